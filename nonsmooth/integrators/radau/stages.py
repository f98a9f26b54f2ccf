"""The stages of Radau IIA of order 5: Jacobian, factors, Newton's method, error estimate.

    Z_i = h sum_j a_ij f(t + c_j h, x_0 + Z_j),    x_1 = x_0 + Z_3,    i = 1, 2, 3

Newton's method on the three stages is split by the eigenvalues of A^-1 into one real and one complex system. The
leading m components may be kinematic, x_i' = x_(m+i), i < m (positions): they are eliminated, so that a mechanical
system with n velocities solves n rows, not 2n. Trailing components may be quadratures, on which f does not depend
(impulses, works).

The method damps what is infinitely stiff, growing modes too: of a saddle it would quietly make a stable motion. So a
step is refused where det(gamma/h - J) < 0, that is where an odd number of real eigenvalues of J exceed gamma/h =
3.64/h. Source: Hairer, Wanner, *Solving Ordinary Differential Equations II* (1996), sections IV.8 (RADAU5) and II.8.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.errors import Status
from nonsmooth.jit import Callback, kernel
from nonsmooth.jit.blocks import Block, Floats, Handle, Ints, view
from nonsmooth.numerics.complex_dense import complex_lu, complex_lu_solve
from nonsmooth.numerics.dense import lu, lu_solve
from nonsmooth.numerics.rounding import EPS, FORWARD_INCREMENT

S6 = math.sqrt(6.0)  # derived: of the nodes of Radau IIA
# defined: nodes, weights of the stages of Radau IIA with three stages; Hairer and Wanner, table IV.5.6
C = ((4.0 - S6) / 10.0, (4.0 + S6) / 10.0, 1.0)
# defined: of the same method
A = (
    ((88.0 - 7.0 * S6) / 360.0, (296.0 - 169.0 * S6) / 1800.0, (-2.0 + 3.0 * S6) / 225.0),
    ((296.0 + 169.0 * S6) / 1800.0, (88.0 + 7.0 * S6) / 360.0, (-2.0 - 3.0 * S6) / 225.0),
    ((16.0 - S6) / 36.0, (16.0 + S6) / 36.0, 1.0 / 9.0),
)
# derived: A^-1 = T diag(GAMMA, block(ALPHA, BETA)) T^-1
GAMMA = 3.0 + 3.0 ** (2.0 / 3.0) - 3.0 ** (1.0 / 3.0)
# derived: the pair of complex eigenvalues of A^-1; Hairer and Wanner, IV.8
ALPHA = 3.0 + 0.5 * (3.0 ** (1.0 / 3.0) - 3.0 ** (2.0 / 3.0))
BETA = -0.5 * (3.0 ** (5.0 / 6.0) + 3.0 ** (7.0 / 6.0))  # derived: their imaginary part
# derived: eigenvectors of A^-1, as in RADAU5
T = (
    (0.09443876248897524, -0.14125529502095421, 0.03002919410514742),
    (0.25021312296533332, 0.20412935229379994, -0.38294211275726192),
    (1.0, 1.0, 0.0),
)
# derived: its inverse
T_INVERSE = (
    (4.17871859155190428, 0.32768282076106237, 0.52337644549944951),
    (-4.17871859155190428, -0.32768282076106237, 0.47662355450055044),
    (0.50287263494578682, -2.57192694985560522, 0.59603920482822492),
)
# derived: weights of the stages in the estimate of the error; Hairer and Wanner, IV.8
ERROR = ((-13.0 - 7.0 * S6) / 3.0, (-13.0 + 7.0 * S6) / 3.0, -1.0 / 3.0)
# derived: x(t + theta h) = x_0 + sum_k theta^(k+1) sum_i Z_i DENSE_ik, the collocation polynomial
DENSE = (
    (13.0 / 3.0 + 7.0 * S6 / 3.0, -23.0 / 3.0 - 22.0 * S6 / 3.0, 10.0 / 3.0 + 5.0 * S6),
    (13.0 / 3.0 - 7.0 * S6 / 3.0, -23.0 / 3.0 + 22.0 * S6 / 3.0, 10.0 / 3.0 - 5.0 * S6),
    (1.0 / 3.0, -8.0 / 3.0, 10.0 / 3.0),
)

NEWTON_ITERATIONS = 6  # chosen: of the stages, one less than RADAU5 takes: a step that needs more is too long
# chosen: a change of the stages, of their tolerance, that stands for rounding where it no longer shrinks
STALLED_CHANGE = 0.03


# rates(address, sys, context, t, x, out) -> Status writes x'; sys and context are handed through
RATES = "int64(int64, int64, float64, float64[::1], float64[::1])"
rates_at = Callback(RATES)


class RadauClock(Block):
    """Times and step sizes [s], and the relative tolerance."""

    now: float  # time of x
    step: float  # that the error asks for
    done: float  # the step that was tried
    step_old: float  # and the one before
    error_old: float  # its error, in tolerances
    factored: float  # the step that the factors are of
    rtol: float
    limit: float  # the longest step that is tried


class RadauFlags(Block):
    """0 or 1, but for the last."""

    has_rates: int  # f_0 is of this x
    has_jacobian: int  # J exists
    is_current: int  # J is of this x
    is_worn: int  # J is to be renewed
    has_dense: int  # ``dense`` holds the step before
    refusal: int  # the Status of rates that refused a state which a step tried


class RadauCounters(Block):
    """What the integrator did."""

    accepted: int
    rejected: int
    evaluations: int
    jacobians: int
    factorisations: int


class Radau(Block, N="n + quadratures", k="n - m"):
    """Arrays of the integrator. N components, n of them implicit, k = n - m of these not kinematic."""

    rates: Handle  # of ``rates_at``
    context: Handle  # what the rates and the event functions are handed
    clock: RadauClock
    flags: RadauFlags
    counters: RadauCounters
    x: Array[Floats, "N"]
    x_1: Array[Floats, "N"]  # end of the step that was tried
    f_0: Array[Floats, "N"]  # rates at x
    atol: Array[Floats, "n"]
    scale: Array[Floats, "n"]  # atol + rtol |x|
    Z: Array[Floats, 3, "N"]
    F: Array[Floats, 3, "N"]  # rates at the stages
    W: Array[Floats, 3, "n"]  # T^-1 Z
    dense: Array[Floats, 3, "N"]  # coefficients of the step before
    J: Array[Floats, "n", "n"]
    real: Array[Floats, "k", "k"]  # factors of gamma/h - J, kinematic components eliminated
    re: Array[Floats, "k", "k"]  # factors of (alpha + i beta)/h - J
    im: Array[Floats, "k", "k"]
    order: Array[Ints, "k"]
    order_c: Array[Ints, "k"]
    trial: Array[Floats, "N"]  # scratch
    f: Array[Floats, "N"]  # scratch
    a: Array[Floats, "n"]  # scratch, and so on
    b: Array[Floats, "n"]
    c: Array[Floats, "n"]
    d: Array[Floats, "n"]
    v: Array[Floats, "k"]
    w: Array[Floats, "k"]
    y: Array[Floats, "k"]
    z: Array[Floats, "k"]


@kernel
def jacobian(sys, ode):
    """J = df/dx by forward differences; the rows of kinematic components are known."""
    n, m = ode.W.shape[1], ode.W.shape[1] - ode.real.shape[0]
    clock, x, f, f_0, J = ode.clock, ode.x, ode.f, ode.f_0, ode.J
    for j in range(n):
        x_j = x[j]
        x[j] = x_j + FORWARD_INCREMENT * max(abs(x_j), ode.atol[j] / clock.rtol)
        step = x[j] - x_j
        status = rates_at(ode.rates, sys, ode.context, clock.now, x, f)
        x[j] = x_j
        if status != Status.RUNNING:
            return status
        for i in range(m, n):
            J[i, j] = (f[i] - f_0[i]) / step
    ode.counters.evaluations += n
    ode.counters.jacobians += 1
    ode.flags.has_jacobian = 1
    ode.flags.is_current = 1
    clock.factored = 0.0
    return Status.RUNNING.value


@kernel
def factorise(h, ode):
    """LU factors of gamma/h - J and (alpha + i beta)/h - J; False where one is singular or the step sees a saddle."""
    n, k = ode.W.shape[1], ode.real.shape[0]
    m = n - k
    J, real, re, im = ode.J, ode.real, ode.re, ode.im
    e = GAMMA / h
    a, b = ALPHA / h, BETA / h
    size = a * a + b * b
    for i in range(k):
        for j in range(k):
            stiffness = J[m + i, j] if j < m else 0.0  # 1/(a + ib) = (a - ib)/size
            real[i, j] = -J[m + i, m + j] - stiffness / e
            re[i, j] = -J[m + i, m + j] - stiffness * a / size
            im[i, j] = stiffness * b / size
        real[i, i] += e
        re[i, i] += a
        im[i, i] += b
    ode.counters.factorisations += 1
    ode.clock.factored = 0.0
    if not lu(k, real, ode.order) or not complex_lu(k, re, im, ode.order_c):
        return False
    if not determinant_is_positive(k, real, ode.order, ode.v):
        return False
    ode.clock.factored = h
    return True


@kernel
def determinant_is_positive(n, A, order, seen):
    """The sign of a determinant from the LU factors: signs of the pivots, parity of the row order."""
    is_positive = True
    for i in range(n):
        seen[i] = 0.0
        if A[i, i] < 0.0:
            is_positive = not is_positive
    for i in range(n):
        j = i
        length = 0
        while seen[j] == 0.0:
            seen[j] = 1.0
            j = order[j]
            length += 1
        if length > 0 and length % 2 == 0:
            is_positive = not is_positive
    return is_positive


@kernel
def guess_stages(h, ode):
    """Z from the polynomial of the step before, else zero; W = T^-1 Z."""
    n = ode.W.shape[1]
    Z, W, dense, clock = ode.Z, ode.W, ode.dense, ode.clock
    has_dense = ode.flags.has_dense != 0
    for s in range(3):
        theta = 1.0 + C[s] * h / clock.step_old if has_dense else 1.0
        for i in range(n):
            Z[s, i] = 0.0
            if has_dense:
                end = dense[0, i] + dense[1, i] + dense[2, i]
                Z[s, i] = theta * (dense[0, i] + theta * (dense[1, i] + theta * dense[2, i])) - end
    for s in range(3):
        for i in range(n):
            W[s, i] = T_INVERSE[s][0] * Z[0, i] + T_INVERSE[s][1] * Z[1, i] + T_INVERSE[s][2] * Z[2, i]


@kernel("Tuple((boolean, int64, float64))(int64, float64, int64)", short_loops=True)
def newton(sys, h, ode_at):
    """Solve the stages by Newton's method; returns (converged, iterations, rate of convergence)."""
    ode = view(ode_at, Radau)
    n, N = ode.W.shape[1], ode.x.shape[0]
    clock, x, Z, W, F, trial, f = ode.clock, ode.x, ode.Z, ode.W, ode.F, ode.trial, ode.f
    tolerance = max(10.0 * EPS / clock.rtol, min(0.03, math.sqrt(clock.rtol)))
    rate, before = 0.0, 0.0
    for iteration in range(NEWTON_ITERATIONS):
        for s in range(3):
            for i in range(N):
                trial[i] = x[i] + Z[s, i] if i < n else x[i]
            status = rates_at(ode.rates, sys, ode.context, clock.now + C[s] * h, trial, f)
            ode.counters.evaluations += 1
            if status != Status.RUNNING:
                ode.flags.refusal = status
                return False, iteration, rate
            for i in range(N):
                F[s, i] = f[i]
        change = newton_update(h, ode)
        if not math.isfinite(change):
            return False, iteration, rate
        for s in range(3):
            for i in range(n):
                Z[s, i] = T[s][0] * W[0, i] + T[s][1] * W[1, i] + T[s][2] * W[2, i]
        left_over = change
        if iteration > 0:
            rate = change / before
            if rate > 0.5 and change < STALLED_CHANGE:
                return True, iteration + 1, rate
            left = NEWTON_ITERATIONS - 1 - iteration
            if not rate < 1.0 or rate**left / (1.0 - rate) * change > tolerance:
                return False, iteration, rate
            left_over = rate / (1.0 - rate) * change
        if left_over < tolerance:
            return True, iteration + 1, rate
        before = change
    return False, NEWTON_ITERATIONS, rate


