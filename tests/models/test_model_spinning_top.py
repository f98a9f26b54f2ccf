"""The spinning top: Euler's equations, Jellett's integral, steady precession, sleep, and the top that turns over."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import SpinningTop
from nonsmooth.mechanics.system import FORCE, KINEMATICS, MASS, NORMAL, TANGENT

TOPS = [SpinningTop(), SpinningTop(r=0.0), SpinningTop(r=0.012, h=0.02), SpinningTop.tippe_top()]


def run(top, t_end, dt=1e-4, every=20, **state):
    return ns.simulate(top, (0, t_end), *top.state(**state), integrator=ns.MoreauJean(dt=dt), every=every)


def tilt(top, sol):
    a = top.axis(sol.q)
    return np.arctan2(np.hypot(a[:, 0], a[:, 1]), a[:, 2])


@pytest.mark.parametrize("top", TOPS)
def test_a_force_at_the_tip_changes_momenta_as_newton_and_euler_say(top):
    system, rng = top.system(), np.random.default_rng(5)
    for _ in range(50):
        q, u, F = rng.normal(size=7), rng.normal(size=6), rng.normal(size=3)
        q[3:] /= np.linalg.norm(q[3:])
        W = np.vstack([system.evaluate(NORMAL, 0.0, q, u), system.evaluate(TANGENT, 0.0, q, u)[0]])
        du = np.linalg.solve(system.evaluate(MASS, 0.0, q, u), system.evaluate(FORCE, 0.0, q, u) + W.T @ F[[2, 0, 1]])
        np.testing.assert_allclose(du[:3], F / top.m - [0, 0, top.g], rtol=1e-12)

        def momentum(t, q=q, u=u, du=du):
            there = q + t * (system.evaluate(KINEMATICS, 0.0, q, u) @ u)
            return system.evaluate(MASS, 0.0, there, u)[3:, 3:] @ (u[3:] + t * du[3:])

        rho = -top.h * top.axis(q) - [0, 0, top.r]
        np.testing.assert_allclose((momentum(1e-5) - momentum(-1e-5)) / 2e-5, np.cross(rho, F), rtol=1e-6, atol=1e-9)


def test_the_state_is_the_one_that_was_asked_for():
    for top in TOPS:
        q, u = top.state(th=0.4, thdot=0.7, precession=1.3, spin=50.0, slip_x=0.2, slip_y=-0.1)
        system, a = top.system(), top.axis(q)
        np.testing.assert_allclose(a, [math.sin(0.4), 0.0, math.cos(0.4)], atol=1e-15)
        assert u[3:] @ a == pytest.approx(50.0)
        turned = np.cross(u[3:], a)  # of the axis: by thdot along its tilt, and about the vertical
        np.testing.assert_allclose(turned, [0.7 * a[2], 1.3 * a[0], -0.7 * a[0]], atol=1e-12)
        np.testing.assert_allclose(system.evaluate(TANGENT, 0.0, q, u)[0] @ u, [0.2, -0.1], atol=1e-14)


@pytest.mark.parametrize(("top", "slip"), [
    (SpinningTop(mu=0.2), 0.0), (SpinningTop(r=0.0, mu=0.3), 0.5), (SpinningTop.tippe_top(e=0.4), 1.0),
])  # fmt: skip
def test_no_force_at_the_tip_changes_jelletts_integral(top, slip):
    """Whether it slides or rolls; steps of 1/2 leave 1/4 of the error."""
    errors = []
    for dt in (2e-4, 1e-4):
        sol = run(top, 0.4, dt=dt, th=0.5, spin=150.0, slip_x=slip, slip_y=0.3 * slip)
        J = top.jellett(sol.q, sol.u)
        errors.append(np.abs(J / J[0] - 1).max())
    assert errors[1] < 1e-4 and errors[0] / errors[1] > 3


@pytest.mark.parametrize("top", TOPS)
def test_a_top_that_rolls_precesses_steadily_at_either_rate(top):
    """Its tilt stays, its axis turns as fast as asked, its tip sticks, and friction is what the circle needs."""
    th, spin = 0.5, 150.0
    for rate in top.precessions(th, spin):
        friction = top.friction_of_precession(th, spin, rate)
        held = dataclass_with(top, mu=1.5 * friction)
        t_end = min(2.0 / abs(rate), 0.5)
        sol = run(held, t_end, dt=t_end / 5000, every=1, th=th, spin=spin, precession=rate)
        assert np.abs(tilt(held, sol) - th).max() < 1e-4
        a = held.axis(sol.q)
        azimuth = np.unwrap(np.arctan2(a[:, 1], a[:, 0]))
        assert azimuth[-1] == pytest.approx(rate * sol.t[-1], rel=1e-3)
        assert (sol.mode[1:] == ns.ContactMode.STICK).all()
        P_F, P_N = np.linalg.norm(sol.P_F[5:, 0], axis=-1), sol.P_N[5:, 0]
        np.testing.assert_allclose(P_F / P_N, friction, rtol=1e-2, atol=1e-9)


def dataclass_with(top, **changes):
    return type(top)(**{**top.system().parameter_values, **changes})


@pytest.mark.parametrize("top", TOPS[:3])
def test_a_top_sleeps_above_its_sleeping_spin_and_falls_below_it(top):
    """A slight tilt swings as the sum of two turns whose rates are those of precession, complex below."""
    critical = top.sleeping_spin()
    inertia, turning = top.A + top.m * (top.h + top.r) ** 2, top.C + top.m * top.r * (top.h + top.r)
    for share, largest in ((0.9, math.inf), (1.1, 3e-5)):
        sol = run(top, 0.4, th=1e-5, spin=share * critical)
        one, two = np.roots([inertia, -turning * share * critical, top.m * top.g * top.h]).astype(complex)
        swing = (two * np.exp(1j * one * sol.t) - one * np.exp(1j * two * sol.t)) / (two - one)
        np.testing.assert_allclose(tilt(top, sol), 1e-5 * np.abs(swing), rtol=5e-3, atol=1e-8)
        assert tilt(top, sol).max() < largest and (share > 1 or tilt(top, sol)[-1] > 5e-5)
    assert top.precessions(1e-9, 0.999 * critical) == () and len(top.precessions(1e-9, 1.001 * critical)) == 2


def spun_upright(top, th, w):
    """About the vertical through a centre of mass at rest."""
    return run(top, 3.0, th=th, spin=w * math.cos(th), precession=w, slip_y=-top.h * w * math.sin(th))


def test_a_tippe_top_turns_over_and_spins_on_as_jelletts_integral_says():
    top = SpinningTop.tippe_top()
    assert top.turns_over()
    sol = spun_upright(top, 0.1, 200.0)
    assert tilt(top, sol)[-1] > 2.95
    assert sol.u[-1, 5] == pytest.approx(top.spin_turned_over(200.0 * math.cos(0.1)), rel=2e-2)
    flat = SpinningTop.tippe_top(A=0.25 * 0.02**3)  # A/C < 1 - 0.3
    assert not flat.turns_over()
    sol = spun_upright(flat, 0.1, 200.0)
    assert flat.axis(sol.q)[-1, 2] > 0.99
    with pytest.raises(ns.InvalidInput, match="sphere"):
        SpinningTop().spin_turned_over(1.0)


@pytest.mark.parametrize("top", TOPS)
def test_a_paradox_needs_more_than_the_critical_friction(top):
    for th in (0.2, 0.9, 1.4):
        q, _ = top.state(th=th)
        assert top.critical_friction(th) == pytest.approx(ns.critical_friction(top, q), rel=1e-12)
    assert top.critical_friction(0.0) == math.inf
