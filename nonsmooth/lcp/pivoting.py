"""Block principal pivoting with Murty's rule as a finite safeguard, for  w = A z + b,  0 <= w _|_ z >= 0.

For a set alpha of active indices  A_aa z_a = -b_a, z = 0 elsewhere, w = A z + b. The infeasible indices

    H = {i in alpha: z_i < 0}  or  {i not in alpha: w_i < 0}

all change sides at once (Kostreva; a Newton step on min(z, w)). That may cycle: when |H| has not shrunk for a few
iterations, only the least index of H changes until it has (Murty), which is finite for every P-matrix. A good first
set makes it the fastest of all, so it serves warm starts.

Source: J. J. Júdice, F. M. Pires, A block principal pivoting algorithm for large-scale strictly monotone linear
complementarity problems, Computers & Operations Research 21 (1994) 587-596.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.jit import kernel
from nonsmooth.lcp.basis import solve_active
from nonsmooth.lcp.result import INVALID, MAX_ITERATIONS, SOLVED
from nonsmooth.lcp.scaling import equilibrate

PIVOTING_PATIENCE = 10  # chosen: block steps without fewer infeasible indices before Murty's rule; Júdice and Pires
SIGN_TOLERANCE = 1e-13  # chosen: a value this far below 0, relative to the largest of the scaled problem, counts as 0


def pivoting_workspace(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Allocate what `pivoting` needs up to n unknowns: lu (n, n + 2), scales (4, n + 2), active (3 n,)."""
    return np.empty((n, n + 2)), np.empty((4, n + 2)), np.empty(3 * n, np.int64)


@kernel
def pivoting(n, A, b, z, lu, scales, active, max_iterations):
    """Solve from the guess z (zero if there is none); write z. Arrays may be larger than n.

    Returns (status, iterations): SOLVED, MAX_ITERATIONS, or INVALID when a principal submatrix is singular.
    """
    size = equilibrate(n, A, b, scales)
    for i in range(n):
        active[2 * n + i] = 1 if z[i] / scales[1, i] > scales[0, i] * _row_value(n, A, b, z, i) else 0
    fewest = n + 1
    patience = PIVOTING_PATIENCE
    for iteration in range(1, max_iterations + 1):
        m = 0
        for i in range(n):
            if active[2 * n + i] == 1:
                active[m] = i
                m += 1
        if not solve_active(n, m, A, b, z, lu, scales, active):
            return INVALID, iteration
        count, first = _mark_infeasible(n, A, b, z, size, scales, active)
        if count == 0:
            for i in range(n):
                z[i] = max(0.0, z[i])
            return SOLVED, iteration
        if count < fewest:
            fewest = count
            patience = PIVOTING_PATIENCE
        else:
            patience = max(0, patience - 1)
        for i in range(n):
            if scales[3, i] == 1.0 and (patience > 0 or i == first):
                active[2 * n + i] = 1 - active[2 * n + i]
    return MAX_ITERATIONS, max_iterations


@kernel
def _row_value(n, A, b, z, i):
    w = b[i]
    for j in range(n):
        w += A[i, j] * z[j]
    return w


@kernel
def _mark_infeasible(n, A, b, z, size, scales, active):
    """Set scales[3, i] to 1 for i in H, else 0; return |H| and its least index."""
    largest = 1.0
    for i in range(n):
        largest = max(largest, abs(z[i]) / (size * scales[1, i]))
    count = 0
    first = -1
    for i in range(n):
        if active[2 * n + i] == 1:
            value = z[i] / (size * scales[1, i])
        else:
            value = _row_value(n, A, b, z, i) * scales[0, i] / size
        scales[3, i] = 0.0
        if value < -SIGN_TOLERANCE * largest:
            scales[3, i] = 1.0
            if count == 0:
                first = i
            count += 1
    return count, first


PIVOTING = (
    "UniTuple(int64, 2)(float64[:, ::1], float64[::1], float64[::1], float64[:, ::1], float64[:, ::1],"
    "int64[::1], int64)"
)


@kernel(PIVOTING, takes_arrays=True)
def pivoting_entry(A, b, z, lu, scales, active, max_iterations):
    """`pivoting` for calls from Python: returns (status, iterations)."""
    return pivoting(b.shape[0], A, b, z, lu, scales, active, max_iterations)
