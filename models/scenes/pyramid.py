"""A pyramid of boxes in the plane: each stands on two of the row below, with a space between neighbours.

It stands for any friction, as friction carries nothing but what the supports leave undetermined: row k from the top
presses on the one below with its weight and those above it, m g (1 + ... + k).
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.checks.arrays import as_count, as_non_negative, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, HalfPlane


@dataclass(frozen=True)
class Pyramid:
    """A pyramid of boxes: bodies "row 0 box 0" (bottom left) to the top.

    Parameters
    ----------
    rows : int
        Number of rows; the lowest has as many boxes.
    a : float
        Edge [m].
    space : float
        Between neighbours, of an edge; 0 to 1.
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
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import Pyramid
    >>> pyramid = Pyramid(rows=3)
    >>> sol = ns.simulate(pyramid, (0, 0.1), integrator=ns.MoreauJean(dt=pyramid.dt))
    >>> ground_load = sol.contacts().of("ground").P_N.sum() / pyramid.dt
    >>> bool(abs(ground_load / pyramid.weight() - 1) < 1e-6)
    True
    """

    rows: int = 10
    a: float = 0.2  # edge [m]
    space: float = 0.1  # [-]
    density: float = 1000.0  # [kg/m^2]
    mu: float = 0.5  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "pyramid"
    source = "the pyramid of boxes of Box2D's samples, by which solvers are compared"
    t_end = 5.0  # s
    dt = 2e-3  # s

    def __post_init__(self) -> None:
        as_count("rows", self.rows)
        as_positive("a", self.a, "m")
        if not 0 < as_non_negative("space", self.space) < 1:
            raise InvalidInput(f"space must lie between 0 and 1, of an edge; got {self.space:g}")
        as_positive("density", self.density, "kg/m^2")
        as_non_negative("mu", self.mu)
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The pyramid, at rest on the ground."""
        scene = Scene(gravity=(0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfPlane((0, 1)), name="ground")
        pitch = (1 + self.space) * self.a
        for row in range(self.rows):
            count = self.rows - row
            for k in range(count):
                place = ((k - 0.5 * (count - 1)) * pitch, (row + 0.5) * self.a)
                scene.body(Box(self.a, self.a), density=self.density, position=place, name=f"row {row} box {k}")
        return scene

    def boxes(self) -> int:
        """How many there are."""
        return self.rows * (self.rows + 1) // 2

    def weight(self) -> float:
        """Of all boxes [N]."""
        return self.boxes() * self.density * self.a**2 * self.g
