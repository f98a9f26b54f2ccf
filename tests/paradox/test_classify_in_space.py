"""Classification of states with friction in two directions, against closed forms and a search of all directions."""

import math
import pickle
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from nonsmooth.paradox.stability import Stability
from nonsmooth.paradox.stability_in_space import slope_of_turning

FLAG = ns.ParadoxFlag


class Contact3(NamedTuple):
    """One contact by its Delassus matrix G (row by row) and its free accelerations c = (b, a_1, a_2)."""

    mu: float
    G: np.ndarray
    c: np.ndarray


def of_matrix(G, c, mu):
    """A system with coordinates (N, T1, T2): M = G^-1 and h = M c."""
    M_0 = np.linalg.inv(G)
    h_0 = M_0 @ c

    def mass(t, q, p, M):
        M[:] = M_0

    def force(t, q, u, p, h):
        h[:] = h_0

    def gap(t, q, p, g_N):
        g_N[0] = q[0]

    def tangent(t, q, p, W_F):
        W_F[0, 0, 1], W_F[0, 1, 2] = 1.0, 1.0

    return ns.System(n_q=3, mass=mass, force=force, gap=gap, tangent=tangent,
                     contacts=[ns.Contact(mu=mu, directions=2)])  # fmt: skip


def classified(G, c, mu, slip=(0.0, 0.0)):
    return ns.classify(of_matrix(np.array(G), np.array(c), mu), 0.0, [0, 0, 0], [0.0, *slip])


COUPLED = [[1.0, 0.8, 0.0], [0.8, 1.0, 0.0], [0.0, 0.0, 1.0]]


@pytest.mark.parametrize("angle", [0.0, 0.7, 1.4, 2.5, -2.0])
@pytest.mark.parametrize("b", [-1.0, 0.5])
def test_p_along_the_slide_decides_how_many_forces_there_are(angle, b):
    """p = G_NN - mu G_NT d; p > 0: one; p < 0: none with b < 0, two with b > 0."""
    d = np.array([math.cos(angle), math.sin(angle)])
    c = classified(COUPLED, [b, 0.0, 0.0], 2.0, 3.0 * d)
    p = 1.0 - 2.0 * 0.8 * d[0]
    assert c.p[0] == pytest.approx(p, abs=1e-12) and c.b[0] == pytest.approx(b, abs=1e-12)
    assert c.n_solutions == (1 if p > 0 else 0 if b < 0 else 2) and c.is_complete
    assert bool(c.flags & FLAG.PAINLEVE) == (p <= 0)
    assert c.mode == ("sliding",)
    np.testing.assert_allclose(c.direction[0], d, atol=1e-12)
    for solution in c.solutions:
        if solution.modes == ("slide",):
            np.testing.assert_allclose(solution.la[0, 0], -b / p, rtol=1e-12)
            np.testing.assert_allclose(solution.la[0, 1:], -2.0 * solution.la[0, 0] * d, rtol=1e-12)


def test_a_state_that_is_open_has_its_free_motion():
    system = of_matrix(np.eye(3), np.array([-1.0, 0.2, 0.3]), 0.5)
    c = ns.classify(system, 0.0, [1.0, 0, 0], [0, 0, 0])
    assert c.mode == ("open",) and c.n_solutions == 1 and c.kind == ns.ParadoxKind.REGULAR
    np.testing.assert_allclose(c.solutions[0].du, [-1.0, 0.2, 0.3])
    assert np.isnan(c.p[0]) and np.isnan(c.direction).all()


def test_what_lands_or_penetrates_is_refused():
    system = of_matrix(np.eye(3), np.array([-1.0, 0, 0]), 0.5)
    with pytest.raises(ns.InvalidInput, match="an impact comes first"):
        ns.classify(system, 0.0, [0, 0, 0], [-1.0, 0, 0])
    with pytest.raises(ns.InvalidInput, match="penetrates"):
        ns.classify(system, 0.0, [-0.1, 0, 0], [0, 0, 0])


