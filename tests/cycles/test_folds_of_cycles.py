"""A branch of cycles goes round its folds: closed forms of first-order averaging, and what it says where it ends."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

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


@pytest.mark.upkeep
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


@pytest.mark.upkeep
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


# where steady sliding is stable beside the cycle: the fold is at the cycle that grazes


class Belt(NamedTuple):
    """A unit mass and spring on a belt whose friction falls with the speed, mu_k + (mu_s - mu_k) exp(-v/v_s)."""

    v: float = 2.4
    c: float = 0.02
    mu_s: float = 0.4
    mu_k: float = 0.2
    v_s: float = 0.5


def on_the_belt(t, q, u, p, h):
    h[0] = -q[0] - p.c * u[0]


def along_the_belt(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0


def speed_of_the_belt(t, q, p, w_F):
    w_F[0, 0] = -p.v


def unit_load(t, q, u, p, N):
    N[0] = 1.0


def belt(**change):
    p = Belt(**change)
    law = ns.Stribeck(mu_s=p.mu_s, mu_k=p.mu_k, v_s=p.v_s, delta=1.0, m_v=0.0)
    return ns.System(coordinates=["x"], mass=mass, force=on_the_belt, tangent=along_the_belt, parameters=p,
                     surface_velocity=speed_of_the_belt, normal_force=unit_load,
                     contacts=[ns.Contact(mu=law, normal_force=True)])  # fmt: skip


def speed_where_the_sliding_cycle_grazes(p):
    """From the speed of the belt, where its friction lets go of the mass (x'' = 0), the mass slides to its next
    greatest speed: that of the belt again."""

    def rate(t, y, v):
        return [y[1], -y[0] - p.c * y[1] + p.mu_k + (p.mu_s - p.mu_k) * math.exp(-(v - y[1]) / p.v_s)]

    def comes_short(v):
        def at_its_greatest(t, y):
            return rate(t, y, v)[1]

        at_its_greatest.direction, at_its_greatest.terminal = -1, True
        begins = [p.mu_s - p.c * v, v]
        aside = solve_ivp(lambda t, y: rate(t, y, v), (0, 0.1), begins, rtol=1e-12, atol=1e-13).y[:, -1]
        found = solve_ivp(lambda t, y: rate(t, y, v), (0, 20), aside, events=at_its_greatest, rtol=1e-12, atol=1e-13)
        return found.y[1, -1] - v

    return brentq(comes_short, 2.0, 4.0, xtol=1e-11)


@pytest.mark.upkeep
def test_a_stick_slip_cycle_beside_stable_sliding_meets_the_unstable_one_at_the_cycle_that_grazes():
    values = [2.6, 2.8, 3.0, 3.2]
    branch = ns.continue_cycle(belt(), "v", values, state=([0.4], [2.6]), duration=300.0)
    (fold,) = [change for change in branch.changes if change.kind == "fold"]
    assert fold.value == pytest.approx(speed_where_the_sliding_cycle_grazes(Belt()), rel=1e-8)
    assert branch.values.tolist() == [2.6, 2.8, 3.0, fold.value, 3.0, 2.8, 2.6]
    sticking, free = branch.cycles[:3], branch.cycles[3:]
    assert all(cycle.stick_duration > 0 and cycle.is_stable for cycle in sticking)
    assert all(cycle.stick_duration == 0 and abs(cycle.multipliers[0]) > 1.2 for cycle in free)
    for outer, inner in zip(sticking, free[:0:-1], strict=True):
        assert inner.amplitudes[0] < outer.amplitudes[0]
    # from the one side of the unstable cycle the mass goes to steady sliding, from the other to the stick-slip motion
    inner, at = free[-1], belt(v=2.6)
    for share, ends in ((0.97, 0.0), (1.03, sticking[0].amplitudes[0])):
        start = [(inner.q[0] - 0.2) * share + 0.2, inner.u[0] * share]
        run = ns.simulate(at, (0, 400.0), *start, integrator=ns.EventDriven(1e-9, 1e-11))
        late = run.t > 390.0
        assert 0.5 * np.ptp(run.q[late, 0]) == pytest.approx(ends, abs=0.2)


@pytest.mark.upkeep
def test_the_branch_turns_where_the_unstable_cycle_begins_to_stick_too():
    stable = ns.limit_cycle(belt(v=3.0), ([0.4], [3.0]), duration=300.0)
    branch = ns.continue_cycle(belt(), "v", [3.0, 3.2], cycle=stable)
    unstable = branch.cycles[-1]
    back = ns.continue_cycle(belt(), "v", [3.0, 3.2], cycle=unstable)
    assert [change.kind for change in back.changes] == ["fold"]
    assert back.changes[0].value == pytest.approx(branch.changes[0].value, rel=1e-9)
    assert back.cycles[-1].period == pytest.approx(stable.period, rel=1e-8) and back.cycles[-1].stick_duration > 0


@pytest.mark.upkeep
def test_a_smooth_fold_beside_stable_sliding_is_gone_round():
    """The quintic oscillator on a belt that is faster than it ever is: Coulomb's force is constant."""
    fast = ns.System(
        coordinates=["x"], mass=mass, force=force, tangent=along_the_belt, surface_velocity=fast_belt,
        normal_force=unit_load, contacts=[ns.Contact(mu=0.3, normal_force=True)], parameters=Quintic(),
    )  # fmt: skip
    values = [0.02, 0.03, 0.04, 0.05]
    on_it = ns.continue_cycle(fast, "d", values, state=([2.0], [0.0]), duration=200.0)
    alone = ns.continue_cycle(oscillator(), "d", values, state=([1.7], [0.0]), duration=200.0)
    assert [change.kind for change in on_it.changes] == [change.kind for change in alone.changes] == ["fold"]
    assert on_it.changes[0].value == pytest.approx(alone.changes[0].value, rel=1e-8)
    assert on_it.amplitudes == pytest.approx(alone.amplitudes, rel=1e-6)


def fast_belt(t, q, p, w_F):
    w_F[0, 0] = -30.0
