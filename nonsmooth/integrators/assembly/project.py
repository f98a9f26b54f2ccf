"""Places after a solved step: bodies move, and what penetrates is pushed apart by a motion that is not a velocity.

    x_1 = x_0 + dt ((2 - 2 theta) v_mid + (2 theta - 1) v_1),    v_mid = v_mid_free + (v_1 - v_free)/2

v_mid is the mean of v_0 and v_1, but for free rotation, where it is that of the mid-point rule. In an island where a
contact closes, theta is 1: with less, the velocity before the impact would drive the bodies into one another. Motion
without impacts is of second order, across impacts of first.

Penetration: dt J_N w >= -share g_N, w the least motion in the mass metric, by a few sweeps of projected Gauss-Seidel;
gaps that are held (held_closed.py) are drawn together by as much, where the others let them. Islands with joints have
their motion from draw_together.py.
Equations: docs/theory/scenes.md, (2).
"""

from __future__ import annotations

from math import sqrt
from typing import Annotated as Array

from nonsmooth.contact.network.joint import JOINT_LIMIT, acts, is_joint, may_land
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.network.rest import is_at_rest
from nonsmooth.contact.network.solve import EXACT_BODIES, ROUNDED_OF_MANY, bodies_of
from nonsmooth.integrators.assembly.beside import note_beside
from nonsmooth.integrators.assembly.bodies import Bodies, fall_of
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.integrators.assembly.guided import change_of_guides, has_guide, turn_of_guides
from nonsmooth.integrators.assembly.held_closed import is_held
from nonsmooth.integrators.assembly.of_body import move_body
from nonsmooth.integrators.assembly.spatial import move_freely
from nonsmooth.jit import in_dimensions, kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.numerics.rounding import EPS, rounded_sum
from nonsmooth.scenes.detection import Found, contact_of, is_rolling

SHARE = 0.2  # chosen: of a penetration that a step takes back: more throws bodies about that sweeps have not settled
SWEEPS = 10  # measured: of a falling heap of 1000 discs: 20 leave the same penetration
# measured: of a large island at rest: 150 boxes then settle in 50 steps, with 10 sweeps in 300
SWEEPS_AT_REST = 100
# measured: times what would close a held gap alone, that it may be pulled by: without a bound, or with 10 times the
# compliance instead, heaps of 150 and 400 boxes do not settle
MOST_PULL = 10.0
# chosen: a velocity of approach below this part of what gravity gives in a step is none: 1e-6 g dt^2 is 4e-11 m at 2 ms
STILL = 1e-6
# chosen: of the same: what was pressed over a gap of at most that part of g dt^2 approaches by what solvers leave, and
# of few bodies what is closed. Measured: where that is so of all bodies, 6 of 24 heaps of 400 boxes rest for 10
NO_FALL = 1e-2
# measured: bodies of an island from which it is a heap: such come to rest by what their contacts lose as they wander,
# and of nine heaps of 400 boxes four did not where they lost nothing
HEAP = 10
# chosen: of all impulses of an island: less is what its solver leaves at a gap, one of that part of g dt^2 and more
NO_IMPULSE, GAP_SEEN = 1e-11, 0.1
EXACT_VELOCITY = 1e-12  # chosen: of a velocity made from terms of such a size: a few thousand roundings


# measured: of a velocity, by what Newton's method leaves of it: 1e-13 of the sum that it is made of; rest is rest
VELOCITY_ROUNDINGS_LEFT = 8192


OF_TURNING = 2.0  # chosen: of what bodies turn their velocities by in a step: held limits may be approached by it
IS_HELD_NEXT, LANDS = 1, 2  # code: of an island; the first is what rows alone make that turn (wandering.py)


class Moves(Block):
    """Where bodies move to."""

    size: Array[Floats, "n_b", "n"]  # sum of the sizes of what a velocity is made of

    lands: Array[Ints, "n_b"]  # whether an island has an impact in this step: LANDS, or IS_HELD_NEXT
    deep: Array[Ints, "n_b"]  # whether bodies of an island are pushed apart in it
    push: Array[Floats, "n_b", "n"]  # by which penetrations are taken back [m/s]
    la: Array[Floats, "m"]  # and what it takes


