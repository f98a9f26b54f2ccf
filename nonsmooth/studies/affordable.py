"""Which values of what is varied a study takes where none are given: as many as some seconds are enough for.

    work = sum_i runs_i steps_i w,    w = 1 + (N/N_0)^2,    N = n_q + n_u + 2 n_c;    of n_b bodies w = 1 + n_b/2

The steps of each run are foreseen from its first PROBED ones. They are counted, not timed, so that a study takes the
same values on every machine and in every run, and a journal fits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from nonsmooth.errors import InvalidInput
from nonsmooth.studies.reference import Problem

PROBED = 2000  # chosen: steps
MOST_WORK = 2e6  # measured: steps that choose their length, of a system of few variables: some 2 to 5 us each
FIXED = 0.2  # measured: of such a step: one of fixed length
REFERENCE = 0.25  # chosen: of that work, for one run of the reference: it makes two
AT_LEAST = 1  # chosen: values


class Choice(NamedTuple):
    """The values that are taken, and a sentence on those that are not."""

    values: list[float]
    left_out: str = ""


def choose_affordable(
    problem: Problem, values: Sequence[float], make: Callable[[float], Any], runs: int,
    reference: Callable[[float], Any] | None = None,
) -> Choice:  # fmt: skip
    """The first of some values, from the cheapest to the dearest.

    Parameters
    ----------
    problem : Problem
    values : sequence of float
    make : callable
        The integrator with a value.
    runs : int
        Of each.
    reference : callable, optional
        The integrator that the study is compared with where a value is the last; it makes as many runs.
    """
    work = 0.0
    for k, value in enumerate(values):
        work += runs * work_of(problem, make(value))
        total = work if reference is None else work + runs * work_of(problem, reference(value))
        if total > MOST_WORK and k >= AT_LEAST:
            return Choice(list(values[:k]), f"values from {value:g} on would take long and are left out: give them")
    return Choice(list(values))


def require_affordable(problem: Problem, reference: Any) -> None:
    """Refuse a motion whose reference alone would take long: one with very many events."""
    most = int(REFERENCE * MOST_WORK / problem.step_cost)
    foreseen = problem.foreseen(reference, max_steps=most)
    if not foreseen.has_ended:
        t, t_end = problem.span[0] + foreseen.part * (problem.span[1] - problem.span[0]), problem.span[1]
        raise InvalidInput(
            f"the reference, {reference!r}, needs more than {most} steps: it came to t = {t:.6g} s of {t_end:g} s; end "
            "the motion earlier, or say with stiffness= that you will wait, or give a reference="
        )


def work_of(problem: Problem, integrator: Any) -> float:
    """Of one run; none where it is refused, with a reason that its cell will tell."""
    try:
        steps = problem.foreseen(integrator, max_steps=PROBED).steps
    except InvalidInput:
        return 0.0
    return steps * problem.step_cost * (1.0 if integrator.chooses_steps else FIXED)
