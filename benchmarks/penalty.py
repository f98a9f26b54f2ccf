"""``python -m benchmarks penalty``: compliant contact by the compiled integrator beside SciPy's Radau, BDF and LSODA.

All of them integrate the same compiled rates through the same modes and events; they differ in their steps, and in what
a step costs. Times are compared at equal error against a run with rtol = 1e-12: for each run of SciPy's, the time that
the compiled integrator takes for its error, between its own runs on a log-log scale.
"""

from __future__ import annotations

import math
import platform
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.catalogue.entries import load
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.results.failures import StepFailure
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
    options: dict[str, Any]


class Figures(NamedTuple):
    """What a run cost, and how good it is."""

    wall_time: float  # s
    steps: int
    evaluations: int
    error: float


def cases() -> dict[str, Case]:
    """The motions: a seizure with stick and slip after it, an impact without collision, bounces."""
    rod = load("painleve-rod")(mu=2.0)
    return {
        "sprag-slip, kc = cc = 1e6, seizure": Case(
            load("sprag-slip")(), {"th": 0.78, "thdot": 1.0}, 0.4, {"stiffness": 1e6, "damping": 1e6}
        ),
        "rod, k = 1e8, impact without collision": Case(
            rod, {"th": math.pi / 3, "slip": -1.0}, 4e-3, {"stiffness": 1e8}
        ),
        "ball, k = 1e6, zeta = 0.2, three bounces": Case(
            load("bouncing-ball")(), {"height": 1.0}, 1.3, {"stiffness": 1e6, "damping_ratio": 0.2}
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
    exact = end_state(run(case, "compiled", REFERENCE_RTOL))
    own = [measure(case, "compiled", rtol, exact) for rtol in RTOLS]
    lines = [f"{'method':9} {'rtol':>6} {'error':>9} {'steps':>6} {'rates':>7} {'wall [ms]':>10} {'ratio':>6}"]
    lines += [line("compiled", rtol, figures, "") for rtol, figures in zip(RTOLS, own, strict=True)]
    for method in METHODS:
        for rtol in SCIPY_RTOLS:
            try:
                figures = measure(case, method, rtol, exact)
            except StepFailure as failure:
                lines.append(f"{method:9} {rtol:6.0e} refused: {str(failure).split(';')[0][:80]}")
                continue
            lines.append(line(method, rtol, figures, f"{figures.wall_time / time_for(figures.error, own):.0f}"))
    return lines


def line(method: str, rtol: float, figures: Figures, ratio: str) -> str:
    """One run."""
    cost = f"{figures.steps:6d} {figures.evaluations:7d} {1e3 * figures.wall_time:10.3f}"
    return f"{method:9} {rtol:6.0e} {figures.error:9.2e} {cost} {ratio:>6}"


def run(case: Case, method: str, rtol: float) -> Any:
    """The motion by one method."""
    integrator = Penalty(**case.options, rtol=rtol, atol=1e-2 * rtol, method=method)
    q0, u0 = case.model.state(**case.state)
    return simulate_whole(case.model, (0.0, case.t_end), q0, u0, integrator=integrator, t_eval=[case.t_end])


def measure(case: Case, method: str, rtol: float, exact: np.ndarray) -> Figures:
    """Least time and error of a run."""
    make: Callable[[], Any] = lambda: run(case, method, rtol)
    make() if method == "compiled" else None  # the first run loads
    runs = [make() for _ in range(REPEATS if method == "compiled" else 1)]
    stats = runs[0].stats
    error = float(np.abs(end_state(runs[0]) - exact).max())
    return Figures(min(r.stats.wall_time for r in runs), stats.steps, stats.evaluations, error)


def end_state(solution: Any) -> np.ndarray:
    """Coordinates and velocities at the end."""
    return np.concatenate((solution.q[-1], solution.u[-1]))


def time_for(error: float, own: list[Figures]) -> float:
    """The time of the compiled integrator for an error: log-log between its runs, beyond them that of the nearest."""
    rows = sorted((math.log(max(f.error, 1e-300)), math.log(f.wall_time)) for f in own)
    errors, times = zip(*rows, strict=True)
    return math.exp(float(np.interp(math.log(max(error, 1e-300)), errors, times)))
