"""Ctrl-C: held back while something is finished, and handed on to threads, which it never meets.

Python raises KeyboardInterrupt in the main thread alone, between two of its instructions. What a signal may not cut is
done under `interrupts_held_back`; what runs in another thread, or in long pieces of compiled code, is divided into
pieces between which `end_if_asked` is called.
"""

from __future__ import annotations

import contextlib
import signal
import threading
import time
from collections.abc import Iterator
from contextvars import ContextVar

PIECE_TIME = 0.02  # s of compiled code between two looks
PIECE_GROWTH = 10.0  # chosen: of a piece, from one to the next
_stop: ContextVar[threading.Event | None] = ContextVar("stop", default=None)


@contextlib.contextmanager
def interrupts_held_back() -> Iterator[None]:
    """Let Ctrl-C wait until the block is done."""
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or before is None:
        yield  # signals go to the main thread, and a handler that is not Python's cannot be put back
        return
    received: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: received.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if received:
        signal.raise_signal(signal.SIGINT)


@contextlib.contextmanager
def ended_by(stop: threading.Event | None) -> Iterator[None]:
    """Let `end_if_asked` look at this event, in this thread."""
    token = _stop.set(stop)
    try:
        yield
    finally:
        _stop.reset(token)


def end_if_asked() -> None:
    """Raise KeyboardInterrupt where the event of this thread is set."""
    stop = _stop.get()
    if stop is not None and stop.is_set():
        raise KeyboardInterrupt


class Pieces:
    """Divides long calls into short ones, whose size is learnt from their time."""

    def __init__(self) -> None:
        self.size = 1

    def of(self, n: int) -> Iterator[slice]:
        """Consecutive pieces of a list of n; raises KeyboardInterrupt between two where that is asked."""
        first = 0
        while first < n:
            end_if_asked()
            began, piece = time.perf_counter(), slice(first, min(n, first + self.size))
            yield piece
            elapsed = max(time.perf_counter() - began, 1e-9)
            self.size = max(1, int((piece.stop - first) * min(PIECE_GROWTH, PIECE_TIME / elapsed)))
            first = piece.stop
