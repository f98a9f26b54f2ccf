"""Adaptive: its error, in tolerances, on small systems where an integrator with error control may go wrong.

Sliding that reverses, bilateral contacts whose force changes its sign, clearances, feet that throw one another up,
loads that read the velocity, tables that shake faster than anything on them moves. Rates of rows and Jacobians of the
forces are left out throughout: they are taken by differences.

References: SciPy's solve_ivp with the modes found by trying all of them (benchmarks/adapters/scipy_modes.py), which
shares nothing with Adaptive but the functions of the systems, and EventDriven at 1e-12, which shares neither steps nor
the treatment of events. Errors are taken at 61 times within the steps, over 1e-2 + max |q|.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns
from benchmarks import peers

pytestmark = pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # of both ends of a piston

MOST = 30.0  # tolerances
ALIKE = 3e-10  # of two references, over 1e-2 + max |q|: rows that move fast have their rates by differences

SYSTEMS = {}  # functions that make them


class Case(NamedTuple):
    """A system, where it starts, and for how long it runs."""

    system: ns.System
    q0: list
    u0: list
    t_end: float


def case(make):
    SYSTEMS[make.__name__.replace("_", " ")] = make
    return make


def diagonal(*m):
    """A mass matrix."""
    m = tuple(float(x) for x in m)
    n = len(m)

    def mass(t, q, p, M):
        for i in range(n):
            M[i, i] = m[i]

    return mass


@case
def block_reverses():
    def force(t, q, u, p, h):
        h[0] = 10 * math.cos(3 * t)
        h[1] = -9.81

    def gap(t, q, p, g):
        g[0] = q[1]

    def normal(t, q, p, W):
        W[0, 1] = 1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    return Case(
        ns.System(
            n_q=2,
            mass=diagonal(1, 1),
            force=force,
            gap=gap,
            normal=normal,
            tangent=tangent,
            contacts=[ns.Contact(mu=0.3)],
        ),
        [0, 0],
        [0.5, 0],
        4.0,
    )


@case
def two_guides():
    """A collar in two guides 2a apart, pushed at the lever b: N = m g/2 +- b F/(2a), both signs."""

    def force(t, q, u, p, h):
        F = 30 * math.cos(4 * t)
        h[0] = F - 5 * q[0]
        h[1] = -9.81 * 2
        h[2] = 0.3 * F

    def gap(t, q, p, g):
        g[0] = q[1] - 0.2 * q[2]
        g[1] = q[1] + 0.2 * q[2]

    def normal(t, q, p, W):
        W[0, 1] = 1.0
        W[0, 2] = -0.2
        W[1, 1] = 1.0
        W[1, 2] = 0.2

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0
        W[1, 0, 0] = 1.0

    return Case(
        ns.System(
            n_q=3,
            mass=diagonal(2, 2, 0.1),
            force=force,
            gap=gap,
            normal=normal,
            tangent=tangent,
            contacts=[ns.Contact(mu=0.2, bilateral=True)] * 2,
        ),
        [0.1, 0, 0],
        [0.3, 0, 0],
        5.0,
    )


@case
def piston_with_clearance():
    """Lateral motion y and tilt of a piston; its axial motion is prescribed, the walls pass with v(t)."""

    def force(t, q, u, p, h):
        h[0] = 400 * math.sin(60 * t) - 3 * u[0]
        h[1] = 2.0 * math.cos(60 * t) - 0.02 * u[1]

    def gap(t, q, p, g):
        for k in range(4):
            side = 1.0 if k < 2 else -1.0
            end = 1.0 if k % 2 == 0 else -1.0
            g[k] = 1e-3 - side * (q[0] + end * 0.03 * q[1])

    def normal(t, q, p, W):
        for k in range(4):
            side = 1.0 if k < 2 else -1.0
            end = 1.0 if k % 2 == 0 else -1.0
            W[k, 0] = -side
            W[k, 1] = -side * end * 0.03

    def tangent(t, q, p, W):
        for k in range(4):
            W[k, 0, 1] = 0.025 if k < 2 else -0.025

    def surface_velocity(t, q, p, w):
        for k in range(4):
            w[k, 0] = 3 * math.sin(60 * t + 0.4)

    return Case(
        ns.System(
            n_q=2,
            mass=diagonal(0.5, 2e-4),
            force=force,
            gap=gap,
            normal=normal,
            tangent=tangent,
            surface_velocity=surface_velocity,
            contacts=[ns.Contact(mu=0.1, e_N=0.3)] * 4,
        ),
        [0, 0],
        [0, 0],
        0.1,
    )


@case
def five_bar():
    """Hip, two knees, two feet (points of mass) on a rough floor: q = (x, y, a_1, b_1, a_2, b_2)."""

    def points(q, J, X):
        for k in range(5):
            X[k, 0] = q[0]
            X[k, 1] = q[1]

    def mass(t, q, p, M):
        m = (4.0, 1.0, 0.5, 1.0, 0.5)
        for i in range(6):
            for j in range(6):
                M[i, j] = 0.0
        for k in range(5):
            for r in range(2):
                row = (
                    1.0 if r == 0 else 0.0,
                    1.0 if r == 1 else 0.0,
                    0.5 * (math.cos(q[2]) if r == 0 else math.sin(q[2])) if k == 1 or k == 2 else 0.0,
                    0.5 * (math.cos(q[3]) if r == 0 else math.sin(q[3])) if k == 2 else 0.0,
                    0.5 * (math.cos(q[4]) if r == 0 else math.sin(q[4])) if k == 3 or k == 4 else 0.0,
                    0.5 * (math.cos(q[5]) if r == 0 else math.sin(q[5])) if k == 4 else 0.0,
                )
                for i in range(6):
                    for j in range(6):
                        M[i, j] += m[k] * row[i] * row[j]
        for i in range(2, 6):
            M[i, i] += 0.02

    def force(t, q, u, p, h):
        m = (4.0, 1.0, 0.5, 1.0, 0.5)
        for i in range(6):
            h[i] = 0.0
        for k in range(5):
            for r in range(2):
                s2 = 0.5 if k == 1 or k == 2 else 0.0
                s3 = 0.5 if k == 2 else 0.0
                s4 = 0.5 if k == 3 or k == 4 else 0.0
                s5 = 0.5 if k == 4 else 0.0
                row = (
                    1.0 if r == 0 else 0.0,
                    1.0 if r == 1 else 0.0,
                    s2 * (math.cos(q[2]) if r == 0 else math.sin(q[2])),
                    s3 * (math.cos(q[3]) if r == 0 else math.sin(q[3])),
                    s4 * (math.cos(q[4]) if r == 0 else math.sin(q[4])),
                    s5 * (math.cos(q[5]) if r == 0 else math.sin(q[5])),
                )
                if r == 0:
                    a = (
                        -s2 * math.sin(q[2]) * u[2] * u[2]
                        - s3 * math.sin(q[3]) * u[3] * u[3]
                        - s4 * math.sin(q[4]) * u[4] * u[4]
                        - s5 * math.sin(q[5]) * u[5] * u[5]
                    )
                else:
                    a = (
                        s2 * math.cos(q[2]) * u[2] * u[2]
                        + s3 * math.cos(q[3]) * u[3] * u[3]
                        + s4 * math.cos(q[4]) * u[4] * u[4]
                        + s5 * math.cos(q[5]) * u[5] * u[5]
                    )
                    a += 9.81
                for i in range(6):
                    h[i] -= m[k] * row[i] * a
        knee_1 = 60 * (q[2] - q[3] - 1.0) + 1.5 * (u[2] - u[3])
        knee_2 = 60 * (q[4] - q[5] + 1.0) + 1.5 * (u[4] - u[5])
        hip = 30 * (q[2] - q[4] - 1.2) + 1.0 * (u[2] - u[4]) - 25 * math.sin(5 * t)
        h[2] -= knee_1 + hip
        h[3] += knee_1
        h[4] -= knee_2 - hip
        h[5] += knee_2

    def gap(t, q, p, g):
        g[0] = q[1] - 0.5 * math.cos(q[2]) - 0.5 * math.cos(q[3])
        g[1] = q[1] - 0.5 * math.cos(q[4]) - 0.5 * math.cos(q[5])

    def normal(t, q, p, W):
        W[0, 1] = 1.0
        W[0, 2] = 0.5 * math.sin(q[2])
        W[0, 3] = 0.5 * math.sin(q[3])
        W[1, 1] = 1.0
        W[1, 4] = 0.5 * math.sin(q[4])
        W[1, 5] = 0.5 * math.sin(q[5])

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0
        W[0, 0, 2] = 0.5 * math.cos(q[2])
        W[0, 0, 3] = 0.5 * math.cos(q[3])
        W[1, 0, 0] = 1.0
        W[1, 0, 4] = 0.5 * math.cos(q[4])
        W[1, 0, 5] = 0.5 * math.cos(q[5])

    y = 0.5 * math.cos(0.9) + 0.5 * math.cos(0.2)
    return Case(
        ns.System(
            n_q=6, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, contacts=[ns.Contact(mu=0.5)] * 2
        ),
        [0, y + 0.02, 0.9, 0.2, -0.9, -0.2],
        [0.3, 0, 0, 0, 0, 0],
        1.5,
    )


@case
def belt_whose_load_reads_u():
    def force(t, q, u, p, h):
        h[0] = -q[0]

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    def surface_velocity(t, q, p, w):
        w[0, 0] = -0.2

    def normal_force(t, q, u, p, N):
        N[0] = 1 / (1 + 3 * abs(u[0] - 0.2))

    return Case(
        ns.System(
            n_q=1,
            mass=diagonal(1),
            force=force,
            tangent=tangent,
            surface_velocity=surface_velocity,
            normal_force=normal_force,
            contacts=[ns.Contact(mu=1.0, normal_force=True)],
        ),
        [0],
        [0.2],
        20.0,
    )


@case
def driven_on_a_shaken_belt():
    def force(t, q, u, p, h):
        h[0] = -40 * q[0] - 0.4 * u[0] + 3 * math.cos(6.8 * t)

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    def surface_velocity(t, q, p, w):
        w[0, 0] = -0.5 - 0.3 * math.sin(4 * t)

    def N(t, q, u, p, N):
        N[0] = 12.0

    return Case(
        ns.System(
            n_q=1,
            mass=diagonal(1.3),
            force=force,
            tangent=tangent,
            surface_velocity=surface_velocity,
            normal_force=N,
            contacts=[ns.Contact(mu=0.2, normal_force=True)],
        ),
        [0.05],
        [0],
        20.0,
    )


@case
def two_blocks_on_a_table():
    def force(t, q, u, p, h):
        h[2] = -3 * 9.81
        h[3] = -2 * 9.81

    def gap(t, q, p, g):
        g[0] = q[2]
        g[1] = q[3] - q[2]

    def normal(t, q, p, W):
        W[0, 2] = 1.0
        W[1, 3] = 1.0
        W[1, 2] = -1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0
        W[1, 0, 1] = 1.0
        W[1, 0, 0] = -1.0

    return Case(
        ns.System(
            n_q=4,
            mass=diagonal(3, 2, 3, 2),
            force=force,
            gap=gap,
            normal=normal,
            tangent=tangent,
            contacts=[ns.Contact(mu=0.4), ns.Contact(mu=0.3)],
        ),
        [0] * 4,
        [-0.855, 0.705, 0, 0],
        2.0,
    )


@case
def three_blocks_on_a_shaken_table():
    def force(t, q, u, p, h):
        for k in range(3):
            h[3 + k] = -(3.0 - k) * 9.81

    def gap(t, q, p, g):
        g[0] = q[3]
        g[1] = q[4] - q[3]
        g[2] = q[5] - q[4]

    def normal(t, q, p, W):
        W[0, 3] = 1.0
        W[1, 4] = 1.0
        W[1, 3] = -1.0
        W[2, 5] = 1.0
        W[2, 4] = -1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0
        W[1, 0, 1] = 1.0
        W[1, 0, 0] = -1.0
        W[2, 0, 2] = 1.0
        W[2, 0, 1] = -1.0

    def surface_velocity(t, q, p, w):
        w[0, 0] = -0.8 * math.cos(7 * t) + 0.2 * math.sin(3 * t)

    return Case(
        ns.System(
            n_q=6,
            mass=diagonal(3, 2, 1, 3, 2, 1),
            force=force,
            gap=gap,
            normal=normal,
            tangent=tangent,
            surface_velocity=surface_velocity,
            contacts=[ns.Contact(mu=0.5), ns.Contact(mu=0.3), ns.Contact(mu=0.2)],
        ),
        [0] * 6,
        [0] * 6,
        3.0,
    )


@case
def feeder():
    """A part on a plate that shakes along and up, a < g: slides to and fro, and never flies."""

    def force(t, q, u, p, h):
        h[1] = -9.81

    def gap(t, q, p, g):
        g[0] = q[1] - 1e-3 * math.sin(80 * t)

    def gap_rate(t, q, p, w):
        w[0] = -0.08 * math.cos(80 * t)

    def normal(t, q, p, W):
        W[0, 1] = 1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    def surface_velocity(t, q, p, w):
        w[0, 0] = -0.16 * math.cos(80 * t)

    return Case(
        ns.System(
            n_q=2,
            mass=diagonal(1, 1),
            force=force,
            gap=gap,
            gap_rate=gap_rate,
            normal=normal,
            tangent=tangent,
            surface_velocity=surface_velocity,
            contacts=[ns.Contact(mu=0.4)],
        ),
        [0, 0],
        [0.1, 0.08],
        1.0,
    )


@case
def hopping_feeder():
    """The same with a > g: it flies once a period."""

    def force(t, q, u, p, h):
        h[1] = -9.81

    def gap(t, q, p, g):
        g[0] = q[1] - 1e-3 * math.sin(120 * t)

    def gap_rate(t, q, p, w):
        w[0] = -0.12 * math.cos(120 * t)

    def normal(t, q, p, W):
        W[0, 1] = 1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    def surface_velocity(t, q, p, w):
        w[0, 0] = -0.24 * math.cos(120 * t)

    return Case(
        ns.System(
            n_q=2,
            mass=diagonal(1, 1),
            force=force,
            gap=gap,
            gap_rate=gap_rate,
            normal=normal,
            tangent=tangent,
            surface_velocity=surface_velocity,
            contacts=[ns.Contact(mu=0.4, e_N=0.1)],
        ),
        [0, 0],
        [0.1, 0.12],
        0.5,
    )


@case
def ball_on_a_shaken_table():
    def force(t, q, u, p, h):
        h[0] = -9.81

    def gap(t, q, p, g):
        g[0] = q[0] - 0.01 * math.sin(25 * t)

    def gap_rate(t, q, p, w):
        w[0] = -0.25 * math.cos(25 * t)

    def normal(t, q, p, W):
        W[0, 0] = 1.0

    return Case(
        ns.System(
            n_q=1,
            mass=diagonal(1),
            force=force,
            gap=gap,
            gap_rate=gap_rate,
            normal=normal,
            contacts=[ns.Contact(e_N=0.4)],
        ),
        [0.1],
        [0],
        1.5,
    )


@case
def bead_on_a_hoop():
    def force(t, q, u, p, h):
        h[0] = 1.5 * math.cos(2 * t)
        h[1] = -9.81

    def gap(t, q, p, g):
        g[0] = math.sqrt(q[0] ** 2 + q[1] ** 2) - 0.7

    def normal(t, q, p, W):
        r = math.sqrt(q[0] ** 2 + q[1] ** 2)
        W[0, 0] = q[0] / r
        W[0, 1] = q[1] / r

    def tangent(t, q, p, W):
        r = math.sqrt(q[0] ** 2 + q[1] ** 2)
        W[0, 0, 0] = -q[1] / r
        W[0, 0, 1] = q[0] / r

    return Case(
        ns.System(
            n_q=2,
            mass=diagonal(1, 1),
            force=force,
            gap=gap,
            normal=normal,
            tangent=tangent,
            contacts=[ns.Contact(mu=0.15, bilateral=True)],
        ),
        [0.7 * math.sin(2.5), 0.7 * -math.cos(2.5)],
        [0, 0],
        6.0,
    )


@case
def stribeck_belt():
    def force(t, q, u, p, h):
        h[0] = -100 * q[0] - 0.5 * u[0] + 2 * math.sin(8 * t)

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    def surface_velocity(t, q, p, w):
        w[0, 0] = -0.1

    def N(t, q, u, p, N):
        N[0] = 10.0

    return Case(
        ns.System(
            n_q=1,
            mass=diagonal(1),
            force=force,
            tangent=tangent,
            surface_velocity=surface_velocity,
            normal_force=N,
            contacts=[ns.Contact(mu=ns.Stribeck(0.4, 0.2, 0.1), normal_force=True)],
        ),
        [0.0],
        [0],
        6.0,
    )


@case
def two_masses_static_kinetic():
    def force(t, q, u, p, h):
        h[0] = -60 * q[0] + 40 * (q[1] - q[0]) - 0.3 * u[0]
        h[1] = -40 * (q[1] - q[0]) - 50 * q[1] - 0.3 * u[1]

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0
        W[1, 0, 1] = 1.0

    def surface_velocity(t, q, p, w):
        w[0, 0] = -0.15
        w[1, 0] = -0.15

    def N(t, q, u, p, N):
        N[0] = 12.0
        N[1] = 15.0

    return Case(
        ns.System(
            n_q=2,
            mass=diagonal(1, 1.4),
            force=force,
            tangent=tangent,
            surface_velocity=surface_velocity,
            normal_force=N,
            contacts=[ns.Contact(mu=ns.StaticKinetic(0.5, 0.3), normal_force=True)] * 2,
        ),
        [0.0, 0.02],
        [0, 0.1],
        5.0,
    )


@case
def bowling_ball():
    """Slides, rolls, and is pushed back: q = (x, y, th), r = 0.11."""

    def force(t, q, u, p, h):
        h[0] = 12 * math.sin(2 * t)
        h[1] = -6 * 9.81

    def gap(t, q, p, g):
        g[0] = q[1] - 0.11

    def normal(t, q, p, W):
        W[0, 1] = 1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0
        W[0, 0, 2] = 0.11

    return Case(
        ns.System(
            n_q=3,
            mass=diagonal(6, 6, 0.4 * 6 * 0.0121),
            force=force,
            gap=gap,
            normal=normal,
            tangent=tangent,
            contacts=[ns.Contact(mu=0.08)],
        ),
        [0, 0.11, 0],
        [4, 0, 0],
        6.0,
    )


@case
def disc_on_a_shaken_plate():
    def force(t, q, u, p, h):
        h[0] = -8 * q[0]
        h[1] = -9.81

    def gap(t, q, p, g):
        g[0] = q[1] - 0.2 - 5e-3 * math.sin(20 * t)

    def gap_rate(t, q, p, w):
        w[0] = -0.1 * math.cos(20 * t)

    def normal(t, q, p, W):
        W[0, 1] = 1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0
        W[0, 0, 2] = 0.2

    def surface_velocity(t, q, p, w):
        w[0, 0] = -1.2 * math.cos(6 * t)

    return Case(
        ns.System(
            n_q=3,
            mass=diagonal(1, 1, 0.02),
            force=force,
            gap=gap,
            gap_rate=gap_rate,
            normal=normal,
            tangent=tangent,
            surface_velocity=surface_velocity,
            contacts=[ns.Contact(mu=0.25)],
        ),
        [0, 0.2, 0],
        [0, 0.1, 0],
        3.0,
    )


@case
def block_in_air():
    """Coulomb's friction and quadratic drag, pushed; the force reads u, its Jacobian is left out."""

    def force(t, q, u, p, h):
        h[0] = 9 * math.sin(1.5 * t) - 0.8 * u[0] * abs(u[0])
        h[1] = -9.81

    def gap(t, q, p, g):
        g[0] = q[1]

    def normal(t, q, p, W):
        W[0, 1] = 1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    return Case(
        ns.System(
            n_q=2,
            mass=diagonal(1, 1),
            force=force,
            gap=gap,
            normal=normal,
            tangent=tangent,
            contacts=[ns.Contact(mu=0.25)],
        ),
        [0, 0],
        [6, 0],
        10.0,
    )


