"""Spatial bodies of a scene, seen along a slanted axis and without perspective.

Faces are drawn from the far ones to the near ones, a sphere as a disc, so that bodies that are in one another may hide
wrongly.
"""

from __future__ import annotations

import functools
import itertools
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawing.bodies import CIRCLE_PIECES, EDGE, FILL, places, polygon, reached
from nonsmooth.drawing.facets import facets_of, has_facets
from nonsmooth.drawing.spring_lines import rope_lines, spring_lines
from nonsmooth.scenes.elements import Body, Kind
from nonsmooth.scenes.parts import parts_of
from nonsmooth.scenes.places import compose, matrix_of, rotate
from nonsmooth.scenes.shape_rows import BOX, CAPSULE, HALF_SPACE, POLYHEDRON

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

GROUND = "#efefef"
GROUND_MARGIN = 0.15  # chosen: of the size of the motion, by which the ground reaches farther than its bodies
# defined: of an isometric camera: about the vertical and above the horizon, at which x, y and z are equally short [rad]
AZIMUTH, ELEVATION = math.radians(-45.0), math.asin(1 / math.sqrt(3.0))
FORESHORTENED = math.sqrt(2.0 / 3.0)  # derived: length in an isometric picture of what is 1 long along x, y or z
SCALE_BAR = 0.25  # chosen: of the width of the picture, that the bar is not longer than
SPATIAL_MARGIN = 0.05  # chosen: of the larger side of what is drawn
Seen = tuple[float, np.ndarray, np.ndarray, bool]  # how near, outline in the picture, colour, whether it has an edge
LIGHT = np.array([0.25, -0.45, 0.86])  # chosen: from where the light comes
# chosen: discs of which a ball is drawn, the lighter the smaller: radius, shift towards the light, shade
HIGHLIGHTS = ((1.0, 0.0, 0.62), (0.86, 0.1, 0.74), (0.62, 0.24, 0.86), (0.34, 0.4, 0.97))


def camera() -> np.ndarray:
    """Rows: to the right, up, and towards the eye."""
    c, s = math.cos(AZIMUTH), math.sin(AZIMUTH)
    eye = np.array([math.cos(ELEVATION) * c, math.cos(ELEVATION) * s, math.sin(ELEVATION)])
    right = np.array([-s, c, 0.0])
    return np.array([right, np.cross(eye, right), eye])


def add_scale(axes: Any, extent: tuple[np.ndarray, np.ndarray]) -> None:
    """A bar with its length: of a vector that lies in the plane of the picture."""
    low, high = extent
    length = round_length(SCALE_BAR * float(high[0] - low[0]))
    across = FORESHORTENED * length
    axes.plot([low[0], low[0] + across], [low[1], low[1]], color="black", lw=2, solid_capstyle="butt", clip_on=False)
    axes.annotate(
        f"{length:g} m along x, y, z", (low[0], low[1]), (0, -4), textcoords="offset points", va="top",
        fontsize=8, annotation_clip=False,
    )  # fmt: skip


def round_length(x: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not longer."""
    power = 10.0 ** math.floor(math.log10(x))
    return max(step for step in (1.0, 2.0, 5.0) if step * power <= x * (1 + 1e-9)) * power


def spatial_extent(solution: SceneSolution) -> tuple[np.ndarray, np.ndarray]:
    """The corners, in the plane of the picture, of what bounded bodies reach in the run."""
    return reached(solution, functools.partial(reach_seen, camera()[:2]), SPATIAL_MARGIN)


def reach_seen(view: np.ndarray, body: Body, place: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Lower and upper corners, in the plane of the picture, of the parts of a bounded body."""
    if not body.shape.is_bounded:
        return []
    seen = [(corners @ view.T, radius) for corners, radius in cores(body, place)]
    return [(points.min(axis=0) - radius, points.max(axis=0) + radius) for points, radius in seen]


def cores(body: Body, place: np.ndarray) -> list[tuple[np.ndarray, float]]:
    """Corners (8, 3) of the core of each part in the world, and the radius that rounds it."""
    found = []
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    for part in parts_of(body.shape, 3):
        if part.kind != HALF_SPACE:
            at = compose(place, part.place)
            found.append((at[:3] + rotate(at[3:], signs * np.array(part.size)), part.radius))
    return found


def grounds_seen(solution: SceneSolution, record: int, view: np.ndarray) -> list[np.ndarray]:
    """Outlines in the picture of the planes that are seen from outside: what lies below the box of the motion."""
    is_free = [body.kind == Kind.DYNAMIC for body in solution.bodies]
    centres = solution.position[:, is_free if any(is_free) else slice(None)].reshape(-1, 3)
    low, high = centres.min(axis=0), centres.max(axis=0)
    reach = max(
        float(np.linalg.norm(corners - centre, axis=1).max()) + radius
        for body, centre, place in zip(
            solution.bodies, solution.position[record], places(solution, record), strict=True
        )
        for corners, radius in cores(body, place)
        if body.kind == Kind.DYNAMIC or not any(is_free)
    )
    margin = reach + GROUND_MARGIN * float((high - low).max())
    corners = np.array(list(itertools.product(*zip(low - margin, high + margin, strict=True))))
    found = []
    for body, place in zip(solution.bodies, places(solution, record), strict=True):
        for part in parts_of(body.shape, 3):
            at = compose(place, part.place)
            normal = matrix_of(at[3:])[:, 2]
            if part.kind == HALF_SPACE and normal @ view[2] > 0:
                below = corners - np.outer((corners - at[:3]) @ normal, normal)
                found.append(_hull(below @ view[:2].T))
    return found


FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))  # defined: outward


