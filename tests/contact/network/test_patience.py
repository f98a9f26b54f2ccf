"""The rule by which a method that was in vain is left out for a while."""

import itertools

import numpy as np
import pytest

from nonsmooth.contact.network.patience import (
    ABSENCE_GROWTH,
    AT_REST,
    CREDIT,
    FACTORS,
    INTERIOR,
    LONG_SWEEPS,
    LONGEST_ABSENCE,
    MANY_FACTORS,
    OTHER_STARTS,
    Patience,
    begin_problem,
    copy_patience,
    note_outcome,
)
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new

METHODS = [FACTORS, MANY_FACTORS, LONG_SWEEPS, AT_REST, INTERIOR, OTHER_STARTS]


def note(patience, method, has_paid, cost=0, least=1):
    interpreted(note_outcome)(patience, method, has_paid, cost, least)


def problems_left_out(patience, method):
    """How many problems pass until the method is tried again."""
    count = 0
    while patience.left[method] > 0:
        interpreted(begin_problem)(patience)
        count += 1
    return count


@pytest.mark.parametrize("least", [1, 20])
@pytest.mark.parametrize("method", METHODS)
def test_a_method_in_vain_is_left_out_some_times_as_long_each_time_until_it_pays(method, least):
    patience = new(Patience)
    for _ in range(2):
        waits = []
        for _ in range(12):
            note(patience, method, False, CREDIT[method], least)
            waits.append(problems_left_out(patience, method))
        assert waits[0] == least and waits[-1] <= LONGEST_ABSENCE[method]
        for before, after in itertools.pairwise(waits):
            assert after == min(ABSENCE_GROWTH[method] * before + 1, LONGEST_ABSENCE[method])
        note(patience, method, True)
        assert patience.left[method] == patience.wait[method] == 0


def test_a_method_with_credit_is_left_out_when_it_is_spent_and_gets_it_again():
    patience, cost = new(Patience), 100
    for _ in range(2):
        for _ in range((CREDIT[AT_REST] - 1) // cost):
            note(patience, AT_REST, False, cost)
            assert patience.left[AT_REST] == 0
        note(patience, AT_REST, False, cost)
        assert patience.left[AT_REST] > 0
    note(patience, AT_REST, False, cost)
    note(patience, AT_REST, True)
    assert patience.spent[AT_REST] == 0


def test_methods_are_known_apart_and_copied_together():
    patience, copy = new(Patience), new(Patience)
    note(patience, MANY_FACTORS, False)
    note(patience, AT_REST, False, 7)
    assert np.flatnonzero(patience.left).tolist() == [MANY_FACTORS] and patience.spent[AT_REST] == 7
    interpreted(copy_patience)(patience, copy)
    assert (copy.words.view(np.int64) == patience.words.view(np.int64)).all()
