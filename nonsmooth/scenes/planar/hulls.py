"""Two hulls: gap, normal and up to two points.

The Minkowski difference B - A of the cores is a convex polygon whose edges are those of A and B; the gap of the cores
is the signed distance of the origin from it. Its edge of largest separation,

    s = max over edges e of A and B of  min_k n_e . (b_k - a_e),

is where it is deepest in (s <= 0), and holds the nearest point or has it at an end (s > 0): the next polygon edges turn
away. So one face, the reference face, decides:

    the incident edge of the other hull (the most opposed normal), clipped to the ends of the face, has overlap
        -> the normal of the face, and a point at each end of the overlap: a vertex of the one or of the other;
    no overlap  ->  two vertices are nearest: the normal along the line between them, one point.

An incident edge that is steeper than 45 degrees touches with its nearer end alone.

Between the two, where edges overlap yet two ends of them are nearest (a window of the width of gap times angle), there
are both points, with the normal along the line between the vertices: it turns from one face's to the other's.

A vertex that is the end of the overlap is the feature of a point, whichever hull has the reference face, so that keys
do not change when two parallel faces take turns.

Source: the separating axis and clipping as in Ericson, *Real-Time Collision Detection*, sections 5.2.1 and 5.4;
Minkowski differences: Cameron and Culley, "Determining the minimum translational distance between two convex
polyhedra", ICRA 1986.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel
from nonsmooth.scenes.detection import FACE_PREFERENCE, SAME_PLACE, in_order, same_place


@kernel
def hull_on_hull(shapes, scratch, i, j, limit):
    """The points of a pair whose gaps are below the limit; returns how many."""
    if shapes.count[i] == 1 and shapes.count[j] == 1:
        return disc_on_disc(shapes, scratch, i, j, limit)
    c, most = scratch.centre, limit + shapes.radius[i] + shapes.radius[j]
    a, b = in_order(shapes, i, j, (c[j, 0] - c[i, 0], c[j, 1] - c[i, 1], 0.0))
    s_a, face_a = farthest_face(shapes, scratch, a, b, most)
    if s_a >= most:
        return 0
    s_b, face_b = farthest_face(shapes, scratch, b, a, most)
    if s_b >= most:
        return 0
    if face_a >= 0 and s_b <= s_a + FACE_PREFERENCE * (shapes.reach[a] + shapes.reach[b]):
        return clip(shapes, scratch, a, b, face_a, 1.0 if a == i else -1.0)
    return clip(shapes, scratch, b, a, face_b, 1.0 if b == i else -1.0)


@kernel
def disc_on_disc(shapes, scratch, i, j, limit):
    """The one point of two discs; where their centres meet the normal is the y-axis."""
    x, y = scratch.centre[j, 0] - scratch.centre[i, 0], scratch.centre[j, 1] - scratch.centre[i, 1]
    r_i, r_j, manifold = shapes.radius[i], shapes.radius[j], scratch.manifold
    d = math.sqrt(x * x + y * y)
    if d - r_i - r_j >= limit:
        return 0
    manifold.nx, manifold.ny = 0.0, 1.0
    if d > SAME_PLACE * (r_i + r_j):
        manifold.nx, manifold.ny = x / d, y / d
    at = 0.5 * (d + r_i - r_j)
    manifold.gap[0], manifold.feature[0] = d - r_i - r_j, 0
    manifold.x[0], manifold.y[0] = scratch.centre[i, 0] + at * manifold.nx, scratch.centre[i, 1] + at * manifold.ny
    return 1


@kernel
def farthest_face(shapes, scratch, a, b, most):
    """The edge of hull a that the core of hull b is farthest outside of, and how far; at once one beyond ``most``."""
    arm, normal = scratch.arm, scratch.normal
    x, y = scratch.centre[b, 0] - scratch.centre[a, 0], scratch.centre[b, 1] - scratch.centre[a, 1]
    best, face = -math.inf, -1
    if shapes.count[a] == 1:
        return best, face
    for e in range(shapes.first[a], shapes.first[a] + shapes.count[a]):
        nx, ny = normal[e, 0], normal[e, 1]
        nearest = math.inf
        for w in range(shapes.first[b], shapes.first[b] + shapes.count[b]):
            nearest = min(nearest, nx * arm[w, 0] + ny * arm[w, 1])
        s = nearest + (nx * (x - arm[e, 0]) + ny * (y - arm[e, 1]))
        if s > best:
            best, face = s, e
            if s >= most:
                break
    return best, face


@kernel
def clip(shapes, scratch, ref, inc, e, sign):
    """The points of the incident hull on edge e of the reference hull, which is i where the sign is 1; how many."""
    arm, normal, manifold = scratch.arm, scratch.normal, scratch.manifold
    f, g = incident_edge(shapes, scratch, ref, inc, e)
    end = next_of(shapes, ref, e)
    nx, ny, length = normal[e, 0], normal[e, 1], shapes.length[e]
    x = scratch.centre[inc, 0] - scratch.centre[ref, 0] - arm[e, 0]
    y = scratch.centre[inc, 1] - scratch.centre[ref, 1] - arm[e, 1]
    # distance from the face and place along it, of the ends of the incident edge: f is ahead of g
    d_f, t_f = nx * (x + arm[f, 0]) + ny * (y + arm[f, 1]), nx * (y + arm[f, 1]) - ny * (x + arm[f, 0])
    d_g, t_g = nx * (x + arm[g, 0]) + ny * (y + arm[g, 1]), nx * (y + arm[g, 1]) - ny * (x + arm[g, 0])
    if f == g or abs(d_f - d_g) > t_f - t_g:
        if d_g < d_f:
            f, t_f, d_f = g, t_g, d_g
        if t_f < 0.0 or t_f > length:
            return corner(shapes, scratch, ref, inc, (e, e if t_f < 0.0 else end), (f, f), sign)
        manifold.nx, manifold.ny = sign * nx, sign * ny
        incident_point(shapes, scratch, ref, inc, f, d_f, sign, 0)
        return 1
    if t_f < 0.0:
        return corner(shapes, scratch, ref, inc, (e, e), (f, g), sign)
    if t_g > length:
        return corner(shapes, scratch, ref, inc, (e, end), (f, g), sign)
    if t_f > length and d_f <= d_g:
        nx, ny = normal_at_end(shapes, scratch, ref, inc, e, end, f, g)
    elif t_g < 0.0 and d_g <= d_f:
        nx, ny = normal_at_end(shapes, scratch, ref, inc, e, e, g, f)
    manifold.nx, manifold.ny = sign * nx, sign * ny
    cosine = nx * normal[e, 0] + ny * normal[e, 1]
    if t_g >= 0.0:
        incident_point(shapes, scratch, ref, inc, g, d_g / cosine, sign, 0)
    else:
        reference_point(shapes, scratch, ref, inc, e, f, sign, 0)
    if t_f <= length:
        incident_point(shapes, scratch, ref, inc, f, d_f / cosine, sign, 1)
    else:
        reference_point(shapes, scratch, ref, inc, end, f, sign, 1)
    order_two(manifold)
    return 2


@kernel
def normal_at_end(shapes, scratch, ref, inc, e, w, f, g):
    """The normal where the nearest end f of the incident edge is beyond end w of face e: that of the face, unless w is
    beyond f too. Then these two vertices are nearest, and the normal turns from that of the one face to the other's."""
    arm = scratch.arm
    nx, ny = scratch.normal[e, 0], scratch.normal[e, 1]
    x = scratch.centre[inc, 0] - scratch.centre[ref, 0] + arm[f, 0] - arm[w, 0]
    y = scratch.centre[inc, 1] - scratch.centre[ref, 1] + arm[f, 1] - arm[w, 1]
    d = math.sqrt(x * x + y * y)
    if x * (arm[g, 0] - arm[f, 0]) + y * (arm[g, 1] - arm[f, 1]) > 0.0 and d > same_place(shapes, ref, inc):
        nx, ny = x / d, y / d
    return nx, ny


