"""A friction law of the user's, mu(v, p): closed forms, the built-in law that it repeats, and a belt beside SciPy."""

import math
import warnings
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from tests.systems import block

SLIDING = [ns.MoreauJean(dt=1e-3), ns.EventDriven(), ns.Adaptive(), ns.Penalty(stiffness=1e6, damping_ratio=0.5)]
of_all = pytest.mark.parametrize("integrator", SLIDING, ids=lambda method: type(method).__name__)


class Belt(NamedTuple):
    m: float = 1.0
    k: float = 1.0
    N: float = 1.0
    mu: float = 1.0
    delta: float = 3.0
    vb: float = 0.2


def leine(v, p):
    return p.mu / (1.0 + p.delta * v)


def mass(t, q, p, M):
    M[0, 0] = p.m


def spring(t, q, u, p, h):
    h[0] = -p.k * q[0]


def tangent(t, q, p, W_F):
    W_F[0, 0, 0] = 1.0


def belt_speed(t, q, p, w_F):
    w_F[0, 0] = -p.vb


def pressure(t, q, u, p, N):
    N[0] = p.N


def belt(law, p=None):
    return ns.System(
        coordinates=[("x", "m")], mass=mass, force=spring, tangent=tangent, surface_velocity=belt_speed,
        normal_force=pressure, contacts=[ns.Contact(mu=law, normal_force=True, name="belt")],
        parameters=p or Belt(),
    )  # fmt: skip


class Slope(NamedTuple):
    m: float = 1.0
    g: float = 9.81
    mu: float = 0.4
    delta: float = 3.0


def slider(law, p=None):
    return block(ns.Contact(mu=law, name="foot"), parameters=p or Slope())


def speed_left(t, v=1.0, mu=0.4):
    """Of a block that slides under mu/(1 + 3 v): v + 3/2 v^2 falls by mu g t."""
    return (math.sqrt(1.0 + 6.0 * (v + 1.5 * v * v - mu * 9.81 * t)) - 1.0) / 3.0


@of_all
def test_a_block_slides_as_the_integral_of_its_law(integrator):
    sol = ns.simulate(slider(ns.Friction(leine)), (0, 0.2), [0, 0], [1.0, 0.0], integrator=integrator)
    assert sol.u[-1, 0] == pytest.approx(speed_left(0.2), abs=1e-9)  # springs of 1e6 N/m: m g/k m/s of the start


@of_all
def test_a_law_without_parameters_takes_the_speed_alone(integrator):
    sol = ns.simulate(slider(ns.Friction(lambda v: 0.4 / (1 + 3 * v))), (0, 0.2), [0, 0], [1.0, 0.0],
                      integrator=integrator)  # fmt: skip
    assert sol.u[-1, 0] == pytest.approx(speed_left(0.2), abs=1e-9)


def times_of_the_belt(p, rtol=1e-11):
    """Beginning of the slips and ends, by SciPy between the events: it sticks while k |x| <= mu(0) N."""
    times, t, x = [], 0.0, 0.0
    for _ in range(3):
        t += (p.mu * p.N / p.k - x) / p.vb
        times.append(t)

        def rates(_, y):
            v = y[1] - p.vb  # below zero: it slips back, and friction drives it on
            return y[1], (-p.k * y[0] + p.N * leine(abs(v), p)) / p.m

        def catches(_, y):
            return y[1] - p.vb

        catches.terminal, catches.direction = True, 1
        first = 1e-6  # s: off the point where it has just begun, to third order
        force = p.N * leine(0.0, p)
        jerk = (-p.k * p.vb) / p.m
        x_0 = force / p.k + p.vb * first
        y = solve_ivp(rates, (0, 20), [x_0, p.vb + 0.5 * jerk * first**2], rtol=rtol, atol=1e-13, method="DOP853",
                      events=catches)  # fmt: skip
        t += first + y.t_events[0][0]
        x = y.y_events[0][0][0]
        times.append(t)
    return np.array(times)


@pytest.mark.parametrize("integrator", [ns.EventDriven(rtol=1e-10, atol=1e-12), ns.Adaptive(rtol=1e-9, atol=1e-11),
                                        ns.MoreauJean(dt=1e-3)], ids=lambda method: type(method).__name__)  # fmt: skip
def test_stick_and_slip_of_a_belt_under_leines_law_have_the_times_of_scipy(integrator):
    exact = times_of_the_belt(Belt())
    sol = ns.simulate(belt(ns.Friction(leine)), (0, exact[-1] + 0.5), [0.0], [0.2], integrator=integrator)
    found = np.array([event.t for event in sol.events])
    assert len(found) == 6
    # the start 1e-6 s behind the slip's is 1e-6^2 off; a step of MoreauJean is 1e-3 s
    tolerance = {"EventDriven": 1e-5, "Adaptive": 1e-5, "MoreauJean": 1e-2}[type(integrator).__name__]
    np.testing.assert_allclose(found, exact, rtol=0, atol=tolerance)


