"""Bodies that turn in space as a system: rounded points on half-spaces and on one another, with the round cone.

    q = (x, quaternion) a body, along its principal axes;    u = (x', w), w in those axes;    q' = B u
    m x'' = m g,    I w' = -w x I w

A point c = x + R a of a body is rounded by a radius r; it touches a half-space, or another such point:

    n = (c_i - c_j)/|c_i - c_j|, or the normal of the half-space,    g_N = n . (c_i - c_j) - r_i - r_j
    A_i = R_i a_i - r_i n,    A_j = R_j a_j + r_j n,    gamma = x_i' + w_i x A_i - x_j' - w_j x A_j + belts
    gamma' at u' = 0:  w_i x A_i' - w_j x A_j',    A_i' = w_i x R_i a_i - r_i n'

with w in the axes of the world, along n and two tangents that are smooth functions of it. A guided body has no
coordinates: its place and turn are functions of the time, and what they give stands in w_N and w_F; of a half-space it
is the velocity where the other body touches it.
Source: Pfeiffer and Glocker, *Multibody Dynamics with Unilateral Contacts* (1996), ch. 4; for the tangents, Duff and
others, *J. Comput. Graph. Tech.* 6 (2017) 1.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.scenes.elements import Body, Kind
from nonsmooth.scenes.inertia import inertia_of
from nonsmooth.scenes.parts import Part, parts_of
from nonsmooth.scenes.places import ORIGIN, compose, conjugate, inverse, place_of, rotate
from nonsmooth.scenes.rounded_points import NO_COORDINATES, Side, Touch
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shape_rows import BOX, CAPSULE, HALF_SPACE, POLYHEDRON, SPHERE
from nonsmooth.scenes.shapes import SPATIAL

SOLID = (
    ("x", "m"), ("y", "m"), ("z", "m"), ("turn w", ""), ("turn x", ""), ("turn y", ""), ("turn z", ""),
)  # fmt: skip
RATES = tuple((f"{name} rate", "m/s") for name in "xyz") + tuple((f"spin {k}", "rad/s") for k in (1, 2, 3))
ALONG_TANGENTS = ("tangent", "surface_velocity")  # defined: functions that a scene without friction has not
Vector = tuple[float, float, float]


class Ends(NamedTuple):
    """What the contacts are of, constants of the compiled functions; of side 0, which is i, and side 1, which is j."""

    body: np.ndarray  # (n_c, 2)
    is_flat: np.ndarray  # (n_c,)
    is_guided: np.ndarray  # (n_c, 2)


class Tables(NamedTuple):
    """Their numbers, which the compiled functions read as p.touches."""

    arm: np.ndarray  # (n_c, 2, 3) [m]
    radius: np.ndarray  # (n_c, 2) [m]
    belt: np.ndarray  # (n_c, 2, 3) [m/s]
    place: np.ndarray  # (n_c, 2, 7) of a guided body at t_0
    rate: np.ndarray  # (n_c, 2, 6) [m/s, rad/s]
    normal: np.ndarray  # (n_c, 3), where it is flat; of a guided half-space in its axes
    t_0: float  # [s]


class Solids(NamedTuple):
    """The numbers of the bodies, which the compiled functions read as p.bodies."""

    m: np.ndarray  # (n_b,) [kg]
    moments: np.ndarray  # (n_b, 3) [kg m^2]
    gravity: np.ndarray  # (3,) [m/s^2]


def touches_of_solids(a: Body, b: Body, numbers: dict[str, int]) -> list[Touch] | None:
    """The contacts of two bodies: points on a half-space, or two single points; None for what touches along faces."""
    found: list[Touch] = []
    for part_a in _parts(a):
        for part_b in _parts(b):
            first, second = (a, part_a), (b, part_b)
            if part_a.kind == HALF_SPACE:
                first, second = second, first
            sides_i, sides_j = (_sides(*side, numbers) for side in (first, second))
            if not sides_i or not sides_j or (len(sides_i) * len(sides_j) > 1 and second[1].kind != HALF_SPACE):
                return None
            normal = rotate(second[1].place[3:], np.array([0.0, 0.0, 1.0])) if second[1].kind == HALF_SPACE else None
            found += [Touch(side, sides_j[0], normal) for side in sides_i]
    return found


def start_of_solids(moving: list[Body]) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and velocities of bodies at their start."""
    q, u = [], []
    for body in moving:
        inertia = inertia_of(body, SPATIAL)
        place = compose(place_of(body.position, body.turn), place_of(inertia.centre, inertia.axes))
        q.append(place)
        u.append(np.concatenate((body.velocity, rotate(conjugate(place[3:]), np.asarray(body.spin)))))
    return np.concatenate(q), np.concatenate(u)


