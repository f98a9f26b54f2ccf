"""Bodies that are struck by several others at once: the rebound decides them together, which is one answer of many.

The reason is that of integrators/moreau_jean/struck_together.py. The contacts of one pair of bodies, as the corners of
a box on a floor, have one normal and one e: they are one impact of this pair. A body that takes impulses from two
others in a rebound, one of which it rebounds from, is between several; what a joint gives it is no blow.
"""

from __future__ import annotations

from nonsmooth.contact.network.joint import is_contact, is_joint
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view

LOADED = 1e-7  # chosen: of the largest impulse of a rebound: less is what the tolerance of its problem leaves
NOBODY, SEVERAL = -1, -2  # code: in the place of the one other body that gives a body impulses


@kernel
def note_together(places, counts):
    """Count a rebound in which a moving body has impulses of several others; keep the first one's body and step."""
    bodies, contacts = view(places.bodies, Bodies), view(places.contacts, Contacts)
    network = view(places.network, Network)
    for b in range(bodies.partner.shape[0]):
        bodies.partner[b] = NOBODY
    least = 0.0
    for c in range(network.n_c):
        if not is_joint(network, c):
            least = max(least, LOADED * network.P[c, 0])
    for c in range(network.n_c):
        if network.P[c, 0] > least and is_contact(network, c):
            meet(network.i[c], network.j[c], bodies.partner)
            meet(network.j[c], network.i[c], bodies.partner)
    for c in range(network.n_c):
        if contacts.impact[c] == 1 and network.P[c, 0] > least:
            for b in (network.i[c], network.j[c]):
                if bodies.motion.moves[b] == 1 and bodies.partner[b] == SEVERAL:
                    note(b, counts)
                    return


@kernel
def meet(b, other, partner):
    """Body b takes an impulse from another."""
    if partner[b] == NOBODY:
        partner[b] = other
    elif partner[b] != other:
        partner[b] = SEVERAL


@kernel
def note(b, counts):
    """Count a rebound that struck body b together with others."""
    if counts.together == 0:
        counts.first_together, counts.struck = counts.steps, b
    counts.together += 1
