"""What a run carries along and writes down: state, records, events, energy ledger.

The ledger of a step, exact for any theta and constant M, with ubar = (u_0 + u_1)/2 and h the force that was applied:

    T_1 - T_0 = dt ubar.h + P_N.(gammabar_N - wbar_N) + P_F.(gammabar_F - wbar_F)

It is booked in columns: work of the forces, P_F.gammabar_F (friction), P_N.gammabar_N (normal loss), -P.w (work of the
moving surfaces). A position projection changes no velocity; its column holds the work of the forces over its motion.
"""

from __future__ import annotations

import functools
import math
from typing import Annotated as Array
from typing import NamedTuple

import numpy as np

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import WORD, Block, Floats, Ints, new, numbers
from nonsmooth.mechanics.contact_problem import SHORT_ROW
from nonsmooth.mechanics.laws import LAW_E_F, LAW_E_N, LAW_IMPACT, ImpactLaw
from nonsmooth.mechanics.system import GIVEN_FORCE, UNILATERAL, ContactMode

# columns of the energy ledger
FORCE_WORK, FRICTION_WORK, NORMAL_WORK, SURFACE_WORK, PROJECTION_WORK = range(5)
N_LEDGER = 5  # derived: columns in all
N_WORKS = 4  # derived: without the projection, which moves no time: those that are integrated with the motion
# event functions of a contact of an integrator that locates events
CLOSURE, FRICTION, SIGN = range(3)
N_FUNCTIONS = 3  # derived: how many these are
# columns of an event
EVENT_T, EVENT_KIND, EVENT_CONTACT, EVENT_MODE_0, EVENT_SLIP_0, EVENT_MODE_1, EVENT_SLIP_1 = range(7)
EVENT_P_N, EVENT_P_F, EVENT_GAMMA_N, EVENT_GAMMA_F, EVENT_SOLUTIONS, EVENT_FOUND = range(7, 13)
EVENT_WIDTH = 13  # derived: columns in all
EVENT_I, EVENT_J = 13, 14  # code: columns of the bodies, behind these, of a paradox of a scene
PARADOX_WIDTH = 15  # derived: columns in all of one
MODE_CHANGE, IMPACT, INCONSISTENT, INDETERMINATE = range(4)


class Worst(Block):
    """The worst figures of a run."""

    residual: float  # of a contact problem, relative to its size
    penetration: float  # [m]
    ledger_error: float  # of a step, relative to ledger_size
    ledger_size: float  # [J] of the terms of a step, the largest so far
    gain: float  # [J]
    push: float  # [J] of work that friction did at an impact


class Event(Block):
    """What happens at a contact; a row of events has its fields in this order."""

    t: float  # [s]
    kind: float
    contact: float
    mode_0: float  # before, and the sign of sliding
    slip_0: float
    mode_1: float  # after
    slip_1: float
    P_N: float  # [N s]
    P_F: float
    gamma_N: float  # [m/s] before
    gamma_F: float
    solutions: float  # of the contact problem, and their modes
    found: float


class Counters(Block):
    """Where a run is, and what it did."""

    is_begun: int  # whether the record of the start is written
    interval: int
    step: int
    n_events: int
    events_lost: int
    failed_contact: int
    steps: int
    solved: int
    skipped: int
    kept: int
    pivots: int
    several: int
    found: int  # of the last contact problem: the set of modes
    solutions: int  # and their number
    gains: int  # impacts, or steps, in which the contacts gained energy
    pushes: int  # in which friction drove a slide
    uncounted: int  # problems whose solutions were not counted
    shared: int  # whose impulses are one share of many
    rejected: int  # steps that were tried and refused
    evaluations: int  # of the rates, or plain steps within a step
    jacobians: int
    factorisations: int


class Together(Block):
    """Impacts of several coupled contacts at once under Newton's law (moreau_jean/struck_together.py)."""

    count: int
    t: float  # [s] of the first
    struck: Array[Ints, "n_c"]  # 1 for the contacts that it struck
    reached: Array[Ints, "n_c"]  # scratch


class Skips(Block):
    """1 for what nobody will ask of a run, so that its steps leave it out; the motion has the same bits."""

    ledger: int
    impulses: int
    events: int


