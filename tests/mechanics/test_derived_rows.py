"""Rows that a model leaves out are derived from its gap: to rounding, compiled and interpreted, in every tool."""

import dataclasses
import math
import pickle
from typing import NamedTuple

import numba
import numpy as np
import pytest

import nonsmooth as ns
from models import (
    BilateralRod,
    InclinedBlock,
    LeadScrew,
    PainleveRod,
    RockingBlock,
    SliderCrank,
    SpragSlip,
    WallPendulum,
    Woodpecker,
)
from nonsmooth.jit import call_model, kernel
from nonsmooth.mechanics.compiled import model_of
from nonsmooth.mechanics.system import GAP_RATE, NORMAL
from nonsmooth.numerics import dual
from nonsmooth.numerics.continuation import CannotContinue, continued

EPS = np.finfo(float).eps
MODELS = [BilateralRod(l=1.4), InclinedBlock(alpha=0.4), LeadScrew(), PainleveRod(l=1.4), RockingBlock(), SliderCrank(),
          SpragSlip(R=3.0), WallPendulum(th_w=0.2), Woodpecker()]  # fmt: skip


@kernel
def evaluate(model, which, t, q, u, p, out):
    return call_model(model, which, t, q, u, p, out)


def compiled_rows(system, which, t, q):
    out = np.zeros(system.shape_of(which))
    assert evaluate(model_of(system).handle, which, t, q, q, system.p, out.reshape(-1))
    return out


def without_rows(model, **changes):
    return dataclasses.replace(model.system(), normal=None, row_rates=None, **changes)


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_derived_rows_are_those_written_by_hand_to_rounding(model):
    given, rng = model.system(), np.random.default_rng(3)
    left_out = without_rows(model)
    for _ in range(5):
        q = rng.uniform(0.2, 0.9, given.n_q)
        expected, found = (system.evaluate(NORMAL, 0.3, q, q) for system in (given, left_out))
        assert np.abs(found - expected).max() <= 8 * EPS * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize("model", [RockingBlock(), SliderCrank()], ids=lambda model: model.name)
def test_derived_rows_have_the_same_bits_compiled_and_interpreted(model):
    system, q = without_rows(model), np.array([0.3, 0.7, 0.4])
    assert (compiled_rows(system, NORMAL, 0.0, q) == system.evaluate(NORMAL, 0.0, q, q)).all()


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
@pytest.mark.parametrize(
    ("model", "state", "t_end"),
    [(PainleveRod(mu=0.3), {"th": 1.1, "thdot": 3.0, "slip": -0.7}, 0.5),
     (RockingBlock(mu=0.5), {"tilt": 0.1, "tilt_rate": 0.5}, 1.0), (SpragSlip(), {}, 1.0),
     (SliderCrank(), {}, 0.1), (BilateralRod(), {}, 0.3)],
    ids=["rod", "rocking block", "sprag-slip", "slider-crank", "bilateral rod"],
)  # fmt: skip
def test_located_events_at_1e_10_are_those_of_the_hand_written_rows(model, state, t_end):
    """The runs differ by the rounding of the rows, and of their rates by differences: 1e-11 of them."""
    start = model.state(**state)
    given, left_out = (
        ns.simulate(system, (0, t_end), *start, integrator=ns.EventDriven(1e-10, 1e-12))
        for system in (model.system(), without_rows(model))
    )
    assert len(given.events) == len(left_out.events) and given.success
    size = np.abs(given.q).max() + np.abs(given.u).max()
    assert np.abs(given.q[-1] - left_out.q[-1]).max() < 1e-11 * size
    assert np.abs(given.u[-1] - left_out.u[-1]).max() < 1e-10 * size


# Gaps of every form ---------------------------------------------------------------------------------------------------


class P(NamedTuple):
    m: float = 2.0  # mass [kg]
    R: float = 0.4  # radius [m]
    n: float = 3.0  # exponent
    w: float = 7.0  # frequency [1/s]


TABLE = np.array([0.0, 0.01, 0.03, 0.02, 0.05, 0.04])


