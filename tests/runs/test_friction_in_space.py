"""Friction in two directions: the round cone, against closed forms and independent integrations."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns


class Block(NamedTuple):
    m: float = 2.0  # [kg]
    g: float = 9.81  # [m/s^2]
    mu: float = 0.3
    tilt: float = 0.0  # [rad] of the plane, down along x
    belt: float = 0.0  # [m/s] of the plane along x
    e_F: float = 0.0


def mass(t, q, p, M):
    M[0, 0], M[1, 1], M[2, 2] = p.m, p.m, p.m


def weight(t, q, u, p, h):
    h[0], h[2] = p.m * p.g * math.sin(p.tilt), -p.m * p.g * math.cos(p.tilt)


def height(t, q, p, g_N):
    g_N[0] = q[2]


def along(t, q, p, W_F):
    W_F[0, 0, 0], W_F[0, 1, 1] = 1.0, 1.0


def belt(t, q, p, w_F):
    w_F[0, 0] = -p.belt


COORDINATES = [("x", "m"), ("y", "m"), ("z", "m")]


def a_block(contact=None, **parameters):
    contact = contact or ns.Contact(mu="mu", e_F="e_F", directions=2, name="foot")
    return ns.System(coordinates=COORDINATES, mass=mass, force=weight, gap=height, tangent=along, contacts=[contact],
                     surface_velocity=belt, parameters=Block(**parameters), name="block")  # fmt: skip


def run(system, t_end, u, dt, q=(0.0, 0.0, 0.0), **options):
    return ns.simulate(system, (0, t_end), q, u, integrator=ns.MoreauJean(dt=dt), **options)


def order(errors):
    """By halving the step."""
    return np.log2(np.divide(errors[:-1], errors[1:]))


def test_a_block_thrown_obliquely_stops_on_a_line_where_its_energy_is_spent():
    """v^2/(2 mu g), to the step in which it stops: v dt; a slide goes on for some roundings of the position."""
    v, dt, p = np.array([1.2, 0.7, 0.0]), 1e-3, Block()
    sol = run(a_block(), 1.0, v, dt)
    way = sol.q[-1, :2]
    assert np.linalg.norm(way) == pytest.approx(v @ v / (2 * p.mu * p.g), abs=p.mu * p.g * dt**2)
    assert abs(way[0] * v[1] - way[1] * v[0]) < 1e-12
    assert (sol.u[-1] == 0.0).all() and sol.mode[-1, 0] == ns.ContactMode.STICK
    assert sol.ledger["friction"][-1] == pytest.approx(-p.m * v @ v / 2, rel=1e-12)
    stops = [event for event in sol.events if event.mode_after == ns.ContactMode.STICK]
    assert [event.slip_before for event in stops] == [0]
    assert stops[0].t == pytest.approx(np.linalg.norm(v) / (p.mu * p.g), abs=2 * dt)


def test_friction_has_the_size_of_the_cone_and_opposes_the_slide():
    sol = run(a_block(), 0.2, [1.2, 0.7, 0.0], 1e-3)
    assert sol.P_F.shape == (len(sol.t), 1, 2)
    np.testing.assert_allclose(np.linalg.norm(sol.P_F[1:, 0], axis=1), 0.3 * sol.P_N[1:, 0], rtol=1e-13)
    unit = sol.gamma_F[1:, 0] / np.linalg.norm(sol.gamma_F[1:, 0], axis=1)[:, None]
    np.testing.assert_allclose(sol.P_F[1:, 0] / (0.3 * sol.P_N[1:]), -unit, atol=1e-12)
    assert (sol.slip == 0).all() and (sol.mode == ns.ContactMode.SLIDE).all()


def test_a_block_carried_off_by_a_conveyor_follows_its_parabola():
    """Thrown across it: relative to the belt it goes straight, v' = -mu g w/|w|, until it rests on it."""
    p = Block(belt=1.5)

    def rate(t, x):
        w = x[2:] - [p.belt, 0.0]
        return np.concatenate([x[2:], -p.mu * p.g * w / np.linalg.norm(w)])

    end = solve_ivp(rate, (0, 0.4), [0, 0, 0, 1.0], rtol=1e-12, atol=1e-13).y[:, -1]
    sol = run(a_block(belt=1.5), 0.4, [0, 1.0, 0], 0.01)
    np.testing.assert_allclose([*sol.q[-1, :2], *sol.u[-1, :2]], end, atol=1e-11)
    resting = run(a_block(belt=1.5), 2.0, [0, 1.0, 0], 0.01)
    np.testing.assert_allclose(resting.u[-1], [1.5, 0, 0], atol=1e-14)
    assert resting.ledger["surface"][-1] > 0.0


