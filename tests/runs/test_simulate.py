"""The front door: grids, failures with their partial solutions, bad input, and one source run at two speeds."""

import linecache
import math

import numpy as np
import pytest

import nonsmooth as ns
import nonsmooth.runs.run as runs
from models import BeadChain, BouncingBall, PainleveRod, RockingBlock, SelfLockingRod, SlidingBlock, SpragSlip
from nonsmooth.runs.system_run import SystemRun
from tests.systems import PointMass, ball, ball_mass, ball_normal

STEP = ns.MoreauJean(dt=1e-3)


def rough_ball(mu):
    return ball(ns.Contact(mu=mu), tangent=ball_normal)


@pytest.mark.parametrize(
    "model", [BouncingBall(), PainleveRod(), SpragSlip(), RockingBlock(), BeadChain(n=4)], ids=repr
)
def test_compiled_and_interpreted_runs_agree_to_rounding(model, monkeypatch):
    q0, u0 = model.state()
    compiled = ns.simulate(model, (0, 0.05), q0, u0, integrator=STEP)
    monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    interpreted = ns.simulate(model, (0, 0.05), q0, u0, integrator=STEP)
    assert compiled.stats.is_compiled and not interpreted.stats.is_compiled
    assert np.allclose(compiled.q, interpreted.q, rtol=1e-12, atol=1e-14)
    assert (compiled.mode == interpreted.mode).all()


def test_what_numba_refuses_runs_interpreted_with_a_warning():
    table = {"gravity": 9.81}

    def odd_force(t, q, u, p, h):
        h[0] = -p.m * dict(table)["gravity"]

    system = ball(force=odd_force)
    with pytest.warns(ns.InterpretedWarning, match="odd_force"):
        solution = ns.simulate(system, (0, 0.1), [1.0], [0.0], integrator=STEP)
    assert np.allclose(solution.q, ns.simulate(ball(), (0, 0.1), [1.0], [0.0], integrator=STEP).q, rtol=1e-15)


@pytest.mark.parametrize("is_compiled", [True, False])
def test_model_functions_write_into_cleared_arrays(is_compiled, monkeypatch):
    def summed(t, q, u, p, h):
        h[0] += -p.m * p.g
        if t < 0.1:
            h[0] += 2 * p.m * p.g

    if not is_compiled:
        monkeypatch.setenv("NONSMOOTH_INTERPRET", "1")
    system = ns.System(n_q=1, mass=ball_mass, force=summed, parameters=PointMass())
    sol = ns.simulate(system, (0, 0.3), [0.0], [0.0], integrator=STEP)
    assert sol.u[-1, 0] == pytest.approx(9.81 * 0.1 - 9.81 * 0.2, rel=1e-12)


def test_t_eval_records_exactly_there():
    t = [0.0, 0.0137, 0.1, 0.10001]
    solution = ns.simulate(ball(), (0, 0.2), [1.0], [0.0], integrator=STEP, t_eval=t)
    assert (solution.t == t).all()
    assert np.allclose(solution.q[:, 0], 1 - 9.81 / 2 * np.square(t), atol=1e-12)  # theta = 1/2 is exact in free fall


ALL = [STEP, ns.Adaptive(1e-6, 1e-8), ns.EventDriven(), ns.Penalty(1e6, damping_ratio=0.5), "auto"]


