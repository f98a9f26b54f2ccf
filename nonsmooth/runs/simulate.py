"""The front door: check the input once, choose the run that fits the integrator, return its Solution."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, Literal, Protocol, overload

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_count, as_flag, as_name, as_positive
from nonsmooth.contact.planar.single import Selection
from nonsmooth.errors import (
    EnergyGainWarning,
    FrictionGainWarning,
    InvalidInput,
    SimultaneousImpactWarning,
    Status,
    ToleranceWarning,
    shown,
    warn_caller,
)
from nonsmooth.integrators.contract import Choice, Integrator
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.mechanics.model_system import as_system, require_planar
from nonsmooth.mechanics.start import answers_start, the_start
from nonsmooth.mechanics.system import UNILATERAL, System
from nonsmooth.results.recorded import LEDGER, kinds_of_system
from nonsmooth.results.solution import Solution
from nonsmooth.results.stats import energy_gain, friction_gain, rebound_together
from nonsmooth.runs.recorder import Recorder
from nonsmooth.runs.run import Run
from nonsmooth.runs.seen import looked_at, require_live
from nonsmooth.runs.size_of_motion import coarse, steps_again, suited, taken_again
from nonsmooth.runs.times import make_timetable, span_of
from nonsmooth.runs.user_events import OF_SCENE, OF_SYSTEM, as_functions
from nonsmooth.runs.watched import watch_of
from nonsmooth.runs.workspace import give_back
from nonsmooth.scenes.given import as_scene
from nonsmooth.signals.telling import listener

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution
    from nonsmooth.scenes.scene import Scene

MOST_THREADS = 64  # chosen: each has a memory of its own, 80 bytes a body and 16 a contact
TOLD_WORK = 0.01  # chosen: of what normal forces took: work of friction that is told by a warning
_is_whole: ContextVar[bool] = ContextVar("is_whole", default=False)  # whether a part of a motion is of no use
_may_go_ahead: ContextVar[bool] = ContextVar("may_go_ahead", default=False)  # whether a run may be ahead of its code
SELECTIONS = {
    "compliant-limit": Selection.COMPLIANT_LIMIT,
    "lift-off": Selection.LIFT_OFF,
    "impact": Selection.IMPACT,
}


class MakesScene(Protocol):
    """What builds a scene."""

    def scene(self) -> Scene:
        """The scene."""


@overload
def simulate(
    system: Scene | MakesScene,
    t_span: tuple[float, float] | None = None,
    *,
    integrator: Integrator | Choice | Literal["auto"] = "auto",
    every: int = 1,
    t_eval: ArrayLike | None = None,
    project: bool = False,
    on_failure: str = "raise",
    events: Callable[..., Any] | Sequence[Callable[..., Any]] = (),
    max_steps: int | None = None,
    max_wall_time: float | None = None,
    progress: Callable[[float], None] | bool | None = None,
    checkpoint: Any = None,
    resume: Any = None,
    checkpoint_every: float = 10.0,
    record: str | Sequence[str] | None = None,
    view: bool = False,
    threads: int = 1,
) -> SceneSolution: ...


@overload
def simulate(
    system: Any,
    t_span: tuple[float, float] | None = None,
    q0: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    *,
    integrator: Integrator | Choice | Literal["auto"] = "auto",
    state: Any = None,
    every: int = 1,
    t_eval: ArrayLike | None = None,
    selection: str = "compliant-limit",
    project: bool = False,
    on_failure: str = "raise",
    events: Callable[..., Any] | Sequence[Callable[..., Any]] = (),
    max_steps: int | None = None,
    max_wall_time: float | None = None,
    progress: Callable[[float], None] | bool | None = None,
    checkpoint: Any = None,
    resume: Any = None,
    checkpoint_every: float = 10.0,
    record: str | Sequence[str] | None = None,
    view: bool = False,
    threads: int = 1,
) -> Solution: ...


@answers_start
def simulate(
    system: Any,
    t_span: tuple[float, float] | None = None,
    q0: ArrayLike | None = None,
    u0: ArrayLike | None = None,
    *,
    integrator: Integrator | Choice | Literal["auto"] = "auto",
    state: Any = None,
    every: int = 1,
    t_eval: ArrayLike | None = None,
    selection: str = "compliant-limit",
    project: bool = False,
    on_failure: str = "raise",
    events: Callable[..., Any] | Sequence[Callable[..., Any]] = (),
    max_steps: int | None = None,
    max_wall_time: float | None = None,
    progress: Callable[[float], None] | bool | None = None,
    checkpoint: Any = None,
    resume: Any = None,
    checkpoint_every: float = 10.0,
    record: str | Sequence[str] | None = None,
    view: bool = False,
    threads: int = 1,
) -> Any:
    """Integrate a system or a scene from t_span[0] to t_span[1].

    Parameters
    ----------
    system : System, model, or Scene
        Or what builds one by a method ``system()`` or ``scene()``; the result of a scene is a `SceneSolution`.
    t_span : (float, float), optional
        Start and end [s]; (0, t_end) when left out, with the ``t_end`` of the system, the model or the scene.
    q0, u0 : array_like (n_q,), (n_u,)
        Initial coordinates and velocities.
    state : dict or (q0, u0), optional
        The start instead of q0 and u0: ``dict(th=0.8, thdot=-1)``, variables of the model's ``state(...)``, of a system
        without one its coordinates and their rates; ``{"q0[0]": 0.8}`` for single entries.
    integrator : MoreauJean, Adaptive, EventDriven, Penalty, Auto or "auto"
        The method and its step or tolerances. "auto", the default, takes EventDriven where few contacts are decided at
        once, Adaptive for many without friction and MoreauJean for the rest, and says why in the summary and in
        ``about["chosen"]``; Auto(rtol) takes what keeps a tolerance (nonsmooth/runs/choice.py has the rules).
    every : int
        Record every so many steps; of an integrator that chooses its steps also every event.
    t_eval : array_like, optional
        Record exactly at these times instead: steps of Moreau–Jean, fixed or adaptive, end there, others are
        interpolated. The start is one of them where it is asked for.
    selection : {"compliant-limit", "lift-off", "impact"}
        Which solution is taken where a rigid contact problem has several.
    project : bool
        Move an inadmissible start to the nearest admissible one in the mass metric; of a scene, bodies that overlap are
        moved apart.
    on_failure : {"raise", "return"}
        Raise `StepFailure` carrying the partial solution, or return that solution.
    events : sequence of callables, optional
        Functions f(t, q, u) whose zeros are looked for, in Python or compiled by numba; as in SciPy's ``solve_ivp``
        with the optional attributes ``terminal`` (True, or the number of the event that ends the run) and ``direction``
        (> 0: rising through zero, < 0: falling). They are found in ``t_events``, ``q_events``, ``u_events``. Of a
        scene, f(t, bodies) with ``bodies["box"].position``, ``.turn``, ``.velocity``, ``.spin``, looked at after every
        step and located within it; they are found in ``t_events``.
    max_steps : int, optional
        The most steps that the run may take.
    max_wall_time : float, optional
        The most seconds of wall time that it may take, looked at some 50 times a second.
    progress : bool or callable, optional
        Called now and then with the fraction done; True shows a bar in a terminal or a notebook.
    checkpoint : path-like, optional
        A folder, made here, into which records and events are written as the run goes, and its state now and then: a
        run that is killed can go on, and its records need not fit into memory (docs/checkpoints.md).
    resume : path-like, optional
        Go on with the checkpoint of the same run, to the bits of a run that was never stopped. The same path as
        ``checkpoint``: go on if it is there, else begin it.
    checkpoint_every : float
        Seconds between two states that are kept, the most that a kill costs.
    record : str or sequence of str, optional
        What is recorded beside the times, of "coordinates", "velocities", "gaps", "impulses", "modes", "ledger" and
        "events", all of these if left out; "motion" is short for the first two. What is left out is not computed where
        the motion does not need it, and takes no memory; asked for, it raises `InvalidInput` (docs/recording.md). Of a
        scene: beside times, residuals and penetrations, of "bodies", "contacts" and "ledger", all of these if left
        out, "events": landings, partings, slips and sticks of every pair of bodies, and "pairs": the impulses and works
        that each pair exchanged since the record before; "motion" is "bodies".
    view : bool
        Show the run in a browser while it goes on; the address is printed on stderr. Needs the extra [live]
        (docs/viewer.md).
    threads : int
        Of a scene: how many threads may solve its islands at once, to the same bits for any number of them
        (docs/benchmarks/scenes.md says what it gains, and where nothing).

    Returns
    -------
    Solution

    Raises
    ------
    InvalidInput
        For shapes, spans and options that break a rule.
    StepFailure, ModelFunctionError
        When a step cannot be taken, unless ``on_failure="return"``.
    BudgetSpent
        When ``max_steps`` or ``max_wall_time`` is used up, unless ``on_failure="return"``.
    EventFunctionError
        When an event function raises or returns no finite number, unless ``on_failure="return"``.
    ProgressError
        When the progress function raises, unless ``on_failure="return"``.
    CheckpointFailure
        When a checkpoint cannot be written on, as on a full disk.
    MissingExtra
        When viser is not installed, with ``view=True``.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import BouncingBall
    >>> ball = BouncingBall(e=0.5)
    >>> sol = ns.simulate(ball, (0, 2), *ball.state(height=1.0), integrator=ns.MoreauJean(dt=1e-3))
    >>> sol.success, abs(float(sol.q[-1, 0])) < 1e-2
    (True, True)
    """
    method: Any = integrator
    scene = as_scene(system)
    if scene is not None:
        t_span = span_of(scene, t_span)
        method, why = chosen_of_scene(method, scene, t_span)
        require_plain(q0, u0, state, "compliant-limit" if goes_by_system(method) else selection)
    else:
        recorded = kinds_of_system(record)
        model, system = system, as_system(system)
        t_span = span_of(model, t_span)
    every = as_count("every", every)
    if every != 1 and t_eval is not None:
        raise InvalidInput("give either every or t_eval; got both")
    rule = SELECTIONS[as_name("selection rule", selection, SELECTIONS)]
    if not isinstance(on_failure, str) or on_failure not in ("raise", "return"):
        raise InvalidInput(f"on_failure must be 'raise' or 'return'; got {shown(on_failure)}")
    if max_wall_time is not None:
        as_positive("max_wall_time", max_wall_time, "s")
    functions = as_functions(events, OF_SYSTEM if scene is None else OF_SCENE)
    project = as_flag("project", project)
    if max_steps is not None:
        as_count("max_steps", max_steps)
    if progress is not None and not isinstance(progress, bool) and not callable(progress):
        raise InvalidInput(
            f"progress must be a function of the fraction done, or True for a bar; got {shown(progress)}"
        )
    if as_flag("view", view):
        require_live()
    if as_count("threads", threads) > MOST_THREADS:
        raise InvalidInput(f"threads must be at most {MOST_THREADS}, and processors help no more; got {threads}")
    if threads > 1 and scene is None:
        raise InvalidInput("threads share the islands of a scene, and a system has none; leave out threads=")
    if scene is not None:
        if goes_by_system(method):
            from nonsmooth.runs.scene_by_system import SceneBySystem

            left_out = {"checkpoint": checkpoint, "resume": resume, "view": view, "threads": threads > 1}
            of_scene = SceneBySystem(scene, t_span, method, record, functions, left_out).run_by(
                simulate, integrator=integrator, every=every, t_eval=t_eval, selection=selection, project=project,
                on_failure=on_failure, max_steps=max_steps, max_wall_time=max_wall_time, progress=progress,
            )  # fmt: skip
        else:
            from nonsmooth.runs.simulate_scene import simulate_scene

            of_scene = simulate_scene(
                scene, t_span, method, every, t_eval, project, functions, on_failure, max_steps, max_wall_time,
                progress, record, checkpoint, resume, checkpoint_every, view, threads,
            )  # fmt: skip
            if why is not None:
                of_scene.about["chosen"] = why
        if of_scene.status == Status.INTERRUPTED and _is_whole.get():
            raise KeyboardInterrupt
        return of_scene  # type: ignore[return-value]
    q_0, u_0 = the_start(model, q0, u0, state, system)
    choice = as_choice(integrator)
    method, reason = (integrator, None) if choice is None else choice.choose(model, system, t_span, q_0, u_0)
    if not method.is_spatial:
        require_planar(system, type(method).__name__)
    task = (system, method, t_span, every, t_eval, q_0, u_0, rule, project)
    if checkpoint is None and resume is None:
        recorder = Recorder(recorded, is_watched=bool(functions))
        run = (run_ahead(*task, recorder) if _may_go_ahead.get() else None) or new_run(*task, recorder)
    elif functions:
        raise InvalidInput("a run with a checkpoint looks for no events; leave out events=, or checkpoint= and resume=")
    else:
        run = checkpointed_run(*task, recorded, checkpoint, resume, checkpoint_every)
    if functions:
        run.watch = watch_of(run, functions)
    if progress is None and not view:
        run.advance(max_wall_time, None, max_steps)
    else:
        with looked_at(run, progress, view) as hear:
            run.advance(max_wall_time, hear, max_steps)
    if run.status == Status.INTERRUPTED and _is_whole.get():
        raise KeyboardInterrupt
    solution = run.solution()
    take: Callable[..., Any] = simulate
    simulate_again = functools.partial(
        take, system, t_span, q_0, u_0, every=every, t_eval=t_eval, selection=selection, project=project,
        record=record,
    )  # fmt: skip
    may_again = checkpoint is None and resume is None
    other = None if choice is None else choice.instead(method, run.status, model, system, t_span)
    left = left_of(max_steps, solution.stats.steps), left_of(max_wall_time, run.wall_time)
    if other is not None and may_again and all(part is None or part > 0 for part in left):
        again = simulate_again(
            integrator=other, on_failure=on_failure, events=events, progress=progress, view=view, max_steps=left[0],
            max_wall_time=left[1],
        )  # fmt: skip
        again.about["chosen"] = f"{reason}, but not from t = {run.time():.6g} s on: the run was taken again"
        return again
    finer = suited(method, reason is not None, solution) if solution.success else None
    if finer is not None and may_again and not (functions or progress or view or max_steps):
        again = simulate_again(
            integrator=finer, on_failure="return", max_wall_time=max_wall_time, max_steps=steps_again(system, solution)
        )
        if again.success:
            again.about["chosen"] = "; ".join([*([reason] if reason else []), taken_again(method, again)])
            return again
    if finer is not None:
        warn_caller(coarse(method, solution), ToleranceWarning)
    if t_eval is not None and len(solution.t) > 1 and solution.t[0] < np.ravel(t_eval)[0]:
        solution = solution.without_start()
    if solution.is_found:
        tell_of_impacts(solution, system)
    if reason is not None:
        solution.about["chosen"] = reason
    if solution.success and not functions:
        give_back(system, run.workspace)
    if not solution.success and solution.status != Status.INTERRUPTED and on_failure == "raise":
        raise run.failure(solution)
    return solution


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
        warn_caller(rebound_together(stats), SimultaneousImpactWarning)


def friction_drives(solution: Solution) -> bool:
    """Whether friction is known to have done work in all, and not a little beside what the normal forces took."""
    if LEDGER not in solution.recorded:
        return False
    ledger = solution.find_ledger([0, -1])
    friction, normal = (float(np.diff(ledger[name])[0]) for name in ("friction", "normal"))
    return friction > TOLD_WORK * abs(normal)


def goes_by_system(integrator: Any) -> bool:
    """Whether a scene is integrated as its system: by what has no step of scenes."""
    from nonsmooth.integrators.penalty.options import Penalty

    require_integrator(integrator)
    return not isinstance(integrator, MoreauJean | Penalty)


def chosen_of_scene(integrator: Any, scene: Scene, t_span: tuple[float, float]) -> tuple[Any, str | None]:
    """The integrator that was given, or the one that "auto" and ``Auto`` choose for a scene, and why."""
    from nonsmooth.runs.choice import Auto

    choice = Auto() if isinstance(integrator, str) and integrator == "auto" else integrator
    if not isinstance(choice, Auto):
        return integrator, None
    from nonsmooth.runs.scene_by_system import choice_of_scene

    return choice_of_scene(choice, scene, t_span)


def require_plain(q0: Any, u0: Any, state: Any, selection: Any) -> None:
    """Raise `InvalidInput` where a scene is given what only a system takes."""
    given = {"q0": q0, "u0": u0, "state": state}
    given |= {"selection": None if selection == "compliant-limit" else selection}
    taken = [f"{name}=" for name, value in given.items() if value is not None]
    if taken == ["selection="]:
        raise InvalidInput(
            "a scene takes no selection=: where few contacts have several solutions it takes that of compliant-limit; "
            "scene.system() takes the other rules"
        )
    if taken:
        raise InvalidInput(f"a scene takes no {taken[0]}: its bodies have their start, and its contacts are found")


def simulate_whole(*motion: Any, **options: Any) -> Solution:
    """`simulate` for those who have no use for a part of a motion: Ctrl-C goes on as KeyboardInterrupt.

    Who listens (nonsmooth/signals/telling.py) hears how far the run is.
    """
    token = _is_whole.set(True)
    try:
        return simulate(*motion, **{"progress": listener(), **options})
    finally:
        _is_whole.reset(token)


def simulate_at_once(*motion: Any, **options: Any) -> Any:
    """`simulate` for who waits for one run: it may begin before its code is compiled (runs/ahead.py)."""
    token = _may_go_ahead.set(True)
    try:
        return simulate(*motion, **options)
    finally:
        _may_go_ahead.reset(token)


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


def require_integrator(integrator: Any) -> None:
    """Raise `InvalidInput` for what is no integrator."""
    if not isinstance(integrator, Integrator):
        raise InvalidInput(
            f"integrator must be an integrator, as ns.MoreauJean(dt=1e-3) is, or 'auto'; got {shown(integrator)}"
        )


def new_run(
    system: System, integrator: Integrator, t_span: tuple[float, float], every: int, t_eval: ArrayLike | None,
    q0: np.ndarray, u0: np.ndarray, selection: int, project: bool, recorder: Recorder | None = None,
) -> Run:  # fmt: skip
    """The run of an integrator."""
    table = make_timetable(integrator, t_span, every, t_eval)
    return Run(system, integrator, table, q0, u0, selection, project, recorder)


def run_ahead(
    system: System, integrator: Integrator, t_span: tuple[float, float], every: int, t_eval: ArrayLike | None,
    q0: np.ndarray, u0: np.ndarray, selection: int, project: bool, recorder: Recorder,
) -> Run | None:  # fmt: skip
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
) -> Run:  # fmt: skip
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
