"""Sufficient tests that a contact problem has one motion, whatever c.

Two solutions differ by dP and dgamma = G dP. Signorini's law and Coulomb's leave, contact by contact,

    dP_N dgamma_N <= 0,    dP_F dgamma_F <= mu |dP_N| |dgamma_F| ,

so that dP_F = a + k dP_N with a dgamma_F <= 0 and |k| <= mu: z = (dP_N, a) fulfils z_j (A z)_j <= 0 in every row of

    A = G [[1, 0], [k, 1]] .

1. Without friction, or with friction under given forces alone, k = 0: 0 >= z.G z = |dgamma|^2 in the metric of the
   masses, and the motions are the same, though the impulses of redundant contacts need not be.
2. If A is a P-matrix for all |k| <= mu, then z = 0. It is one if the matrix of comparison, with the least diagonal and
   the largest other entries,

    G_NN - mu |G_NF|, G_FF;    -(|G_jN| + mu |G_jF|), -|G_jF| ,

   is an M-matrix: elimination without exchange of rows leaves its pivots positive.

A static coefficient above the kinetic one lets sticking and sliding coexist, and is certified by neither.
Source: Cottle, Pang, Stone, *The Linear Complementarity Problem* (1992), sections 3.3 and 3.11.
"""

from __future__ import annotations

from nonsmooth.jit import kernel
from nonsmooth.mechanics.system import GIVEN_FORCE
from nonsmooth.numerics.dense import SINGULAR


@kernel
def has_one_motion(problem, planar):
    """Whether one of the tests certifies a problem."""
    G, couples = problem.G, False
    for k in range(problem.n):
        if problem.kinds[k, 1] > 0:
            if problem.mu_static[k] != problem.mu[k]:
                return False
            a = problem.start[k]
            if problem.kinds[k, 0] != GIVEN_FORCE:
                couples = True
                if not G[a, a] > problem.mu[k] * abs(G[a, a + 1]):
                    return False
    return not couples or is_dominant(problem, planar)


@kernel
def is_dominant(problem, planar):
    """Whether the matrix of comparison is an M-matrix."""
    A, G, r = planar.A, problem.G, problem.r
    for m in range(problem.n):
        a, mu = problem.start[m], problem.mu[m]
        is_coupled = problem.kinds[m, 1] > 0 and problem.kinds[m, 0] != GIVEN_FORCE
        for j in range(r):
            for column in range(a, problem.start[m + 1]):
                A[j, column] = -abs(G[j, column])
            if is_coupled:
                A[j, a] -= mu * abs(G[j, a + 1])
        for column in range(a, problem.start[m + 1]):
            A[column, column] = G[column, column]
        if is_coupled:
            A[a, a] -= mu * abs(G[a, a + 1])
    for k in range(r):
        if not A[k, k] > SINGULAR * G[k, k]:
            return False
        for j in range(k + 1, r):
            if A[j, k] == 0.0:
                continue
            ratio = A[j, k] / A[k, k]
            for m in range(k + 1, r):
                A[j, m] -= ratio * A[k, m]
    return True
