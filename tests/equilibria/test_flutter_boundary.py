"""Boundaries of stability against closed forms and printed values, in every kind of loss."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, FollowerForceArm, ModeCoupling, SpragSlip

RELATIVE = 1e-12  # what is promised is 1e-10; eigenvalues of these matrices are known to about 1e-14


def test_arm_flutters_from_the_printed_load():
    edge = ns.flutter_boundary(FollowerForceArm(), "P", (0.0, 2000.0))
    assert edge.value == pytest.approx(948.126555160, abs=6e-10)
    assert edge.value == pytest.approx(FollowerForceArm().critical_loads()[0], rel=RELATIVE)
    assert edge.frequency**2 == pytest.approx(1131.370850, rel=1e-6)  # a double eigenvalue is known to sqrt(eps)
    assert edge.verdict == ns.Verdict.FLUTTER


@pytest.mark.parametrize("name, value", [("m1", 3.0), ("m2", 0.4), ("l", 0.8), ("k2", 250.0), ("th0", 0.9)])
def test_arm_with_other_parameters_flutters_from_the_load_of_its_closed_form(name, value):
    arm = replace(FollowerForceArm(), **{name: value})
    first, second = arm.critical_loads()
    edge = ns.flutter_boundary(arm, "P", (0.0, 0.5 * (first + second)))
    assert edge.value == pytest.approx(first, rel=RELATIVE)


def test_mode_coupling_flutters_from_the_printed_friction():
    edge = ns.flutter_boundary(ModeCoupling(), "mu", (0.3, 0.8))
    assert edge.value == pytest.approx(0.522527017, abs=6e-10)
    assert edge.value == pytest.approx(ModeCoupling().critical_friction(), rel=RELATIVE)
    assert edge.frequency == pytest.approx(14.390328, abs=6e-7)
    assert edge.verdict == ns.Verdict.FLUTTER
    free = ns.flutter_boundary(ModeCoupling(cx=0.0, cz=0.0), "mu", (0.8, 0.3))
    assert free.value == pytest.approx(0.5, rel=RELATIVE)
    assert free.frequency**2 == pytest.approx(200.0, rel=1e-6)


@pytest.mark.parametrize("cx, cz", [(1.33, 1.0), (0.2, 4.0), (1e-3, 2e-3), (5.0, 5.0)])
def test_damped_boundary_is_that_of_hurwitz(cx, cz):
    model = ModeCoupling(cx=cx, cz=cz)
    edge = ns.flutter_boundary(model, "mu", (0.1, 3.0))
    assert edge.value == pytest.approx(model.critical_friction(), rel=RELATIVE)


def test_vanishing_unequal_damping_leaves_a_boundary_below_the_undamped_one():
    edges = [ns.flutter_boundary(ModeCoupling(cx=e, cz=5 * e), "mu", (0.1, 3.0)).value for e in (1e-1, 1e-2, 1e-3)]
    assert max(edges) < 0.45  # far below 0.5: the destabilisation does not vanish with the damping
    assert abs(edges[2] - edges[1]) < 0.1 * abs(edges[1] - edges[0])


@pytest.mark.parametrize("belt, bracket, value", [
    (BeltOscillator(), (0.3, 0.6), 0.440958552),
    (BeltOscillator(law="smoothed", r=20.0), (0.05, 0.3), 0.163896782),
    (BeltOscillator(law="smoothed", r=20.0), (0.3, 0.6), 0.440201331),
    (BeltOscillator(law="smoothed", r=200.0), (0.005, 0.3), 0.027178274),
    (BeltOscillator(law="smoothed", r=200.0), (0.3, 0.6), 0.440958552),
])  # fmt: skip
def test_belt_loses_its_stability_at_the_printed_speeds_by_negative_damping(belt, bracket, value):
    edge = ns.flutter_boundary(belt, "vb", bracket)
    assert edge.value == pytest.approx(value, abs=6e-10)
    assert edge.verdict == ns.Verdict.NEGATIVE_DAMPING
    assert edge.frequency == pytest.approx(np.sqrt(belt.k / belt.m), rel=1e-12)


class Pair(NamedTuple):
    k11: float = 2.0
    k22: float = 1.6
    k12: float = 0.3
    kn: float = 1.0
    mu: float = 0.1
    N0: float = 10.0
    vb: float = 1.0


def two_modes(**values):
    """Two unit masses coupled by friction: K = [[k11, k12 - mu kn], [k12, k22]]."""

    def mass(t, q, p, M):
        M[0, 0] = 1.0
        M[1, 1] = 1.0

    def force(t, q, u, p, h):
        h[0] = -p.k11 * q[0] - p.k12 * q[1]
        h[1] = -p.k12 * q[0] - p.k22 * q[1]

    def normal_force(t, q, u, p, N):
        N[0] = p.N0 + p.kn * q[1]

    def tangent(t, q, p, W_F):
        W_F[0, 0, 0] = 1.0

    def surface_velocity(t, q, p, w_F):
        w_F[0, 0] = -p.vb

    return ns.System(
        n_q=2, mass=mass, force=force, normal_force=normal_force, tangent=tangent, surface_velocity=surface_velocity,
        contacts=[ns.Contact(mu="mu", normal_force=True)], parameters=Pair(**values),
    )  # fmt: skip


@pytest.mark.parametrize("values", [{}, {"k11": 3.0, "k12": 0.4}, {"k22": 2.5, "kn": 2.0}])
def test_two_modes_flutter_from_the_closed_form_of_their_stiffness(values):
    p = Pair(**values)
    mu_c = (p.k12**2 + (p.k11 - p.k22) ** 2 / 4) / (p.k12 * p.kn)
    edge = ns.flutter_boundary(two_modes(**values), "mu", (0.0, 2 * mu_c))
    assert edge.value == pytest.approx(mu_c, rel=RELATIVE)
    assert Pair() != p or edge.value == pytest.approx(0.433333, abs=6e-7)


def test_two_modes_diverge_where_the_stiffness_loses_its_determinant():
    edge = ns.flutter_boundary(two_modes(mu=0.0), "k12", (0.5, 3.0))  # symmetric: k11 k22 = k12^2
    assert edge.value == pytest.approx(np.sqrt(2.0 * 1.6), rel=RELATIVE)
    assert edge.verdict == ns.Verdict.DIVERGENCE and edge.frequency < 1e-6


def test_effective_inertia_vanishes_where_the_contact_problem_loses_its_sign():
    edge = ns.flutter_boundary(SpragSlip.set_1(), "mu", (0.5, 1.35))
    assert edge.verdict == ns.Verdict.NEGATIVE_INERTIA
    rod = replace(SpragSlip.set_1(), mu=edge.value)
    assert rod.critical_friction(rod.equilibrium()) == pytest.approx(edge.value, rel=RELATIVE)


def test_sprag_slip_becomes_unstable_where_its_effective_damping_vanishes():
    edge = ns.flutter_boundary(SpragSlip.set_1(cth=0.5), "mu", (0.5, 1.2))
    rod = replace(SpragSlip.set_1(cth=0.5), mu=edge.value)
    assert rod.damping_friction(rod.equilibrium()) == pytest.approx(edge.value, rel=RELATIVE)
    assert edge.verdict == ns.Verdict.NEGATIVE_DAMPING


@pytest.mark.parametrize("bracket, message", [
    ((0.1, 0.2), "stable at both ends"), ((0.6, 0.7), "unstable at both ends"), ((0.1,), "2 entries"),
])  # fmt: skip
def test_bracket_without_a_boundary_is_refused(bracket, message):
    with pytest.raises(ns.InvalidInput, match=message):
        ns.flutter_boundary(ModeCoupling(), "mu", bracket)


def test_unknown_parameter_is_refused_with_the_nearest():
    with pytest.raises(ns.UnknownName, match="mu"):
        ns.flutter_boundary(ModeCoupling(), "muu", (0.1, 0.7))
