"""``nonsmooth show``: what a saved run says, drawn and saved in other forms; nothing is run."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from nonsmooth.catalogue.entries import load
from nonsmooth.catalogue.files import from_file, is_file
from nonsmooth.checks.files import FIGURE_ENDINGS
from nonsmooth.commands.outputs import add_drawn, add_printed, add_saved
from nonsmooth.commands.run import UNNAMED, add_pictures, draw, report, require_files, require_panels
from nonsmooth.commands.typed_input import require_module, require_writable
from nonsmooth.commands.typed_model import parameter_of, with_set
from nonsmooth.errors import InvalidInput


def add_show(show: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth show``."""
    show.set_defaults(act=act_show, live=False, t_eval=None, checkpoint=None, resume=None)
    show.add_argument("file", metavar="FILE", type=Path, help="a saved run (.npz, .h5 or .nc), or a checkpoint")
    show.add_argument("--model", metavar="MODEL", help="what was run, where the file does not name it, as for pictures "
                      "of a scene; its parameters are those of the file")  # fmt: skip
    add_saved(show, "save it again, in another form (.npz, .h5 or .nc)")
    add_drawn(show, "draw its histories; nothing by default")
    add_pictures(show)
    add_printed(show)


def act_show(arguments: argparse.Namespace) -> int:
    """``nonsmooth show``."""
    if arguments.view == UNNAMED:
        arguments.view = Path(f"{arguments.file.stem}.html")
    require_files(arguments)
    require_writable(arguments.plot, FIGURE_ENDINGS)
    if arguments.plot:
        require_module("matplotlib", "plot", "figures")
    solution, is_scene = saved_run(arguments.file, arguments.model)
    if is_scene and not arguments.model and (arguments.picture or arguments.animate or arguments.view):
        raise InvalidInput(f"{arguments.file.name} holds the motion of a scene and not its shapes: give --model NAME")
    figure = None if arguments.no_plot else arguments.plot
    require_panels(arguments.panels, is_scene, figure)
    if arguments.out:
        solution.save(arguments.out)
    report(solution, arguments, draw(solution, arguments, figure))
    return 0


def saved_run(path: Path, model: str | None) -> tuple[Any, bool]:
    """The run of a file, of a system or of a scene, with its model; whether it is that of a scene."""
    from nonsmooth.results.scene_solution import SceneSolution
    from nonsmooth.results.solution import Solution

    try:
        return Solution.load(path, model), False
    except InvalidInput as error:
        try:
            solution = SceneSolution.load(path)
        except InvalidInput:
            raise error from None
    if model is not None:
        solution = SceneSolution.load(path, scene_of(model, solution.about))
    return solution, True


def scene_of(typed: str, about: dict[str, Any]) -> Any:
    """The scene that a user names, with the parameters that stand in the file of its run."""
    from nonsmooth.scenes.given import as_scene, is_scene_object

    known = {name: repr(value) for name, value in about.items() if isinstance(value, int | float)}
    found = from_file(typed, known, parameter_of)[1] if is_file(typed) else load(typed)
    fields = {} if is_scene_object(found) else getattr(found, "__dataclass_fields__", {})
    scene = as_scene(with_set(found, {name: text for name, text in known.items() if name in fields}))
    if scene is None:
        raise InvalidInput(f"{typed} is a model with a system; the file is the run of a scene of bodies")
    return scene
