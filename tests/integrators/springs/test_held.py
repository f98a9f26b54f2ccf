"""Joints, limits, springs, forces, guides and laws of friction of a scene on springs: closed forms, other equations."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import nonsmooth as ns
from tests.integrators.assembly.test_joints_with_axes import KINDS, exact, tumbling_on

G = 9.81
FINE = {"rtol": 1e-9, "atol": 1e-11}


def run(scene, t_end, k=1e6, n=11, **options):
    """A run with critical damping of contacts, to a fine tolerance."""
    integrator = ns.Penalty(k, damping_ratio=options.pop("damping_ratio", 1.0), **FINE)
    return ns.simulate(scene, (0, t_end), integrator=integrator, t_eval=np.linspace(0, t_end, n), **options)


def balance(sol):
    """By how much the works of a run are not the change of its kinetic energy, at the records [J]."""
    works = sum(sol.ledger[name] for name in ("force", "friction", "normal", "surface"))
    return sol.ledger["kinetic"] - sol.ledger["kinetic"][0] - works


@pytest.mark.parametrize("kind", KINDS)
def test_a_joint_on_springs_tends_to_the_rigid_one_as_one_over_its_stiffness(kind):
    """Two bodies in space whose equations are integrated with multipliers; a joint gives way by its load over k."""
    t_end, errors = 0.1, []
    end = exact(kind, t_end)
    for k in (1e5, 1e6):
        sol = run(tumbling_on(kind, G), t_end, k)
        turns = [Rotation.from_quat(sol.turn[-1, b], scalar_first=True).as_matrix() for b in range(2)]
        errors.append(np.abs(np.concatenate((sol.position[-1].ravel(), np.ravel(turns))) - end[:24]).max())
        assert np.abs(balance(sol)).max() < 1e-6
        assert sol.ledger["damping"][-1] <= 0.0 <= sol.ledger["elastic"][-1]
    assert 5 < errors[0] / errors[1] < 20, errors


@pytest.mark.parametrize("dim", [2, 3])
def test_a_pin_bears_what_the_rigid_one_bears(dim):
    """A rod that falls about its end: |R| from its angle, R = m g (e_g . e) + ... of the textbook."""
    scene = ns.Scene(gravity=(0, -G) if dim == 2 else (0, 0, -G))
    origin, length, axis = (0.0,) * dim, 1.0, {} if dim == 2 else {"axis": (0, 1, 0)}
    scene.fixed(ns.Disc(0.01) if dim == 2 else ns.Sphere(0.01), position=origin, name="post")
    shape, inertia = (ns.Box(1.0, 0.1), 1.01 / 12) if dim == 2 else (ns.Box(1.0, 0.1, 0.1), None)
    scene.body(shape, mass=1.0, position=(0.5, *origin[1:]), name="rod", inertia=inertia)
    scene.hinge("post", "rod", at=origin, name="pin", **axis)
    sol = run(scene, 1.0, 1e7)
    J = 1.01 / 12 + 0.25
    phi = solve_ivp(
        lambda t, y: (y[1], -G * 0.5 * math.cos(y[0]) / J), (0, 1), (0, 0), t_eval=sol.t, rtol=1e-11, atol=1e-13
    ).y
    angle, rate = phi
    along = -G * np.sin(angle) - 0.5 * length * rate**2  # of the acceleration less gravity, outwards
    across = -G * 0.5 * np.cos(angle) / J * 0.5 + G * np.cos(angle)
    outwards, upwards = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    expected = ((along + 2 * G * np.sin(angle)) * outwards + across * upwards).T
    found = sol.joint("pin").P[:, [0, -1]]
    np.testing.assert_allclose(found[1:], expected[1:], atol=1e-3)


def test_a_leaf_rebounds_from_its_limit_as_a_contact_does():
    """Without damping it goes back with the rate it came with; its pin is at its centre and bears nothing."""
    scene = ns.Scene(gravity=(0, 0))
    scene.fixed(ns.Disc(0.01), name="post")
    scene.body(ns.Box(1.0, 0.1), mass=1.0, spin=1.0, name="leaf")
    scene.hinge("post", "leaf", at=(0, 0), limits=(-1.0, 0.3), name="pin")
    sol = run(scene, 1.0, 1e6, damping_ratio=0.0)
    assert sol["leaf"].spin[-1] == pytest.approx(-1.0, abs=1e-7)
    lasts = math.pi * math.sqrt(1.01 / 12 / 1e6) / math.hypot(0.5, 0.05)  # half a period, at the lever of the leaf
    assert sol["leaf"].turn[-1] == pytest.approx(0.3 - (0.7 - lasts), abs=1e-7)
    assert abs(balance(sol)[-1]) < 1e-7


def test_a_limit_counts_full_turns():
    scene = ns.Scene(gravity=(0, 0, 0))
    scene.fixed(ns.Sphere(0.01), name="post")
    scene.body(ns.Box(1.0, 0.1, 0.1), mass=1.0, position=(0, 0, 0), spin=(0, 0, 10.0), name="leaf")
    scene.hinge("post", "leaf", at=(0, 0, 0), axis=(0, 0, 1), limits=(-1.0, 9.0), name="pin")
    sol = run(scene, 0.85, 1e7, n=171)
    assert (sol["leaf"].spin[:, 2] > 9.9).all()  # 8.5 rad, further than a turn and below the limit
    sol = run(scene, 1.2, 1e7, n=121)
    angle = np.unwrap(2 * np.arctan2(sol["leaf"].turn[:, 3], sol["leaf"].turn[:, 0]))
    assert angle.max() == pytest.approx(9.0, abs=0.02)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_spring_of_the_scene_swings_as_its_closed_form(dim):
    k, c, m, l_0 = 40.0, 0.8, 2.0, 0.5
    scene = ns.Scene(gravity=(0.0,) * dim)
    ball = ns.Disc(0.05) if dim == 2 else ns.Sphere(0.05)
    still = (0.0,) * (dim - 1)
    scene.fixed(ball, position=(0, *still), name="post")
    scene.body(ball, mass=m, position=(0.8, *still), name="ball")
    scene.spring("post", "ball", stiffness=k, damping=c, length=l_0, name="line")
    sol = run(scene, 2.0, 1e5)
    delta, omega = c / (2 * m), math.sqrt(k / m - (c / (2 * m)) ** 2)
    x = 0.3 * np.exp(-delta * sol.t) * (np.cos(omega * sol.t) + delta / omega * np.sin(omega * sol.t))
    np.testing.assert_allclose(sol["ball"].position[:, 0] - l_0, x, atol=1e-8)
    np.testing.assert_allclose(sol.spring("line").force[0], k * 0.3, rtol=1e-12)
    assert np.abs(balance(sol)).max() < 1e-8


def test_a_torsion_spring_swings_as_its_closed_form():
    kappa, moment = 3.0, 0.02
    scene = ns.Scene(gravity=(0, 0))
    scene.fixed(ns.Disc(0.1), position=(1, 0), name="post")
    scene.body(ns.Disc(0.1), mass=1.0, inertia=moment, spin=2.0, name="wheel")
    scene.torsion_spring("post", "wheel", stiffness=kappa)
    sol = run(scene, 1.0, 1e5)
    omega = math.sqrt(kappa / moment)
    np.testing.assert_allclose(sol["wheel"].turn, 2.0 / omega * np.sin(omega * sol.t), atol=1e-7)


@pytest.mark.parametrize("dim", [2, 3])
def test_forces_that_are_functions_are_those_of_their_times(dim):
    """Driven off its own period, and held by a force of the state: one of second order would be 1e-6 off."""
    m, k, nu, still = 1.0, 30.0, 4.0, (0.0,) * (dim - 1)
    scene = ns.Scene(gravity=(0.0,) * dim)
    scene.body(ns.Disc(0.1) if dim == 2 else ns.Sphere(0.1), mass=m, position=(0.2, *still), name="b")
    scene.force("b", lambda t, bodies: (math.sin(nu * t) - k * bodies["b"].position[0], *still))
    scene.force("b", (0.0,) * (dim - 1) + (0.5,))
    sol = run(scene, 2.0, 1e4)
    omega, a = math.sqrt(k / m), 1 / (k - m * nu**2)
    x = 0.2 * np.cos(omega * sol.t) - a * nu / omega * np.sin(omega * sol.t) + a * np.sin(nu * sol.t)
    np.testing.assert_allclose(sol["b"].position[:, 0], x, atol=1e-8)
    np.testing.assert_allclose(sol["b"].position[:, -1], 0.25 * sol.t**2, atol=1e-9)
    assert np.abs(balance(sol)).max() < 1e-8


def test_a_force_at_a_point_turns_its_body():
    scene = ns.Scene(gravity=(0, 0))
    scene.body(ns.Disc(0.5), mass=1.0, name="wheel")  # I = m r^2/2
    scene.force("wheel", lambda t, bodies: (0.0, 0.0) if t > 0.5 else ((0.0, 0.0), 0.25))
    scene.force("wheel", (0.0, 0.0), at=(0.5, 0))
    sol = run(scene, 1.0, 1e4)
    assert sol["wheel"].spin[-1] == pytest.approx(0.25 * 0.5 / 0.125, rel=1e-6)
    scene = ns.Scene(gravity=(0, 0))
    scene.body(ns.Disc(0.5), mass=1.0, name="wheel")
    scene.force("wheel", (0.0, 0.1), at=(0.5, 0))
    rates = lambda t, y: (y[1], 0.05 * math.cos(y[0]) / 0.125)
    theta = solve_ivp(rates, (0, 1), (0, 0), rtol=1e-11, atol=1e-13).y[0, -1]
    assert run(scene, 1.0, 1e4)["wheel"].turn[-1] == pytest.approx(theta, abs=1e-8)


def test_a_guide_that_a_function_moves_carries_what_stands_on_it():
    """A table that heaves: its load follows as a mass on the spring of the contact, driven by the table."""
    k, m, a, nu = 4e5, 2.0, 0.01, 20.0
    c, depth = 2 * 0.5 * math.sqrt(k * m), m * G / k
    scene = ns.Scene(gravity=(0, -G))
    scene.kinematic(ns.HalfPlane((0, 1)), motion=lambda t: (0.0, a * (1 - math.cos(nu * t))), name="table")
    scene.body(ns.Disc(0.1), mass=m, position=(0, 0.1 - depth), name="load")
    sol = run(scene, 0.5, k, damping_ratio=0.5)

    def rates(t, y):
        lift, speed = a * (1 - math.cos(nu * t)), a * nu * math.sin(nu * t)
        return y[1], -G + (k * (lift + 0.1 - y[0]) + c * (speed - y[1])) / m

    y = solve_ivp(rates, (0, 0.5), (0.1 - depth, 0), t_eval=sol.t, rtol=1e-11, atol=1e-13).y[0]
    np.testing.assert_allclose(sol["load"].position[:, 1], y, atol=1e-8)


def test_works_close_where_a_guide_that_a_function_moves_holds_by_a_joint_a_limit_and_a_spring():
    scene = ns.Scene(gravity=(0, -G))
    place = lambda t: ((0.1 * math.sin(8 * t), 0.05 * t), 0.4 * math.sin(5 * t))
    scene.kinematic(ns.Disc(0.05), motion=place, name="hand")
    scene.body(ns.Box(0.8, 0.05), mass=1.0, position=(0.4, 0), velocity=(0.8, 0), name="arm")
    scene.body(ns.Disc(0.1), mass=0.5, position=(0.3, -0.6), name="bob")
    scene.hinge("hand", "arm", at=(0, 0), limits=(-0.5, 0.5), name="pin")
    scene.spring("hand", "bob", stiffness=60.0, damping=0.5, length=0.4)
    sol = run(scene, 0.5, 1e5, n=26)
    relative = sol["arm"].turn - sol["hand"].turn
    assert np.ptp(sol.ledger["surface"]) > 0.1 and relative.min() < -0.49  # it struck its limit
    assert np.abs(balance(sol)).max() < 1e-5


def sliding(law):
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=law))
    scene.fixed(ns.HalfPlane((0, 1)), name="floor")
    scene.body(ns.Disc(0.1), mass=1.0, inertia=1e9, position=(0, 0.1 - G / 1e6), velocity=(2.0, 0), name="stone")
    return scene


def test_a_stone_slows_down_by_its_law_of_friction():
    law = ns.Stribeck(mu_s=0.5, mu_k=0.2, v_s=0.7)
    sol = run(sliding(law), 0.5)
    mu = lambda v: 0.2 + 0.3 * math.exp(-v / 0.7)
    v = solve_ivp(lambda t, v: (-G * mu(v[0]),), (0, 0.5), (2.0,), t_eval=sol.t, rtol=1e-11, atol=1e-13).y[0]
    np.testing.assert_allclose(sol["stone"].velocity[:, 0], v, atol=1e-7)


def test_a_law_that_turns_negative_ends_the_run_with_the_bodies():
    with pytest.raises(ns.StepFailure, match="the friction law of floor and stone is negative") as caught:
        run(sliding(ns.Friction(lambda v: 0.3 - 1.0 * (v < 1.5))), 1.0)
    last = caught.value.solution["stone"].velocity[-1, 0]
    assert 1.5 <= last < 2.0


def test_bodies_that_ignore_one_another_pass_through():
    scene = ns.Scene(gravity=(0, -G))
    scene.fixed(ns.HalfPlane((0, 1)), name="floor")
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0.5), name="ghost")
    scene.ignore("floor", "ghost")
    assert run(scene, 1.0)["ghost"].position[-1, 1] == pytest.approx(0.5 - G / 2, abs=1e-9)


def test_a_function_that_says_no_force_ends_the_run_and_what_was_computed_is_kept():
    scene = ns.Scene(gravity=(0, 0))
    scene.body(ns.Disc(0.1), mass=1.0, velocity=(1.0, 0), name="b")
    scene.force("b", lambda t, bodies: (0.0, 0.0) if t < 0.55 else "none")
    with pytest.raises(ns.StepFailure, match="the force on b at t = 0.55.*must be 2 numbers") as caught:
        run(scene, 1.0)
    kept = caught.value.solution
    assert kept.t[-1] <= 0.55 and kept["b"].position[-1, 0] == pytest.approx(kept.t[-1], abs=1e-9)


def machine():
    scene = ns.Scene(gravity=(0, -G))
    scene.fixed(ns.HalfPlane((0, 1)), material=ns.Material(mu=0.4), name="floor")
    scene.fixed(ns.Disc(0.3), position=(0, 1.0), name="post")
    scene.body(ns.Box(0.8, 0.05), mass=1.0, position=(0.4, 1.0), name="arm")
    scene.body(ns.Disc(0.1), mass=0.5, position=(0.8, 0.5), material=ns.Material(mu=0.4), name="bob")
    scene.hinge("post", "arm", at=(0, 1.0), limits=(-0.4, 1.0), name="pin")
    scene.spring("arm", "bob", at_a=(0.8, 1.0), stiffness=50.0, damping=0.3, length=0.4)
    scene.force("bob", lambda t, bodies: (2.0 * math.sin(9.0 * t), 0.0))
    return scene


@pytest.mark.upkeep
def test_a_machine_on_springs_goes_on_to_the_same_bits(tmp_path):
    method, path = ns.Penalty(1e7, damping_ratio=0.2), tmp_path / "run.nsc"
    whole = ns.simulate(machine(), (0, 0.6), integrator=method, every=7)
    ns.simulate(machine(), (0, 0.6), integrator=method, every=7, checkpoint=path, max_steps=400, on_failure="return")
    resumed = ns.simulate(machine(), (0, 0.6), integrator=method, every=7, resume=path)
    assert whole.stats.steps > 800
    for name in ("t", "position", "velocity", "penetration", "joint_impulses"):
        assert getattr(resumed, name).tobytes() == getattr(whole, name).tobytes(), name


def test_a_machine_on_springs_tends_to_the_rigid_one():
    """The bob swings on its spring, the arm falls on its limit: before they land the rigid steps are the limit."""
    rigid = ns.simulate(machine(), (0, 0.12), integrator=ns.MoreauJean(1e-5), t_eval=[0.12])
    errors = []
    for k in (1e5, 1e6):
        soft = ns.simulate(machine(), (0, 0.12), integrator=ns.Penalty(k, damping_ratio=1.0, **FINE), t_eval=[0.12])
        errors.append(np.abs(soft.position[-1] - rigid.position[-1]).max())
    assert errors[1] < 2e-5 and errors[0] / errors[1] > 4


@pytest.mark.parametrize("what, message", [
    ("motor", "a joint on springs has no set-valued law, and pin has a motor that holds a speed"),
    ("friction", "a joint on springs has no set-valued law, and pin has friction"),
    ("law", "has a law of static and kinetic friction; take ns.Stribeck"),
    ("pairs", "pairs of Penalty are those of contacts, and the scene has joints"),
    ("hertz", "hunt-crossley has no stiffness .* that pin could have"),
])  # fmt: skip
def test_what_springs_do_not_take_is_refused_by_name(what, message):
    law = ns.StaticKinetic(0.5, 0.3) if what == "law" else 0.5
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=law))
    scene.fixed(ns.Disc(0.01), name="post")
    scene.body(ns.Box(1.0, 0.1), mass=1.0, position=(0.5, 0), name="arm")
    friction = ns.PinFriction(0.2, 0.05) if what == "friction" else None
    pin = scene.hinge("post", "arm", at=(0, 0), friction=friction, name="pin")
    if what == "motor":
        pin.motor(speed=1.0, limit=10.0)
    law = {"law": "hunt-crossley", "friction": ns.Regularised(1e-3)} if what == "hertz" else {}
    with pytest.raises(ns.InvalidInput, match=message):
        ns.simulate(scene, (0, 0.1), integrator=ns.Penalty(1e5, **law), record="pairs" if what == "pairs" else None)