def down_the_plane(mu_of, p):
    """Sliding across a plane that is tilted, by an independent method."""

    def rate(t, x):
        v = np.linalg.norm(x[2:])
        return np.concatenate([x[2:], [p.g * math.sin(p.tilt), 0] - mu_of(v) * p.g * math.cos(p.tilt) * x[2:] / v])

    return solve_ivp(rate, (0, 0.3), [0, 0, 0, 2.0], rtol=1e-12, atol=1e-13).y[:, -1]


@pytest.mark.parametrize(("mu", "mu_of"), [
    ("mu", lambda v: 0.6),
    (ns.Stribeck(mu_s=0.9, mu_k=0.6, v_s=0.5), lambda v: 0.6 + 0.3 * math.exp(-v / 0.5)),
    (ns.Polynomial(m0=0.6, m1=0.1), lambda v: 0.6 - 0.1 * v),
    (ns.StaticKinetic(mu_s=0.8, mu_k=0.6), lambda v: 0.6),
    (ns.Friction(lambda v, p: p.mu / (1.0 + v)), lambda v: 0.6 / (1.0 + v)),
], ids=["Coulomb", "Stribeck", "Polynomial", "StaticKinetic", "own"])  # fmt: skip
def test_a_slide_that_turns_is_of_second_order(mu, mu_of):
    p = Block(mu=0.6, tilt=0.4)
    end, errors = down_the_plane(mu_of, p), []
    for dt in (0.02, 0.01, 0.005):
        sol = run(a_block(ns.Contact(mu=mu, directions=2), mu=0.6, tilt=0.4), 0.3, [0, 2.0, 0], dt)
        errors.append(np.abs(np.concatenate([sol.q[-1, :2], sol.u[-1, :2]]) - end).max())
        assert sol.stats.worst_residual < 1e-12
    assert errors[-1] < 1e-4
    np.testing.assert_allclose(order(errors), 2.0, atol=0.15)


@pytest.mark.parametrize(("push", "mode"), [(0.98, "STICK"), (1.02, "SLIDE")])
def test_a_block_pushed_sideways_on_an_incline_holds_up_to_the_cone(push, mode):
    """The force along the plane is (g sin tilt, f), the cone mu g cos tilt: two directions share one mu."""
    p = Block(mu=0.6, tilt=0.4)
    side = push * math.sqrt((p.mu * math.cos(p.tilt)) ** 2 - math.sin(p.tilt) ** 2)

    def pushed(t, q, u, p, h):
        h[0], h[1], h[2] = p.m * p.g * math.sin(p.tilt), p.m * p.g * side, -p.m * p.g * math.cos(p.tilt)

    system = ns.System(n_q=3, mass=mass, force=pushed, gap=height, tangent=along, parameters=p,
                       contacts=[ns.Contact(mu="mu", directions=2)])  # fmt: skip
    sol = run(system, 0.5, [0, 0, 0], 1e-2)
    assert (sol.mode[1:, 0] == ns.ContactMode[mode]).all()
    if mode == "STICK":
        assert (sol.q == 0.0).all()
    else:
        f = p.g * np.array([math.sin(p.tilt), side])
        a = f - p.mu * p.g * math.cos(p.tilt) * f / np.linalg.norm(f)
        np.testing.assert_allclose(sol.u[-1, :2], 0.5 * a, rtol=1e-12)


class Bowl(NamedTuple):
    m: float = 0.5
    g: float = 9.81
    mu: float = 0.8
    c: float = 2.0  # [1/m]: z = c (x^2 + y^2)/2
    omega: float = 3.0  # [rad/s]


