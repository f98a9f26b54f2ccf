"""``python -m benchmarks limit``: where the time of a step, a call, a first use and a cell of a sweep goes.

    python -m benchmarks limit > docs/benchmarks/limit.md

Counted by removing parts. Of a step: the kernels of a part are replaced by ones that do nothing, the loop is compiled
anew, and the rod slides on to the same angle. Of a call: its stages are run up to each of them. Of a first use: its
entry points are compiled one by one in fresh processes. Of a cell: sweeps of runs of one step and of many. What cells
side by side in vectors could gain: a prototype in C for one model (belt_lanes.c). Processor time, medians of
interleaved repeats of one run of this program.
"""

from __future__ import annotations

import functools
import math
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.core import ROD_STEPS, ROOT, SPAN, compile_c, run_c, script
from benchmarks.core_scenes import sliding_rod
from benchmarks.solvers import table
from nonsmooth.catalogue.entries import load
from nonsmooth.integrators.moreau_jean import step as step_of_rod
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.jit import Kernel
from nonsmooth.jit.kernels import rebind
from nonsmooth.runs.simulate import simulate, simulate_whole
from nonsmooth.runs.simulate_system import new_run
from nonsmooth.runs.workspace import give_back
from nonsmooth.sweeps.run_task import RunTask
from nonsmooth.sweeps.sweep import sweep

REPEATS = 11
C_STEPS = 3_000_000  # of a C program, whose time is told in hundredths of a second
CALLS = 100  # of a stage of a call, timed together
CELLS = 2000  # of a sweep that is timed
SAME_ANGLE = 1e-8  # measured: rad: the step is of second order, and programs with a tenth of it differ by 1e-11
LONG = 200  # steps of a long run of a cell
DT = 1e-3  # s
LANES = (2, 4, 8)  # belts side by side
BELT_SPEEDS = [0.1 + 0.05 * lane for lane in range(max(LANES))]  # m/s, as in belt_lanes.c
LANE_STEPS = 1_000_000  # of each
PART_NAMES = {
    "energy ledger": ("book_energy",),
    "search for other solutions, seizures": ("note_paradoxes",),
    "modes and their events": ("set_mode",),
    "look for NaN": ("all_finite",),
    "rest that stays rest (rounding)": ("new_velocity",),
}
# what a first use of the rod compiles: the module and the name of each entry point
ENTRY_POINTS = {
    "the loop over records": "nonsmooth.integrators.fixed_step:run",
    "one step": "nonsmooth.integrators.moreau_jean.step:step",
    "its contact problem": "nonsmooth.integrators.moreau_jean.contact:solve",
}
COMPILE = """import sys, time
module, name = sys.argv[1].split(":")
__import__(module)
if sys.argv[2] == "compile":
    import nonsmooth.jit.internals
started = time.process_time()
getattr(sys.modules[module], name).load()
print(time.process_time() - started)"""


def main(argv: list[str] | None = None) -> int:
    """Print the page; returns the exit code."""
    print("# Where the time goes\n")
    print(
        f"Made by `python -m benchmarks limit` in one run: processor time, medians of {REPEATS} interleaved repeats on"
    )
    print("a machine that others use too: shares are to be trusted more than nanoseconds.\n")
    print_step()
    print_call()
    print_first_use()
    print_cell()
    print_lanes()
    return 0


# -- a step -----------------------------------------------------------------------------------------------------------


def book_energy(sys, dt, theta, is_implicit, n_k, state, work):
    """No energy is booked."""
    return 0.0, 0.0, 0.0


def note_paradoxes(sys, t, dt, n_k, state, scratch):
    """No other solution is looked for."""
    return False


def set_mode(sys, t, i, mode, slip, k, state, work):
    """No mode changes."""


def all_finite(n, n_c, work):
    """Whatever comes is a number."""
    return True


def without(names: Iterable[str]) -> Kernel:
    """The step of Moreau–Jean without some of its parts."""
    removed = {name: Kernel(globals()[name]) for name in names}
    return _replaced(step_of_rod.step, removed, {})


