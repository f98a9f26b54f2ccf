"""Event-driven integration with q' = B u, or friction in two directions, for the loop of radau/located.py.

The modes and their equations are in space_motion.py, how they change in space_switching.py.
"""

from __future__ import annotations

import math
from typing import Annotated as Array
from typing import Any

from nonsmooth.contact.planar.selection import Selection
from nonsmooth.contact.spatial.solve import solve_spatial
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.event_driven.loop import NEARLY_SINGULAR, ONE_FLIGHT, take_state, write_gaps, write_start
from nonsmooth.integrators.event_driven.options import EventDriven, refused_in_space
from nonsmooth.integrators.event_driven.space_hold import hold
from nonsmooth.integrators.event_driven.space_motion import (
    FORCELESS,
    SpaceContacts,
    space_events,
    space_forces,
    space_rates,
    take_course,
)
from nonsmooth.integrators.event_driven.space_switching import switch_in_space
from nonsmooth.integrators.penalty.switching import note_speed
from nonsmooth.integrators.radau.events import NO_EVENT, Events, locate_event
from nonsmooth.integrators.radau.header import take_motion
from nonsmooth.integrators.radau.located import (
    ACCEPT_STEP,
    AT_START,
    AT_VANISHED_STEP,
    CHANGE_MODES,
    FILL_HEADER,
    Located,
    write_state,
)
from nonsmooth.integrators.radau.method import radau_accept, radau_restart, radau_shorten, radau_step
from nonsmooth.integrators.radau.stages import Radau, newton
from nonsmooth.integrators.records import CLOSURE, N_FUNCTIONS, N_WORKS, Record, State
from nonsmooth.jit import Kernel, kernel, rare_kernel
from nonsmooth.jit.blocks import address, new, view
from nonsmooth.mechanics.impact_in_space import collide_in_space
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import ContactMode, System


class Scratch(
    Located,
    n_q=0,
    others=f"(2 + max(1, d)) * n_c + {N_WORKS}",
    functions=f"{N_FUNCTIONS} * n_c",
    motion="n + (n_q or n)",
):
    """Arrays of a run. With q' = B u no part of the motion is eliminated from the stages."""

    ode: Array[Radau, "m = 0 if n_q else n", "n = motion", "quadratures = others"]
    events: Array[Events, "n_events = functions", "n_x = motion + others"]
    contacts: Array[SpaceContacts, "n_q = n_q"]


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
    note_speed(sys, c)
    for i in range(sys.n_c):
        state.worst.penetration = max(state.worst.penetration, -ode.x[sys.n_q + sys.n + i])
        if c.mode[i] == ContactMode.SLIDE:
            take_course(i, c)
    state.counters.steps += 1
    return status


@rare_kernel(CHANGE_MODES, short_loops=True)
def change_modes(sys_at, every, state_at, record_at, scratch_at):
    """Change the modes after the event that waits, and begin with the rates of the new ones; returns a Status."""
    sys, state = view(sys_at, Sys), view(state_at, State)
    record, scratch = view(record_at, Record), view(scratch_at, Scratch)
    ode, events, c = scratch.ode, scratch.events, scratch.contacts
    n_q, n, event, t = sys.n_q, sys.n, scratch.waiting, ode.clock.now
    is_start = event == AT_START
    if is_start:
        for j in range(n_q):
            ode.x[j] = state.q[j]
        for j in range(n):
            ode.x[n_q + j] = state.u[j]
        for i in range(sys.n_c):
            c.mode[i], c.slip[i] = state.mode[i], 0
    if event == AT_VANISHED_STEP:
        event = find_lost_slide(sys_at, t, ode.x, c)
        if event == NO_EVENT:
            return Status.STEP_VANISHED.value
    for j in range(n):
        c.u_0[j] = ode.x[n_q + j]
    for i in range(sys.n_c):
        c.was[i] = c.mode[i]
    status = switch_in_space(sys_at, t, event, ode.x, state_at, address(c)) if sys.n_c > 0 else Status.RUNNING.value
    scratch.first_step = ONE_FLIGHT * c.numbers.flight if sys.n_c > 0 else math.inf
    if status != Status.RUNNING:
        if is_start and write_gaps(sys, t, ode.x, c):
            write_start(t, c.u_0, state, record, scratch)
        return status
    flies_on = not is_start
    for e in range(events.armed.shape[0]):
        events.armed[e] = 0
    for i in range(sys.n_c):
        events.is_gap[N_FUNCTIONS * i + CLOSURE] = 1 if c.mode[i] == ContactMode.OPEN else 0
        flies_on = flies_on and c.mode[i] == ContactMode.OPEN and c.was[i] == ContactMode.OPEN
    events.found.check_start, events.found.handled = 1, max(event, NO_EVENT)
    radau_restart(flies_on, ode)
    has_jumped = False
    for j in range(n_q):
        state.q[j] = ode.x[j]
    for j in range(n):
        has_jumped = has_jumped or c.u_0[j] != ode.x[n_q + j]
        state.u[j] = ode.x[n_q + j]
    status = space_rates(sys_at, address(c), t, ode.x, ode.f)
    if is_start:
        write_start(t, c.u_0, state, record, scratch)
    if every > 0 and has_jumped:
        write_state(sys, t, ode.x, False, state, record, scratch)
    return status


