"""Events of an ordinary differential equation: where a function of the state falls through zero.

An event function is positive while its mode lasts. It is watched at the stages of each step; a gap also where the
parabola through them is lowest, if that is below -atol: a contact may touch and part within one step. The first zero is
enclosed by bisection of the collocation polynomial, and the step is then taken anew to that time and corrected by
Newton's method, so that the state at the event has the order of the method, not that of the polynomial.

A function that begins at zero, within its own tolerance, is *armed* only once it has been above it: what rounding
leaves at the beginning of a mode is no event. What falls without having been armed is one where minus the tolerance is
reached; at the beginning of a mode, at once. A negative tolerance says that the function jumps: its zero is where the
polynomial of the step has it. The tolerance is that of rounding; the error between the stages may be
larger, so what has fallen there must have fallen at the end of the shortened step too, or the step is tried again with
a tenth of its length.
Source: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I* (1993), section II.6; Shampine, Thompson,
*Comput. Math. Appl.* 39 (2000) 43.
"""

from __future__ import annotations

from typing import NamedTuple

from nonsmooth.blocks import Integers, Matrix, Vector, address, view
from nonsmooth.errors import Status
from nonsmooth.integrators.radau import radau_interpolate, radau_shorten
from nonsmooth.integrators.radau_stages import DONE, EPS, NOW, RATES, STEP, C, Radau
from nonsmooth.jit import Callback, kernel

BISECTIONS = 50
CORRECTIONS = 6
NEAR = 0.1  # of the length of the step: a larger correction means that the polynomial was wrong
SLOPE_STEP = 1e-3  # of the distance to the event: the difference that gives the slope of the event function
NO_EVENT, TOO_LONG = -1, -2
ROUNDINGS = 1000.0  # units of rounding that the tolerance of an event function stands for
REDUCTION, MOST_REDUCTIONS = 0.1, 6  # of a step whose error hides the sign of an event function
# found
WHICH, IS_IMMEDIATE, CHECK_START, HANDLED, REDUCTIONS = range(5)

# event_values(address, model, p, context, t, x, out) -> Status writes E values, then their E tolerances
event_values = Callback(RATES)


class Events(NamedTuple):
    """What is known of the event functions, E of them."""

    armed: Integers  # (E,)
    is_gap: Integers  # (E,) 1 for the gap of an open contact, which is looked at between the stages too
    floor: Vector  # (E,) what the rounding of its time left of an event that was handled
    value: Vector  # (2E,) values and tolerances
    stages: Matrix  # (3, E) values at the stages of the step
    x: Vector  # (N,) a state within the step
    found: Integers  # (5,)


def events_shapes(n_events: int, n_x: int) -> dict[str, tuple[int, ...]]:
    """Shapes of ``Events``."""
    return {
        "armed": (n_events,), "is_gap": (n_events,), "floor": (n_events,), "value": (2 * n_events,),
        "stages": (3, n_events), "x": (n_x,), "found": (5,),
    }  # fmt: skip


@kernel("int64(int64, int64, int64, float64[::1], int64, int64, int64)", short_loops=True)
def locate_event(rates, functions, model, p, context, ode_at, events_block):
    """Look for the first event within the step that was tried, and shorten the step to it.

    found[WHICH] is the event, NO_EVENT, or TOO_LONG where a step is to be tried anew, with the clock[STEP] set here;
    found[IS_IMMEDIATE] tells that the event lies at the beginning of the step. Returns a Status.
    """
    ode, events = view(ode_at, Radau), view(events_block, Events)
    found, clock = events.found, ode.clock
    found[WHICH] = NO_EVENT
    found[IS_IMMEDIATE] = 0
    low = 0.0
    for sample in range(-1 if found[CHECK_START] != 0 else 0, 3):
        theta = C[sample] if sample >= 0 else 0.0
        for i in range(ode.x.shape[0]):
            events.x[i] = ode.x[i] + ode.Z[sample, i] if sample >= 0 else ode.x[i]
        status = event_values(functions, model, p, context, clock[NOW] + theta * clock[DONE], events.x, events.value)
        if status != Status.RUNNING:
            return status
        if sample < 0 and found[HANDLED] != NO_EVENT:
            events.floor[found[HANDLED]] = max(0.0, -events.value[found[HANDLED]])
            found[HANDLED] = NO_EVENT
        which, _ = first_fallen(events)
        if which != NO_EVENT and sample < 0:
            found[WHICH] = which
            found[IS_IMMEDIATE] = 1
            return Status.RUNNING.value
        if which != NO_EVENT:
            return shorten_to_event(rates, functions, model, p, context, low, theta, ode, events)
        arm(events)
        low = theta
        if sample >= 0:
            for e in range(events.armed.shape[0]):
                events.stages[sample, e] = events.value[e]
    theta = first_dip(ode.atol[0], events)
    if theta < 1.0:
        radau_interpolate(theta, ode, events.x)
        status = event_values(functions, model, p, context, clock[NOW] + theta * clock[DONE], events.x, events.value)
        if status != Status.RUNNING:
            return status
        which, _ = first_fallen(events)
        if which != NO_EVENT:
            return shorten_to_event(rates, functions, model, p, context, 0.0, theta, ode, events)
    found[CHECK_START] = 0
    found[REDUCTIONS] = 0
    return Status.RUNNING.value


