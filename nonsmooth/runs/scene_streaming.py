"""A recorder of a scene that writes to a checkpoint, so that a run goes on where the checkpoint ends.

As ``streaming.py`` does it for a System: records go to the files as the run goes, and now and then all that the next
step depends on, bit by bit: places and velocities, impulses with their keys, factors and waits of the solvers, ledger
and counts.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput, Status
from nonsmooth.results.checkpoint import Checkpoint
from nonsmooth.results.scene_checkpoint import load_scene_checkpoint, scene_layout
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.runs.scene_recorder import Rows, RunOfScene, SceneRecorder, Window
from nonsmooth.runs.streaming import Place, require_sizes
from nonsmooth.signals.interruption import interrupts_held_back


class StreamingSceneRecorder(SceneRecorder):
    """Records go to a file.

    Parameters
    ----------
    kinds : tuple of str
        As of `SceneRecorder`.
    facts : callable
        ``facts(run)``: all that the bits of the run depend on.
    place : Place
    """

    store: Checkpoint

    def __init__(self, kinds: tuple[str, ...], facts: Callable[[RunOfScene], dict[str, Any]], place: Place) -> None:
        super().__init__(kinds)
        self.facts, self.place = facts, place

    def require_room(self, run: RunOfScene) -> None:
        """There is room on the disk."""

    def begin(self, run: RunOfScene) -> None:
        """Take the state that was kept, or keep that of the start."""
        self.window = Window(run, self.kinds)
        layout = scene_layout(len(run.scene.bodies), run.scene.dim, self.kinds, len(run.scene.joints))
        place = self.place
        self.store = Checkpoint(place.path, self.facts(run), layout, place.may_begin, place.may_resume)
        with ExitStack() as refused:
            refused.callback(self.store.close)
            self._take_kept(run) if self.store.kept else self._keep_start(run)
            refused.pop_all()
        self.kept_at = time.perf_counter()

    def _memory(self, run: RunOfScene) -> Rows:
        """All that the next step depends on, as bits."""
        return {name: block.words.view(np.int64) for name, block in run.assembly.carried.items()}

    def _take_kept(self, run: RunOfScene) -> None:
        kept = self.store.kept
        if kept.get("sizes", np.empty(0)).shape != (3,) or kept.get("place", np.empty(0)).shape != (3,):
            raise InvalidInput(f"the checkpoint {str(self.store.path)!r} is damaged: sizes has another size")
        run.assembly.restore(kept["sizes"])
        require_sizes(self.store, self._memory(run))
        for name, block in run.assembly.carried.items():
            block.restore(kept[name])
        run.assembly.go_on()
        run.go_on_from(*kept["place"].tolist())
        run.status = Status.FINISHED if self.store.status == Status.FINISHED else Status.RUNNING

    def _keep_start(self, run: RunOfScene) -> None:
        run.write_record()
        self._write()
        self._keep(run)

    def empty(self, run: RunOfScene) -> None:
        self._write()

    def look(self, run: RunOfScene) -> None:
        with interrupts_held_back():
            self._write()
            if time.perf_counter() - self.kept_at >= self.place.seconds:
                self._keep(run)
                self.kept_at = time.perf_counter()

    def end(self, run: RunOfScene) -> None:
        with interrupts_held_back():
            self._write()
            if run.status != Status.FINISHED and not run.is_at_record:
                self.window.put(run, run.now)
                self.store.write_last(self._rows())
            self._keep(run)

    def close(self) -> None:
        self.store.close()

    def _write(self) -> None:
        """Append the records that are new."""
        if self.window.count:
            self.store.write(self._rows())

    def _rows(self) -> Rows:
        """The records of the window as rows of the files."""
        columns, beside = self.window.take()
        parts = {"records": columns} | beside
        return {name: as_rows(part, self.store.layout.rows[name]) for name, part in parts.items()}

    def _keep(self, run: RunOfScene) -> None:
        ended = "" if run.status == Status.RUNNING else run.message()
        stats = replace(run.stats(), wall_time=self.store.wall_time + run.wall_time)
        arrays = self._memory(run) | {
            "sizes": run.assembly.sizes, "place": np.array(run.place), "names": np.array(run.names),
            "centres": run.centres, "paradox_rows": run.paradox_rows(),
            "joint_names": np.array([joint.name for joint in run.scene.joints], np.str_),
        }  # fmt: skip
        self.store.keep(arrays, run.about(), run.status, ended, stats)

    def solution(self, run: RunOfScene) -> SceneSolution:
        return load_scene_checkpoint(self.store.path, run.scene, is_verified=True)


def as_rows(columns: Rows, row: np.dtype) -> np.ndarray:
    """Columns as rows of a file."""
    rows = np.empty(len(next(iter(columns.values()))), row)
    for name, column in columns.items():
        rows[name] = column
    return rows
