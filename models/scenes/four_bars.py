"""A row of four-bar linkages that share their cranks: they fall from upright, and lie flat in one line twice a turn.

All cranks are parallel, so that the row is one pendulum with the angle th from upright,

    (n + 1)/3 + n = a,  (n + 1)/2 + n = b:    a l th'' = b g sin th,    a l th'^2/2 + b g cos th = constant

of n loops. Where the bars lie flat every joint may also turn the other way, into an antiparallelogram: the equations of
closure are singular there, and redundant nowhere else. A step passes over that place, and momentum takes it through.
Source: IFToMM, *Library of Computational Benchmark Problems*, A02; González, Dopico, Lugrís, Cuadrado, *Multibody Syst.
Dyn.* 16 (2006) 179.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_count, as_number, as_positive
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, Disc

SLENDER = 0.05  # chosen: thickness of a bar, of its length


@dataclass(frozen=True)
class FourBars:
    """n four-bar linkages in a row: bodies "crank 0" to "crank n" and "coupler 1" to "coupler n".

    Parameters
    ----------
    n : int
        Loops.
    l : float
        Length of a bar [m].
    m : float
        Mass of a bar [kg].
    v_0 : float
        Velocity of the upper ends at the start, along the row [m/s].
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import FourBars
    >>> round(FourBars(n=2).rate(1.5707963267948966), 6)  # where the bars lie flat
    4.88774
    """

    n: int = 2  # loops
    l: float = 1.0  # of a bar [m]
    m: float = 1.0  # of a bar [kg]
    v_0: float = 1.0  # of the upper ends [m/s]
    g: float = 9.81  # gravity [m/s^2]

    name = "four-bars"
    source = "IFToMM, Library of Computational Benchmark Problems, A02"
    t_end = 2.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_count("n", self.n)
        as_positive("l", self.l, "m")
        as_positive("m", self.m, "kg")
        as_number("v_0", self.v_0, "m/s")
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The cranks upright, the couplers between their upper ends; bars pass through one another."""
        scene, l, v, bar = Scene(gravity=(0.0, -self.g)), self.l, self.v_0, Box(self.l, SLENDER * self.l)
        scene.fixed(Disc(SLENDER * l), position=(0.0, 0.0), name="ground")
        inertia = self.m * l * l / 12
        for k in range(self.n + 1):
            scene.body(
                bar, mass=self.m, inertia=inertia, position=(k * l, 0.5 * l), turn=0.5 * math.pi,
                velocity=(0.5 * v, 0.0), spin=-v / l, name=f"crank {k}",
            )  # fmt: skip
            scene.joint("ground", f"crank {k}", at=(k * l, 0.0), name=f"foot {k}")
        for k in range(1, self.n + 1):
            coupler = f"coupler {k}"
            scene.body(bar, mass=self.m, inertia=inertia, position=((k - 0.5) * l, l), velocity=(v, 0.0), name=coupler)
            scene.joint(f"crank {k - 1}", coupler, at=((k - 1) * l, l), name=f"left {k}")
            scene.joint(coupler, f"crank {k}", at=(k * l, l), name=f"right {k}")
        scene.ignore(*(body.name for body in scene.bodies))
        return scene

    def rate(self, th: float) -> float:
        """The size of th' at an angle from upright [rad/s]."""
        a, b = (self.n + 1) / 3 + self.n, (self.n + 1) / 2 + self.n
        return math.sqrt((self.v_0 / self.l) ** 2 + 2 * b / a * self.g / self.l * (1 - math.cos(th)))
