"""Work-precision diagrams: error over wall time and over force evaluations, one row of axes for each scene.

Matplotlib is imported inside the functions.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawing.colours import CYCLE, MARKERS
from nonsmooth.drawing.labels import LETTER
from nonsmooth.drawing.plots import WIDTH, new_figure, save_figure

if TYPE_CHECKING:
    from nonsmooth.studies.work_precision_result import WorkPrecision

PANELS = {"wall_time": ("wall time [ms]", 1e3), "evaluations": ("force evaluations [-]", 1.0)}
LEAST = 1e-16  # chosen: smaller errors are drawn here: rounding


def plot_work_precision(study: WorkPrecision, path: str | Path | None = None) -> Any:
    """Draw a work-precision study.

    Parameters
    ----------
    study : WorkPrecision
    path : path-like, optional
        Where to save; the ending names the format.

    Returns
    -------
    matplotlib.figure.Figure
    """
    n = len(study.scenes)
    figure = new_figure(WIDTH, 2.5 * n + 1.0)
    axes = figure.subplots(n, 2, squeeze=False, sharey=True)
    for k, scene in enumerate(study.scenes):
        left = axes[k]
        for place, cost in zip(left, PANELS, strict=False):
            draw_scene(place, study, scene, cost)
        left[0].set_title(scene, loc="left", fontsize=10)
        left[0].set_ylabel("error of the\npositions [-]")
    handles = {}
    for place in axes.ravel():
        handles.update({label: line for line, label in zip(*place.get_legend_handles_labels(), strict=True)})
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, fontsize=LETTER, frameon=False)
    figure.suptitle(study.title, fontsize=9)
    return save_figure(figure, path)


def draw_scene(axes: Any, study: WorkPrecision, scene: str, cost: str) -> None:
    """The curves of one scene; what cannot be told from the error of the reference is shaded."""
    label, factor = PANELS[cost]
    for j, method in enumerate(study.methods):
        errors, costs = study.curve(scene, method, cost)
        known = np.isfinite(costs) & (costs > 0)
        if not known.any():
            continue
        axes.loglog(
            factor * costs[known], np.maximum(errors[known], LEAST), MARKERS[j % len(MARKERS)] + "-",
            color=CYCLE[j % len(CYCLE)], ms=4, lw=1, label=method,
        )  # fmt: skip
    floor = study.floor_of(scene)
    if floor > 0:
        axes.axhspan(LEAST / 10, floor, color="#eeeeee", zorder=0, label="not told from the reference")
    axes.set(xlabel=label, ylim=(LEAST / 2, 2.0))
    axes.set_yticks([1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0])
    axes.grid(True, which="major", color="#e6e6e6")
