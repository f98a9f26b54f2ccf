"""Every solution of a planar contact problem, by its modes.

Each contact is given a mode: FREE; STICK; SLIDE with its signs; LOCKED (closed without friction). A mode makes the
impulses of its contact an affine function of those of the contacts after it,

    P_i = alpha_i + sum_{j > i} beta_ij P_j ,

which is eliminated from the remaining rows. The tree of modes is walked depth first, so that a leaf costs one small
elimination and one back-substitution instead of a factorisation. A leaf is a solution if it satisfies the inclusions.
Where a pivot vanishes (redundant contacts) the branch is cut and the answer says that it is not complete:
``redundant.py`` decides such branches. One contact that slides with D = 0 and b = 0 has any force, and is given none.
Contacts that share their friction row (reduction.py) are one group: the first of them that is not free takes the
friction of all, the others follow it and add their reach to its own.

All pivots of all branches are positive iff the determinants of all combinations are. The natural map of the problem is
piecewise linear, with one of these determinants on each piece; its degree is that of the problem without friction, 1.
So the least pivot, where it is positive, certifies that there is one solution whatever c.

Cost: up to 4^n leaves for unilateral contacts; 8 contacts take about 15 ms. Deciding whether a solution exists is
NP-complete, so a bound there must be. Sources: docs/theory/moreau_jean.md; Robinson, *Math. Oper. Res.* 17 (1992) 691
(coherent orientation).
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.contact.planar.selection import (
    FREE,
    NO_CANDIDATE,
    PULL_MINUS,
    SLIDE_PLUS,
    STICK,
    WORST_RANK,
    rank,
    sigma_of,
    slip_of,
)
from nonsmooth.contact.planar.single import BORDER_WIDTH, rule_for
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.mechanics.contact_problem import Problem
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL, ContactMode
from nonsmooth.numerics.dense import SINGULAR
from nonsmooth.numerics.rounding import rounded_sum

LOCKED = STICK  # code: a contact without friction that is closed: its only row is zero, as when it sticks
MAX_LEAVES = 70_000  # derived: 4^8 = 65536 planar unilateral contacts
MAX_SOLUTIONS = 32  # chosen: kept of a step; the number found is counted beyond it
LEAF_ROUNDINGS = 100  # chosen: of the terms of a velocity: a smaller one is zero, as where c = 0 and a given force acts
SAME_MOTION = 1e-9  # chosen: relative distance below which two solutions are one motion


class Tree(Block, kept=MAX_SOLUTIONS):
    """Arrays of the walk. n = contacts, r = rows."""

    S: Array[Floats, "n + 1", "r", "r"]  # reduced matrices, one a level
    s: Array[Floats, "n + 1", "r"]  # reduced right-hand sides
    alpha: Array[Floats, "r"]
    beta: Array[Floats, "r", "r"]
    candidate: Array[Ints, "n"]  # mode of each contact on the present branch
    P: Array[Floats, "r"]  # impulses of the present leaf
    gamma: Array[Floats, "r"]
    solutions: Array[Floats, "kept", "r"]  # impulses
    motions: Array[Floats, "kept", "r"]  # contact velocities
    modes: Array[Ints, "kept", "n"]
    inverse: Array[Floats, "r"]  # 1 / G_kk
    group: Array[Ints, "n"]  # 0, or 1 + the first contact with the same friction row
    nodes: int  # eliminations of the last walk
    least: float  # its least pivot, relative to the diagonal of G


@kernel
def next_candidate(kind, d, candidate):
    """The mode tried after ``candidate`` (NO_CANDIDATE first), or NO_CANDIDATE after the last."""
    candidate += 1
    if candidate == FREE and kind != UNILATERAL:
        candidate += 1
    last = STICK if d == 0 else PULL_MINUS if kind == BILATERAL else SLIDE_PLUS + 1
    return candidate if candidate <= last else NO_CANDIDATE


@kernel
def modes_of(k, kinds):
    """Number of modes of a contact."""
    kind, d = kinds[k, 0], kinds[k, 1]
    return (1 if d == 0 else 5 if kind == BILATERAL else 3) + (1 if kind == UNILATERAL else 0)


@kernel
def leaves(n, kinds, most):
    """Number of mode combinations of n contacts, at most ``most`` + 1."""
    total = 1
    for k in range(n):
        total *= modes_of(k, kinds)
        if total > most:
            return most + 1
    return total


@kernel
def leader(level, tree):
    """The contact before ``level`` on the branch that takes the friction of its group; -1 where there is none."""
    if tree.group[level] == 0:
        return -1
    for k in range(level):
        if tree.group[k] == tree.group[level] and tree.candidate[k] != FREE:
            return k
    return -1


@kernel
def eliminate(level, candidate, problem, tree):
    """Express the impulses of contact ``level`` and reduce the rows after it; False where the pivot vanishes."""
    S, s, alpha, beta, r = tree.S, tree.s, tree.alpha, tree.beta, problem.r
    kind, first, last = problem.kinds[level, 0], problem.start[level], problem.start[level + 1]
    tree.nodes += 1
    for k in range(first, last):
        alpha[k] = 0.0
        for m in range(k + 1, r):  # from the next row on: contacts listed before may have had other rows
            beta[k, m] = 0.0
    if candidate >= SLIDE_PLUS and kind == GIVEN_FORCE:
        alpha[first] = -slip_of(candidate) * problem.mu[level] * problem.normal_impulse[level]
    elif candidate >= SLIDE_PLUS:
        f = -slip_of(candidate) * problem.mu[level] * sigma_of(candidate)
        D = S[level, first, first] + f * S[level, first, first + 1]
        if not is_pivot(D * tree.inverse[first], 1.0, tree):
            return False
        alpha[first] = -s[level, first] / D
        alpha[first + 1] = f * alpha[first]
        for m in range(last, r):
            beta[first, m] = -S[level, first, m] / D
            beta[first + 1, m] = f * beta[first, m]
    elif candidate == STICK and (last - first == 1 or leader(level, tree) >= 0):
        if not is_pivot(S[level, first, first] * tree.inverse[first], 1.0, tree):
            return False
        alpha[first] = -s[level, first] / S[level, first, first]
        for m in range(last, r):
            beta[first, m] = -S[level, first, m] / S[level, first, first]
    elif candidate == STICK and not _stick_block(level, first, last, r, tree):
        return False
    for k in range(last, r):
        total = s[level, k]
        for j in range(first, last):
            total += S[level, k, j] * alpha[j]
        s[level + 1, k] = total
        for m in range(last, r):
            total = S[level, k, m]
            for j in range(first, last):
                total += S[level, k, j] * beta[j, m]
            S[level + 1, k, m] = total
    return True


@kernel
def is_pivot(relative, size, tree):
    """Whether a pivot, relative to the diagonal of G, is more than rounding of ``size``; the least one is noted."""
    tree.least = min(tree.least, relative)
    return abs(relative) > SINGULAR * size


@kernel
def _stick_block(level, a, last, r, tree):
    """alpha, beta of a sticking planar contact: both of its rows vanish."""
    S, s, alpha, beta = tree.S, tree.s, tree.alpha, tree.beta
    b = a + 1
    S_aa, S_bb = S[level, a, a], S[level, b, b]
    determinant = S_aa * S_bb - S[level, a, b] * S[level, b, a]
    inverse = tree.inverse
    left = max(abs(S_aa) * inverse[a], abs(S_bb) * inverse[b])  # of the diagonal, by the contacts before
    if not is_pivot(determinant * inverse[a] * inverse[b], left, tree):
        return False
    alpha[a] = (S[level, a, b] * s[level, b] - S_bb * s[level, a]) / determinant
    alpha[b] = (S[level, b, a] * s[level, a] - S_aa * s[level, b]) / determinant
    for m in range(last, r):
        beta[a, m] = (S[level, a, b] * S[level, b, m] - S_bb * S[level, a, m]) / determinant
        beta[b, m] = (S[level, b, a] * S[level, a, m] - S_aa * S[level, b, m]) / determinant
    return True


@kernel
def contradicts(level, candidate, d, first, scale, tree):
    """Whether the singular equations of the last contact have no solution at all: s is not in the range of S."""
    S, s = tree.S, tree.s
    slack = SAME_MOTION * scale
    if d == 0 or candidate >= SLIDE_PLUS:
        return abs(s[level, first]) > slack
    a, b = first, first + 1
    largest = max(abs(S[level, a, a]), abs(S[level, b, a]))
    return abs(S[level, a, a] * s[level, b] - S[level, b, a] * s[level, a]) > slack * largest


@kernel
def pushes(k, small, problem, tree):
    """Whether the impulses of contact k satisfy its inclusions, up to rounding; those of the contacts after it are
    known."""
    candidate, kind, start = tree.candidate[k], problem.kinds[k, 0], problem.start
    if candidate == FREE:
        return True
    P_N = problem.normal_impulse[k] if kind == GIVEN_FORCE else tree.P[start[k]]
    if problem.kinds[k, 1] == 0:
        if kind == BILATERAL:  # one that slides has no friction row left, but a sign (contact/planar/forces.py)
            return problem.slip[k] * P_N >= -small
        return P_N >= -small
    if candidate == STICK:
        reach = abs(P_N) if kind == BILATERAL else P_N
        others = reach_of_others(k, problem, tree)
        return reach >= -small and abs(tree.P[start[k + 1] - 1]) <= problem.mu_static[k] * reach + others + small
    if kind == BILATERAL and abs(P_N) <= small:  # a slide without load is one motion, whatever the sign of P_N
        return slope(candidate, k, problem) > 0.0
    return sigma_of(candidate) * P_N >= -small and (P_N != 0.0 or kind == GIVEN_FORCE)


@kernel
def slope(candidate, k, problem):
    """D = G_NN - s mu sigma G_NF of a contact that slides, the others held."""
    a = problem.start[k]
    return problem.G[a, a] - slip_of(candidate) * problem.mu[k] * sigma_of(candidate) * problem.G[a, a + 1]


@kernel
def reach_of_others(k, problem, tree):
    """The friction that the contacts after k in its group add to what it can take itself."""
    if tree.group[k] == 0:
        return 0.0
    total = 0.0
    for m in range(k + 1, problem.n):
        if tree.group[m] == tree.group[k] and tree.candidate[m] == STICK:
            total += problem.mu_static[m] * tree.P[problem.start[m]]
    return total


@kernel
def back_substitute(small, problem, tree):
    """Impulses of the present leaf, of the last contact first; False as soon as one does not satisfy its inclusions."""
    start, P = problem.start, tree.P
    for k in range(problem.n - 1, -1, -1):
        for row in range(start[k + 1] - 1, start[k] - 1, -1):
            total = tree.alpha[row]
            for m in range(start[k + 1], problem.r):
                total += tree.beta[row, m] * P[m]
            P[row] = total
        if not pushes(k, small, problem, tree):
            return False
    return True


@kernel
def moves(slack, problem, tree):
    """Velocities gamma = G P + c of the present leaf; False as soon as one does not satisfy the inclusions."""
    start, G, gamma = problem.start, problem.G, tree.gamma
    for k in range(problem.n):
        for row in range(start[k], start[k + 1]):
            total, size = problem.c[row], abs(problem.c[row])
            for m in range(problem.r):
                total += G[row, m] * tree.P[m]
                size += abs(G[row, m] * tree.P[m])
            gamma[row] = total if abs(total) > rounded_sum(LEAF_ROUNDINGS, size) else 0.0
        candidate = tree.candidate[k]
        if candidate == FREE and not gamma[start[k]] >= -slack:
            return False
        if candidate >= SLIDE_PLUS and not slip_of(candidate) * gamma[start[k + 1] - 1] >= -slack:
            return False
    return True


@kernel("Tuple((int64, boolean))(int64, int64)", short_loops=True)
def enumerate_modes(problem_at, tree_at):
    """All solutions: their number, and whether the enumeration is complete (no pivot vanished)."""
    problem, tree = view(problem_at, Problem), view(tree_at, Tree)
    n, r, kinds, start = problem.n, problem.r, problem.kinds, problem.start
    scale, largest = begin_tree(problem, tree)
    impulse_scale = scale / largest if largest > 0.0 else 0.0
    found = 0
    is_complete = True
    level = 0
    while level >= 0:
        candidate = next_candidate(kinds[level, 0], kinds[level, 1], tree.candidate[level])
        tree.candidate[level] = candidate
        if candidate == NO_CANDIDATE:
            level -= 1
            continue
        first = leader(level, tree)
        if first >= 0 and candidate != FREE and candidate != tree.candidate[first]:
            continue  # contacts that share their friction row stick or slide together
        if not eliminate(level, candidate, problem, tree):
            if level == n - 1 and contradicts(level, candidate, kinds[level, 1], start[level], scale, tree):
                continue
            if n > 1 or (candidate == STICK and kinds[0, 1] > 0):
                is_complete = False
                continue
        if level < n - 1:
            level += 1
            tree.candidate[level] = NO_CANDIDATE
            continue
        if (
            back_substitute(BORDER_WIDTH * impulse_scale, problem, tree)
            and moves(BORDER_WIDTH * scale, problem, tree)
            and is_new(found, r, scale, tree)
        ):
            keep_solution(found, n, r, tree)
            found += 1
    return found, is_complete


@kernel
def begin_tree(problem, tree):
    """The root of the tree: (max |c|, max |G_km|)."""
    scale = 0.0
    largest = 0.0
    for k in range(problem.r):
        scale = max(scale, abs(problem.c[k]))
        tree.s[0, k], tree.inverse[k] = problem.c[k], 1.0 / problem.G[k, k]
        for m in range(problem.r):
            tree.S[0, k, m] = problem.G[k, m]
            largest = max(largest, abs(problem.G[k, m]))
    tree.candidate[0] = NO_CANDIDATE
    tree.nodes, tree.least = 0, math.inf
    return scale, largest


@kernel
def keep_solution(found, n, r, tree):
    """Keep the present leaf as solution number ``found``, if there is room."""
    if found < tree.modes.shape[0]:
        for k in range(r):
            tree.solutions[found, k] = tree.P[k]
            tree.motions[found, k] = tree.gamma[k]
        for k in range(n):
            tree.modes[found, k] = tree.candidate[k]


@kernel
def is_new(found, r, scale, tree):
    """Whether the present leaf moves otherwise than every solution kept of those found before."""
    for m in range(min(found, tree.modes.shape[0])):
        distance = 0.0
        for k in range(r):
            distance = max(distance, abs(tree.motions[m, k] - tree.gamma[k]))
        if distance <= SAME_MOTION * scale:
            return False
    return True


@kernel
def select(found, problem, tree):
    """The solution taken: that with the largest sum of the ranks of its contacts with friction (``selection``)."""
    best, taken = WORST_RANK, -1
    for m in range(min(found, MAX_SOLUTIONS)):
        total = 0
        for k in range(problem.n):
            if problem.kinds[k, 1] > 0:
                total += rank_of(tree.modes[m, k], k, problem)
        if total > best:
            best, taken = total, m
    return taken


@kernel
def rank_of(candidate, k, problem):
    """What contact k adds to the rank of a solution."""
    a, kind, was_stuck = problem.start[k], problem.kinds[k, 0], problem.mode[k] == ContactMode.STICK
    is_saddle, is_regular = False, True
    if kind != GIVEN_FORCE:
        is_saddle = not slope(candidate, k, problem) > 0.0
        is_regular = problem.G[a, a] > problem.mu[k] * abs(problem.G[a, a + 1])
    return rank(candidate, is_saddle, was_stuck, is_regular, rule_for(kind, problem.selection))
