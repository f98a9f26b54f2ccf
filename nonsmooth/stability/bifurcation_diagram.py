"""What a motion settles into as a parameter is raised and lowered again, by simulation alone.

Each value starts from the state in which the motion of the value before ended, so that two attractors that coexist show
as different diagrams upwards and downwards. Nothing is assumed of the motion: it may be at rest, periodic or not; where
it has not settled within the given duration its maxima show as a streak.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.arrays import as_index, as_name, as_positive, as_vector
from nonsmooth.blocks import WORD
from nonsmooth.errors import InvalidInput
from nonsmooth.initial_state import as_state
from nonsmooth.integrators.moreau_jean import MoreauJean
from nonsmooth.memory import require_memory
from nonsmooth.simulation import simulate
from nonsmooth.solution import Solution
from nonsmooth.system import ContactMode, System, as_system

if TYPE_CHECKING:
    from pathlib import Path

LATE = 0.2  # last part of each simulation, which is looked at
DISTINCT = 1e-4  # of the coordinate's extent over the diagram: maxima nearer than that count as one


@dataclass(frozen=True, eq=False)
class BifurcationDiagram:
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
    """

    parameter: str
    coordinate: int
    values: np.ndarray
    upwards: tuple[np.ndarray, ...]
    downwards: tuple[np.ndarray, ...]
    opens: np.ndarray

    def plot(self, path: str | Path | None = None, label: str = "") -> Any:
        """The maxima against the parameter: see `plot_bifurcations`."""
        from nonsmooth.output.cycle_plots import plot_bifurcations

        return plot_bifurcations(self, path, label)


def bifurcation_diagram(
    system: Any,
    parameter: str,
    values: ArrayLike,
    coordinate: int = 0,
    start: tuple[Any, Any] | None = None,
    duration: float | None = None,
    dt: float | None = None,
) -> BifurcationDiagram:
    """Simulate along a parameter in both directions.

    Parameters
    ----------
    system : System or model
    parameter : str
    values : (k,)
        Increasing.
    coordinate : int
        Whose maxima are kept.
    start : (q0, u0), optional
        Of the first motion; the model's default state when left out.
    duration, dt : float, optional
        Of the simulation at each value [s]; five times the model's ``t_end``, and its ``dt``, when left out. The last
        fifth is looked at.

    Returns
    -------
    BifurcationDiagram

    Raises
    ------
    InvalidInput
        When the values do not increase, or a default is missing.
    """
    grid = as_vector("values", values)
    if grid.size == 0 or not (np.diff(grid) > 0).all():
        raise InvalidInput("values must increase, and at least one is needed")
    source = system if hasattr(system, "state") else as_system(system).parameters
    if start is None and not hasattr(source, "state"):
        raise InvalidInput("this system has no default state; give start=(q0, u0)")
    if duration is None and hasattr(source, "t_end"):
        duration = 5 * source.t_end
    dt = getattr(source, "dt", None) if dt is None else dt
    if duration is None or dt is None:
        raise InvalidInput("this system has no t_end and dt of its own; give duration= and dt=")
    system = as_system(system)
    coordinate = as_index("coordinate", coordinate, system.n_q)
    as_name("parameter", parameter, system.parameter_values)
    span, integrator = as_positive("duration", duration, "s"), MoreauJean(dt=dt)
    require_memory(
        WORD * LATE * span / integrator.dt, "the records of each value", "take a larger dt or a shorter duration"
    )
    state = source.state() if start is None else as_state("start", start, system)
    tables: list[list[Solution]] = []
    for direction in (grid, grid[::-1]):
        runs, state = _swept(system, parameter, direction, state, span, integrator)
        tables.append(runs)
    up, down = tables[0], tables[1][::-1]
    extent = max(np.ptp(run.q[:, coordinate]) for run in up + down)
    opens = np.array([[bool((run.mode == ContactMode.OPEN).any()) for run in runs] for runs in (up, down)])
    return BifurcationDiagram(
        parameter, coordinate, grid,
        tuple(maxima(run.q[:, coordinate], DISTINCT * extent) for run in up),
        tuple(maxima(run.q[:, coordinate], DISTINCT * extent) for run in down), opens,
    )  # fmt: skip


def _swept(
    system: System, parameter: str, values: np.ndarray, state: tuple[Any, Any], span: float, integrator: MoreauJean
) -> tuple[list[Solution], tuple[Any, Any]]:
    """The late part of the motion at each value, and the state in which the last ends."""
    late = np.linspace((1 - LATE) * span, span, max(int(LATE * span / integrator.dt), 2))
    runs = []
    for value in values.tolist():
        moved = system.with_parameters(**{parameter: value})
        run = simulate(moved, (0.0, span), *state, integrator=integrator, t_eval=late, project=True)
        state = run.q[-1], run.u[-1]
        runs.append(without_start(run))
    return runs, state


def without_start(run: Solution) -> Solution:
    """The records without the first, which is the start of the simulation."""
    from dataclasses import replace

    return replace(run, t=run.t[1:], q=run.q[1:], u=run.u[1:], mode=run.mode[1:])


def maxima(x: np.ndarray, distinct: float) -> np.ndarray:
    """The distinct local maxima of samples, increasing; the last sample where there is none."""
    inner = x[1:-1]
    peaks = np.sort(inner[(inner > x[:-2]) & (inner >= x[2:])])
    if peaks.size == 0 or np.ptp(x) <= distinct:
        return x[-1:]
    return peaks[np.concatenate([[True], np.diff(peaks) > distinct])]
