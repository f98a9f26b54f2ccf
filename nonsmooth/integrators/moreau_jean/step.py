"""One step of Moreau–Jean time stepping: predict, solve the closed contacts, move, book.

Equations: docs/theory/moreau_jean.md, (1) to (3). The contact problem of a step is solved in moreau_jean/contact.py.
"""

from __future__ import annotations

from nonsmooth.contact.planar.single import slip_of
from nonsmooth.errors import Status
from nonsmooth.integrators.contract import STEP
from nonsmooth.integrators.moreau_jean.compliance import add_compliance, find_end_gaps
from nonsmooth.integrators.moreau_jean.contact import Scratch, mode_of, solve
from nonsmooth.integrators.moreau_jean.energy_gain import note_gains
from nonsmooth.integrators.moreau_jean.paradox import note_paradoxes
from nonsmooth.integrators.moreau_jean.projection import project
from nonsmooth.integrators.moreau_jean.struck_together import BY_FORCES, note_together
from nonsmooth.integrators.records import (
    State,
    book_energy,
    set_mode,
)
from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.contact_problem import (
    NORMAL_FORCE_READS_U,
    add_restitution,
    apply_inverse,
    carry_to_ends,
    close_contacts,
    delassus,
    evaluate_rows,
    find_loads,
    is_implicit,
    smooth_step,
    stack_rows,
    straighten_gaps,
)
from nonsmooth.mechanics.kinematics import find_end, find_mid_point, has_kinematics, move
from nonsmooth.mechanics.laws import LAW_E_F, LAW_E_N
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP, GIVEN_FORCE, UNILATERAL
from nonsmooth.numerics.rounding import rounded_sum

VELOCITY_ROUNDINGS = 18  # chosen: of a velocity, made from a few terms: a smaller change of it is no change


@kernel(STEP, short_loops=True)
def step(sys_at, t, dt, state_at, scratch_at):
    """One step, or the impact that comes before it; the state changes only once either is known to be good.

    Returns a Status.
    """
    sys = view(sys_at, Sys)
    n, n_c = sys.n, sys.n_c
    state, scratch = view(state_at, State), view(scratch_at, Scratch)
    work = scratch.work
    options = scratch.options
    theta = options.theta
    t_mid = t + 0.5 * dt
    q, u, q_mid = state.q, state.u, work.q_mid
    if has_kinematics(sys):
        if not find_mid_point(sys, t, dt, q, u, work):
            return Status.NOT_FINITE
    else:
        for i in range(n):
            q_mid[i] = q[i] + 0.5 * dt * u[i]
    n_k = 0
    is_rigid = options.stiffness == 0.0
    if n_c > 0:
        if not predict_gaps(sys, t, dt, is_rigid, q, u, work):
            return Status.NOT_FINITE
        n_k = close_contacts(sys, state.mode, work)
    status = smooth_step(sys, scratch.is_known[0] == 0, t_mid, dt, theta, state.u, work)
    if status != Status.RUNNING:
        return status
    scratch.is_known[0] = 1
    if n_k == 0:
        for i in range(n):
            work.u_1[i] = state.u[i] + work.du[i]
        state.counters.skipped += 1
    else:
        if n_c == 1:  # number and row of the only contact, said here and below, are constants in a loop for one system
            n_k, work.closed[0] = 1, 0
        if not evaluate_rows(sys, scratch.is_known[1] == 0, t_mid, state.u, work):
            return Status.NOT_FINITE
        scratch.is_known[1] = 1
        r = stack_rows(sys, n_k, state.u, work)
        apply_inverse(sys, is_implicit(sys), r, work)
        delassus(n, r, work)
        if not carry_to_ends(sys, t, dt, n_k, r, state, work, scratch.there):
            return Status.NOT_FINITE
        if n_c == 1:
            work.closed[0], work.start[0] = 0, 0
        if is_rigid:
            straighten_gaps(sys, dt, n_k, work, scratch.there)
            add_restitution(sys, n_k, 1.0 / ((theta + 0.5) * dt), work)
        else:
            add_compliance(sys, n_k, options.stiffness, options.damping, dt, work)
        status = solve(sys_at, options.selection, dt, n_k, state_at, scratch_at)
        if status == Status.NO_SOLUTION and is_rigid:
            take_mid_point(sys, n_k, u, work)
            status = solve(sys_at, options.selection, dt, n_k, state_at, scratch_at)
        if status == Status.RUNNING and sys.has & NORMAL_FORCE_READS_U:
            if not find_loads_between(sys, t_mid, r, u, work):
                return Status.NOT_FINITE
            status = solve(sys_at, options.selection, dt, n_k, state_at, scratch_at)
        if status != Status.RUNNING:
            return status
        if note_paradoxes(sys, t, dt, n_k, state, scratch):
            return Status.RUNNING
        new_velocity(n, r, state.u, work)
        if not is_rigid:
            find_end_gaps(sys, n_k, dt, work)
    if not all_finite(n, n_c, work):
        return Status.NOT_FINITE
    if has_kinematics(sys) and not end_along(sys, t, dt, theta, state, work):
        return Status.NOT_FINITE
    accept_step(sys, t, dt, theta, n_k, state, scratch)
    if options.projection != 0 and n_k > 0 and not project(sys_at, t + dt, n_k, state_at, address(work)):
        return Status.NOT_FINITE
    return Status.RUNNING


