"""What pairs of bodies exchange: closed forms, the whole ledger and the momenta as sums, and bits of cut runs."""

import numpy as np
import pytest

import nonsmooth as ns

G = 9.81
EPS = np.finfo(float).eps
WORKS = ("normal", "friction", "surface")
ALL = ("bodies", "contacts", "ledger", "pairs")

pytestmark = pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # of small heaps


def simulate(scene, t_end, dt=2e-3, may_sleep=True, compliance=None, theta=0.5, **options):
    contacts = ns.ContactSolver(may_sleep=may_sleep)
    integrator = ns.MoreauJean(dt=dt, contacts=contacts, compliance=compliance, theta=theta)
    return ns.simulate(scene, (0, t_end), integrator=integrator, **({"record": ALL} | options))


def on_ground(dim=2, **material):
    up = np.eye(dim)[-1]
    scene = ns.Scene(gravity=-G * up, material=ns.Material(**material))
    scene.fixed((ns.HalfPlane if dim == 2 else ns.HalfSpace)(up), name="ground")
    return scene


def heap(dim=2, e=0.4, n=6):
    """Boxes and round bodies that fall on one another, land and rebound."""
    scene, up, along = on_ground(dim, mu=0.3, e=e), np.eye(dim)[-1], np.eye(dim)[0]
    for k in range(n):
        shape = ns.Box(*[0.2] * dim) if k % 2 else (ns.Disc if dim == 2 else ns.Sphere)(0.1)
        place = 0.03 * k * along + (0.2 + 0.25 * k) * up
        scene.body(shape, mass=1.0 + k, position=place, velocity=0.5 * along, name=f"body {k}")
    return scene


def chain_on_a_heap():
    scene = heap(n=3)
    for k in range(4):
        scene.body(ns.Box(0.16, 0.04), mass=0.5, position=(0.3 + 0.2 * k, 1.2), name=f"link {k}")
    for k in range(3):
        scene.joint(f"link {k}", f"link {k + 1}", at=(0.4 + 0.2 * k, 1.2), name=f"pin {k}")
    return scene


def spatial_chain():
    """Boxes on ball joints, one of which hangs on a guided hand, over the ground."""
    scene = on_ground(3, mu=0.4)
    scene.kinematic(ns.Sphere(0.02), motion=lambda t: (0.1 - 0.1 * np.cos(5 * t), 0.0, 0.5), name="hand")
    for k in range(3):
        scene.body(ns.Box(0.16, 0.04, 0.03), mass=0.5, position=(0.1 + 0.2 * k, 0, 0.5), name=f"link {k}")
        scene.joint("hand" if k == 0 else f"link {k - 1}", f"link {k}", at=(0.2 * k, 0, 0.5))
    return scene


def shaken_tray():
    """Boxes on a guided tray, and one on a belt."""
    scene = on_ground(mu=0.5)
    scene.kinematic(ns.Box(2, 0.1), motion=lambda t: (0.1 * np.sin(20 * t), 0.5 + 0.02 * np.sin(15 * t)), name="tray")
    scene.fixed(ns.Box(2, 0.1), position=(3, 0.5), surface_velocity=(1.5, 0), name="belt")
    for k in range(2):
        scene.body(ns.Box(0.2, 0.2), mass=1.0 + k, position=(0, 0.65 + 0.2 * k), name=f"box {k}")
    scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(3, 0.65), name="parcel")
    return scene


SCENES = {
    "planar heap": (heap, {}), "spatial heap": (lambda: heap(3), {}), "inelastic": (lambda: heap(e=0.0), {}),
    "chain": (chain_on_a_heap, {}), "spatial chain": (spatial_chain, {}), "tray and belt": (shaken_tray, {}),
    "compliant": (lambda: heap(e=0.0), {"compliance": ns.Compliance(1e7, damping=100.0), "theta": 1.0}),
}  # fmt: skip


def by_record(sol, values, rows=slice(None)):
    """Sums since the start at each record."""
    sums = np.zeros((len(sol.t), *values.shape[1:]))
    np.add.at(sums, sol.pairs.record[rows], values[rows])
    return np.cumsum(sums, axis=0)


