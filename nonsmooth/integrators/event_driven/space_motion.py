"""One contact with friction in two directions between events: its modes, the rates of motion, and what ends a mode.

    q' = u,    M u' = h + W_N^T la_N + W_T^T la_T,    gamma' = G la + b

    open        la = 0
    sliding     la_N = -b_N/p,    la_T = -mu la_N d,    p = G_NN - mu G_NT d,    d = gamma_T/|gamma_T|
    sticking    G la = -b

d turns with the motion; it has no limit at gamma_T = 0. Below the speed v_stop, which counts as none, a slide is
braked as it came (``find_direction`` of penalty/rates.py). Event functions end a mode:

    CLOSURE      g_N of an open contact, la_N of a closed one
    FRICTION     the speed along the course of a slide; mu la_N - |la_T| of sticking
    FORCELESS    p/G_NN of a slide, which has lost its force where it falls to zero

The state is x = (q, u, g_N, P_N, P_T, works). Source: Pfeiffer, Glocker (1996), chapter 5; docs/theory/event_driven.md.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.contact.spatial.all_solutions import OneContact, stick_spatial
from nonsmooth.errors import Status
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.integrators.penalty.rates import find_direction, length_along
from nonsmooth.integrators.penalty.switching import speed_along
from nonsmooth.integrators.radau.stages import RATES
from nonsmooth.integrators.records import (
    CLOSURE,
    FRICTION,
    N_FUNCTIONS,
    N_LEDGER,
    N_WORKS,
    SIGN,
    book_contact_energy,
)
from nonsmooth.integrators.rigid.hold import LINEARISATIONS
from nonsmooth.integrators.rigid.modes import SINGULAR_SLIDE, longest, rounded_length, small_speed
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.mechanics.acceleration_problem import acceleration_problem, constraint_problem
from nonsmooth.mechanics.contact_problem import Work, row_velocities
from nonsmooth.mechanics.impact_in_space import Hodograph
from nonsmooth.mechanics.laws import friction_coefficient, is_no_friction, static_coefficient
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP, ContactMode
from nonsmooth.numerics.rounding import rounded_sum

FORCELESS = SIGN  # code: the event function of a slide that loses its force


class SpaceNumbers(Block):
    """Numbers of a run."""

    atol: float
    rtol: float
    v_stop: float  # [m/s] of sliding that counts as none
    p: float  # over G_NN, of the slide; 1 in other modes
    size: float  # [N] of the terms of la_N
    flight: float  # [s] of the flight that has begun
    late: float  # [s] that the bounces still take which are given up


class SpaceContact(Block, r="max(1, n_c * (1 + d))"):
    """The contact of a run, n_c = 1."""

    work: Work
    numbers: SpaceNumbers
    answers: OneContact
    hodograph: Hodograph
    mode: Array[Ints, "n_c"]
    slip: Array[Ints, "n_c"]  # 0: a slide has no sign
    course: Array[Floats, "n_c", 2]  # the direction of sliding at the last step
    way: Array[Floats, "n_c", 2]  # and now
    q: Array[Floats, "n"]
    u: Array[Floats, "n"]
    la: Array[Floats, "n_c", 3]
    gamma: Array[Floats, "n_c", 3]
    before: Array[Floats, "n_c", 3]  # velocities before the event
    P: Array[Floats, "n_c", 3]  # its impulses
    rates: Array[Floats, 4, "r"]
    u_0: Array[Floats, "n"]  # velocities before it
    ledger: Array[Floats, N_LEDGER]


@kernel("int64(int64, float64, float64[::1], int64)", short_loops=True)
def space_forces(sys_at, t, x, contacts_at):
    """la, gamma and work.du = u' at a state; returns a Status."""
    sys, c = view(sys_at, Sys), view(contacts_at, SpaceContact)
    work, la, numbers, n = c.work, c.la, c.numbers, sys.n
    for j in range(n):
        c.q[j], c.u[j] = x[j], x[n + j]
    work.closed[0] = 0
    status, _ = acceleration_problem(sys, t, c.q, c.u, 1, c.rates, work)
    if status != Status.RUNNING:
        return status
    row_velocities(sys, 1, c.u, work)
    for a in range(3):
        la[0, a], c.gamma[0, a] = 0.0, work.gamma_0[a]
        for b in range(3):
            c.answers.G[0, a, b] = work.G[a, b]
    numbers.p, numbers.size = 1.0, 0.0
    if c.mode[0] == ContactMode.OPEN:
        return Status.RUNNING.value
    if c.mode[0] == ContactMode.STICK:
        la[0, 0], la[0, 1], la[0, 2], _ = stick_spatial(c.answers.G, 0, work.c[0], work.c[1], work.c[2], math.inf)
    else:
        mu = friction_coefficient(sys.laws, 0, max(0.0, find_direction(2, 0, c)))
        if is_no_friction(mu):
            return Status.NEGATIVE_FRICTION.value
        p = work.G[0, 0] - mu * (work.G[0, 1] * c.way[0, 0] + work.G[0, 2] * c.way[0, 1])
        numbers.p = p / work.G[0, 0]
        la[0, 0] = -work.c[0] / p
        for a in range(2):
            la[0, 1 + a] = -mu * la[0, 0] * c.way[0, a]
    numbers.size = abs(la[0, 0]) + abs(work.c[0]) / work.G[0, 0]
    for j in range(n):
        total, size = work.du[j], abs(work.du[j])
        for a in range(3):
            part = work.X[a, j] * la[0, a]
            total, size = total + part, size + abs(part)
        work.du[j] = 0.0 if abs(total) <= rounded_sum(VELOCITY_ROUNDINGS, size) < math.inf else total
    return Status.RUNNING.value


