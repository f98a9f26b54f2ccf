"""Joints in a step: two bodies share a point, an axis or a turn, and the impulse that holds them does no work.

    g = p_j - p_i = 0,  p = x + R s;    J_mid v_1 + b = 0,   b = (J_mid - J_0) v_0

J has the axes of the world and one common point, midway between the two: the impulses of both sides act there, and
angular momentum is kept. It is that of the places at which contacts are looked for, dt/2 ahead but after impacts; b
is what the arms turn until there, so that v_1 is free of the joint where the bodies are at the end of the step, and
P.(v_0 + v_1)/2 is no work to second order: J_mid v_1 = 0 alone would brake a pendulum by dt omega^2/2 of its speed a
second. What the points part in spite of that, dt^3 a step, is taken back where bodies have moved to (hold_places.py).

Joints are rows behind the contacts of a step, with keys above all of theirs, so that they go on with their impulses
(contacts.py), sleep and wake (sleep.py) as contacts do. Bodies that a joint holds pass through one another, as do those
that ignore one another. Rows of joints with axes are in joint_rows.py; d of them are a block.
**Loops.** Rows of a loop may say one thing twice, as one of thirty does in Bricard's linkage. Where bodies are off by
O(dt^2), as in the middle of a step, they contradict each other: impulses that no body would feel grow until they resist
the motion. Joints in loops are therefore soft, gamma + R P = 0, by a hundred thousandth; what no body feels is small.
Source: for the rows, Haug, *Computer Aided Kinematics and Dynamics of Mechanical Systems* (1989), sections 3.3 and 9.4.
Equations: docs/theory/scenes.md, (6).
"""

from __future__ import annotations

from math import sqrt
from typing import Annotated as Array

from nonsmooth.contact.network.joint import JOINED
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies, fall_of
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.integrators.assembly.drive_rows import Drives, drive_of, keep_rate
from nonsmooth.integrators.assembly.joint_rows import arm_at, row_at, write_law_of_rows, write_rows_of_joint
from nonsmooth.integrators.assembly.of_body import write_rows
from nonsmooth.integrators.assembly.spatial import cross
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.scenes.detection import (
    FEATURE_BITS,
    FIRST_DRIVE,
    FIRST_JOINT,
    FIRST_SPRING,
    LAST_FEATURE,
    NO_SHAPE,
    Found,
    move_found,
)
from nonsmooth.scenes.joint_kinds import DISTANCE, OFFSET, POINT, UNUSED
from nonsmooth.scenes.shape_rows import Shapes

# measured: of 1/mass of a joint in a loop: Bricard's linkage, whose rods weigh 10 N, has then reactions of at most 31 N
# at 4 ms, and 29 N at 1 ms; rigid it had 1e7 N. A step leaves 1e-5 g dt of its velocity, which is taken back
LOOP_SOFTNESS = 1e-5


class Joints(Block):
    """n_j blocks of rows, of n_n joints, and n_p pairs of bodies that pass through one another."""

    count: int  # blocks
    apart: int  # such pairs
    loops: int  # blocks that are in loops
    of: Array[Ints, "n_j"]  # the joint of a block
    begin: Array[Ints, "n_n"]  # and the first block of a joint
    body_i: Array[Ints, "n_n"]  # and its bodies
    body_j: Array[Ints, "n_n"]
    shape_i: Array[Ints, "n_j"]  # a shape of either body
    shape_j: Array[Ints, "n_j"]
    i: Array[Ints, "n_j"]  # the bodies
    j: Array[Ints, "n_j"]
    arm_i: Array[Floats, "n_j", "d"]  # from their centres of mass, along their axes [m]
    arm_j: Array[Floats, "n_j", "d"]
    u: Array[Ints, "n_j", "d"]  # the rows (joint_kinds.py)
    w: Array[Ints, "n_j", "d"]
    axes_i: Array[Floats, "n_j", "d", "d"]  # the frames of the joint along the axes of either body, an axis a row
    axes_j: Array[Floats, "n_j", "d", "d"]
    lever: Array[Floats, "n_j"]  # at which turns count [m]
    angle: Array[Floats, "n_j"]  # of j against i at the start, in the plane [rad]
    length: Array[Floats, "n_j"]  # of a distance [m]
    is_looped: Array[Ints, "n_j"]  # 1 of a joint in a loop of joints, which may hold what others do
    machine: Array[Ints, "n_b"]  # of a body: the one that stands for all that are joined to it
    rest: Array[Floats, "n_b", "2"]  # of a step, at that one: squares of what it changes of a machine at rest
    first: Array[Ints, "n_b + 1"]  # body b passes through other[first[b] : first[b + 1]]: joined to it, or ignored
    other: Array[Ints, "2 * n_p"]


