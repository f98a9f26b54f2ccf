"""Scenes with error control: tolerances are kept, what rests costs nothing, a step's records are those of all of it."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

import nonsmooth as ns
from nonsmooth.errors import Status
from nonsmooth.integrators.assembly.controlled import OFF_BY
from nonsmooth.runs.controlled_run import ControlledRun

G = 9.81
PLANE, SPACE = (0.0, -G), (0.0, 0.0, -G)
FACTOR = 10.0  # of the tolerance: errors of steps add up over a run (docs/scenes.md, error control)


def sliding_box():
    """A box that slides and stops: v^2/(2 mu g), in space, where friction turns with the velocity."""
    scene = ns.Scene(gravity=SPACE, material=ns.Material(mu=0.2))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    scene.body(ns.Box(0.2, 0.2, 0.1), mass=1.0, position=(0, 0, 0.05), velocity=(1.2, 0.9, 0), name="b")
    way = 1.5**2 / (2 * 0.2 * G)
    return scene, 1.5, np.array([0.8 * way, 0.6 * way, 0.05])


def ball_that_comes_to_roll():
    """A ball slides until v = 5/7 v_0, at t_1 = 2 v_0/(7 mu g), and rolls."""
    v, mu, t, radius = 2.0, 0.1, 1.2, 0.1
    scene = ns.Scene(gravity=SPACE, material=ns.Material(mu=mu))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    scene.body(ns.Sphere(radius), mass=1.0, position=(0, 0, radius), velocity=(v, 0, 0), name="b")
    t_1 = 2 * v / (7 * mu * G)
    assert t_1 < t
    return scene, t, np.array([v * t_1 - 0.5 * mu * G * t_1**2 + 5 / 7 * v * (t - t_1), 0, radius])


def pendulum_in_space():
    """A bar on a point in space: theta(t) by Jacobi's sn."""
    length, mass, start, t = 0.6, 1.0, 1.0, 1.7
    moment = mass * length**2 / 12 + mass * (length / 2) ** 2
    omega, k = math.sqrt(mass * G * length / 2 / moment), math.sin(start / 2)
    scene = ns.Scene(gravity=SPACE)
    wall = scene.fixed(ns.Sphere(0.01), position=(0, 0, 0))
    sin, cos = math.sin(start), math.cos(start)
    turn = (math.cos(-start / 2), 0, math.sin(-start / 2), 0)  # its own axis z goes to (-sin, 0, cos)
    bar = scene.body(
        ns.Sphere(0.01), mass=mass, inertia=(mass * length**2 / 12, mass * length**2 / 12, 1e-3), turn=turn,
        position=(length / 2 * sin, 0, -length / 2 * cos), name="b",
    )  # fmt: skip
    scene.joint(wall, bar, at=(0, 0, 0))
    sn = ellipj(float(ellipk(k * k)) - omega * t, k * k)[0]
    angle = 2 * math.asin(k * sn)
    return scene, t, 0.5 * length * np.array([math.sin(angle), 0, -math.cos(angle)])


def mass_on_a_spring():
    """A mass that swings on a spring in the plane, against `solve_ivp`."""
    k, rest, t = 200.0, 0.4, 1.5
    scene = ns.Scene(gravity=PLANE)
    wall = scene.fixed(ns.Disc(0.01), position=(0, 0))
    disc = scene.body(ns.Disc(0.05), mass=1.0, position=(0.3, -0.5), name="b")
    scene.spring(wall, disc, stiffness=k, length=rest)
    scene.force(disc, lambda t, bodies: (0.0, 0.0))  # functions are for steps of scenes

    def rate(_, y):
        r = math.hypot(y[0], y[1])
        return [y[2], y[3], -k * (r - rest) * y[0] / r, -k * (r - rest) * y[1] / r - G]

    exact = solve_ivp(rate, (0, t), [0.3, -0.5, 0, 0], rtol=1e-11, atol=1e-13, method="DOP853").y[:2, -1]
    return scene, t, exact


