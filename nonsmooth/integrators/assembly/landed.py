"""Where a contact that landed is, and its normal, after its bodies have moved on.

The point goes with the body whose feature it is: with a ball, whatever it lies on; with what lies on a half-space or a
half-plane; else half with the one and half with the other. A rounded core keeps its normal as it rolls, so it is the
core's point o = p - (r + g/2) n that goes with the body, p half way between the surfaces, g apart:

    o' = o + delta + theta x (o - x),    p' = o' + (r + g/2) n

with delta and theta what the body moves and turns. Of two balls the new normal is the direction of their centres. So an
impulse without friction passes through the centre of a ball, however it spins and slides.

Of a body that lands on one that impulses do not move the point is on its own surface: midway in the gap the arm of a
ball would be R + g/2, and its spin off by as much. Between two bodies that move it is midway, for the sake of their
momenta.
"""

from __future__ import annotations

from math import sqrt

from nonsmooth.jit import kernel
from nonsmooth.scenes.shape_rows import HALF_PLANE, HALF_SPACE, HULL, SPHERE

NEXT_TO_NONE = 2e-8  # chosen: of an arm: in a gap of less what rests has no other arm with each rounding


@kernel
def is_ball(shapes, s, d):
    """Whether a shape is a disc or a sphere."""
    return shapes.kind[s] == SPHERE if d == 3 else shapes.kind[s] == HULL and shapes.count[s] == 1


@kernel
def is_flat(shapes, s, d):
    """Whether a shape is a half-plane or a half-space."""
    return shapes.kind[s] == (HALF_SPACE if d == 3 else HALF_PLANE)


@kernel
def share_of_first(shapes, i, j, d):
    """How much of the way of a contact is that of its first shape."""
    if is_ball(shapes, i, d) != is_ball(shapes, j, d):
        return 1.0 if is_ball(shapes, i, d) else 0.0
    if is_flat(shapes, i, d) or is_flat(shapes, j, d):
        return 1.0 if is_flat(shapes, j, d) else 0.0
    return 0.5


@kernel
def parts_of_gap(bodies, found, network, c, gap):
    """How far the point of contact c, as it is found or with ``reach_to_touch``, is from the surfaces of its sides."""
    i, j, moves, arm = network.i[c], network.j[c], bodies.motion.moves, 0.0
    b = i if moves[i] == 1 else j
    for k in range(found.point.shape[1]):
        arm += abs(found.point[c, k] - bodies.x_0[b, k] - bodies.shift[b, k])
    if gap <= NEXT_TO_NONE * arm or moves[i] == moves[j]:
        return 0.5 * gap, 0.5 * gap
    return (0.0, gap) if moves[i] == 1 else (gap, 0.0)


@kernel
def reach_to_touch(bodies, found, network, c):
    """Put the point of an open contact with a body that impulses do not move on the surface of the other one."""
    of_i, of_j = parts_of_gap(bodies, found, network, c, found.gap[c])
    for k in range(found.point.shape[1]):
        found.point[c, k] += 0.5 * (of_i - of_j) * found.normal[c, k]


@kernel
def way(bodies, b, x, dt):
    """Component x of what body b moves and turns, from where its contacts were looked for to the end of the step."""
    return dt * bodies.v_move[b, x] - bodies.shift[b, x]


@kernel
def gap_where_found(bodies, found, network, c, n):
    """The gap of contact c at the places where it was looked for; ``found`` has that of the beginning of the step."""
    i, j, gap = network.i[c], network.j[c], found.gap[c]
    for x in range(n):
        gap += network.J_i[c, 0, x] * bodies.shift[i, x] + network.J_j[c, 0, x] * bodies.shift[j, x]
    return gap


@kernel
def core_way(bodies, network, c, row, of_first, r, dt, d):
    """What the core of a side of contact c, r n beside its point, moves along an axis of its frame (n, t, s)."""
    b, J, sign = network.j[c], network.J_j, 1.0
    if of_first:
        b, J, sign = network.i[c], network.J_i, -1.0
    total = 0.0
    for x in range(3 * (d - 1)):
        total += sign * J[c, row, x] * way(bodies, b, x, dt)
    if row > 0 and d == 2:
        total += r * way(bodies, b, 2, dt)
    elif row > 0:  # t.(theta x n) = theta.s, s.(theta x n) = -theta.t
        other, turn = 2 if row == 1 else 1, 1.0 if row == 1 else -1.0
        for x in range(3):
            total += r * turn * network.J_j[c, other, x] * way(bodies, b, 3 + x, dt)
    return total


@kernel
def go_on(bodies, shapes, found, network, c, dt, d):
    """Move the point of contact c to where it is after the step; of two balls turn its normal."""
    i, j = found.shape_i[c], found.shape_j[c]
    of_i, of_j = parts_of_gap(bodies, found, network, c, gap_where_found(bodies, found, network, c, 3 * (d - 1)))
    r_i, r_j, share = shapes.radius[i] + of_i, shapes.radius[j] + of_j, share_of_first(shapes, i, j, d)
    are_balls, square = is_ball(shapes, i, d) and is_ball(shapes, j, d), 0.0
    for k in range(d):  # the first columns of a frame's rows are its axes
        first, second = 0.0, 0.0
        for row in range(d):
            first += network.J_j[c, row, k] * core_way(bodies, network, c, row, True, -r_i, dt, d)
            second += network.J_j[c, row, k] * core_way(bodies, network, c, row, False, r_j, dt, d)
        found.point[c, k] += share * first + (1.0 - share) * second
        if are_balls:
            found.normal[c, k] = second - first + (r_i + r_j) * network.J_j[c, 0, k]
            square += found.normal[c, k] * found.normal[c, k]
    for k in range(d):
        if are_balls and square > 0.0:
            found.normal[c, k] /= sqrt(square)
            found.point[c, k] += 0.5 * (r_i - r_j) * (found.normal[c, k] - network.J_j[c, 0, k])
