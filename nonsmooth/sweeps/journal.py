"""The journal of a sweep: append-only JSONL, so that nothing is lost when the program, or the machine, dies.

    {"journal": "nonsmooth sweep", "format": 1, "study": "<sha256>", "cells": 400, "about": {}, "crc32": "0123abcd"}
    {"cell": 17, "status": 1, "values": {"amplitude": [0.0123]}, "crc32": "4567cdef"}

A batch of many cells is written in blocks, a line each, its numbers as Base64 of their bytes (float64, little-endian):

    {"cells": [0, 1, 2, ...], "status": [1, 1, 1, ...],
     "columns": {"amplitude": {"shape": [1], "float64": "..."}}, "texts": {}, "messages": {}, "crc32": "89abcdef"}

The study is a hash of task, parameters, integrator, axes and version; a journal of another study is refused. Lines are
written a batch at a time in one call and handed to the operating system at once; a torn last line is cut off when the
journal is opened again. Numbers are written so that they read back to the same bits.

The checksum of a line is that of its text before it, and of the head: a line that is damaged, edited or from another
journal is named and nothing is run; a cell whose line is not there, for whatever reason, is run again.
"""

from __future__ import annotations

import base64
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

KIND, FORMAT = "nonsmooth sweep", 1  # code: of the form of the file
HEAD = b'{"journal": "nonsmooth sweep"'
LONGEST_HEAD = 2**20  # chosen: bytes; it holds the names of the axes
CHECKSUM = re.compile(rb', "crc32": "([0-9a-f]{8})"}\n')
N_CHECKSUM = 23  # derived: bytes of it
LINES_AT_ONCE = 4096  # chosen: lines read at a time
# chosen: cells of a batch that is written in blocks. A batch takes some 0.1 s; of fewer cells a line each adds nothing
# to that (9 us to write, 13 us to read) and shows numbers to whoever looks into the file
FEWEST_IN_BLOCK = 64
MOST_IN_BLOCK = 4096  # chosen: cells of a line, what one that is damaged costs: 0.3 MB for ten numbers a cell
BLOCK = b'{"cells": '
STORED_FLOAT = np.dtype("<f8")  # defined: of a column of a block
SYNC = 1.0  # chosen: s between two orders to put what was written on the disk


def study_of(task: Task, plan: Plan) -> str:
    """Hash of all that the results depend on.

    Raises
    ------
    Unidentified
        Where the task reads what cannot be distinguished from something else.
    """
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
        Go on with a journal that is there; False begins again, over it.

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
                f"the journal {str(self.path)!r} has format {shown(head.get('format'))}; this version reads {FORMAT}; "
                f"{cure}"
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
            for is_block, group in itertools.groupby(file, lambda line: line.startswith(BLOCK)):
                while lines := list(itertools.islice(group, 1 if is_block else LINES_AT_ONCE)):
                    entries = self._entries(lines, first)
                    yield self._block(entries[0], first) if is_block else self._batch(entries)
                    first += len(lines)

    def _entries(self, lines: list[bytes], first: int) -> list[dict[str, Any]]:
        for k, line in enumerate(lines, start=first):
            if not has_checksum(line, self._start):
                raise self._damage(k)
        return json.loads(b"[" + b",".join(lines) + b"]")

    def _damage(self, k: int) -> InvalidInput:
        return InvalidInput(
            f"line {k} of the journal {str(self.path)!r} is damaged; delete that line and its cells are computed again"
        )

    def _block(self, entry: dict[str, Any], k: int) -> tuple[np.ndarray, Batch]:
        """The cells of a block, line k."""
        try:
            cells, status = np.array(entry["cells"], np.int64), np.array(entry["status"], np.int64)
            N = len(cells)
            columns = {name: array_of_bytes(column, N) for name, column in entry["columns"].items()}
            columns |= {name: np.array(texts, dtype=object).reshape(N) for name, texts in entry["texts"].items()}
            return cells, Batch(columns, status.reshape(N), {int(i): text for i, text in entry["messages"].items()})
        except (KeyError, TypeError, ValueError):
            raise self._damage(k) from None

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
        lines = cell_lines(cells, batch) if len(cells) < FEWEST_IN_BLOCK else block_lines(cells, batch)
        self._file.write(b"".join([with_checksum(line, self._start) for line in lines]))
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


def cell_lines(cells: np.ndarray, batch: Batch) -> Iterator[str]:
    """A line a cell."""
    columns = {json.dumps(name): as_json(values) for name, values in batch.values.items()}
    for k, (cell, status) in enumerate(zip(cells.tolist(), batch.status.tolist(), strict=True)):
        values = ", ".join([f"{name}: {column[k]}" for name, column in columns.items()])
        message = f', "message": {json.dumps(batch.messages[k])}' if k in batch.messages else ""
        yield f'{{"cell": {cell}, "status": {status}, "values": {{{values}}}{message}}}'


def block_lines(cells: np.ndarray, batch: Batch) -> Iterator[str]:
    """A line a block."""
    for first in range(0, len(cells), MOST_IN_BLOCK):
        part = slice(first, first + MOST_IN_BLOCK)
        columns = {name: values[part] for name, values in batch.values.items()}
        texts = {name: values.tolist() for name, values in columns.items() if values.dtype == object}
        messages = {k - first: text for k, text in batch.messages.items() if first <= k < first + MOST_IN_BLOCK}
        yield json.dumps({
            "cells": cells[part].tolist(), "status": batch.status[part].tolist(),
            "columns": {name: as_bytes(values) for name, values in columns.items() if name not in texts},
            "texts": texts, "messages": messages,
        })  # fmt: skip


def as_bytes(values: np.ndarray) -> dict[str, Any]:
    """The results (N, ...) of N cells: their further shape and their bytes."""
    stored = base64.b64encode(np.ascontiguousarray(values, dtype=STORED_FLOAT).tobytes())
    return {"shape": values.shape[1:], "float64": stored.decode("ascii")}


def array_of_bytes(column: dict[str, Any], N: int) -> np.ndarray:
    """The results (N, ...) that `as_bytes` wrote; ValueError where they are not so many."""
    numbers = np.frombuffer(base64.b64decode(column["float64"], validate=True), dtype=STORED_FLOAT)
    return numbers.astype(np.float64).reshape(N, *column["shape"])


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
