"""Maps of paradoxes: regions of sprag-slip rod, rod and lead screw, against closed forms and single states."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BilateralRod, BouncingBall, LeadScrew, PainleveRod, RockingBlock, SelfLockingRod, SpragSlip
from models.sprag_slip import SOLUTIONS

NO_SOLUTION = -1


def test_regions_of_set_2_have_one_two_none_none_and_two_solutions():
    # SYSTEMS G: A0 .. A4 hold 1, 2, 0, 0, 2 solutions; 20,000 random states
    rod = SpragSlip()
    rng = np.random.default_rng(1)
    th, thdot = np.sort(rng.uniform(0.05, 1.52, 200)), np.sort(rng.uniform(-6.0, 6.0, 100))
    chart = ns.paradox_map(rod, th=th, thdot=thdot)
    region = rod.region(th[:, None], thdot[None, :])
    assert set(np.unique(region)) == {0, 1, 2, 3, 4}
    np.testing.assert_array_equal(chart.n_solutions, np.take(SOLUTIONS, region))
    np.testing.assert_array_equal(chart.kind, np.take(SOLUTIONS, region))  # the codes are the counts 0, 1, 2
    Lambda = rod.Lambda(th[:, None], thdot[None, :])
    np.testing.assert_allclose(chart.b, -Lambda / (rod.m * rod.I), rtol=1e-12, atol=1e-11)
    np.testing.assert_allclose(chart.gamma_F, -rod.v_t(th[:, None], thdot[None, :]), rtol=0, atol=1e-13)
    p = np.min([rod.reduced(th, branch).M for branch in (1, -1)], axis=0) / (rod.m * rod.I)
    np.testing.assert_allclose(chart.p, np.broadcast_to(p[:, None], chart.p.shape), rtol=1e-12, atol=1e-13)


def test_normal_forces_of_a_map_are_those_of_the_closed_form():
    rod = SpragSlip()
    th, thdot = np.linspace(0.1, 1.5, 23), np.linspace(-5.0, 5.0, 21)
    chart = ns.paradox_map(rod, th=th, thdot=thdot)
    for i, j in np.ndindex(len(th), len(thdot)):
        exact = rod.normal_forces(th[i], thdot[j])
        n = len(exact)
        assert sorted(chart.la_N.values[i, j, :n]) == pytest.approx(list(exact), rel=1e-9, abs=1e-9)
        assert np.isnan(chart.la_N.values[i, j, n:]).all() and (chart.modes.values[i, j, n:] == NO_SOLUTION).all()


def test_rod_is_paradoxical_above_its_critical_friction_only():
    rod = PainleveRod()
    th, mu = np.linspace(0.01, 1.56, 101), np.linspace(0.0, 3.0, 97)
    chart = ns.paradox_map(rod, th=th, mu=mu, thdot=5.0, slip=-1)
    critical = np.array([rod.critical_friction(angle) for angle in th])
    is_paradox = mu[None, :] > critical[:, None]
    b = np.array([rod.b(angle, 5.0) for angle in th])[:, None]
    expected = np.where(is_paradox, np.where(b > 0, 2, 0), 1)
    np.testing.assert_array_equal(chart.n_solutions, expected)
    assert {0, 1, 2} == set(np.unique(expected))
    mirrored = ns.paradox_map(rod, th=th, mu=mu, thdot=5.0, slip=1)
    assert (mirrored.n_solutions == 1).all()  # p < 0 needs the tip pushed ahead of the centre


@pytest.mark.parametrize(
    "model, axes",
    [
        (
            PainleveRod(),
            {"mu": [0.5, 2.0], "th": np.linspace(0.2, 1.4, 5), "slip": [-1.0, 0.0, 1.0], "thdot": [0.0, 6.0]},
        ),
        (BilateralRod(), {"th": np.linspace(0.2, 2.8, 7), "mu": [0.7, 2.0], "slip": [-1.0, 0.0, 1.0]}),
        (LeadScrew(), {"mu": [0.2, 0.25], "th": [-0.5, 0.5], "thdot": [-3.0, 0.0, 3.0], "R": [10.0, 100.0]}),
        (SelfLockingRod(), {"th": [math.pi / 6], "vb": [0.0, 1.0], "mu": [0.5, 1.5, 1.8]}),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_map_agrees_with_single_states(model, axes):
    from dataclasses import replace

    chart = ns.paradox_map(model, **axes)
    variables = chart.kind.dims
    met = set()
    for point in np.ndindex(chart.kind.shape):
        values = {name: float(chart[name].values[k]) for name, k in zip(variables, point, strict=True)}
        fields = {name: value for name, value in values.items() if hasattr(model, name)}
        there = replace(model, **fields)
        c = ns.classify(there, 0.0, *there.state(**{name: v for name, v in values.items() if name not in fields}))
        found = chart.isel(dict(zip(variables, point, strict=True)))
        assert int(found.n_solutions) == c.n_solutions and int(found.kind) == c.kind
        la_N = found.la_N.values[: c.n_solutions]
        np.testing.assert_allclose(la_N, [s.la_N[0] for s in c.solutions], rtol=1e-12, atol=1e-12)
        met.add(c.n_solutions)
    assert len(met) > 1


def test_threads_and_chunks_change_nothing():
    rod = SpragSlip()
    axes = {"th": np.linspace(0.2, 1.4, 191), "thdot": np.linspace(-5.0, 5.0, 190)}  # more than two chunks
    one, three = ns.paradox_map(rod, workers=1, **axes), ns.paradox_map(rod, workers=3, **axes)
    assert one.equals(three)


def test_state_function_in_python_gives_the_same_map():
    rod = PainleveRod(mu=2.0)
    axes = {"th": np.linspace(0.3, 1.4, 6), "thdot": [0.0, 6.0]}
    compiled = ns.paradox_map(rod, **axes, slip=-1.0)
    python = ns.paradox_map(rod, state=rod.state, **axes, slip=-1.0)
    interpreted = ns.paradox_map(
        rod.system(), state=lambda th, thdot, slip: rod.state(th, thdot, slip), **axes, slip=-1.0
    )
    for other in (python, interpreted):
        np.testing.assert_array_equal(compiled.n_solutions, other.n_solutions)
        np.testing.assert_array_equal(compiled.la_N, other.la_N)


def test_interpreted_model_gives_the_same_map(monkeypatch):
    rod = PainleveRod()
    axes = {"th": np.linspace(0.3, 1.4, 4), "mu": [0.5, 2.0], "slip": -1.0}
    compiled = ns.paradox_map(rod, **axes)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    assert compiled.equals(ns.paradox_map(rod, **axes))


def test_states_in_the_air_and_landing_states_have_kinds_of_their_own():
    ball = BouncingBall()
    chart = ns.paradox_map(ball, height=[0.0, 1.0], velocity=[-1.0, 0.0, 1.0])
    inadmissible, regular = ns.ParadoxKind.INADMISSIBLE, ns.ParadoxKind.REGULAR
    assert chart.kind.values.tolist() == [[inadmissible, regular, regular], [regular] * 3]
    meanings = dict(zip(chart.kind.flag_values.tolist(), chart.kind.flag_meanings.split(), strict=True))
    assert meanings[int(inadmissible)] == "INADMISSIBLE"


def test_several_contacts_have_a_dimension():
    block = RockingBlock(width=1.0, height=2.0)

    def sliding(speed):
        return block.state(tilt=0.0)[0], [speed, 0.0, 0.0]

    chart = ns.paradox_map(block, state=sliding, speed=[-1.0, 1.0], mu=[0.4, 0.9, 2.0])
    assert chart.p.dims == ("speed", "mu", "contact") and chart.la_N.dims == ("speed", "mu", "solution", "contact")
    assert chart.n_solutions.values.tolist() == [[1, 1, 0]] * 2


def test_wrong_axes_are_refused():
    rod = PainleveRod()
    with pytest.raises(ns.UnknownName, match="thdot"):
        ns.paradox_map(rod, thdott=[1.0])
    with pytest.raises(ns.InvalidInput, match="at least one axis"):
        ns.paradox_map(rod, th=1.0)
    with pytest.raises(ns.InvalidInput, match="mu must not be negative"):
        ns.paradox_map(rod, mu=[-1.0, 1.0])
    of_system = ns.paradox_map(rod.system(), mu=[1.0, 2.0], progress=False)  # the state of its parameters, the rod's
    assert of_system.kind.equals(ns.paradox_map(rod, mu=[1.0, 2.0], progress=False).kind)

    class Nothing(NamedTuple):
        m: float = 1.0

    def mass(t, q, p, M):
        M[0, 0] = p.m

    def force(t, q, u, p, h):
        h[0] = 0.0

    free = ns.System(n_q=1, mass=mass, force=force, parameters=Nothing())
    with pytest.raises(ns.InvalidInput, match="system with contacts"):
        ns.paradox_map(free, state=lambda: ([0.0], [0.0]), m=[1.0, 2.0])


@pytest.mark.parametrize("rod_type", [PainleveRod, BilateralRod])
def test_units_do_not_change_the_counts(rod_type):
    # mass, length and time in units m, l, T: forces scale with m l/T^2, the numbers of solutions stay
    th, mu = np.linspace(0.01, 3.1, 31), [0.3, 1.4, 2.0, 5.0]
    reference = None
    for m, l, T in [(1.0, 1.0, 1.0), (1e-3, 1e3, 1.0), (1e6, 1e-3, 1.0), (1e-9, 1e3, 1e-3)]:
        rod = rod_type(m=m, l=l, I=m * l * l / 12, g=9.81 * l / T**2)
        slip, thdot = np.array([-1.0, 0.0, 1.0]) * l / T, np.array([0.0, 3.0, 6.0]) / T
        chart = ns.paradox_map(rod, th=th, mu=mu, slip=slip, thdot=thdot)
        found = chart.n_solutions.values, chart.la_N.values / (m * l / T**2)
        reference = reference or found
        np.testing.assert_array_equal(found[0], reference[0])
        np.testing.assert_allclose(found[1], reference[1], rtol=1e-9)  # p cancels to a thousandth of its terms


def test_exactly_at_critical_friction_the_slide_is_gone():
    rod = PainleveRod()
    th = math.pi / 3
    critical = PainleveRod(mu=rod.critical_friction(th))
    for thdot, modes in [(0.0, ()), (6.0, ("free",))]:
        c = ns.classify(critical, 0.0, *critical.state(th=th, thdot=thdot))
        assert c.is_complete and tuple(s.modes[0] for s in c.solutions) == modes
        assert c.flags & ns.ParadoxFlag.P_ZERO and not c.flags & ns.ParadoxFlag.B_ZERO
