"""A run of a scene whose steps are as long as their error allows, between the times of the records."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from nonsmooth.errors import Status
from nonsmooth.results.stats import SceneStats, StepLengths
from nonsmooth.runs.scene_run import Interval, SceneRun
from nonsmooth.runs.times import RecordTimes, listed, record_times


class FreeSteps(SceneRun):
    """One run, as `SceneRun`, by a method that chooses its steps; ``course`` says where it is."""

    course: Any  # where it is: the time t, the target that no step goes past, the lengths of steps [s]
    cure: str  # of a step that became too short
    may_write = False

    def _times(self, t_span: tuple[float, float], every: int, t_eval: Any) -> RecordTimes:
        """The record times, or start and end where every so many steps are recorded."""
        times, self.every = record_times(t_span, every, t_eval)
        self.is_counted = self.every == 0
        return listed(times)

    def _intervals(self) -> Iterator[Interval]:
        """From time to time of the records, or so many steps at a time to the end; no step is given."""
        times, course, every = self.table.part(0, self.table.count).tolist(), self.course, self.every
        while self.interval < len(times) - 1 if every == 0 else self.now < times[-1] or not self.is_at_record:
            course.target = target = times[self.interval + 1 if every == 0 else -1]
            yield self.now, 0.0, every or sys.maxsize, target

    def left(self, count: int, t_next: float) -> int:
        """Steps to the next record, at most; none at its time."""
        return super().left(count, t_next) if self.now < t_next else 0

    def go_on_from(self, interval: int, steps_before: int, has_record: int) -> None:
        """Count from here."""
        self.interval, self.steps_before, self.has_record = interval, steps_before, bool(has_record)

    @property
    def now(self) -> float:
        """The time that the run has come to [s]."""
        return float(self.course.t)

    def stats(self) -> SceneStats:
        """What the run cost."""
        course = self.course
        lengths = StepLengths(float(course.longest_h), float(course.shortest_h), int(course.rejected))
        return replace(super().stats(), lengths=lengths)

    def reason(self) -> str:
        """A sentence on an end that is none of those that all runs have."""
        if self.status != Status.STEP_VANISHED:
            return super().reason()
        return (
            f"the step became too short for the tolerance rtol = {self.integrator.rtol:g}; stopped at {self.where()}: "
            f"{self.cure}"
        )
