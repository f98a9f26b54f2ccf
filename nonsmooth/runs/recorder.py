"""Where the rows, the steps and the events of a run go: into memory.

A method with a fixed step has a row for each record time from the beginning on, and keeps it there. The rows of one
that chooses its steps are taken from block to block, and so are its steps, where the motion is wanted.

Records of a scene go through a window of some. It has the state as the steps have it, the principal axes of the bodies;
what users are shown, with energies, is made of many records at once when the window is emptied.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nonsmooth.checks.memory import require_memory
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.assembly.written import Written
from nonsmooth.integrators.contract import Integrator
from nonsmooth.integrators.fixed_step import FixedStep
from nonsmooth.integrators.records import EVENT_T, EVENT_WIDTH, Columns, Record, bytes_of_record, no_rows
from nonsmooth.jit.blocks import new
from nonsmooth.results.events import MAX_EVENTS
from nonsmooth.results.recorded import BODIES, CONTACTS, KINDS, KINDS_OF_SCENE, LEDGER, PAIRS
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.results.solution import Solution
from nonsmooth.results.table import scene_arrays, scene_rows
from nonsmooth.runs.ongoing import STEPS_PER_VISIT, Ongoing, columns_of, left_out

ROW_CAPACITY = 4096  # chosen: rows between two visits of Python
GROWTH = 2  # chosen: of the room for records of a scene, where their number is that of the steps
SCENE_WINDOW = 2**22  # chosen: bytes of records of a scene in the window
CONTACT_ROWS = 2**13  # chosen: contacts of records that steps write by themselves, between two visits of Python

Arrays = dict[str, np.ndarray]
SceneRun = Any  # of scene_run.py, which has a recorder
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
        lengths["curved"] = integrator.curved
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
    return bool(run.now > t if run.integrator.chooses_steps else run.state.counters.step > 0)


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
    columns = (steps.t, steps.h, steps.q, steps.u, steps.B, *((steps.Q,) if steps.Q.size else ()))
    taken = tuple(column[: steps.n_steps].copy() for column in columns)
    steps.n_steps = 0
    return taken


class Window:
    """Records that were written and not taken away yet.

    Parameters
    ----------
    run : SceneRun
    kinds : tuple of str
        What is kept of a record.
    """

    def __init__(self, run: SceneRun, kinds: tuple[str, ...]) -> None:
        motion = run.world.bodies.motion
        self.kinds, self.world, self.works = kinds, run.world, run.works
        rows = max(2, SCENE_WINDOW // (8 * (motion.x.size + motion.v.size)))
        self.size = min(run.table.count, rows) if run.is_counted else rows
        self.counted = counted_rows(run, kinds)
        self.written = self._room(run, rows_of_contacts=CONTACT_ROWS if CONTACTS in kinds else 0)
        self.held = {name: getattr(self.written, name) for name in state_of(run, kinds)}
        if run.world.dim == 2 and CONTACTS in kinds:
            self.held["joint_torques"] = self.held["joint_torques"][:, :, 0]
        self.numbers = {kind: np.zeros(self.size, np.int64) for kind in self.counted}  # of rows of each record
        self._clear()

    def _room(self, run: SceneRun, rows_of_contacts: int) -> Written:
        motion = run.world.bodies.motion
        (n_b, n_x), n = motion.x.shape, motion.v.shape[1]
        written = new(
            Written, m=self.size, n_b=n_b, n_x=n_x, n=n, n_w=len(run.assembly.ledger.work),
            n_n=len(run.assembly.reactions.P), d=run.world.dim, r=rows_of_contacts,
        )  # fmt: skip
        written.has_contacts = CONTACTS in self.kinds
        return written

    def _clear(self) -> None:
        self.count = 0
        self.parts: dict[str, list[Arrays]] = {kind: [] for kind in self.counted}  # rows that records count

    @property
    def is_full(self) -> bool:
        """Whether there is no room for one more."""
        return self.count == self.size

    def put(self, run: SceneRun, t: float) -> None:
        """Write the state of the run."""
        for name, value in state_of(run, self.kinds, t).items():
            self.held[name][self.count] = value
        if CONTACTS in self.kinds:
            self._add(CONTACTS, contacts_of(run, self.counted[CONTACTS].names or ()))
        if PAIRS in self.kinds:
            self._add(PAIRS, run.assembly.exchanged())
        self.count += 1

    def _add(self, kind: str, rows: Arrays) -> None:
        """Add the rows of a record."""
        self.parts[kind].append(rows)
        self.numbers[kind][self.count] = len(rows["i"])

    def let_write(self, times: Sequence[float], due: int, stride: int) -> Written:
        """Let steps write the next records by themselves: those of these times [s], so many steps apart, the first one
        behind step ``due``."""
        written = self.written
        written.n, written.rows, written.due, written.stride = self.count, 0, due, stride
        written.is_mixed = 0
        written.t[self.count : self.count + len(times)] = times
        return written

    def take_written(self) -> int:
        """Take over what they wrote; how many records that are."""
        written, before = self.written, self.count
        self.count = int(written.n)
        if CONTACTS in self.kinds and self.count > before:
            counts = self.numbers[CONTACTS][before : self.count] = written.contacts[before : self.count]
            order: Any = slice(int(written.rows))
            if written.is_mixed:  # in the order of their keys, as those of a step
                order = np.lexsort((written.key[order], np.repeat(np.arange(len(counts)), counts)))
            names = self.counted[CONTACTS].names or ()
            self.parts[CONTACTS].append({name: getattr(written, name)[order].copy() for name in names})
        return self.count - before

    def take(self) -> dict[str, Arrays]:
        """Take the records out: their columns, and those of the kinds that they count."""
        columns, dim = {name: column[: self.count] for name, column in self.held.items()}, self.world.dim
        x, v, works = (columns.pop(name, np.empty(0)) for name in ("x", "v", "works"))
        if BODIES in self.kinds:
            turn, spin = (x[:, :, 2], v[:, :, 2]) if dim == 2 else (self.world.turns(x[:, :, 3:]), v[:, :, 3:])
            columns |= {"position": x[:, :, :dim], "turn": turn, "velocity": v[:, :, :dim], "spin": spin}
        if LEDGER in self.kinds:
            ledger = self.world.energies(x, v) | dict(zip(self.works, works.T, strict=True))
            columns |= {f"{LEDGER}/{name}": column for name, column in ledger.items()}
        rows = {"records": columns}
        for kind, row in self.counted.items():
            columns[f"n_{kind}"] = self.numbers[kind][: self.count].copy()
            rows[kind] = joined(self.parts[kind], row)
        self._clear()
        return rows


def state_of(run: SceneRun, kinds: tuple[str, ...], t: float = 0.0) -> dict[str, Any]:
    """What a record is made of, at a time: columns of the table, and x, v and works, which many are made of at once."""
    motion, figures = run.world.bodies.motion, run.assembly.progress.figures
    state: dict[str, Any] = {"t": t, "residual": figures.since_residual, "penetration": figures.since_penetration}
    if BODIES in kinds or LEDGER in kinds:
        state |= {"x": motion.x, "v": motion.v}
    if LEDGER in kinds:
        state["works"] = run.assembly.ledger.work
    if CONTACTS in kinds:
        state |= run.assembly.reactions_of_joints()
    return state


def contacts_of(run: SceneRun, names: Sequence[str]) -> Arrays:
    """Columns of the contacts of the last step."""
    rows, n = run.assembly.contact_rows(), None if run.steps else 0
    return {name: getattr(rows, name)[:n].copy() for name in names}


def rows_of(run: SceneRun, kinds: tuple[str, ...]) -> dict[str, np.dtype]:
    """The rows of a run: of its records, and of the kinds that they count."""
    scene = run.scene
    return scene_rows(len(scene.bodies), scene.dim, kinds, len(scene.joints), run.works)


def counted_rows(run: SceneRun, kinds: tuple[str, ...]) -> dict[str, np.dtype]:
    """Those of the kinds that its records count."""
    return {kind: row for kind, row in rows_of(run, kinds).items() if kind != "records"}


def joined(parts: list[Arrays], row: np.dtype) -> Arrays:
    """Columns of such rows, one record behind the other."""
    none = np.empty(0, row)
    return {name: np.concatenate([none[name], *(part[name] for part in parts)]) for name in row.names or ()}


class SceneRecorder:
    """Records in memory.

    Parameters
    ----------
    kinds : tuple of str
        Of "bodies", "contacts", "ledger", "events", "pairs": what is kept with times, residuals and penetrations.
    """

    is_resumed = False  # whether it writes a checkpoint

    def __init__(self, kinds: tuple[str, ...] = KINDS_OF_SCENE.unasked) -> None:
        self.kinds = kinds

    def require_room(self, run: SceneRun) -> None:
        """Raise `InvalidInput` for more records than there is memory for."""
        needed = float(rows_of(run, self.kinds)["records"].itemsize) * run.table.count
        require_memory(needed, f"{run.table.count} records", "take a larger every or dt, or checkpoint=")

    def begin(self, run: SceneRun) -> None:
        """Get ready before the first record; contacts are reckoned to stay as many as there are at the start."""
        count = run.table.count
        self.window = Window(run, self.kinds)
        row = rows_of(run, self.kinds)["records"]
        self.records = {name: np.zeros((count + 1, *row[name].shape), row[name].base) for name in row.names or ()}
        self.counted = counted_rows(run, self.kinds)
        self.parts: dict[str, list[Arrays]] = {kind: [] for kind in self.counted}
        self.rows, self.held, self.looked = 0, 0, 0  # records; bytes of what they count
        if self.counted:
            each = sum(row.itemsize for row in self.counted.values())
            needed = (row.itemsize + float(each) * run.n_touching) * count
            what = f"{count} records of {run.n_touching} contacts"
            require_memory(needed, what, "take a larger every or dt, record=('bodies',), or checkpoint=")

    def write(self, run: SceneRun, t: float) -> None:
        """Write the state of the run as its next record."""
        if self.window.is_full:
            self.empty(run)
        self.window.put(run, t)

    def empty(self, run: SceneRun) -> None:
        """Empty the window, where there is something in it."""
        if self.window.count == 0:
            return
        counted = self.window.take()
        columns = counted.pop("records")
        n = len(columns["t"])
        self._require_rows(run, self.rows + n)
        for name, column in columns.items():
            self.records[name][self.rows : self.rows + n] = column
        self.rows += n
        for kind, rows in counted.items():
            self.parts[kind].append(rows)
            self.held += self.counted[kind].itemsize * len(rows["i"])
        self._require_room_for_counted(run)

    def _require_rows(self, run: SceneRun, rows: int) -> None:
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
                run.spend("the free memory, which records of all steps would exceed,")
                room = rows + 1
        for name, column in self.records.items():
            grown = np.zeros((room, *column.shape[1:]), column.dtype)
            grown[: self.rows] = column[: self.rows]
            self.records[name] = grown

    def _require_room_for_counted(self, run: SceneRun) -> None:
        """Stop a run whose contacts and pairs, each time they have doubled, would not fit at the rate so far."""
        if self.held < 2 * self.looked or run.status != Status.RUNNING:
            return
        self.looked = self.held
        left = self.held / self.rows * (run.table.count - self.rows if run.is_counted else self.rows)
        try:
            require_memory(left, "contacts", "")
        except InvalidInput:
            run.spend("the free memory, which contacts of all records would exceed,")

    def look(self, run: SceneRun) -> None:
        """Between two blocks of steps, some 50 times a second."""

    def end(self, run: SceneRun) -> None:
        """The run has come to its end, or was stopped: its state is the last record, unless it is one already."""
        if run.status != Status.FINISHED and not run.is_at_record:
            self.write(run, run.now)
        self.empty(run)

    def close(self) -> None:
        """Nothing is written any more."""

    def solution(self, run: SceneRun) -> SceneSolution:
        """What was computed."""
        records = {name: column[: self.rows] for name, column in self.records.items()}
        rows = {"records": records} | {kind: joined(self.parts[kind], row) for kind, row in self.counted.items()}
        return SceneSolution(
            scene_arrays(rows) | run.watched() | {"centres": run.centres}, stats=run.stats(), status=run.status,
            message=run.message(), names=run.names, scene=run.scene, about=run.about(),
            joint_names=[joint.name for joint in run.scene.joints],
        )  # fmt: skip
