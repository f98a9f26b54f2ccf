"""The penalty limit of a scene: its springs against its rigid contacts, over the stiffness.

    e(k) = max |q_k(t) - q_rigid(t)|,    order -d ln e/d ln k

What rests is pressed in by its load over k: order 1. What lands is late by the time of its springs, k^-1/2.
"""

from __future__ import annotations

import contextlib
import functools
import math
import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput, PenetrationWarning
from nonsmooth.integrators.assembly.world import World
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.integrators.springs.scene_springs import half_thickness
from nonsmooth.runs.scene_warnings import DEEP
from nonsmooth.studies.affordable import Choice, choose_affordable
from nonsmooth.studies.comparison import ComparisonTask, run_comparison
from nonsmooth.studies.equal_restitution import chosen_damping, compared
from nonsmooth.studies.reference import Observed, SceneProblem, as_reference, coarser, largest_differences
from nonsmooth.studies.stiffnesses import STIFFNESSES, beside_columns, penalty_at
from nonsmooth.studies.study import Study
from nonsmooth.sweeps.progress import part_shown
from nonsmooth.sweeps.task import Variable

REFERENCE_STEPS = 4000  # chosen: of the rigid run that the springs are compared with
SCENE_BESIDE_STEPS = (250, 1000)  # chosen: of the rigid runs whose cost is compared
STUDY_RTOL = 1e-6  # chosen: errors of the springs are looked at down to some 1e-5 of the motion
STUDY_ATOL = 1e-8  # chosen: as far below it as Penalty's own [m/s]


def study_of_scene(
    problem: SceneProblem, stiffness: np.ndarray | None, damping: float | Callable[[float], float] | None,
    damping_ratio: float | None, restitution: str, penalty: Penalty | None, reference: Any,
    beside: Sequence[Any] | None, workers: int, journal: str | os.PathLike[str] | None, progress: Any,
    of_systems: dict[str, Any],
) -> Study:  # fmt: skip
    """`penalty_study` of a scene, its arguments checked."""
    for name, value in of_systems.items():
        if value is not None:
            raise InvalidInput(f"{name}= of a penalty study looks at a contact of a system; leave it out for a scene")
    span = problem.span[1] - problem.span[0]
    options = Penalty(1.0, rtol=STUDY_RTOL, atol=STUDY_ATOL) if penalty is None else penalty
    is_equal, chosen_ratio = restitution == "equal", None
    if damping is None and damping_ratio is None:
        chosen_ratio = chosen_damping(problem, 0, options.law) if is_equal else None
        damping_ratio = 1.0 if chosen_ratio is None else chosen_ratio
    make = functools.partial(penalty_at, options, damping=damping, damping_ratio=damping_ratio)
    if stiffness is None:
        with no_word_of_depth():
            chosen = choose_affordable(problem, stiffnesses_of(problem), make, ScenePenaltyTask.runs)
    else:
        chosen = Choice(stiffness.tolist())
    compliant = {k: make(k) for k in chosen.values}
    found, rigid = compared(problem, list(compliant.values()), 0, chosen_ratio, is_equal)
    with part_shown("the reference", progress):
        exact = as_reference(MoreauJean(span / REFERENCE_STEPS) if reference is None else reference, rigid)
    task = ScenePenaltyTask(problem, exact, "stiffness", compliant)
    data = run_comparison(task, "N/m", workers, journal, progress)
    data.attrs |= {"left_out": chosen.left_out, "soft": soft_ones(problem, data), **problem.about}
    data = data if found is None else found.columns(data)
    steppers = [MoreauJean(span / n) for n in SCENE_BESIDE_STEPS] if beside is None else beside
    if len(steppers) and not data.attrs["interrupted"]:
        try:
            runs = ComparisonTask(rigid, exact, "beside", dict(enumerate(steppers)))
            data = data.assign(beside_columns(runs, progress))
        except KeyboardInterrupt:  # the runs that the study is of are finished
            data.attrs["interrupted"] = 1
    return Study("stiffness", data, problem.titled("the penalty limit"))


class ScenePenaltyTask(ComparisonTask):
    """Runs with compliant contact, compared with a rigid one."""

    def measure(self, integrator: Any) -> dict[str, Any]:
        """Errors and cost of a run; how deep it went stands among them."""
        with no_word_of_depth():
            return super().measure(integrator)

    def costs(self, columns: Any) -> np.ndarray:
        """Seconds that each cell will take."""
        with no_word_of_depth():
            return super().costs(columns)

    def further(self, integrator: Any, run: Any, observed: Observed) -> dict[str, Any]:
        """The part of the errors that the integration has, and the depth."""
        coarse = self.reference.observe(
            self.problem, coarser(integrator), self.problem.run(coarser(integrator), self.problem.times)
        )
        own = {f"own_{name}": error for name, error in largest_differences(observed, coarse).items()}
        return own | {"penetration": run.stats.worst_penetration}

    @property
    def variables(self) -> dict[str, Variable]:  # type: ignore[override]
        """Also the depth."""
        return super().variables | {"penetration": Variable((), "m")}


@contextlib.contextmanager
def no_word_of_depth() -> Iterator[None]:
    """How deep the springs gave way is a column of the study; there are no warnings of it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PenetrationWarning)
        yield


def stiffnesses_of(problem: SceneProblem) -> list[float]:
    """Powers of ten, from the one on at which the whole weight presses one contact in by little."""
    world = World(problem.scene, problem.span[0])
    weight = float(world.bodies.mass.sum()) * float(np.linalg.norm(world.bodies.gravity))
    least = weight / (DEEP * half_thickness(world.shapes))
    first = math.ceil(math.log10(least)) if least > 0.0 and math.isfinite(least) else math.log10(STIFFNESSES[0])
    return [10.0 ** (first + n) for n in range(len(STIFFNESSES))]


def soft_ones(problem: SceneProblem, data: Any) -> str:
    """A sentence on the runs whose bodies were deep in one another."""
    half = half_thickness(World(problem.scene, problem.span[0]).shapes)
    deep = data.stiffness.values[data.penetration.values > DEEP * half]
    if len(deep) == 0:
        return ""
    return (
        f"soft: up to k = {deep.max():.3g} N/m bodies were deeper in one another than {DEEP:g} of half the thinnest, "
        f"{half:.3g} m"
    )
