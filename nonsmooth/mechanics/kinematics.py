"""Where the coordinates go: q' = B(t, q) u, or q' = u where a system has no kinematics.

    q_mid = q_0 + dt/2 B(t_0, q_0) u_0                           before the contact problem of a step
    q_1 = q_0 + dt B(t_mid, (q_0 + q_1)/2) ubar                  after it, ubar = (1 - theta) u_0 + theta u_1

The implicit mid-point rule keeps what is quadratic in q and constant along q' = B u, as |q| = 1 of a quaternion, for
every step, and is of second order. Its fixed point is found to rounding: an iteration leaves dt |dB/dq| |u|/2 of the
error, of a quaternion dt |omega|/4, until rounding keeps it from getting smaller.
Source: Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006), section IV.2.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.mechanics.sys import evaluate
from nonsmooth.mechanics.system import KINEMATICS

FIXED_POINT_SWEEPS = 40  # chosen: a body that turns by 1.6 rad in a step comes to rounding in as many


@kernel
def has_kinematics(sys):
    """Whether q' = B u is not q' = u."""
    return sys.has & (1 << KINEMATICS) != 0


@kernel
def move(sys, q, tau, u, work, out):
    """out = q + tau B u with work.B as it is, or q + tau u."""
    if has_kinematics(sys):
        move_along(sys, q, tau, u, work, out)
    else:
        for i in range(sys.n):
            out[i] = q[i] + tau * u[i]


@rare_kernel
def move_along(sys, q, tau, u, work, out):
    """out = q + tau B u."""
    for i in range(sys.n_q):
        rate = 0.0
        for j in range(sys.n):
            rate += work.B[i, j] * u[j]
        out[i] = q[i] + tau * rate


@kernel
def coordinate_rates(sys, u, work, out):
    """out[:n_q] = q' at the velocities u, with work.B as it is."""
    if has_kinematics(sys):
        rates_along(sys, u, work, out)
    else:
        for i in range(sys.n):
            out[i] = u[i]


@rare_kernel
def rates_along(sys, u, work, out):
    """out[:n_q] = B u."""
    for i in range(sys.n_q):
        out[i] = 0.0
        for j in range(sys.n):
            out[i] += work.B[i, j] * u[j]


@kernel
def find_kinematics(sys, t, q, u, work):
    """B at a state, to work.B; False if the function raised."""
    return not has_kinematics(sys) or evaluate(sys, KINEMATICS, t, q, u, work.B)


@rare_kernel
def find_mid_point(sys, t, dt, q, u, work):
    """work.q_mid, and work.B there; False if the function raised."""
    if not evaluate(sys, KINEMATICS, t, q, u, work.B):
        return False
    move_along(sys, q, 0.5 * dt, u, work, work.q_mid)
    return evaluate(sys, KINEMATICS, t + 0.5 * dt, work.q_mid, u, work.B)


@rare_kernel
def find_end(sys, t, dt, ubar, q, work):
    """q_1, to work.q_end; work.q_mid and work.B become those of the mid-point of q_0 and q_1. False if the function
    raised, or q_1 is not finite."""
    q_mid, q_end, before = work.q_mid, work.q_end, math.inf
    for _ in range(FIXED_POINT_SWEEPS):
        move_along(sys, q, dt, ubar, work, q_end)
        change = 0.0
        for i in range(sys.n_q):
            middle = 0.5 * (q[i] + q_end[i])
            change = max(change, abs(middle - q_mid[i]))
            q_mid[i] = middle
        if change == 0.0 or not change < before:
            break
        before = change
        if not evaluate(sys, KINEMATICS, t + 0.5 * dt, q_mid, ubar, work.B):
            return False
    total = 0.0
    for i in range(sys.n_q):
        total += 0.0 * q_end[i]
    return total == 0.0
