"""Methods with a fixed step, and their loop: from record to record, ``steps`` steps of ``dt`` each.

interval j:   t_j,  t_j + dt_j,  ...,  t_j + steps_j dt_j = t_(j+1),  record j + 1
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from nonsmooth.errors import Status
from nonsmooth.integrators.contract import EVENTS_AT_ONCE, LOOP, Integrator, Schedule, step_at
from nonsmooth.integrators.records import Record, State, is_full, write_row
from nonsmooth.jit import Kernel, kernel
from nonsmooth.jit.blocks import view
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP


@kernel(LOOP, short_loops=True)
def run(sys_at, schedule_at, max_steps, state_at, record_at, memory_at):
    """Advance by at most max_steps steps; returns a Status."""
    sys, schedule = view(sys_at, Sys), view(schedule_at, Schedule)
    state, record = view(state_at, State), view(record_at, Record)
    t_record, dts, steps = schedule.t, schedule.dt, schedule.steps
    counters, step, events = state.counters, schedule.step, EVENTS_AT_ONCE * sys.n_c
    if counters.is_begun == 0:
        counters.is_begun = 1
        if not write_record(sys, t_record[0], state, record):
            return Status.NOT_FINITE
    status = Status.RUNNING.value
    for _ in range(max_steps):
        j = counters.interval
        if j >= steps.shape[0] or is_full(1 if counters.step == 0 else 0, events, state, record):
            break
        t, dt = t_record[j] + counters.step * dts[j], dts[j]
        status = step_at(step, sys_at, t, dt, state_at, memory_at)
        if status != Status.RUNNING:
            break
        if counters.step == steps[j]:
            counters.interval += 1
            counters.step = 0
            if not write_record(sys, t_record[j + 1], state, record):
                status = Status.NOT_FINITE.value
                break
    j = counters.interval
    if j >= steps.shape[0]:
        state.now = t_record[steps.shape[0]]
        return Status.FINISHED if status == Status.RUNNING else status
    state.now = t_record[j] + counters.step * dts[j]
    return status


@kernel
def write_record(sys, t, state, record):
    """The state, with the gaps there where they are kept; False if the gap function raised."""
    if sys.has & (1 << GAP) and record.g_N.shape[0] > 0 and not evaluate(sys, GAP, t, state.q, state.u, state.g_N):
        return False
    write_row(t, state, record)
    return True


class FixedStep(Integrator):
    """A method whose steps between two records are equal.

    Attributes
    ----------
    dt : float
        The longest step [s].
    theta : float
        Weight of the new velocity in the positions: q_1 = q_0 + dt ((1 - theta) u_0 + theta u_1).
    step : Kernel
        An entry point of the signature `STEP`.
    inlined : tuple of Kernel
        Entry points of its step that become a part of a loop which is compiled for one system alone.
    constants : tuple of block classes
        Those in its memory whose numbers are constant in a run: its options.
    """

    chooses_steps = False
    inlined: ClassVar[tuple[Kernel, ...]] = ()
    constants: ClassVar[tuple[type, ...]] = ()
    dt: float
    theta: float

    @property
    def step(self) -> Kernel:
        """One step."""
        raise NotImplementedError

    @property
    def loop(self) -> Kernel:
        return run

    @property
    def kernels(self) -> tuple[Kernel, ...]:
        return (self.loop, self.step)

    def steps_between(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Equal steps, none longer than dt, between the times t (m + 1,): their lengths and numbers, (m,) each."""
        spans = t[1:] - t[:-1]
        steps = np.maximum(np.ceil(spans / self.dt * (1 - 1e-9)), 1.0)
        dts = spans / steps
        dts[np.abs(dts - self.dt) <= 1e-9 * self.dt] = self.dt  # the step asked for, not one a rounding away
        return dts, steps.astype(np.int64)
