"""Every example runs: those in the docstrings, the Python of the pages, and the commands of the pages."""

import ast
import doctest
import importlib
import os
import re
import shlex
from pathlib import Path

import pytest

import models
import nonsmooth
from nonsmooth.commands.cli import build_parser, main
from nonsmooth.commands.typed_input import NEGATIVE

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted({*(ROOT / "docs").rglob("*.md")} - {*(ROOT / "docs/generated").rglob("*.md")})]
PRINTED = re.compile(r"prints\n\n```text\n(.*?)^```", re.MULTILINE | re.DOTALL)
PYTHON = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(r"^ {4}(nonsmooth (?:run|list|classify|map) [^|\n]*|nonsmooth list)$", re.MULTILINE)
ANY_COMMAND = re.compile(r"^ {4}(nonsmooth [a-z]+(?:\\\n|[^|\n])*)", re.MULTILINE)


def modules_with_examples():
    for package in (nonsmooth, models):
        folder = Path(package.__file__).parent
        for path in sorted(folder.rglob("*.py")):
            if ">>>" in path.read_text():
                yield ".".join((package.__name__, *path.relative_to(folder).with_suffix("").parts))


def require_sympy_for(text):
    """Skip an example that uses SymPy where it is not installed."""
    if "import sympy" in text:
        pytest.importorskip("sympy", reason="energies need SymPy, the extra [symbolic]")


def pages_with(pattern):
    return [pytest.param(page, id=page.name) for page in PAGES if pattern.search(page.read_text())]


@pytest.mark.upkeep
@pytest.mark.parametrize("module", list(modules_with_examples()))
def test_examples_of_docstrings_give_what_they_show(module, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module(module)
    require_sympy_for(Path(module.__file__).read_text())
    outcome = doctest.testmod(module)
    written = re.findall(r"^ *>>> ", Path(module.__file__).read_text(), re.MULTILINE)
    assert outcome.attempted == len(written) and outcome.failed == 0  # one that doctest does not find would never run


@pytest.mark.upkeep
@pytest.mark.parametrize("page", pages_with(PYTHON))
def test_python_of_a_page_runs_from_top_to_bottom(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    script = tmp_path / "page.py"  # a file: model functions are read back from their source
    script.write_text("\n".join(PYTHON.findall(page.read_text())))
    require_sympy_for(script.read_text())
    entered: set[int] = set()
    program = ast.parse(script.read_text())
    handlers = [node for node in ast.walk(program) if isinstance(node, ast.ExceptHandler)]
    for handler in handlers:
        handler.body[:0] = ast.parse(f"_entered.add({handler.lineno})").body
    exec(compile(ast.fix_missing_locations(program), script, "exec"), {"__name__": "page", "_entered": entered})
    assert entered == {handler.lineno for handler in handlers}  # a page that shows a failure has it
    said = capsys.readouterr().out
    assert all(shown in said for shown in PRINTED.findall(page.read_text()))


@pytest.mark.parametrize("page", pages_with(ANY_COMMAND))
def test_every_command_of_a_page_is_understood(page):
    for line in ANY_COMMAND.findall(page.read_text()):
        words = shlex.split(line.replace("\\\n", " "), comments=True)[1:]
        build_parser().parse_args([" " + word if NEGATIVE.match(word) else word for word in words])


@pytest.mark.upkeep
@pytest.mark.parametrize("page", pages_with(COMMAND))
def test_commands_of_a_page_run(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for line in COMMAND.findall(page.read_text()):
        assert main(shlex.split(line)[1:]) == 0, line
    assert os.listdir(tmp_path) or "--plot" not in page.read_text()
