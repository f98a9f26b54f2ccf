"""A brake with a shoe on a lever, that helps itself, or locks.

The shoe presses with N on the top of a wheel, at a distance b from the pivot of its lever along the wheel and c below
it. Friction mu N pulls the shoe along with the wheel: towards the pivot (spin > 0), where it presses the shoe on, or
away from it. A force F at the length L of the lever is in balance with

    F L = N (b - mu c)    spin > 0: locks for mu >= b/c, however small F is
    F L = N (b + mu c)    spin < 0

Where it locks the slide has no forces: p = b (b - mu c)/J <= 0 of a lever with the inertia J. An impact stops the
wheel at once; contacts that are coupled by joints are not asked for paradoxes, so that the run does not name it.
Source: Budynas, Nisbett, *Shigley's Mechanical Engineering Design*, chapter 16 (short shoes).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_non_negative, as_number, as_positive
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, Disc

SHOE = (0.08, 0.04)  # chosen: length and height [m]


@dataclass(frozen=True)
class ShoeBrake:
    """A wheel on an axle and a shoe on its top: bodies "frame", "wheel" and "shoe".

    Parameters
    ----------
    R : float
        Radius of the wheel [m].
    I : float
        Its inertia [kg m^2].
    b, c : float
        From the pivot to the contact, along the wheel and downwards [m].
    L : float
        From the pivot to the force [m].
    F : float
        Force on the lever [N].
    mu : float
        Friction coefficient.
    spin : float
        Of the wheel at the start; > 0 pulls the shoe towards its pivot [rad/s].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import ShoeBrake
    >>> [round(ShoeBrake(spin=spin).normal_force(), 3) for spin in (30.0, -30.0)]
    [200.0, 66.667]
    >>> ShoeBrake(mu=0.81).locks(), round(ShoeBrake().stop_time(), 9)
    (True, 0.5)
    """

    R: float = 0.15  # wheel [m]
    I: float = 0.2  # of the wheel [kg m^2]
    b: float = 0.2  # from the pivot along the wheel [m]
    c: float = 0.25  # and down to the contact [m]
    L: float = 0.4  # lever [m]
    F: float = 50.0  # on the lever [N]
    mu: float = 0.4  # friction [-]
    spin: float = 30.0  # at the start [rad/s]

    name = "shoe-brake"
    source = "Budynas, Nisbett, Shigley's Mechanical Engineering Design, chapter 16"
    t_end = 0.8  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        for name, unit in (("R", "m"), ("I", "kg m^2"), ("b", "m"), ("c", "m"), ("L", "m"), ("F", "N")):
            as_positive(name, getattr(self, name), unit)
        as_non_negative("mu", self.mu)
        as_number("spin", self.spin, "rad/s")

    def scene(self) -> Scene:
        """The shoe on the turning wheel, without gravity."""
        scene, (length, height) = Scene(gravity=(0.0, 0.0), material=Material(mu=self.mu)), SHOE
        pivot = -self.b, self.R + self.c
        scene.fixed(Disc(0.01), position=pivot, name="frame")
        scene.body(Disc(self.R), mass=10.0, inertia=self.I, position=(0.0, 0.0), spin=self.spin, name="wheel")
        scene.body(Box(length, height), mass=1.0, position=(0.0, self.R + 0.5 * height), name="shoe")
        scene.hinge("frame", "wheel", at=(0.0, 0.0), name="axle")
        scene.hinge("frame", "shoe", at=pivot, name="pivot")
        scene.ignore("frame", "wheel")
        scene.ignore("frame", "shoe")
        scene.force("shoe", (0.0, -self.F), at=(self.L - self.b, self.c - 0.5 * height))
        return scene

    def locks(self) -> bool:
        """Whether the slide has no forces."""
        return self.spin > 0.0 and self.mu * self.c >= self.b

    def normal_force(self) -> float:
        """Of the shoe on the turning wheel [N]; inf where it locks."""
        arm = self.b - math.copysign(self.mu, self.spin) * self.c
        return self.F * self.L / arm if arm > 0.0 else math.inf

    def stop_time(self) -> float:
        """When the wheel stands [s]."""
        torque = self.mu * self.normal_force() * self.R
        return self.I * abs(self.spin) / torque if torque > 0.0 else math.inf