def box_that_rebounds():
    """A tilted box that rebounds in space without friction, twice: against steps of 10 us."""
    scene = ns.Scene(gravity=SPACE, material=ns.Material(mu=0.0, e=0.7))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    turn = np.array([0.9, 0.3, 0.2, 0.1])
    scene.body(ns.Box(0.2, 0.3, 0.1), mass=1.0, position=(0, 0, 0.5), turn=turn / np.linalg.norm(turn), name="b")
    fine = ns.simulate(scene, (0, 0.6), integrator=ns.MoreauJean(dt=1e-5), every=10**6)
    return scene, 0.6, fine["b"].position[-1]


def box_on_a_corner():
    """A box that falls on a corner without friction, and turns so that this lifts off, against the equations of a body
    that a point pushes, by `solve_ivp` from the moment of the exact blow."""
    start, mass, t_end = 0.3, 1.0, 0.21
    lengths, q = np.array([0.2, 0.3, 0.1]), np.array([0.9, 0.3, 0.2, 0.1])
    q, I_0 = q / np.linalg.norm(q), np.diag((lengths @ lengths - lengths**2) / 12)
    scene = ns.Scene(gravity=SPACE, material=ns.Material(mu=0.0))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    scene.body(ns.Box(*lengths), mass=mass, position=(0, 0, start), turn=q, name="b")
    up, signs = np.array([0, 0, 1.0]), np.array(list(itertools.product((-0.5, 0.5), repeat=3)))

    def matrix(q):
        return Rotation.from_quat(q, scalar_first=True).as_matrix()

    corner = min((lengths * sign for sign in signs), key=lambda r: (matrix(q) @ r)[2])
    fall = start + (matrix(q) @ corner)[2]

    def terms(q):
        turn = matrix(q)
        r, inverse = turn @ corner, turn @ np.linalg.inv(I_0) @ turn.T
        lever = np.cross(r, up)
        return r, turn @ I_0 @ turn.T, inverse, lever, 1 / mass + lever @ inverse @ lever

    _, _, inverse, lever, G_NN = terms(q)
    speed, t_1 = math.sqrt(2 * G * fall), math.sqrt(2 * fall / G)
    spin, v = inverse @ lever * speed / G_NN, -speed + speed / G_NN / mass

    def rate(_, y):
        q, spin, v = y[:4], y[4:7], y[7]
        r, inertia, inverse, lever, G_NN = terms(q)
        free = -inverse @ np.cross(spin, inertia @ spin)
        force = max(0.0, G - up @ (np.cross(free, r) + np.cross(spin, np.cross(spin, r)))) / G_NN  # it lifts off
        turn = 0.5 * np.array([-q[1:] @ spin, *(q[0] * spin + np.cross(spin, q[1:]))])
        return [*turn, *(free + inverse @ lever * force), -G + force / mass, v]

    exact = solve_ivp(rate, (t_1, t_end), [*q, *spin, v, start - fall], rtol=1e-11, atol=1e-13)
    return scene, t_end, np.array([0, 0, exact.y[8, -1]])


def polygon_that_rolls():
    """A twelve-sided disc that rolls down a slope, a landing at each corner: against steps of 20 us."""
    slope, angles = math.radians(12), (np.arange(12) + 0.5) * math.pi / 6
    scene = ns.Scene(gravity=(G * math.sin(slope), -G * math.cos(slope)), material=ns.Material(mu=0.9))
    for k in range(120):  # many pairs: not taken as a system
        scene.fixed(ns.Disc(0.01), position=(-5.0 - k, 5.0))
    scene.fixed(ns.HalfPlane((0, 1)))
    corners = 0.1 * np.column_stack((np.cos(angles), np.sin(angles)))
    height = 0.1 * math.cos(math.pi / 12)
    scene.body(ns.Polygon(corners), mass=1.0, position=(0, height), velocity=(0.5, 0), spin=-5.0, name="b")
    fine = ns.simulate(scene, (0, 0.5), integrator=ns.MoreauJean(dt=2e-5), every=10**6)
    return scene, 0.5, fine["b"].position[-1]


SCENES = [
    sliding_box, ball_that_comes_to_roll, pendulum_in_space, mass_on_a_spring, box_on_a_corner, box_that_rebounds,
    polygon_that_rolls,
]  # fmt: skip


