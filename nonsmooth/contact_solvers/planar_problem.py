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
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.blocks import Integers, Matrix, Vector
from nonsmooth.contact_solvers.modes import MAX_SOLUTIONS, Tree, tree_shapes
from nonsmooth.contact_solvers.single import FREE, PULL_MINUS, PULL_PLUS, SLIDE_MINUS, SLIDE_PLUS, STICK
from nonsmooth.jit import kernel
from nonsmooth.laws import depends_on_speed, friction_coefficient
from nonsmooth.system import BILATERAL, GIVEN_FORCE, UNILATERAL

ACCEPTED = 1e-9  # largest relative residual of an accepted solution
UNIT = 0.5 * float(np.finfo(float).eps)  # unit roundoff
HALF_THE_DIGITS = 1e-8  # of max |c|: no violation beyond this is put down to rounding
MERITS = 4  # of ``planar_newton``: what a step may rise to


class Family(NamedTuple):
    """Arrays of the impulses that are possible with given modes. r = rows, m <= r unknowns, e inequalities."""

    B: Matrix  # (r, r + 1)
    column: Integers  # (r,) unknown in each column of B
    row: Integers  # (r,) row of each unknown
    first: Integers  # (n + 1,) first unknown of each contact
    x: Vector  # (r,)
    y: Vector  # (r,)
    H: Matrix  # (r, r)
    L: Matrix  # (r, r)
    C: Matrix  # (e, r)
    e: Vector  # (e,)
    A: Matrix  # (e, r)
    AH: Matrix  # (e, r)
    slack: Vector  # (e,) what rounding leaves of an inequality


def family_shapes(n: int, r: int) -> dict[str, tuple[int, ...]]:
    """Shapes of ``Family`` for n contacts with r rows; a contact has up to three inequalities."""
    return {
        "B": (r, r + 1), "column": (r,), "row": (r,), "first": (n + 1,), "x": (r,), "y": (r,), "H": (r, r),
        "L": (r, r), "C": (3 * n, r), "e": (3 * n,), "A": (3 * n, r), "AH": (3 * n, r), "slack": (3 * n,),
    }  # fmt: skip


class Part(NamedTuple):
    """A problem of some of the contacts: an island, or what a census looks at. n = contacts, r = rows."""

    place: Integers  # (n,) of each contact among those it was taken from
    closed: Integers  # (n,)
    start: Integers  # (n + 1,)
    row: Integers  # (r,) of each row among those it was taken from
    G: Matrix  # (r, r)
    c: Vector  # (r,)
    offset: Vector  # (r,)
    P: Vector  # (r,)
    mu: Vector  # (n,)
    mu_static: Vector  # (n,)
    normal_impulse: Vector  # (n,)
    was_stuck: Integers  # (n,)


def part_shapes(n: int, r: int) -> dict[str, tuple[int, ...]]:
    """Shapes of ``Part`` for up to n contacts with r rows."""
    return {
        **dict.fromkeys(("place", "closed", "mu", "mu_static", "normal_impulse", "was_stuck"), (n,)),
        **dict.fromkeys(("row", "c", "offset", "P"), (r,)), "start": (n + 1,), "G": (r, r),
    }  # fmt: skip


class Memory(NamedTuple):
    """The last census of each contact, by its number in the system: a problem and what was found. c = contacts."""

    stamp: Integers  # (c,) number of the census; the contacts of one problem have the same
    members: Integers  # (c,) how many these are; 0 before the first census
    found: Integers  # (c,) solutions
    candidate: Integers  # (c,) mode taken
    role: Integers  # (c,) its part in the census
    least: Vector  # (c,) least pivot
    G: Matrix  # (r, r) in the rows of all contacts of the system
    c: Vector  # (r,)
    mu: Vector  # (c,)
    normal_impulse: Vector  # (c,)
    told: Integers  # (c,) solutions of the last problem that were reported, 0 where they were not counted
    is_shared: Integers  # (c,) whether the impulses of the last problem were one share of many
    last: Integers  # (1,) number of the last census
    debt: Integers  # (1,) work of the censuses taken that is not paid off yet


