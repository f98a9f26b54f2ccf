"""Many states of one system by their natural variables and parameters, and what is found there.

``Points`` prepares the names once: which of them are variables of ``state(...)``, which are parameters, what the
coefficients of friction depend on. ``search`` then runs ``paradox.search`` over columns of values.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_number, as_vector, is_number, result_of
from nonsmooth.contact.planar.forces import FORCES_KEPT, Outcome
from nonsmooth.errors import InvalidInput, UnknownName, nearest, shown
from nonsmooth.jit import CannotCompile, interpreted, load_all
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.compiled import Model, Shelf, model_of
from nonsmooth.mechanics.contact_problem import model_facts
from nonsmooth.mechanics.inspection import inspect_instant
from nonsmooth.mechanics.laws import LAW_C, LAW_E_F, LAW_E_N
from nonsmooth.mechanics.model_system import as_system, with_values
from nonsmooth.mechanics.start import (
    CoordinateState,
    describing,
    forms_of,
    own_state,
    split_state,
    start_of,
    state_function,
    variables_of,
)
from nonsmooth.mechanics.sys import new_sys
from nonsmooth.mechanics.system import System
from nonsmooth.paradox.search import NATURAL, PARAMETER, VARIABLE, Table, search_points
from nonsmooth.paradox.state_problem import decide_redundant, entry_points, new_forces
from nonsmooth.scenes.given import as_model


@dataclass(frozen=True, eq=False)
class Found:
    """Results at N points. c = contacts, k = solutions kept."""

    number: np.ndarray  # (N,)
    outcome: np.ndarray  # (N,) of forces.Outcome
    p: np.ndarray  # (N, c)
    b: np.ndarray  # (N, c)
    gamma_F: np.ndarray  # (N, c)
    la_N: np.ndarray  # (N, k, c)
    modes: np.ndarray  # (N, k, c)


class Points:
    """A system and the names that vary.

    Parameters
    ----------
    model : System or model
    names : sequence of str
        Variables of ``state(...)`` or parameters; each is set by one axis.
    fixed : mapping
        Values of further ones.
    state : callable, dict or (q0, u0), optional
        ``state(**variables) -> (q, u)``, the model's own when left out; variables held fixed; a state of which
        coordinates and rates are varied by name.

    Raises
    ------
    InvalidInput, UnknownName
        For a name that is neither, and for a parameter that changes more than numbers.
    """

    def __init__(self, model: Any, names: tuple[str, ...], fixed: Mapping[str, float], t: float = 0.0,
                 state: Any = None) -> None:  # fmt: skip
        model = as_model(model)
        state, fixed = held_fixed(model, state, fixed)
        self.t, self.names = t, names
        function = as_state_function(model, state)
        self._state = None if own_state(model) is function or state is None else function
        self.variables = variables_of(function)
        self.parameters = dict(as_system(model).parameter_values)
        for name in (*names, *fixed):
            if name not in self.variables and name not in self.parameters:
                known = (*self.variables, *self.parameters)
                raise UnknownName(f"there is no variable or parameter {name!r}; {nearest(name, known)}")
            if name in self.variables and name in self.parameters:
                raise InvalidInput(
                    f"{name!r} has two meanings, a parameter and a variable of state(...): rename one of them, or give "
                    "state=, a function with other names"
                )
        self.fixed = {name: as_number(name, value) for name, value in fixed.items()}
        changes = {name: value for name, value in self.fixed.items() if name not in self.variables}
        self.model = with_values(model, changes)
        self.system = as_system(self.model)
        self._natural = self._shelf_of_natural()
        self._is_inspected = False

    def default(self, name: str) -> Any:
        """The value of a variable that no axis sets."""
        return self.fixed.get(name, self.variables[name])

    @property
    def natural(self) -> Model | None:
        """The model's natural state as machine code; None where it has none that can be compiled."""
        try:
            return None if self._natural is None else self._natural.model()
        except CannotCompile:
            return None

    def _shelf_of_natural(self) -> Shelf | None:
        function = getattr(describing(self.model), "natural_state", None)
        values = [self.default(name) for name in self.variables]
        if self._state is not None or function is None or not all(isinstance(value, int | float) for value in values):
            return None
        system = self.system
        entry = {NATURAL: (function, False, (system.n_q + system.n_u,))}
        return Shelf(entry, len(self.variables), system.n_u, system.unpack, len(system.p))

    def state_at(self, values: tuple[float, ...]) -> np.ndarray:
        """(n_q + n_u,) the state by the Python function, of a value for each name."""
        given = dict(zip(self.names, values, strict=True))
        changes = {name: value for name, value in given.items() if name not in self.variables}
        model = with_values(self.model, changes) if changes and self._state is None else self.model
        state = state_function(model) if self._state is None else self._state
        variables = {name: given.get(name, self.fixed.get(name)) for name in self.variables}
        q, u = as_pair(result_of("state", state, **{name: x for name, x in variables.items() if x is not None}))
        return np.concatenate([as_vector("q", q, self.system.n_q), as_vector("u", u, self.system.n_u)])

    def check(self, axes: list[np.ndarray]) -> None:
        """Let the model judge the ends of each axis, and refuse parameters that change more than numbers."""
        first = {name: float(values[0]) for name, values in zip(self.names, axes, strict=True)} | self.fixed
        variables = {name: value for name, value in first.items() if name in self.variables}
        for name, values in zip(self.names, axes, strict=True):
            for value in (values.min(), values.max()):
                if name in self.variables:
                    state = state_function(self.model) if self._state is None else self._state
                    result_of("state", state, **{**variables, name: float(value)})
                    continue
                other = as_system(with_values(self.model, {name: float(value)}))
                if other.functions != self.system.functions or other.contacts != self.system.contacts:
                    raise InvalidInput(f"{name} shapes the system itself; it cannot be an axis of a map")

    def search(self, columns: list[np.ndarray], kept: int, states: np.ndarray | None = None) -> Found:
        """The forces at N points.

        Parameters
        ----------
        columns : list of (N,) arrays
            The value of each name at every point.
        kept : int
            Solutions written out at each.
        states : ndarray (N, n_q + n_u), optional
            Where there is no compiled natural state; found by `state_at` when left out.
        """
        model = model_of(self.system)
        load_search(self.system, model)
        self._inspect(columns, states)
        has_natural = self.natural is not None and model.is_compiled
        if not has_natural and states is None:
            states = np.array([self.state_at(values) for values in zip(*map(np.ndarray.tolist, columns), strict=True)])
        found = self._search(model, columns, kept, states, False)
        left_open = np.flatnonzero(found.outcome == Outcome.SINGULAR)
        if len(left_open):
            some = None if states is None else states[left_open]
            again = self._search(model, [values[left_open] for values in columns], kept, some, True)
            for name, values in vars(again).items():
                getattr(found, name)[left_open] = values
        return found

    def _inspect(self, columns: list[np.ndarray], states: np.ndarray | None) -> None:
        """Try the functions at the first point, and hold them against one another."""
        if self._is_inspected:
            return
        values = tuple(column[0].item() for column in columns)
        try:
            x = self.state_at(values) if states is None else states[0]
        except InvalidInput:  # no state of the model: nothing is searched there
            return
        given = dict(zip(self.names, values, strict=True))
        changes = {name: value for name, value in given.items() if name not in self.variables}
        inspect_instant(as_system(with_values(self.model, changes)), self.t, x[: self.system.n_q], x[self.system.n_q :])
        self._is_inspected = True

    def _search(
        self, model: Model, columns: list[np.ndarray], kept: int, states: np.ndarray | None, is_redundant: bool
    ) -> Found:
        """One call; with redundant contacts decided if that is asked for."""
        system = self.system
        n_c = max(1, system.n_c)
        room = kept if n_c == 1 else max(kept, FORCES_KEPT)
        forces = new_forces(system, kept=room)
        if is_redundant:
            decide_redundant(forces, model.is_compiled)
        compiled = self.natural if states is None else None
        natural = compiled.handle if compiled is not None else 0
        table = self._new_table(columns, states, kept)
        run = search_points if model.is_compiled else interpreted(search_points)
        blocks = (new_sys(system, model.handle, model_facts(system)), forces, table)
        sys, *handles = (block.address if model.is_compiled else block for block in blocks)
        run(sys, natural, self.t, *handles)
        return Found(
            table.number, table.outcome, table.p_s, table.b, table.gamma_F,
            table.la_N.reshape(-1, kept, n_c), table.modes.reshape(-1, kept, n_c),
        )  # fmt: skip

    def _new_table(self, columns: list[np.ndarray], states: np.ndarray | None, kept: int) -> Table:
        """A block with the values and the defaults filled in."""
        system = self.system
        m, n_c = len(columns[0]), max(1, system.n_c)
        places = list(self.variables), list(system.parameter_values)
        links = law_links(system)
        table = new(
            Table, a=len(columns), m=m, l=len(links), c=n_c, k=kept, n_s=len(self.variables),
            n_q=system.n_q, n_u=system.n_u, n_states=1 if states is None else m,
        )  # fmt: skip
        for j, (name, values) in enumerate(zip(self.names, columns, strict=True)):
            table.values[j] = values
            kind = VARIABLE if name in self.variables else PARAMETER
            table.names[j] = kind, places[kind].index(name)
        table.links[:], table.d = links, system.d
        if states is None:
            table.s[:] = [self.default(name) for name in self.variables]
        else:
            table.states[:] = states
        return table


