"""A convergence study: errors and costs over a stiffness, a step or a tolerance, orders, laws, a table, a figure."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import MissingExtra, UnknownName, nearest
from nonsmooth.studies.laws_of_convergence import LEAST_KNOWN, Fit, fit_laws, observed_orders
from nonsmooth.sweeps.task import CellStatus
from nonsmooth.views import view

if TYPE_CHECKING:
    import xarray

KINDS = ("error_q", "error_u", "error_event_t", "error_after_q", "error_after_u", "error_gamma_N")
OF_CONTACTS = ("restitution", "peak_force", "stop_time", "branch", "penetration")  # columns that are no errors
FINISHED, NOT_RUN = int(CellStatus.FINISHED), int(CellStatus.NOT_RUN)  # code: of a cell
NO_LAW = "no law: every one misses some of the errors by more than half of them"
# chosen: difference of two restitutions: a hundred stiffnesses off their limit still differ by less
OTHER_RESTITUTION = 0.05
STANDS_STILL = 0.1  # chosen: order of an error that does not fall
# chosen: errors of the reference: an error below cannot be distinguished from it, and no order is read from it
ABOVE_FLOOR = 10.0


@dataclass(frozen=True)
class Study:
    """What a study found.

    Attributes
    ----------
    of : {"stiffness", "dt", "rtol"}
        What was varied: k [N/m], dt [s] or the tolerance.
    data : xarray.Dataset
        Over ``of`` and "time": "error_q", "error_u" (largest difference of a coordinate [m, rad] and of a velocity
        [m/s, rad/s] from the reference); over ``of`` and "event": "error_event_t", how much later or earlier the run
        enters the same mode [s], and "error_after_q", "error_after_u", the differences at the time "delay" after it,
        counted in each motion from its own event; "floor_q" and so on: errors of the reference itself; over ``of``:
        "steps", "wall_time" [s], "status", "message". The events are those of the reference, at "event_time" [s] into
        "event_mode"; NaN where a run has none to match. `penalty_study` adds what its contacts did.
    title : str
    """

    of: str
    data: xarray.Dataset
    title: str

    @property
    def x(self) -> np.ndarray:
        """The stiffnesses or steps."""
        return self.data[self.of].values

    def errors(self, name: str = "error_u", at: int = -1) -> np.ndarray:
        """Errors (n,) of one kind at one of the times, or of the events; NaN where they are not above the `floor`.

        Raises
        ------
        UnknownName
            For a kind of error that the study has not.
        """
        if name not in self.kinds:
            raise UnknownName(f"there is no error {name!r} in this study; {nearest(name, self.kinds)}")
        errors = row(self.data[name], at)
        if f"floor_{name.removeprefix('error_')}" not in self.data:
            return errors
        return np.where(errors > ABOVE_FLOOR * self.floor(name, at), errors, np.nan)

    @property
    def kinds(self) -> list[str]:
        """The kinds of error that were measured."""
        return [name for name in KINDS if name in self.data]

    def floor(self, name: str = "error_u", at: int = -1) -> np.ndarray:
        """What cannot be distinguished from zero (n,): the error of the reference, or of the integration."""
        kind = name.removeprefix("error_")
        floor = np.full(len(self.x), float(row(self.data[f"floor_{kind}"], at)))
        return np.fmax(floor, row(self.data[f"own_{kind}"], at)) if f"own_{kind}" in self.data else floor

    def orders(self, name: str = "error_u", at: int = -1) -> np.ndarray:
        """Observed orders between neighbours (n - 1,): of 1/k for a stiffness."""
        sign = -1.0 if self.of == "stiffness" else 1.0
        return sign * observed_orders(self.x, self.errors(name, at))

    def fits(self, name: str = "error_u", at: int = -1) -> list[Fit]:
        """Laws fitted to the errors, the closest first, and last a free power; those that miss the errors by more than
        half of them are none."""
        return fit_laws(self.of, self.x, self.errors(name, at))

    def table(self) -> str:
        """The study as text: a line for each value, when the errors were measured, and the laws."""
        kinds = self.kinds
        extra = [name for name in OF_CONTACTS if self._is_known(name)]
        cells = [[self.of, *(f"{name} (order)" for name in kinds), *extra, "steps", "wall [ms]"]]
        for i, value in enumerate(self.x):
            row = [f"{value:.4g}"]
            if int(self.data.status.values[i]) != 1:
                is_left = int(self.data.status.values[i]) == NOT_RUN
                cells.append([*row, "not run" if is_left else str(self.data.message.values[i])])
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
        laws = [f"{name}: {self._laws(name)}" for name in kinds if self._laws(name)]
        return "\n".join([self.title, *lines, self._when(), *self._restitution(), *laws, *self.notes()])

    def _restitution(self) -> list[str]:
        """What springs and rigid contact give back, where that is known."""
        return [self.data.attrs["restitution"]] if "restitution" in self.data.attrs else []

    def notes(self) -> list[str]:
        """What must be known of the study with its numbers, a sentence each."""
        notes = []
        if self.is_interrupted:
            n = int((self.data.status.values == FINISHED).sum())
            notes.append(f"interrupted: {n} of {len(self.x)} runs are finished")
        notes += [
            self.data.attrs[name] for name in ("left_out", "soft", "undamped", "doubt") if self.data.attrs.get(name)
        ]
        is_explained = any(self.data.attrs.get(name) for name in ("undamped", "doubt"))
        other = other_limit(self) if self.of == "stiffness" and not is_explained else ""
        return notes + ([other] if other else [])

    @property
    def is_interrupted(self) -> bool:
        """Whether Ctrl-C ended the study before its end."""
        return bool(self.data.attrs.get("interrupted", 0))

    def _laws(self, name: str) -> str:
        """The laws of one kind of error, or that there is none; nothing where too few errors are known."""
        fits = self.fits(name)
        if fits:
            return "; ".join(map(str, fits))
        return NO_LAW if np.isfinite(self.errors(name)).sum() >= LEAST_KNOWN else ""

    def _is_known(self, name: str) -> bool:
        """Whether a variable says something of any run."""
        if name not in self.data:
            return False
        values = self.data[name].values
        return bool((values != "").any() if values.dtype.kind in "OU" else np.isfinite(values).any())

    def _when(self) -> str:
        """When the errors of the table were measured."""
        words = f"errors at t = {float(self.data.time[-1]):.6g} s"
        if "event_mode" in self.data.coords:
            event = self.data.isel(event=-1)
            words += (
                f"; error_event_t of {event.event_mode.item()!r} at {float(event.event_time):.6g} s, event "
                f"{self.data.sizes['event']}; error_after {float(event.delay):.6g} s after it"
            )
        return words

    def _error_cell(self, name: str, i: int) -> str:
        error = self.errors(name)[i]
        if not np.isfinite(error):
            return "below the floor" if np.isfinite(row(self.data[name])[i]) else "-"
        order = self.orders(name)[i - 1] if i > 0 else np.nan
        return f"{error:.3e}" + (f" ({order:.2f})" if np.isfinite(order) else " (    )")

    def plot(self, path: str | Path | None = None) -> Any:
        """Draw the study (needs the extra [plot]); returns the Matplotlib figure, saved to ``path`` if given."""
        return view(self, "plot")(self, path)

    def _repr_html_(self) -> str:
        return view(self, "html")(self.table())

    def __repr__(self) -> str:
        return f"Study({self.title!r}, {self.of} = {self.x[0]:.3g} .. {self.x[-1]:.3g})"


def other_limit(study: Study) -> str:
    """Why the compliant motions do not near the reference, where that is seen: the springs give back another part of
    the work than the rigid contact, or the distance does not fall."""
    data = study.data
    known = data.restitution.values[np.isfinite(data.restitution.values)] if "restitution" in data else np.zeros(0)
    e_N = data.attrs.get("e_N", np.nan)
    if len(known) and abs(known[-1] - e_N) > OTHER_RESTITUTION:
        is_meant = abs(data.e_springs.values[-1] - e_N) < OTHER_RESTITUTION if "e_springs" in data else False
        why = (
            "with friction the same damper gives back another part"
            if is_meant
            else "restitution='equal' makes them one"
        )
        return (
            f"the limits differ: the springs give back e = {known[-1]:.3g} at the stiffest, the rigid contact e_N = "
            f"{e_N:.3g}; {why}"
        )
    for name in [kind for kind in ("error_q", "error_u") if kind in study.kinds]:
        last = study.orders(name)[-2:]
        if len(last) == 2 and (np.abs(last) < STANDS_STILL).all():
            return f"the limits differ: {name} does not fall with the stiffness; compliant and rigid motion part"
    return ""


def row(column: Any, at: int = -1) -> np.ndarray:
    """A variable at one of its times, or of its events."""
    dims = {"time", "event"} & set(column.dims)
    values: np.ndarray = column.isel(dict.fromkeys(dims, at)).values
    return values


def _cell(value: Any) -> str:
    return value if isinstance(value, str) else f"{float(value):.6g}"


def require_xarray() -> Any:
    """The module xarray, or a sentence on how to get it."""
    try:
        import xarray
    except ImportError:
        raise MissingExtra('studies need xarray; install it with pip install "nonsmooth[map]"') from None
    return xarray
