"""Contacts with friction in two directions between events: their modes, the rates of motion, and what ends a mode.

    q' = B u,    M u' = h + W_N^T la_N + W_T^T la_T,    gamma' = G la + b

    open        la = 0
    sliding     gamma_N' = 0,    la_T = -mu la_N d,    d = gamma_T/|gamma_T|
    sticking    gamma' = 0

The modes make the forces the solution of one linear system A la = -b an island of contacts that G couples; of one
contact that slides A = p = G_NN - mu G_NT d. d turns with the motion; it has no limit at gamma_T = 0. Below the speed
v_stop, which counts as none, a slide is braked as it came (``find_direction`` of penalty/rates.py). Redundant contacts
make A singular: they share what changes since the last event as equal springs would, from a load that is admissible
then. Event functions end a mode:

    CLOSURE      g_N of an open contact, la_N of a closed one
    FRICTION     the speed along the course of a slide; mu la_N - |la_T| of sticking
    FORCELESS    det A over that without friction, of the island of a slide: where it falls to zero the slide has lost
                 its force

The state is x = (q, u, g_N, P_N, P_T, works). Source: Pfeiffer, Glocker (1996), chapter 5; docs/theory/event_driven.md.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.contact.islands import find_held_islands
from nonsmooth.contact.spatial.all_solutions import OneContact
from nonsmooth.contact.spatial.problem import Spatial
from nonsmooth.errors import Status
from nonsmooth.integrators.moreau_jean.step import VELOCITY_ROUNDINGS
from nonsmooth.integrators.penalty.rates import find_direction, length_along
from nonsmooth.integrators.penalty.switching import follow_slide, speed_along
from nonsmooth.integrators.radau.stages import RATES, determinant_is_positive
from nonsmooth.integrators.records import (
    CLOSURE,
    FRICTION,
    N_FUNCTIONS,
    N_LEDGER,
    N_WORKS,
    SIGN,
)
from nonsmooth.integrators.rigid.modes import DISTINCT_ROWS, EVERY, SINGULAR_SLIDE, rounded_length, small_speed
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.mechanics.acceleration_problem import acceleration_problem, free_acceleration
from nonsmooth.mechanics.contact_problem import Work, row_velocities
from nonsmooth.mechanics.impact_in_space import Hodograph
from nonsmooth.mechanics.kinematics import coordinate_rates, find_kinematics
from nonsmooth.mechanics.laws import friction_coefficient, is_no_friction, static_coefficient
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP, ContactMode
from nonsmooth.numerics.dense import lu, lu_solve
from nonsmooth.numerics.rounding import EPS, rounded_sum

FORCELESS = SIGN  # code: the event function of a slide that loses its force
# code: what is to be done about a contact at an event: its mode stays; is decided; it bounces, and may be given up
STAYS, TO_DECIDE, BOUNCES = range(3)
NORMALS, ALL_HELD, WITH_FRICTION = range(3)  # code: equations of the normals alone; of all that is held; with friction
# chosen: of the mean diagonal of A: makes redundant contacts share their load. What rounding leaves of the residual is
# 1e4 times as large in the share, on which the friction of slides in several directions depends: with 1e-10 steps of
# 1e-10 s were taken at rtol = 1e-10
SHARE_SHIFT = 1e-4
SHARE_REFINEMENTS = 60  # chosen: of a share: each leaves 1e-4 over the least eigenvalue that is not zero


class SpaceNumbers(Block):
    """Numbers of a run."""

    atol: float
    rtol: float
    v_stop: float  # [m/s] of sliding that counts as none
    flight: float  # [s] of the shortest flight that has begun
    shift: float  # of the diagonal of A where contacts are redundant
    compliance: float  # of coupled contacts whose modes are decided
    changed: float  # [s] when a mode changed last
    ratio: float  # det A over that without friction, of the island solved last


class SpaceContacts(Block, r="max(1, n_c * (1 + d))", n_q=0, w="max(1, d)"):
    """The contacts of a run. n = n_u, c = n_c, r = rows, w = columns of friction."""

    work: Array[Work, "n_q = n_q"]
    numbers: SpaceNumbers
    answers: OneContact
    hodograph: Hodograph
    spatial: Array[Spatial, "n = n_c if n_c > 1 else 0"]
    repeats: int  # events since then
    mode: Array[Ints, "n_c"]
    slip: Array[Ints, "n_c"]  # 0: a slide has no sign
    touches: Array[Ints, "n_c"]  # 1 where an open contact takes part in an event
    course: Array[Floats, "n_c", 2]  # the direction of sliding at the last step
    way: Array[Floats, "n_c", 2]  # and now
    q: Array[Floats, "n_q or n"]
    u: Array[Floats, "n"]
    la: Array[Floats, "n_c", "1 + w"]
    gamma: Array[Floats, "n_c", "1 + w"]
    share: Array[Floats, "n_c", "1 + w"]  # forces from which redundant contacts share what changes
    mu: Array[Floats, "n_c"]  # of the contacts that slide
    p: Array[Floats, "n_c"]  # det A over that without friction, of the island of each contact
    is_shared: Array[Ints, "n_c"]  # 1 in an island of redundant contacts
    size: Array[Floats, "n_c"]  # [N] of the terms of la_N
    island: Array[Ints, "n_c"]  # of each closed contact, by all that G couples
    group: Array[Ints, "n_c"]  # by what their modes hold
    held: Array[Ints, "n_c"]  # rows of each closed contact that its mode holds
    row: Array[Ints, "r"]  # of G, of each equation
    contact: Array[Ints, "r"]  # its contact
    part: Array[Ints, "r"]  # 0: normal, 1 and 2: tangential
    A: Array[Floats, "r", "r"]
    factor: Array[Floats, "r", "r"]
    order: Array[Ints, "r"]
    b: Array[Floats, "r"]
    z: Array[Floats, "r"]
    left: Array[Floats, "r"]  # scratch
    centre: Array[Floats, "r"]  # impulses about which coupled contacts are compliant
    sum: Array[Floats, "r"]  # scratch
    rates: Array[Floats, 4, "r"]
    before: Array[Floats, "n_c", "1 + w"]  # velocities before the event
    P: Array[Floats, "n_c", "1 + w"]  # its impulses
    P_none: Array[Floats, "n_c", "1 + d"]
    was: Array[Ints, "n_c"]  # modes before it
    stuck: Array[Ints, "n_c"]  # 1 of those that stuck then, or after an impact without collision
    kind: Array[Ints, "n_c"]  # of event, of each contact
    found: Array[Ints, "n_c"]  # and the number of its solutions; 0: not counted
    open_case: Array[Ints, "n_c"]  # what is to be done about each (space_switching.py)
    softness: Array[Floats, "n_c"]  # of each closed contact along the surface, where their modes are decided
    is_fast: Array[Ints, "n_c"]  # 1 of each closed contact that slides on in any case
    late: Array[Floats, "n_c"]  # [s] that the bounces still take which are given up
    u_0: Array[Floats, "n"]  # velocities before it
    move: Array[Floats, "n"]  # scratch
    dq: Array[Floats, "n_q or n"]  # scratch
    ledger: Array[Floats, N_LEDGER]


@kernel("int64(int64, float64, float64[::1], int64)", short_loops=True)
def space_forces(sys_at, t, x, contacts_at):
    """la, gamma and work.du = u' at a state; returns a Status."""
    sys, c = view(sys_at, Sys), view(contacts_at, SpaceContacts)
    work, n_k = c.work, list_closed(sys, x, c)
    for i in range(sys.n_c):
        c.p[i], c.size[i], c.is_shared[i] = 1.0, 0.0, 0
        for a in range(c.la.shape[1]):
            c.la[i, a], c.gamma[i, a] = 0.0, 0.0
    work.n = n_k
    if n_k == 0:
        for j in range(sys.n_q):
            work.q_mid[j] = c.q[j]
        if not find_kinematics(sys, t, c.q, c.u, work):
            return Status.NOT_FINITE.value
        return free_acceleration(sys, True, t, c.u, work)
    status, _ = acceleration_problem(sys, t, c.q, c.u, n_k, c.rates, work)
    if status != Status.RUNNING:
        return status
    row_velocities(sys, n_k, c.u, work)
    for k in range(n_k):
        for a in range(work.start[k], work.start[k + 1]):
            c.gamma[work.closed[k], a - work.start[k]] = work.gamma_0[a]
    if not find_slides(sys, n_k, c):
        return Status.NEGATIVE_FRICTION.value
    for k in range(n_k):
        c.held[k] = held_rows(c.mode[work.closed[k]], work.start[k + 1] - work.start[k])
    for island in range(find_held_islands(n_k, work.start, c.held, work.G, c.group)):
        find_forces_of(island, n_k, c)
    add_forces(sys, n_k, c)
    return Status.RUNNING.value


