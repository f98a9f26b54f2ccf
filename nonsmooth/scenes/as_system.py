"""A small scene as a system whose contacts are counted once and for all, for every method that takes a `System`.

Contact k is between two rounded points (rounded_points.py): vertices of bodies, or one and a half-plane. A joint is two
contacts of both signs without friction, whose normals are the axes of the world. A guided body has no coordinates: its
places are known functions of the time.

Rows of shapes that touch along faces are not differentiable where the touching features change; they are refused. In
space spheres without friction have their centres as coordinates (`spheres_as_system`), other bodies turn
(`solids_as_system`).
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Iterable
from dataclasses import field, make_dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from nonsmooth.checks.arrays import as_listed, as_number
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.mechanics.laws import FrictionLaw
from nonsmooth.mechanics.model_system import MOST_SYSTEMS, content_of
from nonsmooth.mechanics.start import CoordinateState
from nonsmooth.mechanics.system import Contact, System
from nonsmooth.scenes.elements import Body, Joint, Kind, Spring
from nonsmooth.scenes.inertia import inertia_of
from nonsmooth.scenes.loads_as_system import OF_ANGLE, OF_LINE, OF_VECTOR, Load, functions_of_loads
from nonsmooth.scenes.materials import impact_of_pair
from nonsmooth.scenes.pair_laws import coefficients_of, require_known_pairs, resistance_in
from nonsmooth.scenes.parts import Part, parts_of
from nonsmooth.scenes.places import compose, inverse, place_of, rotate
from nonsmooth.scenes.rounded_points import NO_COORDINATES, Side, Touch, functions_of_touches
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shape_rows import HALF_PLANE
from nonsmooth.scenes.shapes import PLANAR, HalfPlane
from nonsmooth.scenes.solids_as_system import (
    ALONG_TANGENTS,
    RATES,
    SOLID,
    functions_of_solids,
    start_of_solids,
    touches_of_solids,
)
from nonsmooth.scenes.spheres_as_system import functions_of, near_of, nothing_turns, touch_of
from nonsmooth.scenes.weights import Weights, functions_of_weights

PLANE, SPACE = (("x", "m"), ("y", "m"), ("angle", "rad")), (("x", "m"), ("y", "m"), ("z", "m"))  # of one body
CURE = "simulate(scene, ..., integrator=ns.MoreauJean(dt)) takes it"


class _Asked:
    """A scene, its pairs and its start, equal to each that is the same in every part: a scene may grow."""

    def __init__(self, scene: Scene, pairs: Any, t_0: float) -> None:
        self.scene, self.pairs, self.t_0 = scene, pairs, t_0
        of_pairs = tuple((tuple(sorted(names)), given) for names, given in scene.pairs.items())
        others = tuple((tuple(sorted(names)), tuple(given.items())) for names, given in scene.resistances.items())
        own = np.asarray(scene.gravity), scene.name, scene.t_end, scene.dt, others
        self.content = content_of(
            (tuple(scene.bodies), tuple(scene.joints), tuple(scene.springs), tuple(scene.forces), tuple(scene.ignored),
             of_pairs, own, pairs, t_0)
        )  # fmt: skip

    def __hash__(self) -> int:
        return hash(self.content)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Asked) and other.content == self.content


def system_of(scene: Scene, pairs: Any = None, t_0: float = 0.0) -> System:
    """The system of a scene whose bodies are at their start at the time t_0, see `Scene.system`."""
    return _system_of(_Asked(scene, pairs, t_0))


@functools.lru_cache(maxsize=MOST_SYSTEMS)
def _system_of(asked: _Asked) -> System:
    scene = asked.scene
    _require_plain(scene)
    require_known_pairs(scene)
    moving = moving_of(scene)
    numbers = {body.name: k for k, body in enumerate(moving)}
    values: dict[str, float] = {}
    met = _pairs_of(scene, asked.pairs)
    axes: tuple[tuple[str, str], ...]
    own: dict[str, Any] = {"name": scene.name or "scene", "t_end": scene.t_end, "dt": scene.dt}
    touches, contacts = touches_of(scene, asked.pairs), _contacts(scene, met, values)
    if scene.dim == PLANAR:
        (functions, read), axes = _planar_functions(scene, moving, touches, asked.t_0), PLANE
    elif nothing_turns(scene):
        (functions, read), axes = functions_of(scene, moving, [near_of(a, b, numbers) for a, b in met]), SPACE
    else:
        (functions, read), axes = functions_of_solids(scene, moving, touches, asked.t_0), SOLID
        own["velocities"] = tuple((f"{name} of {body.name}", unit) for body in moving for name, unit in RATES)
        if not any(contact.directions == 2 for contact in contacts):
            functions = {name: function for name, function in functions.items() if name not in ALONG_TANGENTS}
    parameters = _parameters(moving, values, read, axes)
    system = System(n_q=len(axes) * len(moving), contacts=contacts, parameters=parameters, **own, **functions)
    type(parameters).state = CoordinateState(system, state_of(scene))
    return system


def moving_of(scene: Scene) -> list[Body]:
    """The bodies that have coordinates, in order."""
    return [body for body in scene.bodies if body.kind is Kind.DYNAMIC]


def touches_of(scene: Scene, pairs: Any = None) -> list[Touch]:
    """The contacts of the system of a scene, in its order: those of joints behind those of pairs."""
    numbers = {body.name: k for k, body in enumerate(moving_of(scene))}
    found = [touch for a, b in _pairs_of(scene, pairs) for touch in _touches_of(scene, a, b, numbers)]
    return found + [touch for joint in scene.joints for touch in _touches_of_joint(joint, numbers)]


def _contacts(scene: Scene, met: list[tuple[Body, Body]], values: dict[str, float]) -> list[Contact]:
    """The laws of these contacts, in the same order."""
    numbers = {body.name: k for k, body in enumerate(moving_of(scene))}
    found: list[Contact] = []
    for a, b in met:
        contact, count = _contact(scene, a, b, values), len(_touches_of(scene, a, b, numbers))
        names = [f"{a.name} {b.name}"] if count == 1 else [f"{a.name} {b.name} {k + 1}" for k in range(count)]
        found += [replace(contact, name=name) for name in names]
    return found + [Contact(bilateral=True, name=f"{joint.name} {x}") for joint in scene.joints for x in "xy"]


def state_of(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """The start of a scene as coordinates and velocities of its system, see `Scene.state`."""
    _require_plain(scene)
    moving = moving_of(scene)
    if scene.dim != PLANAR and nothing_turns(scene):
        return np.concatenate([body.position for body in moving]), np.concatenate([body.velocity for body in moving])
    if scene.dim != PLANAR:
        return start_of_solids(moving)
    q = [compose(place_of(body.position, body.turn), place_of(inertia_of(body, PLANAR).centre, 0.0)) for body in moving]
    return np.concatenate(q), np.concatenate([[*body.velocity, body.spin] for body in moving])


def _require_plain(scene: Scene) -> None:
    """Raise `InvalidInput` for scenes that are no system of this kind."""
    for body in scene.bodies:
        if body.motion is not None:
            raise InvalidInput(
                f"{body.name} moves as a function says, which a system of a scene does not follow; give it an even "
                f"velocity, or {CURE}"
            )
        if isinstance(body.shape, HalfPlane) and np.any(body.spin):
            raise InvalidInput(f"{body.name} is a half-plane that turns, which no system of a scene holds; {CURE}")
    if what := resistance_in(scene):
        raise InvalidInput(f"a material has {what}, which no system of a scene holds; {CURE}")
    for load in (*scene.springs[:1], *scene.forces[:1]) if scene.dim != PLANAR else ():
        raise InvalidInput(f"{load!r} lies in space, where no system of a scene holds springs and forces; {CURE}")
    for force in scene.forces:
        if callable(force.value):
            raise InvalidInput(
                f"the force on {force.body.name} is a function, which no system of a scene holds; {CURE}"
            )
    if scene.joints and scene.dim != PLANAR:
        raise InvalidInput(f"{scene.joints[0].name} is a joint in space, which no system of a scene holds; {CURE}")
    for joint in scene.joints:
        if joint.kind not in ("joint", "hinge"):
            raise InvalidInput(f"{joint.name} is a {joint.kind} joint, which no system of a scene holds; {CURE}")
        if joint.limits or joint.friction or any(spring.inertia for spring in joint.springs):
            raise InvalidInput(
                f"{joint.name} has limits, friction or a rotor, which no system of a scene holds; {CURE}"
            )
        if any(motor.load is None or callable(motor.load) for motor in joint.motors):
            raise InvalidInput(
                f"the motor of {joint.name} is a function or holds a speed, which no system of a scene holds; {CURE}"
            )
    if not moving_of(scene):
        raise InvalidInput("no body of the scene moves by forces; add one by scene.body")


def _pairs_of(scene: Scene, pairs: Any) -> list[tuple[Body, Body]]:
    """The pairs of bodies that may touch, one of them dynamic: those that were named, or all but ``scene.apart()``."""
    if pairs is None:
        apart = {frozenset((a.name, b.name)) for a, b in scene.apart()}
        every = (pair for pair in combinations(scene.bodies, 2) if _has_dynamic(pair))
        return [(a, b) for a, b in every if frozenset((a.name, b.name)) not in apart]
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
    impact = impact_of_pair(a.material, b.material)
    pair = re.sub(r"\W", "_", f"{a.name}_{b.name}", flags=re.ASCII)
    names = f"mu_{pair}", f"e_{pair}"
    if names[1] in values:
        raise InvalidInput(f"two pairs of bodies would both have a coefficient {names[1]}; give {b.name} another name")
    values[names[1]] = e
    if mu == 0:
        return Contact(e_N=names[1], impact=impact)
    if isinstance(mu, float):
        values[names[0]] = mu
    law = mu if isinstance(mu, FrictionLaw) else names[0]
    return Contact(mu=law, e_N=names[1], impact=impact, directions=scene.dim - 1)


def _parameters(
    moving: list[Body], values: dict[str, float], read: dict[str, Any], axes: tuple[tuple[str, str], ...]
) -> Any:  # fmt: skip
    """The coefficients as parameters that know the names of the coordinates, and the numbers that functions read."""
    coordinates = tuple((f"{name} of {body.name}", unit) for body in moving for name, unit in axes)
    fields: list[Any] = [(name, float) for name in values]
    fields += [(name, type(part), field(repr=False)) for name, part in read.items()]
    namespace = {"coordinates": coordinates, "constants": tuple(read)}
    freeze(tuple(read.values()))
    return make_dataclass("Coefficients", fields, namespace=namespace, frozen=True)(**values, **read)


def freeze(part: Any) -> None:
    """Let no array of the numbers that functions read be written to."""
    if isinstance(part, np.ndarray):
        part.flags.writeable = False
    elif isinstance(part, tuple):
        for entry in part:
            freeze(entry)


def _touches_of(scene: Scene, a: Body, b: Body, numbers: dict[str, int]) -> list[Touch]:
    """The contacts of two bodies."""
    if scene.dim == PLANAR:
        touches = _touches_in_plane(a, b, numbers)
    else:
        touches = [touch_of(a, b, numbers)] if nothing_turns(scene) else touches_of_solids(a, b, numbers)
    if touches is None:
        raise InvalidInput(
            f"{a.name} and {b.name}, {a.shape!r} and {b.shape!r}, may touch along faces, which has no smooth gap; "
            f"leave the pair out by pairs=[...], or {CURE}"
        )
    return touches


def _touches_in_plane(a: Body, b: Body, numbers: dict[str, int]) -> list[Touch] | None:
    """Those of their parts; None for what has faces."""
    found: list[Touch] = []
    for part_a in _parts(a):
        for part_b in _parts(b):
            touches = _touches_of_parts(a, part_a, b, part_b, numbers)
            if touches is None:
                return None
            found += touches
    return found


def _touches_of_joint(joint: Joint, numbers: dict[str, int]) -> list[Touch]:
    """The point of one body on that of the other, along x and along y."""
    sides = [_side_at(body, joint.at, numbers) for body in (joint.a, joint.b)]
    return [Touch(sides[0], sides[1], normal) for normal in np.eye(2)]


def _side_at(body: Body, at: np.ndarray, numbers: dict[str, int]) -> Side:
    """The point of a body that is at a place at the start."""
    if body.kind is Kind.DYNAMIC:
        place = compose(place_of(body.position, body.turn), place_of(inertia_of(body, PLANAR).centre, 0.0))
    else:
        place = place_of(np.zeros(2), 0.0) if body.kind is Kind.FIXED else place_of(body.position, body.turn)
    return _side(body, compose(inverse(place), place_of(at, 0.0))[:2], 0.0, numbers)


def _parts(body: Body) -> list[Part]:
    """The parts of a body about its centre of mass; of a guided one about its origin; of a fixed one in the world."""
    if body.kind is Kind.DYNAMIC:
        frame = inverse(place_of(inertia_of(body, PLANAR).centre, 0.0))
    else:
        frame = place_of(body.position, body.turn) if body.kind is Kind.FIXED else place_of(np.zeros(2), 0.0)
    return [part._replace(place=compose(frame, part.place)) for part in parts_of(body.shape, PLANAR)]


def _touches_of_parts(a: Body, part_a: Part, b: Body, part_b: Part, numbers: dict[str, int]) -> list[Touch] | None:
    """Vertices on a half-plane, or two discs; None for what has faces."""
    if part_a.kind == HALF_PLANE:
        a, part_a, b, part_b = b, part_b, a, part_a
    sides_a, sides_b = _sides(a, part_a, numbers), _sides(b, part_b, numbers)
    if part_b.kind == HALF_PLANE:
        turn = part_b.place[2] + (b.turn if b.kind is Kind.KINEMATIC else 0.0)
        normal = rotate(turn, np.array([0.0, 1.0]))
        return [Touch(side, sides_b[0], normal) for side in sides_a]
    if len(sides_a) == len(sides_b) == 1:
        return [Touch(sides_a[0], sides_b[0], None)]
    return None


def _sides(body: Body, part: Part, numbers: dict[str, int]) -> list[Side]:
    """The rounded vertices of a part; of a half-plane, the point where it is."""
    points = np.zeros((1, 2)) if part.kind == HALF_PLANE else part.vertices
    arms = part.place[:2] + rotate(part.place[2], points)
    return [_side(body, arm, part.radius, numbers) for arm in arms]


def _side(body: Body, arm: np.ndarray, radius: float, numbers: dict[str, int]) -> Side:
    """A rounded point of a body, an arm from what its parts are about."""
    belt = np.zeros(2) if body.surface_velocity is None else body.surface_velocity
    place = rate = np.zeros(3)
    if body.kind is Kind.FIXED:
        belt = rotate(body.turn, belt)
    elif body.kind is Kind.KINEMATIC:
        place, rate = place_of(body.position, body.turn), np.array([*body.velocity, body.spin])
    return Side(numbers.get(body.name, NO_COORDINATES), arm, radius, belt, place, rate, body.index)


def _planar_functions(
    scene: Scene, moving: list[Body], touches: list[Touch], t_0: float
) -> tuple[dict[str, Any], dict[str, Any]]:  # fmt: skip
    """Mass, forces, potential, gaps and rows; and what they read."""
    inertias = [inertia_of(body, PLANAR) for body in moving]
    m = np.array([[inertia.mass, inertia.mass, inertia.moments[0]] for inertia in inertias])
    weight = np.column_stack((m[:, :1] * np.asarray(scene.gravity), np.zeros(len(m))))
    numbers = {body.name: k for k, body in enumerate(moving)}
    for joint in scene.joints:
        torque = sum(as_number(f"torque of {joint.name}", motor.load) for motor in joint.motors)
        for body, sign in ((joint.a, -1.0), (joint.b, 1.0)):
            if body.name in numbers:
                weight[numbers[body.name], 2] += sign * torque
    functions, read = functions_of_weights(), {"weights": Weights(m.reshape(-1), weight.reshape(-1))}
    parts: list[tuple[str, Any]] = []
    if loads := _loads(scene, numbers):
        parts.append(("loads", functions_of_loads(loads, t_0)))
    if touches:
        parts.append(("touches", functions_of_touches(touches, t_0)))
    for name, (of_part, numbers_of_part) in parts:
        functions, read = functions | of_part, read | {name: numbers_of_part}
    return functions, read


def _loads(scene: Scene, numbers: dict[str, int]) -> list[Load]:
    """Springs, those of joints, and forces."""
    origin = Side(NO_COORDINATES, np.zeros(2), 0.0, np.zeros(2), np.zeros(3), np.zeros(3), 0)
    found = [_load_of_spring(spring, numbers) for spring in scene.springs]
    for joint in scene.joints:
        touch = _touches_of_joint(joint, numbers)[0]
        found += [
            Load(touch, OF_ANGLE, spring.stiffness, spring.damping, _turn_of(joint.b) - _turn_of(joint.a) + spring.rest)
            for spring in joint.springs
        ]
    return found + [
        Load(
            Touch(_side_at(force.body, _end(force.body, force.at), numbers), origin, None), OF_VECTOR, force=force.value
        )
        for force in scene.forces
    ]


def _load_of_spring(spring: Spring, numbers: dict[str, int]) -> Load:
    """A spring between two points, or of the angle of two bodies."""
    a, b, rest = spring.a, spring.b, spring.length
    ends = _end(a, spring.at_a), _end(b, spring.at_b)
    touch = Touch(_side_at(a, ends[0], numbers), _side_at(b, ends[1], numbers), None)
    if spring.is_torsion:
        turn = b.turn - a.turn
        return Load(touch, OF_ANGLE, spring.stiffness, spring.damping,
                    _turn_of(b) - _turn_of(a) + (turn if rest is None else rest) - turn)  # fmt: skip
    rest = math.dist(*ends) if rest is None else rest
    return Load(touch, OF_LINE if rest > 0.0 else OF_VECTOR, spring.stiffness, spring.damping, rest)


def _end(body: Body, at: np.ndarray | None) -> np.ndarray:
    """A place at the start; the centre of mass for None."""
    if at is not None or body.kind is not Kind.DYNAMIC:
        return body.position if at is None else at
    return compose(place_of(body.position, body.turn), place_of(inertia_of(body, PLANAR).centre, 0.0))[:2]


def _turn_of(body: Body) -> float:
    """The angle of a body at the start, as its system has it: 0 of a fixed one."""
    return 0.0 if body.kind is Kind.FIXED else body.turn
