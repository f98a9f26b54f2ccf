"""The direct rung: an augmented Lagrangian in the impulses, Newton's method in the velocities.

    inner:  g(v) = 0 with P held (``lagrangian``), by semismooth Newton steps v <- v - a A^-1 g with a search for a
    outer:  P <- p(v)

A fixed point of the outer step solves the problem whatever rho is. The larger rho = kappa s_c, the fewer outer steps,
and the nearer a start must be, lest Newton cycle between modes: kappa grows after an inner problem that took two steps
or less, and falls, with the step undone, after one that was not solved.

A has the graph of the bodies (``ordering``, ``block_factor``), so redundant contacts cost nothing and need no shift. A
factor is kept as long as no mode changes and the steps made with it converge, also from one call to the next.

Source: Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353-375; Bertsekas, *Constrained Optimization and
Lagrange Multiplier Methods*, Academic Press 1982, section 2.2 (on the growth of rho).
"""

from __future__ import annotations

import math

from nonsmooth.contact.network.block_factor import back_substitute, factorise
from nonsmooth.contact.network.lagrangian import Direct, assemble, imbalance, size_of_change, size_of_imbalance
from nonsmooth.contact.network.ordering import analyse_island
from nonsmooth.contact.network.problem import (
    Network,
    impulse,
    island_residual,
    island_velocities,
    rounding,
    write,
)
from nonsmooth.jit import in_dimensions, kernel, rare_kernel
from nonsmooth.jit.blocks import view
from nonsmooth.numerics.rounding import EPS

MET, UNMET, NO_ROOM = range(3)  # whether the direct rung met its tolerance

FIRST_KAPPA = 10.0  # measured: 100 and more cycles from a poor start
LARGEST_KAPPA = 1e10  # measured: masses 1 to 1e6 need 1e9
# measured: of kappa after an inner problem of 1 or 2 steps, and of 3 or 4; 10 and 1 take as many factors in stacks and
# a half more in heaps
KAPPA_GROWTH, KAPPA_CREEP = 4.0, 2.0
FEW_STEPS, SOME_STEPS = 2, 4  # chosen: those steps
KAPPA_FALL = 0.2  # chosen: not a power of the growth, so that the same kappa does not come again
# measured: rounding of z relative to the tolerance, up to which kappa grows: 1, 30, 1e3 leave 15, 9, 6 of 54 heaps of
# discs and spheres above 1e-13, this 2
LARGEST_ROUNDING = 1e5
# measured: kappa stays where the residual falls by as much in an outer step: a fifth fewer factors than where it grows
OUTER_REDUCTION = 0.1
INNER_STEPS = 8  # measured: an inner problem that takes more is not found at all
CYCLING = 4  # measured: nor one whose |g| is not below its start after as many
INNER_REDUCTION = 1e-3  # chosen: of |g|, before P moves
CHORD_REDUCTION = 0.1  # chosen: of |g| in a step with a kept factor, else it is made anew
SEARCH_HALVINGS = 5  # chosen
SUFFICIENT = 0.1  # chosen: part of the fall of |g| that a Newton step promises
PATIENCE = 50  # measured: outer steps and factors within which the residual must halve: a heap that is solved takes 40


@kernel
def recall_graph(network, direct):
    """Forget all columns and factors, unless the contacts in use join the same bodies as before."""
    is_same = direct.n_c == network.n_c
    for c in range(network.n_c):
        is_same = is_same and direct.i[c] == network.i[c] and direct.j[c] == network.j[c]
        direct.i[c], direct.j[c] = network.i[c], network.j[c]
    direct.n_c = network.n_c
    direct.desk.graph.end = direct.factor.columns.row.shape[0]
    if not is_same:
        direct.desk.graph.top = 0
        place = direct.factor.columns.place
        for body in range(place.shape[0]):
            place[body] = -1
            direct.kappa[body] = 0.0


@kernel
def is_laid_out(network, direct, desk, k):
    """Whether island k has columns, made now if need be; no where there is no room."""
    islands = network.islands
    begin, end, place = islands.body_start[k], islands.body_start[k + 1], direct.factor.columns.place
    if place[islands.bodies[begin]] >= 0:
        return True
    if analyse_island(network, direct.factor.columns, desk.graph, k):
        return True
    for at in range(begin, end):
        place[islands.bodies[at]] = -1
    return False


@kernel
def newton_step(network, direct, desk, k, size, d, n):
    """One step with the factor at hand: (|g| after it, how many modes are not those of the factor)."""
    islands = network.islands
    begin, end = islands.body_start[k], islands.body_start[k + 1]
    for row in range(begin, end):
        body = direct.factor.columns.body[row]
        for x in range(n):
            direct.step[row, x] = -direct.g[row, x]
            direct.base[body, x] = network.v[body, x]
    back_substitute(direct.factor, desk.square, begin, end, direct.step, n)
    length, after, changed = 1.0, size, 0
    for _ in range(SEARCH_HALVINGS):
        for row in range(begin, end):
            body = direct.factor.columns.body[row]
            for x in range(n):
                network.v[body, x] = direct.base[body, x] + length * direct.step[row, x]
        changed = imbalance(network, direct, k, d, n)
        after = size_of_imbalance(network, direct, k, n)
        if after < size * (1.0 - SUFFICIENT * length):
            break
        length *= 0.5
    return after, changed


@kernel
def refactorise(network, direct, desk, k, d, n):
    """The factor of the modes at hand; False where it has no finite pivots."""
    islands = network.islands
    is_symmetric = assemble(network, direct, desk, k, d, n)
    desk.factors += 1
    return factorise(direct.factor, desk.square, islands.body_start[k], islands.body_start[k + 1], is_symmetric, n)


