"""Whether a process is at work: it lives, nobody stopped it, and it is the one that it was.

The operating system gives its state and when it began (Linux: fields 3 and 22 of /proc/PID/stat, proc(5)). A sign is
"PID START": numbers of processes are given again. Where the system does not say so, no process of others is known to be
at work, and one's own is as long as it has not ended.
"""

from __future__ import annotations

from pathlib import Path

STATE, BEGAN = 0, 19  # defined: places among the fields behind the name of the program
STOPPED, GONE = "tT", "ZXx"  # defined: by a signal or a debugger; ended


def sign_of(pid: int) -> str:
    """By what a process is known again; nothing where it has ended, or the system says nothing of it."""
    fields = _fields(pid)
    return f"{pid} {fields[BEGAN]}" if fields else ""


def is_at_work(sign: str) -> bool:
    """Whether the process of a sign is at work."""
    pid, _, _ = sign.partition(" ")
    fields = _fields(int(pid)) if pid.isdecimal() else []
    return bool(fields) and fields[STATE] not in STOPPED + GONE and sign == f"{pid} {fields[BEGAN]}"


def is_stopped(pid: int) -> bool:
    """Whether somebody stopped a process, as by Ctrl-Z."""
    fields = _fields(pid)
    return bool(fields) and fields[STATE] in STOPPED


def _fields(pid: int) -> list[str]:
    try:
        return Path(f"/proc/{pid}/stat").read_text(errors="replace").rpartition(")")[2].split()
    except OSError:
        return []
