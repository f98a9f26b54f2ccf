"""The table of an adaptive step: plain steps with 1, 2, 3, ... substeps, extrapolated where modes are held.

    T_j = T + c_2 (H/j)^2 + c_3 (H/j)^3 + ...

The error is the distance of the extrapolated value to the one of an order less, of coordinates and velocities. The
impulses are followed to a thousandth, of friction to a thousandth of mu P_N: they are all that moves where a contact
sticks, and the friction may be used up. What is far below mu P_N is rounding in a stack whose top is much heavier.
Order and step are those of least work for the length.
Source: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I* (1993), section II.9.
Equations: docs/theory/adaptive.md, (1) and (2).
"""

from __future__ import annotations

from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.held import held_step
from nonsmooth.integrators.adaptive.polynomial import FIRST_1, note_slopes
from nonsmooth.integrators.adaptive.state import N_ROWS
from nonsmooth.integrators.radau.method import STEP_SAFETY
from nonsmooth.integrators.records import N_LEDGER
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import address
from nonsmooth.mechanics.laws import static_coefficient
from nonsmooth.mechanics.system import GIVEN_FORCE

FASTEST, SLOWEST = 4.0, 0.1  # chosen: bounds of the change of a step
AIMED_ERROR = 0.65  # of the tolerance: the error that the next step aims at in the last row, as measured of least work
# chosen: times its estimate is the error of a step at most, where it is as long as the tolerance lets it
UNDERRATED = 4.0
LOAD = 1e-3  # chosen: of an impulse: what of it is not seen
LEAST_GAIN, MOST_GAIN = 5.0, 50.0  # of a row: 5 to 30 as measured
# chosen: of the largest change, each in tolerances: below this error the rows show what the motion does
SEEN_ERROR = 0.05


@kernel
def fill_row(sys, t, H, j, state, run):
    """Row j of the table, with the modes held; returns a Status."""
    begin_trial(state, run.trial)
    dt, n = H / (j + 1), state.u.shape[0]
    for i in range(n):
        run.way[i] = 0.0
    for k in range(j + 1):
        note_node(k, n, run)
        status = held_step(address(sys), t + k * dt, dt, k, address(run))
        if status != Status.RUNNING:
            return status
    note_node(j + 1, n, run)
    note_slopes(j, n, run)
    for i in range(n):
        run.a_1[i] = run.slopes[j, FIRST_1, i] / H
    write_change(j, state, run)
    for i in range(n):
        run.table[j, i] = run.way[i]  # the difference of the coordinates has their rounding
    return Status.RUNNING.value


@kernel
def note_node(k, n, run):
    """Note the state after k substeps of a row."""
    for i in range(n):
        run.node_q[k, i], run.node_u[k, i] = run.trial.q[i], run.trial.u[i]
        if k < N_ROWS:
            run.begin_u[k, i] = run.trial.u[i]


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
    trial.counters.n_events, trial.counters.gains, trial.worst.gain = 0, 0, 0.0
    trial.counters.pushes, trial.worst.push = 0, 0.0
    trial.together.count = 0


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
def extrapolate(sys, j, n_k, state, run):
    """run.change from the rows 0..j, and errors[j], its distance in tolerances from that of the rows 1..j."""
    table, weights, tol = run.table, run.weights, run.tol
    error, size = 0.0, 0.0
    for i in range(run.change.shape[0]):
        best, other = 0.0, 0.0
        for k in range(j + 1):
            best += weights[0, j, k] * table[k, i]
            other += weights[1, j, k] * table[k, i]
        run.change[i], run.distance[i] = best, best - other
        if i < tol.shape[0]:
            error = max(error, abs(best - other) / (tol[i] + run.clock.rtol * abs(best)))
            size = max(size, abs(best) / tol[i])
    run.counters.is_seen = 1 if error <= SEEN_ERROR * size else 0
    run.errors[j] = UNDERRATED * max(error, error_of_impulses(sys, n_k, state, run))


@kernel
def converges(j, run):
    """Whether the step converges at row j. Two values may agree by chance: a row that gains more than MOST_GAIN is not
    believed, nor is the first difference unless it is far below the tolerance."""
    if j == 1:
        return run.errors[1] * MOST_GAIN <= 1.0
    return max(run.errors[j], run.errors[j - 1] / MOST_GAIN) <= 1.0


@kernel
def error_of_impulses(sys, n_k, state, run):
    """The distances of the impulses, as velocities of their contacts, over their tolerances and a part of themselves,
    of friction a part of its limit: that much of a load must be seen for its end to be found. Not where contacts share
    a load: any share will do."""
    contacts, work = run.contacts, run.contacts.work
    error, width = 0.0, state.P.shape[1]
    for k in range(n_k):
        i, first = work.closed[k], 2 * state.q.shape[0] + work.closed[k] * width
        if contacts.is_shared[i] == 1:
            continue
        if sys.kinds[i, 0] != GIVEN_FORCE:
            G = work.G[work.start[k], work.start[k]]
            tol = run.tol_gamma[i] + LOAD * G * abs(run.change[first])
            error = max(error, G * abs(run.distance[first]) / tol)
        if sys.kinds[i, 1] > 0:
            G = work.G[work.start[k + 1] - 1, work.start[k + 1] - 1]
            limit = max(static_coefficient(sys.laws, i) * abs(run.change[first]), abs(run.change[first + 1]))
            tol = run.tol_slip[i] + LOAD * G * limit
            error = max(error, G * abs(run.distance[first + 1]) / tol)
    return error


@kernel
def growth_of_step(j, run):
    """The factor of the next step after convergence at row j: so that the next one converges at the row aimed at."""
    target = run.counters.target
    if j < target - 1:
        return FASTEST
    if not run.errors[j] > 0.0:
        return FASTEST
    aim = AIMED_ERROR if j == target else 1.0 / STEP_SAFETY
    return min(FASTEST, max(SLOWEST, STEP_SAFETY * (aim / run.errors[j]) ** (1.0 / (j + 2.0))))
