"""Figures of a run: time histories, contact forces, modes, energy, and the phase plane where a model has one.

Matplotlib is imported inside the functions. A model may give ``coordinates`` (names and units), and ``phase_axes`` with
``phase_map(x, y) -> (numbers of solutions, {label: field})`` whose zeros are drawn as curves.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nonsmooth.checks.arrays import as_listed, as_name
from nonsmooth.checks.files import FIGURE_ENDINGS, as_place, whole_file
from nonsmooth.drawing.colours import BLUE, ENERGIES, GREY, RED, REGIONS, STORED, STRIPS, cycled
from nonsmooth.drawing.forces import CUT, PEAKLESS, draw_forces, draw_impulses, loads_of
from nonsmooth.drawing.labels import (
    FLAT,
    LETTER,
    columns_for,
    coordinate_label,
    coordinates_of,
    legend_above,
    show_no_rounding,
    spelt,
    velocity_label,
    with_unit,
)
from nonsmooth.errors import InvalidInput, MissingExtra
from nonsmooth.mechanics.description import title_of as title_of_system
from nonsmooth.mechanics.model_system import idle_parameters
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.events import mode_name
from nonsmooth.results.recorded import COORDINATES, EVENTS, IMPULSES, LEDGER, MODES, VELOCITIES, not_recorded

if TYPE_CHECKING:
    import xarray

    from nonsmooth.results.scene_solution import SceneSolution
    from nonsmooth.results.solution import Solution

WIDTH = 5.0  # chosen: of a figure [in]
SAVED_DPI = 150  # chosen: points per inch of a figure that is saved
PHASE_PLANE_MARGIN = 0.2  # chosen: of the orbit's extent, around it in the phase plane
LEDGER_ROUNDING = 1e-12  # chosen: of the largest energy: what changes less is the rounding of a sum of many steps
GRID = 400  # chosen: points of the phase map along each axis
MOST_DRAWN = 20_000  # chosen: drawn of one curve
MAX_NAMES = 8  # chosen: coordinates drawn; a chain has hundreds
HAIR = 2e-3  # chosen: of the run: a mode that lasts less would be thinner than a dot
LETTERS = 14.0  # chosen: of a title, per inch of the figure's width
OF_THE_SWEEP = {"cells", "cells_from_journal", "cells_failed", "interrupted", "points_reached"}  # chosen: no quantities
TITLE_LETTERS = 71  # chosen: of a line of a title, monospace, in the width of a figure
VALUES_SHOWN = 4  # chosen: intervals between numbers along a history
TIMES_SHOWN = 6  # chosen: numbers along the time: short runs have long ones
MAX_STRIPS = 4000  # chosen: rectangles of a mode strip: an accumulation of impacts has more than a screen can show
PIXELS_OF_TIME = 600  # chosen: instants of a picture over space and time
UNDER_LABELS = 4.5  # chosen: of a legend below an axis, in its letters: under the numbers and the label of the axis
BELOW: dict[str, Any] = {"loc": "upper center", "fontsize": LETTER, "frameon": False}
PLANE, ENERGY, FORCES = "phase plane", "energy", "forces"  # code: panels; others are called as what is recorded
PANELS = (PLANE, COORDINATES, VELOCITIES, ENERGY, FORCES, IMPULSES, MODES)  # of a system, whatever happens in a run
FLATTENED = 0.25  # chosen: of the largest work: energies that change less have axes of their own
PHASE_PLANE, HISTORY, STRIP = 4.2, 1.3, 0.28  # chosen: heights [in]


def new_figure(width: float, height: float) -> Any:
    """A Matplotlib figure without pyplot's global state, which a notebook shows."""
    try:
        from nonsmooth.drawing.notebook_figure import NotebookFigure
    except ImportError:
        raise MissingExtra('figures need Matplotlib; install it with pip install "nonsmooth[plot]"') from None
    return NotebookFigure(figsize=(width, height), layout="constrained")


def save_figure(figure: Any, path: str | Path | None) -> Any:
    """The figure, written to ``path`` where one is given; its ending names the format.

    The places of its axes are found once, and it is drawn once: Matplotlib's ``savefig`` does both twice.
    """
    if path is not None:
        from matplotlib.backend_bases import get_registered_canvas_class

        path = as_place("path", path, FIGURE_ENDINGS)
        ending, engine, dpi, canvas = path.suffix[1:], figure.get_layout_engine(), figure.dpi, figure.canvas
        with whole_file(path) as part:
            figure.dpi = SAVED_DPI
            if engine is not None:
                engine.execute(figure)
                figure.set_layout_engine("none")
            try:
                getattr(get_registered_canvas_class(ending)(figure), f"print_{ending}")(part)
            finally:
                figure.dpi = dpi
                figure.set_canvas(canvas)
                if engine is not None:
                    figure.set_layout_engine(engine)
    return figure


