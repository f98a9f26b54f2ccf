"""What separates two box cores most: a face of either, or a pair of edges.

The Minkowski difference of two convex polyhedra has as faces those of both and the parallelograms of two edges. With
the axes a_p of i and b_q of j, half lengths A_p and B_q, cosines C_pq = a_p . b_q, and d = c_j - c_i:

    face p of i    s = |a_p . d| - A_p - sum_q B_q |C_pq|
    face q of j    s = |b_q . d| - B_q - sum_p A_p |C_pq|
    edges p, q     s = (|n . d| - sum_k A_k |n . a_k| - sum_k B_k |n . b_k|) / |n|,     n = a_p x b_q

The largest s is minus the depth where the cores overlap; where they are apart it is no more than their distance.

Source: Gottschalk, Lin, Manocha, "OBBTree: a hierarchical structure for rapid interference detection", SIGGRAPH 1996;
Ericson, *Real-Time Collision Detection*, section 4.4.1.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.scenes.detection import FACE_PREFERENCE
from nonsmooth.scenes.shape_rows import BOX
from nonsmooth.scenes.spatial.core import between, in_axes

# chosen: sin^2 of two edges that count as parallel. Their normal is known to EPS/sin, 1e-8, and those of the faces
# beside them are as good
PARALLEL_EDGES = 1e-16


@rare_kernel
def separate(shapes, scratch, i, j, most):
    """Fill ``scratch.axes``; False as soon as an axis separates the cores by ``most``."""
    compare_axes(scratch, i, j)
    return separate_by_faces(shapes, scratch, i, j, most) and separate_by_edges(shapes, scratch, i, j, most)


@kernel
def compare_axes(scratch, i, j):
    """The cosines of the axes, and the way from i to j in the axes of each."""
    cosine, t_i, t_j, a = scratch.axes.cosine, scratch.axes.t_i, scratch.axes.t_j, scratch.axis
    x, y, z = between(scratch, i, j)
    for p in range(3):
        for q in range(3):
            cosine[p, q] = a[i, p, 0] * a[j, q, 0] + a[i, p, 1] * a[j, q, 1] + a[i, p, 2] * a[j, q, 2]
    t_i[0], t_i[1], t_i[2] = in_axes(scratch, i, x, y, z)
    t_j[0], t_j[1], t_j[2] = in_axes(scratch, j, x, y, z)


@kernel
def sine_squared(cosine, p, q):
    """sin^2 of the angle of axes p and q, to its own rounding: 1 - cos^2 may be 2e-16 where it is 0."""
    p_1, p_2 = (p + 1) % 3, (p + 2) % 3
    return cosine[p_1, q] * cosine[p_1, q] + cosine[p_2, q] * cosine[p_2, q]


@kernel
def separate_by_faces(shapes, scratch, i, j, most):
    """The face of largest separation, one of i where one of j is not clearly farther out."""
    axes, size, cosine = scratch.axes, shapes.size, scratch.axes.cosine
    axes.face, axes.s_face = -1, -math.inf
    if shapes.kind[i] == BOX:
        for p in range(3):
            s = abs(axes.t_i[p]) - size[i, p]
            for q in range(3):
                s -= size[j, q] * abs(cosine[p, q])
            if s > axes.s_face:
                axes.face, axes.s_face = p, s
    if shapes.kind[j] == BOX:
        preference = FACE_PREFERENCE * (shapes.reach[i] + shapes.reach[j])
        for q in range(3):
            s = abs(axes.t_j[q]) - size[j, q]
            for p in range(3):
                s -= size[i, p] * abs(cosine[p, q])
            if s > axes.s_face + (preference if axes.face < 3 else 0.0):
                axes.face, axes.s_face = 3 + q, s
    return axes.s_face < most


@kernel
def separate_by_edges(shapes, scratch, i, j, most):
    """The pair of edges of largest separation."""
    axes, size, cosine = scratch.axes, shapes.size, scratch.axes.cosine
    axes.edges, axes.s_edges = -1, -math.inf
    for p in range(3):
        if shapes.kind[i] == BOX or p == 2:
            p_1, p_2 = (p + 1) % 3, (p + 2) % 3
            for q in range(3):
                if shapes.kind[j] == BOX or q == 2:
                    q_1, q_2 = (q + 1) % 3, (q + 2) % 3
                    sine_2 = sine_squared(cosine, p, q)
                    if sine_2 > PARALLEL_EDGES:
                        s = abs(axes.t_i[p_2] * cosine[p_1, q] - axes.t_i[p_1] * cosine[p_2, q])
                        s -= size[i, p_1] * abs(cosine[p_2, q]) + size[i, p_2] * abs(cosine[p_1, q])
                        s -= size[j, q_1] * abs(cosine[p, q_2]) + size[j, q_2] * abs(cosine[p, q_1])
                        s /= math.sqrt(sine_2)
                        if s > axes.s_edges:
                            axes.edges, axes.s_edges = 3 * p + q, s
    return axes.s_edges < most
