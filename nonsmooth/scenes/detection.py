"""What detection of contacts is handed and what it finds: the motion of the bodies, and contacts with keys.

A candidate is kept when its gap is below the margin now or, at the velocities handed in, by the end of the step:

    g_N + dt min(gamma_N, 0) < margin,        gamma_N = n . (v_j + w_j x (p - x_j) - v_i - w_i x (p - x_i))
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints

SHAPE_BITS = 22  # chosen: of a key, for either shape: four million of them
FEATURE_BITS = 19  # derived: of a key, what two shapes leave of 63
LAST_FEATURE = (1 << FEATURE_BITS) - 1  # derived: the bits of a key that say what touches
NO_SHAPE = (1 << SHAPE_BITS) - 1  # derived: the last number of a shape: in keys, that of joints
FIRST_JOINT = NO_SHAPE << (SHAPE_BITS + FEATURE_BITS)  # derived: above the keys of all contacts
FIRST_SPRING = (NO_SHAPE - 1) << (SHAPE_BITS + FEATURE_BITS)  # derived: and those of springs below the ones of joints
FIRST_DRIVE = (NO_SHAPE - 2) << (SHAPE_BITS + FEATURE_BITS)  # derived: and those of drives of joints below these
FIRST_ROLLING = (NO_SHAPE - 3) << (SHAPE_BITS + FEATURE_BITS)  # derived: and of rolling friction below these
# chosen: no line of an ordinary scene is across it: of two shapes alike the one that is farther back along it is asked
# first
ASKEW = (0.3183, 0.3679, 1.0)
# chosen, of the reaches of both: the face of the first is the reference unless one of the other is farther out by more
# than this, which is above the rounding of a separation. Keys do not depend on it: whichever of two parallel faces it
# is, the ends of the overlap are the same features. It is a hundredth of SAME_PLACE, so that a corner is told by the
# farthest face.
FACE_PREFERENCE = 1e-12
# chosen, of the reaches and radii of both: points nearer than this, whose difference has lost the digits of a
# direction (6 are left), have the normal of a face.
SAME_PLACE = 1e-10
NOT_FINITE = -(2**62)  # code: a body or a shape is nowhere, or so far out that its cell has no number


class Motion(Block):
    """Where the bodies are and how they move; the integrator owns it.

    A planar body has x = (x, y, angle) and v = (vx, vy, omega); a spatial one x = (position, unit quaternion w x y z)
    and v = (velocity, angular velocity in world axes).
    """

    x: Array[Floats, "n_b", "n_x"]  # [m], [rad]
    v: Array[Floats, "n_b", "n"]  # [m/s], [rad/s]
    moves: Array[Ints, "n_b"]  # 1 where the inverse mass is not zero
    still: Array[Ints, "n_b"]  # 1 where it stays as it is: contacts of two such bodies are not looked for


class Found(Block):
    """Contacts in the order of their keys; m is the room for them."""

    shape_i: Array[Ints, "m"]  # shape_i < shape_j
    shape_j: Array[Ints, "m"]
    key: Array[Ints, "m"]  # shape_i, shape_j and what of them touches: the same while that is the same
    gap: Array[Floats, "m"]  # [m], open > 0
    normal: Array[Floats, "m", "d"]  # from the body of shape_i to that of shape_j
    point: Array[Floats, "m", "d"]  # [m] midway between the two surfaces


@kernel
def move_found(found, c, to):
    """Put a contact in the place of another."""
    found.shape_i[to], found.shape_j[to] = found.shape_i[c], found.shape_j[c]
    found.key[to], found.gap[to] = found.key[c], found.gap[c]
    for k in range(found.normal.shape[1]):
        found.normal[to, k], found.point[to, k] = found.normal[c, k], found.point[c, k]


@kernel
def exchange_found(found, a, b):
    """Exchange two contacts."""
    shape_i, shape_j, key, gap, point = found.shape_i, found.shape_j, found.key, found.gap, found.point
    shape_i[a], shape_i[b] = shape_i[b], shape_i[a]
    shape_j[a], shape_j[b] = shape_j[b], shape_j[a]
    key[a], key[b] = key[b], key[a]
    gap[a], gap[b] = gap[b], gap[a]
    for k in range(point.shape[1]):
        point[a, k], point[b, k] = point[b, k], point[a, k]
        found.normal[a, k], found.normal[b, k] = found.normal[b, k], found.normal[a, k]


@kernel
def key_of(i, j, feature):
    """One number of two shapes and a feature; their order is that of (i, j, feature)."""
    return (((i << SHAPE_BITS) | j) << FEATURE_BITS) | feature


@kernel
def in_order(shapes, i, j, way):
    """The two shapes in an order that does not depend on their numbers, but on what they are and the way (x, y, z) from
    i to j: what is found of a pair is then the same, to the bit, whichever of its bodies was named first."""
    ahead = shapes.rank[j] - shapes.rank[i]
    if ahead > 0 or (ahead == 0 and way[0] * ASKEW[0] + way[1] * ASKEW[1] + way[2] * ASKEW[2] >= 0.0):
        return i, j
    return j, i


@kernel
def same_place(shapes, a, b):
    """The distance below which points of two shapes have no direction [m]."""
    return SAME_PLACE * (shapes.reach[a] + shapes.reach[b] + shapes.radius[a] + shapes.radius[b])


@kernel
def is_finite(motion):
    """Whether all places and velocities are numbers: 0 x is 0 of no other."""
    total = 0.0
    for b in range(motion.x.shape[0]):
        for k in range(motion.x.shape[1]):
            total += 0.0 * motion.x[b, k]
        for k in range(motion.v.shape[1]):
            total += 0.0 * motion.v[b, k]
    return total == 0.0


@kernel
def is_rolling(key):
    """Whether a key is that of rolling or spinning friction."""
    return FIRST_ROLLING <= key < FIRST_DRIVE


@kernel
def contact_of(key):
    """The contact, a row of the problem, whose friction it is."""
    return (key >> FEATURE_BITS) & NO_SHAPE
