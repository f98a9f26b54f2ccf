"""The motion within an adaptive step: the velocities a polynomial, the coordinates its integral (results/motion.py).

    u(t + theta H) = u_0 + sum_k B_k theta^k,    k = 1 ... 2 L + 2

A smooth step gives u_0, u_1, q_1 and the first L derivatives of u at both ends, L = 3 if it took four rows or more.
They are extrapolated from the rows of the table. With the velocities u^0, u^1, ..., u^m between m substeps

    m (u^1 - u^0) = H u'_0 + ...,           m (u^2 - u^1) = H u'_0 + 3/(2 m) H^2 u''_0 + ...,
    m^2 (u^3 - 2 u^2 + u^1) = H^2 u''_0 + 2/m H^3 u'''_0 + ...,    and backwards at the end,

with errors in all powers of 1/m. Only the first of them may hold u^0: what the velocity of a closed contact errs by,
O(1/m^2), sets in with the first substep.

Without q_1 the velocities would be a polynomial of a degree less, off by B_(2L+2) theta^(L+1) (1 - theta)^(L+1): that
estimates, from above, what they err by within the step, B_(2L+2)/4^(L+1) at most, and the coordinates, its integral. A
step is as long as both are within FOLLOWED_ERROR tolerances.

In a step with an event each substep is a piece of its own: a parabola, or where an impact is in it two straight lines
with the acceleration before the step, and the jump half-way between, as the substep has it.
Source: Hairer, Ostermann, *Numer. Math.* 58 (1990) 419; Hairer, Nørsett, Wanner, *Solving Ordinary Differential
Equations I* (1993), section II.9: the estimate, and its bound.
"""

from __future__ import annotations

import functools
import math
from fractions import Fraction

import numpy as np

from nonsmooth.integrators.adaptive.state import MOST_DERIVATIVES, VELOCITY_DEGREE, aitken_neville
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.integrators.records import EVENT_KIND, EVENT_T, IMPACT
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.numerics.rounding import rounded_sum

STEP_PIECES = 4  # chosen: of a step with an event, at most
FOLLOWED_ERROR = 10.0  # measured: tolerances, as in ODEX: the estimate is 2 to 15 times the error
COEFFICIENT_ROUNDINGS = 20_000  # chosen: roundings of a velocity: what its highest coefficient has of them
# The slopes of a row, at the beginning and at the end, and the first row that has each.
FIRST_0, NEXT_0, SECOND_0, FIRST_1, SECOND_1 = range(5)
FIRST_ROWS = (0, 1, 2, 1, 2)  # derived: the first row of the table that each of these has a value of


@functools.cache
def slope_weights() -> np.ndarray:
    """(5, ROWS, ROWS): the weights of the rows in each slope."""
    return np.array([aitken_neville(first) for first in FIRST_ROWS])


@functools.cache
def highest_coefficients() -> np.ndarray:
    """(M + 1, M + 2, M + 2), M = MOST_DERIVATIVES: for L derivatives at an end, B_(L+1) ... B_(2L+2) from what the
    terms of lower degree leave of u - u_0 and its L derivatives at the end, and of the mean of u - u_0."""
    inverses = np.zeros((MOST_DERIVATIVES + 1, MOST_DERIVATIVES + 2, MOST_DERIVATIVES + 2))
    for L in range(1, MOST_DERIVATIVES + 1):
        degrees = range(L + 1, 2 * L + 3)
        rows = [[Fraction(math.perm(k, order)) for k in degrees] for order in range(L + 1)]
        rows.append([Fraction(1, k + 1) for k in degrees])
        inverses[L, : L + 2, : L + 2] = inverse(rows)
    return inverses


def inverse(A: list[list[Fraction]]) -> np.ndarray:
    """The inverse of a matrix with regular leading minors, by elimination without rounding."""
    n = len(A)
    rows = [[*row, *(Fraction(int(a == b)) for b in range(n))] for a, row in enumerate(A)]
    for a in range(n):
        rows[a] = [x / rows[a][a] for x in rows[a]]
        for b in range(n):
            if b != a:
                factor = rows[b][a]
                rows[b] = [x - factor * y for x, y in zip(rows[b], rows[a], strict=True)]
    return np.array([row[n:] for row in rows], dtype=float)


