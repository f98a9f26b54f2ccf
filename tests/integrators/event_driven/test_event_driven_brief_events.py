"""Events that begin and end within what would be one step of the motion: loads that the motion says little of.

A body at rest, or one that a load does not move, is integrated by steps that grow without bound; the closed forms here
say when the load ends a mode, for however short a time.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import nonsmooth as ns
from nonsmooth import ContactMode
from nonsmooth.integrators.radau import resolution

MU, GRAVITY = 0.3, 9.81
TOLERANCES = [1e-4, 1e-8, 1e-12]
MOST = 5.0  # tolerances


def events_at(rtol):
    return ns.EventDriven(rtol, max(1e-14, 1e-2 * rtol))


def block(force, contact, parameters=None):
    """A block of 1 kg on a table: coordinates (x, y), force(t), or force(t, p), = (F_x, F_y) beside its weight."""

    if parameters is None:

        def loads(t, q, u, p, h):
            h[0], h[1] = force(t)
            h[1] -= GRAVITY

    else:

        def loads(t, q, u, p, h):
            h[0], h[1] = force(t, p)
            h[1] -= GRAVITY

    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.0

    def gap(t, q, p, g):
        g[0] = q[1]

    def normal(t, q, p, W):
        W[0, 1] = 1.0

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    return ns.System(
        n_q=2, mass=mass, force=loads, gap=gap, normal=normal, tangent=tangent, contacts=[contact],
        **({} if parameters is None else {"parameters": parameters}),
    )  # fmt: skip


def pushed(part, rate):
    push = part * MU * GRAVITY

    def force(t):
        return push * math.sin(rate * t), 0.0

    return block(force, ns.Contact(mu=MU))


def slip_at_a_crest(part, rate):
    """(Begin, length) of the slip under part mu m g sin(rate t): v' = mu g (part sin(rate t) - 1) until v = 0."""
    begin = math.asin(1 / part) / rate

    def velocity(t):
        return part * (math.cos(rate * begin) - math.cos(rate * t)) / rate - (t - begin)

    end = brentq(velocity, math.pi / rate - begin, math.pi / rate, xtol=1e-16)
    way = math.cos(rate * begin) * (end - begin) - (math.sin(rate * end) - math.sin(rate * begin)) / rate
    return begin, MU * GRAVITY * (part * way / rate - (end - begin) ** 2 / 2)


def begins_of(sol, mode):
    return [event.t for event in sol.events if event.mode_after == mode]


@pytest.mark.parametrize("rtol", [*TOLERANCES, "auto"])
@pytest.mark.parametrize("part", [0.9999, 1.0001, 1.001, 1.01, 1.1])
def test_block_slips_at_every_crest_of_a_force_beyond_its_friction(part, rtol):
    """To and fro alike, from sin(3 t) = 1/part on; and not at all below 1."""
    begin, slip = slip_at_a_crest(part, 3.0) if part > 1 else (0.0, 0.0)
    integrator = "auto" if rtol == "auto" else events_at(rtol)
    sol = ns.simulate(pushed(part, 3.0), (0, 4), [0, 0], [0, 0], integrator=integrator)
    crests = [begin + math.pi / 3 * k for k in range(4)] if part > 1 else []
    assert begins_of(sol, ContactMode.SLIDE) == pytest.approx(crests, abs=1e-12)
    assert np.abs(sol.q[:, 0]).max() == pytest.approx(slip, rel=1e-4, abs=1e-15)


@pytest.mark.upkeep
def test_no_crest_is_missed_at_random_rates_and_tolerances():
    rng = np.random.default_rng(1)
    for _ in range(20):
        part, rate, rtol = 1 + 10 ** rng.uniform(-5, -0.3), 10 ** rng.uniform(-0.5, 2.5), 10 ** rng.uniform(-9, -3)
        t_end = rng.uniform(5, 20) * math.pi / rate
        sol = ns.simulate(pushed(part, rate), (0, t_end), [0, 0], [0, 0], integrator=ns.EventDriven(rtol))
        begin = math.asin(1 / part) / rate
        crests = begin + math.pi / rate * np.arange(21)
        assert begins_of(sol, ContactMode.SLIDE) == pytest.approx(crests[crests < t_end], rel=1e-10)


def flight_from_a_table(part, rate):
    """(Begin, end) of the first flight from a table at y = -part g sin(rate t)/rate^2, whose acceleration is
    part g sin(rate t): the table is left where it falls away with g."""
    begin = (math.pi + math.asin(1 / part)) / rate
    y, v = -part * GRAVITY * math.sin(rate * begin) / rate**2, -part * GRAVITY * math.cos(rate * begin) / rate

    def gap(t):
        tau = t - begin
        return y + v * tau - GRAVITY * tau**2 / 2 + part * GRAVITY * math.sin(rate * t) / rate**2

    shortest = (math.pi - 2 * math.asin(1 / part)) / rate  # the table falls faster than the block until then
    return begin, brentq(gap, begin + shortest, begin + 3 * shortest, xtol=1e-16)


