"""A wall of bricks in running bond, in space: each brick stands on two halves of the course below.

It stands for any friction; what presses on the ground is its weight.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.checks.arrays import as_count, as_non_negative, as_positive
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, HalfSpace

LENGTH, DEPTH, HEIGHT = 0.24, 0.115, 0.071  # defined: of a brick of German standard format, DIN 105-100 [m]
JOINT = 0.01  # defined: between two bricks of a course, DIN 1053-1 [m]


@dataclass(frozen=True)
class Wall:
    """A dry wall of bricks: bodies "course 0 brick 0" to the top; every other course ends in half bricks.

    Parameters
    ----------
    courses : int
        Number of courses.
    bricks : int
        Bricks in a course without half bricks.
    density : float
        Density [kg/m^3].
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
    >>> from nonsmooth.catalogue import Wall
    >>> Wall(courses=2, bricks=2).scene()
    Scene(spatial, 6 bodies, 5 of them dynamic)
    """

    courses: int = 6
    bricks: int = 5
    density: float = 1800.0  # [kg/m^3]
    mu: float = 0.6  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "wall"
    source = "masonry in running bond; format of bricks after DIN 105-100"
    t_end = 2.0  # s
    dt = 2e-3  # s

    def __post_init__(self) -> None:
        as_count("courses", self.courses)
        as_count("bricks", self.bricks)
        as_positive("density", self.density, "kg/m^3")
        as_non_negative("mu", self.mu)
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The wall, at rest on the ground."""
        scene = Scene(gravity=(0.0, 0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfSpace((0, 0, 1)), name="ground")
        for course in range(self.courses):
            for k, (x, length) in enumerate(self.bricks_of(course)):
                place = (x, 0.0, (course + 0.5) * HEIGHT)
                scene.body(
                    Box(length, DEPTH, HEIGHT), density=self.density, position=place, name=f"course {course} brick {k}"
                )
        return scene

    def bricks_of(self, course: int) -> list[tuple[float, float]]:
        """Middle and length of each brick of a course [m]."""
        pitch, half = LENGTH + JOINT, 0.5 * (LENGTH - JOINT)
        left = -0.5 * (self.bricks * pitch - JOINT)
        if course % 2 == 0:
            return [(left + k * pitch + 0.5 * LENGTH, LENGTH) for k in range(self.bricks)]
        whole = [(left + half + JOINT + k * pitch + 0.5 * LENGTH, LENGTH) for k in range(self.bricks - 1)]
        return [(left + 0.5 * half, half), *whole, (-left - 0.5 * half, half)]

    def weight(self) -> float:
        """Of all bricks [N]."""
        lengths = sum(length for course in range(self.courses) for _, length in self.bricks_of(course))
        return self.density * lengths * DEPTH * HEIGHT * self.g
