"""Sweeps: one task at every combination of some axes, on one core, on all of them, or on a cluster.

The front door: checks, an executor, the journal, and the Dataset at the end. The cells run in batches (batches.py); a
batch of runs of a model is one compiled call (block_engine.py).
"""

from __future__ import annotations

import contextlib
import functools
import inspect
import os
import pickle
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np

from nonsmooth.checks.arrays import as_count, as_flag, as_instance, as_positive
from nonsmooth.checks.files import as_path
from nonsmooth.checks.memory import require_memory
from nonsmooth.errors import (
    CellFailure,
    InitialStateWarning,
    InvalidInput,
    MissingExtra,
    UnsettledWarning,
    shown,
    warn_caller,
)
from nonsmooth.jit.content import CURE
from nonsmooth.jit.fingerprint import Unidentified
from nonsmooth.mechanics.system import System
from nonsmooth.signals.interruption import interrupts_held_back
from nonsmooth.sweeps.axes import Plan, as_plan
from nonsmooth.sweeps.axis_names import require_unit
from nonsmooth.sweeps.batches import Driver, InThisProcess, Packed
from nonsmooth.sweeps.journal import Journal, study_of
from nonsmooth.sweeps.pool import LocalPool, as_workers
from nonsmooth.sweeps.progress import Progress
from nonsmooth.sweeps.sweep_files import check_path, save_sweep
from nonsmooth.sweeps.task import OF_COORDINATE, Batch, CellStatus, FunctionTask, Task, Variable, as_slice, put

if TYPE_CHECKING:
    import xarray

LONGEST_WAIT = 1e8  # derived: s, three years: what the clock of a pipe holds
CELL_BYTES = 17  # derived: of a cell without results: status, message, its number among those that are missing
FIRST_BATCH = 1  # chosen: cells: what is in a batch at Ctrl-C is lost, and how long one takes is not known yet


Arguments = ParamSpec("Arguments")
Found = TypeVar("Found")


def answers_options_of_runs(function: Callable[Arguments, Found]) -> Callable[Arguments, Found]:
    """A sweep that answers the options of its runs, which a task has, by where they belong."""
    own = inspect.signature(function).parameters

    @functools.wraps(function)
    def answering(*given: Arguments.args, **options: Arguments.kwargs) -> Found:
        from nonsmooth.sweeps.run_task import RunTask

        of_runs = [word for word in options if word not in own and word in inspect.signature(RunTask).parameters]
        if of_runs:
            typed = ", ".join(f"{word}=..." for word in of_runs)
            raise InvalidInput(f"sweep takes no {of_runs[0]}=; the options of its runs are those of a task: "
                               f"sweep(RunTask(model, measures, {typed}), axes)")  # fmt: skip
        return function(*given, **options)

    return answering


