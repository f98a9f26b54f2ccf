"""When a compliant contact changes its mode, and to which: event functions and what follows each.

A contact has three functions that are positive while its mode lasts: its closure (lift-off, landing), its friction
(the end of sliding: gamma_F = 0; of sticking: |la_F| = mu |la_N|) and the sign of its force (bilateral contacts).
Where a slip ends the contact sticks if the force that holds it is within the limit, otherwise it slides on, or back.
Source: Leine, Nijmeijer, *Dynamics and Bifurcations of Non-Smooth Mechanical Systems* (2004), chapter 6.
"""

from __future__ import annotations

import math

from nonsmooth.errors import Status
from nonsmooth.integrators.penalty.law import NormalLaw, normal_force
from nonsmooth.integrators.penalty.rates import (
    C_N,
    OMEGA,
    Contacts,
    K,
    contact_rates,
    find_forces,
    share_friction,
    sticking_matrix,
)
from nonsmooth.integrators.radau.events import EVENT_ROUNDINGS
from nonsmooth.integrators.radau.stages import RATES
from nonsmooth.integrators.records import CLOSURE, FRICTION, N_FUNCTIONS, SIGN
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.laws import static_coefficient
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import GIVEN_FORCE, UNILATERAL, ContactMode
from nonsmooth.numerics.dense import cholesky_solve
from nonsmooth.numerics.rounding import rounded_sum

# event functions of a contact


@kernel(RATES, short_loops=True)
def contact_events(sys_at, contacts_at, t, x, out):
    """The event functions of every contact and their tolerances, an ``event_values`` function. Returns a Status.

    A function that does not apply to the mode is 1.
    """
    sys = view(sys_at, Sys)
    contacts = view(contacts_at, Contacts)
    status = find_forces(sys, t, x, contacts)
    if status != Status.RUNNING:
        return status
    n, n_c = sys.n, sys.n_c
    E = N_FUNCTIONS * n_c
    for i in range(n_c):
        e = N_FUNCTIONS * i
        speed = rounded_speed(sys, contacts)
        force = force_tolerance(sys, i, speed, contacts)
        for m in range(N_FUNCTIONS):
            out[e + m] = 1.0
            out[E + e + m] = 0.0
        kind, mode = sys.kinds[i, 0], contacts.mode[i]
        if kind == UNILATERAL:
            out[e + CLOSURE] = closure(i, x, n, contacts)
            out[E + e + CLOSURE] = force
        if sys.kinds[i, 1] > 0 and kind != GIVEN_FORCE and mode != ContactMode.OPEN:
            out[e + SIGN] = contacts.sign[i] * contacts.la[i, 0]
            out[E + e + SIGN] = force
            if kind == UNILATERAL and contacts.facts.law != NormalLaw.KELVIN_VOIGT:
                out[e + SIGN] = 1.0
        if mode == ContactMode.SLIDE and contacts.facts.is_regularised == 0:
            out[e + FRICTION] = contacts.slip[i] * contacts.gamma[i, 1]
            out[E + e + FRICTION] = speed
        elif mode == ContactMode.STICK:
            mu = static_coefficient(sys.laws, i)
            out[e + FRICTION] = mu * contacts.sign[i] * contacts.la[i, 0] - abs(contacts.la[i, 1])
            out[E + e + FRICTION] = (1.0 + mu) * force + contacts.numbers.rtol * abs(contacts.la[i, 1])
    return Status.RUNNING.value


@kernel
def closure(i, x, n, contacts):
    """Positive while contact i stays as it is: the force of a closed contact, minus that of an open one."""
    k, c, omega = contacts.constants[i, K], contacts.constants[i, C_N], contacts.constants[i, OMEGA]
    d, d_rate = -x[2 * n + i] / omega, -contacts.gamma[i, 0]
    law = contacts.facts.law
    force = normal_force(law, k, c, d, d_rate)
    if contacts.mode[i] != ContactMode.OPEN:
        return k * d if law == NormalLaw.KELVIN_VOIGT else force
    if law == NormalLaw.KELVIN_VOIGT:
        return -k * d
    return -min(k * d, force)


