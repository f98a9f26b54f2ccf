"""One contact alone, which is most calls: scaled, solved in closed form and judged in one compiled call.

The steps are those of the ladder: powers of two bring G and c to order one, ``local_planar`` or ``local_spatial``
solves, the impulse is projected on its cone, and the natural map of the problem as it was given judges it.
"""

from __future__ import annotations

import math

from nonsmooth.contact.blocks.natural_map import cone_project, natural_map_of
from nonsmooth.contact.blocks.nsgs import local_planar
from nonsmooth.contact.blocks.single_spatial import local_spatial
from nonsmooth.jit import kernel
from nonsmooth.lcp.scaling import power_of_two, root_power_of_two


@kernel
def mean_diagonal(G, dim):
    """rho: tr G / dim; where that is not positive the largest entry of G, where that is 0 one."""
    trace, largest = 0.0, 0.0
    for a in range(dim):
        trace += G[0, a, a]
        for b in range(dim):
            largest = max(largest, abs(G[0, a, b]))
    if trace > 0.0:
        return trace / dim
    return largest if largest > 0.0 else 1.0


@kernel
def scale_contact(G, c, rho, dim, G_scaled):
    """Write G / s^2 and return (1 / (sigma s), sigma / s): c~ = c / (sigma s), P = (sigma / s) P~."""
    s, peak = root_power_of_two(rho), 0.0
    for a in range(dim):
        peak = max(peak, abs(c[a]))
        for b in range(dim):
            G_scaled[0, a, b] = G[0, a, b] / s / s
    sigma = power_of_two(peak / s)
    return 1.0 / (sigma * s), sigma / s


@kernel
def velocity_of_one(G, c, P, gamma, dim):
    """Write gamma = G P + c and return |c|."""
    peak, total = 0.0, 0.0
    for a in range(dim):
        peak = max(peak, abs(c[a]))
        gamma[a] = 0.0
        for b in range(dim):
            gamma[a] += G[0, a, b] * P[b]
        gamma[a] += c[a]
    for a in range(dim):
        total += (c[a] / peak) * (c[a] / peak) if peak > 0.0 else 0.0
    return math.sqrt(total) * peak


@kernel
def decide_one(G, c, mu, P, gamma, scaled, dim):
    """Write P and gamma of the contact with block G[0] (dim, dim); the errors with rho and with rho = 1."""
    rho, P_2 = mean_diagonal(G, dim), 0.0
    to_velocity, to_impulse = scale_contact(G, c, rho, dim, scaled)
    b_N, b_1 = c[0] * to_velocity, c[1] * to_velocity
    if dim == 2:
        P_N, P_1 = local_planar(scaled, 0, b_N, b_1, mu[0])
    else:
        P_N, P_1, P_2 = local_spatial(scaled, 0, b_N, b_1, c[2] * to_velocity, mu[0])
    P_N, P_1, P_2 = cone_project(mu[0], P_N, P_1, P_2)
    P[0] = to_impulse * P_N
    P[1] = to_impulse * P_1
    if dim == 3:
        P[2] = to_impulse * P_2
    return judge_one(G, c, mu, P, gamma, dim)


@kernel
def judge_one(G, c, mu, P, gamma, dim):
    """Write gamma of the impulse P; its errors with rho and with rho = 1."""
    rho, norm = mean_diagonal(G, dim), velocity_of_one(G, c, P, gamma, dim)
    weight = 1.0 / norm if norm > 0.0 else 1.0
    F, F_1 = natural_map_of(mu[0], rho, P, gamma, 0, dim), natural_map_of(mu[0], 1.0, P, gamma, 0, dim)
    return math.sqrt(weight * weight * F), math.sqrt(weight * weight * F_1)


@kernel(
    "UniTuple(float64, 2)(float64[:, :, ::1], float64[::1], float64[::1], float64[::1], float64[::1],"
    " float64[:, :, ::1])",
    takes_arrays=True,
)
def solve_one(G, c, mu, P, gamma, scaled):
    """`decide_one` for calls from Python; ``scaled``, as large as G, is scratch."""
    return decide_one(G, c, mu, P, gamma, scaled, c.shape[0])
