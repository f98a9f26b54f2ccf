"""Solutions on disk: .npz always, .h5 with the extra [io]. No pickle; sealed, written beside and moved into place.

The arrays stand under their attribute names, the ledger under ``ledger/<column>``, the user's events under
``t_events/<k>`` and so on, k the number of the function; the rest is one JSON text ``about``. docs/files.md
"""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.checks.files import as_path, as_place, refusals
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.records import EVENT_WIDTH
from nonsmooth.results.forms import REAL, Form, Rule, require_forms
from nonsmooth.results.hdf5 import put_array, read_sealed, seal_of, write_hdf5
from nonsmooth.results.npz import Archive, read_npz, write_npz
from nonsmooth.results.seal import require_kind
from nonsmooth.results.solution import PER_RECORD, Solution, Stats
from nonsmooth.views import view

SOLUTION_SCHEMA, KIND = 1, "solution"  # code: of the form of the file
HDF5 = (".h5", ".hdf5")
ENDINGS, NETCDF = (".npz", *HDF5), ".nc"
ARRAYS = PER_RECORD | {"event_rows": (REAL, ("n_events", EVENT_WIDTH))}
FORCES: dict[str, Rule] = {"la": (REAL, ("n_t", "n_c", 2))}
LEDGER = "ledger/"
OF_EVENTS = ("t_events", "q_events", "u_events")


def save(solution: Solution, path: str | Path) -> Path:
    """Write a solution; the ending of the path, .npz or .h5, names the format."""
    path = as_place("path", path, (*ENDINGS, NETCDF))
    if path.suffix == NETCDF:
        return view(solution, "netcdf")(solution, path)  # type: ignore[no-any-return]
    arrays = _arrays_of(solution)
    text = json.dumps({
        "schema": SOLUTION_SCHEMA, "status": int(solution.status), "message": solution.message,
        "stats": asdict(solution.stats), "about": solution.about,
    })  # fmt: skip
    if path.suffix in HDF5:
        write_hdf5(path, KIND, functools.partial(fill_hdf5, text, arrays))
    else:
        write_npz(path, KIND, {"about": np.array(text), **arrays}, is_compressed=True)
    return path


def require_no_netcdf(path: Path) -> None:
    """Raise `InvalidInput` for a netCDF file, which holds what other programs want and not the whole run."""
    if path.suffix == NETCDF:
        raise InvalidInput(f"{path.name} is for other programs, xarray.open_dataset reads it; load reads .npz and .h5")


def _arrays_of(solution: Solution) -> dict[str, np.ndarray]:
    arrays = {name: getattr(solution, name) for name in ARRAYS}
    arrays |= {LEDGER + name: column for name, column in solution.ledger.items()}
    if solution.la is not None:
        arrays["la"] = solution.la
    for name in OF_EVENTS:
        arrays |= {f"{name}/{k}": found for k, found in enumerate(getattr(solution, name))}
    return arrays


def fill_hdf5(about: str, arrays: dict[str, np.ndarray], file: Any) -> None:
    """Put the text and the arrays into an open file."""
    file.attrs["about"] = about
    for name, array in arrays.items():
        put_array(file, name, array)


def load(path: str | Path) -> Solution:
    """Read what ``save`` wrote, or a checkpoint; the system itself is not stored."""
    path = as_path("path", path)
    require_no_netcdf(path)
    if os.path.isdir(path):
        from nonsmooth.results.checkpoint import load_checkpoint

        return load_checkpoint(path)
    with refusals(path, "is not a saved solution"):
        found = _read_hdf5(path) if path.suffix in HDF5 else read_npz(path, _check)
        about = found.about()
        if about["schema"] != SOLUTION_SCHEMA:
            raise InvalidInput(f"{path.name} has schema {about['schema']}; this version reads {SOLUTION_SCHEMA}")
        require_kind(found.kind, KIND)
        return _solution(about, found.arrays)


def _read_hdf5(path: Path) -> Archive:
    require_kind(seal_of(path), KIND)
    about, arrays = read_sealed(path, _check)
    return Archive(KIND, {"about": np.array(about), **arrays})


def _check(forms: Mapping[str, Form]) -> None:
    """Raise unless these are the arrays of a solution."""
    rules = ARRAYS | {name: rule for name, rule in FORCES.items() if name in forms}
    rules |= {name: (REAL, ("n_t",)) for name in forms if name.startswith(LEDGER)}
    require_forms(forms, rules)


def _solution(about: dict[str, Any], arrays: dict[str, np.ndarray]) -> Solution:
    ledger = {name.removeprefix(LEDGER): column for name, column in arrays.items() if name.startswith(LEDGER)}
    columns: dict[str, Any] = {name: arrays[name] for name in ARRAYS}
    events: dict[str, Any] = {name: _numbered(arrays, name) for name in OF_EVENTS}
    return Solution(
        **columns, **events, find_ledger=functools.partial(_rows_of, ledger), la=arrays.get("la"),
        stats=Stats(**about["stats"]), status=Status(about["status"]), message=about["message"], about=about["about"],
    )  # fmt: skip


def _numbered(arrays: dict[str, np.ndarray], name: str) -> list[np.ndarray]:
    """The arrays name/0, name/1, ..."""
    count = sum(entry.startswith(f"{name}/") for entry in arrays)
    return [arrays[f"{name}/{k}"] for k in range(count)]


def _rows_of(ledger: dict[str, np.ndarray], rows: Any) -> dict[str, np.ndarray]:
    return {name: column[rows] for name, column in ledger.items()}
