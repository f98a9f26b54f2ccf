"""Adhesion: a contact that is closed stays closed up to a pull of F, and its friction is that of what it presses and F.

    0 <= g_N  _|_  P_N + F dt >= 0,    |P_F| <= mu (P_N + F dt)

With P' = P + F dt e_N these are the laws of a contact without adhesion, whose bodies F also pulls together:

    v = v_free - M^-1 J_N^T F dt + M^-1 J^T P'

so the free velocities of a step are those with the pull of its closed contacts, and solvers know nothing of it. P' is
what goes on from step to step, what rolling friction is in proportion to, and what is recorded of contacts, whose modes
it tells; the works and what pairs exchange are those of P. F acts at each contact point that is closed at the beginning
of the step, or was pressed in the one before and is no farther apart than what its bodies turn by; where P' = 0 it
opens, and F is gone. To separate two bodies takes no energy but that of F over the way of one step, which goes to 0
with it. In an impact there is none: F is finite.
Source: Raous, Cangemi and Cocou, *Comput. Methods Appl. Mech. Eng.* 177 (1999) 383-399 (adhesion, unilateral contact
and friction; this is the limit in which to separate takes no energy).
"""

from __future__ import annotations

from nonsmooth.contact.network.joint import is_contact
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.book import STEP_WORK, Ledger, book_contact, is_of_step
from nonsmooth.integrators.assembly.contacts import Contacts, Surfaces
from nonsmooth.integrators.assembly.pairs import CONTACT, Pairs, add_impulse, row_in_step
from nonsmooth.integrators.assembly.project import EXACT_VELOCITY
from nonsmooth.integrators.assembly.rolling import lever_of
from nonsmooth.integrators.assembly.wandering import row_velocity
from nonsmooth.integrators.records import NORMAL_WORK, SURFACE_WORK
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.scenes.detection import Found
from nonsmooth.scenes.shape_rows import Shapes

STILL_NEAR = 1e-3  # chosen: of the reach of the smaller body: a gap over which what was pressed still adheres
# chosen: of such a gap, that is closed in a step: two discs that begin to turn about one another open by a twentieth of
# r (omega dt)^2, and to close that at once asks for a twentieth of F
DRAWN_SHARE = 0.01


@kernel("void(int64, int64, int64, int64, int64, int64, float64)")
def pull_together(bodies_at, shapes_at, surfaces_at, found_at, contacts_at, network_at, dt):
    """Let what adheres pull its bodies together, of the rows of a step, which are prepared."""
    bodies, shapes, surfaces = view(bodies_at, Bodies), view(shapes_at, Shapes), view(surfaces_at, Surfaces)
    found, contacts, network = view(found_at, Found), view(contacts_at, Contacts), view(network_at, Network)
    for c in range(network.n_c):
        contacts.pull[c] = 0.0
        if not is_contact(network, c):
            continue
        F = surfaces.adhesion[surfaces.material[found.shape_i[c]], surfaces.material[found.shape_j[c]]]
        if F > 0.0 and adheres(bodies, shapes, found, network, c):
            contacts.pull[c] = F * dt
            ask_to_stay(bodies, found, contacts, network, c, dt)
            for x in range(network.v.shape[1]):
                network.v_free[network.i[c], x] -= network.Y_i[c, 0, x] * F * dt
                network.v_free[network.j[c], x] -= network.Y_j[c, 0, x] * F * dt
    for b in range(network.v.shape[0]):
        for x in range(network.v.shape[1]):
            network.v[b, x] = network.v_free[b, x]


@kernel
def ask_to_stay(bodies, found, contacts, network, c, dt):
    """What contact c asks for, which is closed: its bodies part at the beginning of the step by what its rows turn by
    until their middle alone, and by as much with the other sign at its end (wandering.py)."""
    start, size = row_velocity(network, c, 0, bodies.v_0)
    if start > EXACT_VELOCITY * size:
        network.turn[c, 0] = network.b[c, 0] = contacts.wander[c] = start
    if found.gap[c] > 0.0:
        network.b[c, 0] = network.turn[c, 0] + DRAWN_SHARE * found.gap[c] / dt


@kernel
def adheres(bodies, shapes, found, network, c):
    """Whether contact c is closed, or was and is still near."""
    was_pressed = network.P[c, 0] > 0.0
    return found.gap[c] <= (STILL_NEAR * lever_of(bodies, shapes, found, network, c) if was_pressed else 0.0)


@kernel("void(int64, int64, int64, int64, int64)")
def book_pulls(bodies_at, contacts_at, network_at, pairs_at, ledger_at):
    """Book what adhesion does in a step, after its contacts and its pairs."""
    bodies, contacts, network = view(bodies_at, Bodies), view(contacts_at, Contacts), view(network_at, Network)
    pairs, work, d = view(pairs_at, Pairs), view(ledger_at, Ledger).work, bodies.gravity.shape[0]
    for c in range(network.n_c):
        if not (is_contact(network, c) and contacts.pull[c] > 0.0):
            continue
        is_held, P_N = is_of_step(contacts, network, c), network.P[c, 0]
        P_1, P_2 = network.P[c, 1], network.P[c, d - 1]
        network.P[c, 0], network.P[c, 1], network.P[c, d - 1] = -contacts.pull[c], 0.0, 0.0
        normal, _, surface = book_contact(bodies, network, c, bodies.v_0, d, 3 * (d - 1))
        if pairs.is_asked == 1:
            at = row_in_step(pairs, network.i[c], network.j[c], CONTACT)
            add_impulse(pairs, at, network.J_j, network.P, c, d)
            pairs.now[at, d] += normal
            pairs.now[at, d + 2] += surface
        network.P[c, 0], network.P[c, 1], network.P[c, d - 1] = P_N, P_1, P_2
        work[NORMAL_WORK] += normal
        work[SURFACE_WORK] += surface
        if is_held:
            work[STEP_WORK] += normal
