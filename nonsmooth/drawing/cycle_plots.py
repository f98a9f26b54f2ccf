"""Figures of cycles: phase planes with their phases, branches along a parameter, waterfalls, bifurcation diagrams.

Matplotlib is imported inside the functions. Every function returns the figure, and saves it where a path is given.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawing.colours import BLUE, CYCLE, RED, STRIPS, STYLES, cycled
from nonsmooth.drawing.labels import (
    LETTER,
    columns_for,
    coordinate_label,
    coordinates_of,
    legend_above,
    parameter_label,
    velocity_label,
    with_unit,
)
from nonsmooth.drawing.plots import WIDTH, heading, new_figure, save_figure, set_title

CHANGE_LETTERS = 62  # chosen: of a line that lists the changes of a branch

if TYPE_CHECKING:
    from nonsmooth.cycles.cycle import CyclePhase, LimitCycle
    from nonsmooth.cycles.cycle_branch import CycleBranch
    from nonsmooth.studies.bifurcation_diagram import BifurcationDiagram


def plot_cycle(cycle: LimitCycle, path: str | Path | None = None) -> Any:
    """The phase plane of every coordinate, each phase in the colour of its contacts' mode, jumps dotted."""
    n = cycle.system.n_q
    columns = min(n, 2)
    rows = -(-n // columns)
    figure = new_figure(WIDTH, 1.0 + rows * (3.6 if columns == 1 else 2.6))
    planes = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in planes[n:]:
        axes.remove()
    labels = list(dict.fromkeys(phase.label for phase in cycle.phases))
    size = len(cycle.t) // len(cycle.phases)
    for j, (axes, named) in enumerate(zip(planes, coordinates_of(cycle.system), strict=False)):
        for k, phase in enumerate(cycle.phases):
            part = slice(k * size, (k + 1) * size)
            shade, style = look(phase, labels)
            axes.plot(cycle.q[part, j], cycle.u[part, j], color=shade, ls=style, lw=2.2)
            axes.plot(phase.q[j], phase.u[j], "o", color="black", ms=3.5, zorder=5)
            if phase.jump is not None:
                draw_jump(axes, cycle, part.stop - 1, j)
        axes.set_xlabel(coordinate_label(*named))
        axes.set_ylabel(velocity_label(*named))
        axes.locator_params(axis="x", nbins=5 if columns == 1 else 3)
        axes.grid(alpha=0.25)
    handles = phase_handles(cycle, labels)
    columns = columns_for(handles)
    figure.legend(
        handles=handles, loc="outside lower center", ncols=columns, frameon=False, fontsize=LETTER, handlelength=3
    )
    largest = f"{np.abs(cycle.multipliers).max():.4g}" if cycle.multipliers.size else "none"
    found = f"period {cycle.period:.9g} s, largest multiplier {largest}"
    set_title(figure, "\n".join(filter(None, [heading([cycle.system]), found])))
    return save_figure(figure, path)


def draw_jump(axes: Any, cycle: LimitCycle, last: int, j: int) -> None:
    """From the last state of a phase to the first of the next: an impact, with a collision or without."""
    after = (last + 1) % len(cycle.t)
    axes.plot([cycle.q[last, j]] * 2, [cycle.u[last, j], cycle.u[after, j]], color=RED, ls=":", lw=1.4, gid="jump")


def phase_handles(cycle: LimitCycle, labels: list[str]) -> list[Any]:
    """The legend of a cycle."""
    from matplotlib.lines import Line2D

    first = {phase.label: phase for phase in reversed(cycle.phases)}
    looks = {label: look(first[label], labels) for label in labels}
    handles = [Line2D([], [], color=shade, ls=style, lw=2.2, label=label) for label, (shade, style) in looks.items()]
    if any(phase.jump is not None for phase in cycle.phases):
        handles.append(Line2D([], [], color=RED, ls=":", lw=1.4, label="impact"))
    return handles


def look(phase: CyclePhase, labels: list[str]) -> tuple[str, str]:
    """Colour and dashes: of the mode of the contact, dashed where it is guided and pulled; of several contacts those of
    the phase's place in the legend."""
    if len(phase.states) > 1:
        return cycled(labels.index(phase.label))[:2]
    if not phase.states:
        return BLUE, STYLES[0]
    (state,) = phase.states
    return STRIPS[state.mode, state.slip], STYLES[state.normal < 0]


def plot_branch(
    branches: CycleBranch | Mapping[str, CycleBranch],
    path: str | Path | None = None,
    label: str = "",
    coordinate: int | str = 0,
) -> Any:
    """Amplitude, period and stick duration along the parameter; unstable cycles dashed, changes as vertical lines.

    Where sticking ends at a change of the phases, its duration goes to zero there.
    """
    family = branches if isinstance(branches, Mapping) else {"": branches}
    first = next(iter(family.values()))
    system = first.cycles[0].system
    coordinate = system.described.coordinate(coordinate)
    figure = new_figure(WIDTH, 6.4)
    rows = figure.subplots(3, 1, sharex=True)
    for k, (name, branch) in enumerate(family.items()):
        stable = np.array([cycle.is_stable for cycle in branch.cycles])
        curves = [(branch.values, part, stable) for part in (branch.amplitudes[:, coordinate], branch.periods)]
        for axes, (x, y, of_stable) in zip(rows, [*curves, stick_with_ends(branch, stable)], strict=True):
            for is_shown, style in ((of_stable, "-"), (~of_stable, "--")):
                if is_shown.any():
                    axes.plot(x, np.where(is_shown, y, np.nan), style, color=CYCLE[k % len(CYCLE)], lw=1.6,
                              label=name if style == "-" and name else None)  # fmt: skip
        draw_changes(rows, branch)
    name, unit = coordinates_of(system)[coordinate]
    rows[0].set_ylabel(with_unit(f"(max - min)/2\nof {name}", unit))
    rows[1].set_ylabel("period [s]")
    rows[2].set_ylabel("stick [s]")
    rows[2].set_ylim(bottom=0.0)
    rows[2].set_xlabel(label or parameter_label(first.parameter, system.parameters))
    for axes in rows:
        axes.grid(alpha=0.25)
        axes.yaxis.set_major_formatter("{x:.6g}")
    figure.align_ylabels(rows)
    if len(family) > 1:
        legend_above(rows[0])
    set_title(figure, heading([one.cycles[0].system for one in family.values()], first.parameter))
    return save_figure(figure, path)


def draw_changes(rows: Any, branch: CycleBranch) -> None:
    """A line at each change, or a strip where it is known to lie between two values only, with its kind in the legend
    of the period."""
    for axes in rows:
        for change in branch.changes:
            if change.is_located:
                axes.axvline(change.value, color=RED, ls=":", lw=1.1)
            else:
                axes.axvspan(*sorted((change.before, change.after)), color=RED, alpha=0.12, lw=0)
    text = "; ".join(f"{change.kind} {change.where(6)}" for change in branch.changes)
    if text:
        said = [*rows[1].get_title("left").split("\n"), *textwrap.wrap(text, CHANGE_LETTERS)]
        rows[1].set_title("\n".join(line for line in said if line), loc="left", fontsize=LETTER, color=RED)


def stick_with_ends(branch: CycleBranch, stable: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values, durations of sticking and stability, with a zero where it ends or begins: between two cycles none is
    known."""
    values, stick = branch.values, branch.stick_durations
    for change in branch.changes:
        beside = np.flatnonzero((values[:-1] == change.before) & (values[1:] == change.after))
        if change.kind.startswith("stick") and beside.size and not stick[beside[0] : beside[0] + 2].all():
            k = beside[0] + 1
            values, stick = np.insert(values, k, change.value), np.insert(stick, k, 0.0)
            stable = np.insert(stable, k, stable[k - 1])
    return values, stick, stable


def plot_waterfall(
    branch: CycleBranch, path: str | Path | None = None, label: str = "", coordinate: int | str = 0, shown: int = 12
) -> Any:
    """Some cycles of a branch in the phase plane, coloured by the parameter."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    coordinate = branch.cycles[0].system.described.coordinate(coordinate)
    figure = new_figure(WIDTH, 3.9)
    axes = figure.subplots()
    scale = ScalarMappable(Normalize(branch.values.min(), branch.values.max()), colormaps["viridis"])
    for k in np.unique(np.linspace(0, len(branch.cycles) - 1, shown).astype(int)):
        cycle = branch.cycles[k]
        closed = [np.append(x[:, coordinate], x[0, coordinate]) for x in (cycle.q, cycle.u)]
        axes.plot(*closed, color=scale.to_rgba(branch.values[k]), lw=1.3)
    system = branch.cycles[0].system
    named = coordinates_of(system)[coordinate]
    axes.set_xlabel(coordinate_label(*named))
    axes.set_ylabel(velocity_label(*named))
    axes.locator_params(axis="x", nbins=6)
    axes.grid(alpha=0.25)
    set_title(figure, heading([system], branch.parameter))
    figure.colorbar(scale, ax=axes, label=label or parameter_label(branch.parameter, system.parameters))
    return save_figure(figure, path)


def plot_bifurcations(diagram: BifurcationDiagram, path: str | Path | None = None, label: str = "") -> Any:
    """Local maxima, or the points of a section, upwards as small dots, downwards as rings around them; crosses where
    the motion has not settled; a bar below where a contact opened.

    Where both ways find the same motion a ring has its dot; a dot or a ring alone is one of several motions.
    """
    figure = new_figure(WIDTH, 3.9)
    axes = figure.subplots()
    directions: Sequence[tuple[str, Any, str, dict[str, Any]]] = (
        ("upwards", diagram.upwards, CYCLE[0], {"ms": 2.2, "mew": 0.0, "zorder": 3}),
        ("downwards", diagram.downwards, CYCLE[1], {"ms": 5.0, "mew": 0.8, "mfc": "none", "zorder": 2}),
    )
    for k, (name, maxima, shade, style) in enumerate(directions):
        x = np.concatenate([np.full(len(peaks), v) for v, peaks in zip(diagram.values, maxima, strict=True)])
        settled = np.repeat(diagram.settled[k], [len(peaks) for peaks in maxima])
        y = np.concatenate(maxima)
        axes.plot(x[settled], y[settled], "o", color=shade, ls="", label=name, **style)
        if not settled.all():
            axes.plot(x[~settled], y[~settled], "x", color=shade, ls="", ms=4.0, mew=0.7, label=f"{name}, not settled")
        lost = diagram.values[diagram.opens[k]]
        axes.plot(lost, np.full(len(lost), 0.015 + 0.025 * k), "|", color=shade, ms=5,
                  transform=axes.get_xaxis_transform(), label=f"opens, {name}" if len(lost) else None)  # fmt: skip
    axes.set_xlabel(label or parameter_label(diagram.parameter, getattr(diagram.system, "parameters", None)))
    name, _, unit = diagram.coordinate_label.rstrip("]").partition(" [")
    place = with_unit(name, unit) if name else f"q[{diagram.coordinate}]"
    what = "local maxima of" if diagram.periods is None else "once a period of the forcing:"
    axes.set_ylabel(f"{what} {place}")
    axes.margins(y=0.1)
    axes.grid(alpha=0.25)
    legend_above(axes)
    if diagram.system is not None:
        set_title(figure, heading([diagram.system], diagram.parameter))
    return save_figure(figure, path)
