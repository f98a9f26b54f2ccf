"""Periodic motions that slide on a surface in space all the time; those that stop or strike are refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

import nonsmooth as ns
from models import BeltOscillator
from nonsmooth.cycles.cycle_margins import least_p, least_slip
from nonsmooth.cycles.flow_map import flow_curve
from nonsmooth.cycles.jump import read_jump
from nonsmooth.cycles.mode_flow import ContactState, mode_flow
from tests.equilibria.test_equilibria_in_space import sprung

LIKE_THE_BELT = {"m": 1.0, "g": 1.0, "c": 0.1, "k_x": 10.0}  # of `BeltOscillator`: N = 1
START = {"state": ([0.35, 0.0, 0.0], [0.1, 0.0, 0.0]), "duration": 60.0}


def oblique(**changes):
    return sprung(**(LIKE_THE_BELT | {"k_y": 22.0, "vx": 0.42, "vy": 0.03} | changes))


def integral(cycle, function):
    """Of a function of the sliding velocity (2,) over a period."""
    (phase,) = cycle.phases
    curve = flow_curve(mode_flow(cycle.system, phase.states), phase.x, phase.duration, cycle.scale, pieces=60)
    belt = np.array([cycle.system.parameter_values[name] for name in ("vx", "vy")])
    return quad(lambda t: function(curve(t)[3:5] - belt), 0, phase.duration, epsabs=1e-12, epsrel=1e-12)[0]


def slope(gamma):
    return -0.45 + 1.8 * (gamma @ gamma)


def across(gamma):
    v = np.sqrt(gamma @ gamma)
    return (0.4 - 0.45 * v + 0.6 * v**3) / v


@pytest.mark.upkeep
def test_along_its_spring_the_mass_has_the_cycle_of_the_plane_and_two_more_multipliers():
    plane = ns.limit_cycle(BeltOscillator(vb=0.42))
    cycle = ns.limit_cycle(sprung(**LIKE_THE_BELT, k_y=10.0, vx=0.42, vy=0.0), **START)
    assert cycle.period == pytest.approx(plane.period, rel=1e-11) and cycle.is_stable
    assert least_slip(cycle) == pytest.approx(least_slip(plane), rel=1e-7)
    first, *others = cycle.multipliers
    assert first == pytest.approx(np.exp(-integral(cycle, lambda gamma: 0.1 + slope(gamma))), rel=1e-6)
    assert first == pytest.approx(plane.multipliers[0], rel=1e-6)
    assert np.prod(others) == pytest.approx(np.exp(-integral(cycle, lambda gamma: 0.1 + across(gamma))), rel=1e-6)


@pytest.mark.upkeep
def test_a_cycle_oblique_to_its_springs_closes_and_contracts_as_its_damping_says():
    cycle = ns.limit_cycle(oblique(), **START)
    x = cycle.phases[0].x
    sol = ns.simulate(cycle.system, (0, cycle.period), x[:3], x[3:6], integrator=ns.EventDriven(rtol=1e-12, atol=1e-14))
    np.testing.assert_allclose(np.concatenate([sol.q[-1], sol.u[-1]]), x, atol=1e-12)
    assert np.ptp(cycle.q[:, 1]) > 1e-3 and abs(cycle.multipliers[1].imag) > 0.01
    whole = integral(cycle, lambda gamma: 0.2 + slope(gamma) + across(gamma))
    assert np.prod(cycle.multipliers) == pytest.approx(np.exp(-whole), rel=1e-6)
    assert least_p(cycle)[0] == pytest.approx(1.0, abs=1e-12)  # the rows of the plane are not coupled


@pytest.mark.upkeep
def test_a_cycle_is_followed_along_a_parameter():
    branch = ns.continue_cycle(oblique(), "vx", [0.42, 0.4225, 0.425], ns.limit_cycle(oblique(), **START))
    other = ns.limit_cycle(oblique(vx=0.425), **START)
    assert branch.cycles[-1].period == pytest.approx(other.period, rel=1e-10)
    assert np.ptp(branch.cycles[-1].q[:, 0]) < np.ptp(branch.cycles[0].q[:, 0])


@pytest.mark.upkeep
def test_aside_of_its_belt_a_mass_that_would_stick_in_the_plane_slides_past_rest():
    """At 0.2 m/s the mass of the plane sticks for a quarter of a second. Pulled aside at 0.03 m/s it never stops."""
    assert ns.limit_cycle(BeltOscillator(vb=0.2)).stick_duration > 0.2
    cycle = ns.limit_cycle(oblique(vx=0.2), **START)
    assert cycle.stick_duration == 0.0 and 0.005 < least_slip(cycle) < 0.01 and cycle.is_stable
    x = cycle.phases[0].x
    sol = ns.simulate(cycle.system, (0, cycle.period), x[:3], x[3:6], integrator=ns.MoreauJean(dt=1e-5), every=10**6)
    np.testing.assert_allclose(np.concatenate([sol.q[-1], sol.u[-1]]), x, atol=1e-9)


@pytest.mark.upkeep
def test_what_stops_or_strikes_is_refused_by_name():
    with pytest.raises(ns.InvalidInput, match="sticks; with friction in two directions"):
        ns.limit_cycle(oblique(vx=0.2, vy=0.003), **START)
    flying = mode_flow(oblique(), (ContactState(ns.ContactMode.OPEN, 0, 1),))
    with pytest.raises(ns.InvalidInput, match="an impact with friction in two directions"):
        read_jump(flying, np.zeros(6), np.ones(6), [])
