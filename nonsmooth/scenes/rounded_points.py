"""Contacts of rounded points of planar bodies: gaps, rows, and their rates.

A point is an arm a from the centre of mass of a body, rounded by a radius r; the other one may be a point of a
half-plane:

    d = x_i + R_i a_i - x_j - R_j a_j,    g_N = n . d - r_i - r_j,    n = d/|d|, or the normal of the half-plane

With t = (n_y, -n_x), d' the rate of d, and the body axes' belts s turned into those of the world:

    gamma_N = n . d',    gamma_F = t . d' + r_i th_i' + r_j th_j' + t . (s_i - s_j)
    n' = w t,  t' = -w n,  w = t . d'/|d| (half-plane: 0)

A guided body has no coordinates: x and R are functions of the time, and what they give stands in w_N and w_F.
Source: Pfeiffer and Glocker, *Multibody Dynamics with Unilateral Contacts* (1996), ch. 4.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

NO_COORDINATES = -1  # code: in place of the number of a body that moves


class Side(NamedTuple):
    """One side of a contact: a rounded point of a body."""

    body: int  # its number among those that move by forces, or NO_COORDINATES
    arm: np.ndarray  # (2,) from the centre of mass in the body's axes [m]; of a guided one, from its origin
    radius: float  # [m]
    belt: np.ndarray  # (2,) surface velocity in the same axes [m/s]
    place: np.ndarray  # (3,) of a guided body at the start; of a fixed one 0: its arm is in the world
    rate: np.ndarray  # (3,) its velocity [m/s, m/s, rad/s]
    of_scene: int  # number of the body among all of the scene


class Touch(NamedTuple):
    """A contact: side i on side j."""

    i: Side
    j: Side
    normal: np.ndarray | None  # (2,) of a half-plane on side j; None between two points


class Ends(NamedTuple):
    """What the contacts are of, constants of the compiled functions; of side 0, which is i, and side 1, which is j."""

    body: np.ndarray  # (n_c, 2)
    is_flat: np.ndarray  # (n_c,)
    is_guided: np.ndarray  # (n_c, 2)


class Tables(NamedTuple):
    """Their numbers, which the compiled functions read: scenes of other numbers have the same code."""

    arm: np.ndarray  # (n_c, 2, 2) [m]
    radius: np.ndarray  # (n_c, 2) [m]
    belt: np.ndarray  # (n_c, 2, 2) [m/s]
    place: np.ndarray  # (n_c, 2, 3), where it is guided
    rate: np.ndarray  # (n_c, 2, 3)
    normal: np.ndarray  # (n_c, 2), where it is flat
    t_0: float  # when guided bodies are at their places [s]


def tables_of(touches: list[Touch], t_0: float) -> tuple[Ends, Tables]:
    """Both of a list of contacts."""
    sides = [(touch.i, touch.j) for touch in touches]
    columns = {
        name: np.array([[getattr(side, name) for side in pair] for pair in sides])
        for name in ("body", "arm", "radius", "belt", "place", "rate")
    }
    body, guided = columns.pop("body"), columns["place"].any(axis=2) | columns["rate"].any(axis=2)
    ends = Ends(body, np.array([touch.normal is not None for touch in touches]), np.asarray(guided))
    normal = np.array([np.zeros(2) if touch.normal is None else touch.normal for touch in touches])
    return ends, Tables(**columns, normal=normal, t_0=t_0)


def angle(t, q, of, at, c, side):
    """That of the body of a side; 0 of a fixed one."""
    b = of.body[c, side]
    if b != NO_COORDINATES:
        return q[3 * b + 2]
    return at.place[c, side, 2] + at.rate[c, side, 2] * (t - at.t_0) if of.is_guided[c, side] else 0.0


def turned(t, q, of, at, c, side, v):
    """A vector in the axes of the body of a side in those of the world."""
    if of.body[c, side] == NO_COORDINATES and not of.is_guided[c, side]:
        return v[0], v[1]
    th = angle(t, q, of, at, c, side)
    return math.cos(th) * v[0] - math.sin(th) * v[1], math.sin(th) * v[0] + math.cos(th) * v[1]


def point(t, q, of, at, c, side):
    """x + R a."""
    a_x, a_y = turned(t, q, of, at, c, side, at.arm[c, side])
    b = of.body[c, side]
    if b != NO_COORDINATES:
        return q[3 * b] + a_x, q[3 * b + 1] + a_y
    if of.is_guided[c, side]:
        x, y = at.place[c, side, 0] + at.rate[c, side, 0] * (t - at.t_0), at.place[c, side, 1]
        return x + a_x, y + at.rate[c, side, 1] * (t - at.t_0) + a_y
    return a_x, a_y


def rates_of(u, of, at, c, side):
    """x', y' and the angular velocity of the body of a side."""
    b = of.body[c, side]
    if b != NO_COORDINATES:
        return u[3 * b], u[3 * b + 1], u[3 * b + 2]
    return at.rate[c, side, 0], at.rate[c, side, 1], at.rate[c, side, 2]


def point_rates(t, q, u, of, at, c, side):
    """The velocity of a point of a body, and its acceleration at u' = 0."""
    a_x, a_y = turned(t, q, of, at, c, side, at.arm[c, side])
    v_x, v_y, w = rates_of(u, of, at, c, side)
    return v_x - w * a_y, v_y + w * a_x, -w * w * a_x, -w * w * a_y


