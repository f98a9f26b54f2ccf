"""``python -m benchmarks calls``: what one call from Python costs, checks of its arguments and its result included.

    python -m benchmarks calls > docs/benchmarks/calls.md

The calls take turns, so that other work on the machine meets all of them; each figure is the processor time of a call
in a loop of CALLS, as the median and the least of ROUNDS loops.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np

import nonsmooth as ns
from benchmarks.problems import FAMILIES, frictionless_lcp
from benchmarks.solvers import table
from models import BeltOscillator, PainleveRod, RockingBlock, SpragSlip

CALLS, ROUNDS = 50, 41
SEED = 0  # of the random problems


def main(words: list[str] | None = None) -> int:
    """Print the page; returns the exit code."""
    print("# What a call costs\n")
    print(
        f"Made by `python -m benchmarks calls`: processor time of one call [us], median and least of {ROUNDS} loops of"
    )
    print(f"{CALLS} calls that take turns. Checks of the arguments, the result and its own residual are in it.\n")
    calls = named_calls()
    for call in calls.values():
        call()
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(ROUNDS):
        for name, call in calls.items():
            times[name].append(time_of(call))
    columns = {"median": list(map(statistics.median, times.values())), "least": list(map(min, times.values()))}
    print("\n".join(table("call", list(times), {name: [f"{us:.3g}" for us in row] for name, row in columns.items()})))
    return 0


def named_calls() -> dict[str, Callable[[], object]]:
    """The calls that are timed."""
    rng, rod = np.random.default_rng(SEED), PainleveRod(mu=2.0)
    lcps = {n: frictionless_lcp(rng, n) for n in (3, 24)}
    mu, system, state = np.array([0.5]), rod.system(), rod.state(thdot=6.0)
    sprag, belt, block = SpragSlip(), BeltOscillator(), RockingBlock()
    states = {
        "the sprag-slip rod": (sprag.system(), sprag.state()),
        "the belt oscillator": (belt.system(), belt.state()),
        "a block on its two edges": (block.system(), block.state(tilt=0.0)),
    }
    step, short = ns.MoreauJean(dt=1e-3), (0.0, 1e-3)
    plane, space = (np.eye(2), np.array([-1.0, 2.0])), (np.eye(3), np.array([-1.0, 0.2, 0.3]))
    few = {dim: FAMILIES["assembly"](np.random.default_rng([SEED, 5, dim]), 5, dim) for dim in (2, 3)}
    return {
        "`solve_lcp`, n = 3": lambda: ns.solve_lcp(*lcps[3]),
        "`solve_lcp`, n = 24": lambda: ns.solve_lcp(*lcps[24]),
        "`solve_contact`, one contact in the plane": lambda: ns.solve_contact(*plane, mu, 2),
        "`solve_contact`, one contact in space": lambda: ns.solve_contact(*space, mu, 3),
        "`solve_contact`, five contacts in the plane, sparse": lambda: ns.solve_contact(*few[2]),
        "`solve_contact`, five contacts in space, sparse": lambda: ns.solve_contact(*few[3]),
        "`classify`, a rod with two solutions": lambda: ns.classify(system, 0.0, *state),
        **{f"`classify`, {name}": classification_of(*given) for name, given in states.items()},
        "`classify` of that rod, and all it says": lambda: ns.classify(system, 0.0, *state).to_dict(),
        "`simulate`, one step of a rod": lambda: ns.simulate(system, short, *state, integrator=step),
    }


def classification_of(system: ns.System, state: tuple[np.ndarray, np.ndarray]) -> Callable[[], object]:
    """The call that classifies a state."""
    return lambda: ns.classify(system, 0.0, *state)


def time_of(call: Callable[[], object]) -> float:
    """Processor time of one of CALLS calls [us]."""
    start = time.process_time()
    for _ in range(CALLS):
        call()
    return 1e6 * (time.process_time() - start) / CALLS
