"""Painlevé's paradoxes in scenes: against Systems, closed forms, enumerations; whatever else there is, and named so."""

import json
import math

import numpy as np
import pytest

import nonsmooth as ns
from models import PainleveRod
from nonsmooth.commands.results_of_runs import as_json
from nonsmooth.contact.network.problem import Network, prepare_network
from nonsmooth.contact.planar.enumerate import enumerate_modes
from nonsmooth.contact.planar.ladder import solve_planar
from nonsmooth.contact.planar.newton import solve_by_newton
from nonsmooth.contact.planar.problem import Planar, problem_of
from nonsmooth.integrators.assembly import paradox
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.doubtful import Doubts, find_doubtful
from nonsmooth.jit import load_all
from nonsmooth.jit.blocks import new
from nonsmooth.jit.kernels import called_by
from nonsmooth.mechanics.system import UNILATERAL
from nonsmooth.scenes.detection import Found

G, DT = 9.81, 1e-3
STEP = ns.MoreauJean(dt=DT)
THIN, THIN_BOX = 1e-9, 1e-3  # m, of a rod; of a box in space, which slides on two corners
TH = math.pi / 3
INCONSISTENT, INDETERMINATE = ns.EventKind.INCONSISTENT, ns.EventKind.INDETERMINATE


def add_rod(scene, th=TH, thdot=0.0, slip=-1.0, at=0.0, name="rod", is_mirrored=False, shape="capsule"):
    """A rod of 1 m and 1 kg whose tip slides on y = 0."""
    q, u = PainleveRod().state(th=th, thdot=thdot, slip=slip)
    shapes = {
        "capsule": (ns.Capsule(1.0, THIN), THIN),
        "box": (ns.Box(1.0, THIN), 0.5 * THIN * math.cos(th)),
        "polygon": (ns.Polygon([(-0.5, 0), (0, -0.01), (0.5, 0), (0, 0.01)]), 0.0),
    }
    body, lift = shapes[shape]
    x, vx, turn, spin = q[0], u[0] - lift * thdot, q[2], u[2]
    if is_mirrored:
        x, vx, turn, spin = -x, -vx, math.pi - turn, -spin
    scene.body(body, mass=1.0, inertia=1 / 12, name=name, position=(at + x, q[1] + lift), turn=turn,
               velocity=(vx, u[1]), spin=spin)  # fmt: skip


def rod_scene(mu=2.0, last=False, **rod):
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=mu))
    if not last:
        scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    add_rod(scene, **rod)
    if last:
        scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    return scene


def run(scene, t_end=0.02, dt=DT, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)


def as_system(scene, t_end=0.02, dt=DT):
    return ns.simulate(scene.system(), (0, t_end), *scene.state(), integrator=ns.MoreauJean(dt=dt))


def told(event):
    return (
        event.t,
        event.kind,
        event.n_solutions,
        event.alternatives,
        event.choice,
        event.mode_before,
        event.slip_before,
    )


@pytest.mark.upkeep
@pytest.mark.parametrize("shape", ["capsule", "polygon"])
@pytest.mark.parametrize(("thdot", "kind"), [(0.0, INCONSISTENT), (6.0, INDETERMINATE)])
def test_a_rod_in_a_paradox_is_named_as_the_same_rod_as_a_system_is(thdot, kind, shape):
    scene = rod_scene(thdot=thdot, shape=shape)
    found, system = run(scene), as_system(scene)
    assert [event.kind for event in found.paradoxes] == [kind]
    event, same = found.paradoxes[0], system.paradoxes[0]
    assert told(event) == told(same)
    assert (event.i, event.j) == ("ground", "rod")
    np.testing.assert_allclose([event.P_N, event.P_F], [same.P_N, same.P_F], rtol=1e-6)
    assert event.gamma_F == pytest.approx(-1.0, abs=1e-8)
    assert found.stats.indeterminate_steps == system.stats.indeterminate_steps
    assert found.stats.inconsistent == (kind == INCONSISTENT)


