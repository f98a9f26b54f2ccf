"""The contact problem of spatial bodies, smoothed: one equation for every t > 0, and its derivative.

    x o y = t e_N,     x, y inside L,                          L and o in ``blocks.second_order_cone``
    x = S P,     S = diag(mu, 1, 1),     v = v_free + M^-1 J^T P,     gamma = J v + b,
    y_T = gamma_T,     y_N = a + sqrt(|gamma_T|^2 + kappa^2 a^2),     a = gamma_N / mu + C t^2

P in P_unit, velocities in v_unit. At t = 0 this is the problem itself: y_N = gamma_N / mu + |gamma_T| where a = 0, and
where a > 0 the contact is open. kappa makes y smooth. As t grows the opening C t^2 does so before the impulses, and
there is one solution. Smoothing t and opening C t^2 fall together, the opening faster: impulses that press bodies
together then are large on the way, and few contacts slide.

With W y = W^-1 x of Nesterov and Todd, s = log t, and C_ the derivative of y by gamma, a step (dv, dx, dy, ds) obeys

    dy = R + C_ J dv + y' ds,     dy + W^-2 dx = r + r' ds,     M dv = J^T S^-1 dx - g,
    (M + J^T S^-1 W^2 C_ J) dv = J^T S^-1 W^2 (r - R + (r' - y') ds) - g,

R the residual of y; W^-1 times the q with (W y) o q = t e_N - (W y) o (W y) is r, with t e_N alone r'. The matrix has
the graph of the bodies. As W^2 and M are positive definite its determinant has the sign of that of the whole system.
The velocities are unknowns with a residual g = M (v - v_free) - J^T P of their own: made anew from x each time, they
carry roundings that end the path near t = 1e-6.
Source: Acary, Armand, Nguyen and Shpakovych, Optim. Methods Softw. 39 (2024) 634-663 (the smoothing, without kappa and
opening); Nesterov and Todd, Math. Oper. Res. 22 (1997) 1-42.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.contact.blocks.second_order_cone import (
    complementary_target,
    distance_to_boundary,
    jordan_product,
    scale,
    scaling_point,
)
from nonsmooth.contact.network.block_factor import back_substitute, factorise
from nonsmooth.contact.network.lagrangian import Direct, add_contact, clear_blocks, pull
from nonsmooth.contact.network.problem import Network, relative_velocity, write
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, view

ROUNDING_OF_SLIP = 0.5  # chosen: below 1, or y could lie in L with a < 0; 0.2 and 0.9 take as many factors


class Smoothed(Block):
    """The point of an island, by its contacts in their order, and what ``linearise`` finds there."""

    t: float
    opening: float  # C t^2
    P_unit: float  # [N s]
    v_unit: float  # [m/s]
    x: Array[Floats, "m", "3"]
    y: Array[Floats, "m", "3"]
    w: Array[Floats, "m", "4"]  # W, as (w_N, w_1, w_2, eta)
    C: Array[Floats, "m", "3"]  # the first row of C_; the others are those of I
    R: Array[Floats, "m", "3"]
    rate: Array[Floats, "m", "3"]  # y'
    r: Array[Floats, "m", "3"]
    by_t: Array[Floats, "m", "3"]  # r'
    dx: Array[Floats, "m", "3"]  # the step to the solution for this t,
    dy: Array[Floats, "m", "3"]
    path_x: Array[Floats, "m", "3"]  # and the derivative of the solution by log t
    path_y: Array[Floats, "m", "3"]
    # by places of the elimination
    v: Array[Floats, "n_b", "6"]
    g: Array[Floats, "n_b", "6"]  # M (v - v_free) - J^T P
    zero: Array[Floats, "n_b", "6"]
    dv: Array[Floats, "n_b", "6"]
    path_v: Array[Floats, "n_b", "6"]
    D: Array[Floats, "3", "3"]


@kernel
def find_imbalance(network, direct, point, k):
    """P = S^-1 x and v to the network, and g."""
    islands, columns, g = network.islands, direct.factor.columns, point.g
    for row in range(islands.body_start[k], islands.body_start[k + 1]):
        body = columns.body[row]
        for x in range(6):
            network.v[body, x] = point.v[row, x]
            total = 0.0
            for y in range(6):
                total += network.M[body, x, y] * (point.v[row, y] - network.v_free[body, y])
            g[row, x] = total
    begin, unit = islands.contact_start[k], point.P_unit
    for at in range(begin, islands.contact_start[k + 1]):
        c, row = islands.contacts[at], at - begin
        P = (unit * point.x[row, 0] / network.mu[c], unit * point.x[row, 1], unit * point.x[row, 2])
        write(network.P, c, P[0], P[1], P[2], 3)
        pull(g, columns.place[network.i[c]], network.J_i, c, P, 3, 6)
        pull(g, columns.place[network.j[c]], network.J_j, c, P, 3, 6)


@kernel
def smoothed_velocity(network, point, c, row):
    """y of the velocities of contact c, as (y_N, y_1, y_2); C_ and y' go to the point."""
    gamma_N, gamma_1, gamma_2 = relative_velocity(network, c, 3, 6)
    mu, unit = network.mu[c], 1.0 / point.v_unit
    a, y_1, y_2 = unit * gamma_N / mu + point.opening, unit * gamma_1, unit * gamma_2
    length = math.sqrt(y_1 * y_1 + y_2 * y_2 + (ROUNDING_OF_SLIP * a) * (ROUNDING_OF_SLIP * a))
    by_a = 1.0 + ROUNDING_OF_SLIP * ROUNDING_OF_SLIP * a / length if length > 0.0 else 1.0
    point.C[row, 0] = by_a / mu
    point.C[row, 1] = y_1 / length if length > 0.0 else 0.0
    point.C[row, 2] = y_2 / length if length > 0.0 else 0.0
    point.rate[row, 0] = 2.0 * point.opening * by_a
    return a + length, y_1, y_2


