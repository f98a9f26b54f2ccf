"""The loop of a run whose events are located: change the modes, step, look for an event, take the step, write rows.

The step is that of radau/method.py, cut at the first event within it (radau/events.py). Of the modes the loop knows
nothing: what follows an event, what else a step must satisfy, and what the state means, are entry points of the method,
which it calls by their addresses. The state is x = (q, u, gaps, ..., P_N, P_F, works), see radau/header.py.

An event waits in ``memory.waiting`` until it is handled, at the beginning of the next step; so do the start, a
resumption, and a step that has vanished.
"""

from __future__ import annotations

import math
from typing import Annotated as Array
from typing import Any

from nonsmooth.errors import Status
from nonsmooth.integrators.contract import EVENTS_AT_ONCE, LOOP, Handles, Integrator, Schedule, Suspect
from nonsmooth.integrators.radau.events import MAX_STALLS, NO_EVENT, TOO_LONG, Events, locate_event, longest_step
from nonsmooth.integrators.radau.header import note_impulses, radau_suspects, state_at_moment, take_counts
from nonsmooth.integrators.radau.method import SMALLEST_STEP, radau_step
from nonsmooth.integrators.radau.polynomial import CURVED_DEGREE, STEP_DEGREE, begin_polynomial, end_polynomial
from nonsmooth.integrators.radau.stages import Radau, rates_at
from nonsmooth.integrators.records import Record, State, is_full, write_row
from nonsmooth.jit import Callback, Kernel, kernel
from nonsmooth.jit.blocks import Block, Floats, Handle, address, view
from nonsmooth.mechanics.sys import Sys

# code: what may wait in place of an event: the start, a step that vanished
AT_START, AT_VANISHED_STEP = -2, -3

# change_modes(sys, every, state, record, memory) -> Status: the modes after the event that waits, the rows of a jump
CHANGE_MODES = "int64(int64, int64, int64, int64, int64)"
change_modes_at = Callback(CHANGE_MODES)
# accept_step(sys, t, state, memory) -> Status: the step that was tried is taken, to the time t
ACCEPT_STEP = "int64(int64, float64, int64, int64)"
accept_step_at = Callback(ACCEPT_STEP)
# fill_header(sys, t, x, is_within, state, memory) -> Status: the header of the state x, whose rates were evaluated; of
# one within a step the gaps were not
FILL_HEADER = "int64(int64, float64, float64[::1], boolean, int64, int64)"
fill_header_at = Callback(FILL_HEADER)


class Located(Block):
    """What the loop needs, first in the memory of a method, which says the sizes of ``ode`` and ``events``."""

    change_modes: Handle  # of ``change_modes_at``, and so on
    accept_step: Handle
    fill_header: Handle
    waiting: int  # the event that is to be handled, NO_EVENT or a code
    stalls: int  # events in a row without any motion
    first_step: float  # [s] the longest step until one is taken
    ode: Radau
    events: Events
    written: Array[Floats, "n_c", "1 + max(1, d)"]  # impulses at the last row


@kernel(LOOP, short_loops=True)
def run(sys_at, schedule_at, max_steps, state_at, record_at, memory_at):
    """Advance by at most max_steps steps; returns a Status.

    Rows are written every so many steps and at every event, before and after it, or, where every = 0, at the times t.
    The last of these is the end.
    """
    sys, schedule = view(sys_at, Sys), view(schedule_at, Schedule)
    state, record, memory = view(state_at, State), view(record_at, Record), view(memory_at, Located)
    ode = memory.ode
    if state.counters.is_begun == 0:
        state.counters.is_begun = 1
        ode.clock.now, memory.first_step, memory.waiting = state.now, math.inf, AT_START
    status = advance(sys, schedule, max_steps, state, record, memory)
    take_counts(ode, state)
    return status


@kernel
def advance(sys, schedule, max_steps, state, record, memory):
    """``run``, that leaves the counts of the method. The header is that of the last step or event that was accepted,
    whatever the status says."""
    ode, events, every = memory.ode, memory.events, schedule.every
    clock, found, t_end = ode.clock, events.found, schedule.t[schedule.t.shape[0] - 1]
    for _ in range(max_steps):
        if is_full(2 * min(every, 1), EVENTS_AT_ONCE * sys.n_c, state, record):
            return Status.RUNNING.value
        if memory.waiting != NO_EVENT:
            status = handle_event(sys, every, state, record, memory)
            if status != Status.RUNNING:
                return status
        t = clock.now
        if not t_end - t > SMALLEST_STEP * abs(t):
            return Status.FINISHED.value
        status = radau_step(address(sys), min(t_end - t, memory.first_step, longest_step(events)), address(ode))
        if status == Status.RUNNING:
            status = locate_event(address(sys), address(ode), address(events))
        if status == Status.STEP_VANISHED:  # at a place that the method may know
            memory.waiting = AT_VANISHED_STEP
            continue
        if status != Status.RUNNING:
            return status
        if found.which == TOO_LONG:
            continue
        memory.waiting = found.which
        if found.is_immediate == 0:
            t_1 = t_end if clock.done == t_end - t else t + clock.done
            status = take_step(sys, t_1, schedule, state, record, memory)
            if status != Status.RUNNING:
                return status
            if t_1 - t > SMALLEST_STEP * abs(t_end):  # at t = 0 steps of 1e-24 s would get on, but not to the end
                memory.stalls = 0
    return Status.RUNNING.value