def two_blocks(mu_2, directions=2):
    """Two tips with one Delassus matrix each, or coupled where a spring of inertia joins them."""
    M_0 = np.zeros((6, 6))
    M_0[:3, :3] = M_0[3:, 3:] = np.linalg.inv(COUPLED)

    def mass(t, q, p, M):
        M[:] = M_0

    def force(t, q, u, p, h):
        h[:3], h[3:] = -M_0[:3, 0], -M_0[3:, 3]

    def gap(t, q, p, g_N):
        g_N[0], g_N[1] = q[0], q[3]

    def tangent(t, q, p, W_F):
        for k in range(2):
            W_F[k, 0, 3 * k + 1], W_F[k, 1, 3 * k + 2] = 1.0, 1.0

    return ns.System(n_q=6, mass=mass, force=force, gap=gap, tangent=tangent,
                     contacts=[ns.Contact(mu=2.0, directions=2), ns.Contact(mu=mu_2, directions=2)])  # fmt: skip


def test_contacts_that_do_not_touch_one_another_are_decided_apart():
    """The first slides where p < 0 and b < 0: none for both, whatever the second one has."""
    c = ns.classify(two_blocks(0.5), 0.0, 6 * [0.0], [0, 1.0, 0, 0, 0, 0])
    assert (c.n_solutions, c.is_complete, c.kind) == (0, True, ns.ParadoxKind.INCONSISTENT)
    both = ns.classify(two_blocks(1.0), 0.0, 6 * [0.0], [0, 0, 1.0, 0, 0, 0])
    assert both.n_solutions == 1 and both.solutions[0].modes == ("slide", "stick")


def test_the_words_and_the_data_of_a_classification():
    c = classified(COUPLED, [-1.0, 0, 0], 2.0, (1.0, 0.0))
    assert str(c).splitlines()[0] == "INCONSISTENT: no contact force fits this state"
    assert "sliding along (1, 0), p = -0.6 1/kg, b = -1 m/s^2" in str(c)
    assert "! p <= 0" in str(c)
    data = c.to_dict()
    assert data["flags"] == ["PAINLEVE"] and data["direction"] == [[1.0, 0.0]]
    assert repr(c) == "SpatialClassification(INCONSISTENT, n_solutions=0, is_complete=True)"


def test_the_forces_of_a_slide_are_those_that_a_step_takes():
    """A short step from the state: its impulses over dt, to O(dt)."""
    system = of_matrix(np.array(COUPLED), np.array([-1.0, 0.3, 0.1]), 0.5)
    q, u, dt = [0, 0, 0], [0, 1.0, 2.0], 1e-6
    (solution,) = ns.classify(system, 0.0, q, u).solutions
    sol = ns.simulate(system, (0, dt), q, u, integrator=ns.MoreauJean(dt=dt))
    np.testing.assert_allclose(np.array([sol.P_N[-1, 0], *sol.P_F[-1, 0]]) / dt, solution.la[0], rtol=1e-5)


def test_impacts_without_collision_are_listed_where_a_slide_has_p_below_zero():
    """Their velocities are gamma + G P, each law's in its order; none of p > 0, of rest, or of coupled contacts."""
    c = classified(COUPLED, [-1.0, 0.2, 0.1], 2.0, (1.0, 0.7))
    newton, poisson, energetic = c.impacts
    assert [impact.law.name for impact in c.impacts] == ["NEWTON", "POISSON", "ENERGETIC"]
    again = ns.classify(of_matrix(np.array(COUPLED), np.array([-1.0, 0.2, 0.1]), 2.0), 0.0, [0, 0, 0], [0, 1.0, 0.7],
                        restitution=0.8)  # fmt: skip
    for impact in (newton, *again.impacts):
        P = np.array([impact.P_N[0], *impact.P_F[0]])
        after = np.array([0.0, 1.0, 0.7]) + np.array(COUPLED) @ P
        np.testing.assert_allclose(impact.u, after, atol=1e-14)
        np.testing.assert_allclose([impact.gamma_N[0], *impact.gamma_F[0]], after, atol=1e-14)
        assert np.linalg.norm(P[1:]) <= 2.0 * P[0]
    assert newton.gamma_N[0] == poisson.gamma_N[0] == energetic.gamma_N[0] == 0.0  # e = 0
    e_P, e_W = again.impacts[1], again.impacts[2]
    assert e_P.P_N[0] == pytest.approx(1.8 * newton.P_N[0], rel=1e-12) and 0 < e_W.gamma_N[0] < e_P.gamma_N[0]
    assert "energetic  0.8" in str(again) and again.to_dict()["impacts"][1]["law"] == "poisson"
    copied = pickle.loads(pickle.dumps(again))
    assert copied.impacts[1].P_N[0] == e_P.P_N[0] and str(copied) == str(again)
    assert classified(COUPLED, [-1.0, 0.2, 0.1], 2.0, (-1.0, 0.7)).impacts == ()
    assert classified(COUPLED, [-1.0, 0.2, 0.1], 2.0).impacts == ()