def test_a_box_that_is_a_rod_is_named_too():
    assert [told(event) for event in run(rod_scene(shape="box")).paradoxes] == [
        told(event) for event in run(rod_scene(shape="capsule")).paradoxes
    ]


def test_of_several_solutions_a_scene_takes_that_of_a_system_to_rounding():
    """It lifts off, by the centrifugal acceleration of its tip, which the step of a scene knows since it is asked."""
    scene = rod_scene(thdot=6.0)
    found, system = run(scene, 0.1), as_system(scene, 0.1)
    np.testing.assert_allclose(found.q[-1, 3:], system.q[-1], atol=1e-12)
    np.testing.assert_allclose(found.u[-1, 3:], system.u[-1], atol=1e-12)
    b = 6.0**2 * math.sin(TH) / 2 - G
    y_tip = found["rod"].position[10, 1] - 0.5 * math.sin(found["rod"].turn[10])
    assert y_tip == pytest.approx(0.5 * b * (10 * DT) ** 2, rel=0.1)


def test_an_impact_without_collision_is_that_of_a_system_to_first_order_of_the_step():
    """A System takes it before its step, a scene within it."""
    scene, errors = rod_scene(), []
    for dt in (2e-3, 1e-3, 5e-4):
        found, system = run(scene, 0.1, dt), as_system(scene, 0.1, dt)
        errors.append(np.abs(found.q[-1, 3:] - system.q[-1]).max())
    assert errors[0] < 1.0 * 2e-3  # what the tip slides in a step
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 2.0, rtol=0.1)


@pytest.mark.parametrize("th", [0.6, 0.9, math.atan(2.0), 1.3])
@pytest.mark.parametrize("side", [-1, 1])
def test_critical_friction_is_that_of_the_closed_form_from_both_sides(th, side):
    """(1 + 3 cos^2 th)/(3 sin th cos th); pushed ahead, at rest but for its slide."""
    critical = (1 + 3 * math.cos(th) ** 2) / (3 * math.sin(th) * math.cos(th))
    for part in (1e-4, 0.1):
        ahead = run(rod_scene(mu=critical * (1 + side * part), th=th), 5 * DT).paradoxes
        assert [event.kind for event in ahead] == ([INCONSISTENT] if side > 0 else [])
        assert run(rod_scene(mu=critical * (1 + side * part), th=th, slip=1.0), 5 * DT).paradoxes == []  # drawn


@pytest.mark.parametrize("thdot", [0.0, 6.0])
def test_a_mirrored_scene_has_mirrored_names(thdot):
    (event,) = run(rod_scene(thdot=thdot)).paradoxes
    (mirrored,) = run(rod_scene(thdot=thdot, is_mirrored=True)).paradoxes
    turned = {"slide -": "slide +"}
    assert mirrored.alternatives == tuple(turned.get(name, name) for name in event.alternatives)
    assert (mirrored.kind, mirrored.choice, mirrored.slip_before) == (event.kind, event.choice, -event.slip_before)
    np.testing.assert_allclose(mirrored.P_N, event.P_N, rtol=1e-12)
    np.testing.assert_allclose(mirrored.P_F, -event.P_F, rtol=1e-12)


@pytest.mark.parametrize("thdot", [0.0, 6.0])
def test_the_order_of_the_bodies_changes_no_sign(thdot):
    (event,), (other,) = (run(rod_scene(thdot=thdot, last=last)).paradoxes for last in (False, True))
    assert told(event) == told(other)
    assert {event.i, event.j} == {other.i, other.j}
    np.testing.assert_allclose([event.P_N, event.P_F], [other.P_N, other.P_F], rtol=1e-12)


def test_two_rods_at_once_are_named_each():
    scene = rod_scene(name="seized")
    add_rod(scene, thdot=6.0, at=5.0, name="lifted")
    first, second = run(scene).paradoxes
    assert (first.kind, first.j, first.t) == (INCONSISTENT, "seized", 0.0)
    assert (second.kind, second.j, second.t) == (INDETERMINATE, "lifted", 0.0)
    (alone,) = run(rod_scene(thdot=6.0)).paradoxes
    assert told(second) == told(alone)


