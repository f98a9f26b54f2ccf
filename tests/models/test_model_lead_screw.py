"""The lead screw: effective inertia, thresholds and numbers of forces, against its balances and by enumeration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import nonsmooth as ns
from models import LeadScrew


def test_published_thresholds_and_effective_inertia():
    # SYSTEMS I: I = 3.12e-6, r = 5.18e-3, lam = 5.57 deg, m = 10
    screw = LeadScrew()
    assert math.tan(screw.lam) == pytest.approx(0.097522252, abs=5e-10)
    assert screw.critical_friction() == pytest.approx(0.219303854, abs=5e-10)
    assert LeadScrew(mu=0.2).Gamma(-1) == pytest.approx(4.8971e-7, abs=5e-12)
    assert LeadScrew(mu=0.25).Gamma(-1) == pytest.approx(-7.7501e-7, abs=5e-12)
    assert LeadScrew(mu=0.1).is_self_locking() and not LeadScrew(mu=0.09).is_self_locking()
    assert LeadScrew(I=1.0).critical_friction() == math.inf


def test_effective_inertia_vanishes_at_critical_friction():
    screw = LeadScrew(m=3.0, I=0.2, r=0.7, lam=0.3)
    critical = LeadScrew(m=3.0, I=0.2, r=0.7, lam=0.3, mu=screw.critical_friction())
    assert abs(critical.Gamma(-1)) <= 1e-15 * 3  # rounding of terms of order 1


@pytest.mark.parametrize("mu, numbers", [(0.2, {1}), (0.25, {0, 2})])
def test_forces_found_are_those_of_the_closed_form(mu, numbers):
    screw = LeadScrew(mu=mu, cx=0.4)
    rng = np.random.default_rng(5)
    met = set()
    for _ in range(200):
        th, thdot = rng.uniform(-1, 1), rng.uniform(-50, 50)
        c = ns.classify(screw, 0.0, *screw.state(th, thdot))
        exact = screw.normal_forces(th, thdot)
        found = sorted(c.solutions, key=lambda s: s.la_N[0])
        assert c.is_complete and c.n_solutions == len(exact)
        # la_N = -b/p: both are sums whose terms cancel, b by up to 1e3, p by the distance of mu from its threshold
        assert [s.la_N[0] for s in found] == pytest.approx(list(exact), rel=1e-9, abs=1e-9)
        for s in found:
            assert s.du[1] == pytest.approx(screw.angular_acceleration(th, thdot, s.la_N[0]), rel=1e-8, abs=1e-3)
            assert s.du[0] == pytest.approx(screw.r * math.tan(screw.lam) * s.du[1], rel=1e-9, abs=1e-9)
        met.add(c.n_solutions)
    assert met == numbers


def test_two_forces_where_the_load_drives_the_screw_and_none_where_it_brakes():
    # Gamma(-mu) < 0: two forces iff Lambda_0 th' > 0; at th = thi the load alone gives Lambda_0 = I R > 0
    screw = LeadScrew(mu=0.25, c=0.0)
    assert len(screw.normal_forces(0.0, 1.0)) == 2 and screw.normal_forces(0.0, -1.0) == ()
    numbers, fields = screw.phase_map(np.zeros(2), np.array([1.0, -1.0]))
    assert numbers.tolist() == [2, 0] and fields["$N = 0$"] == pytest.approx(screw.I * screw.R)


def test_sliding_ends_in_a_seizure_where_the_force_of_the_thread_vanishes():
    """Gamma th'' + c th' + k th + r xi R = 0 with mu_s = mu from the default start, until Lambda_0 = 0 while th' > 0:
    no force is left, for Gamma(-mu) < 0."""
    screw = LeadScrew()
    q0, u0 = screw.state()
    Gamma, middle = screw.Gamma(1), -screw.r * screw.xi(1) * screw.R / screw.k
    delta = screw.c / (2 * Gamma)
    omega = math.sqrt(screw.k / Gamma - delta**2)
    a, b = q0[1] - middle, (u0[1] + delta * (q0[1] - middle)) / omega

    def slid(t):
        decay, c, s = math.exp(-delta * t), math.cos(omega * t), math.sin(omega * t)
        th = middle + decay * (a * c + b * s)
        return th, decay * (omega * (b * c - a * s) - delta * (a * c + b * s))

    seizure = brentq(lambda t: screw.Lambda_0(*slid(t)), 0.0, 0.01, xtol=1e-15)
    assert slid(seizure)[1] > 0
    sol = ns.simulate(screw, (0, screw.t_end), q0, u0, integrator=ns.EventDriven(rtol=1e-10))
    (event,) = (event for event in sol.events if event.kind is ns.EventKind.INCONSISTENT)
    assert event.t == pytest.approx(seizure, rel=1e-8)
    assert sol.q[-1, 1] == pytest.approx(slid(seizure)[0], rel=1e-7) and abs(sol.u[-1]).max() < 1e-12


def test_steep_thread_and_standing_screw_are_refused():
    with pytest.raises(ns.InvalidInput, match="mu tan"):
        LeadScrew(lam=1.0, mu=0.8)
    with pytest.raises(ns.InvalidInput, match="lam must lie"):
        LeadScrew(lam=2.0)
    with pytest.raises(ns.InvalidInput, match="must turn"):
        LeadScrew().normal_forces(0.0, 0.0)
