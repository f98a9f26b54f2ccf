"""What a penalty study varies, the springs at one stiffness, and the rigid runs for comparison."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from nonsmooth.checks.arrays import result_of
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.studies.comparison import ComparisonTask, run_comparison

STIFFNESSES = tuple(10.0**n for n in range(4, 13))  # chosen: N/m


def penalty_at(
    penalty: Penalty | None, k: float, damping: float | Callable[[float], float] | None, damping_ratio: float | None
) -> Penalty:
    """The integrator at one stiffness."""
    c = result_of("damping", damping, k) if callable(damping) else damping
    if penalty is None:
        return Penalty(k, damping=c, damping_ratio=damping_ratio)
    return replace(penalty, stiffness=k, damping=c, damping_ratio=damping_ratio)


def beside_columns(task: ComparisonTask, progress: Any) -> dict[str, Any]:
    """Errors at the last time and costs of the rigid runs."""
    runs = run_comparison(task, "", progress=progress)
    if runs.attrs["interrupted"]:
        raise KeyboardInterrupt
    names = [name for name in ("error_q", "error_u", "wall_time", "steps") if name in runs]
    columns = {name: runs[name].isel(time=-1) if "time" in runs[name].dims else runs[name] for name in names}
    return {f"beside_{name}": ("beside", column.values) for name, column in columns.items()}
