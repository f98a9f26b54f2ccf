"""Linear systems (A + B G) x = f with block-diagonal A and B: dense LU when small or full, sparse LU otherwise.

The compressed rows of a matrix are the compressed columns of its transpose, so SuperLU gets the transpose and solves
with the transpose of that: no conversion.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nonsmooth.contact.blocks.problem import Blocks
from nonsmooth.jit import kernel

Solve = Callable[[np.ndarray], np.ndarray]


def factorise(blocks: Blocks, A: np.ndarray, B: np.ndarray, keeps_diagonal: bool = False) -> Solve | None:
    """A function f -> (A + B G)^-1 f, or None where the matrix is singular.

    With ``keeps_diagonal`` the pivots of a sparse matrix are taken from its diagonal: right for positive definite ones
    and those near them, and the factors stay as sparse as those of Cholesky.
    """
    n = blocks.n
    if blocks.is_full:
        return _factorise_full(blocks, A, B)
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    data = np.empty(blocks.G.size)
    columns = np.empty(blocks.G.size, dtype=np.int32)
    starts = np.empty(n + 1, dtype=np.int32)
    fill_rows(blocks.G, blocks.indices, blocks.indptr, A, B, data, columns, starts)
    transpose = csc_array((data, columns, starts), shape=(n, n))
    try:
        if keeps_diagonal:
            symmetric = {"SymmetricMode": True}
            factors = splu(transpose, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=symmetric)
        else:
            factors = splu(transpose, permc_spec="MMD_AT_PLUS_A")
    except RuntimeError:  # SuperLU: factor is exactly singular
        return None
    return lambda f: factors.solve(f, trans="T")


def _factorise_full(blocks: Blocks, A: np.ndarray, B: np.ndarray) -> Solve | None:
    from scipy.linalg import get_lapack_funcs

    matrix = np.zeros((blocks.n, blocks.n), order="F")
    fill_full(blocks.G, blocks.indices, blocks.indptr, A, B, matrix)
    factor, substitute = get_lapack_funcs(("getrf", "getrs"), (matrix,))
    lu, pivots, info = factor(matrix, overwrite_a=True)
    if info != 0:
        return None
    return lambda f: substitute(lu, pivots, f)[0]


@kernel
def jacobian_entry(G, k, on_diagonal, A, B, i, a, b):
    """Entry (a, b) of A_i delta_ij + B_i G[k]."""
    total = A[i, a, b] if on_diagonal else 0.0
    for m in range(G.shape[1]):
        total += B[i, a, m] * G[k, m, b]
    return total


@kernel(
    "void(float64[:, :, ::1], int32[::1], int32[::1], float64[:, :, ::1], float64[:, :, ::1], float64[::1],"
    " int32[::1], int32[::1])",
    takes_arrays=True,
)
def fill_rows(G, indices, indptr, A, B, data, columns, starts):
    """Write A + B G in scalar compressed rows."""
    dim = G.shape[1]
    at = 0
    for i in range(indptr.shape[0] - 1):
        for a in range(dim):
            starts[i * dim + a] = at
            for k in range(indptr[i], indptr[i + 1]):
                for b in range(dim):
                    data[at] = jacobian_entry(G, k, indices[k] == i, A, B, i, a, b)
                    columns[at] = indices[k] * dim + b
                    at += 1
    starts[starts.shape[0] - 1] = at


@kernel(
    "void(float64[:, :, ::1], int32[::1], int32[::1], float64[:, :, ::1], float64[:, :, ::1], float64[::1, :])",
    takes_arrays=True,
)
def fill_full(G, indices, indptr, A, B, matrix):
    """Write A + B G into a full matrix of zeros in Fortran order."""
    dim = G.shape[1]
    for i in range(indptr.shape[0] - 1):
        for k in range(indptr[i], indptr[i + 1]):
            for a in range(dim):
                for b in range(dim):
                    matrix[i * dim + a, indices[k] * dim + b] = jacobian_entry(G, k, indices[k] == i, A, B, i, a, b)
