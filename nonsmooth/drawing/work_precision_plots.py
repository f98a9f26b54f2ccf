"""Work-precision diagrams: error over wall time or over force evaluations, a panel a scene.

Matplotlib is imported inside the functions.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawing.colours import CYCLE, MARKERS
from nonsmooth.drawing.labels import LETTER
from nonsmooth.drawing.plots import WIDTH, new_figure, save_figure
from nonsmooth.errors import InvalidInput, shown

if TYPE_CHECKING:
    from nonsmooth.studies.work_precision_result import WorkPrecision

PANELS = {"wall_time": ("wall time [ms]", 1e3), "evaluations": ("force evaluations [-]", 1.0)}
COLUMNS = 2  # chosen: panels in a row
ROW = 1.9  # chosen: height of a row of panels [in]
LEAST = 1e-16  # chosen: smaller errors are drawn here: rounding


def plot_work_precision(study: WorkPrecision, path: str | Path | None = None, cost: str | None = None) -> Any:
    """Draw a work-precision study, a panel a scene.

    Parameters
    ----------
    study : WorkPrecision
    path : path-like, optional
        Where to save; the ending names the format.
    cost : str, optional
        ``"wall_time"`` or ``"evaluations"`` of the forces; without it both of one scene, wall times of several.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidInput
        When the cost is none of the two.
    """
    if cost is not None and cost not in PANELS:
        raise InvalidInput(f"cost must be one of {', '.join(map(repr, PANELS))}; got {shown(cost)}")
    scenes, costs = study.scenes, [cost] if cost else list(PANELS) if len(study.scenes) == 1 else ["wall_time"]
    panels = [(scene, cost) for scene in scenes for cost in costs]
    rows = -(-len(panels) // COLUMNS)
    figure = new_figure(WIDTH, ROW * rows + 1.2)
    places = figure.subplots(rows, COLUMNS, squeeze=False, sharey=True).ravel()
    for place, (scene, kind) in zip(places, panels, strict=False):
        draw_scene(place, study, scene, kind)
        place.set_title(scene, loc="left", fontsize=9)
    for place in places[::COLUMNS]:
        place.set_ylabel("error of the\npositions [-]")
    for place in places[len(panels) :]:
        place.remove()
    handles = {}
    for place in places[: len(panels)]:
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
