"""The figure of a run of a scene: the bodies at its start and its end, then energies, speeds, contacts and what the
solver left, over the time.

Speeds are those of the centres of mass; of many bodies the fastest and the middle one are drawn. What moves less than
rounding lets it, measured by sqrt(g L) of the picture's size L, is drawn at rest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawing.colours import BLACK, cycled
from nonsmooth.drawing.labels import legend_above, show_no_rounding
from nonsmooth.drawing.plots import (
    ENERGY,
    HISTORY,
    TITLE_LETTERS,
    WIDTH,
    Panel,
    asked_for,
    broken,
    energy_panels,
    equations,
    name_times,
    new_figure,
    save_figure,
    set_title,
    thinning,
    unfinished,
    words_of,
)
from nonsmooth.drawing.scene_figures import arranged, draw_instants, extent_of
from nonsmooth.errors import InvalidInput
from nonsmooth.results.recorded import BODIES, CONTACTS, LEDGER, not_recorded
from nonsmooth.scenes.elements import Kind

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

MOST_PICTURED = 5000  # chosen: bodies that are drawn unasked: a picture takes a second
PICTURE_HEIGHTS = 1.6, 3.6  # chosen: least and greatest height of the pictures [in]
FEW = 4  # chosen: bodies with a curve each
NAME = 24  # chosen: letters of a body's name in a legend
SPEEDS, ACCURACY = "speeds", "accuracy"  # code: panels
PANELS = (BODIES, ENERGY, SPEEDS, CONTACTS, ACCURACY)  # of a scene, whatever is recorded
RANKED = (("fastest", 1.0), ("middle", 0.5))  # chosen: quantiles of the speeds of many bodies


def plot_scene(
    solution: SceneSolution, path: str | Path | None = None, panels: Sequence[str] | None = None
) -> Any:  # fmt: skip
    """Draw the bodies at the start and at the end, and energies, speeds, contacts, residual and penetration over time.

    Parameters
    ----------
    solution : SceneSolution
    path : path-like, optional
        Where to save; the ending names the format.
    panels : sequence of str, optional
        Those that are drawn, of "bodies", "energy", "speeds", "contacts", "accuracy"; all that there are when left out.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidInput
        Where neither bodies nor energies were recorded, and for a panel that this run does not have.
    MissingExtra
        When Matplotlib is not installed.
    """
    kept = solution.recorded
    if not {BODIES, LEDGER} & set(kept):
        raise not_recorded("what a figure of the run shows", BODIES)
    there = energy_panels(solution) if LEDGER in kept else []
    if BODIES in kept:
        there += [Panel(SPEEDS, partial(draw_speeds, solution=solution, is_spin=is_spin)) for is_spin in (False, True)]
    there += [Panel(CONTACTS, partial(draw_contacts, solution=solution))] if CONTACTS in kept else []
    there.append(Panel(ACCURACY, partial(draw_accuracy, solution=solution)))
    is_pictured = solution.scene is not None and BODIES in kept and len(solution.names) <= MOST_PICTURED
    asked = asked_for(panels, [*[BODIES] * is_pictured, *(panel.name for panel in there)])
    drawn = [panel for panel in there if panel.name in asked]
    if not drawn:
        raise InvalidInput("panels must name a history; bodies alone are what picture() draws")
    heights = [HISTORY] * len(drawn)
    figure, below = new_figure(WIDTH, sum(heights) + 1.2), None
    if BODIES in asked:
        extent, records = extent_of(solution), np.unique([0, len(solution.t) - 1])
        rows, columns, height = arranged(extent, len(records), WIDTH)
        height = float(np.clip(height, *PICTURE_HEIGHTS))
        figure.set_size_inches(WIDTH, sum(heights) + 1.2 + height)
        above, below = figure.subfigures(2, 1, height_ratios=(height, sum(heights) + 0.6))
        draw_instants(above, solution, records, extent, rows, columns)
    places = (below or figure).subplots(len(drawn), 1, sharex=True, squeeze=False)[:, 0]
    for axes, panel in zip(places, drawn, strict=True):
        panel.draw(axes)
        axes.grid(alpha=0.25)
        if axes.get_yscale() == "linear":
            axes.yaxis.set_major_formatter("{x:.6g}")
    name_times(places[-1], solution.t)
    figure.align_ylabels(places)
    set_title(figure, title_of(solution))
    return save_figure(figure, path)


def title_of(solution: SceneSolution) -> str:
    """The scene, the integrator, parameters, and where an unfinished run stopped."""
    scene = solution.about["scene"].removeprefix("Scene(").removesuffix(")")
    options = broken(words_of(solution.about["integrator"]), TITLE_LETTERS)
    numbers = broken(equations(solution.about), TITLE_LETTERS)
    return "\n".join([*broken(scene, TITLE_LETTERS), *options, *numbers, *unfinished(solution)])


def draw_speeds(axes: Any, solution: SceneSolution, is_spin: bool) -> None:
    """Those of the bodies that are free: of the centres of mass, or of the rotations."""
    values = np.asarray(solution.spin if is_spin else solution.velocity)
    sizes = np.abs(values) if values.ndim == 2 else np.linalg.norm(values, axis=2)
    free = list(range(sizes.shape[1]))
    if solution.scene is not None:
        free = [body.index for body in solution.bodies if body.kind is Kind.DYNAMIC] or free
    k = thinning(solution)
    curves = {solution.names[i]: sizes[:, i] for i in free}
    if len(free) > FEW:
        curves = {f"{word} of {len(free)}": np.quantile(sizes[:, free], part, axis=1) for word, part in RANKED}
    for place, (name, speed) in enumerate(curves.items()):
        colour, dashes, _ = cycled(place)
        label = name if len(name) <= NAME else f"{name[:NAME]}..."
        axes.plot(solution.t[k], speed[k], color=colour, ls=dashes, lw=1.2, label=label)
    axes.set_ylabel("rotation\n[rad/s]" if is_spin else "speed\n[m/s]")
    show_no_rounding(axes, natural_speed(solution, is_spin))
    legend_above(axes)


def natural_speed(solution: SceneSolution, is_spin: bool) -> float:
    """Of a fall through the picture, sqrt(g L), and as a rotation sqrt(g/L); 0 where the scene is not known."""
    if solution.scene is None:
        return 0.0
    low, high = extent_of(solution)
    length, gravity = float((high - low).max()), float(np.linalg.norm(solution.scene.gravity))
    return math.sqrt(gravity / length if is_spin else gravity * length)


def draw_contacts(axes: Any, solution: SceneSolution) -> None:
    """How many contacts carry a load, and how many are near enough to be looked at, after the first step."""
    columns = solution.all_contacts
    loaded = np.concatenate(([0], np.cumsum((columns.P * columns.normal).sum(axis=1) > 0)))[columns.offsets]
    since = min(1, len(solution.t) - 1)  # before the first step no contact was looked for
    for place, (counts, label) in enumerate(((np.diff(loaded), "loaded"), (np.diff(columns.offsets), "near"))):
        colour, dashes, _ = cycled(place)
        axes.step(solution.t[since:], counts[since:], where="pre", color=colour, ls=dashes, lw=1.2, label=label)
    axes.set_ylabel("number of\ncontacts")
    axes.set_ylim(bottom=0)
    axes.yaxis.get_major_locator().set_params(integer=True)
    legend_above(axes)


def draw_accuracy(axes: Any, solution: SceneSolution) -> None:
    """The worst residual and the deepest penetration of the steps since the record before."""
    is_rigid = solution.stats.springs is None
    tiny, units = np.finfo(float).tiny, []
    kinds = (("residual", "-", solution.residual),) * is_rigid + (("penetration", "m", solution.penetration),)
    for place, (name, unit, values) in enumerate(kinds):
        shown = np.where(values > tiny, values, np.nan)
        if np.isfinite(shown).any():
            colour, dashes, _ = cycled(place)
            axes.semilogy(solution.t, shown, color=colour, ls=dashes, lw=1.2, label=name)
            units.append(f"{name} [{unit}]")
    if is_rigid:
        axes.axhline(solution.stats.tol, color=BLACK, lw=1.0, ls=":", label="residual asked for")
        axes.set_yscale("log")
    axes.set_ylabel("\n".join(units) or "penetration [m]")
    if units:
        legend_above(axes)
