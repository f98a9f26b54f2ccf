"""Many states of one system by their natural variables and parameters, and what is found there.

``Points`` prepares a grid once: which of the names are variables of ``state(...)``, which are parameters, what the
coefficients of friction depend on. ``search`` then runs ``paradox.grid`` over chunks of it, in threads.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from nonsmooth.arrays import as_number, as_vector
from nonsmooth.blocks import Block, new_block
from nonsmooth.compiled import Model, model_of
from nonsmooth.contact_problem import model_facts
from nonsmooth.errors import InvalidInput, UnknownName, nearest, shown
from nonsmooth.jit import CannotCompile, CompiledModel, compile_model, interpreted, load_all
from nonsmooth.laws import LAW_C, LAW_E_F, LAW_E_N, LAW_WIDTH
from nonsmooth.paradox.forces import KEPT, Forces, Outcome, forces_shapes
from nonsmooth.paradox.grid import NATURAL, PARAMETER, VARIABLE, Grid, search_points
from nonsmooth.paradox.state_problem import ENTRY_POINTS, decide_redundant
from nonsmooth.system import System, as_system, parameter_tuple, with_values

CHUNK = 16_384  # points of one call: a few megabytes of results


@dataclass(frozen=True, eq=False)
class Found:
    """Results at N points. c = contacts, k = solutions kept."""

    number: np.ndarray  # (N,) int32
    outcome: np.ndarray  # (N,) int8, of forces.Outcome
    p: np.ndarray  # (N, c)
    b: np.ndarray  # (N, c)
    gamma_F: np.ndarray  # (N, c)
    la_N: np.ndarray  # (N, k, c)
    modes: np.ndarray  # (N, k, c) int8


class Points:
    """A system and the names that vary.

    Parameters
    ----------
    model : System or model
    names : sequence of str
        Variables of ``state(...)`` or parameters; each is set by one axis.
    fixed : mapping
        Values of further ones.
    state : callable, optional
        ``state(**variables) -> (q, u)``; the model's own when left out.

    Raises
    ------
    InvalidInput, UnknownName
        For a name that is neither, and for a parameter that changes more than numbers.
    """

    def __init__(self, model: Any, names: tuple[str, ...], fixed: Mapping[str, float], t: float = 0.0,
                 state: Callable | None = None) -> None:  # fmt: skip
        self.t, self.names = t, names
        self._state = state
        if state is not None and not callable(state):
            raise InvalidInput(f"state must be a function of the variables that returns (q, u); got {shown(state)}")
        function = state or getattr(model, "state", None)
        if function is None:
            raise InvalidInput("a system without state(...) of its own needs state=, a function of the variables")
        self.variables = variables_of(function)
        self.parameters = dict(as_system(model).parameter_values)
        for name in (*names, *fixed):
            if name not in self.variables and name not in self.parameters:
                known = (*self.variables, *self.parameters)
                raise UnknownName(f"there is no variable or parameter {name!r}; {nearest(name, known)}")
        self.fixed = {name: as_number(name, value) for name, value in fixed.items()}
        changes = {name: value for name, value in self.fixed.items() if name not in self.variables}
        self.model = with_values(model, changes)
        self.system = as_system(self.model)
        self.natural = self._compile_natural()

    def default(self, name: str) -> Any:
        """The value of a variable that no axis sets."""
        return self.fixed.get(name, self.variables[name])

    def _compile_natural(self) -> CompiledModel | None:
        """The model's natural state as machine code; None where it has none that can be compiled."""
        function = getattr(self.model, "natural_state", None)
        values = [self.default(name) for name in self.variables]
        if self._state is not None or function is None or not all(isinstance(value, int | float) for value in values):
            return None
        system = self.system
        unpack = parameter_tuple(tuple(system.parameter_values))
        entry: dict[int, tuple[Callable, bool, tuple[int, ...]]] = {
            NATURAL: (function, False, (system.n_q + system.n_u,))
        }
        try:
            return compile_model(entry, len(self.variables), system.n_u, unpack, len(system.p))
        except CannotCompile:
            return None

    def states(self, values: np.ndarray) -> np.ndarray:
        """(m, n_q + n_u) states by the Python function, of the values (m, a) along the names."""
        rows = []
        for point in values:
            given = dict(zip(self.names, point.tolist(), strict=True))
            changes = {name: value for name, value in given.items() if name not in self.variables}
            model = with_values(self.model, changes) if changes and self._state is None else self.model
            state = self._state or model.state
            variables = {name: given.get(name, self.fixed.get(name)) for name in self.variables}
            q, u = state(**{name: value for name, value in variables.items() if value is not None})
            rows.append(np.concatenate([as_vector("q", q, self.system.n_q), as_vector("u", u, self.system.n_u)]))
        return np.array(rows)

    def check(self, axes: list[np.ndarray]) -> None:
        """Let the model judge the ends of each axis, and refuse parameters that change more than numbers."""
        first = {name: float(values[0]) for name, values in zip(self.names, axes, strict=True)} | self.fixed
        variables = {name: value for name, value in first.items() if name in self.variables}
        for name, values in zip(self.names, axes, strict=True):
            for value in (values.min(), values.max()):
                if name in self.variables:
                    (self._state or self.model.state)(**{**variables, name: float(value)})
                    continue
                other = as_system(with_values(self.model, {name: float(value)}))
                if other.functions != self.system.functions or other.contacts != self.system.contacts:
                    raise InvalidInput(f"{name} shapes the system itself; it cannot be an axis of a map")

    def search(self, axes: list[np.ndarray], kept: int, is_list: bool = False, workers: int = 1) -> Found:
        """Solve every point of the grid of the axes; of a list, whose axes have equal lengths, point by point."""
        size = len(axes[0]) if is_list else int(np.prod([len(axis) for axis in axes]))
        n_c = max(1, self.system.n_c)
        found = Found(
            np.zeros(size, np.int32), np.zeros(size, np.int8), np.zeros((size, n_c)), np.zeros((size, n_c)),
            np.zeros((size, n_c)), np.zeros((size, kept, n_c)), np.zeros((size, kept, n_c), np.int8),
        )  # fmt: skip
        model = model_of(self.system)
        if model.is_compiled:
            load_all((*ENTRY_POINTS, search_points))
        workers = workers if model.is_compiled else 1
        starts = range(0, size, CHUNK)
        self._search_chunks(model, axes, starts, is_list, found, workers, False)
        left_open = sorted({int(point) // CHUNK for point in np.flatnonzero(found.outcome == Outcome.SINGULAR)})
        if left_open:
            chunks = [starts[k] for k in left_open]
            self._search_chunks(model, axes, chunks, is_list, found, workers, True)
        return found

    def _search_chunks(self, model: Model, axes: list[np.ndarray], starts: Sequence[int], is_list: bool, found: Found,
                       workers: int, is_redundant: bool) -> None:  # fmt: skip
        """Chunks from the points ``starts``, in threads; with redundant contacts decided if that is asked for."""
        stripes = [starts[k::workers] for k in range(min(workers, len(starts)))]
        with ThreadPoolExecutor(len(stripes)) as pool:
            jobs = [
                pool.submit(self._search_stripe, model, axes, stripe, is_list, found, is_redundant)
                for stripe in stripes
            ]  # fmt: skip
            for job in jobs:
                job.result()

    def _search_stripe(self, model: Model, axes: list[np.ndarray], stripe: Sequence[int], is_list: bool, found: Found,
                       is_redundant: bool) -> None:  # fmt: skip
        """The chunks of one thread: blocks of its own, results into their places."""
        system = self.system
        size, kept, n_c = found.la_N.shape
        forces = new_block(
            Forces, forces_shapes(system.n_u, system.n_c, system.d, max(kept, KEPT if n_c > 1 else kept))
        )
        if is_redundant:
            decide_redundant(forces.arrays, model.is_compiled)
        natural = self.natural.address if self.natural and model.is_compiled else 0
        grid = self._new_grid(axes, min(CHUNK, size), kept, n_c, natural != 0)
        arrays = grid.arrays
        has, kinds = model_facts(system), system.kinds
        run = search_points if model.is_compiled else interpreted(search_points)
        handles = [block.address if model.is_compiled else block.arrays for block in (forces, grid)]
        for first in stripe:
            last = min(first + CHUNK, size)
            if not natural:
                arrays.states[: last - first] = self.states(points_between(axes, first, last, is_list))
            run(model.handle, has, natural, kinds, self.t, first, last, is_list, *handles)
            m = slice(0, last - first)
            found.number[first:last] = arrays.number[m]
            found.outcome[first:last] = arrays.outcome[m]
            found.p[first:last] = arrays.p_s[m]
            found.b[first:last] = arrays.b[m]
            found.gamma_F[first:last] = arrays.gamma_F[m]
            found.la_N[first:last] = arrays.la_N[m].reshape(-1, kept, n_c)
            found.modes[first:last] = arrays.modes[m].reshape(-1, kept, n_c)

    def _new_grid(self, axes: list[np.ndarray], m: int, kept: int, n_c: int, has_natural: bool) -> Block:
        """A block with the axes, the defaults and the laws filled in."""
        system = self.system
        n = system.n_q + system.n_u
        places = list(self.variables), list(system.parameter_values)
        links = law_links(system)
        grid = new_block(Grid, {
            "values": (len(axes), max(len(axis) for axis in axes)), "shape": (len(axes),), "axes": (len(axes), 2),
            "links": (len(links), 3), "laws": (n_c, LAW_WIDTH), "s": (len(self.variables),), "p": (len(system.p),),
            "x": (n,), "q": (system.n_q,), "u": (system.n_u,), "states": (1 if has_natural else m, n),
            "number": (m,), "outcome": (m,), "p_s": (m, n_c), "b": (m, n_c), "gamma_F": (m, n_c),
            "la_N": (m, kept * n_c), "modes": (m, kept * n_c),
        })  # fmt: skip
        arrays = grid.arrays
        for j, (name, axis) in enumerate(zip(self.names, axes, strict=True)):
            arrays.values[j, : len(axis)] = axis
            arrays.shape[j] = len(axis)
            kind = VARIABLE if name in self.variables else PARAMETER
            arrays.axes[j] = kind, places[kind].index(name)
        arrays.links[:] = links
        arrays.laws[: system.n_c] = system.laws
        arrays.p[:] = system.p
        if has_natural:
            arrays.s[:] = [self.default(name) for name in self.variables]
        return grid


def split_axes(axes: Mapping[str, Any]) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """The arrays among the arguments, which are axes, and the numbers, which are held fixed."""
    grid = {
        name: as_vector(name, value) for name, value in axes.items() if isinstance(value, Sequence) or np.ndim(value)
    }
    return grid, {name: value for name, value in axes.items() if name not in grid}


def variables_of(state: Callable) -> dict[str, Any]:
    """The variables of a state function and their defaults."""
    return {
        name: None if parameter.default is inspect.Parameter.empty else parameter.default
        for name, parameter in inspect.signature(state).parameters.items()
    }


def law_links(system: System) -> np.ndarray:
    """(l, 3) contact, column of its row of laws, place of the parameter that the coefficient names."""
    places = list(system.parameter_values)
    links = []
    for i, contact in enumerate(system.contacts):
        named = [(LAW_E_N, contact.e_N), (LAW_E_F, contact.e_F)]
        named += [(LAW_C + j, getattr(contact.law, field.name)) for j, field in enumerate(fields(contact.law))]
        links += [(i, column, places.index(name)) for column, name in named if isinstance(name, str)]
    return np.array(links, dtype=np.int64).reshape(-1, 3)


def points_between(axes: list[np.ndarray], first: int, last: int, is_list: bool) -> np.ndarray:
    """(last - first, a) values at some points of a grid, or of a list."""
    index = np.arange(first, last)
    shape = [len(axis) for axis in axes]
    places = [index] * len(axes) if is_list else np.unravel_index(index, shape)
    return np.column_stack([axis[place] for axis, place in zip(axes, places, strict=True)])
