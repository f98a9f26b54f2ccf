"""Pictures of planar scenes from a model's ``shape(q)``: polylines in the plane [m]. Needs the extra [plot]."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_count, as_floats, as_positive
from nonsmooth.drawing.animation import Animation, animation, as_animation
from nonsmooth.drawing.plots import LETTERS, new_figure, save_figure
from nonsmooth.errors import InvalidInput, shown

if TYPE_CHECKING:
    from nonsmooth.results.solution import Solution

MAX_FRAMES = 400  # chosen: a frame takes about 10 ms
MIN_FRAMES = 25  # chosen: of an animation, however short its motion is
MAX_INSTANTS = 8  # chosen: named in the title of a picture
FIGURE_WIDTH, LEAST_HEIGHT, MOST_HEIGHT = 6.0, 2.5, 6.0  # chosen: of a figure [in]; its height follows the scene
COLOUR = "#08306b"
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
            axes.plot(line[:, 0], line[:, 1], color=COLOUR, alpha=shade, lw=1.8)
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
    """Animate the whole run in at most 400 frames; the title says how slow the motion is shown.

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
    figure.set_layout_engine("none")  # the axes stay where they are; only the scene and the title are drawn again
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection

    axes = figure.subplots()
    prepare(axes, solution, model)
    lines = axes.add_collection(LineCollection([], colors=COLOUR, linewidths=1.8))
    title, canvas = axes.set_title(" "), FigureCanvasAgg(figure)
    canvas.draw()
    background = canvas.copy_from_bbox(figure.bbox)
    shown, slow = frames_of(solution, fps)

    def frame(k: int) -> np.ndarray:
        canvas.restore_region(background)
        lines.set_segments(model.shape(solution.q[k]))
        title.set_text(f"t = {solution.t[k]:.3f} s{slow}")
        axes.draw_artist(lines)
        axes.draw_artist(title)
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()

    return animation(path, fps, shown, frame)


def frames_of(solution: Any, fps: int, most: int = MAX_FRAMES) -> tuple[np.ndarray, str]:
    """Indices of the records shown, equally spaced in time, and by how much the motion is slowed or hastened."""
    t = solution.t
    span = float(t[-1] - t[0])
    n = int(np.clip(span * fps, MIN_FRAMES, most))
    factor = n / fps / span if span > 0 else 1.0
    return nearest_records(t, n), "" if 0.9 < factor < 1.1 else f"  (time x {1 / factor:.2g})"


def nearest_records(t: np.ndarray, n: int) -> np.ndarray:
    """Indices of the records nearest to n equally spaced instants."""
    return np.searchsorted(0.5 * (t[1:] + t[:-1]), np.linspace(t[0], t[-1], n))


def scene_model(solution: Solution) -> Any:
    """What is known of a system with a shape, or `InvalidInput`."""
    if solution.described.shape is None:
        raise InvalidInput("this solution has no picture: its model has no shape(q), or it was loaded from a file")
    return solution.described


def prepare(axes: Any, solution: Solution, model: Any) -> None:
    """Equal axes that hold the whole motion, and the ground."""
    shown = np.unique(np.linspace(0, len(solution.t) - 1, 200).astype(int))
    points = np.concatenate([line for k in shown for line in model.shape(solution.q[k])])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.08 * (high - low).max() or 1.0
    for line in model.outline() if model.outline else []:
        axes.plot(line[:, 0], line[:, 1], color="grey", lw=1)
    width, height = high - low + 2 * margin
    across = axes.figure.get_figwidth()
    axes.figure.set_size_inches(across, float(np.clip(across * height / width + 1.0, LEAST_HEIGHT, MOST_HEIGHT)))
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
