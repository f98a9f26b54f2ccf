"""The disk cache of compiled code: what was compiled once is read by every later process.

The key of a function is a hash of all that its machine code was made from: its sources and the values they read
(`fingerprint`), the sources here that generate code, the versions of Python, numba, llvmlite and numpy, the processor,
and numba's options.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import hashlib
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from nonsmooth.jit.code_files import ENDING, CodeFile, usable
from nonsmooth.jit.late import stopped_clock
from nonsmooth.jit.linking import Linked, linked
from nonsmooth.jit.surroundings import surroundings
from nonsmooth.jit.waiting import sentence, waiting

PACKAGE = Path(__file__).parent
ONE_TIME = 2.0  # measured: s that an entry point compiles, of some 20 kB of code with what it calls
MOST_ASIDE = 700_000  # measured: objects, of 250 MB
GENERATORS = sorted(PACKAGE.glob("*.py"))  # sources that generate code themselves


def cache_directory() -> Path:
    """Where compiled code is kept: ``$NONSMOOTH_CACHE_DIR``, else ``nonsmooth`` under the user's cache directory."""
    if os.environ.get("NONSMOOTH_CACHE_DIR"):
        return Path(os.environ["NONSMOOTH_CACHE_DIR"])
    if sys.platform == "win32":
        root = os.environ.get("LOCALAPPDATA") or "~"
    else:
        root = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(os.path.expanduser(root)) / "nonsmooth"


def is_usable() -> bool:
    """Whether compiled code can be kept."""
    return usable(cache_directory())


def is_cached(name: str, key: str) -> bool:
    """Whether code is on disk under this key."""
    return is_usable() and code_file(name, key).exists


def code_file(name: str, key: str) -> CodeFile:
    """The file of a function's code; one that is never there where nothing can be kept."""
    return CodeFile(cache_directory() if is_usable() else None, name, key, "\n".join(surroundings()))


def key_of(content: bytes) -> str:
    """The key of code that is made from this content, on this machine."""
    return hashlib.sha256("\n".join((generators_hash(), *surroundings(), "")).encode() + content).hexdigest()


@functools.cache
def generators_hash() -> str:
    """Hash of the sources that generate code themselves: they shape every compiled function."""
    return hashlib.sha256(b"".join(path.read_bytes() for path in GENERATORS)).hexdigest()


class Compiled:
    """Machine code that was compiled in this process, as long as this object lives.

    Attributes
    ----------
    address : int
        Where its function begins.
    """

    def __init__(self, dispatcher: Any) -> None:
        from nonsmooth.jit.internals import machine_code_of

        self.dispatcher = dispatcher
        self.address = machine_code_of(dispatcher)


MachineCode = Compiled | Linked


def machine_code(
    make: Callable[[], Callable], signature: str, name: str, key: str, options: Callable[[], dict[str, Any]]
) -> MachineCode:
    """The machine code of a function that is called by its address: from the disk, or of what ``make`` returns, with
    numba's ``options()``."""
    found = code_file(name, key).load(linked)
    if found is not None:
        return found
    from nonsmooth.jit.internals import unlinked_code

    dispatcher = compile_cached(make(), signature, name, key, by_address=True, **options())
    return linked(unlinked_code(dispatcher)) or Compiled(dispatcher)


def compile_cached(
    function: Callable, signature: str, name: str, key: str, by_address: bool = False, **options: Any
) -> Any:
    """The dispatcher of numba for one signature, from the disk or compiled and kept there under the given key.

    What is called ``by_address`` alone has no wrapper for Python.
    """
    from nonsmooth.jit.internals import keep_results, numba

    if by_address:
        options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    dispatcher = numba.njit(**options)(function)
    if not numba.config.DISABLE_JIT:
        file = code_file(name, key)
        keep_results(dispatcher, file, by_address)
        telling = contextlib.nullcontext() if file.exists else waiting(lambda: words_of([name], ONE_TIME))
        with telling, stopped_clock(), no_collection():
            dispatcher.compile(signature)
        dispatcher.disable_compile()
    return dispatcher


def words_of(names: list[str], seconds: float, of: str = "") -> str:
    """What is said while these entry points are compiled."""
    what = names[0].rpartition(".")[2] if len(names) == 1 else f"{len(names)} functions{of}"
    return sentence(what, reason_for(names), seconds, cache_directory() if is_usable() else None)


def reason_for(names: list[str]) -> str:
    """Why functions are compiled of which nothing that fits is on disk."""
    is_known = False
    with contextlib.suppress(OSError):  # the folder may go while it is looked through
        is_known = is_usable() and any(any(cache_directory().glob(f"{name}-*{ENDING}")) for name in names)
    return "changed since, or another version of something beneath" if is_known else "first use on this machine"


@contextlib.contextmanager
def no_collection() -> Iterator[None]:
    """Compile without Python's garbage collector, which goes through all that numba keeps again and again: a fifth of
    the time that kernels compile. What was made meanwhile is put to the objects that live long, without a look at them
    (a tenth): it is collected with these, or here once it is more than MOST_ASIDE and, as Python has it, than a quarter
    of all objects, since a collection looks at all (by MOST_ASIDE alone collections were 4 % of the time of all tests).
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            _put_aside()
            gc.enable()


def _put_aside() -> None:
    global _count_aside, _most_aside
    _count_aside += gc.get_count()[0]
    if _count_aside > _most_aside or gc.get_freeze_count() > 0:  # what somebody froze would be thawed
        gc.collect()
        _count_aside, _most_aside = 0, max(MOST_ASIDE, len(gc.get_objects()) // 4)
    else:
        gc.freeze()
        gc.unfreeze()


_count_aside, _most_aside = 0, MOST_ASIDE  # objects
