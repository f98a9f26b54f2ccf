"""The error of a frictional contact problem, in one number without units.

    gamma = G P + c,    uhat_i = gamma_i + mu_i |gamma_T,i| e_N
    F_i = rho_i P_i - proj_K(rho_i P_i - uhat_i),    error = |F| / |c|

with K = {|P_T| <= mu P_N} and rho_i the mean diagonal of G_ii. F = 0 is the inclusion K* contains uhat _|_ P in K.

Source: De Saxce and Feng, Math. Comput. Model. 28 (1998) 225-245; Acary, Bremond and Huber, in: Advanced Topics in
Nonsmooth Dynamics (2018) 375-457.
Equations: docs/theory/contact_solvers.md, (2).
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel


@kernel
def velocity(G, indices, indptr, c, P, gamma):
    """gamma = G P + c for a block matrix G (n_blocks, dim, dim) of compressed rows."""
    dim = G.shape[1]
    for i in range(indptr.shape[0] - 1):
        for a in range(dim):
            total = 0.0
            for k in range(indptr[i], indptr[i + 1]):
                j = indices[k] * dim
                for b in range(dim):
                    total += G[k, a, b] * P[j + b]
            gamma[i * dim + a] = total + c[i * dim + a]


@kernel
def cone_project(mu, y_N, y_1, y_2):
    """Orthogonal projection of (y_N, y_1, y_2) on the cone |P_T| <= mu P_N."""
    y_T = math.sqrt(y_1 * y_1 + y_2 * y_2)
    if y_N >= 0.0 and y_T <= mu * y_N:  # y_N < 0 is outside also where mu y_N = -0
        return y_N, y_1, y_2
    if mu * y_T <= -y_N:
        return 0.0, 0.0, 0.0
    x_N = (y_N + mu * y_T) / (1.0 + mu * mu)
    return x_N, mu * x_N * (y_1 / y_T), mu * x_N * (y_2 / y_T)


@kernel
def put_on_cones(mu, P, dim):
    """Project the impulses on their cones, from which they are some roundings away."""
    for i in range(mu.shape[0]):
        k = i * dim
        P_N, P_1, P_2 = cone_project(mu[i], P[k], P[k + 1], P[k + 2] if dim == 3 else 0.0)
        P[k] = P_N
        P[k + 1] = P_1
        if dim == 3:
            P[k + 2] = P_2


@kernel
def natural_map_of(mu, rho, P, gamma, k, dim):
    """|F_i|^2 of the contact whose rows begin at k."""
    P_2 = 0.0
    gamma_2 = 0.0
    if dim == 3:
        P_2 = rho * P[k + 2]
        gamma_2 = gamma[k + 2]
    P_N = rho * P[k]
    P_1 = rho * P[k + 1]
    gamma_N = gamma[k] + mu * math.sqrt(gamma[k + 1] * gamma[k + 1] + gamma_2 * gamma_2)
    x_N, x_1, x_2 = cone_project(mu, P_N - gamma_N, P_1 - gamma[k + 1], P_2 - gamma_2)
    F_N, F_1, F_2 = P_N - x_N, P_1 - x_1, P_2 - x_2
    return F_N * F_N + F_1 * F_1 + F_2 * F_2


@kernel
def natural_map(mu, rho, weight, P, gamma, dim):
    """The norm of (weight_i |F_i|)_i."""
    total = 0.0
    for i in range(mu.shape[0]):
        total += weight[i] * weight[i] * natural_map_of(mu[i], rho[i], P, gamma, i * dim, dim)
    return math.sqrt(total)


@kernel("void(float64[:, :, ::1], int32[::1], int32[::1], float64[::1], float64[::1], float64[::1])", takes_arrays=True)
def velocity_entry(G, indices, indptr, c, P, gamma):
    """`velocity` for calls from Python."""
    velocity(G, indices, indptr, c, P, gamma)


@kernel("float64(float64[::1], float64[::1], float64[::1], float64[::1], float64[::1], int64)", takes_arrays=True)
def natural_map_entry(mu, rho, weight, P, gamma, dim):
    """`natural_map` for calls from Python."""
    return natural_map(mu, rho, weight, P, gamma, dim)


@kernel("void(float64[::1], float64[::1], int64)", takes_arrays=True)
def put_on_cones_entry(mu, P, dim):
    """`put_on_cones` for calls from Python."""
    put_on_cones(mu, P, dim)