@kernel
def corner(shapes, scratch, ref, inc, end, edge, sign):
    """The one point of vertex w of the reference hull, an end (e, w) of its face e, and the nearer end of the incident
    edge (f, g)."""
    e, w = end
    f, g = edge
    arm, manifold = scratch.arm, scratch.manifold
    x, y = scratch.centre[inc, 0] - scratch.centre[ref, 0], scratch.centre[inc, 1] - scratch.centre[ref, 1]
    x_f, y_f = x + arm[f, 0] - arm[w, 0], y + arm[f, 1] - arm[w, 1]
    x_g, y_g = x + arm[g, 0] - arm[w, 0], y + arm[g, 1] - arm[w, 1]
    d, d_g = math.sqrt(x_f * x_f + y_f * y_f), math.sqrt(x_g * x_g + y_g * y_g)
    if d_g < d:
        f, x_f, y_f, d = g, x_g, y_g, d_g
    nx, ny = scratch.normal[e, 0], scratch.normal[e, 1]
    if d > same_place(shapes, ref, inc):
        nx, ny = x_f / d, y_f / d
    else:
        d = nx * x_f + ny * y_f
    manifold.nx, manifold.ny = sign * nx, sign * ny
    incident_point(shapes, scratch, ref, inc, f, d, sign, 0)
    return 1


