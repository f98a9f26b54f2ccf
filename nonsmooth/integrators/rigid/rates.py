"""The forces of rigid contacts in their modes, the rates of motion, and what ends a mode.

Event functions end a mode:

    CLOSURE     g_N of an open contact, la_N of a closed one (unilateral)
    FRICTION    s gamma_F of sliding, unless mu = 0
    SIGN        sigma la_N of a bilateral contact that slides
    FORWARD     mu sigma la_N + la_F of sticking: where it falls through zero the contact slides with gamma_F > 0
    BACKWARD    mu sigma la_N - la_F of sticking: with gamma_F < 0
    UNIQUE      p' of a loaded bilateral contact that slides alone: where it falls through zero a second force fits
    REGULAR     det A over that without friction, of the island where it is least: a slide whose p falls to zero has
                lost its force (Génot–Brogliato point)

mu |la_N| - |la_F| is the less of FORWARD and BACKWARD, and has kinks at la_N = 0 and la_F = 0, which no polynomial
follows: a bilateral force that passes zero twice within a step would let go unseen. With the sign sigma that la_N had
where sticking began both are smooth, and one falls before la_N passes zero, if anything pulls.

Contacts that G does not couple have their forces island by island. Of redundant contacts no single force is known:
their modes last while any share of the load is admissible, and what
ends then is CLOSURE or FRICTION of those that the least forces break. The trailing components of the state are the
gaps, which are evaluated and not integrated, the impulses and the energy ledger.

Source: Pfeiffer, Glocker (1996), chapter 5; Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653.
"""

from __future__ import annotations

import math

from nonsmooth.errors import Status
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.integrators.radau.stages import RATES
from nonsmooth.integrators.records import CLOSURE, FRICTION, N_FUNCTIONS, SIGN
from nonsmooth.integrators.rigid.census import slides_alone, uniqueness
from nonsmooth.integrators.rigid.modes import (
    BACKWARD,
    DISTINCT_ROWS,
    FORWARD,
    SINGULAR_SLIDE,
    UNIQUE,
    RigidContacts,
    closed_problem,
    decompose_alone,
    decompose_both,
    find_ratios,
    list_equations_of,
    list_islands,
    regularise,
    rounded_length,
    small_speed,
    solve_equations,
)
from nonsmooth.integrators.rigid.redundant import share_load
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.laws import depends_on_speed, static_coefficient
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import BILATERAL, GAP, GIVEN_FORCE, UNILATERAL, ContactMode
from nonsmooth.numerics.rounding import rounded_sum, rounding_of_sum

# An event function that falls at once falls to this, which no slope is measured from, and it is its own tolerance with
# the other sign: what an event has not mended is met again.
BROKEN_FORCE = -rounding_of_sum(8, 1.0)


@kernel("int64(int64, float64, float64[::1], int64)", short_loops=True)
def rigid_forces(sys_at, t, x, contacts_at):
    """The forces at a state, for the rates and the event functions; returns a Status."""
    return find_forces(view(sys_at, Sys), t, x, view(contacts_at, RigidContacts))


@kernel(RATES, short_loops=True)
def rigid_rates(sys_at, contacts_at, t, x, out):
    """x' with x = (q, u, g_N, P_N, P_F, works); a radau ``rates`` function. Returns a Status."""
    sys = view(sys_at, Sys)
    contacts = view(contacts_at, RigidContacts)
    work, la, gamma = contacts.work, contacts.la, contacts.gamma
    n, n_c = sys.n, sys.n_c
    status = rigid_forces(sys_at, t, x, contacts_at)
    if status != Status.RUNNING:
        return status
    total = 0.0
    force, friction, normal, surface = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        out[i] = contacts.u[i]
        out[n + i] = work.du[i]
        total += 0.0 * work.du[i]
        force += work.h[i] * contacts.u[i]
    for i in range(n_c):
        out[2 * n + i] = 0.0
        out[2 * n + n_c + i] = la[i, 0]
        out[2 * n + 2 * n_c + i] = la[i, 1]
        friction += la[i, 1] * gamma[i, 1]
        if sys.kinds[i, 0] != GIVEN_FORCE:
            normal += la[i, 0] * gamma[i, 0]
            surface -= la[i, 0] * work.w_N[i]
        if sys.kinds[i, 1] > 0:
            surface -= la[i, 1] * work.w_F[i, 0]
    end = 2 * n + 3 * n_c
    out[end], out[end + 1], out[end + 2], out[end + 3] = force, friction, normal, surface
    return Status.RUNNING.value if total == 0.0 else Status.NOT_FINITE.value