def test_a_rod_among_a_hundred_bodies_moves_as_it_does_alone():
    scene = rod_scene(name="rod")
    rng = np.random.default_rng(3)
    for k in range(100):
        x, y = 3.0 + 0.25 * (k % 20) + 0.01 * rng.uniform(), 0.1 + 0.25 * (k // 20)
        scene.body(ns.Disc(0.1), mass=1.0, position=(x, y), name=f"disc {k}")
    many, alone = run(scene, 0.05), run(rod_scene(), 0.05)
    assert [told(event) for event in many.paradoxes] == [told(event) for event in alone.paradoxes]
    np.testing.assert_allclose(many["rod"].position[-1], alone["rod"].position[-1], atol=1e-12)


def test_what_is_told_does_not_hang_on_what_is_recorded():
    records = [None, ("bodies",), ("ledger", "events")]
    found = [run(rod_scene(), record=record).paradoxes for record in records]
    assert [[told(event) for event in events] for events in found] == [[told(found[0][0])]] * 3


def test_a_slide_that_runs_into_the_paradox_is_told_at_the_step_of_the_system():
    """Pushed at 5 m/s; found by a search: most motions lift off before."""
    rod = {"th": 0.437, "thdot": 2.933, "slip": -5.156}
    scene = rod_scene(mu=2.051, **rod)
    found, system = run(scene, 0.08, 1e-4, every=10), as_system(scene, 0.08, 1e-4)
    assert [event.kind for event in found.paradoxes] == [event.kind for event in system.paradoxes] == [INCONSISTENT]
    assert found.paradoxes[0].t == pytest.approx(system.paradoxes[0].t, abs=2e-4)
    assert found.paradoxes[0].t > 0.05


def grooved(half, up, mu=0.7):
    """A disc between two walls at a half angle [rad], at rest, pulled up by ``up`` times its weight."""
    scene = ns.Scene(gravity=(0, G * (up - 1)), material=ns.Material(mu=mu))
    for name, side in (("left", 1), ("right", -1)):
        scene.fixed(ns.HalfPlane((side * math.cos(half), math.sin(half))), name=name)
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0.1 / math.sin(half)), name="disc")
    return scene


@pytest.mark.parametrize("part", [0.5, 0.99, 1.01, 1.2])
def test_a_disc_is_jammed_in_a_groove_narrower_than_the_angle_of_friction(part):
    """Pulled up it may stay, since both walls hold it by forces along the line between them, or leave: by the rule
    what stuck sticks. In a wider groove it leaves, and pressed down it stays in either, which is one motion."""
    half = part * math.atan(0.7)
    pulled, pressed = run(grooved(half, 2.0)), run(grooved(half, 0.0))
    assert pressed.paradoxes == []
    if part > 1:
        assert pulled.paradoxes == []
        assert pulled["disc"].position[-1, 1] > pulled["disc"].position[0, 1] + 1e-4
        return
    assert [(event.i, event.j, event.t) for event in pulled.paradoxes] == [
        ("left", "disc", 0.0),
        ("right", "disc", 0.0),
    ]
    assert {(event.kind, event.n_solutions, event.choice) for event in pulled.paradoxes} == {
        (INDETERMINATE, 2, "stick")
    }
    np.testing.assert_allclose(pulled["disc"].position[-1], pulled["disc"].position[0], atol=1e-12)


def quaternion(axis, angle):
    return np.array([math.cos(angle / 2), *(math.sin(angle / 2) * np.asarray(axis, float))])


def after(a, b):
    """The quaternion of turn b, then a."""
    vector = a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *vector])


