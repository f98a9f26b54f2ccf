"""Event-driven integration of one contact with friction in two directions.

    q' = u,    M u' = h + W_N^T la_N + W_T^T la_T,    gamma' = G la + b

    open        la = 0
    sliding     la_N = -b_N/p,    la_T = -mu la_N d,    p = G_NN - mu G_NT d,    d = gamma_T/|gamma_T|
    sticking    G la = -b

Between events the motion is smooth, and Radau IIA integrates it (radau/method.py). d turns with it; it has no limit at
gamma_T = 0. Below the speed v_stop, which counts as none, a slide is braked as it came (``find_direction`` of
penalty/rates.py). Events: g_N of an open contact and la_N of a closed one, the end of a slide, mu la_N - |la_T| of one
that sticks, and p, where a slide loses its force. What follows:

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
from typing import Annotated as Array
from typing import Any

from nonsmooth.contact.planar.selection import Selection
from nonsmooth.contact.planar.single import FREE
from nonsmooth.contact.spatial.all_solutions import SLIDE, OneContact, is_saddle, list_solutions, stick_spatial
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.event_driven.loop import NEARLY_SINGULAR, ONE_FLIGHT, take_state, write_gaps
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.integrators.moreau_jean.energy_gain import note_gains
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.integrators.penalty.rates import find_direction, length_along
from nonsmooth.integrators.penalty.switching import follow_slide, note_speed, speed_along
from nonsmooth.integrators.radau.events import NO_EVENT, Events, locate_event
from nonsmooth.integrators.radau.header import take_motion
from nonsmooth.integrators.radau.located import (
    ACCEPT_STEP,
    AT_START,
    AT_VANISHED_STEP,
    CHANGE_MODES,
    FILL_HEADER,
    Located,
    append_row,
    write_state,
)
from nonsmooth.integrators.radau.method import radau_accept, radau_restart, radau_shorten, radau_step
from nonsmooth.integrators.radau.stages import RATES, Radau, newton
from nonsmooth.integrators.records import (
    CLOSURE,
    FRICTION,
    IMPACT,
    INCONSISTENT,
    INDETERMINATE,
    MODE_CHANGE,
    N_FUNCTIONS,
    N_LEDGER,
    N_WORKS,
    SIGN,
    Record,
    State,
    append_event,
    book_contact_energy,
)
from nonsmooth.integrators.rigid.hold import LINEARISATIONS
from nonsmooth.integrators.rigid.modes import SINGULAR_SLIDE, longest, rounded_length, small_speed
from nonsmooth.jit import Kernel, kernel, rare_kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, address, new, view
from nonsmooth.mechanics.acceleration_problem import acceleration_problem, constraint_problem
from nonsmooth.mechanics.contact_problem import Work, row_velocities
from nonsmooth.mechanics.impact import follows_own_law
from nonsmooth.mechanics.impact_in_space import Hodograph, collide_in_space, turning
from nonsmooth.mechanics.laws import (
    LAW_E_F,
    LAW_E_N,
    LAW_IMPACT,
    friction_coefficient,
    is_no_friction,
    static_coefficient,
)
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP, UNILATERAL, ContactMode, System
from nonsmooth.numerics.dense import SINGULAR
from nonsmooth.numerics.rounding import rounded_sum

MOST_TRIALS = 16  # chosen: impacts without collision at one instant
FORCELESS = SIGN  # code: the event function of a slide that loses its force


class SpaceNumbers(Block):
    """Numbers of a run."""

    atol: float
    rtol: float
    v_stop: float  # [m/s] of sliding that counts as none
    p: float  # over G_NN, of the slide; 1 in other modes
    size: float  # [N] of the terms of la_N
    flight: float  # [s] of the flight that has begun
    late: float  # [s] that the bounces still take which are given up


class SpaceContact(Block, r="max(1, n_c * (1 + d))"):
    """The contact of a run, n_c = 1."""

    work: Work
    numbers: SpaceNumbers
    answers: OneContact
    hodograph: Hodograph
    mode: Array[Ints, "n_c"]
    slip: Array[Ints, "n_c"]  # 0: a slide has no sign
    course: Array[Floats, "n_c", 2]  # the direction of sliding at the last step
    way: Array[Floats, "n_c", 2]  # and now
    q: Array[Floats, "n"]
    u: Array[Floats, "n"]
    la: Array[Floats, "n_c", 3]
    gamma: Array[Floats, "n_c", 3]
    before: Array[Floats, "n_c", 3]  # velocities before the event
    P: Array[Floats, "n_c", 3]  # its impulses
    rates: Array[Floats, 4, "r"]
    u_0: Array[Floats, "n"]  # velocities before it
    ledger: Array[Floats, N_LEDGER]


class Scratch(Located, others=f"4 * n_c + {N_WORKS}", functions=f"{N_FUNCTIONS} * n_c"):
    """Arrays of a run."""

    ode: Array[Radau, "m = n", "n = 2 * n", "quadratures = others"]
    events: Array[Events, "n_events = functions", "n_x = 2 * n + others"]
    contacts: SpaceContact


# between events


@kernel("int64(int64, float64, float64[::1], int64)", short_loops=True)
def space_forces(sys_at, t, x, contacts_at):
    """la, gamma and work.du = u' at a state; returns a Status."""
    sys, c = view(sys_at, Sys), view(contacts_at, SpaceContact)
    work, la, numbers, n = c.work, c.la, c.numbers, sys.n
    for j in range(n):
        c.q[j], c.u[j] = x[j], x[n + j]
    work.closed[0] = 0
    status, _ = acceleration_problem(sys, t, c.q, c.u, 1, c.rates, work)
    if status != Status.RUNNING:
        return status
    row_velocities(sys, 1, c.u, work)
    for a in range(3):
        la[0, a], c.gamma[0, a] = 0.0, work.gamma_0[a]
        for b in range(3):
            c.answers.G[0, a, b] = work.G[a, b]
    numbers.p, numbers.size = 1.0, 0.0
    if c.mode[0] == ContactMode.OPEN:
        return Status.RUNNING.value
    if c.mode[0] == ContactMode.STICK:
        la[0, 0], la[0, 1], la[0, 2], _ = stick_spatial(c.answers.G, 0, work.c[0], work.c[1], work.c[2], math.inf)
    else:
        mu = friction_coefficient(sys.laws, 0, max(0.0, find_direction(2, 0, c)))
        if is_no_friction(mu):
            return Status.NEGATIVE_FRICTION.value
        p = work.G[0, 0] - mu * (work.G[0, 1] * c.way[0, 0] + work.G[0, 2] * c.way[0, 1])
        numbers.p = p / work.G[0, 0]
        la[0, 0] = -work.c[0] / p
        for a in range(2):
            la[0, 1 + a] = -mu * la[0, 0] * c.way[0, a]
    numbers.size = abs(la[0, 0]) + abs(work.c[0]) / work.G[0, 0]
    for j in range(n):
        total, size = work.du[j], abs(work.du[j])
        for a in range(3):
            part = work.X[a, j] * la[0, a]
            total, size = total + part, size + abs(part)
        work.du[j] = 0.0 if abs(total) <= rounded_sum(VELOCITY_ROUNDINGS, size) < math.inf else total
    return Status.RUNNING.value


