"""Friction in the pin of a hinge, in proportion to what the pin bears.

    |M| <= r mu/sqrt(1 + mu^2) |R|

The pin of radius r touches its bore in a point, where |T| <= mu N; R^2 = N^2 + T^2 and M = r T. A pendulum rests where
its weight is no farther from the middle of the pin than r sin(atan mu).
Source: Timoshenko and Young, *Engineering Mechanics* (1956), section 3.5 (circle of friction).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_positive


@dataclass(frozen=True)
class PinFriction:
    """Coulomb friction in the pin of a hinge.

    Parameters
    ----------
    mu : float
        Coefficient of friction [-].
    radius : float
        Of the pin [m].

    Raises
    ------
    InvalidInput
        For numbers that are not positive.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> scene = ns.Scene(gravity=(0, -10.0))
    >>> hook = scene.fixed(ns.Disc(0.01), name="hook")
    >>> wheel = scene.body(ns.Disc(0.2), mass=2.0, inertia=0.1, spin=1.0, name="wheel")
    >>> scene.hinge("hook", "wheel", at=(0, 0), friction=ns.PinFriction(mu=0.75, radius=0.01))
    Hinge('joint 0', 'hook', 'wheel')
    >>> spin = ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=0.01))["wheel"].spin
    >>> spin[[50, 100]].round(9).tolist()  # 0.01 m * 0.6 * 20 N / 0.1 kg m^2 = 1.2 rad/s^2, until it stops
    [0.4, 0.0]
    """

    mu: float
    radius: float

    def __post_init__(self) -> None:
        as_positive("mu of PinFriction", self.mu)
        as_positive("radius of PinFriction", self.radius, "m")

    @property
    def arm(self) -> float:
        """The radius of the circle of friction, r sin(atan mu) [m]."""
        return self.radius * self.mu / math.hypot(1.0, self.mu)
