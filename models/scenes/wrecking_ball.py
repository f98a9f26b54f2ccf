"""A wrecking ball on a chain of links that swings against a wall of bricks.

Released straight, chain and ball turn about the hook nearly as one body, the more so the lighter the links are:

    I th'' = -S g sin th,    I = sum of m (k^2 + a^2),  S = sum of m a  over links and ball, at the distances a,

k the radius of gyration of a link; the ball is held at its centre and does not turn, k = 0. From rest at th_0 it hangs
straight after a quarter of the period, sqrt(I/(S g)) K(sin^2 (th_0/2)), K the complete elliptic integral of the first
kind, with the angular velocity 2 sqrt(S g/I) sin(th_0/2). Then it meets the wall.
Source: Whittaker, *Analytical Dynamics* (1937), section 44 (the pendulum by elliptic functions).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_count, as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, Disc, HalfPlane

THICKNESS = 0.04  # chosen: of a link [m]
BRICK_LENGTH, BRICK_HEIGHT = 0.5, 0.25  # chosen: of a brick of the wall [m]
EYES = 0.9  # chosen: of its pitch that a link is long: it hangs between two pins


@dataclass(frozen=True)
class WreckingBall:
    """A ball on a chain and a wall: bodies "link 0" to "link n-1", "ball", "brick 0" to the top.

    Parameters
    ----------
    n : int
        Number of links.
    l : float
        Length of a link, from pin to pin [m].
    r : float
        Radius of the ball [m].
    courses : int
        Bricks of the wall, one on the other.
    th_0 : float
        Angle at which it is released, from hanging, in (0, pi/2) [rad].
    density, density_w : float
        Of ball and links, of bricks [kg/m^2].
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
    >>> from nonsmooth.catalogue import WreckingBall
    >>> ball = WreckingBall()
    >>> round(ball.hit_time(), 4), round(ball.hit_speed(), 4)
    (0.9356, 5.493)
    """

    n: int = 8
    l: float = 0.4  # of a link [m]
    r: float = 0.35  # of the ball [m]
    courses: int = 8
    th_0: float = 1.0  # [rad]
    density: float = 7800.0  # iron [kg/m^2]
    density_w: float = 1800.0  # brick [kg/m^2]
    mu: float = 0.6  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "wrecking-ball"
    source = "the pendulum by elliptic functions: Whittaker, Analytical Dynamics (1937), section 44"
    t_end = 2.5  # s
    dt = 1e-3  # s

    def __post_init__(self) -> None:
        as_count("n", self.n)
        as_count("courses", self.courses)
        for name in ("l", "r"):
            as_positive(name, getattr(self, name), "m")
        if not self.r < self.l:
            raise InvalidInput(f"r must be below l, or the ball overlaps links; got {self.r:g} and {self.l:g} m")
        for name in ("density", "density_w"):
            as_positive(name, getattr(self, name), "kg/m^2")
        if not 0 < as_number("th_0", self.th_0, "rad") < math.pi / 2:
            raise InvalidInput(f"th_0 must lie in (0, pi/2) rad; got {self.th_0:g}")
        as_non_negative("mu", self.mu)
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The ball drawn aside with a straight chain, at rest; the wall stands where it hangs."""
        scene = Scene(gravity=(0.0, -self.g), material=Material(mu=self.mu))
        scene.fixed(HalfPlane((0, 1)), name="ground")
        height = self.n * self.l + 0.5 * self.courses * BRICK_HEIGHT
        scene.fixed(Disc(THICKNESS), position=(0.0, height), name="hook")
        s, c = math.sin(self.th_0), math.cos(self.th_0)

        def at(way: float) -> tuple[float, float]:
            return -way * s, height - way * c

        for k in range(self.n):
            link = Box(THICKNESS, EYES * self.l)
            scene.body(link, density=self.density, position=at((k + 0.5) * self.l), turn=-self.th_0, name=f"link {k}")
            scene.joint("hook" if k == 0 else f"link {k - 1}", f"link {k}", at=at(k * self.l), name=f"pin {k}")
        way = self.n * self.l
        scene.body(Disc(self.r), density=self.density, position=at(way), turn=-self.th_0, name="ball")
        scene.joint(f"link {self.n - 1}", "ball", at=at(way), name="shackle")
        for k in range(self.courses):
            place = (self.r + 0.5 * BRICK_LENGTH, (k + 0.5) * BRICK_HEIGHT)
            scene.body(Box(BRICK_LENGTH, BRICK_HEIGHT), density=self.density_w, position=place, name=f"brick {k}")
        return scene

    def moments(self) -> tuple[float, float]:
        """I [kg m^2] and S [kg m] of the straight chain and the ball about the hook."""
        link = self.density * THICKNESS * EYES * self.l
        ball, way = self.density * math.pi * self.r**2, self.n * self.l
        own = link * (THICKNESS**2 + (EYES * self.l) ** 2) / 12
        arms = [(k + 0.5) * self.l for k in range(self.n)]
        inertia = sum(own + link * arm**2 for arm in arms) + ball * way**2
        return inertia, link * sum(arms) + ball * way

    def hit_time(self) -> float:
        """When it hangs straight [s]."""
        inertia, moment = self.moments()
        a, b = 1.0, math.cos(0.5 * self.th_0)  # K(sin^2) = pi/2 over the arithmetic-geometric mean of 1 and cos
        while abs(a - b) > 1e-15 * a:
            a, b = 0.5 * (a + b), math.sqrt(a * b)
        return math.sqrt(inertia / (moment * self.g)) * math.pi / (a + b)

    def hit_speed(self) -> float:
        """Of the ball, then [m/s]."""
        inertia, moment = self.moments()
        return 2 * math.sqrt(moment * self.g / inertia) * math.sin(0.5 * self.th_0) * self.n * self.l