@kernel
def find_targets(network, point, k):
    """W, R, r and r' of every contact."""
    islands, x, y, t = network.islands, point.x, point.y, point.t
    begin = islands.contact_start[k]
    for at in range(begin, islands.contact_start[k + 1]):
        row = at - begin
        f_N, f_1, f_2 = smoothed_velocity(network, point, islands.contacts[at], row)
        store(point.R, row, f_N - y[row, 0], f_1 - y[row, 1], f_2 - y[row, 2])
        w_N, w_1, w_2, eta = scaling_point(x[row, 0], x[row, 1], x[row, 2], y[row, 0], y[row, 1], y[row, 2])
        store(point.w, row, w_N, w_1, w_2)
        point.w[row, 3] = eta
        l_N, l_1, l_2 = scale(w_N, w_1, w_2, eta, y[row, 0], y[row, 1], y[row, 2])
        p_N, p_1, p_2 = jordan_product(l_N, l_1, l_2, l_N, l_1, l_2)
        of_w, of_y = (w_N, w_1, w_2, eta), (y[row, 0], y[row, 1], y[row, 2])
        r_N, r_1, r_2 = complementary_target(of_w, of_y, t - p_N, -p_1, -p_2)
        store(point.r, row, r_N, r_1, r_2)
        r_N, r_1, r_2 = complementary_target(of_w, of_y, t, 0.0, 0.0)
        store(point.by_t, row, r_N, r_1, r_2)


@kernel
def store(to, row, N, T_1, T_2):
    """Write a vector into a row."""
    to[row, 0] = N
    to[row, 1] = T_1
    to[row, 2] = T_2


@kernel
def twice(w_N, w_1, w_2, eta, a_N, a_1, a_2):
    """W W a. From the entries of W^2 roundings relative to |w|^4 would come; of a sliding contact |w|^2 is 1 / t."""
    b_N, b_1, b_2 = scale(w_N, w_1, w_2, eta, a_N, a_1, a_2)
    return scale(w_N, w_1, w_2, eta, b_N, b_1, b_2)


@kernel
def squared(w, row, a_N, a_1, a_2):
    """W^2 a."""
    return twice(w[row, 0], w[row, 1], w[row, 2], w[row, 3], a_N, a_1, a_2)


@kernel
def assemble(network, direct, point, k):
    """M + J^T S^-1 W^2 C_ J to the blocks of the factor."""
    islands, KJ, D = network.islands, direct.desk.KJ, point.D
    clear_blocks(network, direct.factor, k, 6)
    begin, unit = islands.contact_start[k], point.P_unit / point.v_unit
    for at in range(begin, islands.contact_start[k + 1]):
        c, row = islands.contacts[at], at - begin
        for column in range(3):
            T_1, T_2 = 1.0 if column == 1 else 0.0, 1.0 if column == 2 else 0.0
            image = squared(point.w, row, point.C[row, column], T_1, T_2)
            D[0, column] = unit * image[0] / network.mu[c]
            D[1, column] = unit * image[1]
            D[2, column] = unit * image[2]
        multiply(D, network.J_i, c, KJ, 0, 3, 6)
        multiply(D, network.J_j, c, KJ, 3, 3, 6)
        add_contact(network, direct, KJ, c, 3, 6)


@kernel
def multiply(D, J, c, KJ, first, d, n):
    """D J[c] to the rows of KJ from ``first`` on."""
    for a in range(d):
        for x in range(n):
            total = D[a, 0] * J[c, 0, x] + D[a, 1] * J[c, 1, x]
            KJ[first + a, x] = total + D[a, 2] * J[c, 2, x] if d == 3 else total


@kernel
def solve_for(network, direct, point, k, right, steps):
    """The steps (dx, dy, dv) of the right sides (r, R, g), or of (r', y', 0)."""
    islands, step, dv = network.islands, direct.step, steps[2]
    begin, end = islands.body_start[k], islands.body_start[k + 1]
    push_bodies(network, direct, point, k, right)
    back_substitute(direct.factor, direct.desk.square, begin, end, step, 6)
    for row in range(begin, end):
        for x in range(6):
            dv[row, x] = step[row, x]
    find_steps(network, direct, point, k, right, steps)


