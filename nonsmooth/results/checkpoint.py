"""Checkpoints: the folder into which a run writes as it goes, and from which it goes on.

    records.npy   one row a record: t, q, u, g_N, P_N, P_F, mode, slip, ledger (and la)
    events.npy    one row an event
    *.crc.npy     the checksums of both, block by block
    state.npz     all that the next step depends on, with the numbers of records and events that belong to it; sealed

The two arrays grow (checked_array.py); the state is written beside and moved into place, after the rows that it belongs
to. Whenever the program dies, the arrays can be read and the state is that of one moment; what lies between the two is
computed again, to the same bits. Rows of the state that do not fit their checksums are damage, and refused; rows behind
them that do not are what a power failure leaves, and left away. Why no HDF5, and what is lost when:
docs/checkpoints.md. No pickle.
"""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.checks.files import refusals
from nonsmooth.errors import CheckpointFailure, InvalidInput, Status
from nonsmooth.integrators.records import EVENT_T, EVENT_WIDTH, N_LEDGER
from nonsmooth.mechanics.system import System
from nonsmooth.results.checked_array import CheckedArray, checksums_of, verified_rows
from nonsmooth.results.growing_array import map_rows
from nonsmooth.results.npz import fill_npz, read_npz
from nonsmooth.results.seal import require_kind
from nonsmooth.results.solution import MAX_EVENTS, PER_RECORD, Solution, Stats, ledger_of, works_by_name

CHECKPOINT_SCHEMA, KIND = 1, "checkpoint"  # code: of the form of the file
RECORDS, EVENTS, STATE, PART = "records.npy", "events.npy", "state.npz", "state.npz.part"
EVENT_NAMES = (
    "t", "kind", "contact", "mode_before", "slip_before", "mode_after", "slip_after", "P_N", "P_F", "gamma_N",
    "gamma_F", "n_solutions", "found",
)  # fmt: skip
EVENT_ROW = np.dtype([(name, "<f8") for name in EVENT_NAMES])


class Shape(NamedTuple):
    """What a record holds: coordinates, contacts, directions of friction, and whether the forces."""

    n: int
    n_c: int
    d: int
    has_forces: bool


def row_type(n: int, n_c: int, d: int, has_forces: bool) -> np.dtype:
    """A row of ``records.npy``."""
    sizes = {"n_q": n, "n_u": n, "n_c": n_c, "d": d}
    columns = [
        (name, dtypes[-1], tuple(size if isinstance(size, int) else sizes[size] for size in shape[1:]))
        for name, (dtypes, shape) in PER_RECORD.items()
    ]
    forces = [("la", "<f8", (n_c, 2))] if has_forces else []
    return np.dtype([*columns, ("ledger", "<f8", (N_LEDGER,)), *forces])


