"""The energy of a step, exact for its velocities: what each impulse does goes with the mean of those it changes.

    T_1 - T_0 = dt m g.vbar + sum P.(gammabar - w),    vbar = (v_0 + v_1)/2

w is what fixed and guided bodies and running surfaces add to gamma. Free rotation keeps the energy, so a spatial body
has its angular velocity after that in the place of omega_0. What the bodies are moved beside dt vbar, with theta = 1 or
out of a penetration, is work of gravity that no velocity shows: it has a column of its own. The work of joints, which
is none but for what the method errs by, stands with that of normals.

Of that, ``STEP_WORK`` is what the step itself takes or gives: all of joints, and of contacts that were closed and
pressed in the step before too, to which no law of impact applies. It is 0 for what does not turn, and of second order
for what is held as it wanders (wandering.py).
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.contact.network.joint import acts, is_joint, is_powered
from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import Contacts, keep_impulses
from nonsmooth.integrators.assembly.project import Moves
from nonsmooth.integrators.records import (
    FORCE_WORK,
    FRICTION_WORK,
    N_LEDGER,
    NORMAL_WORK,
    PROJECTION_WORK,
    SURFACE_WORK,
)
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, view
from nonsmooth.scenes.detection import Found

STEP_WORK = N_LEDGER  # defined: column of the ledger of a scene, behind those of systems
N_SCENE_LEDGER = N_LEDGER + 1  # derived: columns of it


class Ledger(Block):
    """Works since the start [J], in the columns of integrators/records.py, and that of the steps."""

    work: Array[Floats, N_SCENE_LEDGER]
    before: Array[Floats, N_SCENE_LEDGER]  # at the beginning of the step
    landing: Array[Floats, N_SCENE_LEDGER]  # of the contacts of the step alone, after its free motion
    rebound: Array[Floats, N_SCENE_LEDGER]  # and of their rebound


@kernel
def book_contact(bodies, network, c, v_before, d, n):
    """Loss of contact c at the normal and by friction, and what its guided sides give."""
    i, j, moves = network.i[c], network.j[c], bodies.motion.moves
    normal, friction, surface = 0.0, 0.0, 0.0
    for row in range(d):
        P = network.P[c, row]
        if P == 0.0:
            continue
        own, given = 0.0, network.b[c, row] - network.turn[c, row] if row > 0 and not is_joint(network, c) else 0.0
        for x in range(n):
            part = 0.5 * network.J_i[c, row, x] * (v_before[i, x] + network.v[i, x])
            own += part if moves[i] == 1 else 0.0
            given += part if moves[i] == 0 else 0.0
            part = 0.5 * network.J_j[c, row, x] * (v_before[j, x] + network.v[j, x])
            own += part if moves[j] == 1 else 0.0
            given += part if moves[j] == 0 else 0.0
        if row == 0 or is_joint(network, c):
            normal += P * (own + given)
        else:
            friction += P * (own + given)
        surface -= P * given
    return normal, friction, surface


@kernel
def is_of_step(contacts, network, c):
    """Whether the work of the normal of contact c is none of a law: of a joint, or of what was closed and pressed."""
    at = contacts.held[c]
    return is_joint(network, c) or (network.P[c, 0] > 0.0 and at >= 0 and contacts.closing_before[at] == 0.0)


@kernel
def book_contacts(bodies, contacts, network, v_before, d, n, work, is_impact):
    """Book what the impulses of a contact problem do, from the velocities before it to those after; returns the sum of
    the sizes of these works."""
    size = 0.0
    for c in range(network.n_c):
        if acts(network, c):
            normal, friction, surface = book_contact(bodies, network, c, v_before, d, n)
            if is_powered(network, c):
                work[FORCE_WORK] += normal + friction + surface
                continue
            work[NORMAL_WORK] += normal
            if not is_impact and is_of_step(contacts, network, c):
                work[STEP_WORK] += normal
            work[FRICTION_WORK] += friction
            work[SURFACE_WORK] += surface
            size += abs(normal) + abs(friction)
    return size


@kernel
def book_forces(bodies, network, moves, dt, is_pushed, work):
    """The work of gravity and applied forces on the velocities, and on the corrections of places."""
    for b in range(bodies.mass.shape[0]):
        if bodies.motion.moves[b] == 1:
            for k in range(bodies.gravity.shape[0]):
                impulse = dt * (bodies.mass[b] * bodies.gravity[k] + bodies.load[b, k])
                mean = 0.5 * (bodies.v_0[b, k] + network.v[b, k])
                work[FORCE_WORK] += impulse * mean
                aside = bodies.v_move[b, k] - mean
                if is_pushed == 1:
                    aside += moves.push[b, k]
                work[PROJECTION_WORK] += impulse * aside
            d = bodies.gravity.shape[0]
            for x in range(d, network.v.shape[1]):  # in space the spin turns within the step
                mean = bodies.v_move[b, x] if d == 3 else 0.5 * (bodies.v_0[b, x] + network.v[b, x])
                work[FORCE_WORK] += dt * bodies.load[b, x] * mean


@kernel
def add_impulses(contacts, network, d, is_first):
    """The impulses of the step: those of its first problem, and of its impacts."""
    for c in range(network.n_c):
        for row in range(d):
            before = 0.0 if is_first else contacts.P[c, row]
            contacts.P[c, row] = before + network.P[c, row]


@kernel
def finish(bodies, network, n):
    """The velocities found become those of the state."""
    for b in range(network.v.shape[0]):
        for x in range(n):
            bodies.motion.v[b, x] = network.v[b, x]


@kernel
def book(bodies, found, contacts, network, moves, ledger, dt, is_pushed):
    """Book the solved problem of a step, and keep its impulses as the start of the next one."""
    d = bodies.gravity.shape[0]
    n = 3 * (d - 1)
    for column in range(N_SCENE_LEDGER):
        ledger.before[column] = ledger.work[column]
    book_contacts(bodies, contacts, network, bodies.v_0, d, n, ledger.work, False)
    book_forces(bodies, network, moves, dt, is_pushed, ledger.work)
    add_impulses(contacts, network, d, True)
    keep_impulses(bodies, found, network, d, contacts)
    finish(bodies, network, n)


@kernel("void(int64, int64, int64, int64, int64, int64, float64, int64)")
def book_step(bodies_at, found_at, contacts_at, network_at, moves_at, ledger_at, dt, is_pushed):
    """Book a step, in the plane or in space: once a step, its sizes need not be constants."""
    bodies, found, contacts = view(bodies_at, Bodies), view(found_at, Found), view(contacts_at, Contacts)
    network, moves, ledger = view(network_at, Network), view(moves_at, Moves), view(ledger_at, Ledger)
    book(bodies, found, contacts, network, moves, ledger, dt, is_pushed)


@kernel("void(int64, int64, int64, int64)")
def book_landing(bodies_at, contacts_at, network_at, ledger_at):
    """Book what the contacts of a step take from its free motion, before they rebound."""
    bodies, contacts = view(bodies_at, Bodies), view(contacts_at, Contacts)
    network, ledger = view(network_at, Network), view(ledger_at, Ledger)
    d = bodies.gravity.shape[0]
    for column in range(N_SCENE_LEDGER):
        ledger.landing[column] = 0.0
    book_contacts(bodies, contacts, network, network.v_free, d, 3 * (d - 1), ledger.landing, True)


@kernel("float64(int64, int64, int64, int64)")
def book_impact(bodies_at, contacts_at, network_at, ledger_at):
    """Book the impacts of a step; returns the sum of the sizes of their works [J]."""
    bodies, contacts = view(bodies_at, Bodies), view(contacts_at, Contacts)
    network, ledger = view(network_at, Network), view(ledger_at, Ledger)
    d = bodies.gravity.shape[0]
    n = 3 * (d - 1)
    for column in range(N_SCENE_LEDGER):
        ledger.rebound[column] = 0.0
    size = book_contacts(bodies, contacts, network, network.v_free, d, n, ledger.rebound, True)
    for column in range(N_SCENE_LEDGER):
        ledger.work[column] += ledger.rebound[column]
    add_impulses(contacts, network, d, False)
    finish(bodies, network, n)
    return size