class State(Block, n_q=0):
    """What a step changes, and all that is known of a run from outside: the header that every integrator has.

    n = n_u, c = n_c, n_q = 0 where q' = u. Between two calls of a loop it is that of the moment the run has come to.
    """

    now: float  # time [s]
    q: Array[Floats, "n_q or n"]
    u: Array[Floats, "n"]
    g_N: Array[Floats, "n_c"]  # gaps, of the last record or step
    mode: Array[Ints, "n_c"]  # ContactMode
    slip: Array[Ints, "n_c"]  # sign of sliding
    several: Array[Ints, "n_c"]  # whether the last step's problem had several solutions
    P: Array[Floats, "n_c", "1 + d"]  # impulses of the last step
    P_sum: Array[Floats, "n_c", "1 + d"]  # impulses since the last record
    la: Array[Floats, "n_c", "1 + d"]  # forces, of an integrator that has them
    ledger: Array[Floats, N_LEDGER]
    worst: Worst
    together: Together
    counters: Counters
    skips: Skips
    event: Event  # that is being written
    events: Array[Floats, "capacity", EVENT_WIDTH]


class Columns(NamedTuple):
    """Rows of a ``Record``, each column by itself."""

    t: np.ndarray
    q: np.ndarray
    u: np.ndarray
    g_N: np.ndarray
    P: np.ndarray
    mode: np.ndarray
    slip: np.ndarray
    ledger: np.ndarray
    la: np.ndarray


class RecordCounts(Block):
    """What was written."""

    rows: int
    next: int  # of the times of the records


class Steps(Block, n_q=0, curved=0):
    """The motion within the steps, u(t + theta h) = u_0 + sum_k B_k theta^k; where they are not kept, the last one."""

    n_steps: int
    is_kept: int  # 1 where they are kept
    t: Array[Floats, "steps"]  # beginnings
    h: Array[Floats, "steps"]  # lengths
    q: Array[Floats, "steps", "n_q or n"]  # at the beginning
    u: Array[Floats, "steps", "n"]
    B: Array[Floats, "steps", "degree", "n"]
    Q: Array[Floats, "steps", "curved", "n_q"]  # where q' is not u, q(t + theta h) = q_0 + sum_k Q_k theta^k


class Record(
    Block, forces=0, steps=0, degree=0, n_q=0, curved=0, m_q="m", m_u="m", m_g_N="m", m_P="m", m_mode="m", m_slip="m",
    m_ledger="m",
):  # fmt: skip
    """What a run writes down, m rows, and the motion within its steps; the caller empties them.

    ``forces`` is m of an integrator that has forces, else 0; ``m_q`` is 0 where q is not kept, and so on.
    """

    counts: RecordCounts
    steps: Array[Steps, "n_q = n_q", "curved = curved"]
    t: Array[Floats, "m"]
    q: Array[Floats, "m_q", "n_q or n"]
    u: Array[Floats, "m_u", "n"]
    g_N: Array[Floats, "m_g_N", "n_c"]
    P: Array[Floats, "m_P", "n_c", "1 + d"]  # impulses since the row before
    mode: Array[Ints, "m_mode", "n_c"]
    slip: Array[Ints, "m_slip", "n_c"]
    ledger: Array[Floats, "m_ledger", N_LEDGER]
    la: Array[Floats, "forces", "n_c", "1 + d"]


@functools.lru_cache(maxsize=64)
def bytes_of_record(n: int, n_c: int, d: int, n_q: int, left_out: tuple[str, ...] = ()) -> int:
    """Size of one record with its steps, without the columns that are left out."""
    columns = Columns(*list(new(Record, m=1, n=n, n_c=n_c, d=d, n_q=n_q, **no_rows(left_out)))[2:])
    return WORD * (2 + sum(column.size for column in columns))


def no_rows(left_out: tuple[str, ...]) -> dict[str, int]:
    """Sizes of a `Record` without some columns."""
    return {f"m_{name}": 0 for name in left_out}


@kernel
def set_mode(sys, t, i, mode, slip, k, state, work):
    """Give contact i its new mode; a change is an event, and an impact where an open contact closes with a shock."""
    if mode == state.mode[i] and slip == state.slip[i]:
        return
    is_landing = state.mode[i] == ContactMode.OPEN and sys.kinds[i, 0] == UNILATERAL
    kind = IMPACT if is_landing and work.gamma_0[work.start[k]] < 0.0 else MODE_CHANGE
    if state.skips.events == 0:
        describe_closed(sys, k, 1, state, work)
        append_event(t, kind, i, state.mode[i], state.slip[i], mode, slip, state)
    state.mode[i] = mode
    state.slip[i] = slip


