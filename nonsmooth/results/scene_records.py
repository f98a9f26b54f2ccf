"""What a run of a scene records: its columns, kind by kind, in memory and in every file."""

from __future__ import annotations

from typing import Any

import numpy as np

from nonsmooth.results.recorded import EVENTS, LEDGER, chosen_kinds

OF_ALL = ("force", "friction", "normal", "surface", "projection")  # defined: columns of the ledger
STEP = "step"  # defined: of "normal", what the steps take or give, where contacts are rigid (assembly/book.py)
WORKS = (*OF_ALL, STEP)
ENERGIES = ("kinetic", "potential")
# defined: columns of the ledger where contacts are compliant, in addition to OF_ALL
ELASTIC, DAMPING = "elastic", "damping"
BODIES, CONTACTS, PAIRS = "bodies", "contacts", "pairs"
UNASKED = (BODIES, CONTACTS, LEDGER)  # what is recorded where nothing is said
KINDS = (*UNASKED, EVENTS, PAIRS)
OF_BODIES = ("position", "turn", "velocity", "spin")
JOINT_IMPULSES = "joint_impulses"  # of joints, kept with the contacts
SCALAR = ("t", "residual", "penetration")  # that are always recorded


def as_kinds(record: Any) -> tuple[str, ...]:
    """What is recorded, in the order of ``KINDS``; all but events and pairs where nothing is said."""
    return chosen_kinds(record, KINDS, UNASKED, motion=(BODIES,))


def record_row(n_b: int, dim: int, kinds: tuple[str, ...], works: tuple[str, ...] = WORKS, n_j: int = 0) -> np.dtype:
    """A record: a row of numbers; ``works`` are those of the ledger, without the energies of the bodies; n_j joints."""
    of_turn, of_spin = ((4,), (3,)) if dim == 3 else ((), ())
    columns: list[tuple[str, str, tuple[int, ...]]] = [(name, "<f8", ()) for name in SCALAR]
    if BODIES in kinds:
        columns += [("position", "<f8", (n_b, dim)), ("turn", "<f8", (n_b, *of_turn))]
        columns += [("velocity", "<f8", (n_b, dim)), ("spin", "<f8", (n_b, *of_spin))]
    if CONTACTS in kinds:
        columns.append(("n_contacts", "<i8", ()))
        if n_j:
            columns.append((JOINT_IMPULSES, "<f8", (n_j, dim)))
    if LEDGER in kinds:
        columns += [(name, "<f8", ()) for name in (*ENERGIES, *works)]
    if PAIRS in kinds:
        columns.append(("n_pairs", "<i8", ()))
    return np.dtype(columns)


def contact_row(dim: int) -> np.dtype:
    """A contact of a record."""
    columns: list[Any] = [("i", "<i8"), ("j", "<i8"), ("point", "<f8", (dim,)), ("normal", "<f8", (dim,))]
    return np.dtype([*columns, ("gap", "<f8"), ("P", "<f8", (dim,)), ("mu", "<f8")])


def pair_row(dim: int) -> np.dtype:
    """What a pair of bodies exchanged between two records."""
    columns: list[Any] = [("i", "<i8"), ("j", "<i8"), ("joint", "<i8"), ("P", "<f8", (dim,))]
    return np.dtype([*columns, ("normal", "<f8"), ("friction", "<f8"), ("surface", "<f8")])


def rows_beside(dim: int, kinds: tuple[str, ...]) -> dict[str, np.dtype]:
    """The arrays that are kept apart from the records, as many rows as there are in each of them."""
    rows = {CONTACTS: contact_row(dim), PAIRS: pair_row(dim)}
    return {kind: row for kind, row in rows.items() if kind in kinds}


def event_row(dim: int) -> np.dtype:
    """A change at a pair of bodies."""
    columns: list[Any] = [("t", "<f8"), ("kind", "<i8"), ("i", "<i8"), ("j", "<i8"), ("P_N", "<f8")]
    return np.dtype([*columns, ("P", "<f8", (dim,))])
