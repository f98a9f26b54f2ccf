"""The constraints of the modes in space: what a step drifted from them is taken off, and impulses are given.

    min |q - q_1|_M  subject to  g_N = 0 (closed);    min |u - u_1|_M  subject to  gamma_N = 0, gamma_T = 0 (sticking)

as in the plane (rigid/hold.py), with q' = B u; redundant rows take the least impulses. Source: Eich, *SIAM J. Numer.
Anal.* 30 (1993) 1467.
"""

from __future__ import annotations

import math

from nonsmooth.errors import Status
from nonsmooth.integrators.event_driven.space_motion import (
    ALL_HELD,
    NORMALS,
    decompose,
    list_closed,
    list_equations,
    regularise,
    solve_equations,
)
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.integrators.records import (
    N_LEDGER,
    N_WORKS,
    book_contact_energy,
)
from nonsmooth.integrators.rigid.hold import LINEARISATIONS
from nonsmooth.integrators.rigid.modes import DISTINCT_ROWS, EVERY, longest
from nonsmooth.jit import kernel
from nonsmooth.mechanics.acceleration_problem import constraint_problem
from nonsmooth.mechanics.contact_problem import row_velocities
from nonsmooth.mechanics.kinematics import coordinate_rates, find_kinematics
from nonsmooth.mechanics.sys import evaluate
from nonsmooth.mechanics.system import GAP
from nonsmooth.numerics.rounding import rounded_sum


@kernel
def hold(sys, t, x, c):
    """Move the state onto g_N = 0, gamma_N = 0 and, sticking, gamma_T = 0; the gaps are written. Returns a Status."""
    work, n_q, n_c = c.work, sys.n_q, sys.n_c
    if n_c == 0:
        return Status.RUNNING.value
    n_k = 0
    for _ in range(LINEARISATIONS):
        n_k = list_closed(sys, x, c)
        if not find_gaps(sys, t, x, c):
            return Status.NOT_FINITE.value
        if n_k == 0:
            return Status.RUNNING.value
        status, _ = constraint_problem(sys, t, c.q, c.u, n_k, work)
        if status != Status.RUNNING:
            return status
        m, drift = list_equations(NORMALS, EVERY, n_k, c), 0.0
        for e in range(m):
            i = c.contact[e]
            c.b[e], x[n_q + sys.n + i] = -work.g_N[i], 0.0
            drift = max(drift, abs(work.g_N[i]))
        if not drift > rounded_sum(VELOCITY_ROUNDINGS, longest(n_q, c)):
            break
        solve_held(m, NORMALS, c)
        if not find_kinematics(sys, t, c.q, c.u, work):
            return Status.NOT_FINITE.value
        combine(m, sys.n, c)
        coordinate_rates(sys, c.move, work, c.dq)
        for j in range(n_q):
            x[j] += c.dq[j]
    row_velocities(sys, n_k, c.u, work)
    stop(n_k, c)
    give(sys, False, n_k, x, c)
    return Status.RUNNING.value


@kernel
def find_gaps(sys, t, x, c):
    """Write all gaps, to work.g_N and into the state; False where one is no number."""
    if not evaluate(sys, GAP, t, c.q, c.u, c.work.g_N):
        return False
    total = 0.0
    for i in range(sys.n_c):
        x[sys.n_q + sys.n + i] = c.work.g_N[i]
        total += 0.0 * c.work.g_N[i]
    return total == 0.0


@kernel
def solve_held(m, which, c):
    """A z = b of the rows that are held; of redundant ones the least z."""
    if decompose(m, which, c) < DISTINCT_ROWS and m > 1:
        regularise(m, c)
    for e in range(m):
        c.z[e] = 0.0
    solve_equations(m, c)


@kernel
def combine(m, n, c):
    """move = X^T z."""
    for j in range(n):
        c.move[j] = 0.0
        for e in range(m):
            c.move[j] += c.work.X[c.row[e], j] * c.z[e]


@kernel
def stop(n_k, c):
    """The impulses, to work.P, that take gamma_N and, sticking, gamma_T, of the velocities in work.gamma_0."""
    work, m = c.work, list_equations(ALL_HELD, EVERY, n_k, c)
    for a in range(work.start[n_k]):
        work.P[a] = 0.0
    if m == 0:
        return
    for e in range(m):
        c.b[e] = -work.gamma_0[c.row[e]]
    solve_held(m, ALL_HELD, c)
    for e in range(m):
        work.P[c.row[e]] = c.z[e]


@kernel
def give(sys, is_booked, n_k, x, c):
    """u += X^T P, what cancels to rounding set to 0; the impulses of an event are booked, with their works.

    Returns what the contacts gained, the sizes of its parts, and the work with which friction drives a slide.
    """
    work, n_q, n, n_c, r = c.work, sys.n_q, sys.n, sys.n_c, c.work.start[n_k]
    for j in range(n):
        before, total, size = x[n_q + j], x[n_q + j], abs(x[n_q + j])
        for a in range(r):
            part = work.X[a, j] * work.P[a]
            total, size = total + part, size + abs(part)
        x[n_q + j] = 0.0 if abs(total) <= rounded_sum(VELOCITY_ROUNDINGS, size) < math.inf else total
        work.trial[j] = 0.5 * (before + x[n_q + j])
    if not is_booked:
        return 0.0, 0.0, 0.0
    for m in range(N_LEDGER):
        c.ledger[m] = 0.0
    _, gain, size, push = book_contact_energy(sys, n_k, work.trial, c.ledger, work)
    for m in range(N_WORKS):
        x[x.shape[0] - N_WORKS + m] += c.ledger[m]
    for k in range(n_k):
        i = work.closed[k]
        for a in range(work.start[k + 1] - work.start[k]):
            c.P[i, a] += work.P[work.start[k] + a]
            x[n_q + n + (1 + a) * n_c + i] += work.P[work.start[k] + a]
    return gain, size, push
