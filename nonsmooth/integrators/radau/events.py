"""Events of an ordinary differential equation: where a function of the state falls through zero.

An event function is positive while its mode lasts. It is watched at the stages of each step, and between them
(radau/resolution.py): what falls and rises again within one step is found too. The first zero is enclosed on the
collocation polynomial, and the step is then taken anew to that time and corrected by Newton's method, so that
the state at the event has the order of the method, not that of the polynomial. The step that is left is watched in the
same way: what dips before the event may lie between the stages of the longer one.

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

import math
from typing import Annotated as Array

from nonsmooth.errors import Status
from nonsmooth.integrators.radau.method import STEP_SAFETY, move_end, radau_interpolate, radau_shorten
from nonsmooth.integrators.radau.resolution import (
    AT_BEGIN,
    EXTRA,
    NODES,
    forget_largest,
    is_clear,
    judge_resolution,
    keep_end,
    note_values,
)
from nonsmooth.integrators.radau.stages import RATES, C, Radau
from nonsmooth.jit import Callback, kernel, rare_kernel
from nonsmooth.jit.blocks import Block, Floats, Handle, Ints, address, view
from nonsmooth.numerics.rounding import EPS, spacing

MAX_STALLS = 8  # chosen: events at one instant, per event function
MOST_PLACES_TRIED = 150  # chosen: evaluations that enclose an event; some 8 do to 1e-15 of a step
AT_SECANT, BEYOND_SECANT, AT_MIDDLE = range(3)  # code: where an event is looked for within what encloses it
LOW_END, HIGH_END = 1, 2  # code: its ends
EVENT_CORRECTIONS = 6  # chosen: of the time of an event, by steps of the method itself
LARGEST_CORRECTION = 0.1  # derived: of the length of the step: a larger correction means that the polynomial was wrong
# derived: the same that is made on the polynomial of the shortened step, whose end moves with the rates there: it errs
# by the square of that, times what the polynomial errs by within a step
POLYNOMIAL_CORRECTION = 1e-3
SLOPE_STEP = 1e-3  # chosen: of the distance to the event: the difference that gives the slope of the event function
NO_EVENT, TOO_LONG = -1, -2  # code: in place of the number of an event function
EVENT_ROUNDINGS = 2000  # chosen: roundings that the tolerance of an event function stands for
REDUCTION, MOST_REDUCTIONS = 0.1, 6  # chosen: of a step whose error hides the sign of an event function
REFINEMENT, REFINED_PART, MOST_REFINEMENTS = 0.1, 0.3, 12  # chosen: of a step whose event functions are not resolved
UNREFINED_STEP = 1e6 * EPS  # chosen: step, relative to t, that is not refined any further
LONGER = 2.0  # chosen: than the step before: such a step is looked into, whatever its stages say

# event_values(address, sys, context, t, x, out) -> Status writes E values, then their E tolerances
event_values = Callback(RATES)


class Found(Block):
    """What was found in a step."""

    which: int  # the event, NO_EVENT or TOO_LONG
    is_immediate: int  # 1 where it lies at the beginning of the step
    check_start: int  # 1 where a mode has just begun
    handled: int  # the event that began it
    reductions: int  # of a step whose error hides the sign of a function
    refinements: int  # of a step whose functions are not resolved


class Events(Block):
    """What is known of the event functions, E of them."""

    functions: Handle  # of ``event_values``
    armed: Array[Ints, "n_events"]
    is_gap: Array[Ints, "n_events"]  # of an open contact: what dips below zero by less than atol is no touch
    floor: Array[Floats, "n_events"]  # what the rounding of its time left of an event that was handled
    armed_before: Array[Ints, "n_events"]  # the same at the beginning of the step
    floor_before: Array[Floats, "n_events"]
    value: Array[Floats, "2 * n_events"]  # values and tolerances
    above: Array[Floats, "n_events"]  # distances from a fall at the ends of what encloses it
    below: Array[Floats, "n_events"]
    sample: Array[Floats, 6, "n_events"]  # at the beginning of the step, its stages, and two places between
    largest: Array[Floats, "n_events"]  # absolute values since the last event
    longest: float  # step [s] by which the event functions are followed
    x: Array[Floats, "n_x"]  # a state within the step
    found: Found


@kernel("int64(int64, int64, int64)", short_loops=True)
def locate_event(sys, ode_at, events_block):
    """Look for the first event within the step that was tried, and shorten the step to it.

    found.which is the event, NO_EVENT, or TOO_LONG where a step is to be tried anew, shorter; found.is_immediate
    tells that the event lies at the beginning of the step. Returns a Status.
    """
    ode, events = view(ode_at, Radau), view(events_block, Events)
    found = events.found
    found.which, found.is_immediate = NO_EVENT, 0
    if found.check_start != 0:
        status = look_at_start(sys, ode, events)
        if status != Status.RUNNING or found.is_immediate != 0:
            return status
    keep_armed(events)
    status = look_along(sys, NO_EVENT, ode, events)
    length = math.inf
    while status == Status.RUNNING and found.which >= 0 and ode.clock.done < length:
        length = ode.clock.done
        status = look_before(sys, found.which, ode, events)
    found.check_start = 0
    if found.which == TOO_LONG:
        restore_armed(events)
        return status
    if found.which == NO_EVENT:
        keep_end(events)
    found.reductions, found.refinements = 0, 0
    return status


@kernel
def look_at_start(sys, ode, events):
    """Look for what has fallen where a mode begins, and begin to follow the functions; a Status."""
    found = events.found
    status = values_at_stage(sys, -1, ode, events)
    if status != Status.RUNNING:
        return status
    forget_largest(events)
    events.longest = math.inf
    if found.handled != NO_EVENT:
        events.floor[found.handled] = max(0.0, -events.value[found.handled])
        found.handled = NO_EVENT
    which, _ = first_fallen(events)
    if which != NO_EVENT:
        found.which = which
        found.is_immediate = 1
        return status
    arm_functions(events)
    note_values(AT_BEGIN, events.value, events)
    return status


@kernel
def look_along(sys, ending, ode, events):
    """Look for the first fall within the step, at its stages and between them; at its end only where it is not known
    to end with an event. A Status, and found.which as above."""
    for sample in range(3):
        status = values_at_stage(sys, sample, ode, events)
        if status != Status.RUNNING:
            return status
        which, _ = first_fallen(events)
        if which != NO_EVENT and (sample < 2 or ending == NO_EVENT):
            return shorten_to_event(sys, sample, C[sample], ode, events)
        arm_functions(events)
        note_values(1 + sample, events.value, events)
    was_armed = 0
    if ending != NO_EVENT:  # which leaves no doubt: it falls there
        was_armed = events.armed[ending]
        events.armed[ending] = 0
    if is_doubtful(ode, events):
        status = look_between(sys, ode, events)
    else:
        events.longest = LONGER * ode.clock.done
    if ending != NO_EVENT:
        events.armed[ending] = was_armed
    return status


@rare_kernel
def look_before(sys, ending, ode, events):
    """Look for what falls in the step that was shortened to the event of a function, before it: the stages of the
    longer step were too far apart to show it. What is not armed was looked at there: nearer to zero lies its rounding.
    A Status, and found.which as above: the same event, with the same length of the step, if nothing does."""
    found = events.found
    found.which = NO_EVENT
    for e in range(events.armed.shape[0]):
        events.armed[e] = events.armed_before[e]
        events.floor[e] = events.floor_before[e] if events.armed_before[e] == 1 else math.inf
    status = look_along(sys, ending, ode, events)
    for e in range(events.armed.shape[0]):
        if events.armed[e] == 0:
            events.floor[e] = events.floor_before[e]
    if found.which == NO_EVENT:
        found.which = ending
    return status


@kernel
def is_doubtful(ode, events):
    """Whether a function may fall between the stages of the step."""
    return ode.flags.has_dense == 0 or ode.clock.done > LONGER * ode.clock.step_old or not is_clear(events)


@kernel
def longest_step(events):
    """The longest step [s] by which the event functions are followed, as far as is known."""
    return events.longest if events.found.check_start == 0 else math.inf


@rare_kernel
def look_between(sys, ode, events):
    """Look for what falls between the stages, and whether it would be seen; a Status, and found.which as above."""
    clock, found = ode.clock, events.found
    for k in range(EXTRA, len(NODES)):
        status = values_at(sys, NODES[k], ode, events)
        if status != Status.RUNNING:
            return status
        note_values(k, events.value, events)
    room, theta = judge_resolution(ode.atol[0], clock.rtol, events)
    if theta < 1.0:
        status = values_at(sys, theta, ode, events)
        if status != Status.RUNNING:
            return status
        which, _ = first_fallen(events)
        if which != NO_EVENT:
            return shorten_to_event(sys, AT_BEGIN, theta, ode, events)
        room = 0.0
    factor = STEP_SAFETY * room**0.25
    if (
        room >= 1.0
        or found.refinements == MOST_REFINEMENTS
        or REFINEMENT * clock.done <= UNREFINED_STEP * abs(clock.now)
    ):
        events.longest = clock.done * max(1.0, factor)
    else:
        found.which = TOO_LONG
        found.refinements += 1
        events.longest = clock.done * min(REFINED_PART, max(REFINEMENT, factor))
    return Status.RUNNING.value


@kernel
def values_at_stage(sys, sample, ode, events):
    """The event functions at a stage of the step, or where it begins for sample = -1, to events.value; a Status."""
    theta = C[sample] if sample >= 0 else 0.0
    for i in range(ode.x.shape[0]):
        events.x[i] = ode.x[i] + ode.Z[sample, i] if sample >= 0 else ode.x[i]
    return event_values(
        events.functions, sys, ode.context, ode.clock.now + theta * ode.clock.done, events.x, events.value
    )


@kernel
def values_at(sys, theta, ode, events):
    """The event functions within the step that was tried, to events.value; returns a Status."""
    radau_interpolate(theta, ode, events.x)
    t = ode.clock.now + theta * ode.clock.done
    return event_values(events.functions, sys, ode.context, t, events.x, events.value)


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
def arm_functions(events):
    """Arm the functions that are above their tolerance."""
    E = events.armed.shape[0]
    for e in range(E):
        if events.value[e] > events.value[E + e]:
            events.armed[e] = 1
            events.floor[e] = 0.0


@kernel
def keep_armed(events):
    """Keep what is armed where the step begins."""
    for e in range(events.armed.shape[0]):
        events.armed_before[e] = events.armed[e]
        events.floor_before[e] = events.floor[e]


@kernel
def restore_armed(events):
    """What was armed later in a step that is taken anew was not yet where it began."""
    for e in range(events.armed.shape[0]):
        events.armed[e] = events.armed_before[e]
        events.floor[e] = events.floor_before[e]


@kernel
def shorten_to_event(sys, before, high, ode, events):
    """Take the step to the first fall between a place where nothing has fallen, one of NODES, and one where something
    has, whose values are in events.value, and correct it; returns a Status."""
    clock, x, value = ode.clock, events.x, events.value
    t, h = clock.now, clock.done
    status, high = enclose_fall(sys, before, high, ode, events)
    if status != Status.RUNNING:
        return status
    radau_interpolate(high, ode, x)
    status = event_values(events.functions, sys, ode.context, t + high * h, x, value)
    if status != Status.RUNNING:
        return status
    which, is_armed = first_fallen(events)
    at_event = value[which]
    level = 0.0 if is_armed else -value[events.armed.shape[0] + which] - events.floor[which]
    radau_interpolate(high * (1.0 - SLOPE_STEP), ode, x)
    status = event_values(events.functions, sys, ode.context, t + high * (1.0 - SLOPE_STEP) * h, x, value)
    if status != Status.RUNNING:
        return status
    events.found.which = which
    slope = (at_event - value[which]) / (SLOPE_STEP * high * h)
    if value[events.armed.shape[0] + which] < 0.0:
        slope = 0.0
    status, is_met = correct_length(sys, high * h, slope, which, level, ode, events)
    is_refused = status != Status.RUNNING and status != Status.STEP_VANISHED
    if not is_met and not is_refused and events.found.reductions < MOST_REDUCTIONS:
        events.found.which = TOO_LONG  # the polynomial fell, the motion does not; or the shorter step was not solved
        events.found.reductions += 1
        clock.step = REDUCTION * h
        return Status.RUNNING.value
    return status


@kernel
def enclose_fall(sys, before, high, ode, events):
    """(Status, place) of that fall on the polynomial of the step, by regula falsi, every function with a secant of its
    own: at the secant, then as far again beyond it, so that both ends come near; where that is not beyond the fall,
    in the middle."""
    low, way, last = NODES[before], AT_SECANT, 0
    note_distances(events.below, events)
    for e in range(events.armed.shape[0]):
        events.above[e] = distance(events.sample[before, e], e, events)
    for _ in range(MOST_PLACES_TRIED):
        least = max(spacing(high), spacing(ode.clock.now) / ode.clock.done)
        if high - low <= least:
            break
        room = min(least, 0.5 * (high - low))
        middle = min(high - room, max(low + room, low + part_of(way, last, events) * (high - low)))
        status = values_at(sys, middle, ode, events)
        if status != Status.RUNNING:
            return status, high
        which, _ = first_fallen(events)
        side = HIGH_END if which != NO_EVENT else LOW_END
        if side == HIGH_END:
            high = middle
        else:
            low = middle
        note_distances(events.below if side == HIGH_END else events.above, events)
        way = BEYOND_SECANT if way == AT_SECANT else AT_MIDDLE if way == BEYOND_SECANT and side == last else AT_SECANT
        last = side
    return Status.RUNNING.value, high


@kernel
def part_of(way, last, events):
    """Where between the two ends the functions are looked at next, seen from the low one."""
    if way == AT_MIDDLE:
        return 0.5
    part = 1.0  # of the first of the functions that have fallen
    for e in range(events.armed.shape[0]):
        if events.below[e] < 0.0 <= events.above[e]:
            part = min(part, events.above[e] / (events.above[e] - events.below[e]))
    if way == BEYOND_SECANT:
        part = min(0.5, 2.0 * part) if last == LOW_END else max(0.5, 2.0 * part - 1.0)
    return part


@kernel
def distance(value, e, events):
    """How far a function is above where it counts as fallen."""
    return value if events.armed[e] == 1 else value + events.value[events.armed.shape[0] + e] + events.floor[e]


@kernel
def note_distances(end, events):
    """Take the distances at a new end."""
    for e in range(events.armed.shape[0]):
        end[e] = distance(events.value[e], e, events)


@kernel
def correct_length(sys, length, slope, which, level, ode, events):
    """Newton's method on the length of the step, which is taken anew, until the event function has fallen to the
    level; small corrections are made on its polynomial. Returns (Status, whether it falls there)."""
    t, is_met, change = ode.clock.now, False, math.inf
    for _ in range(EVENT_CORRECTIONS):
        if abs(change) < POLYNOMIAL_CORRECTION * length:
            move_end(length, ode)
        else:
            status = radau_shorten(sys, length, address(ode))
            if status != Status.RUNNING:
                return status, False
        status = event_values(events.functions, sys, ode.context, t + length, ode.x_1, events.value)
        if status != Status.RUNNING:
            return status, False
        change = (level - events.value[which]) / slope if slope < 0.0 else 0.0
        is_met = abs(change) < LARGEST_CORRECTION * length
        if abs(change) <= 4.0 * spacing(max(abs(t), length)) or not is_met:
            break
        length += change
    return Status.RUNNING.value, is_met