@kernel
def incident_point(shapes, scratch, ref, inc, w, d, sign, n):
    """Point n of the manifold: vertex w of the incident hull, where the cores are d apart along the normal."""
    r_ref, r_inc, manifold = shapes.radius[ref], shapes.radius[inc], scratch.manifold
    back = 0.5 * sign * (d + r_inc - r_ref)
    manifold.gap[n], manifold.feature[n] = d - r_ref - r_inc, feature_of(shapes, inc, w, -sign)
    manifold.x[n] = scratch.centre[inc, 0] + scratch.arm[w, 0] - back * manifold.nx
    manifold.y[n] = scratch.centre[inc, 1] + scratch.arm[w, 1] - back * manifold.ny


@kernel
def reference_point(shapes, scratch, ref, inc, w, f, sign, n):
    """Point n of the manifold: vertex w of the reference hull below the incident edge that begins at f."""
    arm, manifold = scratch.arm, scratch.manifold
    mx, my = scratch.normal[f, 0], scratch.normal[f, 1]
    x = scratch.centre[inc, 0] - scratch.centre[ref, 0] + arm[f, 0] - arm[w, 0]
    y = scratch.centre[inc, 1] - scratch.centre[ref, 1] + arm[f, 1] - arm[w, 1]
    d = (mx * x + my * y) / (sign * (mx * manifold.nx + my * manifold.ny))
    r_ref, r_inc = shapes.radius[ref], shapes.radius[inc]
    on = 0.5 * sign * (d + r_ref - r_inc)
    manifold.gap[n], manifold.feature[n] = d - r_ref - r_inc, feature_of(shapes, ref, w, sign)
    manifold.x[n] = scratch.centre[ref, 0] + arm[w, 0] + on * manifold.nx
    manifold.y[n] = scratch.centre[ref, 1] + arm[w, 1] + on * manifold.ny


@kernel
def feature_of(shapes, s, w, sign):
    """The feature of a vertex of shape i (sign > 0: even numbers) or j."""
    return 2 * (w - shapes.first[s]) + (0 if sign > 0.0 else 1)


@kernel
def order_two(manifold):
    """Put two points in the order of their features."""
    gap, x, y, feature = manifold.gap, manifold.x, manifold.y, manifold.feature
    if feature[0] > feature[1]:
        feature[0], feature[1] = feature[1], feature[0]
        gap[0], gap[1] = gap[1], gap[0]
        x[0], x[1] = x[1], x[0]
        y[0], y[1] = y[1], y[0]


@kernel
def incident_edge(shapes, scratch, ref, inc, e):
    """The ends of the edge whose normal is the most opposed to that of edge e; twice the one vertex of a disc."""
    normal, first = scratch.normal, shapes.first[inc]
    if shapes.count[inc] == 1:
        return first, first
    most, edge = math.inf, first
    for w in range(first, first + shapes.count[inc]):
        along = normal[e, 0] * normal[w, 0] + normal[e, 1] * normal[w, 1]
        if along < most:
            most, edge = along, w
    return edge, next_of(shapes, inc, edge)


@kernel
def next_of(shapes, s, w):
    """The vertex behind vertex w of a hull."""
    return w + 1 if w + 1 < shapes.first[s] + shapes.count[s] else shapes.first[s]
