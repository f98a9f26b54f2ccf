"""Runs of scenes on disk: .npz always, .h5 with the extra [io], as `results/store.py` keeps other solutions.

Arrays stand under their attribute names, those of contacts under ``contacts/<column>``, the ledger under
``ledger/<column>``, events under ``events/<column>``, pairs under ``pairs/<column>``, times of those of function k of
the user under ``t_events/<k>``; the names of the bodies and the rest are one JSON text ``about``. Shapes are not
stored.
"""

from __future__ import annotations

import functools
import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.checks.arrays import as_instance
from nonsmooth.checks.files import as_path, as_place, refusals
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.records import EVENT_I, EVENT_J, EVENT_KIND, INCONSISTENT, INDETERMINATE, PARADOX_WIDTH
from nonsmooth.results import scene_records as records
from nonsmooth.results.forms import REAL, WHOLE, Form, Rule, require_forms
from nonsmooth.results.hdf5 import read_sealed, seal_of, write_hdf5
from nonsmooth.results.netcdf import put_run, read_run_within
from nonsmooth.results.npz import Archive, read_npz, write_npz
from nonsmooth.results.scene_checkpoint import load_scene_checkpoint
from nonsmooth.results.scene_contacts import ContactColumns
from nonsmooth.results.scene_events import SceneEventKind, SceneEvents
from nonsmooth.results.scene_pairs import ScenePairs
from nonsmooth.results.scene_paradoxes import no_rows
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.results.scene_stats import SceneStats, SpringStats
from nonsmooth.results.seal import require_kind
from nonsmooth.results.store import ENDINGS, HDF5, LEDGER, NETCDF, fill_hdf5
from nonsmooth.views import view

if TYPE_CHECKING:
    from nonsmooth.scenes.scene import Scene

SCENE_SCHEMA, SCENE_KIND = 1, "scene"  # code: of the form of the file
CONTACTS, EVENTS, PAIRS, T_EVENTS = "contacts/", "events/", "pairs/", "t_events/"
PARADOX_ROWS = "paradox_rows"
ARRAYS: dict[str, Rule] = {
    "t": (REAL, ("n_t",)), "residual": (REAL, ("n_t",)), "penetration": (REAL, ("n_t",)),
    "centres": (REAL, ("n_b", "d")),
}  # fmt: skip
PLACES: dict[str, Rule] = {"position": (REAL, ("n_t", "n_b", "d")), "velocity": (REAL, ("n_t", "n_b", "d"))}
COLUMNS: dict[str, Rule] = {
    "offsets": (WHOLE, ("n_offsets",)), "i": (WHOLE, ("m",)), "j": (WHOLE, ("m",)), "point": (REAL, ("m", "d")),
    "normal": (REAL, ("m", "d")), "gap": (REAL, ("m",)), "P": (REAL, ("m", "d")), "mu": (REAL, ("m",)),
}  # fmt: skip
EVENT_COLUMNS: dict[str, Rule] = {
    "t": (REAL, ("n_e",)), "kind": (WHOLE, ("n_e",)), "i": (WHOLE, ("n_e",)), "j": (WHOLE, ("n_e",)),
    "P_N": (REAL, ("n_e",)), "P": (REAL, ("n_e", "d")),
}  # fmt: skip
PAIR_COLUMNS: dict[str, Rule] = {
    "t": (REAL, ("n_p",)), "record": (WHOLE, ("n_p",)), "i": (WHOLE, ("n_p",)), "j": (WHOLE, ("n_p",)),
    "joint": (WHOLE, ("n_p",)), "P": (REAL, ("n_p", "d")), "normal": (REAL, ("n_p",)), "friction": (REAL, ("n_p",)),
    "surface": (REAL, ("n_p",)),
}  # fmt: skip


def save(solution: SceneSolution, path: str | Path) -> Path:
    """Write a run of a scene; the ending of the path, .npz or .h5, names the format."""
    path = as_place("path", path, (*ENDINGS, NETCDF))
    arrays = {name: np.ascontiguousarray(array) for name, array in _arrays_of(solution).items()}
    text = json.dumps({
        "schema": SCENE_SCHEMA, "status": int(solution.status), "message": solution.message, "names": solution.names,
        "stats": asdict(solution.stats), "about": solution.about, "joint_names": solution.joint_names,
    })  # fmt: skip
    if path.suffix == NETCDF:
        add = functools.partial(put_run, SCENE_KIND, {"about": np.array(text), **arrays})
        return view(solution, "netcdf")(solution, path, add)  # type: ignore[no-any-return]
    if path.suffix in HDF5:
        write_hdf5(path, SCENE_KIND, functools.partial(fill_hdf5, text, arrays))
    else:
        write_npz(path, SCENE_KIND, {"about": np.array(text), **arrays}, is_compressed=True)
    return path


