"""The contact problem of a state as plain arrays: what ``classify`` reads once the compiled search has run.

gamma' = G la + c,    u' = du + X^T la,    X = W M^-1,    du = M^-1 h
"""

from __future__ import annotations

import os
import threading
import weakref
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from nonsmooth.contact.planar.enumerate import enumerate_modes
from nonsmooth.contact.planar.forces import FORCES_KEPT, Forces, Outcome, forces_at_state
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.contact.spatial.forces import SpatialForces, forces_in_space
from nonsmooth.errors import InvalidInput
from nonsmooth.jit import Kernel, interpreted, load_all
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.acceleration_problem import acceleration_problem_apart
from nonsmooth.mechanics.compiled import Model, model_of
from nonsmooth.mechanics.contact_problem import model_facts
from nonsmooth.mechanics.inspection import inspect_instant
from nonsmooth.mechanics.situation import CONTRADICTIONS, Situation
from nonsmooth.mechanics.sys import fill_numbers, new_sys
from nonsmooth.mechanics.system import FORCE, GIVEN_FORCE, MASS, System
from nonsmooth.numerics.rounding import rounding_of_sum

STATE_ROUNDINGS = 900  # chosen: of the terms of a sum: a smaller sum is zero
_memory = threading.local()
WHY = CONTRADICTIONS | {
    Situation.LANDING: "{name} approaches with gamma_N = {gamma_N:g} m/s: an impact comes first; classify the "
    "state after it",
}


