"""The impulse map in closed form against its differential equation, the laws of impact, and chatter."""

from __future__ import annotations

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import SpragSlip
from nonsmooth.jit import interpreted
from nonsmooth.mechanics.impact import impulse_map
from nonsmooth.mechanics.laws import LAWS_OF_ONE, ImpactLaw
from nonsmooth.paradox.chatter import bounce, chatter_ratio

closed_form = interpreted(impulse_map)
STEPS = 20_000  # of a reference; its error is a few steps of dP, relative to P


def random_contact(rng):
    """G_NN, G_NF, G_FF of a positive definite G, and mu."""
    B, A = rng.uniform(-2, 2), rng.uniform(0.1, 3)
    return B * B / A * rng.uniform(1.02, 3) + 0.01, B, A, rng.uniform(0, 3)


def marched(law, e, mu, G_NN, G_NF, G_FF, gamma_N, gamma_F, dP):
    """The impact by small steps dP of the normal impulse, friction by its sign, work by summation."""
    gamma_N0, P, P_F, work, compressing = gamma_N, 0.0, 0.0, 0.0, True
    P_c = least_work = 0.0
    for _ in range(50 * STEPS):
        hold = -G_NF / G_FF
        stuck = abs(gamma_F) <= 2 * dP * (abs(G_NF) + mu * G_FF)
        f = -math.copysign(mu, gamma_F)
        if stuck:
            f = max(-mu, min(mu, hold - 0.5 * gamma_F / (G_FF * dP)))  # as much as brings gamma_F to rest
        gamma_N_new = gamma_N + dP * (G_NN + f * G_NF)
        gamma_F += dP * (G_NF + f * G_FF)
        work += 0.5 * (gamma_N + gamma_N_new) * dP
        gamma_N = gamma_N_new
        P, P_F = P + dP, P_F + f * dP
        if compressing and gamma_N >= 0 and P > 5 * dP:
            compressing, P_c, least_work = False, P, work
        if compressing:
            continue
        if law == ImpactLaw.POISSON and P >= (1 + e) * P_c:
            break
        if law == ImpactLaw.NEWTON and gamma_N >= -e * gamma_N0:
            break
        if law == ImpactLaw.ENERGETIC and work - least_work >= -e * e * least_work:
            break
    return P, P_F, gamma_N, gamma_F


@pytest.mark.parametrize("law", LAWS_OF_ONE)
def test_closed_form_solves_the_equations_in_the_normal_impulse(law):
    rng = np.random.default_rng(law)
    met = set()
    for _ in range(12):
        C, B, A, mu = random_contact(rng)
        gamma_N, gamma_F, e = -rng.uniform(0.2, 1), rng.normal(), rng.uniform(0.2, 1)
        P_N, P_F, P_1, P_c = closed_form(law, e, mu, C, B, A, gamma_N, gamma_F)
        dP = P_N / STEPS
        P, P_T, after_N, after_F = marched(law, e, mu, C, B, A, gamma_N, gamma_F, dP)
        # first-order marching: bends are met late by dP, each bend and the ends of both phases once
        assert P == pytest.approx(P_N, abs=40 * dP * (1 + 1 / e))
        slope = C + abs(B) * (mu + abs(B) / A) + A * (mu + abs(B) / A)
        assert P_T == pytest.approx(P_F, abs=40 * dP * (1 + 1 / e) * (1 + mu))
        assert after_N == pytest.approx(gamma_N + C * P_N + B * P_F, abs=80 * dP * (1 + 1 / e) * slope)
        met.add((P_1 < P_c, P_1 < P_N, abs(B) <= mu * A))
    assert len(met) >= 3  # bends in compression, in expansion and not at all; sticking and sliding back