def plot_solution(
    solution: Solution, path: str | Path | None = None, panels: Sequence[str] | None = None
) -> Any:  # fmt: skip
    """Draw a run: states, energy, contact forces and modes against time, and the phase plane where the model has one.

    Coordinates of one unit share an axis. Impulses of collisions and seizures stand apart from the forces: see
    `nonsmooth.drawing.forces`. Of many contacts those that carry most have curves; many coordinates are a picture over
    space and time.

    Parameters
    ----------
    solution : Solution
    path : path-like, optional
        Where to save; the ending names the format.
    panels : sequence of str, optional
        Those that are drawn, of "phase plane", "coordinates", "velocities", "energy", "forces", "impulses", "modes";
        all that there are when left out.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidInput
        For a panel that this run does not have.
    MissingExtra
        When Matplotlib is not installed.
    """
    model = solution.system.parameters if solution.system else None
    there = panels_of(solution)
    plane = [PLANE] * (hasattr(model, "phase_map") and {COORDINATES, VELOCITIES, EVENTS} <= set(solution.recorded))
    asked = asked_for(panels, [*plane, *(panel.name for panel in there)])
    has_phase_plane, drawn = PLANE in asked, [panel for panel in there if panel.name in asked]
    if not drawn:
        raise InvalidInput("panels must name a history; the phase plane alone is no figure of a run")
    heights = [panel.height for panel in drawn]
    title = title_of(solution, TITLE_LETTERS)
    over = 0.5 + 0.15 * title.count("\n") + 0.5
    figure = new_figure(WIDTH, sum(heights) + over + PHASE_PLANE * has_phase_plane)
    histories = figure
    if has_phase_plane:
        above, histories = figure.subfigures(2, 1, height_ratios=(PHASE_PLANE, sum(heights) + 0.5))
        draw_phase_plane(above.subplots(), solution, model)
    rows = histories.subplots(len(drawn), 1, sharex=True, height_ratios=heights, squeeze=False)[:, 0]
    for axes, panel in zip(rows, drawn, strict=True):
        panel.draw(axes)
    upright = rows[: len(rows) - (drawn[-1].name == MODES)]
    for axes in upright:
        axes.grid(alpha=0.25)
        axes.yaxis.set_major_formatter("{x:.6g}")
        axes.locator_params(
            axis="y", nbins=VALUES_SHOWN
        )  # as many whatever the height: the layout asks before it is known
    name_times(rows[-1], solution.t)
    figure.align_ylabels(upright)  # the label of the modes lies, and would be pushed over the edge
    set_title(figure, title)
    return save_figure(figure, path)


class Panel(NamedTuple):
    """What is drawn in a row of a figure, and its height [in]."""

    name: str
    draw: partial[None]
    height: float = HISTORY


def asked_for(panels: Sequence[str] | None, there: Sequence[str]) -> list[str]:
    """The names of the panels that are drawn, of those that there are."""
    if panels is None:
        return list(there)
    asked = as_listed("panels", panels, "a list of names such as 'energy'")
    if not asked:
        raise InvalidInput(f"panels must name one at least; there are {', '.join(dict.fromkeys(there))}")
    for name in asked:
        as_name("panel", name, dict.fromkeys(there))
    return asked


def panels_of(solution: Solution) -> list[Panel]:
    """What draws each history: an axis that would be empty is left out.

    Raises
    ------
    InvalidInput
        Where nothing that is drawn was recorded.
    """
    recorded, n_c = solution.recorded, len(solution.described.contacts)
    panels = state_panels(solution)
    panels += energy_panels(solution) if LEDGER in recorded else []
    if n_c and {IMPULSES, EVENTS} <= set(recorded):
        panels += load_panels(solution)
    if n_c and {MODES, EVENTS} <= set(recorded):
        height = max(0.35, STRIP * n_c) if n_c <= 4 else HISTORY
        panels.append(Panel(MODES, partial(draw_modes, solution=solution), height))
    if not panels:
        raise not_recorded("what a figure of the run shows", COORDINATES)
    return panels


