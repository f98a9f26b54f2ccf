"""What follows an event of contacts with friction in two directions.

1. Contacts that approach are struck. One that G couples to no other by Newton's law with the exact cone, or by its own
   along the hodograph (mechanics/impact_in_space.py); several coupled ones by Newton's law, in one problem.
2. Of a contact that is coupled to no other all answers are known. One that slides goes on where p > 0 > b_N, opens
   where b_N >= 0, and where p <= 0 > b_N it is stopped by the impact without collision, then judged again. One that
   rests takes one of all solutions of the round cone (contact/spatial/all_solutions.py) as a stiff contact does: what
   has stuck sticks if it can; else it opens, slides off along the d of a slide that is no saddle, or sticks.
3. Coupled contacts take one solution of their problem in a step so short that only speeds change in it which count as
   none. They are given a compliance of a millionth, so that redundant ones share their load as equal springs do, and
   what one at its limit of friction cannot hold is given to others.

A bounce lower than atol [m], or than the rounding of a gap, is given up, with the friction that belongs to it.
Source: Pfeiffer, Glocker (1996), chapter 5; docs/theory/event_driven.md.
"""

from __future__ import annotations

import math

from nonsmooth.contact.islands import find_islands
from nonsmooth.contact.planar.single import FREE
from nonsmooth.contact.spatial.all_solutions import SLIDE, is_saddle, list_solutions
from nonsmooth.errors import Status
from nonsmooth.integrators.event_driven.space_coupled import decide_coupled
from nonsmooth.integrators.event_driven.space_hold import find_gaps, give, hold
from nonsmooth.integrators.event_driven.space_impacts import lose_slide, strike_all, take_block
from nonsmooth.integrators.event_driven.space_motion import (
    BOUNCES,
    FORCELESS,
    STAYS,
    TO_DECIDE,
    WITH_FRICTION,
    SpaceContacts,
    decompose,
    is_alone,
    list_closed,
    list_equations,
    regularise,
    solve_equations,
    space_forces,
    take_course,
)
from nonsmooth.integrators.penalty.rates import length_along
from nonsmooth.integrators.penalty.switching import note_speed
from nonsmooth.integrators.radau.events import NO_EVENT
from nonsmooth.integrators.radau.located import AT_START
from nonsmooth.integrators.records import (
    CLOSURE,
    FRICTION,
    INCONSISTENT,
    INDETERMINATE,
    MODE_CHANGE,
    N_FUNCTIONS,
    State,
    append_event,
)
from nonsmooth.integrators.rigid.modes import DISTINCT_ROWS, EVERY, SINGULAR_SLIDE, rounded_length, small_speed
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.laws import (
    LAW_E_N,
    friction_coefficient,
    static_coefficient,
)
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import ContactMode

MOST_TRIALS = 16  # chosen: impacts without collision, and bounces that are given up, at one instant
LOWEST_BOUNCE = 4.0  # chosen: roundings of a gap: of a lower bounce no end is seen
# chosen: events that change no mode in a row, in such a part of the time, after which a run does not go on: a share of
# redundant contacts that leaves its cones at once again
MOST_REPEATS, NO_PROGRESS = 1000, 1e-3


