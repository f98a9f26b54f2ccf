"""A run of a scene: interval after interval between two records.

`simulate` begins it in simulate_scene.py; what is said of its figures in the end is in scene_warnings.py.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from itertools import islice, takewhile
from typing import Any

import numpy as np

from nonsmooth.contact.network.parallel import Desks
from nonsmooth.contact.planar.selection import Selection
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.assembly.apart import part_bodies
from nonsmooth.integrators.assembly.progress import DONE, LOST, NO_FRICTION, RECORD, TOO_MANY, UNSOLVED
from nonsmooth.integrators.assembly.step import Assembly
from nonsmooth.integrators.assembly.struck import MOST_STRUCK
from nonsmooth.integrators.assembly.world import World
from nonsmooth.integrators.moreau_jean.contact_solver import ContactSolver
from nonsmooth.jit.blocks import named_numbers
from nonsmooth.mechanics.laws import ImpactLaw
from nonsmooth.results.ledger import WORKS
from nonsmooth.results.recorded import EVENTS, PAIRS
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.results.stats import SceneStats
from nonsmooth.results.summary import worst_place
from nonsmooth.runs.applied_forces import AppliedForces
from nonsmooth.runs.pair_events import PairEvents
from nonsmooth.runs.recorder import SceneRecorder
from nonsmooth.runs.refused_scenes import require_taken
from nonsmooth.runs.run import Run
from nonsmooth.runs.scene_user_events import SceneWatch
from nonsmooth.runs.times import RecordTimes, grid_times
from nonsmooth.runs.user_events import Stop
from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.scene import Scene
from nonsmooth.signals.interruption import interrupts_held_back

SOFT = "the springs are soft for this motion, or what is thin passed through; a larger stiffness ends this"
TIMES_AT_ONCE = 512  # chosen: record times that are held
ENDS = {LOST: Status.NOT_FINITE, UNSOLVED: Status.NOT_SOLVED}
# name: field of the counts
METHODS = {"kept": "kept", "sweeps": "swept", "augmented Lagrangian": "direct", "interior points": "inside"}
Interval = tuple[float, float, int, float]  # start [s], step [s], number of steps, end [s]


class SceneRun(Run):
    """One run with steps of a given length; with compliant contacts: `SpringRun`.

    Parameters
    ----------
    scene : Scene
    t_span : (float, float)
        [s]
    integrator : MoreauJean, or Penalty of `SpringRun`
    every, t_eval, project
        As of `simulate`.
    functions : sequence of callables
        Events of the user.
    threads : int
    selection : Selection

    Raises
    ------
    InvalidInput
        For what its method does not take (refused_scenes.py), and a scene that cannot begin.
    """

    table: RecordTimes
    recorder: SceneRecorder
    works: tuple[str, ...] = WORKS  # columns of the ledger, beside the energies of the bodies
    is_counted = True  # whether its records are those of the table
    may_write = True  # whether its steps can write records by themselves
    has_islands = True  # whether contact problems are solved, island by island
    ends = ENDS  # the status of each way in which steps come back but one
    intervals: Iterator[Interval] | None = None  # those between records that are left, once the run has begun
    at_hand: Interval | None = None  # the present one
    what_is_deep = "what is thin and fast may have passed through what it met; a smaller dt ends this"

    def __init__(
        self, scene: Scene, t_span: tuple[float, float], integrator: Any, every: int, t_eval: Any,
        recorder: SceneRecorder | None = None, project: bool = False, functions: Sequence[Callable] = (),
        threads: int = 1, selection: Selection = Selection.COMPLIANT_LIMIT,
    ) -> None:  # fmt: skip
        self.scene, self.integrator, self.threads, self.selection = scene, integrator, threads, selection
        self.table = self._times(t_span, every, t_eval)
        self.recorder = SceneRecorder() if recorder is None else recorder
        started = time.perf_counter()
        self.world = World(scene, self.table.span[0])
        require_taken(self, project, functions, threads)
        self.recorder.require_room(self)
        if project:
            part_bodies(self.world)
        motors = [motor for joint in scene.joints for motor in joint.motors]
        self.forces = AppliedForces(self.world) if scene.forces or motors else None
        self.assembly = self._assemble()
        self.compile_time = time.perf_counter() - started
        self.n_touching = self.assembly.find_contacts()
        self.world.require_found(self.n_touching)
        self.world.require_apart(self.n_touching, self.assembly.found)
        self.names = [body.name for body in scene.bodies]
        self.pair_events = PairEvents(self) if EVENTS in self.recorder.kinds else None
        self.watch = SceneWatch(self, functions) if functions else None
        self.watches = [watch for watch in (self.pair_events, self.watch) if watch is not None]
        stands_between = self.watches or self.asks_before_steps or PAIRS in self.recorder.kinds
        self.writes_records = self.may_write and not stands_between
        self.ahead = deque[Interval]()  # behind the present one, as far as they have been looked at
        self.centres = self.world.frames[:, : scene.dim]
        self.began, self.dt = self.table.span[0], 0.0  # of the interval between two records
        self.interval, self.steps_before, self.has_record = 0, 0, False
        if self.has_islands and any(body.kind is Kind.KINEMATIC for body in scene.bodies):
            self.world.go_along(self.assembly.find_contacts(float(self.assembly.doubts.near)), self.assembly.found)
        self.recorder.begin(self)

    def _times(self, t_span: tuple[float, float], every: int, t_eval: Any) -> RecordTimes:
        """The record times."""
        return grid_times(self.integrator, t_span, every, t_eval)

    def _assemble(self) -> Any:
        """The scene in motion: its steps, contacts, works and figures."""
        world, compliance = self.world, self.integrator.compliance
        if compliance is not None:
            world.surfaces.is_compliant, world.surfaces.e[:] = 1, 0.0
            world.surfaces.stiffness, world.surfaces.damping = compliance.stiffness, compliance.damping
            self.what_is_deep = SOFT
        assembly = Assembly(*self._given(self.contacts, self.integrator.theta))
        assembly.desks = Desks(self.threads)
        if compliance is not None:
            assembly.progress.tight = math.inf  # what springs give way to is not taken back
        return assembly

    def _given(self, options: ContactSolver, theta: float) -> tuple[Any, ...]:
        """What an `Assembly` is made of."""
        world = self.world
        return (
            world.bodies, world.shapes, world.surfaces, world.joints, world.springs, world.drives, options.tol,
            options.sweeps, options.interior, options.on_residual == "raise",
            options.may_sleep and not (self.forces is not None and self.forces.are_applied), theta,
            PAIRS in self.recorder.kinds, self.selection,
        )  # fmt: skip

    @property
    def contacts(self) -> ContactSolver:
        """How contact problems are solved."""
        return self.integrator.contacts  # type: ignore[no-any-return]

    def take(self, most: int) -> Status:
        """Take at most so many steps, with the records that fall due; the last of them ends the run."""
        end = self.steps + most
        if self.intervals is None:
            self._begin()
        while self.status == Status.RUNNING and self.at_hand is not None:
            _, _, count, t_next = self.at_hand
            if (left := self.left(count, t_next)) > 0 and self.steps < end:
                if self.writes_records:
                    self._take_recorded(end)
                else:
                    self.take_steps(min(left, end - self.steps))
            elif left > 0:
                break
            else:
                self._end_interval(t_next)
        if self.status == Status.RUNNING and self.at_hand is None:
            return Status.FINISHED
        self.recorder.look(self)
        return self.status

    def _begin(self) -> None:
        """Write the record of the start, and begin the first interval."""
        if not self.has_record:
            self.write_record()
        if self.watch is not None:
            self.watch.look(self, self.now, self.now)
        self.intervals = self._intervals()
        self._next_interval()

    def _next_interval(self) -> None:
        """Go to the next interval, where there is one."""
        assert self.intervals is not None
        self.at_hand = self.ahead.popleft() if self.ahead else next(self.intervals, None)
        if self.at_hand is not None:
            self.began, self.dt, _, _ = self.at_hand

    def _end_interval(self, t: float) -> None:
        """Write the record at the end of an interval, a time t [s], and go to the next."""
        self.go_on_from(self.interval + 1, self.steps, False)
        self.began, self.dt = t, 0.0
        self.write_record()
        self._next_interval()

    def settle(self) -> None:
        """Put the state of a run that ended within its span where it can be read."""
        if self.status != Status.FINISHED:
            self.assembly.end_step()

    def _intervals(self) -> Iterator[Interval]:
        """Start, step, number of steps and end of the intervals between records, from the present one on."""
        k = self.interval
        while k < self.table.count - 1:
            t = self.table.part(k, min(k + TIMES_AT_ONCE, self.table.count))
            dts, counts = self.integrator.steps_between(t)
            yield from zip(t[:-1].tolist(), dts.tolist(), counts.tolist(), t[1:].tolist(), strict=True)
            k += len(t) - 1

    def left(self, count: int, t_next: float) -> int:
        """Steps to the next record: of ``count``, those that were not taken yet."""
        return count - (self.steps - self.steps_before)

    @property
    def place(self) -> tuple[int, int, bool]:
        """Where the run is: the interval, the steps before it, whether its first record was written."""
        return self.interval, self.steps_before, self.has_record

    def go_on_from(self, interval: int, steps_before: int, has_record: int) -> None:
        """Be at that place."""
        self.interval, self.steps_before, self.has_record = interval, steps_before, bool(has_record)
        self.began = float(self.table.part(interval, interval + 1)[0])

    @property
    def is_at_record(self) -> bool:
        """Whether the state is that of the last record."""
        return self.has_record and self.steps == self.steps_before

    def write_record(self) -> None:
        """Write the state as the next record."""
        self.recorder.write(self, self.now)
        figures = self.assembly.progress.figures
        figures.since_residual = figures.since_penetration = 0.0
        if PAIRS in self.recorder.kinds:
            self.assembly.begin_pairs()
        self.has_record = True

    @property
    def steps(self) -> int:
        """Taken so far."""
        return int(self.assembly.progress.counts.steps)

    @property
    def now(self) -> float:
        """The time that the run has come to, by the steps that were taken [s]."""
        return self.began + (self.steps - self.steps_before) * self.dt

    @property
    def asks_before_steps(self) -> bool:
        """Whether a function of the user says something of each step."""
        return bool(self.world.guided) or (self.forces is not None and self.forces.is_asked)

    def _ask_functions(self) -> bool:
        """``ask_functions`` for the step at hand; False where that ends the run."""
        try:
            self.ask_functions(self.now, self.dt)
        except InvalidInput as refusal:
            self._end_without_answer(refusal)
            return False
        return True

    def ask_functions(self, t: float, dt: float) -> None:
        """Ask functions where guided bodies go in a step from t [s], and for its forces; raises `InvalidInput` where
        one says nothing that can be used."""
        self.world.guide(t, dt)
        if self.forces is not None:
            self.forces.update(t, dt)

    def _end_without_answer(self, refusal: InvalidInput) -> None:
        """End the run where a function says nothing that can be used."""
        sentence = f"{refusal}; stopped at {self.where()}"
        self.end_at(Stop(self.now, Status.NOT_FINITE, sentence, cause=refusal))

    def take_steps(self, most: int) -> None:
        """Take some steps, at most so many, without a look at the clock."""
        if self.asks_before_steps and not self._ask_functions():
            return
        if self.asks_before_steps:
            most = 1
        for watch in self.watches:
            most = watch.steps_at_once(self, most)
        t = self.now
        with interrupts_held_back():  # a step is whole, or it is not begun
            end = self.assembly.take_steps(self.dt, most, t)
        self._look_at_end(end, t)

    def _take_recorded(self, end: int) -> None:
        """Take steps until there are so many, those of equal intervals at once, with the records that fall due."""
        window = self.recorder.window
        if window.is_full:
            self.recorder.empty(self)
        if self.status != Status.RUNNING:
            return  # the memory is used up
        alike = self._alike(end, window.size - window.count)
        t, (_, dt, stride, _) = self.now, alike[0]
        until = min(end, self.steps_before + stride * len(alike))
        with interrupts_held_back():
            written = window.let_write([t_next for *_, t_next in alike], self.steps_before + stride, stride)
            try:
                code = self.assembly.take_steps(dt, until - self.steps, t, written)
            finally:
                self._pass(alike[: window.take_written()])
        self._look_at_end(DONE if code == RECORD else code, t)

    def _pass(self, intervals: list[Interval]) -> None:
        """Go on behind intervals whose steps were taken, and whose records were written."""
        for _, _, count, t in intervals:
            self.interval, self.steps_before, self.has_record = self.interval + 1, self.steps_before + count, True
            self.began, self.dt = t, 0.0
            self._next_interval()

    def _alike(self, end: int, most: int) -> list[Interval]:
        """The present interval and those behind it that are as it is, up to a number of steps, at most so many."""
        assert self.at_hand is not None and self.intervals is not None
        alike, steps = [self.at_hand], self.at_hand[2]
        needed = min(most, -(-(end - self.steps_before) // steps))
        self.ahead.extend(islice(self.intervals, max(0, needed - 1 - len(self.ahead))))
        alike += islice(self.ahead, max(0, needed - 1))
        return list(takewhile(lambda interval: interval[1:3] == alike[0][1:3], alike))

    def _look_at_end(self, end: int, t: float) -> None:
        """Go on after steps from a time t [s], or end the run as they came back."""
        if end == NO_FRICTION:
            self._end_without_friction()
        elif end == TOO_MANY:
            self._end_of_large_impact()
        elif end != DONE:
            self.status = self.ends[end]
        else:
            for watch in self.watches:
                watch.look(self, t, self.now)

    def _end_without_friction(self) -> None:
        """End the run where a law of friction gives no coefficient."""
        found, body, c = self.assembly.found, self.assembly.shapes.body, int(self.assembly.progress.wanted)
        first, second = (self.names[int(body[shape[c]])] for shape in (found.shape_i, found.shape_j))
        sentence = f"the friction law of {first} and {second} is negative, or no number, at their sliding speed"
        self._end_without_answer(InvalidInput(sentence))

    def _end_of_large_impact(self) -> None:
        """End the run where a law of impact is that of more contacts than it is done for."""
        body = self.names[int(self.assembly.network.j[int(self.assembly.progress.wanted)])]
        law = ImpactLaw(self.world.surfaces.impact).name.lower()
        sentence = (
            f"impact = {law!r} is for islands of up to {MOST_STRUCK} closed contacts, and {body}, which is about to "
            "rebound, is of a larger one; impact='newton' has no such limit"
        )
        self._end_without_answer(InvalidInput(sentence))

    def paradox_rows(self) -> np.ndarray:
        """Where rigid contact left open what happens, as a solution has it."""
        paradoxes = self.assembly.paradoxes
        return paradoxes.rows[: int(paradoxes.count)].copy()

    def watched(self) -> dict[str, np.ndarray]:
        """Events, times of those of the user and paradoxes, as a solution has them."""
        columns = {"paradox_rows": self.paradox_rows()}
        columns |= {} if self.pair_events is None else self.pair_events.columns()
        times = [] if self.watch is None else self.watch.t_events
        return columns | {f"t_events/{k}": found for k, found in enumerate(times)}

    def stats(self) -> SceneStats:
        """What the run cost."""
        assembly = self.assembly
        counts, figures = (named_numbers(block) for block in (assembly.progress.counts, assembly.progress.figures))
        methods = {name: counts[field] for name, field in METHODS.items() if counts[field]}
        return SceneStats(
            counts["steps"], assembly.n_contacts, max(0, counts["most_contacts"] - assembly.n_others),
            assembly.n_islands,
            methods, counts["sweeps"], counts["factors"], counts["impacts"], counts["asleep"], assembly.tol,
            figures["residual"], figures["last_residual"], counts["missed"], figures["penetration"],
            figures["last_penetration"], self.wall_time, self.compile_time,
            counts["gains"], figures["gain"], islands_asleep=counts["left_islands"],
            struck_together=counts["together"], first_together=self._first_together(),
            rebounds_limited=counts["limited"],
            worst_joint_drift=figures["drift"], last_joint_drift=figures["last_drift"],
            inconsistent=int(assembly.paradoxes.inconsistent), indeterminate_steps=int(assembly.paradoxes.several),
            **self._worst(),
        )  # fmt: skip

    def _worst(self) -> dict[str, Any]:
        """The contact at which the residual was the worst, as the stats have it."""
        progress, names = self.assembly.progress, self.scene.bodies
        if progress.figures.residual == 0.0:
            return {}
        worst = progress.worst
        pair = f"{names[int(worst.i)].name}, {names[int(worst.j)].name}"
        return {"worst_contact": int(worst.row), "worst_pair": pair, "worst_time": self._time_of_step(int(worst.step))}

    def _time_of_step(self, k: int) -> float:
        """When step k began [s]."""
        return float(self.table.span[0] + k * self.integrator.dt)

    def _first_together(self) -> str:
        """When a body was first struck by several others together, and which; nothing where none was."""
        counts = self.assembly.progress.counts
        if not counts.together:
            return ""
        t = self._time_of_step(int(counts.first_together))
        return f"at t = {t:.4g} s {self.world.scene.bodies[int(counts.struck)].name}"

    def reason(self) -> str:
        """A sentence on an end that is none of those that all runs have."""
        if self.status == Status.NOT_FINITE:
            return f"{self.world.lost()} is nowhere: its place is not finite, or too far out; stopped at {self.where()}"
        stats = self.stats()
        return (
            f"the contact problem of this step was solved to a residual of {stats.last_residual:.2g}"
            f"{worst_place(stats)}, and "
            f"tol = {self.assembly.tol:g} was asked for; stopped at {self.where()}"
        )

    def about(self) -> dict[str, Any]:
        """What was run."""
        return {
            **self.scene.parameter_values,
            "scene": repr(self.scene),
            "integrator": repr(self.integrator),
            "contacts": repr(self.contacts),
        }

    def solution(self) -> SceneSolution:
        """What was computed."""
        return self.recorder.solution(self)

    def failed_problem(self, message: str) -> Any:
        """The contact problem of the island that was not solved, where there is one."""
        from nonsmooth.results.failed_problem import SceneProblem

        unsolved = self.assembly.unsolved if self.status == Status.NOT_SOLVED else None
        return None if unsolved is None else SceneProblem(unsolved, message)