def load_panels(solution: Solution) -> list[Panel]:
    """Those of the contact forces and impulses."""
    panels: list[Panel] = []
    loads = loads_of(solution)
    k = thinning(solution)[:-1]
    if loads.has_forces and loads.is_alone:
        panels.append(Panel(FORCES, partial(draw_forces, loads=loads, k=k, kind="normal friction")))
    elif loads.has_forces:
        panels.append(Panel(FORCES, partial(draw_forces, loads=loads, k=k, kind="normal")))
        panels += [Panel(FORCES, partial(draw_forces, loads=loads, k=k, kind="friction"))] * loads.has_friction
    if loads.has_impulses:
        panels.append(Panel(IMPULSES, partial(draw_impulses, loads=loads)))
    return panels


def title_of(solution: Solution, letters: int) -> str:
    """The system, its parameters in lines of so many letters, the integrator, and where an unfinished run stopped."""
    about, idle = solution.about, idle_parameters(solution.system)
    rows = [str(about.get("system", "")), *broken(words_of(about.get("integrator", "")), letters)]
    rows += broken(equations({name: value for name, value in about.items() if name not in idle}), letters)
    rows += unfinished(solution)
    return "\n".join(row for row in rows if row)


def words_of(integrator: str) -> str:
    """An integrator as it is typed, without the options that are left out."""
    return re.sub(r", \w+=(None|False)(?=[,)])", "", str(integrator))


def name_times(axes: Any, t: np.ndarray) -> None:
    """The axis of the time, from the first to the last."""
    axes.set_xlabel("t [s]")
    axes.xaxis.set_major_formatter("{x:.6g}")
    axes.locator_params(axis="x", nbins=TIMES_SHOWN)
    if t[-1] > t[0]:
        axes.set_xlim(t[0], t[-1])


def equations(values: Mapping[str, Any]) -> str:
    """The numbers among the values as "mu = 0.5", each in one piece where the line is broken."""
    return "  ".join(f"{spelt(name)}\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}{value:.4g}" for name, value in values.items()
                     if isinstance(value, int | float))  # fmt: skip


def heading(systems: Sequence[Any], *varied: str) -> str:
    """Name and parameters of the system of a figure, without those that vary; of several what they have in common."""
    first, *others = systems
    rows = [title_of_system(first)] if all(title_of_system(other) == title_of_system(first) for other in others) else []
    idle = {*idle_parameters(first), *varied}
    held = {name: value for name, value in first.parameter_values.items() if name not in idle
            and all(other.parameter_values.get(name) == value for other in others)}  # fmt: skip
    return "\n".join(row for row in [*rows, *broken(equations(held), TITLE_LETTERS)] if row)


def set_title(figure: Any, text: str) -> None:
    """What a figure is of, in letters that tell l from I."""
    figure.suptitle(text, fontsize=LETTER, family="monospace")


def held_fixed(chart: xarray.Dataset, letters: int) -> str:
    """The title of a map: the system and what was held fixed, in lines of so many letters."""
    held = {str(name): value for name, value in chart.attrs.items() if name not in OF_THE_SWEEP}
    rows = [str(chart.attrs.get("system", "")), *broken(equations(held), letters)]
    return "\n".join(row for row in rows if row)


def unfinished(solution: Solution | SceneSolution) -> list[str]:
    """Where a run stopped that did not reach its end."""
    return [] if solution.success else [f"{solution.status.name} at t = {solution.t[-1]:.6g} s"]


def broken(text: str, letters: int) -> list[str]:
    """The text in lines of so many letters; what a no-break space joins stays together."""
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in textwrap.wrap(text, letters)]


def title_rows(title: str, letters: int) -> list[str]:
    """The rows of a title that was given, broken to so many letters where they are longer, no formula among them."""
    joined = re.sub(r"\$[^$]*\$", lambda formula: formula[0].replace(" ", "\N{NO-BREAK SPACE}"), title)
    return [row for given in joined.split("\n") for row in broken(given, letters)]


