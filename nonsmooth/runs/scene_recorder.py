"""Where the records of a scene go: through a window of some records, into memory.

The window has the state as the steps have it, the principal axes of the bodies; what users are shown, with energies, is
made of many records at once when the window is emptied.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from nonsmooth.checks.memory import require_memory
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.assembly.pairs import exchanged
from nonsmooth.integrators.assembly.world import World
from nonsmooth.results.scene_pairs import pairs_of
from nonsmooth.results.scene_records import (
    BODIES,
    CONTACTS,
    JOINT_IMPULSES,
    LEDGER,
    PAIRS,
    UNASKED,
    record_row,
    rows_beside,
)
from nonsmooth.results.scene_solution import SceneSolution, columns_of
from nonsmooth.results.scene_stats import SceneStats
from nonsmooth.runs.times import RecordTimes
from nonsmooth.runs.user_events import Stop
from nonsmooth.scenes.scene import Scene

GROWTH = 2  # chosen: of the room for records, where their number is that of the steps
SCENE_WINDOW = 2**22  # chosen: bytes of records in the window
Rows = dict[str, np.ndarray]  # columns by name


class RunOfScene(Protocol):
    """What a recorder knows of the run of a scene (scene_run.py)."""

    scene: Scene
    world: World
    assembly: Any  # bodies in motion: an `Assembly`, or `SceneSprings`
    table: RecordTimes
    names: list[str]
    centres: np.ndarray
    works: tuple[str, ...]  # columns of the ledger, beside the energies of the bodies
    is_counted: bool  # whether its records are those of the table, or one every so many steps that it chooses
    n_touching: int  # contacts at the start
    status: Status
    wall_time: float

    @property
    def steps(self) -> int:
        """Taken so far."""

    @property
    def now(self) -> float:
        """The time that it has come to [s]."""

    @property
    def is_at_record(self) -> bool:
        """Whether its state is that of the last record."""

    @property
    def place(self) -> tuple[int, int, bool]:
        """Where it is between the records."""

    def write_record(self) -> None:
        """Write the state as the next record."""

    def go_on_from(self, interval: int, steps_before: int, has_record: int) -> None:
        """Be at a place."""

    def stop(self, spent: str) -> None:
        """End the run before its time."""

    def end_at(self, stop: Stop) -> None:
        """End the run as an event of the user says."""

    def watched(self) -> dict[str, Any]:
        """Events, and times of those of the user."""

    def paradox_rows(self) -> np.ndarray:
        """Where rigid contact left open what happens."""

    def stats(self) -> SceneStats:
        """What it cost."""

    def message(self) -> str:
        """How it ended."""

    def about(self) -> dict[str, str]:
        """What was run."""


class Window:
    """Records that were written and not taken away yet.

    Parameters
    ----------
    run : RunOfScene
    kinds : tuple of str
        What is kept of a record.
    """

    def __init__(self, run: RunOfScene, kinds: tuple[str, ...]) -> None:
        motion = run.world.bodies.motion
        self.kinds, self.world, self.works_of, self.count = kinds, run.world, run.works, 0
        rows = max(2, SCENE_WINDOW // (8 * (motion.x.size + motion.v.size)))
        rows = min(run.table.count, rows) if run.is_counted else rows
        self.t, self.worst, self.works = np.empty(rows), np.empty((rows, 2)), np.empty((rows, len(run.works)))
        self.x, self.v = np.empty((rows, *motion.x.shape)), np.empty((rows, *motion.v.shape))
        self.beside = rows_beside(self.world.dim, kinds)
        self._clear()
        joints = len(run.scene.joints) if CONTACTS in kinds else 0
        self.pulls = np.empty((rows, joints, run.scene.dim))

    def _clear(self) -> None:
        self.count = 0
        self.parts: dict[str, list[Rows]] = {kind: [] for kind in self.beside}  # rows that stand beside the records

    @property
    def is_full(self) -> bool:
        """Whether there is no room for one more."""
        return self.count == len(self.t)

    def put(self, run: RunOfScene, t: float) -> None:
        """Write the state of the run."""
        k, motion, figures = self.count, run.world.bodies.motion, run.assembly.progress.figures
        self.t[k], self.worst[k] = t, (figures.since_residual, figures.since_penetration)
        if BODIES in self.kinds or LEDGER in self.kinds:
            self.x[k], self.v[k] = motion.x, motion.v
        if LEDGER in self.kinds:
            self.works[k] = run.assembly.ledger.work
        if CONTACTS in self.kinds:
            self.parts[CONTACTS].append(contacts_of(run))
        if PAIRS in self.kinds:
            self.parts[PAIRS].append(exchanged(run.assembly.pairs))
        if self.pulls.size:
            self.pulls[k] = run.assembly.joint_impulses() if run.steps else 0.0
        self.count = k + 1

    def take(self) -> tuple[Rows, dict[str, Rows]]:
        """Take the records out: their columns, and those of what stands beside them, by kind."""
        n, dim = self.count, self.world.dim
        x, v = self.x[:n], self.v[:n]
        columns: Rows = {"t": self.t[:n], "residual": self.worst[:n, 0], "penetration": self.worst[:n, 1]}
        if BODIES in self.kinds:
            turn, spin = (x[:, :, 2], v[:, :, 2]) if dim == 2 else (self.world.turns(x[:, :, 3:]), v[:, :, 3:])
            columns |= {"position": x[:, :, :dim], "turn": turn, "velocity": v[:, :, :dim], "spin": spin}
        if LEDGER in self.kinds:
            columns |= self.world.energies(x, v) | {name: self.works[:n, w] for w, name in enumerate(self.works_of)}
        beside = {}
        for kind, row in self.beside.items():
            columns[f"n_{kind}"] = np.array([len(found["i"]) for found in self.parts[kind]], np.int64)
            beside[kind] = joined(self.parts[kind], row)
        if self.pulls.size:
            columns[JOINT_IMPULSES] = self.pulls[:n]
        self._clear()
        return columns, beside


def contacts_of(run: RunOfScene) -> Rows:
    """The contacts of the last step: bodies, points, normals, gaps, impulses in the axes of the world, friction."""
    rows = run.assembly.contact_rows()
    n = None if run.steps else 0
    columns = {name: getattr(rows, name)[:n].copy() for name in ("i", "j", "point", "normal", "gap", "mu")}
    return columns | {"P": rows.in_world()[:n]}


def row_of(run: RunOfScene, kinds: tuple[str, ...]) -> np.dtype:
    """A record of a run."""
    scene = run.scene
    return record_row(len(scene.bodies), scene.dim, kinds, run.works, len(scene.joints))


def joined(parts: list[Rows], row: np.dtype) -> Rows:
    """Columns of such rows, one record behind the other."""
    none = np.empty(0, row)
    return {name: np.concatenate([none[name], *(part[name] for part in parts)]) for name in row.names or ()}


class SceneRecorder:
    """Records in memory.

    Parameters
    ----------
    kinds : tuple of str
        Of "bodies", "contacts", "ledger", "events", "pairs": what is kept beside times, residuals and penetrations.
    """

    def __init__(self, kinds: tuple[str, ...] = UNASKED) -> None:
        self.kinds = kinds

    def require_room(self, run: RunOfScene) -> None:
        """Raise `InvalidInput` for more records than there is memory for."""
        row = row_of(run, self.kinds)
        needed = float(row.itemsize) * run.table.count
        require_memory(needed, f"{run.table.count} records", "take a larger every or dt, or checkpoint=")

    def begin(self, run: RunOfScene) -> None:
        """Get ready before the first record; contacts are reckoned to stay as many as there are at the start."""
        count = run.table.count
        self.window = Window(run, self.kinds)
        row = row_of(run, self.kinds)
        self.records = {name: np.zeros((count + 1, *row[name].shape), row[name].base) for name in row.names or ()}
        self.beside = rows_beside(run.scene.dim, self.kinds)
        self.parts: dict[str, list[Rows]] = {kind: [] for kind in self.beside}
        self.rows, self.held, self.looked = 0, 0, 0  # records; bytes of what stands beside them
        if self.beside:
            each = sum(row.itemsize for row in self.beside.values())
            needed = (row.itemsize + float(each) * run.n_touching) * count
            what = f"{count} records of {run.n_touching} contacts"
            require_memory(needed, what, "take a larger every or dt, record=('bodies',), or checkpoint=")

    def write(self, run: RunOfScene, t: float) -> None:
        """Write the state of the run as its next record."""
        if self.window.is_full:
            self.empty(run)
        self.window.put(run, t)

    def empty(self, run: RunOfScene) -> None:
        """Empty the window."""
        columns, beside = self.window.take()
        n = len(columns["t"])
        self._require_rows(run, self.rows + n)
        for name, column in columns.items():
            self.records[name][self.rows : self.rows + n] = column
        self.rows += n
        for kind, rows in beside.items():
            self.parts[kind].append(rows)
            self.held += self.beside[kind].itemsize * len(rows["i"])
        self._require_room_beside(run)

    def _require_rows(self, run: RunOfScene, rows: int) -> None:
        """Room for so many records, of a run whose number of records is that of its steps."""
        if rows <= len(self.records["t"]):
            return
        room = rows + 1
        if run.status == Status.RUNNING:
            room = GROWTH * rows
            try:
                held = sum(column.nbytes for column in self.records.values())
                require_memory(room / len(self.records["t"]) * held, "records", "")
            except InvalidInput:
                run.stop("the free memory, which records of all steps would exceed,")
                room = rows + 1
        for name, column in self.records.items():
            grown = np.zeros((room, *column.shape[1:]), column.dtype)
            grown[: self.rows] = column[: self.rows]
            self.records[name] = grown

    def _require_room_beside(self, run: RunOfScene) -> None:
        """Stop a run whose contacts and pairs, each time they have doubled, would not fit at the rate so far."""
        if self.held < 2 * self.looked or run.status != Status.RUNNING:
            return
        self.looked = self.held
        left = self.held / self.rows * (run.table.count - self.rows if run.is_counted else self.rows)
        try:
            require_memory(left, "contacts", "")
        except InvalidInput:
            run.stop("the free memory, which contacts of all records would exceed,")

    def look(self, run: RunOfScene) -> None:
        """Between two blocks of steps, some 50 times a second."""

    def end(self, run: RunOfScene) -> None:
        """The run has come to its end, or was stopped: its state is the last record, unless it is one already."""
        if run.status != Status.FINISHED and not run.is_at_record:
            self.write(run, run.now)
        self.empty(run)

    def close(self) -> None:
        """Nothing is written any more."""

    def solution(self, run: RunOfScene) -> SceneSolution:
        """What was computed."""
        records = {name: column[: self.rows] for name, column in self.records.items()}
        beside = {kind: joined(self.parts[kind], row) for kind, row in self.beside.items()}
        columns = columns_of(records, beside.get(CONTACTS, {}), self.kinds, run.works) | run.watched()
        joint_names = [joint.name for joint in run.scene.joints]
        if PAIRS in self.kinds:
            columns[PAIRS] = pairs_of(records, beside[PAIRS], run.names, joint_names)
        return SceneSolution(
            **columns, stats=run.stats(), status=run.status, message=run.message(), names=run.names, scene=run.scene,
            centres=run.world.frames[:, : run.scene.dim], about=run.about(), joint_names=joint_names,
        )  # fmt: skip
