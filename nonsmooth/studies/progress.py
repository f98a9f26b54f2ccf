"""How far a sweep is: a line on a terminal, nothing in a pipe, or one line of JSON a second."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Self, TextIO

from nonsmooth.arrays import result_of
from nonsmooth.errors import InvalidInput, shown

PERIOD = {"line": 0.2, "json": 1.0}  # s between two lines


@dataclass(frozen=True)
class Snapshot:
    """State of a sweep.

    Attributes
    ----------
    done, total : int
        Cells, those taken from the journal among them.
    failed : int
        Cells whose status is not FINISHED.
    elapsed, remaining : float
        [s]; remaining is NaN before the first cell.
    rate : float
        Cells a second since this start.
    """

    done: int
    total: int
    failed: int
    elapsed: float
    rate: float
    remaining: float

    def __str__(self) -> str:
        left = f"{duration(self.remaining)} left" if self.rate > 0 else "..."
        failed = f", {self.failed} failed" if self.failed else ""
        part = self.done / max(self.total, 1)
        return f"{self.done}/{self.total} cells ({part:.0%}), {self.rate:.3g}/s, {left}{failed}"


class Progress:
    """Counts cells and shows them.

    Parameters
    ----------
    show : bool, "json" or callable
        True: a line on a terminal, nothing elsewhere; "json": a line of JSON each second on stderr; a callable gets
        each `Snapshot`.
    total, done : int
        Cells of the sweep, and those that the journal had.
    """

    def __init__(self, show: Any, total: int, done: int, stream: TextIO | None = None) -> None:
        self.stream = sys.stderr if stream is None else stream
        self.write = self._writer(show)
        self.period = PERIOD["json" if isinstance(show, str) else "line"]
        self.total, self.done, self.failed, self._before = total, done, 0, done
        self._started = self._shown = time.perf_counter()

    def _writer(self, show: Any) -> Callable[[Snapshot], None] | None:
        if callable(show):
            return show
        if isinstance(show, str) and show == "json":
            return lambda snapshot: print(json.dumps(as_json(snapshot)), file=self.stream, flush=True)
        if show is True:
            return self._write_line if self.stream.isatty() else None
        if show is False or show is None:
            return None
        raise InvalidInput(f"progress must be True, False, 'json' or a function; got {shown(show)}")

    def _write_line(self, snapshot: Snapshot) -> None:
        print(f"\r\033[K{snapshot}", end="", file=self.stream, flush=True)

    def add(self, done: int, failed: int) -> None:
        """Count some cells, and show it when the last time is long enough ago."""
        self.done += done
        self.failed += failed
        if time.perf_counter() - self._shown >= self.period:
            self.show()

    def show(self) -> None:
        """Show the state now."""
        self._shown = time.perf_counter()
        if self.write is not None:
            result_of("the progress function", self.write, self.snapshot())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def close(self) -> None:
        """Show the end, and clear the line."""
        if self.write is not None:
            self.show()
            if self.write == self._write_line:
                print("\r\033[K", end="", file=self.stream, flush=True)

    def snapshot(self) -> Snapshot:
        """The state now."""
        elapsed = time.perf_counter() - self._started
        rate = (self.done - self._before) / elapsed if elapsed > 0 else 0.0
        remaining = (self.total - self.done) / rate if rate > 0 else float("nan")
        return Snapshot(self.done, self.total, self.failed, elapsed, rate, remaining)


def as_json(snapshot: Snapshot) -> dict[str, Any]:
    """The snapshot without NaN, which JSON does not know."""
    return {name: None if value != value else value for name, value in asdict(snapshot).items()}


def duration(seconds: float) -> str:
    """A time as a person would say it."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