@kernel
def first_dip(atol, events):
    """Where in the step, in (0, 1), a gap dips below -atol between stages at which it is positive, by the parabola
    through them; the first of several, 1 if none does."""
    first = 1.0
    for e in range(events.armed.shape[0]):
        v_0, v_1, v_2 = events.stages[0, e], events.stages[1, e], events.stages[2, e]
        slope = (v_1 - v_0) / (C[1] - C[0])
        curvature = ((v_2 - v_1) / (C[2] - C[1]) - slope) / (C[2] - C[0])
        if events.is_gap[e] == 0 or events.armed[e] == 0 or not curvature > 0.0:
            continue
        theta = 0.5 * (C[0] + C[1] - slope / curvature)
        if 0.0 < theta < first and v_0 + (theta - C[0]) * (slope + (theta - C[1]) * curvature) < -atol:
            first = theta
    return first


@kernel
def first_fallen(events):
    """(The first event function that fell, whether it was armed), or NO_EVENT; the unarmed ones come first."""
    E = events.armed.shape[0]
    which = NO_EVENT
    for e in range(E):
        if events.armed[e] == 0 and events.value[e] < -events.value[E + e] - events.floor[e]:
            return e, False
        if which == NO_EVENT and events.armed[e] != 0 and events.value[e] < 0.0:
            which = e
    return which, True


@kernel
def arm(events):
    """Arm the functions that are above their tolerance."""
    E = events.armed.shape[0]
    for e in range(E):
        if events.value[e] > events.value[E + e]:
            events.armed[e] = 1
            events.floor[e] = 0.0


@kernel
def shorten_to_event(rates, functions, model, p, context, low, high, ode, events):
    """Enclose the first zero in (low, high) of the step, take the step to it and correct it; returns a Status."""
    clock, x, value = ode.clock, events.x, events.value
    t, h = clock[NOW], clock[DONE]
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if (high - low) * h <= EPS * abs(t) or high - low <= EPS * high:
            break
        radau_interpolate(middle, ode, x)
        status = event_values(functions, model, p, context, t + middle * h, x, value)
        if status != Status.RUNNING:
            return status
        which, _ = first_fallen(events)
        if which != NO_EVENT:
            high = middle
        else:
            low = middle
    radau_interpolate(high, ode, x)
    status = event_values(functions, model, p, context, t + high * h, x, value)
    if status != Status.RUNNING:
        return status
    which, is_armed = first_fallen(events)
    at_event = value[which]
    level = 0.0 if is_armed else -value[events.armed.shape[0] + which] - events.floor[which]
    radau_interpolate(high * (1.0 - SLOPE_STEP), ode, x)
    status = event_values(functions, model, p, context, t + high * (1.0 - SLOPE_STEP) * h, x, value)
    if status != Status.RUNNING:
        return status
    events.found[WHICH] = which
    slope = (at_event - value[which]) / (SLOPE_STEP * high * h)
    if value[events.armed.shape[0] + which] < 0.0:
        slope = 0.0
    status, is_met = correct(rates, functions, model, p, context, high * h, slope, which, level, ode, events)
    is_refused = status != Status.RUNNING and status != Status.STEP_VANISHED
    if not is_met and not is_refused and events.found[REDUCTIONS] < MOST_REDUCTIONS:
        events.found[WHICH] = TOO_LONG  # the polynomial fell, the motion does not; or the shorter step was not solved
        events.found[REDUCTIONS] += 1
        clock[STEP] = REDUCTION * h
        return Status.RUNNING.value
    events.found[REDUCTIONS] = 0
    return status


@kernel
def correct(rates, functions, model, p, context, length, slope, which, level, ode, events):
    """Newton's method on the length of the step, until the event function has fallen to the level; each of its values
    is from a step taken anew. Returns (Status, whether it falls there)."""
    t = ode.clock[NOW]
    is_met = False
    for _ in range(CORRECTIONS):
        status = radau_shorten(rates, model, p, context, length, address(ode))
        if status != Status.RUNNING:
            return status, False
        status = event_values(functions, model, p, context, t + length, ode.x_1, events.value)
        if status != Status.RUNNING:
            return status, False
        change = (level - events.value[which]) / slope if slope < 0.0 else 0.0
        is_met = abs(change) < NEAR * length
        if abs(change) <= 4.0 * EPS * max(abs(t), length) or not is_met:
            break
        length += change
    arm(events)
    return Status.RUNNING.value, is_met
