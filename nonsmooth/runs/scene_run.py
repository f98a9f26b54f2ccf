"""One run of a scene: step after step, until the end, a failure, Ctrl-C or the end of the budget.

`simulate` begins it in simulate_scene.py; what is said of its figures in the end is in scene_warnings.py.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from typing import Any

import numpy as np

from nonsmooth.contact.network.parallel import Desks
from nonsmooth.contact.planar.selection import Selection
from nonsmooth.errors import InvalidInput, Status, said_by
from nonsmooth.integrators.assembly.apart import part_bodies
from nonsmooth.integrators.assembly.progress import DONE, LOST, NO_FRICTION, TOO_MANY, UNSOLVED
from nonsmooth.integrators.assembly.step import Assembly
from nonsmooth.integrators.assembly.struck import MOST_STRUCK
from nonsmooth.integrators.assembly.world import World
from nonsmooth.integrators.moreau_jean.contact_solver import ContactSolver
from nonsmooth.jit import running_time, waited
from nonsmooth.jit.blocks import named_numbers
from nonsmooth.mechanics.laws import ImpactLaw
from nonsmooth.results.failures import BudgetSpent, EventFunctionError, ModelFunctionError, ProgressError, StepFailure
from nonsmooth.results.ledger import WORKS
from nonsmooth.results.recorded import EVENTS, PAIRS
from nonsmooth.results.scene_solution import SceneSolution
from nonsmooth.results.stats import SceneStats
from nonsmooth.results.summary import worst_place
from nonsmooth.runs.applied_forces import AppliedForces
from nonsmooth.runs.pair_events import PairEvents
from nonsmooth.runs.recorder import SceneRecorder
from nonsmooth.runs.refused_scenes import require_taken
from nonsmooth.runs.run import LOOK_EVERY, Run, next_block
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
FAILURES: dict[Status, type[StepFailure]] = {
    Status.BUDGET_SPENT: BudgetSpent,
    Status.NOT_FINITE: ModelFunctionError,
    Status.PROGRESS_FAILED: ProgressError,
    Status.EVENT_FAILED: EventFunctionError,
}


class SceneRun:
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

    works: tuple[str, ...] = WORKS  # columns of the ledger, beside the energies of the bodies
    is_counted = True  # whether its records are those of the table
    has_islands = True  # whether contact problems are solved, island by island
    ends = ENDS  # the status of each way in which steps come back but one
    _block = 1  # steps before the next look at the clock
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
        self.centres = self.world.frames[:, : scene.dim]
        self.status = Status.RUNNING
        self.began, self.dt = self.table.span[0], 0.0  # of the interval between two records
        self.interval, self.steps_before, self.has_record = 0, 0, False
        self.wall_time = 0.0
        self.cause: BaseException | None = None
        self.spent = ""
        if self.has_islands and any(body.kind is Kind.KINEMATIC for body in scene.bodies):
            self.world.go_along(self.assembly.find_contacts(float(self.assembly.doubts.near)), self.assembly.found)

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

    def advance(
        self, max_wall_time: float | None, progress: Callable[[float], None] | None, max_steps: int | None = None
    ) -> None:
        """Run until the end or a reason to stop."""
        self.recorder.begin(self)
        with closing(self.recorder):
            if self.status == Status.RUNNING:
                self._run_intervals(max_wall_time, progress, max_steps)
                self.recorder.end(self)

    def _run_intervals(
        self, max_wall_time: float | None, progress: Callable[[float], None] | None, max_steps: int | None
    ) -> None:
        self.started, waited_before = running_time(), waited()
        started = self.started
        deadline = math.inf if max_wall_time is None else started + max_wall_time
        budget = sys.maxsize if max_steps is None else max_steps
        self._looked, self._block = started, 1
        try:
            if not self.has_record:
                self.write_record()
            if self.watch is not None:
                self.watch.look(self, self.now, self.now)
            for t, dt, count, t_next in self._intervals() if self.status == Status.RUNNING else ():
                self.began, self.dt = t, dt
                while (left := self.left(count, t_next)) > 0:
                    self._look(deadline, progress, max_wall_time)
                    if self.status == Status.RUNNING and self.steps >= budget:
                        self.stop(f"max_steps = {max_steps}")
                    if self.status != Status.RUNNING:
                        return
                    self.take_steps(min(left, budget - self.steps))
                    if self.status != Status.RUNNING:
                        return
                self.go_on_from(self.interval + 1, self.steps, False)
                self.began, self.dt = t_next, 0.0
                self.write_record()
            if self.status == Status.RUNNING:
                self.status = Status.FINISHED
                if progress is not None:
                    self._show(progress)
        except KeyboardInterrupt:
            Run.interrupted += 1
            self.status = Status.INTERRUPTED
        finally:
            if self.status not in (Status.FINISHED, Status.RUNNING):
                self.assembly.end_step()
            self.wall_time = running_time() - started
            self.compile_time += waited() - waited_before

    def _intervals(self) -> Iterator[tuple[float, float, int, float]]:
        """Start, step, number of steps and end of the intervals between records, from the present one on."""
        while self.interval < self.table.count - 1:
            t = self.table.part(self.interval, min(self.interval + TIMES_AT_ONCE, self.table.count))
            dts, counts = self.integrator.steps_between(t)
            yield from zip(t[:-1].tolist(), dts.tolist(), counts.tolist(), t[1:].tolist(), strict=True)

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

    def _look(self, deadline: float, progress: Callable[[float], None] | None, max_wall_time: float | None) -> None:
        """Look at the clock, now and then, and show how far the run is."""
        now = running_time()
        if now - self._looked < LOOK_EVERY:
            return
        self._looked, self.wall_time = now, now - self.started
        self.recorder.look(self)
        if now > deadline:
            self.stop(f"max_wall_time = {max_wall_time:g} s")
        if progress is not None:
            self._show(progress)

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
        self.status, self.cause = Status.NOT_FINITE, refusal
        self.spent = f"{refusal}; stopped at t = {self.now:.9g} s"

    def take_steps(self, most: int) -> None:
        """Some steps, as many as end before the next look at the clock."""
        before, began = self.steps, running_time()
        if self.asks_before_steps and not self._ask_functions():
            return
        if self.asks_before_steps:
            most = 1
        for watch in self.watches:
            most = watch.steps_at_once(self, most)
        t = self.now
        with interrupts_held_back():  # a step is whole, or it is not begun
            end = self.assembly.take_steps(self.dt, min(most, self._block), t)
        self._look_at_end(end, t)
        self._block = next_block(self.steps - before, running_time() - began)

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
        self.spent = (
            f"the friction law of {first} and {second} is negative, or no number, at a speed that they slide with; "
            f"stopped at t = {self.now:.9g} s"
        )
        self.status, self.cause = Status.NOT_FINITE, InvalidInput(self.spent)

    def _end_of_large_impact(self) -> None:
        """End the run where a law of impact is that of more contacts than it is done for."""
        body = self.names[int(self.assembly.network.j[int(self.assembly.progress.wanted)])]
        law = ImpactLaw(self.world.surfaces.impact).name.lower()
        self.spent = (
            f"impact = {law!r} is for islands of up to {MOST_STRUCK} closed contacts, and {body} is of a larger one; "
            f"impact='newton' has no such limit; stopped at t = {self.now:.9g} s, before it rebounds"
        )
        self.status, self.cause = Status.NOT_FINITE, InvalidInput(self.spent)

    def stop(self, spent: str) -> None:
        """End the run before its time."""
        self.status, self.spent = Status.BUDGET_SPENT, spent

    def end_at(self, stop: Stop) -> None:
        """End the run as an event of the user says."""
        self.status, self.spent, self.cause = stop.status, stop.message, stop.cause

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

    def _show(self, progress: Callable[[float], None]) -> None:
        """Call the user's function of the fraction done; whatever it raises ends the run, with its name."""
        t_0, t_1 = self.table.span
        try:
            progress(float((self.now - t_0) / (t_1 - t_0)) if t_1 > t_0 else 1.0)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self.status, self.cause = Status.PROGRESS_FAILED, error

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

    def message(self) -> str:
        """How the run ended, in a sentence."""
        where = f"t = {self.now:.9g} s"
        if self.status == Status.FINISHED:
            return "the end was reached"
        if self.status in (Status.EVENT_REACHED, Status.EVENT_FAILED) or (
            self.status == Status.NOT_FINITE and self.cause is not None
        ):
            return self.spent
        if self.status == Status.INTERRUPTED:
            return f"interrupted at {where}"
        if self.status == Status.BUDGET_SPENT:
            return f"{self.spent} is used up after {self.steps} steps; stopped at {where}"
        if self.status == Status.PROGRESS_FAILED:
            assert self.cause is not None
            return f"the progress function raised {said_by(self.cause)}; stopped at {where}"
        if self.status == Status.NOT_FINITE:
            return f"{self.world.lost()} is nowhere: its place is not finite, or too far out; stopped at {where}"
        stats = self.stats()
        return (
            f"the contact problem of this step was solved to a residual of {stats.last_residual:.2g}"
            f"{worst_place(stats)}, and "
            f"tol = {self.assembly.tol:g} was asked for; stopped at {where}"
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

    def failure(self, solution: SceneSolution) -> StepFailure:
        """The exception of a run that did not end well."""
        from nonsmooth.results.failed_problem import SceneProblem

        unsolved = self.assembly.unsolved if self.status == Status.NOT_SOLVED else None
        problem = None if unsolved is None else SceneProblem(unsolved, solution.message)
        kind = FAILURES.get(self.status, StepFailure)
        error = kind(solution.message, solution, self.now, problem)  # type: ignore[arg-type]
        error.__cause__ = self.cause
        return error
