"""Where the rows, the steps and the events of a run go: into memory.

A method with a fixed step has a row for each record time from the beginning on, and keeps it there. The rows of one
that chooses its steps are taken from block to block, and so are its steps, where the motion is wanted.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.checks.memory import require_memory
from nonsmooth.errors import Status
from nonsmooth.integrators.contract import Integrator
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.integrators.records import EVENT_T, EVENT_WIDTH, Columns, Record, bytes_of_record, no_rows
from nonsmooth.results.events import MAX_EVENTS
from nonsmooth.results.recorded import KINDS
from nonsmooth.results.solution import Solution
from nonsmooth.runs.ongoing import STEPS_PER_VISIT, Ongoing, columns_of, left_out

ROW_CAPACITY = 4096  # chosen: rows between two visits of Python

Steps = tuple[np.ndarray, ...]  # t, h, q, u, B of results/motion.py


class Recorder:
    """The rows, steps and events of a run in memory.

    Parameters
    ----------
    recorded : tuple of str
        The kinds that are recorded.
    is_watched : bool
        Whether somebody looks at all rows while the run goes on.
    """

    def __init__(self, recorded: tuple[str, ...] = KINDS, is_watched: bool = False) -> None:
        self.recorded, self.is_watched = recorded, is_watched
        self.rows: list[Columns] = []
        self.steps: list[Steps] = []
        self.events: list[np.ndarray] = []
        self.events_dropped = 0

    def kept(self, integrator: Integrator) -> tuple[str, ...]:
        """The kinds that the loop has to keep: a method that chooses its steps needs all itself."""
        return self.recorded if isinstance(integrator, FixedStep) and not self.is_watched else KINDS

    def window(self, run: Ongoing) -> int:
        """How many record times the run is given at once."""
        if not run.integrator.chooses_steps:
            needed = bytes_of_record(**run.system.sizes, left_out=left_out(run.kept)) * float(run.table.count)
            count = run.table.count
            require_memory(needed, f"{count} records", "take a larger every or dt")
        return run.table.count

    def room(self, run: Ongoing, keeps_steps: bool) -> Record:
        """The block for the rows of the run, and for the steps of a block where they are wanted."""
        integrator, system = run.integrator, run.system
        rows = ROW_CAPACITY if run.schedule.every > 0 else len(run.schedule.t)
        steps = 0 if not integrator.chooses_steps else integrator.pieces * STEPS_PER_VISIT if keeps_steps else 1
        lengths = {"forces": rows if integrator.has_forces else 0, "steps": steps, **no_rows(left_out(run.kept))}
        record = run.workspace.record_of(m=rows, **system.sizes, degree=integrator.degree, **lengths)  # fmt: skip
        record.steps.is_kept = keeps_steps and integrator.chooses_steps
        return record

    def begin(self, run: Ongoing) -> None:
        """Get ready before the first block."""

    def take(self, run: Ongoing, status: int) -> int:
        """Take what a block of steps left behind; returns the status with which the run goes on."""
        if run.integrator.chooses_steps:
            self.rows.append(without(left_out(self.recorded), new_rows(run.record)))
            if run.record.steps.is_kept:
                self.steps.append(new_steps(run.record))
        return status

    def take_events(self, run: Ongoing) -> None:
        """Take the events, as many as there is room for."""
        counters = run.state.counters
        count = int(counters.n_events)
        if count == 0:
            return
        room = MAX_EVENTS - sum(len(rows) for rows in self.events)
        self.events.append(run.state.events[: min(count, room)].copy())
        self.events_dropped += max(0, count - room)
        counters.n_events = 0

    def end(self, run: Ongoing) -> None:
        """The run has come to its end, or was stopped."""

    def close(self) -> None:
        """Nothing is written any more."""

    def has_all_steps(self, run: Ongoing) -> bool:
        """Whether the motion within every step was kept."""
        return bool(self.steps) and sum(len(block[0]) for block in self.steps) >= run.state.counters.steps

    def records(self, run: Ongoing) -> Columns:
        """All rows; of an unfinished run also the state it is in, where no row shows it."""
        count = run.record.counts.rows
        written = Columns(*(column[:count] for column in columns_of(run.record)))
        if run.workspace.lends(run.record):
            written = Columns(*(column.copy() for column in written))
        parts = [*self.rows, written]
        ends = [part.t[-1] for part in parts if len(part.t)]
        if not ends:
            parts.append(run.bare_row())
        elif run.status != Status.FINISHED and stands_behind(run, ends[-1]):
            parts.append(run.present_row())
        parts = [without(left_out(self.recorded), part) for part in parts]
        if len(parts) == 1:
            return parts[0]
        return Columns(*map(np.concatenate, zip(*parts, strict=True)))

    def event_rows(self) -> np.ndarray:
        """All events in the order of their times: a contact that closes after bounces is dated by their end."""
        if not self.events:
            return np.zeros((0, EVENT_WIDTH))
        rows = np.concatenate(self.events) if len(self.events) > 1 else self.events[0]
        if len(rows) == 1:
            return rows
        return rows[np.argsort(rows[:, EVENT_T], kind="stable")]

    def stored(self, run: Ongoing) -> Solution | None:
        """The solution, where the recorder holds it."""
        return None


def stands_behind(run: Ongoing, t: float) -> bool:
    """Whether a run has gone on since its last row, at the time t [s]."""
    return bool(run.time() > t if run.integrator.chooses_steps else run.state.counters.step > 0)


def without(names: tuple[str, ...], rows: Columns) -> Columns:
    """Rows without some columns, which are empty."""
    return rows._replace(**{name: getattr(rows, name)[:0] for name in names}) if names else rows


def new_rows(record: Record) -> Columns:
    """Take the rows out of a record."""
    count = record.counts.rows
    rows = Columns(*(column[:count].copy() for column in columns_of(record)))
    record.counts.rows = 0
    return rows


def new_steps(record: Record) -> Steps:
    """Take the steps out of a record."""
    steps = record.steps
    taken = tuple(column[: steps.n_steps].copy() for column in (steps.t, steps.h, steps.q, steps.u, steps.B))
    steps.n_steps = 0
    return taken
