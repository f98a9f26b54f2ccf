"""The unit vector along which two convex cores are farthest apart, or overlap least.

Apart, it is that of their nearest points. Where they touch or overlap, s(n) (`support`) is made larger step by step
from several starts: with j moved away by t along n, far enough to be apart,

    n <- the direction of the nearest points,  which maximises s(m) + t m . n  over all unit vectors m

so that s never falls, and a face whose normal maximises s is found in one step. Starts are the way between the centres,
the best of the faces of either, and, where they overlap by more than a thousandth, the way out of the polytope of their
differences (`expanding_polytope`), which leads to the largest s of all. Source of the step, the proximal point method:
Rockafellar, *SIAM J. Control Optim.* 14 (1976) 877-898.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.shape_rows import BOX, CYLINDER, POLYHEDRON
from nonsmooth.scenes.spatial.core import between, in_world
from nonsmooth.scenes.spatial.expanding_polytope import deepest_direction
from nonsmooth.scenes.spatial.nearest_points import nearest_points
from nonsmooth.scenes.spatial.support import across, separation

# chosen: of the smaller core: nearer than this the direction of two points loses digits; what j is moved away by then
CLOSE = 1e-3
MOST_ASCENTS = 40  # chosen: depths of the size of a round core converge by a half a step
SAME_SEPARATION = 16 * EPS  # chosen: of both cores: what is better by less is the same
# chosen: of both cores: a face that separates as well but for this is the contact, as it is with boxes (`boxes`): its
# normal has the digits of the body's axes, that of two points 12
FACE_OVER_POINTS = 1e-12


@rare_kernel
def separating_direction(shapes, scratch, i, j, most):
    """s and its direction; at once where s is ``most``."""
    scale = shapes.reach[i] + shapes.reach[j]
    smaller = min(shapes.reach[i], shapes.reach[j])
    close = CLOSE * (smaller if smaller > 0.0 else scale)
    middle = towards(scratch, i, j)
    s, n = nearest_points(shapes, scratch, i, j, (0.0, 0.0, 0.0), middle, scale, most)
    if s >= most and s > 0.0:  # 0 is no proof: so it is where they overlap
        return s, n
    s_i, n_i = best_face(shapes, scratch, i, j, i, 1.0)
    s_j, n_j = best_face(shapes, scratch, i, j, j, -1.0)
    if s <= close:
        s, n = ascent(shapes, scratch, i, j, n if s > SAME_SEPARATION * scale else middle, close, scale)
        s, n = better((s, n), (s_i, n_i), shapes, scratch, i, j, close, scale)
        s, n = better((s, n), (s_j, n_j), shapes, scratch, i, j, close, scale)
    if s <= -close:
        n_deep = deepest_direction(shapes, scratch, i, j, scale)
        s, n = better((s, n), (s, n_deep), shapes, scratch, i, j, close, scale)
    if s_i >= s - FACE_OVER_POINTS * scale and s_i >= s_j - SAME_SEPARATION * scale:
        return s_i, n_i
    if s_j >= s - FACE_OVER_POINTS * scale:
        return s_j, n_j
    return s, n


@kernel
def towards(scratch, i, j):
    """The unit vector from the centre of i to that of j; where they meet, z."""
    x, y, z = between(scratch, i, j)
    d = math.sqrt(x * x + y * y + z * z)
    if d == 0.0:
        return 0.0, 0.0, 1.0
    return x / d, y / d, z / d


@kernel
def better(found, face, shapes, scratch, i, j, close, scale):
    """What ascends from a face, where it comes higher than what was found; s and its direction each."""
    s, n = found
    s_face, n_face = face
    if s_face > -math.inf:
        s_up, n_up = ascent(shapes, scratch, i, j, n_face, close, scale)
        if s_up > s + SAME_SEPARATION * scale:
            return s_up, n_up
    return s, n


@rare_kernel
def ascent(shapes, scratch, i, j, n, close, scale):
    """The largest s on the way up from n, and where it is."""
    s = separation(shapes, scratch, i, j, n)
    for _ in range(MOST_ASCENTS):
        t = close + max(0.0, -s)
        shift = (t * n[0], t * n[1], t * n[2])
        _, m = nearest_points(shapes, scratch, i, j, shift, n, scale, math.inf)
        s_m = separation(shapes, scratch, i, j, m)
        if s_m <= s + SAME_SEPARATION * scale:
            break
        s, n = s_m, m
    return s, n


@rare_kernel
def best_face(shapes, scratch, i, j, own, sign):
    """The face of ``own``, which is i where the sign is 1, that separates most; -inf where it has none."""
    best, n, kind = -math.inf, (0.0, 0.0, 1.0), shapes.kind[own]
    for face in range(faces_of(shapes, own)):
        x, y, z = face_normal(shapes, scratch, own, face)
        s = separation(shapes, scratch, i, j, (sign * x, sign * y, sign * z))
        if s > best:
            best, n = s, (sign * x, sign * y, sign * z)
    if kind == CYLINDER:
        other = j if own == i else i
        x, y, z = side_towards(scratch, own, other)
        s = separation(shapes, scratch, i, j, (sign * x, sign * y, sign * z))
        if s > best:
            best, n = s, (sign * x, sign * y, sign * z)
    return best, n


@kernel
def faces_of(shapes, s):
    """How many plane faces a core has."""
    kind = shapes.kind[s]
    if kind == BOX:
        return 6
    if kind == CYLINDER:
        return 2
    return shapes.solids.faces[s] if kind == POLYHEDRON else 0


@kernel
def face_normal(shapes, scratch, s, face):
    """The outward normal of a face, in world axes."""
    if shapes.kind[s] == POLYHEDRON:
        normal, f = shapes.solids.normal, shapes.solids.first_face[s] + face
        return in_world(scratch, s, normal[f, 0], normal[f, 1], normal[f, 2])
    axis, k = scratch.axis, 2 if shapes.kind[s] == CYLINDER else face // 2
    side = 1.0 if face % 2 == 1 else -1.0
    return side * axis[s, k, 0], side * axis[s, k, 1], side * axis[s, k, 2]


@kernel
def side_towards(scratch, s, other):
    """The normal of the side of a cylinder that is turned to another centre."""
    axis = scratch.axis
    x, y, z = between(scratch, s, other)
    u = x * axis[s, 0, 0] + y * axis[s, 0, 1] + z * axis[s, 0, 2]
    v = x * axis[s, 1, 0] + y * axis[s, 1, 1] + z * axis[s, 1, 2]
    u, v = across(u, v)
    return in_world(scratch, s, u, v, 0.0)
