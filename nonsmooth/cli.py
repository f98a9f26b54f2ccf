"""The command line: ``nonsmooth list | run | solve | bench``. Arguments in, library calls, text and files out.

Exit codes: 0 done; 2 bad input; 3 the integration failed (what was computed is saved and summarised); 130 interrupted.
"""

from __future__ import annotations

import argparse
import ast
import json
import math
import operator
import os
import sys
from pathlib import Path
from typing import Any

from nonsmooth import __version__
from nonsmooth.errors import InvalidInput, MissingExtra, NonsmoothError

OPERATORS: dict[type, Any] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}


def main(argv: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    arguments = build_parser().parse_args(argv)
    try:
        return arguments.act(arguments)
    except (InvalidInput, MissingExtra) as error:
        print(f"nonsmooth: {error}", file=sys.stderr)
        return 2
    except NonsmoothError as error:
        print(f"nonsmooth: {error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        print("nonsmooth: interrupted", file=sys.stderr)
        return 130


def build_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="nonsmooth", description="Nonsmooth mechanics with every paradox named.")
    parser.add_argument("--version", action="version", version=f"nonsmooth {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    listing = commands.add_parser("list", help="the models, with their parameters")
    listing.set_defaults(act=act_list)

    run = commands.add_parser("run", help="simulate a model")
    run.set_defaults(act=act_run)
    run.add_argument("model", help="a name of `nonsmooth list`")
    run.add_argument("--set", nargs="+", default=[], metavar="NAME=VALUE", help="parameters, e.g. mu=2 l=1/2")
    run.add_argument("--state", nargs="+", default=[], metavar="NAME=VALUE", help="initial state, e.g. th=pi/4 thdot=0")
    run.add_argument("--q0", nargs="+", type=number, metavar="Q", help="initial coordinates (with --u0)")
    run.add_argument("--u0", nargs="+", type=number, metavar="U", help="initial velocities (with --q0)")
    run.add_argument("--t-end", type=number, metavar="T", help="end [s]; the model's own by default")
    run.add_argument("--dt", type=number, help="step [s]; the model's own by default")
    run.add_argument("--theta", type=number, default=0.5, help="weight of the new velocity, 0.5 to 1")
    run.add_argument("--every", type=int, default=1, metavar="N", help="record every N steps")
    run.add_argument("--selection", default="compliant-limit", help="compliant-limit, lift-off or impact")
    run.add_argument(
        "--project", action="store_true", help="move an inadmissible start to the nearest admissible state"
    )
    run.add_argument("--projection", action="store_true", help="move positions back to the surfaces after each step")
    run.add_argument("--out", type=Path, metavar="FILE", help="save the solution (.npz or .h5)")
    run.add_argument("--plot", type=Path, metavar="FILE", help="where to draw; MODEL.png by default")
    run.add_argument("--no-plot", action="store_true", help="draw nothing")
    run.add_argument("--animate", type=Path, metavar="FILE.gif", help="write an animation")
    run.add_argument("--json", action="store_true", help="print one JSON object instead of the summary")

    solve = commands.add_parser("solve", help="solve contact and complementarity problems from files")
    solve.set_defaults(act=act_solve)
    solve.add_argument("files", nargs="+", metavar="FILE", help=".npz or FCLIB .hdf5")
    solve.add_argument("--solver", default="auto")
    solve.add_argument("--tol", type=number, default=1e-8)
    solve.add_argument("--plot", type=Path, metavar="FILE", help="draw a performance profile")

    bench = commands.add_parser("bench", help="measure run times")
    bench.set_defaults(act=act_bench)
    bench.add_argument("what", choices=["core"])
    return parser


def act_list(arguments: argparse.Namespace) -> int:
    from nonsmooth.catalogue import load_model, model_entries
    from nonsmooth.system import numeric_fields

    for name in model_entries():
        model = load_model(name)
        print(f"{name:18} {(model.__doc__ or '').strip().splitlines()[0]}")
        print(" " * 18, "  ".join(f"{key}={value:.6g}" for key, value in numeric_fields(model()).items()))
    return 0


def act_run(arguments: argparse.Namespace) -> int:
    from nonsmooth.catalogue import load_model
    from nonsmooth.errors import Status
    from nonsmooth.integrators.moreau_jean import MoreauJean
    from nonsmooth.simulation import simulate

    figure = figure_path(arguments)
    for path in (arguments.out, figure, arguments.animate):
        require_writable(path)
    model = build_model(load_model(arguments.model), assignments(arguments.set))
    q0, u0 = initial_state(model, arguments)
    dt = model.dt if arguments.dt is None else arguments.dt
    t_end = model.t_end if arguments.t_end is None else arguments.t_end
    solution = simulate(
        model, (0.0, t_end), q0, u0, integrator=MoreauJean(dt, arguments.theta, arguments.projection),
        every=arguments.every, selection=arguments.selection, project=arguments.project, on_failure="return",
        progress=show_progress if sys.stderr.isatty() else None,
    )  # fmt: skip
    if arguments.out:
        solution.save(arguments.out)
    if figure:
        solution.plot(figure)
    if arguments.animate:
        solution.animate(arguments.animate)
    print(json.dumps(as_json(solution)) if arguments.json else solution.summary())
    if figure and not arguments.json:
        print(f"figure: {figure}")
    return 0 if solution.success else 130 if solution.status == Status.INTERRUPTED else 3


def act_solve(arguments: argparse.Namespace) -> int:
    from nonsmooth.studies.solve_files import format_table, performance_profile, solve_files

    require_writable(arguments.plot)
    results = solve_files([Path(file) for file in arguments.files], solver=arguments.solver, tol=arguments.tol)
    print(format_table(results))
    if arguments.plot:
        performance_profile(results, arguments.plot)
    return 0


def act_bench(arguments: argparse.Namespace) -> int:
    import importlib

    return importlib.import_module(f"nonsmooth.bench.{arguments.what}").main([])


def figure_path(arguments: argparse.Namespace) -> Path | None:
    """Where to draw: what was asked for, else MODEL.png where Matplotlib is installed."""
    if arguments.no_plot:
        return None
    if arguments.plot:
        return arguments.plot
    import importlib.util

    if importlib.util.find_spec("matplotlib") is None:
        print('nonsmooth: no figure without Matplotlib; pip install "nonsmooth[plot]" brings it', file=sys.stderr)
        return None
    return Path(f"{arguments.model}.png")


def require_writable(path: Path | None) -> None:
    """Raise before the run when a file could not be written after it."""
    if path is None:
        return
    folder = path.parent
    if not folder.is_dir():
        raise InvalidInput(f"{str(path)!r} cannot be written: there is no folder {str(folder)!r}")
    if path.is_dir() or not os.access(path if path.exists() else folder, os.W_OK):
        raise InvalidInput(f"{str(path)!r} cannot be written; choose another path")


def build_model(model: Any, changes: dict[str, float]) -> Any:
    from nonsmooth.system import changed

    default = model()
    whole = {name: int(value) for name, value in changes.items() if isinstance(getattr(default, name, None), int)}
    return changed(default, {**changes, **whole})


def initial_state(model: Any, arguments: argparse.Namespace) -> tuple[Any, Any]:
    """q0 and u0 as given, or from the model's natural variables."""
    import inspect

    from nonsmooth.errors import UnknownName, nearest

    if (arguments.q0 is None) != (arguments.u0 is None):
        raise InvalidInput("--q0 and --u0 go together; one of them is missing")
    if arguments.q0 is not None:
        if arguments.state:
            raise InvalidInput("give either --state or --q0 and --u0; got both")
        return arguments.q0, arguments.u0
    values = assignments(arguments.state)
    known = inspect.signature(model.state).parameters
    for name in values:
        if name not in known:
            raise UnknownName(f"the state of this model has no variable {name!r}; {nearest(name, known)}")
    return model.state(**values)


def assignments(texts: list[str]) -> dict[str, float]:
    """NAME=VALUE texts as a dictionary."""
    pairs = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not sign:
            raise InvalidInput(f"a value is given as NAME=VALUE; got {text!r}")
        try:
            pairs[name] = number(value)
        except argparse.ArgumentTypeError as error:
            raise InvalidInput(f"{name} must be a number: {error}") from None
    return pairs


def number(text: str) -> float:
    """A number typed as arithmetic on numbers and pi: 1e-3, pi/4, -2*pi."""
    try:
        return float(_evaluate(ast.parse(text, mode="eval").body))
    except (SyntaxError, KeyError, TypeError, ValueError, ZeroDivisionError, OverflowError):
        raise argparse.ArgumentTypeError(f"{text!r} is no number (try 0.5, 1e-3 or pi/4)") from None


def _evaluate(node: Any) -> float:
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return node.value
    if isinstance(node, ast.Name):
        return {"pi": math.pi, "inf": math.inf, "nan": math.nan}[node.id]
    if isinstance(node, ast.UnaryOp):
        return OPERATORS[type(node.op)](_evaluate(node.operand))
    if isinstance(node, ast.BinOp):
        return OPERATORS[type(node.op)](_evaluate(node.left), _evaluate(node.right))
    raise ValueError(node)


def show_progress(done: float) -> None:
    print(f"\r{done:6.1%}", end="\n" if done >= 1 else "", file=sys.stderr, flush=True)


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
        "n_events": len(solution.event_rows),
        "paradoxes": [
            {**asdict(event), "kind": event.kind.name, "mode_before": event.mode_before.name,
             "mode_after": event.mode_after.name, "choice": event.choice}
            for event in solution.paradoxes
        ],
        "ledger": {name: float(column[-1]) for name, column in solution.ledger.items()},
        "about": solution.about,
    }  # fmt: skip
