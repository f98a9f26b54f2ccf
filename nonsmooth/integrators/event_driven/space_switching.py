"""What follows an event of one contact with friction in two directions.

1. A contact that approaches is struck, by Newton's law with the exact cone, or by its own along the hodograph
   (mechanics/impact_in_space.py).
2. One that slides goes on where p > 0 > b_N, opens where b_N >= 0, and where p <= 0 > b_N it is stopped by the impact
   without collision, then judged again.
3. One that rests takes one of all solutions of the round cone (contact/spatial/all_solutions.py) as a stiff contact
   does: what has stuck sticks if it can; else it opens, slides off along the d of a slide that is no saddle, or sticks.

A bounce lower than atol [m] is given up, with the friction that belongs to it.
Source: Pfeiffer, Glocker (1996), chapter 5; docs/theory/event_driven.md.
"""

from __future__ import annotations

import math

from nonsmooth.contact.planar.single import FREE
from nonsmooth.contact.spatial.all_solutions import SLIDE, is_saddle, list_solutions
from nonsmooth.errors import Status
from nonsmooth.integrators.event_driven.space_motion import FORCELESS, SpaceContact, give, hold, space_forces, stop
from nonsmooth.integrators.moreau_jean.energy_gain import note_gains
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.integrators.penalty.rates import length_along
from nonsmooth.integrators.penalty.switching import follow_slide, note_speed
from nonsmooth.integrators.radau.events import NO_EVENT
from nonsmooth.integrators.radau.located import AT_START
from nonsmooth.integrators.records import (
    CLOSURE,
    FRICTION,
    IMPACT,
    INCONSISTENT,
    INDETERMINATE,
    MODE_CHANGE,
    State,
    append_event,
)
from nonsmooth.integrators.rigid.modes import SINGULAR_SLIDE, rounded_length, small_speed
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.impact import follows_own_law
from nonsmooth.mechanics.impact_in_space import collide_in_space, lose
from nonsmooth.mechanics.laws import (
    LAW_E_N,
    LAW_IMPACT,
    friction_coefficient,
    static_coefficient,
)
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP, ContactMode
from nonsmooth.numerics.rounding import rounded_sum

MOST_TRIALS = 16  # chosen: impacts without collision at one instant


@rare_kernel("int64(int64, float64, int64, float64[::1], int64, int64)", short_loops=True)
def switch_in_space(sys_at, t, event, x, state_at, contacts_at):
    """The impacts and the mode that follow an event; returns a Status."""
    sys, state, c = view(sys_at, Sys), view(state_at, State), view(contacts_at, SpaceContact)
    numbers, is_open = c.numbers, c.mode[0] == ContactMode.OPEN or event == AT_START
    state.mode[0], state.slip[0], kind, found = c.mode[0], c.slip[0], MODE_CHANGE, 1
    numbers.flight, numbers.late = math.inf, 0.0
    is_held = not is_open or event == CLOSURE
    has_stuck = c.mode[0] == ContactMode.STICK
    leaves, lets_go = not is_open and event == CLOSURE, has_stuck and event == FRICTION
    for a in range(3):
        c.P[0, a] = 0.0
    status = space_forces(sys_at, t, x, contacts_at)
    if status != Status.RUNNING:
        return status
    pull = length_along(c.la, 0)
    for a in range(3):
        c.before[0, a] = c.gamma[0, a]
    note_speed(sys, c)
    if not evaluate(sys, GAP, t, c.q, c.u, c.work.g_N):
        return Status.NOT_FINITE.value
    speed = small_speed(sys, c)
    if leaves or not (is_held or c.work.g_N[0] <= rounded_length(sys.n, c)):
        return end_event(sys, t, kind, found, ContactMode.OPEN.value, x, state, c)
    if lets_go:
        c.course[0, 0], c.course[0, 1] = -c.la[0, 1] / pull, -c.la[0, 2] / pull
    if c.gamma[0, 0] < -speed:
        kind, found = IMPACT, strike(sys, False, x, state, c)
        if found == 0:
            return Status.NO_SOLUTION.value
        status = space_forces(sys_at, t, x, contacts_at)
        if status != Status.RUNNING:
            return status
    v, fall, bounce = c.gamma[0, 0], c.work.c[0], 0.0
    if v > speed:
        is_low = kind == IMPACT and fall < 0.0 and v * v < -2.0 * fall * numbers.atol and sys.laws[0, LAW_E_N] < 1.0
        if not is_low:
            if fall < 0.0:
                numbers.flight = -2.0 * v / fall
            return end_event(sys, t, kind, found, ContactMode.OPEN.value, x, state, c)
        numbers.late, bounce = -2.0 * v / (fall * (1.0 - sys.laws[0, LAW_E_N])), v
    for _ in range(MOST_TRIALS):
        mode, several = find_mode(sys, event, lets_go, has_stuck, speed, c)
        if mode >= 0:
            if several > 1 and kind == MODE_CHANGE:
                kind, found = INDETERMINATE, several
            state.counters.several += 1 if several > 1 else 0
            c.mode[0] = mode
            if bounce > 0.0 and mode != ContactMode.OPEN:
                give_up(sys, x, c)
            return end_event(sys, t, kind, found, mode, x, state, c)
        lets_go, has_stuck, event, kind, found = False, True, NO_EVENT, INCONSISTENT, 0
        if strike(sys, True, x, state, c) == 0:
            return Status.NO_SOLUTION.value
        status = space_forces(sys_at, t, x, contacts_at)
        if status != Status.RUNNING:
            return status
        if c.gamma[0, 0] > speed:
            return end_event(sys, t, kind, found, ContactMode.OPEN.value, x, state, c)
    return Status.CHATTERING.value


