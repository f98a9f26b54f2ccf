"""Mass on a conveyor: limits of stability, averaged amplitudes, release from the belt."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator
from nonsmooth.drawing.labels import spelt
from nonsmooth.jit import interpreted
from nonsmooth.mechanics.laws import Polynomial, friction_coefficient, static_coefficient
from nonsmooth.mechanics.system import NORMAL_FORCE, SURFACE_VELOCITY


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


LAWS = ["cubic", "smoothed", "two-coefficient", "stribeck"]


@pytest.mark.parametrize("law", LAWS)
def test_friction_of_the_model_is_the_law_that_its_contact_integrates(law):
    belt = BeltOscillator(law=law, r=7.0, mu_k=0.25, v_s=0.3, m_v=0.05, vb=0.3)
    laws, mu = belt.system().laws, interpreted(friction_coefficient)
    v = np.array([0.02, 0.3, 0.9])
    np.testing.assert_allclose(belt.friction(v), [mu(laws, 0, x) for x in v], rtol=1e-15)
    np.testing.assert_array_equal(belt.friction(-v), -belt.friction(v))
    h = 1e-5  # central difference: truncation r^2 h^2/6 = 1e-9 of the slope, rounding 1e-11
    np.testing.assert_allclose(belt.slope(v), (belt.friction(v + h) - belt.friction(v - h)) / (2 * h), atol=1e-7)
    assert belt.slope() == belt.slope(belt.vb)


@pytest.mark.parametrize("law, limit", [("cubic", 0.4), ("smoothed", 0.0), ("two-coefficient", 0.4), ("stribeck", 0.4)])
def test_limit_of_sticking_is_m0_except_under_the_smoothed_law(law, limit):
    assert interpreted(static_coefficient)(BeltOscillator(law=law).system().laws, 0) == limit


@pytest.mark.parametrize("r, low, high", [(20.0, 0.163896782, 0.440201331), (200.0, 0.027178274, 0.440958552)])
def test_smoothed_friction_is_unstable_between_the_printed_speeds(r, low, high):
    belt = BeltOscillator(law="smoothed", r=r)
    assert belt.unstable_speeds() == pytest.approx((low, high), abs=6e-10)


@pytest.mark.parametrize("belt", [
    BeltOscillator(), BeltOscillator(law="smoothed"), BeltOscillator(law="smoothed", r=200.0),
    BeltOscillator(law="stribeck"),
])  # fmt: skip
def test_growth_changes_its_sign_at_the_ends_of_the_unstable_speeds(belt):
    low, high = belt.unstable_speeds()
    for end, inwards in ((low, 1), (high, -1)):
        for step in (1e-6, -1e-6):
            if end + inwards * step > 0:
                growth = replace(belt, vb=end + inwards * step).eigenvalues().real.max()
                assert (growth > 0) == (step > 0)


@pytest.mark.parametrize("belt", [
    BeltOscillator(law="two-coefficient"), BeltOscillator(law="smoothed", r=1.0), BeltOscillator(law="stribeck", c=9.0),
    BeltOscillator(law="smoothed", N=0.0), BeltOscillator(c=1.0),
])  # fmt: skip
def test_friction_that_does_not_fall_enough_is_stable_at_every_speed(belt):
    assert belt.unstable_speeds() is None
    assert all(replace(belt, vb=vb).eigenvalues().real.max() <= 0 for vb in np.linspace(0.01, 2.0, 50))


def test_stribeck_speed_of_instability_is_its_closed_form():
    belt = BeltOscillator(law="stribeck", m0=0.4, mu_k=0.3, v_s=0.1, c=0.1, N=2.0)
    assert belt.unstable_speeds() == (0.0, pytest.approx(0.1 * math.log(2.0 / 0.1), rel=1e-14))


def test_averaged_rate_vanishes_at_the_averaged_amplitude_and_beyond_the_belt_speed_friction_brakes():
    belt = BeltOscillator(vb=0.42)
    assert belt.averaged_rate(belt.averaged_amplitude()) == pytest.approx(0.0, abs=1e-15)
    Lo = belt.N / math.sqrt(belt.k * belt.m)
    touching = belt.vb / Lo
    assert belt.averaged_rate(1.01 * touching) < belt.averaged_rate(touching) - 0.03  # (2 m0/pi) sqrt(0.02) = 0.036


@pytest.mark.parametrize("vb, a", [
    (0.2, 0.369234), (0.25, 0.590843), (0.3, 0.752423), (0.35, 0.856938), (0.4, 0.828605), (0.44, 0.078412),
])  # fmt: skip
def test_averaged_rate_of_the_smoothed_law_vanishes_at_the_printed_amplitudes(vb, a):
    belt = BeltOscillator(law="smoothed", r=20.0, vb=vb)
    assert belt.averaged_rate(a - 6e-7) > 0 > belt.averaged_rate(a + 6e-7)


def test_power_series_of_the_averaged_equation_has_the_corrected_coefficients():
    belt = BeltOscillator(law="smoothed", r=20.0, vb=0.3)
    Lo, k_4 = belt.N / math.sqrt(belt.k * belt.m), belt.m0 * math.exp(-belt.r * belt.vb)
    without = replace(belt, law="cubic")
    for a in (0.1, 0.5, 0.9):
        terms = [(belt.r * Lo * a / 2) ** (2 * n + 1) / (math.factorial(n) * math.factorial(n + 1)) for n in range(40)]
        assert belt.averaged_rate(a) - without.averaged_rate(a) == pytest.approx(-k_4 * sum(terms), rel=1e-13)


@pytest.mark.parametrize("law", ["cubic", "smoothed", "two-coefficient", "stribeck"])
def test_titles_name_the_parameters_that_change_the_motion_and_no_other(law):
    """What is idle changes no bit, and what is not changes some."""
    belt = BeltOscillator(law=law, m_v=0.1)
    span, start, steps = (0, 10.0), ([0.0], [0.2]), ns.MoreauJean(1e-2)
    sol = ns.simulate(belt, span, *start, integrator=steps)
    title = sol.plot().get_suptitle()
    for name, value in belt.system().parameter_values.items():
        other = replace(belt, **{name: 0.9 * value})
        is_read = not np.array_equal(ns.simulate(other, span, *start, integrator=steps).q, sol.q)
        assert is_read == (f"{spelt(name)} = " in title) == (name not in belt.idle), name
    task = ns.RunTask(belt, t_span=(0, 0.1), integrator=steps)
    assert not any(f"{name} = " in task.about["parameters"] for name in belt.idle)
