"""One planar impact with friction, in closed form in the normal impulse P (Darboux, Keller, Routh).

    d gamma_N/dP = G_NN + f G_NF,    d gamma_F/dP = G_NF + f G_FF,    f = dP_F/dP_N

The contact slides, f = -s mu, until gamma_F = 0 at P_1; then it sticks, f = -G_NF/G_FF, where the cone holds that much,
else it slides back. So gamma_N(P) is a line with one bend. Compression ends at P_c, where gamma_N = 0 on the way up;
the law of impact says how far expansion goes:

    NEWTON     gamma_N+ = -e gamma_N-
    POISSON    P = (1 + e) P_c
    ENERGETIC  the work of expansion is e^2 that of compression (Stronge)

From gamma_N- = 0 with p_s = G_NN - s mu G_NF < 0 this is an *impact without collision*, with C_s = G_NN - G_NF^2/G_FF:
gamma_N+ = 0 (Newton), e P_1 (C_s + |p_s|) (Poisson), e P_1 sqrt(|p_s| (C_s + |p_s|)) (energetic).
Source: Stronge, *Impact Mechanics* (2000), chapter 4; Keller, *J. Appl. Mech.* 53 (1986) 1.
Equations: docs/theory/painleve.md, (5) and (6).
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.mechanics.laws import LAW_E_N, LAW_IMPACT, ImpactLaw, friction_coefficient
from nonsmooth.mechanics.system import UNILATERAL
from nonsmooth.numerics.dense import SINGULAR


@kernel
def impulse_map(law, e, mu, G_NN, G_NF, G_FF, gamma_N, gamma_F):
    """(P_N, P_F, P_1, P_c) of an impact from gamma_N <= 0; P_c is inf where compression never ends.

    An impact that ends while the contact still slides has P_N <= P_1. Without impact (gamma_N = 0, p >= 0) all are 0.
    """
    f_1, P_1 = first_phase(mu, G_NF, G_FF, gamma_F)
    f_2 = second_ratio(mu, G_NF, G_FF)
    p_1 = G_NN + f_1 * G_NF
    p_2 = G_NN + f_2 * G_NF
    if gamma_N >= 0.0 and (p_1 if P_1 > 0.0 else p_2) >= 0.0:
        return 0.0, 0.0, P_1, 0.0
    if p_1 > 0.0 and gamma_N + p_1 * P_1 >= 0.0:
        P_c = -gamma_N / p_1
    elif p_2 > SINGULAR * G_NN:
        P_c = P_1 - (gamma_N + p_1 * P_1) / p_2
    else:
        P_c = math.inf
        return P_c, f_2 * P_c, P_1, P_c
    P_N = P_c + expansion(law, e, gamma_N, p_1, P_1, p_2, P_c)
    return P_N, f_1 * min(P_N, P_1) + f_2 * max(0.0, P_N - P_1), P_1, P_c


@kernel
def first_phase(mu, G_NF, G_FF, gamma_F):
    """(f, P_1): friction ratio of the slide before the impact, and the normal impulse at which it has stopped."""
    if gamma_F == 0.0:
        return 0.0, 0.0
    s = math.copysign(1.0, gamma_F)
    k = G_NF - s * mu * G_FF
    return -s * mu, abs(gamma_F / k) if s * k < 0.0 else math.inf


@kernel
def second_ratio(mu, G_NF, G_FF):
    """Friction ratio once sliding has stopped: that of sticking, or of sliding back where the cone is too narrow."""
    if abs(G_NF) <= mu * G_FF:
        return -G_NF / G_FF
    return -math.copysign(mu, G_NF)


@kernel
def expansion(law, e, gamma_N, p_1, P_1, p_2, P_c):
    """Normal impulse of expansion, over which gamma_N grows from 0 with slope p_1 up to P_1, with p_2 beyond."""
    rest = max(0.0, P_1 - P_c)  # of the first slide
    w = p_1 * rest if rest > 0.0 else 0.0  # gamma_N where it ends
    if law == ImpactLaw.POISSON:
        return e * P_c
    if law == ImpactLaw.NEWTON:
        gamma = -e * gamma_N
        if rest > 0.0 and gamma <= w:
            return gamma / p_1
        return rest + (gamma - w) / p_2
    work = e * e * compression_work(gamma_N, p_1, P_1, P_c)
    if rest > 0.0:
        if 2.0 * work <= w * rest:
            return math.sqrt(2.0 * work / p_1)
        work -= 0.5 * w * rest
    return rest + (math.sqrt(w * w + 2.0 * p_2 * work) - w) / p_2


@kernel
def compression_work(gamma_N, p_1, P_1, P_c):
    """-int_0^P_c gamma_N dP, the area under the bent line."""
    if P_c <= P_1:
        return -0.5 * gamma_N * P_c
    w = gamma_N + p_1 * P_1
    return -0.5 * (gamma_N + w) * P_1 - 0.5 * w * (P_c - P_1)


@kernel
def follows_own_law(i, kinds, laws):
    """Whether impacts of contact i, the only one that is closed, follow another law than Newton's."""
    return laws[i, LAW_IMPACT] != 0.0 and laws[i, LAW_E_N] > 0.0 and kinds[i, 0] == UNILATERAL and kinds[i, 1] > 0


@rare_kernel
def impulses_by_law(laws, i, gamma_0, G, P):
    """Write the impulses of contact i, the only one that is closed, by its own law of impact; False where compression
    never ends, and P stays. The coefficient of friction is that before the impact."""
    mu = friction_coefficient(laws, i, abs(gamma_0[1]))
    P_N, P_F, _, P_c = impulse_map(
        int(laws[i, LAW_IMPACT]), laws[i, LAW_E_N], mu, G[0, 0], G[0, 1], G[1, 1], min(0.0, gamma_0[0]), gamma_0[1]
    )
    if P_c == math.inf:
        return False
    P[0], P[1] = P_N, P_F
    return True
