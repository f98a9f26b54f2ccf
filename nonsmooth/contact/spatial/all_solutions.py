"""All solutions of one spatial contact: open, stick, and every slide, the positive roots of a quartic.

    gamma = G P + c,    S = G_TT - G_TN G_NT / G_NN,    s = c_T - G_TN c_N / G_NN

A slide has gamma_N = 0, gamma_T = -alpha P_T with alpha > 0 and |P_T| = mu P_N. With D = det(S + alpha I) and the
adjugate A of S + alpha I, P_T = -A s / D and G_NN P_N = -(c_N D - G_NT A s) / D, so that

    q(alpha) = mu^2 (c_N D - G_NT A s)^2 - G_NN^2 |A s|^2 = 0,    P_N(alpha) > 0

which has degree 4. Its roots are found in x = alpha/(alpha + S_0) in (0, 1), between those of its derivatives.
There is one solution for every c where no root of phi = mu P_N/|P_T| - 1 can be passed downward: with lambda the
eigenvalues of S, P_N'/P_N >= -mu |G_NT| / (G_NN (lambda_min + alpha)) and |P_T|'/|P_T| <= -1/(lambda_max + alpha), so

    mu |G_NT| / G_NN < lambda_min / lambda_max

is enough. A slide with phi' < 0 is what one with p < 0 is in the plane. Whether no root was lost is decided exactly in
rational numbers (contact/spatial/exact_count.py).
Source: Bonnefon and Daviet, Quartic formulation of Coulomb 3D frictional contact, INRIA RT-0400 (2011).
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.contact.blocks.single_spatial import slide_state
from nonsmooth.contact.planar.single import FREE, STICK
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.numerics.dense import SINGULAR

SLIDE = 6  # code: a slide in two directions, which has no sign, beside the modes of contact/planar/single.py
MOST_SOLUTIONS = 6  # derived: open, stick, and four slides
QUARTIC = 4  # derived: degree of q
ROOT_HALVINGS = 60  # chosen: of an interval in (0, 1): to rounding
NEAR_ROOT = 1e-2  # chosen: part of alpha within which a root of q is one of phi
POLISHING_STEPS = 8  # chosen: of Newton's method: four from a root of q that is well apart from others


class OneContact(Block, most=MOST_SOLUTIONS):
    """One contact, and all its solutions."""

    mu: float
    mu_static: float
    G: Array[Floats, 1, 3, 3]
    c: Array[Floats, 3]
    P: Array[Floats, "most", 3]
    modes: Array[Ints, "most"]
    alphas: Array[Floats, QUARTIC]  # of the slides
    chain: Array[Floats, QUARTIC + 1, QUARTIC + 1]  # scratch: q and its derivatives


@kernel
def reduced(G, k, c_N, c_1, c_2):
    """S and s of the contact with block G[k]: gamma_T where gamma_N = 0."""
    g = G[k, 0, 0]
    S = (
        G[k, 1, 1] - G[k, 1, 0] * G[k, 0, 1] / g,
        G[k, 1, 2] - G[k, 1, 0] * G[k, 0, 2] / g,
        G[k, 2, 1] - G[k, 2, 0] * G[k, 0, 1] / g,
        G[k, 2, 2] - G[k, 2, 0] * G[k, 0, 2] / g,
    )
    return S, (c_1 - G[k, 1, 0] * c_N / g, c_2 - G[k, 2, 0] * c_N / g)


@kernel
def is_surely_unique(G, k, mu):
    """Whether the contact has one solution for every c, by the bound above."""
    g = G[k, 0, 0]
    coupling = mu * math.sqrt(G[k, 0, 1] * G[k, 0, 1] + G[k, 0, 2] * G[k, 0, 2])
    if coupling == 0.0:
        return g > 0.0
    S, _ = reduced(G, k, 0.0, 0.0, 0.0)
    mean, half, shear = 0.5 * (S[0] + S[3]), 0.5 * (S[0] - S[3]), 0.5 * (S[1] + S[2])
    spread = math.sqrt(half * half + shear * shear)
    return coupling * (mean + spread) < g * (mean - spread)


@kernel
def stick_spatial(G, k, c_N, c_1, c_2, mu):
    """(P_N, P_1, P_2, is_admissible) of sticking; where S is singular it is found by no one."""
    S, s = reduced(G, k, c_N, c_1, c_2)
    if not abs(S[0] * S[3] - S[1] * S[2]) > SINGULAR * abs(S[0] * S[3]):
        return 0.0, 0.0, 0.0, False
    P_1, P_2, _, _ = slide_state(S[0], S[1], S[2], S[3], s[0], s[1], 0.0)
    P_N = -(c_N + G[k, 0, 1] * P_1 + G[k, 0, 2] * P_2) / G[k, 0, 0]
    return P_N, P_1, P_2, P_N > 0.0 and math.sqrt(P_1 * P_1 + P_2 * P_2) <= mu * P_N


@kernel
def slide_spatial(G, k, c, mu, alpha):
    """(P_N, P_1, P_2) of the slide with alpha, P exactly on the cone and gamma_N = 0."""
    S, s = reduced(G, k, c[0], c[1], c[2])
    P_1, P_2, _, _ = slide_state(S[0], S[1], S[2], S[3], s[0], s[1], alpha)
    P_N = -(c[0] + G[k, 0, 1] * P_1 + G[k, 0, 2] * P_2) / G[k, 0, 0]
    P_T = math.sqrt(P_1 * P_1 + P_2 * P_2)
    if P_T == 0.0 or not P_N > 0.0:  # a root of q with |P_T| = -mu P_N is none of phi
        return P_N, 0.0, 0.0
    d_1, d_2 = P_1 / P_T, P_2 / P_T
    resistance = G[k, 0, 0] + mu * (G[k, 0, 1] * d_1 + G[k, 0, 2] * d_2)
    if resistance != 0.0:
        P_N = -c[0] / resistance
    return P_N, mu * P_N * d_1, mu * P_N * d_2


@rare_kernel
def list_solutions(G, k, c, mu, mu_static, answers):
    """Write the impulse and the mode of every solution, free, stick and slides in this order; returns their number."""
    P, modes, found = answers.P, answers.modes, 0
    if c[0] >= 0.0:
        P[0, 0], P[0, 1], P[0, 2], modes[0] = 0.0, 0.0, 0.0, FREE
        found = 1
    P_N, P_1, P_2, sticks = stick_spatial(G, k, c[0], c[1], c[2], mu_static)
    if sticks:
        P[found, 0], P[found, 1], P[found, 2], modes[found] = P_N, P_1, P_2, STICK
        found += 1
    elif mu == 0.0 and c[0] < 0.0 < G[k, 0, 0]:
        P[found, 0], P[found, 1], P[found, 2], modes[found] = -c[0] / G[k, 0, 0], 0.0, 0.0, SLIDE
        found += 1
    for m in range(find_slides(G, k, c, mu, answers.chain, answers.alphas)):
        P[found, 0], P[found, 1], P[found, 2] = slide_spatial(G, k, c, mu, answers.alphas[m])
        modes[found] = SLIDE
        found += 1
    return found


@kernel("int64(int64)")
def list_of_one(contact_at):
    """`list_solutions` of a block of its own."""
    contact = view(contact_at, OneContact)
    return list_solutions(contact.G, 0, contact.c, contact.mu, contact.mu_static, contact)


@rare_kernel
def find_slides(G, k, c, mu, chain, alphas):
    """Write the alphas of all slides, the smallest first, and return their number; ``chain`` (5, 5) is scratch."""
    S, s = reduced(G, k, c[0], c[1], c[2])
    scale = 0.5 * (abs(S[0]) + abs(S[3]))
    if mu == 0.0 or scale == 0.0 or G[k, 0, 0] == 0.0:
        return 0
    fill_quartic(G, k, c, mu, (S, s, scale), chain)
    found = 0
    for m in range(find_roots(chain, alphas)):
        alpha = scale * alphas[m] / (1.0 - alphas[m])
        if slide_spatial(G, k, c, mu, alpha)[0] > 0.0:
            alphas[found] = polished(G, k, c, mu, (S, s), alpha)
            found += 1
    return found


@kernel
def cone_gap(G, k, c, mu, reduction, alpha):
    """phi and its derivative."""
    S, s = reduction
    P_1, P_2, d_1, d_2 = slide_state(S[0], S[1], S[2], S[3], s[0], s[1], alpha)
    g, P_T = G[k, 0, 0], math.sqrt(P_1 * P_1 + P_2 * P_2)
    if P_T == 0.0:
        return 0.0, 1.0
    P_N, dP_N = -(c[0] + G[k, 0, 1] * P_1 + G[k, 0, 2] * P_2) / g, -(G[k, 0, 1] * d_1 + G[k, 0, 2] * d_2) / g
    return mu * P_N / P_T - 1.0, mu * (dP_N - P_N * (P_1 * d_1 + P_2 * d_2) / (P_T * P_T)) / P_T


@kernel
def is_saddle(G, k, c, mu, alpha):
    """Whether a slide is one of those that the compliant contact leaves."""
    return cone_gap(G, k, c, mu, reduced(G, k, c[0], c[1], c[2]), alpha)[1] < 0.0


@kernel
def polished(G, k, c, mu, reduction, alpha):
    """A root of q by Newton's method on phi, as long as it comes nearer."""
    phi, slope = cone_gap(G, k, c, mu, reduction, alpha)
    for _ in range(POLISHING_STEPS):
        nearer = alpha - phi / slope if slope != 0.0 else 0.0
        if not abs(nearer - alpha) <= NEAR_ROOT * alpha:
            break
        trial, its_slope = cone_gap(G, k, c, mu, reduction, nearer)
        if not abs(trial) < abs(phi):
            break
        alpha, phi, slope = nearer, trial, its_slope
    return alpha


