"""Memory that a run would take, against what the machine has: a refusal in time instead of a killed process.

An array of zeros costs nothing until it is written, so the operating system grants more than it has and ends the
process later. What is free is read from Linux (MemAvailable, and the limit of the control group); elsewhere it is the
memory of the machine.
"""

from __future__ import annotations

import os
from pathlib import Path

from nonsmooth.errors import InvalidInput

GIB = 2**30  # bytes
SMALL = 2**28  # bytes: less than this is there, and asking costs more than a short run


def require_memory(needed: float, what: str, cure: str) -> None:
    """Raise `InvalidInput` when more bytes are needed than are free."""
    if needed <= SMALL:
        return
    free = free_memory()
    if needed > free:
        raise InvalidInput(f"{what} need {needed / GIB:.3g} GiB and {free / GIB:.3g} GiB are free; {cure}")


def free_memory() -> float:
    """Bytes that this process may still take; inf where nothing is known."""
    return min(_available(), _limit("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"))


def _available() -> float:
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        return 1024.0 * next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable"))
    except (OSError, StopIteration, ValueError, IndexError):
        pass
    try:
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return float("inf")


def _limit(most: str, used: str) -> float:
    try:
        return float(Path(most).read_text()) - float(Path(used).read_text())
    except (OSError, ValueError):  # no control group, or "max": no limit
        return float("inf")
