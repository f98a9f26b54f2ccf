"""What a run has written outlives its program: kill -9, torn files, a full disk; and its memory stays bounded."""

import gc
import json
import os
import signal
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall
from nonsmooth.results import checkpoint as store
from nonsmooth.runs import run as run_module
from nonsmooth.runs import streaming

pytestmark = pytest.mark.upkeep

BALL = (BouncingBall(e=0.8), (0, 1), *BouncingBall().state(height=0.1))
STEP = dict(integrator=ns.MoreauJean(1e-3), every=3)

HARNESS = """
import json, os, random, signal, sys, time
import numpy as np
import nonsmooth as ns
from models import BouncingBall
from nonsmooth.results import checkpoint
from nonsmooth.results import growing_array
from nonsmooth.runs import streaming

streaming.WINDOW = 4096  # bytes: some thirty records between two writes
os.fsync = lambda file: None  # what was written outlives the process
folder, way = sys.argv[1:]
ball = BouncingBall(e=0.8)
arguments = (ball, (0, 2), *ball.state(height=0.1))
options = dict(integrator=ns.MoreauJean(1e-3), every=2)
columns = ("t", "q", "u", "g_N", "P_N", "P_F", "mode", "slip", "event_rows")
whole = ns.simulate(*arguments, **options)


def same(a, b):
    return all(getattr(a, name).tobytes() == getattr(b, name).tobytes() for name in columns)


def die_at(place):
    # The process is killed at its so-many-th act on the files; a write of several bytes is torn, its half is done.
    acts, put, replace, sync = [0], growing_array.GrowingArray._put, os.replace, os.fsync

    def count(before=lambda: None):
        acts[0] += 1
        if acts[0] == place:
            before()
            os.kill(os.getpid(), signal.SIGKILL)

    def torn(self, where, data):
        count(lambda: len(data) > growing_array.SHAPE_BYTES and put(self, where, data[: len(data) // 2]))
        put(self, where, data)

    growing_array.GrowingArray._put = torn
    os.replace = lambda *pair: (count(), replace(*pair), count())
    os.fsync = lambda file: (count(), sync(file))


def child(path, place):
    if place:
        die_at(place)
    resumed = {} if not os.path.exists(path) else {"resume": path}
    ns.simulate(*arguments, **options, checkpoint=path, **resumed, checkpoint_every=0)


began = time.perf_counter()
child(f"{folder}/whole.ckpt", 0)
lasts = time.perf_counter() - began  # as long as a child would, on this machine and in this hour
rng = random.Random(8)
killed, lost = 0, 0
for trial in range(12):
    path = f"{folder}/{trial}.ckpt"
    for _ in range(2):  # killed, and killed again after it went on
        place = rng.randint(1, 100) if way == "acts" else 0
        pid = os.fork()
        if pid == 0:
            child(path, place)
            os._exit(0)
        if way == "moments":
            time.sleep(rng.uniform(0.0, 1.5 * lasts))
            os.kill(pid, signal.SIGKILL)
        killed += os.waitpid(pid, 0)[1] == signal.SIGKILL
        if os.path.exists(f"{path}/state.npz"):
            about, _ = checkpoint.read_state(checkpoint.Path(path))
            rows = np.load(f"{path}/records.npy", mmap_mode="r")  # the ordinary reader
            assert len(rows) >= about["records"], "the state is newer than the records"
            lost = max(lost, len(rows) - about["records"])
            found = ns.Solution.load(path)
            for name in columns:
                rows_of = getattr(found, name)
                assert rows_of.tobytes() == getattr(whole, name)[: len(rows_of)].tobytes(), name
            assert len(found.t) == len(rows) and len(found.event_rows) >= about["events"]
    resumed = ns.simulate(*arguments, **options, checkpoint=path, resume=path)
    assert resumed.success and same(resumed, whole), trial
    assert resumed.stats.steps == whole.stats.steps and resumed.stats.lcp_solved == whole.stats.lcp_solved
print(json.dumps({"killed": killed, "window": streaming.WINDOW // rows.dtype.itemsize, "lost": lost}))
"""


