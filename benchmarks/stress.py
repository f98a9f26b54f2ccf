"""``python -m benchmarks stress [PAGE.md [FOLDER]]``: hard cases by every integrator that claims them.

Each figure has a bound. Without a file the tables are printed; with one they are written as a page, with its pictures
in the folder.
"""

from __future__ import annotations

import math
import os
import platform
import warnings
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from benchmarks import stress_contacts, stress_motions, stress_random, stress_units
from benchmarks.stress_figures import Case, Outcome, run
from benchmarks.stress_random import Verdict
from nonsmooth.errors import EnergyGainWarning, InitialStateWarning

RANDOM_SYSTEMS = 300
HEADER = "| case | integrator | steps | depth [m] | residual | ledger | momentum | invariant | |"
INTRODUCTION = """# Stress: hard cases, and what is left of their invariants

Each row is a motion of which something is known: that nothing moves, where a block stops, what is
conserved. The columns are the deepest penetration, the worst residual of an accepted contact
problem, the error of the energy ledger and of the momentum balance over all that was booked, and
the error of the case's own invariant. A figure beyond its bound is bold, with the bound beside it,
and the row says *fails*. The bounds are derived where the cases are written
(`benchmarks/stress_*.py`); a dash means that the case or the integrator has no such figure. An
integrator stands only in the rows that it claims: `EventDriven` enumerates at most 8 frictional
contacts at rest, the Jacobian of `Penalty` is dense, and rows that look at a fixed step are those
of `MoreauJean`. A residual of 1e-9 is also that of impulses whose rounding hides what they leave
(docs/theory/moreau_jean.md).

This page is written by `python -m benchmarks stress docs/benchmarks/stress.md docs/figures`;
`tests/stress` holds the small cases to the same bounds in every run of the tests,
`pytest -m slow tests/stress` the long ones.
"""


def main(argv: list[str] | None = None) -> int:
    """Print the tables, or write the page; returns 0 if every row holds."""
    groups = {
        "Many, redundant and nearly dependent contacts": run_all(stress_contacts.cases(True)),
        "Cascades, steps, long runs, stiffness, paradoxes": run_all(stress_motions.cases(True)),
        "Other units": [stress_units.compare(trial) for trial in stress_units.trials()],
    }
    outcomes = [outcome for group in groups.values() for outcome in group]
    verdicts = compare_all(RANDOM_SYSTEMS)
    if argv:
        write_page(Path(argv[0]), Path(argv[-1] if len(argv) > 1 else Path(argv[0]).parent), groups, verdicts)
    else:
        print("\n".join(tables(groups) + agreement(verdicts)))
    return int(not all(outcome.holds for outcome in outcomes) or any(is_open(v) for v in verdicts))


def run_all(cases: Iterable[Case]) -> list[Outcome]:
    """Every case by all of its integrators."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InitialStateWarning)
        return [run(case, method) for case in cases for method in case.methods]


def compare_all(n: int) -> list[Verdict]:
    """The first n random systems under all integrators."""
    with warnings.catch_warnings():
        for expected in (InitialStateWarning, EnergyGainWarning):  # e_N > 0 beside friction may gain energy
            warnings.simplefilter("ignore", expected)
        return [verdict for seed in range(n) for verdict in stress_random.compare(seed)]


def is_open(verdict: Verdict) -> bool:
    """Whether two integrators differ and nothing says why."""
    return not verdict.agrees and (not verdict.reason or "failure" in verdict.reason)


def write_page(page: Path, folder: Path, groups: dict[str, list[Outcome]], verdicts: list[Verdict]) -> None:
    """The page and its two pictures."""
    from benchmarks.stress_plots import plot_agreement, plot_margins

    plot_margins([outcome for group in groups.values() for outcome in group], folder / "stress_margins.png")
    plot_agreement(verdicts, folder / "stress_random.png")
    where = os.path.relpath(folder, page.parent)
    lines = [
        INTRODUCTION, f"{platform.system()} {platform.machine()}, Python {platform.python_version()}.", "",
        f"![Every figure over its bound]({where}/stress_margins.png)", "", *tables(groups), *agreement(verdicts),
        f"![Random systems: distance to located events against its bound]({where}/stress_random.png)", "",
    ]  # fmt: skip
    page.write_text("\n".join(lines), encoding="utf-8")


def tables(groups: dict[str, list[Outcome]]) -> list[str]:
    """A table for each group, and a count."""
    lines = []
    for title, group in groups.items():
        failed = sum(not outcome.holds for outcome in group)
        lines += [f"## {title}", "", f"{len(group)} runs, {failed} beyond a bound or not finished.", ""]
        lines += [HEADER, "|" + "---|" * 9, *(row(outcome) for outcome in group), ""]
    return lines


def row(outcome: Outcome) -> str:
    """One run; a figure beyond its bound stands beside it, in bold."""
    cells = [figure_cell(*pair) for pair in zip(outcome.figures, outcome.bounds, strict=True)]
    verdict = "" if outcome.holds else f"*fails* {outcome.failure}".strip()
    return f"| {outcome.case} | {outcome.method} | {outcome.steps} | {' | '.join(cells)} | {verdict} |"


def figure_cell(figure: float, bound: float) -> str:
    """A figure, with its bound where it is beyond it."""
    if math.isnan(figure):
        return "—"
    return f"{figure:.0e}" if math.isnan(bound) or figure <= bound else f"**{figure:.0e}** > {bound:.0e}"


def agreement(verdicts: list[Verdict]) -> list[str]:
    """How many random systems agree, and why the others do not."""
    counts = Counter((v.method, "agrees" if v.agrees else v.reason or "no reason known") for v in verdicts)
    lines = ["## Random planar systems", "",
             "Two to four coordinates, one to four contacts, against located events; the bound and the reasons to",
             "differ are those of `benchmarks/stress_random.py`.", "",
             "| integrator | outcome | systems |", "|---|---|---|"]  # fmt: skip
    lines += [f"| {method} | {outcome} | {count} |" for (method, outcome), count in sorted(counts.items())]
    left = sorted({(v.seed, v.method) for v in verdicts if is_open(v)})
    return [*lines, "", *([f"Open: {', '.join(f'{method} {seed}' for seed, method in left)}.", ""] if left else [])]