def state_panels(solution: Solution) -> list[Panel]:
    """Coordinates and velocities, one axis for each unit; a picture over space and time of many with one unit."""
    names = coordinates_of(solution)
    units = list(dict.fromkeys(unit for _, unit in names))
    if len(names) > MAX_NAMES and len(units) == 1:
        rate = f"{units[0]}/s" if units[0] else ""
        labels = {COORDINATES: with_unit("coordinate", units[0]), VELOCITIES: with_unit("velocity", rate)}
        return [
            Panel(kind, partial(draw_over_space, solution=solution, values=values, label=labels[kind]))
            for kind, values, _ in states_of(solution)
        ]
    panels, velocities = [], list(solution.described.velocities)
    for kind, values, label in states_of(solution):
        if kind == VELOCITIES and velocities:
            names, label = velocities, coordinate_label
        for unit in dict.fromkeys(unit for _, unit in names):
            group = [i for i, (_, own) in enumerate(names) if own == unit]
            draw = partial(draw_states, solution=solution, values=values, group=group, names=names, label=label)
            panels.append(Panel(kind, draw))
    return panels


def states_of(solution: Solution) -> list[tuple[str, np.ndarray, Callable[[str, str], str]]]:
    """Coordinates and velocities, as far as they were recorded, and how their axes are named."""
    states: list[tuple[str, np.ndarray, Callable[[str, str], str]]] = []
    if COORDINATES in solution.recorded:
        states.append((COORDINATES, solution.q, coordinate_label))
    if VELOCITIES in solution.recorded:
        states.append((VELOCITIES, solution.u, velocity_label))
    return states


def draw_states(
    axes: Any, solution: Solution, values: np.ndarray, group: list[int], names: list[tuple[str, str]],
    label: Callable[[str, str], str],
) -> None:  # fmt: skip
    """Coordinates or velocities of one unit, eight of them at most."""
    k = thinning(solution)
    shown = [group[i] for i in some_of(len(group))]
    for place, i in enumerate(shown):
        colour, dashes, _ = cycled(place)
        axes.plot(solution.t[k], values[k, i], color=colour, ls=dashes, label=label(names[i][0], ""), lw=1.2)
    several = f"{len(shown)} of {len(group)}" if len(group) > len(shown) else ", ".join(
        label(names[i][0], "") for i in shown
    )  # fmt: skip
    unit = label("", names[group[0]][1]).replace("'", "").strip()
    axes.set_ylabel(f"{several}\n{unit}" if unit else several)
    show_no_rounding(axes, scale_of(solution, values, group))
    if len(shown) > 1:
        legend_above(axes)


def scale_of(solution: Solution, values: np.ndarray, group: list[int]) -> float:
    """The size that changes of coordinates are measured by: how far their greatest speed would go in the run, of
    velocities that speed."""
    if VELOCITIES not in solution.recorded or solution.described.velocities:
        return float(np.abs(values[:, group]).max(initial=0.0))
    speed = float(np.abs(solution.u[:, [i for i in group if i < solution.u.shape[1]]]).max(initial=0.0))
    return speed if values is solution.u else speed * float(solution.t[-1] - solution.t[0])


def draw_over_space(axes: Any, solution: Solution, values: np.ndarray, label: str) -> None:
    """Time to the right, the number of the coordinate upwards, the value as a colour."""
    t = solution.t
    k = np.unique(nearest_records(t, PIXELS_OF_TIME))
    shown = values[k].T
    size = float(np.quantile(np.abs(shown), PEAKLESS))
    is_cut = size > 0 and np.abs(shown).max() > CUT * size
    limits = {"vmin": max(shown.min(), -CUT * size), "vmax": min(shown.max(), CUT * size)} if is_cut else {}
    mesh = axes.pcolormesh(t[k], np.arange(len(shown)), shown, shading="nearest", cmap="cividis", rasterized=True,
                           **limits)  # fmt: skip
    ends = {(True, True): "both", (True, False): "min", (False, True): "max", (False, False): "neither"}
    low, high = bool(is_cut and shown.min() < -CUT * size), bool(is_cut and shown.max() > CUT * size)
    axes.figure.colorbar(mesh, ax=axes, pad=0.01, extend=ends[low, high], label=label)
    axes.set_ylabel("number of the\ncoordinate")


