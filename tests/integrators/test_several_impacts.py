"""Several contacts hit at one instant, by the law that was chosen: closed forms of beads in a line."""

from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns

INTEGRATORS = [ns.MoreauJean(dt=1e-2), ns.EventDriven(), ns.Adaptive()]
of_all = pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda method: type(method).__name__)
ROUNDING = 1e-12  # derived: of velocities of 1 m/s after some 100 blows of 4 roundings each


class Beads(NamedTuple):
    m: np.ndarray


def mass(t, q, p, M):
    for i in range(M.shape[0]):
        M[i, i] = p.m[i]


def force(t, q, u, p, h):
    h[0] = 0.0


def gap(t, q, p, g_N):
    for i in range(g_N.shape[0]):
        g_N[i] = q[i + 1] - q[i]


def normal(t, q, p, W_N):
    for i in range(W_N.shape[0]):
        W_N[i, i], W_N[i, i + 1] = -1.0, 1.0


def beads(m, contacts):
    """Beads of these masses in a line, which touch."""
    return ns.System(n_q=len(m), mass=mass, force=force, gap=gap, normal=normal, contacts=contacts,
                     parameters=Beads(np.array(m, float)))  # fmt: skip


def after(m, u, contacts, integrator, last=0):
    """Velocities after the first beads, up to ``last``, have come from 5 mm to the others, which touch."""
    q = np.zeros(len(m))
    q[: last + 1] -= 5e-3
    solution = ns.simulate(beads(m, contacts), (0, 0.2), q, np.array(u, float), integrator=integrator)
    energies = 0.5 * (np.array(m) * solution.u**2).sum(axis=1)
    assert (np.diff(energies) <= ROUNDING).all()  # never gains
    momenta = solution.u @ np.array(m, float)
    np.testing.assert_allclose(momenta, momenta[0], rtol=0, atol=ROUNDING)
    return solution.u[-1]


def sequential(e, n):
    return [ns.Contact(e_N=e, impact="sequential")] * n


@of_all
def test_newtons_cradle_sends_the_last_bead(integrator):
    u = after([1.0] * 5, [1, 0, 0, 0, 0], sequential(1.0, 4), integrator)
    np.testing.assert_allclose(u, [0, 0, 0, 0, 1], rtol=0, atol=ROUNDING)


@of_all
def test_two_beads_send_two(integrator):
    u = after([1.0] * 5, [1, 1, 0, 0, 0], sequential(1.0, 4), integrator, last=1)
    np.testing.assert_allclose(u, [0, 0, 0, 1, 1], rtol=0, atol=ROUNDING)


@of_all
def test_last_of_n_beads_that_lose_leaves_with_a_power(integrator):
    e, n = 0.5, 5  # v_(k+1) = (1 + e)/2 v_k, and no other bead is as fast
    u = after([1.0] * n, [1, 0, 0, 0, 0], sequential(e, n - 1), integrator)
    assert u[-1] == pytest.approx(((1 + e) / 2) ** (n - 1), rel=ROUNDING)
    assert (np.diff(u) >= -ROUNDING).all()  # nothing approaches


@of_all
def test_unequal_beads_with_their_own_restitutions_follow_each_other(integrator):
    m, e_1, e_2 = [2.0, 1.0, 2.0], 0.8, 0.9
    contacts = [ns.Contact(e_N=e, impact="sequential") for e in (e_1, e_2)]
    u = after(m, [1, 0, 0], contacts, integrator)
    v_1 = (1 + e_1) * m[0] / (m[0] + m[1])  # of bead 1 after bead 0 struck it
    v_0 = (m[0] - e_1 * m[1]) / (m[0] + m[1])
    v_2 = (1 + e_2) * m[1] / (m[1] + m[2]) * v_1
    w_1 = (m[1] - e_2 * m[2]) / (m[1] + m[2]) * v_1
    assert w_1 < v_0 < v_2  # bead 0 strikes bead 1 again
    v = (m[0] * v_0 + m[1] * w_1) / (m[0] + m[1])
    back = e_1 * (v_0 - w_1) / (m[0] + m[1])
    np.testing.assert_allclose(u, [v - back * m[1], v + back * m[0], v_2], rtol=0, atol=ROUNDING)
    assert v + back * m[0] < v_2


