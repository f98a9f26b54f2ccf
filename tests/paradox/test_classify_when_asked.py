"""What is found when it is first asked for is that of the state that was classified, whatever came in between."""

from __future__ import annotations

import copy
import itertools
import math
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import nonsmooth as ns
from models import BilateralRod, PainleveRod, RockingBlock, SpragSlip
from tests.systems import block

ROD = PainleveRod(mu=2.0)
STATES = [ROD.state(thdot=thdot, slip=slip) for thdot in (0.0, 3.0, 6.0) for slip in (-1.0, 0.0, 1.0)]


def said(c):
    """All that a classification says, to the last bit."""
    return repr(c.to_dict()) + repr([solution.stability.rho.tobytes() for solution in c.solutions])


def asked_at_once(system, state):
    return said(ns.classify(system, 0.0, *state))


def test_other_states_of_the_system_do_not_change_what_is_asked_for_late():
    at_once = [asked_at_once(ROD, state) for state in STATES]
    late = [ns.classify(ROD, 0.0, *state) for state in STATES]
    assert [said(c) for c in late] == at_once
    assert len(set(at_once)) == len(STATES)


def test_writing_into_the_state_of_a_classification_does_not_change_its_impacts():
    c, untouched = (ns.classify(ROD, 0.0, *ROD.state(thdot=0.0)) for _ in range(2))
    c.q[:], c.u[:] = 7.0, 7.0
    assert [impact.u.tobytes() for impact in c.impacts] == [impact.u.tobytes() for impact in untouched.impacts]


def test_another_system_of_the_same_sizes_in_between_changes_nothing():
    other = BilateralRod(mu=1.5)  # as many coordinates and contacts: it is searched in the same memory
    at_once = asked_at_once(ROD, STATES[0])
    c = ns.classify(ROD, 0.0, *STATES[0])
    ns.classify(other, 0.0, *other.state())
    assert said(c) == at_once


def test_threads_do_not_disturb_one_another():
    at_once = [asked_at_once(ROD, state) for state in STATES]
    with ThreadPoolExecutor(4) as pool:
        late = list(pool.map(lambda state: ns.classify(ROD, 0.0, *state), STATES * 8))
    assert [said(c) for c in late] == at_once * 8


@pytest.mark.parametrize("duplicate", [copy.deepcopy, lambda c: pickle.loads(pickle.dumps(c))])
def test_a_copy_says_the_same_without_the_system(duplicate):
    c = ns.classify(ROD, 0.0, *STATES[2])
    assert said(duplicate(c)) == asked_at_once(ROD, STATES[2])
    assert "system" not in repr(vars(duplicate(c)))


def test_number_that_is_known_at_once_is_that_of_the_islands_and_of_the_solutions():
    rng = np.random.default_rng(3)
    counts = set()
    for model, _ in itertools.product((PainleveRod, SpragSlip, RockingBlock), range(20)):
        rod = model() if model is RockingBlock else model(mu=float(rng.uniform(0.1, 3.0)))
        if model is PainleveRod:
            state = rod.state(th=float(rng.uniform(0.2, 1.4)), thdot=float(rng.normal(0.0, 4.0)))
        else:
            state = rod.state()
        c = ns.classify(rod, 0.0, *state)
        counts.add(c.n_solutions)
        assert c.is_complete and c.n_solutions == math.prod(i.n_solutions for i in c.islands) == len(c.solutions)
    assert counts == {0, 1, 2}


LEVEL = 0.5  # of the friction law below


def speed_law(v, p):
    return LEVEL + 0.0 * v


def test_a_law_of_the_users_is_followed_as_it_is_now(monkeypatch):
    """The search keeps what it needs of a system; a law that reads a number that was changed since is another law."""
    system = block(contact=ns.Contact(mu=ns.Friction(speed_law)))
    found = [ns.classify(system, 0.0, [0.0, 0.0], [1.0, 0.0]).mu[0] for _ in range(3)]
    monkeypatch.setitem(globals(), "LEVEL", 0.25)
    after = ns.classify(system, 0.0, [0.0, 0.0], [1.0, 0.0])
    assert found == [0.5] * 3 and after.mu[0] == 0.25
    assert after.solutions[0].la_F[0] == -0.25 * after.solutions[0].la_N[0]