@pytest.mark.upkeep
@pytest.mark.parametrize("make", SCENES, ids=lambda make: make.__name__)
def test_tolerances_are_kept(make):
    """Of place, relative to reach and way; the smaller tolerance has the smaller error, or both are next to none."""
    scene, t, exact = make()
    reach = 0.05  # of each of these bodies at least
    for rtol in (1e-3, 1e-4, 1e-5):
        sol = ns.simulate(scene, (0, t), integrator=ns.Adaptive(rtol=rtol, atol=1e-9), every=10**6)
        assert sol.status == Status.FINISHED and sol.stats.lengths is not None and sol.stats.missed == 0
        error = np.linalg.norm(sol["b"].position[-1] - exact)
        assert error < FACTOR * rtol * (reach + np.linalg.norm(exact - sol["b"].position[0])), rtol


@pytest.mark.upkeep
@pytest.mark.parametrize("tol", [1e-4, 1e-6, 1e-8])
def test_a_ball_that_rebounds_is_where_its_closed_form_says_to_the_tolerance(tol):
    """It lands in the second half of a step as in the whole one, so that both agree however late that is."""
    scene, e, fall = ns.Scene(gravity=PLANE, material=ns.Material(e=0.5)), 0.5, math.sqrt(1.6 / G)
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.body(ns.Disc(0.05), mass=1.0, position=(0, 0.85), name="ball")
    scene.force("ball", (0.0, 0.0))
    sol = ns.simulate(scene, (0, 1.5 * fall), integrator=ns.Adaptive(rtol=tol, atol=tol))
    t = 0.5 * fall
    exact = 0.05 + e * G * fall * t - 0.5 * G * t**2
    assert abs(sol["ball"].position[-1, 1] - exact) < tol and sol.stats.steps < 150


@pytest.mark.upkeep
@pytest.mark.parametrize("seed", range(16))
def test_boxes_that_tumble_on_rough_ground_keep_their_tolerance(seed):
    """Against located events of their systems: before landings were whole, 8 of 40 erred by more, up to 6000 times."""
    rng = np.random.default_rng(seed)
    scene = ns.Scene(gravity=PLANE, material=ns.Material(mu=float(rng.choice([0.1, 0.3, 0.6, 1.0]))))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.body(ns.Box(0.4, 0.1), mass=1.0, position=(0, 0.35), turn=rng.uniform(-1.2, 1.2),
               velocity=(rng.uniform(-1, 1), 0), spin=rng.uniform(-3, 3), name="b")  # fmt: skip
    t_end = rng.uniform(0.25, 0.5)
    expected = ns.simulate(scene, (0, t_end), integrator=ns.EventDriven())["b"]
    for tol in (1e-3, 1e-5):
        sol = ns.simulate(scene, (0, t_end), integrator=ns.Adaptive(rtol=tol, atol=0.01 * tol), **BY_STEPS)["b"]
        apart = np.append(sol.position[-1] - expected.position[-1], 0.2 * (sol.turn[-1] - expected.turn[-1]))
        assert np.abs(apart).max() <= FACTOR * tol * 0.6  # reach of 0.2 m, way of 0.4 m


def tower(n=12):
    scene = ns.Scene(gravity=SPACE, material=ns.Material(mu=0.5, e=0.3))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    for k in range(n):
        scene.body(ns.Box(0.2, 0.2, 0.1), mass=1.0, position=(0, 0, 0.05 + 0.1 * k), name=f"b{k}")
    return scene


BY_STEPS = {"record": ("bodies", "pairs")}  # what a run by the system does not take


