"""Solutions on disk: .npz always, .h5 with the extra [io]. No pickle; written beside and moved into place.

The arrays stand under their attribute names, the ledger under ``ledger/<column>``, the rest as one JSON text ``about``.
"""

from __future__ import annotations

import functools
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import InvalidInput, Status
from nonsmooth.files import DAMAGE, as_path, as_place, read_npz, whole_file
from nonsmooth.output.hdf5 import require_h5py, write_hdf5

if TYPE_CHECKING:
    from nonsmooth.solution import Solution

SCHEMA = 1
HDF5 = (".h5", ".hdf5")
ENDINGS = (".npz", *HDF5)
ARRAYS = ("t", "q", "u", "g_N", "P_N", "P_F", "mode", "slip", "event_rows")


def save(solution: Solution, path: str | Path) -> Path:
    """Write a solution; the ending of the path, .npz or .h5, names the format."""
    path = as_place("path", path, ENDINGS)
    arrays = {name: getattr(solution, name) for name in ARRAYS}
    arrays |= {f"ledger/{name}": column for name, column in solution.ledger.items()}
    about = {
        "schema": SCHEMA,
        "status": int(solution.status),
        "message": solution.message,
        "stats": asdict(solution.stats),
        "about": solution.about,
    }
    if path.suffix in HDF5:
        write_hdf5(path, functools.partial(_fill, json.dumps(about), arrays))
        return path
    with whole_file(path) as part, part.open("wb") as file:
        np.savez_compressed(file, about=np.array(json.dumps(about)), **arrays)
    return path


def load(path: str | Path) -> Solution:
    """Read what ``save`` wrote, or a checkpoint; the system itself is not stored."""
    from nonsmooth.solution import Solution, Stats

    path = as_path("path", path)
    if path.is_dir():
        from nonsmooth.output.checkpoint import load_checkpoint

        return load_checkpoint(path)
    try:
        about, arrays = _read(path)
        about = json.loads(about)
        if about["schema"] != SCHEMA:
            raise InvalidInput(f"{path.name} has schema {about['schema']}; this version reads {SCHEMA}")
        if any(len(arrays[name]) != len(arrays["t"]) for name in arrays if name != "event_rows"):
            raise InvalidInput(f"{path.name} is damaged: its arrays differ in length")
        ledger = {name.removeprefix("ledger/"): column for name, column in arrays.items() if name.startswith("ledger/")}
        return Solution(
            **{name: arrays[name] for name in ARRAYS}, find_ledger=functools.partial(_rows_of, ledger),
            stats=Stats(**about["stats"]), status=Status(about["status"]), message=about["message"],
            about=about["about"],
        )  # fmt: skip
    except FileNotFoundError:
        raise InvalidInput(f"there is no file {str(path)!r}") from None
    except DAMAGE as error:
        if isinstance(error, InvalidInput):
            raise
        raise InvalidInput(f"{path.name} is not a saved solution, or is damaged: {error}") from error


def _rows_of(ledger: dict[str, np.ndarray], rows: Any) -> dict[str, np.ndarray]:
    return {name: column[rows] for name, column in ledger.items()}


def _fill(about: str, arrays: dict[str, Any], file: Any) -> None:
    file.attrs["about"] = about
    for name, array in arrays.items():
        file[name] = array


def _read(path: Path) -> tuple[str, dict[str, Any]]:
    if path.suffix in HDF5:
        with require_h5py().File(path, "r") as file:
            arrays = {name: file[name][()] for name in ARRAYS}
            arrays |= {f"ledger/{name}": column[()] for name, column in file["ledger"].items()}
            return str(file.attrs["about"]), arrays
    arrays = read_npz(path)
    return str(arrays.pop("about")), arrays
