"""The command line: ``nonsmooth list | run | classify | map | solve | study | sweep | bench``.

Arguments in, library calls, text and files out.

Exit codes: 0 done; 2 bad input; 3 the integration failed (what was computed is saved and summarised), or a problem file
was not solved; 130 interrupted.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import sys
import warnings
from pathlib import Path
from typing import Any

from nonsmooth import __version__
from nonsmooth.errors import InvalidInput, MissingExtra, NonsmoothError, NonsmoothWarning
from nonsmooth.limit_commands import add_limits, limit_study
from nonsmooth.paradox_commands import add_classify, add_map
from nonsmooth.sweep_command import add_sweep
from nonsmooth.typed_input import (
    BAD_INPUT,
    FIGURE_ENDINGS,
    NEGATIVE,
    Parser,
    assignments,
    build_model,
    initial_state,
    number,
    ranges,
    require_module,
    require_writable,
    whole_number,
    without_nan,
)

FAILED, INTERRUPTED = 3, 130
SOLUTION_ENDINGS = (".npz", ".h5", ".hdf5")
ANIMATION_ENDINGS = (".gif", ".webp")


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
    texts = sys.argv[1:] if argv is None else argv
    arguments = build_parser().parse_args([" " + text if NEGATIVE.match(text) else text for text in texts])
    with warnings.catch_warnings():
        warnings.showwarning = show_warning  # type: ignore[assignment]
        try:
            code = arguments.act(arguments)
            sys.stdout.flush()
            return code
        except BrokenPipeError:  # the reader of our output has left, as `| head` does
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        except (InvalidInput, MissingExtra, OSError) as error:
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

    add_run(commands.add_parser("run", help="simulate a model", epilog="Numbers may be typed as 1e-3, pi/4, -2*pi."))

    add_classify(commands.add_parser("classify", help="find every set of contact forces that fits a state"))
    add_map(commands.add_parser("map", help="map the numbers of solutions over states and parameters"))

    solve = commands.add_parser("solve", help="solve contact and complementarity problems from files")
    solve.set_defaults(act=act_solve)
    solve.add_argument("files", nargs="+", metavar="FILE", type=Path, help=".npz or FCLIB .hdf5")
    solve.add_argument("--solver", default="auto", metavar="NAME[,NAME]", help="solvers; auto by default")
    solve.add_argument("--tol", type=number, default=1e-8, help="largest accepted error; 1e-8 by default")
    solve.add_argument("--plot", type=Path, metavar="FILE", help="draw a performance profile")

    studies = commands.add_parser("study", help="study a model").add_subparsers(required=True, metavar="STUDY")
    add_stability(studies.add_parser("stability", help="steady sliding: eigenvalues, and their change with parameters"))
    add_limits(studies, act_limit)
    add_sweep(commands.add_parser("sweep", help="run a model at every combination of some axes"))

    bench = commands.add_parser("bench", help="measure run times")
    bench.set_defaults(act=act_bench)
    bench.add_argument("what", choices=["core", "paradox", "penalty", "solvers", "sweep"])
    bench.add_argument("files", nargs="*", help="solvers: also time the problems in these files")
    return parser


def add_run(run: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth run``."""
    run.set_defaults(act=act_run)
    run.add_argument("model", metavar="MODEL", help="a name of `nonsmooth list`")
    for option, what in (("--set", "parameters, e.g. mu=2 l=1/2"), ("--state", "initial state, e.g. th=pi/4 thdot=0")):
        run.add_argument(option, nargs="+", action="extend", default=[], metavar="NAME=VALUE", help=what)
    run.add_argument("--q0", nargs="+", type=number, metavar="Q", help="initial coordinates (with --u0)")
    run.add_argument("--u0", nargs="+", type=number, metavar="U", help="initial velocities (with --q0)")
    run.add_argument("--t-end", type=number, metavar="T", help="end [s]; the model's own by default")
    run.add_argument("--dt", type=number, help="step [s]; the model's own by default")
    run.add_argument("--theta", type=number, default=0.5, help="weight of the new velocity, 0.5 (default) to 1")
    run.add_argument("--every", type=whole_number, default=1, metavar="N", help="record every N steps")
    run.add_argument("--t-eval", nargs="+", type=number, metavar="T", help="record at these times [s] instead")
    run.add_argument(
        "--selection", default="compliant-limit", metavar="RULE",
        help="which solution is taken where there are several: compliant-limit (default), lift-off or impact",
    )  # fmt: skip
    run.add_argument("--project", action="store_true", help="move an inadmissible start to the nearest admissible one")
    run.add_argument("--projection", action="store_true", help="move positions back to the surfaces after each step")
    run.add_argument("--out", type=Path, metavar="FILE", help="save the solution (.npz or .h5)")
    run.add_argument("--plot", type=Path, metavar="FILE", help="where to draw; MODEL.png by default")
    run.add_argument("--no-plot", action="store_true", help="draw nothing")
    run.add_argument("--picture", type=Path, metavar="FILE", help="draw the scene at five instants")
    run.add_argument("--animate", type=Path, metavar="FILE.gif", help="write an animation")
    run.add_argument("--json", action="store_true", help="print one JSON object, and draw only what was asked for")
    run.add_argument("--quiet", action="store_true", help="print neither progress nor summary")