def of_bowl():
    def inertia(t, q, p, M):
        M[0, 0], M[1, 1], M[2, 2] = p.m, p.m, p.m

    def load(t, q, u, p, h):
        h[2] = -p.m * p.g

    def above(t, q, p, g_N):
        g_N[0] = q[2] - 0.5 * p.c * (q[0] ** 2 + q[1] ** 2)

    def normal(t, q, p, W_N):
        W_N[0, 0], W_N[0, 1], W_N[0, 2] = -p.c * q[0], -p.c * q[1], 1.0

    def tangents(t, q, p, W_F):
        r = math.sqrt(q[0] ** 2 + q[1] ** 2)
        s = math.sqrt(1.0 + (p.c * r) ** 2)
        W_F[0, 0, 0], W_F[0, 0, 1], W_F[0, 0, 2] = q[0] / (r * s), q[1] / (r * s), p.c * r / s
        W_F[0, 1, 0], W_F[0, 1, 1] = -q[1] / r, q[0] / r

    def turning(t, q, p, w_F):
        w_F[0, 1] = -p.omega * math.sqrt(q[0] ** 2 + q[1] ** 2)

    return ns.System(n_q=3, mass=inertia, force=load, gap=above, normal=normal, tangent=tangents, parameters=Bowl(),
                     surface_velocity=turning, contacts=[ns.Contact(mu="mu", directions=2)])  # fmt: skip


@pytest.mark.upkeep
def test_a_particle_in_a_turning_bowl_sticks_and_goes_round():
    """It sticks where |g tan a - omega^2 r| <= mu (g + omega^2 r tan a), tan a = c r: held at r = 0.3 m by friction."""
    p, r = Bowl(), 0.3
    slope = p.c * r
    assert abs(p.g * slope - p.omega**2 * r) < p.mu * (p.g + p.omega**2 * r * slope)
    q, t_end = [r, 0.0, 0.5 * p.c * r**2], 1.0
    ends = []
    for dt in (1e-3, 5e-4):
        sol = run(of_bowl(), t_end, [0.0, p.omega * r, 0.0], dt, q=q)
        assert (sol.mode == ns.ContactMode.STICK).all()
        ends.append(np.abs(sol.q[-1, :2] - r * np.array([math.cos(p.omega), math.sin(p.omega)])).max())
    assert ends[0] < 1e-3
    assert ends[1] < 0.3 * ends[0]


def test_a_block_that_lands_obliquely_keeps_its_direction():
    """An impact with e_N = 0: P_N = m v_z, and friction takes mu P_N from the speed along the plane."""
    sol = run(a_block(), 0.2, [3.0, 4.0, -1.0], 1e-3, q=(0.0, 0.0, 0.1))
    event = next(event for event in sol.events if event.kind == ns.EventKind.IMPACT)
    after = sol.u[np.searchsorted(sol.t, event.t) + 1]
    p, dt = Block(), 1e-3
    lost = p.mu * abs(event.gamma_N)
    assert np.hypot(*after[:2]) == pytest.approx(5.0 - lost, abs=2 * p.mu * p.g * dt)
    assert after[0] / after[1] == pytest.approx(0.75, rel=1e-12)
    assert event.P_F == pytest.approx(p.mu * event.P_N, rel=1e-12)


