"""``t_end`` and ``dt`` that a system, a scene or a model has of its own: given once, taken wherever none is typed."""

import json
from dataclasses import dataclass

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.commands.cli import main
from tests.systems import ball

G, HEIGHT = 9.81, 1.0


def falling_scene(**own):
    scene = ns.Scene(gravity=(0, -G), **own)
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, HEIGHT), name="disc")
    return scene


@dataclass(frozen=True)
class ModelOfSystem:
    """Its times stand in the system which it builds."""

    g: float = G

    def system(self):
        return ball(t_end=0.25, dt=1e-3)


@dataclass(frozen=True)
class ModelOfScene:
    """Its times stand in the scene which it builds."""

    g: float = G

    def scene(self):
        return falling_scene(t_end=0.25, dt=1e-3)


@pytest.mark.parametrize("model", [ball(t_end=0.25), ModelOfSystem()])
def test_a_run_without_a_span_ends_at_the_own_end_of_a_system(model):
    sol = ns.simulate(model, q0=[HEIGHT], u0=[0.0], integrator=ns.EventDriven())
    assert sol.t[0] == 0.0 and sol.t[-1] == 0.25
    assert sol.q[-1, 0] == pytest.approx(HEIGHT - 0.5 * G * 0.25**2, rel=1e-12)


@pytest.mark.parametrize("model", [falling_scene(t_end=0.25), ModelOfScene()])
def test_a_run_without_a_span_ends_at_the_own_end_of_a_scene(model):
    sol = ns.simulate(model, integrator=ns.MoreauJean(1e-3))
    assert sol.t[0] == 0.0 and sol.t[-1] == 0.25
    assert sol["disc"].velocity[-1, 1] == pytest.approx(-G * 0.25, rel=1e-12)


def test_what_is_typed_goes_before_what_is_own_and_a_system_before_its_parameters():
    @dataclass(frozen=True)
    class Parameters:
        m: float = 1.0
        g: float = G
        t_end = 0.5

    of_parameters, own = (ball(parameters=Parameters(), **times) for times in ({}, {"t_end": 0.25}))
    start = {"q0": [HEIGHT], "u0": [0.0], "integrator": ns.MoreauJean(1e-3)}
    assert ns.simulate(of_parameters, **start).t[-1] == 0.5
    assert ns.simulate(own, **start).t[-1] == 0.25
    assert ns.simulate(own, (0, 0.1), **start).t[-1] == 0.1


def test_a_scene_gives_name_and_times_to_its_system():
    system = falling_scene(name="fall", t_end=0.25, dt=1e-3).system()
    assert (system.name, system.t_end, system.dt) == ("fall", 0.25, 1e-3)


@pytest.mark.parametrize("make", [lambda **own: ball(**own), lambda **own: ns.Scene(**own)])
@pytest.mark.parametrize("own", [{"t_end": 0.0}, {"dt": -1e-3}, {"t_end": np.nan}, {"name": 3}])
def test_times_that_are_none_are_refused(make, own):
    with pytest.raises(ns.InvalidInput, match=next(iter(own))):
        make(**own)


@pytest.mark.parametrize("model", [ball(), falling_scene()])
def test_a_run_without_any_end_asks_for_one(model):
    start = {} if isinstance(model, ns.Scene) else {"q0": [HEIGHT], "u0": [0.0]}
    with pytest.raises(ns.InvalidInput, match=r"give t_span=\(start, end\), or t_end="):
        ns.simulate(model, **start, integrator=ns.MoreauJean(1e-3))


def test_sweeps_of_systems_and_scenes_take_the_own_times():
    of_system = ns.RunTask(ball(t_end=0.25, dt=1e-3), state={"q0": [HEIGHT], "u0": [0.0]})
    assert of_system.t_span == (0.0, 0.25) and of_system.integrator == ns.MoreauJean(1e-3)

    def last(sol):
        return {"end": sol.t[-1], "steps": sol.stats.steps}

    of_scene = ns.SceneTask(lambda t_end: falling_scene(t_end=t_end, dt=1e-3), last)
    found = ns.sweep(of_scene, {"t_end": [0.1, 0.2]}, progress=False)
    assert found.end.values.tolist() == [0.1, 0.2] and found.steps.values.tolist() == [100, 200]


def test_studies_of_systems_and_scenes_take_the_own_end():
    system = ball(ns.Contact(e_N=0.5), t_end=0.25)
    study = ns.convergence_study(system, q0=[HEIGHT], u0=[0.0], dt=[1e-2, 5e-3], progress=False)
    assert study.data.sizes["dt"] == 2
    of_scene = ns.convergence_study(
        falling_scene(t_end=0.25), dt=[2e-2, 1e-2], reference=exact_fall(0.25), progress=False
    )
    # gravity alone: the midpoint rule has no error but that of rounding
    assert of_scene.data.error_q.max() < 1e-13
    fall = falling_scene(name="fall", t_end=0.01)
    assert ns.penalty_study(fall, stiffness=[1e6], beside=[], progress=False).title == "fall: the penalty limit"


def exact_fall(t):
    return [[0.0, HEIGHT - 0.5 * G * t**2, 0.0]], [[0.0, -G * t, 0.0]]


def test_work_and_precision_of_a_scene_and_of_a_system_with_times_of_their_own():
    scene, times = falling_scene(name="fall", t_end=0.25), np.array([0.125, 0.25])
    motion = ns.TimedMotion(scene, times=times, reference=lambda t: exact_fall(t)[0][0])
    study = ns.work_precision({"fall": motion}, {"MoreauJean": ns.OwnMethod(ns.MoreauJean, (0.125 / 8,))}, repeats=1)
    assert study.best_error("fall", "MoreauJean") < 1e-14


FILE = """
import nonsmooth as ns
scene = ns.Scene(gravity=(0, -9.81), name="two discs", t_end=0.02, dt=1e-3)
scene.fixed(ns.HalfPlane((0, 1)), name="ground")
scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0.1), name="disc")
"""


def test_the_command_runs_a_scene_of_a_file_by_its_own_times_under_its_own_name(tmp_path, monkeypatch, capsys):
    (tmp_path / "two_discs_of_own_times.py").write_text(FILE)
    monkeypatch.chdir(tmp_path)
    assert main("run two_discs_of_own_times.py:scene --no-plot --json".split()) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["t"] == 0.02 and told["stats"]["steps"] == 20 and "two discs" in told["about"]["scene"]
