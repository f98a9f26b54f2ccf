"""Projected Gauss–Seidel for  w = A z + b,  0 <= w _|_ z >= 0,  dense or sparse.

    z_i <- max(0, z_i - w_i / A_ii),   i = 1, 2, ..., n,   with w_i from the newest z

It needs A_ii > 0 and converges for symmetric positive definite A (and for H-matrices); linearly, so it serves large
sparse problems to moderate accuracy and as a start for others.

Source: R. W. Cottle, J.-S. Pang, R. E. Stone, The Linear Complementarity Problem, 1992, section 5.2.
"""

from __future__ import annotations

from nonsmooth.jit import kernel
from nonsmooth.lcp.result import INVALID, MAX_ITERATIONS, SOLVED, lcp_residual

CHECK_EVERY = 8  # chosen: sweeps between two looks at the residual, which costs a sweep
STALL_CHECKS = 25  # chosen: looks without the residual having fallen by a tenth: no longer worth it


@kernel
def pgs(n, A, b, z, tol, max_sweeps):
    """Solve from the guess z; write z. Returns (status, sweeps): SOLVED, MAX_ITERATIONS, or INVALID if A_ii <= 0."""
    for i in range(n):
        if not A[i, i] > 0.0:
            return INVALID, 0
    best = lcp_residual(n, A, b, z)
    stalled = 0
    for sweep in range(1, max_sweeps + 1):
        for i in range(n):
            w = b[i]
            for j in range(n):
                w += A[i, j] * z[j]
            z[i] = max(0.0, z[i] - w / A[i, i])
        if sweep % CHECK_EVERY == 0:
            residual = lcp_residual(n, A, b, z)
            if residual <= tol:
                return SOLVED, sweep
            stalled = 0 if residual < 0.9 * best else stalled + 1
            best = min(best, residual)
            if stalled == STALL_CHECKS:
                return MAX_ITERATIONS, sweep
    return MAX_ITERATIONS, max_sweeps


@kernel("UniTuple(int64, 2)(float64[:, ::1], float64[::1], float64[::1], float64, int64)", takes_arrays=True)
def pgs_entry(A, b, z, tol, max_sweeps):
    """`pgs` for calls from Python."""
    return pgs(b.shape[0], A, b, z, tol, max_sweeps)


SPARSE = (
    "UniTuple(int64, 2)(float64[::1],int32[::1], int32[::1], float64[::1], float64[::1], float64[::1], float64, int64)"
)


@kernel(SPARSE, takes_arrays=True)
def pgs_sparse_entry(data, indices, indptr, diagonal, b, z, tol, max_sweeps):
    """`pgs` for a matrix in compressed rows with its diagonal beside it, for calls from Python."""
    n = b.shape[0]
    scale = 0.0
    for i in range(n):
        if not diagonal[i] > 0.0:
            return INVALID, 0
        scale = max(scale, abs(b[i]))
    best = -1.0
    stalled = 0
    for sweep in range(1, max_sweeps + 1):
        largest = 0.0
        for i in range(n):
            w = b[i]
            for k in range(indptr[i], indptr[i + 1]):
                w += data[k] * z[indices[k]]
            largest = max(largest, abs(min(diagonal[i] * z[i], w)))
            z[i] = max(0.0, z[i] - w / diagonal[i])
        if largest <= 0.5 * tol * scale:
            return SOLVED, sweep
        if sweep % CHECK_EVERY == 0:
            stalled = 0 if best < 0.0 or largest < 0.9 * best else stalled + 1
            best = largest if best < 0.0 else min(best, largest)
            if stalled == STALL_CHECKS:
                return MAX_ITERATIONS, sweep
    return MAX_ITERATIONS, max_sweeps
