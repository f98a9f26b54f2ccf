"""``python -m benchmarks penalty``: compliant contact by the compiled integrator beside SciPy's Radau, BDF and LSODA.

SciPy's take rates, modes and events that are written in Python (adapters/scipy_springs.py). Work is compared at equal
error against a run with rtol = 1e-12: for each run of SciPy's, the evaluations of the rates, and the processor time,
that the compiled integrator takes for its error, between its own runs on a log-log scale.
"""

from __future__ import annotations

import math
import platform
import time
from typing import Any, NamedTuple

import numpy as np

from benchmarks.adapters.scipy_springs import motion
from nonsmooth.catalogue.entries import load
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.runs.simulate import simulate_whole

METHODS = ("Radau", "BDF", "LSODA")
RTOLS = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
SCIPY_RTOLS = (1e-6, 1e-8)
REFERENCE_RTOL = 1e-12
REPEATS = 5


class Case(NamedTuple):
    """A motion to integrate."""

    model: Any
    state: dict[str, float]
    t_end: float
    stiffness: float  # N/m
    damping: float  # N s/m


class Figures(NamedTuple):
    """What a run cost, and how good it is."""

    seconds: float  # of the processor
    steps: int
    evaluations: int
    error: float


def cases() -> dict[str, Case]:
    """The motions: a seizure with stick and slip after it, an impact without collision, bounces."""
    rod, ball = load("painleve-rod")(mu=2.0), load("bouncing-ball")()
    return {
        "sprag-slip, kc = cc = 1e6, seizure": Case(load("sprag-slip")(), {"th": 0.78, "thdot": 1.0}, 0.4, 1e6, 1e6),
        "rod, k = 1e8, impact without collision": Case(rod, {"th": math.pi / 3, "slip": -1.0}, 4e-3, 1e8, 0.0),
        "ball, k = 1e6, zeta = 0.2, three bounces": Case(
            ball, {"height": 1.0}, 1.3, 1e6, 2 * 0.2 * math.sqrt(1e6 * ball.m)
        ),
    }


def main(argv: list[str] | None = None) -> int:
    """Print the tables; returns the exit code."""
    print(f"{platform.platform()}, Python {platform.python_version()}, least of {REPEATS} runs (SciPy: one)\n")
    for name, case in cases().items():
        print(name)
        for line in table(case):
            print("  " + line)
        print()
    return 0


def table(case: Case) -> list[str]:
    """The lines of one motion."""
    exact, _, _ = compiled_run(case, REFERENCE_RTOL)
    own = [measure(case, "compiled", rtol, exact) for rtol in RTOLS]
    lines = [f"{'method':9} {'rtol':>6} {'error':>9} {'steps':>6} {'rates':>7} {'of ours':>8} {'time of ours':>13}"]
    lines += [line("compiled", rtol, figures, "", "") for rtol, figures in zip(RTOLS, own, strict=True)]
    for method in METHODS:
        for rtol in SCIPY_RTOLS:
            try:
                found = measure(case, method, rtol, exact)
            except RuntimeError as failure:
                lines.append(f"{method:9} {rtol:6.0e} {failure}")
                continue
            work = found.evaluations / cost_for(found.error, own, "evaluations")
            lines.append(line(method, rtol, found, f"{work:.1f}", f"{found.seconds / cost_for(found.error, own):.0f}"))
    return lines


def line(method: str, rtol: float, figures: Figures, work: str, ratio: str) -> str:
    """One run."""
    cost = f"{figures.steps:6d} {figures.evaluations:7d}"
    return f"{method:9} {rtol:6.0e} {figures.error:9.2e} {cost} {work:>8} {ratio:>13}"


def compiled_run(case: Case, rtol: float) -> tuple[np.ndarray, int, int]:
    """(State at the end, steps, evaluations) of the compiled integrator."""
    integrator = Penalty(case.stiffness, case.damping, rtol=rtol, atol=1e-2 * rtol)
    q0, u0 = case.model.state(**case.state)
    found = simulate_whole(case.model, (0.0, case.t_end), q0, u0, integrator=integrator, t_eval=[case.t_end])
    return np.concatenate((found.q[-1], found.u[-1])), found.stats.steps, found.stats.evaluations


def scipy_run(case: Case, method: str, rtol: float) -> tuple[np.ndarray, int, int]:
    """(State at the end, steps, evaluations) of one of SciPy's solvers."""
    (q0, u0), times = case.model.state(**case.state), np.array([0.0, case.t_end])
    system, atol = case.model.system(), 1e-2 * rtol
    states, steps, n_rates = motion(system, case.stiffness, case.damping, q0, u0, times, method, rtol, atol)
    return states[-1], steps, n_rates


def measure(case: Case, method: str, rtol: float, exact: np.ndarray) -> Figures:
    """Least time and error of a run."""
    is_ours, seconds = method == "compiled", math.inf
    for _ in range(1 + REPEATS if is_ours else 1):  # our first run loads
        begun = time.process_time()
        end, steps, evaluations = compiled_run(case, rtol) if is_ours else scipy_run(case, method, rtol)
        seconds = min(seconds, time.process_time() - begun)
    return Figures(seconds, steps, evaluations, float(np.abs(end - exact).max()))


def cost_for(error: float, own: list[Figures], what: str = "seconds") -> float:
    """What the compiled integrator takes for an error: log-log between its runs, beyond them that of the nearest."""
    rows = sorted((math.log(max(f.error, 1e-300)), math.log(getattr(f, what))) for f in own)
    errors, costs = zip(*rows, strict=True)
    return math.exp(float(np.interp(math.log(max(error, 1e-300)), errors, costs)))
