"""Pictures and animations of scenes of bodies, in the plane and in space.

Needs the extra [plot]. A spatial picture looks along a slanted axis, without perspective; faces are drawn from the far
ones to the near ones, a sphere as a disc, so that bodies that are in one another may hide wrongly.
"""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.drawing.animation import Animation, animation, as_animation
from nonsmooth.drawing.facets import facets_of, has_facets
from nonsmooth.drawing.plots import new_figure, save_figure
from nonsmooth.drawing.scene import MAX_FRAMES, as_inches, frames_of, instants, set_letters
from nonsmooth.drawing.scene_contacts import scene_contact_marks
from nonsmooth.scenes.parts import Part, parts_of
from nonsmooth.scenes.places import ORIGIN, compose, inverse, matrix_of, place_of, rotate
from nonsmooth.scenes.scene import Body, Kind
from nonsmooth.scenes.shape_rows import BOX, CAPSULE, HALF_PLANE, HALF_SPACE, POLYHEDRON

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

SCENE_WIDTH, LEAST_SCENE, MOST_SCENE = 5.0, 2.5, 7.0  # chosen: of a figure [in]; its height follows the scene
FILL = {Kind.DYNAMIC: "#9ecae1", Kind.FIXED: "#d9d9d9", Kind.KINEMATIC: "#fdd0a2"}
EDGE, GROUND = "#08306b", "#efefef"
GROUND_MARGIN = 0.15  # chosen: of the size of the motion, by which the ground reaches farther than its bodies
WIDE_SCENE = 2.5  # chosen: a scene wider than this many heights has its instants one below the other
CIRCLE_PIECES = 24  # chosen: pieces of a circle
# defined: of an isometric camera: about the vertical and above the horizon, at which x, y and z are equally short [rad]
AZIMUTH, ELEVATION = math.radians(-45.0), math.asin(1 / math.sqrt(3.0))
FORESHORTENED = math.sqrt(2.0 / 3.0)  # derived: length in an isometric picture of what is 1 long along x, y or z
SCALE_BAR = 0.25  # chosen: of the width of the picture, that the bar is not longer than
BODIES_DRAWN, FEWEST_FRAMES = 60_000, 60  # chosen: of an animation: bodies in all frames, some 0.2 ms each, and frames
JOINT_SIZE = 2.5  # chosen: of the circle of a joint [pt]
Seen = tuple[float, np.ndarray, np.ndarray, bool]  # how near, outline in the picture, colour, whether it has an edge
LIGHT = np.array([0.25, -0.45, 0.86])  # chosen: from where the light comes
# chosen: discs of which a ball is drawn, the lighter the smaller: radius, shift towards the light, shade
HIGHLIGHTS = ((1.0, 0.0, 0.62), (0.86, 0.1, 0.74), (0.62, 0.24, 0.86), (0.34, 0.4, 0.97))


def picture(
    solution: SceneSolution, path: str | Path | None = None, n: int = 1, times: ArrayLike | None = None,
    width: float | None = None,
) -> Any:  # fmt: skip
    """Draw the scene at some instants side by side; a spatial one isometrically, with a bar for its scale.

    Parameters
    ----------
    solution : SceneSolution
    path : path-like, optional
        Where to save; the ending names the format, of which .pdf, .svg and .eps are made of lines.
    n : int
        Number of instants, equally spaced; the last one if n is 1.
    times : array_like, optional
        The instants themselves [s]; the nearest records are drawn.
    width : float, optional
        Of the figure [mm], as a column of a journal has it; letters are 8 points high then.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidInput
        For a time outside the run, and a solution that was loaded without its scene.
    MissingExtra
        When Matplotlib is not installed.
    """
    records = instants(solution.t, n, times)
    extent = extent_of(solution)
    across = as_inches(width)
    figure = new_figure(across, 1.0)
    *grid, height = arranged(extent, len(records), across)
    figure.set_size_inches(across, float(np.clip(height, LEAST_SCENE, MOST_SCENE)))
    draw_instants(figure, solution, records, extent, *grid)
    set_letters(figure)
    return save_figure(figure, path)