@answers_options_of_runs
def sweep(
    task: Any,
    axes: Any,
    *,
    workers: int = 1,
    executor: Executor | None = None,
    scheduler: str | None = None,
    journal: str | os.PathLike[str] | None = None,
    resume: bool = True,
    out: str | os.PathLike[str] | None = None,
    progress: Any = True,
    timeout: float | None = None,
    retries: int = 1,
    fail_fast: bool = False,
    batch: int | None = None,
) -> xarray.Dataset:
    """Run a task at every combination of the axes, or at every row of a table.

    Parameters
    ----------
    task : RunTask, model, System or callable
        Runs of a model with measures (`RunTask`; a model alone stands for its final state), or a function that takes
        the axes as keywords and returns a number, an array, or a dict of those.
    axes : mapping, sequence of Axis, or table
        ``{name: values}`` or ``{name: (values, unit)}``: every combination. A DataFrame, a structured array or a list
        of dicts: each row. Names of a model's axes are its parameters, the arguments of its ``state``, "q0[i]",
        "u0[i]", the integrator's options and "t_end".
    workers : int
        Threads for compiled runs, processes for functions and for runs that call Python; 1: in this process.
    executor : concurrent.futures.Executor, optional
        Takes the batches instead; it is not shut down.
    scheduler : str, optional
        Address of a Dask scheduler, "tcp://host:8786", that takes them instead (needs the extra [cluster]).
    journal : path-like, optional
        Where finished cells are written as they come, one line of JSON each.
    resume : bool
        Go on with the journal that is there; cells that stand in it are not run again.
    out : path-like, optional
        Where the result is written at the end, .npz or .nc.
    progress : bool, "json" or callable
        True: a line on a terminal, nothing in a pipe but the estimate of what will take more than a minute. "json": a
        line of JSON a second on stderr. A callable gets each `Snapshot`.
    timeout : float, optional
        Seconds for a cell; what takes longer is ended, with its process.
    retries : int
        How often a cell is tried again after the process that ran it, alone, has died.
    fail_fast : bool
        Raise at the first cell that fails; else it is a value of the result.
    batch : int, optional
        Cells in each batch; by default batches of about 0.1 s.

    Returns
    -------
    xarray.Dataset
        The results over the axes (over "cell" for a table), "status" (`CellStatus`) and "message"; NaN where a cell has
        no result. The same for any batch, number of workers and order. ``.to_dataframe()`` makes a table of it.
        After Ctrl-C: what was finished; the rest has the status NOT_RUN.

    Raises
    ------
    InvalidInput
        For unknown, doubled or non-finite axes, a task that cannot be pickled, a journal of another study, a scheduler
        that does not answer.
    CellFailure
        With ``fail_fast``.
    MissingExtra
        When xarray, or distributed, is needed and not installed.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> found = ns.sweep(lambda x, y: x + y, {"x": [1, 2], "y": [10, 20, 30]})
    >>> found.value.values.tolist()
    [[11.0, 21.0, 31.0], [12.0, 22.0, 32.0]]
    """
    plan = as_plan(axes)
    task = as_task(task)
    task.check(plan.names)
    for axis in plan.axes:
        require_unit(axis.name, axis.unit, task.unit(axis.name))
    resume, fail_fast = as_flag("resume", resume), as_flag("fail_fast", fail_fast)
    if executor is not None and scheduler is None:
        as_instance("executor", executor, Executor, "a concurrent.futures.Executor")
    if journal is not None:
        as_path("journal", journal)
    retries = 0 if isinstance(retries, int) and retries == 0 else as_count("retries", retries)
    timeout = None if timeout is None else min(as_positive("timeout", timeout, "s"), LONGEST_WAIT)
    batch = None if batch is None else as_count("batch", batch)
    require_xarray()
    if out is not None:
        check_path(out)
    result, stop = Result(task, plan), threading.Event()
    try:
        with contextlib.ExitStack() as stack:
            engine, threads = stack.enter_context(open_executor(task, executor, scheduler, workers, timeout))
            sent = task if isinstance(engine, InThisProcess | ThreadPoolExecutor) else packed(task)
            book = (
                None if journal is None else stack.enter_context(Journal(journal, result.require_study(), plan, resume))
            )
            if book is not None:
                result.read(book)
            if not isinstance(sent, Packed):
                sent.load()  # before the clock of the progress begins; another process loads before its first call
            costs = costs_of(task, result)
            meter = stack.enter_context(Progress(progress, len(plan), result.n_resumed, costs=costs, at_once=threads))
            driver = Driver(sent, plan, engine, threads, timeout, retries, FIRST_BATCH, batch, stop, meter.begin)
            try:
                collect(driver, result, book, meter, fail_fast)
            except BaseException:
                stop.set()  # before the threads are waited for
                raise
    except KeyboardInterrupt:
        result.is_interrupted = True
    found = result.dataset()
    if out is not None:
        save_sweep(found, out)
    if result.inadmissible:
        warn_caller(
            f"the initial state is not admissible in {result.inadmissible} of the cells that were run: it penetrates "
            "a contact or violates a bilateral one",
            InitialStateWarning,
        )  # fmt: skip
    doubt = getattr(task, "doubt", lambda values: "")(result.values)
    if doubt:
        warn_caller(doubt, UnsettledWarning)
    return found


def collect(driver: Driver, result: Result, book: Journal | None, meter: Progress, fail_fast: bool) -> None:
    """Run what is missing of a result; every batch is in the journal before it is in the result."""
    try:
        for cells, batch in driver.run(result.missing()):
            with interrupts_held_back():
                if book is not None:
                    book.write(cells, batch)
                result.add(cells, batch)
            meter.finish(cells, int((batch.status != CellStatus.FINISHED).sum()), batch.elapsed)
            if fail_fast:
                raise_failure(driver.plan, cells, batch)
    except BrokenExecutor as error:
        raise InvalidInput(
            f"the executor broke ({type(error).__name__}: {error}); the cells that were finished stand in the journal, "
            "if there is one. workers=... is a pool that survives the death of a worker"
        ) from error