class Reactions(Block):
    """What the joints did in the last step in which they were awake, on their second bodies, in the axes of the world:
    at the point of the joint, and about it."""

    P: Array[Floats, "n_n", "d"]  # [N s]
    torque: Array[Floats, "n_n", "2 * d - 3"]  # [N m s]


@kernel
def key_of_block(joints, k):
    """Above the keys of all contacts; the blocks of a joint are a pair of its own."""
    return FIRST_JOINT | (joints.of[k] << FEATURE_BITS) | (k - joints.begin[joints.of[k]])


@kernel
def joint_of(key):
    """The joint of a key; of many keys too."""
    return (key >> FEATURE_BITS) & NO_SHAPE


@kernel
def block_of(joints, key):
    """The block of rows of a key."""
    return joints.begin[joint_of(key)] + (key & LAST_FEATURE)


@kernel
def pass_through(joints, i, j):
    """Whether two bodies do not touch one another."""
    for at in range(joints.first[i], joints.first[i + 1]):
        if joints.other[at] == j:
            return True
    return False


@kernel("int64(int64, int64, int64, int64)")
def leave_out_ignored(joints_at, shapes_at, found_at, n):
    """Leave out the contacts of bodies that pass through one another, of the first n; how many are left."""
    joints, shapes, found = view(joints_at, Joints), view(shapes_at, Shapes), view(found_at, Found)
    left = 0
    for c in range(n):
        if not pass_through(joints, shapes.body[found.shape_i[c]], shapes.body[found.shape_j[c]]):
            if left < c:
                move_found(found, c, left)
            left += 1
    return left


@kernel
def add_joints(joints, motion, found, n):
    """Write the joints of bodies that are not both still behind the first n contacts; the new n."""
    d = found.normal.shape[1]
    for k in range(joints.count):
        i, j = joints.i[k], joints.j[k]
        if motion.still[i] == 1 and motion.still[j] == 1:
            continue
        found.shape_i[n], found.shape_j[n] = joints.shape_i[k], joints.shape_j[k]
        found.key[n], found.gap[n] = key_of_block(joints, k), 0.0
        for a in range(d):
            found.normal[n, a] = 1.0 if a == 0 else 0.0
        place_joint(joints, motion, found, n)
        n += 1
    return n


@kernel
def place_joint(joints, motion, found, c):
    """The point of row c, midway between those of its bodies."""
    k, x = block_of(joints, found.key[c]), motion.x
    i, j = joints.i[k], joints.j[k]
    a, e = arm_at(x, i, joints.arm_i, k), arm_at(x, j, joints.arm_j, k)
    for axis in range(found.point.shape[1]):
        found.point[c, axis] = 0.5 * (x[i, axis] + a[axis] + x[j, axis] + e[axis])


@kernel
def turn_of_arm(bodies, b, arm, k, d):
    """omega x r - omega_0 x r_0: what the end of an arm gains from the beginning of the step to where its rows are."""
    before, now, v = arm_at(bodies.x_0, b, arm, k), arm_at(bodies.motion.x, b, arm, k), bodies.v_0
    if d == 2:
        return -v[b, 2] * (now[1] - before[1]), v[b, 2] * (now[0] - before[0]), 0.0
    start = v if bodies.motion.moves[b] == 0 else bodies.motion.v
    a = cross(v[b, 3], v[b, 4], v[b, 5], now[0], now[1], now[2])
    e = cross(start[b, 3], start[b, 4], start[b, 5], before[0], before[1], before[2])
    return a[0] - e[0], a[1] - e[1], a[2] - e[2]


