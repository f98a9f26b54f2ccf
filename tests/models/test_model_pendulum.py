"""Pendulum against a wall: elliptic integrals against integration."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from models import WallPendulum


@pytest.mark.parametrize("th_w", [0.0, 0.3, -0.4])
def test_impacts_agree_with_the_integrated_swing(th_w):
    pendulum = WallPendulum(th_w=th_w, l=1.3)

    def wall(t, y):
        return y[0] - th_w

    wall.terminal, wall.direction = True, -1.0
    t, y, times, rates = 0.0, np.array([1.2, 0.0]), [], []
    for _ in range(3):
        swing = solve_ivp(
            lambda t, y: [y[1], -pendulum.g / pendulum.l * np.sin(y[0])], (t, t + 10), y,
            method="DOP853", rtol=1e-12, atol=1e-13, events=wall,
        )  # fmt: skip
        t, y = swing.t_events[0][0], swing.y_events[0][0]
        times.append(t)
        rates.append(y[1])
        y = np.array([th_w, -pendulum.e * y[1]])
    np.testing.assert_allclose(pendulum.impact_times(3, th=1.2), times, rtol=1e-9)
    np.testing.assert_allclose(pendulum.impact_rates(3, th=1.2), rates, rtol=1e-9)


def test_peak_angles_lose_e_squared_of_their_energy():
    pendulum = WallPendulum(e=0.8)
    peaks = pendulum.peak_angles(4, th=1.0)
    assert peaks[0] == pytest.approx(1.0, rel=1e-15)
    np.testing.assert_allclose((1 - np.cos(peaks[1:])) / (1 - np.cos(peaks[:-1])), 0.64, rtol=1e-12)


def test_impacts_accumulate_only_where_gravity_presses_on_the_wall():
    accumulating = WallPendulum(th_w=0.4).impact_times(60)
    steady = WallPendulum(th_w=0.0).impact_times(60)
    assert accumulating[-1] - accumulating[-10] < 1e-4
    # half a period of the small pendulum between impacts
    assert steady[-1] - steady[-2] == pytest.approx(np.pi / WallPendulum().omega(), rel=1e-6)
