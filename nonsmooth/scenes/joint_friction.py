"""Friction in joints, in proportion to what they bear.

    pin, ball    |M| <= r mu/sqrt(1 + mu^2) |R|
    guide        |F| <= mu (|N_1| + |N_2|),    N_1, N_2 = R/2 +- M x e/h

The pin of radius r touches its bore in a point, where |T| <= mu N; R^2 = N^2 + T^2 and M = r T. A pendulum rests where
its weight is no farther from the middle of the pin than r sin(atan mu). A ball of radius r touches its socket in a
point too, so M is across R, and about R there is none.

The guide of length h along the axis e touches in its two ends: R = N_1 + N_2 is what they bear across the axis, and
M = (h/2) e x (N_1 - N_2) about its middle. In the plane |N_1| + |N_2| = max(|R|, 2 |M|/h). A drawer that a force pulls
along its guide, at a distance l from the middle, bears M = l F: it jams where mu 2 l F/h >= F, mu >= h/(2 l), however
hard one pulls.
Source: Timoshenko and Young, *Engineering Mechanics* (1956), section 3.5 (circle of friction).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.checks.arrays import as_non_negative, as_positive


@dataclass(frozen=True)
class PinFriction:
    """Coulomb friction in the pin of a hinge, or, in space, in the ball of a joint.

    Parameters
    ----------
    mu : float
        Coefficient of friction [-].
    radius : float
        Of the pin or the ball [m].

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


@dataclass(frozen=True)
class GuideFriction:
    """Coulomb friction in the guide of a slider, which touches in its two ends.

    The guide goes with the second body, and its middle is where the joint acts. What a torque about the axis presses is
    not counted.

    Parameters
    ----------
    mu : float
        Coefficient of friction [-].
    length : float
        Of the guide along the axis [m]; 0: it touches in one point, and moments press nothing.

    Raises
    ------
    InvalidInput
        For mu that is not positive, and for a length < 0.

    Examples
    --------
    >>> import nonsmooth as ns
    >>> scene = ns.Scene(gravity=(0, 0))
    >>> desk = scene.fixed(ns.Disc(0.01), name="desk")
    >>> drawer = scene.body(ns.Box(0.4, 0.6), mass=2.0, name="drawer")
    >>> scene.slider("desk", "drawer", axis=(1, 0), friction=ns.GuideFriction(mu=0.5, length=0.4))
    Slider('joint 0', 'desk', 'drawer')
    >>> scene.force("drawer", (10.0, 0), at=(0.2, 0.3))  # it slides as long as mu < 0.4/(2 * 0.3) = 2/3
    Force('drawer', [10.  0.])
    >>> sol = ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=0.01))
    >>> round(float(sol["drawer"].velocity[-1, 0]), 9)  # (10 N - 0.5 * 2 * 3 N m/0.4 m)/2 kg = 1.25 m/s^2
    1.25
    """

    mu: float
    length: float = 0.0

    def __post_init__(self) -> None:
        as_positive("mu of GuideFriction", self.mu)
        as_non_negative("length of GuideFriction", self.length)


JointFriction = PinFriction | GuideFriction
