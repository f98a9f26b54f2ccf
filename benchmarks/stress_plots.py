"""The pictures of ``python -m benchmarks stress``: every figure over its bound, and how far random systems agree."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.stress_figures import Outcome
from benchmarks.stress_random import CONTROLLED, DT, STIFFNESS, Verdict
from nonsmooth.drawing.colours import BLACK, WASHED, cycled
from nonsmooth.drawing.labels import LETTER
from nonsmooth.drawing.plots import WIDTH, new_figure, save_figure

NAMES = ("depth", "residual", "ledger", "momentum", "invariant")
METHODS = ("Moreau–Jean", "Adaptive", "EventDriven", "Penalty")  # in the order of their colours, in both pictures
REASONS = ("no reason to differ", "paradox", "energy gain", "impacts at one instant", "law of impact")  # likewise
LEAST = 1e-18  # what is zero is drawn here
NEAREST = 1e-14  # [m kg^(1/2)] distances below are drawn here
APART = 0.2  # of the room of a figure, between two integrators
SPREAD = 0.12  # of it, over which the points of one are spread


def plot_margins(outcomes: list[Outcome], path: Path | None = None) -> Any:
    """Every figure over its bound, by integrator."""
    figure = new_figure(WIDTH, 3.6)
    axes = figure.subplots()
    for m, method in enumerate(METHODS):
        x, y = margins(outcomes, method)
        colour, _, marker = cycled(m)
        x = x + APART * (m - (len(METHODS) - 1) / 2) + SPREAD * (np.linspace(0, 1, len(x)) * 7.1 % 1 - 0.5)
        axes.semilogy(x, np.maximum(y, LEAST), marker, ms=2.5, mew=0.4, mfc="none", color=colour, label=method)
    axes.axhline(1.0, color=BLACK, lw=1)
    axes.annotate("bound", (0.5, 1.0), (0, 3), textcoords="offset points", fontsize=LETTER, ha="center")
    axes.set_xticks(range(len(NAMES)), NAMES)
    axes.set_ylim(0.1 * LEAST, 1e3)
    axes.set_yticks(
        [LEAST, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0], ["0", *(f"$10^{{{k}}}$" for k in range(-15, 0, 3)), "1"]
    )
    axes.set_ylabel("what was measured over its bound [-]")
    axes.grid(True, axis="y", which="major", color=WASHED)
    figure.legend(loc="outside upper center", fontsize=LETTER, ncols=len(METHODS), frameon=False, markerscale=2)
    return save_figure(figure, path)


RUN = {  # integrators of the random systems, and with what
    "MoreauJean": f"dt = {DT:g} s", "Adaptive": f"rtol = {CONTROLLED.rtol:g}", "Penalty": f"k = {STIFFNESS:g} N/m",
}  # fmt: skip


def margins(outcomes: list[Outcome], method: str) -> tuple[np.ndarray, np.ndarray]:
    """Of all runs of an integrator the number of the figure, and the figure over its bound."""
    found = [
        (k, value / bound)
        for outcome in outcomes
        if outcome.method.startswith(method)
        for k, (value, bound) in enumerate(zip(outcome.figures, outcome.bounds, strict=True))
        if bound > 0 and value == value
    ]
    k, ratio = np.array(found).reshape(-1, 2).T
    return k, ratio


def plot_agreement(verdicts: list[Verdict], path: Path | None = None) -> Any:
    """Distance to located events against its bound, one point a random system and method."""
    figure = new_figure(WIDTH, 3.2)
    panels = figure.subplots(1, 3, sharex=True, sharey=True)
    for axes, (method, option) in zip(panels, RUN.items(), strict=True):
        mine = [v for v in verdicts if v.method == method and np.isfinite(v.error)]
        for k, label in enumerate(REASONS):
            chosen = [v for v in mine if (v.reason or REASONS[0]) == label]
            colour, _, marker = cycled(k)
            axes.loglog([v.bound for v in chosen], [max(v.error, NEAREST) for v in chosen], marker, ms=2.5, mew=0.5,
                        mfc="none", color=colour, label=label)  # fmt: skip
        axes.plot([1e-9, 1e2], [1e-9, 1e2], color=BLACK, lw=1)
        axes.set_title(f"{method}\n{option}", fontsize=9)
        axes.set_xticks([1e-8, 1e-4, 1.0])
        axes.grid(True, which="major", color=WASHED)
    panels[1].set_xlabel("bound [m kg$^{1/2}$]; on the line the distance is the bound")
    panels[0].set_ylabel("distance to located\nevents [m kg$^{1/2}$]")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", fontsize=LETTER, ncols=3,
                  frameon=False, markerscale=2)  # fmt: skip
    return save_figure(figure, path)
