"""A run that is read from a file has names, units, its motion between the records and its picture; nothing is run."""

import subprocess
import sys
import warnings
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.catalogue import BeltOscillator, BouncingBall
from tests.systems import ball_gap, ball_mass, ball_normal, ball_weight

ENDINGS = ["npz", "h5", "nc"]
of_endings = pytest.mark.parametrize("ending", ENDINGS)


class P(NamedTuple):
    m: float = 1.0
    g: float = 9.81


def drawn(q):
    return [np.array([[-0.1, q[0]], [0.1, q[0]]])]


BALL = ns.System(coordinates=[("y", "m")], mass=ball_mass, force=ball_weight, gap=ball_gap, normal=ball_normal,
                 contacts=[ns.Contact(e_N=0.5, name="floor")], parameters=P(), name="ball", shape=drawn)  # fmt: skip


def run(system, **options):
    return ns.simulate(system, (0, 0.5), [0.3], [0.0], integrator=ns.MoreauJean(dt=1e-3), **options)


def read(path, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return ns.Solution.load(path, **options)


@pytest.mark.upkeep
@of_endings
def test_a_system_of_a_module_is_found_with_the_parameters_of_the_run(tmp_path, ending):
    fresh = run(BALL.with_parameters(g=5.0))
    found = read(fresh.save(tmp_path / f"run.{ending}"))
    assert found.system.parameter_values == {"m": 1.0, "g": 5.0}
    assert found["y"].tobytes() == fresh["y"].tobytes() and found.described.contacts == ("floor",)
    assert found.described.coordinates == (("y", "m"),)
    assert np.array_equal(found.described.shape([0.7]), drawn([0.7]))
    times = np.linspace(0, 0.5, 77)
    assert found(times).q.tobytes() == fresh(times).q.tobytes()
    assert found.summary() == fresh.summary()


@pytest.mark.upkeep
@of_endings
@pytest.mark.parametrize("integrator", [ns.Adaptive(), ns.EventDriven()], ids=["adaptive", "events"])
def test_the_motion_of_chosen_steps_is_that_of_the_run(tmp_path, ending, integrator):
    fresh = ns.simulate(BALL, (0, 1.0), [0.3], [0.0], integrator=integrator)
    found = read(fresh.save(tmp_path / f"run.{ending}"))
    times = np.linspace(0, 1.0, 77)
    for side in ("left", "right"):
        assert found(times, side).u.tobytes() == fresh(times, side).u.tobytes()


@of_endings
def test_a_registered_model_is_found_by_its_name_with_whatever_parameters_it_has(tmp_path, ending):
    model = BeltOscillator(law="stribeck", vb=0.15)
    fresh = ns.simulate(model, (0, 0.5), *model.state(), integrator=ns.MoreauJean(dt=1e-2))
    found = read(fresh.save(tmp_path / f"run.{ending}"))
    assert found.named_model["place"] == "belt-oscillator" and found.system.parameters == model
    again = read(found.save(tmp_path / f"again.{ending}"))
    assert again.system.parameters == model


SCRIPT = """
import sys
from dataclasses import dataclass
import numpy as np
import nonsmooth as ns
from tests.systems import ball_gap, ball_mass, ball_normal, ball_weight


@dataclass(frozen=True)
class Dropped:
    k: np.ndarray
    m: float = 1.0
    g: float = 9.81
    name = "dropped"
    coordinates = (("height", "m"),)

    def system(self):
        return ns.System(n_q=1, mass=ball_mass, force=ball_weight, gap=ball_gap, normal=ball_normal,
                         contacts=[ns.Contact(name="floor")], parameters=self, name=self.name)

    def shape(self, q):
        return [np.array([[0.0, q[0]], [1.0, q[0]]])]


if __name__ == "__main__":
    sol = ns.simulate(Dropped(np.array([1.0, 2.0]), g=3.0), (0, 0.1), [1.0], [0.0], integrator=ns.MoreauJean(dt=1e-2))
    sol.save(sys.argv[1])
"""


@pytest.mark.upkeep
@of_endings
def test_a_model_of_a_users_file_is_run_only_where_it_is_asked_for_and_the_numbers_are_there_without(tmp_path, ending):
    script, saved = tmp_path / "dropped_model.py", tmp_path / f"run.{ending}"
    script.write_text(SCRIPT)
    subprocess.run([sys.executable, script, saved], check=True, env={**__import__("os").environ, "PYTHONPATH": "."})
    with pytest.warns(
        ns.ModelNotFoundWarning,
        match=rf"run.{ending} was read without its model: .*"
        "dropped_model.py:Dropped, and no file is run",
    ) as caught:
        bare = ns.Solution.load(saved)
    assert len(caught) == 1 and "dropped_model" not in sys.modules and bare.system is None
    assert bare.described.coordinates == (("height", "m"),) and bare.described.contacts == ("floor",)
    assert bare["height"][-1] == pytest.approx(1.0 - 0.5 * 3.0 * 0.01) and bare(0.05).u[0] == pytest.approx(-0.15)
    try:
        whole = read(saved, model=f"{script}:Dropped")
        assert whole.system.parameter_values == {"k[0]": 1.0, "k[1]": 2.0, "m": 1.0, "g": 3.0}
        assert whole.picture() is not None
        assert read(saved).system.parameter_values["g"] == 3.0  # of a module that is there by now
    finally:
        sys.modules.pop("dropped_model", None)


def test_a_model_that_is_given_is_taken_as_it_is_and_must_fit(tmp_path):
    saved = run(BALL).save(tmp_path / "run.npz")
    given = replace(BALL, coordinates=[("z", "m")])
    assert read(saved, model=given).described.names == ["z"]
    with pytest.raises(ns.InvalidInput, match="has 1 coordinates and 1 contacts, the run in the file has"):
        ns.Solution.load(two_beads().save(tmp_path / "two.npz"), model=BALL)


def two_beads():
    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.0

    def force(t, q, u, p, h):
        h[0] = 0.0

    made = ns.System(coordinates=["a", "b"], mass=mass, force=force)
    return ns.simulate(made, (0, 0.1), [0, 0], [1, 1], integrator=ns.MoreauJean(dt=1e-2))


def test_a_system_that_nothing_leads_to_leaves_its_names(tmp_path):
    found = read(two_beads().save(tmp_path / "run.npz"))
    assert found.system is None and found.named_model is None and found["b"][-1] == pytest.approx(0.1)


def test_a_model_whose_fields_have_changed_is_told(tmp_path, monkeypatch):
    model = BouncingBall(e=0.5)
    saved = ns.simulate(model, (0, 0.1), *model.state(), integrator=ns.MoreauJean(dt=1e-2)).save(tmp_path / "run.npz")
    from nonsmooth.catalogue import named

    class Other:
        def __init__(self, mass):
            pass

    monkeypatch.setattr(named, "load", lambda name: Other)
    with pytest.warns(ns.ModelNotFoundWarning, match="Other cannot be made of the parameters in the file"):
        assert ns.Solution.load(saved).system is None


@of_endings
def test_records_that_are_not_all_steps_know_no_motion(tmp_path, ending):
    found = read(run(BALL, every=5).save(tmp_path / f"run.{ending}"))
    with pytest.raises(ns.InvalidInput, match="knows its records only"):
        found(0.1)


def test_xarray_sees_names_of_coordinates_and_no_bytes_of_ours(tmp_path):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(run(BALL).save(tmp_path / "run.nc")) as data:
        assert "run" not in data and list(data.coordinate.values) == ["y"]
