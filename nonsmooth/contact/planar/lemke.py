"""Several planar contacts as a linear complementarity problem, solved by Lemke's method.

Per contact, with P_R = mu P_N + P_F and gamma_L the part of gamma_F to the left, gamma_R that to the right:

    [gamma_N]   [G_NN - G_NF mu   G_NF   0] [P_N    ]   [c_N]
    [gamma_R] = [G_FN - G_FF mu   G_FF   1] [P_R    ] + [c_F]
    [P_L    ]   [     2 mu         -1    0] [gamma_L]   [ 0 ]

Under a given normal force mu P_N is known, and the first row is left out. What is accepted satisfies the inclusions of
``problem.residual``.

Source: Glocker, Studer, *Multibody Syst. Dyn.* 13 (2005) 447.
"""

from __future__ import annotations

from nonsmooth.contact.planar.problem import ACCEPTED_RESIDUAL, residual
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.lcp.lemke import lemke
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE

LEMKE_PIVOTS = 50  # chosen: times the number of unknowns


@kernel
def can_be_faceted(problem):
    """Whether the problem is a linear complementarity problem: a bilateral contact is none."""
    for k in range(problem.n):
        if problem.kinds[k, 0] == BILATERAL:
            return False
    return True


@rare_kernel
def solve_by_lemke(problem, planar):
    """Lemke's method on Glocker's problem; True if the answer satisfies the inclusions."""
    P, z = problem.P, planar.z
    size = assemble_lcp(problem, planar)
    pivots = pivot(size, planar.A, planar.b, z, planar.tableau, planar.scales, planar.basis, LEMKE_PIVOTS * size)
    planar.pivots += pivots
    row = 0
    for k in range(problem.n):
        d = problem.kinds[k, 1]
        t = problem.start[k + 1] - 1
        if problem.kinds[k, 0] == GIVEN_FORCE:
            P[t] = z[row] - problem.mu[k] * problem.normal_impulse[k]
            row += 2
        else:
            P[problem.start[k]] = z[row]
            if d > 0:
                P[t] = z[row + 1] - problem.mu[k] * z[row]
            row += 1 + 2 * d
    return residual(problem, planar) <= ACCEPTED_RESIDUAL


@kernel(
    "int64(int64, float64[:, ::1], float64[::1], float64[::1], float64[:, ::1], float64[:, ::1], int64[::1], int64)"
)
def pivot(size, A, b, z, tableau, scales, basis, max_pivots):
    """Lemke's method as a part compiled for itself; returns the number of pivots."""
    _, pivots = lemke(size, A, b, z, tableau, scales, basis, max_pivots)
    return pivots


@kernel
def assemble_lcp(problem, planar):
    """Fill A and b of Glocker's problem, contact by contact; returns its size."""
    b = planar.b
    row = 0
    for k in range(problem.n):
        first, size, column = problem.start[k], count_unknowns(k, problem), 0
        for a in range(size):
            b[row + a] = 0.0
        for a in range(problem.start[k + 1] - first):
            b[row + a] = problem.c[first + a]
        for m in range(problem.n):
            fill_columns(k, m, row, column, problem, planar)
            column += count_unknowns(m, problem)
        if problem.kinds[k, 1] > 0 and problem.kinds[k, 0] == GIVEN_FORCE:
            b[row + 1] = 2.0 * problem.mu[k] * problem.normal_impulse[k]
        row += size
    return row


@kernel
def count_unknowns(k, problem):
    """Number of unknowns of contact k in Glocker's problem."""
    return (0 if problem.kinds[k, 0] == GIVEN_FORCE else 1) + 2 * problem.kinds[k, 1]


@kernel
def fill_columns(k, m, row, column, problem, planar):
    """Block (k, m) of Glocker's matrix, which begins at a row and a column."""
    A, b, G, mu, first = planar.A, planar.b, problem.G, problem.mu[m], problem.start[m]
    is_given, d = problem.kinds[m, 0] == GIVEN_FORCE, problem.kinds[m, 1]
    size, width, rows = count_unknowns(k, problem), count_unknowns(m, problem), problem.start[k + 1] - problem.start[k]
    for a in range(size):
        for e in range(width):
            A[row + a, column + e] = 0.0
    for a in range(rows):
        g = problem.start[k] + a
        A[row + a, column] = G[g, first]
        if is_given:
            b[row + a] -= G[g, first] * mu * problem.normal_impulse[m]
        elif d > 0:
            A[row + a, column] -= mu * G[g, first + 1]
            A[row + a, column + 1] = G[g, first + 1]
    if k == m and d > 0:
        A[row + rows - 1, column + width - 1] = 1.0
        A[row + size - 1, column + width - 2] = -1.0
        if not is_given:
            A[row + size - 1, column] = 2.0 * mu
