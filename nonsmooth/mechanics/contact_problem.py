"""The contact problem of a step: rows, Delassus matrix, right-hand side.

    gamma = G P + c,    G = W Mhat^-1 W^T,    c = W (u_0 + Mhat^-1 dt h) + w,    Mhat = M + theta dt C + theta^2 dt^2 K

The rows of the closed contacts stand one below the other, per contact (N, T), N alone without friction, T alone for a
contact with a given normal force. M, h and W are taken at the mid-point (t_0 + dt/2, q_0 + dt/2 u_0), the velocities at
the ends of the step: where rows vary, c holds W_1 u, W_1 = W(q_0 + dt u_0), so that a contact that slides along a curve
leaves it by O(dt^2) only and meets the very b = W M^-1 h + W' u + w' of the acceleration level. With theta = 1/2 and
C = K = 0 this is Moreau's time stepping. Source: Jean,
*Comput. Methods Appl. Mech. Engrg.* 177 (1999) 235.
Equations: docs/theory/moreau_jean.md, (2), (4) and (5).
"""

from __future__ import annotations

import math
import operator
import weakref
from typing import Annotated as Array
from typing import Any

from nonsmooth.errors import Status
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import Block, Floats, Ints
from nonsmooth.mechanics.kinematics import has_kinematics, move
from nonsmooth.mechanics.laws import LAW_E_F, LAW_E_N, LAW_WIDTH, copy_friction
from nonsmooth.mechanics.sys import evaluate
from nonsmooth.mechanics.system import (
    BILATERAL,
    DAMPING,
    FORCE,
    GAP_RATE,
    GIVEN_FORCE,
    MASS,
    NORMAL,
    NORMAL_FORCE,
    STIFFNESS,
    SURFACE_VELOCITY,
    TANGENT,
    UNILATERAL,
    System,
)
from nonsmooth.numerics.dense import bandwidth, cholesky, cholesky_solve, cholesky_solve_rows, lu, lu_solve
from nonsmooth.numerics.rounding import NOTHING, rounded_sum

# code: facts about a model, beside one bit for each function it has.
MASS_IS_CONSTANT, ROWS_ARE_CONSTANT, SURFACES_ARE_CONSTANT = 1 << 16, 1 << 17, 1 << 18
# code: bits of the facts of a model
DAMPING_BY_DIFFERENCES, STIFFNESS_BY_DIFFERENCES, NORMAL_FORCE_READS_U = 1 << 19, 1 << 20, 1 << 21
ROWS_READ_T = 1 << 22  # code: bit of the facts of a model
SHORT_ROW = 3  # chosen: columns of a row that are summed without a look for zeros, which a loop for one system unrolls
FREE_ROUNDINGS = 18  # chosen: of the terms of c, which are a few: a smaller one is none
FORCE_INCREMENT = 1.5e-8  # derived: sqrt(eps), the relative increment of a forward difference of the forces


class Problem(Block, r="max(1, n_c * (1 + d))"):
    """The problem of n closed contacts on a dense matrix: gamma = G P + c within the laws of contact and friction.

    Impulses and velocities, or forces and accelerations. A contact has the rows N and F, N alone without friction, F
    alone under a given normal force. n_c = most contacts, r = most rows, d = directions of friction.
    """

    n: int  # contacts
    r: int  # rows
    selection: int  # the rule where there are several solutions
    closed: Array[Ints, "n_c"]  # number of each contact in the system
    start: Array[Ints, "n_c + 1"]  # its first row
    kinds: Array[Ints, "n_c", 2]  # unilateral, bilateral or given force; its directions of friction
    laws: Array[Floats, "n_c", LAW_WIDTH]  # of friction alone
    G: Array[Floats, "r", "r"]  # Delassus matrix
    c: Array[Floats, "r"]  # velocities without impulses
    offset: Array[Floats, "r"]  # (1 - e_F) gamma_F before the step: mu(v) is taken at half offset + gamma_F
    mu: Array[Floats, "n_c"]  # coefficient of sliding
    mu_static: Array[Floats, "n_c"]
    normal_impulse: Array[Floats, "n_c"]  # where it is given
    mode: Array[Ints, "n_c"]  # ContactMode before
    slip: Array[Ints, "n_c"]  # sign of sliding before; of a bilateral contact without friction that of its P_N, or 0
    previous_P: Array[Floats, "n_c", "1 + d"]  # impulses before
    P: Array[Floats, "r"]  # the answer: impulses
    candidate: Array[Ints, "n_c"]  # and modes, as contact/planar/single.py numbers them