@kernel
def find_mode(sys, event, lets_go, has_stuck, speed, c):
    """(mode, number of solutions) of a contact that touches, gamma_N = 0; the mode is -1 where it slides without
    force. The course of a slide is written."""
    work, answers = c.work, c.answers
    stop_below = max(c.numbers.v_stop, speed)
    mu_static, is_arrested = static_coefficient(sys.laws, 0), event == FRICTION and not lets_go
    if lets_go or length_along(c.gamma, 0) > (2.0 if is_arrested else 1.0) * stop_below:
        if not lets_go:
            take_course(c)
        mu = friction_coefficient(sys.laws, 0, length_along(c.gamma, 0))
        p = work.G[0, 0] - mu * (work.G[0, 1] * c.course[0, 0] + work.G[0, 2] * c.course[0, 1])
        has_force = event != FORCELESS and p > 2.0 * SINGULAR_SLIDE * work.G[0, 0]
        if work.c[0] >= 0.0:
            return ContactMode.OPEN.value, 1 if has_force else 2
        return (ContactMode.SLIDE.value, 1) if has_force else (-1, 0)
    mu = friction_coefficient(sys.laws, 0, 0.0)
    found = list_solutions(answers.G, 0, work.c, mu, mu_static, answers)
    best, rank, slides = -1, math.inf, 0
    for m in range(found):
        of = 1.0 if answers.modes[m] == FREE else 0.0 if has_stuck else 3.0
        if answers.modes[m] == SLIDE:
            of = 4.0 if is_saddle(answers.G, 0, work.c, mu, answers.alphas[slides]) else 2.0
            slides += 1
        if of < rank:
            best, rank = m, of
    if best < 0:
        return -1, 0
    if answers.modes[best] != SLIDE:
        return (ContactMode.OPEN.value if answers.modes[best] == FREE else ContactMode.STICK.value), found
    size = math.hypot(answers.P[best, 1], answers.P[best, 2])
    c.course[0, 0], c.course[0, 1] = -answers.P[best, 1] / size, -answers.P[best, 2] / size
    return ContactMode.SLIDE.value, found


@kernel
def take_course(c):
    """Take the direction in which the contact slides; in space it has no sign."""
    follow_slide(2, 0, c)
    c.slip[0] = 0


@kernel
def strike(sys, is_lost, x, state, c):
    """Give the impulses of an impact, with or without collision, at the state that was evaluated last; returns the
    number of solutions, 0 where there is none."""
    work, h, laws, found = c.work, c.hodograph, sys.laws, 1
    mu, law = friction_coefficient(laws, 0, length_along(c.gamma, 0)), int(laws[0, LAW_IMPACT])
    if is_lost or follows_own_law(0, sys.kinds, laws):
        for a in range(3):
            h.before[a] = c.gamma[0, a]
            for b in range(3):
                h.G[a, b] = work.G[a, b]
        h.mu, h.e, h.law = mu, laws[0, LAW_E_N], law
        if is_lost:
            lose(h)
        if not collide_in_space(address(h)):
            return 0
        for a in range(3):
            work.P[a] = h.impulse[a]
    else:
        for a in range(3):
            work.c[a] = c.gamma[0, a]
        work.c[0] *= 1.0 + laws[0, LAW_E_N]
        found = list_solutions(c.answers.G, 0, work.c, mu, max(mu, static_coefficient(laws, 0)), c.answers)
        if found == 0:
            return 0
        last = 1 if found > 1 and c.answers.modes[0] == FREE else 0  # sticking before slides
        for a in range(3):
            work.P[a] = c.answers.P[last, a]
    gain, size, push = give(sys, True, x, c)
    note_gains(sys, gain, push, rounded_sum(VELOCITY_ROUNDINGS, size), True, 1, state, work)
    return found


@kernel
def give_up(sys, x, c):
    """Take off the velocity with which a low bounce begins, with the friction that belongs to its impulse."""
    work = c.work
    stop(sys, c)
    if c.mode[0] == ContactMode.SLIDE:
        mu = friction_coefficient(sys.laws, 0, length_along(c.gamma, 0))
        p = work.G[0, 0] - mu * (work.G[0, 1] * c.course[0, 0] + work.G[0, 2] * c.course[0, 1])
        work.P[0] = -work.gamma_0[0] / p
        for a in range(2):
            work.P[1 + a] = -mu * work.P[0] * c.course[0, a]
    give(sys, True, x, c)


@kernel
def end_event(sys, t, kind, found, mode, x, state, c):
    """Take the new mode, hold the state to it, and append the event, unless it is a start without one."""
    c.mode[0] = mode
    status = hold(sys, t, x, c)
    has_changed = mode != state.mode[0]
    is_start = state.counters.steps == 0 and kind == MODE_CHANGE
    if (has_changed or kind != MODE_CHANGE) and not is_start:
        event = state.event
        event.P_N, event.P_F = c.P[0, 0], length_along(c.P, 0)
        event.gamma_N, event.gamma_F, event.solutions = c.before[0, 0], length_along(c.before, 0), found
        append_event(t + c.numbers.late, kind, 0, state.mode[0], state.slip[0], mode, c.slip[0], state)
    state.mode[0], state.slip[0] = mode, c.slip[0]
    return status