@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("part", [1.0001, 1.001, 1.01])
def test_block_leaves_a_shaken_table_where_it_falls_faster_than_g(part, rtol):
    rate = 7.0

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = -GRAVITY

    def gap(t, q, p, g):
        g[0] = q[0] + part * GRAVITY * math.sin(rate * t) / rate**2

    def normal(t, q, p, W):
        W[0, 0] = 1.0

    def gap_rate(t, q, p, w):
        w[0] = part * GRAVITY * math.cos(rate * t) / rate

    system = ns.System(
        n_q=1, mass=mass, force=force, gap=gap, normal=normal, gap_rate=gap_rate,
        contacts=[ns.Contact()],
    )  # fmt: skip
    begin, end = flight_from_a_table(part, rate)
    u0 = -part * GRAVITY / rate
    sol = ns.simulate(system, (0, 2), [0], [u0], integrator=events_at(rtol))
    period = 2 * math.pi / rate
    flights = begins_of(sol, ContactMode.OPEN)
    assert flights == pytest.approx([begin + period * k for k in range(len(flights))], abs=2e-2 * rtol + 1e-11)
    assert len(flights) == 2


@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("part", [0.9999, 1.0001, 1.01])
def test_block_is_lifted_at_every_crest_of_a_pull_beyond_its_weight(part, rtol):
    """Nothing but the normal force knows of the pull while the block slides without friction."""
    pull = part * GRAVITY

    def force(t):
        return 0.0, pull * math.sin(3 * t)

    sol = ns.simulate(block(force, ns.Contact()), (0, 6), [0, 0], [1, 0], integrator=events_at(rtol))
    crests = [(math.asin(1 / part) + 2 * math.pi * k) / 3 for k in range(3)] if part > 1 else []
    assert begins_of(sol, ContactMode.OPEN) == pytest.approx(crests, abs=1e-12)
    assert sol.q[-1, 0] == pytest.approx(6.0, rel=1e-12)


@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("depth", [1e-4, 1e-2])
def test_guide_lets_go_where_its_normal_force_is_too_small_for_a_moment(depth, rtol):
    """mu N = F (1 + cos(5 t) + 1 - depth) falls below F about each trough."""
    push = 0.1

    def force(t):
        return push, GRAVITY - push / MU * (2 - depth + math.cos(5 * t))

    guide = block(force, ns.Contact(mu=MU, bilateral=True))
    sol = ns.simulate(guide, (0, 3), [0, 0], [0, 0], integrator=events_at(rtol))
    first = math.acos(depth - 1) / 5
    troughs = [first, first + 2 * math.pi / 5]
    assert begins_of(sol, ContactMode.SLIDE) == pytest.approx(troughs, abs=1e-11)


class Load(NamedTuple):
    """Of a guide: parameters, so that one system is compiled."""

    push: float
    depth: float
    rate: float
    side: float


def force_on_guide(t, p):
    return p.push, GRAVITY - p.side * (math.cos(p.rate * t) + 1 - p.depth)


def guide(push, depth, rate, side=1):
    """Pushed along by a constant force, pressed to a side by N = cos(rate t) + 1 - depth, or to the other."""

    return block(force_on_guide, ns.Contact(mu=MU, bilateral=True), Load(push, depth, rate, side))


def slips_at_the_first_trough(push, depth, rate):
    """(Begin, way) of the slips about rate t = pi: v' = push - mu |N| from push = mu |N| on, until v = 0.

    |N| holds the guide on its other side for a while, if that is deep and long enough, and it slips twice.
    """
    centre, changes = math.pi / rate, math.acos(1 - depth) / rate

    def integral(t):
        return math.sin(rate * t) / rate + (1 - depth) * t

    def of_size(t):
        before, after = integral(centre - changes), integral(centre + changes)
        if t <= centre - changes:
            return integral(t)
        return 2 * before - integral(t) if t <= centre + changes else integral(t) - 2 * (after - before)

    def slip(begin, turn, latest):
        def velocity(t):
            return push * (t - begin) - MU * (of_size(t) - of_size(begin))

        end = brentq(velocity, turn, latest, xtol=1e-15) if velocity(latest) < 0 else None
        corners = [t for t in (centre - changes, centre + changes) if begin < t < (end or begin)]
        edges = [begin, *corners, end]
        within = 1e-9 * push * (1 / rate) ** 2  # of the way
        way = sum(quad(velocity, a, b, epsabs=within)[0] for a, b in zip(edges, edges[1:], strict=False)) if end else 0
        return end and (begin, way)

    reach = math.acos(1 - depth - push / MU) / rate  # push = mu N at centre -+ reach
    last = centre + math.pi / rate
    if push >= MU * depth:
        return [slip(centre - reach, centre + reach, last)]
    held = math.acos(1 - depth + push / MU) / rate  # and on the other side at centre -+ held
    first = slip(centre - reach, centre - held, centre + held)
    return [first, slip(centre + held, centre + reach, last)] if first else [slip(centre - reach, centre + reach, last)]


