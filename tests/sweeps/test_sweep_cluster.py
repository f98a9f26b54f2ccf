"""A real Dask scheduler with two workers on this machine's loopback."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import xarray as xr

import nonsmooth as ns
from models.belt_oscillator import BeltOscillator

pytestmark = pytest.mark.upkeep

distributed = pytest.importorskip("distributed")


@pytest.fixture
def cluster(tasks, tmp_path):
    """(address, worker processes) of a scheduler and two workers in processes of their own."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *filter(None, sys.path)])}

    def start(*arguments):
        command = [sys.executable, "-m", "distributed.cli." + arguments[0], *arguments[1:], "--no-dashboard"]
        return subprocess.Popen(
            command, env=environment, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )

    scheduler = start("dask_scheduler", "--host", "127.0.0.1", "--port", str(port))
    workers = [start("dask_worker", address, "--no-nanny", "--nthreads", "1") for _ in range(2)]
    try:
        with distributed.Client(address, timeout=60, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60)
        yield address, workers
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait()


def test_cells_run_on_the_workers_of_a_scheduler(tasks, cluster):
    address, _ = cluster
    axes = {"x": [1.0, 2.0, 3.0], "y": [10.0, 20.0]}
    there = ns.sweep(tasks.picky, axes, scheduler=address, progress=False)
    xr.testing.assert_identical(there, ns.sweep(tasks.picky, axes, progress=False))
    task = ns.RunTask(BeltOscillator(), t_span=(0, 1), integrator=ns.MoreauJean(1e-3))
    axes = {"vb": np.linspace(0.1, 0.4, 4), "x": [0.0, 0.1]}
    there = ns.sweep(task, axes, scheduler=address, batch=2, progress=False)
    xr.testing.assert_identical(there, ns.sweep(task, axes, progress=False))


def test_a_worker_of_the_cluster_killed_in_the_middle_costs_nothing(tasks, cluster):
    address, workers = cluster
    axes = {"x": np.arange(20.0), "y": np.arange(5.0)}

    def kill():
        time.sleep(0.6)
        os.kill(workers[0].pid, signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    found = ns.sweep(tasks.slow_product, axes, scheduler=address, batch=4, progress=False)
    killer.join()
    assert workers[0].wait() == -signal.SIGKILL
    np.testing.assert_array_equal(found.value, np.outer(axes["x"], axes["y"]))
    assert (found.status == ns.CellStatus.FINISHED).all()


def test_an_address_where_nobody_answers_fails_soon():
    with socket.socket() as held:  # bound, but not listening: connections are refused
        held.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{held.getsockname()[1]}"
        started = time.monotonic()
        with pytest.raises(ns.InvalidInput, match="no Dask scheduler answers at"):
            ns.sweep(lambda x: x, {"x": [1]}, scheduler=address, progress=False)
        assert time.monotonic() - started < 30  # the limit is 10 s, and a busy machine takes its time


def test_an_address_that_is_none_is_refused():
    with pytest.raises(ns.InvalidInput, match="no Dask scheduler answers at"):
        ns.sweep(lambda x: x, {"x": [1]}, scheduler="nonsense://", progress=False)
