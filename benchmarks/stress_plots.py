"""The pictures of ``python -m benchmarks stress``: every figure over its bound, and how far random systems agree."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.stress_figures import Outcome
from benchmarks.stress_random import Verdict
from nonsmooth.drawing.plots import new_figure

NAMES = ("depth", "residual", "ledger", "momentum", "invariant")
LEAST = 1e-18  # what is zero is drawn here


def plot_margins(outcomes: list[Outcome], path: Path) -> None:
    """Every figure over its bound, by integrator."""
    figure = new_figure(7.5, 3.6)
    axes = figure.subplots()
    methods = sorted({outcome.method.split()[0] for outcome in outcomes})
    for m, method in enumerate(methods):
        x, y = [], []
        for outcome in (outcome for outcome in outcomes if outcome.method.startswith(method)):
            for k, (value, bound) in enumerate(zip(outcome.figures, outcome.bounds, strict=True)):
                if bound > 0 and value == value:
                    x.append(k + 0.25 * (m - (len(methods) - 1) / 2))
                    y.append(max(value / bound, LEAST))
        axes.semilogy(x, y, "o", markersize=3, alpha=0.5, label=method)
    axes.axhline(1.0, color="black", linewidth=1)
    axes.set_xticks(range(len(NAMES)), NAMES)
    axes.set_ylim(0.3 * LEAST, 1e3)
    axes.set_ylabel("figure / its bound [-]")
    figure.legend(loc="outside upper center", fontsize="small", ncols=len(methods))
    figure.savefig(path, dpi=110)


def plot_agreement(verdicts: list[Verdict], path: Path) -> None:
    """Distance to located events against its bound, one dot a random system and method."""
    figure = new_figure(10.0, 3.6)
    panels = figure.subplots(1, 3, sharex=True, sharey=True)
    for axes, method in zip(panels, ("MoreauJean", "Adaptive", "Penalty"), strict=True):
        mine = [v for v in verdicts if v.method == method and np.isfinite(v.error)]
        for label in ["no reason to differ", *sorted({v.reason for v in mine if v.reason})]:
            chosen = [v for v in mine if (v.reason or "no reason to differ") == label]
            axes.loglog([v.bound for v in chosen], [max(v.error, 1e-14) for v in chosen], "o", markersize=3, alpha=0.6,
                        label=label)  # fmt: skip
        axes.plot([1e-9, 1e2], [1e-9, 1e2], color="black", linewidth=1)
        axes.set_title(method, fontsize="medium")
        axes.set_xlabel("bound [m kg$^{1/2}$]")
        axes.legend(fontsize="x-small", loc="upper left")
    panels[0].set_ylabel("distance to located events [m kg$^{1/2}$]")
    figure.savefig(path, dpi=110)
