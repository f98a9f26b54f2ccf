"""The augmented Lagrangian of a network as equations for its velocities, and their derivative.

    g(v) = M (v - v_free) - J^T p(v),     p_c(v) = proj_D(z_c),   z_c = P_c - rho_c (J v + b)_c,
    D = {|p_T| <= mu max(0, z_N)}:   open where z_N <= 0, stick where |z_T| <= mu z_N, slide else; a joint sticks,
    A = dg/dv = M + sum over c of J_c^T rho_c K_c J_c,   K = dp/dz:

    open K = 0,   stick K = I,   slide K_NN = 1, K_TN = mu t, K_TT = mu z_N / |z_T| (I - t t^T),  t = z_T / |z_T|

P is held. Of a compliant contact, with R on the diagonal of G, p_N = z_N - rho R p_N: z_N and dp/dz_N are times
1/(1 + rho R); of a soft joint all rows are. A is unsymmetric where a contact with friction slides. Source: Alart and
Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353-375.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.contact.network.block_factor import Factor
from nonsmooth.contact.network.joint import is_joint
from nonsmooth.contact.network.ordering import Quotient
from nonsmooth.contact.network.problem import impulse, relative_velocity, write
from nonsmooth.contact.planar.selection import FREE, SLIDE_MINUS, SLIDE_PLUS, STICK
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import Block, Floats, Ints


class Desk(Block):
    """What one island at a time is solved with: several threads have one each (``parallel``)."""

    part: int  # its islands are those with this ``owner``
    going_on: int  # 0 where a problem begins, and else 1 + the island to go on with
    factors: int  # made in all
    graph: Quotient
    KJ: Array[Floats, "2 * d", "n"]
    square: Array[Floats, "2", "n * n"]


class Direct(Block):
    """The memory of the direct rung for a network of the same m, n_b, d and n; ``fill`` blocks in the factors.

    What is by contacts, bodies and islands belongs to one island alone.
    """

    desk: Desk
    factor: Factor
    # of the factors made so far
    n_c: int  # contacts whose columns are laid out
    i: Array[Ints, "m"]
    j: Array[Ints, "m"]
    kappa: Array[Floats, "n_b"]  # of an island when it was solved last
    # of the solution
    P: Array[Floats, "m", "d"]  # held
    p: Array[Floats, "m", "d"]
    z: Array[Floats, "m", "d"]
    best: Array[Floats, "m", "d"]
    rho: Array[Floats, "m"]
    mode: Array[Ints, "m"]
    factored: Array[Ints, "m"]  # the mode in the factor
    v: Array[Floats, "n_b", "n"]  # of the bodies, by their numbers
    base: Array[Floats, "n_b", "n"]
    g: Array[Floats, "n_b", "n"]  # by places in the elimination
    step: Array[Floats, "n_b", "n"]


@kernel
def project(mu, z_N, z_1, z_2, d):
    """The projection of z on the disc of radius mu max(0, z_N), and the mode; sliding has no sign in space."""
    if mu < 0.0:  # a joint
        return z_N, z_1, z_2, STICK
    if not z_N > 0.0:
        return 0.0, 0.0, 0.0, FREE
    z_T, radius = math.sqrt(z_1 * z_1 + z_2 * z_2), mu * z_N
    if z_T <= radius and radius > 0.0:
        return z_N, z_1, z_2, STICK
    share = radius / z_T if z_T > 0.0 else 0.0
    return z_N, share * z_1, share * z_2, SLIDE_MINUS if d == 2 and z_1 > 0.0 else SLIDE_PLUS


@rare_kernel
def imbalance(network, direct, k, d, n):
    """g at the velocities, with z, p and modes; how many modes are not those of the factor."""
    islands, place = network.islands, direct.factor.columns.place
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        row = place[body]
        for x in range(n):
            total = 0.0
            for y in range(n):
                total += network.M[body, x, y] * (network.v[body, y] - network.v_free[body, y])
            direct.g[row, x] = total
    changed = 0
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        gamma_N, gamma_1, gamma_2 = relative_velocity(network, c, d, n)
        P_N, P_1, P_2 = impulse(direct.P, c, d)
        rho = direct.rho[c]
        z_N, z_1, z_2 = P_N - rho * gamma_N, P_1 - rho * gamma_1, P_2 - rho * gamma_2
        if network.soft[c] > 0.0:
            share = share_of_soft(network, direct, c)
            z_N *= share
            if is_joint(network, c):
                z_1, z_2 = share * z_1, share * z_2
        p_N, p_1, p_2, mode = project(network.mu[c], z_N, z_1, z_2, d)
        write(direct.z, c, z_N, z_1, z_2, d)
        write(direct.p, c, p_N, p_1, p_2, d)
        direct.mode[c] = mode
        if mode != direct.factored[c]:
            changed += 1
        if mode != FREE:
            pull(direct.g, place[network.i[c]], network.J_i, c, (p_N, p_1, p_2), d, n)
            pull(direct.g, place[network.j[c]], network.J_j, c, (p_N, p_1, p_2), d, n)
    return changed


@kernel
def pull(g, row, J, c, p, d, n):
    """g_row -= J[c]^T p, of a body that can move."""
    if row < 0:
        return
    p_N, p_1, p_2 = p
    for x in range(n):
        total = J[c, 0, x] * p_N + J[c, 1, x] * p_1
        if d == 3:
            total += J[c, 2, x] * p_2
        g[row, x] -= total


@rare_kernel
def size_of_imbalance(network, direct, k, n):
    """sqrt(g^T M^-1 g): a velocity in the norm of energy."""
    islands, place, g = network.islands, direct.factor.columns.place, direct.g
    total = 0.0
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        row = place[body]
        for x in range(n):
            image = 0.0
            for y in range(n):
                image += network.M_inv[body, x, y] * g[row, y]
            total += g[row, x] * image
    return math.sqrt(total)


@kernel
def size_of_change(network, k, n):
    """sqrt((v - v_free)^T M (v - v_free)): what |g| is small against."""
    islands, v, v_free = network.islands, network.v, network.v_free
    total = 0.0
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        for x in range(n):
            image = 0.0
            for y in range(n):
                image += network.M[body, x, y] * (v[body, y] - v_free[body, y])
            total += (v[body, x] - v_free[body, x]) * image
    return math.sqrt(total)


@kernel
def clear_blocks(network, factor, k, n):
    """M to the blocks of the factor of island k, and zeros to the others."""
    islands, columns = network.islands, factor.columns
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        row = columns.place[body]
        for x in range(n):
            for y in range(n):
                factor.D[row, x * n + y] = network.M[body, x, y]
        for entry in range(columns.first[row], columns.last[row]):
            for x in range(n * n):
                factor.L[entry, x] = 0.0
                factor.U[entry, x] = 0.0


@rare_kernel
def assemble(network, direct, desk, k, d, n):
    """A of the modes at hand to the blocks of the factor; whether it is symmetric."""
    islands = network.islands
    clear_blocks(network, direct.factor, k, n)
    is_symmetric = True
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        mode = direct.mode[c]
        direct.factored[c] = mode
        if mode != FREE:
            if mode != STICK and network.mu[c] > 0.0:
                is_symmetric = False
            derive_rows(network, direct, desk, c, d, n)
            add_contact(network, direct, desk.KJ, c, d, n)
    return is_symmetric


@kernel
def derivative(mu, z_N, z_1, z_2, mode):
    """(K_1N, K_2N, K_11, K_12, K_22) of the projection; K_NN = 1 where it is not open, and K_N1 = K_N2 = 0."""
    if mode == STICK:
        return 0.0, 0.0, 1.0, 0.0, 1.0
    z_T = math.sqrt(z_1 * z_1 + z_2 * z_2)
    if z_T == 0.0:  # without friction
        return 0.0, 0.0, 0.0, 0.0, 0.0
    t_1, t_2, share = z_1 / z_T, z_2 / z_T, mu * z_N / z_T
    return mu * t_1, mu * t_2, share * t_2 * t_2, -share * t_1 * t_2, share * t_1 * t_1


@kernel
def derive_rows(network, direct, desk, c, d, n):
    """rho K J of contact c, of i to the first d rows of KJ and of j to the others."""
    z_N, z_1, z_2 = impulse(direct.z, c, d)
    K_1N, K_2N, K_11, K_12, K_22 = derivative(network.mu[c], z_N, z_1, z_2, direct.mode[c])
    derive(network.J_i, c, direct.rho[c], (K_1N, K_2N, K_11, K_12, K_22), desk.KJ, 0, d, n)
    derive(network.J_j, c, direct.rho[c], (K_1N, K_2N, K_11, K_12, K_22), desk.KJ, d, d, n)
    if network.soft[c] > 0.0:
        soften_rows(network, direct, desk.KJ, c, (K_1N, K_2N), d, n)


@kernel
def share_of_soft(network, direct, c):
    """1 / (1 + rho R)."""
    return 1.0 / (1.0 + direct.rho[c] * network.soft[c])


@kernel
def soften_rows(network, direct, KJ, c, K, d, n):
    """The normal parts of the rows of a compliant contact, times 1 / (1 + rho R); of a joint all of them."""
    less = direct.rho[c] * (share_of_soft(network, direct, c) - 1.0)
    if is_joint(network, c):
        for x in range(n):
            for a in range(d):
                KJ[a, x] += less * network.J_i[c, a, x]
                KJ[d + a, x] += less * network.J_j[c, a, x]
        return
    for x in range(n):
        for part in range(2):
            J_N = network.J_i[c, 0, x] if part == 0 else network.J_j[c, 0, x]
            KJ[part * d, x] += less * J_N
            KJ[part * d + 1, x] += less * K[0] * J_N
            if d == 3:
                KJ[part * d + 2, x] += less * K[1] * J_N


@kernel
def derive(J, c, rho, K, KJ, first, d, n):
    """rho K J[c] to the rows of KJ from ``first`` on."""
    K_1N, K_2N, K_11, K_12, K_22 = K
    for x in range(n):
        J_N, J_1 = J[c, 0, x], J[c, 1, x]
        KJ[first, x] = rho * J_N
        if d == 3:
            J_2 = J[c, 2, x]
            KJ[first + 1, x] = rho * (K_1N * J_N + K_11 * J_1 + K_12 * J_2)
            KJ[first + 2, x] = rho * (K_2N * J_N + K_12 * J_1 + K_22 * J_2)
        else:
            KJ[first + 1, x] = rho * (K_1N * J_N + K_11 * J_1)


@kernel
def add_contact(network, direct, KJ, c, d, n):
    """J^T rho K J of contact c to the blocks of its bodies and of the pair."""
    factor = direct.factor
    place_i, place_j = factor.columns.place[network.i[c]], factor.columns.place[network.j[c]]
    if place_i >= 0:
        add_product(factor.D, place_i, network.J_i, c, KJ, 0, d, n)
    if place_j >= 0:
        add_product(factor.D, place_j, network.J_j, c, KJ, d, d, n)
    pair = factor.columns.pair[c]
    if pair >= 0:
        if place_i > place_j:
            add_product(factor.L, pair, network.J_i, c, KJ, d, d, n)
            add_product(factor.U, pair, network.J_j, c, KJ, 0, d, n)
        else:
            add_product(factor.L, pair, network.J_j, c, KJ, 0, d, n)
            add_product(factor.U, pair, network.J_i, c, KJ, d, d, n)


@kernel
def add_product(T, t, J, c, KJ, first, d, n):
    """T_t += J[c]^T KJ[first : first + d]."""
    for x in range(n):
        for y in range(n):
            total = T[t, x * n + y] + J[c, 0, x] * KJ[first, y] + J[c, 1, x] * KJ[first + 1, y]
            if d == 3:
                total += J[c, 2, x] * KJ[first + 2, y]
            T[t, x * n + y] = total
