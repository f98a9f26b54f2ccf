"""Runs of scenes survive the disk; what is none is refused; a loaded run has no shapes to draw."""

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall
from models.scenes import BoxStack, Conveyor

STEP = ns.MoreauJean(dt=1e-3)
RUNS = {2: Conveyor(n=2), 3: BoxStack(n=2)}


def pendulum():
    """A rod on a pin."""
    scene = ns.Scene()
    scene.fixed(ns.Disc(0.01), name="hook")
    scene.body(ns.Box(1.0, 0.02), mass=1.0, position=(0.5, 0), name="rod")
    scene.joint("hook", "rod", at=(0, 0), name="pin")
    return scene


@pytest.mark.parametrize("ending", ["npz", "h5", "nc"])
def test_joints_and_their_impulses_are_read_back(tmp_path, ending):
    pytest.importorskip({"npz": "numpy", "h5": "h5py", "nc": "xarray"}[ending])
    swing = ns.simulate(pendulum(), (0, 0.02), integrator=STEP)
    path = swing.save(tmp_path / f"run.{ending}")
    read = ns.SceneSolution.load(path, pendulum())
    np.testing.assert_array_equal(read.joint("pin").P, swing.joint("pin").P)
    assert read.stats == swing.stats and read.stats.worst_joint_drift > 0.0
    assert read.summary() == swing.summary() and "1 joint, apart by up to" in swing.summary()
    bare = pendulum()
    bare.joints.clear()
    with pytest.raises(ns.InvalidInput, match="scene is not the one that was run: its joints have other names"):
        ns.SceneSolution.load(path, bare)


def test_impulses_of_joints_are_labelled():
    pytest.importorskip("xarray")
    swing = ns.simulate(pendulum(), (0, 0.02), integrator=STEP)
    np.testing.assert_array_equal(swing.to_xarray().joint_P.sel(joint="pin"), swing.joint("pin").P)


@pytest.fixture(scope="module", params=[2, 3])
def model(request):
    return RUNS[request.param]


@pytest.fixture(scope="module")
def solution(model):
    return ns.simulate(model, (0, 0.02), integrator=STEP)


@pytest.mark.parametrize("name", ["run.npz", "run.h5"])
def test_a_run_read_back_equals_the_one_written(solution, tmp_path, name):
    read = ns.SceneSolution.load(solution.save(tmp_path / name))
    for array in ("t", "position", "turn", "velocity", "spin", "q", "u", "residual", "penetration", "centres"):
        np.testing.assert_array_equal(getattr(read, array), getattr(solution, array))
    assert read.columns.keys() == solution.columns.keys()
    for name, written in solution.columns.items():
        np.testing.assert_array_equal(read.columns[name], written)
    assert read.ledger.keys() == solution.ledger.keys()
    assert (read.stats, read.status, read.about, read.names) == (
        solution.stats, solution.status, solution.about, solution.names,
    )  # fmt: skip
    assert read.summary() == solution.summary() and repr(read.contacts()) == repr(solution.contacts())


def test_a_loaded_run_is_drawn_when_its_scene_is_given(model, solution, tmp_path):
    pytest.importorskip("matplotlib")
    path = solution.save(tmp_path / "run.npz")
    with pytest.raises(ns.InvalidInput, match="has no shapes; give its scene"):
        ns.SceneSolution.load(path).picture(tmp_path / "run.png")
    ns.SceneSolution.load(path).plot(tmp_path / "plot.png")
    ns.SceneSolution.load(path, model.scene()).picture(tmp_path / "run.png")
    assert (tmp_path / "run.png").stat().st_size > 0
    with pytest.raises(ns.InvalidInput, match="scene is not the one that was run"):
        ns.SceneSolution.load(path, BoxStack(n=5).scene())


def test_files_of_solutions_and_of_scenes_are_not_taken_for_one_another(solution, tmp_path):
    ball = BouncingBall()
    other = ns.simulate(ball, (0, 0.01), *ball.state(), integrator=STEP).save(tmp_path / "ball.npz")
    with pytest.raises(ns.InvalidInput, match="ball.npz is not a saved run of a scene"):
        ns.SceneSolution.load(other)
    with pytest.raises(ns.InvalidInput, match="run.npz is not a saved solution"):
        ns.Solution.load(solution.save(tmp_path / "run.npz"))


WRONG = {  # what no run leaves: what its array is changed to, and what is said of it
    "contacts/offsets": (lambda found: found[::-1], "contacts of its records do not fit its offsets"),
    "contacts/i": (lambda found: found + 100, "its contacts/i must lie in 0 ... "),
    "contacts/j": (lambda found: found - 100, "its contacts/j must lie in 0 ... "),
    "contacts/P": (lambda found: found[:-1], "contacts/P must have the shape"),
    "pairs/i": (lambda found: found + 99, "its pairs/i must lie in 0 ... "),
    "pairs/joint": (lambda found: found + 7, "its pairs/joint must lie in -1 ... "),
    "pairs/record": (lambda found: found + 1000, "its pairs/record must lie in 0 ... 20"),
    "events/kind": (lambda found: found + 4, "its events/kind must lie in 0 ... 3"),
    "centres": (lambda found: found[:-1], "position must have the shape"),
    "joint_impulses": (lambda found: np.zeros((len(found), 1, 2)), "joint_torques must have the shape"),
    "paradox_rows": (lambda found: np.zeros((1, 15)), "its kinds of paradoxes must lie in 2 ... 3"),
    "ledger/kinetic": (lambda found: found[1:], "ledger/kinetic must have the shape"),
    "about": (lambda found: str(found).replace('"names": [', '"names": ["one more", '), "not those of its bodies"),
}


@pytest.fixture(scope="module")
def everything():
    """A disc that lands, with all kinds."""
    scene = ns.Scene(gravity=(0, -9.81))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0.1001))
    return ns.simulate(scene, (0, 0.02), integrator=STEP, record=("bodies", "contacts", "ledger", "events", "pairs"))


@pytest.mark.parametrize("name", WRONG)
def test_arrays_that_no_run_leaves_are_refused(everything, tmp_path, name):
    """They are sealed as ours are: another program of ours may have written them."""
    from nonsmooth.results.npz import read_npz, write_npz

    arrays, (changed, words) = read_npz(everything.save(tmp_path / "run.npz")).arrays, WRONG[name]
    write_npz(tmp_path / "run.npz", "scene", arrays | {name: changed(arrays[name])}, is_compressed=True)
    with pytest.raises(ns.InvalidInput, match="run.npz is not a saved run of a scene, or is damaged: .*" + words):
        ns.SceneSolution.load(tmp_path / "run.npz")
