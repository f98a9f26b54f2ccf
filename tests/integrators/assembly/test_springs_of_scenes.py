"""Springs, dampers and torsion springs between bodies: orders, energy, statics, momenta, contacts, errors."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns

DTS = (4e-3, 2e-3, 1e-3)


def run(scene, t_end, dt, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt), **options)


def ball(dim, r):
    return ns.Disc(r) if dim == 2 else ns.Sphere(r)


def axis(dim, x):
    return x * np.eye(dim)[0]


def is_of_second_order(errors):
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / np.array(errors[1:])), 2.0, atol=0.1)


def oscillator(dim, k, c, x=1.0, length=3.0):
    scene = ns.Scene(gravity=(0.0,) * dim)
    scene.fixed(ball(dim, 0.01), position=axis(dim, -length), name="hook")
    scene.body(ball(dim, 0.1), mass=2.0, position=axis(dim, x), name="bob")
    scene.spring("hook", "bob", stiffness=k, damping=c, length=length)
    return scene


@pytest.mark.parametrize("c", [0.0, 1.0])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_spring_with_a_damper_is_of_second_order(dim, c):
    """2 x'' = -40 x - c x'."""
    decay = c / 4
    omega = math.sqrt(20 - decay**2)
    exact = math.exp(-decay) * (math.cos(omega) + decay / omega * math.sin(omega))
    is_of_second_order([abs(run(oscillator(dim, 40.0, c), 1.0, dt)["bob"].position[-1, 0] - exact) for dt in DTS])


@pytest.mark.parametrize("length", [0.8, 0.0])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_pendulum_on_a_spring_is_of_second_order(dim, length):
    k, g = 50.0, -9.81 * np.eye(dim)[1]
    start, speed = axis(dim, 1.0), 0.5 * np.eye(dim)[-1]

    def rates(t, y):
        now = np.linalg.norm(y[:dim])
        return np.concatenate((y[dim:], g - k * (1 - length / now) * y[:dim]))

    exact = solve_ivp(rates, (0, 1), np.concatenate((start, speed)), rtol=1e-11, atol=1e-12).y[:dim, -1]
    errors = []
    for dt in DTS:
        scene = ns.Scene(gravity=g)
        scene.fixed(ball(dim, 0.01), position=(9.0,) * dim, name="hook")
        scene.body(ball(dim, 0.05), mass=1.0, position=start, velocity=speed, name="bob")
        scene.spring("hook", "bob", at_a=(0.0,) * dim, stiffness=k, length=length)
        errors.append(np.abs(run(scene, 1.0, dt)["bob"].position[-1] - exact).max())
    is_of_second_order(errors)


def test_a_torsion_spring_about_a_pin_is_of_second_order():
    errors = []
    for dt in DTS:
        scene = ns.Scene(gravity=(0, 0))
        scene.fixed(ns.Disc(0.01), name="hook")
        scene.body(ns.Disc(0.1), mass=1.0, inertia=0.5, turn=0.3, name="wheel")
        scene.joint("hook", "wheel", at=(0, 0))
        scene.torsion_spring("hook", "wheel", stiffness=8.0, angle=0.0)
        errors.append(abs(run(scene, 1.0, dt)["wheel"].turn[-1] - 0.3 * math.cos(4.0)))
    is_of_second_order(errors)


@pytest.mark.parametrize("k", [40.0, 1e6, 1e10])
def test_the_stiffest_spring_keeps_its_energy_at_any_step(k):
    """omega dt up to 700: the implicit mid-point rule keeps (m v^2 + k x^2)/2 of a linear spring."""
    sol = run(oscillator(2, k, 0.0, x=1e-4), 2.0, 1e-2)
    x, v = sol["bob"].position[:, 0], sol["bob"].velocity[:, 0]
    energy = 0.5 * 2.0 * v**2 + 0.5 * k * x**2
    # each step is solved to 1e-8 of its impulses, and x is known to some 1e-15 m
    assert np.ptp(energy) <= 1e-6 * energy[0] and sol.stats.missed == 0
    gained = sol.ledger["kinetic"] - sol.ledger["kinetic"][0]
    np.testing.assert_allclose(gained, sol.ledger["force"] - sol.ledger["force"][0], atol=1e-9 * energy[0])