def test_a_planar_contact_and_one_without_friction_stand_beside_it():
    """Three blocks in one system: friction in two directions, along x alone, and none."""

    def masses(t, q, p, M):
        for i in range(9):
            M[i, i] = p.m

    def weights(t, q, u, p, h):
        for k in range(3):
            h[3 * k + 2] = -p.m * p.g

    def heights(t, q, p, g_N):
        for k in range(3):
            g_N[k] = q[3 * k + 2]

    def tangents(t, q, p, W_F):
        W_F[0, 0, 0], W_F[0, 1, 1], W_F[1, 0, 3] = 1.0, 1.0, 1.0

    system = ns.System(n_q=9, mass=masses, force=weights, gap=heights, tangent=tangents, parameters=Block(),
                       contacts=[ns.Contact(mu=0.3, directions=2), ns.Contact(mu=0.3), ns.Contact()])  # fmt: skip
    v = [3.0, 4.0, 0.0]
    sol = run(system, 0.2, 3 * v, 1e-3, q=9 * [0.0])
    lost = 0.3 * 9.81 * 0.2
    np.testing.assert_allclose(
        sol.u[-1], [3 * (1 - lost / 5), 4 * (1 - lost / 5), 0, 3 - lost, 4, 0, 3, 4, 0], rtol=1e-12
    )
    assert sol.mode[-1].tolist() == [ns.ContactMode.SLIDE, ns.ContactMode.SLIDE, ns.ContactMode.LOCKED]
    assert sol.slip[-1].tolist() == [0, 1, 0]


def test_friction_under_a_given_normal_force_has_two_directions_too():
    """A puck pressed by 5 N: m |v|' = -mu N along its velocity."""

    def pressed(t, q, u, p, N):
        N[0] = 5.0

    def free(t, q, u, p, h):
        h[0] = 0.0

    system = ns.System(n_q=3, mass=mass, force=free, tangent=along, normal_force=pressed, parameters=Block(),
                       contacts=[ns.Contact(mu="mu", normal_force=True, directions=2)])  # fmt: skip
    sol = run(system, 0.5, [3.0, 4.0, 0.0], 1e-2)
    np.testing.assert_allclose(sol.u[-1, :2], (5.0 - 0.3 * 5.0 / 2.0 * 0.5) * np.array([0.6, 0.8]), rtol=1e-12)


class Ball(NamedTuple):
    m: float = 0.17
    R: float = 0.028
    g: float = 9.81
    mu: float = 0.2


def of_ball():
    def inertia(t, q, p, M):
        for i in range(3):
            M[i, i], M[3 + i, 3 + i] = p.m, 0.4 * p.m * p.R**2

    def load(t, q, u, p, h):
        h[2] = -p.m * p.g

    def above(t, q, p, g_N):
        g_N[0] = q[2] - p.R

    def turning(t, q, p, B):
        """The angular velocity is in the axes of the table: e' = (0, omega) e / 2."""
        B[0, 0], B[1, 1], B[2, 2] = 1.0, 1.0, 1.0
        B[3, 3], B[3, 4], B[3, 5] = -0.5 * q[4], -0.5 * q[5], -0.5 * q[6]
        B[4, 3], B[4, 4], B[4, 5] = 0.5 * q[3], 0.5 * q[6], -0.5 * q[5]
        B[5, 3], B[5, 4], B[5, 5] = -0.5 * q[6], 0.5 * q[3], 0.5 * q[4]
        B[6, 3], B[6, 4], B[6, 5] = 0.5 * q[5], -0.5 * q[4], 0.5 * q[3]

    def of_contact(t, q, p, W_F):
        W_F[0, 0, 0], W_F[0, 0, 4] = 1.0, -p.R
        W_F[0, 1, 1], W_F[0, 1, 3] = 1.0, p.R

    return ns.System(n_q=7, n_u=6, kinematics=turning, mass=inertia, force=load, gap=above, tangent=of_contact,
                     contacts=[ns.Contact(mu="mu", directions=2)], parameters=Ball(), name="ball")  # fmt: skip


V, OMEGA = np.array([1.0, 0.0, 0.0]), np.array([40.0, 10.0, 5.0])


