"""What every ready scene promises: a name under which it is found, a source, a scene that runs, checks that refuse."""

import dataclasses
import math
import re
from importlib.metadata import entry_points

import numpy as np
import pytest

import models.scenes
import nonsmooth as ns
from nonsmooth.scenes.elements import Kind

READY = [getattr(models.scenes, name) for name in models.scenes.__all__]
SMALL = {"sphere-box": {"n": 8}, "hourglass": {"n": 20}, "pyramid": {"rows": 3}, "kapla-tower": {"layers": 3}}


def small(model):
    return model(**SMALL.get(model.name, {}))


@pytest.mark.parametrize("model", READY, ids=lambda model: model.name)
def test_ready_scene_is_found_by_its_name(model):
    found = {entry.name: entry for entry in entry_points(group="nonsmooth.scenes")}
    assert found[model.name].load() is model
    assert model.source and model.t_end > 0 and 0 < model.dt < model.t_end


def test_every_ready_scene_is_registered_and_in_the_package():
    assert {entry.name for entry in entry_points(group="nonsmooth.scenes")} == {model.name for model in READY}


@pytest.mark.parametrize("model", READY, ids=lambda model: model.name)
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.ResidualWarning")
def test_ready_scene_runs_and_says_the_same_twice(model):
    one = small(model)
    runs = [ns.simulate(one, (0, 20 * one.dt), integrator=ns.MoreauJean(dt=one.dt)) for _ in range(2)]
    assert runs[0].success and np.isfinite(runs[0].q).all() and runs[0].summary()
    np.testing.assert_array_equal(runs[0].q, runs[1].q)
    assert sum(body.kind is Kind.DYNAMIC for body in one.scene()) >= 1


@pytest.mark.parametrize("model", READY, ids=lambda model: model.name)
def test_no_parameter_of_a_ready_scene_takes_nonsense(model):
    for field in dataclasses.fields(model):
        for bad in (math.nan, math.inf, "much", None):
            with pytest.raises(ns.InvalidInput, match=rf"\b{re.escape(field.name)}\b"):
                model(**{field.name: bad})


@pytest.mark.upkeep
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.NonsmoothWarning")
@pytest.mark.parametrize("model", READY, ids=lambda model: model.name)
def test_what_parameters_do_not_fit_is_refused_in_a_sentence_before_a_step(model):
    """A thick disc of Euler's, a seed of 0.5 and parcels behind the belt were errors of Python, or nonsense."""
    for field in dataclasses.fields(model):
        value = getattr(model(), field.name)
        for odd in (0, -1, 1e-3, 1e3, 0.5 * value, 2 * value, -value, True):
            if isinstance(value, int) and odd == 1e3:
                continue  # of bodies: too many for a test
            try:
                one = model(**SMALL.get(model.name, {}) | {field.name: odd})
                ns.simulate(one, (0, one.dt), integrator=ns.MoreauJean(dt=one.dt))
            except ns.InvalidInput as refusal:
                assert "\n" not in str(refusal)
    with pytest.raises(
        ns.InvalidInput, match="n parcels of a, space between them, must stand on half of the length, 1.5"
    ):
        models.scenes.Conveyor(n=40)


@pytest.mark.parametrize("model", READY, ids=lambda model: model.name)
def test_parameters_of_a_ready_scene_are_described(model):
    for field in dataclasses.fields(model):
        assert re.search(rf"^    (.*, )?{field.name}(, .*)? : ", model.__doc__, re.MULTILINE), field.name


def test_simulate_refuses_a_class_and_what_builds_no_scene():
    class Wrong:
        def scene(self):
            return 3

    with pytest.raises(ns.InvalidInput, match="what scene.. of Wrong returns must be an ns.Scene; got 3"):
        ns.simulate(Wrong(), (0, 1), integrator=ns.MoreauJean(dt=1e-3))
    with pytest.raises(ns.InvalidInput, match="call it first"):
        ns.simulate(models.scenes.BoxStack, (0, 1), integrator=ns.MoreauJean(dt=1e-3))