@kernel
def find_lost_slide(sys_at, t, x, c):
    """The event function of the slide whose force grows without bound where steps vanish; NO_EVENT if there is none."""
    if space_forces(sys_at, t, x, address(c)) != Status.RUNNING:
        return NO_EVENT
    which, least = NO_EVENT, NEARLY_SINGULAR
    for i in range(c.mode.shape[0]):
        if c.mode[i] == ContactMode.SLIDE and abs(c.p[i]) < least:
            which, least = N_FUNCTIONS * i + FORCELESS, abs(c.p[i])
    return which


@kernel(FILL_HEADER, short_loops=True)
def fill_header(sys_at, t, x, is_within, state_at, scratch_at):
    """The header of a state, with its own gap within a step; returns a Status."""
    scratch = view(scratch_at, Scratch)
    if is_within and not write_gaps(view(sys_at, Sys), t, x, scratch.contacts):
        return Status.NOT_FINITE.value
    take_state(t, x, view(state_at, State), scratch)
    return Status.RUNNING.value


class EventDrivenInSpace(EventDriven):
    """`EventDriven` of a system with q' = B u or friction in two directions, as `simulate` takes it there."""

    is_spatial = True
    callbacks = (space_rates, space_events, change_modes, accept_step, fill_header)

    def __repr__(self) -> str:
        return f"EventDriven(rtol={self.rtol!r}, atol={self.atol!r})"

    def entry_points(self, system: System) -> list[Kernel]:
        """What the loop may reach, itself first."""
        reached = [space_forces, radau_step, radau_shorten, newton, locate_event]
        if system.n_c > 0:
            reached += [switch_in_space, collide_in_space]
        if system.n_c > 1:
            reached += [solve_spatial]
        return [self.loop, *self.callbacks, *reached]

    def memory(self, system: System, selection: int) -> Any:
        """The arrays of a run, with the tolerances."""
        require_followed(system, selection)
        arrays = new(Scratch, **system.sizes)
        arrays.contacts.numbers.atol, arrays.contacts.numbers.rtol = self.atol, self.rtol
        arrays.ode.atol[:], arrays.ode.clock.rtol = self.atol, self.rtol
        return arrays

    def reason(self, status: Status, state: State, memory: Any) -> str:
        """Of coupled contacts for which no set of modes was found."""
        if status != Status.NOT_SOLVED:
            return ""
        closed = int((memory.contacts.mode != ContactMode.OPEN).sum())
        return (
            f"at t = {state.now:.9g} s no modes were found for coupled contacts, {closed} of which are closed; time "
            "stepping goes on through that, as Adaptive or MoreauJean(dt)"
        )


def require_followed(system: System, selection: int) -> None:
    """Raise `InvalidInput` unless a system in space is one that is followed from event to event."""
    for what in refused_in_space(system):
        raise InvalidInput(f"in space EventDriven takes {what}; MoreauJean(dt=...) and Adaptive simulate it")
    if selection != Selection.COMPLIANT_LIMIT:
        raise InvalidInput('in space EventDriven follows the rule selection="compliant-limit" alone')
