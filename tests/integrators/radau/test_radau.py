"""The Radau kernel alone: measured order, stiff and unstable motions, located events, the interpreted twin."""

import math

import numpy as np
import pytest

from nonsmooth.errors import Status
from nonsmooth.integrators.radau.events import (
    NO_EVENT,
    Events,
    locate_event,
)
from nonsmooth.integrators.radau.method import radau_accept, radau_shorten, radau_step
from nonsmooth.integrators.radau.stages import RATES, Radau
from nonsmooth.jit import interpreted, kernel
from nonsmooth.jit.blocks import Block, new, numbers, view


class Rate(Block):
    """What some of the rates read."""

    a: float  # [1/s]


@kernel(RATES)
def duffing(sys, context, t, x, out):
    """x'' = -x - x^3, with the work of the spring as a quadrature."""
    out[0] = x[1]
    out[1] = -x[0] - x[0] * x[0] * x[0]
    out[2] = out[1] * x[1]
    return Status.RUNNING.value


@kernel(RATES)
def oscillator(sys, context, t, x, out):
    """x'' = -x"""
    out[0] = x[1]
    out[1] = -x[0]
    return Status.RUNNING.value


@kernel(RATES)
def attracted(sys, context, t, x, out):
    """x' = -a (x - cos t) - sin t: x = cos t attracts (a > 0) or repels (a < 0). Prothero and Robinson."""
    out[0] = -view(sys, Rate).a * (x[0] - math.cos(t)) - math.sin(t)
    return Status.RUNNING.value


@kernel(RATES)
def all_but_rest(sys, context, t, x, out):
    """Rates of rounding: 1e-190 or 1e-16 by turns, as the last bits of what cancels are."""
    out[0] = 1e-16 * math.exp(-200.0 * (1.0 + math.sin(view(sys, Rate).a * t)))
    return Status.RUNNING.value


@kernel(RATES)
def falls_below_half(sys, context, t, x, out):
    """One event, x_0 = 1/2, of the tolerance 1e-12."""
    out[0] = x[0] - 0.5
    out[1] = 1e-12
    return Status.RUNNING.value


@kernel("int64(int64, float64, int64)")
def march(sys, t_end, ode_at):
    """Step to t_end."""
    ode = view(ode_at, Radau)
    while ode.clock.now < t_end:
        status = radau_step(sys, t_end - ode.clock.now, ode_at)
        if status == Status.RUNNING:
            status = radau_accept(sys, ode)
        if status != Status.RUNNING:
            return status
    return Status.FINISHED.value


@kernel("int64(int64, float64, int64, int64)")
def march_to_event(sys, t_end, ode_at, events_at):
    """Step to the first event."""
    ode, events = view(ode_at, Radau), view(events_at, Events)
    events.found.check_start = 1
    events.found.handled = NO_EVENT
    while ode.clock.now < t_end:
        status = radau_step(sys, t_end - ode.clock.now, ode_at)
        if status == Status.RUNNING:
            status = locate_event(sys, ode_at, events_at)
        if status == Status.RUNNING:
            status = radau_accept(sys, ode)
        if status != Status.RUNNING:
            return status
        if events.found.which != NO_EVENT:
            return Status.FINISHED.value
    return Status.RUNNING.value


def new_ode(rates, x0, kinematic, quadratures, rtol):
    ode = new(Radau, m=kinematic, n=len(x0) - quadratures, quadratures=quadratures)
    ode.rates = rates
    ode.x[:], ode.atol[:], ode.clock.rtol = x0, rtol, rtol
    return ode


def rate_of(a):
    rate = new(Rate)
    rate.a = a
    return rate


def integrate(rates, x0, t_end, rtol, kinematic=0, quadratures=0, a=0.0):
    for entry_point in (radau_step, march):
        entry_point.load()
    block = new_ode(rates.address, x0, kinematic, quadratures, rtol)
    rate = rate_of(a)
    status = Status(march(rate.address, t_end, block.address))
    return status, block


def test_error_falls_with_the_fifth_power_of_the_number_of_steps():
    reference = integrate(duffing, [1.0, 0.0, 0.0], 5.0, 1e-13, 1, 1)[1].x[:2]
    runs = [integrate(duffing, [1.0, 0.0, 0.0], 5.0, rtol, 1, 1)[1] for rtol in (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)]
    errors = [np.abs(run.x[:2] - reference).max() for run in runs]
    steps = [run.counters.accepted for run in runs]
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 4.4 < order < 5.4  # the method has 5, its embedded estimate 3; varying steps scatter the slope


