"""Several planar contacts at once: the ladder of methods of one step.

1. the impulses of the step before, where every contact rested: kept if they still balance;
2. where the solution is certified to be unique: the modes of the step before, if they still hold, else the faceted
   linear complementarity problem by Lemke's method;
3. every solution by enumeration of modes, and the selection rule, where it is not; Lemke's method where contacts are
   redundant and the enumeration is not complete, and at last the enumeration that decides redundant contacts, which is
   compiled when a step first needs it;
4. where there are too many to enumerate, a semismooth Newton method from the impulses of the step before, which is
   compiled for scenes of so many contacts only; then Lemke's method;
5. Gauss–Seidel over the contacts, each solved in closed form.

Lemke's problem, after Glocker, per contact with P_R = mu P_N + P_F and gamma_L the part of gamma_F to the left:

    [gamma_N]   [G_NN - G_NF mu   G_NF   0] [P_N    ]   [c_N]
    [gamma_R] = [G_FN - G_FF mu   G_FF   1] [P_R    ] + [c_F]
    [P_L    ]   [     2 mu         -1    0] [gamma_L]   [ 0 ]

Source: Glocker, Studer, *Multibody Syst. Dyn.* 13 (2005) 447.
What is accepted satisfies the inclusions of ``planar_problem.residual``.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from nonsmooth.blocks import address, view
from nonsmooth.contact_solvers.kept import keep_impulses, keep_modes
from nonsmooth.contact_solvers.modes import MAX_LEAVES, enumerate_modes, leaves, select
from nonsmooth.contact_solvers.planar_newton import solve_by_newton
from nonsmooth.contact_solvers.planar_problem import (
    ACCEPTED,
    Planar,
    has_varying_friction,
    name_modes,
    residual,
    update_friction,
)
from nonsmooth.contact_solvers.redundant import enumerate_redundant
from nonsmooth.contact_solvers.single import STICK, solve_given_force, solve_single
from nonsmooth.jit import interpreted, kernel
from nonsmooth.laws import static_coefficient
from nonsmooth.lcp.lemke import lemke
from nonsmooth.system import BILATERAL, GIVEN_FORCE, UNILATERAL, System

SWEEPS = 20_000  # Gauss–Seidel
SPEED_SWEEPS = 50  # fixed point on mu(v) where several contacts slide
LEMKE_PIVOTS = 50  # times the number of unknowns


class Route(IntEnum):
    """How a contact problem was solved."""

    FAILED = 0  # no solution found, though one may exist
    NO_SOLUTION = 1  # enumerated completely: there is none
    KEPT = 2
    KEPT_MODES = 3
    LEMKE = 4
    ENUMERATED = 5
    GAUSS_SEIDEL = 6
    NEWTON = 7


@kernel(
    "Tuple((int64, int64, int64, float64))(int64, int64[::1], int64[::1], int64[:, ::1], float64[:, ::1], "
    "float64[:, ::1], float64[::1], float64[::1], float64[:, ::1], int64[::1], int64[::1], int64, float64[::1], int64)",
    short_loops=True,
)
def solve_planar(n, closed, start, kinds, laws, G, c, offset, previous_P, mode, slip, selection, P, planar_at):
    """Solve the contact problem of n > 1 closed contacts; write P and the candidates.
    Returns (route, solutions, pivots, residual).

    ``planar.normal_impulse`` holds the given normal impulses; ``mode`` and ``slip`` are those of the step before.
    """
    planar = view(planar_at, Planar)
    for k in range(n):
        i = closed[k]
        planar.was_stuck[k] = 1 if mode[i] == STICK else 0
        planar.mu_static[k] = static_coefficient(laws, i)
    if keep_impulses(n, closed, start, kinds, G, c, previous_P, mode, P, planar):
        return Route.KEPT.value, 1, 0, 0.0
    planar.pivots[0] = 0
    route = Route.FAILED.value
    found = 0
    varies = has_varying_friction(n, closed, start, kinds, laws, offset, planar)
    for _ in range(SPEED_SWEEPS):
        route, found = solve_with_fixed_friction(
            n, closed, start, kinds, laws, G, c, offset, previous_P, mode, slip, selection, P, planar
        )
        if not varies or route <= Route.NO_SOLUTION or route == Route.GAUSS_SEIDEL:
            break
        if not update_friction(n, closed, start, kinds, laws, offset, planar):
            break
    return route, found, planar.pivots[0], residual(n, closed, start, kinds, G, c, P, planar)


@kernel
def solve_with_fixed_friction(
    n, closed, start, kinds, laws, G, c, offset, previous_P, mode, slip, selection, P, planar
):
    """The ladder for given friction coefficients; the velocities reached are left in ``planar.gamma``."""
    n_leaves = leaves(n, closed, kinds, MAX_LEAVES)
    is_singular = False
    if is_certified(n, closed, start, kinds, G, planar):
        if keep_modes(n, closed, start, kinds, G, c, mode, slip, P, planar):
            return Route.KEPT_MODES.value, 1
        if solve_by_lemke(n, closed, start, kinds, G, c, P, planar):
            return Route.LEMKE.value, 1
    if n_leaves <= MAX_LEAVES:
        found, is_complete = enumerate_modes(
            n, closed, start, kinds, planar.mu, planar.mu_static, planar.normal_impulse, G, c, address(planar.tree)
        )
        if found > 0 and take_solution(found, n, closed, start, kinds, G, c, selection, P, planar):
            return Route.ENUMERATED.value, found
        if found == 0 and is_complete:
            return Route.NO_SOLUTION.value, 0
        is_singular = not is_complete
    if n_leaves > MAX_LEAVES and planar.has_newton[0] == 1:
        if solve_by_newton(n, closed, start, kinds, G, c, previous_P, P, address(planar)):
            return Route.NEWTON.value, 1
    if can_be_faceted(n, closed, kinds) and solve_by_lemke(n, closed, start, kinds, G, c, P, planar):
        return Route.LEMKE.value, 1
    if is_singular and planar.can_decide_redundant[0] == 1:
        found = enumerate_redundant(n, closed, start, kinds, G, c, P, address(planar))
        if found == 0:
            return Route.NO_SOLUTION.value, 0
        if take_solution(found, n, closed, start, kinds, G, c, selection, P, planar):
            return Route.ENUMERATED.value, found
    if gauss_seidel(n, closed, start, kinds, laws, G, c, offset, slip, selection, P, planar):
        return Route.GAUSS_SEIDEL.value, 1
    if is_singular or n_leaves > MAX_LEAVES:
        return Route.FAILED.value, 0
    return Route.NO_SOLUTION.value, 0


def exceeds_enumeration(system: System) -> bool:
    """Whether more contacts of the system may be closed at once than are enumerated."""
    return bool(interpreted(leaves)(system.n_c, np.arange(system.n_c), system.kinds, MAX_LEAVES) > MAX_LEAVES)


@kernel
def take_solution(found, n, closed, start, kinds, G, c, selection, P, planar):
    """Take one of the solutions in the tree by the selection rule; True if it satisfies the inclusions."""
    take = select(found, n, closed, start, kinds, planar.mu, G, planar.was_stuck, selection, planar.tree)
    for k in range(start[n]):
        P[k] = planar.tree.solutions[take, k]
    for k in range(n):
        planar.candidate[k] = planar.tree.modes[take, k]
    return residual(n, closed, start, kinds, G, c, P, planar) <= ACCEPTED


@kernel
def is_certified(n, closed, start, kinds, G, planar):
    """A sufficient test that the solution is unique: no friction and no bilateral contact, or a dominant diagonal.

    With P = G_NN - G_NF diag(mu s), row dominance for every choice of the slip signs s makes each P a P-matrix:
    G_ii > sum_j mu_j |G_NF,ij| + sum_{j != i} |G_NN,ij|.
    """
    is_frictionless = True
    for k in range(n):
        kind, d = kinds[closed[k], 0], kinds[closed[k], 1]
        if kind == BILATERAL:
            return False
        if d > 0:
            is_frictionless = False
            if planar.mu_static[k] != planar.mu[k]:
                return False
    if is_frictionless:
        return True
    for k in range(n):
        if kinds[closed[k], 0] == GIVEN_FORCE:
            continue
        a = start[k]
        margin = 2.0 * G[a, a]
        for m in range(n):
            if kinds[closed[m], 0] != GIVEN_FORCE:
                margin -= abs(G[a, start[m]])
                if kinds[closed[m], 1] > 0:
                    margin -= planar.mu_static[m] * abs(G[a, start[m] + 1])
        if not margin > 0.0:
            return False
    return True


@kernel
def can_be_faceted(n, closed, kinds):
    """Whether the problem is a linear complementarity problem: a bilateral contact is none."""
    for k in range(n):
        if kinds[closed[k], 0] == BILATERAL:
            return False
    return True


@kernel
def solve_by_lemke(n, closed, start, kinds, G, c, P, planar):
    """Lemke's method on Glocker's problem; True if the answer satisfies the inclusions."""
    size = assemble_lcp(n, closed, start, kinds, G, c, planar)
    pivots = pivot(size, planar.A, planar.b, planar.z, planar.tableau, planar.scales, planar.basis, LEMKE_PIVOTS * size)
    planar.pivots[0] += pivots
    row = 0
    for k in range(n):
        i = closed[k]
        d = kinds[i, 1]
        t = start[k + 1] - 1
        if kinds[i, 0] == GIVEN_FORCE:
            P[t] = planar.z[row] - planar.mu[k] * planar.normal_impulse[k]
            row += 2
        else:
            P[start[k]] = planar.z[row]
            if d > 0:
                P[t] = planar.z[row + 1] - planar.mu[k] * planar.z[row]
            row += 1 + 2 * d
    return residual(n, closed, start, kinds, G, c, P, planar) <= ACCEPTED and name_modes(
        n, closed, start, kinds, P, planar
    )


@kernel(
    "int64(int64, float64[:, ::1], float64[::1], float64[::1], float64[:, ::1], float64[:, ::1], int64[::1], int64)"
)
def pivot(size, A, b, z, tableau, scales, basis, max_pivots):
    """Lemke's method as a part compiled for itself; returns the number of pivots."""
    _, pivots = lemke(size, A, b, z, tableau, scales, basis, max_pivots)
    return pivots


