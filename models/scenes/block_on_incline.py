"""A block on an incline, in space, at a part of its friction limit: it must not creep.

tan(al) = share mu:    share < 1 rests,    share > 1 slides at g (sin(al) - mu cos(al))
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_positive
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, HalfSpace


@dataclass(frozen=True)
class BlockOnIncline:
    """A block on an incline that descends along x: body "block".

    Parameters
    ----------
    share : float
        Of the friction limit, tan(angle)/mu.
    mu : float
        Friction coefficient.
    a, b, c : float
        Edges along the incline, across it and out of it [m].
    density : float
        Density [kg/m^3].
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import BlockOnIncline
    >>> BlockOnIncline(share=0.5).acceleration(), round(BlockOnIncline(share=2.0, mu=0.3).acceleration(), 4)
    (0.0, 2.5236)
    """

    share: float = 0.5  # [-]
    mu: float = 0.5  # friction [-]
    a: float = 0.4  # [m]
    b: float = 0.3  # [m]
    c: float = 0.2  # [m]
    density: float = 1000.0  # [kg/m^3]
    g: float = 9.81  # gravity [m/s^2]

    name = "block-on-incline"
    source = "Coulomb (1785); the block that creeps in engines that soften or delay friction"
    t_end = 10.0  # s
    dt = 2e-3  # s

    def __post_init__(self) -> None:
        as_positive("share", self.share)
        as_positive("mu", self.mu)
        for name in ("a", "b", "c"):
            as_positive(name, getattr(self, name), "m")
        as_positive("density", self.density, "kg/m^3")
        as_positive("g", self.g, "m/s^2")

    def angle(self) -> float:
        """Of the incline, atan(share mu) [rad]."""
        return math.atan(self.share * self.mu)

    def scene(self) -> Scene:
        """The block at rest on the incline."""
        angle = self.angle()
        normal = (math.sin(angle), 0.0, math.cos(angle))
        scene = Scene(gravity=(0.0, 0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfSpace(normal), name="incline")
        scene.body(
            Box(self.a, self.b, self.c), density=self.density, position=[0.5 * self.c * n for n in normal],
            turn=(math.cos(0.5 * angle), 0.0, math.sin(0.5 * angle), 0.0), name="block",
        )  # fmt: skip
        return scene

    def acceleration(self) -> float:
        """Down the incline [m/s^2]; 0 at rest."""
        return max(0.0, self.g * (math.sin(self.angle()) - self.mu * math.cos(self.angle())))
