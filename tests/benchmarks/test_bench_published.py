"""Published results come out as they are printed, or as the page says who errs; a wrong one is found."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from benchmarks.published import dominoes, mechanisms, page, scenes
from benchmarks.published.rows import Row, Section, computed, program, shown, tolerance, value_of
from nonsmooth.errors import UnknownName

PAGE = Path(__file__).parents[2] / "docs" / "benchmarks" / "published.md"
ROWS = [
    pytest.param(row, id=f"{section.name}: {row.what}", marks=[pytest.mark.slow] if row.is_slow else [])
    for section in page.SECTIONS
    for row in section.rows
]
HALF = Row("a half", "0.50", lambda: 1 / 2)


@pytest.mark.parametrize("row", ROWS)
def test_a_printed_result_comes_out_as_the_page_says(row):
    found = computed(row)
    assert found.is_as_said, f"printed {shown(row.printed)}, ours {found.ours!r}, corrected {row.corrected!r}"


def test_the_page_has_every_row_with_its_program():
    lines = PAGE.read_text().splitlines()
    for section in page.SECTIONS:
        assert f"## {section.title}" in lines
        for row in section.rows:
            begin = page.cells(row.what, shown(row.printed))
            assert any(line.startswith(begin) and line.endswith(f"`{program(row.ours)}` |") for line in lines), row.what
    assert sum(len(section.rows) for section in page.SECTIONS) >= 530
    assert all(page.cells(*told) + " |" in lines for told in page.MISSING.items())


def test_each_section_has_a_name_and_a_source_and_says_why_where_it_is_not_the_printed_digits():
    assert len({section.name for section in page.SECTIONS}) == len(page.SECTIONS)
    for section in page.SECTIONS:
        assert section.source and section.rows
        for row in section.rows:
            assert bool(row.errs) == bool(row.corrected) and bool(row.why) == (row.within is not None), row.what


@pytest.mark.parametrize("wrong", [
    dataclasses.replace(HALF, printed="0.51"),  # a changed print
    dataclasses.replace(HALF, ours=lambda: 0.5051),  # beyond half a unit of the last digit
    dataclasses.replace(HALF, ours=lambda: float("nan")),
    dataclasses.replace(HALF, corrected="0.50", errs="nobody"),  # said to err, but it does not
    dataclasses.replace(HALF, printed="0.60", corrected="0.70", errs="both"),  # the correction is wrong
    dataclasses.replace(HALF, printed="0.5001", within=1e-5, why="too small"),
])  # fmt: skip
def test_a_wrong_row_is_found_and_the_command_fails(wrong, monkeypatch, capsys):
    assert not computed(wrong).is_as_said and "DIFFERS" in computed(wrong).verdict
    monkeypatch.setattr(page, "SECTIONS", (Section("halves", "Halves", "Arithmetic.", (HALF, wrong)),))
    assert page.main([]) == 1
    said = capsys.readouterr().out
    assert "1 agree, in 0 the source errs, 1 differ" in " ".join(said.split()) and said.count("**DIFFERS**") == 1


@pytest.mark.parametrize("right", [
    HALF,
    dataclasses.replace(HALF, ours=lambda: 0.50499),
    dataclasses.replace(HALF, printed="1/2", within=0.0, why="exact"),
    dataclasses.replace(HALF, printed="0.60", corrected="0.50", errs="the source"),
    dataclasses.replace(HALF, printed=lambda: 2 / 3, corrected=lambda: 3 / 6, errs="the source"),
    dataclasses.replace(HALF, printed="0.5001", within=1e-3, why="as the source says"),
])  # fmt: skip
def test_a_row_that_is_as_said_lets_the_command_pass(right, monkeypatch, capsys):
    monkeypatch.setattr(page, "SECTIONS", (Section("halves", "Halves", "Arithmetic.", (right,)),))
    assert page.main(["halves"]) == 0
    assert "DIFFERS" not in capsys.readouterr().out


def test_the_last_printed_digit_is_read_from_every_form_of_a_number():
    for printed, half in (("0.50", 5e-3), ("948", 0.5), ("-9.81", 5e-3), ("1.634599e-3", 5e-10), ("2.9730e4", 0.5)):
        assert tolerance(printed, None) == pytest.approx(half, rel=1e-8)
    assert value_of("-80/7") == pytest.approx(-80 / 7, rel=1e-15) and value_of("2.9730e4") == 29730


def test_the_program_of_a_row_is_the_body_of_its_lambda_with_the_values_of_its_names():
    first, second = (lambda n=3: n + 1), (lambda n="a", k=2: [n for _ in range(k)])
    assert (program(first), program(second)) == ("3 + 1", "['a' for _ in range(2)]")
    assert program(lambda: sorted([2, 1], key=lambda x: -x)[0]) == "sorted([2, 1], key=lambda x: -x)[0]"


def test_measured_speeds_are_those_of_the_films():
    for row, gap in zip(dominoes.SECTIONS[0].rows, dominoes.FILMS, strict=True):
        assert str(gap) in row.what and dominoes.filmed(gap)[0] == pytest.approx(float(row.printed), abs=5e-4)
    assert 2 * dominoes.filmed(9.38)[1] == pytest.approx(0.086, abs=5e-4)
    assert dominoes.filmed(9.38, dominoes.ON_FELT)[0] == pytest.approx(1.33, abs=5e-3)
    assert 2 * dominoes.filmed(43.2562)[1] == pytest.approx(0.049, abs=1e-3)


def test_the_corrections_come_by_scipy_alone():
    assert scenes.polygon_by_arcs() == pytest.approx(0.246609, abs=5e-7)
    for ours, theirs in zip(mechanisms.after(0.03), mechanisms.by_scipy(0.03), strict=True):
        # one linear system gives all rates, the largest 1400 rad/s: its rounding is in proportion to that one
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())


def test_a_section_that_is_not_there_is_refused_by_name():
    with pytest.raises(UnknownName, match="'bell'.*belt"):
        page.main(["bell"])
