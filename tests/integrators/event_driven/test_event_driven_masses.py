"""Masses of very different size, and starts that cannot be decided, under located events."""

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.stress_scenes import Tower, stack, tower


@pytest.mark.parametrize("ratio", [1e3, 1e6, 1e9])
def test_heavy_block_rests_on_a_light_one(ratio):
    blocks = tower(2, Tower(ratio=ratio))
    sol = ns.simulate(blocks, (0, 0.1), np.zeros(4), np.zeros(4), integrator=ns.EventDriven())
    # velocities are sums of impulses that cancel: eps times the ratio is what the light block keeps of g t, and the
    # constraint takes that off after every step
    assert np.abs(sol.q).max() <= np.finfo(float).eps * ratio * 9.81 * 0.1**2
    weight = 9.81 * (1 + ratio)
    # the force is what balances accelerations that are known to eps times the ratio
    assert np.isclose(sol.P_N[:, 0].sum(), weight * 0.1, rtol=1e-8 + 10 * np.finfo(float).eps * ratio)


def test_run_that_cannot_begin_returns_its_start():
    boxes = stack(10, Tower())  # 20 contacts at rest: more than are enumerated
    q0, u0 = np.zeros(30), np.zeros(30)
    sol = ns.simulate(boxes, (0, 0.1), q0, u0, integrator=ns.EventDriven(), on_failure="return")
    assert not sol.success and sol.t.tolist() == [0.0] and sol.g_N.shape == (1, 20)
    assert sol.ledger["kinetic"].tolist() == [0.0] and "t = 0 s" in repr(sol) and sol.summary()
