"""Restitution: a contact that closes in a step lands, moves with its bodies, and rebounds from where it is.

    gamma_plus + e gamma_minus >= 0  _|_  P >= 0 at the contacts that landed,  gamma_plus >= 0 at those that are closed

gamma_minus is the velocity of approach of the free motion, before any impulse of the step. To feed the gap back and
let the contact rebound one step later instead gives e = 0.33, 0.49, 0.01, 0.37 at dt = 1e-2, 1.1e-3, 1e-3, 1e-4 where
0.5 was asked for. A rebound slower than what gravity gives within a step is none: it would never rest.

The rows are those of the places after the step, the point of contact moved with its surfaces: the impulses of both
sides act at one point, and angular momentum is kept.
"""

from __future__ import annotations

from math import sqrt

from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.integrators.assembly.planar import write_rows_planar
from nonsmooth.integrators.assembly.project import normal_velocity
from nonsmooth.integrators.assembly.spatial import write_rows_spatial
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.scenes.detection import Found


@kernel
def mark_impacts(bodies, contacts, network, dt, n):
    """Mark the contacts that rebound; returns how many do."""
    slowest = 0.0
    for k in range(bodies.gravity.shape[0]):
        slowest += bodies.gravity[k] * bodies.gravity[k]
    slowest = dt * sqrt(slowest)
    count = 0
    for c in range(network.n_c):
        contacts.impact[c] = 0
        if contacts.e[c] > 0.0 and network.P[c, 0] > 0.0:
            approach, _ = normal_velocity(network, c, bodies.v_free, n)
            contacts.gamma_minus[c] = approach
            if -contacts.e[c] * approach > slowest:
                contacts.impact[c] = 1
                count += 1
    return count


@kernel
def write_impact(bodies, found, contacts, network, dt, d, n):
    """The contact problem of the impact: it begins at the velocities after the step, and from no impulse."""
    for c in range(network.n_c):
        for k in range(d):  # the first columns of a frame's rows are its axes
            moved = 0.0
            for row in range(d):
                i, j, mean = network.i[c], network.j[c], 0.0
                for x in range(n):
                    way_i = dt * bodies.v_move[i, x] - bodies.ahead[i] * bodies.v_0[i, x]
                    way_j = dt * bodies.v_move[j, x] - bodies.ahead[j] * bodies.v_0[j, x]
                    mean += 0.5 * (network.J_j[c, row, x] * way_j - network.J_i[c, row, x] * way_i)
                moved += network.J_j[c, row, k] * mean
            found.point[c, k] += moved
        if contacts.impact[c] == 1:
            network.b[c, 0] = contacts.e[c] * contacts.gamma_minus[c]
        elif found.gap[c] <= 0.0 or network.P[c, 0] > 0.0:
            network.b[c, 0] = 0.0
        else:
            moved, _ = normal_velocity(network, c, bodies.v_move, n)
            network.b[c, 0] = max(0.0, found.gap[c] / dt + moved)
        for row in range(d):
            network.P[c, row] = 0.0
    for b in range(network.v.shape[0]):
        for x in range(n):
            network.v_free[b, x] = network.v[b, x]


@kernel("int64(int64, int64, int64, int64, float64)")
def begin_impact_planar(bodies_at, found_at, contacts_at, network_at, dt):
    """Write the contact problem of the impacts of a planar step; returns how many contacts rebound."""
    bodies, found = view(bodies_at, Bodies), view(found_at, Found)
    contacts, network = view(contacts_at, Contacts), view(network_at, Network)
    count = mark_impacts(bodies, contacts, network, dt, 3)
    if count > 0:
        write_impact(bodies, found, contacts, network, dt, 2, 3)
        for c in range(network.n_c):
            write_rows_planar(bodies, found, c, network)
    return count


@kernel("int64(int64, int64, int64, int64, float64)")
def begin_impact_spatial(bodies_at, found_at, contacts_at, network_at, dt):
    """Write the contact problem of the impacts of a spatial step; returns how many contacts rebound."""
    bodies, found = view(bodies_at, Bodies), view(found_at, Found)
    contacts, network = view(contacts_at, Contacts), view(network_at, Network)
    count = mark_impacts(bodies, contacts, network, dt, 6)
    if count > 0:
        write_impact(bodies, found, contacts, network, dt, 3, 6)
        for c in range(network.n_c):
            write_rows_spatial(bodies, found, c, network)
    return count