@kernel(RATES, short_loops=True)
def rigid_events(sys_at, contacts_at, t, x, out):
    """The event functions and their tolerances, an ``event_values`` function; one that does not apply is 1."""
    sys = view(sys_at, Sys)
    contacts = view(contacts_at, RigidContacts)
    contacts.facts.margin_asked = contacts.facts.follows_margin
    status = rigid_forces(sys_at, t, x, contacts_at)
    contacts.facts.margin_asked = 0
    if status != Status.RUNNING:
        return status
    work, la = contacts.work, contacts.la
    n, n_c = sys.n, sys.n_c
    E = N_FUNCTIONS * n_c + 1
    if sys.has & (1 << GAP) and not evaluate(sys, GAP, t, contacts.q, contacts.u, work.g_N):
        return Status.NOT_FINITE.value
    speed, length = small_speed(sys, contacts), rounded_length(n, contacts)
    for i in range(n_c):
        e = N_FUNCTIONS * i
        for m in range(N_FUNCTIONS):
            out[e + m] = 1.0
            out[E + e + m] = 0.0
        kind, mode = sys.kinds[i, 0], contacts.mode[i]
        force = contacts.numbers.rtol * contacts.size[i] if contacts.is_shared[i] == 0 else BROKEN_FORCE
        if kind == UNILATERAL:
            out[e + CLOSURE] = work.g_N[i] if mode == ContactMode.OPEN else force_function(la[i, 0], i, contacts)
            out[E + e + CLOSURE] = length if mode == ContactMode.OPEN else force
        if mode == ContactMode.SLIDE:
            if contacts.ratio[i] != 0.0 or depends_on_speed(sys.laws, i):
                out[e + FRICTION] = contacts.slip[i] * contacts.gamma[i, 1]
                out[E + e + FRICTION] = speed
            if kind == BILATERAL:
                if contacts.several[i] == 0 and la[i, 0] != 0.0 and slides_alone(sys, i, contacts):
                    out[e + UNIQUE] = uniqueness(i, contacts)
                out[e + SIGN] = force_function(contacts.sign[i] * la[i, 0], i, contacts)
                out[E + e + SIGN] = force
        elif mode == ContactMode.STICK:
            most = static_coefficient(sys.laws, i) * pressing_force(la[i, 0], la[i, 1], i, contacts)
            out[e + FORWARD] = force_function(most + la[i, 1], i, contacts)
            out[e + BACKWARD] = force_function(most - la[i, 1], i, contacts)
            out[E + e + FORWARD] = out[E + e + BACKWARD] = force
    out[E - 1] = contacts.numbers.determinant - SINGULAR_SLIDE
    out[2 * E - 1] = 0.0
    return Status.RUNNING.value


@kernel
def pressing_force(la_N, la_F, i, contacts):
    """|la_N| of a contact that sticks: sigma la_N, which is smooth, unless nothing pulls or no single force is known.

    What nothing pulls at does not let go where la_N passes zero.
    """
    return abs(la_N) if la_F == 0.0 or contacts.is_shared[i] == 1 else contacts.sign[i] * la_N


@kernel
def force_function(value, i, contacts):
    """The event function of a force: of redundant contacts it falls at once where no share is admissible any more."""
    if contacts.is_shared[i] == 0:
        return value
    if contacts.is_admissible[i] == 1 or value >= 0.0:
        return abs(contacts.margin[i])
    return min(BROKEN_FORCE, contacts.margin[i])


