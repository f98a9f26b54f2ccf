"""``python -m benchmarks others FOLDER...``: problems of others, each by us and by all of Siconos's solvers.

    python -m benchmarks others tests/data > docs/benchmarks/others.md

Every answer is judged by one measure that nobody's own criterion enters: for friction the natural map with rho = 1,
|P - proj_K(P - gamma_hat)| / |q|; for complementarity max |min(z, w)| / max |q|, and |w| where z is free. What is
within SOLVED counts. Siconos runs each of its solvers (and dense and sparse storage) in a process of its own, from its
default options; the fastest that solves a problem is its best. Times are processor times of one call from Python, the
least of some loops; the geometric mean of their ratios is taken over the problems that both solve.
"""

from __future__ import annotations

import math
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks import siconos
from benchmarks.solvers import table
from nonsmooth.commands.solve_files import load_problem
from nonsmooth.contact.blocks.solve import solve_contact
from nonsmooth.errors import InvalidInput
from nonsmooth.lcp.mixed import solve_mlcp
from nonsmooth.lcp.solve import solve_lcp

ADAPTER = Path(__file__).parent / "adapters" / "siconos_others.py"
SOLVED = 1e-7  # the bound of the published comparisons
PATIENCE = 30  # s that a process of Siconos may take
LOOP, ROUNDS = 2e-3, 5  # as in the adapter
TINY = 20  # unknowns
SOLVERS = {
    "lcp": ("LEMKE", "PIVOT", "PIVOT_LUMOD", "NEWTONMIN", "NEWTON_FB_FBLSA", "ENUM", "PGS", "CPG", "RPGS", "BARD"),
    "mlcp": ("FB", "ENUM", "LCP_LEMKE", "PGS"),  # DIRECT ones remember the modes of the call before
    "fc2d": ("NSGS", "CPG", "LEMKE", "ENUM"),
    "fc3d": ("NSGS", "NSN_AC", "NSN_FB", "PROX", "ADMM", "EG"),
}
CALLS: dict[str, Callable[..., Any]] = {
    "lcp": solve_lcp,
    "mlcp": solve_mlcp,
    "fc2d": solve_contact,
    "fc3d": solve_contact,
}
NAMES = {
    "lcp": "Linear complementarity", "mlcp": "Mixed complementarity", "fc2d": "Friction in the plane",
    "fc3d": "Friction in space",
}  # fmt: skip


class Answer(NamedTuple):
    """Who answered, in which processor time [s], and the error in the common measure."""

    solver: str
    seconds: float
    error: float


class Row(NamedTuple):
    """A problem, our answer, and the best one of Siconos (None: nobody solved it, or it is not installed)."""

    name: str
    n: int
    ours: Answer
    best: Answer | None


def main(words: list[str] | None = None) -> int:
    """Print the page; returns the exit code."""
    files = [file for word in words or [] for file in sorted(Path(word).glob("**/*.npz"))]
    problems = [(file, *load_problem(file)) for file in files if file.parent.name in SOLVERS]
    if not problems:
        raise InvalidInput(f"others needs folders of problems with {', '.join(SOLVERS)} in them; got {words or []}")
    print("# Problems of others, beside Siconos\n")
    print("Made by `python -m benchmarks others FOLDER`: processor time of a call from Python that ends within an")
    print(f"error of {SOLVED:g}; where it does not, the error stands beside it. *Best* is the fastest of Siconos's")
    print("solvers that gets there, chosen for each problem after the fact. Ratios are ours over that.\n")
    for kind, title in NAMES.items():
        rows = [row_of(file, arguments, kind) for file, found, _, arguments in problems if found == kind]
        if rows:
            print("\n".join(section(title, rows)), flush=True)
    return 0


def section(title: str, rows: list[Row]) -> Iterator[str]:
    """A table, and what it comes to."""
    yield f"## {title}\n"
    columns: dict[str, list] = {
        "unknowns": [row.n for row in rows],
        "ours": [shown(row.ours) for row in rows],
        "best of Siconos": ["-" if row.best is None else shown(row.best) for row in rows],
        "by": ["-" if row.best is None else row.best.solver for row in rows],
        "ratio": [f"{ratio(row):.2g}" if row.best else "-" for row in rows],
    }
    yield from table("problem", [row.name for row in rows], columns)
    yield ""
    for what, part in (("", rows), (f" of n < {TINY}", [r for r in rows if r.n < TINY]),
                       (f" of n >= {TINY}", [r for r in rows if r.n >= TINY])):  # fmt: skip
        both = [ratio(row) for row in part if row.best is not None and row.ours.error <= SOLVED]
        if both:
            mean = math.exp(sum(map(math.log, both)) / len(both))
            yield f"{len(both)} problems{what} that both solve: geometric mean of the ratios {mean:.2g}.  "
    solved = sum(row.ours.error <= SOLVED for row in rows)
    yield f"We solve {solved} of {len(rows)}, some solver of Siconos {sum(row.best is not None for row in rows)}.\n"


