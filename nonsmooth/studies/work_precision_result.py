"""What a study of run time against error found: curves, times at equal error, a table, a figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_positive
from nonsmooth.errors import UnknownName, nearest
from nonsmooth.studies.study import ABOVE_FLOOR, Study, require_xarray
from nonsmooth.views import view

COSTS = {"wall_time": "wall time [ms]", "evaluations": "force evaluations"}
NOT_TOLD = "; stopped at"  # of a message: the state
TARGETS = (1e-4, 1e-6, 1e-9)  # chosen: errors at which the table compares


@dataclass(frozen=True, repr=False)
class WorkPrecision(Study):
    """Run time against error.

    Attributes
    ----------
    data : xarray.Dataset
        Over "scene", "integrator" and "level": "setting" (step [s] or tolerance), "error", "wall_time" [s],
        "evaluations", "steps", "message" of a run that failed; over "scene": "disagreement" of the two methods that
        gave the reference, 0 where it was given.
    """

    @property
    def scenes(self) -> list[str]:
        """Names of the motions."""
        return [str(name) for name in self.data.scene.values]

    @property
    def methods(self) -> list[str]:
        """Labels of the methods."""
        return [str(name) for name in self.data.integrator.values]

    def curve(self, scene: str, method: str, cost: str = "wall_time") -> tuple[np.ndarray, np.ndarray]:
        """Errors and costs (n,) of the runs that reached their end, in the order of their settings.

        Raises
        ------
        UnknownName
            For a scene, method or cost that the study has not.
        """
        for name, known in ((scene, self.scenes), (method, self.methods), (cost, list(COSTS))):
            if name not in known:
                raise UnknownName(f"there is no {name!r} in this study; {nearest(name, known)}")
        rows = self.data.sel(scene=scene, integrator=method)
        ran = np.isfinite(rows.error.values)
        return rows.error.values[ran], rows[cost].values[ran]

    def floor_of(self, scene: str) -> float:
        """Errors below cannot be distinguished from that of the reference: ten times the disagreement of its two
        methods."""
        return ABOVE_FLOOR * float(self.data.disagreement.sel(scene=scene))

    def best_error(self, scene: str, method: str) -> float:
        """Smallest error that was reached; NaN where the method did not run."""
        errors, _ = self.curve(scene, method)
        return float(errors.min()) if len(errors) else np.nan

    def cost_at(self, error: float, scene: str, method: str, cost: str = "wall_time") -> float:
        """What an error costs: log-log between the runs, taken from coarse to fine, where it is reached for good.

        NaN where no run reaches it. An error larger than that of the cheapest run costs what this run does, and one
        below the floor of the reference is not known.
        """
        error = as_positive("error", error)
        errors, costs = self.curve(scene, method, cost)
        order = np.argsort(costs, kind="stable")
        errors, costs = errors[order], costs[order]
        misses = np.flatnonzero(errors > error)
        if len(errors) == 0 or error < self.floor_of(scene) or (len(misses) and misses[-1] == len(errors) - 1):
            return np.nan
        if len(misses) == 0:
            return float(costs[0])
        k = int(misses[-1])  # every dearer run meets it
        x = np.log(np.maximum(errors[[k + 1, k]], np.finfo(float).tiny))
        return float(np.exp(np.interp(np.log(error), x, np.log(costs[[k + 1, k]]))))

    def dearest(self, scene: str, method: str, cost: str = "wall_time") -> float:
        """Cost of the dearest run: more than this takes an error that `cost_at` does not know."""
        _, costs = self.curve(scene, method, cost)
        return float(costs.max()) if len(costs) else np.nan

    def table(self) -> str:
        """For each scene: the best error of each method, and the wall time and evaluations at equal error."""
        head = ["method", "best error", *(f"ms at {target:g}" for target in TARGETS)]
        head += [f"evaluations at {target:g}" for target in TARGETS]
        lines = [self.title]
        for scene in self.scenes:
            lines += ["", f"{scene}: {self.reference_of(scene)}"]
            cells = [head] + [self._row(scene, method) for method in self.methods if self._ran(scene, method)]
            widths = [max(len(row[j]) for row in cells) for j in range(len(head))]
            lines += ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in cells]
            lines += self.failures(scene)
        return "\n".join(lines)

    def reference_of(self, scene: str) -> str:
        """How far the reference can be trusted."""
        disagreement = float(self.data.disagreement.sel(scene=scene))
        return f"the two references differ by {disagreement:.1e}" if disagreement > 0 else "reference given"

    def failures(self, scene: str) -> list[str]:
        """A line for each run that did not reach its end."""
        rows = self.data.sel(scene=scene)
        return [
            f"  {method} at {float(row.setting):.2g}: {row.message.item().split(NOT_TOLD)[0]}"
            for method in self.methods
            for row in (rows.sel(integrator=method).isel(level=k) for k in range(len(self.data.level)))
            if row.message.item()
        ]

    def _ran(self, scene: str, method: str) -> bool:
        return len(self.curve(scene, method)[0]) > 0

    def _row(self, scene: str, method: str) -> list[str]:
        times = [1e3 * self.cost_at(target, scene, method) for target in TARGETS]
        counts = [self.cost_at(target, scene, method, "evaluations") for target in TARGETS]
        best, floor = self.best_error(scene, method), self.floor_of(scene)
        told = f"{best:.1e}" if best > floor else f"< {floor:.0e}"
        return [method, told, *map(number, times), *map(number, counts)]

    def plot(self, path: str | Path | None = None, cost: str | None = None) -> Any:
        """Draw error over ``"wall_time"`` or ``"evaluations"`` of the forces, a panel a scene (needs the extra [plot]);
        saved to ``path`` if given. Without a ``cost`` both of one scene, wall times of several."""
        return view(self, "plot")(self, path, cost)

    def __repr__(self) -> str:
        return f"WorkPrecision({len(self.scenes)} scenes, {', '.join(self.methods)})"


def joined(studies: Sequence[WorkPrecision]) -> WorkPrecision:
    """Studies of the same methods on different scenes as one."""
    data = require_xarray().concat(
        [study.data for study in studies], "scene", join="outer", fill_value={"message": ""}, data_vars="minimal"
    )
    return WorkPrecision("level", data, studies[0].title)


def number(value: float) -> str:
    """A cost with three digits, a dash where it is not known."""
    return f"{value:.3g}" if np.isfinite(value) else "-"
