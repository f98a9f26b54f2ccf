"""A drawer that is pulled off its middle, in guides with clearance: it slides, or jams.

It turns until two opposite corners touch, l' apart along the guides and w' across them. Pulled by F at e' from the
middle, both bear N, and hold it by f_1 + f_2 = F at most 2 mu N; the moments are in balance with

    sliding, f_1 = f_2 = mu N:   N = F e'/l',   a = F (1 - 2 mu e'/l')/m     as long as mu < l'/(2 e')
    resting:                     N = (F e' + (f_2 - f_1) w'/2)/l'            possible where mu > l'/(2 e') or mu > l'/w'

Pulled nearer to its middle than w'/2 it may jam or slide in between, l'/w' < mu < l'/(2 e'): two sets of forces fit.
Source: statics of a body on two points.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_non_negative, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, HalfPlane

CLEARANCE = 1e-3  # chosen: on either side, of the width


@dataclass(frozen=True)
class JammingDrawer:
    """A drawer between two guides: bodies "left", "right" and "drawer", pulled along y.

    Parameters
    ----------
    l, w : float
        Length along the guides and width of the drawer [m].
    m : float
        Its mass [kg].
    mu : float
        Friction coefficient of the guides.
    F : float
        Pull [N].
    e : float
        Distance of the pull from the middle line [m].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import JammingDrawer
    >>> drawer = JammingDrawer(l=0.3, e=0.2)
    >>> [round(mu, 3) for mu in drawer.bounds()], drawer.outcome()
    ([0.595, 0.746], 'jams')
    """

    l: float = 0.3  # along the guides [m]
    w: float = 0.5  # between them [m]
    m: float = 2.0  # mass [kg]
    mu: float = 0.8  # friction [-]
    F: float = 20.0  # pull [N]
    e: float = 0.2  # of the pull from the middle [m]

    name = "jamming-drawer"
    source = "statics of a body on two points"
    t_end = 0.5  # s
    dt = 1e-4  # s

    def __post_init__(self) -> None:
        for name, unit in (("l", "m"), ("w", "m"), ("m", "kg"), ("F", "N"), ("e", "m")):
            as_positive(name, getattr(self, name), unit)
        as_non_negative("mu", self.mu)
        least = self.w * math.sqrt((1 + 2 * CLEARANCE) ** 2 - 1)
        if self.l < least:
            raise InvalidInput(
                f"l must be {least:.3g} m or more, or the drawer turns round in its guides; got {self.l:g}"
            )

    def scene(self) -> Scene:
        """The drawer at rest, turned so far that both corners touch; its pull keeps its direction."""
        scene = Scene(gravity=(0.0, 0.0), material=Material(mu=self.mu))
        half, th = 0.5 * self.w * (1 + 2 * CLEARANCE), self.tilt()
        scene.fixed(HalfPlane((1, 0)), position=(-half, 0.0), name="left")
        scene.fixed(HalfPlane((-1, 0)), position=(half, 0.0), name="right")
        scene.body(Box(self.w, self.l), mass=self.m, position=(0.0, 0.0), turn=th, name="drawer")
        place = self.e * math.cos(th), self.e * math.sin(th)
        scene.force("drawer", (0.0, self.F), at=place)
        return scene

    def tilt(self) -> float:
        """The angle at which two corners touch: w cos th + l sin th = the distance of the guides [rad]."""
        diagonal = math.hypot(self.w, self.l)
        return math.atan2(self.l, self.w) - math.acos(self.w * (1 + 2 * CLEARANCE) / diagonal)

    def arm(self) -> float:
        """The distance of the two corners along the guides [m]."""
        return self.l * math.cos(self.tilt()) - self.w * math.sin(self.tilt())

    def bounds(self) -> tuple[float, float]:
        """mu from which it may jam, and from which it must."""
        jams = self.arm() / (2 * self.e * math.cos(self.tilt()))
        return min(jams, self.arm() / (self.w * (1 + 2 * CLEARANCE))), jams

    def outcome(self) -> str:
        """What it does from rest: "slides", "slides or jams", "jams"."""
        possible, certain = self.bounds()
        return "slides" if self.mu < possible else "slides or jams" if self.mu < certain else "jams"

    def acceleration(self) -> float:
        """Of a drawer that slides [m/s^2]."""
        return self.F * (1 - self.mu / self.bounds()[1]) / self.m
