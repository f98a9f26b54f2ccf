"""The two nearest points of two convex cores that are apart: the method of Gilbert, Johnson and Keerthi.

The point v of the set j - i that is nearest to the origin is looked for among simplices of support points w(-v); v is
it where v . w = v . v. Each direction v/|v| proves that the cores are v . w/|v| apart at least: the best proof is kept.

Sources: Gilbert, Johnson, Keerthi, *IEEE J. Robotics and Automation* 4 (1988) 193-203; points of a simplex: Ericson,
*Real-Time Collision Detection*, sections 5.1.5 and 5.1.6.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.rotation import cross
from nonsmooth.scenes.spatial.support import difference

MOST_POINTS = 100  # measured: of support points, which are at most 40 of two ellipsoids of ratio 100
NEAREST = 16 * EPS  # chosen: of the sizes of both, by which a distance may miss the one that is proved


@rare_kernel
def nearest_points(shapes, scratch, i, j, shift, start, scale, most):
    """How far i and j, shifted, are apart at least, and the unit vector that proves it; at once where that is ``most``.

    That of i is left in ``scratch.simplex``. A distance of 0 says that they overlap.
    """
    simplex = scratch.simplex
    best, n = -math.inf, start
    simplex.count = 0
    enter(shapes, scratch, i, j, shift, start)
    x, y, z = nearest_on_simplex(simplex)
    note_own(simplex)
    for _ in range(MOST_POINTS):
        d = math.sqrt(x * x + y * y + z * z)
        if d <= NEAREST * scale:
            return 0.0, n
        way = (x / d, y / d, z / d)
        along = enter(shapes, scratch, i, j, shift, way)
        if along > best:
            best, n = along, way
        if best >= most or d - best <= NEAREST * scale:
            break
        x_1, y_1, z_1 = nearest_on_simplex(simplex)
        square = x_1 * x_1 + y_1 * y_1 + z_1 * z_1
        if square >= d * d or (best > 0.0 and square == 0.0):  # roundings of a flat simplex: no better is to be had
            break
        x, y, z = x_1, y_1, z_1
        note_own(simplex)
    return best, n


@kernel
def note_own(simplex):
    """Keep the point of i that is nearest so far."""
    for c in range(3):
        total = 0.0
        for k in range(simplex.count):
            total += simplex.part[k] * simplex.own[k, c]
        simplex.point[c] = total


@kernel
def enter(shapes, scratch, i, j, shift, n):
    """Take the support point along n into the simplex; how far along n it is."""
    simplex = scratch.simplex
    w, a = difference(shapes, scratch, i, j, n)
    k = simplex.count
    for c in range(3):
        simplex.corner[k, c], simplex.own[k, c] = w[c] + shift[c], a[c]
    simplex.count = k + 1
    return simplex.corner[k, 0] * n[0] + simplex.corner[k, 1] * n[1] + simplex.corner[k, 2] * n[2]


@rare_kernel
def nearest_on_simplex(simplex):
    """The point of the simplex nearest to the origin; corners that it does not need are dropped."""
    if simplex.count == 1:
        simplex.part[0] = 1.0
    elif simplex.count == 2:
        on_edge(simplex)
    elif simplex.count == 3:
        on_triangle(simplex, 0, 1, 2)
    else:
        on_tetrahedron(simplex)
    keep_needed(simplex)
    x, y, z = 0.0, 0.0, 0.0
    for k in range(simplex.count):
        x += simplex.part[k] * simplex.corner[k, 0]
        y += simplex.part[k] * simplex.corner[k, 1]
        z += simplex.part[k] * simplex.corner[k, 2]
    return x, y, z


@kernel
def keep_needed(simplex):
    """Drop the corners without weight."""
    m = 0
    for k in range(simplex.count):
        if simplex.part[k] > 0.0:
            simplex.part[m] = simplex.part[k]
            for c in range(3):
                simplex.corner[m, c], simplex.own[m, c] = simplex.corner[k, c], simplex.own[k, c]
            m += 1
    simplex.count = m


@kernel
def corner_of(simplex, k):
    """A corner."""
    return simplex.corner[k, 0], simplex.corner[k, 1], simplex.corner[k, 2]


@kernel
def dot(a, b):
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def less(a, b):
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel
def on_edge(simplex):
    """Weights of the nearest point of an edge."""
    a, b = corner_of(simplex, 0), corner_of(simplex, 1)
    e = less(b, a)
    along, square = -dot(a, e), dot(e, e)
    t = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
    simplex.part[0], simplex.part[1] = 1.0 - t, t


@rare_kernel
def on_triangle(simplex, i_a, i_b, i_c):
    """Weights of the nearest point of a triangle; its square of distance."""
    part = simplex.part
    a, b, c = corner_of(simplex, i_a), corner_of(simplex, i_b), corner_of(simplex, i_c)
    part[i_a], part[i_b], part[i_c] = weights_on_triangle(a, b, c)
    p_x = part[i_a] * a[0] + part[i_b] * b[0] + part[i_c] * c[0]
    p_y = part[i_a] * a[1] + part[i_b] * b[1] + part[i_c] * c[1]
    p_z = part[i_a] * a[2] + part[i_b] * b[2] + part[i_c] * c[2]
    return p_x * p_x + p_y * p_y + p_z * p_z


@rare_kernel
def weights_on_triangle(a, b, c):
    """Of its corners, by the regions of Voronoi."""
    e, f = less(b, a), less(c, a)
    d_1, d_2 = -dot(e, a), -dot(f, a)
    if d_1 <= 0.0 and d_2 <= 0.0:
        return 1.0, 0.0, 0.0
    d_3, d_4 = -dot(e, b), -dot(f, b)
    if d_3 >= 0.0 and d_4 <= d_3:
        return 0.0, 1.0, 0.0
    in_c = d_1 * d_4 - d_3 * d_2
    if in_c <= 0.0 and d_1 >= 0.0 and d_3 <= 0.0:
        t = d_1 / (d_1 - d_3) if d_1 - d_3 > 0.0 else 0.0
        return 1.0 - t, t, 0.0
    d_5, d_6 = -dot(e, c), -dot(f, c)
    if d_6 >= 0.0 and d_5 <= d_6:
        return 0.0, 0.0, 1.0
    in_b = d_5 * d_2 - d_1 * d_6
    if in_b <= 0.0 and d_2 >= 0.0 and d_6 <= 0.0:
        t = d_2 / (d_2 - d_6) if d_2 - d_6 > 0.0 else 0.0
        return 1.0 - t, 0.0, t
    in_a = d_3 * d_6 - d_5 * d_4
    if in_a <= 0.0 and d_4 - d_3 >= 0.0 and d_5 - d_6 >= 0.0:
        length = (d_4 - d_3) + (d_5 - d_6)
        t = (d_4 - d_3) / length if length > 0.0 else 0.0
        return 0.0, 1.0 - t, t
    whole = in_a + in_b + in_c
    return in_a / whole, in_b / whole, in_c / whole


@rare_kernel
def on_tetrahedron(simplex):
    """Weights of the nearest point of a tetrahedron: of the faces that the origin is outside of, the nearest."""
    part, best, face = simplex.part, math.inf, -1
    for k in range(4):
        if is_outside(simplex, k):
            square = on_triangle(simplex, (k + 1) % 4, (k + 2) % 4, (k + 3) % 4)
            if square < best:
                best, face = square, k
    if face < 0:
        simplex.corner[0, 0], simplex.corner[0, 1], simplex.corner[0, 2] = 0.0, 0.0, 0.0
        part[0], simplex.count = 1.0, 1
        return
    on_triangle(simplex, (face + 1) % 4, (face + 2) % 4, (face + 3) % 4)
    part[face] = 0.0


@kernel
def is_outside(simplex, k):
    """Whether the origin is not on the side of corner k of the face that does not have it."""
    a = corner_of(simplex, (k + 1) % 4)
    e, f = less(corner_of(simplex, (k + 2) % 4), a), less(corner_of(simplex, (k + 3) % 4), a)
    n = cross(e[0], e[1], e[2], f[0], f[1], f[2])
    return dot(n, a) * dot(n, less(corner_of(simplex, k), a)) >= 0.0
