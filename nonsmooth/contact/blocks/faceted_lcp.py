"""Friction with a faceted cone, as a linear complementarity problem.

With facet directions D = (d_1 ... d_f), d_k and -d_k both among them, P_T = D beta, unknowns (P_N, beta, lambda),

    0 <= gamma_N                     _|_  P_N    >= 0
    0 <= D^T gamma_T + lambda e      _|_  beta   >= 0
    0 <= mu P_N - e^T beta           _|_  lambda >= 0

Exact in the plane, where the cone has two facets. In space it is another law: P_T lies in a polygon, off the cone by up
to 1 - cos(pi / f), and slides along facets; the error that is reported is that of the round cone.

Pivoting starts from nowhere: of 60 assemblies with masses over six decades and friction coefficients up to two it ends
the two that all iterations leave (docs/benchmarks/ladder).

Source: Stewart and Trinkle, Int. J. Numer. Methods Eng. 39 (1996) 2673-2691; Anitescu and Potra, Nonlinear Dyn. 14
(1997) 231-247.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.contact.blocks.problem import Problem, as_matrix
from nonsmooth.errors import InvalidInput


@dataclass(frozen=True)
class FacetedLCP:
    """Options of the faceted route.

    Parameters
    ----------
    facets : int
        Directions of the cone of a spatial contact, even and at least 4; a planar one always has 2.
    """

    facets: int = 8

    name = "lcp"

    def __post_init__(self) -> None:
        if self.facets < 4 or self.facets % 2:
            raise InvalidInput(f"facets must be even and at least 4; got {self.facets}")

    def run(self, problem: Problem, P: np.ndarray, tol: float, until: float = math.inf) -> tuple[np.ndarray, int]:
        """Solve the problem; ``P`` is not used: pivoting needs no start, and has nothing to return before its end."""
        from nonsmooth.lcp.solve import solve_lcp

        A, b, impulses = faceted(problem, self.facets)
        result = solve_lcp(A, b, tol=min(1e-10, tol))
        return impulses @ result.z, result.iterations


def faceted(problem: Problem, facets: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, b of the LCP and the matrix that maps its z to P."""
    n_c, dim = problem.n_c, problem.dim
    f = 2 if dim == 2 else facets
    angles = 2.0 * np.pi * np.arange(f) / f
    D = np.array([[1.0, -1.0]]) if dim == 2 else np.array([np.cos(angles), np.sin(angles)])
    size = n_c * (f + 2)
    forces = np.zeros((problem.n, n_c * (1 + f)))  # (P_N, beta) -> P
    sums, cones = np.zeros((n_c, n_c * (1 + f))), np.zeros((n_c, n_c * (1 + f)))
    for i in range(n_c):
        beta = slice(n_c + i * f, n_c + (i + 1) * f)
        forces[i * dim, i] = 1.0
        forces[i * dim + 1 : (i + 1) * dim, beta] = D
        sums[i, beta] = 1.0
        cones[i, i] = problem.mu[i]
    A = np.zeros((size, size))
    split = n_c * (1 + f)
    A[:split, :split] = forces.T @ as_matrix(problem.blocks) @ forces
    A[:split, split:] = sums.T
    A[split:, :split] = cones - sums
    b = np.concatenate([forces.T @ problem.c, np.zeros(n_c)])
    return A, b, np.hstack([forces, np.zeros((problem.n, n_c))])
