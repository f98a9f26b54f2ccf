"""A proof that an LCP cannot have a solution: there is no z >= 0 with A z + b >= 0.

    y >= 0,   A^T y <= 0,   b.y < 0      =>      y.(A z + b) = (A^T y).z + b.y < 0  for every z >= 0

Such a y exists exactly when the inequalities have no solution (Farkas). A linear program proposes it, on the
equilibrated problem; it counts only after A^T y and b.y have been computed here and hold within the rounding of those
very sums. An LCP with feasible inequalities may lack solutions too; of that no certificate is known.

Source: R. W. Cottle, J.-S. Pang, R. E. Stone, The Linear Complementarity Problem, 1992, theorem 2.7.8.
Equations: docs/theory/lcp.md, (9).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.lcp.scaling import scaled_problem
from nonsmooth.numerics.rounding import rounding_of_sum

CERTIFICATE_ROUNDINGS = 8  # chosen: of each product, eight times what (3.5) of ``rounding`` says
HIDDEN_SIZE = 1e6  # chosen: of z of the scaled problem: what the rounding of A^T y may hide of b.y
ZERO_ENTRY = 1e-9  # chosen: an entry of the proposed y below this, relative to its largest, is tried as 0


def infeasibility_certificate(A: Any, b: np.ndarray, free: np.ndarray | None = None) -> np.ndarray | None:
    """A checked y, shape (n,), or None.

    Parameters
    ----------
    A : ndarray or scipy.sparse matrix, shape (n, n)
    b : ndarray, shape (n,)
    free : ndarray of bool, shape (n,), optional
        Rows with w_i = 0 and z_i of either sign: there y_i may have either sign and (A^T y)_i must vanish.
    """
    from scipy.optimize import linprog

    n = len(b)
    free = np.zeros(n, dtype=bool) if free is None else free
    alone = hopeless_row(A, b, free)
    if alone is not None:
        return alone
    scaled, c, row, _ = scaled_problem(A, b)
    bounds = np.column_stack([np.where(free, -1.0, 0.0), np.ones(n)])
    transposed = scaled.T
    options: dict[str, Any] = {"A_ub": transposed[~free], "b_ub": np.zeros(int((~free).sum()))}
    if free.any():
        options |= {"A_eq": transposed[free], "b_eq": np.zeros(int(free.sum()))}
    answer = linprog(c, bounds=bounds, method="highs", **options)
    if answer.x is None or not answer.fun < 0:
        return None
    y = np.where(free, answer.x, np.maximum(answer.x, 0.0))
    for candidate in (y, _polished(transposed, y, free)):
        if is_certificate(scaled, c, candidate, free):
            return row * candidate
    return None


def hopeless_row(A: Any, b: np.ndarray, free: np.ndarray) -> np.ndarray | None:
    """The certificate of one row, exact whatever its size: b_i < 0 and no A_ij that could lift it; None without one."""
    lifts = np.asarray((abs(A[:, free]) > 0).sum(axis=1)).ravel() + np.asarray((A[:, ~free] > 0).sum(axis=1)).ravel()
    rows = np.flatnonzero((b < 0) & (lifts == 0) & ~free)
    if not len(rows):
        return None
    y = np.zeros(len(b))
    y[rows[0]] = 1.0
    return y


def is_certificate(A: Any, b: np.ndarray, y: np.ndarray, free: np.ndarray | None = None) -> bool:
    """Whether y >= 0, A^T y <= 0 (= 0 in free columns) and b.y < 0 hold within the rounding of the sums."""
    n = len(b)
    free = np.zeros(n, dtype=bool) if free is None else free
    bound = rounding_of_sum(CERTIFICATE_ROUNDINGS * n, abs(A).T @ abs(y))
    slope = A.T @ y
    is_sign_right = bool((y[~free] >= 0).all())
    is_slope_right = bool((slope <= bound).all() and (slope[free] >= -bound[free]).all())
    # b.y must exceed its own rounding, and what the rounding of A^T y could hide
    return (
        is_sign_right
        and is_slope_right
        and bool(b @ y < -rounding_of_sum(CERTIFICATE_ROUNDINGS * n, abs(b) @ abs(y)) - rounding_of_sum(2, HIDDEN_SIZE))
    )


def _polished(transposed: Any, y: np.ndarray, free: np.ndarray) -> np.ndarray:
    """The y of the same support for which the equations it nearly fulfils hold to rounding."""
    dense = transposed if isinstance(transposed, np.ndarray) else transposed.toarray()
    largest = np.abs(y).max()
    support = np.abs(y) > ZERO_ENTRY * largest
    tight = free | (np.abs(dense @ y) <= ZERO_ENTRY * largest)
    block = dense[np.ix_(tight, support)]
    polished = np.zeros_like(y)
    correction, *_ = np.linalg.lstsq(block, block @ y[support], rcond=None)
    polished[support] = y[support] - correction
    return np.where(free, polished, np.maximum(polished, 0.0))
