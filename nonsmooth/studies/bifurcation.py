"""The study behind ``nonsmooth study bifurcation``: what a motion settles into along one parameter, up and down."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.errors import InvalidInput
from nonsmooth.studies.bifurcation_diagram import BifurcationDiagram, bifurcation_diagram
from nonsmooth.studies.stability import StabilityStudy
from nonsmooth.views import view

SHOWN_POINTS = 6  # chosen: maxima of a motion that are written out


def study_bifurcation(
    model: Any, axes: Mapping[str, ArrayLike], units: Mapping[str, str] | None = None, **options: Any
) -> StabilityStudy:
    """The maxima, or the section, of the motions that a model settles into along one parameter.

    Parameters
    ----------
    model : System or model
    axes : mapping
        One parameter and its values.
    units : mapping, optional
        Its unit, for the figure.
    **options
        As of `bifurcation_diagram`.

    Returns
    -------
    StabilityStudy

    Raises
    ------
    InvalidInput
        Unless there is one parameter.
    """
    if len(axes) != 1:
        raise InvalidInput(f"a bifurcation diagram goes along one parameter; got {', '.join(axes) or 'none'}: --axis")
    ((parameter, values),) = axes.items()
    diagram = bifurcation_diagram(model, parameter, values, **options)
    unit = (units or {}).get(parameter, "")
    draw = partial(_draw, diagram, f"{parameter} [{unit}]" if unit else "")
    return StabilityStudy(table(diagram), draw, results={"diagram": diagram})


def table(diagram: BifurcationDiagram) -> str:
    """A line for each value: how many points there are upwards and downwards, and the first of them."""
    what = "local maxima" if diagram.periods is None else "points once a period of the forcing"
    lines = [f"{what} of {diagram.coordinate_label}", f"{diagram.parameter:>12}  upwards; downwards"]
    for value, up, down, settled in zip(
        diagram.values, diagram.upwards, diagram.downwards, diagram.settled.T, strict=True
    ):
        lines.append(f"{value:12.6g}  {points(up, settled[0])}; {points(down, settled[1])}")
    return "\n".join(lines)


def points(found: np.ndarray, is_settled: bool) -> str:
    """The number of points, and the first of them; and whether they are not those of a settled motion."""
    if not is_settled:
        return f"not settled, {points(found, True)}"
    if not len(found):
        return "none"
    more = ", ..." if len(found) > SHOWN_POINTS else ""
    return f"{len(found)}: " + " ".join(f"{x:.6g}" for x in found[:SHOWN_POINTS]) + more


def _draw(diagram: BifurcationDiagram, label: str, path: Path) -> Any:
    return view(diagram, "plot")(diagram, path, label)
