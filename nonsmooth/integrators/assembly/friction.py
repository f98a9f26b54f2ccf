"""Friction that varies with the slip: the coefficients of a step of a scene, by the laws of a `System`.

    mu = mu(|gamma_T|),    gamma_T = (J v_0 + J v_1)/2 + belt,    mu = mu_s where a contact sticks

at the mean velocity of the step, as `contact/planar/problem.py` takes it: a fixed point, since v_1 depends on mu. A
contact of static and kinetic friction that stuck in the step before, or whose slide turns back within the step, holds
up to mu_s; where that is not enough, it has mu_k. Steps of scenes without such laws do not come here.
"""

from __future__ import annotations

import math

from nonsmooth.contact.network.joint import is_contact
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.planar.problem import MU_ROUNDINGS
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import Contacts, Surfaces, is_within_cone
from nonsmooth.integrators.assembly.wandering import row_velocity
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.mechanics.laws import (
    LAW_CODE,
    STATIC_KINETIC,
    depends_on_speed,
    friction_coefficient,
    is_no_friction,
    static_coefficient,
)
from nonsmooth.numerics.rounding import rounded_sum
from nonsmooth.scenes.detection import Found
from nonsmooth.scenes.shape_rows import Shapes

UNCHANGED, CHANGED = 0, 1  # code: of the coefficients of a step; below 0: that of contact -1 - code is none
STILL_ROUNDINGS = 16  # chosen: of a sliding velocity, a difference of those of two bodies: what is smaller is 0


@kernel("void(int64, int64, int64, int64, int64, int64)")
def take_friction(bodies_at, shapes_at, surfaces_at, found_at, contacts_at, network_at):
    """Take the coefficients at the velocities with which a step begins."""
    bodies, shapes, surfaces = view(bodies_at, Bodies), view(shapes_at, Shapes), view(surfaces_at, Surfaces)
    found, contacts, network = view(found_at, Found), view(contacts_at, Contacts), view(network_at, Network)
    for c in range(network.n_c):
        if not is_contact(network, c):
            continue
        k, at = law_of(shapes, surfaces, found, c), contacts.source[c]
        speed, size = mean_slip(network, c, bodies.v_0, bodies.v_0)
        is_still = contacts.stuck_before[at] == 1 if at >= 0 else speed <= rounded_sum(STILL_ROUNDINGS, size)
        contacts.was_static[c] = is_still
        if is_still:
            network.mu[c] = static_coefficient(surfaces.laws, k)
        else:
            mu = friction_coefficient(surfaces.laws, k, speed)
            network.mu[c] = 0.0 if is_no_friction(mu) else mu


@kernel("int64(int64, int64, int64, int64, int64, int64, float64)")
def update_friction(bodies_at, shapes_at, surfaces_at, found_at, contacts_at, network_at, tol):
    """Take the coefficients at the velocities that a solution leads to; whether one of them changed."""
    bodies, shapes, surfaces = view(bodies_at, Bodies), view(shapes_at, Shapes), view(surfaces_at, Surfaces)
    found, contacts, network = view(found_at, Found), view(contacts_at, Contacts), view(network_at, Network)
    end = UNCHANGED
    for c in range(network.n_c):
        if not is_contact(network, c) or network.P[c, 0] <= 0.0:
            continue
        k, mu = law_of(shapes, surfaces, found, c), network.mu[c]
        if surfaces.laws[k, LAW_CODE] == STATIC_KINETIC:
            is_held = is_within_cone(network, c)
            if contacts.was_static[c] == 0 and not is_held and turns_back(network, c, bodies.v_0):
                mu, contacts.was_static[c] = static_coefficient(surfaces.laws, k), 1
            elif not is_held:
                mu = friction_coefficient(surfaces.laws, k, 0.0)
        elif depends_on_speed(surfaces.laws, k):
            mu = friction_coefficient(surfaces.laws, k, mean_slip(network, c, bodies.v_0, network.v)[0])
            if is_no_friction(mu):
                return -1 - c
        if abs(mu - network.mu[c]) > max(rounded_sum(MU_ROUNDINGS, mu), tol * mu):
            end = CHANGED
        network.mu[c] = mu
    return end


@kernel
def law_of(shapes, surfaces, found, c):
    """The row of the law of contact c."""
    a, b = surfaces.material[found.shape_i[c]], surfaces.material[found.shape_j[c]]
    return a * surfaces.mu.shape[0] + b


@kernel
def turns_back(network, c, v_0):
    """Whether the slide of contact c is against that of the beginning of the step."""
    total = 0.0
    for row in range(1, network.b.shape[1]):
        belt = network.b[c, row] - network.turn[c, row]
        total += (row_velocity(network, c, row, v_0)[0] + belt) * (row_velocity(network, c, row, network.v)[0] + belt)
    return total < 0.0


@kernel
def mean_slip(network, c, v_0, v_1):
    """|gamma_T| of contact c at the mean of two velocities, and the sum of the sizes of its terms."""
    square, sizes = 0.0, 0.0
    for row in range(1, network.b.shape[1]):
        first, size_0 = row_velocity(network, c, row, v_0)
        last, size_1 = row_velocity(network, c, row, v_1)
        belt = network.b[c, row] - network.turn[c, row]
        square += (0.5 * (first + last) + belt) ** 2
        sizes += size_0 + size_1 + abs(belt)
    return math.sqrt(square), sizes
