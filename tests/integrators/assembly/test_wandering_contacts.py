"""Contacts that wander over a body do no work: energy, order, and the closed forms of what rolls, rocks and spins."""

import math

import numpy as np
import pytest

import nonsmooth as ns

G = 9.81  # [m/s^2]
STEPS = (2e-3, 1e-3, 5e-4)  # [s]


def space(mu):
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    return scene


def plane(mu):
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfPlane((0, 1)))
    return scene


def about(axis, angle):
    """The quaternion of a turn."""
    return (math.cos(0.5 * angle), *(math.sin(0.5 * angle) * np.array(axis) / np.linalg.norm(axis)))


def wobbling_disc(mu, tilt=0.3, size=1.0):
    """On its rim, nearly as it precesses steadily (models/scenes/eulers_disc.py)."""
    R, h = 0.1 * size, 0.01 * size
    rate = math.sqrt(4 * G / (R * math.sin(tilt)))
    axis = np.array([math.sin(tilt), 0, math.cos(tilt)])
    low = np.array([0, 0, -1.0]) + axis * axis[2]
    spin = -rate * math.sin(tilt) * low / np.linalg.norm(low)
    scene = space(mu)
    scene.body(ns.Cylinder(R, h), mass=1.0, position=(0, 0, R * math.sin(tilt) + 0.5 * h * math.cos(tilt)),
               turn=about((0, -1, 0), 0.5 * math.pi - tilt), spin=spin, name="b")  # fmt: skip
    return scene


def rocking_ellipsoid(mu):
    """Rolling from the start where it sticks."""
    spin = np.array([3.0, 4.0, 0.5])
    velocity = np.cross(spin, [0, 0, 0.06]) if mu else np.zeros(3)
    scene = space(mu)
    scene.body(ns.Ellipsoid(0.15, 0.1, 0.06), mass=1.0, position=(0, 0, 0.06), spin=spin, velocity=velocity, name="b")
    return scene


def eccentric_disc(mu):
    scene = plane(mu)
    scene.body(ns.Compound((ns.Disc(0.1), (0, 0)), (ns.Disc(0.05), (0.045, 0))), mass=1.0, position=(0, 0.1), name="b")
    return scene


def ball_on_ball(dim, mu):
    """Down from the top of a fixed one, which it leaves later than the run ends."""
    ball, scene = {2: ns.Disc, 3: ns.Sphere}[dim], ns.Scene(gravity=-G * np.eye(dim)[-1], material=ns.Material(mu=mu))
    scene.fixed(ball(0.5))
    place = np.zeros(dim)
    place[0], place[-1] = 0.6 * math.sin(0.1), 0.6 * math.cos(0.1)
    scene.body(ball(0.1), mass=1.0, position=place, name="b")
    return scene


def falling_plank(mu):
    """A rectangle on one of its corners."""
    scene = plane(mu)
    height = 0.1 * math.sin(0.6) + 0.05 * math.cos(0.6)
    scene.body(ns.Box(0.2, 0.1), mass=1.0, position=(0, height), turn=0.6, name="b")
    return scene


def falling_brick(mu):
    """A box on one of its corners; its spin turns it upon that where it slides."""
    scene, turn = space(mu), about((1, 2, 0.3), 0.7)
    w, r = turn[0], np.array(turn[1:])
    corners = [np.array([i, j, k]) * (0.1, 0.07, 0.05) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
    lowest = min((v + 2 * np.cross(r, np.cross(r, v) + w * v))[2] for v in corners)
    scene.body(ns.Box(0.2, 0.14, 0.1), mass=1.0, position=(0, 0, -lowest), turn=turn, spin=(0, 0, 2.0), name="b")
    return scene


ROLLS = 5.0  # a friction coefficient by which what rolls does not slide
CASES = {
    "disc that wobbles": (lambda: wobbling_disc(0.0), 2.0),
    "flat disc that wobbles": (lambda: wobbling_disc(0.0, 0.1), 1.0),
    "ellipsoid that rocks": (lambda: rocking_ellipsoid(0.0), 2.0),
    "ellipsoid that rolls": (lambda: rocking_ellipsoid(ROLLS), 1.0),
    "eccentric disc that slides": (lambda: eccentric_disc(0.0), 1.0),
    "eccentric disc that rolls": (lambda: eccentric_disc(1e3), 1.0),
    "disc that slides on a disc": (lambda: ball_on_ball(2, 0.0), 0.5),
    "disc that rolls on a disc": (lambda: ball_on_ball(2, ROLLS), 0.5),
    "sphere that slides on a sphere": (lambda: ball_on_ball(3, 0.0), 0.5),
    "sphere that rolls on a sphere": (lambda: ball_on_ball(3, ROLLS), 0.5),
    "plank that slides on its corner": (lambda: falling_plank(0.0), 0.1),
    "plank that turns about its corner": (lambda: falling_plank(ROLLS), 0.1),
    "brick that slides on its corner": (lambda: falling_brick(0.0), 0.1),
}


def energy(solution):
    return solution.ledger["kinetic"] + G * solution["b"].position[:, -1]


def run(scene, t_end, dt):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt))


