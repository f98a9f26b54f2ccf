"""A default absolute tolerance beside motions of every size: what scales with a length gives the same numbers."""

import math
import warnings
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns


class Tip(NamedTuple):
    """An oscillator that is driven against a wall; every length is a multiple of L."""

    L: float = 1.0  # [m]


def mass(t, q, p, M):
    M[0, 0] = 1.0


def force(t, q, u, p, h):
    h[0] = p.L * math.cos(0.85 * t) - q[0] - 0.1 * u[0]


def gap(t, q, p, g_N):
    g_N[0] = 1.5 * p.L - q[0]


def tip(L):
    return ns.System(
        coordinates=[("x", "m")], mass=mass, force=force, gap=gap, contacts=[ns.Contact(e_N=0.8)], parameters=Tip(L)
    )


def moved(L, integrator, **options):
    sol = ns.simulate(tip(L), (0.0, 40.0), [0.0], [0.0], integrator=integrator, **options)
    assert sol.success
    return sol.q[-1, 0] / L, sum(event.kind == ns.EventKind.IMPACT for event in sol.events), sol


METHODS = {
    "auto": ("auto", 1e-8),
    "Auto": (ns.Auto(rtol=1e-6), 1e-6),
    "EventDriven": (ns.EventDriven(), 1e-8),
    "Adaptive": (ns.Adaptive(), 1e-8),
    "EventDriven of a tolerance": (ns.EventDriven(rtol=1e-6), 1e-6),
}


@pytest.mark.parametrize("L", [1e-5, 1e-9, 1e-12])
@pytest.mark.parametrize("name", METHODS)
def test_a_motion_of_any_size_keeps_the_tolerance_by_default(name, L):
    """40 s, a dozen impacts, each of which amplifies an error: that of one metre is a few hundred tolerances."""
    method, rtol = METHODS[name]
    metre, impacts, plain = moved(1.0, method)
    small, small_impacts, sol = moved(L, method)
    exact, _, _ = moved(1.0, ns.EventDriven(1e-12, 1e-14))
    assert small_impacts == impacts > 3
    assert abs(small - exact) <= 10.0 * abs(metre - exact) + rtol
    assert L > 1e-6 or "taken again" in sol.about["chosen"]
    assert "taken again" not in plain.about.get("chosen", "")


@pytest.mark.parametrize(
    "options",
    [{"events": lambda t, q, u: q[0] - 1e-9}, {"max_steps": 100_000}, {"progress": lambda done: None}],
    ids=["events", "max_steps", "progress"],
)
def test_a_run_that_is_not_taken_again_says_that_its_tolerance_is_coarse(options):
    with pytest.warns(ns.ToleranceWarning, match=r"default atol = 1.0e-10 .* largest coordinate, \d\.\de-09"):
        moved(1e-9, ns.EventDriven(), **options)


def test_a_tolerance_that_was_asked_for_is_taken_as_it_is():
    _, _, sol = moved(1e-9, ns.EventDriven(1e-8, 1e-11))
    assert "chosen" not in sol.about and "atol=1e-11" in sol.about["integrator"]


@pytest.mark.parametrize("state", [([0.0], [0.0]), ([1e-3], [0.0]), ([2.0], [-1.0])])
def test_rest_and_motions_of_ordinary_size_are_run_once(state):
    def weight(t, q, u, p, h):
        h[0] = -9.81

    def height(t, q, p, g_N):
        g_N[0] = q[0]

    system = ns.System(coordinates=[("x", "m")], mass=mass, force=weight, gap=height, contacts=[ns.Contact(e_N=0.5)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sol = ns.simulate(system, (0.0, 1.0), *state, integrator=ns.EventDriven())
    assert "chosen" not in sol.about and np.isfinite(sol.q).all()
