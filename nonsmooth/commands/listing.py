"""``nonsmooth list``: the models and scenes there are, each with its parameters and the variables of its state."""

from __future__ import annotations

import argparse
import inspect
from typing import Any

from nonsmooth.commands.outputs import add_printed, tell
from nonsmooth.commands.terminal import complain
from nonsmooth.errors import InvalidInput


def add_list(command: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth list``."""
    command.set_defaults(act=act_list)
    command.add_argument("models", nargs="*", metavar="MODEL", help="these alone: names, FILE.py, or FILE.py:NAME")
    add_printed(command)


def act_list(arguments: argparse.Namespace) -> int:
    """``nonsmooth list``."""
    from nonsmooth.catalogue.entries import load, load_entry, model_entries, scene_entries
    from nonsmooth.catalogue.files import found_in, from_file, is_file, load_file, split

    found: list[dict[str, Any]] = []
    refused: dict[str, list[str]] = {}
    for typed in arguments.models:
        if not is_file(typed):
            found.append(facts(typed, load(typed)))
            continue
        file, chosen = split(typed)
        models = dict([from_file(typed)]) if chosen else found_in(load_file(file))
        for name, model in models.items():
            try:
                found.append(facts(f"{file}:{name}", model))
            except InvalidInput as error:
                complain(f"{file}:{name}: {error}")
    for entry in [] if arguments.models else [*model_entries().values(), *scene_entries().values()]:
        try:
            found.append(facts(entry.name, load_entry(entry)))
        except InvalidInput as error:
            refused.setdefault(entry.module.split(".")[0], []).append(str(error))
    for package, errors in refused.items():
        more = f" (and {len(errors) - 1} more of the package {package})" if len(errors) > 1 else ""
        complain(f"{errors[0]}{more}")
    tell(arguments, lambda: "\n".join(map(lines_of, found)), lambda: {"models": found})
    return 0


def facts(name: str, model: Any) -> dict[str, Any]:
    """A model or a scene: its name, what it says of itself, its parameters, the variables of its state."""
    from nonsmooth.checks.parameters import numeric_fields
    from nonsmooth.commands.typed_model import made
    from nonsmooth.mechanics.start import describing, state_function, variables_of
    from nonsmooth.mechanics.system import System
    from nonsmooth.scenes.scene import Scene

    instance = made(model) if isinstance(model, type) else model
    is_scene, is_bare = isinstance(instance, Scene), isinstance(instance, System | Scene)
    what = "scene" if is_scene or hasattr(instance, "scene") else "model"
    said = repr(instance) if is_bare else inspect.getdoc(model) or "no description"
    told: dict[str, Any] = {"name": name, "is": what, "says": said.splitlines()[0]}
    if not is_scene:
        told["parameters"] = {key: float(value) for key, value in numeric_fields(describing(instance)).items()}
        if is_bare or hasattr(instance, "state"):
            told["state"] = list(variables_of(state_function(instance)))
    return told


def lines_of(told: dict[str, Any]) -> str:
    """The same in lines."""
    lines = [f"{told['name']:18} {told['says']}"]
    if "parameters" in told:
        values = "  ".join(f"{key}={value:.6g}" for key, value in told["parameters"].items())
        lines.append(f"{'':18} --set    {values}")
    if "state" in told:
        lines.append(f"{'':18} --state  {'  '.join(told['state'])}")
    return "\n".join(lines)
