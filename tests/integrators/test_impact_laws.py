"""Impacts by Newton's, Poisson's and the energetic law in a run, beside the impulse map of one instant."""

import math
from dataclasses import replace

import numpy as np
import pytest

import nonsmooth as ns
from models import PainleveRod
from nonsmooth.mechanics.impact import impulse_map
from nonsmooth.mechanics.laws import IMPACT_LAWS
from nonsmooth.mechanics.system import NORMAL, TANGENT

ROD = PainleveRod(m=1.0, l=2.0, I=1 / 3, mu=1.8, e=1.0)


def rod_with(impact, **changes):
    model = replace(ROD, **changes)
    return model, replace(model.system(), contacts=[ns.Contact(mu="mu", e_N="e", impact=impact)])


@pytest.mark.parametrize(
    ("impact", "gamma_N"), [("newton", 0.0), ("energetic", 0.22730317), ("poisson", 0.39970403)]
)  # the closed forms e P_1 sqrt(|p| (C_s + |p|)) and e P_1 (C_s + |p|) for slip -1 m/s, to the digits of NUMERICS 2
def test_impact_without_collision_ends_by_the_law_of_the_contact(impact, gamma_N):
    rod, system = rod_with(impact)
    dt = 1e-7  # gravity adds g dt = 1e-6
    solution = ns.simulate(system, (0, dt), *rod.state(th=math.pi / 3), integrator=ns.MoreauJean(dt=dt))
    (paradox,) = solution.paradoxes
    assert paradox.kind.name == "INCONSISTENT"
    exact = rod.impact_without_collision(e=1.0, law=impact)
    assert np.abs(solution.u[-1] - exact.u).max() < 2 * rod.g * dt
    W_N = system.evaluate(NORMAL, 0.0, solution.q[0], solution.u[0])[0]
    assert float(W_N @ solution.u[-1]) == pytest.approx(gamma_N, abs=2 * rod.g * dt)
    assert paradox.P_N == pytest.approx(exact.P_N, abs=2 * rod.g * dt)


@pytest.mark.parametrize(("impact", "gamma_N"), [("newton", 0.0), ("energetic", 0.22730317), ("poisson", 0.39970403)])
def test_event_driven_takes_the_same_impact_without_collision(impact, gamma_N):
    rod, system = rod_with(impact)
    solution = ns.simulate(
        system, (0, 1e-3), *rod.state(th=math.pi / 3), t_eval=[1e-9, 1e-3], integrator=ns.EventDriven()
    )
    paradox = solution.paradoxes[0]
    exact = rod.impact_without_collision(e=1.0, law=impact)
    assert paradox.kind.name == "INCONSISTENT" and paradox.P_N == pytest.approx(exact.P_N, rel=1e-9)
    assert np.abs(solution.u[0] - exact.u).max() < 1e-7  # gravity in 1e-9 s: 1e-8 m/s
    assert (solution.mode[-1] == ns.ContactMode.OPEN) == (gamma_N > 0.0)


@pytest.mark.parametrize("impact", ["poisson", "energetic"])
@pytest.mark.parametrize("slip", [-3.0, -0.05, 0.4])
def test_collision_ends_by_the_law_of_the_contact(impact, slip):
    """One step from touch with gamma_N = -1 m/s: the impulse map plus what gravity does in dt."""
    rod, system = rod_with(impact, e=0.6, mu=0.4)
    q, u = rod.state(th=1.0, slip=slip)
    W = [system.evaluate(which, 0.0, q, u).reshape(-1) for which in (NORMAL, TANGENT)]
    u = u - np.array([0.0, 1.0, 0.0])  # the whole rod falls: gamma_N = -1, gamma_F stays
    X = np.array(W) / np.array([rod.m, rod.m, rod.I])
    G = np.array(W) @ X.T
    P_N, P_F, _, _ = impulse_map(IMPACT_LAWS[impact], 0.6, 0.4, G[0, 0], G[0, 1], G[1, 1], -1.0, W[1] @ u)
    dt = 1e-7
    solution = ns.simulate(system, (0, dt), q, u, integrator=ns.MoreauJean(dt=dt))
    assert np.abs(solution.u[-1] - (u + P_N * X[0] + P_F * X[1])).max() < 20 * rod.g * dt
    assert solution.stats.ledger_error < 1e-14


def test_energetic_law_never_gains_energy():
    """Oblique impacts on rods of all angles: T_+ <= T_- for the energetic law."""
    for th in np.linspace(0.2, 1.5, 14):
        for slip in (-4.0, -0.5, 0.5, 4.0):
            rod, system = rod_with("energetic", mu=0.6)
            q, u = rod.state(th=th, slip=slip)
            u = u - np.array([0.0, 1.0, 0.0])
            solution = ns.simulate(system, (0, 1e-9), q, u, integrator=ns.MoreauJean(dt=1e-9))
            T = solution.ledger["kinetic"]
            assert T[-1] <= T[0] * (1 + 1e-7)  # gravity's work in 1e-9 s is below 1e-7 of T


def test_other_laws_than_newtons_need_a_single_contact_and_a_known_name():
    _, system = rod_with("newton")
    with pytest.raises(ns.InvalidInput, match="impact = 'poisson' needs a system with one contact"):
        replace(system, contacts=[ns.Contact(mu=0.1, impact="poisson"), ns.Contact(mu=0.1)])
    with pytest.raises(ns.UnknownName, match="no impact law 'possion'"):
        ns.Contact(impact="possion")


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_steps_of_blows_have_the_weight_and_the_gap_of_the_others(law):
    """A particle that falls on a rough floor: it slides through each blow, so all laws give back e, and comes to rest
    as deep as Newton's law leaves it, by a part of the way in a step. Without the weight of the steps of blows it sank
    by g dt in each."""

    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.0

    def force(t, q, u, p, h):
        h[1] = -9.81

    def gap(t, q, p, g):
        g[0] = q[1]

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    floor = ns.Contact(e_N=0.5, mu=0.3, impact=law)
    ball = ns.System(n_q=2, mass=mass, force=force, gap=gap, tangent=tangent, contacts=[floor])
    dt = 1e-3
    sol = ns.simulate(ball, (0, 1.5), [0, 0.5], [5.0, 0], integrator=ns.MoreauJean(dt=dt))
    ways = np.sqrt(2 * 9.81 * 0.5) * dt  # the way in a step before the first blow
    assert -ways < sol.q[:, 1].min() < 0.0 and abs(sol.q[-1, 1]) < 1e-2 * ways
    total = sol.ledger["normal"][-1] + sol.ledger["friction"][-1]
    assert 0.5 * (sol.u[-1] @ sol.u[-1]) - 12.5 - total - sol.ledger["force"][-1] == pytest.approx(0.0, abs=1e-10)
