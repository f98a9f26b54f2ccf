"""``python -m benchmarks chain [quick]``: chains of links that fall, and those of MuJoCo, as a page.

    python -m benchmarks chain > docs/benchmarks/chain.md

A chain of ball joints lies along x and is let go. All programs take the same steps in turns, in one process, so that
what else the machine does meets all alike; processor time is that of the steps alone. The ends of neighbours are
compared from the places of all bodies after each turn, for all programs by the same lines. MuJoCo has a chain as a tree
of joints, whose coordinates have no such error, or as free bodies tied by soft constraints.
"""

from __future__ import annotations

import math
import platform
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

import nonsmooth as ns
from benchmarks.peers import adapter, imports
from benchmarks.solvers import table
from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.places import matrix_of

LINK, MASS, THICK = 0.1, 0.1, 0.01  # chosen: length [m], mass [kg], radius [m]
LENGTHS, TURNS = (10, 30, 100, 300), 10  # chosen
DT, STEPS = 1e-3, 200  # chosen [s]
HEAVY, HEAVY_DT, HEAVY_STEPS = 1e4, 1e-4, 2000  # chosen: of a link, for the mass at the end; [s]

HEAD = """# Chains

Made by `python -m benchmarks chain`, Python {python} on {machine}, one thread, programs in turns: a
chain of ball joints in space lies along x and is let go, links of 10 cm and 0.1 kg, {steps} steps of
1 ms. Times are processor times a step in the median of turns; *opens* is how far joints ever part.

As a *tree* MuJoCo has the angles of the joints as coordinates: nothing can open, and the mass
matrix of a chain is full, so that its factors cost the cube of the length. As *ties* it has
`connect` between free bodies, soft, with its time constant of 20 ms, or of two steps (*stiff*).
nonsmooth has bodies and impulses, which are
[solved as a tree](../theory/scenes.md#trees-of-joints), to rounding. A tree of few links is faster
there, ties are as fast, and Runge-Kutta's method errs by less.
"""


class Program(NamedTuple):
    """A program with its settings, which may depend on the step."""

    label: str
    package: str
    module: str
    options: Callable[[float], dict[str, Any]]


PROGRAMS = (
    Program("nonsmooth", "nonsmooth", "nonsmooth_scenes", lambda dt: {}),
    Program("MuJoCo, tree", "mujoco", "mujoco_chains", lambda dt: {}),
    Program("MuJoCo, tree, RK4", "mujoco", "mujoco_chains", lambda dt: {"integrator": "RK4"}),
    Program("MuJoCo, ties", "mujoco", "mujoco_chains", lambda dt: {"is_tree": False}),
    Program("MuJoCo, stiff ties", "mujoco", "mujoco_chains", lambda dt: {"is_tree": False, "solref": 2 * dt}),
)


def chain(n: int, ratio: float = 0.0) -> ns.Scene:
    """A chain of n links, with a ball at its end that weighs so many of them, if any."""
    scene = ns.Scene(gravity=(0, 0, -9.81))
    scene.fixed(ns.Sphere(THICK), name="hook")
    before = "hook"
    for k in range(n):
        place = ((k + 0.5) * LINK, 0, 0)
        body = scene.body(ns.Capsule(LINK - 2 * THICK, THICK), mass=MASS, position=place, name=f"link {k}")
        scene.joint(before, body, at=(k * LINK, 0, 0))
        before = body.name
    if ratio > 0.0:
        ball = scene.body(ns.Sphere(0.5 * LINK), mass=ratio * MASS, position=((n + 0.5) * LINK, 0, 0), name="ball")
        scene.joint(before, ball, at=(n * LINK, 0, 0))
    scene.ignore(*scene.bodies)
    return scene