def test_impact_never_gains_energy_under_the_energetic_law():
    rng = np.random.default_rng(5)
    gained = 0
    for _ in range(2000):
        C, B, A, mu = random_contact(rng)
        gamma = np.array([-rng.uniform(0, 1), rng.normal()])
        G = np.array([[C, B], [B, A]])
        for law in LAWS_OF_ONE:
            P_N, P_F, _, _ = closed_form(law, 1.0, mu, C, B, A, *gamma)
            work = np.array([P_N, P_F]) @ (gamma + 0.5 * G @ [P_N, P_F])
            size = abs(P_N) + abs(P_F)
            if law == ImpactLaw.ENERGETIC:
                assert work <= 1e-12 * size * (1 + size)
            gained += work > 1e-9 * size * (1 + size)
    assert gained > 0  # as Newton's and Poisson's laws may


def test_impact_without_collision_has_the_published_closed_forms():
    rng = np.random.default_rng(6)
    count = 0
    while count < 100:
        C, B, A, mu = random_contact(rng)
        s = 1.0 if B > 0 else -1.0
        p = C - s * mu * B
        if p >= -1e-3:
            continue
        count += 1
        gamma_F, e = s * rng.uniform(0.1, 2), rng.uniform(0.1, 1)
        assert abs(B) <= mu * A  # sticking holds by itself in a paradoxical slide
        P_1, C_s = abs(gamma_F) / abs(B - s * mu * A), C - B * B / A
        expected = {
            ImpactLaw.NEWTON: 0.0,
            ImpactLaw.POISSON: e * P_1 * (C_s + abs(p)),
            ImpactLaw.ENERGETIC: e * P_1 * math.sqrt(abs(p) * (C_s + abs(p))),
        }
        for law, gamma_N in expected.items():
            P_N, P_F, bend, _ = closed_form(law, e, mu, C, B, A, 0.0, gamma_F)
            scale = C * P_N + abs(B * P_F)
            assert bend == pytest.approx(P_1, rel=1e-14)
            assert C * P_N + B * P_F == pytest.approx(gamma_N, abs=1e-14 * scale)
            assert abs(gamma_F + B * P_N + A * P_F) <= 1e-13 * (abs(B) * P_N + A * abs(P_F))


def test_seizure_of_the_sprag_slip_rod_is_its_only_impact():
    # SYSTEMS H: the rigid orbit jumps at th = 0.807078634 from th' = -2.258755703 to 2.769048317
    rod = SpragSlip()
    th, thdot = 0.807078634, -2.258755703
    (impact,) = ns.classify(rod, 0.0, *rod.state(th, thdot)).impacts
    assert impact.u[1] == pytest.approx(2.769048317, abs=1e-9)
    assert impact.P_N[0] == pytest.approx(34.772865558, abs=2e-8) and impact.P_F[0] == pytest.approx(
        38.865743710, abs=2e-8
    )
    rng = np.random.default_rng(9)
    count = 0
    for _ in range(200):
        th, thdot = rng.uniform(0.73, 1.5), rng.uniform(-5, 5)
        c = ns.classify(rod, 0.0, *rod.state(th, thdot))
        if int(rod.region(th, thdot)) in (2, 3):  # A2, A3
            count += 1
            exact = rod.seizure(th, thdot)
            (impact,) = c.impacts
            assert impact.u[1] == pytest.approx(exact.thdot, rel=1e-12)
            assert (impact.P_N[0], impact.P_F[0]) == pytest.approx((exact.P_N, exact.P_F), rel=1e-9, abs=1e-9)
            assert impact.u[1] == pytest.approx(rod.vb / (rod.l * math.sin(th)), rel=1e-12)
    assert count > 30


def test_velocity_step_from_an_indeterminate_state_has_three_solutions():
    # SYSTEMS D: mu = 2, th = 60 deg, th' = 6, u = -1, h = 1e-3, frozen configuration
    from models import PainleveRod
    from nonsmooth.contact.planar.problem import problem_of
    from nonsmooth.contact.planar.single import STICK, admissible, candidate_impulses
    from nonsmooth.mechanics.system import UNILATERAL

    rod, h = PainleveRod(mu=2.0), 1e-3
    (C, B), (_, A) = rod.delassus(math.pi / 3)
    for thdot, expected in [(6.0, [0.0, 0.006813606, 0.317141694]), (0.0, [0.33273015])]:
        c_N = h * rod.b(math.pi / 3, thdot)
        c_F = -1.0 + h * 0.5 * rod.l * thdot**2 * math.cos(math.pi / 3)
        problem = problem_of(np.array([[UNILATERAL, 1]]), np.array([[C, B], [B, A]]), np.array([c_N, c_F]), 2.0, 2.0)
        problem.laws[:], problem.offset[1] = rod.system().laws, -1.0
        bits, _ = interpreted(admissible)(0, problem, 0.0)
        found = [interpreted(candidate_impulses)(k, 0, problem) for k in range(4) if bits >> k & 1]
        assert sorted(P_N for P_N, _ in found) == pytest.approx(expected, abs=6e-9)
        assert bits >> STICK & 1
    assert found[0][1] == pytest.approx(0.44068589, abs=6e-9)


