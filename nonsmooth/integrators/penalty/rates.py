"""The equations of motion with compliant contacts, mode by mode.

    q' = B u,   M u' = h + W_N^T la_N + W_F^T la_F,   z' = omega v,   v' = W_N u' + W_N' u + w_N' - alpha (v - gamma_N)

with z = omega g_N and v = gamma_N = W_N u + w_N. The gap and its rate are variables of their own, beside coordinates
and velocities: computed from them, an indentation of 1e-11 m at a coordinate of 1 m keeps five digits only, and a
normal velocity of 1e-9 m/s, which a damper of 1e10 N s/m makes 10 N of, no more; the force would have no more either.
Times the contact frequency omega a gap has the size of a velocity, and the Jacobian is balanced. What the integration
leaves between v and W_N u is forgotten at the rate alpha. The normal force is a function of (g_N, v); friction is

    sliding with sign s      la_F = -s mu(|gamma_F|) |la_N|
    sticking                 la_F from gamma_F' = W_F u' + W_F' u + w_F' = 0, with the normal forces given
    regularised              la_F = -mu(|gamma_F|) |la_N| tanh(gamma_F / v_s)

where redundant sticking contacts share their load with the least squares. In space gamma_F, la_F and W_F have two
directions, and s is the direction gamma_F/|gamma_F|, which has no limit where sliding stops: behind that place the one
in which it came goes on (``find_direction``), so that the rates are smooth in each mode, as the sign of the plane is.
The events that end a mode are those of penalty/switching.py. Trailing components are the impulses and the energy
ledger: x = (q, u, z, v, P_N, P_F, works).
Source: Brogliato, *Nonsmooth Mechanics* (2016), chapter 2; docs/penalty.md, (1) and (2).
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.errors import Status
from nonsmooth.integrators.penalty.law import NormalLaw, normal_force
from nonsmooth.integrators.radau.stages import RATES
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, view
from nonsmooth.mechanics.acceleration_problem import find_row_rates, free_acceleration, row_shift
from nonsmooth.mechanics.contact_problem import Work, evaluate_rows, stack_rows
from nonsmooth.mechanics.kinematics import coordinate_rates, find_kinematics
from nonsmooth.mechanics.laws import friction_coefficient, is_no_friction
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, ROW_RATES, ContactMode
from nonsmooth.numerics.dense import bandwidth, cholesky, cholesky_solve

# columns of a contact's constants
K, C_N, OMEGA = range(3)
REGULARISATION = 1e-10  # chosen: of the trace: makes redundant contacts share their load
REFINEMENTS = 3  # chosen: of the solution with that part, which leave (1e-10)^4 of it
# derived: alpha/omega: a difference between v and W_N u costs a force alpha/G of it, a hundredth of what an error of
# the same size in z = omega g_N costs
FORGETTING = 0.01


class CompliantFacts(Block):
    """Whole numbers of a run."""

    law: int  # of the normal force
    is_regularised: int  # friction, by a speed v_s
    is_known: int  # whether the constant parts of the model were evaluated


class CompliantNumbers(Block):
    """Numbers of a run."""

    v_s: float  # [m/s]
    v_stop: float  # [m/s] of sliding in space that counts as none
    rtol: float
    zeta: float  # damping ratio; -1 where c is given
    atol: float


class Contacts(Block, r="max(1, n_c * (1 + d))", w="max(1, d)", n_q=0):
    """The contacts of a run. n = n_u, c = n_c, w = columns of friction, n_q = 0 where q' = u."""

    work: Array[Work, "n_q = n_q"]
    facts: CompliantFacts
    numbers: CompliantNumbers
    constants: Array[Floats, "n_c", 3]  # k, c, omega
    mode: Array[Ints, "n_c"]  # ContactMode
    slip: Array[Ints, "n_c"]  # sign of sliding; 1 in space
    course: Array[Floats, "n_c", 2]  # in space: the direction of sliding at the last step
    way: Array[Floats, "n_c", "w"]  # s: the direction of sliding, in the plane its sign
    sign: Array[Ints, "n_c"]  # sign of la_N
    q: Array[Floats, "n_q or n"]
    u: Array[Floats, "n"]
    la: Array[Floats, "n_c", "1 + w"]  # forces
    gamma: Array[Floats, "n_c", "1 + w"]  # contact velocities, the normal one v
    n_stuck: int
    stuck: Array[Ints, "n_c * w"]  # rows of friction of the sticking contacts
    A: Array[Floats, "n_c * w", "n_c * w"]  # W_F M^-1 W_F^T of these
    factor: Array[Floats, "n_c * w", "n_c * w"]
    rhs: Array[Floats, "n_c * w"]
    residual: Array[Floats, "n_c * w"]
    rates: Array[Floats, 4, "r"]  # W' u + w'


