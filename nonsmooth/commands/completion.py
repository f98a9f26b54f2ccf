"""``nonsmooth completion bash | zsh``: what a shell needs to complete commands, options, models and files by Tab.

    eval "$(nonsmooth completion bash)"

The script is made by shtab (https://docs.iterative.ai/shtab) from the parser itself, and knows the models that are
registered when it is made: nothing of this package runs at a press of Tab.
"""

from __future__ import annotations

import argparse
import functools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from nonsmooth.commands.typed_input import require_module

SHELLS = ("bash", "zsh")
MODELS_OF_BASH = """_nonsmooth_models() {{
  compgen -W "{names}" -- "$1"
  compgen -f -X '!*.py' -- "$1"
}}"""


def add_completion(command: argparse.ArgumentParser, parser: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth completion``, which is about the whole parser."""
    command.set_defaults(act=functools.partial(act_completion, parser))
    command.add_argument("shell", choices=SHELLS, help='of which the script is: eval "$(nonsmooth completion bash)"')


def act_completion(parser: argparse.ArgumentParser, arguments: argparse.Namespace) -> int:
    """``nonsmooth completion``."""
    require_module("shtab", "completion", "completions")
    print(script(parser, arguments.shell))
    return 0


def script(parser: argparse.ArgumentParser, shell: str) -> str:
    """The script that completes a command line in a shell."""
    import shtab

    from nonsmooth.catalogue.entries import model_entries, scene_entries

    names = " ".join(sorted({*model_entries(), *scene_entries()}))
    models = {"bash": "_nonsmooth_models", "zsh": f"({names})"}
    for action in actions_of(parser):
        if action.dest in ("model", "models"):
            action.complete = models  # type: ignore[attr-defined]
        elif action.type is Path:
            action.complete = shtab.FILE  # type: ignore[attr-defined]
    preamble = {"bash": MODELS_OF_BASH.format(names=names)}
    made: str = shtab.complete(parser, shell=shell, preamble=preamble)  # type: ignore[arg-type]
    return made


def actions_of(parser: argparse.ArgumentParser) -> Iterator[Any]:
    """Every argument of every command."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from actions_of(command)
        else:
            yield action
