"""``python -m benchmarks scenes [quick] [NAME ...]``: many bodies beside MuJoCo, PyBullet, pymunk, Box2D and Siconos.

All programs are handed the same scene and take turns, some steps each, in one process (Siconos in one of its own): what
else the machine does meets all alike. Processor time is that of the steps alone. After each turn the bodies of every
program are put into our own shapes: penetration is that of our gaps for all, at the ends of turns. A residual only we
have, |natural map| / |impulses|, the worst of a turn's steps. What is not installed is named in the table.
"""

from __future__ import annotations

import math
import os
import platform
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from benchmarks.core import import_time, script
from benchmarks.peers import adapter, imports
from benchmarks.scene_stages import print_stages
from benchmarks.scene_threads import print_threads
from benchmarks.siconos import interpreter
from models.scenes import BlockOnIncline, BoxStack, Pyramid, SphereBox
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Disc, HalfPlane

DT = 2e-3  # s, chosen: of every scene and program
TURNS = 20  # chosen: in which the steps of a run are taken
AT_END = 5  # chosen: turns of the end, whose median is told apart
COARSE = {"tol": 1e-4, "sweeps": 30}  # chosen: as an engine for speed would be set
FINE = {"tol": 1e-6, "sweeps": 60}  # chosen: between that and the default
PATIENT = {"tol": 1e-4, "sweeps": 500}  # chosen: as many as are needed, for what an impact takes
GROWTH = (100, 1000, 10_000)  # chosen: spheres
FIRST_USE = "import os, nonsmooth as ns; from models.scenes import BoxStack; s = BoxStack(n=2, dim={dim}); "
FIRST_USE += "t = sum(os.times()[:4]); ns.simulate(s, (0, 0.01), integrator=ns.MoreauJean(dt=s.dt)); "
FIRST_USE += "print(sum(os.times()[:4]) - t)"  # its own, and that of the processes that compile
HEADER = (
    "| scene | program | ms a step: first | mean | at the end | residual: worst | at the end | penetration [m]: worst "
    "| at the end | moved |\n|---|---|---|---|---|---|---|---|---|---|"
)


class Program(NamedTuple):
    """A program with its settings."""

    label: str
    package: str
    module: str
    options: dict[str, Any] = {}


OURS = Program("nonsmooth", "nonsmooth", "nonsmooth_scenes")
AWAKE = OURS._replace(label="nonsmooth, may_sleep=False", options={"may_sleep": False})
AT_SPEED = [
    OURS._replace(label=f"nonsmooth, tol={o['tol']:g}, sweeps={o['sweeps']}", options=o)
    for o in (FINE, COARSE, PATIENT)
]
MUJOCO = Program("MuJoCo", "mujoco", "mujoco_scenes")
NOSLIP = MUJOCO._replace(label="MuJoCo, noslip 10", options={"noslip": 10})
# as its documentation says: a time constant of two steps, the least
STIFF = MUJOCO._replace(label=f"MuJoCo, solref {2 * DT:g}", options={"solref": 2 * DT})
PYBULLET = Program("PyBullet", "pybullet", "pybullet_scenes")
PERSISTENT = PYBULLET._replace(label="PyBullet, 1000 iterations", options={"iterations": 1000})
PYMUNK = Program("pymunk", "pymunk", "pymunk_scenes")
BOX2D = Program("Box2D 2.3", "Box2D", "box2d_scenes")
SICONOS = Program("Siconos", "siconos", "siconos_scenes")
STACKED = [OURS, AWAKE, MUJOCO, STIFF, NOSLIP, PYBULLET, PERSISTENT, SICONOS]
PILED = [OURS, *AT_SPEED, MUJOCO, PYBULLET, SICONOS]
LAID, POURED = [OURS, AWAKE, PYMUNK, BOX2D], [OURS, *AT_SPEED, PYMUNK, BOX2D]


class Case(NamedTuple):
    """A scene, the time that it runs [s], who runs it, and whether it should stay where it is."""

    scene: Callable[[], Scene]
    t_end: float
    programs: list[Program]
    stays: bool


