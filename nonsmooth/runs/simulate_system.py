"""`simulate` for a system: the integrator that suits, the run, what is said of it, and whether it is taken again."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.errors import (
    EnergyGainWarning,
    FrictionGainWarning,
    InvalidInput,
    SimultaneousImpactWarning,
    Status,
    ToleranceWarning,
    warn_caller,
)
from nonsmooth.integrators.contract import Choice, Integrator
from nonsmooth.mechanics.model_system import as_system, require_planar
from nonsmooth.mechanics.start import the_start
from nonsmooth.mechanics.system import UNILATERAL, System
from nonsmooth.results.recorded import KINDS_OF_SYSTEM, LEDGER
from nonsmooth.results.solution import Solution
from nonsmooth.results.stats import energy_gain, friction_gain, rebound_together
from nonsmooth.runs.asked import Asked, require_integrator
from nonsmooth.runs.recorder import Recorder
from nonsmooth.runs.seen import looked_at
from nonsmooth.runs.size_of_motion import coarse, steps_again, suited, taken_again
from nonsmooth.runs.system_run import SystemRun
from nonsmooth.runs.times import make_timetable, span_of
from nonsmooth.runs.user_events import OF_SYSTEM, as_functions
from nonsmooth.runs.watched import watch_of
from nonsmooth.runs.workspace import give_back

TOLD_WORK = 0.01  # chosen: of what normal forces took: work of friction that is told by a warning
Task = tuple[System, Integrator, tuple[float, float], int, Any, np.ndarray, np.ndarray, int, bool]


def simulate_system(
    model: Any, t_span: tuple[float, float] | None, q0: Any, u0: Any, state: Any, integrator: Any, asked: Asked
) -> Solution:
    """`simulate` for a system, or a model of one."""
    if asked.threads > 1:
        raise InvalidInput("threads share the islands of a scene, and a system has none; leave out threads=")
    functions, recorded = as_functions(asked.events, OF_SYSTEM), KINDS_OF_SYSTEM.chosen(asked.record)
    system, t_span = as_system(model), span_of(model, t_span)
    q_0, u_0 = the_start(model, q0, u0, state, system)
    choice = as_choice(integrator)
    method, reason = (integrator, None) if choice is None else choice.choose(model, system, t_span, q_0, u_0)
    if system.is_spatial and not method.is_spatial:
        method = in_space(method, system)
    task = (system, method, t_span, asked.every, asked.t_eval, q_0, u_0, asked.rule, asked.project)
    run = run_of(task, recorded, functions, asked)
    with looked_at(run, asked.progress, asked.view) as hear:
        run.advance(asked.max_wall_time, hear, asked.max_steps)
    if run.status == Status.INTERRUPTED and asked.is_whole:
        raise KeyboardInterrupt
    solution = run.solution()
    other = None if choice is None else choice.instead(method, run.status, model, system, t_span)
    again = functools.partial(simulate_system, system, t_span, q_0, u_0, None)
    taken = by_another(again, other, run, solution, reason, asked) or by_a_finer(
        again, method, system, solution, reason, asked, functions
    )
    if taken is not None:
        return taken
    if asked.t_eval is not None and len(solution.t) > 1 and solution.t[0] < np.ravel(asked.t_eval)[0]:
        solution = solution.without_start()
    if solution.is_found:
        tell_of_impacts(solution, system)
    if reason is not None:
        solution.about["chosen"] = reason
    if solution.success and not functions:
        give_back(system, run.workspace)
    if not solution.success and solution.status != Status.INTERRUPTED and asked.on_failure == "raise":
        raise run.failure(solution)
    return solution


def in_space(method: Integrator, system: System) -> Integrator:
    """What integrates a system with q' = B u or friction in two directions for a method of the plane.

    Raises
    ------
    InvalidInput
        Of a method that has nothing for such a system.
    """
    from nonsmooth.integrators.adaptive.options import Adaptive
    from nonsmooth.integrators.event_driven.options import EventDriven

    if isinstance(method, Adaptive):
        from nonsmooth.integrators.adaptive.in_space import AdaptiveInSpace

        return AdaptiveInSpace(method.rtol, method.atol)
    if isinstance(method, EventDriven):
        from nonsmooth.integrators.event_driven.in_space import EventDrivenInSpace

        return EventDrivenInSpace(method.rtol, method.atol)
    require_planar(system, type(method).__name__)
    return method


def run_of(task: Task, recorded: tuple[str, ...], functions: list[Callable], asked: Asked) -> SystemRun:
    """The run that is asked for, which looks for the events of the user."""
    if asked.has_checkpoint and functions:
        raise InvalidInput("a run with a checkpoint looks for no events; leave out events=, or checkpoint= and resume=")
    if asked.has_checkpoint:
        return checkpointed_run(*task, recorded, asked.checkpoint, asked.resume, asked.checkpoint_every)
    recorder = Recorder(recorded, is_watched=bool(functions))
    run = (run_ahead(*task, recorder) if asked.may_go_ahead else None) or new_run(*task, recorder)
    if functions:
        run.watch = watch_of(run, functions)
    return run


def by_another(
    again: Callable[..., Solution],
    other: Integrator | None,
    run: SystemRun,
    solution: Solution,
    reason: str | None,
    asked: Asked,
) -> Solution | None:
    """The same run by another integrator, within what is left of its budgets, where the one that was chosen ended."""
    left = left_of(asked.max_steps, solution.stats.steps), left_of(asked.max_wall_time, run.wall_time)
    if other is None or asked.has_checkpoint or any(part is not None and part <= 0 for part in left):
        return None
    taken = again(other, replace(asked, max_steps=left[0], max_wall_time=left[1]))
    taken.about["chosen"] = f"{reason}, but not from t = {run.now:.6g} s on: the run was taken again"
    return taken


def by_a_finer(
    again: Callable[..., Solution], method: Integrator, system: System, solution: Solution, reason: str | None,
    asked: Asked, functions: list[Callable],
) -> Solution | None:  # fmt: skip
    """The same run to a tolerance that suits the size of its motion; where that cannot be had, it is told."""
    finer = suited(method, reason is not None, solution) if solution.success else None
    if finer is None:
        return None
    is_alone = not (functions or asked.progress or asked.view or asked.max_steps or asked.has_checkpoint)
    if is_alone:
        taken = again(finer, replace(asked, on_failure="return", max_steps=steps_again(system, solution)))
        if taken.success:
            taken.about["chosen"] = "; ".join([*([reason] if reason else []), taken_again(method, taken)])
            return taken
    warn_caller(coarse(method, solution), ToleranceWarning)
    return None


def tell_of_impacts(solution: Solution, system: System) -> None:
    """Warn of impacts that gained energy, of those at which friction did so much work that it drives the run, and of
    those that struck several contacts together under a law that nobody chose."""
    stats = solution.stats
    if stats.energy_gains:
        warn_caller(energy_gain(stats), EnergyGainWarning)
    elif stats.friction_gains and friction_drives(solution):
        warn_caller(friction_gain(stats), FrictionGainWarning)
    if stats.struck_together and any(
        contact.impact is None and contact.kind == UNILATERAL for contact in system.contacts
    ):
        warn_caller(rebound_together(stats, system), SimultaneousImpactWarning)


def friction_drives(solution: Solution) -> bool:
    """Whether friction is known to have done work in all, and not a little beside what the normal forces took."""
    if LEDGER not in solution.recorded:
        return False
    ledger = solution.find_ledger([0, -1])
    friction, normal = (float(np.diff(ledger[name])[0]) for name in ("friction", "normal"))
    return friction > TOLD_WORK * abs(normal)


def as_choice(integrator: Any) -> Choice | None:
    """What chooses the integrator, "auto" or ``Auto``; None where one was given."""
    if isinstance(integrator, str) and integrator == "auto":
        from nonsmooth.runs.choice import Auto

        return Auto()
    if isinstance(integrator, Choice):
        return integrator
    require_integrator(integrator)
    return None


def left_of(budget: float | None, used: float) -> Any:
    """What is left of a budget; None where there is none."""
    return None if budget is None else budget - used


def new_run(
    system: System, integrator: Integrator, t_span: tuple[float, float], every: int, t_eval: ArrayLike | None,
    q0: np.ndarray, u0: np.ndarray, selection: int, project: bool, recorder: Recorder | None = None,
) -> SystemRun:  # fmt: skip
    """The run of an integrator."""
    table = make_timetable(integrator, t_span, every, t_eval)
    return SystemRun(system, integrator, table, q0, u0, selection, project, recorder)


def run_ahead(
    system: System, integrator: Integrator, t_span: tuple[float, float], every: int, t_eval: ArrayLike | None,
    q0: np.ndarray, u0: np.ndarray, selection: int, project: bool, recorder: Recorder,
) -> SystemRun | None:  # fmt: skip
    """A run that begins in the interpreter while its code is compiled; None where it is compiled, or is to be first."""
    from nonsmooth.runs.ahead import AheadRun, compiled_elsewhere

    elsewhere = compiled_elsewhere(system, integrator)
    if elsewhere is None:
        return None
    table = make_timetable(integrator, t_span, every, t_eval)
    return AheadRun(elsewhere, system, integrator, table, q0, u0, selection, project, recorder)


def checkpointed_run(
    system: System, integrator: Integrator, t_span: tuple[float, float], every: int, t_eval: ArrayLike | None,
    q0: np.ndarray, u0: np.ndarray, selection: int, project: bool, recorded: tuple[str, ...], checkpoint: Any,
    resume: Any, seconds: float,
) -> SystemRun:  # fmt: skip
    """The run of an integrator, with its checkpoint.

    Raises
    ------
    InvalidInput
        For a checkpoint of another run, and a method that cannot be checkpointed.
    """
    from nonsmooth.runs.identity import facts_of_run
    from nonsmooth.runs.streaming import StreamingRecorder, as_place

    task = system, integrator, t_span, every, t_eval, q0, u0, selection, project
    facts = functools.partial(facts_of_run, *task, recorded)
    return new_run(*task, StreamingRecorder(facts, as_place(checkpoint, resume, seconds), recorded))