def add_stability(study: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth study stability``."""
    study.set_defaults(act=act_stability, json=False)
    study.add_argument("model", metavar="MODEL", help="a name of `nonsmooth list`")
    study.add_argument("--set", nargs="+", action="extend", default=[], metavar="NAME=VALUE", help="parameters")
    study.add_argument(
        "--vary", nargs="+", action="extend", default=[], metavar="NAME=LOW:HIGH:N",
        help="follow the eigenvalues along a parameter, or map the stability over two",
    )  # fmt: skip
    study.add_argument("--plot", type=Path, metavar="FILE", help="where to draw; MODEL.png by default")
    study.add_argument("--no-plot", action="store_true", help="draw nothing")


def act_list(arguments: argparse.Namespace) -> int:
    """``nonsmooth list``."""
    import inspect

    from nonsmooth.catalogue import load_model, model_entries
    from nonsmooth.system import numeric_fields

    for name in model_entries():
        try:
            model = load_model(name)
        except InvalidInput as error:
            complain(str(error))
            continue
        variables = inspect.signature(model.state).parameters if hasattr(model, "state") else ()
        print(f"{name:18} {(inspect.getdoc(model) or 'no description').splitlines()[0]}")
        print(f"{'':18} --set   ", "  ".join(f"{key}={value:.6g}" for key, value in numeric_fields(model()).items()))
        print(f"{'':18} --state ", "  ".join(str(key) for key in variables if key != "self"))
    return 0


def act_run(arguments: argparse.Namespace) -> int:
    """``nonsmooth run``."""
    from nonsmooth.catalogue import load_model

    model = build_model(load_model(arguments.model), assignments("--set", arguments.set))
    require_writable(arguments.out, SOLUTION_ENDINGS)
    if arguments.out and arguments.out.suffix != ".npz":
        require_module("h5py", "io", ".h5 files")
    require_writable(arguments.picture, FIGURE_ENDINGS)
    require_writable(arguments.animate, ANIMATION_ENDINGS)
    if arguments.picture or arguments.animate:
        require_module("matplotlib", "plot", "pictures")
        require_module("PIL", "plot", "animations")
        if not hasattr(model, "shape"):
            raise InvalidInput(f"the model {arguments.model} has no shape(q) to draw; leave --picture, --animate out")
    figure = figure_path(arguments)
    q0, u0 = initial_state(model, arguments)
    solution = simulate_model(model, q0, u0, arguments)
    if arguments.out:
        solution.save(arguments.out)
    if figure:
        solution.plot(figure)
    if arguments.picture:
        solution.picture(arguments.picture)
    if arguments.animate:
        solution.animate(arguments.animate)
    report(solution, arguments, figure)
    if solution.success:
        return 0
    complain(solution.message)
    return INTERRUPTED if solution.status.name == "INTERRUPTED" else FAILED


def simulate_model(model: Any, q0: Any, u0: Any, arguments: argparse.Namespace) -> Any:
    """The run with the options of the command line; a failure comes back as a partial solution."""
    from nonsmooth.integrators.moreau_jean import MoreauJean
    from nonsmooth.simulation import simulate

    dt = getattr(model, "dt", None) if arguments.dt is None else arguments.dt
    t_end = getattr(model, "t_end", None) if arguments.t_end is None else arguments.t_end
    if dt is None or t_end is None:
        raise InvalidInput(f"the model {arguments.model} has no t_end and dt of its own; give --t-end and --dt")
    has_progress = sys.stderr.isatty() and not arguments.quiet
    integrator = MoreauJean(dt, arguments.theta, arguments.projection)
    solution = simulate(
        model, (0.0, t_end), q0, u0, integrator=integrator, every=arguments.every, t_eval=arguments.t_eval,
        selection=arguments.selection, project=arguments.project, on_failure="return",
        progress=show_progress if has_progress else None,
    )  # fmt: skip
    if has_progress:
        print("\r\033[K", end="", file=sys.stderr, flush=True)
    return solution


def report(solution: Any, arguments: argparse.Namespace, figure: Path | None) -> None:
    """The outcome on stdout."""
    if arguments.json:
        print(json.dumps(without_nan(as_json(solution)), allow_nan=False))
    elif not arguments.quiet:
        print(solution.summary())
        written = {
            "solution": arguments.out,
            "figure": figure,
            "picture": arguments.picture,
            "animation": arguments.animate,
        }
        for what, path in written.items():
            if path:
                print(f"{what}: {path}")


def act_solve(arguments: argparse.Namespace) -> int:
    """``nonsmooth solve``."""
    from nonsmooth.studies.solve_files import format_table, performance_profile, solve_files

    require_writable(arguments.plot, FIGURE_ENDINGS)
    if arguments.plot:
        require_module("matplotlib", "plot", "figures")
    results = {name: solve_files(arguments.files, name, arguments.tol) for name in arguments.solver.split(",")}
    print("\n\n".join(format_table(rows) for rows in results.values()))
    if arguments.plot:
        performance_profile(results, arguments.plot)
        print(f"figure: {arguments.plot}")
    return 0 if all(row["status"] == "SOLVED" for rows in results.values() for row in rows) else FAILED


def act_stability(arguments: argparse.Namespace) -> int:
    """``nonsmooth study stability``."""
    from nonsmooth.catalogue import load_model
    from nonsmooth.studies.stability import study_stability

    model = build_model(load_model(arguments.model), assignments("--set", arguments.set))
    axes = ranges("--vary", arguments.vary)
    figure = figure_path(arguments) if axes else None
    study = study_stability(model, axes)
    print(study.text)
    if figure and study.draw:
        study.draw(figure)
        print(f"figure: {figure}")
    return 0


def act_limit(arguments: argparse.Namespace) -> int:
    """``nonsmooth study penalty`` and ``nonsmooth study convergence``."""
    figure = figure_path(arguments)
    study = limit_study(arguments)
    print(study.table())
    if figure:
        study.plot(figure)
        print(f"figure: {figure}")
    return 0


def act_bench(arguments: argparse.Namespace) -> int:
    """``nonsmooth bench``."""
    return importlib.import_module(f"nonsmooth.bench.{arguments.what}").main(arguments.files) or 0


def figure_path(arguments: argparse.Namespace) -> Path | None:
    """Where to draw: what was asked for, else MODEL.png where it can be drawn."""
    if arguments.no_plot:
        if arguments.plot:
            raise InvalidInput("give either --plot or --no-plot; got both")
        return None
    if arguments.plot:
        require_writable(arguments.plot, FIGURE_ENDINGS)
        require_module("matplotlib", "plot", "figures")
        return arguments.plot
    if arguments.json:
        return None
    figure = Path(f"{arguments.model}.png")
    try:
        require_module("matplotlib", "plot", "figures")
        require_writable(figure, FIGURE_ENDINGS)
    except (MissingExtra, InvalidInput) as error:
        complain(f"no figure will be drawn: {error}")
        return None
    return figure


def show_progress(done: float) -> None:
    """A line that is written over."""
    print(f"\r{done:6.1%}", end="", file=sys.stderr, flush=True)


def show_warning(message: Warning | str, category: type[Warning], *_: Any) -> None:
    """A warning of ours as one line; those of other packages say nothing to a user of the command line."""
    if issubclass(category, NonsmoothWarning):
        complain(f"warning: {message}")


def complain(text: str) -> None:
    """One line on stderr."""
    print(f"nonsmooth: {text}", file=sys.stderr)


def as_json(solution: Any) -> dict[str, Any]:
    """What a script wants to know of a run."""
    from dataclasses import asdict

    return {
        "status": solution.status.name,
        "message": solution.message,
        "t": float(solution.t[-1]),
        "q": solution.q[-1].tolist(),
        "u": solution.u[-1].tolist(),
        "stats": asdict(solution.stats),
        "events": [event_as_json(event) for event in solution.events],
        "paradoxes": [event_as_json(event) for event in solution.paradoxes],
        "ledger": {name: float(column[-1]) for name, column in solution.ledger.items()},
        "about": solution.about,
    }


def event_as_json(event: Any) -> dict[str, Any]:
    """An event with its kinds and modes by name."""
    from dataclasses import asdict
    from enum import IntEnum

    fields = {key: value.name if isinstance(value, IntEnum) else value for key, value in asdict(event).items()}
    return fields | ({"choice": event.choice} if hasattr(event, "choice") else {})
