"""The contacts of a step: from what was found between shapes to the rows of a contact problem, and from step to step.

    open    g_N > 0    gamma_N + g_N / dt >= 0: it may close within the step, and no further
    closed  g_N <= 0   gamma_N >= 0: what it penetrates is taken back by places, not by velocities (project.py)

Gaps fed back to the velocities of closed contacts, with impulses kept from step to step and a problem solved to a
part only, are an unstable loop: a part a of the error solved in a step, and the mode grows for every a < 1 (beta 1:
by 1.154 a step at a = 0.1). Without that feedback it decays as sqrt(1 - a).

The impulses of the step before are the start of the next solution, kept in the axes of the world, and, for contacts
whose normal has not turned, along their own: what rests has the same bits for ever. A contact goes on with that of its
key; what is left of a pair of shapes goes on with the nearest one, since roundings may turn a vertex that lies on an
edge into a crossing of edges: a stack whose boxes are alike would otherwise begin anew every other step.
Equations: docs/theory/scenes.md, (1).
"""

from __future__ import annotations

from math import inf
from typing import Annotated as Array

from nonsmooth.contact.network.joint import acts
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.guided import ask_of_guides
from nonsmooth.integrators.assembly.landed import is_ball, reach_to_touch
from nonsmooth.integrators.assembly.of_body import write_rows
from nonsmooth.jit import in_dimensions, kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.numerics.rounding import rounded_sum
from nonsmooth.scenes.detection import FEATURE_BITS, FIRST_ROLLING, LAST_FEATURE, NO_SHAPE, SHAPE_BITS, Found
from nonsmooth.scenes.shape_rows import Shapes

SAME_NORMAL = 1e-5  # chosen: of two normals that are one, as of faces that are flush (hidden.py)
ROLLED_NORMAL = 0.1  # chosen: [rad] of a ball that goes over an edge from one shape to the next, in a step
ON_THE_CONE = 1.0 - 1e-8  # chosen: part of the friction limit from which an impulse is that of a slide
CLOSED_ROUNDINGS = 16  # chosen: of a gap, a difference of places that were turned: what is smaller is 0


class Surfaces(Block):
    """What the shapes are made of, and what pairs of materials do to one another."""

    material: Array[Ints, "n_s"]
    mu: Array[Floats, "n_m", "n_m"]  # of a law that varies with the slip its static coefficient
    has_laws: int  # whether there are such laws
    laws: Array[Floats, "n_l", "width"]  # of all pairs of materials, one row of n_m behind the other; where there are
    e: Array[Floats, "n_m", "n_m"]
    rolling: Array[Floats, "n_m", "n_m"]  # lengths of rolling and spinning friction (rolling.py) [m]
    spinning: Array[Floats, "n_m", "n_m"]
    adhesion: Array[Floats, "n_m", "n_m"]  # pull-off force of a contact (adhesion.py) [N]
    has_grain: int  # whether friction of some differs by direction (grain.py)
    grain: Array[Floats, "n_g", "3"]  # its direction on each shape, in the axes of its body, or 0; where some have one
    across: Array[Floats, "n_m", "n_m"]  # coefficients across it, where mu is that along it
    impact: int  # the law of impact of all pairs of materials that rebound, an ``ImpactLaw``
    is_compliant: int  # then every contact has a spring and a damper in place of e
    stiffness: float  # [N/m]
    damping: float  # [N s/m]


