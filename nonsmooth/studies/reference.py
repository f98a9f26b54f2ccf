"""What a study measures of a motion, and the reference that it measures against.

    q, u at given times;    t_i of matched events;    q, u at t_i + delay_i

A reference is given as arrays, or is the run of an integrator; then its error is the difference from a run with twice
the step, or ten times the tolerance. Events are matched where that integrator locates its own.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.checks.arrays import as_array, as_positive
from nonsmooth.errors import InvalidInput, SimultaneousImpactWarning, Status, shown
from nonsmooth.integrators.adaptive.options import Adaptive
from nonsmooth.integrators.contract import Integrator
from nonsmooth.integrators.event_driven.options import EventDriven
from nonsmooth.jit import identity
from nonsmooth.mechanics.description import title_of
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.system import System
from nonsmooth.results.solution import Solution
from nonsmooth.results.stats import Stats, energy_gain, friction_gain
from nonsmooth.runs.simulate import simulate_whole
from nonsmooth.scenes.given import as_scene
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import PLANAR
from nonsmooth.studies.matched_events import Entrances
from nonsmooth.sweeps.run_task import in_words
from nonsmooth.sweeps.task import identity_of_model

EXACT = EventDriven(rtol=1e-12, atol=1e-14)  # chosen: rigid contact, as good as rounding allows
EXACT_IN_SPACE = Adaptive(rtol=1e-9, atol=1e-11)  # chosen: of second order, as good as seconds allow
# chosen: of the reference: how much coarser the second run is that says how far the first may be off
COARSER_DT, COARSER_RTOL = 2.0, 10.0
BODIES_OF_A_STEP = 2.0  # measured: whose step with compliant contacts takes 5 us more than that of none
FEW_VARIABLES = 12.0  # chosen: of a system: N_0 of studies/affordable.py
Observed = dict[str, np.ndarray]  # "q", "u" (n_t, n); with events "event_t" (m, 1), "after_q", "after_u" (m, n)


class Foreseen(NamedTuple):
    """What a run will cost."""

    seconds: float
    steps: float
    has_ended: bool  # within what was tried: it is known then
    part: float  # of the motion that was tried


@dataclass(frozen=True)
class Problem:
    """A motion from a start, and when it is looked at.

    Attributes
    ----------
    model : System or model
    start : (t_0, q0, u0)
    times : ndarray (n_t,)
        Increasing; the last one is the end [s].
    """

    model: Any
    start: tuple[float, np.ndarray, np.ndarray]
    times: np.ndarray

    @property
    def system(self) -> System:
        """The system; made of the model where it is needed, since a model travels to other processes."""
        return as_system(self.model)

    @property
    def n_q(self) -> int:
        """Number of coordinates."""
        return self.system.n_q

    @property
    def about(self) -> dict[str, str]:
        """Name and parameters in words."""
        return in_words(self.system)

    def titled(self, question: str) -> str:
        """What a study is called: the system, where it has a name, and the question."""
        return ": ".join(part for part in (title_of(self.system), question) if part)

    @property
    def units_of_motion(self) -> tuple[list[str], list[str]]:
        """Of the coordinates and of the velocities, any of which the largest difference may be of."""
        described = self.system.described
        return [unit for _, unit in described.coordinates], [unit for _, unit in described.rates]

    @property
    def span(self) -> tuple[float, float]:
        """Start and end [s]."""
        return self.start[0], float(self.times[-1])

    @property
    def step_cost(self) -> float:
        """Of a step, of that of a system of few variables."""
        system = self.system
        return 1.0 + ((system.n_q + system.n_u + 2 * system.n_c) / FEW_VARIABLES) ** 2

    def identity(self) -> str:
        """A text that is equal for equal motions."""
        return f"{identity_of_model(self.model)}\n{identity(self.start).hex()}"

    def run(self, integrator: Any, at: np.ndarray | None = None) -> Solution:
        """The run of an integrator, recorded at some times, or at the start and every step.

        What it warns of, Newton's law of impact, holds for what it is compared with too.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SimultaneousImpactWarning)
            return simulate_whole(*self.motion, integrator=integrator, t_eval=at)

    @property
    def motion(self) -> tuple[Any, ...]:
        """The first arguments of `simulate`."""
        return self.system, self.span, *self.start[1:]

    def until(self, t: float) -> Problem:
        """The same motion up to an earlier end [s]."""
        return replace(self, times=np.array([t]))

    def foreseen(self, integrator: Any, **budget: Any) -> Foreseen:
        """What the run of an integrator will cost, from as much of it as a budget of `simulate` allows."""
        parts = [0.0]
        run = simulate_whole(
            *self.motion, integrator=integrator, t_eval=self.times[-1:], on_failure="return", progress=parts.append,
            **budget,
        )  # fmt: skip
        part = parts[-1] if run.status == Status.BUDGET_SPENT else 1.0
        scale = 1.0 / part if part > 0 else np.inf
        return Foreseen(run.stats.wall_time * scale, run.stats.steps * scale, part == 1.0, part)


