"""A sphere on a sphere, and on a box core (a capsule's or a box's).

    outside   q the nearest point of the core: the centre, in the axes of the core, clamped to its half lengths
              d = |c - q|,    n = (c - q)/d
    inside    the face with the least depth, d = |c_k| - a_k <= 0

Source: Ericson, *Real-Time Collision Detection*, sections 5.1.3 and 5.2.5.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.scenes.detection import SAME_PLACE, same_place
from nonsmooth.scenes.spatial.core import VERTEX_OF_J, between, in_axes, in_world, note, note_place


@kernel
def sphere_on_sphere(shapes, scratch, i, j, limit):
    """The one point of two spheres; where their centres meet the normal is the z-axis."""
    x, y, z = between(scratch, i, j)
    r_i, r_j = shapes.radius[i], shapes.radius[j]
    d = math.sqrt(x * x + y * y + z * z)
    if d - r_i - r_j >= limit:
        return 0
    nx, ny, nz = 0.0, 0.0, 1.0
    if d > SAME_PLACE * (r_i + r_j):
        nx, ny, nz = x / d, y / d, z / d
    note(scratch.manifold, 0, d - r_i - r_j, nx, ny, nz, 0)
    note_place(scratch, 0, i, 0.0, 0.0, 0.0, 0.5 * (d + r_i - r_j))
    return 1


@rare_kernel
def sphere_on_core(shapes, scratch, sphere, core, limit, is_first):
    """The one point of a sphere, which is i if is_first, and a core."""
    x, y, z = between(scratch, core, sphere)
    x, y, z = in_axes(scratch, core, x, y, z)
    d, nx, ny, nz = point_on_box(shapes.size[core, 0], shapes.size[core, 1], shapes.size[core, 2], x, y, z,
                                 same_place(shapes, sphere, core))  # fmt: skip
    r, r_core = shapes.radius[sphere], shapes.radius[core]
    if d - r - r_core >= limit:
        return 0
    nx, ny, nz = in_world(scratch, core, nx, ny, nz)  # from the core to the sphere
    sign = -1.0 if is_first else 1.0
    note(scratch.manifold, 0, d - r - r_core, sign * nx, sign * ny, sign * nz, 0 if is_first else VERTEX_OF_J)
    note_place(scratch, 0, sphere, 0.0, 0.0, 0.0, -0.5 * sign * (d + r - r_core))
    return 1


@kernel
def point_on_box(a, b, c, x, y, z, nearest):
    """The signed distance of a point from a box with half lengths (a, b, c), and the direction in which it grows; that
    of a face where the point is inside or no farther than ``nearest``."""
    e_x, e_y, e_z = x - min(max(x, -a), a), y - min(max(y, -b), b), z - min(max(z, -c), c)
    d = math.sqrt(e_x * e_x + e_y * e_y + e_z * e_z)
    if d > nearest:
        return d, e_x / d, e_y / d, e_z / d
    d_x, d_y, d_z = abs(x) - a, abs(y) - b, abs(z) - c
    if d_x >= d_y and d_x >= d_z:
        return d_x, math.copysign(1.0, x), 0.0, 0.0
    if d_y >= d_z:
        return d_y, 0.0, math.copysign(1.0, y), 0.0
    return d_z, 0.0, 0.0, math.copysign(1.0, z)
