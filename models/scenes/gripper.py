"""A gripper that holds a box by friction.

Two fingers on rails press with F each. They hold the box as long as

    2 mu F >= m (g + a),    a the acceleration with which they lift it

and else it slips with g + a - 2 mu F/m against them. The scene stands on the hand, whose lift is a part of gravity.
Source: Newton's law of the box.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.checks.arrays import as_non_negative, as_number, as_positive
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box

FINGER = (0.02, 0.08)  # chosen: width and height of a finger [m]


@dataclass(frozen=True)
class Gripper:
    """Two fingers and a box: bodies "hand", "left", "right" and "box", seen from the hand, which is lifted.

    Parameters
    ----------
    m : float
        Mass of the box [kg].
    size : float
        Its edge [m].
    F : float
        Force of each finger [N].
    mu : float
        Friction coefficient.
    a : float
        Acceleration of the hand, upwards [m/s^2].
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import Gripper
    >>> Gripper(mu=0.5).least_force(), round(Gripper(mu=0.5, F=8.0).slip(), 9)
    (11.81, 3.81)
    """

    m: float = 1.0  # box [kg]
    size: float = 0.06  # of the box [m]
    F: float = 12.5  # of a finger [N]
    mu: float = 0.5  # friction [-]
    a: float = 2.0  # of the hand [m/s^2]
    g: float = 9.81  # gravity [m/s^2]

    name = "gripper"
    source = "Newton's law of the box"
    t_end = 0.5  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        for name, unit in (("m", "kg"), ("size", "m"), ("F", "N"), ("g", "m/s^2")):
            as_positive(name, getattr(self, name), unit)
        as_non_negative("mu", self.mu)
        as_number("a", self.a, "m/s^2")

    def scene(self) -> Scene:
        """The box between the fingers, at rest; each finger slides on a rail of the hand, and is pushed towards it."""
        scene = Scene(gravity=(0.0, -self.g - self.a), material=Material(mu=self.mu))
        width, height = FINGER
        scene.fixed(Box(self.size, width), position=(0.0, self.size), name="hand")
        scene.body(Box(self.size, self.size), mass=self.m, position=(0.0, 0.0), name="box")
        for name, side in (("left", -1), ("right", 1)):
            place = side * 0.5 * (self.size + width), 0.0
            scene.body(Box(width, height), mass=0.1, position=place, name=name)
            scene.slider("hand", name, at=place, axis=(1, 0), name=f"{name} rail")
            scene.force(name, (-side * self.F, 0.0))
        scene.ignore("hand", "box")
        return scene

    def least_force(self) -> float:
        """Of a finger, that holds the box [N]."""
        return self.m * (self.g + self.a) / (2 * self.mu)

    def slip(self) -> float:
        """The acceleration of the box against the fingers, downwards; 0 where they hold it [m/s^2]."""
        return max(0.0, self.g + self.a - 2 * self.mu * self.F / self.m)
