"""What pairs of bodies exchanged, between two records or in a run: impulses, and works as the ledger has them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from nonsmooth.results.table import RowsOfPairs


class ScenePair(NamedTuple):
    """What a pair of bodies exchanged since the record before t."""

    t: float  # [s]
    i: str  # names of the bodies
    j: str
    joint: str  # that holds them; "" where they touch
    P: np.ndarray  # (2|3,) on body j, in the axes of the world [N s]
    normal: float  # works [J], as of `ScenePairs`
    friction: float
    surface: float


@dataclass(frozen=True, eq=False)
class ScenePairs(RowsOfPairs):
    """What pairs of bodies exchanged, record by record: those that touched since the record before, and joints.

    Sums over all pairs are the change of ``ledger["normal"]``, ``["friction"]`` and ``["surface"]``; what the impulses
    give a body is what its momentum changed by, without its weight.

    Attributes
    ----------
    t : (m,)
        Of the record at which an interval ends [s]; it begins at the record before.
    record : (m,)
        Its number.
    i, j : (m,)
        Indices of bodies; i < j where they touch, those of a joint as it was declared.
    joint : (m,)
        Index of a joint, -1 where they touch.
    P : (m, 2|3)
        Impulse on body j, in the axes of the world [N s].
    normal, friction, surface : (m,)
        Works of the impulses along normals, of joints too, and along tangents, and what guided bodies and running
        surfaces put in [J].
    names, joint_names : list of str
        Of all bodies and joints.
    """

    columns: dict[str, np.ndarray]
    names: list[str]
    joint_names: list[str]

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, k: int) -> ScenePair:
        i, j = self.names[int(self.i[k])], self.names[int(self.j[k])]
        joint = self.joint_names[int(self.joint[k])] if self.joint[k] >= 0 else ""
        works = float(self.normal[k]), float(self.friction[k]), float(self.surface[k])
        return ScenePair(float(self.t[k]), i, j, joint, self.P[k], *works)

    def __iter__(self) -> Iterator[ScenePair]:
        return (self[k] for k in range(len(self)))

    def of(self, *names: str) -> ScenePairs:
        """Those of one body, or of two."""
        return replace(self, columns=self.touching(*names))

    def total(self) -> ScenePairs:
        """The sums of each pair over all intervals, in the order of (i, j, joint); t and record are the last."""
        keys = np.stack([self.i, self.j, self.joint], axis=1).reshape(-1, 3)
        every, at = np.unique(keys, axis=0, return_inverse=True)
        last = np.zeros(len(every), np.int64)
        np.maximum.at(last, at.ravel(), np.arange(len(self)))
        sums = self.columns_at(last)
        for name in ("P", "normal", "friction", "surface"):
            sums[name] = np.zeros_like(sums[name])
            np.add.at(sums[name], at.ravel(), np.asarray(self.columns[name]))
        return replace(self, columns=sums)

    def __repr__(self) -> str:
        pairs = len(np.unique(np.stack([self.i, self.j, self.joint]), axis=1).T)
        return f"ScenePairs({len(self)} rows of {pairs} pairs)"
