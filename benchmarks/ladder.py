"""``python -m benchmarks ladder [FOLDER...]``: ladders of contact solvers against each other, as a page.

    python -m benchmarks ladder tests/data > docs/benchmarks/ladder.md

A ladder is a function that gives a problem its rungs, a list of solvers. Each of them climbs every problem of five
sets to 1e-8, for CAP seconds at most: small random ones of every family of ``benchmarks/problems.py``; such with masses
over six decades; published ones (the fc2d and fc3d files of the folders, of tests/data without any, each with half, all
and twice of its friction); large random ones, shaken and at rest; and these without friction. Times are those of the
processor; who tries another ladder adds it to LADDERS. Words that name ladders or sets restrict the page to them.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.problems import FAMILIES, Case, uneven
from nonsmooth.commands.solve_files import load_problem
from nonsmooth.contact.blocks.ladder import Solver, climb, from_inside, is_cheap, ladder_of
from nonsmooth.contact.blocks.newton import Newton
from nonsmooth.contact.blocks.nsgs import NSGS
from nonsmooth.contact.blocks.problem import Problem, check_problem, scale_problem

TOLERANCE = 1e-8
COPIES = Path("tests/data")  # of published problems
CAP = 20.0  # s of wall time for one problem
SMALL = (10, 30, 100)  # contacts, roughly
SEEDS = range(5)
HEAVY = (8, 20, 40)  # contacts
FRICTION = (0.5, 1.0, 2.0)  # times the published coefficients
LARGE = (80, 200, 500, 1000, 2300)
LARGE_KINDS: tuple[tuple[str, int, dict[str, float]], ...] = (
    ("packing", 2, {}), ("packing", 3, {}), ("packing", 3, {"noise": 0.0}), ("wall", 2, {"noise": 0.0}),
    ("wall", 3, {}), ("tower", 3, {}), ("uneven", 3, {}),
)  # fmt: skip
Ladder = Callable[[Problem], list[Solver]]


def inside(problem: Problem) -> list[Solver]:
    """Without pivoting and the farthest distance: sweeps, Newton, interior points from three distances, sweeps."""
    return [NSGS(max_sweeps=100), Newton(patience=4), *from_inside(0.3, 0.03, 3.0), NSGS(max_sweeps=20_000)]


LADDERS: dict[str, Ladder] = {"auto": ladder_of, "inside": inside}


class Ascent(NamedTuple):
    """How a ladder did on one problem."""

    error: float
    seconds: float
    solver: str  # that ended it
    rungs: int  # that were begun


def main(words: list[str] | None = None) -> int:
    """Print the page; returns the exit code."""
    words = words or []
    folders = [Path(word) for word in words if word not in LADDERS and word not in SETS] or [COPIES]
    ladders = {name: ladder for name, ladder in LADDERS.items() if name in words} or LADDERS
    print("# Ladders of contact solvers\n")
    print(f"Made by `python -m benchmarks ladder`: processor time to an error of {TOLERANCE:g}, {CAP:g} s at most.")
    print("*of the first's* is the median ratio to the first ladder's time, problem by problem; *ended by* names the")
    print("solver that reached the tolerance, the number of rungs begun until then, and how many ended so.\n")
    for name, ladder in ladders.items():
        print(f"- `{name}`: {(ladder.__doc__ or '').strip()}")
    for name, cases in SETS.items():
        if name in words or not SETS.keys() & set(words):
            print("\n".join(section(name, list(cases(folders)), ladders)), flush=True)
    return 0


def section(name: str, cases: list[tuple[str, Case]], ladders: dict[str, Ladder]) -> Iterator[str]:
    """The table of one set, and the problems that some ladder leaves."""
    found: dict[str, list[Ascent]] = {ladder: [] for ladder in ladders}
    for k, (title, case) in enumerate(cases):
        order = list(ladders) if k % 2 else list(reversed(ladders))
        for ladder in order:
            ascent = ascend(case, ladders[ladder])
            found[ladder].append(ascent)
            print(f"{name}: {title}: {ladder}: {ascent}", file=sys.stderr, flush=True)
    first = next(iter(found.values()))
    yield f"\n## {name.capitalize()}: {len(cases)} problems\n"
    yield "| ladder | solved | median time [ms] | of the first's | longest [s] | all [s] | ended by |"
    yield "|---|---|---|---|---|---|---|"
    for ladder, ascents in found.items():
        yield f"| {ladder} | " + " | ".join(columns(ascents, first)) + " |"
    for k, (title, _) in enumerate(cases):
        left = {ladder: ascents[k].error for ladder, ascents in found.items() if ascents[k].error > TOLERANCE}
        if left:
            yield f"\n{title}: left at " + ", ".join(f"{error:.0e} by {ladder}" for ladder, error in left.items())


def columns(ascents: list[Ascent], first: list[Ascent]) -> Iterator[str]:
    """Solved; median time; median of the ratio to the first ladder; longest; all; and which rungs ended how many."""
    seconds = [ascent.seconds for ascent in ascents]
    yield str(sum(ascent.error <= TOLERANCE for ascent in ascents))
    yield f"{1e3 * statistics.median(seconds):.3g}"
    yield f"{statistics.median(a.seconds / b.seconds for a, b in zip(ascents, first, strict=True)):.2f}"
    yield f"{max(seconds):.2g}"
    yield f"{sum(seconds):.3g}"
    ends = Counter(f"{ascent.solver} ({ascent.rungs})" for ascent in ascents if ascent.error <= TOLERANCE)
    yield ", ".join(f"{end}: {count}" for end, count in sorted(ends.items(), key=lambda item: item[0].split("(")[1]))


def ascend(case: Case, ladder: Ladder) -> Ascent:
    """Climb a problem from zero."""
    problem, _ = scale_problem(check_problem(*case))
    began = time.process_time()
    end = climb(problem, np.zeros(problem.n), TOLERANCE, ladder(problem), is_cheap(problem), time.monotonic() + CAP)
    seconds = time.process_time() - began
    return Ascent(problem.error(end.P), seconds, end.solver, sum("polish" not in note for note in end.notes))


# ---------------------------------------------------------------------------------------------------------------
# The sets: folders -> titles and problems


def random(folders: list[Path]) -> Iterator[tuple[str, Case]]:
    """Every family in the plane and in space."""
    for name, family in FAMILIES.items():
        for dim in (2, 3):
            for size in SMALL:
                for seed in SEEDS:
                    yield f"{name} {dim}-D {size} ({seed})", family(np.random.default_rng([seed, size, dim]), size, dim)


def heavy(folders: list[Path]) -> Iterator[tuple[str, Case]]:
    """Masses over six decades and friction coefficients up to two."""
    for dim in (2, 3):
        for size in HEAVY:
            for seed in range(10, 20):
                yield f"uneven {dim}-D {size} ({seed})", uneven(np.random.default_rng([seed, size, dim]), size, dim)


def published(folders: list[Path]) -> Iterator[tuple[str, Case]]:
    """The friction problems in files."""
    for path in sorted(file for folder in folders for file in folder.glob("fc?d/*.npz")):
        _, _, (G, c, mu, dim) = load_problem(path)
        for part in FRICTION:
            yield f"{path.stem}, {part:g} mu", Case(G, c, part * mu, dim)


def large(folders: list[Path], mu: float = 1.0) -> Iterator[tuple[str, Case]]:
    """Hundreds and thousands of contacts, with so many times their coefficients of friction."""
    for name, dim, options in LARGE_KINDS:
        for size in LARGE:
            G, c, own, _ = FAMILIES[name](np.random.default_rng([7, size, dim]), size, dim, **options)
            yield f"{name} {dim}-D{' at rest' * bool(options)}, {len(own)} contacts", Case(G, c, mu * own, dim)


def smooth(folders: list[Path]) -> Iterator[tuple[str, Case]]:
    """The same without friction."""
    yield from large(folders, 0.0)


SETS = {"random": random, "heavy": heavy, "published": published, "large": large, "smooth": smooth}