@pytest.mark.parametrize("name", SCENES)
def test_works_of_pairs_add_up_to_the_ledger_and_impulses_to_the_momentum_of_each_body(name):
    make, options = SCENES[name]
    scene = make()
    sol = simulate(scene, 0.8, every=7, **options)
    pairs, steps = sol.pairs, sol.stats.steps
    for work in WORKS:
        # a sum of so many terms, in another order: each addition rounds, of sums no larger than those of the sizes
        size = np.abs(getattr(pairs, work)).sum() + np.abs(sol.ledger[work]).max()
        found = by_record(sol, getattr(pairs, work))
        np.testing.assert_allclose(found, sol.ledger[work], rtol=0, atol=(steps + len(pairs)) * EPS * size)
    for b, body in enumerate(scene.bodies):
        if body.kind.name != "DYNAMIC":
            continue
        m = body.mass
        got = by_record(sol, pairs.P, pairs.j == b) - by_record(sol, pairs.P, pairs.i == b)
        gained = m * (sol.velocity[:, b] - sol.velocity[0, b] - np.outer(sol.t, scene.gravity))
        # velocities that are roundings of the impulses beneath become 0 (docs/theory/scenes.md, rest): 8192 a step
        size = np.abs(pairs.P).max()
        np.testing.assert_allclose(got, gained, rtol=0, atol=8192 * steps * EPS * size)
        assert np.abs(gained).max() > 1e-2  # something pushed it
    assert (pairs.record > 0).all() and (np.diff(pairs.record) >= 0).all()
    np.testing.assert_array_equal(pairs.t, sol.t[pairs.record])


def test_two_discs_that_collide_at_an_angle_exchange_what_each_loses():
    """Their normal turns between landing and rebound: impulses along rows of one place do not add up."""
    scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=0.3, e=0.8))
    scene.body(ns.Disc(0.1), mass=1.0, position=(-0.3, 0.05), velocity=(3.0, 0), spin=20.0, name="left")
    scene.body(ns.Disc(0.15), mass=2.0, position=(0.3, 0), velocity=(-2.0, 0.5), name="right")
    sol = simulate(scene, 0.2, dt=4e-3)
    (pair,) = sol.pairs
    assert (pair.i, pair.j, pair.joint) == ("left", "right", "")
    for sign, name, m in ((-1, "left", 1.0), (1, "right", 2.0)):
        change = m * (sol[name].velocity[-1] - sol[name].velocity[0])
        np.testing.assert_allclose(sign * pair.P, change, rtol=1e-14)
    assert abs(pair.P[0]) > 1.0
    kinetic = sol.ledger["kinetic"]
    assert pair.normal + pair.friction == pytest.approx(kinetic[-1] - kinetic[0], rel=1e-13)


def test_a_block_that_slides_to_rest_gives_its_momentum_and_its_energy_to_the_ground():
    m, v, mu = 2.0, 1.0, 0.5
    scene = on_ground(mu=mu)
    scene.body(ns.Box(0.2, 0.02), mass=m, position=(0, 0.01), velocity=(v, 0), name="block")
    sol = simulate(scene, 0.4, every=10)
    (whole,) = sol.pairs.total()
    assert (whole.i, whole.j) == ("ground", "block")
    np.testing.assert_allclose(whole.P, (-m * v, m * G * 0.4), rtol=1e-12)
    assert whole.friction == pytest.approx(-m * v**2 / 2, rel=1e-12)
    assert abs(whole.normal) < 1e-12 and whole.surface == 0.0
    first = sol.pairs[0]
    assert first.t == sol.t[1]
    np.testing.assert_allclose(first.P, (-mu * m * G * 0.02, m * G * 0.02), rtol=1e-12)  # ten steps of 2 ms
    assert first.friction == pytest.approx(-mu * m * G * (v * 0.02 - mu * G * 0.02**2 / 2), rel=1e-12)


