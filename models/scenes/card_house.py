"""Two cards that lean on one another: how steep must they stand?

Each weighs W; the foot carries N = W, and the push H at the top, where by symmetry nothing needs friction, is held by
the friction of the foot. With the angle a from the vertical, and edges rounded by r, moments about the foot are

    H (l cos a + r) = W (l/2) sin a,    H <= mu W:    l sin(a - b) <= r sin b,    tan b = 2 mu

which for thin cards is tan a <= 2 mu.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_non_negative, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Capsule, HalfPlane


@dataclass(frozen=True)
class CardHouse:
    """Two cards that lean on one another: bodies "left" and "right".

    Parameters
    ----------
    length : float
        l, between the middle points of the rounded edges [m].
    thickness : float
        2 r [m].
    angle : float
        Of each card from the vertical [rad].
    density : float
        Density [kg/m^2].
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
    >>> from nonsmooth.catalogue import CardHouse
    >>> round(CardHouse(mu=0.3).largest_angle(), 4), round(CardHouse(mu=0.3, thickness=1e-6).largest_angle(), 4)
    (0.5461, 0.5404)
    """

    length: float = 0.09  # [m]
    thickness: float = 0.002  # [m]
    angle: float = 0.5  # from the vertical [rad]
    density: float = 700.0  # [kg/m^2]
    mu: float = 0.3  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "card-house"
    source = "statics: tan(angle) <= 2 mu for thin cards"
    t_end = 1.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_positive("length", self.length, "m")
        as_positive("thickness", self.thickness, "m")
        if not 0 < as_positive("angle", self.angle, "rad") < math.pi / 2:
            raise InvalidInput(f"angle must lie between 0 and pi/2; got {self.angle:g} rad")
        as_positive("density", self.density, "kg/m^2")
        as_non_negative("mu", self.mu)
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The two cards, at rest on the ground."""
        scene = Scene(gravity=(0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfPlane((0, 1)), name="ground")
        r = 0.5 * self.thickness
        middle = (0.5 * self.length * math.sin(self.angle) + r, 0.5 * self.length * math.cos(self.angle) + r)
        for name, side in (("left", -1.0), ("right", 1.0)):
            scene.body(
                Capsule(self.length, r), density=self.density, position=(side * middle[0], middle[1]),
                turn=side * (self.angle - 0.5 * math.pi) + (math.pi if side < 0 else 0.0), name=name,
            )  # fmt: skip
        return scene

    def largest_angle(self) -> float:
        """At which they stand, b + asin(r sin(b)/l) [rad]."""
        b = math.atan(2 * self.mu)
        return b + math.asin(0.5 * self.thickness / self.length * math.sin(b))

    def push(self) -> float:
        """Of one card on the other at rest, H [N]."""
        r = 0.5 * self.thickness
        weight = self.density * (self.length * self.thickness + math.pi * r * r) * self.g
        return 0.5 * weight * self.length * math.sin(self.angle) / (self.length * math.cos(self.angle) + r)
