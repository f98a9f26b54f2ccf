"""EventDriven with friction in two directions: closed forms, an integration apart, and the way into the paradox."""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from models import RobotFinger, SpatialPainleveRod
from nonsmooth.mechanics.system import FORCE, GAP, MASS, NORMAL, ROW_RATES, TANGENT

FINE = ns.EventDriven(rtol=1e-11, atol=1e-13)
OPEN, STICK, SLIDE = ns.ContactMode.OPEN, ns.ContactMode.STICK, ns.ContactMode.SLIDE


class Sprung(NamedTuple):
    """A mass on springs, on a belt that runs obliquely."""

    m: float = 1.3  # [kg]
    k: float = 0.0  # [N/m]
    g: float = 9.81  # [m/s^2]
    mu: float = 0.3
    e: float = 0.0
    vx: float = 0.3  # of the belt [m/s]
    vy: float = 0.4  # [m/s]


def mass(t, q, p, M):
    M[0, 0] = M[1, 1] = M[2, 2] = p.m


def force(t, q, u, p, h):
    h[0], h[1], h[2] = -p.k * q[0], -p.k * q[1], -p.m * p.g


def gap(t, q, p, g_N):
    g_N[0] = q[2]


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = W_F[0, 1, 1] = 1.0


def between(t, q, p, g_N):
    g_N[0], g_N[1] = q[2], 0.1 - q[2]


def on_both(t, q, p, W_F):
    W_F[0, 0, 0] = W_F[0, 1, 1] = W_F[1, 0, 0] = W_F[1, 1, 1] = 1.0


def load(t, q, u, p, N):
    N[1] = 2.0


def surface_velocity(t, q, p, w_F):
    w_F[0, 0], w_F[0, 1] = -p.vx, -p.vy


def sprung(mu="mu", **changes):
    contacts = [ns.Contact(mu=mu, e_N="e", directions=2)]
    return ns.System(
        n_q=3, mass=mass, force=force, gap=gap, tangent=tangent, surface_velocity=surface_velocity, contacts=contacts,
        parameters=Sprung(**changes),
    )  # fmt: skip


def test_a_block_that_is_thrown_on_a_belt_slides_straight_to_rest_on_it():
    p, v = Sprung(), np.array([-0.5, 1.2])
    sol = ns.simulate(sprung(), (0, 1), np.zeros(3), [*v, 0.0], integrator=FINE)
    belt = np.array([p.vx, p.vy])
    slip = np.linalg.norm(v - belt)
    stop = slip / (p.mu * p.g)
    (event,) = sol.events
    assert event.t == pytest.approx(stop, rel=1e-9) and (event.mode_before, event.mode_after) == (SLIDE, STICK)
    np.testing.assert_allclose(sol.q[-1, :2], belt + (v - belt) / 2 * stop, atol=1e-10)
    np.testing.assert_allclose(sol.u[-1], [*belt, 0.0], atol=1e-14)
    after = sol.t > stop
    np.testing.assert_allclose(sol.u[after, :2], belt + np.zeros((after.sum(), 2)), atol=1e-14)
    lost = -p.m * slip**2 / 2  # what is lost seen from the belt
    assert sol.ledger["friction"][-1] == pytest.approx(lost, rel=1e-9)


def test_what_the_belt_carries_along_is_released_where_its_spring_takes_the_friction():
    p = Sprung(k=20.0)
    sol = ns.simulate(sprung(k=20.0), (0, 0.6), np.zeros(3), [p.vx, p.vy, 0.0], integrator=FINE)
    released = sol.events[0]
    assert (released.mode_before, released.mode_after) == (STICK, SLIDE)
    assert released.t == pytest.approx(p.mu * p.m * p.g / (p.k * 0.5), rel=1e-9)
    after = sol.q[-1] / np.linalg.norm(sol.q[-1])
    np.testing.assert_allclose(after, [0.6, 0.8, 0.0], atol=1e-9)  # along the belt


