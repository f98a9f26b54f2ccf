"""The ladder: what is done for an island, what is said of it, and that both hold whatever is asked."""

import numpy as np
import pytest

from nonsmooth.contact.network import rescue as inside
from nonsmooth.contact.network.patience import FACTORS, MANY_FACTORS, begin_problem
from nonsmooth.contact.network.problem import prepare_network
from nonsmooth.contact.network.rescue import rescue
from nonsmooth.contact.network.solve import (
    BY_FACTORS,
    BY_START,
    BY_SWEEPS,
    EXACT_BODIES,
    RETRY_FACTORS,
    SOLVED_TO_ROUNDING,
    Solver,
    solve_network,
)
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from tests.contact.network.problems import copy_of, heap, joined, judge, network_of, pyramid, stack

SCENES = {
    "stack": lambda: stack(5),
    "stack with a heavy top": lambda: stack(6, 1e6),
    "pyramid": lambda: pyramid(7),
    "discs": lambda: heap(60, 2),
    "spheres": lambda: heap(60, 3),
    "spheres without friction": lambda: heap(40, 3, mu=0.0),
}


def solver_of(network, tol=1e-10, most_sweeps=50, most_factors=100, fill=3000):
    sizes = {"d": network.b.shape[1], "n": network.v.shape[1], "m": len(network.i), "n_b": len(network.v)}
    solver = new(Solver, fill=fill, **sizes)
    solver.tol, solver.most_sweeps, solver.most_factors, solver.most_inside = tol, most_sweeps, most_factors, 200
    return solver


def prepare(network):
    prepare_network(network.address, network.b.shape[1])


def solve(network, solver=None, **options):
    """How many blocks of factors are wanted."""
    solver = solver or solver_of(network, **options)
    return solve_network(network.address, solver.address, solver.direct.desk.address, network.b.shape[1])


def said(network, name):
    return getattr(network.islands, name)[: network.islands.count].tolist()


@pytest.mark.parametrize("tol", [1e-4, 2e-7])
@pytest.mark.parametrize("scene", SCENES)
def test_tolerance_is_met_and_the_next_solve_does_nothing(scene, tol):
    network = SCENES[scene]()
    assert solve(network, tol=tol) == 0
    assert set(said(network, "is_met")) == {1}
    P, v = network.P.copy(), network.v.copy()
    assert judge(network) <= tol and (network.v == v).all() and said(network, "rung") != [BY_START]
    prepare(network)
    assert solve(network, tol=tol) == 0
    assert set(said(network, "rung")) == {BY_START} and (network.P == P).all() and (network.v == v).all()


@pytest.mark.parametrize("scene", SCENES)
def test_few_bodies_are_solved_to_rounding_where_a_fine_residual_is_asked_for(scene):
    network = SCENES[scene]()
    assert solve(network, tol=1e-8) == 0
    few = np.diff(network.islands.body_start[: network.islands.count + 1]) <= EXACT_BODIES
    residuals = np.array(said(network, "residual"))
    assert (residuals[few] <= SOLVED_TO_ROUNDING).all() and (residuals <= 1e-8).all()


def test_island_is_taken_as_far_up_as_it_must_be():
    """A ball that falls needs one contact solved, a stack with a heavy top factors, a ball that is solved nothing."""
    ball = network_of([[0, 0, 0.1], [0, 0, 0]], [np.eye(6)] * 2, [[0, 0, -1, 0, 0, 0], np.zeros(6)],
                      [(0, 1, (0, 0, -1), (0, 0, 0), 0.0)], fixed=(1,))  # fmt: skip
    rests = copy_of(ball)
    rests.P[0] = 1.0, 0.0, 0.0
    network = joined([ball, stack(8, 1e4), rests])
    assert solve(network) == 0
    assert said(network, "rung") == [BY_SWEEPS, BY_FACTORS, BY_START]
    assert said(network, "sweeps")[0] <= 10 and said(network, "factors")[1] > 0
    assert said(network, "is_met") == [1, 1, 1]


def test_what_the_budget_does_not_reach_is_said_with_its_residual():
    network = pyramid(8)
    assert solve(network, most_sweeps=20, most_factors=0) == 0
    assert said(network, "is_met") == [0] and said(network, "sweeps") == [20] and said(network, "factors") == [0]
    assert said(network, "residual")[0] == judge(network) > 1e-4


