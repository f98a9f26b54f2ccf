"""Contact problems of FCLIB and of Siconos, solved as they are stored."""

from __future__ import annotations

from pathlib import Path

from benchmarks.others import CALLS, NAMES, error_of
from benchmarks.published.rows import Row, Section
from nonsmooth.commands.solve_files import load_problem

FOLDER = Path(__file__).parents[2] / "tests" / "data"
SOLVED = 1e-8  # of the published comparisons, the sharpest


def residual(kind, name):
    """Of the answer: the natural map with rho = 1, or max |min(z, w)|, over the size of the given vector."""
    arguments = load_problem(FOLDER / kind / f"{name}.npz")[2]
    found = CALLS[kind](*arguments)
    return error_of(arguments, found.P if kind.startswith("fc") else found.z)


SECTIONS = (
    Section(
        "sets",
        "Stored contact problems",
        "FCLIB (Acary, Brémond, Koziara, Perignon, INRIA RT-0444, 2014) and the test data of Siconos, as they are "
        "stored, matrices that are not symmetric too. No solution is printed; Acary, Brémond, Huber (2018) take a "
        "problem for solved at residuals of 1e-4 to 1e-8. The residual is that of [the comparison with "
        "Siconos](others.md), which no solver's own criterion enters.",
        tuple(
            Row(f"{title.lower()}: {file.stem}", "0", lambda kind=kind, name=file.stem: residual(kind, name),
                within=SOLVED, why="solved, as above")
            for kind, title in NAMES.items() for file in sorted((FOLDER / kind).glob("*.npz"))
        ),
        (residual,),
    ),
)  # fmt: skip