@dataclass(frozen=True, eq=False)
class Problem:
    """The acceleration-level problem of a state, or of an island of its contacts, and the solutions that were
    enumerated. n = closed contacts, r = rows.

    Attributes
    ----------
    G, c, X, du
        See above; ``c_scale`` (r,) is the size of the terms that c is the sum of.
    closed : (n,) the closed contacts; start : (n + 1,) their first rows.
    slip, mu, mu_static, normal, island : (n,)
    candidate : (m, n) modes; la : (m, r) forces of the solutions kept, each contact's those of its island.
    outcomes, counts : (islands,)
        How far the search went, and the number of solutions enumerated.
    """

    system: System
    q: np.ndarray
    u: np.ndarray
    situation: np.ndarray
    gamma: np.ndarray
    closed: np.ndarray
    start: np.ndarray
    slip: np.ndarray
    mu: np.ndarray
    mu_static: np.ndarray
    normal: np.ndarray
    G: np.ndarray
    c: np.ndarray
    c_scale: np.ndarray
    X: np.ndarray
    du: np.ndarray
    candidate: np.ndarray
    la: np.ndarray
    island: np.ndarray
    outcomes: np.ndarray
    counts: np.ndarray

    def members(self, island: int) -> np.ndarray:
        """The places of an island's contacts among the closed ones."""
        return np.flatnonzero(self.island == island)

    def rows(self, members: np.ndarray) -> np.ndarray:
        """The rows of some of the closed contacts."""
        return np.concatenate([np.arange(self.start[k], self.start[k + 1]) for k in members])

    def part(self, island: int) -> Problem:
        """The problem of one island; the friction of slides under a given force elsewhere acts on it."""
        members = self.members(island)
        rows = self.rows(members)
        given = np.zeros(len(self.c))
        for k in range(len(self.closed)):
            if self.slip[k] != 0 and self.kind(k) == GIVEN_FORCE and self.island[k] != island:
                given[self.start[k]] = -self.slip[k] * self.mu[k] * self.normal[k]
        widths = (self.start[1:] - self.start[:-1])[members]
        kept = min(int(self.counts[island]), len(self.la))
        of_contact = {name: getattr(self, name)[members] for name in ("closed", "slip", "mu", "mu_static", "normal")}
        return replace(
            self, **of_contact, start=np.concatenate(([0], np.cumsum(widths))), G=self.G[np.ix_(rows, rows)].copy(),
            c=(self.c + self.G @ given)[rows], c_scale=self.c_scale[rows], X=self.X[rows],
            candidate=self.candidate[:kept, members], la=self.la[:kept, rows], island=np.zeros(len(members), int),
            outcomes=self.outcomes[[island]], counts=self.counts[[island]],
        )  # fmt: skip

    def kind(self, k: int) -> int:
        """Kind of the closed contact k."""
        return int(self.system.kinds[self.closed[k], 0])

    def d(self, k: int) -> int:
        """Directions of friction of the closed contact k."""
        return int(self.system.kinds[self.closed[k], 1])

    def rates(self, free: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """free + G rows, what cancels to rounding set to exactly zero."""
        change = self.G @ rows
        size = np.abs(free) + np.abs(self.G) @ np.abs(rows)
        return np.where(np.abs(free + change) <= rounding_of_sum(STATE_ROUNDINGS, size), 0.0, free + change)

    def spread(self, rows: np.ndarray, absent: float) -> tuple[np.ndarray, np.ndarray]:
        """Values of the rows (r,) as normal and tangential parts (n_c,) each; ``absent`` where there is no row."""
        normal, tangential = np.full(self.system.n_c, absent), np.full(self.system.n_c, absent)
        for k, i in enumerate(self.closed):
            if self.kind(k) != GIVEN_FORCE:
                normal[i] = rows[self.start[k]]
            if self.d(k) > 0:
                tangential[i] = rows[self.start[k + 1] - 1]
        return normal, tangential

    def mu_of_contacts(self) -> np.ndarray:
        """mu (n_c,) at the present speeds; nan where a contact is open."""
        mu = np.full(self.system.n_c, np.nan)
        mu[self.closed] = self.mu
        return mu


class Found(NamedTuple):
    """What a search left behind, copied from the memory that it used: as little as says the number of solutions at once
    and all else when it is asked for. n = closed contacts, r = rows."""

    system: System
    q: np.ndarray
    u: np.ndarray
    outcome: int  # of the island that was least complete
    total: int  # solutions of all islands
    n: int
    r: int
    of_islands: tuple[np.ndarray, ...]  # outcome, number
    of_contacts: tuple[np.ndarray, ...]  # island, closed, slip, mu, mu_static, normal; start (n + 1,)
    of_all: tuple[np.ndarray, ...]  # situation, gamma
    equations: tuple[np.ndarray, ...]  # G, c, gamma_0, W, X, du
    solutions: tuple[np.ndarray, ...]  # candidate, la

    @property
    def is_listed(self) -> bool:
        """Whether every solution is among those kept."""
        return self.outcome == Outcome.COMPLETE and self.total <= FORCES_KEPT

    def problem(self) -> Problem:
        """The problem as plain arrays of their own sizes."""
        n, r, n_c = self.n, self.r, self.system.n_c
        island, closed, slip, mu, mu_static, normal = (column[:n] for column in self.of_contacts[:-1])
        G, c, gamma_0, W, X, du = self.equations
        c_scale = np.abs(W[:r]) @ np.abs(du) + np.abs(gamma_0[:r])
        candidate, la = self.solutions
        return Problem(
            self.system, self.q, self.u, self.of_all[0][:n_c], self.of_all[1][:n_c], closed,
            self.of_contacts[-1][: n + 1], slip, mu, mu_static, normal, G[:r, :r].copy(), c[:r].copy(), c_scale,
            X[:r].copy(), du, candidate[:, :n], la[:, :r], island, *self.of_islands,
        )  # fmt: skip


class Desk:
    """What a thread searches with for forces of one system, again and again: making it anew takes longer."""

    def __init__(self, system: System, model: Model) -> None:
        has = model_facts(system)
        self.model, self.arrays = model, kept_block(has, system)
        self.sys = new_sys(system, model.handle, has)
        search = search_of(system)
        if model.is_compiled:
            load_all(entry_points(system))
        self._search = search.compiled if model.is_compiled else interpreted(search)
        blocks = self.sys, self.arrays
        self._sys, self._arrays = [block.address if model.is_compiled else block for block in blocks]

    def search(self, t: float, q: np.ndarray, u: np.ndarray) -> tuple[int, int, int, int]:
        """All forces at a state into the arrays: (Outcome, solutions, closed contacts, rows)."""
        outcome, total, n, r = self._search(self._sys, t, q, u, self._arrays)
        return int(outcome), int(total), int(n), int(r)  # the interpreter has NumPy's


def search_of(system: System) -> Kernel:
    """The search for the forces of a state, by the directions of friction."""
    return forces_in_space if system.d > 1 else forces_at_state


def entry_points(system: System) -> tuple[Kernel, ...]:
    """What a search may reach, but for redundant contacts."""
    return enumerate_modes, search_of(system), acceleration_problem_apart


def new_forces(system: System, **others: int) -> Forces:
    """The memory of a search."""
    return new(SpatialForces if system.d > 1 else Forces, **system.sizes, **others)


def desk_of(system: System) -> Desk:
    """The desk of a system in this thread; a new one where its machine code is another."""
    desks = _memory.__dict__.setdefault("desks", weakref.WeakKeyDictionary())
    desk = desks.get(system)
    if desk is None or not desk.model.is_current or os.environ.get("NONSMOOTH_INTERPRET") == "1":
        model = model_of(system)
        desk = Desk(system, model)
        if model.is_compiled:
            desks[system] = desk
    elif system.own_laws:  # whose code may be another than before
        fill_numbers(desk.sys, system)
    return desk  # type: ignore[no-any-return]


def forces_found(system: System, t: float, q: np.ndarray, u: np.ndarray) -> Found:
    """Assemble the problem of a state and enumerate its solutions.

    Raises
    ------
    InvalidInput
        Where a contact lands, penetrates or is violated, and where a model function wrote NaN.
    """
    desk = desk_of(system)
    inspect_instant(system, t, q, u, desk.model)
    arrays, work = desk.arrays, desk.arrays.work
    outcome, total, n, r = desk.search(t, q, u)
    islands = max(arrays.island[:n].tolist(), default=-1) + 1
    if outcome != Outcome.COMPLETE and (arrays.outcome[:islands] == Outcome.SINGULAR).any():
        decide_redundant(arrays, desk.model.is_compiled)
        outcome, total, n, r = desk.search(t, q, u)
    if outcome == Outcome.INADMISSIBLE:
        raise InvalidInput(f"the state has no acceleration-level problem: {'; '.join(_reasons(arrays, system))}")
    if outcome == Outcome.NOT_FINITE:
        raise InvalidInput(f"a model function raised, or the mass matrix is not positive definite, at t = {t:g}")
    du = work.du.copy() if n else free_motion(system, t, q, u)
    number = arrays.number[:islands].copy()
    kept = max(number.tolist(), default=0)
    return Found(
        system, q.copy(), u.copy(), outcome, total, n, r, (arrays.outcome[:islands].copy(), number),
        tuple([column.copy() for column in (
            arrays.island, work.closed, arrays.slip, arrays.mu, arrays.mu_static, arrays.normal, work.start)]),
        (arrays.situation.copy(), arrays.gamma.copy()),
        tuple([part.copy() for part in (work.G, work.c, work.gamma_0, work.W, work.X)]) + (du,),
        (arrays.candidate[:kept].copy(), arrays.la[:kept].copy()),
    )  # fmt: skip


def kept_block(has: int, system: System) -> Forces:
    """The thread's memory for systems with these functions and sizes; making it anew takes longer than the search.

    What a function of the system writes is written in every search; what no function writes stays zero.
    """
    blocks = _memory.__dict__.setdefault("blocks", {})
    key = has, *system.sizes.values()
    if key not in blocks:
        blocks[key] = new_forces(system)
    return blocks[key]


def decide_redundant(arrays: Forces, is_compiled: bool) -> None:
    """Let a search decide modes with singular equations; compiled when first met."""
    if is_compiled:
        enumerate_redundant.load()
    arrays.planar.can_decide_redundant = 1


def free_motion(system: System, t: float, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """M^-1 h, where no contact is closed."""
    du = np.linalg.solve(system.evaluate(MASS, t, q, u), system.evaluate(FORCE, t, q, u))
    if not np.isfinite(du).all():
        raise InvalidInput(f"a model function wrote a number that is not finite at t = {t:g}, q = {q}, u = {u}")
    return du


def _reasons(arrays: Forces, system: System) -> list[str]:
    names = system.described.contacts
    return [
        WHY[Situation(situation)].format(
            name=names[i], g_N=arrays.work.g_N[i], depth=-arrays.work.g_N[i], gamma_N=arrays.gamma[i, 0]
        )
        for i, situation in enumerate(arrays.situation)
        if situation in WHY
    ]
