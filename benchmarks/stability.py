"""``python -m benchmarks stability``: equilibria, boundaries, cycles, a cycle along a hundred values of a parameter.

Times of the processor and of the clock [s], the least of a few repeats, after a first call that compiles.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.catalogue.entries import load
from nonsmooth.cycles.cycle import LimitCycle
from nonsmooth.cycles.cycle_branch import CycleBranch, continue_cycle
from nonsmooth.cycles.limit_cycle import limit_cycle
from nonsmooth.equilibria.equilibrium import equilibrium
from nonsmooth.equilibria.flutter_boundary import flutter_boundary
from nonsmooth.equilibria.linearise import linearise

REPEATS = 2
SPEEDS = (0.05, 0.44)  # of the belt, between which its cycle is followed [m/s]
VALUES = 100


def main(argv: list[str] | None = None) -> int:
    """Print the table; returns the exit code."""
    belt, coupling = load("belt-oscillator"), load("mode-coupling")
    slow, values = belt(vb=SPEEDS[0]), np.linspace(*SPEEDS, VALUES)
    first = limit_cycle(slow)
    print(f"{platform.platform()}, Python {platform.python_version()}, least of {REPEATS}: processor and clock [s]\n")
    show("equilibrium and eigenvalues, mode coupling", lambda: linearise(coupling(), equilibrium(coupling())))
    show("flutter boundary, mode coupling", lambda: flutter_boundary(coupling(), "mu", (0.0, 1.0)))
    show("cycle from a near one, belt oscillator", lambda: limit_cycle(slow, first))
    show("cycle from simulation, belt oscillator", lambda: limit_cycle(slow))
    branch = show(f"{VALUES} cycles along the belt's speed", lambda: whole_branch(slow, values, first))
    print(f"\ncycles found: {branch.values.size}")
    for change in branch.changes:
        print(f"{change.kind} at vb = {change.value:.10f}")
    return 0


def whole_branch(slow: Any, values: np.ndarray, first: LimitCycle) -> CycleBranch:
    """The cycles along the speed, to the end."""
    branch = continue_cycle(slow, "vb", values, first)
    if any(change.kind == "interrupted" for change in branch.changes):
        raise KeyboardInterrupt
    return branch


def show(what: str, call: Callable[[], Any]) -> Any:
    """Print the time of a call, and return what it returns."""
    result, times = call(), []
    for _ in range(REPEATS):
        before = np.array([time.process_time(), time.perf_counter()])
        result = call()
        times.append(np.array([time.process_time(), time.perf_counter()]) - before)
    cpu, wall = np.min(times, axis=0)
    print(f"{what:46s} {cpu:10.4f} {wall:10.4f}")
    return result