@rare_kernel("int64(int64, float64, int64, float64[::1], int64, int64)", short_loops=True)
def switch_in_space(sys_at, t, event, x, state_at, contacts_at):
    """The impacts and the modes that follow an event; returns a Status."""
    sys, state, c = view(sys_at, Sys), view(state_at, State), view(contacts_at, SpaceContacts)
    at, what = (event // N_FUNCTIONS, event % N_FUNCTIONS) if event >= 0 else (-1, NO_EVENT)
    status = begin_event(sys_at, t, event, at, what, x, state, c)
    if status != Status.RUNNING:
        return status
    closes = what == CLOSURE and c.was[at] == ContactMode.OPEN
    if what == CLOSURE and not closes:
        c.mode[at] = ContactMode.OPEN.value
        return end_event(sys, t, x, state, c)
    lets_go = what == FRICTION and c.was[at] == ContactMode.STICK
    if lets_go and lets_one_go(sys_at, t, at, x, c):
        return end_event(sys, t, x, state, c)
    status = strike_all(sys_at, t, x, state, c)
    if status != Status.RUNNING:
        return status
    if what == FRICTION or what == FORCELESS or closes:
        c.open_case[at] = TO_DECIDE if c.open_case[at] == STAYS else c.open_case[at]
    for _ in range(MOST_TRIALS):
        status = decide_all(sys_at, t, at, what, x, state, c)
        if status != Status.RUNNING:
            return status
        if not give_up_low(sys_at, t, x, c):
            status = take_off_bounces(sys_at, t, x, c)
            return end_event(sys, t, x, state, c) if status == Status.RUNNING else status
    return Status.CHATTERING.value


@kernel
def begin_event(sys_at, t, event, at, what, x, state, c):
    """Find what touches, and forces and velocities before the event; returns a Status."""
    sys = view(sys_at, Sys)
    list_closed(sys, x, c)
    if not find_gaps(sys, t, x, c):
        return Status.NOT_FINITE.value
    length = rounded_length(sys.n_q, c)
    for i in range(sys.n_c):
        c.stuck[i] = 1 if c.mode[i] == ContactMode.STICK else 0
        c.open_case[i], c.kind[i], c.found[i], c.late[i], c.touches[i] = STAYS, MODE_CHANGE, 1, 0.0, 0
        for a in range(c.P.shape[1]):
            c.P[i, a] = 0.0
        if event == AT_START:
            c.mode[i] = ContactMode.OPEN.value
        if c.mode[i] == ContactMode.OPEN and (c.work.g_N[i] <= length or (i == at and what == CLOSURE)):
            c.touches[i] = 1
            c.open_case[i] = TO_DECIDE if event == AT_START else STAYS
    c.numbers.flight = math.inf
    status = space_forces(sys_at, t, x, address(c))
    if status != Status.RUNNING:
        return status
    for i in range(sys.n_c):
        for a in range(c.la.shape[1]):
            c.before[i, a], c.share[i, a] = c.gamma[i, a], c.la[i, a]
    note_speed(sys, c)
    return status


@kernel
def lets_one_go(sys_at, t, i, x, c):
    """Let contact i, which stuck until now, slide against the force that held it; whether that is the whole event. One
    that is coupled to no other is decided with all its answers."""
    n_k, pull, is_coupled = c.work.n, length_along(c.la, i), False
    if c.is_shared[i] == 1:
        return False
    c.course[i, 0], c.course[i, 1] = -c.la[i, 1] / pull, -c.la[i, 2] / pull
    find_islands(n_k, c.work.start, c.work.G, c.island)
    for k in range(n_k):
        is_coupled = is_coupled or (c.work.closed[k] == i and not is_alone(k, n_k, c))
    if not is_coupled:
        return False
    c.mode[i] = ContactMode.SLIDE.value
    if space_forces(sys_at, t, x, address(c)) == Status.RUNNING and c.p[i] > 2.0 * SINGULAR_SLIDE:
        return True
    c.mode[i] = ContactMode.STICK.value
    return False


@kernel
def spread(n_k, c):
    """Let all closed contacts of an island be decided where one of them is."""
    closed = c.work.closed
    for k in range(n_k):
        for m in range(n_k):
            if c.island[m] == c.island[k] and c.open_case[closed[k]] == TO_DECIDE and c.open_case[closed[m]] == STAYS:
                c.open_case[closed[m]] = TO_DECIDE


@kernel
def decide_all(sys_at, t, at, what, x, state, c):
    """Decide the modes of the contacts that are undecided; returns a Status."""
    sys, work = view(sys_at, Sys), c.work
    for _ in range(MOST_TRIALS):
        status = space_forces(sys_at, t, x, address(c))
        if status != Status.RUNNING:
            return status
        n_k, speed, is_joint, is_lost = work.n, small_speed(sys, c), False, False
        find_islands(n_k, work.start, work.G, c.island)
        spread(n_k, c)
        for k in range(n_k):
            i = work.closed[k]
            if c.open_case[i] != TO_DECIDE:
                continue
            if not is_alone(k, n_k, c):
                is_joint = True
                continue
            if c.kind[i] == INCONSISTENT and c.gamma[i, 0] > speed:
                c.mode[i], c.open_case[i] = ContactMode.OPEN.value, STAYS
                continue
            event = what if i == at and c.kind[i] != INCONSISTENT else NO_EVENT
            mode, several = find_mode(sys, k, event, speed, c)
            if mode < 0:
                if not lose_slide(sys, k, n_k, x, state, c):
                    return Status.NO_SOLUTION.value
                is_lost = True
                break
            if several > 1 and c.kind[i] == MODE_CHANGE:
                c.kind[i], c.found[i] = INDETERMINATE, several
            state.counters.several += 1 if several > 1 else 0
            c.mode[i], c.open_case[i] = mode, STAYS
        if is_joint and not is_lost:
            status, is_lost = decide_coupled(sys_at, t, n_k, speed, x, state, c)
        if status != Status.RUNNING or not is_lost:
            return status
    return Status.CHATTERING.value


@kernel
def find_mode(sys, k, event, speed, c):
    """(mode, number of solutions) of closed contact k, which touches, gamma_N = 0, and is coupled to no other; the mode
    is -1 where it slides without force. The course of a slide is written."""
    work, i, first = c.work, c.work.closed[k], c.work.start[k]
    b_N, G_NN = work.c[first], work.G[first, first]
    if work.start[k + 1] - first == 1:
        return (ContactMode.OPEN.value if b_N >= 0.0 else ContactMode.LOCKED.value), 1
    stop_below = max(c.numbers.v_stop, speed)
    is_arrested = event == FRICTION and c.was[i] == ContactMode.SLIDE
    lets_go = event == FRICTION and not is_arrested
    if lets_go or length_along(c.gamma, i) > (2.0 if is_arrested else 1.0) * stop_below:
        if not lets_go:
            take_course(i, c)
        mu = friction_coefficient(sys.laws, i, length_along(c.gamma, i))
        p = G_NN - mu * (work.G[first, first + 1] * c.course[i, 0] + work.G[first, first + 2] * c.course[i, 1])
        has_force = event != FORCELESS and p > 2.0 * SINGULAR_SLIDE * G_NN
        if b_N >= 0.0:
            return ContactMode.OPEN.value, 1 if has_force else 2
        return (ContactMode.SLIDE.value, 1) if has_force else (-1, 0)
    mu, answers = friction_coefficient(sys.laws, i, 0.0), take_block(k, c)
    found = list_solutions(answers.G, 0, answers.c, mu, static_coefficient(sys.laws, i), answers)
    best, least, slides = -1, math.inf, 0
    for m in range(found):
        rank = 1.0 if answers.modes[m] == FREE else 0.0 if c.stuck[i] == 1 else 3.0
        if answers.modes[m] == SLIDE:
            rank = 4.0 if is_saddle(answers.G, 0, answers.c, mu, answers.alphas[slides]) else 2.0
            slides += 1
        if rank < least:
            best, least = m, rank
    if best < 0:
        return -1, 0
    if answers.modes[best] != SLIDE:
        return (ContactMode.OPEN.value if answers.modes[best] == FREE else ContactMode.STICK.value), found
    size = math.hypot(answers.P[best, 1], answers.P[best, 2])
    c.course[i, 0], c.course[i, 1] = -answers.P[best, 1] / size, -answers.P[best, 2] / size
    return ContactMode.SLIDE.value, found


@kernel
def give_up_low(sys_at, t, x, c):
    """Let the contacts that bounce lower than atol be decided as closed ones; whether there are some."""
    sys, work, bounces = view(sys_at, Sys), c.work, False
    for i in range(sys.n_c):
        bounces = bounces or c.open_case[i] == BOUNCES
    if not bounces or space_forces(sys_at, t, x, address(c)) != Status.RUNNING:
        return False
    has_low, n_k, low = False, work.n, max(c.numbers.atol, LOWEST_BOUNCE * rounded_length(sys.n_q, c))
    for k in range(n_k):
        i, a = work.closed[k], work.start[k]
        if c.open_case[i] != BOUNCES:
            continue
        v, fall, e = c.gamma[i, 0], work.c[a], sys.laws[i, LAW_E_N]
        for m in range(n_k):
            for b in range(work.start[m], work.start[m + 1]):
                fall += work.G[a, b] * c.la[work.closed[m], b - work.start[m]]
        if fall < 0.0 and v * v < -2.0 * fall * low and e < 1.0:
            c.late[i], c.open_case[i], has_low = -2.0 * v / (fall * (1.0 - e)), TO_DECIDE, True
        elif fall < 0.0:
            c.numbers.flight = min(c.numbers.flight, -2.0 * v / fall)
    return has_low


@kernel
def take_off_bounces(sys_at, t, x, c):
    """Take off the velocities with which low bounces begin, with the friction that belongs to their impulses; returns a
    Status."""
    sys, work, is_given = view(sys_at, Sys), c.work, False
    for i in range(sys.n_c):
        is_given = is_given or (c.late[i] > 0.0 and c.mode[i] != ContactMode.OPEN)
    status = space_forces(sys_at, t, x, address(c)) if is_given else Status.RUNNING.value
    if not is_given or status != Status.RUNNING:
        return status
    n_k = work.n
    for a in range(work.start[n_k]):
        work.P[a] = 0.0
    m = list_equations(WITH_FRICTION, EVERY, n_k, c)
    for e in range(m):
        c.b[e], c.z[e] = -work.gamma_0[c.row[e]], 0.0
    if decompose(m, WITH_FRICTION, c) < DISTINCT_ROWS and m > 1:
        regularise(m, c)
    solve_equations(m, c)
    for e in range(m):
        i = c.contact[e]
        work.P[c.row[e]] = c.z[e]
        if c.mode[i] == ContactMode.SLIDE:
            for a in range(2):
                work.P[c.row[e] + 1 + a] = -c.mu[i] * c.z[e] * c.way[i, a]
    give(sys, True, n_k, x, c)
    return status


@kernel
def end_event(sys, t, x, state, c):
    """Hold the state to the new modes, and append the events, unless they are of a start without one; NOT_SOLVED where
    redundant contacts have the same modes many times in a row, at next to one moment."""
    for i in range(sys.n_c):
        c.touches[i] = 0
        if c.mode[i] == ContactMode.OPEN:
            for a in range(c.share.shape[1]):
                c.share[i, a] = 0.0
    status, is_same, is_shared = hold(sys, t, x, c), True, False
    for i in range(sys.n_c):
        is_same = is_same and c.mode[i] == state.mode[i] and c.kind[i] == MODE_CHANGE
        is_shared = is_shared or c.is_shared[i] == 1
    is_same = is_same and is_shared
    c.repeats = c.repeats + 1 if is_same else 0
    c.numbers.changed = c.numbers.changed if is_same else t
    if c.repeats > MOST_REPEATS and t - c.numbers.changed < NO_PROGRESS * abs(t):
        return Status.NOT_SOLVED.value
    for i in range(sys.n_c):
        event, kind, mode = state.event, c.kind[i], c.mode[i]
        has_changed, is_start = mode != state.mode[i], state.counters.steps == 0 and kind == MODE_CHANGE
        if (has_changed or kind != MODE_CHANGE) and not is_start:
            event.P_N, event.P_F = c.P[i, 0], length_along(c.P, i)
            event.gamma_N, event.gamma_F, event.solutions = c.before[i, 0], length_along(c.before, i), c.found[i]
            append_event(t + c.late[i], kind, i, state.mode[i], state.slip[i], mode, c.slip[i], state)
        state.mode[i], state.slip[i] = mode, c.slip[i]
    return status
