"""Solutions whose equations are singular: redundant contacts.

With the modes given, the forces follow from equations A x = -c_a, the motion from the forces. Where A is singular the
walk of ``contact_solvers.modes`` cuts the branch. Here every combination of modes is tried; a singular one has a
solution iff the linear programme

    max t   subject to   A x = -c_a,   every inequality of the modes holds with the margin t >= 0

is feasible. Its x is then one choice among the forces that give this motion (of a block on two rough corners at rest
only the sum of the friction forces is determined). Source: Boyd, Vandenberghe, *Convex Optimization* (2004), section
8.5.1.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from nonsmooth.contact_solvers.modes import SAME_MOTION
from nonsmooth.contact_solvers.single import FREE, PULL_MINUS, PULL_PLUS, SLIDE_MINUS, SLIDE_PLUS, STICK
from nonsmooth.paradox.state_problem import Problem
from nonsmooth.system import BILATERAL, GIVEN_FORCE, UNILATERAL

MAX_COMBINATIONS = 5000  # about a second of linear programmes
STICK_PULLED = PULL_MINUS + 1  # sticking with la_N < 0: the cone of a bilateral contact is two convex ones
ACCEPTED = 1e-10  # of the scale of c: slack of an inequality


class Answer(NamedTuple):
    """A solution of one combination of modes."""

    candidate: np.ndarray  # (n,)
    la: np.ndarray  # (r,)
    is_unique_force: bool


def every_combination(problem: Problem) -> list[Answer] | None:
    """The solutions of all combinations of modes, each motion once; None where there are too many to try."""
    n = len(problem.closed)
    choices = [candidates(problem, k) for k in range(n)]
    if math.prod(len(choice) for choice in choices) > MAX_COMBINATIONS:
        return None
    answers: list[Answer] = []
    motions: list[np.ndarray] = []
    scale = max(np.abs(problem.c).max(), 1e-300)
    for candidate in itertools.product(*choices):
        answer = solve_modes(problem, candidate, scale)
        if answer is None:
            continue
        motion = problem.G @ answer.la + problem.c
        if any(np.abs(motion - other).max() <= SAME_MOTION * scale for other in motions):
            continue
        motions.append(motion)
        answers.append(answer)
    return answers


def candidates(problem: Problem, k: int) -> tuple[int, ...]:
    """The modes that the closed contact k may have."""
    kind, s = problem.kind(k), problem.slip[k]
    free = (FREE,) if kind == UNILATERAL else ()
    if problem.d(k) == 0:
        return (*free, STICK)
    pull = kind == BILATERAL
    if s != 0:
        slides = ((SLIDE_PLUS, PULL_PLUS) if s > 0 else (SLIDE_MINUS, PULL_MINUS))[: 2 if pull else 1]
        return (*free, *slides)
    pulled = (STICK_PULLED, PULL_PLUS, PULL_MINUS) if pull else ()
    return (*free, STICK, SLIDE_PLUS, SLIDE_MINUS, *pulled)


class Modes(NamedTuple):
    """The conditions of one combination of modes: la = E x + e, gamma'[active] = 0, D la + F gamma' + f >= 0."""

    E: np.ndarray  # (r, m)
    e: np.ndarray  # (r,)
    active: np.ndarray  # (m,)
    D: np.ndarray  # (j, r)
    F: np.ndarray  # (j, r)
    f: np.ndarray  # (j,)


def conditions(problem: Problem, candidate: tuple[int, ...]) -> Modes:
    """Write out the modes of all closed contacts."""
    r = len(problem.c)
    unit = np.eye(r)
    columns: list[np.ndarray] = []
    active: list[int] = []
    rows: list[tuple[np.ndarray, np.ndarray, float]] = []
    e, zero = np.zeros(r), np.zeros(r)
    for k, mode in enumerate(candidate):
        N, T = problem.start[k], problem.start[k + 1] - 1
        is_given = problem.kind(k) == GIVEN_FORCE
        s = 1 if mode in (SLIDE_PLUS, PULL_PLUS) else -1
        sigma = -1 if mode in (PULL_PLUS, PULL_MINUS, STICK_PULLED) else 1
        if mode == FREE:
            rows.append((zero, unit[N], 0.0))
            continue
        if mode in (STICK, STICK_PULLED):
            columns += [unit[j] for j in range(N, T + 1)]
            active += range(N, T + 1)
            if problem.d(k) > 0:
                for side in (-1.0, 1.0):
                    hold = problem.mu_static[k] * (0.0 if is_given else sigma) * unit[N] - side * unit[T]
                    rows.append((hold, zero, problem.mu_static[k] * problem.normal[k] if is_given else 0.0))
        elif is_given:
            e[T] = -s * problem.mu[k] * problem.normal[k]
        else:
            columns.append(unit[N] - s * problem.mu[k] * sigma * unit[T])
            active.append(N)
        if mode not in (STICK, STICK_PULLED) and problem.slip[k] == 0:
            rows.append((zero, s * unit[T], 0.0))
        if not is_given and not (problem.kind(k) == BILATERAL and problem.d(k) == 0):
            rows.append((sigma * unit[N], zero, 0.0))
    E = np.array(columns).reshape(-1, r).T
    D, F, f = (np.array([row[j] for row in rows]) for j in range(3))
    return Modes(E, e, np.array(active, dtype=int), D.reshape(-1, r), F.reshape(-1, r), f)


def solve_modes(problem: Problem, candidate: tuple[int, ...], scale: float) -> Answer | None:
    """Forces that fit one combination of modes, or None. ``scale`` is that of c."""
    G, modes = problem.G, conditions(problem, candidate)
    unit = scale / np.diag(G).max()  # of force
    A = G[modes.active] @ modes.E * unit / scale
    free = problem.c + G @ modes.e
    b = -free[modes.active] / scale
    # margins = B x + d, forces relative to ``unit``, accelerations to ``scale``
    B = modes.D @ modes.E + modes.F @ G @ modes.E * unit / scale
    d = (modes.D @ modes.e + modes.f) / unit + modes.F @ free / scale
    x, is_unique = np.zeros(0), True
    if len(b) > 0:
        singular_values = np.linalg.svd(A, compute_uv=False)
        is_unique = bool(singular_values[-1] > 1e-12 * singular_values[0])
        answer = np.linalg.solve(A, b) if is_unique else widest_margin(A, b, B, d)
        if answer is None:
            return None
        x = answer
    if (B @ x + d < -ACCEPTED * (1 + np.abs(x).max(initial=0.0))).any():
        return None
    named = tuple(STICK if mode == STICK_PULLED else mode for mode in candidate)
    return Answer(np.array(named), unit * modes.E @ x + modes.e, is_unique)


def widest_margin(A: np.ndarray, b: np.ndarray, B: np.ndarray, d: np.ndarray) -> np.ndarray | None:
    """x of: max t subject to A x = b, B x + d >= t, 0 <= t <= 1; None where there is none."""
    from scipy.optimize import linprog

    x = np.linalg.lstsq(A, b, rcond=1e-12)[0]
    if np.abs(A @ x - b).max() > SAME_MOTION * max(np.abs(b).max(), 1e-300):
        return None
    # The equations are kept on their range, where their right-hand side lies exactly.
    U, values, Vt = np.linalg.svd(A)
    rank = int((values > 1e-12 * values[0]).sum())
    equations, right = Vt[:rank], (U.T @ b)[:rank] / values[:rank]
    n = len(b)
    answer = linprog(
        np.append(np.zeros(n), -1.0),
        A_ub=np.column_stack([-B, np.ones(len(B))]) if len(B) else None, b_ub=d if len(B) else None,
        A_eq=np.column_stack([equations, np.zeros(rank)]) if rank else None, b_eq=right if rank else None,
        bounds=[(None, None)] * n + [(0.0, 1.0)], method="highs",
    )  # fmt: skip
    return answer.x[:n] if answer.status == 0 else None
