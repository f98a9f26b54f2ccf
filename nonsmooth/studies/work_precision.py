"""Run time against error: several methods on several motions, measured together.

    error = mean |q(t_k) - q_ref(t_k)| / max |q_ref(t_k)|    over the times t_k of a motion, Euclidean norms

A method is run at a row of settings, steps or tolerances. Wall times are medians of repeats, each of which runs every
setting of every method once before the next begins, so that a load of the machine falls on all. Two methods are
compared at equal error: the time of each is read off its runs, log-log between neighbours.
Source: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I* (1993), II.10 (work-precision diagrams).
"""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_count, as_flag
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.adaptive.options import Adaptive
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.mechanics.start import own_state
from nonsmooth.results.failures import StepFailure
from nonsmooth.runs.times import span_of
from nonsmooth.scenes.given import as_scene
from nonsmooth.signals.telling import listening, tell
from nonsmooth.studies.comparison import as_motion
from nonsmooth.studies.reference import Problem, with_step, with_tolerance
from nonsmooth.studies.study import require_xarray
from nonsmooth.studies.work_precision_result import WorkPrecision
from nonsmooth.sweeps.progress import part_shown

TIMES = 16  # chosen: at which a motion is looked at, evenly spaced, where it does not say
STEP_PARTS = tuple(10.0 ** (-0.5 * k) for k in range(4, 12))  # chosen: of the span: 1e-2 to 3e-6
WORK_TOLERANCES = tuple(10.0**-k for k in range(3, 13))  # chosen: relative
TIMED_RUNS = 5  # chosen: of which the fastest counts
LONG_RUN_TIME = 1.0  # chosen: s, of a run that is not repeated
REFERENCES = (EventDriven(rtol=1e-12, atol=1e-14), Adaptive(rtol=1e-10, atol=1e-12))
COLUMNS = ("setting", "error", "wall_time", "evaluations", "steps")


class TimedMotion(NamedTuple):
    """A motion to integrate, and when it is looked at.

    Attributes
    ----------
    system : System or model
    t_span : (float, float), optional
        Start and end [s]; (0, t_end) when left out.
    q0, u0 : array_like, optional
        The model's default state when left out.
    times : array_like, optional
        When positions are compared [s]; 16 times when left out.
    reference : optional
        Positions (n_t, n_q) known at these times, a function of time, or two integrators; see `work_precision`.
    """

    system: Any
    t_span: tuple[float, float] | None = None
    q0: ArrayLike | None = None
    u0: ArrayLike | None = None
    times: ArrayLike | None = None
    reference: Any = None


class Trial(NamedTuple):
    """One run of a method."""

    q: np.ndarray  # (n_t, n_q) at the times
    wall_time: float  # s, of the loop over the steps
    evaluations: float
    steps: float


class Method(Protocol):
    """What can be measured: an integrator (`OwnMethod`), or another program through an adapter."""

    def settings(self, name: str, problem: Problem) -> Sequence[float]:
        """Steps or tolerances for a motion; none where the method cannot run it."""

    def run(self, name: str, problem: Problem, setting: float) -> Trial:
        """One run; StepFailure where it fails."""


@dataclass(frozen=True)
class OwnMethod:
    """An integrator of this package, over its step or its tolerance.

    Parameters
    ----------
    integrator : integrator or class
    values : tuple of float, optional
        Steps [s] or tolerances; parts of the span, 1e-2 to 3e-6, or 1e-3 to 1e-12 when left out.
    """

    integrator: Any
    values: tuple[float, ...] | None = None

    @property
    def has_step(self) -> bool:
        """Whether it is varied by its step, and not by its tolerance."""
        return "dt" in [field.name for field in fields(self.integrator)]

    def settings(self, name: str, problem: Problem) -> Sequence[float]:
        """Steps or tolerances for a motion."""
        if self.values is not None:
            return self.values
        span = problem.span[1] - problem.span[0]
        return [span * part for part in STEP_PARTS] if self.has_step else WORK_TOLERANCES

    def made(self, setting: float) -> Any:
        """The integrator with a step or tolerance."""
        if isinstance(self.integrator, type):
            return self.integrator(setting) if self.has_step else self.integrator(rtol=setting, atol=setting / 100)
        return (with_step if self.has_step else with_tolerance)(self.integrator, setting)

    def run(self, name: str, problem: Problem, setting: float) -> Trial:
        """One run."""
        with listening(None):  # the study reports its progress, not each of its runs
            solution = problem.run(self.made(setting), problem.times)
        stats = solution.stats
        q = solution.q[-len(problem.times) :]
        return Trial(q, stats.wall_time, getattr(stats, "evaluations", 0) or stats.steps, stats.steps)


