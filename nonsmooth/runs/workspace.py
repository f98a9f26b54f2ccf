"""The blocks of a run, kept for the next run of the same system by the same integrator: a sweep makes a million.

A workspace belongs to one run at a time: it is taken from the idle ones, and given back when the run has come to a good
end and its solution, which has arrays of its own, is made.
"""

from __future__ import annotations

import weakref
from typing import Any, cast

import numpy as np

from nonsmooth.integrators.contract import Integrator, Schedule
from nonsmooth.integrators.records import Record, State
from nonsmooth.jit.blocks import Block, handles_of, new
from nonsmooth.mechanics.compiled import Model
from nonsmooth.mechanics.contact_problem import model_facts
from nonsmooth.mechanics.initial_state import ContactsByCode
from nonsmooth.mechanics.sys import Sys, fill_numbers, new_sys
from nonsmooth.mechanics.system import System
from nonsmooth.runs.times import RecordTimes, Timetable

EVENT_CAPACITY = 256  # chosen: 26 kB; the loop comes back to have them emptied
MOST_IDLE = 4  # chosen: of one system and integrator: threads that are likely to run it
MOST_LENT = 4000  # chosen: words of a record, or times: larger blocks are allocated as fast as they are cleared
MOST_WORDS = 100_000  # chosen: 0.8 MB: larger blocks are allocated as fast as they are cleared


class Workspace:
    """The blocks of a run but its record: what is constant, the header, and the memory of the method."""

    def __init__(self, system: System, integrator: Integrator, selection: int, model: Model) -> None:
        self.task = integrator, selection
        self.model = model
        self.sys = new_sys(system, model.handle, model_facts(system))
        capacity = EVENT_CAPACITY + integrator.events_at_once * system.n_c
        self.state = new(State, **system.sizes, capacity=capacity)
        self.memory: Any = integrator.memory(system, selection)
        self.contacts = contacts_by_code(system, model, self.state, self.sys)
        # rows of events, the last of the words of a header, are read as far as they were written
        self._header = self.state.words[: -self.state.events.size or None]
        self.fresh = self._header.copy(), self.memory.words.copy()
        self._has_handles = bool(handles_of(cast(Any, type(self.memory))))
        # blocks whose handles are set, and as loops take them
        self.handed: tuple[tuple[Block, ...], tuple[Any, ...]] = (), ()
        self._schedule: Schedule | None = None
        self._times: RecordTimes | None = None  # of the schedule
        self._record: Record | None = None
        self._sizes: dict[str, int] = {}  # of the record
        self._empty = np.zeros(0)  # its words

    def renew(self, system: System) -> None:
        """Put back the numbers with which the blocks began."""
        fill_numbers(self.sys, system)
        self._header[:], words = self.fresh
        if self._has_handles:
            self.memory.restore(words.view(np.int64))
        else:
            self.memory.words[:] = words

    def schedule_of(self, table: Timetable, stop: int) -> Schedule:
        """The block of the first records of a timetable, found anew where the times are others than before."""
        if stop < table.count or stop > MOST_LENT:
            return table.schedule(0, stop)
        if self._schedule is None or table.times is not self._times:
            self._times, self._schedule = table.times, table.schedule(0, stop)
        return self._schedule

    def record_of(self, **sizes: int) -> Record:
        """An empty block for the rows and steps of a run; a small one is lent: who keeps its rows copies them."""
        if self._record is not None and sizes == self._sizes:
            self._record.words[:] = self._empty
            return self._record
        record = new(Record, **sizes)
        if len(record.words) <= MOST_LENT:
            self._record, self._sizes, self._empty = record, sizes, record.words.copy()
        return record

    def lends(self, record: Record) -> bool:
        """Whether the next run will write into a record."""
        return record is self._record


def contacts_by_code(system: System, model: Model, state: State, sys: Sys) -> ContactsByCode | None:
    """What finds gaps and velocities of contacts at the state of a block; None without machine code or contacts."""
    return ContactsByCode(system, model, state.q, state.u, sys.p) if model.is_compiled and system.n_c > 0 else None


_idle: weakref.WeakKeyDictionary[System, dict[Any, list[Workspace]]] = weakref.WeakKeyDictionary()


def take_workspace(system: System, integrator: Integrator, selection: int, model: Model) -> Workspace:
    """An idle workspace of the system's present machine code, or a new one."""
    idle = _idle.setdefault(system, {}).get((integrator, selection), [])
    try:
        while (workspace := idle.pop()).model is not model:
            pass
    except IndexError:  # none is left, or another thread took the last one
        return Workspace(system, integrator, selection, model)
    workspace.renew(system)
    return workspace


def give_back(system: System, workspace: Workspace) -> None:
    """Keep a workspace that nobody looks at any more."""
    if workspace.model.is_compiled and sum(map(len, workspace.fresh)) <= MOST_WORDS:
        idle = _idle.setdefault(system, {}).setdefault(workspace.task, [])
        if len(idle) < MOST_IDLE:
            idle.append(workspace)