def _arrays_of(solution: SceneSolution) -> dict[str, np.ndarray]:
    arrays = {name: getattr(solution, name) for name in ARRAYS}
    if records.BODIES in solution.recorded:
        arrays |= {name: getattr(solution, name) for name in records.OF_BODIES}
    if records.CONTACTS in solution.recorded:
        arrays |= {CONTACTS + name: getattr(solution.all_contacts, name) for name in COLUMNS}
    if records.LEDGER in solution.recorded:
        arrays |= {LEDGER + name: column for name, column in solution.ledger.items()}
    if records.EVENTS in solution.recorded:
        arrays |= {EVENTS + name: getattr(solution.events, name) for name in EVENT_COLUMNS}
    if records.PAIRS in solution.recorded:
        arrays |= {PAIRS + name: getattr(solution.pairs, name) for name in PAIR_COLUMNS}
    if records.CONTACTS in solution.recorded and solution.joint_names:
        arrays[records.JOINT_IMPULSES] = solution.joint_impulses
    if len(solution.paradox_rows):
        arrays[PARADOX_ROWS] = solution.paradox_rows
    return arrays | {f"{T_EVENTS}{k}": times for k, times in enumerate(solution.t_events)}


def load(path: str | Path, scene: Scene | None = None) -> SceneSolution:
    """Read what ``save`` wrote, or a checkpoint; with the scene, which is not stored, its pictures can be drawn."""
    path = as_path("path", path)
    if os.path.isdir(path):
        solution = load_scene_checkpoint(path)
        return solution if scene is None else with_scene(solution, scene)
    with refusals(path, "is not a saved run of a scene"):
        found = _read(path)
        about = found.about()
        if about["schema"] != SCENE_SCHEMA:
            raise InvalidInput(f"{path.name} has schema {about['schema']}; this version reads {SCENE_SCHEMA}")
        require_kind(found.kind, SCENE_KIND)
        solution = _solution(about, found.arrays)
    return solution if scene is None else with_scene(solution, scene)


def with_scene(solution: SceneSolution, scene: Scene) -> SceneSolution:
    """The solution with the scene that it is of."""
    from nonsmooth.scenes.scene import Scene

    as_instance("scene", scene, Scene, "the ns.Scene that was run")
    if [body.name for body in scene.bodies] != solution.names or scene.dim != solution.dim:
        raise InvalidInput("scene is not the one that was run: its bodies have other names, or another order")
    if [joint.name for joint in scene.joints] != solution.joint_names:
        raise InvalidInput("scene is not the one that was run: its joints have other names, or another order")
    return SceneSolution(**{**vars(solution), "scene": scene})  # as it is: what was not recorded has no value


def _read(path: Path) -> Archive:
    if path.suffix == NETCDF:
        return Archive(SCENE_KIND, read_run_within(path, _check))
    return _read_hdf5(path) if path.suffix in HDF5 else read_npz(path, _check)


def _read_hdf5(path: Path) -> Archive:
    require_kind(seal_of(path), SCENE_KIND)
    about, arrays = read_sealed(path, _check)
    return Archive(SCENE_KIND, {"about": np.array(about), **arrays})


def _check(forms: Mapping[str, Form]) -> None:
    """Raise unless these are the arrays of a run of a scene."""
    has_bodies, has_contacts = "position" in forms, CONTACTS + "offsets" in forms
    rules = ARRAYS | (PLACES if has_bodies else {})
    rules |= {CONTACTS + name: rule for name, rule in COLUMNS.items() if has_contacts}
    rules |= {name: (REAL, ("n_t",)) for name in forms if name.startswith(LEDGER)}
    rules |= {records.JOINT_IMPULSES: (REAL, ("n_t", "n_j", "d"))} if records.JOINT_IMPULSES in forms else {}
    rules |= {EVENTS + name: rule for name, rule in EVENT_COLUMNS.items() if EVENTS + "t" in forms}
    rules |= {PAIRS + name: rule for name, rule in PAIR_COLUMNS.items() if PAIRS + "t" in forms}
    rules |= {name: (REAL, (name,)) for name in forms if name.startswith(T_EVENTS)}
    rules |= {PARADOX_ROWS: (REAL, ("n_paradoxes", PARADOX_WIDTH))} if PARADOX_ROWS in forms else {}
    sizes = require_forms(forms, rules)
    if sizes["d"] not in (2, 3) or (has_contacts and sizes["n_offsets"] != sizes["n_t"] + 1):
        raise ValueError("its arrays do not fit one another")
    if has_bodies:
        of_turn: dict[int, tuple[Any, ...]] = {2: (), 3: (4,)}
        of_spin: dict[int, tuple[Any, ...]] = {2: (), 3: (3,)}
        at = sizes["n_t"], sizes["n_b"]
        require_forms(forms, {"turn": (REAL, at + of_turn[sizes["d"]]), "spin": (REAL, at + of_spin[sizes["d"]])})


def stats_of(stored: dict[str, Any]) -> SceneStats:
    """The figures of a stored run."""
    springs = stored["springs"]
    return SceneStats(**stored | {"springs": None if springs is None else SpringStats(*springs)})