@kernel
def assemble_lcp(n, closed, start, kinds, G, c, planar):
    """Fill A and b of Glocker's problem, contact by contact; returns its size."""
    row = 0
    for k in range(n):
        is_given = kinds[closed[k], 0] == GIVEN_FORCE
        d = kinds[closed[k], 1]
        size = (0 if is_given else 1) + 2 * d
        column = 0
        for a in range(size):
            planar.b[row + a] = 0.0
        for a in range(start[k + 1] - start[k]):
            planar.b[row + a] = c[start[k] + a]
        for m in range(n):
            width = _fill_columns(k, m, row, column, size, closed, start, kinds, G, planar)
            column += width
        if d > 0 and is_given:
            planar.b[row + 1] = 2.0 * planar.mu[k] * planar.normal_impulse[k]
        row += size
    return row


@kernel
def _fill_columns(k, m, row, column, size, closed, start, kinds, G, planar):
    """Block (k, m) of Glocker's matrix; returns its number of columns."""
    A, b, mu = planar.A, planar.b, planar.mu
    is_given = kinds[closed[m], 0] == GIVEN_FORCE
    d = kinds[closed[m], 1]
    width = (0 if is_given else 1) + 2 * d
    rows = start[k + 1] - start[k]
    for a in range(size):
        for e in range(width):
            A[row + a, column + e] = 0.0
    for a in range(rows):
        g = start[k] + a
        if is_given:
            A[row + a, column] = G[g, start[m]]
            b[row + a] -= G[g, start[m]] * mu[m] * planar.normal_impulse[m]
        else:
            A[row + a, column] = G[g, start[m]]
            if d > 0:
                A[row + a, column] -= mu[m] * G[g, start[m] + 1]
                A[row + a, column + 1] = G[g, start[m] + 1]
    if k == m and d > 0:
        A[row + rows - 1, column + width - 1] = 1.0
        A[row + size - 1, column + width - 2] = -1.0
        if not is_given:
            A[row + size - 1, column] = 2.0 * mu[k]
    return width


