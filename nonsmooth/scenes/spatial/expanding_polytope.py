"""The unit vector along which two convex cores that overlap part the soonest: the expanding polytope algorithm.

The set D = j - i of the differences of two cores has the origin inside, and is as deep there as its nearest support
plane, min h(n), h(n) = max over D of n . w = -s(-n) (`support`). A polytope of support points grows within D, at the
face that is nearest to the origin, until D has no point beyond this face:

    distance of the face  <=  min h  <=  h(normal of the face)

so that the least h of all faces that were grown is the depth but for the difference of the two. A polytope that does
not have the origin inside yet has faces of negative distance, which are grown first.

Source: van den Bergen, "Proximity queries and penetration depth computation on 3D game objects", GDC 2001.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.scenes.rotation import cross
from nonsmooth.scenes.spatial.core import between
from nonsmooth.scenes.spatial.placement import MOST_GROWN, MOST_TRIANGLES
from nonsmooth.scenes.spatial.support import difference

# chosen: of the depth: what is left to be found, which the ascent from here finds (`separating_direction`)
GROWN = 1e-3
NO_HEIGHT = 1e-12  # chosen: of both cores: a point that is no higher above a face and a face that is no wider are none


@rare_kernel
def deepest_direction(shapes, scratch, i, j, scale):
    """A direction near that of the largest s of all, from i to j."""
    polytope = scratch.polytope
    start(shapes, scratch, i, j, scale)
    least, best, even = math.inf, (0.0, 0.0, 1.0), NO_HEIGHT * scale
    while polytope.points < MOST_GROWN:
        face = nearest_face(polytope)
        if face < 0:
            break
        n = (polytope.normal[face, 0], polytope.normal[face, 1], polytope.normal[face, 2])
        height = add_point(shapes, scratch, i, j, n)
        if height < least:
            least, best = height, n
        if least - polytope.distance[face] <= max(GROWN * least, even) or not grow(polytope, even):
            break
    return -best[0], -best[1], -best[2]


@kernel
def add_point(shapes, scratch, i, j, n):
    """Take the point of D farthest along n; returns h(n)."""
    w, _ = difference(shapes, scratch, i, j, (-n[0], -n[1], -n[2]))
    polytope = scratch.polytope
    for c in range(3):
        polytope.point[polytope.points, c] = w[c]
    polytope.points += 1
    return w[0] * n[0] + w[1] * n[1] + w[2] * n[2]


@kernel
def way(polytope, a, b):
    """From point a to point b."""
    p = polytope.point
    return p[b, 0] - p[a, 0], p[b, 1] - p[a, 1], p[b, 2] - p[a, 2]


@rare_kernel
def start(shapes, scratch, i, j, scale):
    """A tetrahedron of support points, or what there is of one."""
    polytope = scratch.polytope
    polytope.points = polytope.faces = 0
    x, y, z = between(scratch, i, j)
    n = (1.0, 0.0, 0.0) if abs(x) <= min(abs(y), abs(z)) else (0.0, 1.0, 0.0) if abs(y) <= abs(z) else (0.0, 0.0, 1.0)
    add_point(shapes, scratch, i, j, n)
    add_point(shapes, scratch, i, j, (-n[0], -n[1], -n[2]))
    x, y, z = way(polytope, 0, 1)
    n = cross(x, y, z, n[1], n[2], n[0])  # across the way
    height = add_point(shapes, scratch, i, j, n)
    if height - along(polytope, n, 0) <= NO_HEIGHT * scale * length_of(n):
        polytope.points -= 1
        add_point(shapes, scratch, i, j, (-n[0], -n[1], -n[2]))
    e, f = way(polytope, 0, 1), way(polytope, 0, 2)
    n = cross(e[0], e[1], e[2], f[0], f[1], f[2])
    height = add_point(shapes, scratch, i, j, n)
    if height - along(polytope, n, 0) > NO_HEIGHT * scale * length_of(n):
        a, b = 1, 0  # point 3 is on the side from which (0, 1, 2) is counterclockwise
    else:
        polytope.points -= 1
        add_point(shapes, scratch, i, j, (-n[0], -n[1], -n[2]))
        a, b = 0, 1
    add_face(polytope, a, b, 2, NO_HEIGHT * scale)
    add_face(polytope, b, a, 3, NO_HEIGHT * scale)
    add_face(polytope, a, 2, 3, NO_HEIGHT * scale)
    add_face(polytope, 2, b, 3, NO_HEIGHT * scale)


@kernel
def length_of(n):
    """|n|."""
    return math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])


@kernel
def along(polytope, n, a):
    """n . w of point a."""
    p = polytope.point
    return n[0] * p[a, 0] + n[1] * p[a, 1] + n[2] * p[a, 2]


@rare_kernel
def add_face(polytope, a, b, c, flat):
    """A face, counterclockwise from outside; one without a width is never grown."""
    k = polytope.faces
    e, f = way(polytope, a, b), way(polytope, a, c)
    n = cross(e[0], e[1], e[2], f[0], f[1], f[2])
    length = length_of(n)
    polytope.corner[k, 0], polytope.corner[k, 1], polytope.corner[k, 2] = a, b, c
    polytope.distance[k] = math.inf
    if length > flat * max(length_of(e), length_of(f)):
        n = (n[0] / length, n[1] / length, n[2] / length)
        polytope.distance[k] = along(polytope, n, a)
    polytope.normal[k, 0], polytope.normal[k, 1], polytope.normal[k, 2] = n
    polytope.faces = k + 1


@kernel
def nearest_face(polytope):
    """The face of least distance from the origin; -1 where there is none."""
    best, least = -1, math.inf
    for k in range(polytope.faces):
        if polytope.distance[k] < least:
            best, least = k, polytope.distance[k]
    return best


@rare_kernel
def grow(polytope, flat):
    """Put the last point on: the faces that it is above give way to those between it and their border; False where it
    is above none, or there is no room."""
    last = polytope.points - 1
    faces = edges = 0
    for k in range(polytope.faces):
        n = (polytope.normal[k, 0], polytope.normal[k, 1], polytope.normal[k, 2])
        if along(polytope, n, last) > polytope.distance[k] + flat:
            for c in range(3):
                edges = cross_out(polytope, polytope.corner[k, c], polytope.corner[k, (c + 1) % 3], edges)
        else:
            move_face(polytope, k, faces)
            faces += 1
    polytope.faces = faces
    if edges == 0 or faces + edges > MOST_TRIANGLES:
        return False
    for e in range(edges):
        add_face(polytope, polytope.edge[e, 0], polytope.edge[e, 1], last, flat)
    return True


@kernel
def cross_out(polytope, a, b, edges):
    """List the edge (a, b), or cross out (b, a): what is left in the end is the border; how many there are."""
    edge = polytope.edge
    for e in range(edges):
        if edge[e, 0] == b and edge[e, 1] == a:
            edge[e, 0], edge[e, 1] = edge[edges - 1, 0], edge[edges - 1, 1]
            return edges - 1
    edge[edges, 0], edge[edges, 1] = a, b
    return edges + 1


@kernel
def move_face(polytope, k, m):
    """Face k becomes face m."""
    for c in range(3):
        polytope.corner[m, c], polytope.normal[m, c] = polytope.corner[k, c], polytope.normal[k, c]
    polytope.distance[m] = polytope.distance[k]