@kernel
def write_rest(joints, bodies, fall):
    """The squares of what a step without joints and contacts changes of a velocity and of a turning rate of a machine,
    at most; of the first the fall in the step at least."""
    d, rest = bodies.gravity.shape[0], joints.rest
    for b in range(rest.shape[0]):
        rest[b, 0], rest[b, 1] = fall * fall, 0.0
    for b in range(rest.shape[0]):
        place, turn, of = 0.0, 0.0, joints.machine[b]
        for x in range(bodies.v_0.shape[1]):
            change = bodies.v_free[b, x] - bodies.v_0[b, x]
            if x < d:
                place += change * change
            else:
                turn += change * change
        rest[of, 0], rest[of, 1] = max(rest[of, 0], place), max(rest[of, 1], turn)


@kernel
def softness_of(joints, bodies, k):
    """R of block k of rows: of a joint in a loop, as its bodies move by more than a step from rest would let those of
    its machine move; it is none at rest, so that what friction holds does not creep."""
    if joints.is_looped[k] == 0:
        return 0.0
    v, d, square, lightness, s = bodies.v_0, bodies.gravity.shape[0], 0.0, 0.0, joints.lever[k]
    of = joints.machine[joints.i[k] if bodies.motion.moves[joints.i[k]] == 1 else joints.j[k]]
    rest = max(joints.rest[of, 0], s * s * joints.rest[of, 1])
    for b in (joints.i[k], joints.j[k]):
        if bodies.motion.moves[b] == 1:
            lightness += 1.0 / bodies.mass[b]
        for x in range(v.shape[1]):
            speed = v[b, x] if x < d else s * v[b, x]
            square += speed * speed
    return LOOP_SOFTNESS * lightness * square / (square + rest) if square > 0.0 else 0.0


@kernel
def write_law_of_joint(joints, bodies, found, c, contacts, network, d):
    """What makes row c a joint, b, and how far its points are apart at the beginning of the step."""
    k = block_of(joints, found.key[c])
    i, j = joints.i[k], joints.j[k]
    network.i[c], network.j[c], network.mu[c], contacts.e[c] = i, j, JOINED, 0.0
    drift_of_joint(joints, bodies.x_0, found.key[c], c, contacts)
    if joints.w[k, 0] != POINT:
        write_rows_of_joint(joints, bodies.motion.x, k, c, network)
        write_law_of_rows(joints, bodies, k, c, network)
        return
    of_i, of_j = turn_of_arm(bodies, i, joints.arm_i, k, d), turn_of_arm(bodies, j, joints.arm_j, k, d)
    for axis in range(d):
        network.b[c, axis] = of_j[axis] - of_i[axis]


@kernel
def drift_of_joint(joints, x, key, c, contacts):
    """How far the rows of block c, of such a key, are off at places x."""
    k = block_of(joints, key)
    i, j = joints.i[k], joints.j[k]
    if joints.w[k, 0] == POINT:
        a, e = arm_at(x, i, joints.arm_i, k), arm_at(x, j, joints.arm_j, k)
        for axis in range(contacts.drift.shape[1]):
            contacts.drift[c, axis] = x[j, axis] + e[axis] - x[i, axis] - a[axis]
        return
    for row in range(contacts.drift.shape[1]):
        contacts.drift[c, row] = 0.0
        if joints.w[k, row] != UNUSED:
            _, contacts.drift[c, row] = row_at(joints, x, k, row)


@kernel
def largest_drift(contacts, network, first):
    """The farthest apart that the points of a joint are, of the rows from ``first`` on [m]."""
    largest = 0.0
    for c in range(first, network.n_c):
        square = 0.0
        for axis in range(contacts.drift.shape[1]):
            square += contacts.drift[c, axis] * contacts.drift[c, axis]
        largest = max(largest, square)
    return sqrt(largest)