@pytest.mark.upkeep
@pytest.mark.parametrize("integrator", ALL)
def test_results_are_at_the_times_asked_for_and_at_no_other(integrator, tmp_path):
    """The first one behind the start: impulses and works are still those since the start, also read from a file."""
    t, state, pusher = np.array([0.31, 0.5, 0.7]), ([1.0], [0.0]), ball()
    asked = ns.simulate(pusher, (0, 0.8), *state, integrator=integrator, t_eval=t)
    whole = ns.simulate(pusher, (0, 0.8), *state, integrator=integrator, t_eval=[0.0, *t])
    assert np.array_equal(asked.t, t) and np.array_equal(whole.t, [0.0, *t])
    for name in ("q", "u", "g_N", "P_N", "P_F", "mode", "slip"):
        assert np.array_equal(getattr(asked, name), getattr(whole, name)[1:])
    for name, works in whole.ledger.items():
        assert np.array_equal(asked.ledger[name], works[1:])
    assert asked.P_N.sum() > 0.0 and asked.ledger["force"][0] == pytest.approx(0.5 * 9.81 * 9.81 * 0.31**2, rel=1e-6)
    assert "energy: kinetic" in asked.summary()
    read = ns.Solution.load(asked.save(tmp_path / "asked.npz"))
    assert np.array_equal(read.t, t) and np.array_equal(read.ledger["force"], asked.ledger["force"])
    if integrator != "auto":
        kept = ns.simulate(pusher, (0, 0.8), *state, integrator=integrator, t_eval=t, checkpoint=tmp_path / "kept")
        again = ns.Solution.load(tmp_path / "kept")
        for sol in (kept, again):
            assert np.array_equal(sol.t, t) and np.array_equal(sol.q, asked.q) and np.array_equal(sol.P_N, asked.P_N)
            assert np.array_equal(sol.ledger["force"], asked.ledger["force"])


@pytest.mark.parametrize("t_0, t_1, dt", [(0.0, 0.3, 0.1), (0.0, 2.0, 0.07), (1.3, 1.3 + 0.7, 1e-3), (-0.1, 0.2, 0.1)])
@pytest.mark.parametrize("integrator", [ns.MoreauJean, None])
def test_the_end_of_a_run_is_the_end_asked_for(t_0, t_1, dt, integrator):
    """n dt is not t_1 in floating point; the last record is, and the motion is known there and a rounding beside."""
    chosen = ns.EventDriven() if integrator is None else integrator(dt)
    sol = ns.simulate(ball(), (t_0, t_1), [1.0], [0.0], integrator=chosen)
    assert sol.t[-1] == t_1
    for t in (t_1, np.nextafter(t_1, 9.0), t_0 + (t_1 - t_0)):
        assert np.array_equal(sol(t).q, sol.q[-1])
    assert np.array_equal(sol(np.nextafter(t_0, -9.0)).u, sol.u[0])
    for t in (t_1 + 1e-9, t_0 - 1e-9):
        with pytest.raises(ns.InvalidInput, match="t must be a time within"):
            sol(t)


def test_every_thins_the_record_and_keeps_the_impulses():
    all_steps = ns.simulate(ball(), (0, 1), [1.0], [0.0], integrator=STEP)
    some = ns.simulate(ball(), (0, 1), [1.0], [0.0], integrator=STEP, every=10)
    assert (some.q == all_steps.q[::10]).all()
    assert np.isclose(some.P_N.sum(), all_steps.P_N.sum(), rtol=1e-13)


def test_two_runs_agree_bit_for_bit():
    model = SpragSlip()
    first, second = (ns.simulate(model, (0, 0.5), *model.state(), integrator=STEP) for _ in range(2))
    assert (first.q == second.q).all() and (first.P_N == second.P_N).all()


def test_open_flight_does_no_contact_work():
    solution = ns.simulate(ball(), (0, 0.1), [1.0], [0.0], integrator=STEP)
    assert solution.stats.lcp_solved == 0
    assert solution.stats.lcp_skipped == 100


def test_a_chain_with_more_contacts_than_room_for_events_goes_on():
    beads = BeadChain(n=100)
    sol = ns.simulate(beads, (0, 2e-3), *beads.state(), integrator=STEP)
    assert sol.success and sol.stats.steps == 2


def test_self_locking_rod_beyond_its_jam_angle_has_no_solution_and_says_so():
    rod = SelfLockingRod(mu=1.0)
    q0, u0 = rod.state(th=math.radians(50))
    model = SelfLockingRod(mu=1.0, th0=math.radians(50))
    with pytest.raises(ns.StepFailure, match="no solution") as failure:
        ns.simulate(model, (0, 0.1), q0, u0, integrator=STEP)
    assert failure.value.solution.status == ns.Status.NO_SOLUTION
    assert len(failure.value.solution.t) >= 1


