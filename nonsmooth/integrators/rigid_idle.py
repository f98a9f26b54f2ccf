"""Contacts that are closed although the forces found do without them, because nothing parts them.

A box that stands on the floor in a corner touches the wall: with and without forces there the acceleration is the same.
Of two planes that are nearly one, either carries a particle. Left open, such a contact penetrates by rounding, strikes,
and is left open again, without any time passing. What is held is the acceleration, not the forces: the contact is
closed where the contacts are redundant then and share an admissible load (rigid_redundant.py), and holds while they do.
"""

from __future__ import annotations

from nonsmooth.blocks import address
from nonsmooth.contact_solvers.modes import SAME_MOTION
from nonsmooth.errors import Status
from nonsmooth.integrators.rigid_forces import rigid_rates
from nonsmooth.integrators.rigid_modes import IS_ADMISSIBLE, N_U
from nonsmooth.jit import kernel
from nonsmooth.system import UNILATERAL, ContactMode


@kernel
def close_idle(model, p, t, take, n_k, contacts, touch, forces):
    """Close the contacts that the solution leaves free although they do not part, where they are redundant.

    The acceleration is the same with them and without. Left open they would penetrate by rounding, and strike again.
    """
    work, la = forces.work, forces.la[take]
    r = work.start[n_k]
    scale = 0.0
    for a in range(r):
        scale = max(scale, abs(work.c[a]))
    for k in range(n_k):
        i, a, b = work.closed[k], work.start[k], work.start[k + 1] - 1
        if contacts.kinds[i, 0] != UNILATERAL or contacts.mode[i] != ContactMode.OPEN:
            continue
        parting, slip = work.c[a], work.c[b] if b > a else 0.0
        for c in range(r):
            parting += work.G[a, c] * la[c]
            slip += work.G[b, c] * la[c] if b > a else 0.0
        if abs(parting) > SAME_MOTION * scale:
            continue
        if forces.slip[k] != 0 or abs(slip) <= SAME_MOTION * scale:
            slip = float(forces.slip[k])
        close(i, slip, contacts)
        if not may_share(model, p, t, contacts, touch):
            contacts.mode[i], contacts.slip[i] = ContactMode.OPEN.value, 0


@kernel
def close_all(model, p, t, contacts, touch):
    """Close all contacts that touch, if they are redundant and may share a load; tells whether they may.

    Rows that are nearly parallel or opposite are lost in G, by which forces were looked for.
    """
    for i in range(contacts.kinds.shape[0]):
        if touch.is_touching[i] == 1:
            close(i, touch.gamma[i, 1] if touch.is_resting[i] == 0 else 0.0, contacts)
    return may_share(model, p, t, contacts, touch)


@kernel
def close(i, slip, contacts):
    """Give contact i the mode of a closed contact that slides in the direction of slip, or not at all."""
    contacts.sign[i], contacts.slip[i] = 1, 0
    contacts.mode[i] = ContactMode.LOCKED.value if contacts.kinds[i, 1] == 0 else ContactMode.STICK.value
    if contacts.kinds[i, 1] > 0 and slip != 0.0:
        contacts.mode[i], contacts.slip[i] = ContactMode.SLIDE.value, 1 if slip > 0.0 else -1


@kernel
def may_share(model, p, t, contacts, touch):
    """Whether the contacts are redundant in their modes, or nearly so, and admissible forces go with them."""
    n = contacts.facts[N_U]
    for j in range(n):
        touch.x[j], touch.x[n + j] = contacts.q[j], contacts.u[j]
    status = rigid_rates(model, p, address(contacts), t, touch.x, touch.rates)
    return status == Status.RUNNING and contacts.facts[IS_ADMISSIBLE] == 1
