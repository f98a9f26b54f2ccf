"""Rows of joints with axes (joint_kinds.py): where a row points, how far it is off, and what it is on either body.

    along an axis u of body i:            g = u . (p_j - p_i),   J v = n . (v_j + w_j x r_j - v_i - w_i x r_i)
    an axis of the world, both points:    g = e . (p_j - p_i),   the same J with r to the middle between the points
    axes u of i, w of j at right angles:  g = l u . w,           J v = l (w x u) . (w_j - w_i)
    two points at a distance:             g = |p_j - p_i| - l,   J v as along an axis, n = (p_j - p_i)/|p_j - p_i|

r are the arms of p_j from the centres of both bodies, so that the impulses of both sides act at one point and angular
momentum is kept; these are the exact derivatives of g. Turns count as ways at the lever l, the reach of the smaller
body: all rows of a problem are in m/s and N s. As of joints that share a point (joints.py) a row asks for

    J_mid v_1 + b = 0,    b = J_mid v_0 - J_0 v_0

A row that a block does not use has J = 0, and what stands for it in W (`problem.fill_unused`): its impulse is none.
"""

from __future__ import annotations

from math import atan2, cos, sin, sqrt

from nonsmooth.integrators.assembly.spatial import cross, tangent, turn_by
from nonsmooth.jit import kernel
from nonsmooth.scenes.joint_kinds import DISTANCE, F_AXIS, G_AXIS, OFFSET, PLANE_ANGLE, POINT, TURN, UNUSED

PLANAR_PLACE = 3  # defined: numbers of a place in the plane


@kernel
def arm_at(x, b, arm, k):
    """An arm of joint k along the axes of the world, (x, y, z) with z = 0 in the plane, of body b at places x."""
    if x.shape[1] == PLANAR_PLACE:
        c, s = cos(x[b, 2]), sin(x[b, 2])
        return c * arm[k, 0] - s * arm[k, 1], s * arm[k, 0] + c * arm[k, 1], 0.0
    return turn_by(x, b, arm[k, 0], arm[k, 1], arm[k, 2])


@kernel
def axis_at(x, b, axes, k, u):
    """Axis u of the frame that joint k has on body b, along the axes of the world, at places x."""
    if x.shape[1] == PLANAR_PLACE:
        c, s = cos(x[b, 2]), sin(x[b, 2])
        return c * axes[k, u, 0] - s * axes[k, u, 1], s * axes[k, u, 0] + c * axes[k, u, 1], 0.0
    return turn_by(x, b, axes[k, u, 0], axes[k, u, 1], axes[k, u, 2])


@kernel
def height_of(x, b):
    """The third coordinate of body b, 0 in the plane."""
    return 0.0 if x.shape[1] == PLANAR_PLACE else x[b, 2]


@kernel
def offset_of(joints, x, k):
    """p_j - p_i of joint k, and p_j."""
    i, j = joints.i[k], joints.j[k]
    a, e = arm_at(x, i, joints.arm_i, k), arm_at(x, j, joints.arm_j, k)
    p_0, p_1, p_2 = x[j, 0] + e[0], x[j, 1] + e[1], height_of(x, j) + e[2]
    return (p_0 - x[i, 0] - a[0], p_1 - x[i, 1] - a[1], p_2 - height_of(x, i) - a[2]), (p_0, p_1, p_2)


@kernel
def angle_at(joints, x, k):
    """The angle of body j about the axis e of body i, in space, between -pi and pi [rad]."""
    f, g = axis_at(x, joints.i[k], joints.axes_i, k, F_AXIS), axis_at(x, joints.i[k], joints.axes_i, k, G_AXIS)
    a = axis_at(x, joints.j[k], joints.axes_j, k, F_AXIS)
    return atan2(a[0] * g[0] + a[1] * g[1] + a[2] * g[2], a[0] * f[0] + a[1] * f[1] + a[2] * f[2])


@kernel
def row_at(joints, x, k, row):
    """Where a row points at places x, and how far it is off there [m]."""
    u, w, i, j = joints.u[k, row], joints.w[k, row], joints.i[k], joints.j[k]
    if w == POINT:
        g, _ = offset_of(joints, x, k)
        return (1.0 if row == 0 else 0.0, 1.0 if row == 1 else 0.0, 1.0 if row == 2 else 0.0), g[row]
    if w == PLANE_ANGLE:
        return (0.0, 0.0, 1.0), joints.lever[k] * (x[j, 2] - x[i, 2] - joints.angle[k])
    if w == DISTANCE:
        g, _ = offset_of(joints, x, k)
        s = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2])
        n = (g[0] / s, g[1] / s, g[2] / s) if s > 0.0 else (1.0, 0.0, 0.0)
        return n, s - joints.length[k]
    a = axis_at(x, i, joints.axes_i, k, u)
    if w == OFFSET:
        g, _ = offset_of(joints, x, k)
        return a, a[0] * g[0] + a[1] * g[1] + a[2] * g[2]
    if w == TURN:
        return a, joints.lever[k] * angle_at(joints, x, k)
    e = axis_at(x, j, joints.axes_j, k, w)
    return cross(e[0], e[1], e[2], a[0], a[1], a[2]), joints.lever[k] * (a[0] * e[0] + a[1] * e[1] + a[2] * e[2])