@pytest.mark.parametrize("degrees", [10, 20, 30, 44])
def test_self_locking_rod_is_pressed_by_the_published_force(degrees):
    th = math.radians(degrees)
    rod = SelfLockingRod(mu=1.0, th0=th)
    solution = ns.simulate(rod, (0, 0.01), *rod.state(th=th), integrator=STEP)
    assert np.allclose(solution.P_N[1:, 0] / 1e-3, rod.R / (1 - math.tan(th)), rtol=1e-9)


# Failures of the model ---------------------------------------------------------------------------------------------


def test_nan_written_by_a_model_function_names_the_function_and_keeps_the_past():
    def bad(t, q, u, p, h):
        h[0] = -p.m * p.g if t < 0.05 else math.nan

    with pytest.raises(ns.ModelFunctionError, match=r"force wrote nan.*t = 0\.0") as failure:
        ns.simulate(ball(force=bad), (0, 1), [1.0], [0.0], integrator=STEP)
    assert 49 <= failure.value.solution.stats.steps <= 51
    assert np.isfinite(failure.value.solution.q).all()


def test_model_function_that_raises_is_named_with_its_error():
    def bad(t, q, p, g_N):
        if t > 0.05:
            raise ValueError("out of range")
        g_N[0] = q[0]

    with pytest.raises(ns.ModelFunctionError, match="gap raised ValueError: out of range"):
        ns.simulate(ball(gap=bad), (0, 1), [1.0], [0.0], integrator=STEP)


def test_mass_that_becomes_singular_stops_the_run_with_the_partial_solution():
    def shrinking(t, q, p, M):
        M[0, 0] = p.m * (0.5 - q[0] * 0 - t)

    solution = ns.simulate(ball(mass=shrinking), (0, 1), [9.0], [0.0], integrator=STEP, on_failure="return")
    assert solution.status == ns.Status.MASS_NOT_POSITIVE
    assert "positive definite" in solution.message
    assert abs(solution.t[-1] - 0.5) < 2e-3


@pytest.mark.parametrize("cost", [1e-7, 1e-5, 1e-3, 1.0])
def test_the_clock_is_looked_at_as_often_whatever_a_step_costs(cost):
    block = SystemRun.first_block
    for _ in range(20):
        block = runs.next_block(block, block * cost)
    assert block == max(1, int(runs.LOOK_EVERY / cost)) or abs(block * cost / runs.LOOK_EVERY - 1) < 0.1


@pytest.mark.parametrize(
    "integrator",
    [STEP, ns.EventDriven(), ns.Adaptive(), "auto"],
    ids=["step", "events", "adaptive", "auto"],
)
def test_warnings_point_at_the_line_of_the_user(integrator):
    """Whatever stands between that line and the run, which is another number of calls with each."""
    with pytest.warns(ns.InitialStateWarning) as caught:
        ns.simulate(ball(), (0, 0.01), [-0.1], [0.0], integrator=integrator)
    assert [(warning.filename, source_line(warning)) for warning in caught] == [(__file__, "ns.simulate")]


def source_line(warning):
    """What is called in the line that a warning points at."""
    return linecache.getline(warning.filename, warning.lineno).strip().partition("(")[0]


