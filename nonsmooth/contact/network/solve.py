"""How the islands of a network are solved, one after the other, each from the impulses that it has.

    BY_START    its residual is within the tolerance: nothing is done
    BY_SWEEPS   conjugate sweeps, in rounds, as many as the budget allows; of discs and spheres over-relaxed ones until
                they stall, up to four times as many while the tolerance is in sight, and up to eight times while
                bodies still approach fast enough to be deep in one another at the end of the step
    BY_FACTORS  the augmented Lagrangian, as soon as the sweeps would not come to the tolerance within their budget,
                where factors are affordable: some bodies, or many in the plane or of unlike masses

Islands of few bodies are solved to rounding, unless the tolerance is a coarse one: what rests is then a fixed point,
to the last bit. Those of some bodies of very unlike masses are too, and go to ``rescue`` where that does not do: a
residual of 1e-8 of impulses that hold ten tons is the weight of a tenth of a gram between. So are islands of some
hundred bodies once they are at rest (``rest``). Where the factors of a large island led nowhere, a loose heap in
motion, they are left out for a while, and until it is calm: no contact lands, and the impulses of the step before
nearly solve it.

Whatever was tried, the impulses of the least residual are left, with velocities of just these impulses and the residual
recomputed from them. ``islands`` says of each one its rung, sweeps, factors, residual and whether that will do.
"""

from __future__ import annotations

import math

from nonsmooth.contact.network.al_newton import NO_ROOM, al_newton, copy_impulses, judge_island, recall_graph
from nonsmooth.contact.network.conjugate import Conjugate, conjugate_sweeps
from nonsmooth.contact.network.joint import is_joint
from nonsmooth.contact.network.lagrangian import Desk, Direct
from nonsmooth.contact.network.patience import (
    AT_REST,
    FACTORS,
    LONG_SWEEPS,
    MANY_FACTORS,
    Patience,
    begin_problem,
    note_outcome,
)
from nonsmooth.contact.network.problem import Network, relative_velocity, rounding
from nonsmooth.contact.network.rest import is_at_rest
from nonsmooth.contact.network.round_rows import RoundRows
from nonsmooth.contact.network.round_sweeps import are_round, round_sweeps
from nonsmooth.jit import in_dimensions, kernel, rare_kernel
from nonsmooth.jit.blocks import Block, view
from nonsmooth.numerics.rounding import EPS

BY_START, BY_SWEEPS, BY_FACTORS, BY_INTERIOR = range(4)  # code; the last one is of ``rescue``

