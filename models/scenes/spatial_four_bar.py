"""A spatial four-bar RSSR whose hinges seize: crank and follower turn on thick pins, a rod with two balls joins them.

The crank turns by theta about z at the origin, the follower by psi about -y at (D, 0, 0), so that

    P = A (cos theta, sin theta, 0),    Q = (D + C cos psi, 0, C sin psi),    |Q - P| = B

The rod has no mass, so it pushes with F along n = (Q - P)/B, and its balls have no friction; crank and follower are
balanced, and there is no gravity: each pin bears |F| k, k the part of n across its axis. With h the arms of n,
tau = psi'/theta' = h_A/h_C, and l the radii of the circles of friction,

    I_A theta'' = T - F h_A - s_A l_A k_A |F|,    I_C psi'' = F h_C - s_C l_C k_C |F|,    psi'' = tau theta'' + b
    p F + q |F| = tau T/I_A + b,    p = h_C/I_C + tau h_A/I_A,    q = tau s_A l_A k_A/I_A - s_C l_C k_C/I_C

has one F where |q| < |p|, and else none or two: Painlevé's paradox, near where the follower is dead. Friction of the
crank makes up for some of it. Assumed here: where the axes are, the masses, and balls without friction.
Source: Cremasco Coelho, *Mech. Mach. Theory* 215 (2025) 106163 (that it has paradoxes; lengths, radii and friction).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.joint_friction import PinFriction
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Capsule, Sphere

CRANK_AXIS, FOLLOWER_AXIS = np.array((0.0, 0.0, 1.0)), np.array((0.0, -1.0, 0.0))  # defined


@dataclass(frozen=True)
class SpatialFourBar:
    """Bodies "frame", "crank" and "follower", joined by hinges of their names and by the distance "rod".

    Parameters
    ----------
    A, B, C, D : float
        Crank, rod, follower, and the distance of both axes [m].
    r : float
        Radius of both pins [m].
    mu_A, mu_C : float
        Their coefficients of friction [-]; 0: none.
    I_A, I_C : float
        Inertias of crank and follower about their axes [kg m^2].
    theta : float
        Angle of the crank at the start [rad].
    rate : float
        Its rate [rad/s].
    T : float
        Torque on the crank [N m].

    Raises
    ------
    InvalidInput
        When a parameter is out of range, and for an angle at which the rod does not reach the follower.

    Examples
    --------
    >>> from nonsmooth.catalogue import SpatialFourBar
    >>> SpatialFourBar(theta=1.0).is_well_posed(), SpatialFourBar().is_well_posed()
    (True, False)
    >>> SpatialFourBar(T=20.0).forces().tolist()  # none fits: driven on, the hinges seize
    []
    """

    A: float = 0.2016318  # crank [m]
    B: float = 0.35  # rod [m]
    C: float = 0.2016318  # follower [m]
    D: float = 0.4031627  # between the axes [m]
    r: float = 0.02  # radius of the pins [m]
    mu_A: float = 0.7  # friction of the crank [-]
    mu_C: float = 0.8  # and of the follower [-]
    I_A: float = 10.0  # crank [kg m^2]
    I_C: float = 0.01  # follower [kg m^2]
    theta: float = 2.102  # crank at the start [rad]
    rate: float = 0.001  # [rad/s]
    T: float = 20.0  # torque on the crank [N m]

    name = "spatial-four-bar"
    source = "after Cremasco Coelho, Mech. Mach. Theory 215 (2025) 106163"
    t_end = 0.02  # s
    dt = 1e-4  # s

    def __post_init__(self) -> None:
        for name, unit in (("A", "m"), ("B", "m"), ("C", "m"), ("D", "m"), ("r", "m"), ("I_A", "kg m^2")):
            as_positive(name, getattr(self, name), unit)
        as_positive("I_C", self.I_C, "kg m^2")
        for name in ("mu_A", "mu_C"):
            as_non_negative(name, getattr(self, name))
        for name, unit in (("theta", "rad"), ("rate", "rad/s"), ("T", "N m")):
            as_number(name, getattr(self, name), unit)
        if not abs(self._cos_psi()) < 1.0:
            raise InvalidInput(
                f"theta must let the rod reach the follower, got {self.theta:g} rad; a longer rod or another angle does"
            )

    def _cos_psi(self) -> float:
        a = self.D - self.A * math.cos(self.theta)
        return (self.B**2 - a**2 - self.C**2 - (self.A * math.sin(self.theta)) ** 2) / (2.0 * a * self.C)

    def psi(self) -> float:
        """Angle of the follower at the start [rad]."""
        return math.acos(self._cos_psi())

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """P and Q at the start [m]."""
        psi = self.psi()
        P = self.A * np.array((math.cos(self.theta), math.sin(self.theta), 0.0))
        return P, np.array((self.D + self.C * math.cos(psi), 0.0, self.C * math.sin(psi)))

    def arms(self) -> tuple[float, float]:
        """h_A and h_C, of the rod about both axes at the start [m]."""
        P, Q = self.points()
        n = (Q - P) / self.B
        h_C = FOLLOWER_AXIS @ np.cross(Q - (self.D, 0.0, 0.0), n)
        return float(CRANK_AXIS @ np.cross(P, n)), float(h_C)

    def transmission(self) -> float:
        """tau = psi'/theta' at the start."""
        h_A, h_C = self.arms()
        return h_A / h_C

    def coefficients(self) -> tuple[float, float]:
        """p and q of p F + q |F| = tau T/I_A + b at the start [1/(kg m)]."""
        P, Q = self.points()
        n, (h_A, h_C), tau = (Q - P) / self.B, self.arms(), self.transmission()
        k_A, k_C = math.hypot(n[0], n[1]), math.hypot(n[0], n[2])
        s_A = math.copysign(1.0, self.rate)
        s_C = s_A * math.copysign(1.0, tau)
        p = h_C / self.I_C + tau * h_A / self.I_A
        return p, tau * s_A * self._circle(self.mu_A) * k_A / self.I_A - s_C * self._circle(self.mu_C) * k_C / self.I_C

    def _circle(self, mu: float) -> float:
        return self.r * mu / math.hypot(1.0, mu)

    def is_well_posed(self) -> bool:
        """Whether there is one force of the rod, whatever pulls."""
        p, q = self.coefficients()
        return abs(q) < abs(p)

    def forces(self) -> np.ndarray:
        """The forces F of the rod that fit at the start, none to two [N]; > 0 where it is pressed."""
        p, q = self.coefficients()
        right = self.transmission() * self.T / self.I_A + self._curvature() * self.rate**2
        found = [s * right / (s * p + q) for s in (1.0, -1.0) if right / (s * p + q) > 0.0]
        return np.array(found)

    def _curvature(self) -> float:
        """b/theta'^2, from the second derivative of |Q - P|^2 = B^2 by theta: d . d'' = -d'^2."""
        P, Q = self.points()
        tau, center = self.transmission(), np.array((self.D, 0.0, 0.0))
        d, d_rate = Q - P, tau * np.cross(FOLLOWER_AXIS, Q - center) - np.cross(CRANK_AXIS, P)
        across = -(tau**2) * (Q - center) + P  # centripetal parts of Q'' - P''
        return float(-(d_rate @ d_rate + d @ across) / (self.B * self.arms()[1]))

    def scene(self) -> Scene:
        """The machine at its start."""
        scene = Scene(gravity=(0.0, 0.0, 0.0))
        frame = scene.fixed(Sphere(0.5 * self.r), name="frame")
        P, Q = self.points()
        center, rate_C = np.array((self.D, 0.0, 0.0)), self.transmission() * self.rate
        for name, at, axis, end, angle, length, rate, I, mu in (
            ("crank", np.zeros(3), CRANK_AXIS, P, self.theta, self.A, self.rate, self.I_A, self.mu_A),
            ("follower", center, FOLLOWER_AXIS, Q, self.psi(), self.C, rate_C, self.I_C, self.mu_C),
        ):
            scene.body(  # an arm along x of its frame, with its centre of mass on the axis
                Capsule(length, 0.3 * self.r), mass=1.0, inertia=I * np.eye(3), centre=(-0.5 * length, 0.0, 0.0),
                position=0.5 * (at + end), turn=(math.cos(0.5 * angle), *(math.sin(0.5 * angle) * axis)),
                spin=rate * axis, name=name,
            )  # fmt: skip
            friction = PinFriction(mu, self.r) if mu > 0.0 else None
            hinge = scene.hinge(frame, name, at=at, axis=axis, friction=friction, name=name)
            if name == "crank" and self.T != 0.0:
                hinge.motor(torque=self.T)
        scene.distance("crank", "follower", at_a=P, at_b=Q, name="rod")
        scene.ignore("frame", "crank", "follower")
        return scene
