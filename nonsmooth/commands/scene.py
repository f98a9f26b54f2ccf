"""``nonsmooth scene``: ``nonsmooth run`` for scenes of bodies alone, which also shows a run that was saved."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from nonsmooth.commands.run import act_on, add_run, draw, report, require_outputs, simulate_runnable
from nonsmooth.commands.typed_model import is_scene, typed_model
from nonsmooth.errors import InvalidInput

# options of a run, which a saved one does not take, with the value of one that is left out
OF_RUNS: dict[str, Any] = {
    "t_end": None, "dt": None, "every": 1, "t_eval": None, "max_steps": None, "max_wall_time": None,
    "checkpoint": None, "resume": None, "live": False,
}  # fmt: skip


def add_scene(scene: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth scene``: those of ``nonsmooth run``, and a saved run."""
    add_run(scene)
    scene.set_defaults(act=act_scene)
    scene.add_argument("--saved", type=Path, metavar="FILE", help="show this saved run of the scene; nothing is run")


def act_scene(arguments: argparse.Namespace) -> int:
    """``nonsmooth scene``."""
    model = typed_model(arguments, takes_scenes=True)
    if not is_scene(model):
        raise InvalidInput(f"{arguments.model} is a model with a system, which `nonsmooth run` sets in motion; "
                           "a scene of bodies is needed here")  # fmt: skip
    if arguments.saved:
        require_no_run(arguments)
    figure = require_outputs(model, arguments)
    if not arguments.saved:
        return act_on(simulate_runnable(model, arguments), arguments, figure)
    solution = saved_run(model, arguments.saved)
    if arguments.out:
        solution.save(arguments.out)
    report(solution, arguments, draw(solution, arguments, figure))
    return 0


def require_no_run(arguments: argparse.Namespace) -> None:
    """Raise `InvalidInput` for an option that only a run takes."""
    for name, left_out in OF_RUNS.items():
        if getattr(arguments, name) != left_out:
            raise InvalidInput(f"--saved runs nothing, and takes no --{name.replace('_', '-')}; leave it out")


def saved_run(model: Any, path: Path) -> Any:
    """The run of a scene that was saved; `InvalidInput` for one of another scene."""
    from nonsmooth.results.scene_solution import SceneSolution
    from nonsmooth.scenes.given import as_scene

    return SceneSolution.load(path, as_scene(model))
