"""Cylinders, ellipsoids and polyhedra on a half-space, and a sphere on a cylinder.

On a half-space: of a cylinder eight points of the rim of the lower end, the lowest of them and every eighth of a turn
from it, and the lowest point of the other rim, so that it lies on two points; of an ellipsoid its farthest point, of a
polyhedron its vertices. A sphere on a cylinder is a point on a rectangle, (rho, z) of its centre:

    outside   q = (min(rho, r), clamp(z)),   d = |c - q|;      inside   the nearest of side and ends
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.scenes.detection import same_place
from nonsmooth.scenes.shape_rows import CYLINDER, HALF_SPACE, POLYHEDRON
from nonsmooth.scenes.spatial.core import VERTEX_OF_J, between, in_axes, in_world, note, note_place
from nonsmooth.scenes.spatial.support import across, support, vertex_in_world
from nonsmooth.scenes.spatial.turned_faces import RIM, rim_point


@rare_kernel
def solid_on_half_space(shapes, scratch, i, j, limit):
    """The points of a pair whose gaps are below the limit; returns how many."""
    is_first = shapes.kind[i] == HALF_SPACE  # the half-space is i
    plane, solid = (i, j) if is_first else (j, i)
    axis, kind = scratch.axis, shapes.kind[solid]
    down = (-axis[plane, 2, 0], -axis[plane, 2, 1], -axis[plane, 2, 2])
    if kind == POLYHEDRON:
        n = 0
        for vertex in range(shapes.solids.count[solid]):
            arm = vertex_in_world(shapes, scratch, solid, vertex)
            n = note_above(scratch, plane, solid, arm, down, (is_first, vertex), limit, n)
        return n
    if kind == CYLINDER:
        return cylinder_on_half_space(shapes, scratch, plane, solid, down, is_first, limit)
    arm = support(shapes, scratch, solid, down[0], down[1], down[2])
    return note_above(scratch, plane, solid, arm, down, (is_first, 0), limit, 0)


@rare_kernel
def cylinder_on_half_space(shapes, scratch, plane, solid, down, is_first, limit):
    """The rim of the lower end, and the lowest point of the other; how many."""
    x, y, z = in_axes(scratch, solid, down[0], down[1], down[2])
    lower, n = (1 if z > 0.0 else 0), 0
    for end in range(2):
        for k in range(RIM if end == lower else 1):
            arm = rim_point(shapes, scratch, solid, end, k, x, y)
            n = note_above(scratch, plane, solid, arm, down, (is_first, RIM * end + k), limit, n)
    return n


@rare_kernel
def note_above(scratch, plane, solid, arm, down, kind, limit, n):
    """Note a point of a solid, from its centre, above a half-space, if its gap is below the limit; the new n. ``kind``:
    whether the half-space is i, and the vertex."""
    is_first, vertex = kind
    x, y, z = between(scratch, plane, solid)
    d = -((x + arm[0]) * down[0] + (y + arm[1]) * down[1] + (z + arm[2]) * down[2])
    if d >= limit:
        return n
    sign = 1.0 if is_first else -1.0
    feature = vertex + (VERTEX_OF_J if is_first else 0)
    note(scratch.manifold, n, d, -sign * down[0], -sign * down[1], -sign * down[2], feature)
    note_place(scratch, n, solid, arm[0], arm[1], arm[2], -0.5 * sign * d)
    return n + 1


@rare_kernel
def sphere_on_cylinder(shapes, scratch, sphere, solid, limit, is_first):
    """The one point of a sphere, which is i if is_first, and a cylinder."""
    x, y, z = between(scratch, solid, sphere)
    x, y, z = in_axes(scratch, solid, x, y, z)
    u, v = across(x, y)
    rho, radius, half = math.sqrt(x * x + y * y), shapes.size[solid, 0], shapes.size[solid, 2]
    d, n_rho, n_z = point_on_rectangle(radius, half, rho, z, same_place(shapes, sphere, solid))
    r = shapes.radius[sphere]
    if d - r >= limit:
        return 0
    nx, ny, nz = in_world(scratch, solid, n_rho * u, n_rho * v, n_z)  # from the cylinder to the sphere
    sign = -1.0 if is_first else 1.0
    note(scratch.manifold, 0, d - r, sign * nx, sign * ny, sign * nz, 0 if is_first else VERTEX_OF_J)
    note_place(scratch, 0, sphere, 0.0, 0.0, 0.0, -0.5 * sign * (d + r))
    return 1


@kernel
def point_on_rectangle(radius, half, rho, z, nearest):
    """The signed distance of (rho >= 0, z) from |rho| <= radius, |z| <= half, and the direction in which it grows."""
    e_rho, e_z = max(rho - radius, 0.0), z - min(max(z, -half), half)
    d = math.sqrt(e_rho * e_rho + e_z * e_z)
    if d > nearest:
        return d, e_rho / d, e_z / d
    if rho - radius >= abs(z) - half:
        return rho - radius, 1.0, 0.0
    return abs(z) - half, 0.0, math.copysign(1.0, z)
