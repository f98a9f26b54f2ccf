"""Random planar systems move alike under all integrators, or an event of theirs says why not."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nonsmooth as ns
from benchmarks import stress_random

# several contacts at once have one answer of many, which all integrators give; Newton's law lets friction do work
pytestmark = [
    pytest.mark.filterwarnings(f"ignore::nonsmooth.{told}")
    for told in ("SimultaneousImpactWarning", "FrictionGainWarning")
]


def unexplained(seed):
    with warnings.catch_warnings():
        for expected in (ns.InitialStateWarning, ns.EnergyGainWarning):  # e_N > 0 beside friction may gain energy
            warnings.simplefilter("ignore", expected)
        return [v for v in stress_random.compare(seed) if not v.agrees and (not v.reason or "failure" in v.reason)]


@pytest.mark.upkeep
@settings(max_examples=120, deadline=None, derandomize=True)
@given(st.integers(1000, 10**9))
def test_random_systems_agree_or_say_why_not(seed):
    assert not unexplained(seed)


@pytest.mark.slow
def test_thousands_of_random_systems_agree_or_say_why_not():
    assert not {v.seed for seed in range(3000) for v in unexplained(seed)}


@pytest.mark.parametrize("rtol", [0.97e-8, 1e-8, 1.05e-8, 1.1e-8])
def test_a_slide_that_dies_out_at_the_limit_of_friction_does_not_chatter(rtol):
    """One contact sticks, the other creeps to rest at the limit: the rounding of its velocity changes sign for ever."""
    s = stress_random.sample(340)
    penalty = stress_random.Penalty(stress_random.STIFFNESS, damping_ratio=stress_random.ZETA, rtol=rtol)
    solution = stress_random.run(s, penalty)
    assert solution.success
    assert solution.stats.steps < 50 * (len(solution.events) + 1)  # else steps of one rounding of the time


def test_samples_meet_impacts_slip_and_stick_and_the_bound_is_small_against_the_motion():
    kinds, relative = set(), []
    for seed in range(40):
        s = stress_random.sample(seed)
        exact = stress_random.run(s, stress_random.EventDriven(rtol=1e-8))
        kinds |= {(event.kind.name, event.mode_after.name) for event in exact.events}
        way = stress_random.size(s.M, np.abs(exact.u).max(axis=0)) * stress_random.T_END
        if way > 0:  # some rest
            relative.append(stress_random.bound(s, exact, stress_random.DT) / way)
    assert {("IMPACT", "SLIDE"), ("IMPACT", "STICK"), ("MODE_CHANGE", "STICK"), ("MODE_CHANGE", "OPEN")} <= kinds
    assert np.median(relative) < 1e-2  # else agreement would say nothing


def test_runs_that_differ_are_told_from_those_that_agree():
    s = stress_random.sample(1)
    exact = stress_random.run(s, stress_random.EventDriven(rtol=1e-9, atol=1e-11))
    steps = stress_random.run(s, stress_random.MoreauJean(stress_random.DT))
    other = s.system.with_parameters(h_0=s.system.parameters.h_0 + 1.0)
    assert stress_random.judge(1, s, exact, steps, stress_random.DT).agrees
    pushed = stress_random.run(s._replace(system=other), stress_random.MoreauJean(stress_random.DT))
    assert not stress_random.judge(1, s, exact, pushed, stress_random.DT).agrees
