"""Semismooth Newton on the Alart-Curnier equations, with a line search.

With x = rho P - gamma and gamma = G P + c,

    F_N = rho P_N - max(0, x_N),    F_T = rho P_T - proj(x_T, disc of radius mu max(0, x_N)),    F(P) = 0.

F is piecewise smooth; an element of its generalised Jacobian is A + B G with block-diagonal A and B:

    open    x_N <= 0            F = rho P                          A = rho I,   B = 0
    stick   |x_T| <= mu x_N     F = gamma                          A = 0,       B = I
    slide   otherwise           F_N = gamma_N,  F_T = rho P_T - mu x_N t,  t = x_T / |x_T|,
            A_TT = rho (I - D),  A_TN = -rho mu t,  B_TT = D,  B_TN = mu t,  D = mu x_N / |x_T| (I - t t^T)

Locally quadratic when the Jacobian is regular. It is singular where G is, for stacked and other hyperstatic contacts; a
shift by 1e-9 then selects one of the many impulses, once the modes are right.

Source: Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353-375; the nonmonotone search is that of Grippo,
Lampariello and Lucidi, SIAM J. Numer. Anal. 23 (1986) 707-716.
Equations: docs/theory/contact_solvers.md, (4).
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from nonsmooth.contact.blocks.linear import factorise
from nonsmooth.contact.blocks.problem import Problem
from nonsmooth.jit import kernel

# measured: on the diagonal of the Jacobian: with 1e-11 redundant contacts keep an error of 1e-12 (walls with 100
# contacts take 1.1 to 2.2 times as long), with 1e-7 regular ones take more steps
JACOBIAN_SHIFT = 1e-9


@dataclass(frozen=True)
class Newton:
    """Options of the semismooth Newton method.

    Parameters
    ----------
    max_iterations : int
        Linear solves after which the best iterate is returned.
    memory : int
        The merit |F| must fall below the largest of this many previous ones: 1 is a monotone search.
    patience : int
        Steps within which the error must halve, lest the search be given up.
    """

    max_iterations: int = 100
    memory: int = 4
    patience: int = 12

    name = "newton"

    def run(self, problem: Problem, P: np.ndarray, tol: float, until: float = math.inf) -> tuple[np.ndarray, int]:
        """Iterate from P; returns the best iterate found and the number of linear solves."""
        equations = Equations(problem)
        merit = equations.evaluate(P)
        best, least = P, problem.error(P)
        past, mark, since = [merit], least, 0
        for count in range(self.max_iterations):
            if least <= tol or since == self.patience or time.monotonic() >= until:
                return best, count
            step = equations.step()
            if step is None:
                return best, count
            P, merit = line_search(equations, P, step, max(past[-self.memory :]))
            past.append(merit)
            error = problem.error(P)
            if error < least:
                best, least = P, error
            since += 1
            if least <= 0.5 * mark:
                mark, since = least, 0
            if not np.isfinite(merit):
                return best, count + 1
        return best, self.max_iterations


class Equations:
    """F and its Jacobian at one point: written by `evaluate`, read by `step`."""

    def __init__(self, problem: Problem) -> None:
        shape = (problem.n_c, problem.dim, problem.dim)
        self.problem = problem
        self.A, self.B = np.empty(shape), np.empty(shape)
        self.F, self.gamma = np.empty(problem.n), np.empty(problem.n)

    def evaluate(self, P: np.ndarray) -> float:
        """Linearise at P; returns |F|."""
        problem, blocks = self.problem, self.problem.blocks
        self.gamma = problem.velocity(P)
        alart_curnier_entry(blocks.G, problem.mu, problem.rho, P, self.gamma, self.A, self.B, self.F)
        merit = float(np.linalg.norm(self.F))
        return merit if np.isfinite(merit) else np.inf

    def step(self) -> np.ndarray | None:
        """The Newton step -(A + B G)^-1 F, or None where the Jacobian is singular beyond a shift by roundings."""
        shift = JACOBIAN_SHIFT * np.eye(self.problem.dim)
        solve = factorise(self.problem.blocks, self.A + shift, self.B)
        if solve is None:
            return None
        step = solve(-self.F)
        return step if np.isfinite(step).all() else None


def line_search(equations: Equations, P: np.ndarray, step: np.ndarray, bound: float) -> tuple[np.ndarray, float]:
    """Halve the step until |F| falls below the bound; after ten halvings take the best point seen."""
    length, best, least, P_best = 1.0, P, np.inf, P
    for _ in range(10):
        best = P + length * step
        merit = equations.evaluate(best)
        if merit <= (1.0 - 1e-4 * length) * bound:
            return best, merit
        if merit < least:
            least, P_best = merit, best
        length *= 0.5
    return P_best, equations.evaluate(P_best)


@kernel
def alart_curnier(G, mu, rho, P, gamma, A, B, F):
    """Write the equations F and the blocks A, B of their Jacobian A + B G."""
    dim = G.shape[1]
    for i in range(mu.shape[0]):
        k = i * dim
        r = rho[i]
        for a in range(dim):
            for b in range(dim):
                A[i, a, b] = 0.0
                B[i, a, b] = 0.0
        x_N = r * P[k] - gamma[k]
        if x_N <= 0.0:
            for a in range(dim):
                F[k + a] = r * P[k + a]
                A[i, a, a] = r
            continue
        F[k] = gamma[k]
        B[i, 0, 0] = 1.0
        x_1 = r * P[k + 1] - gamma[k + 1]
        x_2 = r * P[k + 2] - gamma[k + 2] if dim == 3 else 0.0
        x_T = math.sqrt(x_1 * x_1 + x_2 * x_2)
        radius = mu[i] * x_N
        if x_T <= radius and radius > 0.0:
            for a in range(1, dim):
                F[k + a] = gamma[k + a]
                B[i, a, a] = 1.0
            continue
        t_1 = x_1 / x_T if x_T > 0.0 else 0.0
        t_2 = x_2 / x_T if x_T > 0.0 else 0.0
        shrink = radius / x_T if x_T > 0.0 else 0.0
        for a in range(1, dim):
            t_a = t_1 if a == 1 else t_2
            F[k + a] = r * P[k + a] - radius * t_a
            A[i, a, 0] = -r * mu[i] * t_a
            B[i, a, 0] = mu[i] * t_a
            for b in range(1, dim):
                t_b = t_1 if b == 1 else t_2
                D = shrink * ((1.0 if a == b else 0.0) - t_a * t_b)
                A[i, a, b] = r * ((1.0 if a == b else 0.0) - D)
                B[i, a, b] = D


@kernel(
    "void(float64[:, :, ::1], float64[::1], float64[::1], float64[::1], float64[::1], float64[:, :, ::1],"
    " float64[:, :, ::1], float64[::1])",
    takes_arrays=True,
)
def alart_curnier_entry(G, mu, rho, P, gamma, A, B, F):
    """`alart_curnier` for calls from Python."""
    alart_curnier(G, mu, rho, P, gamma, A, B, F)