@kernel
def newton_update(h, ode):
    """W += (A^-1/h - J)^-1 (f - A^-1/h Z) in the transformed variables; returns the norm of the change."""
    n = ode.W.shape[1]
    W, F, a, b, c, scale = ode.W, ode.F, ode.a, ode.b, ode.c, ode.scale
    e, alpha, beta = GAMMA / h, ALPHA / h, BETA / h
    for i in range(n):
        f_1, f_2, f_3 = F[0, i], F[1, i], F[2, i]
        a[i] = T_INVERSE[0][0] * f_1 + T_INVERSE[0][1] * f_2 + T_INVERSE[0][2] * f_3 - e * W[0, i]
        b[i] = T_INVERSE[1][0] * f_1 + T_INVERSE[1][1] * f_2 + T_INVERSE[1][2] * f_3
        c[i] = T_INVERSE[2][0] * f_1 + T_INVERSE[2][1] * f_2 + T_INVERSE[2][2] * f_3
        b[i] -= alpha * W[1, i] - beta * W[2, i]
        c[i] -= alpha * W[2, i] + beta * W[1, i]
    solve_real(h, ode)
    solve_complex(h, ode)
    total = 0.0
    for i in range(n):
        W[0, i] += a[i]
        W[1, i] += b[i]
        W[2, i] += c[i]
        total += (a[i] * a[i] + b[i] * b[i] + c[i] * c[i]) / (scale[i] * scale[i])
    return math.sqrt(total / (3.0 * n))


