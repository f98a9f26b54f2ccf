"""Parcels that are put on a running belt one after the other, in the plane.

Each is pulled along at mu g until it has the speed of the belt, v/(mu g) after it was put there and v^2/(2 mu g) on.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.checks.arrays import as_count, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, HalfPlane


@dataclass(frozen=True)
class Conveyor:
    """A belt, from x = 0 to its length, the floor below its end, and parcels at rest on it: "parcel 0" the foremost.

    Parameters
    ----------
    n : int
        Number of parcels.
    a : float
        Edge of a parcel [m].
    space : float
        Between two of them [m].
    length, height : float
        Of the belt, and above the floor [m].
    v : float
        Speed of the belt [m/s].
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
    >>> from nonsmooth.catalogue import Conveyor
    >>> belt = Conveyor(v=1.0, mu=0.4)
    >>> round(belt.carried_at(), 4), round(belt.way(), 4)
    (0.2548, 0.1274)
    """

    n: int = 4
    a: float = 0.2  # [m]
    space: float = 0.2  # [m]
    length: float = 3.0  # [m]
    height: float = 0.6  # [m]
    v: float = 1.0  # [m/s]
    density: float = 100.0  # [kg/m^2]
    mu: float = 0.4  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "conveyor"
    source = "Coulomb friction on a moving surface"
    t_end = 3.5  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_count("n", self.n)
        for name in ("a", "space", "length", "height"):
            as_positive(name, getattr(self, name), "m")
        as_number("v", self.v, "m/s")
        if not (self.n - 1) * (self.a + self.space) < 0.5 * self.length:
            raise InvalidInput(
                f"n parcels of a, space between them, must stand on half of the length, {0.5 * self.length:g} m; got "
                f"{self.n} of {self.a:g} m and {self.space:g} m"
            )
        as_positive("density", self.density, "kg/m^2")
        as_positive("mu", self.mu)
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The belt and the parcels, the foremost with its middle in that of the belt."""
        scene = Scene(gravity=(0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfPlane((0, 1), -self.height), name="floor")
        thickness = 0.5 * self.height
        scene.fixed(
            Box(self.length, thickness), position=(0.5 * self.length, -0.5 * thickness), surface_velocity=(self.v, 0),
            name="belt",
        )  # fmt: skip
        for k in range(self.n):
            place = (0.5 * self.length - k * (self.a + self.space), 0.5 * self.a)
            scene.body(Box(self.a, self.a), density=self.density, position=place, name=f"parcel {k}")
        return scene

    def carried_at(self) -> float:
        """When a parcel has the speed of the belt [s]."""
        return abs(self.v) / (self.mu * self.g)

    def way(self) -> float:
        """That it has gone by then [m]."""
        return self.v**2 / (2 * self.mu * self.g)
