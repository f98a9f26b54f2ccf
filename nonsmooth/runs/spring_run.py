"""One run of a scene with compliant contacts: steps as long as their error allows, between the times of the records."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.assembly.progress import DONE, LOST
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.integrators.springs.scene_springs import SceneSprings
from nonsmooth.integrators.springs.steps import VANISHED
from nonsmooth.jit.blocks import named_numbers
from nonsmooth.results.scene_solution import WORKS, SceneStats, SpringStats
from nonsmooth.runs.run import next_block
from nonsmooth.runs.scene_run import SOFT, SceneRun
from nonsmooth.runs.times import listed, record_times
from nonsmooth.scenes.scene import Scene

SPRING_ENDS = {LOST: Status.NOT_FINITE, VANISHED: Status.STEP_VANISHED}
GROWTH = 2  # chosen: of the records, where their number is that of the steps


class SpringRun(SceneRun):
    """One run.

    Parameters
    ----------
    scene : Scene
    t_span : (float, float)
        [s]
    integrator : Penalty
    every, t_eval
        As of `simulate`.

    Raises
    ------
    InvalidInput
        For bodies that move as a function says.
    """

    columns = (*WORKS, "elastic", "damping")
    what_is_deep = SOFT

    def __init__(self, scene: Scene, t_span: tuple[float, float], integrator: Penalty, every: int, t_eval: Any) -> None:
        times, self.every = record_times(t_span, every, t_eval)
        guided = [body.name for body in scene.bodies if body.motion is not None]
        if guided:
            raise InvalidInput(
                f"{guided[0]} moves as a function says, which Penalty does not follow within its steps; give it an "
                "even velocity, or take MoreauJean(dt)"
            )
        self._begin(scene, integrator, listed(times))

    def _assemble(self) -> SceneSprings:
        """The scene in motion."""
        world, t = self.world, self.times
        return SceneSprings(world.bodies, world.shapes, world.surfaces, self.integrator, float(t[0]), float(t[-1]))

    def _run(self, may_go_on: Callable[[], bool], budget: int) -> None:
        """To each time that is recorded, or some steps at a time to the end."""
        targets = self.times[1:].tolist()
        if self.every > 0:
            self.times = self.times[:1]
        for target in targets:
            while self.now < target:
                if not may_go_on():
                    return
                self._go_to(target, budget - self.steps)
                if self.status != Status.RUNNING:
                    return
                if self.every > 0 and (self.steps % self.every == 0 or self.now >= target):
                    self._append_row()
            if self.every == 0:
                self._write_row()

    def _go_to(self, target: float, most: int) -> None:
        """Some steps, as many as end before the next look at the clock, or at the next record."""
        if self.every > 0:
            most = min(most, self.every - self.steps % self.every)
        before, began = self.steps, time.perf_counter()
        end = self.assembly.go_to(target, min(most, self._block))
        if end != DONE:
            self.status = SPRING_ENDS[end]
        self._block = next_block(self.steps - before, time.perf_counter() - began)

    def _append_row(self) -> None:
        """One more record, at a time that the steps chose."""
        self.times = np.append(self.times, self.now)
        if self.rows == len(self.x):
            for name in ("x", "v", "works", "worst"):
                column = getattr(self, name)
                setattr(self, name, np.concatenate((column, np.zeros((GROWTH * len(column), *column.shape[1:])))))
        self._write_row()

    def _write_last_row(self) -> None:
        """The state at which the run stopped, unless it is the last record."""
        self.times = self.times[: self.rows]
        if self.now > self.times[-1]:
            self._append_row()

    @property
    def now(self) -> float:
        """The time that the run has come to [s]."""
        return float(self.assembly.progress.t)

    def stats(self) -> SceneStats:
        """What the run cost."""
        course, scales = self.assembly.progress, self.assembly.scales
        counts, figures = named_numbers(course.counts), named_numbers(course.figures)
        longest = float(scales.longest)
        springs = SpringStats(
            self.assembly.omega, longest, float(course.longest_h), float(course.shortest_h), int(course.rejected)
        )
        return SceneStats(
            counts["steps"], int(self.assembly.network.n_c), counts["most_contacts"], 0, {}, 0, 0, 0, 0,
            self.assembly.tol, 0.0, 0.0, 0, figures["penetration"], figures["last_penetration"], self.wall_time,
            self.compile_time, springs=springs,
        )  # fmt: skip

    def message(self) -> str:
        """How the run ended, in a sentence."""
        if self.status != Status.STEP_VANISHED:
            return super().message()
        return (
            f"the step became too short for the tolerance rtol = {self.integrator.rtol:g}; stopped at t = "
            f"{self.now:.9g} s: a smaller stiffness or damping, or a larger rtol, ends this"
        )

    def _about(self) -> dict[str, str]:
        return {"contacts": "forces [N] at the times of the records"}
