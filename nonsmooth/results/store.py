"""Results on disk: .npz always, .h5 with the extra [io], .nc with [data]. No pickle; sealed, written to a file.part
and moved into place.

The arrays stand under the names of their table (table.py); the rest is one JSON text ``about``. docs/files.md
"""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from nonsmooth.checks.arrays import as_instance
from nonsmooth.checks.files import as_path, as_place, refusals
from nonsmooth.errors import InvalidInput, ModelNotFoundWarning, Status, warn_caller
from nonsmooth.integrators.records import EVENT_I, EVENT_J, EVENT_KIND, INCONSISTENT, INDETERMINATE
from nonsmooth.mechanics.description import names_in_file, of_names
from nonsmooth.mechanics.system import System
from nonsmooth.results.checkpoint import load_checkpoint, load_scene_checkpoint
from nonsmooth.results.events import SceneEventKind
from nonsmooth.results.forms import Form, require_forms
from nonsmooth.results.hdf5 import put_array, read_sealed, seal_of, write_hdf5
from nonsmooth.results.motion import Motion, of_records
from nonsmooth.results.netcdf import put_run, read_run_within
from nonsmooth.results.npz import Archive, read_npz, write_npz
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.results.seal import require_kind
from nonsmooth.results.solution import PER_RECORD, Solution
from nonsmooth.results.stats import Stats, stats_of_scene
from nonsmooth.results.table import SCENE, SYSTEM, Table, numbered, rules_of, under
from nonsmooth.views import view

if TYPE_CHECKING:
    from nonsmooth.scenes.scene import Scene

SCHEMA = 1  # code: of the form of the file
KIND, SCENE_KIND = "solution", "scene"
HDF5 = (".h5", ".hdf5")
ENDINGS, NETCDF = (".npz", *HDF5), ".nc"
ARRAYS = (*PER_RECORD, "event_rows")
LEDGER, MOTION = "ledger/", "motion/"
OF_EVENTS = ("t_events", "q_events", "u_events")
STEPS = ("t", "h", "q", "u", "B", "Q")  # defined: columns of a motion; the last one where q' is not u
Result = TypeVar("Result", Solution, SceneSolution)


def save(result: Solution | SceneSolution, path: str | Path) -> Path:
    """Write a result; the ending of the path, .npz, .h5 or .nc, names the format."""
    path = as_place("path", path, (*ENDINGS, NETCDF))
    kind, about, found = content_of_scene(result) if isinstance(result, SceneSolution) else content_of(result)
    told = {"schema": SCHEMA, "status": int(result.status), "message": result.message, "about": result.about}
    text, arrays = json.dumps(told | about), {name: np.ascontiguousarray(array) for name, array in found.items()}
    if path.suffix == NETCDF:
        add = functools.partial(put_run, kind, {"about": np.array(text), **arrays})
        return view(result, "netcdf")(result, path, add)  # type: ignore[no-any-return]
    if path.suffix in HDF5:
        write_hdf5(path, kind, functools.partial(fill_hdf5, text, arrays))
    else:
        write_npz(path, kind, {"about": np.array(text), **arrays}, is_compressed=True)
    return path


def content_of(solution: Solution) -> tuple[str, dict[str, Any], dict[str, np.ndarray]]:
    """What a file has of the run of a system: its kind, what stands in its text, its arrays."""
    about = {
        "stats": vars(solution.stats), "names": names_in_file(solution.described), "theta": solution.theta,
        "model": solution.named_model if solution.system is None else view(solution, "name model")(solution.system),
    }  # fmt: skip
    return KIND, about, _arrays_of(solution)


def content_of_scene(solution: SceneSolution) -> tuple[str, dict[str, Any], dict[str, np.ndarray]]:
    """The same of the run of a scene."""
    about = {"stats": asdict(solution.stats), "names": solution.names, "joint_names": solution.joint_names}
    return SCENE_KIND, about, solution.columns


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
    columns = dict(zip(STEPS, motion.steps, strict=False))
    columns |= {"start": np.concatenate([[motion.start[0]], *motion.start[1:]]),
                "end": np.concatenate([[motion.end[0]], *motion.end[1:]])}  # fmt: skip
    return {MOTION + name: column for name, column in columns.items()}


def _motion(arrays: Mapping[str, np.ndarray]) -> Motion:
    n = arrays[MOTION + "q"].shape[1]
    ends = [(float(row[0]), row[1 : n + 1], row[n + 1 :]) for row in (arrays[MOTION + "start"], arrays[MOTION + "end"])]
    t, h, q, u, B = (arrays[MOTION + name] for name in STEPS[:-1])
    return Motion(t, h, q, u, B, ends[0], ends[1], arrays.get(MOTION + STEPS[-1]))


def fill_hdf5(about: str, arrays: dict[str, np.ndarray], file: Any) -> None:
    """Put the text and the arrays into an open file."""
    file.attrs["about"] = about
    for name, array in arrays.items():
        put_array(file, name, array)


