"""``nonsmooth run``: simulate a model or a scene, print, draw and save."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.checks.files import ANIMATION_ENDINGS, FIGURE_ENDINGS, PAGE_ENDINGS
from nonsmooth.commands.integrators import add_integrator, new_integrator
from nonsmooth.commands.outputs import (
    Options,
    add_drawn,
    add_printed,
    add_progress,
    add_saved,
    progress_of_run,
)
from nonsmooth.commands.terminal import FAILED, complain, figure_path
from nonsmooth.commands.typed_input import (
    initial_state,
    number,
    require_module,
    require_writable,
    whole_number,
    without_nan,
)
from nonsmooth.commands.typed_model import MODEL, is_scene, typed_model
from nonsmooth.errors import INTERRUPTED, InvalidInput
from nonsmooth.results.failures import StepFailure

if TYPE_CHECKING:
    from nonsmooth.results.recorded import Kinds

SOLUTION_ENDINGS = (".npz", ".h5", ".hdf5", ".nc")
PROBLEM_ENDINGS = (".npz", ".hdf5", ".h5")
UNNAMED = Path(".html")  # code: of a player whose file was not named
PICTURED = 6  # chosen: instants of a picture, which fill two rows of three


def add_run(run: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth run``, in groups."""
    run.set_defaults(act=act_run, suffix="")
    run.usage = "%(prog)s MODEL [OPTION ...]"
    run.add_argument("model", metavar="MODEL", help=MODEL)
    add_start(run.add_argument_group("the model and its start"))
    add_method(run.add_argument_group("the integrator"))
    add_length(run.add_argument_group("how long it runs, and how it goes on"))
    add_results(run.add_argument_group("what is recorded, saved and drawn"))
    printed = run.add_argument_group("what is printed")
    add_progress(printed)
    add_printed(printed)


def add_start(options: Options) -> None:
    """What is set in motion, and from where."""
    for option, what in (("--set", "parameters, e.g. mu=2 l=1/2"), ("--state", "initial state, e.g. th=pi/4 thdot=0")):
        options.add_argument(option, nargs="+", action="extend", default=[], metavar="NAME=VALUE", help=what)
    options.add_argument("--q0", nargs="+", type=number, metavar="Q", help="initial coordinates (with --u0)")
    options.add_argument("--u0", nargs="+", type=number, metavar="U", help="initial velocities (with --q0)")
    options.add_argument(
        "--project", action="store_true", help="move an inadmissible start to the nearest admissible one"
    )


def add_method(options: Options) -> None:
    """How a step is made, and which solution it takes."""
    add_integrator(options, may_choose=True)
    options.add_argument(
        "--selection", default="compliant-limit", metavar="RULE",
        help="which solution is taken where there are several: compliant-limit (default), lift-off or impact",
    )  # fmt: skip
    options.add_argument(
        "--threads", type=whole_number, default=1, metavar="N",
        help="of a scene: threads that solve its islands at once, to the same bits; 1 by default",
    )  # fmt: skip


def add_length(options: Options) -> None:
    """Where a run ends, what stops it sooner, and how it is gone on with."""
    options.add_argument("--t-end", type=number, metavar="T", help="end [s]; the model's own by default")
    options.add_argument("--max-steps", type=whole_number, metavar="N", help="the most steps that the run may take")
    options.add_argument("--max-wall-time", type=number, metavar="S", help="the most seconds that it may take")
    options.add_argument("--checkpoint", type=Path, metavar="FOLDER", help="write records there as the run goes")
    options.add_argument("--resume", type=Path, metavar="FOLDER", help="go on with the checkpoint of this same run")
    options.add_argument(
        "--checkpoint-every", type=number, default=10.0, metavar="S",
        help="seconds between two states that are kept; 10 by default",
    )  # fmt: skip


def add_results(options: Options) -> None:
    """What is kept of a run, and where."""
    options.add_argument("--every", type=whole_number, default=1, metavar="N", help="record every N steps")
    options.add_argument("--t-eval", nargs="+", type=number, metavar="T", help="record at these times [s] instead")
    options.add_argument(
        "--record", nargs="+", metavar="KIND",
        help="what is recorded: coordinates, velocities, gaps, impulses, modes, ledger, events; of a scene bodies, "
        "contacts, ledger, events, pairs; or motion",
    )  # fmt: skip
    add_saved(options, "save the solution (.npz, .h5 or .nc)")
    options.add_argument(
        "--dump-failure", type=Path, metavar="FILE",
        help="if a step fails, save its contact problem for `nonsmooth solve` (.npz, or FCLIB's .hdf5)",
    )  # fmt: skip
    add_drawn(options, "where to draw; MODEL.png by default")
    add_pictures(options)
    options.add_argument("--live", action="store_true", help="show the run in a browser while it goes on")