@pytest.mark.parametrize("theta", [0.6, 1.0])
@pytest.mark.parametrize("k", [40.0, 1e6, 1e10])
def test_with_another_theta_a_spring_loses_energy_and_never_gains(k, theta):
    scene = oscillator(2, k, 0.0, x=1e-4)
    sol = ns.simulate(scene, (0, 2), integrator=ns.MoreauJean(1e-2, theta=theta))
    energy = sol["bob"].velocity[:, 0] ** 2 + 0.5 * k * sol["bob"].position[:, 0] ** 2
    assert (np.diff(energy) <= 1e-9 * energy[0]).all() and energy[-1] < 0.95 * energy[0]


def test_a_spring_of_bodies_that_are_moved_apart_has_the_length_that_was_described():
    """Discs that overlap by .05 m are parted: the spring, as long as they were described, pulls with k .05 m."""
    k, m, dt = 80.0, 1.0, 1e-4
    scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=0.0))
    scene.body(ns.Disc(0.1), mass=m, position=(0, 0), name="a")
    scene.body(ns.Disc(0.1), mass=m, position=(0.15, 0), name="b")
    scene.body(ns.Disc(0.1), mass=m, position=(2, 0), name="c")
    scene.spring("a", "b", stiffness=k, name="short")
    scene.spring("b", "c", stiffness=k, name="long")
    sol = run(scene, dt, dt, project=True)
    assert sol.spring("short").force[0] == pytest.approx(0.05 * k, rel=1e-6)
    assert sol.spring("long").force[0] == pytest.approx(-0.025 * k, rel=1e-6)
    assert sol["c"].velocity[-1, 0] == pytest.approx(0.025 * k * dt / m, rel=1e-4)


def test_ends_that_coincide_at_the_start_are_a_spring_of_length_0():
    errors = []
    for dt in DTS:
        scene = ns.Scene(gravity=(0, 0))
        scene.fixed(ns.Disc(0.01), position=(9, 9), name="hook")
        scene.body(ns.Disc(0.1), mass=1.0, velocity=(0.3, 0.4), name="bob")
        scene.spring("hook", "bob", at_a=(0, 0), stiffness=25.0)
        errors.append(np.abs(run(scene, 1.0, dt)["bob"].position[-1] - np.array([0.06, 0.08]) * math.sin(5)).max())
    is_of_second_order(errors)


@pytest.mark.parametrize("k", [1e3, 1e10])
def test_a_chain_of_springs_hangs_by_its_weights(k):
    """Spring j of n bears the weights below: it is longer by (n - j) m g/k."""
    n, m, g = 5, 2.0, 9.81
    scene = ns.Scene(gravity=(0, -g))
    scene.fixed(ns.Disc(0.01), name="0")
    for j in range(1, n + 1):
        scene.body(ns.Disc(0.05), mass=m, position=(0, -0.3 * j), name=f"{j}")
        scene.spring(f"{j - 1}", f"{j}", stiffness=k, damping=2 * math.sqrt(k * m))
    sol = run(scene, 20.0, 5e-3)
    stretch = -np.diff(np.concatenate(([0.0], sol.position[-1, 1:, 1]))) - 0.3
    np.testing.assert_allclose(stretch, (n - np.arange(n)) * m * g / k, rtol=1e-6, atol=1e-12)
    # a place of 1.5 m is known to some 2e-16 m, and a step makes a velocity of dt k/m times that
    assert np.abs(sol.velocity[-1]).max() < 1e-9 + 16 * np.finfo(float).eps * 5e-3 * k / m


def test_momenta_of_two_bodies_on_a_spring_are_kept():
    scene = ns.Scene(gravity=(0, 0))
    scene.body(ns.Box(0.4, 0.2), mass=1.0, inertia=0.02, spin=1.0, name="a")
    scene.body(ns.Box(0.3, 0.2), mass=2.0, inertia=0.03, position=(2, 0.2), velocity=(0, 1), name="b")
    scene.spring("a", "b", at_a=(0.2, 0.1), at_b=(1.85, 0.1), stiffness=100, length=1.6)
    sol = run(scene, 2.0, 1e-3)
    m, x, v = np.array([1.0, 2.0]), sol.position, sol.velocity
    momentum = np.einsum("b,tbk->tk", m, v)
    moment = (x[..., 0] * v[..., 1] - x[..., 1] * v[..., 0]) @ m + sol.spin @ np.array([0.02, 0.03])
    np.testing.assert_allclose(momentum, np.tile(momentum[0], (len(v), 1)), atol=1e-11)
    assert np.ptp(moment) < 1e-5 and np.ptp(sol.spin[:, 0]) > 0.5  # of second order where ends turn


