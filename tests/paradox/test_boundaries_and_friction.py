"""Critical friction and the curves between regions, against the closed forms of the rods and the published table."""

from __future__ import annotations

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import BeltOscillator, BouncingBall, LeadScrew, PainleveRod, SpragSlip

# SYSTEMS G, set 2: th, th' on v_t = 0, the two th' on Lambda = 0; printed to eight decimals.
SET_2 = [
    (0.73, 2.99908692, (-5.90440381, 3.66956101)),
    (0.75, 2.93410545, (-5.16977147, 3.02291917)),
    (0.78, 2.84381989, (-3.91369798, 1.89198792)),
    (0.80, 2.78801564, (-2.81053350, 0.86810430)),
]


def test_least_critical_friction_of_the_slender_rod_is_four_thirds():
    rod = PainleveRod()
    least = ns.least_critical_friction(rod, rod.state()[0], "th", (0.0, math.pi / 2))
    assert least.mu == pytest.approx(4 / 3, rel=1e-14)  # flat at its minimum: the angle's error enters squared
    assert least.at == pytest.approx(math.atan(2.0), abs=1e-7)
    for kappa in (0.5, 2.0, 7.0):  # not slender: 2 sqrt(1 + kappa)/kappa
        other = PainleveRod(I=0.25 / kappa)
        least = ns.least_critical_friction(other, other.state()[0], 2, (0.0, math.pi / 2))
        assert least == pytest.approx(other.least_critical_friction(), abs=1e-7)


def test_critical_friction_is_that_of_the_closed_forms():
    rng = np.random.default_rng(2)
    rod, sprag, screw = PainleveRod(m=1.7, l=0.8, I=0.3), SpragSlip(m=3.0), LeadScrew()
    for th in rng.uniform(0.1, 1.4, 20):
        assert ns.critical_friction(rod, rod.state(th=th)[0]) == pytest.approx(rod.critical_friction(th), rel=1e-13)
        assert ns.critical_friction(sprag, sprag.state(th=th)[0]) == pytest.approx(
            sprag.critical_friction(th), rel=1e-13
        )
    assert ns.critical_friction(screw, screw.state()[0]) == pytest.approx(screw.critical_friction(), rel=1e-12)
    assert ns.critical_friction(rod, rod.state(th=math.pi / 2)[0]) == math.inf  # upright: friction only tilts it


def test_curves_of_the_sprag_slip_rod_go_through_the_published_points():
    rod = SpragSlip()
    th = np.array([0.70, *(row[0] for row in SET_2), 0.83])  # grid lines through the table's angles
    curves = ns.paradox_boundaries(rod, th=th, thdot=np.linspace(-7.0, 5.0, 81))
    for angle, on_slip, on_force in SET_2:
        (slip,) = at(curves.gamma_F, angle)
        assert slip == pytest.approx(on_slip, abs=6e-9)
        assert at(curves.b, angle) == pytest.approx(list(on_force), abs=6e-9)
    (line,) = curves.p
    np.testing.assert_allclose(line[:, 0], 0.720658419, rtol=0, atol=6e-10)
    assert curves.crossings["b", "gamma_F"] == pytest.approx(np.array([[0.752865415, 2.925120353]]), abs=6e-10)


def test_every_point_of_a_curve_is_a_zero_of_its_closed_form():
    rod = SpragSlip()
    curves = ns.paradox_boundaries(rod, th=np.linspace(0.5, 1.55, 31), thdot=np.linspace(-6.0, 6.0, 31))
    for line in curves.p:
        assert np.abs(line[:, 0, None] - rod.paradoxical_angles()).min(axis=1).max() <= 1e-14
    for line in curves.b:  # Lambda is a sum of terms up to 1e3, its slope in th' is above 1 here
        assert np.abs(rod.Lambda(*line.T)).max() <= 1e-10
    for line in curves.gamma_F:
        assert np.abs(rod.v_t(*line.T)).max() <= 1e-14 * 10 * 5  # terms of vb = 10, rounded in their sum
    assert len(curves.p) == 2 and sum(map(len, curves.b)) > 20


def test_génot_brogliato_points_of_the_rod_are_where_p_and_b_vanish():
    # NUMERICS 1: angles, and th' sqrt(s/g) at the first
    for mu, first, second, rate in [(1.4, 55.585811, 69.951867, 1.100981), (1.5, 50.641598, 73.048469, 1.137249),
                                    (2.0, 37.377368, 79.187683, 1.283463)]:  # fmt: skip
        rod = PainleveRod(mu=mu)
        curves = ns.paradox_boundaries(rod, th=np.linspace(0.3, 1.5, 40), thdot=np.linspace(1.0, 9.0, 40))
        points = curves.crossings["p", "b"]
        points = points[np.argsort(points[:, 0])]
        assert np.degrees(points[:, 0]) == pytest.approx([first, second], abs=1.1e-6)
        assert points[0, 1] * math.sqrt(0.5 * rod.l / rod.g) == pytest.approx(rate, abs=6e-7)


def test_systems_without_critical_friction_are_refused():
    ball, belt, rod = BouncingBall(), BeltOscillator(), PainleveRod()
    with pytest.raises(ns.InvalidInput, match="no friction or no gap"):
        ns.critical_friction(ball, ball.state()[0])
    with pytest.raises(ns.InvalidInput, match="no friction or no gap"):
        ns.critical_friction(belt, belt.state()[0])
    with pytest.raises(ns.InvalidInput, match="from 0 to 0"):
        ns.critical_friction(rod, rod.state()[0], 1)
    with pytest.raises(ns.UnknownName, match="'th'"):
        ns.least_critical_friction(rod, rod.state()[0], "thh", (0, 1))
    with pytest.raises(ns.InvalidInput, match="two axes"):
        ns.paradox_boundaries(rod, th=[0.1, 0.2])


def at(lines, angle):
    """The second coordinates at which a family of polylines meets a grid line of the first, in increasing order."""
    met = [y for line in lines for x, y in line if x == pytest.approx(angle, abs=1e-12)]
    return sorted({round(y, 12) for y in met})
