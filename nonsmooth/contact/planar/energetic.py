"""An impact of several contacts by the energetic law, each compressed and given back in its own time.

Every contact is a spring that is stiff beyond measure, all equally, so that their stiffness drops out with the unit of
time, and configuration and smooth forces take no part (Liu, Zhao, Brogliato; linear springs, bi-stiffness):

    d gamma/dt = G f,    dP/dt = f,    f_N >= 0
    d f_N/dt = -gamma_N          while gamma_N < 0: compression takes the work f_N^2/2
    d f_N/dt = -gamma_N/e^2      while gamma_N > 0 and f_N > 0: expansion gives e^2 of it back
    |f_F| <= mu f_N, opposed to gamma_F; what keeps gamma_F = 0, if the cone holds that much

It ends where no force is left and nothing approaches. With the work V = sum e^2 f_N^2/2 that can still be given back,
T + V never grows, and V is none before and after: T_+ <= T_-. One contact alone has f_N dt = dP, so the law of
mechanics/impact.py; so has each of several that nothing couples. Equal contacts of a symmetric body are equal in time.

In a mode all this is linear, so f and gamma are power series over a part of the least period; a step ends where a mode
does, found by bisection of the series. At given f_N the friction of contacts that do not slide is the least of a convex
quadratic function on the cones, which always exists: sweeps decide which of them hold. Sources: Liu, Zhao, Brogliato,
*Proc. R. Soc. A* 464 (2008) 3193 and 465 (2009) 1; Stronge, *Impact Mechanics* (2000), section 3.4; Nguyen, Brogliato,
*Multiple Impacts in Dissipative Granular Chains* (2014), chapter 4.
Equations: docs/theory/moreau_jean.md, (10) and (11).
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.mechanics.contact_problem import Work
from nonsmooth.mechanics.laws import LAW_E_N, friction_coefficient
from nonsmooth.mechanics.sys import Sys
from nonsmooth.numerics.dense import SINGULAR

SHOCK_TERMS = 20  # chosen: terms of a series: 1/20! is below rounding
LOOKS = 4  # chosen: times in a step at which a mode may be seen to have ended; a step is a sixth of a period at most
SERIES_ROUNDING = 1e-17  # chosen: of a force: what the last term of its series may be
SHOCK_HALVINGS = 60  # derived: of a step, to its last bit
STILL_IN_A_SHOCK = 1e-13  # chosen: of the largest velocity before: a velocity below this is none
JUST_AFTER = 1e-8  # chosen: of a step: the forces then decide what holds
HOLDING_SWEEPS = 10_000  # chosen: of Gauss-Seidel on the friction that holds
SETTLED_HOLD = 1e-15  # chosen: of the largest limit: what a last sweep may change
PHASES = 1000  # chosen: for each contact; a series of them converges like a geometric one

APART, COMPRESSED, EXPANDING = 0, 1, 2  # code: modes of a contact in the direction of its normal
HOLDS, NO_RUBBING = 0, 2  # code: friction beside the slides +1, -1: what holds, and where there is none


class Springs(Block, r="n * (1 + d)"):
    """Arrays of a shock. n = contacts, r = rows."""

    f: Array[Floats, SHOCK_TERMS + 1, "r"]  # series of the forces
    gamma: Array[Floats, SHOCK_TERMS + 2, "r"]  # and of the velocities
    ahead: Array[Floats, "r"]  # forces just after the beginning of a step
    mode: Array[Ints, "n"]
    slide: Array[Ints, "n"]  # sign of the sliding that friction opposes, or HOLDS, NO_RUBBING
    mu: Array[Floats, "n"]
    e: Array[Floats, "n"]
    factor: Array[Floats, "n", "n"]  # L D L^T of G in the rows that are held, 1/D on the diagonal
    held: Array[Ints, "n"]  # these rows
    n_held: int
    still: float  # velocity that is none


@kernel("int64(int64, int64, float64, int64, int64)", short_loops=True)
def spring_back(sys_at, n_k, slow, work_at, springs_at):
    """The impulses of the shock from work.gamma_0, to work.shock; normal velocities within ``slow`` are none. 0 where
    they have no end."""
    sys, work, springs = view(sys_at, Sys), view(work_at, Work), view(springs_at, Springs)
    begin(sys, n_k, slow, work, springs)
    for _ in range(PHASES * n_k):
        if is_over(n_k, springs):
            break
        choose_friction(n_k, work, springs)
        dt = expand_in_time(n_k, work, springs)
        dt = first_change(n_k, dt, work, springs)
        move_on(n_k, dt, work, springs)
    for a in range(work.start[n_k]):
        if not abs(work.shock[a]) < math.inf:
            return 0
    return 1


@kernel
def begin(sys, n_k, slow, work, springs):
    """Velocities before, no forces, and the coefficients."""
    start, largest = work.start, 0.0
    for a in range(start[n_k]):
        springs.gamma[0, a], springs.f[0, a], work.shock[a] = work.gamma_0[a], 0.0, 0.0
        largest = max(largest, abs(work.gamma_0[a]))
    springs.still = STILL_IN_A_SHOCK * largest
    for k in range(n_k):
        a = start[k]
        if abs(springs.gamma[0, a]) <= slow:
            springs.gamma[0, a] = 0.0
        springs.mode[k] = COMPRESSED if springs.gamma[0, a] < -springs.still else APART
        springs.e[k], springs.mu[k] = sys.laws[work.closed[k], LAW_E_N], 0.0
        if start[k + 1] > a + 1:
            springs.mu[k] = friction_coefficient(work.laws, k, abs(work.gamma_0[a + 1]))


@kernel
def is_over(n_k, springs):
    """Whether no contact presses."""
    for k in range(n_k):
        if springs.mode[k] != APART:
            return False
    return True


@kernel
def rate_of(k, springs):
    """-d f_N/dt over gamma_N: the stiffness of contact k in its mode."""
    return 1.0 if springs.mode[k] == COMPRESSED else 1.0 / (springs.e[k] * springs.e[k])


@kernel
def time_unit(n_k, work, springs):
    """Less than the inverse of the largest frequency."""
    start, square = work.start, 0.0
    for k in range(n_k):
        if springs.mode[k] == APART:
            continue
        total, a = 0.0, start[k]
        for m in range(n_k):
            total += abs(work.G[a, start[m]])
            if start[m + 1] > start[m] + 1:
                total += springs.mu[m] * abs(work.G[a, start[m] + 1])
        square = max(square, rate_of(k, springs) * total)
    return 1.0 / math.sqrt(square)


@kernel
def choose_friction(n_k, work, springs):
    """What friction does from now on at each contact: oppose a slide, or one that it cannot prevent, or hold."""
    start, ahead, slide, most = work.start, springs.ahead, springs.slide, 0.0
    dt = JUST_AFTER * time_unit(n_k, work, springs)
    for k in range(n_k):
        a = start[k]
        ahead[a], slide[k] = 0.0, NO_RUBBING
        if start[k + 1] > a + 1:
            ahead[a + 1] = 0.0
        if springs.mode[k] == APART:
            continue
        ahead[a] = springs.f[0, a] - dt * rate_of(k, springs) * springs.gamma[0, a]
        if start[k + 1] == a + 1 or springs.mu[k] == 0.0:
            continue
        if abs(springs.gamma[0, a + 1]) <= 2.0 * springs.still:
            springs.gamma[0, a + 1], slide[k] = 0.0, HOLDS
            most = max(most, springs.mu[k] * ahead[a])
        else:
            slide[k] = 1 if springs.gamma[0, a + 1] > 0.0 else -1
            ahead[a + 1] = -slide[k] * springs.mu[k] * ahead[a]
    for _ in range(HOLDING_SWEEPS):
        change = 0.0
        for k in range(n_k):
            if slide[k] == HOLDS:
                change = max(change, abs(hold(k, n_k, work, springs)))
        if change <= SETTLED_HOLD * most:
            break
    let_go(n_k, work, springs)


@kernel
def hold(k, n_k, work, springs):
    """The friction that keeps contact k from sliding, as far as it may; returns its change."""
    t, ahead = work.start[k] + 1, springs.ahead
    pull = 0.0
    for b in range(work.start[n_k]):
        pull += work.G[t, b] * ahead[b]
    limit, before = springs.mu[k] * ahead[t - 1], ahead[t]
    if work.G[t, t] > 0.0:
        ahead[t] = min(limit, max(-limit, before - pull / work.G[t, t]))
    return ahead[t] - before


@kernel
def let_go(n_k, work, springs):
    """Contacts whose friction is at its limit begin to slide; G of the others, which hold, is factorised. Rows that
    follow from others carry nothing."""
    springs.n_held = 0
    for k in range(n_k):
        if springs.slide[k] != HOLDS:
            continue
        t = work.start[k] + 1
        if abs(springs.ahead[t]) >= springs.mu[k] * springs.ahead[t - 1]:
            springs.slide[k] = -1 if springs.ahead[t] > 0.0 else 1
            continue
        springs.held[springs.n_held] = t
        springs.n_held += 1
    L = springs.factor
    for i in range(springs.n_held):
        row = springs.held[i]
        for j in range(i):
            total = work.G[row, springs.held[j]]
            for m in range(j):
                total -= L[i, m] * L[j, m]
            L[i, j] = total
        total = work.G[row, row]
        for m in range(i):
            scaled = L[i, m]
            L[i, m] = scaled * L[m, m]
            total -= scaled * L[i, m]
        L[i, i] = 1.0 / total if total > SINGULAR * work.G[row, row] else 0.0


@kernel
def expand_in_time(n_k, work, springs):
    """The series of forces and velocities; returns how long they hold."""
    start, f, gamma = work.start, springs.f, springs.gamma
    for order in range(SHOCK_TERMS + 1):
        if order > 0:
            for k in range(n_k):
                a = start[k]
                f[order, a] = 0.0
                if springs.mode[k] != APART:
                    f[order, a] = -rate_of(k, springs) * gamma[order - 1, a] / order
        rub_along(order, n_k, work, springs)
        for a in range(start[n_k]):
            gamma[order + 1, a] = 0.0
        for b in range(start[n_k]):
            if f[order, b] != 0.0:
                for a in range(start[n_k]):
                    gamma[order + 1, a] += work.G[b, a] * f[order, b] / (order + 1)
    dt = time_unit(n_k, work, springs)
    size, last = 0.0, 0.0
    for a in range(start[n_k]):
        size, last = max(size, abs(f[0, a]) + dt * abs(f[1, a])), max(last, abs(f[SHOCK_TERMS, a]))
    while last * dt**SHOCK_TERMS > SERIES_ROUNDING * size:
        dt *= 0.5
    return dt


@kernel
def rub_along(order, n_k, work, springs):
    """The friction of this order from the normal forces of this order."""
    start, f, held, L = work.start, springs.f, springs.held, springs.factor
    for k in range(n_k):
        if start[k + 1] > start[k] + 1:
            is_sliding = springs.slide[k] != HOLDS and springs.slide[k] != NO_RUBBING
            f[order, start[k] + 1] = -springs.slide[k] * springs.mu[k] * f[order, start[k]] if is_sliding else 0.0
    for i in range(springs.n_held):
        pull = 0.0
        for b in range(start[n_k]):
            pull += work.G[held[i], b] * f[order, b]
        springs.ahead[held[i]] = -pull
    for i in range(springs.n_held):
        for j in range(i):
            springs.ahead[held[i]] -= L[i, j] * springs.ahead[held[j]]
    for i in range(springs.n_held - 1, -1, -1):
        springs.ahead[held[i]] *= L[i, i]
        for j in range(i + 1, springs.n_held):
            springs.ahead[held[i]] -= L[j, i] * springs.ahead[held[j]]
    for i in range(springs.n_held):
        f[order, held[i]] = springs.ahead[held[i]]


@kernel
def value(series, n, a, t):
    """The series of row a at time t, n its highest power."""
    total = series[n, a]
    for order in range(n - 1, -1, -1):
        total = total * t + series[order, a]
    return total


@kernel
def has_changed(n_k, t, work, springs):
    """Whether a contact has left its mode by time t."""
    for k in range(n_k):
        a = work.start[k]
        normal = value(springs.gamma, SHOCK_TERMS + 1, a, t)
        if springs.mode[k] == COMPRESSED and normal > springs.still:
            return True
        if springs.mode[k] != COMPRESSED and normal < -springs.still:
            return True
        if springs.mode[k] == EXPANDING and value(springs.f, SHOCK_TERMS, a, t) < 0.0:
            return True
        if springs.slide[k] == NO_RUBBING:
            continue
        if springs.slide[k] == HOLDS:
            limit = springs.mu[k] * value(springs.f, SHOCK_TERMS, a, t)
            if abs(value(springs.f, SHOCK_TERMS, a + 1, t)) > limit * (1.0 + STILL_IN_A_SHOCK):
                return True
        elif springs.slide[k] * value(springs.gamma, SHOCK_TERMS + 1, a + 1, t) < -springs.still:
            return True
    return False


@kernel
def first_change(n_k, dt, work, springs):
    """When the first contact leaves its mode, at most dt."""
    before, after = 0.0, dt
    for look in range(1, LOOKS + 1):
        after = dt * look / LOOKS
        if has_changed(n_k, after, work, springs):
            break
        before = after
    if before == after:
        return dt
    for _ in range(SHOCK_HALVINGS):
        middle = 0.5 * (before + after)
        if has_changed(n_k, middle, work, springs):
            after = middle
        else:
            before = middle
    return after


@kernel
def move_on(n_k, dt, work, springs):
    """Impulses, velocities and normal forces after dt, and the modes of the normals."""
    f, gamma, mode = springs.f, springs.gamma, springs.mode
    for a in range(work.start[n_k]):
        total = 0.0
        for order in range(SHOCK_TERMS, -1, -1):
            total = total * dt + f[order, a] / (order + 1)
        work.shock[a] += total * dt
    for k in range(n_k):
        a = work.start[k]
        force = value(f, SHOCK_TERMS, a, dt)
        for b in range(a, work.start[k + 1]):
            gamma[0, b] = value(gamma, SHOCK_TERMS + 1, b, dt)
        if mode[k] == COMPRESSED and gamma[0, a] > springs.still:
            mode[k] = EXPANDING
        elif mode[k] != COMPRESSED and gamma[0, a] < -springs.still:
            mode[k] = COMPRESSED
        elif mode[k] == EXPANDING and force <= 0.0:
            mode[k] = APART
        f[0, a] = 0.0 if mode[k] == APART else max(0.0, force)
