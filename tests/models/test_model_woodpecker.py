"""Woodpecker toy: its equations against the small rotations they come from, its cycle by two integrators."""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns
from models import Woodpecker
from nonsmooth.integrators.records import EVENT_CONTACT, EVENT_KIND, EVENT_T, IMPACT
from nonsmooth.mechanics.system import FORCE, GAP, MASS, NORMAL, TANGENT

UNIT = np.eye(3)


def points(toy, q):
    """Centre of the woodpecker, then beak, lower and upper edge (4, 2), by small rotations phi (-r_y, r_x)."""
    y, phi_M, phi_S = q
    sleeve, joint = np.array([0.0, y]), np.array([toy.lM, y + toy.lM * phi_M])

    def at(origin, phi, r):
        return origin + np.array(r) + phi * np.array([-r[1], r[0]])

    centre = at(joint, phi_S, (toy.lG, 0.0))
    beak = at(centre, phi_S, (-toy.lS, toy.hS))
    return np.array([centre, beak, at(sleeve, phi_M, (toy.rM, -toy.hM)), at(sleeve, phi_M, (toy.rM, toy.hM))])


def test_gaps_rows_and_masses_are_those_of_the_points():
    toy, q, u = Woodpecker(), np.array([0.3, -0.05, 0.04]), np.zeros(3)
    system = toy.system()
    np.testing.assert_allclose(system.evaluate(GAP, 0.0, q, u), points(toy, q)[1:, 0] - toy.r0, atol=1e-17)
    J = np.stack([points(toy, q + e) - points(toy, q) for e in UNIT], axis=-1)  # the map is affine
    np.testing.assert_allclose(system.evaluate(NORMAL, 0.0, q, u), J[1:, 0], atol=1e-16)
    np.testing.assert_allclose(system.evaluate(TANGENT, 0.0, q, u)[:, 0], J[1:, 1], atol=1e-16)
    up = J[0, 1]  # the woodpecker's centre moves up only, see the assumptions
    M = toy.mS * np.outer(up, up) + np.diag([toy.mM, toy.JM, toy.JS])
    np.testing.assert_allclose(system.evaluate(MASS, 0.0, q, u), M, rtol=1e-13, atol=1e-20)


def test_toy_hangs_where_the_forces_balance():
    toy = Woodpecker()
    q0, u0 = toy.state(phi_S=toy.hanging_angle(), ydot=0.0, phi_Sdot=0.0)
    system = toy.system()
    h, W_N, W_F = (system.evaluate(which, 0.0, q0, u0) for which in (FORCE, NORMAL, TANGENT))
    forces = np.linalg.lstsq(np.column_stack([W_N[1], W_F[1, 0]]), -h, rcond=None)[0]
    np.testing.assert_allclose(np.column_stack([W_N[1], W_F[1, 0]]) @ forces, -h, atol=1e-16)
    assert forces[1] / forces[0] == pytest.approx(toy.jamming_friction(), rel=1e-12)


@pytest.mark.parametrize(("mu", "hangs"), [(0.29, True), (0.28, False)])
def test_sleeve_holds_above_the_jamming_friction_only(mu, hangs):
    toy = Woodpecker(mu=mu)
    q0, u0 = toy.state(phi_S=toy.hanging_angle(), ydot=0.0, phi_Sdot=0.0)
    solution = ns.simulate(toy, (0, 0.05), q0, u0, integrator=ns.EventDriven())
    assert (abs(solution.q[-1, 0]) < 1e-14) == hangs


def cycles(toy, t_end, integrator):
    """Times of the strokes of the beak, and the solution."""
    solution = ns.simulate(toy, (0, t_end), *toy.state(), integrator=integrator)
    rows = solution.event_rows
    return rows[(rows[:, EVENT_KIND] == IMPACT) & (rows[:, EVENT_CONTACT] == 0), EVENT_T], solution


def test_printed_state_lies_on_the_limit_cycle_that_attracts():
    toy = Woodpecker()
    strokes, _ = cycles(toy, 4.0, ns.EventDriven())
    periods = np.diff(strokes)
    assert len(periods) > 20
    late = periods[-6:]
    assert np.ptp(late) < 0.2 * np.ptp(periods[:6]) and abs(periods[0] - late.mean()) < 2e-3 * late.mean()


def test_each_cycle_has_a_stroke_of_the_beak_a_slide_and_a_stick():
    strokes, solution = cycles(Woodpecker(), 1.0, ns.EventDriven())
    sticks = [e for e in solution.events if e.contact == 1 and e.mode_after == ns.ContactMode.STICK]
    assert abs(len(sticks) - len(strokes)) <= 1 and len(strokes) == 7
    assert solution.q[-1, 0] < -0.1  # it climbs down


def test_time_steps_converge_to_the_event_driven_motion_with_order_one():
    toy = Woodpecker()
    _, exact = cycles(toy, 0.3, ns.EventDriven(rtol=1e-11, atol=1e-13))
    errors = []
    for dt in (1e-4, 1e-5, 1e-6):
        _, solution = cycles(toy, 0.3, ns.MoreauJean(dt))
        errors.append(np.abs(solution.q[-1] - exact.q[-1]).max())
    # a mean over two decades: an event falls anywhere in its step
    assert np.log10(errors[0] / errors[-1]) / 2 == pytest.approx(1.0, abs=0.35) and errors[-1] < 1e-3


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_event_driven_error_follows_the_tolerance(rtol):
    toy = Woodpecker()
    _, exact = cycles(toy, 0.6, ns.EventDriven(rtol=1e-12, atol=1e-14))
    _, solution = cycles(toy, 0.6, ns.EventDriven(rtol=rtol, atol=rtol / 100))
    np.testing.assert_allclose(solution.q[-1], exact.q[-1], atol=rtol)


def test_energy_lost_is_the_work_of_the_contacts():
    _, solution = cycles(Woodpecker(), 0.6, ns.EventDriven(rtol=1e-10, atol=1e-13))
    ledger = solution.ledger
    energy = ledger["kinetic"] + ledger["potential"]
    lost = energy[0] - energy[-1]
    assert lost == pytest.approx(-(ledger["friction"][-1] + ledger["normal"][-1]), rel=1e-8) and lost > 0
