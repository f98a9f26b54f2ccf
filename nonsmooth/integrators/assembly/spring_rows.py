"""Springs in a step, implicit: a spring is two contacts without friction that give way, one pushes and one pulls.

    P/dt = -k (delta_0 + theta dt gamma) - c gamma,    gamma = (1 - theta) gamma_0 + theta gamma_1

has no largest step; theta is that of the places. With 1/2 it is the mid-point rule, of second order, which keeps the
energy of a linear spring. As a row:

    gamma_1 + R P + b = 0,   R = 1/(dt A),   b = (1 - theta)/theta gamma_0 + k delta_0/A,   A = theta (theta k dt + c)

with delta the stretch and gamma its rate along the row. The two contacts 0 <= P_+ _|_ gamma_1 + R P_+ + b >= 0 and
0 <= P_- _|_ -gamma_1 + R P_- - b >= 0 have the one solution P = P_+ - P_-, so that springs, joints and contacts are one
problem, in the same islands, and every solver of contacts knows springs. In an impact a spring has no impulse.

The row of a spring of length l > 0 is the line between its ends; one of length 0 has a row along each axis of the
world; that of a torsion spring in the plane is the relative angle. Rows of springs stand between contacts and joints.

Source: for R and b, Acary and Brogliato, *Numerical Methods for Nonsmooth Dynamical Systems* (2008), section 1.1;
moreau_jean/compliance.py has the same of compliant contacts.
"""

from __future__ import annotations

from math import sqrt
from typing import Annotated as Array

from nonsmooth.contact.network.joint import SPRUNG
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.integrators.assembly.joint_rows import arm_at
from nonsmooth.integrators.assembly.wandering import row_velocity
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, new, view
from nonsmooth.scenes.detection import FEATURE_BITS, FIRST_JOINT, FIRST_SPRING, NO_SHAPE, Found

ALONG, TORSION = -1, -2  # code: in the place of an axis: the line between the ends, the relative angle
SPRUNG_GAP = 1e30  # code: the gap of a row of a spring [m], which no contact has
NO_LINE = 1e-12  # chosen: of the lengths of the arms: ends that are nearer have no line between them
LEAST_COSINE = 0.5  # chosen: cosine of the angle by which the line of a spring may turn in half a step
SIDES = 2  # defined: rows of an axis of a spring


class Springs(Block):
    """n_a rows of springs, each of an axis."""

    count: int
    shape_i: Array[Ints, "n_a"]  # a shape of either body
    shape_j: Array[Ints, "n_a"]
    i: Array[Ints, "n_a"]  # the bodies
    j: Array[Ints, "n_a"]
    arm_i: Array[Floats, "n_a", "d"]  # of its ends from their centres of mass, along their axes [m]
    arm_j: Array[Floats, "n_a", "d"]
    axis: Array[Ints, "n_a"]  # of the world, ALONG or TORSION
    stiffness: Array[Floats, "n_a"]  # [N/m], [N m/rad]
    damping: Array[Floats, "n_a"]  # [N s/m], [N m s/rad]
    length: Array[Floats, "n_a"]  # [m], [rad]


def no_springs(dim: int) -> Springs:
    """The block of a scene without springs."""
    return new(Springs, n_a=0, d=dim)


@kernel
def spring_of(key):
    """The row of ``Springs`` of a key."""
    return ((key >> FEATURE_BITS) & NO_SHAPE) // SIDES


@kernel
def ends_of(springs, x, k):
    """Where the ends of spring k are, bodies at places x."""
    i, j = springs.i[k], springs.j[k]
    a, e = arm_at(x, i, springs.arm_i, k), arm_at(x, j, springs.arm_j, k)
    z_i, z_j = (x[i, 2], x[j, 2]) if x.shape[1] > 3 else (0.0, 0.0)
    return (x[i, 0] + a[0], x[i, 1] + a[1], z_i + a[2]), (x[j, 0] + e[0], x[j, 1] + e[1], z_j + e[2])