def functions_of_solids(
    scene: Scene, moving: list[Body], touches: list[Touch], t_0: float
) -> tuple[dict[str, Any], dict[str, Any]]:  # fmt: skip
    """Mass, forces, potential, kinematics, and gaps and rows of contacts; and what they read."""
    inertias = [inertia_of(body, SPATIAL) for body in moving]
    m, moments = (np.array([getattr(inertia, name) for inertia in inertias]) for name in ("mass", "moments"))
    read: dict[str, Any] = {"bodies": Solids(m, moments, np.asarray(scene.gravity, dtype=float))}
    functions = _body_functions(len(moving))
    if not touches:
        return functions, read
    of, read["touches"] = _tables(touches, t_0)
    return functions | _contact_functions(of), read


def _parts(body: Body) -> list[Part]:
    """The parts of a body along its principal axes, about its centre of mass; of a guided one about its origin; of a
    fixed one in the world."""
    if body.kind is Kind.DYNAMIC:
        inertia = inertia_of(body, SPATIAL)
        frame = inverse(place_of(inertia.centre, inertia.axes))
    else:
        frame = place_of(body.position, body.turn) if body.kind is Kind.FIXED else ORIGIN[SPATIAL]
    return [part._replace(place=compose(frame, part.place)) for part in parts_of(body.shape, SPATIAL)]


def _sides(body: Body, part: Part, numbers: dict[str, int]) -> list[Side]:
    """The rounded points of a part, or a point of a half-space; none of what has none."""
    belt = np.zeros(3) if body.surface_velocity is None else np.asarray(body.surface_velocity)
    if body.kind is not Kind.KINEMATIC:
        is_moved = body.kind is Kind.DYNAMIC
        belt = rotate(conjugate(np.asarray(inertia_of(body, SPATIAL).axes)) if is_moved else body.turn, belt)
    arms = part.place[:3] + np.array([rotate(part.place[3:], point) for point in _points(part)]).reshape(-1, 3)
    place, rate = ORIGIN[SPATIAL], np.zeros(6)
    if body.kind is Kind.KINEMATIC:
        place, rate = place_of(body.position, body.turn), np.concatenate((body.velocity, body.spin))
    number = numbers.get(body.name, NO_COORDINATES)
    return [Side(number, arm, part.radius, belt, place, rate, body.index) for arm in arms]


def _points(part: Part) -> np.ndarray:
    """Points that are rounded by the radius of the part, about the origin of its frame."""
    if part.kind in (SPHERE, HALF_SPACE):
        return np.zeros((1, 3))
    if part.kind == CAPSULE:
        return np.array([[0.0, 0.0, -part.size[2]], [0.0, 0.0, part.size[2]]])
    if part.kind == BOX:
        return np.array(part.size) * (2.0 * np.indices((2, 2, 2)).reshape(3, -1).T - 1.0)
    return part.vertices if part.kind == POLYHEDRON else np.zeros((0, 3))


def _tables(touches: list[Touch], t_0: float) -> tuple[Ends, Tables]:
    """The contacts, side by side."""
    sides = [(touch.i, touch.j) for touch in touches]
    columns = {
        name: np.array([[getattr(side, name) for side in pair] for pair in sides])
        for name in ("body", "arm", "radius", "belt", "place", "rate")
    }
    guided = (columns["place"] != ORIGIN[SPATIAL]).any(axis=2) | columns["rate"].any(axis=2)
    ends = Ends(columns.pop("body"), np.array([touch.normal is not None for touch in touches]), np.asarray(guided))
    normal = np.array([np.zeros(3) if touch.normal is None else touch.normal for touch in touches])
    return ends, Tables(**columns, normal=normal, t_0=t_0)


def cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def turned(q, b, a):
    """R a of body b, or R^T a for -1 - b; of no body a itself. Its quaternion need not be of unit length."""
    if b == NO_COORDINATES:
        return a
    w, r = q[7 * b + 3], (q[7 * b + 4], q[7 * b + 5], q[7 * b + 6])
    s = cross(r, a)
    z = cross(r, s)
    scale = 2.0 / (w * w + dot(r, r))
    return a[0] + scale * (w * s[0] + z[0]), a[1] + scale * (w * s[1] + z[1]), a[2] + scale * (w * s[2] + z[2])


def turned_back(q, b, a):
    """R^T a."""
    w, r = -q[7 * b + 3], (q[7 * b + 4], q[7 * b + 5], q[7 * b + 6])
    s = cross(r, a)
    z = cross(r, s)
    scale = 2.0 / (w * w + dot(r, r))
    return a[0] + scale * (w * s[0] + z[0]), a[1] + scale * (w * s[1] + z[1]), a[2] + scale * (w * s[2] + z[2])


def origin_of(t, at, c, side):
    """Where a guided body is."""
    x, v, time = at.place, at.rate, t - at.t_0
    return (
        x[c, side, 0] + time * v[c, side, 0],
        x[c, side, 1] + time * v[c, side, 1],
        x[c, side, 2] + time * v[c, side, 2],
    )


def guided(t, at, c, side, a):
    """R a of a guided body, which turns evenly: by its turn at t_0, then about its spin (Rodrigues)."""
    w, r = at.place[c, side, 3], (at.place[c, side, 4], at.place[c, side, 5], at.place[c, side, 6])
    s = cross(r, a)
    z = cross(r, s)
    a = (a[0] + 2.0 * (w * s[0] + z[0]), a[1] + 2.0 * (w * s[1] + z[1]), a[2] + 2.0 * (w * s[2] + z[2]))
    o = (at.rate[c, side, 3], at.rate[c, side, 4], at.rate[c, side, 5])
    spin = math.sqrt(dot(o, o))
    if spin == 0.0:
        return a
    turn = spin * (t - at.t_0)
    s = cross(o, a)
    z = cross(o, s)
    f, g = math.sin(turn) / spin, 2.0 * (math.sin(0.5 * turn) / spin) ** 2
    return a[0] + f * s[0] + g * z[0], a[1] + f * s[1] + g * z[1], a[2] + f * s[2] + g * z[2]


def core_of(t, q, of, at, c, side):
    """R a of a side, and its point c."""
    b = of.body[c, side]
    a = (at.arm[c, side, 0], at.arm[c, side, 1], at.arm[c, side, 2])
    if of.is_guided[c, side]:
        a, x = guided(t, at, c, side, a), origin_of(t, at, c, side)
        return a, (x[0] + a[0], x[1] + a[1], x[2] + a[2])
    if b == NO_COORDINATES:
        return a, a
    a = turned(q, b, a)
    return a, (q[7 * b] + a[0], q[7 * b + 1] + a[1], q[7 * b + 2] + a[2])


def spin_of(q, u, of, at, c, side):
    """The angular velocity of the body of a side in the axes of the world."""
    b = of.body[c, side]
    if b == NO_COORDINATES:
        return at.rate[c, side, 3], at.rate[c, side, 4], at.rate[c, side, 5]
    return turned(q, b, (u[6 * b + 3], u[6 * b + 4], u[6 * b + 5]))


def velocity_at(u, of, at, c, side, spin, arm):
    """x' + w x arm of the body of a side."""
    b = of.body[c, side]
    s = cross(spin, arm)
    if b == NO_COORDINATES:
        return at.rate[c, side, 0] + s[0], at.rate[c, side, 1] + s[1], at.rate[c, side, 2] + s[2]
    return u[6 * b] + s[0], u[6 * b + 1] + s[1], u[6 * b + 2] + s[2]


