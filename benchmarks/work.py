"""``python -m benchmarks work [RTOL]``: what the integrators with error control do on the scenes of the field.

Steps that were accepted, tries that were not, evaluations of the forces, Jacobians and factorisations of EventDriven,
events; the least processor time of a call of `simulate` in ROUNDS rounds, in which scenes and integrators take turns;
and the error in tolerances, the largest of any coordinate in rtol (1e-2 + max |q|) at TIMES times.
"""

from __future__ import annotations

import argparse
import time
import warnings
from typing import Any

import numpy as np

import nonsmooth as ns
from benchmarks.motions import Motion, motions
from benchmarks.solvers import table
from nonsmooth.errors import SimultaneousImpactWarning

ROUNDS = 20  # chosen
TIMES = 17  # chosen: at which positions are compared
RTOL = 1e-6
METHODS = {"EventDriven": ns.EventDriven, "Adaptive": ns.Adaptive}
TITLES = ("ms", "steps", "rejected", "evaluations", "a step", "Jacobians", "factors", "events", "error / rtol")


def main(words: list[str] | None = None) -> int:
    """Print the tables; returns the exit code."""
    warnings.simplefilter("ignore", SimultaneousImpactWarning)  # of the slider-crank
    parser = argparse.ArgumentParser(prog="python -m benchmarks work", description="what a run does, and in which time")
    parser.add_argument("rtol", nargs="?", type=float, default=RTOL, help=f"relative tolerance, {RTOL:g} by default")
    rtol, scenes = parser.parse_args(words).rtol, motions()
    solutions: dict[tuple[str, str], Any] = {}
    seconds: dict[tuple[str, str], list[float]] = {}
    for _ in range(ROUNDS):
        for name, motion in scenes.items():
            for label, method in METHODS.items():
                began = time.process_time()
                solutions[label, name] = run(motion, method(rtol, rtol / 100))
                seconds.setdefault((label, name), []).append(time.process_time() - began)
    exact = {name: run(motion, ns.EventDriven(1e-12, 1e-14)).q for name, motion in scenes.items()}
    for label in METHODS:
        rows = [figures(solutions[label, name], min(seconds[label, name]), exact[name], rtol) for name in scenes]
        columns = {title: [row[k] for row in rows] for k, title in enumerate(TITLES)}
        print(f"{label}(rtol={rtol:g}, atol={rtol / 100:g})\n", *table("scene", scenes, columns), "", sep="\n")
    return 0


def run(motion: Motion, integrator: Any) -> ns.Solution:
    """A run with rows at the times."""
    times = np.linspace(0.0, motion.t_end, TIMES)
    return ns.simulate(motion.model, (0.0, motion.t_end), *motion.state, integrator=integrator, t_eval=times)


def figures(solution: ns.Solution, seconds: float, exact: np.ndarray, rtol: float) -> list[str]:
    """A row of the table."""
    stats, scale = solution.stats, 1e-2 + np.abs(exact).max(axis=0)
    error = (np.abs(solution.q - exact) / scale).max() / rtol
    counts = [stats.steps, stats.rejected, stats.evaluations, f"{stats.evaluations / stats.steps:.1f}"]
    counts += [stats.jacobians, stats.factorisations, len(solution.events)]
    return [f"{1e3 * seconds:.2f}", *map(str, counts), f"{error:.1g}"]
