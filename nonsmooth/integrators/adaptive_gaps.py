"""Gaps over an adaptive step: how low they fell, and when an open contact will close.

Between the ends of a smooth step of length H a gap is the cubic with its values and rates there,

    g(s) = g_0 + s (c + s (b + s a)),    c = H gamma_0,  b = 3 (g_1 - g_0) - H (2 gamma_0 + gamma_1),
    a = H (gamma_0 + gamma_1) - 2 (g_1 - g_0)

and ahead of it the parabola with the acceleration of the step. A step that would end, or pass, below a surface is
taken anew to the first zero, so that an impact finds its gap closed to rounding after two or three steps.
"""

from __future__ import annotations

import math

from nonsmooth.integrators.adaptive_state import ATOL, LEAST, RTOL
from nonsmooth.integrators.rigid_modes import HAS
from nonsmooth.jit import call_model, kernel
from nonsmooth.system import GAP, GAP_RATE, NORMAL, UNILATERAL, ContactMode

BISECTIONS = 60
NEAR = 0.5  # of the gaps at the ends of a step: a lower turn is looked at closely
CLOSED = 1e-2  # of the tolerance of a gap: a contact above it is open. An impact there moves nothing by the tolerance.


@kernel
def observe(model, p, t, x, g, gamma, run):
    """Gaps and their rates at a state, and the rows contacts.work.W_N there; False if a model function raised."""
    contacts, work = run.contacts, run.contacts.work
    has, n, n_c = contacts.facts[HAS], contacts.q.shape[0], contacts.kinds.shape[0]
    for i in range(n):
        contacts.q[i], contacts.u[i] = x[i], x[n + i]
    q, u = contacts.q, contacts.u
    if has & (1 << GAP) and not call_model(model, GAP, t, q, u, p, work.g_N):
        return False
    if has & (1 << NORMAL) and not call_model(model, NORMAL, t, q, u, p, work.W_N):
        return False
    if has & (1 << GAP_RATE) and not call_model(model, GAP_RATE, t, q, u, p, work.w_N):
        return False
    for i in range(n_c):
        g[i], gamma[i] = work.g_N[i], work.w_N[i]
        for j in range(n):
            gamma[i] += work.W_N[i, j] * u[j]
    return True


@kernel
def set_tolerances(run):
    """Tolerances of the next step: atol + rtol times the largest value so far; of a gap and its rate, what follows."""
    tol, W_N, n = run.tol, run.contacts.work.W_N, run.contacts.q.shape[0]
    for i in range(tol.shape[0]):
        tol[i] = run.clock[ATOL] + run.clock[RTOL] * run.largest[i]
    for i in range(W_N.shape[0]):
        run.tol_g[i], run.tol_gamma[i] = 0.0, 0.0
        for j in range(n):
            run.tol_g[i] += abs(W_N[i, j]) * tol[j]
            run.tol_gamma[i] += abs(W_N[i, j]) * tol[n + j]
        lid = closed_gap(i, run)
        run.lid[i] = lid if run.g_0[i] <= lid else 0.0


@kernel
def closed_gap(i, run):
    """The gap below which contact i counts as closed: above what it moves in the shortest step."""
    return CLOSED * run.tol_g[i] + run.clock[LEAST] * abs(run.gamma_0[i])


@kernel
def first_landing(H, state, run):
    """Where in a smooth step the first open contact fell below its surface, or came near it and turned; 2 if none did.

    The step is to end where a gap turns: what the cubic says there is not exact, and a graze is decided by less.
    """
    first = 2.0
    for i in range(state.mode.shape[0]):
        if run.contacts.kinds[i, 0] != UNILATERAL or state.mode[i] != ContactMode.OPEN:
            continue
        c = H * run.gamma_0[i]
        b = 3.0 * (run.g_1[i] - run.g_0[i]) - H * (2.0 * run.gamma_0[i] + run.gamma_1[i])
        a = H * (run.gamma_0[i] + run.gamma_1[i]) - 2.0 * (run.g_1[i] - run.g_0[i])
        lowest = lowest_place(a, b, c)
        floor = min(0.0, run.g_0[i]) - closed_gap(i, run)
        least = run.g_0[i] + lowest * (c + lowest * (b + lowest * a))
        if run.g_1[i] < floor:
            first = min(first, falling_root(run.g_0[i], a, b, c, lowest if least < floor else 1.0))
        elif run.g_0[i] <= closed_gap(i, run):
            first = 0.0 if lowest > 0.0 and least < floor else first  # struck, but the step was too long for an impulse
        elif lowest > 0.0 and least < NEAR * min(run.g_0[i], run.g_1[i]):
            first = min(first, lowest)
    return first


@kernel
def lowest_place(a, b, c):
    """Where in [0, 1] the cubic s (c + s (b + s a)) has its inner minimum; 0 if it has none."""
    root = b * b - 3.0 * a * c
    if root <= 0.0:
        return 0.0
    root = math.sqrt(root)
    if b > 0.0:
        place = -c / (b + root)
    elif a != 0.0:
        place = (root - b) / (3.0 * a)
    else:
        return 0.0
    return place if 0.0 < place < 1.0 else 0.0


@kernel
def falling_root(g_0, a, b, c, place):
    """A zero in [0, place] of the cubic, which is negative at place; 0 if it is negative from the start."""
    if g_0 <= 0.0:
        return 0.0
    left, right = 0.0, place
    for _ in range(BISECTIONS):
        middle = 0.5 * (left + right)
        if g_0 + middle * (c + middle * (b + middle * a)) > 0.0:
            left = middle
        else:
            right = middle
    return left


@kernel
def next_landing(state, run):
    """The time until the first open contact will close with the acceleration it has; inf if none will."""
    first = math.inf
    for i in range(state.mode.shape[0]):
        if run.contacts.kinds[i, 0] != UNILATERAL or state.mode[i] != ContactMode.OPEN:
            continue
        if run.g_0[i] <= closed_gap(i, run):
            continue
        g, gamma, a = run.g_0[i], run.gamma_0[i], run.a_N[i]
        root = gamma * gamma - 2.0 * a * g
        if root < 0.0:
            continue
        root = math.sqrt(root)
        if gamma < 0.0:
            first = min(first, 2.0 * g / (root - gamma))
        elif a < 0.0:
            first = min(first, (gamma + root) / -a)
    return first
