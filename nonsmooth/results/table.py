"""The columns of a result, each said once: memory, files, checkpoints, labelled data and the page of them come from it.

    Column(name, dtype, shape, unit, meaning, kind)

The name is that of the array in a file, and of the attribute; a word before a slash is what it is an attribute of,
``contacts/gap`` of the contacts, and ``*`` stands for any word. A shape is given by symbols, whose sizes are those of a
run: n_t records, n_c contacts with d directions of friction, n_b bodies. The kind is what ``record=`` asks for, "" of
what is always there; of a kind all columns are there, or none. Along n_t stand the records of a run; along m and n_p
contacts and pairs, as many rows a record as it counts.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from nonsmooth.integrators.records import EVENT_WIDTH, PARADOX_WIDTH
from nonsmooth.results.forms import REAL, WHOLE, Rule, Size
from nonsmooth.results.ledger import ENERGIES, WORKS
from nonsmooth.results.recorded import (
    BODIES,
    CONTACTS,
    COORDINATES,
    EVENTS,
    GAPS,
    IMPULSES,
    LEDGER,
    MODES,
    PAIRS,
    VELOCITIES,
    index_of,
    not_recorded,
)

ALWAYS, BETWEEN, FOUND = "", "motion", "found"  # code: kinds that nobody asks for: the last two are there, or not
OPTIONAL = ("la", "motion/Q")  # which not every run of its kind has
COUNTED = {CONTACTS: "m", PAIRS: "n_p"}  # kinds with rows of their own, which a record counts: n_contacts, n_pairs
OF_RECORD = ("pairs/t", "pairs/record")  # columns of these that the records tell


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
    Column("la", REAL, ("n_t", "n_c", "1 + d"), "N", "normal and friction forces", IMPULSES),
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
    Column("motion/Q", REAL, ("m", "degree_q", "n_q"), "", "and of the coordinates, where q' is not u", BETWEEN),
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


def scene_columns(dim: int) -> Table:
    """The columns of a run of a scene, in the plane or in space."""
    turn: tuple[Size, ...] = ("n_t", "n_b") if dim == 2 else ("n_t", "n_b", 4)
    spin: tuple[Size, ...] = ("n_t", "n_b") if dim == 2 else ("n_t", "n_b", 3)
    turns = ("rad", "angles") if dim == 2 else ("1", "unit quaternions")
    return (
        Column("t", REAL, ("n_t",), "s", "time", ALWAYS),
        Column("residual", REAL, ("n_t",), "1", "worst residual since the record before", ALWAYS),
        Column("penetration", REAL, ("n_t",), "m", "deepest penetration since the record before", ALWAYS),
        Column("centres", REAL, ("n_b", dim), "m", "centres of mass, in the frames of the shapes", ALWAYS),
        Column("paradox_rows", REAL, ("n_paradoxes", PARADOX_WIDTH), "", "paradoxes, a row each", ALWAYS),
        Column("position", REAL, ("n_t", "n_b", dim), "m", "centres of mass", BODIES),
        Column("turn", REAL, turn, *turns, BODIES),
        Column("velocity", REAL, ("n_t", "n_b", dim), "m/s", "velocities of the centres of mass", BODIES),
        Column("spin", REAL, spin, "rad/s", "angular velocities", BODIES),
        Column(
            "contacts/offsets", WHOLE, ("n_t + 1",), "1", "first contact of each record, and their number", CONTACTS
        ),
        Column("contacts/i", WHOLE, ("m",), "1", "body that pushes", CONTACTS),
        Column("contacts/j", WHOLE, ("m",), "1", "body that is pushed", CONTACTS),
        Column("contacts/point", REAL, ("m", dim), "m", "midway between the surfaces", CONTACTS),
        Column("contacts/normal", REAL, ("m", dim), "1", "out of body i", CONTACTS),
        Column("contacts/gap", REAL, ("m",), "m", "gap before the last step", CONTACTS),
        Column("contacts/P", REAL, ("m", dim), "N s", "impulse of the last step on body j", CONTACTS),
        Column("contacts/mu", REAL, ("m",), "1", "friction coefficient", CONTACTS),
        Column(
            "joint_impulses", REAL, ("n_t", "n_j", dim), "N s",
            "impulse of the last step on the second body of a joint", CONTACTS,
        ),
        Column(
            "joint_torques", REAL, ("n_t", "n_j") if dim == 2 else ("n_t", "n_j", 3), "N m s",
            "angular impulse of the last step on the second body of a joint, about its point", CONTACTS,
        ),
        Column("ledger/*", REAL, ("n_t",), "J", "energies, and works since the start", LEDGER),
        Column("events/t", REAL, ("n_e",), "s", "beginning of the step of an event", EVENTS),
        Column("events/kind", WHOLE, ("n_e",), "1", "0 LANDING, 1 PARTING, 2 SLIP, 3 STICK", EVENTS),
        Column("events/i", WHOLE, ("n_e",), "1", "first body", EVENTS),
        Column("events/j", WHOLE, ("n_e",), "1", "second body", EVENTS),
        Column("events/P_N", REAL, ("n_e",), "N s", "normal impulses of the step, summed", EVENTS),
        Column("events/P", REAL, ("n_e", dim), "N s", "impulse of the step on body j", EVENTS),
        Column("pairs/t", REAL, ("n_p",), "s", "end of the interval of a pair", PAIRS),
        Column("pairs/record", WHOLE, ("n_p",), "1", "record at which it ends", PAIRS),
        Column("pairs/i", WHOLE, ("n_p",), "1", "first body", PAIRS),
        Column("pairs/j", WHOLE, ("n_p",), "1", "second body", PAIRS),
        Column("pairs/joint", WHOLE, ("n_p",), "1", "joint that holds them, -1 where they touch", PAIRS),
        Column("pairs/P", REAL, ("n_p", dim), "N s", "impulse on body j since the record before", PAIRS),
        Column("pairs/normal", REAL, ("n_p",), "J", "work by normal impulses since the record before", PAIRS),
        Column("pairs/friction", REAL, ("n_p",), "J", "work by friction since the record before", PAIRS),
        Column(
            "pairs/surface", REAL, ("n_p",), "J",
            "work by guided bodies and running surfaces since the record before", PAIRS,
        ),
        Column("t_events/*", REAL, ("found *",), "s", "when function * of the user reached zero", FOUND),
    )  # fmt: skip


SCENE = {dim: scene_columns(dim) for dim in (2, 3)}


class Rows:
    """Columns by name: each is an attribute, an array along the rows."""

    columns: dict[str, np.ndarray]
    kinds: ClassVar[Mapping[str, str]] = {}  # of columns that may not be recorded

    if not TYPE_CHECKING:  # which knows the columns by their names alone

        def __getattr__(self, name: str) -> np.ndarray:
            columns = vars(self).get("columns", {})
            if name in columns:
                return columns[name]
            if columns and self.kinds.get(name):
                raise not_recorded(name, self.kinds[name])
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.columns]

    def columns_at(self, rows: Any) -> dict[str, np.ndarray]:
        """The columns of some rows."""
        return {name: np.asarray(column)[rows] for name, column in self.columns.items()}


class RecordsOfScene(Rows):
    """The attributes that a run of a scene has by its columns, for type checkers and editors, as the classes below."""

    t: np.ndarray
    residual: np.ndarray
    penetration: np.ndarray
    centres: np.ndarray
    paradox_rows: np.ndarray
    position: np.ndarray
    turn: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    joint_impulses: np.ndarray
    joint_torques: np.ndarray


class Ends(Rows):
    """Of what is between two bodies."""

    i: np.ndarray
    j: np.ndarray
    P: np.ndarray
    names: list[str]  # of all bodies

    def touching(self, *bodies: str) -> dict[str, np.ndarray]:
        """The columns of what is of one body, or of two."""
        has = np.ones(len(self.i), bool)
        for b in (index_of(name, self.names) for name in bodies):
            has &= (self.i == b) | (self.j == b)
        return self.columns_at(has)


class RowsOfContacts(Ends):
    """Of contacts."""

    point: np.ndarray
    normal: np.ndarray
    gap: np.ndarray
    mu: np.ndarray


class RowsOfEvents(Ends):
    """Of events."""

    t: np.ndarray
    kind: np.ndarray
    P_N: np.ndarray


class RowsOfPairs(Ends):
    """Of pairs."""

    t: np.ndarray
    record: np.ndarray
    joint: np.ndarray
    normal: np.ndarray
    friction: np.ndarray
    surface: np.ndarray


def columns_along(table: Table, rows: str, kinds: Collection[str]) -> Table:
    """The columns with such rows, "n_t": one a record, of some kinds and those that are always there."""
    return tuple(column for column in table if column.shape[0] == rows and column.kind in (ALWAYS, *kinds)
                 and "*" not in column.name)  # fmt: skip


def row_type(columns: Table, sizes: Mapping[str, int]) -> np.dtype:
    """A row of columns; the sizes by symbol."""
    return np.dtype([
        (word_of(name), dtypes[-1], tuple(sizes[size] if isinstance(size, str) else size for size in shape[1:]))
        for name, dtypes, shape, *_ in columns
    ])  # fmt: skip


def word_of(name: str) -> str:
    """The last word of the name of a column."""
    return name.rpartition("/")[2]


def under(columns: Mapping[str, np.ndarray], word: str) -> dict[str, np.ndarray]:
    """The columns of something by their last words: those of contacts, of the ledger."""
    return {name.removeprefix(f"{word}/"): column for name, column in columns.items() if name.startswith(f"{word}/")}


def numbered(columns: Mapping[str, np.ndarray], word: str) -> list[np.ndarray]:
    """The columns word/0, word/1, ..."""
    found = under(columns, word)
    return [found[str(k)] for k in range(len(found))]


def kinds_in(table: Table, names: Collection[str]) -> set[str]:
    """The kinds of which some column is there."""
    return {
        kind for known, *_, kind in table
        if known in names or ("*" in known and any(name.startswith(known.rstrip("*")) for name in names))
    }  # fmt: skip


def rules_of(table: Table, names: Collection[str]) -> dict[str, Rule]:
    """What the arrays of a file with such names must be: of each kind that is there, all."""
    there = {ALWAYS, *kinds_in(table, names)}
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


def scene_rows(
    n_b: int, dim: int, kinds: Collection[str], n_j: int = 0, works: tuple[str, ...] = WORKS
) -> dict[str, np.dtype]:
    """A row of the records of a scene, and of the kinds that they count; ``works`` are those of its ledger."""
    counted = {
        kind: row_type(
            tuple(column for column in columns_along(SCENE[dim], rows, kinds) if column.name not in OF_RECORD), {}
        )
        for kind, rows in COUNTED.items()
        if kind in kinds
    }
    records = row_type(columns_along(SCENE[dim], "n_t", kinds), {"n_b": n_b, "n_j": n_j}).descr
    records += [(f"ledger/{name}", "<f8") for name in (*ENERGIES, *works) if LEDGER in kinds]
    return {"records": np.dtype([*records, *((f"n_{kind}", "<i8") for kind in counted)])} | counted


def event_row(dim: int) -> np.dtype:
    """A change at a pair of bodies."""
    return row_type(columns_along(SCENE[dim], "n_e", (EVENTS,)), {})


def event_arrays(rows: np.ndarray) -> dict[str, np.ndarray]:
    """The arrays of the changes at pairs of bodies."""
    return {f"{EVENTS}/{name}": rows[name].copy() for name in names_of(rows)}


def scene_arrays(rows: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The arrays of a run of a scene from such rows, or from columns by name."""
    records, columns = rows["records"], dict[str, np.ndarray]()
    for kind in (kind for kind in COUNTED if kind in rows):
        offsets = np.concatenate(([0], np.cumsum(records[f"n_{kind}"], dtype=np.int64)))
        columns |= {f"{kind}/{name}": rows[kind][name][: offsets[-1]] for name in names_of(rows[kind])}
        if kind == CONTACTS:
            columns["contacts/offsets"] = offsets
        else:
            columns["pairs/record"] = record_of(offsets)
            columns["pairs/t"] = np.asarray(records["t"])[columns["pairs/record"]]
    return {name: records[name] for name in names_of(records) if not name.startswith("n_")} | columns


def record_of(offsets: np.ndarray) -> np.ndarray:
    """The record of each row that records count."""
    return np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))


def names_of(rows: Any) -> tuple[str, ...]:
    """The names of rows, or of columns."""
    return rows.dtype.names if isinstance(rows, np.ndarray) else tuple(rows)