@pytest.mark.parametrize("th_phi", [(1.0, 0.7), (0.6, -2.0), (1.3, 2.8)])
def test_a_slide_that_turns_is_the_one_of_an_integration_of_its_own(th_phi):
    rod = SpatialPainleveRod(mu=0.3)
    q, u = rod.state(*th_phi, psidot=2.0, thdot=-0.3, slip=2.0)
    sol = ns.simulate(rod, (0, 0.15), q, u, integrator=FINE)
    end, slowest = sliding_without_kinematics(rod, q, u, 0.15)
    assert slowest > 0.1 and (sol.mode == SLIDE).all()
    np.testing.assert_allclose(np.concatenate([sol.q[-1], sol.u[-1]]), end, atol=1e-9)
    states = zip(sol.q, sol.u, strict=True)
    energy = [0.5 * u @ rod.system().evaluate(MASS, 0.0, q, u) @ u + rod.m * rod.g * q[2] for q, u in states]
    np.testing.assert_allclose(np.diff(energy), np.diff(sol.ledger["friction"]), atol=1e-9)


def rates_of(rod, y):
    """(free acceleration, that by a unit normal force with its friction, p, b) of a slide."""
    system, q, u = rod.system(), y[:5], y[5:]
    M, h, W_N, W_F, r = (system.evaluate(which, 0.0, q, u) for which in (MASS, FORCE, NORMAL, TANGENT, ROW_RATES))
    slip = W_F[0] @ u
    free, pushed = np.linalg.solve(M, np.column_stack([h, W_N[0] - rod.mu * slip @ W_F[0] / np.hypot(*slip)])).T
    return free, pushed, W_N[0] @ pushed, W_N[0] @ free + r[0, 0]


def sliding_without_kinematics(rod, q, u, t_end):
    def rates(t, y):
        free, pushed, p, b = rates_of(rod, y)
        return np.concatenate([y[5:], free - pushed * b / p])

    y = solve_ivp(rates, (0, t_end), np.concatenate([q, u]), method="DOP853", rtol=1e-12, atol=1e-14).y.T
    slips = [np.hypot(*(rod.system().evaluate(TANGENT, 0.0, x[:5], x[5:])[0] @ x[5:])) for x in y]
    return y[-1], min(slips)


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_where_no_force_fits_the_slide_ends_by_the_impact_without_collision(law):
    rod, state = SpatialPainleveRod(mu=2.0, e=0.6), {"th": 1.0, "phi": 0.5, "thdot": 0.4, "psidot": -2.0, "slip": 0.8}
    (contact,) = rod.system().contacts
    system = dataclasses.replace(rod.system(), contacts=[dataclasses.replace(contact, impact=law)])
    sol = ns.simulate(system, (0, 1e-3), *rod.state(**state), integrator=FINE)
    expected, event = rod.impact_without_collision(**state, law=law), sol.events[0]
    assert event.kind == ns.EventKind.INCONSISTENT and event.t == 0.0
    np.testing.assert_allclose(sol.u[1], expected.u, atol=1e-12)
    assert event.P_N == pytest.approx(expected.P_N) and event.P_F == pytest.approx(np.linalg.norm(expected.P_F))
    assert event.mode_after == (STICK if law == "newton" else OPEN)


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_a_slide_that_turns_past_rest_goes_on_after_the_impact_that_is_classified(law):
    finger, state = RobotFinger(mu=2.5, e=0.5), {"th2": -1.27, "phi": -0.94, "slip": 0.5}
    system = finger.system()
    system = dataclasses.replace(system, contacts=[dataclasses.replace(system.contacts[0], impact=law)])
    sol = ns.simulate(system, (0, 1e-4), *finger.state(**state), integrator=FINE)
    (listed,) = [x for x in ns.classify(finger, state=state).impacts if x.law.name.lower() == law]
    event = sol.events[0]
    assert event.kind == ns.EventKind.INCONSISTENT and event.mode_after == (SLIDE if law == "newton" else OPEN)
    np.testing.assert_allclose(sol.u[1], listed.u, atol=1e-12)
    assert event.P_N == pytest.approx(listed.P_N[0]) and np.linalg.norm(listed.gamma_F[0]) > 0.01


