"""Error-controlled Moreau–Jean in space: each step whole, and again as two halves, which are kept.

    e = max_i |x_i of the whole - x_i of the halves|/tol_i,    x = (q, u)

    tol_i = atol + rtol times the largest |x_i| so far
    modes stay       e' <= max(h/T, SHORT_PART)     the halves err by e'/3, which over the run, T, adds up to tol
                     e <= 1
    a mode changes   e <= OF_A_LANDING               an impact is early or late by h/4, a first order of h

Where a mode changes, all are compared in the tolerance of the largest: an impact, which is early or late, moves what
is zero by as wrong a part of itself, however short the step is. Of a rod that a paradox stops that was its quaternion,
for which 5 million steps of 1e-12 s were taken, whose rounding added up to 2.5e-4.

e' is e without what closed contacts make of the velocities: a plain step has gamma_N = 0 with the rows of a place that
it expects, which is off by h^2. That is mended by the next step, and does not add up. So it is taken out of the
difference of the velocities, along the impulses of the contacts in their modes (``mend``).

A plain step closes a contact whose gap is negative at its mid-point. One that lands in the last quarter is closed by
neither: where a gap is negative in the end, e is twice what the coordinates moved by since it was zero.

Where e is larger all is put back to the beginning, and a shorter step is tried. For q' = B u and friction in two
directions, where modes are not held between events as in the plane (adaptive/loop.py): each plain step decides them.
Source of the estimate: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I* (1993), II.4.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.options import Adaptive
from nonsmooth.integrators.contract import EVENTS_AT_ONCE, LOOP, Handles, Schedule, Suspect
from nonsmooth.integrators.fixed_step import write_record
from nonsmooth.integrators.halves import (
    CAUTION,
    FIRST_PART,
    HALVES,
    MOST_GROWTH,
    MOST_SHRINKING,
    NO_STEP,
    OF_A_LANDING,
    SHORT_PART,
)
from nonsmooth.integrators.moreau_jean.contact import Scratch
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.integrators.moreau_jean.step import step
from nonsmooth.integrators.records import Record, State, is_full
from nonsmooth.jit import Kernel, kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, address, new, numbers, view
from nonsmooth.mechanics.sys import Sys, evaluate
from nonsmooth.mechanics.system import GAP, GIVEN_FORCE, UNILATERAL, ContactMode, System
from nonsmooth.numerics.dense import lu, lu_solve

MOST_IMPACTS = 64  # chosen: without collision, before a step


class HalvesClock(Block):
    """Times and step sizes [s], and tolerances."""

    now: float
    step: float  # that the error asks for
    rtol: float
    atol: float


class Halves(Block, r="max(1, n_c * (1 + d))", n_q=0):
    """Arrays of a run. n = n_u, n_q = 0 where q' = u."""

    clock: HalvesClock
    refusal: int  # the Status of the last step that could not be taken
    changes: int  # whether a mode has changed in the step
    scratch: Array[Scratch, "n_q = n_q"]
    begin: Array[State, "n_q = n_q", "capacity = 1"]  # the state before the step, without its events
    q: Array[Floats, "n_q or n"]  # where the whole step led
    u: Array[Floats, "n"]
    du: Array[Floats, "n"]  # the difference of the velocities
    A: Array[Floats, "r", "r"]  # velocities of the rows that modes hold, by impulses in them
    b: Array[Floats, "r"]
    z: Array[Floats, "r"]
    row: Array[Ints, "r"]  # of each
    contact: Array[Ints, "r"]  # and its place among the closed ones
    order: Array[Ints, "r"]
    u_0: Array[Floats, "n"]  # with which a plain step began, after the impacts before it
    largest_q: Array[Floats, "n_q or n"]
    largest_u: Array[Floats, "n"]


