"""Hard cases by every integrator that claims them: each figure stays within the bound that was derived for it."""

import math
import warnings

import pytest

import nonsmooth as ns
from benchmarks import stress, stress_contacts, stress_motions, stress_units
from benchmarks.stress_figures import run

# What is open, as docs/benchmarks/stress.md shows it: a hundred contacts that share the load of fifty boxes, the top
# one a million times heavier: the steps of Adaptive get too short to come to the end within the time of a case.
OPEN = {
    ("stack of 50, masses 1 to 1e+06, at rest", "Adaptive"),
}


def check(case):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ns.InitialStateWarning)
        outcomes = [run(case, method) for method in case.methods]
    failed = [outcome for outcome in outcomes if not outcome.holds]
    known = {method for name, method in OPEN if name == case.name}
    assert outcomes
    assert {outcome.method.split()[0] for outcome in failed} == known, "\n".join(stress.row(o) for o in failed)


def as_long_as_it_takes(case):
    """A case as a parameter, slow where it takes half a minute."""
    return pytest.param(case, marks=pytest.mark.slow if case.name in HALF_A_MINUTE else ())


HALF_A_MINUTE = {"stack of 10, masses 1 to 1e+06, at rest", "stack of 50, masses 1 to 1e+03, at rest"}
GROUPS = (stress_contacts.cases, stress_motions.cases)
SMALL = [case for cases in GROUPS for case in cases(False)]
NAMES = {case.name for case in SMALL}
LONG = [case for cases in GROUPS for case in cases(True) if case.name not in NAMES]


@pytest.mark.upkeep
@pytest.mark.parametrize("case", [as_long_as_it_takes(case) for case in SMALL], ids=lambda case: case.name)
@pytest.mark.filterwarnings("ignore::nonsmooth.ToleranceWarning")  # a motion of micrometres, within its bound
def test_every_figure_is_within_its_bound(case):
    check(case)


@pytest.mark.slow
@pytest.mark.parametrize("case", LONG, ids=lambda case: case.name)
def test_every_figure_of_a_long_case_is_within_its_bound(case):
    check(case)


@pytest.mark.filterwarnings("ignore::nonsmooth.ToleranceWarning")  # what rests moves by micrometres at most
@pytest.mark.parametrize(
    "case",
    [
        as_long_as_it_takes(make(50, m))
        for make, m in ((stress_contacts.tower_at_rest, 1e6), (stress_contacts.stack_at_rest, 1e3))
    ],
    ids=lambda case: case.name,
)
def test_what_rests_under_heavy_bodies_takes_few_steps(case):
    """Rows of heavy bodies are small, not redundant, and the rounding of friction far below its limit is no motion."""
    sol = ns.simulate(case.system, (0.0, stress_contacts.REST), *case.state, integrator=ns.Adaptive(rtol=1e-8))
    assert sol.success and sol.stats.steps <= 20


@pytest.mark.parametrize("trial", list(stress_units.trials()), ids=lambda trial: f"{trial.name}-{trial.integrator!r}")
def test_motion_is_the_same_in_other_units(trial):
    outcome = stress_units.compare(trial)
    assert outcome.holds, stress.row(outcome)


def test_a_figure_beyond_its_bound_or_missing_is_a_failure():
    case = SMALL[0]
    outcome = run(case, case.methods[0])
    assert outcome.holds
    for k in range(5):
        if math.isnan(outcome.bounds[k]):
            continue
        lower = outcome.bounds[:k] + (-1.0,) + outcome.bounds[k + 1 :]
        assert not outcome._replace(bounds=lower).holds
    assert not outcome._replace(error=math.nan).holds
    assert not outcome._replace(failure="NO_SOLUTION at 0 s").holds
