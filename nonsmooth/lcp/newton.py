"""Semismooth Newton on the Fischer–Burmeister equations, dense or sparse, mixed problems included.

    phi_i = z_i + w_i - sqrt(z_i^2 + w_i^2) = 0   (complementary rows),      phi_i = w_i = 0   (free rows)
    J d = -phi,   J = D_z + D_w A,   D_z = 1 - z / r,  D_w = 1 - w / r,  r = sqrt(z^2 + w^2)

with a backtracking line search on theta = |phi|^2 / 2 and, where the Newton direction does not descend, a
Levenberg–Marquardt step (J^T J + nu I) d = -J^T phi. The iterate only has to find the active set {z_i > w_i}: solving
that set's linear equations (one Newton step on min(z, w)) is tried at every iterate near enough and ends at rounding.

Source: T. De Luca, F. Facchinei, C. Kanzow, A semismooth equation approach to the solution of nonlinear complementarity
problems, Mathematical Programming 75 (1996) 407-439.
Equations: docs/theory/lcp.md, (7).
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from nonsmooth.lcp.scaling import scaled_problem

ARMIJO_PART = 1e-4  # chosen: Armijo's fraction of the predicted decrease
SHORTEST_SEARCH = 1e-10  # chosen: step length at which a line search is given up
RELATIVE_DESCENT = 1e-10  # chosen: cos^2-like bound below which a Newton direction is not one of descent
NEAR_SOLUTION = 0.1  # chosen: |phi| relative to the scaled problem from which the active set is tried


def solve_by_semismooth_newton(A: Any, b: np.ndarray, z: np.ndarray, free: np.ndarray, tol: float,
           max_iterations: int) -> tuple[np.ndarray, bool, int]:  # fmt: skip
    """Solve from the guess z.

    Parameters
    ----------
    A : ndarray or scipy.sparse matrix, shape (n, n)
    b, z : ndarray, shape (n,)
    free : ndarray of bool, shape (n,)
        Rows with w_i = 0 and z_i of either sign.
    tol : float
        On max |min(z, w)| of the equilibrated problem, whose b has entries up to 1.
    max_iterations : int

    Returns
    -------
    z, is_converged, iterations
    """
    A, b, _, column = scaled_problem(A, b)
    z = z / column
    for iteration in range(max_iterations):
        w = A @ z + b
        phi = _phi(z, w, free)
        length = np.abs(phi).max()
        if not np.isfinite(length):
            return z * column, False, iteration
        if length < NEAR_SOLUTION:
            corner = solve_active_set(A, b, (z > w) | free)
            if corner is not None and _error(A, b, corner, free) <= tol:
                return np.where(free, corner, np.maximum(corner, 0.0)) * column, True, iteration + 1
        if length <= 0.1 * tol:
            return np.where(free, z, np.maximum(z, 0.0)) * column, True, iteration
        step = _step(A, b, z, w, phi, free)
        if step is None:
            return z * column, False, iteration + 1
        z = z + step
    return z * column, False, max_iterations


def _phi(z: np.ndarray, w: np.ndarray, free: np.ndarray) -> np.ndarray:
    total = z + w
    r = np.hypot(z, w)
    with np.errstate(divide="ignore", invalid="ignore"):
        stable = np.where(total > 0, 2 * z * w / (total + r), total - r)  # no cancellation for z, w > 0
    return np.where(free, w, stable)


def _error(A: Any, b: np.ndarray, z: np.ndarray, free: np.ndarray) -> float:
    w = A @ z + b
    return float(np.abs(np.where(free, w, np.minimum(z, w))).max())


def _step(A: Any, b: np.ndarray, z: np.ndarray, w: np.ndarray, phi: np.ndarray, free: np.ndarray) -> np.ndarray | None:
    """The step to take, damped; None when no direction descends."""
    r = np.hypot(z, w)
    at_corner = r == 0
    r = np.where(at_corner, 1.0, r)
    half = 1 - np.sqrt(0.5)  # the element of the B-subdifferential at (0, 0) with z and w alike
    D_z = np.where(free, 0.0, np.where(at_corner, half, 1 - z / r))
    D_w = np.where(free, 1.0, np.where(at_corner, half, 1 - w / r))
    J = _diagonal_plus(D_z, D_w, A)
    gradient = J.T @ phi
    theta = 0.5 * phi @ phi
    damping = None
    while True:
        d = _direction(J, phi, gradient, damping)
        if d is not None and gradient @ d < -RELATIVE_DESCENT * max(theta, d @ d):
            t = 1.0
            while t > SHORTEST_SEARCH:
                trial = z + t * d
                new = _phi(trial, A @ trial + b, free)
                if 0.5 * new @ new <= theta + ARMIJO_PART * t * (gradient @ d):
                    return t * d
                t *= 0.5
        if damping is not None and damping > 1.0:
            return None
        damping = 1e-8 if damping is None else 1e3 * damping


def _diagonal_plus(D_z: np.ndarray, D_w: np.ndarray, A: Any) -> Any:
    if isinstance(A, np.ndarray):
        return np.diag(D_z) + D_w[:, None] * A
    from scipy import sparse

    return sparse.diags_array(D_z) + A.multiply(D_w[:, None])


def _direction(J: Any, phi: np.ndarray, gradient: np.ndarray, damping: float | None) -> np.ndarray | None:
    """The Newton direction, or with damping nu the Levenberg–Marquardt one; None if the matrix is singular."""
    if damping is None:
        return linear_solve(J, -phi)
    normal = J.T @ J
    size = normal.diagonal().max() or 1.0
    nu = np.full(len(phi), damping * size)
    return linear_solve(_diagonal_plus(nu, np.ones(len(phi)), normal), -gradient)


def solve_active_set(A: Any, b: np.ndarray, active: np.ndarray) -> np.ndarray | None:
    """z with w_i = 0 on the active set and z_i = 0 elsewhere, refined once; None if there is none."""
    index = np.flatnonzero(active)
    z = np.zeros(len(b))
    if len(index):
        block = A[np.ix_(index, index)] if isinstance(A, np.ndarray) else A[index][:, index]
        solution = linear_solve(block, -b[index])
        if solution is None:
            return None
        correction = linear_solve(block, -b[index] - block @ solution)
        z[index] = solution if correction is None else solution + correction
    return z


def linear_solve(A: Any, b: np.ndarray) -> np.ndarray | None:
    """A^-1 b for a dense or sparse matrix; None if it is singular or the result not finite."""
    try:
        if isinstance(A, np.ndarray):
            x = np.linalg.solve(A, b)
        else:
            from scipy.sparse.linalg import splu

            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                x = splu(A.tocsc()).solve(b)
    except (np.linalg.LinAlgError, RuntimeError):
        return None
    return x if np.isfinite(x).all() else None
