"""The equations of motion with rigid contacts, mode by mode.

    q' = u,    M u' = h + W_N^T la_N + W_F^T la_F

Each contact has a mode, and the modes make the forces the solution of one linear system in (la_N, la_F):

    closed              gamma_N' = 0
    sticking            gamma_F' = 0 as well
    sliding, sign s     la_F = -s mu(|gamma_F|) sigma la_N,  sigma the sign of la_N
    open                la = 0

with gamma' = G la + b, the acceleration-level problem by which paradoxes are judged. Its matrix A is G without the rows
of sliding friction, whose columns are added to those of the normal forces: one contact that slides has A = p =
G_NN - s mu sigma G_NF. Contacts that G does not couple have systems of their own, island by island. Redundant contacts
make A singular: rigid/redundant.py. The forces and what ends a mode are in rigid/rates.py, what follows an event in
event_driven/switching.py.

Source: Pfeiffer, Glocker, *Multibody Dynamics with Unilateral Contacts* (1996), chapter 5;
docs/theory/event_driven.md, (1).
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.contact.islands import find_held_islands
from nonsmooth.contact.planar.problem import Planar
from nonsmooth.errors import Status
from nonsmooth.integrators.penalty.rates import REFINEMENTS, REGULARISATION
from nonsmooth.integrators.penalty.switching import fastest_velocity
from nonsmooth.integrators.radau.events import EVENT_ROUNDINGS
from nonsmooth.integrators.radau.stages import determinant_is_positive
from nonsmooth.integrators.records import CLOSURE, FRICTION, SIGN
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import Block, Floats, Ints
from nonsmooth.mechanics.acceleration_problem import acceleration_problem, constraint_problem, free_acceleration
from nonsmooth.mechanics.contact_problem import Work, row_velocities
from nonsmooth.mechanics.laws import friction_coefficient, is_no_friction
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, ContactMode
from nonsmooth.numerics.dense import lu, lu_solve
from nonsmooth.numerics.rounding import NOTHING, rounded_sum

UNIQUE = CLOSURE  # code: of a bilateral contact, which has nothing to close
FORWARD, BACKWARD = FRICTION, SIGN  # code: of a contact that sticks, the ways in which it may slide
EVERY = -1  # code: all islands
# derived: det A over that without friction (p/G_NN of one contact) at which a slide ends: masses of different size
# make both small, but not their ratio. Towards a Génot–Brogliato point la_N grows like p^(chi - 1), 0 < chi: what is
# left of its impulse there is 1e-9^chi of the whole.
SINGULAR_SLIDE = 1e-9
# chosen: below it a step that vanishes has come to such a point: the force grows without bound there
NEARLY_SINGULAR = 1e-3
# derived: smallest pivot of A, squared sine of the angle between two rows, that leaves ten digits of the forces
DISTINCT_ROWS = 1e-6


class Redundant(Block, r="max(1, n_c * (1 + d))"):
    """Arrays of the load that redundant contacts share. r = rows."""

    Q: Array[Floats, "r", "n"]  # orthogonal rows
    X: Array[Floats, "r", "n"]  # M^-1 times each
    R: Array[Floats, "r", "r"]
    y: Array[Floats, "r"]
    order: Array[Ints, "r"]
    length: Array[Floats, "r"]  # squared lengths of the rows in the metric M^-1
    planar: Array[Planar, "n = max(2, n_c)", "kept = 1"]


class RigidFacts(Block):
    """Whole numbers of a run."""

    selection: int  # the rule where there are several solutions
    event: int  # that waits to be handled
    is_shared: int  # of the island found last: 1 where its contacts are redundant, so that no single force is known
    is_admissible: int  # 1 where they are redundant, or nearly so, and admissible forces go with their modes
    follows_margin: int  # whether events follow what is left of that
    margin_asked: int  # and whether it is asked for now


class RigidNumbers(Block):
    """Numbers of a run."""

    atol: float
    rtol: float
    determinant: float  # det A over that without friction, of the island where it is least
    shift: float  # of its diagonal where contacts are redundant
    flight: float  # [s] that the shortest flight lasts which has just begun
    drift: float  # [m] the largest gap of a closed contact
    margin: float  # [N] of the share of redundant contacts


class RigidContacts(Block, r="max(1, n_c * (1 + d))"):
    """The contacts of a run. n = n_u, c = n_c, r = rows."""

    work: Work
    facts: RigidFacts
    numbers: RigidNumbers
    mode: Array[Ints, "n_c"]  # ContactMode
    slip: Array[Ints, "n_c"]  # sign of sliding
    sign: Array[Ints, "n_c"]  # sign of la_N
    q: Array[Floats, "n"]
    u: Array[Floats, "n"]
    la: Array[Floats, "n_c", 2]  # forces
    gamma: Array[Floats, "n_c", 2]  # contact velocities
    size: Array[Floats, "n_c"]  # what the terms of la_N add up to without their signs
    ratio: Array[Floats, "n_c"]  # la_F/la_N of a slide
    determinant: Array[Floats, "n_c"]  # det A over that without friction, of the island of each contact
    is_shared: Array[Ints, "n_c"]  # IS_SHARED of the island of each contact
    is_admissible: Array[Ints, "n_c"]  # and IS_ADMISSIBLE
    margin: Array[Floats, "n_c"]  # and its margin [N], 1 where that was not asked for
    is_alone: Array[Ints, "n_c"]  # 1 for the only contact of an island
    several: Array[Ints, "n_c"]  # 1 where several forces fit the slide, and that was noted
    place: Array[Ints, "n_c"]  # position of each closed contact in work.closed
    held: Array[Ints, "n_c"]  # rows of each of these that the modes hold at zero
    island: Array[Ints, "n_c"]  # and the number of its island
    rates: Array[Floats, 4, "r"]  # W' u + w'
    row: Array[Ints, "r"]  # row of G of each equation
    contact: Array[Ints, "r"]  # contact of each equation
    part: Array[Ints, "r"]  # whether an equation is normal (0) or tangential (1)
    A: Array[Floats, "r", "r"]
    factor: Array[Floats, "r", "r"]
    order: Array[Ints, "r"]
    b: Array[Floats, "r"]
    z: Array[Floats, "r"]
    left: Array[Floats, "r"]  # scratch
    sum: Array[Floats, "r"]  # scratch
    redundant: Redundant


@kernel
def small_speed(sys, contacts):
    """A contact velocity that counts as zero [m/s]: rounding of the velocities, of atol where all are smaller."""
    return rounded_sum(EVENT_ROUNDINGS, fastest_velocity(sys, contacts) + contacts.numbers.atol)


@kernel
def rounded_length(n, contacts):
    """What rounding leaves of a gap that is zero [m]."""
    return rounded_sum(EVENT_ROUNDINGS, longest(n, contacts)) + NOTHING


@kernel
def longest(n, contacts):
    """The largest coordinate."""
    largest = 0.0
    for j in range(n):
        largest = max(largest, abs(contacts.q[j]))
    return largest


@kernel
def closed_problem(sys, t, x, contacts):
    """The acceleration-level problem of the contacts that are not open, and their velocities: (Status, contacts)."""
    work = contacts.work
    n_k = list_closed(sys, x, contacts)
    if n_k == 0:
        return free_acceleration(sys, True, t, contacts.u, work), 0
    status, _ = acceleration_problem(sys, t, contacts.q, contacts.u, n_k, contacts.rates, work)
    row_velocities(sys, n_k, contacts.u, work)
    set_velocities(sys, n_k, contacts)
    return status, n_k


@kernel
def closed_constraints(sys, t, x, contacts):
    """The constraints of the contacts that are not open, and their velocities: (Status, contacts)."""
    n_k = list_closed(sys, x, contacts)
    if n_k == 0:
        return Status.RUNNING.value, 0
    status, _ = constraint_problem(sys, t, contacts.q, contacts.u, n_k, contacts.work)  # fmt: skip
    set_velocities(sys, n_k, contacts)
    return status, n_k


@kernel
def list_closed(sys, x, contacts):
    """Take q and u from the state, and list the contacts that are not open; returns their number."""
    work, n = contacts.work, sys.n
    for j in range(n):
        contacts.q[j], contacts.u[j] = x[j], x[n + j]
        work.q_mid[j] = x[j]
    n_k = 0
    for i in range(sys.n_c):
        contacts.gamma[i, 0], contacts.gamma[i, 1] = 0.0, 0.0
        if contacts.mode[i] != ContactMode.OPEN:
            work.closed[n_k] = i
            n_k += 1
    return n_k


@kernel
def set_velocities(sys, n_k, contacts):
    """The velocities of the closed contacts from those of their rows."""
    work, kinds = contacts.work, sys.kinds
    for k in range(n_k):
        i = work.closed[k]
        if kinds[i, 0] != GIVEN_FORCE:
            contacts.gamma[i, 0] = work.gamma_0[work.start[k]]
        if kinds[i, 1] > 0:
            contacts.gamma[i, 1] = work.gamma_0[work.start[k + 1] - 1]


@kernel
def note_side(sys, i, contacts):
    """Note the sign of la_N of a bilateral contact that sticks, at the state whose forces are in ``contacts``."""
    if sys.kinds[i, 0] == BILATERAL and contacts.mode[i] == ContactMode.STICK:
        contacts.sign[i] = -1 if contacts.la[i, 0] < 0.0 else 1


@kernel
def find_ratios(sys, n_k, contacts):
    """la_F/la_N of the contacts that slide, and la_F where the normal force is given; False where mu(v) is none."""
    work, la = contacts.work, contacts.la
    for k in range(n_k):
        i = work.closed[k]
        is_given = sys.kinds[i, 0] == GIVEN_FORCE
        if is_given:
            la[i, 0] = max(0.0, work.N[i])
        if contacts.mode[i] != ContactMode.SLIDE:
            continue
        s = contacts.slip[i]
        mu = friction_coefficient(sys.laws, i, max(0.0, s * contacts.gamma[i, 1]))
        contacts.ratio[i] = -s * mu * contacts.sign[i]
        if is_given:
            la[i, 1] = -s * mu * la[i, 0]
        if is_no_friction(mu):
            return False
    return True


@kernel
def list_islands(sys, n_k, contacts):
    """Number the islands of the closed contacts in their modes; returns how many."""
    work, kinds = contacts.work, sys.kinds
    for k in range(n_k):
        i = work.closed[k]
        has_normal = 1 if kinds[i, 0] != GIVEN_FORCE else 0
        contacts.place[i] = k
        contacts.held[k] = has_normal + (1 if contacts.mode[i] == ContactMode.STICK else 0)
    return find_held_islands(n_k, work.start, contacts.held, work.G, contacts.island)


@kernel
def list_equations(sys, n_k, contacts):
    """``list_equations_of`` all contacts."""
    return list_equations_of(sys, EVERY, n_k, contacts)


@kernel
def list_equations_of(sys, island, n_k, contacts):
    """The rows that the modes hold at zero, of the contacts of an island: normal, then tangential where a contact
    sticks; returns their number."""
    work = contacts.work
    m = 0
    for k in range(n_k):
        if island != EVERY and contacts.island[k] != island:
            continue
        i = work.closed[k]
        if sys.kinds[i, 0] != GIVEN_FORCE:
            contacts.row[m], contacts.contact[m], contacts.part[m] = work.start[k], i, 0
            m += 1
        if contacts.mode[i] == ContactMode.STICK:
            contacts.row[m], contacts.contact[m], contacts.part[m] = work.start[k + 1] - 1, i, 1
            m += 1
    return m


@kernel
def decompose_both(m, contacts):
    """``decompose`` with friction, and return as it does, with the determinant over that without (1 if none slides)."""
    slides = False
    for e in range(m):
        slides = slides or contacts.mode[contacts.contact[e]] == ContactMode.SLIDE
    frictionless = 1.0
    if slides:
        decompose(m, False, contacts)
        frictionless = contacts.numbers.determinant
    smallest = decompose(m, True, contacts)
    contacts.numbers.determinant = contacts.numbers.determinant / frictionless if slides else 1.0
    return smallest


@kernel
def factorise(m, with_friction, contacts):
    """LU factors of A, of A + shift where contacts are redundant; with_friction adds the columns of sliding
    friction."""
    if decompose(m, with_friction, contacts) == 0.0:
        regularise(m, contacts)


@kernel
def decompose(m, with_friction, contacts):
    """``decompose_alone``, and leave the determinant in numbers, 1 if A is singular."""
    work, factor, row = contacts.work, contacts.factor, contacts.row
    smallest = decompose_alone(m, with_friction, contacts)
    contacts.numbers.determinant = 1.0
    if smallest > 0.0:
        determinant, scale = 1.0, 1.0
        for e in range(m):
            determinant *= abs(factor[e, e])
            scale *= work.G[row[e], row[e]]
        is_positive = determinant_is_positive(m, factor, contacts.order, contacts.sum)
        contacts.numbers.determinant = determinant / scale if is_positive else -determinant / scale
    return smallest


@kernel
def decompose_alone(m, with_friction, contacts):
    """LU factors of A; returns the smallest pivot over the entries of G that stand for its row and its column, since
    masses of different size make some rows small: 0 if A is singular."""
    work, A, factor, row = contacts.work, contacts.A, contacts.factor, contacts.row
    for f in range(m):
        i = contacts.contact[f]
        slides = with_friction and contacts.mode[i] == ContactMode.SLIDE
        for e in range(m):
            A[e, f] = work.G[row[e], row[f]]
            if slides:
                A[e, f] += contacts.ratio[i] * work.G[row[e], row[f] + 1]
            factor[e, f] = A[e, f]
    contacts.numbers.shift = 0.0
    if not lu(m, factor, contacts.order):
        return 0.0
    smallest = math.inf
    for e in range(m):
        a, b = row[contacts.order[e]], row[e]
        scale = math.sqrt(abs(work.G[a, a])) * math.sqrt(abs(work.G[b, b]))  # of the product of two small ones 0
        smallest = min(smallest, abs(factor[e, e]) / scale)
    return smallest


@rare_kernel
def regularise(m, contacts):
    """LU factors of A + shift."""
    A, factor, trace = contacts.A, contacts.factor, 0.0
    for e in range(m):
        trace += contacts.work.G[contacts.row[e], contacts.row[e]]
    contacts.numbers.shift = REGULARISATION * trace
    for e in range(m):
        for f in range(m):
            factor[e, f] = A[e, f]
        factor[e, e] += contacts.numbers.shift
    lu(m, factor, contacts.order)


@kernel
def solve_equations(m, contacts):
    """A z = b, by proximal iterations where A is singular."""
    b, z, left, total = contacts.b, contacts.z, contacts.left, contacts.sum
    lu_solve(m, contacts.factor, contacts.order, b, z)
    if contacts.numbers.shift == 0.0:
        return
    for _ in range(REFINEMENTS):
        for e in range(m):
            left[e] = b[e]
            for f in range(m):
                left[e] -= contacts.A[e, f] * z[f]
        lu_solve(m, contacts.factor, contacts.order, left, total)
        for e in range(m):
            z[e] += total[e]
