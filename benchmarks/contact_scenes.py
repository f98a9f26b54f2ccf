"""A block with any number of contacts: what ``python -m benchmarks contacts`` times.

q = (x, y, th) of the mass centre, from where the block stands upright; the contacts are points (X, Y) of the block,

    x_i = (X cos th - Y sin th, X sin th + Y cos th),    r_i = x + x_i,

against the floor, y = -h, or the wall, x = -a. All points of one side are redundant where it lies flat.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from nonsmooth.mechanics.system import Contact, System


class Block(NamedTuple):
    m: float = 2.0  # mass [kg]
    I: float = 0.1  # central inertia [kg m^2]
    a: float = 0.5  # half width [m]
    h: float = 0.2  # half height [m]
    g: float = 9.81  # gravity [m/s^2]
    mu: float = 0.4  # friction coefficient
    e: float = 0.0  # restitution
    push: float = 0.0  # force towards the wall [N]
    v: float = 0.0  # amplitude of the velocity of the floor [m/s]
    w: float = 20.0  # its circular frequency [1/s]
    walls: float = 0.0  # number of the contacts that face the wall, the last ones


def block_mass(t, q, p, M):
    M[0, 0] = p.m
    M[1, 1] = p.m
    M[2, 2] = p.I


def block_force(t, q, u, p, h):
    h[0] = -p.push
    h[1] = -p.m * p.g


def block_gap(t, q, p, g_N):
    n, s, c = g_N.shape[0], math.sin(q[2]), math.cos(q[2])
    feet = n - int(p.walls)
    for i in range(feet):
        g_N[i] = q[1] + p.a * (2 * i / (feet - 1) - 1.0) * s - p.h * c + p.h
    for i in range(feet, n):
        g_N[i] = q[0] - p.a * c - p.h * (2 * (i - feet) / (n - feet - 1) - 1.0) * s + p.a


def block_normal(t, q, p, W_N):
    n, s, c = W_N.shape[0], math.sin(q[2]), math.cos(q[2])
    feet = n - int(p.walls)
    for i in range(feet):
        W_N[i, 1] = 1.0
        W_N[i, 2] = p.a * (2 * i / (feet - 1) - 1.0) * c + p.h * s
    for i in range(feet, n):
        W_N[i, 0] = 1.0
        W_N[i, 2] = p.a * s - p.h * (2 * (i - feet) / (n - feet - 1) - 1.0) * c


def block_tangent(t, q, p, W_F):
    n, s, c = W_F.shape[0], math.sin(q[2]), math.cos(q[2])
    feet = n - int(p.walls)
    for i in range(feet):
        W_F[i, 0, 0] = 1.0
        W_F[i, 0, 2] = p.h * c - p.a * (2 * i / (feet - 1) - 1.0) * s
    for i in range(feet, n):
        W_F[i, 0, 1] = 1.0
        W_F[i, 0, 2] = -p.a * c - p.h * (2 * (i - feet) / (n - feet - 1) - 1.0) * s


def floor_velocity(t, q, p, w_F):
    for i in range(w_F.shape[0] - int(p.walls)):
        w_F[i, 0] = -p.v * math.cos(p.w * t)


def block(n: int, parameters: Block, contact: Contact | None = None) -> System:
    """A block with n contacts, evenly along its bottom, the last ``parameters.walls`` of them along its left side."""
    contact = Contact(mu="mu", e_N="e") if contact is None else contact
    has_friction = contact.has_friction
    return System(n_q=3, mass=block_mass, force=block_force, gap=block_gap, normal=block_normal,
                  tangent=block_tangent if has_friction else None,
                  surface_velocity=floor_velocity if has_friction else None,
                  contacts=[contact] * n, parameters=parameters, name=f"block with {n} contacts")  # fmt: skip
