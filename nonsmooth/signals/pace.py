"""How long a calculation will take that reports its progress, and a time as a person would say it.

remaining = (1 - part) (now - t)/(part - part at t)
"""

from __future__ import annotations

import math

EVIDENCE_TIME = 1.0  # chosen: s after which a rate is believed
RECENT_TIME = 5.0  # chosen: s after which the rate is measured again: a motion may become slower on its way


class Pace:
    """Seconds that are left of a calculation that reports its progress: at its mean rate, or at that of the last
    `RECENT_TIME` seconds or more where that is less."""

    def __init__(self) -> None:
        self._first = self._last = self._next = (math.inf, 0.0)  # time [s] and part
        self._before = math.inf

    def left(self, part: float, now: float) -> float:
        """At a part and a time; NaN before anything is known, infinite where nothing moves."""
        if part < self._before:  # what comes before the first part is compiling, or another run
            self._first = self._last = self._next = (now, part)
        self._before = part
        if now - self._next[0] >= RECENT_TIME:
            self._last, self._next = self._next, (now, part)
        if now - self._first[0] < EVIDENCE_TIME:
            return math.nan
        return max(time_left(part, now, *mark) for mark in (self._first, self._last))


def time_left(part: float, now: float, t: float, before: float) -> float:
    """At the rate since a time, at which another part was done."""
    return (now - t) * (1.0 - part) / (part - before) if part > before else math.inf


def duration(seconds: float) -> str:
    """A time as a person would say it."""
    if not math.isfinite(seconds):
        return "an unknown time"
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"
