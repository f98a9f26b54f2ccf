"""Events of a run: changes of mode, impacts and paradoxes, from rows of numbers to objects.

Those of a scene are of pairs of bodies: landing, parting, slip and stick.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.integrators import records
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.table import RowsOfEvents


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
WITHOUT_SIGN = {"slide +": "slide", "slide -": "slide"}  # in space, where a slide has a direction
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


@dataclass(frozen=True)
class SceneParadox(ParadoxEvent):
    """A step of a scene in which two bodies had no force to slide with (INCONSISTENT: an impact without collision), or
    the first step of an episode in which several motions fit (INDETERMINATE); as of a System, with the bodies.

    ``contact`` is the number of the contact in its step, the first of those of the two bodies; P_N and P_F are those of
    all of them. Slips and P_F have the signs of ``scene.system()``: positive where body j slides along its normal, out
    of body i, turned by -90 degrees. In space signs are 0, and P_F and gamma_F are sizes.

    Attributes
    ----------
    i, j : str
        Names of the bodies.
    """

    i: str
    j: str


def no_rows() -> np.ndarray:
    """Those of a run without any."""
    return np.zeros((0, records.PARADOX_WIDTH))


def paradox_of(row: np.ndarray, names: list[str], dim: int) -> SceneParadox:
    """A row as an object."""
    event = event_of(row)
    assert isinstance(event, ParadoxEvent)
    if dim == 3:
        event = replace(event, alternatives=tuple(WITHOUT_SIGN.get(name, name) for name in event.alternatives))
    return SceneParadox(**vars(event), i=names[int(row[records.EVENT_I])], j=names[int(row[records.EVENT_J])])


class SceneEventKind(IntEnum):
    """What happened to a pair of bodies."""

    LANDING = 0  # impulses act where none did in the step before
    PARTING = 1  # none act where some did
    SLIP = 2  # all its loaded points slide, where one stuck
    STICK = 3  # one of them sticks, where all slid


class SceneEvent(NamedTuple):
    """A change at a pair of bodies, found in the step that begins at t."""

    t: float  # [s]
    kind: SceneEventKind
    i: str  # names of the bodies
    j: str
    P_N: float  # of the step: sum of the normal impulses of its points [N s]
    P: np.ndarray  # (2|3,) on body j, in the axes of the world [N s]


@dataclass(frozen=True, eq=False)
class SceneEvents(RowsOfEvents):
    """The changes of a run, in the order of time.

    Attributes
    ----------
    t : (m,)
        Beginning of the step in which they were found [s].
    kind : (m,) SceneEventKind
    i, j : (m,)
        Indices of bodies, i < j.
    P_N : (m,)
        Sum of the normal impulses of the pair in that step [N s], on springs of its forces at the end of it [N]; 0 of a
        parting.
    P : (m, 2|3)
        Its impulse on body j, in the axes of the world [N s], on springs its force [N].
    names : list of str
        Of all bodies.
    """

    columns: dict[str, np.ndarray]
    names: list[str]

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, k: int) -> SceneEvent:
        i, j = self.names[int(self.i[k])], self.names[int(self.j[k])]
        return SceneEvent(float(self.t[k]), SceneEventKind(int(self.kind[k])), i, j, float(self.P_N[k]), self.P[k])

    def __iter__(self) -> Iterator[SceneEvent]:
        return (self[k] for k in range(len(self)))

    def of(self, *names: str) -> SceneEvents:
        """Those of one body, or of a pair."""
        return replace(self, columns=self.touching(*names))

    def __repr__(self) -> str:
        counts = np.bincount(self.kind, minlength=len(SceneEventKind))
        listed = ", ".join(f"{counts[kind]} {kind.name}" for kind in SceneEventKind)
        return f"SceneEvents({len(self)}: {listed})"