class Work(Problem, r="max(1, n_c * (1 + d))", n_q=0):
    """Arrays of one step, allocated once a run: the problem of its closed contacts, and what that is made from.
    n = n_u, c = n_c, r = most rows that can be closed, n_q = 0 where q' = u."""

    q_mid: Array[Floats, "n_q or n"]
    q_end: Array[Floats, "n_q or n"]  # scratch, and with kinematics the coordinates after the step
    B: Array[Floats, "n_q", "n"]  # q' = B u, mostly at the mid-point
    h: Array[Floats, "n"]  # force, then the force actually applied
    du: Array[Floats, "n"]  # Mhat^-1 dt h
    trial: Array[Floats, "n"]  # scratch
    rhs: Array[Floats, "n"]  # scratch
    M: Array[Floats, "n", "n"]
    band: int  # bandwidth of M
    factor: Array[Floats, "n", "n"]  # Cholesky factor of M
    Mhat: Array[Floats, "n", "n"]  # LU factors of Mhat
    C: Array[Floats, "n", "n"]
    K: Array[Floats, "n", "n"]
    order: Array[Ints, "n"]  # row order of the LU factors
    g_N: Array[Floats, "n_c"]
    W_N: Array[Floats, "n_c", "n"]
    W_F: Array[Floats, "n_c", "d", "n"]
    w_N: Array[Floats, "n_c"]
    w_F: Array[Floats, "n_c", "d"]
    N: Array[Floats, "n_c"]  # given normal forces
    rates: Array[Floats, "n_c", "1 + d"]  # W' u + w' as the model gives them
    W: Array[Floats, "r", "n"]
    first: Array[Ints, "r"]  # each row of W, unless it is a short one, is zero before this column
    last: Array[Ints, "r"]  # and from this one on
    X: Array[Floats, "r", "n"]  # rows of W Mhat^-1
    w: Array[Floats, "r"]
    gamma_0: Array[Floats, "r"]  # velocities before the step
    gamma_1: Array[Floats, "r"]  # G P + c without restitution and feedback: the velocities after the step
    u_1: Array[Floats, "n"]  # velocities after the step
    shock: Array[Floats, "r"]  # impulses of a law of impact of several contacts, beside those of the problem
    c_kept: Array[Floats, "r"]  # c without them


_known_facts: weakref.WeakKeyDictionary[System, tuple[list[Any], int]] = weakref.WeakKeyDictionary()


def model_facts(system: System) -> int:
    """The ``has`` argument of the kernels: a bit for each function of the model, and what is constant in it.

    Read anew where a function was given other code, as an editor does that loads a changed file into its process.
    """
    codes = [getattr(function, "__code__", None) for function in system.functions.values()]
    known, has = _known_facts.get(system, ([], 0))
    if len(known) != len(codes) or any(map(operator.is_not, known, codes)):
        has = _read_facts(system)
        _known_facts[system] = codes, has
    return has