def test_contacts_and_springs_are_one_problem():
    """A box that a stiff spring presses on the ground slides as if it weighed as much more."""
    k, stretch, m, g, mu = 1e7, 1e-5, 1.0, 9.81, 0.4
    scene = ns.Scene(gravity=(0, -g), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.kinematic(ns.Disc(0.01), position=(0, -1.0), velocity=(2.0, 0.0), name="trolley")  # runs along below
    scene.body(ns.Box(0.4, 0.2), mass=m, position=(0, 0.1), velocity=(2.0, 0.0), name="box")
    scene.spring("trolley", "box", stiffness=k, length=1.1 - stretch)
    sol = run(scene, 0.02, 1e-4, every=1)
    # at the start the spring stands upright: it pulls with k stretch, and friction has mu (m g + k stretch)
    slope = (sol["box"].velocity[2, 0] - 2.0) / sol.t[2]
    assert slope == pytest.approx(-mu * (g + k * stretch / m), rel=2e-2)
    assert sol.stats.missed == 0 and sol.penetration.max() == 0.0


def test_a_belt_oscillator_of_a_scene_is_that_of_a_force():
    """Stick and slip of a block on a belt: the spring, implicit, against the same force, explicit."""

    def block(is_spring):
        scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.5))
        scene.fixed(ns.HalfPlane((0, 1)), surface_velocity=(0.1, 0), name="belt")
        scene.fixed(ns.Disc(0.01), position=(-1, 0.1), name="wall")
        scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(0, 0.1), name="block")
        if is_spring:
            scene.spring("wall", "block", stiffness=100.0)
        else:
            scene.force("block", lambda t, bodies: (-100.0 * bodies["block"].position[0], 0.0))
        return run(scene, 2.0, 1e-3)["block"].position

    np.testing.assert_allclose(block(True), block(False), atol=2e-6)


@pytest.mark.filterwarnings("ignore::nonsmooth.errors.SimultaneousImpactWarning")
@pytest.mark.parametrize("law", ["newton", "energetic"])
def test_a_ball_that_falls_on_a_plate_on_springs_rebounds_from_the_plate_alone(law):
    """Springs give no impulse within an impact: (1 + e) m M/(m + M) v at the plate, whatever k."""
    m, M, e, g = 1.0, 3.0, 0.5, 9.81
    scene = ns.Scene(gravity=(0, -g), material=ns.Material(mu=0.0, e=e, impact=law))
    k = 5e3
    scene.fixed(ns.Disc(0.01), position=(0, -1.0), name="base")
    scene.body(ns.Box(0.5, 0.1), mass=M, position=(0, 0), name="plate")
    scene.spring("base", "plate", stiffness=k, length=1.0 + M * g / k)
    scene.body(ns.Disc(0.05), mass=m, position=(0, 0.3), name="ball")
    sol = run(scene, 0.3, 1e-4)
    v = sol["ball"].velocity[:, 1]
    hit = int(np.argmax(np.diff(v) > 0.5))
    assert v[hit + 1] == pytest.approx(v[hit] * (m - e * M) / (m + M), abs=0.02)
    assert sol.stats.missed == 0


