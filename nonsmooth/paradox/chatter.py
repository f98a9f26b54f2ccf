"""Chatter and reverse chatter: bounces that die out on a contact at rest, or grow out of it.

Between bounces the contact flies freely, gamma_N' = b < 0, gamma_F' = a, so that over the time 2 gamma_N/|b|

    gamma_N- = -gamma_N+,    gamma_F- = gamma_F+ + 2 a gamma_N+/|b| ;

then comes an impact, ``paradox.impact``. Both maps are homogeneous of degree one, so that x = gamma_F+/gamma_N+ has a
map of its own. At a fixed point of it the bounces form a geometric sequence with the ratio r = gamma_N+ after / before:
r < 1 is chatter that comes to rest in finite time, r > 1 reverse chatter, which grows out of rest and may take the
place of sticking although sticking is consistent. With Newton's law r = e always; the energetic law lets friction feed
the bounces.
Source: Nordmark, Dankowicz, Champneys, *IMA J. Appl. Math.* 76 (2011) 85.
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.jit import interpreted
from nonsmooth.mechanics.impact import impulse_map
from nonsmooth.mechanics.laws import ImpactLaw

DIRECTIONS = 721  # derived: starts, x = tan(angle): a quarter of a degree apart


def bounce(x: float, law: ImpactLaw, e: float, mu: float, G: np.ndarray, a: float, b: float) -> tuple[float, float]:
    """One flight and one impact from gamma_N+ = 1, gamma_F+ = x: (gamma_N+, gamma_F+) after it."""
    (G_NN, G_NF), (_, G_FF) = G
    gamma_F = x + 2.0 * a / abs(b)
    P_N, P_F, _, _ = interpreted(impulse_map)(law, e, mu, G_NN, G_NF, G_FF, -1.0, gamma_F)
    return -1.0 + G_NN * P_N + G_NF * P_F, gamma_F + G_NF * P_N + G_FF * P_F


def chatter_ratio(e: float, mu: float, G: np.ndarray, a: float, b: float,
                  law: ImpactLaw = ImpactLaw.ENERGETIC) -> float:  # fmt: skip
    """The greatest ratio r of self-similar bounces of one contact; nan where there are none (b >= 0 or e = 0).

    Parameters
    ----------
    e, mu : float
        Restitution (of the law) and friction.
    G : ndarray (2, 2)
        Delassus matrix, rows (N, F), positive definite [1/kg].
    a, b : float
        Free tangential and normal accelerations [m/s^2].
    """
    if not (b < 0.0 and e > 0.0):
        return math.nan
    angles = np.linspace(-0.5 * math.pi, 0.5 * math.pi, DIRECTIONS)[1:-1]

    def turn(angle: float) -> float:
        """Angle of (gamma_N, gamma_F) after a bounce less that before it: zero at a fixed point of the ratio."""
        gamma_N, gamma_F = bounce(math.tan(angle), law, e, mu, G, a, b)
        return math.atan2(gamma_F, gamma_N) - angle

    turns = np.array([turn(angle) for angle in angles])
    ratios = [
        bounce(math.tan(_root(turn, angles[j], angles[j + 1])), law, e, mu, G, a, b)[0]
        for j in np.flatnonzero(turns[:-1] * turns[1:] <= 0.0)
    ]
    return max(ratios, default=math.nan)


def _root(function, low: float, high: float) -> float:
    from scipy.optimize import brentq

    return brentq(function, low, high, xtol=1e-14, rtol=1e-14)
