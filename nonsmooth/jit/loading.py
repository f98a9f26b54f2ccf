"""Loading of several entry points: what is not on disk yet is compiled by two processes at once, each about half of it.

Numba compiles under one lock, so threads would not help. The time that an entry point takes goes with the length of its
code, that of the kernels in it counted once.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from nonsmooth.jit.bytecode import reading
from nonsmooth.jit.cache import is_usable, words_of
from nonsmooth.jit.kernels import Kernel
from nonsmooth.jit.waiting import waiting

ROOT = Path(__file__).parents[2]  # where the package is imported from
COMPILE = "import sys; from nonsmooth.jit.loading import compile_named; compile_named(sys.argv[1:])"
STARTUP_CODE = 12_000  # measured: bytes of code that compile while the other process starts, some 2 s
PACE = 6_000  # measured: bytes of code that compile in a second, as STARTUP_CODE says
WAIT = 300.0  # chosen: s for the other process; what it has not compiled by then is compiled here


def load_all(entry_points: Iterable[Kernel]) -> None:
    """Load entry points."""
    entry_points = list(entry_points)
    missing = [kernel for kernel in entry_points if not kernel.is_loaded and not kernel.is_on_disk]
    if not missing:
        return _load(entry_points, missing)
    words = words_for(missing)  # before the first of them is on disk, which would look like a change of the others
    with waiting(lambda: words):
        _load(entry_points, missing)


def words_for(missing: list[Kernel]) -> str:
    """What is said while these are compiled: their part of the package, and the time that goes with their code."""
    seconds = sum(map(size_of, missing)) / PACE
    *_, part, _ = missing[0].function.__module__.split(".")
    return words_of([kernel.function.__name__ for kernel in missing], seconds, f" of {part}")


def _load(entry_points: list[Kernel], missing: list[Kernel]) -> None:
    """Compile what is missing, in two processes where that helps, and load all."""
    is_shared = len(missing) > 1 and may_start_process() and is_usable()
    here, there = shares(missing) if is_shared else ([], [])
    other = start_process(there) if there else None
    try:
        if other is not None:
            for kernel in here:
                kernel.load()
            other.wait(WAIT)
    except subprocess.TimeoutExpired:
        pass
    finally:
        if other is not None and other.poll() is None:
            other.kill()
            other.wait()
    for kernel in entry_points:
        kernel.load()


def shares(kernels: list[Kernel]) -> tuple[list[Kernel], list[Kernel]]:
    """Two parts that take about as long to compile: for this process, with the first one, and for one to be started."""
    first, *others = kernels
    here, there, time_here = [first], [], size_of(first)
    time_there = min(STARTUP_CODE, time_here)
    for kernel in sorted(others, key=size_of, reverse=True):
        if time_here < time_there:
            here.append(kernel)
            time_here += size_of(kernel)
        else:
            there.append(kernel)
            time_there += size_of(kernel)
    return here, there


def size_of(kernel: Kernel) -> int:
    """Bytes of the code of a kernel and of those that are compiled with it."""
    found, open_ends = {kernel}, [kernel]
    while open_ends:
        function = open_ends.pop().function
        read = (function.__globals__.get(name) for name, *_ in reading(function.__code__).names)
        new = {other for other in read if isinstance(other, Kernel) and other.signature is None} - found
        found |= new
        open_ends += new
    return sum(len(each.function.__code__.co_code) for each in found)


def may_start_process() -> bool:
    """Whether a second process would help, and is a Python: an embedding program must not be started again."""
    return (os.cpu_count() or 1) > 1 and Path(sys.executable or "").name.startswith("python")


def start_process(kernels: list[Kernel]) -> subprocess.Popen | None:
    """A process that compiles these to disk, or None where none can be started."""
    paths = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH", ""))))
    names = [f"{kernel.function.__module__}:{kernel.function.__name__}" for kernel in kernels]
    try:
        return subprocess.Popen(
            [sys.executable, "-c", COMPILE, *names],
            env={**os.environ, "PYTHONPATH": paths},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
    except OSError:
        return None


def compile_named(names: list[str]) -> None:
    """Compile entry points given as ``module:function``."""
    for name in names:
        module, function = name.split(":")
        __import__(module)
        getattr(sys.modules[module], function).load()
