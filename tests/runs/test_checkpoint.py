"""A run that was stopped, at whatever step, goes on to the bits of one that never was."""

import json
import signal
import subprocess
import sys
from dataclasses import asdict

import numpy as np
import pytest

import nonsmooth as ns
from models import BeadChain, BouncingBall, PainleveRod, RockingBlock, SpragSlip, WallPendulum
from nonsmooth.bench.scenes import row_of_blocks
from nonsmooth.output import checkpoint as store
from nonsmooth.runs import run as runs
from nonsmooth.runs import streamed_run

COLUMNS = ("t", "q", "u", "g_N", "P_N", "P_F", "mode", "slip", "event_rows")


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
    "beads": (scene(BeadChain(), (0, 0.1)), dict(integrator=ns.MoreauJean(1e-3), selection="impact")),
    "row": (row_in_motion(6), dict(integrator=ns.MoreauJean(1e-3), every=7)),
}


def bits(solution):
    """All that a run computed, as bytes."""
    arrays = {name: np.ascontiguousarray(getattr(solution, name)).tobytes() for name in COLUMNS}
    ledger = {name: np.ascontiguousarray(column).tobytes() for name, column in solution.ledger.items()}
    stats = {name: value for name, value in asdict(solution.stats).items() if not name.endswith("_time")}
    return arrays | ledger | stats | {"message": solution.message, "about": solution.about}


@pytest.fixture
def small(monkeypatch):
    """Windows of some 20 records, and stops after 7 steps: between two records, too."""
    monkeypatch.setattr(streamed_run, "WINDOW", 4096)
    monkeypatch.setattr(runs, "FIRST_BLOCK", 7)


@pytest.mark.parametrize("name", RUNS)
def test_a_run_that_streams_to_a_file_has_the_bits_of_one_in_memory(small, tmp_path, name):
    arguments, options = RUNS[name]
    streamed = ns.simulate(*arguments, **options, checkpoint=tmp_path / "run.ckpt", checkpoint_every=0)
    assert streamed.success and bits(streamed) == bits(ns.simulate(*arguments, **options))


@pytest.mark.parametrize("name", RUNS)
def test_a_run_stopped_every_few_steps_goes_on_to_the_same_bits(small, tmp_path, name):
    arguments, options = RUNS[name]
    again = dict(checkpoint=tmp_path / "run.ckpt", resume=tmp_path / "run.ckpt", max_wall_time=1e-9)
    stops = 0
    while not (solution := ns.simulate(*arguments, **options, **again)).success:
        stops += 1
        assert solution.status == ns.Status.INTERRUPTED and stops <= solution.stats.steps <= 7 * stops
    whole = ns.simulate(*arguments, **options)
    assert bits(solution) == bits(whole) and stops > 5


def test_the_state_between_two_records_at_which_a_run_stopped_is_its_last_row_until_it_goes_on(small, tmp_path):
    arguments, options = RUNS["row"][0], dict(integrator=ns.MoreauJean(1e-3), every=10, max_wall_time=1e-9)
    stopped = ns.simulate(*arguments, **options, checkpoint=tmp_path / "run.ckpt")
    assert bits(stopped) == bits(ns.simulate(*arguments, **options)) and stopped.t.tolist() == [0.0, 7e-3]
    gone_on = ns.simulate(*arguments, **options, resume=tmp_path / "run.ckpt")
    assert gone_on.t == pytest.approx([0.0, 0.01, 0.014], abs=1e-15)


def test_a_finished_run_is_read_not_run(tmp_path):
    arguments, options = RUNS["rod"]
    first = ns.simulate(*arguments, **options, checkpoint=tmp_path / "run.ckpt")
    before = (tmp_path / "run.ckpt" / store.RECORDS).stat().st_mtime_ns
    again = ns.simulate(*arguments, **options, resume=tmp_path / "run.ckpt")
    assert again.success and bits(again) == bits(first) and again.stats.steps == first.stats.steps
    assert (tmp_path / "run.ckpt" / store.RECORDS).stat().st_mtime_ns == before


def test_a_run_that_fails_leaves_the_same_partial_solution_and_fails_again_when_resumed(small, tmp_path):
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


def test_the_interpreted_run_is_checkpointed_too_and_is_another_run(small, tmp_path, monkeypatch):
    arguments, options = RUNS["rod"][0], dict(integrator=ns.MoreauJean(5e-3))
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    place = tmp_path / "run.ckpt"
    assert not ns.simulate(*arguments, **options, checkpoint=place, max_wall_time=1e-9).success
    resumed = ns.simulate(*arguments, **options, resume=place)
    assert bits(resumed) == bits(ns.simulate(*arguments, **options)) and not resumed.stats.is_compiled
    monkeypatch.delenv("NONSMOOTH_INTERPRET")
    with pytest.raises(ns.InvalidInput, match="its is_compiled is False, here it is True"):
        ns.simulate(*arguments, **options, resume=place)