def normal_of(t, q, of, at, c):
    """n, and |c_i - c_j|; of a half-space the distance is 1, and n turns with it."""
    if of.is_flat[c]:
        n = (at.normal[c, 0], at.normal[c, 1], at.normal[c, 2])
        return (guided(t, at, c, 1, n) if of.is_guided[c, 1] else n), 1.0
    _, i = core_of(t, q, of, at, c, 0)
    _, j = core_of(t, q, of, at, c, 1)
    d = (i[0] - j[0], i[1] - j[1], i[2] - j[2])
    length = math.sqrt(dot(d, d))
    return (d[0] / length, d[1] / length, d[2] / length), length


def tangents_of(n):
    """Two unit vectors across n."""
    s = 1.0 if n[2] >= 0.0 else -1.0
    a = -1.0 / (s + n[2])
    b = n[0] * n[1] * a
    return (1.0 + s * n[0] * n[0] * a, s * b, -s * n[0]), (b, s + n[1] * n[1] * a, -n[1])


def all_tangents(n: np.ndarray) -> np.ndarray:
    """The same of many normals (..., 3), as (..., 2, 3)."""
    x, y, z = np.moveaxis(n, -1, 0)
    s = np.where(z >= 0.0, 1.0, -1.0)
    a = -1.0 / (s + z)
    first = np.stack((1.0 + s * x * x * a, s * x * y * a, -s * x), axis=-1)
    return np.stack((first, np.stack((x * y * a, s + y * y * a, -y), axis=-1)), axis=-2)


def rates_of_tangents(n, m):
    """Their rates where n' = m."""
    s = 1.0 if n[2] >= 0.0 else -1.0
    a = -1.0 / (s + n[2])
    a_rate = m[2] * a * a
    b_rate = (m[0] * n[1] + n[0] * m[1]) * a + n[0] * n[1] * a_rate
    first = s * (2.0 * n[0] * m[0] * a + n[0] * n[0] * a_rate), s * b_rate, -s * m[0]
    return first, (b_rate, 2.0 * n[1] * m[1] * a + n[1] * n[1] * a_rate, -m[1])


def arm_of(t, q, of, at, c, side, n):
    """A of a side: of a guided half-space to where the other side touches it."""
    if side == 1 and of.is_flat[c] and of.is_guided[c, 1]:
        _, i = core_of(t, q, of, at, c, 0)
        x, r = origin_of(t, at, c, 1), at.radius[c, 0]
        return i[0] - r * n[0] - x[0], i[1] - r * n[1] - x[1], i[2] - r * n[2] - x[2]
    a, _ = core_of(t, q, of, at, c, side)
    r = at.radius[c, side] if side == 1 else -at.radius[c, side]
    return a[0] + r * n[0], a[1] + r * n[1], a[2] + r * n[2]


def write_row(t, q, of, at, c, n, axis, W):
    """J along an axis, of both sides."""
    for side in range(2):
        b, sign = of.body[c, side], 1.0 - 2.0 * side
        if b != NO_COORDINATES:
            moment = turned_back(q, b, cross(arm_of(t, q, of, at, c, side, n), axis))
            for k in range(3):
                W[6 * b + k] += sign * axis[k]
                W[6 * b + 3 + k] += sign * moment[k]


def belt_of(t, q, of, at, c, side):
    """s of a side in the axes of the world."""
    belt = (at.belt[c, side, 0], at.belt[c, side, 1], at.belt[c, side, 2])
    return guided(t, at, c, side, belt) if of.is_guided[c, side] else turned(q, of.body[c, side], belt)


def belts_of(t, q, of, at, c):
    """s_i - s_j."""
    i, j = belt_of(t, q, of, at, c, 0), belt_of(t, q, of, at, c, 1)
    return i[0] - j[0], i[1] - j[1], i[2] - j[2]


def guide_of(t, q, of, at, c, n):
    """What guided bodies give of gamma, without belts."""
    g = (0.0, 0.0, 0.0)
    for side in range(2):
        if of.is_guided[c, side]:
            o, sign = (at.rate[c, side, 3], at.rate[c, side, 4], at.rate[c, side, 5]), 1.0 - 2.0 * side
            s = cross(o, arm_of(t, q, of, at, c, side, n))
            g = (
                g[0] + sign * (at.rate[c, side, 0] + s[0]), g[1] + sign * (at.rate[c, side, 1] + s[1]),
                g[2] + sign * (at.rate[c, side, 2] + s[2]),
            )  # fmt: skip
    return g


