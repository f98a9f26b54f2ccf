"""First-order averaging: printed amplitudes, closed forms, overtaking, other oscillators."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, FollowerForceArm, SpragSlip
from nonsmooth.equilibria.oscillator import accelerate
from nonsmooth.jit import interpreted

LENGTH = 0.1  # N/k of the default belt [m]: the printed amplitudes are in this unit
OMEGA = np.sqrt(10.0)

# Printed: corrected table of the textbook chapter, mass on a conveyor, averaged columns; 0: no cycle.
R_20 = [(0.05, 0), (0.10, 0), (0.20, 0.369234), (0.25, 0.590843), (0.30, 0.752423), (0.35, 0.856938),
        (0.40, 0.828605), (0.44, 0.078412)]  # fmt: skip
R_200 = [(0.05, 0.125493), (0.10, 0.303254), (0.20, 0.633105), (0.25, 0.793187), (0.30, 0.949947), (0.35, 1.100838),
         (0.40, 1.171261), (0.44, 0.183787)]  # fmt: skip
CUBIC = [(0.40, 1.173788), (0.42, 0.849575), (0.44, 0.183787)]


def belts():
    for law, r, rows in (("smoothed", 20.0, R_20), ("smoothed", 200.0, R_200), ("cubic", 20.0, CUBIC)):
        for vb, a in rows:
            yield BeltOscillator(law=law, r=r, vb=vb), a


@pytest.mark.parametrize("belt, a", list(belts()), ids=lambda value: f"{value.law}-{value.r:g}-{value.vb:g}"
                         if isinstance(value, BeltOscillator) else "")  # fmt: skip
def test_averaged_amplitudes_are_the_printed_ones(belt, a):
    motion = ns.averaged_amplitude(belt)
    assert motion.amplitude / LENGTH == pytest.approx(a, abs=6e-7)
    assert motion.is_stable.tolist() == ([True] if a == 0 else [False, True])
    assert motion.omega == pytest.approx(OMEGA, rel=1e-15)


@pytest.mark.parametrize("belt", [
    BeltOscillator(vb=0.42), BeltOscillator(vb=0.1), BeltOscillator(vb=-0.3), BeltOscillator(vb=0.3, law="smoothed"),
    BeltOscillator(vb=0.3, law="smoothed", r=200.0), BeltOscillator(vb=0.3, m=2.5, k=40.0, N=3.0, c=0.4),
], ids=lambda belt: f"{belt.law}-{belt.vb:g}")  # fmt: skip
def test_quadrature_agrees_with_the_closed_form_with_and_without_overtaking(belt):
    motion = ns.averaged_amplitude(belt)
    length, omega = belt.N / belt.k, np.sqrt(belt.k / belt.m)
    touching = abs(belt.vb) / omega
    factors = (0.01, 0.3, 0.9, 0.999) + ((1.001, 1.5, 4.0) if belt.law == "cubic" else ())
    for a in touching * np.array(factors):
        closed = belt.averaged_rate(a / length) * length * omega
        assert motion.rate(a) == pytest.approx(closed, rel=1e-9, abs=1e-13 * omega)


@pytest.mark.parametrize("vb, overtakes", [(0.1, True), (0.39, True), (0.40, False)])
def test_averaged_motion_overtakes_the_belt_below_vb_min(vb, overtakes):
    motion = ns.averaged_amplitude(BeltOscillator(vb=vb))
    assert motion.overtakes.tolist() == [False, overtakes]
    assert (motion.omega * motion.amplitude > vb) == overtakes


def test_growth_from_steady_sliding_is_the_linear_one():
    belt = BeltOscillator(vb=0.3)
    a = 1e-6
    assert ns.averaged_amplitude(belt).rate(a) / a == pytest.approx(-(belt.c + belt.N * belt.slope()) / 2, rel=1e-6)
    assert ns.averaged_amplitude(belt).rate(0.0) == 0.0


def test_dry_friction_at_rest_brakes_linearly_in_time():
    # vb -> 0: a' = -2 mu N/(pi m omega), the well-known linear decay (here with a belt a thousand times slower).
    belt = BeltOscillator(m1=0.0, m3=0.0, c=0.0, vb=1e-5)
    motion = ns.averaged_amplitude(belt)
    expected = -2 * belt.m0 * belt.N / (np.pi * belt.m * motion.omega)
    assert motion.rate(0.1) == pytest.approx(expected, rel=1e-8)  # (vb/(a omega))^2/2 = 5e-10
    assert motion.amplitudes.size == 1


class Spring(NamedTuple):
    e: float = 0.1
    nu: float = 1.0


def free(force):
    def mass(t, q, p, M):
        M[0, 0] = 1.0

    return ns.System(n_q=1, mass=mass, force=force, parameters=Spring())


def test_van_der_pol_oscillator_has_the_amplitude_two():
    def force(t, q, u, p, h):
        h[0] = -q[0] + p.e * (1.0 - q[0] * q[0]) * u[0]

    motion = ns.averaged_amplitude(free(force), largest=10.0)
    np.testing.assert_allclose(motion.amplitudes, [0.0, 2.0], rtol=1e-12)
    assert motion.is_stable.tolist() == [False, True]
    assert motion.rate(1.0) == pytest.approx(0.1 / 2 * (1 - 1 / 4), rel=1e-12)


def test_oscillator_with_two_cycles_has_both_with_opposite_stability():
    # e (-1 + 4 A^2/4 ... ): h = e(-u + 5 x^2 u - 2 x^4 u), a' = e a/2 (-1 + 5 a^2/4 - a^4/4): a^2 = 1 and 4
    def force(t, q, u, p, h):
        h[0] = -q[0] + p.e * u[0] * (-1.0 + 5.0 * q[0] ** 2 - 2.0 * q[0] ** 4)

    motion = ns.averaged_amplitude(free(force), largest=10.0)
    np.testing.assert_allclose(motion.amplitudes, [0.0, 1.0, 2.0], rtol=1e-11)
    assert motion.is_stable.tolist() == [True, False, True]
    assert motion.amplitude == 0.0


def test_source_of_the_kernel_run_by_the_interpreter_gives_the_same_accelerations(monkeypatch):
    belt = BeltOscillator(vb=0.1)
    compiled = ns.averaged_amplitude(belt)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    plain = ns.averaged_amplitude(BeltOscillator(vb=0.1), largest=0.03)
    assert plain.equation._oscillator._loop is interpreted(accelerate)
    for a in (0.01, 0.1):
        assert plain.rate(a) == pytest.approx(compiled.rate(a), rel=1e-13)


def unbounded(t, q, u, p, h):
    h[0] = -q[0]


@pytest.mark.parametrize("system, options, message", [
    (FollowerForceArm(), {}, "one coordinate"),
    (SpragSlip(), {}, "one coordinate"),
    (free(unbounded), {}, "largest="),
    (BeltOscillator(), {"largest": -1.0}, "positive"),
], ids=["two", "constraint", "range", "negative"])  # fmt: skip
def test_what_cannot_be_averaged_is_refused_with_the_reason(system, options, message):
    with pytest.raises(ns.InvalidInput, match=message):
        ns.averaged_amplitude(system, **options)


def test_steady_sliding_without_positive_stiffness_is_refused():
    def force(t, q, u, p, h):
        h[0] = q[0]

    with pytest.raises(ns.InvalidInput, match="positive"):
        ns.averaged_amplitude(free(force), largest=1.0)


def test_negative_amplitude_is_refused():
    with pytest.raises(ns.InvalidInput, match="must not be negative"):
        ns.averaged_amplitude(BeltOscillator(vb=0.42)).rate(-1.0)
