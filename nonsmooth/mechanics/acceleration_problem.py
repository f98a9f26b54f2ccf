"""The contact problem at acceleration level, at one state.

    dgamma/dt = G la + b,    G = W M^-1 W^T,    b = W M^-1 h + W' u + w'

It is the problem of ``contact_problem`` with the state in place of the mid-point, a unit step and the rates of the rows
in place of the velocities: a paradox is judged by the very problem that is integrated. Source: Glocker, *Set-Valued
Force Laws* (2001), chapter 5.
Equations: docs/theory/painleve.md, (1).
"""

from __future__ import annotations

from nonsmooth.errors import Status
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import view
from nonsmooth.mechanics.contact_problem import (
    ROWS_ARE_CONSTANT,
    ROWS_READ_T,
    SURFACES_ARE_CONSTANT,
    Work,
    apply_inverse,
    clear_rounding,
    delassus,
    evaluate_rows,
    evaluate_unloaded_rows,
    factor_mass,
    row_velocities,
    stack_rows,
)
from nonsmooth.mechanics.kinematics import find_kinematics, move
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import FORCE, GIVEN_FORCE, ROW_RATES
from nonsmooth.numerics.dense import cholesky_solve
from nonsmooth.numerics.rounding import NOTHING

# derived: W' u is a fourth-order difference over the time in which the fastest coordinate moves by this much:
# truncation (1e-4)^4 / 30 and rounding 1e-16 / 1e-4 both stay below 1e-11 of W' u where rows vary over a unit of the
# coordinates. Where rows or surfaces move with the time it is no more than so many seconds: a slow body says nothing
# of a table.
ROW_RATE_INCREMENT = 1e-4


@kernel
def acceleration_problem(sys, t, q, u, n_k, rates, work):
    """Fill work.W, work.G and work.c = b for the contacts listed in work.closed; returns (Status, rows).

    ``rates`` is scratch of shape (4, r), r the number of rows.
    """
    n, n_q = sys.n, sys.n_q
    for i in range(n_q):
        work.q_mid[i] = q[i]
    status = free_acceleration(sys, True, t, u, work)
    if status != Status.RUNNING:
        return status, 0
    if not find_kinematics(sys, t, q, u, work):
        return Status.NOT_FINITE, 0
    if not find_row_rates(sys, row_shift(sys, u), t, q, u, n_k, rates, work):
        return Status.NOT_FINITE, 0
    for i in range(n_q):
        work.q_mid[i] = q[i]
    if not evaluate_rows(sys, True, t, u, work):
        return Status.NOT_FINITE, 0
    r = stack_rows(sys, n_k, u, work)
    apply_inverse(sys, False, r, work)
    for k in range(r):
        work.gamma_0[k] = rates[0, k]
    delassus(n, r, work)
    clear_rounding(n, r, work)
    return Status.RUNNING if is_finite(n, r, work) else Status.NOT_FINITE, r


@kernel(
    "Tuple((int64, int64))(int64, float64, float64[::1], float64[::1], int64, float64[:, ::1], int64)", short_loops=True
)
def acceleration_problem_apart(sys_at, t, q, u, n_k, rates, work_at):
    """The same as an entry point: one copy for all that set it up now and then."""
    return acceleration_problem(view(sys_at, Sys), t, q, u, n_k, rates, view(work_at, Work))


@kernel
def free_acceleration(sys, is_first, t, u, work):
    """M, h and work.du = M^-1 h at work.q_mid, the acceleration without contacts; returns a Status."""
    status = factor_mass(sys, is_first, t, u, work)
    if status != Status.RUNNING:
        return status
    if not evaluate(sys, FORCE, t, work.q_mid, u, work.h):
        return Status.NOT_FINITE.value
    for i in range(sys.n):
        work.du[i] = work.h[i]
    cholesky_solve(sys.n, work.band, work.factor, work.du)
    return Status.RUNNING.value


@kernel
def constraint_problem(sys, t, q, u, n_k, work):
    """Fill work.W, work.X, work.G and the velocities work.gamma_0 for the contacts listed in work.closed: what the
    constraints ask of a state, without forces; returns (Status, rows)."""
    n = sys.n
    for i in range(sys.n_q):
        work.q_mid[i] = q[i]
    status = factor_mass(sys, True, t, u, work)
    if status != Status.RUNNING:
        return status, 0
    if not evaluate_rows(sys, True, t, u, work):
        return Status.NOT_FINITE, 0
    r = stack_rows(sys, n_k, u, work)
    apply_inverse(sys, False, r, work)
    for i in range(n):
        work.du[i] = 0.0
    delassus(n, r, work)
    return Status.RUNNING if is_finite(n, r, work) else Status.NOT_FINITE, r


@kernel
def is_finite(n, r, work):
    """Whether the accelerations without contact, G and b are: a comparison with NaN would decide on a mode."""
    total = 0.0
    for i in range(n):
        total += 0.0 * work.du[i]
    for a in range(r):
        total += 0.0 * work.c[a]
        for e in range(r):
            total += 0.0 * work.G[a, e]
    return total == 0.0


@kernel
def row_shift(sys, u):
    """The time e over which rows are told apart [s]."""
    n = sys.n
    fastest = 1.0 if sys.has & ROWS_READ_T else 0.0
    for i in range(n):
        fastest = max(fastest, abs(u[i]))
    return ROW_RATE_INCREMENT / fastest if fastest > NOTHING else ROW_RATE_INCREMENT


@kernel
def find_row_rates(sys, e, t, q, u, n_k, rates, work):
    """rates[0, :r] = W' u + w' of the listed contacts, from the model or by differences along q + e u, e B u
    with work.B, to 2 e on each side; 0 where neither rows nor surfaces change."""
    if sys.has & (1 << ROW_RATES):
        if not evaluate(sys, ROW_RATES, t, q, u, work.rates):
            return False
        r = 0
        for k in range(n_k):
            i = work.closed[k]
            if sys.kinds[i, 0] != GIVEN_FORCE:
                rates[0, r] = work.rates[i, 0]
                r += 1
            for axis in range(sys.kinds[i, 1]):
                rates[0, r] = work.rates[i, 1 + axis]
                r += 1
        return True
    for m in range(rates.shape[1]):
        rates[0, m] = 0.0
    if sys.has & ROWS_ARE_CONSTANT and sys.has & SURFACES_ARE_CONSTANT:
        return True
    r = 0
    for k in range(4):
        offset = (-2.0 * e, -e, e, 2.0 * e)[k]
        move(sys, q, offset, u, work, work.q_mid)
        if not evaluate_unloaded_rows(sys, True, t + offset, u, work):
            return False
        r = row_velocities(sys, n_k, u, work)
        for m in range(r):
            rates[k, m] = work.gamma_0[m]
    for m in range(r):
        rates[0, m] = (rates[0, m] - 8.0 * rates[1, m] + 8.0 * rates[2, m] - rates[3, m]) / (12.0 * e)
    return True
