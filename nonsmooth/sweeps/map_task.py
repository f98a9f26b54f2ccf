"""The task of a sweep over single states: which contact forces each has. A map of paradoxes with journal and workers.

The search is compiled, a batch of states in one call (paradox/points.py).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_count, as_number
from nonsmooth.contact.planar.forces import Outcome
from nonsmooth.errors import InvalidInput
from nonsmooth.jit import identity
from nonsmooth.mechanics.compiled import model_of
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.start import describing, own_state
from nonsmooth.paradox.kinds import ParadoxKind
from nonsmooth.paradox.points import Found, Points, as_state_function, held_fixed, load_search
from nonsmooth.scenes.given import as_model
from nonsmooth.signals.interruption import Pieces
from nonsmooth.signals.telling import tell
from nonsmooth.sweeps.axis_names import Columns, unit_of
from nonsmooth.sweeps.run_rows import Rules
from nonsmooth.sweeps.task import Batch, CellStatus, Variable, as_slice, identity_of_model

KEPT_OF_ONE, KEPT_OF_SEVERAL = 3, 8  # chosen: solutions written out by default


class MapTask:
    """States of a model, and the contact forces that each admits.

    Parameters
    ----------
    model : System or model
    t : float
        Time [s].
    state : callable, dict or (q0, u0), optional
        ``state(**variables) -> (q, u)`` in place of the model's; variables that are held fixed; or a state whose
        coordinates and rates are then varied by name.
    kept : int, optional
        Solutions written out for each state (3 for one contact, else 8); all of them are counted.
    **fixed : float
        Variables of ``state(...)`` and parameters that no axis varies.

    Raises
    ------
    InvalidInput
        For a system without contacts.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import PainleveRod
    >>> found = ns.sweep(ns.MapTask(PainleveRod(), th=1.0472, slip=-1.0), {"mu": [0.5, 2.0], "thdot": [0.0, 6.0]})
    >>> found.n_solutions.values.tolist()
    [[1.0, 1.0], [0.0, 2.0]]
    """

    holds_interpreter = False
    coordinates: dict[str, list[str]] = {}

    def __init__(
        self, model: Any, *, t: float = 0.0, state: Any = None, kept: int | None = None, **fixed: float
    ) -> None:
        model = as_model(model)
        state, given = held_fixed(model, state, fixed)
        fixed = dict(given)
        self.model, self.t, self.state, self.fixed = model, as_number("t", t, "s"), state, fixed
        if state is not None:
            as_state_function(model, state)
        n_c = as_system(model).n_c
        if n_c == 0:
            raise InvalidInput("a map needs a system with contacts; this one has none")
        self.is_one = n_c == 1
        self.kept = (KEPT_OF_ONE if self.is_one else KEPT_OF_SEVERAL) if kept is None else as_count("kept", kept)
        self._points: dict[tuple[str, ...], Points] = {}
        self._rules = Rules(model)
        self._pieces = Pieces()

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_points": {}, "_rules": Rules(self.model)}

    @property
    def variables(self) -> dict[str, Variable]:
        """The results."""
        contact = () if self.is_one else ("contact",)
        return {
            "n_solutions": Variable(meaning="number of solutions"),
            "kind": Variable(meaning="kind of paradox, a ParadoxKind"),
            "p": Variable(contact, "1/kg", "least p of the slides admitted"),
            "b": Variable(contact, "m/s^2", "free normal acceleration"),
            "gamma_F": Variable(contact, "m/s", "sliding velocity"),
            "la_N": Variable(("solution", *contact), "N", "normal force"),
            "modes": Variable(("solution", *contact), meaning="mode of contact"),
        }

    def unit(self, name: str) -> str:
        """Unit of an axis that is a coordinate or its rate."""
        return unit_of(as_system(self.model), name)

    def check(self, names: tuple[str, ...]) -> None:
        """Raise for an axis that is neither a variable of the state nor a parameter."""
        self.points(names)

    def points(self, names: tuple[str, ...]) -> Points:
        """The names of some axes, prepared."""
        if names not in self._points:
            self._points[names] = Points(self.model, names, self.fixed, self.t, self.state)
        return self._points[names]

    def identity(self) -> str:
        """Model, parameters, fixed variables, and the code of the model's functions."""
        state = own_state(self.model) if self.state is None else self.state
        code = identity_of_model(self.model, state, getattr(describing(self.model), "natural_state", None))
        pair = [np.asarray(part).tolist() for part in state] if isinstance(state, tuple | list) else []
        return f"{code}\n{identity((self.t, self.kept, sorted(self.fixed.items()), pair)).hex()}"

    def load(self) -> None:
        """Compile the search."""
        system = as_system(self.model)
        load_search(system, model_of(system))

    def __call__(self, columns: Columns) -> Batch:
        """Search the states of a batch."""
        points = self.points(tuple(columns))
        N = len(next(iter(columns.values())))
        result = Batch({}, np.full(N, int(CellStatus.FINISHED)))

        def fail(cells: np.ndarray, error: Exception) -> None:
            result.status[cells] = CellStatus.FAILED
            result.messages.update(dict.fromkeys(cells.tolist(), str(error)))

        fields = {name: values for name, values in columns.items() if name not in points.variables}
        cells = self._rules.accepted(fields, np.arange(N), fail)
        states = None
        if points.natural is None:
            cells, states = states_of(points, columns, cells, fail)
        for piece in self._pieces.of(len(cells)):
            place = as_slice(cells[piece])
            some = None if states is None else states[piece]
            found = points.search([values[place].astype(float) for values in columns.values()], self.kept, some)
            result.status[cells[piece][found.outcome == Outcome.NOT_FINITE]] = CellStatus.NOT_FINITE
            for name, values in self._values(found).items():
                result.put(name, place, values)
            tell(piece.stop / len(cells))
        return result

    def _values(self, found: Found) -> Mapping[str, np.ndarray]:
        values = {"n_solutions": found.number, "kind": kinds_of(found)}
        for name in ("p", "b", "gamma_F", "la_N", "modes"):
            column = getattr(found, name)
            values[name] = column[..., 0] if self.is_one else column
        return values


def states_of(points: Points, columns: Columns, cells: np.ndarray, fail: Callable) -> tuple[np.ndarray, np.ndarray]:
    """The cells that have a state by the model's Python function, and these states."""
    kept, states = [], []
    for cell in cells.tolist():
        try:
            states.append(points.state_at(tuple(values[cell].item() for values in columns.values())))
            kept.append(cell)
        except InvalidInput as error:
            fail(np.array([cell]), error)
    return np.array(kept, dtype=np.intp), np.array(states)


def kinds_of(found: Found) -> np.ndarray:
    """`ParadoxKind` of each point."""
    kind = np.minimum(found.number, 2)  # INCONSISTENT, REGULAR, INDETERMINATE
    kind = np.where(found.outcome == Outcome.TOO_MANY, ParadoxKind.NOT_ENUMERATED, kind)
    is_no_problem = (found.outcome == Outcome.INADMISSIBLE) | (found.outcome == Outcome.NOT_FINITE)
    return np.where(is_no_problem, ParadoxKind.INADMISSIBLE, kind)