def _read_facts(system: System) -> int:
    has = sum(1 << which for which in system.functions)
    if not system.reads(MASS, "t") and not system.reads(MASS, "q"):
        has |= MASS_IS_CONSTANT
    rows = (NORMAL, TANGENT)
    if not any(system.reads(which, argument) for which in rows for argument in ("t", "q")):
        has |= ROWS_ARE_CONSTANT
    surfaces = (GAP_RATE, SURFACE_VELOCITY)
    if any(system.reads(which, "t") for which in rows + surfaces):
        has |= ROWS_READ_T
    if not any(system.reads(which, argument) for which in surfaces for argument in ("t", "q")):
        has |= SURFACES_ARE_CONSTANT
    if DAMPING not in system.functions and system.reads(FORCE, "u"):
        has |= DAMPING_BY_DIFFERENCES
    if system.stiffness == "differences":
        has |= STIFFNESS_BY_DIFFERENCES
    if system.reads(NORMAL_FORCE, "u"):
        has |= NORMAL_FORCE_READS_U
    return has


@kernel
def smooth_step(sys, is_first, t, dt, theta, u, work):
    """M, h and du = Mhat^-1 dt h at the mid-point; returns a Status."""
    n = sys.n
    status = factor_mass(sys, is_first, t, u, work)
    if status != Status.RUNNING:
        return status
    if not evaluate(sys, FORCE, t, work.q_mid, u, work.h):
        return Status.NOT_FINITE
    for i in range(n):
        work.du[i] = dt * work.h[i]
    if is_implicit(sys):
        return implicit_step(sys, t, dt, theta, u, work)
    cholesky_solve(n, work.band, work.factor, work.du)
    return Status.RUNNING


@kernel
def factor_mass(sys, is_first, t, u, work):
    """M at the mid-point and its Cholesky factor; returns a Status."""
    n = sys.n
    if is_first or not sys.has & MASS_IS_CONSTANT:
        if not evaluate(sys, MASS, t, work.q_mid, u, work.M):
            return Status.NOT_FINITE.value
        work.band = bandwidth(n, work.M)
        if not cholesky(n, work.band, work.M, work.factor):
            return Status.MASS_NOT_POSITIVE.value
    return Status.RUNNING.value


@kernel
def is_implicit(sys):
    """Whether a step is linearly implicit in the force."""
    return sys.has & (1 << DAMPING | 1 << STIFFNESS | DAMPING_BY_DIFFERENCES | STIFFNESS_BY_DIFFERENCES) != 0


@kernel
def implicit_step(sys, t, dt, theta, u, work):
    """du = Mhat^-1 dt (h - (theta - 1/2) dt K u): the force at the mid-point carried to q_0 + theta dt u."""
    n, has = sys.n, sys.has
    if has & DAMPING_BY_DIFFERENCES:
        for i in range(n):
            work.trial[i] = work.du[i]
        cholesky_solve(n, work.band, work.factor, work.trial)
        if not difference_forces(sys, t, work.q_mid, u, True, work):
            return Status.NOT_FINITE
    elif has & (1 << DAMPING) and not evaluate(sys, DAMPING, t, work.q_mid, u, work.C):
        return Status.NOT_FINITE
    if has & STIFFNESS_BY_DIFFERENCES:
        for i in range(n):
            work.trial[i] = dt * u[i]
        if has_kinematics(sys):
            if not difference_along(sys, t, u, work):
                return Status.NOT_FINITE
        elif not difference_forces(sys, t, work.q_mid, u, False, work):
            return Status.NOT_FINITE
    elif has & (1 << STIFFNESS) and not evaluate(sys, STIFFNESS, t, work.q_mid, u, work.K):
        return Status.NOT_FINITE
    M, C, K, Mhat, du, rhs = work.M, work.C, work.K, work.Mhat, work.du, work.rhs
    for i in range(n):
        for j in range(n):
            Mhat[i, j] = M[i, j] + theta * dt * (C[i, j] + theta * dt * K[i, j])
            du[i] -= dt * (theta - 0.5) * dt * K[i, j] * u[j]
        rhs[i] = du[i]
    if not lu(n, work.Mhat, work.order):
        return Status.MASS_NOT_POSITIVE
    lu_solve(n, work.Mhat, work.order, work.rhs, work.du)
    return Status.RUNNING


