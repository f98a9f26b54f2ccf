"""Spheres released over the floor of a box, on a lattice that is not quite regular."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import LARGEST_COUNT, as_count, as_fraction, as_index, as_non_negative, as_positive
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import HalfSpace, Sphere

# chosen: in radii: distance of neighbours and of layers, height of the lowest layer, how far places are off at most
PITCH, LAYER, ABOVE, OFF = 2.3, 2.2, 0.2, 0.08


@dataclass(frozen=True)
class SphereBox:
    """Spheres that fall into a box: bodies "sphere 0" to "sphere n-1".

    Parameters
    ----------
    n : int
        Number of spheres.
    r : float
        Radius [m].
    density : float
        Density [kg/m^3].
    mu : float
        Friction coefficient.
    e : float
        Restitution coefficient (Newton).
    g : float
        Gravity [m/s^2].
    seed : int
        Of the places.

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import SphereBox
    >>> SphereBox(n=1000).scene(), round(SphereBox(n=1000).side(), 6)
    (Scene(spatial, 1005 bodies, 1000 of them dynamic), 1.2)
    """

    n: int = 125
    r: float = 0.05  # radius [m]
    density: float = 1000.0  # [kg/m^3]
    mu: float = 0.5  # friction [-]
    e: float = 0.0  # restitution [-]
    g: float = 9.81  # gravity [m/s^2]
    seed: int = 0

    name = "sphere-box"
    source = "the pile by which engines of rigid bodies are compared"
    t_end = 1.0  # s
    dt = 2e-3  # s

    def __post_init__(self) -> None:
        as_count("n", self.n)
        as_positive("r", self.r, "m")
        as_positive("density", self.density, "kg/m^3")
        as_non_negative("mu", self.mu)
        as_fraction("e", self.e)
        as_positive("g", self.g, "m/s^2")
        as_index("seed", self.seed, LARGEST_COUNT)

    def scene(self) -> Scene:
        """The spheres in the air, at rest, over the floor and between the four walls."""
        scene = Scene(gravity=(0.0, 0.0, -self.g), material=Material(mu=self.mu, e=self.e))
        scene.fixed(HalfSpace((0, 0, 1)), name="floor")
        for name, normal in (("west", (1, 0, 0)), ("east", (-1, 0, 0)), ("south", (0, 1, 0)), ("north", (0, -1, 0))):
            scene.fixed(HalfSpace(normal, -0.5 * self.side()), name=name)
        k, rng = self.a_row(), np.random.default_rng(self.seed)
        for i in range(self.n):
            lattice = np.array([i % k - 0.5 * (k - 1), i // k % k - 0.5 * (k - 1), i // (k * k)])
            place = self.r * (lattice * (PITCH, PITCH, LAYER) + (0, 0, 1 + ABOVE) + rng.uniform(-OFF, OFF, 3))
            scene.body(Sphere(self.r), density=self.density, position=place, name=f"sphere {i}")
        return scene

    def a_row(self) -> int:
        """Spheres along an edge of the lattice: as high as wide."""
        return max(1, math.ceil(round(self.n ** (1 / 3), 9)))

    def side(self) -> float:
        """Of the box [m]: the lattice, and half a sphere more on either side."""
        return self.r * (PITCH * self.a_row() + 1)

    def weight(self) -> float:
        """Of all spheres [N]."""
        return self.n * self.density * 4 / 3 * math.pi * self.r**3 * self.g
