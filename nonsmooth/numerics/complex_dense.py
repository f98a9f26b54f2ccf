"""LU factors of a small complex matrix A + i B, real and imaginary parts in two arrays.

Blocks hold no complex numbers, and the products are few: (a + i b)(c + i d) = ac - bd + i (ad + bc). Source: Golub, Van
Loan, *Matrix Computations*, algorithm 3.4.1; the splitting is that of decc/solc in Hairer and Wanner's RADAU5.
"""

from __future__ import annotations

from nonsmooth.jit import kernel


@kernel
def complex_lu(n, A, B, order):
    """Overwrite A + i B with its LU factors (rows permuted by ``order``); False when a pivot vanishes."""
    for i in range(n):
        order[i] = i
    for k in range(n):
        pivot = k
        largest = A[k, k] * A[k, k] + B[k, k] * B[k, k]
        for i in range(k + 1, n):
            size = A[i, k] * A[i, k] + B[i, k] * B[i, k]
            if size > largest:
                pivot, largest = i, size
        if not largest > 0.0:
            return False
        if pivot != k:
            order[k], order[pivot] = order[pivot], order[k]
            for j in range(n):
                A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
                B[k, j], B[pivot, j] = B[pivot, j], B[k, j]
        a, b = A[k, k] / largest, -B[k, k] / largest
        for i in range(k + 1, n):
            c, d = A[i, k], B[i, k]
            if c == 0.0 and d == 0.0:
                continue
            re, im = c * a - d * b, c * b + d * a
            A[i, k], B[i, k] = re, im
            for j in range(k + 1, n):
                A[i, j] -= re * A[k, j] - im * B[k, j]
                B[i, j] -= re * B[k, j] + im * A[k, j]
    return True


@kernel
def complex_lu_solve(n, A, B, order, a, b, x, y):
    """x + i y = (A + i B)^-1 (a + i b) from the factors of ``complex_lu``; x, y and a, b are different vectors."""
    for i in range(n):
        re, im = a[order[i]], b[order[i]]
        for k in range(i):
            re -= A[i, k] * x[k] - B[i, k] * y[k]
            im -= A[i, k] * y[k] + B[i, k] * x[k]
        x[i], y[i] = re, im
    for i in range(n - 1, -1, -1):
        re, im = x[i], y[i]
        for k in range(i + 1, n):
            re -= A[i, k] * x[k] - B[i, k] * y[k]
            im -= A[i, k] * y[k] + B[i, k] * x[k]
        size = A[i, i] * A[i, i] + B[i, i] * B[i, i]
        x[i] = (re * A[i, i] + im * B[i, i]) / size
        y[i] = (im * A[i, i] - re * B[i, i]) / size
