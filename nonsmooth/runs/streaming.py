"""Runs that write their rows to a checkpoint as they go, and go on where the checkpoint ends.

Between two blocks the new records and events are appended to the files of the checkpoint; every so many seconds all
that the next step depends on is kept: the blocks of memory that the loop works in, bit by bit. A run that goes on from
there takes the steps that it would have taken. Records are never all in memory; the Solution maps the file.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_non_negative
from nonsmooth.checks.files import as_path
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.records import Columns
from nonsmooth.results.checkpoint import Checkpoint, load_checkpoint
from nonsmooth.results.solution import MAX_EVENTS, Solution, Stats, about_run
from nonsmooth.runs.run import Run
from nonsmooth.signals.interruption import interrupts_held_back


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


class Streaming(Run):
    """What makes a run one that streams; it stands before the run's class among the bases."""

    store: Checkpoint

    def new_rows(self) -> np.ndarray:
        """Take the records that are not in the file yet, as its rows."""
        raise NotImplementedError

    def memory(self) -> dict[str, np.ndarray]:
        """All that the next step depends on, as bits."""
        return {"state": self.state.words.view(np.int64), "scratch": self.scratch.words.view(np.int64)}

    def go_on(self) -> None:
        """Get ready after the memory was filled with what was kept."""

    def next_window(self, status: int) -> int:
        """Make room for more records where the loop came to the end of its own."""
        return status

    def last_row(self) -> np.ndarray | None:
        """The state at which the run stopped, where no record shows it."""
        return None

    def attach(self, store: Checkpoint, seconds: float) -> None:
        """Take the state that was kept, or keep that of the start."""
        self.store, self.seconds = store, seconds
        with ExitStack() as refused:
            refused.callback(store.close)
            self._take_kept() if store.kept else self._keep_start()
            refused.pop_all()
        self.kept_at = time.perf_counter()

    def _take_kept(self) -> None:
        self._load_for_retry()  # the loop may reach it: the state says whether
        for name, memory in self.memory().items():
            if name not in self.store.kept or self.store.kept[name].shape != memory.shape:
                raise InvalidInput(f"the checkpoint {str(self.store.path)!r} is damaged: {name} has another size")
            block = {"state": self.state, "scratch": self.scratch}.get(name)
            if block is not None:
                block.restore(self.store.kept[name])
            else:
                memory[:] = self.store.kept[name]
        self.go_on()
        self.status = Status.FINISHED if self.store.status == Status.FINISHED else Status.RUNNING

    def _keep_start(self) -> None:
        super()._block(0)  # writes the record of the start
        self._write()
        self._keep()

    def advance(
        self, max_wall_time: float | None, progress: Callable[[float], None] | None, max_steps: int | None = None
    ) -> None:
        with closing(self.store):
            super().advance(max_wall_time, progress, max_steps)
            with interrupts_held_back():
                self._write()
                last = None if self.status == Status.FINISHED else self.last_row()
                if last is not None:
                    self.store.write_last(last)
                self._keep()

    def solution(self) -> Solution:
        """What the checkpoint holds."""
        return load_checkpoint(self.store.path, self.system, is_verified=True)

    def _block(self, max_steps: int) -> int:
        status = super()._block(max_steps)
        with interrupts_held_back():
            self._write()
            status = self.next_window(status)
            if status == Status.RUNNING and time.perf_counter() - self.kept_at >= self.seconds:
                self._keep()
                self.kept_at = time.perf_counter()
        return status

    def _write(self) -> None:
        """Append the records and events that are new."""
        self.store.write(self.new_rows(), self.state.events[: self.state.counters.n_events])
        self.state.counters.n_events = 0
        self.events_dropped = max(0, self.store.n_events - MAX_EVENTS)

    def _keep(self) -> None:
        ended = "" if self.status == Status.RUNNING else self._message()
        self.store.keep(self.memory(), about_run(self.system, self.integrator), self.status, ended, self._stats())

    def _collect_events(self) -> None:
        """They are written with the records."""

    def _stats(self) -> Stats:
        stats = super()._stats()
        return replace(stats, wall_time=self.store.wall_time + stats.wall_time)

    def as_rows(self, t: np.ndarray, record: Columns, la: np.ndarray | None = None) -> np.ndarray:
        """Records as rows of the file."""
        rows = np.empty(len(t), self.store.row)
        rows["t"], rows["P_N"], rows["P_F"] = t, record.P[:, :, 0], record.P[:, :, 1:]
        for name in ("q", "u", "g_N", "mode", "slip", "ledger"):
            rows[name] = getattr(record, name)
        if la is not None:
            rows["la"] = la
        return rows
