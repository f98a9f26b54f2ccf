"""From columns of axis values to what the runs of a block start from: parameters, laws, q_0, u_0, without a model per
run.

A model whose ``system()`` hands its own fields on as parameters lets a column of values be written straight into the
parameters; its laws are found once for each combination of the coefficients that vary. What ``model.state(...)`` gives
is found once for each combination of what it reads: its arguments and the fields it was seen to read.
"""

from __future__ import annotations

import copy
import functools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.checks.parameters import numeric_fields, whole_fields
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.laws import law_row
from nonsmooth.mechanics.model_system import as_system, with_values
from nonsmooth.mechanics.start import COMPONENT, CoordinateState, describing, own_state
from nonsmooth.mechanics.system import System
from nonsmooth.sweeps.axis_names import Columns, Parts

Failures = Callable[[np.ndarray, Exception], None]  # takes the numbers of cells and what went wrong in them
ROWS_KEPT = 20_000  # chosen: rules and starts of a model: those of an axis of a grid come back in every batch
AXIS_SAMPLES = 9  # chosen: values of an axis at which a system is built to see what depends on it


@dataclass
class Rows:
    """The runs of some cells of one system shape.

    Attributes
    ----------
    system : System
        Gives functions and kinds of contact.
    cells : (N,) numbers of the cells within the batch
    p : (N, n_p), laws : (N, n_c, LAW_WIDTH), q : (N, n_q), u : (N, n_u)
    """

    system: System
    cells: np.ndarray
    p: np.ndarray
    laws: np.ndarray
    q: np.ndarray
    u: np.ndarray


def combinations(columns: Columns, cells: np.ndarray) -> tuple[list[dict[str, Any]], np.ndarray]:
    """The different rows that some columns have at these cells, and which of them each cell has."""
    if not columns:
        return [{}], np.zeros(len(cells), dtype=np.intp)
    place = np.zeros(len(cells), dtype=np.intp)
    for values in columns.values():
        unique, inverse = np.unique(values[cells], return_inverse=True)
        place = place * len(unique) + inverse
    _, first, inverse = np.unique(place, return_index=True, return_inverse=True)
    chosen = [values[cells[first]].tolist() for values in columns.values()]
    return [dict(zip(columns, row, strict=True)) for row in zip(*chosen, strict=True)], inverse


