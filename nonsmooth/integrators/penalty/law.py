"""Forces of a compliant contact from its indentation d = -g_N and its rate d' = -gamma_N.

    clipped         la_N = max(0, k d + c d')  while d > 0           (lifts off where the force reaches zero)
    kelvin-voigt    la_N = k d + c d'          while d > 0, or always in a bilateral contact: of either sign
    hunt-crossley   la_N = max(0, d^(3/2) (k + c d'))  while d > 0

    regularised friction    la_F = -mu(|gamma_F|) |la_N| tanh(gamma_F / v_s)

Sources: Brogliato, *Nonsmooth Mechanics* (2016), chapter 2; Hunt, Crossley, *J. Appl. Mech.* 42 (1975) 440.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from nonsmooth.checks.arrays import as_positive
from nonsmooth.jit import kernel


class NormalLaw(IntEnum):
    """The law of the normal force."""

    CLIPPED = 0
    KELVIN_VOIGT = 1
    HUNT_CROSSLEY = 2


LAWS = {
    "clipped": NormalLaw.CLIPPED,
    "kelvin-voigt": NormalLaw.KELVIN_VOIGT,
    "hunt-crossley": NormalLaw.HUNT_CROSSLEY,
}
EXPONENTS = {NormalLaw.CLIPPED: 1.0, NormalLaw.KELVIN_VOIGT: 1.0, NormalLaw.HUNT_CROSSLEY: 1.5}


@dataclass(frozen=True)
class Regularised:
    """Friction without sticking: la_F = -mu |la_N| tanh(gamma_F / v_s).

    A contact that would stick creeps instead, at a part of v_s.

    Parameters
    ----------
    v_s : float
        Sliding velocity at which friction reaches tanh(1) = 76 % of its limit [m/s].

    Raises
    ------
    InvalidInput
        Unless v_s > 0.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.Regularised(v_s=1e-3)
    Regularised(v_s=0.001)
    """

    v_s: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "v_s", as_positive("v_s", self.v_s, "m/s"))


@dataclass(frozen=True)
class TangentialSpring:
    """Friction of a scene: a spring along the contact that slides where it would pull with more than mu |la_N|.

    A contact that sticks gives way by |la_T|/k_T, and its spring has the damper of the same part of critical damping.
    A `System` sticks rigidly and takes none.

    Parameters
    ----------
    ratio : float
        k_T/k. Two elastic spheres have 2 (1 - nu)/(2 - nu), 0.8 for Poisson's ratio 1/3, the default (Mindlin,
        *J. Appl. Mech.* 16 (1949) 259).

    Raises
    ------
    InvalidInput
        Unless ratio > 0.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> ns.Penalty(stiffness=1e6, damping_ratio=0.3, friction=ns.TangentialSpring(ratio=0.5)).friction
    TangentialSpring(ratio=0.5)
    """

    ratio: float = 0.8

    def __post_init__(self) -> None:
        object.__setattr__(self, "ratio", as_positive("ratio", self.ratio))


@kernel
def normal_force(law, k, c, d, d_rate):
    """la_N of a closed contact, continued smoothly beyond the end of contact: the clipping is an event."""
    if law == NormalLaw.HUNT_CROSSLEY:
        return d * math.sqrt(abs(d)) * (k + c * d_rate)
    return k * d + c * d_rate