def shown(answer: Answer) -> str:
    """Time and, where it is too large, the error."""
    seconds = answer.seconds
    time_ = f"{1e6 * seconds:.3g} us" if seconds < 1e-3 else f"{1e3 * seconds:.3g} ms"
    return time_ if answer.error <= SOLVED else f"{time_} ({answer.error:.0e})"


def ratio(row: Row) -> float:
    """Our time over the best of Siconos."""
    assert row.best is not None
    return row.ours.seconds / row.best.seconds


def row_of(file: Path, arguments: tuple, kind: str) -> Row:
    """We and Siconos on one problem."""
    return Row(file.stem, len(arguments[1]), answer_of_ours(arguments, kind), best_of_siconos(file, arguments, kind))


def answer_of_ours(arguments: tuple, kind: str) -> Answer:
    """Our default solver: the least time of some loops of calls."""

    def timed(times: int) -> float:
        began = time.process_time()
        for _ in range(times):
            CALLS[kind](*arguments)
        return (time.process_time() - began) / times

    result = CALLS[kind](*arguments)
    seconds = timed(1)
    times, rounds = max(1, round(LOOP / max(seconds, 1e-6))), ROUNDS if seconds < 1.0 else 1
    least = min([seconds, *(timed(times) for _ in range(rounds - 1))])
    return Answer(result.solver, least, error_of(arguments, result.P if kind.startswith("fc") else result.z))


def best_of_siconos(file: Path, arguments: tuple, kind: str) -> Answer | None:
    """The fastest of its solvers that is right."""
    python = siconos.interpreter()
    if python is None:
        return None
    storages = ("dense", "sparse") if kind.startswith("fc") else ("dense",)
    answers = [answer_of(python, file, arguments, solver, storage) for solver in SOLVERS[kind] for storage in storages]
    right = [answer for answer in answers if answer is not None and answer.error <= SOLVED]
    return min(right, key=lambda answer: answer.seconds, default=None)


def answer_of(python: str, file: Path, arguments: tuple, solver: str, storage: str) -> Answer | None:
    """One solver of Siconos; None where it is not done in time, or its process ends otherwise."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder, "answer.npz")
        command = [python, str(ADAPTER), str(file.resolve()), solver, storage, str(target)]
        try:
            subprocess.run(command, capture_output=True, timeout=PATIENCE, check=True)
        except subprocess.SubprocessError:
            return None
        with np.load(target) as answer:
            return Answer(f"{solver}, {storage}", float(answer["seconds"]), error_of(arguments, answer["z"]))


# ---------------------------------------------------------------------------------------------------------------
# The common measure


def error_of(arguments: tuple, z: np.ndarray) -> float:
    """Of a solution; inf where it is not finite."""
    if not np.isfinite(z).all():
        return math.inf
    if len(arguments) == 4:
        return friction_error(*arguments, z)
    A, b, free = arguments if len(arguments) == 3 else (*arguments, np.zeros(len(arguments[1]), dtype=bool))
    w = A @ z + b
    return float(np.abs(np.where(free, w, np.minimum(z, w))).max() / np.abs(b).max())


def friction_error(G: Any, c: np.ndarray, mu: np.ndarray, dim: int, P: np.ndarray) -> float:
    """|P - proj_K(P - gamma_hat)| / |c|, gamma_hat = gamma + mu |gamma_T| e_N, K the cone |P_T| <= mu P_N."""
    x = (P - (G @ P + c)).reshape(-1, dim)
    x[:, 0] -= mu * np.linalg.norm((G @ P + c).reshape(-1, dim)[:, 1:], axis=1)
    length = np.linalg.norm(x[:, 1:], axis=1)
    onto = np.maximum((x[:, 0] + mu * length) / (1 + mu**2), 0.0)  # the normal part of the nearest point of the rim
    inside = length <= mu * x[:, 0]
    normal = np.where(inside, x[:, 0], onto)
    shrink = np.where(inside, 1.0, mu * onto / np.where(length > 0, length, 1.0))
    nearest = np.column_stack([normal, shrink[:, None] * x[:, 1:]])
    return float(np.linalg.norm(P.reshape(-1, dim) - nearest) / np.linalg.norm(c))