@kernel
def difference_forces(sys, t, q, u, by_velocity, work):
    """C = -dh/du or K = -dh/dq by forward differences; ``work.trial`` holds the expected change of each variable."""
    n = sys.n
    x = u if by_velocity else q
    out = work.C if by_velocity else work.K
    for j in range(n):
        x_j = x[j]
        size = abs(x_j) + abs(work.trial[j])
        step = FORCE_INCREMENT * size if size > NOTHING else FORCE_INCREMENT
        x[j] = x_j + step
        step = x[j] - x_j
        finished = evaluate(sys, FORCE, t, q, u, work.rhs)
        x[j] = x_j
        if not finished:
            return False
        for i in range(n):
            out[i, j] = (work.h[i] - work.rhs[i]) / step
    return True


@rare_kernel
def difference_along(sys, t, u, work):
    """K = -dh/dq B by forward differences along the columns of work.B; ``work.trial`` holds dt u."""
    n, n_q, q_mid, q = sys.n, sys.n_q, work.q_mid, work.q_end
    for j in range(n):
        size, reach = abs(work.trial[j]), 0.0
        for i in range(n_q):
            reach = max(reach, abs(q_mid[i]) if work.B[i, j] != 0.0 else 0.0)
        step = FORCE_INCREMENT * max(size + reach, FORCE_INCREMENT)
        for i in range(n_q):
            q[i] = q_mid[i] + step * work.B[i, j]
        if not evaluate(sys, FORCE, t, q, u, work.rhs):
            return False
        for i in range(n):
            work.K[i, j] = (work.h[i] - work.rhs[i]) / step
    return True


@kernel
def apply_inverse(sys, with_implicit, m, work):
    """X = W Mhat^-1 for the first m rows, or W M^-1 without the implicit part."""
    n = sys.n
    W, X = work.W, work.X
    if with_implicit:
        rhs, Mhat, order, trial = work.rhs, work.Mhat, work.order, work.trial
        for r in range(m):
            for i in range(n):
                rhs[i] = W[r, i]
            lu_solve(n, Mhat, order, rhs, trial)
            for i in range(n):
                X[r, i] = trial[i]
    else:
        for r in range(m):
            for i in range(n):
                X[r, i] = W[r, i]
        cholesky_solve_rows(n, work.band, work.factor, m, X)


@kernel
def evaluate_rows(sys, is_first, t, u, work):
    """Rows and given normal forces at the mid-point; False if a model function raised, or w or N is not finite.

    NaN in the rows comes out in the velocities; in w and N it would decide on a mode: max(0, N) is 0 then.
    """
    if not evaluate_unloaded_rows(sys, is_first, t, u, work):
        return False
    return not sys.has & (1 << NORMAL_FORCE) or find_loads(sys, t, u, work)


@kernel
def evaluate_unloaded_rows(sys, is_first, t, u, work):
    """W_N, W_F, w_N and w_F at the mid-point; False if a model function raised, or w is not finite."""
    has = sys.has
    if is_first or not has & ROWS_ARE_CONSTANT:
        if has & (1 << NORMAL) and not evaluate(sys, NORMAL, t, work.q_mid, u, work.W_N):
            return False
        if has & (1 << TANGENT) and not evaluate(sys, TANGENT, t, work.q_mid, u, work.W_F):
            return False
    if is_first or not has & SURFACES_ARE_CONSTANT:
        if has & (1 << GAP_RATE) and not evaluate(sys, GAP_RATE, t, work.q_mid, u, work.w_N):
            return False
        if has & (1 << SURFACE_VELOCITY) and not evaluate(sys, SURFACE_VELOCITY, t, work.q_mid, u, work.w_F):
            return False
    total = 0.0
    for i in range(work.w_N.shape[0]):
        total += 0.0 * work.w_N[i]
        for axis in range(work.w_F.shape[1]):
            total += 0.0 * work.w_F[i, axis]
    return total == 0.0


