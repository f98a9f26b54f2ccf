"""Poisson's and the energetic law of impact with friction in two directions, in runs of one contact."""

import dataclasses
import math

import numpy as np
import pytest

import nonsmooth as ns
from models import RobotFinger, SpatialPainleveRod


def with_law(rod, law):
    """The system of a rod whose tip follows a law of impact."""
    system = rod.system()
    (tip,) = system.contacts
    given = {name: getattr(system, name) for name in ("mass", "force", "gap", "normal", "tangent", "row_rates")}
    contact = ns.Contact(mu=tip.mu, e_N="e", directions=2, impact=law, name="tip")
    return ns.System(n_q=5, **given, potential=system.potential, contacts=[contact], parameters=rod)


def run(rod, law, q, u, t_end, dt):
    return ns.simulate(with_law(rod, law), (0, t_end), q, u, integrator=ns.MoreauJean(dt=dt))


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_a_run_goes_through_the_paradox_by_the_law_of_its_contact(law):
    """From an inconsistent state: the velocities of the impact without collision, to first order in the step."""
    rod, state = SpatialPainleveRod(mu=2.0, e=0.7), {"th": 1.0, "phi": 0.5}
    exact, errors = rod.impact_without_collision(**state, e=0.7, law=law), []
    for dt in (1e-4, 5e-5, 2.5e-5):
        sol = run(rod, law, *rod.state(**state), 20 * dt, dt)
        jumped = np.flatnonzero(sol.P_N[:, 0] > 0.5 * exact.P_N)[0]
        errors.append(np.abs(sol.u[jumped] - exact.u).max())
        (event,) = [e for e in sol.events if e.kind == ns.EventKind.INCONSISTENT]
        assert event.P_N == pytest.approx(exact.P_N, rel=30 * dt)
    assert errors[-1] < 2e-3
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 1.0, atol=0.15)


def follow(model, law):
    """The system of a model whose contact follows a law of impact."""
    system = model.system()
    return dataclasses.replace(system, contacts=[dataclasses.replace(system.contacts[0], impact=law)])


def lost(sol):
    return [event for event in sol.events if event.kind == ns.EventKind.INCONSISTENT]


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_a_slide_that_turns_past_rest_ends_by_the_law_of_its_contact(law):
    finger, state = RobotFinger(mu=2.5, e=0.5), {"th2": -1.27, "phi": -0.94, "slip": 0.5}
    (exact,) = [x for x in ns.classify(finger, state=state).impacts if x.law.name.lower() == law]
    assert np.linalg.norm(exact.gamma_F[0]) > 0.01
    errors = []
    for dt in (4e-6, 2e-6, 1e-6):
        sol = ns.simulate(follow(finger, law), (0, dt), *finger.state(**state), integrator=ns.MoreauJean(dt=dt))
        (event,) = lost(sol)
        assert event.mode_after == ns.ContactMode.SLIDE and event.P_N == pytest.approx(exact.P_N[0], rel=2e4 * dt)
        errors.append(np.abs(sol.u[-1] - exact.u).max())
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 1.0, atol=0.1)


@pytest.mark.parametrize(("law", "order"), [("newton", 1.0), ("poisson", 0.5), ("energetic", 1.0)])
def test_a_slide_that_its_force_turns_into_the_paradox_ends_as_event_driven_says(law, order):
    """p = 0 is met after 16.8 ms; what its slide takes until then, of O(sqrt(dt)), is compression to Poisson's law."""
    rod = SpatialPainleveRod(mu=2.0, e=0.5)
    system, start = follow(rod, law), rod.state(th=1.0, phi=1.2, psidot=4.0, slip=3.0)
    exact = ns.simulate(system, (0, 0.02), *start, integrator=ns.EventDriven(rtol=1e-10, atol=1e-12))
    after, steps, errors = exact.u[np.flatnonzero(exact.t == exact.events[0].t)[-1]], [1e-4, 2.5e-5, 6.25e-6], []
    for dt in steps:
        sol = ns.simulate(system, (0, 0.02), *start, integrator=ns.MoreauJean(dt=dt))
        (event,) = lost(sol)
        assert abs(event.t - exact.events[0].t) < 2 * dt
        errors.append(np.abs(sol.u[np.searchsorted(sol.t, event.t + 0.5 * dt)] - after).max())
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(order, abs=0.25)


