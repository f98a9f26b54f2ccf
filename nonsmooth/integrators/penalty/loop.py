"""The loop of a run with compliant contacts: step, look for an event, accept, write, change the mode.

The step is that of radau/method.py, the events those of radau/events.py; what is integrated and what a mode is, is in
penalty/rates.py.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.errors import Status
from nonsmooth.integrators.penalty.rates import OMEGA, Contacts, contact_rates
from nonsmooth.integrators.penalty.switching import begin_contacts, change_mode, rounded_speed
from nonsmooth.integrators.radau.events import (
    MAX_STALLS,
    NO_EVENT,
    TOO_LONG,
    Events,
    locate_event,
    longest_step,
)
from nonsmooth.integrators.radau.method import SMALLEST_STEP, radau_accept, radau_restart, radau_step
from nonsmooth.integrators.radau.polynomial import (
    STEP_DEGREE,
    Steps,
    begin_polynomial,
    end_polynomial,
    state_within,
)
from nonsmooth.integrators.radau.stages import Radau, dense_value, rates_at
from nonsmooth.integrators.records import (
    EVENT_CONTACT,
    EVENT_GAMMA_F,
    EVENT_GAMMA_N,
    EVENT_KIND,
    EVENT_MODE_0,
    EVENT_MODE_1,
    EVENT_P_F,
    EVENT_P_N,
    EVENT_SLIP_0,
    EVENT_SLIP_1,
    EVENT_SOLUTIONS,
    EVENT_T,
    IMPACT,
    MODE_CHANGE,
    N_FUNCTIONS,
    N_WORKS,
    State,
)
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, address, view
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import ContactMode


class Scratch(Block, x=f"2 * (n + n_c) + 2 * n_c + {N_WORKS}", works=N_WORKS, functions=f"{N_FUNCTIONS} * n_c"):
    """Arrays of a run with compliant contacts."""

    ode: Array[Radau, "m = n", "n = 2 * (n + n_c)", "quadratures = 2 * n_c + works"]
    events: Array[Events, "n_events = functions", "n_x = x"]
    contacts: Contacts
    impulses: Array[Floats, "n_c", 2]  # at the last change of mode


class TrailCounts(Block):
    """What was written."""

    rows: int
    next: int  # of t_record
    stalls: int  # events in a row without any motion


class Trail(Block, degree=STEP_DEGREE, row=f"2 * n + 3 * n_c + {N_WORKS}"):
    """Rows that a run writes, m of them, and its steps; the caller empties them."""

    counts: TrailCounts
    steps: Array[Steps, "m = steps", "degree = degree"]
    t: Array[Floats, "m"]
    x: Array[Floats, "m", "row"]
    la: Array[Floats, "m", "n_c", 2]
    mode: Array[Floats, "m", "n_c"]
    slip: Array[Floats, "m", "n_c"]


@kernel("int64(int64, float64[::1], int64, int64, int64, int64, int64)", short_loops=True)
def run(sys_at, t_record, every, max_steps, state_at, trail_at, scratch_at):
    """Advance by at most max_steps steps; returns a Status.

    Rows are written every so many steps and at every event, or, where every = 0, at the times t_record. The last of
    these is the end.
    """
    sys = view(sys_at, Sys)
    state, trail, scratch = view(state_at, State), view(trail_at, Trail), view(scratch_at, Scratch)
    ode, events, contacts = scratch.ode, scratch.events, scratch.contacts
    clock = ode.clock
    t_end = t_record[t_record.shape[0] - 1]
    if state.counters.steps == 0 and trail.counts.next == 0:
        status = begin_run(sys_at, scratch_at)
        if status != Status.RUNNING:
            return status
        write_compliant_row(clock.now, ode.x, contacts, trail)
        trail.counts.next = 1
    for _ in range(max_steps):
        t = clock.now
        h_max = t_end - t
        if not h_max > SMALLEST_STEP * abs(t):
            return Status.FINISHED.value
        if every > 0 and trail.counts.rows >= trail.t.shape[0]:
            return Status.RUNNING.value  # the rows, or the events, are full: the caller empties them
        if state.counters.n_events + contacts.kinds.shape[0] > state.events.shape[0]:
            return Status.RUNNING.value
        status = radau_step(sys_at, min(h_max, longest_step(events)), address(ode))
        if status != Status.RUNNING:
            return status
        status = locate_event(sys_at, address(ode), address(events))
        if status != Status.RUNNING:
            return status
        which = events.found.which
        if which == TOO_LONG:
            continue
        if events.found.is_immediate == 0:
            t_1 = t_end if clock.done == h_max else t + clock.done
            begin_polynomial(t, contacts.facts.n_u, ode, trail.steps)
            status = radau_accept(sys_at, ode)
            if status != Status.RUNNING:
                return status
            clock.now = t_1
            accept(state, contacts, ode)
            end_polynomial(contacts.facts.n_u, ode, trail.steps)
            if every == 0:
                status = interpolate_rows(sys, t, t_1, t_record, scratch, trail)
                if status != Status.RUNNING:
                    return status
            if every > 0 and (state.counters.steps % every == 0 or which != NO_EVENT or t_1 == t_end):
                write_compliant_row(t_1, ode.x, contacts, trail)
            trail.counts.stalls = 0
        if which != NO_EVENT:
            trail.counts.stalls += 1
            if trail.counts.stalls > MAX_STALLS * N_FUNCTIONS * contacts.kinds.shape[0]:
                return Status.CHATTERING.value
            status = switch(sys_at, which, state_at, scratch_at)
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
    m = state.counters.n_events
    if state.counters.steps > 0 and m < state.events.shape[0]:
        row = state.events
        is_impact = state.mode[i] == ContactMode.OPEN and contacts.gamma[i, 0] < -rounded_speed(n, contacts)
        row[m, EVENT_T] = t
        row[m, EVENT_KIND] = IMPACT if is_impact else MODE_CHANGE
        row[m, EVENT_CONTACT] = i
        row[m, EVENT_MODE_0], row[m, EVENT_SLIP_0] = state.mode[i], state.slip[i]
        row[m, EVENT_MODE_1], row[m, EVENT_SLIP_1] = contacts.mode[i], contacts.slip[i]
        row[m, EVENT_P_N], row[m, EVENT_P_F] = P_N - before[i, 0], P_F - before[i, 1]
        row[m, EVENT_GAMMA_N], row[m, EVENT_GAMMA_F] = contacts.gamma[i, 0], contacts.gamma[i, 1]
        row[m, EVENT_SOLUTIONS] = 1
        state.counters.n_events += 1
    before[i, 0], before[i, 1] = P_N, P_F


@kernel
def interpolate_rows(sys, t, t_1, t_record, scratch, trail):
    """Write the rows of the record times in (t, t_1], of the step that was accepted; returns a Status."""
    ode, contacts, x = scratch.ode, scratch.contacts, scratch.events.x
    is_written = False
    while trail.counts.next < t_record.shape[0] and t_record[trail.counts.next] <= t_1:
        moment = t_record[trail.counts.next]
        state_at_moment(moment, t, contacts.facts.n_u, ode, trail.steps, x)
        status = contact_rates(address(sys), address(contacts), moment, x, ode.f)
        if status != Status.RUNNING:
            return status
        write_compliant_row(moment, x, contacts, trail)
        trail.counts.next += 1
        is_written = True
    if is_written:
        return contact_rates(address(sys), address(contacts), t_1, ode.x, ode.f)  # the contacts at the end of the step
    return Status.RUNNING


@kernel
def state_at_moment(moment, t, n, ode, steps, x):
    """The state within the step from t that was accepted last."""
    theta = min(1.0, (moment - t) / ode.clock.done)
    state_within(steps.counts.n_steps - steps.counts.is_kept, theta, steps, x)
    Z = ode.Z
    for i in range(2 * n, x.shape[0]):
        x[i] = ode.x[i] - Z[2, i] + dense_value(theta, Z[0, i], Z[1, i], Z[2, i])


@kernel
def write_compliant_row(t, x, contacts, trail):
    """Append the state without the normal velocities v, which follow from u, the forces and the modes."""
    m, n_c = trail.counts.rows, contacts.kinds.shape[0]
    v = 2 * contacts.facts.n_u + n_c
    for i in range(v):
        trail.x[m, i] = x[i]
    for i in range(v, trail.x.shape[1]):
        trail.x[m, i] = x[n_c + i]
    write_forces(t, contacts, trail)


@kernel
def write_row(t, x, contacts, trail):
    """Append the state, the forces and the modes."""
    for i in range(x.shape[0]):
        trail.x[trail.counts.rows, i] = x[i]
    write_forces(t, contacts, trail)


@kernel
def write_forces(t, contacts, trail):
    """The time, the forces and the modes of a row, which is complete then."""
    m = trail.counts.rows
    trail.t[m] = t
    for i in range(contacts.kinds.shape[0]):
        trail.la[m, i, 0], trail.la[m, i, 1] = contacts.la[i, 0], contacts.la[i, 1]
        trail.mode[m, i], trail.slip[m, i] = contacts.mode[i], contacts.slip[i]
    trail.counts.rows += 1
