"""Blocks on redundant feet that a load tips for a moment: the time has a closed form, and no tolerance misses it."""

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns

WEIGHT, HEIGHT, HALF, INERTIA = 2 * 9.81, 0.3, 0.15, 2 * (0.3**2 + 0.6**2) / 12


class Load(NamedTuple):
    part: float = 1.0  # of the horizontal load that tips, W HALF/HEIGHT, at its crest
    rate: float = 3.0  # of the load [rad/s]


def block_on_feet(feet):
    """Feet at the given places x under the center of mass, so rough that none slides; pushed at that center."""

    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 2.0
        M[2, 2] = INERTIA

    def force(t, q, u, p, h):
        h[0] = p.part * WEIGHT * HALF / HEIGHT * math.sin(p.rate * t)
        h[1] = -WEIGHT

    def gap(t, q, p, g):
        for k in range(len(feet)):
            g[k] = q[1] - HEIGHT * math.cos(q[2]) + feet[k] * math.sin(q[2])

    def normal(t, q, p, W):
        for k in range(len(feet)):
            W[k, 1], W[k, 2] = 1.0, HEIGHT * math.sin(q[2]) + feet[k] * math.cos(q[2])

    def tangent(t, q, p, W):
        for k in range(len(feet)):
            W[k, 0, 0], W[k, 0, 2] = 1.0, HEIGHT * math.cos(q[2]) - feet[k] * math.sin(q[2])

    return ns.System(n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, parameters=Load(),
                     contacts=[ns.Contact(mu=2.0)] * len(feet))  # fmt: skip


FEET = {"two feet": np.array([-HALF, HALF]), "three feet": np.array([-HALF, 0.03, HALF])}


@pytest.mark.parametrize("name", sorted(FEET))
def test_block_tips_as_soon_as_its_load_turns_it_about_an_outer_foot(name):
    """F HEIGHT = W HALF first at asin(1/part)/rate; below part = 1 it stays, whatever the tolerances."""
    block, rng = block_on_feet(FEET[name]), np.random.default_rng(3)
    for _ in range(40):
        rate, part = 10 ** rng.uniform(-1, 2.5), 1 + 10 ** rng.uniform(-5, -0.3)
        integrator = ns.EventDriven(10 ** rng.uniform(-12, -4), 10 ** rng.uniform(-16, -8))
        for crest, tips in ((part, True), (2 - part, False)):
            begin, half = math.asin(1 / part) / rate, math.pi / rate
            end = 0.5 * (begin + half / 2) if tips else half
            sol = ns.simulate(block.with_parameters(part=crest, rate=rate), (0.0, max(end, 1.001 * begin)),
                              [0.0, HEIGHT, 0.0], [0.0, 0.0, 0.0], integrator=integrator)  # fmt: skip
            times = [event.t for event in sol.events]
            assert bool(times) == tips
            assert not tips or rate * abs(times[0] - begin) < 1e-8


@pytest.mark.parametrize(("rtol", "atol"), [(1.03e-12, 4.0e-16), (4.2e-14, 3.1e-16), (2.7e-6, 3.2e-16)])
def test_block_on_two_feet_tips_at_its_first_crest_at_every_tolerance(rtol, atol):
    """F = 9 sin 3t at the height 0.3, and less by half of that moment: F 0.15 + F 0.3 = W 0.15 at sin 3t = 0.7267."""
    F, turn = 9.0, 0.15

    def force(t, q, u, p, h):
        h[0], h[1], h[2] = F * math.sin(3 * t), -WEIGHT, -F * math.sin(3 * t) * turn * math.cos(q[2])

    block = block_on_feet(FEET["two feet"])
    system = ns.System(n_q=3, mass=block.mass, force=force, gap=block.gap, normal=block.normal, tangent=block.tangent,
                       parameters=Load(), contacts=[ns.Contact(mu=0.42)] * 2)  # fmt: skip
    sol = ns.simulate(system, (0.0, 0.5), [0.0, HEIGHT, 0.0], [0.0] * 3, integrator=ns.EventDriven(rtol, atol))
    tips = math.asin(WEIGHT * HALF / (F * (HEIGHT + turn))) / 3
    assert sol.events[0].t == pytest.approx(tips, abs=1e-8)
