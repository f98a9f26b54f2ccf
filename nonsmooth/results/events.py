"""Events of a run: changes of mode, impacts and paradoxes, from rows of numbers to objects."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from nonsmooth.integrators import records
from nonsmooth.mechanics.system import ContactMode


class EventKind(IntEnum):
    """What happened at an event."""

    MODE_CHANGE = records.MODE_CHANGE
    IMPACT = records.IMPACT
    INCONSISTENT = records.INCONSISTENT
    INDETERMINATE = records.INDETERMINATE


WHOLE_COLUMNS = (  # code: of an event; its impulses and velocities are no whole numbers, and may be infinite
    records.EVENT_KIND, records.EVENT_CONTACT, records.EVENT_MODE_0, records.EVENT_SLIP_0, records.EVENT_MODE_1,
    records.EVENT_SLIP_1, records.EVENT_SOLUTIONS, records.EVENT_FOUND,
)  # fmt: skip
MAX_EVENTS = 200_000  # chosen: kept in a solution; the rest are counted
CANDIDATE_NAMES = ("free", "stick", "slide +", "slide -", "slide + (P_N < 0)", "slide - (P_N < 0)")


@dataclass(frozen=True)
class Event:
    """A change at one contact, found in the step that begins at t.

    Attributes
    ----------
    t : float
        Beginning of the step [s].
    kind : EventKind
    contact : int
    mode_before, mode_after : ContactMode
    slip_before, slip_after : int
        Signs of sliding.
    P_N, P_F : float
        Impulses of the step [N s]; of friction in two directions its size.
    gamma_N, gamma_F : float
        Contact velocities before the step [m/s]; of two directions the size of gamma_F.
    """

    t: float
    kind: EventKind
    contact: int
    mode_before: ContactMode
    slip_before: int
    mode_after: ContactMode
    slip_after: int
    P_N: float
    P_F: float
    gamma_N: float
    gamma_F: float


@dataclass(frozen=True)
class ParadoxEvent(Event):
    """A step whose sliding had no force (INCONSISTENT: an impact without collision), or the first step of an episode in
    which the contact problem had several solutions (INDETERMINATE).

    Attributes
    ----------
    n_solutions : int
        Number of solutions of the rigid problem: 0 where sliding was inconsistent.
    alternatives : tuple of str
        The admissible modes among which the selection rule chose, where they are known one by one; none where sliding
        was inconsistent.
    """

    n_solutions: int
    alternatives: tuple[str, ...]

    @property
    def choice(self) -> str:
        """The mode that was taken: of an impact without collision, the mode after it."""
        return mode_name(self.mode_after, self.slip_after)


def mode_name(mode: int, slip: int) -> str:
    """A mode as a person would write it; a closed contact without friction is not locked: it slides freely."""
    name = "closed" if mode == ContactMode.LOCKED else ContactMode(mode).name.lower()
    return name + {1: " +", -1: " -", 0: ""}[int(slip)]


def event_of(row: np.ndarray) -> Event:
    """A row of the events as an object."""
    integer = {k: int(row[k]) for k in WHOLE_COLUMNS}
    fields: dict[str, Any] = {
        "t": float(row[records.EVENT_T]),
        "kind": EventKind(integer[records.EVENT_KIND]),
        "contact": integer[records.EVENT_CONTACT],
        "mode_before": ContactMode(integer[records.EVENT_MODE_0]),
        "slip_before": integer[records.EVENT_SLIP_0],
        "mode_after": ContactMode(integer[records.EVENT_MODE_1]),
        "slip_after": integer[records.EVENT_SLIP_1],
        "P_N": float(row[records.EVENT_P_N]),
        "P_F": float(row[records.EVENT_P_F]),
        "gamma_N": float(row[records.EVENT_GAMMA_N]),
        "gamma_F": float(row[records.EVENT_GAMMA_F]),
    }
    if integer[records.EVENT_KIND] < records.INCONSISTENT:
        return Event(**fields)
    found = integer[records.EVENT_FOUND] if integer[records.EVENT_SOLUTIONS] > 0 else 0
    alternatives = tuple(name for k, name in enumerate(CANDIDATE_NAMES) if found >> k & 1)
    return ParadoxEvent(**fields, n_solutions=integer[records.EVENT_SOLUTIONS], alternatives=alternatives)