@kernel(LOOP, short_loops=True)
def run(sys_at, schedule_at, max_steps, state_at, record_at, memory_at):
    """Try at most max_steps steps; returns a Status. Rows are written every so many steps, or, where every = 0, at the
    times t, at which steps end."""
    sys, schedule = view(sys_at, Sys), view(schedule_at, Schedule)
    state, record, memory = view(state_at, State), view(record_at, Record), view(memory_at, Halves)
    clock, times, end = memory.clock, schedule.t, schedule.t.shape[0] - 1
    for k in range(HALVES):
        memory.scratch.is_known[k] = 0
    if state.counters.is_begun == 0:
        state.counters.is_begun, record.counts.next = 1, 1
        clock.now, clock.step = state.now, FIRST_PART * schedule.span
        note_largest(state, memory)
        if not find_gaps(sys_at, clock.now, state) or not write_record(sys, clock.now, state, record):
            return Status.NOT_FINITE.value
    for _ in range(max_steps):
        if clock.now >= times[end]:
            return Status.FINISHED.value
        if is_full(1, 4 * EVENTS_AT_ONCE * sys.n_c, state, record) or has_no_room(record.steps):
            return Status.RUNNING.value
        left = times[record.counts.next if schedule.every == 0 else end] - clock.now
        h = clock.step if clock.step < 0.5 * left else left if clock.step > CAUTION * left else 0.5 * left
        if h < NO_STEP * schedule.span and h < left:
            return memory.refusal if memory.refusal != Status.RUNNING else Status.STEP_VANISHED.value
        error, order = try_step(sys_at, clock.now, h, schedule.span, state, record.steps, memory)
        change = MOST_GROWTH if error == 0.0 else CAUTION * error ** (-1.0 / order)
        change = min(MOST_GROWTH, max(MOST_SHRINKING, change))
        if not error <= 1.0:
            clock.step = change * h
            continue
        clock.now = clock.now + h if h < left else times[record.counts.next if schedule.every == 0 else end]
        clock.step = max(clock.step, change * h) if h == left else change * h
        state.now, memory.refusal = clock.now, Status.RUNNING.value
        is_due = h == left if schedule.every == 0 else state.counters.steps % schedule.every == 0
        if is_due or clock.now >= times[end]:
            if not write_record(sys, clock.now, state, record):
                return Status.NOT_FINITE.value
            record.counts.next += 1 if schedule.every == 0 else 0
    return Status.RUNNING.value


@kernel
def has_no_room(steps):
    """Whether there is no room for the pieces of a step."""
    return steps.is_kept != 0 and steps.n_steps + HALVES > steps.t.shape[0]


@kernel
def try_step(sys_at, t, h, span, state, steps, memory):
    """Take a step whole and as halves, which stay unless they err by too much: (error in tolerances, its order). Of one
    that cannot be taken the error is infinite, and the reason is left in ``refusal``."""
    n_steps = steps.n_steps
    copy_state(state, memory.begin)
    memory.changes = 0
    status = plain_step(sys_at, t, h, state, memory)
    for i in range(memory.q.shape[0]):
        memory.q[i] = state.q[i]
    for i in range(memory.u.shape[0]):
        memory.u[i] = state.u[i]
    copy_state(memory.begin, state)
    for k in range(HALVES):
        if status == Status.RUNNING:
            status = plain_piece(sys_at, t + k * h / HALVES, h / HALVES, state, steps, memory)
    if status == Status.RUNNING and not find_gaps(sys_at, t + h, state):
        status = Status.NOT_FINITE.value
    error, order = find_error(sys_at, h / span, state, memory)
    if status != Status.RUNNING:
        error, memory.refusal = math.inf, status
    evaluations, rejected = memory.begin.counters.evaluations + 1 + HALVES, memory.begin.counters.rejected
    if error <= 1.0:
        note_largest(state, memory)
        state.counters.steps = memory.begin.counters.steps + 1
    else:
        copy_state(memory.begin, state)
        steps.n_steps, rejected = n_steps, rejected + 1
    state.counters.evaluations, state.counters.rejected = evaluations, rejected
    return error, order


@kernel
def plain_piece(sys_at, t, h, state, steps, memory):
    """``plain_step`` as a piece of the motion, in which the velocities are straight; returns a Status."""
    m, u = steps.n_steps, state.u
    steps.t[m], steps.h[m] = t, h
    for i in range(state.q.shape[0]):
        steps.q[m, i] = state.q[i]
    status = plain_step(sys_at, t, h, state, memory)
    for i in range(u.shape[0]):
        steps.u[m, i], steps.B[m, 0, i] = memory.u_0[i], u[i] - memory.u_0[i]
    if steps.is_kept != 0:
        steps.n_steps += 1
    return status


