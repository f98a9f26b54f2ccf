"""The checkpoint of a run of a scene, in the folder and with the promises of checkpoint.py.

    records.npy    one row a record: t, residual, penetration, and what was asked for of bodies, contacts and ledger
    contacts.npy   one row a contact of a record, record after record

Contacts are written before the records that count them, so that no record is without its contacts.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.results.checkpoint import SCENE_KIND, Layout, end_of, read_state, rows_of
from nonsmooth.results.scene_paradoxes import no_rows
from nonsmooth.results.scene_records import CONTACTS, contact_row, record_row
from nonsmooth.results.scene_solution import SceneSolution, SceneStats, columns_of

if TYPE_CHECKING:
    from nonsmooth.scenes.scene import Scene


def scene_layout(n_b: int, dim: int, kinds: tuple[str, ...], n_j: int = 0) -> Layout:
    """Of so many bodies in the plane or in space, and joints."""
    rows = {"records": record_row(n_b, dim, kinds, n_j=n_j)}
    if CONTACTS in kinds:
        rows["contacts"] = contact_row(dim)
    return Layout(SCENE_KIND, [n_b, dim, list(kinds), *([n_j] if n_j else [])], rows)


def load_scene_checkpoint(path: Path, scene: Scene | None = None, is_verified: bool = False) -> SceneSolution:
    """The records of a checkpoint as a SceneSolution; its arrays are views of the file, read where they are looked at.

    Raises
    ------
    InvalidInput
        For a folder that is no checkpoint of a scene, or a damaged one.
    """
    about, kept = read_state(path, SCENE_KIND)
    n_b, dim, kinds, *n_j = about["shape"]
    rows = rows_of(path, about, scene_layout(n_b, dim, tuple(kinds), *n_j).rows, is_verified)
    records, contacts = rows["records"], rows.get("contacts")
    if contacts is not None:
        records = records[: np.searchsorted(np.cumsum(records["n_contacts"]), len(contacts), side="right")]
    if len(records) < about["records"]:
        raise InvalidInput(f"the checkpoint {str(path)!r} is damaged: contacts of its records are not there")
    status, message = end_of(about)
    return SceneSolution(
        **columns_of(records, contacts, tuple(kinds)), stats=SceneStats(**about["stats"]), status=status,
        message=message, names=names_of(kept), scene=scene, centres=kept["centres"], about=about["about"],
        joint_names=[str(name) for name in kept.get("joint_names", ())],
        paradox_rows=kept.get("paradox_rows", no_rows()),
    )  # fmt: skip


def names_of(kept: dict[str, Any]) -> list[str]:
    """The names of the bodies."""
    return [str(name) for name in kept["names"]]
