"""A scene as the blocks of a run: centres of mass, principal axes, shapes, materials, and what is told how to move."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from nonsmooth.checks.arrays import as_listed, as_vector, is_number, result_of
from nonsmooth.checks.parameters import layout_of
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import Surfaces
from nonsmooth.integrators.assembly.drive_rows import RUBS, SPEED, SPRINGS, STOPS, Drives
from nonsmooth.integrators.assembly.joints import Joints
from nonsmooth.integrators.assembly.spring_rows import ALONG, TORSION, Springs, line_of
from nonsmooth.jit import interpreted, unpack_of
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.laws import (
    IMPACT_LAWS,
    LAW_C,
    LAW_WIDTH,
    Coulomb,
    Friction,
    FrictionLaw,
    ImpactLaw,
    as_law,
    law_row,
    static_coefficient,
)
from nonsmooth.mechanics.own_law import handle_of_law, point_to
from nonsmooth.scenes.detection import NOT_FINITE, Found
from nonsmooth.scenes.elements import Body, Joint, JointSpring, Kind, Motor, Spring
from nonsmooth.scenes.elliptic_friction import EllipticFriction
from nonsmooth.scenes.inertia import inertia_of
from nonsmooth.scenes.joint_friction import GuideFriction, JointFriction, PinFriction
from nonsmooth.scenes.joint_kinds import BALL_TURNS, Rows, blocks_of, coordinate_rows, rows_of
from nonsmooth.scenes.materials import Material, impact_of_pair
from nonsmooth.scenes.pair_laws import coefficients_of, require_known_pairs, resistances_of
from nonsmooth.scenes.parts import parts_of
from nonsmooth.scenes.places import ORIGIN, compose, conjugate, inverse, place_of, rotate, times
from nonsmooth.scenes.ranges import require_within
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shape_rows import ShapeRow, shape_block
from nonsmooth.scenes.shapes import PLANAR, SPATIAL, Shape, as_turn

# chosen: of the smaller of two bodies: a start may penetrate by this part of it, as bodies that were laid by hand do
OVERLAP = 1e-3
# chosen: times what a velocity gained in the step before, that it may gain, or what gravity gives in a step: more is a
# jump. Without the second part a pallet slips by a dt^2/2 where its platform begins to accelerate
GAIN_GROWTH = 2.0
NO_BODY = -1  # code: what no impulse moves, in the place of a body
RUBBED = {"hinge": "angle", "joint": "turns", "slider": "travel"}  # defined: what friction in a joint is against
ANY_DIRECTION = (0.0, 0.0, 1.0)  # code: of what a ball bears, before it has borne something


class World:
    """The blocks of a scene at the start of a run.

    Parameters
    ----------
    scene : Scene
    t : float
        Start [s].

    Raises
    ------
    InvalidInput
        For a body that cannot be one, by name.
    """

    def __init__(self, scene: Scene, t: float) -> None:
        self.scene, self.dim, self.t_0 = scene, scene.dim, t
        n_b = len(scene.bodies)
        self.bodies = new(Bodies, n_b=n_b, dim=scene.dim)
        self.bodies.gravity[:] = scene.gravity
        self.bodies.gain_before[:] = np.nan
        self.frames = np.tile(ORIGIN[scene.dim], (n_b, 1))  # of the principal axes in those of the shape
        self._place()
        rows, materials = [], []
        self.material_numbers: dict[int, int] = {}
        for body, parts in zip(scene.bodies, self._parts(), strict=True):
            rows += [part._replace(body=body.index) for part in parts]
            materials += [self._number_of(body)] * len(parts)
        self.shapes = shape_block(rows)
        self.surfaces = self._surfaces(materials)
        if self.surfaces.has_grain:
            self._lay_grain()
        if self.surfaces.adhesion.any():  # what adheres is held from the first step on
            self.bodies.keeps[:] = self.bodies.motion.moves
        self.joints = self._joints()
        self.springs, self.drives = self._springs(), self._drives()
        self.guided = [body for body in scene.bodies if body.motion is not None]

    def _place(self) -> None:
        """Where bodies are, how they move and what they weigh."""
        listed, bodies, d = self.scene.bodies, self.bodies, self.dim
        if not listed:
            return
        x, v = bodies.motion.x, bodies.motion.v
        starts = [(b.position, b.turn) if b.motion is None else place_at(b, self.t_0, d) for b in listed]
        x[:, :d], x[:, d:] = (np.reshape(part, (len(x), -1)) for part in zip(*starts, strict=True))
        v[:, :d] = [body.velocity for body in listed]
        v[:, d:] = np.reshape([body.spin for body in listed], (len(v), -1))
        dynamic = [body for body in listed if body.kind is Kind.DYNAMIC]
        if moving := [body.index for body in dynamic]:
            bodies.motion.moves[moving] = 1
            masses, centres, axes, moments = zip(*(inertia_of(body, d) for body in dynamic), strict=True)
            bodies.mass[moving], bodies.moments[moving] = masses, moments
            self.frames[moving, :d], self.frames[moving, d:] = centres, np.reshape(axes, (len(moving), -1))
        for b in np.flatnonzero((self.frames != ORIGIN[d]).any(axis=1)):
            x[b] = compose(x[b], self.frames[b])
        for body in listed:
            if body.surface_velocity is not None:
                turn = self.frames[body.index, d:] if d == 3 else self.frames[body.index, 2]
                bodies.surface[body.index] = rotate(conjugate(turn) if d == 3 else -turn, body.surface_velocity)

    def _parts(self) -> Iterator[list[ShapeRow]]:
        """The parts of each body along its principal axes: those of many bodies are the same."""
        known: dict[tuple[Shape, bytes], list[ShapeRow]] = {}
        for body, frame in zip(self.scene.bodies, self.frames, strict=True):
            key = (body.shape, frame.tobytes())
            if key not in known:
                known[key] = [part.row(0, inverse(frame)) for part in parts_of(body.shape, self.dim)]
            yield known[key]

    def _number_of(self, body: Body) -> int:
        return self.material_numbers.setdefault(id(body.material), len(self.material_numbers))

    def _surfaces(self, materials: list[int]) -> Surfaces:
        """Coefficients of all pairs of materials that occur."""
        known = {id(body.material): body.material for body in self.scene.bodies}
        listed = [known[key] for key in self.material_numbers]
        require_known_pairs(self.scene)
        moving = {id(body.material) for body in self.scene.bodies if body.kind is Kind.DYNAMIC}
        bodies = Counter(id(body.material) for body in self.scene.bodies)
        laws: list[FrictionLaw] = []
        pairs: list[tuple[Material, Material, float]] = []
        mu, e, rolling, spinning, adhesion, across = np.zeros((6, len(listed), len(listed)))
        for a, first in enumerate(listed):
            for b, second in enumerate(listed):
                touch = id(first) in moving or id(second) in moving
                if a == b and bodies[id(first)] == 1 and isinstance(first.mu, EllipticFriction):
                    touch = False
                friction, e[a, b] = coefficients_of(self.scene, first, second) if touch else (0.0, 0.0)
                across[a, b] = friction.across if isinstance(friction, EllipticFriction) else -1.0
                laws.append(as_law(friction.along if isinstance(friction, EllipticFriction) else friction))
                if touch:
                    rolling[a, b], spinning[a, b], adhesion[a, b] = resistances_of(self.scene, first, second)
                if touch and (a < b or (a == b and bodies[id(first)] > 1)):
                    pairs.append((first, second, float(e[a, b])))
        has_laws = any(not isinstance(law, Coulomb) for law in laws)
        has_grain = bool((across > 0.0).any())
        if has_laws and has_grain:
            raise InvalidInput("a scene has laws of the sliding speed or EllipticFriction, and this one has both")
        sizes = {"n_s": len(materials), "n_m": len(listed), "width": LAW_WIDTH}
        surfaces = new(Surfaces, n_l=len(laws) if has_laws else 0, n_g=len(materials) if has_grain else 0, **sizes)
        surfaces.has_laws, surfaces.material[:], surfaces.e[:] = has_laws, materials, e
        rows = self._law_rows(laws)
        mu.flat[:] = [interpreted(static_coefficient)(rows, k) for k in range(len(rows))]
        surfaces.mu[:], surfaces.laws[:] = mu, rows[: len(surfaces.laws)]
        surfaces.has_grain, surfaces.across[:] = has_grain, np.where(across > 0.0, across, mu)
        surfaces.rolling[:], surfaces.spinning[:], surfaces.adhesion[:] = rolling, spinning, adhesion
        surfaces.impact = int(law_of_impacts(pairs))
        return surfaces

    def _lay_grain(self) -> None:
        """The directions of friction on the shapes, along the principal axes of their bodies."""
        for s, b in enumerate(self.shapes.body):
            mu = self.scene.bodies[b].material.mu
            if isinstance(mu, EllipticFriction):
                direction = np.array(mu.direction) / np.linalg.norm(mu.direction)
                self.surfaces.grain[s] = rotate(conjugate(self.frames[b, SPATIAL:]), direction)

    def _law_rows(self, laws: list[FrictionLaw]) -> np.ndarray:
        """The laws as the kernels read them; those of the user's are functions of the speed alone."""
        rows = np.array([law_row(law, 0.0, 0.0, "newton", {}) for law in laws]).reshape(-1, LAW_WIDTH)
        self.no_parameters = np.zeros(1)  # what the laws of the user's are handed in place of parameters
        for k, law in enumerate(laws):
            if isinstance(law, Friction):
                rows[k, LAW_C] = handle_of_law(law.function, unpack_of(layout_of(())))
        point_to(rows, self.no_parameters)
        return rows

    def _joints(self) -> Joints:
        """The rows of joints, in blocks, along the axes of their bodies, and who passes through whom."""
        listed, x, d = self.scene.joints, self.bodies.motion.x, self.dim
        pairs = sorted(sorted((a.index, b.index)) for a, b in self.scene.apart())
        blocks = [(joint, rows) for joint in listed for rows in blocks_of(rows_of(joint.kind, d), d)]
        joints = new(Joints, n_j=len(blocks), n_n=len(listed), n_p=len(pairs), n_b=len(x), d=d)
        joints.count, joints.apart = len(blocks), len(pairs)
        joints.of[:] = [joint.index for joint, _ in blocks]
        joints.begin[:] = np.searchsorted(joints.of, np.arange(len(listed)))
        joints.body_i[:], joints.body_j[:] = ([getattr(j, side).index for j in listed] for side in "ab")
        looped, others = looped_joints(listed), [list[int]() for _ in x]
        for i, j in pairs:
            others[i].append(j)
            others[j].append(i)
        for k, (joint, rows) in enumerate(blocks):
            self._frame(joints, k, joint, rows)
            joints.length[k] = joint.length or 0.0
            joints.is_looped[k] = joint.index in looped
        joints.loops, joints.machine[:] = joints.is_looped.sum(), machines_of(listed, len(x))
        joints.first[1:] = np.cumsum([len(row) for row in others])
        joints.other[:] = np.concatenate([np.array(row, np.int64) for row in others]) if pairs else []
        return joints

    def _drives(self) -> Drives:
        """Limits, motors with a speed and springs, along the coordinates that joints leave free."""
        d = self.dim
        listed = [(joint, *row) for joint in self.scene.joints for row in drives_of_joint(joint)]
        drives = new(Drives, n_k=len(listed), n_n=len(self.scene.joints), d=d)
        drives.count = len(listed)
        drives.of[:] = [joint.index for joint, *_ in listed]
        drives.begin[:] = np.searchsorted(drives.of, np.arange(len(self.scene.joints)))
        self.speeds: list[tuple[int, float, Joint, Motor]] = []
        self.sprung: dict[tuple[int, str], tuple[int, float]] = {}  # coordinates with a spring: its drive and its lever
        for k, (joint, along, (low, high), what) in enumerate(listed):
            row = BALL_TURNS if along == "turns" else coordinate_rows(joint.kind, d)[along]
            self._frame(drives, k, joint, (row,))
            scale = drives.lever[k] if along in ("angle", "turns") else 1.0
            if isinstance(what, PinFriction):
                drives.law[k], drives.arm[k], drives.across[k] = RUBS, what.arm / scale, ANY_DIRECTION
            elif isinstance(what, GuideFriction):
                drives.law[k], drives.arm[k], drives.guide[k] = RUBS, what.mu, what.length
            elif isinstance(what, JointSpring):
                drives.law[k], drives.low[k], drives.rate[k] = SPRINGS, low * scale, np.nan
                drives.spring[k] = np.array((what.stiffness, what.damping, what.inertia)) / scale**2
                self.sprung.setdefault((joint.index, along), (k, float(scale)))
            elif what is None:
                drives.law[k], drives.low[k], drives.high[k] = STOPS, low * scale, high * scale
                drives.e[k] = joint.e
            else:
                drives.law[k], drives.high[k] = SPEED, high / scale
                self.speeds.append((k, float(scale), joint, what))
                drives.speed[k] = 0.0 if callable(what.speed) else scale * float(what.speed or 0.0)
        return drives

    def _frame(self, block: Joints | Drives, k: int, joint: Joint, rows: Rows) -> None:
        """Row k of joints or drives: its rows, its lever, and the frames of the joint along the axes of its bodies."""
        d, x = self.dim, self.bodies.motion.x
        block.u[k], block.w[k] = zip(*rows, strict=True)
        block.lever[k] = self._lever_of(joint)
        at_b = joint.at if joint.at_b is None else joint.at_b
        for side, body, at, axes in (("i", joint.a, joint.at, joint.axes), ("j", joint.b, at_b, joint.axes_b)):
            self._join(block, k, side, body, at)
            turn = x[body.index, d:] if d == 3 else x[body.index, 2]
            getattr(block, f"axes_{side}")[k] = rotate(conjugate(turn) if d == 3 else -turn, axes)
        if d == PLANAR:
            block.angle[k] = x[joint.b.index, 2] - x[joint.a.index, 2]

    def _lever_of(self, joint: Joint) -> float:
        """The lever at which turns of a joint count: the reach of the smaller of its bodies that move [m]."""
        reach = self.shapes.reach + self.shapes.radius
        moving = [body.index for body in (joint.a, joint.b) if body.kind is Kind.DYNAMIC]
        return min(float(reach[self.shapes.body == b].max()) for b in moving)

    def _springs(self) -> Springs:
        """The rows of springs: one along the line between its ends, of one of length 0 one along each axis."""
        axes = [(spring, axis) for spring in self.scene.springs for axis in self._axes_of(spring)]
        springs, x = new(Springs, n_a=len(axes), d=self.dim), self.bodies.motion.x
        springs.count = len(axes)
        for k, (spring, axis) in enumerate(axes):
            springs.axis[k], springs.stiffness[k], springs.damping[k] = axis, spring.stiffness, spring.damping
            self._join(springs, k, "i", spring.a, spring.at_a)
            self._join(springs, k, "j", spring.b, spring.at_b)
            at_start = interpreted(line_of)(springs, x, k)[-1] if axis < 0 else 0.0
            springs.length[k] = at_start if spring.length is None else spring.length
        return springs

    def _axes_of(self, spring: Spring) -> tuple[int, ...]:
        if spring.is_torsion:
            return (TORSION,)
        first, second = (
            self.bodies.motion.x[body.index, : self.dim] if at is None else at
            for body, at in ((spring.a, spring.at_a), (spring.b, spring.at_b))
        )
        has_length = (first != second).any() if spring.length is None else spring.length > 0.0
        return (ALONG,) if has_length else tuple(range(self.dim))

    def _join(self, ends: Joints | Springs | Drives, k: int, side: str, body: Body, at: np.ndarray | None) -> None:
        """Row k of a joint or a spring has an end on a body, at a point of the world or at its centre of mass."""
        b, d, x = body.index, self.dim, self.bodies.motion.x
        getattr(ends, side)[k] = b
        getattr(ends, f"shape_{side}")[k] = np.flatnonzero(self.shapes.body == b)[0]
        if at is not None:
            getattr(ends, f"arm_{side}")[k] = compose(inverse(x[b]), place_of(at, ORIGIN[d][d:]))[:d]
        self.bodies.keeps[b] = self.bodies.motion.moves[b]

    def guide(self, t: float, dt: float) -> None:
        """Let guided bodies move from where they are to where they are told to be at t + dt, by the middle of that."""
        bodies, d = self.bodies, self.dim
        for body in self.guided:
            here, b = bodies.motion.x[body.index], body.index
            half, there = (place_of(*place_at(body, t + part * dt, d)) for part in (0.5, 1.0))
            bodies.motion.v[b] = velocity_between(here, there, dt)
            told = velocity_between(half, there, 0.5 * dt) - velocity_between(here, half, 0.5 * dt)
            most = GAIN_GROWTH * np.abs(bodies.gain_before[b])  # NaN at the start, which fmin passes over
            most[: self.dim] = np.maximum(most[: self.dim], dt * np.linalg.norm(bodies.gravity))
            bodies.gain[b], bodies.gain_before[b] = np.copysign(np.fmin(np.abs(told), most), told), told

    def place_guided(self, t: float, dt: float) -> None:
        """Put guided bodies where they are at a time t [s], with their velocities, differences over a short time dt."""
        for body in self.guided:
            before, here, after = (place_of(*place_at(body, at, self.dim)) for at in (max(t - dt, self.t_0), t, t + dt))
            self.bodies.motion.x[body.index] = here
            self.bodies.motion.v[body.index] = velocity_between(before, after, min(2.0 * dt, t + dt - self.t_0))

    def deepest_pair(self, n_c: int, found: Found) -> tuple[str, str, float]:
        """The bodies that are deepest in one another, of the contacts found, and how deep they are [m]."""
        c = int(np.argmin(found.gap[:n_c]))
        first, second = (self.scene.bodies[int(self.shapes.body[s[c]])].name for s in (found.shape_i, found.shape_j))
        return first, second, -float(found.gap[c])

    def require_apart(self, n_c: int, found: Found) -> None:
        """Refuse a start at which two bodies are deep in one another."""
        if n_c == 0:
            return
        c = int(np.argmin(found.gap[:n_c]))
        reach = self.shapes.reach + self.shapes.radius
        if found.gap[c] < -OVERLAP * min(reach[found.shape_i[c]], reach[found.shape_j[c]]):
            first, second, depth = self.deepest_pair(n_c, found)
            raise InvalidInput(
                f"{first} and {second} overlap at the start by {depth:.3g} m; move them apart, or give project=True"
            )

    def go_along(self, n_c: int, found: Found) -> None:
        """At the start what touches a guided body, directly or through others, goes along with it (beside.py)."""
        bodies, moves = self.bodies, self.bodies.motion.moves == 1
        goes = np.array([body.kind is Kind.KINEMATIC for body in self.scene.bodies])
        i, j = (self.shapes.body[shape[:n_c]] for shape in (found.shape_i, found.shape_j))
        count = 0
        while count < (count := int(goes.sum())):
            goes[i[goes[j] & moves[i]]] = True
            goes[j[goes[i] & moves[j]]] = True
        bodies.beside[goes & moves] = bodies.motion.v[goes & moves, : self.dim]

    def require_found(self, n_c: int) -> None:
        """Refuse a start at which a body is so far out that no cell of the broad phase holds it."""
        if n_c == NOT_FINITE:
            raise InvalidInput(
                f"{self.lost()} is nowhere at the start: its place is not finite, or so far out that a float64 has no "
                "room for the smallest shape beside it; put the origin nearer"
            )

    def lost(self) -> str:
        """The first body whose place is not finite, or the one that is farthest out."""
        x = self.bodies.motion.x
        is_lost = ~np.isfinite(x).all(axis=1)
        b = int(np.argmax(is_lost)) if is_lost.any() else int(np.argmax(np.abs(x[:, : self.dim]).max(axis=1)))
        return self.scene.bodies[b].name

    def record(self, x: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, ...]:
        """Position, turn, velocity and spin of all bodies, of their places and velocities (n_b, ...)."""
        if self.dim == PLANAR:
            return x[:, :2], x[:, 2], v[:, :2], v[:, 2]
        return x[:, :3], self.turns(x[None, :, 3:])[0], v[:, :3], v[:, 3:]

    def turns(self, quaternions: np.ndarray) -> np.ndarray:
        """The turns of the shapes (n_t, n_b, 4) from those of the principal axes."""
        return times(quaternions, conjugate(self.frames[:, 3:])[None])

    def energies(self, x: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        """Kinetic and potential energy of records (n_t, n_b, ...) [J]; the potential is 0 at the origin."""
        bodies, d = self.bodies, self.dim
        moves = np.flatnonzero(bodies.motion.moves)
        mass, moments = bodies.mass[moves], bodies.moments[moves]
        # in order, so that a sum is the same to the last bit whatever other records stand beside it
        v, x = np.ascontiguousarray(v[:, moves]), np.ascontiguousarray(x[:, moves])
        kinetic = 0.5 * (mass * (v[..., :d] ** 2).sum(axis=-1)).sum(axis=-1)
        if d == PLANAR:
            kinetic += 0.5 * (moments[:, 0] * v[..., 2] ** 2).sum(axis=-1)
        else:
            spins = moments * turned_back(x[..., 3:], v[..., 3:]) ** 2
            kinetic += 0.5 * spins.reshape(len(x), -1).sum(axis=-1)
        potential = -(mass[:, None] * x[..., :d] * self.scene.gravity).reshape(len(x), -1).sum(axis=-1)
        return {"kinetic": kinetic, "potential": potential}


def law_of_impacts(pairs: list[tuple[Material, Material, float]]) -> ImpactLaw:
    """The law of impact of all pairs of materials that may touch, with their e: those that rebound have one, and
    coefficients that can be its own."""
    rebounds = [(f"{a} and {b}", impact_of_pair(a, b) or "newton", e) for a, b, e in pairs if e > 0.0]
    laws = {law: who for who, law, _ in rebounds}
    if len(laws) > 1:
        said = [f"{who} have {law!r}" for law, who in laws.items()]
        raise InvalidInput(
            f"the bodies of a scene rebound by one law of impact, and {said[0]}, {said[1]}; give their materials one"
        )
    law, of_e = next(iter(laws), "newton"), sorted({e for *_, e in pairs})
    said_e = ", ".join(f"{e:g}" for e in of_e)
    if law == "poisson" and len({e for *_, e in rebounds}) > 1:
        raise InvalidInput(
            f"impact = 'poisson' of a scene needs one e of all that rebound, with several they may gain energy; got "
            f"{said_e}; impact='sequential' or 'energetic' takes several"
        )
    if law == "energetic" and of_e[0] == 0.0:
        raise InvalidInput(
            f"impact = 'energetic' of a scene needs e > 0 of all pairs of materials that may touch; got {said_e}; "
            "impact='sequential' takes any"
        )
    return IMPACT_LAWS[law]


Drive = Motor | JointFriction | JointSpring | None  # None: a limit


def drives_of_joint(joint: Joint) -> list[tuple[str, tuple[float, float], Drive]]:
    """The coordinates of the limits, motors, friction and springs of a joint, their bounds, and what they are of."""
    stops = [(along, pair, None) for along, pair in joint.limits.items() if not np.isinf(pair).all()]
    motors = [(motor.along, (0.0, motor.limit), motor) for motor in joint.motors if motor.speed is not None]
    rubs = [] if joint.friction is None else [(RUBBED[joint.kind], (0.0, 0.0), joint.friction)]
    springs = [(spring.along, (spring.rest, np.inf), spring) for spring in joint.springs]
    return [*stops, *motors, *rubs, *springs]


def looped_joints(listed: list[Joint]) -> set[int]:
    """Which joints are in a loop of joints; what no impulse moves is one body."""
    ways: dict[int, list[tuple[int, int]]] = {}  # from each body a joint and what is behind it: a forest
    root: dict[int, int] = {}
    found: set[int] = set()
    for k, joint in enumerate(listed):
        if joint.kind == "rope":
            continue
        first, second = (body.index if body.kind is Kind.DYNAMIC else NO_BODY for body in (joint.a, joint.b))
        a, b = (root_of(root, body) for body in (first, second))
        if a == b:
            found |= {k, *joints_between(ways, first, second)}
        else:
            root[a] = b
            ways.setdefault(first, []).append((k, second))
            ways.setdefault(second, []).append((k, first))
    return found


def machines_of(listed: list[Joint], n_b: int) -> list[int]:
    """Of each body the one that stands for all that are joined to it; through what no impulse moves nothing is."""
    root: dict[int, int] = {}
    for joint in listed:
        if joint.kind != "rope" and joint.a.kind is joint.b.kind is Kind.DYNAMIC:
            root[root_of(root, joint.a.index)] = root_of(root, joint.b.index)
    return [root_of(root, body) for body in range(n_b)]


def root_of(root: dict[int, int], body: int) -> int:
    """The body that stands for all that are joined to one, whose ways there become shorter."""
    while (above := root.setdefault(body, body)) != body:
        root[body] = body = root.setdefault(above, above)
    return body


def joints_between(ways: dict[int, list[tuple[int, int]]], first: int, second: int) -> list[int]:
    """The joints between two bodies of a tree."""
    at: list[tuple[int, list[int]]] = [(first, [])]
    seen = {first}
    for body, way in at:
        if body == second:
            return way
        at += [(other, [*way, k]) for k, other in ways.get(body, []) if other not in seen]
        seen |= {other for _, other in ways.get(body, [])}
    raise AssertionError("they are joined")


def turned_back(quaternions: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) of the world in the axes of bodies with unit quaternions (..., 4)."""
    w, r = quaternions[..., :1], quaternions[..., 1:]
    c = np.cross(r, v) - w * v
    return v + 2.0 * np.cross(r, c)


def place_at(body: Body, t: float, dim: int) -> tuple[np.ndarray, float | np.ndarray]:
    """What the motion of a guided body says of its place at a time [s]."""
    name = f"motion of {body.name}"
    assert body.motion is not None
    said = result_of(f"{name} at t = {t:g} s", body.motion, t)
    is_pair = isinstance(said, tuple | list) and len(said) == 2 and not is_number(name, said[0])
    position, turn = said if is_pair else (said, None)
    as_listed(name, position, f"a position of {dim} numbers [m], or (position, turn)")
    return require_within(name, as_vector(name, position, dim), "m"), as_turn(name, turn, dim)


def velocity_between(here: np.ndarray, there: np.ndarray, dt: float) -> np.ndarray:
    """The velocity (n,) that moves a body from one place (n_x,) to the other."""
    if len(here) == 3:
        return (there - here) / dt
    return np.concatenate(((there[:3] - here[:3]) / dt, spin_between(here[3:], there[3:], dt)))


def spin_between(here: np.ndarray, there: np.ndarray, dt: float) -> np.ndarray:
    """The angular velocity that turns one place to the other by the map of a step, cay(dt omega); of many places."""
    if here.shape[-1] == 1:
        return (there - here) / dt
    turn = times(there, conjugate(here))
    return 2.0 * turn[..., 1:] / (turn[..., :1] * dt)
