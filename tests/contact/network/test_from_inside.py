"""Interior points on the graph of the bodies: a step by dense matrices, and the islands that they end."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nonsmooth as ns
from nonsmooth.catalogue import DominoRow
from nonsmooth.contact.network import from_inside as driver
from nonsmooth.contact.network import interior, rescue
from nonsmooth.contact.network.al_newton import begin_direct
from nonsmooth.contact.network.from_inside import STARTS, from_inside
from nonsmooth.contact.network.interior import Inside, go_inside, shifted
from nonsmooth.contact.network.joint import JOINED
from nonsmooth.contact.network.multifrontal import factorise_fronts, lay_out_fronts
from nonsmooth.contact.network.patience import begin_problem
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from tests.contact.network.problems import assembled, copy_of, heap, judge, pyramid, stack
from tests.contact.network.test_joint_rows import hanging_bridge
from tests.contact.network.test_solve import prepare, solver_of

ROUNDED = 1e-5  # chosen: ten times the unit of rounding of a matrix with the condition 1e10


def some_without_friction(network):
    network.mu[::3] = 0.0
    return network


def compliant(network):
    network.soft[::2] = 0.3 * network.W[::2, 0, 0]
    prepare(network)
    return network


SCENES = {
    "stack with a heavy top": lambda: stack(6, 1e6),
    "pyramid": lambda: pyramid(7),
    "discs": lambda: heap(60, 2),
    "spheres": lambda: heap(60, 3),
    "spheres, some without friction": lambda: some_without_friction(heap(60, 3)),
    "discs, some without friction": lambda: some_without_friction(heap(60, 2)),
    "spheres without friction": lambda: heap(40, 3, mu=0.0),
    "compliant discs": lambda: compliant(heap(40, 2)),
    "compliant spheres": lambda: compliant(heap(40, 3)),
    "planar bridge of joints": lambda: hanging_bridge(2),
    "bridge of joints": lambda: hanging_bridge(3),
}


def take_steps_inside(network, solver, point, most):
    begin_direct(network.address, solver.direct.address)
    tree, fronts = lay_out_fronts(network, solver.direct, 0)
    blocks = network, solver.direct, tree, fronts, point
    go_inside(*(block.address for block in blocks), 0, 0.0, most, network.b.shape[1])
    return tree, fronts


def point_of(network, shift=0.0):
    point = new(Inside, m=len(network.i))
    point.start, point.shift, point.centring, point.part = 0.3, shift, 3.0, 0.95
    return point


def matrix_of(w_N, w_1, w_2, eta):
    """W."""
    w = np.array([w_1, w_2])
    return eta * np.block([[np.array([[w_N]]), w[None]], [w[:, None], np.eye(2) + np.outer(w, w) / (1 + w_N)]])


@pytest.mark.upkeep
@pytest.mark.parametrize("name", SCENES)
def test_a_step_solves_the_linearised_equations_of_the_assembled_problem(name):
    """M dv = J^T dP, dy = (I + theta E) R + S^-1 B (J dv + R dP_N e_N) / v_c, dy + W^-2 dx = r where the shift is zero.

    The matrices have conditions up to 1e10, of the heavy top and of the joints: six digits are left.
    """
    network = SCENES[name]()
    solver, point = solver_of(network), point_of(network)
    d, n = network.b.shape[1], network.v.shape[1]
    tree, fronts = take_steps_inside(network, solver, point, 4)
    islands = network.islands
    network.P[:] = 0.0
    interpreted(interior.leave)(network, point, 0, d)
    judge(network)
    assert interpreted(interior.find_residual)(network, point, 0, d, n) > 0.0
    interpreted(interior.find_stiffness)(network, point, 0, d)
    assert interpreted(factorise_fronts)(network, tree, fronts, point.D, 0, d, n)
    interpreted(interior.find_step)(network, tree, fronts, point, 0, d, n)
    problem = assembled(network)
    contacts = islands.contacts[: islands.contact_start[1]]
    slopes = np.where(network.mu[contacts] > 0.0, network.mu[contacts], 1.0)
    dP = point.dx[: len(contacts)] * point.P_unit[: len(contacts), None]
    dP[:, 0] /= slopes
    impulses = np.zeros((len(network.i), d))
    impulses[contacts] = dP[:, :d]
    dv = np.einsum("bxy,by->bx", network.M_inv, np.einsum("cbx,c->bx", problem.J, impulses.ravel()))
    of_bodies = tree.body[: islands.body_start[1]]
    size = np.abs(dv).max()
    np.testing.assert_allclose(fronts.x[: len(of_bodies)], dv[of_bodies], atol=ROUNDED * size)
    rates = np.zeros((len(network.i), 3))
    rates[:, :d] = np.einsum("cbx,bx->c", problem.J, dv).reshape(-1, d)
    for row, c in enumerate(contacts):
        mu, unit, y = network.mu[c], 1.0 / point.v_unit[row], point.y[row]
        if mu == JOINED:
            left = point.residual[row] / unit + rates[c] + dP[row] / (interior.JOINED_KAPPA * network.rho[c])
            assert np.abs(left).max() <= ROUNDED * np.abs(rates).max()
            continue
        e = point.theta * np.array([0.0, y[1], y[2]]) / max(np.hypot(y[1], y[2]), 1e-300)
        rate = unit * (rates[c] + [network.soft[c] * dP[row, 0], 0.0, 0.0])
        rate = rate if mu > 0.0 else rate * [1.0, 0.0, 0.0]
        change = point.residual[row] + [e @ point.residual[row], 0.0, 0.0]
        change = change + [rate[0] / slopes[row] + e @ rate, rate[1], rate[2]]
        np.testing.assert_allclose(point.dy[row], change, atol=ROUNDED * np.abs(point.dy).max())
        inverse = np.linalg.inv(matrix_of(*point.w[row]))
        target = point.target[row]
        found = point.dy[row] + inverse @ inverse @ point.dx[row]
        np.testing.assert_allclose(found, target, atol=ROUNDED * np.abs(target).max())


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-8, 1e-2, 10.0]))
def test_the_shifted_matrix_is_that_of_the_inverse(seed, shift):
    rng = np.random.default_rng(seed)
    w, a, eta = rng.normal(size=2) * 10.0 ** rng.uniform(-3, 1), rng.normal(size=3), 10.0 ** rng.uniform(-2, 2)
    row = np.array([[np.sqrt(1.0 + w @ w), *w, eta]])
    inverse = np.linalg.inv(matrix_of(*row[0]))
    expected = np.linalg.solve(inverse @ inverse + shift * np.eye(3), a)
    np.testing.assert_allclose(interpreted(shifted)(row, 0, shift, *a), expected, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("name", SCENES)
def test_islands_are_solved_from_no_impulses(name):
    network = SCENES[name]()
    solver = solver_of(network)
    begin_direct(network.address, solver.direct.address)
    judge(network)
    for k in range(network.islands.count):
        assert from_inside(network, solver.direct, k, 1e-9, 1e-11)
    assert judge(network) <= 1e-9


@pytest.mark.parametrize("name", ["pyramid", "spheres, some without friction", "bridge of joints", "compliant discs"])
def test_interpreted_steps_have_the_same_bits(name):
    network = SCENES[name]()
    twin, most = copy_of(network), 3
    ends = []
    for each, is_compiled in ((network, True), (twin, False)):
        solver, point = solver_of(each), point_of(each, 1e-6)
        begin_direct(each.address, solver.direct.address)
        if is_compiled:
            tree, fronts = take_steps_inside(each, solver, point, most)
        else:
            tree, fronts = lay_out_fronts(each, solver.direct, 0)
            interpreted(go_inside)(each, solver.direct, tree, fronts, point, 0, 0.0, most, each.b.shape[1])
        ends.append(np.concatenate([each.words, point.words, solver.words, fronts.words]).view(np.int64))
    np.testing.assert_array_equal(*ends)


@pytest.mark.parametrize("dim", [2, 3])
def test_joints_alone_have_no_inside_and_keep_their_impulses(dim):
    network = hanging_bridge(dim, is_free=True)
    solver = solver_of(network)
    take_steps_inside(network, solver, point_of(network), 5)
    assert not network.P.any()
    laid_out = lay_out_fronts(network, solver.direct, 0)
    interpreted(go_inside)(network, solver.direct, *laid_out, point_of(network), 0, 0.0, 5, network.b.shape[1])
    assert not network.P.any()


def test_where_it_leads_nowhere_it_is_left_out_for_a_while(monkeypatch):
    """After 1, 2, 3 times in a row that changed nothing the next 0, 2, 6 problems are left out."""
    calls = []
    monkeypatch.setattr(rescue, "solve_pressed", lambda *_: calls.append(len(asked)) or 0)
    monkeypatch.setattr(rescue, "solve_whole", lambda *_: 0)
    network, asked = heap(60, 3), []
    network.P[:, 0] = 1.0
    solver = solver_of(network)
    for _ in range(16):
        interpreted(begin_problem)(solver.patience)
        judge(network)
        network.islands.is_met[:] = network.islands.rung[:] = 0
        network.islands.is_met[1:] = 1
        rescue.rescue(network, solver, 1e-9)
        asked.append(1)
    assert calls == [0, 1, 4, 11]


def test_every_distance_is_tried_and_the_best_impulses_are_left(monkeypatch):
    """What no distance solves keeps the impulses that it came with, if all are worse."""
    network, tried = heap(60, 2), []
    solver = solver_of(network)
    begin_direct(network.address, solver.direct.address)
    assert from_inside(network, solver.direct, 0, 1e-9, 1e-11)
    solved, least = network.P.copy(), judge(network)

    def spoil(*_):
        tried.append(points[-1].start)
        network.P[:] = 0.0
        network.islands.residual[0] = 1.0

    def remembered(*arguments, **sizes):
        points.append(new(*arguments, **sizes))
        return points[-1]

    points = []
    monkeypatch.setattr(driver, "new", remembered)
    monkeypatch.setattr(driver, "go_inside", spoil)
    monkeypatch.setattr(driver, "solve_by_al_newton", lambda *_: None)
    assert from_inside(network, solver.direct, 0, 0.0, 0.0)
    assert tried == [start.distance for start in STARTS]
    np.testing.assert_array_equal(network.P, solved)
    assert judge(network) == least


def test_a_train_of_dominoes_is_solved_in_every_step():
    """Islands of 31 to 40 dominoes with friction 2 on the ground, of which sweeps and factors leave every tenth."""
    solution = ns.simulate(DominoRow(), (0, 1), integrator=ns.MoreauJean(dt=5e-4), every=2000)
    assert solution.stats.methods["interior points"] > 0
    assert solution.stats.worst_residual <= solution.stats.tol
