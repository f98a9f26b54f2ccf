"""The robot finger: Lagrange's equations, forces at rest, and the paradox of a tip that slides."""

import math

import numpy as np
import pytest

sp = pytest.importorskip("sympy", reason="energies need SymPy, the extra [symbolic]")

import nonsmooth as ns  # noqa: E402
from models import RobotFinger  # noqa: E402
from nonsmooth.mechanics.system import FORCE, GAP, MASS, NORMAL, POTENTIAL, ROW_RATES, TANGENT  # noqa: E402

FINGER = RobotFinger(m1=0.7, m2=0.4, l1=0.6, l2=0.5, H=0.62, tau_psi=0.3, tau_1=-0.4, tau_2=0.2)
THS = (-2.0, -1.2, -0.8)


def test_the_equations_are_lagranges():
    """Of links that are three point masses each, by Simpson's rule."""
    l = ns.lagrangian("finger once more")
    psi, th1, th2 = l.coordinates("psi th1 th2")
    m1, m2, l1, l2, H, *torques, mu, g, e = l.parameters(**FINGER.system().parameter_values)
    elbow = sp.Matrix([l1 * sp.cos(th1) * sp.cos(psi), l1 * sp.cos(th1) * sp.sin(psi), H + l1 * sp.sin(th1)])
    joint = sp.Matrix([0, 0, H])
    tip = elbow + l2 * sp.Matrix([sp.cos(th2) * sp.cos(psi), sp.cos(th2) * sp.sin(psi), sp.sin(th2)])
    for m, one, other in ((m1, joint, elbow), (m2, elbow, tip)):
        for share, at in ((sp.Rational(1, 6), one), (sp.Rational(2, 3), (one + other) / 2), (sp.Rational(1, 6), other)):
            l.point_mass(share * m, at=tuple(at))
    l.gravity(g)
    l.potential(-(torques[0] * psi + torques[1] * th1 + torques[2] * (th2 - th1)))
    l.contact(gap=tip[2], e=e)
    again, system, rng = l.model().system(), FINGER.system(), np.random.default_rng(3)
    rows = sp.lambdify(
        (psi, th1, th2), tip.jacobian([psi, th1, th2]).subs({l1: FINGER.l1, l2: FINGER.l2}), "numpy"
    )  # fmt: skip
    places = []
    for _ in range(100):
        q, u = rng.uniform(-2, 2, 3), rng.uniform(-2, 2, 3)
        for which in (MASS, FORCE, GAP, NORMAL):
            expected = again.evaluate(which, 0.0, q, u)
            np.testing.assert_allclose(system.evaluate(which, 0.0, q, u), expected, atol=1e-12)
        np.testing.assert_allclose(system.evaluate(TANGENT, 0.0, q, u)[0], rows(*q)[:2], atol=1e-13)
        rate = (rows(*(q + 1e-5 * u)) - rows(*(q - 1e-5 * u))) @ u / 2e-5
        np.testing.assert_allclose(system.evaluate(ROW_RATES, 0.0, q, u)[0], rate[[2, 0, 1]], atol=1e-8)
        places.append([s.evaluate(POTENTIAL, 0.0, q, u)[0] for s in (system, again)])
    assert np.ptp(np.subtract(*np.array(places).T)) < 1e-12


@pytest.mark.parametrize("th2", THS)
def test_torques_press_with_the_force_that_was_asked_for(th2):
    """At rest: inside the cone the tip sticks and the table holds it with that force; outside it slides."""
    for force, sticks in (((0.5, 0.1, -0.3), True), ((0.5, 0.0, 0.61), False), ((0.5, -0.61, 0.0), False)):
        finger = FINGER.with_torques(FINGER.torques_that_press(force, th2))
        np.testing.assert_allclose(finger.force_at_rest(th2), force, atol=1e-13)
        c = ns.classify(finger, state={"th2": th2, "slip": 0.0, "psi": 0.7})
        held = [s for s in c.solutions if s.modes == ("stick",)]
        assert len(held) == sticks
        for solution in held:
            across = np.array([-math.sin(0.7), math.cos(0.7)])
            assert solution.la[0, 0] == pytest.approx(0.5, abs=1e-12)
            assert solution.la[0, 1:] @ across == pytest.approx(force[2], abs=1e-12)
            np.testing.assert_allclose(solution.du, 0.0, atol=1e-11)


def test_a_finger_that_is_pressed_on_the_table_stays_where_it_is():
    finger = FINGER.with_torques(FINGER.torques_that_press((2.0, 0.5, 1.0), -1.2))
    sol = ns.simulate(finger, (0, 0.2), *finger.state(slip=0.0, psi=0.3), integrator=ns.MoreauJean(dt=1e-3))
    np.testing.assert_allclose(sol.q, sol.q[0] + np.zeros_like(sol.q), atol=1e-12)
    assert (sol.mode[1:] == ns.ContactMode.STICK).all()


@pytest.mark.parametrize("th2", THS)
def test_p_is_that_of_the_state_in_every_direction(th2):
    for phi in (-2.5, -0.4, 0.0, 1.2, 3.0):
        q, u = FINGER.state(th2=th2, phi=phi, slip=0.4, psi=0.6)
        c = ns.classify(FINGER, 0.0, q, u)
        np.testing.assert_allclose(c.direction[0], [math.cos(0.6 + phi), math.sin(0.6 + phi)], atol=1e-12)
        assert c.p[0] == pytest.approx(FINGER.p(th2, phi), rel=1e-11)
    assert ns.critical_friction(FINGER, q) == pytest.approx(FINGER.critical_friction(th2), rel=1e-12)


def test_the_default_finger_is_in_a_paradox_where_its_tip_slides_away_from_the_joint():
    finger = RobotFinger()
    assert finger.mu > finger.critical_friction(-1.2)
    kinds = [ns.classify(finger, state={"phi": phi}).kind.name for phi in (0.0, 1.5, 2.5)]
    assert kinds == ["INCONSISTENT", "REGULAR", "REGULAR"]


def test_what_the_joints_cannot_do_is_refused():
    with pytest.raises(ns.InvalidInput, match="reach"):
        RobotFinger().slopes(0.5)
    straight = RobotFinger(H=0.11 * math.sin(1.0))
    with pytest.raises(ns.InvalidInput, match="stretched"):
        straight.state(th2=-1.0)