@kernel(RATES, short_loops=True)
def space_rates(sys_at, contacts_at, t, x, out):
    """x' with x = (q, u, g_N, P, works); a radau ``rates`` function. Returns a Status."""
    sys, c = view(sys_at, Sys), view(contacts_at, SpaceContact)
    status = space_forces(sys_at, t, x, contacts_at)
    if status != Status.RUNNING:
        return status
    n, work, total = sys.n, c.work, 0.0
    for k in range(2 * n, x.shape[0]):
        out[k] = 0.0
    for j in range(n):
        out[j], out[n + j] = c.u[j], work.du[j]
        out[2 * n + 4] += work.h[j] * c.u[j]
        total += 0.0 * work.du[j]
    for a in range(3):
        out[2 * n + 1 + a] = c.la[0, a]
        out[2 * n + (6 if a == 0 else 5)] += c.la[0, a] * c.gamma[0, a]
        out[2 * n + 7] -= c.la[0, a] * work.w[a]
    return Status.RUNNING.value if total == 0.0 else Status.NOT_FINITE.value


@kernel(RATES, short_loops=True)
def space_events(sys_at, contacts_at, t, x, out):
    """The event functions and their tolerances, an ``event_values`` function; one that does not apply is 1."""
    sys, c = view(sys_at, Sys), view(contacts_at, SpaceContact)
    status = space_forces(sys_at, t, x, contacts_at)
    if status != Status.RUNNING:
        return status
    if not evaluate(sys, GAP, t, c.q, c.u, c.work.g_N):
        return Status.NOT_FINITE.value
    for m in range(N_FUNCTIONS):
        out[m], out[N_FUNCTIONS + m] = 1.0, 0.0
    force = c.numbers.rtol * c.numbers.size
    if c.mode[0] == ContactMode.OPEN:
        out[CLOSURE], out[N_FUNCTIONS + CLOSURE] = c.work.g_N[0], rounded_length(sys.n, c)
        return Status.RUNNING.value
    out[CLOSURE], out[N_FUNCTIONS + CLOSURE] = c.la[0, 0], force
    if c.mode[0] == ContactMode.SLIDE:
        out[FRICTION], out[N_FUNCTIONS + FRICTION] = speed_along(2, 0, c), small_speed(sys, c)
        out[FORCELESS] = c.numbers.p - SINGULAR_SLIDE
    else:
        mu = static_coefficient(sys.laws, 0)
        out[FRICTION], out[N_FUNCTIONS + FRICTION] = mu * c.la[0, 0] - length_along(c.la, 0), (1.0 + mu) * force
    return Status.RUNNING.value


