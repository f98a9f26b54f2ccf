"""The command line: ``nonsmooth list | run | scene | classify | map | solve | study | sweep | completion``.

Arguments in, library calls, text and files out.

Exit codes: 0 done; 2 bad input; 3 the integration failed (what was computed is saved and summarised), or a problem file
was not solved; 4 a result could not be written; 130 interrupted.
"""

from __future__ import annotations

import argparse
import os
import sys
import warnings
from pathlib import Path
from typing import Any

from nonsmooth import __version__
from nonsmooth.checks.files import FIGURE_ENDINGS
from nonsmooth.commands.completion import add_completion
from nonsmooth.commands.paradoxes import add_classify, add_map
from nonsmooth.commands.run import add_run
from nonsmooth.commands.scene import add_scene
from nonsmooth.commands.studies import add_studies
from nonsmooth.commands.sweep import add_sweep
from nonsmooth.commands.terminal import FAILED, NOT_WRITTEN, complain, show_warning
from nonsmooth.commands.typed_input import (
    BAD_INPUT,
    NEGATIVE,
    Parser,
    number,
    require_module,
    require_writable,
)
from nonsmooth.commands.watch import ended_by_ctrl_c, last_words
from nonsmooth.errors import (
    INTERRUPTED,
    FileFailure,
    InvalidInput,
    MissingExtra,
    NonsmoothError,
    NonsmoothWarning,
    UnsupportedVersion,
)

BENCH_IS_GONE = (
    "`nonsmooth bench` is no command any more: the benchmarks are in the source of nonsmooth, beside the package; run "
    "`python -m benchmarks` in a checkout"
)


