"""A car on two wheels that rolls over a low bump: the half car, with wheels that touch and roll.

With the height y of the chassis over its rest, its angle th, lifts h_k(t) of the centres of wheels at x_k = -+ L/2:

    m y'' = sum F_k,    J th'' = sum x_k F_k,    F_k = k (h_k - y - x_k th) + c (h_k' - y' - x_k th')

A wheel of radius r that stays on a bump of radius R, which stands b out of the road, has its centre on a circle:

    h = sqrt((R + r)^2 - x^2) - (R + r) + b   for |x| <= sqrt(2 b (R + r) - b^2), else 0

so that the linear equations have all that the wheels do, to the square of the slope of the bump, 2 b/(R + r). The
chassis has its centre of mass as high as the wheels: forces along the road do not pitch it.
Source: Genta, *Motor Vehicle Dynamics* (World Scientific, 1997), on the half car; the circle is geometry.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, Disc, HalfPlane

AHEAD = 0.3  # chosen: from the front wheel to the bump at the start [m]


@dataclass(frozen=True)
class CarOnBump:
    """Bodies "road", "bump", "chassis", "rear" and "front"; it rolls to the right in its rest on the springs.

    Parameters
    ----------
    m, J : float
        Mass [kg] and inertia [kg m^2] of the chassis.
    L, d : float
        Wheel base, and from the wheels up to the tops of the springs [m].
    m_w, r : float
        A wheel, a solid disc [kg], [m].
    k, c : float
        A spring [N/m] and its damper [N s/m].
    v : float
        Speed [m/s].
    b, R : float
        How far the bump stands out of the road, and its radius [m].
    mu : float
        Friction of tyre and road.
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import CarOnBump
    >>> car = CarOnBump()
    >>> round(car.lift(0.0), 6), round(float(abs(car.linear(np.linspace(0, 1.2, 601))[0]).max()), 4)
    (0.004, 0.0007)
    """

    m: float = 300.0  # chassis [kg]
    J: float = 200.0  # its inertia [kg m^2]
    L: float = 2.4  # wheel base [m]
    d: float = 0.4  # up to the tops of the springs [m]
    m_w: float = 10.0  # a wheel [kg]
    r: float = 0.3  # its radius [m]
    k: float = 2e4  # a spring [N/m]
    c: float = 1.5e3  # its damper [N s/m]
    v: float = 5.0  # speed [m/s]
    b: float = 0.004  # the bump out of the road [m]
    R: float = 2.0  # its radius [m]
    mu: float = 0.9  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "car-on-bump"
    source = "Genta, Motor Vehicle Dynamics (World Scientific, 1997)"
    t_end = 1.2  # s
    dt = 2.5e-4  # s

    def __post_init__(self) -> None:
        for name, unit in (
            ("m", "kg"), ("J", "kg m^2"), ("L", "m"), ("d", "m"), ("m_w", "kg"), ("r", "m"), ("k", "N/m"),
            ("v", "m/s"), ("b", "m"), ("R", "m"), ("g", "m/s^2"),
        ):  # fmt: skip
            as_positive(name, getattr(self, name), unit)
        for name, unit in (("c", "N s/m"), ("mu", "")):
            as_non_negative(name, getattr(self, name), unit)
        if self.b >= self.R:
            raise InvalidInput(f"b must be below R, {self.R:g} m; got {self.b:g}")

    def scene(self) -> Scene:
        """The car before the bump, whose middle is at x = 0."""
        scene = Scene(gravity=(0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfPlane((0.0, 1.0)), name="road")
        scene.fixed(Disc(self.R), position=(0.0, self.b - self.R), name="bump")
        middle = -self.half_width() - AHEAD - 0.5 * self.L
        moves = {"velocity": (self.v, 0.0)}
        scene.body(
            Box(1.3 * self.L, 0.5 * self.d), mass=self.m, inertia=self.J, position=(middle, self.r),
            name="chassis", **moves,
        )  # fmt: skip
        load = 0.5 * self.m * self.g
        for name, x in zip(("rear", "front"), middle + self.sides(), strict=True):
            hub = x, self.r
            scene.body(Disc(self.r), mass=self.m_w, position=hub, spin=-self.v / self.r, name=name, **moves)
            scene.slot("chassis", name, at=hub, axis=(0, 1), name=f"strut {name}")
            scene.spring(
                "chassis", name, at_a=(x, self.r + self.d), stiffness=self.k, damping=self.c,
                length=self.d + load / self.k, name=f"spring {name}",
            )  # fmt: skip
        scene.ignore("chassis", "bump")
        return scene

    def sides(self) -> np.ndarray:
        """x_k, of the rear and the front wheel [m]."""
        return np.array([-0.5, 0.5]) * self.L

    def half_width(self) -> float:
        """Where the centre of a wheel begins to rise, from the middle of the bump [m]."""
        return math.sqrt(2 * self.b * (self.R + self.r) - self.b**2)

    def lift(self, x: float) -> float:
        """h of a wheel at x from the middle of the bump [m]."""
        return max(0.0, math.sqrt(max(0.0, (self.R + self.r) ** 2 - x**2)) - self.R - self.r + self.b)

    def rise(self, x: float) -> float:
        """Its derivative by x."""
        return -x / math.sqrt((self.R + self.r) ** 2 - x**2) if abs(x) < self.half_width() else 0.0

    def linear(self, times: np.ndarray) -> np.ndarray:
        """y [m] and th [rad] of the linear equations, (2, n), at times [s]."""
        from scipy.integrate import solve_ivp

        x_k, front = self.sides(), -self.half_width() - AHEAD

        def rate(t: float, z: np.ndarray) -> np.ndarray:
            at = front + self.v * t + x_k - x_k[1]
            h, h_1 = (np.array([function(x) for x in at]) for function in (self.lift, self.rise))
            F = self.k * (h - z[0] - x_k * z[1]) + self.c * (self.v * h_1 - z[2] - x_k * z[3])
            return np.array([z[2], z[3], F.sum() / self.m, x_k @ F / self.J])

        step = 0.02 * self.half_width() / self.v  # no bump between two of them
        span, start = (0.0, times[-1]), np.zeros(4)
        return np.asarray(solve_ivp(rate, span, start, "DOP853", times, rtol=1e-9, atol=1e-12, max_step=step).y[:2])
