"""Rows of islands of discs: where every arm lies along its normal, normal and tangent do not couple.

    W = diag(w_N, w_T),   w_N = 1/m_i + 1/m_j,   w_T = w_N + r_i^2 / I_i + r_j^2 / I_j,
    P_N <- max(0, P_N - omega gamma_N / w_N),
    P_T <- the nearest number to P_T - omega gamma_T / w_T in [-mu P_N, mu P_N]

is the exact solution of the contact for omega = 1, and over-relaxed, and in the cone, for more. Rows and bodies stand
where those of ``spheres`` do, whose counterpart in the plane this is; impulses are along normal and tangent.

Source: Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235-257; Jourdan, Alart and Jean, ibid. 155 (1998) 31-47.
"""

from __future__ import annotations

from nonsmooth.contact.network.joint import is_joint
from nonsmooth.contact.network.round_rows import (
    AT_ARM_I,
    AT_ARM_J,
    AT_EASE,
    AT_FRICTION,
    AT_IMPULSE,
    AT_LIGHTNESS,
    AT_NORMAL,
    AT_NORMAL_MASS,
    AT_OFFSET,
    AT_TANGENT_MASS,
)
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.numerics.rounding import EPS

ALONG_NORMAL = 1024.0 * EPS  # chosen: of an arm, a difference of places: some hundred radii from the origin


@rare_kernel
def are_discs(network, rows, k):
    """Whether all contacts of island k are such; then their rows and those of their bodies are written."""
    islands = network.islands
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        if not is_disc(network.M_inv, body):
            return False
        write_disc(network, rows, body)
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        if network.soft[c] > 0.0 or is_joint(network, c) or not write_contact_of_discs(network, rows, c):
            return False
    return True


@kernel
def is_disc(M_inv, body):
    """Whether M^-1 is diag(1/m, 1/m, 1/I)."""
    off = abs(M_inv[body, 0, 1]) + abs(M_inv[body, 1, 0])
    for x in range(2):
        off += abs(M_inv[body, x, 2]) + abs(M_inv[body, 2, x])
    return off == 0.0 and M_inv[body, 0, 0] == M_inv[body, 1, 1]


@kernel
def arm_along_normal(J, J_j, M_inv, c, body, sign):
    """(q, whether it is so) where the rows of a body are sign (n, 0) and sign (t, 0) + (0, q), with the n, t of J_j."""
    if M_inv[body, 0, 0] == 0.0:
        return 0.0, True
    arm = J[c, 1, 2]
    is_frame = J_j[c, 1, 0] == -J_j[c, 0, 1] and J_j[c, 1, 1] == J_j[c, 0, 0]
    for a in range(2):
        for x in range(2):
            is_frame = is_frame and J[c, a, x] == sign * J_j[c, a, x]
    return arm, is_frame and abs(J[c, 0, 2]) <= ALONG_NORMAL * abs(arm)


@kernel
def write_contact_of_discs(network, rows, c):
    """The row of contact c, and those of its bodies that cannot move; False where it is none of discs."""
    i, j, M_inv, J, row, P = network.i[c], network.j[c], network.M_inv, network.J_j, rows.contact, network.P
    arm_i, is_arm_i = arm_along_normal(network.J_i, J, M_inv, c, i, -1.0)
    arm_j, is_arm_j = arm_along_normal(J, J, M_inv, c, j, 1.0)
    if not (is_arm_i and is_arm_j):
        return False
    lightness = M_inv[i, 0, 0] + M_inv[j, 0, 0]
    for x in range(2):
        row[c, AT_NORMAL + x], row[c, AT_IMPULSE + x], row[c, AT_OFFSET + x] = J[c, 0, x], P[c, x], network.b[c, x]
    for body in (i, j):
        if M_inv[body, 0, 0] == 0.0:
            write_disc(network, rows, body)
            for a in range(2):
                for x in range(3):
                    J_of = network.J_i[c, a, x] if body == i else J[c, a, x]
                    row[c, AT_OFFSET + a] += J_of * network.v[body, x]
    row[c, AT_FRICTION] = network.mu[c]
    row[c, AT_NORMAL_MASS] = 1.0 / lightness
    row[c, AT_TANGENT_MASS] = 1.0 / (lightness + arm_i * arm_i * M_inv[i, 2, 2] + arm_j * arm_j * M_inv[j, 2, 2])
    row[c, AT_ARM_I], row[c, AT_ARM_J] = arm_i, arm_j
    return True


@kernel
def write_disc(network, rows, body):
    """The row of a body; one that cannot move stands still, its velocity is in the offsets."""
    lightness = network.M_inv[body, 0, 0]
    for x in range(3):
        rows.moving[body, x] = network.v[body, x] if lightness > 0.0 else 0.0
    rows.moving[body, AT_LIGHTNESS], rows.moving[body, AT_EASE] = lightness, network.M_inv[body, 2, 2]


@kernel
def relax_discs(row, moving, c, i, j, omega):
    """Relax contact c with the others held, and let it strike; |change of P_c|^2 and |P_c|^2."""
    n_x, n_y, P_N, P_T = row[c, 0], row[c, 1], row[c, AT_IMPULSE], row[c, AT_IMPULSE + 1]
    u_x, u_y = moving[j, 0] - moving[i, 0], moving[j, 1] - moving[i, 1]
    x_N = P_N - omega * (row[c, AT_NORMAL_MASS] * (n_x * u_x + n_y * u_y + row[c, AT_OFFSET]))
    x_T = 0.0
    if x_N > 0.0:
        arm_i, arm_j = row[c, AT_ARM_I], row[c, AT_ARM_J]
        u_T = n_x * u_y - n_y * u_x + (arm_i * moving[i, 2] + arm_j * moving[j, 2]) + row[c, AT_OFFSET + 1]
        radius = row[c, AT_FRICTION] * x_N
        x_T = max(-radius, min(radius, P_T - omega * (row[c, AT_TANGENT_MASS] * u_T)))
    elif P_N == 0.0 and P_T == 0.0:
        return 0.0, 0.0
    else:
        x_N = 0.0
    row[c, AT_IMPULSE], row[c, AT_IMPULSE + 1] = x_N, x_T
    d_N, d_T = x_N - P_N, x_T - P_T
    d_x, d_y = n_x * d_N - n_y * d_T, n_y * d_N + n_x * d_T
    a_i, a_j = moving[i, AT_LIGHTNESS], moving[j, AT_LIGHTNESS]
    moving[i, 0] -= a_i * d_x
    moving[i, 1] -= a_i * d_y
    moving[i, 2] += moving[i, AT_EASE] * row[c, AT_ARM_I] * d_T
    moving[j, 0] += a_j * d_x
    moving[j, 1] += a_j * d_y
    moving[j, 2] += moving[j, AT_EASE] * row[c, AT_ARM_J] * d_T
    return d_N * d_N + d_T * d_T, x_N * x_N + x_T * x_T
