"""What is known of the forces of a state with friction in two directions.

    gamma' = G la + c    at a state,    0 <= la_N,    |la_T| <= mu la_N

A contact that slides along d carries la_T = -mu la_N d, so that with p = G_NN - mu G_NT d and b = c_N

    0 <= la_N  _|_  p la_N + b >= 0        p < 0 and b < 0: none;  p < 0 and b > 0: it lifts off, or slides

Contacts that are coupled and all slide are one complementarity problem of their la_N (or have no friction); one that
rests by itself has open, stick and the roots of a quartic, whose number is exact (contact/spatial/exact_count.py). Of
coupled contacts of which some rest the complete answer is not known, and none is given. Contacts that G does not couple
are decided apart.
Source: Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653; Champneys, Várkonyi, *IMA J. Appl. Math.* 81 (2016)
538.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.contact.islands import find_islands
from nonsmooth.contact.spatial.contact_solutions import solutions_of_one
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from nonsmooth.lcp.enumerate import lcp_solutions
from nonsmooth.mechanics.acceleration_problem import acceleration_problem
from nonsmooth.mechanics.compiled import interpreted_model
from nonsmooth.mechanics.contact_problem import Work, model_facts
from nonsmooth.mechanics.initial_state import contact_state
from nonsmooth.mechanics.inspection import inspect_instant
from nonsmooth.mechanics.laws import friction_coefficient, static_coefficient
from nonsmooth.mechanics.situation import Situation, find_situation, tolerances_of_state
from nonsmooth.mechanics.sys import new_sys
from nonsmooth.mechanics.system import GIVEN_FORCE, SURFACE_VELOCITY, TANGENT, System, evaluate
from nonsmooth.numerics.rounding import rounding_of_sum
from nonsmooth.paradox.kinds import ParadoxFlag, ParadoxKind, kind_of
from nonsmooth.paradox.state_problem import WHY, free_motion
from nonsmooth.views import view

MOST_SLIDING = 12  # chosen: coupled contacts that slide: 2^12 leaves of a tree, some 0.1 s
MOST_LISTED = 256  # chosen: solutions of all islands that are listed
SLIDE_ROUNDINGS = 900  # chosen: of the terms of a sum: a smaller sum is zero

set_up, judge, tolerate = (interpreted(rule) for rule in (acceleration_problem, find_situation, tolerances_of_state))
mu_of, static_mu_of, islands_of = (interpreted(r) for r in (friction_coefficient, static_coefficient, find_islands))


class SpatialSolution(NamedTuple):
    """One set of contact forces that fits the state.

    Attributes
    ----------
    modes : tuple of str
        Of each contact: "open", "free", "stick", "slide", "closed" (no friction).
    la : ndarray (n_c, 3)
        Forces N, T1, T2 [N].
    du : ndarray (n_u,)
        Accelerations u'.
    """

    modes: tuple[str, ...]
    la: np.ndarray
    du: np.ndarray


@dataclass(frozen=True, eq=False)
class SpatialClassification:
    """What is known of a state with friction in two directions. ``print`` it to read it.

    Attributes
    ----------
    t, q, u
        The state.
    kind : ParadoxKind
        INCONSISTENT, REGULAR, INDETERMINATE; NOT_ENUMERATED where coupled contacts of which some rest are not decided.
    n_solutions : int
        Sets of forces: the product of those of the groups of contacts that G does not couple.
    is_complete : bool
        Whether no solution can be missing.
    solutions : tuple of SpatialSolution
        The first 256 of them.
    flags : ParadoxFlag
        PAINLEVE where p <= 0 for the present slip, at rest for some direction; P_ZERO, B_ZERO.
    mode : tuple of str
        What each contact does: "open", "resting", "sliding", "closed" (no friction).
    gamma_N : ndarray (n_c,), gamma_F : ndarray (n_c, 2)
        Contact velocities [m/s].
    direction : ndarray (n_c, 2)
        Unit vector of sliding; nan where the contact does not slide.
    mu : ndarray (n_c,)
        Friction coefficient at the present speed.
    b : ndarray (n_c,)
        Free normal acceleration [m/s^2]; nan where the contact is open.
    p : ndarray (n_c,)
        G_NN - mu G_NT d [1/kg] of a contact that slides along d alone; at rest G_NN - mu |G_NT|, the least of all
        directions; nan where it is open.
    contacts : tuple of str
        What the contacts are called.
    """

    t: float
    q: np.ndarray
    u: np.ndarray
    kind: ParadoxKind
    n_solutions: int
    is_complete: bool
    solutions: tuple[SpatialSolution, ...]
    flags: ParadoxFlag
    mode: tuple[str, ...]
    gamma_N: np.ndarray
    gamma_F: np.ndarray
    direction: np.ndarray
    mu: np.ndarray
    b: np.ndarray
    p: np.ndarray
    contacts: tuple[str, ...]

    def __str__(self) -> str:
        return view(self, "text")(self)

    def _repr_html_(self) -> str:
        return view(self, "html")(str(self))

    def __repr__(self) -> str:
        return (
            f"SpatialClassification({self.kind.name}, n_solutions={self.n_solutions}, is_complete={self.is_complete})"
        )

    def plot(self, path: str | Path | None = None, title: str = "") -> Any:
        """Draw the forces of every solution, |la_T| and la_N, in the friction cones of the contacts.

        Parameters
        ----------
        path : path-like, optional
            Where to save; the ending names the format.
        title : str
            What stands above; the kind by default.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return view(self, "plot")(self, path, title)

    def to_dict(self) -> dict[str, Any]:
        """Plain lists, numbers and strings."""
        return view(self, "dictionary")(self)


