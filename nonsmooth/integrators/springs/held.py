"""What acts on bodies on springs besides their contacts: joints and their limits, and the springs of the scene.

    joint    la = -(k g + c g'),         each of its rows, g of joint_rows.py, k and c as of contacts
    limit    la as of a contact,         d the way beyond it
    spring   la = -(k (l - l_0) + c l')  along its line (spring_rows.py), its own k and c

A joint gives way by g = la/k: as k grows it becomes the rigid one, and where it is redundant its reactions are those of
the least sum of la^2. Turns count as ways at the lever of the joint.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.drive_rows import STOPS, Drives, coordinate_of
from nonsmooth.integrators.assembly.joint_rows import arm_at, row_at, write_side
from nonsmooth.integrators.assembly.joints import Joints, Reactions, book_row, clear_reaction
from nonsmooth.integrators.assembly.spatial import cross
from nonsmooth.integrators.assembly.spring_rows import TORSION, Springs, line_of
from nonsmooth.integrators.records import FORCE_WORK, NORMAL_WORK, SURFACE_WORK
from nonsmooth.integrators.springs.blocks import DAMPING_WORK, SpringPlaces, Stages
from nonsmooth.integrators.springs.law import Law, damping_of, elastic_energy, spring_and_damper
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, view
from nonsmooth.scenes.joint_kinds import UNUSED


class Row(Block):
    """The row at hand, and what all joints and limits hold [J]."""

    elastic: float
    J: Array[Floats, 2, 1, "n"]


@kernel("void(int64, int64)")
def hold_bodies(places_at, s):
    """Add the forces and the works of joints, limits and springs at stage s."""
    places = view(places_at, SpringPlaces)
    bodies, stages, law = view(places.bodies, Bodies), view(places.rates, Stages), view(places.law, Law)
    row, reactions = view(places.row, Row), view(places.reactions, Reactions)
    joints, drives, coils = view(places.joints, Joints), view(places.drives, Drives), view(places.coils, Springs)
    M_inv, row.elastic = view(places.network, Network).M_inv, 0.0
    for of in range(reactions.P.shape[0]):
        clear_reaction(reactions, of)
    for k in range(joints.count):
        for r in range(joints.w.shape[1]):
            if joints.w[k, r] != UNUSED:
                hold_joint(joints, bodies, k, r, row, (law, M_inv, stages, reactions), s)
    for k in range(drives.count):
        if drives.law[k] == STOPS:
            stop(drives, bodies, k, row, (law, M_inv, stages, reactions), s)
    for k in range(coils.count):
        pull(coils, bodies, k, row, stages, s)


@kernel
def hold_joint(joints, bodies, k, r, row, blocks, s):
    """Row r of block k of a joint: a spring that is damped critically."""
    law, M_inv, stages, reactions = blocks
    i, j = joints.i[k], joints.j[k]
    write_row(joints, bodies.motion.x, k, r, row)
    _, g = row_at(joints, bodies.motion.x, k, r)
    rate, W = rate_along(row, bodies.motion.v, i, j), compliance_along(row, M_inv, i, j)
    spring = -law.k * g
    la = spring - damping_of(law, W) * rate
    row.elastic += 0.5 * law.k * g * g
    apply(row, stages, s, i, j, la)
    stages.work[s, 0, NORMAL_WORK] += la * rate
    stages.work[s, 0, SURFACE_WORK] -= la * given_along(row, bodies, i, j)
    stages.work[s, 0, DAMPING_WORK] += (la - spring) * rate
    book_row(joints.w[k, r], row.J, 1, 0, la, joints.of[k], reactions)


@kernel
def stop(drives, bodies, k, row, blocks, s):
    """The nearer limit of drive k: a contact of the law of all."""
    law, M_inv, stages, reactions = blocks
    i, j, x = drives.i[k], drives.j[k], bodies.motion.x
    at = coordinate_of(drives, x, k)
    sign = -1.0 if drives.high[k] - at < at - drives.low[k] else 1.0
    depth = drives.low[k] - at if sign > 0.0 else at - drives.high[k]
    if depth <= 0.0:
        return
    write_row(drives, x, k, 0, row)
    rate = sign * rate_along(row, bodies.motion.v, i, j)
    la, elastic = spring_and_damper(law, damping_of(law, compliance_along(row, M_inv, i, j)), depth, -rate)
    row.elastic += elastic_energy(law, depth)
    apply(row, stages, s, i, j, sign * la)
    stages.work[s, 0, NORMAL_WORK] += la * rate
    stages.work[s, 0, SURFACE_WORK] -= sign * la * given_along(row, bodies, i, j)
    stages.work[s, 0, DAMPING_WORK] += (la - elastic) * rate
    book_row(drives.w[k, 0], row.J, 1, 0, sign * la, drives.of[k], reactions)


@kernel
def pull(coils, bodies, k, row, stages, s):
    """Row k of the springs of the scene."""
    i, j, x = coils.i[k], coils.j[k], bodies.motion.x
    n_0, n_1, n_2, length = line_of(coils, x, k)
    write_end(coils, x, k, i, coils.arm_i, (-n_0, -n_1, -n_2), row, 0)
    write_end(coils, x, k, j, coils.arm_j, (n_0, n_1, n_2), row, 1)
    rate = rate_along(row, bodies.motion.v, i, j)
    la = -(coils.stiffness[k] * (length - coils.length[k]) + coils.damping[k] * rate)
    apply(row, stages, s, i, j, la)
    stages.work[s, 0, FORCE_WORK] += la * (rate - given_along(row, bodies, i, j))


@kernel
def write_row(block, x, k, r, row):
    """J of row r of block k, of joints or of drives."""
    write_side(block, x, k, r, block.i[k], row.J, 0, 0)
    write_side(block, x, k, r, block.j[k], row.J, 1, 0)
    for y in range(row.J.shape[2]):
        row.J[0, 0, y] = -row.J[0, 0, y]


@kernel
def write_end(coils, x, k, b, arms, n, row, side):
    """J of spring k on body b: a force along n at its end, or a moment."""
    arm = arm_at(x, b, arms, k)
    moment = cross(arm[0], arm[1], arm[2], n[0], n[1], n[2])
    if coils.axis[k] == TORSION:
        row.J[side, 0, 0], row.J[side, 0, 1], row.J[side, 0, 2] = 0.0, 0.0, n[0]
    elif row.J.shape[2] == 3:
        row.J[side, 0, 0], row.J[side, 0, 1], row.J[side, 0, 2] = n[0], n[1], moment[2]
    else:
        for y in range(3):
            row.J[side, 0, y], row.J[side, 0, 3 + y] = n[y], moment[y]


@kernel
def rate_along(row, v, i, j):
    """J v of a row."""
    total = 0.0
    for x in range(row.J.shape[2]):
        total += row.J[0, 0, x] * v[i, x] + row.J[1, 0, x] * v[j, x]
    return total


@kernel
def given_along(row, bodies, i, j):
    """The part of J v that guided bodies have."""
    total = 0.0
    for x in range(row.J.shape[2]):
        total += row.J[0, 0, x] * bodies.motion.v[i, x] if bodies.motion.moves[i] == 0 else 0.0
        total += row.J[1, 0, x] * bodies.motion.v[j, x] if bodies.motion.moves[j] == 0 else 0.0
    return total


@kernel
def compliance_along(row, M_inv, i, j):
    """W = J M^-1 J^T of a row [1/kg]."""
    total = 0.0
    for side in range(2):
        b = i if side == 0 else j
        for x in range(row.J.shape[2]):
            for y in range(row.J.shape[2]):
                total += row.J[side, 0, x] * M_inv[b, x, y] * row.J[side, 0, y]
    return total


@kernel
def apply(row, stages, s, i, j, la):
    """A force along a row, on its two bodies."""
    for x in range(row.J.shape[2]):
        stages.force[i, x] += la * row.J[0, 0, x]
        stages.force[j, x] += la * row.J[1, 0, x]


@kernel
def note_stops(drives, x):
    """Where the coordinates of limits are at the end of a step, for the full turns of the next one."""
    for k in range(drives.count):
        if drives.law[k] == STOPS:
            drives.last[k] = coordinate_of(drives, x, k)
