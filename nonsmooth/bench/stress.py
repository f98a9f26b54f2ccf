"""``nonsmooth bench stress [PAGE.md]``: hard cases by every integrator that claims them, each figure beside its bound.

Without a file the tables are printed; with one they are written as a page, with its figures beside docs/figures.
"""

from __future__ import annotations

import math
import platform
import warnings
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from nonsmooth.bench import stress_contacts
from nonsmooth.bench.stress_figures import Case, Outcome, run

GROUPS: dict[str, Callable[[bool], Iterator[Case]]] = {
    "Many, redundant and nearly dependent contacts": stress_contacts.cases,
}
HEADER = "| case | integrator | steps | depth [m] | residual | ledger | momentum | error | |"


def main(argv: list[str] | None = None) -> int:
    """Print the tables, or write the page; returns 0 if every row holds."""
    outcomes = {title: run_all(cases(True)) for title, cases in GROUPS.items()}
    text = page(outcomes)
    if argv:
        Path(argv[0]).write_text(text, encoding="utf-8")
    else:
        print(text)
    return int(not all(outcome.holds for group in outcomes.values() for outcome in group))


def run_all(cases: Iterable[Case]) -> list[Outcome]:
    """Every case by all of its integrators."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return [run(case, method) for case in cases for method in case.methods]


def page(outcomes: dict[str, list[Outcome]]) -> str:
    """The tables in Markdown."""
    lines = ["# Stress: hard cases, and what is left of their invariants", ""]
    lines += [f"`nonsmooth bench stress`, {platform.platform()}, Python {platform.python_version()}.", ""]
    for title, group in outcomes.items():
        lines += [f"## {title}", "", HEADER, "|" + "---|" * 9, *(row(outcome) for outcome in group), ""]
    return "\n".join(lines)


def row(outcome: Outcome) -> str:
    """One run; a figure beyond its bound stands beside it, in bold."""
    cells = [figure_cell(*pair) for pair in zip(outcome.figures, outcome.bounds, strict=True)]
    verdict = "" if outcome.holds else f"**fails** {outcome.failure}".strip()
    return f"| {outcome.case} | {outcome.method} | {outcome.steps} | {' | '.join(cells)} | {verdict} |"


def figure_cell(figure: float, bound: float) -> str:
    """A figure, with its bound where it is beyond it."""
    if math.isnan(figure):
        return "—"
    return f"{figure:.0e}" if math.isnan(bound) or figure <= bound else f"**{figure:.0e}** > {bound:.0e}"
