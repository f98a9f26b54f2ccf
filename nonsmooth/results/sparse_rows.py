"""Sparse matrices from files: the indices are checked before compiled code follows them.

row k of the matrix:  entries x[p_k .. p_(k+1) - 1] in the columns i[p_k .. p_(k+1) - 1],   0 = p_0 <= ... <= p_m
"""

from __future__ import annotations

from typing import Any

import numpy as np


def compressed_rows(x: np.ndarray, i: np.ndarray, p: np.ndarray, shape: tuple[int, int]) -> Any:
    """The matrix of compressed rows; the arrays may be longer than what p says is used.

    Raises
    ------
    ValueError
        When p does not grow from 0 to at most the number of entries, or an index lies outside the matrix.
    """
    from scipy.sparse import csr_array

    m, n = shape
    if p.shape != (m + 1,) or p[0] != 0 or (np.diff(p) < 0).any() or p[-1] > min(len(i), len(x)):
        raise ValueError(f"the starts of {m} rows must be {m + 1} numbers that grow from 0 to at most {len(x)}")
    used = slice(int(p[-1]))
    require_within(i[used], n)
    return csr_array((x[used], i[used], p), shape=shape)


def require_within(i: np.ndarray, n: int) -> None:
    """Raise `ValueError` unless all indices are at least 0 and below n."""
    outside = (i < 0) | (i >= n)
    if outside.any():
        raise ValueError(f"an index of a matrix must lie in 0 ... {n - 1}; one is {i[outside][0]}")
