"""The compiled integrator beside SciPy's solvers, and what of theirs is refused."""

import math
import re

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, PainleveRod, SpragSlip
from nonsmooth import ContactMode, Status

SCIPY = ("Radau", "BDF", "LSODA")
MARGIN = {"Radau": 100.0, "BDF": 3e4, "LSODA": 3e4}  # multistep errors gather over the steps; so much per rtol is seen


@pytest.mark.parametrize("method", SCIPY)
def test_seizure_by_another_method_ends_in_the_same_state(method):
    rod, rtol = SpragSlip(), 1e-8
    ends = []
    for chosen in ("compiled", method):
        integrator = ns.Penalty(stiffness=1e6, damping=1e6, rtol=rtol, atol=1e-2 * rtol, method=chosen)
        solution = ns.simulate(rod, (0, 0.4), *rod.state(th=0.78, thdot=1.0), integrator=integrator, t_eval=[0.1, 0.4])
        ends.append(np.concatenate((solution.q[1:, 1], solution.u[1:, 1], [solution.P_N.sum()])))
    assert np.abs(ends[1] - ends[0]).max() < MARGIN[method] * rtol


@pytest.mark.parametrize("method", SCIPY)
def test_impact_without_collision_by_another_method(method):
    rod, k = PainleveRod(mu=2.0), 1e8
    velocities = []
    for chosen in ("compiled", method):
        integrator = ns.Penalty(stiffness=k, rtol=1e-9, method=chosen)
        solution = ns.simulate(rod, (0, 6e-3), *rod.state(th=math.pi / 3, slip=-1.0), integrator=integrator)
        velocities.append(next(e.gamma_N for e in solution.events if e.mode_after == ContactMode.OPEN))
    assert abs(velocities[1] - velocities[0]) < 1e-6


@pytest.mark.parametrize(("start", "t_end"), [((0.9, 2.0), 0.4), ((0.85, 0.0), 0.12), ((0.73, 3.3), 0.01)])
def test_a_solver_that_damps_a_saddle_is_refused(start, t_end):
    """Each start reaches A3 and seizes, at 0.3967, 0.1088 and 0.0035 s; SciPy's Radau steps over the growing force,
    whose rate is k/1 s. With smaller steps it does not, and ends where the compiled integrator does."""
    rod, outcomes = SpragSlip(), []
    span, state = (0.0, t_end), rod.state(th=start[0], thdot=start[1])
    exact = ns.simulate(rod, span, *state, integrator=ns.Penalty(stiffness=1e8, damping=1e8))
    for rtol in (1e-5, 1e-9):
        integrator = ns.Penalty(stiffness=1e8, damping=1e8, method="Radau", rtol=rtol, atol=1e-2 * rtol)
        try:
            solution = ns.simulate(rod, span, *state, integrator=integrator)
            outcomes.append("right" if np.abs(solution.q[-1] - exact.q[-1]).max() < 1e-6 else "wrong")
        except ns.StepFailure as failure:
            assert re.search("a force that grows faster than its steps.*method='compiled'", str(failure), re.DOTALL)
            outcomes.append("refused")
    assert outcomes[0] == "refused" and outcomes[1] != "wrong"


@pytest.mark.parametrize(
    ("change", "status"),
    [
        (lambda found: setattr(found, "y", found.y * np.nan), Status.NOT_FINITE),
        (lambda found: setattr(found, "t", found.t * 0.5), Status.STEP_VANISHED),
        (lambda found: setattr(found, "success", False), Status.STEP_VANISHED),
    ],
    ids=["NaN called a success", "unfinished called a success", "failure"],
)
def test_what_scipy_returns_is_checked(monkeypatch, change, status):
    import scipy.integrate

    solve = scipy.integrate.solve_ivp

    def tampered(*arguments, **options):
        found = solve(*arguments, **options)
        change(found)
        return found

    monkeypatch.setattr(scipy.integrate, "solve_ivp", tampered)
    ball = BouncingBall()
    solution = ns.simulate(
        ball,
        (0, 0.2),
        *ball.state(height=1.0),
        integrator=ns.Penalty(stiffness=1e6, method="LSODA"),
        on_failure="return",
    )
    assert solution.status == status and not solution.success
    assert np.isfinite(solution.q).all()


def test_unknown_method_is_refused_with_the_nearest_name():
    with pytest.raises(ns.UnknownName, match="did you mean 'Radau'"):
        ns.Penalty(stiffness=1e6, method="Radav")


def test_records_of_scipy_steps_are_those_asked_for():
    ball = BouncingBall()
    t = np.linspace(0, 1, 6)
    integrator = ns.Penalty(stiffness=1e6, method="LSODA")
    solution = ns.simulate(ball, (0, 1), *ball.state(height=1.0), integrator=integrator, t_eval=t)
    assert (solution.t == t).all() and solution.q.shape == (6, 1) and solution.la.shape == (6, 1, 2)
    assert abs(solution.q[1, 0] - (1 - 9.81 * 0.2**2 / 2)) < 1e-6
