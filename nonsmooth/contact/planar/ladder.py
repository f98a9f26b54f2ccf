"""Several planar contacts at once: the ladder of methods of one step.

Islands of contacts that are not coupled are solved apart (islands.py), one contact in closed form (single.py). Several:

1. the impulses of the step before, where every contact rested: kept if they still balance (kept.py);
2. where there is one motion, by a certificate (certificate.py) or by the last census (census.py): the modes of the step
   before, if they still hold, else Newton's (newton.py) or Lemke's method (lemke.py);
3. else every solution by enumeration of modes (planar/enumerate.py), of the contacts that reduction.py leaves, and the
   selection rule; where a census is not possible, or has to wait, as in 2;
4. Lemke's method where contacts are redundant and the enumeration found nothing, and at last the enumeration that
   decides redundant contacts (redundant.py), which is compiled when a step first needs it;
5. Gauss–Seidel over the contacts (gauss_seidel.py), each solved in closed form, with its law of friction where that
   varies with the speed; alone where friction vanishes with it.

The semismooth Newton method is compiled for scenes of many contacts only. Whatever found the motion, redundant contacts
share its impulses by ``hold_modes``.

What is accepted satisfies the inclusions of ``problem.residual``.
"""

from __future__ import annotations

from enum import IntEnum

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
    pay_census_debt,
    remember_census,
)
from nonsmooth.contact.planar.certificate import has_one_motion
from nonsmooth.contact.planar.enumerate import MAX_LEAVES, enumerate_modes, leaves, select
from nonsmooth.contact.planar.gauss_seidel import gauss_seidel
from nonsmooth.contact.planar.kept import factor, hold_modes, keep_impulses, recall_modes
from nonsmooth.contact.planar.lemke import can_be_faceted, solve_by_lemke
from nonsmooth.contact.planar.newton import solve_by_newton
from nonsmooth.contact.planar.problem import (
    ACCEPTED_RESIDUAL,
    Planar,
    copy_part,
    has_varying_friction,
    largest_velocity,
    name_modes,
    residual,
    update_friction,
)
from nonsmooth.contact.planar.reduction import count_modes, group_contacts
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.contact.planar.single import SLIDE_PLUS, STICK, STILL_VELOCITY, count, slip_of, solve_alone
from nonsmooth.jit import interpreted, kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.contact_problem import Problem
from nonsmooth.mechanics.laws import can_stick, static_coefficient
from nonsmooth.mechanics.system import GIVEN_FORCE, ContactMode, System

SAME_VELOCITIES = 1e-8  # chosen: of max |c|: velocities of one motion, both with a residual of ACCEPTED_RESIDUAL
SPEED_SWEEPS = 50  # chosen: fixed point on mu(v) where several contacts slide


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


@kernel("Tuple((int64, int64, int64, float64))(int64, int64)", short_loops=True)
def solve_planar(problem_at, planar_at):
    """Solve a problem of n > 1 contacts; write P and the candidates. Returns (route, solutions, pivots, residual).

    ``planar.found``, ``members`` and ``bits`` tell of the island of each contact, ``is_counted`` and ``is_shared`` of
    all of them.
    """
    problem, planar = view(problem_at, Problem), view(planar_at, Planar)
    planar.pivots = 0
    pay_census_debt(planar.memory)
    n_islands = find_islands(problem.n, problem.start, problem.G, planar.island)
    is_counted, is_shared, found, worst, route = True, False, 1, 0.0, Route.KEPT.value
    for e in range(n_islands):
        m, bits = list_island(e, problem, planar), 0
        if m > 1:
            island = problem
            if n_islands > 1:
                copy_part(m, problem, planar.part)
                island = view(address(planar.part), Problem)
            path, solutions, off = solve_island(island, planar)
        else:
            path, bits, off = solve_uncoupled(planar.part.place[0], problem, planar)
            solutions = count(bits)
        if path <= Route.NO_SOLUTION:
            return path, 0, planar.pivots, off
        if m > 1 and n_islands > 1:
            give_back(problem, planar.part)
        for f in range(m):
            k = planar.part.place[f]
            planar.found[k], planar.members[k], planar.bits[k] = solutions, m, bits
        is_counted, is_shared = is_counted and planar.is_counted == 1, is_shared or planar.is_shared == 1
        found *= solutions
        worst = max(worst, off)
        if path != Route.KEPT and (route == Route.KEPT or route == Route.KEPT_MODES):
            route = path
    planar.is_counted, planar.is_shared = 1 if is_counted else 0, 1 if is_shared else 0
    return route, found, planar.pivots, worst


