"""A run with rigid contacts and located events."""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.contact.planar.forces import MAX_MODES
from nonsmooth.errors import InitialStateWarning, Status, warn_caller
from nonsmooth.integrators.records import EVENT_T
from nonsmooth.mechanics.initial_state import examine_state
from nonsmooth.mechanics.system import System
from nonsmooth.results.solution import Solution
from nonsmooth.runs.adaptive_run import AdaptiveRun


class EventRun(AdaptiveRun):
    """One integration in progress, of an integrator with ``has_rigid_contacts``."""

    def __init__(
        self, system: System, integrator: Any, t_record: np.ndarray, every: int, q0: np.ndarray, u0: np.ndarray,
        selection: int, project: bool,
    ) -> None:  # fmt: skip
        super().__init__(system, integrator, t_record, every, q0, u0, project)
        start = examine_state(system, self.model, self.has, float(t_record[0]), self.state.q, self.state.u)
        if not start.is_admissible:
            warn_caller(start.message, InitialStateWarning)
        integrator.begin(self.scratch, start.mode, start.slip, selection)

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
        return super().solution()

    def gap_scale(self) -> np.ndarray:
        return np.ones(self.system.n_c)
