"""Problems from files, solved one by one: a table, and the Dolan-More performance profile of several solvers.

    rho_s(tau) = share of the problems that solver s solves within tau times the time of the fastest solver

Files: npz with M, q (LCP), with is_comp too (mixed LCP), with data, indices, indptr, shape, q, mu, dim (friction); and
FCLIB in HDF5. Source: Dolan and More, Math. Program. 91 (2002) 201-213.
"""

from __future__ import annotations

import os
import time
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_positive, as_tolerance
from nonsmooth.checks.files import refusals
from nonsmooth.drawing.plots import save_figure
from nonsmooth.errors import InvalidInput, MissingExtra, NonsmoothError, Status, UnknownName, nearest
from nonsmooth.results.failed_problem import FailedProblem, is_failed_problem, require_failed_problem
from nonsmooth.results.forms import FLAG, REAL, WHOLE, Form, Rule, require_forms
from nonsmooth.results.npz import Archive, read_npz
from nonsmooth.results.sparse_rows import compressed_rows

OF_MIXED = {"A", "B", "C", "D", "a", "b", "n", "m", "block_rows", "block_is_comp"}  # which files of mixed ones hold too
TABLE_NAMES_SHOWN = 20  # chosen: names in a message
RANK_N = 400  # measured: the singular values of a larger matrix take longer than its solution
COMPLEMENTARITY: dict[str, Rule] = {"M": (REAL, ("n", "n")), "q": (REAL, ("n",))}
TABLES: dict[str, dict[str, Rule]] = {  # of which the first whose names are all there says what the problem is
    "friction": {
        "data": (REAL, ("entries",)), "indices": (WHOLE, ("entries",)), "indptr": (WHOLE, ("n + 1",)),
        "shape": (WHOLE, (2,)), "q": (REAL, ("n",)), "mu": (REAL, ("contacts",)), "dim": (WHOLE, ()),
    },
    "mlcp": COMPLEMENTARITY | {"is_comp": (FLAG, ("n",))},
    "lcp": COMPLEMENTARITY,
}  # fmt: skip
COLUMNS = ("file", "kind", "n", "contacts", "rank", "status", "error", "iterations", "time", "solver")


def solve_files(
    paths: Iterable[str | os.PathLike[str]], solver: str = "auto", tol: float = 1e-8, max_time: float | None = None
) -> list[dict]:
    """Solve the complementarity or friction problem of every file.

    Parameters
    ----------
    paths : iterable of path-like
        npz or FCLIB (h5, hdf5) files.
    solver : str
        A name that `solve_lcp` or `solve_contact` knows, or "auto".
    tol : float
        Largest accepted error in the measure of the kind [-].
    max_time : float, optional
        Wall time for each friction problem [s], as for `solve_contact`; complementarity problems take none.

    Returns
    -------
    list of dict
        One per file: file, kind ("lcp", "mlcp", "fc2d", "fc3d"), n, contacts, rank (None for n > 400), status, error,
        iterations, time [s] of the second of two solves, so without compilation, solver, message. What cannot be read
        or solved has status "ERROR" and the reason in ``message``.

    Raises
    ------
    InvalidInput
        When a single path is given instead of a list, for a tolerance or a time that is not positive, or a solver of
        no kind.
    """
    tol = as_tolerance("tol", tol)
    if max_time is not None:
        max_time = as_positive("max_time", max_time, "s")
    _require_solver(solver)
    if isinstance(paths, str | os.PathLike):
        raise InvalidInput(f"paths must be a list of files; got the single path {os.fspath(paths)!r}")
    return [_solve_file(Path(path), solver, tol, max_time) for path in paths]


def _require_solver(name: str) -> None:
    """Raise unless a solver of complementarity or friction problems has this name."""
    from nonsmooth.contact.blocks.solve import SOLVERS as of_friction
    from nonsmooth.lcp.solve import SOLVERS as of_complementarity
    from nonsmooth.numerics.quadratic_program import solver_names

    known = {"auto", *of_complementarity, *of_friction}
    if name not in known and name not in solver_names():
        raise UnknownName(f"no solver is called {name!r}; {nearest(name, known.union(solver_names()))}")


