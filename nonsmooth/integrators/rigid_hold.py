"""The constraints of the modes: what a step drifted from them is taken off, so that an acceleration is enough between.

    min |q - q_1|_M  subject to  g_N = 0 (closed);    min |u - u_1|_M  subject to  gamma_N = 0, gamma_F = 0 (sticking)

One linearisation each, with the matrix of rigid_modes.py without friction: the drift of a step is of the size of its
error. Source: Eich, *SIAM J. Numer. Anal.* 30 (1993) 1467; Hairer, Wanner, *Solving Ordinary Differential Equations II*
(1996), section VII.2.
"""

from __future__ import annotations

from nonsmooth.errors import Status
from nonsmooth.integrators.moreau_jean_step import ROUNDING
from nonsmooth.integrators.rigid_modes import (
    HAS,
    N_U,
    closed_problem,
    factorise,
    find_ratios,
    list_equations,
    longest,
    solve_equations,
)
from nonsmooth.jit import call_model, kernel
from nonsmooth.system import GAP, ContactMode


@kernel
def hold(model, p, t, x, with_friction, contacts):
    """Move the state back onto the constraints of its modes, g_N = 0, gamma_N = 0 and gamma_F = 0; returns a Status.

    What drifted in a step is taken off in the mass metric. A rebound that is given up (with_friction) is taken off with
    the friction that belongs to its impulse. The gaps are written to the state.
    """
    work, kinds = contacts.work, contacts.kinds
    n, n_c = contacts.facts[N_U], kinds.shape[0]
    if n_c == 0:
        return Status.RUNNING
    status, n_k = closed_problem(model, p, t, x, contacts)
    if status != Status.RUNNING:
        return status
    if contacts.facts[HAS] & (1 << GAP) and not call_model(model, GAP, t, contacts.q, contacts.u, p, work.g_N):
        return Status.NOT_FINITE
    for i in range(n_c):
        x[2 * n + i] = work.g_N[i]
    if n_k == 0:
        return Status.RUNNING
    if with_friction and not find_ratios(n_k, contacts):
        return Status.NEGATIVE_FRICTION
    m = list_equations(n_k, contacts)
    factorise(m, with_friction, contacts)
    for e in range(m):
        contacts.b[e] = -contacts.gamma[contacts.contact[e], contacts.part[e]]
    solve_equations(m, contacts)
    move(n, m, n, with_friction, x, contacts)
    for e in range(m):
        i = contacts.contact[e]
        contacts.b[e] = 0.0
        if contacts.part[e] == 0:
            contacts.b[e] = -work.g_N[i] if abs(work.g_N[i]) > ROUNDING * longest(n, contacts) else 0.0
            x[2 * n + i] = 0.0
    solve_equations(m, contacts)
    move(n, m, 0, False, x, contacts)
    return Status.RUNNING


@kernel
def move(n, m, first, with_friction, x, contacts):
    """Add the columns of the equations, times z, to the coordinates (first = 0) or the velocities (first = n) of x.

    A velocity that cancels to rounding becomes exactly 0. With friction z are impulses, and booked.
    """
    work, n_c = contacts.work, contacts.kinds.shape[0]
    for j in range(n):
        total, size = x[first + j], abs(x[first + j])
        for e in range(m):
            i, a = contacts.contact[e], contacts.row[e]
            part = work.X[a, j] * contacts.z[e]
            if with_friction and contacts.mode[i] == ContactMode.SLIDE:
                part += work.X[a + 1, j] * contacts.ratio[i] * contacts.z[e]
            total += part
            size += abs(part)
        x[first + j] = total if first == 0 or abs(total) > ROUNDING * size else 0.0
    if not with_friction:
        return
    for e in range(m):
        i, z = contacts.contact[e], contacts.z[e]
        x[2 * n + n_c + contacts.part[e] * n_c + i] += z
        if contacts.mode[i] == ContactMode.SLIDE:
            x[2 * n + 2 * n_c + i] += contacts.ratio[i] * z