@kernel
def list_island(e, problem, planar):
    """List the contacts of island e in planar.part.place; returns their number."""
    m = 0
    for k in range(problem.n):
        if planar.island[k] == e:
            planar.part.place[m] = k
            m += 1
    return m


@kernel
def give_back(problem, part):
    """Write what was found for an island where its contacts stand among all."""
    for f in range(part.n):
        problem.candidate[part.place[f]] = part.candidate[f]
    for a in range(part.r):
        problem.P[part.row[a]] = part.P[a]


@kernel
def solve_uncoupled(k, problem, planar):
    """Contact k, to which no other is coupled: (route, bits of all admissible candidates, residual)."""
    bits, error = solve_alone(k, problem)
    planar.is_counted, planar.is_shared = 1, 0
    scale = 0.0
    for a in range(problem.start[k], problem.start[k + 1]):
        scale = max(scale, abs(problem.c[a]))
    off = error / scale if scale > 0.0 else error
    if bits == 0:
        return Route.NO_SOLUTION.value, 0, off
    is_kept = is_as_before(problem.candidate[k], problem.mode[k], problem.slip[k])
    return (Route.KEPT_MODES if is_kept else Route.ALONE).value, bits, off


@kernel
def is_as_before(candidate, mode, slip):
    """Whether a candidate is the mode of the step before."""
    if candidate >= SLIDE_PLUS:
        return mode == ContactMode.SLIDE and slip == slip_of(candidate)
    return (candidate == STICK) == (
        mode == ContactMode.STICK or mode == ContactMode.LOCKED
    ) and mode != ContactMode.SLIDE


@kernel
def solve_island(problem, planar):
    """Several contacts that are coupled: (route, solutions, residual)."""
    memory, closed = planar.memory, problem.closed
    for k in range(problem.n):
        problem.mu_static[k] = static_coefficient(problem.laws, k)
    if keep_impulses(problem, planar):
        found = memory.told[closed[0]]
        planar.is_counted, planar.is_shared = 1 if found > 0 else 0, memory.is_shared[closed[0]]
        return Route.KEPT.value, max(1, found), 0.0
    varies = has_varying_friction(problem)
    if varies:
        route, found = find_speeds(problem, planar)
    else:
        route, found = solve_with_fixed_friction(problem, planar)
    for k in range(problem.n):
        memory.told[closed[k]] = found if planar.is_counted == 1 else 0
        memory.is_shared[closed[k]] = planar.is_shared
    return route, found, planar.error


@rare_kernel
def find_speeds(problem, planar):
    """The ladder with mu at the speeds that it leads to, by a fixed point, or where that finds none contact by contact,
    each with its law, as where friction vanishes with the speed: no mode holds there at a mu that is given."""
    route, found = Route.FAILED.value, 0
    if all_can_stick(problem):
        for _ in range(SPEED_SWEEPS):
            route, found = solve_with_fixed_friction(problem, planar)
            if route <= Route.NO_SOLUTION:
                break
            if route == Route.GAUSS_SEIDEL or not update_friction(problem, planar):
                return route, found
        if route > Route.NO_SOLUTION and residual(problem, planar) <= ACCEPTED_RESIDUAL:
            return route, found
    if gauss_seidel(problem, planar):
        name_modes(STILL_VELOCITY, problem, planar)
        planar.is_counted, planar.is_shared = 0, 0
        return Route.GAUSS_SEIDEL.value, 1
    return (Route.NO_SOLUTION if route == Route.NO_SOLUTION else Route.FAILED).value, 0


