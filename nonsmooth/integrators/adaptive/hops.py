"""Flights too low to be followed: contacts that an impact of another has thrown up, and that come back at once.

Two feet without restitution throw one another up in turn, ever lower and sooner. A flight whose height, v^2 / (2 a)
with the acceleration a back towards the surface, is below a part of the tolerance of the gap does not take place.
Over it the weight gives what the landing takes, P = v/G, with its friction; held closed instead, the contact carries
2 v/G in that time. So the impulse at its beginning is -v/G, of which friction is a part as of any other:

    gamma_N = 0 (closed),    gamma_F = 0 (sticking),    P_F = -s mu sigma P_N (sliding)

With it the motion after the flight is the same, to the tolerance. Compare the bounces that adaptive/substep.py drops.
"""

from __future__ import annotations

from nonsmooth.integrators.adaptive.held import coefficient, list_closed
from nonsmooth.integrators.adaptive.scales import closed_gap, mode_when_closed
from nonsmooth.integrators.adaptive.substep import DROPPED
from nonsmooth.integrators.rigid.modes import DISTINCT_ROWS, decompose, list_equations, solve_equations
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.mechanics.acceleration_problem import find_row_rates, row_shift
from nonsmooth.mechanics.contact_problem import apply_inverse, delassus, evaluate_rows, stack_rows
from nonsmooth.mechanics.system import GIVEN_FORCE, UNILATERAL, ContactMode


@kernel
def may_hop(sys, i, run):
    """Whether contact i has just parted."""
    is_open = sys.kinds[i, 0] == UNILATERAL and run.contacts.mode[i] == ContactMode.OPEN
    return is_open and run.gamma_1[i] > 0.0 and run.g_1[i] <= closed_gap(i, run)


@rare_kernel
def drop_hops(sys, t, run):
    """Close the contacts that hop lower than the tolerance, and give run.x the impulses; whether there are any.

    Of the state run.x accelerations are in contacts.work.du, and run.g_1, run.gamma_1 are known.
    """
    contacts, work, n = run.contacts, run.contacts.work, run.contacts.q.shape[0]
    n_c = sys.n_c
    parts = False
    for i in range(n_c):
        work.closed[i] = i
        parts = parts or may_hop(sys, i, run)
    if not parts:
        return False
    for j in range(n):
        contacts.q[j], contacts.u[j] = run.x[j], run.x[n + j]
    if not find_row_rates(sys, row_shift(sys, contacts.u), t, contacts.q, contacts.u, n_c, contacts.rates, work):
        return False
    for j in range(n):
        work.q_mid[j] = contacts.q[j]
    if not evaluate_rows(sys, True, t, contacts.u, work):
        return False
    stack_rows(sys, n_c, contacts.u, work)
    if not close_hops(sys, run):
        return False
    throw_down(sys, run)
    return True


@kernel
def close_hops(sys, run):
    """Give the contacts that hop the modes in which they come down; whether there are any."""
    n = sys.n
    contacts, work, any_hops = run.contacts, run.contacts.work, False
    for i in range(sys.n_c):
        r = work.start[i]
        if not may_hop(sys, i, run):
            continue
        a, v = contacts.rates[0, r], run.gamma_1[i]
        for j in range(n):
            a += work.W_N[i, j] * work.du[j]
        if v * v > -2.0 * a * DROPPED * run.tol_g[i]:
            continue
        any_hops = True
        gamma_F = work.gamma_0[r + 1] if sys.kinds[i, 1] > 0 else 0.0
        contacts.mode[i], contacts.slip[i] = mode_when_closed(sys, i, gamma_F, run), 0
        if contacts.mode[i] == ContactMode.SLIDE:
            contacts.slip[i] = 1 if gamma_F > 0.0 else -1
    return any_hops


@kernel
def throw_down(sys, run):
    """The velocities of run.x by the impulses that hold the modes; redundant ones are left to the constraints."""
    n = sys.n
    contacts, work = run.contacts, run.contacts.work
    kinds, n_k = sys.kinds, list_closed(sys, contacts)
    r = stack_rows(sys, n_k, contacts.u, work)
    apply_inverse(sys, False, r, work)
    delassus(n, r, work)
    for k in range(n_k):
        i = work.closed[k]
        if contacts.mode[i] == ContactMode.SLIDE:
            s = contacts.slip[i]
            mu = coefficient(sys, i, s * work.gamma_0[work.start[k + 1] - 1])
            contacts.ratio[i] = -s * mu * contacts.sign[i]
    m = list_equations(sys, n_k, contacts)
    for e in range(m):
        contacts.b[e] = -work.gamma_0[contacts.row[e]]
    smallest = decompose(m, True, contacts)
    if smallest == 0.0 or (smallest < DISTINCT_ROWS and m > 1):
        return
    solve_equations(m, contacts)
    for e in range(m):
        i, a = contacts.contact[e], contacts.row[e]
        slides = contacts.part[e] == 0 and kinds[i, 0] != GIVEN_FORCE and contacts.mode[i] == ContactMode.SLIDE
        for j in range(n):
            run.x[n + j] += work.X[a, j] * contacts.z[e]
            if slides:
                run.x[n + j] += work.X[a + 1, j] * contacts.ratio[i] * contacts.z[e]