@kernel
def wrench_of(joints, x, k, row, b):
    """The force and the moment of a unit impulse of a row about the centre of body b."""
    n, _ = row_at(joints, x, k, row)
    w = joints.w[k, row]
    if w != OFFSET and w != POINT and w != DISTANCE:
        s = joints.lever[k]
        return (0.0, 0.0, 0.0), (s * n[0], s * n[1], s * n[2])
    g, p = offset_of(joints, x, k)
    back = 0.5 if w == POINT else 0.0
    r_0, r_1, r_2 = p[0] - back * g[0] - x[b, 0], p[1] - back * g[1] - x[b, 1], p[2] - back * g[2] - height_of(x, b)
    return n, cross(r_0, r_1, r_2, n[0], n[1], n[2])


@kernel
def rate_of(joints, x, k, row, b, v):
    """What body b with a velocity of v adds to the rate of a row at places x, as the second body."""
    n, m = wrench_of(joints, x, k, row, b)
    if x.shape[1] == PLANAR_PLACE:
        return n[0] * v[b, 0] + n[1] * v[b, 1] + m[2] * v[b, 2]
    along = n[0] * v[b, 0] + n[1] * v[b, 1] + n[2] * v[b, 2]
    return along + m[0] * v[b, 3] + m[1] * v[b, 4] + m[2] * v[b, 5]


@kernel
def write_side(joints, x, k, row, b, J, c, to):
    """J of a row on the second body, to row ``to`` of block c."""
    n, m = wrench_of(joints, x, k, row, b)
    J[c, to, 0], J[c, to, 1] = n[0], n[1]
    if x.shape[1] == PLANAR_PLACE:
        J[c, to, 2] = m[2]
    else:
        J[c, to, 2], J[c, to, 3], J[c, to, 4], J[c, to, 5] = n[2], m[0], m[1], m[2]


@kernel
def write_axis(network, c, row, at, rate):
    """A row of the angular velocity ``at`` of both bodies."""
    network.J_i[c, row, at], network.J_j[c, row, at] = -rate, rate


@kernel
def write_axis_in_space(network, c, row, e, lever):
    """A row of the angular velocities along a direction."""
    write_axis(network, c, row, 3, lever * e[0])
    write_axis(network, c, row, 4, lever * e[1])
    write_axis(network, c, row, 5, lever * e[2])


@kernel
def write_turns_across(network, c, e, lever):
    """The tangential rows of block c: what its bodies turn by against one another across e."""
    t = tangent(e[0], e[1], e[2])
    write_axis_in_space(network, c, 1, t, lever)
    write_axis_in_space(network, c, 2, cross(e[0], e[1], e[2], t[0], t[1], t[2]), lever)


@kernel
def write_rows_of_joint(joints, x, k, c, network):
    """J_i, J_j of block k of rows at places x, and no b."""
    for row in range(network.b.shape[1]):
        network.b[c, row] = 0.0
        if joints.w[k, row] == UNUSED:
            for y in range(network.v.shape[1]):
                network.J_i[c, row, y] = network.J_j[c, row, y] = 0.0
            continue
        write_side(joints, x, k, row, joints.i[k], network.J_i, c, row)
        write_side(joints, x, k, row, joints.j[k], network.J_j, c, row)
        for y in range(network.v.shape[1]):
            network.J_i[c, row, y] = -network.J_i[c, row, y]


@kernel
def turn_of_side(joints, bodies, k, row, b):
    """What a row gains on body b from the beginning of the step to where it is written, J_mid v_0 - J_0 v_0."""
    start = bodies.v_0 if bodies.motion.moves[b] == 0 else bodies.motion.v
    now = rate_of(joints, bodies.motion.x, k, row, b, bodies.v_0)
    return now - rate_of(joints, bodies.x_0, k, row, b, start)


@kernel
def write_law_of_rows(joints, bodies, k, c, network):
    """b of block k of rows."""
    for row in range(network.b.shape[1]):
        if joints.w[k, row] != UNUSED:
            of_i = turn_of_side(joints, bodies, k, row, joints.i[k])
            network.b[c, row] = turn_of_side(joints, bodies, k, row, joints.j[k]) - of_i
