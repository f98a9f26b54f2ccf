"""Pictures and animations of scenes of bodies, in the plane and in space.

Needs the extra [plot]. How planar bodies are drawn is in planar_bodies.py, how spatial ones are in spatial_bodies.py.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.drawing.animation import Animation, animation, as_animation
from nonsmooth.drawing.bodies import EDGE, places
from nonsmooth.drawing.joint_axes import AXIS_SHARE, gone_with, joint_axes, limits_of
from nonsmooth.drawing.planar_bodies import draw_planar, planar_extent
from nonsmooth.drawing.plots import new_figure, save_figure
from nonsmooth.drawing.scene import MAX_FRAMES, as_inches, frames_of, instants, set_letters
from nonsmooth.drawing.scene_contacts import scene_contact_marks
from nonsmooth.drawing.spatial_bodies import add_scale, camera, draw_spatial, spatial_extent
from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.places import ORIGIN, compose, inverse, place_of

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

SCENE_WIDTH, LEAST_SCENE, MOST_SCENE = 5.0, 2.5, 7.0  # chosen: of a figure [in]; its height follows the scene
WIDE_SCENE = 2.5  # chosen: a scene wider than this many heights has its instants one below the other
INSTANTS_IN_ROW = (3, 2, 4)  # chosen: of instants, the first that leaves the fewest places empty
BODIES_DRAWN, FEWEST_FRAMES = 60_000, 60  # chosen: of an animation: bodies in all frames, some 0.2 ms each, and frames
NARROW_SCENE = 0.2  # chosen: width of a picture below which the numbers on its axis are long [m]
MOST_TICKS_OF_NARROW = 3  # chosen: numbers that there is room for then
JOINT_SIZE = 2.5  # chosen: of the circle of a joint [pt]


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
    """Rows and columns of so many instants with the fewest empty places, and the height [in] that suits a width."""
    wide, tall = extent[1] - extent[0]
    columns = n if n <= INSTANTS_IN_ROW[0] else min(INSTANTS_IN_ROW, key=lambda number: -n % number)
    columns = 1 if wide > WIDE_SCENE * tall else columns
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
    if high[0] - low[0] < NARROW_SCENE:
        axes.locator_params(axis="x", nbins=MOST_TICKS_OF_NARROW)
    axes.set_xlabel("x [m]")
    if has_label:
        axes.set_ylabel("y [m]")


def draw_bodies(
    axes: Any, solution: SceneSolution, record: int, extent: tuple[np.ndarray, np.ndarray]
) -> list[Any]:  # fmt: skip
    """Draw the bodies of a record; what was added to the axes."""
    before = set(axes.get_children())
    draw = draw_planar if solution.dim == 2 else draw_spatial
    draw(axes, solution, record, extent)
    draw_joints(axes, solution, record, float(np.max(extent[1] - extent[0])))
    added = [artist for artist in axes.get_children() if artist not in before]
    return sorted(added, key=lambda artist: artist.get_zorder())  # of one order as they were added


def draw_joints(axes: Any, solution: SceneSolution, record: int, size: float) -> None:
    """Draw a small circle at each joint, where it is on the body that moves, and its axis; size is the picture's."""
    joints = [joint for joint in solution.joints if not joint.is_tie]
    if not joints:
        return
    here, points = places(solution, record), []
    for ends in joint_axes(solution, here, size):
        line = ends if solution.dim == 2 else ends @ camera()[:2].T
        axes.plot(line[:, 0], line[:, 1], "--|", color=EDGE, lw=0.7, ms=2 * JOINT_SIZE, zorder=2.5)
    for joint in joints:
        for points_of_limit in limits_of(joint, AXIS_SHARE * size):
            line = gone_with(joint.a, here[joint.a.index], points_of_limit)
            line = line if solution.dim == 2 else line @ camera()[:2].T
            axes.plot(line[:, 0], line[:, 1], color=EDGE, lw=0.7, zorder=2.5)
    for joint in joints:
        body = joint.b if joint.b.kind is Kind.DYNAMIC else joint.a
        arm = compose(
            inverse(place_of(body.position, body.turn)), place_of(joint.at, ORIGIN[solution.dim][solution.dim :])
        )
        points.append(compose(here[body.index], arm)[: solution.dim])
    seen = np.array(points) if solution.dim == 2 else np.array(points) @ camera()[:2].T
    axes.plot(seen[:, 0], seen[:, 1], "o", mfc="white", mec=EDGE, ms=JOINT_SIZE, mew=0.8, zorder=3)