@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(("push", "depth"), [(1e-2, 1e-3), (1e-3, 1e-2), (3e-4, 0.3)])
def test_guide_slips_where_its_force_changes_sides_for_a_moment(push, depth, side, rtol):
    """|N| is far above the push before and after, and the times at which it is not are a small part of a step."""
    slips = slips_at_the_first_trough(push, depth, 5.0)
    sol = ns.simulate(guide(push, depth, 5.0, side), (0, 1.2), [0, 0], [0, 0], integrator=events_at(rtol))
    assert begins_of(sol, ContactMode.SLIDE) == pytest.approx([begin for begin, _ in slips], abs=1e-12)
    assert sol.q[-1, 0] == pytest.approx(sum(way for _, way in slips), rel=1e-6, abs=1e-2 * rtol)


def random_guide(rng, least=1e-4):
    """(push, depth, rate, rtol)"""
    push, depth = 10 ** rng.uniform(math.log10(least), -0.6), 10 ** rng.uniform(-6, -0.3)
    return push, depth, 10 ** rng.uniform(-0.5, 2.5), 10 ** rng.uniform(-9, -3)


def test_no_change_of_sides_is_missed_at_random_rates_and_tolerances():
    rng = np.random.default_rng(3)
    for _ in range(40):
        push, depth, rate, rtol = random_guide(rng)
        slips = slips_at_the_first_trough(push, depth, rate)
        period = 2 * math.pi / rate
        cycles = int(rng.integers(1, 5))
        sol = ns.simulate(
            guide(push, depth, rate), (0, cycles * period), [0, 0], [0, 0], integrator=ns.EventDriven(rtol)
        )
        begins = [begin + period * k for k in range(cycles) for begin, _ in slips]
        assert begins_of(sol, ContactMode.SLIDE) == pytest.approx(begins, rel=1e-10)


@pytest.mark.stress
def test_changes_of_sides_that_leave_no_trace_are_all_that_is_missed():
    """A slip that is over within 1e-5 of a step, before modes are decided; ways of rounding."""
    rng = np.random.default_rng(5)
    total, missed = 0, []
    for _ in range(300):
        push, depth, rate, rtol = random_guide(rng, least=1e-7)
        slips = [slip for slip in slips_at_the_first_trough(push, depth, rate) if slip]
        t_end = 2 * math.pi / rate
        sol = ns.simulate(guide(push, depth, rate), (0, t_end), [0, 0], [0, 0], integrator=ns.EventDriven(rtol))
        found = np.array([*begins_of(sol, ContactMode.SLIDE), -1.0])
        total += len(slips)
        missed += [way for begin, way in slips if np.abs(found - begin).min() > 1e-10 * t_end]
    assert total > 300 and len(missed) < 0.2 * total
    assert max(missed) < 1e-12


def test_adaptive_moves_a_guide_that_slips_where_its_force_changes_sides():
    """Where the way is above the tolerance: below it a slip may be left out."""
    rng = np.random.default_rng(4)
    for _ in range(40):
        push, depth, rate, rtol = random_guide(rng)
        way = sum(way for _, way in slips_at_the_first_trough(push, depth, rate))
        system, t_end = guide(push, depth, rate), 2 * math.pi / rate
        sol = ns.simulate(system, (0, t_end), [0, 0], [0, 0], integrator=ns.Adaptive(rtol, 1e-2 * rtol))
        assert sol.q[-1, 0] == pytest.approx(way, abs=MOST * (1e-2 * rtol + rtol * way))


@pytest.mark.parametrize(
    ("integrator", "most"), [(ns.EventDriven(1e-8), 300), (ns.Adaptive(1e-8), 30)], ids=["event-driven", "adaptive"]
)
def test_guide_that_nothing_pushes_stays_where_its_force_changes_sides(integrator, most):
    """And no step ends there: nothing is decided."""
    sol = ns.simulate(guide(0.0, 0.7, 5.0), (0, 20), [0, 0], [0, 0], integrator=integrator)
    assert sol.events == [] and not sol.q.any() and sol.stats.steps < most


def test_guide_that_carries_nothing_but_rounding_stays():
    """N is 1e-15 N to either side, by turns, and nothing pulls: no side is decided upon."""

    def force(t):
        return 0.0, GRAVITY * (1 + 2e-16 * math.sin(50 * t))

    system = block(force, ns.Contact(mu=MU, bilateral=True))
    sol = ns.simulate(system, (0, 1), [0, 0], [0, 0], integrator=ns.EventDriven(1e-8), max_steps=5000)
    assert sol.events == [] and not sol.q.any()


