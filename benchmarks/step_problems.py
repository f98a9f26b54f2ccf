"""Contact problems of single steps of scenes, as other programs can solve them; Siconos's solutions of these.

    M v = H P + f,    gamma = H^T v + w

of the bodies that move. ``write(folder)`` puts them into files of FCLIB, with the impulses that Siconos found, for the
tests where it is not installed.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from benchmarks import siconos
from benchmarks.adapters.nonsmooth_scenes import Motion
from benchmarks.scenes import DT, discs
from nonsmooth.contact.network.problem import Network
from nonsmooth.results.fclib import GlobalContactProblem, write_fclib
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, Capsule, Cylinder, HalfSpace, Sphere


def slanted() -> Scene:
    """Four boxes in a stack, each turned a little about the vertical, on a ground that is too steep for them."""
    scene = Scene(gravity=(3.5, 0.4, -9.81), material=Material(mu=0.3))
    scene.fixed(HalfSpace((0, 0, 1)))
    for k in range(4):
        turn = (math.cos(0.05 * k), 0, 0, math.sin(0.05 * k))
        scene.body(Box(0.2, 0.2, 0.2), density=1000, position=(0.01 * k, 0, 0.1 + 0.2 * k), turn=turn)
    return scene


def thrown() -> Scene:
    """Eight bodies of four shapes that fall on one another."""
    rng, scene = np.random.default_rng(2), Scene(gravity=(0, 0, -9.81), material=Material(mu=0.4))
    scene.fixed(HalfSpace((0, 0, 1)))
    shapes = (Box(0.2, 0.15, 0.1), Cylinder(0.08, 0.2), Capsule(0.15, 0.05), Sphere(0.1))
    for k in range(8):
        turn = rng.normal(size=4)
        place = (*rng.uniform(-0.1, 0.1, 2), 0.2 + 0.32 * k)
        scene.body(shapes[k % 4], density=1000, position=place, turn=turn / np.linalg.norm(turn))
    return scene


def poured() -> Scene:
    """Thirty spheres, some of them spinning, that fall into a trough."""
    rng, scene = np.random.default_rng(4), Scene(gravity=(0, 0, -9.81), material=Material(mu=0.3))
    for normal in ((1, 0, 1), (-1, 0, 1), (0, 1, 1), (0, -1, 1)):
        scene.fixed(HalfSpace(normal))
    for k in range(30):
        place = (*rng.uniform(-0.05, 0.05, 2), 0.15 + 0.11 * k)
        scene.body(Sphere(0.05), density=1000, position=place, spin=rng.normal(size=3) * 20)
    return scene


# scenes, and steps after which many of their contacts slide
CASES = {
    "spheres": (poured, 200),
    "slanted": (slanted, 40),
    "thrown": (thrown, 300),
    "discs": (lambda: discs(40), 150),
}


def problem_after(scene: Scene, steps: int) -> GlobalContactProblem:
    """That of the last of so many steps, with our impulses."""
    motion = Motion(scene, DT, tol=1e-11, sweeps=20_000)
    motion.step(steps)
    return problem_of(motion.run.assembly.network)


def problem_of(network: Network) -> GlobalContactProblem:
    """Of all contacts that a network has, and of the bodies that can move."""
    from scipy.sparse import block_diag, csc_array

    n_c, (n_b, n), d = int(network.n_c), network.v.shape, network.b.shape[1]
    moving = np.flatnonzero(network.M_inv[:, 0, 0] > 0)
    J = np.zeros((n_c, d, n_b, n))
    for c in range(n_c):
        J[c, :, network.i[c]] = network.J_i[c]
        J[c, :, network.j[c]] += network.J_j[c]
    H = csc_array(J[:, :, moving].reshape(n_c * d, -1).T)
    f = np.einsum("bxy,by->bx", network.M[moving], network.v_free[moving]).ravel()
    still = np.setdiff1d(np.arange(n_b), moving)
    w = network.b[:n_c] + np.einsum("cdbx,bx->cd", J[:, :, still], network.v_free[still])
    M = csc_array(block_diag([0.5 * (block + block.T) for block in network.M[moving]]))
    mu, P = network.mu[:n_c].copy(), network.P[:n_c].ravel()
    return GlobalContactProblem(M, H, f, w.ravel(), mu, d, P=P, note="by nonsmooth")


def solved_by_siconos(problems: list[GlobalContactProblem]) -> list[np.ndarray]:
    """Impulses of each."""
    local = [problem.local() for problem in problems]
    return [r for r, _ in siconos.solve_steps([(np.asarray(p.G.todense()), p.c, p.mu) for p in local])]


def write(folder: Path) -> None:
    """All cases with Siconos's impulses."""
    problems = {name: problem_after(scene(), steps) for name, (scene, steps) in CASES.items()}
    for (name, p), r in zip(problems.items(), solved_by_siconos(list(problems.values())), strict=True):
        given = GlobalContactProblem(p.M, p.H, p.f, p.w, p.mu, p.dim, P=r)
        write_fclib(folder / f"{name}.hdf5", given)
