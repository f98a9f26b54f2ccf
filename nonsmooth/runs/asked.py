"""What a run is asked for beside its problem and its method: checked once, handed on whole."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike

from nonsmooth.checks.arrays import as_count, as_flag, as_name, as_positive
from nonsmooth.contact.planar.single import Selection
from nonsmooth.errors import InvalidInput, shown
from nonsmooth.integrators.contract import Integrator
from nonsmooth.runs.seen import require_live

MOST_THREADS = 64  # chosen: each has a memory of its own, 80 bytes a body and 16 a contact
SELECTIONS = {
    "compliant-limit": Selection.COMPLIANT_LIMIT,
    "lift-off": Selection.LIFT_OFF,
    "impact": Selection.IMPACT,
}


@dataclass
class Asked:
    """The options of `simulate`, by their names there; what breaks a rule raises `InvalidInput`."""

    every: int
    t_eval: ArrayLike | None
    selection: str
    project: bool
    on_failure: str
    events: Callable[..., Any] | Sequence[Callable[..., Any]]
    max_steps: int | None
    max_wall_time: float | None
    progress: Callable[[float], None] | bool | None
    checkpoint: Any
    resume: Any
    checkpoint_every: float
    record: str | Sequence[str] | None
    view: bool
    threads: int
    is_whole: bool  # whether a part of a motion is of no use: Ctrl-C is no result then
    may_go_ahead: bool  # whether the run may be ahead of its code

    def __post_init__(self) -> None:
        self.every = as_count("every", self.every)
        if self.every != 1 and self.t_eval is not None:
            raise InvalidInput("give either every or t_eval; got both")
        as_name("selection rule", self.selection, SELECTIONS)
        if not isinstance(self.on_failure, str) or self.on_failure not in ("raise", "return"):
            raise InvalidInput(f"on_failure must be 'raise' or 'return'; got {shown(self.on_failure)}")
        if self.max_wall_time is not None:
            as_positive("max_wall_time", self.max_wall_time, "s")
        self.project = as_flag("project", self.project)
        if self.max_steps is not None:
            as_count("max_steps", self.max_steps)
        if self.progress is not None and not isinstance(self.progress, bool) and not callable(self.progress):
            raise InvalidInput(
                f"progress must be a function of the fraction done, or True for a bar; got {shown(self.progress)}"
            )
        if as_flag("view", self.view):
            require_live()
        if as_count("threads", self.threads) > MOST_THREADS:
            raise InvalidInput(
                f"threads must be at most {MOST_THREADS}, and processors help no more; got {self.threads}"
            )

    @property
    def rule(self) -> Selection:
        """The rule by which one of several solutions is taken."""
        return SELECTIONS[self.selection]

    @property
    def has_checkpoint(self) -> bool:
        """Whether the run is kept on disk, or goes on with one that is."""
        return self.checkpoint is not None or self.resume is not None


def require_integrator(integrator: Any) -> None:
    """Raise `InvalidInput` for what is no integrator."""
    if not isinstance(integrator, Integrator):
        raise InvalidInput(
            f"integrator must be an integrator, as ns.MoreauJean(dt=1e-3) is, or 'auto'; got {shown(integrator)}"
        )
