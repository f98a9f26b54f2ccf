"""``nonsmooth new``: a file with a model that runs, to begin one's own with."""

from __future__ import annotations

import argparse
from pathlib import Path

from nonsmooth.checks.files import as_place, whole_file
from nonsmooth.errors import InvalidInput

BEGINNINGS = {  # name of a file beside this one: what it has
    "functions": "a block on a belt: mass, force, gap and friction as functions",
    "energies": "a pendulum on a spring next to a wall, derived by SymPy",
    "scene": "boxes that slide off a ramp: shapes whose contacts are found",
}


def add_new(new: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth new``."""
    new.set_defaults(act=act_new)
    new.add_argument("file", metavar="FILE.py", type=Path, help="the file that is written; what is there stays")
    new.add_argument(
        "--of", choices=[*BEGINNINGS], default="functions",
        help="; ".join(f"{name}: {what}" for name, what in BEGINNINGS.items()) + "; functions by default",
    )  # fmt: skip


def act_new(arguments: argparse.Namespace) -> int:
    """``nonsmooth new``."""
    path = as_place("the path", arguments.file, (".py",))
    if path.exists():
        raise InvalidInput(f"there is a file {path} already; give another name, or remove it")
    text = (Path(__file__).parent / "beginnings" / f"{arguments.of}.txt").read_text(encoding="utf-8")
    with whole_file(path) as part:
        part.write_text(text.replace("FILE", str(path)), encoding="utf-8")
    print(f"{path}: {BEGINNINGS[arguments.of]}. It runs as it is:\n\n    nonsmooth run {path} --view")
    return 0
