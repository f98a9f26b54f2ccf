"""Loading of several entry points: what is not on disk yet is compiled by two processes at once.

Numba compiles under one lock, so threads would not help. The first use of Moreau–Jean on a machine with two cores falls
from 21 s to 13 s by it.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from nonsmooth.jit.cache import is_usable
from nonsmooth.jit.kernels import Kernel

ROOT = Path(__file__).parents[2]  # where the package is imported from
COMPILE = "import sys; from nonsmooth.jit.loading import compile_named; compile_named(sys.argv[1:])"
WAIT = 300.0  # chosen: s for the other process; what it has not compiled by then is compiled here


def load_all(entry_points: Iterable[Kernel]) -> None:
    """Load entry points, the one that takes longest to compile first."""
    entry_points = list(entry_points)
    missing = [kernel for kernel in entry_points if not kernel.is_loaded and not kernel.is_on_disk]
    is_shared = len(missing) > 1 and may_start_process() and is_usable()
    other = start_process(missing[1:]) if is_shared else None
    try:
        if other is not None:
            missing[0].load()
            other.wait(WAIT)
    except subprocess.TimeoutExpired:
        pass
    finally:
        if other is not None and other.poll() is None:
            other.kill()
            other.wait()
    for kernel in entry_points:
        kernel.load()


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
