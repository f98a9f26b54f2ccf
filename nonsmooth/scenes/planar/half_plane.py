"""A hull and a half-plane: every vertex is a point of contact.

    d = n . (c + a_k - o),    g_N = d - r,    p = c + a_k - n (d + r)/2

with the outward normal n of the half-plane and a point o of its border. The hull is outside where all its vertices are:
the points are all the conditions there are.
"""

from __future__ import annotations

from nonsmooth.jit import kernel
from nonsmooth.scenes.planar.hulls import feature_of
from nonsmooth.scenes.shape_rows import HALF_PLANE


@kernel
def hull_on_half_plane(shapes, scratch, i, j, limit):
    """The points of a pair whose gaps are below the limit; returns how many."""
    is_first = shapes.kind[i] == HALF_PLANE  # the half-plane is i
    plane, hull = (i, j) if is_first else (j, i)
    nx, ny, r = scratch.grid.normal[plane, 0], scratch.grid.normal[plane, 1], shapes.radius[hull]
    x = scratch.centre[hull, 0] - scratch.centre[plane, 0]
    y = scratch.centre[hull, 1] - scratch.centre[plane, 1]
    height = nx * x + ny * y
    if height - shapes.reach[hull] - r >= limit:
        return 0
    manifold, sign, n = scratch.manifold, 1.0 if is_first else -1.0, 0
    manifold.nx, manifold.ny = sign * nx, sign * ny
    for k in range(shapes.count[hull]):
        w = shapes.first[hull] + k
        d = height + (nx * scratch.arm[w, 0] + ny * scratch.arm[w, 1])
        if d - r < limit:
            manifold.gap[n], manifold.feature[n] = d - r, feature_of(shapes, hull, w, -sign)
            manifold.x[n] = scratch.centre[hull, 0] + scratch.arm[w, 0] - 0.5 * (d + r) * nx
            manifold.y[n] = scratch.centre[hull, 1] + scratch.arm[w, 1] - 0.5 * (d + r) * ny
            n += 1
    return n
