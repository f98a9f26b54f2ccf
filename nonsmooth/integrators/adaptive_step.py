"""One adaptive step: plain steps of Moreau–Jean with 1, 2, 3, ... substeps, extrapolated where the motion is smooth.

    T_j = T + c_2 (H/j)^2 + c_3 (H/j)^3 + ...        (theta = 1/2, no event within H)

1. Every substep has the modes of the accepted step before, no gap has fallen below its tolerance on the way, and a
   short probe from the end has these modes too: the extrapolated value is accepted once it differs from the one of an
   order less by no more than the tolerance.
2. One of the first two rows saw an event: its two-substep value is accepted if it agrees with the plain one, in the
   positions, and in the velocities as well unless a contact closed.
3. An event that only a deeper row, a gap or the probe saw lies where the first rows cannot measure it: the step is cut.

Order and step of the smooth rows are those of least work for the length. Source: Studer, Leine, Glocker, *Int. J.
Numer. Meth. Engng* 76 (2008) 1747; Hairer, Norsett, Wanner, *Solving Ordinary Differential Equations I* (1993), II.9.
"""

from __future__ import annotations

import math

from nonsmooth.blocks import address, view
from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive_state import ATOL, ROWS, RTOL, TARGET, Extrapolation
from nonsmooth.integrators.adaptive_substep import RETAKE, substep
from nonsmooth.integrators.records import FORCE_WORK, N_EVENTS, N_LEDGER, State
from nonsmooth.integrators.rigid_hold import hold
from nonsmooth.integrators.rigid_modes import HAS
from nonsmooth.jit import call_model, kernel
from nonsmooth.system import GAP, GAP_RATE, NORMAL, UNILATERAL, ContactMode

# How a step that was tried ended.
REFUSED, SMOOTH, EVENT = range(3)
SHRINK = 0.3  # of a step that holds an event which it cannot resolve
GROW = 4.0  # of a step after an event
FASTEST, SLOWEST = 8.0, 0.1  # bounds of the change of a smooth step
SAFETY = 0.8
PROBE = 1e-3  # of the step: how far beyond its end the modes are looked at


@kernel("Tuple((int64, int64, float64))(int64, float64[::1], float64, float64, int64, int64)", short_loops=True)
def try_step(model, p, t, H, state_at, run_at):
    """Try one step of length H: (Status, how it ended, what to multiply H by). ``run.change`` is what it changes."""
    state, run = view(state_at, State), view(run_at, Extrapolation)
    target = run.counters[TARGET]
    has_event, has_landed = False, False
    for j in range(ROWS):
        status, has_changed, lands = fill_row(model, p, t, H, j, state, run)
        if status != Status.RUNNING:
            return status, REFUSED, SHRINK
        if has_changed and j >= 2:
            return Status.RUNNING.value, REFUSED, SHRINK
        has_event = has_event or has_changed
        has_landed = has_landed or lands
        if j == 0:
            continue
        if has_event:
            return judge_event(model, p, t + H, has_landed, state, run)
        extrapolate(j, state, run)
        if run.errors[j] <= 1.0:
            status, is_good = check_end(model, p, t, H, state, run)
            if status != Status.RUNNING or not is_good:
                return status, REFUSED, SHRINK
            return Status.RUNNING.value, SMOOTH, plan(j, run)
        if j > target and j > 1:
            break
    factor = SAFETY * run.errors[j] ** (-1.0 / (j + 2.0)) if math.isfinite(run.errors[j]) else SLOWEST
    return Status.RUNNING.value, REFUSED, min(SAFETY, max(SLOWEST, factor))


@kernel
def fill_row(model, p, t, H, j, state, run):
    """Row j of the table: (Status, whether a mode changed, whether a contact landed)."""
    trial, n_c = run.trial, state.mode.shape[0]
    begin_trial(state, trial)
    dt = H / (j + 1)
    has_changed, lands = False, False
    for k in range(j + 1):
        status = substep(model, p, t + k * dt, dt, address(run))
        if status == RETAKE:
            status = substep(model, p, t + k * dt, dt, address(run))
        if status != Status.RUNNING:
            return status, False, False
        for i in range(n_c):
            if trial.mode[i] != state.mode[i] or trial.slip[i] != state.slip[i]:
                has_changed = True
                lands = lands or state.mode[i] == ContactMode.OPEN
    write_change(j, state, run)
    return Status.RUNNING, has_changed, lands


