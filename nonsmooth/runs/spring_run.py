"""One run of a scene with compliant contacts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.assembly.progress import LOST
from nonsmooth.integrators.springs.scene_springs import SceneSprings
from nonsmooth.integrators.springs.steps import VANISHED
from nonsmooth.numerics.rounding import EPS
from nonsmooth.results.ledger import DAMPING, ELASTIC, OF_ALL
from nonsmooth.results.recorded import PAIRS
from nonsmooth.results.stats import SceneStats, SpringStats
from nonsmooth.runs.free_steps import FreeSteps
from nonsmooth.runs.scene_run import SOFT

SPRING_ENDS = {LOST: Status.NOT_FINITE, VANISHED: Status.STEP_VANISHED}
# chosen: of the longest step, over which velocities of guided bodies are differences; longer where the rounding of
# their places would be more than atol of a velocity
GUIDE_MOMENT = 1e-3


class SpringRun(FreeSteps):
    """One run, as `SceneRun`, by `Penalty`."""

    works: tuple[str, ...] = (*OF_ALL, ELASTIC, DAMPING)
    what_is_deep = SOFT
    cure = "a smaller stiffness or damping, or a larger rtol, ends this"
    has_islands = False
    ends = SPRING_ENDS
    asks_before_steps = False  # but in their stages
    assembly: SceneSprings

    def _assemble(self) -> SceneSprings:
        """The scene in motion."""
        keeps_pairs = PAIRS in self.recorder.kinds
        ask = self._ask_at if super().asks_before_steps else None
        return SceneSprings(self.world, self.integrator, *self.table.span, keeps_pairs, ask)

    def _ask_at(self, t: float) -> None:
        """Ask functions where guided bodies are at a time t [s], and for the forces on the state at hand."""
        if self.world.guided:
            far = float(np.abs(self.world.bodies.motion.x[:, : self.scene.dim]).max())
            moment = max(GUIDE_MOMENT * float(self.assembly.scales.longest), EPS * far / self.integrator.atol)
            self.world.place_guided(t, moment)
        if self.forces is not None and self.forces.is_asked:
            self.forces.write(t)

    def take_steps(self, most: int) -> None:
        """``SceneRun.take_steps``; a force that says nothing that can be used ends the run."""
        try:
            super().take_steps(most)
        except InvalidInput as refusal:
            self._end_without_answer(refusal)

    @property
    def course(self) -> Any:
        """Where the run is."""
        return self.assembly.progress

    def stats(self) -> SceneStats:
        """What the run cost."""
        springs = SpringStats(self.assembly.omega, float(self.assembly.scales.longest))
        return replace(super().stats(), springs=springs)

    def about(self) -> dict[str, Any]:
        """What was run."""
        return {
            **self.scene.parameter_values,
            "scene": repr(self.scene),
            "integrator": repr(self.integrator),
            "contacts": "forces [N] at the times of the records",
        }
