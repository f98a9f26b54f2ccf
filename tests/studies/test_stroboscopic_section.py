"""Sections of forced motions once a period, against the closed form of the impact oscillator and of a linear one."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

import nonsmooth as ns
from tests.drawing.looks import faults

RESTITUTION = 0.5


@dataclass(frozen=True)
class Forced:
    """An oscillator under a force.

    Parameters
    ----------
    Omega : float
        Angular frequency [rad/s].
    c : float
        Damping [N s/m].
    """

    Omega: float = 2.0
    c: float = 0.0


def mass(t, q, p, M):
    M[0, 0] = 1.0


def force(t, q, u, p, h):
    h[0] = math.cos(p.Omega * t) - q[0] - p.c * u[0]


def gap(t, q, p, g_N):
    g_N[0] = q[0]


HAMMER = ns.System(
    coordinates=[("x", "m")], mass=mass, force=force, gap=gap, contacts=[ns.Contact(e_N=RESTITUTION)],
    parameters=Forced(), name="hammer",
)  # fmt: skip
FREE = ns.System(coordinates=[("x", "m")], mass=mass, force=force, parameters=Forced(c=0.4))


def sections_of_one_impact(Omega, n):
    """x(2 pi k/Omega), k = 0 .. n-1, of the orbit of x'' + x = cos(Omega t) that hits x = 0 once in n periods.

    Between impacts, with A = 1/(1 - Omega^2) and the phase th of the force at the impact,
    x = -c cos t + b sin t + A cos(Omega t + th), c = A cos th; x(tau) = 0 after tau = n T gives b = -c tan(tau/2), and
    x'(0) = -e x'(tau) the tangent of th (Shaw, Holmes, J. Sound Vib. 90 (1983) 129)."""
    e, tau, A = RESTITUTION, 2 * math.pi * n / Omega, 1 / (1 - Omega**2)
    tangent = (e * math.sin(tau) - math.tan(tau / 2) * (1 + e * math.cos(tau))) / (1 + e)
    for th in (math.atan(tangent / Omega), math.atan(tangent / Omega) + math.pi):
        c = A * math.cos(th)
        b = -c * math.tan(tau / 2)
        if b - A * Omega * math.sin(th) > 0:  # it leaves the wall
            t = (2 * math.pi * np.arange(n) - th) / Omega % tau
            return np.sort(-c * np.cos(t) + b * np.sin(t) + A * np.cos(Omega * t + th))
    raise AssertionError


def test_an_impact_oscillator_hits_once_a_period_and_once_in_two():
    """One and two points of the closed form, upwards and downwards; contraction e^2 an impact, 40 impacts at least."""
    values, n = [1.5, 3.6, 3.8, 3.9], [1, 2, 2, 2]
    diagram = ns.bifurcation_diagram(
        HAMMER, "Omega", values, state=dict(x=0.5), duration=200.0, forcing="Omega", integrator=ns.EventDriven()
    )
    np.testing.assert_allclose(diagram.periods, 2 * math.pi / np.array(values))
    for points in (diagram.upwards, diagram.downwards):
        for k, Omega in enumerate(values):
            np.testing.assert_allclose(points[k], sections_of_one_impact(Omega, n[k]), atol=1e-6)
    assert diagram.opens.all()


def test_time_steps_find_the_same_points_but_for_their_error():
    """An impact is known to a step: x is wrong by some velocity times dt."""
    diagram = ns.bifurcation_diagram(
        HAMMER, "Omega", [3.8], state=dict(x=0.5), duration=200.0, dt=1e-3, forcing=lambda p: 2 * math.pi / p.Omega
    )
    exact = sections_of_one_impact(3.8, 2)
    distance = np.abs(diagram.upwards[0][:, None] - exact).min(axis=1)
    assert distance.max() < 5e-3 and (np.abs(exact[:, None] - diagram.upwards[0]).min(axis=1) < 5e-3).all()


@pytest.mark.parametrize("Omega", [0.7, 1.3])
def test_a_linear_oscillator_repeats_after_one_period_and_has_two_points_at_half_of_it(Omega):
    """x = Re(exp(i Omega t)/(1 - Omega^2 + i c Omega)); its negative half a period later. exp(-c t/2) is 2e-28 at the
    beginning of the late part."""
    options = dict(state=dict(x=0.0), duration=400.0, integrator=ns.EventDriven(rtol=1e-9, atol=1e-11), dt=1e-2)
    x = (1 / (1 - Omega**2 + 1j * 0.4 * Omega)).real
    one = ns.bifurcation_diagram(FREE, "Omega", [Omega], forcing=2 * math.pi / Omega, **options)
    np.testing.assert_allclose(one.upwards[0], [x], atol=1e-7)
    two = ns.bifurcation_diagram(FREE, "Omega", [Omega], forcing=math.pi / Omega, **options)
    np.testing.assert_allclose(two.upwards[0], [-abs(x), abs(x)], atol=1e-7)


def test_a_section_is_drawn_as_such(tmp_path):
    diagram = ns.bifurcation_diagram(
        HAMMER, "Omega", np.linspace(3.4, 4.0, 4), state=dict(x=0.5), duration=120.0, dt=1e-2, forcing="Omega"
    )
    figure = diagram.plot(tmp_path / "section.png")
    assert figure.axes[0].get_ylabel() == "once a period of the forcing: x [m]" and faults(figure) == []


def test_a_frequency_without_a_unit_is_not_guessed():
    bare = ns.System(
        coordinates=[("x", "m")], mass=mass, force=force, gap=gap, contacts=[ns.Contact()], parameters=Bare()
    )
    with pytest.raises(
        ns.InvalidInput, match=r"unit .* is \[s\], \[Hz\] or \[rad/s\]; got none; give the period itself"
    ):
        ns.bifurcation_diagram(
            bare, "Omega", [2.0], state=dict(x=0.5), duration=100.0, dt=1e-2, forcing="Omega"
        )  # fmt: skip


@dataclass(frozen=True)
class Bare:
    Omega: float = 2.0
    c: float = 0.0
