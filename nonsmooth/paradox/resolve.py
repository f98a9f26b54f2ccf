"""Where the force of a slide ends: the test for an impact without collision.

A slide with sign s of contact N carries the normal force la_N >= 0 of

    0 <= la_N,   p la_N + b >= 0,   la_N (p la_N + b) = 0,      p = G_NN - s mu G_NF

at acceleration level. With p < 0 and b < 0 there is none: rigid mechanics is inconsistent, and the step that sticks
there passed through an impact without collision. What follows the test, and why it is asked twice:
docs/theory/moreau_jean.md. Source: Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653.
"""

from __future__ import annotations

from nonsmooth.acceleration_problem import acceleration_problem
from nonsmooth.blocks import view
from nonsmooth.contact_problem import Work
from nonsmooth.errors import Status
from nonsmooth.jit import kernel
from nonsmooth.system import BILATERAL


@kernel(
    "boolean(int64, int64, float64[::1], int64[:, ::1], float64, int64, float64, float64, int64, int64, int64, "
    "float64[::1], float64[::1], int64, int64, float64[:, ::1])",
    short_loops=True,
)
def had_no_force(model, has, p, kinds, mu, slip, t, dt, n, n_k, k, q, u, work_at, there_at, rates):
    """Whether the slide of closed contact k ran out of forces within a step from (t, q, u).

    The acceleration-level problem is asked at the state before the step, and at the end of the step for the motion
    without contact forces: where the force of a slide fades to zero the step itself crosses into the paradox.
    """
    work, there = view(work_at, Work), view(there_at, Work)
    for m in range(n_k):
        there.closed[m] = work.closed[m]
    if no_force_at(model, has, p, kinds, mu, slip, t, n, n_k, k, q, u, there, rates):
        return True
    for i in range(n):
        work.trial[i] = q[i] + dt * u[i]
        work.rhs[i] = u[i] + work.du[i]
    return no_force_at(model, has, p, kinds, mu, slip, t + dt, n, n_k, k, work.trial, work.rhs, there, rates)


@kernel
def no_force_at(model, has, p, kinds, mu, slip, t, n, n_k, k, q, u, there, rates):
    """Whether no normal force fits the slip that contact k had, at one state."""
    status, _ = acceleration_problem(model, has, t, n, q, u, p, n_k, kinds, rates, there)
    if status != Status.RUNNING:
        return False
    a = there.start[k]
    is_bilateral = kinds[there.closed[k], 0] == BILATERAL
    return has_no_sliding_force(is_bilateral, slip, mu, there.G[a, a], there.G[a, a + 1], there.c[a])


@kernel
def has_no_sliding_force(is_bilateral, s, mu, G_NN, G_NF, b):
    """Whether no normal force fits sliding with sign s: b + D la_N = 0 (or b >= 0 while la_N = 0) has no solution."""
    p = G_NN - s * mu * G_NF
    if not is_bilateral:
        return p < 0.0 and b < 0.0
    D = G_NN + s * mu * G_NF  # for la_N < 0
    return -b / p < 0.0 < -b / D if p != 0.0 and D != 0.0 else True