@kernel
def solve_real(h, ode):
    """Overwrite a with (gamma/h - J)^-1 a."""
    n, k = ode.W.shape[1], ode.real.shape[0]
    m = n - k
    J, a, v, w = ode.J, ode.a, ode.v, ode.w
    e = GAMMA / h
    for j in range(m):
        w[j] = a[j] / e
    for i in range(k):
        total = a[m + i]
        for j in range(m):
            total += J[m + i, j] * w[j]
        v[i] = total
    lu_solve(k, ode.real, ode.order, v, w)
    for i in range(m):
        a[i] = (a[i] + w[i]) / e
    for i in range(k):
        a[m + i] = w[i]


@kernel
def solve_complex(h, ode):
    """Overwrite b + i c with ((alpha + i beta)/h - J)^-1 (b + i c)."""
    n, k = ode.W.shape[1], ode.real.shape[0]
    m = n - k
    J, b, c, v, w, y, z = ode.J, ode.b, ode.c, ode.v, ode.w, ode.y, ode.z
    alpha, beta = ALPHA / h, BETA / h
    size = alpha * alpha + beta * beta
    for j in range(m):
        y[j], z[j] = (b[j] * alpha + c[j] * beta) / size, (c[j] * alpha - b[j] * beta) / size
    for i in range(k):
        re, im = b[m + i], c[m + i]
        for j in range(m):
            re += J[m + i, j] * y[j]
            im += J[m + i, j] * z[j]
        v[i], w[i] = re, im
    complex_lu_solve(k, ode.re, ode.im, ode.order_c, v, w, y, z)
    for i in range(m):
        re, im = b[i] + y[i], c[i] + z[i]
        b[i] = (re * alpha + im * beta) / size
        c[i] = (im * alpha - re * beta) / size
    for i in range(k):
        b[m + i], c[m + i] = y[i], z[i]