class Known(NamedTuple):
    """A reference: positions at the times, and how far the two methods that gave them differ."""

    q: np.ndarray
    disagreement: float


def work_precision(
    systems: Mapping[str, TimedMotion] | Sequence[Any],
    integrators: Mapping[str, Any],
    reference: Any = None,
    *,
    repeats: int = TIMED_RUNS,
    progress: Any = True,
) -> WorkPrecision:
    """Measure error against run time and against evaluations of the forces.

    Parameters
    ----------
    systems : mapping of TimedMotion, or sequence of models
        By name; a model is run from its default state to its ``t_end``.
    integrators : mapping
        By label: an integrator or its class, which is run at a row of steps or tolerances; `OwnMethod` with chosen
        ones; or any `Method`, as an adapter of another program is.
    reference : optional
        For motions that bring none: (n_t, n_q) positions, a function of time that returns them, or a pair of
        integrators, of which the first counts and the difference is reported; by default ``EventDriven(rtol=1e-12)``
        and ``Adaptive(rtol=1e-10)``.
    repeats : int
        Runs of each setting; one that takes more than a second is not repeated.
    progress : bool
        A line on a terminal.

    Returns
    -------
    WorkPrecision
        A `Study` over "scene", "integrator" and "level"; after Ctrl-C of the scenes that were finished.

    Raises
    ------
    InvalidInput
        For settings, references and models that break a rule.
    StepFailure
        Where a reference cannot be computed. A method that fails is a gap in the study, with its message.
    MissingExtra
        Where xarray is not installed.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import WallPendulum
    >>> study = ns.work_precision([WallPendulum()], {"EventDriven": ns.EventDriven}, repeats=1)
    >>> bool(study.best_error("wall-pendulum", "EventDriven") < 1e-9)
    True
    """
    require_xarray()
    repeats = as_count("repeats", repeats)
    motions = as_scenes(systems)
    methods = {label: as_method(label, given) for label, given in integrators.items()}
    if not motions or not methods:
        raise InvalidInput("work_precision needs at least one motion and one integrator")
    found: dict[str, tuple[float, dict[str, list[dict[str, Any]]]]] = {}
    try:
        for name, motion in motions.items():
            problem = problem_of(motion)
            known = as_known(motion.reference if motion.reference is not None else reference, problem)
            with part_shown(name, as_flag("progress", progress)):
                found[name] = (known.disagreement, measure(name, problem, methods, known, repeats))
    except KeyboardInterrupt:
        if not found:
            raise
    study = assemble(found, list(methods))
    study.data.attrs["interrupted"] = int(len(found) < len(motions))
    return study


def as_scenes(systems: Any) -> dict[str, TimedMotion]:
    """Motions by name."""
    if isinstance(systems, Mapping):
        motions = dict(systems)
    else:
        motions = {model.name: TimedMotion(model) for model in systems}
    for name, motion in motions.items():
        if not isinstance(motion, TimedMotion):
            raise InvalidInput(f"{name!r} must be a TimedMotion(system, t_span, q0, u0); got {motion!r}")
    return motions


def as_method(label: str, given: Any) -> Method:
    """An integrator or its class as a method."""
    if isinstance(given, OwnMethod) or (hasattr(given, "settings") and hasattr(given, "run")):
        return given
    if is_dataclass(given) and {"dt", "rtol"} & {field.name for field in fields(given)}:
        return OwnMethod(given)
    raise InvalidInput(f"{label!r} must be an integrator or its class, with dt or rtol, or a Method; got {given!r}")


