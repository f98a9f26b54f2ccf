"""The systems that the core is timed on."""

from __future__ import annotations

import math
from typing import NamedTuple

from nonsmooth.mechanics.system import Contact, System


class Rod(NamedTuple):
    m: float = 1.0  # mass [kg]
    l: float = 2.0  # length [m]
    I: float = 1 / 3  # central inertia [kg m^2]
    g: float = 9.81  # gravity [m/s^2]
    mu: float = 0.5  # friction coefficient


def sliding_rod() -> System:
    """A rod on a floor: three coordinates, one frictional contact, rows that vary."""

    def mass(t, q, p, M):
        M[0, 0] = p.m
        M[1, 1] = p.m
        M[2, 2] = p.I

    def force(t, q, u, p, h):
        h[1] = -p.m * p.g

    def gap(t, q, p, g_N):
        g_N[0] = q[1] - p.l / 2 * math.sin(q[2])

    def normal(t, q, p, W_N):
        W_N[0, 1] = 1.0
        W_N[0, 2] = -p.l / 2 * math.cos(q[2])

    def tangent(t, q, p, W_F):
        W_F[0, 0, 0] = 1.0
        W_F[0, 0, 2] = p.l / 2 * math.sin(q[2])

    return System(n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent,
                  contacts=[Contact(mu="mu")], parameters=Rod(), name="rod")  # fmt: skip


class Blocks(NamedTuple):
    m: float = 1.0  # mass of a block [kg]
    k: float = 100.0  # stiffness between neighbours [N/m]
    g: float = 9.81  # gravity [m/s^2]
    mu: float = 0.3  # friction coefficient


def row_of_blocks(n: int, k: float = Blocks().k, is_stiff: bool = False) -> System:
    """n blocks on a floor, coupled by springs: q = (x_1, y_1, x_2, ...), n frictional contacts, all closed.

    A stiff row gives its stiffness k [N/m] to the methods that are implicit in it.
    """

    def mass(t, q, p, M):
        for i in range(2 * n):
            M[i, i] = p.m

    def force(t, q, u, p, h):
        for i in range(n):
            h[2 * i + 1] = -p.m * p.g
        for i in range(n - 1):
            pull = p.k * (q[2 * i + 2] - q[2 * i])
            h[2 * i] += pull
            h[2 * i + 2] -= pull

    def stiffness(t, q, u, p, K):
        for i in range(n):
            K[2 * i, 2 * i] = p.k * ((i > 0) + (i < n - 1))
        for i in range(n - 1):
            K[2 * i, 2 * i + 2] = -p.k
            K[2 * i + 2, 2 * i] = -p.k

    def gap(t, q, p, g_N):
        for i in range(n):
            g_N[i] = q[2 * i + 1]

    def normal(t, q, p, W_N):
        for i in range(n):
            W_N[i, 2 * i + 1] = 1.0

    def tangent(t, q, p, W_F):
        for i in range(n):
            W_F[i, 0, 2 * i] = 1.0

    return System(n_q=2 * n, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent,
                  stiffness=stiffness if is_stiff else None, contacts=[Contact(mu="mu")] * n,
                  parameters=Blocks(k=k), name=f"row of {n} blocks")  # fmt: skip