@case
def between_two_walls():
    def force(t, q, u, p, h):
        h[0] = 20 * math.cos(9 * t) - 15 * q[0] - 0.1 * u[0] ** 3

    def gap(t, q, p, g):
        g[0] = q[0] + 0.2
        g[1] = 0.2 - q[0]

    def normal(t, q, p, W):
        W[0, 0] = 1.0
        W[1, 0] = -1.0

    return Case(
        ns.System(n_q=1, mass=diagonal(1), force=force, gap=gap, normal=normal, contacts=[ns.Contact(e_N=0.6)] * 2),
        [0.0],
        [0.5],
        3.0,
    )


@case
def block_on_two_feet():
    """Pushed at its height: sticks, slides, tilts, and lands again."""

    def force(t, q, u, p, h):
        F = 9.0 * math.sin(3 * t)
        h[0] = F
        h[1] = -2 * 9.81
        h[2] = -F * 0.15 * math.cos(q[2])

    def gap(t, q, p, g):
        g[0] = q[1] - 0.3 * math.cos(q[2]) - 0.15 * math.sin(q[2])
        g[1] = q[1] - 0.3 * math.cos(q[2]) + 0.15 * math.sin(q[2])

    def normal(t, q, p, W):
        for k in range(2):
            s = -0.15 if k == 0 else 0.15
            W[k, 1] = 1.0
            W[k, 2] = 0.3 * math.sin(q[2]) + s * math.cos(q[2])

    def tangent(t, q, p, W):
        for k in range(2):
            s = -0.15 if k == 0 else 0.15
            W[k, 0, 0] = 1.0
            W[k, 0, 2] = 0.3 * math.cos(q[2]) - s * math.sin(q[2])

    return Case(
        ns.System(
            n_q=3,
            mass=diagonal(2, 2, 2 * (0.3**2 + 0.6**2) / 12),
            force=force,
            gap=gap,
            normal=normal,
            tangent=tangent,
            contacts=[ns.Contact(mu=0.42)] * 2,
        ),
        [0, 0.3, 0],
        [0, 0, 0],
        3.0,
    )