def _replaced(kernel: Kernel, removed: dict[str, Kernel], known: dict[Kernel, Kernel]) -> Kernel:
    """A kernel with others in the place of those it calls, and of those that they call; entry points stay."""
    if kernel in known:
        return known[kernel]

    def instead(inner: Kernel) -> Kernel:
        if type(inner) is not Kernel or inner.signature is not None:
            return inner
        return removed.get(inner.function.__name__) or _replaced(inner, removed, known)

    source = rebind(kernel.function, instead)  # type: ignore[arg-type]
    known[kernel] = Kernel(source, kernel.signature, kernel.short_loops, kernel.is_rare)
    return known[kernel]


def new_velocity(n, r, u, work):
    """u_1 = u_0 + du + X^T P, whatever rounding leaves of rest."""
    for i in range(n):
        work.u_1[i] = u[i] + work.du[i]
        for k in range(r):
            work.u_1[i] += work.X[k, i] * work.P[k]


@dataclass(frozen=True)
class Without(MoreauJean):
    """Moreau–Jean without some parts of its step."""

    parts: tuple[str, ...] = ()

    @property
    def step(self) -> Kernel:
        """The step that is left."""
        return variant(self.parts)


@functools.cache
def variant(parts: tuple[str, ...]) -> Kernel:
    """The step without parts; compiled once."""
    return without(name for part in parts for name in PART_NAMES[part])


def run_rod(parts: tuple[str, ...], record: str | None = None) -> tuple[float, float]:
    """Nanoseconds of processor time a step of the sliding rod, and its final angle."""
    th, integrator = math.pi / 3, Without(dt=SPAN / ROD_STEPS, parts=parts)
    start = [0, math.sin(th), th], [1, 0, 0]
    started = time.process_time()
    solution = simulate_whole(sliding_rod(), (0, SPAN), *start, integrator=integrator, every=ROD_STEPS,
                              record=record)  # fmt: skip
    return (time.process_time() - started) / ROD_STEPS * 1e9, float(solution.q[-1, 2])


def run_program(program: Path) -> tuple[float, float]:
    """The same of a C program, but for what it takes to start it."""
    began = os.times().children_user
    run_c(program, 1)
    started = os.times().children_user
    angle = run_c(program, C_STEPS)[1]
    return (os.times().children_user - started - (started - began)) / C_STEPS * 1e9, angle


def print_step() -> None:
    """A table of the parts of a step."""
    cuts = {
        "the step": (),
        **{f"without: {part}": (part,) for part in PART_NAMES},
        "without all of these": tuple(PART_NAMES),
    }
    with tempfile.TemporaryDirectory() as folder:
        programs = compile_c(Path(folder))
        runs: dict[str, Callable[[], tuple[float, float]]] = {
            name: functools.partial(run_rod, parts) for name, parts in cuts.items()
        }
        runs['`record="motion"`'] = functools.partial(run_rod, (), "motion")
        runs |= {name: functools.partial(run_program, program) for name, program in programs.items()}
        for name, run in runs.items():
            _, angle = run()  # compiled, or loaded
            if abs(angle - runs["the step"]()[1]) > SAME_ANGLE:
                raise SystemExit(f"{name} ends at another angle")
        times = interleaved({name: lambda run=run: run()[0] for name, run in runs.items()})  # type: ignore[misc]
    whole = times["the step"]
    columns = {
        "ns a step": {name: f"{statistics.median(values):.0f}" for name, values in times.items()},
        "of the step": {name: f"{ratio(values, whole):.2f}" for name, values in times.items()},
    }
    print("## A step of the rod\n")
    print_table("", columns)
    print(
        "\nWhat is left without all of these does what the C programs do, for contacts of any number and kind, with\n"
        "functions of a model in Python. Each line is the whole less one part; what two share goes with neither.\n"
    )


# -- a call -----------------------------------------------------------------------------------------------------------


