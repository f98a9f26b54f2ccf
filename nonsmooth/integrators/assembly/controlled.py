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

from nonsmooth.integrators.assembly.divided import Parts, add_parts, keep_part, land_whole
from nonsmooth.integrators.assembly.in_motion import ROOM
from nonsmooth.integrators.assembly.progress import DONE
from nonsmooth.integrators.assembly.project import LANDS
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
from nonsmooth.jit.blocks import Block, Floats, keep_rows, new
from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.places import conjugate, times

ROUNDINGS_OF_PLACES = 16  # chosen: of a place, that are no error
OFF_BY = 0.5  # derived: of a step, by which a landing is early at most, or a rebound late: each has its half
OF_HALVES = 3.0  # derived: the halves err by e over it: 2^2 - 1
WAY_IN_A_STEP = 0.5  # chosen: of the smallest reach, the way of the fastest body in a step, which finds what it meets
NO_SHORTER = -2  # code: the error asks for such a step


class Way(NamedTuple):
    """Where a step led."""

    lands: bool  # whether a body landed in it
    rebounds: bool  # whether one rebounded
    x: np.ndarray  # (n, n_x) places of the bodies that move
    v: np.ndarray  # (n, 3|6) their velocities
    push: np.ndarray  # and by how much of the places penetrations were taken back


Snapshot = dict[str, np.ndarray]  # the words of blocks


