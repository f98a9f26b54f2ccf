"""The shapes of a body, as the player has them, as one mesh of triangles in the axes of the body, for a live view.

What is planar lies in z = 0. A disc lacks a sector, by which its turn is seen; a sphere has plane facets.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.drawing.facets import circle
from nonsmooth.drawing.player.film import Body, Shape, ShapeKind
from nonsmooth.scenes.places import rotate

SUBDIVISIONS = 2  # chosen: subdivisions of an icosahedron, 320 facets
UNBOUNDED = (ShapeKind.HALF_PLANE, ShapeKind.HALF_SPACE)


class Mesh(NamedTuple):
    """Corners (n, 3) [m], and the numbers of those of each triangle (m, 3), counterclockwise from outside."""

    corners: np.ndarray
    triangles: np.ndarray

    @property
    def size(self) -> float:
        """How far it reaches along an axis [m]."""
        return float(np.abs(self.corners).max(initial=0.0))


def outline_of(mesh: Mesh) -> np.ndarray:
    """The edges (k, 2, 3) of a planar mesh that belong to one triangle only."""
    edges = mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, first, count = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    return mesh.corners[edges[first[count == 1]]]


def mesh_of(body: Body, reach: float) -> Mesh:
    """All shapes of a body; of what has no bounds a piece that reaches so far [m]."""
    found = [piece(shape, reach) for shape in body.shapes]
    first = np.cumsum([0, *(len(mesh.corners) for mesh in found)])
    triangles = [mesh.triangles + start for mesh, start in zip(found, first[:-1], strict=True)]
    return Mesh(np.concatenate([mesh.corners for mesh in found]), np.concatenate(triangles))


def is_bounded(body: Body) -> bool:
    """Whether it is neither a half-plane nor a half-space."""
    return all(shape.kind not in UNBOUNDED for shape in body.shapes)


def piece(shape: Shape, reach: float) -> Mesh:
    """One shape."""
    mesh = MESHES[shape.kind, shape.points.shape[1]](shape, reach)
    return mesh if shape.place is None else Mesh(moved(mesh.corners, shape.place), mesh.triangles)


def moved(points: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Points (n, 3) of a frame in the body's own."""
    if len(place) == 3:
        return np.column_stack([place[:2] + rotate(place[2], points[:, :2]), points[:, 2]])
    return np.asarray(place[:3] + rotate(place[3:], points))


def fan(outline: np.ndarray) -> Mesh:
    """A convex outline (k, 2) in the plane."""
    k = np.arange(1, len(outline) - 1)
    return Mesh(np.column_stack([outline, np.zeros(len(outline))]), np.column_stack([0 * k, k, k + 1]))


def disc(shape: Shape, reach: float) -> Mesh:
    """A circle but for a sector."""
    return fan(np.concatenate([shape.points, shape.points + shape.radius * circle()]))


def thick_line(shape: Shape, reach: float) -> Mesh:
    """A planar capsule."""
    from scipy.spatial import ConvexHull

    around = np.concatenate([end + shape.radius * circle() for end in shape.points])
    return fan(around[ConvexHull(around).vertices])


def flat_square(shape: Shape, reach: float) -> Mesh:
    """A piece of the surface of a half-space, seen from outside."""
    return fan(reach * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]))


def below_line(shape: Shape, reach: float) -> Mesh:
    """A piece of a half-plane."""
    depth = reach / 20  # chosen: a strip below its surface
    return fan(np.array([(-reach, -depth), (reach, -depth), (reach, 0.0), (-reach, 0.0)]))


def sphere(shape: Shape, reach: float) -> Mesh:
    """Of plane facets, with corners on the sphere."""
    from trimesh.creation import icosphere

    ball = icosphere(SUBDIVISIONS, shape.radius)
    return Mesh(shape.points[0] + ball.vertices, ball.faces)


def hull(points: np.ndarray) -> Mesh:
    """The smallest convex body that has these points (n, 3)."""
    from trimesh.convex import convex_hull

    found = convex_hull(points)
    return Mesh(found.vertices, found.faces)


def capsule(shape: Shape, reach: float) -> Mesh:
    """The hull of two spheres."""
    from trimesh.creation import icosphere

    around = icosphere(SUBDIVISIONS, shape.radius).vertices
    return hull(np.concatenate([end + around for end in shape.points]))


def box(shape: Shape, reach: float) -> Mesh:
    """Of its half edges."""
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return hull(signs * shape.points)


def facets(shape: Shape, reach: float) -> Mesh:
    """Its triangles."""
    return Mesh(shape.points, np.arange(len(shape.points)).reshape(-1, 3))


def polygon(shape: Shape, reach: float) -> Mesh:
    """A convex polygon."""
    return fan(shape.points)


def segment(shape: Shape, reach: float) -> Mesh:
    """A line without thickness as a strip of a hundredth of its length."""
    along = (shape.points[1] - shape.points[0]) / 200
    aside = np.array([-along[1], along[0]])
    (x, y) = shape.points
    return fan(np.array([x - aside, y - aside, y + aside, x + aside]))


MESHES = {
    (ShapeKind.DISC, 2): disc, (ShapeKind.POLYGON, 2): polygon, (ShapeKind.POLYLINE, 2): segment,
    (ShapeKind.CAPSULE, 2): thick_line, (ShapeKind.HALF_PLANE, 2): below_line, (ShapeKind.SPHERE, 3): sphere,
    (ShapeKind.CAPSULE, 3): capsule, (ShapeKind.BOX, 3): box, (ShapeKind.FACETS, 3): facets,
    (ShapeKind.HALF_SPACE, 3): flat_square,
}  # fmt: skip