@kernel
def fill_quartic(G, k, c, mu, reduction, chain):
    """chain[4, :] = q in powers of x, in units in which S_0 = 1."""
    S, s, scale = reduction
    g, g_1, g_2 = G[k, 0, 0], G[k, 0, 1], G[k, 0, 2]
    # A s = (v_1, v_2) + alpha s;  alpha = scale y
    v_1, v_2 = S[3] * s[0] - S[1] * s[1], S[0] * s[1] - S[2] * s[0]
    det = S[0] * S[3] - S[1] * S[2]
    n_0 = c[0] * det - g_1 * v_1 - g_2 * v_2
    n_1 = (c[0] * (S[0] + S[3]) - g_1 * s[0] - g_2 * s[1]) * scale
    n_2 = c[0] * scale * scale
    w_1, w_2, m, h = s[0] * scale, s[1] * scale, mu * mu, g * g
    a_0 = m * n_0 * n_0 - h * (v_1 * v_1 + v_2 * v_2)
    a_1 = 2.0 * (m * n_0 * n_1 - h * (v_1 * w_1 + v_2 * w_2))
    a_2 = m * (n_1 * n_1 + 2.0 * n_0 * n_2) - h * (w_1 * w_1 + w_2 * w_2)
    a_3 = 2.0 * m * n_1 * n_2
    a_4 = m * n_2 * n_2
    # sum a_i x^i (1 - x)^(4 - i)
    chain[4, 0] = a_0
    chain[4, 1] = a_1 - 4.0 * a_0
    chain[4, 2] = a_2 - 3.0 * a_1 + 6.0 * a_0
    chain[4, 3] = a_3 - 2.0 * a_2 + 3.0 * a_1 - 4.0 * a_0
    chain[4, 4] = a_4 - a_3 + a_2 - a_1 + a_0