class Closed(NamedTuple):
    """The closed contacts of a state: contact k has rows start[k] to start[k + 1] of G and c."""

    system: System
    number: np.ndarray  # (n,) in the system
    start: np.ndarray
    G: np.ndarray
    c: np.ndarray
    d: np.ndarray  # (n, 2) unit vector of sliding; 0 where it rests, or has no friction
    mu: np.ndarray
    mu_static: np.ndarray
    N: np.ndarray  # given normal forces

    def normal(self, k: int) -> int:
        """Its row N."""
        return int(self.start[k])

    def rows(self, k: int) -> np.ndarray:
        """Its tangential rows."""
        return np.arange(self.start[k] + (0 if self.is_given(k) else 1), self.start[k + 1])

    def is_given(self, k: int) -> bool:
        """Whether its normal force is given."""
        return bool(self.system.kinds[self.number[k], 0] == GIVEN_FORCE)

    def friction(self, k: int) -> np.ndarray:
        """The forces of its rows for each newton of normal force, where it slides or has no friction."""
        tangential = -self.mu[k] * self.d[k, : len(self.rows(k))]
        return tangential if self.is_given(k) else np.concatenate([[1.0], tangential])

    def rests(self, k: int) -> bool:
        """Whether its friction does not know a direction."""
        return len(self.rows(k)) > 0 and not self.d[k].any()


Found = tuple[list[tuple[tuple[str, ...], np.ndarray]], bool]  # modes and forces by row, and whether that is all


def classify_in_space(
    system: System, t: float, q: np.ndarray, u: np.ndarray, tolerance: float
) -> SpatialClassification:
    """The classification of a state.

    Raises
    ------
    InvalidInput
        Where a contact penetrates or approaches, and where a model function wrote no number.
    """
    inspect_instant(system, t, q, u)
    gamma_N, gamma_F, situation = situations(system, t, q, u)
    sliding, n_c = situation == Situation.SLIDING, system.n_c
    speed = np.linalg.norm(gamma_F, axis=1)
    direction = np.where(sliding[:, None], gamma_F / np.where(speed > 0.0, speed, 1.0)[:, None], np.nan)
    mu = np.array([mu_of(system.laws, i, speed[i]) if system.kinds[i, 1] else 0.0 for i in range(n_c)])
    number = np.flatnonzero((situation == Situation.SLIDING) | (situation == Situation.RESTING))
    closed, X, free = problem_of(system, t, q, u, number, np.nan_to_num(direction), mu)
    b, p, flags = slopes(closed, tolerance)
    groups = [group(closed, members) for members in members_of(closed)]
    counts = [len(found) for found, _ in groups]
    n_solutions = math.prod(counts)
    is_complete = all(done for _, done in groups) or any(done and not found for found, done in groups)
    listed = itertools.islice(itertools.product(*(found for found, _ in groups)), MOST_LISTED)
    names = [MODES[Situation(kind)] for kind in situation]
    mode = [("closed" if not system.kinds[i, 1] and name == "resting" else name) for i, name in enumerate(names)]
    return SpatialClassification(
        t, q, u, kind_of(n_solutions, is_complete), n_solutions, is_complete,
        tuple(combined(closed, parts, X, free) for parts in listed), flags, tuple(mode), gamma_N, gamma_F, direction,
        mu, spread(b, number, n_c), spread(p, number, n_c), system.described.contacts,
    )  # fmt: skip


