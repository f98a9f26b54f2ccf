"""Seizures of the sprag-slip rod that starts where sliding has no force: what the integrators report of them.

SYSTEMS H: the bar stops against the belt at once, th' = vb / (l sin th), with the impulses of the frozen configuration.
"""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import SpragSlip
from nonsmooth import EventKind

SET_2 = SpragSlip()
STICKS_ON = (SpragSlip(mu=1.518707393289783), 0.50688406, 3.97546778)  # slides, seizes at 0.0471 s and sticks on
STICK_ENDS = 0.966466904  # rad: the greatest th at which the bar can stick (SYSTEMS H)


def random_starts(n):
    """States of A2 and A3."""
    rng = np.random.default_rng(45)
    states = rng.uniform((0.73, -4.0), (1.4, 4.0), size=(400, 2))
    return [(th, thdot) for th, thdot in states if int(SET_2.region(th, thdot)) in (2, 3)][:n]


def seizure(integrator, th, thdot, t_end):
    """The first paradox of a run from there."""
    solution = ns.simulate(SET_2, (0.0, t_end), *SET_2.state(th, thdot), integrator=integrator)
    return solution.paradoxes[0], solution


@pytest.mark.parametrize(("th", "thdot"), [(0.78, 1.0), *random_starts(6)])
def test_event_driven_seizure_is_the_impulse_map(th, thdot):
    event, solution = seizure(ns.EventDriven(), th, thdot, 1e-6)
    exact = SET_2.seizure(th, thdot)
    assert (event.t, event.contact, event.kind) == (0.0, 0, EventKind.INCONSISTENT)
    assert event.choice == (
        "stick" if th < STICK_ENDS else "slide -"
    )  # what follows the impact, which ends without slip
    assert event.n_solutions == 0 and event.alternatives == ()
    assert (event.P_N, event.P_F) == pytest.approx((exact.P_N, exact.P_F), rel=1e-9)
    # after the jump the bar moves for 1 us under accelerations below 1e3 / s^2
    assert solution.u[-1][1] == pytest.approx(SET_2.vb / (SET_2.l * math.sin(th)), abs=1e-3)


@pytest.mark.parametrize(("th", "thdot"), [(0.78, 1.0), *random_starts(6)])
def test_moreau_jean_seizure_tends_to_the_impulse_map_with_first_order(th, thdot):
    exact = SET_2.seizure(th, thdot)
    dts = np.array([1e-4, 1e-5, 1e-6])
    errors = []
    for dt in dts:
        event, _ = seizure(ns.MoreauJean(dt), th, thdot, 3 * dt)
        assert (event.t, event.contact, event.kind, event.choice) == (0.0, 0, EventKind.INCONSISTENT, "stick")
        errors.append(math.hypot(event.P_N - exact.P_N, event.P_F - exact.P_F))
    assert np.polyfit(np.log(dts), np.log(errors), 1)[0] == pytest.approx(1.0, abs=0.1)


def test_sticking_after_a_seizure_lasts():
    """Moreau–Jean sticks on as the event-driven motion does.

    The seizure is placed to one step, so th to |th'| dt, with |th'| < 4 rad/s before it.
    """
    model, *start = STICKS_ON
    exact = ns.simulate(model, (0.0, 0.1), *model.state(*start), integrator=ns.EventDriven(rtol=1e-10, atol=1e-12))
    for dt in (1e-3, 1e-4, 1e-5):
        solution = ns.simulate(model, (0.0, 0.1), *model.state(*start), integrator=ns.MoreauJean(dt))
        assert abs(solution.q[-1, 1] - exact.q[-1, 1]) < 4.0 * dt
        assert solution.mode[-1, 0] == exact.mode[-1, 0] == ns.ContactMode.STICK


def test_motion_between_the_records_begins_a_seizure_with_the_velocity_after_it():
    solution = ns.simulate(SET_2, (0.0, 3e-4), *SET_2.state(0.78, 1.0), integrator=ns.MoreauJean(1e-4))
    after = SET_2.vb / (SET_2.l * math.sin(0.78))
    assert solution(0.0, side="left").u[1] == 1.0 and abs(after - 1.0) > 0.1
    assert solution(1e-12).u[1] == pytest.approx(after, rel=1e-9)  # q holds it to rounding / dt
    assert np.abs(solution(solution.t).q - solution.q).max() < 1e-14
