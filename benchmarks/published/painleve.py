"""Painlevé's rod in general: Génot-Brogliato points, and the rod in space."""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np
from scipy.optimize import brentq, minimize_scalar

import nonsmooth as ns
from benchmarks.published.rows import Row, Section
from models import PainleveRod


@functools.cache
def points(mu):
    """Génot-Brogliato points (th, th') of the rod: p = b = 0, by increasing th."""
    curves = ns.paradox_boundaries(PainleveRod(mu=mu), th=np.linspace(0.3, 1.5, 40), thdot=np.linspace(1.0, 9.0, 40))
    found = curves.crossings["p", "b"]
    return found[np.argsort(found[:, 0])]


def scaled_rate(mu):
    """th' sqrt(s/g) at the first of them, s half the length."""
    rod = PainleveRod(mu=mu)
    return points(mu)[0, 1] * math.sqrt(rod.l / (2 * rod.g))


@dataclasses.dataclass(frozen=True)
class RodInSpace:
    """A slender rod of half length 1 and mass 1 with its lower tip on the plane z = 0, g = 1; it does not roll.

    q = (x, y, z, th, ps): the centre, the elevation and the azimuth of the axis from the tip to the centre.
    """

    mu: float = 2.0

    def system(self):
        """As a system with friction in two directions."""

        def mass(t, q, p, M):
            M[0, 0] = M[1, 1] = M[2, 2] = 1.0
            M[3, 3] = 1 / 3
            M[4, 4] = math.cos(q[3]) ** 2 / 3

        def force(t, q, u, p, h):
            both = math.cos(q[3]) * math.sin(q[3]) / 3
            h[2], h[3], h[4] = -1.0, -both * u[4] ** 2, 2 * both * u[3] * u[4]

        def gap(t, q, p, g_N):
            g_N[0] = q[2] - math.sin(q[3])

        def tangent(t, q, p, W_F):
            c, s = math.cos(q[3]), math.sin(q[3])
            W_F[0, 0, 0], W_F[0, 0, 3], W_F[0, 0, 4] = 1.0, s * math.cos(q[4]), c * math.sin(q[4])
            W_F[0, 1, 1], W_F[0, 1, 3], W_F[0, 1, 4] = 1.0, s * math.sin(q[4]), -c * math.cos(q[4])

        contact = ns.Contact(mu="mu", directions=2)
        return ns.System(n_q=5, mass=mass, force=force, gap=gap, tangent=tangent, contacts=[contact], parameters=self)


@functools.cache
def system_in_space(mu):
    """Made once."""
    return RodInSpace(mu).system()


def contact_in_space(th, mu=2.0, phi=0.0, turning=0.0):
    """(p, b) of the tip: slip at the angle phi to the axis that it drags ahead, rate of the azimuth ``turning``."""
    c, s = math.cos(th), math.sin(th)
    u = [-math.cos(phi), math.sin(phi) + c * turning, 0.0, 0.0, turning]
    state = ns.classify(system_in_space(mu), 0.0, [0.0, 0.0, s, th, 0.0], u)
    return state.p[0], state.b[0]


def angle_of_p(mu, bracket):
    """Elevation [degrees] at which p = 0 while the tip is dragged ahead."""
    return math.degrees(brentq(lambda th: contact_in_space(th, mu)[0], *bracket, xtol=1e-14))


def widest_slip(mu):
    """Largest angle phi [degrees] of slip at which p = 0 is met, at the elevation arctan 2."""
    return math.degrees(brentq(lambda phi: contact_in_space(math.atan(2), mu, phi)[0], 0.0, 1.5, xtol=1e-14))


def lifting_rate(th):
    """Rate of the azimuth, of sqrt(g/l), at which b = 0 without any rate of the elevation."""
    return brentq(lambda turning: contact_in_space(th, turning=turning)[1], 0.1, 100.0, xtol=1e-13)


GB = {1.4: "55.585811 69.951867 1.100981", 1.5: "50.641598 73.048469 1.137249", 2.0: "37.377368 79.187683 1.283463"}
IN_SPACE = {
    1.4: "55.5858 69.9519 1.9480490 3.0096833 17.7528",
    5 / 3: "45 75.9638 1.6817928 4.1860720 36.8699",
    2.0: "37.3774 79.1877 1.6151213 5.3786619 48.1897",
}

SECTIONS = (
    Section(
        "genot-brogliato",
        "Génot–Brogliato points",
        "Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653: the points where p and b vanish together; the "
        "digits are those of the closed forms, th from mu = mu_c(th) and th' sqrt(s/g) = 1/sqrt(sin th).",
        tuple(
            Row(*what)
            for mu, line in GB.items()
            for what in (
                (f"first angle, mu = {mu} [degrees]", line.split()[0], lambda mu=mu: math.degrees(points(mu)[0, 0])),
                (f"second angle, mu = {mu} [degrees]", line.split()[1], lambda mu=mu: math.degrees(points(mu)[1, 0])),
                (f"th' sqrt(s/g), mu = {mu}", line.split()[2], lambda mu=mu: scaled_rate(mu)),
            )
        ),
        (points, scaled_rate),
    ),
    Section(
        "space",
        "Painlevé's rod in space",
        "Cheesman, Hogan, Uldall Kristiansen, arXiv 2110.14324, name three critical rates of the azimuth, one of them "
        "free of any paradox. The digits are those of closed forms from the equations of Newton and Euler, which we "
        "take for these three (1.6118549 = sqrt(3 sqrt(3)/2), and 1/(cos th sqrt(sin th)) where p = 0); the rows find "
        "them by classifying states.",
        (
            Row("least rate that lifts off, of sqrt(g/l)", "1.6118549",
                lambda: minimize_scalar(lifting_rate, bounds=(0.2, 1.2), method="bounded").fun),
            Row("elevation there [degrees]", "35.264",
                lambda: math.degrees(minimize_scalar(lifting_rate, bounds=(0.2, 1.2), method="bounded").x)),
            *(
                Row(what, line.split()[k], ours)
                for mu, line in IN_SPACE.items()
                for k, (what, ours) in enumerate((
                    (f"first elevation with p = 0, mu = {mu:.4g} [degrees]", lambda mu=mu: angle_of_p(mu, (0.3, 1.1))),
                    (f"second one, mu = {mu:.4g} [degrees]", lambda mu=mu: angle_of_p(mu, (1.11, 1.55))),
                    (f"rate at the first, mu = {mu:.4g}",
                     lambda mu=mu: lifting_rate(math.radians(angle_of_p(mu, (0.3, 1.1))))),
                    (f"rate at the second, mu = {mu:.4g}",
                     lambda mu=mu: lifting_rate(math.radians(angle_of_p(mu, (1.11, 1.55))))),
                    (f"widest angle of slip, mu = {mu:.4g} [degrees]", lambda mu=mu: widest_slip(mu)),
                ))
            ),
        ),
        (RodInSpace, contact_in_space, angle_of_p, lifting_rate, widest_slip),
    ),
)  # fmt: skip
