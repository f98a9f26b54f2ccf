"""Two faces seen along the normal n of a contact: where they lie over one another, corner by corner.

Both are seen as polygons in the plane across n, with heights along n. The incident one is clipped to the sides of the
reference, whose normal is nearer to n (Sutherland and Hodgman); each corner that is left has the difference of the two
heights as its gap. Corners are features of both: a vertex of the one or of the other, or a pair of edges, so that keys
do not change when two parallel faces take turns. Of two lines: where they cross, or the ends of the part that they have
in common.

The deepest point of a contact is one of these; others are what may touch within the step, though now farther apart.

Source: Sutherland and Hodgman, "Reentrant polygon clipping", CACM 17, 1974; manifolds: Ericson, *Real-Time Collision
Detection*, section 5.5.
"""

from __future__ import annotations

import math

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.scenes.detection import same_place
from nonsmooth.scenes.shape_rows import CYLINDER
from nonsmooth.scenes.spatial.core import EDGES, TWO_EDGES, VERTEX_OF_J, note, note_place
from nonsmooth.scenes.spatial.face_manifold import copy_corner

REFERENCE_SIDE = 1024  # code: sides from here on are sides of the reference polygon
# chosen: sine of two lines that lie side by side: at the ends of the common part they are as much aside, of its length,
# and round sides are lower there by the square of it
SIDE_BY_SIDE = 1e-4
# chosen: of its length, how far another border may be aside and still lie on it: of two sharp ones, whose gap is not
# known better; of a round one, whose gap is, as of two lines
BORDER, ROUND_BORDER = 1e-6, SIDE_BY_SIDE
FLAT_ON = 1.0 - 1e-12  # chosen: cosine of a face and the normal from which its corners are all that touches
ONE_POINT = 100.0  # chosen: of what two points have no direction below: nearer ones are one
STEEPEST = 1e-9  # chosen: cosine to the normal below which a face has no heights


@rare_kernel
def overlay(shapes, scratch, pair, triad, corners, limit, n):
    """Note where the faces of a pair, of so many corners each, lie over one another with gaps below the limit, behind
    the first n points; the new n."""
    n_i, n_j = corners
    slack = same_place(shapes, pair[0], pair[1])
    if n_i == 1 or n_j == 1:
        return n
    if n_i == 2 and n_j == 2:
        return two_lines(shapes, scratch, pair, triad, limit, n)
    slope_i, slope_j = plane_of(scratch.face_i, n_i), plane_of(scratch.face_j, n_j)
    is_first = n_j == 2 or (n_i > 2 and abs(slope_i[2]) >= abs(slope_j[2]))  # the reference is i
    slope = slope_i if is_first else slope_j
    if abs(slope[2]) <= STEEPEST:
        return n
    if max(abs(slope_i[2]), abs(slope_j[2])) < FLAT_ON:
        n = two_borders(shapes, scratch, pair, triad, corners, limit, n)
    ref, n_ref, inc = (scratch.face_i, n_i, scratch.face_j) if is_first else (scratch.face_j, n_j, scratch.face_i)
    if min(n_i, n_j) == 2 and shapes.kind[pair[0 if is_first else 1]] == CYLINDER:
        m = line_on_rim(scratch, ref, inc, is_first)
        return note_corners_along(shapes, scratch, pair, triad, (is_first, slope), limit, m, n)
    m = clip(scratch, n_i, n_j, is_first, slope[2], 0.0)
    if n == 0 and (m == 0 or is_on_a_side(scratch, ref, n_ref, m, 2.0 * slack)):  # that only meet at their borders
        m = clip(scratch, n_i, n_j, is_first, slope[2], slack)
    return note_corners_along(shapes, scratch, pair, triad, (is_first, slope), limit, m, n)


@rare_kernel
def two_borders(shapes, scratch, pair, triad, corners, limit, n):
    """Note the ends of what two parallel borders have in common, of faces that both fall off from there; the new n."""
    n_i, n_j = corners
    a, b = border_side(scratch.face_i.corner, n_i, 1.0), border_side(scratch.face_j.corner, n_j, -1.0)
    sides = ((a, a + 1 if a + 1 < n_i else 0), (b, b + 1 if b + 1 < n_j else 0))
    return side_by_side(shapes, scratch, pair, triad, sides, ROUND_BORDER if min(n_i, n_j) == 2 else BORDER, limit, n)


