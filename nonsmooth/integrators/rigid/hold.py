"""The constraints of the modes: what a step drifted from them is taken off, so that an acceleration is enough between.

    min |q - q_1|_M  subject to  g_N = 0 (closed);    min |u - u_1|_M  subject to  gamma_N = 0, gamma_F = 0 (sticking)

with the matrix of rigid/modes.py without friction; the rows of the velocities are those of the new positions. Source:
Eich, *SIAM J. Numer. Anal.* 30 (1993) 1467; Hairer, Wanner, *Solving Ordinary Differential Equations II* (1996),
section VII.2.
"""

from __future__ import annotations

import math

from nonsmooth.errors import Status
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.integrators.rigid.modes import (
    RigidContacts,
    closed_constraints,
    factorise,
    find_ratios,
    list_equations,
    longest,
    rounded_length,
    solve_equations,
)
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP, ContactMode
from nonsmooth.numerics.rounding import rounded_sum

LINEARISATIONS = 4  # derived: the drift of a step is small: each squares it


@kernel("int64(int64, float64, float64[::1], boolean, int64)", short_loops=True)
def hold_constraints(sys_at, t, x, with_friction, contacts_at):
    """Move the state back onto the constraints of its modes, positions first; returns a Status.

    A rebound that is given up (with_friction) is taken off with the friction that belongs to its impulse. The gaps are
    written to the state.
    """
    return hold(view(sys_at, Sys), t, x, with_friction, view(contacts_at, RigidContacts))


@kernel
def hold(sys, t, x, with_friction, contacts):
    """The same, by itself: LLVM unrolls the loops of an entry point before it inlines what they call."""
    n, n_c = sys.n, sys.n_c
    if n_c == 0:
        return Status.RUNNING.value
    n_k, m = 0, 0
    for _ in range(LINEARISATIONS):
        status, n_k = closed_constraints(sys, t, x, contacts)
        if status != Status.RUNNING:
            return status
        m = list_equations(sys, n_k, contacts)
        if m > 0:
            factorise(m, False, contacts)
        if not move_positions(sys, t, m, x, contacts):
            return Status.NOT_FINITE.value
        if not contacts.numbers.drift > rounded_length(n, contacts):
            break
    if m == 0:
        return Status.RUNNING.value
    if with_friction:
        if not find_ratios(sys, n_k, contacts):
            return Status.NEGATIVE_FRICTION.value
        factorise(m, True, contacts)
    for e in range(m):
        contacts.b[e] = -contacts.gamma[contacts.contact[e], contacts.part[e]]
    solve_equations(m, contacts)
    add_corrections(sys, m, n, with_friction, x, contacts)
    return Status.RUNNING.value


@kernel
def move_positions(sys, t, m, x, contacts):
    """Close the gaps of the closed contacts by one linearisation, and write all gaps; False if one is not finite."""
    work, has = contacts.work, sys.has
    n, n_c = sys.n, sys.n_c
    contacts.numbers.drift = 0.0
    if has & (1 << GAP) and not evaluate(sys, GAP, t, contacts.q, contacts.u, work.g_N):
        return False
    for i in range(n_c):
        if not math.isfinite(work.g_N[i]):
            return False
        x[2 * n + i] = work.g_N[i]
    for e in range(m):
        i = contacts.contact[e]
        contacts.b[e] = 0.0
        if contacts.part[e] == 0:
            x[2 * n + i] = 0.0
            gap = abs(work.g_N[i])
            contacts.numbers.drift = max(contacts.numbers.drift, gap)
            if gap > rounded_sum(VELOCITY_ROUNDINGS, longest(n, contacts)):
                contacts.b[e] = -work.g_N[i]
    if contacts.numbers.drift > 0.0:
        solve_equations(m, contacts)
        add_corrections(sys, m, 0, False, x, contacts)
    return True


@kernel
def add_corrections(sys, m, first, with_friction, x, contacts):
    """Add the columns of the equations, times z, to the coordinates (first = 0) or the velocities (first = n) of x.

    A velocity that cancels to rounding becomes exactly 0. With friction z are impulses, and booked.
    """
    n = sys.n
    work, n_c = contacts.work, sys.n_c
    for j in range(n):
        total, size = x[first + j], abs(x[first + j])
        for e in range(m):
            i, a = contacts.contact[e], contacts.row[e]
            part = work.X[a, j] * contacts.z[e]
            if with_friction and contacts.mode[i] == ContactMode.SLIDE:
                part += work.X[a + 1, j] * contacts.ratio[i] * contacts.z[e]
            total += part
            size += abs(part)
        x[first + j] = 0.0 if first > 0 and abs(total) <= rounded_sum(VELOCITY_ROUNDINGS, size) < math.inf else total
    if not with_friction:
        return
    for e in range(m):
        i, z = contacts.contact[e], contacts.z[e]
        x[2 * n + n_c + contacts.part[e] * n_c + i] += z
        if contacts.mode[i] == ContactMode.SLIDE:
            x[2 * n + 2 * n_c + i] += contacts.ratio[i] * z