SADDLE, STABLE = Stability.SADDLE, Stability.STABLE


def test_a_slide_is_a_saddle_of_a_stiff_contact_where_p_is_below_zero():
    free, slide = classified(COUPLED, [0.5, 0.0, 0.0], 2.0, (1.0, 0.0)).solutions
    assert (free.stability.kind, slide.stability.kind) == (STABLE, SADDLE)
    (slide,) = classified(COUPLED, [-0.5, 0.0, 0.0], 2.0, (-1.0, 0.0)).solutions
    assert slide.stability.kind == STABLE
    np.testing.assert_allclose(slide.stability.rho, [1.0 + 2.0 * 0.8], rtol=1e-12)
    assert "unstable (saddle of a stiff contact)" in str(classified(COUPLED, [0.5, 0.0, 0.0], 2.0, (1.0, 0.0)))


def left_by_a_stiff_contact(G, c, mu, la):
    """Whether a compliant contact, begun beside a slide from rest, leaves it: by its force, or by its direction."""
    stiffness, speed, turned = 1e7, 1e-2, 1e-3
    damping = 1.4 * math.sqrt(stiffness / G[0, 0])
    d = -la[1:] / np.linalg.norm(la[1:])

    def rate(t, y):
        N = max(0.0, -stiffness * y[0] - damping * y[1])
        force = np.array([N, *(-mu * N * y[2:] / np.linalg.norm(y[2:]))])
        a = G @ force + c
        return [y[1], a[0], a[1], a[2]]

    def angle(y):
        return math.atan2(d[0] * y[3] - d[1] * y[2], d @ y[2:])

    def stays(t, y):
        """Positive while force and direction are beside those of the slide."""
        return min(0.1 - abs(-stiffness * y[0] / la[0] - 1.0), 20 * turned - abs(angle(y)))

    stays.terminal = True
    start = np.array([[math.cos(turned), -math.sin(turned)], [math.sin(turned), math.cos(turned)]]) @ d * speed
    end = 50.0 * speed / np.linalg.norm((G @ la + c)[1:])
    sol = solve_ivp(rate, (0, end), [-la[0] / stiffness, 0.0, *start], "LSODA", rtol=1e-8, atol=1e-12, events=stays)
    return len(sol.t_events[0]) > 0 or abs(angle(sol.y[:, -1])) > turned


def kind_of_slide(G, c, la):
    """By what nearby motions leave it."""
    if G[0, 0] + G[0, 1:] @ la[1:] / la[0] < 0:
        return "its force"
    return "its direction" if slope_of_turning(G, c, la) > 0 else "nothing"


def test_slides_from_rest_are_tagged_as_a_stiff_contact_leaves_them_or_not():
    """Two random contacts of each kind, against an independent integration of their springs."""
    rng, met = np.random.default_rng(12), {"its force": 0, "its direction": 0, "nothing": 0}
    for _ in range(2_000):
        A = rng.normal(size=(3, 3))
        G, c = A @ A.T + 0.05 * np.eye(3), rng.normal(size=3)
        mu = rng.uniform(0.8, 3.0) * G[0, 0] / np.linalg.norm(G[0, 1:])
        found = ns.contact_solutions(G, c, mu)
        kinds = [kind_of_slide(G, c, la) for mode, la in zip(found.modes, found.P, strict=True) if mode == "slide"]
        if all(met[kind] >= 2 for kind in kinds):
            continue
        for kind in kinds:
            met[kind] += 1
        solutions = classified(G, c, mu).solutions
        assert all(one.stability.kind == STABLE for one in solutions if one.modes != ("slide",))
        slides = [one for one in solutions if one.modes == ("slide",)]
        for kind, one in zip(kinds, slides, strict=True):
            assert one.stability.kind == (STABLE if kind == "nothing" else SADDLE)
            assert left_by_a_stiff_contact(G, c, mu, one.la[0]) == (kind != "nothing")
    assert min(met.values()) >= 2