@kernel
def normal_velocity(network, c, v, n):
    """J_N v of contact c, and the sum of the sizes of its terms."""
    i, j = network.i[c], network.j[c]
    total, size = 0.0, 0.0
    for x in range(n):
        a, b = network.J_i[c, 0, x] * v[i, x], network.J_j[c, 0, x] * v[j, x]
        total += a + b
        size += abs(a) + abs(b)
    return total, size


@kernel
def turn_of_limit(network, c):
    """What the row of a limit of a joint turns by in half of the step; 0 of contacts."""
    return network.turn[c, 0] if network.sprung[c] == JOINT_LIMIT else 0.0


@kernel
def island_of(network, c):
    """The island of contact c, of whose bodies one may be none of it."""
    return max(network.islands.of[network.i[c]], network.islands.of[network.j[c]])


@kernel
def is_of_few(network, c):
    """Whether the island of contact c has less than HEAP bodies."""
    k = island_of(network, c)
    return k >= 0 and bodies_of(network, k) < HEAP


@kernel
def leave_out_rounding(found, network, c, d, n, fall):
    """The impulse of a contact that is open, as interior points leave it, becomes 0: it lands and holds nothing."""
    P = network.P[c, 0]
    if P > 0.0 and found.gap[c] > 0.0 and network.soft[c] == 0.0 and is_of_few(network, c):
        speed, _ = normal_velocity(network, c, network.v, n)
        of_all = NO_IMPULSE * sqrt(network.islands.P[island_of(network, c)])
        is_open = network.b[c, 0] - network.turn[c, 0] > fall
        if P <= EPS * network.rho[c] * (network.b[c, 0] + speed) or (is_open and P <= of_all):
            for row in range(d):
                network.P[c, row] = 0.0


@kernel
def rest(found, network, d, n, moves, fall):
    """Velocities that are roundings of the sums they are made of become 0: a block that sticks does not creep.

    In an island of many bodies so do those that its residual leaves, which is relative to all impulses together.
    """
    v, size = network.v, moves.size
    for b in range(v.shape[0]):
        for x in range(n):
            size[b, x] = abs(network.v_free[b, x])
    for c in range(network.n_c):
        leave_out_rounding(found, network, c, d, n, fall)
        if acts(network, c):
            for row in range(d):
                P = abs(network.P[c, row])
                for x in range(n):
                    size[network.i[c], x] += abs(network.Y_i[c, row, x]) * P
                    size[network.j[c], x] += abs(network.Y_j[c, row, x]) * P
        if is_rolling(found.key[c]):
            add_pressure(network, contact_of(found.key[c]), n, size)
    islands, M_inv = network.islands, network.M_inv
    for b in range(v.shape[0]):
        k = islands.of[b]
        left = 0.0
        if k >= 0 and bodies_of(network, k) > EXACT_BODIES:
            left = ROUNDED_OF_MANY * sqrt(islands.P[k])
        for x in range(n):
            of_all = left * sqrt(M_inv[b, x, x] * M_inv[b, 0, 0])
            if abs(v[b, x]) <= max(of_all, rounded_sum(VELOCITY_ROUNDINGS_LEFT, size[b, x])):
                v[b, x] = 0.0


@kernel
def add_pressure(network, c, n, size):
    """Add what the bodies of contact c gain by its normal impulse along each of their velocities, whatever its normal:
    rolling friction is solved to a part of that, and leaves nothing else of what it stops."""
    for b in (network.i[c], network.j[c]):
        for x in range(n):
            size[b, x] += sqrt(network.M_inv[b, x, x] * network.M_inv[b, 0, 0]) * network.P[c, 0]


