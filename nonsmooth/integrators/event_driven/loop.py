"""The loop of an event-driven run: step, look for an event, accept, write, change the modes.

The step is that of radau/method.py, the events those of radau/events.py; the equations of the modes are in
rigid/modes.py, what follows an event in event_driven/switching.py.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.contact.planar.forces import Forces
from nonsmooth.errors import Status
from nonsmooth.integrators.contract import LOOP, Schedule
from nonsmooth.integrators.event_driven.switching import SOLUTIONS_KEPT, switch_modes
from nonsmooth.integrators.event_driven.touch import AT_START, Touch
from nonsmooth.integrators.radau.events import (
    MAX_STALLS,
    NO_EVENT,
    TOO_LONG,
    Events,
    locate_event,
    longest_step,
)
from nonsmooth.integrators.radau.header import (
    note_impulses,
    state_at_moment,
    take_contacts,
    take_counts,
    take_motion,
)
from nonsmooth.integrators.radau.method import SMALLEST_STEP, radau_accept, radau_restart, radau_step
from nonsmooth.integrators.radau.polynomial import begin_polynomial, end_polynomial
from nonsmooth.integrators.radau.stages import Radau
from nonsmooth.integrators.records import CLOSURE, N_FUNCTIONS, N_WORKS, Record, State, is_full, write_row
from nonsmooth.integrators.rigid.census import count_step, enters_region, note_several, slides, slides_alone
from nonsmooth.integrators.rigid.hold import hold
from nonsmooth.integrators.rigid.modes import NEARLY_SINGULAR, RigidContacts, note_side
from nonsmooth.integrators.rigid.rates import rigid_rates
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, address, view
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP, ContactMode

# derived: rows of a contact at one moment: what happens, the solutions of its impact, those of its forces
EVENTS_AT_ONCE = 3
# derived, of the step that the motion would take: how far ahead an event on the border of two modes is decided. What
# changes of the forces until then, 1e-5 of what they change in a step, is far above their rounding.
MOMENT = 1e-5
# chosen: of the flight that has begun: the longest first step, whose stages then all see the gap open
ONE_FLIGHT = 0.75


class Scratch(Block, others=f"3 * n_c + {N_WORKS}", functions=f"{N_FUNCTIONS} * n_c + 1", kept=SOLUTIONS_KEPT):
    """Arrays of an event-driven run."""

    ode: Array[Radau, "m = n", "n = 2 * n", "quadratures = others"]
    events: Array[Events, "n_events = functions", "n_x = 2 * n + others"]
    contacts: RigidContacts
    touch: Touch
    forces: Array[Forces, "kept = kept"]
    written: Array[Floats, "n_c", 2]  # impulses at the last row
    stalls: Array[Ints, 1]  # events in a row without any motion


@kernel(LOOP, short_loops=True)
def run(sys_at, schedule_at, max_steps, state_at, record_at, scratch_at):
    """Advance by at most max_steps steps; returns a Status.

    Rows are written every so many steps and at every event, before and after it, or, where every = 0, at the times t.
    The last of these is the end.
    """
    sys, schedule = view(sys_at, Sys), view(schedule_at, Schedule)
    state, record, scratch = view(state_at, State), view(record_at, Record), view(scratch_at, Scratch)
    if state.counters.is_begun == 0:
        begin(sys, state, scratch)
    status = advance(sys, schedule, max_steps, state, record, scratch)
    state.now = scratch.ode.clock.now
    if status == Status.RUNNING or status == Status.FINISHED:  # else the header stays where the step began
        take_state(state.now, scratch.ode.x, state, scratch)
    take_counts(scratch.ode, state)
    return status


@kernel
def begin(sys, state, scratch):
    """Take the start from the header; its modes are decided as an event."""
    ode, contacts = scratch.ode, scratch.contacts
    n = state.q.shape[0]
    for j in range(n):
        ode.x[j], ode.x[n + j] = state.q[j], state.u[j]
    for i in range(state.mode.shape[0]):
        contacts.mode[i], contacts.slip[i], contacts.sign[i] = state.mode[i], state.slip[i], 1
        for k in range(sys.laws.shape[1]):  # they differ from cell to cell of a sweep
            contacts.laws[i, k], scratch.forces.laws[i, k] = sys.laws[i, k], sys.laws[i, k]
    ode.clock.now = state.now
    contacts.facts.event, contacts.numbers.flight = AT_START, math.inf
    state.counters.is_begun = 1


@kernel
def advance(sys, schedule, max_steps, state, record, scratch):
    """``run``, that leaves the header to be filled."""
    ode, events, contacts = scratch.ode, scratch.events, scratch.contacts
    every, clock = schedule.every, ode.clock
    t_end = schedule.t[schedule.t.shape[0] - 1]
    for _ in range(max_steps):
        t = clock.now
        if is_full(2 * min(every, 1), EVENTS_AT_ONCE * sys.n_c, state, record):
            return Status.RUNNING.value
        if contacts.facts.event != NO_EVENT:
            status = handle_event(sys, every, state, record, scratch)
            if status != Status.RUNNING:
                return status
        if not t_end - t > SMALLEST_STEP * abs(t):
            return Status.FINISHED.value
        h_max = min(t_end - t, ONE_FLIGHT * contacts.numbers.flight, longest_step(events))
        status = radau_step(address(sys), h_max, address(ode))
        if status == Status.RUNNING:
            status = locate_event(address(sys), address(ode), address(events))
        if status == Status.STEP_VANISHED and slide_is_lost(sys, contacts, ode):
            contacts.facts.event = events.armed.shape[0] - 1
            continue
        if status != Status.RUNNING:
            return status
        if events.found.which == TOO_LONG:
            continue
        contacts.facts.event = events.found.which
        if events.found.is_immediate != 0:
            continue
        contacts.numbers.flight = math.inf
        t_1 = t_end if clock.done == t_end - t else t + clock.done
        begin_polynomial(t, sys.n, ode, record.steps)
        status = hold(sys, t_1, ode.x_1, False, contacts)
        if status == Status.RUNNING:
            status = radau_accept(address(sys), ode)
        if status != Status.RUNNING:
            return status
        clock.now = t_1
        accept(state, contacts, ode)
        count_step(state, contacts)
        end_polynomial(sys.n, ode, record.steps)
        if every == 0:
            status = write_rows(sys, t, t_1, schedule, state, record, scratch)
            if status != Status.RUNNING:
                return status
        is_end = t_1 == t_end or events.found.which != NO_EVENT
        if every > 0 and (state.counters.steps % every == 0 or is_end):
            write_state(t_1, ode.x, state, record, scratch)
        if t_1 - t > SMALLEST_STEP * abs(t_end):  # at t = 0 steps of 1e-24 s would get on, but not to the end
            scratch.stalls[0] = 0
    return Status.RUNNING.value


@kernel
def slide_is_lost(sys, contacts, ode):
    """Whether the steps vanish because the motion has come to a Génot–Brogliato point."""
    status = rigid_rates(address(sys), address(contacts), ode.clock.now, ode.x, ode.f)
    return status == Status.RUNNING and contacts.numbers.determinant < NEARLY_SINGULAR


@kernel
def accept(state, contacts, ode):
    """Count the step, keep the state and the deepest penetration."""
    n = contacts.facts.n_u
    for i in range(n):
        state.q[i], state.u[i] = ode.x[i], ode.x[n + i]
    for i in range(contacts.kinds.shape[0]):
        state.worst.penetration = max(state.worst.penetration, -ode.x[2 * n + i])
        if contacts.la[i, 1] == 0.0:
            note_side(i, contacts)
    state.counters.steps += 1


@kernel
def handle_event(sys, every, state, record, scratch):
    """Change the modes and begin anew with the rates of the new ones; returns a Status."""
    ode, events, contacts = scratch.ode, scratch.events, scratch.contacts
    n, event = contacts.facts.n_u, contacts.facts.event
    scratch.stalls[0] += 1
    if scratch.stalls[0] > MAX_STALLS * events.armed.shape[0]:
        return Status.CHATTERING
    t, is_start = ode.clock.now, event == AT_START
    u_0 = scratch.touch.u_0
    for j in range(n):
        u_0[j] = ode.x[n + j]
    status, enters = Status.RUNNING.value, enters_region(event, contacts)
    if enters or contacts.kinds.shape[0] == 0:
        contacts.facts.event = NO_EVENT
    else:
        status = switch_modes(
            address(sys), t, MOMENT * ode.clock.step, ode.x, address(state), address(contacts), address(scratch.touch),
            address(scratch.forces),
        )  # fmt: skip
    if status != Status.RUNNING:
        if is_start and write_gaps(sys, t, ode.x, contacts):
            write_start(t, state, record, scratch)
        return status
    for e in range(events.armed.shape[0]):
        events.armed[e] = 0
    for i in range(contacts.kinds.shape[0]):
        events.is_gap[N_FUNCTIONS * i + CLOSURE] = 1 if contacts.mode[i] == ContactMode.OPEN else 0
    events.found.check_start = 1
    events.found.handled = event if event >= 0 else NO_EVENT
    radau_restart(ode)
    has_jumped = False
    for j in range(n):
        has_jumped = has_jumped or u_0[j] != ode.x[n + j]
        state.q[j], state.u[j] = ode.x[j], ode.x[n + j]
    has_slide = False
    for i in range(contacts.kinds.shape[0]):
        has_slide = has_slide or slides(i, contacts)
    if not is_start and not has_slide and (every == 0 or not has_jumped):
        return status
    status = rigid_rates(address(sys), address(contacts), t, ode.x, ode.f)
    for i in range(contacts.kinds.shape[0]):
        if status == Status.RUNNING and slides_alone(i, contacts):
            note_several(t, i, enters and i == event // N_FUNCTIONS, state, contacts)
    if is_start:
        write_start(t, state, record, scratch)
    if every > 0 and has_jumped:
        write_state(t, ode.x, state, record, scratch)
    return status


@kernel
def write_gaps(sys, t, x, contacts):
    """Write the gaps of a state into it; False if the gap function raised."""
    n, has_gap = contacts.facts.n_u, contacts.facts.has & (1 << GAP)
    for j in range(n):
        contacts.q[j], contacts.u[j] = x[j], x[n + j]
    if has_gap and not evaluate(sys, GAP, t, contacts.q, contacts.u, contacts.work.g_N):
        return False
    for i in range(contacts.kinds.shape[0]):
        x[2 * n + i] = contacts.work.g_N[i] if has_gap else 0.0
    return True


@kernel
def write_start(t, state, record, scratch):
    """Write the row of the start: the velocities before an impact there, and nothing in the quadratures yet."""
    x, x_0, n, n_c = scratch.ode.x, scratch.events.x, state.q.shape[0], state.mode.shape[0]
    for i in range(x.shape[0]):
        x_0[i] = x[i] if i < 2 * n + n_c else 0.0
    for j in range(n):
        x_0[n + j] = scratch.touch.u_0[j]
    write_state(t, x_0, state, record, scratch)
    record.counts.next = 1


@kernel
def write_rows(sys, t, t_1, schedule, state, record, scratch):
    """Write the rows of the record times in (t, t_1] of the accepted step, with their gaps; returns a Status."""
    ode, contacts, x, t_record = scratch.ode, scratch.contacts, scratch.events.x, schedule.t
    is_written = False
    while record.counts.next < t_record.shape[0] and t_record[record.counts.next] <= t_1:
        moment = t_record[record.counts.next]
        state_at_moment(moment, t, sys.n, ode, record.steps, x)
        status = rigid_rates(address(sys), address(contacts), moment, x, ode.f)
        if status != Status.RUNNING:
            return status
        if not write_gaps(sys, moment, x, contacts):
            return Status.NOT_FINITE
        write_state(moment, x, state, record, scratch)
        record.counts.next += 1
        is_written = True
    if is_written:
        take_state(t_1, ode.x, state, scratch)
        return rigid_rates(address(sys), address(contacts), t_1, ode.x, ode.f)  # the forces at the end of the step
    return Status.RUNNING


@kernel
def take_state(t, x, state, scratch):
    """The header of the state x = (q, u, g_N, P_N, P_F, works), whose forces were evaluated."""
    n, n_c = state.q.shape[0], state.mode.shape[0]
    take_motion(t, x, state)
    for i in range(n_c):
        state.g_N[i] = x[2 * n + i]
    take_contacts(2 * n + n_c, x, scratch.written, state, scratch.contacts)


@kernel
def write_state(t, x, state, record, scratch):
    """Append a row of the state x."""
    take_state(t, x, state, scratch)
    write_row(t, state, record)
    note_impulses(2 * state.q.shape[0] + state.mode.shape[0], x, scratch.written)
