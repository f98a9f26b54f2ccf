"""One impact with friction in two directions, against an independent integration in P, energy, and the plane."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from models import PainleveRod, SpatialPainleveRod
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.impact_in_space import Hodograph, collide, collide_in_space
from nonsmooth.mechanics.laws import ImpactLaw

LAWS = [ImpactLaw.NEWTON, ImpactLaw.POISSON, ImpactLaw.ENERGETIC]


def impact(G, mu, gamma, e, law):
    h = new(Hodograph)
    h.mu, h.e, h.law, h.G[:], h.before[:] = mu, e, int(law), G, gamma
    assert collide_in_space(h.address)
    return h


def by_integration(G, mu, gamma, e, law):
    """gamma and P after the impact: gamma(P) by DOP853 down to 1e-9 of the speed, then sticking; P_T from gamma_T."""

    def rate(P, y):
        d = y[1:3] / np.linalg.norm(y[1:3])
        force = np.array([1.0, *(-mu * d)])
        return [*(G @ force), y[0]]  # and the work

    def stops(P, y):
        return np.linalg.norm(y[1:3]) - 1e-9 * np.linalg.norm(gamma[1:])

    stops.terminal = True
    first = solve_ivp(rate, (0, 1e3), [*gamma, 0.0], "DOP853", rtol=1e-13, atol=1e-15, events=stops, dense_output=True)
    P_1, y_1 = first.t[-1], first.y[:, -1]
    q = -np.linalg.solve(G[1:, 1:], G[1:, 0])
    rise = G[0, 0] + G[0, 1:] @ q

    def at(P):
        if P <= P_1:
            return first.sol(P)
        dP = P - P_1
        return np.array([y_1[0] + rise * dP, 0.0, 0.0, y_1[3] + y_1[0] * dP + rise * dP**2 / 2])

    grid = np.linspace(0.0, 3.0 * P_1 + 3.0 * abs(gamma[0]) / rise, 6001)[1:]
    gamma_N = np.array([at(P)[0] for P in grid])
    assert gamma_N[0] < 0
    k = int(np.argmax(gamma_N >= 0))
    P_c = brentq(lambda P: at(P)[0], grid[k - 1], grid[k], xtol=1e-15)
    W_c = at(P_c)[3]
    if law == ImpactLaw.NEWTON:
        P_end = brentq(lambda P: at(P)[0] + e * gamma[0], P_c, 50 * P_c + 1, xtol=1e-15) if e * gamma[0] else P_c
    elif law == ImpactLaw.POISSON:
        P_end = (1 + e) * P_c
    else:
        P_end = brentq(lambda P: at(P)[3] - (1 - e**2) * W_c, P_c, 50 * P_c, xtol=1e-15)
    after = at(P_end)[:3]
    P_T = np.linalg.solve(G[1:, 1:], after[1:] - gamma[1:] - G[1:, 0] * P_end)
    return after, np.array([P_end, *P_T])


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("phi", [0.1, 0.4, -0.7])
def test_impacts_without_collision_of_the_rod_agree_with_an_integration_in_the_impulse(law, phi):
    rod = SpatialPainleveRod(mu=2.0)
    G, d = rod.delassus(1.0), -np.array([math.cos(phi), math.sin(phi)])
    assert rod.p(1.0, phi) < 0
    gamma = np.array([0.0, *(0.8 * d)])
    found, (after, P) = impact(G, 2.0, gamma, 0.6, law), by_integration(G, 2.0, gamma, 0.6, law)
    np.testing.assert_allclose(found.impulse, P, atol=1e-9)
    np.testing.assert_allclose(found.gamma, after, atol=2e-9)
    np.testing.assert_allclose(found.gamma, gamma + G @ found.impulse, atol=1e-13)


@pytest.mark.upkeep
@pytest.mark.parametrize("law", LAWS)
def test_random_collisions_agree_with_an_integration_in_the_impulse(law):
    rng, met = np.random.default_rng(4), 0
    while met < 12:
        A = rng.normal(size=(3, 3))
        G, mu = A @ A.T + 0.5 * np.eye(3), rng.uniform(0.2, 1.5)
        if np.linalg.norm(np.linalg.solve(G[1:, 1:], G[1:, 0])) > 0.9 * mu:
            continue  # sliding on is another test
        gamma = np.array([-rng.uniform(0.2, 1.0), *rng.normal(size=2)])
        found, (after, P) = impact(G, mu, gamma, 0.7, law), by_integration(G, mu, gamma, 0.7, law)
        np.testing.assert_allclose(found.impulse, P, rtol=1e-8, atol=2e-9)
        np.testing.assert_allclose(found.gamma, after, atol=1e-8)
        met += 1


@pytest.mark.parametrize(("law", "gamma_N"), [(ImpactLaw.NEWTON, 0.0), (ImpactLaw.POISSON, 0.39970403),
                                              (ImpactLaw.ENERGETIC, 0.22730317)])  # fmt: skip
def test_without_azimuth_it_is_the_impact_of_the_plane(law, gamma_N):
    values = {"m": 1.0, "l": 2.0, "I": 1 / 3, "mu": 1.8}
    th = math.radians(60.0)
    found = impact(SpatialPainleveRod(**values).delassus(th), 1.8, [0.0, -1.0, 0.0], 1.0, law)
    assert found.gamma[0] == pytest.approx(gamma_N, abs=6e-9)
    plane = PainleveRod(**values).impact_without_collision(th, 0.0, -1.0, e=1.0, law=law.name.lower())
    np.testing.assert_allclose(found.impulse, [plane.P_N, plane.P_F, 0.0], rtol=1e-12, atol=1e-16)
    assert found.P_c == pytest.approx(plane.P_c, rel=1e-12)


def test_the_energetic_law_gives_back_e_squared_of_the_work_and_friction_takes_the_rest():
    """T+ - T- = work of the normal impulse and of friction, -mu int v dP, by the path."""
    rod = SpatialPainleveRod(mu=2.0)
    G, gamma = rod.delassus(1.0), np.array([0.0, -0.5, -0.3])
    h = impact(G, 2.0, gamma, 0.5, ImpactLaw.ENERGETIC)
    assert h.work == pytest.approx((1 - 0.5**2) * h.work_c, rel=1e-12) and h.work_c < 0
    after = np.asarray(h.gamma)
    change = 0.5 * (after @ np.linalg.solve(G, after) - gamma @ np.linalg.solve(G, gamma))
    assert change < h.work < 0
    # friction: -mu int v dP, by the points of the path and the trapezoidal rule between them
    P, v = h.path[: h.n, 0], np.hypot(*h.path[: h.n, 2:].T)
    assert change - h.work == pytest.approx(-2.0 * np.trapezoid(v, P), rel=0.05)


def test_where_the_cone_does_not_hold_it_slides_away_on_a_ray_that_does_not_turn():
    """The plane once more: a slide that comes to rest is turned back where |G_NF|/G_FF > mu."""
    G = np.array([[1.0, 0.0, 0.9], [0.0, 1.5, 0.0], [0.9, 0.0, 1.0]])
    h = impact(G, 0.5, [-1.0, 0.0, -0.2], 0.5, ImpactLaw.POISSON)
    assert h.gamma[2] > 0 and abs(h.gamma[1]) < 1e-15
    assert np.hypot(*h.impulse[1:]) < 0.5 * h.impulse[0]
    # -mu over the way to rest, +mu on the way back
    P_1 = 0.2 / (0.9 + 0.5)
    assert h.impulse[2] == pytest.approx(0.5 * P_1 - 0.5 * (h.impulse[0] - P_1), rel=1e-12)


def test_in_space_a_slide_that_cannot_stick_swerves_and_never_rests():
    """A little aside of the plane the velocity turns by half a turn; the outcome is near that of the plane."""
    G = np.array([[1.0, 0.0, 0.9], [0.0, 1.5, 0.0], [0.9, 0.0, 1.0]])
    plane = impact(G, 0.5, [-1.0, 0.0, -0.2], 0.5, ImpactLaw.POISSON)
    near = impact(G, 0.5, [-1.0, 1e-6, -0.2], 0.5, ImpactLaw.POISSON)
    np.testing.assert_allclose(near.gamma, plane.gamma, atol=1e-3)
    assert (near.slides[: near.n] == 1).all() and np.hypot(*near.path[: near.n, 2:].T).min() > 0


def test_machine_code_has_the_bits_of_its_source():
    G, gamma = SpatialPainleveRod(mu=2.0).delassus(1.0), [0.0, -0.8, 0.2]
    for law in LAWS:
        h, twin = impact(G, 2.0, gamma, 0.6, law), new(Hodograph)
        twin.mu, twin.e, twin.law, twin.G[:], twin.before[:] = 2.0, 0.6, int(law), G, gamma
        assert interpreted(collide)(twin)
        np.testing.assert_array_equal(h.path, twin.path)
        assert h.impulse.tolist() == twin.impulse.tolist()
