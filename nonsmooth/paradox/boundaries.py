"""The curves that bound regions of paradoxes: zeros of p, b and gamma_F in a plane of two names, and where they cross.

The number of solutions changes only across p = 0, b = 0 and gamma_F = 0. Contour lines of a grid give each curve as a
polyline whose points lie on the edges of the grid; every point is then moved along its edge to the zero of the field by
bisection, and a crossing of two polylines to the common zero by Newton's method. p = b = 0 is the point of Génot and
Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.checks.arrays import as_number
from nonsmooth.errors import InvalidInput, MissingExtra
from nonsmooth.paradox.points import Points, split_axes
from nonsmooth.signals.interruption import Pieces
from nonsmooth.views import Worded

if TYPE_CHECKING:
    from collections.abc import Callable

FIELDS = ("p", "b", "gamma_F")
EDGE_HALVINGS = 60  # derived: of an edge: to the last place
PLANE_INCREMENT = 1e-6  # chosen: of the plane's extent, for Newton's method
NEWTON_STEPS = 12  # chosen: of the search for a boundary, which bisection has bracketed
REACHED = 1e-11  # chosen: of the plane's extent: a crossing moves less than this


@dataclass(frozen=True, eq=False, repr=False)
class Boundaries(Worded):
    """Zero curves in the plane of two names.

    Attributes
    ----------
    names : (str, str)
    p, b, gamma_F : list of ndarray (n, 2)
        Polylines with p = 0, b = 0 and gamma_F = 0.
    crossings : dict
        ``("p", "b")`` and so on: (n, 2) points where two of them meet.
    """

    names: tuple[str, str]
    p: list[np.ndarray]
    b: list[np.ndarray]
    gamma_F: list[np.ndarray]
    crossings: dict[tuple[str, str], np.ndarray]


def paradox_boundaries(system: Any, *, contact: int | str = 0, t: float = 0.0,
                       state: Callable[..., Any] | None = None, **axes: Any) -> Boundaries:  # fmt: skip
    """The zero curves of p, b and gamma_F over two axes.

    Parameters
    ----------
    system, t, state
        As in `paradox_map`.
    contact : int
    **axes : float or array-like
        Exactly two arrays, the axes of the plane, increasing; numbers are held fixed.

    Returns
    -------
    Boundaries
        Points on the curves, good to rounding where the grid resolves them.

    Raises
    ------
    InvalidInput
        Unless two axes are given.
    MissingExtra
        When contourpy (of Matplotlib) is not installed.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import PainleveRod
    >>> curves = ns.paradox_boundaries(PainleveRod(mu=2.0), th=np.linspace(0.1, 1.5, 40), thdot=np.linspace(0, 9, 40))
    >>> [round(float(np.degrees(curve[0, 0])), 4) for curve in curves.p]
    [37.3774, 79.1877]
    """
    try:
        from contourpy import contour_generator
    except ImportError:
        raise MissingExtra('boundaries need contourpy; pip install "nonsmooth[map]" brings it') from None
    plane, fixed = split_axes(axes)
    if len(plane) != 2 or any(len(values) < 2 or (np.diff(values) <= 0).any() for values in plane.values()):
        raise InvalidInput("boundaries need two axes, each of increasing values; got " + (", ".join(plane) or "none"))
    points = Points(system, tuple(plane), fixed, as_number("t", t, "s"), state)
    contact = points.system.described.contact(contact)
    x, y = plane.values()
    points.check([x, y])
    pieces = Pieces()

    def fields(xy: np.ndarray) -> np.ndarray:
        """(n, 3) p, b, gamma_F at points (n, 2)."""
        values = np.zeros((len(xy), 3))
        for piece in pieces.of(len(xy)):
            found = points.search([np.ascontiguousarray(column) for column in xy[piece].T], 1)
            values[piece] = np.column_stack([found.p[:, contact], found.b[:, contact], found.gamma_F[:, contact]])
        return values

    grid = fields(np.column_stack([axis.ravel() for axis in np.meshgrid(x, y)])).reshape(len(y), len(x), 3)
    curves: dict[str, list[np.ndarray]] = {}
    for j, name in enumerate(FIELDS):
        lines: Any = contour_generator(x, y, np.ma.masked_invalid(grid[:, :, j])).lines(0.0)
        curves[name] = [refined(line, x, y, lambda xy, j=j: fields(xy)[:, j]) for line in lines]
    crossings = all_crossings(curves, np.array([np.ptp(x), np.ptp(y)]), fields)
    names = tuple(plane)
    return Boundaries((names[0], names[1]), curves["p"], curves["b"], curves["gamma_F"], crossings)


def all_crossings(curves: dict[str, list[np.ndarray]], extent: np.ndarray,
                  fields: Callable) -> dict[tuple[str, str], np.ndarray]:  # fmt: skip
    """The points where the curves of each two fields meet."""
    crossings = {}
    for pair in itertools.combinations(range(len(FIELDS)), 2):
        one, other = FIELDS[pair[0]], FIELDS[pair[1]]
        crossings[one, other] = common_zeros(
            curves[one], curves[other], extent, lambda xy, pair=pair: fields(xy)[:, pair]
        )  # fmt: skip
    return crossings


def refined(line: np.ndarray, x: np.ndarray, y: np.ndarray, field: Callable) -> np.ndarray:
    """Points of a contour line moved along the grid edges they lie on to the zero of the field, by bisection."""
    low, high = line.copy(), line.copy()
    for axis, values in enumerate((x, y)):
        place = np.clip(np.searchsorted(values, line[:, axis], side="right") - 1, 0, len(values) - 2)
        is_between = np.abs(values[place] - line[:, axis]) > 1e-9 * np.diff(values)[place]
        is_between &= np.abs(values[place + 1] - line[:, axis]) > 1e-9 * np.diff(values)[place]
        low[is_between, axis] = values[place][is_between]
        high[is_between, axis] = values[place + 1][is_between]
    f_low, f_high = field(low), field(high)
    is_bracket = f_low * f_high < 0
    for _ in range(EDGE_HALVINGS):
        middle = 0.5 * (low + high)
        f_middle = field(middle)
        is_left = (f_low * f_middle <= 0)[:, None]
        low, high = np.where(is_left, low, middle), np.where(is_left, middle, high)
        f_low = np.where(is_left[:, 0], f_low, f_middle)
    return np.where(is_bracket[:, None], 0.5 * (low + high), line)


def common_zeros(one: list[np.ndarray], other: list[np.ndarray], extent: np.ndarray, fields: Callable) -> np.ndarray:
    """(n, 2) points where two families of polylines cross, refined by Newton's method."""
    starts = [start for a in one for b in other for start in line_crossings(a, b)]
    found: list[np.ndarray] = []
    for start in starts:
        point = newton(np.array(start), extent, fields)
        if point is not None and not any((np.abs(point - known) <= 1e-6 * extent).all() for known in found):
            found.append(point)
    return np.array(found).reshape(-1, 2)


