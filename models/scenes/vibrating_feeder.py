"""A part on a plate that shakes along an oblique line: it sticks, slides and hops, and is conveyed.

    plate: (X, Y) = a sin(w t) (cos beta, sin beta);    sticks while  -s_- <= sin(w t) <= s_+
    s_+ = mu g/(a w^2 (cos beta + mu sin beta)),    s_- = mu g/(a w^2 (cos beta - mu sin beta))
    slides with v' = -X'' -+ mu (g + Y''),    hops at sin(w t) = 1/Gamma,  Gamma = a w^2 sin beta/g

with v against the plate. It lands without a rebound; friction takes up to mu times the normal jump of its velocity.
Each phase has a closed form, and its end a root. Below Gamma = 1 it never hops, below s_+ = 1 it rests on the plate.
Source: Blekhman, *Vibrational Mechanics* (World Scientific, 2000), on vibrational displacement.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, Disc

UPRIGHT = 0.5 * math.pi  # derived
PLATE = 1e3  # chosen: so heavy that a part is no load on its spring [kg]
LOOKS = 2000  # chosen: looks for the end of a phase in a period


@dataclass(frozen=True)
class VibratingFeeder:
    """Bodies "frame", "plate", heavy, on a spring, and "part", a flat box that does not tip; x points ahead.

    Parameters
    ----------
    a : float
        Amplitude along the line [m].
    w : float
        Angular frequency [rad/s].
    beta : float
        Of the line over the plate [rad].
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
    >>> from nonsmooth.catalogue import VibratingFeeder
    >>> round(VibratingFeeder().throw(), 4), VibratingFeeder(a=3e-5).speed(periods=10)
    (1.5091, 0.0)
    """

    a: float = 3e-4  # amplitude [m]
    w: float = 314.159265358979  # 50 Hz [rad/s]
    beta: float = math.pi / 6  # of the line [rad]
    mu: float = 0.4  # friction [-]
    g: float = 9.81  # gravity [m/s^2]

    name = "vibrating-feeder"
    source = "Blekhman, Vibrational Mechanics (World Scientific, 2000)"
    t_end = 0.4  # s
    dt = 1e-4  # s

    def __post_init__(self) -> None:
        for name, unit in (("a", "m"), ("w", "rad/s"), ("g", "m/s^2")):
            as_positive(name, getattr(self, name), unit)
        as_non_negative("mu", self.mu)
        if not 0.0 <= as_number("beta", self.beta, "rad") < UPRIGHT:
            raise InvalidInput(f"beta must be in [0, pi/2) rad; got {self.beta:g}")

    def scene(self) -> Scene:
        """The part at rest on the plate, which begins to move at its largest speed."""
        scene = Scene(gravity=(0.0, -self.g), material=Material(mu=self.mu))
        line = np.array([math.cos(self.beta), math.sin(self.beta)])
        scene.fixed(Disc(0.005), position=(-0.6, -0.1), name="frame")
        going = {"velocity": self.a * self.w * line}
        scene.body(Box(1.0, 0.01), mass=PLATE, position=(0.0, -0.005), name="plate", **going)
        rail, stiffness = scene.slider("frame", "plate", axis=line, name="rail"), PLATE * self.w**2
        rail.spring(stiffness=stiffness, rest=PLATE * self.g * line[1] / stiffness)  # its weight is in balance
        scene.body(Box(0.04, 0.01), mass=0.01, position=(0.0, 0.005), name="part", **going)
        return scene

    def throw(self) -> float:
        """Gamma; above 1 it hops."""
        return self.a * self.w**2 * math.sin(self.beta) / self.g

    def speed(self, periods: int = 100) -> float:
        """The mean speed of conveying, of the second half of so many periods [m/s]."""
        T = 2.0 * math.pi / self.w
        half, end = self.way(np.array([0.5 * periods * T, periods * T]))
        return float(end - half) / (0.5 * periods * T)

    def way(self, times: np.ndarray) -> np.ndarray:
        """How far it is along the plate from its start at times that increase [m]."""
        t, x, v, found = 0.0, 0.0, 0.0, np.zeros(len(times))
        while t <= times[-1]:
            place, rate, end, v_end = self._phase(t, v)
            inside = (times >= t) & (times <= end)
            found[inside] = x + np.array([place(time) for time in times[inside]])
            t, x, v = end, x + place(end), rate(end) if v_end is None else v_end
        return found

    def _plate(self, t: float, derivative: int = 0) -> tuple[float, float]:
        """X and Y, or their first or second derivative."""
        size = self.a * self.w**derivative * math.sin(self.w * t + 0.5 * math.pi * derivative)
        return size * math.cos(self.beta), size * math.sin(self.beta)

    def _phase(self, t: float, v: float) -> tuple[Callable, Callable, float, float | None]:
        """Place and velocity along the plate from t on, when that ends, and with which velocity if not that."""
        X, Y = self._plate(t)
        X_1, Y_1 = self._plate(t, 1)
        X_2, Y_2 = self._plate(t + 1e-9 / self.w, 2)  # just after: phases end where a sign changes
        N = self.g + Y_2

        def moves(push: float) -> tuple[Callable, Callable]:
            def rate(s: float) -> float:
                now = self._plate(s, 1)
                return v - push * (self.g * (s - t) + now[1] - Y_1) - (now[0] - X_1)

            def place(s: float) -> float:
                tau, now = s - t, self._plate(s)
                falls = 0.5 * self.g * tau**2 + now[1] - Y - Y_1 * tau
                return v * tau - push * falls - (now[0] - X - X_1 * tau)

            return place, rate

        if N <= 0.0:
            place, rate = moves(0.0)
            lands = self._first(lambda s: self._plate(s)[1] - Y - Y_1 * (s - t) + 0.5 * self.g * (s - t) ** 2, t)
            down = self.g * (lands - t) - Y_1 + self._plate(lands, 1)[1]
            return place, rate, lands, math.copysign(max(0.0, abs(rate(lands)) - self.mu * down), rate(lands))
        lifts = self._first(lambda s: -(self.g + self._plate(s, 2)[1]), t)
        if v == 0.0 and abs(X_2) <= self.mu * N:
            slips = self._first(lambda s: abs(self._plate(s, 2)[0]) - self.mu * (self.g + self._plate(s, 2)[1]), t)
            return lambda s: 0.0, lambda s: 0.0, min(slips, lifts), 0.0
        sense = math.copysign(1.0, v if v != 0.0 else -X_2)
        place, rate = moves(sense * self.mu)
        stops = self._first(lambda s: -sense * rate(s), t)
        return place, rate, min(stops, lifts), 0.0 if stops <= lifts else None

    def _first(self, claim: Callable[[float], float], t: float) -> float:
        """When a function that is not above 0 just after t next becomes so, within a period; else its end."""
        from scipy.optimize import brentq

        step = 2.0 * math.pi / self.w / LOOKS
        before = t + 1e-6 * step
        for k in range(1, LOOKS + 1):
            after = t + k * step
            if claim(after) > 0.0:
                return float(brentq(claim, before, after, xtol=1e-15)) if claim(before) <= 0.0 else before
            before = after
        return t + LOOKS * step
