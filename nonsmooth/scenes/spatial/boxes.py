"""Two box cores, one of them a box at least: boxes, rounded boxes, a capsule on a box.

    the face of largest separation s, unless two edges are clearly farther apart
        -> its overlap with the incident face: up to 8 points with the normal of the face (`face_manifold`);
    two edges  ->  one point on their common perpendicular;
    neither holds the nearest points (beyond the face, off the ends of the edges)  ->  `nearest_features`.

Whether a step found it is known: s is never more than the distance, so where a corner of the overlap is no higher than
s, or where the perpendicular meets both edges, it did.
"""

from __future__ import annotations

from nonsmooth.jit import rare_kernel
from nonsmooth.scenes.detection import FACE_PREFERENCE, same_place
from nonsmooth.scenes.spatial.core import VERTEX_OF_J, in_world, note, note_place, vertex_at
from nonsmooth.scenes.spatial.edges import edge_contact
from nonsmooth.scenes.spatial.face_manifold import clip_to_face, lowest_corner, note_corners
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
    axes, scale = scratch.axes, shapes.reach[i] + shapes.reach[j]
    is_first = axes.face < 3  # the reference is i
    ref, inc, axis = (i, j, axes.face) if is_first else (j, i, axes.face - 3)
    along = axes.t_i[axis] if is_first else -axes.t_j[axis]
    sign = 1.0 if along > 0.0 else -1.0  # the side of the face
    apart = max(axes.s_face, axes.s_edges)
    if axes.s_face >= axes.s_edges - FACE_OVER_EDGES * scale:
        n = clip_to_face(shapes, scratch, ref, inc, axis, sign, is_first)
        if lowest_corner(scratch, shapes.size[ref, axis], axis, sign, n) <= apart + FACE_PREFERENCE * scale:
            return note_corners(shapes, scratch, ref, inc, axis, sign, n, is_first, limit)
    is_near = apart <= same_place(shapes, i, j)
    if axes.s_edges > axes.s_face:
        n = edge_contact(shapes, scratch, i, j, is_near)
        if n == 1:
            return 1
    if is_near:
        return deepest_vertex(shapes, scratch, ref, inc, axis, sign, is_first)
    return nearest_features(shapes, scratch, i, j, limit)


@rare_kernel
def deepest_vertex(shapes, scratch, ref, inc, axis, sign, is_first):
    """The one point of corners that meet: the vertex of the incident core nearest to the face, with its normal."""
    vertex, d, cosine = 0, scratch.axes.s_face, scratch.axes.cosine
    for k in range(3):
        along = cosine[axis, k] if is_first else cosine[k, axis]
        if sign * along < 0.0 and shapes.size[inc, k] > 0.0:
            vertex |= 1 << k
    up = sign if is_first else -sign
    x, y, z = in_world(scratch, ref, up if axis == 0 else 0.0, up if axis == 1 else 0.0, up if axis == 2 else 0.0)
    r_ref, r_inc = shapes.radius[ref], shapes.radius[inc]
    note(scratch.manifold, 0, d - r_ref - r_inc, x, y, z, vertex + (VERTEX_OF_J if is_first else 0))
    x, y, z = vertex_at(shapes, scratch, inc, vertex)
    note_place(scratch, 0, inc, x, y, z, (-0.5 if is_first else 0.5) * (d + r_inc - r_ref))
    return 1
