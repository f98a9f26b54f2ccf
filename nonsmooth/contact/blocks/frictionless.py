"""Contacts without friction: the linear complementarity problem of their normals.

    0 <= G_NN P_N + c_N  _|_  P_N >= 0,    P_T = 0

It has a third or half of the unknowns and, for a symmetric semidefinite G, is a convex program. Of 240 random problems
the rest of the ladder solves as many in 1.3 times the time, but packings of 500 to 1000 spheres take it 6 to 13 times
as long, and one of 2400 contacts it leaves (docs/benchmarks/ladder). Gauss-Seidel solves loose assemblies in the least
time; where contacts are redundant it stalls, and interior points take over (docs/benchmarks/solvers).

Source: Moreau, in: Nonsmooth Mechanics and Applications (1988) 1-82.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.contact.blocks.problem import Blocks, Problem
from nonsmooth.errors import InvalidInput


class Frictionless(NamedTuple):
    """The complementarity problem of the normals."""

    name: str = "frictionless"

    def run(self, problem: Problem, P: np.ndarray, tol: float, until: float = math.inf) -> tuple[np.ndarray, int]:
        """Solve from the normal parts of P."""
        from nonsmooth.lcp.solve import solve_lcp

        if problem.mu.any():
            raise InvalidInput("solver 'frictionless' takes mu = 0 at every contact; use solver='auto'")
        result = solve_lcp(normal_matrix(problem.blocks), problem.c[:: problem.dim], tol=0.1 * tol)
        impulses = np.zeros_like(P)
        impulses[:: problem.dim] = result.z
        return impulses, result.iterations


def normal_matrix(blocks: Blocks) -> Any:
    """G_NN in compressed rows."""
    from scipy.sparse import csr_array

    n_c = blocks.indptr.shape[0] - 1
    return csr_array((blocks.G[:, 0, 0].copy(), blocks.indices, blocks.indptr), shape=(n_c, n_c))