def energy_panels(solution: Solution | SceneSolution) -> list[Panel]:
    """Energies and works, all since the start; of a changing mass and its gyroscopic force, which cancel, the sum.

    Works that grow with the time, as those of a belt, would flatten the energies: these have axes of their own then.
    Of the terms that change: rounding of the energies, and of the largest change, is none.
    """
    ledger = dict(solution.ledger)
    if "mass" in ledger:
        ledger["force, changing mass"] = ledger.pop("force") + ledger.pop("mass")
    spans = {name: float(np.ptp(ledger[name])) for name in ENERGIES if name in ledger}
    size = max(float(np.abs(values).max()) for values in ledger.values())
    least = max(FLAT * max(spans.values()), LEDGER_ROUNDING * size)
    changing = [name for name, span in spans.items() if span > least]
    stored, works = ([name for name in changing if (name in STORED) == is_stored] for is_stored in (True, False))
    is_flat = bool(stored and works) and max(spans[k] for k in stored) < FLATTENED * max(spans[k] for k in works)
    drawn = partial(draw_ledger, t=solution.t, ledger=ledger, k=thinning(solution))
    if is_flat:
        return [Panel(ENERGY, partial(drawn, names=stored)), Panel(ENERGY, partial(drawn, names=works, word="work"))]
    return [Panel(ENERGY, partial(drawn, names=changing))]


def draw_ledger(
    axes: Any, t: np.ndarray, ledger: Mapping[str, np.ndarray], k: np.ndarray, names: list[str],
    word: str = "change of\nenergy",
) -> None:  # fmt: skip
    """Terms at the records k."""
    for name in names:
        colour, dashes = ENERGIES[name]
        label = f"{name} energy" if name in STORED else f"work: {name}"
        axes.plot(t[k], ledger[name][k] - ledger[name][0], label=label, color=colour, ls=dashes, lw=1.3)
    axes.set_ylabel(f"{word} [J]")
    if names:
        legend_above(axes)
    else:
        axes.plot(t[[0, -1]], [0.0, 0.0], color=GREY, lw=1.0)
        axes.text(0.5, 0.6, "no energy changes and no work is done", transform=axes.transAxes, ha="center", fontsize=9)


def own_name(name: str, i: int) -> str:
    """The name that the user gave a contact, or nothing."""
    return "" if name == f"contact {i}" else name


