"""Several planar contacts at once: the ladder of methods of one step.

Islands of contacts that are not coupled are solved apart (islands.py), one contact in closed form (single.py). Several:

1. the impulses of the step before, where every contact rested: kept if they still balance (kept.py);
2. where there is one motion, by a certificate (certificate.py) or by the last census (census.py): the modes of the step
   before, if they still hold, else Newton's or Lemke's method;
3. else every solution by enumeration of modes (planar/enumerate.py), of the contacts that reduction.py leaves, and the
   selection rule; where a census is not possible, or has to wait, as in 2;
4. Lemke's method where contacts are redundant and the enumeration found nothing, and at last the enumeration that
   decides redundant contacts, which is compiled when a step first needs it;
5. Gauss–Seidel over the contacts, each solved in closed form.

The semismooth Newton method is compiled for scenes of many contacts only. Whatever found the motion, redundant contacts
share its impulses by ``hold_modes``.

Lemke's problem, after Glocker, per contact with P_R = mu P_N + P_F and gamma_L the part of gamma_F to the left:

    [gamma_N]   [G_NN - G_NF mu   G_NF   0] [P_N    ]   [c_N]
    [gamma_R] = [G_FN - G_FF mu   G_FF   1] [P_R    ] + [c_F]
    [P_L    ]   [     2 mu         -1    0] [gamma_L]   [ 0 ]

Source: Glocker, Studer, *Multibody Syst. Dyn.* 13 (2005) 447.
What is accepted satisfies the inclusions of ``problem.residual``.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from nonsmooth.contact.islands import find_islands
from nonsmooth.contact.planar.census import (
    ALWAYS_ONE,
    EVERY_STEP,
    NOT_TOLD,
    ONE_AS_BEFORE,
    UNKNOWN,
    known_solutions,
    may_count,
    note_modes,
    pay_off,
    remember,
)
from nonsmooth.contact.planar.certificate import has_one_motion
from nonsmooth.contact.planar.enumerate import MAX_LEAVES, enumerate_modes, leaves, select
from nonsmooth.contact.planar.kept import factor, hold_modes, keep_impulses, recall_modes
from nonsmooth.contact.planar.newton import solve_by_newton
from nonsmooth.contact.planar.problem import (
    ACCEPTED,
    Planar,
    has_varying_friction,
    name_modes,
    residual,
    update_friction,
)
from nonsmooth.contact.planar.reduction import count_modes, reduce
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.contact.planar.single import (
    NO_CANDIDATE,
    SLIDE_PLUS,
    STICK,
    STILL,
    count,
    slip_of,
    solve_alone,
    solve_given_force,
    solve_single,
)
from nonsmooth.jit import interpreted, kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.lcp.lemke import lemke
from nonsmooth.mechanics.laws import static_coefficient
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode, System

SWEEPS = 20_000  # Gauss–Seidel
SAME = 1e-8  # of max |c|: velocities of one motion, both with a residual of ACCEPTED
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
    ALONE = 8  # one contact in closed form


@kernel(
    "Tuple((int64, int64, int64, float64))(int64, int64[::1], int64[::1], int64[:, ::1], float64[:, ::1], "
    "float64[:, ::1], float64[::1], float64[::1], float64[:, ::1], int64[::1], int64[::1], int64, float64[::1], int64)",
    short_loops=True,
)
def solve_planar(n, closed, start, kinds, laws, G, c, offset, previous_P, mode, slip, selection, P, planar_at):
    """Solve the contact problem of n > 1 closed contacts; write P and the candidates.
    Returns (route, solutions, pivots, residual).

    ``planar.normal_impulse`` holds the given normal impulses; ``mode`` and ``slip`` are those of the step before.
    ``planar.found``, ``members`` and ``bits`` tell of the island of each contact, ``is_counted`` and ``is_shared`` of
    all of them.
    """
    planar = view(planar_at, Planar)
    part = planar.part
    planar.pivots = 0
    pay_off(planar)
    n_islands = find_islands(n, start, G, planar.island)
    is_counted, is_shared, found, worst, route = True, False, 1, 0.0, Route.KEPT.value
    for k in range(n if n_islands > 1 else 0):
        planar.given[k] = planar.normal_impulse[k]
    for e in range(n_islands):
        m, closed_e, start_e, G_e, c_e, offset_e, P_e = n, closed, start, G, c, offset, P
        if n_islands > 1:
            m = take_island(e, n, closed, start, G, c, offset, planar)
            closed_e, start_e, G_e, c_e = part.closed, part.start, part.G, part.c
            offset_e, P_e = part.offset, part.P
        if m > 1:
            path, solutions, off = solve_island(
                m, closed_e, start_e, kinds, laws, G_e, c_e, offset_e, previous_P, mode, slip, selection, P_e, planar
            )
            bits = 0
        else:
            i = closed_e[0]
            candidate, bits, error = solve_alone(
                kinds[i, 0], kinds[i, 1], laws, i, G_e, c_e, offset_e, planar.normal_impulse[0],
                mode[i] == ContactMode.STICK, slip[i], selection, P_e,
            )  # fmt: skip
            planar.candidate[0], planar.is_counted, planar.is_shared = candidate, 1, 0
            path, solutions, off = (
                route_alone(candidate, mode[i], slip[i]),
                count(bits),
                relative(error, c_e, start_e[1]),
            )
        if path <= Route.NO_SOLUTION:
            return path, 0, planar.pivots, off
        give_back(e, m, n_islands, solutions, bits, n, start, P, planar)
        is_counted, is_shared = is_counted and planar.is_counted == 1, is_shared or planar.is_shared == 1
        found *= solutions
        worst = max(worst, off)
        if path != Route.KEPT and (route == Route.KEPT or route == Route.KEPT_MODES):
            route = path
    for k in range(n if n_islands > 1 else 0):
        planar.candidate[k] = planar.taken[k]
    planar.is_counted, planar.is_shared = 1 if is_counted else 0, 1 if is_shared else 0
    return route, found, planar.pivots, worst


@kernel
def take_island(e, n, closed, start, G, c, offset, planar):
    """Copy the problem of island e to ``planar.part``; returns the number of its contacts."""
    part = planar.part
    m = 0
    for k in range(n):
        if planar.island[k] == e:
            part.place[m] = k
            planar.normal_impulse[m] = planar.given[k]
            m += 1
    r = copy_part(m, closed, start, G, c, part)
    for a in range(r):
        part.offset[a] = offset[part.row[a]]
    return m


@kernel
def copy_part(m, closed, start, G, c, part):
    """Copy the problem of the m contacts in part.place; returns the number of rows."""
    r = 0
    for e in range(m):
        k = part.place[e]
        part.closed[e], part.start[e] = closed[k], r
        for row in range(start[k], start[k + 1]):
            part.row[r] = row
            r += 1
    part.start[m] = r
    for a in range(r):
        part.c[a] = c[part.row[a]]
        for b in range(r):
            part.G[a, b] = G[part.row[a], part.row[b]]
    return r


@kernel
def give_back(e, m, n_islands, solutions, bits, n, start, P, planar):
    """Write what was found for island e where its contacts stand among all."""
    part = planar.part
    for f in range(m):
        k = f if n_islands == 1 else part.place[f]
        planar.taken[k], planar.found[k], planar.members[k], planar.bits[k] = planar.candidate[f], solutions, m, bits
    if n_islands > 1:
        for a in range(part.start[m]):
            P[part.row[a]] = part.P[a]


@kernel
def route_alone(candidate, mode, slip):
    """The route of a contact in closed form."""
    if candidate == NO_CANDIDATE:
        return Route.NO_SOLUTION.value
    return Route.KEPT_MODES.value if is_as_before(candidate, mode, slip) else Route.ALONE.value


@kernel
def relative(error, c, r):
    """A velocity over max |c|."""
    scale = 0.0
    for a in range(r):
        scale = max(scale, abs(c[a]))
    return error / scale if scale > 0.0 else error


@kernel
def is_as_before(candidate, mode, slip):
    """Whether a candidate is the mode of the step before."""
    if candidate >= SLIDE_PLUS:
        return mode == ContactMode.SLIDE and slip == slip_of(candidate)
    return (candidate == STICK) == (
        mode == ContactMode.STICK or mode == ContactMode.LOCKED
    ) and mode != ContactMode.SLIDE


@kernel
def solve_island(n, closed, start, kinds, laws, G, c, offset, previous_P, mode, slip, selection, P, planar):
    """Several contacts that are coupled: (route, solutions, residual)."""
    memory = planar.memory
    for k in range(n):
        i = closed[k]
        planar.was_stuck[k] = 1 if mode[i] == STICK else 0
        planar.mu_static[k] = static_coefficient(laws, i)
    if keep_impulses(n, closed, start, kinds, G, c, previous_P, mode, P, planar):
        found = memory.told[closed[0]]
        planar.is_counted, planar.is_shared = 1 if found > 0 else 0, memory.is_shared[closed[0]]
        return Route.KEPT.value, max(1, found), 0.0
    route, found = Route.FAILED.value, 0
    varies = has_varying_friction(n, closed, start, kinds, laws, offset, planar)
    for _ in range(SPEED_SWEEPS):
        route, found = solve_with_fixed_friction(
            n, closed, start, kinds, laws, G, c, offset, previous_P, mode, slip, selection, P, planar
        )
        if not varies or route <= Route.NO_SOLUTION or route == Route.GAUSS_SEIDEL:
            break
        if not update_friction(n, closed, start, kinds, laws, offset, planar):
            break
    for k in range(n):
        memory.told[closed[k]] = found if planar.is_counted == 1 else 0
        memory.is_shared[closed[k]] = planar.is_shared
    return route, found, planar.error


@kernel
def solve_with_fixed_friction(
    n, closed, start, kinds, laws, G, c, offset, previous_P, mode, slip, selection, P, planar
):
    """The ladder for given friction coefficients; the velocities reached are left in ``planar.gamma``."""
    recall_modes(n, closed, kinds, mode, slip, previous_P, planar)
    if has_one_motion(n, closed, start, kinds, G, planar):
        planar.is_counted = 1
        route = go_on(n, closed, start, kinds, G, c, previous_P, P, planar)
        if route != Route.FAILED:
            return route, 1
        recall_modes(n, closed, kinds, mode, slip, previous_P, planar)
    left = reduce(n, closed, start, kinds, G, c, planar)
    n_modes = count_modes(left, closed, kinds, MAX_LEAVES, planar)
    if n_modes > EVERY_STEP:
        known = known_solutions(n, left, closed, start, G, c, planar) if n_modes <= MAX_LEAVES else UNKNOWN
        route = Route.FAILED.value
        if known == ALWAYS_ONE or n_modes > MAX_LEAVES or not may_count(planar):
            route = go_on(n, closed, start, kinds, G, c, previous_P, P, planar)
        elif known != UNKNOWN and hold_modes(n, closed, start, kinds, G, c, P, planar):
            route = Route.KEPT_MODES.value
        is_counted = known == ALWAYS_ONE or (known == ONE_AS_BEFORE and route == Route.KEPT_MODES)
        planar.is_counted = 1 if is_counted else 0
        if route != Route.FAILED and (
            is_counted
            or known == NOT_TOLD
            or n_modes > MAX_LEAVES
            or not has_saddle(n, closed, start, kinds, G, planar)
        ):
            return route, 1
        recall_modes(n, closed, kinds, mode, slip, previous_P, planar)
    route, found = count_all(left, n, closed, start, kinds, laws, G, c, offset, previous_P, slip, selection, P, planar)
    if n_modes > EVERY_STEP:
        note_modes(n, closed, planar)
    return route, found


@rare_kernel
def go_on(n, closed, start, kinds, G, c, previous_P, P, planar):
    """One solution: by the modes in planar.candidate, else by Newton's or Lemke's method; FAILED if there is none."""
    if hold_modes(n, closed, start, kinds, G, c, P, planar):
        return Route.KEPT_MODES.value
    return solve_anew(n, closed, start, kinds, G, c, previous_P, P, planar)


@rare_kernel
def solve_anew(n, closed, start, kinds, G, c, previous_P, P, planar):
    """One solution by Newton's or Lemke's method; FAILED if these find none."""
    if planar.has_newton == 1 and solve_by_newton(n, closed, start, kinds, G, c, previous_P, P, address(planar)):
        share(n, closed, start, kinds, G, c, P, planar)
        return Route.NEWTON.value
    if can_be_faceted(n, closed, kinds) and solve_by_lemke(n, closed, start, kinds, G, c, P, planar):
        share(n, closed, start, kinds, G, c, P, planar)
        return Route.LEMKE.value
    return Route.FAILED.value


@rare_kernel
def share(n, closed, start, kinds, G, c, P, planar):
    """Name the modes of a motion that was found, and let redundant contacts share its impulses. Where no such share is
    admissible, or it would be another motion, the impulses given are left. Returns whether there is one."""
    scale = 0.0
    for row in range(start[n]):
        planar.trial[row], planar.step[row] = P[row], planar.gamma[row]
        scale = max(scale, abs(c[row]))
    name_modes(ACCEPTED, n, closed, start, kinds, G, c, P, planar)
    is_shared = hold_modes(n, closed, start, kinds, G, c, P, planar)
    for row in range(start[n]):
        is_shared = is_shared and abs(planar.gamma[row] - planar.step[row]) <= SAME * scale
    if is_shared:
        return True
    for row in range(start[n]):
        P[row] = planar.trial[row]
    residual(n, closed, start, kinds, G, c, P, planar)
    name_modes(STILL, n, closed, start, kinds, G, c, P, planar)
    return False


@kernel
def has_saddle(n, closed, start, kinds, G, planar):
    """Whether a contact slides with D < 0, which the selection rule takes only where there is nothing else."""
    for k in range(n):
        if planar.candidate[k] >= SLIDE_PLUS and kinds[closed[k], 0] != GIVEN_FORCE:
            a = start[k]
            if G[a, a] + factor(k, planar) * G[a, a + 1] <= 0.0:
                return True
    return False


@kernel
def count_all(left, n, closed, start, kinds, laws, G, c, offset, previous_P, slip, selection, P, planar):
    """Every solution, of the contacts that are left and, where that does not decide, of all; else any solution."""
    planar.is_counted = 1
    is_singular = False
    for attempt in range(2):
        if attempt == 1:
            left = take_all(n, planar)
        n_modes = count_modes(left, closed, kinds, MAX_LEAVES, planar)
        if n_modes > MAX_LEAVES:
            break
        found, is_complete = take_census(n_modes, left, n, closed, start, kinds, G, c, planar)
        if found == 0 and is_complete:
            return Route.NO_SOLUTION.value, 0
        if found > 0 and take_solution(found, left, n, closed, start, kinds, G, c, selection, is_complete, P, planar):
            return Route.ENUMERATED.value, found
        is_singular = True
        if left == n and not has_groups(n, planar):
            break
    planar.is_counted = 0
    route = go_on(n, closed, start, kinds, G, c, previous_P, P, planar)
    if route != Route.FAILED:
        return route, 1
    left = take_all(n, planar)
    is_enumerable = count_modes(left, closed, kinds, MAX_LEAVES, planar) <= MAX_LEAVES
    if is_singular and is_enumerable and planar.can_decide_redundant == 1:
        copy_friction(left, closed, start, G, c, planar)
        found = enumerate_redundant(n, closed, start, kinds, G, G, c, P, address(planar))
        if found == 0:
            return Route.NO_SOLUTION.value, 0
        if take_solution(found, left, n, closed, start, kinds, G, c, selection, False, P, planar):
            planar.is_counted = 1
            return Route.ENUMERATED.value, found
    if gauss_seidel(n, closed, start, kinds, laws, G, c, offset, slip, selection, P, planar):
        share(n, closed, start, kinds, G, c, P, planar)
        return Route.GAUSS_SEIDEL.value, 1
    if is_singular or not is_enumerable:
        return Route.FAILED.value, 0
    return Route.NO_SOLUTION.value, 0


@kernel
def take_all(n, planar):
    """Let a census look at all contacts, each alone; returns their number."""
    for k in range(n):
        planar.rest.place[k] = k
    for k in range(min(n, planar.tree.group.shape[0])):
        planar.tree.group[k] = 0
    return n


@kernel
def has_groups(n, planar):
    """Whether a census takes some contacts together."""
    for k in range(min(n, planar.tree.group.shape[0])):
        if planar.tree.group[k] != 0:
            return True
    return False


@kernel
def sticks_together(take, left, planar):
    """Whether contacts of one group stick in a solution, so that they share its friction."""
    tree = planar.tree
    for e in range(left):
        if tree.group[e] != 0 and tree.group[e] != e + 1 and tree.modes[take, e] == STICK:
            return True
    return False


@kernel
def take_census(n_modes, left, n, closed, start, kinds, G, c, planar):
    """Enumerate the solutions of the contacts that are left; returns as ``enumerate_modes``."""
    rest = planar.rest
    copy_friction(left, closed, start, G, c, planar)
    found, is_complete = enumerate_modes(
        left, rest.closed, rest.start, kinds, rest.mu, rest.mu_static, rest.normal_impulse, rest.G, rest.c,
        address(planar.tree),
    )  # fmt: skip
    if n_modes > EVERY_STEP:
        remember(found, n, left, closed, start, G, c, planar)
    return found, is_complete


@kernel
def copy_friction(left, closed, start, G, c, planar):
    """Copy the problem of the contacts that are left to planar.rest."""
    rest = planar.rest
    copy_part(left, closed, start, G, c, rest)
    for e in range(left):
        k = rest.place[e]
        rest.mu[e], rest.mu_static[e] = planar.mu[k], planar.mu_static[k]
        rest.normal_impulse[e], rest.was_stuck[e] = planar.normal_impulse[k], planar.was_stuck[k]


@rare_kernel
def take_solution(found, left, n, closed, start, kinds, G, c, selection, is_regular, P, planar):
    """Take one of the solutions in the tree by the selection rule; True if it satisfies the inclusions."""
    rest, tree = planar.rest, planar.tree
    take = select(found, left, rest.closed, rest.start, kinds, rest.mu, rest.G, rest.was_stuck, selection, tree)
    for row in range(start[n]):
        P[row] = 0.0
    for a in range(rest.start[left]):
        P[rest.row[a]] = tree.solutions[take, a]
    is_solved = residual(n, closed, start, kinds, G, c, P, planar) <= ACCEPTED
    planar.is_shared = 0
    if is_regular and left == n and not sticks_together(take, left, planar):
        name_modes(STILL, n, closed, start, kinds, G, c, P, planar)
    elif share(n, closed, start, kinds, G, c, P, planar):
        is_solved = True
    else:
        planar.is_shared = 1
        spread_friction(take, left, start, P, planar)
        is_solved = residual(n, closed, start, kinds, G, c, P, planar) <= ACCEPTED
        name_modes(STILL, n, closed, start, kinds, G, c, P, planar)
    return is_solved


@kernel
def spread_friction(take, left, start, P, planar):
    """Give the friction of each group that sticks to its members in the parts of their limits mu P_N."""
    rest, tree = planar.rest, planar.tree
    for e in range(left):
        if tree.group[e] != e + 1:
            continue
        friction, reach = 0.0, 0.0
        for f in range(e, left):
            if tree.group[f] == e + 1 and tree.modes[take, f] == STICK:
                k = rest.place[f]
                friction += P[start[k] + 1]
                reach += rest.mu_static[f] * P[start[k]]
        for f in range(e, left):
            if tree.group[f] == e + 1 and tree.modes[take, f] == STICK and reach > 0.0:
                k = rest.place[f]
                P[start[k] + 1] = friction * rest.mu_static[f] * P[start[k]] / reach


def exceeds_enumeration(system: System) -> bool:
    """Whether more contacts of the system may be closed at once than are enumerated."""
    return bool(interpreted(leaves)(system.n_c, np.arange(system.n_c), system.kinds, MAX_LEAVES) > MAX_LEAVES)


@kernel
def can_be_faceted(n, closed, kinds):
    """Whether the problem is a linear complementarity problem: a bilateral contact is none."""
    for k in range(n):
        if kinds[closed[k], 0] == BILATERAL:
            return False
    return True


@rare_kernel
def solve_by_lemke(n, closed, start, kinds, G, c, P, planar):
    """Lemke's method on Glocker's problem; True if the answer satisfies the inclusions."""
    size = assemble_lcp(n, closed, start, kinds, G, c, planar)
    pivots = pivot(size, planar.A, planar.b, planar.z, planar.tableau, planar.scales, planar.basis, LEMKE_PIVOTS * size)
    planar.pivots += pivots
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
    return residual(n, closed, start, kinds, G, c, P, planar) <= ACCEPTED


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


@rare_kernel
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
                return True
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
