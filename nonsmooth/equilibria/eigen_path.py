"""Eigenvalues along a parameter, each followed as the same mode.

From one value to the next, modes are matched by the assignment that minimises

    sum_i c_ii,    c_ij = |s_i - s*_j|/max|s|  +  1 - MAC_ij,     MAC_ij = |y_i^H y*_j|^2/(|y_i|^2 |y*_j|^2)

with y = (x, s x) the state vector of the mode. Where a match is not clear, c_ii > CLEAR_MATCH min_j c_ij, the way
between the two values is halved and each half is followed: frequencies that cross are told apart by their shapes, and
eigenvalues that pass near one another by their places. At a branch point, where two meet and part, neither tells; there
the names are a convention that does not depend on the values chosen: of a pair that becomes real the larger one keeps
the column with Im s > 0, of two that become a pair the larger one gets it, pairs stay pairs of columns, and of two
pairs that meet on the imaginary axis and leave it to both sides the growing one gets the column that stands first.
Sources:
Kuhn, *Naval Research Logistics* 2 (1955) 83 (assignment); Allemang and Brown, *Proc. 1st Int. Modal Analysis Conf.*
(1982) 110 (MAC).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_name, as_vector
from nonsmooth.equilibria.equilibrium import Equilibrium, as_equilibrium, equilibrium, follow_equilibrium
from nonsmooth.equilibria.flutter_boundary import StabilityBoundary, flutter_boundary
from nonsmooth.equilibria.linearise import Linearisation, Verdict, linearise
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.model_system import as_rated
from nonsmooth.scenes.given import as_model
from nonsmooth.signals.telling import tell
from nonsmooth.views import Worded, view

if TYPE_CHECKING:
    from pathlib import Path

CLEAR_MATCH = 0.3  # chosen: of the next best match: a better one is believed
TIE = 1e-6  # chosen: difference of two costs, of order one, that rounding may have made at a branch point
BRANCH_HALVINGS = 12  # derived: of the way between two values: a branch point is passed within 1/4000 of it
SMALLEST_EIGENVALUE = 1e-300  # chosen: stands for zero where it divides


@dataclass(frozen=True, eq=False, repr=False)
class EigenPath(Worded):
    """Eigenvalues of steady sliding along a parameter.

    Attributes
    ----------
    parameter : str
    values : ndarray (n,)
    eigenvalues : ndarray (n, 2 n_r)
        s [1/s]; a column is a mode.
    mode_shapes : ndarray (n, n_q, 2 n_r)
    verdicts : ndarray (n,) of Verdict
    is_virtual : ndarray (n,) of bool
    points : tuple of Linearisation
    """

    parameter: str
    values: np.ndarray
    eigenvalues: np.ndarray
    mode_shapes: np.ndarray
    verdicts: np.ndarray
    is_virtual: np.ndarray
    points: tuple[Linearisation, ...]

    @property
    def growth(self) -> np.ndarray:
        """max Re s (n,) [1/s]."""
        return self.eigenvalues.real.max(axis=1)

    @property
    def changes(self) -> list[tuple[float, float, Verdict, Verdict]]:
        """(value before, value after, verdict before, verdict after) wherever the verdict changes."""
        k = np.flatnonzero(np.diff(self.verdicts))
        return [
            (float(self.values[i]), float(self.values[i + 1]), Verdict(self.verdicts[i]), Verdict(self.verdicts[i + 1]))
            for i in k
        ]

    def boundary(self, before: float, after: float) -> StabilityBoundary | None:
        """Where stability is lost or regained between two of the values, solved to rounding; None where both are stable
        or both unstable, or nothing is found."""
        k, j = (int(np.argmin(np.abs(self.values - value))) for value in (before, after))
        if (self.verdicts[k] > Verdict.MARGINAL) == (self.verdicts[j] > Verdict.MARGINAL):
            return None
        at = self.points[k].equilibrium
        try:
            return flutter_boundary(at.mode.system, self.parameter, (before, after), at)
        except InvalidInput:
            return None

    def plot(self, path: str | Path | None = None, unit: str = "") -> Any:
        """Growth rates and frequencies against the parameter, and the root locus: see `plot_eigen_path`."""
        return view(self, "plot")(self, path, unit)


def eigen_path(system: Any, parameter: str, values: ArrayLike, at: Equilibrium | None = None) -> EigenPath:
    """Follow the eigenvalues of steady sliding along a parameter.

    Parameters
    ----------
    system : System, model, or Scene
    parameter : str
    values : (n,)
        In increasing or decreasing order.
    at : Equilibrium, optional
        Where to start; its contacts and signs are kept. ``equilibrium`` at the first value when left out.

    Returns
    -------
    EigenPath
        After Ctrl-C up to the value that was reached: its ``values`` are fewer then.

    Raises
    ------
    InvalidInput
        When the values are not in order, or no equilibrium is found at one of them.
    UnknownName
        When there is no such parameter.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import ModeCoupling
    >>> path = ns.eigen_path(ModeCoupling(cx=0.0, cz=0.0), "mu", np.linspace(0.0, 0.6, 13))
    >>> [(round(a, 6), round(b, 6), after.name) for a, b, before, after in path.changes]
    [(0.5, 0.55, 'FLUTTER')]
    """
    grid = as_vector("values", values)
    if grid.size == 0 or not (np.all(np.diff(grid) > 0) or np.all(np.diff(grid) < 0)):
        raise InvalidInput("values must be in increasing or in decreasing order, each once, and at least one")
    system = as_rated(as_model(system), "eigen_path")
    as_name("parameter", parameter, system.parameter_values)
    first = {parameter: float(grid[0])}
    at = equilibrium(system.with_parameters(**first)) if at is None else follow_equilibrium(as_equilibrium(at), **first)
    points: list[Linearisation] = []
    order: list[np.ndarray] = []
    try:
        for value in grid:
            at = follow_equilibrium(at, **{parameter: float(value)})
            points.append(linearise(at.mode.system, at))
            order.append(next_columns(grid, points, order, lambda near, value: _between(near, parameter, value)))
            tell(len(order) / grid.size)
    except KeyboardInterrupt:
        if not order:
            raise
    grid, points = grid[: len(order)], points[: len(order)]
    return EigenPath(
        parameter, grid,
        np.array([point.eigenvalues[k] for point, k in zip(points, order, strict=True)]),
        np.array([point.mode_shapes[:, k] for point, k in zip(points, order, strict=True)]),
        np.array([point.verdict for point in points]),
        np.array([point.equilibrium.is_virtual for point in points]), tuple(points),
    )  # fmt: skip


def _between(near: Linearisation, parameter: str, value: float) -> Linearisation | None:
    """The linearisation at a value between two; None where no equilibrium is found."""
    try:
        at = follow_equilibrium(near.equilibrium, **{parameter: value})
        return linearise(at.mode.system, at)
    except InvalidInput:
        return None


def next_columns(
    grid: np.ndarray, points: Sequence[Any], order: Sequence[np.ndarray], at: Callable[[Any, float], Any]
) -> np.ndarray:
    """Which eigenvalue of the last point belongs to which column; ``at(near, value)`` gives points between."""
    j = len(order)
    if j == 0:
        return np.arange(points[0].eigenvalues.size)
    return carried(order[-1], (float(grid[j - 1]), points[j - 1]), (float(grid[j]), points[j]), at, BRANCH_HALVINGS)


def carried(
    columns: np.ndarray, start: tuple[float, Any], end: tuple[float, Any], at: Callable[[Any, float], Any], depth: int
) -> np.ndarray:
    """The eigenvalues at the end that belong to the columns of those at the start."""
    from scipy.optimize import linear_sum_assignment

    (a, old), (b, new) = start, end
    s = old.eigenvalues[columns]
    cost = np.abs(s[:, None] - new.eigenvalues[None, :]) / max(np.abs(s).max(), SMALLEST_EIGENVALUE)
    cost += 1 - assurance(states(old)[:, columns], states(new))
    chosen = linear_sum_assignment(cost)[1]
    if depth > 0 and not is_clear(cost, chosen):
        middle = 0.5 * (a + b)
        between = at(old, middle)
        if between is not None:
            half = carried(columns, start, (middle, between), at, depth - 1)
            return carried(half, (middle, between), end, at, depth - 1)
    return by_convention(s, new.eigenvalues, untied(s, new.eigenvalues, cost, chosen))


def is_clear(cost: np.ndarray, chosen: np.ndarray) -> bool:
    """Whether each match is much better than every other for its column."""
    if len(chosen) < 2:
        return True
    rows = np.arange(len(chosen))
    others = cost.copy()
    others[rows, chosen] = np.inf
    return bool((cost[rows, chosen] <= CLEAR_MATCH * others.min(axis=1)).all())


def untied(s: np.ndarray, new: np.ndarray, cost: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """The match in which of two oscillations that could as well be exchanged the first one has the larger growth."""
    chosen = chosen.copy()
    least = TIE * np.abs(new).max()
    for a, b in itertools.combinations(np.flatnonzero(s.imag > 0).tolist(), 2):
        x, y = chosen[[a, b]]
        gain = cost[a, x] + cost[b, y] - cost[a, y] - cost[b, x]
        if abs(gain) < TIE and new[y].real - new[x].real > least:
            chosen[[a, b]] = y, x
    return chosen


def by_convention(s: np.ndarray, new: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """The match in which conjugate columns stay so, and the larger of two real ones has the column with Im s > 0."""
    chosen = chosen.copy()
    place = {int(k): column for column, k in enumerate(chosen)}

    def exchange(one: int, other: int) -> None:
        chosen[[one, other]] = chosen[[other, one]]
        place[int(chosen[one])], place[int(chosen[other])] = one, other

    for column in np.flatnonzero(s.imag > 0).tolist():
        partner = int(np.abs(s - s[column].conj()).argmin())
        x, y = new[chosen[column]], new[chosen[partner]]
        if x.imag == 0 and y.imag == 0:
            if x.real < y.real:
                exchange(column, partner)
        elif x.imag != 0:
            exchange(partner, place[int(np.abs(new - x.conj()).argmin())])
            if x.imag < 0:
                exchange(column, partner)
    for column in np.flatnonzero(s.imag == 0).tolist():
        x = new[chosen[column]]
        if x.imag > 0:
            other = place[int(np.abs(new - x.conj()).argmin())]
            if s[other].imag == 0 and s[other].real > s[column].real:
                exchange(column, other)
    return chosen


def states(point: Linearisation) -> np.ndarray:
    """Columns (x |s|max, s x), coordinates and velocities of each mode in equal weight."""
    x = point.mode_shapes[list(point.kept)]
    return np.concatenate([x * max(np.abs(point.eigenvalues).max(), SMALLEST_EIGENVALUE), x * point.eigenvalues])


def assurance(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Modal assurance criterion of each column of a with each of b, in [0, 1]."""
    sizes = np.linalg.norm(a, axis=0)[:, None] * np.linalg.norm(b, axis=0)[None, :]
    return np.abs(a.conj().T @ b) ** 2 / sizes**2