class RowBuilder:
    """Makes the rows of batches of cells.

    Parameters
    ----------
    model : System or model
    state : mapping
        Arguments of ``model.state`` that stay as they are; or "q0" and "u0".
    """

    def __init__(self, model: Any, state: Mapping[str, Any]) -> None:
        self.model, self.source = model, describing(model)
        self.state = {name: value for name, value in state.items() if not COMPONENT.fullmatch(name)}
        self._entries = {name: value for name, value in state.items() if name not in self.state}
        self._rules = Rules(model)
        self._reads: set[str] = set()  # fields that model.state was seen to read
        self._starts_known: dict[tuple, Any] = {}
        self._is_direct: bool | None = None

    def rows(self, parts: Parts, cells: np.ndarray, fail: Failures) -> Iterator[Rows]:
        """The rows of these cells, those of each system apart; ``fail(cells, error)`` takes those that cannot run."""
        good = cells if isinstance(self.model, System) else self._rules.accepted(parts.fields, cells, fail)
        make = self._direct_rows if self.is_direct(parts.fields) else self._built_rows
        for system, these, p, laws in make(parts.fields, good, fail) if len(good) else ():
            q, u, keep = self._starts(parts, these, (system.n_q, system.n_u), fail)
            if keep.any():
                yield Rows(system, these[keep], p[keep], laws[keep], q, u)

    def is_direct(self, fields: Columns) -> bool:
        """Whether the swept fields reach the system as parameters only."""
        if self._is_direct is None:
            self._is_direct = isinstance(self.model, System) or self._passes_fields_on(fields)
        return self._is_direct

    def _passes_fields_on(self, fields: Columns) -> bool:
        names = set(type(self.model).system.__code__.co_names)
        if names & fields.keys() or whole_fields(self.model) & fields.keys():
            return False
        base = as_system(self.model)
        for name, values in fields.items():
            for value in np.unique(values)[:: max(1, len(values) // AXIS_SAMPLES)]:
                try:
                    system = as_system(with_values(self.model, {name: value.item()}))
                except InvalidInput:
                    continue
                expected = {**base.numbers, name: value.item()}
                if (
                    system.numbers != expected
                    or system.functions != base.functions
                    or system.contacts != base.contacts
                    or not np.array_equal(system.law_numbers, laws_of(base, expected))
                ):
                    return False
        return True

    def _starts(
        self, parts: Parts, cells: np.ndarray, sizes: tuple[int, int], fail: Failures
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """q_0 and u_0 of the cells that have a start, and which these are."""
        while True:
            known = self._reads & parts.fields.keys()
            read = {name: parts.fields[name] for name in sorted(known)}
            rows, place = combinations({**read, **parts.arguments}, cells)
            starts = [self._start(row, known) for row in rows]
            if self._reads & parts.fields.keys() == known:
                break
        n, table = sizes[0], np.full((len(starts), sum(sizes)), np.nan)
        for k, start in enumerate(starts):
            if isinstance(start, Exception):
                fail(cells[place == k], start)
            else:
                table[k] = start
        keep = np.isfinite(table).all(axis=1)[place]
        q, u = np.ascontiguousarray(table[place[keep], :n]), np.ascontiguousarray(table[place[keep], n:])
        for name, value in self._entries.items():
            (q if name[0] == "q" else u)[:, int(name[3:-1])] = value
        for name, values in parts.components.items():
            (q if name[0] == "q" else u)[:, int(name[3:-1])] = values[cells[keep]]
        return q, u, keep

    def _start(self, row: Mapping[str, Any], known: set[str]) -> Any:
        """q_0 and u_0 in one list for a row of fields and arguments, or why there is none; kept for cells to come."""
        key = tuple(row.items())
        start = self._starts_known.get(key)
        if start is None:
            if len(self._starts_known) >= ROWS_KEPT:
                self._starts_known.clear()
            start = self._starts_known[key] = self._new_start(row, known)
        return start

    def _new_start(self, row: Mapping[str, Any], known: set[str]) -> Any:
        given = {name: value for name, value in row.items() if name not in known}
        if own_state(self.source) is None or "q0" in self.state:
            return self._start_by_name(given)
        arguments = {**self.state, **given}
        try:
            model = with_values(self.source, {name: row[name] for name in known})
            q, u = (watched(model, self._reads) if known else self._watched_model).state(**arguments)
        except InvalidInput as error:
            return error
        start = [float(x) for part in (q, u) for x in part]
        if not all(map(math.isfinite, start)):
            return InvalidInput(f"the initial state must be finite; state(...) gave q0 = {q}, u0 = {u}")
        return start

    def _start_by_name(self, given: dict[str, float]) -> Any:
        """Coordinates and rates by name, in addition to those of the pair or the dictionary that was given."""
        pair = (self.state["q0"], self.state["u0"]) if "q0" in self.state else None
        try:
            q, u = CoordinateState(as_system(self.model), pair)(**({} if pair else self.state), **given)
        except InvalidInput as error:
            return error
        return [*q.tolist(), *u.tolist()]

    @functools.cached_property
    def _watched_model(self) -> Any:
        return watched(self.source, self._reads)

    def _direct_rows(self, fields: Columns, cells: np.ndarray, fail: Failures) -> Iterator[tuple]:
        """All cells in one: the columns are written into the parameters."""
        system = as_system(self.model)
        names = list(system.parameter_values)
        p = np.tile(system.p, (len(cells), 1))
        for name, values in fields.items():
            p[:, names.index(name)] = values[cells]
        rows, place = combinations({name: fields[name] for name in law_names(system) & fields.keys()}, cells)
        laws = np.zeros((len(rows), *system.law_numbers.shape))
        is_good = np.ones(len(rows), dtype=bool)
        for k, row in enumerate(rows):
            try:
                laws[k] = laws_of(system, {**system.parameter_values, **row})
            except InvalidInput as error:
                is_good[k] = False
                fail(cells[place == k], error)
        keep = is_good[place]
        yield system, cells[keep], p[keep], laws[place[keep]]

    def _built_rows(self, fields: Columns, cells: np.ndarray, fail: Failures) -> Iterator[tuple]:
        """A system for each combination of the swept fields."""
        rows, place = combinations(fields, cells)
        for k, row in enumerate(rows):
            these = cells[place == k]
            try:
                system = as_system(with_values(self.model, row))
            except InvalidInput as error:
                fail(these, error)
                continue
            yield system, these, np.tile(system.p, (len(these), 1)), np.tile(system.law_numbers, (len(these), 1, 1))


class Rules:
    """What a model asks of its fields; what it said of a row of values is kept, since rows come back in every batch.

    Parameters
    ----------
    model : System or model
    """

    def __init__(self, model: Any) -> None:
        self.model = model
        self._accepted: set[tuple] = set()

    def accepted(self, fields: Columns, cells: np.ndarray, fail: Failures) -> np.ndarray:
        """The cells whose model can be built; ``fail(cells, error)`` takes the others."""
        if len(fields) == 1:  # a sort is four times as fast as one that remembers where each value came from
            (values,) = fields.values()
            if self._accepted.issuperset(zip(np.unique(values[cells]).tolist(), strict=True)):
                return cells
        rows, place = combinations(fields, cells)
        is_good = np.ones(len(rows), dtype=bool)
        check = check_of(self.model, set(fields))
        for k, row in enumerate(rows):
            if tuple(row.values()) in self._accepted:
                continue
            try:
                check(row)
                self._accepted.add(tuple(row.values()))
            except InvalidInput as error:
                is_good[k] = False
                fail(cells[place == k], error)
        if len(self._accepted) > ROWS_KEPT:
            self._accepted.clear()
        return cells[is_good[place]]


def check_of(model: Any, names: set[str]) -> Callable[[Mapping[str, Any]], Any]:
    """A function that raises for a row of new values of some fields that the model refuses.

    It is the model's own ``__post_init__`` on one copy whose fields are written over: a new model costs ten times as
    much. Where whole fields vary, or a model has no such copy, it is the new model.
    """
    is_plain = isinstance(model, System) or not hasattr(model, "__post_init__") or not hasattr(model, "__dict__")
    if is_plain or names & whole_fields(model):
        return functools.partial(with_values, model)
    twin = copy.copy(model)

    def check(row: Mapping[str, Any]) -> None:
        vars(twin).update(row)
        twin.__post_init__()

    return check


def laws_of(system: System, values: Mapping[str, float]) -> np.ndarray:
    """(n_c, LAW_WIDTH) laws of the contacts for other parameters."""
    rows = [
        law_row(contact.law, contact.e_N, contact.e_F, contact.law_of_impact, values) for contact in system.contacts
    ]
    return np.array(rows).reshape(system.law_numbers.shape)


def law_names(system: System) -> set[str]:
    """The parameters that stand in friction laws and restitution coefficients."""
    coefficients: list[Any] = []
    for contact in system.contacts:
        coefficients += [contact.e_N, contact.e_F, *vars(contact.law).values()]
    return {name for name in coefficients if isinstance(name, str)}


def watched(model: Any, reads: set[str]) -> Any:
    """A copy of a model that notes which of its fields are read; of a tuple, which cannot note it, all are."""
    if isinstance(model, tuple):
        reads.update(numeric_fields(model))
        return model
    twin = copy.copy(model)
    object.__setattr__(twin, "_reads", reads)
    cls: Any = type(model)
    object.__setattr__(twin, "__class__", _watched_class(cls))
    return twin


@functools.cache
def _watched_class(cls: type) -> type:
    fields = frozenset(getattr(cls, "__dataclass_fields__", ()))

    class Watched(cls):  # type: ignore[misc,valid-type]
        def __getattribute__(self, name: str) -> Any:
            if name in fields:
                object.__getattribute__(self, "_reads").add(name)
            return object.__getattribute__(self, name)

    return Watched