@kernel
def describe_closed(sys, k, solutions, state, work):
    """The event to come is one of closed contact k: its impulses, its velocities before, the number of solutions."""
    event, i = state.event, work.closed[k]
    a, b = work.start[k], work.start[k + 1] - 1
    if sys.kinds[i, 0] != GIVEN_FORCE:
        event.P_N, event.gamma_N = work.P[a], work.gamma_0[a]
    if sys.kinds[i, 1] == 1:
        event.P_F, event.gamma_F = work.P[b], work.gamma_0[b]
    elif sys.kinds[i, 1] == 2:
        event.P_F = math.sqrt(work.P[b - 1] * work.P[b - 1] + work.P[b] * work.P[b])
        event.gamma_F = math.sqrt(work.gamma_0[b - 1] * work.gamma_0[b - 1] + work.gamma_0[b] * work.gamma_0[b])
    event.solutions, event.found = solutions, state.counters.found


@rare_kernel
def append_event(t, kind, i, mode_0, slip_0, mode_1, slip_1, state):
    """Append ``state.event``, as one of contact i that changes from a mode to another, and clear it."""
    event, counters = state.event, state.counters
    row, m = numbers(event), counters.n_events
    if state.skips.events != 0:
        return
    if m < state.events.shape[0]:
        event.t, event.kind, event.contact = t, kind, i
        event.mode_0, event.slip_0, event.mode_1, event.slip_1 = mode_0, slip_0, mode_1, slip_1
        for column in range(EVENT_WIDTH):
            state.events[m, column] = row[column]
        counters.n_events = m + 1
    else:
        counters.events_lost += 1
    for column in range(EVENT_WIDTH):
        row[column] = 0.0


@kernel
def take_together(trial, state):
    """Take over what was noted in a trial that is accepted."""
    found, together = trial.together, state.together
    if found.count > 0 and together.count == 0:
        together.t = found.t
        for i in range(found.struck.shape[0]):
            together.struck[i] = found.struck[i]
    together.count += found.count


@kernel
def book_contact_energy(sys, n_k, ubar, ledger, work):
    """Book friction, normal and surface work of a step: (their sum, friction and normal alone, sizes of all parts, the
    work with which friction drives a slide at a rebound)."""
    closed, start, W, P, w = work.closed, work.start, work.W, work.P, work.w
    n, total, gain, size, push = sys.n, 0.0, 0.0, 0.0, 0.0
    for k in range(n_k):
        has_normal = sys.kinds[closed[k], 0] != GIVEN_FORCE
        for r in range(start[k], start[k + 1]):
            velocity, speed = 0.0, 0.0
            first = 0 if n <= SHORT_ROW else work.first[r]
            last = n if n <= SHORT_ROW else work.last[r]
            for j in range(first, last):
                part = W[r, j] * ubar[j]
                velocity += part
                speed += abs(part)
            is_normal = has_normal and r == start[k]
            loss = P[r] * (velocity + w[r])
            ledger[NORMAL_WORK if is_normal else FRICTION_WORK] += loss
            ledger[SURFACE_WORK] -= P[r] * w[r]
            total += P[r] * velocity
            gain += loss
            size += abs(P[r]) * speed
            if loss > 0.0 and not is_normal and has_normal and rebounds_by_newton(sys, closed[k], start[k], work):
                push = max(push, loss - abs(P[r] * (work.c[r] - work.gamma_0[r])) + push_across(sys, k, r, ubar, work))
    return total, gain, size, push


@rare_kernel
def push_across(sys, k, r, ubar, work):
    """What row r of closed contact k leaves out of its friction: that along the other of two directions."""
    if sys.kinds[work.closed[k], 1] < 2:
        return 0.0
    other, velocity = 2 * work.start[k] + 3 - r, 0.0
    for j in range(sys.n):
        velocity += work.W[other, j] * ubar[j]
    loss = work.P[other] * (velocity + work.w[other])
    return loss - abs(work.P[other] * (work.c[other] - work.gamma_0[other]))


