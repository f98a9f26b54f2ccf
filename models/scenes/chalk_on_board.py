"""Chalk that is pushed over a board obliquely: the hand carries it, and presses it with F, as a weight does.

A rod of length l, whose ends are rounded by r, leans at th from the board with its tip on it, and slides without
turning, at phi from straight ahead: phi = 0 drives the tip into the board, phi = pi drags it behind. With s = l/2,
the normal n of the board, e from the tip to the middle, and the arm -s e - r n of the contact, a force n - mu d gives

    p = 1/m + s^2 cos^2 th/I - mu cos th cos phi (s^2 sin th + s r)/I,    gamma_N' = p la_N + b,    b = -F/m

Where p < 0 no force fits, and an impact without collision stops the tip. That is so for |phi| < phi_max alone.
Assumed here: a hand that neither turns the chalk nor holds it back.
Source: Champneys, Várkonyi, *IMA J. Appl. Math.* 81 (2016) 538 (chalk); p as in models/spatial_painleve_rod.py, there
with r = 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Capsule, HalfSpace


@dataclass(frozen=True)
class ChalkOnBoard:
    """Bodies "board" and "chalk"; the board is upright, and the chalk slides along y, towards z where phi > 0.

    Parameters
    ----------
    mu : float
        Coefficient of friction [-].
    th : float
        Angle between chalk and board [rad].
    phi : float
        Direction of the push, from straight ahead [rad].
    speed : float
        Of the push [m/s].
    F : float
        Force of the hand towards the board [N].
    m : float
        Mass [kg].
    l, r : float
        Length between the middles of the rounded ends, and their radius [m].

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> import math
    >>> from nonsmooth.catalogue import ChalkOnBoard
    >>> chalk = ChalkOnBoard(mu=2.0)
    >>> round(math.degrees(chalk.critical_azimuth()), 2), chalk.p() < 0
    (52.85, True)
    """

    mu: float = 2.0  # friction [-]
    th: float = math.pi / 3  # between chalk and board [rad]
    phi: float = 0.0  # of the push, from straight ahead [rad]
    speed: float = 0.5  # of the push [m/s]
    F: float = 1.0  # of the hand, towards the board [N]
    m: float = 0.01  # mass [kg]
    l: float = 0.08  # length between the middles of the ends [m]
    r: float = 0.004  # radius of the ends [m]

    name = "chalk-on-board"
    source = "after Champneys, Várkonyi, IMA J. Appl. Math. 81 (2016) 538"
    t_end = 0.02  # s
    dt = 1e-4  # s

    def __post_init__(self) -> None:
        as_non_negative("mu", self.mu)
        if not 0.0 < as_number("th", self.th, "rad") < 0.5 * math.pi:
            raise InvalidInput(f"th must lie between 0 and pi/2; got {self.th:g} rad")
        as_number("phi", self.phi, "rad")
        for name, unit in (("speed", "m/s"), ("F", "N"), ("m", "kg"), ("l", "m"), ("r", "m")):
            as_positive(name, getattr(self, name), unit)

    @property
    def inertia(self) -> float:
        """Moment of inertia across the chalk about its middle, of a slender rod [kg m^2]."""
        return self.m * self.l**2 / 12

    def p(self, phi: float | None = None) -> float:
        """How much a unit of normal force with its friction adds to the normal acceleration [1/kg]."""
        steep, levers = self._terms()
        return steep - self.mu * math.cos(self.phi if phi is None else phi) * levers

    def _terms(self) -> tuple[float, float]:
        """p without friction, and what mu cos phi takes of it."""
        s, I = 0.5 * self.l, self.inertia
        steep = 1.0 / self.m + (s * math.cos(self.th)) ** 2 / I
        return steep, math.cos(self.th) * (s * s * math.sin(self.th) + s * self.r) / I

    def critical_friction(self) -> float:
        """The friction above which the push straight ahead is a paradox [-]."""
        steep, levers = self._terms()
        return steep / levers

    def critical_azimuth(self) -> float | None:
        """phi_max, up to which the push is a paradox [rad]; None where none is."""
        least = self.critical_friction()
        return None if self.mu < least else math.acos(least / self.mu)

    def scene(self) -> Scene:
        """The chalk at its start."""
        scene = Scene(gravity=(-self.F / self.m, 0.0, 0.0), material=Material(mu=self.mu))
        scene.fixed(HalfSpace((1, 0, 0)), name="board")
        e = np.array((math.sin(self.th), math.cos(self.th), 0.0))  # from the tip
        axis = e + (1.0, 0.0, 0.0)  # half a turn about it brings the axis x of the capsule to e
        velocity = -self.speed * np.array((0.0, math.cos(self.phi), math.sin(self.phi)))
        I = self.inertia
        scene.body(
            Capsule(self.l, self.r), mass=self.m, inertia=np.diag((0.5 * self.m * self.r**2, I, I)), name="chalk",
            position=0.5 * self.l * e + (self.r, 0.0, 0.0), turn=(0.0, *axis / np.linalg.norm(axis)),
            velocity=velocity,
        )  # fmt: skip
        return scene