def add_pictures(options: Options) -> None:
    """--panels, of the histories, and --picture, --animate, --view: the bodies themselves."""
    options.add_argument(
        "--panels", nargs="+", metavar="NAME",
        help="what the figure shows: 'phase plane', coordinates, velocities, energy, forces, impulses, modes; of a "
        "scene bodies, energy, speeds, contacts, accuracy; all that there are by default",
    )  # fmt: skip
    options.add_argument("--picture", type=Path, metavar="FILE", help="draw the bodies at some instants")
    options.add_argument("--animate", type=Path, metavar="FILE", help="write an animation (.gif, .webp or .mp4)")
    options.add_argument(
        "--view", type=Path, nargs="?", const=UNNAMED, metavar="FILE.html",
        help="write a player that any browser opens; MODEL.html by default",
    )  # fmt: skip


def act_run(arguments: argparse.Namespace) -> int:
    """``nonsmooth run``."""
    model = typed_model(arguments, takes_scenes=True)
    figure = require_outputs(model, arguments)
    return act_on(simulate_runnable(model, arguments), arguments, figure)


def require_outputs(model: Any, arguments: argparse.Namespace) -> Path | None:
    """Raise before the run for options that do not fit and files that could not be written; the path of the figure."""
    from nonsmooth.results.recorded import KINDS_OF_SCENE, KINDS_OF_SYSTEM

    of_scene = is_scene(model)
    require_kinds(KINDS_OF_SCENE if of_scene else KINDS_OF_SYSTEM, arguments)
    if arguments.view == UNNAMED:
        arguments.view = Path(f"{arguments.model}.html")
    require_files(arguments)
    require_writable(arguments.dump_failure, PROBLEM_ENDINGS)
    if arguments.dump_failure and arguments.dump_failure.suffix != ".npz":
        require_module("h5py", "io", "FCLIB files")
    if arguments.live:
        require_module("viser", "live", "live views")
    is_drawn = arguments.picture or arguments.animate or arguments.view or arguments.live
    if is_drawn and not of_scene and not has_shape(model):
        raise InvalidInput(
            f"the model {arguments.model} has no shape(q) to draw: give it one, as System(shape=...), or leave "
            "--picture, --animate, --view, --live out"
        )
    figure = figure_path(arguments)
    require_panels(arguments.panels, of_scene, figure)
    return figure


def require_kinds(kinds_of_run: Kinds, arguments: argparse.Namespace) -> None:
    """Raise `InvalidInput` for a --record of what no such run records, and for drawings of what it leaves out.

    The figure that is drawn unasked is left out where it would be empty."""
    kinds = set(kinds_of_run.chosen(arguments.record))
    arguments.no_plot = arguments.no_plot or not (arguments.plot or kinds & set(kinds_of_run.plotted))
    needs = {"plot": kinds_of_run.plotted, **dict.fromkeys(("picture", "animate", "view"), (kinds_of_run.drawn,))}
    for option, needed in needs.items():
        if getattr(arguments, option) and not kinds & set(needed):
            raise InvalidInput(
                f"--{option} needs {' or '.join(needed)}, which --record leaves out; add them, or leave --{option} out"
            )


def require_panels(panels: list[str] | None, of_scene: bool, figure: Path | None) -> None:
    """Raise for --panels without a figure, and for a name that no figure of such a run has."""
    if panels is None:
        return
    from nonsmooth.drawing import plots, scene_histories

    plots.asked_for(panels, scene_histories.PANELS if of_scene else plots.PANELS)
    if figure is None:
        raise InvalidInput("--panels chooses what --plot draws; give --plot FILE")


def require_files(arguments: argparse.Namespace) -> None:
    """Raise for files of a solution or of its bodies that could not be written."""
    require_writable(arguments.out, SOLUTION_ENDINGS)
    if arguments.out and arguments.out.suffix == ".nc":
        require_module("xarray", "data", ".nc files")
        require_module("netCDF4", "data", ".nc files")
    elif arguments.out and arguments.out.suffix != ".npz":
        require_module("h5py", "io", ".h5 files")
    require_writable(arguments.picture, FIGURE_ENDINGS)
    require_writable(arguments.animate, ANIMATION_ENDINGS)
    require_writable(arguments.view, PAGE_ENDINGS)
    if arguments.picture or arguments.animate:
        require_module("matplotlib", "plot", "pictures")
        require_module("PIL", "plot", "animations")


