"""What a motion settles into as a parameter is raised and lowered again, by simulation alone.

Each value starts from the state in which the motion of the value before ended, so that two attractors that coexist show
as different diagrams upwards and downwards: a chain, which is one cell of a sweep over the starts. Nothing is assumed
of the motion: it may be at rest, periodic or not. It has settled where its range and its maxima are the same in both
halves of the second half of its simulation; what has not is marked wherever it is drawn or printed.

Of a forced system the coordinate is looked at once a period of the forcing instead,

    x(n T),    n T in the late part, the duration a whole number of periods:

a motion that repeats after m periods has m points, in general distinct, whatever its maxima (the stroboscopic section;
Guckenheimer, Holmes, *Nonlinear Oscillations* (1983), section 1.5).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_instance, as_name, as_positive, as_vector, result_of
from nonsmooth.checks.memory import require_memory
from nonsmooth.errors import InvalidInput, UnsettledWarning, warn_caller
from nonsmooth.integrators.contract import Integrator
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.jit import identity
from nonsmooth.jit.blocks import WORD
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.start import answers_start, forms_of, own_state, own_time, start_of
from nonsmooth.mechanics.system import ContactMode, System
from nonsmooth.mechanics.units import unit_of_parameter
from nonsmooth.runs.simulate import simulate_whole
from nonsmooth.scenes.given import as_model
from nonsmooth.signals.telling import tell
from nonsmooth.sweeps.measures import SETTLED_AMPLITUDE
from nonsmooth.sweeps.sweep import require_whole, sweep
from nonsmooth.sweeps.task import identity_of_model
from nonsmooth.views import Worded, view

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.results.solution import Solution

LATE = 0.2  # chosen: last part of each simulation, whose points are kept
SECOND_HALF = 0.5  # chosen: of a simulation, in which it is seen whether it has settled
DISTINCT_MAXIMA = 1e-4  # chosen: of the coordinate's extent over the diagram: maxima nearer than that count as one
# chosen: points of a section: a motion of as many periods is distinguished from one that has not settled
LEAST_SECTIONS = 8
PERIODS: dict[str, Callable[[float], float]] = {  # of a forcing, by the unit of the parameter that says it
    "s": lambda period: period, "Hz": lambda frequency: 1.0 / frequency, "rad/s": lambda omega: 2.0 * math.pi / omega,
}  # fmt: skip
SHOWN_VALUES = 5  # chosen: of those where something is to be said
STILL_MOTION = 1e-9  # chosen: of the coordinate's size: smaller motions are the end of a decay, or rounding


@dataclass(frozen=True, eq=False, repr=False)
class BifurcationDiagram(Worded):
    """Local maxima of a coordinate along a parameter, or its values once a period of the forcing, up- and downwards.

    Attributes
    ----------
    parameter : str
    coordinate : int
    values : ndarray (k,)
    upwards, downwards : tuple of k arrays
        The distinct local maxima of the coordinate in the late part of each motion; for a motion at rest, its position;
        none for one that moves without a maximum there.
        Of a section its distinct values at whole periods of the forcing.
    opens : ndarray (2, k) of bool
        Whether a contact opened in the late part, upwards and downwards.
    coordinate_label : str
        Name and unit of the coordinate.
    system : System, optional
        Whose motions they are; it names the axes of the figure.
    periods : ndarray (k,), optional
        Of the forcing at each value [s], where the diagram is a section.
    change : ndarray (2, k), optional
        By which part of its range a motion differs between the two halves of the second half of its simulation, in its
        range or its points (which time steps know to a step); of several starts the largest. Zero where it comes to
        rest within a hundredth of the diagram's extent.
    """

    parameter: str
    coordinate: int
    values: np.ndarray
    upwards: tuple[np.ndarray, ...]
    downwards: tuple[np.ndarray, ...]
    opens: np.ndarray
    coordinate_label: str = ""
    system: System | None = field(default=None, repr=False)
    periods: np.ndarray | None = None
    change: np.ndarray | None = None

    @property
    def settled(self) -> np.ndarray:
        """Whether the motions have settled (2, k), upwards and downwards: they change by a hundredth at most."""
        return np.ones(self.opens.shape, bool) if self.change is None else self.change <= SETTLED_AMPLITUDE

    def plot(self, path: str | Path | None = None, label: str = "") -> Any:
        """The maxima or the section against the parameter: see `plot_bifurcations`."""
        return view(self, "plot")(self, path, label)


@answers_start
def bifurcation_diagram(
    system: Any,
    parameter: str,
    values: ArrayLike,
    coordinate: int | str = 0,
    start: Any = None,
    duration: float | None = None,
    dt: float | None = None,
    workers: int = 1,
    progress: Any = True,
    state: Any = None,
    forcing: float | str | Callable[[Any], float] | None = None,
    integrator: Integrator | None = None,
) -> BifurcationDiagram:
    """Simulate along a parameter in both directions.

    Parameters
    ----------
    system : System, model, or Scene
    parameter : str
    values : (k,)
        Increasing.
    coordinate : int or str
        Its number or name, whose maxima are kept.
    start, state : (q0, u0), dict, or list of such, optional
        Of the first motion; the model's default state when left out. From each of several starts a chain of its own
        goes, and the diagram holds the maxima of all: more attractors are found.
    duration, dt : float, optional
        Of the simulation at each value [s]; five times the model's ``t_end``, and its ``dt``, when left out. The last
        fifth is looked at. A section takes the next whole number of periods, and steps of which a whole number make
        one.
    workers : int
        Processes for several starts.
    progress : bool, "json" or callable
        As of `sweep`; a cell is a chain of all the values.
    forcing : float, str or callable, optional
        Period of the forcing [s]: the diagram is the stroboscopic section then. Also the name of a parameter whose unit
        in the docstring of its class is [s], [Hz] or [rad/s], or the period as a function of the parameters,
        ``lambda p: 2 * math.pi / p.Omega``; both follow the parameter that is varied.
    integrator : integrator, optional
        In place of ``MoreauJean(dt)``; of one without a step ``dt`` is the time between two samples of the maxima.
        Points of a section differ by the errors of the steps: ``EventDriven()`` distinguishes those nearer than that.

    Returns
    -------
    BifurcationDiagram

    Raises
    ------
    InvalidInput
        When the values do not increase, a default is missing, or the last fifth of the duration holds fewer than eight
        periods.
    CellFailure
        When a simulation cannot go on.

    Warns
    -----
    UnsettledWarning
        Where a motion has not settled, or never repeats; and where it has no maximum in the last fifth, being slower
        than that, or drifting.

    Examples
    --------
    A mass against a wall under a force cos(Omega t): it hits once a period at 1.5 rad/s, once in two at 3.8 rad/s.

    >>> import math
    >>> from typing import NamedTuple
    >>> import nonsmooth as ns
    >>> class P(NamedTuple): Omega: float = 2.0
    >>> def mass(t, q, p, M): M[0, 0] = 1.0
    >>> def force(t, q, u, p, h): h[0] = math.cos(p.Omega * t) - q[0]
    >>> def gap(t, q, p, g_N): g_N[0] = q[0]
    >>> hammer = ns.System(coordinates=[("x", "m")], mass=mass, force=force, gap=gap, contacts=[ns.Contact(e_N=0.5)],
    ...                    parameters=P(), name="hammer")
    >>> diagram = ns.bifurcation_diagram(hammer, "Omega", [1.5, 3.8], state=dict(x=0.5), duration=200.0,
    ...                                  forcing=lambda p: 2 * math.pi / p.Omega, integrator=ns.EventDriven())
    >>> [points.round(3).tolist() for points in diagram.upwards]
    [[0.649], [0.238, 0.432]]
    """
    grid, system = as_vector("values", values), as_model(system)
    if grid.size == 0 or not (np.diff(grid) > 0).all():
        raise InvalidInput("values must increase, and at least one is needed")
    if start is not None and state is not None:
        raise InvalidInput("give either start or state; got both")
    start, own = state if start is None else start, own_state(system)
    if start is None and own is None:
        raise InvalidInput(f"this system has no default state; give state={forms_of(system)}")
    if duration is None and (t_end := own_time(system, "t_end")) is not None:
        duration = 5 * t_end
    if integrator is not None:
        as_instance("integrator", integrator, Integrator, "an integrator, as MoreauJean(dt=1e-3) or EventDriven()")
    dt = getattr(integrator, "dt", own_time(system, "dt") if dt is None else dt)
    needs_dt = integrator is None or forcing is None
    if duration is None or needs_dt and dt is None:
        raise InvalidInput("this system has no t_end and dt of its own; give duration= and dt=")
    coordinate = as_system(system).described.coordinate(coordinate)
    as_name("parameter", parameter, as_system(system).parameter_values)
    span = as_positive("duration", duration, "s")
    step = as_positive("dt", dt, "s") if needs_dt else math.inf
    periods = None if forcing is None else periods_along(as_system(system), parameter, grid, forcing, span)
    if periods is None:
        require_memory(
            WORD * SECOND_HALF * span / step, "the records of each value", "take a larger dt or a shorter duration"
        )
    starts = as_starts(own() if start is None and own else start, system)
    looks = [late_part(span, step)] * grid.size if periods is None else [section(span, T) for T in periods.tolist()]
    steps = MoreauJean(step) if integrator is None else integrator
    chain = Chain(
        system, parameter, np.concatenate([grid, grid[::-1]]), coordinate, starts, looks + looks[::-1],
        [steps] * (2 * grid.size) if periods is None else [whole_steps(steps, T) for T in [*periods, *periods[::-1]]],
        periods is not None,
    )  # fmt: skip
    starting = {"start": range(len(starts))}
    found = require_whole(sweep(chain, starting, workers=workers, fail_fast=True, progress=progress))
    late, opens = found.late.values, (found.opens.values > 0).any(axis=0)
    extent = np.nanmax(late) - np.nanmin(late)
    rests = found.size.values <= SETTLED_AMPLITUDE * max(extent, np.nanmax(np.abs(late)))
    change = np.where(rests & (found.grows.values == 0), 0.0, found.change.values).max(axis=0)
    distinct = DISTINCT_MAXIMA * extent + STILL_MOTION * np.nanmax(np.abs(late))
    points_of = maxima if periods is None else apart
    peaks = [points_of(late[:, i], distinct) for i in range(late.shape[1])]
    if periods is None:
        moving = [any(not peaks_of(motion, distinct).size for motion in motions) for motions in np.moveaxis(late, 1, 0)]
        warn_of_no_maxima(np.unique(chain.values[moving]), LATE * span)
    k = grid.size
    diagram = BifurcationDiagram(
        parameter, coordinate, grid, tuple(peaks[:k]), tuple(peaks[:k - 1:-1]), np.array([opens[:k], opens[:k - 1:-1]]),
        as_system(system).described.label(coordinate),
        as_system(system), periods, np.array([change[:k], change[:k - 1:-1]]),
    )  # fmt: skip
    warn_of_unsettled(diagram)
    return diagram


def periods_along(system: System, parameter: str, grid: np.ndarray, forcing: Any, duration: float) -> np.ndarray:
    """The period of the forcing at each value (k,) [s], of which the late part holds enough."""
    periods = [period_of(system.with_parameters(**{parameter: value}), forcing) for value in grid.tolist()]
    longest = max(periods)
    if LATE * duration < (LEAST_SECTIONS - 0.5) * longest:
        raise InvalidInput(
            f"the last fifth of duration = {duration:g} s must hold {LEAST_SECTIONS} periods of the forcing, the "
            f"longest of which is {longest:g} s; give duration={LEAST_SECTIONS * longest / LATE:.3g} or more"
        )
    return np.array(periods)


def period_of(system: System, forcing: Any) -> float:
    """The period of the forcing of a system [s], from a number, the name of a parameter, or a function of them all."""
    if callable(forcing):
        return as_positive("forcing(p)", result_of("forcing", forcing, system.parameters), "s")
    if not isinstance(forcing, str):
        return as_positive("forcing", forcing, "s")
    as_name("forcing", forcing, system.parameter_values)
    unit, value = unit_of_parameter(system.parameters, forcing), system.parameter_values[forcing]
    if unit not in PERIODS:
        raise InvalidInput(
            f"forcing = {forcing!r} must be a parameter whose unit in the docstring of its class is [s], [Hz] or "
            f"[rad/s]; got {f'[{unit}]' if unit else 'none'}; give the period itself, "
            f"forcing=lambda p: 2 * math.pi / p.{forcing}"
        )
    return as_positive(f"the period of {forcing}", PERIODS[unit](as_positive(forcing, value, unit)), "s")


def late_part(duration: float, dt: float) -> np.ndarray:
    """When a motion is looked at for its maxima [s]: in its second half."""
    late = np.linspace((1 - LATE) * duration, duration, max(int(LATE * duration / dt), 2))
    before = np.linspace((1 - SECOND_HALF) * duration, late[0], max(int((SECOND_HALF - LATE) * duration / dt), 2))
    return np.concatenate([before[:-1], late])


def section(duration: float, period: float) -> np.ndarray:
    """The same for a section: whole periods; the last ends the motion, so that the next begins in the same phase."""
    n = math.ceil(duration / period * (1.0 - DISTINCT_MAXIMA))
    return period * np.arange(n - round(SECOND_HALF * n) + 1, n + 1)


def is_late(times: np.ndarray) -> np.ndarray:
    """Which of the times of a look, of which the last one ends the motion, are in its late part."""
    return times >= (1.0 - LATE) * times[-1] * (1.0 - DISTINCT_MAXIMA)


def whole_steps(integrator: Integrator, period: float) -> Integrator:
    """The integrator with a step, no longer, of which a whole number make a period."""
    dt = getattr(integrator, "dt", None)
    return integrator if dt is None else replace(integrator, dt=period / math.ceil(period / dt))  # type: ignore[type-var]


def as_starts(given: Any, system: Any) -> list[tuple[np.ndarray, np.ndarray]]:
    """The starts (q0, u0): one, or a list of them."""
    pairs = given if isinstance(given, list) else [given]
    if not pairs:
        raise InvalidInput("start must be a pair (q0, u0), or a list of such pairs; the list is empty")
    return [start_of(system, pair, "start") for pair in pairs]


@dataclass(frozen=True, eq=False)
class Chain:
    """The function of a cell: motions along a parameter, each from where the one before ended."""

    model: Any
    parameter: str
    values: np.ndarray
    coordinate: int
    starts: list[tuple[np.ndarray, np.ndarray]]
    looks: list[np.ndarray]
    integrators: list[Integrator]
    is_section: bool

    def identity(self) -> str:
        """A text that is equal for equal chains."""
        starts = [(q.tolist(), u.tolist()) for q, u in self.starts]
        looks = [times[[0, -1]].tolist() for times in self.looks]
        parts = (self.parameter, self.values.tolist(), self.coordinate, starts, looks, self.integrators)
        return f"{identity_of_model(self.model)}\n{identity(parts).hex()}"

    def __call__(self, start: int) -> dict[str, np.ndarray]:
        """For each value the coordinate in the late part (k, m), NaN beyond the points of a section that has fewer, and
        whether a contact was open there (k,)."""
        system, most = as_system(self.model), max(int(is_late(times).sum()) for times in self.looks)
        state = self.starts[start]
        late: list[np.ndarray] = []
        opens: list[bool] = []
        settling: list[tuple[float, float, bool]] = []
        for value, times, integrator in zip(self.values.tolist(), self.looks, self.integrators, strict=True):
            moved = system.with_parameters(**{self.parameter: value})
            run = simulate_whole(
                moved, (0.0, times[-1]), *state, integrator=integrator, t_eval=times, project=True, progress=None
            )
            tell(len(late) / len(self.values))
            state = run.q[-1], run.u[-1]
            looked, x = is_late(times), run.q[:, self.coordinate]
            late.append(np.pad(x[looked], (0, most - int(looked.sum())), constant_values=np.nan))
            opens.append(was_open(run, looked))
            unsure = float(np.abs(run.u[:, self.coordinate]).max()) * getattr(integrator, "dt", 0.0)
            settling.append(settling_of(x, self.is_section, unsure))
        change, size, grows = map(np.array, zip(*settling, strict=True))
        return {"late": np.array(late), "opens": np.array(opens), "change": change, "size": size, "grows": grows}


def was_open(run: Solution, looked: np.ndarray) -> bool:
    """Whether a contact was open at one of these records, or opened between two of them."""
    since = run.t[looked][0]
    between = any(event.mode_after == ContactMode.OPEN and event.t >= since for event in run.events)
    return between or bool((run.mode[looked] == ContactMode.OPEN).any())


def settling_of(x: np.ndarray, is_section: bool, unsure: float) -> tuple[float, float, bool]:
    """By which part of its range a motion, or its section, differs between the halves of its samples: in its range, and
    in its points, each from the nearest one of the other half, but for what the samples are unsure by; that range, and
    whether the later half has the larger one."""
    halves = np.array_split(x, 2)
    extents = [float(np.ptp(half)) for half in halves]
    size = float(np.abs(x).max() if is_section else np.ptp(x))
    grows = extents[1] > extents[0] + unsure
    if size <= STILL_MOTION * float(np.abs(x).max()):
        return 0.0, size, grows
    lacks = 0.0 if is_section else 1.0 - min(extents) / size
    one, other = (half if is_section else peaks_of(half, 0.0) for half in halves)
    if not (len(one) and len(other)):
        return 1.0, size, grows
    nearest = np.abs(one[:, None] - other)
    aside = max(float(nearest.min(axis=0).max()), float(nearest.min(axis=1).max()))
    return max(lacks, (aside - unsure) / size), size, grows


def warn_of_unsettled(diagram: BifurcationDiagram) -> None:
    """Say at which values a motion has not settled."""
    values = diagram.values[~diagram.settled.all(axis=0)]
    if not values.size or diagram.change is None:
        return
    warn_caller(
        f"at {len(values)} values ({first_of(values)}) the motion has not settled to {SETTLED_AMPLITUDE:g}, or never "
        f"repeats: in the second half of its simulation it still changes by up to {diagram.change.max():.2g} of its "
        "range; its points are marked (settled); take a longer duration=",
        UnsettledWarning,
    )


def first_of(values: np.ndarray) -> str:
    """Some values of a parameter in a message."""
    return ", ".join(f"{value:g}" for value in values[:SHOWN_VALUES]) + (", ..." if len(values) > SHOWN_VALUES else "")


def apart(x: np.ndarray, distinct: float) -> np.ndarray:
    """The distinct values of several motions (s, m), increasing, but for NaN."""
    points = np.sort(x[np.isfinite(x)])
    return points[np.diff(points, prepend=-math.inf) > distinct]


def warn_of_no_maxima(values: np.ndarray, window: float) -> None:
    """Say at which values of the parameter (m,) a motion moves on without a maximum within the window [s]."""
    if not values.size:
        return
    warn_caller(
        f"at {len(values)} values ({first_of(values)}) the coordinate moves without a maximum in the last fifth of the "
        f"motion, {window:g} s: its period is longer, or it creeps or drifts; no point stands there; take a longer "
        "duration=",
        UnsettledWarning,
    )


def maxima(x: np.ndarray, distinct: float) -> np.ndarray:
    """The distinct local maxima of samples (m,), or of several motions (s, m), increasing; of a motion at rest its last
    sample."""
    return apart(np.concatenate([peaks_of(motion, distinct) for motion in np.atleast_2d(x)]), distinct)


def peaks_of(x: np.ndarray, distinct: float) -> np.ndarray:
    """The local maxima of samples; of a motion at rest the last one."""
    if np.ptp(x) <= distinct:
        return x[-1:]
    inner = x[1:-1]
    return inner[(inner > x[:-2]) & (inner >= x[2:])]
