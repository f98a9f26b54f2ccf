"""P-matrices: all principal minors are positive, so that w = A z + b, 0 <= w _|_ z >= 0 has one solution for every b.

    A = [[a, r], [c, B]] is a P-matrix  iff  a > 0, and B and the Schur complement B - c r/a are P-matrices,

2^n steps in all. Two sufficient tests need no more than a factorisation: the symmetric part is positive definite, or
the rows are strictly dominated by positive diagonals. Source: Cottle, Pang, Stone, *The Linear Complementarity Problem*
(1992), theorem 3.3.7; Tsatsomeros, Li, *BIT* 40 (2000) 390.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_square_matrix

EXACT = 16  # chosen: largest n that is decided minor by minor


def is_p_matrix(A: Any) -> bool | None:
    """Whether A is a P-matrix.

    Parameters
    ----------
    A : array_like (n, n)

    Returns
    -------
    bool or None
        None where n > 16 and the sufficient tests say nothing.

    Raises
    ------
    InvalidInput
        When A is not square or not finite.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.is_p_matrix([[1.0, -3.0], [0.5, 1.0]]), ns.is_p_matrix([[1.0, 2.0], [2.0, 1.0]])
    (True, False)
    """
    A = as_square_matrix("A", A)
    diagonal = np.diag(A)
    if not (diagonal > 0).all():
        return False
    if (2 * diagonal > np.abs(A).sum(axis=1)).all() or is_positive_definite(A + A.T):
        return True
    return has_positive_minors(A) if len(A) <= EXACT else None


def is_positive_definite(A: np.ndarray) -> bool:
    """Whether a symmetric matrix has a Cholesky factor."""
    try:
        np.linalg.cholesky(A)
    except np.linalg.LinAlgError:
        return False
    return True


def has_positive_minors(A: np.ndarray) -> bool:
    """The recursion above."""
    if not A[0, 0] > 0:
        return False
    if len(A) == 1:
        return True
    rest = A[1:, 1:]
    return has_positive_minors(rest) and has_positive_minors(rest - np.outer(A[1:, 0], A[0, 1:]) / A[0, 0])
