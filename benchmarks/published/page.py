"""The page "Published results, remade", and the command that makes it."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Iterable, Iterator

from benchmarks.published import (
    arms,
    belt,
    dominoes,
    mechanisms,
    painleve,
    rods,
    scenes,
    sets,
    sprag_slip,
    standing,
    textbooks,
)
from benchmarks.published.rows import Found, Section, computed, program, shown, shown_as
from nonsmooth.checks.arrays import as_name

SECTIONS: tuple[Section, ...] = (
    *belt.SECTIONS, *arms.SECTIONS, *rods.SECTIONS, *sprag_slip.SECTIONS, *mechanisms.SECTIONS, *painleve.SECTIONS,
    *textbooks.SECTIONS, *scenes.SECTIONS, *standing.SECTIONS, *dominoes.SECTIONS, *sets.SECTIONS,
)  # fmt: skip
COLUMNS = 100  # chosen: of a line of Markdown (tests/test_house.py)
HEAD = ("quantity", "printed", "ours", "difference", "verdict", "program")
SAID = """\
Made by `python -m benchmarks published > docs/benchmarks/published.md`; with the names of the second column, as in
`python -m benchmarks published belt rod`, it makes these sections. The command ends with 1 if a row does not come
out as its verdict says, and `tests/benchmarks/test_bench_published.py` runs the rows.

*Printed* is typed as the source prints it; *ours* is computed by the program of the last column each time this page
is made, never stored. A row agrees if it is within half a unit of the last printed digit, unless the verdict names
another error with its reason. Where the source errs, ours has to meet what is right by a route of its own.

The programs use the public names of `nonsmooth` and the models of its catalogue, and the functions above their
table, which stand in `benchmarks/published`: in a checkout, `from benchmarks.published.belt import *` and what the
last column says remake a row of the first section.

*Corrected table* names a set of numbers whose equations are printed in a textbook chapter on friction-induced
instability with slips of the pen. They were derived again from the balance laws, and the numbers computed without
this library, by two of three routes: closed form; Runge–Kutta of order 8 at a relative tolerance of 1e-12 with events
located by root finding; stiff integration of a compliant or smoothed version."""
MISSING = {
    "bodies that enter later": "100 sheets of paper, one each 0.25 s (fork of PhysX)",
    "bodies that bend": "the Princeton beam",
    "data that are not stored here": "the piles of 2048 and 5040 spheres of Kleinert, Simeon, Obermayr (2015), whose "
    "floor carries their weight; the curves of IFToMM's governor",
    "a number, or a parameter of the motion": "the slider-crank with clearance (Flores, Leine, Glocker 2010); the case "
    "on two belts (fork of PhysX); energy won in an impact of two contacts (Kane 1984); grazing maps (arXiv "
    "2602.22797) and canards (arXiv 1703.08437)",
}


def main(words: list[str] | None = None) -> int:
    """Print the page, or the sections named; returns 1 if a row is not as it should be."""
    chosen = [section_of(word) for word in words or []]
    found = {section.name: [computed(row) for row in section.rows] for section in chosen or SECTIONS}
    lines = page(found) if not chosen else [line for section in chosen for line in table(section, found[section.name])]
    print("\n".join(lines))
    return 0 if all(one.is_as_said for rows in found.values() for one in rows) else 1


def section_of(name: str) -> Section:
    """By its name."""
    named = {section.name: section for section in SECTIONS}
    return named[as_name("section", name, named)]


def page(found: dict[str, list[Found]]) -> Iterator[str]:
    """The whole page."""
    everything = [one for rows in found.values() for one in rows]
    of_tables = sum(len(section.rows) for section in SECTIONS if section.table)
    agree, err, differ = counted(everything)
    yield "# Published results, remade\n"
    yield wrapped(
        f"{len(everything)} printed results, computed again: {agree} agree, in {err} the source errs, {differ} differ "
        f"for a reason that is not known. {len(everything) - of_tables} are of papers, books, programs and data of "
        f"others, {of_tables} of the corrected tables described below."
    )
    yield "\n| results | name | rows | agree | source errs |\n|---|---|---|---|---|"
    for section in SECTIONS:
        agree, err, _ = counted(found[section.name])
        link = f"[{section.title}](#{anchor(section.title)})"
        yield cells(link, f"`{section.name}`", str(len(section.rows)), str(agree), str(err) if err else "-") + " |"
    yield "\n## How it is made\n"
    for part in SAID.split("\n\n"):
        yield wrapped(part) + "\n"
    yield "## Where the source errs\n\n| quantity | of | printed | right | who errs |\n|---|---|---|---|---|"
    for section in SECTIONS:
        for row in section.rows:
            if row.errs:
                link = f"[{section.title}](#{anchor(section.title)})"
                yield cells(row.what, link, shown(row.printed), shown(row.corrected, ""), row.errs) + " |"
    yield "\n## What cannot be typed yet\n\n| missing | results |\n|---|---|"
    for missing, results in MISSING.items():
        yield cells(missing, results) + " |"
    yield ""
    for section in SECTIONS:
        yield from table(section, found[section.name])


def table(section: Section, found: Iterable[Found]) -> Iterator[str]:
    """A section with its table."""
    yield f"## {section.title}\n"
    yield wrapped(f"Corrected table {section.table}. {section.source}" if section.table else section.source) + "\n"
    if section.picture:
        yield f"{section.picture}\n"
    if section.functions:
        code = "\n\n\n".join(inspect.getsource(function).rstrip() for function in section.functions)
        yield f"```py\n{code}\n```\n"
    yield cells(*HEAD) + " |"
    yield "|" + "---|" * len(HEAD)
    for one in found:
        row, size = one.row, f"{one.difference:.1e}"
        numbers = (shown(row.printed), shown_as(one.ours, row.printed), size)
        yield cells(row.what, *numbers, one.verdict, f"`{program(row.ours)}`") + " |"
    yield ""


def counted(found: Iterable[Found]) -> tuple[int, int, int]:
    """How many agree, in how many the source errs, how many differ."""
    said = [(one.is_as_said, bool(one.row.errs)) for one in found]
    return said.count((True, False)), said.count((True, True)), said.count((False, False)) + said.count((False, True))


def cells(*texts: str) -> str:
    """A line of a table without its end."""
    return "| " + " | ".join(text.replace("|", "\\|") for text in texts)


def anchor(title: str) -> str:
    """Of a heading, as forges and MyST make it."""
    return "".join(letter for letter in title.lower().replace(" ", "-") if letter.isalnum() or letter in "-_")


def wrapped(text: str) -> str:
    """Lines of Markdown."""
    return textwrap.fill(text, COLUMNS, break_long_words=False, break_on_hyphens=False)