@kernel
def turning_of(bodies, network, c):
    """The sizes of the spins of both bodies times those of their velocities, of the beginning of the step [m/s^2]."""
    spin, speed, d = 0.0, 0.0, bodies.gravity.shape[0]
    for b in (network.i[c], network.j[c]):
        for x in range(network.v.shape[1]):
            if x < d:
                speed += abs(bodies.v_0[b, x])
            else:
                spin += abs(bodies.v_0[b, x])
    return spin * speed


@kernel
def find_landings(bodies, found, contacts, network, dt, n, moves):
    """Mark islands in which a contact closes, or would be driven in by the mean of the velocities."""
    fall, islands = fall_of(bodies, dt), network.islands
    still = STILL * fall
    for k in range(islands.count):
        moves.lands[k] = 0
    for k in range(islands.count):
        for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
            c = islands.contacts[at]
            if not may_land(network, c):
                continue
            before, size = normal_velocity(network, c, bodies.v_0, n)
            after, _ = normal_velocity(network, c, network.v, n)
            is_pressed = network.P[c, 0] > 0.0 and network.b[c, 0] + after <= NO_FALL * fall
            limit = still + EXACT_VELOCITY * size
            at = contacts.held[c]
            is_closed = at >= 0 and contacts.closing_before[at] <= NO_FALL * fall
            if network.soft[c] == 0.0 and (is_closed or (found.gap[c] <= 0.0 and is_of_few(network, c))):
                limit += NO_FALL * fall
            if contacts.wander[c] != 0.0:
                before, after = before - contacts.wander[c], after + contacts.wander[c]
                limit += contacts.slack[c]
            elif network.sprung[c] == JOINT_LIMIT:
                before, after = before - turn_of_limit(network, c), after + turn_of_limit(network, c)
                limit += OF_TURNING * dt * turning_of(bodies, network, c)
            elif has_guide(bodies, network, c):
                before += turn_of_guides(bodies, network, c, 0, 0.0)
                after += turn_of_guides(bodies, network, c, 0, dt)
                limit += change_of_guides(bodies, network, c, bodies.gravity.shape[0])
            gap = max(found.gap[c], 0.0)
            if (is_pressed and before < -limit) or gap + 0.5 * dt * (before + after) < -dt * limit:
                is_turn = contacts.slack[c] > 0.0 and contacts.wander[c] == 0.0
                is_none = is_turn and before >= -limit - contacts.slack[c]
                moves.lands[k] = max(moves.lands[k], IS_HELD_NEXT if is_none else LANDS)
                if moves.lands[k] == LANDS:
                    break


@kernel
def find_move(bodies, network, theta, n, moves):
    """v_move of every body."""
    for b in range(bodies.mass.shape[0]):
        k = network.islands.of[b]
        weight = 2.0 if k >= 0 and moves.lands[k] > 0 else 2.0 * theta
        if bodies.motion.moves[b] == 0:
            weight = 1.0  # by v_mid, whatever theta is
        for x in range(n):
            mean = bodies.v_mid[b, x] + 0.5 * (network.v[b, x] - bodies.v_free[b, x])
            bodies.v_move[b, x] = (2.0 - weight) * mean + (weight - 1.0) * network.v[b, x]


@kernel
def mark_kept(bodies, network, moves):
    """Mark the bodies that are pressed or joined, in islands without an impact."""
    for b in range(bodies.mass.shape[0]):
        if bodies.motion.moves[b] == 0 or bodies.motion.still[b] == 0:
            bodies.keeps[b] = 0
    for c in range(network.n_c):
        if acts(network, c):
            for b in (network.i[c], network.j[c]):
                k = network.islands.of[b]
                if k >= 0 and moves.lands[k] != LANDS:
                    bodies.keeps[b] = 1


@kernel
def put_back(bodies):
    """Put the bodies back where they were at the beginning of the step."""
    x, x_0 = bodies.motion.x, bodies.x_0
    for b in range(x.shape[0]):
        for k in range(x.shape[1]):
            x[b, k] = x_0[b, k]


