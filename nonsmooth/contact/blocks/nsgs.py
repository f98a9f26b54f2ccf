"""Nonsmooth Gauss-Seidel: one contact after the other is solved exactly, the others held fixed.

    b_i = c_i + sum over j != i of G_ij P_j,    P_i <- solution(G_ii, b_i, mu_i)

A sweep costs one product G P and n_c single contacts. It converges for most rigid-body problems, linearly, and slowly
where G has no full rank or the masses differ much.

Source: Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235-257; Acary and Brogliato (2008), section 13.7.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from nonsmooth.contact.blocks.problem import Problem
from nonsmooth.contact.blocks.single_spatial import local_spatial
from nonsmooth.contact.planar.single import stick
from nonsmooth.jit import kernel

MEASURED_EVERY = 25  # chosen: sweeps between two measurements of the error, and two looks at the clock


@dataclass(frozen=True)
class NSGS:
    """Options of nonsmooth Gauss-Seidel.

    Parameters
    ----------
    max_sweeps : int
        Sweeps after which the best iterate is returned.
    """

    max_sweeps: int = 10_000

    name = "nsgs"

    def run(self, problem: Problem, P: np.ndarray, tol: float, until: float = math.inf) -> tuple[np.ndarray, int]:
        """Iterate from P; returns the best iterate found and the number of sweeps."""
        rows = problem.blocks.G, problem.blocks.indices, problem.blocks.indptr
        stretch = problem.weight * problem.rho
        P, best, least, total = P.copy(), P, np.inf, 0
        while total < self.max_sweeps:
            most = min(MEASURED_EVERY - total % MEASURED_EVERY, self.max_sweeps - total)
            sweeps, change = nsgs(rows, problem.c, problem.mu, stretch, P, tol, most)
            total, error = total + sweeps, problem.error(P)
            if error < least:
                best, least = P.copy(), error
            if error <= tol or not change > 0.0 or not np.isfinite(error) or time.monotonic() >= until:
                break
        return best, total


@kernel
def local_planar(G, k, b_N, b_T, mu):
    """P = (P_N, P_T) of the planar contact with block G[k] and free velocity b: open, else stick, else slide.

    The modes are those of ``single``, with one mu and no rule of selection. Where none is admissible the sliding one
    that is nearest to it is returned: sweeps go on, and the error tells.
    """
    if b_N >= 0.0:
        return 0.0, 0.0
    g_NN, g_NT, g_TN, g_TT = G[k, 0, 0], G[k, 0, 1], G[k, 1, 0], G[k, 1, 1]
    P_N, P_T, sticks = stick(g_NN, g_NT, g_TN, g_TT, b_N, b_T)
    if sticks and abs(P_T) <= mu * P_N:
        return P_N, P_T
    best = -np.inf
    P_N = 0.0
    P_T = 0.0
    for half in range(2):
        sign = 1.0 - 2.0 * half  # of the sliding velocity
        resistance = g_NN - sign * mu * g_NT
        if resistance > 0.0:
            normal = -b_N / resistance
            slip = sign * (b_T + (g_TN - sign * mu * g_TT) * normal)
            if slip > best:
                best = slip
                P_N = normal
                P_T = -sign * mu * normal
    return P_N, P_T


@kernel
def relax(G, k, i, b, mu, P):
    """Solve contact i with diagonal block G[k] and free velocity b, write P_i; the square of its change."""
    dim = G.shape[1]
    at = i * dim
    if dim == 2:
        P_N, P_1 = local_planar(G, k, b[0], b[1], mu)
        P_2 = 0.0
        old_2 = 0.0
    else:
        P_N, P_1, P_2 = local_spatial(G, k, b[0], b[1], b[2], mu)
        old_2 = P[at + 2]
    d_N = P_N - P[at]
    d_1 = P_1 - P[at + 1]
    d_2 = P_2 - old_2
    P[at] = P_N
    P[at + 1] = P_1
    if dim == 3:
        P[at + 2] = P_2
    return d_N * d_N + d_1 * d_1 + d_2 * d_2


@kernel
def sweep(rows, c, mu, stretch, P):
    """Solve every contact once; returns sum (stretch |change|)^2, which the natural map follows."""
    G, indices, indptr = rows
    dim = G.shape[1]
    total = 0.0
    for i in range(mu.shape[0]):
        b_N = c[i * dim]
        b_1 = c[i * dim + 1]
        b_2 = c[i * dim + 2] if dim == 3 else 0.0
        own = 0
        for k in range(indptr[i], indptr[i + 1]):
            if indices[k] == i:
                own = k
                continue
            j = indices[k] * dim
            b_N += G[k, 0, 0] * P[j] + G[k, 0, 1] * P[j + 1]
            b_1 += G[k, 1, 0] * P[j] + G[k, 1, 1] * P[j + 1]
            if dim == 3:
                b_N += G[k, 0, 2] * P[j + 2]
                b_1 += G[k, 1, 2] * P[j + 2]
                b_2 += G[k, 2, 0] * P[j] + G[k, 2, 1] * P[j + 1] + G[k, 2, 2] * P[j + 2]
        change = relax(G, own, i, (b_N, b_1, b_2), mu[i], P)
        total += stretch[i] * stretch[i] * change
    return total


@kernel(
    "Tuple((int64, float64))(Tuple((float64[:, :, ::1], int32[::1], int32[::1])), float64[::1], float64[::1],"
    " float64[::1], float64[::1], float64, int64)",
    takes_arrays=True,
)
def nsgs(rows, c, mu, stretch, P, tol, most):
    """Sweep until the change is below tol, ``most`` times at most; returns the sweeps and the square of the change.

    rows = (G, indices, indptr); stretch = weight rho makes a change of impulses one of the natural map.
    """
    for count in range(1, most + 1):
        change = sweep(rows, c, mu, stretch, P)
        if change <= tol * tol or count == most:
            return count, change
    return 0, 0.0