@kernel
def border_side(corner, m, sign):
    """The side of a polygon that is highest, sign times; by the corner where it begins."""
    best, most = 0, -math.inf
    for k in range(1 if m == 2 else m):
        height = sign * (corner[k, 2] + corner[k + 1 if k + 1 < m else 0, 2])
        if height > most:
            best, most = k, height
    return best


@kernel
def plane_of(polygon, m):
    """The unit normal of a polygon (Newell), or zeros of a line."""
    x, y, z = 0.0, 0.0, 0.0
    corner = polygon.corner
    for k in range(1, m - 1):
        a, b, c = corner[k, 0] - corner[0, 0], corner[k, 1] - corner[0, 1], corner[k, 2] - corner[0, 2]
        d = corner[k + 1, 0] - corner[0, 0]
        e = corner[k + 1, 1] - corner[0, 1]
        f = corner[k + 1, 2] - corner[0, 2]
        x, y, z = x + b * f - c * e, y + c * d - a * f, z + a * e - b * d
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0.0:
        return 0.0, 0.0, 0.0
    return x / length, y / length, z / length


@rare_kernel
def clip(scratch, n_i, n_j, is_first, sense, slack):
    """Clip the incident face to the sides of the reference, which is i if is_first, each wider by a slack, to
    ``scratch.polygon``; how many corners. The reference is counterclockwise about the normal where ``sense`` > 0."""
    ref, inc = (scratch.face_i, scratch.face_j) if is_first else (scratch.face_j, scratch.face_i)
    n_ref, n_inc = (n_i, n_j) if is_first else (n_j, n_i)
    for k in range(n_inc):
        copy_corner(inc, k, scratch.polygon, k)
        scratch.polygon.feature[k] += VERTEX_OF_J if is_first else 0
    m = n_inc
    for side in range(n_ref):
        m = clip_to_side(scratch, ref, n_ref, side, m, n_inc == 2, is_first, (sense, slack))
    return m


@rare_kernel
def line_on_rim(scratch, ref, inc, is_first):
    """Clip a line to the circle of an end, seen as an ellipse about c with the half axes p and q of two points of its
    rim, to ``scratch.polygon``: |a_0 + t a| = 1 in the coordinates along these; how many corners."""
    rim, polygon = ref.corner, scratch.polygon
    p_u, p_v = 0.5 * (rim[0, 0] - rim[4, 0]), 0.5 * (rim[0, 1] - rim[4, 1])
    q_u, q_v = 0.5 * (rim[2, 0] - rim[6, 0]), 0.5 * (rim[2, 1] - rim[6, 1])
    u, v, way_u, way_v = line(inc.corner, (0, 1))
    u, v = u - 0.5 * (rim[0, 0] + rim[4, 0]), v - 0.5 * (rim[0, 1] + rim[4, 1])
    area = p_u * q_v - p_v * q_u
    a_0, b_0 = (u * q_v - v * q_u) / area, (p_u * v - p_v * u) / area
    a, b = (way_u * q_v - way_v * q_u) / area, (p_u * way_v - p_v * way_u) / area
    along, across, long_2 = a_0 * a + b_0 * b, a_0 * b - b_0 * a, a * a + b * b
    if across * across >= long_2:
        return 0
    half = math.sqrt(long_2 - across * across)
    enter, leave = max((-along - half) / long_2, 0.0), min((-along + half) / long_2, 1.0)
    if enter > leave:
        return 0
    for k in range(2):
        x, y, z = part_of(inc.corner, (0, 1), enter if k == 0 else leave)
        polygon.corner[k, 0], polygon.corner[k, 1], polygon.corner[k, 2] = x, y, z
        if (enter if k == 0 else 1.0 - leave) == 0.0:
            polygon.feature[k] = inc.feature[k] + (VERTEX_OF_J if is_first else 0)
        else:
            polygon.feature[k] = cut_feature(ref, 2, k, inc.side[0], is_first)
    return 2


@kernel
def is_on_a_side(scratch, ref, n_ref, m, within):
    """Whether all corners of what is left are on one side of the reference: which of them is then by rounding."""
    corner = scratch.polygon.corner
    for side in range(n_ref):
        x, y, a, b = line(ref.corner, (side, side + 1 if side + 1 < n_ref else 0))
        farthest = 0.0
        for k in range(m):
            farthest = max(farthest, abs(b * (corner[k, 0] - x) - a * (corner[k, 1] - y)))
        if farthest <= within * math.sqrt(a * a + b * b):
            return True
    return False