def spatial_rod(mu=2.0, th=TH, thdot=0.0, slip=-1.0, azimuth=0.0, shape="capsule", last=False):
    """The rod in a vertical plane of space; about its own axis it is hard to turn, so that it does not roll."""
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=mu))
    if not last:
        scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    e, side = np.array([math.cos(azimuth), math.sin(azimuth), 0]), np.array([-math.sin(azimuth), math.cos(azimuth), 0])
    along = math.cos(th) * e + np.array([0, 0, math.sin(th)])
    across = -math.sin(th) * e + np.array([0, 0, math.cos(th)])
    arm = -0.5 * along - (np.array([0, 0, THIN]) if shape == "capsule" else 0.5 * THIN_BOX * across)
    spin = -thdot * side
    scene.body(
        ns.Capsule(1.0, THIN) if shape == "capsule" else ns.Box(1.0, THIN_BOX, THIN_BOX), mass=1.0, name="rod",
        inertia=np.diag([1 / 24, 1 / 12, 1 / 12]), position=(0, 0, -arm[2]), velocity=slip * e - np.cross(spin, arm),
        turn=after(quaternion((0, 0, 1), azimuth), quaternion((0, 1, 0), -th)), spin=spin,
    )  # fmt: skip
    if last:
        scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    return scene


@pytest.mark.parametrize("azimuth", [0.0, 0.7, 4.0])
@pytest.mark.parametrize("shape", ["capsule", "box"])
def test_a_rod_in_space_has_the_paradoxes_of_the_plane_in_every_direction(azimuth, shape):
    (seized,) = run(spatial_rod(azimuth=azimuth, shape=shape)).paradoxes
    (planar,) = run(rod_scene()).paradoxes
    assert (seized.kind, seized.t, {seized.i, seized.j}) == (INCONSISTENT, 0.0, {"ground", "rod"})
    assert (seized.choice, seized.gamma_F) == ("stick", pytest.approx(1.0, abs=1e-8))
    assert seized.P_N == pytest.approx(planar.P_N, rel=1e-2)
    (lifted,) = run(spatial_rod(thdot=6.0, azimuth=azimuth, shape=shape)).paradoxes
    assert (lifted.kind, lifted.choice, lifted.P_N) == (INDETERMINATE, "open", 0.0)
    assert lifted.n_solutions >= 2
    assert shape == "box" or (lifted.n_solutions, lifted.alternatives) == (2, ("free", "slide"))
    below = (1 + 3 * math.cos(TH) ** 2) / (3 * math.sin(TH) * math.cos(TH)) * (1 - 1e-4)
    assert run(spatial_rod(mu=below, azimuth=azimuth, shape="capsule")).paradoxes == []


def test_the_spatial_rod_lifts_off_on_the_parabola_of_the_free_one():
    found = run(spatial_rod(thdot=6.0, azimuth=0.3), 0.05)
    t = found.t
    height = found["rod"].position[0, 2] + found["rod"].velocity[0, 2] * t - G * t**2 / 2
    np.testing.assert_allclose(found["rod"].position[:, 2], height, atol=1e-12)


def random_network(d, m, n_free, rng):
    """m contacts of some moving bodies and a fixed one, with a metric and rows of no particular shape."""
    n = 3 * (d - 1)
    network = new(Network, m=m, n_b=n_free + 1, d=d, n=n)
    network.n_c = m
    for b in range(n_free):
        root = rng.normal(size=(n, n)) + 2 * np.eye(n)
        network.M_inv[b] = root @ root.T
        network.M[b] = np.linalg.inv(network.M_inv[b])
    for c in range(m):
        i, j = rng.choice(n_free + 1, 2, replace=False)
        network.i[c], network.j[c] = i, j
        network.J_i[c], network.J_j[c] = rng.normal(size=(2, d, n))
    network.mu[:] = rng.uniform(0.0, 1.5, m)
    return network


def asked(network, v_0, v_free, gap=0.0):
    """The doubtful islands of contacts of a gap."""
    d = network.b.shape[1]
    bodies, doubts = new(Bodies, n_b=len(network.v), dim=d), new(Doubts, n_b=len(network.v))
    found = new(Found, m=len(network.mu), d=d)
    found.gap[:] = gap
    bodies.v_0[:], network.v_free[:] = v_0, v_free
    load_all([prepare_network[d], find_doubtful[d]])
    prepare_network(network.address, d)
    find_doubtful(bodies.address, found.address, network.address, doubts.address, 0, d)
    return set(doubts.island[: int(doubts.count)].tolist())


