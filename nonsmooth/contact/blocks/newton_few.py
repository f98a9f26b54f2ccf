"""Few contacts at once: the semismooth Newton method of ``newton``, every step of it in one compiled call.

    (A + B G) R^-1 x = -F,    P <- P + s R^-1 x,    R = diag(rho_i),    s = 1, 1/2, 1/4, ...

The unknowns x are velocities, so that no column of the matrix knows the masses. It begins where a few sweeps ended,
stops at rounding, and gives up where the matrix is singular or the error does not halve within some steps: the ladder
then begins from its own start. Measured: a step takes 2 us with 4 contacts in space and 35 us with 25, where one that
calls LAPACK takes 30 us more.
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.contact.blocks.few_contacts import error_of, measure_sizes
from nonsmooth.contact.blocks.linear import jacobian_entry
from nonsmooth.contact.blocks.natural_map import put_on_cones, velocity
from nonsmooth.contact.blocks.newton import alart_curnier
from nonsmooth.jit import kernel
from nonsmooth.numerics.dense import lu, lu_solve

FEW_UNKNOWNS = 96  # measured: above, factors by LAPACK are faster
SWEEPS_BEFORE = 16  # measured: before them, or as many as there are unknowns; more cost more than Newton's method
STEPS_AT_MOST = 30  # chosen: who needs more does not converge quadratically
# measured: of walls and arches with redundant contacts none comes to rounding with 1e-11, all do with 1e-9 to 1e-5
SHIFT = 1e-7
HALVED_WITHIN = 8  # measured: steps within which the error must halve, as NEWTON_TRIAL_STEPS of the ladder
MEMORY = 4  # defined: |F| must fall below the largest of so many before, as in ``newton``
HALVED_STEPS = 6  # chosen: of a step; shorter ones go nowhere


Memory = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def newton_memory(n_c: int, dim: int) -> Memory:
    """Scratch of `step_few`: A and B (2, n_c, dim, dim), vectors (4, n), the matrix (n, n), its order of rows (n,)."""
    n = n_c * dim
    return np.empty((2, n_c, dim, dim)), np.empty((4, n)), np.empty((n, n)), np.empty(n, dtype=np.int64)


@kernel
def fill_scaled(rows, rho, A, B, matrix):
    """matrix = (A + B G) R^-1, and a shift, lest redundant contacts make it singular."""
    G, indices, indptr = rows
    dim = G.shape[1]
    for i in range(indptr.shape[0] - 1):
        for a in range(dim):
            for j in range(matrix.shape[1]):
                matrix[i * dim + a, j] = 0.0
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            for a in range(dim):
                for b in range(dim):
                    matrix[i * dim + a, j * dim + b] = jacobian_entry(G, k, j == i, A, B, i, a, b) / rho[j]
    for k in range(matrix.shape[0]):
        matrix[k, k] += SHIFT


@kernel
def norm_of(x):
    """|x|."""
    total = 0.0
    for k in range(x.shape[0]):
        total += x[k] * x[k]
    return math.sqrt(total)


@kernel
def linearise(rows, c, mu, rho, P, at):
    """Write gamma, F and the blocks A, B at P; returns |F|. at = (A, B, F, gamma)."""
    A, B, F, gamma = at
    velocity(rows[0], rows[1], rows[2], c, P, gamma)
    alart_curnier(rows[0], mu, rho, P, gamma, A, B, F)
    return norm_of(F)


@kernel
def search(problem, P, x, trial, at, bound):
    """The first P + s R^-1 x below the bound, or the shortest tried, in ``trial``; returns |F| there."""
    rows, c, mu, rho = problem
    dim, length, merit = rows[0].shape[1], 1.0, math.inf
    for _ in range(HALVED_STEPS):
        for k in range(P.shape[0]):
            trial[k] = P[k] + length * x[k] / rho[k // dim]
        merit = linearise(rows, c, mu, rho, trial, at)
        if merit <= (1.0 - 1e-4 * length) * bound:
            break
        length *= 0.5
    return merit


@kernel
def step_some(rows, c, mu, P, gamma, rho, memory, tol):
    """Newton steps from P: (steps, error, error with rho = 1); the error is inf where it is given up.

    Writes P, gamma (n,) and rho (n_c,).
    """
    blocks, vectors, matrix, order = memory
    dim, n = rows[0].shape[1], c.shape[0]
    F, x, trial, past = vectors[0], vectors[1], vectors[2], vectors[3]
    at = (blocks[0], blocks[1], F, gamma)
    norm = measure_sizes(rows, c, rho)
    if norm < 0.0:
        return 0, math.inf, math.inf
    merit = linearise(rows, c, mu, rho, P, at)
    for k in range(MEMORY):
        past[k] = merit
    mark, since = error_of(mu, rho, P, gamma, dim)[0], 0
    for count in range(1, STEPS_AT_MOST + 1):
        fill_scaled(rows, rho, blocks[0], blocks[1], matrix)
        if not lu(n, matrix, order):
            break
        for k in range(n):
            F[k] = -F[k]
        lu_solve(n, matrix, order, F, x)
        bound = max(past[0], past[1], past[2], past[3])
        past[count % MEMORY] = search((rows, c, mu, rho), P, x, trial, at, bound)
        for k in range(n):
            P[k] = trial[k]
        error = error_of(mu, rho, P, gamma, dim)[0]
        if error <= tol * norm:
            put_on_cones(mu, P, dim)
            velocity(rows[0], rows[1], rows[2], c, P, gamma)
            F_rho, F_1 = error_of(mu, rho, P, gamma, dim)
            if F_rho <= tol * norm:
                return count, F_rho / norm, F_1 / norm
        since += 1
        if error <= 0.5 * mark:
            mark, since = error, 0
        if since == HALVED_WITHIN or not error < math.inf:
            break
    return count, math.inf, math.inf


@kernel(
    "Tuple((int64, float64, float64))(Tuple((float64[:, :, ::1], int32[::1], int32[::1])), float64[::1], float64[::1],"
    " float64[::1], float64[::1], float64[::1], Tuple((float64[:, :, :, ::1], float64[:, ::1], float64[:, ::1],"
    " int64[::1])), float64)",
    takes_arrays=True,
)
def step_few(rows, c, mu, P, gamma, rho, memory, tol):
    """`step_some` for calls from Python."""
    return step_some(rows, c, mu, P, gamma, rho, memory, tol)
