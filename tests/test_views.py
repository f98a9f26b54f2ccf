"""The table of who draws, saves and words a result: complete, and the only way from a result to those."""

import ast
import importlib
import inspect
from pathlib import Path

import pytest

import nonsmooth
from models import BouncingBall
from nonsmooth.views import VIEWS, view

PACKAGE = Path(nonsmooth.__file__).parent
ROWS = [(name, act, path) for name, acts in VIEWS.items() for act, path in acts.items()]
NO_CLASS = {"stability map"}  # a Dataset


def classes_of_the_package():
    for path in PACKAGE.rglob("*.py"):
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.ClassDef):
                yield node.name, path.relative_to(PACKAGE).as_posix()


@pytest.mark.parametrize(("name", "act", "path"), ROWS)
def test_each_row_names_a_function_that_takes_the_result_first(name, act, path):
    module, _, function = path.rpartition(".")
    found = getattr(importlib.import_module(f"nonsmooth.{module}"), function)
    assert inspect.isfunction(found) and found.__module__ == f"nonsmooth.{module}"
    assert next(iter(inspect.signature(found).parameters)) != "self"


def test_each_name_is_that_of_one_class():
    classes = list(classes_of_the_package())
    for name in VIEWS.keys() - NO_CLASS:
        assert [found for found, _ in classes].count(name) == 1, name


def test_a_derived_result_is_drawn_as_its_base():
    class Longer(nonsmooth.Solution):
        pass

    assert view(Longer, "plot") is view(nonsmooth.Solution, "plot")


@pytest.mark.upkeep
def test_each_view_that_a_result_asks_for_is_in_the_table():
    """``view(self, "plot")`` within a class, or of a name: the row is there."""
    asked = set()
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "view":
                if len(node.args) == 2 and isinstance(node.args[1], ast.Constant):
                    asked.add(node.args[1].value)
    assert asked == {act for _, act, _ in ROWS}


def test_a_solution_loads_who_draws_it_only_when_it_is_drawn():
    """Neither Matplotlib nor the module that uses it, until ``plot`` is called."""
    import subprocess
    import sys

    code = (
        "import sys, nonsmooth as ns\nfrom models import BouncingBall\nball = BouncingBall()\n"
        "sol = ns.simulate(ball, (0, 0.01), *ball.state(), integrator=ns.MoreauJean(1e-3))\n"
        "print([name for name in sys.modules if name.startswith(('nonsmooth.drawing', 'matplotlib', 'h5py'))])\n"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert ended.stdout == "[]\n", ended


def test_a_result_saves_and_words_itself_through_the_table(tmp_path):
    ball = BouncingBall()
    solution = nonsmooth.simulate(ball, (0, 0.1), *ball.state(), integrator=nonsmooth.MoreauJean(1e-3))
    assert solution.summary() == view(solution, "summary")(solution)
    assert (nonsmooth.Solution.load(solution.save(tmp_path / "run.npz")).q == solution.q).all()