# Ctrl-C ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("moment", ["between blocks", "while rows are written", "while the state is kept"])
def test_ctrl_c_stops_at_a_whole_block_from_which_the_run_goes_on(small, tmp_path, monkeypatch, moment):
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


# kill -9 --------------------------------------------------------------------------------------------------------------

HARNESS = """
import json, os, random, signal, sys, time
import numpy as np
import nonsmooth as ns
from models import BouncingBall
from nonsmooth.output import checkpoint, growing_array
from nonsmooth.runs import streamed_run

streamed_run.WINDOW = 4096  # bytes: some thirty records between two writes
folder, way = sys.argv[1:]
ball = BouncingBall(e=0.8)
arguments = (ball, (0, 2), *ball.state(height=0.1))
options = dict(integrator=ns.MoreauJean(1e-3), every=2)
columns = ("t", "q", "u", "g_N", "P_N", "P_F", "mode", "slip", "event_rows")
whole = ns.simulate(*arguments, **options)


def same(a, b, m=None):
    return all(np.ascontiguousarray(getattr(a, n)[:m]).tobytes() == np.ascontiguousarray(getattr(b, n)[:m]).tobytes()
               for n in columns)


def die_at(place):
    # The process is killed at its so-many-th act on the files; a write of several bytes is torn, its half is done.
    acts, put, replace, sync = [0], growing_array.GrowingArray._put, os.replace, os.fsync

    def count(before=lambda: None):
        acts[0] += 1
        if acts[0] == place:
            before()
            os.kill(os.getpid(), signal.SIGKILL)

    def torn(self, where, data):
        count(lambda: len(data) > growing_array.COUNT and put(self, where, data[: len(data) // 2]))
        put(self, where, data)

    growing_array.GrowingArray._put = torn
    os.replace = lambda *pair: (count(), replace(*pair), count())
    os.fsync = lambda file: (count(), sync(file))


def child(path, place):
    if place:
        die_at(place)
    resumed = {} if not os.path.exists(path) else {"resume": path}
    ns.simulate(*arguments, **options, checkpoint=path, **resumed, checkpoint_every=0)


rng = random.Random(8)
killed, lost = 0, 0
for trial in range(40):
    path = f"{folder}/{trial}.ckpt"
    for _ in range(2):  # killed, and killed again after it went on
        place = rng.randint(1, 100) if way == "acts" else 0
        pid = os.fork()
        if pid == 0:
            child(path, place)
            os._exit(0)
        if way == "moments":
            time.sleep(rng.uniform(0.0, 0.05))
            os.kill(pid, signal.SIGKILL)
        killed += os.waitpid(pid, 0)[1] == signal.SIGKILL
        if os.path.exists(f"{path}/state.npz"):
            about, _ = checkpoint.read_state(checkpoint.Path(path))
            rows = np.load(f"{path}/records.npy", mmap_mode="r")  # the ordinary reader
            assert len(rows) >= about["records"], "the state is newer than the records"
            lost = max(lost, len(rows) - about["records"])
            found = ns.Solution.load(path)
            assert same(found, whole, len(rows)) if len(found.event_rows) >= len(whole.event_rows) else True
            for name in columns[:-1]:
                assert getattr(found, name).tobytes() == getattr(whole, name)[: len(rows)].tobytes(), name
            n = about["events"]
            assert (found.event_rows[:n] == whole.event_rows[:n]).all()
    resumed = ns.simulate(*arguments, **options, checkpoint=path, resume=path)
    assert resumed.success and same(resumed, whole), trial
    assert resumed.stats.steps == whole.stats.steps and resumed.stats.lcp_solved == whole.stats.lcp_solved
print(json.dumps({"killed": killed, "window": streamed_run.WINDOW // rows.dtype.itemsize, "lost": lost}))
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs kill -9 and fork")
@pytest.mark.parametrize("way", ["acts", "moments"])
def test_kill_9_at_any_moment_leaves_a_file_that_opens_and_goes_on_to_the_same_bits(tmp_path, way):
    script = tmp_path / "harness.py"
    script.write_text(HARNESS)
    ended = subprocess.run(
        [sys.executable, str(script), str(tmp_path), way], capture_output=True, text=True, timeout=300,
        env=environment(), stdin=subprocess.DEVNULL,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    report = json.loads(ended.stdout)
    if way == "acts":  # 80 trials, each killed: a run makes more than a hundred acts; never more than a window is lost
        assert report["killed"] == 80
    assert report["lost"] <= report["window"]


def environment():
    import os

    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