@kernel(RATES, short_loops=True)
def contact_rates(sys_at, contacts_at, t, x, out):
    """x' with x = (q, u, z, v, P_N, P_F, works); a radau ``rates`` function. Returns a Status."""
    sys = view(sys_at, Sys)
    contacts = view(contacts_at, Contacts)
    work, la, gamma = contacts.work, contacts.la, contacts.gamma
    n, n_c = sys.n, sys.n_c
    status = find_forces(sys, t, x, contacts)
    if status != Status.RUNNING:
        return status
    total, first = 0.0, sys.n_q + n
    coordinate_rates(sys, contacts.u, work, out)
    for i in range(n):
        out[sys.n_q + i] = work.du[i]
        total += 0.0 * work.du[i]
    P_N = first + 2 * n_c
    force, friction, normal, surface = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        force += work.h[i] * contacts.u[i]
    for i in range(n_c):
        out[first + i] = contacts.constants[i, OMEGA] * gamma[i, 0]
        out[first + n_c + i] = normal_acceleration(sys, i, contacts)
        for part in range(la.shape[1]):
            out[P_N + part * n_c + i] = la[i, part]
        if sys.kinds[i, 0] != GIVEN_FORCE:
            normal += la[i, 0] * gamma[i, 0]
            surface -= la[i, 0] * work.w_N[i]
        for axis in range(sys.kinds[i, 1]):
            friction += la[i, 1 + axis] * gamma[i, 1 + axis]
            surface -= la[i, 1 + axis] * work.w_F[i, axis]
    end = P_N + la.shape[1] * n_c
    out[end], out[end + 1], out[end + 2], out[end + 3] = force, friction, normal, surface
    return Status.RUNNING.value if total == 0.0 else Status.NOT_FINITE.value


@kernel
def normal_acceleration(sys, i, contacts):
    """v' of contact i, with the accelerations that were found."""
    n = sys.n
    if sys.kinds[i, 0] == GIVEN_FORCE:
        return 0.0
    work, a = contacts.work, contacts.work.start[i]
    total = contacts.rates[0, a]
    for j in range(n):
        total += work.W_N[i, j] * work.du[j]
    return total - FORGETTING * contacts.constants[i, OMEGA] * (contacts.gamma[i, 0] - work.gamma_0[a])


@kernel
def find_forces(sys, t, x, contacts):
    """contacts.la, contacts.gamma and work.du = u' at a state; returns a Status."""
    work, facts = contacts.work, contacts.facts
    n, n_c = sys.n, sys.n_c
    for i in range(n_c):
        work.closed[i] = i
    for i in range(sys.n_q):
        contacts.q[i] = x[i]
    for i in range(n):
        contacts.u[i] = x[sys.n_q + i]
    if not find_kinematics(sys, t, contacts.q, contacts.u, work):
        return Status.NOT_FINITE
    if n_c > 0:
        if not find_row_rates(sys, row_shift(sys, contacts.u), t, contacts.q, contacts.u, n_c, contacts.rates, work):
            return Status.NOT_FINITE
    for i in range(sys.n_q):
        work.q_mid[i] = contacts.q[i]
    is_first = facts.is_known == 0
    status = free_acceleration(sys, is_first, t, contacts.u, work)
    if status != Status.RUNNING:
        return status
    if n_c == 0:
        return Status.RUNNING
    are_moved = sys.has & (1 << ROW_RATES) == 0  # the rows are those of the last difference
    if not evaluate_rows(sys, is_first or are_moved, t, contacts.u, work):
        return Status.NOT_FINITE
    facts.is_known = 1
    stack_rows(sys, n_c, contacts.u, work)
    if not given_forces(sys, x, contacts):
        return Status.NEGATIVE_FRICTION
    accelerate(sys, contacts)
    list_stuck(sys, contacts)
    if contacts.n_stuck > 0:
        hold_sticking(sys, contacts)
    return Status.RUNNING