def main(argv: list[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    argv : list of str, optional
        The arguments; those of the process when left out.

    Returns
    -------
    int
        The exit code.
    """
    words = sys.argv[1:] if argv is None else argv
    if words[:1] == ["bench"]:
        complain(BENCH_IS_GONE)
        return BAD_INPUT
    return perform(build_parser(), words)


def perform(parser: argparse.ArgumentParser, words: list[str]) -> int:
    """Parse some words and do what they ask for; the exit code, with a line on stderr where it is not 0."""
    arguments = parser.parse_args([" " + word if NEGATIVE.match(word) else word for word in words])
    with warnings.catch_warnings():
        warnings.simplefilter("default", NonsmoothWarning)  # a line on stderr, also where Python is told otherwise
        warnings.showwarning = show_warning  # type: ignore[assignment]
        try:
            with ended_by_ctrl_c():
                code = arguments.act(arguments)
            sys.stdout.flush()
            return code
        except BrokenPipeError:  # the reader of our output has left, as `| head` does
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        except FileFailure as error:
            complain(str(error))
            return NOT_WRITTEN
        except (InvalidInput, MissingExtra, UnsupportedVersion, OSError) as error:
            complain(str(error))
            return BAD_INPUT
        except MemoryError:
            complain("there is not enough memory for this run; record less (--every), stop earlier, or make it smaller")
            return BAD_INPUT
        except NonsmoothError as error:
            complain(str(error))
            return FAILED
        except KeyboardInterrupt:
            complain("interrupted")
            return INTERRUPTED


def build_parser() -> argparse.ArgumentParser:
    """Every command with its options."""
    parser = Parser(prog="nonsmooth", description="Nonsmooth mechanics with every paradox named.")
    parser.add_argument("--version", action="version", version=f"nonsmooth {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    listing = commands.add_parser("list", help="the models, with their parameters and states")
    listing.set_defaults(act=act_list)
    listing.add_argument("files", nargs="*", metavar="FILE.py", type=Path, help="the models of these files instead")

    add_run(commands.add_parser("run", help="simulate a model", epilog="Numbers may be typed as 1e-3, pi/4, -2*pi."))

    add_scene(commands.add_parser("scene", help="simulate a scene of bodies, or show a saved run of one"))
    add_classify(commands.add_parser("classify", help="find every set of contact forces that fits a state"))
    add_map(commands.add_parser("map", help="map the numbers of solutions over states and parameters"))

    solve = commands.add_parser("solve", help="solve contact and complementarity problems from files")
    solve.set_defaults(act=act_solve)
    solve.add_argument("files", nargs="+", metavar="FILE", type=Path, help=".npz or FCLIB .hdf5")
    solve.add_argument("--solver", default="auto", metavar="NAME[,NAME]", help="solvers; auto by default")
    solve.add_argument("--tol", type=number, default=1e-8, help="largest accepted error; 1e-8 by default")
    solve.add_argument("--max-time", type=number, metavar="T", help="wall time for a friction problem [s]")
    solve.add_argument("--plot", type=Path, metavar="FILE", help="draw a performance profile")

    add_studies(commands.add_parser("study", help="study a model").add_subparsers(required=True, metavar="STUDY"))
    add_sweep(commands.add_parser("sweep", help="run a model at every combination of some axes"))
    add_completion(commands.add_parser("completion", help="print what a shell needs to complete words by Tab"), parser)
    return parser


def act_list(arguments: argparse.Namespace) -> int:
    """``nonsmooth list``."""
    from nonsmooth.catalogue.entries import load_entry, model_entries, scene_entries
    from nonsmooth.catalogue.files import found_in, load_file

    refused: dict[str, list[str]] = {}
    for file in arguments.files:
        for name, model in found_in(load_file(str(file))).items():
            describe(f"{file}:{name}", model)
    for entry in [] if arguments.files else [*model_entries().values(), *scene_entries().values()]:
        try:
            describe(entry.name, load_entry(entry))
        except InvalidInput as error:
            refused.setdefault(entry.module.split(".")[0], []).append(str(error))
    for package, errors in refused.items():
        more = f" (and {len(errors) - 1} more of the package {package})" if len(errors) > 1 else ""
        complain(f"{errors[0]}{more}")
    return 0


def describe(name: str, model: Any) -> None:
    """A model or a scene with its parameters and the variables of its state."""
    import inspect

    from nonsmooth.checks.parameters import numeric_fields
    from nonsmooth.commands.typed_model import made
    from nonsmooth.mechanics.start import describing, state_function, variables_of
    from nonsmooth.mechanics.system import System
    from nonsmooth.scenes.scene import Scene

    instance = made(model) if isinstance(model, type) else model
    is_bare = isinstance(instance, System | Scene)
    said = repr(instance) if is_bare else inspect.getdoc(model) or "no description"
    print(f"{name:18} {said.splitlines()[0]}")
    if isinstance(instance, Scene):
        return
    values = numeric_fields(describing(instance))
    print(f"{'':18} --set   ", "  ".join(f"{key}={value:.6g}" for key, value in values.items()))
    if is_bare or hasattr(instance, "state"):
        print(f"{'':18} --state ", "  ".join(variables_of(state_function(instance))))


def act_solve(arguments: argparse.Namespace) -> int:
    """``nonsmooth solve``."""
    from nonsmooth.commands.solve_files import format_table, performance_profile, solve_files

    require_writable(arguments.plot, FIGURE_ENDINGS)
    if arguments.plot:
        require_module("matplotlib", "plot", "figures")
    results: dict[str, list[dict]] = {name: [] for name in arguments.solver.split(",")}

    def tables() -> str:
        return "\n\n".join(format_table(rows) for rows in results.values() if rows)

    try:
        with last_words(tables):
            for name, rows in results.items():
                for file in arguments.files:
                    rows += solve_files([file], name, arguments.tol, arguments.max_time)
    except KeyboardInterrupt:
        print(tables())
        raise
    print(tables())
    if arguments.plot:
        performance_profile(results, arguments.plot)
        print(f"figure: {arguments.plot}")
    return 0 if all(row["status"] == "SOLVED" for rows in results.values() for row in rows) else FAILED
