"""What a run with compliant contacts does beside the loop of radau/located.py: its start, its steps, its events.

What is integrated and what a mode is, is in penalty/rates.py, how a mode changes in penalty/switching.py.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.errors import Status
from nonsmooth.integrators.penalty.rates import OMEGA, Contacts, length_along
from nonsmooth.integrators.penalty.switching import begin_contacts, change_mode, follow_slide, note_speed, rounded_speed
from nonsmooth.integrators.radau.events import NO_EVENT, Events
from nonsmooth.integrators.radau.header import take_contacts, take_motion
from nonsmooth.integrators.radau.located import (
    ACCEPT_STEP,
    AT_START,
    AT_VANISHED_STEP,
    CHANGE_MODES,
    FILL_HEADER,
    Located,
    write_state,
)
from nonsmooth.integrators.radau.method import radau_accept, radau_restart
from nonsmooth.integrators.radau.stages import Radau
from nonsmooth.integrators.records import IMPACT, MODE_CHANGE, N_FUNCTIONS, N_WORKS, Record, State, append_event
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Floats, address, view
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import ContactMode


class Scratch(
    Located, n_q=0, motion="n + (n_q or n)", impulses="(1 + max(1, d)) * n_c", works=N_WORKS,
    x="motion + 2 * n_c + impulses + works", functions=f"{N_FUNCTIONS} * n_c",
):  # fmt: skip
    """Arrays of a run with compliant contacts. With q' = B u no part of the motion is eliminated from the stages."""

    ode: Array[Radau, "m = 0 if n_q else n", "n = motion + 2 * n_c", "quadratures = impulses + works"]
    events: Array[Events, "n_events = functions", "n_x = x"]
    contacts: Array[Contacts, "n_q = n_q"]
    before: Array[Floats, "n_c", "1 + max(1, d)"]  # impulses at the last change of mode


@kernel(ACCEPT_STEP, short_loops=True)
def accept_step(sys_at, t, state_at, scratch_at):
    """Take the step that was tried, to the time t; returns a Status."""
    state, scratch = view(state_at, State), view(scratch_at, Scratch)
    status = radau_accept(sys_at, scratch.ode)
    if status == Status.RUNNING:
        note_step(view(sys_at, Sys), t, state, scratch)
    return status


@kernel
def note_step(sys, t, state, scratch):
    """Count a step to the time t, keep the state, the deepest indentation and the courses of slides in space."""
    x, first = scratch.ode.x, sys.n_q + sys.n
    take_motion(t, x, state)
    note_speed(sys, scratch.contacts)
    for i in range(state.mode.shape[0]):
        depth = -x[first + i] / scratch.contacts.constants[i, OMEGA]
        state.worst.penetration = max(state.worst.penetration, depth)
        if sys.kinds[i, 1] == 2 and scratch.contacts.mode[i] == ContactMode.SLIDE:
            follow_slide(2, i, scratch.contacts)
    state.counters.steps += 1


@kernel(CHANGE_MODES, short_loops=True)
def change_modes(sys_at, every, state_at, record_at, scratch_at):
    """Change a mode after the event that waits, and begin anew with the rates of the new one; returns a Status."""
    sys, state = view(sys_at, Sys), view(state_at, State)
    record, scratch = view(record_at, Record), view(scratch_at, Scratch)
    if scratch.waiting == AT_START:
        return begin_run(sys, state, record, scratch)
    if scratch.waiting == AT_VANISHED_STEP:
        return Status.STEP_VANISHED.value
    ode, events, contacts, which = scratch.ode, scratch.events, scratch.contacts, scratch.waiting
    for i in range(sys.n_c):
        state.mode[i], state.slip[i] = contacts.mode[i], contacts.slip[i]
    status = change_mode(sys, ode.clock.now, ode.x, which, contacts, ode.f)
    if status != Status.RUNNING:
        return status
    for i in range(sys.n_c):
        if contacts.mode[i] != state.mode[i] or contacts.slip[i] != state.slip[i] or i == which // N_FUNCTIONS:
            for m in range(N_FUNCTIONS):
                events.armed[N_FUNCTIONS * i + m] = 0
        if contacts.mode[i] != state.mode[i] or contacts.slip[i] != state.slip[i]:
            note_event(sys, ode.clock.now, i, state, scratch)
            state.mode[i], state.slip[i] = contacts.mode[i], contacts.slip[i]
    events.found.check_start, events.found.handled = 1, which
    radau_restart(False, ode)
    return Status.RUNNING.value


@kernel
def begin_run(sys, state, record, scratch):
    """The modes and the row of the start; returns a Status."""
    ode, found = scratch.ode, scratch.events.found
    found.check_start, found.handled = 1, NO_EVENT
    note_speed(sys, scratch.contacts)
    status = begin_contacts(address(sys), ode.clock.now, ode.x, address(scratch.contacts), ode.f)
    if status == Status.RUNNING:
        status = write_state(sys, ode.clock.now, ode.x, False, state, record, scratch)
        record.counts.next = 1
    return status


@kernel
def note_event(sys, t, i, state, scratch):
    """Append the change of mode of contact i, with its impulses since the change before; none at the start."""
    contacts, x, before = scratch.contacts, scratch.ode.x, scratch.before
    first, n_c = sys.n_q + sys.n + 2 * sys.n_c + i, sys.n_c
    for part in range(before.shape[1]):
        before[i, part] = x[first + part * n_c] - before[i, part]
    if state.counters.steps > 0:
        event = state.event
        event.P_N, event.P_F, event.solutions = before[i, 0], along(sys, before, i), 1
        event.gamma_N, event.gamma_F = contacts.gamma[i, 0], along(sys, contacts.gamma, i)
        is_impact = state.mode[i] == ContactMode.OPEN and contacts.gamma[i, 0] < -rounded_speed(sys, contacts)
        kind = IMPACT if is_impact else MODE_CHANGE
        append_event(t, kind, i, state.mode[i], state.slip[i], contacts.mode[i], contacts.slip[i], state)
    for part in range(before.shape[1]):
        before[i, part] = x[first + part * n_c]


@kernel
def along(sys, pairs, i):
    """What contact i has along the surface: with its sign in the plane, its size in space."""
    return length_along(pairs, i) if sys.kinds[i, 1] == 2 else pairs[i, 1]


@kernel(FILL_HEADER, short_loops=True)
def fill_header(sys_at, t, x, is_within, state_at, scratch_at):
    """The header of the state x = (q, u, z, v, P_N, P_F, works); returns a Status."""
    state, scratch = view(state_at, State), view(scratch_at, Scratch)
    take_motion(t, x, state)
    first = state.q.shape[0] + state.u.shape[0]
    for i in range(state.mode.shape[0]):
        state.g_N[i] = x[first + i] / scratch.contacts.constants[i, OMEGA]
    take_contacts(x, scratch.written, state, scratch.contacts)
    return Status.RUNNING.value
