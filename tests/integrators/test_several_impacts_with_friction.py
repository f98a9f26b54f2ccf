"""Several contacts with friction hit at one instant: closed forms, the order of blows, and no gain of energy."""

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.jit import interpreted
from nonsmooth.mechanics.impact import impulse_map
from nonsmooth.mechanics.laws import ImpactLaw
from tests.integrators.test_several_impacts import INTEGRATORS

ROUNDING = 1e-9  # derived: of 1 m/s: roundings of some hundred blows, and weights of a time step without any


class Random(NamedTuple):
    M: np.ndarray
    W_N: np.ndarray
    W_F: np.ndarray


def mass(t, q, p, M):
    for i in range(M.shape[0]):
        for j in range(M.shape[0]):
            M[i, j] = p.M[i, j]


def free(t, q, u, p, h):
    h[0] = 0.0


def gap(t, q, p, g_N):
    for i in range(g_N.shape[0]):
        total = 0.0
        for j in range(q.shape[0]):
            total += p.W_N[i, j] * q[j]
        g_N[i] = total


def tangent(t, q, p, W_F):
    for i in range(W_F.shape[0]):
        for j in range(q.shape[0]):
            W_F[i, 0, j] = p.W_F[i, j]


def linear(M, W_N, W_F, contacts):
    """A system without forces whose contacts touch at q = 0."""
    M, W_N, W_F = (np.array(array, float) for array in (M, W_N, W_F))
    return ns.System(n_q=len(M), mass=mass, force=free, gap=gap, tangent=tangent, contacts=contacts,
                     parameters=Random(M, W_N, W_F))  # fmt: skip


def struck(made, u, integrator):
    """Velocities just after contacts that touch were struck with u."""
    n = len(u)
    return ns.simulate(made, (0, 1e-6), np.zeros(n), np.array(u, float), integrator=integrator).u[-1]


METHODS = [ns.MoreauJean(dt=1e-6), ns.EventDriven(), ns.Adaptive()]
of_methods = pytest.mark.parametrize("integrator", METHODS, ids=lambda method: type(method).__name__)

# a block on two feet, m = 1 kg, J = 0.3 kg m^2, feet at (-+b, -h) from its centre: q = (x, y, th)
B, H, J = 0.5, 0.3, 0.3
FEET_N = [[0.0, 1.0, -B], [0.0, 1.0, B]]
FEET_F = [[1.0, 0.0, H], [1.0, 0.0, H]]


def feet(e, mu, impact):
    return linear(np.diag([1.0, 1.0, J]), FEET_N, FEET_F, [ns.Contact(mu=mu, e_N=e, impact=impact)] * 2)


@of_methods
def test_a_sliding_block_that_lands_flat_leaves_flat_under_poissons_law(integrator):
    """Friction turns it, which the feet share: compression ends at rest, and expansion gives e of all impulses."""
    e, mu, u, v = 0.5, 0.2, 3.0, 1.0
    found = struck(feet(e, mu, "poisson"), [u, -v, 0.0], integrator)
    np.testing.assert_allclose(found, [u - (1 + e) * mu * v, e * v, 0.0], rtol=0, atol=ROUNDING)


@of_methods
def test_a_block_that_sticks_in_compression_is_given_no_push_to_the_side(integrator):
    """Enough friction stops it in compression; expansion has nothing to oppose, P_F = 0 there, and does not turn it."""
    e, mu, u, v = 0.5, 1.0, 0.1, 1.0
    found = struck(feet(e, mu, "poisson"), [u, -v, 0.0], integrator)
    # feet held: x + h th = 0, P_C = (2 feet): normals sum v, P_F = -u, their couple u h = b (P_2 - P_1)... of expansion
    P_sum, couple = v, u * H / B
    left, right = 0.5 * (P_sum - couple), 0.5 * (P_sum + couple)
    turn = e * B * (right - left) / J  # by the normals of expansion; friction holds the feet against it
    G = 1.0 + H * H / J
    P_F = -H * turn / G
    expected = [P_F, e * v, turn + H * P_F / J]
    assert abs(P_F) <= mu * e * P_sum
    np.testing.assert_allclose(found[0] + H * found[2], 0.0, rtol=0, atol=ROUNDING)  # still held
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


def in_turn(M, W_N, W_F, u, e, mu):
    """The fastest approach first, of equal ones the first, each blow by the energetic law of one contact."""
    M_inv = np.linalg.inv(np.array(M, float))
    W_N, W_F, u = (np.array(array, float) for array in (W_N, W_F, u))
    fastest = -(W_N @ u).min()
    for _ in range(10_000):
        gamma = W_N @ u
        i = int(np.argmin(gamma))
        if gamma[i] >= -1e-10 * fastest:
            return u
        W = np.stack([W_N[i], W_F[i]])
        G = W @ M_inv @ W.T
        P_N, P_F, _, _ = interpreted(impulse_map)(ImpactLaw.ENERGETIC, e, mu, G[0, 0], G[0, 1], G[1, 1], *(W @ u))
        u = u + M_inv @ W.T @ [P_N, P_F]
    raise AssertionError("no end")


