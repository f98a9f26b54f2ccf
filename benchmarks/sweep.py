"""``python -m benchmarks sweep``: what a sweep costs beside the bare loop, on one and two workers, what each part adds,
and a map of 10^6 states.

The cells of the grid share their speeds and starts; those of the two tables share none, and their starts come from
``model.state(...)``, or are numbers of their own (q0[0]).

The bare time of a run is that of the compiled loop alone, called for single cells of the same sweep; a call that takes
no step is subtracted, so that it holds nothing but steps. Times of the processor, which other programs on the machine
disturb less, and of the clock; medians of interleaved repeats. The processor time of other processes is not counted.
"""

from __future__ import annotations

import importlib.util
import platform
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import wait
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.catalogue.entries import load
from nonsmooth.contact.planar.single import Selection
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.runs.system_run import SystemRun
from nonsmooth.runs.times import Timetable, make_timetable
from nonsmooth.sweeps.axis_names import AxisNames
from nonsmooth.sweeps.map_task import MapTask
from nonsmooth.sweeps.pool import LocalPool
from nonsmooth.sweeps.run_rows import RowBuilder
from nonsmooth.sweeps.run_task import RunTask
from nonsmooth.sweeps.sweep import require_whole, sweep

REPEATS = 5
STEPS, DT = 200, 1e-3
SIDE = 316  # cells along each axis: 10^5 together
SAMPLE = 1000  # cells of which the bare loop is timed
CALLS = 200  # of an executor
MAP_SIDE = 1000  # states along each axis of the map
AXES: dict[str, np.ndarray] = {"vb": np.linspace(0.05, 0.5, SIDE), "x": np.linspace(0.0, 0.1, SIDE)}


def main(argv: list[str] | None = None) -> int:
    """Print the tables; returns the exit code."""
    print(f"{platform.platform()}, Python {platform.python_version()}, medians of {REPEATS} interleaved repeats\n")
    print_runs()
    print_map()
    print_parts()
    return 0


def belt_task() -> RunTask:
    """Runs of the belt oscillator: 200 steps, final state and number of paradoxes."""
    belt = load("belt-oscillator")()
    return RunTask(belt, ["final_state", "paradoxes"], t_span=(0, STEPS * DT), integrator=MoreauJean(DT))


def print_runs() -> None:
    """Time a run: bare, in a sweep, with two workers, with a journal."""
    task, cells = belt_task(), SIDE * SIDE
    with tempfile.TemporaryDirectory() as folder, LocalPool(2) as pool:
        book = Path(folder) / "journal.jsonl"
        ways: dict[str, Callable[[], np.ndarray]] = {
            "the bare loop": bare_run,
            "sweep, 1 worker": lambda: timed(task) / cells,
            "sweep, 2 workers": lambda: timed(task, workers=2) / cells,
            "sweep, 2 processes": lambda: timed(task, executor=pool) / cells,
            "sweep, 1 worker, journal": lambda: timed(task, journal=book, resume=False) / cells,
            "table, starts by state(x=...)": lambda: timed(task, cells_of_their_own("x")) / cells,
            "table, starts as q0[0]": lambda: timed(task, cells_of_their_own("q0[0]")) / cells,
        }
        times: dict[str, list[np.ndarray]] = {name: [] for name in ways}
        for name in ways:
            ways[name]()  # compile, or load
        for _ in range(REPEATS):
            for name in ways:
                times[name].append(ways[name]())
        size = book.stat().st_size / cells
    print(f"belt oscillator, {STEPS} steps a run, {cells} runs: us a run, and its ratio to the bare loop")
    print(f"{'':30s} {'processor':>18s} {'clock':>18s}")
    bare = np.array(times["the bare loop"])
    for name, values in times.items():
        (cpu, wall), (cpu_ratio, wall_ratio) = np.median(values, axis=0) * 1e6, np.median(values / bare, axis=0)
        print(f"{name:30s} {cpu:9.2f} ({cpu_ratio:6.2f}) {wall:9.2f} ({wall_ratio:6.2f})")
    print(f"{'journal':30s} {size:9.0f} bytes a cell")


def now() -> np.ndarray:
    """Processor time and clock [s]."""
    return np.array([time.process_time(), time.perf_counter()])


def timed(task: Any, cells: Any = None, **options: Any) -> np.ndarray:
    """Seconds of a sweep over the grid, or over other cells: of the processor, of the clock."""
    started = now()
    require_whole(sweep(task, AXES if cells is None else cells, progress=False, **options))
    return now() - started