def test_a_billiard_ball_goes_from_a_parabola_to_a_line():
    """Until it rolls the slip keeps its direction, so the centre has a constant acceleration; then v = 5/7 v_0 + 2/7
    omega_0 x R, from 2 |slip_0|/(7 mu g) on."""
    p, dt = Ball(), 1e-3
    sol = ns.simulate(of_ball(), (0, 0.5), [0, 0, p.R, 1, 0, 0, 0], [*V, *OMEGA], integrator=ns.MoreauJean(dt=dt))
    slip = np.array([V[0] - p.R * OMEGA[1], V[1] + p.R * OMEGA[0]])
    until = 2 * np.linalg.norm(slip) / (7 * p.mu * p.g)
    np.testing.assert_allclose(sol.gamma_F[0, 0], slip, atol=1e-15)
    slides = sol.t < until - dt
    a = -p.mu * p.g * slip / np.linalg.norm(slip)
    parabola = np.outer(sol.t, V[:2]) + np.outer(sol.t**2 / 2, a)
    np.testing.assert_allclose(sol.q[slides, :2], parabola[slides], atol=1e-12)
    end = 5 / 7 * V[:2] + 2 / 7 * p.R * np.array([OMEGA[1], -OMEGA[0]])
    np.testing.assert_allclose(sol.u[-1, :2], end, rtol=1e-12)
    assert sol.mode[-1, 0] == ns.ContactMode.STICK
    assert np.abs(np.linalg.norm(sol.q[:, 3:], axis=1) - 1.0).max() < 1e-12


class Stool(NamedTuple):
    m: float = 3.0
    J_1: float = 0.2
    J_2: float = 0.25
    J_3: float = 0.15
    H: float = 0.1  # [m] of the centre above the floor
    r: float = 0.3  # [m] of the feet from the axis
    g: float = 9.81
    mu: float = 0.35


FEET = 0.2 + 2 * np.pi / 3 * np.arange(3)
X, Y = np.cos(FEET), np.sin(FEET)


