"""``nonsmooth list``: the models and scenes there are, each with its parameters and the variables of its state."""

from __future__ import annotations

import argparse
import inspect
import shutil
import textwrap
from typing import Any

from nonsmooth.commands.outputs import add_printed, tell
from nonsmooth.commands.terminal import complain
from nonsmooth.errors import InvalidInput

HEADINGS = {
    "model": "Models, systems of coordinates: run, classify, map, study, sweep",
    "scene": "Scenes of bodies: run, scene",
}


def add_list(command: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth list``."""
    command.set_defaults(act=act_list)
    command.add_argument("models", nargs="*", metavar="MODEL", help="these alone: names, FILE.py, or FILE.py:NAME")
    add_printed(command)


def act_list(arguments: argparse.Namespace) -> int:
    """``nonsmooth list``."""
    from nonsmooth.catalogue.entries import load, load_entry, model_entries, scene_entries
    from nonsmooth.catalogue.files import OF_SCENES, found_in, from_file, is_file, load_file, split

    found: list[dict[str, Any]] = []
    refused: dict[str, list[str]] = {}
    for typed in arguments.models:
        if not is_file(typed):
            found.append(facts(typed, load(typed)))
            continue
        file, chosen = split(typed)
        models = dict([from_file(typed)]) if chosen or file.endswith(OF_SCENES) else found_in(load_file(file))
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
    tell(arguments, lambda: in_words(found, bool(arguments.models)), lambda: {"models": found})
    return 0


def facts(name: str, model: Any) -> dict[str, Any]:
    """A model or a scene: its name, what it says of itself, its parameters, the variables of its state."""
    from nonsmooth.commands.typed_model import made
    from nonsmooth.mechanics.start import describing, own_time, state_function, variables_of
    from nonsmooth.mechanics.system import System
    from nonsmooth.mechanics.units import meaning_of_parameter, unit_of_parameter
    from nonsmooth.scenes.scene import Scene

    instance = made(model) if isinstance(model, type) else model
    is_scene, is_bare = isinstance(instance, Scene), isinstance(instance, System | Scene)
    what = "scene" if is_scene or hasattr(instance, "scene") else "model"
    said = repr(instance) if is_bare else inspect.getdoc(model) or "no description"
    told: dict[str, Any] = {"name": name, "is": what, "says": said.splitlines()[0]}
    if not is_scene:
        described = describing(instance)
        told["parameters"] = parameters_of(described)
        told["units"] = {key: unit_of_parameter(described, key) for key in told["parameters"]}
        told["meanings"] = {key: meaning_of_parameter(described, key) for key in told["parameters"]}
        if is_bare or hasattr(instance, "state"):
            state = state_function(instance)
            told["state"] = list(variables_of(state))
            told["defaults"] = {key: value for key, value in variables_of(state).items() if value is not None}
            told["state_says"] = (inspect.getdoc(state) or "").partition("\n")[0]
    for time in ("t_end", "dt"):
        told[time] = own_time(instance, time)
    return told


def parameters_of(described: Any) -> dict[str, float | str]:
    """Numbers, and the texts among the fields: all that --set takes."""
    from nonsmooth.checks.parameters import numeric_fields

    texts = {name: getattr(described, name) for name in getattr(described, "__dataclass_fields__", {})}
    numbers = {name: float(value) for name, value in numeric_fields(described).items()}
    return numbers | {name: value for name, value in texts.items() if isinstance(value, str)}


def in_words(found: list[dict[str, Any]], were_named: bool) -> str:
    """One model with the meanings of its parameters; of several a few lines each, under headings."""
    if were_named and len(found) == 1:
        return in_detail(found[0])
    blocks = []
    for what, heading in HEADINGS.items():
        those = [lines_of(told) for told in found if told["is"] == what]
        if those:
            blocks.append("\n".join([*([] if were_named else [heading, ""]), *those]))
    more = [] if were_named else ["`nonsmooth list NAME` says what the parameters of one mean."]
    return ("\n" if were_named else "\n\n").join([*blocks, *more])


def lines_of(told: dict[str, Any]) -> str:
    """A model in a few lines."""
    lines = [f"{told['name']:18} {told['says']}"]
    if "parameters" in told:
        lines += rows("--set", [assigned(told, key) for key in told["parameters"]])
    if "state" in told:
        lines += rows("--state", told["state"])
    return "\n".join(lines)


def rows(option: str, words: list[str]) -> list[str]:
    """What an option takes, two spaces apart, in as many rows as a terminal needs."""
    room, found = max(shutil.get_terminal_size((120, 24)).columns - 28, 40), [""]
    for word in words:
        joined = f"{found[-1]}  {word}" if found[-1] else word
        found = [*found[:-1], joined] if len(joined) <= room or not found[-1] else [*found, word]
    return [f"{'':18} {option if k == 0 else '':8} {row}" for k, row in enumerate(found)]


def assigned(told: dict[str, Any], key: str) -> str:
    """A parameter with its value and unit."""
    unit = told["units"][key]
    return f"{key}={value_of(told['parameters'][key])}{f' {unit}' if unit not in ('', '-') else ''}"


def value_of(value: float | str | None) -> str:
    """A number in six digits, a text as it is."""
    return "" if value is None else f"{value:.6g}" if isinstance(value, float | int) else str(value)


def in_detail(told: dict[str, Any]) -> str:
    """A model with the value, unit and meaning of each parameter, and the variables of its state."""
    lines = [f"{told['name']:18} {told['says']}"]
    if told.get("parameters"):
        lines += ["", "--set NAME=VALUE: the parameters"]
        lines += table([(key, value_of(value), told["units"][key], told["meanings"][key])
                        for key, value in told["parameters"].items()])  # fmt: skip
    if told.get("state"):
        lines += ["", "--state NAME=VALUE: " + (told["state_says"] or "where it begins")]
        lines += table([(key, value_of(told["defaults"].get(key)), "", "") for key in told["state"]])
    times = [f"{name} = {told[name]:g} s" for name in ("t_end", "dt") if told[name] is not None]
    return "\n".join(lines + (["", f"by default {', '.join(times)}"] if times else []))


def table(cells: list[tuple[str, ...]]) -> list[str]:
    """Columns as wide as what stands in them, the last one broken; of rows that it is the same for, once."""
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)][:-1]
    room, lines, said = max(shutil.get_terminal_size((120, 24)).columns - sum(widths) - 8, 30), [], ""
    for *row, words in cells:
        front = "  " + "  ".join(f"{cell:{n}}" for cell, n in zip(row, widths, strict=True))
        first, *more = (textwrap.wrap(words, room) or [""]) if words != said else [words and '"']
        lines += [f"{front}  {first}".rstrip(), *(f"{'':{len(front)}}  {line}" for line in more)]
        said = words
    return lines
