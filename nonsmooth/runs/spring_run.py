"""One run of a scene with compliant contacts: steps as long as their error allows, between the times of the records."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.assembly.progress import LOST
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.integrators.springs.scene_springs import SceneSprings
from nonsmooth.integrators.springs.steps import VANISHED
from nonsmooth.jit.blocks import named_numbers
from nonsmooth.results.events import no_rows
from nonsmooth.results.ledger import DAMPING, ELASTIC, OF_ALL
from nonsmooth.results.recorded import PAIRS
from nonsmooth.results.stats import SceneStats, SpringStats
from nonsmooth.runs.recorder import SceneRecorder
from nonsmooth.runs.scene_run import SOFT, SceneRun, require_no_joints
from nonsmooth.runs.times import listed, record_times
from nonsmooth.scenes.scene import Scene

SPRING_ENDS = {LOST: Status.NOT_FINITE, VANISHED: Status.STEP_VANISHED}


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

    works: tuple[str, ...] = (*OF_ALL, ELASTIC, DAMPING)
    what_is_deep = SOFT
    has_islands = False
    ends = SPRING_ENDS
    assembly: SceneSprings

    def __init__(
        self, scene: Scene, t_span: tuple[float, float], integrator: Penalty, every: int, t_eval: Any,
        recorder: SceneRecorder | None = None, project: bool = False, functions: Sequence[Callable] = (),
    ) -> None:  # fmt: skip
        require_no_joints(scene, "Penalty")
        times, self.every = record_times(t_span, every, t_eval)
        self.is_counted = self.every == 0
        guided = [body.name for body in scene.bodies if body.motion is not None]
        if guided:
            raise InvalidInput(
                f"{guided[0]} moves as a function says, which Penalty does not follow within its steps; give it an "
                "even velocity, or take MoreauJean(dt)"
            )
        self._begin(scene, integrator, listed(times), recorder, project, functions)
        if self.world.surfaces.has_laws:
            raise InvalidInput(
                "Penalty rubs by Coulomb's law in a scene, and a material of it has a law of the sliding speed; take "
                "MoreauJean(dt)"
            )

    def _assemble(self) -> SceneSprings:
        """The scene in motion."""
        world, (t_0, t_1) = self.world, self.table.span
        keeps_pairs = PAIRS in self.recorder.kinds
        return SceneSprings(world.bodies, world.shapes, world.surfaces, self.integrator, t_0, t_1, keeps_pairs)

    def _intervals(self) -> Iterator[tuple[float, float, int, float]]:
        """From time to time of the records, or so many steps at a time to the end; no step is given."""
        last = self.table.count - 1
        while self.interval < last if self.is_counted else self.now < self.table.span[1] or not self.is_at_record:
            k = self.interval + 1 if self.is_counted else last
            self.assembly.progress.target = target = float(self.table.part(k, k + 1)[0])
            yield self.now, 0.0, self.every or sys.maxsize, target

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

    def paradox_rows(self) -> np.ndarray:
        """None: springs have a motion whatever the friction."""
        return no_rows()

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
