"""Event-driven integration of one contact with friction in two directions, for the loop of radau/located.py.

The modes and their equations are in space_motion.py, how they change in space_switching.py.
"""

from __future__ import annotations

from typing import Annotated as Array
from typing import Any

from nonsmooth.contact.planar.selection import Selection
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.event_driven.loop import NEARLY_SINGULAR, ONE_FLIGHT, take_state, write_gaps, write_start
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.integrators.event_driven.space_motion import (
    FORCELESS,
    SpaceContact,
    hold,
    space_events,
    space_forces,
    space_rates,
)
from nonsmooth.integrators.event_driven.space_switching import switch_in_space, take_course
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
from nonsmooth.mechanics.laws import LAW_E_F
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import UNILATERAL, ContactMode, System


class Scratch(Located, others=f"4 * n_c + {N_WORKS}", functions=f"{N_FUNCTIONS} * n_c"):
    """Arrays of a run."""

    ode: Array[Radau, "m = n", "n = 2 * n", "quadratures = others"]
    events: Array[Events, "n_events = functions", "n_x = 2 * n + others"]
    contacts: SpaceContact


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


@rare_kernel(CHANGE_MODES, short_loops=True)
def change_modes(sys_at, every, state_at, record_at, scratch_at):
    """Change the mode after the event that waits, and begin with the rates of the new one; returns a Status."""
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
            write_start(t, c.u_0, state, record, scratch)
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
        write_start(t, c.u_0, state, record, scratch)
    if every > 0 and has_jumped:
        write_state(sys, t, ode.x, False, state, record, scratch)
    return status


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
