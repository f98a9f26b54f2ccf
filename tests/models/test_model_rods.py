"""Painlevé's rods: printed coefficients, numbers of solutions, impacts without collision."""

from __future__ import annotations

import numpy as np
import pytest

from models import BilateralRod, PainleveRod

# mu, th [deg], th' [rad/s], slip, p, b, solutions la_N: printed digits (m = 1, l = 1, I = 1/12, g = 9.81)
SAMPLE_STATES = [
    (0.5, 60, 0, -1, 1.10048095, -9.81, (8.914284273,)),
    (0.5, 60, 6, -1, 1.10048095, 5.77845727, (0.0,)),
    (2.0, 60, 0, -1, -0.84807621, -9.81, ()),
    (2.0, 60, 6, -1, -0.84807621, 5.77845727, (0.0, 6.813606125)),
    (2.0, 60, 0, +1, 4.34807621, -9.81, (2.256170206,)),
    (1.5, 65, 3, -1, -0.18778141, -5.73161496, ()),
    (1.5, 65, 5, -1, -0.18778141, 1.51884734, (0.0, 8.088379598)),
]
BILATERAL_STATES = [
    (-1, 6, (-1.328968718, 6.813606125)),
    (-1, 0, ()),
    (+1, 0, (-11.567356646, 2.256170206)),
    (+1, 6, ()),
]


@pytest.mark.parametrize("mu, degrees, thdot, slip, p, b, solutions", SAMPLE_STATES)
def test_coefficients_and_forces_of_the_sample_states(mu, degrees, thdot, slip, p, b, solutions):
    rod, th = PainleveRod(mu=mu), np.radians(degrees)
    assert rod.coefficients(th, thdot, slip) == pytest.approx((p, b), abs=6e-9)
    assert rod.normal_forces(th, thdot, slip) == pytest.approx(solutions, abs=6e-10)


@pytest.mark.parametrize("mu, degrees, thdot, slip, p, b, solutions", SAMPLE_STATES)
def test_contact_rows_give_the_coefficients_of_the_sample_states(
    contact_problem, mu, degrees, thdot, slip, p, b, solutions
):
    rod, th = PainleveRod(mu=mu), np.radians(degrees)
    W, G, free = contact_problem(rod, *rod.state(th, thdot, slip))
    assert G[0, 0] - mu * slip * G[0, 1] == pytest.approx(p, abs=6e-9)
    assert free[0] == pytest.approx(b, abs=6e-9)
    np.testing.assert_allclose(G, rod.delassus(th), rtol=1e-13)
    np.testing.assert_allclose(G @ rod.stick_forces(th, thdot) + free, 0.0, atol=1e-12)


@pytest.mark.parametrize("slip, thdot, solutions", BILATERAL_STATES)
def test_bilateral_rod_has_the_printed_solutions(contact_problem, bilateral_solutions, slip, thdot, solutions):
    rod, th = BilateralRod(), np.radians(60)
    assert rod.normal_forces(th, thdot, slip) == pytest.approx(solutions, abs=6e-10)
    _, G, b = contact_problem(rod, *rod.state(th, thdot, slip))
    assert [la_N for la_N, _ in bilateral_solutions(G, b, rod.mu, slip)] == pytest.approx(solutions, abs=6e-10)


