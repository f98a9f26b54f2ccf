"""`simulate` for a scene: the recorder that suits, what is refused, the run, what is said of it."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any

from nonsmooth.errors import Status
from nonsmooth.integrators.contract import Integrator
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.results.recorded import kinds_of_scene
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.runs.identity import facts_of_scene_run
from nonsmooth.runs.recorder import SceneRecorder
from nonsmooth.runs.scene_run import SceneRun
from nonsmooth.runs.scene_warnings import warn_of
from nonsmooth.runs.seen import looked_at
from nonsmooth.runs.streaming import StreamingSceneRecorder, as_place
from nonsmooth.scenes.scene import Scene


def simulate_scene(
    scene: Scene, t_span: tuple[float, float], integrator: Integrator, every: int, t_eval: Any,
    project: bool, functions: Sequence[Callable], on_failure: str, max_steps: int | None, max_wall_time: float | None,
    progress: Callable[[float], None] | bool | None, record: Any, checkpoint: Any, resume: Any, checkpoint_every: float,
    view: bool, threads: int,
) -> SceneSolution:  # fmt: skip
    """`simulate` for a scene by steps of scenes, its arguments checked but for those of times."""
    kinds = kinds_of_scene(record)
    recorder = SceneRecorder(kinds)
    if checkpoint is not None or resume is not None:
        facts = functools.partial(facts_of, t_span, every, t_eval, kinds, project)
        recorder = StreamingSceneRecorder(kinds, facts, as_place(checkpoint, resume, checkpoint_every))
    run = kind_of_run(integrator)(scene, t_span, integrator, every, t_eval, recorder, project, functions, threads)
    with looked_at(run, progress, view) as hear:
        run.advance(max_wall_time, hear, max_steps)
    solution = run.solution()
    warn_of(run, solution)
    if not solution.success and solution.status != Status.INTERRUPTED and on_failure == "raise":
        raise run.failure(solution)
    return solution


def kind_of_run(integrator: Integrator) -> type[SceneRun]:
    """Of steps with rigid contacts, or on springs."""
    if isinstance(integrator, MoreauJean):
        return SceneRun
    from nonsmooth.runs.spring_run import SpringRun

    return SpringRun


def facts_of(
    t_span: tuple[float, float], every: int, t_eval: Any, kinds: tuple[str, ...], project: bool, run: SceneRun
) -> dict[str, Any]:  # fmt: skip
    """All that the bits of a run depend on."""
    stages = run.assembly.stages
    kernels = (stages.take, stages.find, *stages.others)
    return facts_of_scene_run(run.world, kernels, run.integrator, t_span, every, t_eval, kinds, project)
