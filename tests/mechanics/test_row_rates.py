"""Row rates W' u + w' that a model leaves out are found by differences along the motion, to nine digits."""

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BilateralRod, PainleveRod, RockingBlock, SpragSlip


def forces(system, q, u):
    return np.array([[*solution.la_N, *solution.la_F.ravel()] for solution in ns.classify(system, 0.0, q, u).solutions])


@pytest.mark.parametrize(
    ("model", "state"),
    [
        (PainleveRod(mu=0.3), {"th": 1.1, "thdot": 3.0, "slip": -0.7}),
        (PainleveRod(mu=2.0), {"th": math.pi / 3, "thdot": 6.0, "slip": -1.0}),
        (BilateralRod(mu=2.0), {"th": math.pi / 3, "thdot": 6.0, "slip": -1.0}),
        (SpragSlip(), {"th": 0.9, "thdot": 1.0}),
        (RockingBlock(mu=0.5), {"tilt": 0.1, "tilt_rate": 2.0}),
    ],
    ids=["one solution", "three solutions", "bilateral", "sprag-slip", "two contacts"],
)
def test_forces_with_computed_rates_are_those_with_given_ones(model, state):
    given = model.system()
    q, u = model.state(**state)
    expected, found = (forces(system, q, u) for system in (given, dataclasses.replace(given, row_rates=None)))
    assert len(expected) > 0 and found.shape == expected.shape
    assert np.allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


class P(NamedTuple):
    w: float = 3.0  # frequency of the floor [1/s]


def mass(t, q, p, M):
    M[0, 0] = 2.0


def force(t, q, u, p, h):
    h[0] = -2.0 * 9.81


def gap(t, q, p, g_N):
    g_N[0] = q[0] - 0.1 * math.sin(p.w * t)


def normal(t, q, p, W_N):
    W_N[0, 0] = 1.0


def gap_rate(t, q, p, w_N):
    w_N[0] = -0.1 * p.w * math.cos(p.w * t)


def test_a_shaken_floor_presses_with_its_own_acceleration():
    shaken = ns.System(
        n_q=1, mass=mass, force=force, gap=gap, normal=normal, gap_rate=gap_rate, contacts=[ns.Contact()],
        parameters=P(),
    )  # fmt: skip
    t = 0.3
    q, u = [0.1 * math.sin(3 * t)], [0.3 * math.cos(3 * t)]
    (solution,) = ns.classify(shaken, t, q, u).solutions
    floor = -0.9 * math.sin(3 * t)  # its acceleration
    assert np.isclose(solution.la_N[0], 2.0 * (9.81 + floor), rtol=1e-9)