def _solution(about: dict[str, Any], arrays: dict[str, np.ndarray]) -> SceneSolution:
    names = [str(name) for name in about["names"]]
    if len(names) != len(arrays["centres"]):
        raise ValueError("its arrays are not those of its bodies")
    ledger = {name.removeprefix(LEDGER): column for name, column in arrays.items() if name.startswith(LEDGER)}
    columns: dict[str, Any] = {name: arrays.get(name) for name in (*ARRAYS, *records.OF_BODIES)}
    columns |= _joints(about, arrays)
    return SceneSolution(
        **columns, ledger=ledger or None, all_contacts=_contacts(arrays, len(names)), events=_events(arrays, names),
        pairs=_pairs(arrays, names, columns["joint_names"]), t_events=_times_of_events(arrays),
        stats=stats_of(about["stats"]), status=Status(about["status"]), message=about["message"], names=names,
        scene=None, about=about["about"], paradox_rows=_paradoxes(arrays, names),
    )  # fmt: skip


def _joints(about: dict[str, Any], arrays: dict[str, np.ndarray]) -> dict[str, Any]:
    """The joints and, where contacts were kept, their impulses."""
    names = [str(name) for name in about["joint_names"]]
    impulses = arrays.get(records.JOINT_IMPULSES)
    if CONTACTS + "offsets" in arrays and impulses is None:
        impulses = np.zeros((len(arrays["t"]), 0, arrays["centres"].shape[1]))
    if impulses is not None and impulses.shape[1] != len(names):
        raise ValueError("its impulses of joints are not those of its joints")
    return {"joint_names": names, records.JOINT_IMPULSES: impulses}


def _contacts(arrays: dict[str, np.ndarray], n_b: int) -> ContactColumns | None:
    """The contacts of all records, where they were kept."""
    if CONTACTS + "offsets" not in arrays:
        return None
    columns = ContactColumns(**{name: arrays[CONTACTS + name] for name in COLUMNS})
    offsets, bodies = columns.offsets, np.concatenate((columns.i, columns.j))
    if offsets[0] != 0 or (np.diff(offsets) < 0).any() or offsets[-1] != len(columns.i):
        raise ValueError("the contacts of its records do not fit its offsets")
    require_bodies("contacts", bodies, n_b)
    return columns


def _events(arrays: dict[str, np.ndarray], names: list[str]) -> SceneEvents | None:
    """The changes at contacts, where they were kept."""
    if EVENTS + "t" not in arrays:
        return None
    columns = {name: arrays[EVENTS + name] for name in EVENT_COLUMNS}
    require_bodies("events", np.concatenate((columns["i"], columns["j"])), len(names))
    if not np.isin(columns["kind"], list(SceneEventKind)).all():
        raise ValueError("its events have kinds that are not there")
    return SceneEvents(**columns, names=names)


def _paradoxes(arrays: dict[str, np.ndarray], names: list[str]) -> np.ndarray:
    """Where rigid contact left open what happens."""
    rows = arrays.get(PARADOX_ROWS, no_rows())
    require_bodies("paradoxes", rows[:, [EVENT_I, EVENT_J]], len(names))
    if not np.isin(rows[:, EVENT_KIND], (INCONSISTENT, INDETERMINATE)).all():
        raise ValueError("its paradoxes have kinds that are not there")
    return rows


def _pairs(arrays: dict[str, np.ndarray], names: list[str], joint_names: list[str]) -> ScenePairs | None:
    """What pairs of bodies exchanged, where it was kept."""
    if PAIRS + "t" not in arrays:
        return None
    columns = {name: arrays[PAIRS + name] for name in PAIR_COLUMNS}
    require_bodies("pairs", np.concatenate((columns["i"], columns["j"])), len(names))
    joint, record = columns["joint"], columns["record"]
    if ((joint < -1) | (joint >= len(joint_names))).any():
        raise ValueError("its pairs name joints that are not there")
    if ((record < 0) | (record >= len(arrays["t"]))).any():
        raise ValueError("its pairs are of records that are not there")
    return ScenePairs(**columns, names=names, joint_names=joint_names)


def _times_of_events(arrays: dict[str, np.ndarray]) -> list[np.ndarray]:
    """The times of the events of each function of the user."""
    count = sum(name.startswith(T_EVENTS) for name in arrays)
    missing = [k for k in range(count) if f"{T_EVENTS}{k}" not in arrays]
    if missing:
        raise ValueError(f"it has no {T_EVENTS}{missing[0]}")
    return [arrays[f"{T_EVENTS}{k}"] for k in range(count)]


def require_bodies(what: str, bodies: np.ndarray, n_b: int) -> None:
    """Raise `ValueError` for numbers of bodies that are not there."""
    if ((bodies < 0) | (bodies >= n_b)).any():
        raise ValueError(f"its {what} name bodies that are not there")
