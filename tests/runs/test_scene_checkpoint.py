"""A run of a scene that was stopped, at whatever step, goes on to the bits of one that never was."""

import os
import signal
import subprocess
import sys
import tracemalloc
from dataclasses import asdict

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.commands.cli import main
from nonsmooth.results import checkpoint as store
from nonsmooth.runs import recorder, scene_run, spring_run

pytestmark = [
    pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning"),  # of small heaps
    pytest.mark.filterwarnings("ignore::nonsmooth.PenetrationWarning"),  # of springs, which are soft to be fast
]

DT = 2e-3
STEP = dict(integrator=ns.MoreauJean(dt=DT), every=3)
SPRINGS = dict(integrator=ns.Penalty(1e6, damping_ratio=0.3), every=5)
ALL_KINDS = {"record": ("bodies", "contacts", "ledger", "pairs")}
OF_TIME = ("wall_time", "compile_time", "asleep")  # a step is left out within a block of steps, whose length is of time


def falling(dim=2, e=0.3, n=8, mu=0.5):
    """Bodies that fall on one another and rebound: contacts come and go, islands are swept and factorised."""
    scene = ns.Scene(gravity=(0,) * (dim - 1) + (-9.81,), material=ns.Material(mu=mu, e=e))
    scene.fixed(ns.HalfPlane((0, 1)) if dim == 2 else ns.HalfSpace((0, 0, 1)), name="ground")
    for k in range(n):
        round_one, box = (ns.Disc(0.1), ns.Box(0.2, 0.15)) if dim == 2 else (ns.Sphere(0.1), ns.Box(0.2, 0.15, 0.15))
        place = (0.03 * (-1) ** k, 0.11 + 0.22 * k) if dim == 2 else (0.03 * (-1) ** k, 0.02 * k, 0.11 + 0.22 * k)
        scene.body(round_one if k % 2 else box, density=1000, position=place, name=f"body {k}")
    return scene


def stack_on_a_table_that_moves():
    """Boxes of unlike masses, whose factors are kept from step to step, on a guided body."""
    scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.5))
    scene.kinematic(ns.Box(2, 0.1), motion=lambda t: (0.1 * np.sin(3 * t), -0.05), name="table")
    for k in range(4):
        scene.body(ns.Box(0.2, 0.2), mass=1 + 99 * (k == 3), position=(0, 0.1 + 0.2 * k), name=f"box {k}")
    return scene


def chain_in_a_heap():
    """A heap on which a chain falls: rows of joints, drifts that are taken back, impulses of joints."""
    scene = falling(n=4)
    for k in range(4):
        scene.body(ns.Box(0.16, 0.04), mass=0.5, position=(0.3 + 0.2 * k, 0.5), name=f"link {k}")
    for k in range(3):
        scene.joint(f"link {k}", f"link {k + 1}", at=(0.4 + 0.2 * k, 0.5))
    return scene


def octagons_that_fall_on_one_another():
    """Eight points each, when they have landed: more contacts than a scene of so many bodies has room for at first."""
    corners = [(0.1 * np.cos(a), 0.1 * np.sin(a), z) for z in (-0.05, 0.05) for a in np.arange(8) * np.pi / 4]
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    for k in range(4):
        scene.body(ns.Polyhedron(corners), density=1000, position=(0, 0, 0.05 + 0.101 * k), name=f"octagon {k}")
    return scene


SCENES = {
    "heap": falling, "spatial heap": lambda: falling(3, n=4), "moved stack": stack_on_a_table_that_moves,
    "chain in a heap": chain_in_a_heap, "rest": lambda: falling(n=1, e=0.0),
}  # fmt: skip


def bits(solution):
    """All that a run computed, as bytes."""
    columns = {name: getattr(solution, name) for name in ("t", "residual", "penetration")}
    if "bodies" in solution.recorded:
        columns |= {name: getattr(solution, name) for name in ("position", "turn", "velocity", "spin")}
    if "ledger" in solution.recorded:
        columns |= solution.ledger
    if "contacts" in solution.recorded:
        columns |= {f"contacts {name}": column for name, column in solution.all_contacts.columns.items()}
        columns["joint_impulses"] = solution.joint_impulses
    if "pairs" in solution.recorded:
        columns |= {f"pairs {name}": getattr(solution.pairs, name) for name in solution.pairs.columns}
    stats = {name: value for name, value in asdict(solution.stats).items() if name not in OF_TIME}
    return {name: np.ascontiguousarray(column).tobytes() for name, column in columns.items()} | stats