def rates_of_contact(t, q, u, of, at, c):
    """n, n', gamma without belts, and its rate at u' = 0."""
    n, length = normal_of(t, q, of, at, c)
    o_i, o_j = spin_of(q, u, of, at, c, 0), spin_of(q, u, of, at, c, 1)
    a_i, _ = core_of(t, q, of, at, c, 0)
    a_j, _ = core_of(t, q, of, at, c, 1)
    v_i, v_j = velocity_at(u, of, at, c, 0, o_i, a_i), velocity_at(u, of, at, c, 1, o_j, a_j)
    d = (v_i[0] - v_j[0], v_i[1] - v_j[1], v_i[2] - v_j[2])
    along = dot(n, d)
    if of.is_flat[c]:
        m = cross(o_j, n)
    else:
        m = ((d[0] - along * n[0]) / length, (d[1] - along * n[1]) / length, (d[2] - along * n[2]) / length)
    A_i, A_j = arm_of(t, q, of, at, c, 0, n), arm_of(t, q, of, at, c, 1, n)
    s_i, s_j = cross(o_i, a_i), cross(o_j, a_j)
    r_i, r_j = at.radius[c, 0], at.radius[c, 1]
    way_i = (s_i[0] - r_i * m[0], s_i[1] - r_i * m[1], s_i[2] - r_i * m[2])
    way_j = (s_j[0] + r_j * m[0], s_j[1] + r_j * m[1], s_j[2] + r_j * m[2])
    if of.is_flat[c]:  # the place of the contact on the half-space moves with the other side
        o = velocity_at(u, of, at, c, 1, o_j, (0.0, 0.0, 0.0))
        way_j = (v_i[0] - r_i * m[0] - o[0], v_i[1] - r_i * m[1] - o[1], v_i[2] - r_i * m[2] - o[2])
    w_i, w_j = cross(o_i, way_i), cross(o_j, way_j)
    g_i, g_j = velocity_at(u, of, at, c, 0, o_i, A_i), velocity_at(u, of, at, c, 1, o_j, A_j)
    gamma = (g_i[0] - g_j[0], g_i[1] - g_j[1], g_i[2] - g_j[2])
    return n, m, gamma, (w_i[0] - w_j[0], w_i[1] - w_j[1], w_i[2] - w_j[2])


def rate_of_belts(t, q, u, of, at, c):
    """(s_i - s_j)': belts turn with their bodies."""
    s = cross(spin_of(q, u, of, at, c, 0), belt_of(t, q, of, at, c, 0))
    z = cross(spin_of(q, u, of, at, c, 1), belt_of(t, q, of, at, c, 1))
    return s[0] - z[0], s[1] - z[1], s[2] - z[2]


def write_slip_rates(t, q, u, of, at, c, found, r):
    """The rates along the tangents, with those of the belts."""
    n, m, gamma, rate = found
    first, second = tangents_of(n)
    f, s = rates_of_tangents(n, m)
    belts, turning = belts_of(t, q, of, at, c), rate_of_belts(t, q, u, of, at, c)
    slip = (gamma[0] + belts[0], gamma[1] + belts[1], gamma[2] + belts[2])
    rate_T = (rate[0] + turning[0], rate[1] + turning[1], rate[2] + turning[2])
    r[c, 1] = dot(first, rate_T) + dot(f, slip)
    r[c, 2] = dot(second, rate_T) + dot(s, slip)


