"""The cone L = {|x_T| <= x_N} of R^3 and its algebra, one cone at a time, in scalars.

    a o b = (a . b,  a_N b_T + b_N a_T),      e = (1, 0, 0),      J = diag(1, -1, -1)

The Nesterov-Todd matrix of x and y in the inside of L is the one symmetric W with W y = W^-1 x that maps L on itself:

    W = eta [ w_N  w_T^T ; w_T  I + w_T w_T^T / (1 + w_N) ],
    W^-1 = J W J / eta^2,    W^-2 = (2 (J w)(J w)^T - J) / eta^2,
    eta^2 = |x|_J / |y|_J,   w = (x / |x|_J + J y / |y|_J) / (2 g),   2 g^2 = 1 + x . y / (|x|_J |y|_J),

where |x|_J^2 = x_N^2 - |x_T|^2.

Source: Nesterov and Todd, Math. Oper. Res. 22 (1997) 1-42; Alizadeh and Goldfarb, Math. Program. 95 (2003) 3-51.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel


@kernel
def inner_length(x_N, x_1, x_2):
    """|x|_J: the distance from the boundary of L in its own measure."""
    x_T = math.sqrt(x_1 * x_1 + x_2 * x_2)
    return math.sqrt(max((x_N - x_T) * (x_N + x_T), 0.0))


@kernel
def scaling_point(x_N, x_1, x_2, y_N, y_1, y_2):
    """(w_N, w_1, w_2, eta) of x and y."""
    x_J = inner_length(x_N, x_1, x_2)
    y_J = inner_length(y_N, y_1, y_2)
    double_g = math.sqrt(2.0 + 2.0 * (x_N * y_N + x_1 * y_1 + x_2 * y_2) / (x_J * y_J))
    return (
        (x_N / x_J + y_N / y_J) / double_g,
        (x_1 / x_J - y_1 / y_J) / double_g,
        (x_2 / x_J - y_2 / y_J) / double_g,
        math.sqrt(x_J / y_J),
    )


@kernel
def scale(w_N, w_1, w_2, eta, a_N, a_1, a_2):
    """W a; with (w_N, -w_1, -w_2, 1 / eta) it is W^-1 a."""
    w_a = w_1 * a_1 + w_2 * a_2
    share = a_N + w_a / (1.0 + w_N)
    return eta * (w_N * a_N + w_a), eta * (a_1 + share * w_1), eta * (a_2 + share * w_2)


@kernel
def scale_twice(w_N, w_1, w_2, eta, a_N, a_1, a_2):
    """W W a. From the entries of W^2 roundings relative to |w|^4 would come, and |w|^2 grows as contacts slide."""
    b_N, b_1, b_2 = scale(w_N, w_1, w_2, eta, a_N, a_1, a_2)
    return scale(w_N, w_1, w_2, eta, b_N, b_1, b_2)


@kernel
def jordan_product(a_N, a_1, a_2, b_N, b_1, b_2):
    """The product a o b."""
    return a_N * b_N + a_1 * b_1 + a_2 * b_2, a_N * b_1 + b_N * a_1, a_N * b_2 + b_N * a_2


@kernel
def jordan_quotient(a_N, a_1, a_2, b_N, b_1, b_2):
    """The q with a o q = b."""
    length = inner_length(a_N, a_1, a_2)
    q_N = (a_N * b_N - a_1 * b_1 - a_2 * b_2) / (length * length)
    return q_N, (b_1 - q_N * a_1) / a_N, (b_2 - q_N * a_2) / a_N


@kernel
def distance_to_boundary(x_N, x_1, x_2, d_N, d_1, d_2):
    """The least a > 0 with x + a d on the boundary of L; inf if there is none. x is inside."""
    quadratic = d_N * d_N - d_1 * d_1 - d_2 * d_2
    half = x_N * d_N - x_1 * d_1 - x_2 * d_2
    length = inner_length(x_N, x_1, x_2)
    constant = length * length
    discriminant = half * half - quadratic * constant
    if discriminant < -1e-14 * half * half:  # along the axis it is 0 up to roundings
        return math.inf
    denominator = math.sqrt(max(discriminant, 0.0)) - half
    return constant / denominator if denominator > 0.0 else math.inf


@kernel
def corrector_target(w, y, dx, dy, tau):
    """The r of a corrector after the predictor dx, dy: -y + W^-1 z, (W y) o z = tau e - (W^-1 dx) o (W dy), w being
    (w_N, w_1, w_2, eta)."""
    w_N, w_1, w_2, eta = w
    a_N, a_1, a_2 = scale(w_N, -w_1, -w_2, 1.0 / eta, dx[0], dx[1], dx[2])
    b_N, b_1, b_2 = scale(w_N, w_1, w_2, eta, dy[0], dy[1], dy[2])
    p_N, p_1, p_2 = jordan_product(a_N, a_1, a_2, b_N, b_1, b_2)
    l_N, l_1, l_2 = scale(w_N, w_1, w_2, eta, y[0], y[1], y[2])
    z_N, z_1, z_2 = jordan_quotient(l_N, l_1, l_2, tau - p_N, -p_1, -p_2)
    q_N, q_1, q_2 = scale(w_N, -w_1, -w_2, 1.0 / eta, z_N, z_1, z_2)
    return q_N - y[0], q_1 - y[1], q_2 - y[2]
