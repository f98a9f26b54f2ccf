"""Pictures of planar scenes from a model's ``shape(q)``: polylines in the plane [m]. Needs the extra [plot]."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_count, as_floats, as_positive
from nonsmooth.drawing.animation import Animation, animation, as_animation
from nonsmooth.drawing.colours import BLUE, RED, STRIPS
from nonsmooth.drawing.forces import loads_of
from nonsmooth.drawing.labels import LETTER
from nonsmooth.drawing.plots import LETTERS, nearest_records, new_figure, save_figure
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.events import mode_name

if TYPE_CHECKING:
    from nonsmooth.results.solution import Solution

MAX_FRAMES = 1000  # chosen: a frame takes about 10 ms
FRAMES_A_PERIOD = 25  # chosen: of the fastest coordinate; with two or fewer it would seem to stand or to run backwards
REVERSAL = 0.05  # chosen: of its greatest speed: what a coordinate must reach both ways to have swung
ARROW = 0.2  # chosen: of the picture: the length of a large force
LARGE = 0.95  # chosen: quantile of the forces that has this length; larger ones are no longer
MIN_FRAMES = 25  # chosen: of an animation, however short its motion is
MAX_INSTANTS = 8  # chosen: named in the title of a picture
FIGURE_WIDTH, LEAST_HEIGHT, MOST_HEIGHT = 5.0, 2.5, 6.0  # chosen: of a figure [in]; its height follows the scene
MM_PER_INCH = 25.4  # defined
COLUMN, COLUMN_LETTERS = 5.0, 8  # chosen: in: a narrower figure is one for a column, and its letters [points]
LEAST_LINE = 24  # chosen: letters of a title's line


def picture(
    solution: Solution, path: str | Path | None = None, n: int = 5, times: ArrayLike | None = None,
    width: float | None = None,
) -> Any:  # fmt: skip
    """Draw the scene at the records nearest to some instants, the later the darker.

    Parameters
    ----------
    solution : Solution
    path : path-like, optional
        Where to save; the ending names the format, of which .pdf, .svg and .eps are made of lines.
    n : int
        Number of instants, equally spaced; the last one if n is 1.
    times : array_like, optional
        The instants themselves [s].
    width : float, optional
        Of the figure [mm], as a column of a journal has it; letters are 8 points high then.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidInput
        When the model has no ``shape(q)``, or a time lies outside the run.
    MissingExtra
        When Matplotlib is not installed.
    """
    model = scene_model(solution)
    records = instants(solution.t, n, times)
    figure = new_figure(as_inches(width), MOST_HEIGHT)
    axes = figure.subplots()
    prepare(axes, solution, model)
    for k, shade in zip(records, np.linspace(0.2 if len(records) > 1 else 1.0, 1.0, len(records)), strict=True):
        for line in model.shape(solution.q[k]):
            axes.plot(line[:, 0], line[:, 1], color=BLUE, alpha=shade, lw=1.8)
    named = ", ".join(f"{t:.3g}" for t in solution.t[records[:MAX_INSTANTS]])
    named += f", ... {solution.t[records[-1]]:.3g}" if len(records) > MAX_INSTANTS else ""
    axes.set_title(wrapped(f"t = {named} s{', the later the darker' if len(records) > 1 else ''}", figure), fontsize=10)
    set_letters(figure)
    return save_figure(figure, path)


def instants(t: np.ndarray, n: int, times: ArrayLike | None) -> np.ndarray:
    """Indices of the records nearest to the times, or to n equally spaced instants; of one the last."""
    n = as_count("n", n)
    if n > MAX_FRAMES:
        raise InvalidInput(f"n must not exceed {MAX_FRAMES} instants; got {n}")
    if times is None:
        return nearest_records(t, n) if n > 1 else np.array([len(t) - 1])
    wanted = np.atleast_1d(as_floats("times", times))
    if wanted.ndim > 1 or not 0 < wanted.size <= MAX_FRAMES or not ((t[0] <= wanted) & (wanted <= t[-1])).all():
        raise InvalidInput(
            f"times must be 1 to {MAX_FRAMES} instants within [{t[0]:g}, {t[-1]:g}] s, the times of the run; got "
            f"{shown(times)}"
        )
    return np.searchsorted(0.5 * (t[1:] + t[:-1]), wanted)


def as_inches(width: float | None) -> float:
    """The width of a figure, given in mm."""
    return FIGURE_WIDTH if width is None else as_positive("width", width, "mm") / MM_PER_INCH


def wrapped(text: str, figure: Any) -> str:
    """A title in lines that are not longer than the figure is wide."""
    return textwrap.fill(text, max(LEAST_LINE, int(LETTERS * figure.get_figwidth())))


def set_letters(figure: Any) -> None:
    """Letters of a column where the figure is as narrow as one."""
    if figure.get_figwidth() >= COLUMN:
        return
    for axes in figure.axes:
        for text in (axes.title, axes.xaxis.label, axes.yaxis.label, *axes.texts):
            text.set_fontsize(COLUMN_LETTERS)
        axes.tick_params(labelsize=COLUMN_LETTERS)


def animate(solution: Solution, path: str | Path | None = None, fps: int = 25) -> Path | Animation:
    """Animate a run with at least 25 frames in each period of the fastest coordinate; the title says how much the time
    is stretched, and where 1000 frames do not reach the end.

    Closed contacts are dots in the colour of what they do, with an arrow for the force on the body and a ring where a
    shock happened since the frame before, where its contacts have ``at(q)``.

    Parameters
    ----------
    solution : Solution
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
        When the model has no ``shape(q)``, or the ending is none of these.
    MissingExtra
        When Matplotlib or Pillow is not installed, or ffmpeg for an .mp4.
    """
    path, fps = as_animation(path, fps)
    model = scene_model(solution)
    figure = new_figure(FIGURE_WIDTH, MOST_HEIGHT)
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection

    axes = figure.subplots()
    prepare(axes, solution, model)
    lines = axes.add_collection(LineCollection([], colors=BLUE, linewidths=1.8))
    shown, slow = frames_of(solution, fps, periods=periods_of(solution))
    marks = contact_marks(axes, solution, model, shown)
    title, canvas = axes.set_title(" ", fontsize=10), FigureCanvasAgg(figure)
    canvas.draw()
    figure.set_layout_engine("none")  # the axes stay where they are; only what moves is drawn again
    background = canvas.copy_from_bbox(figure.bbox)

    def frame(k: int) -> np.ndarray:
        canvas.restore_region(background)
        lines.set_segments(model.shape(solution.q[k]))
        title.set_text(f"t = {solution.t[k]:.4g} s{slow}")
        for artist in (lines, *marks(k), title):
            axes.draw_artist(artist)
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()

    return animation(path, fps, shown, frame)


def frames_of(solution: Any, fps: int, most: int = MAX_FRAMES, periods: float = 0.0) -> tuple[np.ndarray, str]:
    """Indices of the records shown, equally spaced in time, and by how much the motion is slowed or hastened; of more
    periods than there are frames for, the first ones."""
    t = solution.t
    span = float(t[-1] - t[0])
    least = FRAMES_A_PERIOD * periods
    n = int(np.clip(np.ceil(max(span * fps, least)), MIN_FRAMES, most))
    part = min(1.0, most / least) if least > 0 else 1.0
    factor = n / fps / (part * span) if span > 0 else 1.0
    slower = f", {factor:.3g} times slower" if factor > 1 else f", {1 / factor:.3g} times faster"
    said = "" if 0.9 < factor < 1.1 else slower
    said += "" if part == 1.0 else f", the first {part * span:.3g} s of {span:.3g} s"
    end = max(int(np.searchsorted(t, t[0] + part * span, "right")), 1)
    return nearest_records(t[:end], n), said


def periods_of(solution: Solution) -> float:
    """How often the coordinate that reverses most swings to and fro."""
    return max((reversals(column) for column in solution.u.T), default=0) / 2


def reversals(speed: np.ndarray) -> int:
    """How often a speed changes its sign, small ones left out: those of rounding, and of what has come to rest."""
    sides = np.sign(speed[np.abs(speed) > REVERSAL * np.abs(speed).max(initial=0.0)])
    return int(np.count_nonzero(np.diff(sides)))


def contact_marks(axes: Any, solution: Solution, model: Any, shown: np.ndarray) -> Callable[[int], list[Any]]:
    """What draws the contacts of a record: dots by mode, arrows of forces, rings of shocks since the frame before."""
    from matplotlib.collections import LineCollection
    from matplotlib.lines import Line2D

    n_c = solution.mode.shape[1]
    if not n_c or model.contact_frames is None:
        return lambda k: []
    loads = loads_of(solution)
    force = np.where(loads.is_impulse, 0.0, np.hypot(loads.normal, loads.friction))
    large = float(np.quantile(force[force > 0], LARGE)) if (force > 0).any() else 1.0
    length = ARROW * float(np.ptp(axes.get_ylim()))
    arrows = axes.add_collection(LineCollection([], colors=RED, linewidths=1.6))
    dots = axes.scatter(np.zeros(n_c), np.zeros(n_c), s=28, zorder=5, edgecolors="black", linewidths=0.5)
    rings = axes.scatter([0.0], [0.0], s=140, zorder=4, facecolors="none", edgecolors=RED, linewidths=1.8)
    code = np.unique(3 * solution.mode + np.sign(solution.slip))
    handles = [
        Line2D([], [], marker="o", ls="", color=colour, mec="black", mew=0.5, label=mode_name(mode, slip))
        for (mode, slip), colour in STRIPS.items()
        if 3 * mode + slip in code and mode != ContactMode.OPEN
    ]
    handles.append(Line2D([], [], color=RED, lw=1.6, label=f"force, full length {large:.3g} N"))
    for artist in (arrows, dots, rings):
        artist.set_animated(True)
    axes.figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize=LETTER, frameon=False)
    before = dict(zip(shown[1:], shown[:-1], strict=True))

    def marks(k: int) -> list[Any]:
        """Move the marks to a record."""
        point, normal, tangent = model.contact_frames(solution.q[k])
        is_closed = solution.mode[k] != ContactMode.OPEN
        i = max(k - 1, 0)
        acts = np.where(loads.is_impulse[i], 0.0, 1.0)[:, None] * is_closed[:, None]
        F = acts * (loads.normal[i][:, None] * normal + loads.friction[i][:, None] * tangent) / large
        F *= length / np.maximum(1.0, np.linalg.norm(F, axis=1))[:, None]
        arrows.set_segments(np.stack([point, point + F], axis=1))
        dots.set_offsets(point[is_closed])
        dots.set_facecolors([STRIPS[ContactMode(int(m)), int(np.sign(s))] for m, s in
                             zip(solution.mode[k][is_closed], solution.slip[k][is_closed], strict=True)])  # fmt: skip
        first = before.get(k, k)
        loaded = loads.is_impulse[first:k] & ((loads.normal[first:k] != 0) | (loads.friction[first:k] != 0))
        rings.set_offsets(point[loaded.any(axis=0)])
        return [arrows, rings, dots]

    return marks


def scene_model(solution: Solution) -> Any:
    """What is known of a system with a shape, or `InvalidInput`."""
    if solution.described.shape is None:
        raise InvalidInput(
            "this solution has no picture: its model has no shape(q), or it was loaded from a file without its model, "
            "which Solution.load(path, model=...) takes"
        )
    return solution.described


def with_surroundings(low: np.ndarray, high: np.ndarray, still: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The box of a motion, widened until it reaches each line that stands still, unless that is farther than its size.

    A line that passes through the box, as the ground does, widens it no further.
    """
    size = (high - low).max()
    for line in still:
        least, most = line.min(axis=0), line.max(axis=0)
        if np.maximum(least - high, low - most).max() <= size:
            low, high = np.minimum(low, most), np.maximum(high, least)
    return low, high


def prepare(axes: Any, solution: Solution, model: Any) -> None:
    """Equal axes that hold the whole motion, and the ground."""
    shown = np.unique(np.linspace(0, len(solution.t) - 1, 200).astype(int))
    points = np.concatenate([line for k in shown for line in model.shape(solution.q[k])])
    low, high = points.min(axis=0), points.max(axis=0)
    for line in model.outline() if model.outline else []:
        axes.plot(line[:, 0], line[:, 1], color="grey", lw=1)
    low, high = with_surroundings(low, high, model.outline() if model.outline else [])
    margin = 0.08 * (high - low).max() or 1.0
    width, height = high - low + 2 * margin
    across = axes.figure.get_figwidth()
    axes.figure.set_size_inches(across, float(np.clip(across * height / width + 1.0, LEAST_HEIGHT, MOST_HEIGHT)))
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
