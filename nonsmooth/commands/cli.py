"""The command line: ``nonsmooth COMMAND``, one of those that ``build_parser`` adds.

Arguments in, library calls, text and files out.

Exit codes: 0 done; 2 bad input; 3 the integration failed (what was computed is saved and summarised), or a problem file
was not solved; 4 a result could not be written; 130 interrupted.
"""

from __future__ import annotations

import argparse
import functools
import os
import sys
import warnings
from pathlib import Path

from nonsmooth import __version__
from nonsmooth.checks.files import FIGURE_ENDINGS
from nonsmooth.commands.completion import add_completion
from nonsmooth.commands.listing import add_list
from nonsmooth.commands.new import add_new
from nonsmooth.commands.outputs import add_printed, tell, tell_file
from nonsmooth.commands.paradoxes import add_classify, add_map
from nonsmooth.commands.run import add_run
from nonsmooth.commands.scene import add_scene
from nonsmooth.commands.show import add_show
from nonsmooth.commands.studies import add_studies
from nonsmooth.commands.sweep import add_sweep
from nonsmooth.commands.terminal import FAILED, NOT_WRITTEN, as_typed, complain, show_warning
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

AsWritten = argparse.RawDescriptionHelpFormatter  # lines of the examples stay lines
EXAMPLES = """examples:
  nonsmooth run sprag-slip
      from the model's own start to its own end; what happened is printed, and drawn in sprag-slip.png
  nonsmooth run painleve-rod --set mu=2 --state th=pi/3 thdot=6 --t-end 0.5 --out rod.npz
      another friction and another start; numbers may be typed as 1e-3, pi/4, -2*pi
  nonsmooth run box-stack --view
      a scene, as a player for the browser
  nonsmooth run my_rod.py:Rod --integrator adaptive --rtol 1e-8 --json
      a model of your own, with error control, for a script"""


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
    return perform(build_parser(), words)


def perform(parser: argparse.ArgumentParser, words: list[str]) -> int:
    """Parse some words and do what they ask for; the exit code, with a line on stderr where it is not 0."""
    arguments = parser.parse_args([" " + word if NEGATIVE.match(word) else word for word in words])
    options = arguments.options
    with warnings.catch_warnings():
        warnings.simplefilter("default", NonsmoothWarning)  # a line on stderr, also where Python has other filters
        warnings.showwarning = functools.partial(show_warning, options)
        try:
            with ended_by_ctrl_c():
                code = arguments.act(arguments)
            sys.stdout.flush()
            return code
        except BrokenPipeError:  # the reader of our output has left, as `| head` does
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        except FileFailure as error:
            complain(as_typed(str(error), options))
            return NOT_WRITTEN
        except (InvalidInput, MissingExtra, UnsupportedVersion, OSError) as error:
            complain(as_typed(str(error), options))
            return BAD_INPUT
        except MemoryError:
            complain("there is not enough memory for this run; record less (--every), stop earlier, or make it smaller")
            return BAD_INPUT
        except NonsmoothError as error:
            complain(as_typed(str(error), options))
            return FAILED
        except KeyboardInterrupt:
            complain("interrupted")
            return INTERRUPTED


def build_parser() -> argparse.ArgumentParser:
    """Every command with its options."""
    parser = Parser(prog="nonsmooth", description="Nonsmooth mechanics with every paradox named.")
    parser.add_argument("--version", action="version", version=f"nonsmooth {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    add_list(commands.add_parser("list", help="the models, with their parameters and states"))
    add_new(commands.add_parser("new", help="write a model that runs into a file, to begin your own with"))
    add_run(commands.add_parser("run", help="simulate a model or a scene", epilog=EXAMPLES, formatter_class=AsWritten))

    add_scene(commands.add_parser("scene", help="simulate a scene of bodies, or show a saved run of one"))
    add_show(commands.add_parser("show", help="print, draw and convert a saved run of a model or a scene"))
    add_classify(commands.add_parser("classify", help="find every set of contact forces that fits a state"))
    add_map(commands.add_parser("map", help="map the numbers of solutions over states and parameters"))

    solve = commands.add_parser("solve", help="solve contact and complementarity problems from files")
    solve.set_defaults(act=act_solve)
    solve.add_argument("files", nargs="+", metavar="FILE", type=Path, help=".npz or FCLIB .hdf5")
    solve.add_argument("--solver", default="auto", metavar="NAME[,NAME]", help="solvers; auto by default")
    solve.add_argument("--tol", type=number, default=1e-8, help="largest accepted error; 1e-8 by default")
    solve.add_argument("--max-time", type=number, metavar="T", help="wall time for a friction problem [s]")
    solve.add_argument("--plot", type=Path, metavar="FILE", help="draw a performance profile")
    add_printed(solve)

    add_studies(commands.add_parser("study", help="study a model").add_subparsers(required=True, metavar="STUDY"))
    add_sweep(commands.add_parser("sweep", help="run a model at every combination of some axes"))
    add_completion(commands.add_parser("completion", help="print what a shell needs to complete words by Tab"), parser)
    parser.describe()
    for _, command in parser.leaves():
        command.root = parser
    return parser


def act_solve(arguments: argparse.Namespace) -> int:
    """``nonsmooth solve``."""
    from nonsmooth.commands.solve_files import format_table, performance_profile, solve_files

    require_writable(arguments.plot, FIGURE_ENDINGS)
    if arguments.plot:
        require_module("matplotlib", "plot", "figures")
    results: dict[str, list[dict]] = {name: [] for name in arguments.solver.split(",")}

    def tables() -> str:
        return "\n\n".join(format_table(rows) for rows in results.values() if rows)

    def problems() -> dict:
        return {"problems": [row for rows in results.values() for row in rows]}

    try:
        with last_words(lambda: "" if arguments.json or arguments.quiet else tables()):
            for name, rows in results.items():
                for file in arguments.files:
                    rows += solve_files([file], name, arguments.tol, arguments.max_time)
    except KeyboardInterrupt:
        tell(arguments, tables, problems)
        raise
    tell(arguments, tables, problems)
    if arguments.plot:
        performance_profile(results, arguments.plot)
        tell_file(arguments, "figure", arguments.plot)
    found = [row for rows in results.values() for row in rows]
    if all(row["status"] == "ERROR" for row in found):
        raise InvalidInput("; ".join(dict.fromkeys(row["message"] for row in found)))
    return 0 if all(row["status"] == "SOLVED" for row in found) else FAILED