def test_sweeps_that_factors_did_not_help_are_made_after_them():
    """With three factors a pyramid is not solved; the sweeps that were given up for them are."""
    network = pyramid(8)
    solve(network, tol=1e-13, most_sweeps=40, most_factors=3)
    assert said(network, "is_met") == [0] and said(network, "rung") == [BY_FACTORS]
    assert said(network, "sweeps") == [40] and said(network, "residual")[0] == judge(network)


@pytest.mark.parametrize("most_factors", [0, 3])
@pytest.mark.parametrize("most_sweeps", [0, 1, 12])
def test_residual_is_never_more_than_that_of_the_start(most_sweeps, most_factors):
    for seed in range(3):
        network = heap(40, 3, seed=seed)
        solve(network, tol=1e-9)
        network.P[:] *= 1.0 + 1e-6 * np.random.default_rng(seed).normal(size=network.P.shape)
        start = judge(network)
        prepare(network)
        solve(network, tol=1e-15, most_sweeps=most_sweeps, most_factors=most_factors)
        assert judge(network) <= start


@pytest.mark.parametrize("is_first", [True, False])
def test_factors_of_some_bodies_say_nothing_of_those_of_many(is_first):
    """Three factors solve 45 boxes that are nearly solved; 225 discs in motion they do not, which are then left out."""
    few, many = pyramid(9), heap(225, 2)
    assert solve(few, tol=1e-9) == 0
    few.P[:] *= 1.0 + 1e-7
    network = joined([few, many] if is_first else [many, few])
    solver = solver_of(network, tol=1e-9, most_sweeps=1, most_factors=3)
    assert solve(network, solver) == 0
    assert sorted(said(network, "is_met")) == [0, 1] and said(network, "rung") == [BY_FACTORS] * 2
    assert (solver.patience.left[FACTORS], solver.patience.left[MANY_FACTORS]) == (0, 1)
    network.v_free[:, 0] += 1e-3
    prepare(network)
    assert solve(network, solver) == 0 and sorted(said(network, "rung")) == [BY_SWEEPS, BY_FACTORS]


@pytest.mark.parametrize(("push", "rung"), [(1e-6, BY_FACTORS), (1e-1, BY_SWEEPS)])
def test_many_boxes_that_took_many_factors_get_more_once_they_are_calm(push, rung):
    """Solved from no impulses, then pushed aside on the floor: their start is near, or far off."""
    network = pyramid(21)
    solver = solver_of(network, tol=1e-9, most_sweeps=5)
    assert solve(network, solver) == 0 and said(network, "is_met") == [1]
    patience = solver.patience
    assert said(network, "factors")[0] > RETRY_FACTORS
    assert (patience.left[MANY_FACTORS], patience.wait[MANY_FACTORS]) == (0, 1)
    network.v_free[:-1, 0] += push
    prepare(network)
    assert solve(network, solver) == 0 and said(network, "rung") == [rung]


def test_more_room_is_asked_for_and_then_enough():
    network = joined([stack(3, 1e3), pyramid_in_space := stack(12, 1e3)])
    wanted = solve(network, fill=4)
    assert wanted > 4 and said(network, "is_met")[0] == 1
    while wanted > 0:
        assert wanted < 200
        wanted = solve(network, fill=wanted)
    assert said(network, "is_met") == [1, 1] and pyramid_in_space.n_c == 48


def test_bodies_that_part_but_for_rounding_are_solved():
    """Nothing presses where two bodies move at the same 10 m/s; what rounding leaves of gamma is no contact."""
    v = [[10.0, 0.1, 3.0], [10.0, 0.1, 3.0]]
    x = [[0.0, 0.0], [0.3, 0.7]]
    normal = np.array([0.6, 0.8])
    network = network_of(x, [np.eye(3)] * 2, v, [(0, 1, normal, (0.1, 0.3), 0.0)])
    arm = np.array([0.3, 0.7])
    network.v_free[1, :2] += 3.0 * np.array([-arm[1], arm[0]])  # one rigid motion
    for slip in np.linspace(-4e-15, 4e-15, 9):
        network.b[0, 0] = slip
        prepare(network)
        assert solve(network, tol=1e-13, most_sweeps=3) == 0 and said(network, "is_met") == [1]


@pytest.mark.parametrize("scene", ["stack", "discs"])
def test_what_is_not_finite_is_not_met(scene):
    network = SCENES[scene]()
    network.v_free[2, 1] = np.nan
    prepare(network)
    assert solve(network) == 0
    assert 0 in said(network, "is_met")


