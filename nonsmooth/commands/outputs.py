"""The options that mean the same in every command: what is printed, drawn, saved, shown on the way, and gone on with.

    --json  --quiet  --plot  --no-plot  --out  --progress  --workers  --resume

A command takes those that have a meaning for it; tests/commands/test_same_words.py holds the table.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.commands.typed_input import whole_number, without_nan

if TYPE_CHECKING:
    import xarray

Options = argparse._ActionsContainer  # a command, or a group of its options
PROGRESS = {"line": True, "json": "json", "none": False}
LINE_PACE = 1.0  # chosen: s between two lines of JSON


def add_printed(command: Options) -> None:
    """--json and --quiet."""
    command.add_argument("--json", action="store_true", help="print one JSON object, and draw only what was asked for")
    command.add_argument("--quiet", action="store_true", help="print neither progress nor result")


def add_drawn(command: Options, where: str) -> None:
    """--plot and --no-plot."""
    command.add_argument("--plot", type=Path, metavar="FILE", help=where)
    command.add_argument("--no-plot", action="store_true", help="draw nothing")


def add_saved(command: Options, what: str) -> None:
    """--out."""
    command.add_argument("--out", type=Path, metavar="FILE", help=what)


def add_progress(command: Options) -> None:
    """--progress."""
    command.add_argument(
        "--progress", choices=[*PROGRESS], default="line",
        help="on stderr: a line on a terminal (default), or a line of JSON each second",
    )  # fmt: skip


def add_workers(command: Options, what: str, default: int | None = 1) -> None:
    """--workers."""
    command.add_argument("--workers", type=whole_number, default=default, metavar="N", help=what)


def add_resumed(command: Options) -> None:
    """--resume, of what keeps a journal."""
    command.add_argument(
        "--resume", "--journal", dest="journal", type=Path, metavar="FILE",
        help="a journal: what is finished is written there as it comes, and not run again",
    )  # fmt: skip


def progress_of(arguments: argparse.Namespace) -> Any:
    """What the library is given: whether and how the progress is shown."""
    return PROGRESS[arguments.progress] and not arguments.quiet and PROGRESS[arguments.progress]


def progress_of_run(arguments: argparse.Namespace) -> Any:
    """The same for one run, which calls a function with the part that is done."""
    shown = progress_of(arguments)
    return PartLines() if shown == "json" else shown


@contextlib.contextmanager
def part_told(what: str, arguments: argparse.Namespace) -> Iterator[None]:
    """The same for a calculation in one piece."""
    from nonsmooth.signals.telling import listening
    from nonsmooth.sweeps.progress import part_shown

    shown = progress_of(arguments)
    with listening(PartLines()) if shown == "json" else part_shown(what, shown):
        yield


class PartLines:
    """Lines of JSON on stderr, a second apart: the part that is done, and the seconds since the beginning."""

    def __init__(self) -> None:
        self.began, self.last = time.perf_counter(), -LINE_PACE

    def __call__(self, part: float) -> None:
        """Take the part that is done."""
        elapsed = time.perf_counter() - self.began
        if elapsed - self.last >= LINE_PACE or part >= 1.0:
            self.last = elapsed
            print(json.dumps({"part": float(part), "elapsed": round(elapsed, 3)}), file=sys.stderr, flush=True)


def tell(arguments: argparse.Namespace, text: Callable[[], Any], results: Callable[[], dict[str, Any]]) -> None:
    """Print the results as JSON, or as text, or nothing."""
    if arguments.json:
        print(json.dumps(without_nan(results()), allow_nan=False))
    elif not arguments.quiet:
        print(text())


def tell_file(arguments: argparse.Namespace, what: str, path: Path | None) -> None:
    """A line for a file that was written."""
    if path and not arguments.json and not arguments.quiet:
        print(f"{what}: {path}")


def save_json(path: Path | None, results: Callable[[], dict[str, Any]]) -> None:
    """Write results as JSON, whole or not at all."""
    if path is None:
        return
    from nonsmooth.checks.files import whole_file

    with whole_file(path) as part:
        part.write_text(json.dumps(without_nan(results()), allow_nan=False) + "\n")


def dataset_as_json(found: xarray.Dataset) -> dict[str, Any]:
    """The values of every axis, with units, and every result over them."""
    return {
        "coordinates": {str(name): plain(column.values) for name, column in found.coords.items()},
        "coordinate_units": {
            str(name): str(column.attrs["units"]) for name, column in found.coords.items() if "units" in column.attrs
        },
        "results": {
            str(name): {"dims": [str(dim) for dim in column.dims], "units": column.attrs.get("units", ""),
                        "values": plain(column.values)}
            for name, column in found.data_vars.items()
        },
    }  # fmt: skip


def plain(values: Any) -> Any:
    """An array as lists; complex numbers as {"re": ..., "im": ...}."""
    import numpy as np

    array = np.asarray(values)
    if array.dtype.kind == "c":
        return {"re": array.real.tolist(), "im": array.imag.tolist()}
    return array.tolist()


def units_of_state(model: Any) -> dict[str, Any]:
    """Units of the time, and of each coordinate and its rate; "" of those that nobody named."""
    from nonsmooth.mechanics.model_system import as_system

    described = as_system(model).described
    q, u = ([unit for _, unit in pairs] for pairs in (described.coordinates, described.rates))
    return {"t": "s", "q": q, "u": u}


def attrs_as_json(attrs: Any) -> dict[str, Any]:
    """Attributes of a Dataset."""
    return {str(name): plain(value) if hasattr(value, "tolist") else value for name, value in attrs.items()}


def event_as_json(event: Any) -> dict[str, Any]:
    """An event with its kinds and modes by name."""
    from dataclasses import asdict
    from enum import IntEnum

    fields = {key: value.name if isinstance(value, IntEnum) else value for key, value in asdict(event).items()}
    return fields | ({"choice": event.choice} if hasattr(event, "choice") else {})
