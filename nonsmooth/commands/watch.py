"""Ctrl-C ends a command within half a second, whatever its main thread does.

Python raises KeyboardInterrupt between two instructions of the main thread. Compiled loops come back for it some fifty
times a second; the optimiser of a compilation, a single large solve and a library's import may not for seconds. So a
thread hears of the signal too, at once, by the file descriptor that Python's own handler writes to. Where the main
thread has not heard after `COMPILER_PATIENCE`, it says what is finished and ends the process; where it has, it is left
to keep what is finished in its own time.

Nothing is raised within a compilation, whose halves LLVM does not survive: the process ends there and then. And what is
raised in a function that C has called, as a finaliser, goes nowhere, Python reports it as ignored: it is sent again
until it is raised where it counts.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

from nonsmooth.commands.terminal import complain
from nonsmooth.errors import INTERRUPTED, NonsmoothError

COMPILER_PATIENCE = 0.35  # chosen: s; ending the process takes a few hundredths more
COMPILER = ("numba", "llvmlite")
AGAIN = 0.01  # chosen: s until a signal that went nowhere is sent again
_last_words: list[Callable[[], str]] = []


@contextlib.contextmanager
def ended_by_ctrl_c() -> Iterator[None]:
    """End the process soon after Ctrl-C, from another thread than the main one if need be.

    Only a program of its own is watched: in another thread, under another handler or in an interactive session Ctrl-C
    is what it was.
    """
    is_ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler and not hasattr(sys, "ps1")
    if threading.current_thread() is not threading.main_thread() or not is_ours:
        yield
        return
    heard = threading.Event()

    def hear(number: int, frame: FrameType | None) -> Any:
        if is_compiling(frame):
            _end()
        heard.set()
        signal.default_int_handler(number, frame)

    reader, writer = os.pipe()
    report = sys.unraisablehook
    os.set_blocking(writer, False)
    signal.signal(signal.SIGINT, hear)
    before = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=(reader, heard), daemon=True).start()
    sys.unraisablehook = lambda ignored: _send_anew(heard) if _is_ctrl_c(ignored, heard) else report(ignored)
    try:
        yield
    except NonsmoothError:
        raise
    except Exception:
        if not heard.is_set():
            raise
        raise KeyboardInterrupt from None  # what Ctrl-C broke may end otherwise, as a compilation does
    finally:
        sys.unraisablehook = report
        signal.set_wakeup_fd(before)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        os.close(writer)  # ends the thread


@contextlib.contextmanager
def last_words(say: Callable[[], str]) -> Iterator[None]:
    """What is printed if the process must be ended within the block: what is finished by then."""
    _last_words.append(say)
    try:
        yield
    finally:
        _last_words.pop()


def is_compiling(frame: FrameType | None) -> bool:
    """Whether a frame, or one that has called it, belongs to the compiler; compiled code has no frames."""
    while frame is not None:
        if frame.f_globals.get("__name__", "").partition(".")[0] in COMPILER:
            return True
        frame = frame.f_back
    return False


def _is_ctrl_c(ignored: Any, heard: threading.Event) -> bool:
    """Whether what Python ignores is the exception of a signal."""
    return heard.is_set() and issubclass(ignored.exc_type, KeyboardInterrupt)


def _send_anew(heard: threading.Event) -> None:
    """Once more, when what was called from C has returned."""
    heard.clear()
    threading.Timer(AGAIN, os.kill, (os.getpid(), signal.SIGINT)).start()


def _watch(reader: int, heard: threading.Event) -> None:
    """Wait for the signal, and for the main thread to hear of it; the first signal sets the time."""
    while numbers := os.read(reader, 64):
        if signal.SIGINT in numbers:
            time.sleep(COMPILER_PATIENCE)
            if not heard.is_set():
                _end()
    os.close(reader)


def _end() -> None:
    """End the process and those that it has started."""
    with contextlib.suppress(Exception):
        for say in _last_words:
            print(say())
    with contextlib.suppress(Exception):
        complain("interrupted")
        sys.stdout.flush()
    from multiprocessing import active_children

    for child in active_children():
        child.kill()
    os._exit(INTERRUPTED)
