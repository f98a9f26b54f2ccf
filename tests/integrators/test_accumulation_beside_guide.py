"""A series of bounces beside a rough guide: the friction of each flight and of each impact adds up, by a closed form.

A slider on a rail bounces on a floor that leans against the rail. In flight the rail carries the side load, at an
impact k P, with the sign of k: the friction along the rail is mu times the size of either,

    m w' = -mu |side|  (flight),    m dw = -mu |k| P,  P = (1 + e) m v_k,    m w' = -mu |side - k m g|  (rest).
"""

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns


class Slider(NamedTuple):
    """x across the rail, y above the floor, z along the rail."""

    m: float = 1.3  # [kg]
    g: float = 9.81  # [m/s^2]
    side: float = 4.0  # [N] on the rail in flight
    k: float = 0.7  # slope of the floor across the rail
    mu: float = 0.3
    e: float = 0.5
    height: float = 0.02  # [m]
    w: float = 3.0  # [m/s] along the rail at first

    def along(self, t):
        """z and w at the time t, from bounce to bounce."""
        z, w, now = 0.0, self.w, 0.0
        wait, v = math.sqrt(2 * self.height / self.g), math.sqrt(2 * self.g * self.height)
        brake = self.mu * abs(self.side) / self.m
        while wait > 1e-18 and now + wait < t:
            z, w, now = z + w * wait - brake * wait**2 / 2, w - brake * wait, now + wait
            w -= self.mu * abs(self.k) * (1 + self.e) * v
            v *= self.e
            wait = 2 * v / self.g
        if wait <= 1e-18:
            brake = self.mu * abs(self.side - self.k * self.m * self.g) / self.m
        left = t - now
        return z + w * left - brake * left**2 / 2, w - brake * left


def mass(t, q, p, M):
    M[0, 0] = M[1, 1] = M[2, 2] = p.m


def force(t, q, u, p, h):
    h[0], h[1] = -p.side, -p.m * p.g


def gap(t, q, p, g_N):
    g_N[0] = q[0]
    g_N[1] = q[1] + p.k * q[0]


def tangent(t, q, p, W_F):
    W_F[0, 0, 2] = 1.0


def run(slider, integrator, t_end):
    system = ns.System(
        coordinates=["x", "y", "z"], mass=mass, force=force, gap=gap, tangent=tangent, parameters=slider,
        contacts=[ns.Contact(mu="mu", bilateral=True), ns.Contact(e_N="e")],
    )  # fmt: skip
    start = [0.0, slider.height, 0.0], [0.0, 0.0, slider.w]
    return ns.simulate(system, (0.0, t_end), *start, integrator=integrator, t_eval=[0.5 * t_end, t_end])


METHODS = [ns.EventDriven, ns.Adaptive]


@pytest.mark.parametrize("rtol", [1e-5, 1e-7, 1e-9])
@pytest.mark.parametrize("k", [0.7, -0.7])
@pytest.mark.parametrize("e", [0.2, 0.6])
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.__name__)
def test_the_friction_of_a_guide_is_that_of_every_bounce(method, e, k, rtol):
    slider = Slider(e=e, k=k)
    sol = run(slider, method(rtol, rtol / 100), 0.6)
    assert sol.success
    for row in (-2, -1):
        z, w = slider.along(sol.t[row])
        assert w > 0.3  # it slides on
        assert sol.q[row, 2] == pytest.approx(z, abs=3 * rtol) and sol.u[row, 2] == pytest.approx(w, abs=30 * rtol)
    assert sol.q[-1, 1] == pytest.approx(0.0, abs=1e-12) and sol.u[-1, 1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.__name__)
def test_a_smooth_guide_and_impulses_of_one_sign_are_as_before(method):
    for slider in (Slider(mu=0.0), Slider(side=-4.0), Slider(k=0.0)):
        sol = run(slider, method(1e-8, 1e-10), 0.5)
        assert sol.q[-1, 2] == pytest.approx(slider.along(0.5)[0], abs=3e-8)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.__name__)
def test_the_impulses_of_the_bounces_given_up_are_booked(method):
    """The floor takes the weight, friction what the slider loses."""
    slider = Slider()
    sol = run(slider, method(1e-6, 1e-8), 0.6)
    assert sol.P_N[:, 1].sum() == pytest.approx(slider.m * slider.g * 0.6, rel=1e-5)
    assert np.sum(sol.P_F[:, 0]) == pytest.approx(slider.m * (sol.u[-1, 2] - slider.w), rel=1e-5)
