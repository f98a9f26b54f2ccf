"""The point mass that many tests begin with: a block on the floor y = 0, q = (x, y), and a ball above it, q = (y,)."""

from typing import NamedTuple

import nonsmooth as ns


class PointMass(NamedTuple):
    m: float = 1.0  # mass [kg]
    g: float = 9.81  # gravity [m/s^2]


def block_mass(t, q, p, M):
    M[0, 0] = M[1, 1] = p.m


def block_weight(t, q, u, p, h):
    h[1] = -p.m * p.g


def block_gap(t, q, p, g_N):
    g_N[0] = q[1]


def block_normal(t, q, p, W_N):
    W_N[0, 1] = 1.0


def block_tangent(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0


def ball_mass(t, q, p, M):
    M[0, 0] = p.m


def ball_weight(t, q, u, p, h):
    h[0] = -p.m * p.g


def ball_gap(t, q, p, g_N):
    g_N[0] = q[0]


def ball_normal(t, q, p, W_N):
    W_N[0, 0] = 1.0


BLOCK = {"mass": block_mass, "force": block_weight, "gap": block_gap, "normal": block_normal, "tangent": block_tangent}
BALL = {"mass": ball_mass, "force": ball_weight, "gap": ball_gap, "normal": ball_normal}


def block(contact=None, parameters=None, **changes):
    """A block on the floor; what is given takes the place of its own."""
    contacts = [ns.Contact(mu=0.3) if contact is None else contact]
    return ns.System(n_q=2, **({"contacts": contacts, "parameters": parameters or PointMass()} | BLOCK | changes))


def ball(contact=None, parameters=None, **changes):
    """A ball above the floor; what is given takes the place of its own."""
    contacts = [ns.Contact(e_N=0.5) if contact is None else contact]
    return ns.System(n_q=1, **({"contacts": contacts, "parameters": parameters or PointMass()} | BALL | changes))
