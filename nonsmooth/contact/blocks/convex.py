"""Convex programming inside a fixed point on the sliding speed.

    P_k+1 = argmin  1/2 P^T S P + P^T (c + s_k + R P_k)   subject to |P_T| <= mu P_N
    s_k,i = mu_i |gamma_T,i(P_k)| e_N,    S = (G + G^T) / 2,  R = (G - G^T) / 2

With one pass (``passes = 1``, s = 0) this is the convex relaxation, in which a sliding contact opens at speed
mu |gamma_T|: it is Coulomb's law only where mu = 0 or nothing slides. A fixed point of the passes is Coulomb's law; the
passes need not converge where mu is large. In the plane the cone is two half-planes and a quadratic program is solved
through qpsolvers (osqp); in space a second-order cone program by clarabel, as qpsolvers has none. G must be positive
semidefinite. Never use a relaxation to count or classify solutions.

Source: Acary, Cadoux, Lemarechal and Malick, Z. Angew. Math. Mech. 91 (2011) 155-175.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.contact.blocks.problem import Problem, as_matrix
from nonsmooth.errors import InvalidInput, MissingExtra
from nonsmooth.numerics.quadratic_program import minimise

# chosen: of the norm of G: matrices that were stored in single precision still count as semidefinite
SINGLE_PRECISION = 1e-7


@dataclass(frozen=True)
class Convex:
    """Options of the convex route.

    Parameters
    ----------
    passes : int
        Convex programs solved; 1 is the plain convex relaxation.
    """

    passes: int = 100

    name = "convex"

    def __post_init__(self) -> None:
        if self.passes < 1:
            raise InvalidInput(f"passes must be at least 1; got {self.passes}")

    def run(self, problem: Problem, P: np.ndarray, tol: float) -> tuple[np.ndarray, int]:
        """Start with the sliding speeds at P; returns the best iterate and the number of convex programs."""
        G = as_matrix(problem.blocks)
        S, R = 0.5 * (G + G.T), 0.5 * (G - G.T)
        if (lowest := float(np.linalg.eigvalsh(S)[0])) < -SINGLE_PRECISION * float(np.linalg.norm(S)):
            raise InvalidInput(
                f"G must be positive semidefinite for the convex route; its symmetric part has the eigenvalue "
                f"{lowest:.3g} (in scaled units); use solver='auto'"
            )
        solve = _planar if problem.dim == 2 else _spatial
        best, least = P, problem.error(P)
        for count in range(1, self.passes + 1):
            shift = np.zeros((problem.n_c, problem.dim))
            if self.passes > 1:
                gamma = problem.velocity(P).reshape(-1, problem.dim)
                shift[:, 0] = problem.mu * np.linalg.norm(gamma[:, 1:], axis=1)
            trial = solve(S, problem.c + shift.ravel() + R @ P, problem.mu, P)
            if trial is None:
                return best, count
            P, error = trial, problem.error(trial)
            if error < least:
                best, least = P, error
            if least <= tol:
                return best, count
        return best, self.passes


def _planar(S: np.ndarray, c: np.ndarray, mu: np.ndarray, P: np.ndarray) -> np.ndarray | None:
    i = np.arange(mu.shape[0])
    rows = np.zeros((2, mu.shape[0], c.shape[0]))
    rows[:, i, 2 * i] = -mu
    rows[0, i, 2 * i + 1], rows[1, i, 2 * i + 1] = 1.0, -1.0
    normal = np.zeros((mu.shape[0], c.shape[0]))
    normal[i, 2 * i] = -1.0  # where mu = 0 the cone's rows leave P_N free
    cone = np.vstack([rows.reshape(-1, c.shape[0]), normal])
    return minimise(S, c, cone, np.zeros(cone.shape[0]), guess=P)


def _spatial(S: np.ndarray, c: np.ndarray, mu: np.ndarray, P: np.ndarray) -> np.ndarray | None:
    from scipy.sparse import csc_matrix, diags

    clarabel = _clarabel()
    factors = np.ones(c.shape[0])
    factors[::3] = mu  # (mu P_N, P_T) lies in the round cone of slope one
    cones = [clarabel.SecondOrderConeT(3)] * mu.shape[0] + [clarabel.NonnegativeConeT(mu.shape[0])]
    normal = np.zeros((mu.shape[0], c.shape[0]))
    normal[np.arange(mu.shape[0]), 3 * np.arange(mu.shape[0])] = -1.0
    rows = csc_matrix(np.vstack([-diags(factors).toarray(), normal]))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-12
    solver = clarabel.DefaultSolver(csc_matrix(np.triu(S)), c, rows, np.zeros(rows.shape[0]), cones, settings)
    x = np.array(solver.solve().x)
    return x if np.isfinite(x).all() else None


def _clarabel() -> Any:
    try:
        import clarabel
    except ImportError:
        raise MissingExtra("the convex route in space needs clarabel; install it with: pip install clarabel") from None
    return clarabel