MODES = {Situation.OPEN: "open", Situation.RESTING: "resting", Situation.SLIDING: "sliding"}


def situations(system: System, t: float, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """gamma_N (n_c,), gamma_F (n_c, 2) and what each contact does."""
    g_N, gamma_N, size = contact_state(system, t, q, u)
    rows = evaluate(system, TANGENT, t, q, u) @ u + evaluate(system, SURFACE_VELOCITY, t, q, u)
    gamma_F = rows * (np.arange(system.d) < system.kinds[:, 1:])
    allowed = tolerate(*(float(np.abs(x).max(initial=0.0)) for x in (q, u, size)))
    found = np.array(
        [judge(kind, g_N[i], gamma_N[i], size[i], *allowed, False) for i, kind in enumerate(system.kinds[:, 0])]
    )
    names = system.described.contacts
    wrong = [WHY[Situation(kind)].format(name=names[i], g_N=g_N[i], depth=-g_N[i], gamma_N=gamma_N[i])
             for i, kind in enumerate(found) if kind in WHY]  # fmt: skip
    if wrong:
        raise InvalidInput(f"the state has no acceleration-level problem: {'; '.join(wrong)}")
    return gamma_N, gamma_F, found


def problem_of(
    system: System, t: float, q: np.ndarray, u: np.ndarray, number: np.ndarray, d: np.ndarray, mu: np.ndarray
) -> tuple[Closed, np.ndarray, np.ndarray]:
    """The problem of the closed contacts, X = W M^-1 and the accelerations without contact."""
    work, n = new(Work, **system.sizes), len(number)
    if n == 0:
        zero = np.zeros(0)
        return Closed(system, number, np.zeros(1, int), np.zeros((0, 0)), zero, d[:0], zero, zero, zero), \
            np.zeros((0, system.n_u)), free_motion(system, t, q, u)  # fmt: skip
    sys = new_sys(system, interpreted_model(system).handle, model_facts(system))
    work.closed[:n] = number
    with np.errstate(all="ignore"):
        status, r = set_up(sys, t, q, u, n, np.zeros((4, len(work.c))), work)
    if status != Status.RUNNING:
        raise InvalidInput(
            f"a model function wrote no finite number, or the mass matrix is not positive definite, at t = {t:g}"
        )
    static = np.array([static_mu_of(system.laws, i) if system.kinds[i, 1] else 0.0 for i in number])
    start, G, c = work.start[: n + 1].copy(), work.G[:r, :r].copy(), work.c[:r].copy()
    closed = Closed(system, number, start, G, c, d[number], mu[number], static, np.maximum(work.N[number], 0.0))
    return closed, work.X[:r].copy(), work.du.copy()


def slopes(closed: Closed, tolerance: float) -> tuple[np.ndarray, np.ndarray, ParadoxFlag]:
    """b and p of each closed contact, nan under a given force, and what they say."""
    n, flags = len(closed.number), ParadoxFlag(0)
    b, p = np.full(n, np.nan), np.full(n, np.nan)
    for k in range(n):
        if closed.is_given(k):
            continue
        N, T = closed.normal(k), closed.rows(k)
        tilt = closed.mu[k] * closed.G[N, T]
        along = np.linalg.norm(tilt) if closed.rests(k) else tilt @ closed.d[k, : len(T)]
        b[k], p[k] = closed.c[N], closed.G[N, N] - along
        is_p_zero = abs(p[k]) <= tolerance * (closed.G[N, N] + abs(along))
        flags |= ParadoxFlag.PAINLEVE if p[k] <= 0.0 or is_p_zero else ParadoxFlag(0)
        flags |= ParadoxFlag.P_ZERO if is_p_zero else ParadoxFlag(0)
        flags |= ParadoxFlag.B_ZERO if b[k] == 0.0 else ParadoxFlag(0)
    return b, p, flags


def members_of(closed: Closed) -> list[np.ndarray]:
    """The closed contacts in groups that G does not couple."""
    island = np.zeros(len(closed.number), np.int64)
    count = islands_of(len(closed.number), closed.start, closed.G, island) if len(island) else 0
    return [np.flatnonzero(island == m) for m in range(count)]


def group(closed: Closed, members: np.ndarray) -> Found:
    """All forces of contacts that are coupled."""
    if not any(closed.rests(k) for k in members):
        return of_slides(closed, members)
    if len(members) == 1 and not closed.is_given(members[0]):
        return of_one_at_rest(closed, int(members[0]))
    return [], False


def of_slides(closed: Closed, members: np.ndarray) -> Found:
    """Contacts that slide, or have no friction: a complementarity problem of their normal forces."""
    given = [k for k in members if closed.is_given(k)]
    free = [k for k in members if not closed.is_given(k)]
    unit = np.zeros((len(closed.c), len(members)))  # forces for each newton of normal force
    for m, k in enumerate(members):
        unit[closed.start[k] : closed.start[k + 1], m] = closed.friction(k)
    known = unit[:, [m for m, k in enumerate(members) if k in given]] @ closed.N[given]
    rows, columns = [closed.normal(k) for k in free], unit[:, [m for m, k in enumerate(members) if k in free]]
    if len(free) > MOST_SLIDING:
        return [], False
    b = (closed.c + closed.G @ known)[rows]
    size = (np.abs(closed.c) + np.abs(closed.G) @ np.abs(known))[rows]
    b[np.abs(b) <= rounding_of_sum(SLIDE_ROUNDINGS, size)] = 0.0
    faces = lcp_solutions((closed.G @ columns)[rows], b) if free else ()
    found = [
        (modes_of(closed, members, dict(zip(free, face.z, strict=True))), known + columns @ face.z) for face in faces
    ]
    return found if free else [(modes_of(closed, members, {}), known)], all(face.dimension == 0 for face in faces)


def modes_of(closed: Closed, members: np.ndarray, la_N: dict[int, float]) -> tuple[str, ...]:
    """What contacts that slide do under these normal forces."""
    moving = {k: "slide" if len(closed.rows(k)) else "closed" for k in members}
    return tuple("free" if la_N.get(k, 1.0) == 0.0 else moving[k] for k in members)


def of_one_at_rest(closed: Closed, k: int) -> Found:
    """Open, stick, and every slide of one contact."""
    own = np.concatenate([[closed.normal(k)], closed.rows(k)])
    modes, forces, is_complete = solutions_of_one(
        closed.G[np.ix_(own, own)], closed.c[own], closed.mu[k], closed.mu_static[k]
    )
    found: list[tuple[tuple[str, ...], np.ndarray]] = []
    for mode, force in zip(modes, forces, strict=True):
        la = np.zeros(len(closed.c))
        la[own] = force
        found.append(((mode,), la))
    return found, is_complete


def combined(closed: Closed, parts: tuple[tuple[tuple[str, ...], np.ndarray], ...], X: np.ndarray, free: np.ndarray
             ) -> SpatialSolution:  # fmt: skip
    """A solution of all contacts from one of each group."""
    rows = sum((la for _, la in parts), np.zeros(len(closed.c)))
    modes, forces = ["open"] * closed.system.n_c, np.zeros((closed.system.n_c, 3))
    for members, (names, _) in zip(members_of(closed), parts, strict=True):
        for k, name in zip(members, names, strict=True):
            i, T = closed.number[k], closed.rows(k)
            modes[i] = name
            forces[i, 0] = closed.N[k] if closed.is_given(k) else rows[closed.normal(k)]
            forces[i, 1 : 1 + len(T)] = rows[T]
    return SpatialSolution(tuple(modes), forces, free + X.T @ rows)


def spread(values: np.ndarray, number: np.ndarray, n_c: int) -> np.ndarray:
    """Values of the closed contacts, nan of the others."""
    found = np.full(n_c, np.nan)
    found[number] = values
    return found
