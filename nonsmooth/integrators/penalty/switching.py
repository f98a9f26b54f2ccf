"""When a compliant contact changes its mode, and to which: event functions and what follows each.

A contact has three functions that are positive while its mode lasts: its closure (lift-off, landing), its friction
(the end of sliding: gamma_F = 0; of sticking: |la_F| = mu |la_N|) and the sign of its force (bilateral contacts).
Where a slip ends the contact sticks if the force that holds it is within the limit, otherwise it slides on, or back. In
space the direction of a slide is followed from step to step: a slide that has turned by 60 degrees within one, at a
speed, takes its new course.
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
    length_along,
    list_stuck,
    share_friction,
    sticking_matrix,
)
from nonsmooth.integrators.radau.events import EVENT_ROUNDINGS
from nonsmooth.integrators.radau.stages import RATES
from nonsmooth.integrators.records import CLOSURE, FRICTION, N_FUNCTIONS, SIGN
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.laws import friction_coefficient, static_coefficient
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import GIVEN_FORCE, UNILATERAL, ContactMode
from nonsmooth.numerics.dense import cholesky_solve
from nonsmooth.numerics.rounding import rounded_sum

# chosen: of the largest velocity. The Jacobian is one of differences over FORWARD_INCREMENT, 1.5e-8 of it, which a
# direction that turns over less would make noise of. Below it a slide is braked as it came; what that is wrong by is
# the part by which it would turn yet, of this speed
LEAST_SLIDE = 1e-7
SLIDE_BISECTIONS = 60  # chosen: of an interval: to the rounding

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
    n_c = sys.n_c
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
            out[e + CLOSURE] = closure(i, x[sys.n_q + sys.n + i], contacts)
            out[E + e + CLOSURE] = force
        if sys.kinds[i, 1] > 0 and kind != GIVEN_FORCE and mode != ContactMode.OPEN:
            out[e + SIGN] = contacts.sign[i] * contacts.la[i, 0]
            out[E + e + SIGN] = force
            if kind == UNILATERAL and contacts.facts.law != NormalLaw.KELVIN_VOIGT:
                out[e + SIGN] = 1.0
        if mode == ContactMode.SLIDE and contacts.facts.is_regularised == 0:
            out[e + FRICTION] = speed_along(sys.kinds[i, 1], i, contacts)
            out[E + e + FRICTION] = speed
        elif mode == ContactMode.STICK:
            mu = static_coefficient(sys.laws, i)
            held = length_along(contacts.la, i)
            out[e + FRICTION] = mu * contacts.sign[i] * contacts.la[i, 0] - held
            out[E + e + FRICTION] = (1.0 + mu) * force + contacts.numbers.rtol * held
    return Status.RUNNING.value


@kernel
def speed_along(d, i, contacts):
    """Positive while contact i slides on: its speed in the sense of its slip; in space, with its course c,
    2 c.gamma_F - |gamma_F|."""
    gamma, course = contacts.gamma, contacts.course
    if d == 1:
        return contacts.slip[i] * gamma[i, 1]
    return 2.0 * (course[i, 0] * gamma[i, 1] + course[i, 1] * gamma[i, 2]) - length_along(gamma, i)


@kernel
def closure(i, z, contacts):
    """Positive while contact i stays as it is: the force of a closed contact, minus that of an open one."""
    k, c, omega = contacts.constants[i, K], contacts.constants[i, C_N], contacts.constants[i, OMEGA]
    d, d_rate = -z / omega, -contacts.gamma[i, 0]
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
        for axis in range(sys.kinds[i, 1]):
            fastest = max(fastest, abs(contacts.gamma[i, 1 + axis]), abs(contacts.work.w_F[i, axis]))
    return fastest


@kernel
def note_speed(sys, contacts):
    """The speed of sliding in space that counts as none, by the velocities at hand."""
    numbers = contacts.numbers
    numbers.v_stop = max(numbers.atol, LEAST_SLIDE * max(numbers.atol / numbers.rtol, fastest_velocity(sys, contacts)))


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
        let_go(sys, i, contacts)
        return Status.RUNNING
    if is_sliding(sys, i, contacts):
        follow_slide(sys.kinds[i, 1], i, contacts)
        return Status.RUNNING
    return find_sticking(sys, t, x, i, contacts, out)


@kernel
def is_sliding(sys, i, contacts):
    """Whether contact i slides in space faster than what counts as none: its course has turned."""
    stop = 2.0 * max(contacts.numbers.v_stop, rounded_speed(sys, contacts))
    return sys.kinds[i, 1] == 2 and length_along(contacts.gamma, i) > stop


@kernel
def follow_slide(d, i, contacts):
    """Take the sign, or the course, of the velocity with which contact i slides."""
    gamma = contacts.gamma
    if d == 1:
        contacts.slip[i] = 1 if gamma[i, 1] > 0.0 else -1
        return
    size = length_along(gamma, i)
    contacts.slip[i] = 1
    if size > contacts.numbers.v_stop:
        contacts.course[i, 0], contacts.course[i, 1] = gamma[i, 1] / size, gamma[i, 2] / size


@kernel
def let_go(sys, i, contacts):
    """Let contact i slide, which stuck with a force la_F that it cannot hold.

    In space it moves off along s: A (la_F + mu la_N s) = -sigma s, sigma >= 0, with A of its two rows: its acceleration
    has the direction of its motion. |(sigma + mu la_N A)^-1 A la_F| falls with sigma, which is bisected.
    """
    la, work, d = contacts.la, contacts.work, sys.kinds[i, 1]
    contacts.mode[i] = ContactMode.SLIDE.value
    if d == 1:
        contacts.slip[i] = -1 if la[i, 1] > 0.0 else 1
        return
    b, a_11, a_12, a_22 = work.start[i + 1] - 2, 0.0, 0.0, 0.0
    for j in range(sys.n):
        a_11 += work.W[b, j] * work.X[b, j]
        a_12 += work.W[b, j] * work.X[b + 1, j]
        a_22 += work.W[b + 1, j] * work.X[b + 1, j]
    limit = friction_coefficient(sys.laws, i, 0.0) * abs(la[i, 0])
    pull_1, pull_2 = -(a_11 * la[i, 1] + a_12 * la[i, 2]), -(a_12 * la[i, 1] + a_22 * la[i, 2])
    low, high = 0.0, math.sqrt(pull_1 * pull_1 + pull_2 * pull_2)
    s_1, s_2 = pull_1, pull_2
    for _ in range(SLIDE_BISECTIONS):
        sigma = 0.5 * (low + high)
        m_11, m_12, m_22 = limit * a_11 + sigma, limit * a_12, limit * a_22 + sigma
        s_1, s_2 = m_22 * pull_1 - m_12 * pull_2, m_11 * pull_2 - m_12 * pull_1
        if s_1 * s_1 + s_2 * s_2 > (m_11 * m_22 - m_12 * m_12) ** 2:
            low = sigma
        else:
            high = sigma
    size = math.sqrt(s_1 * s_1 + s_2 * s_2)
    contacts.slip[i] = 1
    contacts.course[i, 0], contacts.course[i, 1] = s_1 / size, s_2 / size


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
    follow_slide(sys.kinds[i, 1], i, contacts)
    if contacts.facts.is_regularised != 0:
        return Status.RUNNING
    stop = contacts.numbers.v_stop if sys.kinds[i, 1] == 2 else 0.0
    if length_along(contacts.gamma, i) > max(stop, rounded_speed(sys, contacts)):
        return Status.RUNNING
    return find_sticking(sys, t, x, i, contacts, out)


@kernel
def find_sticking(sys, t, x, arrested, contacts, out):
    """Let a contact stick, and every other that slides without velocity; then let go, one by one, those that would hold
    too much."""
    n_c = sys.n_c
    speed = rounded_speed(sys, contacts)
    for i in range(n_c):
        if i == arrested or (contacts.mode[i] == ContactMode.SLIDE and length_along(contacts.gamma, i) <= speed):
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
                over = length_along(contacts.la, i) - limit
                if over > excess:
                    worst, excess = i, over
        if worst < 0:
            break
        let_go(sys, worst, contacts)
    return Status.RUNNING


@kernel
def stop_sliding(sys, x, contacts):
    """Take from u what rounding of the time of the event left of the sliding velocity of the sticking contacts."""
    n = sys.n
    work, stuck, rhs = contacts.work, contacts.stuck, contacts.rhs
    list_stuck(sys, contacts)
    for a in range(contacts.n_stuck):
        rhs[a] = -work.gamma_0[stuck[a]]
    sticking_matrix(n, contacts)
    share_friction(contacts.n_stuck, contacts)
    for a in range(contacts.n_stuck):
        b = stuck[a]
        for j in range(n):
            x[sys.n_q + j] += work.X[b, j] * rhs[a]
        for i in range(sys.n_c):
            x[sys.n_q + n + sys.n_c + i] += normal_change(sys, i, b, contacts) * rhs[a]


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
    first = sys.n_q + sys.n + sys.n_c
    for i in range(sys.n_c):
        if sys.kinds[i, 0] != GIVEN_FORCE:
            x[first + i] = contacts.work.gamma_0[contacts.work.start[i]]


@kernel("int64(int64, float64, float64[::1], int64, float64[::1])", short_loops=True)
def begin_contacts(sys_at, t, x, contacts_at, out):
    """The modes at the start.

    A unilateral contact begins closed where it approaches without a gap; one that is indented is closed by an event.
    """
    sys = view(sys_at, Sys)
    contacts = view(contacts_at, Contacts)
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
        is_landing = x[sys.n_q + sys.n + i] <= 0.0 and contacts.gamma[i, 0] < 0.0
        if sys.kinds[i, 0] != UNILATERAL or is_landing:
            contacts.sign[i] = -1 if contacts.la[i, 0] < 0.0 else 1
            status = close_contact(sys, t, x, i, contacts, out)
            if status != Status.RUNNING:
                return status
    return Status.RUNNING.value