@rare_kernel
def note_corners_along(shapes, scratch, pair, triad, reference, limit, m, n):
    """Note the m corners of what is left, with the heights of the plane of the reference below them, which is i or not
    and has this normal; the new n."""
    is_first, slope = reference
    ref, corner = scratch.face_i if is_first else scratch.face_j, scratch.polygon.corner
    for k in range(m):
        u, v, h = corner[k, 0], corner[k, 1], corner[k, 2]
        under = ref.corner[0, 2] - ((u - ref.corner[0, 0]) * slope[0] + (v - ref.corner[0, 1]) * slope[1]) / slope[2]
        spot = (u, v, under, h) if is_first else (u, v, h, under)
        n = note_corner(shapes, scratch, pair, triad, spot, scratch.polygon.feature[k], limit, n)
    return n


@rare_kernel
def clip_to_side(scratch, ref, n_ref, side, n, is_open, is_first, within):
    """Clip the polygon of n corners to one side of the reference, of this sense and wider by a slack; the new n."""
    sense, slack = within
    polygon, clipped, m = scratch.polygon, scratch.clipped, 0
    following = side + 1 if side + 1 < n_ref else 0
    x, y = ref.corner[side, 0], ref.corner[side, 1]
    a, b = ref.corner[following, 0] - x, ref.corner[following, 1] - y
    length = math.copysign(math.sqrt(a * a + b * b), sense)
    if length == 0.0:
        return n
    a, b = a / length, b / length
    for k in range(n):
        ahead = k + 1 if k + 1 < n else 0
        d = b * (polygon.corner[k, 0] - x) - a * (polygon.corner[k, 1] - y) - slack
        d_next = b * (polygon.corner[ahead, 0] - x) - a * (polygon.corner[ahead, 1] - y) - slack
        if d <= 0.0:
            copy_corner(polygon, k, clipped, m)
            m += 1
        if (d <= 0.0) != (d_next <= 0.0) and not (is_open and ahead == 0):
            part = d / (d - d_next)
            for c in range(3):
                clipped.corner[m, c] = polygon.corner[k, c] + part * (polygon.corner[ahead, c] - polygon.corner[k, c])
            clipped.feature[m] = cut_feature(ref, n_ref, side, polygon.side[k], is_first)
            clipped.side[m] = polygon.side[k] if d > 0.0 else REFERENCE_SIDE + side
            m += 1
    for k in range(m):
        copy_corner(clipped, k, polygon, k)
    return m


@kernel
def cut_feature(ref, n_ref, side, cut, is_first):
    """Where a side of the reference face cuts an edge of the incident one: the two edges. Where it cuts another side:
    the vertex of the reference face."""
    if cut < REFERENCE_SIDE:
        own = ref.side[side]
        return TWO_EDGES + (EDGES * own + cut if is_first else EDGES * cut + own)
    other = cut - REFERENCE_SIDE
    at = side if other == (side - 1 if side > 0 else n_ref - 1) else other
    return ref.feature[at] + (0 if is_first else VERTEX_OF_J)


@rare_kernel
def note_corner(shapes, scratch, pair, triad, spot, feature, limit, n):
    """Note a point at a place (u, v) across the normal, between the heights of the cores there, if its gap is below the
    limit and it is none of those noted; the new n."""
    i, j = pair
    u, v, below, above = spot
    r_i, r_j = shapes.radius[i], shapes.radius[j]
    gap = above - below - r_i - r_j
    if gap >= limit:
        return n
    e, f, normal = triad
    note(scratch.manifold, n, gap, normal[0], normal[1], normal[2], feature)
    x, y, z = u * e[0] + v * f[0], u * e[1] + v * f[1], u * e[2] + v * f[2]
    note_place(scratch, n, i, x, y, z, 0.5 * (below + r_i + above - r_j))
    return n if is_noted(scratch.manifold, n, ONE_POINT * same_place(shapes, i, j)) else n + 1


@kernel
def is_noted(manifold, n, near):
    """Whether point n is one of those before: of the same features, or at the same place."""
    for k in range(n):
        if manifold.feature[k] == manifold.feature[n] or apart(manifold, k, n) <= near:
            return True
    return False