def cases(is_quick: bool) -> dict[str, Case]:
    """All of them, or small ones."""
    n, rows, share = (30, 3, 0.02) if is_quick else (1000, 45, 1.0)
    return {
        "S2tilt": Case(BlockOnIncline(share=0.5).scene, 10.0 * share, STACKED, True),
        "S7": Case(BoxStack().scene, 10.0 * share, STACKED, True),
        "S7h": Case(BoxStack(top_ratio=1e3).scene, 10.0 * share, STACKED, True),
        "S7h6": Case(BoxStack(top_ratio=1e6).scene, 10.0 * share, [OURS, MUJOCO, STIFF, PERSISTENT], True),
        "S6": Case(SphereBox(n=n).scene, 1.0 * share, PILED, False),
        "pyramid": Case(Pyramid(rows=rows).scene, 1.0 * share, LAID, True),
        "discs": Case(lambda: discs(n), 3.0 * share, POURED, False),
    }


def main(words: list[str]) -> int:
    """Print the tables."""
    is_quick, names = "quick" in words, [word for word in words if word != "quick"]
    known: dict[str, Callable[[], None]] = {
        name: lambda name=name, case=case: print_case(name, case)  # type: ignore[misc]
        for name, case in cases(is_quick).items()
    }
    known["growth"] = lambda: print_growth(GROWTH[:1] if is_quick else GROWTH, 20 if is_quick else 300)
    known["stages"] = lambda: print_stages(30 if is_quick else 1000, 4 if is_quick else 500, COARSE)
    known["threads"] = lambda: print_threads(is_quick)
    known["first"] = print_first_use
    if unknown := [name for name in names if name not in known]:
        print(f"there is no scene {unknown[0]!r}; known: {', '.join(known)}", file=sys.stderr)
        return 2
    print(f"{platform.platform()}, Python {platform.python_version()}, dt = {DT:g} s")
    for name in names or [name for name in known if not is_quick or name != "first"]:
        print(f"\n{name}: load of the machine {load()}", flush=True)
        known[name]()
    return 0


def load() -> str:
    """Processes that want a processor, over a minute, and how many processors there are."""
    return f"{os.getloadavg()[0]:.1f} on {os.cpu_count()} processors"


@dataclass
class Course:
    """A program on its way through a scene."""

    motion: Any
    seconds: list[float] = field(default_factory=list)  # of processor a step, one for each turn
    counts: list[int] = field(default_factory=list)
    depth: list[float] = field(default_factory=list)  # [m]
    residual: list[float] = field(default_factory=list)
    places: list[np.ndarray] = field(default_factory=list)  # of the bodies that move, before and after each turn

    def take(self, count: int, judge: Any) -> None:
        """A turn."""
        began = time.process_time()
        elsewhere = self.motion.step(count)  # of a program with a process of its own: its processor time
        self.seconds.append((time.process_time() - began if elsewhere is None else elsewhere) / count)
        self.counts.append(count)
        self.places.append(self.motion.places()[0])
        self.depth.append(judge.penetration(*self.motion.places()))
        if hasattr(self.motion, "residual"):
            self.residual.append(self.motion.residual())


def print_case(name: str, case: Case) -> None:
    """All programs side by side."""
    print(HEADER)
    judge = adapter("nonsmooth_scenes").Judge(case.scene(), DT)
    courses = {p.label: started(p, case.scene) for p in case.programs if is_installed(p)}
    for count in turns(round(case.t_end / DT)):
        for course in courses.values():
            course.take(count, judge)
    for program in case.programs:
        figures = row(courses[program.label], case.stays) if program.label in courses else "not installed" + " |" * 7
        print(f"| {name} | {program.label} | {figures} |", flush=True)
    for course in courses.values():
        if hasattr(course.motion, "close"):
            course.motion.close()
    for program in case.programs:
        if program.module == OURS.module:
            print(f"\n{program.label}: {every_step(courses[program.label])}", flush=True)


def is_installed(program: Program) -> bool:
    """Here, or in the Python that has Siconos."""
    return interpreter() is not None if program is SICONOS else imports(program.package)


def started(program: Program, scene: Callable[[], Scene]) -> Course:
    """A program before its first step."""
    course = Course(adapter(program.module).Motion(scene(), DT, **program.options))
    course.places.append(course.motion.places()[0])
    return course


