"""Compliant contact with friction in two directions: slides that turn, stop and start, and the stiff limit."""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from models import BilliardBall, PainleveRod, SpatialPainleveRod, SpinningTop
from nonsmooth import ContactMode

G = 9.81
STIFF = 1e8


@dataclass(frozen=True)
class Slope:
    """A mass on a plane that pulls it along x, heavier along y; its motions are coupled by ``m_12``."""

    pull: float = 0.0
    m_12: float = 0.0
    m_2: float = 1.0
    belt: float = 0.0

    def system(self, mu):
        def mass(t, q, p, M):
            M[0, 0], M[1, 1], M[2, 2] = 1.0, p.m_2, 1.0
            M[0, 1], M[1, 0] = p.m_12, p.m_12

        def force(t, q, u, p, h):
            h[0], h[2] = p.pull, -9.81

        def gap(t, q, p, g_N):
            g_N[0] = q[2]

        def normal(t, q, p, W_N):
            W_N[0, 2] = 1.0

        def tangent(t, q, p, W_F):
            W_F[0, 0, 0], W_F[0, 1, 1] = 1.0, 1.0

        def surface_velocity(t, q, p, w):
            w[0, 0] = -p.belt

        return ns.System(
            n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, surface_velocity=surface_velocity,
            contacts=[ns.Contact(mu=mu, directions=2)], parameters=self,
        )  # fmt: skip


def run(system, t_end, velocity, **options):
    """A run that begins at the depth of rest."""
    return ns.simulate(
        system, (0.0, t_end), np.array([0.0, 0.0, -G / STIFF]), np.array([*velocity, 0.0]),
        integrator=ns.Penalty(STIFF, damping_ratio=0.5, **options),
    )  # fmt: skip


def stop_of(solution):
    """When the contact began to stick [s]."""
    return next(event.t for event in solution.events if event.mode_after == ContactMode.STICK)


@pytest.mark.parametrize(("speed", "angle"), [(1.0, 0.3), (2.0, 1.2), (0.5, 2.9)])
def test_a_slide_on_a_slope_turns_and_stops_when_its_closed_form_does(speed, angle):
    """v' = a cos psi - f and v psi' = -a sin psi with a the pull and f = mu g: T = v (f + a cos psi)/(f^2 - a^2)."""
    mu, pull = 0.3, 2.0
    solution = run(Slope(pull).system(mu), 20.0, (speed * math.cos(angle), speed * math.sin(angle)))
    expected = speed * (mu * G + pull * math.cos(angle)) / ((mu * G) ** 2 - pull**2)
    assert abs(stop_of(solution) - expected) < 1e-7 * expected
    assert (solution.u[-1] == 0).all()
    assert np.hypot(*solution.la[-1, 0, 1:]) == pytest.approx(pull, rel=1e-8)


@pytest.mark.parametrize("m_12", [0.0, 0.8])
def test_the_way_of_a_slide_is_that_of_another_integration(m_12):
    mu, slope = 0.3, Slope(2.0, m_12, 4.0)
    solution = run(slope.system(mu), 20.0, (1.0, 1.5))
    inverse = np.linalg.inv([[1.0, m_12], [m_12, 4.0]])

    def rates(t, y):
        return np.r_[y[2:], inverse @ (np.array([2.0, 0.0]) - mu * G * y[2:] / np.linalg.norm(y[2:]))]

    def speed(t, y):
        return np.linalg.norm(y[2:]) - 1e-8

    speed.terminal = True
    other = solve_ivp(rates, (0, 20), [0, 0, 1.0, 1.5], method="DOP853", events=speed, rtol=1e-12, atol=1e-14)
    assert other.status == 1
    assert abs(solution.q[-1, :2] - other.y[:2, -1]).max() < 1e-8  # the tolerance, of metres; and (1e-8)^2/(2 mu g)


def test_what_cannot_hold_moves_off_in_the_direction_of_its_acceleration():
    """M a = pull - mu la_N a/|a|: of coupled masses another direction than that of the force which would hold."""
    mu, slope = 0.3, Slope(4.0, 0.8, 4.0)
    solution = run(slope.system(mu), 1.0, (0.0, 0.0))
    a = solution.u[-1, :2]
    M = np.array([[1.0, 0.8], [0.8, 4.0]])
    assert abs(M @ a - [4.0, 0.0] + mu * G * a / np.linalg.norm(a)).max() < 1e-6
    assert np.cross([*solution.q[-1, :2], 0], [*a, 0])[2] == pytest.approx(0, abs=1e-7)


