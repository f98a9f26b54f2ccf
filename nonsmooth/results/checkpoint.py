"""Checkpoints: the folder into which a run writes as it goes, and from which it goes on.

    records.npy   one row a record: t, and what is recorded of q, u, g_N, P_N, P_F, mode, slip, ledger (and la)
    events.npy    one row an event, where they are recorded
    *.crc.npy     the checksums of both, block by block
    state.npz     all that the next step depends on, with the numbers of records and events that belong to it; sealed

Of a scene contacts.npy and pairs.npy stand in the place of the events: a row a contact of a record, and a pair,
record after record, as many as a record counts. The arrays grow (checked_array.py); the state is written to
state.npz.part and moved into place, after the rows that it belongs to. Whenever the program dies, the arrays can be
read and the state is that of one moment; what lies between the two is computed again, to the same bits. Rows of the
state that do not fit their checksums are damage, and refused; rows behind them that do not are what a power failure
leaves, and left away. Why no HDF5, and what is lost when: docs/checkpoints.md. No pickle.
"""

from __future__ import annotations

import functools
import json
import os
import types
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nonsmooth.checks.files import refusals
from nonsmooth.errors import CheckpointFailure, InvalidInput, Status
from nonsmooth.integrators.records import EVENT_T, EVENT_WIDTH, N_LEDGER
from nonsmooth.mechanics.description import of_names
from nonsmooth.mechanics.system import System
from nonsmooth.results.checked_array import CheckedArray, checksums_of, verified_rows
from nonsmooth.results.events import MAX_EVENTS
from nonsmooth.results.growing_array import map_rows
from nonsmooth.results.ledger import finder_of_ledger
from nonsmooth.results.motion import of_records
from nonsmooth.results.npz import fill_npz, read_npz
from nonsmooth.results.recorded import EVENTS, KINDS, LEDGER
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.results.seal import require_kind
from nonsmooth.results.solution import PER_RECORD, Solution
from nonsmooth.results.stats import Stats, stats_of_scene
from nonsmooth.results.table import EVENT, SYSTEM, columns_along, row_type, scene_arrays, scene_rows

if TYPE_CHECKING:
    from nonsmooth.scenes.scene import Scene

CHECKPOINT_SCHEMA, KIND, SCENE_KIND = 1, "checkpoint", "scenecheckpoint"  # code: of the form of the file
READERS = {KIND: ("System", "ns.Solution.load"), SCENE_KIND: ("scene", "ns.SceneSolution.load")}
STATE, PART = "state.npz", "state.npz.part"
HASHED = "#"  # code: how a fact begins of which only the hash is kept
EVENT_ROW = np.dtype([(column.name, "<f8") for column in EVENT])


class Shape(NamedTuple):
    """What a record holds: coordinates, velocities, contacts, directions of friction, whether it holds the forces, and
    what is recorded."""

    n_q: int
    n_u: int
    n_c: int
    d: int
    has_forces: bool
    recorded: tuple[str, ...] = KINDS


class Layout(NamedTuple):
    """What a checkpoint holds."""

    kind: str  # as which its state is sealed
    shape: Any  # what the rows are made from, as JSON can hold it
    rows: dict[str, np.dtype]  # of each array, by its name; the first is that of the records


def layout_of(shape: Shape) -> Layout:
    """That of a run of a `System`."""
    sizes = {"n_q": shape.n_q, "n_u": shape.n_u, "n_c": shape.n_c, "d": shape.d, "1 + d": 1 + shape.d}
    columns = tuple(column for column in columns_along(SYSTEM, "n_t", shape.recorded)
                    if shape.has_forces or column.name != "la")  # fmt: skip
    works = [("ledger", "<f8", (N_LEDGER,))] if LEDGER in shape.recorded else []
    events = {EVENTS: EVENT_ROW} if EVENTS in shape.recorded else {}
    return Layout(KIND, shape, {"records": np.dtype(row_type(columns, sizes).descr + works)} | events)


def scene_layout(n_b: int, dim: int, kinds: tuple[str, ...], n_j: int, works: tuple[str, ...]) -> Layout:
    """That of a run of a scene with so many bodies and joints, and such works in its ledger."""
    return Layout(SCENE_KIND, [n_b, dim, list(kinds), n_j, list(works)], scene_rows(n_b, dim, kinds, n_j, works))