@pytest.mark.upkeep
def test_of_a_thousand_slides_that_have_a_force_none_is_lost():
    """Whether they go on under the force that is classified, in 10 ns, or come to rest in 5 ms."""
    rng, seen = np.random.default_rng(12), 0
    while seen < 1000:
        rod = SpatialPainleveRod(mu=rng.uniform(0.5, 2.5), e=0.5)
        state = {"th": rng.uniform(0.3, 1.4), "phi": rng.uniform(-3, 3), "psidot": rng.normal(), "slip": 0.3}
        told = ns.classify(rod, state=state)
        if told.n_solutions != 1 or abs(told.p[0]) < 1e-2:
            continue
        q, u = rod.state(**state)
        sol = ns.simulate(follow(rod, "energetic"), (0, 1e-8), q, u, integrator=ns.MoreauJean(dt=1e-8))
        assert not lost(sol)
        assert sol.P_N[-1, 0] / 1e-8 == pytest.approx(told.solutions[0].la[0, 0], rel=1e-3)
        seen += 1
    stuck = 0
    for _ in range(100):
        th = rng.uniform(0.3, 1.3)
        rod = SpatialPainleveRod(mu=rng.uniform(0.7, 1.0) * SpatialPainleveRod().critical_friction(th), e=0.5)
        q, u = rod.state(th, rng.uniform(-3, 3), slip=rng.uniform(1e-3, 2e-2))
        sol = ns.simulate(follow(rod, "energetic"), (0, 5e-3), q, u, integrator=ns.MoreauJean(dt=1e-5))
        stuck += (sol.mode == ns.ContactMode.STICK).any()
        assert not lost(sol)
    assert stuck > 50


@pytest.mark.parametrize("law", ["poisson", "energetic"])
def test_with_e_0_all_laws_are_newtons_which_is_not_their_limit(law):
    """The slide turns within a blow with e -> 0; Newton's law takes its direction at the end."""
    rng, furthest = np.random.default_rng(5), 0.0
    for _ in range(40):
        mu, state = rng.uniform(0.1, 1.2), {"th": rng.uniform(0.3, 1.3), "phi": rng.uniform(-3, 3), "slip": 0.7}
        ends = {}
        for e, rule in ((0.0, law), (0.0, "newton"), (1e-12, law)):
            rod = SpatialPainleveRod(mu=mu, e=e)
            q, u = rod.state(**state)
            u[2] -= 0.6
            for integrator in (ns.MoreauJean(dt=1e-7), ns.EventDriven(rtol=1e-9, atol=1e-11), ns.Adaptive(1e-7)):
                u_1 = ns.simulate(follow(rod, rule), (0, 1e-7), q, u, integrator=integrator).u[-1]
                np.testing.assert_allclose(u_1, ends.setdefault((e, rule), u_1), atol=1e-5)
        np.testing.assert_allclose(ends[0.0, law], ends[0.0, "newton"], atol=1e-12)
        furthest = max(furthest, np.abs(ends[0.0, law] - ends[1e-12, law]).max())
    assert furthest > 0.1


@pytest.mark.parametrize("law", ["poisson", "energetic"])
def test_with_azimuth_zero_a_run_is_that_of_the_plane(law):
    from models import PainleveRod

    space, plane = SpatialPainleveRod(mu=0.4, e=0.6), PainleveRod(mu=0.4, e=0.6)
    q, u = plane.state(th=0.9, thdot=1.0, slip=-0.5)
    q[1] += 0.05
    flat = plane.system()
    given = {name: getattr(flat, name) for name in ("mass", "force", "gap", "normal", "tangent", "row_rates")}
    planar = ns.System(n_q=3, **given, contacts=[ns.Contact(mu="mu", e_N="e", impact=law)], parameters=plane)
    in_plane = ns.simulate(planar, (0, 0.15), q, u, integrator=ns.MoreauJean(dt=1e-4))
    in_space = run(space, law, [q[0], 0, q[1], q[2], 0], [u[0], 0, u[1], u[2], 0], 0.15, 1e-4)
    struck = [event for event in in_space.events if event.kind == ns.EventKind.IMPACT]
    assert struck and struck[0].t == in_plane.events[0].t
    np.testing.assert_allclose(in_space.u[:, [0, 2, 3]], in_plane.u, atol=2e-3)
    np.testing.assert_allclose(in_space.u[:, [1, 4]], 0.0, atol=1e-14)