def test_a_belt_puts_in_what_a_sliding_parcel_takes_and_rubs_away():
    m, mu, v, t = 1.5, 0.25, 4.0, 0.5  # it slides all the time
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=mu))
    scene.fixed(ns.Box(20, 0.1), position=(0, -0.05), surface_velocity=(v, 0), name="belt")
    scene.body(ns.Box(0.4, 0.02), mass=m, position=(0, 0.01), name="parcel")
    (pair,) = simulate(scene, t, every=10**6).pairs
    np.testing.assert_allclose(pair.P, (mu * m * G * t, m * G * t), rtol=1e-12)
    assert pair.surface == pytest.approx(mu * m * G * v * t, rel=1e-12)
    assert pair.friction == pytest.approx(-mu * m * G * (v * t - mu * G * t**2 / 2), rel=1e-12)


def test_a_joint_is_a_pair_of_its_own_and_does_no_work_to_second_order():
    works = []
    for dt in (4e-3, 2e-3, 1e-3):
        scene = ns.Scene(gravity=(0, -G))
        scene.fixed(ns.Disc(0.02), name="hook")
        scene.body(ns.Box(1.0, 0.02), mass=2.0, position=(0.5, 0), name="rod")
        scene.joint("hook", "rod", at=(0, 0), name="pin")
        sol = simulate(scene, 0.3, dt=dt, every=50)
        (pair,) = sol.pairs.total()
        assert (pair.i, pair.j, pair.joint) == ("hook", "rod", "pin")
        np.testing.assert_allclose(pair.P, 2.0 * (sol["rod"].velocity[-1] + (0, G * 0.3)), rtol=1e-12)
        works.append(abs(pair.normal))
        assert pair.friction == pair.surface == 0.0
    assert abs(np.log2(works[0] / works[1]) - 2) < 0.2 and abs(np.log2(works[1] / works[2]) - 2) < 0.2


def box_at_rest_and_ball():
    """A pile that sleeps while a ball rolls elsewhere, and, where the ball is left out, altogether."""
    scene = on_ground(mu=0.5)
    for k in range(3):
        scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(0, 0.1 + 0.2 * k), name=f"box {k}")
    return scene


@pytest.mark.parametrize("has_ball", [True, False])
def test_what_sleeps_goes_on_with_its_weight_and_no_bit_depends_on_its_sleep(has_ball):
    def run(may_sleep, threads=1):
        scene = box_at_rest_and_ball()
        if has_ball:
            scene.body(ns.Disc(0.1), mass=1.0, position=(-6, 0.1), velocity=(2, 0), spin=-20.0, name="ball")
        return simulate(scene, 1.0, may_sleep=may_sleep, every=50, threads=threads)

    asleep, awake, shared = run(True), run(False), run(True, threads=2)
    assert (asleep.stats.islands_asleep if has_ball else asleep.stats.asleep) > 490
    for name in asleep.pairs.columns:
        np.testing.assert_array_equal(getattr(asleep.pairs, name), getattr(awake.pairs, name), err_msg=name)
        np.testing.assert_array_equal(getattr(asleep.pairs, name), getattr(shared.pairs, name), err_msg=name)
    for above, (i, j) in zip((3, 2, 1), (("ground", "box 0"), ("box 0", "box 1"), ("box 1", "box 2")), strict=True):
        found = asleep.pairs.of(i, j)
        assert len(found) == 10  # intervals of 0.1 s
        np.testing.assert_allclose(found.P, np.tile((0, above * G * 0.1), (10, 1)), rtol=1e-11, atol=1e-12)
        assert not found.normal.any() and not found.friction.any()


def test_a_run_that_is_stopped_between_records_has_what_was_exchanged_until_then():
    m = 1.0
    scene = on_ground(mu=0.5)
    scene.body(ns.Box(0.2, 0.2), mass=m, position=(0, 0.1), name="box")
    sol = simulate(scene, 1.0, every=100, max_steps=130, on_failure="return")
    assert len(sol.t) == 3
    np.testing.assert_allclose(sol.pairs.P[:, 1], (m * G * 0.2, m * G * 0.06), rtol=1e-12)


