"""Springs, forces and torques in the system of a scene, by closed forms, and the same in steps of the scene."""

import math

import numpy as np
import pytest

import nonsmooth as ns

FINE = ns.EventDriven(rtol=1e-11, atol=1e-13)


def oscillation(t, w, zeta, x_0=1.0):
    """Of x'' + 2 zeta w x' + w^2 x = 0 from rest."""
    wd = w * math.sqrt(1 - zeta**2)
    return x_0 * math.exp(-zeta * w * t) * (math.cos(wd * t) + zeta * w / wd * math.sin(wd * t))


@pytest.mark.upkeep
@pytest.mark.parametrize("length", [0.0, 0.5])
def test_a_damped_mass_on_a_spring_swings_as_its_closed_form(length):
    """With a length along its line, without one as a vector."""
    scene = ns.Scene(gravity=(0, 0))
    scene.fixed(ns.Disc(0.01), turn=0.7, name="wall")
    scene.body(ns.Disc(0.1), mass=2.0, position=(0.3 + length, 0), name="b")
    scene.ignore("wall", "b")
    scene.spring("wall", "b", stiffness=50.0, damping=2.0, length=length)
    sol = ns.simulate(scene, (0, 2), integrator=FINE)
    assert sol["b"].position[-1, 0] - length == pytest.approx(oscillation(2, 5, 0.1, 0.3), abs=1e-9)
    assert sol.spring("spring 0").force[0] == pytest.approx(15.0)
    work = -sol.ledger["kinetic"] + sol.ledger["force"]
    assert abs(work).max() < 1e-9


@pytest.mark.upkeep
@pytest.mark.parametrize("kind", ["fixed", "kinematic"])
@pytest.mark.parametrize("how", ["torsion_spring", "on the joint"])
def test_a_wheel_on_a_torsion_spring_swings_about_its_rest(how, kind):
    scene = ns.Scene(gravity=(0, 0))
    getattr(scene, kind)(ns.Disc(0.1), turn=0.3, name="frame")
    scene.body(ns.Disc(0.2), mass=1.0, inertia=0.5, turn=0.8, name="wheel")
    pin = scene.hinge("frame", "wheel", at=(0, 0), name="pin")
    if how == "torsion_spring":
        scene.torsion_spring("frame", "wheel", stiffness=8.0, damping=0.4, angle=0.75)
    else:
        pin.spring(stiffness=8.0, damping=0.4, rest=0.25)
    pin.motor(torque=0.8)  # turns the rest by 0.1
    sol = ns.simulate(scene, (0, 2), integrator=FINE)
    assert sol["wheel"].turn[-1] == pytest.approx(1.15 + oscillation(2, 4, 0.1, -0.35), abs=1e-9)


@pytest.mark.upkeep
def test_a_force_at_a_point_goes_with_its_body():
    """On a bar about a pin a constant force is a weight: a pendulum with its period for 1 rad."""
    from scipy.special import ellipk

    scene, F, l, J = ns.Scene(gravity=(0, 0)), 3.0, 0.4, 0.2
    scene.fixed(ns.Disc(0.01), position=(1, 2), name="frame")
    scene.body(ns.Disc(0.1), mass=1.0, inertia=J, position=(1, 2), turn=0.4, name="bar")
    scene.hinge("frame", "bar", at=(1, 2))
    scene.force("bar", (F, 0), at=(1 + l * math.cos(1.0), 2 + l * math.sin(1.0)))
    period = 4 * math.sqrt(J / (F * l)) * ellipk(math.sin(0.5) ** 2)
    sol = ns.simulate(scene, (0, period), integrator=FINE)
    assert sol["bar"].turn[-1] == pytest.approx(0.4, abs=1e-8)
    assert sol["bar"].turn.min() == pytest.approx(0.4 - 2.0, abs=1e-3)


@pytest.mark.upkeep
def test_a_spring_whose_other_end_moves_evenly_drives_its_mass():
    scene, v, w = ns.Scene(gravity=(0, 0)), 0.5, 4.0
    scene.kinematic(ns.Disc(0.1), position=(1, 0), velocity=(v, 0), spin=2.0, name="hand")
    scene.body(ns.Disc(0.1), mass=1.0, name="b")
    scene.spring("hand", "b", stiffness=w**2, name="line")
    sol = ns.simulate(scene, (0, 1.5), integrator=FINE)
    assert sol["b"].position[-1, 0] == pytest.approx(v * (1.5 - math.sin(w * 1.5) / w), abs=1e-9)


@pytest.mark.upkeep
def test_systems_and_steps_of_a_scene_with_all_of_it_agree():
    """To the second order of the steps."""

    def scene():
        made = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.3))
        made.fixed(ns.HalfPlane((0, 1)), name="ground")
        made.body(ns.Box(0.6, 0.1), mass=2.0, position=(0, 0.6), turn=0.2, name="bar")
        made.body(ns.Disc(0.1), mass=1.0, position=(0.3, 0.1), velocity=(1.0, 0), name="wheel")
        made.body(ns.Disc(0.1), mass=0.5, position=(-0.2, 1.2), name="top")
        made.hinge("bar", "top", at=(-0.1, 0.9), name="pin").motor(torque=0.3)
        made.joints[0].spring(stiffness=3.0, damping=0.1, rest=0.2)
        made.spring("bar", "wheel", at_a=(0.3, 0.6), stiffness=40.0, damping=1.0)
        made.spring("ground", "bar", at_a=(-0.1, 0.0), at_b=(-0.2, 0.55), stiffness=90.0, length=0.7)
        made.force("top", (0.5, 1.0), at=(-0.15, 1.25))
        made.ignore("bar", "wheel", "top")
        return made

    exact = ns.simulate(scene(), (0, 0.3), integrator=ns.EventDriven(rtol=1e-10, atol=1e-12))
    errors = []
    for dt in (2e-3, 1e-3):
        sol = ns.simulate(scene(), (0, 0.3), integrator=ns.MoreauJean(dt))
        errors.append(np.abs(sol.position[-1] - exact.position[-1]).max())
    assert errors[1] < 2e-6 and 3.0 < errors[0] / errors[1] < 5.0
    assert sol.joint("pin").angle[-1] == pytest.approx(exact.joint("pin").angle[-1], abs=5e-5)


def test_a_scene_in_space_has_no_springs_as_a_system():
    scene = ns.Scene(gravity=(0, 0, -9.81))
    scene.fixed(ns.Sphere(0.1), name="a")
    scene.body(ns.Sphere(0.1), mass=1.0, position=(0, 0, -1), name="b")
    scene.spring("a", "b", stiffness=1.0, name="line")
    with pytest.raises(ns.InvalidInput, match=r"Spring\('line'.* lies in space, where no system of a scene holds"):
        scene.system()
