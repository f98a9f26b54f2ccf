"""What a run works on: the blocks of its integrator, from the start to the rows that it leaves behind."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

import numpy as np

from nonsmooth.errors import InitialStateWarning, Status, warn_caller
from nonsmooth.integrators.contract import Handles, Integrator, Schedule
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.integrators.records import Columns, Record, Skips
from nonsmooth.jit import handle_of
from nonsmooth.jit.blocks import Block
from nonsmooth.jit.specialised import Specialised
from nonsmooth.mechanics.compiled import Model, loop_of
from nonsmooth.mechanics.initial_state import check_mass, examine_state, project_state
from nonsmooth.mechanics.inspection import inspect_start
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import GAP, System
from nonsmooth.results.motion import Motion, of_records
from nonsmooth.results.recorded import COLUMNS_OF, EVENTS, IMPULSES, KINDS, LEDGER
from nonsmooth.runs.specialise import loop_of_system
from nonsmooth.runs.times import Timetable
from nonsmooth.runs.user_events import Stop
from nonsmooth.runs.workspace import take_workspace

STEPS_PER_VISIT = 512  # measured: steps of chosen length between two visits: 10 ms of a rod, 5 s of a hundred beads


class Ongoing:
    """An integration, from its start on.

    Parameters
    ----------
    system : System
    integrator : Integrator
    table : Timetable
    q0, u0 : (n_u,)
        The start, admissible if ``project`` moves it there.
    selection : int
        The rule where there are several solutions.
    project : bool
    kept : tuple of str
        The kinds of records that its loop has to keep.
    """

    schedule: Schedule
    record: Record
    stop: Stop | None = None  # at an event of the user
    own_loop: Specialised | None = None  # for this system alone, which takes over once it is compiled

    def __init__(
        self, system: System, integrator: Integrator, table: Timetable, q0: np.ndarray, u0: np.ndarray, selection: int,
        project: bool, kept: tuple[str, ...] = KINDS,
    ) -> None:  # fmt: skip
        self.system, self.integrator, self.table, self.selection = system, integrator, table, selection
        self.kept = kept
        started = time.perf_counter()
        self.model, self.loop = self.find_loop()
        self.compile_time = time.perf_counter() - started
        self.workspace = take_workspace(system, integrator, selection, self.model)
        self.sys, self.state, self.memory = self.workspace.sys, self.workspace.state, self.workspace.memory
        skip(self.state.skips, kept)
        t_0, t_end = table.span
        self.state.now = t_0
        inspect_start(system, t_0, q0, u0, self.model)  # before a loop is compiled for a model that it refuses
        if isinstance(integrator, FixedStep):
            started = time.perf_counter()
            self.find_own_loop()
            self.compile_time += time.perf_counter() - started
        if integrator.chooses_steps:
            check_mass(system, t_0, q0, u0)
        self._take_start(t_0, q0, u0, project)
        integrator.prepare(system, t_end, self.state, self.memory)
        self.status = Status.RUNNING
        self.wall_time = 0.0

    def find_loop(self) -> tuple[Model, Callable]:
        """The model, and the loop for it."""
        return loop_of(self.system, self.integrator)

    def find_own_loop(self) -> None:
        """The loop for this system alone, where the steps that are left pay for it."""
        if isinstance(self.integrator, FixedStep):
            steps = (self.table.span[1] - self.state.now) / self.integrator.dt
            self.own_loop = loop_of_system(self.integrator, self.model, self.sys, self.state, self.memory, steps)

    def _take_start(self, t: float, q0: np.ndarray, u0: np.ndarray, project: bool) -> None:
        """The state at the start, and the modes of rigid contacts there."""
        system, state = self.system, self.state
        state.q[:], state.u[:] = q0, u0
        if self.integrator.is_rigid:
            start = examine_state(system, t, q0, u0, self.workspace.contacts)
        if project:
            q0, u0 = project_state(system, t, q0, u0)
            state.q[:], state.u[:] = q0, u0
        if self.integrator.is_rigid:
            if project:
                start = examine_state(system, t, q0, u0, self.workspace.contacts)
            if not start.is_admissible and (not project or self.integrator.chooses_steps):
                warn_caller(start.message, InitialStateWarning)
            state.mode[:], state.slip[:] = start.mode, start.slip

    def step_loop(self, max_steps: int) -> int:
        """Take at most so many steps; returns a Status."""
        if self.own_loop is not None and self.own_loop.address:
            self.loop, self.own_loop = self.own_loop.compiled, None
        blocks = self.sys, self.schedule, self.state, self.record, self.memory
        if blocks != self.workspace.handed[0]:
            set_handles(self.integrator, self.model.is_compiled, self.sys, self.schedule, self.memory)
            self.workspace.handed = blocks, self.handed(*blocks)
        sys, schedule, *others = self.workspace.handed[1]
        if self.integrator.chooses_steps:
            max_steps = min(max_steps, STEPS_PER_VISIT)
        # what is not finite is found by the loop itself; the interpreter would warn of it
        with nullcontext() if self.model.is_compiled else np.errstate(all="ignore"):
            return int(self.loop(sys, schedule, max_steps, *others))

    def handed(self, *blocks: Block) -> tuple[Any, ...]:
        """Blocks as the loop takes them: by their addresses, or themselves in the interpreter."""
        return tuple(block.address if self.model.is_compiled else block for block in blocks)

    def load_for_retry(self) -> bool:
        """Get ready what decides a contact problem that was not solved; False if there is nothing more to try."""
        started = time.perf_counter()
        is_ready = self.integrator.load_for_retry(self.system, self.memory, self.model.is_compiled)
        self.compile_time += time.perf_counter() - started
        return bool(is_ready)

    @property
    def now(self) -> float:
        """The time that the run has come to [s]."""
        return float(self.state.now) if self.stop is None else self.stop.t

    def present_row(self) -> Columns:
        """The state between two records, as a row."""
        state, row = self.state, self.bare_row()
        row.ledger[:], row.P[:] = state.ledger, state.P_sum
        if GAP in self.system.functions and len(row.g_N):
            try:
                row.g_N[0] = self.system.evaluate(GAP, float(row.t[0]), state.q, state.u)
            except Exception:  # the gap function is what failed: the gap there is not known
                row.g_N[0] = np.nan
        return row

    def bare_row(self) -> Columns:
        """The state of a run that failed before it wrote a row, as the only one."""
        shapes = columns_of(self.record)
        row = Columns(*(np.zeros((min(1, len(column)), *column.shape[1:]), column.dtype) for column in shapes))
        row.t[:], row.q[:], row.u[:] = self.now, self.state.q, self.state.u
        row.mode[:], row.slip[:] = self.state.mode, self.state.slip
        return row


def motion_between(system: System, integrator: Integrator, record: Columns, events: np.ndarray) -> Motion:
    """The motion between the records of a fixed step."""
    assert isinstance(integrator, FixedStep)
    is_straight = system.kinematics is not None
    return of_records(integrator.theta, is_straight, record.t, record.q, record.u, record.mode, events)


def skip(skips: Skips, kept: tuple[str, ...]) -> None:
    """Have a loop leave out what is not kept; a fresh one leaves out nothing."""
    if kept == KINDS:
        return
    skips.ledger, skips.impulses, skips.events = (kind not in kept for kind in (LEDGER, IMPULSES, EVENTS))


@functools.cache
def left_out(kept: tuple[str, ...]) -> tuple[str, ...]:
    """The columns of a record that are not kept."""
    return tuple(name for kind, columns in COLUMNS_OF.items() if kind not in kept for name in columns)


def columns_of(record: Record) -> Columns:
    """The columns of a record, (m, ...) each."""
    return Columns(*(getattr(record, name) for name in Columns._fields))


def set_handles(integrator: Integrator, is_compiled: bool, sys: Sys, schedule: Schedule, memory: Any) -> None:
    """Write addresses of this process into the blocks, whatever a checkpoint had."""
    if isinstance(integrator, FixedStep):
        schedule.step = handle_of(integrator.step, is_compiled)
    callbacks = tuple(handle_of(kernel, is_compiled) for kernel in integrator.callbacks)
    integrator.set_handles(sys, Handles(is_compiled, callbacks), memory)