@kernel
def list_stuck(sys, contacts):
    """The rows of friction of the contacts that stick."""
    contacts.n_stuck = 0
    for i in range(sys.n_c):
        if contacts.mode[i] == ContactMode.STICK:
            for b in range(contacts.work.start[i + 1] - sys.kinds[i, 1], contacts.work.start[i + 1]):
                contacts.stuck[contacts.n_stuck] = b
                contacts.n_stuck += 1


@kernel
def given_forces(sys, x, contacts):
    """The forces that the state gives: all but the friction of sticking contacts; False where mu(v) is none."""
    first = sys.n_q + sys.n
    work, la, gamma, law = contacts.work, contacts.la, contacts.gamma, contacts.facts.law
    for i in range(sys.n_c):
        kind, d = sys.kinds[i, 0], sys.kinds[i, 1]
        mode = contacts.mode[i]
        for part in range(la.shape[1]):
            la[i, part], gamma[i, part] = 0.0, 0.0
        if kind == GIVEN_FORCE:
            la[i, 0] = max(0.0, work.N[i])
        else:
            gamma[i, 0] = x[first + sys.n_c + i]
            if mode != ContactMode.OPEN:
                k, c, omega = contacts.constants[i, K], contacts.constants[i, C_N], contacts.constants[i, OMEGA]
                a_law = NormalLaw.KELVIN_VOIGT.value if kind == BILATERAL else law
                la[i, 0] = normal_force(a_law, k, c, -x[first + i] / omega, -gamma[i, 0])
        if d == 0:
            continue
        for axis in range(d):
            gamma[i, 1 + axis] = work.gamma_0[work.start[i + 1] - d + axis]
        if mode != ContactMode.SLIDE:
            continue
        limit = la[i, 0] * contacts.sign[i]
        if contacts.facts.is_regularised != 0:
            mu = regularised_friction(sys, i, limit, contacts)
        else:
            mu = friction_coefficient(sys.laws, i, max(0.0, find_direction(d, i, contacts)))
            for axis in range(d):
                la[i, 1 + axis] = -contacts.way[i, axis] * mu * limit
        if is_no_friction(mu):
            return False
    return True


@kernel
def find_direction(d, i, contacts):
    """Write the direction s in which contact i slides, to ``way``; returns its speed.

    In space, with the course c of the step and a = c.gamma_F: gamma_F/|gamma_F| where a >= v_stop; below, gamma_F with
    the part a replaced by v_stop, and the speed falls through zero with a.
    """
    gamma, way, course = contacts.gamma, contacts.way, contacts.course
    if d == 1:
        way[i, 0] = contacts.slip[i]
        return contacts.slip[i] * gamma[i, 1]
    along = course[i, 0] * gamma[i, 1] + course[i, 1] * gamma[i, 2]
    lift = max(0.0, contacts.numbers.v_stop - along)
    x, y = gamma[i, 1] + lift * course[i, 0], gamma[i, 2] + lift * course[i, 1]
    size = math.sqrt(x * x + y * y)
    way[i, 0], way[i, 1] = x / size, y / size
    return size - lift


@kernel
def regularised_friction(sys, i, limit, contacts):
    """Write la_F = -mu(|gamma_F|) limit tanh(|gamma_F|/v_s) gamma_F/|gamma_F| of contact i; returns mu."""
    gamma, v_s = contacts.gamma, contacts.numbers.v_s
    speed = length_along(contacts.gamma, i)
    mu = friction_coefficient(sys.laws, i, speed)
    part = math.tanh(speed / v_s) / speed if speed > 0.0 else 1.0 / v_s
    for axis in range(sys.kinds[i, 1]):
        contacts.la[i, 1 + axis] = -mu * limit * part * gamma[i, 1 + axis]
    return mu


