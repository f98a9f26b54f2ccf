"""A recorder that writes to a checkpoint, so that a run goes on where the checkpoint ends.

Between two blocks of steps the new records and events are appended to the files of the checkpoint; every so many
seconds all that the next step depends on is kept: the blocks of memory that the loop works in, bit by bit. A run that
goes on from there takes the steps that it would have taken. Records are never all in memory; a fixed step is given its
record times a window at a time, and the Solution maps the file.
"""

from __future__ import annotations

import math
import time
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_non_negative
from nonsmooth.checks.files import as_path
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.integrators.records import Columns, Record, bytes_of_record
from nonsmooth.jit.blocks import numbers
from nonsmooth.mechanics.description import names_in_file
from nonsmooth.results.checkpoint import EVENT_ROW, Checkpoint, Shape, layout_of, load_checkpoint
from nonsmooth.results.events import MAX_EVENTS
from nonsmooth.results.recorded import EVENTS, KINDS
from nonsmooth.results.solution import Solution, about_run, per_record, theta_of
from nonsmooth.results.stats import Stats
from nonsmooth.runs.ongoing import Ongoing, left_out
from nonsmooth.runs.recorder import Recorder, new_rows, stands_behind
from nonsmooth.signals.interruption import interrupts_held_back
from nonsmooth.views import view

WINDOW = 2**22  # chosen: bytes of records in memory


@dataclass(frozen=True)
class Place:
    """Where a run is checkpointed, what may be there, and how often its state is kept [s]."""

    path: Any
    may_begin: bool
    may_resume: bool
    seconds: float


def as_place(checkpoint: Any, resume: Any, seconds: float) -> Place:
    """Begin, go on, or, where both are given, whichever is possible."""
    for name, path in (("checkpoint", checkpoint), ("resume", resume)):
        if path is not None:
            as_path(name, path)
    if checkpoint is not None and resume is not None and str(checkpoint) != str(resume):
        raise InvalidInput(
            f"checkpoint and resume must be the same path, or one of them; got {str(checkpoint)!r} and {str(resume)!r}"
        )
    path = checkpoint if resume is None else resume
    seconds = as_non_negative("checkpoint_every", seconds, "s")
    return Place(path, checkpoint is not None, resume is not None, seconds)


