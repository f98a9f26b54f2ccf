"""What journals and checkpoints know a module by stays when it moves."""

import importlib.util

import pytest

import nonsmooth as ns
from nonsmooth.checks.arrays import as_number
from nonsmooth.contact.planar.lemke import pivot
from nonsmooth.integrators.adaptive.loop import run
from nonsmooth.jit.content import Content
from nonsmooth.jit.former_names import FORMER, known_as
from nonsmooth.jit.libraries import library_path

# from what is left of the files that they were in
PARTED = {"contact.planar.lemke", "results.events", "results.failures", "results.stats"}


@pytest.mark.parametrize("module", FORMER)
def test_each_module_of_the_table_is_there(module):
    assert importlib.util.find_spec(f"nonsmooth.{module}") is not None


def test_no_two_modules_are_known_by_one_name():
    """Nor is one known by a name that another has now, but for those that were together."""
    names = [name for module, name in FORMER.items() if module not in PARTED]
    assert len(set(names)) == len(names)
    assert not {name for name in names if holds_code(name)}


def holds_code(name):
    """Whether this is a module of the package, and not only a folder of them."""
    try:
        found = importlib.util.find_spec(f"nonsmooth.{name}")
    except ModuleNotFoundError:
        return False
    return found is not None and found.submodule_search_locations is None


def test_a_function_that_models_use_is_known_as_it_was():
    """``state`` of most models calls it: journals of maps and sweeps hold its name."""
    assert library_path(as_number, Content().is_library) == "nonsmooth.arrays.as_number"
    assert known_as("nonsmooth.errors") == "nonsmooth.errors" and known_as("numpy.linalg") == "numpy.linalg"


def test_the_slot_of_an_entry_point_is_named_as_it_was():
    assert run.slot_name == "nonsmooth.nonsmooth.integrators.adaptive_loop.run"
    assert pivot.slot_name == "nonsmooth.nonsmooth.contact_solvers.planar.pivot"


def test_public_classes_are_known_as_they_were():
    assert known_as(ns.System.__module__) == "nonsmooth.system"
    assert known_as(ns.StepFailure.__module__) == "nonsmooth.errors"
    assert {known_as(kind.__module__) for kind in (ns.Solution, ns.Stats, ns.ParadoxEvent)} == {"nonsmooth.solution"}