def test_a_belt_carries_along_what_is_thrown_across_it():
    """Relative to the belt the slide is straight: it stops after |v - w|/(mu g), and then goes with the belt."""
    mu, belt = 0.4, 1.5
    solution = run(Slope(belt=belt).system(mu), 1.0, (0.0, 1.0))
    assert abs(stop_of(solution) - math.hypot(belt, 1.0) / (mu * G)) < 1e-8
    assert abs(solution.u[-1, :2] - [belt, 0.0]).max() < 1e-9
    ledger = solution.ledger
    works = ledger["force"] + ledger["friction"] + ledger["normal"] + ledger["surface"]
    assert abs(ledger["kinetic"] - ledger["kinetic"][0] - works).max() < 1e-7
    assert ledger["friction"][-1] == pytest.approx(-0.5 * (belt**2 + 1.0), abs=1e-7)


def test_regularised_friction_pulls_against_the_slide():
    solution = run(Slope(2.0).system(0.3), 0.3, (1.0, 1.5), friction=ns.Regularised(1e-3))
    sliding, force = solution.u[:, :2], solution.la[:, 0, 1:]
    size = 0.3 * solution.la[:, 0, 0] * np.tanh(np.hypot(*sliding.T) / 1e-3)
    expected = -size[:, None] * sliding / np.hypot(*sliding.T)[:, None]
    assert abs(force - expected).max() < 1e-9


def test_the_rod_in_its_own_plane_moves_as_the_rod_of_the_plane():
    integrator, t_end = ns.Penalty(1e6, damping_ratio=0.3, rtol=1e-9, atol=1e-11), 0.3
    plane, space = PainleveRod(mu=0.4), SpatialPainleveRod(mu=0.4)
    flat = ns.simulate(plane, (0, t_end), *plane.state(th=1.0, thdot=0.5, slip=-1.0), integrator=integrator)
    whole = ns.simulate(space, (0, t_end), *space.state(th=1.0, phi=0.0, thdot=0.5, slip=1.0), integrator=integrator)
    way = [whole.q[-1, [0, 2, 3]] - whole.q[0, [0, 2, 3]], flat.q[-1] - flat.q[0]]
    assert abs(way[0] - way[1]).max() < 1e-8
    assert abs(whole.u[-1, [0, 2, 3]] - flat.u[-1]).max() < 1e-7
    assert not whole.q[:, [1, 4]].any()


@pytest.mark.parametrize("phi", [0.0, 0.4])
def test_without_a_solution_the_limit_is_the_energetic_impact_without_loss(phi):
    """The force of an inconsistent state grows as exp(sqrt(-p k) t) to what stops the slide, which takes ln k times the
    period: errors go with k^(-1/2) ln k (docs/penalty.md), that is by 7.4 to 8.3 for each factor 100 of k here."""
    rod, state = SpatialPainleveRod(mu=2.0), {"th": 1.0, "phi": phi, "slip": 1.0}
    limit = rod.impact_without_collision(**state, e=1.0, law="energetic").u
    errors = []
    for k in (1e8, 1e10, 1e12):
        integrator = ns.Penalty(k, rtol=1e-10, atol=1e-12)
        sol = ns.simulate(rod, (0, 30 / math.sqrt(k)), *rod.state(**state), integrator=integrator)
        end = next(event.t for event in sol.events if event.mode_after == ContactMode.OPEN)
        errors.append(np.abs(sol.u[np.searchsorted(sol.t, end)] - limit).max())
    ratios = np.array(errors[:-1]) / errors[1:]
    ks = np.array([1e8, 1e10, 1e12])
    sizes = np.log(ks) / np.sqrt(ks)
    assert abs(ratios / (sizes[:-1] / sizes[1:]) - 1).max() < 0.15 and errors[-1] < 3e-4


