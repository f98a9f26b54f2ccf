"""A run that begins in the interpreter while its machine code is compiled by other processes.

    interpreter, block after block  ->  the code is there, or was waited for: the same blocks go on by it

Nobody waits for the first picture of a new machine: most runs of the models of this package end in the interpreter
within a second or two, and compiling takes four to ten. The bits are those of machine code (docs/promises.md), for the
functions of this package; a model of the user's may call what NumPy rounds otherwise than the C library, so it is
compiled first. What does not go well in the interpreter is done again by machine code, from the block before on.
"""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np

from nonsmooth.errors import Status
from nonsmooth.integrators.contract import Integrator
from nonsmooth.jit import running_time
from nonsmooth.jit.elsewhere import Elsewhere, compile_elsewhere
from nonsmooth.jit.late import interrupts_counted, stopped_clock
from nonsmooth.jit.loading import ROOT, words_for
from nonsmooth.jit.waiting import waiting
from nonsmooth.mechanics.compiled import Model, interpreted_model, loop_of, model_of
from nonsmooth.mechanics.system import System
from nonsmooth.results.solution import Solution
from nonsmooth.runs.recorder import Recorder
from nonsmooth.runs.system_run import SystemRun
from nonsmooth.runs.times import Timetable
from nonsmooth.runs.workspace import contacts_by_code

LONGEST_LEFT = 4.0  # chosen: s that may be left in the interpreter, about what the code of the simplest method takes
FIRST_GUESS = 0.5  # chosen: s in the interpreter before what is left is guessed from the part that is done
MOST_WORDS_KEPT = 1_000_000  # chosen: 8 MB, 2 ms: what is copied before each block
OURS = tuple(f"{ROOT / name}{os.sep}" for name in ("nonsmooth", "models"))  # code: folders of this package
WELL = (Status.RUNNING, Status.FINISHED)


def compiled_elsewhere(system: System, integrator: Integrator) -> Elsewhere | None:
    """The processes that compile what a run may reach, where it may go ahead of them; None where it may not."""
    if os.environ.get("NONSMOOTH_INTERPRET") or integrator.loop.is_loaded or not is_of_package(system):
        return None
    missing = [kernel for kernel in integrator.entry_points(system) if not kernel.is_on_disk]
    return compile_elsewhere(missing) if missing else None


def is_of_package(system: System) -> bool:
    """Whether all functions of a system are of this package."""
    codes = [getattr(function, "__code__", None) for function in system.functions.values()]
    return not system.own_laws and all(code is not None and code.co_filename.startswith(OURS) for code in codes)


class AheadRun(SystemRun):
    """One integration in progress, the beginning of which is interpreted.

    Parameters
    ----------
    elsewhere : Elsewhere
        The processes that compile its code. The others are those of `SystemRun`.
    """

    interpreted = 0  # steps
    ahead_time = 0.0  # [s] that they took

    def __init__(
        self, elsewhere: Elsewhere, system: System, integrator: Integrator, table: Timetable, q0: np.ndarray,
        u0: np.ndarray, selection: int, project: bool, recorder: Recorder,
    ) -> None:  # fmt: skip
        self.elsewhere = elsewhere
        super().__init__(system, integrator, table, q0, u0, selection, project, recorder)

    def find_loop(self) -> tuple[Model, Callable]:
        """The loop in the interpreter."""
        model = interpreted_model(self.system)
        return model, model.loop(self.integrator, self.system)

    def block(self, max_steps: int) -> int:
        """A block in the interpreter as long as it goes well there and the code is not compiled; then by the code."""
        if self.model.is_compiled:
            return super().block(max_steps)
        if self._is_long() or self._words_kept() > MOST_WORDS_KEPT or self.elsewhere.is_over:
            self.go_over()
            return super().block(max_steps)
        before, began = self.snapshot(), running_time()
        with interrupts_counted() as interrupts:
            status = self._interpreted_block(max_steps)
        self.ahead_time += running_time() - began
        self.interpreted = int(self.state.counters.steps)
        if status not in WELL:
            self.go_back(before)
            self.go_over()
            return super().block(max_steps)
        if interrupts:  # between two steps
            raise KeyboardInterrupt
        return status

    def _interpreted_block(self, max_steps: int) -> int:
        """A block; where Python raises what machine code writes as NaN, one that is to be done again."""
        try:
            return super().block(max_steps)
        except Exception:
            return Status.NOT_FINITE

    def _is_long(self) -> bool:
        """Whether so much is left that the code will be there before the end; the interpreter slows the others down."""
        done = self.fraction_done()
        return self.ahead_time > FIRST_GUESS and self.ahead_time * (1.0 - done) > LONGEST_LEFT * done

    def _words_kept(self) -> int:
        return sum(len(block.words) for block in (self.state, self.record, self.memory))

    def go_over(self) -> None:
        """Go on by machine code from where the blocks are, once it is there: the model is compiled meanwhile."""
        self.interpreted = int(self.state.counters.steps)
        missing = [kernel for kernel in self.integrator.entry_points(self.system) if not kernel.is_on_disk]
        words = words_for(missing, [missing]) if missing else ""
        with waiting(lambda: words), stopped_clock():
            model_of(self.system)
            self.elsewhere.wait()
            self.model, self.loop = loop_of(self.system, self.integrator)
        self.sys.model = self.model.handle
        workspace = self.workspace
        workspace.model, workspace.handed = self.model, ((), ())
        workspace.contacts = contacts_by_code(self.system, self.model, self.state, self.sys)
        self.find_own_loop()

    def solution(self) -> Solution:
        """What was computed, and how much of it in the interpreter."""
        solution = super().solution()
        self.elsewhere.leave()
        if self.interpreted:
            part = f"the first {self.interpreted}" if self.model.is_compiled else f"all {self.interpreted}"
            solution.about["interpreted"] = (
                f"{part} steps, {self.ahead_time:.2g} s, while machine code for the rest and for later runs is "
                "compiled by other processes; no bit differs"
            )
        return solution
