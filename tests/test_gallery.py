"""Every script of the gallery runs, is short, draws a figure, and ends with a line of facts; together they show every
model and every ready scene."""

import inspect
import re
import runpy
import shlex
from pathlib import Path

import pytest
from matplotlib.figure import Figure

import nonsmooth as ns
from nonsmooth.catalogue.entries import entries_by_class
from nonsmooth.commands.cli import main

pytestmark = pytest.mark.upkeep

pyplot = pytest.importorskip("matplotlib.pyplot")

EXAMPLES = Path(__file__).parents[1] / "docs/examples"
SCRIPTS = sorted(EXAMPLES.glob("*/plot_*.py"))
LEAST_SCRIPTS, MOST_LINES = 40, 30  # defined: what the gallery promises
BY_ENERGIES = "import sympy"
PLAYER = re.compile(r"``(nonsmooth run .*? --view)``")
SHORT = "2e-3"  # s: long enough for a player
MISSED = re.compile(r"(\d+)(?: of \d+)? steps missed")
NOT_A_NUMBER = re.compile(r"\b(nan|inf)\b")


def named(path):
    return pytest.param(path, id=f"{path.parent.name}/{path.stem.removeprefix('plot_')}")


def code_of(path):
    """The lines of a script behind its heading that are not blank."""
    return [line for line in path.read_text().split('"""', 2)[2].splitlines() if line.strip()]


@pytest.mark.parametrize("script", [named(path) for path in SCRIPTS])
def test_an_example_runs_draws_and_says_how_well_it_was_solved(script, tmp_path, monkeypatch, capsys):
    if BY_ENERGIES in script.read_text():
        pytest.importorskip("sympy", reason="energies need SymPy, the extra [symbolic]")
    monkeypatch.chdir(tmp_path)
    pyplot.switch_backend("Agg")
    try:
        found = runpy.run_path(str(script))
        assert any(isinstance(value, Figure) for value in found.values())
    finally:
        pyplot.close("all")
    *_, status = capsys.readouterr().out.splitlines()
    assert re.search(r"\d", status) and not NOT_A_NUMBER.search(status)
    assert all(int(missed) == 0 for missed in MISSED.findall(status))


@pytest.mark.parametrize("script", [named(path) for path in SCRIPTS])
def test_an_example_is_short(script):
    assert len(code_of(script)) < MOST_LINES


@pytest.mark.parametrize("command", sorted({found for path in SCRIPTS for found in PLAYER.findall(path.read_text())}))
def test_the_player_of_an_example_is_written_by_its_command(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*shlex.split(command)[1:], "player.html", "--no-plot", "--t-end", SHORT]) == 0
    assert Path("player.html").exists()


def test_the_gallery_shows_every_public_function():
    text = "\n".join(path.read_text() for path in SCRIPTS)
    public = {name: getattr(ns, name) for name in ns.__all__}
    functions = [name for name, value in public.items() if inspect.isfunction(value)]
    assert [name for name in functions if f"ns.{name}(" not in text] == []


def test_the_gallery_shows_every_model_and_every_ready_scene():
    assert len(SCRIPTS) >= LEAST_SCRIPTS
    text = "\n".join(path.read_text() for path in SCRIPTS)
    assert [name for name in entries_by_class() if not re.search(rf"\b{name}\(", text)] == []