def test_ctrl_c_gives_back_what_was_computed_with_its_events():
    looks = []

    def interrupt(done):
        looks.append(done)
        if len(looks) == 3:  # after 100, at most 1000 and at most 10 000 steps of 300 000
            raise KeyboardInterrupt

    step, start = ns.MoreauJean(dt=1e-5), ([1e-6], [0.0])  # the first impact is in step 45
    solution = ns.simulate(ball(), (0, 3), *start, integrator=step, every=30, progress=interrupt)
    assert solution.status == ns.Status.INTERRUPTED and not solution.success
    assert 1e-3 < solution.t[-1] < 0.112 and solution.message.startswith("interrupted at t = ")
    whole = ns.simulate(ball(), (0, 3), *start, integrator=step, every=30)
    n = len(solution.t) - 1  # the last record is the state at the interruption, between two records
    assert (solution.q[:n] == whole.q[:n]).all()
    assert (solution.event_rows == whole.event_rows[: len(solution.event_rows)]).all() and len(solution.events) > 1


def test_negative_friction_law_is_a_typed_failure():
    block = SlidingBlock().system()
    contact = ns.Contact(mu=ns.Polynomial(m0=0.3, m1=0.2))  # negative above 1.5 m/s
    system = ns.System(n_q=2, contacts=[contact], parameters=block.parameters, mass=block.mass, force=block.force,
                       gap=block.gap, normal=block.normal, tangent=block.tangent)  # fmt: skip
    solution = ns.simulate(system, (0, 1), [0, 0], [2.0, 0.0], integrator=STEP, on_failure="return")
    assert solution.status == ns.Status.NEGATIVE_FRICTION


# Bad input: one sentence with quantity, rule, value -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"q0": [1.0, 2.0]}, r"q0 must have 1 entries; got 2"),
        ({"u0": [math.nan]}, r"u0 must be finite; u0\[0\] is nan"),
        ({"q0": "high"}, r"q0 must be an array of numbers"),
        ({"t_span": (1.0, 0.0)}, r"t_span must not run backwards; got \(1, 0\)"),
        ({"t_span": (0.0, math.inf)}, r"t_span\[1\] must be finite"),
        ({"t_eval": [0.5, 0.2]}, r"t_eval must increase"),
        ({"every": 0}, r"every must be a whole number of at least 1; got 0"),
        ({"selection": "liftoff"}, r"did you mean 'lift-off'"),
        ({"on_failure": "ignore"}, r"on_failure must be 'raise' or 'return'"),
        ({"selection": None}, r"there is no selection rule None"),
        ({"q0": [[1.0]]}, r"q0 must be a vector; got shape \(1, 1\)"),
        ({"u0": [-math.inf]}, r"u0 must be finite; u0\[0\] is -inf"),
        ({"t_span": 1.0}, r"t_span must be a pair \(start, end\)"),
        ({"t_eval": [0.5, math.nan]}, r"t_eval must be finite; t_eval\[1\] is nan"),
        ({"every": 2.0}, r"every must be a whole number"),
        ({"max_wall_time": -1.0}, r"max_wall_time must be positive \[s\]; got -1"),
        ({"integrator": ns.MoreauJean}, r"an integrator, as ns.MoreauJean\(dt=1e-3\) is, or 'auto'; got"),
        ({"integrator": "MoreauJean"}, r"integrator must be an integrator.*got 'MoreauJean'"),
    ],
)
def test_bad_arguments_are_refused_in_one_sentence(change, message):
    arguments = {"t_span": (0, 1), "q0": [1.0], "u0": [0.0], "integrator": STEP, **change}
    with pytest.raises(ns.InvalidInput, match=message):
        ns.simulate(ball(), arguments.pop("t_span"), arguments.pop("q0"), arguments.pop("u0"), **arguments)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: ns.MoreauJean(dt=0.0), "dt must be positive .s.; got 0"),
        (lambda: ns.MoreauJean(dt=math.nan), "dt must be finite"),
        (lambda: ns.MoreauJean(dt=1e-3, theta=0.2), r"theta must lie in \[0.5, 1\]; got 0.2"),
        (lambda: BouncingBall(e=1.5).system(), r"e_N must lie in \[0, 1\]; got 1.5|e must lie in"),
        (lambda: SlidingBlock(mu=-0.1).system(), "mu must not be negative; got -0.1"),
        (lambda: ball(gap=None), "needs the function gap"),
        (lambda: ball(force=ball_mass), r"force must take \(t, q, u, p, out\)"),
        (
            lambda: rough_ball(mu="mue"),
            "the parameter 'mue', which does not exist",
        ),
        (lambda: ball().with_parameters(mm=1.0), "there is no parameter 'mm'"),
        (lambda: ball().with_parameters(m=math.nan), "the parameter m must be finite; got nan"),
        (lambda: ball().with_parameters(m="heavy"), "the parameter m must be a number; got 'heavy'"),
        (lambda: ball(mass=None), "needs the function mass; it was not given"),
        (lambda: ball(force=1.0), "force must be a function; got float"),
        (lambda: ball(contacts=ns.Contact(e_N=2.0)), r"e_N must lie in \[0, 1\]; got 2"),
        (lambda: ball(contacts=[ns.Contact(e_N=-0.1)]), r"e_N must lie in \[0, 1\]; got -0.1"),
        (lambda: ball(contacts=[ns.Contact(e_F=math.nan)]), "e_F must be finite; got nan"),
        (lambda: ball(contacts=[1.0]), r"contacts must be a list of Contact, one for each gap; got \[1.0\]"),
        (lambda: rough_ball(mu=math.nan), "mu must be finite; got nan"),
        (lambda: rough_ball(mu=-0.5), "mu must not be negative; got -0.5"),
        (
            lambda: rough_ball(mu=ns.Stribeck(0.5, 0.2, 0.0)),
            "v_s must be positive",
        ),
        (
            lambda: rough_ball(mu=ns.StaticKinetic(0.2, 0.3)),
            "mu_s - mu_k must not be",
        ),
        (lambda: ns.simulate(BouncingBall, (0, 1), [1], [0], integrator=STEP), "got the class BouncingBall: call it"),
        (lambda: ns.MoreauJean(dt=-1e-3), "dt must be positive .s.; got -0.001"),
        (lambda: ns.MoreauJean(dt=math.inf), "dt must be finite; got inf"),
        (lambda: ns.MoreauJean(dt=1e-3, projection="no"), "projection must be True or False; got 'no'"),
    ],
)
def test_bad_systems_are_refused_in_one_sentence(build, message):
    with pytest.raises(ns.InvalidInput, match=message):
        build()


