"""Steady sliding on a surface in space: the direction of sliding turns with the motion, and is damped by friction."""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BilliardBall, SpatialPainleveRod

SLOPE = ns.Polynomial(0.4, 0.45, 0.6)  # mu = 0.4 - 0.45 v + 0.6 v^3


class Sprung(NamedTuple):
    """A mass on two springs, on a belt that runs obliquely to them."""

    m: float = 1.3  # [kg]
    k_x: float = 10.0  # [N/m]
    k_y: float = 25.0  # [N/m]
    c: float = 0.1  # [N s/m]
    g: float = 9.81  # [m/s^2]
    vx: float = 0.2  # of the belt [m/s]
    vy: float = 0.15  # [m/s]


def mass(t, q, p, M):
    M[0, 0] = M[1, 1] = M[2, 2] = p.m


def force(t, q, u, p, h):
    h[0], h[1], h[2] = -p.k_x * q[0] - p.c * u[0], -p.k_y * q[1] - p.c * u[1], -p.m * p.g


def gap(t, q, p, g_N):
    g_N[0] = q[2]


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = W_F[0, 1, 1] = 1.0


def surface_velocity(t, q, p, w_F):
    w_F[0, 0], w_F[0, 1] = -p.vx, -p.vy


def sprung(mu=SLOPE, **changes):
    contacts = [ns.Contact(mu=mu, directions=2)]
    return ns.System(
        n_q=3, mass=mass, force=force, gap=gap, tangent=tangent, surface_velocity=surface_velocity, contacts=contacts,
        parameters=Sprung(**changes),
    )  # fmt: skip


def test_a_sprung_mass_is_carried_along_the_belt():
    p, v = Sprung(), math.hypot(0.2, 0.15)
    pull = (0.4 - 0.45 * v + 0.6 * v**3) * p.m * p.g
    at = ns.equilibrium(sprung(), guess=[0.1, 0.1, 0.0])
    np.testing.assert_allclose(at.q, [pull * 0.2 / v / p.k_x, pull * 0.15 / v / p.k_y, 0.0], rtol=1e-12)
    assert not at.is_virtual and at.residual < 1e-14
    assert (at.gamma_F[0], at.la_N[0], at.la_F[0]) == pytest.approx((v, p.m * p.g, -pull), rel=1e-12)


@pytest.mark.parametrize("speeds", [(0.2, 0.15), (0.0, 0.3), (0.6, -0.4)])
def test_friction_damps_across_the_slide_by_its_force_over_the_speed_and_along_it_by_its_slope(speeds):
    """C = c + N mu' d d^T + (mu N/v) (1 - d d^T), d the direction of sliding."""
    p, d, v = Sprung(vx=speeds[0], vy=speeds[1]), -np.array(speeds), math.hypot(*speeds)
    N, along = p.m * p.g, np.outer(d, d) / v**2
    C = p.c * np.eye(2) + N * (1.8 * v**2 - 0.45) * along
    C += (0.4 - 0.45 * v + 0.6 * v**3) * N / v * (np.eye(2) - along)
    motion = ns.linearise(sprung(vx=speeds[0], vy=speeds[1]))
    np.testing.assert_allclose(motion.C, C, atol=1e-12 * N / v)
    np.testing.assert_allclose(motion.M, p.m * np.eye(2), rtol=1e-14)
    np.testing.assert_allclose(motion.K, np.diag([p.k_x, p.k_y]), atol=1e-12 * N)
    assert motion.kept == (0, 1) and motion.inertia[0, 0] == pytest.approx(1 / p.m)


def test_steps_of_time_grow_and_die_out_as_the_eigenvalues_say():
    """By half a period and more: of an oscillation along x, that is damped as across a slide along y."""
    p = Sprung(vx=0.0, vy=0.3)
    system = sprung(vx=p.vx, vy=p.vy)
    motion = ns.linearise(system)
    assert motion.verdict == ns.Verdict.NEGATIVE_DAMPING
    q_0 = motion.equilibrium.q
    sol = ns.simulate(
        system, (0, 1.0), q_0 + [1e-6, 1e-6, 0.0], np.zeros(3), integrator=ns.Adaptive(rtol=1e-11, atol=1e-13)
    )
    A = motion.companion
    from scipy.linalg import expm

    expected = expm(A * sol.t[-1]) @ [1e-6, 1e-6, 0.0, 0.0]
    np.testing.assert_allclose(sol.q[-1, :2] - q_0[:2], expected[:2], atol=2e-9)


def test_sliding_loses_its_stability_where_the_slope_of_friction_along_it_takes_the_damping():
    """c + N mu'(v) = 0 at v = sqrt((0.45 - c/N)/1.8), whatever the springs: across the slide friction damps."""
    p = Sprung()
    edge = ns.flutter_boundary(sprung(vx=0.0), "vy", (0.6, 0.3))
    assert edge.value == pytest.approx(math.sqrt((0.45 - p.c / (p.m * p.g)) / 1.8), rel=1e-12)
    assert edge.frequency == pytest.approx(math.sqrt(p.k_y / p.m), rel=1e-9)


def test_a_held_rod_has_the_inertia_of_its_paradox():
    """W_N M^-1 R^T is p of the closed form, for the direction in which the ground is drawn from under the tip."""
    rod = SpatialPainleveRod(mu=2.0)
    plain, (q_0, _) = rod.system(), rod.state(th=1.0, slip=0.0)
    for phi in (0.0, 0.4, 1.2):

        def held(t, q, u, p, h):
            for j in range(5):
                h[j] = -1e5 * (q[j] - q_0[j])
            h[2] -= p.m * p.g

        def drawn(t, q, p, w_F, phi=phi):
            w_F[0, 0], w_F[0, 1] = -math.cos(phi), -math.sin(phi)

        motion = ns.linearise(dataclasses.replace(plain, force=held, surface_velocity=drawn))
        th, psi = motion.equilibrium.q[3:]
        assert motion.inertia[0, 0] == pytest.approx(rod.p(th, phi - psi), abs=1e-12)
        assert (motion.verdict == ns.Verdict.NEGATIVE_INERTIA) == (rod.p(th, phi - psi) < 0)


def test_what_has_no_direction_is_refused():
    with pytest.raises(ns.InvalidInput, match="no direction to go in"):
        ns.equilibrium(sprung(vx=0.0, vy=0.0))
    with pytest.raises(ns.InvalidInput, match="sliding= gives signs"):
        ns.equilibrium(sprung(), sliding=[1])
    with pytest.raises(ns.InvalidInput, match="kinematics"):
        ns.linearise(BilliardBall())
    with pytest.raises(
        ns.InvalidInput, match=r"takes no system with friction in two directions; MoreauJean\(dt=\.\.\.\)"
    ):
        ns.averaged_amplitude(sprung())
