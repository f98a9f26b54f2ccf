"""The study behind ``nonsmooth study stability``: what becomes of steady sliding, at one point, along one parameter or
over two."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.equilibria.eigen_path import EigenPath, eigen_path
from nonsmooth.equilibria.equilibrium import equilibrium
from nonsmooth.equilibria.linearise import Linearisation, Verdict, linearise
from nonsmooth.equilibria.stability_map import stability_map
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.mechanics.start import start_of
from nonsmooth.views import view


@dataclass(frozen=True)
class StabilityStudy:
    """A table as text, the function that draws the figure (None at a single point), whether Ctrl-C ended it, and what
    was found, by name."""

    text: str
    draw: Callable[[Path], Any] | None
    is_interrupted: bool = False
    results: dict[str, Any] = field(default_factory=dict)


def study_stability(
    model: Any,
    axes: Mapping[str, ArrayLike],
    units: Mapping[str, str] | None = None,
    state: Any = None,
    sliding: ArrayLike | None = None,
    normal: ArrayLike | None = None,
) -> StabilityStudy:
    """Steady sliding of a model, and how its stability changes with up to two parameters.

    Parameters
    ----------
    model : System or model
    axes : dict
        Names of parameters and their values.
    units : mapping, optional
        Units of parameters, for the figure.
    state : dict or (q0, u0), optional
        Near whose coordinates steady sliding is looked for; the model's default state when left out.
    sliding, normal : (n_c,), optional
        Signs of sliding and of the normal forces, as of `equilibrium`.

    Returns
    -------
    StabilityStudy

    Raises
    ------
    InvalidInput
        When there are more than two parameters, or no steady sliding is found.
    """
    system = as_system(model)
    if len(axes) > 2:
        raise InvalidInput(f"one or two parameters can be varied; got {', '.join(axes)}")
    guess = None if state is None else start_of(model, state)[0]
    at = equilibrium(system, guess, sliding=sliding, normal=normal)
    small = linearise(system, at)
    text = describe(small)
    results: dict[str, Any] = {"sliding": small}
    if not axes:
        return StabilityStudy(text, None, results=results)
    if len(axes) == 2:
        chart = stability_map(system, axes, at, sensitivities=False)
        reached = chart.attrs.get("points_reached", chart.verdict.size)
        found = count(chart.verdict.values, chart.verdict.size - reached)
        draw = partial(_draw_map, chart, units or {})
        results |= {"map": chart}
        return StabilityStudy(f"{text}\n\n{found}", draw, reached < chart.verdict.size, results)
    (parameter, values), = axes.items()  # fmt: skip
    try:
        path = eigen_path(system, parameter, values, at)
    except KeyboardInterrupt:
        return StabilityStudy(text, None, True, results)
    is_cut = path.values.size < np.size(values)
    draw_path = partial(path.plot, unit=(units or {}).get(parameter, ""))
    results |= {"path": path}
    return StabilityStudy(f"{text}\n\n{changes(path, not is_cut)}", draw_path, is_cut, results)


def describe(small: Linearisation) -> str:
    """Where the system rests, under which forces, and its eigenvalues."""
    at = small.equilibrium
    system = at.mode.system
    named = zip(system.described.coordinates, at.q, strict=True)
    where = "steady sliding" if np.any(at.gamma_F[at.mode.closed]) else "equilibrium"
    lines = [f"{where}: " + ", ".join(f"{name} = {x:.9g} {unit}".rstrip() for (name, unit), x in named)]
    for i in at.mode.closed:
        name = system.described.contacts[i]
        lines.append(f"{name}: la_N = {at.la_N[i]:.9g} N, la_F = {at.la_F[i]:.9g} N, gamma_F = {at.gamma_F[i]:g} m/s")
    return "\n".join([*lines, small.summary()])


def changes(path: EigenPath, are_located: bool = True) -> str:
    """Every change of the verdict along the path; the boundary of stability to rounding, where that is asked."""
    if not path.changes:
        verdict = Verdict(path.verdicts[0])
        ends = f"{path.parameter} = {path.values[0]:g} ... {path.values[-1]:g}"
        return f"{spelt(verdict)} throughout {ends}"
    lines = []
    for before, after, was, becomes in path.changes:
        where = f"between {before:g} and {after:g}"
        edge = path.boundary(before, after) if are_located else None
        if edge is not None:
            where = f"= {edge.value:.12g}, frequency {edge.frequency:.9g} rad/s"
        lines.append(f"{path.parameter} {where}: {spelt(was)} -> {spelt(becomes)}")
    return "\n".join(lines)


def count(verdicts: np.ndarray, left: int = 0) -> str:
    """How many points of a map have each verdict, and how many were not reached."""
    lines = [f"{int((verdicts == v).sum()):6d} points {spelt(v)}" for v in Verdict if (verdicts == v).any()]
    missing = int(np.isnan(verdicts).sum()) - left
    lines += [f"{missing:6d} points without an equilibrium"] if missing else []
    return "\n".join(lines + ([f"{left:6d} points not reached"] if left else []))


def spelt(verdict: Verdict) -> str:
    """The verdict in words."""
    return verdict.name.lower().replace("_", " ")


def _draw_map(chart: Any, units: Mapping[str, str], path: Path) -> Any:
    return view("stability map", "plot")(chart, path, [units.get(name, "") for name in chart.growth.dims])
