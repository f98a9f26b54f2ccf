"""Contacts of other kinds in the classification: laws of friction, given normal forces, moving surfaces, no contact."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, LeadScrew, SlidingBlock, SpragSlip
from tests.systems import block, block_mass


class Block(NamedTuple):
    m: float = 2.0
    g: float = 10.0
    push: float = 5.0
    mu_s: float = 0.5
    mu_k: float = 0.2


def force(t, q, u, p, h):
    h[0] = p.push
    h[1] = -p.m * p.g


def pushed_block(law, **parameters):
    return block(ns.Contact(mu=law), Block(**parameters), force=force)


def modes(system, speed):
    c = ns.classify(system, 0.0, [0.0, 0.0], [speed, 0.0])
    assert c.is_complete
    return {s.modes[0]: float(s.la_F[0]) for s in c.solutions}


def test_static_friction_above_kinetic_lets_sticking_and_sliding_coexist():
    # weight 20 N: holds 10 N, brakes 4 N; a push of 5 N is between
    system = pushed_block(ns.StaticKinetic("mu_s", "mu_k"))
    assert modes(system, 0.0) == pytest.approx({"stick": -5.0, "slide +": -4.0})
    assert modes(system, 1.0) == pytest.approx({"slide +": -4.0})
    assert modes(system.with_parameters(push=3.0), 0.0) == pytest.approx({"stick": -3.0})
    assert modes(system.with_parameters(push=11.0), 0.0) == pytest.approx({"slide +": -4.0})


def test_coefficient_of_a_law_is_that_of_the_present_speed():
    law = ns.Polynomial(m0=0.4, m1=0.1, m3=0.02)
    for speed in (0.5, -2.0):
        v = abs(speed)
        c = ns.classify(pushed_block(law), 0.0, [0.0, 0.0], [speed, 0.0])
        assert c.mu[0] == pytest.approx(0.4 - 0.1 * v + 0.02 * v**3, rel=1e-15)
        assert c.solutions[0].la_F[0] == pytest.approx(-np.sign(speed) * c.mu[0] * 20.0, rel=1e-14)
    assert modes(pushed_block(law), 0.0) == pytest.approx({"stick": -5.0})
    smooth = ns.Smoothed(m0=0.4, r=10.0)  # no friction at rest
    assert modes(pushed_block(smooth), 0.0) == pytest.approx({"slide +": 0.0})


def test_friction_under_a_given_force_slides_or_sticks_with_the_belt():
    belt = BeltOscillator()
    c = ns.classify(belt, 0.0, *belt.state(x=0.02, velocity=-0.1))
    (solution,) = c.solutions
    v = belt.vb + 0.1  # belt minus mass
    friction = belt.N * (belt.m0 - belt.m1 * v + belt.m3 * v**3)
    assert solution.la_F[0] == pytest.approx(friction, rel=1e-14) and solution.la_N[0] == belt.N
    assert solution.du[0] == pytest.approx((friction - belt.k * 0.02 + belt.c * 0.1) / belt.m, rel=1e-13)
    assert np.isnan(c.p).all() and not c.impacts
    for x, mode in [(0.01, "stick"), (0.06, "slide -")]:  # holds while |c vb + k x| <= N m0 = 0.4
        assert ns.classify(belt, 0.0, [x], [belt.vb]).solutions[0].modes == (mode,)


def test_system_without_contacts_moves_freely():
    free = ns.System(n_q=2, mass=block_mass, force=force, parameters=Block())
    c = ns.classify(free, 0.0, [0.0, 0.0], [1.0, 2.0])
    assert c.kind == ns.ParadoxKind.REGULAR and c.n_solutions == 1 and c.mode == ()
    assert c.solutions[0].du.tolist() == [2.5, -10.0]
    assert str(c).startswith("REGULAR")


def test_belt_of_one_system_does_not_drive_the_next():
    # systems of equal size share memory: what one writes (here the belt's speed) must not reach another
    sprag, screw = SpragSlip(), LeadScrew()
    before = str(ns.classify(screw, 0.0, *screw.state(thdot=2.0)).to_dict())
    ns.classify(sprag, 0.0, *sprag.state())
    assert str(ns.classify(screw, 0.0, *screw.state(thdot=2.0)).to_dict()) == before


def test_classifications_of_one_system_do_not_share_their_arrays():
    block_model = SlidingBlock(mu=0.3)
    first = ns.classify(block_model, 0.0, *block_model.state(speed=1.0))
    before = first.to_dict()
    ns.classify(block_model, 0.0, *block_model.state(speed=-2.0))
    assert str(first.to_dict()) == str(before)
