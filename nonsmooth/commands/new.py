"""``nonsmooth new``: a file with a model or a scene that runs, to begin one's own with."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from nonsmooth.checks.files import as_place, whole_file
from nonsmooth.errors import InvalidInput

BEGINNINGS = {  # name of a file beside this one: what it has
    "functions": "a block on a belt: mass, force, gap and friction as functions",
    "energies": "a pendulum on a spring next to a wall, derived by SymPy",
    "scene": "boxes that slide off a ramp: shapes whose contacts are found",
}
SCHEMA = "scene.schema.json"


def add_new(new: argparse.ArgumentParser) -> None:
    """The options of ``nonsmooth new``."""
    new.set_defaults(act=act_new)
    new.add_argument(
        "file", metavar="FILE", type=Path,
        help=f"the file that is written, FILE.py, or FILE.toml for a scene, with {SCHEMA} next to it, by which editors "
        "complete names; what is there stays",
    )  # fmt: skip
    new.add_argument(
        "--of", choices=[*BEGINNINGS],
        help="; ".join(f"{name}: {what}" for name, what in BEGINNINGS.items()) + "; functions by default",
    )  # fmt: skip


def act_new(arguments: argparse.Namespace) -> int:
    """``nonsmooth new``."""
    path = as_place("the path", arguments.file, (".py", ".toml"))
    if path.exists():
        raise InvalidInput(f"there is a file {path} already; give another name, or remove it")
    is_toml = path.suffix == ".toml"
    if is_toml and arguments.of not in (None, "scene"):
        raise InvalidInput(f"a TOML file holds a scene, and --of {arguments.of} is a model; give FILE.py")
    kind = arguments.of or ("scene" if is_toml else "functions")
    beginning = "scene_file" if is_toml else kind
    text = (Path(__file__).parent / "beginnings" / f"{beginning}.txt").read_text(encoding="utf-8")
    with whole_file(path) as part:
        part.write_text(text.replace("FILE", str(path)), encoding="utf-8")
    if is_toml:
        write_schema(path.with_name(SCHEMA))
    print(f"{path}: {BEGINNINGS[kind]}. It runs as it is:\n\n    nonsmooth run {path} --view")
    return 0


def write_schema(path: Path) -> None:
    """The schema of scene files, as this version reads them."""
    from nonsmooth.scenes.file_schema import schema

    with whole_file(path) as part:
        part.write_text(json.dumps(schema(), indent=1) + "\n", encoding="utf-8")
