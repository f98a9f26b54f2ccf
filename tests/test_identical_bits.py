"""The same bits from run to run, from process to process, and with any number of threads."""

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

import nonsmooth as ns
from models import BeadChain, BouncingBall, PainleveRod, SpragSlip

INTEGRATORS = [ns.MoreauJean(dt=1e-3), ns.EventDriven(), ns.Penalty(1e6, damping_ratio=0.2)]
RUN = """
import hashlib, sys
import nonsmooth as ns
from models import SpragSlip
rod = SpragSlip()
run = ns.simulate(rod, (0, 0.2), *rod.state(), integrator=ns.MoreauJean(dt=1e-3))
arrays = (run.t, run.q, run.u, run.P_N, run.P_F, run.event_rows)
print(hashlib.sha256(b"".join(a.tobytes() for a in arrays)).hexdigest())
"""


def digest(run):
    arrays = (run.t, run.q, run.u, run.P_N, run.P_F, run.event_rows)
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()


def assert_same_bits(one, other):
    for name, column in one.data_vars.items():
        if column.dtype == object:  # texts
            assert (column == other[name]).all()
        else:
            assert column.values.tobytes() == other[name].values.tobytes()


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
def test_two_runs_have_the_same_bits_whatever_ran_between_them(integrator):
    ball = BouncingBall(e=0.7)
    start = ball.state(height=1.0)
    first = ns.simulate(ball, (0, 1), *start, integrator=integrator)
    chain = BeadChain(n=3)
    ns.simulate(chain, (0, 1e-2), *chain.state(), integrator=ns.MoreauJean(dt=1e-3))  # dirties the memory
    assert digest(first) == digest(ns.simulate(ball, (0, 1), *start, integrator=integrator))


def test_two_processes_have_the_same_bits():
    """With other seeds of Python's hashes, so that the order of no set enters."""
    rod = SpragSlip()
    here = digest(ns.simulate(rod, (0, 0.2), *rod.state(), integrator=ns.MoreauJean(dt=1e-3)))
    for seed in ("1", "2"):
        done = subprocess.run([sys.executable, "-c", RUN], capture_output=True, text=True, timeout=120, check=True,
                              env={**os.environ, "PYTHONHASHSEED": seed})  # fmt: skip
        assert done.stdout.strip() == here


def test_how_often_the_clock_is_looked_at_changes_no_bit(monkeypatch):
    """Blocks of one step or of thousands: progress and budgets never enter the numbers."""
    rod = SpragSlip()
    run = {"t_span": (0, 0.2), "integrator": ns.MoreauJean(dt=1e-3)}
    whole = ns.simulate(rod, run["t_span"], *rod.state(), integrator=run["integrator"])
    monkeypatch.setattr("nonsmooth.runs.run.next_block", lambda steps, elapsed: 1)
    seen = []
    watched = ns.simulate(rod, run["t_span"], *rod.state(), integrator=run["integrator"], max_wall_time=1e3,
                          progress=seen.append)  # fmt: skip
    assert digest(whole) == digest(watched) and len(seen) > 10


@pytest.mark.parametrize("batch", [1, 7, None])
@pytest.mark.parametrize("workers", [1, 2, 3])
def test_threads_and_batches_change_no_bit_of_a_sweep(workers, batch):
    axes = {"e": np.linspace(0.1, 0.9, 20)}
    task = ns.RunTask(
        BouncingBall(), ["final_state", "penetration"], t_span=(0, 0.5), integrator=ns.MoreauJean(dt=1e-2)
    )
    one = ns.sweep(task, axes, progress=False)
    other = ns.sweep(task, axes, workers=workers, batch=batch, progress=False)
    assert_same_bits(one, other)


@pytest.mark.parametrize("workers", [1, 2, 3])
def test_threads_change_no_bit_of_a_map(workers):
    axes = {"th": np.linspace(0.2, 1.4, 60), "mu": np.linspace(0.3, 3.0, 60)}
    one, other = (ns.paradox_map(PainleveRod(), workers=number, **axes) for number in (1, workers))
    assert_same_bits(one, other)