def belt_rates(t, q, u, of, at, c, side):
    """The velocity of a belt, and its rate as the body turns."""
    s_x, s_y = turned(t, q, of, at, c, side, at.belt[c, side])
    w = rates_of(u, of, at, c, side)[2]
    return s_x, s_y, -w * s_y, w * s_x


def between(t, q, of, at, c):
    """d of contact c."""
    i_x, i_y = point(t, q, of, at, c, 0)
    j_x, j_y = point(t, q, of, at, c, 1)
    return i_x - j_x, i_y - j_y


def direction(t, q, of, at, c):
    """n of contact c."""
    if of.is_flat[c]:
        return at.normal[c, 0], at.normal[c, 1]
    d_x, d_y = between(t, q, of, at, c)
    length = math.sqrt(d_x * d_x + d_y * d_y)
    return d_x / length, d_y / length


def turning(t, q, of, at, c, slide):
    """w of contact c, where the points slide past one another at t . d'."""
    if of.is_flat[c]:
        return 0.0
    d_x, d_y = between(t, q, of, at, c)
    return slide / math.sqrt(d_x * d_x + d_y * d_y)


def guided_rates(t, q, of, at, c):
    """d' of contact c that is of guided bodies alone, and their r_i th_i' + r_j th_j'."""
    v_x, v_y, spin = 0.0, 0.0, 0.0
    for side in range(2):
        if of.is_guided[c, side]:
            sign = 1.0 - 2.0 * side
            a_x, a_y = turned(t, q, of, at, c, side, at.arm[c, side])
            w = at.rate[c, side, 2]
            v_x += sign * (at.rate[c, side, 0] - w * a_y)
            v_y += sign * (at.rate[c, side, 1] + w * a_x)
            spin += at.radius[c, side] * w
    return v_x, v_y, spin


def write_gaps(t, q, of, at, g_N):
    """The gaps."""
    for c in range(of.body.shape[0]):
        n_x, n_y = direction(t, q, of, at, c)
        d_x, d_y = between(t, q, of, at, c)
        g_N[c] = n_x * d_x + n_y * d_y - at.radius[c, 0] - at.radius[c, 1]


def write_normals(t, q, of, at, W_N):
    """The gradients of the gaps."""
    for c in range(of.body.shape[0]):
        n_x, n_y = direction(t, q, of, at, c)
        for side in range(2):
            b, sign = of.body[c, side], 1.0 - 2.0 * side
            if b != NO_COORDINATES:
                a_x, a_y = turned(t, q, of, at, c, side, at.arm[c, side])
                W_N[c, 3 * b] = sign * n_x
                W_N[c, 3 * b + 1] = sign * n_y
                W_N[c, 3 * b + 2] = sign * (a_x * n_y - a_y * n_x)


def write_tangents(t, q, of, at, W_F):
    """The rows of sliding."""
    for c in range(of.body.shape[0]):
        n_x, n_y = direction(t, q, of, at, c)
        for side in range(2):
            b, sign = of.body[c, side], 1.0 - 2.0 * side
            if b != NO_COORDINATES:
                a_x, a_y = turned(t, q, of, at, c, side, at.arm[c, side])
                W_F[c, 0, 3 * b] = sign * n_y
                W_F[c, 0, 3 * b + 1] = -sign * n_x
                W_F[c, 0, 3 * b + 2] = at.radius[c, side] - sign * (a_x * n_x + a_y * n_y)


