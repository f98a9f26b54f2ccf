"""A run that writes its rows to a checkpoint as it goes, and goes on where the checkpoint ends.

Between two blocks the new records and events are appended to the files of the checkpoint; every so many seconds all
that the next step depends on is kept: the blocks of memory that the loop works in, bit by bit. A run that goes on from
there takes the steps that it would have taken. Records are never all in memory; the Solution maps the file.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nonsmooth.arrays import as_non_negative
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.records import INTERVAL, N_EVENTS, STEP, Record, bytes_of_record
from nonsmooth.output.checkpoint import Checkpoint, load_checkpoint, row_type
from nonsmooth.runs.identity import facts_of_run
from nonsmooth.runs.run import Run, last_row
from nonsmooth.runs.times import Grid, RecordTimes, grid_times
from nonsmooth.solution import MAX_EVENTS, Solution, Stats, about_run
from nonsmooth.system import System

WINDOW = 2**22  # bytes of records in memory


@dataclass(frozen=True)
class Place:
    """Where a run is checkpointed, what may be there, and how often its state is kept [s]."""

    path: Any
    may_begin: bool
    may_resume: bool
    seconds: float


def as_place(checkpoint: Any, resume: Any, seconds: float) -> Place:
    """Begin, go on, or, where both are given, whichever is possible."""
    if checkpoint is not None and resume is not None and str(checkpoint) != str(resume):
        raise InvalidInput(
            f"checkpoint and resume must be the same path, or one of them; got {str(checkpoint)!r} and {str(resume)!r}"
        )
    path = checkpoint if resume is None else resume
    seconds = as_non_negative("checkpoint_every", seconds, "s")
    return Place(path, checkpoint is not None, resume is not None, seconds)


def streamed_run(
    system: System, integrator: Any, t_span: tuple[float, float], every: int, t_eval: Any, q0: np.ndarray,
    u0: np.ndarray, selection: int, project: bool, place: Place,
) -> Run:  # fmt: skip
    """The run of an integrator, with its checkpoint.

    Raises
    ------
    InvalidInput
        For a checkpoint of another run, and an integrator that cannot be checkpointed.
    """
    if getattr(integrator, "chooses_steps", False):
        raise InvalidInput(f"{type(integrator).__name__} cannot be checkpointed; MoreauJean can")
    times = grid_times(integrator, t_span, every, t_eval)
    run = StreamedRun(system, integrator, times, q0, u0, selection, project)
    facts = facts_of_run(system, integrator, t_span, every, t_eval, q0, u0, selection, project, run.model.is_compiled)
    row = row_type(system.n_u, system.n_c, system.d, has_forces=False)
    run.attach(Checkpoint(place.path, facts, row, place.may_begin, place.may_resume), place.seconds)
    return run


class StreamedRun(Run):
    """One integration in progress, of a fixed step, on a window of the record times."""

    store: Checkpoint

    def __init__(
        self, system: System, integrator: Any, times: RecordTimes, q0: np.ndarray, u0: np.ndarray, selection: int,
        project: bool,
    ) -> None:  # fmt: skip
        self.times, self.first = times, 0
        row_bytes = bytes_of_record(system.n_u, system.n_c, system.d)
        self.window = max(2, WINDOW // row_bytes)
        super().__init__(system, integrator, self._window(integrator), q0, u0, selection, project)

    def _window(self, integrator: Any) -> Grid:
        t = self.times.part(self.first, min(self.first + self.window, self.times.count))
        return Grid(t, *integrator.steps_between(t))

    def attach(self, store: Checkpoint, seconds: float) -> None:
        """Take the state that was kept, or keep that of the start."""
        self.store, self.seconds = store, seconds
        self.wall_time_before = store.wall_time
        if store.kept:
            self._restore(store.kept)
            if store.status == Status.FINISHED:
                self.status = Status.FINISHED
        else:
            super()._block(0)  # writes the record of the start
            self._write()
            self._keep()
        self.kept_at = time.perf_counter()

    def _restore(self, kept: dict[str, np.ndarray]) -> None:
        self._load_for_retry()  # the loop may reach it: the state says whether
        for name, memory in self._memory().items():
            if kept[name].shape != memory.shape:
                raise InvalidInput(f"the checkpoint {str(self.store.path)!r} is damaged: {name} has another size")
            memory[:] = kept[name]
        self.first = self.store.n_records - 1
        self.state.counters[INTERVAL] = 0
        self.grid = self._window(self.integrator)

    def _memory(self) -> dict[str, np.ndarray]:
        """All that the next step depends on, as bits."""
        return {"state": self.state_block.memory.view(np.int64), "scratch": self.scratch_block.memory.view(np.int64)}

    def _block(self, max_steps: int) -> int:
        status = super()._block(max_steps)
        with interrupts_held_back():
            self._write()
            if status == Status.FINISHED and self.store.n_records < self.times.count:
                self.first = self.store.n_records - 1
                self.state.counters[INTERVAL] = 0
                self.grid = self._window(self.integrator)
                status = Status.RUNNING
            if status == Status.RUNNING and time.perf_counter() - self.kept_at >= self.seconds:
                self._keep()
                self.kept_at = time.perf_counter()
        return status

    def look_for(self, events: Sequence[Callable]) -> None:
        raise InvalidInput("a run with a checkpoint looks for no events; leave out events=, or checkpoint= and resume=")

    def advance(
        self, max_wall_time: float | None, progress: Callable[[float], None] | None, max_steps: int | None = None
    ) -> None:
        super().advance(max_wall_time, progress, max_steps)
        with interrupts_held_back():
            self._write()
            if self.status != Status.FINISHED and self.state.counters[STEP] > 0:
                t = self._time()
                row = last_row(self.record, self.state, self.system, t)
                self.store.write_last(self._as_rows(np.array([t]), row))
            self._keep()
            self.store.close()

    def _write(self) -> None:
        """Append the records and events that are new."""
        new = slice(self.store.n_records - self.first, int(self.state.counters[INTERVAL]) + 1)
        record = Record(*(column[new] for column in self.record))
        self.store.write(self._as_rows(self.grid.t[new], record), self.state.events[: self.state.counters[N_EVENTS]])
        self.state.counters[N_EVENTS] = 0
        self.events_dropped = max(0, self.store.n_events - MAX_EVENTS)

    def _collect_events(self) -> None:
        """They are written with the records."""

    def _as_rows(self, t: np.ndarray, record: Record) -> np.ndarray:
        rows = np.empty(len(t), self.store.row)
        rows["t"], rows["P_N"], rows["P_F"] = t, record.P[:, :, 0], record.P[:, :, 1:]
        for name in ("q", "u", "g_N", "mode", "slip", "ledger"):
            rows[name] = getattr(record, name)
        return rows

    def _keep(self) -> None:
        is_running = self.status == Status.RUNNING
        self.store.keep(
            self._memory(), about_run(self.system, self.integrator), self.status,
            "" if is_running else self._message(), self._stats(),
        )  # fmt: skip

    def _fraction_done(self) -> float:
        t_0, t_1 = self.times.part(0, 1)[0], self.times.part(self.times.count - 1, self.times.count)[-1]
        return float((self._time() - t_0) / (t_1 - t_0)) if t_1 > t_0 else 1.0

    def _stats(self) -> Stats:
        stats = super()._stats()
        return replace(stats, wall_time=self.wall_time_before + stats.wall_time)

    def solution(self) -> Solution:
        """What the checkpoint holds."""
        return load_checkpoint(self.store.path, self.system)


@contextmanager
def interrupts_held_back() -> Iterator[None]:
    """Let Ctrl-C wait until a block is written: files and memory then agree on what was."""
    if threading.current_thread() is not threading.main_thread():
        yield  # signals go to the main thread
        return
    received: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: received.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if received:
        signal.raise_signal(signal.SIGINT)
