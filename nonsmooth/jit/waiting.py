"""What is compiled says so, where it takes longer than a person waits without asking.

    nonsmooth: compiling 12 functions of moreau_jean (first use on this machine), about 20 s; kept in ~/.cache/nonsmooth
    14 s

One line on stderr for what is compiled together, after SILENT_TIME seconds of it, and in a terminal the seconds that
have gone by, which move until it is there; what is read from disk, or compiled sooner, says nothing, nor does anything
under ``NONSMOOTH_QUIET=1``. The time that is said takes the load of the machine into account: of n processes that would
run on c processors each has c/n of its time.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextvars import ContextVar

SILENT_TIME = 1.0  # chosen: s
CROWDED = 1.25  # chosen: times as long as alone: less is not worth a word
# measured: 1.2 to 2.3 times as long at loads of 4 to 8 on two virtual cores: whoever shares them slows each of them too
SHARED_CORES = 2.0
TICK = 1.0  # chosen: s between two looks at the clock that a person sees
ERASED = "\r\x1b[K"  # defined: ECMA-48, erase in line
_is_said: ContextVar[bool] = ContextVar("is_said", default=False)


@contextlib.contextmanager
def waiting(words: Callable[[], str]) -> Iterator[None]:
    """Say ``words()`` once on stderr where the block takes longer than SILENT_TIME; blocks within it say nothing."""
    if _is_said.get() or os.environ.get("NONSMOOTH_QUIET", "") not in ("", "0"):
        yield
        return
    token, is_over = _is_said.set(True), threading.Event()
    thread = threading.Thread(target=tell_until, args=(is_over, words), daemon=True)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()
        _is_said.reset(token)


def tell_until(is_over: threading.Event, words: Callable[[], str]) -> None:
    """Say the words after a while, and in a terminal how long it has taken, until it is over."""
    began = time.perf_counter()
    if is_over.wait(SILENT_TIME):
        return
    print(words(), file=sys.stderr, flush=True)
    if not sys.stderr.isatty():
        return
    while not is_over.wait(TICK):
        print(f"{ERASED}{time.perf_counter() - began:.0f} s", end="", file=sys.stderr, flush=True)
    print(ERASED, end="", file=sys.stderr, flush=True)


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Say nothing of what is compiled in the block: nobody waits for it."""
    token = _is_said.set(True)
    try:
        yield
    finally:
        _is_said.reset(token)


def sentence(what: str, why: str, seconds: float, folder: object) -> str:
    """What is compiled, why, for about how long, and where it is kept; ``folder`` None where nothing can be kept."""
    kept = f"kept in {folder}" if folder is not None else "kept nowhere: the cache directory cannot be used"
    busy = crowding()
    least = max(1.0, busy * seconds)
    if busy > CROWDED:
        lasts = f"{least:.0f} to {SHARED_CORES * least:.0f} s ({max(1.0, seconds):.0f} s if nothing else ran)"
    else:
        lasts = f"{least:.0f} s"
    return f"nonsmooth: compiling {what} ({why}), about {lasts}; {kept}"


def crowding() -> float:
    """How many times as long something takes as on a machine that does nothing else; 1 where nobody knows."""
    try:
        running = os.getloadavg()[0]
    except (AttributeError, OSError):
        return 1.0
    return max(1.0, (running + 1.0) / (os.cpu_count() or 1))
