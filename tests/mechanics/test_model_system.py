"""The system that a model builds: kept for models that can be keys, built anew for others, and asked for once."""

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


def test_a_model_that_can_be_a_key_builds_its_system_once_and_another_each_time():
    for model, calls in ((Counted(), 1), (Unhashable(), 2)):
        systems = [as_system(model), as_system(model)]
        assert (model.calls, len(set(map(id, systems)))) == (calls, calls)


@pytest.mark.parametrize("kind", [Counted, Unhashable])
def test_a_type_error_of_a_model_comes_out_of_its_first_call(kind):
    model = kind(fails=True)
    with pytest.raises(TypeError):
        as_system(model)
    assert model.calls == 1
