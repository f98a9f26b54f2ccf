"""``python -m benchmarks core``: nanoseconds a step, beside the same step written in C; compile, import and call times.

The rod is also stepped by two C programs compiled on the spot (where there is no C compiler, they are left out): one
with all known to the compiler, one generic through function pointers. They take the same step, mid-point, rows at the
mid-point and at the end, Delassus matrix, closed form of the contact, and end at the same angle. Each is compiled
twice: with the motion alone, to compare with ``record="motion"``, and with all that the library books of a step
(rod_books.h), to compare with a run that keeps everything. Medians of interleaved repeats.
"""

from __future__ import annotations

import functools
import math
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.core_scenes import row_of_blocks, sliding_rod
from nonsmooth.catalogue.entries import load
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.runs.simulate import simulate_whole
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Disc, HalfPlane

REPEATS = 7
MOTION = "motion"
# loops of the rod: whether compiled for it alone, and what is recorded
RODS: dict[str, tuple[bool, str | None]] = {
    "rod": (False, None), "rod, motion alone": (False, MOTION),
    "rod, own loop": (True, None), "rod, own loop, motion alone": (True, MOTION),
}  # fmt: skip
ROD_STEPS, STEPS = 300_000, 20_000
SPAN = 0.3  # s
C_PROGRAMS = {
    "hard-coded in C": ("rod.c",),
    "hard-coded in C, books as much": ("rod.c", "-DBOOKS"),
    "C through function pointers": ("rod_pointers.c",),
    "C through function pointers, books as much": ("rod_pointers.c", "-DBOOKS"),
}
AIMS = {  # chosen: how many times as long as a C program a loop may take
    ("rod, motion alone", "C through function pointers"): 1.3,
    ("rod", "C through function pointers, books as much"): 1.7,
    ("rod, own loop, motion alone", "hard-coded in C"): 1.5,
    ("rod, own loop", "hard-coded in C, books as much"): 1.5,
}
IMPORT = "import time; t = time.perf_counter(); import nonsmooth; print(time.perf_counter() - t)"
ROOT = Path(__file__).parents[1]  # where this package is found
FIRST_USE = "from benchmarks.core import run_rod; run_rod(100)"


def main(argv: list[str] | None = None) -> int:
    """Print the tables; returns the exit code."""
    print(f"{platform.platform()}, Python {platform.python_version()}, medians of {REPEATS} interleaved repeats\n")
    print_steps()
    print_calls()
    return 0


def print_steps() -> None:
    """Nanoseconds a step."""
    runs: dict[str, Callable[[], float]] = {
        name: lambda options=options: run_rod(ROD_STEPS, *options)[0]  # type: ignore[misc]
        for name, options in RODS.items()
    }
    for model in ("belt-oscillator", "bouncing-ball"):
        runs[model] = lambda model=model: run_model(model, False)  # type: ignore[misc]
        runs[f"{model}, own loop"] = lambda model=model: run_model(model, True)  # type: ignore[misc]
    for n in (2, 6, 12):
        runs[f"row of {n} blocks"] = lambda n=n: run_row(n)  # type: ignore[misc]
    for n in (1, 10):
        runs[f"scene of {n} rolling discs"] = functools.partial(run_discs, n, STEPS)
        runs[f"scene of {n} discs, every step recorded"] = functools.partial(run_discs, n, 1)
    with tempfile.TemporaryDirectory() as folder:
        runs["rod, every step recorded"] = lambda: run_recorded(None)
        runs["rod, streamed to a checkpoint"] = lambda: run_recorded(Path(folder) / "rod.ckpt")
        for name, program in compile_c(Path(folder)).items():
            runs[name] = lambda program=program: run_c(program, ROD_STEPS)[0]  # type: ignore[misc]
        times: dict[str, list[float]] = {name: [] for name in runs}
        for name in runs:
            runs[name]()  # compile, or load
        for _ in range(REPEATS):
            for name in runs:
                times[name].append(runs[name]())
    for name, values in times.items():
        print(f"{name:42s} {statistics.median(values):9.0f} ns a step")
    for (loop, floor), aim in AIMS.items():
        if floor in times:
            print(f"{loop}: {median_ratio(times[loop], times[floor]):.2f} of {floor} (aim {aim})")
    if not set(C_PROGRAMS) & set(times):
        print("no C compiler (cc or gcc) was found: nothing to compare with")


def print_calls() -> None:
    """What a call, an import and a compilation cost."""
    print(f"\n{'one simulate call':30s} {call_overhead() * 1e6:9.0f} us (one step of the rod)")
    print(f"{'import nonsmooth':30s} {import_time():9.3f} s")
    with tempfile.TemporaryDirectory() as folder:
        first, second = script(FIRST_USE, folder), script(FIRST_USE, folder)
        another = script(FIRST_USE + "; import benchmarks.core as c; t = c.time.perf_counter(); c.run_row(1); "
                         "print(c.time.perf_counter() - t)", folder, read=True)  # fmt: skip
    print(f"{'first use on a machine':30s} {first - second:9.1f} s of compiling")
    print(f"{'a new model':30s} {another:9.2f} s of compiling, once")