@kernel(ACCEPT_STEP, short_loops=True)
def accept_step(sys_at, t, state_at, scratch_at):
    """Take the step that was tried, moved onto the constraints of its mode, to the time t; returns a Status."""
    sys, state, scratch = view(sys_at, Sys), view(state_at, State), view(scratch_at, Scratch)
    ode, c = scratch.ode, scratch.contacts
    status = hold(sys, t, ode.x_1, c)
    if status == Status.RUNNING:
        status = radau_accept(sys_at, ode)
    if status != Status.RUNNING:
        return status
    take_motion(t, ode.x, state)
    state.worst.penetration = max(state.worst.penetration, -ode.x[2 * sys.n])
    note_speed(sys, c)
    if c.mode[0] == ContactMode.SLIDE:
        take_course(c)
    state.counters.steps += 1
    return status


@kernel
def hold(sys, t, x, c):
    """Move the state onto g_N = 0, gamma_N = 0 and, sticking, gamma_T = 0; the gap is written. Returns a Status."""
    work, n = c.work, sys.n
    work.closed[0] = 0
    for _ in range(LINEARISATIONS):
        for j in range(n):
            c.q[j], c.u[j] = x[j], x[n + j]
        if not evaluate(sys, GAP, t, c.q, c.u, work.g_N) or not math.isfinite(work.g_N[0]):
            return Status.NOT_FINITE.value
        x[2 * n] = work.g_N[0]
        if c.mode[0] == ContactMode.OPEN:
            return Status.RUNNING.value
        status, _ = constraint_problem(sys, t, c.q, c.u, 1, work)
        if status != Status.RUNNING:
            return status
        x[2 * n] = 0.0
        if abs(work.g_N[0]) <= rounded_sum(VELOCITY_ROUNDINGS, longest(n, c)):
            break
        for j in range(n):
            x[j] -= work.X[0, j] * work.g_N[0] / work.G[0, 0]
    row_velocities(sys, 1, c.u, work)
    stop(sys, c)
    give(sys, False, x, c)
    return Status.RUNNING.value