class Judge:
    """What a chain has lost, from the places of its bodies: how far its joints open, and its energy."""

    def __init__(self, scene: ns.Scene) -> None:
        bodies = [body for body in scene.bodies if body.kind is Kind.DYNAMIC]
        self.masses = np.array([body.mass for body in bodies], float)
        middles, joints = (np.array([part.position for part in bodies]), np.array([j.at for j in scene.joints]))
        self.back, self.ahead = joints - middles, joints[1:] - middles[:-1]

    def opening(self, position: np.ndarray, turn: np.ndarray) -> float:
        """The farthest that two ends which a joint holds are apart [m]."""
        R = np.array([matrix_of(quaternion / np.linalg.norm(quaternion)) for quaternion in turn])
        back = position + np.einsum("kij,kj->ki", R, self.back)
        ahead = position[:-1] + np.einsum("kij,kj->ki", R[:-1], self.ahead)
        return float(np.linalg.norm(back - np.vstack((np.zeros(3), ahead)), axis=1).max())


class Course:
    """A program on its way."""

    def __init__(self, program: Program, scene: ns.Scene, dt: float) -> None:
        self.motion = adapter(program.module).Motion(scene, dt, **program.options(dt))
        self.judge, self.seconds = Judge(scene), list[float]()
        self.opened, self.residual = 0.0, 0.0
        self.end = np.zeros(3)

    def take(self, count: int) -> None:
        """A turn."""
        began = time.process_time()
        self.motion.step(count)
        self.seconds.append((time.process_time() - began) / count)
        position, turn = self.motion.places()
        self.opened, self.end = max(self.opened, self.judge.opening(position, turn)), position[-1]
        if hasattr(self.motion, "residual"):
            self.residual = max(self.residual, self.motion.residual())


def courses(n: int, ratio: float, dt: float, steps: int, first: int = 1) -> dict[str, Course]:
    """All programs that are installed through the same chain, in turns; the first one is not timed."""
    found = {p.label: Course(p, chain(n, ratio), dt) for p in PROGRAMS if imports(p.package)}
    for count in (first, *[steps // TURNS] * TURNS):
        for course in found.values():
            course.take(count)
    return found


def main(words: list[str]) -> int:
    """Print the page; returns the exit code."""
    share = 20 if "quick" in words else 1
    if unknown := [word for word in words if word != "quick"]:
        print(f"chain takes `quick` or nothing; got {unknown[0]!r}", file=sys.stderr)
        return 2
    print(HEAD.format(python=platform.python_version(), machine=platform.machine(), steps=STEPS // share))
    print("\n".join(page(LENGTHS[: 4 if share == 1 else 2], DT, STEPS // share, 0.0)), flush=True)
    print(f"\nWith a ball at the end that weighs 10,000 links, {HEAVY_STEPS // share} steps of 0.1 ms:\n")
    print("\n".join(page(LENGTHS[: 3 if share == 1 else 1], HEAVY_DT, HEAVY_STEPS // share, HEAVY)), flush=True)
    return 0


def page(lengths: tuple[int, ...], dt: float, steps: int, ratio: float) -> Iterator[str]:
    """The tables of time, of what opens, and of the way of the end against that of half the step."""
    runs = {n: courses(n, ratio, dt, steps) for n in lengths}
    labels = list(runs[lengths[0]])
    cost = {label: [1e3 * statistics.median(runs[n][label].seconds[1:]) for n in lengths] for label in labels}
    columns: dict[str, list[str]] = {f"{n} links [ms]": [f"{cost[label][k]:.3g}" for label in labels]
                                     for k, n in enumerate(lengths)}  # fmt: skip
    if len(lengths) > 1:
        span = math.log(lengths[-1] / lengths[0])
        columns["exponent"] = [f"{math.log(cost[label][-1] / cost[label][0]) / span:.2f}" for label in labels]
    yield from table("time a step", labels, columns)
    opened = {f"{n} links": [f"{runs[n][label].opened:.0e} m" for label in labels] for n in lengths}
    yield ""
    yield from table("opens by", labels, opened)
    ours = [f"{runs[n][labels[0]].residual:.0e}" for n in lengths]
    finer = {
        n: np.array([course.end for course in courses(n, ratio, 0.5 * dt, 2 * steps, 2).values()]) for n in lengths
    }
    away = {
        f"{n} links": [f"{np.linalg.norm(runs[n][label].end - finer[n][k]):.0e} m" for k, label in enumerate(labels)]
        for n in lengths
    }
    yield ""
    yield from table("end of the chain against half the step", labels, away)
    yield f"\nWorst residual of nonsmooth: {', '.join(ours)}."