@dataclass(frozen=True)
class SceneProblem(Problem):
    """The same of a scene; its bodies have their start."""

    @property
    def n_q(self) -> int:
        """Number of coordinates, those of a place and a turn for each body."""
        return (3 if self.scene.dim == PLANAR else 7) * len(self.scene)

    @property
    def about(self) -> dict[str, str]:
        """Name and parameters in words."""
        words = [f"{name} = {value:.4g}" for name, value in self.scene.parameter_values.items()]
        return {"system": self.scene.name, "parameters": "  ".join(words)}

    def titled(self, question: str) -> str:
        """What a study is called: the scene and the question."""
        return f"{self.scene.name or 'a scene'}: {question}"

    @property
    def units_of_motion(self) -> tuple[list[str], list[str]]:
        """Of centres and angles."""
        return ["m", "rad"], ["m/s", "rad/s"]

    @property
    def motion(self) -> tuple[Any, ...]:
        """The first arguments of `simulate`."""
        return self.model, self.span

    @property
    def step_cost(self) -> float:
        """Of a step: in proportion to the bodies."""
        return 1.0 + len(self.scene.bodies) / BODIES_OF_A_STEP

    @property
    def scene(self) -> Scene:
        """The scene; made of the model where it is needed."""
        scene = as_scene(self.model)
        assert scene is not None
        return scene

    def identity(self) -> str:
        """A text that is equal for equal motions."""
        return identity(self.start[0], self.scene).hex()


@dataclass(frozen=True)
class Reference:
    """What is measured of the reference.

    Attributes
    ----------
    observed : dict of arrays
    floor : dict of arrays
        Largest errors of its own, of each row.
    events : Entrances or None
        Its events, where it locates them.
    delay : ndarray (m,)
        Time after each at which states are compared [s].
    doubt : str
        What is to be said of its impacts.
    """

    observed: Observed
    floor: dict[str, np.ndarray]
    events: Entrances | None = None
    delay: np.ndarray | None = None
    doubt: str = ""

    def observe(self, problem: Problem, integrator: Any, run: Solution) -> Observed:
        """The same of a run, which was recorded at the times of the problem; NaN where it has no such event."""
        n = len(problem.times)
        observed = {"q": run.q[-n:], "u": run.u[-n:]}
        if self.events is None or self.delay is None:
            return observed
        t = self.events.matched(run)
        observed |= {"event_t": t[:, None], **states_at(problem, integrator, t + self.delay)}
        return observed

    def errors(self, observed: Observed) -> dict[str, np.ndarray]:
        """Largest difference of each row, by name."""
        return largest_differences(observed, self.observed)


