"""The distance of two cores that are apart, from all their features.

Every vertex of the one is set against the other, and every pair of edges: one of these has the two nearest points. It
is asked where neither a face nor two edges did.

Source: Ericson, *Real-Time Collision Detection*, section 5.1 (polyhedra: vertex against face, edge against edge).
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.scenes.detection import same_place
from nonsmooth.scenes.shape_rows import BOX
from nonsmooth.scenes.spatial.core import (
    BOX_EDGES,
    EDGES,
    TWO_EDGES,
    VERTEX_OF_J,
    between,
    in_axes,
    in_world,
    is_vertex,
    note,
    note_place,
    vertex_at,
)
from nonsmooth.scenes.spatial.edges import edge_point, feet, perpendicular
from nonsmooth.scenes.spatial.separating_axes import PARALLEL_EDGES, sine_squared
from nonsmooth.scenes.spatial.spheres import point_on_box

# chosen, of the reaches and radii of both: features are nearer only by more than this, so that of two ends, each
# nearest to the other, always the same one is told; some roundings of a place
NEARER_FEATURE = 1e-14


@rare_kernel
def nearest_features(shapes, scratch, i, j, limit):
    """Note the point of least distance, 1; or 0 where its gap is not below the limit."""
    scratch.manifold.gap[0] = limit
    n = vertices_on_core(shapes, scratch, i, j, True, 0)
    n = vertices_on_core(shapes, scratch, j, i, False, n)
    for edge_i in range(BOX_EDGES):
        for edge_j in range(BOX_EDGES):
            if is_edge(shapes, i, edge_i) and is_edge(shapes, j, edge_j):
                n = edge_on_edge(shapes, scratch, i, j, edge_i, edge_j, n)
    return n


@rare_kernel
def vertices_on_core(shapes, scratch, core, other, is_first, n):
    """Note the vertex of a core, which is i if is_first, that is nearest to the other core, if it is nearer than what
    is noted; n, or 1 then."""
    r_core, r_other, size = shapes.radius[core], shapes.radius[other], shapes.size
    c_x, c_y, c_z = between(scratch, other, core)
    for vertex in range(8):
        if is_vertex(shapes, core, vertex):
            x, y, z = vertex_at(shapes, scratch, core, vertex)
            u, v, w = in_axes(scratch, other, c_x + x, c_y + y, c_z + z)
            d, u, v, w = point_on_box(size[other, 0], size[other, 1], size[other, 2], u, v, w,
                                      same_place(shapes, core, other))  # fmt: skip
            if d - r_core - r_other < nearest_so_far(shapes, scratch, core, other, n):
                u, v, w = in_world(scratch, other, u, v, w)
                sign = -1.0 if is_first else 1.0
                note(scratch.manifold, 0, d - r_core - r_other, sign * u, sign * v, sign * w,
                     vertex + (0 if is_first else VERTEX_OF_J))  # fmt: skip
                note_place(scratch, 0, core, x, y, z, -0.5 * sign * (d + r_core - r_other))
                n = 1
    return n


@kernel
def nearest_so_far(shapes, scratch, a, b, n):
    """The gap that another feature must be below."""
    scale = shapes.reach[a] + shapes.reach[b] + shapes.radius[a] + shapes.radius[b]
    return scratch.manifold.gap[0] - (NEARER_FEATURE * scale if n > 0 else 0.0)


@kernel
def is_edge(shapes, s, edge):
    """Whether a core has this edge: all of a box, one of a capsule."""
    return shapes.kind[s] == BOX or edge == 8


@rare_kernel
def edge_on_edge(shapes, scratch, i, j, edge_i, edge_j, n):
    """Note the common perpendicular of two edges, if it meets both and is shorter than what is noted; n, or 1 then."""
    p, q = edge_i // 4, edge_j // 4
    if sine_squared(scratch.axes.cosine, p, q) <= PARALLEL_EDGES:
        return n
    t, s = feet(shapes, scratch, i, j, edge_i, edge_j)
    if abs(t) > shapes.size[i, p] or abs(s) > shapes.size[j, q]:
        return n
    x, y, z = between(scratch, i, j)
    a_x, a_y, a_z = edge_point(shapes, scratch, i, edge_i, t)
    b_x, b_y, b_z = edge_point(shapes, scratch, j, edge_j, s)
    x, y, z = x + b_x - a_x, y + b_y - a_y, z + b_z - a_z
    d, r_i, r_j = math.sqrt(x * x + y * y + z * z), shapes.radius[i], shapes.radius[j]
    if d - r_i - r_j >= nearest_so_far(shapes, scratch, i, j, n):
        return n
    if d > same_place(shapes, i, j):
        x, y, z = x / d, y / d, z / d
    else:
        x, y, z = perpendicular(scratch, i, j, p, q)
    note(scratch.manifold, 0, d - r_i - r_j, x, y, z, TWO_EDGES + EDGES * edge_i + edge_j)
    note_place(scratch, 0, i, a_x, a_y, a_z, 0.5 * (d + r_i - r_j))
    return 1
