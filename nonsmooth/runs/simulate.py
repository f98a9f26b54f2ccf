"""The front door: check what is asked for once, and hand it to the run of a system or of a scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, Literal, Protocol, overload

from numpy.typing import ArrayLike

from nonsmooth.integrators.contract import Choice, Integrator
from nonsmooth.mechanics.start import answers_start
from nonsmooth.results.solution import Solution
from nonsmooth.runs.asked import Asked
from nonsmooth.runs.simulate_system import simulate_system
from nonsmooth.scenes.given import as_scene
from nonsmooth.signals.telling import listener

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution
    from nonsmooth.scenes.scene import Scene

_is_whole: ContextVar[bool] = ContextVar("is_whole", default=False)  # whether a part of a motion is of no use
_may_go_ahead: ContextVar[bool] = ContextVar("may_go_ahead", default=False)  # whether a run may be ahead of its code


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
    asked = Asked(
        every, t_eval, selection, project, on_failure, events, max_steps, max_wall_time, progress, checkpoint, resume,
        checkpoint_every, record, view, threads, _is_whole.get(), _may_go_ahead.get(),
    )  # fmt: skip
    scene = as_scene(system)
    if scene is None:
        return simulate_system(system, t_span, q0, u0, state, integrator, asked)
    from nonsmooth.runs.simulate_scene import require_plain, simulate_scene

    require_plain(q0, u0, state)
    return simulate_scene(scene, t_span, integrator, asked)


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
