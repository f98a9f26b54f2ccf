"""What bodies that move as a function tells carry, throw and hold, against closed forms, with measured orders."""

import math
from math import cos, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns

G = 9.81
DTS = (4e-3, 2e-3, 1e-3)


def simulate(scene, t_end, dt, may_sleep=True, theta=0.5, **options):
    integrator = ns.MoreauJean(dt=dt, theta=theta, contacts=ns.ContactSolver(may_sleep=may_sleep))
    return ns.simulate(scene, (0, t_end), integrator=integrator, **options)


def planar(mu=0.9, gravity=G, e=0.0):
    return ns.Scene(gravity=(0, -gravity), material=ns.Material(mu=mu, e=e))


def orders(errors):
    """That errors of steps in a ratio of two fall with."""
    return [math.log2(before / after) for before, after in zip(errors, errors[1:], strict=False)]


def seen_from(place, angle, position):
    """A planar position in the axes of a body."""
    x, y = position - np.asarray(place)
    return np.array([cos(angle) * x + sin(angle) * y, cos(angle) * y - sin(angle) * x])


def on_a_turntable(angle, rate, r=0.5):
    """A box that lies at r on a table that turns by a function of time, and begins at a rate."""
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.8))

    def motion(t):
        return (0, 0, -0.05), (cos(angle(t) / 2), 0, 0, sin(angle(t) / 2))

    scene.kinematic(ns.Box(2, 2, 0.1), motion=motion, name="table")
    box = ns.Box(0.1, 0.1, 0.1)
    scene.body(box, mass=1, position=(r, 0, 0.05), velocity=(0, rate * r, 0), spin=(0, 0, rate), name="box")
    return scene


@pytest.mark.upkeep
@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_what_lies_on_a_turntable_goes_out_to_third_order_and_back_to_second(theta):
    W, r, t_end = 2.0, 0.5, 2.0
    out, back = [], []
    for dt in DTS:
        sol = simulate(on_a_turntable(lambda t: W * t, W), t_end, dt, theta=theta)
        x = seen_from((0, 0), W * sol.t[-1], sol["box"].position[-1][:2])
        out.append(abs(x[0] - r))
        back.append(abs(x[1]))
        # the velocity at the end is that of x_0 + v_0 dt, farther out by (W dt)^2/2: the box runs ahead by as much
        assert back[-1] < 1.01 * r * W * t_end * (W * dt) ** 2 / 2
        assert out[-1] < 1e-2 * r * W**2 * dt / 2 * t_end  # what the velocity of the middle drifts by
    assert all(abs(order - 3) < 0.1 for order in orders(out)) and all(abs(order - 2) < 0.05 for order in orders(back))


def test_a_table_that_spins_up_takes_a_box_along_and_the_friction_that_holds_it_does_no_work_to_second_order():
    a, r, t_end = 1.0, 0.5, 2.0
    away, works = [], []
    for dt in DTS:
        sol = simulate(on_a_turntable(lambda t: a * t**2 / 2, 0.0), t_end, dt)
        x = seen_from((0, 0), a * t_end**2 / 2, sol["box"].position[-1][:2])
        away.append(np.linalg.norm(x - (r, 0)))
        works.append(abs(sol.ledger["friction"][-1]))
        energy = 0.5 * (r**2 + 0.1**2 / 6) * (a * t_end) ** 2
        assert sol.ledger["kinetic"][-1] == pytest.approx(energy, rel=2 * (a * t_end * dt) ** 2)
        assert sol.ledger["surface"][-1] == pytest.approx(sol.ledger["kinetic"][-1], rel=(a * t_end * dt) ** 2)
    assert min(orders(away)) > 1.9 and away[-1] < 2e-6
    assert min(orders(works)) > 1.9 and works[-1] < 1e-6


def test_a_box_stays_where_it_is_on_a_plate_that_swings_about_a_far_point():
    def angle(t):
        return 0.3 * (1 - cos(3.0 * t))

    for dt in DTS:
        scene = planar()
        scene.kinematic(ns.Box(1, 0.1), motion=lambda t: ((sin(angle(t)), -cos(angle(t))), angle(t)), name="plate")
        scene.body(ns.Box(0.1, 0.1), mass=1, position=(0.1, -0.9), name="box")
        sol = simulate(scene, 2.0, dt)
        a = angle(2.0)
        away = seen_from((sin(a), -cos(a)), a, sol["box"].position[-1]) - (0.1, 0.1)
        assert np.abs(away).max() < 0.02 * dt**2
        assert sol.stats.worst_penetration < dt**2


def carried(motion, shapes, t_end, dt, velocity=(0, 0)):
    """A box that bridges trays; how far it ends from where it was on them."""
    scene = planar()
    for k, (shape, x) in enumerate(shapes):
        scene.kinematic(shape, motion=lambda t, x=x: motion(t) + np.array([x, -0.05]), name=f"tray {k}")
    scene.body(ns.Box(0.5, 0.1), mass=1, position=motion(0.0) + np.array([0, 0.05]), velocity=velocity, name="box")
    sol = simulate(scene, t_end, dt)
    return sol["box"].position[-1] - motion(sol.t[-1]) - (0, 0.05), sol


@pytest.mark.upkeep
@pytest.mark.parametrize("shapes", [[(ns.Box(1, 0.1), 0.0)], [(ns.Box(0.3, 0.1), -0.2), (ns.Box(0.3, 0.1), 0.2)]])
@pytest.mark.parametrize("lift", [0.0, 0.01])
def test_a_box_stays_where_it_is_on_shaken_trays(shapes, lift):
    def motion(t):
        return np.array([0.1 * (1 - cos(5 * t)), lift * sin(11 * t) * sin(3 * t)])

    for dt in DTS:
        away, sol = carried(motion, shapes, 2.0, dt)
        assert np.abs(away).max() < 0.05 * dt**2
        assert abs(sol.ledger["friction"][-1]) < 2.0 * dt**2


