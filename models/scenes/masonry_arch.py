"""A semicircular arch of stones: how thin may it be?

With joints that bear any pressure, no pull and no sliding, it stands if a line of thrust lies within it (the safe
theorem of plastic analysis). Stones are cut along radii, and the arch is symmetric: with a thrust H at the crown, at
height y_H, and weight W and centre x_c of the stones from there to a joint, the pressure in that joint lies between its
edges (x, y) if

    H (y_H - y) - W (x - x_c) >= 0 about the inner edge,    <= 0 about the outer one:    linear in (H, H y_H).

The thinnest arch of very many stones has t/R = 0.107478, R the radius of its middle line, with hinges 54.5 degrees
from the crown: Milankovitch, *Z. Math. Phys.* 55 (1907) 1-27; Cocchetti, Colasante and Rizzi, *Appl. Mech. Rev.* 64
(2012) 050802. Fewer stones have fewer joints that may open, and may be thinner: `least_ratio`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_count, as_non_negative, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, Polygon

LEAST_RATIO = 0.107478  # derived: t/R of very many stones, by the sources above
HALVINGS = 40  # chosen: of the interval (0, 1) in which the least ratio of some stones lies: to 1e-12


@dataclass(frozen=True)
class MasonryArch:
    """A semicircular arch between two abutments: bodies "stone 0" (right) to "stone n-1" (left).

    Parameters
    ----------
    n : int
        Number of stones.
    R : float
        Radius of the middle line [m].
    ratio : float
        Thickness, of R.
    density : float
        Density [kg/m^2].
    mu : float
        Friction coefficient; 0.4 keeps the joints from sliding.
    g : float
        Gravity [m/s^2].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import MasonryArch
    >>> arch = MasonryArch(n=21, ratio=0.12)
    >>> arch.stands(), MasonryArch(n=21, ratio=0.10).stands()
    (True, False)
    >>> round(MasonryArch(n=400).least_ratio(), 5)
    0.10748
    """

    n: int = 21
    R: float = 5.0  # radius of the middle line [m]
    ratio: float = 0.12  # t/R [-]
    density: float = 2000.0  # [kg/m^2]
    mu: float = 0.7  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "masonry-arch"
    source = "Milankovitch (1907); Cocchetti, Colasante and Rizzi, Appl. Mech. Rev. 64 (2012) 050802"
    t_end = 5.0  # s
    dt = 2e-3  # s

    def __post_init__(self) -> None:
        if as_count("n", self.n) < 2:
            raise InvalidInput(f"an arch has at least 2 stones; got n = {self.n}")
        as_positive("R", self.R, "m")
        if not as_positive("ratio", self.ratio) < 1:
            raise InvalidInput(f"ratio must be below 1, of the radius; got {self.ratio:g}")
        as_positive("density", self.density, "kg/m^2")
        as_non_negative("mu", self.mu)
        as_positive("g", self.g, "m/s^2")

    def scene(self) -> Scene:
        """The arch as it is drawn, its stones in the coordinates of the drawing."""
        scene = Scene(gravity=(0.0, -self.g), material=Material(mu=self.mu))
        inner, outer = self.R * (1 - 0.5 * self.ratio), self.R * (1 + 0.5 * self.ratio)
        width = 4 * (outer - inner)
        for side, name in ((1, "right abutment"), (-1, "left abutment")):
            scene.fixed(Box(width, 0.5 * width), position=(side * self.R, -0.25 * width), name=name)
        joints = np.linspace(0.0, math.pi, self.n + 1)
        rays = np.stack([np.cos(joints), np.sin(joints)], axis=1)
        rays[-1, 1] = 0.0  # the last joint lies on the abutment, as the first does
        for k in range(self.n):
            corners = [inner * rays[k], outer * rays[k], outer * rays[k + 1], inner * rays[k + 1]]
            scene.body(Polygon(corners), density=self.density, position=(0, 0), name=f"stone {k}")
        return scene

    def stands(self, ratio: float | None = None) -> bool:
        """Whether a line of thrust lies within the arch, of its own ratio or another."""
        rows = self._conditions(self.ratio if ratio is None else ratio)
        # rows a H + b H y <= c: the least violation s of all, by a linear program in (H, H y, s)
        from scipy.optimize import linprog

        scale = np.abs(rows).max(axis=1, keepdims=True)
        rows = rows / np.where(scale > 0, scale, 1.0)
        columns = np.hstack([rows[:, :2], -np.ones((len(rows), 1))])
        bounds = [(0, None), (None, None), (-1, 1)]
        found = linprog([0, 0, 1], A_ub=columns, b_ub=rows[:, 2], bounds=bounds, method="highs-ds")
        return bool(found.x[2] <= 0)

    def least_ratio(self) -> float:
        """The least t/R at which it stands, with its own number of stones."""
        low, high = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self.stands(middle) else (middle, high)
        return high

    def _conditions(self, ratio: float) -> np.ndarray:
        """Rows (a, b, c) of a H + b (H y) <= c, with R = 1 and areas for weights."""
        inner, outer = 1 - 0.5 * ratio, 1 + 0.5 * ratio
        edges = np.linspace(0.0, math.pi, self.n + 1)
        rays = np.stack([np.cos(edges), np.sin(edges)], axis=1)
        right = range((self.n + 1) // 2)
        stones = [stone(inner, outer, rays[k], rays[k + 1]) for k in right]
        rows = [[inner, -1.0, 0.0], [-outer, 1.0, 0.0]]  # of the joint at the crown
        if self.n % 2:  # there is none: the crown cuts its stone into two
            stones[-1] = right_half(inner, outer, rays[right[-1]], rays[right[-1] + 1])
            rows = []
        weight = moment = 0.0
        for k in reversed(right):
            area, x_c = stones[k]
            weight += area
            moment += area * x_c
            for radius, sign in ((inner, 1.0), (outer, -1.0)):
                x, y = radius * rays[k]
                # about (x, y), turning to the outer side: H (y_H - y) - W (x - x_c): >= 0 inside, <= 0 outside
                rows.append([sign * y, -sign, sign * (moment - weight * x)])
        return np.array(rows)


def stone(inner: float, outer: float, a: np.ndarray, b: np.ndarray) -> tuple[float, float]:
    """Area and x of the centre of a stone between two rays."""
    return area_and_centre(np.array([inner * a, outer * a, outer * b, inner * b]))


def right_half(inner: float, outer: float, a: np.ndarray, b: np.ndarray) -> tuple[float, float]:
    """Of the stone at the crown, whose faces are chords."""
    top, bottom = 0.5 * outer * (a + b), 0.5 * inner * (a + b)
    return area_and_centre(np.array([inner * a, outer * a, top, bottom]))


def area_and_centre(corners: np.ndarray) -> tuple[float, float]:
    """Of a polygon, by Gauss's formula: area, and x of its centre."""
    after = np.roll(corners, -1, axis=0)
    cross = corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0]
    return 0.5 * float(cross.sum()), float(((corners[:, 0] + after[:, 0]) * cross).sum() / (3 * cross.sum()))
