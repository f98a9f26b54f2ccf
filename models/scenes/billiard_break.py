"""The break of a game of pool: a ball runs into fifteen that stand in a triangle, on a table with four cushions.

The impact runs through the triangle from ball to ball, which a step resolves if the spaces between them are wider than
the way of a ball in it, gap > v_0 dt. With a longer step they are hit at once, and the cue ball rebounds as from one
heavy body (see Newton's cradle).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_count, as_fraction, as_non_negative, as_number, as_positive
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import HalfSpace, Sphere

RADIUS, MASS = 0.028575, 0.170  # defined: of a ball, World Pool-Billiard Association: 2.25 in, 5.5 to 6 oz [m, kg]
LENGTH, WIDTH = 2.54, 1.27  # defined: of the table between cushions, by the same rules, 100 in x 50 in [m]


@dataclass(frozen=True)
class BilliardBreak:
    """The break: bodies "cue ball", and "ball 1" (the foremost) to "ball 15".

    Parameters
    ----------
    rows : int
        Of the triangle.
    v_0 : float
        Speed of the cue ball [m/s].
    aside : float
        Of its path from the axis of the table [m].
    gap : float
        Between neighbours in the triangle [m].
    e : float
        Restitution coefficient (Newton) of balls.
    mu_b, mu_t : float
        Friction coefficients: ball on ball, ball on cloth.
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import BilliardBreak
    >>> BilliardBreak().scene()
    Scene(spatial, 21 bodies, 16 of them dynamic)
    """

    rows: int = 5
    v_0: float = 8.0  # [m/s]
    aside: float = 0.0  # [m]
    gap: float = 2e-4  # [m]
    e: float = 0.95  # restitution [-]
    mu_b: float = 0.06  # ball on ball [-]
    mu_t: float = 0.2  # ball on cloth [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "billiard-break"
    source = "sizes by the rules of the World Pool-Billiard Association"
    t_end = 0.6  # s
    dt = 2e-5  # s

    def __post_init__(self) -> None:
        as_count("rows", self.rows)
        as_positive("v_0", self.v_0, "m/s")
        as_number("aside", self.aside, "m")
        as_non_negative("gap", self.gap, "m")
        as_fraction("e", self.e)
        as_non_negative("mu_b", self.mu_b)
        as_non_negative("mu_t", self.mu_t)
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The cue ball rolls along the table towards the triangle, at x > 0."""
        ivory, cloth = Material(mu=self.mu_b, e=self.e, name="ball"), Material(mu=self.mu_t, name="cloth")
        cushion = Material(mu=self.mu_t, e=self.e, name="cushion")
        scene = Scene(gravity=(0.0, 0.0, -self.g), material=ivory)
        scene.pair(ivory, cloth, mu=self.mu_t, e=0.0)
        scene.fixed(HalfSpace((0, 0, 1)), material=cloth, name="table")
        for name, normal, half in (
            ("head", (1, 0, 0), LENGTH / 2), ("foot", (-1, 0, 0), LENGTH / 2),
            ("left", (0, 1, 0), WIDTH / 2), ("right", (0, -1, 0), WIDTH / 2),
        ):  # fmt: skip
            scene.fixed(HalfSpace(normal, -half), material=cushion, name=name)
        scene.body(
            Sphere(RADIUS), mass=MASS, position=(-LENGTH / 4, self.aside, RADIUS), velocity=(self.v_0, 0, 0),
            spin=(0, self.v_0 / RADIUS, 0), name="cue ball",
        )  # fmt: skip
        for k, (x, y) in enumerate(self.triangle()):
            scene.body(Sphere(RADIUS), mass=MASS, position=(x, y, RADIUS), name=f"ball {k + 1}")
        return scene

    def triangle(self) -> np.ndarray:
        """Places of the balls, row by row from the foremost (n, 2) [m]."""
        pitch = 2 * RADIUS + self.gap
        rows = [(row, k - 0.5 * row) for row in range(self.rows) for k in range(row + 1)]
        return np.array([(LENGTH / 4 + row * pitch * np.sqrt(0.75), k * pitch) for row, k in rows])

    def energy(self) -> float:
        """Of the cue ball that rolls, at the start, (7/10) m v^2 [J]."""
        return 0.7 * MASS * self.v_0**2
