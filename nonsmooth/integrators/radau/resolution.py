"""What event functions do between the places of a step at which they are known, and whether that is known well enough.

A body at rest, or one that a load does not move, says nothing of that load: its steps grow without bound, and a load
may rise and fall again within one of them. So the event functions are part of what limits a step. Each is known at the
beginning of the step and at its three stages, and where these four leave a doubt at two places more. The polynomial
P through all six tells where it is low; what the cubic P_3 through the first four is off by at the other two, spread
over the step as w = theta (theta - c_1) (theta - c_2) (theta - 1), bounds the error:

    P(theta) + floor >= DOUBT_OF_CUBIC |w(theta)| max_k |f(theta_k) - P_3(theta_k)| / |w(theta_k)|

Where a function is far from zero, large errors do; near zero the step shrinks until its sign is certain, or until what
is left is below the floor: a thousandth of the relative tolerance of the largest value since the last event, of a gap
the absolute tolerance. Source: Shampine, Thompson, *Comput. Math. Appl.* 39 (2000) 43.
"""

from __future__ import annotations

import math

from nonsmooth.integrators.radau.stages import C
from nonsmooth.jit import kernel
from nonsmooth.numerics.rounding import rounded_sum

# chosen: the beginning of a step, its stages, and two places between them; and their order along the step
NODES, ORDER = (0.0, C[0], C[1], C[2], 0.4, 0.85), (0, 1, 4, 2, 5, 3)
AT_BEGIN, AT_END, EXTRA = 0, 3, 4  # code: places among the nodes


def lagrange(theta: float, places: tuple[float, ...]) -> tuple[float, ...]:
    """What the values at the places contribute at theta to the polynomial through them."""
    return tuple(math.prod((theta - r) / (k - r) for r in places if r != k) for k in places)


def shape(theta: float) -> float:
    """|w(theta)|, which vanishes where the cubic is exact."""
    return abs(math.prod(theta - place for place in NODES[:EXTRA]))


# derived: half way between them
MIDDLES = tuple(0.5 * (NODES[ORDER[a]] + NODES[ORDER[a + 1]]) for a in range(len(ORDER) - 1))
AT_MIDDLES = tuple(lagrange(theta, NODES) for theta in MIDDLES)  # derived: P
SHAPE_AT_MIDDLES = tuple(shape(theta) for theta in MIDDLES)  # derived: |w|
SCALES = tuple(1.0 / math.prod(k - r for r in NODES if r != k) for k in NODES)  # derived: of the products of P
# derived: (f - P_3)/|w| at the two places beside the cubic: weights of the values at the first four
OFF_CUBIC = tuple(tuple(-part / shape(theta) for part in lagrange(theta, NODES[:EXTRA])) for theta in NODES[EXTRA:])
OFF_OWN = tuple(1.0 / shape(theta) for theta in NODES[EXTRA:])  # derived: its own weight
# derived: between the beginning and the stages; weights of the stages in their parabola there, and what the cubic adds
BETWEEN = (0.5 * C[0], 0.5 * (C[0] + C[1]), 0.5 * (C[1] + C[2]))
PARABOLA = tuple(lagrange(theta, C) for theta in BETWEEN)  # derived: weights
BENT = tuple(math.prod(theta - c for c in C) for theta in BETWEEN)  # derived: of the cubic
# derived: weights of the first four values in its third difference
TWIST = tuple(1.0 / math.prod(k - r for r in NODES[:EXTRA] if r != k) for k in NODES[:EXTRA])
# chosen: times what a function varies by at the stages: so far from zero it cannot fall between them
FAR_FROM_ZERO = 4.0
# chosen: of what a function varies by at the stages: if it comes as near to zero its dip is looked at closely
LOW_DIP = 0.25
# chosen: times what the parabola through the stages is off by, which is more than the error of the cubic
CLEAR_OF_PARABOLA = 10.0
# chosen: times the error of the cubic, which is more than that of the polynomial through all places
DOUBT_OF_CUBIC = 4.0
# chosen: of the largest value: a larger error is that of a function that turns more often than it is looked at
FOLLOWED_FUNCTION = 0.05
DIP_FLOOR = 1e-3  # chosen: of rtol, relative to the largest value: lower dips are not looked for
LOAD_ROUNDINGS = 2000  # chosen: of the largest value: what rounding leaves of a force


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
        events.sample[AT_BEGIN, e] = events.sample[AT_END, e]


@kernel
def forget_largest(events):
    """Begin anew with other modes."""
    for e in range(events.armed.shape[0]):
        events.largest[e] = 0.0


@kernel
def is_watched(e, events):
    """Whether a function may fall between the places: it is armed, and was not left below zero by an event that was
    handled."""
    return events.armed[e] == 1 and events.sample[AT_BEGIN, e] >= 0.0


