"""Trees of joints are solved at once: the impulses of a step against dense ones, in plane and space; loops are left."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.integrators.moreau_jean.contact_solver import ContactSolver
from nonsmooth.runs.scene_run import SceneRun


def tree(dim, n, is_free, kinds, ratio):
    """n bodies, each joined to one before it at random, the first to the ground; masses differ by ``ratio``."""
    rng = np.random.default_rng(n + dim)
    gravity = (0, -9.81) if dim == 2 else (0, 0, -9.81)
    scene, ball = ns.Scene(gravity=gravity), ns.Disc(0.05) if dim == 2 else ns.Sphere(0.05)
    scene.fixed(ball, name="ground")
    for k in range(n):
        spin = rng.normal() if dim == 2 else rng.normal(size=3)
        inertia = {} if dim == 2 else {"inertia": 1e-2 * rng.uniform(1, 1.5, 3)}
        body = scene.body(
            ball, mass=ratio ** rng.uniform(), position=rng.normal(size=dim), spin=spin, velocity=rng.normal(size=dim),
            name=f"{k}", **inertia,
        )  # fmt: skip
        if k == 0 and is_free:
            continue
        other = "ground" if k == 0 else f"{rng.integers(k)}"
        kind = kinds[k % len(kinds)]
        at = {"at": rng.normal(size=dim)}
        axis = {"axis": rng.normal(size=dim)} if kind in ("slider", "slot") or (kind == "hinge" and dim == 3) else {}
        getattr(scene, kind)(other, body, **axis, **({} if kind == "distance" else at))
    scene.ignore(*scene.bodies)
    return scene


def after_a_step(scene):
    run = SceneRun(scene, (0.0, 1e-3), ns.MoreauJean(dt=1e-3, contacts=ContactSolver()), 1, None)
    run.assembly.take_steps(1e-3, 1)
    return run.assembly.network


def dense(network):
    """P and v of rigid joints, by all rows at once."""
    n_c, d, n = network.n_c, network.b.shape[1], network.v.shape[1]
    J = np.zeros((n_c * d, len(network.v) * n))
    for c in range(n_c):
        for J_b, body in ((network.J_i, network.i[c]), (network.J_j, network.j[c])):
            J[d * c : d * c + d, n * body : n * body + n] += J_b[c]
    M_inv = np.zeros((J.shape[1], J.shape[1]))
    for body, block in enumerate(network.M_inv):
        M_inv[n * body : n * body + n, n * body : n * body + n] = block
    rhs = J @ network.v_free.ravel() + network.b[:n_c].ravel()
    used, P = J.any(axis=1), np.zeros(len(J))
    P[used] = -np.linalg.solve((J @ M_inv @ J.T)[np.ix_(used, used)], rhs[used])
    return P.reshape(n_c, d), (network.v_free.ravel() + M_inv @ J.T @ P).reshape(network.v.shape)


KINDS = {2: (["joint"], ["hinge", "slider", "fix", "slot", "distance"]),
         3: (["joint"], ["hinge", "slider", "joint", "fix", "slot", "distance"])}  # fmt: skip


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("mixed", [0, 1])
@pytest.mark.parametrize("is_free", [False, True])
@pytest.mark.parametrize(("n", "ratio"), [(1, 1.0), (2, 10.0), (12, 1e4), (60, 10.0)])
def test_a_tree_of_joints_has_the_impulses_of_all_rows_at_once(dim, mixed, is_free, n, ratio):
    network = after_a_step(tree(dim, n, is_free, KINDS[dim][mixed], ratio))
    islands = network.islands
    if n == 1 and is_free:
        assert islands.count == 0
        return
    assert islands.count == 1 and islands.factors[0] == 1 and islands.sweeps[0] == 0
    P, v = dense(network)
    np.testing.assert_allclose(network.P[: network.n_c], P, atol=1e-9 * abs(P).max())
    np.testing.assert_allclose(network.v, v, atol=1e-10 * abs(v).max())


def test_a_loop_and_a_tree_held_twice_are_left_to_the_ladder_and_met():
    """A chain between two walls, and one whose ends are joined."""
    for ends in (("ground", "ground"), ("0", "5")):
        scene = ns.Scene(gravity=(0, -9.81))
        scene.fixed(ns.Disc(0.05), name="ground")
        for k in range(6):
            scene.body(ns.Disc(0.05), mass=1.0, position=(np.cos(k), np.sin(k)), spin=1.0, name=f"{k}")
            if k:
                scene.joint(f"{k - 1}", f"{k}", at=(np.cos(k - 0.5), np.sin(k - 0.5)))
        scene.joint(ends[0], "0" if ends[0] == "ground" else "5", at=(0.0, 0.0))
        if ends[1] == "ground":
            scene.joint("ground", "5", at=(2.0, 0.0))
        scene.ignore(*scene.bodies)
        islands = after_a_step(scene).islands
        assert islands.count == 1 and islands.is_met[0] == 1 and islands.residual[0] < 1e-8
        assert islands.factors[0] + islands.sweeps[0] > 1
