"""Maps of paradoxes: the number of solutions over any grid of coordinates, velocities and parameters.

Source: docs/theory/painleve.md; Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653, figure 3.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.arrays import as_count, as_number
from nonsmooth.errors import InvalidInput, MissingExtra
from nonsmooth.paradox.classify import ParadoxKind
from nonsmooth.paradox.forces import Outcome
from nonsmooth.paradox.points import Found, Points, split_axes

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray

MODES = {
    -1: "no_solution", 0: "free", 1: "stick_or_closed", 2: "slide_plus", 3: "slide_minus",
    4: "slide_plus_pulled", 5: "slide_minus_pulled", 6: "open",
}  # fmt: skip
MAX_POINTS = 100_000_000  # of one map: its results are some ten gigabytes then
KEPT_OF_ONE, KEPT_OF_SEVERAL = 3, 8  # solutions written out by default


def paradox_map(system: Any, *, t: float = 0.0, state: Callable | None = None, workers: int | None = None,
                kept: int | None = None, **axes: Any) -> xarray.Dataset:  # fmt: skip
    """Classify every state of a grid.

    Parameters
    ----------
    system : System or model
    t : float
        Time [s].
    state : callable, optional
        ``state(**variables) -> (q, u)`` for a system that has no ``state`` method.
    workers : int, optional
        Threads; one for each processor when left out.
    kept : int, optional
        Solutions written out at each point (3 for one contact, else 8); all of them are counted.
    **axes : float or array-like
        Variables of ``state(...)`` and parameters by name: an array is an axis of the map, a number is held fixed.
        The others keep their defaults.

    Returns
    -------
    xarray.Dataset
        Over the axes: ``n_solutions``; ``kind``, codes of `ParadoxKind`; ``p``, ``b``, ``gamma_F`` of each contact, p
        the least of the slides that the state admits, so that p < 0 is the paradox; ``la_N`` and ``modes`` of each
        solution. The attributes ``flag_values`` and ``flag_meanings`` explain codes; the dimension ``contact`` is there
        with several contacts.

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
    >>> from models import PainleveRod
    >>> th = np.radians([30.0, 60.0])
    >>> chart = ns.paradox_map(PainleveRod(), th=th, thdot=[0.0, 6.0], mu=2.0, slip=-1.0)
    >>> chart.n_solutions.values.tolist()
    [[1, 1], [0, 2]]
    """
    try:
        import xarray
    except ImportError:
        raise MissingExtra('paradox_map needs xarray; install it with pip install "nonsmooth[map]"') from None
    grid, fixed = split_axes(axes)
    if not grid:
        raise InvalidInput("a map needs at least one axis, as in th=np.linspace(0, 1, 100); for one state, classify")
    shape = tuple(len(values) for values in grid.values())
    if not 0 < np.prod(shape, dtype=float) <= MAX_POINTS:
        raise InvalidInput(f"a map has 1 to {MAX_POINTS} points; got {shape}")
    points = Points(system, tuple(grid), fixed, as_number("t", t, "s"), state)
    n_c = points.system.n_c
    if n_c == 0:
        raise InvalidInput("a map needs a system with contacts; this one has none")
    points.check(list(grid.values()))
    kept = (KEPT_OF_ONE if n_c == 1 else KEPT_OF_SEVERAL) if kept is None else as_count("kept", kept)
    threads = os.cpu_count() or 1 if workers is None else as_count("workers", workers)
    found = points.search(list(grid.values()), kept, workers=threads)
    return as_dataset(xarray, points, grid, found)


def kinds_of(found: Found) -> np.ndarray:
    """`ParadoxKind` of each point."""
    kind = np.minimum(found.number, 2)  # INCONSISTENT, REGULAR, INDETERMINATE
    kind = np.where(found.outcome == Outcome.TOO_MANY, ParadoxKind.NOT_ENUMERATED, kind)
    is_no_problem = (found.outcome == Outcome.INADMISSIBLE) | (found.outcome == Outcome.NOT_FINITE)
    return np.where(is_no_problem, ParadoxKind.INADMISSIBLE, kind).astype(np.int8)


def as_dataset(xarray: Any, points: Points, grid: dict[str, np.ndarray], found: Found) -> xarray.Dataset:
    """The results with names, units and meanings."""
    shape = tuple(len(values) for values in grid.values())
    dims = tuple(grid)
    is_one = points.system.n_c == 1
    contact = () if is_one else ("contact",)

    def over(dims_: tuple[str, ...], values: np.ndarray, **attrs: Any) -> tuple:
        rest = values.shape[1:-1] if is_one and values.ndim > 1 else values.shape[1:]
        return dims_, values.reshape(*shape, *rest), attrs

    kinds = {int(kind): kind.name for kind in ParadoxKind}
    data = {
        "n_solutions": over(dims, found.number, long_name="number of solutions"),
        "kind": over(dims, kinds_of(found), long_name="kind of paradox", **flags(kinds)),
        "p": over((*dims, *contact), found.p, units="1/kg", long_name="least p of the slides admitted"),
        "b": over((*dims, *contact), found.b, units="m/s^2", long_name="free normal acceleration"),
        "gamma_F": over((*dims, *contact), found.gamma_F, units="m/s", long_name="sliding velocity"),
        "la_N": over((*dims, "solution", *contact), found.la_N, units="N", long_name="normal force"),
        "modes": over((*dims, "solution", *contact), found.modes, long_name="mode of contact", **flags(MODES)),
    }
    attrs = {"system": points.system.name or "system", "t": points.t}
    attrs |= {name: value for name, value in points.system.parameter_values.items() if name not in grid}
    attrs |= {name: points.default(name) for name in points.variables
              if name not in grid and points.default(name) is not None}  # fmt: skip
    coords = {name: (name, values, {"units": unit_of(points.system, name)}) for name, values in grid.items()}
    return xarray.Dataset(data, coords=coords, attrs=attrs)


def flags(meanings: dict[int, str]) -> dict[str, Any]:
    """Codes and their meanings as the CF conventions write them."""
    return {"flag_values": np.array(list(meanings), np.int8), "flag_meanings": " ".join(meanings.values())}


def unit_of(system: Any, name: str) -> str:
    """Unit of a variable that is a coordinate of the model or its rate; empty where it is not known."""
    units = dict(getattr(system.parameters, "coordinates", ()))
    if name in units:
        return units[name]
    return f"{units[name[:-3]]}/s" if name.endswith("dot") and name[:-3] in units else ""