def test_in_space_a_slide_turns_into_the_paradox_and_its_force_grows_without_bound():
    """With dt = p ds the rates stay finite at p = 0: free p - b pushed. The slide passes it with b < 0, la_N ~ 1/sqrt.

    In the plane p = 0 is passed with b = 0 alone.
    """
    rod = SpatialPainleveRod(mu=2.0)
    start = rod.state(th=1.0, phi=1.2, psidot=4.0, slip=3.0)

    def rates(s, y):
        free, pushed, p, b = rates_of(rod, y[:-1])
        return np.concatenate([p * y[5:10], p * free - b * pushed, [p]])

    def p_of(s, y):
        return rates_of(rod, y[:-1])[2]

    p_of.terminal = True
    path = solve_ivp(rates, (0, 1), [*start[0], *start[1], 0.0], method="DOP853", rtol=1e-12, atol=1e-14, events=p_of)
    there, moment = path.y[:10, -1], path.y[10, -1]
    _, _, p, b = rates_of(rod, there)
    assert abs(p) < 1e-12 and b < -9.0
    sol = ns.simulate(rod, (0, 0.02), *start, integrator=FINE)
    (event,) = sol.events
    assert event.kind == ns.EventKind.INCONSISTENT and event.mode_after == STICK
    assert event.t == pytest.approx(moment, rel=1e-9)
    th, psi, slip = there[3], there[4], rod.system().evaluate(TANGENT, 0.0, there[:5], there[5:])[0] @ there[5:]
    phi = math.remainder(math.atan2(-slip[1], -slip[0]) - psi, 2 * math.pi)
    G, d, left = rod.delassus(th), -np.array([math.cos(phi), math.sin(phi)]), np.array([math.sin(phi), -math.cos(phi)])
    turns = (G[0, 1:] @ left) * ((G[1:, 0] - rod.mu * G[1:, 1:] @ d) @ left)
    y, rate = path.y[:, -1], 1e-6 * rates(0, path.y[:, -1])
    slope = (p_of(0, y + rate) - p_of(0, y - rate)) / 2e-6
    assert slope == pytest.approx(rod.mu * b / np.hypot(*slip) * turns, rel=1e-7) and slope < 0
    assert rod.rate_of_p(th, phi, there[8], there[9], np.hypot(*slip)) == pytest.approx(slope, rel=1e-7)
    impact = rod.impact_without_collision(th, phi - 1e-9, there[8], there[9], np.hypot(*slip))
    after = np.flatnonzero(sol.t == event.t)[-1]
    h, across = np.array([math.cos(psi), math.sin(psi)]), np.array([-math.sin(psi), math.cos(psi)])
    np.testing.assert_allclose(sol.u[after, 3:], impact.u[3:], atol=2e-8)
    np.testing.assert_allclose([sol.u[after, :2] @ h, sol.u[after, :2] @ across], impact.u[:2], atol=2e-8)
    until = event.t - sol.t
    near = (until > 1e-12) & (until < 1e-7)
    square = [rates_of(rod, np.concatenate(state))[2] ** 2 for state in zip(sol.q[near], sol.u[near], strict=True)]
    np.testing.assert_allclose(square / until[near], square[0] / until[near][0], rtol=5e-3)
    assert near.sum() > 5


def test_bounces_take_from_the_slide_what_their_impulses_allow_until_they_end():
    """Falling from h with e: the series ends at t_1 (1 + e)/(1 - e), after an impulse m g t in all."""
    p, h = Sprung(vx=0.0, vy=0.0, e=0.5), 0.02
    sol = ns.simulate(sprung(vx=0.0, vy=0.0, e=0.5), (0, 0.6), [0, 0, h], [1.2, 1.6, 0.0], integrator=FINE)
    t_inf = math.sqrt(2 * h / p.g) * 3.0
    closed = next(event for event in sol.events if event.mode_after == SLIDE)
    assert closed.t == pytest.approx(t_inf, abs=1e-6)
    speed = 2.0 - p.mu * p.g * 0.6
    np.testing.assert_allclose(sol.u[-1], [0.6 * speed, 0.8 * speed, 0.0], atol=1e-9)
    assert abs(sol.q[-1, 2]) < 1e-20