FIRST_ROUND, ROUND = 10, 25  # chosen: sweeps between two residuals, each of which costs one and a half
# measured: of steps of heaps of spheres, whose start is near; from no impulses factors find less than from conjugate
# sweeps. 1.5 takes a tenth less sweeps, and left a sphere 0.16 mm deep; 1.6 stalls at 2e-3
OVER_RELAXATION = 1.4
# measured: part of the residual that a round leaves after which sweeps are conjugate: some packings stall over-relaxed
ROUND_STALLED = 0.9
# measured: rounds without a better residual after which discs and spheres are relaxed less, by this factor and down to
# this least: where mu is 1 or more three that touch one another may go round for ever, two contacts sliding and one
# sticking; with 0.8 for good 3 of 72 heaps more do not come to 1e-10
ROUNDS_IN_CIRCLES, LESS_RELAXED, LEAST_RELAXATION = 3, 0.8, 0.3
# measured: mu from which they may: 1000 falling discs with mu = 0.5 took 2.4 ms a step, 1.5 without
MAY_CIRCLE = 1.0
PAYING_SWEEPS = 4  # chosen: budgets of discs and spheres that may be spent while the tolerance is in sight
# measured: budgets that may be spent while they approach faster than ``Solver.approach``: with 4, discs that fall from
# 5 m in a funnel, an hourglass and boxes are up to 0.13 mm deep, with 8 0.09 mm
SWEEPS_WHERE_DEEP = 8
SWEEPS_FOR_FACTORS = 4  # measured: of the budget, that an island of spheres is swept before it is factorised
FEW_CONTACTS = 4  # chosen: which plain sweeps solve at once
FEW_BODIES = 200  # measured: 150 spheres take 8 ms a factor, 1000 200 ms
MANY_BODIES = 2000  # measured: 1000 bodies in the plane take 2 ms a factor
# measured: residuals of islands that are solved to rounding, and then by a few more steps with the factors at hand: a
# stack of ten boxes takes 2 us a step then, with a top a thousand times heavier 3 us; to 1e-8 they take 140 and 430,
# and creep
SOLVED_TO_ROUNDING, ROUNDED = 1e-13, 3e-16
# measured: of islands of many bodies: a pyramid of 1035 boxes then stands to the last bit, and sleeps
ROUNDED_OF_MANY = 1e-14
FINE = 1e-7  # chosen: a tolerance above it is one for speed
EXACT_BODIES = 32  # chosen: a factor of so many takes some 50 us in space
POLISH_FACTORS = 2  # chosen: more would be for modes that still change
LARGE_FACTORS = 100  # measured: of a large island: a pyramid of 1035 boxes takes 56 from no impulses
BARELY_MOVED = 1e-3  # chosen: residual of the impulses of the step before, above which many modes change
# measured: of a large island where they led nowhere the last time: of 1000 discs at rest 6 to 15 lead somewhere, and
# others 30 to 60 nowhere
RETRY_FACTORS = 25
BODIES_A_WAIT = 2  # chosen: problems that an island at rest is left out for where that did not do, by bodies
MOST_RESTING = 500  # measured: 1000 discs, of which one rolls for ever, take 10 factors in each step, 15 ms
# chosen: more than a loose heap has, in which sizes differ by less than ten
VERY_UNLIKE_MASSES = 1e3
UNLIKE_MASSES = 10.0  # measured: sweeps of a stack of ten do not reach 1e-3 in 200 where the top is 1000 times heavier


class Solver(Block):
    """The memory of the solvers for a network of the same m, n_b, d and n; ``fill`` blocks in the factors.

    Some 10 blocks a body are enough in the plane, 30 in space.
    """

    tol: float  # largest residual that is asked for
    most_sweeps: int  # of an island
    most_factors: int  # of an island; 0 is sweeps alone
    over_relaxation: float  # of spheres; up to 1 is conjugate sweeps
    approach: float  # that sweeps of discs and spheres should leave at most [m/s]; 0: whatever it is
    most_inside: int  # bodies of an island that interior points solve (``rescue``)
    contradicted: int  # steps since a large island at rest was not solved, whose small gaps cannot all close; 0: none
    patience: Patience
    conjugate: Conjugate
    rows: RoundRows  # of discs and spheres
    direct: Direct


@kernel
def solve(network, solver, desk, d, n):
    """Solve all islands of a desk; 0, or how many blocks of factors are wanted where there is no room for them.

    Called again with more room it goes on where it was, to the bits that it would have come to with that room at once.
    """
    islands, first, waited = network.islands, 0, -1
    if desk.going_on > 0:
        first = waited = desk.going_on - 1
        desk.going_on = 0
    else:
        begin_islands(network, solver)
    for k in range(first, islands.count):
        if islands.is_met[k] == 0 and islands.owner[k] == desk.part:
            is_next = k == waited and islands.rung[k] == BY_FACTORS
            if not solve_island(network, solver, desk, k, is_next, d, n):
                desk.going_on = 1 + k
                return desk.graph.wanted
    return 0


@kernel
def begin_islands(network, solver):
    """Before the islands of a problem are solved: what is kept of the one before."""
    network.tol = solver.tol
    recall_graph(network, solver.direct)
    begin_problem(solver.patience)


