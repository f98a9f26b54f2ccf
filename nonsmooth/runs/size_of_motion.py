"""Whether an absolute tolerance that nobody asked for suits the size of the motion.

    tol_i = atol + rtol max |q_i|

The default atol is one of bodies of a metre. Of a motion of nanometres it is a tenth of the coordinates, and impacts
are lost in it. How large a motion is a run knows at its end only: where atol is more than TOLERATED of what rtol makes
of the largest coordinate, the run is taken again with that which ``Auto`` has for coordinates of 1, times their size.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from nonsmooth.results.solution import Solution
from nonsmooth.runs.choice import PER_ATOL

TOLERATED = 100.0  # chosen: of rtol times the size: what an absolute tolerance may make of a relative one
# chosen: times the steps of the run, that the finer one may take, and steps of one contact beside them: a method of
# order 5 takes 16 times as many for an atol of 1e-6 times the first. What takes more is the noise of a system that
# rests, and the first run stands, with a word: a stack of 50 blocks would take ten minutes for the motion of 1e-12 m
# that its solver leaves
STEPS_AGAIN, STEPS_OF_ONE = 16, 20_000
NO_MOTION = 1e-13  # chosen: [SI units]: less is rounding of a system of the size 1 that rests


def suited(integrator: Any, is_chosen: bool, solution: Solution) -> Any:
    """The integrator with an atol for the size of this motion; None where its own will do, or was asked for."""
    is_known = "coordinates" in solution.recorded and len(solution.q) > 0
    if not is_known or not has_default_atol(integrator, is_chosen):
        return None
    size = float(np.abs(solution.q).max(initial=0.0))
    if not np.isfinite(size) or size < NO_MOTION or integrator.atol <= TOLERATED * integrator.rtol * size:
        return None
    return replace(integrator, atol=integrator.rtol / PER_ATOL * size)


def has_default_atol(integrator: Any, is_chosen: bool) -> bool:
    """Whether an integrator has an absolute tolerance, and nobody asked for it."""
    if not hasattr(integrator, "atol") or not hasattr(integrator, "rtol"):
        return False
    return is_chosen or integrator.atol == getattr(type(integrator), "atol", None)


def steps_again(system: Any, solution: Solution) -> int:
    """The most steps that a run with a finer atol may take: a step costs as the square of the contacts."""
    return STEPS_AGAIN * int(solution.stats.steps) + STEPS_OF_ONE // (1 + len(system.contacts) ** 2)


def coarse(integrator: Any, solution: Solution) -> str:
    """What is to be said where the run is not taken again."""
    size = float(np.abs(solution.q).max())
    atol = integrator.rtol / PER_ATOL * size
    return (
        f"the default atol = {integrator.atol:.1e} is {integrator.atol / size:.1e} of the largest coordinate, "
        f"{size:.1e}, far above rtol = {integrator.rtol:.1e}: events may be lost in it; atol={atol:.1e} suits it"
    )


def taken_again(first: Any, solution: Solution) -> str:
    """What the result says of a run that was taken again."""
    size = float(np.abs(solution.q).max())
    return f"the default atol = {first.atol:.1e} is too coarse for coordinates of {size:.1e}: the run was taken again"
