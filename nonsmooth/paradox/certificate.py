"""Contacts that all slide, or have no friction: one linear complementarity problem, and when it has one solution.

    gamma_N' = P la_N + b,    0 <= la_N _|_ gamma_N' >= 0,    P = G_NN - G_NF diag(mu s)

has exactly one solution whatever the load iff P is a P-matrix. That is known without trying a single mode, and where
the modes are too many to be tried, Lemke's method then finds the solution. Source: Lötstedt, *ZAMM* 61 (1981) 605.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.contact.planar.single import FREE, SLIDE_MINUS, SLIDE_PLUS, STICK
from nonsmooth.lcp.p_matrix import is_p_matrix
from nonsmooth.lcp.result import LCPStatus
from nonsmooth.lcp.solve import solve_lcp
from nonsmooth.mechanics.system import UNILATERAL
from nonsmooth.paradox.state_problem import Problem


def sliding_matrix(problem: Problem) -> np.ndarray | None:
    """P (n, n) of the closed contacts; None unless all are unilateral, and slide or have no friction."""
    n = len(problem.closed)
    if n == 0 or any(problem.kind(k) != UNILATERAL or (problem.d(k) and not problem.slip[k]) for k in range(n)):
        return None
    N, T = problem.start[:-1], problem.start[1:] - 1
    return problem.G[np.ix_(N, N)] - problem.G[np.ix_(N, T)] * (problem.mu * problem.slip)


def is_always_regular(problem: Problem) -> bool | None:
    """Whether these contacts have one solution for every load; None where that is not known."""
    P = sliding_matrix(problem)
    return None if P is None else is_p_matrix(P)


def solve_sliding(problem: Problem) -> tuple[np.ndarray, np.ndarray] | None:
    """One solution (modes (n,), forces (r,)) of contacts that all slide; None if there is none to be found."""
    P = sliding_matrix(problem)
    if P is None:
        return None
    N, T = problem.start[:-1], problem.start[1:] - 1
    result = solve_lcp(P, problem.c[N])
    if result.status != LCPStatus.SOLVED:
        return None
    la = np.zeros(len(problem.c))
    la[N] = result.z
    has_friction = N != T
    la[T[has_friction]] = (-problem.slip * problem.mu * result.z)[has_friction]
    slides = np.where(problem.slip > 0, SLIDE_PLUS, np.where(problem.slip < 0, SLIDE_MINUS, STICK))
    return np.where(result.z > 0, slides, FREE), la
