"""Limits and motors of joints, and what `sol.joint` says, against closed forms, statics and another integrator."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.integrators.assembly.progress import DONE, NOT_MET
from nonsmooth.integrators.assembly.stages import take_steps
from nonsmooth.integrators.assembly.step import PLACES
from nonsmooth.jit import interpreted
from nonsmooth.runs.recorder import SceneRecorder
from nonsmooth.runs.scene_run import SceneRun

G = 9.81
DTS = (4e-3, 2e-3)


def run(scene, t_end, dt, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)


def is_of_second_order(errors, within=0.2):
    assert abs(math.log2(errors[-2] / errors[-1]) - 2) < within, errors


def point(dim, x, y):
    return (x, y) if dim == 2 else (x, 0.0, y)


def ball(dim, r):
    return ns.Disc(r) if dim == 2 else ns.Sphere(r)


LENGTH, MASS = 1.0, 2.0
INERTIA = MASS * (LENGTH**2 + 0.05**2) / 12 + MASS * LENGTH**2 / 4
WEIGHT = MASS * G * LENGTH / 2  # on the arm of a bar that lies flat [N m]


def bar(dim, limits=None, gravity=G, rate=0.0):
    """A bar that lies flat on a hinge at its end; its angle counts upwards, about (0, -1, 0) in space."""
    scene = ns.Scene(gravity=point(dim, 0, -gravity))
    scene.fixed(ball(dim, 0.02), name="hook")
    box = ns.Box(LENGTH, 0.05) if dim == 2 else ns.Box(LENGTH, 0.2, 0.05)
    spin = rate if dim == 2 else (0, -rate, 0)
    scene.body(
        box, mass=MASS, position=point(dim, LENGTH / 2, 0), spin=spin, velocity=point(dim, 0, rate * LENGTH / 2),
        name="bar",
    )  # fmt: skip
    axis = {} if dim == 2 else {"axis": (0, -1, 0)}
    return scene, scene.hinge("hook", "bar", at=point(dim, 0, 0), limits=limits, name="hinge", **axis)


def about(dim, L):
    """The part about the axis, counted as its angle is."""
    return L if dim == 2 else -L[..., 1]


def swing(t_end, torque, angle=0.0, rate=0.0):
    """The angle of the bar under its weight and a torque(t, angle, rate)."""
    return solve_ivp(
        lambda t, y: [y[1], (torque(t, *y) - WEIGHT * math.cos(y[0])) / INERTIA], (0, t_end), [angle, rate],
        rtol=1e-11, atol=1e-12,
    ).y[:, -1]  # fmt: skip


@pytest.mark.parametrize("dim", [2, 3])
def test_a_bar_falls_on_its_limit_and_rests_there(dim):
    low, dt = -0.9, 2e-3
    sol = run(bar(dim, (low, 1.0))[0], 2.0, dt)
    hinge = sol.joint("hinge")
    landing = float(sol.t[np.argmax(hinge.at_limit == -1)])
    exact = solve_ivp(
        lambda t, y: [y[1], -WEIGHT * math.cos(y[0]) / INERTIA], (0, 2), [0, 0], rtol=1e-11, atol=1e-12,
        events=[lambda t, y: y[0] - low],
    ).t_events[0][0]  # fmt: skip
    assert abs(landing - exact) <= 2 * dt
    assert np.abs(hinge.angle[sol.t > landing + 8 * dt] - low).max() < 1e-9 and hinge.angle.min() > low - 1e-5
    assert (hinge.angle_rate[-100:] == 0.0).all() and sol.stats.missed == 0
    np.testing.assert_allclose(about(dim, hinge.L[-1]) / dt, WEIGHT * math.cos(low), rtol=1e-7)


@pytest.mark.parametrize("dim", [2, 3])
def test_what_rests_on_a_limit_sleeps(dim):
    scene = ns.Scene(gravity=point(dim, 0, -G))
    scene.fixed(ball(dim, 0.02), name="rail")
    scene.body(ball(dim, 0.1), mass=2.0, name="cart")
    scene.slider("rail", "cart", axis=point(dim, 0, 1), limits=(-0.2, 0.5), name="way")
    sol = run(scene, 2.0, 1e-3)
    assert sol.joint("way").travel[-1] == pytest.approx(-0.2, abs=1e-10) and sol.stats.asleep > 1000
    np.testing.assert_allclose(sol.joint("way").P[-1] / 1e-3, point(dim, 0, 2.0 * G), atol=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_limit_takes_what_turns_into_it_and_lets_it_go(dim):
    """Without weight: it turns to .6 rad at 1 rad/s, stops, and a torque turns it back to the other limit."""
    scene, hinge = bar(dim, (-0.3, 0.6), gravity=0.0, rate=1.0)
    hinge.motor(torque=lambda t, bodies: -INERTIA * 2.0 if t > 1.0 else 0.0)
    sol = run(scene, 2.5, 1e-3)
    angle = sol.joint("hinge").angle
    assert angle.max() < 0.6 + 1e-8 and angle.min() > -0.3 - 1e-8
    np.testing.assert_allclose(np.interp([0.5, 0.9, 1.5], sol.t, angle), [0.5, 0.6, 0.6 - 0.25], atol=2e-3)
    at = sol.joint("hinge").at_limit
    assert at[900] == 1 and at[1500] == 0 and at[-1] == -1 and sol.stats.missed == 0


def test_a_limit_beyond_a_turn_counts_turns():
    scene = ns.Scene(gravity=(0, 0, 0))
    scene.fixed(ns.Sphere(0.02), name="hook")
    scene.body(ns.Sphere(0.1), mass=1.0, spin=(0, 0, 5.0), name="wheel")
    scene.hinge("hook", "wheel", at=(0, 0, 0), axis=(0, 0, 1), limits=(-np.inf, 3 * math.pi), name="screw")
    sol = run(scene, 3.0, 2e-3)
    screw = sol.joint("screw")
    assert abs(screw.angle[-1] - 3 * math.pi) < 1e-8 and sol["wheel"].spin[-1, 2] == 0.0
    np.testing.assert_allclose(screw.angle[sol.t < 1.8], 5.0 * sol.t[sol.t < 1.8], rtol=1e-4)


@pytest.mark.upkeep
@pytest.mark.parametrize("dim", [2, 3])
def test_a_cart_between_two_ends_stays_between_them(dim):
    scene = ns.Scene(gravity=point(dim, 0, 0))
    scene.fixed(ball(dim, 0.02), name="rail")
    scene.body(ball(dim, 0.1), mass=1.0, name="cart")
    way = scene.slider("rail", "cart", axis=point(dim, 0.6, 0.8), limits=(-0.2, 0.5), name="way")
    way.motor(force=lambda t, bodies: 5.0 * math.cos(3.0 * t))
    sol = run(scene, 6.0, 1e-3)
    travel = sol.joint("way").travel
    assert travel.max() < 0.5 + 1e-7 and travel.min() > -0.2 - 1e-7 and sol.stats.missed == 0
    assert {-1, 0, 1} == set(sol.joint("way").at_limit)
    at = sol.joint("way").at_limit == 1
    held = 5 + np.flatnonzero(at[5:] & at[:-5])  # not within five steps of a landing
    pull = sol.joint("way").P[held] @ np.array(point(dim, 0.6, 0.8)) / 1e-3
    pressing = 5.0 * np.cos(3.0 * (sol.t[held] - 5e-4)) > 0.1
    np.testing.assert_allclose(pull[pressing], -5.0 * np.cos(3.0 * (sol.t[held] - 5e-4))[pressing], atol=1e-6)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_motor_reaches_its_speed_by_its_limit_and_holds_it(dim):
    scene, hinge = bar(dim, gravity=0.0)
    hinge.motor(speed=2.0, limit=1.5 * INERTIA)
    dt = 1e-2
    sol = run(scene, 2.0, dt)
    did = sol.joint("hinge")
    np.testing.assert_allclose(did.angle_rate, np.minimum(1.5 * sol.t, 2.0), atol=2e-3)
    assert np.abs(did.angle_rate[-50:] - 2.0).max() < 1e-12 and sol.stats.missed == 0
    np.testing.assert_allclose(about(dim, did.L[1:100]) / dt, 1.5 * INERTIA, rtol=1e-9)
    works = sum(sol.ledger[name] for name in ("force", "friction", "normal", "surface"))
    np.testing.assert_allclose(sol.ledger["kinetic"], works, atol=1e-12)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_brake_holds_what_is_below_its_limit_and_slips_beyond(dim):
    scene, hinge = bar(dim)
    hinge.motor(speed=0.0, limit=1.01 * WEIGHT)
    sol = run(scene, 2.0, 2e-3)
    # each step is solved to a part of its impulses: no velocity is left but roundings
    assert np.abs(sol.joint("hinge").angle).max() < 1e-12 and sol.stats.missed == 0
    np.testing.assert_allclose(about(dim, sol.joint("hinge").L[-1]) / 2e-3, WEIGHT, rtol=1e-9)
    errors = []
    for dt in DTS:
        scene, hinge = bar(dim)
        hinge.motor(speed=0.0, limit=0.6 * WEIGHT)
        did = run(scene, 0.5, dt).joint("hinge")
        errors.append(np.abs(np.array([did.angle[-1], did.angle_rate[-1]]) - swing(0.5, lambda *_: 0.6 * WEIGHT)).max())
    is_of_second_order(errors)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_torque_of_time_and_state_is_of_second_order(dim):
    def turn(state):
        turn = state["bar"].turn
        return turn if dim == 2 else -2 * math.atan2(turn[2], turn[0])

    errors = []
    for dt in DTS:
        scene, hinge = bar(dim)
        hinge.motor(torque=lambda t, bodies: 8.0 * math.sin(5.0 * t) - 20.0 * turn(bodies))
        did = run(scene, 0.8, dt).joint("hinge")
        exact = swing(0.8, lambda t, angle, rate: 8.0 * math.sin(5.0 * t) - 20.0 * angle)
        errors.append(np.abs(np.array([did.angle[-1], did.angle_rate[-1]]) - exact).max())
    is_of_second_order(errors)


def test_a_speed_that_is_a_function_is_followed():
    scene, hinge = bar(3)
    hinge.motor(speed=lambda t, bodies: math.cos(2.0 * t), limit=1e3)
    did = run(scene, 2.0, 1e-3).joint("hinge")
    np.testing.assert_allclose(did.angle_rate[1:], np.cos(2.0 * did.t[1:]), atol=1e-5)
    np.testing.assert_allclose(did.angle, 0.5 * np.sin(2.0 * did.t), atol=1e-3)


@pytest.mark.parametrize("lightness", [1.0, 1e2, 1e6])
def test_brakes_of_an_arm_of_two_links_bear_its_weight(lightness):
    """Links of 1 and .8 m, 2 and 1 kg, and others 1e6 times lighter: the torques of statics."""
    q, L, m = np.array([0.3, 0.5]), np.array([1.0, 0.8]), np.array([2.0, 1.0]) / lightness
    turns = np.cumsum(q)
    scene, at, before = ns.Scene(gravity=(0, -G)), np.zeros(2), "base"
    scene.fixed(ns.Disc(0.02), name="base")
    for k in range(2):
        way = L[k] * np.array([math.cos(turns[k]), math.sin(turns[k])])
        scene.body(ns.Box(L[k], 0.05), mass=m[k], position=at + way / 2, turn=turns[k], name=f"{k}")
        scene.hinge(before, f"{k}", at=at, name=f"q{k}").motor(speed=0.0, limit=30.0 / lightness)
        at, before = at + way, f"{k}"
    dt = 1e-2
    sol = run(scene, 1.0, dt)
    second = m[1] * G * L[1] / 2 * math.cos(turns[1])
    first = (m[0] / 2 + m[1]) * G * L[0] * math.cos(turns[0]) + second
    found = [sol.joint(f"q{k}").L[-1] / dt for k in range(2)]
    np.testing.assert_allclose(found, [first, second], rtol=1e-9)
    assert np.abs(sol.turn - sol.turn[0]).max() < 1e-12 and sol.stats.missed == 0


def test_a_gripper_holds_a_box_by_friction_while_its_motors_press_enough():
    def lifted(press):
        """The table sinks after half a second."""
        mu, m = 0.5, 1.0
        scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=mu))
        scene.fixed(ns.Disc(0.02), position=(0, 1), name="hand")
        scene.body(ns.Box(0.1, 0.1), mass=m, name="box")
        for name, x in (("left", -0.1), ("right", 0.1)):
            scene.body(ns.Box(0.04, 0.06), mass=0.2, position=(x, 0), name=name)
            way = scene.slider("hand", name, axis=(-x, 0), limits=(0.0, 0.2), name=f"{name} way")
            way.motor(speed=0.5, limit=press * m * G / (2 * mu))
        scene.kinematic(ns.Box(1, 0.1), motion=lambda t: (0, -0.1 - 0.2 * max(0.0, t - 0.5)), name="table")
        sol = run(scene, 1.0, 1e-3)
        assert sol.stats.missed == 0
        return sol

    sol = lifted(0.9)
    assert sol["box"].position[-1, 1] < -0.05
    sol = lifted(1.05)
    assert np.abs(sol["box"].position[-1]).max() < 1e-9
    np.testing.assert_allclose(sol.joint("left way").travel[-1], 0.03, atol=1e-9)
    np.testing.assert_allclose(sol.joint("left way").travel_rate[-1], 0.0, atol=1e-9)


def test_travel_and_rate_of_a_joint_are_those_along_the_axis_of_its_first_body():
    """A bead runs out on a bar that turns evenly: r'' = omega^2 r."""
    omega, errors = 1.5, []
    for dt in DTS:
        scene = ns.Scene(gravity=(0, 0, 0))
        scene.kinematic(ns.Box(4.0, 0.05, 0.05), spin=(0, 0, omega), name="bar")
        scene.body(ns.Sphere(0.05), mass=1.0, position=(0.5, 0, 0), velocity=(0, 0.5 * omega, 0), name="bead")
        scene.slot("bar", "bead", at=(0.5, 0, 0), axis=(1, 0, 0), limits=(-np.inf, 0.6), name="way")
        sol = run(scene, 1.2, dt)
        way, t = sol.joint("way"), sol.t
        out = t <= 0.9
        errors.append(np.abs(way.travel[out] - 0.5 * (np.cosh(omega * t[out]) - 1)).max())
        errors.append(np.abs(way.travel_rate[out] - 0.5 * omega * np.sinh(omega * t[out])).max())
        # at the end of its way the bar carries it round: the limit has m omega^2 r
        assert abs(way.travel[-1] - 0.6) < 1e-6 and sol.stats.missed == 0
        pull = np.linalg.norm(way.P[-1]) / dt
        assert abs(pull - omega**2 * 1.1) < 20 * dt
    is_of_second_order(errors[::2])
    is_of_second_order(errors[1::2])


def machine():
    scene, hinge = bar(3, (-0.2, 0.7))
    hinge.motor(speed=lambda t, bodies: 3.0 * math.cos(4.0 * t), limit=1.5 * WEIGHT)
    scene.body(ns.Sphere(0.1), mass=0.5, position=(1.2, 0, 0), velocity=(0, 0, 0.0), name="bob")
    scene.slider("bar", "bob", axis=(1, 0, 0), at=(1.2, 0, 0), limits=(-0.1, 0.2)).motor(
        force=lambda t, bodies: 10.0 * math.sin(9.0 * t)
    )
    return scene


@pytest.mark.upkeep
def test_bits_do_not_depend_on_threads_and_a_run_is_resumed(tmp_path):
    whole = run(machine(), 0.6, 1e-3, record=("bodies", "contacts", "ledger", "pairs"))
    assert whole.stats.missed == 0 and len(set(whole.joint("hinge").at_limit)) > 1
    assert (run(machine(), 0.6, 1e-3, threads=2).position == whole.position).all()
    place = tmp_path / "run.npz"
    run(machine(), 0.6, 1e-3, checkpoint=place, max_steps=223, on_failure="return")
    resumed = run(machine(), 0.6, 1e-3, checkpoint=place, resume=place)
    for name in ("position", "velocity", "joint_impulses", "joint_torques"):
        assert (getattr(resumed, name) == getattr(whole, name)).all()


@pytest.mark.upkeep
def test_a_machine_is_found_by_adaptive_steps_as_by_short_ones():
    short = run(machine(), 0.4, 2e-5, every=2000)
    sol = ns.simulate(machine(), (0, 0.4), integrator=ns.Adaptive(rtol=1e-6, atol=1e-7), every=1)
    np.testing.assert_allclose(sol.position[-1], short.position[-1], atol=2e-5)


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ((0.1, 0.5), "limits of h must have the start, 0, between them; got 0.1 and 0.5"),
        ((0.0, 0.0), "limits of h must have the start, 0, between them"),
        ((0.5, -0.5), "limits of h must have the start, 0, between them"),
        ((-1.0, math.nan), "limits of h must be two numbers"),
        (1.0, "limits of h must be two numbers, the least and the largest"),
    ],
)
def test_limits_that_are_none_are_refused(limits, message):
    scene = ns.Scene()
    scene.fixed(ns.Disc(0.1), name="a")
    scene.body(ns.Disc(0.1), mass=1.0, name="b")
    with pytest.raises(ns.InvalidInput, match=message):
        scene.hinge("a", "b", at=(0, 0), limits=limits, name="h")


@pytest.mark.parametrize(
    ("kind", "options", "message"),
    [
        ("hinge", {}, "the motor of h needs one of torque=, force= and speed=; got none"),
        ("hinge", {"torque": 1.0, "speed": 1.0}, "needs one of torque=, force= and speed=; got torque, speed"),
        ("hinge", {"force": 1.0}, "has force=, and a hinge joint has angle along its axis"),
        ("slider", {"torque": 1.0}, "has torque=, and a slider joint has travel along its axis"),
        ("fix", {"speed": 1.0, "limit": 1.0}, "has speed=, and a fix joint has no angle or travel along its axis"),
        ("hinge", {"speed": 1.0}, "the motor of h needs limit="),
        ("hinge", {"speed": 1.0, "limit": -1.0}, "limit of the motor of h"),
        ("hinge", {"torque": 1.0, "limit": 1.0}, "a limit is one of a motor with speed="),
        ("hinge", {"torque": "fast"}, "torque of the motor of h must be a number"),
    ],
)
def test_a_motor_that_is_none_is_refused(kind, options, message):
    scene = ns.Scene()
    scene.fixed(ns.Disc(0.1), name="a")
    scene.body(ns.Disc(0.1), mass=1.0, name="b")
    axis = {"axis": (1, 0)} if kind == "slider" else {}
    with pytest.raises(ns.InvalidInput, match=message):
        getattr(scene, kind)("a", "b", at=(0, 0), name="h", **axis).motor(**options)


def test_functions_of_motors_that_fail_and_methods_without_motors_say_so():
    scene, hinge = bar(2)
    hinge.motor(torque=lambda t, bodies: math.nan)
    with pytest.raises(ns.StepFailure, match="the motor of hinge at t = 0 s must be .*finite|the motor of hinge"):
        run(scene, 0.1, 1e-2)
    with pytest.raises(ns.InvalidInput, match="the motor of hinge is a function or holds a speed, which no system"):
        scene.system()
    scene, hinge = bar(2, (-1, 1))
    with pytest.raises(
        ns.InvalidInput, match="hinge has limits, friction or a rotor, which no system of a scene holds"
    ):
        scene.system()
    sol = run(scene, 0.01, 1e-2)
    with pytest.raises(ns.InvalidInput, match="there is no joint 'hing'; .*hinge"):
        sol.joint("hing")


# --- friction of pins, in proportion to what they bear


@pytest.mark.parametrize("dim", [2, 3])
def test_a_wheel_on_a_rubbing_pin_slows_evenly_and_stops(dim):
    m, I, pin = 2.0, 0.05, ns.PinFriction(mu=0.3, radius=0.02)
    scene = ns.Scene(gravity=point(dim, 0, -G))
    scene.fixed(ball(dim, 0.02), name="hook")
    inertia, spin = (I, 2.0) if dim == 2 else ((I, I, I), (0, -2.0, 0))
    scene.body(ball(dim, 0.2), mass=m, inertia=inertia, spin=spin, name="wheel")
    axis = {} if dim == 2 else {"axis": (0, -1, 0)}
    scene.hinge("hook", "wheel", at=point(dim, 0, 0), friction=pin, **axis)
    sol = run(scene, 2.0, 1e-3)
    slows = 0.02 * math.sin(math.atan(0.3)) * m * G / I
    did = sol.joint("joint 0")
    np.testing.assert_allclose(did.angle_rate, np.maximum(2.0 - slows * sol.t, 0.0), atol=1e-9)
    assert (did.angle[-100:] == did.angle[-1]).all() and sol.stats.missed == 0
    assert sol.ledger["friction"][-1] == pytest.approx(-0.5 * I * 2.0**2, rel=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("part", [0.999999, 1.000001])
def test_a_pendulum_on_a_rubbing_pin_rests_within_its_circle_of_friction_and_not_beyond(dim, part):
    pin = ns.PinFriction(mu=0.4, radius=0.05)
    aside = part * 0.05 * math.sin(math.atan(0.4))
    scene = ns.Scene(gravity=point(dim, 0, -G))
    scene.fixed(ball(dim, 0.02), name="hook")
    scene.body(ball(dim, 0.1), mass=2.0, position=point(dim, aside, -0.5), name="bob")
    axis = {} if dim == 2 else {"axis": (0, -1, 0)}
    scene.hinge("hook", "bob", at=point(dim, 0, 0), friction=pin, name="pin", **axis)
    sol = run(scene, 5.0, 5e-3)
    moved = np.abs(sol.joint("pin").angle).max()
    if part < 1.0:
        assert moved < 1e-12
    else:  # as an oscillator under dry friction it turns by twice what is beyond
        assert moved == pytest.approx(2e-6 * aside / 0.5, rel=0.01)
    assert sol.stats.missed == 0


def test_a_pendulum_on_a_rubbing_pin_swings_as_its_load_says_to_second_order():
    """R is the weight and what turns the bob: it goes into the friction, and that into R."""
    m, l, I, pin, start = 1.5, 0.6, 0.02, ns.PinFriction(mu=0.5, radius=0.04), 1.2
    r = 0.04 * math.sin(math.atan(0.5))

    def acceleration(angle, rate):
        """By iteration, of M = r |R|, R = m (a - g)."""
        turning = 0.0
        for _ in range(60):
            s, c = math.sin(angle), math.cos(angle)
            a = np.array([turning * c - rate**2 * s, turning * s + rate**2 * c]) * l + [0, G]
            turning = (-m * G * l * s - math.copysign(r * m * math.hypot(*a), rate)) / (I + m * l**2)
        return turning

    exact = solve_ivp(
        lambda t, y: [y[1], acceleration(*y)], (0, 0.5), [start, -1e-12], rtol=1e-10, atol=1e-11
    ).y[:, -1]  # fmt: skip
    errors = []
    for dt in DTS:
        scene = ns.Scene(gravity=(0, -G))
        scene.fixed(ns.Disc(0.02), name="hook")
        scene.body(
            ns.Disc(0.1), mass=m, inertia=I, position=(l * math.sin(start), -l * math.cos(start)), turn=start,
            name="bob",
        )  # fmt: skip
        scene.hinge("hook", "bob", at=(0, 0), friction=pin, name="pin")
        sol = run(scene, 0.5, dt)
        did = sol.joint("pin")
        errors.append(max(abs(did.angle[-1] + start - exact[0]), abs(did.angle_rate[-1] - exact[1])))
        assert sol.stats.missed == 0
    is_of_second_order(errors, 0.3)


def test_friction_of_a_pin_that_is_none_is_refused():
    with pytest.raises(ns.InvalidInput, match="radius of PinFriction"):
        ns.PinFriction(mu=0.1, radius=0.0)
    scene = ns.Scene()
    scene.fixed(ns.Disc(0.1), name="a")
    scene.body(ns.Disc(0.1), mass=1.0, name="b")
    with pytest.raises(ns.InvalidInput, match="friction of h must be ns.PinFriction"):
        scene.hinge("a", "b", at=(0, 0), friction=0.3, name="h")


@pytest.mark.upkeep
@pytest.mark.parametrize("dim", [2, 3])
def test_the_interpreter_drives_joints_with_the_bits_of_compiled_code(dim):
    def begun():
        scene, hinge = bar(dim, (-0.01, 0.7), rate=-4.0)
        hinge.motor(speed=1.0, limit=0.5 * WEIGHT)
        scene.body(ball(dim, 0.1), mass=0.5, position=point(dim, 1.2, 0), velocity=point(dim, 0, -4.8), name="bob")
        guide = ns.GuideFriction(mu=0.2, length=0.1)
        scene.slider("bar", "bob", axis=point(dim, 1, 0), at=point(dim, 1.2, 0), limits=(-0.1, 0.2), friction=guide)
        scene.body(ball(dim, 0.1), mass=0.5, position=point(dim, 0, -0.5), name="wheel")
        if dim == 3:
            scene.body(ns.Sphere(0.05), mass=0.5, position=(0.3, 0.5, -0.5), spin=(1.0, 0, 0), name="bell")
            scene.joint("hook", "bell", at=(0.2, 0.5, 0), friction=ns.PinFriction(0.3, 0.02))
        axis = {} if dim == 2 else {"axis": (0, 1, 0)}
        scene.hinge("hook", "wheel", at=point(dim, 0.01, -0.5), friction=ns.PinFriction(0.3, 0.02), **axis)
        return SceneRun(scene, (0, 6 * 2e-3), ns.MoreauJean(dt=2e-3), 1, None, SceneRecorder(("pairs",))).assembly

    one, other = begun(), begun()
    one.take_steps(2e-3, 6)
    fields = {name: getattr(other.progress, name) for name in type(other.progress)._fields()}
    fields |= {name: getattr(one.progress, name) for name in ("whole", "margin", "widest")}
    blocks = {name: getattr(other, name) for name in PLACES}
    fields["places"] = SimpleNamespace(motion=other.bodies.motion, **blocks)
    progress = SimpleNamespace(**fields)
    while (end := interpreted(take_steps)(progress, 6 - int(progress.counts.steps), dim)) == NOT_MET:
        other.rescue()
    assert end == DONE and (one.reactions.torque != 0.0).any() and (one.drives.high > 0.0).all()
    for name in ("bodies", "contacts", "ledger", "pairs", "reactions", "drives"):
        found, expected = (getattr(run, name).words.view(np.int64) for run in (other, one))
        np.testing.assert_array_equal(found, expected)


def test_a_file_holds_the_friction_of_a_pin(tmp_path):
    """It was left out of files without a word."""
    scene, _ = bar(2)
    scene.body(ball(2, 0.1), mass=1.0, position=(1.0, 0.5), spin=3.0, name="wheel")
    scene.hinge("bar", "wheel", at=(1.0, 0.5), friction=ns.PinFriction(mu=0.3, radius=0.02), name="pin")
    scene.save(tmp_path / "pin.toml")
    read = ns.Scene.load(tmp_path / "pin.toml")
    assert read.joints[1].friction == ns.PinFriction(mu=0.3, radius=0.02) and read.joints[0].friction is None
    assert (run(read, 0.2, 2e-3).position == run(scene, 0.2, 2e-3).position).all()
