"""An LCP with a symmetric positive semidefinite matrix as the quadratic program it is the optimality condition of:

    min  z.A z / 2 + b.z   over   z >= 0          <=>          w = A z + b,   0 <= w _|_ z >= 0

by any solver that qpsolvers finds installed. For another matrix the program has other solutions than the LCP, so it is
refused, not symmetrised. The unknowns are scaled to order 1 (R = E keeps the symmetry), and since interior-point and
splitting solvers stop at their own tolerance, the active set they found is solved exactly where that is better.

Source: R. W. Cottle, J.-S. Pang, R. E. Stone, The Linear Complementarity Problem, 1992, section 1.4.
Equations: docs/theory/lcp.md, (8).
"""

from __future__ import annotations

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.lcp.newton import linear_solve
from nonsmooth.numerics.quadratic_program import minimise

SYMMETRY = 1e-12  # derived: |A - A^T| allowed, relative to the largest entry: rounding of a product W M^-1 W^T
DEFINITENESS = 1e-10  # derived: negative eigenvalue allowed, relative to the largest: rounding of a rank-deficient one


def why_not_a_qp(A: np.ndarray) -> str:
    """The reason why the LCP is not a convex quadratic program; empty if it is one."""
    largest = np.abs(A).max(initial=0.0)
    asymmetry = np.abs(A - A.T).max(initial=0.0)
    if asymmetry > SYMMETRY * largest:
        return f"A is not symmetric: max |A - A^T| is {asymmetry / largest:.1e} of max |A|"
    d = _symmetric_scale(A)
    eigenvalues = np.linalg.eigvalsh(d[:, None] * (0.5 * (A + A.T)) * d)
    if eigenvalues[0] < -DEFINITENESS * max(eigenvalues[-1], -eigenvalues[0]):
        return f"A is not positive semidefinite: the equilibrated matrix has the eigenvalue {eigenvalues[0]:.1e}"
    return ""


def solve_as_qp(A: np.ndarray, b: np.ndarray, guess: np.ndarray, name: str) -> tuple[np.ndarray, bool]:
    """Solve by the qpsolvers solver of this name; returns z and whether the solver claims success.

    Raises
    ------
    InvalidInput
        When A is unsymmetric or indefinite.
    """
    reason = why_not_a_qp(A)
    if reason:
        raise InvalidInput(f"solver {name!r} solves quadratic programs only: {reason}; choose another, such as 'lemke'")
    d = _symmetric_scale(A)
    size = np.abs(d * b).max() or 1.0
    P, q = d[:, None] * (0.5 * (A + A.T)) * d, d * b / size
    x = minimise(P, q, lower=np.zeros(len(b)), guess=guess / (d * size), solver=name)
    if x is None:
        return guess, False
    z = np.maximum(x, 0.0)
    return size * d * _on_active_set(P, q, z), True


def _on_active_set(P: np.ndarray, q: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The solution with the active set {z_i > w_i}, if its error is less than that of z."""
    active = np.flatnonzero(z > P @ z + q)
    block = P[np.ix_(active, active)]
    solution = linear_solve(block, -q[active])
    if solution is None:
        return z
    correction = linear_solve(block, -q[active] - block @ solution)
    corner = np.zeros(len(q))
    corner[active] = np.maximum(solution if correction is None else solution + correction, 0.0)

    def error(x: np.ndarray) -> float:
        return float(np.abs(np.minimum(x, P @ x + q)).max())

    return corner if error(corner) < error(z) else z


def _symmetric_scale(A: np.ndarray) -> np.ndarray:
    """Powers of two d with d_i^2 A_ii near 1 (the row's largest entry where A_ii = 0)."""
    diagonal = np.abs(np.diagonal(A))
    size = np.where(diagonal > 0, diagonal, np.abs(A).max(axis=1, initial=0.0))
    return np.where(size > 0, np.exp2(-(np.frexp(size)[1] // 2).astype(float)), 1.0)
