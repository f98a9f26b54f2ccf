"""What an event-driven run does beside the loop of radau/located.py: its start, its steps, what follows its events.

The equations of the modes are in rigid/modes.py, how they change in event_driven/switching.py.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.contact.planar.forces import Forces
from nonsmooth.errors import Status
from nonsmooth.integrators.event_driven.switching import SOLUTIONS_KEPT, switch_modes
from nonsmooth.integrators.event_driven.touch import Touch
from nonsmooth.integrators.radau.events import NO_EVENT, Events
from nonsmooth.integrators.radau.header import take_contacts, take_motion
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
from nonsmooth.integrators.radau.method import radau_accept, radau_restart
from nonsmooth.integrators.radau.stages import Radau
from nonsmooth.integrators.records import CLOSURE, N_FUNCTIONS, N_WORKS, Record, State
from nonsmooth.integrators.rigid.census import count_step, enters_region, note_several, slides, slides_alone
from nonsmooth.integrators.rigid.hold import hold_constraints
from nonsmooth.integrators.rigid.modes import NEARLY_SINGULAR, RigidContacts, note_side
from nonsmooth.integrators.rigid.rates import rigid_rates
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP, ContactMode

# derived, of the step that the motion would take: how far ahead an event on the border of two modes is decided. What
# changes of the forces until then, 1e-5 of what they change in a step, is far above their rounding.
MOMENT = 1e-5
# chosen: of the flight that has begun: the longest first step, whose stages then all see the gap open
ONE_FLIGHT = 0.75


class Scratch(Located, others=f"3 * n_c + {N_WORKS}", functions=f"{N_FUNCTIONS} * n_c + 1", kept=SOLUTIONS_KEPT):
    """Arrays of an event-driven run."""

    ode: Array[Radau, "m = n", "n = 2 * n", "quadratures = others"]
    events: Array[Events, "n_events = functions", "n_x = 2 * n + others"]
    contacts: RigidContacts
    touch: Touch
    forces: Array[Forces, "kept = kept"]


@kernel(ACCEPT_STEP, short_loops=True)
def accept_step(sys_at, t, state_at, scratch_at):
    """Take the step that was tried, moved onto the constraints of its modes, to the time t; returns a Status."""
    sys, state, scratch = view(sys_at, Sys), view(state_at, State), view(scratch_at, Scratch)
    ode, contacts = scratch.ode, scratch.contacts
    status = hold_constraints(sys_at, t, ode.x_1, False, address(contacts))
    if status == Status.RUNNING:
        status = radau_accept(sys_at, ode)
    if status != Status.RUNNING:
        return status
    take_motion(t, ode.x, state)
    for i in range(sys.n_c):
        state.worst.penetration = max(state.worst.penetration, -ode.x[2 * sys.n + i])
        if contacts.la[i, 1] == 0.0:
            note_side(sys, i, contacts)
    state.counters.steps += 1
    count_step(sys, state, contacts)
    return Status.RUNNING.value


@kernel
def begin_run(sys, state, scratch):
    """Take the start from the header; its modes are decided as an event."""
    ode, contacts = scratch.ode, scratch.contacts
    for j in range(sys.n):
        ode.x[j], ode.x[sys.n + j] = state.q[j], state.u[j]
    for i in range(sys.n_c):
        contacts.mode[i], contacts.slip[i], contacts.sign[i] = state.mode[i], state.slip[i], 1


@kernel
def slide_is_lost(sys, contacts, ode):
    """Whether the steps vanish because the motion has come to a Génot–Brogliato point."""
    status = rigid_rates(address(sys), address(contacts), ode.clock.now, ode.x, ode.f)
    return status == Status.RUNNING and contacts.numbers.determinant < NEARLY_SINGULAR


@rare_kernel(CHANGE_MODES, short_loops=True)
def change_modes(sys_at, every, state_at, record_at, scratch_at):
    """Change the modes after the event that waits, and begin anew with the rates of the new ones; returns a Status."""
    sys, state = view(sys_at, Sys), view(state_at, State)
    record, scratch = view(record_at, Record), view(scratch_at, Scratch)
    ode, events, contacts = scratch.ode, scratch.events, scratch.contacts
    n, event, is_start = sys.n, scratch.waiting, scratch.waiting == AT_START
    if is_start:
        begin_run(sys, state, scratch)
    if event == AT_VANISHED_STEP:
        if not slide_is_lost(sys, contacts, ode):
            return Status.STEP_VANISHED.value
        event = events.armed.shape[0] - 1
    contacts.facts.event = event
    t, u_0, held = ode.clock.now, scratch.touch.u_0, scratch.touch.held
    for j in range(n):
        u_0[j] = ode.x[n + j]
    for i in range(sys.n_c):
        held[i, 0], held[i, 1], held[i, 2] = contacts.mode[i], contacts.slip[i], contacts.sign[i]
    status, enters = Status.RUNNING.value, enters_region(sys, event, contacts)
    if not enters and sys.n_c > 0:
        status = switch_modes(
            sys_at, t, MOMENT * ode.clock.step, ode.x, state_at, address(contacts), address(scratch.touch),
            address(scratch.forces),
        )  # fmt: skip
        scratch.first_step = ONE_FLIGHT * contacts.numbers.flight
    if status != Status.RUNNING:
        if is_start and write_gaps(sys, t, ode.x, contacts):
            write_start(t, scratch.touch.u_0, state, record, scratch)
        return status
    for e in range(events.armed.shape[0]):
        events.armed[e] = 0
    for i in range(sys.n_c):
        events.is_gap[N_FUNCTIONS * i + CLOSURE] = 1 if contacts.mode[i] == ContactMode.OPEN else 0
    events.found.check_start = 1
    events.found.handled = event if event >= 0 else NO_EVENT
    radau_restart(not is_start and has_same_modes(held, contacts), ode)
    has_jumped = False
    for j in range(n):
        has_jumped = has_jumped or u_0[j] != ode.x[n + j]
        state.q[j], state.u[j] = ode.x[j], ode.x[n + j]
    has_slide = False
    for i in range(sys.n_c):
        has_slide = has_slide or slides(sys, i, contacts)
    if not is_start and not has_slide and (every == 0 or not has_jumped):
        return status
    status = rigid_rates(sys_at, address(contacts), t, ode.x, ode.f)
    for i in range(sys.n_c):
        if status == Status.RUNNING and slides_alone(sys, i, contacts):
            note_several(sys, t, i, enters and i == event // N_FUNCTIONS, state, contacts)
    if is_start:
        write_start(t, scratch.touch.u_0, state, record, scratch)
    if every > 0 and has_jumped:
        write_state(sys, t, ode.x, False, state, record, scratch)
    return status


@kernel
def has_same_modes(held, contacts):
    """Whether all modes are those before the event, as those of an impact between flights are."""
    for i in range(held.shape[0]):
        if held[i, 0] != contacts.mode[i] or held[i, 1] != contacts.slip[i] or held[i, 2] != contacts.sign[i]:
            return False
    return True


@kernel
def write_gaps(sys, t, x, contacts):
    """Write the gaps of a state into it; False if the gap function raised."""
    n_q, n, has_gap = contacts.q.shape[0], sys.n, sys.has & (1 << GAP)
    for j in range(n_q):
        contacts.q[j] = x[j]
    for j in range(n):
        contacts.u[j] = x[n_q + j]
    if has_gap and not evaluate(sys, GAP, t, contacts.q, contacts.u, contacts.work.g_N):
        return False
    for i in range(sys.n_c):
        x[n_q + n + i] = contacts.work.g_N[i] if has_gap else 0.0
    return True


@kernel
def write_start(t, u_0, state, record, scratch):
    """Write the row of the start: the velocities before an impact there, and nothing in the quadratures yet."""
    x, x_0, n_q, n, n_c = scratch.ode.x, scratch.events.x, state.q.shape[0], state.u.shape[0], state.mode.shape[0]
    for i in range(x.shape[0]):
        x_0[i] = x[i] if i < n_q + n + n_c else 0.0
    for j in range(n):
        x_0[n_q + j] = u_0[j]
    take_state(t, x_0, state, scratch)
    append_row(t, x_0, state, record, scratch)
    record.counts.next = 1


@kernel(FILL_HEADER, short_loops=True)
def fill_header(sys_at, t, x, is_within, state_at, scratch_at):
    """The header of the state x = (q, u, g_N, P_N, P_F, works), with its own gaps within a step; returns a Status."""
    scratch = view(scratch_at, Scratch)
    if is_within and not write_gaps(view(sys_at, Sys), t, x, scratch.contacts):
        return Status.NOT_FINITE.value
    take_state(t, x, view(state_at, State), scratch)
    return Status.RUNNING.value


@kernel
def take_state(t, x, state, scratch):
    """The header of a state whose gaps are in it."""
    take_motion(t, x, state)
    for i in range(state.mode.shape[0]):
        state.g_N[i] = x[state.q.shape[0] + state.u.shape[0] + i]
    take_contacts(x, scratch.written, state, scratch.contacts)