def memory_shapes(n: int, r: int) -> dict[str, tuple[int, ...]]:
    """Shapes of ``Memory`` for a system of n contacts with r rows."""
    return {
        **dict.fromkeys(
            ("stamp", "members", "found", "candidate", "role", "least", "mu", "normal_impulse", "told", "is_shared"),
            (n,),
        ),
        "G": (r, r), "c": (r,), "last": (1,), "debt": (1,),
    }  # fmt: skip


class Planar(NamedTuple):
    """Arrays of the several-contact solvers. n = contacts, r = rows, m = unknowns of the LCP."""

    A: Matrix  # (m, m)
    b: Vector  # (m,)
    z: Vector  # (m,)
    tableau: Matrix
    scales: Matrix
    basis: Integers
    mu: Vector  # (n,) coefficient of sliding
    mu_static: Vector  # (n,)
    normal_impulse: Vector  # (n,) of contacts with a given normal force
    was_stuck: Integers  # (n,) 0 or 1
    candidate: Integers  # (n,) what was chosen
    unknown: Integers  # (r,) the rows whose impulses are unknown, modes given
    order: Integers  # (r,) row order of LU factors
    gamma: Vector  # (r,)
    error: Vector  # (1,) the last residual
    pivots: Integers  # (1,)
    best: Vector  # (r,) impulses with the least merit of ``planar_newton``
    trial: Vector  # (r,)
    step: Vector  # (r,)
    merits: Vector  # the last ones
    can_decide_redundant: Integers  # (1,) 1 once ``redundant.enumerate_redundant`` is loaded
    has_newton: Integers  # (1,) 1 once ``planar_newton.solve_by_newton`` is loaded
    may_wait: Integers  # (1,) 1 where a census may be put off (census.py)
    given: Vector  # (n,) given normal impulses of all islands
    taken: Integers  # (n,) candidates of all islands
    stays: Integers  # (n,) whether a census looks at a contact
    island: Integers  # (n,) number of the island of each contact
    members: Integers  # (n,) number of contacts in the island of each contact
    found: Integers  # (n,) number of solutions of the island of each contact
    bits: Integers  # (n,) admissible candidates of a contact that is alone in its island, else 0
    is_counted: Integers  # (1,) whether the solutions of the last problem were counted, or certified to be one
    is_shared: Integers  # (1,) whether the impulses of the last problem are one share of many
    part: Part  # an island
    rest: Part  # what a census looks at
    memory: Memory
    tree: Tree
    family: Family


def planar_shapes(n: int, d: int, kept: int = MAX_SOLUTIONS) -> dict[str, Any]:
    """Shapes of ``Planar`` for up to n contacts and ``kept`` solutions; next to nothing when there is but one."""
    m = 3 * n if n > 1 else 1
    r = n * (1 + d) if n > 1 else 1
    levels = min(n, 18) if n > 1 else 1  # more are not enumerated, even where each has two modes
    per_contact = dict.fromkeys(
        ("mu", "mu_static", "normal_impulse", "was_stuck", "candidate", "given", "taken", "stays", "island",
         "members", "found", "bits"), (n,),
    )  # fmt: skip
    flags = ("error", "pivots", "can_decide_redundant", "has_newton", "may_wait", "is_counted", "is_shared")
    return {
        **per_contact, **dict.fromkeys(flags, (1,)), "A": (m, m), "b": (m,), "z": (m,), "tableau": (m, m + 2),
        "scales": (4, m + 2), "basis": (4 * m + 2,), "gamma": (r,), "unknown": (r,), "order": (r,),
        "best": (r,), "trial": (r,), "step": (r,), "merits": (MERITS,),
        "part": part_shapes(n, r), "rest": part_shapes(n, r), "memory": memory_shapes(n, r),
        "tree": tree_shapes(levels, min(r, 2 * levels), kept), "family": family_shapes(levels, min(r, 2 * levels)),
    }  # fmt: skip


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
    planar.error[0] = worst
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