def print_call() -> None:
    """A table of the stages of one `simulate` call of one step."""
    from nonsmooth.mechanics.compiled import loop_of
    from nonsmooth.mechanics.initial_state import ContactsByCode, examine_state
    from nonsmooth.mechanics.start import the_start

    system, method, th = sliding_rod(), MoreauJean(dt=DT), math.pi / 3
    q, u, span = np.array([0.0, math.sin(th), th]), np.array([1.0, 0.0, 0.0]), (0.0, DT)
    simulate(system, span, q, u, integrator=method)
    by_code = ContactsByCode(system, loop_of(system, method)[0], q, u, system.p)

    def up_to(stage: int) -> Callable[[], None]:
        def call() -> None:
            start = the_start(system, q, u, None, system)
            run = new_run(system, method, span, 1, None, *start, 0, False)
            if stage > 0:
                run.advance(None, None, None)
            if stage > 1:
                run.solution()
            give_back(system, run.workspace)

        return call

    def asked() -> None:
        solution = simulate(system, span, q, u, integrator=method)
        assert solution.stats.steps == 1 and len(solution.ledger) > 0

    calls: dict[str, Callable[[], object]] = {
        "checks of the start, q0 and u0": lambda: the_start(system, q, u, None, system),
        "modes of the contacts at the start": lambda: examine_state(system, 0.0, q, u, by_code),
        "up to the first block of steps": up_to(0),
        "and the step, with its book-keeping": up_to(1),
        "and a solution that nobody has asked yet": up_to(2),
        "`simulate`": lambda: simulate(system, span, q, u, integrator=method),
        "`simulate`, and rows, figures and ledger are asked for": asked,
    }
    for _ in range(CALLS):  # what is looked at now and then has been
        for call in calls.values():
            call()
    times = interleaved({name: functools.partial(time_of, call) for name, call in calls.items()})
    print("## A call of `simulate`, one step of the rod\n")
    print_table("", {"us": {name: f"{statistics.median(values):.1f}" for name, values in times.items()}})
    print("\nThe first two lines are parts of the third.\n")


def time_of(call: Callable[[], object]) -> float:
    """Processor time of one of CALLS calls [us]."""
    started = time.process_time()
    for _ in range(CALLS):
        call()
    return 1e6 * (time.process_time() - started) / CALLS


# -- a first use ------------------------------------------------------------------------------------------------------


def print_first_use() -> None:
    """A table of what a first use compiles, and of what a later one loads."""
    programs = {"imports numpy": "import numpy", "imports numpy and numba": "import numpy, numba"}
    seconds = {f"an empty interpreter that {does}": ("", script(program)) for does, program in programs.items()}
    rows: dict[str, dict[str, str]] = {"compiled [s]": {}, "loaded [s]": {}}
    for name, entry in ENTRY_POINTS.items():
        with tempfile.TemporaryDirectory() as folder:
            rows["compiled [s]"][name] = f"{load_time(entry, folder, 'compile'):.2f}"
            rows["loaded [s]"][name] = f"{load_time(entry, folder, 'load'):.3f}"
    for name, (first, later) in seconds.items():
        rows["compiled [s]"][name], rows["loaded [s]"][name] = first, f"{later:.2f}"
    print("## A first use\n")
    print_table("", rows)
    print(
        "\nEach entry point in a process of its own: what numba and LLVM do once in a process is in each of them.\n"
        "Processes share the work of a first use: as many as there are cores, four at most. The last\n"
        "lines are the clock of a start; what is loaded needs no numba.\n"
    )


def load_time(entry: str, cache: str, what: str) -> float:
    """Seconds of the processor for an entry point in a fresh process, which imports numba first if it compiles."""
    environment = {**os.environ, "NONSMOOTH_CACHE_DIR": cache}
    done = subprocess.run(
        [sys.executable, "-c", COMPILE, entry, what],
        env=environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout)


# -- a cell of a sweep ------------------------------------------------------------------------------------------------


