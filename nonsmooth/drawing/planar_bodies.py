"""Planar bodies of a scene: outlines of their parts, half-planes as far as they are seen."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawing.bodies import CIRCLE_PIECES, EDGE, FILL, places, polygon, reached
from nonsmooth.drawing.spring_lines import COIL_WIDTH, coil, rope_lines, spring_lines
from nonsmooth.scenes.elements import Body, Kind
from nonsmooth.scenes.parts import Part, parts_of
from nonsmooth.scenes.places import compose, matrix_of, rotate
from nonsmooth.scenes.shape_rows import HALF_PLANE

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

PLANAR_MARGIN = 0.06  # chosen: of the larger side of what is drawn


def planar_extent(solution: SceneSolution) -> tuple[np.ndarray, np.ndarray]:
    """The corners of what is drawn: all that bounded bodies reach in the run, and a margin."""
    return reached(solution, reach_of, PLANAR_MARGIN)


def reach_of(body: Body, place: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Lower and upper corners of the bounded parts of a body."""
    outlines = [rounded(part, place) for part in parts_of(body.shape, 2) if part.kind != HALF_PLANE]
    return [(outline.min(axis=0), outline.max(axis=0)) for outline in outlines]


def rounded(part: Part, place: np.ndarray) -> np.ndarray:
    """The outline (k, 2) of a planar hull in the world: each vertex an arc from one normal to the next."""
    at = compose(place, part.place)
    vertices = at[:2] + rotate(at[2], part.vertices)
    if part.radius == 0.0:
        return vertices
    if len(vertices) == 1:
        angles = at[2] + np.linspace(0.0, 2 * math.pi, CIRCLE_PIECES + 1)
        return vertices[0] + part.radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    edges = np.roll(vertices, -1, axis=0) - vertices
    normals = np.arctan2(-edges[:, 0], edges[:, 1])
    arcs = []
    for k, vertex in enumerate(vertices):
        first, turn = normals[k - 1], (normals[k] - normals[k - 1]) % (2 * math.pi)
        angles = first + np.linspace(0.0, turn, max(2, int(CIRCLE_PIECES * turn / (2 * math.pi)) + 2))
        arcs.append(vertex + part.radius * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    return np.concatenate(arcs)


def draw_planar(axes: Any, solution: SceneSolution, record: int, extent: tuple[np.ndarray, np.ndarray]) -> None:
    """Draw planar bodies; a disc has a spoke, so that its turn is seen."""
    from matplotlib.collections import LineCollection, PolyCollection

    outlines: dict[Kind, list[np.ndarray]] = {kind: [] for kind in Kind}
    spokes, grounds = [], []
    for body, place in zip(solution.bodies, places(solution, record), strict=True):
        for part in parts_of(body.shape, 2):
            if part.kind == HALF_PLANE:
                grounds.append((body.kind, half_plane(compose(place, part.place), extent)))
                continue
            outline = rounded(part, place)
            outlines[body.kind].append(outline)
            if len(part.vertices) == 1:
                spokes.append(np.array([compose(place, part.place)[:2], outline[0]]))
    for kind, outline in grounds:
        axes.add_patch(polygon(outline, facecolor=FILL[kind], edgecolor="none", zorder=0))
    many = max(1.0, len(solution.bodies) / 100)
    for kind, polygons in outlines.items():
        collection = PolyCollection(polygons, facecolors=FILL[kind], edgecolors=EDGE, linewidths=0.8 / math.sqrt(many))
        axes.add_collection(collection)
    starts = spring_lines(solution, 0)
    coils = [
        coil(ends, COIL_WIDTH * float(np.linalg.norm(start[1] - start[0])))
        for ends, start in zip(spring_lines(solution, record), starts, strict=True)
    ]
    axes.add_collection(
        LineCollection(spokes + coils + rope_lines(solution, record), colors=EDGE, linewidths=0.8 / math.sqrt(many))
    )


def half_plane(place: np.ndarray, extent: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """What is seen of a half-plane: a rectangle that is larger than the picture."""
    size = 4.0 * float((extent[1] - extent[0]).max())
    middle = matrix_of(place[2]).T @ (0.5 * (extent[0] + extent[1]) - place[:2])
    x = middle[0]
    corners = np.array([[x - size, -size], [x + size, -size], [x + size, 0.0], [x - size, 0.0]])
    return place[:2] + rotate(place[2], corners)
