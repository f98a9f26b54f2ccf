"""Solutions on disk: .npz always, .h5 with the extra [io], .nc with [data]. No pickle; sealed, written to a file.part
and moved into place.

The arrays stand under their attribute names, the ledger under ``ledger/<column>``, the user's events under
``t_events/<k>`` and so on, k the number of the function; the rest is one JSON text ``about``. docs/files.md
"""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.checks.files import as_path, as_place, refusals
from nonsmooth.errors import InvalidInput, ModelNotFoundWarning, Status, warn_caller
from nonsmooth.mechanics.description import names_in_file, of_names
from nonsmooth.mechanics.system import System
from nonsmooth.results.forms import Form, require_forms
from nonsmooth.results.hdf5 import put_array, read_sealed, seal_of, write_hdf5
from nonsmooth.results.motion import Motion, of_records
from nonsmooth.results.netcdf import put_run, read_run_within
from nonsmooth.results.npz import Archive, read_npz, write_npz
from nonsmooth.results.seal import require_kind
from nonsmooth.results.solution import PER_RECORD, Solution
from nonsmooth.results.stats import Stats
from nonsmooth.results.table import SYSTEM, rules_of
from nonsmooth.views import view

SOLUTION_SCHEMA, KIND = 1, "solution"  # code: of the form of the file
HDF5 = (".h5", ".hdf5")
ENDINGS, NETCDF = (".npz", *HDF5), ".nc"
ARRAYS = (*PER_RECORD, "event_rows")
LEDGER = "ledger/"
OF_EVENTS = ("t_events", "q_events", "u_events")
MOTION, STEPS = "motion/", ("t", "h", "q", "u", "B")


def save(solution: Solution, path: str | Path) -> Path:
    """Write a solution; the ending of the path, .npz or .h5, names the format."""
    path = as_place("path", path, (*ENDINGS, NETCDF))
    text, arrays = content_of(solution)
    if path.suffix == NETCDF:
        add = functools.partial(put_run, KIND, {"about": np.array(text), **arrays})
        return view(solution, "netcdf")(solution, path, add)  # type: ignore[no-any-return]
    if path.suffix in HDF5:
        write_hdf5(path, KIND, functools.partial(fill_hdf5, text, arrays))
    else:
        write_npz(path, KIND, {"about": np.array(text), **arrays}, is_compressed=True)
    return path


def content_of(solution: Solution) -> tuple[str, dict[str, np.ndarray]]:
    """The text and the arrays of a file."""
    text = json.dumps({
        "schema": SOLUTION_SCHEMA, "status": int(solution.status), "message": solution.message,
        "stats": vars(solution.stats), "about": solution.about, "names": names_in_file(solution.described),
        "model": solution.named_model if solution.system is None else view(solution, "name model")(solution.system),
        "theta": solution.theta,
    })  # fmt: skip
    return text, _arrays_of(solution)


def _arrays_of(solution: Solution) -> dict[str, np.ndarray]:
    own = solution.__getstate__()
    arrays = {name: own[name] for name in ARRAYS if own[name] is not None}
    if own["find_ledger"] is not None:
        arrays |= {LEDGER + name: column for name, column in solution.ledger.items()}
    for name in OF_EVENTS:
        arrays |= {f"{name}/{k}": found for k, found in enumerate(getattr(solution, name))}
    if solution.find_motion is not None and solution.theta is None:
        arrays |= _arrays_of_motion(solution.motion)
    return arrays


def _arrays_of_motion(motion: Motion) -> dict[str, np.ndarray]:
    """The steps of a motion, and its two ends as (t, q, u)."""
    columns = dict(zip(STEPS, motion.steps, strict=True))
    columns |= {"start": np.concatenate([[motion.start[0]], *motion.start[1:]]),
                "end": np.concatenate([[motion.end[0]], *motion.end[1:]])}  # fmt: skip
    return {MOTION + name: column for name, column in columns.items()}


def _motion(arrays: Mapping[str, np.ndarray]) -> Motion:
    n = arrays[MOTION + "q"].shape[1]
    ends = [(float(row[0]), row[1 : n + 1], row[n + 1 :]) for row in (arrays[MOTION + "start"], arrays[MOTION + "end"])]
    t, h, q, u, B = (arrays[MOTION + name] for name in STEPS)
    return Motion(t, h, q, u, B, ends[0], ends[1])


def fill_hdf5(about: str, arrays: dict[str, np.ndarray], file: Any) -> None:
    """Put the text and the arrays into an open file."""
    file.attrs["about"] = about
    for name, array in arrays.items():
        put_array(file, name, array)


