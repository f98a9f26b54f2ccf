"""Every set of contact forces that a state admits: the acceleration-level problem, solved by modes.

    gamma' = G la + b

A contact at rest has its four modes. One that slides, gamma_F != 0, keeps its direction s for an instant and has one
unknown, la_F = -s mu sigma la_N with sigma the sign of la_N: its row of friction leaves the problem, and

    gamma_N' = (G_NN - G_NF diag(mu s sigma)) la_N + b_N

is a problem of normal forces alone, with a matrix that is not symmetric. For unilateral contacts (sigma = +1) it is the
linear complementarity problem whose matrix fails to be a P-matrix in Painlevé's paradoxes; for bilateral ones both
signs sigma are tried. Contacts that G does not couple are islands: each has its own solutions, found by
``enumerate``, and the solutions of all are the products of these, which nothing enumerates.

Source: Lötstedt, *ZAMM* 61 (1981) 605; Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Annotated as Array

from nonsmooth.contact.islands import find_held_islands
from nonsmooth.contact.planar.enumerate import SAME_MOTION, enumerate_modes, leaves
from nonsmooth.contact.planar.implied import are_dependent
from nonsmooth.contact.planar.problem import Part, Planar, largest_velocity
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.contact.planar.single import BORDER_WIDTH, FREE, PULL_MINUS, PULL_PLUS, SLIDE_MINUS, SLIDE_PLUS, STICK
from nonsmooth.errors import Status
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, address, view
from nonsmooth.mechanics.acceleration_problem import acceleration_problem_apart
from nonsmooth.mechanics.contact_problem import Work, evaluate_rows, row_velocities
from nonsmooth.mechanics.laws import friction_coefficient, static_coefficient
from nonsmooth.mechanics.situation import Situation, find_situation, tolerances_of_state
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import BILATERAL, GAP, GIVEN_FORCE

MAX_MODES = 400_000  # derived: 5^8: eight bilateral contacts at rest, a fifth of a second
MAX_CONTACTS = 18  # derived: 2^18 modes of sliding contacts are fewer, 2^19 more
FORCES_KEPT = 256  # derived: solutions kept of one island: eight sliding contacts have at most that many
MOST_COUNTED = 1 << 52  # derived: solutions of all islands that are counted


class Forces(Block, most=MAX_CONTACTS, kept=FORCES_KEPT, c="max(1, n_c)", r="max(1, n_c * (1 + d))", n_q=0):
    """Arrays of the search for forces. c = contacts, r = rows."""

    work: Array[Work, "n_q = n_q"]
    rates: Array[Floats, 4, "r"]
    situation: Array[Ints, "c"]  # of every contact
    gamma: Array[Floats, "c", "max(2, 1 + d)"]  # gamma_N, gamma_F of every contact
    slip: Array[Ints, "c"]  # sign of sliding of each closed contact, 0 at rest
    mu: Array[Floats, "c"]  # of each closed contact, at its present speed
    mu_static: Array[Floats, "c"]
    normal: Array[Floats, "c"]  # given normal forces of the closed contacts
    sigma: Array[Ints, "c"]  # sign of la_N tried at bilateral contacts that slide
    asked: Array[Ints, "c"]  # 1 for closed contacts whose island is looked at
    reduced: Array[Part, "n_c = c"]  # the problem of an island without the friction rows of slides
    K: Array[Floats, "r", "r"]  # its G without friction
    planar: Array[Planar, "n = min(max(n_c, 2), most)", "kept = kept"]  # in which it is solved
    held: Array[Ints, "c"]  # rows of each closed contact that stay in the reduced problem
    island: Array[Ints, "c"]  # of each closed contact
    number: Array[Ints, "c"]  # solutions of each island
    outcome: Array[Ints, "c"]  # Outcome of each island
    candidate: Array[Ints, "kept", "c"]  # modes of each solution of the island of each closed contact
    la: Array[Floats, "kept", "r"]  # and its forces, by row of the full problem
    taken: Array[Floats, "r"]  # the forces that an integrator takes of them


class Outcome(IntEnum):
    """How far the search went."""

    COMPLETE = 0
    SINGULAR = 1  # some modes have singular equations, and ``enumerate_redundant`` is not loaded yet
    TOO_MANY = 2  # more modes than are enumerated
    INADMISSIBLE = 3  # no acceleration-level problem: a contact lands, penetrates or is violated
    NOT_FINITE = 4  # a model function raised or wrote NaN


@kernel(
    "Tuple((int64, int64, int64, int64))(int64, float64, float64[::1], float64[::1], int64)",
    short_loops=True,
)
def forces_at_state(sys_at, t, q, u, forces_at):
    """All contact forces at a state: (outcome, solutions, closed contacts, rows)."""
    sys = view(sys_at, Sys)
    forces = view(forces_at, Forces)
    if sys.n_c == 0:
        return Outcome.COMPLETE.value, 1, 0, 0
    n_k = list_closed(sys, t, q, u, forces)
    if n_k < 0:
        return (Outcome.INADMISSIBLE if n_k == -1 else Outcome.NOT_FINITE).value, 0, 0, 0
    if n_k == 0:
        return Outcome.COMPLETE.value, 1, 0, 0
    for k in range(n_k):
        i = forces.work.closed[k]
        forces.asked[k] = 1
        forces.slip[k] = 0
        if forces.situation[i] == Situation.SLIDING:
            forces.slip[k] = 1 if forces.gamma[i, 1] > 0.0 else -1
    outcome, found, r = forces_of_closed(sys, t, q, u, n_k, forces)
    return outcome, found, n_k, r


@kernel
def forces_of_closed(sys, t, q, u, n_k, forces):
    """All forces of the n_k contacts in work.closed, whose slip and gamma are known: (outcome, solutions, rows)."""
    is_finite, r = set_up_closed(sys, t, q, u, n_k, forces)
    if not is_finite:
        return Outcome.NOT_FINITE.value, 0, r
    outcome, found = find_forces(sys, n_k, forces)
    return outcome, found, r


@kernel
def set_up_closed(sys, t, q, u, n_k, forces):
    """Fill work, coefficients and given forces of the n_k contacts in work.closed: (whether they are numbers, rows)."""
    work, kinds, laws = forces.work, sys.kinds, sys.laws
    status, r = acceleration_problem_apart(address(sys), t, q, u, n_k, forces.rates, address(work))
    if status != Status.RUNNING:
        return False, r
    for k in range(n_k):
        i = work.closed[k]
        forces.mu[k] = friction_coefficient(laws, i, sliding_speed(i, forces.gamma)) if kinds[i, 1] > 0 else 0.0
        forces.mu_static[k] = static_coefficient(laws, i) if kinds[i, 1] > 0 else 0.0
        forces.normal[k] = max(0.0, work.N[i])
    return True, r


@kernel
def sliding_speed(i, gamma):
    """|gamma_F| of a contact."""
    if gamma.shape[1] == 2:
        return abs(gamma[i, 1])
    return math.sqrt(gamma[i, 1] * gamma[i, 1] + gamma[i, 2] * gamma[i, 2])


@kernel
def list_closed(sys, t, q, u, forces):
    """Fill work.closed and the situation of every contact; their number, -1 if inadmissible, -2 if not finite."""
    work, kinds, situation, gamma = forces.work, sys.kinds, forces.situation, forces.gamma
    n_c, length, speed = kinds.shape[0], 0.0, 0.0
    for j in range(q.shape[0]):
        work.q_mid[j] = q[j]
        length = max(length, abs(q[j]))
    for j in range(u.shape[0]):
        speed = max(speed, abs(u[j]))
    if sys.has & (1 << GAP) and not evaluate(sys, GAP, t, q, u, work.g_N):
        return -2
    if not evaluate_rows(sys, True, t, u, work):
        return -2
    for i in range(n_c):
        work.closed[i] = i
    row_velocities(sys, n_c, u, work)
    r = 0
    surface = 0.0
    for i in range(n_c):
        for axis in range(gamma.shape[1]):
            gamma[i, axis] = 0.0
        if kinds[i, 0] != GIVEN_FORCE:
            gamma[i, 0] = work.gamma_0[r]
            r += 1
        for axis in range(kinds[i, 1]):
            gamma[i, 1 + axis] = work.gamma_0[r]
            r += 1
        surface = max(surface, sliding_speed(i, gamma))
    near, slow, still = tolerances_of_state(length, speed, surface)
    n_k = 0
    is_admissible = True
    for i in range(n_c):
        speed = sliding_speed(i, gamma)
        situation[i] = find_situation(kinds[i, 0], work.g_N[i], gamma[i, 0], speed, near, slow, still, False)
        if situation[i] == Situation.RESTING or situation[i] == Situation.SLIDING:
            work.closed[n_k] = i
            n_k += 1
        elif situation[i] != Situation.OPEN:
            is_admissible = False
    return n_k if is_admissible else -1


@kernel
def find_forces(sys, n_k, forces):
    """The solutions of every island of the problem in forces.work for given slip signs: (Outcome of the island that
    was least complete, number of solutions of all)."""
    outcome, total = Outcome.COMPLETE.value, 1
    for island in range(list_islands(sys, n_k, forces)):
        forces.outcome[island], forces.number[island] = Outcome.COMPLETE.value, 1
        if is_asked(island, n_k, forces):
            forces.outcome[island], forces.number[island] = find_forces_of(sys, island, n_k, forces)
        outcome = max(outcome, forces.outcome[island])
        total = min(MOST_COUNTED, total * forces.number[island])
    return outcome, total


@kernel
def is_asked(island, n_k, forces):
    """Whether the solutions of an island are asked for: of islands that go on as they were they are not."""
    for k in range(n_k):
        if forces.island[k] == island and forces.asked[k] == 1:
            return True
    return False


@kernel
def list_islands(sys, n_k, forces):
    """Number the islands of the closed contacts; returns how many."""
    work = forces.work
    for k in range(n_k):
        width = work.start[k + 1] - work.start[k]
        is_sliding = forces.slip[k] != 0
        forces.held[k] = width
        if is_sliding:
            forces.held[k] = 0 if sys.kinds[work.closed[k], 0] == GIVEN_FORCE else 1
    return find_held_islands(n_k, work.start, forces.held, work.G, forces.island)


@kernel
def solution_of(number, island, forces):
    """Which solution of an island belongs to a solution of all: its digit, the first island's changes fastest."""
    for before in range(island):
        number //= forces.number[before]
    return number % forces.number[island]