@kernel
def has_joints(network, k):
    """Whether island k has a joint: they stand behind its contacts."""
    return is_joint(network, network.islands.contacts[network.islands.contact_start[k + 1] - 1])


@kernel
def find_deep(found, network, tight, moves):
    """Mark the islands in which bodies are deeper in one another than roundings are; whether there is one."""
    islands, is_any = network.islands, False
    for k in range(islands.count):
        if has_joints(network, k):
            is_any = is_any or moves.deep[k] == 1
            continue
        moves.deep[k] = 0
        for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
            c = islands.contacts[at]
            if found.gap[c] < -tight or (found.gap[c] > tight and is_held(found, network, c)):
                moves.deep[k] = 1
                is_any = True
    return is_any


@kernel
def find_push(found, network, dt, n, moves):
    """The push of every body: that of the bodies of deep islands, island by island."""
    islands, push = network.islands, moves.push
    for b in range(push.shape[0]):
        if islands.of[b] < 0 or not has_joints(network, islands.of[b]):
            for x in range(n):
                push[b, x] = 0.0
    for k in range(islands.count):
        if moves.deep[k] == 1 and not has_joints(network, k):
            push_island(found, network, k, dt, n, moves)


@kernel
def push_island(found, network, k, dt, n, moves):
    """The push of island k, by projected Gauss-Seidel on the normals of closed contacts, and of those that are held."""
    islands, push = network.islands, moves.push
    begin, end = islands.contact_start[k], islands.contact_start[k + 1]
    for at in range(begin, end):
        moves.la[islands.contacts[at]] = 0.0
    is_large = bodies_of(network, k) > EXACT_BODIES
    for _ in range(SWEEPS_AT_REST if is_large and is_at_rest(network, k, n) else SWEEPS):
        for at in range(begin, end):
            c = islands.contacts[at]
            is_pulled = is_held(found, network, c)
            if found.gap[c] >= 0.0 and not is_pulled:
                continue
            i, j = network.i[c], network.j[c]
            speed, _ = normal_velocity(network, c, push, n)
            wanted = speed + SHARE * found.gap[c] / dt
            least = -MOST_PULL * SHARE * found.gap[c] / (dt * network.W[c, 0, 0]) if is_pulled else 0.0
            la = max(least, moves.la[c] - wanted / network.W[c, 0, 0])
            change = la - moves.la[c]
            moves.la[c] = la
            if change != 0.0:
                for x in range(n):
                    push[i, x] += network.Y_i[c, 0, x] * change
                    push[j, x] += network.Y_j[c, 0, x] * change


@in_dimensions("int64(int64, int64, int64, int64, int64, float64, float64, float64)")
def move_bodies(bodies_at, found_at, contacts_at, network_at, moves_at, dt, theta, tight, d):
    """Move bodies, and push apart those that are deep in one another; whether some are."""
    bodies, found, contacts = view(bodies_at, Bodies), view(found_at, Found), view(contacts_at, Contacts)
    network, moves, n = view(network_at, Network), view(moves_at, Moves), 3 * (d - 1)
    rest(found, network, d, n, moves, GAP_SEEN * fall_of(bodies, dt))
    find_landings(bodies, found, contacts, network, dt, n, moves)
    find_move(bodies, network, theta, n, moves)
    put_back(bodies)
    is_pushed = find_deep(found, network, tight, moves)
    if is_pushed:
        find_push(found, network, dt, n, moves)
    for b in range(bodies.mass.shape[0]):
        if d == 3 and bodies.motion.moves[b] == 1 and bodies.motion.still[b] == 0:
            k = network.islands.of[b]
            move_freely(bodies, b, network.v, dt, k >= 0 and moves.lands[k] > 0)
        else:
            move_body(bodies, b, dt, bodies.v_move, d)
        if is_pushed:
            move_body(bodies, b, dt, moves.push, d)
    mark_kept(bodies, network, moves)
    note_beside(bodies, network, d)
    return 1 if is_pushed else 0