def rotation(q, R):
    w, x, y, z = q[3], q[4], q[5], q[6]
    R[0, 0], R[0, 1], R[0, 2] = w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)
    R[1, 0], R[1, 1], R[1, 2] = 2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)
    R[2, 0], R[2, 1], R[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z


def of_stool(directions=2, **parameters):
    def inertia(t, q, p, M):
        M[0, 0], M[1, 1], M[2, 2], M[3, 3], M[4, 4], M[5, 5] = p.m, p.m, p.m, p.J_1, p.J_2, p.J_3

    def load(t, q, u, p, h):
        h[2] = -p.m * p.g
        h[3], h[4] = (p.J_2 - p.J_3) * u[4] * u[5], (p.J_3 - p.J_1) * u[5] * u[3]
        h[5] = (p.J_1 - p.J_2) * u[3] * u[4]

    def turning(t, q, p, B):
        B[0, 0], B[1, 1], B[2, 2] = 1.0, 1.0, 1.0
        B[3, 3], B[3, 4], B[3, 5] = -0.5 * q[4], -0.5 * q[5], -0.5 * q[6]
        B[4, 3], B[4, 4], B[4, 5] = 0.5 * q[3], -0.5 * q[6], 0.5 * q[5]
        B[5, 3], B[5, 4], B[5, 5] = 0.5 * q[6], 0.5 * q[3], -0.5 * q[4]
        B[6, 3], B[6, 4], B[6, 5] = -0.5 * q[5], 0.5 * q[4], 0.5 * q[3]

    def above(t, q, p, g_N):
        w, x, y, z = q[3], q[4], q[5], q[6]
        for k in range(3):
            lean = 2 * (x * z - w * y) * X[k] + 2 * (y * z + w * x) * Y[k]
            g_N[k] = q[2] + p.r * lean - (w * w - x * x - y * y + z * z) * p.H

    def of_feet(t, q, p, W_F):
        R = np.zeros((3, 3))
        rotation(q, R)
        for k in range(3):
            a, b, c = p.r * X[k], p.r * Y[k], -p.H
            for d in range(2):
                W_F[k, d, d] = 1.0
                W_F[k, d, 3] = R[d, 2] * b - R[d, 1] * c
                W_F[k, d, 4] = R[d, 0] * c - R[d, 2] * a
                W_F[k, d, 5] = R[d, 1] * a - R[d, 0] * b

    feet = [ns.Contact(mu="mu", directions=directions, name=f"foot {k}") for k in range(3)]
    return ns.System(n_q=7, n_u=6, kinematics=turning, mass=inertia, force=load, gap=above, tangent=of_feet,
                     contacts=feet, parameters=Stool(**parameters), name="stool")  # fmt: skip


STANDING, SPINNING = [0, 0, Stool().H, 1, 0, 0, 0], [0.8, 0.3, 0, 0, 0, 4.0]


def slid_stool(t_end):
    """x, y, angle and their rates of a stool that slides and spins, upright: normal forces from the balance of its
    weight and of the moments of friction, by an independent method."""
    p = Stool()

    def rate(t, x):
        c, s = math.cos(x[2]), math.sin(x[2])
        S = np.array([[c, -s], [s, c]]) @ (p.r * np.array([X, Y]))
        v = x[3:5, None] + x[5] * np.array([-S[1], S[0]])
        d = v / np.linalg.norm(v, axis=0)
        balance = np.array([np.ones(3), S[1] - p.H * p.mu * d[1], -S[0] + p.H * p.mu * d[0]])
        F = -p.mu * np.linalg.solve(balance, [p.m * p.g, 0, 0]) * d
        return np.concatenate([x[3:], F.sum(1) / p.m, [(S[0] * F[1] - S[1] * F[0]).sum() / p.J_3]])

    return solve_ivp(rate, (0, t_end), [0, 0, 0, 0.8, 0.3, 4.0], rtol=1e-12, atol=1e-13).y[:, -1]


def state_of_stool(sol):
    angle = 2 * math.atan2(sol.q[-1, 6], sol.q[-1, 3])
    return np.array([*sol.q[-1, :2], angle, *sol.u[-1, [0, 1, 5]]])


def spin_stool(dt, t_end=0.15, system=None, **options):
    return ns.simulate(system or of_stool(), (0, t_end), STANDING, SPINNING, integrator=ns.MoreauJean(dt=dt), **options)


def test_a_stool_that_slides_and_spins_is_of_second_order():
    end, errors = slid_stool(0.15), []
    for dt in (4e-3, 2e-3, 1e-3):
        sol = spin_stool(dt)
        errors.append(np.abs(state_of_stool(sol) - end).max())
        assert sol.stats.worst_residual < 1e-12
        assert (sol.mode == ns.ContactMode.SLIDE).all()
    assert errors[-1] < 1e-4
    np.testing.assert_allclose(order(errors), 2.0, atol=0.15)


def test_a_stool_is_the_same_as_that_of_a_scene():
    """Three spheres on a half-space, whose friction opposes the velocity at the end of a step: of first order, 5e-3 of
    the rates at 1e-3 s."""
    p, scene = Stool(), ns.Scene(gravity=(0, 0, -9.81))
    scene.fixed(ns.HalfSpace((0, 0, 1)), material=ns.Material(mu=p.mu))
    shape = ns.Compound(*((ns.Sphere(p.H), (p.r * x, p.r * y, 0)) for x, y in zip(X, Y, strict=True)))
    scene.body(shape, mass=p.m, inertia=np.diag([p.J_1, p.J_2, p.J_3]), position=(0, 0, p.H), velocity=(0.8, 0.3, 0),
               spin=(0, 0, 4.0), material=ns.Material(mu=p.mu))  # fmt: skip
    found = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(dt=1e-3))
    own = spin_stool(1e-3, t_end=1.0)
    place = found.position[:, 1] if found.position.shape[1] > 1 else found.position[:, 0]
    np.testing.assert_allclose(place[-1, :2], own.q[-1, :2], atol=2e-3)
    assert (own.u[-1] == 0.0).all()


def test_a_stool_comes_to_rest_and_stays():
    sol = spin_stool(1e-3, t_end=1.5)
    rest = sol.t > sol.t[np.flatnonzero(np.abs(sol.u).max(axis=1) > 0)[-1]]
    assert rest.sum() > 100
    assert (sol.q[rest] == sol.q[-1]).all() and (sol.mode[-1] == ns.ContactMode.STICK).all()
    energy = sol.ledger["kinetic"][-1] - sol.ledger["kinetic"][0]
    assert energy == pytest.approx(sol.ledger["friction"][-1], rel=1e-4)
    assert "foot 0" in sol.summary() and "slide" in sol.summary()


def test_the_interpreter_takes_the_same_steps(monkeypatch):
    compiled = spin_stool(5e-3, t_end=0.1)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    assert spin_stool(5e-3, t_end=0.1).q.tobytes() == compiled.q.tobytes()