def _solve_file(path: Path, solver: str, tol: float, max_time: float | None) -> dict:
    row: dict[str, Any] = dict.fromkeys(COLUMNS)
    row |= {"file": path.name, "status": "ERROR", "solver": solver, "message": ""}
    try:
        kind, matrix, arguments = load_problem(path)
        n = matrix.shape[0]
        row |= {"kind": kind, "n": n, "contacts": len(arguments[2]) if kind.startswith("fc") else None}
        if n <= RANK_N:
            row["rank"] = int(np.linalg.matrix_rank(matrix.toarray() if hasattr(matrix, "toarray") else matrix))
        if kind == "step":
            return row | _replayed(arguments[0])
        for _ in range(2):
            start = time.perf_counter()
            result = _solve(kind, arguments, solver, tol, max_time)
            row["time"] = time.perf_counter() - start
    except (NonsmoothError, OSError) as error:
        return row | {"message": str(error)}
    reached = result.error if kind.startswith("fc") else result.residual
    return row | {
        "status": result.status.name,
        "error": float(reached),
        "iterations": int(result.iterations),
        "solver": result.solver,
        "message": result.message,
    }


def _replayed(problem: FailedProblem) -> dict[str, Any]:
    """The row of a contact problem that a step left: the step's own solver is asked again."""
    start = time.perf_counter()
    answer = problem.solve()
    status = "SOLVED" if answer.status == Status.FINISHED else answer.status.name
    return {"contacts": len(problem.kinds), "time": time.perf_counter() - start, "status": status,
            "error": answer.residual, "iterations": 0, "solver": "of the step", "message": problem.about}  # fmt: skip


def _solve(kind: str, arguments: tuple[Any, ...], solver: str, tol: float, max_time: float | None) -> Any:
    if max_time is not None and not kind.startswith("fc"):
        raise InvalidInput("max_time limits friction problems; leave it out for complementarity problems")
    if kind == "lcp":
        from nonsmooth.lcp.solve import solve_lcp

        A, b = arguments
        return solve_lcp(A, b, solver=solver, tol=tol)
    if kind == "mlcp":
        from nonsmooth.lcp.mixed import solve_mlcp

        A, b, free = arguments
        return solve_mlcp(A, b, free, solver=solver, tol=tol)
    from nonsmooth.contact.blocks.solve import solve_contact

    G, c, mu, dim = arguments
    return solve_contact(G, c, mu, dim, solver=solver, tol=tol, max_time=max_time)


def load_problem(path: Path) -> tuple[str, Any, tuple]:
    """Kind, matrix and the positional arguments of the solve function of its kind."""
    if path.suffix in (".h5", ".hdf5"):
        from nonsmooth.results.fclib import read_fclib

        problem = read_fclib(path).local()
        return f"fc{problem.dim}d", problem.G, (problem.G, problem.c, problem.mu, problem.dim)
    if path.suffix != ".npz":
        raise InvalidInput(f"a problem file must end in .npz, .h5 or .hdf5; got {path.name}")
    with refusals(path, "must be an npz archive of plain arrays"):
        found = read_npz(path, lambda forms: _require_problem(path.name, forms))
        return _problem_of(_kind(path.name, found.arrays), found)


def _problem_of(kind: str, found: Archive) -> tuple[str, Any, tuple]:
    entries = found.arrays
    if kind == "step":
        failed = FailedProblem.of_archive(found)
        return kind, failed.G, (failed,)
    for name, (dtypes, _) in TABLES[kind].items():
        if dtypes == REAL and not np.isfinite(entries[name]).all():
            raise ValueError(f"{name} must be finite; one of its entries is not")
    if kind == "friction":
        return _friction(entries)
    A, b = entries["M"], entries["q"]
    return kind, A, (A, b) if kind == "lcp" else (A, b, ~_as_flags("is_comp", entries["is_comp"]))


def _friction(entries: dict[str, np.ndarray]) -> tuple[str, Any, tuple]:
    c, mu, dim, shape = entries["q"], entries["mu"], int(entries["dim"]), tuple(entries["shape"].tolist())
    if dim not in (2, 3) or len(mu) * dim != len(c) or shape != (len(c), len(c)):
        raise ValueError(
            f"q must have dim = 2 or 3 rows for each contact, and W a row for each of them; it has {len(c)} rows, "
            f"mu has {len(mu)} contacts of dim {dim}, and W the shape {shape}"
        )
    G = compressed_rows(entries["data"], entries["indices"], entries["indptr"], shape)
    return f"fc{dim}d", G, (G, c, mu, dim)