@kernel
def find_forces_of(sys, island, n_k, forces):
    """Every solution of one island: (Outcome, number)."""
    reduced, planar, tree = forces.reduced, forces.planar, forces.planar.tree
    found = 0
    outcome = Outcome.COMPLETE.value
    pairs = count_pairs(sys, island, n_k, forces)
    for signs in range(pairs):
        n = reduce_problem(sys, island, n_k, signs, forces)
        if n > planar.island.shape[0] or pairs * leaves(n, reduced.kinds, MAX_MODES) > MAX_MODES:
            return Outcome.TOO_MANY.value, 0
        number = 1
        is_complete = n < 2 or planar.can_decide_redundant == 0 or not are_dependent(forces.K, reduced, tree)
        if n > 0 and is_complete:
            number, is_complete = enumerate_modes(address(reduced), address(tree))
        if not is_complete and planar.can_decide_redundant == 0:
            outcome = Outcome.SINGULAR.value
        elif not is_complete:
            number = enumerate_redundant(address(reduced), forces.K, address(planar))
        for m in range(min(number, tree.modes.shape[0])):
            found += keep_solution(sys, island, n_k, m, found, forces)
        if number > tree.modes.shape[0]:
            found += number - tree.modes.shape[0]
    return outcome, found


@kernel
def count_pairs(sys, island, n_k, forces):
    """Number of combinations of the signs of la_N at the bilateral contacts of an island that slide."""
    pairs = 1
    for k in range(n_k):
        is_bilateral = sys.kinds[forces.work.closed[k], 0] == BILATERAL
        if forces.island[k] == island and is_bilateral and forces.slip[k] != 0 and pairs <= MAX_MODES:
            pairs *= 2
    return pairs