class Checkpoint:
    """An open checkpoint.

    Parameters
    ----------
    path : path-like
        The folder.
    facts : dict
        All that the bits of the run depend on, by name, as JSON can hold it.
    shape : Shape
        Of a record.
    may_begin, may_resume : bool
        What is asked for: a checkpoint that is not there yet, one that is there, or either.

    Attributes
    ----------
    n_records, n_events : int
        Rows in the arrays.
    kept : dict
        The arrays of the state that was found; empty where the run begins.

    Raises
    ------
    InvalidInput
        For a checkpoint of another run, a folder that is none, one that is there already, one that is not.
    """

    def __init__(self, path: Any, facts: dict[str, Any], shape: Shape, may_begin: bool, may_resume: bool) -> None:
        self.path, self.facts, self.shape = Path(path), json.loads(json.dumps(facts)), shape
        self.row = row_type(*shape)
        self.shown = 0
        self.status, self.wall_time = Status.RUNNING, 0.0
        self.kept: dict[str, np.ndarray] = {}
        is_there = (self.path / STATE).exists()
        if is_there and not may_resume:
            raise InvalidInput(f"there is a checkpoint {str(path)!r} already; resume= goes on with it, or remove it")
        if not is_there:
            self._require_free(may_begin)
        n_records, n_events = self._restore() if is_there else (0, 0)
        self._files = ExitStack()
        try:
            self.path.mkdir(exist_ok=True)
            if not is_there:
                self._remove_arrays()
            self._records = self._open(RECORDS, self.row, n_records)
            self._events = self._open(EVENTS, EVENT_ROW, n_events)
        except OSError as error:
            self._files.close()
            raise InvalidInput(
                f"the checkpoint {str(path)!r} cannot be written: {error}; choose another path"
            ) from None

    def _require_free(self, may_begin: bool) -> None:
        """Raise unless a run may begin here: nothing there, or one that died before it kept its first state."""
        if self.path.is_dir():
            ours = {RECORDS, EVENTS, checksums_of(Path(RECORDS)).name, checksums_of(Path(EVENTS)).name, PART}
            foreign = {entry.name for entry in self.path.iterdir()} - ours
            if foreign:
                raise InvalidInput(
                    f"{str(self.path)!r} is no checkpoint, it holds {min(foreign)!r}; choose another path"
                )
        elif self.path.exists():
            raise InvalidInput(f"{str(self.path)!r} is no checkpoint, which is a folder; choose another path")
        elif not may_begin:
            raise InvalidInput(f"there is no checkpoint {str(self.path)!r}; checkpoint= begins one")

    def _restore(self) -> tuple[int, int]:
        """Take the state that is there; the numbers of records and events that belong to it."""
        about, self.kept = read_state(self.path)
        _require_equal(self.path, about["facts"], self.facts)
        require_rows(self.path, about)
        self.status, self.wall_time = Status(about["status"]), about["stats"]["wall_time"]
        if about["shown"]:  # the row at which the run stopped is about to be forgotten
            self._put_state(about | {"shown": 0, "status": int(Status.RUNNING)}, self.kept)
        return about["records"], about["events"]

    def _remove_arrays(self) -> None:
        """Forget rows that no state belongs to."""
        for name in (RECORDS, EVENTS):
            for file in (self.path / name, checksums_of(self.path / name)):
                file.unlink(missing_ok=True)

    def _open(self, name: str, row: np.dtype, rows: int) -> CheckedArray:
        return self._files.enter_context(closing(CheckedArray(self.path / name, row, rows)))

    @property
    def n_records(self) -> int:
        """Records in the array."""
        return self._records.rows

    @property
    def n_events(self) -> int:
        """Events in the array."""
        return self._events.rows

    def write(self, records: np.ndarray, events: np.ndarray) -> None:
        """Append rows."""
        with self._refusals():
            if len(records):
                self._records.append(records)
            if len(events):
                self._events.append(np.ascontiguousarray(events).view(EVENT_ROW)[:, 0])
        self.shown = 0

    def keep(self, arrays: dict[str, Any], about: dict[str, Any], status: Status, message: str, stats: Stats) -> None:
        """Put the rows on the disk, and then the state that belongs to them."""
        text = {
            "checkpoint": "nonsmooth", "schema": CHECKPOINT_SCHEMA, "facts": self.facts, "shape": self.shape,
            "records": self.n_records, "shown": self.shown, "events": self.n_events, "status": int(status),
            "message": message, "stats": asdict(stats), "about": about,
        }  # fmt: skip
        with self._refusals():
            self._records.sync()
            self._events.sync()
            self._put_state(text, arrays)

    def _put_state(self, about: dict[str, Any], arrays: dict[str, Any]) -> None:
        part = self.path / PART
        with open(part, "w+b") as file:
            fill_npz(file, KIND, {"about": np.array(json.dumps(about)), **arrays}, is_compressed=False)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, self.path / STATE)

    def write_last(self, record: np.ndarray) -> None:
        """Show the state at which a run stopped as one more row: the next record will stand in its place."""
        with self._refusals():
            self._records.show(record)
        self.shown = len(record)

    def close(self) -> None:
        """Close the two arrays; what they hold stays."""
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


def load_checkpoint(path: Path, system: System | None = None, is_verified: bool = False) -> Solution:
    """The records of a checkpoint as a Solution; its arrays are views of the file, read where they are looked at.

    Without the system the ledger has no kinetic and potential energy. Every byte is read once to verify the checksums,
    but where this very program verified or wrote them.

    Raises
    ------
    InvalidInput
        For a folder that is no checkpoint, or a damaged one.
    """
    about, _ = read_state(path)
    n_records, n_events = (None, None) if is_verified else require_rows(path, about)
    rows = map_rows(path / RECORDS, row_type(*about["shape"]))[:n_records]
    events = np.array(map_rows(path / EVENTS, EVENT_ROW)[:n_events][:MAX_EVENTS]).view("<f8").reshape(-1, EVENT_WIDTH)
    events = events[np.argsort(events[:, EVENT_T], kind="stable")]
    status, message = Status(about["status"]), about["message"]
    if status == Status.RUNNING:
        status = Status.INTERRUPTED
        message = "the program ended before the run did (or is still at work); resume= goes on with it"
    find_ledger = functools.partial(_works_at, rows["ledger"])
    if system is not None:
        find_ledger = functools.partial(ledger_of, system, *(rows[name] for name in ("t", "q", "u", "ledger")))
    columns: dict[str, Any] = {name: rows[name] for name in PER_RECORD}
    solution = Solution(
        **columns, event_rows=events, find_ledger=find_ledger, stats=Stats(**about["stats"]), status=status,
        message=message, about=about["about"], system=system,
        la=rows["la"] if "la" in (rows.dtype.names or ()) else None,
    )  # fmt: skip
    return solution if about["facts"].get("records_start", True) or len(rows) < 2 else solution.without_start()


def _works_at(works: np.ndarray, rows: Any) -> dict[str, np.ndarray]:
    return works_by_name(works[rows])


def read_state(path: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
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
        require_kind(found.kind, KIND)
    return about, found.arrays


def require_rows(path: Path, about: dict[str, Any]) -> tuple[int, int]:
    """How many records and events fit their checksums; raises unless those of the state do."""
    return (
        _require_rows(path / RECORDS, row_type(*about["shape"]), about["records"] + about["shown"]),
        _require_rows(path / EVENTS, EVENT_ROW, about["events"]),
    )


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
        difference = f"its {what} differs" if what.startswith("code of ") else f"its {what} is {old}, here it is {new}"
        raise InvalidInput(
            f"the checkpoint {str(path)!r} is of another run: {difference}; give what it was begun with, or choose "
            "another path"
        )
