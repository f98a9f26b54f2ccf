"""Andrews' squeezing mechanism as bodies: seven of them on ten pins, a spring and a motor.

Crank K1 turns about O and drives, at one end, a spring-loaded lever K3 on B and two toggles K4 K5 and K6 K7 on A; all
meet in the point P of the rod K2. A torque that drives the crank does the work M (beta - beta_0).
Source: *Test Set for IVP Solvers*, Andrews' squeezing mechanism; Hairer, Wanner, *Solving Ordinary Differential
Equations II* (1996), VI.9. Its digits are those of PSIDE at 1e-14, and err by 1.2e-9 rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_number, as_positive
from nonsmooth.scenes.places import rotate
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Capsule, Compound, Disc

A, B, C = np.array([[-0.06934, -0.00227], [-0.03635, 0.03273], [0.014, 0.072]])  # defined [m]
RR, D, SS, SD, ZF, FA, U = 0.007, 0.028, 0.035, 0.02, 0.02, 0.01421, 0.04  # defined: of the test set [m]
ANGLES = ("beta", "Theta", "gamma", "Phi", "delta", "Omega", "epsilon")
START = (-0.0617138900142764496, 0.0, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550,
         -0.222668390165885885, 1.23054744454982120)  # fmt: skip
AT_30_MS = (15.81077119629904, -15.75637105984298, 0.04082224013073101, -0.5347301163226948, 0.5244099658805304,
            0.5347301163226948, 1.048080741042263)  # fmt: skip
MASSES = ((0.04325, 2.194e-6), (0.00365, 4.41e-7), (0.02373, 5.255e-6), (0.00706, 5.667e-7), (0.0705, 1.169e-5),
          (0.00706, 5.667e-7), (0.05498, 1.912e-5))  # fmt: skip
THICK = 1e-3  # chosen: radius of the bodies, which touch nothing [m]


@dataclass(frozen=True)
class AndrewsSqueezer:
    """Bodies "frame" and "K1" to "K7", without gravity, at rest; motor on the pin "O", spring "spring".

    Parameters
    ----------
    M : float
        Torque on the crank [N m].
    k, l0 : float
        Stiffness [N/m] and free length [m] of the spring from C to K3.

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import AndrewsSqueezer
    >>> scene = AndrewsSqueezer().scene()
    >>> len(scene.bodies), len(scene.joints), len(scene.springs)
    (8, 10, 1)
    """

    M: float = 0.033  # torque [N m]
    k: float = 4530.0  # spring [N/m]
    l0: float = 0.07785  # its free length [m]

    name = "andrews-squeezer"
    source = "Test Set for IVP Solvers; Hairer, Wanner, Solving Ordinary Differential Equations II (1996), VI.9"
    t_end = 0.03  # s
    dt = 1e-5  # s

    def __post_init__(self) -> None:
        as_number("M", self.M, "N m")
        for name, unit in (("k", "N/m"), ("l0", "m")):
            as_positive(name, getattr(self, name), unit)

    def scene(self) -> Scene:
        """The mechanism at the start of the test set."""
        beta, theta, gamma, phi, delta, omega, epsilon = START
        turns = (beta, beta + theta, gamma, phi + delta, delta, omega + epsilon, epsilon)

        def at(angle: float, x: float, y: float) -> np.ndarray:
            return rotate(angle, np.array([x, y]))

        crank = at(beta, RR, 0)
        P = crank - at(beta + theta, D, 0)
        lever, toggle, low, high = B, A, A + at(delta, U, 0), A - at(epsilon, 0, U)
        hook = B + at(gamma, 0.02, -0.018)
        centres = (
            at(beta, 0.00092, 0), crank - at(turns[1], 0.0115, 0), B + at(gamma, 0.01043, -0.01874),
            low - at(turns[3], 0, ZF - FA), A + at(delta, 0.02308, 0.00916), high + at(turns[5], ZF - FA, 0),
            A - at(epsilon, 0.00449, 0.01228),
        )  # fmt: skip
        ends = (((0, 0), crank), (crank, P), (P, lever, hook), (low, P), (toggle, low), (high, P), (toggle, high))
        scene = Scene(gravity=(0.0, 0.0))
        spot = Disc(THICK)
        scene.fixed(Compound((spot, (0.0, 0.0)), (spot, A), (spot, B), (spot, C)), name="frame")
        for k, (mass, inertia) in enumerate(MASSES):
            points = [at(-turns[k], *(np.array(end) - centres[k])) for end in ends[k]]
            scene.body(
                Compound(*map(_bar, points, points[1:])), mass=mass, inertia=inertia, centre=(0.0, 0.0),
                position=centres[k], turn=turns[k], name=f"K{k + 1}",
            )  # fmt: skip
        for name, a, b, place in (
            ("O", "frame", "K1", (0.0, 0.0)), ("crank", "K1", "K2", crank), ("P", "K2", "K3", P),
            ("P4", "K2", "K4", P), ("P6", "K2", "K6", P), ("B", "frame", "K3", B), ("A5", "frame", "K5", A),
            ("A7", "frame", "K7", A), ("E", "K4", "K5", low), ("H", "K6", "K7", high),
        ):  # fmt: skip
            scene.hinge(a, b, at=place, name=name)
        scene.ignore(*scene.bodies)
        scene.joints[0].motor(torque=self.M)
        scene.spring("frame", "K3", at_a=C, at_b=hook, stiffness=self.k, length=self.l0, name="spring")
        return scene

    def angles(self, bodies: Any) -> np.ndarray:
        """The seven angles of a run (m, 7), or at one time (7,)."""
        beta, second, gamma, fourth, delta, sixth, epsilon = (np.asarray(bodies[f"K{k}"].turn) for k in range(1, 8))
        return np.stack((beta, second - beta, gamma, fourth - delta, delta, sixth - epsilon, epsilon), axis=-1)

    def published(self) -> np.ndarray:
        """Those at 0.03 s, of the default parameters [rad]."""
        return np.array(AT_30_MS)


def _bar(one: np.ndarray, other: np.ndarray) -> tuple[Capsule, np.ndarray, float]:
    """A part of a body, between two points."""
    x, y = other - one
    return Capsule(math.hypot(x, y), THICK), 0.5 * (one + other), math.atan2(y, x)
