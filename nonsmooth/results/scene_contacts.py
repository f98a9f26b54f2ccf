"""Contacts of a run of a scene: those of all records in columns, those of one record by themselves."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.table import RowsOfContacts
from nonsmooth.views import Worded


@dataclass(frozen=True, eq=False)
class SceneContacts(RowsOfContacts):
    """The contacts of one record; ``i`` pushes ``j`` along ``normal``.

    Attributes
    ----------
    t : float
        [s]
    i, j : (m,) indices of bodies
    point, normal : (m, 2|3)
        Midway between the surfaces [m], and out of body i.
    gap : (m,) before the last step [m]
    P : (m, 2|3)
        Impulses of the last step in the axes of the world, on body j [N s]; of a run with compliant contacts the forces
        [N].
    P_N, P_F : (m,)
        Their normal part, and the size of their tangential part.
    mode : (m,) ContactMode
    mu : (m,) friction coefficients
    names : (n_b,) of all bodies
    """

    t: float
    columns: dict[str, np.ndarray]
    names: list[str]

    def __len__(self) -> int:
        return len(self.i)

    @property
    def P_N(self) -> np.ndarray:
        """Normal impulses [N s]."""
        return normal_and_friction(self.P, self.normal)[0]

    @property
    def P_F(self) -> np.ndarray:
        """Sizes of the tangential impulses [N s]."""
        return normal_and_friction(self.P, self.normal)[1]

    @property
    def mode(self) -> np.ndarray:
        """OPEN without an impulse; STICK within the friction cone, SLIDE on it, to 1e-8 of it."""
        return modes_of(*normal_and_friction(self.P, self.normal), self.mu)

    def of(self, name: str) -> SceneContacts:
        """Those of one body."""
        return replace(self, columns=self.touching(name))

    def __repr__(self) -> str:
        loaded = int((self.P_N > 0).sum())
        return f"SceneContacts({len(self)} at t = {self.t:.6g} s, {loaded} of them loaded)"


def normal_and_friction(P: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normal parts (m,) of impulses, and the sizes of their tangential parts."""
    P_N = (P * normal).sum(axis=1)
    return P_N, np.linalg.norm(P - P_N[:, None] * normal, axis=1)


def modes_of(P_N: np.ndarray, P_F: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """What contacts with such impulses do."""
    sliding = np.where(P_F >= mu * P_N * (1 - 1e-8), ContactMode.SLIDE, ContactMode.STICK)
    return np.where(P_N > 0, sliding, ContactMode.OPEN)


class ContactColumns(Worded, RowsOfContacts):
    """The contacts of all records, one behind the other; those of record k are offsets[k] to offsets[k + 1] - 1."""

    offsets: np.ndarray

    def __init__(self, columns: dict[str, np.ndarray]) -> None:
        self.columns = columns

    @property
    def _fields(self) -> tuple[str, ...]:
        return tuple(self.columns)

    def at(self, rows: slice | np.ndarray, t: float, names: list[str]) -> SceneContacts:
        """Some of the contacts, at a time."""
        columns = {name: column[rows] for name, column in self.columns.items() if name != "offsets"}
        return SceneContacts(t, columns, names)