@kernel
def plain_step(sys_at, t, h, state, memory):
    """One step of Moreau–Jean, after the impacts without collision before it; notes a change of modes, and returns a
    Status."""
    before, status, impacts = state.counters.step, Status.RUNNING.value, 0
    while status == Status.RUNNING and state.counters.step == before and impacts <= MOST_IMPACTS:
        for i in range(state.u.shape[0]):
            memory.u_0[i] = state.u[i]
        status = step(sys_at, t, h, address(state), address(memory.scratch))
        impacts += 1
    if status == Status.RUNNING and state.counters.step == before:
        return Status.CHATTERING.value
    begin = memory.begin
    if impacts > 1:
        memory.changes = 1
    for i in range(state.mode.shape[0]):
        if state.mode[i] != begin.mode[i] or state.slip[i] != begin.slip[i]:
            memory.changes = 1
    return status


@kernel
def find_gaps(sys_at, t, state):
    """The gaps of a state; False if the gap function raised."""
    sys = view(sys_at, Sys)
    return sys.has & (1 << GAP) == 0 or evaluate(sys, GAP, t, state.q, state.u, state.g_N)


@kernel
def find_error(sys_at, part, state, memory):
    """The error of a step that is such a part of the run, in what the tolerance allows it, and its order."""
    sys, clock, du = view(sys_at, Sys), memory.clock, memory.du
    late = lateness(sys, state, memory.begin)
    e_q = difference(state.q, memory.q, memory.largest_q, clock)
    e_u = difference(state.u, memory.u, memory.largest_u, clock)
    if late > 0.0:
        memory.changes = 1
    if memory.changes != 0:
        e_q = jump_difference(state.q, memory.q, memory.largest_q, clock)
        e_q = max(e_q, 2.0 * late * jump_difference(state.q, memory.begin.q, memory.largest_q, clock))
        return max(e_q, jump_difference(state.u, memory.u, memory.largest_u, clock)) / OF_A_LANDING, 1
    for i in range(du.shape[0]):
        du[i] = state.u[i] - memory.u[i]
    mend(sys, state, memory)
    e_add = e_q
    for i in range(du.shape[0]):
        e_add = max(e_add, abs(du[i]) / (clock.atol + clock.rtol * max(memory.largest_u[i], abs(state.u[i]))))
    return max(e_u, e_add / max(part, SHORT_PART)), 2


@kernel
def mend(sys, state, memory):
    """Take out of du what impulses of the closed contacts in their modes take out of gamma: A z = W du."""
    work, A, z, row, du = memory.scratch.work, memory.A, memory.z, memory.row, memory.du
    m = list_held(sys, state, memory)
    if m == 0:
        return
    for e in range(m):
        memory.b[e] = 0.0
        for j in range(sys.n):
            memory.b[e] += work.W[row[e], j] * du[j]
        for f in range(m):
            A[e, f] = work.G[row[e], row[f]]
            for b in range(*slides_with(sys, f, state, memory)):
                A[e, f] += work.P[b] / work.P[row[f]] * work.G[row[e], b]
    if not lu(m, A, memory.order):
        return
    lu_solve(m, A, memory.order, memory.b, z)
    for f in range(m):
        for j in range(sys.n):
            du[j] -= work.X[row[f], j] * z[f]
        for b in range(*slides_with(sys, f, state, memory)):
            for j in range(sys.n):
                du[j] -= work.P[b] / work.P[row[f]] * work.X[b, j] * z[f]


@kernel
def list_held(sys, state, memory):
    """The rows that the modes at the end of the step hold; returns their number."""
    work, m = memory.scratch.work, 0
    is_closed = False
    for i in range(sys.n_c):
        is_closed = is_closed or state.mode[i] != ContactMode.OPEN
    for k in range(work.n if is_closed else 0):
        i, normal = work.closed[k], 1 if sys.kinds[work.closed[k], 0] != GIVEN_FORCE else 0
        held = normal if state.mode[i] != ContactMode.STICK else work.start[k + 1] - work.start[k]
        for a in range(work.start[k], work.start[k] + (held if state.mode[i] != ContactMode.OPEN else 0)):
            memory.row[m], memory.contact[m] = a, k
            m += 1
    return m


@kernel
def slides_with(sys, f, state, memory):
    """The rows of friction, first and behind the last, whose impulses are in proportion to that of a held row."""
    work, a, k = memory.scratch.work, memory.row[f], memory.contact[f]
    if state.mode[work.closed[k]] != ContactMode.SLIDE or work.P[a] == 0.0:
        return 0, 0
    return a + 1, work.start[k + 1]


