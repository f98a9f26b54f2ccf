"""Watt's governor with a sleeve, in space: two balls on arms about a spindle that turns evenly.

With the angle alpha of the arms from the spindle, J = m l^2 + I of a ball about its hinge and W = w^2/2 of the spindle:

    (J + 2 M l^2 sin^2 alpha) alpha'^2 - m l^2 w^2 sin^2 alpha - 2 (m + M) g l cos alpha = const
    rests at cos alpha = (m + M) g/(m l w^2), where that is below 1; else it hangs
    swings about it at  W^2 = m l^2 w^2 sin^2 alpha/(J + 2 M l^2 sin^2 alpha)

The links from the balls to the sleeve are as long as the arms, and have no mass. Balls have no weight of their own to
turn but I about any axis, and the arms none.
Source: Maxwell, *Proc. R. Soc.* 16 (1868) 270; Pontryagin, *Ordinary Differential Equations* (1962), section 27.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Capsule, Compound, Cylinder, Sphere

UPRIGHT = math.pi / 2  # derived: arms as far out as they go
UP = math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0  # derived: turns x onto z


@dataclass(frozen=True)
class Governor:
    """Bodies "spindle", guided, "left", "right" and "sleeve"; at rest on the turning spindle.

    Parameters
    ----------
    l : float
        Arms and links [m].
    m, M : float
        A ball, the sleeve [kg].
    r : float
        Of the balls [m].
    w : float
        Rate of the spindle [rad/s].
    alpha : float
        Angle of the arms at the start [rad].
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import Governor
    >>> governor = Governor()
    >>> round(governor.rest(), 4), round(governor.frequency(), 4), Governor(w=3.0).rest()
    (1.0861, 5.4661, 0.0)
    """

    l: float = 0.4  # arms and links [m]
    m: float = 1.0  # a ball [kg]
    M: float = 2.0  # sleeve [kg]
    r: float = 0.05  # of the balls [m]
    w: float = 4 * math.pi  # of the spindle [rad/s]
    alpha: float = 0.8  # at the start [rad]
    g: float = 9.81  # gravity [m/s^2]

    name = "governor"
    source = "Maxwell, Proc. R. Soc. 16 (1868) 270"
    t_end = 2.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        for name, unit in (("l", "m"), ("m", "kg"), ("M", "kg"), ("r", "m"), ("g", "m/s^2")):
            as_positive(name, getattr(self, name), unit)
        as_number("w", self.w, "rad/s")
        if not 0.0 < as_positive("alpha", self.alpha, "rad") < UPRIGHT:
            raise InvalidInput(f"alpha must be below pi/2 rad; got {self.alpha:g}")

    def scene(self) -> Scene:
        """Arms at their first angle, turning with the spindle."""
        scene, spin = Scene(gravity=(0.0, 0.0, -self.g)), (0.0, 0.0, self.w)
        scene.kinematic(Cylinder(0.01, 2 * self.l), position=(0.0, 0.0, -self.l), turn=UP, spin=spin, name="spindle")
        low = (0.0, 0.0, -2 * self.l * math.cos(self.alpha))
        scene.body(Cylinder(0.03, 0.02), mass=self.M, position=low, turn=UP, spin=spin, name="sleeve")
        scene.slider("spindle", "sleeve", axis=(0, 0, 1), name="guide")
        for name, side in (("left", -1.0), ("right", 1.0)):
            out = np.array([side * math.sin(self.alpha), 0.0, -math.cos(self.alpha)])
            turn = math.cos(0.5 * self.alpha), 0.0, -side * math.sin(0.5 * self.alpha), 0.0
            arm = Capsule(self.l, 0.005)
            scene.body(
                Compound((Sphere(self.r), (0, 0, 0)), (arm, (0, 0, 0.5 * self.l), UP)), mass=self.m,
                inertia=np.full(3, 0.4 * self.m * self.r**2), centre=(0, 0, 0), position=self.l * out, turn=turn,
                spin=spin, velocity=(0.0, side * self.w * self.l * math.sin(self.alpha), 0.0), name=name,
            )  # fmt: skip
            scene.hinge("spindle", name, at=(0, 0, 0), axis=(0, -side, 0), name=f"arm {name}")
            scene.distance(name, "sleeve", name=f"link {name}")
        scene.ignore(*scene.bodies)
        return scene

    def angle(self, bodies: Any) -> np.ndarray:
        """alpha of a run, or at one time [rad], from the height of the sleeve."""
        return np.arccos(-np.asarray(bodies["sleeve"].position)[..., 2] / (2 * self.l))

    def rest(self) -> float:
        """Where it rests, turning [rad]."""
        cosine = (self.m + self.M) * self.g / (self.m * self.l * self.w**2) if self.w != 0.0 else math.inf
        return math.acos(cosine) if cosine < 1.0 else 0.0

    def inertia(self, alpha: Any) -> Any:
        """What its energy has as that of alpha'^2 [kg m^2]."""
        return self.m * (self.l**2 + 0.4 * self.r**2) + 2 * self.M * (self.l * np.sin(alpha)) ** 2

    def frequency(self) -> float:
        """W of small swings about where it rests [rad/s]."""
        rest = self.rest()
        return abs(self.w * math.sin(rest)) * self.l * math.sqrt(self.m / float(self.inertia(rest)))

    def potential(self, alpha: Any) -> Any:
        """That of weight and of turning [J], of half the energy above."""
        weight = 2 * (self.m + self.M) * self.g * self.l * np.cos(alpha)
        return -self.m * (self.l * self.w * np.sin(alpha)) ** 2 - weight

    def angle_at(self, times: np.ndarray) -> np.ndarray:
        """alpha at times, by the equation of motion that this energy has [rad]."""
        from scipy.integrate import solve_ivp

        def rate(_: float, y: np.ndarray) -> list[float]:
            s, c = math.sin(y[0]), math.cos(y[0])
            pull = (self.m * (self.l * self.w) ** 2 * c - (self.m + self.M) * self.g * self.l) * s
            return [y[1], (pull - 2 * self.M * self.l**2 * s * c * y[1] ** 2) / float(self.inertia(y[0]))]

        span = 0.0, float(times[-1])
        return np.asarray(solve_ivp(rate, span, [self.alpha, 0.0], "DOP853", times, rtol=1e-12, atol=1e-13).y[0])