@kernel
def list_closed(sys, x, c):
    """Take q and u from the state, and list the contacts that are not open, or take part in an event: their number."""
    n_k = 0
    for j in range(sys.n_q):
        c.q[j] = x[j]
    for j in range(sys.n):
        c.u[j] = x[sys.n_q + j]
    for i in range(sys.n_c):
        if c.mode[i] != ContactMode.OPEN or c.touches[i] == 1:
            c.work.closed[n_k] = i
            n_k += 1
    return n_k


@kernel
def is_alone(k, n_k, c):
    """Whether closed contact k is the only one of its island."""
    for m in range(n_k):
        if m != k and c.island[m] == c.island[k]:
            return False
    return True


@kernel
def take_course(i, c):
    """Take the direction in which contact i slides; in space it has no sign."""
    follow_slide(2, i, c)
    c.slip[i] = 0


@kernel
def held_rows(mode, rows):
    """How many rows of a contact its mode holds at zero."""
    return 0 if mode == ContactMode.OPEN else rows if mode == ContactMode.STICK else 1


@kernel
def find_slides(sys, n_k, c):
    """Directions and coefficients of the contacts that slide; False where a law of friction gives none."""
    for k in range(n_k):
        i = c.work.closed[k]
        if c.mode[i] != ContactMode.SLIDE:
            continue
        c.mu[i] = friction_coefficient(sys.laws, i, max(0.0, find_direction(2, i, c)))
        if is_no_friction(c.mu[i]):
            return False
    return True


