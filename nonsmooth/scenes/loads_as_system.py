"""Springs, constant forces and torques of the plane as functions of a system, in addition to weights.

With d = p_a - p_b between two points of bodies (rounded_points.py), l = |d| and phi = th_b - th_a, the first body feels

    along its line:    F = -(k (l - l_0) + c l') d/l,        V = k (l - l_0)^2/2
    as a vector:       F = f - k d - c d',                   V = k d^2/2 - f . d
    as an angle:       M = k (phi - phi_0) + c phi',         V = k (phi - phi_0)^2/2

and the second one the opposite. A force on a point of a body is a vector f against a point of the world.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.scenes.rounded_points import (
    NO_COORDINATES,
    Ends,
    Tables,
    Touch,
    angle,
    between,
    point_rates,
    rates_of,
    tables_of,
    turned,
)

OF_LINE, OF_VECTOR, OF_ANGLE = range(3)  # code: what a load is of


class Load(NamedTuple):
    """A spring between two points, or a force on one."""

    touch: Touch
    kind: int
    stiffness: float = 0.0  # [N/m], [N m/rad]
    damping: float = 0.0  # [N s/m], [N m s/rad]
    rest: float = 0.0  # [m], [rad]
    force: Any = (0.0, 0.0)  # (2,) [N]


class Laws(NamedTuple):
    """The numbers of the laws."""

    kind: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    rest: np.ndarray
    force: np.ndarray  # (n, 2)


class Loads(NamedTuple):
    """What the compiled functions read of the loads: their points and their laws."""

    points: Tables
    laws: Laws


def turn_between(t, q, of, at, c):
    """phi of load c."""
    return angle(t, q, of, at, c, 1) - angle(t, q, of, at, c, 0)


def pull(t, q, u, of, at, laws, c):
    """F of load c on its first body, and M."""
    k, b = laws.stiffness[c], laws.damping[c]
    if laws.kind[c] == OF_ANGLE:
        rate = rates_of(u, of, at, c, 1)[2] - rates_of(u, of, at, c, 0)[2]
        return 0.0, 0.0, k * (turn_between(t, q, of, at, c) - laws.rest[c]) + b * rate
    d_x, d_y = between(t, q, of, at, c)
    i_x, i_y, _, _ = point_rates(t, q, u, of, at, c, 0)
    j_x, j_y, _, _ = point_rates(t, q, u, of, at, c, 1)
    v_x, v_y = i_x - j_x, i_y - j_y
    if laws.kind[c] == OF_VECTOR:
        return laws.force[c, 0] - k * d_x - b * v_x, laws.force[c, 1] - k * d_y - b * v_y, 0.0
    length = math.sqrt(d_x * d_x + d_y * d_y)
    n_x, n_y = d_x / length, d_y / length
    F = k * (length - laws.rest[c]) + b * (n_x * v_x + n_y * v_y)
    return -F * n_x, -F * n_y, 0.0


def add_pulls(t, q, u, of, at, laws, h):
    """Add all of them to the forces."""
    for c in range(of.body.shape[0]):
        F_x, F_y, M = pull(t, q, u, of, at, laws, c)
        for side in range(2):
            b, sign = of.body[c, side], 1.0 - 2.0 * side
            if b != NO_COORDINATES:
                a_x, a_y = turned(t, q, of, at, c, side, at.arm[c, side])
                h[3 * b] += sign * F_x
                h[3 * b + 1] += sign * F_y
                h[3 * b + 2] += sign * (a_x * F_y - a_y * F_x + M)


def stored(t, q, of, at, laws):
    """V of all of them."""
    V = 0.0
    for c in range(of.body.shape[0]):
        if laws.kind[c] == OF_ANGLE:
            V += 0.5 * laws.stiffness[c] * (turn_between(t, q, of, at, c) - laws.rest[c]) ** 2
            continue
        d_x, d_y = between(t, q, of, at, c)
        length = math.sqrt(d_x * d_x + d_y * d_y) - laws.rest[c]
        V += 0.5 * laws.stiffness[c] * length * length - laws.force[c, 0] * d_x - laws.force[c, 1] * d_y
    return V


def write_forces(t, q, u, of, p, h):
    """h."""
    for k in range(len(h)):
        h[k] = p.weights.weight[k]
    add_pulls(t, q, u, of, p.loads.points, p.loads.laws, h)


def write_potential(t, q, of, p, V):
    """V."""
    V[0] = stored(t, q, of, p.loads.points, p.loads.laws)
    for k in range(len(q)):
        V[0] -= p.weights.weight[k] * q[k]


def functions_of_loads(loads: list[Load], t_0: float) -> tuple[dict[str, Any], Loads]:
    """Force and potential of weights and these, and what they read as p.loads; they read the time where a body is
    guided, and only there."""
    of, points = tables_of([load.touch for load in loads], t_0)
    laws = Laws(*(np.array([getattr(load, name) for load in loads], dtype=float) for name in Laws._fields))
    return _functions_of_time(of) if of.is_guided.any() else _functions_without_time(of), Loads(points, laws)


def _functions_without_time(of: Ends) -> dict[str, Any]:
    def force(t, q, u, p, h):
        write_forces(0.0, q, u, of, p, h)

    def potential(t, q, p, V):
        write_potential(0.0, q, of, p, V)

    return {"force": force, "potential": potential}


def _functions_of_time(of: Ends) -> dict[str, Any]:
    def force(t, q, u, p, h):
        write_forces(t, q, u, of, p, h)

    def potential(t, q, p, V):
        write_potential(t, q, of, p, V)

    return {"force": force, "potential": potential}
