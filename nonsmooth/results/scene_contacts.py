"""Contacts of a run of a scene: those of all records in columns, those of one record by themselves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.mechanics.system import ContactMode
from nonsmooth.results.scene_bodies import index_of
from nonsmooth.views import Worded, view


@dataclass(frozen=True, eq=False)
class SceneContacts:
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
    names : (n_b,) of all bodies
    """

    t: float
    i: np.ndarray
    j: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    gap: np.ndarray
    P: np.ndarray
    mu: np.ndarray
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
        k = index_of(name, self.names)
        rows = np.flatnonzero((self.i == k) | (self.j == k))
        return contacts_in(rows, self, self.t, self.names)

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


class ContactColumns(NamedTuple):
    """The contacts of all records, one behind the other; those of record k are offsets[k] to offsets[k + 1] - 1."""

    offsets: np.ndarray
    i: np.ndarray
    j: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    gap: np.ndarray
    P: np.ndarray
    mu: np.ndarray

    def __repr__(self) -> str:
        return view(Worded, "repr")(self)

    def _repr_html_(self) -> str:
        return view(Worded, "html")(self)


def contacts_in(rows: Any, columns: SceneContacts | ContactColumns, t: float, names: list[str]) -> SceneContacts:
    """The contacts in some rows of columns, at a time."""
    of_contacts = {name: getattr(columns, name)[rows] for name in ContactColumns._fields[1:]}
    return SceneContacts(t=t, names=names, **of_contacts)
