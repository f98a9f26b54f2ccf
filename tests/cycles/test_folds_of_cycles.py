"""A branch of cycles goes round its folds: closed forms of first-order averaging, and what it says where it ends."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, SpragSlip
from nonsmooth.cycles.cycle_margins import least_p, paradox_at


class Quintic(NamedTuple):
    """x'' + x + d x' - b x'^3 + f x'^5 = 0: damped when slow, fed at middle speeds, damped when fast."""

    d: float = 0.02
    b: float = 0.1
    f: float = 0.05


def mass(t, q, p, M):
    M[0, 0] = 1.0


def force(t, q, u, p, h):
    h[0] = -q[0] - p.d * u[0] + p.b * u[0] ** 3 - p.f * u[0] ** 5


def oscillator(**change):
    return ns.System(n_q=1, mass=mass, force=force, parameters=Quintic(**change))


def averaged(p):
    """a' = -a (d/2 - 3/8 b A + 5/16 f A^2), A = a^2: both amplitudes, the stable one first."""
    root = math.sqrt((0.375 * p.b) ** 2 - 0.625 * p.f * p.d)
    return [math.sqrt((0.375 * p.b + s * root) / (0.625 * p.f)) for s in (1, -1)]


def fold_of(p):
    """The damping at which both meet, 9 b^2/(40 f)."""
    return 9 * p.b**2 / (40 * p.f)


@pytest.fixture(scope="module")
def branch():
    return ns.continue_cycle(oscillator(), "d", [0.02, 0.03, 0.04, 0.05], ns.limit_cycle(
        oscillator(), ([1.7], [0.0]), duration=200.0))  # fmt: skip


def test_branch_goes_round_the_fold_where_stable_and_unstable_cycles_meet(branch):
    (fold,) = [change for change in branch.changes if change.kind == "fold"]
    # averaging errs in the second order of the damping's parts, (b a^2)^2 = 0.01
    assert fold.value == pytest.approx(fold_of(Quintic()), rel=0.01)
    k = int(np.argmax(branch.values))
    assert branch.values[k] == fold.value and (np.diff(branch.values[: k + 1]) > 0).all()
    assert branch.values[k + 1 :].tolist() == [0.04, 0.03, 0.02]
    assert all(cycle.is_stable for cycle in branch.cycles[:k])
    assert not any(cycle.is_stable or cycle.is_marginal for cycle in branch.cycles[k + 1 :])


def test_both_cycles_have_the_averaged_amplitudes(branch):
    for value, cycle in zip(branch.values, branch.cycles, strict=True):
        if value in (0.02, 0.03, 0.04):
            stable, unstable = averaged(Quintic(d=value))
            expected = stable if cycle.is_stable else unstable
            assert cycle.amplitudes[0] == pytest.approx(expected, rel=5e-3)


def test_multiplier_is_one_at_the_fold_and_both_cycles_reach_up_to_it(branch):
    k = int(np.argmax(branch.values))
    # the multiplier departs from 1 as the square root of the parameter's error, 1e-10 or less
    assert branch.cycles[k].multipliers[0] == pytest.approx(1.0, abs=1e-4)
    below = branch.values[k] * (1 - 1e-6)
    for cycle in branch.cycles[k - 1 : k + 2 : 2]:
        near = ns.continue_cycle(oscillator(), "d", [cycle.system.parameters.d, below], cycle)
        assert near.values.tolist() == [cycle.system.parameters.d, below]


def test_branch_that_shrinks_to_a_rest_ends_there_and_is_no_fold(branch):
    small = branch.cycles[-1]
    shrinking = ns.continue_cycle(oscillator(), "d", [0.02, 0.01, 0.005, 0.002, -0.002], small)
    assert shrinking.values.tolist() == [0.02, 0.01, 0.005, 0.002]
    (end,) = shrinking.changes
    assert end.kind == "end" and "rest" in end.message


def test_cycle_leaves_the_paradoxical_states_where_its_greatest_angle_is_that_of_zero_inertia():
    """Sprag-slip rod, set 1: M+ = 0 at th = 0.850692310; the cycle shrinks as the damper grows."""
    rod = SpragSlip.set_1(cth=3.0)
    branch = ns.continue_cycle(rod, "cth", [3.0, 3.1], ns.limit_cycle(rod))
    (exit_,) = branch.changes
    assert exit_.kind == "paradox exit" and "indeterminate, 2 solutions" in exit_.message
    there = ns.limit_cycle(SpragSlip.set_1(cth=exit_.value), branch.cycles[0])
    assert there.extremes[1][1] == pytest.approx(0.850692310, abs=2e-8)
    assert branch.cycles[0].extremes[1][1] > rod.paradoxical_angles()[0] > branch.cycles[1].extremes[1][1]


def test_least_p_is_that_of_classify_and_of_the_closed_form():
    rod = SpragSlip.set_1(cth=0.5)
    cycle = ns.limit_cycle(rod)
    least, x = least_p(cycle)
    th, inertia = x[1], rod.m * rod.l**2 * math.cos(x[1]) ** 2
    assert least == pytest.approx((rod.I + inertia * (1 - rod.mu * math.tan(th))) / (rod.I + inertia), rel=1e-9)
    assert x[1] == pytest.approx(0.899886645, abs=2e-8)  # printed: the greatest angle of the cycle
    found = ns.classify(rod, 0.0, x[:2], x[2:])
    assert found.n_solutions == 2 and paradox_at(cycle, x) == "indeterminate, 2 solutions"


def test_cycle_of_a_given_normal_force_meets_no_paradox():
    assert least_p(ns.limit_cycle(BeltOscillator(vb=0.2)))[0] == math.inf
