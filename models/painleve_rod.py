"""Painlevé's rod: a rod that slides on rough ground on its lower tip, unilateral contact.

    gamma_N' = p la_N + b,    0 <= la_N  _|_  gamma_N' >= 0
    p > 0: one solution;    p < 0, b > 0: two (indeterminate);    p < 0, b < 0: none (inconsistent)

Source: Painlevé, *C. R. Acad. Sci. Paris* 121 (1895) 112; Lötstedt, *ZAMM* 61 (1981) 605; Génot and Brogliato,
*Eur. J. Mech. A/Solids* 18 (1999) 653. The geometry is that of models/rod_geometry.py.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_non_negative
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import Contact, System

from .rod_geometry import FUNCTIONS, TipRod, slip_sign, tip


class RodImpact(NamedTuple):
    """Outcome of an impact without collision.

    Attributes
    ----------
    P_1, P_c : float
        Normal impulse at which the tip stops slipping, and at the greatest compression [N s].
    P_N, P_F : float
        Total normal and friction impulse [N s].
    gamma_N : float
        Normal velocity of the tip after the impact [m/s].
    u : ndarray (3,)
        Velocities x', y' [m/s] and th' [rad/s] after the impact.
    """

    P_1: float
    P_c: float
    P_N: float
    P_F: float
    gamma_N: float
    u: np.ndarray


@dataclass(frozen=True)
class PainleveRod(TipRod):
    """Rod sliding on its lower tip, unilateral contact: q = (x, y, th), the centre and the angle.

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
    e : float
        Restitution coefficient (Newton).

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from nonsmooth.catalogue import PainleveRod
    >>> rod = PainleveRod(mu=2.0)
    >>> mu_P, th_P = rod.least_critical_friction()
    >>> round(mu_P, 6), round(float(np.degrees(th_P)), 4)
    (1.333333, 63.4349)
    >>> rod.normal_forces(th=np.pi / 3, thdot=0.0, slip=-1.0)
    ()
    >>> [round(N, 6) for N in rod.normal_forces(th=np.pi / 3, thdot=6.0, slip=-1.0)]
    [0.0, 6.813606]
    """

    e: float = 0.0  # restitution [-]

    name = "painleve-rod"
    source = "Painlevé, C. R. Acad. Sci. Paris 121 (1895) 112; Lötstedt, ZAMM 61 (1981) 605; " \
             "Génot and Brogliato, Eur. J. Mech. A/Solids 18 (1999) 653"  # fmt: skip
    t_end = 0.3  # s
    dt = 1e-4  # s

    def __post_init__(self) -> None:
        super().__post_init__()
        as_fraction("e", self.e)

    def system(self) -> System:
        """The system with one unilateral contact with friction at the tip."""
        return System(n_q=3, **FUNCTIONS, contacts=[Contact(mu="mu", e_N="e", at=tip)], parameters=self, name=self.name)

    def state(self, th: float = math.pi / 3, thdot: float = 0.0, slip: float = -1.0,
              x: float = 0.0) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """q0 (3,) and u0 (3,) with the tip on the ground and neither rising nor falling.

        Parameters
        ----------
        th, thdot : float
            Angle [rad] and angular velocity [rad/s].
        slip : float
            Velocity of the tip along the ground, gamma_F [m/s].
        x : float
            Position of the centre [m].
        """
        return self.tip_state(th, thdot, slip, x)

    def coefficients(self, th: float, thdot: float, slip: float) -> tuple[float, float]:
        """(p, b) of gamma_N' = p la_N + b in the present direction of slip [1/kg, m/s^2]."""
        return self.p(th, self.mu * slip_sign(slip)), self.b(th, thdot)

    def normal_forces(self, th: float, thdot: float, slip: float) -> tuple[float, ...]:
        """Every la_N that solves 0 <= la_N _|_ p la_N + b >= 0 [N], in increasing order."""
        p, b = self.coefficients(th, thdot, slip)
        free = (0.0,) if b >= 0 else ()
        pressed = (-b / p,) if b * p < 0 else ()
        return free + pressed

    def impact_without_collision(
        self,
        th: float = math.pi / 3,
        thdot: float = 0.0,
        slip: float = -1.0,
        e: float | None = None,
        law: str = "newton",
    ) -> RodImpact:
        """The impact that resolves a state with p < 0, at frozen configuration (Darboux, Keller).

        The tip slips until P_1 = |slip|/|gamma_F per impulse|, reaching gamma_N = p P_1 < 0; then it sticks and
        gamma_N rises at k_st = G_NN - G_NF^2/G_FF, through zero at P_c (greatest compression).

        Parameters
        ----------
        th, thdot, slip : float
            The state, with p < 0 and gamma_N = 0.
        e : float, optional
            Restitution coefficient; the model's when left out.
        law : {"newton", "poisson", "energetic"}
            Newton: P_c, whatever e, since gamma_N = 0 before. Poisson: (1 + e) P_c. Energetic (Stronge): the work of
            the expansion is e^2 that of the compression, P_c + e sqrt(-gamma_N1 P_c/k_st).

        Raises
        ------
        InvalidInput
            Where p >= 0 (there is no such impact), for an unknown law, or e outside [0, 1].
        """
        e = as_fraction("e", self.e if e is None else e)
        P_1, w_1, k_st = self._slip_phase(th, slip)
        P_c = P_1 - w_1 / k_st
        if law not in ("newton", "poisson", "energetic"):
            raise InvalidInput(f"law must be 'newton', 'poisson' or 'energetic'; got {law!r}")
        expansion = {"newton": 0.0, "poisson": e * P_c, "energetic": e * math.sqrt(-w_1 * P_c / k_st)}[law]
        return self._impact(th, thdot, slip, expansion)

    def compliant_limit(self, th: float = math.pi / 3, thdot: float = 0.0, slip: float = -1.0,
                        zeta: float = 0.0) -> RodImpact:  # fmt: skip
        """The impact without collision as the limit k -> inf of a compliant contact with damping ratio zeta.

        N = max(0, k d + c d'), c = 2 zeta sqrt(k m), d the indentation. While the tip slips, d and d' grow along the
        unstable direction of d'' = -p (k d + c d'); while it sticks, d'' = -k_st (k d + c d') until N = 0. Both are
        solved in the time sqrt(k) t.

        Raises
        ------
        InvalidInput
            Where p >= 0, or zeta < 0.
        """
        P_1, w_1, k_st = self._slip_phase(th, slip)
        c = 2 * as_non_negative("zeta", zeta) * math.sqrt(self.m)  # damping at k = 1
        p = w_1 / P_1
        growth = -p * c / 2 + math.sqrt((p * c / 2) ** 2 - p)
        d_0, v_0 = -w_1 / growth, -w_1
        root = cmath.sqrt((k_st * c / 2) ** 2 - k_st)
        if abs(root) < 1e-8 * math.sqrt(k_st):  # critically damped: the two exponents differ by rounding only
            root = complex(1e-8 * math.sqrt(k_st))
        s_1, s_2 = -k_st * c / 2 + root, -k_st * c / 2 - root
        a_1, a_2 = (v_0 - s_2 * d_0) / (s_1 - s_2), (s_1 * d_0 - v_0) / (s_1 - s_2)
        ratio = cmath.log(-a_2 * (1 + c * s_2) / (a_1 * (1 + c * s_1)))  # (s_1 - s_2) t at N = 0
        if abs(root.imag) > abs(root.real):
            time = (ratio.imag % (2 * math.pi)) / (s_1 - s_2).imag
        else:
            time = ratio.real / (s_1 - s_2).real
        w_plus = -(a_1 * s_1 * cmath.exp(s_1 * time) + a_2 * s_2 * cmath.exp(s_2 * time)).real
        return self._impact(th, thdot, slip, w_plus / k_st)

    def _slip_phase(self, th: float, slip: float) -> tuple[float, float, float]:
        """P_1, gamma_N there, and k_st; refuses p >= 0."""
        mu_s = self.mu * slip_sign(slip)
        (G_NN, G_NF), (_, G_FF) = self.delassus(th)
        p = G_NN - mu_s * G_NF
        if p >= 0:
            raise InvalidInput(
                f"an impact without collision needs p < 0; got p = {p:g} 1/kg at th = {th:g}, slip = {slip:g}; "
                f"mu must exceed {self.critical_friction(th):g}, with slip against the lean of the rod"
            )
        P_1 = -slip / (G_NF - mu_s * G_FF)
        return P_1, p * P_1, G_NN - G_NF**2 / G_FF

    def _impact(self, th: float, thdot: float, slip: float, expansion: float) -> RodImpact:
        """Apply the normal impulse P_c + expansion."""
        P_1, w_1, k_st = self._slip_phase(th, slip)
        (_, G_NF), (_, G_FF) = self.delassus(th)
        P_c = P_1 - w_1 / k_st
        P_N = P_c + expansion
        P_F = -self.mu * slip_sign(slip) * P_1 - G_NF / G_FF * (P_N - P_1)
        _, u = self.tip_state(th, thdot, slip, 0.0)
        s = 0.5 * self.l
        u += np.array([P_F / self.m, P_N / self.m, s * (P_F * math.sin(th) - P_N * math.cos(th)) / self.I])
        return RodImpact(P_1, P_c, P_N, P_F, k_st * expansion, u)