@pytest.mark.upkeep
def test_checkpoints_files_and_sweeps_have_the_same_bits(tmp_path):
    whole = spin_stool(2e-3, t_end=0.4)
    with pytest.raises(ns.BudgetSpent):
        spin_stool(2e-3, t_end=0.4, checkpoint=tmp_path / "stool", max_steps=77)
    resumed = spin_stool(2e-3, t_end=0.4, resume=tmp_path / "stool")
    assert resumed.P_F.tobytes() == whole.P_F.tobytes()
    for ending in ("npz", "h5", "nc"):
        again = ns.Solution.load(whole.save(tmp_path / f"stool.{ending}"), of_stool())
        assert again.P_F.tobytes() == whole.P_F.tobytes() and again.summary() == whole.summary()
        assert np.array_equal(again.gamma_F, whole.gamma_F)
    assert whole.to_xarray().sizes["direction"] == 2
    task = ns.RunTask(of_stool(), t_span=(0, 0.4), state={"q0": STANDING, "u0": SPINNING},
                      integrator=ns.MoreauJean(dt=2e-3))  # fmt: skip
    found = ns.sweep(task, {"mu": [0.2, 0.35]}, progress=False)
    assert np.array_equal(found["q"].values[1], whole.q[-1])


def test_a_compliant_foot_sinks_in_by_its_weight():
    p = Stool()
    integrator = ns.MoreauJean(dt=1e-3, theta=1.0, compliance=ns.Compliance(stiffness=1e5, damping=100.0))
    sol = ns.simulate(of_stool(), (0, 1.0), STANDING, 6 * [0.0], integrator=integrator)
    np.testing.assert_allclose(sol.g_N[-1], -p.m * p.g / 3e5, rtol=1e-3)


def test_positions_are_moved_back_along_the_kinematics():
    integrator = ns.MoreauJean(dt=2e-3, projection=True)
    sol = ns.simulate(of_stool(), (0, 0.15), STANDING, SPINNING, integrator=integrator)
    assert np.abs(sol.g_N).max() < 1e-9
    np.testing.assert_allclose(state_of_stool(sol), slid_stool(0.15), atol=1e-3)


# One contact whose normal and tangential directions are coupled: Painlevé's rod in space.


class Tilted(NamedTuple):
    """A tip whose Delassus matrix has p = 1 - mu k d_x: coupling k of the normal with the direction x."""

    mu: float = 2.0
    k: float = 0.8
    g: float = 1.0
    press: float = 1.0
    pull: float = 0.0


def of_tip():
    def inertia(t, q, p, M):
        """M^-1 = G, in the coordinates N, T1, T2."""
        D = 1.0 - p.k * p.k
        M[0, 0], M[0, 1], M[1, 0], M[1, 1], M[2, 2] = 1.0 / D, -p.k / D, -p.k / D, 1.0 / D, 1.0

    def load(t, q, u, p, h):
        """h = M (b, a, 0), b = -press, a = pull."""
        D = 1.0 - p.k * p.k
        h[0], h[1] = (-p.press - p.k * p.pull) / D, (p.k * p.press + p.pull) / D

    def above(t, q, p, g_N):
        g_N[0] = q[0]

    def tangents(t, q, p, W_F):
        W_F[0, 0, 1], W_F[0, 1, 2] = 1.0, 1.0

    return ns.System(n_q=3, mass=inertia, force=load, gap=above, tangent=tangents, parameters=Tilted(),
                     contacts=[ns.Contact(mu="mu", directions=2)])  # fmt: skip


def test_a_slide_that_no_force_goes_with_ends_in_an_impact_without_collision():
    """Along +x p = 1 - mu k < 0 and b < 0; along y p = 1."""
    sol = run(of_tip(), 0.1, [0, 1.0, 0.0], 1e-3)
    assert [event.kind.name for event in sol.paradoxes[:1]] == ["INCONSISTENT"]
    assert sol.paradoxes[0].mode_after == ns.ContactMode.STICK
    assert not run(of_tip(), 0.01, [0, 0.0, 1.0], 1e-3).paradoxes