@kernel
def reduce_problem(sys, island, n_k, signs, forces):
    """The problem of an island without the friction rows of contacts that slide, for one choice of the bilateral
    signs; returns the number of its contacts."""
    work, slip, reduced, start = forces.work, forces.slip, forces.reduced, forces.reduced.start
    n = 0
    r = 0
    for k in range(n_k):
        if forces.island[k] != island:
            continue
        kind, d = sys.kinds[work.closed[k], 0], sys.kinds[work.closed[k], 1]
        forces.sigma[k] = 1
        is_sliding = slip[k] != 0
        if is_sliding and kind == BILATERAL:
            forces.sigma[k] = 1 - 2 * (signs & 1)
            signs >>= 1
        if is_sliding and kind == GIVEN_FORCE:
            continue
        reduced.place[n], start[n] = k, r
        reduced.kinds[n, 0], reduced.kinds[n, 1] = kind, 0 if is_sliding else d
        reduced.mu[n], reduced.mu_static[n] = forces.mu[k], forces.mu_static[k]
        reduced.normal_impulse[n] = forces.normal[k]
        reduced.slip[n] = forces.sigma[k] if is_sliding and kind == BILATERAL else 0
        for row in range(work.start[k], work.start[k] + forces.held[k]):
            reduced.row[r] = row
            r += 1
        n += 1
    reduced.n, reduced.r, start[n] = n, r, r
    for a in range(r):
        reduce_row(sys, a, n_k, forces)
    return n


