"""The motion within a step: the velocities a polynomial of degree 4, the coordinates its integral.

    u(t + theta h) = u_0 + sum_k B_k theta^k,    q(t + theta h) = q_0 + h (theta u_0 + sum_k B_k theta^(k+1)/(k+1))

Three of its five conditions are the ends, u_0, u_1 and q_1. The other two are the accelerations at both ends (Hermite):
then the error is of order 5 in h, as that of Radau IIA at the ends. Where the motion is stiffer than the step, an
acceleration says nothing of the motion within it; the polynomial would pass the stages by more than their tolerance,
and the collocation polynomial, of degree 3 through the stages, takes its place. It is of order 4 and damps as the
method does. Each coordinate decides for itself. Impulses and works keep the collocation polynomial.

Where q' = B u, coordinates are no integrals of velocities: each has the cubic through its values and rates at both
ends, which errs by h^4/384 of the fourth derivative.
Source: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I* (1993), section II.6.
Equations: docs/theory/event_driven.md, (3).
"""

from __future__ import annotations

from nonsmooth.integrators.radau.stages import DENSE, C
from nonsmooth.jit import kernel, rare_kernel

STEP_DEGREE = 4  # derived: of a polynomial by the five conditions above
CURVED_DEGREE = 3  # derived: by four, of coordinates that are no integrals
# chosen: tolerances of a component by which the stages, of order 3, may lie beside the polynomial. In smooth motion
# they do by a few: the error estimate of a step is of order 3 too.
BESIDE_STEP = 10.0


@kernel
def begin_polynomial(t, n, ode, steps):
    """Note the beginning of a step that is about to be accepted; B_1 = h u'_0."""
    m, n_q = steps.n_steps, steps.q.shape[1]
    h = ode.clock.done
    steps.t[m], steps.h[m] = t, h
    for i in range(n):
        steps.q[m, i], steps.u[m, i] = ode.x[i], ode.x[n_q + i]
        steps.B[m, 0, i] = h * ode.f_0[n_q + i]
    if goes_along(steps):
        for i in range(n_q):
            steps.q[m, i], steps.Q[m, 0, i] = ode.x[i], h * ode.f_0[i]


@kernel
def goes_along(steps):
    """Whether the coordinates have polynomials of their own."""
    return steps.Q.shape[1] > 0 and steps.Q.shape[2] > 0


@kernel
def end_polynomial(n, ode, steps):
    """Find B from the end of the step, which has been accepted."""
    m = steps.n_steps
    B, h = steps.B, steps.h[m]
    if goes_along(steps):
        end_along(m, n, ode, steps)
        n = 0
    for i in range(n):
        u_0 = steps.u[m, i]
        change = ode.x[n + i] - u_0
        mean = (ode.x[i] - steps.q[m, i]) / h - u_0
        first = B[m, 0, i]
        total, area, slope = change - first, mean - 0.5 * first, h * ode.f_0[n + i] - first
        B[m, 1, i] = 1.5 * slope - 12.0 * total + 30.0 * area
        B[m, 2, i] = -4.0 * slope + 28.0 * total - 60.0 * area
        B[m, 3, i] = 2.5 * slope - 15.0 * total + 30.0 * area
        reach = BESIDE_STEP * ode.scale[n + i]
        for s in range(2):
            if not abs(polynomial(m, i, C[s], steps) - ode.Z[s, n + i]) <= reach:
                collocate(m, i, change, mean, ode.Z[0, n + i], ode.Z[1, n + i], ode.Z[2, n + i], steps)
                break
    if steps.is_kept != 0:
        steps.n_steps += 1


@rare_kernel
def end_along(m, n, ode, steps):
    """The cubics of coordinates and velocities where q' = B u."""
    n_q = steps.q.shape[1]
    for i in range(n_q):
        end_cubic(m, i, i, ode.x[i] - steps.q[m, i], steps.h[m], ode, steps.Q)
    for i in range(n):
        end_cubic(m, i, n_q + i, ode.x[n_q + i] - steps.u[m, i], steps.h[m], ode, steps.B)
        steps.B[m, 3, i] = 0.0


@kernel
def end_cubic(m, i, j, change, h, ode, P):
    """The cubic P[m, :, i] of component j of the state, which has its first coefficient; beside the stages that
    through them, with what the state was moved at the end of the step spread over it."""
    first, last = P[m, 0, i], h * ode.f_0[j]
    P[m, 1, i], P[m, 2, i] = 3.0 * change - 2.0 * first - last, first + last - 2.0 * change
    reach = BESIDE_STEP * ode.scale[j]
    for s in range(2):
        value = C[s] * (P[m, 0, i] + C[s] * (P[m, 1, i] + C[s] * P[m, 2, i]))
        if not abs(value - ode.Z[s, j]) <= reach:
            for k in range(3):
                P[m, k, i] = DENSE[0][k] * ode.Z[0, j] + DENSE[1][k] * ode.Z[1, j] + DENSE[2][k] * ode.Z[2, j]
            P[m, 0, i] += change - ode.Z[2, j]
            break


@kernel
def collocate(m, i, change, mean, Z_1, Z_2, Z_3, steps):
    """The collocation polynomial; what the state was moved at the end of the step is spread over it."""
    B = steps.B
    area = 0.0
    for k in range(3):
        B[m, k, i] = DENSE[0][k] * Z_1 + DENSE[1][k] * Z_2 + DENSE[2][k] * Z_3
        area += B[m, k, i] / (k + 2.0)
    B[m, 3, i] = 0.0
    moved = change - Z_3
    bulge = 6.0 * (mean - area - 0.5 * moved)  # moved theta + bulge theta (1 - theta) has the area that is missing
    B[m, 0, i] += moved + bulge
    B[m, 1, i] -= bulge


@kernel
def polynomial(m, i, theta, steps):
    """u_i - u_0 at t + theta h of step m."""
    B = steps.B
    return theta * (B[m, 0, i] + theta * (B[m, 1, i] + theta * (B[m, 2, i] + theta * B[m, 3, i])))


@kernel
def state_within(m, theta, steps, x):
    """Write q and u at t + theta h of step m into the leading components of x."""
    n_q, n, B, h = steps.q.shape[1], steps.u.shape[1], steps.B, steps.h[m]
    along = goes_along(steps)
    for i in range(n_q if along else 0):
        Q = steps.Q
        x[i] = steps.q[m, i] + theta * (Q[m, 0, i] + theta * (Q[m, 1, i] + theta * Q[m, 2, i]))
    for i in range(0 if along else n):
        area = 0.2 * B[m, 3, i]
        area = 0.25 * B[m, 2, i] + theta * area
        area = B[m, 1, i] / 3.0 + theta * area
        area = 0.5 * B[m, 0, i] + theta * area
        x[i] = steps.q[m, i] + theta * h * (steps.u[m, i] + theta * area)
    for i in range(n):
        x[n_q + i] = steps.u[m, i] + polynomial(m, i, theta, steps)
