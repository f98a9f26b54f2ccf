"""Entry points that few runs reach, compiled or read from disk when they are first called.

    address = slot
    if address is 0:  fetch(slot)         Python loads the entry point, which fills the slot; the run waits
    call what stands in the slot          as any other entry point

The call is made where the loop has come to, so all bits of the run are those with everything loaded before it. Threads
that reach one at once wait for the first of them. Ctrl-C waits until it is loaded and is then handed on, so that the
loop stops between two steps, as ever. One that cannot be loaded ends the loop by `NotLoaded`: every call from one entry
point into another hands an exception on. The clock of a run stands still meanwhile (`running_time`), as it does
wherever something is compiled.
"""

from __future__ import annotations

import contextlib
import ctypes
import signal
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from nonsmooth.errors import NonsmoothError, said_by

FETCH_SYMBOL = "nonsmooth.fetch"  # defined: the linker's name of `fetch`
NOT_FETCHED, FETCHED, FETCHED_INTERRUPTED = range(3)  # code: what `fetch` returns

_lock = threading.RLock()
_loaders: dict[int, tuple[str, Callable[[], None]]] = {}  # by the address of the slot: name, and what fills it


class OfThread(threading.local):
    """What a thread knows of its own waiting."""

    waited = 0.0  # [s]
    reason = ""  # why the last one could not be loaded


_of_thread = OfThread()


class NotLoaded(NonsmoothError, RuntimeError):
    """An entry point that a loop has come to could not be loaded; numba makes it, without arguments."""

    def __init__(self) -> None:
        super().__init__(_of_thread.reason)


@ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_size_t)
def fetch(slot: int) -> int:
    """Load the entry point of a slot; called by machine code, to which no exception can pass."""
    name, load = _loaders[slot]
    try:
        with stopped_clock(), interrupts_counted() as interrupts, _lock:
            load()
        return FETCHED_INTERRUPTED if interrupts else FETCHED
    except BaseException as reason:
        _of_thread.reason = f"the run has come to {name}, which cannot be compiled or loaded: {said_by(reason)}"
        return NOT_FETCHED


@contextlib.contextmanager
def interrupts_counted() -> Iterator[list[int]]:
    """Note what Ctrl-C sends instead of raising it: Python does so in the main thread alone."""
    numbers: list[int] = []
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or before is None:
        yield numbers
        return
    signal.signal(signal.SIGINT, lambda number, _: numbers.append(number))
    try:
        yield numbers
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def stopped_clock() -> Iterator[None]:
    """Stop the clock of a run: what is done in here is no part of it."""
    before, began = waited(), time.perf_counter()
    try:
        yield
    finally:
        _of_thread.waited = before + time.perf_counter() - began


def waited() -> float:
    """How long this thread has waited for what a run came to [s]."""
    return _of_thread.waited


def running_time() -> float:
    """The clock of a run [s]: what this thread takes without such waiting."""
    return time.perf_counter() - _of_thread.waited


def know(slot: int, name: str, load: Callable[[], None]) -> None:
    """Know what fills the slot at an address, and let the linker know `fetch`."""
    import llvmlite.binding as llvm

    _loaders[slot] = name, load
    address = ctypes.cast(fetch, ctypes.c_void_p).value
    llvm.add_symbol(FETCH_SYMBOL, address)


def generate_fetch(context: Any, builder: Any, slot: Any) -> None:
    """The machine code before a call: fill the slot if it is empty, or raise `NotLoaded`."""
    from llvmlite import ir

    from nonsmooth.jit.internals import cgutils

    word = ir.IntType(64)
    address = builder.ptrtoint(builder.load(slot), word)
    with builder.if_then(builder.icmp_unsigned("==", address, word(0)), likely=False):
        kind = ir.FunctionType(word, [word])
        function = cgutils.get_or_insert_function(builder.module, kind, FETCH_SYMBOL)
        outcome = builder.call(function, [builder.ptrtoint(slot, word)])
        with builder.if_then(builder.icmp_signed("==", outcome, word(NOT_FETCHED)), likely=False):
            context.call_conv.return_user_exc(builder, NotLoaded, ())
        with builder.if_then(builder.icmp_signed("==", outcome, word(FETCHED_INTERRUPTED)), likely=False):
            interrupt = ir.FunctionType(ir.VoidType(), [])
            builder.call(cgutils.get_or_insert_function(builder.module, interrupt, "PyErr_SetInterrupt"), [])