@case
def rocking_on_a_shaken_floor():
    def force(t, q, u, p, h):
        h[1] = -9.81

    def gap(t, q, p, g):
        g[0] = q[1] - 0.4 * math.cos(q[2]) - 0.15 * math.sin(q[2])
        g[1] = q[1] - 0.4 * math.cos(q[2]) + 0.15 * math.sin(q[2])

    def normal(t, q, p, W):
        for k in range(2):
            s = -0.15 if k == 0 else 0.15
            W[k, 1] = 1.0
            W[k, 2] = 0.4 * math.sin(q[2]) + s * math.cos(q[2])

    def tangent(t, q, p, W):
        for k in range(2):
            s = -0.15 if k == 0 else 0.15
            W[k, 0, 0] = 1.0
            W[k, 0, 2] = 0.4 * math.cos(q[2]) - s * math.sin(q[2])

    def surface_velocity(t, q, p, w):
        for k in range(2):
            w[k, 0] = -0.6 * math.sin(8 * t)

    return Case(
        ns.System(
            n_q=3,
            mass=diagonal(1, 1, 0.06),
            force=force,
            gap=gap,
            normal=normal,
            tangent=tangent,
            surface_velocity=surface_velocity,
            contacts=[ns.Contact(mu=0.8)] * 2,
        ),
        [0, 0.4, 0],
        [0, 0, 0],
        1.2,
    )