@kernel
def find_loads(sys, t, u, work):
    """The given normal forces at the velocities u, to work.N; False if the function raised or one is not finite."""
    total = 0.0
    if not evaluate(sys, NORMAL_FORCE, t, work.q_mid, u, work.N):
        return False
    for i in range(work.N.shape[0]):
        total += 0.0 * work.N[i]
    return total == 0.0


@kernel
def stack_rows(sys, n_k, u, work):
    """Stack the rows of the closed contacts and their velocities gamma_0; returns the number of rows."""
    n = sys.n
    closed, start, W, W_N = work.closed, work.start, work.W, work.W_N
    w, w_N, W_F, w_F, gamma_0 = work.w, work.w_N, work.W_F, work.w_F, work.gamma_0
    r = 0
    for k in range(n_k):
        i = closed[k]
        start[k] = r
        if sys.kinds[i, 0] != GIVEN_FORCE:
            for j in range(n):
                W[r, j] = W_N[i, j]
            w[r] = w_N[i]
            r += 1
        for axis in range(sys.kinds[i, 1]):
            for j in range(n):
                W[r, j] = W_F[i, axis, j]
            w[r] = w_F[i, axis]
            r += 1
    start[n_k] = r
    first, last = work.first, work.last
    for k in range(r):
        total = w[k]
        if n <= SHORT_ROW:
            for j in range(n):
                total += W[k, j] * u[j]
        else:
            first[k] = n
            last[k] = 0
            for j in range(n):
                if W[k, j] != 0.0:
                    total += W[k, j] * u[j]
                    first[k] = min(first[k], j)
                    last[k] = j + 1
        gamma_0[k] = total
    return r


@kernel
def row_velocities(sys, n_k, u, work):
    """gamma_0 of the closed contacts alone, without stacking their rows; returns the number of rows."""
    n = sys.n
    closed, gamma_0, W_N, w_N, W_F, w_F = work.closed, work.gamma_0, work.W_N, work.w_N, work.W_F, work.w_F
    r = 0
    for k in range(n_k):
        i = closed[k]
        if sys.kinds[i, 0] != GIVEN_FORCE:
            total = w_N[i]
            for j in range(n):
                total += W_N[i, j] * u[j]
            gamma_0[r] = total
            r += 1
        for axis in range(sys.kinds[i, 1]):
            total = w_F[i, axis]
            for j in range(n):
                total += W_F[i, axis, j] * u[j]
            gamma_0[r] = total
            r += 1
    return r


@kernel
def delassus(n, r, work):
    """G = W X^T and c = gamma_0 + W du."""
    W, X, G, gamma_0, du, c = work.W, work.X, work.G, work.gamma_0, work.du, work.c
    for k in range(r):
        first = 0 if n <= SHORT_ROW else work.first[k]
        last = n if n <= SHORT_ROW else work.last[k]
        for m in range(r):
            total = 0.0
            for j in range(first, last):
                total += W[k, j] * X[m, j]
            G[k, m] = total
        total = gamma_0[k]
        for j in range(first, last):
            total += W[k, j] * du[j]
        c[k] = total


@kernel
def clear_rounding(n, r, work):
    """c = 0 where it is rounding of its terms: where no load acts its sign would decide on a paradox."""
    W, du, c = work.W, work.du, work.c
    for k in range(r):
        size = abs(work.gamma_0[k])
        for j in range(n):
            size += abs(W[k, j] * du[j])
        if abs(c[k]) <= rounded_sum(FREE_ROUNDINGS, size) < math.inf:
            c[k] = 0.0


