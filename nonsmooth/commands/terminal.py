"""What commands share on a terminal: exit codes, lines on stderr, and where a figure goes."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nonsmooth.checks.files import FIGURE_ENDINGS
from nonsmooth.commands.typed_input import require_module, require_writable
from nonsmooth.errors import InvalidInput, MissingExtra, NonsmoothWarning

FAILED, NOT_WRITTEN = 3, 4  # code: exit codes, apart from 0, typed_input.BAD_INPUT and errors.INTERRUPTED


def require_one(arguments: argparse.Namespace) -> None:
    """Raise for a figure that is asked for and refused."""
    if arguments.plot and arguments.no_plot:
        raise InvalidInput("give either --plot or --no-plot; got both")


def figure_path(arguments: argparse.Namespace) -> Path | None:
    """Where to draw: what was asked for, else MODEL.png, or MODEL-STUDY.png, where it can be drawn."""
    require_one(arguments)
    if arguments.no_plot:
        return None
    if arguments.plot:
        require_writable(arguments.plot, FIGURE_ENDINGS)
        require_module("matplotlib", "plot", "figures")
        return arguments.plot
    if arguments.json:
        return None
    figure = Path(f"{arguments.model}{arguments.suffix}.png")
    try:
        require_module("matplotlib", "plot", "figures")
        require_writable(figure, FIGURE_ENDINGS)
    except (MissingExtra, InvalidInput) as error:
        complain(f"no figure will be drawn: {error}")
        return None
    return figure


def show_warning(options: Mapping[str, str], message: Warning | str, category: type[Warning], *_: Any) -> None:
    """A warning of ours as one line; those of other packages say nothing to a user of the command line."""
    if issubclass(category, NonsmoothWarning):
        complain(f"warning: {as_typed(str(message), options)}")


def as_typed(text: str, options: Mapping[str, str]) -> str:
    """A message of the library with its keywords as the options of the command: ``dt=`` is --dt, ``project=True`` is
    --project, ``state=(q0, u0) or dict(th=0.8)`` is --state th=0.8, ``integrator=ns.MoreauJean(dt)`` --integrator
    moreau-jean; other keywords are left."""

    def typed(found: re.Match) -> str:
        word, value = options.get(found["name"]), found["value"] or ""
        if word is None:
            return found[0]
        if found["by_name"]:
            value = found["by_name"].replace(",", "")
        elif found["by_key"]:
            value = found["by_key"].replace('"', "").replace(": ", "=")
        elif found["made"]:
            value = re.sub(r"(?<!^)(?=[A-Z])", "-", found["made"]).lower()
        elif value == "True":
            value = ""
        return f"{word} {value}".rstrip()

    start = r"(?:\(q0, u0\) or )?(?:dict\((?P<by_name>[^)]*)\)|\{(?P<by_key>[^}]*)\})"
    value = rf"True\b|{start}|ns\.(?P<made>\w+)\([^)]*\)|'[^']*'|[\d.eE+-]*\d"
    return re.sub(rf"(?<![\w.])(?P<name>[a-z]\w*)=(?P<value>{value})?", typed, text)


def complain(text: str) -> None:
    """One line on stderr."""
    print(f"nonsmooth: {text}", file=sys.stderr)
