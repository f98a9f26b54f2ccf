"""Shapes: one row a shape, fixed to a body.

Planar. Every bounded shape is the convex hull of k >= 1 vertices, made rounder by a radius r (its Minkowski sum with a
disc):

    disc     1 vertex,  r           capsule   2 vertices, r
    segment  2 vertices, r = 0      box, polygon   k vertices, r >= 0

and there is the half-plane y <= 0 of its own axes. Edge e goes from vertex e to the next, counterclockwise; a hull of
two vertices has two edges, there and back.

Spatial. A sphere, a capsule along its own z and a box are each a box core with half lengths (0, 0, 0), (0, 0, c) and
(a, b, c), made rounder by r; the half-space is z <= 0 of its own axes. A cylinder about its own z has the half lengths
(r, r, c), an ellipsoid its half axes; a polyhedron has vertices and faces, and half the widths of its bounding box.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Annotated as Array
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nonsmooth.jit.blocks import Block, Floats, Ints, new
from nonsmooth.scenes.faces import UP, Face, Faces, faces_of_box, faces_of_hull

# kinds of shape
HULL, HALF_PLANE = range(2)
SPHERE, CAPSULE, BOX, HALF_SPACE, CYLINDER, POLYHEDRON, ELLIPSOID = range(7)


class Solids(Block):
    """Vertices and faces of the polyhedra of a scene, one behind the other."""

    first: Array[Ints, "n_s"]  # rows in vertices, of a shape
    count: Array[Ints, "n_s"]
    first_face: Array[Ints, "n_s"]
    faces: Array[Ints, "n_s"]
    vertices: Array[Floats, "n_v", "3"]  # [m] in the shape's axes
    normal: Array[Floats, "n_f", "3"]  # outward
    first_corner: Array[Ints, "n_f"]  # rows in corner, counterclockwise from outside
    corners: Array[Ints, "n_f"]
    corner: Array[Ints, "n_k"]  # vertex of its shape
    edge: Array[Ints, "n_k"]  # of its shape, from this corner to the next of the face


class Shapes(Block, n_g=0, n_l=0):
    """What is constant in the shapes of a scene; n_x = 3 | 7 numbers are a place."""

    body: Array[Ints, "n_s"]  # row in `Motion`
    kind: Array[Ints, "n_s"]
    place: Array[Floats, "n_s", "n_x"]  # in the body's axes
    radius: Array[Floats, "n_s"]  # [m] by which the core is made rounder
    size: Array[Floats, "n_s", "3"]  # [m] half lengths of the core; spatial
    reach: Array[Floats, "n_s"]  # [m] of the core about its place; inf for half-planes and half-spaces
    rank: Array[Ints, "n_s"]  # in an order of the geometries alone; the same of shapes that look the same
    first: Array[Ints, "n_s"]  # rows in vertices; planar
    count: Array[Ints, "n_s"]
    vertices: Array[Floats, "n_w", "2"]  # [m] in the shape's axes, and of the edge that begins there:
    normals: Array[Floats, "n_w", "2"]  # outward
    length: Array[Floats, "n_w"]  # [m]
    solids: Solids
    faces: Faces
    apart: Array[Ints, "n_e"]  # pairs of bodies that do not collide, ``pair_code``, ascending


class ShapeRow(NamedTuple):
    """One shape. The place is (x, y, angle) or (position, unit quaternion) in the axes of the body.

    ``vertices`` (k, 2) are those of a hull, counterclockwise and strictly convex, a disc's at (0, 0); (k, 3) of a
    polyhedron, with its ``faces``; ``size`` the half lengths of a core.
    """

    body: int
    kind: int
    place: Sequence[float]
    radius: float = 0.0
    size: Sequence[float] = (0.0, 0.0, 0.0)
    vertices: npt.ArrayLike = ()
    faces: tuple[tuple[int, ...], ...] = ()


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
    planar = [row if row.kind != POLYHEDRON else None for row in rows]
    hulls = [np.asarray(row.vertices if row else (), dtype=float).reshape(-1, 2) for row in planar]
    sizes = {"n_s": len(rows), "n_x": len(rows[0].place) if rows else 3, "n_w": sum(map(len, hulls)), "n_e": len(apart)}
    flat = [list(faces_of_row(row, hull)) for row, hull in zip(rows, hulls, strict=True)]
    sizes |= {"n_g": sum(map(len, flat)), "n_l": sum(len(corners) for row in flat for _, corners in row)}
    shapes = new(Shapes, **sizes, **sizes_of_solids(rows))
    shapes.apart[:] = sorted(pair_code(a, b) for a, b in apart)
    if rows:
        shapes.body[:], shapes.kind[:], shapes.place[:], shapes.radius[:], shapes.size[:], *_ = zip(*rows, strict=True)
    shapes.reach[:] = [reach_of(row, hull) for row, hull in zip(rows, hulls, strict=True)]
    shapes.count[:] = [len(hull) for hull in hulls]
    shapes.first[1:] = np.cumsum(shapes.count)[:-1]
    for first, hull in zip(shapes.first, hulls, strict=True):
        if len(hull):
            fill_edges(shapes, slice(first, first + len(hull)), hull)
    fill_solids(shapes.solids, rows)
    fill_faces(shapes.faces, flat)
    shapes.rank[:] = ranks_of(rows)
    return shapes


def faces_of_row(row: ShapeRow, hull: np.ndarray) -> Iterator[Face]:
    """The plane faces of a shape; none where it is rounded."""
    if row.radius > 0.0:
        return
    if len(row.place) == 3:
        flat = np.column_stack((hull, np.zeros(len(hull))))
        yield from [(np.array([0.0, 1.0, 0.0]), np.empty((0, 3)))] if row.kind == HALF_PLANE else faces_of_hull(flat)
    elif row.kind == HALF_SPACE:
        yield UP, np.empty((0, 3))
    elif row.kind == BOX:
        yield from faces_of_box(row.size)
    elif row.kind == POLYHEDRON:
        for loop in row.faces:
            corners = np.asarray(row.vertices, dtype=float)[list(loop)]
            yield normal_of(corners), corners


def fill_faces(faces: Faces, flat: Sequence[Sequence[Face]]) -> None:
    """Write the faces of all shapes."""
    f, k = 0, 0
    for s, row in enumerate(flat):
        faces.first[s], faces.count[s] = f, len(row)
        for normal, corners in row:
            faces.normal[f], faces.first_corner[f], faces.corners[f] = normal, k, len(corners)
            faces.height[f] = float((corners @ normal).mean()) if len(corners) else 0.0
            faces.corner[k : k + len(corners)] = corners
            f, k = f + 1, k + len(corners)


def ranks_of(rows: Sequence[ShapeRow]) -> list[int]:
    """The number of each shape among the different ones, by kind, measures and vertices: whichever rows they are."""
    looks = [(row.kind, row.radius, *row.size, np.asarray(row.vertices, dtype=float).tobytes()) for row in rows]
    rank = {look: k for k, look in enumerate(sorted(set(looks)))}
    return [rank[look] for look in looks]


def reach_of(row: ShapeRow, hull: np.ndarray) -> float:
    """How far its core goes from its place [m]."""
    if len(row.place) == 3:
        return math.inf if row.kind == HALF_PLANE else float(np.hypot(*hull.T).max())
    if row.kind == HALF_SPACE:
        return math.inf
    if row.kind == POLYHEDRON:
        return float(np.linalg.norm(row.vertices, axis=1).max())
    if row.kind == ELLIPSOID:
        return max(row.size)
    return math.hypot(*row.size[1:]) if row.kind == CYLINDER else math.hypot(*row.size)


def sizes_of_solids(rows: Sequence[ShapeRow]) -> dict[str, int]:
    """Of `Solids`: vertices, faces and their corners."""
    loops = [loop for row in rows for loop in row.faces]
    n_v = sum(len(np.asarray(row.vertices)) for row in rows if row.kind == POLYHEDRON and len(row.place) > 3)
    return {"n_v": n_v, "n_f": len(loops), "n_k": sum(map(len, loops))}


def fill_solids(solids: Solids, rows: Sequence[ShapeRow]) -> None:
    """Vertices, faces and edges of all polyhedra."""
    v, f, k = 0, 0, 0
    for s, row in enumerate(rows):
        if not row.faces:
            continue
        vertices = np.asarray(row.vertices, dtype=float)
        edges: dict[frozenset[int], int] = {}
        solids.first[s], solids.count[s], solids.first_face[s], solids.faces[s] = v, len(vertices), f, len(row.faces)
        solids.vertices[v : v + len(vertices)] = vertices
        v += len(vertices)
        for loop in row.faces:
            solids.normal[f] = normal_of(vertices[list(loop)])
            solids.first_corner[f], solids.corners[f] = k, len(loop)
            for a, b in zip(loop, (*loop[1:], loop[0]), strict=True):
                solids.corner[k], solids.edge[k] = a, edges.setdefault(frozenset((a, b)), len(edges))
                k += 1
            f += 1


def normal_of(loop: np.ndarray) -> np.ndarray:
    """The unit normal of a plane polygon (k, 3), counterclockwise about it (Newell)."""
    a = loop - loop[0]
    (x, y, z), (u, v, w) = a.T, np.roll(a, -1, axis=0).T
    area = np.stack((y * w - z * v, z * u - x * w, x * v - y * u), axis=1).sum(axis=0)
    return area / np.linalg.norm(area)


def fill_edges(shapes: Shapes, rows: slice, hull: np.ndarray) -> None:
    """Vertices of a hull and, of the edges that begin there, lengths and outward normals."""
    shapes.vertices[rows] = hull
    if len(hull) > 1:
        edge = np.roll(hull, -1, axis=0) - hull
        shapes.length[rows] = np.hypot(*edge.T)
        shapes.normals[rows] = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / shapes.length[rows, None]