def test_empty_problem_is_solved():
    assert solve(network_of(np.zeros((2, 2)), [np.eye(3)] * 2, np.ones((2, 3)), [])) == 0


@pytest.mark.parametrize("scene", ["stack", "discs"])
def test_kernels_have_the_same_bits_interpreted(scene):
    network = {"stack": lambda: stack(3), "discs": lambda: heap(12, 2, mu=1.0, speed=0.5)}[scene]()
    twin, solver = copy_of(network), solver_of(network, tol=1e-13, most_sweeps=14)
    twin_solver = solver_of(network, tol=1e-13, most_sweeps=14)
    assert solve(network, solver) == 0
    desk, d = twin_solver.direct.desk, network.b.shape[1]
    assert interpreted(solve_network)(twin, twin_solver, desk, d) == 0
    assert (network.words.view(np.int64) == twin.words.view(np.int64)).all()
    assert (solver.words.view(np.int64) == twin_solver.words.view(np.int64)).all()
    assert BY_FACTORS in said(network, "rung")


def test_what_rounding_of_the_velocities_holds_above_the_tolerance_is_met():
    network = heap(6, 2)
    network.v_free[:, :2] += 1e6  # all move alike, what is fixed too: relative velocities are known to 1e-10 m/s
    prepare(network)
    assert solve(network, tol=1e-13) == 0 and set(said(network, "is_met")) == {1}
    assert judge(network) <= 1e-13
    assert (network.islands.F[:1] > 1e-24 * network.islands.P[:1]).all()
    network.islands.is_met[:] = 0
    rescue(network, solver_of(network), 1e-13)
    assert set(said(network, "is_met")) == {1}


def test_starts_that_all_missed_wait_while_the_first_one_is_tried(monkeypatch):
    """Until the next problem, the third, the seventh; what they leave is better each time, so that they go on."""
    tried = []

    def come_nearer(network, k, goal, starts):
        tried.append(len(starts))
        network.islands.residual[k] *= 0.01
        return 1

    monkeypatch.setattr(inside, "solve_pressed", come_nearer)
    monkeypatch.setattr(inside, "solve_whole", lambda *_: 1)
    network = heap(60, 3)
    solver = solver_of(network)
    solver.most_inside = 60
    for _ in range(7):
        network.islands.residual[0], network.islands.is_met[0] = 1e-3, 0
        interpreted(begin_problem)(solver.patience)
        rescue(network, solver, solver.tol)
    every = len(inside.PRESSED_STARTS[3])
    assert tried == [every, every, 1, 1, every, 1, 1] and every > 1


def on_four_corners(rng):
    """A box that lands on four points whose gaps are not quite of one plane, and a body far above it, as in a step of
    next to no length: b_N = g/dt."""
    half = np.array([0.15, 0.1, 0.05])
    x = [np.zeros(3), np.array([0.0, 0.0, half[2]]), np.array([0.0, 0.0, 0.5])]
    up, corners = np.array([0.0, 0.0, 1.0]), ((1, 1), (1, -1), (-1, 1), (-1, -1))
    contacts = [
        (0, 1, up, (a * half[0], b * half[1], 0.0), rng.uniform(-1e-3, 1e-3) + 1e-6 * rng.normal()) for a, b in corners
    ]
    contacts.append((1, 2, up, (0.0, 0.0, 0.3), 10.0 ** rng.uniform(6.0, 10.0)))
    mass = 5.0 * np.diag([1.0, 1.0, 1.0, *(half[[1, 0, 0]] ** 2 + half[[2, 2, 1]] ** 2) / 3.0])
    v = np.zeros((3, 6))
    v[1] = (*(0.1 * rng.normal(size=2)), -rng.uniform(0.0, 0.1), *(1e-2 * rng.normal(size=2)), rng.normal())
    return network_of(x, np.tile(mass, (3, 1, 1)), v, contacts, mu=0.4, fixed=(0,))


def test_a_wide_gap_hides_no_error_of_corners_that_land():
    """The residual that counts is that of the problem without the gap, which is open."""
    rng = np.random.default_rng(0)
    for _ in range(40):
        network = on_four_corners(rng)
        solver = solver_of(network, tol=1e-8)
        assert solve(network, solver) == 0
        if not network.islands.is_met[0]:
            rescue(network, solver, solver.tol)
        assert (network.P[4] == 0.0).all()
        network.b[4, 0] = 100.0
        assert judge(network) <= 1e-8
