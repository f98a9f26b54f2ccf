"""Mass on a conveyor: limits of stability, averaged amplitudes, release from the belt."""

from __future__ import annotations

import math

import numpy as np
import pytest

from models import BeltOscillator
from nonsmooth.jit import interpreted
from nonsmooth.laws import Polynomial, friction_coefficient
from nonsmooth.system import NORMAL_FORCE, SURFACE_VELOCITY


def test_limits_of_the_belt_speed_are_the_printed_ones():
    belt = BeltOscillator()
    assert (belt.vb_max(), belt.vb_min()) == pytest.approx((0.440958552, 0.394405319), abs=6e-10)


@pytest.mark.parametrize("vb, a, metres", [
    (0.40, 1.173788, 0.1173788), (0.42, 0.849575, 0.0849575), (0.44, 0.183787, 0.0183787),
])  # fmt: skip
def test_averaged_amplitudes_are_the_printed_ones(vb, a, metres):
    belt = BeltOscillator(vb=vb)
    assert belt.averaged_amplitude() == pytest.approx(a, abs=6e-7)
    assert belt.averaged_amplitude() * belt.N / belt.k == pytest.approx(metres, abs=6e-8)


def test_averaged_motion_touches_the_belt_speed_at_vb_min():
    belt = BeltOscillator(vb=BeltOscillator().vb_min() * (1 + 1e-12))
    assert belt.averaged_amplitude() * belt.N / math.sqrt(belt.k * belt.m) == pytest.approx(belt.vb, rel=1e-9)


@pytest.mark.parametrize("factor, unstable", [(0.999, True), (1.001, False)])
def test_steady_sliding_loses_its_stability_at_vb_max(factor, unstable):
    belt = BeltOscillator(vb=factor * BeltOscillator().vb_max())
    assert (belt.eigenvalues().real.max() > 0) == unstable
    assert (belt.averaged_amplitude() > 0) == unstable


@pytest.mark.parametrize("vb, y_end", [
    (0.05, 0.0017425), (0.10, 0.0034400), (0.20, 0.0065200), (0.30, 0.0088800), (0.35, 0.0096775), (0.39, 0.0100909),
])  # fmt: skip
def test_mass_leaves_the_belt_at_the_printed_position(vb, y_end):
    belt = BeltOscillator(vb=vb)
    assert belt.release_position() - belt.equilibrium() == pytest.approx(y_end, abs=6e-8)


def test_friction_is_odd_and_equals_the_law_of_the_contact():
    belt = BeltOscillator()
    system = belt.system()
    mu = interpreted(friction_coefficient)
    for v in (0.05, 0.3, 0.9):
        assert belt.friction(v) == -belt.friction(-v) == pytest.approx(mu(system.laws, 0, v), rel=1e-15)
    slope = (belt.friction(belt.vb + 1e-6) - belt.friction(belt.vb - 1e-6)) / 2e-6
    assert belt.slope() == pytest.approx(slope, rel=1e-8)
    assert isinstance(system.contacts[0].law, Polynomial)


def test_contact_has_the_given_normal_force_and_the_speed_of_the_belt():
    system = BeltOscillator(N=2.5, vb=0.3).system()
    q = u = np.zeros(1)
    assert system.evaluate(NORMAL_FORCE, 0.0, q, u) == [2.5]
    assert system.evaluate(SURFACE_VELOCITY, 0.0, q, u) == [[-0.3]]


def test_constant_friction_keeps_steady_sliding_stable_at_any_speed():
    belt = BeltOscillator(m1=0.0, m3=0.0)
    assert belt.vb_max() == 0.0 == belt.averaged_amplitude()
    assert belt.eigenvalues().real.max() == pytest.approx(-0.05)
    assert belt.equilibrium() == pytest.approx(0.04)


def test_friction_that_only_falls_is_unstable_at_any_speed():
    assert BeltOscillator(m3=0.0).vb_max() == math.inf