@rare_kernel
def take_mid_point(sys, n_k, u, work):
    """c = W (u_0 + du) + w by the rows of the mid-point alone, with no gap fed back.

    Contacts that wedge a mechanism leave it no motion. The rows at the ends of the step and the gaps ask for one of
    O(dt^2), which no impulses can give where G is singular: c is not in its range.
    """
    r = stack_rows(sys, n_k, u, work)
    delassus(sys.n, r, work)
    add_restitution(sys, n_k, 0.0, work)


@kernel
def predict_gaps(sys, t, dt, is_rigid, q, u, work):
    """work.g_N at the mid-point, of compliant contacts at the end of the step; False if the gap function raised."""
    if not sys.has & (1 << GAP):
        return True
    if is_rigid:
        return evaluate(sys, GAP, t + 0.5 * dt, work.q_mid, u, work.g_N)
    move(sys, q, dt, u, work, work.q_end)
    return evaluate(sys, GAP, t + dt, work.q_end, u, work.g_N)


@rare_kernel
def find_loads_between(sys, t_mid, r, u, work):
    """The given normal forces at the mean of the velocities before the step and after it, where they read them: at u_0
    alone the step would be of first order. False if one is not finite."""
    n = sys.n
    new_velocity(n, r, u, work)
    for i in range(n):
        work.trial[i] = 0.5 * (u[i] + work.u_1[i])
    return find_loads(sys, t_mid, work.trial, work)


@kernel
def new_velocity(n, r, u, work):
    """u_1 = u_0 + du + X^T P; what cancels to rounding is set to exactly 0 or u_0, so that rest is rest for ever."""
    du, X, P, u_1 = work.du, work.X, work.P, work.u_1
    for i in range(n):
        change = du[i]
        size = abs(du[i])
        for k in range(r):
            part = X[k, i] * P[k]
            change += part
            size += abs(part)
        new = u[i] + change
        if abs(new) <= rounded_sum(VELOCITY_ROUNDINGS, abs(u[i]) + size):
            new = 0.0
        elif abs(change) <= rounded_sum(VELOCITY_ROUNDINGS, size):
            new = u[i]
        u_1[i] = new


@kernel
def all_finite(n, n_c, work):
    """Whether the new velocities, their squares and the gaps are finite numbers: energies must not overflow."""
    u_1, g_N = work.u_1, work.g_N
    total = 0.0
    for i in range(n):
        total += 0.0 * (u_1[i] * u_1[i])
    for i in range(n_c):
        total += 0.0 * g_N[i]
    return total == 0.0


@rare_kernel
def end_along(sys, t, dt, theta, state, work):
    """The coordinates after the step, along B at the mid-point; False if the kinematics raised or are not finite."""
    u, u_1, ubar = state.u, work.u_1, work.rhs
    for i in range(sys.n):
        ubar[i] = (1.0 - theta) * u[i] + theta * u_1[i]
    return find_end(sys, t, dt, ubar, state.q, work)


@kernel
def may_gain(sys, n_k, work):
    """Whether a coefficient of restitution has a say in the step: no other step gains energy (energy_gain.py), and of
    those that do is told whether the ledger is kept or not."""
    for k in range(n_k):
        i = work.closed[k]
        if sys.laws[i, LAW_E_F] != 0.0 or (sys.laws[i, LAW_E_N] != 0.0 and work.gamma_0[work.start[k]] != 0.0):
            return True
    return False


@kernel
def accept_step(sys, t, dt, theta, n_k, state, scratch):
    """Move to the end of the step; book energy, impulses, modes, events and the worst penetration."""
    n, n_c = sys.n, sys.n_c
    work = scratch.work
    if state.skips.ledger == 0 or may_gain(sys, n_k, work):
        gain, size, push = book_energy(sys, dt, theta, is_implicit(sys), n_k, state, work)
        if scratch.options.stiffness == 0.0:
            note_gains(sys, gain, push, rounded_sum(VELOCITY_ROUNDINGS, size), False, n_k, state, work)
    if n_k > 1 and scratch.options.stiffness == 0.0:
        note_together(sys, t, BY_FORCES, n_k, state, work)
    k = 0
    for i in range(n_c):
        if k == n_k or work.closed[k] != i:  # not closed: it was open already
            for m in range(state.P.shape[1]):
                state.P[i, m] = 0.0
            continue
        candidate = scratch.work.candidate[k]
        set_mode(sys, t, i, mode_of(candidate, sys.kinds[i, 1]), slip_of(candidate), k, state, work)
        shift = 0
        if sys.kinds[i, 0] == GIVEN_FORCE:
            shift = 1
            state.P[i, 0] = dt * max(0.0, work.N[i])
        elif sys.kinds[i, 0] == UNILATERAL:
            state.worst.penetration = max(state.worst.penetration, -work.g_N[i])
        for m in range(work.start[k], work.start[k + 1]):
            state.P[i, m - work.start[k] + shift] = work.P[m]
        if state.skips.impulses == 0:
            for m in range(state.P.shape[1]):
                state.P_sum[i, m] += state.P[i, m]
        k += 1
    q, u, u_1 = state.q, state.u, work.u_1
    if has_kinematics(sys):
        for i in range(sys.n_q):
            q[i] = work.q_end[i]
        for i in range(n):
            u[i] = u_1[i]
    else:
        for i in range(n):
            q[i] += dt * ((1.0 - theta) * u[i] + theta * u_1[i])
            u[i] = u_1[i]
    state.counters.step += 1
    state.counters.steps += 1