@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("before", [0.5, -0.5])
def test_guide_that_is_pushed_after_its_force_has_changed_sides_is_held(before, rtol):
    """It is pressed to the other side, from t = 1 on, when a push of half its friction, or less, begins at t = 2."""

    def force(t):
        return 0.5 * MU * max(0.0, t - 2), GRAVITY + math.copysign(1.0, before) * (t - 1)

    system = block(force, ns.Contact(mu=MU, bilateral=True))
    sol = ns.simulate(system, (0, 5), [0, 0], [0, 0], integrator=events_at(rtol))
    assert sol.events == [] and not sol.q.any()


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_block_that_a_given_force_holds_slips_where_that_force_vanishes_for_a_moment(rtol):
    """mu N = mu (1 - (1 - 1e-3) exp(-((t - 2)/0.3)^2)) falls below F = 2e-3 mu: once, about t = 2."""

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    def force(t, q, u, p, h):
        h[0] = 2e-3 * MU

    def normal_force(t, q, u, p, N):
        N[0] = 1 - (1 - 1e-3) * math.exp(-(((t - 2) / 0.3) ** 2))

    def tangent(t, q, p, W):
        W[0, 0, 0] = 1.0

    system = ns.System(
        n_q=1, mass=mass, force=force, tangent=tangent, normal_force=normal_force,
        contacts=[ns.Contact(mu=MU, normal_force=True)],
    )  # fmt: skip
    sol = ns.simulate(system, (0, 5), [0], [0], integrator=events_at(rtol))
    begin = 2 - 0.3 * math.sqrt(math.log((1 - 1e-3) / (1 - 2e-3)))
    assert begins_of(sol, ContactMode.SLIDE) == pytest.approx([begin], abs=1e-11)


def test_weights_between_the_stages_are_those_of_the_polynomials():
    """Of one of degree 5 all six places tell it; of degree 4 the cubic misses its leading coefficient times w; of a
    cubic the stages' parabola misses the product of its three factors."""
    rng = np.random.default_rng(2)
    places = np.array(resolution.NODES)
    quintic, quartic, cubic = (np.polynomial.Polynomial(rng.normal(size=n)) for n in (6, 5, 4))
    middles = np.array(resolution.AT_MIDDLES) @ quintic(places)
    assert middles == pytest.approx(quintic(np.array(resolution.MIDDLES)), rel=1e-12, abs=1e-13)
    assert np.array(resolution.SCALES) @ quintic(places) == pytest.approx(quintic.coef[5], rel=1e-11)
    off = np.array(resolution.OFF_CUBIC) @ quartic(places[:4]) + np.array(resolution.OFF_OWN) * quartic(places[4:])
    assert np.abs(off) == pytest.approx(np.abs(quartic.coef[4]), rel=1e-11)
    between = np.array(resolution.PARABOLA) @ cubic(places[1:4])
    twist = np.array(resolution.TWIST) @ cubic(places[:4])
    exact = cubic(np.array(resolution.BETWEEN))
    assert between + twist * np.array(resolution.BENT) == pytest.approx(exact, rel=1e-12, abs=1e-13)


def two_particles():
    """Of 1 kg each, y_1'' = 1 and y_2'' = 0, above tables at zero."""

    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.0

    def force(t, q, u, p, h):
        h[0] = 1.0

    def gap(t, q, p, g):
        g[0], g[1] = q

    def normal(t, q, p, W):
        W[0, 0] = W[1, 1] = 1.0

    contacts = [ns.Contact(mu=0.0, e_N=1.0), ns.Contact(mu=0.0, e_N=1.0)]
    return ns.System(n_q=2, mass=mass, force=force, gap=gap, normal=normal, contacts=contacts)


def test_particle_that_dips_before_another_one_lands_lands_first():
    """The step of a parabola is as long as it may be: it ends where the second particle lands, and the stages of the
    longer step say nothing of the first one, which dips by 1e-7 m to 1e-4 m within 1e-3 s to 3e-2 s."""
    system, rng = two_particles(), np.random.default_rng(3)
    for _ in range(300):
        depth, at = 10 ** rng.uniform(-7, -4), rng.uniform(0.3, 0.9)
        fall = at + rng.uniform(0.03, 1.0)
        sol = ns.simulate(system, (0, fall + 0.2), [at**2 / 2 - depth, fall], [-at, -1.0], integrator=events_at(1e-8))
        first = min(sol.events, key=lambda event: event.t)
        assert (first.contact, first.t) == (0, pytest.approx(at - math.sqrt(2 * depth), abs=1e-9))
