"""``nonsmooth sweep``: a sweep from the command line.

    nonsmooth sweep painleve-rod --axis mu=0:2:200 --axis th=0.1:1.5:200 --measure paradoxes --workers 2 \\
        --out map.nc --plot map.png
"""

from __future__ import annotations

import argparse
from typing import Any

from nonsmooth.checks.files import FIGURE_ENDINGS
from nonsmooth.commands.outputs import (
    add_drawn,
    add_printed,
    add_progress,
    add_resumed,
    add_saved,
    add_workers,
    dataset_as_json,
    progress_of,
    tell,
)
from nonsmooth.commands.terminal import FAILED, complain, require_one
from nonsmooth.commands.typed_input import (
    AXIS,
    assignments,
    number,
    read_axis,
    require_module,
    require_writable,
)
from nonsmooth.commands.typed_model import MODEL, typed_model
from nonsmooth.errors import INTERRUPTED, InvalidInput

SHOWN_FAILURES = 5  # chosen: failures that are written out
SHOWN_COORDINATES = 6  # chosen: coordinates with a line each


def add_sweep(sweep: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth sweep``."""
    sweep.set_defaults(act=act_sweep)
    sweep.add_argument("model", metavar="MODEL", help=MODEL)
    sweep.add_argument("--axis", nargs="+", action="extend", required=True, metavar="AXIS", dest="axes", help=AXIS)
    sweep.add_argument(
        "--measure", nargs="+", action="extend", default=[], metavar="NAME",
        help="what is kept of each run: final_state (default), amplitude, period, modes, paradoxes, inconsistent, "
        "indeterminate, impacts, mode_changes, residual, penetration, end_time",
    )  # fmt: skip
    for option, what in (("--set", "parameters, e.g. mu=2 l=1/2"), ("--state", "initial state, e.g. th=pi/4 thdot=0")):
        sweep.add_argument(option, nargs="+", action="extend", default=[], metavar="NAME=VALUE", help=what)
    sweep.add_argument("--t-end", type=number, metavar="T", help="end [s]; the model's own by default")
    sweep.add_argument("--dt", type=number, help="step [s]; the model's own by default")
    sweep.add_argument("--theta", type=number, default=0.5, help="weight of the new velocity, 0.5 (default) to 1")
    sweep.add_argument("--selection", default="compliant-limit", metavar="RULE", help="as for run")
    sweep.add_argument("--window", type=number, default=0.5, metavar="PART",
                       help="amplitude and period from this part of the run on; 0.5 by default")  # fmt: skip
    sweep.add_argument("--settle", type=number, default=0.01, metavar="PART",
                       help="what amplitude and period may change by within the window; 0.01 by default")  # fmt: skip
    sweep.add_argument("--settle-by", type=number, metavar="T",
                       help="make runs that have not settled twice as long, and again, until this end [s]")  # fmt: skip
    add_workers(sweep, "threads; 1 by default")
    sweep.add_argument("--scheduler", metavar="ADDRESS", help="a Dask scheduler, e.g. tcp://host:8786")
    add_resumed(sweep)
    sweep.add_argument("--anew", action="store_true", help="begin the journal again instead of resuming")
    sweep.add_argument("--fail-fast", action="store_true", help="stop at the first cell that fails")
    add_progress(sweep)
    add_saved(sweep, "save the result (.npz or .nc)")
    add_drawn(sweep, "draw the first measure that is a number, over one or two axes; nothing by default")
    add_printed(sweep)


def act_sweep(arguments: argparse.Namespace) -> int:
    """``nonsmooth sweep``."""
    from nonsmooth.drawing.sweep_plot import plot_sweep
    from nonsmooth.sweeps.sweep import sweep
    from nonsmooth.sweeps.sweep_files import ENDINGS

    axes = [read_axis(text) for text in arguments.axes]
    require_one(arguments)
    require_writable(arguments.out, ENDINGS)
    require_writable(arguments.plot, FIGURE_ENDINGS)
    if arguments.plot:
        require_module("matplotlib", "plot", "figures")
        if not 1 <= sum(len(axis.values) > 1 for axis in axes) <= 2:
            raise InvalidInput("--plot needs one or two axes of more than one value; leave it out, or an axis")
    task = make_task(arguments)
    drawn = next((name for name, variable in task.variables.items() if not variable.is_text), None)
    if arguments.plot and drawn is None:
        raise InvalidInput(
            f"--plot needs a measure that is a number; {', '.join(task.variables)} is a text: add another"
        )
    found = sweep(
        task, axes, workers=arguments.workers, scheduler=arguments.scheduler, journal=arguments.journal,
        resume=not arguments.anew, out=arguments.out, progress=progress_of(arguments), fail_fast=arguments.fail_fast,
    )  # fmt: skip
    is_cut = bool(found.attrs["interrupted"])
    if arguments.plot and not is_cut:
        plot_sweep(found, arguments.plot, drawn)
    tell(arguments, lambda: summary(found, arguments), lambda: as_json(found))
    if is_cut:
        complain(interruption(found, arguments))
        return INTERRUPTED
    return FAILED if found.attrs["cells_failed"] == found.attrs["cells"] else 0


def make_task(arguments: argparse.Namespace) -> Any:
    """Runs of the model with the options of the command line."""
    from nonsmooth.integrators.moreau_jean.options import MoreauJean
    from nonsmooth.mechanics.start import own_time
    from nonsmooth.sweeps.run_task import RunTask

    model = typed_model(arguments)
    dt = own_time(model, "dt") if arguments.dt is None else arguments.dt
    t_end = own_time(model, "t_end") if arguments.t_end is None else arguments.t_end
    if dt is None or t_end is None:
        raise InvalidInput(f"the model {arguments.model} has no t_end and dt of its own; give --t-end and --dt")
    return RunTask(
        model, arguments.measure or ["final_state"], t_span=(0.0, t_end), integrator=MoreauJean(dt, arguments.theta),
        state=assignments("--state", arguments.state), selection=arguments.selection, window=arguments.window,
        settle=arguments.settle, settle_by=arguments.settle_by,
    )  # fmt: skip


def interruption(found: Any, arguments: argparse.Namespace) -> str:
    """What is left of a sweep after Ctrl-C, and how it goes on."""
    from nonsmooth.sweeps.task import CellStatus

    n = int((found.status != CellStatus.NOT_RUN).sum())
    more = "; the same command goes on with the rest" if arguments.journal and not arguments.anew else ""
    return f"interrupted: {n} of {found.attrs['cells']} cells are finished{more}; nothing is drawn"


def summary(found: Any, arguments: argparse.Namespace) -> str:
    """The sweep in a few lines: cells, ranges, failures, files."""
    import numpy as np

    attrs, lines = found.attrs, []
    shape = " x ".join(str(found.sizes[dim]) for dim in found.status.dims)
    resumed = f", {attrs['cells_from_journal']} of them from the journal" if attrs["cells_from_journal"] else ""
    lines.append(f"{attrs['cells']} cells ({shape}){resumed}")
    for name, column in found.data_vars.items():
        values = column.values
        if name not in ("status", "message", "settled") and values.dtype.kind == "f" and np.isfinite(values).any():
            lines += [range_of(*part) for part in parts_of(column)]
        elif name == "modes":
            lines.append(f"{name:20} {len(np.unique(values.astype(str)))} different sequences")
    lines += unsettled(found, arguments) + failures(found)
    figure = None if attrs["interrupted"] else arguments.plot
    lines += [f"{what}: {path}" for what, path in (("result", arguments.out), ("figure", figure)) if path]
    return "\n".join(lines)


def parts_of(column: Any) -> list[tuple[str, str, Any]]:
    """Name, unit and values of a result; of each coordinate for itself, whose units differ, where there are a few."""
    from nonsmooth.sweeps.task import OF_COORDINATE

    name, unit = str(column.name), column.attrs.get("units", "")
    if "coordinate" not in column.dims or not 1 < column.sizes["coordinate"] <= SHOWN_COORDINATES:
        return [(name, unit.replace(OF_COORDINATE, ""), column.values)]
    each = [column.isel(coordinate=k) for k in range(column.sizes["coordinate"])]
    units = [unit.replace(OF_COORDINATE, str(part.coordinate_unit.item())) for part in each]
    return [(f"{name}[{part.coordinate.item()}]", own, part.values) for part, own in zip(each, units, strict=True)]


def range_of(name: str, unit: str, values: Any) -> str:
    """The least and the greatest value in a line."""
    import numpy as np

    is_known = np.isfinite(values).any()
    ends = f"{np.nanmin(values):.6g} to {np.nanmax(values):.6g} {unit}".rstrip() if is_known else "unknown"
    return f"{name:20} {ends}"


def unsettled(found: Any, arguments: argparse.Namespace) -> list[str]:
    """How many motions have settled, and the first of those that have not with their axis values."""
    import numpy as np

    if "settled" not in found:
        return []
    column = found.settled.values
    cells = np.argwhere(column == 0.0)
    lines = [f"{'settled':20} {int((column == 1.0).sum())} of {column.size} cells, to {arguments.settle:g}"]
    for cell in cells[:SHOWN_FAILURES]:
        lines.append(f"  not settled: {axis_values(found, cell.tolist())}")
    return lines + ([f"  and {len(cells) - SHOWN_FAILURES} more"] if len(cells) > SHOWN_FAILURES else [])


def axis_values(found: Any, cell: list[int]) -> str:
    """Where a cell lies on the axes, or in the rows of a table."""
    place = found.isel(dict(zip(found.status.dims, cell, strict=True)))
    units = {dim: found[dim].attrs.get("units", "-") if dim in found.coords else "-" for dim in found.status.dims}
    return ", ".join(f"{dim} = {place[dim].item():.6g} {units[dim].strip('-')}".rstrip() for dim in found.status.dims)


def failures(found: Any) -> list[str]:
    """The cells that failed: how many, and the first of them with their axis values."""
    import numpy as np

    from nonsmooth.sweeps.task import CellStatus

    status = found.status.values
    cells = np.argwhere((status != CellStatus.FINISHED) & (status != CellStatus.NOT_RUN))
    if not len(cells):
        return []
    lines = [f"{len(cells)} cells failed:"]
    for cell in cells[:SHOWN_FAILURES]:
        place = found.isel(dict(zip(found.status.dims, cell.tolist(), strict=True)))
        lines.append(
            f"  {axis_values(found, cell.tolist())}: {CellStatus(place.status.item()).name}, {place.message.item()}"
        )
    return lines + ([f"  and {len(cells) - SHOWN_FAILURES} more"] if len(cells) > SHOWN_FAILURES else [])


def as_json(found: Any) -> dict[str, Any]:
    """What a script wants to know of a sweep: counts, axes, and every result over them."""
    from nonsmooth.sweeps.task import CellStatus

    status = found.status.values
    counts = {member.name: int((status == member).sum()) for member in CellStatus if (status == member).any()}
    return {
        **found.attrs, "status": counts, "axes": {str(dim): found.sizes[dim] for dim in found.status.dims},
        **dataset_as_json(found),
    }  # fmt: skip
