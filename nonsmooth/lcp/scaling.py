"""Equilibration by powers of two:  w' = (R A E) z' + R b / s,   z = s E z',  R, E diagonal > 0.

Row and column scaling keeps the signs of w and z, hence the solutions. With powers of two it rounds nothing. One pass
R_i = max_j |A_ij|^-1/2 ..., after Ruiz, repeated: afterwards the largest entry of every row and column is near 1, so
that pivot and tie tolerances are plain numbers.

Source: D. Ruiz, A scaling algorithm to equilibrate both rows and columns norms in matrices, RAL-TR-2001-034.
Equations: docs/theory/lcp.md, (3).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nonsmooth.jit import kernel

PASSES = 6  # derived: each halves the exponent of the imbalance, 1e24 becomes 2.4; most matrices need one or two
EVEN = 64.0  # derived: row and column maxima this close before a pass lie within [1/16, 4] after it: enough


@kernel
def power_of_two(x):
    """The power of two just above x > 0 (1 for x = 0)."""
    return x / math.frexp(x)[0] if x > 0.0 else 1.0


@kernel
def root_power_of_two(x):
    """The power of two just above sqrt(x), x > 0 (1 for x = 0)."""
    return power_of_two(math.sqrt(x))


@kernel
def equilibrate(n, A, b, scales):
    """Write R into scales[0, :n], E into scales[1, :n]; return s, the power of two with max |R b| / s in [1/2, 1).

    Row 2 of scales (4, n + 2) is scratch; row 3 is not touched.
    """
    for i in range(n):
        scales[0, i] = 1.0
        scales[1, i] = 1.0
    for _ in range(PASSES):
        if _balance(n, A, scales) <= EVEN:
            break
    largest = 0.0
    for i in range(n):
        largest = max(largest, scales[0, i] * abs(b[i]))
    return power_of_two(largest)


@kernel
def _balance(n, A, scales):
    """One pass of Ruiz; returns the largest over the smallest of the row and column maxima it found."""
    most = 0.0
    least = math.inf
    for j in range(n):
        scales[2, j] = 0.0
    for i in range(n):
        row = 0.0
        for j in range(n):
            entry = abs(A[i, j]) * scales[1, j]
            row = max(row, entry)
            scales[2, j] = max(scales[2, j], scales[0, i] * entry)
        row *= scales[0, i]
        if row > 0.0:
            most = max(most, row)
            least = min(least, row)
            scales[0, i] /= root_power_of_two(row)
    for j in range(n):
        column = scales[2, j]
        if column > 0.0:
            least = min(least, column)
            scales[1, j] /= root_power_of_two(column)
    return most / least


def scaled_problem(A: Any, b: np.ndarray) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray]:
    """The same equilibration for a dense or scipy.sparse matrix: R A E, R b / s, R and s E, so that z = (s E) z'."""
    R, E = np.ones(len(b)), np.ones(len(b))
    for _ in range(PASSES):
        size = abs(_scaled(A, R, E))
        rows, columns = _largest(size, 1), _largest(size, 0)
        found = np.concatenate([rows[rows > 0], columns[columns > 0]])
        if not len(found):
            break
        R /= _root_powers_of_two(rows)
        E /= _root_powers_of_two(columns)
        if rows.max() / found.min() <= EVEN:
            break
    s = float(_powers_of_two(np.array([np.max(R * abs(b), initial=0.0)]))[0])
    return _scaled(A, R, E), R * b / s, R, s * E


def _scaled(A: Any, R: np.ndarray, E: np.ndarray) -> Any:
    if isinstance(A, np.ndarray):
        return R[:, None] * A * E
    return A.multiply(R[:, None]).multiply(E).tocsr()


def _largest(size: Any, axis: int) -> np.ndarray:
    largest = size.max(axis=axis)
    return largest if isinstance(largest, np.ndarray) else largest.toarray().ravel()


def _root_powers_of_two(x: np.ndarray) -> np.ndarray:
    return _powers_of_two(np.sqrt(x))


def _powers_of_two(x: np.ndarray) -> np.ndarray:
    return np.where(x > 0, np.exp2(np.frexp(x)[1]), 1.0)
