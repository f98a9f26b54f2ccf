"""What decays goes on to numbers that have few digits left, or none: to an integrator they are zero."""

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import InclinedBlock, RockingBlock, WallPendulum
from nonsmooth.numerics.quadratic_program import minimise

TINY = (1e-30, 1e-200, 1e-290, 3e-308, 1e-315, 5e-324)
INTEGRATORS = (ns.MoreauJean(dt=1e-3), ns.Adaptive(), ns.EventDriven(), ns.Penalty(1e5, damping=1.0))
named = pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda integrator: type(integrator).__name__)


class P(NamedTuple):
    c: float = 2.0  # damping of the second coordinate [N s/m]


def mass(t, q, p, M):
    M[0, 0] = M[1, 1] = 1.0


def force(t, q, u, p, h):
    h[0] = -q[0]
    h[1] = -q[1] - p.c * u[1]


def gap(t, q, p, g_N):
    g_N[0] = 2.0 + q[0] + q[1]


SWINGING = ns.System(
    coordinates=["x", "y"], mass=mass, force=force, gap=gap, contacts=[ns.Contact()], parameters=P(), name="swinging"
)


@named
@pytest.mark.parametrize("tiny", TINY)
def test_a_coordinate_that_has_decayed_leaves_the_others_to_their_motion(integrator, tiny):
    sol = ns.simulate(SWINGING, (0, 2), state={"x": 1.0, "y": tiny}, integrator=integrator)
    assert sol.q[-1, 0] == pytest.approx(math.cos(2.0), abs=1e-6)  # dt^2/12 a second of the mid-point rule: 2e-7
    assert abs(sol.q[-1, 1]) <= tiny


@named
@pytest.mark.parametrize("tiny", TINY)
@pytest.mark.parametrize("which", [0, 1, 2])
def test_a_block_on_its_edge_with_next_to_no_velocity_falls_as_from_rest(integrator, which, tiny):
    """The edge is closed to rounding: that it approaches by 1e-30 m/s is no reason that no force would fit."""
    block = RockingBlock()
    q, u = block.state()
    moved = np.array(u)
    moved[which] -= tiny
    options = {"integrator": integrator, "project": True}
    fallen, asked = (ns.simulate(block, (0, 0.05), q, start, **options).q[-1] for start in (moved, u))
    np.testing.assert_allclose(fallen, asked, atol=1e-9)


@named
@pytest.mark.parametrize("tiny", TINY)
def test_a_gap_of_nothing_is_closed(integrator, tiny):
    block = InclinedBlock()
    u = block.state()[1]
    lifted, asked = (
        ns.simulate(block, (0, 0.05), [0.0, y], u, integrator=integrator, project=True).q[-1] for y in (tiny, 0.0)
    )
    np.testing.assert_allclose(lifted, asked, atol=1e-9)


@named
@pytest.mark.parametrize("tiny", TINY)
def test_a_depth_of_nothing_is_none(integrator, tiny):
    sol = ns.simulate(WallPendulum(), (0, 0.05), [-tiny], [0.0], integrator=integrator, project=True)
    assert abs(sol.q[-1, 0]) < 1e-9


def test_a_solver_that_raises_an_exception_of_its_own_has_no_answer():
    assert minimise(np.eye(1), np.zeros(1), np.eye(1), np.array([-np.inf])) is None
