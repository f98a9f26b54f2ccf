"""EventDriven of bodies that turn and of several contacts in space: closed forms and integrations apart."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from models import BilliardBall
from nonsmooth.mechanics.system import FORCE, GAP, KINEMATICS, MASS, NORMAL, ROW_RATES, TANGENT

G = 9.81
FINE = ns.EventDriven(rtol=1e-11, atol=1e-13)
OPEN, STICK, SLIDE = ns.ContactMode.OPEN, ns.ContactMode.STICK, ns.ContactMode.SLIDE
SIZES, MASS_OF_BOX = (0.4, 0.3, 0.2), 2.0


def on_floor(shape, mu=0.3, e=0.0, slope=0.0, **body):
    """The system of one body on a floor, which falls off towards x, and its start."""
    scene = ns.Scene(gravity=(G * math.sin(slope), 0, -G * math.cos(slope)), material=ns.Material(mu=mu, e=e))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="floor")
    scene.body(shape, mass=MASS_OF_BOX, name="body", **body)
    return scene.system(), scene.state()


def box(**given):
    return on_floor(ns.Box(*SIZES), **({"position": (0, 0, SIZES[2] / 2)} | given))


def energy(system, q, u):
    heights = np.reshape(q, (-1, 7))[:, 2]
    M = system.evaluate(MASS, 0.0, q, u)
    return 0.5 * u @ M @ u + G * (np.diag(M)[2::6] * heights).sum()


def test_a_free_symmetric_body_precesses_about_its_angular_momentum():
    A, C, tilt, rate = 0.02, 0.03, 0.4, 5.0

    def mass(t, q, p, M):
        M[0, 0], M[1, 1], M[2, 2] = A, A, C

    def force(t, q, u, p, h):
        h[0], h[1] = (A - C) * u[1] * u[2], (C - A) * u[2] * u[0]

    def kinematics(t, q, p, B):
        w, x, y, z = q[0] / 2, q[1] / 2, q[2] / 2, q[3] / 2
        B[0, 0], B[0, 1], B[0, 2] = -x, -y, -z
        B[1, 0], B[1, 1], B[1, 2] = w, -z, y
        B[2, 0], B[2, 1], B[2, 2] = z, w, -x
        B[3, 0], B[3, 1], B[3, 2] = -y, x, w

    body = ns.System(n_q=4, n_u=3, mass=mass, force=force, kinematics=kinematics)
    q0 = np.array([math.cos(tilt / 2), math.sin(tilt / 2), 0.0, 0.0])  # the axis is tilted from the vertical L
    u0 = rate * np.array([0.0, math.sin(tilt) / A, math.cos(tilt) / C]) * A  # L = A rate along z
    sol = ns.simulate(body, (0, 2), q0, u0, integrator=FINE)

    def axis(q):
        w, x, y, z = q
        return np.array([2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z])

    exact = np.array([math.sin(tilt) * math.sin(rate * 2), -math.sin(tilt) * math.cos(rate * 2), math.cos(tilt)])
    np.testing.assert_allclose(axis(sol.q[-1]), exact, atol=1e-9)
    between = sol(1.2345).q  # the cubic between two steps
    turned = rate * 1.2345
    expected = [math.sin(tilt) * math.sin(turned), -math.sin(tilt) * math.cos(turned), math.cos(tilt)]
    np.testing.assert_allclose(axis(between), expected, atol=1e-9)
    assert np.linalg.norm(sol.q[-1]) == pytest.approx(1.0, abs=1e-9)
    assert ns.simulate(body, (0, 2), q0, u0).about["integrator"].startswith("EventDriven")


def test_a_billiard_ball_slides_along_its_parabola_and_rolls():
    ball = BilliardBall()
    q, u = ball.state()
    sol = ns.simulate(ball, (0, 1), q, u, integrator=FINE)
    (event,) = sol.events
    stop = ball.rolling_time(u)
    assert event.t == pytest.approx(stop, rel=1e-9) and (event.mode_before, event.mode_after) == (SLIDE, STICK)
    for t in (0.4 * stop, stop, 1.0):
        np.testing.assert_allclose(sol(t).q[:2], ball.path(t, u), atol=1e-9)
    np.testing.assert_allclose(sol.u[-1, :2], ball.rolling_velocity(u), atol=1e-12)


def test_a_box_slides_to_rest_on_its_four_corners():
    system, (q, u) = box(velocity=(1.0, 0.3, 0.0))
    sol = ns.simulate(system, (0, 0.5), q, u, integrator=FINE)
    speed, braking = math.hypot(1.0, 0.3), 0.3 * G
    assert {event.mode_after for event in sol.events} == {STICK}
    assert sol.events[0].t == pytest.approx(speed / braking, rel=1e-9)
    np.testing.assert_allclose(sol.q[-1, :2], speed / (2 * braking) * np.array([1.0, 0.3]), atol=1e-10)
    assert not sol.u[-1].any() and sol.stats.uncounted >= 1


def test_a_box_that_spins_on_its_corners_is_braked_by_their_equal_loads():
    system, (q, u) = box(spin=(0, 0, 3.0))
    sol = ns.simulate(system, (0, 0.2), q, u, integrator=FINE)
    moment = MASS_OF_BOX / 12 * (SIZES[0] ** 2 + SIZES[1] ** 2)
    stop = moment * 3.0 / (0.3 * MASS_OF_BOX * G * math.hypot(*SIZES[:2]) / 2)
    assert sol.events[0].t == pytest.approx(stop, rel=1e-8)
    assert 2 * math.atan2(sol.q[-1, 6], sol.q[-1, 3]) == pytest.approx(1.5 * stop, rel=1e-8)


@pytest.mark.parametrize("slope", [0.29, 0.31])
def test_a_box_on_a_slope_rests_below_the_angle_of_friction_and_slides_above(slope):
    system, (q, u) = box(slope=slope, mu=math.tan(0.3))
    sol = ns.simulate(system, (0, 2), q, u, integrator=FINE)
    a = G * (math.sin(slope) - math.tan(0.3) * math.cos(slope)) if slope > 0.3 else 0.0
    np.testing.assert_allclose(sol.q[-1, :3] - q[:3], [2 * a, 0, 0], atol=1e-9)
    loads = sol.la[-1, :, 0]
    assert loads.sum() == pytest.approx(MASS_OF_BOX * G * math.cos(slope), rel=1e-12) and loads.min() >= 0
    # the friction of each is within its cone, to the compliance of a millionth
    part = np.linalg.norm(sol.la[-1, loads > 0, 1:], axis=1) / (math.tan(0.3) * loads[loads > 0])
    assert part.max() < 1 + 1e-6
    # the friction, at the floor, tips the weight towards the lower corners: N_low/N_high of the two edges
    tips = math.tan(min(slope, 0.3)) * SIZES[2] / SIZES[0]
    low = system.evaluate(GAP, 0.0, q, u) < 1e-9
    downhill = np.argsort(loads)[-2:]
    assert loads[downhill].sum() == pytest.approx((0.5 + tips / 2) * loads.sum(), rel=1e-9) and low.sum() == 4


# a tripod, whose three feet are not redundant
TRIPOD = ns.Polyhedron([(0.2, 0, 0), (-0.1, 0.17, 0), (-0.1, -0.17, 0), (0, 0, 0.15)])


def slide_apart(system, q, u, mu, t_end):
    """Three feet that slide, by DOP853 with rows and rates of the system and a solver of linear equations."""
    feet = np.flatnonzero(system.evaluate(GAP, 0.0, q, u) < 1e-9)

    def rates(t, x):
        q, u = x[:7], x[7:]
        M, h, W_N, W_F, r, B = (
            system.evaluate(which, t, q, u) for which in (MASS, FORCE, NORMAL, TANGENT, ROW_RATES, KINEMATICS)
        )
        W_N, W_F, r = W_N[feet], W_F[feet], r[feet, 0]
        slip = W_F @ u
        d = slip / np.linalg.norm(slip, axis=1, keepdims=True)
        pushes = np.linalg.solve(M, (W_N - mu * np.einsum("ca,caj->cj", d, W_F)).T)
        free = np.linalg.solve(M, h)
        la = np.linalg.solve(W_N @ pushes, -(W_N @ free + r))
        assert (la > 0).all()
        return np.concatenate([B @ u, free + pushes @ la])

    return solve_ivp(rates, (0, t_end), np.concatenate([q, u]), "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]


def test_three_feet_that_slide_and_turn_go_as_an_integration_of_their_own():
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.4))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="floor")
    scene.body(TRIPOD, mass=1.3, name="tripod", position=(0, 0, 0.15 / 4), velocity=(0.9, 0.2, 0), spin=(0, 0, 4.0))
    system, (q, u) = scene.system(), scene.state()
    q[2] -= system.evaluate(GAP, 0.0, q, u).min()
    sol = ns.simulate(system, (0, 0.2), q, u, integrator=FINE)
    assert not len(sol.events) and (sol.mode[-1] == SLIDE).sum() == 3
    apart = slide_apart(system, q, u, 0.4, 0.2)
    np.testing.assert_allclose(np.concatenate([sol.q[-1], sol.u[-1]]), apart, atol=1e-9)


TUMBLING = {"position": (0, 0, 0.16), "turn": (math.cos(0.1), 0.6 * math.sin(0.1), 0.8 * math.sin(0.1), 0),
            "spin": (1.0, 2.0, 0.5), "velocity": (0.8, 0.1, 0)}  # fmt: skip


@cache
def tumbled(rtol, e=0.0):
    system, (q, u) = box(e=e, **TUMBLING)
    return ns.simulate(system, (0, 0.4), q, u, integrator=ns.EventDriven(rtol=rtol, atol=1e-2 * rtol))


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")
@pytest.mark.parametrize("e", [0.0, 0.4])
def test_a_box_that_lands_corner_by_corner_comes_to_rest_with_its_energy_booked(e):
    coarse, fine = tumbled(1e-8, e), tumbled(1e-11, e)
    system, _ = box(e=e, **TUMBLING)
    works = sum(fine.ledger[name] for name in ("friction", "normal", "surface"))
    kept = np.array([energy(system, q, u) for q, u in zip(fine.q, fine.u, strict=True)]) - works
    np.testing.assert_allclose(kept, kept[0], atol=1e-9)
    np.testing.assert_allclose(coarse.q[-1], fine.q[-1], atol=1e-6)
    assert (fine.mode[-1] == STICK).sum() == 4 and not fine.u[-1].any() and fine.stats.worst_penetration < 1e-12


def test_steps_of_moreau_jean_tend_to_it_where_three_feet_land():
    """Three feet have one share of the load; four may brake a spin by any."""
    system, (q, u) = on_floor(TRIPOD, **(TUMBLING | {"position": (0, 0, 0.1)}))
    sol, errors = ns.simulate(system, (0, 0.4), q, u, integrator=FINE), []
    for dt in (4e-4, 1e-4, 2.5e-5):
        steps = ns.simulate(system, (0, 0.4), q, u, integrator=ns.MoreauJean(dt))
        errors.append(np.abs(steps.q[-1] - sol.q[-1]).max())
    assert (sol.mode[-1] == STICK).sum() == 3 and len(sol.events) > 6
    assert errors[2] < 2e-4 and errors[2] < errors[0] / 6  # first order at landings


def test_a_ball_that_hits_another_on_a_table_strikes_it_and_is_lifted():
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.2, e=0.0))
    ivory = ns.Material(mu=0.2, e=0.9, name="ivory")
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="table", material=ns.Material(mu=0.2, name="felt"))
    scene.pair("felt", "ivory", mu=0.2, e=0.0)
    scene.body(ns.Sphere(0.03), mass=0.17, position=(0, 0, 0.03), velocity=(1, 0, 0), name="cue", material=ivory)
    scene.body(ns.Sphere(0.03), mass=0.17, position=(0.3, 0.02, 0.03), name="ball", material=ivory)
    system, (q, u) = scene.system(), scene.state()
    with pytest.warns(ns.SimultaneousImpactWarning, match="one answer of many: e_N = 0 has no rebound, and impact='n"):
        sol = ns.simulate(system, (0, 1), q, u, integrator=FINE)
    roll, hit = sol.events[0], next(event for event in sol.events if event.kind == ns.EventKind.IMPACT)
    assert roll.t == pytest.approx(1.0 / (3.5 * 0.2 * G), rel=1e-9)  # u_0 / (7/2 mu g)
    rolled = 5 / 7 * (hit.t - roll.t) + (1 - (2 / 7) / 2) * roll.t  # the mean of 1 and 5/7 while it slides
    assert rolled == pytest.approx(0.3 - math.sqrt(0.06**2 - 0.02**2), rel=1e-9)
    at = np.flatnonzero(sol.t == hit.t)
    before, after = sol.u[at[0]].reshape(2, 6)[:, :3], sol.u[at[-1]].reshape(2, 6)[:, :3]
    n = np.array([math.sqrt(0.06**2 - 0.02**2), 0.02, 0]) / 0.06
    assert (after[1] - after[0]) @ n == pytest.approx(0.9 * (before[0] - before[1]) @ n, rel=1e-9)


def lost_plate(slope=math.pi / 3):
    """A plate on its lower edge that is pushed with mu = 2: both corners slide where no force fits."""
    half = (0.5, 0.1, 1e-6)
    turn = (math.cos(-slope / 2), 0, math.sin(-slope / 2), 0)
    return on_floor(ns.Box(2 * half[0], 2 * half[1], 2 * half[2]), mu=2.0, turn=turn, velocity=(-1.0, 0.0, 0.0),
                    position=(0, 0, half[0] * math.sin(slope) + half[2] * math.cos(slope)))  # fmt: skip


def test_two_coupled_corners_that_slide_without_force_are_stopped_together():
    """The impact without collision of the plane, P_F/P_N inside the cone: the edge stops, and sticks."""
    system, (q, u) = lost_plate()
    q[2] -= system.evaluate(GAP, 0.0, q, u).min()
    sol = ns.simulate(system, (0, 1e-3), q, u, integrator=FINE)
    lost = [event for event in sol.events if event.kind == ns.EventKind.INCONSISTENT]
    assert len(lost) == 2 and lost[0].t == lost[1].t == 0.0 and lost[0].P_N == pytest.approx(lost[1].P_N, rel=1e-6)
    # of a slender rod of half length 1/2: all of the velocity of its lower end goes
    after = sol.u[np.flatnonzero(sol.t == 0.0)[-1]]
    corners = np.argsort(system.evaluate(GAP, 0.0, q, u))[:2]
    slip = system.evaluate(TANGENT, 0.0, q, after)[corners] @ after
    np.testing.assert_allclose(slip, 0.0, atol=1e-8)
    np.testing.assert_allclose(system.evaluate(NORMAL, 0.0, q, after)[corners] @ after, 0.0, atol=1e-8)
    M, W = system.evaluate(MASS, 0.0, q, u), np.zeros((2, 6))  # rows of the middle of the edge, in the plane
    W[0] = system.evaluate(NORMAL, 0.0, q, u)[corners].mean(axis=0)
    W[1] = system.evaluate(TANGENT, 0.0, q, u)[corners, 0].mean(axis=0)
    P_N, P_F = -np.linalg.solve(W @ np.linalg.solve(M, W.T), W @ u)
    assert sum(event.P_N for event in lost) == pytest.approx(P_N, rel=1e-6)
    assert sum(event.P_F for event in lost) == pytest.approx(abs(P_F), rel=1e-6) and abs(P_F) < 2 * P_N