@kernel
def find_steps(network, direct, point, k, right, steps):
    """dy = R + C_ J dv and dx = W^2 (r - dy)."""
    islands, (target, residual, _), (dx, dy, dv) = network.islands, right, steps
    begin, unit = islands.contact_start[k], 1.0 / point.v_unit
    for at in range(begin, islands.contact_start[k + 1]):
        c, row = islands.contacts[at], at - begin
        g_N, g_1, g_2 = rate_of_contact(network, direct, dv, c, 3, 6)
        y_N = residual[row, 0] + unit * (point.C[row, 0] * g_N + point.C[row, 1] * g_1 + point.C[row, 2] * g_2)
        y_1, y_2 = residual[row, 1] + unit * g_1, residual[row, 2] + unit * g_2
        x_N, x_1, x_2 = squared(point.w, row, target[row, 0] - y_N, target[row, 1] - y_1, target[row, 2] - y_2)
        store(dx, row, x_N, x_1, x_2)
        store(dy, row, y_N, y_1, y_2)


@kernel
def rate_of_contact(network, direct, dv, c, d, n):
    """J dv of contact c as (N, T1, T2), with T2 = 0 in the plane."""
    g_N = g_1 = g_2 = 0.0
    for side in range(2):
        row = direct.factor.columns.place[network.i[c] if side == 0 else network.j[c]]
        if row >= 0:
            J = network.J_i if side == 0 else network.J_j
            for x in range(n):
                g_N += J[c, 0, x] * dv[row, x]
                g_1 += J[c, 1, x] * dv[row, x]
                if d == 3:
                    g_2 += J[c, 2, x] * dv[row, x]
    return g_N, g_1, g_2


@kernel
def push_bodies(network, direct, point, k, right):
    """J^T S^-1 W^2 (r - R) - g of all bodies."""
    islands, columns, step, (target, residual, g) = network.islands, direct.factor.columns, direct.step, right
    for row in range(islands.body_start[k], islands.body_start[k + 1]):
        for x in range(6):
            step[row, x] = -g[row, x]
    begin, unit = islands.contact_start[k], -point.P_unit
    for at in range(begin, islands.contact_start[k + 1]):
        c, row = islands.contacts[at], at - begin
        r_N, r_1, r_2 = target[row, 0] - residual[row, 0], target[row, 1] - residual[row, 1], target[row, 2]
        x_N, x_1, x_2 = squared(point.w, row, r_N, r_1, r_2 - residual[row, 2])
        push = (unit * x_N / network.mu[c], unit * x_1, unit * x_2)
        pull(step, columns.place[network.i[c]], network.J_i, c, push, 3, 6)
        pull(step, columns.place[network.j[c]], network.J_j, c, push, 3, 6)


@kernel
def linearise_island(network, direct, point, k):
    """The step to the path and the derivative along it; False where the matrix has no finite pivots."""
    islands = network.islands
    find_imbalance(network, direct, point, k)
    find_targets(network, point, k)
    assemble(network, direct, point, k)
    direct.desk.factors += 1
    begin, end = islands.body_start[k], islands.body_start[k + 1]
    if not factorise(direct.factor, direct.desk.square, begin, end, False, 6):
        return False
    solve_for(network, direct, point, k, (point.r, point.R, point.g), (point.dx, point.dy, point.dv))
    along = (point.path_x, point.path_y, point.path_v)
    solve_for(network, direct, point, k, (point.by_t, point.rate, point.zero), along)
    return True


@kernel("int64(int64, int64, int64, int64)")
def linearise(network_at, direct_at, point_at, k):
    """``linearise_island``."""
    is_regular = linearise_island(view(network_at, Network), view(direct_at, Direct), view(point_at, Smoothed), k)
    return 1 if is_regular else 0


@kernel("void(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1])", takes_arrays=True)
def to_dual(w, dx, dy, dual_x, dual_y):
    """W^-2 dx and W^2 dy."""
    for row in range(dx.shape[0]):
        y_N, y_1, y_2 = squared(w, row, dy[row, 0], dy[row, 1], dy[row, 2])
        store(dual_y, row, y_N, y_1, y_2)
        w_N, w_1, w_2, eta = w[row, 0], -w[row, 1], -w[row, 2], 1.0 / w[row, 3]
        x_N, x_1, x_2 = twice(w_N, w_1, w_2, eta, dx[row, 0], dx[row, 1], dx[row, 2])
        store(dual_x, row, x_N, x_1, x_2)


@kernel("float64(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1])", takes_arrays=True)
def room(x, y, dx, dy):
    """How many times the step one may go until a contact leaves its cones."""
    out = math.inf
    for row in range(x.shape[0]):
        out = min(out, distance_to_boundary(x[row, 0], x[row, 1], x[row, 2], dx[row, 0], dx[row, 1], dx[row, 2]))
        out = min(out, distance_to_boundary(y[row, 0], y[row, 1], y[row, 2], dy[row, 0], dy[row, 1], dy[row, 2]))
    return out
