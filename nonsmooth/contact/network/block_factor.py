"""LU factors of a matrix of n x n blocks on the graph of the bodies, in a given order and without pivoting of blocks.

    A = (I + L) D (I + D^-1 U),     D block diagonal, L below it, U above it

For each column k: D_k <- D_k^-1; L_ik <- A_ik D_k^-1; then A_ij -= L_ik A_kj for all i, j that column k reaches. Where
A is symmetric U_ki = A_ik^T is known and only the lower half is updated. A block is a row of n^2 numbers. Source: Duff,
Erisman and Reid, *Direct Methods for Sparse Matrices*, 2nd edition, Oxford 2017, chapters 5 and 12.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.contact.network.ordering import Columns
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import Block, Floats, Ints


class Factor(Block):
    """The blocks of A, then of its factors."""

    columns: Columns
    D: Array[Floats, "n_b", "n * n"]
    L: Array[Floats, "fill", "n * n"]
    U: Array[Floats, "fill", "n * n"]
    block_at: Array[Ints, "n_b"]  # of a row, its block in the column that is updated, and else -1


@rare_kernel
def factorise(factor, square, begin, end, is_symmetric, n):
    """Factorise the rows and columns begin <= k < end; False where a pivot vanishes or is not finite.

    ``square`` (2, n^2) is for two blocks meanwhile.
    """
    columns, L, U = factor.columns, factor.L, factor.U
    for k in range(begin, end):
        factor.block_at[k] = -1
    for k in range(begin, end):
        if not invert(factor, square, k, n):
            return False
        for at in range(columns.first[k], columns.last[k]):
            if is_symmetric:
                transpose(U, L, at, n)
            scale_column(factor, square, at, k, n)
        for at in range(columns.first[k], columns.last[k]):
            subtract_product(factor.D, columns.row[at], L, at, U, at, n)
            update_column(factor, at, columns.last[k], is_symmetric, n)
    return True


@kernel
def update_column(factor, at, last, is_symmetric, n):
    """Subtract what column k does to the column of its row at ``at``: with its rows below, up to ``last``."""
    columns, L, U, block_at = factor.columns, factor.L, factor.U, factor.block_at
    if at + 1 == last:
        return
    j = columns.row[at]
    first_j, last_j = columns.first[j], columns.last[j]
    for entry in range(first_j, last_j):
        block_at[columns.row[entry]] = entry
    for below in range(at + 1, last):
        to = block_at[columns.row[below]]
        subtract_product(L, to, L, below, U, at, n)
        if not is_symmetric:
            subtract_product(U, to, L, at, U, below, n)


@kernel
def transpose(U, L, at, n):
    """U[at] = L[at]^T."""
    for x in range(n):
        for y in range(n):
            U[at, x * n + y] = L[at, y * n + x]


@kernel
def subtract_product(T, t, A, a, B, b, n):
    """T_t -= A_a B_b."""
    if n == 6:
        for x in range(0, 36, 6):
            subtract_row(T, t, A, a, B, b, x)
        return
    for x in range(n):
        for y in range(n):
            total = T[t, x * n + y]
            for z in range(n):
                total -= A[a, x * n + z] * B[b, z * n + y]
            T[t, x * n + y] = total


@kernel
def subtract_row(T, t, A, a, B, b, x):
    """The row of 6 x 6 blocks that begins at x, to the same bits: in registers, since T may be A or B as far as a
    compiler knows. Measured: 7 Gflop/s, 4 without."""
    t_0, t_1, t_2, t_3, t_4, t_5 = T[t, x], T[t, x + 1], T[t, x + 2], T[t, x + 3], T[t, x + 4], T[t, x + 5]
    for z in range(6):
        share, y = A[a, x + z], 6 * z
        t_0 -= share * B[b, y]
        t_1 -= share * B[b, y + 1]
        t_2 -= share * B[b, y + 2]
        t_3 -= share * B[b, y + 3]
        t_4 -= share * B[b, y + 4]
        t_5 -= share * B[b, y + 5]
    T[t, x], T[t, x + 1], T[t, x + 2], T[t, x + 3], T[t, x + 4], T[t, x + 5] = t_0, t_1, t_2, t_3, t_4, t_5


@kernel
def scale_column(factor, square, at, k, n):
    """L_at <- L_at D_k^-1."""
    D, L = factor.D, factor.L
    for x in range(n):
        for y in range(n):
            total = 0.0
            for z in range(n):
                total += L[at, x * n + z] * D[k, z * n + y]
            square[0, x * n + y] = total
    for x in range(n * n):
        L[at, x] = square[0, x]


@kernel
def invert(factor, square, k, n):
    """D_k <- D_k^-1 by Gauss and Jordan; False where a pivot is zero or not finite."""
    A, Z, D = square, square, factor.D
    for x in range(n):
        for y in range(n):
            A[0, x * n + y] = D[k, x * n + y]
            Z[1, x * n + y] = 1.0 if x == y else 0.0
    for p in range(n):
        pivot = A[0, p * n + p]
        if not abs(pivot) > 0.0:
            return False
        scale = 1.0 / pivot
        for y in range(n):
            A[0, p * n + y] *= scale
            Z[1, p * n + y] *= scale
        for x in range(n):
            if x != p:
                share = A[0, x * n + p]
                for y in range(n):
                    A[0, x * n + y] -= share * A[0, p * n + y]
                    Z[1, x * n + y] -= share * Z[1, p * n + y]
    for x in range(n * n):
        D[k, x] = Z[1, x]
    return True


@rare_kernel
def back_substitute(factor, square, begin, end, x, n):
    """x <- A^-1 x of the rows begin <= k < end."""
    columns, L, U, D, row = factor.columns, factor.L, factor.U, factor.D, factor.columns.row
    for k in range(begin, end):
        for at in range(columns.first[k], columns.last[k]):
            subtract_image(x, row[at], L, at, k, n)
    for k in range(end - 1, begin - 1, -1):
        for at in range(columns.first[k], columns.last[k]):
            subtract_image(x, k, U, at, row[at], n)
        for a in range(n):
            total = 0.0
            for e in range(n):
                total += D[k, a * n + e] * x[k, e]
            square[0, a] = total
        for a in range(n):
            x[k, a] = square[0, a]


@kernel
def subtract_image(x, to, A, a, k, n):
    """x_to -= A_a x_k."""
    for row in range(n):
        total = x[to, row]
        for e in range(n):
            total -= A[a, row * n + e] * x[k, e]
        x[to, row] = total