def problem_of(motion: TimedMotion) -> Problem:
    """The motion, checked, and when positions are compared."""
    span, start = span_of(motion.system, motion.t_span), (motion.q0, motion.u0)
    own = own_state(motion.system)
    if motion.q0 is None and motion.u0 is None and own is not None and as_scene(motion.system) is None:
        start = own()
    return as_motion(
        motion.system, span, *start, None, np.linspace(*span, TIMES + 1)[1:] if motion.times is None else motion.times
    )


def as_known(given: Any, problem: Problem) -> Known:
    """The reference of a motion."""
    times = problem.times
    pair = REFERENCES if given is None else given
    if isinstance(pair, tuple | list) and len(pair) == 2 and all(hasattr(one, "load") for one in pair):
        one, other = (problem.run(integrator, times).q[-len(times) :] for integrator in pair)
        return Known(one, distance(other, one))
    if callable(given):
        given = [given(float(t)) for t in times]
    q, n_q = np.asarray(given, dtype=float), problem.n_q
    if q.size != len(times) * n_q or not np.isfinite(q).all():
        raise InvalidInput(
            f"reference must be finite positions {len(times), n_q}: (times, coordinates), a function of time, or two "
            f"integrators; got {q.shape}"
        )
    return Known(q.reshape(len(times), n_q), 0.0)


def distance(q: np.ndarray, q_ref: np.ndarray) -> float:
    """The error of positions (n_t, n_q)."""
    scale = np.linalg.norm(q_ref, axis=1).max()
    return float(np.linalg.norm(q - q_ref, axis=1).mean() / (scale if scale > 0 else 1.0))


def measure(
    name: str, problem: Problem, methods: Mapping[str, Method], known: Known, repeats: int
) -> dict[str, list[dict[str, Any]]]:
    """A row for each setting of each method."""
    rows: dict[str, list[dict[str, Any]]] = {}
    walls: dict[tuple[str, int], list[float]] = {}
    settings = {label: method.settings(name, problem) for label, method in methods.items()}
    n, done = (1 + repeats) * sum(map(len, settings.values())), 0
    for label, method in methods.items():
        rows[label] = []
        for level, setting in enumerate(settings[label]):
            tell(done / n)
            done += 1
            try:
                trial = method.run(name, problem, setting)  # loads what it needs; its time does not count
            except (InvalidInput, StepFailure) as failure:
                rows[label].append({"setting": setting, "message": str(failure)})
                continue
            rows[label].append({
                "setting": setting, "error": distance(trial.q, known.q), "wall_time": trial.wall_time,
                "evaluations": trial.evaluations, "steps": trial.steps, "message": "",
            })  # fmt: skip
            walls[label, level] = []
    for _ in range(repeats):
        for (label, level), times in walls.items():
            tell(done / n)
            done += 1
            row = rows[label][level]
            if row["wall_time"] < LONG_RUN_TIME:
                times.append(methods[label].run(name, problem, row["setting"]).wall_time)
    for (label, level), times in walls.items():
        rows[label][level]["wall_time"] = statistics.median(times or [rows[label][level]["wall_time"]])
    return rows


def assemble(found: Mapping[str, tuple[float, Mapping[str, list[dict[str, Any]]]]], labels: list[str]) -> WorkPrecision:
    """The rows as a study; methods with fewer settings are filled with NaN."""
    xarray = require_xarray()
    levels = max((len(rows) for _, of_scene in found.values() for rows in of_scene.values()), default=0)
    shape = (len(found), len(labels), levels)
    arrays = {key: np.full(shape, np.nan) for key in COLUMNS}
    messages = np.full(shape, "", dtype=object)
    for i, (_, of_scene) in enumerate(found.values()):
        for j, label in enumerate(labels):
            for k, row in enumerate(of_scene[label]):
                messages[i, j, k] = row["message"]
                for key in COLUMNS:
                    arrays[key][i, j, k] = row.get(key, np.nan)
    dims = ("scene", "integrator", "level")
    data = xarray.Dataset(
        {key: (dims, values) for key, values in arrays.items()}
        | {"message": (dims, messages), "disagreement": ("scene", [floor for floor, _ in found.values()])},
        {"scene": list(found), "integrator": labels, "level": np.arange(levels)},
    )
    data["wall_time"].attrs["units"] = "s"
    return WorkPrecision("level", data, "run time against error")
