"""The contact problem of several planar contacts: its residual, the names of its modes, what is solved in.

    gamma = G P + c,    per contact (N, T), N alone without friction, T alone for a given normal force

A solution satisfies, with R = mu |P_N| (mu_s where it sticks),

    0 <= P_N _|_ gamma_N >= 0  (gamma_N = 0 for a bilateral contact),    P_F = proj_[-R, R](P_F - gamma_F / G_FF).

Friction that vanishes with the speed opposes the velocity in the middle of the step, at which its mu is taken, in the
place of gamma_F: against gamma_F it would jump where that changes its sign, with nothing that sticks between.

What is left of these may be rounding. Summed in any order the r products of a row and c give, for a unit roundoff u,

    |fl(gamma_k) - gamma_k| <= (r + 1) u s_k + O(u^2),    s_k = sum_m |G_km| |P_m| + |c_k|,

and a violation v_k <= (r + 1) u s_k is removed by changes of G and c below (r + 1) u of each of their entries, which
are rounded themselves. P then solves a problem that cannot be told from the given one. So v is accepted up to
ACCEPTED_RESIDUAL max |c|, and up to (r + 1) u s_k where that is more: where impulses times G are 1e6 times what they
change, as under a heavy body on a light one. A violation above HALF_THE_DIGITS max |c| is not put down to rounding,
however large the impulses: a contact that is jammed has no solution with impulses of 1e15.

Sources: Jean, *Comput. Methods Appl. Mech. Engrg.* 177 (1999) 235; Oettli, Prager, *Numer. Math.* 6 (1964) 405; Higham,
*Accuracy and Stability of Numerical Algorithms* (2002), sections 3.1 and 7.1.
Equations: docs/theory/moreau_jean.md, (9).
"""

from __future__ import annotations

import math
from typing import Annotated as Array

import numpy as np

from nonsmooth.contact.planar.energetic import Springs
from nonsmooth.contact.planar.enumerate import MAX_SOLUTIONS, Tree
from nonsmooth.contact.planar.single import FREE, PULL_MINUS, PULL_PLUS, SLIDE_MINUS, SLIDE_PLUS, STICK
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, new
from nonsmooth.mechanics.contact_problem import Problem
from nonsmooth.mechanics.laws import can_stick, copy_friction, depends_on_speed, friction_coefficient
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL
from nonsmooth.numerics.rounding import rounded_sum

ACCEPTED_RESIDUAL = 1e-9  # chosen: largest relative residual of an accepted solution
HALF_THE_DIGITS = 1e-8  # chosen: of max |c|: no violation beyond this is put down to rounding
MU_ROUNDINGS = 90  # chosen: a friction coefficient that changes by less has found its speed
MERITS = 4  # chosen: of ``newton``: what a step may rise to


class Family(Block):
    """Arrays of the impulses that are possible with given modes. r = rows, m <= r unknowns, e inequalities."""

    B: Array[Floats, "r", "r + 1"]
    column: Array[Ints, "r"]  # unknown in each column of B
    row: Array[Ints, "r"]  # row of each unknown
    first: Array[Ints, "n + 1"]  # first unknown of each contact
    x: Array[Floats, "r"]
    y: Array[Floats, "r"]
    H: Array[Floats, "r", "r"]
    L: Array[Floats, "r", "r"]
    C: Array[Floats, "3 * n", "r"]
    e: Array[Floats, "3 * n"]
    A: Array[Floats, "3 * n", "r"]
    AH: Array[Floats, "3 * n", "r"]
    slack: Array[Floats, "3 * n"]  # what rounding leaves of an inequality


class Part(Problem):
    """A problem of some of the contacts of another: an island, or what a census looks at."""

    place: Array[Ints, "n_c"]  # of each contact in the other
    row: Array[Ints, "r"]  # of each row


