"""Several contacts hit at one instant by the energetic law, against closed forms of springs and another integration.

The law is that of equally stiff springs (contact/planar/energetic.py): y'' = -G y in the compressions while they are
pressed, and e^2 of the work given back.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import nonsmooth as ns
from tests.integrators.test_several_impacts import after, beads, of_all
from tests.integrators.test_several_impacts_with_friction import (
    FEET_F,
    FEET_N,
    B,
    H,
    J,
    feet,
    linear,
    of_methods,
    struck,
)

SOLVED = 1e-8  # chosen: of 1 m/s: what the other integration, of rtol 1e-11, and roots of its events err by
ROUNDING = 1e-10  # derived: STILL_IN_A_SHOCK = 1e-13 of the velocities at some ten changes of a mode


def energetic(e, n):
    return [ns.Contact(e_N=e, impact="energetic")] * n


def two_springs(same, other, v):
    """Changes of the two normal velocities of contacts with G = [[same, other], [other, same]], other < 0, of which
    the first approaches with v: until one of them parts both are pressed, from then on the other alone. e = 1."""
    slow, fast = math.sqrt(same + other), math.sqrt(same - other)

    def compression(t):
        part = 0.5 * v * np.array([math.sin(slow * t) / slow, math.sin(fast * t) / fast])
        return np.array([part[0] + part[1], part[0] - part[1]])

    def rate(t):
        part = 0.5 * v * np.array([math.cos(slow * t), math.cos(fast * t)])
        return np.array([part[0] + part[1], part[0] - part[1]])

    times = np.linspace(1e-3, 2 * math.pi / slow, 4000)
    first = [next(t for t in times if compression(t)[i] < 0.0) for i in (0, 1)]
    i = int(np.argmin(first))
    end = brentq(lambda t: compression(t)[i], first[i] - 2 * (times[1] - times[0]), first[i], xtol=1e-15)
    y, gamma = compression(end), -rate(end)
    left, approach = y[1 - i], -gamma[1 - i]  # of the other: y'' = -same y from here to its end
    leaves = math.sqrt(approach**2 + same * left**2)
    push = (leaves + approach) / same
    gamma[1 - i], gamma[i] = leaves, gamma[i] + other * push
    return gamma - [-v, 0.0]


@of_all
def test_three_beads_leave_as_a_chain_of_equal_springs(integrator):
    """Both contacts are pressed until the first parts: not the answer of any other law, (0, 0, 1) among them."""
    u = after([1.0] * 3, [1, 0, 0], energetic(1.0, 2), integrator)
    push = np.linalg.solve([[2.0, -1.0], [-1.0, 2.0]], two_springs(2.0, -1.0, 1.0))
    np.testing.assert_allclose(u, [1.0 - push[0], push[0] - push[1], push[1]], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(u, [-0.13, 0.15, 0.98], rtol=0, atol=5e-3)  # the known figures of linear springs


@of_methods
@pytest.mark.parametrize("inertia", [0.1, 0.4])
def test_a_rocking_block_that_strikes_with_one_foot(integrator, inertia):
    """It turns about one foot until the other strikes: with J < m b^2 the blow presses the first one too."""
    made = linear(np.diag([1.0, 1.0, inertia]), FEET_N, np.zeros((2, 3)), energetic(1.0, 2))
    found = np.array(FEET_N) @ struck(made, [0.0, -0.5, 0.5 / B], integrator)  # gamma_N = (-1, 0) before
    same, other = 1.0 + B * B / inertia, 1.0 - B * B / inertia
    expected = two_springs(same, other, 1.0) if other < 0.0 else np.array([2.0, 2.0 * other / same])
    np.testing.assert_allclose(found, expected + [-1.0, 0.0], rtol=0, atol=ROUNDING)


@of_methods
def test_a_block_that_lands_flat_leaves_flat(integrator):
    e = 0.6
    made = linear(np.diag([1.0, 1.0, J]), FEET_N, np.zeros((2, 3)), energetic(e, 2))
    np.testing.assert_allclose(struck(made, [0.3, -1.0, 0.0], integrator), [0.3, e, 0.0], rtol=0, atol=ROUNDING)


@of_all
def test_two_balls_that_strike_a_third_between_them_leave_alike(integrator):
    """The middle one is a wall to both; in turn (``sequential``) they would not leave alike."""
    e = 0.5
    made = beads([1.0, 2.0, 1.0], energetic(e, 2))
    found = ns.simulate(made, (0, 0.01), np.zeros(3), [1.0, 0.0, -1.0], integrator=integrator).u[-1]
    np.testing.assert_allclose(found, [-e, 0.0, e], rtol=0, atol=ROUNDING)


def by_another_integration(M, W_N, W_F, u, e, mu):
    """Velocities after the shock by Runge and Kutta on velocities and forces, of slides that keep their direction."""
    W_N, W_F = np.array(W_N, float), np.array(W_F, float)
    W = W_N - mu * np.sign(W_F @ u)[:, None] * W_F if mu else W_N
    push = np.linalg.solve(np.array(M, float), W.T)
    n = len(u)

    def rates(t, x):
        gamma, f = W_N @ x[:n], np.maximum(0.0, x[n:])
        stiffness = np.where(gamma < 0.0, 1.0, 1.0 / np.square(e))
        return np.concatenate([push @ f, np.where((gamma < 0.0) | (x[n:] > 0.0), -stiffness * gamma, 0.0)])

    x = np.concatenate([u, np.zeros(len(W_N))])
    for _ in range(1500):  # short enough to see each contact part, and none for ever
        x = solve_ivp(rates, (0, 0.02), x, rtol=1e-11, atol=1e-13).y[:, -1]
        x[n:] = np.maximum(0.0, x[n:])
        if (W_N @ x[:n] >= -1e-13).all() and not x[n:].any():
            return x[:n]
    raise AssertionError("no end")


@pytest.mark.parametrize("e", [[0.9, 0.7, 0.8], [0.4, 1.0, 0.6]])
def test_unequal_beads_that_lose_follow_another_integration(e):
    m, u = [1.0, 2.0, 0.7, 1.5], np.array([1.0, 0.0, 0.0, -0.3])
    contacts = [ns.Contact(e_N=value, impact="energetic") for value in e]
    made = beads(m, contacts)
    found = ns.simulate(made, (0, 1e-6), np.zeros(4), u, integrator=ns.MoreauJean(dt=1e-6)).u[-1]
    expected = by_another_integration(np.diag(m), np.diff(np.eye(4), axis=0), np.zeros((3, 4)), u, e, 0.0)
    np.testing.assert_allclose(found, expected, rtol=0, atol=SOLVED)


@of_methods
def test_a_block_that_slides_on_both_feet_follows_another_integration(integrator):
    e, mu, u = 0.5, 0.2, np.array([3.0, -1.0, 0.4])
    expected = by_another_integration(np.diag([1.0, 1.0, J]), FEET_N, FEET_F, u, [e, e], mu)
    assert expected[0] + H * expected[2] > 0.0  # the feet still slide
    np.testing.assert_allclose(struck(feet(e, mu, "energetic"), u, integrator), expected, rtol=0, atol=SOLVED)


def test_feet_that_share_one_friction_hold_as_one():
    """Two feet that slide alike are redundant: what one cannot hold the other does, and enough friction holds both."""
    found = struck(feet(0.5, 5.0, "energetic"), [0.1, -1.0, 0.0], ns.MoreauJean(dt=1e-9))
    assert abs(found[0] + H * found[2]) <= ROUNDING  # no slide is left
    lost = 0.5 * (1.01 - found @ np.diag([1.0, 1.0, J]) @ found)
    assert 0.0 < lost < 0.505


def test_a_ball_between_two_walls_that_give_all_back_comes_to_an_end():
    """It would fly to and fro for ever; what is left after PHASES ends without rebound, and no energy is won."""

    def walls(t, q, p, g_N):
        g_N[0], g_N[1] = q[0], -q[0]

    made = linear([[1.0]], np.zeros((2, 1)), np.zeros((2, 1)), energetic(1.0, 2))
    made = ns.System(n_q=1, mass=made.mass, force=made.force, gap=walls, contacts=energetic(1.0, 2),
                     parameters=made.parameters)  # fmt: skip
    found = ns.simulate(made, (0, 1e-3), [0.0], [1.0], integrator=ns.MoreauJean(dt=1e-3), on_failure="return")
    assert abs(found.u[-1, 0]) <= 1.0


def test_restitutions_of_which_some_are_none_are_refused():
    with pytest.raises(ns.InvalidInput, match="'energetic' of several contacts needs e_N > 0 at all .* got 0.5, 0;"):
        beads([1.0] * 3, [ns.Contact(e_N=e, impact="energetic") for e in (0.5, 0.0)])
    u = ns.simulate(
        beads([1.0] * 3, energetic(0.0, 2)), (0, 0.01), np.zeros(3), [1.0, 0.0, 0.0], integrator=ns.MoreauJean(dt=1e-3)
    ).u[-1]
    np.testing.assert_allclose(u, 1 / 3, rtol=0, atol=ROUNDING)  # nothing is given back
