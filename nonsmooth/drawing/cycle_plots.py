"""Figures of cycles: phase planes with their phases, branches along a parameter, waterfalls, bifurcation diagrams.

Matplotlib is imported inside the functions. Every function returns the figure, and saves it where a path is given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.drawing.plots import BLUE, RED, STRIPS, new_figure, save_figure
from nonsmooth.drawing.stability_plots import COLOURS

if TYPE_CHECKING:
    from nonsmooth.cycles.cycle import CyclePhase, LimitCycle
    from nonsmooth.cycles.cycle_branch import CycleBranch
    from nonsmooth.studies.bifurcation_diagram import BifurcationDiagram


def plot_cycle(cycle: LimitCycle, path: str | Path | None = None) -> Any:
    """The phase plane of every coordinate, each phase in the colour of what its contact does."""
    n = cycle.system.n_q
    figure = new_figure(5.5 * n + 0.5, 4.8)
    planes = figure.subplots(1, n, squeeze=False)[0]
    size = len(cycle.t) // len(cycle.phases)
    for j, axes in enumerate(planes):
        shown = set()
        for k, phase in enumerate(cycle.phases):
            part = slice(k * size, (k + 1) * size)
            label = phase.label
            style = "--" if any(state.normal < 0 for state in phase.states) else "-"
            axes.plot(cycle.q[part, j], cycle.u[part, j], style, color=colour(phase), lw=2.2,
                      label=None if label in shown else label)  # fmt: skip
            axes.plot(phase.q[j], phase.u[j], "o", color="black", ms=4, zorder=5)
            shown.add(label)
        axes.set_xlabel(cycle.system.described.label(j))
        axes.set_ylabel(cycle.system.described.rate_label(j))
        axes.grid(alpha=0.25)
    planes[0].legend(frameon=False, fontsize=9, loc="center")
    largest = f"{np.abs(cycle.multipliers).max():.4g}" if cycle.multipliers.size else "none"
    figure.suptitle(f"period {cycle.period:.9g} s, largest multiplier {largest}", fontsize=10)
    return save_figure(figure, path)


def colour(phase: CyclePhase) -> str:
    """Of what the first contact does; black where there is none."""
    return STRIPS[phase.states[0].mode, phase.states[0].slip] if phase.states else BLUE


def plot_branch(
    branches: CycleBranch | Mapping[str, CycleBranch],
    path: str | Path | None = None,
    label: str = "",
    coordinate: int | str = 0,
) -> Any:
    """Amplitude, period and stick duration along the parameter; unstable cycles dashed, changes as vertical lines."""
    family = branches if isinstance(branches, Mapping) else {"": branches}
    first = next(iter(family.values()))
    coordinate = first.cycles[0].system.described.coordinate(coordinate)
    figure = new_figure(7.5, 7.5)
    rows = figure.subplots(3, 1, sharex=True)
    for k, (name, branch) in enumerate(family.items()):
        stable = np.array([cycle.is_stable for cycle in branch.cycles])
        for axes, values in zip(
            rows, (branch.amplitudes[:, coordinate], branch.periods, branch.stick_durations), strict=True
        ):
            for kind, style in ((stable, "-"), (~stable, "--")):
                if kind.any():
                    axes.plot(branch.values, np.where(kind, values, np.nan), style, color=COLOURS[k % len(COLOURS)],
                              lw=1.6, label=name if style == "-" and name else None)  # fmt: skip
        for change in branch.changes:
            for axes in rows:
                axes.axvline(change.value, color=RED, ls=":", lw=1.1)
            rows[0].annotate(change.kind, (change.value, 0.03), (3, 0), ("data", "axes fraction"), "offset points",
                             rotation=90, fontsize=8, color=RED, va="bottom")  # fmt: skip
    name, unit = first.cycles[0].system.described.coordinates[coordinate]
    rows[0].set_ylabel(f"(max - min)/2 of {name}" + (f" [{unit}]" if unit else ""))
    rows[1].set_ylabel("period [s]")
    rows[2].set_ylabel("stick [s]")
    rows[2].set_xlabel(label or first.parameter)
    for axes in rows:
        axes.grid(alpha=0.25)
    if len(family) > 1:
        rows[0].legend(frameon=False, fontsize=9)
    return save_figure(figure, path)


def plot_waterfall(
    branch: CycleBranch, path: str | Path | None = None, label: str = "", coordinate: int | str = 0, shown: int = 12
) -> Any:
    """Some cycles of a branch in the phase plane, coloured by the parameter."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    coordinate = branch.cycles[0].system.described.coordinate(coordinate)
    figure = new_figure(7, 5.2)
    axes = figure.subplots()
    scale = ScalarMappable(Normalize(branch.values.min(), branch.values.max()), colormaps["viridis"])
    for k in np.unique(np.linspace(0, len(branch.cycles) - 1, shown).astype(int)):
        cycle = branch.cycles[k]
        closed = [np.append(x[:, coordinate], x[0, coordinate]) for x in (cycle.q, cycle.u)]
        axes.plot(*closed, color=scale.to_rgba(branch.values[k]), lw=1.3)
    names = branch.cycles[0].system.described
    axes.set_xlabel(names.label(coordinate))
    axes.set_ylabel(names.rate_label(coordinate))
    axes.grid(alpha=0.25)
    figure.colorbar(scale, ax=axes, label=label or branch.parameter)
    return save_figure(figure, path)


def plot_bifurcations(diagram: BifurcationDiagram, path: str | Path | None = None, label: str = "") -> Any:
    """Local maxima upwards and downwards; crosses where a contact opened."""
    figure = new_figure(7.5, 4.8)
    axes = figure.subplots()
    directions: Sequence[tuple[str, Any, str, str]] = (
        ("upwards", diagram.upwards, "^", BLUE), ("downwards", diagram.downwards, "v", "#d95f02"),
    )  # fmt: skip
    for k, (name, maxima, marker, shade) in enumerate(directions):
        x = np.concatenate([np.full(len(peaks), v) for v, peaks in zip(diagram.values, maxima, strict=True)])
        y = np.concatenate(maxima)
        axes.plot(x, y, marker, color=shade, mfc="none", ms=5, ls="", label=name)
        if diagram.opens[k].any():
            lost = [peaks[-1] for peaks, is_open in zip(maxima, diagram.opens[k], strict=True) if is_open]
            axes.plot(
                diagram.values[diagram.opens[k]], lost, "x", color=RED, label="a contact opens" if k == 0 else None
            )
    axes.set_xlabel(label or diagram.parameter)
    axes.set_ylabel(f"local maxima of {diagram.coordinate_label or f'q[{diagram.coordinate}]'}")
    axes.grid(alpha=0.25)
    axes.legend(frameon=False, fontsize=9)
    return save_figure(figure, path)
