"""Modes that hold although the forces found do without them: contacts that nothing parts, and that nothing moves.

A box that stands on the floor in a corner touches the wall: with and without forces there the acceleration is the same.
Of two planes that are nearly one, either carries a particle. Left open, such a contact penetrates by rounding, strikes,
and is left open again, without any time passing. What is held is the acceleration, not the forces: the contact is
closed where the contacts are redundant then and share an admissible load (rigid/redundant.py), and holds while they do.

So it is with friction. Of two feet of one body at rest the forces found may push one to its limit, which then slides
with the velocity zero for ever, and hold the other: both stick.
"""

from __future__ import annotations

from nonsmooth.contact.planar.enumerate import SAME_MOTION
from nonsmooth.contact.planar.forces import is_asked
from nonsmooth.errors import Status
from nonsmooth.integrators.rigid.modes import note_side
from nonsmooth.integrators.rigid.rates import rigid_rates
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import address
from nonsmooth.mechanics.system import UNILATERAL, ContactMode


@kernel
def close_idle(sys, t, n_k, contacts, touch, forces):
    """Close the contacts that the solution leaves free although they do not part, and hold those that it lets slide
    from rest although they do not move, where they are redundant.

    The acceleration is the same with them and without. Left open they would penetrate by rounding, and strike again.
    """
    for k in range(n_k):
        i = forces.work.closed[k]
        is_free = sys.kinds[i, 0] == UNILATERAL and contacts.mode[i] == ContactMode.OPEN
        starts_to_slide = contacts.mode[i] == ContactMode.SLIDE and forces.slip[k] == 0
        if touch.strikes[i] == 1 or not (is_free or starts_to_slide) or not is_asked(forces.island[k], n_k, forces):
            continue
        parts, moves, slip = relative_motion(sys, k, n_k, forces)
        if parts if is_free else moves:
            continue
        mode, direction, sign = contacts.mode[i], contacts.slip[i], contacts.sign[i]
        set_closed_mode(sys, i, slip if moves and forces.slip[k] == 0 else float(forces.slip[k]), contacts)
        if not may_share(sys, t, i, contacts, touch):
            contacts.mode[i], contacts.slip[i], contacts.sign[i] = mode, direction, sign


@kernel
def relative_motion(sys, k, n_k, forces):
    """gamma_N' and gamma_F' of a contact under the forces taken: (is it not zero, is it not zero, gamma_F')."""
    work = forces.work
    a, b = work.start[k], work.start[k + 1] - 1
    scale, parting, slip = 0.0, work.c[a], work.c[b] if sys.kinds[work.closed[k], 1] > 0 else 0.0
    for m in range(n_k):
        if forces.island[m] == forces.island[k]:
            for c in range(work.start[m], work.start[m + 1]):
                scale = max(scale, abs(work.c[c]))
                parting += work.G[a, c] * forces.taken[c]
                slip += work.G[b, c] * forces.taken[c] if sys.kinds[work.closed[k], 1] > 0 else 0.0
    return abs(parting) > SAME_MOTION * scale, abs(slip) > SAME_MOTION * scale, slip


@kernel
def close_island(sys, t, island, n_k, contacts, touch, forces):
    """Close all contacts of an island, if they are redundant and may share a load; tells whether they may.

    Rows that are nearly parallel or opposite are lost in G, by which forces were looked for.
    """
    last = -1
    for k in range(n_k):
        if forces.island[k] == island:
            last = forces.work.closed[k]
            set_closed_mode(sys, last, touch.gamma[last, 1] if touch.is_resting[last] == 0 else 0.0, contacts)
    return may_share(sys, t, last, contacts, touch)


@kernel
def set_closed_mode(sys, i, slip, contacts):
    """Give contact i the mode of a closed contact that slides in the direction of slip, or not at all."""
    contacts.sign[i], contacts.slip[i] = 1, 0
    contacts.mode[i] = ContactMode.LOCKED.value if sys.kinds[i, 1] == 0 else ContactMode.STICK.value
    if sys.kinds[i, 1] > 0 and slip != 0.0:
        contacts.mode[i], contacts.slip[i] = ContactMode.SLIDE.value, 1 if slip > 0.0 else -1


@kernel
def may_share(sys, t, i, contacts, touch):
    """Whether the island of contact i is redundant in its modes, or nearly so, and admissible forces go with them."""
    n = sys.n
    for j in range(n):
        touch.x[j], touch.x[n + j] = contacts.q[j], contacts.u[j]
    status = rigid_rates(address(sys), address(contacts), t, touch.x, touch.rates)
    for k in range(sys.n_c):
        note_side(sys, k, contacts)
    return status == Status.RUNNING and contacts.is_admissible[i] == 1
