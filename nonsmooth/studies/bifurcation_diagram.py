"""What a motion settles into as a parameter is raised and lowered again, by simulation alone.

Each value starts from the state in which the motion of the value before ended, so that two attractors that coexist show
as different diagrams upwards and downwards: a chain, which is one cell of a sweep over the starts. Nothing is assumed
of the motion: it may be at rest, periodic or not; where it has not settled within the given duration its maxima show as
a streak.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_name, as_positive, as_vector
from nonsmooth.checks.memory import require_memory
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.jit.blocks import WORD
from nonsmooth.mechanics.start import answers_start, describing, forms_of, own_state, start_of
from nonsmooth.mechanics.system import ContactMode, System, as_system
from nonsmooth.runs.simulate import simulate_whole
from nonsmooth.signals.telling import tell
from nonsmooth.sweeps.sweep import require_whole, sweep
from nonsmooth.views import Worded, view

if TYPE_CHECKING:
    from pathlib import Path

LATE = 0.2  # chosen: last part of each simulation, which is looked at
DISTINCT_MAXIMA = 1e-4  # chosen: of the coordinate's extent over the diagram: maxima nearer than that count as one
STILL_MOTION = 1e-9  # chosen: of the coordinate's size: smaller motions are the end of a decay, or rounding


@dataclass(frozen=True, eq=False, repr=False)
class BifurcationDiagram(Worded):
    """Local maxima of a coordinate along a parameter, upwards and downwards.

    Attributes
    ----------
    parameter : str
    coordinate : int
    values : ndarray (k,)
    upwards, downwards : tuple of k arrays
        The distinct local maxima of the coordinate in the late part of each motion; for a motion at rest, its position.
    opens : ndarray (2, k) of bool
        Whether a contact opened in the late part, upwards and downwards.
    coordinate_label : str
        Name and unit of the coordinate.
    system : System, optional
        Whose motions they are; it names the axes of the figure.
    """

    parameter: str
    coordinate: int
    values: np.ndarray
    upwards: tuple[np.ndarray, ...]
    downwards: tuple[np.ndarray, ...]
    opens: np.ndarray
    coordinate_label: str = ""
    system: System | None = field(default=None, repr=False)

    def plot(self, path: str | Path | None = None, label: str = "") -> Any:
        """The maxima against the parameter: see `plot_bifurcations`."""
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
) -> BifurcationDiagram:
    """Simulate along a parameter in both directions.

    Parameters
    ----------
    system : System or model
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
        fifth is looked at.
    workers : int
        Processes for several starts.
    progress : bool, "json" or callable
        As of `sweep`; a cell is a chain of all the values.

    Returns
    -------
    BifurcationDiagram

    Raises
    ------
    InvalidInput
        When the values do not increase, or a default is missing.
    CellFailure
        When a simulation cannot go on.
    """
    grid = as_vector("values", values)
    if grid.size == 0 or not (np.diff(grid) > 0).all():
        raise InvalidInput("values must increase, and at least one is needed")
    if start is not None and state is not None:
        raise InvalidInput("give either start or state; got both")
    start, source, own = state if start is None else start, describing(system), own_state(system)
    if start is None and own is None:
        raise InvalidInput(f"this system has no default state; give state={forms_of(system)}")
    if duration is None and hasattr(source, "t_end"):
        duration = 5 * source.t_end
    dt = getattr(source, "dt", None) if dt is None else dt
    if duration is None or dt is None:
        raise InvalidInput("this system has no t_end and dt of its own; give duration= and dt=")
    coordinate = as_system(system).described.coordinate(coordinate)
    as_name("parameter", parameter, as_system(system).parameter_values)
    span, integrator = as_positive("duration", duration, "s"), MoreauJean(dt=dt)
    require_memory(
        WORD * LATE * span / integrator.dt, "the records of each value", "take a larger dt or a shorter duration"
    )
    starts = as_starts(own() if start is None and own else start, system)
    there_and_back = np.concatenate([grid, grid[::-1]])
    chain = Chain(system, parameter, there_and_back, coordinate, starts, span, integrator)
    starting = {"start": range(len(starts))}
    found = require_whole(sweep(chain, starting, workers=workers, fail_fast=True, progress=progress))
    late, opens = found.late.values, (found.opens.values > 0).any(axis=0)
    distinct = DISTINCT_MAXIMA * np.ptp(late) + STILL_MOTION * np.abs(late).max()
    peaks = [maxima(late[:, i], distinct) for i in range(late.shape[1])]
    k = grid.size
    return BifurcationDiagram(
        parameter, coordinate, grid, tuple(peaks[:k]), tuple(peaks[:k - 1:-1]), np.array([opens[:k], opens[:k - 1:-1]]),
        as_system(system).described.label(coordinate),
        as_system(system),
    )  # fmt: skip


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
    span: float
    integrator: MoreauJean

    def __call__(self, start: int) -> dict[str, np.ndarray]:
        """For each value the coordinate in the late part (k, m), and whether a contact opened there (k,)."""
        system, span = as_system(self.model), self.span
        times = np.linspace((1 - LATE) * span, span, max(int(LATE * span / self.integrator.dt), 2))
        state = self.starts[start]
        late: list[np.ndarray] = []
        opens: list[bool] = []
        for value in self.values.tolist():
            moved = system.with_parameters(**{self.parameter: value})
            run = simulate_whole(
                moved, (0.0, span), *state, integrator=self.integrator, t_eval=times, project=True, progress=None
            )
            tell(len(late) / len(self.values))
            state = run.q[-1], run.u[-1]
            late.append(run.q[:, self.coordinate])
            opens.append(bool((run.mode == ContactMode.OPEN).any()))
        return {"late": np.array(late), "opens": np.array(opens)}


def maxima(x: np.ndarray, distinct: float) -> np.ndarray:
    """The distinct local maxima of samples (m,), or of several motions (s, m), increasing; of a motion without one its
    last sample."""
    peaks = np.sort(np.concatenate([peaks_of(motion, distinct) for motion in np.atleast_2d(x)]))
    return peaks[np.concatenate([[True], np.diff(peaks) > distinct])]


def peaks_of(x: np.ndarray, distinct: float) -> np.ndarray:
    """The local maxima of samples; the last sample where there is none."""
    inner = x[1:-1]
    peaks = inner[(inner > x[:-2]) & (inner >= x[2:])]
    return x[-1:] if peaks.size == 0 or np.ptp(x) <= distinct else peaks