@kernel
def handle_event(sys, every, state, record, memory):
    """Let the method change the modes; returns a Status."""
    if memory.waiting != AT_START:
        memory.stalls += 1
        if memory.stalls > MAX_STALLS * memory.events.armed.shape[0]:
            return Status.CHATTERING.value
    status = change_modes_at(memory.change_modes, address(sys), every, address(state), address(record), address(memory))
    if status == Status.RUNNING:
        memory.waiting = NO_EVENT
        fill_header(sys, memory.ode.clock.now, memory.ode.x, state, memory)
    return status


@kernel
def take_step(sys, t_1, schedule, state, record, memory):
    """Take the step that was tried, to the time t_1, and write the rows that are due; returns a Status."""
    ode, every, t = memory.ode, schedule.every, memory.ode.clock.now
    begin_polynomial(t, sys.n, ode, record.steps)
    status = accept_step_at(memory.accept_step, address(sys), t_1, address(state), address(memory))
    if status != Status.RUNNING:
        return status
    ode.clock.now, memory.first_step = t_1, math.inf
    end_polynomial(sys.n, ode, record.steps)
    if every == 0:
        status = write_rows(sys, t, t_1, schedule, state, record, memory)
        fill_header(sys, t_1, ode.x, state, memory)
        return status
    is_end = t_1 == schedule.t[schedule.t.shape[0] - 1] or memory.waiting != NO_EVENT
    if state.counters.steps % every == 0 or is_end:
        return write_state(sys, t_1, ode.x, False, state, record, memory)
    fill_header(sys, t_1, ode.x, state, memory)
    return status


@kernel
def write_rows(sys, t, t_1, schedule, state, record, memory):
    """Write the rows of the record times in (t, t_1], of the step that was taken; returns a Status. Forces are those
    of its end then."""
    ode, x, t_record, status = memory.ode, memory.events.x, schedule.t, Status.RUNNING.value
    is_written = False
    while record.counts.next < t_record.shape[0] and t_record[record.counts.next] <= t_1:
        moment = t_record[record.counts.next]
        state_at_moment(moment, t, ode, record.steps, x)
        status = rates_at(ode.rates, address(sys), ode.context, moment, x, ode.f)
        if status == Status.RUNNING:
            status = write_state(sys, moment, x, True, state, record, memory)
        if status != Status.RUNNING:
            return status
        record.counts.next += 1
        is_written = True
    if is_written:
        status = rates_at(ode.rates, address(sys), ode.context, t_1, ode.x, ode.f)
    return status


@kernel
def fill_header(sys, t, x, state, memory):
    """The header of a state that was accepted."""
    fill_header_at(memory.fill_header, address(sys), t, x, False, address(state), address(memory))


@kernel
def write_state(sys, t, x, is_within, state, record, memory):
    """Append a row of the state x, whose rates were evaluated; returns a Status."""
    status = fill_header_at(memory.fill_header, address(sys), t, x, is_within, address(state), address(memory))
    if status == Status.RUNNING:
        append_row(t, x, state, record, memory)
    return status


@kernel
def append_row(t, x, state, record, memory):
    """Append a row of the header, which was taken from the state x; impulses are counted anew from here."""
    write_row(t, state, record)
    note_impulses(x, memory.written)


class LocatesEvents(Integrator):
    """A method of this loop. Its ``callbacks`` are the rates, the event functions, ``change_modes``, ``accept_step``
    and ``fill_header``; its memory is a `Located` with ``contacts``, and what else these need."""

    locates_events = True
    has_forces = True
    degree = STEP_DEGREE
    curved = CURVED_DEGREE

    @property
    def loop(self) -> Kernel:
        """The loop over the steps."""
        return run

    def set_handles(self, sys: Sys, handles: Handles, memory: Any) -> None:
        """What the loop calls."""
        ode, events = memory.ode, memory.events
        ode.rates, events.functions, memory.change_modes, memory.accept_step, memory.fill_header = handles.callbacks
        ode.context = handles.of(memory.contacts)

    def suspects(self, schedule: Schedule, state: State, memory: Any) -> list[Suspect]:
        """Where a step of Radau calls the rates."""
        return radau_suspects(state, memory.ode)
