"""A cylinder, an ellipsoid or a polyhedron, and any other shape: the points where they touch.

    a half-space, a sphere on a cylinder       closed forms (`round_solids`)
    any other pair of convex cores, rounded    the direction that separates them most (`separating_direction`), the
                                               faces that they turn to one another (`turned_faces`), and the points
                                               where these lie over one another (`overlay`)

An entry point of its own: a scene without such shapes compiles nothing of it.

How exact: where a flat face decides, to rounding; else the gap to rounding and the normal to 1e-5, since the gap does
not change with it there.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import view
from nonsmooth.scenes.detection import in_order
from nonsmooth.scenes.shape_rows import CYLINDER, ELLIPSOID, HALF_SPACE, SPHERE, Shapes
from nonsmooth.scenes.spatial.core import NEAREST_POINTS, between, note, note_place, order_points, turn_over
from nonsmooth.scenes.spatial.nearest_points import nearest_points
from nonsmooth.scenes.spatial.overlay import overlay
from nonsmooth.scenes.spatial.placement import SpatialScratch
from nonsmooth.scenes.spatial.round_solids import solid_on_half_space, sphere_on_cylinder
from nonsmooth.scenes.spatial.separating_direction import CLOSE, FACE_OVER_POINTS, best_face, separating_direction
from nonsmooth.scenes.spatial.support import support
from nonsmooth.scenes.spatial.turned_faces import contact_axes, turned_face


@kernel("int64(int64, int64, int64, int64, float64)")
def solid_contact(shapes_at, scratch_at, i, j, limit):
    """The points of a pair of `Shapes`, in the order of their features, to the manifold of `SpatialScratch`; returns
    how many. Those with gaps beyond the limit may be left out."""
    shapes, scratch = view(shapes_at, Shapes), view(scratch_at, SpatialScratch)
    kind_i, kind_j = shapes.kind[i], shapes.kind[j]
    if kind_i == HALF_SPACE or kind_j == HALF_SPACE:
        n = solid_on_half_space(shapes, scratch, i, j, limit)
    elif kind_i == SPHERE and kind_j == CYLINDER:
        n = sphere_on_cylinder(shapes, scratch, i, j, limit, True)
    elif kind_i == CYLINDER and kind_j == SPHERE:
        n = sphere_on_cylinder(shapes, scratch, j, i, limit, False)
    else:
        a, b = in_order(shapes, i, j, between(scratch, i, j))
        n = convex_on_convex(shapes, scratch, a, b, limit)
        if a != i:
            turn_over(scratch.manifold, n)
    order_points(scratch.manifold, n)
    return n


@kernel("int64(int64, int64, int64, int64, float64)")
def further_points(shapes_at, scratch_at, i, j, limit):
    """Behind the one point of two boxes, or a capsule and a box, where else they may touch within the step: the corners
    of their faces over one another; how many points there are then. An edge that lands swings another corner down."""
    shapes, scratch = view(shapes_at, Shapes), view(scratch_at, SpatialScratch)
    manifold = scratch.manifold
    a, b = in_order(shapes, i, j, between(scratch, i, j))
    if a != i:
        turn_over(manifold, 1)
    normal = (manifold.normal[0, 0], manifold.normal[0, 1], manifold.normal[0, 2])
    n = with_faces(shapes, scratch, a, b, normal, limit, 1)
    if a != i:
        turn_over(manifold, n)
    order_points(manifold, n)
    return n


@rare_kernel
def with_faces(shapes, scratch, i, j, normal, limit, n):
    """Behind the first n points, the corners of what the cores turn to one another along a normal; the new n."""
    e, f = contact_axes(scratch, i, normal)
    triad = (e, f, normal)
    n_i = turned_face(shapes, scratch, i, i, triad, 1.0, scratch.face_i)
    n_j = turned_face(shapes, scratch, j, i, triad, -1.0, scratch.face_j)
    return overlay(shapes, scratch, (i, j), triad, (n_i, n_j), limit, n)


@rare_kernel
def convex_on_convex(shapes, scratch, i, j, limit):
    """The points of two convex cores, rounded by their radii."""
    r_i, r_j, n = shapes.radius[i], shapes.radius[j], 0
    s, normal = separating_direction(shapes, scratch, i, j, limit + r_i + r_j)
    if s - r_i - r_j >= limit:
        return 0
    if has_corners(shapes.kind[i]) and has_corners(shapes.kind[j]):
        n = with_faces(shapes, scratch, i, j, normal, limit, n)
    lowest = math.inf
    for k in range(n):
        lowest = min(lowest, scratch.manifold.gap[k])
    if lowest > s - r_i - r_j + 2.0 * FACE_OVER_POINTS * (shapes.reach[i] + shapes.reach[j]):
        n = note_nearest(shapes, scratch, i, j, s, normal, n)
    return n


@kernel
def has_corners(kind):
    """Whether a core may turn a line or a face to another."""
    return kind != SPHERE and kind != ELLIPSOID


@rare_kernel
def note_nearest(shapes, scratch, i, j, s, normal, n):
    """Note the point between the nearest points of the cores, s apart along the normal; the new n. Upon a face that of
    an ellipsoid follows from the normal to rounding: nearest points are known to 1e-7."""
    r_i, r_j, scale = shapes.radius[i], shapes.radius[j], shapes.reach[i] + shapes.reach[j]
    for own, other, sign in ((i, j, 1.0), (j, i, -1.0)):
        if shapes.kind[own] == ELLIPSOID and best_face(shapes, scratch, i, j, other, -sign)[1] == normal:
            arm = support(shapes, scratch, own, sign * normal[0], sign * normal[1], sign * normal[2])
            note(scratch.manifold, n, s - r_i - r_j, normal[0], normal[1], normal[2], NEAREST_POINTS)
            note_place(scratch, n, own, arm[0], arm[1], arm[2], 0.5 * (sign * s + r_i - r_j))
            return n + 1
    t = max(0.0, CLOSE * scale - s)
    nearest_points(shapes, scratch, i, j, (t * normal[0], t * normal[1], t * normal[2]), normal, scale, math.inf)
    point = scratch.simplex.point
    note(scratch.manifold, n, s - r_i - r_j, normal[0], normal[1], normal[2], NEAREST_POINTS)
    note_place(scratch, n, i, point[0], point[1], point[2], 0.5 * (s + r_i - r_j))
    return n + 1
