"""One run of a scene: step after step, until the end, a failure, Ctrl-C or the end of the budget."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.checks.memory import require_memory
from nonsmooth.errors import (
    EnergyGainWarning,
    InvalidInput,
    PenetrationWarning,
    ResidualWarning,
    Status,
    said_by,
    warn_caller,
)
from nonsmooth.integrators.assembly.progress import DONE, LOST, UNSOLVED
from nonsmooth.integrators.assembly.step import Assembly
from nonsmooth.integrators.assembly.world import World
from nonsmooth.integrators.contract import Integrator
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.jit.blocks import named_numbers
from nonsmooth.results.failures import BudgetSpent, ModelFunctionError, ProgressError, StepFailure
from nonsmooth.results.scene_solution import WORKS, ContactColumns, SceneSolution, SceneStats
from nonsmooth.runs.run import LOOK_EVERY, next_block
from nonsmooth.runs.times import RecordTimes, grid_times
from nonsmooth.scenes.scene import Scene
from nonsmooth.signals.bar import heard

SOFT = "the springs are soft for this motion, or what is thin passed through; a larger stiffness ends this"
DEEP = 0.01  # chosen: of the smallest shape: a penetration that is told
ENDS = {LOST: Status.NOT_FINITE, UNSOLVED: Status.NOT_SOLVED}
METHODS = {"kept": "kept", "sweeps": "swept", "augmented Lagrangian": "direct"}  # name: field of the counts
FAILURES: dict[Status, type[StepFailure]] = {
    Status.BUDGET_SPENT: BudgetSpent,
    Status.NOT_FINITE: ModelFunctionError,
    Status.PROGRESS_FAILED: ProgressError,
}


class SceneRun:
    """One run with steps of a given length; with compliant contacts: `SpringRun`.

    Parameters
    ----------
    scene : Scene
    t_span : (float, float)
        [s]
    integrator : MoreauJean
    every, t_eval
        As of `simulate`.
    """

    columns: tuple[str, ...] = WORKS  # of the ledger, beside the energies of the bodies
    what_is_deep = "what is thin and fast may have passed through what it met; a smaller dt ends this"

    def __init__(
        self, scene: Scene, t_span: tuple[float, float], integrator: MoreauJean, every: int, t_eval: Any
    ) -> None:
        if not isinstance(integrator, MoreauJean):
            raise InvalidInput(
                f"a scene is integrated by MoreauJean(dt=...); got {type(integrator).__name__}: Penalty(k) takes one "
                "too, others a small planar one as scene.system(), from *scene.state()"
            )
        if integrator.projection:
            raise InvalidInput("bodies of a scene are pushed apart in every step; leave out projection= of MoreauJean")
        self._begin(scene, integrator, grid_times(integrator, t_span, every, t_eval))

    def _begin(self, scene: Scene, integrator: Any, times: RecordTimes) -> None:
        """The records, and the scene in motion."""
        self.scene, self.integrator = scene, integrator
        n_b = len(scene.bodies)
        if n_b == 0:
            raise InvalidInput("the scene has no bodies; add them by scene.body(...), scene.fixed(...)")
        bytes_of_record = 8.0 * n_b * (13 if scene.dim == 3 else 6)
        require_memory(bytes_of_record * times.count, f"{times.count} records", "take a larger every or dt")
        self.times = times.part(0, times.count)
        started = time.perf_counter()
        self.world = World(scene, float(self.times[0]))
        self.assembly = self._assemble()
        self.compile_time = time.perf_counter() - started
        self.world.require_apart(self.assembly.find_contacts(), self.assembly.found)
        self.status = Status.RUNNING
        self.began, self.dt, self.steps_before = float(self.times[0]), 0.0, 0  # of the interval between two records
        self.wall_time = 0.0
        self.cause: BaseException | None = None
        self.spent = ""
        self.x = np.zeros((times.count, *self.world.bodies.motion.x.shape))
        self.v = np.zeros((times.count, *self.world.bodies.motion.v.shape))
        self.works = np.zeros((times.count, len(self.columns)))
        self.worst = np.zeros((times.count, 2))
        self.chunks: list[tuple[np.ndarray, ...]] = []
        self.rows = 0

    def _assemble(self) -> Any:
        """The scene in motion: its steps, contacts, works and figures."""
        options, world, compliance = self.integrator.contacts, self.world, self.integrator.compliance
        if compliance is not None:
            world.surfaces.is_compliant, world.surfaces.e[:] = 1, 0.0
            world.surfaces.stiffness, world.surfaces.damping = compliance.stiffness, compliance.damping
            self.what_is_deep = SOFT
        assembly = Assembly(
            world.bodies, world.shapes, world.surfaces, options.tol, options.sweeps, options.on_residual == "raise",
            options.may_sleep, self.integrator.theta,
        )  # fmt: skip
        if compliance is not None:
            assembly.progress.tight = math.inf  # what springs give way to is not taken back
        return assembly

    def advance(
        self, max_wall_time: float | None, progress: Callable[[float], None] | None, max_steps: int | None = None
    ) -> None:
        """Run until the end or a reason to stop."""
        started = time.perf_counter()
        deadline = math.inf if max_wall_time is None else started + max_wall_time
        budget = sys.maxsize if max_steps is None else max_steps
        self._looked, self._block = started, 1

        def may_go_on() -> bool:
            self._look(deadline, progress, max_wall_time)
            if self.status == Status.RUNNING and self.steps >= budget:
                self._stop(f"max_steps = {max_steps}")
            return self.status == Status.RUNNING

        try:
            self._write_row()
            self._run(may_go_on, budget)
            if self.status != Status.RUNNING:
                return
            self.status = Status.FINISHED
            if progress is not None:
                self._show(progress)
        except KeyboardInterrupt:
            self.status = Status.INTERRUPTED
        finally:
            if self.status != Status.FINISHED and self.status != Status.RUNNING:
                self.assembly.end_step()
                self._write_last_row()
            self.wall_time = time.perf_counter() - started

    def _run(self, may_go_on: Callable[[], bool], budget: int) -> None:
        """From record to record, as long as that may go on."""
        dts, counts = self.integrator.steps_between(self.times)
        for k, (dt, count) in enumerate(zip(dts.tolist(), counts.tolist(), strict=True)):
            self.began, self.dt, self.steps_before = float(self.times[k]), dt, self.steps
            while (done := self.steps - self.steps_before) < count:
                if not may_go_on():
                    return
                self._take_steps(min(count - done, budget - self.steps))
                if self.status != Status.RUNNING:
                    return
            self.began, self.dt = float(self.times[k + 1]), 0.0
            self._write_row()

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
        now = time.perf_counter()
        if now - self._looked < LOOK_EVERY:
            return
        self._looked = now
        if now > deadline:
            self._stop(f"max_wall_time = {max_wall_time:g} s")
        if progress is not None:
            self._show(progress)

    def _take_steps(self, most: int) -> None:
        """Some steps, as many as end before the next look at the clock."""
        before, began = self.steps, time.perf_counter()
        if self.world.guided:
            self.world.guide(self.now, self.dt)
            most = 1
        end = self.assembly.take_steps(self.dt, min(most, self._block))
        if end != DONE:
            self.status = ENDS[end]
        self._block = next_block(self.steps - before, time.perf_counter() - began)

    def _stop(self, spent: str) -> None:
        self.status, self.spent = Status.BUDGET_SPENT, spent

    def _show(self, progress: Callable[[float], None]) -> None:
        """Call the user's function of the fraction done; whatever it raises ends the run, with its name."""
        t_0, t_1 = self.times[0], self.times[-1]
        try:
            progress(float((self.now - t_0) / (t_1 - t_0)) if t_1 > t_0 else 1.0)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self.status, self.cause = Status.PROGRESS_FAILED, error

    def _write_row(self) -> None:
        """Write the state as the next record."""
        motion, k = self.world.bodies.motion, self.rows
        self.x[k], self.v[k], self.works[k] = motion.x, motion.v, self.assembly.ledger.work
        figures = self.assembly.progress.figures
        self.worst[k] = figures.since_residual, figures.since_penetration
        figures.since_residual = figures.since_penetration = 0.0
        self.chunks.append(self._contacts())
        self.rows = k + 1

    def _write_last_row(self) -> None:
        """The state at which the run stopped, unless it is the last record."""
        self.times = np.append(self.times[: self.rows], self.now)
        if self.rows and self.times[-1] == self.times[-2]:
            self.times = self.times[:-1]
        else:
            self._write_row()

    def _contacts(self) -> tuple[np.ndarray, ...]:
        """The contacts of the last step: bodies, points, normals, gaps, impulses in the world, friction."""
        assembly = self.assembly
        n = assembly.network.n_c if self.steps else 0
        found, network = assembly.found, assembly.network
        d = self.scene.dim
        P = np.einsum("crk,cr->ck", network.J_j[:n, :, :d], assembly.contacts.P[:n])
        columns = network.i[:n], network.j[:n], found.point[:n], found.normal[:n], found.gap[:n]
        return (*(column.copy() for column in columns), P, network.mu[:n].copy())

    def stats(self) -> SceneStats:
        """What the run cost."""
        assembly = self.assembly
        counts, figures = (named_numbers(block) for block in (assembly.progress.counts, assembly.progress.figures))
        methods = {name: counts[field] for name, field in METHODS.items() if counts[field]}
        return SceneStats(
            counts["steps"], int(assembly.network.n_c), counts["most_contacts"], int(assembly.network.islands.count),
            methods, counts["sweeps"], counts["factors"], counts["impacts"], counts["asleep"], assembly.tol,
            figures["residual"], figures["last_residual"], counts["missed"], figures["penetration"],
            figures["last_penetration"], self.wall_time, self.compile_time,
            counts["gains"], figures["gain"],
        )  # fmt: skip

    def message(self) -> str:
        """How the run ended, in a sentence."""
        where = f"t = {self.now:.9g} s"
        if self.status == Status.FINISHED:
            return "the end was reached"
        if self.status == Status.INTERRUPTED:
            return f"interrupted at {where}"
        if self.status == Status.BUDGET_SPENT:
            return f"{self.spent} is used up after {self.steps} steps; stopped at {where}"
        if self.status == Status.PROGRESS_FAILED:
            assert self.cause is not None
            return f"the progress function raised {said_by(self.cause)}; stopped at {where}"
        if self.status == Status.NOT_FINITE:
            return f"{self.world.lost()} is nowhere: its place is not finite, or too far out; stopped at {where}"
        residual = self.assembly.progress.figures.last_residual
        return (
            f"the contact problem of this step was solved to a residual of {residual:.2g}, and "
            f"tol = {self.assembly.tol:g} was asked for; stopped at {where}"
        )

    def solution(self) -> SceneSolution:
        """What was computed."""
        k, dim = self.rows, self.scene.dim
        x, v = self.x[:k], self.v[:k]
        counts = [len(chunk[0]) for chunk in self.chunks]
        offsets = np.concatenate(([0], np.cumsum(counts)))
        columns = ContactColumns(offsets, *map(np.concatenate, zip(*self.chunks, strict=True)))
        turn, spin = (x[:, :, 2], v[:, :, 2]) if dim == 2 else (self.world.turns(x[:, :, 3:]), v[:, :, 3:])
        ledger = self.world.energies(x, v) | {name: self.works[:k, w] for w, name in enumerate(self.columns)}
        about = {"scene": repr(self.scene), "integrator": repr(self.integrator)} | self._about()
        return SceneSolution(
            self.times[:k], x[:, :, :dim], turn, v[:, :, :dim], spin, columns, ledger, self.worst[:k, 0],
            self.worst[:k, 1], self.stats(), self.status, self.message(), [body.name for body in self.scene.bodies],
            self.scene, self.world.frames[:, :dim], about,
        )  # fmt: skip

    def _about(self) -> dict[str, str]:
        """What is to be kept of the options beside."""
        return {"contacts": repr(self.integrator.contacts)}

    def failure(self, solution: SceneSolution) -> StepFailure:
        """The exception of a run that did not end well."""
        error = FAILURES.get(self.status, StepFailure)(solution.message, solution, self.now)  # type: ignore[arg-type]
        error.__cause__ = self.cause
        return error


