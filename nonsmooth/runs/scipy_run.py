"""Compliant contact by one of SciPy's solvers: the same rates, events and modes, other steps. A cross-check.

Each call of ``solve_ivp`` ends at the first event; the mode changes, and the next call begins there. Nothing is taken
on trust: a run that SciPy calls a success and that holds NaN (LSODA does that), stops before its end, or has gone
through an event unseen is a failure here, and so is one that has stepped over a saddle and damped it: SciPy's solvers
do not look for growing modes, so det(gamma/h - J) of each step is looked at here, as in radau/stages.py. A step that
ends in an event on the wrong side of a saddle within it is not told.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.errors import Status
from nonsmooth.integrators.penalty.loop import change_modes, evaluate_contacts, fill_header, note_step
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.integrators.radau.events import EVENT_ROUNDINGS, MAX_STALLS, NO_EVENT
from nonsmooth.integrators.radau.header import take_counts
from nonsmooth.integrators.radau.located import AT_START, append_row
from nonsmooth.integrators.radau.stages import GAMMA
from nonsmooth.integrators.records import N_FUNCTIONS
from nonsmooth.jit import Kernel, interpreted
from nonsmooth.jit.blocks import Block
from nonsmooth.numerics.rounding import FORWARD_INCREMENT, rounding_of_sum
from nonsmooth.runs.ongoing import set_handles
from nonsmooth.runs.run import Run

PASSED = 10.0  # chosen: tolerances by which an event function may be negative where no event was found


class RatesRefused(Exception):
    """The rates cannot be computed at a state that the solver asked for."""

    def __init__(self, status: int) -> None:
        self.status = status


class ScipyRun(Run):
    """One integration in progress, by ``scipy.integrate.solve_ivp``."""

    integrator: Penalty

    stalls = 0  # changes of mode without a step between
    known: tuple[Any, np.ndarray] = (None, np.zeros(0))  # the state of the last event functions, and their values

    def step_loop(self, max_steps: int) -> int:
        """Integrate to the next event, or to the end."""
        ode = self.memory.ode
        try:
            with np.errstate(all="ignore"):
                return self._to_next_event()
        except RatesRefused as refused:
            return refused.status
        except ValueError:  # the root of an event function has no bracket on the solver's own interpolant
            return Status.NOT_SOLVED
        finally:
            interpreted(fill_header)(self.sys, ode.clock.now, ode.x, False, self.state, self.memory)
            interpreted(take_counts)(ode, self.state)

    def _to_next_event(self) -> int:
        ode = self.memory.ode
        set_handles(self.integrator, self.model.is_compiled, self.sys, self.schedule, self.memory)
        rates, functions = ode.rates, self.memory.events.functions
        if not self.state.counters.is_begun:
            self._switch(AT_START)
            self.state.counters.is_begun = 1
        if self.state.counters.n_events + self.system.n_c > len(self.state.events):
            return Status.RUNNING
        which = self._fallen(self._evaluate(functions, ode.clock.now, ode.x), 1.0)
        if which == NO_EVENT:
            which, status = self._solve(rates, functions)
            if status != Status.RUNNING or which == NO_EVENT:
                return status if status != Status.RUNNING else Status.FINISHED
            self.stalls = 0
        self.stalls += 1
        if self.stalls > MAX_STALLS * N_FUNCTIONS * self.system.n_c:
            return Status.CHATTERING
        self._switch(which)
        return Status.RUNNING

    def _switch(self, event: int) -> None:
        """What follows an event, or the start."""
        self.memory.waiting = event
        self._accept(self._call(change_modes, int(self.schedule.every), self.state, self.record, self.memory))

    def _solve(self, rates: Any, functions: Any) -> tuple[int, int]:
        """(the event that ended it, RUNNING), NO_EVENT at the end, or the status of a failure."""
        from scipy.integrate import solve_ivp

        ode = self.memory.ode
        start, end = float(ode.clock.now), float(self.schedule.t[-1])
        if not end > start:
            return NO_EVENT, Status.RUNNING
        n_events = N_FUNCTIONS * self.system.n_c
        atol = np.full(len(ode.x), self.integrator.rtol)  # of impulses and works [N s, J]
        atol[: len(ode.atol)] = ode.atol
        with np.errstate(all="ignore"):
            found = solve_ivp(
                lambda t, x: self._evaluate(rates, t, x), (start, end), ode.x.copy(), method=self.integrator.method,
                rtol=self.integrator.rtol, atol=atol, dense_output=True,
                events=[self._event(functions, e) for e in range(n_events)],
            )  # fmt: skip
        ode.counters.evaluations += found.nfev
        ode.counters.jacobians += found.njev or 0
        ode.counters.factorisations += found.nlu or 0
        if not np.isfinite(found.y).all():
            return NO_EVENT, Status.NOT_FINITE
        if not found.success or (found.status == 0 and found.t[-1] != end):
            return NO_EVENT, Status.STEP_VANISHED
        if self._steps_over_saddle(rates, found):
            return NO_EVENT, Status.NOT_SOLVED
        moment = found.t[-1]
        which = next((e for e in range(n_events) if len(found.t_events[e])), NO_EVENT)
        loose = PASSED * max(1.0, self.integrator.rtol / rounding_of_sum(EVENT_ROUNDINGS, 1.0))
        passed = self._fallen(self._evaluate(functions, moment, found.y[:, -1]), loose)
        if passed not in (NO_EVENT, which):
            return NO_EVENT, Status.NOT_SOLVED
        self._record(found, start, moment)
        ode.clock.now, ode.x[:] = moment, found.y[:, -1]
        for _ in found.t[1:]:
            interpreted(note_step)(moment, self.state, self.memory)
        return which, Status.RUNNING

    def _steps_over_saddle(self, rates: Any, found: Any) -> bool:
        """Whether det(gamma/h - J) < 0 at an end of a step: an odd number of modes grow faster than it resolves."""
        n, h = len(self.memory.ode.atol), np.diff(found.t)
        longest = np.fmax(np.append(h, 0.0), np.append(0.0, h))  # of the steps that meet there
        return any(
            length > 0 and np.linalg.slogdet(GAMMA / length * np.eye(n) - self._jacobian(rates, t, x)[:n])[0] < 0
            for t, length, x in zip(found.t, longest, found.y.T, strict=True)
        )

    def _jacobian(self, rates: Any, t: float, x: np.ndarray) -> np.ndarray:
        """dx'/dx by forward differences."""
        ode = self.memory.ode
        n = len(ode.atol)
        f_0, J = self._evaluate(rates, t, x), np.zeros((len(x), n))
        for j in range(n):
            moved = x.copy()
            moved[j] += FORWARD_INCREMENT * max(abs(x[j]), ode.atol[j] / self.integrator.rtol)
            J[:, j] = (self._evaluate(rates, t, moved) - f_0) / (moved[j] - x[j])
        return J

    def _record(self, found: Any, start: float, moment: float) -> None:
        """Write the rows that were asked for, of the steps of one call."""
        if int(self.schedule.every) == 0:
            for t in self.schedule.t[(self.schedule.t > start) & (self.schedule.t <= moment)]:
                self._write(t, found.sol(t))
            return
        last = len(found.t) - 1
        for k in range(1, last + 1):
            if k % int(self.schedule.every) == 0 or k == last:
                self._write(found.t[k], found.y[:, k])

    def _write(self, t: float, x: np.ndarray) -> None:
        x = np.ascontiguousarray(x)
        self._evaluate(self.memory.ode.rates, t, x)
        if self.record.counts.rows == len(self.record.t):
            self.recorder.take(self, Status.RUNNING)
        interpreted(fill_header)(self.sys, t, x, False, self.state, self.memory)
        interpreted(append_row)(t, x, self.state, self.record, self.memory)

    def _evaluate(self, function: Any, t: float, x: np.ndarray) -> np.ndarray:
        out = np.zeros(max(len(x), 2 * N_FUNCTIONS * self.system.n_c))
        x = np.ascontiguousarray(x)
        self._accept(self._call(evaluate_contacts, function, t, x, out, self.memory))
        return out[: len(x)] if function == self.memory.ode.rates else out

    def _event(self, functions: Any, e: int) -> Callable:
        """Event function e for SciPy; all of them are asked for at the same state, one after the other."""

        def event(t: float, x: np.ndarray) -> float:
            key = (t, x.tobytes())
            if self.known[0] != key:
                self.known = key, self._evaluate(functions, t, x)
            return float(self.known[1][e])

        self.known = (None, np.zeros(0))
        event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
        return event

    def _fallen(self, values: np.ndarray, loose: float) -> int:
        """The first event function below minus its tolerance; of an event just handled, below what is left of it."""
        events = self.memory.events
        n = N_FUNCTIONS * self.system.n_c
        handled = events.found.handled
        events.floor[:] = 0.0
        if handled != NO_EVENT:
            events.floor[handled] = max(0.0, -values[handled])
            events.found.handled = NO_EVENT
        below = np.flatnonzero(values[:n] < -loose * values[n : 2 * n] - events.floor)
        return int(below[0]) if len(below) else NO_EVENT

    def message(self) -> str:
        """How the run ended, in a sentence."""
        if self.status != Status.NOT_SOLVED:
            return super().message()
        return (
            f"SciPy's {self.integrator.method} went past the end of a contact mode without seeing it, or over a force "
            f"that grows faster than its steps resolve, after t = {self.time():.9g} s, {self._where()}; take "
            "method='compiled', or a smaller rtol"
        )

    def _call(self, kernel: Kernel, *arguments: Any) -> int:
        handed = [self.handed(part)[0] if isinstance(part, Block) else part for part in (self.sys, *arguments)]
        return (kernel.compiled if self.model.is_compiled else interpreted(kernel))(*handed)

    def _accept(self, status: int) -> None:
        if status != Status.RUNNING:
            raise RatesRefused(status)
