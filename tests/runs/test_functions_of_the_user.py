"""Whatever a function of the user's raises, also what is no Exception, ends in a typed failure that says it."""

import dataclasses
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall

BALL = BouncingBall(e=0.5)
START = BALL.state(height=1.0)
INTEGRATORS = [ns.MoreauJean(1e-3), ns.EventDriven(), ns.Penalty(1e5, damping_ratio=0.1)]


class Gone(BaseException):
    """No Exception, as SystemExit is none."""


def raising(error, after=0):
    """A function that raises from some call on."""
    calls = []

    def function(*arguments):
        calls.append(arguments)
        if len(calls) > after:
            raise error
        return 1.0

    return function


def event_that_raises(error):
    def event(t, q, u):
        if t > 0.5:
            raise error
        return 1.0

    return event


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda integrator: type(integrator).__name__)
@pytest.mark.parametrize(
    ("error", "said"),
    [(Gone("it left\nand took the rest"), "Gone: it left and took the rest"), (SystemExit(3), "SystemExit: 3")],
)
def test_an_event_function_that_raises_anything_ends_the_run_with_its_words(integrator, error, said):
    with pytest.raises(ns.EventFunctionError, match=said) as failure:
        ns.simulate(BALL, (0, 2), *START, integrator=integrator, events=event_that_raises(error))
    assert 0.5 < failure.value.t < 0.7 and failure.value.__cause__ is error and "\n" not in str(failure.value)


def test_ctrl_c_in_an_event_function_is_still_ctrl_c():
    events = event_that_raises(KeyboardInterrupt())
    found = ns.simulate(BALL, (0, 2), *START, integrator=ns.EventDriven(), events=events)
    assert found.status == ns.Status.INTERRUPTED


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda integrator: type(integrator).__name__)
@pytest.mark.parametrize("error", [ValueError("no terminal"), Gone("no terminal"), SystemExit("no terminal")])
def test_a_progress_function_that_raises_ends_the_run_with_what_was_computed(integrator, error):
    with pytest.raises(
        ns.ProgressError, match=r"progress function raised \w+: no terminal; stopped at t = "
    ) as failure:
        ns.simulate(BALL, (0, 1), *START, integrator=integrator, progress=raising(error))
    assert failure.value.__cause__ is error and isinstance(failure.value, ns.StepFailure)
    assert len(failure.value.solution.t) > 1 and np.isfinite(failure.value.solution.q).all()
    found = ns.simulate(BALL, (0, 1), *START, integrator=integrator, progress=raising(error), on_failure="return")
    assert found.status == ns.Status.PROGRESS_FAILED and not found.success


def test_a_run_whose_progress_failed_goes_on_from_its_checkpoint(tmp_path):
    task = {"integrator": ns.MoreauJean(1e-4), "checkpoint": tmp_path / "run", "checkpoint_every": 0.0}
    with pytest.raises(ns.ProgressError):
        ns.simulate(BALL, (0, 2), *START, **task, progress=raising(ValueError("no"), after=1))
    whole = ns.simulate(BALL, (0, 2), *START, integrator=ns.MoreauJean(1e-4))
    found = ns.simulate(BALL, (0, 2), *START, **task, resume=tmp_path / "run")
    assert found.success and (found.q == whole.q).all()


def test_the_progress_function_of_a_sweep_is_told_to_raise():
    task = ns.RunTask(BALL, t_span=(0, 0.01), integrator=ns.MoreauJean(1e-3))
    with pytest.raises(ns.InvalidInput, match="the progress function raised ValueError: no terminal"):
        ns.sweep(task, {"e": [0.2, 0.5]}, progress=raising(ValueError("no terminal")))


def mass(t, q, p, M):
    M[0, 0] = 1.0


@pytest.mark.parametrize("after", [0.0, 0.005])
def test_a_model_function_that_leaves_the_program_is_a_failure_of_the_model(after, monkeypatch):
    def force(t, q, u, p, h):
        if t >= after:
            raise SystemExit("the table ends")

    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    system = ns.System(n_q=1, mass=mass, force=force)
    failure = ns.InvalidInput if after == 0.0 else ns.ModelFunctionError
    with pytest.raises(failure, match="the model function force raised RuntimeError: SystemExit: the table ends"):
        ns.simulate(system, (0, 0.01), [0.0], [0.0], integrator=ns.MoreauJean(1e-3))


# Parameters that no function can take --------------------------------------------------------------------------------


class Whole(NamedTuple):
    m: float = 1.0
    n: int = 10**400


class Complex(NamedTuple):
    m: complex = np.complex128(1.0 + 2.0j)


@dataclasses.dataclass(frozen=True)
class Private:
    m: float = 1.0
    _k: float = 2.0


@pytest.mark.parametrize(
    ("parameters", "message"),
    [(Whole(), r"the parameter n must be a number; got 1000000"),
     (Private(), r"a parameter's name must not begin with an underscore; got _k"),
     (Complex(), r"the parameter m must be a number; got "), (Whole, r"got the class Whole: call it first")],
)  # fmt: skip
def test_parameters_that_no_function_can_take_are_refused_by_name(parameters, message):
    with pytest.raises(ns.InvalidInput, match=message):
        ns.System(n_q=1, mass=mass, force=lambda t, q, u, p, h: None, parameters=parameters)
    if parameters is not Whole:
        with pytest.raises(ns.InvalidInput, match="must be a number"):
            ns.System(n_q=1, mass=mass, force=lambda t, q, u, p, h: None, parameters=Whole(n=3)).with_parameters(n=1j)
