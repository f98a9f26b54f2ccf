"""Memory that a run would take, against what the machine has: a refusal in time instead of a killed process.

An array of zeros costs nothing until it is written, so the operating system grants more than it has and ends the
process later. What is free is read from Linux (MemAvailable, and the limit of the control group); elsewhere it is the
memory of the machine.
"""

from __future__ import annotations

import os
from pathlib import Path

from nonsmooth.errors import InvalidInput

GIB = 2**30  # defined: bytes
UNASKED_BYTES = 2**28  # chosen: bytes: less than this is there, and asking costs more than a short run
# measured: bytes that a byte of a file may stand for: 1 to 6 on published contact problems, 1000 for zeros
INFLATION = 100
LEAST_CLAIM = 2**26  # chosen: bytes that any file may claim


def require_memory(needed: float, what: str, cure: str) -> None:
    """Raise `InvalidInput` when more bytes are needed than are free."""
    if needed <= UNASKED_BYTES:
        return
    free = free_memory()
    if needed > free:
        raise InvalidInput(f"{what} need {needed / GIB:.3g} GiB and {free / GIB:.3g} GiB are free; {cure}")


def require_room(claimed: int, size: int | None) -> None:
    """Raise `ValueError` when the arrays in a file claim more bytes than there is room for.

    Parameters
    ----------
    claimed : int
        Bytes of all arrays as their headers say.
    size : int or None
        Bytes of the file, of which those of others may stand for 100 each; None: a file whose checksum was verified.
    """
    if size is not None and claimed > max(LEAST_CLAIM, INFLATION * size):
        raise ValueError(
            f"its arrays claim {claimed / GIB:.3g} GiB in a file of {size / GIB:.3g} GiB, more than {INFLATION} times "
            "as much; a file that is not compressed may be as large as the memory"
        )
    if claimed > UNASKED_BYTES and claimed > free_memory():
        raise ValueError(f"its arrays need {claimed / GIB:.3g} GiB and {free_memory() / GIB:.3g} GiB are free")


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