@kernel
def carry_to_ends(sys, t, dt, n_k, r, state, work, there):
    """Carry the contact velocities from the rows of the mid-point to those of the ends: gamma_0 to the beginning, c to
    the end. The change over half a step, (W_1 - W_mid) u_0 + w_1 - w_mid, is half the dt (W' u + w') of the step."""
    u = state.u
    if sys.has & ROWS_ARE_CONSTANT and sys.has & SURFACES_ARE_CONSTANT:
        return True
    move(sys, state.q, dt, u, work, there.q_mid)
    for k in range(n_k):
        there.closed[k] = work.closed[k]
    if not evaluate_rows(sys, True, t + dt, u, there):
        return False
    row_velocities(sys, n_k, u, there)
    gamma_0, gamma_1, c = work.gamma_0, there.gamma_0, work.c
    for k in range(r):
        change = gamma_1[k] - gamma_0[k]
        c[k] += change
        gamma_0[k] -= change
    return True


@kernel
def straighten_gaps(sys, dt, n_k, work, there):
    """Take the curvature of the constraints from the gaps at the mid-point, after ``carry_to_ends``.

    The mid-point lies off a curved constraint by (dt/2)^2 (W' u + w')/2 = dt/8 (gamma_1 - gamma_0). Fed back, that
    would disturb the first velocities after a start or an event by O(dt), and their impulses as much as the forces of
    the contacts are.
    """
    if sys.has & ROWS_ARE_CONSTANT and sys.has & SURFACES_ARE_CONSTANT:
        return
    for k in range(n_k):
        i = work.closed[k]
        if sys.kinds[i, 0] != GIVEN_FORCE:
            row = work.start[k]
            work.g_N[i] -= 0.125 * dt * (there.gamma_0[row] - work.gamma_0[row])


@kernel
def add_restitution(sys, n_k, feedback, work):
    """Newton's law, c += e gamma_0, and the gap fed back to closed contacts, c_N += feedback g_N."""
    closed, start, c, gamma_0, g_N = work.closed, work.start, work.c, work.gamma_0, work.g_N
    for k in range(n_k):
        i = closed[k]
        r = start[k]
        kind = sys.kinds[i, 0]
        if kind != GIVEN_FORCE:
            if kind == UNILATERAL:
                c[r] += sys.laws[i, LAW_E_N] * gamma_0[r]
            if kind == BILATERAL or g_N[i] > 0.0:
                c[r] += feedback * g_N[i]
            r += 1
        if sys.kinds[i, 1] > 0:
            c[r] += sys.laws[i, LAW_E_F] * gamma_0[r]
        if sys.kinds[i, 1] > 1:
            c[r + 1] += sys.laws[i, LAW_E_F] * gamma_0[r + 1]


@kernel
def fill_problem(sys, n, selection, mode, slip, problem):
    """What the problem of the n contacts in ``problem.closed`` must know of these beside rows, G and c: from the tables
    of the system, and their modes before."""
    problem.n, problem.r, problem.selection = n, problem.start[n], selection
    for k in range(n):
        i = problem.closed[k]
        problem.kinds[k, 0], problem.kinds[k, 1] = sys.kinds[i, 0], sys.kinds[i, 1]
        problem.mode[k], problem.slip[k] = mode[i], slip[i]
        copy_friction(sys.laws, i, problem.laws, k)


@kernel
def recall_impulses(P, problem):
    """The impulses before, (n_c, 1 + d), of the contacts of a problem."""
    for k in range(problem.n):
        for m in range(P.shape[1]):
            problem.previous_P[k, m] = P[problem.closed[k], m]


@kernel
def close_contacts(sys, mode, work):
    """List the contacts that take part in the step; returns their number.

    A unilateral contact is closed where the mid-point gap is not positive, or where it was active in the step before
    (then the gap fed back lets it part, but not hover). The given normal forces are not known yet: always listed.
    """
    n_c = sys.n_c
    n_k = 0
    for i in range(n_c):
        if sys.kinds[i, 0] != UNILATERAL or not work.g_N[i] > 0.0 or mode[i] != 0:
            work.closed[n_k] = i
            n_k += 1
    return n_k
