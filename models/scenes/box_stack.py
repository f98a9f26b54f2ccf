"""Cubes stacked on the ground, in the plane or in space; the top one may be much heavier.

    P_N of the contact below cube k = dt g (m_k + ... + m_n),    v = 0

A stack at rest stays: nothing but the solution of its contact problems decides. A heavy cube on light ones is what
sweeps from contact to contact do not solve, each cube sees only its neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_count, as_non_negative, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, HalfPlane, HalfSpace


@dataclass(frozen=True)
class BoxStack:
    """Cubes stacked on the ground: bodies "box 0" (the lowest) to "box n-1".

    Parameters
    ----------
    n : int
        Number of cubes.
    a : float
        Edge [m].
    density : float
        Density [kg/m^3], in the plane [kg/m^2].
    mu : float
        Friction coefficient.
    top_ratio : float
        Mass of the top cube, of that of the others.
    g : float
        Gravity [m/s^2].
    dim : int
        2 for the plane, 3 for space.

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> from nonsmooth.catalogue import BoxStack
    >>> stack = BoxStack(n=3, dim=2)
    >>> sol = ns.simulate(stack, (0, 0.1), integrator=ns.MoreauJean(dt=stack.dt))
    >>> bool(abs(sol.position[-1] - sol.position[0]).max() < 1e-12)
    True
    """

    n: int = 10
    a: float = 0.2  # edge [m]
    density: float = 1000.0  # [kg/m^3]
    mu: float = 0.5  # friction [-]
    top_ratio: float = 1.0  # [-]
    g: float = 9.81  # gravity [m/s^2]
    dim: int = 3

    name = "box-stack"
    source = "the stack of ten cubes by which solvers of contact problems are compared"
    t_end = 10.0  # s
    dt = 2e-3  # s

    def __post_init__(self) -> None:
        as_count("n", self.n)
        as_positive("a", self.a, "m")
        as_positive("density", self.density, "kg/m^3")
        as_non_negative("mu", self.mu)
        as_positive("top_ratio", self.top_ratio)
        as_positive("g", self.g, "m/s^2")
        if self.dim not in (2, 3):
            raise InvalidInput(f"dim must be 2 (plane) or 3 (space); got {self.dim}")

    def scene(self) -> Scene:
        """The stack, at rest on the ground."""
        up = np.eye(self.dim)[-1]
        scene = Scene(gravity=-self.g * up, material=Material(mu=self.mu))
        scene.fixed(HalfPlane(up) if self.dim == 2 else HalfSpace(up), name="ground")
        for k, (height, mass) in enumerate(zip(self.heights(), self.masses(), strict=True)):
            scene.body(Box(*[self.a] * self.dim), mass=mass, position=height * up, name=f"box {k}")
        return scene

    def heights(self) -> np.ndarray:
        """Of the centres (n,) [m]."""
        return self.a * (np.arange(self.n) + 0.5)

    def masses(self) -> np.ndarray:
        """(n,) [kg]."""
        masses = np.full(self.n, self.density * self.a**self.dim)
        masses[-1] *= self.top_ratio
        return masses

    def loads(self) -> np.ndarray:
        """Force between each cube and what it stands on (n,) [N]."""
        return self.g * np.cumsum(self.masses()[::-1])[::-1]
