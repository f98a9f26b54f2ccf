"""Spatial scenes against closed forms, invariants and measured orders."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.scenes.places import matrix_of

G = 9.81
GRAVITY = (0.0, 0.0, -G)
DT = 2e-3
EPS = np.finfo(float).eps


def simulate(scene, t_end, dt=DT, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)


def floor(material, **options):
    scene = ns.Scene(gravity=GRAVITY, material=material)
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="floor", **options)
    return scene


def tumbling():
    scene = ns.Scene(gravity=(0, 0, 0))
    scene.body(ns.Box(0.1, 0.2, 0.3), density=1000, spin=(0.01, 5.0, 0.02), velocity=(1, 2, 3), name="box")
    return scene


def moments_of_box(a, b, c, density):
    return density * a * b * c / 12 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])


def test_free_rotation_keeps_energy_and_angular_momentum_however_long_the_step():
    moments = moments_of_box(0.1, 0.2, 0.3, 1000)
    for dt in (1e-3, 5e-2):
        solution = simulate(tumbling(), 20.0, dt)
        box = solution["box"]
        turns = np.array([matrix_of(q) for q in box.turn])
        L = np.einsum("tij,j,tkj,tk->ti", turns, moments, turns, box.spin)
        steps = len(box.t)
        np.testing.assert_allclose(L, np.tile(L[0], (steps, 1)), atol=16 * steps * EPS * np.linalg.norm(L[0]))
        np.testing.assert_allclose(solution.ledger["kinetic"], solution.ledger["kinetic"][0], rtol=16 * steps * EPS)
        assert np.abs(np.linalg.norm(box.turn, axis=1) - 1.0).max() <= 4 * EPS


@pytest.mark.parametrize("turn_of_step", [0.1, 0.6, 3.0, 30.0])
@pytest.mark.parametrize("shape", [ns.Capsule(0.3, 0.005), ns.Box(0.3, 0.01, 0.01), ns.Box(0.3, 0.2, 0.01)], ids=repr)
def test_thin_bodies_spin_freely_with_their_energy_and_angular_momentum(shape, turn_of_step):
    """A rod of 1 : 30 has moments of 1 : 600: the spin about its axis is what its energy shows errors of."""
    dt = 1e-3
    for seed in range(4):
        spin = np.random.default_rng(seed).normal(size=3)
        scene = ns.Scene(gravity=(0, 0, 0))
        scene.body(shape, density=1000, spin=spin * turn_of_step / dt / np.linalg.norm(spin), name="body")
        solution = simulate(scene, 0.1, dt)
        body, kinetic = solution["body"], solution.ledger["kinetic"]
        turns = np.array([matrix_of(q) for q in body.turn])
        in_body = np.einsum("tij,ti->tj", turns, body.spin)
        # of the moments of a box or a capsule, the ratio of the largest to the least is below 1500
        steps, ratio = len(body.t), 1500.0
        np.testing.assert_allclose(kinetic, kinetic[0], rtol=ratio * steps * EPS)
        moments = moments_of(shape)
        L = np.einsum("tij,j,tj->ti", turns, moments, in_body)
        np.testing.assert_allclose(L, np.tile(L[0], (steps, 1)), atol=64 * steps * EPS * np.linalg.norm(L[0]))


def moments_of(shape):
    """Moments about the axes of a box, or of a capsule along x, of density 1000."""
    if isinstance(shape, ns.Box):
        return moments_of_box(*shape.lengths, 1000)
    l, r = shape.length, shape.radius
    rod, ball = 1000 * np.pi * r * r * l, 1000 * 4 / 3 * np.pi * r**3
    along = rod * r * r / 2 + ball * 2 / 5 * r * r
    across = rod * (l * l / 12 + r * r / 4) + ball * (2 / 5 * r * r + l * l / 4 + 3 / 8 * l * r)
    return np.array([along, across, across])


def test_tumbling_about_the_middle_axis_is_of_second_order():
    """Against Euler's equations, I omega' = I omega x omega with q' = q omega/2, by DOP853 to 1e-12."""
    moments = moments_of_box(0.1, 0.2, 0.3, 1000)

    def rates(t, y):
        q, w = y[:4], y[4:]
        r = q[1:]
        return [*(-0.5 * (r @ w),), *(0.5 * (q[0] * w + np.cross(r, w))), *(np.cross(moments * w, w) / moments)]

    t_end = 3.0
    exact = solve_ivp(rates, (0, t_end), [1, 0, 0, 0, 0.01, 5.0, 0.02], method="DOP853", rtol=1e-12, atol=1e-14).y[
        :4, -1
    ]
    errors = []
    for dt in (4e-3, 2e-3, 1e-3):
        turn = simulate(tumbling(), t_end, dt)["box"].turn[-1]
        errors.append(min(np.abs(turn - exact).max(), np.abs(turn + exact).max()))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (np.abs(orders - 2.0) < 0.05).all(), errors


