"""The scales of an adaptive step: its tolerances, what they make of gaps and velocities, the time of an event.

    tol_i = atol + rtol max |x_i|        of coordinates and velocities, the largest value so far
    tol_g = sum_j |W_N,j| tol_q,j        of a gap;  of its rate and of a sliding velocity with tol_u

An event function is zero within its band: a part of these, and of the sizes of its terms for a force. What a contact
does within its bands is below the resolution.
"""

from __future__ import annotations

from nonsmooth.integrators.radau.events import EVENT_ROUNDINGS
from nonsmooth.jit import kernel
from nonsmooth.mechanics.situation import Situation, find_situation, mode_of_situation
from nonsmooth.mechanics.sys import evaluate
from nonsmooth.mechanics.system import GAP, GAP_RATE, NORMAL, TANGENT
from nonsmooth.numerics.rounding import rounded_sum

# chosen: of a tolerance: what an event may be off by. It is one of many in a step, and most events amplify it
BAND = 1e-2
EVENT_TIME = 1e-3  # chosen: of a step
# chosen: of a tolerance, above rounding: what the place of an impact may be off by, and what may move in the time of an
# event. Of impacts that follow one another the order counts: which is first changes the motion by more than they move.
IMPACT_BAND = 1e-4


@kernel
def evaluate_gaps(sys, t, x, g, gamma, run):
    """Gaps and their rates at a state, and the rows contacts.work.W_N and W_F there; False if a function raised."""
    contacts, work = run.contacts, run.contacts.work
    has, n, n_c = sys.has, contacts.q.shape[0], sys.n_c
    for i in range(n):
        contacts.q[i], contacts.u[i] = x[i], x[n + i]
    q, u = contacts.q, contacts.u
    if has & (1 << GAP) and not evaluate(sys, GAP, t, q, u, work.g_N):
        return False
    if has & (1 << NORMAL) and not evaluate(sys, NORMAL, t, q, u, work.W_N):
        return False
    if has & (1 << GAP_RATE) and not evaluate(sys, GAP_RATE, t, q, u, work.w_N):
        return False
    if has & (1 << TANGENT) and not evaluate(sys, TANGENT, t, q, u, work.W_F):
        return False
    for i in range(n_c):
        g[i], gamma[i] = work.g_N[i], work.w_N[i]
        for j in range(n):
            gamma[i] += work.W_N[i, j] * u[j]
    return True


@kernel
def set_tolerances(sys, run):
    """The tolerances of the next step, by the rows of the state that was observed last."""
    tol, work, n = run.tol, run.contacts.work, run.contacts.q.shape[0]
    for i in range(tol.shape[0]):
        tol[i] = run.clock.atol + run.clock.rtol * run.largest[i]
    for i in range(work.W_N.shape[0]):
        run.tol_g[i], run.tol_gamma[i], run.tol_slip[i] = 0.0, 0.0, 0.0
        for j in range(n):
            run.tol_g[i] += abs(work.W_N[i, j]) * tol[j]
            run.tol_gamma[i] += abs(work.W_N[i, j]) * tol[n + j]
            if sys.kinds[i, 1] > 0:
                run.tol_slip[i] += abs(work.W_F[i, 0, j]) * tol[n + j]
        lid = closed_gap(i, run)
        run.lid[i] = lid if run.g_0[i] <= lid else 0.0


@kernel
def closed_gap(i, run):
    """The gap below which contact i counts as closed: above what it moves in the shortest step."""
    return impact_band(run) * run.tol_g[i] + run.clock.least * abs(run.gamma_0[i])


@kernel
def impact_band(run):
    """What the place of an impact may be off by, and its instant move, in tolerances: not what rounding hides."""
    return max(IMPACT_BAND, min(BAND, rounded_sum(EVENT_ROUNDINGS, 1.0) / run.clock.rtol))


@kernel
def is_parting(sys, i, gamma_N, run):
    """Whether contact i leaves with this velocity, by more than its band: the situation of one without a gap."""
    slow, still = BAND * run.tol_gamma[i], run.tol_slip[i]
    return find_situation(sys.kinds[i, 0], 0.0, gamma_N, 0.0, 0.0, slow, still, True) == Situation.OPEN


@kernel
def mode_when_closed(sys, i, gamma_F, run):
    """The mode of contact i, held closed, that slides with this velocity."""
    kind, d, still = sys.kinds[i, 0], sys.kinds[i, 1], run.tol_slip[i]
    return mode_of_situation(find_situation(kind, 0.0, 0.0, gamma_F, 0.0, 0.0, still, True), d)


@kernel
def length_of_instant(run):
    """A time in which smooth motion moves nothing by more than a part of its tolerance, no more than EVENT_TIME of a
    step: what is at rest may be about to break away."""
    n, part = run.a_0.shape[0], impact_band(run)
    shortest = EVENT_TIME * run.clock.step
    for i in range(n):
        speed, acceleration = run.largest[n + i], max(abs(run.a_0[i]), abs(run.a_1[i]))
        if speed > 0.0:
            shortest = min(shortest, part * run.tol[i] / speed)
        if acceleration > 0.0:
            shortest = min(shortest, part * run.tol[n + i] / acceleration)
    return max(shortest, run.clock.least)


@kernel
def farthest(n, run):
    """The largest change of a coordinate in the first two rows, in tolerances."""
    largest = 0.0
    for i in range(n):
        largest = max(largest, abs(run.table[0, i]) / run.tol[i], abs(run.table[1, i]) / run.tol[i])
    return largest
