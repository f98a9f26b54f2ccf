"""The house is as its map says: rooms, which way imports go, nothing loose at the top, tests in the same tree."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "nonsmooth"
AT_THE_TOP = {"__init__.py", "__main__.py", "errors.py", "views.py"}
BESIDE = {"acceptance", "benchmarks", "data", "models", "mutations", "peers", "stress"}  # tests of more than one room
ROW = re.compile(r"^\| (`[^|]*`) \| [^|]+ \| ([^|]*)\|$", re.M)


def rooms():
    return {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"}


def rows_of_the_map():
    """(rooms, files to begin with) from the top of the table to its bottom."""
    page = (ROOT / "CONTRIBUTING.md").read_text()
    return [tuple(re.findall(r"`([^`]+)`", cell) for cell in row) for row in ROW.findall(page)]


def layers():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]
    (contract,) = [contract for contract in settings["contracts"] if contract["type"] == "layers"]
    assert settings["exclude_type_checking_imports"] is False and "ignore_imports" not in contract
    return [{name.strip().removeprefix("nonsmooth.") for name in layer.split("|")} for layer in contract["layers"]]


def test_nothing_is_loose_at_the_top():
    assert {path.name for path in PACKAGE.glob("*.*")} == AT_THE_TOP


def test_the_map_has_every_room_and_the_order_of_imports():
    of_the_map = [{name.removesuffix(".py") for name in names} for names, _ in rows_of_the_map()]
    assert of_the_map == layers()[1:] and layers()[0] == {"__main__"}
    assert set().union(*of_the_map) == rooms() | {"errors", "views"}


def test_the_files_that_the_map_begins_with_are_there():
    for names, files in rows_of_the_map():
        assert len(files) > 0 or "errors.py" in names
        for file in files:
            assert any((PACKAGE / folder / file).is_file() for folder in ("", *names, "integrators")), file


def test_every_room_says_what_it_is_for():
    for path in PACKAGE.rglob("__init__.py"):
        assert path.read_text().startswith('"""'), path


def test_tests_stand_in_the_tree_of_what_they_test():
    for path in (ROOT / "tests").rglob("test_*.py"):
        folder = path.parent.relative_to(ROOT / "tests")
        assert folder == Path() or folder.parts[0] in BESIDE or (PACKAGE / folder).is_dir(), path
