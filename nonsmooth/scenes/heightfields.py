"""Ground of a shape that a table of heights gives: convex pieces from the surface down to a base.

In space the cell between (x_i, y_j) and (x_i+1, y_j+1) is two triangular prisms, which meet over this diagonal; in the
plane a piece is a trapezium. Faces between pieces and edges within flat ground are hidden (docs/theory/scenes.md).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_floats, as_number, as_vector
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.ranges import require_within
from nonsmooth.scenes.shapes import Compound, Polygon, Polyhedron, polyhedron_of

PRISM = ((3, 4, 5), (2, 1, 0), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))  # defined: faces; corners 3, 4, 5 are on top


def heightfield(heights: Any, lengths: Any, *, base: float | None = None) -> Compound:
    """Make ground of heights at the points of a grid, the middle of the grid at x = 0, or x = y = 0.

    Parameters
    ----------
    heights : array_like (n_y, n_x) or (n_x,)
        In space z at the points (x_i, y_j) as ``heights[j, i]``, in the plane y at x_i [m].
    lengths : array_like (2,) or float
        Of the whole grid along x and y, or along x [m].
    base : float, optional
        Height of the lower side, below all heights [m]; when left out, below the lowest one by the longer side of a
        cell.

    Returns
    -------
    Compound
        Of two triangular prisms a cell, or a trapezium: the surface is linear on each, and goes through all points.

    Raises
    ------
    InvalidInput
        For heights that are no grid of two points or more a side, or not finite; a length that is not positive; a base
        that is not below all heights.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> x = np.linspace(-1, 1, 21)
    >>> bowl = ns.heightfield(0.5 * (x**2 + x[:, None] ** 2), (2, 2))
    >>> bowl
    Compound(800 parts)
    >>> scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5))
    >>> _ = scene.fixed(bowl)
    """
    z = as_heights(heights)
    sides = as_lengths(lengths, z.ndim)
    x, *y = (np.linspace(-0.5 * side, 0.5 * side, n) for side, n in zip(sides, z.shape[::-1], strict=True))
    step = max(side / (n - 1) for side, n in zip(sides, z.shape[::-1], strict=True))
    low = as_base(base, float(z.min()), step)
    pieces = prisms(x, y[0], z, low) if y else trapezia(x, z, low)
    return Compound(*((piece, np.zeros(z.ndim + 1)) for piece in pieces))


def as_heights(value: Any) -> np.ndarray:
    """A grid of finite heights, or `InvalidInput`."""
    heights = as_floats("heights", value)
    if heights.ndim not in (1, 2) or min(heights.shape) < 2:
        raise InvalidInput(
            f"heights must be an (n_y, n_x) array, or (n_x,) in the plane, of 2 points a side or more; got shape "
            f"{heights.shape}"
        )
    if not np.isfinite(heights).all():
        raise InvalidInput("heights must be finite")
    return np.asarray(require_within("heights", heights, "m"))


def as_lengths(value: Any, sides: int) -> list[float]:
    """The sides of the grid, or `InvalidInput`."""
    lengths = as_vector("lengths", np.atleast_1d(as_floats("lengths", value)), sides)
    if not (lengths > 0).all():
        raise InvalidInput(f"lengths must be positive [m]; got {lengths.tolist()}")
    return require_within("lengths", lengths, "m").tolist()


def as_base(value: float | None, lowest: float, step: float) -> float:
    """The height of the lower side, or `InvalidInput`."""
    if value is None:
        return lowest - step
    base = float(require_within("base", as_number("base", value, "m"), "m"))
    if not base < lowest:
        raise InvalidInput(f"base must be below all heights, the lowest of which is {lowest:g} m; got {base:g} m")
    return base


def trapezia(x: np.ndarray, y: np.ndarray, base: float) -> Iterator[Polygon]:
    """The pieces below a line through points of the plane."""
    for k in range(len(x) - 1):
        yield Polygon([(x[k], base), (x[k + 1], base), (x[k + 1], y[k + 1]), (x[k], y[k])])


def prisms(x: np.ndarray, y: np.ndarray, z: np.ndarray, base: float) -> Iterator[Polyhedron]:
    """The pieces below a surface of triangles."""
    top = np.stack((*np.meshgrid(x, y), z), axis=2)
    for j in range(len(y) - 1):
        for i in range(len(x) - 1):
            a, b, c, d = top[j, i], top[j, i + 1], top[j + 1, i + 1], top[j + 1, i]
            for corners in ((a, b, c), (a, c, d)):
                vertices = np.array((*corners, *corners))
                vertices[:3, 2] = base
                yield polyhedron_of(vertices, PRISM)