def costs_of(task: Task, result: Result) -> np.ndarray | None:
    """(N,) seconds that each cell may take, zero of those that are there; None where the task does not know."""
    expected = getattr(task, "costs", None)
    missing = result.missing()
    found = None if expected is None or not len(missing) else expected(result.plan.columns(missing))
    if found is None:
        return None
    costs = np.zeros(len(result.plan))
    costs[missing] = found
    return costs


def require_whole(found: xarray.Dataset) -> xarray.Dataset:
    """A sweep that came to its end, for those who have no use for a part; else KeyboardInterrupt."""
    if found.attrs["interrupted"]:
        raise KeyboardInterrupt
    return found


def as_task(candidate: Any) -> Task:
    """A task as it is, a model's runs, or a function's calls."""
    if all(hasattr(candidate, name) for name in ("identity", "check", "holds_interpreter")):
        return candidate
    if isinstance(candidate, System) or callable(getattr(candidate, "system", None)):
        from nonsmooth.sweeps.run_task import RunTask

        return RunTask(candidate)
    if callable(candidate):
        return FunctionTask(candidate)
    raise InvalidInput(f"a task must be a RunTask, a model or a function; got {type(candidate).__name__}")


def require_xarray() -> None:
    """Import xarray, and what it imports at its first use, before the sweep, which ends quickly then; or say what is
    missing."""
    try:
        import xarray
    except ImportError:
        raise MissingExtra('sweeps need xarray; pip install "nonsmooth[map]" brings it') from None
    xarray.Dataset(coords={"first": [0.0]})


@contextlib.contextmanager
def open_executor(
    task: Task, executor: Executor | None, scheduler: str | None, workers: int, timeout: float | None
) -> Iterator[tuple[Executor, int]]:
    """The executor, and how many calls it runs at a time; ours are shut down at the end."""
    workers = as_workers(workers)
    if executor is not None and scheduler is not None:
        raise InvalidInput("give either executor or scheduler; got both")
    if timeout is not None and (scheduler or not hasattr(executor or LocalPool, "submit_within")):
        raise InvalidInput("timeout needs worker processes that can be ended: leave it out, or use workers=...")
    if scheduler is not None and not isinstance(scheduler, str):
        raise InvalidInput(f"scheduler must be an address such as 'tcp://host:8786'; got {shown(scheduler)}")
    if scheduler is not None:
        from nonsmooth.sweeps.cluster import connect

        remote, threads, client = connect(scheduler)
        with client:
            yield remote, threads
    elif executor is not None:
        yield executor, getattr(executor, "_max_workers", os.cpu_count() or 1)
    elif workers == 1 and timeout is None:
        yield InThisProcess(), 1
    else:
        needs_processes = task.holds_interpreter or timeout is not None
        own = LocalPool(workers) if needs_processes else ThreadPoolExecutor(workers)
        try:
            yield own, workers
        except BaseException:
            own.shutdown(wait=needs_processes, cancel_futures=True)  # a thread that compiles is not waited for
            raise
        own.shutdown()


def packed(task: Task) -> Packed:
    """The task as it travels to another process, or a sentence on why it cannot."""
    try:
        return Packed(pickle.dumps(task))
    except Exception as error:
        what = getattr(task, "function", getattr(task, "model", task))
        raise InvalidInput(
            f"the task {getattr(what, '__qualname__', type(what).__name__)} cannot be pickled, so no other process can "
            f"run it: {error}. Define its functions at the top level of a module, or use workers=1"
        ) from None


def raise_failure(plan: Plan, cells: np.ndarray, batch: Batch) -> None:
    """Raise for the first cell of a batch that failed."""
    for k in np.flatnonzero(batch.status != CellStatus.FINISHED)[:1]:
        place = ", ".join(f"{name} = {values[0]}" for name, values in plan.columns(cells[k : k + 1]).items())
        status = CellStatus(int(batch.status[k])).name
        raise CellFailure(f"the cell {place} ended with {status}: {batch.messages.get(int(k), '')}")


