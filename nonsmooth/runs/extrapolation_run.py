"""A run whose steps are extrapolated from plain steps with rigid contacts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nonsmooth.integrators.adaptive.loop import BUDGET_TRIES
from nonsmooth.integrators.adaptive.polynomial import STEP_PIECES
from nonsmooth.integrators.adaptive.state import VELOCITY_DEGREE
from nonsmooth.integrators.records import N_WORKS
from nonsmooth.results.solution import Solution, Stats
from nonsmooth.runs.event_run import EventRun


class ExtrapolationRun(EventRun):
    """One integration in progress, of an integrator that ``extrapolates``."""

    spent = f"the budget of a run that gets nowhere, {BUDGET_TRIES} tries (larger tolerances may get past this point),"

    pieces, degree = STEP_PIECES, VELOCITY_DEGREE

    def rows_to_now(self) -> tuple[np.ndarray, ...]:
        """The rows written so far, and the present state behind them: t (m,), x (m, N), modes and slips (m, n_c)."""
        state, g_N = self.state, self.scratch.g_0
        P = np.zeros((2, self.system.n_c))
        P[: state.P_sum.shape[1]] = state.P_sum.T
        x = np.concatenate((state.q, state.u, g_N, *P, state.ledger[:N_WORKS]))
        now = (np.array([self._time()]), x[None], state.mode[None], state.slip[None])
        t, x, _, mode, slip = map(np.concatenate, zip(*self.rows, self._written(), strict=True))
        rows = (t, x, mode, slip)
        if t[-1] == now[0][0]:
            return rows
        return tuple(np.concatenate(column) for column in zip(rows, now, strict=True))

    def solution(self) -> Solution:
        """What was computed; plain steps have impulses, not forces."""
        return replace(super().solution(), la=None)

    def _time(self) -> float:
        return float(self.scratch.clock.now)

    def _place(self) -> tuple[np.ndarray, np.ndarray]:
        return self.state.q, self.state.u

    def _modes(self) -> np.ndarray:
        return self.state.mode

    def _suspects(self) -> list[tuple[float, np.ndarray, np.ndarray]]:
        t, q, u, scratch = self._time(), self.state.q, self.state.u, self.scratch
        dt, least, trial = float(scratch.clock.step), float(scratch.clock.least), scratch.trial
        parts = (0.0, 0.5 * dt, dt, least)
        return [*((t + part, q + part * u, u) for part in parts), (t + dt, trial.q, trial.u)]

    def _stats(self) -> Stats:
        counters = self.scratch.counters
        return Stats.from_run(
            self.state, self.wall_time, self.compile_time, self.events_dropped, self.model.is_compiled,
            rejected=int(counters.rejected), evaluations=int(counters.substeps),
        )  # fmt: skip