@kernel
def list_equations(which, island, n_k, c):
    """The rows that are held at zero, of the contacts of an island; returns their number."""
    work, m = c.work, 0
    for k in range(n_k):
        i = work.closed[k]
        rows = held_rows(c.mode[i], work.start[k + 1] - work.start[k])
        if island != EVERY and c.group[k] != island:
            continue
        for a in range(min(rows, 1) if which == NORMALS else rows):
            c.row[m], c.contact[m], c.part[m] = work.start[k] + a, i, a
            m += 1
    return m


@kernel
def decompose(m, which, c):
    """LU factors of A; returns the smallest pivot over the entries of G that stand for its row and column, 0 where A is
    singular, and leaves the determinant over the product of the diagonal of G in c.numbers.ratio."""
    G, A, row, smallest, determinant = c.work.G, c.A, c.row, math.inf, 1.0
    for f in range(m):
        i = c.contact[f]
        slides = which == WITH_FRICTION and c.mode[i] == ContactMode.SLIDE
        for e in range(m):
            A[e, f] = G[row[e], row[f]]
            if slides:
                A[e, f] -= c.mu[i] * (c.way[i, 0] * G[row[e], row[f] + 1] + c.way[i, 1] * G[row[e], row[f] + 2])
            c.factor[e, f] = A[e, f]
    c.numbers.shift, c.numbers.ratio = 0.0, 0.0
    if not lu(m, c.factor, c.order):
        return 0.0
    for e in range(m):
        pivot, size = c.factor[e, e], math.sqrt(abs(G[row[c.order[e]], row[c.order[e]]] * G[row[e], row[e]]))
        smallest = min(smallest, abs(pivot) / size)
        determinant *= abs(pivot) / G[row[e], row[e]]
    c.numbers.ratio = determinant if determinant_is_positive(m, c.factor, c.order, c.sum) else -determinant
    return smallest


@kernel
def find_forces_of(island, n_k, c):
    """The forces of one island."""
    m = list_equations(WITH_FRICTION, island, n_k, c)
    if m == 0:
        return
    frictionless, slides = 1.0, False
    for e in range(m):
        slides = slides or c.mode[c.contact[e]] == ContactMode.SLIDE
    if slides:
        decompose(m, ALL_HELD, c)
        frictionless = c.numbers.ratio
    smallest = decompose(m, WITH_FRICTION, c)
    ratio = c.numbers.ratio / frictionless if slides and frictionless > 0.0 else 1.0
    is_lost = slides and abs(ratio) < DISTINCT_ROWS
    if m > 1 and smallest < DISTINCT_ROWS and (smallest == 0.0 or not is_lost):
        regularise(m, c)
        ratio = ratio if is_lost else 1.0
    for e in range(m):
        c.b[e], c.z[e] = -c.work.c[c.row[e]], c.share[c.contact[e], c.part[e]]
    solve_equations(m, c)
    for e in range(m):
        i = c.contact[e]
        c.la[i, c.part[e]], c.p[i], c.is_shared[i] = c.z[e], ratio, 1 if c.numbers.shift > 0.0 else 0
        if c.mode[i] == ContactMode.SLIDE:
            for a in range(2):
                c.la[i, 1 + a] = -c.mu[i] * c.z[e] * c.way[i, a]


@rare_kernel
def regularise(m, c):
    """LU factors of A + shift."""
    trace = 0.0
    for e in range(m):
        trace += c.work.G[c.row[e], c.row[e]]
    c.numbers.shift = SHARE_SHIFT * trace / m
    for e in range(m):
        for f in range(m):
            c.factor[e, f] = c.A[e, f]
        c.factor[e, e] += c.numbers.shift
    lu(m, c.factor, c.order)


