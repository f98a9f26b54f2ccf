"""Paradoxes of friction in joints, against closed forms: a drawer, a lever on a thick pin, a spatial four-bar."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import SpatialFourBar

INCONSISTENT, INDETERMINATE = ns.EventKind.INCONSISTENT, ns.EventKind.INDETERMINATE
MASS, GUIDE = 2.0, 0.4  # kg, m


def drawer(F, aside, mu=0.8, v=1.0, is_in_space=False):
    """A drawer on a guide whose centre of mass is aside of it, pulled along it: |N_1| + |N_2| = 2 m |a| y/h."""
    at, way = (0, aside), (v, 0)
    fill = (0,) if is_in_space else ()
    scene = ns.Scene(gravity=(0, 0, *fill))
    scene.fixed(ns.Sphere(0.01) if is_in_space else ns.Disc(0.01), name="desk")
    box = ns.Box(0.4, 0.6, 0.2) if is_in_space else ns.Box(0.4, 0.6)
    scene.body(box, mass=MASS, position=(*at, *fill), velocity=(*way, *fill), name="drawer")
    friction = ns.GuideFriction(mu=mu, length=GUIDE)
    scene.slider("desk", "drawer", at=(0, 0, *fill), axis=(1, 0, *fill), friction=friction)
    scene.ignore("desk", "drawer")
    scene.force("drawer", (F, 0, *fill), at=(0, 0, *fill))
    return scene


def excess(aside, mu=0.8):
    """kappa of m a = F - kappa m |a| s: what friction makes of the force that it stops."""
    return 2.0 * mu * aside / GUIDE


def run(scene, dt=1e-3, steps=5):
    return ns.simulate(scene, (0, steps * dt), integrator=ns.MoreauJean(dt=dt))


@pytest.mark.parametrize("is_in_space", [False, True])
@pytest.mark.parametrize("v", [1.0, -1.0])
@pytest.mark.parametrize("aside", [0.2, 0.5, -0.5])
def test_a_pulled_drawer_slides_on_with_the_least_load_and_it_is_said_where_another_fits(v, aside, is_in_space):
    sol = run(drawer(math.copysign(3.0, v), aside, v=v, is_in_space=is_in_space))
    a = (sol["drawer"].velocity[-1, 0] - v) / sol.t[-1]
    assert a == pytest.approx(math.copysign(3.0, v) / (MASS * (1 + excess(abs(aside)))), rel=1e-9)
    has_two = excess(abs(aside)) > 1.0
    assert [event.kind for event in sol.paradoxes] == [INDETERMINATE] * has_two  # an episode is one event
    assert sol.stats.indeterminate_steps == (5 if has_two else 0)
    assert sol.stats.missed == 0


@pytest.mark.parametrize("is_in_space", [False, True])
@pytest.mark.parametrize("v", [1.0, -1.0])
def test_a_drawer_that_is_pushed_back_seizes(v, is_in_space):
    sol = run(drawer(math.copysign(3.0, -v), 0.5, v=v, is_in_space=is_in_space), steps=1)
    (event,) = sol.paradoxes
    assert (event.kind, event.i, event.j, event.n_solutions) == (INCONSISTENT, "desk", "drawer", 0)
    assert event.mode_after is ns.ContactMode.STICK
    friction = -MASS * v + math.copysign(3e-3, v)  # N s, along the guide; in space its size
    assert event.P_F == pytest.approx(abs(friction) if is_in_space else friction, rel=1e-9)
    np.testing.assert_allclose(sol["drawer"].velocity[1], 0, atol=1e-12)
    np.testing.assert_allclose(sol.ledger["friction"][-1], -0.5 * MASS, rtol=1e-2)  # of first order in dt


def test_a_drawer_with_little_friction_is_pushed_back_without_a_word():
    sol = run(drawer(-3.0, 0.2))
    assert not sol.paradoxes
    assert sol["drawer"].velocity[-1, 0] == pytest.approx(1 - 0.005 * 1.5 / (1 - excess(0.2)), rel=1e-9)


# a lever whose centre of mass is at l from a pin with a circle of friction c: M a + k sqrt(a^2 + w^4) = Q
LEVER, LEVER_MASS, INERTIA, CIRCLE = 0.05, 1.0, 1e-4, 0.06
M, K = INERTIA + LEVER_MASS * LEVER**2, CIRCLE * LEVER_MASS * LEVER


def lever(Q, w):
    scene = ns.Scene(gravity=(0, 0))
    scene.fixed(ns.Disc(0.01), name="wall")
    scene.body(ns.Disc(0.05), mass=LEVER_MASS, inertia=INERTIA, position=(LEVER, 0), velocity=(0, LEVER * w),
               spin=w, name="lever")  # fmt: skip
    scene.hinge("wall", "lever", at=(0, 0), friction=ns.PinFriction(mu=0.75, radius=CIRCLE / 0.6))
    scene.force("lever", lambda t, bodies: ((0.0, 0.0), Q))
    scene.ignore("wall", "lever")
    return scene


@pytest.mark.parametrize("w", [2.0, -3.0])
@pytest.mark.parametrize("share", [-1.0, 0.9, 1.1, 2.0])
def test_a_lever_on_a_thick_pin_has_the_accelerations_of_its_quadratic(share, w):
    Q = share * w**2 * math.sqrt(K**2 - M**2)  # along w
    A, B, C = M**2 - K**2, -2 * M * Q, Q**2 - (K * w**2) ** 2
    roots = [(-B + s * math.sqrt(B * B - 4 * A * C)) / (2 * A) for s in (1, -1)] if B * B > 4 * A * C else []
    roots = sorted((a for a in roots if Q > M * a), key=abs)
    dt = 1e-6
    sol = run(lever(math.copysign(1, w) * Q, w), dt=dt, steps=1)
    (event,) = sol.paradoxes
    if share < 1.0:
        assert (roots, event.kind) == ([], INCONSISTENT)
        assert sol["lever"].spin[1] == pytest.approx(0, abs=1e-9)
    else:
        assert (event.kind, event.n_solutions, len(roots)) == (INDETERMINATE, 2, 2)
        a = (sol["lever"].spin[1] - w) / dt * np.sign(w)
        assert a == pytest.approx(roots[0], rel=1e-3)  # the least load, of first order in dt


SOFTNESS = 2e-3  # of p, by joints in a loop: 1e-5 (1/m + 1/m) along the rod, of p h_C >= 0.01 1/kg


def crank_acceleration(model, F):
    P, Q = model.points()
    n, circle = (Q - P) / model.B, model.r * model.mu_A / math.hypot(1, model.mu_A)
    turning_back = math.copysign(circle * math.hypot(n[0], n[1]) * abs(F), model.rate)
    return (model.T - F * model.arms()[0] - turning_back) / model.I_A


@pytest.mark.parametrize("T", [20.0, -20.0])
@pytest.mark.parametrize("rate", [1e-3, -1e-3])
@pytest.mark.parametrize("theta", [1.0, 2.0, 2.095, 2.1005, 2.101, 2.1015, 2.102, 2.1023])
@pytest.mark.parametrize("mu_A", [0.0, 0.3, 0.7])
def test_a_spatial_four_bar_has_the_forces_of_its_closed_form(theta, rate, T, mu_A):
    model, dt = SpatialFourBar(theta=theta, rate=rate, T=T, mu_A=mu_A), 1e-7
    sol = run(model.scene(), dt=dt, steps=2)
    forces = sorted(model.forces(), key=abs)
    kinds = {event.kind for event in sol.paradoxes if event.t == 0}
    assert kinds == ({INCONSISTENT} if len(forces) == 0 else {INDETERMINATE} if len(forces) == 2 else set())
    assert (len(forces) == 1) == model.is_well_posed()
    if forces:  # the second step: in the first one the loop of joints takes up its softness
        a = (sol["crank"].spin[2, 2] - sol["crank"].spin[1, 2]) / dt
        expected, (p, q) = crank_acceleration(model, forces[0]), model.coefficients()
        of_rod = abs(expected - T / model.I_A) * SOFTNESS * abs(p) / abs(abs(p) - abs(q))  # F goes as 1/(p +- q)
        assert abs(a - expected) <= of_rod + 1e-5 * abs(expected)
        assert sol.stats.missed == 0
    else:
        assert abs(sol["follower"].spin[1, 1]) < 1e-9


def test_the_curvature_of_the_four_bar_is_the_derivative_of_its_transmission():
    step = 1e-5
    ahead, back = (SpatialFourBar(theta=1.0 + s).transmission() for s in (step, -step))
    with_rate = SpatialFourBar(theta=1.0, rate=1.0, T=0.0, mu_A=0.0, mu_C=0.0)
    p, _ = with_rate.coefficients()
    assert with_rate.forces()[0] * p == pytest.approx((ahead - back) / (2 * step), rel=1e-8)


@pytest.mark.upkeep
@pytest.mark.parametrize("T", [20.0, 200.0])
def test_a_machine_that_stands_seized_does_not_creep(T):
    """Its joints are a loop, which is soft where it moves and rigid where a torque finds it at rest."""
    model = SpatialFourBar(T=T)
    sol = ns.simulate(model.scene(), (0, 1.0), integrator=ns.MoreauJean(dt=1e-3), every=500)
    angle = sol.joint("crank").angle
    assert abs(angle[2] - angle[1]) < 1e-12 and sol["crank"].spin[-1, 2] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("dt", [1e-3, 1e-4])
@pytest.mark.parametrize("T", [20.0, -20.0, 2.0])
@pytest.mark.parametrize("theta", [1.8, 1.95, 2.05, 2.102])
def test_friction_that_leaves_the_loads_open_is_solved_in_every_step(theta, T, dt):
    """Where both pins stick within their limits any force of the rod between two fits: one of them is enough."""
    sol = ns.simulate(SpatialFourBar(theta=theta, T=T).scene(), (0, 50 * dt), integrator=ns.MoreauJean(dt=dt))
    assert sol.stats.missed == 0


def test_a_joint_that_is_no_paradox_costs_no_second_problem():
    """A contraction begins with its loads: the friction of the first problem is that of the last."""
    scene = drawer(3.0, 0.24)  # kappa = 0.96: a fixed point takes 500 problems to 1e-8
    sol = run(scene, steps=20)
    assert sol.stats.missed == 0
    assert sol["drawer"].velocity[-1, 0] == pytest.approx(1 + 0.02 * 1.5 / 1.96, rel=1e-9)


def test_what_is_not_asked_is_not_named():
    """A motor in the machine: its force is no load that is known before."""
    scene = drawer(3.0, 0.5)
    scene.body(ns.Disc(0.01), mass=0.1, position=(0, 2.0), name="rotor")
    scene.hinge("drawer", "rotor", at=(0, 2.0)).motor(speed=1.0, limit=1e-3)
    sol = run(scene)
    assert not sol.paradoxes