@of_methods
@pytest.mark.parametrize("u", [[3.0, -1.0, 0.0], [0.1, -1.0, 0.3], [-2.0, -1.0, -1.0]])
def test_blows_with_friction_follow_one_another_in_the_stated_order(integrator, u):
    e, mu = 0.5, 0.3
    found = struck(feet(e, mu, "sequential"), u, integrator)
    expected = in_turn(np.diag([1.0, 1.0, J]), FEET_N, FEET_F, u, e, mu)
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


@of_methods
@pytest.mark.parametrize("impact", ["sequential", "poisson", "energetic"])
def test_contacts_that_are_not_coupled_follow_their_own_law_of_one_contact(integrator, impact):
    """Two rods that share nothing, struck in the same step, end as each would alone."""
    G = np.array([[2.5, -1.5], [-1.5, 2.5]])  # of the rod at 45 degrees
    M = np.linalg.inv(G)
    both = np.kron(np.eye(2), M)
    W_N, W_F = np.eye(4)[[0, 2]], np.eye(4)[[1, 3]]
    e, mu = 0.7, 0.6
    u = np.array([-1.0, 0.4, -0.5, 2.0])
    found = struck(linear(both, W_N, W_F, [ns.Contact(mu=mu, e_N=e, impact=impact)] * 2), u, integrator)
    law = ImpactLaw.POISSON if impact == "poisson" else ImpactLaw.ENERGETIC
    for k in (0, 2):
        P_N, P_F, _, _ = interpreted(impulse_map)(law, e, mu, G[0, 0], G[0, 1], G[1, 1], u[k], u[k + 1])
        np.testing.assert_allclose(found[k : k + 2], u[k : k + 2] + G @ [P_N, P_F], rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("impact", ["sequential", "poisson", "energetic"])
def test_no_random_system_gains_energy_and_nothing_approaches_after(impact):
    rng = np.random.default_rng(7)
    gains = []
    for _ in range(120):
        n, n_c = 4, int(rng.integers(2, 4))
        A = rng.normal(size=(n, n))
        M = A @ A.T + 0.3 * np.eye(n)
        W_N, W_F = rng.normal(size=(2, n_c, n))
        e, mu = float(rng.uniform(0, 1)), float(rng.uniform(0.05, 1.0))
        u = rng.normal(size=n)
        made = linear(M, W_N, W_F, [ns.Contact(mu=mu, e_N=e, impact=impact)] * n_c)
        after = struck(made, u, ns.MoreauJean(dt=1e-9))
        scale = 0.5 * u @ M @ u
        gains.append((0.5 * after @ M @ after - scale) / scale)
        assert (W_N @ after >= -1e-8 * np.abs(W_N @ u).max()).all()
    assert max(gains) <= 1e-12 and min(gains) < -0.1


@pytest.mark.parametrize("integrator", INTEGRATORS[:2], ids=["fixed", "events"])
def test_a_block_that_falls_with_friction_comes_to_rest(integrator):
    from tests.systems import PointMass  # its weight

    def weight(t, q, u, p, h):
        h[1] = -9.81

    for impact in ("sequential", "poisson", "energetic"):
        made = feet(0.4, 0.5, impact)
        made = ns.System(n_q=3, mass=made.mass, force=weight, gap=gap, tangent=tangent, contacts=made.contacts,
                         parameters=made.parameters)  # fmt: skip
        sol = ns.simulate(made, (0, 3), [0, 0.1, 0], [0.5, 0, 0], integrator=integrator, on_failure="return")
        energy = 0.5 * (sol.u**2 @ [1.0, 1.0, J]) + 9.81 * sol.q[:, 1]
        assert sol.success and (energy <= energy[0] + 1e-9).all() and PointMass().g == 9.81
        np.testing.assert_allclose(sol.u[-1], 0.0, atol=1e-6)


def test_an_own_law_of_friction_may_stand_in_impacts_of_several():
    law = ns.Friction(lambda v, p: 0.3 / (1.0 + v))
    u = [3.0, -1.0, 0.0]
    made = linear(np.diag([1.0, 1.0, J]), FEET_N, FEET_F, [ns.Contact(mu=law, e_N=0.5, impact="poisson")] * 2)
    found = struck(made, u, ns.MoreauJean(dt=1e-9))
    assert math.isclose(found[1], 0.5, rel_tol=1e-6) and found[0] < 3.0