class Course(Block):
    """Where a run is, and its steps."""

    t: float  # the time that it has come to [s]
    target: float  # which no step goes past [s]
    h: float  # the step that is tried next [s]
    longest_h: float  # that was kept [s]
    shortest_h: float  # [s]
    rejected: int
    worst_residual: float
    worst_time: float  # when that was [s]
    is_together: int  # whether a body has been struck by several
    first_together: float  # when it first was [s]
    v: Array[Floats, "n_b", "n"]  # velocities at the beginning of the step [m/s]
    start: Array[Floats, "n_b", "d"]  # places of the centres at the start of the run [m]
    size: Array[Floats, "n_b"]  # of the reach of a body and its farthest way from there, the sum [m]


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
    own_stages = (land_whole,)

    def __init__(self, rtol: float, atol: float, t_0: float, t_1: float, *options: Any) -> None:
        super().__init__(*options)
        self.progress.may_divide, self.progress.lands_whole = 0, 1
        motion, n_b = self.bodies.motion, len(self.bodies.mass)
        self.rtol, self.atol, self.span, self.end = rtol, atol, t_1 - t_0, t_1
        self.moving = np.flatnonzero(motion.moves == 1)
        self.course: Course = new(Course, n_b=n_b, d=self.dim, n=3 * (self.dim - 1))
        self.course.t, self.course.h, self.course.shortest_h = t_0, FIRST_PART * self.span, inf
        self.course.start[:] = motion.x[:, : self.dim]
        self.course.size[:] = self.reach_of(np.arange(n_b))
        self.reach = self.course.size[self.moving].copy()

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
        end, _ = self._take(t, h, 1, prepare)
        if end != DONE:
            return end
        self._go_back(begin)
        return NO_SHORTER

    def _try(
        self, t: float, h: float, begin: Snapshot, prepare: Callable[[float, float], None]
    ) -> tuple[int, float, int]:
        """Take a step whole, and from a snapshot again as two halves; how that ended, and the error with its order."""
        end, whole = self._take(t, h, 1, prepare)
        self._go_back(begin)
        if end == DONE:
            end, halves = self._take(t, h, 2, prepare)
        if end != DONE:
            return end, inf, 1
        if whole.lands or halves.lands or halves.rebounds:
            return end, self._difference(whole, halves, h, self.end - t - h) / OF_A_LANDING, 1
        return end, self._difference(whole, halves, h, 0.0) / OF_HALVES / max(h / self.span, SHORT_PART), 2

    @property
    def lands(self) -> bool:
        """Whether a body landed in the step before."""
        found = self.moves.lands[: int(self.network.islands.count)]
        return bool((found == LANDS).any())

    def _longest(self) -> float:
        """The step in which the fastest body goes WAY_IN_A_STEP of the smallest reach."""
        fastest = np.sqrt((self.bodies.motion.v[self.moving, : self.dim] ** 2).sum(axis=1).max(initial=0.0))
        way = WAY_IN_A_STEP * self.smallest
        most = float(fastest) + sqrt(self._falls() * way)
        return way / most if most > 0.0 else inf

    def _falls(self) -> float:
        """What changes velocities without contacts, at most [m/s^2]."""
        return self.gravity + float(self.bodies.strongest)

    def _take(self, t: float, h: float, parts: int, prepare: Callable[[float, float], None]) -> tuple[int, Way]:
        """Take a step in so many equal parts; how that ended, and where it led."""
        end, lands, before, push = (
            DONE,
            False,
            new(Parts, m=0, d=self.dim),
            np.zeros((len(self.moving), 3 * (self.dim - 1))),
        )
        pulls, impacts = [np.zeros_like(column) for column in self.reactions], int(self.progress.counts.impacts)
        for part in range(parts):
            if part > 0:
                before, pulls = self._parts_so_far(), [column.copy() for column in self.reactions]
            begin = t + part * h / parts
            prepare(begin, h / parts)
            end = self.take_steps(h / parts, 1, begin)
            lands, push = lands or self.lands, push + self._push() * h / parts
            if end != DONE:
                break
        self._add(before, pulls)
        motion = self.bodies.motion
        rebounds = int(self.progress.counts.impacts) > impacts
        return end, Way(lands, rebounds, motion.x[self.moving].copy(), motion.v[self.moving].copy(), push)

    def _push(self) -> np.ndarray:
        """By which penetrations were taken back: a share of them in a step, however short it is."""
        is_pushed = (self.moves.deep[: int(self.network.islands.count)] == 1).any()
        return self.moves.push[self.moving] * is_pushed

    def _parts_so_far(self) -> Parts:
        """The impulses of the step before, which are those of a part now."""
        self._make_room_for_parts(len(self.found.gap))
        keep_part(self.found.address, self.contacts.address, self.network.address, self.parts.address)
        parts = new(Parts, m=len(self.parts.key), d=self.dim)
        keep_rows(self.parts, parts)
        return parts

    def _add(self, before: Parts, pulls: list[np.ndarray]) -> None:
        """Add the impulses of parts to those of the step, and those of the joints that are awake."""
        still, joints = self.bodies.motion.still == 1, self.joints
        awake = ~(still[joints.body_i] & still[joints.body_j])
        for column, pull in zip(self.reactions, pulls, strict=True):
            column[awake] += pull[awake]
        if before.n_c == 0:
            return
        self._make_room_for_parts(int(before.n_c))
        add_parts(self.parts.address, before.address)

    def _make_room_for_parts(self, more: int) -> None:
        """Have room for so many more."""
        room = int(self.parts.n_c) + more
        if room > len(self.parts.key):
            parts, self.parts = self.parts, new(Parts, m=int(ROOM * room), d=self.dim)
            keep_rows(parts, self.parts)
            self.go_on()

    def _difference(self, whole: Way, halves: Way, h: float, left: float) -> float:
        """e / tol of the worst body: how far the places are from one another, but for what is taken back of
        penetrations, or will be in a time by the velocities after a landing. These differ where the landing takes the
        halves and not the whole, but no more than they change with its place."""
        d, x, size = self.dim, halves.x, self.course.size
        size[self.moving] = np.maximum(size[self.moving], self.reach + norms(x[:, :d] - self.course.start[self.moving]))
        turned = x[:, d:] - whole.x[:, d:] if d == 2 else turns_between(whole.x[:, d:], x[:, d:])
        apart = np.hstack((x[:, :d] - whole.x[:, :d], turned)) - (halves.push - whole.push)
        e = self._sizes_of(apart) - ROUNDINGS_OF_PLACES * EPS * (np.abs(x[:, :d]).max(axis=1) + self.reach)
        if left > 0.0:
            way, jump = h * self._sizes_of(halves.v), self._sizes_of(halves.v - self.course.v[self.moving])
            dv = np.minimum(self._sizes_of(halves.v - whole.v), jump * way / self.reach)
            e = np.maximum(e, left * dv)
        if whole.lands or halves.lands or halves.rebounds:
            struck = self._sizes_of(halves.v - self.course.v[self.moving]) - h * self._falls()
            e = np.maximum(e, OFF_BY * h * struck)
        tol = self.atol + self.rtol * size[self.moving]
        return float((e / tol).max(initial=0.0))

    def _sizes_of(self, change: np.ndarray) -> np.ndarray:
        """Of changes (n, 3|6) of bodies: of place, or of reach times angle [m]."""
        return np.maximum(norms(change[:, : self.dim]), self.reach * norms(change[:, self.dim :]))  # type: ignore[no-any-return]

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

    def _snapshot(self) -> Snapshot:
        """All that the next step depends on."""
        return {name: getattr(self, name).words.copy() for name in CARRIED}

    def _go_back(self, begin: Snapshot) -> None:
        """Be as at a snapshot, with the room that there is now."""
        for name, words in begin.items():
            block = getattr(self, name)
            if len(words) == len(block.words):
                block.restore(words.view(np.int64))
            else:
                keep_rows(type(block)(words), block)
        self.solver.direct.desk.graph.end = self.fill
        self.verdicts = []
        self.go_on()  # addresses are those of now


def norms(a: np.ndarray) -> np.ndarray:
    """Of rows."""
    return np.sqrt((a * a).sum(axis=1))  # type: ignore[no-any-return]


def turns_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """By which unit quaternions (n, 4) are turned from others (n, 3) [rad]; in the axes of the world."""
    turn = times(b, conjugate(a))
    return 2.0 * np.copysign(1.0, turn[:, :1]) * turn[:, 1:]  # type: ignore[no-any-return]