class Memory(Block):
    """The last census of each contact, by its number in the system: a problem and what was found. c = contacts."""

    stamp: Array[Ints, "n"]  # number of the census; the contacts of one problem have the same
    members: Array[Ints, "n"]  # how many these are; 0 before the first census
    found: Array[Ints, "n"]  # solutions
    candidate: Array[Ints, "n"]  # mode taken
    role: Array[Ints, "n"]  # its part in the census
    least: Array[Floats, "n"]  # least pivot
    G: Array[Floats, "r", "r"]  # in the rows of all contacts of the system
    c: Array[Floats, "r"]
    mu: Array[Floats, "n"]
    normal_impulse: Array[Floats, "n"]
    told: Array[Ints, "n"]  # solutions of the last problem that were reported, 0 where they were not counted
    is_shared: Array[Ints, "n"]  # whether the impulses of the last problem were one share of many
    last: int  # number of the last census
    debt: int  # work of the censuses taken that is not paid off yet


class Planar(
    Block,
    kept=MAX_SOLUTIONS,
    m="3 * n if n > 1 else 1",
    r="n * (1 + d) if n > 1 else 1",
    levels="min(n, 18) if n > 1 else 1",
):
    """Arrays of the several-contact solvers. n = contacts, r = rows, m = unknowns of the LCP."""

    A: Array[Floats, "m", "m"]
    b: Array[Floats, "m"]
    z: Array[Floats, "m"]
    tableau: Array[Floats, "m", "m + 2"]
    scales: Array[Floats, 4, "m + 2"]
    basis: Array[Ints, "4 * m + 2"]
    unknown: Array[Ints, "r"]  # the rows whose impulses are unknown, modes given
    order: Array[Ints, "r"]  # row order of LU factors
    gamma: Array[Floats, "r"]
    error: float  # the last residual
    pivots: int
    best: Array[Floats, "r"]  # impulses with the least merit of ``newton``
    trial: Array[Floats, "r"]
    step: Array[Floats, "r"]
    merits: Array[Floats, MERITS]  # the last ones
    can_decide_redundant: int  # 1 once ``redundant.enumerate_redundant`` is loaded
    has_newton: int  # 1 once ``newton.solve_by_newton`` is loaded
    may_wait: int  # 1 where a census may be put off (census.py)
    stays: Array[Ints, "n"]  # whether a census looks at a contact
    island: Array[Ints, "n"]  # number of the island of each contact
    members: Array[Ints, "n"]  # number of contacts in the island of each contact
    found: Array[Ints, "n"]  # number of solutions of the island of each contact
    bits: Array[Ints, "n"]  # admissible candidates of a contact that is alone in its island, else 0
    is_counted: int  # whether the solutions of the last problem were counted, or certified to be one
    is_shared: int  # whether the impulses of the last problem are one share of many
    part: Array[Part, "n_c = n"]  # an island
    rest: Array[Part, "n_c = n"]  # what a census looks at
    memory: Memory
    tree: Array[Tree, "n = levels", "r = min(r, 2 * levels)", "kept = kept"]
    family: Array[Family, "n = levels", "r = min(r, 2 * levels)"]
    springs: Springs  # of an impact of several


def problem_of(kinds: Ints, G: Floats, c: Floats, mu: Floats, mu_static: Floats) -> Problem:
    """The problem of n contacts from plain arrays: ``kinds`` (n, 2), the others by contact or by row."""
    problem = new(Problem, n_c=len(kinds), d=1, r=len(c))
    problem.n, problem.r = len(kinds), len(c)
    problem.closed[:] = np.arange(problem.n)
    problem.kinds[:], problem.G[:], problem.c[:] = kinds, G, c
    problem.start[1:] = np.cumsum(problem.kinds[:, 1] + (problem.kinds[:, 0] != GIVEN_FORCE))
    problem.mu[:], problem.mu_static[:] = mu, mu_static
    return problem