@pytest.fixture
def small(monkeypatch):
    """Windows of two records; nothing waits for the disk."""
    monkeypatch.setattr(recorder, "SCENE_WINDOW", 64)
    monkeypatch.setattr(os, "fsync", lambda file: None)


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_stopped_every_few_steps_goes_on_to_the_same_bits(small, tmp_path, name):
    all_kinds = STEP | ALL_KINDS
    whole = ns.simulate(SCENES[name](), (0, 0.4), **all_kinds)
    stops, path = 0, tmp_path / "run.nsc"
    again = all_kinds | dict(checkpoint=path, resume=path, on_failure="return")
    while not (cut := ns.simulate(SCENES[name](), (0, 0.4), **again, max_steps=17 * (stops + 1))).success:
        stops += 1
        assert cut.status == ns.Status.BUDGET_SPENT and cut.stats.steps == 17 * stops
        assert cut.t[-1] == pytest.approx(17 * stops * DT, abs=1e-12)
    assert stops == 11 and bits(cut) == bits(whole)
    assert bits(ns.simulate(SCENES[name](), (0, 0.4), **all_kinds, resume=path)) == bits(whole)  # it is read, not run


RUNS_OF_SPRINGS = {
    "heap": (falling, (0, 0.3), SPRINGS),
    "spatial heap": (lambda: falling(3, n=4), (0, 0.15), SPRINGS),
    "record times": (falling, (0, 0.3), SPRINGS | {"every": 1, "t_eval": np.linspace(0.02, 0.3, 9)}),
    "a time alone": (falling, (0, 0.1), SPRINGS | {"every": 1, "t_eval": [0.1]}),
    "every step": (lambda: falling(n=2), (0, 0.15), SPRINGS | {"every": 1}),
    "more room": (octagons_that_fall_on_one_another, (0, 0.03), SPRINGS),
    "regularised": (
        falling, (0, 0.2), {"integrator": ns.Penalty(1e6, damping=50.0, friction=ns.Regularised(1e-3)), "every": 5}
    ),
}  # fmt: skip


@pytest.mark.upkeep
@pytest.mark.parametrize("name", RUNS_OF_SPRINGS)
def test_a_scene_on_springs_stopped_every_few_steps_goes_on_to_the_same_bits(small, tmp_path, name):
    """Elongations, the rates at the state and the length that the next step is tried with are kept too."""
    scene, span, options = RUNS_OF_SPRINGS[name]
    options = options | ALL_KINDS
    whole = ns.simulate(scene(), span, **options)
    few, stops, path = whole.stats.steps // 7 + 1, 0, tmp_path / "run.nsc"
    again = options | dict(checkpoint=path, resume=path, on_failure="return")
    while not (cut := ns.simulate(scene(), span, **again, max_steps=few * (stops + 1))).success:
        stops += 1
        assert cut.status == ns.Status.BUDGET_SPENT and cut.stats.steps == few * stops
        found = bits(cut)  # of files that the next run writes to
        at_once = ns.simulate(scene(), span, **again, max_steps=few * stops)
        assert bits(at_once) == found  # a run that goes on and takes no step ends with the same contacts
    assert name != "more room" or whole.stats.most_contacts > 2 * 5 + 16  # what five shapes have room for at first
    assert stops == 6 and bits(cut) == bits(whole) and cut.stats.lengths.rejected > 0
    assert {"elastic", "damping"} < cut.ledger.keys()
    assert bits(ns.simulate(scene(), span, **options, resume=path)) == bits(whole)  # it is read, not run
    assert bits(ns.SceneSolution.load(path)) == bits(whole)


def test_a_run_on_springs_whose_steps_vanish_fails_again_where_it_failed(small, tmp_path):
    options = SPRINGS | {"checkpoint": tmp_path / "run.nsc", "resume": tmp_path / "run.nsc", "on_failure": "return"}
    integrator = ns.Penalty(1e6, damping_ratio=0.3, rtol=1e-13, atol=1e-300)
    first, second = (ns.simulate(falling(n=2), (0, 0.1), **options | {"integrator": integrator}) for _ in range(2))
    assert first.status == second.status == ns.Status.STEP_VANISHED and bits(first) == bits(second)


@pytest.mark.parametrize("record", [("bodies",), "contacts", ("ledger", "bodies"), "pairs", ()])
def test_what_is_not_recorded_is_refused_by_name_and_changes_no_bit_of_the_rest(small, tmp_path, record):
    whole = bits(ns.simulate(falling(), (0, 0.2), **STEP, record=("bodies", "contacts", "ledger", "pairs")))
    in_memory = ns.simulate(falling(), (0, 0.2), **STEP, record=record)
    streamed = ns.simulate(falling(), (0, 0.2), **STEP, record=record, checkpoint=tmp_path / "run.nsc")
    in_memory.save(tmp_path / "run.npz")
    loaded = ns.SceneSolution.load(tmp_path / "run.npz")
    for solution in (in_memory, streamed, loaded):
        assert set(solution.recorded) == set([record] if isinstance(record, str) else record)
        assert bits(solution).items() <= whole.items()
        assert "steps" in solution.summary() and repr(solution)
    columns = {"bodies": "position", "contacts": "all_contacts", "ledger": "ledger", "pairs": "pairs"}
    for kind in columns.keys() - set(in_memory.recorded):
        with pytest.raises(ns.InvalidInput, match=rf'{columns[kind]} was not recorded; .*record=\("{kind}"'):
            getattr(in_memory, columns[kind])


