"""Steps of a scene with compliant contacts, as long as their error allows.

    err = max_b max(|dv_b|, omega_b |dx_b|, omega_b |dxi|) / (atol + rtol |v_b|) <= 1,    omega_b = sqrt(k/m_b)
    |dW| / sum_b m_b |v_b| (atol + rtol |v_b|) <= 1 of the work W of the dampers, which a clipped force does not feel

|v_b| is the largest velocity of a point of the body, omega_b |dx_b| the velocity that has the energy of an elongation
dx_b: so the tolerances follow the stiffness, as those of penalty/options.py do. A new step is h err^(-1/5), no longer
than 1/omega of the lightest body, so that a contact, which lasts pi/omega, is never stepped over, nor than what moves a
body by a quarter of the thinnest one. Where a force has a kink or a jump (landing, the start and the end of a slide)
the estimate sees it, and the step is shortened until it is within the tolerance.

A spring that slides is stretched beyond its slider within a step and cut back at the end. Where the slide ends within
the step, what it went too far is an error of its own, |dxi|.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import Annotated as Array

from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.drive_rows import Drives
from nonsmooth.integrators.assembly.pairs import Pairs
from nonsmooth.integrators.assembly.progress import (
    DONE,
    LOST,
    MORE_BOOKS,
    MORE_CONTACTS,
    MORE_PAIRS,
    NO_FRICTION,
    Counts,
    Figures,
)
from nonsmooth.integrators.springs.blocks import DAMPING_WORK, ELASTIC_ENERGY, N_COLUMNS, Books, SpringPlaces, Stages
from nonsmooth.integrators.springs.exchange import book_exchanges, write_exchange
from nonsmooth.integrators.springs.held import Row, note_stops
from nonsmooth.integrators.springs.law import Law, Springs
from nonsmooth.integrators.springs.rates import (
    FIRST_WITHOUT_LAW,
    NO_ROOM_FOR_SPRINGS,
    given_power,
    held_energy,
    is_held,
    turn_least,
    write_rates,
)
from nonsmooth.integrators.springs.table import EMBEDDED_ORDER, LAST_STAGE, STAGE_NODES, STAGES, error_sum, stage_sum
from nonsmooth.jit import in_dimensions, kernel
from nonsmooth.jit.blocks import Block, Floats, view
from nonsmooth.scenes.detection import NOT_FINITE, Found

# code: how a run of steps comes back, as those of assembly/progress.py are; at a stage whose forces are functions
VANISHED, ASKS = 7, 40
ASKS_FORCES = -(2**59)  # code: as a number of contacts
SAFETY, LEAST_CHANGE, MOST_CHANGE = 0.9, 0.2, 5.0  # chosen: of the next step
SHORTEST = 1e-9  # chosen: of the longest step: no jump of a force needs less, but one that comes again and again does
WAY_SHARE = 0.25  # chosen: of the thinnest body, that the fastest may move in a step
LEAST_ENERGY = 2.0**-1022  # defined: the least normal double: an energy of bodies that do not move [J]


class Scales(Block):
    """What errors are measured by."""

    rtol: float
    atol: float  # [m/s]
    longest: float  # step [s]
    thinnest: float  # body [m]
    reach: Array[Floats, "n_b"]  # of a body about its centre of mass [m]
    omega: Array[Floats, "n_b"]  # [1/s]


class Course(Block):
    """Where a run is."""

    places: SpringPlaces
    counts: Counts
    figures: Figures
    t: float  # [s]
    target: float  # to which the run goes [s]
    h: float  # the step that is tried next [s]
    shortest_h: float  # of the steps taken, those that ended at a record apart [s]
    longest_h: float
    rejected: int
    is_warm: int  # whether the rates at the present state are known
    wanted: int  # of what there was no room for
    tried: float  # the step at hand [s]
    is_cut: int  # whether the target cuts it
    is_begun: int
    stage: int  # of it
    asks: int  # whether forces are functions
    asked: float  # the time at which they are wanted [s]
    is_told: int  # whether they were asked for this stage


@in_dimensions("int64(int64, int64)")
def take_spring_steps(course_at, most, d):
    """Go on to the target, in so many steps at most; DONE or why not."""
    course = view(course_at, Course)
    scales = view(course.places.scales, Scales)
    taken = 0
    while taken < most and course.t < course.target:
        if course.is_begun == 0:
            h, is_cut = next_step(course, scales, view(course.places.bodies, Bodies), d)
            if h < SHORTEST * scales.longest or course.t + h == course.t:
                if not is_cut:
                    return VANISHED
            if has_no_room_for_pairs(course):
                return MORE_BOOKS
            begin_step(course, h, is_cut)
        h, is_cut = course.tried, course.is_cut == 1
        n_c = try_step(course, h, d)
        if n_c == ASKS_FORCES:
            return ASKS
        course.is_begun = 0
        if FIRST_WITHOUT_LAW >= n_c > 2 * FIRST_WITHOUT_LAW:
            course.wanted = FIRST_WITHOUT_LAW - n_c
            return NO_FRICTION
        if n_c == NO_ROOM_FOR_SPRINGS or n_c > view(course.places.found, Found).gap.shape[0]:
            course.wanted = max(n_c, view(course.places.found, Found).gap.shape[0])
            return MORE_CONTACTS
        if n_c < 0 and n_c != NOT_FINITE:
            course.wanted = -n_c
            return MORE_PAIRS
        error = inf if n_c == NOT_FINITE else error_of(course.places, h, d)
        change = LEAST_CHANGE
        if error < inf:
            change = max(LEAST_CHANGE, min(MOST_CHANGE, SAFETY * max(error, 1e-10) ** (-1.0 / EMBEDDED_ORDER)))
        if error <= 1.0:
            accept(course, h, d)
            course.t = course.target if is_cut and h >= course.target - course.t else course.t + h
            course.h = max(course.h, change * h) if is_cut else change * h
            if not is_cut:
                course.shortest_h = h if course.shortest_h == 0.0 else min(course.shortest_h, h)
                course.longest_h = max(course.longest_h, h)
            taken += 1
        else:
            go_back(course.places, d)
            if course.is_warm == 0 and n_c == NOT_FINITE:
                return LOST
            course.rejected += 1
            course.h = min(change, SAFETY) * h
    return DONE


@kernel
def has_no_room_for_pairs(course):
    """Whether a step might book more pairs than there is room for: each of its springs another one."""
    pairs, springs = view(course.places.pairs, Pairs), view(course.places.springs, Springs)
    course.wanted = pairs.count + springs.key_before.shape[0]
    return pairs.is_asked == 1 and course.wanted > pairs.i.shape[0]


@kernel
def next_step(course, scales, bodies, d):
    """The length of the next step, and whether the target cuts it."""
    h = min(course.h, scales.longest)
    v, fastest = bodies.motion.v, 0.0
    for b in range(v.shape[0]):
        square = 0.0
        for k in range(d):
            square += v[b, k] * v[b, k]
        fastest = max(fastest, square)
    if fastest > 0.0:
        h = min(h, WAY_SHARE * scales.thinnest / sqrt(fastest))
    rest = course.target - course.t
    if rest <= h * (1.0 + 1e-9):
        return rest, True
    return (0.5 * rest, True) if rest < 2.0 * h else (h, False)


@kernel
def begin_step(course, h, is_cut):
    """Begin a step of a length, from the state at hand."""
    course.tried, course.is_cut, course.is_begun = h, 1 if is_cut else 0, 1
    course.stage, course.is_told = course.is_warm, 0
    bodies, springs = view(course.places.bodies, Bodies), view(course.places.springs, Springs)
    motion = bodies.motion
    for b in range(bodies.mass.shape[0]):
        for k in range(motion.x.shape[1]):
            bodies.x_0[b, k] = motion.x[b, k]
        for k in range(motion.v.shape[1]):
            bodies.v_0[b, k] = motion.v[b, k]
    for at in range(springs.n_before):
        springs.excess[at] = 0.0


@kernel
def try_step(course, h, d):
    """The stages of a step, or those that are left; the number of contacts at its end, or the code that ended it."""
    places, n_c = course.places, 0
    bodies, stages = view(places.bodies, Bodies), view(places.rates, Stages)
    for s in range(course.stage, STAGES):
        if course.is_told == 0:
            if s > 0:
                set_stage(bodies, stages, s, h, d)
            if course.asks == 1:
                course.stage, course.asked = s, course.t + STAGE_NODES[s] * h
                return ASKS_FORCES
        course.is_told = 0
        n_c = write_rates(places, s, h, d)
        if n_c < 0 or n_c > view(places.found, Found).gap.shape[0]:
            go_back(places, d)
            return n_c
        course.is_warm = 1
    return n_c


@kernel
def set_stage(bodies, stages, s, h, d):
    """The state of stage s; quaternions are of unit length."""
    x, v = bodies.motion.x, bodies.motion.v
    for b in range(bodies.mass.shape[0]):
        for k in range(x.shape[1]):
            x[b, k] = bodies.x_0[b, k] + h * stage_sum(stages.x, s, b, k)
        for k in range(v.shape[1]):
            v[b, k] = bodies.v_0[b, k] + h * stage_sum(stages.v, s, b, k)
        if d == 3:
            scale = 1.0 / sqrt(x[b, 3] * x[b, 3] + x[b, 4] * x[b, 4] + x[b, 5] * x[b, 5] + x[b, 6] * x[b, 6])
            x[b, 3], x[b, 4], x[b, 5], x[b, 6] = scale * x[b, 3], scale * x[b, 4], scale * x[b, 5], scale * x[b, 6]


@kernel
def go_back(places, d):
    """To the state at the beginning of the step."""
    bodies = view(places.bodies, Bodies)
    for b in range(bodies.mass.shape[0]):
        for k in range(bodies.motion.x.shape[1]):
            bodies.motion.x[b, k] = bodies.x_0[b, k]
        for k in range(bodies.motion.v.shape[1]):
            bodies.motion.v[b, k] = bodies.v_0[b, k]


@kernel
def speed_of(v, b, reach, d):
    """No less than the velocity of any point of a body [m/s]."""
    size, spin = 0.0, 0.0
    for k in range(v.shape[1]):
        if k < d:
            size += v[b, k] * v[b, k]
        else:
            spin += v[b, k] * v[b, k]
    return sqrt(size) + reach * sqrt(spin)


@kernel
def error_of(places, h, d):
    """The estimated error of a step, in its tolerances."""
    bodies, stages, scales = view(places.bodies, Bodies), view(places.rates, Stages), view(places.scales, Scales)
    worst, energy = 0.0, 0.0
    for b in range(bodies.mass.shape[0]):
        if bodies.motion.moves[b] == 1:
            reach = scales.reach[b]
            allowed = tolerance(bodies, scales, b, d)
            energy += bodies.mass[b] * allowed * (allowed - scales.atol) / scales.rtol
            for k in range(stages.v.shape[2]):
                worst = larger(worst, abs(h * error_sum(stages.v, b, k)) * (1.0 if k < d else reach) / allowed)
            for k in range(stages.x.shape[2]):
                arm = 1.0 if k < d else reach if d == 2 else 2.0 * reach
                worst = larger(worst, scales.omega[b] * abs(h * error_sum(stages.x, b, k)) * arm / allowed)
    lost = abs(h * error_sum(stages.work, 0, DAMPING_WORK))
    if lost > 0.0:
        worst = larger(worst, lost / max(energy, LEAST_ENERGY))
    return larger(worst, spring_error(places, h, d))


@kernel
def larger(worst, error):
    """The larger one; what is no number is infinite."""
    return max(worst, error) if error < inf else inf


@kernel
def tolerance(bodies, scales, b, d):
    """Of the velocities of a body [m/s]."""
    reach = scales.reach[b]
    return scales.atol + scales.rtol * max(speed_of(bodies.v_0, b, reach, d), speed_of(bodies.motion.v, b, reach, d))


@kernel
def spring_error(places, h, d):
    """Of the tangential springs: the estimate, and what went beyond a slider before it came to rest again."""
    bodies, network, scales = view(places.bodies, Bodies), view(places.network, Network), view(places.scales, Scales)
    law, springs = view(places.law, Law), view(places.springs, Springs)
    worst = 0.0
    if law.is_regularised == 1:
        return worst
    for c in range(network.n_c):
        at, error, size = springs.source[c], 0.0, 0.0
        for k in range(d):
            part = h * error_sum(springs.rate, at, k)
            error += part * part
            size += springs.stretch[c, k] * springs.stretch[c, k]
        over = sqrt(size) - network.mu[c] * abs(network.P[c, 0]) / (law.ratio * law.k)
        error = sqrt(error) if over < 0.0 else 0.0  # of one that slides the elongation is its limit
        error += max(0.0, springs.excess[at] - max(over, 0.0))
        i, j = network.i[c], network.j[c]
        if bodies.motion.moves[i] == 1:
            worst = larger(worst, scales.omega[i] * error / tolerance(bodies, scales, i, d))
        if bodies.motion.moves[j] == 1:
            worst = larger(worst, scales.omega[j] * error / tolerance(bodies, scales, j, d))
    return worst


@kernel
def accept(course, h, d):
    """The end of the step becomes the beginning of the next one."""
    places = course.places
    network, found, law = view(places.network, Network), view(places.found, Found), view(places.law, Law)
    stages, springs, books = view(places.rates, Stages), view(places.springs, Springs), view(places.ledger, Books)
    for column in range(N_COLUMNS):
        books.work[column] += h * stage_sum(stages.work, LAST_STAGE, 0, column)
        stages.work[0, 0, column] = stages.work[LAST_STAGE, 0, column]
    if springs.is_asked == 1:
        book_exchanges(places.shapes, places.springs, places.pairs, h)
    for c in range(network.n_c):
        slide_back(network, found, law, springs, c, d)
    books.work[ELASTIC_ENERGY] = held_energy(law, found, network, springs)
    if is_held(places):
        books.work[ELASTIC_ENERGY] += view(places.row, Row).elastic
        note_stops(view(places.drives, Drives), view(places.bodies, Bodies).motion.x)
    springs.n_before = network.n_c
    deepest = 0.0
    for c in range(network.n_c):
        deepest = min(deepest, found.gap[c])
        springs.key_before[c] = springs.next_key[c]
        for k in range(d):
            springs.point_before[c, k], springs.normal_before[c, k] = found.point[c, k], found.normal[c, k]
            springs.xi[c, k], springs.rate[0, c, k] = springs.next_xi[c, k], springs.next_rate[c, k]
        if springs.is_asked == 1:
            given = given_power(view(places.bodies, Bodies), network, c, d, 3 * (d - 1))
            write_exchange(network, springs, 0, c, c, d, given)
    for b in range(stages.v.shape[1]):
        for k in range(stages.v.shape[2]):
            stages.v[0, b, k] = stages.v[LAST_STAGE, b, k]
        for k in range(stages.x.shape[2]):
            stages.x[0, b, k] = stages.x[LAST_STAGE, b, k]
    note(course, -deepest, network.n_c)


@kernel
def slide_back(network, found, law, springs, c, d):
    """The spring of contact c in the next step: within its slider, in the axes of the new normal."""
    at, size = springs.source[c], 0.0
    for k in range(d):
        size += springs.stretch[c, k] * springs.stretch[c, k]
    size, limit, scale = sqrt(size), network.mu[c] * abs(network.P[c, 0]), 1.0
    if law.is_regularised == 1:
        scale = 0.0
    elif law.ratio * law.k * size > limit:
        scale = limit / (law.ratio * law.k * size)
    springs.next_key[c] = found.key[c]
    for k in range(d):
        springs.next_xi[c, k] = scale * springs.stretch[c, k]
        springs.next_rate[c, k] = springs.rate[LAST_STAGE, at, k]
    if d == 3:
        a, b, r = springs.normal_before, found.normal, springs.rate
        r_0, r_1, r_2 = turn_least(
            (a[at, 0], a[at, 1], a[at, 2]),
            (b[c, 0], b[c, 1], b[c, 2]),
            (r[LAST_STAGE, at, 0], r[LAST_STAGE, at, 1], r[LAST_STAGE, at, 2]),
        )
        springs.next_rate[c, 0], springs.next_rate[c, 1], springs.next_rate[c, 2] = r_0, r_1, r_2


@kernel
def note(course, depth, n_c):
    """The figures of a step."""
    counts, figures = course.counts, course.figures
    counts.steps += 1
    counts.most_contacts = max(counts.most_contacts, n_c)
    figures.last_penetration = depth
    figures.penetration = max(figures.penetration, depth)
    figures.since_penetration = max(figures.since_penetration, depth)