def _kind(file_name: str, names: Collection[str]) -> str:
    """Which problem arrays of these names are."""
    if is_failed_problem(names):
        return "step"
    for kind, rules in TABLES.items():
        if rules.keys() <= set(names):
            if kind == "lcp" and OF_MIXED & set(names):
                raise InvalidInput(f"{file_name} is a mixed problem without is_comp, which says where w_i = 0")
            return kind
    raise InvalidInput(
        f"{file_name} must hold M and q, or W in compressed rows with q, mu, dim; "
        f"it has {list(names)[:TABLE_NAMES_SHOWN]}"
    )


def _require_problem(file_name: str, forms: Mapping[str, Form]) -> None:
    """Raise unless the arrays of a file are those of a problem, with their dtypes and shapes."""
    kind = _kind(file_name, forms)
    if kind == "step":
        require_failed_problem(forms)
    else:
        require_forms(forms, TABLES[kind])


def _as_flags(name: str, flags: np.ndarray) -> np.ndarray:
    if not np.isin(flags, (0, 1)).all():
        raise ValueError(f"{name} must be 0 or 1 in each row")
    return flags.astype(bool)


def format_table(results: list[dict]) -> str:
    """The results as a text table; errors of reading and solving stand under it."""
    cells = [list(COLUMNS[:-2]) + ["time [ms]", "solver"]] + [
        [_cell(key, row[key]) for key in COLUMNS] for row in results
    ]
    widths = [max(len(line[k]) for line in cells) for k in range(len(COLUMNS))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in cells]
    solved = sum(row["status"] == "SOLVED" for row in results)
    reasons = [f"{row['file']}: {row['message']}" for row in results if row["status"] == "ERROR"]
    return "\n".join([lines[0], "-" * len(lines[0]), *lines[1:], "", f"{solved} of {len(results)} solved", *reasons])


def _cell(key: str, value: Any) -> str:
    if value is None:
        return "-"
    if key == "time":
        return f"{1e3 * value:.2f}"
    return f"{value:.1e}" if key == "error" else str(value)


def performance_profile(results: dict[str, list[dict]] | list[dict], path: str | os.PathLike[str]) -> None:
    """Draw the Dolan-More profile of one or several solvers.

    Parameters
    ----------
    results : dict of str to list of dict, or list of dict
        For every solver what `solve_files` returned for the same files; a list is one solver.
    path : path-like
        The figure; its ending names the format.

    Raises
    ------
    InvalidInput
        When the solvers were not run on the same files, or on none.
    MissingExtra
        When matplotlib is not installed.

    Source: Dolan and More, Math. Program. 91 (2002) 201-213.
    """
    runs = results if isinstance(results, dict) else {results[0]["solver"] if len(results) == 1 else "auto": results}
    ratios = time_ratios(runs)
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtra("a performance profile needs matplotlib: pip install nonsmooth[plot]") from None
    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    axes = figure.add_subplot()
    finite = [ratio[np.isfinite(ratio)] for ratio in ratios.values()]
    right = 1.3 * max([10.0, *(float(r.max()) for r in finite if r.size)])
    for (name, ratio), steps in zip(ratios.items(), finite, strict=True):
        tau = np.concatenate([[1.0], np.sort(steps), [right]])
        share = np.concatenate([[0.0], np.arange(1, steps.size + 1), [steps.size]]) / ratio.size
        axes.step(tau, share, where="post", label=f"{name} ({steps.size} of {ratio.size})")
    axes.set(xscale="log", xlim=(1.0, right), ylim=(0.0, 1.03), xlabel="time / time of the fastest solver, τ [-]",
             ylabel="share of problems solved within τ [-]")  # fmt: skip
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right")
    save_figure(figure, Path(path))


def time_ratios(runs: dict[str, list[dict]]) -> dict[str, np.ndarray]:
    """Time over the fastest solver's time for every problem; inf where it was not solved."""
    files = [[row["file"] for row in rows] for rows in runs.values()]
    if not files or not files[0] or any(names != files[0] for names in files):
        raise InvalidInput("results must hold the same files, at least one, in the same order for every solver")
    times = np.array(
        [[row["time"] if row["status"] == "SOLVED" else np.inf for row in rows] for rows in runs.values()], dtype=float
    )
    fastest = times.min(axis=0)
    with np.errstate(invalid="ignore"):
        ratios = np.where(np.isfinite(times), times / fastest, np.inf)
    return dict(zip(runs, ratios, strict=True))
