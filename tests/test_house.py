"""The house is as its map says: rooms, which way imports go, nothing loose at the top, tests in the same tree."""

import ast
import importlib
import re
import tomllib
from enum import Enum
from numbers import Number
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "nonsmooth"
AT_THE_TOP = {"__init__.py", "__init__.pyi", "py.typed", "__main__.py", "errors.py", "views.py"}
BESIDE = {"acceptance", "benchmarks", "data", "models", "mutations", "peers", "site", "stress"}
ORIGIN = re.compile(r"\b(derived|measured|chosen|defined|code)\b")  # of a constant; a code names a case
BARE = {"TOL", "TOLERANCE", "ROUNDING", "ROUNDINGS", "EPS", "SMALL", "TINY", "LARGEST", "MAX", "MIN", "LIMIT", "FACTOR"}
ROUNDING = PACKAGE / "numerics" / "rounding.py"
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


class Constant(NamedTuple):
    """A number, or a tuple of numbers, that a module gives a name in capital letters."""

    name: str
    path: Path
    said: str  # its comment: on its lines, or in the block of comments right above them
    is_range: bool  # range(n): cases are counted, and their names say what they are


def is_numeric(value):
    if isinstance(value, tuple):
        return len(value) > 0 and all(is_numeric(part) for part in value)
    return isinstance(value, Number) and not isinstance(value, bool | Enum)


def comment_of(statement, lines):
    above = statement.lineno - 1
    while above > 0 and lines[above - 1].startswith("#"):
        above -= 1
    return " ".join(line.partition("#")[2] for line in lines[above : statement.end_lineno])


def constants_of(path):
    lines = path.read_text().splitlines()
    module = importlib.import_module(".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"))
    for statement in ast.parse("\n".join(lines)).body:
        if isinstance(statement, ast.Assign | ast.AnnAssign) and statement.value is not None:
            is_range = isinstance(statement.value, ast.Call) and ast.unparse(statement.value.func) == "range"
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            for node in (node for target in targets for node in ast.walk(target)):
                if isinstance(node, ast.Name) and node.id.isupper() and is_numeric(getattr(module, node.id)):
                    yield Constant(node.id, path, comment_of(statement, lines), is_range)


def constants():
    return [constant for path in sorted(PACKAGE.rglob("*.py")) for constant in constants_of(path)]


@pytest.mark.upkeep
def test_no_name_of_a_number_stands_in_two_files():
    """What two files read stands once and is imported; what differs has another name, that of its quantity."""
    first = {}
    for constant in constants():
        assert first.setdefault(constant.name, constant.path) == constant.path, (constant, first[constant.name])
    assert len(first) > 500


def test_every_number_with_a_name_says_where_it_comes_from():
    silent = [(c.name, str(c.path)) for c in constants() if not c.is_range and not ORIGIN.search(c.said)]
    assert silent == []


@pytest.mark.upkeep
def test_no_name_of_a_number_leaves_out_of_what_it_is():
    assert [(c.name, str(c.path)) for c in constants() if c.name in BARE and c.path != ROUNDING] == []


def test_the_unit_of_rounding_stands_in_one_file():
    written = re.compile(r"finfo\([^)]*\)\.eps\b|float_info|\b2\.2+0?\d*e-16|\b2(\.0)? ?\*\* ?-5[23]")
    assert [str(path) for path in PACKAGE.rglob("*.py") if written.search(path.read_text())] == [str(ROUNDING)]


MOST_ARGUMENTS = 8  # chosen: of a kernel; beyond it values travel in the block that has them


def kernels_of(path):
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.FunctionDef) and any("kernel" in ast.unparse(mark) for mark in node.decorator_list):
            yield node.name, [argument.arg for argument in node.args.args]