@kernel
def all_can_stick(problem):
    """Whether no contact has friction that vanishes with its speed."""
    for k in range(problem.n):
        if problem.kinds[k, 1] > 0 and not can_stick(problem.laws, k):
            return False
    return True


@kernel
def solve_with_fixed_friction(problem, planar):
    """The ladder for given friction coefficients; the velocities reached are left in ``planar.gamma``."""
    recall_modes(problem)
    if has_one_motion(problem, planar):
        planar.is_counted = 1
        route = go_on(problem, planar)
        if route != Route.FAILED:
            return route, 1
        recall_modes(problem)
    left = group_contacts(problem, planar)
    n_modes = count_modes(left, MAX_LEAVES, problem, planar)
    if n_modes > EVERY_STEP:
        known = known_solutions(left, problem, planar) if n_modes <= MAX_LEAVES else UNKNOWN
        route = Route.FAILED.value
        if known == ALWAYS_ONE or n_modes > MAX_LEAVES or not may_count(planar):
            route = go_on(problem, planar)
        elif known != UNKNOWN and hold_modes(problem, planar):
            route = Route.KEPT_MODES.value
        is_counted = known == ALWAYS_ONE or (known == ONE_AS_BEFORE and route == Route.KEPT_MODES)
        planar.is_counted = 1 if is_counted else 0
        if route != Route.FAILED and (
            is_counted or known == NOT_TOLD or n_modes > MAX_LEAVES or not has_saddle(problem)
        ):
            return route, 1
        recall_modes(problem)
    elif known_solutions(left, problem, planar) == ALWAYS_ONE:
        planar.is_counted = 1
        route = go_on(problem, planar)
        if route != Route.FAILED:
            return route, 1
        recall_modes(problem)
    route, found = count_all(left, problem, planar)
    note_modes(problem, planar.memory)
    return route, found


@rare_kernel
def go_on(problem, planar):
    """One solution: by the modes in problem.candidate, else by Newton's or Lemke's method; FAILED if there is none."""
    if hold_modes(problem, planar):
        return Route.KEPT_MODES.value
    return solve_anew(problem, planar)


@rare_kernel
def solve_anew(problem, planar):
    """One solution by Newton's or Lemke's method; FAILED if these find none."""
    if planar.has_newton == 1 and solve_by_newton(address(problem), address(planar)):
        share(problem, planar)
        return Route.NEWTON.value
    if can_be_faceted(problem) and solve_by_lemke(problem, planar):
        share(problem, planar)
        return Route.LEMKE.value
    return Route.FAILED.value


@rare_kernel
def share(problem, planar):
    """Name the modes of a motion that was found, and let redundant contacts share its impulses. Where no such share is
    admissible, or it would be another motion, the impulses given are left. Returns whether there is one."""
    P, gamma, trial, step = problem.P, planar.gamma, planar.trial, planar.step
    scale = largest_velocity(problem)
    for row in range(problem.r):
        trial[row], step[row] = P[row], gamma[row]
    name_modes(ACCEPTED_RESIDUAL, problem, planar)
    is_shared = hold_modes(problem, planar)
    for row in range(problem.r):
        is_shared = is_shared and abs(gamma[row] - step[row]) <= SAME_VELOCITIES * scale
    if is_shared:
        return True
    for row in range(problem.r):
        P[row] = trial[row]
    residual(problem, planar)
    name_modes(STILL_VELOCITY, problem, planar)
    return False


@kernel
def has_saddle(problem):
    """Whether a contact slides with D < 0, which the selection rule takes only where there is nothing else."""
    for k in range(problem.n):
        if problem.candidate[k] >= SLIDE_PLUS and problem.kinds[k, 0] != GIVEN_FORCE:
            a = problem.start[k]
            if problem.G[a, a] + factor(k, problem) * problem.G[a, a + 1] <= 0.0:
                return True
    return False


