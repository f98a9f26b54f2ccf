"""Ctrl-C: held back while something is finished, and handed on to threads, which it never meets.

Python raises KeyboardInterrupt in the main thread alone, between two of its instructions. What a signal may not cut is
done under `interrupts_held_back`; what runs in another thread, or in long pieces of compiled code, is divided into
pieces between which `end_if_asked` is called.
"""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from contextvars import ContextVar

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