def cells_of_their_own(start: str) -> np.ndarray:
    """A table in which no two cells have a speed or a start in common."""
    rng = np.random.default_rng(2)
    table = np.empty(SIDE * SIDE, dtype=[("vb", float), (start, float)])
    for name, axis in zip(("vb", start), AXES.values(), strict=True):
        table[name] = rng.uniform(axis[0], axis[-1], table.size)
    return table


def print_map() -> None:
    """Time a map of paradoxes through the sweep."""
    axes = {"th": np.linspace(0.01, 1.56, MAP_SIDE), "mu": np.linspace(0.0, 3.0, MAP_SIDE)}
    task = MapTask(load("painleve-rod")(), kept=1, slip=-1.0)
    timed(task, {name: values[:2] for name, values in axes.items()})  # compile, or load
    for workers in (1, 2):
        print_map_time(f"map of {MAP_SIDE**2} states, {workers} workers", timed(task, axes, workers=workers))
    with tempfile.TemporaryDirectory() as folder:
        book = Path(folder) / "journal.jsonl"
        print_map_time("map, 1 worker, journal", timed(task, axes, journal=book, resume=False))
        print_map_time("that journal read", timed(task, axes, journal=book))
        print(f"{'journal of the map':30s} {book.stat().st_size / MAP_SIDE**2:9.0f} bytes a cell")


def print_map_time(what: str, seconds: np.ndarray) -> None:
    """A line of the table of maps: processor and clock."""
    print(f"{what:30s} {seconds[0]:9.2f} s {'':6s} {seconds[1]:9.2f} s")


def bare_run() -> np.ndarray:
    """Seconds of the steps of one run, mean over cells spread over the sweep."""
    belt, integrator = load("belt-oscillator"), MoreauJean(DT)
    table = make_timetable(integrator, (0, STEPS * DT), STEPS, None)
    total = np.zeros(2)
    rng = np.random.default_rng(1)
    for vb, x in zip(rng.choice(AXES["vb"], SAMPLE), rng.choice(AXES["x"], SAMPLE), strict=True):
        model = belt(vb=float(vb))
        total += loop_time(model, table, float(x), STEPS) - loop_time(model, table, float(x), 0)
    return total / SAMPLE


def loop_time(model: Any, table: Timetable, x: float, steps: int) -> np.ndarray:
    """Seconds of one call of the compiled loop."""
    q_0, u_0 = model.state(x=x)
    run = SystemRun(model.system(), table.integrator, table, q_0, u_0, Selection.COMPLIANT_LIMIT, False)
    started = now()
    run.step_loop(steps)
    return now() - started


def nothing(x: float = 0.0) -> float:
    """The cheapest task."""
    return x


def print_parts() -> None:
    """What the parts cost: a cell of a Python function, a call of each executor."""
    print("\nwhat each part costs")
    x = np.arange(20_000.0)
    started = time.perf_counter()
    sweep(nothing, {"x": x}, progress=False)
    print(f"{'a Python function':30s} {(time.perf_counter() - started) / x.size * 1e6:9.2f} us a cell")
    print(f"{'a start that no other cell has':30s} {row_time('x') * 1e6:9.2f} us")
    print(f"{'a model that no other cell has':30s} {row_time('vb') * 1e6:9.2f} us")
    with LocalPool(2) as pool:
        print(f"{'a batch, local processes':30s} {call_time(pool) * 1e6:9.0f} us")
    if importlib.util.find_spec("distributed") is None:
        print("distributed is not installed: no figure for a scheduler")
        return
    from distributed import LocalCluster

    from nonsmooth.sweeps.cluster import connect

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        executor, _, client = connect(cluster.scheduler_address)
        with client:
            print(f"{'a batch, Dask on this machine':30s} {call_time(executor) * 1e6:9.0f} us")


def row_time(axis: str) -> float:
    """Processor seconds in Python for a cell whose value of one axis no other cell has."""
    task = belt_task()
    values = np.random.default_rng(1).random(20_000)
    names = AxisNames(task.model, task.integrator)
    builder = RowBuilder(task.model, {})
    started = time.process_time()
    for part in np.split(values, 20):
        for _ in builder.rows(names.split({axis: part}), np.arange(part.size), lambda cells, error: None):
            pass
    return (time.process_time() - started) / values.size


def call_time(executor: Any) -> float:
    """Seconds a call, of many that wait together."""
    wait([executor.submit(nothing, float(k)) for k in range(4)])  # the workers have started
    started = time.perf_counter()
    wait([executor.submit(nothing, float(k)) for k in range(CALLS)])
    return (time.perf_counter() - started) / CALLS
