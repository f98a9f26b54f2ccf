"""Every set of contact forces that a state with friction in two directions admits.

    gamma' = G la + c

A contact that slides keeps its direction d for an instant: its tangential axes are turned until the first is d, and it
is a planar contact that slides forward, la_T = -mu la_N d. A contact at rest that G couples to no other has free,
stick, and the slides of its round cone (all_solutions.py). Islands of several contacts of which one rests are not
enumerated.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.contact.planar.forces import (
    FORCES_KEPT,
    MAX_CONTACTS,
    MOST_COUNTED,
    Forces,
    Outcome,
    find_forces_of,
    list_closed,
    list_islands,
    set_up_closed,
    sliding_speed,
)
from nonsmooth.contact.planar.single import FREE, SLIDE_MINUS, SLIDE_PLUS, STICK
from nonsmooth.contact.spatial.all_solutions import OneContact, list_solutions
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Floats, Ints, view
from nonsmooth.mechanics.situation import Situation
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import GIVEN_FORCE, UNILATERAL
from nonsmooth.numerics.dense import lu, lu_solve

MOST_BESIDE = 13  # chosen: contacts of an island of which one rests: 4096 sets of the others


class SpatialForces(Forces, most=MAX_CONTACTS, kept=FORCES_KEPT, c="max(1, n_c)", r="max(1, n_c * (1 + d))", n_q=0):
    """Arrays of the search for forces, with what two directions of friction need."""

    direction: Array[Floats, "c", 2]  # of sliding of each closed contact; 0 at rest
    one: OneContact
    beside: Array[Ints, "c"]  # the other contacts of the island of one that rests
    loaded: Array[Ints, "c"]  # those of them that a set has
    A: Array[Floats, "c", "c"]
    order: Array[Ints, "c"]
    b: Array[Floats, "c"]
    z: Array[Floats, 4, "c"]  # A^-1 times c_S and the columns of G_Sr


@kernel(
    "Tuple((int64, int64, int64, int64))(int64, float64, float64[::1], float64[::1], int64)",
    short_loops=True,
)
def forces_in_space(sys_at, t, q, u, forces_at):
    """All contact forces at a state: (outcome, solutions, closed contacts, rows). Rows of friction of a contact that
    slides are along its direction, and to the left of it."""
    sys, forces = view(sys_at, Sys), view(forces_at, SpatialForces)
    n_k = list_closed(sys, t, q, u, forces)
    if n_k < 0:
        return (Outcome.INADMISSIBLE if n_k == -1 else Outcome.NOT_FINITE).value, 0, 0, 0
    if n_k == 0:
        return Outcome.COMPLETE.value, 1, 0, 0
    is_finite, r = set_up_closed(sys, t, q, u, n_k, forces)
    if not is_finite:
        return Outcome.NOT_FINITE.value, 0, n_k, r
    for k in range(n_k):
        find_direction(sys, k, forces)
        if forces.slip[k] != 0 and sys.kinds[forces.work.closed[k], 1] == 2:
            turn_rows(forces.work.start[k + 1] - 2, r, forces.direction[k, 0], forces.direction[k, 1], forces.work)
    outcome, total = Outcome.COMPLETE.value, 1
    for island in range(list_islands(sys, n_k, forces)):
        forces.outcome[island], forces.number[island] = find_island(sys, island, n_k, forces)
        outcome = max(outcome, forces.outcome[island])
        total = min(MOST_COUNTED, total * forces.number[island])
    return outcome, total, n_k, r


@kernel
def find_direction(sys, k, forces):
    """slip and direction of a closed contact: 0 at rest, and slip = 1 along its slide with two directions."""
    i, gamma = forces.work.closed[k], forces.gamma
    forces.slip[k], forces.direction[k, 0], forces.direction[k, 1] = 0, 0.0, 0.0
    if forces.situation[i] == Situation.SLIDING:
        speed = sliding_speed(i, gamma)
        forces.direction[k, 0], forces.direction[k, 1] = gamma[i, 1] / speed, gamma[i, 2] / speed
        forces.slip[k] = -1 if sys.kinds[i, 1] == 1 and gamma[i, 1] < 0.0 else 1


@kernel
def turn_rows(a, r, d_1, d_2, work):
    """Rows a and a + 1 of the problem, and the columns of G, as the components along (d_1, d_2) and to the left."""
    W, X, G = work.W, work.X, work.G
    for j in range(W.shape[1]):
        W[a, j], W[a + 1, j] = d_1 * W[a, j] + d_2 * W[a + 1, j], d_1 * W[a + 1, j] - d_2 * W[a, j]
        X[a, j], X[a + 1, j] = d_1 * X[a, j] + d_2 * X[a + 1, j], d_1 * X[a + 1, j] - d_2 * X[a, j]
    for e in range(r):
        G[a, e], G[a + 1, e] = d_1 * G[a, e] + d_2 * G[a + 1, e], d_1 * G[a + 1, e] - d_2 * G[a, e]
    for e in range(r):
        G[e, a], G[e, a + 1] = d_1 * G[e, a] + d_2 * G[e, a + 1], d_1 * G[e, a + 1] - d_2 * G[e, a]
    for values in (work.c, work.gamma_0):
        values[a], values[a + 1] = d_1 * values[a] + d_2 * values[a + 1], d_1 * values[a + 1] - d_2 * values[a]


@kernel
def find_island(sys, island, n_k, forces):
    """Every solution of one island: (Outcome, number)."""
    members, resting, alone = 0, 0, 0
    for k in range(n_k):
        if forces.island[k] != island:
            continue
        i, members = forces.work.closed[k], members + 1
        if sys.kinds[i, 1] == 2:
            clear_left(k, forces)
            if forces.slip[k] == 0:
                resting, alone = resting + 1, k
    if resting == 0:
        return find_forces_of(sys, island, n_k, forces)
    if sys.kinds[forces.work.closed[alone], 0] == GIVEN_FORCE:
        return Outcome.TOO_MANY.value, 0
    if members == 1:
        return Outcome.COMPLETE.value, answer_of_one(alone, forces)
    if not list_beside(sys, alone, members, n_k, forces):
        return Outcome.TOO_MANY.value, 0
    return answers_among(alone, members - 1, forces)


@kernel
def list_beside(sys, k, members, n_k, forces):
    """List the others of the island of contact k; False where one of them rests, is bilateral or has a given force, or
    where they are too many."""
    m = 0
    for other in range(n_k):
        if other == k or forces.island[other] != forces.island[k]:
            continue
        i = forces.work.closed[other]
        if sys.kinds[i, 0] != UNILATERAL or (sys.kinds[i, 1] > 0 and forces.slip[other] == 0):
            return False
        forces.beside[m] = other
        m += 1
    return members <= MOST_BESIDE


@kernel
def answers_among(k, n, forces):
    """The solutions of contact k, which rests, for every set of the n contacts beside it: (Outcome, number)."""
    found, outcome = 0, Outcome.COMPLETE.value
    for loaded in range(1 << n):
        m = 0
        for e in range(n):
            if loaded >> e & 1:
                forces.loaded[m] = forces.beside[e]
                m += 1
        if not reduce_to_one(k, m, forces):
            outcome = Outcome.SINGULAR.value
            continue
        one = forces.one
        for answer in range(list_solutions(one.G, 0, one.c, one.mu, one.mu_static, one)):
            if is_answer(k, n, m, loaded, answer, forces):
                keep_answer(k, n, m, answer, found, forces)
                found += 1
    return outcome, found


@kernel
def column(row, f, forces):
    """Entry of G of a row for a unit of la_N of contact f, with its friction."""
    work, a = forces.work, forces.work.start[f]
    if work.start[f + 1] == a + 1:
        return work.G[row, a]
    return work.G[row, a] - forces.slip[f] * forces.mu[f] * work.G[row, a + 1]


@kernel
def reduce_to_one(k, m, forces):
    """G and c of contact k while the m loaded contacts slide closed, to ``one``; False where A is singular."""
    work, one, A, z, first = forces.work, forces.one, forces.A, forces.z, forces.work.start[k]
    one.mu, one.mu_static = forces.mu[k], forces.mu_static[k]
    for e in range(m):
        for f in range(m):
            A[e, f] = column(work.start[forces.loaded[e]], forces.loaded[f], forces)
    if m > 0 and not lu(m, A, forces.order):
        return False
    for part in range(4):
        for e in range(m):
            row = work.start[forces.loaded[e]]
            forces.b[e] = work.c[row] if part == 0 else work.G[row, first + part - 1]
        if m > 0:
            lu_solve(m, A, forces.order, forces.b, z[part])
    for a in range(3):
        one.c[a] = work.c[first + a]
        for b in range(3):
            one.G[0, a, b] = work.G[first + a, first + b]
        for f in range(m):
            by = column(first + a, forces.loaded[f], forces)
            one.c[a] -= by * z[0, f]
            for b in range(3):
                one.G[0, a, b] -= by * z[1 + b, f]
    return True


@kernel
def is_answer(k, n, m, loaded, answer, forces):
    """Whether the loaded contacts press, and the others beside contact k open; the la_N of these are left in ``b``."""
    work, P, z, first = forces.work, forces.one.P, forces.z, forces.work.start[k]
    for f in range(m):
        forces.b[f] = -z[0, f]
        for part in range(3):
            forces.b[f] -= z[1 + part, f] * P[answer, part]
        if not forces.b[f] > 0.0:
            return False
    for e in range(n):
        if loaded >> e & 1 == 0:
            row = work.start[forces.beside[e]]
            gamma = work.c[row]
            for part in range(3):
                gamma += work.G[row, first + part] * P[answer, part]
            for f in range(m):
                gamma += column(row, forces.loaded[f], forces) * forces.b[f]
            if not gamma >= 0.0:
                return False
    return True


@kernel
def keep_answer(k, n, m, answer, found, forces):
    """Write a solution among those of the island, where there is room for it."""
    work, first, la, candidate = forces.work, forces.work.start[k], forces.la, forces.candidate
    if found >= la.shape[0]:
        return
    candidate[found, k] = forces.one.modes[answer]
    for part in range(3):
        la[found, first + part] = forces.one.P[answer, part]
    for e in range(n):
        other = forces.beside[e]
        candidate[found, other] = FREE
        for a in range(work.start[other], work.start[other + 1]):
            la[found, a] = 0.0
    for f in range(m):
        other = forces.loaded[f]
        a = work.start[other]
        la[found, a] = forces.b[f]
        if work.start[other + 1] == a + 1:
            candidate[found, other] = STICK
            continue
        candidate[found, other] = SLIDE_PLUS if forces.slip[other] > 0 else SLIDE_MINUS
        la[found, a + 1] = -forces.slip[other] * forces.mu[other] * forces.b[f]


@kernel
def clear_left(k, forces):
    """No friction to the left of a slide."""
    for m in range(forces.la.shape[0]):
        forces.la[m, forces.work.start[k + 1] - 1] = 0.0


@kernel
def answer_of_one(k, forces):
    """The solutions of a contact that rests alone; their number."""
    one, work, first = forces.one, forces.work, forces.work.start[k]
    one.mu, one.mu_static = forces.mu[k], forces.mu_static[k]
    for a in range(3):
        one.c[a] = work.c[first + a]
        for b in range(3):
            one.G[0, a, b] = work.G[first + a, first + b]
    found = list_solutions(one.G, 0, one.c, one.mu, one.mu_static, one)
    for m in range(min(found, forces.la.shape[0])):
        forces.candidate[m, k] = one.modes[m]
        for a in range(3):
            forces.la[m, first + a] = one.P[m, a]
    return found