@pytest.mark.upkeep
@pytest.mark.parametrize("case", CASES)
def test_what_no_law_takes_energy_from_keeps_it_to_second_order(case):
    """What it gains where it is put back upon the ground, or sticks, is of second order too."""
    build, t_end = CASES[case]
    lost, ends = [], []
    for dt in STEPS:
        sol = run(build(), t_end, dt)
        E = energy(sol)
        lost.append(np.abs(E / E[0] - 1).max())
        ends.append(sol["b"].position[-1])
        assert (E / E[0] - 1).max() <= 0.5 * dt**2 + 1e-12
    assert lost[1] < 1e-2
    assert lost[2] < 5e-8 or lost[2] < 0.31 * lost[1]
    assert np.abs(ends[2] - ends[1]).max() < 0.35 * np.abs(ends[1] - ends[0]).max()


@pytest.mark.parametrize("size", [1e-1, 1.0, 10.0])
def test_a_disc_of_any_size_wobbles_on(size):
    """Also a coin, whose rows turn by 2 g dt in half a step as those of others do; dt in proportion to its period."""
    sol = run(wobbling_disc(0.0, size=size), 0.3 * math.sqrt(size), 1e-3 * math.sqrt(size))
    E = energy(sol)
    assert E[-1] >= 0.999 * E[0] and sol.stats.missed == 0


def on_its_tip(how, dt):
    """A fast top of six sides: its tip stands on the ground, or is held by a joint; where its centre is after 0.5 s."""
    scene, tilt, height, radius = space(1e3), 0.3, 0.12, 0.06
    axis = np.array([0, -math.sin(tilt), math.cos(tilt)])
    rim = [(radius * math.cos(k * math.pi / 3), radius * math.sin(k * math.pi / 3), height) for k in range(6)]
    if how == "joint":
        scene = ns.Scene(gravity=(0, 0, -G))
        scene.fixed(ns.Sphere(0.001), position=(0, 0, -0.5), name="ground")
    scene.body(ns.Polyhedron([(0, 0, 0), *rim]), mass=1.0, turn=about((1, 0, 0), tilt), spin=250 * axis, name="b")
    if how == "joint":
        scene.joint("ground", "b", at=(0, 0, 0))
    return run(scene, 0.5, dt)["b"].position[-1]


@pytest.mark.upkeep
def test_a_top_on_its_tip_is_as_good_as_by_a_joint():
    exact = on_its_tip("joint", 5e-5)
    by_joint, by_contact = ([np.abs(on_its_tip(how, dt) - exact).max() for dt in (4e-4, 2e-4)]
                            for how in ("joint", "contact"))  # fmt: skip
    assert by_contact[1] < 0.35 * by_contact[0] and by_joint[1] < 0.35 * by_joint[0]
    assert by_contact[0] < 3.0 * by_joint[0] < 1e-4


def test_a_ball_leaves_another_at_two_thirds_of_its_height():
    """Without friction at cos(theta) = 2/3 cos(theta_0); before that the contact holds it without loss."""
    for dim in (2, 3):
        sol = run(ball_on_ball(dim, 0.0), 0.9, 1e-3)
        away = np.linalg.norm(sol["b"].position, axis=1)
        left = np.flatnonzero(away > 0.6 + 1e-6)[0]
        assert sol["b"].position[left, -1] / away[left] == pytest.approx(2 / 3 * math.cos(0.1), abs=1e-2)
        E = energy(sol)
        assert E[-1] == pytest.approx(E[0], rel=1e-5)


