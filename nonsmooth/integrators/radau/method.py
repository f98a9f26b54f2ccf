"""Radau IIA of order 5 with error control: stiff ordinary differential equations x' = f(t, x), in compiled code.

A step is tried (`radau_step`), may be shortened to an event within it (`radau_shorten`), and is then accepted
(`radau_accept`); after a change of f the method begins anew (`radau_restart`). The stages and the refusal of saddles
are in radau/stages.py. Source: Hairer, Wanner, *Solving Ordinary Differential Equations II* (1996), section IV.8
(RADAU5); step control of Gustafsson, *ACM Trans. Math. Softw.* 20 (1994) 496.
"""

from __future__ import annotations

import math

from nonsmooth.errors import Status
from nonsmooth.integrators.radau.stages import (
    DENSE,
    NEWTON_ITERATIONS,
    T_INVERSE,
    C,
    Radau,
    dense_value,
    estimate_error,
    factorise,
    finish_stages,
    guess_stages,
    jacobian,
    newton,
    rates_at,
)
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.numerics.rounding import EPS

STEP_SAFETY = 0.9  # chosen: of the step that the error would allow, as in RADAU5
LEAST_STEP_CHANGE, MOST_STEP_CHANGE = 0.1, 10.0  # chosen: bounds of the change of step
KEEP = 1.2  # chosen: a step that would grow by less keeps its length, and with it the factors
RECOVER = 1.2  # chosen: growth of the longest step after Newton's method failed with a longer one
# chosen: of the span: the first step of a body at rest, which says nothing of the time in which its loads change
QUIET_FIRST_STEP = 1e-6
SLOW = 1e-3  # chosen: rate of convergence of Newton's method above which the Jacobian is renewed
SMALLEST_STEP = 16.0 * EPS  # chosen: step, relative to t
SMALLEST_RTOL = 100 * EPS  # chosen: no state is known better after a hundred steps
# chosen: an error that is no smaller when the next is compared with it, as in RADAU5. At rest errors are rounding,
# 1e-60 or 1e-6 of the tolerance by chance, and such a growth would shrink the step to nothing.
CALM = 1e-2


@kernel("int64(int64, float64, int64)", short_loops=True)
def radau_step(sys, h_max, ode_at):
    """Try steps until one is good: Z, x_1 and clock.done describe it; x and the time stay. Returns a Status."""
    ode = view(ode_at, Radau)
    clock, flags, counters = ode.clock, ode.flags, ode.counters
    if flags.has_rates == 0:
        status = begin(sys, h_max, ode)
        if status != Status.RUNNING:
            return status
    while True:
        h = min(clock.step, h_max)
        if not h > SMALLEST_STEP * abs(clock.now):
            return flags.refusal if flags.refusal != 0 else Status.STEP_VANISHED.value
        if flags.has_jacobian == 0:
            status = jacobian(sys, ode)
            if status != Status.RUNNING:
                return status
        flags.refusal = 0
        if clock.factored != h and not factorise(h, ode):
            counters.rejected += 1
            clock.step = 0.5 * h
            continue
        guess_stages(h, ode)
        converged, iterations, rate = newton(sys, h, ode_at)
        if not converged:
            if flags.is_current == 0:
                flags.has_jacobian = 0
            else:
                counters.rejected += 1
                clock.step = 0.5 * h
                clock.limit = 0.5 * h
                flags.has_dense = 0
            continue
        finish_stages(h, ode)
        error = estimate_error(h, ode)
        safety = STEP_SAFETY * (2.0 * NEWTON_ITERATIONS + 1.0) / (2.0 * NEWTON_ITERATIONS + iterations)
        factor = safety * step_factor(h, error, clock)
        if not error <= 1.0:
            counters.rejected += 1
            clock.step = h * max(LEAST_STEP_CHANGE, factor)
            continue
        is_slow = iterations > 2 and rate > SLOW
        if not is_slow and factor < KEEP and h == clock.step:
            factor = 1.0
        if h == clock.step or factor < 1.0:
            clock.step = h * min(MOST_STEP_CHANGE, factor)
        clock.limit *= RECOVER
        clock.step = min(clock.step, clock.limit)
        clock.done = h
        clock.error_old = max(CALM, error)
        flags.is_worn = is_slow
        return Status.RUNNING.value


