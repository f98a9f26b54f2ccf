"""The columns of results: the pages have those of the table, and the recorded kinds their fields."""

import re
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.integrators.records import Event
from nonsmooth.jit.blocks import fields_of
from nonsmooth.results.forms import NAMES, Form, require_forms
from nonsmooth.results.table import (
    EVENT,
    SCENE,
    SYSTEM,
    RecordsOfScene,
    RowsOfContacts,
    RowsOfEvents,
    RowsOfPairs,
    columns_along,
    row_type,
    rules_of,
    word_of,
)

DOCS = Path(__file__).parents[2] / "docs"
HEAD = "| array | of | dtype | shape | unit | meaning |\n|---|---|---|---|---|---|\n"
PAGES = {"Columns of a solution": SYSTEM, "Columns of a run of a scene": SCENE[3]}
SIZES = {"n_t": 4, "n_q": 3, "n_u": 3, "n_c": 2, "d": 1, "1 + d": 2}


def page_of(table):
    """The columns as a table of Markdown."""
    return HEAD + "".join(
        f"| `{name}` | {kind} | {NAMES[dtypes]} | ({', '.join(map(str, shape))}{',' * (len(shape) == 1)}) | {unit} | "
        f"{meaning} |\n"
        for name, dtypes, shape, unit, meaning, kind in table
    )


@pytest.mark.parametrize("title", PAGES)
def test_the_page_of_files_has_the_columns_of_the_table(title):
    page = page_of(PAGES[title])
    assert f"## {title}\n\n{page}" in (DOCS / "files.md").read_text(), f"\n{page}"


def test_the_page_of_recording_names_every_field_of_a_kind():
    rows = re.findall(r'^\| `"(\w+)"` \| (.*) \|$', (DOCS / "recording.md").read_text(), re.M)
    fields = {kind: set(re.findall(r"`(\w+)`", row)) for kind, row in rows}
    for column in SYSTEM:
        if column.kind in fields:
            assert column.name.removesuffix("/*") in fields[column.kind], column


def test_in_the_plane_a_vector_has_two_components_and_turns_are_angles():
    planar = {column.name: column for column in SCENE[2]}
    for column in SCENE[3]:
        plane = planar.pop(column.name)
        if column.name in ("turn", "spin"):
            assert plane.shape == column.shape[:2] and plane.unit[:3] == "rad"
        elif column.name == "joint_torques":  # one about the only axis there is
            assert plane == column._replace(shape=column.shape[:-1])
        else:
            assert plane == column._replace(shape=tuple(2 if size == 3 else size for size in column.shape))
    assert not planar


@pytest.mark.parametrize(("attributes", "word"), [
    (RecordsOfScene, ""), (RowsOfContacts, "contacts"), (RowsOfEvents, "events"), (RowsOfPairs, "pairs"),
])  # fmt: skip
def test_type_checkers_know_the_columns_of_scenes(attributes, word):
    named = {name for kind in attributes.__mro__ for name in getattr(kind, "__annotations__", {})}
    columns = {column.name for column in SCENE[3] if "*" not in column.name and column.name != "contacts/offsets"}
    assert named - {"columns", "kinds", "names"} == {
        word_of(name) for name in columns if name.rpartition("/")[0] == word
    }


def test_kinds_of_events_are_told_by_number():
    (kind,) = (column for column in SCENE[3] if column.name == "events/kind")
    assert kind.meaning == ", ".join(f"{each.value} {each.name}" for each in ns.SceneEventKind)


def test_an_event_has_the_numbers_that_the_loop_writes():
    assert len(EVENT) == len(fields_of(Event))


def forms(**changes):
    """Of a run that recorded coordinates and impulses."""
    row = row_type(columns_along(SYSTEM, "n_t", ("coordinates", "impulses")), SIZES)
    every = {name: Form(row[name].base.str, (4, *row[name].shape)) for name in row.names}
    return {name: form for name, form in (every | changes).items() if form is not None}


@pytest.mark.parametrize(("changes", "words"), [
    ({"t": None}, "it has no t"),
    ({"P_F": None}, "it has no P_F"),
    ({"q": Form("<f4", (4, 3))}, "q must be float64; it is float32"),
    ({"q": Form(">f8", (4, 3))}, r"q must be float64; it is float64 \(>f8\)"),
    ({"P_N": Form("<f8", (3, 2))}, r"P_N must have the shape \(n_t = 4, n_c\); it has \(3, 2\)"),
    ({"q": Form("<f8", (4,))}, "q must have the shape"),
    ({"ledger/friction": Form("<f8", (5,))}, "ledger/friction must have the shape"),
    ({"u_events/3": Form("<f8", (2, 1)), "t_events/3": Form("<f8", (1,))}, r"u_events/3 must .* \(found 3 = 1"),
    ({"motion/t": Form("<f8", (2,))}, "it has no motion/"),
])  # fmt: skip
def test_arrays_that_are_not_those_of_the_table_are_refused(changes, words):
    with pytest.raises(ValueError, match=words):
        require_forms(forms(**changes), rules_of(SYSTEM, forms(**changes)))


def test_of_what_was_recorded_all_is_there_and_of_the_rest_nothing_is_asked():
    for left_out in ({}, {"la": None}, {"P_N": None, "P_F": None, "la": None}):
        there = forms(**left_out)
        assert require_forms(there, rules_of(SYSTEM, there))["n_q"] == 3
        assert rules_of(SYSTEM, there).keys() == there.keys()


def test_a_size_that_is_a_sum_is_that_of_its_parts():
    rules = {"q": (("<f8",), ("n",)), "ends": (("<f8",), ("1 + n",))}
    ends = {"q": Form("<f8", (3,)), "ends": Form("<f8", (4,))}
    assert require_forms(ends, rules) == {"n": 3, "1 + n": 4}
    with pytest.raises(ValueError, match=r"ends must have 1 \+ n = 4 entries; it has 3"):
        require_forms(ends | {"ends": Form(np.dtype(float).str, (3,))}, rules)