def test_bounces_without_friction_shrink_by_the_coefficient_of_restitution():
    G = np.array([[1.3, 0.4], [0.4, 0.9]])
    for law in LAWS_OF_ONE:
        assert chatter_ratio(0.7, 0.0, G, 0.5, -2.0, law) == pytest.approx(0.7, rel=1e-12)
    assert chatter_ratio(0.7, 1.5, G, 3.0, -2.0, ImpactLaw.NEWTON) == pytest.approx(0.7, rel=1e-12)
    assert math.isnan(chatter_ratio(0.7, 1.5, G, 3.0, 2.0)) and math.isnan(chatter_ratio(0.0, 1.5, G, 3.0, -2.0))


def test_reverse_chatter_grows_out_of_a_sticking_contact_as_its_ratio_says(references):
    make, randomise, _ = references
    template = make(1, "u")
    rng = np.random.default_rng(2)
    flagged = 0
    for _ in range(150):
        system, _ = randomise(template, rng, np.zeros(1))
        c = ns.classify(system, 0.0, np.ones(6), np.zeros(6), restitution=0.8)
        has_flag = bool(c.flags & ns.ParadoxFlag.REVERSE_CHATTER)
        sticks = any(s.modes == ("stick",) for s in c.solutions)
        assert has_flag == bool(c.chatter_ratio[0] > 1 and sticks)
        if not has_flag:
            continue
        flagged += 1
        # G_NN = (p_+ + p_-)/2, G_NF = (k_+ + k_-)/2: follow bounces from the self-similar one, a tenth of it first
        G_NN, G_NF = c.p[0].mean(), c.k[0].mean()
        G_FF = (G_NF - c.k[0, 0]) / c.mu[0]
        G = np.array([[G_NN, G_NF], [G_NF, G_FF]])
        ratio = c.chatter_ratio[0]
        x = self_similar(G, c.mu[0], c.a[0], c.b[0], ratio)
        gamma = 0.1 * np.array([1.0, x])
        for _ in range(3):
            grown = (
                np.array(bounce(gamma[1] / gamma[0], ImpactLaw.ENERGETIC, 0.8, c.mu[0], G, c.a[0], c.b[0])) * gamma[0]
            )
            assert grown[0] == pytest.approx(ratio * gamma[0], rel=1e-5)
            gamma = grown
    assert flagged > 3


def self_similar(G, mu, a, b, ratio):
    """gamma_F+/gamma_N+ that repeats: the scan's sign changes with the wanted growth, by bisection."""
    angles = np.linspace(-1.57, 1.57, 4001)

    def turn(angle):
        N, F = bounce(math.tan(angle), ImpactLaw.ENERGETIC, 0.8, mu, G, a, b)
        return math.atan2(F, N) - angle

    values = [turn(angle) for angle in angles]
    best = None
    for j in range(len(angles) - 1):
        if values[j] * values[j + 1] > 0:
            continue
        low, high, f_low = angles[j], angles[j + 1], values[j]
        for _ in range(60):
            middle = 0.5 * (low + high)
            if f_low * turn(middle) <= 0:
                high = middle
            else:
                low, f_low = middle, turn(middle)
        x = math.tan(0.5 * (low + high))
        grown = bounce(x, ImpactLaw.ENERGETIC, 0.8, mu, G, a, b)[0]
        if best is None or abs(grown - ratio) < abs(best[1] - ratio):
            best = (x, grown)
    return best[0]
