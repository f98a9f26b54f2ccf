"""Woodpecker toy: a sleeve with play on a pole, a woodpecker on a spring, a beak that strikes the pole.

The pole is the strip |x| <= r0. The sleeve, half as high as 2 hM and with inner radius rM, has its centre at (0, y) and
turns by phi_M; the spring leads from (lM, 0) of the sleeve to the woodpecker, whose centre of mass lies lG further and
which turns by phi_S; its beak is the point (-lS, hS) seen from there. Angles are counter-clockwise and small, so that a
point at r of a body turned by phi moves by phi (-r_y, r_x); horizontal motions of the bodies are neglected, the sleeve
stays centred. So the woodpecker's centre is at (lM + lG, y + lM phi_M + lG phi_S), and

    beak on the pole's right side:    x = lM + lG - lS - hS phi_S,   g_1 = lM + lG - lS - r0 - hS phi_S
                                      gamma_F = y' + lM phi_M' + (lG - lS) phi_S'
    lower edge (rM, -hM) of the sleeve: x = rM + hM phi_M,           g_2 = rM - r0 + hM phi_M
    upper edge (rM,  hM) of the sleeve: x = rM - hM phi_M,           g_3 = rM - r0 - hM phi_M
                                      gamma_F = y' + rM phi_M'       of both

Edge 2 and the opposite edge (-rM, hM) close together; the two are taken as one contact, at the woodpecker's side. With
T = mM y'^2/2 + JM phi_M'^2/2 + mS (y' + lM phi_M' + lG phi_S')^2/2 + JS phi_S'^2/2 and the spring's moment
cphi (phi_S - phi_M),

    M = [mM + mS, mS lM, mS lG;  mS lM, JM + mS lM^2, mS lM lG;  mS lG, mS lM lG, JS + mS lG^2]
    h = -[(mM + mS) g;  cphi (phi_M - phi_S) + mS g lM;  cphi (phi_S - phi_M) + mS g lG]

Sources: Pfeiffer, Glocker, *Multibody Dynamics with Unilateral Contacts* (1996), ch. 15; Leine, Van Campen, Glocker,
*J. Vib. Control* 9 (2003) 25 (parameters, state on the limit cycle).
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from nonsmooth.checks.arrays import as_fraction, as_non_negative, as_number, as_positive
from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.system import Contact, System

OUTWARDS, UP = (1.0, 0.0), (0.0, 1.0)  # of the pole: its normal and its tangent


def mass(t, q, p, M):
    M[0, 0] = p.mM + p.mS
    M[0, 1] = p.mS * p.lM
    M[0, 2] = p.mS * p.lG
    M[1, 0] = M[0, 1]
    M[1, 1] = p.JM + p.mS * p.lM * p.lM
    M[1, 2] = p.mS * p.lM * p.lG
    M[2, 0] = M[0, 2]
    M[2, 1] = M[1, 2]
    M[2, 2] = p.JS + p.mS * p.lG * p.lG


def force(t, q, u, p, h):
    moment = p.cphi * (q[2] - q[1])
    h[0] = -(p.mM + p.mS) * p.g
    h[1] = moment - p.mS * p.g * p.lM
    h[2] = -moment - p.mS * p.g * p.lG


def stiffness(t, q, u, p, K):
    K[1, 1] = p.cphi
    K[1, 2] = -p.cphi
    K[2, 1] = -p.cphi
    K[2, 2] = p.cphi


def gap(t, q, p, g_N):
    g_N[0] = p.lM + p.lG - p.lS - p.r0 - p.hS * q[2]
    g_N[1] = p.rM - p.r0 + p.hM * q[1]
    g_N[2] = p.rM - p.r0 - p.hM * q[1]


def normal(t, q, p, W_N):
    W_N[0, 2] = -p.hS
    W_N[1, 1] = p.hM
    W_N[2, 1] = -p.hM


def tangent(t, q, p, W_F):
    for i in range(3):
        W_F[i, 0, 0] = 1.0
        W_F[i, 0, 1] = p.rM
    W_F[0, 0, 1] = p.lM
    W_F[0, 0, 2] = p.lG - p.lS


def row_rates(t, q, u, p, r):
    r[0, 0] = 0.0


def potential(t, q, p, V):
    twist = q[2] - q[1]
    V[0] = p.mM * p.g * q[0] + p.mS * p.g * (q[0] + p.lM * q[1] + p.lG * q[2]) + 0.5 * p.cphi * twist * twist


def beak(q, p):
    """Return the tip of the beak, with the normal and the tangent of the pole."""
    y, phi_M, phi_S = q
    lever = p.lG - p.lS
    return (p.lM + lever - p.hS * phi_S, y + p.lM * phi_M + lever * phi_S + p.hS), OUTWARDS, UP


@functools.cache
def edge(side):
    """Return what says where the lower (-1) or the upper (1) edge of the sleeve is, and its directions."""

    def at(q, p):
        y, phi_M, _ = q
        return (p.rM - side * p.hM * phi_M, y + side * p.hM + p.rM * phi_M), OUTWARDS, UP

    return at


@dataclass(frozen=True)
class Woodpecker:
    """Woodpecker toy: q = (y, phi_M, phi_S), height of the sleeve, angles of sleeve and woodpecker.

    The contacts are the beak, the lower and the upper edge of the sleeve.

    Parameters
    ----------
    r0, rM : float
        Radius of the pole and inner radius of the sleeve [m].
    hM : float
        Half the height of the sleeve [m].
    lM, lG : float
        From the pole's axis to the spring, and from the spring to the woodpecker's centre of mass [m].
    hS, lS : float
        Height of the beak over the woodpecker's centre of mass, and its distance from it towards the pole [m].
    mM, mS : float
        Masses of sleeve and woodpecker [kg].
    JM, JS : float
        Their central moments of inertia [kg m^2].
    cphi : float
        Stiffness of the spring [N m/rad].
    g : float
        Gravity [m/s^2].
    mu : float
        Friction coefficient of all contacts.
    e1, e2, e3 : float
        Restitution coefficients (Newton) of beak, lower and upper edge; the tangential ones are zero.

    Raises
    ------
    InvalidInput
        When a parameter is out of range.

    Examples
    --------
    >>> from nonsmooth.catalogue import Woodpecker
    >>> toy = Woodpecker()
    >>> round(toy.jam_angle(), 6), round(toy.jamming_friction(), 6), round(toy.beak_angle(), 3)
    (-0.103448, 0.285187, 0.12)
    """

    r0: float = 0.0025  # radius of the pole [m]
    rM: float = 0.0031  # inner radius of the sleeve [m]
    hM: float = 0.0058  # half height of the sleeve [m]
    lM: float = 0.010  # pole to spring [m]
    lG: float = 0.015  # spring to woodpecker [m]
    hS: float = 0.02  # height of the beak [m]
    lS: float = 0.0201  # length of the beak [m]
    mM: float = 3e-4  # mass of the sleeve [kg]
    mS: float = 4.5e-3  # mass of the woodpecker [kg]
    JM: float = 5e-9  # inertia of the sleeve [kg m^2]
    JS: float = 7e-7  # inertia of the woodpecker [kg m^2]
    cphi: float = 0.0056  # stiffness of the spring [N m/rad]
    g: float = 9.81  # gravity [m/s^2]
    mu: float = 0.3  # friction coefficient [-]
    e1: float = 0.5  # restitution of the beak [-]
    e2: float = 0.0  # restitution of the lower edge [-]
    e3: float = 0.0  # restitution of the upper edge [-]

    name = "woodpecker"
    source = "Leine, Van Campen, Glocker, J. Vib. Control 9 (2003) 25"
    coordinates = (("y", "m"), ("phi_M", "rad"), ("phi_S", "rad"))
    parts = ("sleeve", "spring", "woodpecker", "beak")
    t_end = 0.6  # s
    dt = 1e-4  # s

    def __post_init__(self) -> None:
        for key in ("r0", "rM", "hM", "lM", "lG", "hS", "lS"):
            as_positive(key, getattr(self, key), "m")
        for key in ("mM", "mS"):
            as_positive(key, getattr(self, key), "kg")
        for key in ("JM", "JS"):
            as_positive(key, getattr(self, key), "kg m^2")
        as_positive("cphi", self.cphi, "N m/rad")
        as_positive("g", self.g, "m/s^2")
        as_non_negative("mu", self.mu)
        for key in ("e1", "e2", "e3"):
            as_fraction(key, getattr(self, key))
        if self.rM <= self.r0:
            raise InvalidInput(f"the sleeve must be wider than the pole, rM > r0 = {self.r0:g} m; got {self.rM:g} m")

    def system(self) -> System:
        """The system with three unilateral contacts with friction."""
        contacts = [
            Contact(mu="mu", e_N="e1", at=beak),
            Contact(mu="mu", e_N="e2", at=edge(-1)),
            Contact(mu="mu", e_N="e3", at=edge(1)),
        ]
        return System(
            n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, row_rates=row_rates,
            stiffness=stiffness, potential=potential, contacts=contacts, parameters=self, name=self.name,
        )  # fmt: skip

    def state(
        self, phi_S: float = -0.2788, ydot: float = -0.3411, phi_Sdot: float = -7.4583,
        y: float = 0.0, phi_M: float | None = None, phi_Mdot: float = 0.0,
    ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """q0 (3,) and u0 (3,): heights [m], angles [rad] and their rates; without phi_M the lower edge touches.

        The default lies on the limit cycle. It is printed with phi_M = -0.1036, which is 1e-6 m inside the pole.
        """
        phi_M = self.jam_angle() if phi_M is None else as_number("phi_M", phi_M, "rad")
        q0 = np.array([as_number("y", y, "m"), phi_M, as_number("phi_S", phi_S, "rad")])
        u0 = [as_number("ydot", ydot, "m/s"), as_number("phi_Mdot", phi_Mdot, "rad/s")]
        return q0, np.array([*u0, as_number("phi_Sdot", phi_Sdot, "rad/s")])

    def jam_angle(self) -> float:
        """phi_M [rad] at which the lower edge touches the pole; the upper one touches at its opposite."""
        return -(self.rM - self.r0) / self.hM

    def beak_angle(self) -> float:
        """phi_S [rad] at which the beak touches the pole."""
        return (self.lM + self.lG - self.lS - self.r0) / self.hS

    def hanging_angle(self) -> float:
        """phi_S [rad] in equilibrium on the jammed sleeve: cphi (phi_S - phi_M) = -mS g lG."""
        return self.jam_angle() - self.mS * self.g * self.lG / self.cphi

    def jamming_friction(self) -> float:
        """The friction coefficient from which on the toy hangs on its sleeve: la_F/la_N of the lower edge at rest.

        la_F = (mM + mS) g,    hM la_N = mS g (lM + lG) - rM la_F
        """
        weight = self.mM + self.mS
        lever = self.mS * (self.lM + self.lG) - self.rM * weight
        return weight * self.hM / lever if lever > 0 else math.inf

    def swing_period(self) -> float:
        """Period of the woodpecker on the jammed sleeve [s], 2 pi sqrt((JS + mS lG^2)/cphi)."""
        return 2 * math.pi * math.sqrt((self.JS + self.mS * self.lG**2) / self.cphi)

    def shape(self, q: np.ndarray) -> list[np.ndarray]:
        """Sleeve (5, 2), spring (2, 2), woodpecker (25, 2) and beak (3, 2) as polylines, turned as in the equations."""
        y, phi_M, phi_S = q
        sleeve = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * [self.rM, self.hM]
        joint = np.array([self.lM, y + self.lM * phi_M])
        centre = joint + [self.lG, self.lG * phi_S]
        angle = np.linspace(0.0, 2 * np.pi, 25)
        body = np.column_stack([0.3 * self.lG * np.cos(angle), 0.7 * self.hS * np.sin(angle)])
        beak = np.array([[-0.15 * self.lG, 0.6 * self.hS], [-self.lS, self.hS], [0.1 * self.lG, 0.7 * self.hS]])
        return [
            [0.0, y] + turned(sleeve, phi_M), np.array([[self.rM, y + self.rM * phi_M], joint, centre]),
            centre + turned(body, phi_S), centre + turned(beak, phi_S),
        ]  # fmt: skip

    def outline(self) -> list[np.ndarray]:
        """The two sides of the pole."""
        y = np.array([-6 * self.hS, 3 * self.hS])
        return [np.column_stack([np.full(2, side * self.r0), y]) for side in (-1, 1)]


def turned(points: np.ndarray, phi: float) -> np.ndarray:
    """Points (n, 2) seen from a body's centre, turned by a small angle."""
    return points + phi * np.column_stack([-points[:, 1], points[:, 0]])