@kernel
def solve_island(network, solver, desk, k, is_next, d, n):
    """Take island k up the ladder; False where there is no room for its factors. ``is_next``: these are next."""
    islands, has_room, bodies = network.islands, True, bodies_of(network, k)
    islands.residual[k] = judge_island(network, k, d, n)
    if not is_next and islands.residual[k] <= solver.tol and not is_within(network, k):
        islands.is_met[k] = 1  # further digits would be those of roundings
        return True
    is_direct = is_next or may_factorise(network, solver, k, d, n)
    is_fine = bodies <= EXACT_BODIES or has_very_unlike_masses(network, k)
    goal = min(solver.tol, SOLVED_TO_ROUNDING) if is_direct and is_fine and solver.tol <= FINE else solver.tol
    if not islands.residual[k] <= goal:
        if not is_next:
            islands.rung[k] = BY_SWEEPS
            sweep_in_rounds(network, solver, k, goal, is_direct, d, n)
        if is_direct and not islands.residual[k] <= goal:
            most = affordable_factors(solver, bodies)
            has_room = solve_directly(network, solver, desk, k, goal, most, d, n)
            if has_room:  # where that did not come to the goal either, the rest of the budget is spent
                note_factors(solver.patience, bodies, islands.residual[k] <= goal, islands.factors[k])
                sweep_in_rounds(network, solver, k, goal, False, d, n)
    floor = ROUNDED if bodies <= FEW_BODIES else ROUNDED_OF_MANY
    if has_room and solver.tol <= FINE and floor < islands.residual[k] <= goal:
        has_room = polish(network, solver, desk, k, floor, is_direct, d, n)
    if has_room:
        islands.is_met[k] = islands.residual[k] <= solver.tol and not may_creep(network, solver, k, d, n)
        if not islands.residual[k] <= solver.tol and bodies > EXACT_BODIES and is_at_rest(network, k, n):
            solver.contradicted = max(1, solver.contradicted)
    return has_room


@kernel
def is_within(network, k):
    """Whether |F| of island k is within tol |P|, without what rounding of its velocities hides."""
    return network.islands.F[k] <= network.tol * network.tol * network.islands.P[k]


@kernel
def has_very_unlike_masses(network, k):
    """Whether masses of island k, of some bodies, differ so much that light ones carry heavy ones: the impulses between
    them are to be known to a part of the weight of the light ones."""
    return bodies_of(network, k) <= FEW_BODIES and ratio_of_masses(network, k) > VERY_UNLIKE_MASSES


@kernel
def may_creep(network, solver, k, d, n):
    """Whether island k, met to the tolerance, is one of these without joints, and not solved to rounding: dearer
    solvers may do, which leave joints half of the digits."""
    islands = network.islands
    if solver.tol > FINE or islands.residual[k] <= SOLVED_TO_ROUNDING or not has_very_unlike_masses(network, k):
        return False
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        if is_joint(network, islands.contacts[at]):
            return False
    return math.sqrt(islands.F[k]) > rounding(network, k, math.inf, d, n)


@kernel
def lasting_residual(network, solver, k):
    """The residual up to which the ladder leaves island k as it is, whatever else there is, however long it waits."""
    bodies = bodies_of(network, k)
    if solver.tol > FINE or bodies > MANY_BODIES:
        return solver.tol
    return min(solver.tol, ROUNDED if bodies <= FEW_BODIES else ROUNDED_OF_MANY)


@kernel
def bodies_of(network, k):
    """How many bodies island k has."""
    return network.islands.body_start[k + 1] - network.islands.body_start[k]


@kernel
def may_factorise(network, solver, k, d, n):
    """Whether the direct rung is for island k, now."""
    if solver.most_factors == 0 or not has_affordable_factors(network, k, d):
        return False
    bodies = bodies_of(network, k)
    if bodies <= EXACT_BODIES:
        return True
    patience = solver.patience
    if bodies <= FEW_BODIES:
        return patience.left[FACTORS] == 0
    is_new = patience.wait[MANY_FACTORS] == 0
    return patience.left[MANY_FACTORS] == 0 and (is_new or is_calm(network, k, d, n))


