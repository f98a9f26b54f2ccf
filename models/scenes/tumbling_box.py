"""A box that turns freely, almost about its middle axis: it turns over, again and again.

Euler's equations for moments A < B < C, with a = (C - B)/A, b = (C - A)/B, c = (B - A)/C,

    w_1' = -a w_2 w_3,    w_2' = b w_3 w_1,    w_3' = -c w_1 w_2

start from w_2 = 0 at t = 0 with solutions in Jacobi's elliptic functions. Where 2 E B > L^2 (w_1 never vanishes):
w_1 = W_1 dn, w_2 = W_2 sn, w_3 = W_3 cn of (p t | m). Source: Landau and Lifshitz, *Mechanics* (1976), section 37.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box


@dataclass(frozen=True)
class TumblingBox:
    """A free box: body "box"; its edges are longest along x and shortest along z, so that it turns over about y.

    Parameters
    ----------
    a, b, c : float
        Edges, a > b > c [m].
    density : float
        Density [kg/m^3].
    w_1, w_3 : float
        Angular velocities about x and z at t = 0, that about y is 0 then [rad/s].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import TumblingBox
    >>> box = TumblingBox()
    >>> bool(abs(box.angular_velocity(box.period()) - (box.w_1, 0, box.w_3)).max() < 1e-9)
    True
    """

    a: float = 0.3  # [m]
    b: float = 0.2  # [m]
    c: float = 0.1  # [m]
    density: float = 1000.0  # [kg/m^3]
    w_1: float = 3.0  # [rad/s]
    w_3: float = 2.0  # [rad/s]

    name = "tumbling-box"
    source = "Jacobi (1849); Landau and Lifshitz, Mechanics (1976), section 37"
    t_end = 10.0  # s
    dt = 2e-3  # s

    def __post_init__(self) -> None:
        for name in ("a", "b", "c"):
            as_positive(name, getattr(self, name), "m")
        if not self.a > self.b > self.c:
            raise InvalidInput(f"edges must be a > b > c; got {self.a:g}, {self.b:g}, {self.c:g} m")
        as_positive("density", self.density, "kg/m^3")
        as_positive("w_1", self.w_1, "rad/s")
        as_positive("w_3", self.w_3, "rad/s")

    def scene(self) -> Scene:
        """The box, free of gravity."""
        scene = Scene(gravity=(0.0, 0.0, 0.0))
        spin = (self.w_1, 0.0, self.w_3)
        scene.body(Box(self.a, self.b, self.c), density=self.density, position=(0, 0, 0), spin=spin, name="box")
        return scene

    def moments(self) -> np.ndarray:
        """A < B < C [kg m^2]."""
        squares = np.array([self.a, self.b, self.c]) ** 2
        return self.density * self.a * self.b * self.c * (squares.sum() - squares) / 12

    def _jacobi(self) -> tuple[float, float, bool]:
        """Rate p [rad/s], parameter m, and whether w_1 is the one that never vanishes."""
        A, B, C = self.moments()
        a, b, c = (C - B) / A, (C - A) / B, (B - A) / C
        # w_1^2/a + w_2^2/b and w_3^2/c + w_2^2/b are kept: the smaller bounds w_2
        first, third = self.w_1**2 / a, self.w_3**2 / c
        return math.sqrt(a * b * c * max(first, third)), min(first, third) / max(first, third), first > third

    def angular_velocity(self, t: float) -> np.ndarray:
        """At a time, in the axes of the box (3,) [rad/s]."""
        from scipy.special import ellipj

        A, B, C = self.moments()
        p, m, is_first = self._jacobi()
        sn, cn, dn, _ = ellipj(p * t, m)
        first, third = (dn, cn) if is_first else (cn, dn)
        w_2 = math.sqrt((C - A) / B * min(self.w_1**2 * A / (C - B), self.w_3**2 * C / (B - A)))
        return np.array([self.w_1 * first, w_2 * sn, self.w_3 * third])

    def period(self) -> float:
        """After which the angular velocity in the box is the same again [s]."""
        from scipy.special import ellipk

        p, m, _ = self._jacobi()
        return 4 * float(ellipk(m)) / p
