"""A face of a box and the face, or the edge, of another core that is turned to it: the overlap, corner by corner.

In the axes of the reference box the incident face, the one whose normal is the most opposed, is clipped to the sides
of the reference face (Sutherland and Hodgman); each corner that is left has the height h above the face as its gap.
Corners are features of both: a vertex of the incident core, a vertex of the reference box, or a pair of edges,
whichever box has the reference face, so that keys do not change when two parallel faces take turns.

Source: Sutherland and Hodgman, "Reentrant polygon clipping", CACM 17, 1974; manifolds: Ericson, *Real-Time Collision
Detection*, section 5.5.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.scenes.shape_rows import BOX
from nonsmooth.scenes.spatial.core import (
    EDGES,
    TWO_EDGES,
    VERTEX_OF_J,
    between,
    edge_number,
    in_axes,
    in_world,
    note,
    note_place,
    vertex_at,
)

NO_EDGE = 16  # code: sides from here on are planes of the clip, 2 axis + (1 on the positive side)


@rare_kernel
def clip_to_face(shapes, scratch, ref, inc, axis, sign, is_first, slack):
    """The overlap of face ``axis`` of the reference box, on that side of it (sign) and wider by a slack, with the
    incident core, to ``scratch.polygon``; how many corners. The reference is i if is_first."""
    n = incident_polygon(shapes, scratch, ref, inc, axis, sign, is_first)
    is_open = n == 2
    for k in range(1, 3):
        for side in range(2):
            n = clip_to_side(shapes, scratch, ref, (axis, sign, is_first), ((axis + k) % 3, side), n, is_open, slack)
    return n


@kernel
def incident_polygon(shapes, scratch, ref, inc, axis, sign, is_first):
    """The incident face of a box, or the segment of a capsule, in the axes of the reference."""
    if shapes.kind[inc] != BOX:
        put_corner(shapes, scratch, ref, inc, 0, edge_number(2, 0), 0, is_first)
        put_corner(shapes, scratch, ref, inc, 4, edge_number(2, 0), 1, is_first)
        return 2
    cosine = scratch.axes.cosine
    most, face = -1.0, 0
    for q in range(3):
        along = abs(cosine[axis, q] if is_first else cosine[q, axis])
        if along > most:
            most, face = along, q
    along = cosine[axis, face] if is_first else cosine[face, axis]
    base = 0 if sign * along > 0.0 else 1 << face  # the side of the incident face
    u, v = 1 << (face + 1) % 3, 1 << (face + 2) % 3
    put_corner(shapes, scratch, ref, inc, base, edge_number((face + 1) % 3, base), 0, is_first)
    put_corner(shapes, scratch, ref, inc, base | u, edge_number((face + 2) % 3, base | u), 1, is_first)
    put_corner(shapes, scratch, ref, inc, base | u | v, edge_number((face + 1) % 3, base | v), 2, is_first)
    put_corner(shapes, scratch, ref, inc, base | v, edge_number((face + 2) % 3, base), 3, is_first)
    return 4


@rare_kernel
def put_corner(shapes, scratch, ref, inc, vertex, edge, k, is_first):
    """Corner k of the polygon: a vertex of the incident core, and the edge behind it."""
    polygon = scratch.polygon
    x, y, z = between(scratch, ref, inc)
    a, b, c = vertex_at(shapes, scratch, inc, vertex)
    polygon.corner[k, 0], polygon.corner[k, 1], polygon.corner[k, 2] = in_axes(scratch, ref, x + a, y + b, z + c)
    polygon.feature[k], polygon.side[k] = vertex + (VERTEX_OF_J if is_first else 0), edge


@rare_kernel
def clip_to_side(shapes, scratch, ref, face, border, n, is_open, slack):
    """Clip the polygon of n corners to one border (axis, side) of the reference face (axis, sign, is_first); the new
    n."""
    axis, sign, is_first = face
    across, side = border
    polygon, clipped, m = scratch.polygon, scratch.clipped, 0
    half, out = shapes.size[ref, across] + slack, 1.0 if side == 1 else -1.0
    for k in range(n):
        following = k + 1 if k + 1 < n else 0
        d = out * polygon.corner[k, across] - half
        d_next = out * polygon.corner[following, across] - half
        if d <= 0.0:
            copy_corner(polygon, k, clipped, m)
            m += 1
        if (d <= 0.0) != (d_next <= 0.0) and not (is_open and following == 0):
            part = d / (d - d_next)
            for a in range(3):
                clipped.corner[m, a] = polygon.corner[k, a] + part * (
                    polygon.corner[following, a] - polygon.corner[k, a]
                )
            clipped.feature[m] = cut_feature(axis, sign, across, side, polygon.side[k], is_first)
            clipped.side[m] = polygon.side[k] if d > 0.0 else NO_EDGE + 2 * across + side
            m += 1
    for k in range(m):
        copy_corner(clipped, k, polygon, k)
    return m


@kernel
def copy_corner(source, k, target, m):
    """Corner k of one polygon as corner m of another."""
    for a in range(3):
        target.corner[m, a] = source.corner[k, a]
    target.feature[m], target.side[m] = source.feature[k], source.side[k]


@kernel
def cut_feature(axis, sign, across, side, cut, is_first):
    """Where a side of the reference face cuts an edge of the incident core: the two edges. Where it cuts another side:
    the vertex of the reference face."""
    corner = (1 << axis if sign > 0.0 else 0) | (side << across)
    if cut < NO_EDGE:
        own = edge_number(3 - axis - across, corner)
        return TWO_EDGES + (EDGES * own + cut if is_first else EDGES * cut + own)
    other = (cut - NO_EDGE) // 2
    return (corner | ((cut & 1) << other)) + (0 if is_first else VERTEX_OF_J)


@kernel
def is_on_a_side(shapes, scratch, ref, axis, n, within):
    """Whether all corners of the overlap are on one side of the reference face: which of them is then by rounding."""
    for k in range(1, 3):
        across, low, high = (axis + k) % 3, math.inf, -math.inf
        for c in range(n):
            low, high = min(low, scratch.polygon.corner[c, across]), max(high, scratch.polygon.corner[c, across])
        if max(abs(low), abs(high)) + within >= shapes.size[ref, across] and high - low <= within:
            return True
    return False


@kernel
def on_face(shapes, polygon, ref, axis, k):
    """Corner k, which is not beyond the border of the reference face by more than a slack, put back onto it."""
    a, b, c = polygon.corner[k, 0], polygon.corner[k, 1], polygon.corner[k, 2]
    size = shapes.size
    if axis != 0:
        a = min(max(a, -size[ref, 0]), size[ref, 0])
    if axis != 1:
        b = min(max(b, -size[ref, 1]), size[ref, 1])
    if axis != 2:
        c = min(max(c, -size[ref, 2]), size[ref, 2])
    return a, b, c


@kernel
def lowest_corner(scratch, ref_half, axis, sign, n):
    """The least height of the corners above the face."""
    lowest = math.inf
    for k in range(n):
        lowest = min(lowest, sign * scratch.polygon.corner[k, axis] - ref_half)
    return lowest


@kernel
def note_corners(shapes, scratch, ref, inc, face, n, limit):
    """Note the corners whose gaps above a face (axis, sign, is_first) are below the limit; how many."""
    axis, sign, is_first = face
    polygon, m = scratch.polygon, 0
    r_ref, r_inc = shapes.radius[ref], shapes.radius[inc]
    way = 1.0 if is_first else -1.0
    for k in range(n):
        d = sign * polygon.corner[k, axis] - shapes.size[ref, axis]
        if d - r_ref - r_inc < limit:
            up = way * sign
            note(scratch.manifold, m, d - r_ref - r_inc, up * scratch.axis[ref, axis, 0],
                 up * scratch.axis[ref, axis, 1], up * scratch.axis[ref, axis, 2], polygon.feature[k])  # fmt: skip
            x, y, z = in_world(scratch, ref, *on_face(shapes, polygon, ref, axis, k))
            note_place(scratch, m, ref, x, y, z, -0.5 * way * (d + r_inc - r_ref))
            m += 1
    return m
