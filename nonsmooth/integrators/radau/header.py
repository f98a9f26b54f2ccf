"""The header of a run whose state is integrated as x = (q, u, gaps, ..., P_N, P_F, works).

The trailing components are quadratures since the start: the impulses of the contacts and the works of the ledger. The
header has the impulses since the last row.
"""

from __future__ import annotations

from typing import Any

from nonsmooth.integrators.contract import Suspect
from nonsmooth.integrators.radau.method import SMALLEST_STEP
from nonsmooth.integrators.radau.polynomial import state_within
from nonsmooth.integrators.radau.stages import dense_value
from nonsmooth.integrators.records import N_WORKS
from nonsmooth.jit import kernel


def radau_suspects(state: Any, ode: Any) -> list[Suspect]:
    """Where a step of Radau called the rates: its beginning, the trial after the smallest step, its end."""
    t, n_q, end = float(ode.clock.now), len(state.q), len(state.q) + len(state.u)
    ends = ((SMALLEST_STEP * abs(t), ode.trial), (float(ode.clock.done), ode.x_1))
    return [Suspect(t, state.q, state.u), *(Suspect(t + part, x[:n_q], x[n_q:end]) for part, x in ends)]


@kernel
def state_at_moment(moment, t, ode, steps, x):
    """The state within the step from t that was accepted last."""
    theta = min(1.0, (moment - t) / ode.clock.done)
    state_within(steps.n_steps - steps.is_kept, theta, steps, x)
    Z = ode.Z
    for i in range(steps.q.shape[1] + steps.u.shape[1], x.shape[0]):
        x[i] = ode.x[i] - Z[2, i] + dense_value(theta, Z[0, i], Z[1, i], Z[2, i])


@kernel
def take_motion(t, x, state):
    """The time, the coordinates and the velocities of the header."""
    n_q, n = state.q.shape[0], state.u.shape[0]
    state.now = t
    for i in range(n_q):
        state.q[i] = x[i]
    for i in range(n):
        state.u[i] = x[n_q + i]


@kernel
def take_contacts(x, written, state, contacts):
    """The impulses since the last row, the works, forces and modes of the header; ``written`` are the impulses of the
    last row."""
    n_c, first = state.mode.shape[0], first_impulse(x, written)
    for i in range(n_c):
        for k in range(state.P_sum.shape[1]):
            state.P_sum[i, k] = x[first + k * n_c + i] - written[i, k]
        for k in range(state.la.shape[1]):
            state.la[i, k] = contacts.la[i, k]
        state.mode[i], state.slip[i] = contacts.mode[i], contacts.slip[i]
    for k in range(N_WORKS):
        state.ledger[k] = x[first + written.size + k]


@kernel
def take_counts(ode, state):
    """Move what the method counted to the header."""
    its, total = ode.counters, state.counters
    total.rejected += its.rejected
    total.evaluations += its.evaluations
    total.jacobians += its.jacobians
    total.factorisations += its.factorisations
    its.rejected, its.evaluations, its.jacobians, its.factorisations = 0, 0, 0, 0


@kernel
def note_impulses(x, written):
    """The impulses of the row that was written, from which those of the next are counted."""
    n_c, first = written.shape[0], first_impulse(x, written)
    for i in range(n_c):
        for k in range(written.shape[1]):
            written[i, k] = x[first + k * n_c + i]


@kernel
def first_impulse(x, written):
    """Where P_N begins in a state."""
    return x.shape[0] - written.size - N_WORKS
