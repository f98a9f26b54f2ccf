"""Rebounds of several contacts give back no more than what they took.

Newton's law asks each contact of an island for e times its own velocity of approach, whatever the others do, and may
ask for more energy than there was. With W_- = sum P.(gamma_free + gamma_l)/2 the work of the contacts in landing, and
that of the rebound, of impulses s P from the velocities gamma_1 after the landing to gamma_2,

    W_+(s) = s P.gamma_1 + s^2 P.(gamma_2 - gamma_1)/2 <= -sum e^2 W_-

is kept by the largest s <= 1: scaled impulses stay in their cones, and momentum is kept. What then still approaches
lands again in the next step. One contact alone keeps Newton's law.
"""

from __future__ import annotations

from math import sqrt

from nonsmooth.contact.network.joint import is_joint
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view


@kernel
def power(network, c, v, d, n):
    """P.gamma of contact c at velocities v (n_b, n), gamma relative to running surfaces."""
    i, j, total = network.i[c], network.j[c], 0.0
    for row in range(d):
        gamma = network.b[c, row] if row > 0 else 0.0
        for x in range(n):
            gamma += network.J_i[c, row, x] * v[i, x] + network.J_j[c, row, x] * v[j, x]
        total += network.P[c, row] * gamma
    return total


@kernel
def share_of_rebound(contacts, network, k, d, n):
    """s of island k."""
    islands, first, last, given_back, hits = network.islands, 0.0, 0.0, 0.0, 0
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        first += power(network, c, network.v_free, d, n)
        last += power(network, c, network.v, d, n)
        given_back += contacts.e[c] * contacts.e[c] * contacts.lost[c]
        is_hit = network.P[c, 0] != 0.0 or contacts.lost[c] != 0.0
        hits += 1 if is_hit and not is_joint(network, c) else 0
    given_back = max(0.0, given_back)
    if hits < 2 or 0.5 * (first + last) <= given_back:
        return 1.0
    return (sqrt(first * first + 2.0 * (last - first) * given_back) - first) / (last - first)


@kernel("void(int64, int64, int64)")
def limit_rebounds(contacts_at, network_at, d):
    """Scale the impulses of islands whose contacts would give back more than they took."""
    contacts, network = view(contacts_at, Contacts), view(network_at, Network)
    islands, n = network.islands, 3 * (d - 1)
    for k in range(islands.count):
        s = share_of_rebound(contacts, network, k, d, n)
        if s == 1.0:
            continue
        for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
            for row in range(d):
                network.P[islands.contacts[at], row] *= s
        for at in range(islands.body_start[k], islands.body_start[k + 1]):
            b = islands.bodies[at]
            for x in range(n):
                network.v[b, x] = network.v_free[b, x] + s * (network.v[b, x] - network.v_free[b, x])
