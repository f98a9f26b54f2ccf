"""Islands shared by threads: the bits of one, whatever their number, also where a run is cut short or goes on."""

import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

import nonsmooth as ns
from models.scenes import SphereBox
from nonsmooth.contact.network import parallel
from nonsmooth.contact.network.parallel import Desks, at_once, share_islands
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.network.solve import EXACT_BODIES, Solver
from nonsmooth.integrators.assembly.draw_together import draw_together
from nonsmooth.integrators.assembly.hold_places import hold_places, write_gaps
from nonsmooth.integrators.assembly.joined_trees import NO_TREE
from nonsmooth.integrators.assembly.joints import first_joint
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from nonsmooth.runs.scene_run import SceneRun

DT = 2e-3
THREADS = (2, 3, 4)
WITHOUT_INTERIOR_POINTS = ns.MoreauJean(dt=DT, contacts=ns.ContactSolver(interior=0))  # they solve every step

pytestmark = [
    pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning"),  # of small heaps
    pytest.mark.filterwarnings("ignore:in .* steps the contact problem was solved to less than tol"),
]


def stacks(dim=3, stacks=4, boxes=4, kick=1.0, moved=False):
    """Stacks of boxes that slide apart: each is an island, and is solved by factors in every step."""
    scene = ns.Scene(gravity=(0,) * (dim - 1) + (-9.81,), material=ns.Material(mu=0.4))
    if moved:
        size = (20, 0.1) if dim == 2 else (20, 4, 0.1)
        scene.kinematic(ns.Box(*size), motion=lambda t: (0.1 * np.sin(9 * t), *(0,) * (dim - 2), -0.05), name="table")
    else:
        scene.fixed(ns.HalfPlane((0, 1)) if dim == 2 else ns.HalfSpace((0, 0, 1)), name="ground")
    box = ns.Box(*(0.2,) * dim)
    for s in range(stacks):
        for b in range(boxes):
            place = (1.5 * s, *(0,) * (dim - 2), 0.1 + 0.2 * b)
            speed = (kick * (b % 3 - 1) * (1 + 0.1 * s), *(0,) * (dim - 1))
            scene.body(box, mass=1 + 99 * (b == 3), position=place, velocity=speed, name=f"box {s} {b}")
    return scene


def sleepers():
    """Stacks at rest, two that slide, and a disc that rolls into one at rest."""
    scene = stacks(dim=2, stacks=2)
    for s in range(2, 5):
        for b in range(3):
            scene.body(ns.Box(0.2, 0.2), mass=1, position=(1.5 * s, 0.1 + 0.2 * b), name=f"still {s} {b}")
    scene.body(ns.Disc(0.1), mass=5, position=(9, 0.1), velocity=(-8, 0), spin=80, name="disc")
    return scene


def chains(dim=2, chains=3, links=4):
    """Chains that swing among stacks of boxes, each with a heavy end: their joints drift, and are drawn together."""
    scene = stacks(dim)
    flat = (0,) * (dim - 2)
    for k in range(chains):
        x, y = -3.0 - 3.0 * k, 2.0 + 0.1 * k
        scene.fixed(ns.Disc(0.01) if dim == 2 else ns.Sphere(0.01), position=(x, *flat, y), name=f"hook {k}")
        before = f"hook {k}"
        for a in range(links):
            size, name = (0.3, 0.05) if dim == 2 else (0.3, 0.05, 0.05), f"link {k} {a}"
            mass = 0.3 if a < links - 1 else 30.0
            scene.body(ns.Box(*size), mass=mass, position=(x + 0.15 + 0.3 * a, *flat, y), name=name)
            scene.joint(before, name, at=(x + 0.3 * a, *flat, y))
            before = name
    return scene


SCENES = {
    "chains among planar boxes": chains,
    "chains among boxes": lambda: chains(3),
    "boxes": stacks,
    "planar boxes": lambda: stacks(2, stacks=6),
    "boxes on a table that moves": lambda: stacks(2, kick=0.0, moved=True),
    "spheres that rebound": SphereBox(n=64, e=0.5).scene,
    "islands that sleep": sleepers,
}


def bits(solution):
    """All that a run computed, as bytes."""
    columns = {name: getattr(solution, name) for name in ("t", "residual", "penetration", "position", "turn")}
    columns |= {name: getattr(solution, name) for name in ("velocity", "spin")} | solution.ledger
    columns |= {f"contacts {name}": column for name, column in solution.all_contacts.columns.items()}
    return {name: np.ascontiguousarray(column).tobytes() for name, column in columns.items()}


def simulate(name, t_end=0.3, threads=1, **options):
    integrator = options.pop("integrator", ns.MoreauJean(dt=DT))
    return ns.simulate(SCENES[name](), (0, t_end), integrator=integrator, every=3, threads=threads, **options)