@kernel
def find_forces(sys, t, x, contacts):
    """contacts.la, contacts.gamma and work.du = u' at a state; returns a Status."""
    la, n_c = contacts.la, sys.n_c
    status, n_k = closed_problem(sys, t, x, contacts)
    if status != Status.RUNNING:
        return status
    contacts.numbers.determinant = 1.0
    for i in range(n_c):
        la[i, 0], la[i, 1] = 0.0, 0.0
    if n_k == 0:
        return Status.RUNNING
    if not find_ratios(sys, n_k, contacts):
        return Status.NEGATIVE_FRICTION
    least = math.inf
    for island in range(list_islands(sys, n_k, contacts)):
        find_forces_of(sys, island, n_k, contacts)
        least = min(least, contacts.numbers.determinant)
    contacts.numbers.determinant = least
    add_forces(sys, n_k, contacts)
    return Status.RUNNING


@kernel
def find_forces_of(sys, island, n_k, contacts):
    """The forces of one island, and what is known of them."""
    la = contacts.la
    for e in range(solve_island(sys, island, n_k, True, contacts)):
        i = contacts.contact[e]
        la[i, contacts.part[e]] = contacts.z[e]
        if contacts.part[e] == 0 and contacts.mode[i] == ContactMode.SLIDE:
            la[i, 1] = contacts.ratio[i] * contacts.z[e]


@kernel
def solve_island(sys, island, n_k, asks_determinant, contacts):
    """The equations of one island, with the friction of given normal forces in contacts.la: their number, what solves
    them in contacts.z, and what is known of that for each contact, its determinant where that is asked for."""
    work, facts, kinds, la = contacts.work, contacts.facts, sys.kinds, contacts.la
    facts.is_shared, facts.is_admissible, contacts.numbers.margin = 0, 0, 1.0
    m = list_equations_of(sys, island, n_k, contacts)
    for e in range(m):
        a = contacts.row[e]
        contacts.b[e] = -work.c[a]
        for k in range(n_k):
            i = work.closed[k]
            if kinds[i, 0] == GIVEN_FORCE:
                contacts.b[e] -= work.G[a, work.start[k]] * la[i, 1]
    smallest = decompose_both(m, contacts) if asks_determinant else decompose_alone(m, True, contacts)
    if smallest < DISTINCT_ROWS and m > 1:
        share(sys, m, contacts)
    else:
        if smallest == 0.0:
            regularise(m, contacts)
        solve_equations(m, contacts)
    size = 0
    for k in range(n_k):
        if contacts.island[k] == island:
            i = work.closed[k]
            contacts.determinant[i] = contacts.numbers.determinant
            contacts.is_shared[i], contacts.is_admissible[i] = facts.is_shared, facts.is_admissible
            contacts.margin[i] = contacts.numbers.margin
            contacts.is_alone[i] = 1
            size += 1
    for k in range(n_k):
        if contacts.island[k] == island and size > 1:
            contacts.is_alone[work.closed[k]] = 0
    return m


@rare_kernel
def share(sys, m, contacts):
    """The share of the load of redundant contacts, from a guess where it cannot do without: that tells the sign of a
    bilateral force that sticks, and stays where there are more rows than are shared."""
    needs_guess = m > contacts.redundant.planar.family.B.shape[0]
    for e in range(m):
        i = contacts.contact[e]
        needs_guess = needs_guess or (sys.kinds[i, 0] == BILATERAL and contacts.mode[i] == ContactMode.STICK)
    if needs_guess:
        regularise(m, contacts)
        solve_equations(m, contacts)
    share_load(address(sys), m, address(contacts))


@kernel
def add_forces(sys, n_k, contacts):
    """work.du += X^T la, what cancels to rounding set to exactly 0, so that rest is rest for ever; and the sizes of the
    terms that each force is the sum of."""
    n = sys.n
    work, la = contacts.work, contacts.la
    for k in range(n_k):
        i, a = work.closed[k], work.start[k]
        contacts.size[i] = abs(la[i, 0]) + abs(work.c[a]) / work.G[a, a]
    for j in range(n):
        total, size = work.du[j], abs(work.du[j])
        for k in range(n_k):
            i = work.closed[k]
            first = 0 if sys.kinds[i, 0] != GIVEN_FORCE else 1
            for a in range(work.start[k], work.start[k + 1]):
                part = work.X[a, j] * la[i, a - work.start[k] + first]
                total += part
                size += abs(part)
        work.du[j] = (
            0.0 if abs(total) <= rounded_sum(VELOCITY_ROUNDINGS, size) < math.inf else total
        )  # what is not finite stays