def test_ball_slides_and_then_rolls_with_five_sevenths_of_its_speed():
    mu, v_0, r = 0.2, 2.0, 0.1
    scene = floor(ns.Material(mu=mu))
    scene.body(ns.Sphere(r), density=1000, position=(0, 0, r), velocity=(v_0, 0, 0), name="ball")
    ball = simulate(scene, 1.0, 1e-3)["ball"]
    assert ball.velocity[-1, 0] == pytest.approx(5 / 7 * v_0, rel=1e-12)
    slip = np.linalg.norm(ball.velocity[:, :2] - r * np.stack([ball.spin[:, 1], -ball.spin[:, 0]], axis=1), axis=1)
    assert abs(ball.t[np.argmax(slip < 1e-9)] - 2 * v_0 / (7 * mu * G)) <= 1e-3
    # x is of second order but for the one step in which it begins to roll
    t_roll = 2 * v_0 / (7 * mu * G)
    x = v_0 * t_roll - 0.5 * mu * G * t_roll**2 + 5 / 7 * v_0 * (1.0 - t_roll)
    assert abs(ball.position[-1, 0] - x) <= mu * G * 1e-3**2


def test_friction_opposes_sliding_in_every_direction_on_the_round_cone():
    mu, speed = 0.3, 1.0
    for angle in np.linspace(0, 2 * np.pi, 7):
        scene = floor(ns.Material(mu=mu))
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        scene.body(ns.Box(0.2, 0.2, 0.02), density=1000, position=(0, 0, 0.01), velocity=speed * way, name="plate")
        plate = simulate(scene, 0.5)["plate"]
        stop = speed**2 / (2 * mu * G)
        # its height tilts the load forward, not the direction; the plate turns by what that moves: (h mu / a)^2
        assert plate.position[-1] @ way == pytest.approx(stop, rel=2e-3)
        assert abs(plate.position[-1] @ np.array([-way[1], way[0], 0.0])) <= 1e-6


def test_block_at_half_its_friction_limit_stays_to_the_last_bit():
    mu = 0.5
    angle = np.arctan(0.5 * mu)
    normal = np.array([-np.sin(angle), 0.0, np.cos(angle)])
    scene = ns.Scene(gravity=GRAVITY, material=ns.Material(mu=mu))
    scene.fixed(ns.HalfSpace(normal))
    turn = (np.cos(angle / 2), 0, -np.sin(angle / 2), 0)
    scene.body(ns.Box(0.4, 0.3, 0.2), density=1000, position=0.1 * normal, turn=turn, name="block")
    block = simulate(scene, 10.0, every=100)["block"]
    np.testing.assert_array_equal(block.position, np.tile(block.position[0], (len(block.t), 1)))
    np.testing.assert_array_equal(block.turn, np.tile(block.turn[0], (len(block.t), 1)))


@pytest.mark.parametrize("top", [1.0, 1000.0])
def test_stack_with_a_heavy_top_stands(top):
    scene = floor(ns.Material(mu=0.5))
    for k in range(10):
        density = 1000.0 * (top if k == 9 else 1.0)
        scene.body(ns.Box(0.2, 0.2, 0.2), density=density, position=(0, 0, 0.1 + 0.2 * k))
    solution = simulate(scene, 2.0, every=10)
    assert np.abs(solution.position - solution.position[0]).max() < 1e-12
    weights = 1000 * 0.008 * G * DT * (9 + top)
    assert solution.contacts().of("floor").P_N.sum() == pytest.approx(weights, rel=1e-9)


