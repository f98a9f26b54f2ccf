"""A small scene as a system whose contacts are counted once and for all, for every method that takes a `System`.

Contact k is between two rounded points: a vertex of a body, an arm a_i from its centre of mass, and a vertex of
another one or a point of a half-plane:

    d = x_i + R_i a_i - x_j - R_j a_j,    g_N = n . d - r_i - r_j,    n = d/|d|, or the normal of the half-plane

With t = (n_y, -n_x), d' the rate of d, and the body axes' belts s turned into those of the world:

    gamma_N = n . d',    gamma_F = t . d' + r_i th_i' + r_j th_j' + t . (s_i - s_j)
    n' = w t,  t' = -w n,  w = t . d'/|d| (half-plane: 0)

Rows of shapes that touch along faces are not differentiable where the touching features change; they are refused. Of
scenes in space those of spheres without friction are a system (`spheres_as_system`).
Source: Pfeiffer and Glocker, *Multibody Dynamics with Unilateral Contacts* (1996), ch. 4.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import make_dataclass
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.checks.arrays import as_listed
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.mechanics.system import Contact, System
from nonsmooth.scenes.inertia import inertia_of
from nonsmooth.scenes.parts import Part, parts_of
from nonsmooth.scenes.places import compose, inverse, place_of, rotate
from nonsmooth.scenes.scene import Body, Kind, Scene, coefficients_of, require_known_pairs
from nonsmooth.scenes.shape_rows import HALF_PLANE
from nonsmooth.scenes.shapes import PLANAR
from nonsmooth.scenes.spheres_as_system import functions_of, near_of, require_spheres
from nonsmooth.scenes.weights import functions_of_weights

NO_COORDINATES = -1  # code: in place of the number of a body that moves
PLANE, SPACE = (("x", "m"), ("y", "m"), ("angle", "rad")), (("x", "m"), ("y", "m"), ("z", "m"))  # of one body
CURE = "simulate(scene, ..., integrator=ns.MoreauJean(dt)) takes it"


class Side(NamedTuple):
    """One side of a contact: a rounded point of a body."""

    body: int  # its number among those that move, or NO_COORDINATES
    arm: np.ndarray  # (2,) from the centre of mass in the body's axes [m]; of a fixed body, in the world
    radius: float  # [m]
    belt: np.ndarray  # (2,) surface velocity in the same axes [m/s]


class Touch(NamedTuple):
    """A contact: side i on side j."""

    i: Side
    j: Side
    normal: np.ndarray | None  # (2,) of a half-plane on side j; None between two points


def system_of(scene: Scene, pairs: Any = None) -> System:
    """The system of a scene, see `Scene.system`."""
    _require_plain(scene)
    require_known_pairs(scene)
    moving = [body for body in scene.bodies if body.kind is Kind.DYNAMIC]
    numbers = {body.name: k for k, body in enumerate(moving)}
    touches: list[Touch] = []
    contacts: list[Contact] = []
    values: dict[str, float] = {}
    met = _pairs_of(scene, pairs)
    own: dict[str, Any] = {"name": scene.name or "scene", "t_end": scene.t_end, "dt": scene.dt}
    if scene.dim != PLANAR:
        require_spheres(scene, met, CURE)
        contacts = [_contact(scene, a, b, values) for a, b in met]
        functions = functions_of(scene, moving, [near_of(a, b, numbers) for a, b in met])
        parameters = _parameters(moving, values, SPACE)
        return System(n_q=3 * len(moving), contacts=contacts, parameters=parameters, **own, **functions)
    for a, b in met:
        found = _touches_of(a, b, numbers)
        touches += found
        contacts += [_contact(scene, a, b, values)] * len(found)
    parameters = _parameters(moving, values, PLANE)
    functions = _body_functions(scene, moving) | (_contact_functions(touches) if touches else {})
    return System(n_q=3 * len(moving), contacts=contacts, parameters=parameters, **own, **functions)


def state_of(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """The start of a scene as coordinates and velocities of its system, see `Scene.state`."""
    _require_plain(scene)
    moving = [body for body in scene.bodies if body.kind is Kind.DYNAMIC]
    if scene.dim != PLANAR:
        require_spheres(scene, [], CURE)
        return np.concatenate([body.position for body in moving]), np.concatenate([body.velocity for body in moving])
    q = [compose(place_of(body.position, body.turn), place_of(inertia_of(body, PLANAR).centre, 0.0)) for body in moving]
    return np.concatenate(q), np.concatenate([[*body.velocity, body.spin] for body in moving])


def _require_plain(scene: Scene) -> None:
    """Raise `InvalidInput` for scenes that are no system of this kind."""
    for body in scene.bodies:
        if body.kind is Kind.KINEMATIC:
            raise InvalidInput(f"{body.name} moves as it is told, which a system of a scene does not; {CURE}")
    if scene.joints:
        raise InvalidInput(f"{scene.joints[0].name} is a joint, which a system of a scene does not hold; {CURE}")
    if all(body.kind is not Kind.DYNAMIC for body in scene.bodies):
        raise InvalidInput("no body of the scene moves by forces; add one by scene.body")


def _pairs_of(scene: Scene, pairs: Any) -> list[tuple[Body, Body]]:
    """The pairs of bodies that may touch, one of them dynamic: those that were named, or all."""
    if pairs is None:
        return [pair for pair in combinations(scene.bodies, 2) if _has_dynamic(pair)]
    named = [_named_pair(scene, pair) for pair in as_listed("pairs", pairs, "a list of pairs of names of bodies")]
    met = {frozenset((a.name, b.name)) for a, b in named}
    if len(met) < len(named):
        raise InvalidInput("pairs names two bodies twice; each pair is given once")
    return named


def _named_pair(scene: Scene, pair: Any) -> tuple[Body, Body]:
    names = as_listed("a pair", pair, "a tuple of the names of two bodies")
    if len(names) != 2:
        raise InvalidInput(f"a pair has the names of two bodies; got {shown(pair)}")
    a, b = scene[names[0]], scene[names[1]]
    if a is b or not _has_dynamic((a, b)):
        raise InvalidInput(f"a pair is one of two bodies, at least one of them dynamic; got {shown(pair)}")
    return a, b


def _has_dynamic(pair: Iterable[Body]) -> bool:
    return any(body.kind is Kind.DYNAMIC for body in pair)


def _contact(scene: Scene, a: Body, b: Body, values: dict[str, float]) -> Contact:
    """The contact of two bodies, its coefficients named after them; without friction it has no tangential row."""
    mu, e = coefficients_of(scene, a.material, b.material)
    pair = re.sub(r"\W", "_", f"{a.name}_{b.name}", flags=re.ASCII)
    names = f"mu_{pair}", f"e_{pair}"
    if names[1] in values:
        raise InvalidInput(f"two pairs of bodies would both have a coefficient {names[1]}; give {b.name} another name")
    values[names[1]] = e
    if mu == 0:
        return Contact(e_N=names[1])
    values[names[0]] = mu
    return Contact(mu=names[0], e_N=names[1])


def _parameters(moving: list[Body], values: dict[str, float], axes: tuple[tuple[str, str], ...]) -> Any:
    """The coefficients as parameters that know the names of the coordinates."""
    coordinates = tuple((f"{name} of {body.name}", unit) for body in moving for name, unit in axes)
    named = make_dataclass(
        "Coefficients", [(name, float) for name in values], namespace={"coordinates": coordinates}, frozen=True
    )
    return named(**values)


def _touches_of(a: Body, b: Body, numbers: dict[str, int]) -> list[Touch]:
    """The contacts of two bodies."""
    found = []
    for part_a in _parts(a):
        for part_b in _parts(b):
            touches = _touches_of_parts(a, part_a, b, part_b, numbers)
            if touches is None:
                raise InvalidInput(
                    f"{a.name} and {b.name}, {a.shape!r} and {b.shape!r}, may touch along faces, which has no smooth "
                    f"gap; leave the pair out by pairs=[...], or {CURE}"
                )
            found += touches
    return found


def _parts(body: Body) -> list[Part]:
    """The parts of a body, about its centre of mass; of a fixed one, where they stand."""
    if body.kind is Kind.DYNAMIC:
        frame = inverse(place_of(inertia_of(body, PLANAR).centre, 0.0))
    else:
        frame = place_of(body.position, body.turn)
    return [part._replace(place=compose(frame, part.place)) for part in parts_of(body.shape, PLANAR)]


def _touches_of_parts(a: Body, part_a: Part, b: Body, part_b: Part, numbers: dict[str, int]) -> list[Touch] | None:
    """Vertices on a half-plane, or two discs; None for what has faces."""
    if part_a.kind == HALF_PLANE:
        a, part_a, b, part_b = b, part_b, a, part_a
    sides_a, sides_b = _sides(a, part_a, numbers), _sides(b, part_b, numbers)
    if part_b.kind == HALF_PLANE:
        normal = rotate(part_b.place[2], np.array([0.0, 1.0]))
        return [Touch(side, sides_b[0], normal) for side in sides_a]
    if len(sides_a) == len(sides_b) == 1:
        return [Touch(sides_a[0], sides_b[0], None)]
    return None


def _sides(body: Body, part: Part, numbers: dict[str, int]) -> list[Side]:
    """The rounded vertices of a part; of a half-plane, the point where it is."""
    number = numbers.get(body.name, NO_COORDINATES)
    belt = np.zeros(2) if body.surface_velocity is None else body.surface_velocity
    if number == NO_COORDINATES:
        belt = rotate(body.turn, belt)
    points = np.zeros((1, 2)) if part.kind == HALF_PLANE else part.vertices
    arms = part.place[:2] + rotate(part.place[2], points)
    return [Side(number, arm, part.radius, belt) for arm in arms]


def _body_functions(scene: Scene, moving: list[Body]) -> dict[str, Any]:
    """Mass, weight and potential."""
    inertias = [inertia_of(body, PLANAR) for body in moving]
    m = np.array([[inertia.mass, inertia.mass, inertia.moments[0]] for inertia in inertias]).reshape(-1)
    weight = np.array([place_of(inertia.mass * np.asarray(scene.gravity), 0.0) for inertia in inertias]).reshape(-1)
    return functions_of_weights(m, weight)


class Tables(NamedTuple):
    """The contacts as constants of the compiled functions; of side 0, which is i, and side 1, which is j."""

    body: np.ndarray  # (n_c, 2)
    arm: np.ndarray  # (n_c, 2, 2) [m]
    radius: np.ndarray  # (n_c, 2) [m]
    belt: np.ndarray  # (n_c, 2, 2) [m/s]
    is_flat: np.ndarray  # (n_c,)
    normal: np.ndarray  # (n_c, 2), where it is flat


def _tables(touches: list[Touch]) -> Tables:
    sides = [(touch.i, touch.j) for touch in touches]
    return Tables(
        body=np.array([[side.body for side in pair] for pair in sides]),
        arm=np.array([[side.arm for side in pair] for pair in sides]),
        radius=np.array([[side.radius for side in pair] for pair in sides]),
        belt=np.array([[side.belt for side in pair] for pair in sides]),
        is_flat=np.array([touch.normal is not None for touch in touches]),
        normal=np.array([np.zeros(2) if touch.normal is None else touch.normal for touch in touches]),
    )


def turned(q, b, v):
    """A vector in the axes of body b in those of the world."""
    if b == NO_COORDINATES:
        return v[0], v[1]
    c, s = math.cos(q[3 * b + 2]), math.sin(q[3 * b + 2])
    return c * v[0] - s * v[1], s * v[0] + c * v[1]


def point(q, b, arm):
    """x + R a."""
    a_x, a_y = turned(q, b, arm)
    if b == NO_COORDINATES:
        return a_x, a_y
    return q[3 * b] + a_x, q[3 * b + 1] + a_y


def point_rates(q, u, b, arm):
    """The velocity of a point of body b, and its acceleration at u' = 0."""
    if b == NO_COORDINATES:
        return 0.0, 0.0, 0.0, 0.0
    a_x, a_y = turned(q, b, arm)
    w = u[3 * b + 2]
    return u[3 * b] - w * a_y, u[3 * b + 1] + w * a_x, -w * w * a_x, -w * w * a_y


