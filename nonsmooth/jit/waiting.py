"""What is compiled says so, where it takes longer than a person waits without asking.

    nonsmooth: compiling 12 functions of moreau_jean (first use on this machine), about 20 s; kept in ~/.cache/nonsmooth

One line on stderr for what is compiled together, after SILENT_TIME seconds of it; what is read from disk, or compiled
sooner, says nothing, nor does anything under ``NONSMOOTH_QUIET=1``.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextvars import ContextVar

SILENT_TIME = 1.0  # chosen: s
_is_said: ContextVar[bool] = ContextVar("is_said", default=False)


@contextlib.contextmanager
def waiting(words: Callable[[], str]) -> Iterator[None]:
    """Say ``words()`` once on stderr where the block takes longer than SILENT_TIME; blocks within it say nothing."""
    if _is_said.get() or os.environ.get("NONSMOOTH_QUIET", "") not in ("", "0"):
        yield
        return
    token = _is_said.set(True)
    timer = threading.Timer(SILENT_TIME, lambda: print(words(), file=sys.stderr, flush=True))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        _is_said.reset(token)


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
    return f"nonsmooth: compiling {what} ({why}), about {max(1.0, seconds):.0f} s; {kept}"
