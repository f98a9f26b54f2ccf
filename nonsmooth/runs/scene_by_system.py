"""A scene integrated as its system, by the methods that scenes have no step of their own for.

What is run is `Scene.system()`; what comes back is a run of the scene: bodies by name, contacts with their points and
their impulses in the axes of the world, energies of all bodies, events by pairs of bodies. Impulses and penetrations
are those since the record before.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.integrators import records
from nonsmooth.integrators.adaptive.options import Adaptive
from nonsmooth.integrators.assembly.paradox_events import MOST_PARADOXES
from nonsmooth.integrators.assembly.world import World
from nonsmooth.integrators.contract import Integrator
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.jit import interpreted
from nonsmooth.mechanics.laws import CONSTANT, LAW_CODE, static_coefficient
from nonsmooth.mechanics.system import ContactMode, System
from nonsmooth.results.events import SceneEventKind
from nonsmooth.results.failures import StepFailure
from nonsmooth.results.ledger import OF_ALL, STEP
from nonsmooth.results.recorded import (
    BODIES,
    CONTACTS,
    COORDINATES,
    EVENTS,
    GAPS,
    IMPULSES,
    KINDS_OF_SCENE,
    LEDGER,
    MODES,
    VELOCITIES,
)
from nonsmooth.results.scene_bodies import SceneState
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.results.solution import Solution
from nonsmooth.results.stats import SceneStats
from nonsmooth.results.table import event_arrays, event_row
from nonsmooth.runs.choice import MOST_WITHOUT_FRICTION, PER_ATOL, STEPS_OF_SPAN, Auto
from nonsmooth.runs.refused_scenes import require_taken_by_system
from nonsmooth.scenes.as_system import CURE, moving_of, system_of, touches_of
from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.places import rotate_all, times, turn_by
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import PLANAR
from nonsmooth.scenes.solids_as_system import all_tangents
from nonsmooth.scenes.spheres_as_system import nothing_turns

# measured (docs/scenes.md): contacts with friction that may close, up to which a second takes some ten seconds
MOST_RUBBING = 40
# what is recorded of the system for each kind of a scene
KINDS_OF = {
    BODIES: (COORDINATES, VELOCITIES), CONTACTS: (COORDINATES, GAPS, MODES, IMPULSES),
    LEDGER: (COORDINATES, VELOCITIES, LEDGER), EVENTS: (COORDINATES, MODES, EVENTS),
}  # fmt: skip


def choice_of_scene(
    choice: Auto, scene: Scene, t_span: tuple[float, float], refused: dict[str, Any]
) -> tuple[Integrator, str]:
    """The integrator for a scene at its start, and why: of its system where it has one of few contacts, and nothing is
    asked for that such a run does not take."""
    try:
        require_taken_by_system("a method of systems", refused)
        system = few_contacts(scene, "a method of systems", t_span[0], follows_turns=True)
        chosen, why = choice.choose(scene, system, t_span, *scene.state())
        has_steps = isinstance(chosen, MoreauJean | Adaptive) and system.is_spatial
        return (by_steps(choice, scene, t_span), why) if has_steps else (chosen, why)
    except InvalidInput as refusal:
        return by_steps(choice, scene, t_span), str(refusal).split(";")[0]


def by_steps(choice: Auto, scene: Scene, t_span: tuple[float, float]) -> Integrator:
    """The integrator of steps of the scene, which has no system or a large one."""
    if choice.rtol is not None:
        return Adaptive(choice.rtol, choice.rtol / PER_ATOL)
    return MoreauJean(scene.dt if scene.dt is not None else (t_span[1] - t_span[0]) / STEPS_OF_SPAN)


def few_contacts(scene: Scene, method: str, t_0: float, follows_turns: bool) -> System:
    """The system of a scene, or `InvalidInput` where it has too many contacts for a method, or one that turns in space
    for a method that does not follow that."""
    moving = len(moving_of(scene))
    pairs = moving * (len(scene) - moving) + moving * (moving - 1) // 2 - len(scene.apart())
    if scene.dim != PLANAR and not follows_turns and not nothing_turns(scene):
        raise InvalidInput(f"{method} takes no bodies that turn in space, and no friction there; {CURE}")
    system = system_of(scene, None, t_0) if pairs <= MOST_WITHOUT_FRICTION else None  # each pair has a contact
    rubbing = 0 if system is None else int((system.kinds[:, 1] > 0).sum())
    if system is None or system.n_c > MOST_WITHOUT_FRICTION or rubbing > MOST_RUBBING:
        got = f"{pairs} pairs of bodies" if system is None else f"{system.n_c}, {rubbing} with friction"
        raise InvalidInput(
            f"{method} takes scenes of up to {MOST_WITHOUT_FRICTION} contacts that may close, {MOST_RUBBING} of them "
            f"with friction, and this scene has {got}; {CURE}"
        )
    return system


class SceneBySystem:
    """The system of a scene, and what its run says of the scene.

    Parameters
    ----------
    scene : Scene
    t_span : (float, float)
        [s]
    integrator : Integrator
    record : str or sequence of str, optional
        Kinds of a scene.
    functions : sequence of callables
        Events f(t, bodies) of the user.
    refused : mapping
        Options of `simulate` that such a run does not take, as they were given; None or False where left out.
    """

    def __init__(
        self, scene: Scene, t_span: tuple[float, float], integrator: Integrator, record: Any,
        functions: Sequence[Callable], refused: dict[str, Any],
    ) -> None:  # fmt: skip
        method = type(integrator).__name__
        self.kinds = KINDS_OF_SCENE.chosen(record)
        require_taken_by_system(method, refused)
        self.scene, self.t_span, self.t_0 = scene, t_span, t_span[0]
        self.system, self.start = few_contacts(scene, method, self.t_0, True), scene.state()
        self.touches = touches_of(scene)
        self.world, self.names = World(scene, self.t_0), [body.name for body in scene.bodies]
        self.moving = np.array([body.index for body in moving_of(scene)])
        of_events = {IMPULSES} if EVENTS in self.kinds and self.system.d > 1 else set()
        self.record = sorted({kind for own in self.kinds for kind in KINDS_OF[own]} | {EVENTS} | of_events)
        self.events = [self._of_bodies(function) for function in functions]

    def run_by(self, simulate: Callable[..., Solution]) -> SceneSolution:
        """Simulate the system, and return the run of the scene, or raise its failure."""
        try:
            run = simulate(self.system, self.t_span, *self.start, self.events, self.record)
        except StepFailure as failure:
            raise self.failure(failure) from failure.__cause__
        return self.solution(run)

    def _of_bodies(self, function: Callable) -> Callable:
        """An event of the user as a function of the state of the system."""

        @functools.wraps(function)
        def of_state(t: float, q: np.ndarray, u: np.ndarray) -> Any:
            x, v = self.places(np.array([t]), q[None], u[None])
            return function(t, self._state(t, x[0], v[0]))

        vars(of_state).pop("__wrapped__", None)  # it takes other arguments
        return of_state

    def _state(self, t: float, x: np.ndarray, v: np.ndarray) -> SceneState:
        return SceneState(t, self.names, self.scene, *self._columns(x, v))

    def _columns(self, x: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, ...]:
        """Position, turn, velocity and spin of places (..., n_b, 3|7) and rates (..., n_b, 3|6)."""
        d = self.scene.dim
        if d == PLANAR:
            return x[..., :2], x[..., 2], v[..., :2], v[..., 2]
        return x[..., :3], self.world.turns(x[..., 3:]), v[..., :3], v[..., 3:]

    def places(self, t: np.ndarray, q: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places and rates of all bodies at times (n_t,) with states (n_t, n_q), as steps of scenes have them."""
        motion, d, s = self.world.bodies.motion, self.scene.dim, (t - self.t_0)[:, None, None]
        v = np.tile(motion.v, (len(t), 1, 1))
        x = np.tile(motion.x, (len(t), 1, 1))
        if d == PLANAR:
            x += s * motion.v
            x[:, self.moving], v[:, self.moving] = (part.reshape(len(t), -1, 3) for part in (q, u))
            return x, v
        x[..., :3] += s * motion.v[:, :3]
        x[..., 3:] = times(turn_by(s * motion.v[:, 3:]), x[..., 3:])
        if self.system.kinematics is None:
            x[:, self.moving, :3], v[:, self.moving, :3] = (part.reshape(len(t), -1, 3) for part in (q, u))
            return x, v
        q, u = q.reshape(len(t), -1, 7), u.reshape(len(t), -1, 6)
        turns = q[..., 3:] / np.linalg.norm(q[..., 3:], axis=-1, keepdims=True)
        x[:, self.moving] = np.concatenate((q[..., :3], turns), axis=-1)
        v[:, self.moving] = np.concatenate((u[..., :3], rotate_all(turns, u[..., 3:])), axis=-1)
        return x, v

    def solution(self, run: Solution) -> SceneSolution:
        """The run of the system as one of the scene."""
        q = run.q if len(self.kinds) else np.tile(self.start[0], (len(run.t), 1))
        has_velocities = VELOCITIES in self.record
        x, v = self.places(run.t, q, run.u if has_velocities else np.zeros((len(q), self.system.n_u)))
        unknown, scene = np.full(len(run.t), np.nan), self.scene
        columns = {
            "t": run.t, "residual": unknown, "penetration": unknown, "centres": self.world.frames[:, : scene.dim],
            "paradox_rows": self._paradox_rows(run),
        } | {f"t_events/{k}": found for k, found in enumerate(run.t_events)}  # fmt: skip
        if BODIES in self.kinds:
            columns |= zip(("position", "turn", "velocity", "spin"), self._columns(x, v), strict=True)
        if CONTACTS in self.kinds:
            columns["penetration"] = 0.0 - run.g_N[:, : self.n_pairs].min(axis=1, initial=0.0)
            pulls = self._joint_impulses(run)
            columns |= self._contacts(run, x) | {
                "joint_impulses": pulls,
                "joint_torques": np.zeros(pulls.shape[:2] if scene.dim == PLANAR else pulls.shape),
            }
        if LEDGER in self.kinds:
            ledger = self.world.energies(x, v) | {name: run.ledger[name] for name in OF_ALL}
            columns |= {f"{LEDGER}/{name}": column for name, column in ledger.items()}
            columns[f"{LEDGER}/{STEP}"] = unknown  # not told apart
        columns |= self._events(run) if EVENTS in self.kinds else {}
        return SceneSolution(
            columns, self._stats(run, columns), run.status, run.message, self.names, scene, self._about(run),
            [joint.name for joint in scene.joints],
            find_motion=functools.partial(self._between, run),
        )  # fmt: skip

    def _between(self, run: Solution, t: np.ndarray) -> tuple[np.ndarray, ...]:
        """Position, turn, velocity and spin of all bodies at times."""
        return self._columns(*self.places(t, *run(t)))

    def failure(self, failure: StepFailure) -> StepFailure:
        """A failure of the system as one of the scene."""
        return type(failure)(str(failure), self.solution(failure.solution), failure.t, failure.problem)  # type: ignore[arg-type]

    def _about(self, run: Solution) -> dict[str, Any]:
        chosen: dict[str, Any] = {name: run.about[name] for name in ("integrator", "chosen") if name in run.about}
        return {
            **self.scene.parameter_values, "scene": repr(self.scene), **chosen,
            "contacts": f"{self.n_pairs} that may close",
        }  # fmt: skip

    def _stats(self, run: Solution, columns: dict[str, np.ndarray]) -> SceneStats:
        cost, has_contacts = run.stats, CONTACTS in self.kinds
        closed = np.diff(columns["contacts/offsets"]) if has_contacts else np.zeros(1, int)
        impacts = int((run.event_rows[:, records.EVENT_KIND] == records.IMPACT).sum())
        drift = np.abs(run.g_N[:, self.n_pairs :]) if has_contacts else np.zeros((1, 0))
        return SceneStats(
            cost.steps, int(closed[-1]), int(closed.max()), 0, {}, 0,
            cost.factorisations, impacts, 0, np.nan, cost.worst_residual, np.nan, 0, cost.worst_penetration,
            float(columns["penetration"][-1]), cost.wall_time, cost.compile_time, cost.energy_gains,
            cost.worst_energy_gain, cost.struck_together, cost.first_together,
            worst_joint_drift=float(drift.max(initial=0.0)), last_joint_drift=float(drift[-1].max(initial=0.0)),
            inconsistent=int((run.event_rows[:, records.EVENT_KIND] == records.INCONSISTENT).sum()),
            indeterminate_steps=cost.indeterminate_steps,
        )  # fmt: skip

    # --- contacts

    @property
    def n_pairs(self) -> int:
        """Contacts of pairs of bodies; those of joints stand behind them, two each."""
        return self.system.n_c - 2 * len(self.scene.joints)

    @functools.cached_property
    def sides(self) -> np.ndarray:
        """(n_pairs, 2) the bodies i and j of the contacts, by their number in the scene."""
        pairs = self.touches[: self.n_pairs]
        return np.array([(touch.i.of_scene, touch.j.of_scene) for touch in pairs], np.int64).reshape(-1, 2)

    def _where(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points midway between the surfaces and normals (n_t, n_pairs, d), from body j to body i."""
        pairs, d = self.touches[: self.n_pairs], self.scene.dim
        points = []
        for side in ("i", "j"):
            own = [getattr(touch, side) for touch in pairs]
            of = x[:, [part.of_scene for part in own]]
            arm = np.array([part.arm for part in own]).reshape(-1, d)
            if d == PLANAR:
                c, s = np.cos(of[..., 2]), np.sin(of[..., 2])
                turned = np.stack((c * arm[:, 0] - s * arm[:, 1], s * arm[:, 0] + c * arm[:, 1]), axis=-1)
            else:
                turned = rotate_all(of[..., 3:], np.broadcast_to(arm, of[..., :3].shape))
            in_world = np.array([self.scene.bodies[part.of_scene].kind is Kind.FIXED for part in own], bool)
            points.append(np.where(in_world[:, None], arm, of[..., :d] + turned))
        between = points[0] - points[1]
        normals = [np.full(d, np.nan) if touch.normal is None else touch.normal for touch in pairs]
        flat = np.broadcast_to(np.array(normals).reshape(-1, d), between.shape)
        if d != PLANAR:
            on = [touch.j.of_scene for touch in pairs]
            is_guided = [self.scene.bodies[body].kind is Kind.KINEMATIC for body in on]
            flat = np.where(np.array(is_guided)[:, None], rotate_all(x[:, on, 3:], flat), flat)
        normal = np.where(np.isnan(flat), between / np.linalg.norm(between, axis=-1, keepdims=True), flat)
        radii = np.array([(touch.i.radius, touch.j.radius) for touch in pairs]).reshape(-1, 2)
        gap = (normal * between).sum(axis=-1) - radii.sum(axis=1)
        return points[0] - normal * (radii[:, 0] + 0.5 * gap)[..., None], normal

    def _impulses(self, P_N: np.ndarray, P_F: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """P_N n + P_F t on body i, in the axes of the world; P_F (..., d)."""
        if P_F.shape[-1] == 0:
            return P_N[..., None] * normal
        if self.scene.dim != PLANAR:
            return P_N[..., None] * normal + (P_F[..., None] * all_tangents(normal)).sum(axis=-2)
        tangent = np.stack((normal[..., 1], -normal[..., 0]), axis=-1)
        return P_N[..., None] * normal + P_F * tangent

    def _contacts(self, run: Solution, x: np.ndarray) -> dict[str, np.ndarray]:
        """The closed contacts of all records; the body of the smaller number pushes the other."""
        m = self.n_pairs
        point, normal = self._where(x)
        P = self._impulses(run.P_N[:, :m], run.P_F[:, :m], normal)
        is_closed = (run.mode[:, :m] != ContactMode.OPEN) | (run.P_N[:, :m] > 0.0)
        k, c = np.nonzero(is_closed)
        sign = np.where(self.sides[:, 0] < self.sides[:, 1], -1.0, 1.0)[c, None]  # of n out of the smaller number
        laws = self.system.laws[:m]
        mu = np.array([interpreted(static_coefficient)(laws, i) for i in range(m)]) * (self.system.kinds[:m, 1] > 0)
        slides = (run.mode[:, :m] == ContactMode.SLIDE) & (run.P_N[:, :m] > 0.0) & (laws[:, LAW_CODE] != CONSTANT)
        used = np.divide(
            np.linalg.norm(run.P_F[:, :m], axis=2), run.P_N[:, :m], out=np.tile(mu, (len(run.t), 1)), where=slides
        )
        found = {
            "offsets": np.concatenate(([0], np.cumsum(is_closed.sum(axis=1)))),
            "i": self.sides.min(axis=1, initial=2**62)[c], "j": self.sides.max(axis=1, initial=0)[c],
            "point": point[k, c], "normal": sign * normal[k, c], "gap": run.g_N[:, :m][k, c], "P": sign * P[k, c],
            "mu": used[k, c],
        }  # fmt: skip
        return {f"{CONTACTS}/{name}": column for name, column in found.items()}

    def _joint_impulses(self, run: Solution) -> np.ndarray:
        """(n_t, n_j, 2) on the second body of each joint."""
        return -run.P_N[:, self.n_pairs :].reshape(len(run.t), -1, self.scene.dim)

    # --- events

    def _paradox_rows(self, run: Solution) -> np.ndarray:
        rows = run.event_rows[run.event_rows[:, records.EVENT_KIND] >= records.INCONSISTENT][:MOST_PARADOXES]
        bodies = np.sort(self.sides, axis=1)[rows[:, records.EVENT_CONTACT].astype(int)]
        return np.hstack((rows, bodies))

    def _events(self, run: Solution) -> dict[str, np.ndarray]:
        """Changes of pairs of bodies, from those of their contacts."""
        m = self.n_pairs
        modes, found = run.mode[0, :m].copy(), list[tuple[Any, ...]]()
        rows = run.event_rows[run.event_rows[:, records.EVENT_CONTACT] < m]
        for t, group in groupby(rows, key=lambda row: float(row[records.EVENT_T])):
            at, before, struck = list(group), modes.copy(), np.zeros(m, bool)
            P_N, P_F = np.zeros(m), np.zeros((m, self.system.d))
            k = max(0, int(np.searchsorted(run.t, t, side="right")) - 1)
            for row in at:
                c = int(row[records.EVENT_CONTACT])
                modes[c] = int(row[records.EVENT_MODE_1])
                struck[c] |= row[records.EVENT_KIND] in (records.IMPACT, records.INCONSISTENT)
                P_N[c] += row[records.EVENT_P_N]
                P_F[c] += self._friction_of(row, run, k, c)
            x, _ = self.places(run.t[k : k + 1], run.q[k : k + 1], np.zeros((1, self.system.n_u)))
            impulses = self._impulses(P_N, P_F, self._where(x)[1][0])
            pairs = np.sort(self.sides, axis=1)
            for i, j in np.unique(pairs[[int(row[records.EVENT_CONTACT]) for row in at]], axis=0):
                own = (pairs == (i, j)).all(axis=1)
                on_j = np.where((self.sides[own, 0] == j)[:, None], impulses[own], -impulses[own]).sum(axis=0)
                for kind in kinds_of_change(before[own], modes[own], bool(struck[own].any())):
                    is_parting = kind == SceneEventKind.PARTING
                    found.append((t, kind, i, j, *((0.0, 0.0 * on_j) if is_parting else (P_N[own].sum(), on_j))))
        return event_arrays(np.array(found, event_row(self.scene.dim)))

    def _friction_of(self, row: np.ndarray, run: Solution, k: int, c: int) -> Any:
        """P_F (d,) of an event; in space the row has its size alone, and the direction is that of the impulse in record
        k where that begins at the event, else not a number."""
        size = row[records.EVENT_P_F]
        if self.system.d < 2 or size == 0.0:
            return size
        follows = k > 0 and run.t[k] == run.t[k - 1] == row[records.EVENT_T]
        return run.P_F[k, c] if follows else np.full(2, np.nan)


def kinds_of_change(before: np.ndarray, after: np.ndarray, is_struck: bool) -> list[SceneEventKind]:
    """What happened to a pair of bodies whose contacts had some modes and have others."""
    was, rests = mode_of_pair(before), mode_of_pair(after)
    landing = [SceneEventKind.LANDING] if was == ContactMode.OPEN and (is_struck or rests != ContactMode.OPEN) else []
    if rests == ContactMode.OPEN:
        return [*landing, SceneEventKind.PARTING] if landing or was != ContactMode.OPEN else []
    if landing or was == rests:
        return landing
    return [SceneEventKind.SLIP if rests == ContactMode.SLIDE else SceneEventKind.STICK]


def mode_of_pair(modes: np.ndarray) -> ContactMode:
    """Of two bodies: they stick where one of their contacts does; one without friction slides."""
    if (modes == ContactMode.STICK).any():
        return ContactMode.STICK
    return ContactMode.SLIDE if (modes != ContactMode.OPEN).any() else ContactMode.OPEN