def test_mass_matrix_that_is_not_positive_definite_is_refused_at_the_start():
    with pytest.raises(ns.InvalidInput, match="positive definite"):
        ns.simulate(ball().with_parameters(m=-1.0), (0, 1), [1.0], [0.0],
                    integrator=STEP)  # fmt: skip


# The initial state ----------------------------------------------------------------------------------------------------


def test_initial_penetration_is_reported_and_moved_out_on_request_only():
    with pytest.warns(ns.InitialStateWarning, match=r"contact 0 penetrates by 0\.1 m"):
        ns.simulate(ball(), (0, 0.01), [-0.1], [0.0], integrator=STEP)
    solution = ns.simulate(ball(), (0, 0.01), [-0.1], [0.0], integrator=STEP, project=True)
    assert abs(solution.q[0, 0]) < 1e-15


def test_inconsistent_velocity_of_a_bilateral_contact_is_moved_to_the_nearest_in_the_mass_metric():
    rod = SpragSlip()
    q0, u0 = rod.state(th=0.6, thdot=1.0)
    wrong = u0 + [0.3, 0.0]
    with pytest.warns(ns.InitialStateWarning, match="normal velocity"):
        ns.simulate(rod, (0, 1e-3), q0, wrong, integrator=STEP)
    solution = ns.simulate(rod, (0, 1e-3), q0, wrong, integrator=STEP, project=True)
    W = np.array([1.0, -rod.l * math.cos(0.6)])
    minv = np.array([1 / rod.m, 1 / rod.I])
    nearest = wrong - minv * W * (W @ wrong) / (W @ (minv * W))
    assert np.allclose(solution.u[0], nearest, rtol=1e-9)