def load(path: str | Path, model: Any = None) -> Solution:
    """Read what ``save`` wrote, or a checkpoint, and find the model that it names."""
    path = as_path("path", path)
    if os.path.isdir(path):
        from nonsmooth.results.checkpoint import load_checkpoint

        return load_checkpoint(path, functools.partial(_system_of, path, model))
    with refusals(path, "is not a saved solution"):
        found = _read(path)
        about = found.about()
        if about["schema"] != SOLUTION_SCHEMA:
            raise InvalidInput(f"{path.name} has schema {about['schema']}; this version reads {SOLUTION_SCHEMA}")
        require_kind(found.kind, KIND)
        solution = _solution(about, found.arrays)
    return _with_model(solution, path, model)


def _read(path: Path) -> Archive:
    if path.suffix == NETCDF:
        return Archive(KIND, read_run_within(path, _check))
    return _read_hdf5(path) if path.suffix in HDF5 else read_npz(path, _check)


def _read_hdf5(path: Path) -> Archive:
    require_kind(seal_of(path), KIND)
    about, arrays = read_sealed(path, _check)
    return Archive(KIND, {"about": np.array(about), **arrays})


def _check(forms: Mapping[str, Form]) -> None:
    """Raise unless these are the arrays of a solution: of what it recorded, all."""
    require_forms(forms, rules_of(SYSTEM, forms))


def _solution(about: dict[str, Any], arrays: dict[str, np.ndarray]) -> Solution:
    ledger = {name.removeprefix(LEDGER): column for name, column in arrays.items() if name.startswith(LEDGER)}
    columns: dict[str, Any] = {name: arrays.get(name) for name in ARRAYS}
    find_ledger: Any = functools.partial(_rows_of, ledger) if ledger else None
    events: dict[str, Any] = {name: _numbered(arrays, name) for name in OF_EVENTS}
    return Solution(
        **columns, **events, find_ledger=find_ledger,
        stats=Stats(**about["stats"]), status=Status(about["status"]), message=about["message"], about=about["about"],
        names=of_names(about["names"]), named_model=about["model"], theta=about["theta"],
        find_motion=_find_motion(about["theta"], bool(about["names"]["velocities"]), arrays),
    )  # fmt: skip


def _find_motion(
    theta: float | None, is_straight: bool, arrays: Mapping[str, np.ndarray]
) -> Callable[[], Motion] | None:
    """What finds the motion between the records, where the file holds it."""
    if theta is not None:
        names = ("t", "q", "u", "mode", "event_rows")
        return functools.partial(of_records, theta, is_straight, *(arrays[name] for name in names))
    return functools.partial(_motion, arrays) if MOTION + "t" in arrays else None


def _with_model(solution: Solution, path: Path, given: Any) -> Solution:
    """The solution with its system, where that is found."""
    own, named = solution.__getstate__(), solution.described
    n_q, n_c = (
        next((own[name].shape[1] for name in columns if own[name] is not None), len(names))
        for columns, names in ((("q", "u"), named.coordinates), (("mode", "g_N", "P_N"), named.contacts))
    )
    system = _system_of(path, given, solution.named_model, n_q, n_c)
    return solution if system is None else solution.changed(system=system)


def _system_of(path: Path, given: Any, named: dict[str, Any] | None, n_q: int, n_c: int) -> System | None:
    """The system of so many coordinates and contacts that was given, or that a file names, where that is found."""
    if named is None and given is None:
        return None
    try:
        system: System = view(Solution, "find model")(named or {"place": ""}, given)
        _require_sizes(system, n_q, n_c)
    except InvalidInput as reason:
        if given is not None:
            raise
        warn_caller(f"{path.name} was read without its model: {reason}", ModelNotFoundWarning)
        return None
    return system


def _require_sizes(system: System, n_q: int, n_c: int) -> None:
    """Raise `InvalidInput` for a system that cannot have made these numbers."""
    if (system.n_q, system.n_c) != (n_q, n_c):
        raise InvalidInput(
            f"{system.name or 'the model'} has {system.n_q} coordinates and {system.n_c} contacts, the run in the file "
            f"has {n_q} and {n_c}"
        )


def _numbered(arrays: dict[str, np.ndarray], name: str) -> list[np.ndarray]:
    """The arrays name/0, name/1, ..."""
    count = sum(entry.startswith(f"{name}/") for entry in arrays)
    return [arrays[f"{name}/{k}"] for k in range(count)]


def _rows_of(ledger: dict[str, np.ndarray], rows: Any) -> dict[str, np.ndarray]:
    return {name: column[rows] for name, column in ledger.items()}
