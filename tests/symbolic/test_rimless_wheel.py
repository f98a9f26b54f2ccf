"""A rimless wheel from its energies, eight feet as eight contacts, beside its step map in closed form.

    omega_(k+1)^2 = eta^2 (omega_k^2 + Delta),    eta = (I + m a^2 cos 2 alpha)/(I + m a^2)

Source: McGeer, *Int. J. Robotics Research* 9 (1990) 62.
"""

from __future__ import annotations

import numpy as np
import pytest

sp = pytest.importorskip("sympy", reason="energies need SymPy, the extra [symbolic]")

import nonsmooth as ns  # noqa: E402

FEET = 8
HALF = np.pi / FEET


def declared():
    l = ns.lagrangian("rimless wheel of the test")
    x, y = l.coordinates("x y", unit="m")
    (th,) = l.coordinates("th", unit="rad")
    m, a, I, g, gamma, mu = l.parameters(m=1.3, a=0.8, I=0.2, g=9.81, gamma=0.1, mu=1.5)
    l.rigid_body(m, I, at=(x, y), angle=th)
    l.gravity(g, direction=(sp.sin(gamma), -sp.cos(gamma)))
    for k in range(FEET):
        angle = th + 2 * sp.pi * k / FEET
        l.contact(point=(x + a * sp.sin(angle), y - a * sp.cos(angle)), normal=(0, 1), mu=mu)
    return l.model()


def run(wheel, omega, integrator, duration):
    a, s, c = wheel.a, np.sin(HALF), np.cos(HALF)
    start = wheel.state(x=-a * s, y=a * c, th=HALF, xdot=-a * c * omega, ydot=-a * s * omega, thdot=omega)
    sol = ns.simulate(wheel, (0, duration), *start, integrator=integrator)
    after = sol.u[1:, 2][np.diff(sol.u[:, 2]) > 0.05]  # rad/s; an impact takes more, a step between impacts far less
    return after, expected(wheel, omega, len(after))


def expected(wheel, omega, number):
    inertia = wheel.I + wheel.m * wheel.a**2
    eta = (wheel.I + wheel.m * wheel.a**2 * np.cos(2 * HALF)) / inertia
    gain = 4 * wheel.m * wheel.g * wheel.a * np.sin(HALF) * np.sin(wheel.gamma) / inertia
    found = [omega]
    for _ in range(number):
        found.append(-eta * np.sqrt(found[-1] ** 2 + gain))
    return np.array(found[1:])


def test_located_impacts_of_a_rimless_wheel_are_those_of_its_step_map():
    after, closed_form = run(declared(), -1.5, ns.EventDriven(1e-11, 1e-12), 4.0)
    assert len(after) >= 5
    np.testing.assert_allclose(after, closed_form, rtol=1e-10)  # ten times the tolerance of the integrator


def test_time_stepping_meets_the_step_map_with_first_order():
    wheel = declared()
    errors = []
    for dt in (4e-4, 1e-4):
        after, closed_form = run(wheel, -1.5, ns.MoreauJean(dt=dt), 3.0)
        assert len(after) >= 4
        errors.append(np.abs(after - closed_form).max())
    assert errors[1] < 0.6 * errors[0] < 0.6 * 10 * 4e-4 * wheel.g / wheel.a  # an impact falls anywhere within a step
