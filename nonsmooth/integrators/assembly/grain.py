"""Friction that differs by direction (scenes/elliptic_friction.py): tangents along the axes of its ellipse, to scale.

    t_1 along the projection of the grain on the tangents, of length s,   t_2 = n x t_1,
    mu_1^2 = s^2 along^2 + (1 - s^2) across^2,   mu_2 = across,   mu = max(mu_1, mu_2),
    rows  (mu_k/mu) t_k:    P_k = (mu_k/mu) P'_k,    |P'_T| <= mu P_N

mu_k^2 along t_k are those of the tensor along^2 e e^T + across^2 (1 - e e^T) on the tangents. The law of slip, along
the normal of the ellipse at P, is that of the round cone in P' and gamma', for P.gamma = P'.gamma': so all solvers,
their residual and the energy are those of round cones. Contacts are recorded in rows of length 1, with P, and mu of
the direction that P_T has.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import Contacts, Surfaces, has_same_normal
from nonsmooth.integrators.assembly.spatial import cross, turn_by, write_row
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.scenes.detection import FIRST_ROLLING, Found

END_GRAIN = 1e-9  # chosen: of the length of a direction: a projection that is shorter has none


@kernel("void(int64, int64, int64, int64, int64, int64)")
def turn_to_grain(bodies_at, surfaces_at, found_at, contacts_at, network_at, is_impact):
    """Turn the tangents of contacts to the grain of their bodies, of a step or of its impact."""
    bodies, surfaces, found = view(bodies_at, Bodies), view(surfaces_at, Surfaces), view(found_at, Found)
    contacts, network = view(contacts_at, Contacts), view(network_at, Network)
    for c in range(network.n_c):
        if found.key[c] < FIRST_ROLLING:
            a, b = surfaces.material[found.shape_i[c]], surfaces.material[found.shape_j[c]]
            along, across = surfaces.mu[a, b], surfaces.across[a, b]
            if along != across:
                turn_contact(bodies, surfaces, found, network, c, along, across)
                if is_impact == 0:
                    start_along_grain(found, contacts, network, c)


@kernel
def grain_of(bodies, surfaces, found, network, c):
    """The grain of contact c, in the axes of the world: that of the one side which has some."""
    s, b, g = found.shape_i[c], network.i[c], surfaces.grain
    if g[s, 0] == 0.0 and g[s, 1] == 0.0 and g[s, 2] == 0.0:
        s, b = found.shape_j[c], network.j[c]
    return turn_by(bodies.motion.x, b, g[s, 0], g[s, 1], g[s, 2])


@kernel
def turn_contact(bodies, surfaces, found, network, c, along, across):
    """The tangents of contact c along the axes of its ellipse, to scale, with what they ask of surfaces that run."""
    n = (found.normal[c, 0], found.normal[c, 1], found.normal[c, 2])
    point = (found.point[c, 0], found.point[c, 1], found.point[c, 2])
    old_1 = (network.J_j[c, 1, 0], network.J_j[c, 1, 1], network.J_j[c, 1, 2])
    old_2 = (network.J_j[c, 2, 0], network.J_j[c, 2, 1], network.J_j[c, 2, 2])
    e = grain_of(bodies, surfaces, found, network, c)
    over = e[0] * n[0] + e[1] * n[1] + e[2] * n[2]
    p_0, p_1, p_2 = e[0] - over * n[0], e[1] - over * n[1], e[2] - over * n[2]
    s = sqrt(p_0 * p_0 + p_1 * p_1 + p_2 * p_2)
    t = (p_0 / s, p_1 / s, p_2 / s) if s > END_GRAIN else old_1
    mu_1 = sqrt(s * s * along * along + (1.0 - s * s) * across * across) if s > END_GRAIN else across
    u = cross(n[0], n[1], n[2], t[0], t[1], t[2])
    mu = max(mu_1, across)
    network.mu[c] = mu
    for row, axis, scale in ((1, t, mu_1 / mu), (2, u, across / mu)):
        write_row(bodies, network.i[c], -scale, point, axis, network.J_i, c, row)
        write_row(bodies, network.j[c], scale, point, axis, network.J_j, c, row)
    for asked in (network.b, network.turn):
        of_1, of_2 = asked[c, 1], asked[c, 2]
        for row, axis, scale in ((1, t, mu_1 / mu), (2, u, across / mu)):
            to_1 = old_1[0] * axis[0] + old_1[1] * axis[1] + old_1[2] * axis[2]
            to_2 = old_2[0] * axis[0] + old_2[1] * axis[1] + old_2[2] * axis[2]
            asked[c, row] = scale * (of_1 * to_1 + of_2 * to_2)


@kernel
def start_along_grain(found, contacts, network, c):
    """The impulse of the step before in the rows of contact c, unless it has that normal, and so these rows."""
    at = contacts.source[c]
    if at < 0 or has_same_normal(found, contacts, c, at):
        return
    for row in range(1, 3):
        along, square = 0.0, 0.0
        for k in range(3):
            along += network.J_j[c, row, k] * contacts.P_before[at, k]
            square += network.J_j[c, row, k] * network.J_j[c, row, k]
        network.P[c, row] = along / square


class Upright(NamedTuple):
    """Rows of length 1, impulses along them, and coefficients in the directions of these."""

    frame: np.ndarray
    own: np.ndarray
    mu: np.ndarray


def upright(frame: np.ndarray, own: np.ndarray, mu: np.ndarray) -> Upright:
    """Rows (m, 3, 3) that are to scale, with the impulses (m, 3) along them and the coefficients (m,) of their round
    cones, as users are shown them."""
    scale = np.linalg.norm(frame, axis=2)
    sizes = [np.linalg.norm(P[:, 1:], axis=1) for P in (own, scale * own)]
    rubs = sizes[0] > 0.0
    part = np.divide(sizes[1], sizes[0], out=np.ones(len(own)), where=rubs)
    return Upright(frame / scale[:, :, None], scale * own, np.where(mu > 0.0, part * mu, mu))
