"""One run of a scene with compliant contacts: steps as long as their error allows, between the times of the records."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from nonsmooth.errors import Status
from nonsmooth.integrators.assembly.progress import LOST
from nonsmooth.integrators.springs.scene_springs import SceneSprings
from nonsmooth.integrators.springs.steps import VANISHED
from nonsmooth.results.ledger import DAMPING, ELASTIC, OF_ALL
from nonsmooth.results.recorded import PAIRS
from nonsmooth.results.stats import SceneStats, SpringStats
from nonsmooth.runs.scene_run import SOFT, SceneRun
from nonsmooth.runs.times import RecordTimes, listed, record_times

SPRING_ENDS = {LOST: Status.NOT_FINITE, VANISHED: Status.STEP_VANISHED}


class SpringRun(SceneRun):
    """One run, as `SceneRun`, by `Penalty`."""

    works: tuple[str, ...] = (*OF_ALL, ELASTIC, DAMPING)
    what_is_deep = SOFT
    has_islands = False
    ends = SPRING_ENDS
    assembly: SceneSprings

    def _times(self, t_span: tuple[float, float], every: int, t_eval: Any) -> RecordTimes:
        """The record times, or start and end where every so many steps are recorded."""
        times, self.every = record_times(t_span, every, t_eval)
        self.is_counted = self.every == 0
        return listed(times)

    def _assemble(self) -> SceneSprings:
        """The scene in motion."""
        world, (t_0, t_1) = self.world, self.table.span
        keeps_pairs = PAIRS in self.recorder.kinds
        return SceneSprings(world.bodies, world.shapes, world.surfaces, self.integrator, t_0, t_1, keeps_pairs)

    def _intervals(self) -> Iterator[tuple[float, float, int, float]]:
        """From time to time of the records, or so many steps at a time to the end; no step is given."""
        times, course, every = self.table.part(0, self.table.count).tolist(), self.assembly.progress, self.every
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
        return float(self.assembly.progress.t)

    def stats(self) -> SceneStats:
        """What the run cost."""
        course, scales = self.assembly.progress, self.assembly.scales
        steps = float(scales.longest), float(course.longest_h), float(course.shortest_h)
        return replace(super().stats(), springs=SpringStats(self.assembly.omega, *steps, int(course.rejected)))

    def message(self) -> str:
        """How the run ended, in a sentence."""
        if self.status != Status.STEP_VANISHED:
            return super().message()
        return (
            f"the step became too short for the tolerance rtol = {self.integrator.rtol:g}; stopped at t = "
            f"{self.now:.9g} s: a smaller stiffness or damping, or a larger rtol, ends this"
        )

    def about(self) -> dict[str, Any]:
        """What was run."""
        return {
            **self.scene.parameter_values,
            "scene": repr(self.scene),
            "integrator": repr(self.integrator),
            "contacts": "forces [N] at the times of the records",
        }
