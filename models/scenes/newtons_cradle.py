"""Equal balls in a row on a smooth table; the first comes sliding.

With spaces between them, pairs of balls collide one after the other, and for e = 1 the last one alone flies on:
v = (0, ..., 0, v_0). Touching, they are hit at once, and Newton's law asks of all contacts together

    u_plus >= -e u_minus  _|_  P >= 0,    u_minus = (-v_0, 0, ..., 0)

whose solution is another: all move on with v_0 (1 + e)/n but the first, which rebounds from them. No such law gives
what elastic spheres do when they touch: that is settled by the waves in them. Spaces much narrower than v_0 dt, the way
in a step, count as none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_count, as_fraction, as_non_negative, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Disc, HalfPlane, HalfSpace, Sphere


@dataclass(frozen=True)
class NewtonsCradle:
    """Equal balls in a row on a smooth table: bodies "ball 0", which comes sliding, to "ball n-1".

    Parameters
    ----------
    n : int
        Number of balls.
    r : float
        Radius [m].
    gap : float
        Between neighbours at rest [m]; 0: they touch.
    v_0 : float
        Speed of the first [m/s].
    e : float
        Restitution coefficient (Newton) of balls.
    g : float
        Gravity [m/s^2].
    dim : int
        2 for discs, 3 for spheres.

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import NewtonsCradle
    >>> NewtonsCradle(n=3, gap=0.01).velocities(), NewtonsCradle(n=3, gap=0.0).velocities().round(4)
    (array([0., 0., 1.]), array([-0.3333,  0.6667,  0.6667]))
    """

    n: int = 5
    r: float = 0.05  # [m]
    gap: float = 0.01  # [m]
    v_0: float = 1.0  # [m/s]
    e: float = 1.0  # restitution [-]
    g: float = 9.81  # gravity [m/s^2]
    dim: int = 3

    name = "newtons-cradle"
    source = "Brogliato, Nonsmooth Mechanics (2016), chapter 6"
    t_end = 1.0  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        if as_count("n", self.n) < 2:
            raise InvalidInput(f"a cradle has at least 2 balls; got n = {self.n}")
        as_positive("r", self.r, "m")
        as_non_negative("gap", self.gap, "m")
        as_positive("v_0", self.v_0, "m/s")
        as_fraction("e", self.e)
        as_positive("g", self.g, "m/s^2")
        if self.dim not in (2, 3):
            raise InvalidInput(f"dim must be 2 (plane) or 3 (space); got {self.dim}")

    def scene(self) -> Scene:
        """The balls along the x-axis; the first is two radii away from the others."""
        along, up = np.eye(self.dim)[0], np.eye(self.dim)[-1]
        scene = Scene(gravity=-self.g * up, material=Material(mu=0.0, e=self.e))
        table = HalfPlane(up, -self.r) if self.dim == 2 else HalfSpace(up, -self.r)
        scene.fixed(table, material=Material(mu=0.0, e=0.0), name="table")
        ball = Disc(self.r) if self.dim == 2 else Sphere(self.r)
        for k in range(self.n):
            x = k * (2 * self.r + self.gap) - (2 * self.r if k == 0 else 0.0)
            velocity = self.v_0 * along if k == 0 else None
            scene.body(ball, mass=1.0, position=x * along, velocity=velocity, name=f"ball {k}")
        return scene

    def velocities(self) -> np.ndarray:
        """After the collisions (n,) [m/s]; of spaced balls after the first collision of each pair."""
        n, e, v = self.n, self.e, np.zeros(self.n)
        if self.gap == 0.0:  # contacts 2, 3, ... only push: all move on together, the first rebounds from them
            v[:] = (1 + e) / n
            v[0] -= e
            return self.v_0 * v
        v[:-1] = 0.5 * (1 - e) * (0.5 * (1 + e)) ** np.arange(n - 1)
        v[-1] = (0.5 * (1 + e)) ** (n - 1)
        return self.v_0 * v

    def time(self) -> float:
        """When the last ball is hit, of spaced balls [s]."""
        speeds = self.v_0 * (0.5 * (1 + self.e)) ** np.arange(self.n - 1)
        ways = np.full(self.n - 1, self.gap)
        ways[0] += 2 * self.r
        return math.fsum(ways / speeds)
