"""Recorders that write to a checkpoint, so that a run goes on where the checkpoint ends.

Between two blocks of steps the new records and events are appended to the files of the checkpoint; every so many
seconds all that the next step depends on is kept: the blocks of memory that the loop works in, bit by bit; of a scene
places and velocities, impulses with their keys, factors and waits of the solvers, ledger and counts. A run that goes on
from there takes the steps that it would have taken. Records are never all in memory; a fixed step is given its record
times a window at a time, and the result maps the file.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
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
from nonsmooth.results.checkpoint import (
    EVENT_ROW,
    Checkpoint,
    Layout,
    Shape,
    layout_of,
    load_checkpoint,
    load_scene_checkpoint,
    scene_layout,
)
from nonsmooth.results.events import MAX_EVENTS
from nonsmooth.results.recorded import EVENTS, KINDS
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.results.solution import Solution, about_run, per_record, theta_of
from nonsmooth.runs.ongoing import Ongoing, left_out
from nonsmooth.runs.recorder import Arrays, Recorder, SceneRecorder, SceneRun, Window, new_rows, stands_behind
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


class Stream:
    """What is written to a checkpoint as a run goes, of a system or of a scene.

    Parameters
    ----------
    facts : callable
        All that the bits of the run depend on.
    place : Place
    """

    store: Checkpoint
    kept_at: float  # [s] when a state was kept
    memory: Callable[[Any], Arrays]  # all that the next step depends on, as bits
    take_kept: Callable[[Any], None]  # takes the state that was kept
    write_start: Callable[[Any], None]  # writes the record of the start
    write_new: Callable[[Any], None]  # appends what is new
    last_rows: Callable[[Any], Arrays]  # the state at which the run stopped, where no record shows it
    about: Callable[[Any], dict[str, Any]]  # what is run, by name

    def __init__(self, facts: Callable[..., dict[str, Any]], place: Place) -> None:
        self.facts, self.place = facts, place

    def open(self, run: Any, facts: dict[str, Any], layout: Layout, said: dict[str, Any]) -> None:
        """Open the files; take the state that was kept, or keep that of the start."""
        self.store = Checkpoint(self.place.path, facts, layout, self.place.may_begin, self.place.may_resume)
        self.store.said = said
        with ExitStack() as refused:
            refused.callback(self.store.close)
            if self.store.kept:
                self.take_kept(run)
                run.status = Status.FINISHED if self.store.status == Status.FINISHED else Status.RUNNING
            else:
                self.write_start(run)
                self.write_new(run)
                self.keep(run)
            refused.pop_all()
        self.kept_at = time.perf_counter()

    def keep(self, run: Any) -> None:
        """Keep the state, with the rows that belong to it."""
        ended, stats = "" if run.status == Status.RUNNING else run.message(), run.stats()
        stats = type(stats)(**vars(stats) | {"wall_time": self.store.wall_time + run.wall_time})
        self.store.keep(self.memory(run), self.about(run), run.status, ended, stats)

    def keep_if_due(self, run: Any) -> None:
        """Keep the state, every so many seconds."""
        if time.perf_counter() - self.kept_at >= self.place.seconds:
            self.keep(run)
            self.kept_at = time.perf_counter()

    def end(self, run: Any) -> None:
        """The run has come to its end, or was stopped: the state there is shown as one more record."""
        with interrupts_held_back():
            self.write_new(run)
            if run.status != Status.FINISHED and (last := self.last_rows(run)):
                self.store.write_last(last)
            self.keep(run)

    def close(self) -> None:
        """Nothing is written any more."""
        self.store.close()


class StreamingRecorder(Stream, Recorder):
    """Rows and events of a system go to a file."""

    def __init__(self, facts: Any, place: Place, recorded: tuple[str, ...] = KINDS) -> None:
        Stream.__init__(self, facts, place)
        Recorder.__init__(self, recorded)
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
        self.open(run, self.facts(run.model.is_compiled), layout, self._said(run))

    def _said(self, run: Ongoing) -> dict[str, Any]:
        """Names, the model by its name, and the theta of a run whose every step is a record."""
        is_whole = isinstance(run.integrator, FixedStep) and run.table.has_each_step
        return {"names": names_in_file(run.system.described), "model": view(Solution, "name model")(run.system),
                "theta": theta_of(run.integrator) if is_whole else None}  # fmt: skip

    def memory(self, run: Ongoing) -> Arrays:
        """The blocks of the loop."""
        blocks = {"state": run.state.words, "memory": run.memory.words}
        return {name: words.view(np.int64) for name, words in blocks.items()} | {"counts": numbers(run.record.counts)}

    def take_kept(self, run: Ongoing) -> None:
        """Take the state that was kept."""
        run.load_for_retry()  # the loop may reach it: the state says whether
        require_sizes(self.store, self.memory(run))
        run.state.restore(self.store.kept["state"])
        run.memory.restore(self.store.kept["memory"])
        numbers(run.record.counts)[:] = self.store.kept["counts"]
        self._open_window(run)

    def write_start(self, run: Ongoing) -> None:
        """Have the loop write the record of the start."""
        run.step_loop(0)

    def _open_window(self, run: Ongoing) -> None:
        """Give a fixed step the record times from the last record on."""
        if run.integrator.chooses_steps:
            return
        self.first = max(0, self.store.count("records") - 1)
        run.state.counters.interval = 0
        run.schedule = run.table.schedule(self.first, min(self.first + self.size, run.table.count))

    def take(self, run: Ongoing, status: int) -> int:
        with interrupts_held_back():
            self.write_new(run)
            if status == Status.FINISHED and self.first + len(run.schedule.t) < run.table.count:
                self._open_window(run)
                status = Status.RUNNING
            if status == Status.RUNNING:
                self.keep_if_due(run)
        return status

    def take_events(self, run: Ongoing) -> None:
        """They are written with the records."""

    def last_rows(self, run: Ongoing) -> Arrays:
        """The state at which the run stopped, where no record shows it."""
        if not self.store.count("records"):
            return {"records": self._as_rows(run.bare_row())}
        return {"records": self._as_rows(run.present_row())} if stands_behind(run, self.last_t) else {}

    def write_new(self, run: Ongoing) -> None:
        """Append the records and events that are new."""
        counters = run.state.counters
        events = np.ascontiguousarray(run.state.events[: counters.n_events]).view(EVENT_ROW)[:, 0]
        rows = new_rows(run.record)
        self.store.write({"records": self._as_rows(rows), "events": events})
        self.last_t = rows.t[-1] if len(rows.t) else self.last_t
        counters.n_events = 0
        if EVENTS in self.recorded:
            self.events_dropped = max(0, self.store.count("events") - MAX_EVENTS)

    def about(self, run: Ongoing) -> dict[str, Any]:
        """What is run, by name."""
        return about_run(run.system, run.integrator)

    def _as_rows(self, record: Columns) -> np.ndarray:
        """Records as rows of the file."""
        columns = per_record(record, self.recorded, has_forces=True) | {"ledger": record.ledger}
        return as_rows(columns, self.store.layout.rows["records"])

    def stored(self, run: Ongoing) -> Solution:
        return load_checkpoint(self.store.path, lambda *_: run.system, is_verified=True)


class StreamingSceneRecorder(Stream, SceneRecorder):
    """Records of a scene go to a file; ``kinds`` as of `SceneRecorder`."""

    is_resumed = True

    def __init__(self, kinds: tuple[str, ...], facts: Callable[..., dict[str, Any]], place: Place) -> None:
        Stream.__init__(self, facts, place)
        SceneRecorder.__init__(self, kinds)

    def require_room(self, run: SceneRun) -> None:
        """There is room on the disk."""

    def begin(self, run: SceneRun) -> None:
        """Take the state that was kept, or keep that of the start."""
        self.window = Window(run, self.kinds)
        said = {"names": run.names, "joint_names": [joint.name for joint in run.scene.joints]}
        layout = scene_layout(len(run.scene.bodies), run.scene.dim, self.kinds, len(run.scene.joints), run.works)
        self.open(run, self.facts(run), layout, said)

    def memory(self, run: SceneRun) -> Arrays:
        """The blocks of the step, and what a solution has that no record tells."""
        bits = {name: block.words.view(np.int64) for name, block in run.assembly.carried.items()}
        return bits | {"sizes": run.assembly.sizes, "place": np.array(run.place), "centres": run.centres,
                       "paradox_rows": run.paradox_rows()}  # fmt: skip

    def take_kept(self, run: SceneRun) -> None:
        """Take the state that was kept."""
        kept = self.store.kept
        require_sizes(self.store, {"sizes": run.assembly.sizes, "place": np.array(run.place)})
        run.assembly.restore(kept["sizes"])
        blocks = run.assembly.carried
        require_sizes(self.store, {name: block.words for name, block in blocks.items()})
        for name, block in blocks.items():
            block.restore(kept[name])
        run.assembly.go_on()
        run.go_on_from(*kept["place"].tolist())

    def write_start(self, run: SceneRun) -> None:
        """Write the record of the start into the window."""
        run.write_record()

    def empty(self, run: SceneRun) -> None:
        self.write_new(run)

    def look(self, run: SceneRun) -> None:
        with interrupts_held_back():
            self.write_new(run)
            self.keep_if_due(run)

    def write_new(self, run: SceneRun) -> None:
        """Append the records of the window."""
        if self.window.count:
            self.store.write(self._rows())

    def last_rows(self, run: SceneRun) -> Arrays:
        """The state at which the run stopped, where no record shows it."""
        if run.is_at_record:
            return {}
        self.window.put(run, run.now)
        return self._rows()

    def _rows(self) -> Arrays:
        """The records of the window as rows of the files."""
        return {name: as_rows(part, self.store.layout.rows[name]) for name, part in self.window.take().items()}

    def about(self, run: SceneRun) -> dict[str, Any]:
        """What is run, by name."""
        return run.about()  # type: ignore[no-any-return]

    def solution(self, run: SceneRun) -> SceneSolution:
        return load_scene_checkpoint(self.store.path, run.scene, is_verified=True)


def as_rows(columns: dict[str, Any], row: np.dtype) -> np.ndarray:
    """Columns as rows of a file."""
    rows = np.empty(len(next(iter(columns.values()))), row)
    for name in row.names or ():
        rows[name] = columns[name]
    return rows


def require_sizes(store: Checkpoint, memory: dict[str, np.ndarray]) -> None:
    """Raise `InvalidInput` unless the arrays that were kept have the sizes of those that they go to."""
    for name, array in memory.items():
        if name not in store.kept or store.kept[name].shape != array.shape:
            raise InvalidInput(f"the checkpoint {str(store.path)!r} is damaged: {name} has another size")
