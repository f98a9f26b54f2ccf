"""The system that a model builds: of the model as it is now; one system as long as it is the same."""

import dataclasses
import json
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.mechanics.model_system import as_system
from tests.systems import ball


class Counted:
    def __init__(self, fails=False):
        self.calls, self.fails = 0, fails

    def system(self):
        self.calls += 1
        return ball(ns.Contact()) if not self.fails else np.zeros(2) + "m"


class Unhashable(Counted):
    __hash__ = None


@pytest.mark.parametrize("kind", [Counted, Unhashable])
def test_a_model_is_asked_each_time_and_gives_one_system_as_long_as_its_parts_are_the_same(kind):
    model = kind()
    systems = [as_system(model), as_system(model)]
    assert model.calls == 2 and systems[0] is systems[1]


@pytest.mark.parametrize("kind", [Counted, Unhashable])
def test_a_type_error_of_a_model_comes_out_of_its_first_call(kind):
    model = kind(fails=True)
    with pytest.raises(TypeError):
        as_system(model)
    assert model.calls == 1


# A ball that falls from 1 m, e read in one way or another: after the only impact, at t = sqrt(2/g), it has the speed
# e sqrt(2 g), so at t = 2 sqrt(2/g) it is at the height 2 e - 1, as long as that is above the floor.

G = 9.81


def mass(t, q, p, M):
    M[0, 0] = 1.0


def force(t, q, u, p, h):
    h[0] = -G


def gap(t, q, p, g_N):
    g_N[0] = q[0]


def system_of(e):
    return ns.System(n_q=1, mass=mass, force=force, gap=gap, contacts=[ns.Contact(e_N=e)])


def height(model):
    end = 2.0 * (2.0 / G) ** 0.5
    return ns.simulate(model, (0.0, end), [1.0], [0.0], integrator=ns.EventDriven(), progress=False).q[-1, 0]


class Attribute:
    e = 0.0

    def system(self):
        return system_of(self.e)


class ByProperty(Attribute):
    e = property(lambda self: self.numbers["e"])


class InList(Attribute):
    numbers = [0.0]  # noqa: RUF012

    def system(self):
        return system_of(self.numbers[0])


class ReadsFile(Attribute):
    def system(self):
        return system_of(json.loads(self.path.read_text()))


class ReadsEnvironment(Attribute):
    def system(self):
        import os

        return system_of(float(os.environ["NONSMOOTH_TEST_E"]))


class BuildsFunctions(Attribute):
    def system(self):
        e = self.e

        def height_above(t, q, p, g_N):
            g_N[0] = q[0] + 1e-300 * e

        return dataclasses.replace(system_of(e), gap=height_above)


@dataclasses.dataclass
class Data(Attribute):
    e: float = 0.0


class Keyed(Attribute):
    """One that says of itself that it is the same."""

    __hash__ = lambda self: 1  # noqa: E731
    __eq__ = lambda self, other: True  # noqa: E731


class P(NamedTuple):
    floor: np.ndarray


class ParameterArray(Attribute):
    floor = np.zeros(1)

    def system(self):
        def above(t, q, p, g_N):
            g_N[0] = q[0] - p.floor[0]

        return dataclasses.replace(system_of(0.0), gap=above, parameters=P(self.floor))


def by_attribute(model, e, tmp_path, monkeypatch):
    model.e = e


def by_class(model, e, tmp_path, monkeypatch):
    monkeypatch.setattr(type(model), "e", e)


def by_dict(model, e, tmp_path, monkeypatch):
    vars(model).setdefault("numbers", {})["e"] = e


def by_list(model, e, tmp_path, monkeypatch):
    model.numbers[0] = e


def by_global(model, e, tmp_path, monkeypatch):
    def system(self):
        return system_of(e)

    monkeypatch.setattr(type(model), "system", system)


def by_own_method(model, e, tmp_path, monkeypatch):
    model.system = lambda: system_of(e)


def by_file(model, e, tmp_path, monkeypatch):
    model.path = tmp_path / "e.json"
    model.path.write_text(json.dumps(e))


def by_environment(model, e, tmp_path, monkeypatch):
    monkeypatch.setenv("NONSMOOTH_TEST_E", repr(e))


CHANGES = {
    "attribute": (Attribute, by_attribute), "attribute of the class": (Attribute, by_class),
    "property of a dict": (ByProperty, by_dict), "list": (InList, by_list),
    "method of the class": (Attribute, by_global), "method of its own": (Attribute, by_own_method),
    "file": (ReadsFile, by_file), "environment": (ReadsEnvironment, by_environment),
    "dataclass": (Data, by_attribute),
    "equal to every other": (Keyed, by_attribute), "functions made by the method": (BuildsFunctions, by_attribute),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_a_model_that_changed_runs_as_it_is_now(name, tmp_path, monkeypatch):
    kind, change = CHANGES[name]
    model = kind()
    for e in (0.9, 0.6, 0.9):
        change(model, e, tmp_path, monkeypatch)
        assert height(model) == pytest.approx(2.0 * e - 1.0, abs=1e-7)
        assert as_system(model).contacts[0].e_N == e


def test_an_array_of_parameters_that_is_written_to_is_read_again():
    """The ball lies on a floor that is raised."""
    model = ParameterArray()
    for floor in (0.25, 0.5):
        model.floor[0] = floor
        assert height(model) == pytest.approx(floor, abs=1e-7)


@dataclasses.dataclass
class Floor:
    y: float
    heights: np.ndarray


def test_parameters_that_are_written_to_after_the_system_was_made_are_read_again():
    """The same ball on a floor that is raised, by an attribute and by an entry of an array."""

    def above(t, q, p, g_N):
        g_N[0] = q[0] - p.y - p.heights[1]

    floor = Floor(0.25, np.zeros(2))
    system = dataclasses.replace(system_of(0.0), gap=above, parameters=floor)
    assert height(system) == pytest.approx(0.25, abs=1e-7) and as_system(system) is system
    floor.y = 0.5
    assert height(system) == pytest.approx(0.5, abs=1e-7)
    floor.heights[1] = 0.125
    assert height(system) == pytest.approx(0.625, abs=1e-7)
    floor.y, floor.heights[1] = 0.25, 0.0
    assert as_system(system) is system


@pytest.mark.parametrize(("one", "other"), [(0.0, -0.0), (1, 1.0), (1, True), (float("nan"), 1.0)])
def test_parts_that_python_calls_equal_are_told_apart(one, other):
    """Of a model that hands on what it has as a default of a function."""

    class Model(Attribute):
        def system(self):
            def load(t, q, u, p, h, c=self.e):
                h[0] = c

            return dataclasses.replace(system_of(0.5), force=load)

    model, seen = Model(), []
    for model.e in (one, other, one):
        seen.append(as_system(model))
    assert seen[0] is seen[2] is not seen[1]