@kernel
def begin_trial(state, trial):
    """The accepted state, to be tried from."""
    for i in range(state.q.shape[0]):
        trial.q[i], trial.u[i] = state.q[i], state.u[i]
    for i in range(state.mode.shape[0]):
        trial.mode[i], trial.slip[i], trial.several[i] = state.mode[i], state.slip[i], state.several[i]
        for k in range(state.P.shape[1]):
            trial.P[i, k] = state.P[i, k]
            trial.P_sum[i, k] = 0.0
    for k in range(N_LEDGER):
        trial.ledger[k] = 0.0
    trial.counters[N_EVENTS] = 0


@kernel
def write_change(j, state, run):
    """The changes over the trial, as a row of the table."""
    trial, table = run.trial, run.table
    n, width = state.q.shape[0], state.P.shape[1]
    for i in range(n):
        table[j, i] = trial.q[i] - state.q[i]
        table[j, n + i] = trial.u[i] - state.u[i]
    end = 2 * n
    for i in range(state.mode.shape[0]):
        for k in range(width):
            table[j, end + k] = trial.P_sum[i, k]
        end += width
    for k in range(N_LEDGER):
        table[j, end + k] = trial.ledger[k]


@kernel
def extrapolate(j, state, run):
    """run.change from the rows 0..j, and errors[j], its distance in tolerances from that of the rows 1..j."""
    table, weights, tol = run.table, run.weights, run.tol
    error = 0.0
    for i in range(run.change.shape[0]):
        best, other = 0.0, 0.0
        for k in range(j + 1):
            best += weights[0, j, k] * table[k, i]
            other += weights[1, j, k] * table[k, i]
        run.change[i] = best
        if i < tol.shape[0]:
            error = max(error, abs(best - other) / tol[i])
    run.errors[j] = error


@kernel
def plan(j, run):
    """The factor of the next step after convergence at row j, and its row, run.counters[TARGET]: least work."""
    work, best, factor = 0.0, math.inf, 1.0
    substeps = 1.0
    for k in range(1, j + 1):
        substeps += k + 1
        grow = FASTEST
        if run.errors[k] > 0.0:
            grow = min(FASTEST, max(SLOWEST, SAFETY * (0.5 / run.errors[k]) ** (1.0 / (k + 2.0))))
        work = (substeps + 1.0) / grow
        if work < best:
            best, factor = work, grow
            run.counters[TARGET] = k
    if run.counters[TARGET] == j and j < ROWS - 1:
        run.counters[TARGET] = j + 1
        factor = min(FASTEST, factor * (substeps + j + 3.0) / (substeps + 1.0))
    return factor


@kernel
def judge_event(model, p, t_1, has_landed, state, run):
    """Accept two substeps with an event if one agrees with them: (Status, how it ended, factor of the next step)."""
    table, tol, n = run.table, run.tol, state.q.shape[0]
    error, largest = 0.0, 0.0
    for i in range(2 * n):
        run.change[i] = table[1, i]
        if i < n or not has_landed:
            error = max(error, abs(table[1, i] - table[0, i]) / tol[i])
    for i in range(2 * n, run.change.shape[0]):
        run.change[i] = table[1, i]
    if not error <= 1.0:
        return Status.RUNNING.value, REFUSED, SHRINK
    for i in range(n):
        run.x[i], run.x[n + i] = run.trial.q[i], run.trial.u[i]
    if not observe(model, p, t_1, run.x, run.g_1, run.gamma_1, run):
        return Status.NOT_FINITE.value, REFUSED, SHRINK
    for i in range(state.mode.shape[0]):
        if run.contacts.kinds[i, 0] == UNILATERAL and run.g_1[i] < min(0.0, run.g_0[i]) - run.tol_g[i]:
            return Status.RUNNING.value, REFUSED, SHRINK
    return Status.RUNNING.value, EVENT, GROW