@kernel
def begin(sys, h_max, ode):
    """Rates, scales and a first step at a start: h = |x| / (100 |x'|), norms as in the error test."""
    clock, x, f_0, scale = ode.clock, ode.x, ode.f_0, ode.scale
    status = rates_at(ode.rates, sys, ode.context, clock.now, x, f_0)
    ode.counters.evaluations += 1
    if status != Status.RUNNING:
        return status
    size, speed = 0.0, 0.0
    for i in range(scale.shape[0]):
        scale[i] = ode.atol[i] + clock.rtol * abs(x[i])
        size += x[i] / scale[i] * (x[i] / scale[i])
        speed += f_0[i] / scale[i] * (f_0[i] / scale[i])
    ode.flags.has_rates = 1
    ode.flags.has_dense = 0
    clock.factored = 0.0
    clock.error_old = 0.0
    clock.limit = math.inf
    # one part of a component, or of its tolerance where all are zero, in the first step
    h = 0.01 * math.sqrt(max(size, 1.0) / speed) if speed > 0.0 else QUIET_FIRST_STEP * h_max
    clock.step = min(h_max, max(h, 2.0 * SMALLEST_STEP * abs(clock.now)))
    return Status.RUNNING.value


@kernel
def step_factor(h, error, clock):
    """The change of step that would bring the error to 1, from this step and the one before (Gustafsson)."""
    if not error > 1e-12:
        return MOST_STEP_CHANGE
    factor = 1.0
    if clock.error_old > 0.0:
        factor = min(1.0, h / clock.step_old * (clock.error_old / error) ** 0.25)
    return factor * error**-0.25


@kernel("int64(int64, float64, int64)", short_loops=True)
def radau_shorten(sys, h, ode_at):
    """Take the step of ``radau_step`` anew with a smaller h: to an event that was found within it."""
    ode = view(ode_at, Radau)
    move_end(h, ode)  # the polynomial of the longer step is the first guess
    for s in range(3):
        for i in range(ode.W.shape[1]):
            total = 0.0
            for r in range(3):
                total += T_INVERSE[s][r] * ode.Z[r, i]
            ode.W[s, i] = total
    while True:
        if factorise(h, ode):
            converged, _, _ = newton(sys, h, ode_at)
            if converged:
                break
        if ode.flags.is_current != 0:
            return Status.STEP_VANISHED.value
        status = jacobian(sys, ode)
        if status != Status.RUNNING:
            return status
    finish_stages(h, ode)
    return Status.RUNNING.value


@kernel
def move_end(h, ode):
    """Let the step that was tried end after the time h, on its polynomial."""
    ratio = h / ode.clock.done
    for i in range(ode.x.shape[0]):
        Z_1, Z_2, Z_3 = ode.Z[0, i], ode.Z[1, i], ode.Z[2, i]
        for s in range(3):
            ode.Z[s, i] = dense_value(C[s] * ratio, Z_1, Z_2, Z_3)
        ode.x_1[i] = ode.x[i] + ode.Z[2, i]
    ode.clock.done = h


@kernel
def radau_interpolate(theta, ode, out):
    """x(t + theta h) within the step that was tried, not yet accepted."""
    Z, x = ode.Z, ode.x
    for i in range(x.shape[0]):
        out[i] = x[i] + dense_value(theta, Z[0, i], Z[1, i], Z[2, i])


@kernel
def radau_accept(sys, ode):
    """Move to the end of the step that was tried; returns the Status of the rates there."""
    clock, Z, x, x_1, dense, scale = ode.clock, ode.Z, ode.x, ode.x_1, ode.dense, ode.scale
    for i in range(x.shape[0]):
        for k in range(3):
            dense[k, i] = DENSE[0][k] * Z[0, i] + DENSE[1][k] * Z[1, i] + DENSE[2][k] * Z[2, i]
        x[i] = x_1[i]
    clock.now += clock.done
    clock.step_old = clock.done
    ode.flags.has_dense = 1
    ode.flags.is_current = 0
    if ode.flags.is_worn != 0:
        ode.flags.has_jacobian = 0
    ode.counters.accepted += 1
    ode.counters.evaluations += 1
    for i in range(scale.shape[0]):
        scale[i] = ode.atol[i] + clock.rtol * abs(x[i])
    return rates_at(ode.rates, sys, ode.context, clock.now, x, ode.f_0)


@kernel
def radau_restart(keeps_rates, ode):
    """Forget what belongs to the rates before a change of them, or of the state alone: its Jacobian is an old one then,
    which is taken anew where Newton's method asks for it."""
    flags = ode.flags
    flags.has_rates, flags.is_current, flags.has_dense, flags.refusal = 0, 0, 0, 0
    if not keeps_rates or flags.is_worn != 0:
        flags.has_jacobian, flags.is_worn = 0, 0