@kernel
def solve_equations(m, c):
    """A z = b; where A is singular the nearest solution to what z is, by proximal iterations."""
    if c.numbers.shift == 0.0:
        lu_solve(m, c.factor, c.order, c.b, c.z)
        return
    for _ in range(SHARE_REFINEMENTS):
        for e in range(m):
            c.left[e] = c.b[e]
            for f in range(m):
                c.left[e] -= c.A[e, f] * c.z[f]
        lu_solve(m, c.factor, c.order, c.left, c.sum)
        largest, change = 0.0, 0.0
        for e in range(m):
            c.z[e] += c.sum[e]
            largest, change = max(largest, abs(c.z[e])), max(change, abs(c.sum[e]))
        if not change > EPS * largest:
            break


@kernel
def add_forces(sys, n_k, c):
    """work.du += X^T la, what cancels to rounding set to exactly 0; and the sizes of the terms of each force."""
    work, la = c.work, c.la
    for k in range(n_k):
        i, a = work.closed[k], work.start[k]
        c.size[i] = abs(la[i, 0]) + abs(work.c[a]) / work.G[a, a]
    for j in range(sys.n):
        total, size = work.du[j], abs(work.du[j])
        for k in range(n_k):
            for a in range(work.start[k], work.start[k + 1]):
                part = work.X[a, j] * la[work.closed[k], a - work.start[k]]
                total, size = total + part, size + abs(part)
        work.du[j] = 0.0 if abs(total) <= rounded_sum(VELOCITY_ROUNDINGS, size) < math.inf else total


@kernel(RATES, short_loops=True)
def space_rates(sys_at, contacts_at, t, x, out):
    """x' with x = (q, u, g_N, P, works); a radau ``rates`` function. Returns a Status."""
    sys, c = view(sys_at, Sys), view(contacts_at, SpaceContacts)
    status = space_forces(sys_at, t, x, contacts_at)
    if status != Status.RUNNING:
        return status
    n_q, n, n_c, work, total = sys.n_q, sys.n, sys.n_c, c.work, 0.0
    works = x.shape[0] - N_WORKS
    for k in range(n_q + n, x.shape[0]):
        out[k] = 0.0
    coordinate_rates(sys, c.u, work, out)
    for j in range(n):
        out[n_q + j] = work.du[j]
        out[works] += work.h[j] * c.u[j]
        total += 0.0 * work.du[j]
    for k in range(work.n):
        i = work.closed[k]
        for a in range(work.start[k + 1] - work.start[k]):
            force = c.la[i, a]
            out[n_q + n + (1 + a) * n_c + i] = force
            out[works + (2 if a == 0 else 1)] += force * c.gamma[i, a]
            out[works + 3] -= force * work.w[work.start[k] + a]
    return Status.RUNNING.value if total == 0.0 else Status.NOT_FINITE.value


@kernel(RATES, short_loops=True)
def space_events(sys_at, contacts_at, t, x, out):
    """The event functions and their tolerances, an ``event_values`` function; one that does not apply is 1."""
    sys, c = view(sys_at, Sys), view(contacts_at, SpaceContacts)
    E = N_FUNCTIONS * sys.n_c
    status = space_forces(sys_at, t, x, contacts_at)
    if status != Status.RUNNING:
        return status
    if sys.n_c > 0 and not evaluate(sys, GAP, t, c.q, c.u, c.work.g_N):
        return Status.NOT_FINITE.value
    speed, length = small_speed(sys, c), rounded_length(sys.n_q, c)
    for i in range(sys.n_c):
        e, force, mode = N_FUNCTIONS * i, c.numbers.rtol * c.size[i], c.mode[i]
        for m in range(N_FUNCTIONS):
            out[e + m], out[E + e + m] = 1.0, 0.0
        if mode == ContactMode.OPEN:
            out[e + CLOSURE], out[E + e + CLOSURE] = c.work.g_N[i], length
            continue
        out[e + CLOSURE], out[E + e + CLOSURE] = c.la[i, 0], force
        if mode == ContactMode.SLIDE:
            out[e + FRICTION], out[E + e + FRICTION] = speed_along(2, i, c), speed
            out[e + FORCELESS] = c.p[i] - SINGULAR_SLIDE
        elif mode == ContactMode.STICK:
            mu = static_coefficient(sys.laws, i)
            out[e + FRICTION] = mu * c.la[i, 0] - length_along(c.la, i)
            out[E + e + FRICTION] = (1.0 + mu) * force
    return Status.RUNNING.value
