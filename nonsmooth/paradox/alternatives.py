"""Impacts without collision: the way out of a state by velocities that jump though nothing collides.

One unilateral contact that slides with p_s < 0: the impulse map of ``mechanics.impact``, and with friction in two
directions the hodograph of ``mechanics.impact_in_space``, under each law of impact. One bilateral contact: plastic,
both velocities zero, where sticking needs |P_F| <= mu |P_N|. Several closed contacts: laws that divide an impact into
compression and expansion are not defined; with Newton's law, gamma_N- = 0 makes

    gamma+ = G P + gamma-,    P != 0

the contact problem of the velocities, and each of its solutions is listed. What is struck is an island: those of
several islands are any combination. Source: docs/theory/painleve.md, (5) and (6).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nonsmooth.contact.planar.enumerate import Tree, enumerate_modes, leaves
from nonsmooth.contact.planar.forces import FORCES_KEPT, MAX_CONTACTS, MAX_MODES
from nonsmooth.contact.planar.problem import Planar, problem_of
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.impact import impulse_map
from nonsmooth.mechanics.impact_in_space import Hodograph, collide_in_space
from nonsmooth.mechanics.laws import LAWS_OF_ONE, ImpactLaw
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE
from nonsmooth.paradox.state_problem import Problem


@dataclass(frozen=True, eq=False)
class ImpactAlternative:
    """An impact without collision that a state admits.

    Attributes
    ----------
    law : ImpactLaw
    e : float
        Coefficient of restitution (of the law).
    P_N, P_F : ndarray (n_c,)
        Impulses [N s]; P_F (n_c, 2) with friction in two directions.
    u : ndarray (n_u,)
        Velocities after it.
    gamma_N, gamma_F : ndarray (n_c,)
        Contact velocities after it [m/s]; nan for open contacts; gamma_F (n_c, 2) with friction in two directions.
    """

    law: ImpactLaw
    e: float
    P_N: np.ndarray
    P_F: np.ndarray
    u: np.ndarray
    gamma_N: np.ndarray
    gamma_F: np.ndarray


class Impact(NamedTuple):
    """An impact of an island: its law, coefficient, and impulses (r,)."""

    law: ImpactLaw
    e: float
    P: np.ndarray


def impacts_without_collision(part: Problem, restitution: np.ndarray) -> tuple[Impact, ...] | None:
    """Every impact without collision of an island, ``restitution`` (n_c,); None where they were not sought."""
    if not any(slip != 0 and part.kind(k) != GIVEN_FORCE for k, slip in enumerate(part.slip)):
        return ()
    if len(part.closed) > 1:
        return impacts_of_several(part)
    return impacts_of_one(part, float(restitution[part.closed[0]]))


def impacts_of_one(part: Problem, e: float) -> tuple[Impact, ...]:
    """The impacts of the only contact of an island, where p < 0."""
    (G_NN, G_NF), (_, G_FF) = part.G
    gamma_F = part.gamma[part.closed[0], 1]
    mu, s = part.mu[0], part.slip[0]
    if part.kind(0) == BILATERAL:
        P = sticking_impulse(part.G, gamma_F)
        if P is None or not mu * abs(G_NF) > G_NN:
            return ()
        return (Impact(ImpactLaw.NEWTON, 0.0, P),)
    if not G_NN - s * mu * G_NF < 0.0:
        return ()
    found = []
    for law in LAWS_OF_ONE:
        P_N, P_F, _, _ = interpreted(impulse_map)(law, e, mu, G_NN, G_NF, G_FF, 0.0, gamma_F)
        if np.isfinite(P_N):
            found.append(Impact(law, e, np.array([P_N, P_F])))
    return tuple(found)


def sticking_impulse(G: np.ndarray, gamma_F: float) -> np.ndarray | None:
    """(P_N, P_F) that bring both velocities of a contact to zero; None where G is singular."""
    if not np.linalg.det(G) > 1e-12 * G[0, 0] * G[1, 1]:
        return None
    return -np.linalg.solve(G, np.array([0.0, gamma_F]))


def impacts_of_several(part: Problem) -> tuple[Impact, ...] | None:
    """Every solution P != 0 of the velocity-level problem with gamma_N- = 0; None where they are too many to try."""
    n, r = len(part.closed), len(part.c)
    kinds = np.ascontiguousarray(part.system.kinds[part.closed])
    if n > MAX_CONTACTS or interpreted(leaves)(n, kinds, MAX_MODES) > MAX_MODES:
        return None
    gamma = velocities(part)
    impulses = solve_velocities(part, kinds, gamma)
    largest = np.abs(gamma).max(initial=0.0) / np.diag(part.G).max()
    return tuple(Impact(ImpactLaw.NEWTON, 0.0, P[:r]) for P in impulses if np.abs(P).max() > 1e-9 * largest)


def solve_velocities(part: Problem, kinds: np.ndarray, gamma: np.ndarray) -> np.ndarray:
    """Every impulse P (m, r) with gamma+ = G P + gamma within the laws; redundant contacts are decided if need be."""
    n, r = len(part.closed), len(part.c)
    problem = problem_of(kinds, part.G, gamma, part.mu, part.mu_static)
    tree = new(Tree, n=n, r=r, kept=FORCES_KEPT)
    found, is_complete = enumerate_modes(problem.address, tree.address)
    if not is_complete:
        planar = new(Planar, n=n, d=1, kept=FORCES_KEPT)
        found, tree = enumerate_redundant(problem.address, part.G, planar.address), planar.tree
    return tree.solutions[: min(found, FORCES_KEPT)]


def velocities(problem: Problem) -> np.ndarray:
    """gamma- (r,) of the closed contacts, its normal part exactly zero."""
    gamma = np.zeros(len(problem.c))
    for k, i in enumerate(problem.closed):
        if problem.d(k) > 0:
            gamma[problem.start[k + 1] - 1] = problem.gamma[i, 1]
    return gamma


def outcome_of(problem: Problem, rows: np.ndarray, impact: Impact) -> ImpactAlternative:
    """Velocities of all contacts after the impulses of the rows of an island."""
    P = np.zeros(len(problem.c))
    P[rows] = impact.P
    P_N, P_F = problem.spread(P, 0.0)
    gamma_N, gamma_F = problem.spread(problem.rates(velocities(problem), P), np.nan)
    return ImpactAlternative(impact.law, impact.e, P_N, P_F, problem.u + problem.X.T @ P, gamma_N, gamma_F)


def impacts_in_space(problem: Problem, restitution: np.ndarray) -> tuple[ImpactAlternative, ...]:
    """Every impact without collision of a contact that slides in two directions with p < 0, coupled to no other."""
    found = []
    for island in range(len(problem.counts)):
        (k, *others), h = problem.members(island), new(Hodograph)
        i, first = problem.closed[k], problem.start[k]
        if others or problem.d(k) < 2 or problem.slip[k] == 0 or problem.kind(k) == GIVEN_FORCE:
            continue
        rows = slice(first, first + 3)
        h.mu, h.e, h.G[:] = problem.mu[k], restitution[i], problem.G[rows, rows]
        h.before[1] = np.linalg.norm(problem.gamma[i, 1:])
        if h.G[0, 0] - h.mu * h.G[0, 1] >= 0.0:
            continue
        for law in LAWS_OF_ONE:
            h.law = int(law)
            if collide_in_space(h.address):
                found.append(outcome_in_space(problem, k, h))
    return tuple(found)


def outcome_in_space(problem: Problem, k: int, h: Hodograph) -> ImpactAlternative:
    """Velocities after an impact of closed contact k, of which only it has a part."""
    i, n_c = problem.closed[k], problem.system.n_c
    d = problem.gamma[i, 1:] / h.before[1]
    axes = np.column_stack([d, [-d[1], d[0]]])  # along the slide, and to its left
    P_N, P_F = np.zeros(n_c), np.zeros((n_c, 2))
    P_N[i], P_F[i] = h.impulse[0], axes @ h.impulse[1:]
    gamma = np.full((n_c, 3), np.nan)
    gamma[problem.closed] = problem.gamma[problem.closed]
    gamma[i] = h.gamma[0], *(axes @ h.gamma[1:])
    u = problem.u + problem.X[problem.start[k] : problem.start[k] + 3].T @ h.impulse
    return ImpactAlternative(ImpactLaw(h.law), float(h.e), P_N, P_F, u, gamma[:, 0], gamma[:, 1:])