def print_cell() -> None:
    """A table of what a cell of a sweep costs beside its steps."""
    belt = load("belt-oscillator")()
    speeds = {"vb": np.linspace(0.05, 0.5, CELLS)}

    def swept(steps: int, measures: list[str], journal: Path | None = None) -> float:
        task = RunTask(belt, measures, t_span=(0, steps * DT), integrator=MoreauJean(DT))
        started = time.process_time()
        sweep(task, speeds, progress=False, journal=journal, resume=False)
        return 1e6 * (time.process_time() - started) / CELLS

    with tempfile.TemporaryDirectory() as folder:
        book = Path(folder) / "journal.jsonl"
        ways: dict[str, Callable[[], float]] = {
            "one step, final state": lambda: swept(1, ["final_state"]),
            "one step, final state and paradoxes": lambda: swept(1, ["final_state", "paradoxes"]),
            "one step, both, journal": lambda: swept(1, ["final_state", "paradoxes"], book),
            f"{LONG} steps, both": lambda: swept(LONG, ["final_state", "paradoxes"]),
        }
        for way in ways.values():
            way()
        times = interleaved(ways)
    long, short = times[f"{LONG} steps, both"], times["one step, final state and paradoxes"]
    slope = statistics.median(1e3 * (a - b) / (LONG - 1) for a, b in zip(long, short, strict=True))
    print(f"## A cell of a sweep\n\nThe belt oscillator at {CELLS} speeds:\n")
    print_table("", {"us a cell": {name: f"{statistics.median(values):.2f}" for name, values in times.items()}})
    print(
        f"\nA further step takes {slope:.0f} ns; a cell of one step is its start, its checks, its rows, its place in\n"
        "the result, and what a sweep costs once, divided by its cells."
    )


# -- cells side by side -----------------------------------------------------------------------------------------------


def print_lanes() -> None:
    """A table of belt oscillators side by side in vectors, in C, beside the loop that is compiled for the belt."""
    print("\n## Cells side by side\n")
    compiler = shutil.which("gcc")
    if compiler is None:
        print("No GCC was found, whose vectors the prototype is written in.")
        return
    with tempfile.TemporaryDirectory() as folder:
        ways: dict[str, Callable[[], float]] = {"the loop compiled for the belt": run_belts}
        for lanes in LANES:
            program = Path(folder) / f"lanes{lanes}"
            source = str(Path(__file__).with_name("belt_lanes.c"))
            subprocess.run([compiler, "-O3", "-march=native", f"-DLANES={lanes}", source, "-o", str(program), "-lm"],
                           check=True)  # fmt: skip
            ways[f"{lanes} lanes in C"] = functools.partial(run_lanes, program, lanes)
        for way in ways.values():
            way()
        times = interleaved(ways)
    whole = times["the loop compiled for the belt"]
    columns = {
        "ns a step and cell": {name: f"{statistics.median(values):.0f}" for name, values in times.items()},
        "of the loop": {name: f"{ratio(values, whole):.2f}" for name, values in times.items()},
    }
    print_table("", columns)
    print("\nThe motion alone, a speed of the belt a lane, with stick and slip; all end at the same places.")


def run_belts() -> float:
    """Nanoseconds of processor time a step of belts at the speeds of the lanes, each in the loop of its own."""
    belt, started = load("belt-oscillator"), time.process_time()
    for speed in BELT_SPEEDS:
        integrator = MoreauJean(DT, specialise=True)
        simulate_whole(belt(vb=speed), (0, LANE_STEPS * DT), [0.0], [0.0], integrator=integrator, every=LANE_STEPS,
                       record="motion")  # fmt: skip
    return 1e9 * (time.process_time() - started) / LANE_STEPS / len(BELT_SPEEDS)


def run_lanes(program: Path, lanes: int) -> float:
    """The same of the prototype."""
    started = os.times().children_user
    subprocess.run([program, str(LANE_STEPS), str(DT)], capture_output=True, check=True)
    return 1e9 * (os.times().children_user - started) / LANE_STEPS / lanes


def interleaved(ways: dict[str, Callable[[], float]]) -> dict[str, list[float]]:
    """The figures of each way, taken in turns, each time begun with the next one: after a program of its own the first
    run in this process is slow (measured: up to twice)."""
    times: dict[str, list[float]] = {name: [] for name in ways}
    for repeat in range(REPEATS):
        first = repeat % len(ways)
        for name in [*ways][first:] + [*ways][:first]:
            times[name].append(ways[name]())
    return times


def ratio(values: list[float], whole: list[float]) -> float:
    """The median of the ratios of each repeat."""
    return statistics.median(a / b for a, b in zip(values, whole, strict=True))


def print_table(head: str, columns: dict[str, dict[str, str]]) -> None:
    """Named columns of named rows."""
    names = list(next(iter(columns.values())))
    print("\n".join(table(head, names, {title: [column[name] for name in names] for title, column in columns.items()})))