def test_ball_on_a_turntable_rolls_in_a_circle():
    """A ball that rolls on a table of spin Omega moves in a circle with 2/7 Omega, wherever it starts."""
    omega, r, v = 2.0, 0.05, 0.3
    scene = ns.Scene(gravity=GRAVITY, material=ns.Material(mu=1.0))
    scene.kinematic(ns.HalfSpace((0, 0, 1)), spin=(0, 0, omega), name="table")
    # rolling at the start: v + omega_ball x (-r e_z) = Omega x x
    x = np.array([0.4, 0.0])
    slip = np.array([-omega * x[1], omega * x[0]])
    spin = np.array([-(v * 1.0 - slip[1]) / r, (0.0 - slip[0]) / r, 0.0])
    scene.body(ns.Sphere(r), density=1000, position=(*x, r), velocity=(0, v, 0), spin=spin, name="ball")
    errors = []
    for dt in (4e-3, 2e-3):
        ball = simulate(scene, 2 * np.pi / (2 / 7 * omega), dt)["ball"]
        errors.append(np.linalg.norm(ball.position[-1] - ball.position[0]))  # back at the start after one turn
        np.testing.assert_allclose(np.linalg.norm(ball.velocity, axis=1), v, rtol=omega * dt * 2 * np.pi)
    assert errors[1] == pytest.approx(0.25 * errors[0], rel=0.05) and errors[1] < 2e-5


def test_collision_of_spheres_keeps_momentum_and_angular_momentum():
    scene = ns.Scene(gravity=(0, 0, 0), material=ns.Material(mu=0.3, e=0.8))
    scene.body(ns.Sphere(0.1), mass=1.0, position=(0, 0, 0), velocity=(2, 0, 0), spin=(1, 2, 3), name="a")
    scene.body(ns.Sphere(0.1), mass=3.0, position=(0.5, 0.06, 0.03), velocity=(-1, 0, 0), spin=(-2, 0, 1), name="b")
    solution = simulate(scene, 0.5, 1e-3)
    total, moment = 0.0, 0.0
    for name, m in (("a", 1.0), ("b", 3.0)):
        body = solution[name]
        total = total + m * body.velocity
        moment = moment + m * np.cross(body.position, body.velocity) + 0.4 * m * 0.01 * body.spin
    assert np.ptp(solution["a"].velocity[:, 0]) > 1.0
    np.testing.assert_allclose(total, np.tile(total[0], (len(total), 1)), atol=1e-14)
    np.testing.assert_allclose(moment, np.tile(moment[0], (len(moment), 1)), atol=1e-13)


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")
def test_energy_ledger_of_falling_boxes_closes():
    rng = np.random.default_rng(5)
    scene = floor(ns.Material(mu=0.4, e=0.2))
    for k in range(4):
        quaternion = rng.normal(size=4)
        scene.body(
            ns.Box(0.3, 0.2, 0.1), density=800, position=(0.05 * k, 0, 0.4 + 0.4 * k), spin=rng.normal(size=3),
            turn=quaternion / np.linalg.norm(quaternion),
        )  # fmt: skip
    solution = simulate(scene, 1.0, 2.5e-4, every=10)
    ledger = solution.ledger
    works = sum(ledger[name] for name in ("force", "friction", "normal", "surface"))
    gained = ledger["kinetic"] - ledger["kinetic"][0]
    # impulses change the spin at the places before the step, and the energy is that of those after it: of order dt
    assert np.abs(gained - works).max() <= 0.005 * ledger["force"].max()
    assert ledger["friction"][-1] + ledger["normal"][-1] < 0.0


def test_chain_that_is_hit_at_once_has_newtons_answer_and_its_energy():
    """Five spheres that touch, e = 1: Newton's law gives (-0.6, 0.4, 0.4, 0.4, 0.4), and keeps the energy."""
    scene = ns.Scene(gravity=(0, 0, 0), material=ns.Material(mu=0.0, e=1.0))
    for k in range(5):
        first = k == 0
        scene.body(
            ns.Sphere(0.05), mass=1.0, position=(0.1 * k - 0.1 * first, 0, 0), velocity=(1.0 * first, 0, 0)
        )  # fmt: skip
    with pytest.warns(ns.SimultaneousImpactWarning, match="was struck by several bodies at once"):
        solution = simulate(scene, 0.3, 1e-3)
    np.testing.assert_allclose(solution.velocity[-1, :, 0], [-0.6, 0.4, 0.4, 0.4, 0.4], atol=1e-12)
    assert solution.stats.energy_gains == 0
