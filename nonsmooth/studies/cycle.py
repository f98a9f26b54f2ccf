"""The study behind ``nonsmooth study cycle``: the periodic motion of a model, and its change along one parameter."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nonsmooth.cycles.cycle import CyclePhase, LimitCycle
from nonsmooth.cycles.cycle_branch import CycleBranch, continue_cycle
from nonsmooth.cycles.limit_cycle import limit_cycle
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.model_system import as_system
from nonsmooth.studies.stability import StabilityStudy
from nonsmooth.views import view

PRINTED_ROWS = 40  # chosen: of the printed table of a branch


def study_cycle(
    model: Any, axes: Mapping[str, ArrayLike], units: Mapping[str, str] | None = None, **options: Any
) -> StabilityStudy:
    """The cycle that a start tends to, the model's default state if none is given, and its branch along a parameter.

    Parameters
    ----------
    model : System or model
    axes : mapping
        At most one parameter and its values.
    units : mapping, optional
        Its unit, for the figure.
    **options
        As of `limit_cycle`.

    Returns
    -------
    StabilityStudy

    Raises
    ------
    InvalidInput
        When there is no cycle, or there are several parameters.
    """
    if len(axes) > 1:
        raise InvalidInput(f"a cycle is followed along one parameter; got {', '.join(axes)}")
    if not axes:
        cycle = limit_cycle(model, **options)
        return StabilityStudy(describe(cycle), partial(_draw_cycle, cycle), results={"cycle": cycle})
    ((parameter, values),) = axes.items()
    first = as_system(model).with_parameters(**{parameter: float(np.ravel(values)[0])})
    branch = continue_cycle(model, parameter, values, limit_cycle(first, **options), forcing=options.get("forcing"))
    is_interrupted = any(change.kind == "interrupted" for change in branch.changes)
    unit = (units or {}).get(parameter, "")
    label = f"{parameter} [{unit}]" if unit else ""
    draw = partial(_draw_branch, branch, label)
    return StabilityStudy(table(branch, not is_interrupted), draw, is_interrupted, {"branch": branch})


def describe(cycle: LimitCycle) -> str:
    """Period, multipliers and phases of a cycle."""
    multipliers = ", ".join(f"{m:.6f}" for m in np.round(cycle.multipliers, 6) + 0.0)
    marginal = "marginal (one of a family, or where the stability changes)"
    verdict = "stable" if cycle.is_stable else marginal if cycle.is_marginal else "unstable"
    lines = [
        f"period {cycle.period:.12g} s, {verdict}, residual {cycle.residual:.1e}",
        f"Floquet multipliers {multipliers}",
        *([f"drift in a period {', '.join(f'{gone:.12g}' for gone in cycle.drift)}"] if cycle.drifts else []),
        f"{'begins [s]':>14} {'duration [s]':>14}  phase",
    ]
    names = cycle.system.described.contacts
    lines += [
        f"{phase.begins:14.9f} {phase.duration:14.9f}  {phase.label}{jump(phase, names)}" for phase in cycle.phases
    ]
    return "\n".join(lines)


def jump(phase: CyclePhase, names: tuple[str, ...]) -> str:
    """What strikes at the end of a phase, in words."""
    if phase.jump is None:
        return ""
    struck = ", ".join(names[blow.contact] for blow in phase.jump.blows)
    return f", then {'an impact' if phase.jump.closing else 'an impact without collision'} at {struck}"


def table(branch: CycleBranch, has_amplitudes: bool = True) -> str:
    """A line for each of about forty cycles, then every change; amplitudes are integrated once more, some 0.1 s
    each."""
    head = "  (max - min)/2" if has_amplitudes else ""
    lines = [f"{branch.parameter:>12} {'period [s]':>14} {'stick [s]':>12} {'largest multiplier':>19}{head}"]
    stride = max(1, -(-len(branch.cycles) // PRINTED_ROWS))
    for value, cycle in list(zip(branch.values, branch.cycles, strict=True))[::stride]:
        largest = abs(cycle.multipliers).max() if cycle.multipliers.size else 0.0
        halves = "  " + " ".join(f"{half:.8g}" for half in cycle.amplitudes) if has_amplitudes else ""
        lines.append(f"{value:12.6g} {cycle.period:14.9f} {cycle.stick_duration:12.9f} {largest:19.6f}{halves}")
    lines += [
        f"{change.kind} at {branch.parameter} = {change.value:.10g}" if change.is_located else
        f"{change.kind} of {branch.parameter} {change.where(10)}" for change in branch.changes
    ]  # fmt: skip
    return "\n".join(lines)


def _draw_cycle(cycle: LimitCycle, path: Path) -> Any:
    return view(cycle, "plot")(cycle, path)


def _draw_branch(branch: CycleBranch, label: str, path: Path) -> Any:
    return view(branch, "plot")(branch, path, label)
