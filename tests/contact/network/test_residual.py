"""The residual of a network: its definition written once more in numpy, of islands, light contacts, next to nothing."""

import math

import numpy as np
import pytest

from nonsmooth.contact.network.problem import UNSEEN, worst_contact
from nonsmooth.jit import interpreted
from nonsmooth.numerics.rounding import EPS
from tests.contact.network.problems import judge, network_of

TOL = 1e-8


def pairs(d, count, rng, ratio=1.0, speed=1.0):
    """Islands of three bodies in a row each, the lower one on what is fixed, with random impulses of their cones."""
    n = 3 * (d - 1)
    x, contacts, normal = [np.zeros(d)], [], np.eye(d)[-1]
    for k in range(count):
        place = np.zeros(d)
        place[0] = 3.0 * k
        for a in range(3):
            x.append(place + (0.5 + a) * normal)
            contacts.append((len(x) - 2 if a else 0, len(x) - 1, normal, place + a * normal, 0.0))
    scales = np.ones(len(x))
    scales[2::3] = ratio
    M = scales[:, None, None] * np.eye(n)
    network = network_of(x, M, speed * rng.normal(size=(len(x), n)), contacts, fixed=(0,))
    network.v_free[0] = 0.0
    network.P[:, 0] = rng.uniform(0.5, 1.0, len(contacts))
    network.P[:, 1:] = 0.2 * rng.normal(size=(len(contacts), d - 1))
    network.tol = TOL
    return network


def projected(mu, z):
    """The projection on the cone |z_T| <= mu z_N, by its three cases."""
    N, T = z[0], np.linalg.norm(z[1:])
    if T <= mu * N:
        return z
    if mu * T <= -N:
        return np.zeros(len(z))
    N = (N + mu * T) / (1 + mu * mu)
    return np.concatenate(([N], mu * N * z[1:] / T))


def of_contacts(network, contacts):
    """|F|, |P| and R of some contacts, and F of each."""
    d, n = network.b.shape[1], network.v.shape[1]
    F, R = [], 0.0
    for c in contacts:
        i, j, mu, rho, P = network.i[c], network.j[c], network.mu[c], network.rho[c], network.P[c]
        gamma = network.J_i[c] @ network.v[i] + network.J_j[c] @ network.v[j] + network.b[c]
        shifted = gamma + np.eye(d)[0] * mu * np.linalg.norm(gamma[1:])
        F.append(P - projected(mu, P - rho * shifted))
        size = np.abs(network.J_i[c]) @ np.abs(network.v[i]) + np.abs(network.J_j[c]) @ np.abs(network.v[j])
        size += np.abs(network.b[c])
        is_open = network.P[c, 0] == 0.0 and gamma[0] > (2 * n + 1) * EPS * size[0]
        size[0] += mu * np.linalg.norm(size[1:])
        R += rho**2 * (0.0 if is_open else size @ size)
    return np.linalg.norm(F), np.linalg.norm(network.P[contacts]), (2 * n + 1) * EPS * math.sqrt(R), F


def relative(network, contacts):
    """Their residual."""
    F, P, R, _ = of_contacts(network, contacts)
    if network.tol * P >= F:
        return F / P if P else 0.0
    if P == 0.0:
        return min(1.0, F * network.tol / R) if F > R else 0.0
    return F / max(P, R / network.tol)


def residual_of_island(network, k):
    islands = network.islands
    contacts = islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]]
    rho, found = network.rho[contacts], [relative(network, contacts)]
    bound = UNSEEN * rho.max()
    while rho.min() < bound:
        found.append(relative(network, contacts[rho < bound]))
        bound *= UNSEEN
    return max(found)


@pytest.mark.parametrize("ratio", [1.0, 1e-9, 1e9])
@pytest.mark.parametrize("d", [2, 3])
def test_the_residual_of_a_problem_is_the_largest_of_its_islands(d, ratio):
    rng = np.random.default_rng(d)
    for speed in (1.0, 1e7, 1e9):
        network = pairs(d, 5, rng, ratio, speed)
        found = judge(network)
        count = int(network.islands.count)
        expected = [residual_of_island(network, k) for k in range(count)]
        assert count == 5
        np.testing.assert_allclose(network.islands.residual[:count], expected, rtol=1e-6)
        assert found == network.islands.residual[:count].max()


