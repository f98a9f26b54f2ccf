"""A run that was stopped, at whatever step, goes on to the bits of one that never was."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.core_scenes import row_of_blocks
from models import BeadChain, BouncingBall, PainleveRod, RockingBlock, SpragSlip, WallPendulum
from nonsmooth.results import checkpoint as store


def row_in_motion(n):
    speeds = np.zeros(2 * n)
    speeds[::2] = np.linspace(0.5, 1.0, n)
    return row_of_blocks(n), (0, 0.2), np.zeros(2 * n), speeds


def scene(model, span, **state):
    return model, span, *model.state(**state)


# the arguments of a run, and its options: 1 to 19 contacts, bilateral, impacts, sticking, M(q), records of every step,
# of every third, and at given times
RUNS = {
    "ball": (scene(BouncingBall(e=0.8), (0, 1), height=0.1), dict(integrator=ns.MoreauJean(1e-3), every=3)),
    "rod": (scene(PainleveRod(mu=1.6), (0, 0.2), th=0.8, thdot=-1.0, slip=1.0), dict(integrator=ns.MoreauJean(2e-4))),
    "sprag-slip": (scene(SpragSlip(), (0, 0.6), th=0.8, thdot=0.0), dict(integrator=ns.MoreauJean(1e-3, theta=0.7))),
    "pendulum": (
        scene(WallPendulum(), (0, 1)),
        dict(integrator=ns.MoreauJean(1e-3, projection=True), t_eval=np.linspace(0.05, 1, 37)),
    ),
    "rocking block": (scene(RockingBlock(), (0, 1)), dict(integrator=ns.MoreauJean(2e-3))),
    "beads": (scene(BeadChain(), (0, 0.04)), dict(integrator=ns.MoreauJean(1e-3), selection="impact")),
    "row": (row_in_motion(6), dict(integrator=ns.MoreauJean(1e-3), every=7)),
    "ball, event-driven": (scene(BouncingBall(e=0.9), (0, 3), height=0.1), dict(integrator=ns.EventDriven(1e-9))),
    "rod, event-driven": (
        scene(PainleveRod(mu=0.3), (0, 0.5), th=1.2, thdot=-1.0, slip=1.0),
        dict(integrator=ns.EventDriven(), t_eval=np.linspace(0, 0.5, 30)),
    ),
    "rod, compliant": (
        scene(PainleveRod(mu=0.3), (0, 0.1), th=1.2, thdot=-1.0, slip=1.0),
        dict(integrator=ns.Penalty(stiffness=1e5, damping_ratio=0.3), every=3),
    ),
    "sprag-slip, compliant": (
        scene(SpragSlip(), (0, 0.2), th=0.8, thdot=1.0),
        dict(integrator=ns.Penalty(stiffness=1e6, damping=1e3), t_eval=np.linspace(0.1, 0.2, 11)),
    ),
    "pendulum, adaptive": (scene(WallPendulum(), (0, 9)), dict(integrator=ns.Adaptive(rtol=1e-9), every=2)),
    "rocking block, adaptive": (scene(RockingBlock(), (0, 3)), dict(integrator=ns.Adaptive(rtol=1e-9))),
    "sprag-slip, adaptive": (scene(SpragSlip(), (0, 1)), dict(integrator=ns.Adaptive(rtol=1e-5))),
}


@pytest.mark.parametrize("name", RUNS)
def test_a_run_that_streams_to_a_file_has_the_bits_of_one_in_memory(small, tmp_path, name, bits):
    arguments, options = RUNS[name]
    streamed = ns.simulate(*arguments, **options, checkpoint=tmp_path / "run.ckpt", checkpoint_every=0)
    assert streamed.success and bits(streamed) == bits(ns.simulate(*arguments, **options))


@pytest.mark.upkeep
@pytest.mark.parametrize("name", RUNS)
def test_a_run_stopped_every_few_steps_goes_on_to_the_same_bits(small, tmp_path, name, bits):
    arguments, options = RUNS[name]
    again = dict(
        checkpoint=tmp_path / "run.ckpt", resume=tmp_path / "run.ckpt", max_wall_time=1e-9, on_failure="return"
    )
    stops = 0
    while not (solution := ns.simulate(*arguments, **options, **again)).success:
        stops += 1
        assert solution.status == ns.Status.BUDGET_SPENT and solution.stats.steps <= 19 * stops
    whole = ns.simulate(*arguments, **options)
    assert bits(solution) == bits(whole) and stops > 2


BEGIN = """
import sys
from test_checkpoint import RUNS, ns
for name, (arguments, options) in RUNS.items():
    ns.simulate(*arguments, **options, checkpoint=f"{sys.argv[1]}/{name}", max_steps=9, on_failure="return")
