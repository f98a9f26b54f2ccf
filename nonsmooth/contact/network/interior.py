"""Interior points on the graph of the bodies: Newton on the smoothed inclusion, as in ``blocks.interior``.

    x, y in L,    x o y = 0,    x = S P / P_c,    y = S^-1 gamma / v_c + |y_T| e_N,    gamma = J v + b + R P_N e_N

of every contact, L and o in ``blocks.second_order_cone``, S = diag(mu, 1, 1), in units P_c, v_c of its own in which its
Delassus block is about 1. The velocities are always those of the impulses, v = v_free + M^-1 J^T P. With W the
Nesterov-Todd matrix of the point and B = I + theta mu e_N y_T^T / |y_T| a step solves

    (M + sum of J_c^T D_c J_c) dv = sum of J_c^T K_c (r - (I + theta E) residual),
    K = P_c S^-1 (W^-2 + shift I)^-1,    D = K S^-1 B / v_c,    dP = K (r - (I + theta E) residual) - D J dv,

r the target of the predictor, and then of the corrector. The matrix has the graph of the bodies, and redundant contacts
cost nothing. W^2 grows without bound as contacts press or slide; shift is a compliance for the step alone, that keeps
the matrix from being all rounding: what it leaves of the residual is gone with the next steps. Of a compliant contact
dP_N stands on both sides: K and D are divided by I + R D e_N e_N^T. A joint, whose cone is the whole space, has
K = D = JOINED_KAPPA rho: an augmented Lagrangian.

Sources: those of ``blocks.interior``; for the shift Altman and Gondzio, Optim. Methods Softw. 11 (1999) 275-302.
Equations: docs/theory/contact_solvers.md, (8).
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.contact.blocks.interior import INTERIOR_PATIENCE, SHORT_STEP, THETA_RISE
from nonsmooth.contact.blocks.second_order_cone import (
    corrector_target,
    distance_to_boundary,
    scale_twice,
    scaling_point,
)
from nonsmooth.contact.network.al_newton import copy_impulses, judge_island
from nonsmooth.contact.network.elimination_tree import Tree
from nonsmooth.contact.network.joint import is_joint
from nonsmooth.contact.network.lagrangian import Direct, pull
from nonsmooth.contact.network.multifrontal import Fronts, factorise_fronts, solve_fronts
from nonsmooth.contact.network.problem import Network, contact_velocity, impulse, laws_velocity, write
from nonsmooth.jit import in_dimensions, kernel
from nonsmooth.jit.blocks import Block, Floats, view

CENTRING = 3.0  # chosen: Mehrotra's exponent
JOINED_KAPPA = 1e6  # chosen: of a joint: a step leaves a millionth of its velocity, and half of the digits


class Inside(Block):
    """The point of an island, by its contacts in their order, and a step from it."""

    start: float  # distance from the boundary of the cones that the steps begin at
    is_centred: int  # whether they begin where x o y is start^2 e for all contacts
    centring: float  # exponent of what the predictor leaves of x . y, for the part of it that the corrector aims at
    part: float  # of the way to the boundary of the cones that a step goes at most
    shift: float  # of W^-2, in a step
    theta: float  # share of the derivative of |y_T|
    P_unit: Array[Floats, "m"]  # [N s]
    v_unit: Array[Floats, "m"]  # [m/s]
    x: Array[Floats, "m", "3"]
    y: Array[Floats, "m", "3"]
    w: Array[Floats, "m", "4"]  # W, as (w_N, w_1, w_2, eta)
    residual: Array[Floats, "m", "3"]
    target: Array[Floats, "m", "3"]  # r
    dx: Array[Floats, "m", "3"]
    dy: Array[Floats, "m", "3"]
    D: Array[Floats, "m", "9"]


@kernel
def store(to, row, N, T_1, T_2):
    """Write a vector into a row."""
    to[row, 0] = N
    to[row, 1] = T_1
    to[row, 2] = T_2


@kernel
def enter(network, point, k, d, n):
    """x and y inside the cones by point.start, next to the impulses and their velocities; the impulses follow x."""
    islands, size = network.islands, 0.0
    begin, end = islands.contact_start[k], islands.contact_start[k + 1]
    for at in range(begin, end):
        c = islands.contacts[at]
        gamma_N, gamma_1, gamma_2 = contact_velocity(network, network.v_free, c, d, n)
        size = max(size, math.sqrt(network.rho[c]) * max(abs(gamma_N), max(abs(gamma_1), abs(gamma_2))))
    start, point.theta, size = point.start, 1.0, size if size > 0.0 else 1.0
    for at in range(begin, end):
        c, row = islands.contacts[at], at - begin
        root = math.sqrt(network.rho[c])
        point.P_unit[row], point.v_unit[row] = size * root, size / root
        P_N, P_1, P_2 = impulse(network.P, c, d)
        if is_joint(network, c):
            store(point.x, row, P_N / point.P_unit[row], P_1 / point.P_unit[row], P_2 / point.P_unit[row])
            continue
        s, is_rough = slope(network, c)
        x_N, x_1, x_2 = s * P_N / point.P_unit[row], 0.0, 0.0
        gamma_N, gamma_1, gamma_2 = laws_velocity(network, c, d, n)
        y_N, y_1, y_2 = gamma_N / (s * point.v_unit[row]), 0.0, 0.0
        if is_rough:
            x_1, x_2 = P_1 / point.P_unit[row], P_2 / point.P_unit[row]
            y_1, y_2 = gamma_1 / point.v_unit[row], gamma_2 / point.v_unit[row]
        if point.is_centred == 1:
            centre(
                point, row, x_N - max(y_N, 0.0) - math.sqrt(y_1 * y_1 + y_2 * y_2), x_1 - y_1, x_2 - y_2, start * start
            )
            continue
        store(point.x, row, max(x_N, math.sqrt(x_1 * x_1 + x_2 * x_2)) + start, x_1, x_2)
        store(point.y, row, max(y_N, 0.0) + math.sqrt(y_1 * y_1 + y_2 * y_2) + start, y_1, y_2)


@kernel
def centre(point, row, z_N, z_1, z_2, tau):
    """x and y of a row with x - y = z and x o y = tau e: as far from the boundary as those of any other row."""
    z_T = math.sqrt(z_1 * z_1 + z_2 * z_2)
    t_1, t_2 = (z_1 / z_T, z_2 / z_T) if z_T > 0.0 else (0.0, 0.0)
    x_plus, y_plus = factors_of(tau, z_N + z_T)
    x_minus, y_minus = factors_of(tau, z_N - z_T)
    x_T, y_T = 0.5 * (x_plus - x_minus), 0.5 * (y_plus - y_minus)
    store(point.x, row, 0.5 * (x_plus + x_minus), x_T * t_1, x_T * t_2)
    store(point.y, row, 0.5 * (y_plus + y_minus), y_T * t_1, y_T * t_2)


@kernel
def factors_of(tau, difference):
    """The positive numbers whose product is tau, of which the first is larger than the second by the difference."""
    larger = 0.5 * (abs(difference) + math.sqrt(difference * difference + 4.0 * tau))
    return (larger, tau / larger) if difference > 0.0 else (tau / larger, larger)


@kernel
def slope(network, c):
    """(mu, True), or (1, False) of a contact without friction, whose cone is a half-line."""
    return (network.mu[c], True) if network.mu[c] > 0.0 else (1.0, False)


@kernel
def leave(network, point, k, d):
    """P = P_c S^-1 x to the network."""
    islands = network.islands
    begin = islands.contact_start[k]
    for at in range(begin, islands.contact_start[k + 1]):
        c, row = islands.contacts[at], at - begin
        unit, s = point.P_unit[row], 1.0 if is_joint(network, c) else slope(network, c)[0]
        write(network.P, c, unit * point.x[row, 0] / s, unit * point.x[row, 1], unit * point.x[row, 2], d)


@kernel
def find_residual(network, point, k, d, n):
    """The residual of y, W, and r of the predictor; returns the mean gap x . y, NaN where there are no cones."""
    islands, x, y, gap, count = network.islands, point.x, point.y, 0.0, 0
    begin = islands.contact_start[k]
    for at in range(begin, islands.contact_start[k + 1]):
        c, row = islands.contacts[at], at - begin
        gamma_N, gamma_1, gamma_2 = laws_velocity(network, c, d, n)
        unit = 1.0 / point.v_unit[row]
        if is_joint(network, c):
            store(point.residual, row, unit * gamma_N, unit * gamma_1, unit * gamma_2)
            continue
        s, is_rough = slope(network, c)
        y_T = math.sqrt(y[row, 1] * y[row, 1] + y[row, 2] * y[row, 2])
        R_1, R_2 = unit * gamma_1 - y[row, 1], unit * gamma_2 - y[row, 2]
        R_N = unit * gamma_N / s + y_T - y[row, 0]
        store(point.residual, row, R_N, R_1 if is_rough else 0.0, R_2 if is_rough else 0.0)
        w_N, w_1, w_2, eta = scaling_point(x[row, 0], x[row, 1], x[row, 2], y[row, 0], y[row, 1], y[row, 2])
        store(point.w, row, w_N, w_1, w_2)
        point.w[row, 3] = eta
        store(point.target, row, -y[row, 0], -y[row, 1], -y[row, 2])
        gap += x[row, 0] * y[row, 0] + x[row, 1] * y[row, 1] + x[row, 2] * y[row, 2]
        count += 1
    return gap / count if count > 0 else math.nan


@kernel
def along_slip(point, row):
    """theta y_T / |y_T|."""
    y_1, y_2 = point.y[row, 1], point.y[row, 2]
    y_T = math.sqrt(y_1 * y_1 + y_2 * y_2)
    return (point.theta * y_1 / y_T, point.theta * y_2 / y_T) if y_T > 0.0 else (0.0, 0.0)


@kernel
def rate_of_dual(network, point, c, row, g_N, g_1, g_2):
    """S^-1 B g / v_c: the rate of y for the rate g of gamma."""
    s, is_rough = slope(network, c)
    unit = 1.0 / point.v_unit[row]
    if not is_rough:
        return unit * g_N, 0.0, 0.0
    e_1, e_2 = along_slip(point, row)
    return unit * (g_N / s + e_1 * g_1 + e_2 * g_2), unit * g_1, unit * g_2


@kernel
def shifted(w, row, shift, a_N, a_1, a_2):
    """(W^-2 + shift I)^-1 a, by the eigenvalues eta^2 (w_N +- |w_T|)^2, eta^2 of W^2, w_N^2 - |w_T|^2 = 1."""
    w_1, w_2, eta = w[row, 1], w[row, 2], w[row, 3]
    w_T = math.sqrt(w_1 * w_1 + w_2 * w_2)
    t_1, t_2 = (w_1 / w_T, w_2 / w_T) if w_T > 0.0 else (1.0, 0.0)
    out = w[row, 0] + w_T
    large, middle, small = eta * eta * out * out, eta * eta, eta * eta / (out * out)
    along = a_1 * t_1 + a_2 * t_2
    plus = 0.5 * (a_N + along) * large / (1.0 + shift * large)
    minus = 0.5 * (a_N - along) * small / (1.0 + shift * small)
    across = (a_2 * t_1 - a_1 * t_2) * middle / (1.0 + shift * middle)
    tangent = plus - minus
    return plus + minus, tangent * t_1 - across * t_2, tangent * t_2 + across * t_1


@kernel
def kappa_of_joint(network, c):
    """JOINED_KAPPA, less where the joint is soft."""
    return JOINED_KAPPA / (1.0 + JOINED_KAPPA * network.rho[c] * network.soft[c])


@kernel
def push_of_dual(network, point, c, row, a_N, a_1, a_2):
    """K a, of a rigid contact: the impulse for a step a of the dual."""
    if is_joint(network, c):
        unit = kappa_of_joint(network, c) * point.P_unit[row]
        return unit * a_N, unit * a_1, unit * a_2
    s, is_rough = slope(network, c)
    x_N, x_1, x_2 = shifted(point.w, row, point.shift, a_N, a_1, a_2)
    unit = point.P_unit[row]
    return unit * x_N / s, unit * x_1 if is_rough else 0.0, unit * x_2 if is_rough else 0.0


@kernel
def push_of_rate(network, point, c, row, g_N, g_1, g_2):
    """D g, of a rigid contact."""
    if is_joint(network, c):
        unit = kappa_of_joint(network, c) * network.rho[c]
        return unit * g_N, unit * g_1, unit * g_2
    a_N, a_1, a_2 = rate_of_dual(network, point, c, row, g_N, g_1, g_2)
    return push_of_dual(network, point, c, row, a_N, a_1, a_2)


@kernel
def yielding(network, point, c, row, p):
    """(I + R D e_N e_N^T)^-1 p: the impulse of a compliant contact, which shortens as it grows."""
    p_N, p_1, p_2 = p
    R = network.soft[c]
    if not R > 0.0 or is_joint(network, c):
        return p_N, p_1, p_2
    D_N, D_1, D_2 = push_of_rate(network, point, c, row, 1.0, 0.0, 0.0)
    share = p_N / (1.0 + R * D_N)
    return share, p_1 - R * D_1 * share, p_2 - R * D_2 * share


@kernel
def wanted_push(network, point, c, row):
    """K (r - (I + theta E) residual) of contact c."""
    R, r = point.residual, point.target
    if is_joint(network, c):
        return push_of_dual(network, point, c, row, -R[row, 0], -R[row, 1], -R[row, 2])
    e_1, e_2 = along_slip(point, row)
    a_N = r[row, 0] - R[row, 0] - e_1 * R[row, 1] - e_2 * R[row, 2]
    push = push_of_dual(network, point, c, row, a_N, r[row, 1] - R[row, 1], r[row, 2] - R[row, 2])
    return yielding(network, point, c, row, push)


@kernel
def find_stiffness(network, point, k, d):
    """D of every contact."""
    islands, D = network.islands, point.D
    begin = islands.contact_start[k]
    for at in range(begin, islands.contact_start[k + 1]):
        c, row = islands.contacts[at], at - begin
        for column in range(d):
            push = push_of_rate(
                network, point, c, row, 1.0 if column == 0 else 0.0, 1.0 if column == 1 else 0.0,
                1.0 if column == 2 else 0.0,
            )  # fmt: skip
            D[row, column], D[row, 3 + column], D[row, 6 + column] = yielding(network, point, c, row, push)


@kernel
def rate_of_contact(network, tree, dv, c, d, n):
    """J dv of contact c as (N, T1, T2), with T2 = 0 in the plane."""
    g_N = g_1 = g_2 = 0.0
    for side in range(2):
        row = tree.place[network.i[c] if side == 0 else network.j[c]]
        if row >= 0:
            J = network.J_i if side == 0 else network.J_j
            for x in range(n):
                g_N += J[c, 0, x] * dv[row, x]
                g_1 += J[c, 1, x] * dv[row, x]
                if d == 3:
                    g_2 += J[c, 2, x] * dv[row, x]
    return g_N, g_1, g_2


@kernel
def find_step(network, tree, fronts, point, k, d, n):
    """dx and dy for the target, with the factors at hand."""
    find_rates(network, tree, fronts, point, k, d, n)
    islands, r = network.islands, point.target
    first = islands.contact_start[k]
    for at in range(first, islands.contact_start[k + 1]):
        c, row = islands.contacts[at], at - first
        g_N, g_1, g_2 = rate_of_contact(network, tree, fronts.x, c, d, n)
        less_N, less_1, less_2 = yielding(network, point, c, row, push_of_rate(network, point, c, row, g_N, g_1, g_2))
        P_N, P_1, P_2 = wanted_push(network, point, c, row)
        s, unit = 1.0 if is_joint(network, c) else slope(network, c)[0], 1.0 / point.P_unit[row]
        dx_N, dx_1, dx_2 = unit * s * (P_N - less_N), unit * (P_1 - less_1), unit * (P_2 - less_2)
        store(point.dx, row, dx_N, dx_1, dx_2)
        if not is_joint(network, c):
            w_N, w_1, w_2, eta = point.w[row, 0], point.w[row, 1], point.w[row, 2], point.w[row, 3]
            a_N, a_1, a_2 = scale_twice(w_N, -w_1, -w_2, 1.0 / eta, dx_N, dx_1, dx_2)
            store(point.dy, row, r[row, 0] - a_N, r[row, 1] - a_1, r[row, 2] - a_2)


@kernel
def find_rates(network, tree, fronts, point, k, d, n):
    """dv, by places."""
    islands, step = network.islands, fronts.x
    for row in range(islands.body_start[k + 1] - islands.body_start[k]):
        for x in range(n):
            step[row, x] = 0.0
    first = islands.contact_start[k]
    for at in range(first, islands.contact_start[k + 1]):
        c = islands.contacts[at]
        P_N, P_1, P_2 = wanted_push(network, point, c, at - first)
        pull(step, tree.place[network.i[c]], network.J_i, c, (-P_N, -P_1, -P_2), d, n)
        pull(step, tree.place[network.j[c]], network.J_j, c, (-P_N, -P_1, -P_2), d, n)
    solve_fronts(tree, fronts, n)


@kernel
def longest_step(network, point, k, share):
    """The step length, at most 1 and ``share`` of the way out of the cones, and the mean gap after it."""
    islands, x, y, dx, dy, out = network.islands, point.x, point.y, point.dx, point.dy, math.inf
    begin, end = islands.contact_start[k], islands.contact_start[k + 1]
    for at in range(begin, end):
        if not is_joint(network, islands.contacts[at]):
            a = at - begin
            out = min(out, distance_to_boundary(x[a, 0], x[a, 1], x[a, 2], dx[a, 0], dx[a, 1], dx[a, 2]))
            out = min(out, distance_to_boundary(y[a, 0], y[a, 1], y[a, 2], dy[a, 0], dy[a, 1], dy[a, 2]))
    length, gap, count = min(1.0, share * out), 0.0, 0
    for at in range(begin, end):
        if not is_joint(network, islands.contacts[at]):
            a = at - begin
            for i in range(3):
                gap += (x[a, i] + length * dx[a, i]) * (y[a, i] + length * dy[a, i])
            count += 1
    return length, gap / count


@kernel
def correct(network, point, k, tau):
    """r of the corrector, which leads to x o y = tau e_N but for terms of third order."""
    islands, w, y, dx, dy = network.islands, point.w, point.y, point.dx, point.dy
    begin = islands.contact_start[k]
    for at in range(begin, islands.contact_start[k + 1]):
        if not is_joint(network, islands.contacts[at]):
            a = at - begin
            of_w, of_y = (w[a, 0], w[a, 1], w[a, 2], w[a, 3]), (y[a, 0], y[a, 1], y[a, 2])
            of_dx, of_dy = (dx[a, 0], dx[a, 1], dx[a, 2]), (dy[a, 0], dy[a, 1], dy[a, 2])
            r_N, r_1, r_2 = corrector_target(of_w, of_y, of_dx, of_dy, tau)
            store(point.target, a, r_N, r_1, r_2)


@kernel
def advance(network, direct, tree, fronts, point, k, d, n):
    """A predictor and a corrector; False where the numbers run out."""
    gap = find_residual(network, point, k, d, n)
    if not gap > 0.0:
        return False
    find_stiffness(network, point, k, d)
    direct.desk.factors += 1
    islands = network.islands
    if not factorise_fronts(network, tree, fronts, point.D, k, d, n):
        return False
    find_step(network, tree, fronts, point, k, d, n)
    _, ahead = longest_step(network, point, k, 1.0)
    share = min(1.0, max(0.0, ahead / gap))
    correct(network, point, k, share**point.centring * gap)
    find_step(network, tree, fronts, point, k, d, n)
    length, ahead = longest_step(network, point, k, point.part)
    if not (length > 0.0 and ahead < math.inf):
        return False
    begin = islands.contact_start[k]
    for row in range(islands.contact_start[k + 1] - begin):
        for a in range(3):
            point.x[row, a] += length * point.dx[row, a]
            point.y[row, a] += length * point.dy[row, a]
    point.theta = 0.5 * point.theta if length < SHORT_STEP else min(1.0, point.theta + THETA_RISE)
    return True


@in_dimensions("void(int64, int64, int64, int64, int64, int64, float64, int64)")
def go_inside(network_at, direct_at, tree_at, fronts_at, point_at, k, tol, most, d):
    """Take at most ``most`` steps from the impulses of island k, whose fronts are laid out.

    The best impulses of the steps are left, their residual in the islands.
    """
    network, direct, point = view(network_at, Network), view(direct_at, Direct), view(point_at, Inside)
    tree, fronts, islands, n = view(tree_at, Tree), view(fronts_at, Fronts), network.islands, 3 * (d - 1)
    least, waited = math.inf, 0
    judge_island(network, k, d, n)
    copy_impulses(islands, k, network.P, direct.best, d)
    enter(network, point, k, d, n)
    for _ in range(most):
        leave(network, point, k, d)
        error = judge_island(network, k, d, n)
        waited = 0 if error < 0.9 * least else waited + 1
        if error < least:
            least = error
            copy_impulses(islands, k, network.P, direct.best, d)
        if least <= tol or waited == INTERIOR_PATIENCE or not advance(network, direct, tree, fronts, point, k, d, n):
            break
    copy_impulses(islands, k, direct.best, network.P, d)
    islands.residual[k] = judge_island(network, k, d, n)
