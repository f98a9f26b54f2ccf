"""``python -m benchmarks contacts [FOLDER]``: a step with 2 to 200 closed contacts, beside what is redundant.

A block on n feet at rest, sliding, on a shaken floor, rocking and landing; without friction; in bilateral guides; in a
corner; towers of blocks with one contact each, stacks with two. Moreau–Jean, dt = 1 ms. Processor time of a run less
that of a run of one step, least of a few repeats. With a folder the figure ``contact_number.png`` is written there.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.contact_scenes import Block, block
from benchmarks.stress_scenes import Tower, stack, tower
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.mechanics.system import Contact, System
from nonsmooth.results.stats import Stats
from nonsmooth.runs.simulate import simulate

DT = 1e-3  # step [s]
NUMBERS = (2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 16, 24, 40, 64, 100, 200)
REPEATS = 5
LONGEST = 2.0  # of the runs of one scene [s]
TILT = 0.05  # of a block that rocks or lands [rad]


class Scene(NamedTuple):
    """A system with its start, as long as something happens [s]."""

    system: System
    q0: Any
    u0: Any
    t_end: float


def tilted(parameters: Block, height: float) -> list[float]:
    """Coordinates of a block on its left foot, turned by TILT, ``height`` above the floor."""
    return [0.0, height + parameters.a * np.sin(TILT) + parameters.h * (np.cos(TILT) - 1.0), TILT]


def at_rest(n: int) -> Scene:
    return Scene(block(n, Block()), np.zeros(3), np.zeros(3), 0.3)


def sliding(n: int) -> Scene:
    return Scene(block(n, Block()), np.zeros(3), [1.5, 0.0, 0.0], 0.3)


def shaken(n: int) -> Scene:
    return Scene(block(n, Block(v=0.5)), np.zeros(3), np.zeros(3), 0.5)


def rocking(n: int) -> Scene:
    return Scene(block(n, Block()), tilted(Block(), 0.0), np.zeros(3), 0.6)


def landing(n: int) -> Scene:
    return Scene(block(n, Block(e=0.3)), tilted(Block(), 0.03), [0.5, 0.0, 0.0], 0.6)


def frictionless(n: int) -> Scene:
    return Scene(block(n, Block(e=0.3), Contact(e_N="e")), tilted(Block(), 0.03), [0.5, 0.0, 0.0], 0.6)


def guided(n: int) -> Scene:
    return Scene(block(n, Block(), Contact(mu="mu", bilateral=True)), np.zeros(3), [1.5, 0.0, 0.0], 0.3)


def cornered(n: int) -> Scene:
    """A block strikes the wall with half of its contacts, flat, and stays in the corner."""
    return Scene(block(n, Block(push=5.0, walls=n // 2)), [0.05, 0.0, 0.0], [-1.0, 0.0, 0.0], 0.4)


def struck_tower(n: int) -> Scene:
    u0 = np.zeros(2 * n)
    u0[-2] = 1.0
    return Scene(tower(n, Tower()), np.zeros(2 * n), u0, 0.3)


def struck_stack(n: int) -> Scene:
    """The highest box is pushed and tips."""
    u0 = np.zeros(3 * (n // 2))
    u0[-3], u0[-1] = 1.0, -2.0
    return Scene(stack(n // 2, Tower()), np.zeros(len(u0)), u0, 0.4)


# name -> scene of n contacts, and the numbers it has
SCENES: dict[str, tuple[Callable[[int], Scene], Callable[[int], bool]]] = {
    "at rest": (at_rest, lambda n: True),
    "sliding": (sliding, lambda n: True),
    "on a shaken floor": (shaken, lambda n: True),
    "rocking": (rocking, lambda n: True),
    "landing": (landing, lambda n: True),
    "landing, no friction": (frictionless, lambda n: True),
    "sliding in guides": (guided, lambda n: True),
    "into a corner": (cornered, lambda n: n >= 4),
    "tower of n, struck": (struck_tower, lambda n: n <= 100),
    "stack of n/2, struck": (struck_stack, lambda n: n % 2 == 0 and n <= 100),
}


def main(argv: list[str] | None = None) -> int:
    """Print the table, and draw it if a folder is given; returns the exit code."""
    print(f"{platform.platform()}, Python {platform.python_version()}: us a step, least of {REPEATS}\n")
    print("| contacts | " + " | ".join(map(str, NUMBERS)) + " |")
    print("|---" * (len(NUMBERS) + 1) + "|")
    costs: dict[str, dict[int, float]] = {}
    for name, (scene, has) in SCENES.items():
        costs[name] = {n: cost(scene(n))[0] for n in NUMBERS if has(n)}
        row = [f"{costs[name][n]:.1f}" if n in costs[name] else "" for n in NUMBERS]
        print(f"| {name} | " + " | ".join(row) + " |", flush=True)
    if argv:
        plot_costs(costs, Path(argv[0]) / "contact_number.png")
    return 0


def cost(scene: Scene) -> tuple[float, Stats]:
    """Microseconds of processor time a step, and the statistics of the run."""
    timed_run(scene, DT)  # compile, or load
    one_step = min(timed_run(scene, DT)[0] for _ in range(REPEATS))
    times: list[float] = []
    while len(times) < REPEATS and sum(times) < LONGEST:
        seconds, stats = timed_run(scene, scene.t_end)
        times.append(seconds)
    return max(0.0, min(times) - one_step) / (stats.steps - 1) * 1e6, stats


def timed_run(scene: Scene, t_end: float) -> tuple[float, Stats]:
    """Processor time of a run [s], and its statistics."""
    began = time.process_time()
    solution = simulate(scene.system, (0.0, t_end), scene.q0, scene.u0, integrator=MoreauJean(DT), every=10**6)
    return time.process_time() - began, solution.stats


def plot_costs(costs: dict[str, dict[int, float]], path: Path) -> None:
    """Microseconds a step against the number of contacts."""
    from nonsmooth.drawing.plots import new_figure

    figure = new_figure(7.5, 4.2)
    axes = figure.subplots()
    for name, values in costs.items():
        axes.loglog(list(values), list(values.values()), "o-", markersize=3, label=name)
    axes.set_xlabel("closed contacts [-]")
    axes.set_ylabel("processor time a step [us]")
    axes.set_xticks(NUMBERS[::3], [str(n) for n in NUMBERS[::3]])
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    figure.legend(loc="outside right upper", fontsize="small")
    figure.savefig(path, dpi=110)