def stribeck(v, p):
    return 0.3 + 0.2 * math.exp(-v / 0.1) + 0.01 * v


BUILT_IN = ns.Stribeck(0.5, 0.3, 0.1, 1.0, 0.01)


@of_all
def test_a_built_in_law_typed_again_gives_the_same_motion(integrator):
    def run(law):
        return ns.simulate(belt(law), (0, 12.0), [0.0], [0.2], integrator=integrator)

    ours, own = run(BUILT_IN), run(ns.Friction(stribeck))
    np.testing.assert_allclose(own(np.linspace(0, 12, 50)).q, ours(np.linspace(0, 12, 50)).q, rtol=0, atol=1e-9)
    assert len(own.events) == len(ours.events) >= 2


def test_two_contacts_have_two_laws_and_nested_parameters_and_arrays():
    class Spring(NamedTuple):
        c: float = 3.0

    class P(NamedTuple):
        mu: np.ndarray
        spring: Spring = Spring()

    def two(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.0

    def free(t, q, u, p, h):
        h[0] = 0.0

    def along(t, q, p, W_F):
        W_F[0, 0, 0] = W_F[1, 0, 1] = 1.0

    def load(t, q, u, p, N):
        N[0] = N[1] = 9.81

    made = ns.System(
        n_q=2, mass=two, force=free, tangent=along, normal_force=load, parameters=P(np.array([0.4, 0.2])),
        contacts=[ns.Contact(mu=ns.Friction(lambda v, p: p.mu[0] / (1 + p.spring.c * v)), normal_force=True),
                  ns.Contact(mu=ns.Friction(lambda v, p: p.mu[1] / (1 + p.spring.c * v)), normal_force=True)],
    )  # fmt: skip
    for integrator in SLIDING[:3]:
        sol = ns.simulate(made, (0, 0.2), [0, 0], [1.0, 1.0], integrator=integrator)
        np.testing.assert_allclose(sol.u[-1], [speed_left(0.2), speed_left(0.2, mu=0.2)], rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    "integrator", [ns.MoreauJean(dt=1e-3), ns.Adaptive()], ids=lambda method: type(method).__name__
)
def test_a_sweep_of_its_parameters_has_the_closed_form_in_every_cell(integrator):
    task = ns.RunTask(slider(ns.Friction(leine)), "final_state", t_span=(0, 0.2), integrator=integrator,
                      state=([0, 0], [1.0, 0.0]))  # fmt: skip
    mu = np.linspace(0.1, 0.4, 7)
    found = ns.sweep(task, {"mu": mu})
    np.testing.assert_allclose(found["u"].values[:, 0], [speed_left(0.2, mu=value) for value in mu], rtol=0, atol=1e-9)


def test_classify_sees_the_coefficient_at_the_present_speed():
    found = ns.classify(slider(ns.Friction(leine)), 0.0, [0, 0], [1.0, 0.0])
    assert found.solutions[0].la_F[0] == pytest.approx(-9.81 * 0.1, rel=1e-12)


def test_steady_sliding_has_the_slope_of_the_law():
    """Re s = -(c + N mu')/(2 m), mu' = -3 mu/(1 + 3 v)^2, as of the built-in law typed again."""
    own, ours = (ns.linearise(belt(law)) for law in (ns.Friction(stribeck), BUILT_IN))
    np.testing.assert_allclose(own.eigenvalues, ours.eigenvalues, rtol=1e-12)
    slope = -3.0 / (1 + 3 * 0.2) ** 2
    np.testing.assert_allclose(ns.linearise(belt(ns.Friction(leine))).eigenvalues.real, -slope / 2, rtol=1e-9)


def test_interpreted_and_compiled_runs_have_the_same_bits(monkeypatch):
    def runs():
        return [ns.simulate(belt(ns.Friction(leine)), (0, 6.0), [0.0], [0.2], integrator=method)
                for method in (ns.MoreauJean(dt=1e-2), ns.Adaptive(rtol=1e-5, atol=1e-7))]  # fmt: skip

    compiled = runs()
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    for fast, slow in zip(compiled, runs(), strict=True):
        assert fast.stats.is_compiled and not slow.stats.is_compiled
        assert fast.q.tobytes() == slow.q.tobytes() and fast.u.tobytes() == slow.u.tobytes()


def test_a_law_that_numba_refuses_runs_in_the_interpreter_with_a_warning():
    table = {"mu": 0.4}

    def odd(v, p):
        return sum(value for value in table.values()) / (1 + 3 * v)

    with pytest.warns(ns.InterpretedWarning, match="odd"):
        sol = ns.simulate(slider(ns.Friction(odd)), (0, 0.02), [0, 0], [1.0, 0.0], integrator=ns.MoreauJean(dt=1e-3))
    assert sol.u[-1, 0] == pytest.approx(speed_left(0.02), abs=1e-12)


FACTOR = 1.0


def scaled(v, p):
    return FACTOR * p.mu / (1 + 3 * v)


def test_a_global_that_the_law_reads_is_read_anew(monkeypatch):
    made = slider(ns.Friction(scaled))
    first = ns.simulate(made, (0, 0.1), [0, 0], [1.0, 0.0], integrator=ns.MoreauJean(dt=1e-3))
    monkeypatch.setitem(globals(), "FACTOR", 0.5)
    second = ns.simulate(made, (0, 0.1), [0, 0], [1.0, 0.0], integrator=ns.MoreauJean(dt=1e-3))
    assert first.u[-1, 0] == pytest.approx(speed_left(0.1), abs=1e-12)
    assert second.u[-1, 0] == pytest.approx(speed_left(0.1, mu=0.2), abs=1e-12)


@pytest.mark.upkeep
@pytest.mark.parametrize(
    "integrator", [ns.MoreauJean(dt=1e-3), ns.Adaptive()], ids=lambda method: type(method).__name__
)
def test_a_run_that_was_stopped_goes_on_to_the_same_bits_and_another_law_is_another_run(tmp_path, integrator):
    made, start = belt(ns.Friction(leine)), ([0.0], [0.2])
    whole = ns.simulate(made, (0, 12.0), *start, integrator=integrator, checkpoint=tmp_path / "whole")
    ns.simulate(made, (0, 12.0), *start, integrator=integrator, checkpoint=tmp_path / "cut", max_steps=60,
                on_failure="return")  # fmt: skip
    with pytest.raises(ns.InvalidInput, match="friction law of contact 0"):
        ns.simulate(belt(ns.Friction(stribeck)), (0, 12.0), *start, integrator=integrator, resume=tmp_path / "cut")
    again = ns.simulate(made, (0, 12.0), *start, integrator=integrator, resume=tmp_path / "cut")
    assert again.q.tobytes() == whole.q.tobytes()


@of_all
@pytest.mark.parametrize(("law", "said"), [(lambda v, p: 0.4 - v, "is -0"), (lambda v, p: 0.4 if v < 0.5 else math.nan,
                                                                            "is nan")])  # fmt: skip
def test_a_law_that_becomes_negative_or_no_number_ends_the_run_with_its_name(integrator, law, said):
    with pytest.raises(ns.StepFailure, match=f"the friction law of foot {said}.* must be a finite number >= 0"):
        ns.simulate(slider(ns.Friction(law)), (0, 0.2), [0, 0], [1.0, 0.0], integrator=integrator)


@pytest.mark.parametrize("law, said", [
    (lambda v, p: -0.1, r"the friction law of foot must be a finite number >= 0; got mu\(0\) = -0.1"),
    (lambda v, p: math.nan, "got mu.0. = nan"),
    (lambda v, p: p.nothing, "the friction law of foot raised AttributeError"),
    (lambda v, p: None, "the friction law of foot raised TypeError"),
])  # fmt: skip
def test_a_law_without_a_number_at_rest_is_refused_when_the_system_is_made(law, said):
    with pytest.raises(ns.InvalidInput, match=said):
        slider(ns.Friction(law))


@pytest.mark.parametrize("wrong", [0.3, "mu", None, lambda: 0.3, lambda t, q, p: 0.3])
def test_what_is_no_law_is_refused(wrong):
    with pytest.raises(ns.InvalidInput, match="a friction law must"):
        ns.Friction(wrong)


def test_a_law_without_a_jump_at_rest_does_not_stick():
    def smooth(v, p):
        return p.mu * math.tanh(v / 1e-2)

    sol = ns.simulate(slider(ns.Friction(smooth)), (0, 0.28), [0, 0], [1.0, 0.0], integrator=ns.MoreauJean(dt=1e-4))
    assert sol.mode[-1, 0] == ns.ContactMode.SLIDE and 0.0 < sol.u[-1, 0] < 1e-5


def test_no_problem_with_the_addresses_of_a_law_leaves_the_process(tmp_path):
    with warnings.catch_warnings(), pytest.raises(ns.StepFailure) as caught:
        warnings.simplefilter("ignore")
        ns.simulate(slider(ns.Friction(lambda v, p: 0.4 - v)), (0, 0.2), [0, 0], [1.0, 0.0],
                    integrator=ns.MoreauJean(dt=1e-3))  # fmt: skip
    assert caught.value.problem is None
