"""A double pendulum of two uniform rods.

Small swings about hanging straight down are two modes, w^2 the eigenvalues of

    M = m l^2 [4/3 1/2; 1/2 1/3],   K = m g l diag(3/2, 1/2)    of two equal rods:  w^2 = (3 +- 6/sqrt(7)) g/l

of any lengths and masses those of the same two matrices; the lower mode has both rods on one side. From larger angles
it is chaotic: two runs part by a factor e within about a swing.
Source: Landau, Lifshitz, *Mechanics* (1976), section 5, problem 1, with rods for points.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_number, as_positive
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, Disc

SLENDER = 0.05  # chosen: thickness of a rod, of its length


@dataclass(frozen=True)
class DoublePendulum:
    """Two rods on two pins, at rest: bodies "hook", "upper", "lower", joints "hip", "knee".

    Parameters
    ----------
    l_1, l_2 : float
        Lengths of the upper and the lower rod, from pin to pin [m].
    m_1, m_2 : float
        Their masses [kg].
    th_1, th_2 : float
        Their angles at the start, from hanging [rad].
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import DoublePendulum
    >>> import numpy as np
    >>> (DoublePendulum(l_2=1.0, m_2=1.0).frequencies() ** 2 / 9.81).round(6).tolist()
    [0.732213, 5.267787]
    """

    l_1: float = 1.0  # upper rod [m]
    l_2: float = 0.8  # lower rod [m]
    m_1: float = 1.0  # upper rod [kg]
    m_2: float = 0.8  # lower rod [kg]
    th_1: float = 2.0  # [rad]
    th_2: float = 2.5  # [rad]
    g: float = 9.81  # gravity [m/s^2]

    name = "double-pendulum"
    source = "Landau, Lifshitz, Mechanics (1976), section 5, problem 1, with rods for points"
    t_end = 5.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        for name, unit in (("l_1", "m"), ("l_2", "m"), ("m_1", "kg"), ("m_2", "kg"), ("g", "m/s^2")):
            as_positive(name, getattr(self, name), unit)
        for name in ("th_1", "th_2"):
            as_number(name, getattr(self, name), "rad")

    def scene(self) -> Scene:
        """The rods at rest at their angles; slender, their moments of inertia those of lines."""
        scene, pin = Scene(gravity=(0.0, -self.g)), np.zeros(2)
        scene.fixed(Disc(SLENDER * self.l_1), name="hook")
        above = "hook"
        for name, joint, l, m, th in (
            ("upper", "hip", self.l_1, self.m_1, self.th_1), ("lower", "knee", self.l_2, self.m_2, self.th_2),
        ):  # fmt: skip
            along = np.array([math.sin(th), -math.cos(th)])
            scene.body(
                Box(SLENDER * l, l), mass=m, inertia=m * l * l / 12, position=pin + 0.5 * l * along, turn=th, name=name
            )
            scene.joint(above, name, at=pin, name=joint)
            above, pin = name, pin + l * along
        scene.ignore("hook", "lower")
        return scene

    def matrices(self) -> tuple[np.ndarray, np.ndarray]:
        """M and K (2, 2) of small angles [kg m^2], [N m]."""
        l, L, m, n = self.l_1, self.l_2, self.m_1, self.m_2
        mass = np.array([[(m / 3 + n) * l * l, n * l * L / 2], [n * l * L / 2, n * L * L / 3]])
        return mass, self.g * np.diag([(m / 2 + n) * l, n * L / 2])

    def frequencies(self) -> np.ndarray:
        """The angular frequencies of small swings, the lower one first [rad/s]."""
        mass, stiffness = self.matrices()
        return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real))

    def mode(self, k: int) -> np.ndarray:
        """The angles (2,) of mode k, the upper one 1."""
        mass, stiffness = self.matrices()
        squares, shapes = np.linalg.eig(np.linalg.solve(mass, stiffness))
        shape = shapes[:, np.argsort(squares.real)[k]].real
        return np.asarray(shape / shape[0])
