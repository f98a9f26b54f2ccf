"""A contact that wanders over its bodies is held without loss: its rows turn within a step.

A contact that was held in the step before, gamma_0 = 0, and is found in the middle of this one, has the rows J of that
place. With J v_1 = 0 its impulse would do the work P.J v_0/2, of first order, for J v_0 is what the rows have turned by
since. As of joints (joints.py) that is asked for, so that the work is none:

    J v_1 + turn = 0,    turn = dt/(dt + dt_before) (J v_0 - J_before v_0),    P.J (v_0 + v_1) = P.(gamma_0 + gamma_1)

J_before are the rows in the middle of the step before, so turn is what they turn by in half a step; of it follow the
velocities of the contact at the ends of the step, gamma_0 = J v_0 - turn and gamma_1 = J v_1 + turn. What turns ever
more slowly would gain by that, by dt^2: turn is at least J v_0, so that gamma_0 <= 0 and nothing is gained. The
tangents turn likewise. The gap at the beginning, from that of the middle, bends by dt turn/4. With 1/2 for the weight
of both steps, Euler's disc takes ten times as many of them for a tolerance of 1e-3 (controlled.py).

A contact without an impulse before, of other features, or that ran farther over a body than TURNED of its arm has no
rows before. Nothing turns in an island in which a contact is about to land, for that moves by v_1, nor in a heap. A
contact that was found at the beginning of its step, after a landing, approaches by what turned in that, which is no
landing: up to ``slack`` its bodies are held from the next step on.
Equations: docs/theory/scenes.md, (7).
"""

from __future__ import annotations

from nonsmooth.contact.network.joint import is_contact
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.beside import is_in_the_middle
from nonsmooth.integrators.assembly.bodies import Bodies, fall_of
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.integrators.assembly.project import EXACT_VELOCITY, NO_FALL, STILL, is_of_few, normal_velocity
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.scenes.detection import Found

OF_TURN = 2.0  # chosen: of turn, by which what is held may approach: after a step without turn it does by one of it
# chosen: times g dt, what gravity gives in a step: a turn that is none, below half of STILL, as of faces that are flush
# but for roundings; and an approach that turns alone may leave. A disc that wobbles turns its rows by 2 g dt
NO_TURN, MOST_FALLS = 3e-7, 8.0
ONE_PLACE = 1e-8  # chosen: of normals, and of an arm: points that are nearer are one
TURNED = 0.5  # chosen: of an arm, that a contact goes over its body in a step: an angle of half a radian


@kernel("void(int64, int64, int64, int64, float64, float64)")
def ask_of_wandering(bodies_at, found_at, contacts_at, network_at, dt, driven_in):
    """What contacts that were held ask beside their rows, in the plane or in space; ``driven_in`` [m/s]: an approach
    that leaves no penetration to speak of."""
    bodies, found = view(bodies_at, Bodies), view(found_at, Found)
    contacts, network = view(contacts_at, Contacts), view(network_at, Network)
    islands, contacts.half = network.islands, dt / (contacts.dt_before + dt)
    fall = fall_of(bodies, dt)
    for c in range(network.n_c):
        contacts.wander[c] = contacts.slack[c] = 0.0
        if is_of_few(network, c) and was_held(bodies, found, contacts, network, c):
            _, turn, size = turn_of_rows(bodies, contacts, network, c, 0)
            if abs(turn) > EXACT_VELOCITY * size + NO_TURN * fall:
                contacts.slack[c] = min(OF_TURN * abs(turn) + NO_FALL * fall, max(MOST_FALLS * fall, driven_in))
    for k in range(islands.count):
        begin, end = islands.contact_start[k], islands.contact_start[k + 1]
        share_rows(bodies, found, contacts, network, begin, end)
        if is_held_together(bodies, contacts, network, begin, end, dt):
            for at in range(begin, end):
                c = islands.contacts[at]
                if contacts.slack[c] > 0.0 and is_found_in_the_middle(bodies, network, c):
                    ask(bodies, found, contacts, network, c, dt)


@kernel
def share_rows(bodies, found, contacts, network, begin, end):
    """Of two contacts at one place, as on the ridge of two shapes, the one that had no impulse has the other's rows."""
    for at in range(begin, end):
        c = network.islands.contacts[at]
        if contacts.slack[c] > 0.0:
            for other in range(begin, end):
                e = network.islands.contacts[other]
                is_new = contacts.slack[e] == 0.0 and is_contact(network, e)
                if is_new and are_at_one_place(bodies, found, network, c, e):
                    contacts.held[e], contacts.slack[e] = contacts.held[c], contacts.slack[c]


@kernel
def are_at_one_place(bodies, found, network, c, e):
    """Whether two contacts of one body have one point and one normal."""
    if network.i[c] != network.i[e] and network.j[c] != network.j[e]:
        return False
    b, way, arm = network.i[c] if network.i[c] == network.i[e] else network.j[c], 0.0, 0.0
    for k in range(found.point.shape[1]):
        if abs(found.normal[c, k] - found.normal[e, k]) > ONE_PLACE:
            return False
        way += abs(found.point[c, k] - found.point[e, k])
        arm += abs(found.point[c, k] - bodies.motion.x[b, k])
    return way <= ONE_PLACE * arm


