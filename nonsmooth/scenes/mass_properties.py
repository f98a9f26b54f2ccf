"""Mass, centroid and inertia of shapes of one density, and of bodies made of several.

A hull rounded by r is its polygon, a strip of width r along each edge, and a sector at each vertex, of the angle alpha
between the normals of its edges:

    strip    area l r,                        centroid r/2 outside the middle of the edge
    sector   area alpha r^2/2,                centroid (4 r/3 alpha) sin(alpha/2) outside the vertex
    polygon  2 A = sum p_k x p_(k+1),         6 A c = sum (p_k + p_(k+1)) p_k x p_(k+1),
             12 J = sum (p_k.p_k + p_k.p_(k+1) + p_(k+1).p_(k+1)) p_k x p_(k+1)      about the origin

A box core (a, b, c) rounded by r is the box, a slab of thickness r on each face, the quarters of a cylinder along its
edges and the octants of a ball at its vertices; along x

    int x^2 dV = 8 a^3 b c/3                                                                  box
               + 8 b c ((a + r)^3 - a^3)/3 + 8 a^3 (b + c) r/3                                slabs
               + 2 pi r^2 a^3/3 + 2 (b + c) (pi r^2 a^2 + 8 a r^3/3 + pi r^4/4)               cylinders
               + 4 pi r^3 a^2/3 + pi a r^4 + 4 pi r^5/15                                      ball

A cylinder of radius r and half length c about z, and an ellipsoid:

    V = 2 pi r^2 c,      int x^2 dV = V r^2/4,  int z^2 dV = V c^2/3
    V = 4 pi a b c/3,    int x^2 dV = V a^2/5

A polyhedron is the tetrahedra of a point and the triangles (p, q, r) of its faces, each with

    6 V = p . (q x r),   4 c = p + q + r,   20/V int x x^T dV = p p^T + q q^T + r r^T + (p + q + r)(p + q + r)^T

The parallel axis theorem: J_0 = J_c + m (c.c 1 - c c^T). Source: Goldstein, *Classical Mechanics*, section 5.3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nonsmooth.scenes.shape_rows import CYLINDER, ELLIPSOID, POLYHEDRON, ShapeRow


@dataclass(frozen=True)
class Mass:
    """Mass properties in the axes of a body.

    Attributes
    ----------
    mass : float
        [kg], or [kg/m] of depth in the plane.
    centroid : ndarray, (2,) or (3,)
        [m]
    inertia : ndarray, (1, 1) or (3, 3)
        About the centroid [kg m^2].
    """

    mass: float
    centroid: np.ndarray
    inertia: np.ndarray


def mass_of(shape: ShapeRow, density: float) -> Mass:
    """The mass properties of a bounded shape of this density [kg/m^3, or kg/m^2 in the plane], in the axes of its body.

    Examples
    --------
    >>> from nonsmooth.scenes.shape_rows import SPHERE
    >>> ball = ShapeRow(body=0, kind=SPHERE, place=(0, 0, 1, 1, 0, 0, 0), radius=0.5)
    >>> mass_of(ball, 1000.0).centroid.tolist()
    [0.0, 0.0, 1.0]
    """
    place = np.asarray(shape.place, dtype=float)
    if len(place) == 3:
        own = hull_mass(np.asarray(shape.vertices, dtype=float).reshape(-1, 2), shape.radius, density)
        c, s = math.cos(place[2]), math.sin(place[2])
        return Mass(own.mass, place[:2] + np.array([[c, -s], [s, c]]) @ own.centroid, own.inertia)
    own = solid_mass(shape, density)
    R = rotation(place[3:])
    return Mass(own.mass, place[:3] + R @ own.centroid, R @ own.inertia @ R.T)


def solid_mass(shape: ShapeRow, density: float) -> Mass:
    """Of a bounded shape of space, in its own axes."""
    a, b, c = shape.size
    if shape.kind == POLYHEDRON:
        return polyhedron(np.asarray(shape.vertices, dtype=float), shape.faces, density)
    if shape.kind == CYLINDER:
        return of_second_moments(2 * math.pi * a * b * c * density, a**2 / 4, b**2 / 4, c**2 / 3)
    if shape.kind == ELLIPSOID:
        return of_second_moments(4 / 3 * math.pi * a * b * c * density, a**2 / 5, b**2 / 5, c**2 / 5)
    return core_mass(np.asarray(shape.size, dtype=float), shape.radius, density)


def of_second_moments(mass: float, x: float, y: float, z: float) -> Mass:
    """From the means of the squared coordinates."""
    return Mass(mass, np.zeros(3), mass * np.diag([y + z, z + x, x + y]))


def polyhedron(vertices: np.ndarray, faces: Sequence[Sequence[int]], density: float) -> Mass:
    """Of vertices (k, 3) and faces, counterclockwise from outside; about a point within, so that nothing cancels."""
    centre = vertices.mean(axis=0)
    triangles = [(face[0], *pair) for face in faces for pair in zip(face[1:-1], face[2:], strict=True)]
    p, q, r = (vertices[[triangle[k] for triangle in triangles]] - centre for k in range(3))
    volumes, total = (p * np.cross(q, r)).sum(axis=1) / 6, p + q + r
    mass = float(volumes.sum())
    c = volumes @ total / (4 * mass)
    second = sum(np.einsum("t,ta,tb->ab", volumes, e, e) for e in (p, q, r, total)) / 20 - mass * np.outer(c, c)
    return Mass(density * mass, centre + c, density * (np.trace(second) * np.eye(3) - second))


def combined(parts: Sequence[Mass]) -> Mass:
    """The mass properties of several parts together, none of which overlap."""
    mass = sum(part.mass for part in parts)
    centroid = sum((part.mass * part.centroid for part in parts), np.zeros(len(parts[0].centroid))) / mass
    inertia = sum((part.inertia + carried(part, centroid) for part in parts), np.zeros_like(parts[0].inertia))
    return Mass(mass, centroid, inertia)


def carried(part: Mass, about: np.ndarray) -> np.ndarray:
    """The inertia of the mass of a part at its centroid, about another point."""
    c = part.centroid - about
    if len(c) == 2:
        return np.full((1, 1), part.mass * (c @ c))
    return part.mass * (c @ c * np.eye(3) - np.outer(c, c))


def rotation(quaternion: np.ndarray) -> np.ndarray:
    """The matrix of a unit quaternion (w, x, y, z)."""
    w, e = quaternion[0], quaternion[1:]
    skew = np.array([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]])
    return np.eye(3) + 2.0 * (w * skew + skew @ skew)


def core_mass(size: np.ndarray, r: float, density: float) -> Mass:
    """Of a box core rounded by r, about its centre."""
    a, b, c = size
    volume = 8 * a * b * c + 8 * r * (a * b + b * c + c * a) + 2 * math.pi * r**2 * (a + b + c) + 4 / 3 * math.pi * r**3
    x, y, z = second_moment(a, b, c, r), second_moment(b, c, a, r), second_moment(c, a, b, r)
    return Mass(density * volume, np.zeros(3), density * np.diag([y + z, z + x, x + y]))


def second_moment(a: float, b: float, c: float, r: float) -> float:
    """int x^2 dV of a box core rounded by r."""
    pi = math.pi
    box = 8 / 3 * a**3 * b * c
    slabs = 8 / 3 * (b * c * ((a + r) ** 3 - a**3) + a**3 * (b + c) * r)
    cylinders = 2 / 3 * pi * r**2 * a**3 + 2 * (b + c) * (pi * r**2 * a**2 + 8 / 3 * a * r**3 + pi / 4 * r**4)
    ball = 4 / 3 * pi * r**3 * a**2 + pi * a * r**4 + 4 / 15 * pi * r**5
    return box + slabs + cylinders + ball


def hull_mass(p: np.ndarray, r: float, density: float) -> Mass:
    """Of a hull with the vertices p (k, 2), counterclockwise, rounded by r."""
    parts = [polygon(p)] if len(p) > 2 else []
    edges = np.roll(p, -1, axis=0) - p
    if r > 0.0 and len(p) > 1:
        parts += [strip(p[k], edges[k], r) for k in range(len(p))]
    if r > 0.0:
        parts += [sector(p[k], edges[k - 1], edges[k], r) for k in range(len(p))]
    whole = combined(parts)
    return Mass(density * whole.mass, whole.centroid, density * whole.inertia)


def polygon(p: np.ndarray) -> Mass:
    """Of a polygon of density 1, from moments about its first vertex."""
    a = p - p[0]
    b = np.roll(a, -1, axis=0)
    twice = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    area = twice.sum() / 2
    c = (twice[:, None] * (a + b)).sum(0) / (6 * area)
    polar = (twice * ((a * a).sum(1) + (a * b).sum(1) + (b * b).sum(1))).sum() / 12
    return Mass(area, p[0] + c, np.full((1, 1), polar - area * (c @ c)))


def strip(p: np.ndarray, edge: np.ndarray, r: float) -> Mass:
    """Of the strip of width r outside an edge from p."""
    length = math.hypot(*edge)
    outward = np.array([edge[1], -edge[0]]) / length
    area = length * r
    return Mass(area, p + 0.5 * (edge + r * outward), np.full((1, 1), area * (length**2 + r**2) / 12))


def sector(p: np.ndarray, before: np.ndarray, behind: np.ndarray, r: float) -> Mass:
    """Of the sector of radius r at the vertex p between two edges; of a disc where there are none."""
    half = math.pi if not before.any() else 0.5 * abs(math.atan2(before[0] * behind[1] - before[1] * behind[0],
                                                                 before @ behind))  # fmt: skip
    area = half * r**2
    outside = 2 * r * math.sin(half) / (3 * half) if before.any() else 0.0
    middle = 0.0 if not before.any() else math.atan2(-before[0], before[1]) + half  # where its axis points
    c = outside * np.array([math.cos(middle), math.sin(middle)])
    return Mass(area, p + c, np.full((1, 1), area * r**2 / 2 - area * (c @ c)))