def mass(t, q, p, M):
    M[0, 0] = M[1, 1] = p.m


def force(t, q, u, p, h):
    h[1] = -9.81 * p.m


def wave(x, p):
    return 0.1 * math.sin(3.0 * x) / (1.0 + x * x)


@numba.njit
def quick(x):
    return math.exp(-x * x)


def smooth(t, q, p, g_N):
    g_N[0] = math.sqrt(q[0] * q[0] + (q[1] - 1.0) ** 2) - p.R + wave(q[0], p) * math.cos(p.w * t) ** p.n - quick(q[0])
    g_N[1] = math.atan2(q[1], 2.0 + q[0]) + math.hypot(q[0], q[1]) / 3 - math.log(2.0 + q[0]) * math.tanh(q[1])


def branches(t, q, p, g_N):
    for i in range(2):
        x = q[0] - 0.2 * i
        if x > 0.3 or q[1] < -5.0:
            g_N[i] = q[1] - 0.3 * x
        elif -0.1 <= x < 0.0:
            g_N[i] = q[1] - x**2
        else:
            g_N[i] = max(q[1], 0.1 * q[1], q[0]) - 0.5 * abs(x)
        g_N[i] /= 1.0 + p.R * min(q[1], 2.0) ** 2


def tabulated(t, q, p, g_N):
    s = q[0] / 0.25
    k = int(s)
    g_N[0] = q[1] - (TABLE[k] + (TABLE[k + 1] - TABLE[k]) * (s - k))
    g_N[1] = math.copysign(q[1], -1.0) + float(q[0]) * math.pow(2.0 + q[0], q[1])


def closed_over(scale):
    def floor(t, q, p, g_N):
        """A floor with

        a docstring of several lines."""
        g_N[0] = scale * q[1] + wave(q[0], p)
        g_N[1] = q[1] - p.R * np.sin(p.w * t + q[0])

    return floor


EXOTIC = lambda t, q, p, g_N: g_N.__setitem__(slice(None), q[1] - 0.1 * np.cos(3 * q[0] + t))  # noqa: E731


def system_of(gap, **more):
    return ns.System(n_q=2, mass=mass, force=force, gap=gap, contacts=[ns.Contact()] * 2, parameters=P(), **more)


def differences(f, x, step=2.0**-9):
    """df/dx by differences of eighth order, written down anew; f is smooth within 4 steps."""
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
    return sum(c * (f(x + k * step) - f(x - k * step)) for k, c in weights.items()) / step


@pytest.mark.upkeep
@pytest.mark.parametrize("gap", [smooth, branches, tabulated, closed_over(1.7), numba.njit(smooth)])
@pytest.mark.parametrize("q", [(0.35, 0.6), (0.21, 0.9), (0.9, 0.4), (0.05, 0.7)])
def test_gaps_with_branches_tables_powers_and_helpers_are_differentiated_to_rounding(gap, q):
    system, q, t = system_of(gap), np.array(q), 0.3
    assert system.functions[NORMAL].__name__ == "dual_normal"
    found, source = system.evaluate(NORMAL, t, q, q), getattr(gap, "py_func", gap)

    def value(t, q):
        g_N = np.zeros(2)
        source(t, q, system.unpacked, g_N)
        return g_N

    for j, e in enumerate(np.eye(2)):
        expected = differences(lambda s, e=e: value(t, q + s * e), 0.0)
        assert np.abs(found[:, j] - expected).max() < 1e-11
    assert (compiled_rows(system, NORMAL, t, q) == found).all()
    if GAP_RATE in system.functions:
        rate = system.evaluate(GAP_RATE, t, q, q)
        assert np.abs(rate - differences(lambda s: value(t + s, q), 0.0)).max() < 1e-10
        assert (compiled_rows(system, GAP_RATE, t, q) == rate).all()


