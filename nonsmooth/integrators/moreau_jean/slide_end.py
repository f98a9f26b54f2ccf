"""Where the force of a slide ends: the test for an impact without collision.

A slide with sign s of contact N carries the normal force la_N >= 0 of

    0 <= la_N,   p la_N + b >= 0,   la_N (p la_N + b) = 0,      p = G_NN - s mu G_NF

at acceleration level; in space p = G_NN - mu G_NT d along the direction d of sliding. With p < 0 and b < 0 there is
none: rigid mechanics is inconsistent, and the step that sticks there passed through an impact without collision. What
follows the test, and why it is asked twice: docs/theory/moreau_jean.md.
Source: Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653.
"""

from __future__ import annotations

import math

from nonsmooth.contact.spatial.solve import GOES_ON
from nonsmooth.errors import Status
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import address
from nonsmooth.mechanics.acceleration_problem import acceleration_problem_apart
from nonsmooth.mechanics.contact_problem import row_velocities
from nonsmooth.mechanics.impact_in_space import p_before, turns_into_paradox
from nonsmooth.mechanics.kinematics import move
from nonsmooth.mechanics.system import BILATERAL


@kernel
def had_no_force(sys, mu, t, dt, n_k, k, state, scratch):
    """Whether the slide of closed contact k ran out of forces within a step from the state at t.

    The acceleration-level problem is asked at the end of the step for the motion without contact forces, where a force
    that fades to zero has crossed into the paradox, and at the state before the step, where it is left in ``there``,
    contact k first.
    """
    slip, is_lost = state.slip[scratch.work.closed[k]], False
    for way in range(2):
        if set_up_slide(sys, t, dt, 1.0 - way, n_k, k, state, scratch):
            there = scratch.there
            is_bilateral = sys.kinds[there.closed[0], 0] == BILATERAL
            if has_no_sliding_force(is_bilateral, slip, mu, there.G[0, 0], there.G[0, 1], there.c[0]):
                is_lost = True
        elif way == 1:
            return False
    return is_lost


@kernel
def slid_without_force(sys, t, dt, n_k, k, state, scratch):
    """The same of a contact with friction in two directions, by the p and b of its own slide, at the end of the step
    only where the slide goes on."""
    there = scratch.there
    for way in range(0 if goes_on(k, scratch.work) else 1, 2):
        if set_up_slide(sys, t, dt, 1.0 - way, n_k, k, state, scratch):
            row_velocities(sys, 1, scratch.work.rhs, there)
            v_1, v_2 = there.gamma_0[1], there.gamma_0[2]
            speed = math.sqrt(v_1 * v_1 + v_2 * v_2)
            p = there.G[0, 0] * speed - scratch.spatial.mu[k] * (there.G[0, 1] * v_1 + there.G[0, 2] * v_2)
            if p < 0.0 and there.c[0] < 0.0:
                return True
    return False


@kernel
def turned_without_force(scratch):
    """Whether the slide of the only contact, in the hodograph, has p < 0 in the rows of the step, or is turned to p < 0
    by the impulse of the step before it is stopped."""
    work, h = scratch.work, scratch.hodograph
    if not (work.c[0] < 0.0 and h.before[1] * h.before[1] + h.before[2] * h.before[2] > 0.0):
        return False
    return p_before(h)[0] < 0.0 or (goes_on(0, work) and turns_into_paradox(work.P[0], h))


@kernel
def goes_on(k, work):
    """Whether the motion without contact forces changes the slide of closed contact k by a part only. Another one is
    at its end, and what has become of it is not known to O(dt)."""
    a = work.start[k]
    v_1, v_2 = work.gamma_0[a + 1], work.gamma_0[a + 2]
    change_1, change_2 = work.c[a + 1] - v_1, work.c[a + 2] - v_2
    return change_1 * change_1 + change_2 * change_2 < GOES_ON * GOES_ON * (v_1 * v_1 + v_2 * v_2)


@kernel
def set_up_slide(sys, t, dt, ahead, n_k, k, state, scratch):
    """The acceleration-level problem, contact k first, at a part of the step on the motion without contact forces, to
    ``there``; False if it is not finite."""
    work, there = scratch.work, scratch.there
    for m in range(n_k):
        there.closed[m] = work.closed[m]
    there.closed[0], there.closed[k] = work.closed[k], work.closed[0]
    move(sys, state.q, ahead * dt, state.u, work, work.q_end)
    for i in range(sys.n):
        work.rhs[i] = state.u[i] + ahead * work.du[i]
    status, _ = acceleration_problem_apart(
        address(sys), t + ahead * dt, work.q_end, work.rhs, n_k, scratch.rates, address(there)
    )
    return status == Status.RUNNING


@kernel
def has_no_sliding_force(is_bilateral, s, mu, G_NN, G_NF, b):
    """Whether no normal force fits sliding with sign s: b + D la_N = 0 (or b >= 0 while la_N = 0) has no solution."""
    p = G_NN - s * mu * G_NF
    if not is_bilateral:
        return p < 0.0 and b < 0.0
    D = G_NN + s * mu * G_NF  # for la_N < 0
    return -b / p < 0.0 < -b / D if p != 0.0 and D != 0.0 else True