@kernel
def solve_inner(network, direct, desk, k, is_kept, d, n):
    """Newton's method with P held: the steps that it took, 0 where it did not come to an end."""
    changed = imbalance(network, direct, k, d, n)
    first = size = size_of_imbalance(network, direct, k, n)
    floor = 4.0 * EPS * size_of_change(network, k, n)
    for count in range(INNER_STEPS):
        if not is_kept or changed > 0:
            if not refactorise(network, direct, desk, k, d, n):
                return 0
        before = size
        size, changed = newton_step(network, direct, desk, k, size, d, n)
        if size <= INNER_REDUCTION * first or size <= floor:
            return count + 1
        if not size < math.inf or (count + 1 >= CYCLING and size > first):
            return 0
        is_kept = size <= CHORD_REDUCTION * before
    return 0


@rare_kernel
def largest_kappa(network, k, tol, d, n):
    """The kappa up to which rounding of the velocities is small enough in z = P - rho (J v + b)."""
    R, P = rounding(network, k, math.inf, d, n), math.sqrt(network.islands.P[k])
    return min(LARGEST_KAPPA, LARGEST_ROUNDING * tol * P / R) if R > 0.0 else LARGEST_KAPPA


@kernel
def set_rho(network, direct, k, kappa):
    """rho = kappa / W_NN of each contact of island k."""
    islands = network.islands
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        direct.rho[c] = kappa / network.W[c, 0, 0]


@rare_kernel
def keep_velocities(to, network, k, n):
    """Copy the velocities of island k."""
    islands = network.islands
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        for x in range(n):
            to[body, x] = network.v[body, x]


@kernel
def put_back_velocities(network, kept, k, n):
    """Give island k the velocities that were kept."""
    islands = network.islands
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        for x in range(n):
            network.v[body, x] = kept[body, x]


@rare_kernel
def copy_impulses(islands, k, P, to, d):
    """Copy the impulses of island k."""
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        P_N, P_1, P_2 = impulse(P, c, d)
        write(to, c, P_N, P_1, P_2, d)


@rare_kernel
def judge_island(network, k, d, n):
    """The residual of the impulses of island k, at their own velocities."""
    island_velocities(network, k, d, n)
    return island_residual(network, k, d, n)


@kernel
def next_kappa(network, k, kappa, steps, tol, d, n):
    """kappa after an inner problem that took so many steps, and an outer one that was slow."""
    if steps > SOME_STEPS:
        return kappa
    growth = KAPPA_GROWTH if steps <= FEW_STEPS else KAPPA_CREEP
    return max(FIRST_KAPPA, min(kappa * growth, largest_kappa(network, k, tol, d, n)))


@kernel
def take_outer_step(network, direct, k, d, n):
    """P <- p(v): the residual of it. The velocities stay those of the inner problem."""
    islands = network.islands
    copy_impulses(islands, k, direct.p, direct.P, d)
    copy_impulses(islands, k, direct.p, network.P, d)
    keep_velocities(direct.v, network, k, n)
    error = judge_island(network, k, d, n)
    put_back_velocities(network, direct.v, k, n)
    return error


@kernel
def al_newton(network, direct, desk, k, tol, most, d, n):
    """Solve island k from its impulses to a residual of tol, with ``most`` factors or few more; how it ended.

    The best impulses are left, with their velocities, and the residual in ``islands.residual``.
    """
    islands = network.islands
    if not is_laid_out(network, direct, desk, k):
        return NO_ROOM
    error = least = judge_island(network, k, d, n)
    copy_impulses(islands, k, network.P, direct.best, d)
    copy_impulses(islands, k, network.P, direct.P, d)
    kappa, is_climbing = max(FIRST_KAPPA, direct.kappa[k]), False  # at first it is that of the last solution
    if not least < math.inf:
        return UNMET
    begun, mark, taken, work, marked = desk.factors, least, 0, 0, 0  # work: outer steps and factors
    is_done = least <= tol
    while not is_done and desk.factors < begun + most and work < marked + PATIENCE:
        is_done = least <= tol  # one step more, with the factor at hand, comes close to rounding
        set_rho(network, direct, k, kappa)
        keep_velocities(direct.v, network, k, n)
        steps = solve_inner(network, direct, desk, k, kappa == direct.kappa[k], d, n)
        direct.kappa[k] = kappa
        taken += 1
        work = taken + desk.factors - begun
        if steps == 0:
            put_back_velocities(network, direct.v, k, n)
            kappa = kappa * KAPPA_FALL if is_climbing else FIRST_KAPPA
            is_climbing = True
            continue
        before, error = error, take_outer_step(network, direct, k, d, n)
        if error < least:
            least = error
            copy_impulses(islands, k, network.P, direct.best, d)
        if least <= 0.5 * mark:
            mark, marked = least, work
        if not error <= OUTER_REDUCTION * before:
            kappa = next_kappa(network, k, kappa, steps, tol, d, n)
    copy_impulses(islands, k, direct.best, network.P, d)
    islands.residual[k] = judge_island(network, k, d, n)
    return MET if islands.residual[k] <= tol else UNMET


@kernel("void(int64, int64)")
def begin_direct(network_at, direct_at):
    """Before the islands of a network are solved: ``recall_graph``."""
    recall_graph(view(network_at, Network), view(direct_at, Direct))


@in_dimensions("int64(int64, int64, int64, float64, int64)")
def solve_by_al_newton(network_at, direct_at, k, tol, most, d):
    """``al_newton`` at the desk of the solver."""
    direct = view(direct_at, Direct)
    return al_newton(view(network_at, Network), direct, direct.desk, k, tol, most, d, 3 * (d - 1))
