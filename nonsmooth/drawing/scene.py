"""Pictures of planar scenes from a model's ``shape(q)``: polylines in the plane [m]. Needs the extra [plot]."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.checks.arrays import as_count
from nonsmooth.checks.files import as_place, whole_file
from nonsmooth.drawing.plots import new_figure, save_figure
from nonsmooth.errors import InvalidInput, MissingExtra

MAX_FPS = 100  # defined: frames a second: a gif says their length in hundredths of a second
ANIMATION_ENDINGS = (".gif", ".webp")

if TYPE_CHECKING:
    from nonsmooth.results.solution import Solution

MAX_FRAMES = 400  # chosen: a frame takes about 10 ms
MIN_FRAMES = 25  # chosen: of an animation, however short its motion is
MAX_INSTANTS = 8  # chosen: named in the title of a picture
FIGURE_WIDTH, LEAST_HEIGHT, MOST_HEIGHT = 6.0, 2.5, 6.0  # chosen: of a figure [in]; its height follows the scene
COLOUR = "#08306b"
COLOURS = 64  # chosen: of a gif's palette: shades of the lines and of the letters, taken from the first frame


def picture(solution: Solution, path: str | Path | None = None, n: int = 5) -> Any:
    """Draw the scene at the records nearest to n equally spaced instants, the later the darker.

    Parameters
    ----------
    solution : Solution
    path : path-like, optional
        Where to save; the ending names the format.
    n : int
        Number of instants.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidInput
        When the model has no ``shape(q)``.
    MissingExtra
        When Matplotlib is not installed.
    """
    model = scene_model(solution)
    figure = new_figure(FIGURE_WIDTH, MOST_HEIGHT)
    axes = figure.subplots()
    prepare(axes, solution, model)
    if as_count("n", n) > MAX_FRAMES:
        raise InvalidInput(f"n must not exceed {MAX_FRAMES} instants; got {n}")
    shown = nearest_records(solution.t, n)
    for k, shade in zip(shown, np.linspace(0.2 if n > 1 else 1.0, 1.0, n), strict=True):
        for line in model.shape(solution.q[k]):
            axes.plot(line[:, 0], line[:, 1], color=COLOUR, alpha=shade, lw=1.8)
    instants = ", ".join(f"{t:.3g}" for t in solution.t[shown[:MAX_INSTANTS]])
    instants += f", ... {solution.t[shown[-1]]:.3g}" if n > MAX_INSTANTS else ""
    axes.set_title(f"t = {instants} s{', the later the darker' if n > 1 else ''}", fontsize=10)
    return save_figure(figure, path)


def animate(solution: Solution, path: str | Path, fps: int = 25) -> Path:
    """Write a gif (or webp) over the whole run, in at most 400 frames; its title says how slow the motion is shown.

    Parameters
    ----------
    solution : Solution
    path : path-like
    fps : int
        Frames a second.

    Returns
    -------
    Path

    Raises
    ------
    InvalidInput
        When the model has no ``shape(q)``, or the ending is neither .gif nor .webp.
    MissingExtra
        When Matplotlib or Pillow is not installed.
    """
    path, fps = as_place("path", path, ANIMATION_ENDINGS), as_count("fps", fps)
    if fps > MAX_FPS:
        raise InvalidInput(f"fps must not exceed {MAX_FPS}, the fastest that a gif shows; got {fps}")
    model = scene_model(solution)
    figure = new_figure(FIGURE_WIDTH, MOST_HEIGHT)
    figure.set_layout_engine("none")  # the axes stay where they are; only the scene and the title are drawn again
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.collections import LineCollection
        from PIL import Image
    except ImportError:
        raise MissingExtra('animations need Pillow; install it with pip install "nonsmooth[plot]"') from None
    axes = figure.subplots()
    prepare(axes, solution, model)
    lines = axes.add_collection(LineCollection([], colors=COLOUR, linewidths=1.8))
    title, canvas = axes.set_title(" "), FigureCanvasAgg(figure)
    canvas.draw()
    background = canvas.copy_from_bbox(figure.bbox)
    shown, slow = frames_of(solution, fps)

    def frame(k: int) -> Any:
        canvas.restore_region(background)
        lines.set_segments(model.shape(solution.q[k]))
        title.set_text(f"t = {solution.t[k]:.3f} s{slow}")
        axes.draw_artist(lines)
        axes.draw_artist(title)
        return Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")

    palette = frame(shown[0]).quantize(COLOURS, Image.Quantize.FASTOCTREE)
    frames = (frame(k).quantize(palette=palette, dither=Image.Dither.NONE) for k in shown)
    with whole_file(path) as part:
        duration = round(1000 / fps)
        next(frames).save(part, path.suffix[1:], save_all=True, append_images=frames, duration=duration, loop=0)
    return path


def frames_of(solution: Solution, fps: int) -> tuple[np.ndarray, str]:
    """Indices of the records shown, equally spaced in time, and by how much the motion is slowed or hastened."""
    span = float(solution.t[-1] - solution.t[0])
    n = int(np.clip(span * fps, MIN_FRAMES, MAX_FRAMES))
    factor = n / fps / span if span > 0 else 1.0
    return nearest_records(solution.t, n), "" if 0.9 < factor < 1.1 else f"  (time x {1 / factor:.2g})"


def nearest_records(t: np.ndarray, n: int) -> np.ndarray:
    """Indices of the records nearest to n equally spaced instants."""
    return np.searchsorted(0.5 * (t[1:] + t[:-1]), np.linspace(t[0], t[-1], n))


def scene_model(solution: Solution) -> Any:
    """The model that knows its shape, or `InvalidInput`."""
    model = solution.system.parameters if solution.system else None
    if not hasattr(model, "shape"):
        raise InvalidInput("this solution has no picture: its model has no shape(q), or it was loaded from a file")
    return model


def prepare(axes: Any, solution: Solution, model: Any) -> None:
    """Equal axes that hold the whole motion, and the ground."""
    shown = np.unique(np.linspace(0, len(solution.t) - 1, 200).astype(int))
    points = np.concatenate([line for k in shown for line in model.shape(solution.q[k])])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.08 * (high - low).max() or 1.0
    for line in model.outline() if hasattr(model, "outline") else []:
        axes.plot(line[:, 0], line[:, 1], color="grey", lw=1)
    width, height = high - low + 2 * margin
    axes.figure.set_size_inches(
        FIGURE_WIDTH, float(np.clip(FIGURE_WIDTH * height / width + 1.0, LEAST_HEIGHT, MOST_HEIGHT))
    )
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