def load(path: str | Path, model: Any = None) -> Solution:
    """Read what ``save`` wrote, or a checkpoint, and find the model that it names."""
    path = as_path("path", path)
    if os.path.isdir(path):
        return load_checkpoint(path, functools.partial(_system_of, path, model))
    return _with_model(_read(path, KIND, "is not a saved solution", lambda forms: SYSTEM, _solution), path, model)


def load_scene(path: str | Path, scene: Scene | None = None) -> SceneSolution:
    """The same of a run of a scene; with the scene, which is not stored, its pictures can be drawn."""
    path = as_path("path", path)
    if os.path.isdir(path):
        solution = load_scene_checkpoint(path)
    else:
        solution = _read(path, SCENE_KIND, "is not a saved run of a scene", _table_of_scene, _scene_solution)
    return solution if scene is None else with_scene(solution, scene)


def _read(
    path: Path, kind: str, what: str, table_of: Callable[[Mapping[str, Form]], Table],
    result_of: Callable[[dict[str, Any], dict[str, np.ndarray]], Result],
) -> Result:  # fmt: skip
    """A result of one kind; `InvalidInput` for a file that is none, or damaged."""

    def check(forms: Mapping[str, Form]) -> None:
        require_forms(forms, rules_of(table_of(forms), forms))

    with refusals(path, what):
        if path.suffix == NETCDF:
            found = Archive(kind, read_run_within(path, check))
        elif path.suffix in HDF5:
            require_kind(seal_of(path), kind)
            text, arrays = read_sealed(path, check)
            found = Archive(kind, {"about": np.array(text), **arrays})
        else:
            found = read_npz(path, check)
        about = found.about()
        if about["schema"] != SCHEMA:
            raise InvalidInput(f"{path.name} has schema {about['schema']}; this version reads {SCHEMA}")
        require_kind(found.kind, kind)
        return result_of(about, found.arrays)


def _solution(about: dict[str, Any], arrays: dict[str, np.ndarray]) -> Solution:
    ledger = under(arrays, "ledger")
    columns: dict[str, Any] = {name: arrays.get(name) for name in ARRAYS}
    find_ledger: Any = functools.partial(_rows_of, ledger) if ledger else None
    events: dict[str, Any] = {name: numbered(arrays, name) for name in OF_EVENTS}
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


def _rows_of(ledger: dict[str, np.ndarray], rows: Any) -> dict[str, np.ndarray]:
    return {name: column[rows] for name, column in ledger.items()}


def _table_of_scene(forms: Mapping[str, Form]) -> Table:
    """That of the plane or of space, as the centres tell."""
    return SCENE[2] if "centres" in forms and forms["centres"].shape[1:] == (2,) else SCENE[3]


def _scene_solution(about: dict[str, Any], columns: dict[str, np.ndarray]) -> SceneSolution:
    solution = SceneSolution(
        columns, stats=stats_of_scene(about["stats"]),
        status=Status(about["status"]), message=about["message"], names=about["names"], scene=None,
        about=about["about"], joint_names=about["joint_names"],
    )  # fmt: skip
    require_places(solution)
    return solution


def require_places(solution: SceneSolution) -> None:
    """Raise `ValueError` for numbers of bodies, joints, records, contacts or kinds that are not there."""
    columns, n_b, n_j = solution.columns, len(solution.names), len(solution.joint_names)
    if (len(columns["centres"]), columns.get("joint_impulses", np.empty((1, n_j))).shape[1]) != (n_b, n_j):
        raise ValueError("its arrays are not those of its bodies and joints")
    ends = {"pairs/joint": (-1, n_j), "pairs/record": (0, len(columns["t"])), "events/kind": (0, len(SceneEventKind))}
    ends |= {name: (0, n_b) for name in columns if name.endswith(("/i", "/j"))}
    paradoxes = columns["paradox_rows"]
    places = [(name, columns[name], *bounds) for name, bounds in ends.items() if name in columns]
    places += [("bodies of paradoxes", paradoxes[:, [EVENT_I, EVENT_J]], 0, n_b),
               ("kinds of paradoxes", paradoxes[:, EVENT_KIND], INCONSISTENT, INDETERMINATE + 1)]  # fmt: skip
    for name, column, low, end in places:
        if ((column < low) | (column >= end)).any():
            raise ValueError(f"its {name} must lie in {low} ... {end - 1}")
    if "contacts/offsets" in columns:
        offsets, m = columns["contacts/offsets"], len(columns["contacts/i"])
        if offsets[0] != 0 or (np.diff(offsets) < 0).any() or offsets[-1] != m:
            raise ValueError("the contacts of its records do not fit its offsets")


def with_scene(solution: SceneSolution, scene: Scene) -> SceneSolution:
    """The solution with the scene that it is of."""
    from nonsmooth.scenes.scene import Scene

    as_instance("scene", scene, Scene, "the ns.Scene that was run")
    if [body.name for body in scene.bodies] != solution.names or scene.dim != solution.dim:
        raise InvalidInput("scene is not the one that was run: its bodies have other names, or another order")
    if [joint.name for joint in scene.joints] != solution.joint_names:
        raise InvalidInput("scene is not the one that was run: its joints have other names, or another order")
    return replace(solution, scene=scene)
