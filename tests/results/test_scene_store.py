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
    for found, written in zip(read.all_contacts, solution.all_contacts, strict=True):
        np.testing.assert_array_equal(found, written)
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


@pytest.mark.parametrize("broken", ["offsets", "i", "names"])
def test_contacts_that_do_not_fit_are_refused(solution, tmp_path, broken):
    from nonsmooth.results.npz import read_npz, write_npz

    path = solution.save(tmp_path / "run.npz")
    arrays = read_npz(path).arrays
    if broken == "offsets":
        arrays["contacts/offsets"] = arrays["contacts/offsets"][::-1].copy()
    elif broken == "i":
        arrays["contacts/i"] = arrays["contacts/i"] + 100
    else:
        arrays["about"] = np.array(str(arrays["about"]).replace('"names": [', '"names": ["one more", '))
    write_npz(path, "scene", arrays, is_compressed=True)
    with pytest.raises(ns.InvalidInput, match="run.npz is not a saved run of a scene"):
        ns.SceneSolution.load(path)