@kernel
def first_joint(found, network):
    """The first row of a joint: they stand behind the contacts."""
    c = network.n_c
    while c > 0 and found.key[c - 1] >= FIRST_JOINT:
        c -= 1
    return c


@kernel("void(int64, int64, int64, int64, int64, int64, float64)")
def write_joints(joints_at, bodies_at, found_at, contacts_at, network_at, is_impact, dt):
    """Make joints of the last rows of a problem, which were written as contacts, in the plane or in space.

    Those of an impact are held where its bodies are, after the step.
    """
    joints, bodies, found = view(joints_at, Joints), view(bodies_at, Bodies), view(found_at, Found)
    contacts, network = view(contacts_at, Contacts), view(network_at, Network)
    if is_impact == 0 and joints.loops > 0:
        write_rest(joints, bodies, fall_of(bodies, dt))
    for c in range(first_joint(found, network), network.n_c):
        if is_impact == 0:
            found.gap[c] = 0.0
            network.soft[c] = softness_of(joints, bodies, block_of(joints, found.key[c]))
            write_law_of_joint(joints, bodies, found, c, contacts, network, network.b.shape[1])
        else:
            place_joint(joints, bodies.motion, found, c)
            write_rows_after(joints, bodies, found, c, network)


@kernel
def write_rows_after(joints, bodies, found, c, network):
    """The rows of a joint where its bodies are."""
    d, k = network.b.shape[1], block_of(joints, found.key[c])
    if joints.w[k, 0] != POINT:
        write_rows_of_joint(joints, bodies.motion.x, k, c, network)
    else:
        write_rows(bodies, found, c, network, d)
    for axis in range(d):
        network.b[c, axis] = 0.0


@kernel("void(int64, int64, int64, int64, int64, int64)")
def book_reactions(joints_at, drives_at, found_at, network_at, reactions_at, is_first):
    """Book what the joints that are awake do in a solved problem, with their limits and motors: the first one of a step
    or one behind it."""
    joints, drives, found = view(joints_at, Joints), view(drives_at, Drives), view(found_at, Found)
    network, reactions = view(network_at, Network), view(reactions_at, Reactions)
    if is_first == 1:
        for k in range(drives.count):
            if drives.is_slack[k] == 1:
                clear_reaction(reactions, drives.of[k])
        for c in range(network.n_c):
            if is_of_joint(found.key[c]):
                clear_reaction(reactions, joint_of(found.key[c]))
    for c in range(network.n_c):
        key = found.key[c]
        if key >= FIRST_JOINT:
            book_rows(joints, block_of(joints, key), joint_of(key), c, network, reactions)
        elif FIRST_DRIVE <= key < FIRST_SPRING:
            keep_rate(drives, drive_of(drives, key), c, network)
            book_rows(drives, drive_of(drives, key), joint_of(key), c, network, reactions)


@kernel
def is_of_joint(key):
    """Whether a key is that of rows of a joint, or of its limits and motors."""
    return key >= FIRST_JOINT or FIRST_DRIVE <= key < FIRST_SPRING


@kernel
def book_rows(joints, k, of, c, network, reactions):
    """Book block k of rows of a joint, row c of a problem."""
    most = joints.w.shape[1] - 1
    for row in range(network.b.shape[1]):
        book_row(joints.w[k, min(row, most)], network.J_j, c, row, network.P[c, row], of, reactions)


@kernel
def book_row(w, J, c, row, P, of, reactions):
    """Book an impulse, or a force, along a row of a joint."""
    d = reactions.P.shape[1]
    if w == POINT or w == OFFSET or w == DISTANCE:
        for x in range(d):
            reactions.P[of, x] += J[c, row, x] * P
    else:
        for x in range(2 * d - 3):
            reactions.torque[of, x] += J[c, row, d + x] * P


@kernel
def clear_reaction(reactions, of):
    """None yet."""
    for x in range(reactions.P.shape[1]):
        reactions.P[of, x] = 0.0
    for x in range(reactions.torque.shape[1]):
        reactions.torque[of, x] = 0.0
