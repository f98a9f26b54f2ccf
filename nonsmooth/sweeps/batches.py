"""Cells in batches through an executor: sizes from measured times, retries one by one where a worker died.

A batch holds about BATCH_TIME seconds of work, so that what an executor charges per task (0.2 ms for a local worker, a
few ms for a scheduler on the network) stays below some per cent. The results do not depend on the sizes.
"""

from __future__ import annotations

import functools
import math
import pickle
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nonsmooth.signals.interruption import ended_by
from nonsmooth.sweeps.axes import Plan
from nonsmooth.sweeps.pool import WorkerDied, WorkerTimedOut
from nonsmooth.sweeps.task import Batch, CellStatus, Task

BATCH_TIME = 0.1  # chosen: s of work in a batch; at least 0.02 is left when the estimate is five times too large
BATCH_GROWTH = 8  # chosen: a batch is at most this many times larger than the one before
MAX_CELLS = 32_768  # chosen: cells in a batch: bounds the memory of its arrays
AHEAD = 2  # chosen: batches waiting per worker


class InThisProcess(Executor):
    """Calls at once, in the calling thread."""

    _max_workers = 1

    def submit(self, function: Any, /, *args: Any, **kwargs: Any) -> Future:
        """The call, already made."""
        future: Future = Future()
        try:
            future.set_result(function(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@dataclass(frozen=True)
class Packed:
    """A task on its way to another process, where it is unpacked once, and ready before the time of a call begins."""

    pickled: bytes

    def __reduce__(self) -> tuple[Any, ...]:
        return unpacked, (self.pickled,)


@functools.lru_cache(maxsize=4)
def unpacked(pickled: bytes) -> Task:
    """The task with its code imported and compiled; kept for the next batch."""
    task: Task = pickle.loads(pickled)
    task.load()
    return task


def run_batch(task: Task, columns: dict[str, np.ndarray], stop: threading.Event | None = None) -> Batch:
    """Run a batch and time it; in a thread of this process, until it is asked to stop."""
    started = time.perf_counter()
    with ended_by(stop):
        batch = task(columns)
    batch.elapsed = time.perf_counter() - started
    return batch


@dataclass
class Driver:
    """Sends the cells of a plan through an executor.

    Parameters
    ----------
    task : Task or Packed
        Packed for executors that leave this process.
    plan : Plan
    executor : Executor
    workers : int
        How many calls the executor runs at a time.
    timeout : float or None
        Seconds for one cell.
    retries : int
        How often a cell is tried again, alone, after its worker died.
    first_size : int
        Cells in the first batch, whose time is not known.
    batch : int or None
        Cells in every batch, instead of sizes from measured times.
    stop : threading.Event, optional
        Ends batches that run in threads of this process.
    begin : callable, optional
        Called with the numbers of the cells that are run next in the calling thread.
    """

    task: Any
    plan: Plan
    executor: Executor
    workers: int
    timeout: float | None
    retries: int
    first_size: int
    batch: int | None = None
    stop: threading.Event | None = None
    begin: Callable[[np.ndarray], None] | None = None
    _alone: deque[int] = field(default_factory=deque)  # cells to be tried one by one
    _deaths: dict[int, int] = field(default_factory=dict)  # of workers, per cell that they ran alone
    _size: int = 0

    def run(self, cells: np.ndarray) -> Iterator[tuple[np.ndarray, Batch]]:
        """The cells with these numbers: (numbers, results) of each batch as it comes in."""
        pending: dict[Future, np.ndarray] = {}
        self._size = self.batch or self.first_size
        taken = 0
        try:
            while True:
                while len(pending) < self._room and (self._alone or taken < len(cells)):
                    if self._alone:
                        chosen = np.array([self._alone.popleft()])
                    else:
                        chosen = cells[taken : taken + self._next_size(len(cells) - taken)]
                        taken += len(chosen)
                    pending[self._submit(chosen)] = chosen
                if not pending:
                    return
                done, _ = wait(pending, return_when=FIRST_COMPLETED)
                for future in done:
                    chosen = pending.pop(future)
                    batch = self._result(future, chosen)
                    if batch is not None:
                        yield chosen, batch
        finally:
            for future in pending:
                future.cancel()

    @property
    def _room(self) -> int:
        return 1 if isinstance(self.executor, InThisProcess) else AHEAD * self.workers

    def _next_size(self, left: int) -> int:
        if self.batch:
            return self.batch
        return max(1, min(self._size, MAX_CELLS, math.ceil(left / (AHEAD * self.workers))))

    def _submit(self, chosen: np.ndarray) -> Future:
        if self.begin is not None and isinstance(self.executor, InThisProcess):
            self.begin(chosen)
        columns = self.plan.columns(chosen)
        if self.timeout is None:
            is_here = isinstance(self.executor, ThreadPoolExecutor)
            return self.executor.submit(run_batch, self.task, columns, *([self.stop] if is_here else []))
        return self.executor.submit_within(  # type: ignore[attr-defined]
            self.timeout * len(chosen), run_batch, self.task, columns
        )

    def _result(self, future: Future, chosen: np.ndarray) -> Batch | None:
        """The results of a batch; None where its cells go back to be tried alone."""
        try:
            batch: Batch = future.result()
        except Exception as error:
            if not is_death(error):
                raise
            return self._bury(chosen, error)
        if batch.elapsed > 0:
            wanted = BATCH_TIME / batch.elapsed * len(chosen)
            self._size = int(min(max(1.0, wanted), BATCH_GROWTH * max(self._size, 1), MAX_CELLS))
        return batch

    def _bury(self, chosen: np.ndarray, error: Exception) -> Batch | None:
        """A worker died, or was ended: cells that were in company are tried alone, a cell that was alone so often."""
        if len(chosen) > 1:
            self._alone.extend(chosen.tolist())
            return None
        cell = int(chosen[0])
        self._deaths[cell] = self._deaths.get(cell, 0) + 1
        is_late = isinstance(error, WorkerTimedOut)
        if not is_late and self._deaths[cell] <= self.retries:
            self._alone.append(cell)
            return None
        status = CellStatus.TIMED_OUT if is_late else CellStatus.CRASHED
        return Batch({}, np.array([int(status)]), {0: str(error) or type(error).__name__})


def is_death(error: Exception) -> bool:
    """Whether an exception says that the process of a call is gone (Dask says KilledWorker)."""
    is_ours = isinstance(error, WorkerDied | WorkerTimedOut)
    return is_ours or (type(error).__name__ == "KilledWorker" and not isinstance(error, BrokenExecutor))