def rows_of(network):
    """J (m, d, n_b n) and M^-1, block diagonal."""
    m, d, n_b, n = len(network.mu), network.b.shape[1], len(network.v), network.v.shape[1]
    J, M_inv = np.zeros((m, d, n_b, n)), np.zeros((n_b * n, n_b * n))
    for c in range(m):
        J[c, :, network.i[c]] += network.J_i[c]
        J[c, :, network.j[c]] += network.J_j[c]
    for b in range(n_b):
        M_inv[b * n : (b + 1) * n, b * n : (b + 1) * n] = network.M_inv[b]
    return J.reshape(m, d, -1), M_inv


@pytest.mark.parametrize("d", [2, 3])
def test_contacts_that_slide_are_doubtful_where_their_matrix_is_no_p_matrix(d):
    rng, counts = np.random.default_rng(d), np.zeros(2, int)
    for _ in range(150):
        network = random_network(d, int(rng.integers(1, d + 2)), int(rng.integers(1, 3)), rng)
        v = 100.0 * rng.normal(size=network.v.shape) * (network.M_inv[:, :1, 0] > 0)
        J, M_inv = rows_of(network)
        network.b[:, 0] = -J[:, 0] @ v.ravel()  # no approach, which could end a slide
        doubtful, gamma = asked(network, v, v), np.einsum("cax,x->ca", J, v.ravel())[:, 1:]
        t = gamma / np.linalg.norm(gamma, axis=1)[:, None]
        of_friction = np.einsum("cax,ca->cx", J[:, 1:], t)
        A = J[:, 0] @ M_inv @ (J[:, 0] - network.mu[:, None] * of_friction).T
        islands = network.islands
        for k in range(int(islands.count)):
            rows = islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]]
            is_regular = ns.is_p_matrix(A[np.ix_(rows, rows)])
            assert (k in doubtful) == (not is_regular)
            counts[int(is_regular)] += 1
    assert (counts > 10).all()


@pytest.mark.parametrize("rounding", [0.0, 1e-34, -1e-34, -1e-16])
@pytest.mark.parametrize("d", [2, 3])
def test_what_recedes_is_doubtful_only_where_it_was_pressed(d, rounding):
    """Impulses of the step before, turned to the normals of this one, may be roundings of zero of either sign."""
    rng, counts = np.random.default_rng(d), 0
    for _ in range(50):
        network = random_network(d, int(rng.integers(1, d + 2)), int(rng.integers(1, 3)), rng)
        v = 100.0 * rng.normal(size=network.v.shape) * (network.M_inv[:, :1, 0] > 0)
        J, _ = rows_of(network)
        network.b[:, 0] = 1.0 + np.abs(J[:, 0] @ v.ravel())
        network.P[:] = rounding
        doubtful = asked(network, v, v, gap=0.01)
        counts += len(doubtful)
        assert rounding > 0.0 or not doubtful
    assert rounding <= 0.0 or counts > 0