def line_crossings(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Points where the segments of two polylines cross."""
    d, e = np.diff(a, axis=0)[:, None], np.diff(b, axis=0)[None]
    gap = b[None, :-1] - a[:-1, None]
    area = d[..., 0] * e[..., 1] - d[..., 1] * e[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        along = (gap[..., 0] * e[..., 1] - gap[..., 1] * e[..., 0]) / area
        across = (gap[..., 0] * d[..., 1] - gap[..., 1] * d[..., 0]) / area
    i, j = np.nonzero((along >= 0) & (along <= 1) & (across >= 0) & (across <= 1))
    return a[i] + along[i, j][:, None] * d[i, 0]


def newton(point: np.ndarray, extent: np.ndarray, fields: Callable) -> np.ndarray | None:
    """The common zero of two fields near a point, or None."""
    steps = np.diag(PLANE_INCREMENT * extent)
    for _ in range(NEWTON_STEPS):
        values = fields(np.vstack([point, point + steps, point - steps]))
        J = ((values[1:3] - values[3:5]) / (2 * np.diag(steps))[:, None]).T
        try:
            change = np.linalg.solve(J, -values[0])
        except np.linalg.LinAlgError:
            return None
        point = point + change
        if not np.isfinite(point).all():
            return None
        if (np.abs(change) <= REACHED * extent).all():
            return point
    return None
