"""A step that fails leaves its contact problem as a small file, which is solved again with the same bits."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import SelfLockingRod, SlidingBlock
from nonsmooth.commands.cli import main
from nonsmooth.commands.solve_files import solve_files
from nonsmooth.contact.blocks.problem import check_problem
from nonsmooth.mechanics.laws import LAW_C, LAW_CODE, LAW_IMPACT, LAW_WIDTH, POLYNOMIAL, ImpactLaw
from nonsmooth.mechanics.system import BILATERAL, GIVEN_FORCE, UNILATERAL
from nonsmooth.results.failed_problem import FailedProblem
from nonsmooth.results.fclib import read_fclib

STEP = ns.MoreauJean(dt=1e-3)


def jammed(integrator=STEP):
    """The rod pressed beyond the angle at which it jams: every mode of its contact is refuted."""
    rod = SelfLockingRod(mu=1.0, th0=math.radians(50))
    with pytest.raises(ns.StepFailure) as failure:
        ns.simulate(rod, (0, 0.1), *SelfLockingRod(mu=1.0).state(th=math.radians(50)), integrator=integrator)
    return failure.value


def falls_and_jams(integrator=STEP):
    """The rod beyond that angle, with its tip above the belt: it lands, and then no mode is left."""
    rod = SelfLockingRod(mu=1.0, th0=math.radians(50))
    with pytest.raises(ns.StepFailure) as failure:
        ns.simulate(rod, (0, 1.0), [math.radians(49)], [0.0], integrator=integrator)
    return failure.value


def two_blocks_on_one_floor(integrator=STEP):
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
        ns.simulate(system, (0, 1), np.zeros(4), [0.5, 0, 2.0, 0], integrator=integrator)
    return failure.value


def test_the_problem_in_the_file_is_the_one_the_mechanics_gives():
    """Blocks of 2 kg: G = 1/m on the diagonal, and c_N = -g dt with g = 10 m/s^2, as the floor is not left."""
    problem = two_blocks_on_one_floor().problem
    assert np.allclose(problem.G, np.eye(4) / 2, rtol=1e-15)
    assert np.allclose(problem.c[[1, 3]], [0.5, 2.0], rtol=1e-15)
    assert (problem.c[[0, 2]] < 0).all()
    assert problem.laws.shape[0] == 2 and problem.dt == STEP.dt


@pytest.mark.parametrize("integrator", [STEP, ns.EventDriven(), ns.Adaptive()], ids=lambda one: type(one).__name__)
@pytest.mark.parametrize("fail", [jammed, two_blocks_on_one_floor])
def test_a_dumped_problem_is_read_back_bit_for_bit_and_fails_again(fail, integrator, tmp_path):
    failure = fail(integrator)
    path = failure.dump(tmp_path / "step.npz")
    again = FailedProblem.load(path)
    for name, array in vars(failure.problem).items():
        assert np.array_equal(getattr(again, name), array)
    assert again.solve().status == failure.solution.status
    assert [file.name for file in tmp_path.iterdir()] == ["step.npz"] and path.stat().st_size < 10_000


@pytest.mark.parametrize("integrator", [ns.EventDriven(), ns.Adaptive()], ids=lambda one: type(one).__name__)
def test_a_run_that_lands_where_no_mode_is_left_has_the_problem_of_its_landing(integrator):
    """The speed is that of the fall under the moment R l cos th from 49 to 50 degrees, and c that speed, as e = 0."""
    failure = falls_and_jams(integrator)
    problem, rod = failure.problem, SelfLockingRod()
    speed = math.sqrt(2 * rod.R * rod.l / rod.I * (math.sin(math.radians(50)) - math.sin(math.radians(49))))
    assert problem.gamma_0[0] == pytest.approx(-rod.l * math.cos(math.radians(50)) * speed, rel=1e-4)
    assert problem.c[0] == pytest.approx(problem.gamma_0[0], rel=1e-2) and problem.kinds.tolist() == [[UNILATERAL, 1]]
    assert problem.solve().status == failure.solution.status == ns.Status.NO_SOLUTION


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


def test_a_problem_that_another_program_wrote_again_is_refused(tmp_path):
    """Its step was solved with the bits in the file: what changed them is not known."""
    path = jammed().dump(tmp_path / "step.npz")
    with np.load(path) as file:
        entries = dict(file)
    np.savez(path, **entries)
    with pytest.raises(ns.InvalidInput, match="step.npz holds no contact problem of a step, .* it has no seal"):
        FailedProblem.load(path)
    (row,) = solve_files([path], "auto", 1e-8)
    assert row["status"] == "ERROR" and "it has no seal" in row["message"]


# FCLIB: u = W r + q, rows (N, T) for each contact


def made_problem(seed, *kinds, mu=0.4):
    """A problem of contacts (kind, directions of friction) between bodies of random masses, with its solution."""
    rng = np.random.default_rng(seed)
    kinds = np.array(kinds)
    start = np.concatenate([[0], np.cumsum(1 + kinds[:, 1])])
    r = start[-1]
    H = rng.normal(size=(r, r + 2))
    laws = np.zeros((len(kinds), LAW_WIDTH))
    laws[:, LAW_C] = mu * kinds[:, 1]
    n = len(kinds)
    modes = np.zeros(n, dtype=np.int64)
    return FailedProblem(H @ H.T, rng.normal(size=r), np.zeros(r), start, kinds, laws, np.zeros(n), np.zeros((n, 2)),
                         modes, modes.copy(), 1e-3, 0, "made")  # fmt: skip


@pytest.mark.parametrize("kinds", [
    [(UNILATERAL, 1)], [(UNILATERAL, 1), (UNILATERAL, 1)], [(UNILATERAL, 0), (UNILATERAL, 1)],
    [(BILATERAL, 0), (UNILATERAL, 1)], [(UNILATERAL, 1), (BILATERAL, 0), (UNILATERAL, 0), (UNILATERAL, 1)],
])  # fmt: skip
def test_the_fclib_form_has_the_solution_of_the_step(kinds, tmp_path):
    """W is positive definite and mu small: the solution is unique, and two solvers that share nothing find it. The
    general one stops at an error of 1e-8 |q|, so P is known to 1e-8 |q| over the least eigenvalue of G."""
    for seed in range(5):
        problem = made_problem(seed, *kinds)
        answer = problem.solve()
        assert answer.status == ns.Status.FINISHED
        form = read_fclib(problem.save(tmp_path / "step.hdf5"))
        found = ns.solve_contact(form.G, form.c, form.mu, form.dim, solver="nsgs", tol=1e-8)
        assert found.success and form.about == "made"
        P = np.zeros((len(form.mu), 2))
        unilateral = [k for k, (kind, _) in enumerate(kinds) if kind == UNILATERAL]
        for i, k in enumerate(unilateral):
            rows = slice(problem.start[k], problem.start[k + 1])
            P[i, : kinds[k][1] + 1] = answer.P[rows]
        assert check_problem(form.G, form.c, form.mu, form.dim).error(P.ravel()) < 1e-12
        bound = 1e-8 * np.linalg.norm(form.c) / np.linalg.eigvalsh(problem.G)[0]
        assert np.abs(found.P - P.ravel()).max() < 10 * bound


def test_the_fclib_form_of_the_jammed_rod_is_its_problem_and_no_mode_solves_it(tmp_path, capsys):
    """One contact: P = 0, stick and both slides, each from the two equations of its mode, leave the error that the
    cone or the sign leaves; and the general solvers find nothing."""
    failure = jammed()
    path = failure.dump(tmp_path / "step.hdf5")
    form = read_fclib(path)
    assert np.array_equal(form.G.toarray(), failure.problem.G) and np.array_equal(form.c, failure.problem.c)
    assert form.mu.tolist() == [1.0] and form.about == str(failure)
    error = check_problem(form.G, form.c, form.mu, 2).error
    G, c = failure.problem.G, failure.problem.c
    slides = [np.array([1.0, -sign]) * -c[0] / (G[0] @ [1.0, -sign]) for sign in (-1.0, 1.0)]
    for P in (np.zeros(2), np.linalg.solve(G, -c), *slides):
        assert error(P) > 1e4 * 1e-8  # a solution has 1e-8
    assert main(["solve", str(path)]) == 3
    assert "fc2d" in capsys.readouterr().out


@pytest.mark.parametrize(("kinds", "law", "what"), [
    ([(BILATERAL, 1)], {}, "friction of a bilateral contact"), ([(GIVEN_FORCE, 0)], {}, "a given normal force"),
    ([(UNILATERAL, 1)], {LAW_CODE: POLYNOMIAL}, "friction that depends on the sliding speed"),
    ([(UNILATERAL, 1)], {LAW_IMPACT: ImpactLaw.POISSON}, "another law of impact"),
    ([(BILATERAL, 0)], {}, "bilateral contacts only"),
])  # fmt: skip
def test_what_fclib_has_no_place_for_is_refused_and_said(kinds, law, what, tmp_path):
    problem = made_problem(0, *kinds)
    for column, value in law.items():
        problem.laws[:, column] = value
    with pytest.raises(ns.InvalidInput, match=f"FCLIB has no place for {what}.*; write .npz"):
        problem.save(tmp_path / "step.hdf5")
    assert not list(tmp_path.iterdir())


def test_bilateral_contacts_that_depend_on_one_another_are_not_eliminated(tmp_path):
    problem = made_problem(0, (BILATERAL, 0), (BILATERAL, 0), (UNILATERAL, 1))
    problem.G[:2, :2] = 1.0
    with pytest.raises(ns.InvalidInput, match="depend on one another"):
        problem.save(tmp_path / "step.hdf5")