@pytest.mark.upkeep
@pytest.mark.filterwarnings("ignore::nonsmooth.ResidualWarning", "ignore::nonsmooth.SimultaneousImpactWarning")
@pytest.mark.filterwarnings("ignore::nonsmooth.PenetrationWarning")  # what steps leave that are not solved, as is said
@pytest.mark.parametrize(("mu", "e", "seed", "n"), [(1e3, 1.0, 2, 40), (1e6, 0.0, 0, 30), (5.0, 0.5, 1, 30)])
def test_heaps_of_extreme_friction_come_to_their_end(mu, e, seed, n):
    rng, scene = np.random.default_rng(seed), ns.Scene(gravity=(0, -G), material=ns.Material(mu=mu, e=e))
    for normal in ((0, 1), (1, 0), (-1, 0)):
        scene.fixed(ns.HalfPlane(normal, 0 if normal[1] else -0.6))
    for k in range(n):
        place = np.array([-0.45 + 0.3 * (k % 4), 0.3 + 0.3 * (k // 4)]) + rng.uniform(-0.02, 0.02, 2)
        scene.body(ns.Disc(0.1), mass=1.0, position=place, velocity=rng.normal(size=2))
    assert run(scene, 0.6, record=("bodies",)).success


def test_all_that_the_dense_core_may_call_is_loaded(monkeypatch):
    """A slot that nobody filled is a jump to nowhere, in whatever scene comes to it."""
    loaded = []
    monkeypatch.setattr(paradox, "load_all", loaded.extend)
    for dim, begins in ((2, [solve_planar, enumerate_modes]), (3, [enumerate_modes])):
        loaded.clear()
        assert paradox.load_dense_core(4, dim).has_newton == 0
        met, open_ends = set(begins), list(begins)
        while open_ends:
            new_ones = called_by(open_ends.pop()) - met - {solve_by_newton}
            met |= new_ones
            open_ends += new_ones
        assert {kernel for kernel in met if kernel.signature is not None and not kernel.is_late} == set(loaded)


def test_an_island_that_is_not_doubtful_has_one_solution_whatever_its_load():
    """Of contacts at rest, which may slide either way; all modes are tried."""
    rng, counts = np.random.default_rng(5), np.zeros(2, int)
    load_all([enumerate_modes])
    for _ in range(300):
        m = int(rng.integers(1, 4))
        network = random_network(2, m, int(rng.integers(1, 3)), rng)
        network.mu[:] *= 0.7
        doubtful, (J, M_inv) = asked(network, np.zeros(network.v.shape), np.zeros(network.v.shape)), rows_of(network)
        islands = network.islands
        for k in range(int(islands.count)):
            rows = islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]]
            part = J[rows].reshape(2 * len(rows), -1)
            mu, matrix = network.mu[rows], part @ M_inv @ part.T
            if np.linalg.cond(matrix) > 1e8:
                continue
            found = set()
            for _ in range(40):
                c = rng.normal(size=len(matrix))
                problem = problem_of(np.tile((UNILATERAL, 1), (len(rows), 1)), matrix, c, mu, mu)
                planar = new(Planar, n=4, d=1)
                found.add(enumerate_modes(problem.address, planar.tree.address)[0])
            counts[int(k in doubtful)] += 1
            assert k in doubtful or found == {1}
    assert (counts > 15).all()


def test_the_summary_the_json_and_files_tell_them(tmp_path):
    scene = rod_scene()
    add_rod(scene, thdot=6.0, at=5.0, name="other")
    found = run(scene)
    assert "paradoxes: 1 inconsistent, 1 indeterminate episode (1 of 20 steps had several solutions)" in found.summary()
    assert "ground, rod  no force fits the sliding: impact without collision, then stick" in found.summary()
    assert "ground, other  3 solutions (free | stick | slide -): took open" in found.summary()
    kinds = [event["kind"] for event in json.loads(json.dumps(as_json(found, False)))["paradoxes"]]
    assert kinds == ["INCONSISTENT", "INDETERMINATE"]
    for name in ("run.npz", "run.h5", "run.nc"):
        loaded = ns.SceneSolution.load(found.save(tmp_path / name))
        assert loaded.paradoxes == found.paradoxes
        assert loaded.stats == found.stats
    silent = run(rod_scene(mu=0.5))
    assert silent.paradoxes == [] and "paradoxes" not in silent.summary()


def test_a_run_that_is_resumed_goes_on_telling_them(tmp_path):
    scene = rod_scene(thdot=6.0)
    whole = run(scene, 0.02)
    options = {"integrator": STEP, "checkpoint": tmp_path / "run.nsc"}
    ns.simulate(scene, (0, 0.02), max_steps=7, on_failure="return", **options)
    resumed = ns.simulate(scene, (0, 0.02), integrator=STEP, resume=tmp_path / "run.nsc")
    assert resumed.paradoxes == whole.paradoxes
    assert resumed.stats.indeterminate_steps == whole.stats.indeterminate_steps
    np.testing.assert_array_equal(resumed.position, whole.position)


def test_damaged_paradoxes_are_refused(tmp_path):
    found = run(rod_scene())
    found.paradox_rows[0, 1] = 7.0
    with pytest.raises(ns.InvalidInput, match="its kinds of paradoxes must lie in 2"):
        ns.SceneSolution.load(found.save(tmp_path / "run.npz"))


def welded_rod(parts, mu=2.0, **rod):
    """The rod of `add_rod`, cut into equal parts that are welded to one another."""
    whole = rod_scene(mu=mu, **rod)["rod"]
    scene, length = ns.Scene(gravity=(0, -G), material=ns.Material(mu=mu)), 1.0 / parts
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    e, n = (np.array(axis) for axis in ((math.cos(TH), math.sin(TH)), (-math.sin(TH), math.cos(TH))))
    for k in range(parts):
        r = (k + 0.5) * length - 0.5
        scene.body(
            ns.Capsule(length, THIN), mass=length, inertia=length**3 / 12, name=f"part {k}", turn=whole.turn,
            position=whole.position + r * e, velocity=whole.velocity + r * whole.spin * n, spin=whole.spin,
        )  # fmt: skip
        if k > 0:
            scene.fix(f"part {k - 1}", f"part {k}", at=whole.position + (r - 0.5 * length) * e)
    return scene


@pytest.mark.parametrize("parts", [2, 3])
@pytest.mark.parametrize("thdot", [0.0, 1.0, 6.0])
def test_a_rod_of_welded_parts_is_named_as_the_whole_one_is(thdot, parts):
    """Rows of joints are those of the middle of the step, of contacts those of its beginning: a part thdot dt of P."""
    (event,), (same,) = run(welded_rod(parts, thdot=thdot)).paradoxes, run(rod_scene(thdot=thdot)).paradoxes
    assert told(event) == told(same) and (event.i, event.j) == ("ground", "part 0")
    np.testing.assert_allclose([event.P_N, event.P_F], [same.P_N, same.P_F], rtol=1e-8 + thdot * DT)
    assert run(welded_rod(parts, mu=1.0, thdot=thdot)).paradoxes == []


@pytest.mark.parametrize("parts", [2, 3])
def test_the_forces_that_a_rod_of_welded_parts_needs_are_those_of_the_whole_one(parts, monkeypatch):
    asked = []

    class Noted(paradox.StateProblem):
        def __init__(self, *given):
            super().__init__(*given)
            asked.append(self)

    monkeypatch.setattr(paradox, "StateProblem", Noted)
    for scene in (welded_rod(parts, thdot=6.0), rod_scene(thdot=6.0)):
        run(scene, 2 * DT)
    of_parts, of_whole = asked[0], asked[len(asked) // 2]
    np.testing.assert_allclose(of_parts.G, of_whole.G, rtol=1e-10)
    for found in (of_parts, of_whole):  # gaps are differenced over 1e-3 of a reach: rounding 1e-16/1e-6 of 36 m/s^2
        np.testing.assert_allclose(found.b, [6.0**2 * math.sin(TH) / 2 - G], rtol=1e-7)


@pytest.mark.parametrize(("thdot", "kind"), [(0.0, INCONSISTENT), (6.0, INDETERMINATE)])
def test_a_rod_of_welded_parts_in_space_is_named_too(thdot, kind):
    """Its ends and the moments of its parts are those of a rod of 1 m and 1 kg."""
    e, J, dt = np.array([math.cos(TH), 0.0, math.sin(TH)]), 0.125 / 12, 1e-4
    scene, spin = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=2.0)), np.array([0.0, -thdot, 0.0])
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    for k, r in enumerate((0.25, 0.75)):
        scene.body(
            ns.Capsule(0.5, THIN), mass=0.5, inertia=(1e-6 * J, J, J), name=f"part {k}", position=(0, 0, THIN) + r * e,
            turn=(math.cos(TH / 2), 0, -math.sin(TH / 2), 0), velocity=(-1, 0, 0) + np.cross(spin, r * e), spin=spin,
        )  # fmt: skip
    scene.fix("part 0", "part 1", at=(0, 0, THIN) + 0.5 * e)
    (event,) = ns.simulate(scene, (0, 2e-3), integrator=ns.MoreauJean(dt)).paradoxes
    assert (event.kind, event.j) == (kind, "part 0")
    assert event.n_solutions == (2 if kind == INDETERMINATE else 0)


