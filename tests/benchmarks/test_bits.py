"""The hashes that say whether a change of the code changed a bit."""

import numpy as np

import nonsmooth as ns
from benchmarks import bits
from models import BouncingBall


def run_of(height):
    ball = BouncingBall()
    return ns.simulate(ball, (0, 0.6), *ball.state(height=height), integrator=ns.MoreauJean(1e-3))


def test_runs_with_the_same_bits_have_the_same_hash_and_no_others():
    assert bits.digest(run_of(1.0)) == bits.digest(run_of(1.0))
    assert bits.digest(run_of(1.0)) != bits.digest(run_of(np.nextafter(1.0, 2.0)))


def test_what_differs_or_is_gone_is_named(capsys):
    assert bits.compare({"a": "1", "b": "2"}, {"a": "1", "b": "2"}) == 0
    assert bits.compare({"a": "1", "b": "2", "c": "3"}, {"a": "1", "b": "4"}) == 1
    named = capsys.readouterr().out
    assert "1 of 3" in named and "differs: b" in named and "differs: c" in named and "differs: a" not in named


def test_cases_cover_every_model_integrator_and_selection_rule():
    names = [name for name, _ in bits.cases("compiled")]
    assert len(names) == len(set(names))
    assert {name.split(" | ")[1] for name in names} == set(bits.integrators(1e-3))
