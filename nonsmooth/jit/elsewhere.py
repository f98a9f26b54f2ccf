"""Entry points that other processes compile while this one goes on, and even after it has ended.

A note in the folder of compiled code says which processes compile. Who finds one of them at work begins nothing: a
second command within these seconds waits for the processes of the first, or does without. Nobody waits for a process
that is gone, or that was stopped, as by Ctrl-Z. No file is locked; where the note cannot be written or read there is
none.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

from nonsmooth.jit.at_work import is_at_work, is_stopped, sign_of
from nonsmooth.jit.cache import cache_directory, is_usable
from nonsmooth.jit.code_files import READ_ONLY
from nonsmooth.jit.kernels import Kernel
from nonsmooth.jit.loading import MOST_PROCESSES, WAIT, may_start_process, shares, start_process
from nonsmooth.jit.surroundings import require_tested, version_of_numba
from nonsmooth.jit.turns import Turns

NOTE = "compiling.lock"  # chosen: a name that is none of compiled code
LONGEST_NOTE = 4096  # chosen: bytes; a line of 20 a process
# defined: a link is refused, and a pipe is not waited for
WRITE_NOTE = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
LOOK = 0.02  # chosen: s between two looks whether the processes are done


class Elsewhere:
    """Processes that compile, ours or those of another command.

    Parameters
    ----------
    path : Path
        The note about those of another command.
    processes : list of Popen
        Ours; then nobody else is waited for.
    """

    def __init__(self, path: Path, processes: list[subprocess.Popen]) -> None:
        self._path, self._processes = path, processes

    @property
    def is_over(self) -> bool:
        """Whether none of them is at work."""
        if self._processes:
            return all(process.poll() is not None or is_stopped(process.pid) for process in self._processes)
        return not any(map(is_at_work, noted(self._path)))

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
    others = Elsewhere(cache_directory() / NOTE, [])
    if not others.is_over:
        return others
    turns = Turns(shares(entry_points, min(os.cpu_count() or 1, MOST_PROCESSES), head_start=0.0))
    try:
        begun = [start_process(*turns.of(k)) for k in range(len(turns.shares))]
    finally:
        turns.close()
    processes = [process for process in begun if process is not None]
    note(cache_directory() / NOTE, [process.pid for process in processes])
    return Elsewhere(cache_directory() / NOTE, processes) if processes else None


def note(path: Path, pids: list[int]) -> None:
    """Say that these processes compile, where that can be said."""
    signs = filter(None, map(sign_of, pids))
    with contextlib.suppress(OSError), open(os.open(path, WRITE_NOTE, 0o600), "w") as file:
        file.write("".join(f"{sign}\n" for sign in signs))


def noted(path: Path) -> list[str]:
    """The signs of the processes that are said to compile."""
    try:
        handle = os.open(path, READ_ONLY)
    except OSError:
        return []
    try:
        return os.read(handle, LONGEST_NOTE).decode(errors="replace").splitlines()
    except OSError:
        return []
    finally:
        os.close(handle)
