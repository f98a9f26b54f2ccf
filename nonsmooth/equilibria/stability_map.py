"""Stability of steady sliding over two parameters, with the slopes of the growth rate."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_flag, as_name, as_vector
from nonsmooth.equilibria.equilibrium import Equilibrium, as_equilibrium, equilibrium, follow_equilibrium
from nonsmooth.equilibria.linearise import linearise
from nonsmooth.equilibria.sensitivity import eigenvalue_sensitivity
from nonsmooth.errors import InvalidInput, MissingExtra, shown
from nonsmooth.mechanics.description import title_of
from nonsmooth.mechanics.model_system import as_rated
from nonsmooth.mechanics.units import unit_of_parameter
from nonsmooth.scenes.given import as_model
from nonsmooth.signals.telling import tell


def stability_map(
    system: Any, axes: Mapping[str, ArrayLike], at: Equilibrium | None = None, sensitivities: bool = True
) -> Any:
    """Growth rate, frequency and verdict of steady sliding over a grid of two parameters.

    Parameters
    ----------
    system : System, model, or Scene
    axes : mapping
        Two parameters and their values.
    at : Equilibrium, optional
        Where to start; its contacts and signs are kept. ``equilibrium`` at the first values when left out.
    sensitivities : bool
        Whether to compute d growth/dp for both parameters as well (five times the work).

    Returns
    -------
    xarray.Dataset
        ``growth`` max Re s [1/s], ``frequency`` of that eigenvalue [rad/s], ``verdict`` (Verdict), ``is_virtual``, and
        ``d_growth_d_NAME``; `plot_stability_map` draws it. Growth is NaN where no equilibrium is found. After Ctrl-C it
        is NaN from there on, and the attribute ``points_reached`` counts those that were looked at.

    Raises
    ------
    InvalidInput
        When ``axes`` does not name two parameters.
    MissingExtra
        When xarray is not installed.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import ModeCoupling
    >>> chart = ns.stability_map(ModeCoupling(), {"mu": [0.4, 0.6], "cz": [0.5, 1.0]})
    >>> [[ns.Verdict(v).name for v in row] for row in chart.verdict.values]
    [['STABLE', 'STABLE'], ['FLUTTER', 'FLUTTER']]
    """
    try:
        import xarray
    except ImportError:
        raise MissingExtra('maps need xarray; install it with pip install "nonsmooth[map]"') from None
    xarray.Dataset(coords={"first": [0.0]})  # what xarray imports at its first use, it imports now, not after Ctrl-C
    sensitivities = as_flag("sensitivities", sensitivities)
    if not isinstance(axes, Mapping):
        raise InvalidInput(f"axes must be a dictionary {{parameter: values}}; got {shown(axes)}")
    if len(axes) != 2:
        raise InvalidInput(f"axes must name two parameters; got {list(axes)}")
    (first, x), (second, y) = ((name, as_vector(name, values)) for name, values in axes.items())
    system = as_rated(as_model(system), "stability_map")
    for name, values in ((first, x), (second, y)):
        as_name("parameter", name, system.parameter_values)
        if values.size == 0:
            raise InvalidInput(f"the axis {name} must hold at least one value; got none")
    corner = {first: float(x[0]), second: float(y[0])}
    at = (
        equilibrium(system.with_parameters(**corner))
        if at is None
        else follow_equilibrium(as_equilibrium(at), **corner)
    )
    names = ["growth", "frequency", "verdict", "is_virtual"]
    names += [f"d_growth_d_{name}" for name in axes] if sensitivities else []
    table = {name: np.full((x.size, y.size), np.nan) for name in names}
    reached = 0
    with contextlib.suppress(KeyboardInterrupt):
        for i, j in np.ndindex(x.size, y.size):
            k = j if i % 2 == 0 else y.size - 1 - j  # to and fro, so that each point starts from a neighbour
            at, figures = _point(at, {first: float(x[i]), second: float(y[k])}, list(axes) if sensitivities else [])
            for name, value in zip(names, figures, strict=False):  # none where there is no equilibrium
                table[name][i, k] = value
            reached += 1
            tell(reached / table["growth"].size)
    data = {name: ((first, second), values) for name, values in table.items()}
    attrs: dict[str, Any] = {} if reached == table["growth"].size else {"points_reached": reached}
    attrs |= {"system": title_of(system)}
    attrs |= {name: value for name, value in system.parameter_values.items() if name not in (first, second)}
    model = at.mode.system.parameters
    coords = {
        name: (name, values, {"units": unit} if (unit := unit_of_parameter(model, name)) else {})
        for name, values in ((first, x), (second, y))
    }
    return xarray.Dataset(data, coords=coords, attrs=attrs)


def _point(at: Equilibrium, where: dict[str, float], parameters: list[str]) -> tuple[Equilibrium, list[float]]:
    """The equilibrium at other parameters and its figures; the one before and none where none is found."""
    try:
        at = follow_equilibrium(at, **where)
    except InvalidInput:
        return at, []
    return at, _figures(at, parameters)


def _figures(at: Equilibrium, parameters: list[str]) -> list[float]:
    """Growth, frequency, verdict, whether virtual, and the slopes of the growth."""
    system = at.mode.system
    small = linearise(system, at)
    k = int(np.abs(small.eigenvalues - small.dominant).argmin())
    slopes = [float(eigenvalue_sensitivity(system, name, small)[k].real) for name in parameters]
    return [small.growth, abs(small.dominant.imag), int(small.verdict), at.is_virtual, *slopes]