@pytest.fixture(autouse=True)
def shared_however_small(monkeypatch):
    monkeypatch.setattr(parallel, "WORTH_SHARING", {2: 0, 3: 0})


@pytest.fixture
def shared(monkeypatch):
    """How many islands threads were handed, problem by problem."""
    counts, begin = [], Desks.begin

    def noting(self, network, solver, factors):
        counts.append(int(network.islands.count))
        begin(self, network, solver, factors)
        assert self.is_shared and len(self.left) == parallel.PARTS_A_THREAD * self.threads

    monkeypatch.setattr(Desks, "begin", noting)
    return counts


@pytest.mark.upkeep
@pytest.mark.parametrize("name", SCENES)
def test_any_number_of_threads_has_the_bits_of_one(shared, name):
    one = simulate(name)
    assert shared == []
    for threads in THREADS:
        several = simulate(name, threads=threads)
        assert len(shared) > 30 and max(shared) > 2
        shared.clear()
        assert bits(several) == bits(one)
        for count in ("sweeps", "factorisations", "methods", "missed", "islands_asleep", "struck_together"):
            assert getattr(several.stats, count) == getattr(one.stats, count)


def test_small_problems_are_not_handed_over(monkeypatch):
    one = simulate("planar boxes", 0.1)
    monkeypatch.setattr(parallel, "WORTH_SHARING", {2: 10**6, 3: 10**6})
    monkeypatch.setattr(parallel, "_pool", None)
    assert bits(simulate("planar boxes", 0.1, threads=2)) == bits(one)


def run_with_room(scene, fill, threads, t_end=0.2):
    """Bodies after a run that begins with room for so many blocks of factors."""
    run = SceneRun(scene, (0, t_end), ns.MoreauJean(dt=DT), 1, None)
    assembly, d = run.assembly, scene.dim
    assembly.desks, assembly.fill = Desks(threads), fill
    assembly.solver = new(Solver, fill=0, m=0, n_b=0, d=d, n=3 * (d - 1))
    assembly._make_solver()
    run.advance(None, None)
    return assembly.fill, run.solution().velocity, run.solution().position


@pytest.mark.upkeep
@pytest.mark.parametrize("name", ["boxes", "chains among planar boxes", "chains among boxes"])
def test_the_room_for_factors_changes_no_bit(name):
    _, v, x = run_with_room(SCENES[name](), 5000, 1)
    for threads in (1, *THREADS):
        fill, v_small, x_small = run_with_room(SCENES[name](), 4, threads)
        assert fill > 8
        np.testing.assert_array_equal(v_small, v)
        np.testing.assert_array_equal(x_small, x)


@pytest.mark.parametrize("kernel", [draw_together, hold_places])
@pytest.mark.parametrize("dim", [2, 3])
def test_places_are_drawn_together_alike_however_often_room_is_asked_for(dim, kernel):
    run = SceneRun(chains(dim, links=6), (0, 0.1), ns.MoreauJean(dt=DT), 1, None)
    run.advance(None, None)
    assembly, pushes, asked = run.assembly, [], []
    network, x = assembly.network, assembly.bodies.motion.x
    x[:, :dim] += np.random.default_rng(1).normal(scale=1e-5, size=x[:, :dim].shape)
    parted = x.copy()
    first = interpreted(first_joint)(assembly.found, network)
    interpreted(write_gaps)(assembly.joints, assembly.bodies, assembly.found, assembly.contacts, network, first)
    kept = {name: getattr(network, name).copy() for name in ("P", "b", "mu", "v", "v_free")}
    assembly.held.tree.is_ready[:] = NO_TREE  # else no factors of the ladder are asked for
    for fill in (5000, 2):
        assembly.fill, assembly.solver = fill, new(Solver, fill=0, m=0, n_b=0, d=dim, n=3 * (dim - 1))
        assembly._make_solver()
        assembly.moves.push[:], x[:] = np.nan, parted
        assembly.progress.is_pushed = 0
        asked.append(0)
        while wanted := kernel(assembly.progress.address, dim):
            asked[-1] += 1
            assembly.fill = wanted
            assembly._make_solver()
        pushes.append(assembly.moves.push.copy())
        assert all((getattr(network, name) == before).all() for name, before in kept.items())
        assert not assembly.solver.patience.left.any() and assembly.held.is_begun == 0
    assert asked[0] == 0 and asked[1] > 1
    assert np.nanmax(np.abs(pushes[0])) > 0.0
    np.testing.assert_array_equal(*pushes)


def test_ctrl_c_ends_a_run_of_threads_between_two_steps(monkeypatch):
    whole, solve, calls = simulate("boxes"), Desks.solve, []

    def interrupted(self, network, solver):
        calls.append(1)
        if len(calls) == 40:
            signal.raise_signal(signal.SIGINT)
        return solve(self, network, solver)

    monkeypatch.setattr(Desks, "solve", interrupted)
    part = simulate("boxes", threads=2)
    n = len(part.t) - 1  # the last record is that of the step at which it was stopped
    assert part.status == ns.Status.INTERRUPTED and 5 < n < len(whole.t) - 5
    np.testing.assert_array_equal(part.velocity[:n], whole.velocity[:n])