HARNESS = """
import os, random, signal, sys, time
sys.path.insert(0, sys.argv[2])
import test_scene_checkpoint as cases
import nonsmooth as ns
from nonsmooth.results import growing_array
from nonsmooth.runs import recorder
recorder.SCENE_WINDOW = 64
os.fsync = lambda file: None
options = getattr(cases, sys.argv[3])
whole = ns.simulate(cases.falling(), (0, 0.4), **options)


def child(path, place):  # killed at its so-many-th act on the files; a write of several bytes is torn
    acts, put, replace = [0], growing_array.GrowingArray._put, os.replace

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
    ns.simulate(cases.falling(), (0, 0.4), **options, checkpoint=path, resume=path, checkpoint_every=0)


rng, killed = random.Random(5), 0
for trial in range(10):
    path = f"{sys.argv[1]}/{trial}.nsc"
    for _ in range(2):
        place = rng.randint(1, 100)
        pid = os.fork()
        if pid == 0:
            child(path, place)
            os._exit(0)
        is_killed = os.waitpid(pid, 0)[1] == signal.SIGKILL
        killed += is_killed
        if os.path.exists(f"{path}/state.npz"):
            found = ns.SceneSolution.load(path)
            n = len(found.t)
            assert found.position.tobytes() == whole.position[:n].tobytes()
            m = found.all_contacts.offsets[-1]
            assert found.all_contacts.P.tobytes() == whole.all_contacts.P[:m].tobytes()
            assert not (is_killed and found.success and n < len(whole.t))
    resumed = ns.simulate(cases.falling(), (0, 0.4), **options, checkpoint=path, resume=path)
    assert resumed.success and cases.bits(resumed) == cases.bits(whole), trial
print(killed)
"""


