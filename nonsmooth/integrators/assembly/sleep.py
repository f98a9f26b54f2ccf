"""Islands that sleep: what a step did not change, and the next one cannot, is left out of it.

An island falls asleep after a step that began and ended at rest, from the impulses that it ends with, whose solver did
nothing and would do nothing again, and whose contacts do no work: the step is a fixed point, and so are all that
follow, until something else comes near. Its contacts go from the rows of the step to rows of their own; its bodies are
``still``, so none of their pairs is looked for but those with bodies that move.

An island wakes when a contact is found between one of its bodies and a body that is not still (a margin before they
touch), which is where its own contacts would begin to be solved together with others, and when the step has another
length. Its impulses are then those it fell asleep with. No bit of it differs from that of an island that is kept awake.
"""

from __future__ import annotations

from math import nan
from typing import Annotated as Array
from typing import NamedTuple

import numpy as np

from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.network.solve import BY_START, Solver, lasting_residual
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import impulse_before
from nonsmooth.integrators.assembly.of_body import predict_body
from nonsmooth.integrators.assembly.project import Moves
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.scenes.detection import FIRST_ROLLING, Found


class Asleep(Block):
    """The islands that sleep, of n_b bodies, and their contacts, up to m."""

    n_c: int  # contacts
    count: int  # islands
    new_contacts: int  # of these, what fell asleep in the last step: it stands among the rows of that too
    new_islands: int
    dt: float  # [s] the length of the steps that they sleep through
    deepest: float  # their least gap, or 0 [m]
    residual: float  # the largest of theirs
    island: Array[Ints, "n_b"]  # of a body: 1 + the first body of its island; 0 of one that is awake
    residual_of: Array[Floats, "n_b"]  # of the island with this first body
    owner: Array[Ints, "m"]  # island of a contact; those of one island are in the order of their keys
    key: Array[Ints, "m"]
    i: Array[Ints, "m"]
    j: Array[Ints, "m"]
    mu: Array[Floats, "m"]
    gap: Array[Floats, "m"]
    normal: Array[Floats, "m", "d"]
    point: Array[Floats, "m", "d"]
    frame: Array[Floats, "m", "d", "d"]  # axes of normal and tangents
    own: Array[Floats, "m", "d"]  # impulses along these


class ContactRows(NamedTuple):
    """Contacts of a step as users are shown them, one row each."""

    i: np.ndarray
    j: np.ndarray
    mu: np.ndarray
    gap: np.ndarray
    normal: np.ndarray
    point: np.ndarray
    frame: np.ndarray  # (m, d, d) axes of normal and tangents
    own: np.ndarray  # impulses along these

    @property
    def P(self) -> np.ndarray:
        """The impulses in the axes of the world."""
        return (self.frame * self.own[:, :, None]).sum(axis=1)


def rows_of_step(found: Found, network: Network, P: np.ndarray) -> ContactRows:
    """Those that stand among the rows of the step, before its springs and joints."""
    n, d = int(np.searchsorted(found.key[: int(network.n_c)], FIRST_ROLLING)), P.shape[1]
    columns = network.i, network.j, network.mu, found.gap, found.normal, found.point, network.J_j[:, :, :d], P
    return ContactRows(*(column[:n] for column in columns))


def rows_at_rest(asleep: Asleep) -> ContactRows:
    """Those that sleep, island by island."""
    is_contact = asleep.key[: int(asleep.n_c)] < FIRST_ROLLING
    return ContactRows(*(getattr(asleep, name)[: int(asleep.n_c)][is_contact] for name in ContactRows._fields))


