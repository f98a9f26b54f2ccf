"""The contact problem of several planar contacts: its arrays, its residual, the names of its modes.

    gamma = G P + c,    per contact (N, T), N alone without friction, T alone for a given normal force

A solution satisfies, with R = mu |P_N| (mu_s where it sticks),

    0 <= P_N _|_ gamma_N >= 0  (gamma_N = 0 for a bilateral contact),    P_F = proj_[-R, R](P_F - gamma_F / G_FF).

Source: Jean, *Comput. Methods Appl. Mech. Engrg.* 177 (1999) 235.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from nonsmooth.blocks import Integers, Matrix, Vector
from nonsmooth.contact_solvers.modes import MAX_SOLUTIONS, Tree, tree_shapes
from nonsmooth.contact_solvers.single import FREE, STICK
from nonsmooth.jit import kernel
from nonsmooth.laws import depends_on_speed, friction_coefficient
from nonsmooth.system import BILATERAL, GIVEN_FORCE, UNILATERAL

ACCEPTED = 1e-9  # largest relative residual of an accepted solution


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


def family_shapes(n: int, r: int) -> dict[str, tuple[int, ...]]:
    """Shapes of ``Family`` for n contacts with r rows; a contact has up to three inequalities."""
    return {
        "B": (r, r + 1), "column": (r,), "row": (r,), "first": (n + 1,), "x": (r,), "y": (r,), "H": (r, r),
        "L": (r, r), "C": (3 * n, r), "e": (3 * n,), "A": (3 * n, r), "AH": (3 * n, r),
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
    pivots: Integers  # (1,)
    can_decide_redundant: Integers  # (1,) 1 once ``redundant.enumerate_redundant`` is loaded
    tree: Tree
    family: Family


def planar_shapes(n: int, d: int, kept: int = MAX_SOLUTIONS) -> dict[str, Any]:
    """Shapes of ``Planar`` for up to n contacts and ``kept`` solutions; next to nothing when there is but one."""
    m = 3 * n if n > 1 else 1
    r = n * (1 + d) if n > 1 else 1
    levels = min(n, 18) if n > 1 else 1  # more are not enumerated, even where each has two modes
    per_contact = dict.fromkeys(("mu", "mu_static", "normal_impulse", "was_stuck", "candidate"), (n,))
    return {
        **per_contact, "A": (m, m), "b": (m,), "z": (m,), "tableau": (m, m + 2), "scales": (4, m + 2),
        "basis": (4 * m + 2,), "gamma": (r,),
        "unknown": (r,), "order": (r,), "pivots": (1,), "can_decide_redundant": (1,),
        "tree": tree_shapes(levels, min(r, 2 * levels), kept), "family": family_shapes(levels, min(r, 2 * levels)),
    }  # fmt: skip


@kernel
def residual(n, closed, start, kinds, G, c, P, planar):
    """Largest violation of the inclusions, relative to max |c|; the velocities are left in ``planar.gamma``.

    Normal: |min(|G_NN| P_N, gamma_N)|. Tangential, by the projection on the disc of radius mu |P_N|:
    G_FF |P_F - proj(P_F - gamma_F / G_FF)|.
    """
    r = start[n]
    scale = 0.0
    worst = 0.0
    for k in range(r):
        total = c[k]
        for m in range(r):
            total += G[k, m] * P[m]
        planar.gamma[k] = total
        scale = max(scale, abs(c[k]))
    for k in range(n):
        i = closed[k]
        a = start[k]
        t = start[k + 1] - 1
        kind = kinds[i, 0]
        P_N = planar.normal_impulse[k] if kind == GIVEN_FORCE else P[a]
        if kind == UNILATERAL:
            worst = max(worst, abs(min(abs(G[a, a]) * P_N, planar.gamma[a])))
        elif kind == BILATERAL:
            worst = max(worst, abs(planar.gamma[a]))
        if kinds[i, 1] > 0:
            is_stuck = abs(planar.gamma[t]) <= ACCEPTED * scale
            reach = (planar.mu_static[k] if is_stuck else planar.mu[k]) * max(
                0.0, abs(P_N) if kind == BILATERAL else P_N
            )
            pulled = P[t] - planar.gamma[t] / G[t, t]
            worst = max(worst, G[t, t] * abs(P[t] - max(-reach, min(reach, pulled))))
    if not worst < np.inf:  # NaN
        return np.inf
    return worst / scale if scale > 0.0 else worst


@kernel
def name_modes(n, closed, start, kinds, P, planar):
    """Name the mode of each contact from its impulses and velocities; always True."""
    for k in range(n):
        i = closed[k]
        t = start[k + 1] - 1
        is_given = kinds[i, 0] == GIVEN_FORCE
        P_N = planar.normal_impulse[k] if is_given else P[start[k]]
        reach = planar.mu[k] * abs(P_N)
        if P_N == 0.0:
            planar.candidate[k] = FREE if kinds[i, 0] == UNILATERAL or is_given else STICK
        elif kinds[i, 1] == 0 or abs(P[t]) < reach * (1.0 - 1e-9):
            planar.candidate[k] = STICK
        else:
            s = -1 if P[t] > 0.0 else 1
            stays = abs(planar.gamma[t]) <= 1e-12 * abs(P[t])
            planar.candidate[k] = STICK if stays else (2 if s > 0 else 3) + (2 if P_N < 0.0 else 0)
    return True


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
