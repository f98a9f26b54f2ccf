"""Worker processes: nothing but a poison cell is lost when they die, and the results are those of one process."""

from __future__ import annotations

import functools
import importlib
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from models.belt_oscillator import BeltOscillator
from nonsmooth.sweeps.axes import as_plan
from nonsmooth.sweeps.batches import Driver, InThisProcess
from nonsmooth.sweeps.pool import LocalPool, WorkerDied
from nonsmooth.sweeps.task import FunctionTask

pytestmark = pytest.mark.upkeep

AXES = {"x": [1.0, 2.0, 3.0], "y": [10.0, 20.0, 30.0, 40.0]}
EXPECTED = np.outer(AXES["x"], AXES["y"])


def test_processes_threads_and_this_process_agree(tasks):
    here = ns.sweep(tasks.product, AXES, progress=False)
    np.testing.assert_array_equal(here.value, EXPECTED)
    xr.testing.assert_identical(here, ns.sweep(tasks.product, AXES, workers=2, progress=False))
    with ThreadPoolExecutor(3) as threads, ProcessPoolExecutor(2) as processes:
        for executor in (threads, processes):
            xr.testing.assert_identical(here, ns.sweep(tasks.product, AXES, executor=executor, progress=False))


def test_compiled_runs_in_worker_processes_have_the_same_bits():
    task = ns.RunTask(BeltOscillator(), ["final_state", "modes"], t_span=(0, 1), integrator=ns.MoreauJean(1e-3))
    axes = {"vb": np.linspace(0.1, 0.4, 6), "x": [0.0, 0.1]}
    with LocalPool(2) as pool:
        there = ns.sweep(task, axes, executor=pool, batch=5, progress=False)
    xr.testing.assert_identical(there, ns.sweep(task, axes, progress=False))


def test_a_worker_killed_at_a_random_moment_costs_nothing(tasks):
    rng = np.random.default_rng()
    axes = {"x": np.arange(20.0), "y": np.arange(5.0)}
    with LocalPool(2) as pool:
        pool.submit(tasks.product, 1, 1).result()

        def kill():
            time.sleep(rng.uniform(0.05, 0.8))
            os.kill(rng.choice(pool.pids), signal.SIGKILL)

        killer = threading.Thread(target=kill)
        killer.start()
        found = ns.sweep(tasks.slow_product, axes, executor=pool, progress=False)
        killer.join()
    xr.testing.assert_identical(found.drop_attrs(), ns.sweep(tasks.slow_product, axes, progress=False).drop_attrs())


def test_a_worker_killed_while_it_starts_costs_nothing(tasks):
    with LocalPool(1) as pool:
        first = pool.submit(tasks.product, 2, 3)
        while not pool.pids:
            time.sleep(0.001)
        os.kill(pool.pids[0], signal.SIGKILL)
        with pytest.raises(WorkerDied, match="SIGKILL"):
            first.result(timeout=60)
        assert pool.submit(tasks.product, 2, 3).result(timeout=60) == 6


def test_a_cell_whose_worker_died_once_is_tried_again(tasks, tmp_path):
    task = functools.partial(tasks.dies_once, marker=str(tmp_path / "died"))
    found = ns.sweep(task, AXES, workers=2, batch=5, progress=False)
    assert (tmp_path / "died").exists()
    np.testing.assert_array_equal(found.value, EXPECTED)


def test_a_poison_cell_is_marked_and_the_rest_finish(tasks):
    found = ns.sweep(tasks.poison, AXES, workers=2, batch=5, progress=False)
    assert found.status.sel(x=2, y=30) == ns.CellStatus.CRASHED and "SIGKILL" in found.message.sel(x=2, y=30).item()
    assert np.isnan(found.value.sel(x=2, y=30))
    is_poison = np.zeros(EXPECTED.shape, dtype=bool)
    is_poison[1, 2] = True
    assert (found.status.values[~is_poison] == ns.CellStatus.FINISHED).all()
    np.testing.assert_array_equal(found.value.values[~is_poison], EXPECTED[~is_poison])


def test_a_cell_that_takes_too_long_is_ended(tasks):
    found = ns.sweep(tasks.sleeper, AXES, timeout=2.0, batch=2, progress=False)
    assert found.status.sel(x=1, y=20) == ns.CellStatus.TIMED_OUT
    assert int((found.status == ns.CellStatus.FINISHED).sum()) == EXPECTED.size - 1