@kernel("void(int64, int64, int64, int64, int64, int64, float64)")
def let_sleep(bodies_at, found_at, network_at, moves_at, solver_at, asleep_at, dt):
    """Let the islands fall asleep that the step just solved left as they were, in the plane or in space."""
    bodies, found, network = view(bodies_at, Bodies), view(found_at, Found), view(network_at, Network)
    moves, solver, asleep = view(moves_at, Moves), view(solver_at, Solver), view(asleep_at, Asleep)
    contacts, islands = asleep.n_c, asleep.count
    for k in range(network.islands.count):
        if network.islands.rung[k] == BY_START and is_fixed_point(bodies, network, moves, solver, k):
            put_to_sleep(bodies, found, network, asleep, k)
    asleep.new_contacts, asleep.new_islands = asleep.n_c - contacts, asleep.count - islands
    if asleep.new_islands > 0:
        asleep.dt = dt
        sum_up(asleep)


@kernel
def is_fixed_point(bodies, network, moves, solver, k):
    """Whether the step that was solved for island k left all as it was, and the next one would."""
    islands = network.islands
    if moves.deep[k] == 1 or islands.is_met[k] == 0 or not islands.residual[k] <= lasting_residual(network, solver, k):
        return False
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        for x in range(network.v.shape[1]):
            if network.v[body, x] != 0.0 or bodies.v_0[body, x] != 0.0 or bodies.v_move[body, x] != 0.0:
                return False
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        if is_driven(bodies, network, islands.contacts[at]):
            return False
    return True


@kernel
def is_driven(bodies, network, c):
    """Whether contact c is with a body that is guided along, or is pressed where a surface runs."""
    for b in (network.i[c], network.j[c]):
        if bodies.motion.moves[b] == 0 and not stands(bodies, b):
            return True
    if network.P[c, 0] > 0.0:
        for row in range(1, network.b.shape[1]):
            if network.b[c, row] != 0.0:
                return True
    return False


@kernel
def put_to_sleep(bodies, found, network, asleep, k):
    """Let island k sleep."""
    islands = network.islands
    first = islands.bodies[islands.body_start[k]]
    for at in range(islands.body_start[k], islands.body_start[k + 1]):
        body = islands.bodies[at]
        asleep.island[body] = 1 + first
        bodies.motion.still[body] = 1
    asleep.residual_of[first] = islands.residual[k]
    for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
        c, row, d = islands.contacts[at], asleep.n_c, network.b.shape[1]
        asleep.owner[row], asleep.key[row] = 1 + first, found.key[c]
        asleep.i[row], asleep.j[row] = network.i[c], network.j[c]
        asleep.mu[row], asleep.gap[row] = network.mu[c], found.gap[c]
        for a in range(d):
            asleep.normal[row, a], asleep.point[row, a] = found.normal[c, a], found.point[c, a]
            asleep.own[row, a] = network.P[c, a]
            for e in range(d):
                asleep.frame[row, a, e] = network.J_j[c, a, e]
        asleep.n_c = row + 1
    asleep.count += 1


@kernel
def sum_up(asleep):
    """The figures of all islands that sleep."""
    asleep.residual = asleep.deepest = 0.0
    for b in range(asleep.island.shape[0]):
        if asleep.island[b] == 1 + b:
            asleep.residual = max(asleep.residual, asleep.residual_of[b])
    for row in range(asleep.n_c):
        asleep.deepest = min(asleep.deepest, asleep.gap[row])


@kernel
def mark_guides(bodies, shapes, is_any_asleep):
    """What impulses do not move is still while it stands, where something sleeps or most shapes are of its kind: these
    are not compared with one another then."""
    motion = bodies.motion
    is_spared = is_any_asleep or is_mostly_guided(motion, shapes)
    for b in range(motion.moves.shape[0]):
        if motion.moves[b] == 0:
            motion.still[b] = 1 if is_spared and stands(bodies, b) else 0


@kernel
def is_mostly_guided(motion, shapes):
    """Whether more than half of the shapes are of bodies that impulses do not move."""
    n_s, n = shapes.body.shape[0], 0
    for s in range(n_s):
        n += 1 - motion.moves[shapes.body[s]]
    return 2 * n > n_s


@kernel
def stands(bodies, b):
    """Whether body b has no velocity, and is told of none."""
    for x in range(bodies.gain.shape[1]):
        if bodies.motion.v[b, x] != 0.0 or bodies.gain[b, x] != 0.0:
            return False
    return True