@kernel
def line_of(springs, x, k):
    """The direction of spring k from its first end to the other, and its length; of a torsion spring its angle."""
    first, second = ends_of(springs, x, k)
    d_0, d_1, d_2 = second[0] - first[0], second[1] - first[1], second[2] - first[2]
    axis = springs.axis[k]
    if axis == TORSION:
        return 1.0, 0.0, 0.0, x[springs.j[k], 2] - x[springs.i[k], 2]
    if axis == 0:
        return 1.0, 0.0, 0.0, d_0
    if axis == 1:
        return 0.0, 1.0, 0.0, d_1
    if axis == 2:
        return 0.0, 0.0, 1.0, d_2
    length, size = sqrt(d_0 * d_0 + d_1 * d_1 + d_2 * d_2), springs.length[k]
    if length <= NO_LINE * size:
        return 1.0, 0.0, 0.0, length
    return d_0 / length, d_1 / length, d_2 / length, length


@kernel
def direction_of(springs, bodies, k):
    """The direction of spring k where its contacts are looked for; of one that the step does not resolve, which turns
    too far until there, that at the beginning."""
    n_0, n_1, n_2, _ = line_of(springs, bodies.motion.x, k)
    s_0, s_1, s_2, _ = line_of(springs, bodies.x_0, k)
    if n_0 * s_0 + n_1 * s_1 + n_2 * s_2 < LEAST_COSINE:
        return s_0, s_1, s_2
    return n_0, n_1, n_2


@kernel
def add_springs(springs, bodies, found, n):
    """Write the springs of bodies that are not both still behind the first n contacts; the new n."""
    d, motion = found.normal.shape[1], bodies.motion
    for k in range(springs.count):
        i, j = springs.i[k], springs.j[k]
        if motion.still[i] == 1 and motion.still[j] == 1:
            continue
        n_0, n_1, n_2 = direction_of(springs, bodies, k)
        first, second = ends_of(springs, motion.x, k)
        for side in range(SIDES):
            sign = 1.0 - 2.0 * side
            found.shape_i[n], found.shape_j[n] = springs.shape_i[k], springs.shape_j[k]
            found.key[n], found.gap[n] = FIRST_SPRING | ((SIDES * k + side) << FEATURE_BITS), 0.0
            for a in range(d):
                along = n_0 if a == 0 else n_1 if a == 1 else n_2
                found.normal[n, a], found.point[n, a] = sign * along, 0.5 * (first[a] + second[a])
            n += 1
    return n


@kernel("void(int64, int64, int64, int64, int64, int64, float64)")
def write_springs(springs_at, bodies_at, found_at, contacts_at, network_at, is_impact, dt):
    """Make springs of their rows, which were written as contacts; those of an impact ask for nothing."""
    springs, bodies, found = view(springs_at, Springs), view(bodies_at, Bodies), view(found_at, Found)
    contacts, network = view(contacts_at, Contacts), view(network_at, Network)
    for c in range(network.n_c):
        if FIRST_SPRING <= found.key[c] < FIRST_JOINT:
            found.gap[c], network.mu[c], network.sprung[c], contacts.e[c] = SPRUNG_GAP, 0.0, SPRUNG, 0.0
            k = spring_of(found.key[c])
            if springs.axis[k] == TORSION:
                write_angle(network, c, 1.0 if found.normal[c, 0] > 0.0 else -1.0)
            for row in range(network.b.shape[1]):
                network.b[c, row] = network.turn[c, row] = 0.0
            if is_impact == 1:
                network.b[c, 0] = SPRUNG_GAP
            else:
                write_law_of_spring(springs, bodies, found, network, c, k, dt)


@kernel
def write_angle(network, c, sign):
    """The row of the relative angle in the plane."""
    for x in range(2):
        network.J_i[c, 0, x] = network.J_j[c, 0, x] = 0.0
    network.J_i[c, 0, 2], network.J_j[c, 0, 2] = -sign, sign


@kernel
def write_law_of_spring(springs, bodies, found, network, c, k, dt):
    """R and b of row c of spring k, from where it is at the beginning of the step."""
    _, _, _, length = line_of(springs, bodies.x_0, k)
    side = ((found.key[c] >> FEATURE_BITS) & NO_SHAPE) % SIDES
    stretch = (1.0 - 2.0 * side) * (length - springs.length[k])
    rate, _ = row_velocity(network, c, 0, bodies.v_0)
    theta = 1.0 - 0.5 * bodies.lead
    A = theta * (theta * springs.stiffness[k] * dt + springs.damping[k])
    network.soft[c] = 1.0 / (dt * A)
    network.b[c, 0] = (1.0 - theta) / theta * rate + springs.stiffness[k] * stretch / A
