"""A row of sliding blocks: the modes of the step before are tried first, and agree with Lemke's method."""

import numpy as np
import pytest

import nonsmooth as ns
from benchmarks.core_scenes import row_of_blocks
from benchmarks.stress_scenes import Tower, tower
from nonsmooth.contact.planar import kept
from nonsmooth.contact.planar import ladder as planar
from nonsmooth.contact.planar.problem import Planar, problem_of
from nonsmooth.contact.planar.single import SLIDE_MINUS, SLIDE_PLUS
from nonsmooth.jit.blocks import new


def run(n, t_end=0.6):
    u0 = np.zeros(2 * n)
    u0[::2] = np.linspace(1.0, 2.0, n)
    return ns.simulate(row_of_blocks(n), (0, t_end), np.zeros(2 * n), u0, integrator=ns.MoreauJean(dt=1e-3))


@pytest.mark.parametrize("n", [2, 6])
def test_blocks_that_slide_on_are_answered_by_their_modes(n):
    sol = run(n)
    changed = len({event.t for event in sol.events})
    assert sol.stats.lcp_kept >= sol.stats.steps - changed
    assert (sol.P_N[1:] == pytest.approx(9.81e-3, rel=1e-12)) and (sol.g_N == 0).all()


def falling_tower(n, t_end):
    """The highest of n blocks slides, the others begin to: a chain of coupled contacts."""
    u0 = np.zeros(2 * n)
    u0[-2] = 1.0
    return ns.simulate(tower(n, Tower(mu=0.5)), (0, t_end), np.zeros(2 * n), u0, integrator=ns.MoreauJean(dt=1e-3))


def test_modes_kept_and_lemke_give_one_motion(monkeypatch):
    """The interpreted source, with and without the modes of the step before."""
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    with_modes = falling_tower(3, 0.1)
    monkeypatch.setitem(ns.jit.interpreted(planar.go_on).__globals__, "hold_modes", lambda *arguments: False)
    by_lemke = falling_tower(3, 0.1)
    assert with_modes.stats.lcp_kept > 0 and by_lemke.stats.lcp_kept == 0
    # both satisfy G P + c to ROUNDING: velocities agree to 100 steps of 1e-15 m/s, positions to dt times their sum
    assert np.abs(with_modes.u - by_lemke.u).max() < 1e-12


def test_a_mode_that_no_longer_fits_is_refused():
    """Two sliding contacts, one of them now pulled away: P_N = -c/G < 0 does not satisfy P_N >= 0."""
    system = row_of_blocks(2)
    hold = ns.jit.interpreted(kept.hold_modes)
    mu, planar_arrays = np.full(2, 0.3), new(Planar, n=2, d=1)
    problem = problem_of(system.kinds, np.eye(4), np.zeros(4), mu, mu)

    def holds(c, *modes):
        problem.c[:], problem.candidate[:] = c, modes
        return hold(problem, planar_arrays)

    pressed, pulled = np.array([-1.0, 2.0, -1.0, 2.0]), np.array([-1.0, 2.0, 1.0, 2.0])
    assert holds(pressed, SLIDE_PLUS, SLIDE_PLUS)
    assert problem.P == pytest.approx([1.0, -0.3, 1.0, -0.3])
    assert not holds(pulled, SLIDE_PLUS, SLIDE_PLUS)
    assert not holds(pressed, SLIDE_PLUS, SLIDE_MINUS)  # slides the other way