@kernel
def lateness(sys, state, begin):
    """The part of a step since an open contact has had a negative gap; 0 where none has."""
    late = 0.0
    for i in range(sys.n_c):
        fall = begin.g_N[i] - state.g_N[i]
        is_open = sys.kinds[i, 0] == UNILATERAL and state.mode[i] == ContactMode.OPEN
        if is_open and state.g_N[i] < 0.0 and fall > 0.0:
            late = max(late, min(1.0, -state.g_N[i] / fall))
    return late


@kernel
def difference(x, y, largest, clock):
    """max |x_i - y_i|/tol_i."""
    worst = 0.0
    for i in range(x.shape[0]):
        tol = clock.atol + clock.rtol * max(largest[i], abs(x[i]))
        worst = max(worst, abs(x[i] - y[i]) / tol)
    return worst


@kernel
def jump_difference(x, y, largest, clock):
    """max |x_i - y_i| in the tolerance of the largest of all."""
    worst, most = 0.0, 0.0
    for i in range(x.shape[0]):
        worst, most = max(worst, abs(x[i] - y[i])), max(most, largest[i], abs(x[i]))
    return worst / (clock.atol + clock.rtol * most)


@kernel
def note_largest(state, memory):
    """Note the largest coordinates and velocities so far."""
    for i in range(state.q.shape[0]):
        memory.largest_q[i] = max(memory.largest_q[i], abs(state.q[i]))
    for i in range(state.u.shape[0]):
        memory.largest_u[i] = max(memory.largest_u[i], abs(state.u[i]))


@kernel
def copy_state(source, to):
    """All of a state but its events, of which the number is copied."""
    to.now = source.now
    to.together.count, to.together.t = source.together.count, source.together.t
    copy_numbers(numbers(source.worst), numbers(to.worst))
    copy_numbers(numbers(source.counters), numbers(to.counters))
    copy_numbers(numbers(source.skips), numbers(to.skips))
    for i in range(source.q.shape[0]):
        to.q[i] = source.q[i]
    for i in range(source.u.shape[0]):
        to.u[i] = source.u[i]
    for i in range(source.ledger.shape[0]):
        to.ledger[i] = source.ledger[i]
    for i in range(source.mode.shape[0]):
        to.g_N[i], to.mode[i], to.slip[i], to.several[i] = (
            source.g_N[i], source.mode[i], source.slip[i], source.several[i],
        )  # fmt: skip
        to.together.struck[i] = source.together.struck[i]
        for k in range(source.P.shape[1]):
            to.P[i, k], to.P_sum[i, k] = source.P[i, k], source.P_sum[i, k]


@kernel
def copy_numbers(source, to):
    """One row of numbers to another."""
    for k in range(source.shape[0]):
        to[k] = source[k]


class AdaptiveInSpace(Adaptive):
    """`Adaptive` of a system with q' = B u or friction in two directions, as `simulate` takes it there."""

    pieces = HALVES
    degree = 1
    is_spatial = True
    events_at_once = 4 * EVENTS_AT_ONCE

    def __repr__(self) -> str:
        return f"Adaptive(rtol={self.rtol!r}, atol={self.atol!r})"

    @property
    def loop(self) -> Kernel:
        """The loop over the steps."""
        return run

    def entry_points(self, system: System) -> list[Kernel]:
        """What the loop may reach for this system, itself first."""
        return [self.loop, *MoreauJean(1.0).entry_points(system)[1:]]

    def memory(self, system: System, selection: int) -> Halves:  # type: ignore[override]
        """The arrays of a run, with the tolerances."""
        arrays = new(Halves, **system.sizes)
        MoreauJean(1.0).fill(arrays.scratch, system, selection)
        arrays.clock.rtol, arrays.clock.atol, arrays.refusal = self.rtol, self.atol, Status.RUNNING.value
        return arrays

    def set_handles(self, sys: Sys, handles: Handles, memory: Halves) -> None:  # type: ignore[override]
        """Nothing is called by its address."""

    def load_for_retry(self, system: System, memory: Halves, is_compiled: bool) -> bool:
        """As of a plain step."""
        return MoreauJean(1.0).load_for_retry(system, memory.scratch, is_compiled)

    def suspects(self, schedule: Schedule, state: State, memory: Halves) -> list[Suspect]:  # type: ignore[override]
        """Beginning, middle and end of the step that failed, from the state before it."""
        t, h = float(memory.clock.now), float(memory.clock.step)
        return [Suspect(t + part * h, state.q, state.u) for part in (0.0, 0.5, 1.0)]