def test_a_spring_says_its_length_and_force():
    """m x'' = -F of an oscillator, and its torque about a pin; the force of a body at rest is its weight."""
    sol = run(oscillator(2, 40.0, 1.0), 1.0, 1e-3)
    line = sol.spring("spring 0")
    x, v = sol["bob"].position[:, 0], sol["bob"].velocity[:, 0]
    np.testing.assert_allclose(line.length, 3.0 + x, atol=1e-12)
    np.testing.assert_allclose(line.force, 40.0 * x + v, atol=1e-12)
    scene = ns.Scene(gravity=(0, 0, -9.81))
    scene.fixed(ns.Sphere(0.1), position=(0, 0, 2), name="hook")
    scene.body(ns.Box(0.2, 0.2, 0.2), mass=2.0, name="bob")
    scene.spring("hook", "bob", at_b=(0, 0, 0.1), stiffness=500.0, damping=60.0, name="line")
    hung = run(scene, 5.0, 1e-3, every=100)
    assert hung.spring("line").force[-1] == pytest.approx(2.0 * 9.81, rel=1e-6)
    with pytest.raises(ns.InvalidInput, match="there is no spring 'lines'; .*line"):
        hung.spring("lines")
    scene = ns.Scene(gravity=(0, 0))
    scene.fixed(ns.Disc(0.01), name="hook")
    scene.body(ns.Disc(0.1), mass=1.0, inertia=0.5, turn=0.3, name="wheel")
    scene.joint("hook", "wheel", at=(0, 0))
    scene.torsion_spring("hook", "wheel", stiffness=8.0, angle=0.1, name="clock")
    wheel = run(scene, 1.0, 1e-3)
    np.testing.assert_allclose(wheel.spring("clock").force, 8.0 * (wheel["wheel"].turn - 0.1), atol=1e-12)


def boxes_on_springs():
    scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.3))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    for k in range(4):
        scene.body(ns.Box(0.2, 0.2), density=500, position=(0.5 * k, 0.4), turn=0.2 * k, name=f"box {k}")
        if k:
            scene.spring(f"box {k - 1}", f"box {k}", stiffness=300.0, damping=5.0, length=0.35)
    return scene


def test_bits_do_not_depend_on_threads_and_a_run_is_resumed(tmp_path):
    whole = run(boxes_on_springs(), 0.5, 1e-3)
    assert whole.stats.missed == 0
    assert (run(boxes_on_springs(), 0.5, 1e-3, threads=2).position == whole.position).all()
    place = tmp_path / "run.npz"
    run(boxes_on_springs(), 0.5, 1e-3, checkpoint=place, max_steps=123, on_failure="return")
    resumed = run(boxes_on_springs(), 0.5, 1e-3, checkpoint=place, resume=place)
    assert (resumed.position == whole.position).all() and (resumed.velocity == whole.velocity).all()


def test_what_rests_on_springs_falls_asleep_and_wakes():
    scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.3))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(0, 0.1), name="box")
    scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(1, 0.1), name="other")
    scene.spring("box", "other", stiffness=100.0, length=0.98)
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 3.5), name="late")
    sol = run(scene, 2.0, 1e-3)
    assert "left out" in sol.summary() or sol.stats.islands_asleep > 0
    hit = int(np.searchsorted(sol.t, math.sqrt(2 * 3.2 / 9.81))) + 2
    assert (sol["box"].position[: hit - 4] == sol["box"].position[0]).all()
    assert sol["late"].position[-1, 1] < 0.4 and sol.stats.missed == 0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "needs stiffness= or damping="),
        ({"stiffness": -1.0}, "stiffness of spring 0 must not be negative"),
        ({"stiffness": 1.0, "length": -1.0}, "length of spring 0 must not be negative"),
        ({"stiffness": math.inf}, "stiffness of spring 0"),
        ({"stiffness": 1.0, "at_a": (1, 2, 3)}, "at of spring 0"),
        ({"stiffness": 1.0, "name": 3}, "name of a spring"),
    ],
)
def test_a_spring_that_is_none_is_refused(options, message):
    scene = ns.Scene()
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 1), name="b")
    with pytest.raises(ns.InvalidInput, match=message):
        scene.spring("ground", "b", **options)


def test_bodies_and_methods_that_have_no_springs_are_named():
    scene = ns.Scene()
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.fixed(ns.Disc(0.1), position=(3, 1), name="post")
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 1), name="b")
    for a, b, message in (
        ("b", "b", "joins b to itself"), ("ground", "post", "no force moves either"),
        ("b", "x", "joins 'x', which is no"),
    ):  # fmt: skip
        with pytest.raises(ns.InvalidInput, match=message):
            scene.spring(a, b, stiffness=1.0)
    scene.spring("post", "b", stiffness=1.0, name="line")
    with pytest.raises(ns.InvalidInput, match="there is a spring 'line' already"):
        scene.spring("post", "b", stiffness=1.0, name="line")
    with pytest.raises(ns.InvalidInput, match="a torsion spring is one of bodies in the plane"):
        ns.Scene(gravity=(0, 0, 0)).torsion_spring("a", "b", stiffness=1.0)