@of_all
def test_poissons_law_gives_newtons_answer_to_a_line_at_rest_and_its_own_to_one_that_parts(integrator):
    e = 0.5
    contacts = [ns.Contact(e_N=e, impact="poisson")] * 4
    u = after([1.0] * 5, [1, 0, 0, 0, 0], contacts, integrator)
    mean, P = 0.2, np.array([0.8, 0.6, 0.4, 0.2])  # compression: one velocity, and the impulses of it
    np.testing.assert_allclose(u, mean + e * np.diff(np.concatenate([[0.0], -P, [0.0]])), rtol=0, atol=ROUNDING)


@of_all
def test_two_contacts_struck_together_follow_poisson_or_their_order(integrator):
    """Balls 0 and 2 strike ball 1 between them at once, ball 2 half as fast."""

    def velocities(impact, e):
        made = beads([1.0] * 3, [ns.Contact(e_N=e, impact=impact)] * 2)
        return ns.simulate(made, (0, 0.01), np.zeros(3), [1.0, 0.0, -0.5], integrator=integrator).u[-1]

    # compression: all at 1/6; P_C = (5/6, 2/3)
    e = 0.5
    np.testing.assert_allclose(velocities("poisson", e), [1 / 6 - e * 5 / 6, 1 / 6 + e / 6, 1 / 6 + e * 2 / 3],
                               atol=1e-9)  # fmt: skip
    # e = 1: 0 stops and hands its 1 to ball 1, which meets ball 2, hands that on and takes -1/2, which goes to ball 0
    np.testing.assert_allclose(velocities("sequential", 1.0), [-0.5, 0.0, 1.0], atol=1e-9)


@of_all
def test_equal_approaches_begin_with_the_lowest_number(integrator):
    """Two balls strike a third between them symmetrically: what follows is not symmetric."""
    made = beads([1.0, 2.0, 1.0], sequential(0.5, 2))
    found = ns.simulate(made, (0, 0.01), np.zeros(3), [1.0, 0.0, -1.0], integrator=integrator).u[-1]
    v = [1.0, 0.0, -1.0]
    for _ in range(200):  # the fastest approach first, of equal ones the first
        closing = [v[0] - v[1], v[1] - v[2]]
        i = 0 if closing[0] >= closing[1] else 1
        if closing[i] <= 1e-10:
            break
        m = (1.0, 2.0, 1.0)
        P = 1.5 * closing[i] / (1 / m[i] + 1 / m[i + 1])
        v[i], v[i + 1] = v[i] - P / m[i], v[i + 1] + P / m[i + 1]
    assert abs(v[0] + v[2]) > 0.01
    np.testing.assert_allclose(found, v, rtol=0, atol=1e-9)


def test_laws_of_several_contacts_that_cannot_be_are_refused():
    def refused(message, *contacts):
        with pytest.raises(ns.InvalidInput, match=message):
            ns.System(n_q=3, mass=mass, force=force, gap=gap, contacts=contacts, parameters=Beads(np.ones(3)),
                      tangent=mass)  # fmt: skip

    one = ns.Contact(e_N=0.5, impact="sequential")
    refused("or several that are all unilateral and of the same law", one, ns.Contact())
    refused("all unilateral", one, ns.Contact(bilateral=True, impact="sequential"))
    poisson = [ns.Contact(e_N=e, impact="poisson") for e in (0.5, 0.6)]
    refused("'poisson' of several contacts needs one e_N, with several they may gain energy; got 0.5, 0.6", *poisson)


def test_gravity_presses_a_struck_row_to_rest():
    """A ball falls onto two that rest on a table, e = 0.5: all come to rest, and no energy is won."""

    class P(NamedTuple):
        g: float = 9.81

    def unit(t, q, p, M):
        for i in range(3):
            M[i, i] = 1.0

    def weight(t, q, u, p, h):
        for i in range(3):
            h[i] = -p.g

    def heights(t, q, p, g_N):
        g_N[0] = q[0]
        g_N[1] = q[1] - q[0]
        g_N[2] = q[2] - q[1]

    def height(t, q, p, V):
        V[0] = p.g * (q[0] + q[1] + q[2])

    for impact in ("sequential", "poisson", "energetic"):
        made = ns.System(n_q=3, mass=unit, force=weight, gap=heights, potential=height, parameters=P(),
                         contacts=[ns.Contact(e_N=0.5, impact=impact)] * 3)  # fmt: skip
        sol = ns.simulate(made, (0, 2), [0, 0, 0.1], [0, 0, 0], integrator=ns.MoreauJean(dt=1e-3))
        total = 0.5 * (sol.u**2).sum(axis=1) + 9.81 * sol.q.sum(axis=1)
        np.testing.assert_allclose(sol.u[-1], 0.0, atol=1e-12)
        assert (total <= total[0] + 1e-12).all()
