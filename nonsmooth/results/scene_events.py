"""What happened at the contacts of a scene, pair of bodies by pair of bodies: landing, parting, slip and stick."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from nonsmooth.results.scene_bodies import index_of


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
class SceneEvents:
    """The changes of a run, in the order of time.

    Attributes
    ----------
    t : (m,)
        Beginning of the step in which they were found [s].
    kind : (m,) SceneEventKind
    i, j : (m,)
        Indices of bodies, i < j.
    P_N : (m,)
        Sum of the normal impulses of the pair in that step [N s]; 0 of a parting.
    P : (m, 2|3)
        Its impulse on body j, in the axes of the world [N s].
    names : list of str
        Of all bodies.
    """

    t: np.ndarray
    kind: np.ndarray
    i: np.ndarray
    j: np.ndarray
    P_N: np.ndarray
    P: np.ndarray
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
        has = np.ones(len(self), bool)
        for name in names:
            b = index_of(name, self.names)
            has &= (self.i == b) | (self.j == b)
        t, kind, i, j, P_N, P = (column[has] for column in (self.t, self.kind, self.i, self.j, self.P_N, self.P))
        return SceneEvents(t, kind, i, j, P_N, P, self.names)

    def __repr__(self) -> str:
        counts = np.bincount(self.kind, minlength=len(SceneEventKind))
        listed = ", ".join(f"{counts[kind]} {kind.name}" for kind in SceneEventKind)
        return f"SceneEvents({len(self)}: {listed})"