def test_many_pairs_in_one_interval_find_room_and_are_those_of_short_intervals():
    """More pairs than there are bodies meet between two records: the block grows."""

    def gas(every):
        scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=0.2, e=1.0))
        for k, (x, y, side) in enumerate(((0, -1, (9, 1)), (0, 3, (9, 1)), (-2, 1, (1, 9)), (2, 1, (1, 9)))):
            scene.fixed(ns.Box(*side), position=(x, y), name=f"wall {k}")
        rng = np.random.default_rng(1)
        for k in range(16):
            place = (-1.1 + 0.7 * (k % 4), 0.7 * (k // 4) - 0.1)
            scene.body(ns.Disc(0.15), mass=1.0, position=place, velocity=rng.normal(size=2) * 6.0, name=f"disc {k}")
        return simulate(scene, 2.0, every=every)

    long, short = gas(10**6), gas(10)
    one, many = long.pairs, short.pairs.total()
    assert len(one) > 2 * 20 + 16  # the room at the start
    for name in ("i", "j", "joint"):
        np.testing.assert_array_equal(getattr(one, name), getattr(many, name))
    for name in ("P", *WORKS):
        size = np.abs(getattr(short.pairs, name)).sum()
        np.testing.assert_allclose(getattr(one, name), getattr(many, name), rtol=0, atol=2000 * EPS * size)
    np.testing.assert_array_equal(long.q[-1], short.q[-1])


def test_pairs_are_kept_where_they_are_asked_for_and_change_no_bit():
    plain, asked = simulate(heap(), 0.3, record=None), simulate(heap(), 0.3)
    np.testing.assert_array_equal(plain.q, asked.q)
    np.testing.assert_array_equal(plain.u, asked.u)
    for name in plain.ledger:
        np.testing.assert_array_equal(plain.ledger[name], asked.ledger[name])
    assert "pairs" not in plain.recorded
    with pytest.raises(ns.InvalidInput, match=r'pairs was not recorded; simulate\(..., record=\("pairs"'):
        plain.pairs  # noqa: B018


def test_rows_are_found_by_name_and_read_in_words():
    sol = simulate(chain_on_a_heap(), 0.6, every=20)
    pairs = sol.pairs
    of_both = [pair.t for pair in pairs if {pair.i, pair.j} == {"ground", "body 1"}]
    assert list(pairs.of("body 1", "ground").t) == of_both and len(of_both) > 0
    held = {(pair.i, pair.j, pair.joint) for pair in pairs.of("link 1") if pair.joint}
    assert held == {("link 0", "link 1", "pin 0"), ("link 1", "link 2", "pin 1")}
    assert repr(pairs) == f"ScenePairs({len(pairs)} rows of {len(pairs.total())} pairs)"
    with pytest.raises(ns.InvalidInput, match="there is no body 'link 9'"):
        pairs.of("link 9")


def test_a_run_without_contacts_has_no_pairs():
    scene = ns.Scene(gravity=(0, -G))
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 1))
    pairs = simulate(scene, 0.1).pairs
    assert len(pairs) == len(pairs.total()) == 0 and repr(pairs) == "ScenePairs(0 rows of 0 pairs)"


@pytest.mark.parametrize("ending", ["npz", "h5", "nc"])
def test_pairs_are_read_back(tmp_path, ending):
    pytest.importorskip({"npz": "numpy", "h5": "h5py", "nc": "netCDF4"}[ending])
    sol = simulate(chain_on_a_heap(), 0.5, every=20)
    read = ns.SceneSolution.load(sol.save(tmp_path / f"run.{ending}")).pairs
    assert (read.names, read.joint_names) == (sol.pairs.names, sol.pairs.joint_names)
    assert read.columns.keys() == sol.pairs.columns.keys()
    for name, column in read.columns.items():
        np.testing.assert_array_equal(column, sol.pairs.columns[name])


def test_pairs_by_name_in_a_table_and_a_dataset():
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    sol = simulate(chain_on_a_heap(), 0.5, every=20)
    table, data, pairs = sol.to_dataframe("pairs"), sol.to_xarray(), sol.pairs
    assert list(table.i) == [pair.i for pair in pairs] and list(table.joint) == [pair.joint for pair in pairs]
    np.testing.assert_array_equal(table["friction [J]"], pairs.friction)
    np.testing.assert_array_equal(table.P_y, pairs.P[:, 1])
    np.testing.assert_array_equal(data.pair_P, pairs.P)
    np.testing.assert_array_equal(data.pair_record, pairs.record)
    assert data.pair_P.units == "N s" and data.pair_normal.units == "J"