@case
def centrifugal_brake():
    """Shoes press on the drum with m r w^2 - F: the load reads u, and is none below a speed."""

    def force(t, q, u, p, h):
        h[0] = 6 * math.sin(0.8 * t) + 1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 0.3

    def N(t, q, u, p, N):
        N[0] = max(0.0, 0.1 * u[0] ** 2 - 4.0)

    return Case(
        ns.System(
            n_q=1,
            mass=diagonal(0.5),
            force=force,
            tangent=tangent,
            normal_force=N,
            contacts=[ns.Contact(mu=0.4, normal_force=True)],
        ),
        [0],
        [0],
        10.0,
    )


@case
def rough_pivot():
    """A pendulum whose friction torque is mu r |reaction|, the reaction m (g cos + l w^2) reads u."""

    def force(t, q, u, p, h):
        h[0] = -9.81 * 1.2 * 0.5 * math.sin(q[0]) + 0.8 * math.cos(4 * t)

    def tangent(t, q, p, W):
        W[0, 0, 0] = 0.05

    def N(t, q, u, p, N):
        N[0] = 1.2 * (9.81 * math.cos(q[0]) + 0.5 * u[0] ** 2 + 12.0)

    return Case(
        ns.System(
            n_q=1,
            mass=diagonal(0.3),
            force=force,
            tangent=tangent,
            normal_force=N,
            contacts=[ns.Contact(mu=0.3, normal_force=True)],
        ),
        [1.2],
        [0],
        8.0,
    )


