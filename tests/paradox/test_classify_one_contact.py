"""One contact: Painlevé's rod on and in its ground, the self-locking rod; counts, forces, kinds, stability, impacts."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import nonsmooth as ns
from models import BilateralRod, BouncingBall, PainleveRod, SelfLockingRod, SlidingBlock
from nonsmooth.paradox.stability import Stability

# SYSTEMS D: mu, th [deg], th', slip, A, B, solutions N; m = l = 1, I = 1/12, g = 9.81, printed to nine digits.
SAMPLES = [
    (0.5, 60, 0, -1, 1.10048095, -9.81, (8.914284273,)),
    (0.5, 60, 6, -1, 1.10048095, 5.77845727, (0.0,)),
    (2.0, 60, 0, -1, -0.84807621, -9.81, ()),
    (2.0, 60, 6, -1, -0.84807621, 5.77845727, (0.0, 6.813606125)),
    (2.0, 60, 0, 1, 4.34807621, -9.81, (2.256170206,)),
    (1.5, 65, 3, -1, -0.18778141, -5.73161496, ()),
    (1.5, 65, 5, -1, -0.18778141, 1.51884734, (0.0, 8.088379598)),
]  # fmt: skip
KINDS = [ns.ParadoxKind.INCONSISTENT, ns.ParadoxKind.REGULAR, ns.ParadoxKind.INDETERMINATE]
PRINTED = 6e-9  # half a unit of the last printed digit, and as much again


@pytest.mark.parametrize("mu, degrees, thdot, slip, p, b, N", SAMPLES)
def test_rod_on_the_ground_has_the_published_solutions(mu, degrees, thdot, slip, p, b, N):
    rod = PainleveRod(mu=mu)
    c = ns.classify(rod, 0.0, *rod.state(th=math.radians(degrees), thdot=thdot, slip=slip))
    assert c.is_complete and c.kind == KINDS[len(N)] and c.n_solutions == len(N)
    assert [float(s.la_N[0]) for s in c.solutions] == pytest.approx(list(N), abs=PRINTED)
    column = 0 if slip > 0 else 1
    assert c.p[0, column] == pytest.approx(p, abs=PRINTED) and c.b[0] == pytest.approx(b, abs=PRINTED)
    assert [s.modes[0] for s in c.solutions] == [("slide +" if slip > 0 else "slide -") if N_ else "free" for N_ in N]


@pytest.mark.parametrize("mu, degrees, thdot, slip, p, b, N", SAMPLES)
def test_every_solution_satisfies_the_equation_of_motion_and_coulombs_law(mu, degrees, thdot, slip, p, b, N):
    rod = PainleveRod(mu=mu)
    th = math.radians(degrees)
    for s in ns.classify(rod, 0.0, *rod.state(th=th, thdot=thdot, slip=slip)).solutions:
        la_N, la_F, half = float(s.la_N[0]), float(s.la_F[0]), rod.l / 2
        assert la_F == pytest.approx(-mu * la_N * slip, rel=1e-15)
        newton = [la_F, la_N - rod.m * rod.g, half * (la_F * math.sin(th) - la_N * math.cos(th)) / rod.I]
        np.testing.assert_allclose(s.du, newton, rtol=0, atol=1e-12 * 100)  # forces of order 100
        gap_rate = s.du[1] - half * (math.cos(th) * s.du[2] - math.sin(th) * thdot**2)  # g_N'' by hand
        assert s.dgamma_N[0] == pytest.approx(gap_rate, abs=1e-11) and s.dgamma_N[0] * la_N == 0


# SYSTEMS E: slip, th', N; mu = 2, th = 60 deg.
BILATERAL = [(-1, 6, (6.813606125, -1.328968718)), (-1, 0, ()), (1, 0, (2.256170206, -11.567356646)), (1, 6, ())]


@pytest.mark.parametrize("slip, thdot, N", BILATERAL)
def test_rod_held_on_the_ground_has_none_or_two_and_the_stiff_one_has_positive_p(slip, thdot, N):
    rod = BilateralRod(mu=2.0)
    c = ns.classify(rod, 0.0, *rod.state(th=math.pi / 3, thdot=thdot, slip=slip))
    assert c.is_complete and c.kind == KINDS[len(N)]
    assert [float(s.la_N[0]) for s in c.solutions] == pytest.approx(list(N), abs=PRINTED)
    for s in c.solutions:
        mu_s = rod.mu * slip * np.sign(s.la_N[0])
        expected = Stability.STABLE if rod.p(math.pi / 3, mu_s) > 0 else Stability.SADDLE
        assert s.stability.kind == expected
    assert [impact.gamma_F[0] for impact in c.impacts] == [0.0]  # plastic: the tip is seized


def test_bilateral_rod_below_critical_friction_has_one_solution_at_any_slip():
    rod = BilateralRod(mu=1.3)  # 4/3 is the least critical friction
    rng = np.random.default_rng(3)
    for _ in range(100):
        state = rod.state(th=rng.uniform(0.1, 3.0), thdot=rng.uniform(-8, 8), slip=rng.uniform(-1, 1))
        c = ns.classify(rod, 0.0, *state)
        assert c.kind == ns.ParadoxKind.REGULAR and not c.impacts


def test_impact_without_collision_ends_as_its_law_says():
    # NUMERICS 2, in closed form: e P_1 (C_s + |p|) and e P_1 sqrt(|p| (C_s + |p|)).
    rod = PainleveRod(m=1.0, l=2.0, I=1 / 3, mu=1.8)
    c = ns.classify(rod, 0.0, *rod.state(th=math.pi / 3), restitution=1.0)
    after = {impact.law: impact.gamma_N[0] for impact in c.impacts}
    assert after[ns.ImpactLaw.NEWTON] == 0
    assert after[ns.ImpactLaw.ENERGETIC] == pytest.approx(0.22730317, abs=5e-9)
    assert after[ns.ImpactLaw.POISSON] == pytest.approx(0.39970403, abs=5e-9)
    for impact in c.impacts:
        exact = rod.impact_without_collision(e=1.0, law=impact.law.name.lower())
        np.testing.assert_allclose(impact.u, exact.u, rtol=0, atol=1e-14)
        assert impact.gamma_F[0] == 0


def test_self_locked_rod_is_jammed():
    # beyond arctan(1/mu) = 45 deg neither forces nor an impact exist: G has rank one
    rod = SelfLockingRod(mu=1.0, th0=math.radians(50))
    c = ns.classify(rod, 0.0, *rod.state(th=rod.th0))
    assert c.kind == ns.ParadoxKind.INCONSISTENT and c.flags & ns.ParadoxFlag.JAMMED and not c.impacts
    rod = SelfLockingRod(mu=1.0, th0=math.radians(44))
    c = ns.classify(rod, 0.0, *rod.state(th=rod.th0))
    assert c.solutions[0].la_N[0] == pytest.approx(29.144981, abs=5e-7)
    rod = SelfLockingRod(mu=1.0, th0=math.radians(50), vb=0.0)  # at rest the redundant friction holds it
    c = ns.classify(rod, 0.0, *rod.state(th=rod.th0))
    assert c.kind == ns.ParadoxKind.REGULAR and c.solutions[0].modes == ("stick",)
    assert not c.solutions[0].is_unique_force and np.abs(c.solutions[0].du).max() <= 1e-12


def test_génot_brogliato_point_is_flagged():
    rod = PainleveRod(mu=1.5)
    th = rod.paradoxical_angles()[0]
    thdot = math.sqrt(rod.g / (0.5 * rod.l * math.sin(th)))
    assert thdot * math.sqrt(0.5 * rod.l / rod.g) == pytest.approx(1.137249, abs=5e-7)  # NUMERICS 1
    assert math.degrees(th) == pytest.approx(50.641598, abs=5e-7)
    flags = ns.classify(rod, 0.0, *rod.state(th=th, thdot=thdot)).flags
    assert flags & ns.ParadoxFlag.GENOT_BROGLIATO
    assert not ns.classify(rod, 0.0, *rod.state(th=th + 1e-3, thdot=thdot)).flags & ns.ParadoxFlag.P_ZERO
    assert ns.classify(rod, 0.0, *rod.state(th=th + 1e-3, thdot=0.0)).flags == 0


def test_state_in_the_air_has_one_free_motion():
    ball = BouncingBall()
    c = ns.classify(ball, 0.0, *ball.state(height=1.0))
    assert c.kind == ns.ParadoxKind.REGULAR and c.mode == ("open",) and c.solutions[0].du[0] == -ball.g


def test_frictionless_contact_is_closed_or_free():
    ball = BouncingBall(m=2.0)
    (solution,) = ns.classify(ball, 0.0, [0.0], [0.0]).solutions
    assert solution.modes == ("closed",) and solution.la_N[0] == pytest.approx(2.0 * ball.g, rel=1e-15)


def test_landing_and_penetrating_states_are_refused():
    ball = BouncingBall()
    with pytest.raises(ns.InvalidInput, match="approaches with gamma_N = -1"):
        ns.classify(ball, 0.0, [0.0], [-1.0])
    block = SlidingBlock()
    with pytest.raises(ns.InvalidInput, match="penetrates by 0.5"):
        ns.classify(block, 0.0, [1.0, -0.5], [0.0, 0.0])
    rod = BilateralRod()
    q, u = rod.state()
    with pytest.raises(ns.InvalidInput, match="bilateral contact 0 has the gap 0.1"):
        ns.classify(rod, 0.0, q + [0, 0.1, 0], u)
    with pytest.raises(ns.InvalidInput, match="q must have 3 entries"):
        ns.classify(rod, 0.0, q[:2], u)


def test_report_reads_as_words_and_as_json():
    rod = PainleveRod(mu=2.0)
    c = ns.classify(rod, 0.0, *rod.state(thdot=6.0), restitution=0.5)
    text = str(c)
    assert "INDETERMINATE" in text and "slide -" in text and "6.81361" in text and "saddle" in text
    data = json.loads(json.dumps(c.to_dict()))
    assert data["kind"] == "INDETERMINATE" and data["n_solutions"] == len(data["solutions"]) == 2
    assert [impact["law"] for impact in data["impacts"]] == ["newton", "poisson", "energetic"]


def test_interpreted_search_agrees_with_the_compiled_one(monkeypatch):
    rod = PainleveRod(mu=2.0)
    for thdot in (0.0, 6.0):
        compiled = json.dumps(ns.classify(rod, 0.0, *rod.state(thdot=thdot)).to_dict())
        monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
        assert json.dumps(ns.classify(rod, 0.0, *rod.state(thdot=thdot)).to_dict()) == compiled
        monkeypatch.delenv("NONSMOOTH_INTERPRET")