@kernel
def note_slopes(j, n, run):
    """What row j, of j + 1 substeps, says of the derivatives."""
    u, m, slopes = run.node_u, j + 1, run.slopes
    for i in range(n):
        slopes[j, FIRST_0, i] = m * (u[1, i] - run.begin_u[0, i])
        slopes[j, FIRST_1, i] = m * (u[m, i] - run.begin_u[m - 1, i])
        if m > 1:
            slopes[j, NEXT_0, i] = m * (u[2, i] - u[1, i])
        if m > 2:
            slopes[j, SECOND_0, i] = m * m * (u[3, i] - 2.0 * u[2, i] + u[1, i])
            slopes[j, SECOND_1, i] = m * m * (u[m, i] - 2.0 * u[m - 1, i] + u[m - 2, i])


@rare_kernel
def fit_polynomial(H, j, state, run):
    """run.B: the motion of a step that converged at row j, from the state to run.x."""
    n, L = state.q.shape[0], min(j, MOST_DERIVATIVES)
    B, left, ends = run.B, run.left, run.ends
    for i in range(n):
        find_derivatives(i, j, run)
        left[0] = run.x[n + i] - state.u[i]
        left[L + 1] = mean_velocity(i, H, state, run) - state.u[i]
        for order in range(1, L + 1):
            left[order] = ends[1, order]
        for k in range(VELOCITY_DEGREE):
            B[k, i] = 0.0
        factorial = 1.0
        for k in range(1, L + 1):
            factorial *= k
            term = ends[0, k] / factorial
            B[k - 1, i] = term
            left[L + 1] -= term / (k + 1)
            for order in range(L + 1):
                left[order] -= term
                term *= k - order
        for a in range(L + 2):
            for b in range(L + 2):
                B[L + a, i] += run.highest[L, a, b] * left[b]


@kernel
def followed_growth(H, j, state, run):
    """How many times as long a step that converged at row j, and was fitted, could be for the motion within it to be
    followed."""
    n, L, tol = state.q.shape[0], min(j, MOST_DERIVATIVES), run.tol
    highest = 2 * L + 1
    in_u, in_q = 1.0, 1.0 / (2 * L + 3)  # (1/4)^(L+1) and (L+1)!^2/(2L+3)!
    for k in range(1, L + 2):
        in_u *= 0.25
        in_q *= k / (L + 1.0 + k)
    error = 0.0
    for i in range(n):
        size = abs(run.B[highest, i])
        rounding = rounded_sum(COEFFICIENT_ROUNDINGS, run.largest[n + i])
        error = max(error, in_q * H * size / (tol[i] + H * rounding), in_u * size / (tol[n + i] + rounding))
    return (FOLLOWED_ERROR / error) ** (1.0 / (highest + 1)) if error > 0.0 else math.inf


@kernel
def mean_velocity(i, H, state, run):
    """(q_1 - q_0)/H of coordinate i, without the rounding of the coordinates, which is much in short steps."""
    change = run.change[i]
    moved = run.x[i] - (state.q[i] + change)
    if abs(moved) > rounded_sum(VELOCITY_ROUNDINGS, max(abs(run.x[i]), abs(state.q[i]))):
        change += moved
    return change / H


@kernel
def state_within(theta, H, state, run):
    """run.y: the state at the part theta of the step that was fitted."""
    n, B, y = state.q.shape[0], run.B, run.y
    for i in range(n):
        u, area = 0.0, 0.0
        for k in range(VELOCITY_DEGREE - 1, -1, -1):
            u = theta * (B[k, i] + u)
            area = B[k, i] / (k + 2.0) + theta * area
        y[i] = state.q[i] + theta * H * (state.u[i] + theta * area)
        y[n + i] = state.u[i] + u