@kernel
def rounded_speed(sys, contacts):
    """What rounding leaves of a contact velocity that is zero [m/s]; times a stiff damper it is a force that counts.

    A velocity is resolved to atol + rtol |u|, as if nothing were slower than atol/rtol: where all comes to rest, what
    is left of a slide must not end and begin again with every rounding of its sign.
    """
    return rounded_sum(
        EVENT_ROUNDINGS, max(contacts.numbers.atol / contacts.numbers.rtol, fastest_velocity(sys, contacts))
    )


@kernel
def fastest_velocity(sys, contacts):
    """The largest of the velocities, of sliding and of the surfaces."""
    n = sys.n
    fastest = 0.0
    for j in range(n):
        fastest = max(fastest, abs(contacts.u[j]))
    for i in range(sys.n_c):
        fastest = max(fastest, abs(contacts.gamma[i, 1]))
        if sys.kinds[i, 1] > 0:
            fastest = max(fastest, abs(contacts.work.w_F[i, 0]))
    return fastest


@kernel
def force_tolerance(sys, i, speed, contacts):
    """A force that counts as zero [N]: what such a velocity makes in the damper and, after 1/omega, in the spring."""
    if sys.kinds[i, 0] == GIVEN_FORCE:
        return contacts.numbers.rtol * contacts.la[i, 0]
    k, c, omega = contacts.constants[i, K], contacts.constants[i, C_N], contacts.constants[i, OMEGA]
    return normal_force(contacts.facts.law, k, c, speed / omega, speed)


@kernel
def change_mode(sys, t, x, which, contacts, out):
    """Give a contact its new mode after one of its event functions fell through zero; returns a Status."""
    i, function = which // N_FUNCTIONS, which % N_FUNCTIONS
    if function == SIGN:
        contacts.sign[i] = -contacts.sign[i]
        return Status.RUNNING
    status = contact_rates(address(sys), address(contacts), t, x, out)
    if status != Status.RUNNING:
        return status
    if function == CLOSURE and contacts.mode[i] != ContactMode.OPEN:
        contacts.mode[i] = ContactMode.OPEN.value
        contacts.slip[i] = 0
        return Status.RUNNING
    if function == CLOSURE:
        if contacts.numbers.zeta >= 0.0:
            set_damping(sys, i, contacts)
        contacts.sign[i] = 1
        return close_contact(sys, t, x, i, contacts, out)
    if contacts.mode[i] == ContactMode.STICK:
        contacts.mode[i] = ContactMode.SLIDE.value
        contacts.slip[i] = -1 if contacts.la[i, 1] > 0.0 else 1
        return Status.RUNNING
    return find_sticking(sys, t, x, i, contacts, out)


@kernel
def set_damping(sys, i, contacts):
    """c = 2 zeta sqrt(k m) with the mass m = 1/G_NN that the contact meets where it closes."""
    work, n = contacts.work, sys.n
    trial = work.trial
    for j in range(n):
        trial[j] = work.W_N[i, j]
    cholesky_solve(n, work.band, work.factor, trial)
    G = 0.0
    for j in range(n):
        G += work.W_N[i, j] * trial[j]
    contacts.constants[i, C_N] = 2.0 * contacts.numbers.zeta * math.sqrt(contacts.constants[i, K] / G)


@kernel
def close_contact(sys, t, x, i, contacts, out):
    """The mode of a contact that has just closed, its velocities being known."""
    if sys.kinds[i, 1] == 0:
        contacts.mode[i] = ContactMode.LOCKED.value
        return Status.RUNNING
    contacts.mode[i] = ContactMode.SLIDE.value
    contacts.slip[i] = 1 if contacts.gamma[i, 1] > 0.0 else -1
    if contacts.facts.is_regularised != 0:
        return Status.RUNNING
    if abs(contacts.gamma[i, 1]) > rounded_speed(sys, contacts):
        return Status.RUNNING
    return find_sticking(sys, t, x, i, contacts, out)