@kernel
def stop(sys, c):
    """The impulses, to work.P, that take gamma_N and, sticking, gamma_T, of the velocities in work.gamma_0."""
    work, G = c.work, c.answers.G
    work.P[0], work.P[1], work.P[2] = -work.gamma_0[0] / work.G[0, 0], 0.0, 0.0
    if c.mode[0] == ContactMode.STICK:
        for a in range(3):
            for b in range(3):
                G[0, a, b] = work.G[a, b]
        work.P[0], work.P[1], work.P[2], _ = stick_spatial(
            G, 0, work.gamma_0[0], work.gamma_0[1], work.gamma_0[2], math.inf
        )


@kernel
def give(sys, is_booked, x, c):
    """u += X^T P, what cancels to rounding set to 0; the impulses of an event are booked, with their works.

    Returns what the contact gained, the sizes of its parts, and the work with which friction drives a slide.
    """
    work, n = c.work, sys.n
    for j in range(n):
        before, total, size = x[n + j], x[n + j], abs(x[n + j])
        for a in range(3):
            part = work.X[a, j] * work.P[a]
            total, size = total + part, size + abs(part)
        x[n + j] = 0.0 if abs(total) <= rounded_sum(VELOCITY_ROUNDINGS, size) < math.inf else total
        work.trial[j] = 0.5 * (before + x[n + j])
    if not is_booked:
        return 0.0, 0.0, 0.0
    for m in range(N_LEDGER):
        c.ledger[m] = 0.0
    _, gain, size, push = book_contact_energy(sys, 1, work.trial, c.ledger, work)
    for m in range(N_WORKS):
        x[2 * n + 4 + m] += c.ledger[m]
    for a in range(3):
        c.P[0, a] += work.P[a]
        x[2 * n + 1 + a] += work.P[a]
    return gain, size, push


# events


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
def lose(h):
    """Let the impact begin where p = 0, from a slide whose p is not quite 0 yet.

    Until then gamma_N stays 0, held by a force: dp/dP < 0 where the slide turns into the paradox, and gamma_N would
    rise by p^2/(-2 dp/dP), which is taken off twice. Where it does not turn so, p is taken as just below 0.
    """
    G, v = h.G, math.sqrt(h.before[1] * h.before[1] + h.before[2] * h.before[2])
    d_1, d_2 = h.before[1] / v, h.before[2] / v
    p = G[0, 0] - h.mu * (G[0, 1] * d_1 + G[0, 2] * d_2)
    slope = -h.mu * (G[0, 2] * d_1 - G[0, 1] * d_2) * turning(math.atan2(d_2, d_1), h)[0] / v
    h.before[0] = 0.0
    if p >= 0.0 and slope < 0.0:
        h.before[0] = p * p / slope
    elif p >= 0.0:
        G[0, 0] -= p + SINGULAR * G[0, 0]


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


@rare_kernel(CHANGE_MODES, short_loops=True)
def change_modes(sys_at, every, state_at, record_at, scratch_at):
    """Change the mode after the event that waits, and begin anew with the rates of the new one; returns a Status."""
    sys, state = view(sys_at, Sys), view(state_at, State)
    record, scratch = view(record_at, Record), view(scratch_at, Scratch)
    ode, events, c = scratch.ode, scratch.events, scratch.contacts
    n, event, t = sys.n, scratch.waiting, ode.clock.now
    is_start = event == AT_START
    if is_start:
        for j in range(n):
            ode.x[j], ode.x[n + j] = state.q[j], state.u[j]
        c.mode[0], c.slip[0] = state.mode[0], 0
    if event == AT_VANISHED_STEP:
        status = space_forces(sys_at, t, ode.x, address(c))
        if status != Status.RUNNING or not abs(c.numbers.p) < NEARLY_SINGULAR:
            return Status.STEP_VANISHED.value
        event = FORCELESS
    for j in range(n):
        c.u_0[j] = ode.x[n + j]
    mode = c.mode[0]
    status = switch_in_space(sys_at, t, event, ode.x, state_at, address(c))
    scratch.first_step = ONE_FLIGHT * c.numbers.flight
    if status != Status.RUNNING:
        if is_start and write_gaps(sys, t, ode.x, c):
            write_start(t, state, record, scratch)
        return status
    for e in range(events.armed.shape[0]):
        events.armed[e] = 0
    events.is_gap[CLOSURE] = 1 if c.mode[0] == ContactMode.OPEN else 0
    events.found.check_start, events.found.handled = 1, max(event, NO_EVENT)
    radau_restart(not is_start and mode == c.mode[0] and c.mode[0] == ContactMode.OPEN, ode)
    has_jumped = False
    for j in range(n):
        has_jumped = has_jumped or c.u_0[j] != ode.x[n + j]
        state.q[j], state.u[j] = ode.x[j], ode.x[n + j]
    status = space_rates(sys_at, address(c), t, ode.x, ode.f)
    if is_start:
        write_start(t, state, record, scratch)
    if every > 0 and has_jumped:
        write_state(sys, t, ode.x, False, state, record, scratch)
    return status