@kernel
def check_end(model, p, t, H, state, run):
    """Move the end of a smooth step onto its constraints; whether no gap was missed and the modes last: (Status, bool)."""
    contacts, trial, x = run.contacts, run.trial, run.x
    n, n_c = state.q.shape[0], state.mode.shape[0]
    for i in range(n):
        x[i] = state.q[i] + run.change[i]
        x[n + i] = state.u[i] + run.change[n + i]
    if n_c == 0:
        return Status.RUNNING, True
    status = hold(model, p, t + H, x, False, contacts)
    if status != Status.RUNNING:
        return status, False
    book_hold(n, state, run)
    if not observe(model, p, t + H, x, run.g_1, run.gamma_1, run):
        return Status.NOT_FINITE, False
    is_active = False
    for i in range(n_c):
        is_active = is_active or state.mode[i] != ContactMode.OPEN
        if contacts.kinds[i, 0] == UNILATERAL and state.mode[i] == ContactMode.OPEN:
            if lowest(H, run.g_0[i], run.gamma_0[i], run.g_1[i], run.gamma_1[i]) < min(0.0, run.g_0[i]) - run.tol_g[i]:
                return Status.RUNNING, False
    if not is_active:
        return Status.RUNNING, True
    for i in range(n):
        trial.q[i], trial.u[i] = x[i], x[n + i]
    status = substep(model, p, t + H, PROBE * H, address(run))
    if status == RETAKE:
        return Status.RUNNING, False
    for i in range(n_c):
        if trial.mode[i] != state.mode[i] or trial.slip[i] != state.slip[i]:
            return status, False
    return status, True


@kernel
def book_hold(n, state, run):
    """Count what the move onto the constraints changed, the work of the forces over it included."""
    x, change = run.x, run.change
    works = change.shape[0] - N_LEDGER
    for i in range(n):
        moved = x[i] - state.q[i] - change[i]
        change[works + FORCE_WORK] += run.contacts.work.h[i] * moved


@kernel
def lowest(H, g_0, gamma_0, g_1, gamma_1):
    """The smallest value of the cubic with these values and slopes at the ends of a step H."""
    least = min(g_0, g_1)
    c = H * gamma_0
    b = 3.0 * (g_1 - g_0) - H * (2.0 * gamma_0 + gamma_1)
    a = -2.0 * (g_1 - g_0) + H * (gamma_0 + gamma_1)
    root = b * b - 3.0 * a * c
    if root <= 0.0:
        return least
    root = math.sqrt(root)
    # of 3 a s^2 + 2 b s + c = 0 without cancellation; the minimum is the one where 3 a s + b > 0
    s = -c / (b + root) if b + root != 0.0 else 2.0
    if b < 0.0 and a != 0.0:
        s = (-b + root) / (3.0 * a)
    if 0.0 < s < 1.0:
        least = min(least, g_0 + s * (c + s * (b + s * a)))
    return least


@kernel
def observe(model, p, t, x, g, gamma, run):
    """Gaps and their rates at a state, and the rows contacts.work.W_N there; False if a model function raised."""
    contacts, work = run.contacts, run.contacts.work
    has, n, n_c = contacts.facts[HAS], contacts.q.shape[0], contacts.kinds.shape[0]
    for i in range(n):
        contacts.q[i], contacts.u[i] = x[i], x[n + i]
    q, u = contacts.q, contacts.u
    if has & (1 << GAP) and not call_model(model, GAP, t, q, u, p, work.g_N):
        return False
    if has & (1 << NORMAL) and not call_model(model, NORMAL, t, q, u, p, work.W_N):
        return False
    if has & (1 << GAP_RATE) and not call_model(model, GAP_RATE, t, q, u, p, work.w_N):
        return False
    for i in range(n_c):
        g[i], gamma[i] = work.g_N[i], work.w_N[i]
        for j in range(n):
            gamma[i] += work.W_N[i, j] * u[j]
    return True


@kernel
def set_tolerances(run):
    """Tolerances of the next step: atol + rtol times the largest value so far; of a gap, what it inherits of them."""
    tol, W_N = run.tol, run.contacts.work.W_N
    for i in range(tol.shape[0]):
        tol[i] = run.clock[ATOL] + run.clock[RTOL] * run.largest[i]
    for i in range(W_N.shape[0]):
        total = 0.0
        for j in range(W_N.shape[1]):
            total += abs(W_N[i, j]) * tol[j]
        run.tol_g[i] = total
