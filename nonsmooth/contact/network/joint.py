"""A joint among the contacts of a network: d rows that are held together whatever impulse it takes.

    gamma_c = J_i v_i + J_j v_j + b_c = 0,    P_c free

It is a contact whose cone is the whole space, so the polar one is the origin: nothing is projected, the natural map is
F_c = rho_c gamma_c, one joint with the others held is P_c <- P_c - W_c^-1 gamma_c, and the augmented Lagrangian has it
always stick. Its row has the code JOINED in the place of mu, which all of them read anyway.

One that says what others say too may be soft, gamma_c + R_c P_c = 0: what they say differs by what the step errs by,
and impulses that no body feels would grow without a bound.

Source: Acary and Brogliato, *Numerical Methods for Nonsmooth Dynamical Systems* (2008), section 13.3 (bilateral rows
among unilateral ones).
"""

from __future__ import annotations

from nonsmooth.jit import kernel, rare_kernel

JOINED = -1.0  # code: in the place of mu: the row block of a joint
# code: what is no contact: of a spring, of the limit of a joint, of its motor, of the friction of its pin
SPRUNG, JOINT_LIMIT, MOTOR, PIN = 1, 2, 3, 4


@kernel
def is_joint(network, c):
    """Whether row block c is a joint."""
    return network.mu[c] < 0.0


@kernel
def is_contact(network, c):
    """Whether row block c is where two bodies may touch, and none of a joint, a spring or a drive."""
    return network.mu[c] >= 0.0 and network.sprung[c] == 0


@kernel
def may_land(network, c):
    """Whether row block c is a contact or a limit of a joint, which is reached as contacts are."""
    return network.mu[c] >= 0.0 and (network.sprung[c] == 0 or network.sprung[c] == JOINT_LIMIT)


@kernel
def is_powered(network, c):
    """Whether row block c is of a spring or a motor, whose work is that of forces."""
    return network.sprung[c] == SPRUNG or network.sprung[c] == MOTOR


@kernel
def acts(network, c):
    """Whether contact c has an impulse, or is a joint, which always may."""
    return network.P[c, 0] > 0.0 or network.mu[c] < 0.0


@rare_kernel
def solve_joint(W, c, b_N, b_1, b_2, d):
    """-W_c^-1 b, W_c symmetric and positive definite, by its factors L D L^T."""
    L_1N = W[c, 1, 0] / W[c, 0, 0]
    D_1 = W[c, 1, 1] - L_1N * W[c, 1, 0]
    y_1 = -b_1 + L_1N * b_N
    x_1, x_2, L_2N = y_1 / D_1, 0.0, 0.0
    if d == 3:
        L_2N = W[c, 2, 0] / W[c, 0, 0]
        u_21 = W[c, 2, 1] - L_2N * W[c, 1, 0]
        L_21 = u_21 / D_1
        D_2 = W[c, 2, 2] - L_2N * W[c, 2, 0] - L_21 * u_21
        x_2 = (-b_2 + L_2N * b_N - L_21 * y_1) / D_2
        x_1 -= L_21 * x_2
    return -b_N / W[c, 0, 0] - L_1N * x_1 - L_2N * x_2, x_1, x_2