@kernel
def write_start(t, state, record, scratch):
    """Write the row of the start: the velocities before an impact there, and nothing in the quadratures yet."""
    x, x_0, n = scratch.ode.x, scratch.events.x, state.q.shape[0]
    for i in range(x.shape[0]):
        x_0[i] = x[i] if i <= 2 * n else 0.0
    for j in range(n):
        x_0[n + j] = scratch.contacts.u_0[j]
    take_state(t, x_0, state, scratch)
    append_row(t, x_0, state, record, scratch)
    record.counts.next = 1


@kernel(FILL_HEADER, short_loops=True)
def fill_header(sys_at, t, x, is_within, state_at, scratch_at):
    """The header of a state, with its own gap within a step; returns a Status."""
    scratch = view(scratch_at, Scratch)
    if is_within and not write_gaps(view(sys_at, Sys), t, x, scratch.contacts):
        return Status.NOT_FINITE.value
    take_state(t, x, view(state_at, State), scratch)
    return Status.RUNNING.value


class EventDrivenInSpace(EventDriven):
    """`EventDriven` of a system of one contact with friction in two directions, as `simulate` takes it there."""

    is_spatial = True
    callbacks = (space_rates, space_events, change_modes, accept_step, fill_header)

    def __repr__(self) -> str:
        return f"EventDriven(rtol={self.rtol!r}, atol={self.atol!r})"

    def entry_points(self, system: System) -> list[Kernel]:
        """What the loop may reach, itself first."""
        reached = [space_forces, switch_in_space, collide_in_space, radau_step, radau_shorten, newton, locate_event]
        return [self.loop, *self.callbacks, *reached]

    def memory(self, system: System, selection: int) -> Any:
        """The arrays of a run, with the tolerances."""
        require_one_contact(system, selection)
        arrays = new(Scratch, **system.sizes)
        arrays.contacts.numbers.atol, arrays.contacts.numbers.rtol = self.atol, self.rtol
        arrays.ode.atol[:], arrays.ode.clock.rtol = self.atol, self.rtol
        return arrays

    def reason(self, status: Status, state: State, memory: Any) -> str:
        """Nothing more than the status says."""
        return ""


def require_one_contact(system: System, selection: int) -> None:
    """Raise `InvalidInput` unless a system in space is one that is followed from event to event."""
    cure = "MoreauJean(dt=...) and Adaptive simulate it"
    if system.kinematics is not None:
        raise InvalidInput(f"EventDriven takes no system with kinematics (q' = B u); {cure}")
    if system.n_c != 1 or tuple(system.kinds[0]) != (UNILATERAL, 2):
        raise InvalidInput(
            "of systems with friction in two directions EventDriven takes those with one contact, unilateral; got "
            f"{system.n_c} contacts; {cure}"
        )
    if system.laws[0, LAW_E_F] != 0:
        raise InvalidInput(f"in space EventDriven takes no tangential restitution, e_F = 0; {cure}")
    if selection != Selection.COMPLIANT_LIMIT:
        raise InvalidInput('in space EventDriven follows the rule selection="compliant-limit" alone')
