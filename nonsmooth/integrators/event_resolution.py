"""What event functions do between the places of a step at which they are known, and whether that is known well enough.

A body at rest, or one that a load does not move, says nothing of that load: its steps grow without bound, and a load
may rise and fall again within one of them. So the event functions are part of what limits a step. Each is known at the
beginning of the step and at its three stages, and where these four leave a doubt at two places more. The polynomial
P through all six tells where it is low; what the cubic P_3 through the first four is off by at the other two, spread
over the step as w = theta (theta - c_1) (theta - c_2) (theta - 1), bounds the error:

    P(theta) + floor >= DOUBT |w(theta)| max_k |f(theta_k) - P_3(theta_k)| / |w(theta_k)|

Where a function is far from zero, large errors do; near zero the step shrinks until its sign is certain, or until what
is left is below the floor: a thousandth of the relative tolerance of the largest value since the last event, of a gap
the absolute tolerance. Source: Shampine, Thompson, *Comput. Math. Appl.* 39 (2000) 43.
"""

from __future__ import annotations

import math

from nonsmooth.integrators.radau_stages import EPS, C
from nonsmooth.jit import kernel

# The beginning of a step, its stages, and two places between them, and their order along the step
PLACES = (0.0, C[0], C[1], C[2], 0.4, 0.85)
ORDER = (0, 1, 4, 2, 5, 3)
BEGIN, END, EXTRA = 0, 3, 4
FAR = 4.0  # times what a function varies by at the stages: so far from zero it cannot fall between them
LOW = 0.25  # of what a function varies by at the stages: if it comes as near to zero its dip is looked at closely
CLEAR = 10.0  # times what the parabola through the stages is off by, which is more than the error of the cubic
DOUBT = 4.0  # times the error of the cubic, which is more than that of the polynomial through all places
FOLLOWED = 0.05  # of the largest value: a larger error is that of a function that turns more often than it is looked at
FLOOR = 1e-3  # of rtol, relative to the largest value: lower dips are not looked for
ROUNDED = 1000.0 * EPS  # of the largest value: what rounding leaves of a force


@kernel
def note_values(k, value, events):
    """Keep the values at place k of the step."""
    for e in range(events.armed.shape[0]):
        events.sample[k, e] = value[e]
        events.largest[e] = max(events.largest[e], abs(value[e]))


@kernel
def keep_end(events):
    """The end of a step is the beginning of the next."""
    for e in range(events.armed.shape[0]):
        events.sample[BEGIN, e] = events.sample[END, e]


@kernel
def forget_largest(events):
    """Begin anew with other modes."""
    for e in range(events.armed.shape[0]):
        events.largest[e] = 0.0


@kernel
def is_watched(e, events):
    """Whether a function may fall between the places: it is armed, was not left below zero by an event that was
    handled, and does not jump."""
    return events.armed[e] == 1 and events.sample[BEGIN, e] >= 0.0 <= events.value[events.armed.shape[0] + e]


@kernel
def is_clear(events):
    """Whether the stages alone leave no doubt that no function falls between them."""
    for e in range(events.armed.shape[0]):
        f_0, f_1, f_2, f_3 = events.sample[0, e], events.sample[1, e], events.sample[2, e], events.sample[3, e]
        lowest, highest = min(f_0, f_1, f_2, f_3), max(f_0, f_1, f_2, f_3)
        if not is_watched(e, events) or lowest > FAR * (highest - lowest):
            continue
        low = LOW * (highest - lowest)
        slope = (f_2 - f_1) / (C[1] - C[0])
        curvature = ((f_3 - f_2) / (C[2] - C[1]) - slope) / (C[2] - C[0])
        twist = (f_1 - C[0] * (slope - C[1] * curvature) - f_0) / (C[0] * C[1] * C[2])
        vertex = 0.5 * (C[0] + C[1] - slope / curvature) if curvature > 0.0 else 1.0
        for theta in (0.5 * C[0], 0.5 * (C[0] + C[1]), 0.5 * (C[1] + C[2]), min(1.0, max(0.0, vertex))):
            parabola = f_1 + (theta - C[0]) * (slope + (theta - C[1]) * curvature)
            off = twist * (theta - C[0]) * (theta - C[1]) * (theta - C[2])
            if not parabola + off >= CLEAR * abs(off) + low:
                return False
    return True


@kernel
def judge(atol, rtol, events):
    """(Room, place): how many times the error fits between the functions and zero where that is least, 1 or more if
    they are resolved; and the first place in the step where one falls below its floor, 1 if none does."""
    room, first = math.inf, 1.0
    for e in range(events.armed.shape[0]):
        if not is_watched(e, events) or is_constant(e, events):
            continue
        floor = max(FLOOR * rtol, ROUNDED) * events.largest[e]
        if events.is_gap[e] == 1:
            floor = max(floor, atol)
        error = DOUBT * error_of_cubic(e, events)
        for k in range(EXTRA, len(PLACES)):
            if events.sample[k, e] < -floor:
                first = min(first, PLACES[k])
        for a in range(len(PLACES) - 1):
            low, high = PLACES[ORDER[a]], PLACES[ORDER[a + 1]]
            middle = 0.5 * (low + high)
            for theta in (middle, lowest_place(e, low, middle, high, events)):
                value = polynomial(theta, len(PLACES), e, events)
                if value < -floor:
                    first = min(first, theta)
                off = error * abs(shape(theta))
                if off > floor:
                    room = min(room, max(0.0, min(value + floor, FOLLOWED * events.largest[e])) / off)
    return room, first


@kernel
def is_constant(e, events):
    """Whether a function has one value at all places."""
    for k in range(1, len(PLACES)):
        if events.sample[k, e] != events.sample[BEGIN, e]:
            return False
    return True


@kernel
def error_of_cubic(e, events):
    """max |f - P_3|/|w| at the two places beside its nodes."""
    error = 0.0
    for k in range(EXTRA, len(PLACES)):
        theta = PLACES[k]
        error = max(error, abs(events.sample[k, e] - polynomial(theta, EXTRA, e, events)) / abs(shape(theta)))
    return error


@kernel
def shape(theta):
    """w(theta), which vanishes where the cubic is exact."""
    return theta * (theta - C[0]) * (theta - C[1]) * (theta - C[2])


@kernel
def polynomial(theta, m, e, events):
    """The polynomial through the first m places, in the form of Lagrange."""
    total = 0.0
    for k in range(m):
        part = events.sample[k, e]
        for r in range(m):
            if r != k:
                part *= (theta - PLACES[r]) / (PLACES[k] - PLACES[r])
        total += part
    return total


@kernel
def lowest_place(e, low, middle, high, events):
    """Where the parabola through three values of the polynomial is lowest in (low, high); the middle if it is not."""
    m = len(PLACES)
    f_0, f_1, f_2 = polynomial(low, m, e, events), polynomial(middle, m, e, events), polynomial(high, m, e, events)
    bend = f_0 - 2.0 * f_1 + f_2
    theta = middle + 0.25 * (high - low) * (f_0 - f_2) / bend if bend > 0.0 else middle
    return theta if low < theta < high else middle