@kernel
def copy_part(m, problem, part):
    """Copy the problem of the m contacts in part.place."""
    r = 0
    for e in range(m):
        k = part.place[e]
        part.closed[e], part.start[e] = problem.closed[k], r
        part.kinds[e, 0], part.kinds[e, 1] = problem.kinds[k, 0], problem.kinds[k, 1]
        part.mu[e], part.mu_static[e] = problem.mu[k], problem.mu_static[k]
        part.normal_impulse[e] = problem.normal_impulse[k]
        part.mode[e], part.slip[e] = problem.mode[k], problem.slip[k]
        copy_friction(problem.laws, k, part.laws, e)
        for j in range(problem.previous_P.shape[1]):
            part.previous_P[e, j] = problem.previous_P[k, j]
        for row in range(problem.start[k], problem.start[k + 1]):
            part.row[r] = row
            r += 1
    part.n, part.r, part.start[m], part.selection = m, r, r, problem.selection
    for a in range(r):
        row = part.row[a]
        part.c[a], part.offset[a] = problem.c[row], problem.offset[row]
        for b in range(r):
            part.G[a, b] = problem.G[row, part.row[b]]


@kernel
def velocities(problem, planar):
    """gamma = G P + c to ``planar.gamma``; returns max |c|, the scale of all of them."""
    G, c, P, gamma = problem.G, problem.c, problem.P, planar.gamma
    scale = 0.0
    for k in range(problem.r):
        total = c[k]
        for m in range(problem.r):
            total += G[k, m] * P[m]
        gamma[k] = total
        scale = max(scale, abs(c[k]))
    return scale


@kernel
def largest_velocity(problem):
    """max |c|, the scale of all velocities."""
    scale = 0.0
    for k in range(problem.r):
        scale = max(scale, abs(problem.c[k]))
    return scale


@kernel
def normal_impulse_of(k, problem):
    """P_N of contact k, that of the answer or the given one."""
    return problem.normal_impulse[k] if problem.kinds[k, 0] == GIVEN_FORCE else problem.P[problem.start[k]]


@kernel
def residual(problem, planar):
    """Largest violation of the inclusions, relative to max |c|; also left in ``planar.error``, the velocities in
    ``planar.gamma``.

    A violation that is rounding counts as ACCEPTED_RESIDUAL.
    Normal: |min(|G_NN| P_N, gamma_N)|. Tangential, by the projection on the disc of radius mu |P_N|:
    G_FF |P_F - proj(P_F - v / G_FF)|, v = gamma_F, or that of the middle of the step.
    """
    G, P, gamma = problem.G, problem.P, planar.gamma
    scale = velocities(problem, planar)
    worst = 0.0
    for k in range(problem.n):
        a = problem.start[k]
        t = problem.start[k + 1] - 1
        kind = problem.kinds[k, 0]
        P_N = normal_impulse_of(k, problem)
        if kind == UNILATERAL:
            worst = max(worst, beyond_rounding(abs(min(abs(G[a, a]) * P_N, gamma[a])), a, scale, problem))
        elif kind == BILATERAL:
            worst = max(worst, beyond_rounding(abs(gamma[a]), a, scale, problem))
        if problem.kinds[k, 1] > 0:
            has_static, v = can_stick(problem.laws, k), gamma[t]
            if not has_static:
                v = 0.5 * (problem.offset[t] + v)
            is_stuck = has_static and beyond_rounding(abs(v), t, scale, problem) <= ACCEPTED_RESIDUAL * scale
            reach = (problem.mu_static[k] if is_stuck else problem.mu[k]) * max(
                0.0, abs(P_N) if kind == BILATERAL else P_N
            )
            pulled = P[t] - v / G[t, t]
            violation = G[t, t] * abs(P[t] - max(-reach, min(reach, pulled)))
            worst = max(worst, beyond_rounding(violation, t, scale, problem))
    if not worst < np.inf:  # NaN
        worst = np.inf
    elif scale > 0.0:
        worst /= scale
    planar.error = worst
    return worst