def test_what_a_task_imports_is_no_part_of_its_time(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    slow = "import multiprocessing, time\nif multiprocessing.parent_process(): time.sleep(3)\n"
    (tmp_path / "slow_to_import.py").write_text(slow + "def double(x): return 2 * x\n")
    double = importlib.import_module("slow_to_import").double
    found = ns.sweep(double, {"x": [1.0, 2.0]}, timeout=2.0, batch=1, progress=False)
    sys.modules.pop("slow_to_import")
    assert found.value.values.tolist() == [2.0, 4.0]


def test_a_task_that_cannot_be_loaded_there_says_why(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delenv("PYTHONPATH", raising=False)
    (tmp_path / "only_here.py").write_text("def double(x): return 2 * x\n")
    double = importlib.import_module("only_here").double
    (tmp_path / "only_here.py").unlink()
    with LocalPool(1) as pool, pytest.raises(ModuleNotFoundError, match="only_here"):
        pool.submit(double, 1).result(timeout=60)
    sys.modules.pop("only_here")


def test_an_exception_is_the_value_of_its_cell(tasks):
    for workers in (1, 2):
        found = ns.sweep(tasks.picky, AXES, workers=workers, progress=False)
        assert (found.status.sel(x=3) == ns.CellStatus.FAILED).all()
        assert set(found.message.sel(x=3).values) == {"ValueError: x must not be 3"}
        np.testing.assert_array_equal(found.value.values[:2], EXPECTED[:2])
        assert found.attrs["cells_failed"] == 4


def test_fail_fast_stops_at_the_first_failure(tasks):
    with pytest.raises(ns.CellFailure, match=r"x = 3.0, y = 10.0 ended with FAILED: ValueError: x must not be 3"):
        ns.sweep(tasks.picky, AXES, fail_fast=True, batch=1, progress=False)


def test_the_pool_loses_the_call_of_a_dead_worker_only(tasks):
    with LocalPool(2) as pool:
        doomed = pool.submit(tasks.poison, 2, 30)
        others = [pool.submit(tasks.product, k, 2) for k in range(20)]
        with pytest.raises(WorkerDied, match="SIGKILL"):
            doomed.result(timeout=60)
        assert [other.result(timeout=60) for other in others] == [2 * k for k in range(20)]


def test_results_and_exceptions_cross_the_pipe(tasks):
    with LocalPool(1) as pool:
        assert pool.submit(tasks.several, 3).result()["word"] == "odd"
        with pytest.raises(ValueError, match="x must not be 3"):
            pool.submit(tasks.picky, 3, 1).result()


def test_a_broken_foreign_executor_is_named(tasks):
    with ProcessPoolExecutor(1) as executor, pytest.raises(ns.InvalidInput, match="the executor broke"):
        ns.sweep(tasks.poison, AXES, executor=executor, progress=False)


def test_batches_grow_to_the_work_that_pays(tasks):
    """Cells of 2 ms: the batches grow from one cell towards 0.1 s, and each cell is in exactly one."""
    plan = as_plan({"x": np.arange(400.0), "y": [1.0]})
    task = FunctionTask(functools.partial(tasks.slow_product, seconds=0.002))
    driver = Driver(task, plan, InThisProcess(), 1, None, 1, first_size=1)
    sizes = [len(cells) for cells, _ in driver.run(np.arange(400))]
    assert sizes[0] == 1 and max(sizes) > 10 and sum(sizes) == 400


def test_interrupted_sweeps_return_what_is_there(tasks):
    def interrupt(x, y):
        if (x, y) == (2.0, 20.0):
            raise KeyboardInterrupt
        return x * y

    found = ns.sweep(interrupt, AXES, batch=1, progress=False)
    assert found.attrs["interrupted"] == 1
    done = found.status.values.reshape(-1) == ns.CellStatus.FINISHED
    assert done.tolist() == [True] * 5 + [False] * 7
    assert (found.status.values.reshape(-1)[5:] == ns.CellStatus.NOT_RUN).all()


def test_a_result_may_hold_arrays_and_texts(tasks):
    found = ns.sweep(tasks.several, {"x": [1.0, 2.0, 3.0]}, progress=False)
    assert found.pair.dims == ("x", "pair_0") and found.word.values.tolist() == ["odd", "even", "odd"]
    with pytest.raises(ns.InvalidInput, match="alike in every cell"):
        ns.sweep(tasks.uneven, {"x": [1, 2]}, progress=False)


def test_a_script_without_a_guard_is_told_of_it(tmp_path):
    script = tmp_path / "script.py"
    script.write_text("import nonsmooth as ns\ndef f(x): return x\nns.sweep(f, {'x': [1, 2]}, workers=2)\n")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run([sys.executable, str(script)], env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 1 and "must guard its own start with" in done.stderr.splitlines()[-1]
