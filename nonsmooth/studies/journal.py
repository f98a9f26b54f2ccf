"""The journal of a sweep: append-only JSONL, so that nothing is lost when the program, or the machine, dies.

    {"journal": "nonsmooth sweep", "format": 1, "study": "<sha256>", "cells": 40000, "about": {...}}
    {"cell": 17, "status": 1, "values": {"amplitude": [0.0123]}}

The study is a hash of task, parameters, integrator, axes and version; a journal of another study is refused. Lines are
written a batch at a time in one call and handed to the operating system at once; a torn last line is cut off when the
journal is opened again. Numbers are written so that they read back to the same bits.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Self

import numpy as np

from nonsmooth import __version__
from nonsmooth.errors import InvalidInput
from nonsmooth.studies.axes import Plan
from nonsmooth.studies.task import Batch, Task

KIND, FORMAT = "nonsmooth sweep", 1
HEAD = b'{"journal": "nonsmooth sweep"'
ENTRY = {"cell", "status", "values"}
CHUNK = 4096  # lines read at a time
SYNC = 1.0  # s between two orders to put what was written on the disk


def study_of(task: Task, plan: Plan) -> str:
    """Hash of all that the results depend on."""
    digest = hashlib.sha256(f"{__version__}\n{type(task).__qualname__}\n{task.identity()}\n".encode())
    for axis in plan.axes:
        digest.update(f"{axis.name}\n{plan.is_table}\n{axis.values.dtype.kind}\n".encode())
        digest.update(repr(axis.values.tolist()).encode())
    return digest.hexdigest()


class Journal:
    """An open journal.

    Parameters
    ----------
    path : path-like
    study : str
        What `study_of` gave.
    plan : Plan
    resume : bool
        Go on with a journal that is there; False begins anew, over it.

    Raises
    ------
    InvalidInput
        When the file is no journal, belongs to another study, is damaged inside, or cannot be written.
    """

    def __init__(self, path: str | os.PathLike[str], study: str, plan: Plan, resume: bool) -> None:
        self.path, self.study, self.plan = Path(path), study, plan
        try:
            is_there = resume and self.path.exists() and self._check_and_mend()
            self._file = open(self.path, "ab" if is_there else "wb", buffering=0)
        except OSError as error:
            raise InvalidInput(
                f"the journal {str(self.path)!r} cannot be used: {error.strerror}; choose another path"
            ) from None
        if not is_there:
            about = {"axes": {axis.name: len(axis.values) for axis in plan.axes}, "version": __version__}
            head = {"journal": KIND, "format": FORMAT, "study": study, "cells": len(plan), "about": about}
            self._file.write(json.dumps(head).encode() + b"\n")
        self._synced = time.monotonic()

    def _check_and_mend(self) -> bool:
        """Refuse what is not this study's journal; cut a torn last line off. False where not even the head is whole."""
        with open(self.path, "rb") as file:
            line = file.readline()
            if not line or (line.startswith(HEAD) and not line.endswith(b"\n")):
                return False
            head = _parse(line)
            if head is None or head.get("journal") != KIND:
                raise InvalidInput(f"{str(self.path)!r} is no journal of a sweep; choose another path")
            if head.get("format") != FORMAT or head.get("study") != self.study:
                raise InvalidInput(
                    f"the journal {str(self.path)!r} belongs to another study (model, parameters, axes, integrator, "
                    "measures or version differ); choose another path, or resume=False to write over it"
                )
            file.seek(0, os.SEEK_END)
            end = size = file.tell()
            while end > 0:  # back to the end of the last whole line
                start = max(0, end - 65536)
                file.seek(start)
                place = file.read(end - start).rfind(b"\n")
                if place >= 0:
                    end = start + place + 1
                    break
                end = start
        if end < size:
            os.truncate(self.path, end)
        return True

    def read(self) -> Iterator[tuple[np.ndarray, Batch]]:
        """The finished cells, some at a time: their numbers and results."""
        with open(self.path, "rb") as file:
            next(file)
            first = 2
            while lines := list(itertools.islice(file, CHUNK)):
                yield self._batch(self._entries(lines, first))
                first += len(lines)

    def _entries(self, lines: list[bytes], first: int) -> list[dict[str, Any]]:
        try:
            entries = json.loads(b"[" + b",".join(lines) + b"]")
        except ValueError:
            entries = [_parse(line) for line in lines]
        N = len(self.plan)
        for k, entry in enumerate(entries, start=first):
            if not isinstance(entry, dict) or not entry.keys() >= ENTRY or not 0 <= entry["cell"] < N:
                raise InvalidInput(
                    f"line {k} of the journal {str(self.path)!r} is damaged; delete that line and its cell is computed "
                    "again"
                )
        return entries

    def _batch(self, entries: list[dict[str, Any]]) -> tuple[np.ndarray, Batch]:
        batch = Batch({}, np.array([entry["status"] for entry in entries]))
        batch.messages = {k: entry["message"] for k, entry in enumerate(entries) if "message" in entry}
        values = [entry["values"] for entry in entries]
        for name in dict.fromkeys(itertools.chain.from_iterable(values)):
            rows = [k for k, row in enumerate(values) if name in row]
            batch.put(name, np.array(rows), as_array([values[k][name] for k in rows]))
        return np.array([entry["cell"] for entry in entries]), batch

    def write(self, cells: np.ndarray, batch: Batch) -> None:
        """Append the cells of a batch."""
        columns = {json.dumps(name): as_json(values) for name, values in batch.values.items()}
        lines = []
        for k, (cell, status) in enumerate(zip(cells.tolist(), batch.status.tolist(), strict=True)):
            values = ", ".join([f"{name}: {column[k]}" for name, column in columns.items()])
            message = f', "message": {json.dumps(batch.messages[k])}' if k in batch.messages else ""
            lines.append(f'{{"cell": {cell}, "status": {status}, "values": {{{values}}}{message}}}\n')
        self._file.write("".join(lines).encode())
        if time.monotonic() - self._synced > SYNC:
            os.fsync(self._file.fileno())
            self._synced = time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def close(self) -> None:
        """Put everything on the disk."""
        os.fsync(self._file.fileno())
        self._file.close()


def _parse(line: bytes) -> dict[str, Any] | None:
    try:
        entry = json.loads(line)
    except ValueError:
        return None
    return entry if isinstance(entry, dict) else None


def as_json(values: np.ndarray) -> list[str]:
    """Each of N results as JSON, which knows neither NaN nor inf: {"float": "nan"} stands for NaN."""
    if values.dtype == object:
        return [json.dumps(text) for text in values]
    is_finite = np.isfinite(values).reshape(len(values), -1).all(axis=1)
    return [
        repr(value) if finite else json.dumps(_marked(value))
        for value, finite in zip(values.tolist(), is_finite.tolist(), strict=True)
    ]


def _marked(value: Any) -> Any:
    if isinstance(value, list):
        return [_marked(part) for part in value]
    return value if math.isfinite(value) else {"float": repr(value)}


def as_array(values: list[Any]) -> np.ndarray:
    """The results of some cells as `as_json` wrote them."""
    if isinstance(values[0], str):
        return np.array(values, dtype=object)
    try:
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        return np.array([_unmarked(value) for value in values], dtype=np.float64)


def _unmarked(value: Any) -> Any:
    if isinstance(value, list):
        return [_unmarked(part) for part in value]
    return float(value["float"]) if isinstance(value, dict) else value