"""


@pytest.mark.upkeep
def test_a_run_begun_in_another_process_goes_on_to_the_same_bits_in_this_one(tmp_path, bits):
    """Addresses of compiled functions are of the process that began; they must not be taken from its file."""
    paths = os.pathsep.join(filter(None, [os.path.dirname(__file__), *sys.path]))
    began = subprocess.run(
        [sys.executable, "-c", BEGIN, str(tmp_path)], env={**os.environ, "PYTHONPATH": paths}, capture_output=True
    )
    assert began.returncode == 0, began.stderr
    for name, (arguments, options) in RUNS.items():
        resumed = ns.simulate(*arguments, **options, resume=tmp_path / name)
        assert bits(resumed) == bits(ns.simulate(*arguments, **options)), name


def test_the_state_between_two_records_at_which_a_run_stopped_is_its_last_row_until_it_goes_on(small, tmp_path, bits):
    arguments = RUNS["row"][0]
    options = dict(integrator=ns.MoreauJean(1e-3), every=10, on_failure="return")
    stopped = ns.simulate(*arguments, **options, max_steps=19, checkpoint=tmp_path / "run.ckpt")
    in_memory = ns.simulate(*arguments, **options, max_steps=19)
    assert bits(stopped) | {"message": 0} == bits(in_memory) | {"message": 0}  # which has the wall time
    assert stopped.t == pytest.approx([0.0, 0.01, 0.019], abs=1e-15)
    gone_on = ns.simulate(*arguments, **options, max_steps=38, resume=tmp_path / "run.ckpt")
    assert gone_on.t == pytest.approx([0.0, 0.01, 0.02, 0.03, 0.038], abs=1e-15)


def test_a_finished_run_is_read_not_run(tmp_path, bits):
    arguments, options = RUNS["rod"]
    first = ns.simulate(*arguments, **options, checkpoint=tmp_path / "run.ckpt")
    before = (tmp_path / "run.ckpt" / "records.npy").stat().st_mtime_ns
    again = ns.simulate(*arguments, **options, resume=tmp_path / "run.ckpt")
    assert again.success and bits(again) == bits(first) and again.stats.steps == first.stats.steps
    assert (tmp_path / "run.ckpt" / "records.npy").stat().st_mtime_ns == before


def test_a_run_that_fails_leaves_the_same_partial_solution_and_fails_again_when_resumed(small, tmp_path, bits):
    ball = BouncingBall().system()

    def mass(t, q, p, M):
        M[0, 0] = p.m * (0.5 - t) if t > 0.3 else p.m

    system = ns.System(n_q=1, mass=mass, force=ball.force, parameters=ball.parameters)
    arguments, options = (system, (0, 1), [9.0], [0.0]), dict(integrator=ns.MoreauJean(1e-3), every=30)
    partial = ns.simulate(*arguments, **options, on_failure="return")
    for place in ({"checkpoint": tmp_path / "run.ckpt"}, {"resume": tmp_path / "run.ckpt"}):
        with pytest.raises(ns.StepFailure, match="mass matrix is not positive definite") as failure:
            ns.simulate(*arguments, **options, **place)
        assert bits(failure.value.solution) == bits(partial)
        assert ns.Solution.load(tmp_path / "run.ckpt").status == ns.Status.MASS_NOT_POSITIVE


def test_the_interpreted_run_is_checkpointed_too_and_is_another_run(small, tmp_path, monkeypatch, bits):
    arguments, options = RUNS["rod"][0], dict(integrator=ns.MoreauJean(5e-3))
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    place = tmp_path / "run.ckpt"
    assert not ns.simulate(*arguments, **options, checkpoint=place, max_wall_time=1e-9, on_failure="return").success
    resumed = ns.simulate(*arguments, **options, resume=place)
    assert bits(resumed) == bits(ns.simulate(*arguments, **options)) and not resumed.stats.is_compiled
    monkeypatch.delenv("NONSMOOTH_INTERPRET")
    with pytest.raises(ns.InvalidInput, match="its is_compiled is False, here it is True"):
        ns.simulate(*arguments, **options, resume=place)


# Ctrl-C ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("moment", ["between blocks", "while rows are written", "while the state is kept"])
def test_ctrl_c_stops_at_a_whole_block_from_which_the_run_goes_on(small, tmp_path, monkeypatch, moment, bits):
    arguments, options = RUNS["ball"]
    where = {"while rows are written": "write", "while the state is kept": "keep"}.get(moment, "__init__")
    original, calls = getattr(store.Checkpoint, where), []

    def interrupted(self, *given):
        calls.append(1)
        if len(calls) == 3:
            signal.raise_signal(signal.SIGINT)
        return original(self, *given)

    monkeypatch.setattr(store.Checkpoint, where, interrupted)
    progress = (lambda _: calls.append(1) or len(calls) == 3 and signal.raise_signal(signal.SIGINT)) if (
        moment == "between blocks") else None  # fmt: skip
    stopped = ns.simulate(
        *arguments, **options, checkpoint=tmp_path / "run.ckpt", checkpoint_every=0, progress=progress
    )
    monkeypatch.setattr(store.Checkpoint, where, original)
    assert stopped.status == ns.Status.INTERRUPTED and 0 < stopped.stats.steps < 1000
    assert bits(ns.simulate(*arguments, **options, resume=tmp_path / "run.ckpt")) == bits(
        ns.simulate(*arguments, **options)
    )


def test_a_loaded_checkpoint_has_the_names_the_model_and_the_motion_of_a_fresh_run(tmp_path):
    arguments, options = RUNS["rod"]
    fresh = ns.simulate(*arguments, **options)
    streamed = ns.simulate(*arguments, **options, checkpoint=tmp_path / "rod")
    loaded = ns.Solution.load(tmp_path / "rod")
    assert loaded.system.name == fresh.system.name and loaded.described.coordinates == fresh.described.coordinates
    assert loaded.system.parameters == arguments[0]
    for name in fresh.ledger:
        np.testing.assert_array_equal(loaded.ledger[name], fresh.ledger[name])
    for t in (0.0, 0.03337, 0.2):
        for found in (streamed, loaded):
            np.testing.assert_array_equal(found(t).q, fresh(t).q)
            np.testing.assert_array_equal(found(t).u, fresh(t).u)


def test_a_checkpoint_of_some_steps_has_no_motion_between_them(tmp_path):
    arguments, options = RUNS["ball"]
    sparse = ns.simulate(*arguments, **options, checkpoint=tmp_path / "ball")
    with pytest.raises(ns.InvalidInput, match="knows its records only"):
        sparse(0.5)
