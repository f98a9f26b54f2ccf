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

from nonsmooth.contact.network.joint import is_contact
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.book import book_contact
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view

SHARE_TOLD = 1.0 - 1e-6  # chosen: s of a rebound that is counted: what is nearer to 1 is what the solvers leave


@kernel
def work_of(bodies, network, c, v_before, d, n):
    """P.(gamma_before + gamma)/2 of contact c, relative to running surfaces."""
    normal, friction, _ = book_contact(bodies, network, c, v_before, d, n)
    return normal + friction


@kernel
def note_landing(bodies, contacts, network, d):
    """What each contact takes from the free motion in landing, -W_-."""
    for c in range(network.n_c):
        contacts.lost[c] = -work_of(bodies, network, c, bodies.v_free, d, 3 * (d - 1))


@kernel
def share_of_rebound(bodies, contacts, network, k, d, n):
    """s of island k."""
    islands, work, last, given_back, hits = network.islands, 0.0, 0.0, 0.0, 0
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c = islands.contacts[at]
        work += work_of(bodies, network, c, network.v_free, d, n)
        last += work_of(bodies, network, c, network.v, d, n)
        given_back += contacts.e[c] * contacts.e[c] * contacts.lost[c]
        is_hit = network.P[c, 0] != 0.0 or contacts.lost[c] != 0.0
        hits += 1 if is_hit and is_contact(network, c) else 0
    given_back, first = max(0.0, given_back), 2.0 * work - last
    if hits < 2 or work <= given_back:
        return 1.0
    return (sqrt(first * first + 2.0 * (last - first) * given_back) - first) / (last - first)


@kernel("int64(int64, int64, int64, int64)")
def limit_rebounds(bodies_at, contacts_at, network_at, d):
    """Scale the impulses of islands whose contacts would give back more than they took; returns 1 if there are such."""
    bodies, contacts, network = view(bodies_at, Bodies), view(contacts_at, Contacts), view(network_at, Network)
    islands, n, is_any = network.islands, 3 * (d - 1), 0
    for k in range(islands.count):
        s = share_of_rebound(bodies, contacts, network, k, d, n)
        if s == 1.0:
            continue
        is_any = 1 if s < SHARE_TOLD else is_any
        for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
            for row in range(d):
                network.P[islands.contacts[at], row] *= s
        for at in range(islands.body_start[k], islands.body_start[k + 1]):
            b = islands.bodies[at]
            for x in range(n):
                network.v[b, x] = network.v_free[b, x] + s * (network.v[b, x] - network.v_free[b, x])
    return is_any
