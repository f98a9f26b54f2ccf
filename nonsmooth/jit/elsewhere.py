"""Entry points that other processes compile while this one goes on, and even after it has ended.

The processes hold a lock on a file of the folder of compiled code, as long as one of them lives. Who finds it locked
begins nothing: a second command within these seconds waits for the processes of the first, or does without.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

from nonsmooth.jit.cache import cache_directory, is_usable
from nonsmooth.jit.kernels import Kernel
from nonsmooth.jit.loading import MOST_PROCESSES, WAIT, may_start_process, shares, start_process
from nonsmooth.jit.surroundings import require_tested, version_of_numba
from nonsmooth.jit.turns import Turns

LOCK = "compiling.lock"  # chosen: a name that is none of compiled code
LOOK = 0.02  # chosen: s between two looks whether the processes are done


class Elsewhere:
    """Processes that compile, ours or those of another command.

    Parameters
    ----------
    path : Path
        The file that they have locked.
    processes : list of Popen
        Ours.
    """

    def __init__(self, path: Path, processes: list[subprocess.Popen]) -> None:
        self._path, self._processes = path, processes

    @property
    def is_over(self) -> bool:
        """Whether all of them have ended."""
        if any(process.poll() is None for process in self._processes):
            return False
        handle = locked(self._path)
        if handle is not None:
            os.close(handle)
        return handle is not None

    def wait(self) -> None:
        """Wait for their end; what they have not compiled after WAIT seconds is compiled by who needs it."""
        until = time.monotonic() + WAIT
        while not self.is_over and time.monotonic() < until:
            time.sleep(LOOK)

    def leave(self) -> None:
        """Let them go on without this process, which has no more need of them."""
        for process in self._processes:
            process.returncode = 0  # Python warns of processes that nobody waited for; these end by themselves


def compile_elsewhere(entry_points: list[Kernel]) -> Elsewhere | None:
    """Begin to compile these in other processes, unless there are some that compile; None where there can be none.

    Raises
    ------
    UnsupportedVersion
        For a numba that was not tested, or none.
    """
    require_tested(version_of_numba())
    if sys.platform == "win32" or not (may_start_process() and is_usable()):
        return None
    path = cache_directory() / LOCK
    try:
        handle = locked(path)
    except OSError:  # a file system without locks
        return None
    if handle is None:
        return Elsewhere(path, [])
    turns = Turns(shares(entry_points, min(os.cpu_count() or 1, MOST_PROCESSES), head_start=0.0))
    try:
        begun = [start_process(*turns.of(k), keeps=(handle,)) for k in range(len(turns.shares))]
    finally:
        turns.close()
        os.close(handle)  # the processes hold it
    processes = [process for process in begun if process is not None]
    return Elsewhere(path, processes) if processes else None


def locked(path: Path) -> int | None:
    """The handle of a file that nobody else has locked; None where somebody has.

    Raises
    ------
    OSError
        Where the file cannot be opened, or files cannot be locked.
    """
    import fcntl

    handle = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o600)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        return None
    except OSError:
        os.close(handle)
        raise
    return handle
