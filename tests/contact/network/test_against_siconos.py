"""Steps of scenes against Siconos's solution of the same contact problem."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import siconos
from benchmarks.step_problems import CASES, problem_after, solved_by_siconos
from nonsmooth.contact.blocks.problem import check_problem

FOLDER = Path(__file__).parents[2] / "data" / "steps_by_siconos"
AGREE = 1e-8  # of the fastest approach
UNIQUE = ("discs",)  # impulses; those of what touches at more points than it has velocities are not


def compare(problem, ours, theirs, name):
    """Velocities of all contacts and of the bodies; impulses where they are unique. Both solve the problem itself."""
    local = problem.local()
    judge = check_problem(local.G, local.c, local.mu, local.dim)
    scale = np.abs(local.c).max()
    assert judge.error(ours) < 1e-11 and judge.error(theirs) < 1e-11
    gamma, gamma_theirs = (local.G @ P + local.c for P in (ours, theirs))
    assert np.abs(gamma - gamma_theirs).max() < AGREE * scale
    step = problem.H @ (ours - theirs) / problem.M.diagonal()  # of bodies whose axes are not those of inertia: in size
    assert np.abs(step).max() < AGREE * scale
    pressed = np.repeat((np.abs(ours) + np.abs(theirs)).reshape(-1, local.dim)[:, 0] > 0, local.dim)
    G = local.G.toarray()[np.ix_(pressed, pressed)]  # of full rank: these velocities have one set of impulses
    assert (np.linalg.matrix_rank(G) == len(G)) == (name in UNIQUE)
    if name in UNIQUE:
        assert np.abs(ours - theirs).max() < AGREE * np.abs(theirs).max()
    slide = np.linalg.norm(gamma.reshape(-1, local.dim)[:, 1:], axis=1) > 1e-6
    return slide.sum(), pressed.sum() // local.dim


@pytest.mark.parametrize("name", CASES)
def test_a_step_has_the_velocities_that_siconos_found(name):
    """Its solution is kept with the problem; ours is found by the solver that steps scenes."""
    pytest.importorskip("h5py")
    from nonsmooth.results.fclib import read_fclib

    problem = read_fclib(FOLDER / f"{name}.hdf5")
    result = problem.solve(tol=1e-12)
    assert result.solver == "network"
    sliding, pressed = compare(problem, result.P, problem.P, name)
    assert sliding > 0 and pressed > 5


@pytest.mark.skipif(siconos.interpreter() is None, reason="no Siconos (Debian: apt-get install python3-siconos)")
@pytest.mark.parametrize("name", CASES)
def test_siconos_solves_the_step_that_a_scene_takes(name):
    """The impulses are those of the step itself."""
    scene, steps = CASES[name]
    problem = problem_after(scene(), steps)
    (theirs,) = solved_by_siconos([problem])
    compare(problem, problem.P, theirs, name)