def test_bilateral_angular_acceleration_keeps_the_tip_on_the_ground():
    rod, th, thdot = BilateralRod(mu=1.1), 0.9, 2.0
    for slip in (-1.0, 1.0):
        for la_N in rod.normal_forces(th, thdot, slip):
            thddot = rod.angular_acceleration(th, thdot, slip, la_N)
            yddot = 0.5 * rod.l * (thddot * np.cos(th) - thdot**2 * np.sin(th))
            assert rod.m * yddot == pytest.approx(la_N - rod.m * rod.g, abs=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_bilateral_number_of_solutions_follows_the_signs_of_p_and_b(seed):
    rng = np.random.default_rng(seed)
    for _ in range(100):
        rod, th, thdot = BilateralRod(mu=rng.uniform(0, 3)), rng.uniform(0.05, 1.5), rng.uniform(-8, 8)
        slip = rng.choice([-1.0, 1.0])
        expected = 1 if rod.p(th, -rod.mu) > 0 else 2 if slip * rod.b(th, thdot) < 0 else 0
        assert len(rod.normal_forces(th, thdot, slip)) == expected


def test_least_critical_friction_of_the_slender_rod_is_four_thirds():
    rod = PainleveRod.slender(m=2.0, l=3.0, mu=0.1)
    mu_P, th_P = rod.least_critical_friction()
    assert (mu_P, th_P) == pytest.approx((4 / 3, np.arctan(2)), rel=1e-15)
    assert rod.critical_friction(th_P) == pytest.approx(mu_P, rel=1e-14)
    assert rod.critical_friction(th_P + 0.01) > mu_P < rod.critical_friction(th_P - 0.01)


@pytest.mark.parametrize("mu, degrees", [(1.5, (50.641598, 73.048469)), (2.0, (37.377368, 79.187683))])
def test_paradoxical_angles_are_the_printed_ones(mu, degrees):
    rod = PainleveRod(mu=mu)
    angles = rod.paradoxical_angles()
    assert np.degrees(angles) == pytest.approx(degrees, abs=6e-7)
    for th in angles:
        assert rod.critical_friction(th) == pytest.approx(mu, rel=1e-13)


def test_there_are_no_paradoxical_angles_below_the_critical_friction():
    assert PainleveRod(mu=1.3).paradoxical_angles() is None
    assert PainleveRod(mu=4.0).critical_friction(np.pi / 2) > 1e15


def test_plastic_impact_without_collision_stops_the_tip():
    rod = PainleveRod()
    impact = rod.impact_without_collision(th=np.pi / 3, thdot=0.0, slip=-1.0)
    assert (impact.P_1, impact.P_c) == pytest.approx((0.19227213, 0.32475953), abs=6e-9)
    assert (impact.P_N, impact.P_F, impact.u[2]) == pytest.approx((0.32475953, 0.4375, 1.29903811), abs=6e-9)
    q0, _ = rod.state(th=np.pi / 3)
    assert rod_tip_velocity(rod, q0, impact.u) == pytest.approx((0.0, 0.0), abs=1e-15)


def rod_tip_velocity(rod, q, u):
    s = 0.5 * rod.l
    return u[0] + s * np.sin(q[2]) * u[2], u[1] - s * np.cos(q[2]) * u[2]


def test_energetic_impact_without_collision_at_full_restitution():
    rod = PainleveRod(e=1.0)
    impact = rod.impact_without_collision(law="energetic")
    assert (impact.gamma_N, impact.u[2]) == pytest.approx((0.255296505, 1.107565727), abs=6e-10)


def test_energetic_restitution_returns_e_squared_of_the_work_of_compression():
    rod, e = PainleveRod(mu=1.8), 0.6
    th, slip = 1.1, -0.7
    impact = rod.impact_without_collision(th=th, slip=slip, e=e, law="energetic")
    (G_NN, G_NF), (_, G_FF) = rod.delassus(th)
    w_1 = (G_NN + rod.mu * G_NF) * impact.P_1
    compression = 0.5 * w_1 * impact.P_c  # gamma_N falls to w_1 and rises to 0, both linearly in the impulse
    expansion = 0.5 * impact.gamma_N * (impact.P_N - impact.P_c)
    assert expansion == pytest.approx(-(e**2) * compression, rel=1e-13)
    assert G_NN - G_NF**2 / G_FF == pytest.approx(impact.gamma_N / (impact.P_N - impact.P_c), rel=1e-13)


@pytest.mark.parametrize("law, factor", [("newton", 1.0), ("poisson", 1.5)])
def test_poisson_multiplies_the_impulse_of_compression_and_newton_does_not(law, factor):
    impact = PainleveRod().impact_without_collision(e=0.5, law=law)
    assert impact.P_N == pytest.approx(factor * impact.P_c, rel=1e-14)


def test_impulses_of_an_impact_obey_the_friction_cone_and_the_balances():
    rod = PainleveRod(mu=2.2, m=1.3)
    th, thdot, slip = 1.0, -1.5, -0.4
    q0, u0 = rod.state(th=th, thdot=thdot, slip=slip)
    impact = rod.impact_without_collision(th, thdot, slip, e=0.8, law="poisson")
    assert abs(impact.P_F) <= rod.mu * impact.P_N
    W = np.array([[0, 1, -0.5 * np.cos(th)], [1, 0, 0.5 * np.sin(th)]])
    M = np.diag([rod.m, rod.m, rod.I])
    np.testing.assert_allclose(M @ (impact.u - u0), W.T @ [impact.P_N, impact.P_F], atol=1e-14)
    np.testing.assert_allclose(W @ impact.u, [impact.gamma_N, 0.0], atol=1e-14)


def test_mirrored_rod_has_the_mirrored_impact():
    rod = PainleveRod()
    impact = rod.impact_without_collision(th=np.pi / 3, slip=-1.0)
    mirror = rod.impact_without_collision(th=np.pi - np.pi / 3, slip=1.0)
    np.testing.assert_allclose(mirror.u, impact.u * [-1, 1, -1], atol=1e-14)


@pytest.mark.parametrize(
    "zeta, gamma_N, thdot",
    [
        (0.0, 0.255296505, 1.107565727),
        (0.1, 0.200882468, 1.148376255),
        (0.5, 0.091258409, 1.230594299),
        (1.0, 0.043548397, 1.266376808),
    ],
)
def test_limit_of_the_compliant_contact_is_the_printed_one(zeta, gamma_N, thdot):
    impact = PainleveRod().compliant_limit(zeta=zeta)
    assert (impact.gamma_N, impact.u[2]) == pytest.approx((gamma_N, thdot), abs=6e-10)


def test_limit_of_the_compliant_contact_is_continuous_at_critical_damping():
    rod = PainleveRod()
    (G_NN, G_NF), (_, G_FF) = rod.delassus(np.pi / 3)
    critical = 1 / np.sqrt(rod.m * (G_NN - G_NF**2 / G_FF))
    below, at, above = (rod.compliant_limit(zeta=critical * f).gamma_N for f in (1 - 1e-6, 1.0, 1 + 1e-6))
    assert below == pytest.approx(at, rel=1e-5) == pytest.approx(above, rel=1e-5)