@pytest.mark.parametrize("tol", [1e-3, 1e-4, 1e-6])
@pytest.mark.parametrize("gravity", [PLANE, SPACE])
def test_what_lands_flat_on_rough_ground_stands_where_it_lands(gravity, tol):
    """A box with v_T < mu v_N stands at once, v t_l from its start: its whole impulse comes at the landing."""
    fill = (0,) * (len(gravity) - 2)
    scene = ns.Scene(gravity=gravity, material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfSpace((0, 0, 1)) if fill else ns.HalfPlane((0, 1)))
    box = ns.Box(0.3, 0.2, 0.1) if fill else ns.Box(0.3, 0.1)
    scene.body(box, mass=1.0, position=(0, *fill, 0.3), velocity=(0.1, *fill, 0), name="b")
    sol = ns.simulate(scene, (0, 0.5), integrator=ns.Adaptive(rtol=tol, atol=0.01 * tol), **BY_STEPS)
    expected = (0.1 * math.sqrt(2 * 0.25 / G), *fill, 0.05)
    assert np.abs(sol["b"].position[-1] - expected).max() <= FACTOR * tol * (0.01 + 0.4)  # reach and way of 0.4 m


def rod_over_rough_ground(mu):
    scene = ns.Scene(gravity=PLANE, material=ns.Material(mu=mu))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.body(ns.Box(0.4, 0.05), mass=1.0, position=(0, 0.4), turn=0.6, velocity=(0.4, 0), spin=1.0, name="b")
    return scene


@pytest.mark.upkeep
@pytest.mark.parametrize("tol", [1e-3, 1e-4, 1e-5, 1e-6])
@pytest.mark.parametrize("mu", [0.0, 0.1, 0.3, 1.0])
def test_a_rod_that_lands_on_rough_ground_moves_as_its_system_with_located_events(mu, tol):
    """Parts of an impulse, one step after the other, would be another impact: friction has another way in each."""
    t_end = 0.225  # 5 ms after the landing of its corner, at 0.2197 s, at up to 7 rad/s
    expected = ns.simulate(rod_over_rough_ground(mu), (0, t_end), integrator=ns.EventDriven())["b"]
    sol = ns.simulate(
        rod_over_rough_ground(mu), (0, t_end), integrator=ns.Adaptive(rtol=tol, atol=0.01 * tol), **BY_STEPS
    )["b"]
    apart = np.append(sol.position[-1] - expected.position[-1], 0.2 * (sol.turn[-1] - expected.turn[-1]))
    assert np.abs(apart).max() <= FACTOR * tol * (0.01 + 0.5)
    # the velocities of an impact err as the angle at it does: 2 m/s times a tenth of the tolerance over 0.2 m
    np.testing.assert_allclose(sol.velocity[-1], expected.velocity[-1], atol=2 * FACTOR * tol)


def test_what_rests_costs_a_few_steps_and_moves_by_nothing():
    sol = ns.simulate(tower(), (0, 60), integrator=ns.Adaptive(rtol=1e-6, atol=1e-8), every=1)
    assert sol.stats.lengths.rejected == 0
    # a step is at most the way of half a reach at the speed of its fall, r = sqrt(.1^2 + .1^2 + .05^2)
    longest = 0.5 * 0.15 / math.sqrt(G * 0.5 * 0.15)
    assert sol.stats.steps < 1.2 * 60 / longest
    assert np.abs(sol.position[-1] - sol.position[0]).max() < 1e-12


def falling_things():
    scene = ns.Scene(gravity=SPACE, material=ns.Material(mu=0.3, e=0.5))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    scene.body(ns.Sphere(0.1), mass=2.0, position=(0, 0, 0.3), velocity=(1, 0, 0), spin=(0, 0, 1), name="ball")
    scene.body(ns.Box(0.1, 0.1, 0.1), mass=1.0, position=(1, 0, 0.05), name="box")
    scene.body(ns.Capsule(0.05, 0.2), mass=1.0, position=(0.5, 0.1, 0.4), spin=(1, 0, 0), name="capsule")
    return scene


