"""A model function that raises or writes NaN is named with its time, whatever it is; what was computed is kept."""

import math

import numba
import numpy as np
import pytest

import nonsmooth as ns
from tests.systems import BLOCK, PointMass, ball, block


def nothing(t, q, p, out):
    out[:] = 0.0


def nothing_either(t, q, u, p, out):
    out[:] = 0.0


FUNCTIONS = {  # that every step calls
    **BLOCK, "surface_velocity": nothing, "gap_rate": nothing, "stiffness": nothing_either, "damping": nothing_either,
}  # fmt: skip


def writes_nan(function, is_fast):
    """The function, which writes NaN from t = 0.05 s on."""
    good = numba.njit(function) if is_fast else function

    def with_u(t, q, u, p, out):
        good(t, q, u, p, out)
        if t > 0.05:
            out[:] = math.nan

    def without_u(t, q, p, out):
        good(t, q, p, out)
        if t > 0.05:
            out[:] = math.nan

    return with_u if function.__code__.co_argcount == 5 else without_u


def raises(function, is_fast):
    """The function, which raises from t = 0.05 s on."""
    good = numba.njit(function) if is_fast else function

    def with_u(t, q, u, p, out):
        if t > 0.05:
            raise ValueError("the table ends at 0.05 s")
        good(t, q, u, p, out)

    def without_u(t, q, p, out):
        if t > 0.05:
            raise ValueError("the table ends at 0.05 s")
        good(t, q, p, out)

    return with_u if function.__code__.co_argcount == 5 else without_u


def sliding_block(**changes):
    return block(ns.Contact(mu=0.1), **(FUNCTIONS | changes))


def run(system, **options):
    integrator = ns.MoreauJean(dt=1e-3)
    return ns.simulate(system, (0, 0.1), [0.0, 0.0], [1.0, 0.0], integrator=integrator, **options)


@pytest.mark.upkeep
@pytest.mark.parametrize("breaks", [writes_nan, raises])
@pytest.mark.parametrize(
    ("name", "is_fast"), [*((name, False) for name in FUNCTIONS), ("force", True), ("gap", True), ("tangent", True)]
)
def test_the_function_that_fails_is_named_with_its_time(name, breaks, is_fast, monkeypatch):
    if not is_fast:
        monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    with pytest.raises(ns.ModelFunctionError) as failure:
        run(sliding_block(**{name: breaks(FUNCTIONS[name], is_fast)}))
    said = f"{name} wrote nan" if breaks is writes_nan else f"{name} raised ValueError: the table ends at 0.05 s"
    assert said in str(failure.value) and "t = 0.0" in str(failure.value)
    solution = failure.value.solution
    assert solution.stats.is_compiled == is_fast
    assert solution.status == ns.Status.NOT_FINITE and abs(solution.t[-1] - 0.05) <= 1.5e-3
    assert np.isfinite(solution.q).all() and np.isfinite(solution.u).all()
    assert math.isclose(failure.value.t, solution.t[-1])


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_index_out_of_range_is_refused_before_compiled_code_would_write_there(name, monkeypatch):
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")  # spares the compilation: the refusal comes before any step
    is_with_u = FUNCTIONS[name].__code__.co_argcount == 5

    def with_u(t, q, u, p, out):
        out[2] = 1.0

    def without_u(t, q, p, out):
        out[2] = 1.0

    with pytest.raises(ns.InvalidInput, match=rf"{name} raised IndexError: .*, at t = 0 s; it writes an array"):
        run(sliding_block(**{name: with_u if is_with_u else without_u}))


@pytest.mark.upkeep
def test_a_misspelt_parameter_is_refused_with_the_name_of_the_function():
    def misspelt(t, q, u, p, h):
        h[1] = -p.mm * p.g

    with (
        pytest.warns(ns.InterpretedWarning, match="misspelt"),
        pytest.raises(ns.InvalidInput, match="force raised Attr"),
    ):
        run(sliding_block(force=misspelt))


def test_mass_that_loses_definiteness_during_a_run_fails_with_time_state_and_past():
    def shrinking(t, q, p, M):
        M[0, 0] = p.m * (0.05 - t)
        M[1, 1] = p.m

    with pytest.raises(ns.StepFailure, match=r"not positive definite.*stopped at t = 0\.05.*q = \[") as failure:
        run(sliding_block(mass=shrinking))
    solution = failure.value.solution
    assert solution.status == ns.Status.MASS_NOT_POSITIVE
    assert abs(solution.t[-1] - 0.05) < 1.5e-3 and len(solution.t) == solution.stats.steps + 1


FALL = PointMass(m=2.0)  # from 0.4 m
EVERY_METHOD = [ns.EventDriven(), ns.Adaptive(), ns.Penalty(stiffness=1e4), ns.MoreauJean(1e-3)]


def shaken_until(t, q, u, p, h):
    """Weight and 20 N cos(200 t), which keeps steps short, until 2.5 s."""
    h[0] = math.nan if t > 2.5 else 20.0 * math.cos(200.0 * t) - p.m * p.g


@pytest.mark.parametrize("rows", [{"t_eval": [0.0, 5.0]}, {"every": 1000}], ids=["at times", "of steps"])
@pytest.mark.parametrize("integrator", EVERY_METHOD)
def test_impulses_since_the_last_record_are_those_of_the_state_that_a_run_failed_at(integrator, rows):
    """A ball bounces until its force is no number any more: m u = P - m g t + (20/200) sin(200 t)."""
    falling = ball(ns.Contact(e_N=0.9), FALL, force=shaken_until)
    with pytest.raises(ns.ModelFunctionError) as failure:
        ns.simulate(falling, (0, 5.0), [0.4], [0.0], integrator=integrator, **rows)
    sol, weight = failure.value.solution, FALL.m * FALL.g
    t, bounces = sol.t[-1], sol.P_N.sum()
    assert 2.4 < t < 2.5 + 1e-6 and bounces > weight
    tolerance = 20.0 * 0.1**2 * 2.5 if isinstance(integrator, ns.MoreauJean) else 1e-5  # (h omega)^2 of 20 N in 2.5 s
    assert abs(FALL.m * sol.u[-1, 0] - (bounces - weight * t + 0.1 * math.sin(200.0 * t))) < tolerance