def load_search(system: System, model: Model) -> None:
    """Compile what the search calls."""
    if model.is_compiled:
        load_all((*entry_points(system), search_points))


def split_axes(axes: Mapping[str, Any]) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """The arrays among the arguments, which are axes, and the numbers, which are held fixed."""
    grid = {name: as_vector(name, value) for name, value in axes.items() if not is_number(name, value)}
    return grid, {name: value for name, value in axes.items() if name not in grid}


def held_fixed(model: Any, state: Any, fixed: Mapping[str, float]) -> tuple[Any, Mapping[str, float]]:
    """The variables of a state that was given by name join those held fixed; entries of it make a pair."""
    if callable(getattr(state, "state", None)):
        return start_of(model, state), fixed
    if not isinstance(state, Mapping):
        return state, fixed
    whole, entries, variables = split_state(model, state)
    return (start_of(model, state), fixed) if whole or entries else (None, {**variables, **fixed})


def as_state_function(model: Any, state: Any) -> Callable:
    """The function of the variables of a state: the one given, that of a pair (q0, u0), or the model's."""
    if state is None:
        return state_function(model)
    if isinstance(state, tuple | list):
        return CoordinateState(as_system(model), state)
    if not callable(state) or isinstance(state, type):
        raise InvalidInput(
            f"state must be {forms_of(model)}, or a function of the variables that returns (q, u); got {shown(state)}"
        )
    return state


def as_pair(state: Any) -> tuple[Any, Any]:
    """q and u as a state function returns them."""
    if not isinstance(state, tuple | list) or len(state) != 2:
        raise InvalidInput(f"state must return a pair (q, u); it returned {shown(state)}")
    return state[0], state[1]


def law_links(system: System) -> np.ndarray:
    """(l, 3) contact, column of its row of laws, place of the parameter that the coefficient names."""
    places = list(system.parameter_values)
    links = []
    for i, contact in enumerate(system.contacts):
        named = [(LAW_E_N, contact.e_N), (LAW_E_F, contact.e_F)]
        named += [(LAW_C + j, getattr(contact.law, field.name)) for j, field in enumerate(fields(contact.law))]
        links += [(i, column, places.index(name)) for column, name in named if isinstance(name, str)]
    return np.array(links, dtype=np.int64).reshape(-1, 3)
