"""A convergence study: errors and costs over a stiffness or a step, orders, the law they follow, a table, a figure."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import MissingExtra, UnknownName, nearest
from nonsmooth.studies.laws_of_convergence import Fit, fit_laws, observed_orders

if TYPE_CHECKING:
    import xarray

ABOVE_FLOOR = 10.0  # errors of the reference: an error below is not told from it, and no order is read from it


@dataclass(frozen=True)
class Study:
    """What a study found.

    Attributes
    ----------
    of : {"stiffness", "dt"}
        What was varied: k [N/m] or dt [s].
    data : xarray.Dataset
        Over ``of`` and "time": "error_q", "error_u" (largest difference of a coordinate [m, rad] and of a velocity
        [m/s, rad/s] from the reference), "floor_q", "floor_u" (error of the reference itself, over "time"); over
        ``of``: "steps", "wall_time" [s], "status", "message". `penalty_study` adds what its contacts did.
    title : str
    """

    of: str
    data: xarray.Dataset
    title: str

    @property
    def x(self) -> np.ndarray:
        """The stiffnesses or steps."""
        return self.data[self.of].values

    def errors(self, name: str = "error_u", time: int = -1) -> np.ndarray:
        """Errors (n,) of one kind at one of the times; NaN where they are not told from the `floor`.

        Raises
        ------
        UnknownName
            For a kind of error that the study has not.
        """
        kinds = [str(key) for key in self.data if str(key).startswith("error_")]
        if name not in kinds:
            raise UnknownName(f"there is no error {name!r} in this study; {nearest(name, kinds)}")
        column = self.data[name]
        if "time" not in column.dims:
            return column.values
        errors = column.isel(time=time).values
        return np.where(errors > ABOVE_FLOOR * self.floor(name, time), errors, np.nan)

    def floor(self, name: str = "error_u", time: int = -1) -> np.ndarray:
        """What cannot be told from zero (n,): the error of the reference, or of the integration."""
        kind = name.removeprefix("error_")
        floor = np.full(len(self.x), float(self.data[f"floor_{kind}"].isel(time=time)))
        return np.fmax(floor, self.data[f"own_{kind}"].isel(time=time).values) if f"own_{kind}" in self.data else floor

    def orders(self, name: str = "error_u", time: int = -1) -> np.ndarray:
        """Observed orders between neighbours (n - 1,): of 1/k for a stiffness."""
        sign = -1.0 if self.of == "stiffness" else 1.0
        return sign * observed_orders(self.x, self.errors(name, time))

    def fits(self, name: str = "error_u", time: int = -1) -> list[Fit]:
        """Laws fitted to the errors, the closest first, and last a free power."""
        return fit_laws(self.of, self.x, self.errors(name, time))

    def table(self) -> str:
        """The study as text: a line for each value, then the laws."""
        kinds = [str(key) for key in self.data if str(key).startswith("error_")]
        extra = [name for name in ("restitution", "peak_force", "stop_time", "branch") if name in self.data]
        cells = [[self.of, *(f"{name} (order)" for name in kinds), *extra, "steps", "wall [ms]"]]
        for i, value in enumerate(self.x):
            row = [f"{value:.4g}"]
            if int(self.data.status.values[i]) != 1:
                cells.append([*row, str(self.data.message.values[i])])
                continue
            row += [self._error_cell(name, i) for name in kinds]
            row += [_cell(self.data[name].values[i]) for name in extra]
            cells.append([*row, str(int(self.data.steps.values[i])), f"{1e3 * self.data.wall_time.values[i]:.3g}"])
        n = len(cells[0])
        widths = [max(len(row[j]) for row in cells if len(row) == n) for j in range(n)]
        lines = [
            "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=False)) if len(row) == n
            else f"{row[0].rjust(widths[0])}  {row[1]}" for row in cells
        ]  # fmt: skip
        laws = [f"{name}: {'; '.join(map(str, self.fits(name)))}" for name in kinds if self.fits(name)]
        return "\n".join([self.title, *lines, *laws])

    def _error_cell(self, name: str, i: int) -> str:
        error = self.errors(name)[i]
        if not np.isfinite(error):
            return "below the floor" if np.isfinite(_last(self.data[name])[i]) else "-"
        order = self.orders(name)[i - 1] if i > 0 else np.nan
        return f"{error:.3e}" + (f" ({order:.2f})" if np.isfinite(order) else " (    )")

    def plot(self, path: str | Path | None = None) -> Any:
        """Draw the study (needs the extra [plot]); returns the Matplotlib figure, saved to ``path`` if given."""
        from nonsmooth.output.study_plots import plot_study

        return plot_study(self, path)

    def __repr__(self) -> str:
        return f"Study({self.title!r}, {self.of} = {self.x[0]:.3g} .. {self.x[-1]:.3g})"


def _last(column: Any) -> np.ndarray:
    return column.isel(time=-1).values if "time" in column.dims else column.values


def _cell(value: Any) -> str:
    return value if isinstance(value, str) else f"{float(value):.6g}"


def require_xarray() -> Any:
    """The module xarray, or a sentence on how to get it."""
    try:
        import xarray
    except ImportError:
        raise MissingExtra('studies need xarray; install it with pip install "nonsmooth[map]"') from None
    return xarray