def median_ratio(above: list[float], below: list[float]) -> float:
    """Of figures measured in turn."""
    return statistics.median(a / b for a, b in zip(above, below, strict=True))


def run_rod(steps: int, specialise: bool = False, record: str | None = None) -> tuple[float, float]:
    """Nanoseconds a step of the sliding rod, and its final angle."""
    th = math.pi / 3
    integrator = MoreauJean(dt=SPAN / steps, specialise=specialise)
    solution = simulate_whole(
        sliding_rod(), (0, SPAN), [0, math.sin(th), th], [1, 0, 0], integrator=integrator, every=steps,
        record=record,
    )  # fmt: skip
    return solution.stats.wall_time / steps * 1e9, float(solution.q[-1, 2])


def run_recorded(checkpoint: Path | None) -> float:
    """Nanoseconds a step of the rod with a record of each, in memory or in a checkpoint."""
    th = math.pi / 3
    integrator, started = MoreauJean(dt=SPAN / ROD_STEPS), time.perf_counter()
    simulate_whole(
        sliding_rod(), (0, SPAN), [0, math.sin(th), th], [1, 0, 0], integrator=integrator, checkpoint=checkpoint
    )
    elapsed = time.perf_counter() - started
    if checkpoint:
        shutil.rmtree(checkpoint)
    return elapsed / ROD_STEPS * 1e9


def run_model(name: str, specialise: bool) -> float:
    """Nanoseconds a step of a model from its own start: the belt oscillator in its cycle, the ball that bounces."""
    model, integrator = load(name)(), MoreauJean(dt=1e-4, specialise=specialise)
    solution = simulate_whole(model, (0, STEPS * 1e-4), *model.state(), integrator=integrator, every=STEPS)
    return float(solution.stats.wall_time / STEPS * 1e9)


def run_row(n: int) -> float:
    """Nanoseconds a step of n blocks sliding in a row."""
    u_0 = np.zeros(2 * n)
    u_0[::2] = np.linspace(1.0, 2.0, n)
    solution = simulate_whole(
        row_of_blocks(n), (0, STEPS * 1e-5), np.zeros(2 * n), u_0, integrator=MoreauJean(dt=1e-5), every=STEPS
    )
    return solution.stats.wall_time / STEPS * 1e9


def run_discs(n: int, every: int) -> float:
    """Nanoseconds a step of a scene of n discs that roll, with a record of all after so many steps."""
    scene = Scene(gravity=(0.0, -9.81), material=Material(mu=0.5))
    scene.fixed(HalfPlane((0.0, 1.0)))
    for k in range(n):
        scene.body(Disc(0.1), mass=1.0, position=(0.5 * k, 0.1), velocity=(0.3, 0.0))
    started = time.perf_counter()
    simulate_whole(scene, (0, STEPS * 1e-4), integrator=MoreauJean(dt=1e-4), every=every)
    return (time.perf_counter() - started) / STEPS * 1e9


def compile_c(folder: Path) -> dict[str, Path]:
    """The C programs, if the system has a compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    programs = {}
    for name, (file, *flags) in C_PROGRAMS.items() if compiler else ():
        programs[name] = folder / "-".join([Path(file).stem, *flags])
        source = Path(__file__).with_name(file)
        subprocess.run([str(compiler), "-O2", *flags, str(source), "-o", str(programs[name]), "-lm"], check=True)
    return programs


def run_c(program: Path, steps: int) -> tuple[float, float, float]:
    """Nanoseconds a step of a C program, the final angle, and the work of friction [J], where it is booked."""
    printed = subprocess.run([str(program), str(steps)], capture_output=True, text=True, check=True).stdout
    nanoseconds, th, friction = map(float, printed.split())
    return nanoseconds, th, friction


def call_overhead() -> float:
    """Seconds of a `simulate` call that takes one step, median."""
    system, integrator, th = sliding_rod(), MoreauJean(dt=1e-3), math.pi / 3
    times = []
    for _ in range(200):
        started = time.perf_counter()
        simulate_whole(system, (0, 1e-3), [0, math.sin(th), th], [1, 0, 0], integrator=integrator)
        times.append(time.perf_counter() - started)
    return statistics.median(times)


def import_time() -> float:
    """Seconds of the import in a fresh interpreter, by its own clock: what starting it takes is as long, and varies."""
    return statistics.median(script(IMPORT, read=True) for _ in range(REPEATS))


def script(code: str, cache: str | None = None, read: bool = False) -> float:
    """Seconds that a fresh interpreter takes for some code, or the number that it prints."""
    environment = {**os.environ, **({"NONSMOOTH_CACHE_DIR": cache} if cache else {})}
    started = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, cwd=ROOT, capture_output=True, text=True, check=True
    )
    return float(done.stdout) if read else time.perf_counter() - started