@pytest.mark.parametrize("e", [0.0, 0.5])
def test_a_rod_that_lands_is_struck_as_the_exact_cone_says(e):
    rod = SpatialPainleveRod(mu=0.3, e=e)
    q, u = rod.state(th=1.0, phi=0.7, psidot=2.0, slip=2.0)
    q[2] += 0.05
    sol = ns.simulate(rod, (0, 0.15), q, u, integrator=FINE)
    event, system = sol.events[0], rod.system()
    k = int(np.flatnonzero(np.diff(sol.t) == 0)[0])  # the rows before and after
    q, before, after = sol.q[k], sol.u[k], sol.u[k + 1]
    rows = np.vstack([system.evaluate(NORMAL, 0.0, q, before), system.evaluate(TANGENT, 0.0, q, before)[0]])
    M = system.evaluate(MASS, 0.0, q, before)
    G, gamma = rows @ np.linalg.solve(M, rows.T), rows @ before
    assert abs(system.evaluate(GAP, 0.0, q, before)[0]) < 1e-13
    (P,) = ns.contact_solutions(G, gamma + [e * gamma[0], 0, 0], rod.mu).P
    np.testing.assert_allclose(after - before, np.linalg.solve(M, rows.T @ P), atol=1e-11)
    assert event.kind == ns.EventKind.IMPACT and event.P_N == pytest.approx(P[0])
    assert event.mode_after == (SLIDE if e == 0 else OPEN)


def test_steps_of_moreau_jean_tend_to_it_where_a_finger_stops_and_sticks():
    finger = RobotFinger(mu=0.5).with_torques(RobotFinger().torques_that_press((1.0, 0.0, 0.4), -1.2))
    q, u = finger.state(slip=0.05, phi=1.0)
    sol = ns.simulate(finger, (0, 0.01), q, u, integrator=FINE)
    errors = [
        np.abs(ns.simulate(finger, (0, 0.01), q, u, integrator=ns.MoreauJean(dt=dt)).q[-1] - sol.q[-1]).max()
        for dt in (2e-5, 5e-6)
    ]
    assert sol.mode[-1, 0] == STICK and errors[1] < 1e-8 and errors[1] < 0.4 * errors[0]


def test_of_two_answers_the_rod_takes_lift_off_and_says_so():
    rod = SpatialPainleveRod(mu=2.0)
    sol = ns.simulate(rod, (0, 0.01), *rod.state(th=math.pi / 3, phi=0.4, psidot=12.0), integrator=FINE)
    assert sol.events[0].kind == ns.EventKind.INDETERMINATE and sol.events[0].n_solutions == 2
    assert (sol.mode[1:] == OPEN).all()


def test_what_is_not_followed_from_event_to_event_is_refused():
    rod = SpatialPainleveRod(mu=0.3)
    with pytest.raises(ns.InvalidInput, match="compliant-limit"):
        ns.simulate(rod, (0, 1), *rod.state(), integrator=FINE, selection="impact")
    system = sprung()
    given = ns.Contact(mu=0.3, directions=2, normal_force=True)
    with pytest.raises(ns.InvalidInput, match="unilateral contacts with friction in two directions or none, and no"):
        two = dataclasses.replace(
            system, contacts=[system.contacts[0], given], gap=between, tangent=on_both, normal_force=load
        )
        ns.simulate(two, (0, 1), np.zeros(3), np.zeros(3), integrator=FINE)
    with pytest.raises(ns.InvalidInput, match="e_F"):
        ns.simulate(
            dataclasses.replace(system, contacts=[ns.Contact(mu=0.3, e_F=0.5, directions=2)]), (0, 1), np.zeros(3),
            np.zeros(3), integrator=FINE,
        )  # fmt: skip
