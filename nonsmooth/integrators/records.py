"""What a run carries along and writes down: state, records, events, energy ledger.

The ledger of a step, exact for any theta and constant M, with ubar = (u_0 + u_1)/2 and h the force that was applied:

    T_1 - T_0 = dt ubar.h + P_N.(gammabar_N - wbar_N) + P_F.(gammabar_F - wbar_F)

It is booked in columns: work of the forces, P_F.gammabar_F (friction), P_N.gammabar_N (normal loss), -P.w (work of the
moving surfaces). A position projection changes no velocity; its column holds the work of the forces over its motion.
"""

from __future__ import annotations

import functools
from typing import Annotated as Array
from typing import NamedTuple

import numpy as np

from nonsmooth.jit import kernel, rare_kernel
from nonsmooth.jit.blocks import WORD, Block, Floats, Ints, new
from nonsmooth.mechanics.sys import evaluate
from nonsmooth.mechanics.system import GAP, GIVEN_FORCE, UNILATERAL, ContactMode

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
MODE_CHANGE, IMPACT, INCONSISTENT, INDETERMINATE = range(4)


class Worst(Block):
    """The worst figures of a run."""

    residual: float  # of a contact problem, relative to its size
    penetration: float  # [m]
    ledger_error: float  # of a step, relative to ledger_size
    ledger_size: float  # [J] of the terms of a step, the largest so far
    gain: float  # [J]


class Counters(Block):
    """Where a run is, and what it did."""

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
    uncounted: int  # problems whose solutions were not counted
    shared: int  # whose impulses are one share of many


class State(Block):
    """What a step changes. n = n_u, c = n_c."""

    q: Array[Floats, "n"]
    u: Array[Floats, "n"]
    mode: Array[Ints, "n_c"]  # ContactMode
    slip: Array[Ints, "n_c"]  # sign of sliding
    several: Array[Ints, "n_c"]  # whether the last step's problem had several solutions
    P: Array[Floats, "n_c", "1 + d"]  # impulses of the last step
    P_sum: Array[Floats, "n_c", "1 + d"]  # impulses since the last record
    ledger: Array[Floats, N_LEDGER]
    worst: Worst
    counters: Counters
    events: Array[Floats, "capacity", EVENT_WIDTH]


class Columns(NamedTuple):
    """Rows of a ``Record``, each column by itself."""

    q: np.ndarray
    u: np.ndarray
    g_N: np.ndarray
    P: np.ndarray
    mode: np.ndarray
    slip: np.ndarray
    ledger: np.ndarray


class Record(Block):
    """What a run writes down, one row a record, (m, ...)."""

    q: Array[Floats, "m", "n"]
    u: Array[Floats, "m", "n"]
    g_N: Array[Floats, "m", "n_c"]
    P: Array[Floats, "m", "n_c", "1 + d"]
    mode: Array[Ints, "m", "n_c"]
    slip: Array[Ints, "m", "n_c"]
    ledger: Array[Floats, "m", N_LEDGER]


@functools.lru_cache(maxsize=64)
def bytes_of_record(n: int, n_c: int, d: int) -> int:
    """Size of one record with its time and its steps."""
    return WORD * (3 + sum(column.size for column in new(Record, m=1, n=n, n_c=n_c, d=d)))


@kernel
def set_mode(sys, t, i, mode, slip, k, state, work):
    """Give contact i its new mode; a change is an event, and an impact where an open contact closes with a shock."""
    if mode == state.mode[i] and slip == state.slip[i]:
        return
    is_landing = state.mode[i] == ContactMode.OPEN and sys.kinds[i, 0] == UNILATERAL
    kind = IMPACT if is_landing and work.gamma_0[work.start[k]] < 0.0 else MODE_CHANGE
    add_event(sys, t, kind, i, mode, slip, k, 1, state, work)
    state.mode[i] = mode
    state.slip[i] = slip


@rare_kernel
def add_event(sys, t, kind, i, mode, slip, k, solutions, state, work):
    """Append an event; k is the place of contact i among the closed ones."""
    m = state.counters.n_events
    if m >= state.events.shape[0]:
        state.counters.events_lost += 1
        return
    row = state.events
    a = work.start[k]
    b = work.start[k + 1] - 1
    has_normal = sys.kinds[i, 0] != GIVEN_FORCE
    has_friction = sys.kinds[i, 1] > 0
    row[m, EVENT_T] = t
    row[m, EVENT_KIND] = kind
    row[m, EVENT_CONTACT] = i
    row[m, EVENT_MODE_0] = state.mode[i]
    row[m, EVENT_SLIP_0] = state.slip[i]
    row[m, EVENT_MODE_1] = mode
    row[m, EVENT_SLIP_1] = slip
    row[m, EVENT_P_N] = work.P[a] if has_normal else 0.0
    row[m, EVENT_P_F] = work.P[b] if has_friction else 0.0
    row[m, EVENT_GAMMA_N] = work.gamma_0[a] if has_normal else 0.0
    row[m, EVENT_GAMMA_F] = work.gamma_0[b] if has_friction else 0.0
    row[m, EVENT_SOLUTIONS] = solutions
    row[m, EVENT_FOUND] = state.counters.found
    state.counters.n_events += 1


@kernel
def book_contact_energy(sys, n_k, ubar, ledger, work):
    """Book friction, normal and surface work of a step: (their sum, friction and normal alone, sizes of all parts)."""
    closed, start, W, P, w, first, last = work.closed, work.start, work.W, work.P, work.w, work.first, work.last
    total, gain, size = 0.0, 0.0, 0.0
    for k in range(n_k):
        has_normal = sys.kinds[closed[k], 0] != GIVEN_FORCE
        for r in range(start[k], start[k + 1]):
            velocity, speed = 0.0, 0.0
            for j in range(first[r], last[r]):
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
    return total, gain, size


@kernel
def book_energy(sys, dt, theta, is_implicit, n_k, state, work):
    """Book the energy of a step and compare it with the change of kinetic energy, ubar.M (u_1 - u_0).

    The error is counted in the sum of the sizes of all parts, the largest of the run so far: where large works cancel,
    or forces within h of a system at rest, their rounding remains. Returns what the contacts gained, relative to their
    surfaces, and the sum of the sizes of its parts.
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
    contact, gain, contact_size = book_contact_energy(sys, n_k, ubar, ledger, work)
    ledger[FORCE_WORK] += force
    size += contact_size
    worst.ledger_size = max(worst.ledger_size, size)
    error = abs(change - force - contact)
    if error > worst.ledger_error * worst.ledger_size:
        worst.ledger_error = error / worst.ledger_size
    return gain, contact_size


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
def write_record(sys, m, t, state, record, work):
    """Record m: the state, the gaps there, the impulses since the last record; False if the gap function raised."""
    n, n_c = sys.n, sys.n_c
    for i in range(n):
        record.q[m, i] = state.q[i]
        record.u[m, i] = state.u[i]
    for i in range(N_LEDGER):
        record.ledger[m, i] = state.ledger[i]
    if sys.has & (1 << GAP) and not evaluate(sys, GAP, t, state.q, state.u, work.g_N):
        return False
    for i in range(n_c):
        record.g_N[m, i] = work.g_N[i]
        record.mode[m, i] = state.mode[i]
        record.slip[m, i] = state.slip[i]
        for k in range(state.P.shape[1]):
            record.P[m, i, k] = state.P_sum[i, k]
            state.P_sum[i, k] = 0.0
    return True