@kernel
def finish_stages(h, ode):
    """Quadratures of the stages, and the end x_1."""
    n, N = ode.W.shape[1], ode.x.shape[0]
    Z, F, x, x_1 = ode.Z, ode.F, ode.x, ode.x_1
    for s in range(3):
        for i in range(n, N):
            Z[s, i] = h * (A[s][0] * F[0, i] + A[s][1] * F[1, i] + A[s][2] * F[2, i])
    for i in range(N):
        x_1[i] = x[i] + Z[2, i]


@kernel
def estimate_error(h, ode):
    """Norm of (gamma/h - J)^-1 (f_0 + sum ERROR_s Z_s / h), at most 1 where the step is good."""
    n = ode.W.shape[1]
    Z, a, x, x_1, f_0 = ode.Z, ode.a, ode.x, ode.x_1, ode.f_0
    for i in range(n):
        a[i] = f_0[i] + (ERROR[0] * Z[0, i] + ERROR[1] * Z[1, i] + ERROR[2] * Z[2, i]) / h
    solve_real(h, ode)
    total = 0.0
    for i in range(n):
        part = a[i] / (ode.atol[i] + ode.clock.rtol * max(abs(x[i]), abs(x_1[i])))
        total += part * part
    return math.sqrt(total / n)


@kernel
def dense_value(theta, Z_1, Z_2, Z_3):
    """x(t + theta h) - x_0 from the stages of one component."""
    total = 0.0
    for k in range(3):
        total = total * theta + (DENSE[0][2 - k] * Z_1 + DENSE[1][2 - k] * Z_2 + DENSE[2][2 - k] * Z_3)
    return total * theta
