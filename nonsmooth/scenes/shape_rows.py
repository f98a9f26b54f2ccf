"""Shapes: one row a shape, fixed to a body.

Planar. Every bounded shape is the convex hull of k >= 1 vertices, made rounder by a radius r (its Minkowski sum with a
disc):

    disc     1 vertex,  r           capsule   2 vertices, r
    segment  2 vertices, r = 0      box, polygon   k vertices, r >= 0

and there is the half-plane y <= 0 of its own axes. Edge e goes from vertex e to the next, counterclockwise; a hull of
two vertices has two edges, there and back.

Spatial. A sphere, a capsule along its own z and a box are each a box core with half lengths (0, 0, 0), (0, 0, c) and
(a, b, c), made rounder by r; the half-space is z <= 0 of its own axes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated as Array

import numpy as np
import numpy.typing as npt

from nonsmooth.jit.blocks import Block, Floats, Ints, new

# kinds of shape
HULL, HALF_PLANE = range(2)
SPHERE, CAPSULE, BOX, HALF_SPACE = range(4)


class Shapes(Block):
    """What is constant in the shapes of a scene; n_x = 3 | 7 numbers are a place."""

    body: Array[Ints, "n_s"]  # row in `Motion`
    kind: Array[Ints, "n_s"]
    place: Array[Floats, "n_s", "n_x"]  # in the body's axes
    radius: Array[Floats, "n_s"]  # [m] by which the core is made rounder
    size: Array[Floats, "n_s", "3"]  # [m] half lengths of the core; spatial
    reach: Array[Floats, "n_s"]  # [m] of the core about its place; inf for half-planes and half-spaces
    first: Array[Ints, "n_s"]  # rows in vertices; planar
    count: Array[Ints, "n_s"]
    vertices: Array[Floats, "n_w", "2"]  # [m] in the shape's axes, and of the edge that begins there:
    normals: Array[Floats, "n_w", "2"]  # outward
    length: Array[Floats, "n_w"]  # [m]
    apart: Array[Ints, "n_e"]  # pairs of bodies that do not collide, ``pair_code``, ascending


@dataclass(frozen=True)
class ShapeRow:
    """One shape. The place is (x, y, angle) or (position, unit quaternion) in the axes of the body.

    ``vertices`` (k, 2) are those of a hull, counterclockwise and strictly convex, a disc's at (0, 0); ``size`` the half
    lengths of a box core.
    """

    body: int
    kind: int
    place: Sequence[float]
    radius: float = 0.0
    size: Sequence[float] = (0.0, 0.0, 0.0)
    vertices: npt.ArrayLike = ()


def pair_code(a: int, b: int) -> int:
    """One number of a pair of bodies, whichever is named first."""
    return min(a, b) << 32 | max(a, b)


def shape_block(rows: Sequence[ShapeRow], apart: Sequence[tuple[int, int]] = ()) -> Shapes:
    """The rows as a block; bodies of the pairs ``apart`` do not collide.

    Examples
    --------
    >>> disc = ShapeRow(body=0, kind=HULL, place=(0, 0, 0), radius=0.5, vertices=[(0, 0)])
    >>> shape_block([disc, ShapeRow(1, HALF_PLANE, (0, 0, 0))]).reach.tolist()
    [0.0, inf]
    """
    hulls = [np.asarray(row.vertices, dtype=float).reshape(-1, 2) for row in rows]
    n_w = sum(map(len, hulls))
    shapes = new(Shapes, n_s=len(rows), n_x=len(rows[0].place) if rows else 3, n_w=n_w, n_e=len(apart))
    shapes.apart[:] = sorted(pair_code(a, b) for a, b in apart)
    first = 0
    for s, (row, hull) in enumerate(zip(rows, hulls, strict=True)):
        shapes.body[s], shapes.kind[s], shapes.place[s] = row.body, row.kind, row.place
        shapes.radius[s], shapes.size[s] = row.radius, row.size
        shapes.reach[s] = reach_of(row, hull)
        shapes.first[s], shapes.count[s] = first, len(hull)
        fill_edges(shapes, slice(first, first + len(hull)), hull)
        first += len(hull)
    return shapes


def reach_of(row: ShapeRow, hull: np.ndarray) -> float:
    """How far its core goes from its place [m]."""
    if len(row.place) == 3:
        return math.inf if row.kind == HALF_PLANE else float(np.hypot(*hull.T).max())
    return math.inf if row.kind == HALF_SPACE else math.hypot(*row.size)


def fill_edges(shapes: Shapes, rows: slice, hull: np.ndarray) -> None:
    """Vertices of a hull and, of the edges that begin there, lengths and outward normals."""
    shapes.vertices[rows] = hull
    if len(hull) > 1:
        edge = np.roll(hull, -1, axis=0) - hull
        shapes.length[rows] = np.hypot(*edge.T)
        shapes.normals[rows] = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / shapes.length[rows, None]
