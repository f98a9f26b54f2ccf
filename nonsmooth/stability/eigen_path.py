"""Eigenvalues along a parameter, each followed as the same mode.

From one value to the next, modes are matched by the assignment that minimises

    sum_i  |s_i - s*_i|/max|s|  +  1 - MAC_i,     MAC = |y^H y*|^2/(|y|^2 |y*|^2)

with s* continued linearly and y = (x, s x) the state vector of the mode. Where two eigenvalues meet (flutter) neither
the frequency nor the shape tells them apart: there the names are a convention. Sources: Kuhn, *Naval Research
Logistics* 2 (1955) 83 (assignment); Allemang and Brown, *Proc. 1st Int. Modal Analysis Conf.* (1982) 110 (MAC).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.arrays import as_name, as_vector
from nonsmooth.errors import InvalidInput
from nonsmooth.stability.equilibrium import Equilibrium, as_equilibrium, equilibrium, follow
from nonsmooth.stability.linearise import Linearisation, Verdict, linearise
from nonsmooth.system import as_system

if TYPE_CHECKING:
    from pathlib import Path


@dataclass(frozen=True, eq=False)
class EigenPath:
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

    def plot(self, path: str | Path | None = None, unit: str = "") -> Any:
        """Growth rates and frequencies against the parameter, and the root locus: see `plot_eigen_path`."""
        from nonsmooth.output.stability_plots import plot_eigen_path

        return plot_eigen_path(self, path, unit)


def eigen_path(system: Any, parameter: str, values: ArrayLike, at: Equilibrium | None = None) -> EigenPath:
    """Follow the eigenvalues of steady sliding along a parameter.

    Parameters
    ----------
    system : System or model
    parameter : str
    values : (n,)
        In increasing or decreasing order.
    at : Equilibrium, optional
        Where to start; its contacts and signs are kept. ``equilibrium`` at the first value when left out.

    Returns
    -------
    EigenPath

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
    >>> from models import ModeCoupling
    >>> path = ns.eigen_path(ModeCoupling(cx=0.0, cz=0.0), "mu", np.linspace(0.0, 0.6, 13))
    >>> [(round(a, 6), round(b, 6), after.name) for a, b, before, after in path.changes]
    [(0.5, 0.55, 'FLUTTER')]
    """
    grid = as_vector("values", values)
    if grid.size == 0 or not (np.all(np.diff(grid) > 0) or np.all(np.diff(grid) < 0)):
        raise InvalidInput("values must be in increasing or in decreasing order, each once, and at least one")
    system = as_system(system)
    as_name("parameter", parameter, system.parameter_values)
    first = {parameter: float(grid[0])}
    at = equilibrium(system.with_parameters(**first)) if at is None else follow(as_equilibrium(at), **first)
    points: list[Linearisation] = []
    for value in grid:
        at = follow(at, **{parameter: float(value)})
        points.append(linearise(at.mode.system, at))
    order = _followed(grid, points)
    return EigenPath(
        parameter, grid,
        np.array([point.eigenvalues[k] for point, k in zip(points, order, strict=True)]),
        np.array([point.mode_shapes[:, k] for point, k in zip(points, order, strict=True)]),
        np.array([point.verdict for point in points]),
        np.array([point.equilibrium.is_virtual for point in points]), tuple(points),
    )  # fmt: skip


def _followed(grid: np.ndarray, points: list[Linearisation]) -> list[np.ndarray]:
    """For each point, which of its eigenvalues belongs to which column."""
    from scipy.optimize import linear_sum_assignment

    order = [np.arange(points[0].eigenvalues.size)]
    for j in range(1, len(points)):
        old, new = points[j - 1], points[j]
        s, k = old.eigenvalues[order[-1]], order[-1]
        expected = s
        if j > 1:
            slope = (s - points[j - 2].eigenvalues[order[-2]]) / (grid[j - 1] - grid[j - 2])
            expected = s + slope * (grid[j] - grid[j - 1])
        distance = np.abs(expected[:, None] - new.eigenvalues[None, :]) / max(np.abs(s).max(), 1e-300)
        cost = distance + 1 - assurance(states(old)[:, k], states(new))
        order.append(linear_sum_assignment(cost)[1])
    return order


def states(point: Linearisation) -> np.ndarray:
    """Columns (x |s|max, s x), coordinates and velocities of each mode in equal weight."""
    x = point.mode_shapes[list(point.kept)]
    return np.concatenate([x * max(np.abs(point.eigenvalues).max(), 1e-300), x * point.eigenvalues])


def assurance(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Modal assurance criterion of each column of a with each of b, in [0, 1]."""
    sizes = np.linalg.norm(a, axis=0)[:, None] * np.linalg.norm(b, axis=0)[None, :]
    return np.abs(a.conj().T @ b) ** 2 / sizes**2