@case
def ladder():
    """A rod leans on a wall and a floor and slides down."""

    def force(t, q, u, p, h):
        h[1] = -9.81

    def gap(t, q, p, g):
        g[0] = q[1] - math.sin(q[2])
        g[1] = q[0] - math.cos(q[2])

    def normal(t, q, p, W):
        W[0, 1] = 1.0
        W[0, 2] = -math.cos(q[2])
        W[1, 0] = 1.0
        W[1, 2] = math.sin(q[2])

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0
        W[0, 0, 2] = -math.sin(q[2])
        W[1, 0, 1] = 1.0
        W[1, 0, 2] = math.cos(q[2])

    th = 1.1
    return Case(
        ns.System(
            n_q=3,
            mass=diagonal(1, 1, 1 / 3),
            force=force,
            gap=gap,
            normal=normal,
            tangent=tangent,
            contacts=[ns.Contact(mu=0.2), ns.Contact(mu=0.15)],
        ),
        [math.cos(th), math.sin(th), th],
        [0, 0, 0],
        0.9,
    )


@case
def three_given_loads():
    """A chain of three masses, each under a brake of its own."""

    def force(t, q, u, p, h):
        h[0] = 30 * (q[1] - q[0]) - 40 * q[0]
        h[1] = 30 * (q[0] - q[1]) + 30 * (q[2] - q[1])
        h[2] = 30 * (q[1] - q[2]) - 40 * q[2] + 9 * math.cos(5 * t)

    def tangent(t, q, p, W):
        for k in range(3):
            W[k, 0, k] = 1.0

    def N(t, q, u, p, N):
        N[0] = 4.0
        N[1] = 6.0
        N[2] = 5.0 + 2 * math.sin(3 * t)

    return Case(
        ns.System(
            n_q=3,
            mass=diagonal(1, 0.8, 1.2),
            force=force,
            tangent=tangent,
            normal_force=N,
            contacts=[ns.Contact(mu=0.3, normal_force=True)] * 3,
        ),
        [0.1, 0, -0.1],
        [0, 0.5, 0],
        8.0,
    )


