"""The farthest point of a core in a direction, from its centre, in world axes; what it separates from another.

    box        sum_k sign(n_k) a_k e_k                     capsule, cylinder    sign(n_z) c e_z + r n_T/|n_T|
    ellipsoid  A n/|A^(1/2) n|,  A = diag(a^2, b^2, c^2)   polyhedron           the farthest vertex

    s(n) = min_j n . y - max_i n . x

is how far two cores are apart along n. Source: van den Bergen, *Collision Detection in Interactive 3D Environments*,
section 4.3.4.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.scenes.shape_rows import CYLINDER, ELLIPSOID, POLYHEDRON, SPHERE
from nonsmooth.scenes.spatial.core import between, in_axes, in_world


@rare_kernel
def support(shapes, scratch, s, x, y, z):
    """The farthest point of a core in a direction."""
    kind, size = shapes.kind[s], shapes.size
    if kind == SPHERE:
        return 0.0, 0.0, 0.0
    x, y, z = in_axes(scratch, s, x, y, z)
    if kind == POLYHEDRON:
        return vertex_in_world(shapes, scratch, s, farthest_vertex(shapes, s, x, y, z))
    a, b, c = size[s, 0], size[s, 1], size[s, 2]
    if kind == ELLIPSOID:
        u, v, w = a * x, b * y, c * z
        length = math.sqrt(u * u + v * v + w * w)
        return in_world(scratch, s, a * u / length, b * v / length, c * w / length)
    if kind == CYLINDER:
        u, v = across(x, y)
        return in_world(scratch, s, a * u, a * v, math.copysign(c, z))
    return in_world(scratch, s, math.copysign(a, x), math.copysign(b, y), math.copysign(c, z))


@kernel
def across(x, y):
    """The unit vector of (x, y); where there is none, x."""
    length = math.sqrt(x * x + y * y)
    if length == 0.0:
        return 1.0, 0.0
    return x / length, y / length


@kernel
def farthest_vertex(shapes, s, x, y, z):
    """The number of the vertex of a polyhedron farthest in a direction of its own axes."""
    solids = shapes.solids
    first, best, most = solids.first[s], 0, -math.inf
    for k in range(solids.count[s]):
        v = first + k
        along = solids.vertices[v, 0] * x + solids.vertices[v, 1] * y + solids.vertices[v, 2] * z
        if along > most:
            best, most = k, along
    return best


@kernel
def vertex_in_world(shapes, scratch, s, vertex):
    """A vertex of a polyhedron from its centre, in world axes."""
    solids = shapes.solids
    v = solids.first[s] + vertex
    return in_world(scratch, s, solids.vertices[v, 0], solids.vertices[v, 1], solids.vertices[v, 2])


@kernel
def difference(shapes, scratch, i, j, n):
    """The point of j - i that is nearest along a direction n, and the point of i that it is of."""
    n_x, n_y, n_z = n
    c_x, c_y, c_z = between(scratch, i, j)
    a_x, a_y, a_z = support(shapes, scratch, i, n_x, n_y, n_z)
    b_x, b_y, b_z = support(shapes, scratch, j, -n_x, -n_y, -n_z)
    return (c_x + b_x - a_x, c_y + b_y - a_y, c_z + b_z - a_z), (a_x, a_y, a_z)


@kernel
def separation(shapes, scratch, i, j, n):
    """s(n) of a unit vector."""
    w, _ = difference(shapes, scratch, i, j, n)
    return w[0] * n[0] + w[1] * n[1] + w[2] * n[2]
