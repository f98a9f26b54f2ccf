"""Contacts that cannot act, because another shape hides what touches: seams between flush faces, and layers.

Of a contact between shapes a and b, p is its point on b and m the normal out of b. Other shapes that p is in or on
belong to the surface that a meets. They hide

    a face of b          m is its normal, and all ways from p within the face are in other shapes:
                         the end of the next tile in a row, the inner faces of an L, what lies behind a thin sheet
    an edge or a corner  a face next to it is hidden, and b or another shape goes farther along m:
                         the edge of the next tile, which to a body on the row is no edge
    a seam               a face next to it is hidden, m is the normal of another one, which goes on in the other shape,
                         and what touches is no corner of a: it rests on its corners

and a corner of a upon a face of b has the normal of that face, not the one of a's face over it, where the face goes on
in another shape. So the contacts of a row of flush tiles are those of one floor, to rounding.

Other shapes are those that the same body touches: what hides b is as near to it as b. A seam is none of a body that
moves, which may need what holds it there; and where a alone does not move, other bodies may hide faces of b, no more.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.integrators.assembly.joints import Joints
from nonsmooth.integrators.assembly.landed import is_ball
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import Block, Ints, view
from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.detection import LAST_FEATURE, Found, Motion, exchange_found, key_of, move_found
from nonsmooth.scenes.faces import (
    along,
    angle_of,
    contains,
    flattest,
    goes_beyond,
    in_shape,
    in_world_of,
    out_of_shape,
    to_shape,
)
from nonsmooth.scenes.shape_rows import CYLINDER, ELLIPSOID, Shapes
from nonsmooth.scenes.spatial.core import NEAREST_POINTS, TWO_EDGES, VERTEX_OF_J

FLUSH = 1e-8  # chosen: of the smaller shape: faces, edges and points that are nearer than this are one
FLUSH_OF_ROUND = 1e-4  # chosen: where a core is round: its nearest point is known to 1e-5
# chosen: of the smaller shape: the way within a face on which it must be hidden. Faces of two shapes at angles below
# FLUSH/WAY_WITHIN are parallel
WAY_WITHIN = 1e-2
ALIGNED = 1e-5  # chosen: of two normals that are one: above FLUSH/WAY_WITHIN
SAME_BITS = 16 * EPS  # chosen: of two unit vectors that are one but for their rounding
STEEPEST_CORNER = 0.7071067811865476  # defined: sine of 45 degrees, up to which a corner of a is one upon a face of b
NO_PAIR = -1  # code: end of a list


class Links(Block):
    """The pairs of shapes that touch, listed by their bodies."""

    shape_i: Array[Ints, "m"]
    shape_j: Array[Ints, "m"]
    following: Array[Ints, "m", "2"]  # the next pair of the body of shape i, and of shape j
    first: Array[Ints, "n_b"]  # of a body
    joined: Array[Ints, "n_b"]  # whether it passes through another one: such may overlap, and hide nothing
    near: Array[Ints, "m"]  # shapes that a point of a contact is in
    hidden: Array[Ints, "m"]  # of a contact: whether it cannot act


@kernel("int64(int64, int64, int64, int64, int64, int64)")
def leave_out_hidden(shapes_at, motion_at, joints_at, links_at, found_at, n):
    """Leave out the contacts that are hidden, of the first n, and turn the normals of corners upon flush faces; how
    many are left."""
    shapes, motion = view(shapes_at, Shapes), view(motion_at, Motion)
    links, found, joints = view(links_at, Links), view(found_at, Found), view(joints_at, Joints)
    link(shapes, motion, found, links, n)
    for b in range(links.joined.shape[0]):
        links.joined[b] = 1 if joints.apart > 0 and joints.first[b] < joints.first[b + 1] else 0
    for c in range(n):
        links.hidden[c] = 1 if is_hidden(shapes, motion, links, found, c) else 0
    left = 0
    for c in range(n):
        if links.hidden[c] == 0:
            if left < c:
                move_found(found, c, left)
            left = sort_in(found, left)
    return left


@kernel
def sort_in(found, n):
    """Put contact n in its place by its key among those before it, which are in order; how many there are then: one
    corner of a body on a seam is one contact, the nearer one: the other may be with the side of the next tile."""
    at = n
    while at > 0 and found.key[at - 1] > found.key[n]:
        at -= 1
    if at > 0 and found.key[at - 1] == found.key[n]:
        if found.gap[n] < found.gap[at - 1]:
            exchange_found(found, n, at - 1)
        return n
    for c in range(n, at, -1):
        exchange_found(found, c, c - 1)
    return n + 1


@kernel
def link(shapes, motion, found, links, n):
    """List the pairs of the first n contacts by the bodies that move; contacts are in the order of their pairs."""
    for b in range(links.first.shape[0]):
        links.first[b] = NO_PAIR
    pair = NO_PAIR
    for c in range(n):
        i, j = found.shape_i[c], found.shape_j[c]
        if pair != NO_PAIR and links.shape_i[pair] == i and links.shape_j[pair] == j:
            continue
        pair += 1
        links.shape_i[pair], links.shape_j[pair] = i, j
        for side in range(2):
            b = shapes.body[i] if side == 0 else shapes.body[j]
            links.following[pair, side] = links.first[b]
            links.first[b] = 2 * pair + side


@kernel
def is_hidden(shapes, motion, links, found, c):
    """Whether contact c is hidden on either side."""
    i, j = found.shape_i[c], found.shape_j[c]
    if shapes.faces.count[j] > 0 and is_hidden_behind(shapes, motion, links, found, c, i, j):
        return True
    return shapes.faces.count[i] > 0 and is_hidden_behind(shapes, motion, links, found, c, j, i)


@kernel
def is_hidden_behind(shapes, motion, links, found, c, a, b):
    """Whether what contact c of shapes a and b touches of b is hidden."""
    body_a, body_b = shapes.body[a], shapes.body[b]
    centre = body_a if motion.moves[body_a] == 1 else body_b
    at = links.first[centre]
    if motion.moves[centre] == 0 or at == NO_PAIR or links.following[at // 2, at % 2] == NO_PAIR:
        return False
    return is_behind(shapes, motion, links, found, c, a, b)


@rare_kernel
def is_behind(shapes, motion, links, found, c, a, b):
    """The same, of a body that moves and touches several shapes."""
    x, faces, flush = motion.x, shapes.faces, FLUSH_OF_ROUND if is_round(shapes, a) else FLUSH
    moves_a, moves_b = motion.moves[shapes.body[a]], motion.moves[shapes.body[b]]
    m, p = side_of(found, c, b)
    r, u = to_shape(shapes, x, b, p), in_shape(shapes, x, b, m)
    f = flattest(faces, b, u)
    is_face = angle_of(faces, f, u) <= ALIGNED
    if is_face and is_behind_itself(faces, b, f, r, flush * size_of(shapes, a, b)):
        return True
    n = list_near(shapes, motion, links, a, b, (p, flush), False)
    if is_face and n > 0 and is_covered(shapes, x, links, (n, flush), b, f, r):
        return True
    is_corner = is_corner_of(found, c, a)
    is_upon = (
        is_corner
        and moves_a == 1
        and moves_b == 0
        and angle_of(faces, f, u) < (FLUSH_OF_ROUND if is_round(shapes, a) else STEEPEST_CORNER)
    )
    if is_upon and angle_of(faces, f, u) > SAME_BITS and is_continued(shapes, motion, links, a, b, f, (p, m)):
        if is_round(shapes, a):
            return True  # it is over the face of the other shape
        if turn_to_face(shapes, x, found, c, a, b, f):
            if is_between(shapes, motion, links, found, c, a, b, f):
                return True
            number_as_one(shapes, motion, links, found, c, a, b, f)
            return False
    if moves_a == 0:
        n = list_near(shapes, motion, links, a, b, (p, flush), True)
    if is_face and is_corner and moves_a == 1 and moves_b == 0:
        number_as_one(shapes, motion, links, found, c, a, b, f)
    if n == 0 or not has_seam(shapes, x, links, (n, flush), b, (f if is_face else -1), r):
        return False
    if is_face:
        return moves_b == 0 and not is_corner and goes_on_flat(shapes, x, links, (n, flush), p, m)
    slack = flush * size_of(shapes, a, b)
    if goes_beyond(faces, b, r, u, slack):
        return True
    for k in range(n):
        s = links.near[k]
        if goes_beyond(faces, s, to_shape(shapes, x, s, p), in_shape(shapes, x, s, m), slack):
            return True
        if is_ball(shapes, a, found.normal.shape[1]) and moves_b + motion.moves[shapes.body[s]] == 0 and s < b:
            return True  # the same point of a ridge, which s has
    return False


@kernel
def is_between(shapes, motion, links, found, c, a, b, f):
    """Whether face f of shape b, which a corner of a is turned to, is covered there: a corner that goes over the seam
    of two tiles is nearer to the edge of the one it leaves than to the face below that edge."""
    _, p = side_of(found, c, b)
    n = list_near(shapes, motion, links, a, b, (p, FLUSH), False)
    return n > 0 and is_covered(shapes, motion.x, links, (n, FLUSH), b, f, to_shape(shapes, motion.x, b, p))


@kernel
def is_behind_itself(faces, b, f, r, slack):
    """Whether shape b is between a point r of it and its face f, as it is at the upper corners of a thin plate."""
    half = 0.5 * (faces.height[f] - along(faces.normal, f, r))
    way = (half * faces.normal[f, 0], half * faces.normal[f, 1], half * faces.normal[f, 2])
    return half > slack and contains(faces, b, (r[0] + way[0], r[1] + way[1], r[2] + way[2]), slack)


@kernel
def is_round(shapes, s):
    """Whether the nearest points of a core are found by iteration."""
    return shapes.place.shape[1] > 3 and (shapes.kind[s] == CYLINDER or shapes.kind[s] == ELLIPSOID)


@kernel
def size_of(shapes, a, b):
    """The reach of the smaller of two shapes [m]."""
    return min(shapes.reach[a] + shapes.radius[a], shapes.reach[b] + shapes.radius[b])


@kernel
def side_of(found, c, b):
    """The normal out of shape b, one of contact c, and the point of its surface, (x, y, z) with z = 0 in the plane."""
    sign, is_planar = 1.0 if b == found.shape_i[c] else -1.0, found.normal.shape[1] == 2
    m = (sign * found.normal[c, 0], sign * found.normal[c, 1], 0.0 if is_planar else sign * found.normal[c, 2])
    half, point = 0.5 * found.gap[c], found.point
    z = 0.0 if is_planar else point[c, 2] - half * m[2]
    return m, (point[c, 0] - half * m[0], point[c, 1] - half * m[1], z)


@kernel
def is_corner_of(found, c, a):
    """Whether what touches of shape a is a corner, or round."""
    feature = found.key[c] & LAST_FEATURE
    is_first = found.shape_i[c] == a
    if found.normal.shape[1] == 2:
        return (feature % 2 == 0) == is_first
    if feature >= TWO_EDGES:
        return feature == NEAREST_POINTS
    return (feature < VERTEX_OF_J) == is_first


@kernel
def other_shape(shapes, motion, links, at, a, b, is_own):
    """The shape of entry ``at`` of a list that may hide b from a; b where it is none."""
    pair, side = at // 2, at % 2
    s = links.shape_j[pair] if side == 0 else links.shape_i[pair]
    if motion.moves[shapes.body[a]] == 0 and shapes.body[s] == shapes.body[a]:
        s = links.shape_i[pair] if side == 0 else links.shape_j[pair]
    if shapes.body[s] == shapes.body[a] or (is_own and shapes.body[s] != shapes.body[b]):
        return b
    if links.joined[shapes.body[s]] == 1 and links.joined[shapes.body[b]] == 1:
        return b
    return s if shapes.faces.count[s] > 0 else b


@kernel
def first_other(shapes, motion, links, a, b):
    """Where the list of the shapes begins that may hide b from a."""
    body_a = shapes.body[a]
    return links.first[body_a if motion.moves[body_a] == 1 else shapes.body[b]]


@kernel
def list_near(shapes, motion, links, a, b, place, is_own):
    """List the other shapes, those of the body of b alone if ``is_own``, that a point is in or on; how many."""
    p, flush = place
    n, at, x = 0, first_other(shapes, motion, links, a, b), motion.x
    while at != NO_PAIR:
        s = other_shape(shapes, motion, links, at, a, b, is_own)
        at = links.following[at // 2, at % 2]
        if s == b or is_far(shapes, x, s, p):
            continue
        if contains(shapes.faces, s, to_shape(shapes, x, s, p), flush * size_of(shapes, s, b)):
            links.near[n] = s
            n += 1
    return n


@kernel
def is_far(shapes, x, s, p):
    """Whether a point is farther from the body of shape s than any of its points."""
    b, place = shapes.body[s], shapes.place
    e_x, e_y = p[0] - x[b, 0], p[1] - x[b, 1]
    r_x, r_y = place[s, 0], place[s, 1]
    square, arm = e_x * e_x + e_y * e_y, r_x * r_x + r_y * r_y
    if x.shape[1] > 3:
        e_z, r_z = p[2] - x[b, 2], place[s, 2]
        square, arm = square + e_z * e_z, arm + r_z * r_z
    reach = (1.0 + FLUSH) * shapes.reach[s]
    return square > 2.0 * (arm + reach * reach)  # (a + b)^2 <= 2 (a^2 + b^2)


@kernel
def is_covered(shapes, x, links, listed, b, f, r):
    """Whether all ways from a point r within face f of shape b are in the shapes listed."""
    faces = shapes.faces
    corner, slack = faces.corner, listed[1] * shapes.reach[b]
    for k in range(faces.first_corner[f], faces.first_corner[f] + faces.corners[f]):
        w = (corner[k, 0] - r[0], corner[k, 1] - r[1], corner[k, 2] - r[2])
        length = (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) ** 0.5
        if length > slack:
            step = min(WAY_WITHIN * shapes.reach[b] / length, 0.5)
            q = out_of_shape(shapes, x, b, (r[0] + step * w[0], r[1] + step * w[1], r[2] + step * w[2]))
            if not is_in_one(shapes, x, links, listed, b, q):
                return False
    return faces.corners[f] > 0


@kernel
def is_in_one(shapes, x, links, listed, b, q):
    """Whether a point, from the centre of shape b along the axes of the world, is in one of the shapes listed."""
    p, (n, flush) = centre_of(shapes, x, b), listed
    for k in range(n):
        s = links.near[k]
        r = to_shape(shapes, x, s, (p[0] + q[0], p[1] + q[1], p[2] + q[2]))
        if contains(shapes.faces, s, r, flush * size_of(shapes, s, b)):
            return True
    return False


@kernel
def has_seam(shapes, x, links, listed, b, f, r):
    """Whether a face of shape b that a point r is on, another one than f, is covered by the shapes listed."""
    faces, slack = shapes.faces, listed[1] * shapes.reach[b]
    for g in range(faces.first[b], faces.first[b] + faces.count[b]):
        if g != f and abs(along(faces.normal, g, r) - faces.height[g]) <= slack:
            if is_covered(shapes, x, links, listed, b, g, r):
                return True
    return False


@kernel
def goes_on_flat(shapes, x, links, listed, p, m):
    """Whether a face with normal m goes on at a point in one of the shapes listed."""
    faces, (n, flush) = shapes.faces, listed
    for k in range(n):
        s = links.near[k]
        f, r = flattest(faces, s, in_shape(shapes, x, s, m)), to_shape(shapes, x, s, p)
        is_there = abs(along(faces.normal, f, r) - faces.height[f]) <= flush * shapes.reach[s]
        if is_there and angle_of(faces, f, in_shape(shapes, x, s, m)) <= ALIGNED:
            return True
    return False


@kernel
def number_as_one(shapes, motion, links, found, c, a, b, f):
    """Give contact c upon a fixed face the key of a contact with the first of the shapes in which the face goes on.

    Impulses under a face are not unique: the solvers find those that they come to first, in the order of the keys.
    """
    is_first, key, feature = b == found.shape_i[c], found.key[c], found.key[c] & LAST_FEATURE
    at = first_other(shapes, motion, links, a, b)
    while at != NO_PAIR:
        s = other_shape(shapes, motion, links, at, a, b, False)
        at = links.following[at // 2, at % 2]
        if s < b and (is_first or s > a) and motion.moves[shapes.body[s]] == 0 and are_flush(shapes, motion.x, b, f, s):
            key = min(key, key_of(s, found.shape_j[c], feature) if is_first else key_of(found.shape_i[c], s, feature))
    found.key[c] = key


@kernel
def are_flush(shapes, x, b, f, s):
    """Whether shape s has a face in the plane of face f of shape b."""
    faces, centre = shapes.faces, centre_of(shapes, x, b)
    n = out_of_shape(shapes, x, b, (faces.normal[f, 0], faces.normal[f, 1], faces.normal[f, 2]))
    h = faces.height[f]
    u = in_shape(shapes, x, s, n)
    g = flattest(faces, s, u)
    on = to_shape(shapes, x, s, (centre[0] + h * n[0], centre[1] + h * n[1], centre[2] + h * n[2]))
    height = along(faces.normal, g, on) - faces.height[g]
    return angle_of(faces, g, u) <= ALIGNED and abs(height) <= FLUSH * size_of(shapes, s, b)


@kernel
def is_continued(shapes, motion, links, a, b, f, side):
    """Whether the plane of face f of b goes on in another shape, farther along m than the point of a contact."""
    p, m = side
    x, at = motion.x, first_other(shapes, motion, links, a, b)
    while at != NO_PAIR:
        s = other_shape(shapes, motion, links, at, a, b, False)
        at = links.following[at // 2, at % 2]
        if s != b and are_flush(shapes, x, b, f, s):
            if goes_beyond(shapes.faces, s, to_shape(shapes, x, s, p), in_shape(shapes, x, s, m), 0.0):
                return True
    return False


@kernel
def centre_of(shapes, x, s):
    """The origin of the axes of shape s in the world."""
    b, place, is_planar = shapes.body[s], shapes.place, x.shape[1] == 3
    r = in_world_of(x, b, (place[s, 0], place[s, 1], 0.0 if is_planar else place[s, 2]))
    return x[b, 0] + r[0], x[b, 1] + r[1], 0.0 if is_planar else x[b, 2] + r[2]


@kernel
def turn_to_face(shapes, x, found, c, a, b, f):
    """Let contact c be that of a corner of shape a, rounded by its radius, and face f of shape b; False where it is not
    over the face."""
    faces, radius, d = shapes.faces, shapes.radius[a], found.normal.shape[1]
    m, p = side_of(found, c, b)
    way = found.gap[c] + radius
    corner = (p[0] + way * m[0], p[1] + way * m[1], p[2] + way * m[2])
    r = to_shape(shapes, x, b, corner)
    height = along(faces.normal, f, r) - faces.height[f]
    foot = (
        r[0] - height * faces.normal[f, 0],
        r[1] - height * faces.normal[f, 1],
        r[2] - height * faces.normal[f, 2],
    )
    if not contains(faces, b, foot, FLUSH * size_of(shapes, a, b)):
        return False
    n = out_of_shape(shapes, x, b, (faces.normal[f, 0], faces.normal[f, 1], faces.normal[f, 2]))
    sign = 1.0 if b == found.shape_i[c] else -1.0
    found.gap[c] = height - radius
    for k in range(d):
        found.normal[c, k], found.point[c, k] = sign * n[k], corner[k] - 0.5 * (height + radius) * n[k]
    return True
