"""Results of textbooks, papers and program pages on impacts, friction and masonry."""

from __future__ import annotations

import functools
import math
import warnings
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, minimize_scalar

import nonsmooth as ns
from benchmarks.published.rows import Row, Section
from models import BouncingBall, RockingBlock, Woodpecker
from models.scenes import MasonryArch, NewtonsCradle

FINE = ns.EventDriven(rtol=1e-12, atol=1e-14)


def last_bounce(e):
    """Time at which a ball dropped from 1 m comes to rest [s]."""
    ball = BouncingBall(e=e)
    sol = ns.simulate(ball, (0, 10), *ball.state(height=1.0), integrator=FINE)
    return next(event.t for event in sol.events if event.mode_after == ns.ContactMode.LOCKED)


@functools.cache
def dropped(e):
    """15 s of a ball dropped from 50 m, g = 9.8 m/s^2."""
    ball = BouncingBall(e=e, g=9.8)
    return ns.simulate(ball, (0, 15), *ball.state(height=50.0), integrator=FINE)


def locally_best():
    """The restitution near 0.87 that brings the ball highest after 15 s, and so nearest to 20 m."""
    return minimize_scalar(lambda e: -dropped(e).q[-1, 0], bounds=(0.86, 0.875), method="bounded",
                           options={"xatol": 1e-12}).x  # fmt: skip


def reaching(height):
    """The restitution near 1 that brings the ball to a height after 15 s."""
    return brentq(lambda e: dropped(e).q[-1, 0] - height, 0.98, 1.0, xtol=1e-14)


@functools.cache
def on_a_spring():
    """10 s of a ball of 0.1 kg dropped from 1 m on a contact of 1000 N/m without damping."""
    ball = BouncingBall(m=0.1, e=1.0)
    integrator = ns.Penalty(stiffness=1e3, rtol=1e-12, atol=1e-13)
    return ns.simulate(ball, (0, 10), *ball.state(height=1.0), integrator=integrator)


def energy_kept(sol):
    """Of a ball that flies at the end, over that of its start."""
    return (9.81 * sol.q[-1, 0] + sol.u[-1, 0] ** 2 / 2) / (9.81 * sol.q[0, 0])


@functools.cache
def ideal_ball():
    """60 s of a ball dropped from 10 m that loses nothing."""
    ball = BouncingBall(e=1.0)
    return ns.simulate(ball, (0, 60), *ball.state(height=10.0), integrator=FINE)


def rocking_ratio(width, height):
    """Rate of a rocking block after its first impact over that before it."""
    block = RockingBlock(width=width, height=height)
    sol = ns.simulate(block, (0, 1), *block.state(tilt=0.05), integrator=FINE)
    t = sol.events[0].t
    return sol(t).u[2] / sol(t, side="left").u[2]