class Contacts(Block):
    """Up to m contacts of a step, beside the rows of their problem."""

    e: Array[Floats, "m"]
    gamma_minus: Array[Floats, "m"]  # velocity of approach of a contact that rebounds [m/s]
    lost: Array[Floats, "m"]  # what it took from the motion in landing [J]
    taken: Array[Floats, "m"]  # twice the energy that a landing took along the normal [J]
    impact: Array[Ints, "m"]  # whether it rebounds
    drift: Array[Floats, "m", "d"]  # of a joint: how far its points are apart [m]
    pull: Array[Floats, "m"]  # by which a contact adheres in the step (adhesion.py) [N s]
    P: Array[Floats, "m", "d"]  # impulses of the step, those of its impacts with them [N s]
    n_before: int  # contacts of the step before that had impulses
    dt_before: float  # its length, or that of its last part [s]
    half: float  # of what rows turned by since its middle, the part that they turn by in half of this one
    key_before: Array[Ints, "m"]
    P_before: Array[Floats, "m", "d"]  # in the axes of the world
    own_before: Array[Floats, "m", "d"]  # along normal and tangents
    normal_before: Array[Floats, "m", "d"]
    point_before: Array[Floats, "m", "d"]
    arms_before: Array[Floats, "m", "2", "d"]  # from the centres of its bodies [m]
    closing_before: Array[Floats, "m"]  # velocity at which its gap closed, 0 of one that was closed [m/s]
    was_static: Array[Ints, "m"]  # of a contact of this step: whether static friction has been tried on it
    stuck_before: Array[Ints, "m"]  # whether its impulse was within its friction cone
    row_before: Array[Ints, "m"]  # which row of the step before it was
    gamma_before: Array[Floats, "m", "d"]  # J v_1 along normal and tangents (wandering.py) [m/s]
    slack: Array[Floats, "m"]  # velocity of approach up to which what was held does not land [m/s]
    wander: Array[Floats, "m"]  # of b_N, what the rows of a contact that is held turn by (wandering.py) [m/s]
    is_taken: Array[Ints, "m"]  # whether a contact of this step goes on with it
    held: Array[Ints, "m"]  # of a contact of this step: which one of those had its rows (wandering.py); -1: none
    source: Array[Ints, "m"]  # of a contact of this step: which one of those it goes on with; -1: none
    left_of: Array[Ints, "n_s"]  # of a shape: its first contact of the step before; -1: none
    left: Array[Ints, "m", "2"]  # and behind such a one, those of its two shapes


@kernel
def write_law(shapes, surfaces, found, c, network):
    """Bodies and friction of contact c; its restitution."""
    s_i, s_j = found.shape_i[c], found.shape_j[c]
    network.i[c], network.j[c] = shapes.body[s_i], shapes.body[s_j]
    a, b = surfaces.material[s_i], surfaces.material[s_j]
    network.mu[c], network.soft[c], network.sprung[c] = surfaces.mu[a, b], 0.0, 0
    return surfaces.e[a, b]


@kernel
def begin(bodies, network, n):
    """The velocities without impulses."""
    for b in range(network.v_free.shape[0]):
        for x in range(n):
            network.v_free[b, x] = bodies.v_free[b, x]


@kernel
def write_gap(bodies, found, c, dt, network):
    """The gap at the beginning of the step, and what it asks of the normal velocity."""
    i, j, size = network.i[c], network.j[c], 0.0
    for x in range(bodies.shift.shape[1]):
        found.gap[c] -= network.J_i[c, 0, x] * bodies.shift[i, x] + network.J_j[c, 0, x] * bodies.shift[j, x]
    for k in range(found.point.shape[1]):
        size += abs(found.point[c, k]) + abs(bodies.x_0[i, k]) + abs(bodies.x_0[j, k])
    if abs(found.gap[c]) <= rounded_sum(CLOSED_ROUNDINGS, size):
        found.gap[c] = 0.0
    network.b[c, 0] = found.gap[c] / dt if found.gap[c] > 0.0 else 0.0


@kernel
def write_compliance(surfaces, found, c, dt, network):
    """R of a compliant contact, and what its gap asks of the normal velocity (moreau_jean/compliance.py)."""
    k, damping = surfaces.stiffness, surfaces.damping
    network.soft[c] = 1.0 / (k * dt * dt + damping * dt)
    network.b[c, 0] = found.gap[c] / (dt + damping / k)


@in_dimensions("void(int64, int64, int64, int64, int64, int64, float64)")
def write_contacts(bodies_at, shapes_at, surfaces_at, found_at, contacts_at, network_at, dt, d):
    """The rows of a step, and where their solution starts; network.n_c contacts were found."""
    bodies, shapes, surfaces = view(bodies_at, Bodies), view(shapes_at, Shapes), view(surfaces_at, Surfaces)
    found, contacts, network = view(found_at, Found), view(contacts_at, Contacts), view(network_at, Network)
    begin(bodies, network, 3 * (d - 1))
    find_all_sources(shapes, bodies, found, network.n_c, contacts)
    for c in range(network.n_c):
        contacts.e[c] = write_law(shapes, surfaces, found, c, network)
        reach_to_touch(bodies, found, network, c)
        write_rows(bodies, found, c, network, d)
        write_gap(bodies, found, c, dt, network)
        if surfaces.is_compliant == 1:
            write_compliance(surfaces, found, c, dt, network)
        ask_of_guides(bodies, found, network, c, d, dt)
        start_from_before(found, contacts, network, c, d)


