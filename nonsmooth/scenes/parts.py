"""A shape as the rows that detection knows: convex parts, each with its place in the frame of the body."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nonsmooth.scenes.places import ORIGIN, compose, place_of, turn_onto
from nonsmooth.scenes.shape_rows import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    HALF_PLANE,
    HALF_SPACE,
    HULL,
    POLYHEDRON,
    SPHERE,
    ShapeRow,
)
from nonsmooth.scenes.shapes import (
    PLANAR,
    Box,
    Capsule,
    Compound,
    Cylinder,
    Disc,
    Ellipsoid,
    HalfPlane,
    HalfSpace,
    Polygon,
    Polyhedron,
    Segment,
    Shape,
    Sphere,
)

HALF = math.sqrt(0.5)  # derived: cos and sin of a quarter turn's half
ALONG_X = np.array([HALF, 0.0, HALF, 0.0])  # derived: turns z onto x, about y


class Part(NamedTuple):
    """A convex part: its core, rounded by a radius, at a place in the shape's frame."""

    kind: int
    place: np.ndarray
    radius: float = 0.0
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    vertices: np.ndarray = np.zeros((0, 2))
    faces: tuple[tuple[int, ...], ...] = ()

    def row(self, body: int, frame: np.ndarray) -> ShapeRow:
        """The row of it as a part of a body, in whose axes the shape's frame is at ``frame``."""
        place = compose(frame, self.place).tolist()
        return ShapeRow(body, self.kind, place, self.radius, self.size, self.vertices, self.faces)


def parts_of(shape: Shape, dim: int) -> list[Part]:
    """The parts of a shape in the plane or in space."""
    origin = ORIGIN[dim]
    if isinstance(shape, Compound):
        return [
            part._replace(place=compose(place_of(position, turn), part.place))
            for inner, position, turn in shape.parts
            for part in parts_of(inner, dim)
        ]
    if isinstance(shape, HalfPlane | HalfSpace):
        place = place_of(shape.offset * shape.normal, turn_onto(shape.normal))
        return [Part(HALF_PLANE if dim == PLANAR else HALF_SPACE, place)]
    if dim == PLANAR:
        vertices, radius = hull_of(shape)
        return [Part(HULL, origin, radius, vertices=vertices)]
    if isinstance(shape, Sphere):
        return [Part(SPHERE, origin, shape.radius)]
    if isinstance(shape, Capsule):
        return [Part(CAPSULE, place_of(origin[:3], ALONG_X), shape.radius, (0.0, 0.0, 0.5 * shape.length))]
    if isinstance(shape, Cylinder):
        size = (shape.radius, shape.radius, 0.5 * shape.length)
        return [Part(CYLINDER, place_of(origin[:3], ALONG_X), 0.0, size)]
    if isinstance(shape, Ellipsoid):
        return [Part(ELLIPSOID, origin, 0.0, (shape.a, shape.b, shape.c))]
    if isinstance(shape, Polyhedron):
        low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        at = place_of(middle, origin[3:])
        return [Part(POLYHEDRON, at, 0.0, tuple(half.tolist()), shape.vertices - middle, shape.faces)]
    assert isinstance(shape, Box)
    a, b, c = shape.lengths
    return [Part(BOX, origin, 0.0, (0.5 * a, 0.5 * b, 0.5 * c))]


def hull_of(shape: Shape) -> tuple[np.ndarray, float]:
    """The vertices (k, 2) of a bounded planar shape, counterclockwise, and the radius that rounds them."""
    if isinstance(shape, Disc):
        return np.zeros((1, 2)), shape.radius
    if isinstance(shape, Capsule):
        return np.array([[-0.5 * shape.length, 0.0], [0.5 * shape.length, 0.0]]), shape.radius
    if isinstance(shape, Box):
        a, b = 0.5 * shape.lengths[0], 0.5 * shape.lengths[1]
        return np.array([[-a, -b], [a, -b], [a, b], [-a, b]]), 0.0
    if isinstance(shape, Segment):
        return np.array([shape.a, shape.b]), 0.0
    assert isinstance(shape, Polygon)
    return shape.vertices, shape.radius