@functools.cache
def cradle(n):
    """Velocities of n balls that touch when the first is struck at 1 m/s: all contacts at once, as is printed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ns.SimultaneousImpactWarning)
        sol = ns.simulate(NewtonsCradle(n=n, gap=0.0), (0, 0.5), integrator=ns.MoreauJean(dt=1e-3))
    return [sol[f"ball {k}"].velocity[-1, 0] for k in range(n)]


@dataclass(frozen=True)
class TwoModes:
    """Two modes coupled by friction: K = [[2, 0.3 - mu], [0.3, 1.6]], M = 1."""

    mu: float = 0.1

    def system(self):
        """As a system."""

        def mass(t, q, p, M):
            M[0, 0] = M[1, 1] = 1.0

        def force(t, q, u, p, h):
            h[0] = -2.0 * q[0] - (0.3 - p.mu) * q[1]
            h[1] = -0.3 * q[0] - 1.6 * q[1]

        return ns.System(n_q=2, mass=mass, force=force, parameters=self)


def super_ball(e_F):
    """Velocity along the table of a ball thrown under it, after three bounces [m/s]."""

    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.0
        M[2, 2] = 0.004

    def force(t, q, u, p, h):
        h[1] = -10.0

    def gap(t, q, p, g_N):
        g_N[0], g_N[1] = q[1] - 0.1, 0.9 - q[1]

    def tangent(t, q, p, W_F):
        W_F[0, 0, 0], W_F[0, 0, 2] = 1.0, 0.1
        W_F[1, 0, 0], W_F[1, 0, 2] = -1.0, 0.1

    contacts = [ns.Contact(mu=1.0, e_N=1.0, e_F=e_F)] * 2
    ball = ns.System(n_q=3, mass=mass, force=force, gap=gap, tangent=tangent, contacts=contacts)
    return ns.simulate(ball, (0, 1.2), [0, 0.9, 0], [1, -1, 0], integrator=FINE).u[-1, 0]


def rolling_on_a_spring():
    """Frequency of a rolling cylinder (0.5 kg, radius 0.05 m) on a spring of 100 N/m [rad/s]."""
    l = ns.lagrangian("cylinder on a spring")
    x, th = l.coordinates("x th")
    xdot, thdot = l.rates
    l.kinetic(0.5 * (0.5 * xdot**2 + 0.5 * 0.5 * 0.05**2 * thdot**2))
    l.potential(0.5 * 100 * x**2)
    l.contact(normal_force=0.5 * 9.81, slip=xdot + 0.05 * thdot, mu=1.0)
    sol = ns.simulate(l.model(), (0, 5), [0.02, 0], [0, 0], integrator=FINE, events=lambda t, q, u: u[0])
    return math.pi / np.diff(sol.t_events[0]).mean()


SECTIONS = (
    Section(
        "bounces",
        "Bouncing balls",
        "The sum of the flights, sqrt(2 h/g) (1 + e)/(1 - e), of textbooks, h = 1 m; SciMLSensitivity's page "
        "\"Bouncing Ball Hybrid ODE Optimization\"; Kurtz, Castro, arXiv 2511.08771 (CENIC), a ball of "
        "0.1 kg on 1000 N/m, and what is left of its energy in newton-adaptive, a program of others, with fixed steps "
        "and with error control, and in MuJoCo; Bullet, issue 1530.",
        (
            *(
                Row(f"bounces end, e = {e} [s]", printed, lambda e=e: last_bounce(e))
                for e, printed in ((0.5, "1.3545709"), (0.8, "4.0637128"), (0.9, "8.5789492"))
            ),
            *(
                Row(f"SciML: bounce {k + 1}, e = 0.8 [s]", printed, lambda k=k: dropped(0.8).events[k].t, within=1e-12,
                    why="error of their integration")
                for k, printed in enumerate(("3.1943828249997095", "8.30539534499923", "12.394205360998841"))
            ),
            Row("SciML: optimised restitution", "0.866554105436901", lambda: locally_best(), within=1e-7,
                why="a maximum is known to the root of rounding"),
            Row(
                "SciML: restitution with which the ball is at 20 m after 15 s", "0.866554105436901",
                lambda: reaching(20.0),
                corrected=lambda: brentq(lambda e: BouncingBall(e=e, g=9.8).height(15.0, height=50.0) - 20, 0.98, 1.0),
                errs="the page: its optimisation ends in the local optimum above, where the ball is at 19.37 m",
            ),
            Row("CENIC: bounces in 10 s", "11",
                lambda: sum(event.mode_after == ns.ContactMode.OPEN for event in on_a_spring().events)),
            Row("CENIC: energy after 10 s, of that at the start", "1", lambda: energy_kept(on_a_spring()),
                within=1e-11, why="exact"),
            *(
                Row(f"energy that it lost after 10 s [%]: {name}", printed,
                    lambda: 100 * abs(1 - energy_kept(on_a_spring())), corrected="0.000000",
                    errs="a spring without damping loses nothing")
                for name, printed in (
                    ("steps of 1 ms", "99.6"), ("steps of 0.1 ms", "32"), ("steps of 10 us", "3.5"),
                    ("error control at 1e-5", "61"), ("error control at 1e-6", "22"), ("MuJoCo", "99.5"),
                )
            ),
            Row("Bullet: height to which an ideal ball from 10 m comes back [m]", "4.5",
                lambda: 10 * energy_kept(ideal_ball()), corrected="10.0000000",
                errs="Bullet, as its issue 1530 reports"),
        ),
        (last_bounce, dropped, locally_best, reaching, on_a_spring, energy_kept, ideal_ball),
    ),
    Section(
        "several-impacts",
        "Impacts of several contacts",
        "Housner, *Bull. Seismol. Soc. Am.* 53 (1963) 403: a rocking block keeps 1 - (3/2) sin^2 alpha of its rate. "
        "Moreau's impact of a cradle whose balls touch, e = 1. Leine, *An Introduction to Nonsmooth Dynamics*, program "
        "of the super ball: with e_T = 1 it comes back, with e_T = 0 it does not.",
        (
            *(
                Row(f"rate kept by a block of {width} x {height} m", printed,
                    lambda width=width, height=height: rocking_ratio(width, height))
                for width, height, printed in ((0.2, 0.8, "0.911765"), (0.2, 1.2, "0.959459"))
            ),
            Row("rate kept by a block of 0.2 x 0.4 m", "0.7", lambda: rocking_ratio(0.2, 0.4), within=1e-12,
                why="exact"),
            *(
                Row(f"ball {k + 1} of {n} [m/s]", printed, lambda n=n, k=k: cradle(n)[k],
                    within=1e-9, why="exact")
                for n, after in ((3, ("-1/3", "2/3", "2/3")), (4, ("-1/2", "1/2", "1/2", "1/2")))
                for k, printed in enumerate(after)
            ),
            Row("direction of the super ball, e_T = 1", "-1", lambda: np.sign(super_ball(1.0))),
            Row("direction of the tennis ball, e_T = 0", "1", lambda: np.sign(super_ball(0.0))),
        ),
        (rocking_ratio, cradle, super_ball),
    ),
    Section(
        "classics",
        "Woodpecker, arch, two modes, a cylinder",
        "Woodpecker: Leine, Van Campen, Glocker, *J. Vib. Control* 9 (2003) 25, and the run of Leine's program, which "
        "takes one period. Arch: Milankovitch (1907); Cocchetti, Colasante, Rizzi, *Appl. Mech. Rev.* 64 (2012) "
        "050802, for very many stones. Two modes: mu_c = (k12^2 + (k11 - k22)^2/4)/(k12 kn). Cylinder: Castro, "
        "Permenter, Han, *IEEE Trans. Robotics* (2023), arXiv 2110.10107, omega = sqrt(k/(m + I/R^2)).",
        (
            Row("period of the woodpecker [s]", "0.146", lambda: ns.limit_cycle(Woodpecker(), duration=4.0).period),
            Row(
                "angle of its jammed sleeve [rad]", "-0.1036", lambda: Woodpecker().jam_angle(),
                corrected=lambda: -(0.0031 - 0.0025) / 0.0058,
                errs="the printed state lies 0.9 um inside the pole",
            ),
            Row("least thickness of an arch, of its radius", "0.107478", lambda: MasonryArch(n=1000).least_ratio(),
                is_slow=True),
            Row("friction of flutter of two modes", "0.433333",
                lambda: ns.flutter_boundary(TwoModes(), "mu", (0.31, 1.0)).value),
            Row("frequency of a cylinder on a spring [rad/s]", lambda: math.sqrt(100 / (0.5 + 0.25)),
                lambda: rolling_on_a_spring()),
        ),
        (TwoModes, rolling_on_a_spring),
    ),
)  # fmt: skip
