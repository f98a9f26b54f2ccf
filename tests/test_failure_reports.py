"""A step that fails leaves its contact problem as a small file, which is solved again with the same bits."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import SelfLockingRod, SlidingBlock
from nonsmooth.cli import main
from nonsmooth.runs.failed_problem import FailedProblem
from nonsmooth.studies.solve_files import solve_files

STEP = ns.MoreauJean(dt=1e-3)


def jammed():
    """The rod pressed beyond the angle at which it jams: every mode of its contact is refuted."""
    rod = SelfLockingRod(mu=1.0, th0=math.radians(50))
    with pytest.raises(ns.StepFailure) as failure:
        ns.simulate(rod, (0, 0.1), *SelfLockingRod(mu=1.0).state(th=math.radians(50)), integrator=STEP)
    return failure.value


def two_blocks_on_one_floor():
    """Two blocks, one of which slides so fast that its friction law is negative: the second contact of two fails."""
    block = SlidingBlock()

    def mass(t, q, p, M):
        for i in range(4):
            M[i, i] = 2.0

    def force(t, q, u, p, h):
        h[1] = -20.0
        h[3] = -20.0

    def gap(t, q, p, g_N):
        g_N[0] = q[1]
        g_N[1] = q[3]

    def normal(t, q, p, W_N):
        W_N[0, 1] = 1.0
        W_N[1, 3] = 1.0

    def tangent(t, q, p, W_F):
        W_F[0, 0, 0] = 1.0
        W_F[1, 0, 2] = 1.0

    contacts = [ns.Contact(mu=0.3), ns.Contact(mu=ns.Polynomial(m0=0.3, m1=0.2))]
    system = ns.System(n_q=4, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, contacts=contacts,
                       parameters=block)  # fmt: skip
    with pytest.raises(ns.StepFailure) as failure:
        ns.simulate(system, (0, 1), np.zeros(4), [0.5, 0, 2.0, 0], integrator=STEP)
    return failure.value


def test_the_problem_in_the_file_is_the_one_the_mechanics_gives():
    """Blocks of 2 kg: G = 1/m on the diagonal, and c_N = -g dt with g = 10 m/s^2, as the floor is not left."""
    problem = two_blocks_on_one_floor().problem
    assert np.allclose(problem.G, np.eye(4) / 2, rtol=1e-15)
    assert np.allclose(problem.c[[1, 3]], [0.5, 2.0], rtol=1e-15)
    assert (problem.c[[0, 2]] < 0).all()
    assert problem.laws.shape[0] == 2 and problem.dt == STEP.dt


@pytest.mark.parametrize("fail", [jammed, two_blocks_on_one_floor])
def test_a_dumped_problem_is_read_back_bit_for_bit_and_fails_again(fail, tmp_path):
    failure = fail()
    path = failure.dump(tmp_path / "step.npz")
    again = FailedProblem.load(path)
    for name, array in vars(failure.problem).items():
        assert np.array_equal(getattr(again, name), array)
    assert again.solve().status == failure.solution.status
    assert [file.name for file in tmp_path.iterdir()] == ["step.npz"] and path.stat().st_size < 10_000


def test_a_problem_that_has_a_solution_is_solved_where_it_is_replayed(tmp_path):
    """The jammed rod with less friction: mu = 0 leaves P_N = -c_N / G_NN."""
    problem = jammed().problem
    problem.laws[:, 3] = 0.0
    answer = problem.solve()
    assert answer.status == ns.Status.FINISHED and answer.residual < 1e-12
    assert math.isclose(answer.P[0], max(0.0, -problem.c[0] / problem.G[0, 0]), rel_tol=1e-12)


def test_the_command_line_saves_what_solve_opens_again(tmp_path, capsys):
    path = str(tmp_path / "step.npz")
    run = ["run", "self-locking-rod", "--set", "mu=1", "th0=50*pi/180", "--state", "th=50*pi/180", "--no-plot"]
    assert main([*run, "--dump-failure", path]) == 3
    assert "no solution" in capsys.readouterr().err
    assert main(["solve", path]) == 3
    printed = capsys.readouterr().out
    assert "NO_SOLUTION" in printed and "of the step" in printed


def test_a_run_that_succeeds_writes_no_problem(tmp_path, capsys):
    path = tmp_path / "step.npz"
    assert main(["run", "bouncing-ball", "--t-end", "0.01", "--no-plot", "--dump-failure", str(path)]) == 0
    assert not path.exists()


def test_a_failure_without_a_contact_problem_says_so(tmp_path, capsys):
    def force(t, q, u, p, h):
        h[0] = 1e300 * u[0] * u[0]

    def mass(t, q, p, M):
        M[0, 0] = 1.0

    with pytest.raises(ns.StepFailure) as failure:
        ns.simulate(ns.System(n_q=1, mass=mass, force=force), (0, 1), [0.0], [1e10], integrator=STEP)
    assert failure.value.problem is None and failure.value.residual == 0.0
    with pytest.raises(ns.InvalidInput, match="no contact problem to write"):
        failure.value.dump(tmp_path / "step.npz")


@pytest.mark.parametrize("name", ["G", "start", "kinds", "about"])
def test_a_damaged_problem_is_refused(name, tmp_path):
    path = jammed().dump(tmp_path / "step.npz")
    with np.load(path) as file:
        entries = dict(file)
    entries[name] = np.array("{") if name == "about" else entries[name][:-1]
    np.savez(path, **entries)
    with pytest.raises(ns.InvalidInput):
        FailedProblem.load(path)
    (row,) = solve_files([path], "auto", 1e-8)
    assert row["status"] == "ERROR" and row["message"]