def test_quadrature_of_the_power_is_the_change_of_kinetic_energy():
    rtol = 1e-10
    x = integrate(duffing, [1.0, 0.0, 0.0], 5.0, rtol, 1, 1)[1].x
    assert abs(x[2] - 0.5 * x[1] ** 2) < 100 * rtol  # both of order 1, some fifty steps of error rtol each


def test_eliminating_positions_changes_rounding_only():
    x0, rtol = [1.0, 0.3], 1e-8
    eliminated = integrate(oscillator, x0, 10.0, rtol, kinematic=1)[1].x
    full = integrate(oscillator, x0, 10.0, rtol, kinematic=0)[1].x
    exact = [math.cos(10) + 0.3 * math.sin(10), 0.3 * math.cos(10) - math.sin(10)]
    assert np.abs(eliminated - full).max() < 0.1 * rtol  # Newton's method is stopped at a part of the tolerance
    assert np.abs(eliminated - exact).max() < 100 * rtol


@pytest.mark.parametrize("stiffness", [1e3, 1e8, 1e12])
def test_stiffness_costs_no_steps_once_the_transient_has_died_out(stiffness):
    rtol = 1e-8
    status, ode = integrate(attracted, [1.0], 3.0, rtol, a=stiffness)
    assert status == Status.FINISHED
    assert abs(ode.x[0] - math.cos(3.0)) < 10 * rtol
    assert ode.counters.accepted < 200


def test_a_saddle_is_followed_not_damped():
    """From 1e-6 beside the repelling solution x - cos t = 1e-6 exp(lambda t): a step that damps would return."""
    growth, start = 1e4, 1e-6
    t_end = math.log(1e3) / growth
    status, ode = integrate(attracted, [1.0 + start], t_end, 1e-10, a=-growth)
    assert status == Status.FINISHED
    # errors made on the way grow by as much as the distance itself, 1e3; 1e-10 a step over some forty steps
    assert abs(ode.x[0] - math.cos(t_end) - 1e3 * start) < 1e3 * 40 * 1e-10


@pytest.mark.parametrize("rate", [1.0, 2.0, 5.0, 7.0, 300.0])
def test_rounding_of_rates_at_rest_does_not_shorten_the_steps(rate):
    """The rounding of a second is a hundredth of the tolerance: every step is as long as it may be, 1 s."""
    for entry_point in (radau_step, march):
        entry_point.load()
    block, sys = new_ode(all_but_rest.address, [0.0], 0, 0, 1e-14), rate_of(rate)
    for second in range(1, 101):
        status = march(sys.address, float(second), block.address)
        assert Status(status) == Status.FINISHED
    assert block.counters.accepted == 100


def test_event_is_located_to_the_error_of_the_method():
    """cos t = 1/2 at t = pi/3."""
    rtol = 1e-9
    for entry_point in (radau_step, radau_shorten, locate_event, march_to_event):
        entry_point.load()
    ode, events = new_ode(oscillator.address, [1.0, 0.0], 1, 0, rtol), new(Events, n_events=1, n_x=2)
    events.functions = falls_below_half.address
    status = march_to_event(0, 3.0, ode.address, events.address)
    assert status == Status.FINISHED
    assert abs(ode.x[0] - 0.5) < 1e-15  # Newton's method ends at rounding
    assert abs(ode.clock.now - math.pi / 3) < 30 * rtol  # the error of some thirty steps


def test_rates_that_refuse_a_state_end_the_run_with_their_status():
    @kernel(RATES)
    def refuses(sys, context, t, x, out):
        out[0] = -1.0
        return Status.NOT_FINITE.value if x[0] < 0.5 else Status.RUNNING.value

    rtol = 1e-6
    status, ode = integrate(refuses, [1.0], 3.0, rtol)
    assert status == Status.NOT_FINITE
    assert abs(ode.x[0] - 0.5) < rtol**1.5  # Newton's method is stopped at sqrt(rtol) of the tolerance


def test_interpreter_and_machine_code_agree_bit_for_bit():
    x0, rtol = [1.0, 0.0, 0.0], 1e-7
    compiled = integrate(duffing, x0, 2.0, rtol, 1, 1)[1]
    twin = new_ode(interpreted(duffing), x0, 1, 1, rtol)
    status = interpreted(march)(rate_of(0.0), 2.0, twin)
    assert status == Status.FINISHED
    assert (twin.x == compiled.x).all()
    assert (numbers(twin.counters) == numbers(compiled.counters)).all()
    assert twin.clock.done == compiled.clock.done
