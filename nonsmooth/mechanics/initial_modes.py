"""Modes of the contacts at a start, found inside a compiled loop.

The same rules as ``initial_state.examine_state``, which words what is wrong with a start: a contact takes part where
its gap is closed and it neither parts nor lands; it sticks where gamma_F = 0 within the scale of the velocities.
"""

from __future__ import annotations

from nonsmooth.jit import kernel
from nonsmooth.mechanics.contact_problem import evaluate_rows
from nonsmooth.mechanics.initial_state import CONSISTENT
from nonsmooth.mechanics.sys import evaluate
from nonsmooth.mechanics.system import BILATERAL, GAP, GIVEN_FORCE, ContactMode

RAISED, INADMISSIBLE, ADMISSIBLE = 0, 1, 2  # code: what a state of the model is


@kernel
def initial_modes(sys, t, state, work):
    """Fill state.mode and state.slip from state.q, state.u; returns RAISED, INADMISSIBLE or ADMISSIBLE."""
    n, n_c = sys.n, sys.n_c
    q, u, gamma_F = state.q, state.u, work.rates
    for j in range(n):
        work.q_mid[j] = q[j]
    if n_c > 0:
        if sys.has & (1 << GAP) and not evaluate(sys, GAP, t, work.q_mid, u, work.g_N):
            return RAISED
        if not evaluate_rows(sys, sys.has, True, t, u, work):
            return RAISED
    length, speed, surface = 0.0, 0.0, 0.0
    for j in range(n):
        length = max(length, abs(q[j]))
        speed = max(speed, abs(u[j]))
    for i in range(n_c):
        if sys.kinds[i, 1] > 0:
            gamma_F[i, 1] = work.w_F[i, 0]
            for j in range(n):
                gamma_F[i, 1] += work.W_F[i, 0, j] * u[j]
            surface = max(surface, abs(gamma_F[i, 1]))
    verdict = ADMISSIBLE
    for i in range(n_c):
        if sys.kinds[i, 0] != GIVEN_FORCE:
            gamma_N = work.w_N[i]
            for j in range(n):
                gamma_N += work.W_N[i, j] * u[j]
            is_bilateral = sys.kinds[i, 0] == BILATERAL
            if is_bilateral:
                if abs(work.g_N[i]) > CONSISTENT * length or abs(gamma_N) > CONSISTENT * max(speed, surface):
                    verdict = INADMISSIBLE
            elif work.g_N[i] < -CONSISTENT * length:
                verdict = INADMISSIBLE
            if not is_bilateral and (work.g_N[i] > CONSISTENT * length or abs(gamma_N) > CONSISTENT * speed):
                continue
        if sys.kinds[i, 1] == 0:
            state.mode[i] = ContactMode.LOCKED.value
        elif abs(gamma_F[i, 1]) <= CONSISTENT * max(speed, surface):
            state.mode[i] = ContactMode.STICK.value
        else:
            state.mode[i] = ContactMode.SLIDE.value
            state.slip[i] = 1 if gamma_F[i, 1] > 0.0 else -1
    return verdict
