"""The journal of a sweep: append-only JSONL, so that nothing is lost when the program, or the machine, dies.

    {"journal": "nonsmooth sweep", "format": 2, "study": "<sha256>", "cells": 400, "about": {}, "crc32": "0123abcd"}
    {"cell": 17, "status": 1, "values": {"amplitude": [0.0123]}, "crc32": "4567cdef"}

The study is a hash of task, parameters, integrator, axes and version; a journal of another study is refused. Lines are
written a batch at a time in one call and handed to the operating system at once; a torn last line is cut off when the
journal is opened again. Numbers are written so that they read back to the same bits.

The checksum of a line is that of its text before it, and of the head: a line that is damaged, edited or from another
journal is named and nothing is run; a cell whose line is not there, for whatever reason, is run again.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import os
import re
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, Self

import numpy as np

from nonsmooth import __version__
from nonsmooth.checks.files import open_to_read
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.sweeps.axes import Plan
from nonsmooth.sweeps.task import Batch, Task

KIND, FORMAT = "nonsmooth sweep", 2  # code: of the form of the file
HEAD = b'{"journal": "nonsmooth sweep"'
LONGEST_HEAD = 2**20  # chosen: bytes; it holds the names of the axes
CHECKSUM = re.compile(rb', "crc32": "([0-9a-f]{8})"}\n')
N_CHECKSUM = 23  # derived: bytes of it
LINES_AT_ONCE = 4096  # chosen: lines read at a time
SYNC = 1.0  # chosen: s between two orders to put what was written on the disk


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
        about = {"axes": {axis.name: len(axis.values) for axis in plan.axes}, "version": __version__}
        head = {"journal": KIND, "format": FORMAT, "study": study, "cells": len(plan), "about": about}
        self._head = with_checksum(json.dumps(head), 0)
        self._start = zlib.crc32(self._head)  # of the checksum of each line
        try:
            is_there = resume and self.path.exists() and self._check_and_mend()
            self._file = open(self.path, "ab" if is_there else "wb", buffering=0)
        except OSError as error:
            raise InvalidInput(
                f"the journal {str(self.path)!r} cannot be used: {error.strerror}; choose another path"
            ) from None
        if not is_there:
            self._file.write(self._head)
        self._synced = time.monotonic()

    def _check_and_mend(self) -> bool:
        """Refuse what is not this study's journal; cut a torn last line off. False where not even the head is whole."""
        with self._opened() as file:
            line = file.readline(LONGEST_HEAD)
            end = size = file.seek(0, os.SEEK_END)
            if not line or (line.startswith(HEAD) and not line.endswith(b"\n") and len(line) == size):
                return False
            self._require_head(line)
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

    def _opened(self) -> BinaryIO:
        try:
            return open_to_read(self.path)
        except ValueError as error:
            raise InvalidInput(f"the journal {str(self.path)!r} cannot be used: {error}; choose another path") from None

    def _require_head(self, line: bytes) -> None:
        """Raise unless a journal begins with the head of this study."""
        if line == self._head:
            return
        head = _parse(line)
        if head is None or head.get("journal") != KIND:
            raise InvalidInput(f"{str(self.path)!r} is no journal of a sweep; choose another path")
        cure = "choose another path, or resume=False to write over it"
        if head.get("format") == FORMAT and not has_checksum(line, 0):
            raise InvalidInput(f"the first line of the journal {str(self.path)!r} is damaged; {cure}")
        if head.get("format") != FORMAT:
            raise InvalidInput(
                f"the journal {str(self.path)!r} has format {shown(head.get('format'))}; this version reads {FORMAT}, "
                f"whose lines have checksums; {cure}"
            )
        raise InvalidInput(
            f"the journal {str(self.path)!r} belongs to another study (model, parameters, axes, integrator, measures "
            f"or version differ); {cure}"
        )

    def read(self) -> Iterator[tuple[np.ndarray, Batch]]:
        """The finished cells, some at a time: their numbers and results."""
        with self._opened() as file:
            file.readline()
            first = 2
            while lines := list(itertools.islice(file, LINES_AT_ONCE)):
                yield self._batch(self._entries(lines, first))
                first += len(lines)

    def _entries(self, lines: list[bytes], first: int) -> list[dict[str, Any]]:
        for k, line in enumerate(lines, start=first):
            if not has_checksum(line, self._start):
                raise InvalidInput(
                    f"line {k} of the journal {str(self.path)!r} is damaged; delete that line and its cell is computed "
                    "again"
                )
        return json.loads(b"[" + b",".join(lines) + b"]")

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
            line = f'{{"cell": {cell}, "status": {status}, "values": {{{values}}}{message}}}'
            lines.append(with_checksum(line, self._start))
        self._file.write(b"".join(lines))
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


def with_checksum(line: str, start: int) -> bytes:
    """A line of JSON, {...}, with the checksum of its text as its last entry."""
    text = line[:-1].encode()
    return b'%b, "crc32": "%08x"}\n' % (text, zlib.crc32(text, start))


def has_checksum(line: bytes, start: int) -> bool:
    """Whether a line ends with the checksum of what stands before it."""
    found = CHECKSUM.fullmatch(line, len(line) - N_CHECKSUM) if len(line) > N_CHECKSUM else None
    return found is not None and int(found[1], 16) == zlib.crc32(line[:-N_CHECKSUM], start)


def _parse(line: bytes) -> dict[str, Any] | None:
    try:
        entry = json.loads(line)
    except (ValueError, RecursionError):
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