def test_what_approaches_at_a_corner_still_lands_and_is_not_thrown_back():
    """A plank that turns about one corner until the other one lands, e = 0: the ground takes what it comes with."""
    for mu in (0.0, ROLLS):
        sol = run(falling_plank(mu), 0.6, 1e-3)
        assert np.abs(sol["b"].velocity[-1, 1]) < 1e-9 and np.abs(sol["b"].spin[-1]) < 1e-9
        assert np.diff(energy(sol)).max() < 1e-6 and sol.penetration.max() < 1e-4
        assert sol["b"].position[:, 1].max() < sol["b"].position[0, 1] + 1e-9


def test_the_second_impact_of_a_rocking_block_is_where_housner_has_it():
    """(I + m r^2) th'' = -m g r sin(alpha - th); each impact leaves 1 - 3/2 sin^2(alpha) of th', and the steps of one,
    of first order, let it be four steps late or early."""
    width, height, start = 0.2, 0.8, 0.05
    r, alpha = 0.5 * math.hypot(width, height), math.atan2(width, height)
    p_2 = G * r / ((width**2 + height**2) / 12 + r * r)

    def f(y):
        return np.array([y[1], -p_2 * math.sin(alpha - y[0])])

    def fall(th, rate):
        """The time from a tilt and rate to 0, and the rate then, by steps of the classical method of order 4."""
        t, h = 0.0, 1e-5
        y = np.array([th, rate])
        while y[0] >= 0.0:
            k_1 = f(y)
            k_2 = f(y + 0.5 * h * k_1)
            k_3 = f(y + 0.5 * h * k_2)
            last, y = y, y + h / 6 * (k_1 + 2 * k_2 + 2 * k_3 + f(y + h * k_3))
            t += h
        return t - h * y[0] / (y[0] - last[0]), y[1]

    first, rate = fall(start, 0.0)
    flight, _ = fall(0.0, -rate * (1 - 1.5 * math.sin(alpha) ** 2))
    scene = plane(ROLLS)
    up = r * math.cos(alpha - start)
    scene.body(ns.Box(width, height), mass=1.0, position=(0, up), turn=start, name="b")
    sol = run(scene, 1.2 * (first + flight), 1e-3)
    turn = sol["b"].turn.ravel()
    crossings = [sol.t[k] + 1e-3 * turn[k] / (turn[k] - turn[k + 1]) for k in np.flatnonzero(turn[1:] * turn[:-1] < 0)]
    assert crossings[0] == pytest.approx(first, abs=1e-4)
    assert crossings[1] == pytest.approx(first + flight, abs=4e-3)


def test_the_ledger_has_what_the_steps_take_and_the_summary_says_where_it_is_much():
    """A disc that wobbles: at 5 ms a step is a fifth of a radian, in which its rows do not turn evenly."""
    fine, coarse = run(wobbling_disc(0.0), 0.5, 1e-3), run(wobbling_disc(0.0), 0.5, 5e-3)
    for sol in (fine, coarse):
        assert (
            sol.ledger["step"][-1] == pytest.approx(sol.ledger["normal"][-1], rel=1e-2) and sol.ledger["step"][-1] < 0
        )
    assert "that of the steps" in coarse.summary() and "that of the steps" not in fine.summary()


def test_what_lands_and_what_slides_has_no_work_of_the_steps():
    """The impact of a brick is that of a law; upon the ground nothing turns."""
    scene = plane(0.3)
    scene.body(ns.Box(0.2, 0.1), mass=1.0, position=(0, 0.2), velocity=(2.0, 0.0), name="b")
    sol = run(scene, 1.0, 1e-3)
    assert sol.ledger["normal"][-1] < -0.5
    assert abs(sol.ledger["step"][-1]) < 2e-3 * abs(sol.ledger["normal"][-1])
    assert "that of the steps" not in sol.summary()