@pytest.mark.parametrize(("depth", "leaves"), [(0.9, True), (1.1, False)])
@pytest.mark.parametrize("phi", [0.0, 0.3])
def test_of_two_answers_the_depth_decides(phi, depth, leaves):
    """p < 0 < b: the forces 0 and -b/p fit. The second is a saddle of the springs, at the depth -b/(p k): from above it
    the tip lifts off, from below it seizes."""
    rod = SpatialPainleveRod(mu=2.0)
    state = {"th": 1.0, "phi": phi, "psidot": 12.0, "slip": 1.0}
    p, b, k = rod.p(1.0, phi), rod.b(1.0, 0.0, 12.0), 1e8
    assert p < 0 < b
    q, u = rod.state(**state)
    q[2] += depth * b / (p * k)
    sol = ns.simulate(rod, (0, 30 / math.sqrt(k)), q, u, integrator=ns.Penalty(k))
    brief = 10 * abs(b / p) / math.sqrt(-p * k)  # the force of the saddle, for ten of its times
    assert (sol.P_N.sum() < brief) == leaves
    assert (ContactMode.STICK not in [event.mode_after for event in sol.events]) == leaves


def test_a_study_of_a_slide_in_space_has_the_order_of_the_plane():
    """With its own reference, which keeps 1e-9: errors of the coordinates fall as 1/k."""
    rod = SpatialPainleveRod(mu=0.4)
    study = ns.penalty_study(rod, (0, 0.1), *rod.state(th=1.0, phi=0.5, slip=1.0), stiffness=[1e5, 1e6, 1e7])
    errors = study.data.error_q.values[:, 0]
    assert abs(np.log10(errors[:-1] / errors[1:]) - 1).max() < 0.1


def test_two_feet_that_stick_share_what_holds_them():
    """Two contacts of one body whose four rows have two velocities: the loads are the least ones, half each."""

    def mass(t, q, p, M):
        for i in range(3):
            M[i, i] = 1.0

    def force(t, q, u, p, h):
        h[0], h[1], h[2] = 1.0, 0.5, -9.81

    def gap(t, q, p, g_N):
        g_N[0], g_N[1] = q[2], q[2]

    def normal(t, q, p, W_N):
        W_N[0, 2], W_N[1, 2] = 1.0, 1.0

    def tangent(t, q, p, W_F):
        for i in range(2):
            W_F[i, 0, 0], W_F[i, 1, 1] = 1.0, 1.0

    feet = [ns.Contact(mu=0.4, directions=2), ns.Contact(mu=0.4, directions=2)]
    system = ns.System(n_q=3, mass=mass, force=force, gap=gap, normal=normal, tangent=tangent, contacts=feet)
    start = np.array([0.0, 0.0, -G / (2 * STIFF)])
    sol = ns.simulate(system, (0, 0.1), start, np.zeros(3), integrator=ns.Penalty(STIFF, damping_ratio=0.5))
    assert (sol.mode[-1] == ContactMode.STICK).all()
    assert abs(sol.la[-1, :, 1:].sum(axis=0) + [1.0, 0.5]).max() < 1e-14 and not sol.u[:, :2].any()
    assert abs(sol.la[-1, :, 1:] + [0.5, 0.25]).max() < 1e-9  # REGULARISATION of the trace, 4 1/kg


@pytest.mark.parametrize("model, t_end", [(BilliardBall(), 0.3), (SpinningTop(), 0.1)])
def test_bodies_that_turn_go_as_rigid_ones_the_better_the_stiffer_their_contact(model, t_end):
    """A slide of bodies with q' = B u: the end errs by 1/k, as the indentation m g/k does."""
    q, u = model.state()
    rigid = ns.simulate(model, (0, t_end), q, u, integrator=ns.EventDriven(1e-11, 1e-13)).q[-1]
    soft = ns.Penalty(1e5, damping_ratio=0.7, rtol=1e-9, atol=1e-11)
    errors = [
        np.abs(ns.simulate(model, (0, t_end), q, u, integrator=by).q[-1] - rigid).max()
        for by in (soft, dataclasses.replace(soft, stiffness=1e7))
    ]
    assert errors[0] < 2e-4 and errors[1] == pytest.approx(errors[0] / 100, rel=0.1)


def test_a_ball_that_turns_rests_at_the_depth_of_its_weight():
    ball = BilliardBall()
    sol = ns.simulate(ball, (0, 0.5), *ball.state(), integrator=ns.Penalty(1e6, damping_ratio=0.7))
    assert -sol.g_N[-1, 0] == pytest.approx(ball.m * 9.81 / 1e6, rel=1e-8)
    assert sol.events[-1].mode_after == ContactMode.STICK
    assert sol.events[-1].t == pytest.approx(ball.rolling_time(ball.state()[1]), rel=1e-6)