def test_a_box_in_a_gondola_goes_round_and_stays_level_where_it_is():
    W = 2.0
    for dt in DTS:
        circle, tray = lambda t: np.array([sin(W * t), -cos(W * t)]), [(ns.Box(1, 0.1), 0.0)]
        away, sol = carried(circle, tray, 3.0, dt, velocity=(W, 0))
        assert np.abs(away).max() < 0.01 * dt**2 and abs(sol.ledger["friction"][-1]) < 0.1 * dt**2


def test_a_box_pressed_to_a_wall_that_turns_without_gravity_stays_there_to_second_order():
    W, away = 8.0, []
    for dt in DTS:
        scene = planar(mu=0.5, gravity=0.0)
        scene.kinematic(ns.Box(1, 0.1), motion=lambda t: ((sin(W * t), -cos(W * t)), W * t), name="wall")
        start = {"position": (0.1, -0.9), "velocity": (0.9 * W, 0.1 * W), "spin": W}
        scene.body(ns.Box(0.1, 0.1), mass=1, **start, name="box")
        sol = simulate(scene, 2.0, dt)
        a = W * sol.t[-1]
        away.append(np.abs(seen_from((sin(a), -cos(a)), a, sol["box"].position[-1]) - (0.1, 0.1)).max())
        assert abs(sol.ledger["normal"][-1]) < (W * dt) ** 2 * 0.5 * 0.9**2 * W**2  # of the energy, no more
    assert all(abs(order - 2) < 0.2 for order in orders(away)) and away[-1] < 1e-4


def test_a_rod_that_hangs_on_a_shaken_hand_follows_its_equation_to_second_order():
    l = 0.5
    inertia = (l**2 + 0.02**2) / 12 + l**2 / 4

    def rates(t, y):
        return [y[1], -(l / 2) * (G * sin(y[0]) + 2.5 * cos(5 * t) * cos(y[0])) / inertia]

    exact = solve_ivp(rates, (0, 2), [0, 0], rtol=1e-11, atol=1e-12).y[:, -1]
    errors = []
    for dt in DTS:
        scene = ns.Scene(gravity=(0, -G))
        scene.kinematic(ns.Disc(0.01), motion=lambda t: (0.1 * (1 - cos(5 * t)), 0), name="hand")
        scene.body(ns.Box(0.02, l), mass=1, position=(0, -l / 2), name="rod")
        scene.joint("hand", "rod", at=(0, 0))
        rod = simulate(scene, 2.0, dt)["rod"]
        errors.append(max(abs(rod.turn[-1] - exact[0]), abs(rod.spin[-1] - exact[1])))
    assert all(abs(order - 2) < 0.1 for order in orders(errors)) and errors[-1] < 1e-4


def test_a_box_that_slides_on_an_accelerating_tray_has_the_acceleration_of_friction():
    mu, a = 0.2, 5.0
    scene = planar(mu=mu)
    scene.kinematic(ns.Box(40, 0.1), motion=lambda t: (a * t**2 / 2, -0.05), name="tray")
    scene.body(ns.Box(0.1, 0.1), mass=1, position=(0, 0.05), name="box")
    sol = simulate(scene, 1.0, 2e-3)
    np.testing.assert_allclose(sol["box"].position[:, 0], mu * G * sol.t**2 / 2, atol=1e-13)
    np.testing.assert_allclose(sol["tray"].velocity[1:, 0], a * sol.t[1:], rtol=1e-9)  # that at the end of a step
    rubbed = -mu * G * (a - mu * G) / 2  # force times what it slides
    assert sol.ledger["friction"][-1] == pytest.approx(rubbed, rel=1e-9)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.3, 0.5, 0.8])
def test_a_kick_that_begins_within_a_step_throws_at_its_speed(share):
    speed, dt = 2.0, 1e-3

    def motion(t):
        return 0.0, speed * min(max(0.0, t - (100 + share) * dt), 20 * dt) - 0.05

    scene = planar(mu=0.3)
    scene.kinematic(ns.Box(1, 0.1), motion=motion, name="plate")
    scene.body(ns.Box(0.1, 0.1), mass=1, position=(0, 0.05), name="box")
    box = simulate(scene, 0.25, dt)["box"]
    assert box.velocity[:, 1].max() == pytest.approx(speed, rel=1e-9)


def test_a_table_that_stops_lets_its_load_sleep_and_takes_it_along_to_the_same_bits_when_it_goes_on():
    def angle(t):
        return 0.5 * (min(t, 0.25) + max(0.0, t - 0.75))

    def run(may_sleep):
        scene = planar(mu=0.8)
        scene.kinematic(ns.Box(2, 0.1), motion=lambda t: ((0.2 * angle(t), -0.05), 0.3 * angle(t)), name="table")
        for k in range(2):
            scene.body(ns.Box(0.2, 0.1), mass=1, position=(-0.3, 0.05 + 0.1 * k), name=f"box {k}")
        return simulate(scene, 1.0, 1 / 1024, may_sleep=may_sleep)

    asleep, awake = run(True), run(False)
    assert asleep.stats.asleep + asleep.stats.islands_asleep > 300
    for name in ("position", "turn", "velocity", "spin"):
        np.testing.assert_array_equal(getattr(asleep, name), getattr(awake, name))
    rest = (asleep.t > 0.5) & (asleep.t < 0.74)
    assert not asleep.velocity[rest].any() and asleep.velocity[-1, 2].any()
