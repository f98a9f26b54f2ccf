"""Mass, centre and principal moments of a body, from its shape and its density or mass.

A rounded hull (the points within r of a convex polygon of area A and perimeter L) is the polygon, a rectangle along each
edge and a sector at each vertex; the sectors of all vertices make up a disc. Moments of parts add by the parallel axis
theorem, I_c = I + m (|c|^2 1 - c c^T).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.parts import Part, parts_of
from nonsmooth.scenes.places import matrix_of, quaternion_of
from nonsmooth.scenes.scene import Body
from nonsmooth.scenes.shape_rows import BOX, CAPSULE, SPHERE

LEAST_MOMENT = 1e-9  # chosen: of m times the square of the extent: with less, a body would turn without any torque


class Inertia(NamedTuple):
    """Of a body."""

    mass: float  # [kg]
    centre: np.ndarray  # (2|3,) in the shape's frame [m]
    axes: float | np.ndarray  # of the principal axes in the shape's frame: 0, or a unit quaternion
    moments: np.ndarray  # (1|3,) about them [kg m^2]


class Extent(NamedTuple):
    """Of a part of density one, in a frame: volume (area), centre, and the second moments int x x^T about the centre."""

    volume: float
    centre: np.ndarray
    second: np.ndarray


def inertia_of(body: Body, dim: int) -> Inertia:
    """The inertia of a body.

    Raises
    ------
    InvalidInput
        When the shape has no volume, or the body no moment.
    """
    extents = [extent_of(part, dim) for part in parts_of(body.shape, dim)]
    volume = sum(extent.volume for extent in extents)
    if not volume > 0:
        raise InvalidInput(f"{body.name} has a shape without volume, {body.shape!r}; round it, or fix the body")
    centre = sum(extent.volume * extent.centre for extent in extents) / volume
    second = sum(moved(extent, centre) for extent in extents)
    density = body.density if body.density is not None else body.mass / volume  # type: ignore[operator]
    mass = density * volume
    if dim == 2:
        moment = density * float(np.trace(second)) if body.inertia is None else float(body.inertia)
        return Inertia(mass, centre, 0.0, np.array([moment]))
    tensor = density * (np.trace(second) * np.eye(3) - second) if body.inertia is None else body.inertia
    axes, moments = principal_axes(tensor)
    return Inertia(mass, centre, axes, moments)


def principal_axes(tensor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The turn of the principal axes, and the moments (3,): axes that are principal already stay as they are."""
    off = np.abs(tensor - np.diag(np.diag(tensor))).max()
    if off <= 1e-14 * np.abs(tensor).max():
        moments = np.diag(tensor).copy()
        if np.ptp(moments) <= 1e-14 * moments.max():  # a cube, a ball: no turn changes the moments
            moments[:] = moments.mean()
        return np.array([1.0, 0.0, 0.0, 0.0]), moments
    moments, axes = np.linalg.eigh(tensor)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return quaternion_of(axes), moments


def moved(extent: Extent, centre: np.ndarray) -> np.ndarray:
    """Second moments about another centre."""
    arm = extent.centre - centre
    return extent.second + extent.volume * np.outer(arm, arm)


def extent_of(part: Part, dim: int) -> Extent:
    """The extent of a part in the shape's frame."""
    own = planar_extent(part.vertices, part.radius) if dim == 2 else spatial_extent(part)
    R = matrix_of(part.place[2] if dim == 2 else part.place[3:])
    return Extent(own.volume, part.place[:dim] + R @ own.centre, R @ own.second @ R.T)


def planar_extent(vertices: np.ndarray, r: float) -> Extent:
    """Of a hull that is rounded by r: the polygon, rectangles along its edges, sectors at its vertices."""
    pieces = [polygon_extent(vertices)] if len(vertices) > 2 else []
    edges = np.roll(vertices, -1, axis=0) - vertices
    lengths = np.hypot(*edges.T)
    if r > 0:
        for vertex, edge, length in zip(vertices, edges, lengths, strict=True):
            if length > 0:
                along, out = edge / length, np.array([edge[1], -edge[0]]) / length
                second = length * r / 12 * (length**2 * np.outer(along, along) + r**2 * np.outer(out, out))
                pieces.append(Extent(length * r, vertex + 0.5 * edge + 0.5 * r * out, second))
        pieces += sectors(vertices, edges, r)
    volume = sum(piece.volume for piece in pieces)
    if not volume > 0:
        return Extent(0.0, vertices.mean(axis=0), np.zeros((2, 2)))
    centre = sum(piece.volume * piece.centre for piece in pieces) / volume
    return Extent(volume, centre, sum(moved(piece, centre) for piece in pieces))


def sectors(vertices: np.ndarray, edges: np.ndarray, r: float) -> list[Extent]:
    """Of each vertex, the sector of radius r between the normals of its two edges; of a single one, the whole disc."""
    if len(vertices) == 1:
        return [Extent(np.pi * r**2, vertices[0], 0.25 * np.pi * r**4 * np.eye(2))]
    normals = np.arctan2(-edges[:, 0], edges[:, 1])
    found = []
    for k, vertex in enumerate(vertices):
        angle = (normals[k] - normals[k - 1]) % (2 * np.pi)
        middle = normals[k - 1] + 0.5 * angle
        area, arm = 0.5 * angle * r**2, 4 * r * np.sin(0.5 * angle) / (3 * angle)
        # int x x^T about the vertex, in axes along and across the bisector
        along, across = r**4 / 8 * (angle + np.sin(angle)), r**4 / 8 * (angle - np.sin(angle))
        e, f = np.array([np.cos(middle), np.sin(middle)]), np.array([-np.sin(middle), np.cos(middle)])
        second = along * np.outer(e, e) + across * np.outer(f, f) - area * arm**2 * np.outer(e, e)
        found.append(Extent(area, vertex + arm * e, second))
    return found


def polygon_extent(vertices: np.ndarray) -> Extent:
    """Of a convex polygon, by triangles from its first vertex."""
    origin = vertices[0]
    a, b = vertices[1:-1] - origin, vertices[2:] - origin
    areas = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    volume = float(areas.sum())
    centre = (areas[:, None] * (a + b)).sum(axis=0) / (3 * volume)
    # int x x^T over a triangle 0, a, b: area/12 (aa + bb + (a + b)(a + b))
    sums = np.einsum("k,ki,kj->ij", areas / 12, a, a) + np.einsum("k,ki,kj->ij", areas / 12, b, b)
    sums += np.einsum("k,ki,kj->ij", areas / 12, a + b, a + b)
    return Extent(volume, origin + centre, sums - volume * np.outer(centre, centre))


def spatial_extent(part: Part) -> Extent:
    """Of a ball, a capsule along z, or a cuboid."""
    r, (a, b, c) = part.radius, part.size
    if part.kind == SPHERE:
        volume = 4 / 3 * np.pi * r**3
        return Extent(volume, np.zeros(3), volume * r**2 / 5 * np.eye(3))
    if part.kind == CAPSULE:
        tube, ball = 2 * c * np.pi * r**2, 4 / 3 * np.pi * r**3
        across = tube * r**2 / 4 + ball * r**2 / 5
        # each half ball has its centre 3 r / 8 beyond the end of the tube
        along = tube * c**2 / 3 + ball * (r**2 / 5 + c**2 + 3 * c * r / 4)
        return Extent(tube + ball, np.zeros(3), np.diag([across, across, along]))
    assert part.kind == BOX
    volume = 8 * a * b * c
    return Extent(volume, np.zeros(3), volume / 3 * np.diag([a**2, b**2, c**2]))