def arranged(extent: tuple[np.ndarray, np.ndarray], n: int, across: float) -> tuple[int, int, float]:
    """Rows and columns of so many instants, and the height [in] that suits a width."""
    wide, tall = extent[1] - extent[0]
    columns = 1 if wide > WIDE_SCENE * tall else min(n, 3)
    rows = -(-n // columns)
    return rows, columns, float(across / columns * tall / wide * rows + 0.9 * rows)


def draw_instants(
    figure: Any, solution: SceneSolution, records: np.ndarray, extent: tuple[np.ndarray, np.ndarray], rows: int,
    columns: int,
) -> None:  # fmt: skip
    """The scene at some records, in a figure or a part of one."""
    places = figure.subplots(rows, columns, squeeze=False).ravel()
    for k, (axes, record) in enumerate(zip(places, records, strict=False)):
        frame_scene(axes, solution, extent, has_label=k % columns == 0)
        draw_bodies(axes, solution, int(record), extent)
        axes.set_title(f"t = {solution.t[record]:.3g} s", fontsize=10)
    for axes in places[len(records) :]:
        axes.set_axis_off()


def animate(solution: SceneSolution, path: str | Path | None = None, fps: int = 25) -> Path | Animation:
    """Animate the whole run, in at most 1000 frames; with more than 60 bodies in fewer, 60 at least.

    Loaded contacts, where they were recorded, are dots in the colour of what they do, with a line for the impulse of a
    step on a body that is free to move; of compliant contacts for the force.

    Parameters
    ----------
    solution : SceneSolution
    path : path-like, optional
        A .gif, .webp or .mp4; without it a notebook shows what comes back.
    fps : int
        Frames a second.

    Returns
    -------
    Path or Animation

    Raises
    ------
    InvalidInput
        For another ending, and a solution that was loaded without its scene.
    MissingExtra
        When Matplotlib or Pillow is not installed, or ffmpeg for an .mp4.
    """
    path, fps = as_animation(path, fps)
    extent = extent_of(solution)
    figure = new_figure(SCENE_WIDTH, 1.0)
    wide, tall = extent[1] - extent[0]
    figure.set_size_inches(SCENE_WIDTH, float(np.clip(SCENE_WIDTH * tall / wide + 0.9, LEAST_SCENE, MOST_SCENE)))
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    axes, canvas = figure.subplots(), FigureCanvasAgg(figure)
    frame_scene(axes, solution, extent)
    title = axes.set_title(" ", fontsize=10)
    marks = scene_contact_marks(axes, solution, np.eye(2) if solution.dim == 2 else camera()[:2])
    canvas.draw()
    figure.set_layout_engine("none")  # the axes stay where they are; only the bodies and the title are drawn again
    background = canvas.copy_from_bbox(figure.bbox)
    most = int(np.clip(BODIES_DRAWN // len(solution.names), FEWEST_FRAMES, MAX_FRAMES))
    shown, slow = frames_of(solution, fps, most)

    def frame(k: int) -> np.ndarray:
        canvas.restore_region(background)
        title.set_text(f"t = {solution.t[k]:.3f} s{slow}")
        drawn = draw_bodies(axes, solution, int(k), extent)
        for artist in (*drawn, *marks(int(k)), *(axes.spines.values() if axes.axison else ()), title):
            axes.draw_artist(artist)
        for artist in drawn:
            artist.remove()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()

    return animation(path, fps, shown, frame)


def extent_of(solution: SceneSolution) -> tuple[np.ndarray, np.ndarray]:
    """The corners of the picture that holds the whole motion."""
    return planar_extent(solution) if solution.dim == 2 else spatial_extent(solution)


def frame_scene(
    axes: Any, solution: SceneSolution, extent: tuple[np.ndarray, np.ndarray], has_label: bool = True
) -> None:
    """Limits and labels of the picture of a scene."""
    low, high = extent
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    if solution.dim == 3:
        axes.set_axis_off()
        add_scale(axes, extent)
        return
    axes.set_xlabel("x [m]")
    if has_label:
        axes.set_ylabel("y [m]")


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


def draw_bodies(
    axes: Any, solution: SceneSolution, record: int, extent: tuple[np.ndarray, np.ndarray]
) -> list[Any]:  # fmt: skip
    """Draw the bodies of a record; what was added to the axes."""
    before = set(axes.get_children())
    draw = draw_planar if solution.dim == 2 else draw_spatial
    draw(axes, solution, record, extent)
    draw_joints(axes, solution, record)
    return sorted(set(axes.get_children()) - before, key=lambda artist: artist.get_zorder())


def places(solution: SceneSolution, record: int) -> list[np.ndarray]:
    """Where the frame of each shape is in a record."""
    dim = solution.dim
    found = []
    for body in solution.bodies:
        centre, turn = solution.position[record, body.index], solution.turn[record, body.index]
        place = place_of(centre, turn)
        offset = solution.centres[body.index]
        found.append(compose(place, place_of(-offset, ORIGIN[dim][dim:])))
    return found


def draw_joints(axes: Any, solution: SceneSolution, record: int) -> None:
    """Draw a small circle at each joint, where it is on the body that moves."""
    joints = solution.scene.joints if solution.scene is not None else []
    if not joints:
        return
    here, points = places(solution, record), []
    for joint in joints:
        body = joint.b if joint.b.kind is Kind.DYNAMIC else joint.a
        arm = compose(
            inverse(place_of(body.position, body.turn)), place_of(joint.at, ORIGIN[solution.dim][solution.dim :])
        )
        points.append(compose(here[body.index], arm)[: solution.dim])
    seen = np.array(points) if solution.dim == 2 else np.array(points) @ camera()[:2].T
    axes.plot(seen[:, 0], seen[:, 1], "o", mfc="white", mec=EDGE, ms=JOINT_SIZE, mew=0.8, zorder=3)


def planar_extent(solution: SceneSolution) -> tuple[np.ndarray, np.ndarray]:
    """The corners of what is drawn: all that bounded bodies reach in the run, and a margin."""
    lows, highs = [], []
    for record in np.unique(np.linspace(0, len(solution.t) - 1, 20).astype(int)):
        for body, place in zip(solution.bodies, places(solution, int(record)), strict=True):
            for part in parts_of(body.shape, 2):
                if part.kind != HALF_PLANE:
                    outline = rounded(part, place)
                    lows.append(outline.min(axis=0))
                    highs.append(outline.max(axis=0))
    low, high = np.min(lows, axis=0), np.max(highs, axis=0)
    margin = 0.06 * float((high - low).max() or 1.0)
    return low - margin, high + margin


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
        axes.add_patch(_polygon(outline, facecolor=FILL[kind], edgecolor="none", zorder=0))
    many = max(1.0, len(solution.bodies) / 100)
    for kind, polygons in outlines.items():
        collection = PolyCollection(polygons, facecolors=FILL[kind], edgecolors=EDGE, linewidths=0.8 / math.sqrt(many))
        axes.add_collection(collection)
    axes.add_collection(LineCollection(spokes, colors=EDGE, linewidths=0.8 / math.sqrt(many)))


def _polygon(outline: np.ndarray, **style: Any) -> Any:
    from matplotlib.patches import Polygon

    return Polygon(outline, **style)


def half_plane(place: np.ndarray, extent: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """What is seen of a half-plane: a rectangle that is larger than the picture."""
    size = 4.0 * float((extent[1] - extent[0]).max())
    middle = matrix_of(place[2]).T @ (0.5 * (extent[0] + extent[1]) - place[:2])
    x = middle[0]
    corners = np.array([[x - size, -size], [x + size, -size], [x + size, 0.0], [x - size, 0.0]])
    return place[:2] + rotate(place[2], corners)


def camera() -> np.ndarray:
    """Rows: to the right, up, and towards the eye."""
    c, s = math.cos(AZIMUTH), math.sin(AZIMUTH)
    eye = np.array([math.cos(ELEVATION) * c, math.cos(ELEVATION) * s, math.sin(ELEVATION)])
    right = np.array([-s, c, 0.0])
    return np.array([right, np.cross(eye, right), eye])


def spatial_extent(solution: SceneSolution) -> tuple[np.ndarray, np.ndarray]:
    """The corners, in the plane of the picture, of what bounded bodies reach in the run."""
    view = camera()[:2]
    lows, highs = [], []
    for record in np.unique(np.linspace(0, len(solution.t) - 1, 20).astype(int)):
        for body, place in zip(solution.bodies, places(solution, int(record)), strict=True):
            if body.shape.is_bounded:
                for corners, radius in cores(body, place):
                    seen = corners @ view.T
                    lows.append(seen.min(axis=0) - radius)
                    highs.append(seen.max(axis=0) + radius)
    low, high = np.min(lows, axis=0), np.max(highs, axis=0)
    margin = 0.05 * float((high - low).max() or 1.0)
    return low - margin, high + margin


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
    from matplotlib.collections import PolyCollection

    view = camera()
    for ground in grounds_seen(solution, record, view):
        axes.add_patch(_polygon(ground, facecolor=GROUND, edgecolor=FILL[Kind.FIXED], zorder=0))
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
