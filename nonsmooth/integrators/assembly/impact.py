"""Restitution: a contact that closes in a step lands, moves with its bodies, and rebounds from where it is.

    gamma_plus + e gamma_minus >= 0  _|_  P >= 0 at the contacts that landed,  gamma_plus >= 0 at those that are closed

gamma_minus is the velocity of approach of the free motion where its gap g closes, on the parabola

    gamma_minus^2 = gamma_0^2 - 2 a g,    a = (gamma_free - gamma_0)/dt

so that a body that falls, lands and is thrown back without loss has the energy that it had. To feed the gap back and
let the contact rebound one step later instead gives e = 0.33, 0.49, 0.01, 0.37 at dt = 1e-2, 1.1e-3, 1e-3, 1e-4 where
0.5 was asked for. A rebound slower than what gravity gives within a step is none: it would never rest.

The landing takes (gamma_minus^2 - gamma_l^2)/(2 G_0) from the motion along the normal, and leaves gamma_l of it;
bodies turn on the way to the place where they rebound, where G_0 = J M^-1 J^T has become G_1, and gamma_l the velocity
gamma_1. What is given back there is e^2 of what was taken, and of what is left,

    gamma_plus^2 = e^2 (gamma_1^2 + (G_1/G_0)(gamma_minus^2 - gamma_l^2))

which is e^2 gamma_minus^2 for bodies that do not turn, and is taken to be that where the impulses of others made the
contact land faster than it came. With the velocity alone an elastic ellipsoid that tumbles gains and loses up to 2 % of
its energy at an impact, at a spin of 50/s and dt = 1 ms.

The rows are those of the places after the step (landed.py): the impulses of both sides act at one point, and angular
momentum is kept.
Equations: docs/theory/scenes.md, (8).
"""

from __future__ import annotations

from math import sqrt

from nonsmooth.contact.network.joint import is_contact
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies, fall_of
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.integrators.assembly.energy_limit import note_landing
from nonsmooth.integrators.assembly.landed import go_on
from nonsmooth.integrators.assembly.of_body import write_rows
from nonsmooth.integrators.assembly.project import EXACT_VELOCITY, normal_velocity, turn_of_limit
from nonsmooth.integrators.assembly.spatial import take_spins
from nonsmooth.jit import in_dimensions, kernel
from nonsmooth.jit.blocks import view
from nonsmooth.scenes.detection import Found
from nonsmooth.scenes.shape_rows import Shapes

NOT_MET_YET = 1e3  # chosen: times the fastest approach of the step: no impact throws contacts together faster


@kernel
def approach(gap, gamma_0, gamma_free, dt):
    """gamma_minus: the velocity of approach where the gap of a free motion closes, between those of the step."""
    if gap <= 0.0:
        return gamma_0
    landing = -sqrt(max(0.0, gamma_0 * gamma_0 - 2.0 * (gamma_free - gamma_0) / dt * gap))
    return min(max(landing, min(gamma_0, gamma_free)), max(gamma_0, gamma_free))


@kernel
def mark_impacts(bodies, found, contacts, network, dt, whole, n):
    """Mark the contacts that rebound, with gamma_minus and what their landing took along the normal; returns how many
    do."""
    slowest, count = fall_of(bodies, whole), 0
    for c in range(network.n_c):
        contacts.impact[c] = 0
        if contacts.e[c] > 0.0 and network.P[c, 0] > 0.0:
            gamma_0, size = normal_velocity(network, c, bodies.v_0, n)
            gamma_free, _ = normal_velocity(network, c, bodies.v_free, n)
            turn = contacts.wander[c] + turn_of_limit(network, c)
            gamma_0, gamma_free = gamma_0 - turn, gamma_free + turn
            gamma_minus = approach(found.gap[c], gamma_0, gamma_free, dt)
            if -contacts.e[c] * gamma_minus > max(slowest, EXACT_VELOCITY * size):
                gamma_l, _ = normal_velocity(network, c, network.v, n)
                gamma_l += turn_of_limit(network, c)
                taken = (gamma_minus * gamma_minus - gamma_l * gamma_l) / (network.W[c, 0, 0] - network.soft[c])
                contacts.gamma_minus[c], contacts.taken[c] = gamma_minus, taken
                contacts.impact[c] = 1
                count += 1
    return count


@kernel
def write_impact(bodies, shapes, found, contacts, network, dt, d):
    """The contact problem of the impact: it begins at the velocities after the step, and from no impulse. Contacts that
    are still open and can rebound ask for nothing: what throws them together now lands in a step to come."""
    n, far = 3 * (d - 1), 0.0
    for c in range(network.n_c):
        gamma, _ = normal_velocity(network, c, bodies.v_free, n)
        far = max(far, NOT_MET_YET * abs(gamma))
    for c in range(network.n_c):
        if is_contact(network, c):
            go_on(bodies, shapes, found, network, c, dt, d)
        if found.gap[c] <= 0.0 or network.P[c, 0] > 0.0:
            network.b[c, 0] = 0.0
        else:
            moved, _ = normal_velocity(network, c, bodies.v_move, n)
            left = found.gap[c] / dt + moved
            network.b[c, 0] = left + far if left > 0.0 and contacts.e[c] > 0.0 else max(0.0, left)
        for row in range(d):
            network.P[c, row] = network.turn[c, row] = 0.0
    for b in range(network.v.shape[0]):
        for x in range(n):
            network.v_free[b, x] = network.v[b, x]


@in_dimensions("int64(int64, int64, int64, int64, int64, float64, float64)")
def begin_impact(bodies_at, shapes_at, found_at, contacts_at, network_at, dt, whole, d):
    """Write the contact problem of the impacts of a step; returns how many contacts rebound."""
    bodies, shapes, found = view(bodies_at, Bodies), view(shapes_at, Shapes), view(found_at, Found)
    contacts, network = view(contacts_at, Contacts), view(network_at, Network)
    count = mark_impacts(bodies, found, contacts, network, dt, whole, 3 * (d - 1))
    if count > 0:
        note_landing(bodies, contacts, network, d)
        if d == 3:
            take_spins(bodies, network.v)
        write_impact(bodies, shapes, found, contacts, network, dt, d)
        for c in range(network.n_c):
            write_rows(bodies, found, c, network, d)
    return count


@kernel("void(int64, int64)")
def ask_rebounds(contacts_at, network_at):
    """The normal velocities that the contacts that landed are to have, of the rows after the step, which are prepared;
    in the plane or in space."""
    contacts, network = view(contacts_at, Contacts), view(network_at, Network)
    for c in range(network.n_c):
        if contacts.impact[c] == 1:
            gamma_minus = contacts.gamma_minus[c]
            if contacts.taken[c] > 0.0:  # else others threw it at its contact
                gamma_1, _ = normal_velocity(network, c, network.v_free, network.v.shape[1])
                gamma_minus = -sqrt(gamma_1 * gamma_1 + network.W[c, 0, 0] * contacts.taken[c])
            network.b[c, 0] = contacts.e[c] * gamma_minus
