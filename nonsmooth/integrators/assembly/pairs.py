"""What each pair of bodies exchanged since the record before: impulses, and the works of the ledger, for runs that ask.

    P = sum over steps and contacts of J_j^T P_c (on body j, axes of the world),   works of each contact as in book.py

A joint is a pair of its own. What a pair does in a step is summed first; steps that repeat it, to the last bit, are
counted and multiplied: at rest, asleep or left out, a contact goes on with its impulse in each step, and the sum is the
same to the last bit however the steps are cut into runs, and whether they were taken or left out. Pairs are found by
their numbers in a hash table with open addressing (Knuth, *The Art of Computer Programming* 3, section 6.4).
"""

from __future__ import annotations

from typing import Annotated as Array

import numpy as np

from nonsmooth.contact.network.joint import acts, is_powered
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.book import book_contact
from nonsmooth.integrators.assembly.joints import joint_of
from nonsmooth.integrators.assembly.sleep import Asleep, is_kept
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, keep_rows, new, view
from nonsmooth.scenes.detection import FIRST_DRIVE, FIRST_JOINT, FIRST_SPRING, Found

# chosen: odd numbers that spread the numbers of bodies and joints over the buckets. Source: Teschner et al., "Optimized
# spatial hashing for collision detection of deformable objects", VMV 2003
SPREADS = (73856093, 19349663, 83492791)
CONTACT = -1  # code: in the place of the number of a joint
PAIR_WORKS = ("normal", "friction", "surface")  # defined: columns behind the impulse


class Pairs(Block, n_t="1 << (2 * n_p).bit_length()", columns="d + 3"):
    """Up to n_p pairs since the record before; columns are the impulse, and works by normal, friction and surface."""

    is_asked: int  # whether the run keeps them
    count: int
    step: int  # the one that was booked last, of those taken
    is_open: int  # whether what it did stands in ``now`` alone
    i: Array[Ints, "n_p"]
    j: Array[Ints, "n_p"]
    joint: Array[Ints, "n_p"]
    seen: Array[Ints, "n_p"]  # the last step in which it acted
    steps: Array[Ints, "n_p"]  # in which it did
    times: Array[Ints, "n_p"]  # the last of these, that all did the same
    now: Array[Floats, "n_p", "columns"]  # what it does in the step at hand
    last: Array[Floats, "n_p", "columns"]  # what it did in each of these ``times``
    total: Array[Floats, "n_p", "columns"]  # and in all steps before them
    row_at: Array[Ints, "n_t"]  # 1 + the row of a pair; 0 where there is none


@kernel("void(int64, int64, int64, int64, int64, int64, int64)")
def book_pairs(bodies_at, found_at, network_at, asleep_at, pairs_at, is_impact, is_first):
    """Book a solved problem of a step, the first one with what sleeps, or that of its impacts, after the ledger."""
    bodies, found, network = view(bodies_at, Bodies), view(found_at, Found), view(network_at, Network)
    pairs, asleep, d = view(pairs_at, Pairs), view(asleep_at, Asleep), bodies.gravity.shape[0]
    if is_first == 1:
        settle(pairs)
        pairs.step += 1
        pairs.is_open = 1
        for row in range(asleep.n_c - asleep.new_contacts):
            is_spring = FIRST_SPRING <= asleep.key[row] < FIRST_JOINT
            is_drive = FIRST_DRIVE <= asleep.key[row] < FIRST_SPRING
            if is_kept(asleep, row) and not is_spring and not (is_drive and asleep.mu[row] > 0.0):  # of a motor
                joint = joint_of(asleep.key[row]) if asleep.key[row] >= FIRST_DRIVE else CONTACT
                at = row_in_step(pairs, asleep.i[row], asleep.j[row], joint)
                add_impulse(pairs, at, asleep.frame, asleep.own, row, d)
    v_before = bodies.v_0 if is_impact == 0 else network.v_free
    for c in range(network.n_c):
        if acts(network, c) and not is_powered(network, c):
            joint = joint_of(found.key[c]) if found.key[c] >= FIRST_DRIVE else CONTACT
            at = row_in_step(pairs, network.i[c], network.j[c], joint)
            add_impulse(pairs, at, network.J_j, network.P, c, d)
            normal, friction, surface = book_contact(bodies, network, c, v_before, d, 3 * (d - 1))
            pairs.now[at, d] += normal
            pairs.now[at, d + 1] += friction
            pairs.now[at, d + 2] += surface


@kernel
def add_impulse(pairs, at, axes, P, c, d):
    """The impulse of row c of a problem, in the axes of the world."""
    for k in range(d):
        total = 0.0
        for a in range(d):
            total += axes[c, a, k] * P[c, a]
        pairs.now[at, k] += total


