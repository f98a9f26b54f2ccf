"""Islands of a network: contacts that are joined by bodies which can move.

Contacts of one body that moves are coupled, and a body that does not move (M^-1 = 0) couples nothing: what stands on
the same floor is apart. An island has its own solutions, so it is solved by itself.

Disjoint sets with path halving; the root of a set is its body of the lowest number. Islands are numbered in the order
of their first contacts, and contacts and bodies keep their order within one: an island is solved with the same bits
whatever else there is. Source: Tarjan and van Leeuwen, J. ACM 31 (1984) 245-281.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints


class Islands(Block):
    """Contacts and bodies grouped by islands, and what was found of each."""

    count: int
    contacts: Array[Ints, "m"]  # rows of contacts, island by island; without those of two bodies that cannot move
    contact_start: Array[Ints, "n_b + 1"]  # island k has contacts[contact_start[k] : contact_start[k + 1]]
    bodies: Array[Ints, "n_b"]  # that can move and are touched, island by island
    body_start: Array[Ints, "n_b + 1"]
    parent: Array[Ints, "n_b"]  # in its set, at the end its root; -1 of a body that cannot move
    of: Array[Ints, "n_b"]  # island of a body, -1 of one that cannot move or is not touched
    F: Array[Floats, "n_b"]  # sums of squares [N^2 s^2]: of the natural map,
    P: Array[Floats, "n_b"]  # and of the impulses
    residual: Array[Floats, "n_b"]
    below: Array[Floats, "n_b"]  # the rho of the light contacts whose it is; inf: of all
    rung: Array[Ints, "n_b"]  # how far up the ladder of ``solve`` an island was taken
    sweeps: Array[Ints, "n_b"]
    factors: Array[Ints, "n_b"]
    owner: Array[Ints, "n_b"]  # which of several threads solves it (``parallel``)
    is_met: Array[Ints, "n_b"]  # whether the residual is within the tolerance, or to ``solve`` less, where it has to


@kernel
def find_islands(network, n):
    """Group the contacts in use, and the bodies that they touch."""
    islands = network.islands
    join_bodies(network, n)
    number_islands(network)
    group_contacts(network)
    group_bodies(islands)


@kernel
def can_move(M_inv, body, n):
    """Whether an impulse can move a body."""
    for x in range(n):
        if M_inv[body, x, x] > 0.0:
            return True
    return False


@kernel
def root_of(parent, body):
    """The root of the set of a body; every second body on the way is hung one higher."""
    while parent[body] != body:
        parent[body] = parent[parent[body]]
        body = parent[body]
    return body


@kernel
def join_bodies(network, n):
    """The disjoint sets of the bodies that can move; in the end every parent is a root."""
    parent, of = network.islands.parent, network.islands.of
    for body in range(parent.shape[0]):
        parent[body] = body if can_move(network.M_inv, body, n) else -1
        of[body] = -1
    for c in range(network.n_c):
        i, j = network.i[c], network.j[c]
        if parent[i] >= 0 and parent[j] >= 0:
            a, b = root_of(parent, i), root_of(parent, j)
            if a != b:
                parent[max(a, b)] = min(a, b)
    for body in range(parent.shape[0]):
        if parent[body] >= 0:
            parent[body] = root_of(parent, body)


@kernel
def root_of_contact(network, c):
    """The root of its bodies, -1 where none can move."""
    return max(network.islands.parent[network.i[c]], network.islands.parent[network.j[c]])


@kernel
def number_islands(network):
    """Number the sets that are touched, and count their contacts, to contact_start[k + 1]."""
    islands = network.islands
    islands.count = 0
    islands.contact_start[0] = 0
    for c in range(network.n_c):
        root = root_of_contact(network, c)
        if root < 0:
            continue
        if islands.of[root] < 0:
            islands.of[root] = islands.count
            forget_island(islands, islands.count)
            islands.count += 1
            islands.contact_start[islands.count] = 0
        islands.contact_start[islands.of[root] + 1] += 1


@kernel
def forget_island(islands, k):
    """Nothing is known of island k."""
    islands.residual[k] = 1.0
    islands.rung[k] = islands.sweeps[k] = islands.factors[k] = islands.is_met[k] = islands.owner[k] = 0


@kernel
def group_contacts(network):
    """Put each contact in its place. body_start counts how many of an island have come."""
    islands = network.islands
    for k in range(islands.count):
        islands.contact_start[k + 1] += islands.contact_start[k]
        islands.body_start[k] = islands.contact_start[k]
    for c in range(network.n_c):
        root = root_of_contact(network, c)
        if root >= 0:
            k = islands.of[root]
            islands.contacts[islands.body_start[k]] = c
            islands.body_start[k] += 1


@kernel
def group_bodies(islands):
    """Put each body that is touched in its place."""
    start, of, parent = islands.body_start, islands.of, islands.parent
    for k in range(islands.count + 1):
        start[k] = 0
    for body in range(parent.shape[0]):
        if parent[body] >= 0:
            of[body] = of[parent[body]]
            if of[body] >= 0:
                start[of[body] + 1] += 1
    for k in range(islands.count):
        start[k + 1] += start[k]
    for body in range(parent.shape[0]):
        if of[body] >= 0:
            islands.bodies[start[of[body]]] = body
            start[of[body]] += 1
    for k in range(islands.count, 0, -1):
        start[k] = start[k - 1]
    start[0] = 0
