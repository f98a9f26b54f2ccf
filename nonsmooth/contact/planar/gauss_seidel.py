"""Gauss–Seidel over planar contacts: each is solved in closed form with the others held, in turn.

    c_k <- c_k + sum of G_km P_m over the others,    P_k = the answer of contact k alone (single.py)

The law of friction of each is taken at the speed that it has come to.

Source: Jean, *Comput. Methods Appl. Mech. Engrg.* 177 (1999) 235.
"""

from __future__ import annotations

from nonsmooth.contact.planar.problem import ACCEPTED_RESIDUAL, residual, update_friction
from nonsmooth.contact.planar.single import solve_alone
from nonsmooth.jit import kernel, rare_kernel

GAUSS_SEIDEL_SWEEPS = 20_000  # chosen: of all contacts


@rare_kernel
def gauss_seidel(problem, planar):
    """Each contact solved in closed form with the others held, in turn, until the residual is accepted."""
    for row in range(problem.r):
        problem.P[row] = 0.0
    for sweep in range(GAUSS_SEIDEL_SWEEPS):
        for k in range(problem.n):
            relax(k, problem)
        if sweep % 10 == 9:
            residual(problem, planar)
            update_friction(problem, planar)
            if residual(problem, planar) <= ACCEPTED_RESIDUAL:
                return True
    return False


@kernel
def relax(k, problem):
    """Solve contact k with the others held: for as long their impulses count to its c."""
    c, a, t = problem.c, problem.start[k], problem.start[k + 1] - 1
    c_a, c_t = c[a], c[t]
    local_a, local_t = local_velocity(a, k, problem), local_velocity(t, k, problem)
    c[a], c[t] = local_a, local_t
    solve_alone(k, problem)
    c[a], c[t] = c_a, c_t


@kernel
def local_velocity(row, k, problem):
    """Velocity of a row of contact k from all impulses except its own."""
    total = problem.c[row]
    for m in range(problem.r):
        if m < problem.start[k] or m >= problem.start[k + 1]:
            total += problem.G[row, m] * problem.P[m]
    return total
