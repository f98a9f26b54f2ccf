"""The contact problem of several planar contacts: its arrays, its residual, the names of its modes.

    gamma = G P + c,    per contact (N, T), N alone without friction, T alone for a given normal force

A solution satisfies, with R = mu |P_N| (mu_s where it sticks),

    0 <= P_N _|_ gamma_N >= 0  (gamma_N = 0 for a bilateral contact),    P_F = proj_[-R, R](P_F - gamma_F / G_FF).

What is left of these may be rounding. Summed in any order the r products of a row and c give, for a unit roundoff u,

    |fl(gamma_k) - gamma_k| <= (r + 1) u s_k + O(u^2),    s_k = sum_m |G_km| |P_m| + |c_k|,

and a violation v_k <= (r + 1) u s_k is removed by changes of G and c below (r + 1) u of each of their entries, which
are rounded themselves. P then solves a problem that cannot be told from the given one. So v is accepted up to
ACCEPTED max |c|, and up to (r + 1) u s_k where that is more: where impulses times G are 1e6 times what they change, as
under a heavy body on a light one. A violation above HALF_THE_DIGITS max |c| is not put down to rounding, however large
the impulses: a contact that is jammed has no solution with impulses of 1e15.

Sources: Jean, *Comput. Methods Appl. Mech. Engrg.* 177 (1999) 235; Oettli, Prager, *Numer. Math.* 6 (1964) 405; Higham,
*Accuracy and Stability of Numerical Algorithms* (2002), sections 3.1 and 7.1.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

import numpy as np

from nonsmooth.contact.planar.enumerate import MAX_SOLUTIONS, Tree
from nonsmooth.contact.planar.single import FREE, PULL_MINUS, PULL_PLUS, SLIDE_MINUS, SLIDE_PLUS, STICK
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints
from nonsmooth.mechanics.laws import depends_on_speed, friction_coefficient
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL

ACCEPTED = 1e-9  # largest relative residual of an accepted solution
UNIT = 0.5 * float(np.finfo(float).eps)  # unit roundoff
HALF_THE_DIGITS = 1e-8  # of max |c|: no violation beyond this is put down to rounding
MERITS = 4  # of ``newton``: what a step may rise to


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


class Part(Block):
    """A problem of some of the contacts: an island, or what a census looks at. n = contacts, r = rows."""

    place: Array[Ints, "n"]  # of each contact among those it was taken from
    closed: Array[Ints, "n"]
    start: Array[Ints, "n + 1"]
    row: Array[Ints, "r"]  # of each row among those it was taken from
    G: Array[Floats, "r", "r"]
    c: Array[Floats, "r"]
    offset: Array[Floats, "r"]
    P: Array[Floats, "r"]
    mu: Array[Floats, "n"]
    mu_static: Array[Floats, "n"]
    normal_impulse: Array[Floats, "n"]
    was_stuck: Array[Ints, "n"]


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
    mu: Array[Floats, "n"]  # coefficient of sliding
    mu_static: Array[Floats, "n"]
    normal_impulse: Array[Floats, "n"]  # of contacts with a given normal force
    was_stuck: Array[Ints, "n"]  # 0 or 1
    candidate: Array[Ints, "n"]  # what was chosen
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
    given: Array[Floats, "n"]  # given normal impulses of all islands
    taken: Array[Ints, "n"]  # candidates of all islands
    stays: Array[Ints, "n"]  # whether a census looks at a contact
    island: Array[Ints, "n"]  # number of the island of each contact
    members: Array[Ints, "n"]  # number of contacts in the island of each contact
    found: Array[Ints, "n"]  # number of solutions of the island of each contact
    bits: Array[Ints, "n"]  # admissible candidates of a contact that is alone in its island, else 0
    is_counted: int  # whether the solutions of the last problem were counted, or certified to be one
    is_shared: int  # whether the impulses of the last problem are one share of many
    part: Part  # an island
    rest: Part  # what a census looks at
    memory: Memory
    tree: Array[Tree, "n = levels", "r = min(r, 2 * levels)", "kept = kept"]
    family: Array[Family, "n = levels", "r = min(r, 2 * levels)"]


@kernel
def velocities(r, G, c, P, gamma):
    """gamma = G P + c; returns max |c|, the scale of all of them."""
    scale = 0.0
    for k in range(r):
        total = c[k]
        for m in range(r):
            total += G[k, m] * P[m]
        gamma[k] = total
        scale = max(scale, abs(c[k]))
    return scale


@kernel
def residual(n, closed, start, kinds, G, c, P, planar):
    """Largest violation of the inclusions, relative to max |c|; also left in ``planar.error``, the velocities in
    ``planar.gamma``.

    A violation that is rounding counts as ACCEPTED.
    Normal: |min(|G_NN| P_N, gamma_N)|. Tangential, by the projection on the disc of radius mu |P_N|:
    G_FF |P_F - proj(P_F - gamma_F / G_FF)|.
    """
    r = start[n]
    scale = velocities(r, G, c, P, planar.gamma)
    worst = 0.0
    for k in range(n):
        i = closed[k]
        a = start[k]
        t = start[k + 1] - 1
        kind = kinds[i, 0]
        P_N = planar.normal_impulse[k] if kind == GIVEN_FORCE else P[a]
        if kind == UNILATERAL:
            worst = max(worst, beyond_rounding(abs(min(abs(G[a, a]) * P_N, planar.gamma[a])), a, r, scale, G, c, P))
        elif kind == BILATERAL:
            worst = max(worst, beyond_rounding(abs(planar.gamma[a]), a, r, scale, G, c, P))
        if kinds[i, 1] > 0:
            is_stuck = beyond_rounding(abs(planar.gamma[t]), t, r, scale, G, c, P) <= ACCEPTED * scale
            reach = (planar.mu_static[k] if is_stuck else planar.mu[k]) * max(
                0.0, abs(P_N) if kind == BILATERAL else P_N
            )
            pulled = P[t] - planar.gamma[t] / G[t, t]
            violation = G[t, t] * abs(P[t] - max(-reach, min(reach, pulled)))
            worst = max(worst, beyond_rounding(violation, t, r, scale, G, c, P))
    if not worst < np.inf:  # NaN
        worst = np.inf
    elif scale > 0.0:
        worst /= scale
    planar.error = worst
    return worst


@kernel
def beyond_rounding(violation, k, r, scale, G, c, P):
    """The violation of row k, or ACCEPTED max |c| where it is more and rounding."""
    if violation <= ACCEPTED * scale or violation > HALF_THE_DIGITS * scale:
        return violation
    return ACCEPTED * scale if violation <= rounding_of(k, r, G, c, P) else violation


@kernel
def rounding_of(k, r, G, c, P):
    """(r + 1) u s_k, what the velocity of row k may be wrong by."""
    size = abs(c[k])
    for m in range(r):
        size += abs(G[k, m] * P[m])
    return (r + 1) * UNIT * size


@kernel
def is_zero(k, slack, r, scale, G, c, P, planar):
    """Whether the velocity of row k is none: within ``slack`` of max |c|, or within its own rounding."""
    speed = abs(planar.gamma[k])
    return speed <= slack * scale or (speed <= HALF_THE_DIGITS * scale and speed <= rounding_of(k, r, G, c, P))


@kernel
def name_modes(slack, n, closed, start, kinds, G, c, P, planar):
    """Name the modes by what the contacts do, from their impulses and velocities in ``planar.gamma``; always True.

    Open is a contact that parts; closed one with gamma_N = 0, whether it has an impulse or others carry its load. It
    slides where gamma_F is not zero, unless that is within what is accepted and the friction does not oppose it; else
    it sticks, also where its impulse lies on the border of the cone. So no mode hangs on how redundant contacts share a
    load, and none that moves is called at rest because its friction is lost in rounding.
    """
    r = start[n]
    scale = 0.0
    for k in range(r):
        scale = max(scale, abs(c[k]))
    for k in range(n):
        kind, a, t = kinds[closed[k], 0], start[k], start[k + 1] - 1
        P_N = planar.normal_impulse[k] if kind == GIVEN_FORCE else P[a]
        opposing = -math.copysign(P[t], P[t] * planar.gamma[t])
        parts = planar.gamma[a] > abs(G[a, a]) * P_N and not is_zero(a, slack, r, scale, G, c, P, planar)
        if (kind == UNILATERAL and parts) or (kind == GIVEN_FORCE and P_N == 0.0):
            planar.candidate[k] = FREE
        elif kinds[closed[k], 1] == 0 or is_zero(t, slack, r, scale, G, c, P, planar):
            planar.candidate[k] = STICK
        elif abs(planar.gamma[t]) <= ACCEPTED * scale and opposing < planar.mu[k] * abs(P_N) * (1.0 - ACCEPTED):
            planar.candidate[k] = STICK
        else:
            planar.candidate[k] = sliding(planar.gamma[t] > 0.0, P_N < 0.0)
    return True


@kernel
def sliding(is_forward, is_pulled):
    """The candidate of a sliding contact from the signs of gamma_F and P_N."""
    if is_pulled:
        return PULL_PLUS if is_forward else PULL_MINUS
    return SLIDE_PLUS if is_forward else SLIDE_MINUS


@kernel
def has_varying_friction(n, closed, start, kinds, laws, offset, planar):
    """Set mu from the velocities before the step; True if any law depends on the speed."""
    varies = False
    for k in range(n):
        i = closed[k]
        t = start[k + 1] - 1
        speed = abs(offset[t]) if kinds[i, 1] > 0 else 0.0
        planar.mu[k] = friction_coefficient(laws, i, speed)
        varies = varies or depends_on_speed(laws, i)
    return varies


@kernel
def update_friction(n, closed, start, kinds, laws, offset, planar):
    """Take mu at the speed in the middle of the step; True while it still changes."""
    changed = False
    for k in range(n):
        i = closed[k]
        t = start[k + 1] - 1
        if kinds[i, 1] > 0 and depends_on_speed(laws, i):
            mu = friction_coefficient(laws, i, 0.5 * abs(offset[t] + planar.gamma[t]))
            changed = changed or abs(mu - planar.mu[k]) > 1e-14 * abs(mu)
            planar.mu[k] = mu
    return changed