def test_kernels_take_few_arguments_and_none_that_the_system_has():
    """What a model has, its contacts and their laws stand in ``sys``, and in no argument or block beside it."""
    kernels = [(path.name, *found) for path in sorted(PACKAGE.rglob("*.py")) for found in kernels_of(path)]
    assert len(kernels) > 500
    assert [(file, name) for file, name, given in kernels if len(given) > MOST_ARGUMENTS] == []
    assert [(file, name) for file, name, given in kernels if "has" in given] == []
    beside = {"kinds", "laws"}
    assert [(file, name) for file, name, given in kernels if "sys" in given and beside & set(given)] == []


COLUMNS = 100  # of a line of Markdown, so that a diff shows something
WHOLE = re.compile(r"`[^`]+`|\$[^$]+\$|\]\([^)]*\)")  # code, formulas and the targets of links are not parted


def pages():
    made = {"generated", "_build", "examples"}
    return [*ROOT.glob("*.md"), *(page for page in (ROOT / "docs").rglob("*.md") if not made & set(page.parts))]


def long_lines(text):
    """Numbers of the lines that are too long and could be parted: no tables, headings, code or formulas."""
    fence, found = "", []  # what ends the code or the formula that a line stands in
    for number, line in enumerate(text.splitlines(), 1):
        begin, code = line.lstrip(), re.match(r" *(```+|~~~+)|    ", line)
        if fence:
            fence = "" if fence in line else fence
        elif code or begin.startswith("$$"):
            fence = code[1] or "" if code else "$$" * (begin.count("$$") == 1)
        elif len(line) > COLUMNS and not begin.startswith(("|", "#")):
            words = WHOLE.sub("whole", re.sub(r"^([-*+]|\d+\.) +", "", begin))
            found += [number] if " " in words else []
    return found


def test_lines_of_markdown_fit_into_a_diff():
    assert not {str(page.relative_to(ROOT)): lines for page in pages() if (lines := long_lines(page.read_text()))}
    word, code = "a" * 60, f"`{'b c ' * 40}`"
    assert long_lines(f"{word} {word}\n- {code}\n{word} {code}\n| {code} |\n```\n{word} {word}\n```") == [1, 3]


NAMED = re.compile(r"docs/([\w/]+\.md)((?:(?:, | and | to )\(\d+\))*)")  # a page, and the equations of it


def test_equations_that_code_names_stand_on_their_pages():
    missing = []
    for path in sorted(PACKAGE.rglob("*.py")):
        for page, numbers in NAMED.findall(" ".join(path.read_text().split())):
            written = (ROOT / "docs" / page).read_text()
            missing += [(path.name, page, n) for n in re.findall(r"\d+", numbers) if f"\\tag{{{n}}}" not in written]
    assert missing == []
    assert NAMED.findall("docs/a.md, (2), (4) and (5).") == [("a.md", ", (2), (4) and (5)")]


def test_a_theory_page_says_first_what_it_assumes():
    pages = sorted({*(ROOT / "docs/theory").glob("*.md")} - {ROOT / "docs/theory/index.md"})
    assert [page.name for page in pages if re.findall("^## (.*)", page.read_text(), re.M)[:1] != ["Assumes"]] == []


def test_equations_of_a_page_are_numbered_in_their_order():
    pages = [ROOT / "docs/penalty.md", *(ROOT / "docs/theory").glob("*.md")]
    numbers = {page.name: [int(n) for n in re.findall(r"\\tag\{(\d+)\}", page.read_text())] for page in pages}
    assert {name: found for name, found in numbers.items() if found != sorted(found)} == {}


def test_the_friction_coefficient_is_a_greek_letter_and_the_sign_for_a_millionth_stands_before_units():
    """Two characters look alike; a search for one does not find the other."""
    millionth = re.compile("\u00b5(?![ms](?![a-zA-Z]))")
    rooms = ("nonsmooth", "models", "docs/examples", "docs/figures", "benchmarks")
    sources = [*pages(), *(path for room in rooms for path in (ROOT / room).rglob("*.py"))]
    assert [str(path.relative_to(ROOT)) for path in sources if millionth.search(path.read_text(encoding="utf-8"))] == []
    assert millionth.search("\u00b5mg") and not millionth.search("30 \u00b5m, 2 \u00b5s")