def draw_modes(axes: Any, solution: Solution) -> None:
    """A strip for each contact, coloured by its mode, with a mark above it at each paradox."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    n_c = solution.mode.shape[1]
    code = 3 * solution.mode + np.sign(solution.slip) + 1
    met = {divmod(int(value), 3) for value in np.unique(code[1:])}
    for i in range(n_c):
        draw_strip(axes, solution.t, code[1:, i], i, n_c)
    axes.set_ylim(-0.5, n_c - 0.5 + 0.35 * bool(solution.paradoxes))
    names = solution.described.contacts
    axes.set_yticks(
        range(n_c) if 1 < n_c <= 4 else [], [own_name(names[i], i) or str(i) for i in range(n_c)][: 4 * (1 < n_c <= 4)]
    )
    one = f"mode of\n{names[0]}" if own_name(names[0], 0) else "mode"
    label = one if n_c == 1 else "mode of\ncontact" if n_c <= 4 else f"modes of\n{n_c} contacts"
    if n_c <= 4:
        axes.set_ylabel(label, rotation=0, ha="right", va="center")  # upright it is longer than strips are high
    else:
        axes.set_ylabel(label)
    handles: list[Any] = [
        Patch(color=colour, label=mode_name(mode, sign))
        for (mode, sign), colour in STRIPS.items()
        if (mode, sign + 1) in met
    ]
    for has_none, marker, label in ((True, "v", "inconsistent"), (False, "|", "indeterminate from")):
        times = [event.t for event in solution.paradoxes if (event.n_solutions == 0) == has_none]
        if times:
            style: dict[str, Any] = {"marker": marker, "color": RED, "ls": "", "ms": 6}
            axes.plot(times, np.full(len(times), n_c - 0.3), clip_on=False, zorder=5, **style)
            handles.append(Line2D([], [], label=label, **style))
    axes.legend(handles=handles, bbox_to_anchor=(0.5, 0.0), borderaxespad=UNDER_LABELS,
                ncols=columns_for(handles), **BELOW)  # fmt: skip


def draw_strip(axes: Any, t: np.ndarray, code: np.ndarray, i: int, n_c: int) -> None:
    """The intervals of equal mode of one contact."""
    if not len(code):
        return
    first = np.concatenate(([0], np.flatnonzero(np.diff(code)) + 1))
    last = np.append(first[1:], len(code))
    k = np.unique(np.linspace(0, len(first) - 1, min(len(first), MAX_STRIPS)).astype(int))
    lasting = t[last[k]] - t[first[k]]
    is_hair = lasting < HAIR * (t[-1] - t[0])
    order = np.argsort(is_hair, kind="stable")  # hairs are drawn last, with an edge that makes them visible
    colours = [STRIPS[(ContactMode(int(c) // 3), int(c) % 3 - 1)] for c in code[first[k[order]]]]
    axes.broken_barh(
        np.column_stack((t[first[k]], lasting))[order], (i - 0.45, 0.9) if n_c <= 20 else (i - 0.5, 1.0),
        facecolors=colours, edgecolors=colours, linewidths=0.7 * is_hair[order] * (n_c <= 20),
    )  # fmt: skip


def draw_phase_plane(axes: Any, solution: Solution, model: Any) -> None:
    """The orbit over the map of the numbers of solutions, with the curves that bound its regions."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    i, j = model.phase_axes
    x, y = solution.q[:, i], solution.u[:, j]
    speed = float(np.abs(solution.u[:, i]).max()) if i < solution.u.shape[1] else 0.0
    floors = speed * float(solution.t[-1] - solution.t[0]), float(np.abs(y).max())
    grid_x, grid_y = (np.linspace(*extent(v, floor), GRID) for v, floor in zip((x, y), floors, strict=True))
    counts, fields = model.phase_map(*np.meshgrid(grid_x, grid_y))
    handles: list[Any] = []
    for n, (label, colour, hatch) in enumerate(REGIONS):
        if (counts == n).any():
            area = axes.contourf(grid_x, grid_y, counts == n, levels=[0.5, 1.5], colors=[colour], hatches=[hatch])
            area.set_edgecolor("#a0a0a0")
            area.set_linewidth(0)
            handles.append(Patch(facecolor=colour, hatch=hatch, edgecolor="#a0a0a0", label=f"{label} while it slides"))
    for (label, field), style in zip(fields.items(), ("-", "--", ":"), strict=False):
        if field.min() < 0 < field.max():
            axes.contour(grid_x, grid_y, field, levels=[0.0], colors="black", linestyles=style, linewidths=1.4)
            handles.append(Line2D([], [], color="black", ls=style, label=label))
    axes.plot(x, y, color=BLUE, lw=1.8)
    axes.plot(x[0], y[0], "o", color=BLUE, ms=6)
    handles.append(Line2D([], [], color=BLUE, marker="o", ms=6, label="motion from its start"))
    jumps = [np.searchsorted(solution.t, event.t, "right") - 1 for event in solution.paradoxes if not event.n_solutions]
    if jumps:
        axes.plot(x[jumps], y[jumps], "v", color=RED, ms=7, mec="white", zorder=5)
        handles.append(Line2D([], [], color=RED, marker="v", ls="", ms=7, label="impact without collision from here"))
    names = coordinates_of(solution)
    axes.set_xlabel(coordinate_label(*names[i]))
    axes.set_ylabel(velocity_label(*names[j]))
    axes.locator_params(axis="x", nbins=6)
    axes.legend(handles=handles, bbox_to_anchor=(0.5, 0.0), borderaxespad=UNDER_LABELS, ncols=2, **BELOW)


def some_of(n: int) -> np.ndarray:
    """All of n numbers, or eight that are equally spaced."""
    return np.unique(np.linspace(0, n - 1, min(n, MAX_NAMES)).astype(int))


def extent(values: np.ndarray, scale: float = 0.0) -> tuple[float, float]:
    """The range of the values with a margin on both sides; what changes less than rounding does is given the scale."""
    low, high = float(values.min()), float(values.max())
    is_flat = high - low < FLAT * max(scale, abs(low), abs(high))
    margin = PHASE_PLANE_MARGIN * (scale if is_flat else high - low) or 1.0
    return low - margin, high + margin


def thinning(solution: Solution | SceneSolution) -> np.ndarray:
    """Indices of the records that are drawn."""
    n = len(solution.t)
    return np.unique(np.linspace(0, n - 1, min(n, MOST_DRAWN)).astype(int))


def nearest_records(t: np.ndarray, n: int) -> np.ndarray:
    """Indices of the records nearest to n equally spaced instants."""
    return np.searchsorted(0.5 * (t[1:] + t[:-1]), np.linspace(t[0], t[-1], n))


def is_geometric(values: np.ndarray) -> bool:
    """Whether equal ratios, and not equal steps, lie between the values."""
    if values.dtype.kind not in "fi" or len(values) < 3 or not (values > 0).all():
        return False
    return bool(np.ptp(np.diff(np.log(values))) < 1e-6 < np.ptp(np.diff(values)) / np.abs(values).max())
