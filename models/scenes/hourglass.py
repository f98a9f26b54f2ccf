"""Discs that run through the neck of an hourglass, in the plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.checks.arrays import LARGEST_COUNT, as_count, as_index, as_non_negative, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Disc, HalfPlane, Segment

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

PITCH, OFF = 2.3, 0.1  # chosen: in radii: distance of neighbours, and how far places are off at most
WIDTH, HEIGHT = 24.0, 20.0  # chosen: in radii: half the width at the top, and height of each half of the glass


@dataclass(frozen=True)
class Hourglass:
    """Discs above the neck of an hourglass: bodies "disc 0" to "disc n-1".

    Parameters
    ----------
    n : int
        Number of discs.
    r : float
        Radius [m].
    neck : float
        Width of the neck, in diameters; below about four discs may bridge it.
    density : float
        Density [kg/m^2].
    mu : float
        Friction coefficient.
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
    >>> from nonsmooth.catalogue import Hourglass
    >>> Hourglass(n=50).scene()
    Scene(planar, 55 bodies, 50 of them dynamic)
    """

    n: int = 120
    r: float = 0.01  # radius [m]
    neck: float = 5.0  # in diameters [-]
    density: float = 1000.0  # [kg/m^2]
    mu: float = 0.3  # friction [-]
    g: float = 9.81  # gravity [m/s^2]
    seed: int = 0

    name = "hourglass"
    source = "To, Lai and Pak, Phys. Rev. Lett. 86 (2001) 71-74 (jamming of discs in a hopper)"
    t_end = 2.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_count("n", self.n)
        as_positive("r", self.r, "m")
        if not 1 < as_positive("neck", self.neck) < WIDTH / 2:
            raise InvalidInput(f"neck must lie between 1 and {WIDTH / 2:g} diameters; got {self.neck:g}")
        as_positive("density", self.density, "kg/m^2")
        as_non_negative("mu", self.mu)
        as_positive("g", self.g, "m/s^2")
        as_index("seed", self.seed, LARGEST_COUNT)

    def scene(self) -> Scene:
        """The discs at rest above the glass; the middle of its neck is the origin."""
        scene = Scene(gravity=(0.0, -self.g), material=Material(mu=self.mu))
        neck, wide, high = self.neck * self.r, WIDTH * self.r, HEIGHT * self.r
        scene.fixed(HalfPlane((0, 1), -high), name="floor")
        for side, name in ((-1, "left"), (1, "right")):
            scene.fixed(Segment((side * neck, 0), (side * wide, high)), name=f"{name} slope")
            scene.fixed(HalfPlane((-side, 0), -wide), name=f"{name} wall")
        rng = np.random.default_rng(self.seed)
        for k, place in enumerate(self.lattice()):
            place = place + self.r * rng.uniform(-OFF, OFF, 2) + (0, high)
            scene.body(Disc(self.r), density=self.density, position=place, name=f"disc {k}")
        return scene

    def lattice(self) -> np.ndarray:
        """Places (n, 2) of the discs above the slopes [m]."""
        a_row = int((2 * WIDTH - 2) / PITCH)
        k = np.arange(self.n)
        return self.r * PITCH * np.stack([k % a_row - 0.5 * (a_row - 1), k // a_row + 0.5], axis=1)

    def passed(self, solution: SceneSolution) -> np.ndarray:
        """How many discs are below the neck, in each record (n_t,)."""
        discs = [k for k, name in enumerate(solution.names) if name.startswith("disc")]
        return (solution.position[:, discs, 1] < 0).sum(axis=1)