def simulate_scene(
    kind: type[SceneRun], scene: Scene, t_span: tuple[float, float], integrator: Integrator, every: int, t_eval: Any,
    on_failure: str, max_steps: int | None, max_wall_time: float | None,
    progress: Callable[[float], None] | bool | None,
) -> SceneSolution:  # fmt: skip
    """`simulate` for a scene by a kind of run, its arguments checked but for those of times."""
    run = kind(scene, t_span, integrator, every, t_eval)  # type: ignore[arg-type]
    with heard(progress) as hear:
        run.advance(max_wall_time, hear, max_steps)
    solution = run.solution()
    if solution.stats.missed and run.status == Status.FINISHED:
        warn_caller(missed_residual(solution.stats), ResidualWarning)
    if solution.stats.energy_gains:
        warn_caller(rebound_gain(solution.stats), EnergyGainWarning)
    if solution.stats.worst_penetration > DEEP * run.assembly.smallest:
        warn_caller(deep_penetration(solution.stats, run.assembly.smallest, run.what_is_deep), PenetrationWarning)
    if not solution.success and solution.status != Status.INTERRUPTED and on_failure == "raise":
        raise run.failure(solution)
    return solution


def rebound_gain(stats: SceneStats) -> str:
    """What is to be said of a run whose contacts gained energy."""
    return (
        f"the contacts gained energy in {stats.energy_gains} impacts, up to {stats.worst_energy_gain:.3g} J: "
        "Newton's law of impact lets them where e > 0 and friction acts, or several contacts are hit at once; "
        "e = 0 gains nothing"
    )


def deep_penetration(stats: SceneStats, smallest: float, what: str) -> str:
    """What is to be said of a run whose bodies were deep in one another: thin and fast ones may have passed through."""
    return (
        f"bodies were up to {stats.worst_penetration:.2g} m in one another, and the smallest reaches {smallest:.2g} m: "
        + what
    )


def missed_residual(stats: SceneStats) -> str:
    """What is to be said of a run whose contact problems were not all solved to the tolerance."""
    return (
        f"in {stats.missed} of {stats.steps} steps the contact problem was solved to less than tol = {stats.tol:g}, at "
        f"worst to {stats.worst_residual:.2g}; more sweeps, or a larger tol, end this: "
        "MoreauJean(dt, contacts=ns.ContactSolver(tol=..., sweeps=...))"
    )