@kernel
def row_in_step(pairs, i, j, joint):
    """The row of a pair, which acts in the step at hand."""
    slot = slot_of(pairs, i, j, joint)
    if pairs.row_at[slot] == 0:
        row = pairs.count
        pairs.count = pairs.row_at[slot] = row + 1
        pairs.i[row], pairs.j[row], pairs.joint[row], pairs.seen[row] = i, j, joint, 0
        clear(pairs, row)
    row = pairs.row_at[slot] - 1
    if pairs.seen[row] != pairs.step:
        pairs.seen[row] = pairs.step
        for k in range(pairs.now.shape[1]):
            pairs.now[row, k] = 0.0
    return row


@kernel
def slot_of(pairs, i, j, joint):
    """Where the table has a pair, or would have it."""
    last = pairs.row_at.shape[0] - 1
    slot = (i * SPREADS[0] ^ j * SPREADS[1] ^ (joint + 1) * SPREADS[2]) & last
    while pairs.row_at[slot] > 0:
        row = pairs.row_at[slot] - 1
        if pairs.i[row] == i and pairs.j[row] == j and pairs.joint[row] == joint:
            break
        slot = (slot + 1) & last
    return slot


@kernel
def clear(pairs, row):
    """A row of nothing yet."""
    pairs.steps[row] = pairs.times[row] = 0
    for k in range(pairs.total.shape[1]):
        pairs.total[row, k] = 0.0


@kernel
def settle(pairs):
    """Take what pairs did in the step booked last: it is counted where it is what they did before, else summed up."""
    if pairs.is_open == 0:
        return
    pairs.is_open = 0
    for row in range(pairs.count):
        if pairs.seen[row] != pairs.step:
            continue
        if pairs.times[row] == 0 or not is_repeated(pairs, row):
            for k in range(pairs.now.shape[1]):
                pairs.total[row, k] += pairs.times[row] * pairs.last[row, k]
                pairs.last[row, k] = pairs.now[row, k]
            pairs.times[row] = 0
        pairs.times[row] += 1
        pairs.steps[row] += 1


@kernel
def is_repeated(pairs, row):
    """Whether a pair did in the step at hand what it did before."""
    for k in range(pairs.now.shape[1]):
        if pairs.now[row, k] != pairs.last[row, k]:
            return False
    return True


@kernel("void(int64, int64)")
def repeat_pairs(pairs_at, steps):
    """Count so many steps as if they had been taken: each pair does what it did in the last one."""
    pairs = view(pairs_at, Pairs)
    settle(pairs)
    for row in range(pairs.count):
        if pairs.seen[row] == pairs.step:
            pairs.times[row] += steps
            pairs.steps[row] += steps


@kernel("void(int64)")
def settle_pairs(pairs_at):
    """``settle``, of what a record is made of."""
    settle(view(pairs_at, Pairs))


@kernel("void(int64)")
def begin_pairs(pairs_at):
    """Begin anew after a record, with the pairs that acted in the last step: a next one left out repeats it."""
    pairs = view(pairs_at, Pairs)
    settle(pairs)
    n, pairs.count = pairs.count, 0
    for row in range(n):
        if pairs.seen[row] == pairs.step:
            to = pairs.count
            pairs.i[to], pairs.j[to], pairs.joint[to] = pairs.i[row], pairs.j[row], pairs.joint[row]
            pairs.seen[to] = pairs.seen[row]
            for k in range(pairs.last.shape[1]):
                pairs.now[to, k], pairs.last[to, k] = pairs.now[row, k], pairs.last[row, k]
            clear(pairs, to)
            pairs.count = to + 1
    list_pairs(pairs_at)


@kernel("void(int64)")
def list_pairs(pairs_at):
    """Make the table anew."""
    pairs = view(pairs_at, Pairs)
    for slot in range(pairs.row_at.shape[0]):
        pairs.row_at[slot] = 0
    for row in range(pairs.count):
        pairs.row_at[slot_of(pairs, pairs.i[row], pairs.j[row], pairs.joint[row])] = row + 1


OF_PAIRS = (book_pairs, repeat_pairs, settle_pairs, begin_pairs, list_pairs)  # defined: of a run that keeps them


def with_room(before: Pairs, n_p: int, d: int) -> Pairs:
    """The same pairs, with room for n_p of them."""
    pairs = new(Pairs, n_p=n_p, d=d)
    keep_rows(before, pairs)
    list_pairs(pairs.address)
    return pairs


def exchanged(pairs: Pairs) -> dict[str, np.ndarray]:
    """What each pair exchanged since the record before, in the order of (i, j, joint)."""
    settle_pairs(pairs.address)
    rows, d = np.flatnonzero(pairs.steps[: int(pairs.count)]), pairs.now.shape[1] - len(PAIR_WORKS)
    keys = [getattr(pairs, name)[rows] for name in ("i", "j", "joint")]
    order = np.lexsort(keys[::-1])
    rows = rows[order]
    sums = pairs.total[rows] + pairs.times[rows, None] * pairs.last[rows]
    found = dict(zip(("i", "j", "joint"), (key[order] for key in keys), strict=True))
    return found | {"P": sums[:, :d]} | {name: sums[:, d + k] for k, name in enumerate(PAIR_WORKS)}