@kernel
def length_along(pairs, i):
    """The length of what row i has along the surface, behind its normal part."""
    total = 0.0
    for part in range(1, pairs.shape[1]):
        total += pairs[i, part] * pairs[i, part]
    return math.sqrt(total)


@kernel
def accelerate(sys, contacts):
    """work.du = M^-1 (h + W^T la) with the forces that are known."""
    n, n_c = sys.n, sys.n_c
    work, la = contacts.work, contacts.la
    rhs, W, W_N = work.rhs, work.W, work.W_N
    for j in range(n):
        rhs[j] = 0.0
    for i in range(n_c):
        if sys.kinds[i, 0] != GIVEN_FORCE and la[i, 0] != 0.0:
            for j in range(n):
                rhs[j] += W_N[i, j] * la[i, 0]
        d = sys.kinds[i, 1]
        for axis in range(d):
            if la[i, 1 + axis] != 0.0:
                b = work.start[i + 1] - d + axis
                for j in range(n):
                    rhs[j] += W[b, j] * la[i, 1 + axis]
    cholesky_solve(n, work.band, work.factor, rhs)
    for j in range(n):
        work.du[j] += rhs[j]


@kernel
def hold_sticking(sys, contacts):
    """The friction of the sticking contacts, A la_F = -(W_F u' + W_F' u + w_F'), added to la and to work.du."""
    n, n_stuck = sys.n, contacts.n_stuck
    work, stuck, rhs = contacts.work, contacts.stuck, contacts.rhs
    sticking_matrix(n, contacts)
    for a in range(n_stuck):
        b = stuck[a]
        total = contacts.rates[0, b]
        for j in range(n):
            total += work.W[b, j] * work.du[j]
        rhs[a] = -total
    share_friction(n_stuck, contacts)
    a = 0
    for i in range(sys.n_c):
        if contacts.mode[i] == ContactMode.STICK:
            for axis in range(sys.kinds[i, 1]):
                contacts.la[i, 1 + axis] = rhs[a]
                a += 1
    for a in range(n_stuck):
        for j in range(n):
            work.du[j] += work.X[stuck[a], j] * rhs[a]


@kernel
def sticking_matrix(n, contacts):
    """A = W_F M^-1 W_F^T of the sticking contacts."""
    n_stuck = contacts.n_stuck
    work, stuck, A, trial = contacts.work, contacts.stuck, contacts.A, contacts.work.trial
    for a in range(n_stuck):
        row = stuck[a]
        for j in range(n):
            trial[j] = work.W[row, j]
        cholesky_solve(n, work.band, work.factor, trial)
        for j in range(n):
            work.X[row, j] = trial[j]
        for b in range(n_stuck):
            total = 0.0
            for j in range(n):
                total += work.W[stuck[b], j] * trial[j]
            A[b, a] = total


@kernel
def share_friction(n_stuck, contacts):
    """Overwrite rhs with the least solution of A la = rhs, by proximal iterations on (A + shift)."""
    A, factor, rhs, residual = contacts.A, contacts.factor, contacts.rhs, contacts.residual
    if n_stuck == 1:
        rhs[0] /= A[0, 0]
        return
    shift = 0.0
    for a in range(n_stuck):
        shift += REGULARISATION * A[a, a]
    for a in range(n_stuck):
        A[a, a] += shift
        residual[a] = rhs[a]
        rhs[a] = 0.0
    band = bandwidth(n_stuck, A)
    cholesky(n_stuck, band, A, factor)
    for _ in range(REFINEMENTS):
        cholesky_solve(n_stuck, band, factor, residual)
        for a in range(n_stuck):
            rhs[a] += residual[a]
            residual[a] *= shift  # (A + shift) x = r leaves r - A x = shift x