@kernel
def wake_touched(bodies, shapes, found, n, contacts, asleep, step):
    """Wake the islands of which a contact was found, among the first n, for a step (dt, d); returns how many."""
    before = asleep.count
    for c in range(n):
        for s in (found.shape_i[c], found.shape_j[c]):
            owner = asleep.island[shapes.body[s]]
            if owner > 0:
                wake(bodies, contacts, asleep, owner, step)
    if asleep.count < before:
        sum_up(asleep)
    return before - asleep.count


@kernel
def wake_all(bodies, contacts, asleep, step):
    """Wake what sleeps, for a step (dt, d)."""
    for b in range(asleep.island.shape[0]):
        if asleep.island[b] > 0:
            wake(bodies, contacts, asleep, asleep.island[b], step)
    sum_up(asleep)


@kernel
def wake(bodies, contacts, asleep, owner, step):
    """Wake one island for a step (dt, d): its impulses are those of the step before, its free motion is predicted."""
    dt, d = step
    for b in range(asleep.island.shape[0]):
        if asleep.island[b] == owner:
            asleep.island[b] = bodies.motion.still[b] = 0
            predict_body(bodies, b, dt, d)
    give_back_impulses(contacts, asleep, owner)
    left = 0
    for row in range(asleep.n_c):
        if asleep.owner[row] != owner:
            move_row(asleep, row, left)
            left += 1
    asleep.n_c = left
    asleep.count -= 1


@kernel
def give_back_impulses(contacts, asleep, owner):
    """Merge the impulses of an island into those of the step before, from the last key down."""
    last, to = contacts.n_before - 1, contacts.n_before - 1
    for row in range(asleep.n_c):
        to += 1 if asleep.owner[row] == owner and is_kept(asleep, row) else 0
    contacts.n_before = to + 1
    for row in range(asleep.n_c - 1, -1, -1):
        if asleep.owner[row] != owner or not is_kept(asleep, row):
            continue
        while last >= 0 and contacts.key_before[last] > asleep.key[row]:
            impulse_before(contacts, last, to)
            last, to = last - 1, to - 1
        take_impulse(contacts, asleep, row, to)
        to -= 1


@kernel
def is_kept(asleep, row):
    """Whether a contact had an impulse, or is a joint."""
    return asleep.own[row, 0] > 0.0 or asleep.mu[row] < 0.0


@kernel
def take_impulse(contacts, asleep, row, to):
    """The impulse of a contact that slept as one of the step before."""
    d = asleep.own.shape[1]
    contacts.key_before[to], contacts.closing_before[to], contacts.stuck_before[to] = asleep.key[row], 0.0, 1
    for k in range(d):
        total = 0.0
        for a in range(d):
            total += asleep.frame[row, a, k] * asleep.own[row, a]
        contacts.P_before[to, k], contacts.own_before[to, k] = total, asleep.own[row, k]
        contacts.point_before[to, k], contacts.normal_before[to, k] = asleep.point[row, k], asleep.normal[row, k]
        contacts.gamma_before[to, k] = 0.0
        contacts.arms_before[to, 0, k] = contacts.arms_before[to, 1, k] = nan  # it has not run anywhere


@kernel
def move_row(asleep, row, to):
    """Put a row of the contacts in the place of another."""
    asleep.owner[to], asleep.key[to] = asleep.owner[row], asleep.key[row]
    asleep.i[to], asleep.j[to] = asleep.i[row], asleep.j[row]
    asleep.mu[to], asleep.gap[to] = asleep.mu[row], asleep.gap[row]
    for a in range(asleep.own.shape[1]):
        asleep.normal[to, a], asleep.point[to, a] = asleep.normal[row, a], asleep.point[row, a]
        asleep.own[to, a] = asleep.own[row, a]
        for e in range(asleep.own.shape[1]):
            asleep.frame[to, a, e] = asleep.frame[row, a, e]