@kernel
def polish(network, solver, desk, k, floor, is_direct, d, n):
    """Bring island k, solved to the tolerance, to rounding: where factors are due, and a large one that is at rest."""
    islands, patience, made = network.islands, solver.patience, desk.factors
    is_resting = patience.left[AT_REST] == 0 and may_rest(network, solver, k, d) and is_at_rest(network, k, n)
    if not is_direct and not is_resting:
        return True
    most = min(solver.most_factors, RETRY_FACTORS) if is_resting else POLISH_FACTORS
    if not solve_directly(network, solver, desk, k, floor, most, d, n):
        return False
    made, is_round, bodies = desk.factors - made, islands.residual[k] <= floor, bodies_of(network, k)
    if is_resting:
        note_outcome(patience, AT_REST, False, made, bodies // BODIES_A_WAIT)  # what rests asks for no more
    else:
        note_factors(patience, bodies, is_round, made)
    return True


@kernel
def may_rest(network, solver, k, d):
    """Whether island k is one that is brought to rounding at rest: too large to be solved to rounding in any case."""
    is_large = EXACT_BODIES < bodies_of(network, k) <= MOST_RESTING and solver.tol <= FINE
    return is_large and solver.most_factors > 0 and has_affordable_factors(network, k, d)


@kernel
def affordable_factors(solver, bodies):
    """How many an island of so many bodies is given: few of a large one where they led nowhere the last time."""
    if bodies <= FEW_BODIES:
        return solver.most_factors
    return min(solver.most_factors, RETRY_FACTORS if solver.patience.wait[MANY_FACTORS] > 0 else LARGE_FACTORS)


@kernel
def is_calm(network, k, d, n):
    """Whether island k begins, or goes on much as it did: no open contact without an impulse closes."""
    islands = network.islands
    if islands.P[k] > 0.0 and not islands.residual[k] <= BARELY_MOVED:
        return False
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        if network.b[c, 0] > 0.0 and network.P[c, 0] == 0.0:
            gamma_N, _, _ = relative_velocity(network, c, d, n)
            if gamma_N < 0.0:
                return False
    return True


@kernel
def note_factors(patience, bodies, is_solved, made):
    """Note what factors of an island of so many bodies led to. Where there are many, and those that led somewhere were
    many too, the next ones wait until it is calm."""
    if bodies > FEW_BODIES:
        note_outcome(patience, MANY_FACTORS, is_solved, made, 1)
        if made > RETRY_FACTORS:
            patience.wait[MANY_FACTORS] = max(1, patience.wait[MANY_FACTORS])
    elif bodies > EXACT_BODIES:
        note_outcome(patience, FACTORS, is_solved, made, 1)


@kernel
def solve_directly(network, solver, desk, k, goal, most, d, n):
    """The direct rung; False where there is no room for the factors."""
    islands, made = network.islands, desk.factors
    islands.rung[k] = BY_FACTORS
    end = al_newton(network, solver.direct, desk, k, goal, most, d, n)
    islands.factors[k] += desk.factors - made
    return end != NO_ROOM


@kernel
def has_affordable_factors(network, k, d):
    """Whether the direct rung is for island k."""
    bodies = bodies_of(network, k)
    return bodies <= FEW_BODIES or (bodies <= MANY_BODIES and (d == 2 or ratio_of_masses(network, k) > UNLIKE_MASSES))


@kernel
def ratio_of_masses(network, k):
    """The largest over the least mass of island k."""
    islands = network.islands
    least, largest = math.inf, 0.0
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        mass = network.M[islands.bodies[at], 0, 0]
        least, largest = min(least, mass), max(largest, mass)
    return largest / least


@kernel
def sweep(network, solver, k, most, omega, d, n):
    """A round of sweeps from the velocities of the impulses: how many. By rows, omega > 0, they leave v alone."""
    if omega > 0.0:
        return round_sweeps(network, solver.rows, solver.conjugate, k, most, EPS, omega, d)
    return conjugate_sweeps(network, solver.conjugate, k, most, EPS, d, n)


@kernel
def is_in_sight(error, before, count, left, goal):
    """Whether the goal is reached within the sweeps that are left, if they go on as the last ``count`` did."""
    return error * (error / before) ** (left / count) <= goal


@rare_kernel
def fastest_approach(network, k, n):
    """The fastest that bodies of island k still approach, beyond what their gaps let them [m/s]."""
    islands, fastest = network.islands, 0.0
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        i, j, gamma_N = network.i[c], network.j[c], network.b[c, 0]
        for x in range(n):
            gamma_N += network.J_i[c, 0, x] * network.v[i, x] + network.J_j[c, 0, x] * network.v[j, x]
        fastest = max(fastest, -gamma_N)
    return fastest


@kernel
def largest_mu(network, k):
    """The largest coefficient of friction of island k."""
    islands, largest = network.islands, 0.0
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        largest = max(largest, network.mu[islands.contacts[at]])
    return largest


@rare_kernel
def sweep_in_rounds(network, solver, k, goal, may_leave, d, n):
    """Sweep island k until it is solved or the budget is spent, or is seen not to be enough where one may leave.

    Discs and spheres go on beyond it while the tolerance is in sight, and while they would be driven into one another;
    where they go round in circles they are relaxed less.
    """
    islands, best = network.islands, solver.direct.best
    error = least = islands.residual[k]
    copy_impulses(islands, k, network.P, best, d)
    done, most_sweeps, is_hopeful, circles = islands.sweeps[k], solver.most_sweeps, True, 0
    omega = 0.0
    if solver.most_sweeps > done and not least <= goal and are_round(network, solver.rows, k, d):
        is_many = islands.contact_start[k + 1] - islands.contact_start[k] > FEW_CONTACTS
        omega = solver.over_relaxation if is_many and solver.over_relaxation > 1.0 else 1.0
        most_sweeps *= SWEEPS_FOR_FACTORS if may_leave and omega > 1.0 and d == 3 else 1
    budget = longest = deepest = most_sweeps
    if omega > 0.0 and solver.approach > 0.0:
        deepest = max(most_sweeps, SWEEPS_WHERE_DEEP * solver.most_sweeps)
    is_long = False
    if omega > 1.0 and (solver.patience.left[LONG_SWEEPS] == 0 or bodies_of(network, k) <= EXACT_BODIES):
        longest = max(most_sweeps, PAYING_SWEEPS * solver.most_sweeps)
    while done < budget and is_hopeful and not least <= goal:
        most = min(FIRST_ROUND if done == 0 else ROUND, budget - done)
        count = sweep(network, solver, k, most, omega, d, n)
        done += count
        before, error = error, judge_island(network, k, d, n)
        if done == budget < longest and omega > 1.0 and is_in_sight(error, before, count, longest - done, goal):
            budget, is_long = min(budget + ROUND, longest), True
        if done == budget < deepest and fastest_approach(network, k, n) > solver.approach:
            budget = min(budget + ROUND, deepest)
        circles = 0 if error < least else circles + 1
        if 0.0 < omega <= 1.0 and circles >= ROUNDS_IN_CIRCLES and largest_mu(network, k) >= MAY_CIRCLE:
            omega, circles = max(LESS_RELAXED * omega, LEAST_RELAXATION), 0
        if omega > 1.0 and error > ROUND_STALLED * before:
            omega, circles = 1.0, 0
        if error < least:
            least = error
            copy_impulses(islands, k, network.P, best, d)
        is_hopeful = not may_leave or is_in_sight(error, before, count, budget - done, goal)
    islands.sweeps[k] = done
    if is_long and bodies_of(network, k) > EXACT_BODIES:
        note_outcome(solver.patience, LONG_SWEEPS, least <= goal, 0, 1)
    if not error == least:
        copy_impulses(islands, k, best, network.P, d)
        judge_island(network, k, d, n)
    islands.residual[k] = least


@in_dimensions("int64(int64, int64, int64)")
def solve_network(network_at, solver_at, desk_at, d):
    """``solve``; the desk is that of the solver, or of a thread (``parallel``)."""
    return solve(view(network_at, Network), view(solver_at, Solver), view(desk_at, Desk), d, 3 * (d - 1))
