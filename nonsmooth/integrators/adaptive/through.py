"""Plain steps through a stretch of an adaptive run where no modes last: contacts that chatter, forces that grow without
bound, forces that jump.

Each plain step decides anew, and two of them are accepted if one agrees with them, or if they are so short that no
coordinate moves by its tolerance in them. The next are four times as long, until modes are found that last.
"""

from __future__ import annotations

from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.polynomial import FIRST_1, note_slopes
from nonsmooth.integrators.adaptive.scales import closed_gap, evaluate_gaps, farthest
from nonsmooth.integrators.adaptive.state import Extrapolation
from nonsmooth.integrators.adaptive.step import book_constraint_work
from nonsmooth.integrators.adaptive.substep import RETAKE, substep
from nonsmooth.integrators.adaptive.switch import take_trial_mode
from nonsmooth.integrators.adaptive.table import begin_trial, note_node, write_change
from nonsmooth.integrators.records import State
from nonsmooth.integrators.rigid.hold import hold_constraints
from nonsmooth.jit import kernel, late_kernel
from nonsmooth.jit.blocks import address, view
from nonsmooth.mechanics.sys import Sys
from nonsmooth.mechanics.system import UNILATERAL, ContactMode


@late_kernel("Tuple((int64, boolean))(int64, float64, float64, int64, int64)", short_loops=True)
def step_through(sys_at, t, H, state_at, run_at):
    """Try two plain steps in the time H, to run.x: (Status, whether they are accepted)."""
    sys = view(sys_at, Sys)
    state, run = view(state_at, State), view(run_at, Extrapolation)
    for j in range(2):
        status = fill_row(sys, t, H, j, state, run)
        if status != Status.RUNNING:
            return status, False
    table, tol, n = run.table, run.tol, state.q.shape[0]
    error = 0.0
    for i in range(2 * n):
        size = max(abs(table[0, i]), abs(table[1, i]))
        error = max(error, abs(table[1, i] - table[0, i]) / (tol[i] + run.clock.rtol * size))
    if not (error <= 1.0 or farthest(n, run) <= 1.0):
        return Status.RUNNING.value, False
    for i in range(run.change.shape[0]):
        run.change[i] = table[1, i]
    return end_through(sys, t + H, state, run)


@kernel
def fill_row(sys, t, H, j, state, run):
    """Row j of the table, with modes decided in every plain step; returns a Status."""
    trial = run.trial
    begin_trial(state, trial)
    dt, n = H / (j + 1), trial.u.shape[0]
    for k in range(j + 1):
        note_node(k, n, run)
        status = substep(address(sys), t + k * dt, dt, address(run))
        for _ in range(state.mode.shape[0]):  # slides that share nothing end one after the other
            if status == RETAKE:
                for i in range(n):
                    run.begin_u[k, i] = trial.u[i]
                status = substep(address(sys), t + k * dt, dt, address(run))
        if status != Status.RUNNING:
            return status if status != RETAKE else Status.NOT_SOLVED.value
    note_node(j + 1, n, run)
    note_slopes(j, n, run)
    for i in range(n):
        run.a_1[i] = run.slopes[j, FIRST_1, i] / H
    for i in range(state.mode.shape[0]):
        run.several[i] = trial.several[i]
    write_change(j, state, run)
    return Status.RUNNING.value


@kernel
def end_through(sys, t_1, state, run):
    """Move the end onto the constraints of its modes, but for what parts: (Status, whether no gap has fallen)."""
    contacts, trial, x, n = run.contacts, run.trial, run.x, state.q.shape[0]
    for i in range(n):
        x[i], x[n + i] = trial.q[i], trial.u[i]
    if not evaluate_gaps(sys, t_1, x, run.g_1, run.gamma_1, run):
        return Status.NOT_FINITE.value, False
    for i in range(state.mode.shape[0]):
        is_unilateral = sys.kinds[i, 0] == UNILATERAL
        if is_unilateral and run.g_1[i] < min(0.0, run.g_0[i]) - closed_gap(i, run):
            return Status.RUNNING.value, False
        parts = is_unilateral and run.gamma_1[i] > run.tol_gamma[i]
        take_trial_mode(sys, i, run)
        if parts:
            contacts.mode[i], contacts.slip[i] = ContactMode.OPEN.value, 0
    status = hold_constraints(address(sys), t_1, x, False, address(contacts))
    if status != Status.RUNNING:
        return status, False
    book_constraint_work(n, state, run)
    is_finite = evaluate_gaps(sys, t_1, x, run.g_1, run.gamma_1, run)
    return Status.RUNNING.value if is_finite else Status.NOT_FINITE.value, is_finite
