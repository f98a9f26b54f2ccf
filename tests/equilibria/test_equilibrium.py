"""Steady sliding: printed equilibria, virtual ones, balances, refusals."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import (
    BeltOscillator,
    BouncingBall,
    FollowerForceArm,
    ModeCoupling,
    SelfLockingRod,
    SlidingBlock,
    SpragSlip,
    WallPendulum,
)
from tests.systems import block

# Printed values: corrected equations of the textbook chapter on friction-induced instability; last digits rounded.
SET_1 = (0.828053558508, 37.830818394)
SET_2 = (0.849626709900, 38.551699381)


@pytest.mark.parametrize("rod, expected", [
    (SpragSlip.set_1(), SET_1), (SpragSlip.set_1(cth=0.5), SET_1), (SpragSlip(), SET_2),
])  # fmt: skip
def test_sprag_slip_rests_at_the_printed_angle_under_the_printed_force(rod, expected):
    at = ns.equilibrium(rod)
    assert not at.is_virtual
    assert at.q[1] == pytest.approx(expected[0], abs=6e-13)
    assert at.q[0] == pytest.approx(rod.l * math.sin(at.q[1]), rel=1e-15)
    assert at.la_N[0] == pytest.approx(expected[1], abs=6e-10)
    assert at.la_N[0] == pytest.approx(rod.ky * at.q[0] + rod.R, rel=1e-13)
    assert at.la_F[0] == pytest.approx(rod.mu * at.la_N[0], rel=1e-15)  # gamma_F = -vb: friction pulls along the belt


def test_equilibrium_of_the_other_branch_is_found_and_called_virtual():
    at = ns.equilibrium(SpragSlip(), guess=[2.7, 0.57], normal=[-1])
    assert at.q[1] == pytest.approx(0.572612565, abs=6e-10)
    assert at.is_virtual and at.la_N[0] > 0
    assert "pulled" in at.wrong[0]


@pytest.mark.parametrize("model, expected", [
    (FollowerForceArm(P=500.0), (-0.125, -0.125 + math.pi / 6)),
    (FollowerForceArm(P=1000.0), (-0.25, -0.25 + math.pi / 6)),
    (BeltOscillator(vb=0.3), (BeltOscillator(vb=0.3).equilibrium(),)),
    (BeltOscillator(vb=-0.3), (-BeltOscillator(vb=0.3).equilibrium(),)),
    (BeltOscillator(law="smoothed", vb=0.3), (BeltOscillator(law="smoothed", vb=0.3).equilibrium(),)),
    (ModeCoupling(), tuple(ModeCoupling().equilibrium())),
    (ModeCoupling(vb=-10.0), tuple(ModeCoupling(vb=-10.0).equilibrium())),
    (SelfLockingRod(th0=0.4), (0.4,)),
    (WallPendulum(th_w=-0.2), (0.0,)),
], ids=lambda value: getattr(value, "name", ""))  # fmt: skip
def test_equilibria_are_those_of_the_closed_forms(model, expected):
    at = ns.equilibrium(model)
    np.testing.assert_allclose(at.q, expected, rtol=4e-15, atol=4e-15)
    assert not at.is_virtual and at.residual < 1e-15


@pytest.mark.parametrize("mu, angle", [(1.0, 10.0), (1.0, 44.0), (0.5, 40.0)])
def test_normal_force_of_the_self_locking_rod_is_its_closed_form(mu, angle):
    rod = SelfLockingRod(mu=mu, th0=math.radians(angle))
    assert ns.equilibrium(rod).la_N[0] == pytest.approx(rod.normal_force(), rel=1e-12)


def test_beyond_the_jamming_angle_the_balance_needs_a_pull_and_is_virtual():
    at = ns.equilibrium(SelfLockingRod(mu=1.0, th0=math.radians(50.0)))
    assert at.is_virtual and at.la_N[0] < 0


def test_a_mass_pulled_off_the_conveyor_is_no_equilibrium_in_contact():
    at = ns.equilibrium(ModeCoupling(R=-100.0))
    assert at.is_virtual and "press" in at.wrong[0]


def test_far_guesses_reach_the_same_equilibrium():
    rod = SpragSlip.set_1()
    for th in (0.3, 0.6, 1.0):
        assert ns.equilibrium(rod, guess=[5 * math.sin(th), th]).q[1] == pytest.approx(SET_1[0], abs=6e-13)


class Plate(NamedTuple):
    m: float = 2.0
    g: float = 9.81
    k: float = 300.0


def plate(**functions):
    """A mass on the ground, held sideways by a spring; the ground moves with -1 m/s under it."""

    def force(t, q, u, p, h):
        h[0] = -p.k * q[0]
        h[1] = -p.m * p.g

    def surface_velocity(t, q, p, w_F):
        w_F[0, 0] = 1.0

    given = {"force": force, "surface_velocity": surface_velocity}
    return block(ns.Contact(mu=0.3), Plate(), **(given | functions))


def test_unilateral_contact_closed_at_the_guess_carries_the_weight():
    at = ns.equilibrium(plate(), guess=[0.1, 0.0])
    assert at.la_N[0] == pytest.approx(2.0 * 9.81, rel=1e-14)
    assert at.q == pytest.approx([-0.3 * 2.0 * 9.81 / 300.0, 0.0], rel=1e-13)


def test_contact_open_at_the_guess_stays_open_and_the_missing_support_is_named():
    with pytest.raises(ns.InvalidInput, match="not isolated"):
        ns.equilibrium(plate(), guess=[0.1, 0.5])  # nothing holds the mass in the air


def test_model_whose_force_takes_real_numbers_only_is_solved_with_its_own_jacobian():
    def force(t, q, u, p, h):
        h[0] = -p.k * float(q[0])
        h[1] = -p.m * p.g

    def stiffness(t, q, u, p, K):
        K[0, 0] = p.k

    at = ns.equilibrium(plate(force=force, stiffness=stiffness), guess=[0.1, 0.0])
    assert at.q[0] == pytest.approx(-0.3 * 2.0 * 9.81 / 300.0, rel=1e-13)
    with pytest.raises(ns.InvalidInput, match="complex"):
        ns.equilibrium(plate(force=force), guess=[0.1, 0.0])


@pytest.mark.parametrize("model, options, message", [
    (SlidingBlock(), {}, "does not slide"),
    (SpragSlip(), {"guess": [1.0]}, "2 entries"),
    (SpragSlip(), {"sliding": [0]}, r"\+1 or -1"),
    (ModeCoupling(), {"normal": [-1]}, "only push"),
    (BouncingBall(), {"guess": [1.0]}, "not isolated"),
    (ModeCoupling(k=0.0, kx=0.0), {}, "not isolated|singular"),
    (object(), {}, "a system or a model"),
])  # fmt: skip
def test_what_has_no_isolated_equilibrium_is_refused_with_the_reason(model, options, message):
    with pytest.raises(ns.InvalidInput, match=message):
        ns.equilibrium(model, **options)
