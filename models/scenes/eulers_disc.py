"""Euler's disc: a coin that rolls on its rim, and turns the faster the flatter it lies.

With its centre at rest it turns about the line from there to the lowest point of its rim, at P, and this line
precesses evenly: for a tilt alpha, half a thickness h, moments A across the axis and C about it,

    spin = k P,    k^2 = m g sin(alpha) P_x / (r (A r cos(alpha) - C h sin(alpha)))
    P_x = r cos(alpha) - h sin(alpha),    Omega = k r/sin(alpha)
    thin and flat:  Omega^2 = 4 g/(r alpha),  E = 3 m g r alpha/2

so that Omega grows as alpha^(-1/2) while energy is lost, whatever loses it. The rim of a rigid disc that does not slip
loses none: here the precession goes on.
Source: Moffatt, *Nature* 404 (2000) 833-834; Kessler and O'Reilly, *Regul. Chaotic Dyn.* 7 (2002) 49-60.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Cylinder, HalfSpace


@dataclass(frozen=True)
class EulersDisc:
    """A disc on its rim, in steady precession at the start: body "disc".

    Parameters
    ----------
    r, thickness : float
        Radius [m], thickness [m].
    density : float
        Density [kg/m^3].
    tilt : float
        Of its face from the ground, at the start [rad].
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
    >>> from models.scenes import EulersDisc
    >>> disc = EulersDisc()
    >>> round(disc.precession(), 1)  # [rad/s]; 102.3 of a thin disc that lies flat
    102.4
    """

    r: float = 0.0375  # [m]
    thickness: float = 0.0005  # [m]
    density: float = 7800.0  # [kg/m^3]
    tilt: float = 0.1  # [rad]
    mu: float = 1.0  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "eulers-disc"
    source = "Moffatt, Nature 404 (2000) 833-834"
    t_end = 0.5  # s
    dt = 1e-4  # s

    def __post_init__(self) -> None:
        for name, unit in (("r", "m"), ("thickness", "m"), ("density", "kg/m^3"), ("mu", ""), ("g", "m/s^2")):
            as_positive(name, getattr(self, name), unit)
        if not 0 < as_number("tilt", self.tilt, "rad") < 0.5 * math.pi:
            raise InvalidInput(f"tilt must lie between 0 and a right angle; got {self.tilt:g} rad")
        if not min(self._pull()) > 0:
            raise InvalidInput(
                f"thickness must be less, for a disc of {self.r:g} m, tilted by {self.tilt:g} rad, to go round on its "
                f"rim; got {self.thickness:g} m"
            )

    def scene(self) -> Scene:
        """The disc on the lowest point of its rim, its centre at rest, turning about the line from it to that point."""
        scene = Scene(gravity=(0.0, 0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfSpace((0, 0, 1)), name="ground")
        h, s, c = 0.5 * self.thickness, math.sin(self.tilt), math.cos(self.tilt)
        k, half = self.turn_rate(), 0.5 * (self.tilt - 0.5 * math.pi)  # from x to the axis (s, 0, c)
        scene.body(
            Cylinder(self.r, self.thickness), density=self.density, position=(0, 0, self.r * s + h * c),
            turn=(math.cos(half), 0.0, math.sin(half), 0.0), name="disc",
            spin=(k * (self.r * c - h * s), 0.0, -k * (self.r * s + h * c)),
        )  # fmt: skip
        return scene

    def turn_rate(self) -> float:
        """The spin over the way from the centre to the point of contact, k [1/(m s)]."""
        arm, change = self._pull()
        return math.sqrt(self.g * math.sin(self.tilt) * arm / (self.r * change))

    def _pull(self) -> tuple[float, float]:
        """The arm of the weight about the point of contact [m], and what of the angular momentum it turns [m^3]."""
        h, s, c, r = 0.5 * self.thickness, math.sin(self.tilt), math.cos(self.tilt), self.r
        A, C = r**2 / 4 + h**2 / 3, r**2 / 2  # of a mass of 1
        return r * c - h * s, A * r * c - C * h * s

    def precession(self) -> float:
        """How fast the point of contact goes round, Omega [rad/s]."""
        return self.turn_rate() * self.r / math.sin(self.tilt)

    def tilt_of(self, turn: np.ndarray) -> np.ndarray:
        """The angle of the face with the ground [rad] for turns (..., 4)."""
        return np.arctan2(np.hypot(*self.axis(turn)[..., :2].T), self.axis(turn)[..., 2])

    def azimuth(self, turn: np.ndarray) -> np.ndarray:
        """Where the lowest point is, about the vertical, without jumps [rad], for turns (n, 4)."""
        axis = self.axis(turn)
        return np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))

    def axis(self, turn: np.ndarray) -> np.ndarray:
        """Of the disc in the world (..., 3), for turns (..., 4)."""
        w, x, y, z = np.moveaxis(turn, -1, 0)
        return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=-1)
