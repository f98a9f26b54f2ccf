"""Painlevé's rod with its tip held on the ground: bilateral contact.

    p(mu_s) la_N + b = 0,    mu_s = mu sgn(gamma_F) sgn(la_N),    la_F = -mu_s la_N

The normal force has either sign. With p(-mu) < 0 < p(+mu) there are none or two solutions, in either direction of slip;
of the two, the one with p > 0 is the limit of a compliant contact, the other is unstable.
Source: Painlevé, *C. R. Acad. Sci. Paris* 121 (1895) 112; textbook chapter on friction-induced instability (corrected).
The geometry is that of models/rod_geometry.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.mechanics.system import Contact, System

from .rod_geometry import FUNCTIONS, TipRod, slip_sign, tip


@dataclass(frozen=True)
class BilateralRod(TipRod):
    """Rod whose tip is guided along the ground: q = (x, y, th), bilateral contact with friction.

    Parameters
    ----------
    m : float
        Mass [kg].
    l : float
        Length [m].
    I : float
        Central moment of inertia [kg m^2]; m l^2/12 for a uniform slender rod, see `slender`.
    mu : float
        Friction coefficient.
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from nonsmooth.catalogue import BilateralRod
    >>> rod = BilateralRod(mu=2.0)
    >>> [round(N, 6) for N in rod.normal_forces(th=np.pi / 3, thdot=6.0, slip=-1.0)]
    [-1.328969, 6.813606]
    >>> rod.normal_forces(th=np.pi / 3, thdot=0.0, slip=-1.0)
    ()
    """

    name = "bilateral-rod"
    source = "Painlevé, C. R. Acad. Sci. Paris 121 (1895) 112; textbook chapter on friction-induced instability " \
             "(corrected)"  # fmt: skip
    t_end = 0.3  # s
    dt = 1e-4  # s

    def system(self) -> System:
        """The system with one bilateral contact with friction at the tip."""
        return System(
            n_q=3, **FUNCTIONS, contacts=[Contact(mu="mu", bilateral=True, at=tip)], parameters=self, name=self.name
        )  # fmt: skip

    def state(self, th: float = math.pi / 3, thdot: float = 6.0, slip: float = -1.0,
              x: float = 0.0) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """q0 (3,) and u0 (3,) with the tip on the ground.

        Parameters
        ----------
        th, thdot : float
            Angle [rad] and angular velocity [rad/s]; the default state has two solutions.
        slip : float
            Velocity of the tip along the ground, gamma_F [m/s].
        x : float
            Position of the centre [m].
        """
        return self.tip_state(th, thdot, slip, x)

    def normal_forces(self, th: float, thdot: float, slip: float) -> tuple[float, ...]:
        """Every la_N with p(mu_s) la_N + b = 0 [N], in increasing order; zero only where b = 0."""
        b, mu_s = self.b(th, thdot), self.mu * slip_sign(slip)
        if b == 0:
            return (0.0,)
        solutions = []
        for sign in (-1.0, 1.0):
            p = self.p(th, mu_s * sign)
            if p != 0 and -b / p * sign > 0:
                solutions.append(-b / p)
        return tuple(solutions)

    def angular_acceleration(self, th: float, thdot: float, slip: float, la_N: float) -> float:
        """th'' = (l/2I) (la_F sin th - la_N cos th) of one of the solutions la_N [rad/s^2]."""
        la_F = -self.mu * slip_sign(slip) * abs(la_N)
        return 0.5 * self.l / self.I * (la_F * math.sin(th) - la_N * math.cos(th))