@kernel
def rebounds_by_newton(sys, i, row, work):
    """Whether contact i approaches and Newton's law gives back a part of that, and nothing of the slide."""
    has_law = sys.laws[i, LAW_E_N] > 0.0 and sys.laws[i, LAW_IMPACT] == ImpactLaw.NEWTON.value
    return has_law and sys.laws[i, LAW_E_F] == 0.0 and sys.kinds[i, 0] == UNILATERAL and work.gamma_0[row] < 0.0


@kernel
def book_energy(sys, dt, theta, is_implicit, n_k, state, work):
    """Book the energy of a step and compare it with the change of kinetic energy, ubar.M (u_1 - u_0).

    The error is counted in the sum of the sizes of all parts, the largest of the run so far: where large works cancel,
    or forces within h of a system at rest, their rounding remains. Returns what the contacts gained, relative to their
    surfaces, the sum of the sizes of its parts, and the work with which friction drives a slide at a rebound.
    """
    n = sys.n
    h, M, u_0, u_1, ubar = work.h, work.M, state.u, work.u_1, work.trial
    ledger, worst, band = state.ledger, state.worst, work.band
    for i in range(n):
        ubar[i] = 0.5 * (u_0[i] + u_1[i])
    change, force, size = 0.0, 0.0, 0.0
    for i in range(n):
        momentum, moved = 0.0, 0.0
        for j in range(max(0, i - band), min(n, i + band + 1)):
            momentum += M[i, j] * (u_1[j] - u_0[j])
            moved += abs(M[i, j]) * (abs(u_0[j]) + abs(u_1[j]))
        impulse = dt * h[i]
        if is_implicit:
            impulse -= implicit_impulse(i, dt, theta, n, u_0, u_1, work)
        change += ubar[i] * momentum
        force += ubar[i] * impulse
        size += (abs(u_0[i]) + abs(u_1[i])) * (moved + abs(impulse))
    contact, gain, contact_size, push = book_contact_energy(sys, n_k, ubar, ledger, work)
    ledger[FORCE_WORK] += force
    size += contact_size
    worst.ledger_size = max(worst.ledger_size, size)
    error = abs(change - force - contact)
    if error > worst.ledger_error * worst.ledger_size:
        worst.ledger_error = error / worst.ledger_size
    return gain, contact_size, push


@kernel
def implicit_impulse(i, dt, theta, n, u_0, u_1, work):
    """What the linearly implicit step takes from the impulse dt h_i."""
    C, K = work.C, work.K
    total = 0.0
    for j in range(n):
        total += theta * dt * (C[i, j] + theta * dt * K[i, j]) * (u_1[j] - u_0[j])
        total += (theta - 0.5) * dt * dt * K[i, j] * u_0[j]
    return total


@kernel
def write_row(t, state, record):
    """Append a row of the header as it is, in the columns that are kept; impulses are counted anew from here."""
    m, n, n_c = record.counts.rows, state.u.shape[0], state.mode.shape[0]
    record.t[m] = t
    if record.q.shape[0] > 0:
        for i in range(state.q.shape[0]):
            record.q[m, i] = state.q[i]
    if record.u.shape[0] > 0:
        for i in range(n):
            record.u[m, i] = state.u[i]
    if record.g_N.shape[0] > 0:
        for i in range(n_c):
            record.g_N[m, i] = state.g_N[i]
    if record.mode.shape[0] > 0:
        for i in range(n_c):
            record.mode[m, i], record.slip[m, i] = state.mode[i], state.slip[i]
    if record.P.shape[0] > 0:
        for i in range(n_c):
            for k in range(state.P_sum.shape[1]):
                record.P[m, i, k] = state.P_sum[i, k]
                state.P_sum[i, k] = 0.0
    if record.ledger.shape[0] > 0:
        for i in range(N_LEDGER):
            record.ledger[m, i] = state.ledger[i]
    if record.la.shape[0] > 0:
        for i in range(n_c):
            for k in range(state.la.shape[1]):
                record.la[m, i, k] = state.la[i, k]
    record.counts.rows = m + 1


@kernel
def is_full(rows, events, state, record):
    """Whether there is no room for so many more rows and events: the caller empties them."""
    if rows > 0 and record.counts.rows + rows > record.t.shape[0]:
        return True
    return state.counters.n_events + events > state.events.shape[0]
