"""Failures of a run: what stopped it, and all that was computed until then."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.errors import InvalidInput, NonsmoothError

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.checks.arrays import Vector
    from nonsmooth.results.failed_problem import FailedProblem, SceneProblem
    from nonsmooth.results.solution import Solution


class StepFailure(NonsmoothError, RuntimeError):
    """The integration stopped before its end.

    Attributes
    ----------
    solution : Solution
        Everything computed until then; its last record is the state before the step that failed.
    t : float
        Time of that state [s].
    q, u : (n_q,), (n_u,)
        That state.
    problem : FailedProblem, SceneProblem or None
        The contact problem that stopped the run: of `MoreauJean` that of its step, of `EventDriven` and `Adaptive` that
        of the contacts which touch at the instant; of a scene the islands that stayed above the tolerance where
        ``on_residual="raise"``. None after other failures, of `Penalty`, and with a friction law of the user's.
    """

    def __init__(self, message: str, solution: Solution, t: float, problem: FailedProblem | SceneProblem | None = None
    ) -> None:  # fmt: skip
        super().__init__(message)
        self.solution = solution
        self.t = t
        self.problem = problem

    @property
    def residual(self) -> float:
        """Worst residual of the contact problems that were accepted until then, relative to max |c|."""
        return self.solution.stats.worst_residual

    def dump(self, path: str | Path) -> Path:
        """Write the contact problem of the step to a small file, which ``nonsmooth solve`` opens again.

        Parameters
        ----------
        path : path-like
            .npz keeps all that the step's own solver was given; .hdf5 or .h5 is the form of FCLIB, for other programs.

        Raises
        ------
        InvalidInput
            Where the step that failed has no contact problem: the message of the failure says what stopped it. For
            FCLIB also where a law has no place in it.
        FileFailure
            Where it cannot be written.
        """
        if self.problem is None:
            raise InvalidInput(
                "this failure has no contact problem to write: none was being solved, or its friction law is a "
                "function of the user's; failure.solution has the state it stopped at"
            )
        return self.problem.save(path)

    @property
    def q(self) -> Vector:
        """Coordinates (n_q,) where the run stopped."""
        return self.solution.q[-1]

    @property
    def u(self) -> Vector:
        """Velocities (n_u,) where the run stopped."""
        return self.solution.u[-1]


class ModelFunctionError(StepFailure):
    """A function of the model raised, wrote NaN or inf, or contradicts another; the message says which, and where."""


class BudgetSpent(StepFailure):
    """The steps or the seconds that a run was given are used up before its end."""


class EventFunctionError(StepFailure):
    """An event function of the user raised, or returned no finite number; the message says which, and where."""


class ProgressError(StepFailure):
    """The user's function that shows progress raised; the message says what, ``solution`` has the run until then."""