def run_script(code, tmp_path, *words):
    """What a script prints, as JSON."""
    script = tmp_path / "script.py"
    script.write_text(code)
    ended = subprocess.run(
        [sys.executable, str(script), str(tmp_path), *words], capture_output=True, text=True, timeout=300,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    return json.loads(ended.stdout)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs kill -9 and fork")
@pytest.mark.parametrize("way", ["acts", "moments"])
def test_kill_9_at_any_moment_leaves_a_file_that_opens_and_goes_on_to_the_same_bits(tmp_path, way):
    report = run_script(HARNESS, tmp_path, way)
    if way == "acts":  # each of 24 was killed: a run makes more than a hundred acts; never more than a window is lost
        assert report["killed"] == 24
    assert report["lost"] <= report["window"]


def test_what_a_dying_program_left_behind_its_last_row_is_not_looked_at(small, tmp_path, bits):
    path = tmp_path / "run.ckpt"
    stopped = ns.simulate(*BALL, **STEP, checkpoint=path, max_wall_time=1e-9, on_failure="return")
    for name in ("records.npy", "events.npy", store.PART):
        with open(path / name, "ab") as file:
            file.write(b"torn" * 11)
    assert bits(ns.Solution.load(path)).items() <= bits(stopped).items()
    assert bits(ns.simulate(*BALL, **STEP, resume=path)) == bits(ns.simulate(*BALL, **STEP))


def test_a_run_that_died_before_its_first_state_was_kept_begins_again(small, tmp_path, monkeypatch, bits):
    path = tmp_path / "run.ckpt"
    with monkeypatch.context() as patch, pytest.raises(MemoryError):
        patch.setattr(np, "savez", lambda *_, **__: (_ for _ in ()).throw(MemoryError()))
        ns.simulate(*BALL, **STEP, checkpoint=path)
    assert not (path / store.STATE).exists() and (path / "records.npy").exists()
    assert bits(ns.simulate(*BALL, **STEP, resume=path)) == bits(ns.simulate(*BALL, **STEP))


NEARLY_FULL = """
import json, os, resource, sys
import numpy as np
import nonsmooth as ns
from models import BouncingBall
from nonsmooth.runs import streaming

streaming.WINDOW = 4096
os.fsync = lambda file: None
path = sys.argv[1] + "/run.ckpt"
ball = BouncingBall(e=0.8)
arguments, step = (ball, (0, 2), *ball.state(height=0.1)), ns.MoreauJean(1e-3)
whole = ns.simulate(*arguments, integrator=step)
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, resource.RLIM_INFINITY))
try:
    ns.simulate(*arguments, integrator=step, checkpoint=path, checkpoint_every=0)
except ns.CheckpointFailure as failure:
    message = str(failure)
rows = np.load(path + "/records.npy", mmap_mode="r")
partial = ns.Solution.load(path)
resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
resumed = ns.simulate(*arguments, integrator=step, resume=path)
print(json.dumps({
    "message": message, "rows": len(rows), "whole": len(whole.t), "bytes": rows.dtype.itemsize,
    "partial": partial.q.tobytes() == whole.q[: len(rows)].tobytes(), "status": partial.status.name,
    "resumed": resumed.q.tobytes() == whole.q.tobytes() and resumed.success,
}))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs RLIMIT_FSIZE")
def test_a_disk_that_fills_up_stops_the_run_with_a_sentence_and_costs_nothing_that_was_written(tmp_path):
    report = run_script(NEARLY_FULL, tmp_path)
    assert (
        report["message"].startswith("the checkpoint ") and "could not be written: File too large" in report["message"]
    )
    window = 4096 // report["bytes"]
    assert 100_000 / report["bytes"] - 2 * window - 10 < report["rows"] < report["whole"]
    assert report["partial"] and report["resumed"] and report["status"] == "INTERRUPTED"


def test_the_memory_of_a_run_that_streams_does_not_grow_with_its_records(tmp_path, monkeypatch):
    monkeypatch.setattr(streaming, "WINDOW", 2**16)
    monkeypatch.setattr(os, "fsync", lambda file: None)
    ns.simulate(*BALL, **STEP, checkpoint=tmp_path / "first.ckpt")  # imports and caches
    monkeypatch.setattr(run_module, "next_block", lambda steps, seconds: 1000)  # not as the clock goes
    peaks = {}
    for n in (10_000, 100_000):
        path = tmp_path / f"{n}.ckpt"
        options = dict(integrator=ns.MoreauJean(1e-5), checkpoint=path, checkpoint_every=0)
        gc.collect()
        tracemalloc.start()
        solution = ns.simulate(BALL[0], (0, n * 1e-5), *BALL[2:], **options)
        solution.summary()
        peaks[n] = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert len(solution.t) == n + 1
        record_bytes = (path / "records.npy").stat().st_size
    assert record_bytes > 9e6 and max(peaks.values()) < 2**20
    assert peaks[100_000] < peaks[10_000] + 2**16


def test_a_checkpoint_is_read_with_numpy_alone_and_holds_no_pickle(tmp_path, bits):
    solution = ns.simulate(*BALL, **STEP, checkpoint=tmp_path / "run.ckpt")
    records = np.load(tmp_path / "run.ckpt" / "records.npy", mmap_mode="r", allow_pickle=False)
    events = np.load(tmp_path / "run.ckpt" / "events.npy", allow_pickle=False)
    assert (records["q"] == solution.q).all() and (records["P_N"] == solution.P_N).all()
    assert (events["t"] == [event.t for event in solution.events]).all() and len(events) > 3
    with np.load(tmp_path / "run.ckpt" / "state.npz", allow_pickle=False) as state:
        assert json.loads(str(state["about"]))["records"] == len(records)
        assert {state[name].dtype.kind for name in state.files} == {"U", "i"}
    saved = ns.Solution.load(solution.save(tmp_path / "run.npz"))
    assert bits(saved) == bits(solution)
