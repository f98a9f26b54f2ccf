"""Pairs and events of scenes on springs: the ledger and the momenta as sums, closed forms, and what changes no bit."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from tests.integrators.assembly.test_pairs import WORKS, by_record, heap, on_ground

G, K = 9.81, 1e6
EPS = np.finfo(float).eps
ALL = ("bodies", "contacts", "ledger", "pairs")
LANDING, PARTING, SLIP, STICK = ns.SceneEventKind

pytestmark = pytest.mark.filterwarnings("ignore::nonsmooth.PenetrationWarning")  # of springs, which are soft to be fast


def simulate(scene, t_end, record=ALL, every=7, t_eval=None, **options):
    springs = ns.Penalty(K, **({"damping_ratio": 0.3} | options))
    return ns.simulate(scene, (0, t_end), integrator=springs, every=every, t_eval=t_eval, record=record)


def belt(dim=2):
    """A crate that slides on a running belt, with a parcel on it, and a ball that falls on both."""
    scene, up, along = ns.Scene(gravity=-G * np.eye(dim)[-1], material=ns.Material(mu=0.4)), *np.eye(dim)[[-1, 0]]
    scene.fixed(ns.Box(4.0, *[1.0] * (dim - 2), 0.1), position=-0.05 * up, surface_velocity=1.5 * along, name="belt")
    for k, name in enumerate(("crate", "parcel")):
        scene.body(ns.Box(*[0.2] * dim), mass=2.0 - k, position=(0.1 + 0.2 * k) * up, name=name)
    ball = ns.Disc(0.1) if dim == 2 else ns.Sphere(0.1)
    scene.body(ball, mass=1.0, position=0.6 * up + 0.05 * along, spin=20.0 if dim == 2 else (0, 20.0, 5.0), name="ball")
    return scene


RUNS = {
    "planar heap": (heap, {}), "spatial heap": (lambda: heap(3, n=4), {}), "belt": (belt, {}),
    "spatial belt": (lambda: belt(3), {}),
    "that pull": (heap, {"law": "kelvin-voigt"}),  # normal forces of either sign
    "regularised": (
        belt, {"law": "hunt-crossley", "friction": ns.Regularised(1e-2), "damping_ratio": None, "damping": 1.0}
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", RUNS)
def test_pairs_on_springs_sum_up_to_the_ledger_and_to_the_momenta(name):
    """Each is a sum of the same forces with the same weights, in another order: each addition rounds, of sums no larger
    than those of the sizes."""
    make, options = RUNS[name]
    scene = make()
    sol = simulate(scene, 0.3, **options)
    pairs, steps = sol.pairs, sol.stats.steps
    # of a step: seven stages of each contact, and each row of the force of a contact
    roundings = steps * 7 * sol.stats.most_contacts * scene.dim + len(pairs)
    for work in WORKS:
        size = np.abs(getattr(pairs, work)).sum() + np.abs(sol.ledger[work]).max()
        found = by_record(sol, getattr(pairs, work))
        np.testing.assert_allclose(found, sol.ledger[work], rtol=0, atol=roundings * EPS * size)
    for b, body in enumerate(scene.bodies):
        if body.kind.name != "DYNAMIC":
            continue
        got = by_record(sol, pairs.P, pairs.j == b) - by_record(sol, pairs.P, pairs.i == b)
        gained = body.mass * (sol.velocity[:, b] - sol.velocity[0, b] - np.outer(sol.t, scene.gravity))
        # each step rounds the velocity that it ends with
        size = np.abs(pairs.P).max() + body.mass * np.abs(sol.velocity[:, b]).max()
        np.testing.assert_allclose(got, gained, rtol=0, atol=(roundings + steps) * EPS * size)
        assert np.abs(gained).max() > 1e-2  # something pushed it
    np.testing.assert_array_equal(pairs.t, sol.t[pairs.record])
    assert (pairs.i < pairs.j).all() and (pairs.joint == -1).all()
    assert name not in ("belt", "spatial belt", "regularised") or np.abs(pairs.surface).sum() > 0.1


def test_two_discs_on_springs_exchange_what_each_loses():
    scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=0.3))
    scene.body(ns.Disc(0.1), mass=1.0, position=(-0.15, 0.05), velocity=(3.0, 0), spin=20.0, name="left")
    scene.body(ns.Disc(0.15), mass=2.0, position=(0.15, 0), velocity=(-2.0, 0.5), name="right")
    sol = simulate(scene, 0.1, every=1, t_eval=[0.1])
    (pair,) = sol.pairs
    assert (pair.i, pair.j, pair.joint) == ("left", "right", "") and abs(pair.P[0]) > 1.0
    for sign, name, m in ((-1, "left", 1.0), (1, "right", 2.0)):
        change = m * (sol[name].velocity[-1] - sol[name].velocity[0])
        # rounded once in each step, as are the impulses
        np.testing.assert_allclose(sign * pair.P, change, rtol=0, atol=2 * 7 * sol.stats.steps * EPS * 6.0)


def test_a_block_that_slides_on_springs_gives_its_momentum_and_its_energy_to_the_ground():
    """The end of the slide is met to the tolerance of the steps, 1e-8 of the speed each."""
    m, v, mu = 2.0, 1.0, 0.5
    scene = on_ground(mu=mu)
    scene.body(ns.Box(0.4, 0.02), mass=m, position=(0, 0.01 - m * G / (2 * K)), velocity=(v, 0), name="block")
    sol = simulate(scene, 0.4, damping_ratio=0.9)
    (whole,) = sol.pairs.total()
    assert (whole.i, whole.j) == ("ground", "block")
    at_rest = m * np.abs(sol.velocity[-1, 1]).max()
    np.testing.assert_allclose(whole.P, (-m * v, m * G * 0.4), rtol=0, atol=at_rest + sol.stats.steps * 1e-8 * m * v)
    held = sol.ledger["elastic"][-1] - sol.ledger["elastic"][0]
    atol = abs(held) + sol.stats.steps * 1e-8 * m * v**2 + abs(sol.ledger["damping"][-1])
    assert whole.friction == pytest.approx(-m * v**2 / 2, abs=atol) and atol < 1e-3 and whole.surface == 0.0


@pytest.mark.upkeep
def test_more_pairs_meet_between_two_records_than_there_was_room_for():
    """A gas of discs on springs, whose walls push without friction; one long interval against short ones."""

    def gas(every):
        scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=0.2))
        for k, (x, y, side) in enumerate(((0, -1, (9, 1)), (0, 3, (9, 1)), (-2, 1, (1, 9)), (2, 1, (1, 9)))):
            scene.fixed(ns.Box(*side), position=(x, y), name=f"wall {k}")
        rng = np.random.default_rng(1)
        for k in range(16):
            place = (-1.1 + 0.7 * (k % 4), 0.7 * (k // 4) - 0.1)
            scene.body(ns.Disc(0.15), mass=1.0, position=place, velocity=rng.normal(size=2) * 6.0, name=f"disc {k}")
        return simulate(scene, 2.0, every=every, damping_ratio=0.0)

    long, short = gas(10**6), gas(50)
    one, many = long.pairs, short.pairs.total()
    assert len(one) > 2 * 20 + 16  # the room at the start
    for name in ("i", "j", "joint"):
        np.testing.assert_array_equal(getattr(one, name), getattr(many, name))
    for name in ("P", *WORKS):
        size = np.abs(getattr(short.pairs, name)).sum()
        np.testing.assert_allclose(getattr(one, name), getattr(many, name), rtol=0, atol=long.stats.steps * EPS * size)
    np.testing.assert_array_equal(long.q[-1], short.q[-1])


@pytest.mark.parametrize("record", ["pairs", "events"])
def test_pairs_and_events_on_springs_change_no_bit_of_the_run(record):
    scene = belt()
    plain = simulate(scene, 0.1, record=("bodies", "ledger"))
    asked = simulate(scene, 0.1, record=("bodies", "ledger", record))
    for name in ("t", "position", "velocity", "penetration"):
        assert getattr(plain, name).tobytes() == getattr(asked, name).tobytes()
    assert all(plain.ledger[name].tobytes() == asked.ledger[name].tobytes() for name in plain.ledger)
    assert plain.stats.steps == asked.stats.steps and len(getattr(asked, record)) > 0
    with pytest.raises(ns.InvalidInput, match=f"{record} was not recorded"):
        getattr(plain, record)


def kinds_of(events):
    return [event.kind for event in events]


def test_a_ball_on_a_spring_lands_where_its_fall_ends_and_parts_half_a_period_later():
    """Without weight: it flies at v to the wall, is on it for pi sqrt(m/k), and comes back no more."""
    m, v = 2.0, 0.5
    scene = ns.Scene(gravity=(0, 0))
    scene.fixed(ns.HalfPlane((0, 1)), name="wall")
    scene.body(ns.Disc(0.1), mass=m, position=(0, 0.15), velocity=(0, -v), name="ball")
    sol = simulate(scene, 0.15, record=("bodies", "contacts", "events"), every=1, damping_ratio=0.0)
    landing, parting = sol.events
    step = sol.stats.lengths.longest
    assert (landing.kind, parting.kind) == (LANDING, PARTING) and (landing.i, landing.j) == ("wall", "ball")
    assert 0.0 <= 0.05 / v - landing.t <= step  # the beginning of the step in which it lands
    half = math.pi * math.sqrt(m / K)
    assert -1e-6 * half <= 0.05 / v + half - parting.t <= step + 1e-6 * half
    at_end = sol.contacts(sol.t[sol.t > landing.t][0])
    assert landing.P_N == at_end.P_N.sum() > 0.0  # forces [N], as those of contacts
    np.testing.assert_array_equal(landing.P, at_end.P.sum(axis=0))
    assert parting.P_N == 0.0


def test_an_event_of_the_user_finds_where_a_ball_turns_round_on_its_spring():
    """A quarter of a period after it landed: located on a cubic of the step, whose rate errs by sqrt(3)/216 of h^3
    times the fourth derivative of the place, v omega^3, against v omega, with which it passes through zero."""
    m, v = 2.0, 0.5

    def turns(t, bodies):
        return bodies["ball"].velocity[1]

    turns.terminal = True
    scene = ns.Scene(gravity=(0, 0))
    scene.fixed(ns.HalfPlane((0, 1)), name="wall")
    scene.body(ns.Disc(0.1), mass=m, position=(0, 0.15), velocity=(0, -v), name="ball")
    springs, omega = ns.Penalty(K, damping_ratio=0.0), math.sqrt(K / m)
    sol = ns.simulate(scene, (0, 0.2), integrator=springs, events=turns)
    h, exact = sol.stats.lengths.longest, 0.05 / v + 0.5 * math.pi / omega
    atol = math.sqrt(3) / 216 * h**3 * omega**2 + sol.stats.steps * 1e-8 / omega
    assert sol.status == ns.Status.EVENT_REACHED and atol < 0.01 * h
    assert sol.t_events[0][0] == pytest.approx(exact, abs=atol) and exact - atol <= sol.t[-1] <= exact + h


def test_a_block_that_slides_on_springs_sticks_when_its_speed_is_spent():
    """At v/(mu g), in the step that this lies in, or the next one: springs are stretched, and shake for a while."""
    v, mu = 1.0, 0.5
    scene = on_ground(mu=mu)
    scene.body(ns.Box(0.4, 0.02), mass=2.0, position=(0, 0.01 - G / K), velocity=(v, 0), name="block")
    sol = simulate(scene, 0.3, record="events", damping_ratio=0.9)
    (stick,) = sol.events
    assert stick.kind == STICK and abs(v / (mu * G) - stick.t) <= 2.0 * sol.stats.lengths.longest


def test_a_block_on_springs_that_is_hit_slips_at_its_limit_and_sticks_below_it():
    """A ball without friction hits a block from the side."""
    scene = on_ground(mu=0.5)
    m, slick = 2.0, ns.Material(mu=0.0)
    scene.body(ns.Box(0.4, 0.2), mass=m, position=(0, 0.1 - m * G / (2 * K)), name="block")
    scene.body(ns.Disc(0.05), mass=1.0, position=(-0.3, 0.1), velocity=(3.0, 0), material=slick, name="ball")
    sol = simulate(scene, 0.6, record=("bodies", "events"), every=1, damping_ratio=0.9)
    assert kinds_of(sol.events.of("ball", "block"))[:2] == [LANDING, PARTING]
    found = sol.events.of("ground", "block")
    slip, stick = found[0], found[len(found) - 1]
    hit = sol.events.of("ball", "block").t[0]
    assert slip.kind == SLIP and stick.kind == STICK and hit <= slip.t
    assert abs(slip.P[0]) == pytest.approx(0.5 * slip.P_N, rel=1e-8) and abs(stick.P[0]) < 0.5 * stick.P_N


SOFT = {
    "springs": ns.Penalty(K, damping_ratio=0.9),
    "compliance": ns.MoreauJean(1e-3, theta=1.0, compliance=ns.Compliance(K, 1e3)),
}


@pytest.mark.parametrize("name", SOFT)
def test_what_stands_on_springs_from_the_start_has_not_landed(name):
    """At the depth that bears it, or at no depth, as it is placed by a user who thinks of rigid bodies."""
    scene = on_ground(mu=0.5)
    for k, depth in enumerate((2.0 * G / (2 * K), 0.0)):
        scene.body(ns.Box(0.4, 0.2), mass=2.0, position=(k, 0.1 - depth), name=f"block {k}")
    scene.body(ns.Disc(0.1), mass=1.0, position=(3, 0.15), name="ball")
    events = ns.simulate(scene, (0, 0.2), integrator=SOFT[name], record="events").events
    assert kinds_of(events.of("ball"))[0] == LANDING
    assert len(events.of("block 0")) == len(events.of("block 1")) == 0


def test_events_of_springs_are_saved_and_have_units_of_forces(tmp_path):
    pytest.importorskip("xarray")
    pytest.importorskip("pandas")
    sol = simulate(belt(), 0.1, record=("bodies", "events", "pairs"))
    read = ns.SceneSolution.load(sol.save(tmp_path / "run.npz"))
    for kind in ("events", "pairs"):
        for name, column in getattr(sol, kind).columns.items():
            np.testing.assert_array_equal(getattr(read, kind).columns[name], column)
    data = sol.to_xarray()
    assert data.event_P.units == data.event_P_N.units == "N" and data.pair_P.units == "N s"
    assert list(sol.to_dataframe("events").kind) == [event.kind.name for event in sol.events]
    assert len(sol.to_dataframe("pairs")) == len(sol.pairs)