@pytest.mark.parametrize("law", ["poisson", "energetic"])
def test_an_oblique_blow_is_that_of_the_hodograph(law):
    """One step from the ground: gamma+ of the block mechanics/impact_in_space, with what the weight does in a step."""
    from nonsmooth.jit.blocks import new
    from nonsmooth.mechanics.impact_in_space import Hodograph, collide_in_space

    rng, dt = np.random.default_rng(8), 1e-6
    for _ in range(10):
        rod = SpatialPainleveRod(mu=rng.uniform(0.1, 0.9), e=0.8)
        th = rng.uniform(0.3, 1.3)
        q, u = rod.state(th, rng.uniform(-3, 3), slip=rng.uniform(0.2, 1.0))
        u[2] -= 0.6
        q[2] -= 1e-9
        sol, h = run(rod, law, q, u, dt, dt), new(Hodograph)
        h.mu, h.e, h.law, h.G[:] = rod.mu, 0.8, {"poisson": 1, "energetic": 2}[law], rod.delassus(th)
        h.before[:] = [-0.6, *u[:2]]
        assert collide_in_space(h.address)
        np.testing.assert_allclose([sol.P_N[-1, 0], *sol.P_F[-1, 0]], h.impulse, atol=1e-4)
        assert sol.mode[-1, 0] in (ns.ContactMode.STICK, ns.ContactMode.SLIDE)


def test_the_energetic_law_never_gains_energy():
    rng = np.random.default_rng(9)
    for _ in range(30):
        rod = SpatialPainleveRod(mu=rng.uniform(0.1, 2.5), e=1.0, g=0.0)
        q, u = rod.state(rng.uniform(0.2, 1.4), rng.uniform(-3, 3), slip=rng.uniform(0.0, 1.0))
        u[2] -= 0.5
        sol = run(rod, "energetic", q, u, 1e-5, 1e-5)
        change = sol.ledger["kinetic"][-1] - sol.ledger["kinetic"][0]
        assert change < 1e-6


def test_a_ball_that_bounces_comes_to_rest_on_the_ground():
    """Under each law: no more penetration than Newton's, where a blow and the weight share a step."""
    depths = {}
    for law in ("newton", "poisson", "energetic"):
        rod = SpatialPainleveRod(mu=0.6, e=0.5)
        q, u = rod.state(th=math.pi / 2 - 1e-3, slip=0.0)
        u[2] -= 1.0
        sol = run(rod, law, q, u, 0.3, 1e-3)
        depths[law] = -sol.g_N.min()
    assert max(depths["poisson"], depths["energetic"]) < 3 * depths["newton"]


def test_several_contacts_take_newtons_law_alone():
    def gap(t, q, p, g_N):
        g_N[0], g_N[1] = q[2], q[2]

    def tangent(t, q, p, W_F):
        for k in range(2):
            W_F[k, 0, 0], W_F[k, 1, 1] = 1.0, 1.0

    contacts = [ns.Contact(mu=0.3, directions=2, impact="poisson"), ns.Contact(mu=0.3, directions=2, impact="poisson")]
    with pytest.raises(ns.InvalidInput, match="of one contact also 'poisson' and 'energetic'"):
        ns.System(n_q=3, mass=lambda t, q, p: np.eye(3), force=lambda t, q, u, p: [0, 0, -9.81], gap=gap,
                  tangent=tangent, contacts=contacts)  # fmt: skip
