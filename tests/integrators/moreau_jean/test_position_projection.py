"""``MoreauJean(projection=True)`` holds contacts at their surfaces; velocities and impulses stay as they are."""

import math
from typing import NamedTuple

import numpy as np

import nonsmooth as ns
from models import BouncingBall, RockingBlock


class Bead(NamedTuple):
    m: float = 1.0  # mass [kg]
    g: float = 9.81  # gravity [m/s^2]
    r: float = 0.5  # radius of the wire [m]


def mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.m


def force(t, q, u, p, h):
    h[1] = -p.m * p.g


def gap(t, q, p, g_N):
    g_N[0] = math.sqrt(q[0] * q[0] + q[1] * q[1]) - p.r


def normal(t, q, p, W_N):
    r = math.sqrt(q[0] * q[0] + q[1] * q[1])
    W_N[0, 0] = q[0] / r
    W_N[0, 1] = q[1] / r


def bead_on_a_circular_wire():
    contacts = [ns.Contact(bilateral=True)]
    return ns.System(
        n_q=2, mass=mass, force=force, gap=gap, normal=normal, contacts=contacts, parameters=Bead(), name="bead"
    )


def run(system, start, t_end, projection):
    return ns.simulate(system, (0, t_end), *start, integrator=ns.MoreauJean(dt=1e-3, projection=projection))


def test_a_bead_stays_on_its_wire_to_rounding():
    start = ([0.5, 0.0], [0.0, 0.0])
    off = {on: np.abs(run(bead_on_a_circular_wire(), start, 2.0, on).g_N).max() for on in (False, True)}
    shift = 2 * 9.81 * 1e-3**2 / 8  # of the chord of a step from its arc: (dt/2)^2 u^2 / (2 r), u^2 <= 2 g r
    assert off[False] < shift
    assert off[True] < shift**2 / (2 * 0.5) < 1e-10  # what one linearisation of a circle leaves: shift^2/(2 r)


def test_projected_bead_swings_with_the_period_of_the_pendulum():
    start = ([0.5 * math.sin(0.2), -0.5 * math.cos(0.2)], [0.0, 0.0])
    solution = run(bead_on_a_circular_wire(), start, 2.0, True)
    x = solution.q[:, 0]
    down = np.flatnonzero((x[:-1] > 0) & (x[1:] <= 0))
    crossings = solution.t[down] + 1e-3 * x[down] / (x[down] - x[down + 1])
    k = math.sin(0.1)  # of the complete elliptic integral, by its arithmetic-geometric mean
    a, b = 1.0, math.sqrt(1 - k * k)
    for _ in range(6):
        a, b = (a + b) / 2, math.sqrt(a * b)
    assert np.isclose(crossings[1] - crossings[0], 2 * math.pi * math.sqrt(0.5 / 9.81) / a, rtol=1e-4)


def test_a_ball_at_rest_lies_on_the_ground_not_below_it():
    ball = BouncingBall(e=0.5)
    left, moved = (run(ball, ball.state(), 2.0, on) for on in (False, True))
    assert moved.q[-1, 0] >= -1e-15 > left.q[-1, 0]
    ledger = moved.ledger
    lifted = np.diff(ledger["kinetic"] + ledger["potential"] - ledger["normal"])  # m g times the lift of each step
    assert lifted.max() > 0.01 and np.allclose(lifted, -np.diff(ledger["projection"]), atol=1e-13)


def test_projection_does_not_touch_velocities_of_a_block_that_stands():
    block = RockingBlock()
    start = block.state(tilt=0.0)
    left, moved = (run(block, start, 0.1, on) for on in (False, True))
    assert (left.u == moved.u).all() and (left.P_N == moved.P_N).all()
