"""Cycles at parameters that nobody printed: shooting against long event-driven motions, averaging against cycles."""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, LeadScrew, ModeCoupling, SpragSlip

LAWS = ("cubic", "smoothed", "two-coefficient", "stribeck")


def belt(rng):
    m0 = rng.uniform(0.2, 0.8)
    return BeltOscillator(
        m=rng.uniform(0.5, 3), k=rng.uniform(2, 100), c=rng.uniform(0.01, 0.3), N=rng.uniform(0.3, 5), m0=m0,
        m1=rng.uniform(0.1, 0.8), m3=rng.uniform(0.2, 2), vb=rng.uniform(0.03, 0.5), r=10 ** rng.uniform(1, 2.5),
        mu_k=m0 * rng.uniform(0.4, 0.95), v_s=rng.uniform(0.05, 0.4), law=str(rng.choice(LAWS)),
    )  # fmt: skip


def coupling(rng):
    return ModeCoupling(
        m=rng.uniform(0.5, 3), k=rng.uniform(50, 200), kx=rng.uniform(50, 200), kz=rng.uniform(100, 400),
        cx=rng.uniform(0.2, 3), cz=rng.uniform(0.2, 3), mu=rng.uniform(0.6, 1.2), R=1e5, vb=rng.uniform(1, 15),
    )  # fmt: skip


def sprag(rng):
    return SpragSlip(
        m=rng.uniform(0.8, 2.2), mu=rng.uniform(1.1, 1.35), cth=rng.uniform(0.2, 3.0), vb=rng.uniform(5, 12)
    )


def settled(model, duration):
    """Half the swing of every coordinate over the last fifth of a long motion, and the time between its last rises."""
    run = ns.simulate(model, (0.0, duration), *model.state(), integrator=ns.EventDriven(rtol=1e-9, atol=1e-12))
    late = run.t > 0.8 * duration
    q, t = run.q[late], run.t[late]
    half = 0.5 * np.ptp(q, axis=0)
    y = q[:, int(np.argmax(half))]
    y = y - 0.5 * (y.max() + y.min())
    k = np.flatnonzero((y[:-1] < 0) & (y[1:] >= 0))
    rises = t[k] - y[k] * (t[k + 1] - t[k]) / (y[k + 1] - y[k])
    return half, np.diff(rises)


def agrees(model, duration):
    """Whether there is a cycle; it must be that of the long motion."""
    half, periods = settled(model, duration)
    try:
        cycle = ns.limit_cycle(model)
    except ns.InvalidInput as refused:
        # refused in words that name the reason: the motion has died out, or is still dying
        assert any(word in str(refused) for word in ("rest", "dies out", "does not close", "normal force"))
        return False
    # the motion is recorded at its steps only: swings are read to 1e-2, rises to the square of a step
    np.testing.assert_allclose(half, cycle.amplitudes, rtol=2e-2)
    turns = cycle.period / np.median(periods)
    assert round(turns) >= 1 and turns == pytest.approx(round(turns), rel=1e-3)
    assert cycle.is_stable and cycle.residual < 1e-8
    return True


@pytest.mark.upkeep
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow), pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "draw, duration, least",
    [(belt, 200.0, 1), pytest.param(coupling, 300.0, 3, marks=pytest.mark.slow), (sprag, 12.0, 2)],
)
def test_cycles_at_random_parameters_are_those_of_long_motions(draw, duration, least, seed):
    rng = np.random.default_rng(seed)
    assert sum(agrees(draw(rng), duration) for _ in range(4)) >= least


@pytest.mark.parametrize("weak", [0.2, 0.05])
def test_averaging_errs_in_the_first_order_of_the_nonlinearity(weak):
    """Damping and friction scaled by N: the averaged amplitude of the smoothed law against the exact cycle."""
    plain = BeltOscillator(law="smoothed", r=20.0, vb=0.3, N=weak, c=0.1 * weak)
    amplitude = ns.averaged_amplitude(plain).amplitude
    assert amplitude > 0
    start = plain.state(x=plain.equilibrium() + amplitude, velocity=0.0)
    cycle = ns.limit_cycle(plain, start, duration=100.0)
    assert cycle.amplitudes[0] == pytest.approx(amplitude, rel=0.2 * weak)


def test_screw_whose_drive_stands_still_comes_to_rest_and_a_turning_one_has_no_period():
    with pytest.raises(ns.InvalidInput, match="come to rest"):
        ns.limit_cycle(LeadScrew())
    with pytest.raises(ns.InvalidInput, match="change with time"):
        ns.limit_cycle(LeadScrew(omega=2.0))
