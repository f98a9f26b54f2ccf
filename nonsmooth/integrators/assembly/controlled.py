"""Steps of a scene as long as their error allows: each is taken whole, and again as two halves.

    e = |x_whole - x_halves|    of every body: of its place, and of its reach times its angle

The halves are kept where e is within what the tolerance, tol = atol + rtol (reach + way from the start), allows:

    smooth      e/3 <= tol max(h/T, SHORT_PART)     the halves err by e/3, which over the run, T, adds up to tol
    landing     max(e, e_v) <= OF_A_LANDING tol     its place errs as its time does, by a first order of h

e_v is what the error of the velocities makes until the end of the run: |v_whole - v_halves|, and at most the jump of
the velocities times the way in the step over the reach, since a landing that ends in the next step would differ by its
jump. A landing takes its whole impulse at the beginning of the step, or of the half, that it is in, up to h/2 early
(``land_whole``): parts of it, one after the other, would be another impact wherever its friction turns. What rebounds
does so at the end of its half, up to h/2 late. So e is at least the jump of the velocity times that. What is taken back
of penetrations is no error: it is a share in each step, however short. Where e is larger, all is put back to the
beginning, and a shorter step is tried. What rests or falls freely has e = 0.
Steps are not divided at landings (divided.py): what follows a landing in the second half would be one part of the whole
and of the halves, and its error in both.
Source of the estimate: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I* (1993), II.4.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf, sqrt
from typing import Annotated as Array
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.contact.network.problem import Network
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.divided import Parts, add_parts, keep_part, land_whole
from nonsmooth.integrators.assembly.in_motion import ROOM
from nonsmooth.integrators.assembly.progress import DONE
from nonsmooth.integrators.assembly.project import LANDS, Moves
from nonsmooth.integrators.assembly.step import CARRIED, Assembly
from nonsmooth.integrators.halves import (
    CAUTION,
    FIRST_PART,
    MOST_GROWTH,
    MOST_SHRINKING,
    NO_STEP,
    OF_A_LANDING,
    SHORT_PART,
)
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, keep_rows, new, view
from nonsmooth.numerics.rounding import EPS

ROUNDINGS_OF_PLACES = 16  # chosen: of a place, that are no error
OFF_BY = 0.5  # derived: of a step, by which a landing is early at most, or a rebound late: each has its half
OF_HALVES = 3.0  # derived: the halves err by e over it: 2^2 - 1
WAY_IN_A_STEP = 0.5  # chosen: of the smallest reach, the way of the fastest body in a step, which finds what it meets
NO_SHORTER = -2  # code: the error asks for such a step


class Way(Block):
    """Where a step led."""

    lands: int  # whether a body landed in it
    rebounds: int  # whether one rebounded
    x: Array[Floats, "n_b", "n_x"]  # places of the bodies
    v: Array[Floats, "n_b", "n"]  # their velocities
    push: Array[Floats, "n_b", "n"]  # and by how much of the places penetrations were taken back


class Snapshot(NamedTuple):
    """All that the next step depends on."""

    words: dict[str, np.ndarray]  # of blocks
    placed: int  # times that the addresses of blocks were written before it


class Course(Block):
    """Where a run is, and its steps."""

    t: float  # the time that it has come to [s]
    target: float  # which no step goes past [s]
    h: float  # the step that is tried next [s]
    longest_h: float  # that was kept [s]
    shortest_h: float  # [s]
    rejected: int
    rtol: float
    atol: float  # [m]
    worst_residual: float
    worst_time: float  # when that was [s]
    is_together: int  # whether a body has been struck by several
    first_together: float  # when it first was [s]
    v: Array[Floats, "n_b", "n"]  # velocities at the beginning of the step [m/s]
    start: Array[Floats, "n_b", "d"]  # places of the centres at the start of the run [m]
    reach: Array[Floats, "n_b"]  # of a body [m]
    size: Array[Floats, "n_b"]  # of that and its farthest way from its start, the sum [m]


@kernel("void(int64, int64, int64, int64, float64)")
def keep_way(bodies_at, network_at, moves_at, way_at, h):
    """Keep where a part of a step led, h long: places and velocities, whether a body landed in it, and by how much of
    the places penetrations were taken back, a share of them in a step, however short it is."""
    motion, islands = view(bodies_at, Bodies).motion, view(network_at, Network).islands
    moves, way, is_pushed = view(moves_at, Moves), view(way_at, Way), False
    for k in range(islands.count):
        way.lands = 1 if moves.lands[k] == LANDS else way.lands
        is_pushed = is_pushed or moves.deep[k] == 1
    for b in range(motion.x.shape[0]):
        for a in range(motion.x.shape[1]):
            way.x[b, a] = motion.x[b, a]
        for a in range(motion.v.shape[1]):
            way.v[b, a] = motion.v[b, a]
            way.push[b, a] += moves.push[b, a] * h if is_pushed else 0.0


@kernel("float64(int64, int64, int64, int64, float64, float64, float64)")
def worst_error(bodies_at, course_at, whole_at, halves_at, h, left, falls):
    """e / tol of the worst body: how far the places are from one another, but for what is taken back of penetrations,
    or will be in a time ``left`` by the velocities after a landing. These differ where the landing takes the halves and
    not the whole, but no more than they change with its place. ``falls`` changes velocities without contacts [m/s^2].
    """
    bodies, course = view(bodies_at, Bodies), view(course_at, Course)
    whole, halves, d, worst = view(whole_at, Way), view(halves_at, Way), bodies.gravity.shape[0], 0.0
    lands = whole.lands == 1 or halves.lands == 1 or halves.rebounds == 1
    for b in range(course.reach.shape[0]):
        if bodies.motion.moves[b] == 0:
            continue
        reach, square, far = course.reach[b], 0.0, 0.0
        for a in range(d):
            square += (halves.x[b, a] - course.start[b, a]) ** 2
            far = max(far, abs(halves.x[b, a]))
        course.size[b] = max(course.size[b], reach + sqrt(square))
        e = apart(whole, halves, b, reach, d) - ROUNDINGS_OF_PLACES * EPS * (far + reach)
        jump = change_of(halves.v, course.v, 1.0, b, reach, d)
        if not (e < inf and jump < inf):
            return inf
        if left > 0.0:
            way = h * change_of(halves.v, course.v, 0.0, b, reach, d)
            e = max(e, left * min(change_of(halves.v, whole.v, 1.0, b, reach, d), jump * way / reach))
        if lands:
            e = max(e, OFF_BY * h * (jump - h * falls))
        worst = max(worst, e / (course.atol + course.rtol * course.size[b]))
    return worst


@kernel
def apart(whole, halves, b, reach, d):
    """How far the places of body b are from one another, or its reach times the angle [m]."""
    place, turn = 0.0, 0.0
    for a in range(d):
        place += (halves.x[b, a] - whole.x[b, a] - (halves.push[b, a] - whole.push[b, a])) ** 2
    for a in range(d, whole.v.shape[1]):
        turned = halves.x[b, a] - whole.x[b, a] if d == 2 else turn_between(whole.x, halves.x, b, a - d)
        turn += (turned - (halves.push[b, a] - whole.push[b, a])) ** 2
    return max(sqrt(place), reach * sqrt(turn))


@kernel
def turn_between(x, y, b, axis):
    """By which the unit quaternion of y is turned from that of x about an axis of the world [rad]."""
    k, m = 4 + (axis + 1) % 3, 4 + (axis + 2) % 3
    w = x[b, 3] * y[b, 3] + x[b, 4] * y[b, 4] + x[b, 5] * y[b, 5] + x[b, 6] * y[b, 6]
    turn = x[b, 3] * y[b, 4 + axis] - y[b, 3] * x[b, 4 + axis] - (y[b, k] * x[b, m] - y[b, m] * x[b, k])
    return 2.0 * turn if w >= 0.0 else -2.0 * turn


@kernel
def change_of(v, before, share, b, reach, d):
    """The size of v less a share of another velocity of body b, or of its reach times its turning rate [m/s]."""
    place, turn = 0.0, 0.0
    for a in range(d):
        place += (v[b, a] - share * before[b, a]) ** 2
    for a in range(d, v.shape[1]):
        turn += (v[b, a] - share * before[b, a]) ** 2
    return max(sqrt(place), reach * sqrt(turn))


class Controlled(Assembly):
    """A scene in motion, with error control.

    Parameters
    ----------
    rtol, atol : float
        Of the places of bodies: relative to their reach and their way, and absolute [m].
    t_0, t_1 : float
        Start and end of the run [s].
    *options
        Those of `Assembly`.
    """

    kept = (*CARRIED, "course")
    own_stages = (land_whole, keep_way, worst_error)
    placed = 0  # times that the addresses of blocks were written

    def __init__(self, rtol: float, atol: float, t_0: float, t_1: float, *options: Any) -> None:
        super().__init__(*options)
        self.progress.may_divide, self.progress.lands_whole = 0, 1
        motion, (n_b, n_x), n = self.bodies.motion, self.bodies.motion.x.shape, 3 * (self.dim - 1)
        self.span, self.end = t_1 - t_0, t_1
        self.moving = np.flatnonzero(motion.moves == 1)
        self.course: Course = new(Course, n_b=n_b, d=self.dim, n=n)
        self.course.t, self.course.h, self.course.shortest_h = t_0, FIRST_PART * self.span, inf
        self.course.rtol, self.course.atol = rtol, atol
        self.course.start[:] = motion.x[:, : self.dim]
        self.course.reach[:] = self.course.size[:] = self.reach_of(np.arange(n_b))
        self.whole, self.halves = (new(Way, n_b=n_b, n_x=n_x, n=n) for _ in range(2))
        self.before: Parts = new(Parts, m=0, d=self.dim)  # the first of two halves

    def take_controlled(self, prepare: Callable[[float, float], None]) -> int:
        """Take one step, as long as its error allows, to ``course.target`` at most; ``prepare`` (t, dt) what functions
        say of a step. Returns DONE, NO_SHORTER, or why no step could be taken."""
        course = self.course
        t, end = float(course.t), DONE
        while True:
            left = float(course.target) - t
            h = min(float(course.h), self._longest(), left)
            if h < NO_STEP * self.span and h < left:
                return NO_SHORTER if end == DONE else self._fail(t, h, prepare)
            h = left if h > CAUTION * left else min(h, 0.5 * left)  # no short step before a record
            begin, course.v[:] = self._snapshot(), self.bodies.motion.v
            try:
                end, error, order = self._try(t, h, begin, prepare)
            except BaseException:
                self._go_back(begin)
                raise
            change = min(MOST_GROWTH, max(MOST_SHRINKING, CAUTION * error ** (-1.0 / order))) if error else MOST_GROWTH
            if error <= 1.0:
                self._note(t, h, change, left)
                return DONE
            self._go_back(begin)
            course.h, course.rejected = change * h, course.rejected + 1

    def _fail(self, t: float, h: float, prepare: Callable[[float, float], None]) -> int:
        """Take a step that cannot be taken once more, so that its contacts are there to be named; why it cannot be."""
        begin = self._snapshot()
        end = self._take(t, h, 1, self.whole, prepare)
        if end != DONE:
            return end
        self._go_back(begin)
        return NO_SHORTER

    def _try(
        self, t: float, h: float, begin: Snapshot, prepare: Callable[[float, float], None]
    ) -> tuple[int, float, int]:
        """Take a step whole, and from a snapshot again as two halves; how that ended, and the error with its order."""
        end = self._take(t, h, 1, self.whole, prepare)
        self._go_back(begin)
        if end == DONE:
            end = self._take(t, h, 2, self.halves, prepare)
        if end != DONE:
            return end, inf, 1
        if self.whole.lands or self.halves.lands or self.halves.rebounds:
            return end, self._error(h, self.end - t - h) / OF_A_LANDING, 1
        return end, self._error(h, 0.0) / OF_HALVES / max(h / self.span, SHORT_PART), 2

    def _error(self, h: float, left: float) -> float:
        """e / tol of the worst body."""
        at = self.bodies.address, self.course.address, self.whole.address, self.halves.address
        return float(worst_error(*at, h, left, self._falls()))

    def _longest(self) -> float:
        """The step in which the fastest body goes WAY_IN_A_STEP of the smallest reach."""
        fastest = np.sqrt((self.bodies.motion.v[self.moving, : self.dim] ** 2).sum(axis=1).max(initial=0.0))
        way = WAY_IN_A_STEP * self.smallest
        most = float(fastest) + sqrt(self._falls() * way)
        return way / most if most > 0.0 else inf

    def _falls(self) -> float:
        """What changes velocities without contacts, at most [m/s^2]."""
        return self.gravity + float(self.bodies.strongest)

    def _take(self, t: float, h: float, parts: int, way: Way, prepare: Callable[[float, float], None]) -> int:
        """Take a step in so many equal parts; how that ended, and to ``way`` where it led."""
        before, pulls, impacts = None, list[np.ndarray](), int(self.progress.counts.impacts)
        way.lands, way.push[:] = 0, 0.0
        for part in range(parts):
            if part > 0:
                before, pulls = self._parts_so_far(), [column.copy() for column in self.reactions]
            begin = t + part * h / parts
            prepare(begin, h / parts)
            end = self.take_steps(h / parts, 1, begin)
            keep_way(self.bodies.address, self.network.address, self.moves.address, way.address, h / parts)
            if end != DONE:
                break
        if before is not None:
            self._add(before, pulls)
        way.rebounds = int(self.progress.counts.impacts) > impacts
        return end

    def _parts_so_far(self) -> Parts:
        """The impulses of the step before, which are those of a part now."""
        if len(self.before.key) < len(self.found.gap):
            self.before = new(Parts, m=len(self.found.gap), d=self.dim)
        self.before.n_c = 0
        keep_part(self.found.address, self.contacts.address, self.network.address, self.before.address)
        return self.before

    def _add(self, before: Parts, pulls: list[np.ndarray]) -> None:
        """Add the impulses of parts to those of the step, and those of the joints that are awake."""
        if self.joints.count > 0:
            still, joints = self.bodies.motion.still == 1, self.joints
            awake = ~(still[joints.body_i] & still[joints.body_j])
            for column, pull in zip(self.reactions, pulls, strict=True):
                column[awake] += pull[awake]
        if before.n_c > 0:
            self._make_room_for_parts(int(before.n_c))
            add_parts(self.parts.address, before.address)

    def _make_room_for_parts(self, more: int) -> None:
        """Have room for so many more."""
        room = int(self.parts.n_c) + more
        if room > len(self.parts.key):
            parts, self.parts = self.parts, new(Parts, m=int(ROOM * room), d=self.dim)
            keep_rows(parts, self.parts)
            self.go_on()

    def _note(self, t: float, h: float, change: float, left: float) -> None:
        """Note a step that was kept."""
        course, progress = self.course, self.progress
        progress.counts.steps -= 1  # two halves are one step
        if progress.figures.residual > course.worst_residual:
            course.worst_residual, course.worst_time = progress.figures.residual, t
        if progress.counts.together and not course.is_together:
            course.is_together, course.first_together = 1, t
        course.t = float(course.target) if h == left else t + h
        course.h = max(float(course.h), change * h) if h == left else change * h
        course.longest_h, course.shortest_h = max(float(course.longest_h), h), min(float(course.shortest_h), h)

    @property
    def sizes(self) -> np.ndarray:
        """Of the blocks: those of `Assembly`, and the contacts of parts that there is room for."""
        return np.append(super().sizes, len(self.parts.key))

    def restore(self, sizes: np.ndarray) -> None:
        """Blocks of such sizes, into which what was carried may be copied; ``go_on`` afterwards."""
        super().restore(sizes[:-1])
        self.parts = new(Parts, m=int(sizes[-1]), d=self.dim)

    def go_on(self) -> None:
        """Let the steps find the blocks of this process."""
        super().go_on()
        self.placed += 1

    def _snapshot(self) -> Snapshot:
        """All that the next step depends on."""
        return Snapshot({name: getattr(self, name).words.copy() for name in CARRIED}, self.placed)

    def _go_back(self, begin: Snapshot) -> None:
        """Be as at a snapshot, with the room that there is now."""
        self.verdicts = []
        if begin.placed == self.placed:  # all blocks stand where they stood
            for name, words in begin.words.items():
                getattr(self, name).words[:] = words
            return
        for name, words in begin.words.items():
            block = getattr(self, name)
            if len(words) == len(block.words):
                block.restore(words.view(np.int64))
            else:
                keep_rows(type(block)(words), block)
        self.solver.direct.desk.graph.end = self.fill
        self.go_on()  # addresses are those of now