def test_a_step_that_misses_its_tolerance_fails_alike():
    contacts = ns.ContactSolver(interior=0, on_residual="raise")
    failures = []
    for threads in (1, 2):
        with pytest.raises(ns.StepFailure) as failure:
            simulate("spheres that rebound", 0.4, threads, integrator=ns.MoreauJean(dt=DT, contacts=contacts))
        failures.append(failure.value)
    assert str(failures[0]) == str(failures[1])
    assert bits(failures[0].solution) == bits(failures[1].solution)


@pytest.mark.filterwarnings("default:in .* steps the contact problem")
def test_what_is_missed_is_told_alike():
    told = []
    for threads in (1, 2):
        with pytest.warns(ns.ResidualWarning) as warned:
            simulate("spheres that rebound", 0.4, threads, integrator=WITHOUT_INTERIOR_POINTS)
        told.append([str(w.message) for w in warned if w.category is ns.ResidualWarning])
    assert told[0] == told[1] and len(told[0]) == 1


@pytest.mark.upkeep
@pytest.mark.parametrize(("before", "after"), [(1, 2), (3, 1), (2, 4)])
@pytest.mark.parametrize("name", ["boxes", "boxes on a table that moves", "islands that sleep", "chains among boxes"])
def test_a_checkpoint_goes_on_with_another_number_of_threads(tmp_path, name, before, after):
    whole = simulate(name)
    for steps, threads in ((31, before), (62, after), (100, before)):
        with pytest.raises(ns.BudgetSpent):
            simulate(name, threads=threads, checkpoint=tmp_path / "c", resume=tmp_path / "c", max_steps=steps)
    assert bits(simulate(name, threads=after, checkpoint=tmp_path / "c", resume=tmp_path / "c")) == bits(whole)


def test_what_a_thread_raises_is_raised_when_all_are_done():
    begun, done = threading.Event(), []

    def fail():
        begun.set()
        raise ArithmeticError("of a thread")

    def last():
        assert begun.wait(60)
        done.append(1)

    with pytest.raises(ArithmeticError, match="of a thread"):
        at_once([last, fail])
    assert done == [1]


def test_a_thread_that_gets_no_processor_keeps_nobody_waiting():
    gate, begun, done = threading.Event(), threading.Event(), []

    def held():
        begun.set()
        gate.wait(60)

    holder = threading.Thread(target=at_once, args=([lambda: gate.wait(60), held],))
    holder.start()
    assert begun.wait(60)  # the one thread of the pool is busy now
    at_once([lambda: done.append("here"), lambda: done.append("never")])
    gate.set()
    holder.join()
    assert done == ["here"]


def islands_of(contacts, bodies):
    network = new(Network, m=sum(contacts), n_b=max(sum(bodies), 1), d=2, n=3)
    islands = network.islands
    islands.count = len(contacts)
    islands.contact_start[: len(contacts) + 1] = np.cumsum([0, *contacts])
    islands.body_start[: len(bodies) + 1] = np.cumsum([0, *bodies])
    return islands


@pytest.mark.parametrize("parts", [2, 3, 4])
def test_islands_are_shared_evenly_and_large_ones_stay_with_the_first(parts):
    large, rng = EXACT_BODIES + 1, np.random.default_rng(parts)
    contacts, bodies = [*rng.integers(1, 9, 300).tolist(), 200, 3], [*[3] * 300, large, 2]
    islands = islands_of(contacts, bodies)
    share_islands(islands, parts)
    owner = islands.owner[: len(contacts)]
    assert owner[300] == 0 and set(owner.tolist()) == set(range(parts))
    shares = [sum(np.array(contacts)[owner == part]) for part in range(parts)]
    assert max(shares) - min(shares) <= 2 * 9
    islands = islands_of([2000, 4, 4, 4, 4, 4, 4], [500, 2, 2, 2, 2, 2, 2])
    share_islands(islands, parts)
    assert islands.owner[0] == 0 and 0 not in islands.owner[1:7]


FORKED = """
import os
import nonsmooth as ns
from nonsmooth.contact.network import parallel
from tests.integrators.assembly.test_threads import simulate
parallel.WORTH_SHARING = {2: 0, 3: 0}
simulate("boxes", 0.1, threads=2)
assert parallel._pool.cache_info().currsize == 1
child = os.fork()
if child == 0:
    os._exit(7 if simulate("boxes", 0.1, threads=2).success else 1)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no fork")
def test_a_process_that_was_forked_has_threads_of_its_own():
    ended = subprocess.run([sys.executable, "-c", FORKED], capture_output=True, text=True, timeout=240, check=True)
    assert ended.stdout.strip() == "7"