@pytest.mark.upkeep
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs kill -9 and fork")
@pytest.mark.parametrize("options", ["STEP", "SPRINGS"])
def test_kill_9_at_any_act_on_the_files_leaves_a_checkpoint_that_goes_on_to_the_same_bits(tmp_path, options):
    script = tmp_path / "script.py"
    script.write_text(HARNESS)
    ended = subprocess.run(
        [sys.executable, str(script), str(tmp_path), os.path.dirname(__file__), options], capture_output=True,
        text=True, timeout=300, env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    assert int(ended.stdout.split()[-1]) > 10


@pytest.mark.upkeep
@pytest.mark.parametrize("options", [STEP, SPRINGS], ids=["steps", "springs"])
@pytest.mark.parametrize("moment", ["write", "keep"])
def test_ctrl_c_while_files_are_written_waits_until_they_are_whole(small, tmp_path, monkeypatch, moment, options):
    original, calls = getattr(store.Checkpoint, moment), []

    def interrupted(self, *given):
        calls.append(1)
        if len(calls) == 3:
            signal.raise_signal(signal.SIGINT)
        return original(self, *given)

    monkeypatch.setattr(store.Checkpoint, moment, interrupted)
    monkeypatch.setattr("nonsmooth.runs.run.LOOK_EVERY", 0.0)
    stopped = ns.simulate(falling(), (0, 0.4), **options, checkpoint=tmp_path / "run.nsc", checkpoint_every=0)
    monkeypatch.setattr(store.Checkpoint, moment, original)
    assert stopped.status == ns.Status.INTERRUPTED and stopped.stats.steps > 0 and stopped.t[-1] < 0.4
    resumed = ns.simulate(falling(), (0, 0.4), **options, resume=tmp_path / "run.nsc")
    assert bits(resumed) == bits(ns.simulate(falling(), (0, 0.4), **options))


TIMES = {
    "steps": STEP, "springs": SPRINGS, "springs at times": SPRINGS | {"every": 1, "t_eval": [0.02, 0.05, 0.1]}
}  # fmt: skip


@pytest.mark.parametrize("which", [1, 2, -1])
@pytest.mark.parametrize("moment", ["go_on_from", "write_record"])
@pytest.mark.parametrize("name", TIMES)
def test_ctrl_c_between_a_step_and_its_record_loses_none(small, tmp_path, monkeypatch, name, moment, which):
    """The first record behind the start, the next one, and the last."""
    options, kind = TIMES[name] | ALL_KINDS, scene_run.SceneRun if name == "steps" else spring_run.SpringRun
    whole = ns.simulate(falling(), (0, 0.1), **options)
    original, left = getattr(kind, moment), [range(len(whole.t))[which] - (moment == "go_on_from")]

    def interrupted(run, *given):
        left[0] -= 1
        if left[0] == -1:
            raise KeyboardInterrupt
        original(run, *given)

    monkeypatch.setattr(kind, moment, interrupted)
    stopped = ns.simulate(falling(), (0, 0.1), **options, checkpoint=tmp_path / "run.nsc")
    assert stopped.status == ns.Status.INTERRUPTED and stopped.t[-1] == whole.t[which]
    monkeypatch.setattr(kind, moment, original)
    assert bits(ns.simulate(falling(), (0, 0.1), **options, resume=tmp_path / "run.nsc")) == bits(whole)


def moved():
    scene = falling()
    scene.bodies[2].position[0] += 1e-9
    return scene


OTHERS = {
    "start": (moved, {}, "its start differs"),
    "friction": (lambda: falling(mu=0.4), {}, "its table of materials differs"),
    "more bodies": (lambda: falling(n=9), {}, "its scene is Scene.planar, 9 bodies.*here it is Scene.planar, 10"),
    "step": (falling, {"integrator": ns.MoreauJean(dt=1e-3)}, "its integrator is .*dt=0.002.*here it is .*dt=0.001"),
    "tolerance": (
        falling, {"integrator": ns.MoreauJean(dt=DT, contacts=ns.ContactSolver(tol=1e-3))}, "its contacts is ContactSo"
    ),
    "records": (falling, {"record": ["bodies"]}, "its record is"),
    "softness": (
        falling, {"integrator": ns.MoreauJean(DT, theta=1.0, compliance=ns.Compliance(1e7))}, "its integrator is .*None"
    ),
    "springs": (falling, SPRINGS, "its integrator is MoreauJean.*here it is Penalty"),
}  # fmt: skip


@pytest.mark.parametrize("what", OTHERS)
def test_the_checkpoint_of_another_scene_or_integrator_is_refused(small, tmp_path, what):
    scene, options, message = OTHERS[what]
    ns.simulate(falling(), (0, 0.1), **STEP, checkpoint=tmp_path / "run.nsc")
    with pytest.raises(ns.InvalidInput, match=f"is of another run: {message}"):
        ns.simulate(scene(), (0, 0.1), **STEP | options, resume=tmp_path / "run.nsc")


def test_the_checkpoint_of_other_springs_is_refused(small, tmp_path):
    ns.simulate(falling(), (0, 0.05), **SPRINGS, checkpoint=tmp_path / "run.nsc")
    for other in (ns.Penalty(2e6, damping_ratio=0.3), ns.Penalty(1e6, damping_ratio=0.3, rtol=1e-7)):
        with pytest.raises(ns.InvalidInput, match="is of another run: its integrator is Penalty.*here it is Penalty"):
            ns.simulate(falling(), (0, 0.05), **SPRINGS | {"integrator": other}, resume=tmp_path / "run.nsc")


def test_checkpoints_of_scenes_and_of_systems_are_told_apart(small, tmp_path):
    ns.simulate(falling(), (0, 0.1), **STEP, checkpoint=tmp_path / "scene.nsc")
    with pytest.raises(ns.InvalidInput, match="that of a run of a scene; ns.SceneSolution.load reads it"):
        ns.Solution.load(tmp_path / "scene.nsc")
    with pytest.raises(ns.InvalidInput, match="there is no checkpoint .*; checkpoint= begins one"):
        ns.simulate(falling(), (0, 0.1), **STEP, resume=tmp_path / "none.nsc")


@pytest.mark.upkeep
def test_the_memory_of_a_streamed_run_does_not_grow_with_its_records(small, tmp_path):
    def peak(t_end):
        tracemalloc.start()
        ns.simulate(falling(), (0, t_end), integrator=STEP["integrator"], checkpoint=tmp_path / f"{t_end}.nsc")
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    peak(2.1)  # what is loaded when it is first reached is loaded here
    record_bytes = 8 * 9 * 6
    assert peak(2.0) - peak(0.5) < 0.5 * 750 * record_bytes


def test_the_command_line_goes_on_with_a_checkpoint(tmp_path, capsys):
    words = f"run box-stack --set n=2 dim=2 --t-end 0.1 --no-plot --json --checkpoint {tmp_path / 'run.nsc'}".split()
    assert main([*words, "--max-steps", "5"]) == 3
    assert main([*words, "--resume", str(tmp_path / "run.nsc")]) == 0
    assert '"status": "FINISHED"' in capsys.readouterr().out
