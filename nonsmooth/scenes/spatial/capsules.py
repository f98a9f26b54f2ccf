"""Two capsules: points of two segments, c_i + t a (|t| <= h) and c_j + s b (|s| <= k), r apart.

    ends        an end of the one whose foot on the other's axis is within that segment;
    a crossing  where both axes have their common perpendicular within both segments,
                as two edges have (`edges`);
    two ends    without a foot, where they are nearer than all these.

Two that lie side by side touch at both ends of their overlap; each point has the normal along its own distance. Where
the axes meet that is their common perpendicular, or any normal of axes in one line.

Source: Ericson, *Real-Time Collision Detection*, section 5.1.9.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.scenes.detection import same_place
from nonsmooth.scenes.rotation import cross
from nonsmooth.scenes.spatial.core import EDGES, TWO_EDGES, VERTEX_OF_J, between, note, note_place
from nonsmooth.scenes.spatial.edges import crossing, perpendicular

# chosen: sin^2 of two axes whose crossing is not looked for, since it is known to EPS/sin of their length only; the
# ends of the overlap are as near to 1e-8 of that length
PARALLEL_AXES = 1e-16
POSITIVE_END = 4  # code: the vertex of a capsule on the positive side of z; 0 is on the negative
AXIS_EDGE = 8  # code: the edge of a capsule, number 0 along z


@rare_kernel
def capsule_on_capsule(shapes, scratch, i, j, limit):
    """The points of a pair whose gaps are below the limit; returns how many."""
    axis = scratch.axis
    d_x, d_y, d_z = between(scratch, i, j)
    a_d = axis[i, 2, 0] * d_x + axis[i, 2, 1] * d_y + axis[i, 2, 2] * d_z
    b_d = axis[j, 2, 0] * d_x + axis[j, 2, 1] * d_y + axis[j, 2, 2] * d_z
    a_b = axis[i, 2, 0] * axis[j, 2, 0] + axis[i, 2, 1] * axis[j, 2, 1] + axis[i, 2, 2] * axis[j, 2, 2]
    h, k, n = shapes.size[i, 2], shapes.size[j, 2], 0
    for end in range(2):
        t = h if end == 1 else -h
        s = a_b * t - b_d
        if -k <= s <= k:
            n = nearest_point(shapes, scratch, i, j, (t, s), POSITIVE_END * end, limit, n)
    for end in range(2):
        s = k if end == 1 else -k
        t = a_d + a_b * s
        if -h < t < h:
            n = nearest_point(shapes, scratch, i, j, (t, s), VERTEX_OF_J + POSITIVE_END * end, limit, n)
    if not are_parallel(scratch, i, j):
        a = (axis[i, 2, 0], axis[i, 2, 1], axis[i, 2, 2])
        b = (axis[j, 2, 0], axis[j, 2, 1], axis[j, 2, 2])
        t, s = crossing(a, b, (d_x, d_y, d_z))
        if -h < t < h and -k < s < k:
            n = nearest_point(shapes, scratch, i, j, (t, s), TWO_EDGES + (EDGES + 1) * AXIS_EDGE, limit, n)
    return nearest_ends(shapes, scratch, i, j, (a_d, b_d, a_b), limit, n)


@kernel
def nearest_ends(shapes, scratch, i, j, products, limit, n):
    """Note the two nearest of the ends without a foot, if they are nearer than the n points noted; the new n.

    ``products`` are those of the axes with the way between the centres, and with one another.
    """
    a_d, b_d, a_b = products
    h, k = shapes.size[i, 2], shapes.size[j, 2]
    best, best_t, best_s, feature = math.inf, 0.0, 0.0, 0
    for end in range(4):
        t, s = h if end & 1 else -h, k if end & 2 else -k
        squared = t * t + s * s - 2.0 * (t * s * a_b + t * a_d - s * b_d)  # less |d|^2
        has_foot = -k <= a_b * t - b_d <= k or -h < a_d + a_b * s < h
        if squared < best and not has_foot:
            best, best_t, best_s, feature = squared, t, s, POSITIVE_END * (end & 1)
    if best == math.inf:
        return n
    for point in range(n):
        limit = min(limit, scratch.manifold.gap[point])
    return nearest_point(shapes, scratch, i, j, (best_t, best_s), feature, limit, n)


@rare_kernel
def nearest_point(shapes, scratch, i, j, feet, feature, limit, n):
    """Note the point between the feet t and s on the axes of i and j, if its gap is below the limit; the new n."""
    t, s = feet
    axis = scratch.axis
    d_x, d_y, d_z = between(scratch, i, j)
    x, y, z = t * axis[i, 2, 0], t * axis[i, 2, 1], t * axis[i, 2, 2]
    e_x = d_x + s * axis[j, 2, 0] - x
    e_y = d_y + s * axis[j, 2, 1] - y
    e_z = d_z + s * axis[j, 2, 2] - z
    d, r_i, r_j = math.sqrt(e_x * e_x + e_y * e_y + e_z * e_z), shapes.radius[i], shapes.radius[j]
    if d - r_i - r_j >= limit:
        return n
    if d > same_place(shapes, i, j):
        nx, ny, nz = e_x / d, e_y / d, e_z / d
    elif are_parallel(scratch, i, j):
        nx, ny, nz = axis[i, 0, 0], axis[i, 0, 1], axis[i, 0, 2]
    else:
        nx, ny, nz = perpendicular(scratch, i, j, 2, 2)
    note(scratch.manifold, n, d - r_i - r_j, nx, ny, nz, feature)
    note_place(scratch, n, i, x, y, z, 0.5 * (d + r_i - r_j))
    return n + 1


@kernel
def are_parallel(scratch, i, j):
    """Whether the common perpendicular of the axes is not known."""
    a = scratch.axis
    x, y, z = cross(a[i, 2, 0], a[i, 2, 1], a[i, 2, 2], a[j, 2, 0], a[j, 2, 1], a[j, 2, 2])
    return x * x + y * y + z * z <= PARALLEL_AXES
