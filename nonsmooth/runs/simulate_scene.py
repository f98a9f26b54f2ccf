"""`simulate` for a scene: by steps of scenes or as its system, the recorder that suits, the run, what is said of it."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.contract import Integrator
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.results.recorded import KINDS_OF_SCENE, PAIRS
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.results.solution import Solution
from nonsmooth.runs.asked import Asked, require_integrator
from nonsmooth.runs.identity import facts_of_scene_run
from nonsmooth.runs.recorder import SceneRecorder
from nonsmooth.runs.scene_run import SceneRun
from nonsmooth.runs.scene_warnings import warn_of
from nonsmooth.runs.seen import looked_at
from nonsmooth.runs.streaming import StreamingSceneRecorder, as_place
from nonsmooth.runs.times import span_of
from nonsmooth.runs.user_events import OF_SCENE, as_functions
from nonsmooth.scenes.scene import Scene


def simulate_scene(scene: Scene, t_span: tuple[float, float] | None, integrator: Any, asked: Asked) -> SceneSolution:
    """`simulate` for a scene: by steps of scenes, or as its system."""
    t_span = span_of(scene, t_span)
    method, why = chosen_of_scene(integrator, scene, t_span, asked)
    instead = steps_instead(method, scene, t_span[0], asked)
    if goes_by_system(method) and instead is None:
        solution = by_its_system(scene, t_span, method, integrator, asked)
    else:
        solution = by_steps(scene, t_span, method, asked)
        if why is not None or instead is not None:
            solution.about["chosen"] = why or instead
    if solution.status == Status.INTERRUPTED and asked.is_whole:
        raise KeyboardInterrupt
    return solution


def by_steps(scene: Scene, t_span: tuple[float, float], integrator: Integrator, asked: Asked) -> SceneSolution:
    """The run of an integrator that has steps of scenes."""
    kinds, functions = KINDS_OF_SCENE.chosen(asked.record), as_functions(asked.events, OF_SCENE)
    recorder = SceneRecorder(kinds)
    if asked.has_checkpoint:
        facts = functools.partial(facts_of, t_span, asked.every, asked.t_eval, kinds, asked.project)
        place = as_place(asked.checkpoint, asked.resume, asked.checkpoint_every)
        recorder = StreamingSceneRecorder(kinds, facts, place)
    run = kind_of_run(integrator)(
        scene, t_span, integrator, asked.every, asked.t_eval, recorder, asked.project, functions, asked.threads,
        asked.rule,
    )  # fmt: skip
    with looked_at(run, asked.progress, asked.view) as hear:
        run.advance(asked.max_wall_time, hear, asked.max_steps)
    solution = run.solution()
    warn_of(run, solution)
    if not solution.success and solution.status != Status.INTERRUPTED and asked.on_failure == "raise":
        raise run.failure(solution)
    return solution


def by_its_system(
    scene: Scene, t_span: tuple[float, float], method: Integrator, integrator: Any, asked: Asked
) -> SceneSolution:
    """The run of the system of a scene, ``integrator`` or what it chooses for that."""
    from nonsmooth.runs.scene_by_system import SceneBySystem
    from nonsmooth.runs.simulate_system import simulate_system

    functions = as_functions(asked.events, OF_SCENE)
    of_scene = SceneBySystem(scene, t_span, method, asked.record, functions, of_steps_alone(asked))

    def run_system(system: Any, span: tuple[float, float], q0: Any, u0: Any, events: Any, record: Any) -> Solution:
        return simulate_system(system, span, q0, u0, None, integrator, replace(asked, events=events, record=record))

    return of_scene.run_by(run_system)


def kind_of_run(integrator: Integrator) -> type[SceneRun]:
    """Of steps with rigid contacts, of one length or as their error allows, or on springs."""
    from nonsmooth.integrators.adaptive.options import Adaptive

    if isinstance(integrator, MoreauJean):
        return SceneRun
    if isinstance(integrator, Adaptive):
        from nonsmooth.runs.controlled_run import ControlledRun

        return ControlledRun
    from nonsmooth.runs.spring_run import SpringRun

    return SpringRun


def facts_of(
    t_span: tuple[float, float], every: int, t_eval: Any, kinds: tuple[str, ...], project: bool, run: SceneRun
) -> dict[str, Any]:  # fmt: skip
    """All that the bits of a run depend on."""
    stages = run.assembly.stages
    kernels = (stages.take, stages.find, *stages.others)
    return facts_of_scene_run(run.world, kernels, run.integrator, t_span, every, t_eval, kinds, project, run.selection)


def goes_by_system(integrator: Any) -> bool:
    """Whether a scene is integrated as its system, where it has one of few contacts."""
    from nonsmooth.integrators.penalty.options import Penalty

    require_integrator(integrator)
    return not isinstance(integrator, MoreauJean | Penalty)


def steps_instead(integrator: Any, scene: Scene, t_0: float, asked: Asked) -> str | None:
    """Why `Adaptive` takes steps of the scene (controlled_run.py) and not of its system; None where it does not."""
    from nonsmooth.integrators.adaptive.options import Adaptive

    if not isinstance(integrator, Adaptive):
        return None
    from nonsmooth.runs.scene_by_system import few_contacts

    if taken := [name for name, value in of_steps_alone(asked).items() if value]:
        return f"a run by the system of a scene takes no {taken[0]}"
    try:
        few_contacts(scene, "Adaptive of systems", t_0, follows_turns=False)
        scene.state()
    except InvalidInput as refusal:
        return str(refusal).split(";")[0]
    return None


def of_steps_alone(asked: Asked) -> dict[str, Any]:
    """Options that runs by the system of a scene do not take, as they were given; None or False where left out."""
    options = {"checkpoint": asked.checkpoint, "resume": asked.resume, "view": asked.view, "threads": asked.threads > 1}
    return options | {'record="pairs"': PAIRS in KINDS_OF_SCENE.chosen(asked.record)}


def chosen_of_scene(
    integrator: Any, scene: Scene, t_span: tuple[float, float], asked: Asked
) -> tuple[Any, str | None]:  # fmt: skip
    """The integrator that was given, or the one that "auto" and ``Auto`` choose for a scene, and why."""
    from nonsmooth.runs.choice import Auto

    choice = Auto() if isinstance(integrator, str) and integrator == "auto" else integrator
    if not isinstance(choice, Auto):
        return integrator, None
    from nonsmooth.runs.scene_by_system import choice_of_scene

    return choice_of_scene(choice, scene, t_span, of_steps_alone(asked))


def require_plain(q0: Any, u0: Any, state: Any) -> None:
    """Raise `InvalidInput` where a scene is given a start."""
    given = {"q0": q0, "u0": u0, "state": state}
    taken = [f"{name}=" for name, value in given.items() if value is not None]
    if taken:
        raise InvalidInput(f"a scene takes no {taken[0]}: its bodies have their start, and its contacts are found")
