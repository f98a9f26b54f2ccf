"""Interior points: Newton on the smoothed inclusion, in a scaling that makes both cones one.

With x = S P, y = S^-1 uhat, S = diag(mu, 1, 1), the inclusion K* contains uhat _|_ P in K of a contact reads

    x, y in L,    x o y = 0,    y = S^-1 (G P + c) + |y_T| e_N,          L and o in ``second_order_cone``.

x o y = tau e_N is followed to tau = 0. With W the Nesterov-Todd matrix of the point, a step solves

    (B G + S W^-2 S) dP = S (r - (I + theta E) R),    dy = r - W^-2 dx,    B = I + theta mu E,   E = e_N y_T^T / |y_T|,

R the residual of the last equation, r = -y for the predictor; the corrector adds W^-1 q to it, where
(W y) o q = tau e_N - (W^-1 dx) o (W dy) with the predictor's dx and dy. theta is the share of the derivative of |y_T|
that is used: with all of it convergence is fast, with none a step is that of a convex problem with frozen sliding
speeds. It falls when steps get short and rises again.

The matrix is regular where G is not, and mass ratios do not lengthen the path. It ends inside the solution set, at
1e-6 or better; Newton's method finds the last digits. Where mu = 0 the cone is a half-line and P_T = 0.

Source: Mehrotra, SIAM J. Optim. 2 (1992) 575-601 (predictor, corrector); for friction Acary, Armand, Nguyen and
Shpakovych, Optim. Methods Softw. 39 (2024) 634-663, who freeze the sliding speeds (theta = 0).
Equations: docs/theory/contact_solvers.md, (5).
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from nonsmooth.contact.blocks.linear import Solve, factorise
from nonsmooth.contact.blocks.problem import Problem
from nonsmooth.contact.blocks.second_order_cone import (
    corrector_target,
    distance_to_boundary,
    scaling_point,
)
from nonsmooth.jit import kernel

CONE_STEP_PART = 0.95  # chosen: of the way to the boundary of the cones that a step goes at most
SHORT_STEP, THETA_RISE = 0.2, 0.2  # chosen: a step below SHORT_STEP halves theta, any other adds THETA_RISE
INTERIOR_PATIENCE = 12  # chosen: steps without a smaller error after which no more is expected


@dataclass(frozen=True)
class Interior:
    """Options of the interior point method.

    Parameters
    ----------
    start : float
        Distance from the boundary of the cones at which the iteration starts, in units of the scaled problem [-].
    max_iterations : int
        Steps after which the best iterate is returned.
    """

    start: float = 0.3
    max_iterations: int = 60

    name = "interior"

    def run(self, problem: Problem, P: np.ndarray, tol: float, until: float = math.inf) -> tuple[np.ndarray, int]:
        """Iterate from the neighbourhood of P; returns the best iterate found and the number of steps."""
        best, least = P, problem.error(P)
        point = InteriorPoint(problem, P, self.start)
        reached, waited = np.inf, 0
        for count in range(self.max_iterations):
            if least <= tol or waited == INTERIOR_PATIENCE or time.monotonic() >= until:
                return best, count
            if not point.step():
                return best, count + 1
            error = problem.error(point.P)
            waited = 0 if error < 0.9 * reached else waited + 1
            reached = min(error, reached)
            if error < least:
                best, least = point.P.copy(), error
        return best, self.max_iterations


class InteriorPoint:
    """The point (x, y), and what a step from it needs; the third component vanishes in the plane."""

    def __init__(self, problem: Problem, P: np.ndarray, start: float) -> None:
        n_c, dim = problem.n_c, problem.dim
        self.problem, self.P, self.theta = problem, P.copy(), 1.0
        self.x, self.y, self.dx, self.dy, self.residual, self.target = np.zeros((6, n_c, 3))
        self.w = np.empty((n_c, 4))
        self.A, self.B = np.empty((2, n_c, dim, dim))
        self.rhs = np.empty(problem.n)
        enter(problem.mu, dim, problem.velocity(P), start, self.P, self.x, self.y)

    def step(self) -> bool:
        """One predictor and corrector; False where the numbers run out."""
        problem, x, y = self.problem, self.x, self.y
        gap = find_residual(problem.mu, problem.dim, problem.velocity(self.P), x, y, self.residual)
        linearise(problem.mu, problem.dim, self.theta, x, y, self.w, self.A, self.B)
        solve = factorise(problem.blocks, self.A, self.B, keeps_diagonal=True)
        if solve is None or not gap > 0.0:
            return False
        np.negative(y, out=self.target)
        self._direction(solve)
        _, gap_ahead = longest_step(x, y, self.dx, self.dy, 1.0)
        centring = min(1.0, max(0.0, gap_ahead / gap)) ** 3
        correct(self.w, y, self.dx, self.dy, centring * gap, self.target)
        self._direction(solve)
        length, gap_ahead = longest_step(x, y, self.dx, self.dy, CONE_STEP_PART)
        if not (length > 0.0 and math.isfinite(gap_ahead)):
            return False
        x += length * self.dx
        y += length * self.dy
        leave(problem.mu, problem.dim, x, self.P)
        self.theta = 0.5 * self.theta if length < SHORT_STEP else min(1.0, self.theta + THETA_RISE)
        return True

    def _direction(self, solve: Solve) -> None:
        """The step for the target r."""
        mu, dim = self.problem.mu, self.problem.dim
        right_side(mu, dim, self.theta, self.y, self.target, self.residual, self.rhs)
        direction(mu, dim, self.w, self.target, solve(self.rhs), self.dx, self.dy)


@kernel(
    "void(float64[::1], int64, float64[::1], float64, float64[::1], float64[:, ::1], float64[:, ::1])",
    takes_arrays=True,
)
def enter(mu, dim, gamma, start, P, x, y):
    """x and y inside the cones by ``start``, next to P and its velocities; P follows x."""
    for i in range(mu.shape[0]):
        k = i * dim
        s = mu[i] if mu[i] > 0.0 else 1.0
        for a in range(1, dim if mu[i] > 0.0 else 1):
            x[i, a] = P[k + a]
            y[i, a] = gamma[k + a]
        x[i, 0] = max(s * P[k], math.hypot(x[i, 1], x[i, 2])) + start
        y[i, 0] = max(gamma[k] / s, 0.0) + math.hypot(y[i, 1], y[i, 2]) + start
    _write(mu, dim, x, P)


@kernel
def _write(mu, dim, x, P):
    for i in range(mu.shape[0]):
        P[i * dim] = x[i, 0] / mu[i] if mu[i] > 0.0 else x[i, 0]
        for a in range(1, dim):
            P[i * dim + a] = x[i, a]


@kernel("void(float64[::1], int64, float64[:, ::1], float64[::1])", takes_arrays=True)
def leave(mu, dim, x, P):
    """P = S^-1 x."""
    _write(mu, dim, x, P)


@kernel(
    "float64(float64[::1], int64, float64[::1], float64[:, ::1], float64[:, ::1], float64[:, ::1])", takes_arrays=True
)
def find_residual(mu, dim, gamma, x, y, residual):
    """Write R; returns the mean gap x . y."""
    gap = 0.0
    for i in range(mu.shape[0]):
        is_cone = mu[i] > 0.0
        s = mu[i] if is_cone else 1.0
        y_T = math.hypot(y[i, 1], y[i, 2])
        residual[i, 0] = gamma[i * dim] / s + y_T - y[i, 0]
        for a in range(dim):
            gap += x[i, a] * y[i, a]
            if a > 0:
                residual[i, a] = gamma[i * dim + a] - y[i, a] if is_cone else 0.0
    return gap / mu.shape[0]


@kernel(
    "void(float64[::1], int64, float64, float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, :, ::1],"
    " float64[:, :, ::1])",
    takes_arrays=True,
)
def linearise(mu, dim, theta, x, y, w, A, B):
    """Write W (as w, eta) and the blocks A = S W^-2 S, B of the matrix A + B G."""
    for i in range(mu.shape[0]):
        is_cone = mu[i] > 0.0
        s = mu[i] if is_cone else 1.0
        y_T = math.hypot(y[i, 1], y[i, 2])
        w_N, w_1, w_2, eta = scaling_point(x[i, 0], x[i, 1], x[i, 2], y[i, 0], y[i, 1], y[i, 2])
        w[i, 0] = w_N
        w[i, 1] = w_1
        w[i, 2] = w_2
        w[i, 3] = eta
        for a in range(dim):
            for b in range(dim):
                A[i, a, b] = 0.0
                B[i, a, b] = 0.0
            A[i, a, a] = 1.0
        B[i, 0, 0] = 1.0
        A[i, 0, 0] = s * s * (2.0 * w_N * w_N - 1.0) / (eta * eta)
        for a in range(1, dim if is_cone else 1):
            A[i, 0, a] = -2.0 * s * w_N * w[i, a] / (eta * eta)
            A[i, a, 0] = A[i, 0, a]
            for b in range(1, dim):
                A[i, a, b] = (2.0 * w[i, a] * w[i, b] + (1.0 if a == b else 0.0)) / (eta * eta)
            B[i, a, a] = 1.0
            B[i, 0, a] = theta * s * y[i, a] / y_T if y_T > 0.0 else 0.0


@kernel(
    "void(float64[::1], int64, float64, float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[::1])",
    takes_arrays=True,
)
def right_side(mu, dim, theta, y, target, residual, rhs):
    """S (r - (I + theta E) R)."""
    for i in range(mu.shape[0]):
        y_T = math.hypot(y[i, 1], y[i, 2])
        slip = (y[i, 1] * residual[i, 1] + y[i, 2] * residual[i, 2]) / y_T if y_T > 0.0 else 0.0
        s = mu[i] if mu[i] > 0.0 else 1.0
        rhs[i * dim] = s * (target[i, 0] - residual[i, 0] - theta * slip)
        for a in range(1, dim):
            rhs[i * dim + a] = target[i, a] - residual[i, a] if mu[i] > 0.0 else 0.0


@kernel(
    "void(float64[::1], int64, float64[:, ::1], float64[:, ::1], float64[::1], float64[:, ::1], float64[:, ::1])",
    takes_arrays=True,
)
def direction(mu, dim, w, target, dP, dx, dy):
    """The steps dx = S dP and dy = r - W^-2 dx."""
    for i in range(mu.shape[0]):
        dx[i, 0] = dP[i * dim] * (mu[i] if mu[i] > 0.0 else 1.0)
        for a in range(1, dim):
            dx[i, a] = dP[i * dim + a]
        share = 2.0 * (w[i, 0] * dx[i, 0] - w[i, 1] * dx[i, 1] - w[i, 2] * dx[i, 2])  # 2 (J w) . dx
        inverse = 1.0 / (w[i, 3] * w[i, 3])
        dy[i, 0] = target[i, 0] - inverse * (share * w[i, 0] - dx[i, 0])
        dy[i, 1] = target[i, 1] - inverse * (dx[i, 1] - share * w[i, 1])
        dy[i, 2] = target[i, 2] - inverse * (dx[i, 2] - share * w[i, 2])


@kernel(
    "void(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1], float64, float64[:, ::1])",
    takes_arrays=True,
)
def correct(w, y, dx, dy, tau, target):
    """Write r = -y + W^-1 q, q the vector with (W y) o q = tau e_N - (W^-1 dx) o (W dy)."""
    for i in range(w.shape[0]):
        of_w, of_y = (w[i, 0], w[i, 1], w[i, 2], w[i, 3]), (y[i, 0], y[i, 1], y[i, 2])
        of_dx, of_dy = (dx[i, 0], dx[i, 1], dx[i, 2]), (dy[i, 0], dy[i, 1], dy[i, 2])
        target[i, 0], target[i, 1], target[i, 2] = corrector_target(of_w, of_y, of_dx, of_dy, tau)


@kernel(
    "UniTuple(float64, 2)(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1], float64)",
    takes_arrays=True,
)
def longest_step(x, y, dx, dy, boundary):
    """The step length, at most 1 and ``boundary`` of the way out of the cones, and the mean gap after it."""
    out = math.inf
    for i in range(x.shape[0]):
        out = min(out, distance_to_boundary(x[i, 0], x[i, 1], x[i, 2], dx[i, 0], dx[i, 1], dx[i, 2]))
        out = min(out, distance_to_boundary(y[i, 0], y[i, 1], y[i, 2], dy[i, 0], dy[i, 1], dy[i, 2]))
    length = min(1.0, boundary * out)
    gap = 0.0
    for i in range(x.shape[0]):
        for a in range(3):
            gap += (x[i, a] + length * dx[i, a]) * (y[i, a] + length * dy[i, a])
    return length, gap / x.shape[0]
