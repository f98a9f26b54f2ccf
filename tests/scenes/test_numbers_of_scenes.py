"""The functions of the system of a scene read its numbers: scenes of other numbers share their code, and no result."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.jit import models
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.sweeps.task import identity_of_model

G = 9.81


def rod(l=1.0, spin=0.0):
    """Painlevé's rod of length l, which slides and turns about its lower end."""
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=2.0))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    height, th = 0.5 * l * math.sin(math.pi / 3) + 1e-9, math.pi / 3
    velocity = (-1 - 0.5 * l * spin * math.sin(th), 0.5 * l * spin * math.cos(th))
    scene.body(ns.Capsule(l, 1e-9), mass=1.0, inertia=l**2 / 12, position=(0, height), turn=th, velocity=velocity,
               spin=spin, name="rod")  # fmt: skip
    return scene


def pendulum(l=1.0):
    """A bob on a pin at a distance l, with a spring on the pin."""
    scene = ns.Scene(gravity=(0, -G))
    scene.fixed(ns.Disc(0.01), name="hook")
    scene.body(ns.Disc(0.1), mass=2.0, inertia=0.02, position=(l, 0), name="bob")
    scene.hinge("hook", "bob", at=(0, 0), name="pin")
    scene.torsion_spring("hook", "bob", stiffness=3.0)
    scene.ignore("hook", "bob")
    return scene


def sphere(l=1.0):
    """A smooth sphere of radius l/10 over a half-space."""
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="floor")
    scene.body(ns.Sphere(0.1 * l), mass=1.0, position=(0, 0, 0.5), name="ball")
    return scene


def chalk(l=1.0):
    """A rough rod in space, on its end."""
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="board")
    lean = 0.5 * math.pi / 3
    scene.body(ns.Capsule(l, 0.01), mass=1.0, position=(0, 0, 0.5 * l * math.cos(2 * lean) + 0.01),
               turn=(math.cos(lean), math.sin(lean), 0, 0), velocity=(0.1, 0, 0), name="chalk")  # fmt: skip
    return scene


SCENES = [rod, pendulum, sphere, chalk]


@pytest.fixture
def codes(monkeypatch):
    """The keys of the codes that models asked for."""
    asked, compiled = [], models._compile

    def note(*arguments):
        asked.append(arguments[-1])
        return compiled(*arguments)

    monkeypatch.setattr(models, "_compile", note)
    return asked


@pytest.mark.upkeep
@pytest.mark.parametrize("scene", SCENES)
def test_scenes_of_other_numbers_have_the_code_of_the_first(scene, codes):
    for l in (1.0, 0.7):
        system = scene(l).system()
        ns.simulate(system, (0, 1e-3), *scene(l).state(), integrator=ns.MoreauJean(dt=1e-3))
    assert codes and len(set(codes)) == 1


@pytest.mark.parametrize("l", [1.0, 0.5, 2.0])
def test_a_rod_of_another_length_has_its_own_forces(l):
    """b = l/2 sin th w^2 - g of a rod that turns at w."""
    scene = rod(l, spin=3.0)
    found = ns.classify(scene.system(), 0.0, *scene.state())
    contact = int(np.flatnonzero([name != "open" for name in found.mode])[0])
    assert found.b[contact] == pytest.approx(0.5 * l * math.sin(math.pi / 3) * 9.0 - G, rel=1e-6)


@pytest.mark.parametrize("l", [1.0, 0.5])
def test_a_pendulum_of_another_length_swings_in_its_own_time(l):
    inertia = 0.02 + 2.0 * l * l
    sol = ns.simulate(pendulum(l), (0, 0.2), integrator=ns.Adaptive(rtol=1e-9, atol=1e-11))
    turn = sol["bob"].turn[-1]  # energy: I w^2/2 = m g l sin|turn| - k turn^2/2
    w = sol["bob"].spin[-1]
    energy = 0.5 * inertia * w * w + 2.0 * G * l * math.sin(turn) + 1.5 * turn * turn
    assert energy == pytest.approx(0.0, abs=1e-6) and turn < -0.1


@pytest.mark.parametrize("l", [1.0, 2.0])
def test_a_sphere_of_another_radius_lands_at_its_own_time(l):
    sol = ns.simulate(sphere(l), (0, 0.5), integrator=ns.EventDriven(), record=("bodies", "events"))
    assert sol.events.t[0] == pytest.approx(math.sqrt(2 * (0.5 - 0.1 * l) / G), rel=1e-9)


@pytest.mark.upkeep
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.InitialStateWarning")
@pytest.mark.parametrize("scene", SCENES)
def test_scenes_of_other_numbers_are_other_models(scene, tmp_path):
    """Sweeps do not take the journal of one for the other, nor does a run go on from the other's checkpoint."""
    one, other = scene(1.0).system(), scene(0.7).system()
    assert identity_of_model(one) != identity_of_model(other)
    assert as_system(other) is not as_system(one)
    state = scene(1.0).state()
    options = {"integrator": ns.MoreauJean(dt=1e-3), "on_failure": "return"}
    ns.simulate(one, (0, 0.01), *state, **options, max_steps=5, checkpoint=tmp_path / "run.ckpt")
    with pytest.raises(ns.NonsmoothError, match="another"):
        ns.simulate(other, (0, 0.01), *state, **options, resume=tmp_path / "run.ckpt")


def test_numbers_that_functions_read_are_no_parameters():
    system = rod().system()
    assert list(system.parameter_values) == ["e_ground_rod", "mu_ground_rod"]
    assert len(system.p) > 2 and list(system.numbers)[:2] == list(system.parameter_values)
    assert "touches" not in repr(system.parameters)
    changed = system.with_parameters(mu_ground_rod=0.1)
    np.testing.assert_array_equal(changed.p[2:], system.p[2:])
    found = ns.sweep(
        ns.RunTask(rod(), t_span=(0, 2e-3), integrator=ns.MoreauJean(1e-3)), {"mu_ground_rod": [0.0, 0.2]},
        progress=False,
    )  # fmt: skip
    assert list(found.coords) and "touches.arm[0,0,0]" not in found.attrs