@kernel
def start_from_before(found, contacts, network, c, d):
    """The impulses of the step before: in the rows of contact c, or turned to them where its normal has changed."""
    at = contacts.source[c]
    is_kept = at >= 0 and has_same_normal(found, contacts, c, at)
    for row in range(d):
        total = contacts.own_before[at, row] if is_kept else 0.0
        if at >= 0 and not is_kept:
            for k in range(d):
                total += network.J_j[c, row, k] * contacts.P_before[at, k]
        network.P[c, row] = total


@kernel
def has_same_normal(found, contacts, c, at):
    """Whether contact c has the normal, to the last bit, of the one that it goes on with."""
    for k in range(found.normal.shape[1]):
        if found.normal[c, k] != contacts.normal_before[at, k]:
            return False
    return True


@kernel
def find_sources(found, n_c, contacts):
    """Which contact of the step before each one goes on with; both steps are in the order of their keys."""
    leave_all(contacts)
    take_by_pairs(found, n_c, contacts, True)
    take_by_pairs(found, n_c, contacts, False)


@kernel
def find_all_sources(shapes, bodies, found, n_c, contacts):
    """The same, with what slid to another shape."""
    leave_all(contacts)
    take_by_pairs(found, n_c, contacts, True)
    for c in range(n_c):
        contacts.held[c] = contacts.source[c]
    find_sources_on_neighbours(shapes, bodies, found, n_c, contacts)
    take_by_pairs(found, n_c, contacts, False)


@kernel
def leave_all(contacts):
    """None of the contacts of the step before is taken."""
    for at in range(contacts.n_before):
        contacts.is_taken[at] = 0


@kernel
def take_by_pairs(found, n_c, contacts, is_same):
    """Contacts of each pair of shapes go on with those of the same key, or, of what is left, with the nearest."""
    key, before, first, c = found.key, contacts.key_before, 0, 0
    while c < n_c:
        pair = key[c] >> FEATURE_BITS
        end = c
        while end < n_c and key[end] >> FEATURE_BITS == pair:
            end += 1
        while first < contacts.n_before and before[first] >> FEATURE_BITS < pair:
            first += 1
        last = first
        while last < contacts.n_before and before[last] >> FEATURE_BITS == pair:
            last += 1
        if is_same:
            take_same(key, c, end, first, last, contacts)
        else:
            take_nearest(found, c, end, first, last, contacts)
        c, first = end, last


@kernel
def take_same(key, begin, end, first, last, contacts):
    """Contacts begin to end - 1 of a pair go on with those of the same key among first to last - 1."""
    at = first
    for c in range(begin, end):
        contacts.source[c] = -1
        while at < last and contacts.key_before[at] < key[c]:
            at += 1
        if at < last and contacts.key_before[at] == key[c]:
            contacts.source[c] = at
            contacts.is_taken[at] = 1


@kernel
def take_nearest(found, begin, end, first, last, contacts):
    """What is left of them goes on with the nearest of what is left."""
    for c in range(begin, end):
        if contacts.source[c] >= 0:
            continue
        least = inf
        for at in range(first, last):
            if contacts.is_taken[at] == 0:
                square = 0.0
                for k in range(found.point.shape[1]):
                    way = found.point[c, k] - contacts.point_before[at, k]
                    square += way * way
                if square < least:
                    least, contacts.source[c] = square, at
        if contacts.source[c] >= 0:
            contacts.is_taken[contacts.source[c]] = 1


@kernel
def find_sources_on_neighbours(shapes, bodies, found, n_c, contacts):
    """What slides from one shape to the next, with the same normal, goes on with what it had on that."""
    list_before(contacts)
    moves = bodies.motion.moves
    for c in range(n_c):
        if contacts.source[c] < 0 and found.key[c] < FIRST_ROLLING:
            for side in range(2):
                s = found.shape_i[c] if side == 0 else found.shape_j[c]
                if contacts.source[c] < 0 and moves[shapes.body[s]] == 1:
                    take_left(found, c, s, is_ball(shapes, s, found.normal.shape[1]), contacts)


