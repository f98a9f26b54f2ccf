"""The surface of a cylinder, a polyhedron or an ellipsoid as plane convex facets, for pictures."""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.scenes.parts import Part
from nonsmooth.scenes.shape_rows import CYLINDER, ELLIPSOID, POLYHEDRON

ROUND_PIECES = 24  # chosen: of a circle


def has_facets(part: Part) -> bool:
    """Whether a part is drawn by its facets."""
    return part.kind in (CYLINDER, POLYHEDRON, ELLIPSOID)


def facets_of(part: Part) -> list[np.ndarray]:
    """The facets (k, 3) in the part's axes, counterclockwise from outside."""
    if part.kind == POLYHEDRON:
        return [part.vertices[list(face)] for face in part.faces]
    return cylinder_facets(part.size) if part.kind == CYLINDER else ellipsoid_facets(part.size)


def circle() -> np.ndarray:
    """Points (k, 2) of the unit circle."""
    angles = np.linspace(0.0, 2 * math.pi, ROUND_PIECES, endpoint=False)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def bands(rings: np.ndarray) -> list[np.ndarray]:
    """Four-cornered facets between rings (n, k, 3) of points, counterclockwise about z and rising."""
    return [
        np.array([low[k - 1], low[k], high[k], high[k - 1]])
        for low, high in zip(rings[:-1], rings[1:], strict=True)
        for k in range(ROUND_PIECES)
    ]


def cylinder_facets(size: tuple[float, float, float]) -> list[np.ndarray]:
    """Of a cylinder about z."""
    rings = np.array([[(size[0] * x, size[1] * y, z) for x, y in circle()] for z in (-size[2], size[2])])
    return [rings[0][::-1], rings[1], *bands(rings)]


def ellipsoid_facets(size: tuple[float, float, float]) -> list[np.ndarray]:
    """Between circles of latitude; the poles are cut off a little above the last one."""
    heights = np.linspace(-0.5 * math.pi, 0.5 * math.pi, ROUND_PIECES // 2 + 1)
    heights[[0, -1]] *= 1.0 - 0.25 / ROUND_PIECES  # facets of four different corners there too
    rings = np.array([[(math.cos(h) * x, math.cos(h) * y, math.sin(h)) for x, y in circle()] for h in heights])
    rings *= size
    return [rings[0][::-1], rings[-1], *bands(rings)]


def triangles_of(part: Part) -> np.ndarray:
    """The facets as triangles (n, 3, 3); those of a circle about its middle."""
    return np.array([triangle for facet in facets_of(part) for triangle in fan_of(facet)])


def fan_of(facet: np.ndarray) -> list[list[np.ndarray]]:
    """The triangles of a convex facet (k, 3)."""
    if len(facet) == ROUND_PIECES:
        middle = facet.mean(axis=0)
        return [[middle, facet[k - 1], facet[k]] for k in range(ROUND_PIECES)]
    return [[facet[0], facet[k], facet[k + 1]] for k in range(1, len(facet) - 1)]


def quarters_of(part: Part, triangles: np.ndarray) -> np.ndarray | None:
    """Of a round part the sign of the quarter about its z-axis that each triangle (n, 3, 3) lies in."""
    if part.kind == POLYHEDRON:
        return None
    x, y, _ = triangles.mean(axis=1).T
    return np.where(x * y > 0, 1, -1)
