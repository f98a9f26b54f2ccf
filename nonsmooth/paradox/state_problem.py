"""The contact problem of a state as plain arrays: what ``classify`` reads once the compiled search has run.

gamma' = G la + c,    u' = du + X^T la,    X = W M^-1,    du = M^-1 h
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace

import numpy as np

from nonsmooth.contact.planar.enumerate import enumerate_modes
from nonsmooth.contact.planar.forces import Forces, Outcome, forces_at_state
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.errors import InvalidInput
from nonsmooth.jit import interpreted, load_all
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.compiled import model_of
from nonsmooth.mechanics.contact_problem import model_facts
from nonsmooth.mechanics.inspection import inspect_instant
from nonsmooth.mechanics.situation import CONTRADICTIONS, Situation
from nonsmooth.mechanics.sys import new_sys
from nonsmooth.mechanics.system import FORCE, GIVEN_FORCE, MASS, System
from nonsmooth.numerics.rounding import rounding_of_sum

STATE_ROUNDINGS = 900  # chosen: of the terms of a sum: a smaller sum is zero
_memory = threading.local()
ENTRY_POINTS = (enumerate_modes, forces_at_state)  # what a search may reach, but for redundant contacts
WHY = CONTRADICTIONS | {
    Situation.LANDING: "contact {i} approaches with gamma_N = {gamma_N:g} m/s: an impact comes first; classify the "
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


def problem_at(system: System, t: float, q: np.ndarray, u: np.ndarray) -> Problem:
    """Assemble the problem of a state and enumerate its solutions.

    Raises
    ------
    InvalidInput
        Where a contact lands, penetrates or is violated, and where a model function wrote NaN.
    """
    model = model_of(system)
    inspect_instant(system, t, q, u, model)
    has = model_facts(system)
    arrays = kept_block(has, system.n_u, system.n_c, system.d)
    sys = new_sys(system, model.handle, has)
    search = forces_at_state if model.is_compiled else interpreted(forces_at_state)
    if model.is_compiled:
        load_all(ENTRY_POINTS)
    handles = (sys.address, arrays.address) if model.is_compiled else (sys, arrays)
    outcome, _, n, r = search(handles[0], t, q, u, handles[1])
    islands = int(arrays.island[:n].max(initial=-1)) + 1
    if (arrays.outcome[:islands] == Outcome.SINGULAR).any():
        decide_redundant(arrays, model.is_compiled)
        outcome, _, n, r = search(handles[0], t, q, u, handles[1])
    if outcome == Outcome.INADMISSIBLE:
        raise InvalidInput(f"the state has no acceleration-level problem: {'; '.join(_reasons(arrays))}")
    if outcome == Outcome.NOT_FINITE:
        raise InvalidInput(f"a model function raised, or the mass matrix is not positive definite, at t = {t:g}")
    work = arrays.work
    kept = int(arrays.number[:islands].max(initial=0))
    c, W, du = work.c[:r].copy(), work.W[:r], work.du if n else free_motion(system, t, q, u)
    if not (np.isfinite(c).all() and np.isfinite(work.G[:r, :r]).all() and np.isfinite(du).all()):
        raise InvalidInput(f"a model function wrote a number that is not finite at t = {t:g}, q = {q}, u = {u}")
    return Problem(
        system, q, u, arrays.situation[: system.n_c].copy(),
        arrays.gamma[: system.n_c].copy(), work.closed[:n].copy(), work.start[: n + 1].copy(),
        arrays.slip[:n].copy(), arrays.mu[:n].copy(), arrays.mu_static[:n].copy(), arrays.normal[:n].copy(),
        work.G[:r, :r].copy(), c, np.abs(W) @ np.abs(du) + np.abs(work.gamma_0[:r]), work.X[:r].copy(), du.copy(),
        arrays.candidate[:kept, :n].copy(), arrays.la[:kept, :r].copy(),
        arrays.island[:n].copy(), arrays.outcome[:islands].copy(), arrays.number[:islands].copy(),
    )  # fmt: skip


def kept_block(has: int, n: int, n_c: int, d: int) -> Forces:
    """The thread's memory for systems with these functions and sizes; making it anew takes longer than the search.

    What a function of the system writes is written in every search; what no function writes stays zero.
    """
    blocks = _memory.__dict__.setdefault("blocks", {})
    if (has, n, n_c, d) not in blocks:
        blocks[has, n, n_c, d] = new(Forces, n=n, n_c=n_c, d=d)
    return blocks[has, n, n_c, d]


def decide_redundant(arrays: Forces, is_compiled: bool) -> None:
    """Let a search decide modes with singular equations; compiled when first met."""
    if is_compiled:
        enumerate_redundant.load()
    arrays.planar.can_decide_redundant = 1


def free_motion(system: System, t: float, q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """M^-1 h, where no contact is closed."""
    return np.linalg.solve(system.evaluate(MASS, t, q, u), system.evaluate(FORCE, t, q, u))


def _reasons(arrays: Forces) -> list[str]:
    return [
        WHY[Situation(situation)].format(
            i=i, g_N=arrays.work.g_N[i], depth=-arrays.work.g_N[i], gamma_N=arrays.gamma[i, 0]
        )
        for i, situation in enumerate(arrays.situation)
        if situation in WHY
    ]
