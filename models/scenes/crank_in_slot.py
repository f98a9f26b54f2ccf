"""A slider-crank whose slider has clearance in its slot, as bodies: the machine of models/slider_crank.py.

Crank, rod and slider are boxes on pins, the slot two half-planes. What that model has as three angles and four gaps is
found here by the shapes: both are one motion, with the same laws of friction and impact.
Source: Flores, Leine, Glocker, *Multibody Syst. Dyn.* 23 (2010) 165, as in models/slider_crank.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_number
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, Disc, HalfPlane

from ..slider_crank import SliderCrank

THICKNESS = 0.01  # chosen: of crank and rod, which touch nothing [m]


@dataclass(frozen=True)
class CrankInSlot:
    """Bodies "frame", "crank", "rod", "slider" and the walls "below" and "above"; it coasts from its start.

    Parameters
    ----------
    c : float
        Clearance above, and below, the slider in the middle of the slot [m].
    mu, e : float
        Coefficients of friction and of restitution of the slider and its walls.
    th1dot, th2dot : float
        Rates of crank and rod at the start, where both lie along the slot [rad/s].
    g : float
        Gravity, across the slot [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import CrankInSlot
    >>> [body.name for body in CrankInSlot().scene().bodies]
    ['frame', 'below', 'above', 'crank', 'rod', 'slider']
    """

    c: float = 0.001  # clearance [m]
    mu: float = 0.01  # friction [-]
    e: float = 0.4  # restitution [-]
    th1dot: float = 150.0  # crank [rad/s]
    th2dot: float = -75.0  # rod [rad/s]
    g: float = 9.81  # gravity [m/s^2]

    name = "crank-in-slot"
    source = "Flores, Leine, Glocker, Multibody Syst. Dyn. 23 (2010) 165"
    t_end = 0.02  # s
    dt = 1e-5  # s

    def __post_init__(self) -> None:
        self.model()
        for name in ("th1dot", "th2dot"):
            as_number(name, getattr(self, name), "rad/s")

    def model(self) -> SliderCrank:
        """The same machine in three angles."""
        return SliderCrank(c=self.c, mu=self.mu, e=self.e, g=self.g)

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """q and u of that."""
        return self.model().state(th1dot=self.th1dot, th2dot=self.th2dot)

    def scene(self) -> Scene:
        """The machine at its start."""
        p, (q, u) = self.model(), self.start()
        scene = Scene(gravity=(0.0, -self.g), material=Material(mu=self.mu, e=self.e))
        scene.fixed(Disc(THICKNESS), name="frame")
        scene.fixed(HalfPlane((0, 1)), position=(0.0, -p.b - p.c), name="below")
        scene.fixed(HalfPlane((0, -1)), position=(0.0, p.b + p.c), name="above")
        pin, speed, before = np.zeros(2), np.zeros(2), "frame"
        for name, l, m, J, th, rate in (("crank", p.l1, p.m1, p.J1, q[0], u[0]), ("rod", p.l2, p.m2, p.J2, q[1], u[1])):
            along, across = np.array([math.cos(th), math.sin(th)]), np.array([-math.sin(th), math.cos(th)])
            scene.body(
                Box(l, THICKNESS), mass=m, inertia=J, position=pin + 0.5 * l * along, turn=th,
                velocity=speed + 0.5 * l * rate * across, spin=rate, name=name,
            )  # fmt: skip
            scene.joint(before, name, at=pin, name=f"pin of the {name}")
            pin, speed, before = pin + l * along, speed + l * rate * across, name
        scene.body(
            Box(2 * p.a, 2 * p.b), mass=p.m3, inertia=p.J3, position=pin, turn=q[2], velocity=speed, spin=u[2],
            name="slider",
        )  # fmt: skip
        scene.joint("rod", "slider", at=pin, name="pin of the slider")
        scene.ignore("frame", "crank", "rod", "below", "above")
        scene.ignore("frame", "crank", "rod", "slider")
        return scene

    def angles(self, bodies: object) -> np.ndarray:
        """The angles of crank, rod and slider of a run (m, 3), or at one time (3,)."""
        return np.stack([bodies[name].turn for name in ("crank", "rod", "slider")], axis=-1)  # type: ignore[index]