@kernel
def gauss_seidel(n, closed, start, kinds, laws, G, c, offset, slip, selection, P, planar):
    """Each contact solved in closed form with the others held, in turn, until the residual is accepted."""
    for k in range(start[n]):
        P[k] = 0.0
    for sweep in range(SWEEPS):
        for k in range(n):
            i = closed[k]
            a = start[k]
            t = start[k + 1] - 1
            local = _local_velocity(a, start[k], t, start[n], G, c, P)
            if kinds[i, 0] == GIVEN_FORCE:
                _, P[t] = solve_given_force(
                    laws, i, G[t, t], local, offset[t], planar.normal_impulse[k], planar.was_stuck[k] == 1, slip[i]
                )
            elif kinds[i, 1] == 0:
                P[a] = -local / G[a, a]
                if kinds[i, 0] == UNILATERAL:
                    P[a] = max(0.0, P[a])
            else:
                c_F = _local_velocity(t, start[k], t, start[n], G, c, P)
                _, P[a], P[t], _ = solve_single(
                    kinds[i, 0], laws, i, G[a, a], G[a, t], G[t, a], G[t, t], local, c_F, offset[t],
                    planar.was_stuck[k] == 1, slip[i], selection,
                )  # fmt: skip
        if sweep % 10 == 9:
            _update_all_friction(n, closed, start, kinds, laws, G, c, offset, P, planar)
            if residual(n, closed, start, kinds, G, c, P, planar) <= ACCEPTED:
                return name_modes(n, closed, start, kinds, P, planar)
    return False


@kernel
def _local_velocity(row, first, last, r, G, c, P):
    """Velocity of a row from all impulses except those of its own contact."""
    total = c[row]
    for m in range(r):
        if m < first or m > last:
            total += G[row, m] * P[m]
    return total


@kernel
def _update_all_friction(n, closed, start, kinds, laws, G, c, offset, P, planar):
    residual(n, closed, start, kinds, G, c, P, planar)
    update_friction(n, closed, start, kinds, laws, offset, planar)