@kernel
def apart(manifold, k, m):
    """The distance of two points."""
    x, y = manifold.point[m, 0] - manifold.point[k, 0], manifold.point[m, 1] - manifold.point[k, 1]
    z = manifold.point[m, 2] - manifold.point[k, 2]
    return math.sqrt(x * x + y * y + z * z)


@rare_kernel
def two_lines(shapes, scratch, pair, triad, limit, n):
    """Note where two lines cross, or the ends of what they have in common; the new n."""
    a, b = line(scratch.face_i.corner, (0, 1)), line(scratch.face_j.corner, (0, 1))
    w_u, w_v = b[0] - a[0], b[1] - a[1]
    sine = a[2] * b[3] - a[3] * b[2]
    if sine * sine <= SIDE_BY_SIDE * SIDE_BY_SIDE * square(a) * square(b):
        return side_by_side(shapes, scratch, pair, triad, ((0, 1), (0, 1)), math.inf, limit, n)
    t, s = (w_u * b[3] - w_v * b[2]) / sine, (w_u * a[3] - w_v * a[2]) / sine
    if 0.0 <= t <= 1.0 and 0.0 <= s <= 1.0:
        feature = TWO_EDGES + EDGES * scratch.face_i.side[0] + scratch.face_j.side[0]
        n = between_lines(shapes, scratch, pair, triad, ((0, 1), (0, 1)), (t, s, feature), limit, n)
    return n


@kernel
def line(corner, side):
    """Where a side begins across the normal, and its way there."""
    k, m = side
    return corner[k, 0], corner[k, 1], corner[m, 0] - corner[k, 0], corner[m, 1] - corner[k, 1]


@kernel
def square(a):
    """Of the length of a line."""
    return a[2] * a[2] + a[3] * a[3]


@rare_kernel
def side_by_side(shapes, scratch, pair, triad, sides, aside, limit, n):
    """Note the ends of what two lines have in common where these are no farther aside than so much of their length;
    the new n."""
    a, b = line(scratch.face_i.corner, sides[0]), line(scratch.face_j.corner, sides[1])
    w_u, w_v = b[0] - a[0], b[1] - a[1]
    square_a, square_b = square(a), square(b)
    if square_a == 0.0 or square_b == 0.0:
        return n
    first, last = a[2] * w_v - a[3] * w_u, a[2] * (w_v + b[3]) - a[3] * (w_u + b[2])
    if max(abs(first), abs(last)) > aside * square_a:
        return n
    for end in range(2):
        s = (a[2] * (w_u + end * b[2]) + a[3] * (w_v + end * b[3])) / square_a
        if 0.0 <= s <= 1.0:
            feature = VERTEX_OF_J + scratch.face_j.feature[sides[1][end]]
            n = between_lines(shapes, scratch, pair, triad, sides, (s, float(end), feature), limit, n)
        t = (b[2] * (end * a[2] - w_u) + b[3] * (end * a[3] - w_v)) / square_b
        if 0.0 < t < 1.0:
            feature = scratch.face_i.feature[sides[0][end]]
            n = between_lines(shapes, scratch, pair, triad, sides, (float(end), t, feature), limit, n)
    return n


@rare_kernel
def between_lines(shapes, scratch, pair, triad, sides, spot, limit, n):
    """Note the point between these parts of two lines; the new n."""
    t, s, feature = spot
    a_u, a_v, below = part_of(scratch.face_i.corner, sides[0], t)
    b_u, b_v, above = part_of(scratch.face_j.corner, sides[1], s)
    u, v = b_u - a_u, b_v - a_v
    if above > below and shapes.radius[pair[0]] + shapes.radius[pair[1]] > 0.0:  # rounded lines that are a little aside
        above = below + math.sqrt((above - below) * (above - below) + u * u + v * v)
    u, v = 0.5 * (a_u + b_u), 0.5 * (a_v + b_v)
    return note_corner(shapes, scratch, pair, triad, (u, v, below, above), feature, limit, n)


@kernel
def part_of(corner, side, t):
    """The point at this part of a side."""
    k, m = side
    return (
        corner[k, 0] + t * (corner[m, 0] - corner[k, 0]),
        corner[k, 1] + t * (corner[m, 1] - corner[k, 1]),
        corner[k, 2] + t * (corner[m, 2] - corner[k, 2]),
    )