@kernel
def is_found_in_the_middle(bodies, network, c):
    """Whether both bodies of contact c are in the middle of the step."""
    return is_in_the_middle(bodies, network.i[c]) and is_in_the_middle(bodies, network.j[c])


@kernel
def is_held_together(bodies, contacts, network, begin, end, dt):
    """Whether no contact of an island is met on the free way of its bodies, but those that were held."""
    n, still = network.v.shape[1], STILL * fall_of(bodies, dt)
    for at in range(begin, end):
        c = network.islands.contacts[at]
        if not is_contact(network, c):
            continue
        if contacts.slack[c] > 0.0:
            start, turn, _ = turn_of_rows(bodies, contacts, network, c, 0)
            if start - turn < -contacts.slack[c]:
                return False
        elif normal_velocity(network, c, bodies.v_0, n)[0] < -still:
            if network.b[c, 0] + normal_velocity(network, c, bodies.v_free, n)[0] < 0.0:
                return False
    return True


@kernel
def was_held(bodies, found, contacts, network, c):
    """Whether contact c goes on with one that was pressed, of the same features."""
    at = contacts.held[c]
    if at < 0 or network.soft[c] != 0.0 or not is_contact(network, c):
        return False
    for side in range(2):
        b = network.i[c] if side == 0 else network.j[c]
        if bodies.motion.moves[b] == 0 and turns_or_gains(bodies, b):
            return False
        if bodies.motion.moves[b] == 1 and ran_far(bodies, found, contacts, c, b, side):
            return False
    return True


@kernel
def turns_or_gains(bodies, b):
    """Whether a guided body turns, or changes its velocity."""
    d = bodies.gravity.shape[0]
    for x in range(bodies.gain.shape[1]):
        if bodies.gain[b, x] != 0.0 or (x >= d and bodies.v_0[b, x] != 0.0):
            return True
    return False


@kernel
def ran_far(bodies, found, contacts, c, b, side):
    """Whether contact c has gone farther about the centre of body b, one of its sides, than TURNED of its arm."""
    far, arm, at = 0.0, 0.0, contacts.held[c]
    for k in range(found.point.shape[1]):
        now = found.point[c, k] - bodies.motion.x[b, k]
        before = contacts.arms_before[at, side, k]
        far += (now - before) * (now - before)
        arm += now * now
    return far > TURNED * TURNED * arm


@kernel
def turn_of_rows(bodies, contacts, network, c, row):
    """J v_0, what a row of contact c turns by in half a step, and the sum of the sizes of its terms."""
    start, size = row_velocity(network, c, row, bodies.v_0)
    return start, contacts.half * (start - contacts.gamma_before[contacts.held[c], row]), size


@kernel
def row_velocity(network, c, row, v):
    """J v of a row of contact c, and the sum of the sizes of its terms, by the difference of two velocities: the same,
    but for a rounding of that, however fast both bodies travel."""
    i, j, total, size = network.i[c], network.j[c], 0.0, 0.0
    for x in range(network.v.shape[1]):
        if x < network.b.shape[1]:  # J_i = -J_j
            part = network.J_j[c, row, x] * (v[j, x] - v[i, x])
        else:
            part = network.J_i[c, row, x] * v[i, x] + network.J_j[c, row, x] * v[j, x]
        total += part
        size += abs(part)
    return total, size


@kernel
def ask(bodies, found, contacts, network, c, dt):
    """turn of the rows of contact c; its gap."""
    for row in range(network.b.shape[1]):
        start, turn, size = turn_of_rows(bodies, contacts, network, c, row)
        if abs(turn) <= EXACT_VELOCITY * size:
            continue
        if row == 0:
            found.gap[c] += 0.25 * dt * turn
            turn = max(turn, start)
            is_met = found.gap[c] > dt * abs(turn)
            network.b[c, 0] = turn + (found.gap[c] / dt if is_met else 0.0)
            contacts.wander[c] = turn
        else:
            network.b[c, row] += turn
        network.turn[c, row] = turn


@kernel("void(int64, int64, int64, int64, float64)")
def note_held(bodies_at, found_at, contacts_at, network_at, dt):
    """J v_1 of the contacts of the step, and their arms."""
    bodies, found = view(bodies_at, Bodies), view(found_at, Found)
    contacts, network = view(contacts_at, Contacts), view(network_at, Network)
    contacts.dt_before = dt
    for at in range(contacts.n_before):
        c = contacts.row_before[at]
        i, j = network.i[c], network.j[c]
        for row in range(network.b.shape[1]):
            contacts.gamma_before[at, row], _ = row_velocity(network, c, row, network.v)
            contacts.arms_before[at, 0, row] = found.point[c, row] - bodies.x_0[i, row] - bodies.shift[i, row]
            contacts.arms_before[at, 1, row] = found.point[c, row] - bodies.x_0[j, row] - bodies.shift[j, row]