@pytest.mark.parametrize("d", [2, 3])
def test_what_is_loaded_hides_no_island_that_is_not_solved(d):
    rng = np.random.default_rng(7)
    network = pairs(d, 3, rng)
    network.v_free[:] = 0.0
    network.P[:] = 0.0
    assert judge(network) == 0.0
    network.P[0, 0] = 1e-6  # an impulse that nothing asks for
    assert judge(network) > 0.1
    alone = network.islands.residual[0]
    network.P[3:] = 1e9 * np.eye(d)[0]  # of other islands
    judge(network)
    assert network.islands.residual[0] == alone


@pytest.mark.parametrize("speed", [1.0, 1e3, 1e8])
@pytest.mark.parametrize("d", [2, 3])
def test_without_a_load_there_is_no_residual(d, speed):
    """Bodies that travel alike, or part, at velocities whose roundings look like an approach."""
    rng, roundings = np.random.default_rng(3), 0
    for _ in range(50):
        network = pairs(d, 2, rng)
        network.b[:, :] = -speed * rng.normal(size=network.b.shape)
        network.P[:] = 0.0
        # velocities that cancel b but for their rounding, from the lowest body up
        network.v_free[:] = 0.0
        for c in range(int(network.n_c)):
            network.v_free[network.j[c], :d] = network.v_free[network.i[c], :d]
            rows = network.J_j[c][:, :d]
            network.v_free[network.j[c], :d] -= rows.T @ network.b[c]
        error = judge(network)
        of_all = network.islands.F[: int(network.islands.count)]
        roundings += int((of_all > 0.0).any())
        assert error == 0.0
    assert roundings > 5


@pytest.mark.parametrize("d", [2, 3])
def test_what_exceeds_rounding_counts_however_small_it_is(d):
    """An approach of a thousand roundings of the velocities, without an impulse, is above the tolerance."""
    network = pairs(d, 1, np.random.default_rng(0))
    network.P[:] = 0.0
    network.v_free[:] = 0.0
    network.v_free[1:, 0] = 100.0
    network.v_free[3, d - 1] = -1e4 * (6 * d) * EPS * 100.0
    assert judge(network) > 10 * TOL
    network.tol = 0.0  # without a tolerance nothing is taken for rounding
    assert judge(network) == 1.0


@pytest.mark.parametrize("width", [1e3, 1e9, 1e15])
@pytest.mark.parametrize("d", [2, 3])
def test_what_is_open_hides_no_error_of_others(d, width):
    """A gap that is wide for a short step, b_N = g/dt: the residual is that of the same problem without it."""
    network = pairs(d, 1, np.random.default_rng(1))
    network.P[2] = 0.0
    network.b[2, 0] = 100.0
    expected = judge(network)
    assert expected > 1e-3
    network.b[2, 0] = width
    assert judge(network) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("ratio", [1.0, 1e-9])
@pytest.mark.parametrize("d", [2, 3])
def test_the_worst_contact_is_that_of_the_largest_part(d, ratio):
    rng, find, found = np.random.default_rng(11), interpreted(worst_contact), set()
    for _ in range(20):
        network = pairs(d, 2, rng, ratio)
        network.P[rng.random(len(network.P)) < 0.3] = 0.0
        judge(network)
        islands = network.islands
        k = int(np.argmax(islands.residual[: int(islands.count)]))
        contacts = islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]]
        contacts = contacts[network.rho[contacts] < islands.below[k]]
        sizes = np.linalg.norm(of_contacts(network, contacts)[3], axis=1)
        worst = find(network, k, d, 3 * (d - 1))
        assert worst == contacts[int(np.argmax(sizes))]
        found.add(worst)
    assert len(found) > 2


def test_what_is_not_finite_is_no_residual():
    network = pairs(2, 3, np.random.default_rng(1))
    network.v_free[4, 0] = np.nan
    assert math.isnan(judge(network))