def finger(rng):
    """Two links on pins, whose tip slides on the ground."""
    l_1, l_2 = rng.uniform(0.5, 1.5, 2)
    a, b, spin = rng.uniform(-math.pi, math.pi), rng.uniform(0.3, math.pi - 0.3), rng.uniform(-4, 4)
    e_1, e_2 = (np.array((math.cos(angle), math.sin(angle))) for angle in (a, b))
    n_1, n_2 = (np.array((-e[1], e[0])) for e in (e_1, e_2))
    elbow = np.array((0.0, THIN)) + l_2 * e_2
    shoulder, of_elbow = elbow - l_1 * e_1, spin * l_1 * n_1
    turning = of_elbow[1] / (l_2 * n_2[1])
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=rng.uniform(0.5, 4.0)))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    scene.fixed(ns.Disc(0.01), position=shoulder, name="base")
    scene.body(ns.Box(l_1, 0.02), mass=rng.uniform(0.5, 3), position=shoulder + 0.5 * l_1 * e_1, turn=a,
               velocity=0.5 * of_elbow, spin=spin, name="upper")  # fmt: skip
    scene.body(ns.Capsule(l_2, THIN), mass=rng.uniform(0.5, 3), position=elbow - 0.5 * l_2 * e_2, turn=b,
               velocity=of_elbow - 0.5 * l_2 * turning * n_2, spin=turning, name="lower")  # fmt: skip
    for pair in (("base", "upper"), ("ground", "upper"), ("base", "lower")):
        scene.ignore(*pair)
    scene.hinge("base", "upper", at=shoulder)
    scene.hinge("upper", "lower", at=elbow)
    return scene, (of_elbow - l_2 * turning * n_2)[0]