@kernel
def find_roots(chain, roots):
    """The simple roots in (0, 1) of the polynomial chain[4], in order; returns their number. chain[d] becomes a
    derivative of degree d, between whose roots those of the next one lie."""
    for d in range(QUARTIC - 1, 0, -1):
        for i in range(d + 1):
            chain[d, i] = (i + 1) * chain[d + 1, i + 1]
    count = 0
    for d in range(1, QUARTIC + 1):
        low, found, before = 0.0, 0, count
        for m in range(before + 1):
            high = roots[m] if m < before else 1.0
            chain[0, m] = crossing(chain, d, low, high)
            low = high
        for m in range(before + 1):
            if chain[0, m] > 0.0:
                roots[found] = chain[0, m]
                found += 1
        count = found
    return count


@kernel
def crossing(chain, d, low, high):
    """Where the polynomial chain[d] passes through zero between two places; 0 where it does not."""
    below = value_at(chain, d, low)
    if below == 0.0 or (below < 0.0) == (value_at(chain, d, high) < 0.0):
        return 0.0
    for _ in range(ROOT_HALVINGS):
        middle = 0.5 * (low + high)
        if (value_at(chain, d, middle) < 0.0) == (below < 0.0):
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@kernel
def value_at(chain, d, x):
    """The polynomial chain[d] at x."""
    total = chain[d, d]
    for i in range(d - 1, -1, -1):
        total = total * x + chain[d, i]
    return total
