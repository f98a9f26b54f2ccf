"""Modes of the contacts at a start, found inside a compiled loop.

The same as ``initial_state.examine_state``, which words what is wrong with a start.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel
from nonsmooth.mechanics.contact_problem import evaluate_rows
from nonsmooth.mechanics.situation import Situation, find_situation, mode_of_situation, tolerances_of_state
from nonsmooth.mechanics.sys import evaluate
from nonsmooth.mechanics.system import GAP, GIVEN_FORCE, ContactMode

RAISED, INADMISSIBLE, ADMISSIBLE = 0, 1, 2  # code: what a state of the model is


@kernel
def initial_modes(sys, t, state, work):
    """Fill state.mode and state.slip from state.q, state.u; returns RAISED, INADMISSIBLE or ADMISSIBLE."""
    n, n_c = sys.n, sys.n_c
    q, u, gamma_F = state.q, state.u, work.rates
    for j in range(sys.n_q):
        work.q_mid[j] = q[j]
    if n_c > 0:
        if sys.has & (1 << GAP) and not evaluate(sys, GAP, t, work.q_mid, u, work.g_N):
            return RAISED
        if not evaluate_rows(sys, True, t, u, work):
            return RAISED
    length, speed, surface = 0.0, 0.0, 0.0
    for j in range(sys.n_q):
        length = max(length, abs(q[j]))
    for j in range(n):
        speed = max(speed, abs(u[j]))
    for i in range(n_c):
        if sys.kinds[i, 1] > 0:
            gamma_F[i, 1] = work.w_F[i, 0]
            for j in range(n):
                gamma_F[i, 1] += work.W_F[i, 0, j] * u[j]
            if sys.kinds[i, 1] == 2:
                gamma_F[i, 2] = work.w_F[i, 1]
                for j in range(n):
                    gamma_F[i, 2] += work.W_F[i, 1, j] * u[j]
                gamma_F[i, 1] = math.sqrt(gamma_F[i, 1] ** 2 + gamma_F[i, 2] ** 2)
            surface = max(surface, abs(gamma_F[i, 1]))
    near, slow, still = tolerances_of_state(length, speed, surface)
    verdict = ADMISSIBLE
    for i in range(n_c):
        kind, d, gamma_N, slip = sys.kinds[i, 0], sys.kinds[i, 1], 0.0, 0.0
        if kind != GIVEN_FORCE:
            gamma_N = work.w_N[i]
            for j in range(n):
                gamma_N += work.W_N[i, j] * u[j]
        if d > 0:
            slip = gamma_F[i, 1]
        if find_situation(kind, work.g_N[i], gamma_N, slip, near, slow, still, False) >= Situation.PENETRATING.value:
            verdict = INADMISSIBLE
        state.mode[i] = mode_of_situation(find_situation(kind, work.g_N[i], gamma_N, slip, near, slow, still, True), d)
        if state.mode[i] == ContactMode.SLIDE and d == 1:
            state.slip[i] = 1 if slip > 0.0 else -1
    return verdict