@pytest.mark.upkeep
def test_fingers_on_pins_are_in_the_paradoxes_that_the_census_of_their_systems_finds():
    rng, kinds = np.random.default_rng(1), set()
    for _ in range(60):
        scene, slip = finger(rng)
        if abs(slip) > 0.5 and scene["base"].position[1] > 0.2:
            kind = ns.classify(scene).kind.name
            found = ns.simulate(scene, (0, 1e-5), integrator=ns.MoreauJean(1e-5)).paradoxes
            assert [event.kind.name for event in found] == ([] if kind == "REGULAR" else [kind])
            kinds.add(kind)
    assert kinds == {"REGULAR", "INCONSISTENT", "INDETERMINATE"}


def test_islands_of_springs_are_not_asked():
    scene = rod_scene()
    rod = scene["rod"]
    scene.body(ns.Disc(0.01), mass=1e-3, position=rod.position, velocity=rod.velocity, name="bead")
    scene.hinge("bead", "rod", at=rod.position, name="pin")
    assert len(run(scene).paradoxes) == 1
    scene.spring("bead", "ground", stiffness=1.0, at_b=(0.0, 0.0))
    assert run(scene).paradoxes == []


def test_islands_of_compliant_contacts_are_not_asked():
    thick = ns.Scene(gravity=(0, -G), material=ns.Material(mu=3.0))
    thick.fixed(ns.HalfPlane((0, 1)), name="ground")
    lowest = 0.5 * math.sin(TH) + 0.02
    thick.body(ns.Capsule(1.0, 0.02), mass=1.0, position=(0, lowest), turn=TH, velocity=(-1.0, 0), name="rod")
    assert len(run(thick).paradoxes) == 1
    soft = ns.MoreauJean(dt=1e-4, theta=1.0, compliance=ns.Compliance(1e6))
    assert ns.simulate(thick, (0, 1e-3), integrator=soft).paradoxes == []
    assert ns.simulate(thick, (0, 1e-3), integrator=ns.Penalty(1e6)).paradoxes == []
