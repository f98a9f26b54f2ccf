"""Moreau–Jean against closed forms, with orders measured and invariants to rounding."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from models import BeadChain, BilateralRod, BouncingBall, InclinedBlock, PainleveRod, SlidingBlock, WallPendulum
from nonsmooth import ContactMode, EventKind

G = 9.81


def run(model, t_end, dt, state=None, **options):
    q0, u0 = model.state() if state is None else state
    return ns.simulate(model, (0.0, t_end), q0, u0, integrator=ns.MoreauJean(dt=dt), **options)


def fitted_order(errors, dts):
    return np.polyfit(np.log(dts), np.log(errors), 1)[0]


def test_ball_bounces_at_the_closed_form_times_within_one_step():
    dt = 1e-4
    ball = BouncingBall(e=0.5)
    solution = run(ball, 1.3, dt)
    impacts = [event.t for event in solution.events if event.kind == EventKind.IMPACT][:4]
    first = math.sqrt(2 / G)
    exact = [first * (1 + 2 * sum(0.5**k for k in range(1, n + 1))) for n in range(4)]
    # every impact is found in the step in which the mid-point gap closes, and shifts the later ones by as much
    assert np.allclose(impacts, exact, atol=4 * dt)


def test_ball_comes_to_rest_after_its_zeno_point():
    solution = run(BouncingBall(e=0.5), 2.0, 1e-3)
    at_rest = solution.t > 3 * math.sqrt(2 / G) + 0.05
    assert (solution.u[at_rest] == 0.0).all()
    assert np.abs(solution.q[at_rest]).max() < G * 1e-6  # a step of free fall from rest is g dt^2


def test_block_stops_where_its_kinetic_energy_is_spent():
    dt = 1e-4
    block = SlidingBlock(mu=0.3)
    solution = run(block, 1.0, dt, block.state(speed=2.0))
    distance = 2.0**2 / (2 * 0.3 * G)
    assert abs(solution.q[-1, 0] - distance) < 0.3 * G * dt**2  # exact but for the step in which it stops
    assert (solution.u[-1] == 0.0).all()


def test_block_that_has_stopped_never_creeps_on_a_level_plane_in_a_million_steps():
    solution = run(SlidingBlock(mu=0.3), 1000.0, 1e-3, every=1000)
    stopped = solution.t > 0.7
    assert np.ptp(solution.q[stopped, 0]) == 0.0


@pytest.mark.parametrize(("mu", "alpha"), [(1.0, 0.1), (1.0, 0.2), (1.0, 0.7), (0.3, math.atan(0.3 * 0.999))])
def test_block_stuck_on_an_oblique_plane_keeps_its_place_over_a_million_steps(mu, alpha):
    block = InclinedBlock(mu=mu, alpha=alpha)
    q0, u0 = block.state(slip=0.0, distance=0.3)
    solution = ns.simulate(block, (0, 1000.0), q0, u0, integrator=ns.MoreauJean(dt=1e-3), every=100_000)
    assert np.abs(solution.q - q0).max() <= np.spacing(1.0)  # one unit in the last place of the length scale


@pytest.mark.parametrize(("share", "moves"), [(0.999, False), (1.001, True)])
def test_block_holds_just_below_the_friction_limit_and_slides_just_above(share, moves):
    alpha = math.atan(0.3 * share)
    block = InclinedBlock(mu=0.3, alpha=alpha)
    solution = run(block, 1.0, 1e-3, block.state(slip=0.0))
    assert (np.abs(solution.q[-1] - solution.q[0]).max() > 0.0) == moves


def test_pendulum_in_smooth_motion_is_of_second_order():
    pendulum = WallPendulum(th_w=-1.5)  # the wall is out of reach
    q0, u0 = pendulum.state(th=1.0)
    reference = ns.simulate(pendulum, (0, 1.0), q0, u0, integrator=ns.MoreauJean(dt=1e-5)).q[-1, 0]
    dts = np.array([1e-2, 5e-3, 2.5e-3])
    errors = [
        abs(ns.simulate(pendulum, (0, 1.0), q0, u0, integrator=ns.MoreauJean(dt=dt)).q[-1, 0] - reference) for dt in dts
    ]
    assert 1.9 < fitted_order(errors, dts) < 2.1


def test_sliding_along_a_curve_is_of_second_order():
    rod = PainleveRod(mu=0.3, l=2.0, I=1 / 3)
    state = rod.state(th=math.pi / 3, thdot=0.0, slip=1.0)
    reference = run(rod, 0.05, 1e-6, state, every=1000).q[-1]
    dts = np.array([2.5e-3, 1.25e-3, 6.25e-4])
    errors = [np.abs(run(rod, 0.05, dt, state).q[-1] - reference).max() for dt in dts]
    assert fitted_order(errors, dts) > 1.6  # tends to 2 from below; rows at the mid-point alone would give 1


def test_impacts_are_of_first_order():
    reference = run(BouncingBall(e=0.5), 0.6, 1e-7, every=10**5).q[-1, 0]
    dts = np.geomspace(3e-3, 3e-5, 9)
    errors = [abs(run(BouncingBall(e=0.5), 0.6, dt).q[-1, 0] - reference) for dt in dts]
    assert 0.7 < fitted_order(errors, dts) < 1.4  # the phase of the impact in its step scatters the errors


@pytest.mark.parametrize("theta", [0.5, 0.75, 1.0])
def test_energy_ledger_closes_at_every_step_for_any_theta(theta):
    rod = PainleveRod(mu=0.3)
    q0, u0 = rod.state(th=0.87, thdot=0.0, slip=0.8)
    solution = ns.simulate(rod, (0, 0.2), q0, u0, integrator=ns.MoreauJean(dt=1e-3, theta=theta))
    ledger = solution.ledger
    work = sum(ledger[name] for name in ("force", "friction", "normal", "surface"))
    assert np.abs(ledger["kinetic"] - ledger["kinetic"][0] - work).max() < 1e-13 * ledger["kinetic"].max()


def test_bead_chain_keeps_its_momentum():
    solution = run(BeadChain(n=100), 1.0, 1e-3)  # the wave has not reached the wall
    assert abs(solution.u[-1].sum() - 1.0) < 1e-12


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")  # what is asked holds for it too
@pytest.mark.parametrize(("dt", "tolerance"), [(1e-3, 5e-3), (5e-5, 5e-4)])
def test_bead_chain_approaches_its_exact_energy(dt, tolerance):
    solution = run(BeadChain(), 2.0, dt, every=50)
    assert abs(solution.ledger["kinetic"][-1] / 0.0080414 - 1) < tolerance  # first order in dt


def stiff_beam(stiffness=None, damping=None):
    """Two masses, a stiff nonlinear spring and a dash-pot between them, on a soft spring."""

    def mass(t, q, p, M):
        M[0, 0] = 1.0
        M[1, 1] = 2.0

    def force(t, q, u, p, h):
        stretch, rate = q[1] - q[0], u[1] - u[0]
        tension = 1e4 * (stretch + stretch**3) + 50.0 * rate
        h[0] = tension - q[0]
        h[1] = -tension

    return ns.System(n_q=2, mass=mass, force=force, stiffness=stiffness, damping=damping)


def test_jacobians_that_are_given_and_computed_take_the_same_steps():
    def stiffness(t, q, u, p, K):
        k = 1e4 * (1 + 3 * (q[1] - q[0]) ** 2)
        K[0, 0] = k + 1.0
        K[1, 1] = k
        K[0, 1] = K[1, 0] = -k

    def damping(t, q, u, p, C):
        C[0, 0] = C[1, 1] = 50.0
        C[0, 1] = C[1, 0] = -50.0

    start, integrator = ([0.0, 0.1], [1.0, 0.0]), ns.MoreauJean(dt=1e-2, theta=0.6)
    given = ns.simulate(stiff_beam(stiffness, damping), (0, 1), *start, integrator=integrator)
    computed = ns.simulate(stiff_beam("differences"), (0, 1), *start, integrator=integrator)
    # forward differences have a relative error of about sqrt(eps), amplified over 100 steps by less than 1000
    assert np.allclose(given.q, computed.q, atol=1e-5) and np.abs(given.q).max() < 2.0


def test_implicit_step_is_stable_where_an_explicit_one_is_not():
    from models import SpragSlip

    rod = SpragSlip(kth=1e9, cth=0.0)
    q0, u0 = rod.state(th=0.6, thdot=0.0)
    solution = ns.simulate(rod, (0, 0.2), q0, u0, integrator=ns.MoreauJean(dt=1e-3, theta=1.0))
    assert abs(solution.q[-1, 1] - rod.th0) < 0.05


# Painlevé's rod -------------------------------------------------------------------------------------------------


def test_inconsistent_state_is_an_impact_without_collision_with_its_impulses():
    rod = PainleveRod(mu=2.0, l=2.0, I=1 / 3)
    solution = run(rod, 1e-3, 1e-3, rod.state(th=math.pi / 3, thdot=0.0, slip=-1.0))
    (paradox,) = solution.paradoxes
    assert paradox.kind == EventKind.INCONSISTENT
    assert paradox.n_solutions == 0
    assert np.allclose((paradox.P_N, paradox.P_F), (0.3327, 0.4407), atol=5e-5)
    # the velocities of the impulses spread over the step; the impact taken before it differs by O(dt |th'|)
    assert np.allclose(solution.u[1], (-0.5593, 0.3229, 0.6458), atol=1e-3)


@pytest.mark.parametrize(
    ("selection", "mode", "u"),
    [
        ("compliant-limit", ContactMode.OPEN, (-4.4641, 1.9902, 4.0000)),
        ("lift-off", ContactMode.OPEN, (-4.4641, 1.9902, 4.0000)),
        ("impact", ContactMode.STICK, (-4.0340, 2.3076, 4.6473)),
    ],
)
def test_indeterminate_state_goes_on_by_the_stated_rule(selection, mode, u):
    rod = PainleveRod(mu=2.0, l=2.0, I=1 / 3)
    solution = run(rod, 1e-3, 1e-3, rod.state(th=math.pi / 3, thdot=4.0, slip=-1.0), selection=selection)
    (paradox,) = solution.paradoxes
    assert paradox.kind == EventKind.INDETERMINATE
    assert paradox.n_solutions == 3
    assert set(paradox.alternatives) == {"free", "stick", "slide -"}
    assert paradox.mode_after == mode
    assert np.allclose(solution.u[1], u, atol=8e-3)  # printed for the frozen configuration, O(dt) apart


def test_ordinary_capture_into_sticking_is_no_paradox():
    solution = run(SlidingBlock(mu=0.3), 1.0, 1e-3)
    assert any(event.mode_after == ContactMode.STICK for event in solution.events)
    assert solution.paradoxes == []


@pytest.mark.parametrize(
    ("th", "thdot", "slip", "mu", "events"),
    [
        (50, 0.0, 0.8, 0.3, [0.112538799, 0.200072319]),  # T2: slip reversals
        (75, -0.5, -0.5, 1.0, [0.007552851, 0.587985263]),  # T4: capture, end of sticking
        (20, 6.0, -1.0, 0.3, [0.042777016]),  # T3: lift-off
    ],
)
def test_regular_motions_of_the_rod_change_mode_at_the_published_times(th, thdot, slip, mu, events):
    dt = 1e-5
    rod = PainleveRod(mu=mu)
    solution = run(rod, events[-1] + 0.01, dt, rod.state(th=math.radians(th), thdot=thdot, slip=slip), every=100)
    times = [event.t for event in solution.events]
    reached = [min(times, key=lambda t: abs(t - exact)) for exact in events]  # a reversal may stick for one step
    assert np.allclose(reached, events, atol=2 * dt)
    assert len(times) <= 2 * len(events)


def test_rod_of_t1_slips_left_to_the_end_at_the_published_time():
    dt = 1e-5
    rod = PainleveRod(mu=0.3)
    solution = run(rod, 0.362, dt, rod.state(th=math.radians(50), thdot=0.0, slip=-0.4), every=1)
    th = solution.q[:, 2]
    k = int(np.flatnonzero(th <= math.radians(2))[0])
    end = solution.t[k] - dt * (math.radians(2) - th[k]) / (th[k - 1] - th[k])
    assert abs(end - 0.361904031) < dt  # second order in dt, and the printed digits
    assert (solution.slip[1 : k + 1, 0] == -1).all() and solution.events == []


def test_bilateral_rod_changes_the_sign_of_its_normal_force_at_the_published_time():
    dt = 1e-5
    rod = BilateralRod(mu=0.3)
    solution = run(rod, 0.06, dt, rod.state(th=math.radians(20), thdot=6.0, slip=-1.0))
    P_N = solution.P_N[1:, 0]
    change = solution.t[1:][np.flatnonzero(np.diff(np.sign(P_N)))[0]]
    assert abs(change - 0.042777016) < 2 * dt


@pytest.mark.parametrize("theta", [0.5, 0.75, 1.0])
def test_positions_take_the_new_velocity_with_the_weight_theta(theta):
    """Free fall: u_n = -n g dt, so q_N = q_0 - g dt^2 (N (N - 1) / 2 + theta N)."""
    ball, dt, N = BouncingBall(g=10.0), 1e-3, 50
    solution = ns.simulate(ball, (0, N * dt), *ball.state(height=1.0), integrator=ns.MoreauJean(dt=dt, theta=theta))
    assert solution.q[-1, 0] == pytest.approx(1.0 - 10.0 * dt**2 * (N * (N - 1) / 2 + theta * N), rel=1e-14)