def draw_spatial(axes: Any, solution: SceneSolution, record: int, extent: tuple[np.ndarray, np.ndarray]) -> None:
    """Draw spatial bodies from the far ones to the near ones, and the ground where it is level."""
    from matplotlib.collections import LineCollection, PolyCollection

    view = camera()
    for ground in grounds_seen(solution, record, view):
        axes.add_patch(polygon(ground, facecolor=GROUND, edgecolor=FILL[Kind.FIXED], zorder=0))
    polygons: list[Seen] = []
    for body, place in zip(solution.bodies, places(solution, record), strict=True):
        if not body.shape.is_bounded:
            continue
        base = _rgb(FILL[body.kind])
        for part, (corners, radius) in zip(
            [part for part in parts_of(body.shape, 3) if part.kind != HALF_SPACE], cores(body, place), strict=True
        ):
            if has_facets(part):
                at = compose(place, part.place)
                faces = [at[:3] + rotate(at[3:], facet) for facet in facets_of(part)]
                polygons += seen_faces(faces, base, view, is_edged=part.kind == POLYHEDRON)
            else:
                polygons += seen_part(part.kind, corners, radius, base, view)
    polygons.sort(key=lambda entry: entry[0])
    many = max(1.0, len(solution.bodies) / 50)
    springs = [ends @ view[:2].T for ends in spring_lines(solution, record) + rope_lines(solution, record)]
    axes.add_collection(LineCollection(springs, colors=EDGE, linewidths=1.2 / math.sqrt(many)))
    axes.add_collection(
        PolyCollection(
            [outline for _, outline, _, _ in polygons], facecolors=[colour for _, _, colour, _ in polygons],
            edgecolors=[EDGE if edged else "none" for *_, edged in polygons], linewidths=0.6 / math.sqrt(many),
        )
    )  # fmt: skip


def seen_part(kind: int, corners: np.ndarray, radius: float, base: np.ndarray, view: np.ndarray) -> list[Seen]:
    """The polygons of a part."""
    centre = corners.mean(axis=0)
    if kind == BOX and radius == 0.0:
        return seen_faces([outward(corners[list(face)], centre) for face in FACES], base, view, is_edged=True)
    ends = corners[[0, 7]] if kind == CAPSULE else centre[None]
    angles = np.linspace(0.0, 2 * math.pi, CIRCLE_PIECES, endpoint=False)
    circle = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    light = radius * view[:2] @ LIGHT
    found = []
    for size, aside, shade in HIGHLIGHTS:
        points = np.concatenate([end @ view[:2].T + aside * light + size * circle for end in ends])
        outline = points if len(ends) == 1 else _hull(points)
        # by roundings nearer than the one below it, so that they stay in this order
        found.append((float(centre @ view[2]) + 1e-9 * radius * (1.0 - size), outline, shade * base, size == 1.0))
    return found


def outward(outline: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """A plane outline (k, 3), counterclockwise from the side away from a centre."""
    normal = np.cross(outline[1] - outline[0], outline[2] - outline[0])
    return outline if normal @ (outline.mean(axis=0) - centre) > 0 else outline[::-1]


def seen_faces(faces: list[np.ndarray], base: np.ndarray, view: np.ndarray, is_edged: bool) -> list[Seen]:
    """The faces (k, 3) of a convex body, counterclockwise from outside, that are turned to the camera."""
    found = []
    for outline in faces:
        normal = np.cross(outline[1] - outline[0], outline[2] - outline[0])
        normal /= np.linalg.norm(normal)
        if normal @ view[2] > 0:
            shade = 0.55 + 0.45 * max(0.0, float(normal @ LIGHT))
            found.append((float(outline.mean(axis=0) @ view[2]), outline @ view[:2].T, shade * base, is_edged))
    return found


def _hull(points: np.ndarray) -> np.ndarray:
    from scipy.spatial import ConvexHull

    return points[ConvexHull(points).vertices]


def _rgb(colour: str) -> np.ndarray:
    return np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