def _contact_functions(of: Ends) -> dict[str, Any]:
    """Gaps, rows, velocities of surfaces, and the rates of rows."""
    n_c = len(of.body)

    def gap(t, q, p, g_N):
        for c in range(n_c):
            n, _ = normal_of(t, q, of, p.touches, c)
            _, i = core_of(t, q, of, p.touches, c, 0)
            _, j = core_of(t, q, of, p.touches, c, 1)
            g_N[c] = dot(n, (i[0] - j[0], i[1] - j[1], i[2] - j[2])) - p.touches.radius[c, 0] - p.touches.radius[c, 1]

    def gap_rate(t, q, p, w_N):
        for c in range(n_c):
            n, _ = normal_of(t, q, of, p.touches, c)
            w_N[c] = dot(n, guide_of(t, q, of, p.touches, c, n))

    def normal(t, q, p, W_N):
        for c in range(n_c):
            n, _ = normal_of(t, q, of, p.touches, c)
            write_row(t, q, of, p.touches, c, n, n, W_N[c])

    def tangent(t, q, p, W_F):
        for c in range(n_c):
            n, _ = normal_of(t, q, of, p.touches, c)
            first, second = tangents_of(n)
            write_row(t, q, of, p.touches, c, n, first, W_F[c, 0])
            write_row(t, q, of, p.touches, c, n, second, W_F[c, 1])

    def surface_velocity(t, q, p, w_F):
        for c in range(n_c):
            n, _ = normal_of(t, q, of, p.touches, c)
            first, second = tangents_of(n)
            belts, g = belts_of(t, q, of, p.touches, c), guide_of(t, q, of, p.touches, c, n)
            slip = (belts[0] + g[0], belts[1] + g[1], belts[2] + g[2])
            w_F[c, 0], w_F[c, 1] = dot(first, slip), dot(second, slip)

    def row_rates(t, q, u, p, r):
        for c in range(n_c):
            n, m, gamma, rate = rates_of_contact(t, q, u, of, p.touches, c)
            r[c, 0] = dot(n, rate) + dot(m, gamma)
            if r.shape[1] > 1:
                write_slip_rates(t, q, u, of, p.touches, c, (n, m, gamma, rate), r)

    found = {
        "gap": gap, "normal": normal, "tangent": tangent, "surface_velocity": surface_velocity, "row_rates": row_rates,
    }  # fmt: skip
    return found | ({"gap_rate": gap_rate} if of.is_guided.any() else {})


def _body_functions(n_b: int) -> dict[str, Any]:
    """Mass, forces, potential and kinematics."""

    def mass(t, q, p, M):
        for b in range(n_b):
            for k in range(3):
                M[6 * b + k, 6 * b + k] = p.bodies.m[b]
                M[6 * b + 3 + k, 6 * b + 3 + k] = p.bodies.moments[b, k]

    def force(t, q, u, p, h):
        for b in range(n_b):
            w_1, w_2, w_3 = u[6 * b + 3], u[6 * b + 4], u[6 * b + 5]
            for k in range(3):
                h[6 * b + k] = p.bodies.m[b] * p.bodies.gravity[k]
            h[6 * b + 3] = (p.bodies.moments[b, 1] - p.bodies.moments[b, 2]) * w_2 * w_3
            h[6 * b + 4] = (p.bodies.moments[b, 2] - p.bodies.moments[b, 0]) * w_3 * w_1
            h[6 * b + 5] = (p.bodies.moments[b, 0] - p.bodies.moments[b, 1]) * w_1 * w_2

    def potential(t, q, p, V):
        for b in range(n_b):
            for k in range(3):
                V[0] -= p.bodies.m[b] * p.bodies.gravity[k] * q[7 * b + k]

    def kinematics(t, q, p, B):
        for b in range(n_b):
            w, x, y, z = 0.5 * q[7 * b + 3], 0.5 * q[7 * b + 4], 0.5 * q[7 * b + 5], 0.5 * q[7 * b + 6]
            i, j = 7 * b + 3, 6 * b + 3
            for k in range(3):
                B[7 * b + k, 6 * b + k] = 1.0
            B[i, j], B[i, j + 1], B[i, j + 2] = -x, -y, -z
            B[i + 1, j], B[i + 1, j + 1], B[i + 1, j + 2] = w, -z, y
            B[i + 2, j], B[i + 2, j + 1], B[i + 2, j + 2] = z, w, -x
            B[i + 3, j], B[i + 3, j + 1], B[i + 3, j + 2] = -y, x, w

    return {"mass": mass, "force": force, "potential": potential, "kinematics": kinematics}
