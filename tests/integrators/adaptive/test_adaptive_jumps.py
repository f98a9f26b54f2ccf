"""Forces that jump, in time and in space, under Adaptive: closed forms arc by arc."""

import math
import warnings

import numpy as np
import pytest

import nonsmooth as ns
from tests.systems import block

MOST = 30.0  # tolerances
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)


def mass(t, q, p, M):
    M[0, 0] = 1.0


def error(system, start, t, exact, rtol):
    """Largest error of q at the times t, in tolerances; nothing may be warned of."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sol = ns.simulate(system, (0.0, t[-1]), *start, integrator=ns.Adaptive(rtol, 1e-2 * rtol), max_steps=200_000)
    return np.abs(sol(t).q[:, 0] - exact).max() / (rtol * (1e-2 + np.abs(exact).max()))


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_body_that_is_pulled_back_with_a_constant_force_runs_through_parabolas(rtol):
    """h = -sign q from q = 1/2: a parabola within every two seconds, twenty reversals."""

    def force(t, q, u, p, h):
        h[0] = -1.0 if q[0] > 0.0 else 1.0

    t = np.linspace(0.0, 40.0, 401)[1:]
    arc = np.floor((t + 1.0) / 2.0)
    exact = (-1.0) ** arc * 0.5 * (1.0 - (t - 2.0 * arc) ** 2)
    assert error(ns.System(n_q=1, mass=mass, force=force), ([0.5], [0.0]), t, exact, rtol) < MOST


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_spring_with_a_step_at_its_rest_swings_in_arcs_of_cosines(rtol):
    """h = -4 q - F sign q: about -F/4 until q = 0 after acos(1/(1 + 2/F))/2 s, and then about F/4."""
    F = 0.7

    def force(t, q, u, p, h):
        h[0] = -4.0 * q[0] - (F if q[0] > 0.0 else -F)

    t, quarter = np.linspace(0.0, 30.0, 401)[1:], 0.5 * math.acos(F / 4 / (0.5 + F / 4))
    arc = np.floor((t + quarter) / (2.0 * quarter))
    exact = (-1.0) ** arc * ((0.5 + F / 4) * np.cos(2.0 * (t - 2.0 * quarter * arc)) - F / 4)
    assert error(ns.System(n_q=1, mass=mass, force=force), ([0.5], [0.0]), t, exact, rtol) < MOST


def under_levels(t, edges, levels, k, A):
    """q(t) of q'' = -k q + A cos 3t + level from (0.1, 0.2), exactly from edge to edge."""
    B, omega, q, u, begin, exact = A / (k - 9.0), math.sqrt(k), 0.1, 0.2, 0.0, []
    stops = sorted([(s, 0) for s in edges if s < t[-1]] + [(s, 1) for s in t])
    level = iter(levels)
    c = next(level)
    for stop, is_asked in stops:
        s = stop - begin
        if k > 0.0:
            x, v = q - c / k - B * math.cos(3 * begin), (u + 3 * B * math.sin(3 * begin)) / omega
            q = c / k + B * math.cos(3 * stop) + x * math.cos(omega * s) + v * math.sin(omega * s)
            u = -3 * B * math.sin(3 * stop) + omega * (v * math.cos(omega * s) - x * math.sin(omega * s))
        else:
            v = u + 3 * B * math.sin(3 * begin)
            q += v * s + 0.5 * c * s * s + B * (math.cos(3 * stop) - math.cos(3 * begin))
            u += c * s - 3 * B * (math.sin(3 * stop) - math.sin(3 * begin))
        begin = stop
        if is_asked:
            exact.append(q)
        else:
            c = next(level)
    return np.array(exact)


@pytest.mark.parametrize(("k", "A"), [(0.0, 0.0), (2.0, 1.5)], ids=["alone", "with smooth forces"])
@pytest.mark.parametrize("jumps", [40, 400, 4000])
def test_load_that_is_switched_to_and_fro_moves_a_body_as_its_arcs_have_it(jumps, k, A):
    rate = 0.1 * jumps

    def force(t, q, u, p, h):
        h[0] = -k * q[0] + A * math.cos(3.0 * t) + (1.0 if math.floor(rate * t) % 2 == 0 else -1.0)

    t = np.linspace(0.0, 10.0, 101)[1:]
    edges, levels = np.arange(1, jumps + 2) / rate, [1.0 - 2.0 * (i % 2) for i in range(jumps + 3)]
    exact = under_levels(t, edges, levels, k, A)
    system = ns.System(n_q=1, mass=mass, force=force)
    assert max(error(system, ([0.1], [0.2]), t, exact, rtol) for rtol in TOLERANCES) < MOST


@pytest.mark.parametrize("seed", range(6))
def test_load_that_jumps_at_random_times_by_random_amounts_is_followed(seed):
    rng = np.random.default_rng(seed)
    edges, levels = np.sort(rng.uniform(0.0, 10.0, 60)), rng.normal(size=61) * 10 ** rng.uniform(-2, 2)
    k, A = 2.0, 1.5

    def force(t, q, u, p, h):
        h[0] = -k * q[0] + A * math.cos(3.0 * t) + levels[np.searchsorted(edges, t, side="right")]

    t = np.linspace(0.0, 10.0, 101)[1:]
    exact = under_levels(t, edges, levels, k, A)
    system = ns.System(n_q=1, mass=mass, force=force)
    assert max(error(system, ([0.1], [0.2]), t, exact, rtol) for rtol in TOLERANCES) < MOST


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_block_that_is_pushed_to_and_fro_over_its_floor_slides_with_either_acceleration(rtol):
    """m = 1, mu g = 1 in the plane, pushed by 3 and -1/2 in turn: u' = 2, then -3/2, and it never stops.

    From u = 1/10 after n whole seconds u has grown by 1/4 each: always above zero.
    """
    g = 10.0

    def force(t, q, u, p, h):
        h[0] = 3.0 if math.floor(2.0 * t) % 2 == 0 else -0.5
        h[1] = -g

    system = block(ns.Contact(mu=0.1), force=force)
    t = np.linspace(0.0, 6.0, 121)[1:]
    whole = np.floor(t)
    part = t - whole
    first, second = np.minimum(part, 0.5), np.maximum(part - 0.5, 0.0)
    u_0 = 0.1 + 0.25 * whole
    began = 0.1 * whole + 0.25 * whole * (whole - 1.0) / 2.0 + whole * (0.25 + 0.5 - 0.1875)
    exact = began + u_0 * first + first**2 + (u_0 + 1.0) * second - 0.75 * second**2
    assert error(system, ([0.0, 0.0], [0.1, 0.0]), t, exact, rtol) < MOST


@pytest.mark.parametrize(("rtol", "most"), [(1e-4, 1e-2), (1e-8, 1e-6)])
def test_body_that_friction_in_its_force_stops_does_not_turn_back(rtol, most):
    """h = 1/2 - sign u from u = 1: at rest from t = 2, q = 1 on. A run that cannot get on from there says so."""

    def force(t, q, u, p, h):
        h[0] = 0.5 - (1.0 if u[0] > 0.0 else -1.0)

    sol = ns.simulate(ns.System(n_q=1, mass=mass, force=force), (0.0, 4.0), [0.0], [1.0],
                      integrator=ns.Adaptive(rtol, 1e-2 * rtol), on_failure="return")  # fmt: skip
    assert sol.success or sol.status == ns.Status.BUDGET_SPENT
    assert sol.t[-1] > 2.0
    assert sol.q[sol.t > 2.0, 0] == pytest.approx(1.0, abs=most)