def test_what_cannot_be_rewritten_is_differentiated_by_differences_of_eighth_order():
    made = {}
    exec("def gap(t, q, p, g_N):\n    g_N[0] = q[1] - 0.3 * q[0] ** 3\n    g_N[1] = q[1]", made)
    q = np.array([0.3, 0.8])
    for gap, expected in ((made["gap"], [[-0.081, 1.0], [0.0, 1.0]]), (EXOTIC, [[0.3 * math.sin(0.9), 1.0]] * 2)):
        system = system_of(gap)
        assert system.functions[NORMAL].__name__ == "difference_normal"
        found = system.evaluate(NORMAL, 0.0, q, q)
        assert np.abs(found - expected).max() < 2e-12  # rounding: 1e-16 of the gap over 2^-11
    assert abs(system.evaluate(GAP_RATE, 0.0, q, q)[0] - 0.1 * math.sin(0.9)) < 2e-12


def whole(t, q, p, g_N):
    g_N[0] = q[1] - q[0] // 0.1


def unknown(t, q, p, g_N):
    g_N[0] = np.linalg.norm(q)


def by_keyword(t, q, p, g_N):
    g_N[0] = max(q[0], q[1], key=abs)


@pytest.mark.parametrize("function", [whole, unknown, by_keyword, EXOTIC, math.sin])
def test_what_is_not_known_is_not_rewritten(function):
    with pytest.raises(CannotContinue):
        continued(function)


def test_a_source_that_was_edited_since_it_was_read_is_not_taken(tmp_path, monkeypatch):
    file = tmp_path / "edited_model.py"
    file.write_text("def gap(t, q, p, g_N):\n    g_N[0] = q[0] * q[0]\n")
    monkeypatch.syspath_prepend(tmp_path)
    import edited_model

    assert continued(edited_model.gap)
    file.write_text("def gap(t, q, p, g_N):\n    g_N[0] = 3.0 * q[0]\n")
    with pytest.raises(CannotContinue, match="has changed since it was read"):
        continued(edited_model.gap)


@pytest.mark.parametrize("name", sorted(dual.OF_MATH))
def test_every_function_for_dual_numbers_has_its_value_and_its_derivative(name):
    real, made = getattr(math, name), dual.OF_MATH[name]
    x, step = 1.7 if name == "acosh" else 0.37, 2.0**-9
    if made.__code__.co_argcount == 1:
        z = complex(made(complex(x, 1e-30)))
        assert z.real == real(x) and abs(z.imag / 1e-30 - differences(real, x, step)) < 2e-12
        return
    for a, b in ((complex(x, 1e-30), 0.8), (0.8, complex(x, 1e-30))):
        z = made(a, b)
        expected = differences(lambda s, a=a, b=b: real(a.real + s * (a.imag > 0), b.real + s * (b.imag > 0)), 0.0)
        assert z.real == real(a.real, b.real) and abs(z.imag / 1e-30 - expected) < 2e-12


# In every tool -----------------------------------------------------------------------------------------------------


def test_stability_of_steady_sliding_is_that_of_the_hand_written_rows():
    given, left_out = (ns.linearise(system) for system in (SpragSlip(), without_rows(SpragSlip())))
    assert np.allclose(np.sort_complex(left_out.eigenvalues), np.sort_complex(given.eigenvalues), rtol=1e-9)


def test_a_limit_cycle_is_that_of_the_hand_written_rows():
    rod = SpragSlip.set_1(cth=0.5)
    given = ns.limit_cycle(rod)
    left_out = ns.limit_cycle(dataclasses.replace(rod.system(), normal=None), guess=rod.state(), duration=rod.t_end)
    assert abs(left_out.period - given.period) < 1e-9 * given.period
    assert abs(left_out.stick_duration - given.stick_duration) < 1e-7 * given.period


def test_a_system_with_derived_rows_crosses_to_another_process_and_has_one_identity():
    system = system_of(smooth)
    other = pickle.loads(pickle.dumps(system))
    assert other.functions[NORMAL] is system.functions[NORMAL]
    assert system.with_parameters(R=0.5).functions[NORMAL] is system.functions[NORMAL]
