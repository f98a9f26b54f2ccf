"""One spatial contact, exactly: 3 x 3 block G, cone |P_T| <= mu P_N.

    open    P = 0                                                    if b_N >= 0
    stick   P = -G^-1 b                                              if |P_T| <= mu P_N
    slide   gamma_N = 0,  gamma_T = -alpha P_T,  |P_T| = mu P_N      otherwise, for one alpha > 0

With P_N eliminated through gamma_N = 0, S = G_TT - G_TN G_NT / G_NN and s = b_T - G_TN b_N / G_NN,

    P_T(alpha) = -(S + alpha I)^-1 s,    phi(alpha) = mu P_N(alpha) / |P_T(alpha)| - 1 = 0.

phi(0) < 0 because the contact does not stick and phi grows without bound, so a root exists whenever G_NN > 0 and S is
positive (semi)definite; it is bracketed, then found by Newton steps that fall back on bisection. phi is nearly linear.

Source: Bonnefon and Daviet, Quartic formulation of Coulomb 3D frictional contact, INRIA RT-0400 (2011), whose quartic
in alpha this root solves; the secular form of the equation is that of More and Sorensen (1983) for trust regions.
Equations: docs/theory/contact_solvers.md, (3).
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel


@kernel
def slide_state(S_11, S_12, S_21, S_22, s_1, s_2, alpha):
    """P_T = -(S + alpha I)^-1 s and its derivative in alpha; 0 instead of a division by zero."""
    a = S_11 + alpha
    d = S_22 + alpha
    det = a * d - S_12 * S_21
    if det == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    P_1 = -(d * s_1 - S_12 * s_2) / det
    P_2 = -(a * s_2 - S_21 * s_1) / det
    return P_1, P_2, -(d * P_1 - S_12 * P_2) / det, -(a * P_2 - S_21 * P_1) / det


@kernel
def slide_alpha(g, S, b, mu):
    """The root alpha > 0 of phi: bracket by growing steps, then safeguarded Newton to the last digits.

    g = (G_NN, G_N1, G_N2), S = (S_11, S_12, S_21, S_22), b = (b_N, s_1, s_2).
    """
    g_NN, g_N1, g_N2 = g
    S_11, S_12, S_21, S_22 = S
    b_N, s_1, s_2 = b
    low = 0.0
    scale = 0.5 * (abs(S_11) + abs(S_22)) + 1e-3 * g_NN
    high = -1.0  # not bracketed yet
    alpha = 1e-2 * scale
    for _ in range(200):
        P_1, P_2, dP_1, dP_2 = slide_state(S_11, S_12, S_21, S_22, s_1, s_2, alpha)
        P_T = math.sqrt(P_1 * P_1 + P_2 * P_2)
        if P_T == 0.0:
            return alpha
        P_N = -(b_N + g_N1 * P_1 + g_N2 * P_2) / g_NN
        phi = mu * P_N / P_T - 1.0
        dP_N = -(g_N1 * dP_1 + g_N2 * dP_2) / g_NN
        slope = mu * dP_N / P_T - mu * P_N * (P_1 * dP_1 + P_2 * dP_2) / (P_T * P_T * P_T)
        if phi < 0.0:
            low = alpha
        else:
            high = alpha
        trial = alpha - phi / slope if slope > 0.0 else -1.0
        if abs(trial - alpha) <= 4e-16 * alpha:
            return alpha
        if high < 0.0:
            following = min(max(trial, 2.0 * alpha), 1e3 * alpha + scale)
        elif trial > low and trial < high:
            following = trial
        else:
            following = 0.5 * (low + high)
        if abs(following - alpha) <= 4e-16 * alpha:
            return following
        alpha = following
    return alpha


@kernel
def local_spatial(G, k, b_N, b_1, b_2, mu):
    """P = (P_N, P_1, P_2) of the single contact with block G[k] and free velocity b."""
    if b_N >= 0.0:
        return 0.0, 0.0, 0.0
    g_NN = G[k, 0, 0]
    if g_NN <= 0.0:
        return 0.0, 0.0, 0.0
    g_N1 = G[k, 0, 1]
    g_N2 = G[k, 0, 2]
    if mu == 0.0:
        return -b_N / g_NN, 0.0, 0.0
    S_11 = G[k, 1, 1] - G[k, 1, 0] * g_N1 / g_NN
    S_12 = G[k, 1, 2] - G[k, 1, 0] * g_N2 / g_NN
    S_21 = G[k, 2, 1] - G[k, 2, 0] * g_N1 / g_NN
    S_22 = G[k, 2, 2] - G[k, 2, 0] * g_N2 / g_NN
    s_1 = b_1 - G[k, 1, 0] * b_N / g_NN
    s_2 = b_2 - G[k, 2, 0] * b_N / g_NN
    det = S_11 * S_22 - S_12 * S_21
    if det > 1e-14 * abs(S_11 * S_22):  # S is regular to working precision
        P_1, P_2, _, _ = slide_state(S_11, S_12, S_21, S_22, s_1, s_2, 0.0)
        P_N = -(b_N + g_N1 * P_1 + g_N2 * P_2) / g_NN
        P_T = math.sqrt(P_1 * P_1 + P_2 * P_2)
        is_sticking = P_T <= mu * P_N
        if is_sticking:
            return P_N, P_1, P_2
    alpha = slide_alpha((g_NN, g_N1, g_N2), (S_11, S_12, S_21, S_22), (b_N, s_1, s_2), mu)
    P_1, P_2, _, _ = slide_state(S_11, S_12, S_21, S_22, s_1, s_2, alpha)
    P_T = math.sqrt(P_1 * P_1 + P_2 * P_2)
    if P_T == 0.0:
        return -b_N / g_NN, 0.0, 0.0
    d_1 = P_1 / P_T
    d_2 = P_2 / P_T
    P_N = -(b_N + g_N1 * P_1 + g_N2 * P_2) / g_NN
    resistance = g_NN + mu * (g_N1 * d_1 + g_N2 * d_2)
    if resistance > 0.0:
        P_N = -b_N / resistance  # gamma_N = 0 with P exactly on the cone
    return P_N, mu * P_N * d_1, mu * P_N * d_2