@kernel
def beyond_rounding(violation, k, scale, problem):
    """The violation of row k, or ACCEPTED_RESIDUAL max |c| where it is more and rounding."""
    if violation <= ACCEPTED_RESIDUAL * scale or violation > HALF_THE_DIGITS * scale:
        return violation
    return ACCEPTED_RESIDUAL * scale if violation <= rounding_of(k, problem) else violation


@kernel
def rounding_of(k, problem):
    """(r + 1) u s_k, what the velocity of row k may be wrong by."""
    return rounded_sum(problem.r + 1, size_of_terms(k, problem))


@kernel
def size_of_terms(k, problem):
    """s_k = sum_m |G_km| |P_m| + |c_k|."""
    size = abs(problem.c[k])
    for m in range(problem.r):
        size += abs(problem.G[k, m] * problem.P[m])
    return size


@kernel
def is_zero(k, slack, scale, problem, planar):
    """Whether the velocity of row k is none: within ``slack`` of max |c|, or within its own rounding."""
    speed = abs(planar.gamma[k])
    return speed <= slack * scale or (speed <= HALF_THE_DIGITS * scale and speed <= rounding_of(k, problem))


@kernel
def name_modes(slack, problem, planar):
    """Name the modes by what the contacts do, from their impulses and velocities in ``planar.gamma``; always True.

    Open is a contact that parts; closed one with gamma_N = 0, whether it has an impulse or others carry its load. It
    slides where gamma_F is not zero, unless that is within what is accepted and the friction does not oppose it; else
    it sticks, also where its impulse lies on the border of the cone. So no mode hangs on how redundant contacts share a
    load, and none that moves is called at rest because its friction is lost in rounding.
    """
    P, gamma, scale = problem.P, planar.gamma, largest_velocity(problem)
    for k in range(problem.n):
        kind, a, t = problem.kinds[k, 0], problem.start[k], problem.start[k + 1] - 1
        P_N = normal_impulse_of(k, problem)
        opposing = -math.copysign(P[t], P[t] * gamma[t])
        parts = gamma[a] > abs(problem.G[a, a]) * P_N and not is_zero(a, slack, scale, problem, planar)
        if (kind == UNILATERAL and parts) or (kind == GIVEN_FORCE and P_N == 0.0):
            problem.candidate[k] = FREE
        elif problem.kinds[k, 1] == 0 or is_zero(t, slack, scale, problem, planar):
            problem.candidate[k] = STICK
        elif abs(gamma[t]) <= ACCEPTED_RESIDUAL * scale and opposing < problem.mu[k] * abs(P_N) * (
            1.0 - ACCEPTED_RESIDUAL
        ):
            problem.candidate[k] = STICK
        else:
            problem.candidate[k] = sliding_candidate(gamma[t] > 0.0, P_N < 0.0)
    return True


@kernel
def sliding_candidate(is_forward, is_pulled):
    """The candidate of a sliding contact from the signs of gamma_F and P_N."""
    if is_pulled:
        return PULL_PLUS if is_forward else PULL_MINUS
    return SLIDE_PLUS if is_forward else SLIDE_MINUS


@kernel
def has_varying_friction(problem):
    """Set mu from the velocities before the step; True if any law depends on the speed."""
    varies = False
    for k in range(problem.n):
        speed = abs(problem.offset[problem.start[k + 1] - 1]) if problem.kinds[k, 1] > 0 else 0.0
        problem.mu[k] = friction_coefficient(problem.laws, k, speed)
        varies = varies or depends_on_speed(problem.laws, k)
    return varies


@kernel
def update_friction(problem, planar):
    """Take mu at the speed in the middle of the step; True while it still changes."""
    changed = False
    for k in range(problem.n):
        t = problem.start[k + 1] - 1
        if problem.kinds[k, 1] > 0 and depends_on_speed(problem.laws, k):
            mu = friction_coefficient(problem.laws, k, 0.5 * abs(problem.offset[t] + planar.gamma[t]))
            changed = changed or abs(mu - problem.mu[k]) > rounded_sum(MU_ROUNDINGS, abs(mu))
            problem.mu[k] = mu
    return changed
