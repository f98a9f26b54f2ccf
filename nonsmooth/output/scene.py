"""Pictures of planar scenes from a model's ``shape(q)``: polylines in the plane [m]. Needs the extra [plot]."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.output.plots import new_figure

if TYPE_CHECKING:
    from nonsmooth.solution import Solution

MAX_FRAMES = 400


def still(solution: Solution, path: str | Path, instants: int = 6) -> Path:
    """Draw the scene at equally spaced instants, the later the darker."""
    model = scene_model(solution)
    figure = new_figure(7, 6)
    axes = figure.subplots()
    prepare(axes, solution, model)
    times = np.linspace(0, len(solution.t) - 1, instants).astype(int)
    for k, shade in zip(times, np.linspace(0.25, 1.0, instants), strict=True):
        for line in model.shape(solution.q[k]):
            axes.plot(line[:, 0], line[:, 1], color="#08306b", alpha=shade)
    axes.set_title(f"t = {solution.t[0]:.3g} ... {solution.t[-1]:.3g} s, the later the darker", fontsize=10)
    figure.savefig(path, dpi=150)
    return Path(path)


def animate(solution: Solution, path: str | Path, fps: int = 25) -> Path:
    """Write a gif of at most 400 frames over the whole run."""
    from matplotlib.animation import FuncAnimation, PillowWriter

    model = scene_model(solution)
    figure = new_figure(6, 5)
    axes = figure.subplots()
    prepare(axes, solution, model)
    lines = [axes.plot(line[:, 0], line[:, 1], color="#08306b")[0] for line in model.shape(solution.q[0])]
    title = axes.set_title("")
    frames = np.unique(np.linspace(0, len(solution.t) - 1, min(len(solution.t), MAX_FRAMES)).astype(int))

    def draw(k: int) -> list[Any]:
        for drawn, line in zip(lines, model.shape(solution.q[k]), strict=True):
            drawn.set_data(line[:, 0], line[:, 1])
        title.set_text(f"t = {solution.t[k]:.3f} s")
        return [*lines, title]

    FuncAnimation(figure, draw, frames=frames).save(path, writer=PillowWriter(fps=fps))
    return Path(path)


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
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