def test_several_solutions_are_counted_and_one_is_taken_by_the_rule():
    """b = 0.1, a = 0.5 at rest: it may lift off; stick, with P_N = (k a - b)/(1 - k^2) and |P_T| = (a - k b)/(1 - k^2)
    within the cone; or slide along x, where p < 0."""
    system = of_tip().with_parameters(press=-0.1, pull=0.5)
    lifted = run(system, 0.05, [0, 0, 0], 1e-3, selection="lift-off")
    stuck = run(system, 0.05, [0, 0, 0], 1e-3, selection="impact")
    assert lifted.q[-1, 0] > 0.0 and (stuck.q == 0.0).all()
    assert lifted.stats.indeterminate_steps >= 1 and stuck.stats.indeterminate_steps == 50
    assert stuck.paradoxes[0].n_solutions == 3


@pytest.mark.parametrize(("changes", "said"), [
    ({"directions": 3}, r"directions must be 1 \(planar friction\) or 2 \(spatial\); got 3"),
    ({"directions": True}, "directions must be 1"),
    ({"directions": 2, "mu": 0.0}, "directions=2 needs friction; give it mu > 0"),
    ({"directions": 2, "mu": -0.1}, "mu must not be negative"),
])  # fmt: skip
def test_a_contact_that_cannot_be_is_refused(changes, said):
    with pytest.raises(ns.InvalidInput, match=said):
        ns.Contact(**{"mu": 0.3} | changes)


def one_row(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0


def three_rows(t, q, p, W_F):
    W_F[0, 0, 0], W_F[0, 1, 1], W_F[0, 2, 2] = 1.0, 1.0, 1.0


@pytest.mark.parametrize(("changes", "said"), [
    ({"tangent": None}, "needs the function tangent"),
    ({"tangent": one_row}, r"tangent writes one row for contact 0, which has directions=2: write W_F\[0, 0, :\] and"),
    ({"tangent": three_rows}, r"tangent raised .* shape \(1, 2, 3\)"),
    ({"contacts": [ns.Contact(mu=0.3, directions=2, bilateral=True)]}, "two directions takes no bilateral contact"),
    ({"contacts": [ns.Contact(mu=0.3, directions=2, impact="sequential")]}, "takes Newton's law of impact, of one"),
    ({"parameters": Block(mu=-1.0)}, "mu must not be negative"),
])  # fmt: skip
def test_a_system_that_cannot_be_is_refused(changes, said):
    given = {"n_q": 3, "mass": mass, "force": weight, "gap": height, "tangent": along, "parameters": Block(),
             "contacts": [ns.Contact(mu="mu", directions=2)]}  # fmt: skip
    with pytest.raises(ns.InvalidInput, match=said):
        run(ns.System(**given | changes), 0.1, [0, 0, 0], 1e-2)


def test_contacts_that_exclude_each_other_end_the_run_with_their_problem(tmp_path):
    """Two walls close in on a particle from both sides."""

    def walls(t, q, p, g_N):
        g_N[0], g_N[1] = q[2] - t, 0.1 - t - q[2]

    def on_both(t, q, p, W_F):
        for k in range(2):
            W_F[k, 0, 0], W_F[k, 1, 1] = 1.0, 1.0

    system = ns.System(n_q=3, mass=mass, force=weight, gap=walls, tangent=on_both, parameters=Block(),
                       contacts=[ns.Contact(mu=0.3, directions=2), ns.Contact(mu=0.3, directions=2)])  # fmt: skip
    with pytest.raises(ns.StepFailure) as failure:
        run(system, 0.2, [0, 0, 1.0], 1e-3, q=(0, 0, 0.01))
    problem = failure.value.problem
    assert problem.kinds[:, 1].tolist() == [2, 2]
    assert problem.solve().status == ns.Status.NOT_SOLVED
    again = type(problem).load(problem.save(tmp_path / "problem.npz"))
    assert np.array_equal(again.G, problem.G)
    assert ns.read_fclib(problem.save(tmp_path / "problem.h5")).dim == 3