@kernel
def count_all(left, problem, planar):
    """Every solution, of the contacts that are left and, where that does not decide, of all; else any solution."""
    planar.is_counted = 1
    is_singular = False
    for attempt in range(2):
        if attempt == 1:
            left = take_all(problem.n, planar)
        n_modes = count_modes(left, MAX_LEAVES, problem, planar)
        if n_modes > MAX_LEAVES:
            break
        found, is_complete = take_census(n_modes, left, problem, planar)
        if found == 0 and is_complete:
            return Route.NO_SOLUTION.value, 0
        if found > 0 and take_solution(found, left, is_complete, problem, planar):
            return Route.ENUMERATED.value, found
        is_singular = True
        if left == problem.n and not has_groups(problem.n, planar):
            break
    planar.is_counted = 0
    route = go_on(problem, planar)
    if route != Route.FAILED:
        return route, 1
    left = take_all(problem.n, planar)
    is_enumerable = count_modes(left, MAX_LEAVES, problem, planar) <= MAX_LEAVES
    if is_singular and is_enumerable and planar.can_decide_redundant == 1:
        copy_part(left, problem, planar.rest)
        found = enumerate_redundant(address(problem), problem.G, address(planar))
        if found == 0:
            return Route.NO_SOLUTION.value, 0
        if take_solution(found, left, False, problem, planar):
            planar.is_counted = 1
            return Route.ENUMERATED.value, found
    if gauss_seidel(problem, planar):
        share(problem, planar)
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
def take_census(n_modes, left, problem, planar):
    """Enumerate the solutions of the contacts that are left; returns as ``enumerate_modes``."""
    copy_part(left, problem, planar.rest)
    found, is_complete = enumerate_modes(address(planar.rest), address(planar.tree))
    remember_census(found, left, problem, planar)
    return found, is_complete


@rare_kernel
def take_solution(found, left, is_regular, problem, planar):
    """Take one of the solutions in the tree by the selection rule; True if it satisfies the inclusions."""
    rest, tree, P = planar.rest, planar.tree, problem.P
    take = select(found, view(address(rest), Problem), tree)
    for row in range(problem.r):
        P[row] = 0.0
    for a in range(rest.r):
        P[rest.row[a]] = tree.solutions[take, a]
    is_solved = residual(problem, planar) <= ACCEPTED_RESIDUAL
    planar.is_shared = 0
    if is_regular and left == problem.n and not sticks_together(take, left, planar):
        name_modes(STILL_VELOCITY, problem, planar)
    elif share(problem, planar):
        is_solved = True
    else:
        planar.is_shared = 1
        spread_friction(take, problem, planar)
        is_solved = residual(problem, planar) <= ACCEPTED_RESIDUAL
        name_modes(STILL_VELOCITY, problem, planar)
    return is_solved


@kernel
def spread_friction(take, problem, planar):
    """Give the friction of each group that sticks to its members in the parts of their limits mu P_N."""
    rest, tree, P = planar.rest, planar.tree, problem.P
    for e in range(rest.n):
        if tree.group[e] != e + 1:
            continue
        friction, reach = 0.0, 0.0
        for f in range(e, rest.n):
            if tree.group[f] == e + 1 and tree.modes[take, f] == STICK:
                a = problem.start[rest.place[f]]
                friction += P[a + 1]
                reach += rest.mu_static[f] * P[a]
        for f in range(e, rest.n):
            if tree.group[f] == e + 1 and tree.modes[take, f] == STICK and reach > 0.0:
                a = problem.start[rest.place[f]]
                P[a + 1] = friction * rest.mu_static[f] * P[a] / reach


def exceeds_enumeration(system: System) -> bool:
    """Whether more contacts of the system may be closed at once than are enumerated."""
    return bool(interpreted(leaves)(system.n_c, system.kinds, MAX_LEAVES) > MAX_LEAVES)