def act_on(solution: Any, arguments: argparse.Namespace, figure: Path | None) -> int:
    """Save, draw and tell a run; the exit code."""
    if arguments.out:
        solution.save(arguments.out)
    if solution.status.name == "INTERRUPTED":  # who ends a run waits for no drawing; what is saved can be drawn later
        report(solution, arguments, {})
        complain(f"{solution.message}; nothing is drawn")
        return INTERRUPTED
    report(solution, arguments, draw(solution, arguments, figure))
    if solution.success:
        return 0
    complain(solution.message)
    return FAILED


def draw(solution: Any, arguments: argparse.Namespace, figure: Path | None) -> dict[str, Path | None]:
    """Draw what was asked for; the files by what they are."""
    figure = draw_histories(solution, figure, arguments.panels)
    if arguments.picture:
        solution.picture(arguments.picture, n=PICTURED)
    if arguments.animate:
        solution.animate(arguments.animate)
    if arguments.view:
        solution.view(arguments.view)
    return {
        "figure": figure, "picture": arguments.picture, "animation": arguments.animate, "player": arguments.view,
    }  # fmt: skip


def draw_histories(solution: Any, figure: Path | None, panels: list[str] | None) -> Path | None:
    """Draw the figure; where it was asked for a panel of what did not happen, say so. The file that was written."""
    if figure is None:
        return None
    try:
        solution.plot(figure, panels)
    except InvalidInput as reason:
        if panels is None:
            raise
        complain(f"{figure} is not written: {reason}")
        return None
    return figure


def has_shape(model: Any) -> bool:
    """Whether there is something to draw."""
    from nonsmooth.mechanics.model_system import as_system

    return as_system(model).described.shape is not None


def simulate_runnable(model: Any, arguments: argparse.Namespace) -> Any:
    """The run with the options of the command line; a failure comes back as a partial solution, and its contact problem
    is written if that is wanted."""
    from nonsmooth.mechanics.start import own_time
    from nonsmooth.runs.simulate import simulate_at_once

    start = start_of_run(model, arguments)
    integrator = new_integrator(arguments, model)
    t_end = own_time(model, "t_end") if arguments.t_end is None else arguments.t_end
    if t_end is None:
        raise InvalidInput(f"the model {arguments.model} has no t_end of its own; give --t-end")
    try:
        return simulate_at_once(
            model, (0.0, t_end), *start, integrator=integrator, every=arguments.every, t_eval=arguments.t_eval,
            selection=arguments.selection, project=arguments.project, max_steps=arguments.max_steps,
            max_wall_time=arguments.max_wall_time, progress=progress_of_run(arguments),
            checkpoint=arguments.checkpoint, resume=arguments.resume, checkpoint_every=arguments.checkpoint_every,
            view=arguments.live, record=arguments.record, threads=arguments.threads,
        )  # fmt: skip
    except StepFailure as failure:
        if arguments.dump_failure:
            dump(failure, arguments.dump_failure)
        return failure.solution


def start_of_run(model: Any, arguments: argparse.Namespace) -> tuple[Any, ...]:
    """The q0 and u0 of a model; none of a scene, whose bodies have their own: options of them raise `InvalidInput`."""
    if not is_scene(model):
        return initial_state(model, arguments)
    for option in ("state", "q0", "u0"):
        if getattr(arguments, option):
            raise InvalidInput(f"--{option} is no option for {arguments.model}, a scene of bodies; leave it out")
    return ()


def dump(failure: StepFailure, path: Path) -> None:
    """The contact problem of the step, or a line that says why it is not written."""
    if failure.problem is None:
        complain(f"{path} is not written: no contact problem was being solved")
        return
    try:
        failure.dump(path)
    except InvalidInput as reason:
        complain(f"{path} is not written: {reason}")


def report(solution: Any, arguments: argparse.Namespace, drawn: dict[str, Path | None]) -> None:
    """The outcome on stdout."""
    if arguments.json:
        from nonsmooth.commands.results_of_runs import as_json

        print(json.dumps(without_nan(as_json(solution, arguments.t_eval is not None)), allow_nan=False))
    elif not arguments.quiet:
        print(solution.summary())
        written = {
            "solution": arguments.out, **drawn, "checkpoint": arguments.checkpoint or arguments.resume,
        }  # fmt: skip
        for what, path in written.items():
            if path:
                print(f"{what}: {path}")