@kernel
def list_before(contacts):
    """List by shapes the contacts of the step before."""
    for s in range(contacts.left_of.shape[0]):
        contacts.left_of[s] = -1
    for at in range(contacts.n_before):
        if contacts.key_before[at] < FIRST_ROLLING:
            for side in range(2):
                s = shape_of_key(contacts.key_before[at], side)
                contacts.left[at, side] = contacts.left_of[s]
                contacts.left_of[s] = at


@kernel
def shape_of_key(key, side):
    """The first or the second shape of a key."""
    pair = key >> FEATURE_BITS
    return pair >> SHAPE_BITS if side == 0 else pair & NO_SHAPE


@kernel
def take_left(found, c, s, is_round, contacts):
    """Contact c of shape s goes on with what is left of the same corner of it, with its normal, or of a ball; where
    another one took that, it has its rows."""
    at, widest = contacts.left_of[s], ROLLED_NORMAL if is_round else SAME_NORMAL
    while at >= 0:
        turn, key = 0.0, contacts.key_before[at]
        for k in range(found.normal.shape[1]):
            turn += (found.normal[c, k] - contacts.normal_before[at, k]) ** 2
        is_same = (is_round or (key ^ found.key[c]) & LAST_FEATURE == 0) and turn <= widest * widest
        if is_same:
            contacts.held[c] = at
        if is_same and contacts.is_taken[at] == 0:
            contacts.source[c], contacts.is_taken[at] = at, 1
            return
        at = contacts.left[at, 0 if shape_of_key(key, 0) == s else 1]


@kernel
def is_within_cone(network, c):
    """Whether the impulse of contact c is less than its friction holds."""
    friction, most = 0.0, network.mu[c] * network.P[c, 0] * ON_THE_CONE
    for row in range(1, network.P.shape[1]):
        friction += network.P[c, row] * network.P[c, row]
    return friction < most * most


@kernel
def keep_contact(found, network, c, d, contacts):
    """Keep the impulse of contact c for the step to come, J_j^T P: its first d columns are those of a force."""
    at = contacts.n_before
    contacts.key_before[at] = found.key[c]
    for k in range(d):
        total = 0.0
        for row in range(d):
            total += network.J_j[c, row, k] * network.P[c, row]
        contacts.P_before[at, k], contacts.own_before[at, k] = total, network.P[c, k]
        contacts.point_before[at, k], contacts.normal_before[at, k] = found.point[c, k], found.normal[c, k]
    contacts.row_before[at], contacts.stuck_before[at] = c, is_within_cone(network, c)
    contacts.closing_before[at] = network.b[c, 0] - network.turn[c, 0]
    contacts.n_before = at + 1


@kernel
def keep_impulses(bodies, found, network, d, contacts):
    """Keep all impulses that are not zero, and those of joints, but those of bodies that fell asleep (sleep.py)."""
    still, moves = bodies.motion.still, bodies.motion.moves
    contacts.n_before = 0
    for c in range(network.n_c):
        i, j = network.i[c], network.j[c]
        if acts(network, c) and still[i] * moves[i] + still[j] * moves[j] == 0:
            keep_contact(found, network, c, d, contacts)


@kernel
def impulse_before(contacts, at, to):
    """Put one of the impulses of the step before in the place of another."""
    contacts.key_before[to] = contacts.key_before[at]
    contacts.row_before[to], contacts.closing_before[to] = contacts.row_before[at], contacts.closing_before[at]
    contacts.stuck_before[to] = contacts.stuck_before[at]
    for k in range(contacts.P_before.shape[1]):
        contacts.P_before[to, k], contacts.own_before[to, k] = contacts.P_before[at, k], contacts.own_before[at, k]
        contacts.point_before[to, k] = contacts.point_before[at, k]
        contacts.normal_before[to, k] = contacts.normal_before[at, k]
        contacts.gamma_before[to, k] = contacts.gamma_before[at, k]
        for side in range(2):
            contacts.arms_before[to, side, k] = contacts.arms_before[at, side, k]
