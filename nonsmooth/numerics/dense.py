"""Small dense linear algebra for kernels: root-free Cholesky and LU with explicit sizes.

np.linalg would take 8 s to compile and about a microsecond a call; at the sizes of a contact problem (n <= 16) plain
loops are ten times faster. Source: Golub, Van Loan, *Matrix Computations*, algorithms 4.1.2 and 3.4.1.
"""

from __future__ import annotations

from nonsmooth.jit import kernel

SINGULAR = 1e-13  # chosen: a pivot below this part of its matrix's largest entry counts as zero


@kernel
def bandwidth(n, A):
    """Largest |i - j| with A_ij != 0; a diagonal matrix has 0, and its factor solves in n multiplications."""
    for distance in range(n - 1, 0, -1):
        for i in range(distance, n):
            if A[i, i - distance] != 0.0 or A[i - distance, i] != 0.0:
                return distance
    return 0


@kernel
def cholesky(n, band, A, L):
    """A = L D L^T: L below its diagonal of ones, 1/D on it; False unless A is positive definite (or holds NaN).

    Without roots every number scales as the masses do: in units with other powers of two the bits are the same.
    """
    for i in range(n):
        first = max(0, i - band)
        for j in range(first, i):
            total = A[i, j]
            for k in range(first, j):
                total -= L[i, k] * L[j, k]
            L[i, j] = total  # L_ij D_j until the row is complete
        total = A[i, i]
        for k in range(first, i):
            scaled = L[i, k]
            L[i, k] = scaled * L[k, k]
            total -= scaled * L[i, k]
        if not total > 0.0:
            return False
        L[i, i] = 1.0 / total
    return True


@kernel
def cholesky_solve(n, band, L, x):
    """Overwrite x with A^-1 x."""
    if band == 0:
        for i in range(n):
            x[i] *= L[i, i]
        return
    for i in range(n):
        total = x[i]
        for k in range(max(0, i - band), i):
            total -= L[i, k] * x[k]
        x[i] = total
    for i in range(n - 1, -1, -1):
        total = x[i] * L[i, i]
        for k in range(i + 1, min(n, i + band + 1)):
            total -= L[k, i] * x[k]
        x[i] = total


@kernel
def cholesky_solve_rows(n, band, L, m, X):
    """Overwrite the first m rows of X with A^-1 times each row."""
    if band == 0:
        for r in range(m):
            for i in range(n):
                X[r, i] *= L[i, i]
        return
    for r in range(m):
        for i in range(n):
            total = X[r, i]
            for k in range(max(0, i - band), i):
                total -= L[i, k] * X[r, k]
            X[r, i] = total
        for i in range(n - 1, -1, -1):
            total = X[r, i] * L[i, i]
            for k in range(i + 1, min(n, i + band + 1)):
                total -= L[k, i] * X[r, k]
            X[r, i] = total


@kernel
def lu(n, A, order):
    """Overwrite A with its LU factors (partial pivoting, rows permuted by ``order``); False when singular."""
    largest = 0.0
    for i in range(n):
        order[i] = i
        for j in range(n):
            largest = max(largest, abs(A[i, j]))
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[pivot, k]):
                pivot = i
        if not abs(A[pivot, k]) > SINGULAR * largest:
            return False
        if pivot != k:
            order[k], order[pivot] = order[pivot], order[k]
            for j in range(n):
                A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
        for i in range(k + 1, n):
            if A[i, k] == 0.0:  # matrices of chains and stacks have few entries
                continue
            A[i, k] /= A[k, k]
            for j in range(k + 1, n):
                A[i, j] -= A[i, k] * A[k, j]
    return True


@kernel
def lu_solve(n, A, order, b, x):
    """x = A^-1 b from the factors of ``lu``; b and x are different vectors."""
    for i in range(n):
        total = b[order[i]]
        for k in range(i):
            total -= A[i, k] * x[k]
        x[i] = total
    for i in range(n - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, n):
            total -= A[i, k] * x[k]
        x[i] = total / A[i, i]
