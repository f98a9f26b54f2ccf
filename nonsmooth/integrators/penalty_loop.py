"""The loop of a run with compliant contacts: step, look for an event, accept, write, change the mode.

The step is that of radau.py, the events those of event_location.py; what is integrated and what a mode is, is in
compliant_contacts.py.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

from nonsmooth.blocks import Cube, Integers, Matrix, Vector, address, frozen, view
from nonsmooth.errors import Status
from nonsmooth.integrators.compliant_contacts import N_U, N_WORKS, OMEGA, Contacts, contacts_shapes
from nonsmooth.integrators.contact_switching import N_FUNCTIONS, begin_contacts, change_mode, rounded_speed
from nonsmooth.integrators.event_location import (
    CHECK_START,
    HANDLED,
    IS_IMMEDIATE,
    NO_EVENT,
    TOO_LONG,
    WHICH,
    Events,
    events_shapes,
    locate_event,
    longest_step,
)
from nonsmooth.integrators.radau import SMALLEST, radau_accept, radau_restart, radau_step
from nonsmooth.integrators.radau_stages import DONE, NOW, Radau, dense_value, radau_shapes, rates_at
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
    N_EVENTS,
    PENETRATION,
    STEPS,
    State,
)
from nonsmooth.integrators.step_polynomial import (
    IS_KEPT,
    N_STEPS,
    Steps,
    begin_polynomial,
    end_polynomial,
    state_within,
    steps_shapes,
)
from nonsmooth.jit import kernel
from nonsmooth.laws import LAW_WIDTH
from nonsmooth.system import ContactMode

MAX_STALLS = 8  # changes of mode at one instant, per event function
# counts of a trail
ROWS, NEXT, STALLS = range(3)


class Scratch(NamedTuple):
    """Arrays of a run with compliant contacts."""

    ode: Radau
    events: Events
    contacts: Contacts
    impulses: Matrix  # (c, 2) at the last change of mode


class Trail(NamedTuple):
    """Rows that a run writes, m of them, and its steps; the caller empties them."""

    counts: Integers  # (3,)
    steps: Steps
    t: Vector  # (m,)
    x: Matrix  # (m, N)
    la: Cube  # (m, c, 2)
    mode: Matrix  # (m, c)
    slip: Matrix  # (m, c)


@functools.lru_cache(maxsize=64)
def scratch_shapes(n: int, n_c: int, d: int) -> tuple:
    """Shapes of ``Scratch``."""
    quadratures = 2 * n_c + N_WORKS
    return frozen({
        "ode": radau_shapes(n, 2 * (n + n_c), quadratures),
        "events": events_shapes(N_FUNCTIONS * n_c, 2 * (n + n_c) + quadratures),
        "contacts": contacts_shapes(n, n_c, d, LAW_WIDTH),
        "impulses": (n_c, 2),
    })  # fmt: skip


def trail_shapes(m: int, steps: int, n: int, n_c: int) -> dict[str, Any]:
    """Shapes of ``Trail`` for m rows and so many steps."""
    per_contact = (m, n_c)
    return {
        "counts": (3,), "steps": steps_shapes(steps, n), "t": (m,),
        "x": (m, 2 * n + 3 * n_c + N_WORKS), "la": (m, n_c, 2), "mode": per_contact,
        "slip": per_contact,
    }  # fmt: skip


@kernel("int64(int64, int64, int64, float64[::1], float64[::1], int64, int64, int64, int64, int64)", short_loops=True)
def run(model, rates, functions, p, t_record, every, max_steps, state_at, trail_at, scratch_at):
    """Advance by at most max_steps steps; returns a Status.

    Rows are written every so many steps and at every event, or, where every = 0, at the times t_record. The last of
    these is the end.
    """
    state, trail, scratch = view(state_at, State), view(trail_at, Trail), view(scratch_at, Scratch)
    ode, events, contacts = scratch.ode, scratch.events, scratch.contacts
    clock = ode.clock
    t_end = t_record[t_record.shape[0] - 1]
    if state.counters[STEPS] == 0 and trail.counts[NEXT] == 0:
        status = begin_run(rates, model, p, scratch_at)
        if status != Status.RUNNING:
            return status
        write_compliant_row(clock[NOW], ode.x, contacts, trail)
        trail.counts[NEXT] = 1
    for _ in range(max_steps):
        t = clock[NOW]
        h_max = t_end - t
        if not h_max > SMALLEST * abs(t):
            return Status.FINISHED.value
        if every > 0 and trail.counts[ROWS] >= trail.t.shape[0]:
            return Status.RUNNING.value  # the rows, or the events, are full: the caller empties them
        if state.counters[N_EVENTS] + contacts.kinds.shape[0] > state.events.shape[0]:
            return Status.RUNNING.value
        status = radau_step(rates, model, p, address(contacts), min(h_max, longest_step(events)), address(ode))
        if status != Status.RUNNING:
            return status
        status = locate_event(rates, functions, model, p, address(contacts), address(ode), address(events))
        if status != Status.RUNNING:
            return status
        which = events.found[WHICH]
        if which == TOO_LONG:
            continue
        if events.found[IS_IMMEDIATE] == 0:
            t_1 = t_end if clock[DONE] == h_max else t + clock[DONE]
            begin_polynomial(t, contacts.facts[N_U], ode, trail.steps)
            status = radau_accept(rates, model, p, address(contacts), ode)
            if status != Status.RUNNING:
                return status
            clock[NOW] = t_1
            accept(state, contacts, ode)
            end_polynomial(contacts.facts[N_U], ode, trail.steps)
            if every == 0:
                status = interpolate_rows(rates, model, p, t, t_1, t_record, scratch, trail)
                if status != Status.RUNNING:
                    return status
            if every > 0 and (state.counters[STEPS] % every == 0 or which != NO_EVENT or t_1 == t_end):
                write_compliant_row(t_1, ode.x, contacts, trail)
            trail.counts[STALLS] = 0
        if which != NO_EVENT:
            trail.counts[STALLS] += 1
            if trail.counts[STALLS] > MAX_STALLS * N_FUNCTIONS * contacts.kinds.shape[0]:
                return Status.CHATTERING.value
            status = switch(rates, model, p, which, state_at, scratch_at)
            if status != Status.RUNNING:
                return status
    return Status.RUNNING.value


@kernel("int64(int64, int64, float64[::1], int64)", short_loops=True)
def begin_run(rates, model, p, scratch_at):
    """The modes at the start; returns a Status."""
    scratch = view(scratch_at, Scratch)
    ode, events = scratch.ode, scratch.events
    events.found[CHECK_START] = 1
    events.found[HANDLED] = NO_EVENT
    return begin_contacts(rates, model, p, ode.clock[NOW], ode.x, address(scratch.contacts), ode.f)


@kernel("int64(int64, int64, float64[::1], float64, float64[::1], float64[::1], int64)", short_loops=True)
def evaluate_contacts(function, model, p, t, x, out, scratch_at):
    """The rates or the event functions at a state; returns a Status."""
    return rates_at(function, model, p, address(view(scratch_at, Scratch).contacts), t, x, out)


@kernel
def accept(state, contacts, ode):
    """Count the step, keep the state and the deepest indentation."""
    n = contacts.facts[N_U]
    for i in range(n):
        state.q[i], state.u[i] = ode.x[i], ode.x[n + i]
    for i in range(contacts.kinds.shape[0]):
        state.worst[PENETRATION] = max(state.worst[PENETRATION], -ode.x[2 * n + i] / contacts.constants[i, OMEGA])
    state.counters[STEPS] += 1


@kernel("int64(int64, int64, float64[::1], int64, int64, int64)", short_loops=True)
def switch(rates, model, p, which, state_at, scratch_at):
    """Change a mode and begin anew with the rates of the new one; returns a Status."""
    state, scratch = view(state_at, State), view(scratch_at, Scratch)
    ode, events, contacts = scratch.ode, scratch.events, scratch.contacts
    n_c = contacts.kinds.shape[0]
    for i in range(n_c):
        state.mode[i], state.slip[i] = contacts.mode[i], contacts.slip[i]
    status = change_mode(rates, model, p, ode.clock[NOW], ode.x, which, contacts, ode.f)
    if status != Status.RUNNING:
        return status
    for i in range(n_c):
        if contacts.mode[i] != state.mode[i] or contacts.slip[i] != state.slip[i] or i == which // N_FUNCTIONS:
            for m in range(N_FUNCTIONS):
                events.armed[N_FUNCTIONS * i + m] = 0
        if contacts.mode[i] != state.mode[i] or contacts.slip[i] != state.slip[i]:
            note_event(ode.clock[NOW], i, state, scratch)
            state.mode[i], state.slip[i] = contacts.mode[i], contacts.slip[i]
    events.found[CHECK_START] = 1
    events.found[HANDLED] = which
    radau_restart(ode)
    return Status.RUNNING.value


@kernel
def note_event(t, i, state, scratch):
    """Append the change of mode of contact i, with its impulses since the change before; none at the start."""
    contacts, x, before = scratch.contacts, scratch.ode.x, scratch.impulses
    n, n_c = contacts.facts[N_U], contacts.kinds.shape[0]
    P_N, P_F = x[2 * (n + n_c) + i], x[2 * n + 3 * n_c + i]
    m = state.counters[N_EVENTS]
    if state.counters[STEPS] > 0 and m < state.events.shape[0]:
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
        state.counters[N_EVENTS] += 1
    before[i, 0], before[i, 1] = P_N, P_F


@kernel
def interpolate_rows(rates, model, p, t, t_1, t_record, scratch, trail):
    """Write the rows of the record times in (t, t_1], of the step that was accepted; returns a Status."""
    ode, contacts, x = scratch.ode, scratch.contacts, scratch.events.x
    is_written = False
    while trail.counts[NEXT] < t_record.shape[0] and t_record[trail.counts[NEXT]] <= t_1:
        moment = t_record[trail.counts[NEXT]]
        state_at_moment(moment, t, contacts.facts[N_U], ode, trail.steps, x)
        status = rates_at(rates, model, p, address(contacts), moment, x, ode.f)
        if status != Status.RUNNING:
            return status
        write_compliant_row(moment, x, contacts, trail)
        trail.counts[NEXT] += 1
        is_written = True
    if is_written:
        return rates_at(rates, model, p, address(contacts), t_1, ode.x, ode.f)  # the contacts at the end of the step
    return Status.RUNNING


@kernel
def state_at_moment(moment, t, n, ode, steps, x):
    """The state within the step from t that was accepted last."""
    theta = min(1.0, (moment - t) / ode.clock[DONE])
    state_within(steps.counts[N_STEPS] - steps.counts[IS_KEPT], theta, steps, x)
    Z = ode.Z
    for i in range(2 * n, x.shape[0]):
        x[i] = ode.x[i] - Z[2, i] + dense_value(theta, Z[0, i], Z[1, i], Z[2, i])


@kernel
def write_compliant_row(t, x, contacts, trail):
    """Append the state without the normal velocities v, which follow from u, the forces and the modes."""
    m, n_c = trail.counts[ROWS], contacts.kinds.shape[0]
    v = 2 * contacts.facts[N_U] + n_c
    for i in range(v):
        trail.x[m, i] = x[i]
    for i in range(v, trail.x.shape[1]):
        trail.x[m, i] = x[n_c + i]
    write_forces(t, contacts, trail)


@kernel
def write_row(t, x, contacts, trail):
    """Append the state, the forces and the modes."""
    for i in range(x.shape[0]):
        trail.x[trail.counts[ROWS], i] = x[i]
    write_forces(t, contacts, trail)


@kernel
def write_forces(t, contacts, trail):
    """The time, the forces and the modes of a row, which is complete then."""
    m = trail.counts[ROWS]
    trail.t[m] = t
    for i in range(contacts.kinds.shape[0]):
        trail.la[m, i, 0], trail.la[m, i, 1] = contacts.la[i, 0], contacts.la[i, 1]
        trail.mode[m, i], trail.slip[m, i] = contacts.mode[i], contacts.slip[i]
    trail.counts[ROWS] += 1
