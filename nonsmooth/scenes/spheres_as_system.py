"""Spheres without friction as a system: nothing turns them, so that their centres are all the coordinates there are.

    d = x_i - x_j,    g_N = n . d - r_i - r_j,    n = d/|d|, or the normal of a half-space, whose r is 0
    gamma_N = n . d',    its rate at u' = 0:  (d'^2 - gamma_N^2)/|d|, or 0

Every method takes such a system, with q' = u and no friction in two directions; of bodies that turn: solids_as_system.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.scenes.elements import Body, Kind
from nonsmooth.scenes.inertia import inertia_of
from nonsmooth.scenes.pair_laws import coefficients_of
from nonsmooth.scenes.parts import parts_of
from nonsmooth.scenes.places import compose, place_of, rotate
from nonsmooth.scenes.rounded_points import Side, Touch
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import SPATIAL, HalfSpace, Sphere
from nonsmooth.scenes.weights import Weights, functions_of_weights

IS_FIXED = -1  # code: in place of the number of a body that moves


class Near(NamedTuple):
    """A contact of two spheres, or of a sphere i and a half-space j."""

    i: int  # its number among those that move, or IS_FIXED
    j: int
    start: np.ndarray  # (3,) of what stands: x_i, or -x_j [m]; 0 of two that move
    radius: float  # r_i + r_j [m]
    normal: np.ndarray | None  # (3,) of a half-space


def near_of(a: Body, b: Body, numbers: dict[str, int]) -> Near:
    """The contact of two bodies."""
    if isinstance(a.shape, HalfSpace):
        a, b = b, a
    i, j = (numbers.get(body.name, IS_FIXED) for body in (a, b))
    start = (i == IS_FIXED) * np.asarray(a.position) - (j == IS_FIXED) * _place_of(b)[:3]
    radius = a.shape.radius + getattr(b.shape, "radius", 0.0)  # type: ignore[attr-defined]
    is_flat = isinstance(b.shape, HalfSpace)
    return Near(i, j, start, radius, rotate(_place_of(b)[3:], np.array([0.0, 0.0, 1.0])) if is_flat else None)


def touch_of(a: Body, b: Body, numbers: dict[str, int]) -> Touch:
    """The same contact as that of two rounded points."""
    if isinstance(a.shape, HalfSpace):
        a, b = b, a
    sides = [
        Side(
            numbers.get(body.name, IS_FIXED), np.zeros(3) if body.kind is Kind.DYNAMIC else _place_of(body)[:3],
            getattr(body.shape, "radius", 0.0), np.zeros(3), np.zeros(7), np.zeros(6), body.index,
        )
        for body in (a, b)
    ]  # fmt: skip
    return Touch(sides[0], sides[1], near_of(a, b, numbers).normal)


def _place_of(body: Body) -> np.ndarray:
    """Where the only part of a body is."""
    return compose(place_of(body.position, body.turn), parts_of(body.shape, SPATIAL)[0].place)


def nothing_turns(scene: Scene) -> bool:
    """Whether all bodies are spheres on one another and on half-spaces, none of them guided, no two of which rub."""
    if any(body.kind is Kind.KINEMATIC for body in scene.bodies):
        return False
    moving = [body for body in scene.bodies if body.kind is Kind.DYNAMIC]
    are_spheres = all(isinstance(body.shape, Sphere) for body in moving)
    if not are_spheres or not all(isinstance(body.shape, Sphere | HalfSpace) for body in scene.bodies):
        return False
    pairs = ((a, b) for a in moving for b in scene.bodies if a is not b)
    return all(coefficients_of(scene, a.material, b.material)[0] == 0.0 for a, b in pairs)


class Tables(NamedTuple):
    """The numbers of the contacts, which the compiled functions read as p.touches."""

    start: np.ndarray  # (n_c, 3) [m]
    radius: np.ndarray  # (n_c,) [m]
    normal: np.ndarray  # (n_c, 3), of a half-space


def functions_of(scene: Scene, moving: list[Body], nears: list[Near]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Mass, weight, potential, gaps, rows and their rates; and what they read."""
    m = np.repeat([inertia_of(body, SPATIAL).mass for body in moving], 3)
    read: dict[str, Any] = {"weights": Weights(m, m * np.tile(np.asarray(scene.gravity, dtype=float), len(moving)))}
    if not nears:
        return functions_of_weights(), read
    flat = [np.zeros(3) if near.normal is None else near.normal for near in nears]
    columns = [near.start for near in nears], [near.radius for near in nears], flat
    return functions_of_weights() | _contact_functions(nears), read | {"touches": Tables(*map(np.array, columns))}


def between(q, i, j, start):
    """x_i - x_j; of velocities too, with start 0."""
    d_x, d_y, d_z = start[0], start[1], start[2]
    if i >= 0:
        d_x, d_y, d_z = d_x + q[3 * i], d_y + q[3 * i + 1], d_z + q[3 * i + 2]
    if j >= 0:
        d_x, d_y, d_z = d_x - q[3 * j], d_y - q[3 * j + 1], d_z - q[3 * j + 2]
    return d_x, d_y, d_z


def direction(q, body, is_flat, at, c):
    """n of contact c."""
    if is_flat[c]:
        return at.normal[c, 0], at.normal[c, 1], at.normal[c, 2]
    d_x, d_y, d_z = between(q, body[c, 0], body[c, 1], at.start[c])
    length = math.sqrt(d_x * d_x + d_y * d_y + d_z * d_z)
    return d_x / length, d_y / length, d_z / length


def _contact_functions(nears: list[Near]) -> dict[str, Any]:
    """Gap, rows and their rates."""
    body = np.array([(near.i, near.j) for near in nears])
    is_flat = np.array([near.normal is not None for near in nears])
    still = np.zeros(3)
    n_c = len(nears)

    def gap(t, q, p, g_N):
        for c in range(n_c):
            n_x, n_y, n_z = direction(q, body, is_flat, p.touches, c)
            d_x, d_y, d_z = between(q, body[c, 0], body[c, 1], p.touches.start[c])
            g_N[c] = n_x * d_x + n_y * d_y + n_z * d_z - p.touches.radius[c]

    def normal(t, q, p, W_N):
        for c in range(n_c):
            n_x, n_y, n_z = direction(q, body, is_flat, p.touches, c)
            for side in range(2):
                b, sign = body[c, side], 1.0 - 2.0 * side
                if b >= 0:
                    W_N[c, 3 * b] = sign * n_x
                    W_N[c, 3 * b + 1] = sign * n_y
                    W_N[c, 3 * b + 2] = sign * n_z

    def row_rates(t, q, u, p, r):
        for c in range(n_c):
            if not is_flat[c]:
                n_x, n_y, n_z = direction(q, body, is_flat, p.touches, c)
                d_x, d_y, d_z = between(q, body[c, 0], body[c, 1], p.touches.start[c])
                v_x, v_y, v_z = between(u, body[c, 0], body[c, 1], still)
                along = n_x * v_x + n_y * v_y + n_z * v_z
                square = v_x * v_x + v_y * v_y + v_z * v_z
                r[c, 0] = (square - along * along) / (n_x * d_x + n_y * d_y + n_z * d_z)

    return {"gap": gap, "normal": normal, "row_rates": row_rates}
