"""The contact problem of many bodies: every contact touches two of them.

    gamma_c = J_i v_i + J_j v_j + b_c,     v = v_free + M^-1 J^T P,
    K* contains gamma_c + mu_c |gamma_c,T| e_N  _|_  P_c in K = {|P_T| <= mu P_N}

with i, j the bodies of contact c, d rows a contact (N, T1[, T2]) and n velocities a body: d, n = 2, 3 in the plane and
3, 6 in space. M is block diagonal, so the Delassus matrix G = J M^-1 J^T is never made; what a solver needs of it are
the parts Y^T = M^-1 J^T of one contact and its own block W = J_i Y_i^T + J_j Y_j^T.

The residual of an island is that of the natural map, in impulses:

    F_c = P_c - proj_K(P_c - rho_c (gamma_c + mu_c |gamma_c,T| e_N)),   rho_c = d / tr W_c,
    residual = |F| / |P|,   and where that is above tol:   |F| / max(|P|, R / tol)

R is what rounding of the velocities does to |F|, so that no tolerance asks for digits which velocities do not have: for
bodies that move and exchange next to nothing the residual is relative to R / tol. Without impulses it is 0 where none
are asked for, to R, and at most 1.
Where masses of an island differ so much that the impulses of its light bodies are roundings of |P|, the residual is the
largest of those of all its contacts and of its light ones alone, rho_c < UNSEEN^k max rho, k = 1, 2, ... That of a
problem is the largest of those of its islands.

A joint stands among the contacts, with the whole space in the place of K (joint.py). The last rows of a block may be
unused: J = 0, and W has the softness of the first one in their place.

A compliant contact has R on the diagonal of G, gamma_c,N + R_c P_N in the place of gamma_c,N (its law is in
integrators/moreau_jean/compliance.py): R stands in W, and in what the laws ask of.

Bodies that nothing moves (fixed ones, and those whose motion is given) have M^-1 = 0; their velocities are those of
v_free. A contact of two of them is in no island: it has no impulse.

Kernels take d and n as numbers; an entry point hands them constants, and the loops over them are unrolled. A planar
problem compiles no entry point of space. Source: Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235-257; De Saxce
and Feng, Math. Comput. Model. 28 (1998) 225-245.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.contact.blocks.natural_map import cone_project
from nonsmooth.contact.network.islands import Islands, find_islands
from nonsmooth.contact.network.joint import is_joint
from nonsmooth.jit import in_dimensions, kernel, rare_kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.numerics.rounding import EPS

# chosen: part of the largest rho of an island below which contacts are judged by themselves: light bodies have at least
# two digits where tol = 1e-8
UNSEEN = 1e-6


class Network(Block):
    """Up to m contacts of n_b bodies, d rows a contact and n velocities a body."""

    n_c: int  # contacts in use, the first of the m rows
    tol: float  # of the residual, by which R counts; 0: not at all
    islands: Islands
    i: Array[Ints, "m"]  # bodies of a contact
    j: Array[Ints, "m"]
    J_i: Array[Floats, "m", "d", "n"]  # its rows
    J_j: Array[Floats, "m", "d", "n"]
    b: Array[Floats, "m", "d"]  # [m/s]
    turn: Array[Floats, "m", "d"]  # of b, what guided bodies add by turning within the step
    mu: Array[Floats, "m"]  # or JOINED, of a joint
    soft: Array[Floats, "m"]  # R of a compliant contact, or of all rows of a joint [1/kg]; 0 of a rigid one
    sprung: Array[Ints, "m"]  # what is no contact (joint.py): one of the two that are a spring, a limit, a motor; or 0
    P: Array[Floats, "m", "d"]  # [N s], also the start of every solver
    gamma: Array[Floats, "m", "d"]  # [m/s]
    v: Array[Floats, "n_b", "n"]
    v_free: Array[Floats, "n_b", "n"]
    M: Array[Floats, "n_b", "n", "n"]
    M_inv: Array[Floats, "n_b", "n", "n"]  # its inverse, or 0
    Y_i: Array[Floats, "m", "d", "n"]  # J_i M_i^-1
    Y_j: Array[Floats, "m", "d", "n"]
    W: Array[Floats, "m", "d", "d"]  # [1/kg]
    rho: Array[Floats, "m"]  # [kg]; 0 where nothing can move


@kernel
def prepare(network, d, n):
    """Y = J M^-1, W and rho of every contact; the velocities are the free ones, also of bodies that cannot move."""
    for body in range(network.v.shape[0]):
        for x in range(n):
            network.v[body, x] = network.v_free[body, x]
    for c in range(network.n_c):
        image(network.J_i, network.M_inv, c, network.i[c], network.Y_i, d, n)
        image(network.J_j, network.M_inv, c, network.j[c], network.Y_j, d, n)
        trace = 0.0
        for a in range(d):
            for e in range(d):
                total = 0.0
                for x in range(n):
                    total += network.J_i[c, a, x] * network.Y_i[c, e, x] + network.J_j[c, a, x] * network.Y_j[c, e, x]
                network.W[c, a, e] = total
            if a == 0 or is_joint(network, c):
                network.W[c, a, a] += network.soft[c]
            trace += network.W[c, a, a]
        if network.W[c, d - 1, d - 1] == 0.0:
            trace += fill_unused(network, c, d)
        network.rho[c] = d / trace if trace > 0.0 else 0.0


@rare_kernel
def fill_unused(network, c, d):
    """Let rows that a block does not use, with J = 0, have the softness of its first one, so that they ask for nothing
    and their impulse is none; what stands in W for them."""
    total = 0.0
    for a in range(1, d):
        if network.W[c, a, a] == 0.0:
            network.W[c, a, a] = network.W[c, 0, 0]
            total += network.W[c, 0, 0]
    return total


@kernel
def image(J, M_inv, c, body, Y, d, n):
    """The rows Y[c] = J[c] M_inv[body]."""
    for a in range(d):
        for x in range(n):
            total = 0.0
            for y in range(n):
                total += J[c, a, y] * M_inv[body, y, x]
            Y[c, a, x] = total


@kernel
def relative_velocity(network, c, d, n):
    """gamma_c of the velocities at hand as (N, T1, T2), with T2 = 0 in the plane."""
    return contact_velocity(network, network.v, c, d, n)


@kernel
def contact_velocity(network, v, c, d, n):
    """gamma_c = J_i v_i + J_j v_j + b_c of the velocities v of the bodies."""
    i, j, J_i, J_j = network.i[c], network.j[c], network.J_i, network.J_j
    gamma_N, gamma_1, gamma_2 = network.b[c, 0], network.b[c, 1], 0.0
    for x in range(n):
        gamma_N += J_i[c, 0, x] * v[i, x] + J_j[c, 0, x] * v[j, x]
        gamma_1 += J_i[c, 1, x] * v[i, x] + J_j[c, 1, x] * v[j, x]
    if d == 3:
        gamma_2 = network.b[c, 2]
        for x in range(n):
            gamma_2 += J_i[c, 2, x] * v[i, x] + J_j[c, 2, x] * v[j, x]
    return gamma_N, gamma_1, gamma_2


@kernel
def laws_velocity(network, c, d, n):
    """What the laws of contact ask of: gamma_c, and R P_N of a compliant one, of a joint R P."""
    gamma_N, gamma_1, gamma_2 = relative_velocity(network, c, d, n)
    R = network.soft[c]
    if R > 0.0 and is_joint(network, c):
        gamma_1 += R * network.P[c, 1]
        gamma_2 += R * network.P[c, 2] if d == 3 else 0.0
    return gamma_N + R * network.P[c, 0], gamma_1, gamma_2


@kernel
def strike(network, c, P_N, P_1, P_2, d, n):
    """Let an impulse of contact c act on the velocities of its bodies."""
    strike_body(network.Y_i, network.v, c, network.i[c], (P_N, P_1, P_2), d, n)
    strike_body(network.Y_j, network.v, c, network.j[c], (P_N, P_1, P_2), d, n)


@kernel
def strike_body(Y, v, c, body, P, d, n):
    """v_body += Y[c]^T P."""
    P_N, P_1, P_2 = P
    for x in range(n):
        change = Y[c, 0, x] * P_N + Y[c, 1, x] * P_1
        if d == 3:
            change += Y[c, 2, x] * P_2
        v[body, x] += change


@kernel
def impulse(P, c, d):
    """P_c as (N, T1, T2), with T2 = 0 in the plane."""
    return P[c, 0], P[c, 1], P[c, 2] if d == 3 else 0.0


@kernel
def write(P, c, P_N, P_1, P_2, d):
    """Let P_c be (N, T1[, T2])."""
    P[c, 0] = P_N
    P[c, 1] = P_1
    if d == 3:
        P[c, 2] = P_2


@kernel
def velocities(network, d, n):
    """v = v_free + M^-1 J^T P of all bodies, and no impulse where no body can move."""
    for body in range(network.v.shape[0]):
        for x in range(n):
            network.v[body, x] = network.v_free[body, x]
    for c in range(network.n_c):
        if network.rho[c] == 0.0:
            write(network.P, c, 0.0, 0.0, 0.0, d)
        else:
            P_N, P_1, P_2 = impulse(network.P, c, d)
            strike(network, c, P_N, P_1, P_2, d, n)


@kernel
def island_velocities(network, k, d, n):
    """The same of the bodies of island k."""
    islands = network.islands
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        for x in range(n):
            network.v[body, x] = network.v_free[body, x]
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        P_N, P_1, P_2 = impulse(network.P, c, d)
        strike(network, c, P_N, P_1, P_2, d, n)


@kernel
def natural_map(network, c, d, n):
    """|F_c|^2 and |P_c|^2."""
    gamma_N, gamma_1, gamma_2 = laws_velocity(network, c, d, n)
    P_N, P_1, P_2 = impulse(network.P, c, d)
    mu, rho = network.mu[c], network.rho[c]
    if is_joint(network, c):
        return rho * rho * square_of_joint(network, c, d, n), P_N * P_N + P_1 * P_1 + P_2 * P_2
    shifted = gamma_N + mu * math.sqrt(gamma_1 * gamma_1 + gamma_2 * gamma_2)
    x_N, x_1, x_2 = cone_project(mu, P_N - rho * shifted, P_1 - rho * gamma_1, P_2 - rho * gamma_2)
    F_N, F_1, F_2 = P_N - x_N, P_1 - x_1, P_2 - x_2
    return F_N * F_N + F_1 * F_1 + F_2 * F_2, P_N * P_N + P_1 * P_1 + P_2 * P_2


@rare_kernel
def square_of_joint(network, c, d, n):
    """|gamma_c|^2 of a joint, without the rows that rounding of the velocities lets be no smaller.

    Else joints of bodies that fly freely, whose impulses are none, would have roundings relative to roundings.
    """
    i, j, v, total = network.i[c], network.j[c], network.v, 0.0
    for a in range(d):
        gamma = network.b[c, a] + network.soft[c] * network.P[c, a]
        size = abs(network.b[c, a]) + abs(network.soft[c] * network.P[c, a])
        for x in range(n):
            of_i, of_j = network.J_i[c, a, x] * v[i, x], network.J_j[c, a, x] * v[j, x]
            gamma += of_i + of_j
            size += abs(of_i) + abs(of_j)
        if abs(gamma) > (2 * n + 1) * EPS * size:
            total += gamma * gamma
    return total


@kernel
def island_residual(network, k, d, n):
    """The residual of island k at its velocities; its sums |F|^2, |P|^2 go to the islands."""
    islands = network.islands
    F, P, least, largest = 0.0, 0.0, math.inf, 0.0
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        F_c, P_c = natural_map(network, c, d, n)
        F += F_c
        P += P_c
        least, largest = min(least, network.rho[c]), max(largest, network.rho[c])
    islands.F[k], islands.P[k], islands.below[k] = F, P, math.inf
    error = relative(network, k, math.inf, F, P, d, n)
    if error < math.inf and least < UNSEEN * largest:
        return residual_of_light(network, k, error, least, largest, d, n)
    return error


@rare_kernel
def residual_of_light(network, k, worst, least, largest, d, n):
    """The largest of the residual of all contacts of island k and of its light ones, whose rho are from ``least`` to
    ``largest``; ``islands.below[k]`` says whose it is."""
    islands, bound = network.islands, UNSEEN * largest
    while least < bound:
        F, P = 0.0, 0.0
        for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
            c = islands.contacts[at]
            if network.rho[c] < bound:
                F_c, P_c = natural_map(network, c, d, n)
                F += F_c
                P += P_c
        error = relative(network, k, bound, F, P, d, n)
        if error > worst:
            worst, islands.below[k] = error, bound
        bound *= UNSEEN
    return worst


@kernel
def relative(network, k, bound, F, P, d, n):
    """The residual of the contacts of island k with rho < bound, of which |F|^2 and |P|^2 are the sums."""
    tol = network.tol
    if F <= tol * tol * P:
        return math.sqrt(F / P) if P > 0.0 else 0.0
    size, scale = math.sqrt(F), math.sqrt(P)
    if tol > 0.0:
        R = rounding(network, k, bound, d, n)
        if P == 0.0 and size <= R:
            return 0.0
        scale = max(scale, R / tol)
    return size / (scale if P > 0.0 else max(scale, size)) if size != 0.0 else 0.0  # NaN stays NaN


@rare_kernel
def rounding(network, k, bound, d, n):
    """R: what rounding of the velocities does to |F| of the contacts of island k with rho < bound [N s].

    gamma_c is a sum of 2n + 1 products, each as large as its factors; rho_c (gamma_c + mu_c |gamma_c,T| e_N) goes into
    F_c. Of an open contact, P_c = 0 and gamma_N > 0, F_c = 0 whatever its rounding: a gap that is wide for the length
    of the step would hide what the others leave.
    """
    islands, total = network.islands, 0.0
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        if not network.rho[c] < bound:
            continue
        i, j, square_T = network.i[c], network.j[c], 0.0
        for a in range(d - 1, -1, -1):
            gamma, size = network.b[c, a], abs(network.b[c, a])
            for x in range(n):
                of_i, of_j = network.J_i[c, a, x] * network.v[i, x], network.J_j[c, a, x] * network.v[j, x]
                gamma += of_i + of_j
                size += abs(of_i) + abs(of_j)
            if a > 0:
                square_T += size * size
            elif network.P[c, 0] == 0.0 and not is_joint(network, c) and gamma > (2 * n + 1) * EPS * size:
                size = 0.0
            else:
                size += network.soft[c] * network.P[c, 0] + max(network.mu[c], 0.0) * math.sqrt(square_T)
            total += (network.rho[c] * size) * (network.rho[c] * size)
    return (2 * n + 1) * EPS * math.sqrt(total)


@kernel
def residual(network, d, n):
    """The largest residual of all islands, NaN where one is; that of each island goes to islands.residual."""
    islands, worst = network.islands, 0.0
    for k in range(islands.count):
        islands.residual[k] = island_residual(network, k, d, n)
        if not islands.residual[k] <= worst and worst == worst:
            worst = islands.residual[k]
    return worst


@kernel
def worst_contact(network, k, d, n):
    """The contact of the largest |F_c|, of those that the residual of island k is of."""
    islands, largest, worst = network.islands, -1.0, -1
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        F_c, _ = natural_map(network, c, d, n)
        if network.rho[c] < islands.below[k] and not F_c <= largest:
            largest, worst = F_c, c
    return worst


@kernel
def contact_velocities(network, d, n):
    """gamma of every contact."""
    for c in range(network.n_c):
        gamma_N, gamma_1, gamma_2 = relative_velocity(network, c, d, n)
        write(network.gamma, c, gamma_N, gamma_1, gamma_2, d)


@in_dimensions("void(int64)")
def prepare_network(network_at, d):
    """The parts of the rows and the islands: before any solver."""
    network = view(network_at, Network)
    prepare(network, d, 3 * (d - 1))
    find_islands(network, 3 * (d - 1))


@in_dimensions("float64(int64)")
def judge_network(network_at, d):
    """The velocities of P, the residual of each island and the largest, and gamma."""
    network, n = view(network_at, Network), 3 * (d - 1)
    velocities(network, d, n)
    contact_velocities(network, d, n)
    return residual(network, d, n)
