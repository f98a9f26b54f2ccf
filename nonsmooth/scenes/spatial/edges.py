"""Two edges that face each other: one point on their common perpendicular.

n = +-(a_p x b_q)/|a_p x b_q|  from i to j;    the edge of i farthest along n, that of j farthest against it
their points of least distance, t a_p and s b_q from their middles, which are d apart:
    t = c.(d x b_q)/c^2,    s = c.(d x a_p)/c^2,    c = a_p x b_q
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.scenes.rotation import cross
from nonsmooth.scenes.spatial.core import (
    EDGES,
    TWO_EDGES,
    between,
    edge_number,
    edge_vertex,
    in_axes,
    note,
    note_place,
    vertex_at,
)


@rare_kernel
def edge_contact(shapes, scratch, i, j, beyond):
    """Note the point of the pair of edges in ``scratch.axes``; False where it is beyond an end by more than this."""
    axes = scratch.axes
    p, q = axes.edges // 3, axes.edges % 3
    x, y, z = perpendicular(scratch, i, j, p, q)
    edge_i, edge_j = farthest_edge(shapes, scratch, i, p, x, y, z), farthest_edge(shapes, scratch, j, q, -x, -y, -z)
    t, s = feet(shapes, scratch, i, j, edge_i, edge_j)
    if abs(t) > shapes.size[i, p] + beyond or abs(s) > shapes.size[j, q] + beyond:
        return False
    d, r_i, r_j = axes.s_edges, shapes.radius[i], shapes.radius[j]
    note(scratch.manifold, 0, d - r_i - r_j, x, y, z, TWO_EDGES + EDGES * edge_i + edge_j)
    x, y, z = edge_point(shapes, scratch, i, edge_i, t)
    note_place(scratch, 0, i, x, y, z, 0.5 * (d + r_i - r_j))
    return True


@kernel
def farthest_edge(shapes, scratch, s, axis, x, y, z):
    """The edge of a core along this axis that is farthest in a direction."""
    components, vertex = in_axes(scratch, s, x, y, z), 0
    for k in range(3):
        if k != axis and components[k] > 0.0 and shapes.size[s, k] > 0.0:
            vertex |= 1 << k
    return edge_number(axis, vertex)


@kernel
def perpendicular(scratch, i, j, p, q):
    """The unit vector across axis p of i and axis q of j, towards j."""
    axis = scratch.axis
    x, y, z = cross(axis[i, p, 0], axis[i, p, 1], axis[i, p, 2], axis[j, q, 0], axis[j, q, 1], axis[j, q, 2])
    c_x, c_y, c_z = between(scratch, i, j)
    length = math.copysign(math.sqrt(x * x + y * y + z * z), x * c_x + y * c_y + z * c_z)
    return x / length, y / length, z / length


@kernel
def feet(shapes, scratch, i, j, edge_i, edge_j):
    """The feet (t, s) of the common perpendicular of two edges, from their middles."""
    axis, p, q = scratch.axis, edge_i // 4, edge_j // 4
    x, y, z = between(scratch, i, j)
    a_x, a_y, a_z = edge_point(shapes, scratch, i, edge_i, 0.0)
    b_x, b_y, b_z = edge_point(shapes, scratch, j, edge_j, 0.0)
    x, y, z = x + b_x - a_x, y + b_y - a_y, z + b_z - a_z
    a = (axis[i, p, 0], axis[i, p, 1], axis[i, p, 2])
    b = (axis[j, q, 0], axis[j, q, 1], axis[j, q, 2])
    return crossing(a, b, (x, y, z))


@kernel
def crossing(a, b, way):
    """The feet (t, s) of the common perpendicular of two lines with unit directions a and b, and the way from the one
    origin to the other: to EPS/sin of their angle, where its products with a and b would give EPS/sin^2."""
    a_x, a_y, a_z = a
    b_x, b_y, b_z = b
    x, y, z = way
    c_x, c_y, c_z = cross(a_x, a_y, a_z, b_x, b_y, b_z)
    sine_2 = c_x * c_x + c_y * c_y + c_z * c_z
    u_x, u_y, u_z = cross(x, y, z, b_x, b_y, b_z)
    v_x, v_y, v_z = cross(x, y, z, a_x, a_y, a_z)
    return (c_x * u_x + c_y * u_y + c_z * u_z) / sine_2, (c_x * v_x + c_y * v_y + c_z * v_z) / sine_2


@kernel
def edge_point(shapes, scratch, s, edge, t):
    """The point of an edge t from its middle, from the centre of its shape."""
    axis, direction = scratch.axis, edge // 4
    x, y, z = vertex_at(shapes, scratch, s, edge_vertex(edge))
    t += shapes.size[s, direction]
    return x + t * axis[s, direction, 0], y + t * axis[s, direction, 1], z + t * axis[s, direction, 2]
