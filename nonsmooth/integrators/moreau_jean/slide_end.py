"""Where the force of a slide ends: the test for an impact without collision.

A slide with sign s of contact N carries the normal force la_N >= 0 of

    0 <= la_N,   p la_N + b >= 0,   la_N (p la_N + b) = 0,      p = G_NN - s mu G_NF

at acceleration level. With p < 0 and b < 0 there is none: rigid mechanics is inconsistent, and the step that sticks
there passed through an impact without collision. What follows the test, and why it is asked twice:
docs/theory/moreau_jean.md. Source: Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653.
"""

from __future__ import annotations

from nonsmooth.errors import Status
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import address
from nonsmooth.mechanics.acceleration_problem import acceleration_problem_apart
from nonsmooth.mechanics.kinematics import move
from nonsmooth.mechanics.system import BILATERAL


@kernel
def had_no_force(sys, mu, t, dt, n_k, k, state, scratch):
    """Whether the slide of closed contact k ran out of forces within a step from the state at t.

    The acceleration-level problem is asked at the end of the step for the motion without contact forces, where a force
    that fades to zero has crossed into the paradox, and at the state before the step, where it is left in ``there``,
    contact k first.
    """
    n, q, u = sys.n, state.q, state.u
    work, there, slip = scratch.work, scratch.there, state.slip[scratch.work.closed[k]]
    for m in range(n_k):
        there.closed[m] = work.closed[m]
    there.closed[0], there.closed[k] = work.closed[k], work.closed[0]
    is_lost = False
    for way in range(2):
        ahead = 1.0 - way
        move(sys, q, ahead * dt, u, work, work.q_end)
        for i in range(n):
            work.rhs[i] = u[i] + ahead * work.du[i]
        status, _ = acceleration_problem_apart(
            address(sys), t + ahead * dt, work.q_end, work.rhs, n_k, scratch.rates, address(there)
        )
        if status == Status.RUNNING:
            is_bilateral = sys.kinds[there.closed[0], 0] == BILATERAL
            if has_no_sliding_force(is_bilateral, slip, mu, there.G[0, 0], there.G[0, 1], there.c[0]):
                is_lost = True
        elif way == 1:
            return False
    return is_lost


@kernel
def has_no_sliding_force(is_bilateral, s, mu, G_NN, G_NF, b):
    """Whether no normal force fits sliding with sign s: b + D la_N = 0 (or b >= 0 while la_N = 0) has no solution."""
    p = G_NN - s * mu * G_NF
    if not is_bilateral:
        return p < 0.0 and b < 0.0
    D = G_NN + s * mu * G_NF  # for la_N < 0
    return -b / p < 0.0 < -b / D if p != 0.0 and D != 0.0 else True
