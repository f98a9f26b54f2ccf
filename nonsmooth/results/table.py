"""The columns of a result, each said once: memory, files, checkpoints, labelled data and the page of them come from it.

    Column(name, dtype, shape, unit, meaning, kind)

The name is that of the array in a file; a word before a slash is what the array is of, ``motion/t`` are times of the
motion, and ``*`` stands for any word. A shape is given by symbols, whose sizes are those of a run: n_t records, n_c
contacts with d directions of friction. The kind is what ``record=`` asks for, "" of what is always there; of a kind all
columns are there, or none.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np

from nonsmooth.integrators.records import EVENT_WIDTH
from nonsmooth.results.forms import REAL, WHOLE, Rule, Size
from nonsmooth.results.recorded import COORDINATES, EVENTS, GAPS, IMPULSES, LEDGER, MODES, VELOCITIES

ALWAYS, BETWEEN, FOUND = "", "motion", "found"  # code: kinds that nobody asks for: the last two are there, or not
OPTIONAL = ("la",)  # which not every run of its kind has


class Column(NamedTuple):
    """One column of a result."""

    name: str
    dtype: tuple[str, ...]  # which a file may have; memory has the last
    shape: tuple[Size, ...]
    unit: str
    meaning: str
    kind: str


Table = tuple[Column, ...]

SYSTEM: Table = (
    Column("t", REAL, ("n_t",), "s", "time", ALWAYS),
    Column("q", REAL, ("n_t", "n_q"), "", "coordinates", COORDINATES),
    Column("u", REAL, ("n_t", "n_u"), "", "velocities", VELOCITIES),
    Column("g_N", REAL, ("n_t", "n_c"), "m", "gaps", GAPS),
    Column("P_N", REAL, ("n_t", "n_c"), "N s", "normal impulses since the record before", IMPULSES),
    Column("P_F", REAL, ("n_t", "n_c", "d"), "N s", "friction impulses since the record before", IMPULSES),
    Column("mode", WHOLE, ("n_t", "n_c"), "1", "mode of the last step", MODES),
    Column("slip", WHOLE, ("n_t", "n_c"), "1", "sign of sliding", MODES),
    Column("la", REAL, ("n_t", "n_c", 2), "N", "normal and friction forces", IMPULSES),
    Column("ledger/*", REAL, ("n_t",), "J", "energies, and works since the start", LEDGER),
    Column("event_rows", REAL, ("n_events", EVENT_WIDTH), "", "events, a row each", EVENTS),
    Column("t_events/*", REAL, ("found *",), "s", "when function * of the user reached zero", FOUND),
    Column("q_events/*", REAL, ("found *", "n_q"), "", "coordinates there", FOUND),
    Column("u_events/*", REAL, ("found *", "n_u"), "", "velocities there", FOUND),
    Column("motion/t", REAL, ("m",), "s", "beginnings of the steps", BETWEEN),
    Column("motion/h", REAL, ("m",), "s", "their lengths", BETWEEN),
    Column("motion/q", REAL, ("m", "n_q"), "", "coordinates at their beginnings", BETWEEN),
    Column("motion/u", REAL, ("m", "n_u"), "", "velocities at their beginnings", BETWEEN),
    Column("motion/B", REAL, ("m", "degree", "n_u"), "", "coefficients of the velocities", BETWEEN),
    Column("motion/start", REAL, ("1 + n_q + n_u",), "", "t, q, u before an impact at the start", BETWEEN),
    Column("motion/end", REAL, ("1 + n_q + n_u",), "", "t, q, u after an impact at the end", BETWEEN),
)

# the numbers of an event, as ``event_rows`` has them
EVENT: Table = tuple(
    Column(name, dtype, ("n_events",), unit, f"{name} of events", EVENTS)
    for name, dtype, unit in (
        ("t", REAL, "s"), ("kind", WHOLE, ""), ("contact", WHOLE, ""), ("mode_before", WHOLE, ""),
        ("slip_before", WHOLE, ""), ("mode_after", WHOLE, ""), ("slip_after", WHOLE, ""), ("P_N", REAL, "N s"),
        ("P_F", REAL, "N s"), ("gamma_N", REAL, "m/s"), ("gamma_F", REAL, "m/s"), ("n_solutions", WHOLE, ""),
        ("found", WHOLE, ""),
    )
)  # fmt: skip


def columns_along(table: Table, rows: str, kinds: Collection[str]) -> Table:
    """The columns with such rows, "n_t": one a record, of some kinds and those that are always there."""
    return tuple(column for column in table if column.shape[0] == rows and column.kind in (ALWAYS, *kinds)
                 and "*" not in column.name)  # fmt: skip


def row_type(columns: Table, sizes: Mapping[str, int]) -> np.dtype:
    """A row of columns; the sizes by symbol."""
    return np.dtype([
        (name, dtypes[-1], tuple(sizes[size] if isinstance(size, str) else size for size in shape[1:]))
        for name, dtypes, shape, *_ in columns
    ])  # fmt: skip


def rules_of(table: Table, names: Collection[str]) -> dict[str, Rule]:
    """What the arrays of a file with such names must be: of each kind that is there, all."""
    there = {ALWAYS, *(column.kind for column in table if column.name in names)}
    rules: dict[str, Rule] = {}
    for name, dtypes, shape, *_, kind in table:
        before, star, _ = name.partition("*")
        if star:
            for found in (found for found in names if found.startswith(before)):
                word = found.removeprefix(before)
                rules[found] = dtypes, tuple(str(size).replace("*", word) for size in shape)
        elif name in names or (kind in there and name not in OPTIONAL):
            rules[name] = dtypes, shape
    return rules