@case
def incline_that_tilts():
    """A block on an incline that tilts to and fro: the floor turns about the origin with phi = 0.6 sin t."""

    def force(t, q, u, p, h):
        h[1] = -9.81

    def gap(t, q, p, g):
        f = 0.6 * math.sin(2 * t)
        g[0] = -math.sin(f) * q[0] + math.cos(f) * q[1]

    def gap_rate(t, q, p, w):
        f = 0.6 * math.sin(2 * t)
        d = 1.2 * math.cos(2 * t)
        w[0] = -d * (math.cos(f) * q[0] + math.sin(f) * q[1])

    def normal(t, q, p, W):
        f = 0.6 * math.sin(2 * t)
        W[0, 0] = -math.sin(f)
        W[0, 1] = math.cos(f)

    def tangent(t, q, p, W):
        f = 0.6 * math.sin(2 * t)
        W[0, 0, 0] = math.cos(f)
        W[0, 0, 1] = math.sin(f)

    def surface_velocity(t, q, p, w):
        f = 0.6 * math.sin(2 * t)
        d = 1.2 * math.cos(2 * t)
        w[0, 0] = -d * (math.sin(f) * q[0] - math.cos(f) * q[1])

    return Case(
        ns.System(
            n_q=2,
            mass=diagonal(1, 1),
            force=force,
            gap=gap,
            gap_rate=gap_rate,
            normal=normal,
            tangent=tangent,
            surface_velocity=surface_velocity,
            contacts=[ns.Contact(mu=0.3)],
        ),
        [0.3, 0],
        [0, 0.36],
        4.0,
    )


@case
def wobbling_load():
    """A block under a vertical force that nearly lifts it, pushed along: slip starts and ends with the load."""

    def force(t, q, u, p, h):
        h[0] = 2.0 - 3 * q[0]
        h[1] = -9.81 + 8.5 * math.sin(11 * t)

    def gap(t, q, p, g):
        g[0] = q[1]

    def normal(t, q, p, W):
        W[0, 1] = 1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    return Case(
        ns.System(
            n_q=2,
            mass=diagonal(1, 1),
            force=force,
            gap=gap,
            normal=normal,
            tangent=tangent,
            contacts=[ns.Contact(mu=ns.StaticKinetic(0.5, 0.35))],
        ),
        [0, 0],
        [0, 0],
        5.0,
    )


FAST = ["block reverses", "two guides", "piston with clearance", "five bar", "belt whose load reads u", "feeder",
        "two blocks on a table", "three blocks on a shaken table", "block on two feet", "bead on a hoop"]  # fmt: skip
ALONE = ["block reverses", "two guides", "piston with clearance", "five bar", "centrifugal brake", "stribeck belt"]


def run(case, rtol, **more):
    integrator = ns.Adaptive(rtol, 1e-2 * rtol)
    return ns.simulate(case.system, (0, case.t_end), case.q0, case.u0, integrator=integrator, **more)


def error(case, rtol, exact):
    """Error of Adaptive [tolerances]."""
    return distance(run(case, rtol)(times(case)).q, exact) / rtol


def distance(q, exact):
    return (np.abs(q - exact) / (1e-2 + np.abs(exact).max(axis=0))).max()


def times(case):
    return np.linspace(0, case.t_end, 61)


def by_events(case):
    """Coordinates of EventDriven."""
    integrator = ns.EventDriven(1e-12, 1e-14)
    return ns.simulate(case.system, (0, case.t_end), case.q0, case.u0, integrator=integrator, t_eval=times(case)).q


def by_trying(case):
    """Coordinates of SciPy, in steps that see a slip as short as a five-hundredth of the span."""
    motion = peers.adapter("scipy_modes").motion
    return motion(case.system, case.q0, case.u0, times(case), max_step=case.t_end / 500)[0]


@pytest.mark.upkeep
@pytest.mark.parametrize("name", FAST)
def test_error_is_a_few_tolerances(name):
    case = SYSTEMS[name]()
    exact = by_events(case)
    assert max(error(case, rtol, exact) for rtol in (1e-5, 1e-8)) < MOST


@pytest.mark.upkeep
@pytest.mark.parametrize("name", ALONE)
def test_motion_is_that_of_scipy_with_modes_found_by_trying_all(name):
    case = SYSTEMS[name]()
    exact = by_trying(case)
    assert max(error(case, rtol, exact) for rtol in (1e-6, 1e-8, 1e-10)) < MOST
    assert distance(by_events(case), exact) < ALIKE


def test_block_rests_on_two_feet_whatever_of_the_tolerance_is_rounding():
    """At rest on both the errors of steps are rounding of a shared load, 1e-60 or 1e-4 of the tolerance by chance."""
    case = SYSTEMS["block on two feet"]()
    fine, coarse = (
        ns.simulate(case.system, (0, case.t_end), case.q0, case.u0, integrator=ns.EventDriven(1e-12, atol))
        for atol in (1e-14, 1e-13)
    )
    assert fine.q[-1] == pytest.approx(coarse.q[-1], abs=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(SYSTEMS))