@kernel
def reduce_row(sys, a, n_k, forces):
    """Row a of the reduced problem."""
    work, slip, reduced, start, row = forces.work, forces.slip, forces.reduced, forces.reduced.start, forces.reduced.row
    reduced.c[a] = reduced_free(sys, n_k, row[a], forces)
    for m in range(reduced.n):
        k = reduced.place[m]
        for e in range(start[m], start[m + 1]):
            reduced.G[a, e] = forces.K[a, e] = work.G[row[a], row[e]]
        if slip[k] != 0:
            f = -slip[k] * forces.mu[k] * forces.sigma[k]
            if sys.kinds[work.closed[k], 1] > 0:
                reduced.G[a, start[m]] += f * work.G[row[a], work.start[k] + 1]


@kernel
def reduced_free(sys, n_k, row, forces):
    """Free acceleration of a row, with the friction of contacts that slide under a given normal force."""
    work = forces.work
    total = work.c[row]
    for k in range(n_k):
        if forces.slip[k] != 0 and sys.kinds[work.closed[k], 0] == GIVEN_FORCE:
            total -= work.G[row, work.start[k]] * forces.slip[k] * forces.mu[k] * forces.normal[k]
    return total


@kernel
def names_slide(k, a, la_N, scale, forces):
    """Whether the sign tried names the slide of bilateral contact k: without force either does, and one with D > 0 is
    taken."""
    reduced = forces.reduced
    row = reduced.start[a]
    G_NN, D = forces.K[row, row], reduced.G[row, row]
    if abs(la_N) * G_NN > BORDER_WIDTH * scale:
        return True
    return D > 0.0 and (forces.sigma[k] > 0 or D >= 2.0 * G_NN)


@kernel
def moves_alike(one, other, island, n_k, scale, forces):
    """Whether two sets of forces of an island cause one motion."""
    work, la = forces.work, forces.la
    for k in range(n_k):
        if forces.island[k] != island:
            continue
        for row in range(work.start[k], work.start[k + 1]):
            change = 0.0
            for m in range(n_k):
                if forces.island[m] == island:
                    for e in range(work.start[m], work.start[m + 1]):
                        change += work.G[row, e] * (la[one, e] - la[other, e])
            if abs(change) > SAME_MOTION * scale:
                return False
    return True


@kernel
def keep_solution(sys, island, n_k, m, found, forces):
    """Write solution m of the reduced problem among those found of its island; 0 where it moves as another does, with
    forces of other signs, else 1."""
    work, tree, slip, sigma, reduced = forces.work, forces.planar.tree, forces.slip, forces.sigma, forces.reduced
    scale = largest_velocity(reduced)
    for a in range(reduced.n):
        k = reduced.place[a]
        if slip[k] != 0 and sys.kinds[work.closed[k], 0] == BILATERAL:
            if not names_slide(k, a, tree.solutions[m, reduced.start[a]], scale, forces):
                return 0
    if found >= forces.la.shape[0]:
        return 1
    la, candidate = forces.la, forces.candidate
    for k in range(n_k):
        if forces.island[k] != island:
            continue
        candidate[found, k] = SLIDE_PLUS if slip[k] > 0 else SLIDE_MINUS
        if slip[k] != 0:  # a given normal force, unless overwritten below
            la[found, work.start[k]] = -slip[k] * forces.mu[k] * forces.normal[k]
    for a in range(reduced.n):
        k = reduced.place[a]
        first = reduced.start[a]
        mode = tree.modes[m, a]
        for e in range(first, reduced.start[a + 1]):
            la[found, reduced.row[e]] = tree.solutions[m, e]
        if slip[k] != 0:
            la[found, work.start[k] + 1] = -slip[k] * forces.mu[k] * sigma[k] * tree.solutions[m, first]
            if mode == STICK:  # a closed contact with one row
                mode = SLIDE_PLUS if slip[k] > 0 else SLIDE_MINUS
                if sigma[k] < 0:
                    mode = PULL_PLUS if slip[k] > 0 else PULL_MINUS
            else:
                mode = FREE
        candidate[found, k] = mode
    for other in range(found):
        if moves_alike(found, other, island, n_k, scale, forces):
            return 0
    return 1
