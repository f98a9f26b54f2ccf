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


@pytest.mark.upkeep
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


@pytest.mark.upkeep
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


@pytest.mark.upkeep
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


def mass_of_two(t, q, p, M):
    """Of coordinates that are those of two contacts: places along the ground draw the couplings."""
    for i in range(6):
        for j in range(i + 1):
            M[i, j] = 0.55 * math.sin(7.0 * (i + 1) * q[1] + 5.0 * (j + 1) * q[2] + 3.0 * (i + 2 * j) * q[4])
            M[j, i] = M[i, j]
        M[i, i] = 1.6 + 0.4 * math.sin(11.0 * (i + 1) * q[5])


def force_of_two(t, q, u, p, h):
    for i in range(6):
        h[i] = math.cos(9.0 * (i + 1) * q[4] + 13.0 * i * q[5])
    h[0] -= 1.0
    h[3] -= 1.0


def gap_of_two(t, q, p, g_N):
    g_N[0], g_N[1] = q[0], q[3]


def normal_of_two(t, q, p, W_N):
    W_N[0, 0], W_N[1, 3] = 1.0, 1.0


def tangent_of_two(t, q, p, W_F):
    for axis in range(2):
        W_F[0, axis, 1 + axis], W_F[1, axis, 4 + axis] = 1.0, 1.0


TWO = ns.System(
    n_q=6, mass=mass_of_two, force=force_of_two, gap=gap_of_two, normal=normal_of_two, tangent=tangent_of_two,
    contacts=[ns.Contact(mu=1.6, directions=2), ns.Contact(mu=1.5, directions=2)],
)  # fmt: skip


class Coupled:
    """Two coupled contacts, of which the first slides and the second rests."""

    mu = (1.6, 1.5)

    def __init__(self, rng):
        self.q = np.insert(rng.uniform(-3, 3, 4), [0, 2], 0.0)
        self.slide = rng.standard_normal(2)
        self.u = np.r_[0.0, self.slide, 0.0, 0.0, 0.0]
        M, h = np.zeros((6, 6)), np.zeros(6)
        mass_of_two(0.0, self.q, None, M)
        force_of_two(0.0, self.q, self.u, None, h)
        self.is_mass = np.linalg.eigvalsh(M)[0] > 0.1
        self.G, self.c = np.linalg.inv(M), np.linalg.solve(M, h)

    def answers(self, directions=20_000):
        """Their number, by a search of all directions of the second contact: slides where gamma_T turns through d."""
        G, c = self.G, self.c
        d = self.slide / np.linalg.norm(self.slide)
        slider = np.r_[1.0, -self.mu[0] * d, 0.0, 0.0, 0.0]
        angles = np.linspace(0.0, 2.0 * np.pi, directions, endpoint=False)
        rays = np.column_stack(
            (np.zeros((directions, 3)), np.ones(directions), -self.mu[1] * np.cos(angles), -self.mu[1] * np.sin(angles))
        )
        number = 0
        for is_loaded in (False, True):
            of = slider if is_loaded else np.zeros(6)
            number += self.is_stuck(G, c, of, is_loaded) + self.is_free(G, c, of, is_loaded)
            number += self.slides(G, c, of, is_loaded, rays, angles)
        return number

    def is_free(self, G, c, of, is_loaded):
        N = -c[0] / (G[0] @ of) if is_loaded else 0.0
        gamma = c + G @ (N * of)
        return int(gamma[3] >= 0 and (N > 0 if is_loaded else gamma[0] >= 0))

    def is_stuck(self, G, c, of, is_loaded):
        rows = [0, 3, 4, 5] if is_loaded else [3, 4, 5]
        columns = np.column_stack(([of] if is_loaded else []) + list(np.eye(6)[3:]))
        x = np.linalg.solve((G @ columns)[rows], -c[rows])
        P = columns @ x
        presses = P[3] > 0 and np.hypot(*P[4:]) <= self.mu[1] * P[3]
        return int(presses and (x[0] > 0 if is_loaded else (c + G @ P)[0] >= 0))

    def slides(self, G, c, of, is_loaded, rays, angles):
        a, b = G @ of, rays @ G
        if is_loaded:
            det = a[0] * b[:, 3] - b[:, 0] * a[3]
            N = (-c[0] * b[:, 3] + b[:, 0] * c[3]) / det
            P = (-a[0] * c[3] + a[3] * c[0]) / det
        else:
            N, P = np.zeros(len(b)), -c[3] / b[:, 3]
        gamma = c + np.outer(N, a) + P[:, None] * b
        along = gamma[:, 4] * np.cos(angles) + gamma[:, 5] * np.sin(angles)
        across = gamma[:, 5] * np.cos(angles) - gamma[:, 4] * np.sin(angles)
        fits = (P > 0) & (along > 0) & ((N > 0) if is_loaded else (gamma[:, 0] >= 0))
        return int((fits & np.roll(fits, -1) & (across * np.roll(across, -1) < 0)).sum())


@pytest.mark.upkeep
def test_one_that_rests_among_sliding_ones_has_the_solutions_of_all_directions():
    rng, several, none, complete = np.random.default_rng(5), 0, 0, 0
    models = [model for model in (Coupled(rng) for _ in range(400)) if model.is_mass]
    assert len(models) > 60
    for model in models:
        found = ns.classify(TWO, 0.0, model.q, model.u)
        assert found.n_solutions == model.answers()
        several, none = several + (found.n_solutions > 1), none + (found.n_solutions == 0)
        complete += found.is_complete
        for solution in found.solutions:
            la = solution.la.ravel()
            gamma = model.c + model.G @ la
            assert abs(gamma[[0, 3]] * la[[0, 3]]).max() < 1e-9 and min(*gamma[[0, 3]], *la[[0, 3]]) > -1e-9
            assert abs(solution.du - gamma).max() < 1e-9
            assert np.hypot(*la[4:]) <= model.mu[1] * la[3] + 1e-9
    assert several >= 2 and none >= 1 and complete > 0.9 * len(models)


def test_two_that_rest_together_are_not_enumerated():
    model = Coupled(np.random.default_rng(5))
    found = ns.classify(TWO, 0.0, model.q, np.zeros(6))
    assert found.kind.name == "NOT_ENUMERATED" and not found.is_complete
