"""What a core turns to a direction: a face, an edge or a point, corner by corner.

Places are from the centre of i, in the axes (e_1, e_2, n) of a contact with the normal n.

    sphere, ellipsoid   the farthest point          capsule     its segment
    box, polyhedron     the face whose normal is nearest to the direction
    cylinder            steeper than 45 degrees an end, eight points of its rim, the lowest one of them; else the line
                        of its side

An eight-sided rim: a cylinder that stands upright to 1e-7 tips over a lever of r cos(pi/8) = 0.924 r in the worst
direction, and of r as soon as it tilts, since the lowest point of the rim is always one of the eight.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.scenes.shape_rows import BOX, CAPSULE, CYLINDER, POLYHEDRON
from nonsmooth.scenes.spatial.core import between, edge_number, in_axes, in_world, vertex_at
from nonsmooth.scenes.spatial.separating_direction import face_normal, faces_of
from nonsmooth.scenes.spatial.support import support, vertex_in_world

RIM = 8  # chosen: points of the rim of an end
# chosen: sine of the tilt of an end below which the lowest point of its rim is not known; they are fixed to the body
UPRIGHT = 1e-7
SIDE_EDGE = 2 * RIM  # code: edge number of the line of a side, behind those of both rims


@kernel
def contact_axes(scratch, i, n):
    """Two unit vectors that make a right-handed triad with n, along axes of i where n is one."""
    axis, best, least = scratch.axis, 0, math.inf
    for k in range(3):
        along = abs(axis[i, k, 0] * n[0] + axis[i, k, 1] * n[1] + axis[i, k, 2] * n[2])
        if along < least:
            best, least = k, along
    a = (axis[i, best, 0], axis[i, best, 1], axis[i, best, 2])
    along = a[0] * n[0] + a[1] * n[1] + a[2] * n[2]
    x, y, z = a[0] - along * n[0], a[1] - along * n[1], a[2] - along * n[2]
    length = math.sqrt(x * x + y * y + z * z)
    e = (x / length, y / length, z / length)
    return e, (n[1] * e[2] - n[2] * e[1], n[2] * e[0] - n[0] * e[2], n[0] * e[1] - n[1] * e[0])


@rare_kernel
def turned_face(shapes, scratch, s, i, triad, sign, polygon):
    """Write the corners that shape s turns to sign times the normal, the last of the triad; how many."""
    n = triad[2]
    x, y, z = sign * n[0], sign * n[1], sign * n[2]
    kind = shapes.kind[s]
    if kind == BOX:
        return box_face(shapes, scratch, s, i, triad, (x, y, z), polygon)
    if kind == POLYHEDRON:
        return polyhedron_face(shapes, scratch, s, i, triad, (x, y, z), polygon)
    if kind == CYLINDER:
        return cylinder_face(shapes, scratch, s, i, triad, (x, y, z), polygon)
    if kind == CAPSULE:
        for end in range(2):
            put(scratch, s, i, triad, vertex_at(shapes, scratch, s, 4 * end), (4 * end, 8), polygon, end)
        return 2
    put(scratch, s, i, triad, support(shapes, scratch, s, x, y, z), (0, 0), polygon, 0)
    return 1


@kernel
def put(scratch, s, i, triad, arm, feature, polygon, k):
    """Corner k: a point from the centre of s, and as its feature the vertex that it is and the edge behind it."""
    x, y, z = arm
    if s != i:
        c_x, c_y, c_z = between(scratch, i, s)
        x, y, z = x + c_x, y + c_y, z + c_z
    for a in range(3):
        e = triad[a]
        polygon.corner[k, a] = e[0] * x + e[1] * y + e[2] * z
    polygon.feature[k], polygon.side[k] = feature


@kernel
def flattest_face(shapes, scratch, s, n):
    """The face whose normal is nearest to a direction."""
    best, most = 0, -math.inf
    for face in range(faces_of(shapes, s)):
        x, y, z = face_normal(shapes, scratch, s, face)
        along = x * n[0] + y * n[1] + z * n[2]
        if along > most:
            best, most = face, along
    return best


@rare_kernel
def box_face(shapes, scratch, s, i, triad, n, polygon):
    """The face of a box; 4."""
    face = flattest_face(shapes, scratch, s, n)
    axis = face // 2
    base, one, two = (1 << axis) * (face % 2), 1 << (axis + 1) % 3, 1 << (axis + 2) % 3
    for k in range(4):
        vertex = base | (one if k == 1 or k == 2 else 0) | (two if k >= 2 else 0)
        along = (axis + 1 + k % 2) % 3
        feature = (vertex, edge_number(along, vertex))
        put(scratch, s, i, triad, vertex_at(shapes, scratch, s, vertex), feature, polygon, k)
    return 4


@rare_kernel
def polyhedron_face(shapes, scratch, s, i, triad, n, polygon):
    """The face of a polyhedron; its number of corners."""
    solids = shapes.solids
    face = solids.first_face[s] + flattest_face(shapes, scratch, s, n)
    for k in range(solids.corners[face]):
        at = solids.first_corner[face] + k
        vertex = solids.corner[at]
        arm = vertex_in_world(shapes, scratch, s, vertex)
        put(scratch, s, i, triad, arm, (vertex, solids.edge[at]), polygon, k)
    return solids.corners[face]


@rare_kernel
def cylinder_face(shapes, scratch, s, i, triad, n, polygon):
    """An end of a cylinder, or the line of its side; 8 or 2."""
    x, y, z = in_axes(scratch, s, n[0], n[1], n[2])
    end = 1 if z > 0.0 else 0
    if abs(z) < math.sqrt(0.5):
        for k in range(2):
            put(scratch, s, i, triad, rim_point(shapes, scratch, s, k, 0, x, y), (RIM * k, SIDE_EDGE), polygon, k)
        return 2
    for k in range(RIM):
        turn = k if end == 1 else (RIM - k) % RIM
        behind = k if end == 1 else (RIM - k - 1) % RIM
        arm = rim_point(shapes, scratch, s, end, turn, x, y)
        put(scratch, s, i, triad, arm, (RIM * end + turn, RIM * end + behind), polygon, k)
    return RIM


@rare_kernel
def rim_point(shapes, scratch, s, end, k, x, y):
    """The point of the rim of an end k eighths of a turn from where (x, y), in the cylinder's axes, points."""
    length = math.sqrt(x * x + y * y)
    if length <= UPRIGHT:
        x, y, length = 1.0, 0.0, 1.0
    c, z = math.cos(0.25 * math.pi * k) / length, math.sin(0.25 * math.pi * k) / length
    r, h = shapes.size[s, 0], shapes.size[s, 2]
    return in_world(scratch, s, r * (c * x - z * y), r * (z * x + c * y), h if end == 1 else -h)