def write_gap_rates(t, q, of, at, w_N):
    """What guided bodies give to the rates of the gaps."""
    for c in range(of.body.shape[0]):
        n_x, n_y = direction(t, q, of, at, c)
        v_x, v_y, _ = guided_rates(t, q, of, at, c)
        w_N[c] = n_x * v_x + n_y * v_y


def write_surfaces(t, q, of, at, w_F):
    """What belts and guided bodies give to sliding."""
    for c in range(of.body.shape[0]):
        n_x, n_y = direction(t, q, of, at, c)
        i_x, i_y = turned(t, q, of, at, c, 0, at.belt[c, 0])
        j_x, j_y = turned(t, q, of, at, c, 1, at.belt[c, 1])
        v_x, v_y, spin = guided_rates(t, q, of, at, c)
        w_F[c, 0] = n_y * (i_x - j_x + v_x) - n_x * (i_y - j_y + v_y) + spin


def write_row_rates(t, q, u, of, at, r):
    """The rates of the rows along the motion."""
    for c in range(of.body.shape[0]):
        n_x, n_y = direction(t, q, of, at, c)
        vi_x, vi_y, ai_x, ai_y = point_rates(t, q, u, of, at, c, 0)
        vj_x, vj_y, aj_x, aj_y = point_rates(t, q, u, of, at, c, 1)
        si_x, si_y, bi_x, bi_y = belt_rates(t, q, u, of, at, c, 0)
        sj_x, sj_y, bj_x, bj_y = belt_rates(t, q, u, of, at, c, 1)
        slide = n_y * (vi_x - vj_x) - n_x * (vi_y - vj_y)
        w = turning(t, q, of, at, c, slide)
        r[c, 0] = n_x * (ai_x - aj_x) + n_y * (ai_y - aj_y) + w * slide
        r[c, 1] = n_y * (ai_x + bi_x - aj_x - bj_x) - n_x * (ai_y + bi_y - aj_y - bj_y)
        r[c, 1] -= w * (n_x * (vi_x + si_x - vj_x - sj_x) + n_y * (vi_y + si_y - vj_y - sj_y))


def functions_of_touches(touches: list[Touch], t_0: float) -> tuple[dict[str, Any], Tables]:
    """The functions of a system with these contacts, and what they read as p.touches; they read the time where a body
    is guided, and only there."""
    of, tables = tables_of(touches, t_0)
    functions = _functions_of_time(of) if of.is_guided.any() else _functions_without_time(of)
    if not of.is_guided.any() and not tables.belt.any():
        del functions["surface_velocity"]
    return functions, tables


def _functions_without_time(of: Ends) -> dict[str, Any]:
    def gap(t, q, p, g_N):
        write_gaps(0.0, q, of, p.touches, g_N)

    def normal(t, q, p, W_N):
        write_normals(0.0, q, of, p.touches, W_N)

    def tangent(t, q, p, W_F):
        write_tangents(0.0, q, of, p.touches, W_F)

    def surface_velocity(t, q, p, w_F):
        write_surfaces(0.0, q, of, p.touches, w_F)

    def row_rates(t, q, u, p, r):
        write_row_rates(0.0, q, u, of, p.touches, r)

    return {
        "gap": gap, "normal": normal, "tangent": tangent, "row_rates": row_rates, "surface_velocity": surface_velocity,
    }  # fmt: skip


def _functions_of_time(of: Ends) -> dict[str, Any]:
    def gap(t, q, p, g_N):
        write_gaps(t, q, of, p.touches, g_N)

    def normal(t, q, p, W_N):
        write_normals(t, q, of, p.touches, W_N)

    def tangent(t, q, p, W_F):
        write_tangents(t, q, of, p.touches, W_F)

    def gap_rate(t, q, p, w_N):
        write_gap_rates(t, q, of, p.touches, w_N)

    def surface_velocity(t, q, p, w_F):
        write_surfaces(t, q, of, p.touches, w_F)

    def row_rates(t, q, u, p, r):
        write_row_rates(t, q, u, of, p.touches, r)

    return {
        "gap": gap, "normal": normal, "tangent": tangent, "gap_rate": gap_rate, "surface_velocity": surface_velocity,
        "row_rates": row_rates,
    }  # fmt: skip