class Checkpoint:
    """An open checkpoint.

    Parameters
    ----------
    path : path-like
        The folder.
    facts : dict
        All that the bits of the run depend on, by name, as JSON can hold it.
    layout : Layout
    may_begin, may_resume : bool
        What is asked for: a checkpoint that is not there yet, one that is there, or either.

    Attributes
    ----------
    said : dict
        What no bit depends on: names, the model, how the motion between the records is found.
    kept : dict
        The arrays of the state that was found; empty where the run begins.

    Raises
    ------
    InvalidInput
        For a checkpoint of another run, a folder that is none, one that is there already, one that is not.
    """

    def __init__(self, path: Any, facts: dict[str, Any], layout: Layout, may_begin: bool, may_resume: bool) -> None:
        self.path, self.facts, self.layout = Path(path), json.loads(json.dumps(facts)), layout
        self.shown = dict.fromkeys(layout.rows, 0)
        self.status, self.wall_time = Status.RUNNING, 0.0
        self.kept: dict[str, np.ndarray] = {}
        self.said: dict[str, Any] = {}
        is_there = (self.path / STATE).exists()
        if is_there and not may_resume:
            raise InvalidInput(f"there is a checkpoint {str(path)!r} already; resume= goes on with it, or remove it")
        if not is_there:
            self._require_free(may_begin)
        counts = self._restore() if is_there else self.shown
        self._files = ExitStack()
        try:
            self.path.mkdir(exist_ok=True)
            if not is_there:
                self._remove_arrays()
            self._arrays = {name: self._open(name, row, counts[name]) for name, row in layout.rows.items()}
        except OSError as error:
            self._files.close()
            raise InvalidInput(
                f"the checkpoint {str(path)!r} cannot be written: {error}; choose another path"
            ) from None

    def _require_free(self, may_begin: bool) -> None:
        """Raise unless a run may begin here: nothing there, or one that died before it kept its first state."""
        if self.path.is_dir():
            ours = {PART, *(file.name for file in self._files_of_arrays())}
            foreign = {entry.name for entry in self.path.iterdir()} - ours
            if foreign:
                raise InvalidInput(
                    f"{str(self.path)!r} is no checkpoint, it holds {min(foreign)!r}; choose another path"
                )
        elif self.path.exists():
            raise InvalidInput(f"{str(self.path)!r} is no checkpoint, which is a folder; choose another path")
        elif not may_begin:
            raise InvalidInput(f"there is no checkpoint {str(self.path)!r}; checkpoint= begins one")

    def _restore(self) -> dict[str, int]:
        """Take the state that is there; the numbers of rows that belong to it."""
        about, self.kept = read_state(self.path, self.layout.kind)
        _require_equal(self.path, about["facts"], self.facts)
        require_rows(self.path, about, self.layout.rows)
        self.status, self.wall_time = Status(about["status"]), about["stats"]["wall_time"]
        if about["shown"]:  # the row at which the run stopped is about to be forgotten
            forgotten = {key: 0 for key in about if key.startswith("shown")}
            self._put_state(about | forgotten | {"status": int(Status.RUNNING)}, self.kept)
        return {name: about[name] for name in self.layout.rows}

    def _remove_arrays(self) -> None:
        """Forget rows that no state belongs to."""
        for file in self._files_of_arrays():
            file.unlink(missing_ok=True)

    def _files_of_arrays(self) -> list[Path]:
        files = [file_of(self.path, name) for name in self.layout.rows]
        return [*files, *map(checksums_of, files)]

    def _open(self, name: str, row: np.dtype, rows: int) -> CheckedArray:
        return self._files.enter_context(closing(CheckedArray(file_of(self.path, name), row, rows)))

    def count(self, name: str) -> int:
        """Rows in an array."""
        return self._arrays[name].rows

    def write(self, rows: dict[str, np.ndarray]) -> None:
        """Append rows to arrays, to the records last: no row of them is without those that it speaks of."""
        with self._refusals():
            for name, new in reversed(self._in_order(rows)):
                self._arrays[name].append(new)
        self.shown = dict.fromkeys(self.layout.rows, 0)

    def _in_order(self, rows: dict[str, np.ndarray]) -> list[tuple[str, np.ndarray]]:
        return [(name, rows[name]) for name in self.layout.rows if name in rows and len(rows[name])]

    def keep(self, arrays: dict[str, Any], about: dict[str, Any], status: Status, message: str, stats: Any) -> None:
        """Put the rows on the disk, and then the state that belongs to them."""
        text = {
            "checkpoint": "nonsmooth", "schema": CHECKPOINT_SCHEMA, "facts": self.facts, "shape": self.layout.shape,
            **{name: array.rows for name, array in self._arrays.items()},
            **{shown_of(name): count for name, count in self.shown.items()},
            "status": int(status), "message": message, "stats": vars(stats), "about": about,
            "said": self.said,
        }  # fmt: skip
        with self._refusals():
            for array in self._arrays.values():
                array.sync()
            self._put_state(text, arrays)

    def _put_state(self, about: dict[str, Any], arrays: dict[str, Any]) -> None:
        part = self.path / PART
        with open(part, "w+b") as file:
            fill_npz(file, self.layout.kind, {"about": np.array(json.dumps(about)), **arrays}, is_compressed=False)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, self.path / STATE)

    def write_last(self, rows: dict[str, np.ndarray]) -> None:
        """Show the state at which a run stopped as one more record: the next one will stand in its place."""
        with self._refusals():
            for name, last in reversed(self._in_order(rows)):
                self._arrays[name].show(last)
                self.shown[name] = len(last)

    def close(self) -> None:
        """Close the arrays; what they hold stays."""
        self._files.close()

    @contextmanager
    def _refusals(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise CheckpointFailure(
                f"the checkpoint {str(self.path)!r} could not be written: {error.strerror}; what it held before is "
                "whole. Make room and resume it"
            ) from error


def load_checkpoint(
    path: Path, system_of: Callable[[dict[str, Any] | None, int, int], System | None], is_verified: bool = False
) -> Solution:
    """The records of a checkpoint as a Solution; its arrays are views of the file, read where they are looked at.

    ``system_of`` finds the system from the model that is named, the number of coordinates and that of contacts.

    Without the system the ledger has no kinetic and potential energy. Every byte is read once to verify the checksums,
    but where this very program verified or wrote them.

    Raises
    ------
    InvalidInput
        For a folder that is no checkpoint, or a damaged one.
    """
    about, _ = read_state(path, KIND)
    shape = Shape(*about["shape"])
    arrays = rows_of(path, about, layout_of(shape).rows, is_verified)
    rows, status_and_message = arrays["records"], end_of(about)
    said = about["said"]
    system = system_of(said["model"], shape.n_q, shape.n_c)
    kept: dict[str, Any] = {name: rows[name] for name in rows.dtype.names or ()}
    columns = {name: kept.get(name) for name in PER_RECORD}
    record = types.SimpleNamespace(**kept)
    events = _in_time(arrays["events"]) if "events" in arrays else None
    theta, find_motion = said["theta"], None
    has_jumps = events is not None and len(arrays["events"]) <= MAX_EVENTS  # of which a motion must know all
    if theta is not None and events is not None and has_jumps and {"q", "u", "mode"} <= kept.keys():
        is_straight, (t, q, u, mode) = (
            bool(said["names"]["velocities"]),
            (kept[name] for name in ("t", "q", "u", "mode")),
        )
        find_motion = functools.partial(of_records, theta, is_straight, t, q, u, mode, events)
    solution = Solution(
        **columns, event_rows=events,  # type: ignore[arg-type]
        find_ledger=finder_of_ledger(system, record, shape.recorded),  # type: ignore[arg-type]
        stats=Stats(**about["stats"]), status=status_and_message[0], message=status_and_message[1],
        about=about["about"], system=system, theta=theta if find_motion is not None else None, find_motion=find_motion,
        names=of_names(said["names"]),
        named_model=said["model"],
    )  # fmt: skip
    return solution if about["facts"]["records_start"] or len(rows) < 2 else solution.without_start()


def load_scene_checkpoint(path: Path, scene: Scene | None = None, is_verified: bool = False) -> SceneSolution:
    """The same of a run of a scene; records whose contacts or pairs are not there are left away.

    Raises
    ------
    InvalidInput
    """
    about, kept = read_state(path, SCENE_KIND)
    rows = rows_of(path, about, scene_layout(*about["shape"]).rows, is_verified)
    for kind in rows.keys() - {"records"}:
        counted = np.cumsum(rows["records"][f"n_{kind}"])
        rows["records"] = rows["records"][: np.searchsorted(counted, len(rows[kind]), side="right")]
        if len(rows["records"]) < about["records"]:
            raise InvalidInput(f"the checkpoint {str(path)!r} is damaged: {kind} of its records are not there")
    status, message = end_of(about)
    columns = scene_arrays(rows) | {name: kept[name] for name in ("centres", "paradox_rows")}
    return SceneSolution(
        columns, stats=stats_of_scene(about["stats"]), status=status, message=message, scene=scene,
        about=about["about"], **about["said"],
    )  # fmt: skip


def _in_time(rows: np.ndarray) -> np.ndarray:
    """Events as rows of numbers, in the order of time."""
    events = np.array(rows[:MAX_EVENTS]).view("<f8").reshape(-1, EVENT_WIDTH)
    return events[np.argsort(events[:, EVENT_T], kind="stable")]


def end_of(about: dict[str, Any]) -> tuple[Status, str]:
    """How a run ended, in a sentence; one that was killed was interrupted."""
    status = Status(about["status"])
    if status == Status.RUNNING:
        return (
            Status.INTERRUPTED,
            "the program ended before the run did (or is still at work); resume= goes on with it",
        )
    return status, about["message"]


def file_of(path: Path, name: str) -> Path:
    """Where an array stands."""
    return path / f"{name}.npy"


def shown_of(name: str) -> str:
    """Where the state keeps how many rows of an array are those of the state at which the run stopped."""
    return "shown" if name == "records" else f"shown {name}"


def read_state(path: Path, kind: str = KIND) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """What is known of the run, and the arrays of its state."""
    if not os.path.exists(path / STATE):
        raise InvalidInput(f"{str(path)!r} is no checkpoint: it has no {STATE}")
    with refusals(path, f"is no checkpoint: {STATE} is none of ours"):
        found = read_npz(path / STATE)
        about = found.about()
        schema = about["schema"] if about["checkpoint"] == "nonsmooth" else None
        if schema != CHECKPOINT_SCHEMA:
            raise InvalidInput(
                f"the checkpoint {str(path)!r} has schema {schema}; this version reads {CHECKPOINT_SCHEMA}"
            )
        if found.kind != kind and found.kind in READERS:
            what, reader = READERS[found.kind]
            raise InvalidInput(f"the checkpoint {str(path)!r} is that of a run of a {what}; {reader} reads it")
        require_kind(found.kind, kind)
    return about, found.arrays


def require_rows(path: Path, about: dict[str, Any], rows: dict[str, np.dtype]) -> dict[str, int]:
    """How many rows of each array fit their checksums; raises unless those of the state do."""
    return {
        name: _require_rows(file_of(path, name), row, about[name] + about[shown_of(name)]) for name, row in rows.items()
    }


def rows_of(
    path: Path, about: dict[str, Any], rows: dict[str, np.dtype], is_verified: bool
) -> dict[str, np.ndarray]:  # fmt: skip
    """The rows of each array, mapped; those that fit their checksums, unless this program verified or wrote them."""
    counts = dict.fromkeys(rows) if is_verified else require_rows(path, about, rows)
    return {name: map_rows(file_of(path, name), row)[: counts[name]] for name, row in rows.items()}


def _require_rows(path: Path, row: np.dtype, least: int) -> int:
    try:
        count = verified_rows(path, row)
        if count < least:
            raise ValueError(f"of its first {least} rows {least - count} are not what was written, or are not there")
    except (OSError, ValueError) as error:
        raise InvalidInput(f"the checkpoint {str(path.parent)!r} is damaged: {path.name}: {error}") from error
    return count


def _require_equal(path: Path, there: dict[str, Any], here: dict[str, Any]) -> None:
    """Raise unless a checkpoint is of this very run."""
    for what in here:
        old, new = there.get(what), here[what]
        if old == new:
            continue
        if isinstance(new, dict) and isinstance(old, dict):
            name = next(name for name in sorted(new.keys() | old.keys()) if old.get(name) != new.get(name))
            what, old, new = f"{what} {name}", old.get(name), new.get(name)
        is_hashed = what.startswith("code of ") or str(new).startswith(HASHED)
        difference = f"its {what} differs" if is_hashed else f"its {what} is {old}, here it is {new}"
        raise InvalidInput(
            f"the checkpoint {str(path)!r} is of another run: {difference}; give what it was begun with, or choose "
            "another path"
        )