def test_error_is_a_few_tolerances_at_every_tolerance(name):
    case = SYSTEMS[name]()
    exact = by_trying(case)
    assert max(error(case, rtol, exact) for rtol in 10.0 ** -np.arange(4, 10.5)) < MOST
    assert distance(by_events(case), exact) < ALIKE


@pytest.mark.parametrize("name", ["stribeck belt", "between two walls", "bead on a hoop"])
def test_motion_between_the_steps_is_as_exact_as_at_their_ends(name):
    """Velocities too, a hundredth of a second away from impacts; where steps were as long as their ends allow,
    velocities between them were off by up to 620 tolerances."""
    case = SYSTEMS[name]()
    for rtol in (1e-6, 1e-8):
        sol = run(case, rtol)
        t = np.setdiff1d(np.linspace(0, case.t_end, 401), [0.0])
        impacts = np.array([event.t for event in sol.events if event.kind == ns.EventKind.IMPACT])
        t = np.r_[0, [s for s in t if not (np.abs(impacts - s) < 1e-2).any()]]
        exact = ns.simulate(case.system, (0, case.t_end), case.q0, case.u0, integrator=ns.EventDriven(1e-12, 1e-14),
                            t_eval=t)  # fmt: skip
        assert distance(sol(t).q, exact.q) < MOST * rtol
        assert distance(sol(t).u, exact.u) < MOST * rtol


def test_piston_that_lies_on_a_wall_strikes_it_with_its_other_end_too():
    """By hand: the end that lies on the wall would be pushed into it, W_0 M^-1 W_1^T < 0, so both take impulses.

    P = A^-1 (0, -(1 + e) gamma_1), A = G_NN - mu G_NF with both ends sliding on; every other set of modes breaks a
    condition: what opens goes into the wall, what sticks is beyond the cone.
    """
    case, e, mu = SYSTEMS["piston with clearance"](), 0.3, 0.1
    W_N, W_F, M = np.array([[-1, -0.03], [-1, 0.03]]), np.array([[0, 0.025]] * 2), np.diag([0.5, 2e-4])
    A = W_N @ np.linalg.solve(M, (W_N - mu * W_F).T)
    for integrator in (ns.EventDriven(1e-12, 1e-14), ns.Adaptive(1e-10, 1e-12)):
        sol = ns.simulate(case.system, (0, 0.01), case.q0, case.u0, integrator=integrator)
        strike = next(event for event in sol.events if event.contact == 1)
        before, after = sol(strike.t, side="left"), sol(strike.t)
        gamma = W_N @ before.u
        assert gamma[0] == pytest.approx(0.0, abs=1e-9) and gamma[1] < -1.0
        P = np.linalg.solve(A, [0.0, -(1 + e) * gamma[1]])
        assert (P > 0.0).all()
        assert after.u == pytest.approx(before.u + np.linalg.solve(M, (W_N - mu * W_F).T @ P), rel=1e-8)
        assert strike.P_N == pytest.approx(P[1], rel=1e-8)
        assert after.u @ M @ after.u < 0.1 * before.u @ M @ before.u


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("cut", [True, False])
def test_block_slides_freely_while_its_given_load_is_none(way, cut):
    """N = max(0, |t - 2| - 1), m = 1, F = 1/2, mu = 2/5, u(0) = -6/5: u turns at t = 2, within the time without load.

    u(1) = -1/2, u(3) = 1/2, and u(5) = 7/10; x(5) is the sum of cubic polynomials. The model may cut the load or leave
    it to be cut.
    """

    def force(t, q, u, p, h):
        h[0] = 0.5 * way

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    def normal_force(t, q, u, p, N):
        N[0] = max(0.0, abs(t - 2) - 1) if cut else abs(t - 2) - 1

    system = ns.System(
        n_q=1, mass=diagonal(1), force=force, tangent=tangent, normal_force=normal_force,
        contacts=[ns.Contact(mu=0.4, normal_force=True)],
    )  # fmt: skip
    loaded = -1.2 + 0.5 / 2 + 0.4 * (1 / 2 - 1 / 6)  # x(1) = -6/5 + F/2 + mu (t^2/2 - t^3/6)
    x = loaded + 0.0 + (0.5 * 2 + 0.5 * 2**2 / 2 - 0.4 * 2**3 / 6)  # from -1/2 to 1/2 and back over 1 ... 3
    for rtol in 10.0 ** -np.arange(4, 10.5):
        sol = ns.simulate(system, (0, 5), [0], [-1.2 * way], integrator=ns.Adaptive(rtol, 1e-2 * rtol))
        assert sol.u[-1, 0] == pytest.approx(0.7 * way, abs=MOST * rtol)
        assert sol.q[-1, 0] == pytest.approx(x * way, abs=MOST * rtol)
        assert sol.stats.steps < 200
        turns = [event.t for event in sol.events if event.slip_after == way]
        assert turns == pytest.approx([2.0], abs=MOST * rtol)


def test_block_under_a_swinging_force_ends_where_dop853_has_it():
    """x(4) by DOP853 at 1e-13 between the reversals of the slide."""
    case = SYSTEMS["block reverses"]()
    for rtol in (1e-4, 1e-6, 1e-8, 1e-10):
        sol = ns.simulate(case.system, (0, 4), case.q0, case.u0, integrator=ns.Adaptive(rtol, 1e-2 * rtol))
        assert abs(sol.q[-1, 0] + 1.0849897610404828) < MOST * rtol


