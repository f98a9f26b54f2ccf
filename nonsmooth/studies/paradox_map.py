"""Maps of paradoxes: the number of solutions over any grid of coordinates, velocities and parameters.

A map is a sweep of `MapTask`, in threads.

Source: docs/theory/painleve.md; Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653, figure 3.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.checks.arrays import as_count
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.description import title_of
from nonsmooth.mechanics.start import answers_start
from nonsmooth.paradox.kinds import ParadoxKind
from nonsmooth.paradox.points import Points, split_axes
from nonsmooth.sweeps.map_task import MapTask
from nonsmooth.sweeps.sweep import sweep
from nonsmooth.sweeps.task import CellStatus

if TYPE_CHECKING:
    import xarray

MODES = {
    -1: "no_solution", 0: "free", 1: "stick_or_closed", 2: "slide_plus", 3: "slide_minus",
    4: "slide_plus_pulled", 5: "slide_minus_pulled", 6: "open", 7: "slide",
}  # fmt: skip
MOST_MAP_POINTS = 100_000_000  # chosen: of one map: its results are some ten gigabytes then
WHOLE_NUMBERS = {  # the results in order, and what those are that a sweep holds as floats
    "n_solutions": np.int32, "kind": np.int8, "p": None, "b": None, "gamma_F": None, "la_N": None, "modes": np.int8,
}  # fmt: skip


@answers_start
def paradox_map(system: Any, *, t: float = 0.0, state: Any = None, workers: int | None = None,
                kept: int | None = None, progress: Any = True, journal: str | os.PathLike[str] | None = None,
                **axes: Any) -> xarray.Dataset:  # fmt: skip
    """Classify every state of a grid.

    Parameters
    ----------
    system : System, model, or Scene
    t : float
        Time [s].
    state : callable, dict or (q0, u0), optional
        ``state(**variables) -> (q, u)`` in place of the model's; variables that are held fixed, as ``dict(th=0.8)``; or
        a state whose coordinates and rates are then varied by name.
    workers : int, optional
        Threads; one for each processor when left out.
    kept : int, optional
        Solutions written out at each point (3 for one contact, else 8); all of them are counted.
    progress : bool, "json" or callable
        As of `sweep`.
    journal : path-like, optional
        As of `sweep`: what is finished is written there, and not made again.
    **axes : float or array-like
        Variables of ``state(...)`` and parameters by name: an array is an axis of the map, a number is held fixed.
        The others keep their defaults.

    Returns
    -------
    xarray.Dataset
        Over the axes: ``n_solutions``; ``kind``, codes of `ParadoxKind`; ``p``, ``b``, ``gamma_F`` of each contact, p
        the least of the slides that the state admits, so that p < 0 is the paradox, gamma_F with friction in two
        directions the speed; ``la_N`` and ``modes`` of each
        solution. The attributes ``flag_values`` and ``flag_meanings`` explain codes; the dimension ``contact`` is there
        with several contacts. After Ctrl-C it ends with the value of the first axis that was reached, states that
        were not have the kind NOT_REACHED, and the attribute ``interrupted`` is 1. `plot_map` draws it.

    Raises
    ------
    UnknownName
        For a name that is neither a variable of the state nor a parameter.
    InvalidInput
        Without an axis, and where the model refuses a value.
    MissingExtra
        When xarray is not installed.

    Notes
    -----
    States that penetrate or land have the kind INADMISSIBLE and no solution counted; states with more contacts than are
    enumerated the kind NOT_ENUMERATED.

    Examples
    --------
    >>> import numpy as np
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import PainleveRod
    >>> th = np.radians([30.0, 60.0])
    >>> chart = ns.paradox_map(PainleveRod(), th=th, thdot=[0.0, 6.0], mu=2.0, slip=-1.0)
    >>> chart.n_solutions.values.tolist()
    [[1, 1], [0, 2]]
    """
    grid, fixed = split_axes(axes)
    if not grid:
        raise InvalidInput("a map needs at least one axis, as in th=np.linspace(0, 1, 100); for one state, classify")
    if taken := [name for name in grid if name in WHOLE_NUMBERS]:
        raise InvalidInput(f"{taken[0]} is a result of a map, and no name of an axis; give the parameter another name")
    shape = tuple(len(values) for values in grid.values())
    if not 0 < np.prod(shape, dtype=float) <= MOST_MAP_POINTS:
        raise InvalidInput(f"a map has 1 to {MOST_MAP_POINTS} points; got {shape}")
    task = MapTask(system, t=t, state=state, kept=kept, **fixed)
    points = task.points(tuple(grid))
    points.check(list(grid.values()))
    threads = os.cpu_count() or 1 if workers is None else min(as_count("workers", workers), os.cpu_count() or 1)
    found = sweep(task, grid, workers=threads, progress=progress, journal=journal)
    if found.attrs["interrupted"]:
        found = begun(found)
    refused = np.argwhere(found.status.values == CellStatus.FAILED)
    if len(refused):
        where = found.isel(dict(zip(grid, refused[0], strict=True)))
        raise InvalidInput(
            f"{where.message.item()} (at {', '.join(f'{name} = {float(where[name])}' for name in grid)})"
        )
    return as_map(found, points)


def begun(found: xarray.Dataset) -> xarray.Dataset:
    """The values of the first axis that a search ended by Ctrl-C came to."""
    is_reached = (found.status != CellStatus.NOT_RUN).values
    rows = np.flatnonzero(is_reached.reshape(len(is_reached), -1).any(axis=1))
    if not len(rows):
        raise KeyboardInterrupt
    return found.isel({found.status.dims[0]: slice(0, int(rows[-1]) + 1)})


def as_map(found: xarray.Dataset, points: Points) -> xarray.Dataset:
    """The results as whole numbers where they are, with what codes mean, and what was held fixed."""
    kinds = {int(kind): kind.name for kind in ParadoxKind}
    chart = found[list(WHOLE_NUMBERS)].copy()
    is_reached = found.status != CellStatus.NOT_RUN
    is_whole = bool(is_reached.all())
    for name, dtype in WHOLE_NUMBERS.items():
        if dtype is not None:
            left = ParadoxKind.NOT_REACHED if name == "kind" else -1
            known = found[name] if is_whole else found[name].where(is_reached, int(left))
            chart[name] = known.astype(dtype, keep_attrs=True)
    chart.kind.attrs.update(flags(kinds))
    chart.modes.attrs.update(flags(MODES))
    attrs = {"system": title_of(points.system), "t": points.t}
    attrs |= {name: value for name, value in points.system.parameter_values.items() if name not in points.names}
    attrs |= {name: points.default(name) for name in points.variables
              if name not in points.names and points.default(name) is not None}  # fmt: skip
    return chart.assign_attrs(attrs)


def flags(meanings: dict[int, str]) -> dict[str, Any]:
    """Codes and their meanings as the CF conventions write them."""
    return {"flag_values": np.array(list(meanings), np.int8), "flag_meanings": " ".join(meanings.values())}
