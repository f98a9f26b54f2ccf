"""Compilations in threads while a run goes on with the code that it has, until they are done.

The loops of a run hold no lock of the interpreter, so that a thread compiles meanwhile where a processor is free.
Nobody waits for it: at the end of the process, and before it is forked while a thread has numba's lock, it is given up
between two of the functions that it compiles.
"""

from __future__ import annotations

import atexit
import os
import threading
from collections.abc import Callable

_threads: list[threading.Thread] = []
_is_ending = threading.Event()


class GivenUp(BaseException):
    """A compilation that nobody needs any more."""


def begin(work: Callable[[], None]) -> None:
    """Do some work in a thread of its own."""

    def quietly() -> None:
        try:
            work()
        except GivenUp:
            pass

    thread = threading.Thread(target=quietly, daemon=True)
    _threads.append(thread)
    thread.start()


def go_on() -> None:
    """Raise `GivenUp` in such a thread if it is to end; asked before each function that is compiled."""
    if _is_ending.is_set() and threading.current_thread() in _threads:
        raise GivenUp


def finish() -> None:
    """End the threads."""
    _is_ending.set()
    for thread in _threads:
        thread.join()
    _threads.clear()
    _is_ending.clear()


def has_free_processor() -> bool:
    """Whether a processor is free for another thread, as far as the system says."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    busy = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    return count > 1 and busy <= count - 1


atexit.register(finish)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=finish)
