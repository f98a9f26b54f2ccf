"""A complementary basis solved to full accuracy: with alpha the set of basic z,

    A_aa z_a = -b_a,   z = 0 elsewhere,

by LU with partial pivoting on the equilibrated matrix and one step of iterative refinement with the given A and b.
Pivoting methods find the set; their tableau has gathered the rounding of every pivot, this has not.

Source: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2002, theorem 12.3.
Equations: docs/theory/lcp.md, (6).
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel


@kernel
def resolve_basis(n, A, b, z, tableau, scales, basis):
    """Solve for the z_k found in basis[:n] (numbers n..2n-1) and write z; False, z untouched, if singular.

    The tableau and basis of `lemke_pivots` serve as workspace and are overwritten; `scales` is read.
    """
    m = 0
    for i in range(n):
        variable = basis[i]
        if n <= variable < 2 * n:
            basis[m] = variable - n
            m += 1
    is_regular = solve_active(n, m, A, b, z, tableau, scales, basis)
    for i in range(n):
        z[i] = max(0.0, z[i])
    return is_regular


@kernel
def solve_active(n, m, A, b, z, lu, scales, active):
    """Solve A_aa z_a = -b_a for the m indices active[:m]; False, z untouched, if A_aa is singular.

    Workspace: lu (n, n + 2), active (2 n,), scales (4, n + 2), rows 0 and 1 as `equilibrate` leaves them.
    """
    for i in range(m):
        for j in range(m):
            lu[i, j] = scales[0, active[i]] * A[active[i], active[j]] * scales[1, active[j]]
        lu[i, n] = -scales[0, active[i]] * b[active[i]]
    if not lu_factor(m, lu, scales, active, n):
        return False
    lu_solve(m, lu, active, n)
    for i in range(m):
        lu[i, n + 1] = lu[i, n] * scales[1, active[i]]
    for i in range(m):  # refine
        r = -b[active[i]]
        for j in range(m):
            r -= A[active[i], active[j]] * lu[j, n + 1]
        lu[i, n] = scales[0, active[i]] * r
    lu_solve(m, lu, active, n)
    for i in range(m):
        if not math.isfinite(lu[i, n] + lu[i, n + 1]):
            return False
    for i in range(n):
        z[i] = 0.0
    for i in range(m):
        z[active[i]] = lu[i, n + 1] + lu[i, n] * scales[1, active[i]]
    return True


@kernel
def lu_factor(m, lu, scratch, order, n):
    """Factor lu[:m, :m] in place; the row exchanged at step k goes to order[n + k]. False if a pivot is 0.

    The pivot row is copied to scratch[2]: from another array the inner loop vectorises.
    """
    for k in range(m):
        row = k
        for i in range(k + 1, m):
            if abs(lu[i, k]) > abs(lu[row, k]):
                row = i
        order[n + k] = row
        if not abs(lu[row, k]) > 0.0:
            return False
        if row != k:
            for j in range(m):
                lu[k, j], lu[row, j] = lu[row, j], lu[k, j]
        for j in range(k, m):
            scratch[2, j] = lu[k, j]
        for i in range(k + 1, m):
            factor = lu[i, k] / lu[k, k]
            lu[i, k] = factor
            if factor != 0.0:
                for j in range(k + 1, m):
                    lu[i, j] -= factor * scratch[2, j]
    return True


@kernel
def lu_solve(m, lu, order, n):
    """Solve with the factors of `lu_factor`; the right-hand side and the solution are lu[:m, n]."""
    for k in range(m):
        row = order[n + k]
        lu[k, n], lu[row, n] = lu[row, n], lu[k, n]
    for i in range(m):
        for j in range(i):
            lu[i, n] -= lu[i, j] * lu[j, n]
    for i in range(m - 1, -1, -1):
        for j in range(i + 1, m):
            lu[i, n] -= lu[i, j] * lu[j, n]
        lu[i, n] /= lu[i, i]
