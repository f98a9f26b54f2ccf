"""The figure of docs/theory/event_driven.md: ``python docs/figures/event_driven.py [FOLDER]``.

The slender rod towards its Génot–Brogliato point, with 200 random steps of plain Moreau–Jean, against EventDriven.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from nonsmooth import EventKind
from nonsmooth.catalogue import PainleveRod

ROD = PainleveRod(mu=2.0)
START = ROD.state(th=math.radians(34), thdot=2.0, slip=-6.0)
T_POINT, T_END = 0.0203153845, 0.05  # s
STEPS = 10.0 ** np.random.default_rng(200).uniform(-5.0, -3.0, 200)  # s


def end_of(integrator: object) -> tuple[np.ndarray, bool]:
    """Where a run ends, and whether it met the impact without collision."""
    run = ns.simulate(ROD, (0.0, T_END), *START, integrator=integrator)
    return run.q[-1], any(event.kind == EventKind.INCONSISTENT for event in run.paradoxes)


def outcomes(integrators: list) -> tuple[np.ndarray, np.ndarray]:
    """Errors of the tip angle at the end [rad], and which runs met the impact."""
    exact, _ = end_of(ns.EventDriven(1e-12, 1e-14))
    ends = [end_of(integrator) for integrator in integrators]
    return np.array([abs(q[2] - exact[2]) for q, _ in ends]), np.array([met for _, met in ends])


def steps_through_the_point(folder: Path) -> None:
    """Error of Moreau–Jean against the step, by what the step met."""
    errors, met = outcomes([ns.MoreauJean(dt) for dt in STEPS])
    tolerances = 10.0 ** -np.arange(4.0, 12.0)
    by_events, found = outcomes([ns.EventDriven(rtol, 1e-2 * rtol) for rtol in tolerances])
    print(f"MoreauJean: impact without collision in {met.sum()} of {met.size} runs")
    print(f"  median error of th with it {np.median(errors[met]):.2e}, without {np.median(errors[~met]):.2e} rad")
    print(f"EventDriven: in {found.sum()} of {found.size}, largest error / rtol {(by_events / tolerances).max():.2g}")
    figure, axes = plt.subplots(figsize=(7.2, 4.4), layout="constrained")
    kinds = [(True, "C0", "impact without collision"), (False, "C3", "none noticed: lifts off, or stops later")]
    for is_met, colour, label in kinds:
        k = met == is_met
        axes.loglog(STEPS[k], errors[k], "o", ms=3.5, color=colour, label=f"{label}: {k.sum()} of {k.size}")
    axes.set(xlabel=r"$\Delta t$ [s]", ylabel=rf"error of $\theta$ at {T_END:g} s [rad]",
             title="Moreau–Jean through the Génot–Brogliato point, 200 random steps")  # fmt: skip
    axes.legend()
    axes.grid(alpha=0.3)
    figure.savefig(folder / "genot_brogliato_steps.png", dpi=150)


if __name__ == "__main__":
    steps_through_the_point(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