@kernel(RATES, short_loops=True)
def space_rates(sys_at, contacts_at, t, x, out):
    """x' with x = (q, u, g_N, P, works); a radau ``rates`` function. Returns a Status."""
    sys, c = view(sys_at, Sys), view(contacts_at, SpaceContact)
    status = space_forces(sys_at, t, x, contacts_at)
    if status != Status.RUNNING:
        return status
    n, work, total = sys.n, c.work, 0.0
    for k in range(2 * n, x.shape[0]):
        out[k] = 0.0
    for j in range(n):
        out[j], out[n + j] = c.u[j], work.du[j]
        out[2 * n + 4] += work.h[j] * c.u[j]
        total += 0.0 * work.du[j]
    for a in range(3):
        out[2 * n + 1 + a] = c.la[0, a]
        out[2 * n + (6 if a == 0 else 5)] += c.la[0, a] * c.gamma[0, a]
        out[2 * n + 7] -= c.la[0, a] * work.w[a]
    return Status.RUNNING.value if total == 0.0 else Status.NOT_FINITE.value


@kernel(RATES, short_loops=True)
def space_events(sys_at, contacts_at, t, x, out):
    """The event functions and their tolerances, an ``event_values`` function; one that does not apply is 1."""
    sys, c = view(sys_at, Sys), view(contacts_at, SpaceContact)
    status = space_forces(sys_at, t, x, contacts_at)
    if status != Status.RUNNING:
        return status
    if not evaluate(sys, GAP, t, c.q, c.u, c.work.g_N):
        return Status.NOT_FINITE.value
    for m in range(N_FUNCTIONS):
        out[m], out[N_FUNCTIONS + m] = 1.0, 0.0
    force = c.numbers.rtol * c.numbers.size
    if c.mode[0] == ContactMode.OPEN:
        out[CLOSURE], out[N_FUNCTIONS + CLOSURE] = c.work.g_N[0], rounded_length(sys.n, c)
        return Status.RUNNING.value
    out[CLOSURE], out[N_FUNCTIONS + CLOSURE] = c.la[0, 0], force
    if c.mode[0] == ContactMode.SLIDE:
        out[FRICTION], out[N_FUNCTIONS + FRICTION] = speed_along(2, 0, c), small_speed(sys, c)
        out[FORCELESS] = c.numbers.p - SINGULAR_SLIDE
    else:
        mu = static_coefficient(sys.laws, 0)
        out[FRICTION], out[N_FUNCTIONS + FRICTION] = mu * c.la[0, 0] - length_along(c.la, 0), (1.0 + mu) * force
    return Status.RUNNING.value


@kernel
def hold(sys, t, x, c):
    """Move the state onto g_N = 0, gamma_N = 0 and, sticking, gamma_T = 0; the gap is written. Returns a Status."""
    work, n = c.work, sys.n
    work.closed[0] = 0
    for _ in range(LINEARISATIONS):
        for j in range(n):
            c.q[j], c.u[j] = x[j], x[n + j]
        if not evaluate(sys, GAP, t, c.q, c.u, work.g_N) or not math.isfinite(work.g_N[0]):
            return Status.NOT_FINITE.value
        x[2 * n] = work.g_N[0]
        if c.mode[0] == ContactMode.OPEN:
            return Status.RUNNING.value
        status, _ = constraint_problem(sys, t, c.q, c.u, 1, work)
        if status != Status.RUNNING:
            return status
        x[2 * n] = 0.0
        if abs(work.g_N[0]) <= rounded_sum(VELOCITY_ROUNDINGS, longest(n, c)):
            break
        for j in range(n):
            x[j] -= work.X[0, j] * work.g_N[0] / work.G[0, 0]
    row_velocities(sys, 1, c.u, work)
    stop(sys, c)
    give(sys, False, x, c)
    return Status.RUNNING.value


@kernel
def stop(sys, c):
    """The impulses, to work.P, that take gamma_N and, sticking, gamma_T, of the velocities in work.gamma_0."""
    work, G = c.work, c.answers.G
    work.P[0], work.P[1], work.P[2] = -work.gamma_0[0] / work.G[0, 0], 0.0, 0.0
    if c.mode[0] == ContactMode.STICK:
        for a in range(3):
            for b in range(3):
                G[0, a, b] = work.G[a, b]
        work.P[0], work.P[1], work.P[2], _ = stick_spatial(
            G, 0, work.gamma_0[0], work.gamma_0[1], work.gamma_0[2], math.inf
        )


@kernel
def give(sys, is_booked, x, c):
    """u += X^T P, what cancels to rounding set to 0; the impulses of an event are booked, with their works.

    Returns what the contact gained, the sizes of its parts, and the work with which friction drives a slide.
    """
    work, n = c.work, sys.n
    for j in range(n):
        before, total, size = x[n + j], x[n + j], abs(x[n + j])
        for a in range(3):
            part = work.X[a, j] * work.P[a]
            total, size = total + part, size + abs(part)
        x[n + j] = 0.0 if abs(total) <= rounded_sum(VELOCITY_ROUNDINGS, size) < math.inf else total
        work.trial[j] = 0.5 * (before + x[n + j])
    if not is_booked:
        return 0.0, 0.0, 0.0
    for m in range(N_LEDGER):
        c.ledger[m] = 0.0
    _, gain, size, push = book_contact_energy(sys, 1, work.trial, c.ledger, work)
    for m in range(N_WORKS):
        x[2 * n + 4 + m] += c.ledger[m]
    for a in range(3):
        c.P[0, a] += work.P[a]
        x[2 * n + 1 + a] += work.P[a]
    return gain, size, push
