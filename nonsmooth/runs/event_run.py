"""A run with rigid contacts and located events."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from nonsmooth.contact.planar.forces import MAX_MODES
from nonsmooth.errors import InitialStateWarning, Status
from nonsmooth.integrators.records import EVENT_T
from nonsmooth.mechanics.initial_state import examine_state
from nonsmooth.mechanics.system import System
from nonsmooth.results.solution import Solution
from nonsmooth.runs.adaptive_run import AdaptiveRun
from nonsmooth.runs.hand_over import GIVEN_UP, LOOK, MANY, are_dense, step_over, unit


class EventRun(AdaptiveRun):
    """One integration in progress, of an integrator with ``has_rigid_contacts``."""

    def __init__(
        self, system: System, integrator: Any, t_record: np.ndarray, every: int, q0: np.ndarray, u0: np.ndarray,
        selection: int, project: bool,
    ) -> None:  # fmt: skip
        super().__init__(system, integrator, t_record, every, q0, u0, project)
        start = examine_state(system, self.model, self.has, float(t_record[0]), self.state.q, self.state.u)
        if not start.is_admissible:
            warnings.warn(start.message, InitialStateWarning, stacklevel=5)
        integrator.begin(self.scratch, start.mode, start.slip, selection)

    def _block(self, max_steps: int) -> int:
        """A block, and where its events are too dense a stretch of another integrator, if there is one."""
        stepper = getattr(self.integrator, "hand_over", None)
        if stepper is None:
            return super()._block(max_steps)
        steps_left = self.budget - int(self.state.counters.steps)
        status = super()._block(max(1, min(LOOK, steps_left)))  # whatever the clock says
        if status in GIVEN_UP or (status == Status.RUNNING and are_dense(self._recent_events(), unit(self, stepper))):
            return step_over(self, stepper, status)
        return status

    def _recent_events(self) -> np.ndarray:
        """The last events (MANY, EVENT_WIDTH) since events are followed."""
        new = self.state.events[: int(self.state.counters.n_events)]
        rows = np.concatenate((*self.events[-MANY:], new))[-MANY:]
        return rows[rows[:, EVENT_T] >= self.follows_since]

    def _message(self) -> str:
        if self.status == Status.NOT_SOLVED and getattr(self.integrator, "hand_over", self) is None:
            touching = int(self.scratch.touch.is_touching.sum())
            return (
                f"{touching} contacts touch at once, at t = {self._time():.9g} s, and EventDriven tries at most "
                f"{MAX_MODES} modes, as many as 8 or 9 contacts with friction have at rest: time stepping goes on "
                "through that, as Adaptive or MoreauJean(dt), or EventDriven(hand_over=Adaptive()) for this stretch "
                f"alone; {self._where()}"
            )
        return super()._message()

    def solution(self) -> Solution:
        """What was computed; a contact that closes after bounces is dated by their end, so the events are sorted."""
        if self.events:
            rows = np.concatenate(self.events)
            self.events = [rows[np.argsort(rows[:, EVENT_T], kind="stable")]]
        solution = super().solution()
        if self.stretches:
            name, several = type(self.integrator.hand_over).__name__, "es" if self.stretches > 1 else ""
            solution.about["handed over"] = (
                f"{self.stretches} stretch{several} of {self.handed_over:.3g} s in all to {name}"
            )
        return solution

    def gap_scale(self) -> np.ndarray:
        return np.ones(self.system.n_c)
