"""A step in which a body lands is taken in parts: up to the landing, and from there on.

Where a contact c closes within the step, its impulse acts as if from the beginning of the step: a block that rocks then
pivots too early, by up to dt, and loses the order of the method. It lands at t_l instead, the first root of

    g_N + gamma_0 t + a t^2/2 = 0,    a = (gamma_1 - W_cc P_N - gamma_0)/dt

a is the acceleration of the gap under all impulses of the whole step but its own. The first part of the step ends at
t_l; in it the contact may approach freely, b_N >= 2 g dt - gamma_0, since a partial impulse beside a corner that is
pressed would take more than an impact does. If it would be met before, since the other impulses are not those of the
whole step, the part is taken again, shorter. The second part begins with the whole impact, b_N = 0, over what is left
of the gap. Where bodies rebound, it has next to no length and ends with that (impact.py), and a third part takes the
rest of the step. All are steps of the scheme, of their own lengths; the impulses of a step are those of all of them.

Steps are divided in small scenes, where a body lands on one that impulses do not move, faster than ``FAST`` steps of
gravity bring it to, and not so fast that it may turn another corner to what is thin. Two bodies that are both free keep
their angular momentum to rounding in a step that is not divided.
Equations: docs/theory/scenes.md, (3).
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from typing import Annotated as Array

import numpy as np

from nonsmooth.contact.network.joint import may_land
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies, fall_of
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.integrators.assembly.project import normal_velocity, put_back, turn_of_limit
from nonsmooth.integrators.assembly.sleep import ContactRows
from nonsmooth.integrators.assembly.wandering import turns_or_gains
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.scenes.detection import FIRST_ROLLING, Found
from nonsmooth.scenes.shape_rows import Shapes

FAST = 4.0  # chosen: times g dt, the velocity of approach of a landing: what is slower loses less than the step does
IN_SECOND_HALF = 0.5  # chosen: of a part: what would land before it at its velocity is not let in
# chosen: of the reach of a body, its way in a step: one of 100 m/s that spins went through a wall of a millimetre
NEAR_ENOUGH = 0.5
SHORT_OF_IT = 0.999  # chosen: of the time to a landing, a part that is taken again
PAST_IT = 1e-9  # chosen: of the way of a contact in a part: what is overlapped less is a rounding
LEFT_OVER = 2.0 * (1.0 - SHORT_OF_IT)  # derived: of the way in a step: over such a gap a contact lands at once
STROKE = 1e-9  # chosen: of a step, the part in which what has landed rebounds
ROOM_OF_PARTS = 4  # derived: times the contacts of a step: of two parts that a division adds, and of those before
MOST_DIVISIONS = 12  # chosen: of a step: corners that land within it, and parts that are taken again
UNDIVIDED = 2.0  # code: the share of a step in which nothing lands
NO_KEY = -1  # code: of no contact


class Parts(Block):
    """The m contacts that may have had impulses in the parts of a step before its last one."""

    n_c: int
    key: Array[Ints, "m"]
    i: Array[Ints, "m"]
    j: Array[Ints, "m"]
    mu: Array[Floats, "m"]
    gap: Array[Floats, "m"]
    normal: Array[Floats, "m", "d"]
    point: Array[Floats, "m", "d"]
    frame: Array[Floats, "m", "d", "d"]  # axes of normal and tangents
    P: Array[Floats, "m", "d"]  # impulses in the axes of the world


@kernel("float64(int64, int64, int64, int64, int64, float64, float64)")
def part_to_landing(bodies_at, shapes_at, found_at, contacts_at, network_at, dt, whole):
    """The share of the solved step up to the first landing: 0 where what lands at once rebounds, 1 where it is due
    later, and UNDIVIDED where nothing lands."""
    bodies, shapes, found = view(bodies_at, Bodies), view(shapes_at, Shapes), view(found_at, Found)
    contacts, network = view(contacts_at, Contacts), view(network_at, Network)
    for b in range(bodies.mass.shape[0]):
        if bodies.motion.moves[b] == 0 and turns_or_gains(bodies, b):
            return UNDIVIDED
    part, n, fast = UNDIVIDED, network.v.shape[1], FAST * fall_of(bodies, dt)
    for c in range(network.n_c):
        if is_on_the_ground(bodies, network, c):
            before, _ = normal_velocity(network, c, bodies.v_0, n)
            before -= turn_of_limit(network, c)
            if before >= -fast:
                continue
            reach = min(reach_of(shapes, found.shape_i[c]), reach_of(shapes, found.shape_j[c]))
            if -before * whole > NEAR_ENOUGH * reach:
                return UNDIVIDED
            if found.gap[c] <= -LEFT_OVER * whole * before:
                part = 0.0 if contacts.e[c] > 0.0 and network.P[c, 0] > 0.0 else part
                continue
            after, _ = normal_velocity(network, c, network.v, n)
            after += turn_of_limit(network, c)
            is_met = network.P[c, 0] > 0.0 or found.gap[c] + 0.5 * dt * (before + after) < PAST_IT * dt * before
            if is_met:
                part = min(part, share_to_landing(network, c, found.gap[c], before, after, dt))
    return part


@kernel
def is_on_the_ground(bodies, network, c):
    """Whether contact c is one with a body that impulses do not move."""
    return may_land(network, c) and bodies.motion.moves[network.i[c]] != bodies.motion.moves[network.j[c]]


@kernel
def reach_of(shapes, s):
    """How far a shape reaches from its centre."""
    return shapes.reach[s] + shapes.radius[s]


@kernel
def share_to_landing(network, c, gap, before, after, dt):
    """t_l / dt of contact c, at most 1, from its velocities at the ends of the step."""
    change = after - network.W[c, 0, 0] * network.P[c, 0] - before
    square = before * before - 2.0 * change * gap / dt
    return min(1.0, 2.0 * gap / (dt * (sqrt(square) - before))) if square >= 0.0 else 1.0


@kernel("void(int64, int64, int64, float64, float64, int64)")
def ask_of_landings(bodies_at, found_at, network_at, dt, whole, lets_in):
    """Stop at once what lands at the beginning of a part of a step; in one up to a landing let what approaches fast, to
    land at the end of it or later, do so freely."""
    bodies, found, network = view(bodies_at, Bodies), view(found_at, Found), view(network_at, Network)
    fall = fall_of(bodies, dt)
    for c in range(network.n_c):
        if found.gap[c] > 0.0 and is_on_the_ground(bodies, network, c):
            turn = turn_of_limit(network, c)
            before, _ = normal_velocity(network, c, bodies.v_0, network.v.shape[1])
            before -= turn
            if before < -FAST * fall:
                if lets_in == 1 and found.gap[c] >= -IN_SECOND_HALF * dt * before:
                    network.b[c, 0] = max(network.b[c, 0], 2.0 * fall - before + turn)
                elif found.gap[c] <= -LEFT_OVER * whole * before:
                    network.b[c, 0] = turn


@kernel("void(int64, int64, int64, float64)")
def land_whole(bodies_at, found_at, network_at, dt):
    """Stop at once what approaches fast and would close its gap within a step that is not divided."""
    bodies, found, network = view(bodies_at, Bodies), view(found_at, Found), view(network_at, Network)
    fall, n = fall_of(bodies, dt), network.v.shape[1]
    for c in range(network.n_c):
        if found.gap[c] > 0.0 and may_land(network, c):
            turn = turn_of_limit(network, c)
            before = normal_velocity(network, c, bodies.v_0, n)[0] - turn
            after = normal_velocity(network, c, network.v_free, n)[0] + turn
            if before < -FAST * fall and found.gap[c] < -dt * after:
                network.b[c, 0] = turn


@kernel("void(int64, int64, int64, int64)")
def keep_part(found_at, contacts_at, network_at, parts_at):
    """Add up the impulses of the contacts in the parts of a step before its last one, those of impacts with them."""
    found, contacts = view(found_at, Found), view(contacts_at, Contacts)
    network, parts, d = view(network_at, Network), view(parts_at, Parts), found.normal.shape[1]
    for c in range(network.n_c):
        if contacts.P[c, 0] > 0.0 and found.key[c] < FIRST_ROLLING:
            at = row_of_key(parts, found.key[c], d)
            parts.gap[at], parts.mu[at] = found.gap[c], network.mu[c]
            parts.i[at], parts.j[at] = network.i[c], network.j[c]
            for k in range(d):
                parts.normal[at, k], parts.point[at, k] = found.normal[c, k], found.point[c, k]
                for row in range(d):
                    parts.frame[at, row, k] = network.J_j[c, row, k]
                    parts.P[at, k] += network.J_j[c, row, k] * contacts.P[c, row]


@kernel("void(int64, int64)")
def add_parts(parts_at, others_at):
    """Add the impulses of other parts, for which there is room."""
    parts, others = view(parts_at, Parts), view(others_at, Parts)
    d = parts.normal.shape[1]
    for other in range(others.n_c):
        at = row_of_key(parts, others.key[other], d)
        parts.gap[at], parts.mu[at] = others.gap[other], others.mu[other]
        parts.i[at], parts.j[at] = others.i[other], others.j[other]
        for k in range(d):
            parts.normal[at, k], parts.point[at, k] = others.normal[other, k], others.point[other, k]
            parts.P[at, k] += others.P[other, k]
            for row in range(d):
                parts.frame[at, row, k] = others.frame[other, row, k]


@kernel
def has_room(parts, most):
    """Whether two more parts can be kept, of up to so many contacts each."""
    return parts.n_c + 2 * most <= parts.key.shape[0]


@kernel
def row_of_key(parts, key, d):
    """The row of a contact, which is a new one where it had none yet."""
    for at in range(parts.n_c):
        if parts.key[at] == key:
            return at
    at, parts.n_c = parts.n_c, parts.n_c + 1
    parts.key[at] = key
    for k in range(d):
        parts.P[at, k] = 0.0
    return at


@kernel
def is_taken_again(progress, places):
    """Whether the solved part of a step is taken again: up to just before a landing within it, or, where parts do not
    get short enough, with the landing in it."""
    is_first = progress.lets_in == 0
    if progress.is_stroke == 1 or (is_first and (progress.is_missed == 1 or progress.has_verdicts == 1)):
        return False
    if is_first and not has_room(view(places.parts, Parts), view(places.found, Found).gap.shape[0]):
        return False
    share = part_to_landing(
        places.bodies, places.shapes, places.found, places.contacts, places.network, progress.dt, progress.whole
    )
    if share == UNDIVIDED or (is_first and progress.divisions == MOST_DIVISIONS):
        return False
    if progress.divisions == MOST_DIVISIONS:
        progress.lets_in = 0
    elif share == 0.0:
        progress.parts, progress.divisions = max(progress.parts, 1), progress.divisions + 1
        progress.is_stroke, progress.lets_in = 1, 0
        progress.left += (1.0 - STROKE) * progress.dt
        progress.dt *= STROKE
    else:
        share *= 1.0 if is_first else SHORT_OF_IT
        progress.left += (1.0 - share) * progress.dt
        progress.dt *= share
        progress.parts = max(progress.parts, 1) if progress.left > 0.0 else progress.parts
        progress.divisions, progress.lets_in = progress.divisions + 1, 1
    put_back(view(places.bodies, Bodies))
    return True


@kernel
def begin_next_part(progress, places):
    """Keep the impulses of the part that ends, and begin the next one: what has landed rebounds in one of its own."""
    keep_part(places.found, places.contacts, places.network, places.parts)
    progress.is_stroke = progress.has_restitution * progress.lets_in
    progress.dt = STROKE * progress.left if progress.is_stroke == 1 else progress.left
    progress.left -= progress.dt
    progress.parts, progress.lets_in = progress.parts + 1, 0


OF_PARTS = (part_to_landing, ask_of_landings, keep_part)  # defined: of a scene whose steps may be divided


def with_parts(
    rows: ContactRows, keys: np.ndarray, parts: Parts, upright: Callable[[ContactRows], ContactRows] | None
) -> tuple[ContactRows, np.ndarray]:
    """The contacts of the last part of a step with the impulses of all its parts, and their keys; rows are in the order
    of these, as are the rows of joints. ``upright`` makes those that users are shown of rows to scale (grain.py)."""
    n = int(parts.n_c)
    order = np.argsort(parts.key[:n])
    key, P = parts.key[order], parts.P[order]
    at = np.searchsorted(keys, key)
    is_last = np.append(keys, NO_KEY)[at] == key
    own = rows.own.copy()
    own[at[is_last]] += np.einsum("crk,ck->cr", rows.frame[at[is_last]], P[is_last])
    left = order[~is_last & (key < FIRST_ROLLING)]
    columns = {name: getattr(parts, name)[left] for name in ContactRows._fields if name != "own"}
    others = ContactRows(**columns, own=np.einsum("crk,ck->cr", parts.frame[left], parts.P[left]))
    if upright is not None:
        others = upright(others._replace(own=others.own / (others.frame**2).sum(axis=2)))
    keys = np.concatenate((keys, parts.key[left]))
    order = np.argsort(keys)
    joined = (np.concatenate(column)[order] for column in zip(rows._replace(own=own), others, strict=True))
    return ContactRows(*joined), keys[order]
