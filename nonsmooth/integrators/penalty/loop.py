"""The loop of a run with compliant contacts: step, look for an event, accept, write, change the mode.

The step is that of radau/method.py, the events those of radau/events.py; what is integrated and what a mode is, is in
penalty/rates.py.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.errors import Status
from nonsmooth.integrators.contract import LOOP, Schedule
from nonsmooth.integrators.penalty.rates import OMEGA, Contacts, contact_rates
from nonsmooth.integrators.penalty.switching import N_FUNCTIONS, begin_contacts, change_mode, rounded_speed
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
from nonsmooth.integrators.radau.stages import Radau, rates_at
from nonsmooth.integrators.records import (
    IMPACT,
    MODE_CHANGE,
    N_WORKS,
    Record,
    State,
    append_event,
    is_full,
    write_row,
)
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, address, view
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import ContactMode


class Scratch(Block, x=f"2 * (n + n_c) + 2 * n_c + {N_WORKS}", works=N_WORKS, functions=f"{N_FUNCTIONS} * n_c"):
    """Arrays of a run with compliant contacts."""

    ode: Array[Radau, "m = n", "n = 2 * (n + n_c)", "quadratures = 2 * n_c + works"]
    events: Array[Events, "n_events = functions", "n_x = x"]
    contacts: Contacts
    impulses: Array[Floats, "n_c", 2]  # at the last change of mode
    written: Array[Floats, "n_c", 2]  # and at the last row
    stalls: Array[Ints, 1]  # events in a row without any motion


@kernel(LOOP, short_loops=True)
def run(sys_at, schedule_at, max_steps, state_at, record_at, scratch_at):
    """Advance by at most max_steps steps; returns a Status.

    Rows are written every so many steps and at every event, or, where every = 0, at the times t. The last of these is
    the end.
    """
    sys, schedule = view(sys_at, Sys), view(schedule_at, Schedule)
    state, record, scratch = view(state_at, State), view(record_at, Record), view(scratch_at, Scratch)
    status = advance(sys, schedule, max_steps, state, record, scratch)
    state.now = scratch.ode.clock.now
    if status == Status.RUNNING or status == Status.FINISHED:  # else the header stays where the step began
        take_state(state.now, scratch.ode.x, state, scratch)
    take_counts(scratch.ode, state)
    return status


@kernel
def advance(sys, schedule, max_steps, state, record, scratch):
    """``run``, that leaves the header to be filled."""
    ode, events, contacts = scratch.ode, scratch.events, scratch.contacts
    every, t_record, clock = schedule.every, schedule.t, ode.clock
    t_end = t_record[t_record.shape[0] - 1]
    if state.counters.is_begun == 0:
        status = begin_run(address(sys), address(scratch))
        if status != Status.RUNNING:
            return status
        write_state(clock.now, ode.x, state, record, scratch)
        state.counters.is_begun, record.counts.next = 1, 1
    for _ in range(max_steps):
        t = clock.now
        h_max = t_end - t
        if not h_max > SMALLEST_STEP * abs(t):
            return Status.FINISHED.value
        if is_full(min(every, 1), sys.n_c, state, record):
            return Status.RUNNING.value
        status = radau_step(address(sys), min(h_max, longest_step(events)), address(ode))
        if status != Status.RUNNING:
            return status
        status = locate_event(address(sys), address(ode), address(events))
        if status != Status.RUNNING:
            return status
        which = events.found.which
        if which == TOO_LONG:
            continue
        if events.found.is_immediate == 0:
            t_1 = t_end if clock.done == h_max else t + clock.done
            begin_polynomial(t, sys.n, ode, record.steps)
            status = radau_accept(address(sys), ode)
            if status != Status.RUNNING:
                return status
            clock.now = t_1
            accept(state, contacts, ode)
            end_polynomial(sys.n, ode, record.steps)
            if every == 0:
                status = interpolate_rows(sys, t, t_1, schedule, state, record, scratch)
                if status != Status.RUNNING:
                    return status
            if every > 0 and (state.counters.steps % every == 0 or which != NO_EVENT or t_1 == t_end):
                write_state(t_1, ode.x, state, record, scratch)
            scratch.stalls[0] = 0
        if which != NO_EVENT:
            scratch.stalls[0] += 1
            if scratch.stalls[0] > MAX_STALLS * N_FUNCTIONS * sys.n_c:
                return Status.CHATTERING.value
            status = switch(address(sys), which, address(state), address(scratch))
            if status != Status.RUNNING:
                return status
    return Status.RUNNING.value


@kernel("int64(int64, int64)", short_loops=True)
def begin_run(sys_at, scratch_at):
    """The modes at the start; returns a Status."""
    scratch = view(scratch_at, Scratch)
    ode, events = scratch.ode, scratch.events
    events.found.check_start = 1
    events.found.handled = NO_EVENT
    return begin_contacts(sys_at, ode.clock.now, ode.x, address(scratch.contacts), ode.f)


@kernel("int64(int64, int64, float64, float64[::1], float64[::1], int64)", short_loops=True)
def evaluate_contacts(sys_at, function, t, x, out, scratch_at):
    """The rates or the event functions at a state; returns a Status."""
    return rates_at(function, sys_at, address(view(scratch_at, Scratch).contacts), t, x, out)


@kernel
def accept(state, contacts, ode):
    """Count the step, keep the state and the deepest indentation."""
    n = contacts.facts.n_u
    for i in range(n):
        state.q[i], state.u[i] = ode.x[i], ode.x[n + i]
    for i in range(contacts.kinds.shape[0]):
        state.worst.penetration = max(state.worst.penetration, -ode.x[2 * n + i] / contacts.constants[i, OMEGA])
    state.counters.steps += 1


@kernel("int64(int64, int64, int64, int64)", short_loops=True)
def switch(sys_at, which, state_at, scratch_at):
    """Change a mode and begin anew with the rates of the new one; returns a Status."""
    sys = view(sys_at, Sys)
    state, scratch = view(state_at, State), view(scratch_at, Scratch)
    ode, events, contacts = scratch.ode, scratch.events, scratch.contacts
    n_c = contacts.kinds.shape[0]
    for i in range(n_c):
        state.mode[i], state.slip[i] = contacts.mode[i], contacts.slip[i]
    status = change_mode(sys, ode.clock.now, ode.x, which, contacts, ode.f)
    if status != Status.RUNNING:
        return status
    for i in range(n_c):
        if contacts.mode[i] != state.mode[i] or contacts.slip[i] != state.slip[i] or i == which // N_FUNCTIONS:
            for m in range(N_FUNCTIONS):
                events.armed[N_FUNCTIONS * i + m] = 0
        if contacts.mode[i] != state.mode[i] or contacts.slip[i] != state.slip[i]:
            note_event(ode.clock.now, i, state, scratch)
            state.mode[i], state.slip[i] = contacts.mode[i], contacts.slip[i]
    events.found.check_start = 1
    events.found.handled = which
    radau_restart(ode)
    return Status.RUNNING.value


@kernel
def note_event(t, i, state, scratch):
    """Append the change of mode of contact i, with its impulses since the change before; none at the start."""
    contacts, x, before = scratch.contacts, scratch.ode.x, scratch.impulses
    n, n_c = contacts.facts.n_u, contacts.kinds.shape[0]
    P_N, P_F = x[2 * (n + n_c) + i], x[2 * n + 3 * n_c + i]
    if state.counters.steps > 0:
        event = state.event
        event.P_N, event.P_F, event.solutions = P_N - before[i, 0], P_F - before[i, 1], 1
        event.gamma_N, event.gamma_F = contacts.gamma[i, 0], contacts.gamma[i, 1]
        is_impact = state.mode[i] == ContactMode.OPEN and contacts.gamma[i, 0] < -rounded_speed(n, contacts)
        kind = IMPACT if is_impact else MODE_CHANGE
        append_event(t, kind, i, state.mode[i], state.slip[i], contacts.mode[i], contacts.slip[i], state)
    before[i, 0], before[i, 1] = P_N, P_F


@kernel
def interpolate_rows(sys, t, t_1, schedule, state, record, scratch):
    """Write the rows of the record times in (t, t_1], of the step that was accepted; returns a Status."""
    ode, contacts, x, t_record = scratch.ode, scratch.contacts, scratch.events.x, schedule.t
    is_written = False
    while record.counts.next < t_record.shape[0] and t_record[record.counts.next] <= t_1:
        moment = t_record[record.counts.next]
        state_at_moment(moment, t, sys.n, ode, record.steps, x)
        status = contact_rates(address(sys), address(contacts), moment, x, ode.f)
        if status != Status.RUNNING:
            return status
        write_state(moment, x, state, record, scratch)
        record.counts.next += 1
        is_written = True
    if is_written:
        return contact_rates(address(sys), address(contacts), t_1, ode.x, ode.f)  # the contacts at the end of the step
    return Status.RUNNING


@kernel
def take_state(t, x, state, scratch):
    """The header of the state x = (q, u, z, v, P_N, P_F, works), whose contacts were evaluated."""
    contacts = scratch.contacts
    n_c = contacts.kinds.shape[0]
    take_motion(t, x, state)
    for i in range(n_c):
        state.g_N[i] = x[2 * state.q.shape[0] + i] / contacts.constants[i, OMEGA]
    take_contacts(2 * (state.q.shape[0] + n_c), x, scratch.written, state, contacts)


@kernel
def write_state(t, x, state, record, scratch):
    """Append a row of the state x."""
    take_state(t, x, state, scratch)
    write_row(t, state, record)
    note_impulses(2 * (state.q.shape[0] + state.mode.shape[0]), x, scratch.written)
