"""Chalk on a board: p, the critical azimuth and friction of its closed form, as classified and in runs."""

import numpy as np
import pytest

import nonsmooth as ns
from models import SpatialPainleveRod
from models.scenes import ChalkOnBoard


@pytest.mark.parametrize("th", [0.4, 1.0, 1.4])
@pytest.mark.parametrize("phi", [0.0, 0.5, -1.2, 3.0])
@pytest.mark.parametrize("r", [1e-6, 0.004])
def test_p_and_b_are_those_of_the_classification(th, phi, r):
    chalk = ChalkOnBoard(th=th, phi=phi, r=r, mu=1.7)
    found = ns.classify(chalk.scene())
    tip = found.mode.index("sliding")
    assert found.p[tip] == pytest.approx(chalk.p(), rel=1e-9)
    assert found.b[tip] == pytest.approx(-chalk.F / chalk.m, rel=1e-9)
    assert found.kind.name == ("INCONSISTENT" if chalk.p() < 0 else "REGULAR")


def test_p_of_a_sharp_chalk_is_that_of_the_rod_in_space():
    chalk, rod = ChalkOnBoard(r=1e-12), SpatialPainleveRod.slender(m=0.01, l=0.08, mu=2.0)
    for phi in np.linspace(-3, 3, 13):
        assert chalk.p(phi) == pytest.approx(rod.p(chalk.th, phi), rel=1e-9)
    assert chalk.critical_azimuth() == pytest.approx(rod.critical_azimuth(chalk.th), rel=1e-9)


@pytest.mark.parametrize("side", [1, -1])
def test_it_jumps_within_the_critical_azimuth_alone(side):
    limit = ChalkOnBoard().critical_azimuth()
    for off, is_named in ((-1e-3, True), (1e-3, False)):
        chalk = ChalkOnBoard(phi=side * (limit + off))
        sol = ns.simulate(chalk.scene(), (0, 1e-6), integrator=ns.MoreauJean(dt=1e-6))
        assert [event.kind for event in sol.paradoxes] == [ns.EventKind.INCONSISTENT] * is_named


def test_below_the_critical_friction_no_push_is_a_paradox():
    least = ChalkOnBoard().critical_friction()
    assert ChalkOnBoard(mu=0.999 * least).critical_azimuth() is None
    assert ns.critical_friction(ChalkOnBoard(mu=0.5).scene()) == pytest.approx(least, rel=1e-6)
