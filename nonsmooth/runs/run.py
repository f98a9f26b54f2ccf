"""One integration in progress: block after block of steps, until the end, a failure, Ctrl-C or the end of a budget.

Between two blocks Python looks for Ctrl-C and shows progress; a block takes some hundredths of a second, or one step. A
run of a system is in system_run.py, one of a scene in scene_run.py.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from contextlib import closing
from typing import Any, ClassVar

from nonsmooth.errors import Status, said_by
from nonsmooth.jit import running_time, waited
from nonsmooth.results.failures import BudgetSpent, EventFunctionError, ModelFunctionError, ProgressError, StepFailure
from nonsmooth.runs.user_events import Stop

LOOK_EVERY = 0.02  # chosen: s between two looks at the clock and at Ctrl-C
FAILURES: dict[Status, type[StepFailure]] = {
    Status.NOT_FINITE: ModelFunctionError,
    Status.BUDGET_SPENT: BudgetSpent,
    Status.EVENT_FAILED: EventFunctionError,
    Status.CONTRADICTED: ModelFunctionError,
    Status.PROGRESS_FAILED: ProgressError,
}


class Run:
    """One integration in progress, of whatever there is to integrate.

    Attributes
    ----------
    status : Status
    wall_time, compile_time : float
        [s]
    stop : Stop
        Where something other than the steps ended it, what and when.
    cause : BaseException
        Of a failure, an exception of the user's.
    """

    interrupted = 0  # runs of this process that Ctrl-C cut short: who makes many of them ends with the first
    first_block: ClassVar[int] = 1  # steps before the first look at the clock
    integrator: Any
    table: Any  # the times of the records
    recorder: Any  # where the records go
    status: Status = Status.RUNNING
    wall_time = 0.0
    compile_time = 0.0
    stop: Stop | None = None
    cause: BaseException | None = None
    spent = ""  # which budget was used up

    @property
    def steps(self) -> int:
        """Taken so far."""
        raise NotImplementedError

    @property
    def now(self) -> float:
        """The time that the run has come to [s]."""
        raise NotImplementedError

    def take(self, most: int) -> Status:
        """Take a block of at most so many steps, with its records and events."""
        raise NotImplementedError

    def settle(self) -> None:
        """Find out more about an end, once the steps have ended."""

    def reason(self) -> str:
        """A sentence on an end that is none of those that all runs have."""
        raise NotImplementedError

    def failed_problem(self, message: str) -> Any:
        """The contact problem at which the run failed, where there is one."""

    def where(self) -> str:
        """Where the run is, in words."""
        return f"t = {self.now:.9g} s"

    def advance(
        self, max_wall_time: float | None, progress: Callable[[float], None] | None, max_steps: int | None = None
    ) -> None:
        """Run block after block until the end, a failure, Ctrl-C or the end of a budget."""
        with closing(self.recorder):
            if self.status == Status.RUNNING:
                self._run_blocks(max_wall_time, progress, max_steps)
                self.recorder.end(self)

    def _run_blocks(
        self, max_wall_time: float | None, progress: Callable[[float], None] | None, max_steps: int | None
    ) -> None:
        started, waited_before = running_time(), waited()
        deadline = math.inf if max_wall_time is None else started + max_wall_time
        budget, block = sys.maxsize if max_steps is None else max_steps, self.first_block
        try:
            while self.status == Status.RUNNING:
                began, before = running_time(), self.steps
                if before >= budget and self.fraction_done() < 1.0:
                    self.spend(f"max_steps = {max_steps}")
                    break
                self.status = self.take(max(1, min(block, budget - before)))
                now = running_time()
                self.wall_time = now - started
                block = next_block(self.steps - before, now - began)
                if progress is not None:
                    self._show(progress)
                if now > deadline and self.status == Status.RUNNING:
                    self.spend(f"max_wall_time = {max_wall_time:g} s")
        except KeyboardInterrupt:
            Run.interrupted += 1
            self.status = Status.INTERRUPTED
        finally:
            self.wall_time = running_time() - started
            self.compile_time += waited() - waited_before
        self.settle()

    def spend(self, what: str) -> None:
        """End the run, because something is used up."""
        self.status, self.spent = Status.BUDGET_SPENT, what

    def end_at(self, stop: Stop) -> None:
        """End the run where an event or a function of the user says so."""
        self.status, self.stop = stop.status, stop

    def _show(self, progress: Callable[[float], None]) -> None:
        """Call the user's function of the fraction done; whatever it raises ends the run, with its name."""
        try:
            progress(self.fraction_done())
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            self.status, self.cause = Status.PROGRESS_FAILED, error

    def fraction_done(self) -> float:
        """The part of the span that lies behind."""
        t_0, t_1 = self.table.span
        return float((self.now - t_0) / (t_1 - t_0)) if t_1 > t_0 else 1.0

    def message(self) -> str:
        """How the run ended, in a sentence."""
        where = f"t = {self.now:.9g} s"
        if self.status == Status.FINISHED:
            return "the end was reached"
        if self.status == Status.INTERRUPTED:
            return f"interrupted at {where}"
        if self.status == Status.BUDGET_SPENT:
            spent = self.spent or self.integrator.budget
            return f"{spent} is used up after {self.steps} steps; stopped at {self.where()}"
        if self.status == Status.PROGRESS_FAILED:
            assert self.cause is not None
            return f"the progress function raised {said_by(self.cause)}; stopped at {where}"
        return self.reason() if self.stop is None else self.stop.message

    def failure(self, solution: Any) -> StepFailure:
        """The exception of a run that did not end well."""
        kind = FAILURES.get(self.status, StepFailure)
        error = kind(solution.message, solution, self.now, self.failed_problem(solution.message))
        error.__cause__ = self.cause if self.stop is None else self.stop.cause
        return error


def next_block(steps: int, elapsed: float) -> int:
    """Steps until the next look at the clock, from those just taken and their seconds; at most ten times more."""
    return max(1, int(steps * min(10.0, LOOK_EVERY / max(elapsed, 1e-9))))
