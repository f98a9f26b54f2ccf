"""Alternating directions with an adaptive penalty: one linear system and one projection on the cones an iteration.

    (G + beta I) P = beta (Z - U) - c - s        Z = proj_K(P + U),  U <- U + P - Z,  s_i = mu_i |beta U_T,i| e_N

beta U tends to -uhat, so s carries the term mu |gamma_T| that makes the convex problem Coulomb's. One factorisation
serves until beta is changed to balance |P - Z| against |Z - Z_previous|. It needs no full rank and stands large
numbers of redundant contacts.

Source: Boyd et al., Found. Trends Mach. Learn. 3 (2011) 1-122, sections 3.4.1 and 3.4.3; Tasora, Mangoni, Benatti and
Garziera, Int. J. Numer. Methods Eng. 122 (2021) 4093-4113.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from nonsmooth.contact.blocks.linear import factorise
from nonsmooth.contact.blocks.natural_map import cone_project
from nonsmooth.contact.blocks.problem import Problem
from nonsmooth.jit import kernel


@dataclass(frozen=True)
class ADMM:
    """Options of the alternating direction method.

    Parameters
    ----------
    beta : float
        First penalty, in units of the mean diagonal [-].
    relaxation : float
        Over-relaxation in [1, 2) [-].
    max_iterations : int
        Iterations after which the best iterate is returned.
    """

    beta: float = 0.05
    relaxation: float = 1.6
    max_iterations: int = 3000

    name = "admm"

    def run(self, problem: Problem, P: np.ndarray, tol: float, until: float = math.inf) -> tuple[np.ndarray, int]:
        """Iterate from P; returns the best iterate found and the number of iterations."""
        beta, dim = self.beta, problem.dim
        solve = _shifted_solve(problem, beta)
        Z, U = P.copy(), -_uhat(problem, P) / beta
        best, least = P, problem.error(P)
        for count in range(1, self.max_iterations + 1):
            if solve is None or time.monotonic() >= until:
                return best, count
            s = np.zeros((problem.n_c, dim))
            s[:, 0] = problem.mu * np.linalg.norm(beta * U.reshape(-1, dim)[:, 1:], axis=1)
            x = solve(beta * (Z - U) - problem.c - s.ravel())
            x = self.relaxation * x + (1.0 - self.relaxation) * Z
            before = Z
            Z = x + U
            project(problem.mu, dim, Z)
            U = U + x - Z
            if count % 5 == 0 or count == self.max_iterations:
                error = problem.error(Z)
                if error < least:
                    best, least = Z, error
                if least <= tol or not np.isfinite(error):
                    return best, count
            if count in (10, 20, 40, 80, 160, 320, 640):
                ratio = np.linalg.norm(x - Z) / max(np.linalg.norm(Z - before), np.finfo(float).tiny)
                factor = float(np.clip(np.sqrt(ratio), 0.1, 10.0))
                if not 0.5 < factor < 2.0:
                    beta, U = beta * factor, U / factor
                    solve = _shifted_solve(problem, beta)
        return best, self.max_iterations


def _shifted_solve(problem: Problem, beta: float):  # type: ignore[no-untyped-def]
    identity = np.broadcast_to(np.eye(problem.dim), (problem.n_c, problem.dim, problem.dim)).copy()
    return factorise(problem.blocks, beta * identity, identity, keeps_diagonal=True)


def _uhat(problem: Problem, P: np.ndarray) -> np.ndarray:
    gamma = problem.velocity(P).reshape(-1, problem.dim)
    gamma[:, 0] += problem.mu * np.linalg.norm(gamma[:, 1:], axis=1)
    return gamma.ravel()


@kernel("void(float64[::1], int64, float64[::1])", takes_arrays=True)
def project(mu, dim, x):
    """Project every contact of x on its friction cone, in place."""
    for i in range(mu.shape[0]):
        k = i * dim
        x_N, x_1, x_2 = cone_project(mu[i], x[k], x[k + 1], x[k + 2] if dim == 3 else 0.0)
        x[k] = x_N
        x[k + 1] = x_1
        if dim == 3:
            x[k + 2] = x_2
