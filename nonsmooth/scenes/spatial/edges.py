"""Two edges that face each other: one point on their common perpendicular.

n = +-(a_p x b_q)/|a_p x b_q|  from i to j;    the edge of i farthest along n, that of j farthest against it
their points of least distance: see `capsules`
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.scenes.spatial.core import (
    EDGES,
    TWO_EDGES,
    between,
    edge_number,
    edge_vertex,
    note,
    note_place,
    vertex_at,
)
from nonsmooth.scenes.spatial.rotation import cross


@rare_kernel
def edge_contact(shapes, scratch, i, j, is_near):
    """Note the point of the pair of edges in ``scratch.axes``: 1; or 0 where it is off the end of one.

    Where the cores overlap or touch (is_near) it is off by rounding alone.
    """
    axes, axis, cosine = scratch.axes, scratch.axis, scratch.axes.cosine
    p, q = axes.edges // 3, axes.edges % 3
    p_1, p_2, q_1, q_2 = (p + 1) % 3, (p + 2) % 3, (q + 1) % 3, (q + 2) % 3
    along = axes.t_i[p_2] * cosine[p_1, q] - axes.t_i[p_1] * cosine[p_2, q]
    sign = 1.0 if along >= 0.0 else -1.0
    vertex_i = side_bit(-sign * cosine[p_2, q], p_1) | side_bit(sign * cosine[p_1, q], p_2)
    vertex_j = side_bit(-sign * cosine[p, q_2], q_1) | side_bit(sign * cosine[p, q_1], q_2)
    edge_i, edge_j = edge_number(p, vertex_i), edge_number(q, vertex_j)
    t, s, sine_2 = feet(shapes, scratch, i, j, edge_i, edge_j)
    if not is_near and (abs(t) > shapes.size[i, p] or abs(s) > shapes.size[j, q]):
        return 0
    x, y, z = cross(axis[i, p, 0], axis[i, p, 1], axis[i, p, 2], axis[j, q, 0], axis[j, q, 1], axis[j, q, 2])
    length = math.sqrt(x * x + y * y + z * z)
    x, y, z = sign * x / length, sign * y / length, sign * z / length
    d, r_i, r_j = axes.s_edges, shapes.radius[i], shapes.radius[j]
    note(scratch.manifold, 0, d - r_i - r_j, x, y, z, TWO_EDGES + EDGES * edge_i + edge_j)
    x, y, z = edge_point(shapes, scratch, i, edge_i, t)
    note_place(scratch, 0, i, x, y, z, 0.5 * (d + r_i - r_j))
    return 1


@kernel
def side_bit(component, axis):
    """The bit of an axis if a component along it is positive."""
    return 1 << axis if component > 0.0 else 0


@kernel
def feet(shapes, scratch, i, j, edge_i, edge_j):
    """The feet (t, s) of the common perpendicular of two edges, from their middles, and sin^2 of their angle."""
    axis, p, q = scratch.axis, edge_i // 4, edge_j // 4
    x, y, z = between(scratch, i, j)
    a_x, a_y, a_z = edge_point(shapes, scratch, i, edge_i, 0.0)
    b_x, b_y, b_z = edge_point(shapes, scratch, j, edge_j, 0.0)
    x, y, z = x + b_x - a_x, y + b_y - a_y, z + b_z - a_z
    a_d = axis[i, p, 0] * x + axis[i, p, 1] * y + axis[i, p, 2] * z
    b_d = axis[j, q, 0] * x + axis[j, q, 1] * y + axis[j, q, 2] * z
    a_b = scratch.axes.cosine[p, q]
    x, y, z = cross(axis[i, p, 0], axis[i, p, 1], axis[i, p, 2], axis[j, q, 0], axis[j, q, 1], axis[j, q, 2])
    sine_2 = x * x + y * y + z * z
    return (a_d - a_b * b_d) / sine_2, (a_b * a_d - b_d) / sine_2, sine_2


@kernel
def edge_point(shapes, scratch, s, edge, t):
    """The point of an edge t from its middle, from the centre of its shape."""
    axis, direction = scratch.axis, edge // 4
    x, y, z = vertex_at(shapes, scratch, s, edge_vertex(edge))
    t += shapes.size[s, direction]
    return x + t * axis[s, direction, 0], y + t * axis[s, direction, 1], z + t * axis[s, direction, 2]
