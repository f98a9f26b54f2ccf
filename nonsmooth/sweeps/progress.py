"""How far a study is: a bar on a terminal or in a notebook, nothing in a pipe, or one line of JSON a second.

What will take more than a minute is announced before, wherever it is shown:

    remaining = elapsed (work left)/(work done),    work: expected seconds of the cells, or their number

The part of the present cell that is done comes from the loops that report it (nonsmooth/signals/telling.py).
"""

from __future__ import annotations

import contextlib
import json
import math
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from typing import Any, Self, TextIO

import numpy as np

from nonsmooth.checks.arrays import result_of
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.signals.bar import BAR_PERIOD, Bar, bar_of
from nonsmooth.signals.pace import EVIDENCE_TIME, Pace, duration
from nonsmooth.signals.telling import listening

JSON_PERIOD = 1.0  # chosen: s between two lines of JSON
ANNOUNCED_TIME = 60.0  # chosen: s: what takes longer is said before it starts
CLEARED = "\r\033[K"  # the line of a bar


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
        [s]; remaining is NaN before anything is known.
    rate : float
        Cells a second since this start.
    present : float
        Part of the present cells that is done, where it is known.
    """

    done: int
    total: int
    failed: int
    elapsed: float
    rate: float
    remaining: float
    present: float = 0.0

    @property
    def part(self) -> float:
        """Of the cells, that are done."""
        return self.done / max(self.total, 1)

    def __str__(self) -> str:
        left = f"{duration(self.remaining)} left" if math.isfinite(self.remaining) else "..."
        failed = f", {self.failed} failed" if self.failed else ""
        present = f", the present one {self.present:.0%}" if self.present > 0 else ""
        rate = f", {self.rate:.3g}/s" if self.rate > 0 else ""
        return f"{self.done}/{self.total} cells ({self.part:.0%}){present}{rate}, {left}{failed}"


class Progress:
    """Counts cells and shows them.

    Parameters
    ----------
    show : bool, "json" or callable
        True: a bar on a terminal or in a notebook, elsewhere the estimate alone; "json": a line of JSON each
        second on stderr; a callable gets each `Snapshot`.
    total, done : int
        Cells of the sweep, and those that the journal had.
    costs : ndarray (total,), optional
        Expected seconds of each cell.
    at_once : int
        Cells that run at a time.
    """

    def __init__(
        self, show: Any, total: int, done: int, stream: TextIO | None = None, costs: np.ndarray | None = None,
        at_once: int = 1,
    ) -> None:  # fmt: skip
        self.stream = sys.stderr if stream is None else stream
        self.is_json = isinstance(show, str) and show == "json"
        self.is_line = show is True
        self.bar = Bar(self.stream)
        self.write = self._writer(show)
        self.period = JSON_PERIOD if self.is_json else BAR_PERIOD
        self.total, self.done, self.failed, self._before = total, done, 0, done
        self.costs, self.at_once = costs, at_once
        self._seconds = 0.0  # that were expected of the cells that are done
        self._begun, self._present = 0.0, 0.0  # work of the present cells, and the part of it that is done
        self._is_announced = False
        self._started = self._shown = self._since = self._heard = time.perf_counter()
        self._is_known = False  # whether any work was heard of: what came before was compiling

    def _writer(self, show: Any) -> Callable[[Snapshot], None] | None:
        if callable(show):
            return show
        if self.is_json:
            return lambda snapshot: print(json.dumps(as_json(snapshot)), file=self.stream, flush=True)
        if show is True:
            return self._write_bar if self.bar.is_seen else None
        if show is False or show is None:
            return None
        raise InvalidInput(f"progress must be True, False, 'json' or a function; got {shown(show)}")

    def _write_bar(self, snapshot: Snapshot) -> None:
        self.bar.show(snapshot.part, str(snapshot))

    def begin(self, cells: np.ndarray) -> None:
        """These cells are run now, in this thread."""
        self._begun, self._present = self._work(cells), 0.0

    def finish(self, cells: np.ndarray, failed: int, elapsed: float) -> None:
        """These cells are done, and took so many seconds."""
        self._seconds += self._work(cells)
        self.add(len(cells), failed, elapsed)

    def add(self, done: int, failed: int, elapsed: float = math.inf) -> None:
        """Count some cells, and show it when the last time is long enough ago."""
        self.done += done
        self.failed += failed
        self._begun, self._present = 0.0, 0.0
        if not self._is_known:
            self._is_known, self._heard = True, time.perf_counter()
            self._since = max(self._since, self._heard - elapsed)
        self._look()

    def hear(self, part: float) -> None:
        """So much of the present cells, or of one of their runs, is done."""
        if not self._is_known:
            self._is_known, self._since = True, time.perf_counter()
            self._heard = self._since
        self._present = part
        self._look()

    def _work(self, cells: np.ndarray) -> float:
        """Their number, or the seconds that are expected of them."""
        return float(len(cells)) if self.costs is None else float(self.costs[cells].sum())

    def _look(self) -> None:
        now = time.perf_counter()
        is_evident = now - self._heard >= EVIDENCE_TIME  # the first cells may have waited for their compiling
        if not self._is_announced and self.costs is None and is_evident:
            self._announce(self.snapshot().remaining)
        if now - self._shown >= self.period:
            self.show()

    def _announce(self, seconds: float) -> None:
        """Say what will take more than a minute."""
        if not seconds > ANNOUNCED_TIME or self._is_announced:
            return
        self._is_announced = True
        if self.is_json:
            print(json.dumps({"estimate": seconds}), file=self.stream, flush=True)
        elif self.is_line:
            say_estimate(f"{self.total - self.done} cells", seconds, self.stream)

    def show(self) -> None:
        """Show the state now."""
        self._shown = time.perf_counter()
        if self.write is not None:
            result_of("the progress function", self.write, self.snapshot())

    def __enter__(self) -> Self:
        self._listening = listening(self.hear if self.write is not None or self.is_line else None)
        self._listening.__enter__()
        self._announce(self.snapshot().remaining)
        return self

    def __exit__(self, *_: Any) -> None:
        self._listening.__exit__(None, None, None)
        self.close()

    def close(self) -> None:
        """Show the end, and clear the line."""
        if self.write is not None:
            self._present = 0.0
            self.show()
        self.bar.close()

    def snapshot(self) -> Snapshot:
        """The state now."""
        elapsed = time.perf_counter() - self._started
        rate = (self.done - self._before) / elapsed if elapsed > 0 else 0.0
        remaining = self._remaining(self._started + elapsed - self._since)
        return Snapshot(self.done, self.total, self.failed, elapsed, rate, remaining, self._present)

    def _remaining(self, elapsed: float) -> float:
        """Seconds for what is left, from what the work so far took; at first from what was expected."""
        done, left = float(self.done - self._before), float(self.total - self.done)
        present = self._begun * self._present
        if self.costs is not None:
            done, left = self._seconds, float(self.costs.sum()) - self._seconds
        if done + present > (0.0 if self.costs is None else EVIDENCE_TIME):
            return (left - present) * elapsed / (done + present)
        return left / self.at_once if self.costs is not None else math.nan


@contextlib.contextmanager
def part_shown(what: str, show: Any, stream: TextIO | None = None) -> Iterator[None]:
    """A bar for a calculation that reports its progress, where somebody sees it and ``show`` is True."""
    if show is not True:
        yield
        return
    pace, is_announced = Pace(), False

    def hear(part: float) -> None:
        nonlocal is_announced
        left = pace.left(part, time.perf_counter())
        if not is_announced and left > ANNOUNCED_TIME:
            is_announced = True
            say_estimate(what, left, sys.stderr if stream is None else stream)
        grow(part)

    with bar_of(what, stream) as grow, listening(hear):
        yield


def say_estimate(what: str, seconds: float, stream: TextIO) -> None:
    """A line that stays."""
    clear = CLEARED if stream.isatty() else ""
    print(f"{clear}nonsmooth: {what} will take about {duration(seconds)}; Ctrl-C keeps what is finished", file=stream)
    stream.flush()


def as_json(snapshot: Snapshot) -> dict[str, Any]:
    """The snapshot without NaN, which JSON does not know."""
    return {name: None if value != value else value for name, value in asdict(snapshot).items()}