@kernel
def is_clear(events):
    """Whether the stages alone leave no doubt that no function falls between them."""
    for e in range(events.armed.shape[0]):
        f_0, f_1, f_2, f_3 = events.sample[0, e], events.sample[1, e], events.sample[2, e], events.sample[3, e]
        lowest, highest = min(f_0, f_1, f_2, f_3), max(f_0, f_1, f_2, f_3)
        if lowest > FAR_FROM_ZERO * (highest - lowest) or not is_watched(e, events):
            continue
        low = LOW_DIP * (highest - lowest)
        twist = TWIST[0] * f_0 + TWIST[1] * f_1 + TWIST[2] * f_2 + TWIST[3] * f_3
        for k in range(len(BETWEEN)):
            parabola = PARABOLA[k][0] * f_1 + PARABOLA[k][1] * f_2 + PARABOLA[k][2] * f_3
            if not parabola + twist * BENT[k] >= CLEAR_OF_PARABOLA * abs(twist * BENT[k]) + low:
                return False
        if not is_clear_at_vertex(f_1, f_2, f_3, twist, low):
            return False
    return True


@kernel
def is_clear_at_vertex(f_1, f_2, f_3, twist, low):
    """The same where the parabola through the stages is lowest in the step, or at its end."""
    slope = (f_2 - f_1) * (1.0 / (C[1] - C[0]))
    curvature = ((f_3 - f_2) * (1.0 / (C[2] - C[1])) - slope) * (1.0 / (C[2] - C[0]))
    if not curvature > 0.0:
        return f_3 >= low
    theta = min(1.0, max(0.0, 0.5 * (C[0] + C[1] - slope / curvature)))
    parabola = f_1 + (theta - C[0]) * (slope + (theta - C[1]) * curvature)
    off = twist * (theta - C[0]) * (theta - C[1]) * (theta - C[2])
    return parabola + off >= CLEAR_OF_PARABOLA * abs(off) + low


@kernel
def judge_resolution(atol, rtol, events):
    """(Room, place): how many times the error fits between the functions and zero where that is least, 1 or more if
    they are resolved; and the first place in the step where one falls below its floor, 1 if none does."""
    room, first = math.inf, 1.0
    for e in range(events.armed.shape[0]):
        if not is_watched(e, events) or is_constant(e, events):
            continue
        floor = max(DIP_FLOOR * rtol, rounded_sum(LOAD_ROUNDINGS, 1.0)) * events.largest[e]
        if events.is_gap[e] == 1:
            floor = max(floor, atol)
        error = DOUBT_OF_CUBIC * error_of_cubic(e, events)
        for k in range(EXTRA, len(NODES)):
            if events.sample[k, e] < -floor:
                first = min(first, NODES[k])
        most = FOLLOWED_FUNCTION * events.largest[e]
        for a in range(len(MIDDLES)):
            value = middle_value(a, e, events)
            if value < -floor:
                first = min(first, MIDDLES[a])
            room = min(room, room_at(value + floor, most, error * SHAPE_AT_MIDDLES[a], floor))
            theta = lowest_place(a, value, e, events)
            if theta != MIDDLES[a]:
                value = polynomial(theta, e, events)
                if value < -floor:
                    first = min(first, theta)
                off = error * abs(theta * (theta - C[0]) * (theta - C[1]) * (theta - C[2]))
                room = min(room, room_at(value + floor, most, off, floor))
    return room, first


@kernel
def room_at(value, most, off, floor):
    """How many times the error fits between a value and zero; an error below the floor does any number of times."""
    return max(0.0, min(value, most)) / off if off > floor else math.inf


@kernel
def is_constant(e, events):
    """Whether a function has one value at all places."""
    for k in range(1, len(NODES)):
        if events.sample[k, e] != events.sample[AT_BEGIN, e]:
            return False
    return True


@kernel
def error_of_cubic(e, events):
    """max |f - P_3|/|w| at the two places beside its nodes."""
    error = 0.0
    for a in range(len(OFF_OWN)):
        off = OFF_OWN[a] * events.sample[EXTRA + a, e]
        for k in range(EXTRA):
            off += OFF_CUBIC[a][k] * events.sample[k, e]
        error = max(error, abs(off))
    return error


@kernel
def middle_value(a, e, events):
    """The polynomial through all places, in the middle between two."""
    value = 0.0
    for k in range(len(NODES)):
        value += AT_MIDDLES[a][k] * events.sample[k, e]
    return value


@kernel
def polynomial(theta, e, events):
    """The polynomial through all places, in the form of Lagrange."""
    total = 0.0
    for k in range(len(NODES)):
        part = SCALES[k] * events.sample[k, e]
        for r in range(len(NODES)):
            if r != k:
                part *= theta - NODES[r]
        total += part
    return total


@kernel
def lowest_place(a, value, e, events):
    """Where the parabola through two places and the value in their middle is lowest; the middle if not between."""
    half = MIDDLES[a] - NODES[ORDER[a]]
    f_0, f_2 = events.sample[ORDER[a], e], events.sample[ORDER[a + 1], e]
    bend = f_0 - 2.0 * value + f_2
    if not 0.5 * abs(f_0 - f_2) < bend:
        return MIDDLES[a]
    return MIDDLES[a] + 0.5 * half * (f_0 - f_2) / bend