def states_at(problem: Problem, integrator: Any, t: np.ndarray) -> Observed:
    """The states at some times in any order; NaN at those that are NaN or beyond the end."""
    system = problem.system
    q, u = np.full((len(t), system.n_q), np.nan), np.full((len(t), system.n_u), np.nan)
    inside = np.flatnonzero(t <= problem.span[1])
    if len(inside):
        at, place = np.unique(t[inside], return_inverse=True)
        run = problem.run(integrator, at)
        q[inside], u[inside] = run.q[-len(at) :][place], run.u[-len(at) :][place]
    return {"after_q": q, "after_u": u}


def largest_differences(one: Observed, other: Observed) -> dict[str, np.ndarray]:
    """Largest difference in each row, by name."""
    return {name: np.abs(values - other[name]).max(axis=1) for name, values in one.items()}


def as_reference(given: Any, problem: Problem, delay: float | None = None) -> Reference:
    """A reference from arrays (q, u) or from an integrator.

    Parameters
    ----------
    given : (array_like, array_like) or integrator
    problem : Problem
    delay : float, optional
        Time after each event [s]; half the time to the next one when left out.

    Raises
    ------
    InvalidInput
        For arrays of other shapes, and for a delay where no events are located.
    """
    if isinstance(given, tuple | list) and len(given) == 2:
        if delay is not None:
            raise InvalidInput("delay= needs the events of a reference; give an integrator that locates them")
        return as_given(given, problem)
    if delay is not None:
        as_positive("delay", delay, "s")
    if not isinstance(given, Integrator):
        raise InvalidInput(
            f"reference must be an integrator, or a pair (q, u) of states at the times; got {shown(given)}"
        )
    fine, coarse = problem.run(given, problem.times), problem.run(coarser(given), problem.times)
    alone = Reference({}, {})
    if given.locates_events:
        t_end = problem.span[1]
        events = Entrances.of_run(fine).before(t_end - (delay or 0.0))
        if len(events.t):
            alone = Reference({}, {}, events, events.middles(t_end) if delay is None else np.full(len(events.t), delay))
    elif delay is not None:
        raise InvalidInput(f"delay= needs a reference that locates its events, as EventDriven does; got {given!r}")
    observed = alone.observe(problem, given, fine)
    floor = largest_differences(observed, alone.observe(problem, coarser(given), coarse))
    return replace(alone, observed=observed, floor=floor, doubt=doubt_of_impacts(fine))


def doubt_of_impacts(run: Solution) -> str:
    """Why no compliant contact tends to a rigid run: its impacts, or their friction, gained energy."""
    stats = run.stats
    gained = getattr(stats, "energy_gains", 0), getattr(stats, "friction_gains", 0)
    if not any(gained) or not isinstance(stats, Stats):
        return ""
    said = energy_gain(stats) if gained[0] else friction_gain(stats)
    return f"the limits differ: in the rigid reference {said}; the friction of springs and dampers only takes"


def as_given(pair: Any, problem: Problem) -> Reference:
    """States (q, u) that the caller knows."""
    shape = (len(problem.times), problem.n_q)
    q, u = (as_array(f"reference[{k}]", column) for k, column in enumerate(pair))
    q, u = (column.reshape(shape) if column.size == shape[0] * shape[1] else column for column in (q, u))
    if q.shape != shape or u.shape != shape:
        raise InvalidInput(
            f"reference must be a pair of arrays {shape}: (times, coordinates); got {q.shape}, {u.shape}"
        )
    return Reference({"q": q, "u": u}, {name: np.zeros(len(q)) for name in ("q", "u")})


def coarser(integrator: Any) -> Any:
    """The same method with a larger step or tolerance."""
    if hasattr(integrator, "dt"):
        return with_step(integrator, COARSER_DT * integrator.dt)
    return with_tolerance(integrator, COARSER_RTOL * integrator.rtol)


def with_step(integrator: Any, dt: float) -> Any:
    """The same method with another step."""
    return replace(integrator, dt=dt)


def with_tolerance(integrator: Any, rtol: float) -> Any:
    """The same method with another relative tolerance; the absolute one changes with it."""
    return replace(integrator, rtol=rtol, atol=integrator.atol * rtol / integrator.rtol)
