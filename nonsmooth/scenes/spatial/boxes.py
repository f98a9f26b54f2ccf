"""Two box cores, one of them a box at least: boxes, rounded boxes, a capsule on a box.

    the face of largest separation s, unless two edges are clearly farther apart
        -> its overlap with the incident face: up to 8 points with the normal of the face (`face_manifold`);
    two edges  ->  one point on their common perpendicular;
    neither holds the nearest points (beyond the face, off the ends of the edges)  ->  `nearest_features`.

Whether a step found it is known: s is never more than the distance, so where a corner of the overlap is no higher than
s, or where the perpendicular meets both edges, it did. Where the cores overlap, s is the depth, and its face or edges
hold the point.
"""

from __future__ import annotations

import math

from nonsmooth.jit import rare_kernel
from nonsmooth.scenes.detection import FACE_PREFERENCE, same_place
from nonsmooth.scenes.spatial.edges import edge_contact
from nonsmooth.scenes.spatial.face_manifold import clip_to_face, is_on_a_side, lowest_corner, note_corners
from nonsmooth.scenes.spatial.nearest_features import nearest_features
from nonsmooth.scenes.spatial.separating_axes import separate

# chosen, of the reaches of both: two edges are the contact only where they are farther apart by more than this than the
# best face. The angle between the normals, and what the stack of a face loses, is of this size; its gap's error is the
# square of it.
FACE_OVER_EDGES = 1e-6


@rare_kernel
def core_on_core(shapes, scratch, i, j, limit):
    """The points of a pair whose gaps are below the limit; returns how many."""
    if not separate(shapes, scratch, i, j, limit + shapes.radius[i] + shapes.radius[j]):
        return 0
    axes, scale, slack = scratch.axes, shapes.reach[i] + shapes.reach[j], same_place(shapes, i, j)
    is_first = axes.face < 3  # the reference is i
    ref, inc, axis = (i, j, axes.face) if is_first else (j, i, axes.face - 3)
    along = axes.t_i[axis] if is_first else -axes.t_j[axis]
    sign = 1.0 if along > 0.0 else -1.0  # the side of the face
    apart = max(axes.s_face, axes.s_edges)
    is_deep = apart < -slack
    if axes.s_face >= axes.s_edges - FACE_OVER_EDGES * scale:
        n = clip_to_face(shapes, scratch, ref, inc, axis, sign, is_first, 0.0)
        if n == 0 or is_on_a_side(shapes, scratch, ref, axis, n, 2.0 * slack):  # that only meet at their borders
            n = clip_to_face(shapes, scratch, ref, inc, axis, sign, is_first, slack)
        highest = math.inf if is_deep else apart + 2.0 * FACE_PREFERENCE * scale
        if n > 0 and lowest_corner(scratch, shapes.size[ref, axis], axis, sign, n) <= highest:
            return note_corners(shapes, scratch, ref, inc, (axis, sign, is_first), n, limit)
    if axes.s_edges > axes.s_face:
        beyond = math.inf if is_deep else slack if apart <= slack else 0.0
        if edge_contact(shapes, scratch, i, j, beyond):
            return 1
    return nearest_features(shapes, scratch, i, j, limit)