@kernel
def keep_smooth(t, H, state, run, steps):
    """Append the motion of the step that was fitted, from the state."""
    s = steps.n_steps
    steps.t[s], steps.h[s] = t, H
    for i in range(state.q.shape[0]):
        steps.q[s, i], steps.u[s, i] = state.q[i], state.u[i]
        for k in range(VELOCITY_DEGREE):
            steps.B[s, k, i] = run.B[k, i]
    steps.n_steps += 1


@kernel
def find_derivatives(i, j, run):
    """H u', H^2 u'', H^3 u''' of velocity i at both ends, from the rows up to j."""
    ends = run.ends
    ends[0, 1] = extrapolated(FIRST_0, 0.0, 0.0, i, j, run)
    ends[0, 2] = extrapolated(NEXT_0, ends[0, 1], 1.5, i, j, run)
    ends[0, 3] = extrapolated(SECOND_0, ends[0, 2], 2.0, i, j, run)
    ends[1, 1] = extrapolated(FIRST_1, 0.0, 0.0, i, j, run)
    ends[1, 2] = extrapolated(SECOND_1, 0.0, 0.0, i, j, run)
    ends[1, 3] = extrapolated(SECOND_1, ends[1, 2], -1.0, i, j, run)


@kernel
def extrapolated(which, lower, place, i, j, run):
    """A slope of velocity i at the end of the step, from the rows up to j that have it; or its derivative there, from
    the value ``lower`` at the end and those that lie ``place`` substeps from it."""
    total = 0.0
    for k in range(j + 1):
        value = run.slopes[k, which, i]
        if place != 0.0:
            value = (value - lower) * (k + 1) / place
        total += run.slope_shares[which, j, k] * value
    return total


@kernel
def keep_event(t, H, state, run, steps):
    """Append the pieces of a step of two substeps, from the state to run.x."""
    n, dt, piece = state.q.shape[0], 0.5 * H, run.piece
    for k in range(2):
        for i in range(n):
            piece[0, i], piece[1, i] = run.node_q[k, i], run.begin_u[k, i]
            piece[2, i], piece[3, i] = run.node_q[k + 1, i], run.node_u[k + 1, i]
            if k == 1:
                piece[2, i], piece[3, i] = run.x[i], run.x[n + i]
        if has_impact(t + k * dt, run.trial):
            split(t + k * dt, dt, n, run, steps)
        else:
            keep_parabola(t + k * dt, dt, n, piece, steps)


@kernel
def has_impact(t, trial):
    """Whether an impact is in the substep that begins at t."""
    for e in range(trial.counters.n_events):
        if trial.events[e, EVENT_T] == t and trial.events[e, EVENT_KIND] == IMPACT:
            return True
    return False


@kernel
def split(t, dt, n, run, steps):
    """Append the two halves of a substep with an impact."""
    piece, a, half = run.piece, run.a_0, 0.5 * dt
    for i in range(n):
        piece[4, i], piece[5, i] = piece[2, i], piece[3, i]
        piece[2, i] = piece[0, i] + half * (piece[1, i] + 0.5 * half * a[i])
        piece[3, i] = piece[1, i] + half * a[i]
    keep_parabola(t, half, n, piece, steps)
    for i in range(n):
        piece[0, i], piece[1, i] = piece[2, i], piece[5, i] - half * a[i]
        piece[2, i], piece[3, i] = piece[4, i], piece[5, i]
    keep_parabola(t + half, half, n, piece, steps)


@kernel
def keep_parabola(t, h, n, piece, steps):
    """Append the piece from (q, u) = piece[0:2] to piece[2:4] whose velocities are a parabola."""
    s = steps.n_steps
    steps.t[s], steps.h[s] = t, h
    for i in range(n):
        steps.q[s, i], steps.u[s, i] = piece[0, i], piece[1, i]
        change, mean = piece[3, i] - piece[1, i], (piece[2, i] - piece[0, i]) / h - piece[1, i]
        steps.B[s, 0, i] = 6.0 * mean - 2.0 * change
        steps.B[s, 1, i] = 3.0 * change - 6.0 * mean
        for k in range(2, VELOCITY_DEGREE):
            steps.B[s, k, i] = 0.0
    steps.n_steps += 1