def belt_rates(q, u, b, belt):
    """The velocity of a belt, and its rate as the body turns."""
    s_x, s_y = turned(q, b, belt)
    w = 0.0 if b == NO_COORDINATES else u[3 * b + 2]
    return s_x, s_y, -w * s_y, w * s_x


def between(q, at, c):
    """d of contact c."""
    i_x, i_y = point(q, at.body[c, 0], at.arm[c, 0])
    j_x, j_y = point(q, at.body[c, 1], at.arm[c, 1])
    return i_x - j_x, i_y - j_y


def direction(q, at, c):
    """n of contact c."""
    if at.is_flat[c]:
        return at.normal[c, 0], at.normal[c, 1]
    d_x, d_y = between(q, at, c)
    length = math.sqrt(d_x * d_x + d_y * d_y)
    return d_x / length, d_y / length


def turning(q, at, c, slide):
    """w of contact c, where the points slide past one another at t . d'."""
    if at.is_flat[c]:
        return 0.0
    d_x, d_y = between(q, at, c)
    return slide / math.sqrt(d_x * d_x + d_y * d_y)


def _contact_functions(touches: list[Touch]) -> dict[str, Any]:
    """Gap, rows and their rates."""
    at = _tables(touches)
    n_c = len(touches)

    def gap(t, q, p, g_N):
        for c in range(n_c):
            n_x, n_y = direction(q, at, c)
            d_x, d_y = between(q, at, c)
            g_N[c] = n_x * d_x + n_y * d_y - at.radius[c, 0] - at.radius[c, 1]

    def normal(t, q, p, W_N):
        for c in range(n_c):
            n_x, n_y = direction(q, at, c)
            for side in range(2):
                b, sign = at.body[c, side], 1.0 - 2.0 * side
                if b != NO_COORDINATES:
                    a_x, a_y = turned(q, b, at.arm[c, side])
                    W_N[c, 3 * b] = sign * n_x
                    W_N[c, 3 * b + 1] = sign * n_y
                    W_N[c, 3 * b + 2] = sign * (a_x * n_y - a_y * n_x)

    def tangent(t, q, p, W_F):
        for c in range(n_c):
            n_x, n_y = direction(q, at, c)
            for side in range(2):
                b, sign = at.body[c, side], 1.0 - 2.0 * side
                if b != NO_COORDINATES:
                    a_x, a_y = turned(q, b, at.arm[c, side])
                    W_F[c, 0, 3 * b] = sign * n_y
                    W_F[c, 0, 3 * b + 1] = -sign * n_x
                    W_F[c, 0, 3 * b + 2] = at.radius[c, side] - sign * (a_x * n_x + a_y * n_y)

    def surface_velocity(t, q, p, w_F):
        for c in range(n_c):
            n_x, n_y = direction(q, at, c)
            i_x, i_y = turned(q, at.body[c, 0], at.belt[c, 0])
            j_x, j_y = turned(q, at.body[c, 1], at.belt[c, 1])
            w_F[c, 0] = n_y * (i_x - j_x) - n_x * (i_y - j_y)

    def row_rates(t, q, u, p, r):
        for c in range(n_c):
            i, j = at.body[c, 0], at.body[c, 1]
            n_x, n_y = direction(q, at, c)
            vi_x, vi_y, ai_x, ai_y = point_rates(q, u, i, at.arm[c, 0])
            vj_x, vj_y, aj_x, aj_y = point_rates(q, u, j, at.arm[c, 1])
            si_x, si_y, bi_x, bi_y = belt_rates(q, u, i, at.belt[c, 0])
            sj_x, sj_y, bj_x, bj_y = belt_rates(q, u, j, at.belt[c, 1])
            slide = n_y * (vi_x - vj_x) - n_x * (vi_y - vj_y)
            w = turning(q, at, c, slide)
            r[c, 0] = n_x * (ai_x - aj_x) + n_y * (ai_y - aj_y) + w * slide
            r[c, 1] = n_y * (ai_x + bi_x - aj_x - bj_x) - n_x * (ai_y + bi_y - aj_y - bj_y)
            r[c, 1] -= w * (n_x * (vi_x + si_x - vj_x - sj_x) + n_y * (vi_y + si_y - vj_y - sj_y))

    functions = {"gap": gap, "normal": normal, "tangent": tangent, "row_rates": row_rates}
    return functions | ({"surface_velocity": surface_velocity} if at.belt.any() else {})
