"""Loading of several entry points: what is not on disk yet is compiled by some processes at once, a share each.

Numba compiles under one lock, so threads would not help. The time that an entry point takes goes with the length of its
code, that of the kernels in it counted once. Numba's part of it is spent once in a process on each kernel, LLVM's in
each entry point that the kernel is a part of: those that share kernels go together where the shares stay even. Bytes
tell the time to a factor of 1.5: who is done with his share goes on with what is left of another (turns.py).
"""

from __future__ import annotations

import contextlib
import functools
import os
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from nonsmooth.jit.at_work import is_stopped
from nonsmooth.jit.cache import is_usable, words_of
from nonsmooth.jit.kernels import Kernel, called_by
from nonsmooth.jit.late import stopped_clock
from nonsmooth.jit.turns import Turns, in_turn
from nonsmooth.jit.waiting import waiting

ROOT = Path(__file__).parents[2]  # where the package is imported from
# Neither the working folder nor the folder that this package lies in is searched: their files are nobody's modules.
# Numba looks for LAPACK in SciPy, 0.15 s, which no kernel uses; at the end there is nothing to tidy up.
COMPILE = """
import importlib.util, os, sys
sys.modules["scipy.linalg"] = None
package, pipes, *names = sys.argv[1:]
spec = importlib.util.spec_from_file_location("nonsmooth", package)
sys.modules["nonsmooth"] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(sys.modules["nonsmooth"])
from nonsmooth.jit.loading import compile_named
compile_named(tuple(map(int, pipes.split())), names)
os._exit(0)
"""
MOST_PROCESSES = 4  # chosen: 250 MB each, and the largest entry point of a scene takes a third of all
STARTUP_CODE = 8_000  # measured: bytes of code that compile while another process starts, some 0.8 s
PACE = 10_000  # measured: bytes of code that a process compiles in a second while others do too: 7,000 to 13,000
ONCE = 0.65  # measured: numba's part of the time
WAIT = 300.0  # chosen: s for the other processes; what they have not compiled by then is compiled here
STOP_LOOK = 0.5  # chosen: s between two looks whether somebody stopped one of them


def load_all(entry_points: Iterable[Kernel]) -> None:
    """Load entry points."""
    entry_points = list(entry_points)
    missing = [kernel for kernel in entry_points if not kernel.is_loaded and not kernel.is_on_disk]
    if not missing:
        with stopped_clock():
            return _load(entry_points, [[]])
    is_shared = len(missing) > 1 and may_start_process() and is_usable()
    parts = shares(missing, min(os.cpu_count() or 1, MOST_PROCESSES) if is_shared else 1)
    words = words_for(missing, parts)  # before one of them is on disk, which would look like a change of the others
    with waiting(lambda: words), stopped_clock():
        _load(entry_points, parts)


def words_for(missing: list[Kernel], parts: list[list[Kernel]]) -> str:
    """What is said while these are compiled: their part of the package, and the time of the longest share."""
    seconds = max(map(work_of, parts)) / PACE
    *_, part, _ = missing[0].function.__module__.split(".")
    return words_of([kernel.kept_name for kernel in missing], seconds, f" of {part}")


def _load(entry_points: list[Kernel], parts: list[list[Kernel]]) -> None:
    """Compile the first share here and the others in processes of their own, and load all."""
    turns = Turns(parts)
    others = [process for k in range(1, len(parts)) if (process := start_process(*turns.of(k))) is not None]
    until = time.monotonic() + WAIT
    try:
        for kernel in in_turn(*turns.of(0)):
            kernel.load()
        for other in others:
            wait_for(other, until)
    finally:
        turns.close()
        for other in others:
            if other.poll() is None:
                other.kill()
                other.wait()
    for kernel in entry_points:
        kernel.load()


def wait_for(process: subprocess.Popen, until: float) -> None:
    """Wait for the end of a process until a time, unless somebody stopped it."""
    while time.monotonic() < until and not is_stopped(process.pid):
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(STOP_LOOK)
            return


def shares(kernels: list[Kernel], processes: int, head_start: float = STARTUP_CODE) -> list[list[Kernel]]:
    """Parts that take about as long to compile: for this process, with the first one, and for some to be started.

    ``head_start``: bytes of code that this one compiles before the others have started; 0 where all are started.
    """
    first, *others = kernels
    parts: list[list[Kernel]] = [[first], *([] for _ in range(1, processes))]
    start = min(head_start, work_of(kernels) / (1 + processes))
    for kernel in sorted(others, key=size_of, reverse=True):
        ends = [(work_of([*part, kernel]) + (start if k > 0 else 0), k == 0) for k, part in enumerate(parts)]
        parts[ends.index(min(ends))].append(kernel)
    return [part for part in parts if part]


def work_of(kernels: list[Kernel]) -> float:
    """Bytes of code that take as long as these take together in one process."""
    together = set().union(*map(kernels_of, kernels))
    return ONCE * bytes_of(together) + (1.0 - ONCE) * sum(map(size_of, kernels))


def size_of(kernel: Kernel) -> int:
    """Bytes of the code of a kernel and of those that are compiled with it."""
    return bytes_of(kernels_of(kernel))


def bytes_of(kernels: Iterable[Kernel]) -> int:
    """Bytes of the code of kernels themselves."""
    return sum(len(each.function.__code__.co_code) for each in kernels)


@functools.cache
def kernels_of(kernel: Kernel) -> frozenset[Kernel]:
    """A kernel and those that are compiled with it."""
    found, open_ends = {kernel}, [kernel]
    while open_ends:
        new = {other for other in called_by(open_ends.pop()) if other.signature is None} - found
        found |= new
        open_ends += new
    return frozenset(found)


def may_start_process() -> bool:
    """Whether a second process would help, and is a Python: an embedding program must not be started again."""
    return (os.cpu_count() or 1) > 1 and Path(sys.executable or "").name.startswith("python")


def start_process(pipes: tuple[int, ...], kernels: list[Kernel]) -> subprocess.Popen | None:
    """A process that compiles to disk what is its turn, or None where none can be started."""
    package = str(ROOT / "nonsmooth" / "__init__.py")
    names = [kernel.place for kernel in kernels]
    try:
        return subprocess.Popen(
            [sys.executable, "-P", "-c", COMPILE, package, " ".join(map(str, pipes)), *names],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            pass_fds=pipes,
        )
    except OSError:
        return None


def compile_named(pipes: tuple[int, ...], names: list[str]) -> None:
    """Compile entry points given by their places, those whose turn it is."""
    for place in in_turn(pipes, names):
        kernel_at(place).load()


def kernel_at(place: str) -> Kernel:
    """The entry point at ``module:function``, or at ``module:function[d]`` where there is one for each dimension."""
    module, name = place.split(":")
    __import__(module)
    name, _, d = name.removesuffix("]").partition("[")
    found: Any = getattr(sys.modules[module], name)
    return found[int(d)] if d else found  # type: ignore[no-any-return]
