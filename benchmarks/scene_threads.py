"""What threads gain that share the islands of a scene: wall time of the same steps with one thread and with more.

The runs have the same bits, so each step does the same work in all of them; they take turns, step by step, and the
whole is repeated: of each step the least time counts, since what else the machine does only adds to it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from benchmarks.peers import adapter
from models.scenes import SphereBox
from nonsmooth.contact.network.parallel import Desks
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, HalfPlane, HalfSpace

THREADS = (1, 2)  # chosen: what the tables were made with
REPEATS = 5  # chosen
SIDE, DISTANCE = 0.2, 2.0  # m, chosen: of boxes, and of stacks


class Shared(NamedTuple):
    """A scene, and the steps of it that are timed."""

    label: str
    scene: Callable[[], Scene]
    steps: int


def shared(is_quick: bool) -> list[Shared]:
    """Scenes of many islands, and of one."""
    stacks, spheres, steps = (4, 27, 4) if is_quick else (50, 1000, 30)
    return [
        Shared(f"{stacks} stacks of ten boxes that slide apart", lambda: sliding_stacks(3, stacks), steps),
        Shared(f"{stacks} such stacks in the plane", lambda: sliding_stacks(2, stacks), steps),
        Shared(f"{spheres} spheres falling: groups", SphereBox(n=spheres).scene, 3 * steps),
        Shared(f"{spheres // 10} spheres in a heap: one island", SphereBox(n=spheres // 10).scene, 10 * steps),
    ]


def sliding_stacks(dim: int, count: int) -> Scene:
    """Stacks of ten boxes, each of which is pushed another way: an island each, in motion."""
    scene, rest = Scene(gravity=(0.0,) * (dim - 1) + (-9.81,), material=Material(mu=0.5)), (0.0,) * (dim - 2)
    scene.fixed(HalfPlane((0, 1)) if dim == 2 else HalfSpace((0, 0, 1)), name="floor")
    for stack in range(count):
        for k in range(10):
            place, speed = (DISTANCE * stack, *rest, SIDE * (k + 0.5)), float(k % 3 - 1) * (1.0 + 0.01 * stack)
            velocity = (speed, *rest, 0.0)
            scene.body(Box(*(SIDE,) * dim), density=1000, position=place, velocity=velocity)
    return scene


def print_threads(is_quick: bool) -> None:
    """A row a scene."""
    print(
        "| scene | islands | factors a step | " + " | ".join(f"ms a step, {n} threads" for n in THREADS) + " | ratio |"
    )
    print("|---" * (4 + len(THREADS)) + "|")
    for case in shared(is_quick):
        least = np.full((len(THREADS), case.steps), np.inf)
        for _ in range(REPEATS):
            motions = [started(case.scene(), threads) for threads in THREADS]
            for k in range(case.steps):
                for row, motion in enumerate(motions):
                    began = time.perf_counter()
                    motion.step(1)
                    least[row, k] = min(least[row, k], time.perf_counter() - began)
        stats, mean = motions[0].run.stats(), 1e3 * least.mean(axis=1)
        cells = " | ".join(f"{t:.3g}" for t in mean)
        print(
            f"| {case.label} | {stats.islands} | {stats.factorisations / case.steps:.0f} | {cells} | "
            f"{mean[0] / mean[-1]:.2f} |",
            flush=True,
        )


def started(scene: Scene, threads: int) -> Any:
    """A motion of so many threads."""
    motion = adapter("nonsmooth_scenes").Motion(scene, 2e-3)
    motion.run.assembly.desks = Desks(threads)
    return motion