@pytest.mark.parametrize("speed", [0.0, 1e-7])
def test_slow_body_on_a_fast_table_feels_its_acceleration(speed):
    """Sticking on a table that shakes with 300 rad/s, a body is where the table is, and its load is that of gravity."""

    def surface_velocity(t, q, p, w):
        w[0, 0] = -1e-5 * math.cos(300 * t)

    def force(t, q, u, p, h):
        h[1] = -9.81

    def gap(t, q, p, g):
        g[0] = q[1]

    def normal(t, q, p, W):
        W[0, 1] = 1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    system = ns.System(
        n_q=2, mass=diagonal(1, 1), force=force, gap=gap, normal=normal, tangent=tangent,
        surface_velocity=surface_velocity, contacts=[ns.Contact(mu=0.5)],
    )  # fmt: skip
    for integrator in (ns.EventDriven(1e-10, 1e-14), ns.Adaptive(1e-10, 1e-14)):
        sol = ns.simulate(system, (0, 0.2), [0, 0], [1e-5 + speed, 0], integrator=integrator)
        sticks = sol.t > 0.01
        slip = sol.q[sticks, 0] - 1e-5 / 300 * np.sin(300 * sol.t[sticks])
        assert np.ptp(slip) < 1e-13


@pytest.mark.parametrize("which", ["force", "load"])
def test_moreau_jean_is_of_second_order_where_a_load_reads_the_velocity(which):
    """A slide that no event interrupts: errors fall by four where the step is halved."""

    def force(t, q, u, p, h):
        h[0] = -q[0] - (0.3 * u[0] * abs(u[0]) if which == "force" else 0.0)

    def normal_force(t, q, u, p, N):
        N[0] = 2.0 + q[0] ** 2 + (0.5 * u[0] if which == "load" else 0.0)

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    def surface_velocity(t, q, p, w):
        w[0, 0] = -3.0

    system = ns.System(
        n_q=1, mass=diagonal(1), force=force, tangent=tangent, surface_velocity=surface_velocity,
        normal_force=normal_force, contacts=[ns.Contact(mu=0.5, normal_force=True)],
    )  # fmt: skip
    exact = ns.simulate(system, (0, 2), [0], [-0.1], integrator=ns.EventDriven(1e-12, 1e-14)).q[-1, 0]
    coarse, fine = (
        abs(ns.simulate(system, (0, 2), [0], [-0.1], integrator=ns.MoreauJean(dt)).q[-1, 0] - exact)
        for dt in (1e-2, 5e-3)
    )
    assert 3.5 < coarse / fine < 4.5


def test_run_that_gets_nowhere_ends_with_a_word():
    """A force of 1e12 rad/s asks for steps of 1e-12 s: 1e12 of them."""

    def force(t, q, u, p, h):
        h[0] = 1e3 * math.cos(1e12 * t)

    system = ns.System(n_q=1, mass=diagonal(1), force=force)
    sol = ns.simulate(system, (0, 1), [0], [0], integrator=ns.Adaptive(1e-10, 1e-12), on_failure="return")
    assert sol.status == ns.Status.BUDGET_SPENT and "gets nowhere" in sol.message


def test_belt_without_impacts_gains_no_energy_at_one():
    """Forced, with Stribeck's friction, at a loose tolerance; a gain of energy would be warned of."""
    case = SYSTEMS["stribeck belt"]()
    assert (
        ns.simulate(case.system, (0, case.t_end), case.q0, case.u0, integrator=ns.Adaptive(1e-4)).stats.energy_gains
        == 0
    )


def slip_at_a_crest(part):
    """(Begin, length) of the slip under F = part mu m g sin(3 t): v' = mu g (part sin(3 t) - 1) until v = 0."""
    begin = math.asin(1 / part) / 3

    def velocity(t):
        return part * (math.cos(3 * begin) - math.cos(3 * t)) / 3 - (t - begin)

    end = brentq(velocity, math.pi / 3 - begin, math.pi / 3, xtol=1e-15)
    way = part * (math.cos(3 * begin) * (end - begin) / 3 - (math.sin(3 * end) - math.sin(3 * begin)) / 9)
    return begin, 0.3 * 9.81 * (way - (end - begin) ** 2 / 2)


@pytest.mark.parametrize("part", [0.9999, 1.0001, 1.01])
def test_block_pushed_almost_to_its_friction_slips_where_it_is_pushed_beyond(part):
    """At rest until sin(3 t) = 1/part, at every crest, to and fro alike; and not at all below 1."""
    begin, slip = slip_at_a_crest(part) if part > 1 else (0.0, 0.0)

    def force(t, q, u, p, h):
        h[0], h[1] = part * 0.3 * 9.81 * math.sin(3 * t), -9.81

    def gap(t, q, p, g):
        g[0] = q[1]

    def normal(t, q, p, W):
        W[0, 1] = 1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    system = ns.System(
        n_q=2, mass=diagonal(1, 1), force=force, gap=gap, normal=normal, tangent=tangent, contacts=[ns.Contact(mu=0.3)]
    )
    for rtol in (1e-4, 1e-8):
        sol = ns.simulate(system, (0, 4), [0, 0], [0, 0], integrator=ns.Adaptive(rtol))
        begins = [event.t for event in sol.events if event.mode_after == ns.ContactMode.SLIDE]
        crests = [begin + math.pi / 3 * k for k in range(4)] if part > 1 else []
        assert begins == pytest.approx(crests, abs=3 * rtol)  # within 1e-2 rtol of the force, over its slope there
        assert np.abs(sol.q[:, 0]).max() == pytest.approx(slip, rel=1e-2, abs=1e-10)
