"""One run of a scene with compliant contacts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from nonsmooth.errors import Status
from nonsmooth.integrators.assembly.progress import LOST
from nonsmooth.integrators.springs.scene_springs import SceneSprings
from nonsmooth.integrators.springs.steps import VANISHED
from nonsmooth.results.ledger import DAMPING, ELASTIC, OF_ALL
from nonsmooth.results.recorded import PAIRS
from nonsmooth.results.stats import SceneStats, SpringStats
from nonsmooth.runs.free_steps import FreeSteps
from nonsmooth.runs.scene_run import SOFT

SPRING_ENDS = {LOST: Status.NOT_FINITE, VANISHED: Status.STEP_VANISHED}


class SpringRun(FreeSteps):
    """One run, as `SceneRun`, by `Penalty`."""

    works: tuple[str, ...] = (*OF_ALL, ELASTIC, DAMPING)
    what_is_deep = SOFT
    cure = "a smaller stiffness or damping, or a larger rtol, ends this"
    has_islands = False
    ends = SPRING_ENDS
    assembly: SceneSprings

    def _assemble(self) -> SceneSprings:
        """The scene in motion."""
        world, (t_0, t_1) = self.world, self.table.span
        keeps_pairs = PAIRS in self.recorder.kinds
        return SceneSprings(world.bodies, world.shapes, world.surfaces, self.integrator, t_0, t_1, keeps_pairs)

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
