"""Interior points for  w = A z + b,  0 <= w _|_ z >= 0  with many unknowns, dense or sparse.

    z_i w_i = tau,    tau -> 0,    dw = A dz + A z + b - w,
    (A + diag(w / z)) dz = -(A z + b) + (sigma tau - dz_a dw_a) / z

by Mehrotra's predictor (sigma = 0, no dz_a dw_a) and corrector. Ten to thirty steps for a positive semidefinite A,
symmetric or not, whatever its rank and condition: where projected Gauss-Seidel stalls on redundant contacts. The set
{z_i > w_i} is solved exactly at the end, where it is regular.

Source: Mehrotra, SIAM J. Optim. 2 (1992) 575-601; Kojima, Megiddo, Noma and Yoshise, A Unified Approach to Interior
Point Algorithms for Linear Complementarity Problems (1991).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.lcp.newton import solve_active_set
from nonsmooth.lcp.result import natural_scales

ORTHANT_STEP_PART = 0.99  # chosen: of the way to the boundary that a step goes at most
LEAST_START = 1.0  # chosen: least z and w of the scaled problem, whose b and diagonal have entries near 1


def solve_by_interior_point(
    A: Any, b: np.ndarray, z: np.ndarray, tol: float, max_iterations: int
) -> tuple[np.ndarray, bool, int]:
    """Solve from the neighbourhood of the guess z >= 0.

    Parameters
    ----------
    A : ndarray or scipy.sparse matrix, shape (n, n)
    b, z : ndarray, shape (n,)
    tol : float
        On the residual of ``lcp_residual``.
    max_iterations : int

    Returns
    -------
    z, is_converged, iterations
    """
    if (b >= 0).all():
        return np.zeros_like(b), True, 0
    d = 1.0 / np.sqrt(natural_scales(A))  # one factor for row and column: a semidefinite matrix stays one
    A = d[:, None] * A * d if isinstance(A, np.ndarray) else A.multiply(d[:, None]).multiply(d).tocsr()
    size, largest = np.abs(d * b).max(), np.abs(b).max()
    b, z, most = d * b / size, z / (d * size) + LEAST_START, d * largest / size
    w, sizes = np.maximum(A @ z + b, 0.0) + LEAST_START, abs(A)

    def error(z: np.ndarray) -> float:
        wrong = np.abs(np.minimum(z, A @ z + b))
        least = np.minimum(np.abs(b) + sizes @ np.abs(z), most)
        return float(np.divide(wrong, least, out=np.zeros_like(wrong), where=wrong > 0.0).max())

    best, least = z, error(z)
    for count in range(max_iterations):
        if least <= tol:
            corner = solve_active_set(A, b, best > A @ best + b)
            if corner is not None and error(corner := np.maximum(corner, 0.0)) < least:
                best = corner
            return best * d * size, True, count
        step = _step(A, b, z, w)
        if step is None:
            break
        z, w = z + step[0], w + step[1]
        if (reached := error(z)) < least:
            best, least = z, reached
    return best * d * size, least <= tol, max_iterations


def _step(A: Any, b: np.ndarray, z: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Predictor and corrector; None where the numbers run out."""
    ahead = A @ z + b
    gap = z @ w / len(b)
    solve = _factors(A, w / z)
    if solve is None:
        return None
    dz = solve(-ahead)
    dw = A @ dz + ahead - w
    length = min(1.0, _way_out(z, dz), _way_out(w, dw))
    centring = min(1.0, max(0.0, (z + length * dz) @ (w + length * dw) / len(b) / gap)) ** 3
    dz = solve(-ahead + (centring * gap - dz * dw) / z)
    dw = A @ dz + ahead - w
    if not (np.isfinite(dz).all() and np.isfinite(dw).all()):
        return None
    length = min(1.0, ORTHANT_STEP_PART * min(_way_out(z, dz), _way_out(w, dw)))
    return length * dz, length * dw


def _way_out(x: np.ndarray, dx: np.ndarray) -> float:
    with np.errstate(divide="ignore"):
        return float(np.where(dx < 0, -x / dx, np.inf).min())


def _factors(A: Any, diagonal: np.ndarray) -> Callable[[np.ndarray], np.ndarray] | None:
    """The function f -> (A + diag)^-1 f."""
    if isinstance(A, np.ndarray):
        from scipy.linalg import lu_factor, lu_solve

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            factors = lu_factor(A + np.diag(diagonal), check_finite=False)
        return lambda f: lu_solve(factors, f, check_finite=False)
    from scipy.sparse import diags_array
    from scipy.sparse.linalg import splu

    matrix = (A + diags_array(diagonal)).tocsc()
    try:  # pivots on the diagonal keep the factors as sparse as those of Cholesky
        lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return None
    return lu.solve