def test_the_impulses_of_a_record_are_those_of_the_whole_step():
    """Each kept step: m (v_1 - v_0 - g h) = sum of P, of both halves and the impacts in them."""
    scene = falling_things()
    run = ns.Adaptive(rtol=1e-4, atol=1e-6)
    sol = ns.simulate(scene, (0, 0.6), integrator=run, record=("bodies", "contacts", "events"))
    mass, h = np.array([2.0, 1.0, 1.0]), np.diff(sol.t)
    gained = mass[:, None] * (np.diff(sol.velocity[:, 1:], axis=0) - h[:, None, None] * np.array(SPACE))
    given = np.zeros_like(gained)
    for k in range(len(h)):
        contacts = sol.contacts(sol.t[k + 1])
        for i, j, P in zip(contacts.i, contacts.j, contacts.P, strict=True):
            for body, sign in ((i, -1.0), (j, 1.0)):
                if body > 0:
                    given[k, body - 1] += sign * P
    np.testing.assert_allclose(given, gained, atol=1e-12)
    landings = [event for event in sol.events if event.kind == ns.SceneEventKind.LANDING]
    assert {"ball", "capsule"} <= {event.j for event in landings}
    assert all(event.P_N > 0 for event in landings)


def test_records_are_at_their_times():
    times = np.array([0.0, 0.1, 0.123456789, 0.5])
    sol = ns.simulate(falling_things(), (0, 0.5), integrator=ns.Adaptive(rtol=1e-4, atol=1e-6), t_eval=times)
    np.testing.assert_array_equal(sol.t, times)


def test_a_run_that_is_resumed_has_the_same_bits(tmp_path):
    run, kinds = ns.Adaptive(rtol=1e-4, atol=1e-6), ("bodies", "contacts", "ledger")
    whole = ns.simulate(falling_things(), (0, 0.6), integrator=run, record=kinds)
    place = tmp_path / "run"
    ns.simulate(falling_things(), (0, 0.6), integrator=run, record=kinds, checkpoint=place, max_steps=20,
                on_failure="return")  # fmt: skip
    resumed = ns.simulate(falling_things(), (0, 0.6), integrator=run, record=kinds, resume=place)
    np.testing.assert_array_equal(resumed.t, whole.t)
    np.testing.assert_array_equal(resumed.position, whole.position)
    np.testing.assert_array_equal(resumed.ledger["kinetic"], whole.ledger["kinetic"])
    assert resumed.stats.lengths == whole.stats.lengths and resumed.stats.steps == whole.stats.steps


def test_threads_change_no_bit():
    one, two = (ns.simulate(tower(), (0, 0.2), integrator=ns.Adaptive(rtol=1e-4, atol=1e-6), threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one.position, two.position)


def test_what_no_step_is_short_enough_for_ends_the_run():
    """A piston that is moved by a jump strikes a ball at no speed: the shorter the step, the faster."""
    scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=0.0))
    scene.kinematic(ns.Box(0.1, 1.0), motion=lambda t: ((0.5 if t > 0.1 else 0.0, 0.0), 0.0), name="piston")
    scene.body(ns.Disc(0.1), mass=1.0, position=(0.3, 0.0), name="ball")
    with pytest.raises(ns.StepFailure, match="too short for the tolerance") as caught:
        ns.simulate(scene, (0, 0.5), integrator=ns.Adaptive(rtol=1e-6, atol=1e-9))
    sol = caught.value.solution
    assert sol.status == Status.STEP_VANISHED and sol.t[-1] == pytest.approx(0.1, abs=1e-9)
    np.testing.assert_array_equal(sol["ball"].position[-1], (0.3, 0.0))


def test_what_ends_a_step_is_named():
    """A law of friction that is negative at the speed of the second of three boxes."""
    scene = ns.Scene(gravity=PLANE, material=ns.Material(mu=ns.Friction(lambda v: 0.5 - 0.2 * v)))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    for k, speed in enumerate((1.0, 3.0, 1.0)):
        scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(5 * k, 0.1), velocity=(speed, 0), name=f"box {k}")
    with pytest.raises(ns.StepFailure, match="the friction law of ground and box 1 is negative") as caught:
        ns.simulate(scene, (0, 1), integrator=ns.Adaptive(1e-4))
    np.testing.assert_array_equal(caught.value.solution.position[-1, 1:, 0], (0, 5, 10))


def test_a_force_that_raises_ends_the_run_at_the_last_whole_step():
    def force(t, bodies):
        if t > 0.1:
            raise ValueError("no force")
        return 0.0, 0.0, 1.0

    scene = falling_things()
    scene.force("ball", force)
    with pytest.raises(ns.StepFailure, match="no force") as caught:
        ns.simulate(scene, (0, 0.5), integrator=ns.Adaptive(rtol=1e-4, atol=1e-6))
    sol = caught.value.solution
    v = sol["ball"].velocity[-1, 2]
    assert 0.0 < sol.t[-1] < 0.1 and v == pytest.approx((-G + 0.5) * sol.t[-1], rel=1e-12)


