"""A pendulum beside a wall and a mass on a spring: a system of a user's own, with names, parts and arrays."""

import math
from typing import NamedTuple

import numpy as np

import nonsmooth as ns


class Spring(NamedTuple):
    k: float = 40.0  # stiffness [N/m]
    c: float = 0.5  # damping [N s/m]


class P(NamedTuple):
    m: np.ndarray = np.array([1.0, 2.0])  # masses [kg]
    l: float = 0.5  # length [m]
    wall: float = 0.2  # distance of the wall [m]
    spring: Spring = Spring()


def mass(t, q, p, M):
    M[0, 0] = p.m[0] * p.l**2
    M[1, 1] = p.m[1]


def force(t, q, u, p, h):
    h[0] = -9.81 * p.m[0] * p.l * math.sin(q[0])
    h[1] = -p.spring.k * q[1] - p.spring.c * u[1]


def gap(t, q, p, g_N):
    g_N[0] = p.wall - p.l * math.sin(q[0])


def shape(q, p):
    return [np.array([[0.0, 0.0], [p.l * math.sin(q[0]), -p.l * math.cos(q[0])]])]


def outline(p):
    return [np.array([[p.wall, -1.0], [p.wall, 0.0]])]


def system(**options):
    options = {"coordinates": [("th", "rad"), ("x", "m")], "name": "pendulum and mass"} | options
    return ns.System(
        mass=mass, force=force, gap=gap, contacts=[ns.Contact(e_N=0.5, name="wall")], shape=shape, outline=outline,
        **{"parameters": P()} | options,
    )  # fmt: skip