def turns(steps: int) -> list[int]:
    """The first step alone, then about equal parts."""
    edges = np.linspace(1, steps, TURNS + 1).round().astype(int)
    return [1, *(int(count) for count in np.diff(edges) if count > 0)]


def row(course: Course, stays: bool) -> str:
    """The figures of a run."""
    mean = float(np.average(course.seconds[1:], weights=course.counts[1:]))
    times = [course.seconds[0], mean, statistics.median(course.seconds[-AT_END:])]
    residuals = f"{max(course.residual):.0e} | {course.residual[-1]:.0e}" if course.residual else "- | -"
    if stays:
        moved = f"{distance(course.places[0], course.places[-1]):.1e} m"
    else:
        moved = f"{distance(*course.places[-2:]) / (course.counts[-1] * DT):.1e} m/s"
    cells = [
        *(f"{1e3 * t:.3g}" for t in times),
        residuals,
        f"{max(course.depth):.1e}",
        f"{course.depth[-1]:.1e}",
        moved,
    ]
    return " | ".join(cells)


def every_step(course: Course) -> str:
    """What our own count of all steps has, beside that of the ends of turns."""
    stats = course.motion.run.stats()
    return f"of {stats.steps} steps {stats.missed} missed tol, deepest penetration {stats.worst_penetration:.1e} m"


def distance(a: np.ndarray, b: np.ndarray) -> float:
    """The farthest that a body went [m]."""
    return float(np.linalg.norm(b - a, axis=1).max())


def print_growth(sizes: tuple[int, ...], steps: int) -> None:
    """The time of a step against the number of spheres, at the coarse tolerance."""
    courses = {n: started(AT_SPEED[1], SphereBox(n=n).scene) for n in sizes}
    judges = {n: adapter("nonsmooth_scenes").Judge(SphereBox(n=n).scene(), DT) for n in sizes}
    for count in turns(steps):
        for n, course in courses.items():
            course.take(count, judges[n])
    print("| spheres | ms a step: mean | at the end | contacts | residual: worst | penetration [m]: worst | exponent |")
    print("|---|---|---|---|---|---|---|")
    before: tuple[int, float] | None = None
    for n, course in courses.items():
        mean = float(np.average(course.seconds[1:], weights=course.counts[1:]))
        exponent = f"{math.log(mean / before[1]) / math.log(n / before[0]):.2f}" if before else ""
        print(
            f"| {n} | {1e3 * mean:.3g} | {1e3 * statistics.median(course.seconds[-AT_END:]):.3g} | "
            f"{course.motion.run.stats().contacts} | {max(course.residual):.0e} | {max(course.depth):.1e} | "
            f"{exponent} |",
            flush=True,
        )
        before = n, mean


def print_first_use() -> None:
    """Seconds of compiling of the first scene of a kind on a machine, and of the import."""
    for kind, dim in (("planar", 2), ("spatial", 3)):
        with tempfile.TemporaryDirectory() as folder:
            first, second = (script(FIRST_USE.format(dim=dim), folder, read=True) for _ in range(2))
        print(f"first {kind} scene: {first:.1f} s of processor time, once; {second:.2f} s in the next process")
    print(f"import nonsmooth: {import_time():.3f} s")


def discs(n: int) -> Scene:
    """Discs over a floor between two walls, in rows of 25 that are not quite regular."""
    r, pitch, off, a_row, rng = 0.05, 0.12, 0.005, 25, np.random.default_rng(1)
    scene = Scene(gravity=(0.0, -9.81), material=Material(mu=0.5))
    scene.fixed(HalfPlane((0, 1)), name="floor")
    for side, name in ((1, "left"), (-1, "right")):
        scene.fixed(HalfPlane((side, 0), -0.5 * pitch * a_row), name=name)
    for k in range(n):
        place = pitch * np.array([k % a_row - 0.5 * (a_row - 1), k // a_row + 0.5]) + rng.uniform(-off, off, 2)
        scene.body(Disc(r), density=1000, position=place, name=f"disc {k}")
    return scene
