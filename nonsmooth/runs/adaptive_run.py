"""A run whose integrator chooses its own steps: the rows are as many as the motion needs, or at the times asked for."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from nonsmooth.errors import Status
from nonsmooth.integrators.adaptive.switch import EVENTS_AT_INSTANT
from nonsmooth.integrators.penalty.loop import Trail
from nonsmooth.integrators.penalty.rates import OMEGA
from nonsmooth.integrators.radau.method import SMALLEST_STEP
from nonsmooth.integrators.radau.polynomial import STEP_DEGREE
from nonsmooth.integrators.records import N_LEDGER, N_WORKS, Columns, State
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.compiled import loop_of
from nonsmooth.mechanics.contact_problem import model_facts
from nonsmooth.mechanics.initial_state import check_mass, project_state
from nonsmooth.mechanics.inspection import inspect_start
from nonsmooth.mechanics.sys import new_sys
from nonsmooth.mechanics.system import System
from nonsmooth.results.motion import Motion, join_motions
from nonsmooth.results.solution import Solution, Stats
from nonsmooth.runs.run import Run
from nonsmooth.runs.user_events import PLACES_OF_STEP, EventWatch, Stop

ADAPTIVE_EVENT_CAPACITY = 1024  # chosen: rows, and those of an instant
ROW_CAPACITY = 4096  # chosen: rows between two visits of Python
SPAN_LEFT = 0.75 * SMALLEST_STEP  # chosen: of the time: what is left to the end is no step
STEPS_PER_VISIT = 512  # measured: steps between two visits: 10 ms of a rod, 5 s of a hundred beads


class AdaptiveRun(Run):
    """One integration in progress, of an integrator with ``chooses_steps``."""

    follows_since = -math.inf  # [s] begin of the stretch whose events are followed
    doublings = 0  # of the length of a stretch that another integrator takes over
    stretches, handed_over = 0, 0.0  # how many there were, and their time [s]
    pieces, degree = 1, STEP_DEGREE  # polynomials a step, at most, and their degree

    def __init__(
        self,
        system: System,
        integrator: Any,
        t_record: np.ndarray,
        every: int,
        q0: np.ndarray,
        u0: np.ndarray,
        project: bool,
    ) -> None:
        self.system, self.integrator, self.t_record, self.every = system, integrator, t_record, every
        started = time.perf_counter()
        self.model, self.loop = loop_of(system, integrator)
        self.has = model_facts(system)
        self.sys = new_sys(system, self.model.handle, self.has)
        self.compile_time = time.perf_counter() - started
        t_0 = float(t_record[0])
        inspect_start(system, t_0, q0, u0, self.model)
        check_mass(system, t_0, q0, u0)
        if project:
            q0, u0 = project_state(system, t_0, q0, u0)
        n, n_c, d = system.n_u, system.n_c, system.d
        self.state = new(State, n=n, n_c=n_c, d=d, capacity=ADAPTIVE_EVENT_CAPACITY + EVENTS_AT_INSTANT * n_c)
        self.scratch = integrator.scratch(system, self.sys, t_0, float(t_record[-1]), q0, u0)
        self.trail = self._new_trail(keeps_steps=every == 1)
        self.state.q[:], self.state.u[:] = q0, u0
        self.rows: list[tuple[np.ndarray, ...]] = []
        self.steps: list[tuple[np.ndarray, ...]] = []
        self.events: list[np.ndarray] = []
        self.events_dropped = 0
        self.status = Status.RUNNING
        self.wall_time = 0.0

    def _new_trail(self, keeps_steps: bool) -> Trail:
        """Room for the rows of a block, and for its steps where they are wanted."""
        self.keeps_steps = keeps_steps
        rows = len(self.t_record) if self.every == 0 else ROW_CAPACITY
        steps = self.pieces * STEPS_PER_VISIT if keeps_steps else 1
        trail = new(Trail, m=rows, steps=steps, degree=self.degree, n=self.system.n_u, n_c=self.system.n_c)
        trail.steps.counts.is_kept = keeps_steps
        return trail

    def _failed_problem(self, message: str) -> None:
        """Steps of chosen length solve no contact problem of their own."""

    def _block(self, max_steps: int) -> int:
        with np.errstate(all="ignore"):
            self._set_handles()
            sys, *blocks = self._handed(self.sys, self.state, self.trail, self.scratch)
            status = self.loop(sys, self.t_record, self.every, min(max_steps, STEPS_PER_VISIT), *blocks)
        self._collect_rows()
        return status

    def _collect_rows(self) -> None:
        if self.every > 0:
            self.rows.append(self._written())
            self.trail.counts.rows = 0
        if self.keeps_steps:
            self.steps.append(self._new_steps())

    def look_for(self, events: Sequence[Callable]) -> None:
        """Look for events of the user in every step, whichever are recorded."""
        self.watch = EventWatch(events, PLACES_OF_STEP)
        self.keep_steps()

    def keep_steps(self) -> None:
        """Keep the motion within the steps, whichever are recorded; before the first of them."""
        self.trail = self._new_trail(keeps_steps=True)

    def _watched_block(self, max_steps: int) -> int:
        """A block, and the events of the user in it; at a reason to stop the block is run anew, to end there."""
        assert self.watch is not None
        memories = [block.words for block in (self.state, self.trail, self.scratch)]
        before = [memory.copy() for memory in memories]
        n_rows, n_steps, n_events = len(self.rows), len(self.steps), len(self.events)
        handed = self.follows_since, self.doublings, self.stretches, self.handed_over
        status = self._block(max_steps)
        here = (self._time(), *self._place())
        stop = self.watch.scan(join_motions(self.steps[n_steps:], here, here), has_ended=status == Status.FINISHED)
        if stop is not None:
            for memory, old in zip(memories, before, strict=True):
                memory[:] = old
            del self.rows[n_rows:], self.steps[n_steps:], self.events[n_events:]
            self.follows_since, self.doublings, self.stretches, self.handed_over = handed
            self._end_at(stop)
            status = Status.RUNNING
            while status == Status.RUNNING:
                status = self._block(STEPS_PER_VISIT)
                self._collect_events()
            self.stop = stop
            status = stop.status if status == Status.FINISHED else status
        if self.every != 1:
            self.steps.clear()
        return status

    def _end_at(self, stop: Stop) -> None:
        """Let the run end at a stop; at an instant later, if the velocities jump there, so that they have jumped."""
        instant = SPAN_LEFT * abs(stop.t) if stop.is_jump and self.every > 0 else 0.0
        t_end = min(self.t_record[-1], stop.t + instant)
        self.t_record = np.append(self.t_record[self.t_record < t_end], t_end)

    def _callbacks(self) -> tuple[Any, ...]:
        """The rates and the event functions, as the loop calls them."""
        callbacks = self.integrator.callbacks
        return tuple(kernel.address if self.model.is_compiled else interpreted(kernel) for kernel in callbacks)

    def _set_handles(self) -> None:
        """What the method for differential equations calls: addresses of this process, whatever a checkpoint had."""
        if callbacks := self._callbacks():
            ode, events = self.scratch.ode, self.scratch.events
            ode.rates, events.functions = callbacks
            (ode.context,) = self._handed(self.scratch.contacts)

    def _written(self) -> tuple[np.ndarray, ...]:
        """The columns of the trail's rows."""
        counts, _, *columns = self.trail
        return tuple(column[: counts.rows].copy() for column in columns)

    def _new_steps(self) -> tuple[np.ndarray, ...]:
        """The steps of the block that was run, taken out of the trail."""
        counts, *columns = self.trail.steps
        taken = tuple(column[: counts.n_steps].copy() for column in columns)
        counts.n_steps = 0
        return taken

    def _suspects(self) -> list[tuple[float, np.ndarray, np.ndarray]]:
        t, n, ode = self._time(), self.system.n_u, self.scratch.ode
        ends = ((SMALLEST_STEP * abs(t), ode.trial), (float(ode.clock.done), ode.x_1))
        return [(t, self.state.q, self.state.u), *((t + part, x[:n], x[n : 2 * n]) for part, x in ends)]

    def _time(self) -> float:
        return float(self.scratch.ode.clock.now)

    def _place(self) -> tuple[np.ndarray, np.ndarray]:
        x, n = self.scratch.ode.x, self.system.n_u
        return x[:n], x[n : 2 * n]

    def _modes(self) -> np.ndarray:
        return self.scratch.contacts.mode

    def _load_for_retry(self) -> bool:
        return False  # compliant contacts have no contact problem to solve

    def _fraction_done(self) -> float:
        span = self.t_record[-1] - self.t_record[0]
        return float((self._time() - self.t_record[0]) / span) if span > 0 else 1.0

    def solution(self) -> Solution:
        """What was computed."""
        t, x, la, mode, slip = map(np.concatenate, zip(*self.rows, self._written(), *self._start_row(), strict=True))
        record = self._record_of(x, mode, slip, np.zeros((1, self.system.n_c, 2)))
        events = np.concatenate(self.events) if self.events else self.state.events[:0]
        return Solution.from_run(
            self.system, self.integrator, t, record, events, self.status, self._message(), self._stats(), la,
            self._motion_of_steps(t, record.q, record.u), self._user_events(),
        )  # fmt: skip

    def _start_row(self) -> list[tuple[np.ndarray, ...]]:
        """The state of a run that failed before it wrote a row, as the only one."""
        if self.trail.counts.rows or any(len(row[0]) for row in self.rows):
            return []
        x, la, mode, slip = (np.zeros((1, *column.shape[1:])) for column in list(self.trail)[3:])
        x[0, : 2 * self.system.n_u] = *self.state.q, *self.state.u
        contacts = self.scratch.contacts
        mode[0], slip[0] = contacts.mode, contacts.slip
        return [(np.array([self._time()]), x, la, mode, slip)]

    def _record_of(self, x: np.ndarray, mode: np.ndarray, slip: np.ndarray, P_0: np.ndarray) -> Columns:
        """The record of rows of the trail; P_0 (1, n_c, 2): the impulses up to the row before them."""
        n, n_c, d = self.system.n_u, self.system.n_c, self.system.d
        q, u, z, P_N, P_F, works = np.split(x, np.cumsum([n, n, n_c, n_c, n_c]), axis=1)
        P = np.diff(np.stack((P_N, P_F), axis=2), axis=0, prepend=P_0)[:, :, : 1 + d]
        ledger = np.zeros((len(x), N_LEDGER))
        ledger[:, :N_WORKS] = works
        return Columns(q, u, z / self.gap_scale(), P, mode.astype(np.int64), slip.astype(np.int64), ledger)

    def _motion_of_steps(self, t: np.ndarray, q: np.ndarray, u: np.ndarray) -> Callable[[], Motion] | None:
        """What joins the steps to the motion, if they were kept."""
        if not self.steps or sum(len(block[0]) for block in self.steps) < self.state.counters.steps:
            return None
        return functools.partial(join_motions, self.steps, (t[0], q[0], u[0]), (t[-1], q[-1], u[-1]))

    def gap_scale(self) -> np.ndarray:
        """(n_c,) What the trail holds in place of a gap, z = scale g_N."""
        return self.scratch.contacts.constants[:, OMEGA]

    def _stats(self) -> Stats:
        counters = self.scratch.ode.counters
        return Stats.from_run(
            self.state, self.wall_time, self.compile_time, self.events_dropped, self.model.is_compiled,
            rejected=int(counters.rejected), evaluations=int(counters.evaluations),
            jacobians=int(counters.jacobians), factorisations=int(counters.factorisations),
        )  # fmt: skip