@pytest.mark.parametrize(
    "option",
    [{"checkpoint": "run"}, {"threads": 2}, {"record": ["bodies", "pairs"]}],
    ids=lambda option: next(iter(option)),
)
def test_what_a_run_by_the_system_does_not_take_is_taken_by_steps(option, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = ns.Scene(gravity=PLANE)
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 1), name="b")
    sol = ns.simulate(scene, (0, 0.2), integrator=ns.Adaptive(1e-6), **option)
    assert sol.stats.lengths is not None and next(iter(option)) in sol.about["chosen"]
    assert sol["b"].position[-1, 1] == pytest.approx(1 - 0.5 * G * 0.04, rel=1e-12)


@pytest.mark.upkeep
def test_a_scene_of_few_contacts_is_taken_as_its_system():
    scene = ns.Scene(gravity=PLANE)
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 1), name="b")
    as_system = ns.simulate(scene, (0, 0.2), integrator=ns.Adaptive())
    assert as_system.stats.lengths is None and "chosen" not in as_system.about
    scene.force("b", lambda t, bodies: (1.0, 0.0))
    by_steps = ns.simulate(scene, (0, 0.2), integrator=ns.Adaptive())
    assert by_steps.stats.lengths is not None and "the force on b" in by_steps.about["chosen"]
    said = by_steps.summary().splitlines()
    assert said[1].startswith("Adaptive(rtol=1e-08, atol=1e-10), because the force on b is a function")
    assert any("steps of" in line and "in vain" in line for line in said)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_error_of_a_step_is_the_distance_of_its_ends_at_the_reach_of_a_body(dim):
    """Of places and of turns, less what was taken back of penetrations; of velocities where a landing comes."""
    rng, reach, tol, h, left = np.random.default_rng(dim), 0.7, 1e-6, 1e-3, 0.25
    scene = ns.Scene(gravity=(0,) * dim)
    scene.body(ns.Disc(reach) if dim == 2 else ns.Sphere(reach), mass=1.0)
    run = ControlledRun(scene, (0.0, 1.0), ns.Adaptive(rtol=1e-13, atol=tol), 1, None)
    assembly = run.assembly
    for far in (1e-2, 1.0) * 10:  # the turn counts, or the way
        way, turn = 1e-3 * far * rng.normal(size=dim), 1e-4 * rng.normal(size=2 * dim - 3)
        for each in (assembly.whole, assembly.halves):
            each.x[:], each.v[:], each.push[:] = 0.0, 0.0, 0.0
            each.lands = each.rebounds = 0
        if dim == 2:
            assembly.halves.x[0, 2:] = turn
        else:
            first = Rotation.from_rotvec(rng.normal(size=3))
            for each, at in ((assembly.whole, first), (assembly.halves, Rotation.from_rotvec(turn) * first)):
                each.x[0, 3:] = np.roll(at.as_quat(), 1) * rng.choice((-1, 1))
        assembly.halves.x[0, :dim] = way
        assembly.halves.push[0] = 0.5 * np.concatenate((way, turn))
        apart = 0.5 * max(np.linalg.norm(way), reach * np.linalg.norm(turn))
        assert assembly._error(h, 0.0) == pytest.approx(apart / tol, rel=2e-6)
        assembly.course.v[:], assembly.halves.v[:], assembly.whole.v[:] = 0.0, 0.0, 0.0
        assembly.halves.v[0, :dim], assembly.whole.lands = 1e4 * way, 1
        speed = 1e4 * np.linalg.norm(way)
        struck, later = OFF_BY * h * speed, left * min(speed, speed * h * speed / reach)
        assert assembly._error(h, left) == pytest.approx(max(apart, struck, later) / tol, rel=2e-6)
    assembly.halves.x[0, 0] = np.nan
    assert assembly._error(h, left) == np.inf