class Result:
    """The results of a sweep while they come in."""

    def __init__(self, task: Task, plan: Plan) -> None:
        needed = len(plan) * (CELL_BYTES + 8.0 * max(1, len(task.variables)))
        require_memory(needed, f"the results of {len(plan)} cells", "take fewer, or some at a time")
        self.task, self.plan = task, plan
        self.study = self.untold = ""
        try:
            self.study = study_of(task, plan)
        except Unidentified as reason:
            self.untold = str(reason)
        self.values: dict[str, np.ndarray] = {}
        self.status = np.full(len(plan), int(CellStatus.NOT_RUN), dtype=np.int8)
        self.messages: dict[int, str] = {}
        self.n_resumed = self.inadmissible = 0
        self.is_interrupted = False

    def require_study(self) -> str:
        """The hash by which a journal knows the study.

        Raises
        ------
        InvalidInput
            Where it cannot be distinguished from others.
        """
        if self.untold:
            raise InvalidInput(f"a journal cannot tell this study from others: {self.untold}. {CURE}")
        return self.study

    def read(self, journal: Journal) -> None:
        """Take the finished cells of a journal."""
        for cells, batch in journal.read():
            self.add(cells, batch)
        self.n_resumed = int((self.status != CellStatus.NOT_RUN).sum())

    def missing(self) -> np.ndarray:
        """Numbers of the cells that are not there."""
        return np.flatnonzero(self.status == CellStatus.NOT_RUN)

    def add(self, cells: np.ndarray, batch: Batch) -> None:
        """Take the results of a batch."""
        place = as_slice(cells)
        self.status[place] = batch.status
        self.inadmissible += batch.inadmissible
        self.messages.update({int(cells[k]): message for k, message in batch.messages.items()})
        for name, values in batch.values.items():
            put(self.values, name, place, values, len(self.plan))

    def dataset(self) -> xarray.Dataset:
        """The Dataset over the axes."""
        import xarray

        plan = self.plan
        columns = {name: self._variable(name, self.values[name]) for name in sorted(self.values)}
        flags = {"flag_values": [int(s) for s in CellStatus], "flag_meanings": " ".join(s.name for s in CellStatus)}
        columns["status"] = (plan.dims, self.status.reshape(plan.shape), flags)
        messages = np.full(len(plan), "", dtype=object)
        messages[list(self.messages)] = list(self.messages.values())
        columns["message"] = (plan.dims, messages.reshape(plan.shape), {})
        coordinates: dict[str, Any] = {}
        for axis in plan.axes:
            unit = axis.unit or self.task.unit(axis.name)
            attrs = {"units": unit} if unit else {}
            coordinates[axis.name] = ("cell" if plan.is_table else axis.name, axis.values, attrs)
        used = {dim for dims, *_ in columns.values() for dim in dims}
        for name, labels in self.task.coordinates.items():
            dim = name.removesuffix("_unit")
            if dim in used:
                coordinates[name] = (dim, labels)
        return xarray.Dataset(columns, coordinates, {
            "study": self.study, "cells": len(plan), "cells_from_journal": self.n_resumed,
            "cells_failed": int(((self.status != CellStatus.FINISHED) & (self.status != CellStatus.NOT_RUN)).sum()),
            **({"cells_unsettled": int((self.values["settled"] == 0.0).sum())} if "settled" in self.values else {}),
            "interrupted": int(self.is_interrupted), **getattr(self.task, "about", {}),
        })  # fmt: skip

    def _variable(self, name: str, values: np.ndarray) -> tuple[Any, ...]:
        known = self.task.variables.get(name, Variable(tuple(f"{name}_{k}" for k in range(values.ndim - 1))))
        attrs = {"units": known.unit.replace(OF_COORDINATE, self._only_unit()), "long_name": known.meaning}
        shape = (*self.plan.shape, *values.shape[1:])
        return (*self.plan.dims, *known.dims), values.reshape(shape), {key: text for key, text in attrs.items() if text}

    def _only_unit(self) -> str:
        """The unit of all coordinates, or what stands for the unit of each."""
        units = set(self.task.coordinates.get("coordinate_unit", ()))
        return units.pop() if len(units) == 1 else OF_COORDINATE