class StreamingRecorder(Recorder):
    """Rows and events go to a file.

    Parameters
    ----------
    facts : callable
        ``facts(is_compiled)``: all that the bits of the run depend on.
    place : Place
    recorded : tuple of str
    """

    store: Checkpoint

    def __init__(self, facts: Any, place: Place, recorded: tuple[str, ...] = KINDS) -> None:
        super().__init__(recorded)
        self.facts, self.place = facts, place
        self.first = 0  # the record time at which the window begins
        self.last_t = math.inf  # [s] of the last row of this process; of those before it is not known

    def window(self, run: Ongoing) -> int:
        if run.integrator.chooses_steps:
            return run.table.count
        self.size = max(2, WINDOW // bytes_of_record(**run.system.sizes, left_out=left_out(run.kept)))
        return min(self.size, run.table.count)

    def room(self, run: Ongoing, keeps_steps: bool) -> Record:
        """The steps between the rows are not kept."""
        return super().room(run, keeps_steps=False)

    def begin(self, run: Ongoing) -> None:
        """Take the state that was kept, or keep that of the start."""
        system = run.system
        sizes = system.n_q, system.n_u, system.n_c, system.d
        layout = layout_of(Shape(*sizes, run.integrator.has_forces, self.recorded))
        facts = self.facts(run.model.is_compiled)
        self.store = Checkpoint(self.place.path, facts, layout, self.place.may_begin, self.place.may_resume)
        self.store.said = self._said(run)
        with ExitStack() as refused:
            refused.callback(self.store.close)
            self._take_kept(run) if self.store.kept else self._keep_start(run)
            refused.pop_all()
        self.kept_at = time.perf_counter()

    def _said(self, run: Ongoing) -> dict[str, Any]:
        """Names, the model by its name, and the theta of a run whose every step is a record."""
        is_whole = isinstance(run.integrator, FixedStep) and run.table.has_each_step
        return {"names": names_in_file(run.system.described), "model": view(Solution, "name model")(run.system),
                "theta": theta_of(run.integrator) if is_whole else None}  # fmt: skip

    def _memory(self, run: Ongoing) -> dict[str, np.ndarray]:
        """All that the next step depends on, as bits."""
        blocks = {"state": run.state.words, "memory": run.memory.words}
        return {name: words.view(np.int64) for name, words in blocks.items()} | {"counts": numbers(run.record.counts)}

    def _take_kept(self, run: Ongoing) -> None:
        run.load_for_retry()  # the loop may reach it: the state says whether
        require_sizes(self.store, self._memory(run))
        run.state.restore(self.store.kept["state"])
        run.memory.restore(self.store.kept["memory"])
        numbers(run.record.counts)[:] = self.store.kept["counts"]
        self._open_window(run)
        run.status = Status.FINISHED if self.store.status == Status.FINISHED else Status.RUNNING

    def _keep_start(self, run: Ongoing) -> None:
        run.step_loop(0)  # writes the record of the start
        self._write(run)
        self._keep(run)

    def _open_window(self, run: Ongoing) -> None:
        """Give a fixed step the record times from the last record on."""
        if run.integrator.chooses_steps:
            return
        self.first = max(0, self.store.count("records") - 1)
        run.state.counters.interval = 0
        run.schedule = run.table.schedule(self.first, min(self.first + self.size, run.table.count))

    def take(self, run: Ongoing, status: int) -> int:
        with interrupts_held_back():
            self._write(run)
            if status == Status.FINISHED and self.first + len(run.schedule.t) < run.table.count:
                self._open_window(run)
                status = Status.RUNNING
            if status == Status.RUNNING and time.perf_counter() - self.kept_at >= self.place.seconds:
                self._keep(run)
                self.kept_at = time.perf_counter()
        return status

    def take_events(self, run: Ongoing) -> None:
        """They are written with the records."""

    def end(self, run: Ongoing) -> None:
        with interrupts_held_back():
            self._write(run)
            last = None if run.status == Status.FINISHED else self._last_row(run)
            if last is not None:
                self.store.write_last({"records": self._as_rows(last)})
            self._keep(run)

    def close(self) -> None:
        self.store.close()

    def _last_row(self, run: Ongoing) -> Columns | None:
        """The state at which the run stopped, where no record shows it."""
        if not self.store.count("records"):
            return run.bare_row()
        return run.present_row() if stands_behind(run, self.last_t) else None

    def _write(self, run: Ongoing) -> None:
        """Append the records and events that are new."""
        counters = run.state.counters
        events = np.ascontiguousarray(run.state.events[: counters.n_events]).view(EVENT_ROW)[:, 0]
        rows = new_rows(run.record)
        self.store.write({"records": self._as_rows(rows), "events": events})
        self.last_t = rows.t[-1] if len(rows.t) else self.last_t
        counters.n_events = 0
        if EVENTS in self.recorded:
            self.events_dropped = max(0, self.store.count("events") - MAX_EVENTS)

    def _keep(self, run: Ongoing) -> None:
        ended = "" if run.status == Status.RUNNING else run.message()
        stats = Stats(**vars(run.stats()) | {"wall_time": self.store.wall_time + run.wall_time})
        self.store.keep(self._memory(run), about_run(run.system, run.integrator), run.status, ended, stats)

    def _as_rows(self, record: Columns) -> np.ndarray:
        """Records as rows of the file."""
        row = self.store.layout.rows["records"]
        rows = np.empty(len(record.t), row)
        columns = per_record(record, self.recorded, has_forces=True) | {"ledger": record.ledger}
        for name in row.names or ():
            rows[name] = columns[name]
        return rows

    def stored(self, run: Ongoing) -> Solution:
        return load_checkpoint(self.store.path, lambda *_: run.system, is_verified=True)


def require_sizes(store: Checkpoint, memory: dict[str, np.ndarray]) -> None:
    """Raise `InvalidInput` unless the arrays that were kept have the sizes of those that they go to."""
    for name, array in memory.items():
        if name not in store.kept or store.kept[name].shape != array.shape:
            raise InvalidInput(f"the checkpoint {str(store.path)!r} is damaged: {name} has another size")