@kernel
def find_sticking(sys, t, x, arrested, contacts, out):
    """Let a contact stick, and every other that slides without velocity; then let go, one by one, those that would hold
    too much."""
    n_c = sys.n_c
    speed = rounded_speed(sys, contacts)
    for i in range(n_c):
        if i == arrested or (contacts.mode[i] == ContactMode.SLIDE and abs(contacts.gamma[i, 1]) <= speed):
            contacts.mode[i] = ContactMode.STICK.value
            contacts.slip[i] = 0
    for _ in range(n_c + 1):
        for is_stopped in range(2):
            status = contact_rates(address(sys), address(contacts), t, x, out)
            if status != Status.RUNNING:
                return status
            if is_stopped == 0:
                stop_sliding(sys, x, contacts)
        worst, excess = -1, 0.0
        for i in range(n_c):
            if contacts.mode[i] == ContactMode.STICK:
                limit = static_coefficient(sys.laws, i) * abs(contacts.la[i, 0])
                over = abs(contacts.la[i, 1]) - limit
                if over > excess:
                    worst, excess = i, over
        if worst < 0:
            break
        contacts.mode[worst] = ContactMode.SLIDE.value
        contacts.slip[worst] = -1 if contacts.la[worst, 1] > 0.0 else 1
    return Status.RUNNING


@kernel
def stop_sliding(sys, x, contacts):
    """Take from u what rounding of the time of the event left of the sliding velocity of the sticking contacts."""
    n = sys.n
    work, stuck, rhs = contacts.work, contacts.stuck, contacts.rhs
    n_stuck = 0
    for i in range(sys.n_c):
        if contacts.mode[i] == ContactMode.STICK:
            rhs[n_stuck] = -contacts.gamma[i, 1]
            n_stuck += 1
    sticking_matrix(n, n_stuck, contacts)
    share_friction(n_stuck, contacts)
    for a in range(n_stuck):
        b = work.start[stuck[a] + 1] - 1
        for j in range(n):
            x[n + j] += work.X[b, j] * rhs[a]
        for i in range(sys.n_c):
            x[2 * n + sys.n_c + i] += normal_change(sys, i, b, contacts) * rhs[a]


@kernel
def normal_change(sys, i, b, contacts):
    """The change of v of contact i with the velocities that a unit impulse in row b gives."""
    n = sys.n
    work, total = contacts.work, 0.0
    if sys.kinds[i, 0] != GIVEN_FORCE:
        for j in range(n):
            total += work.W_N[i, j] * work.X[b, j]
    return total


@kernel
def set_normal_velocities(sys, x, contacts):
    """v = W_N u + w_N from the rows that were evaluated last."""
    n = sys.n
    for i in range(sys.n_c):
        if sys.kinds[i, 0] != GIVEN_FORCE:
            x[2 * n + sys.n_c + i] = contacts.work.gamma_0[contacts.work.start[i]]


@kernel("int64(int64, float64, float64[::1], int64, float64[::1])", short_loops=True)
def begin_contacts(sys_at, t, x, contacts_at, out):
    """The modes at the start.

    A unilateral contact begins closed where it approaches without a gap; one that is indented is closed by an event.
    """
    sys = view(sys_at, Sys)
    contacts = view(contacts_at, Contacts)
    n = sys.n
    for i in range(sys.n_c):
        contacts.mode[i] = ContactMode.OPEN.value
        contacts.slip[i] = 0
        contacts.sign[i] = 1
        if sys.kinds[i, 0] != UNILATERAL:
            contacts.mode[i] = ContactMode.LOCKED.value
    for _ in range(2):  # the rows give the normal velocities v, and these the forces
        status = contact_rates(sys_at, address(contacts), t, x, out)
        if status != Status.RUNNING:
            return status
        set_normal_velocities(sys, x, contacts)
    for i in range(sys.n_c):
        is_landing = x[2 * n + i] <= 0.0 and contacts.gamma[i, 0] < 0.0
        if sys.kinds[i, 0] != UNILATERAL or is_landing:
            contacts.sign[i] = -1 if contacts.la[i, 0] < 0.0 else 1
            status = close_contact(sys, t, x, i, contacts, out)
            if status != Status.RUNNING:
                return status
    return Status.RUNNING.value
