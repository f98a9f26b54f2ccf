"""One run of a scene with rigid contacts and error control: by `Adaptive`, where a scene is not taken as its system."""

from __future__ import annotations

from dataclasses import replace

from nonsmooth.contact.network.parallel import Desks
from nonsmooth.errors import InvalidInput, Status
from nonsmooth.integrators.assembly.controlled import NO_SHORTER, Controlled
from nonsmooth.integrators.moreau_jean.contact_solver import ContactSolver
from nonsmooth.runs.free_steps import FreeSteps
from nonsmooth.runs.scene_run import ENDS
from nonsmooth.signals.interruption import interrupts_held_back

MID_POINT = 0.5  # defined: theta of steps of second order
OF_RTOL, LEAST_TOL = 0.01, 1e-12  # chosen: the residual asked of contact problems, a part of rtol, and its least


class ControlledRun(FreeSteps):
    """One run, as `SceneRun`, by `Adaptive`."""

    ends = ENDS | {NO_SHORTER: Status.STEP_VANISHED}
    cure = "a larger rtol or atol ends this"
    assembly: Controlled

    @property
    def contacts(self) -> ContactSolver:
        """How contact problems are solved."""
        standard = ContactSolver()
        tol = max(LEAST_TOL, min(standard.tol, OF_RTOL * self.integrator.rtol))
        return replace(standard, tol=tol, may_sleep=False)

    def _assemble(self) -> Controlled:
        """The scene in motion."""
        options, own = self.integrator, self._given(self.contacts, MID_POINT)
        assembly = Controlled(options.rtol, options.atol, *self.table.span, *own)
        assembly.desks, self.course = Desks(self.threads), assembly.course
        return assembly

    def take_steps(self, most: int) -> None:
        """Take one step."""
        t = self.now
        try:
            with interrupts_held_back():
                end = self.assembly.take_controlled(self.ask_functions)
        except InvalidInput as refusal:
            self._end_without_answer(refusal)
        else:
            self._look_at_end(end, t)

    def _time_of_step(self, k: int) -> float:
        """When step k began [s], of those that something is said of."""
        worst = int(self.assembly.progress.worst.step)
        return float(self.course.worst_time if k == worst else self.course.first_together)
