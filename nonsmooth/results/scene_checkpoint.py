"""The checkpoint of a run of a scene, in the folder and with the promises of checkpoint.py.

    records.npy    one row a record: t, residual, penetration, and what was asked for of bodies, contacts and ledger
    contacts.npy   one row a contact of a record, record after record
    pairs.npy      one row a pair of bodies and record, where it was asked for

Contacts and pairs are written before the records that count them, so that no record is without them.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.results.checkpoint import SCENE_KIND, Layout, end_of, read_state, rows_of
from nonsmooth.results.scene_pairs import pairs_of
from nonsmooth.results.scene_records import CONTACTS, PAIRS, record_row, rows_beside
from nonsmooth.results.scene_solution import SceneSolution, columns_of
from nonsmooth.results.scene_stats import SceneStats

if TYPE_CHECKING:
    from nonsmooth.scenes.scene import Scene


def scene_layout(n_b: int, dim: int, kinds: tuple[str, ...], n_j: int) -> Layout:
    """Of so many bodies in the plane or in space, and joints."""
    rows = {"records": record_row(n_b, dim, kinds, n_j=n_j)} | rows_beside(dim, kinds)
    return Layout(SCENE_KIND, [n_b, dim, list(kinds), n_j], rows)


def load_scene_checkpoint(path: Path, scene: Scene | None = None, is_verified: bool = False) -> SceneSolution:
    """The records of a checkpoint as a SceneSolution; its arrays are views of the file, read where they are looked at.

    Raises
    ------
    InvalidInput
        For a folder that is no checkpoint of a scene, or a damaged one.
    """
    about, kept = read_state(path, SCENE_KIND)
    n_b, dim, kinds, n_j = about["shape"]
    rows = rows_of(path, about, scene_layout(n_b, dim, tuple(kinds), n_j).rows, is_verified)
    records = rows.pop("records")
    for kind, beside in rows.items():
        records = records[: np.searchsorted(np.cumsum(records[f"n_{kind}"]), len(beside), side="right")]
        if len(records) < about["records"]:
            raise InvalidInput(f"the checkpoint {str(path)!r} is damaged: {kind} of its records are not there")
    status, message = end_of(about)
    columns, names = columns_of(records, rows.get(CONTACTS), tuple(kinds)), names_of(kept)
    joint_names = [str(name) for name in kept["joint_names"]]
    if PAIRS in rows:
        columns[PAIRS] = pairs_of(records, rows[PAIRS], names, joint_names)
    return SceneSolution(
        **columns, stats=SceneStats(**about["stats"]), status=status, message=message, names=names, scene=scene,
        centres=kept["centres"], about=about["about"], joint_names=joint_names,
        paradox_rows=kept["paradox_rows"],
    )  # fmt: skip


def names_of(kept: dict[str, Any]) -> list[str]:
    """The names of the bodies."""
    return [str(name) for name in kept["names"]]
