"""Planar scenes against closed forms, invariants and measured orders."""

import subprocess
import sys

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall
from nonsmooth.commands.solve_files import solve_files
from nonsmooth.contact.blocks.natural_map import cone_project
from nonsmooth.integrators.assembly.progress import REBOUND, SOLVE, note_residual
from nonsmooth.jit import interpreted
from nonsmooth.runs.scene_run import SceneRun
from nonsmooth.scenes.places import rotate, turn_onto

G = 9.81
GRAVITY = (0.0, -G)
DT = 2e-3


def on_ground(material, *bodies, **ground):
    scene = ns.Scene(gravity=GRAVITY, material=material)
    scene.fixed(ns.HalfPlane((0, 1)), name="ground", **ground)
    for options in bodies:
        scene.body(**options)
    return scene


def simulate(scene, t_end, dt=DT, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)


def test_free_flight_is_the_parabola_to_rounding():
    scene = ns.Scene(gravity=GRAVITY)
    scene.body(ns.Box(0.2, 0.1), mass=2.0, position=(0, 1), velocity=(3, 4), spin=5, name="box")
    box = simulate(scene, 1.0)["box"]
    expected = np.stack([3 * box.t, 1 + 4 * box.t - 0.5 * G * box.t**2], axis=1)
    np.testing.assert_allclose(
        box.position, expected, atol=500 * 16 * np.finfo(float).eps
    )  # 500 steps of some roundings
    np.testing.assert_allclose(box.turn, 5 * box.t, rtol=1e-13)


def test_sliding_block_stops_where_its_energy_is_spent_and_stays():
    mu, v_0 = 0.3, 2.0
    scene = on_ground(
        ns.Material(mu=mu),
        {"shape": ns.Box(0.2, 0.1), "density": 1000, "position": (0, 0.05), "velocity": (v_0, 0), "name": "block"},
    )
    errors = []
    for dt in (4e-3, 1e-3):
        solution = simulate(scene, 1.0, dt)
        x = solution["block"].position[:, 0]
        errors.append(abs(x[-1] - v_0**2 / (2 * mu * G)))
        assert np.ptp(x[solution.t > 0.8]) == 0.0  # sticks: it does not creep
        assert np.ptp(x[solution.t > 0.7]) <= 1e-8 * G * dt**2  # what the residual of the step in which it stops leaves
    # the step in which it stops is shared by sliding and sticking: at most mu g dt^2 / 8
    assert errors[0] <= mu * G * 4e-3**2 / 8 * 1.01
    assert errors[1] <= mu * G * 1e-3**2 / 8 * 1.01


@pytest.mark.parametrize("share", [0.5, 0.99])
def test_block_below_its_friction_limit_does_not_move_at_all(share):
    mu = 0.5
    angle = np.arctan(share * mu)
    scene = ns.Scene(gravity=GRAVITY, material=ns.Material(mu=mu))
    scene.fixed(ns.HalfPlane((-np.sin(angle), np.cos(angle))))
    normal = np.array([-np.sin(angle), np.cos(angle)])
    scene.body(ns.Box(0.4, 0.2), density=1000, position=0.1 * normal, turn=angle, name="block")
    block = simulate(scene, 2.0)["block"]
    np.testing.assert_array_equal(block.position, np.tile(block.position[0], (len(block.t), 1)))
    np.testing.assert_array_equal(block.turn, block.turn[0])


def test_block_above_its_friction_limit_slides_with_the_acceleration_that_is_left():
    mu, angle = 0.2, 0.5
    scene = ns.Scene(gravity=GRAVITY, material=ns.Material(mu=mu))
    normal, down = np.array([-np.sin(angle), np.cos(angle)]), np.array([-np.cos(angle), -np.sin(angle)])
    scene.fixed(ns.HalfPlane(normal))
    scene.body(ns.Box(0.4, 0.1), density=1000, position=0.05 * normal, turn=angle, name="block")
    block = simulate(scene, 1.0)["block"]
    acceleration = G * (np.sin(angle) - mu * np.cos(angle))
    # constant forces: the mean of the velocities moves it exactly; the residual of the contact problem is 1e-8
    moved = (block.position[-1] - block.position[0]) @ down
    np.testing.assert_allclose(moved, 0.5 * acceleration, rtol=1e-7)


@pytest.mark.parametrize("e", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("dt", [1e-2, 1.1e-3, 1e-3])
def test_ball_rebounds_with_its_coefficient_and_never_goes_into_the_ground(e, dt):
    r, height = 0.1, 1.0
    scene = on_ground(
        ns.Material(mu=0.0, e=e), {"shape": ns.Disc(r), "density": 1000, "position": (0, r + height), "name": "ball"}
    )
    ball = simulate(scene, 1.2, dt)["ball"]
    y = ball.position[:, 1] - r
    assert y.min() >= -1e-15
    exact = BouncingBall(e=e)
    # an impact is felt at the end of its step: the first velocity is wrong by g dt, the time by dt
    first = np.argmax(ball.velocity[:, 1] > 0) if e > 0 else np.argmax(y < 1e-12) + 1
    v_1 = exact.impact_speed(height)
    assert abs(ball.t[first] - v_1 / G) <= 2 * dt
    assert ball.velocity[first, 1] == pytest.approx(e * v_1, abs=2 * G * dt)
    if dt < 5e-3:
        reference = np.array([exact.height(t, height) for t in ball.t])
        assert np.abs(y - reference).mean() <= 3 * dt  # first order: velocity times the error of the time


def test_two_discs_keep_momentum_and_part_with_their_coefficient():
    e = 0.7
    scene = ns.Scene(gravity=(0.0, 0.0), material=ns.Material(mu=0.3, e=e))
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0), velocity=(2, 0), spin=3, name="a")
    scene.body(ns.Disc(0.1), mass=3.0, position=(0.5, 0.05), velocity=(-1, 0), name="b")
    solution = simulate(scene, 0.5, 1e-3)
    a, b = solution["a"], solution["b"]
    momentum = a.velocity + 3 * b.velocity
    np.testing.assert_allclose(momentum, np.tile(momentum[0], (len(a.t), 1)), atol=1e-14)
    moment = 0.5 * 0.1**2 * a.spin + 3 * 0.5 * 0.1**2 * b.spin
    for body, mass in ((a, 1.0), (b, 3.0)):
        moment += mass * (body.position[:, 0] * body.velocity[:, 1] - body.position[:, 1] * body.velocity[:, 0])
    hit = int(np.argmax(np.abs(np.diff(a.velocity[:, 0])) > 0.1)) + 1
    normal = b.position[hit] - a.position[hit]
    normal /= np.linalg.norm(normal)
    before = (b.velocity[0] - a.velocity[0]) @ normal
    after = (b.velocity[-1] - a.velocity[-1]) @ normal
    assert after == pytest.approx(-e * before, abs=0.02)  # the normal turns by v dt / r within the step of the impact
    # each impulse acts at one point: the angular momentum changes by what the point moves in the step, x_1 against x_0
    np.testing.assert_allclose(moment, moment[0], atol=1e-12)


def test_rolling_disc_has_two_thirds_of_its_sliding_speed():
    mu, v_0, r = 0.3, 2.0, 0.1
    scene = on_ground(
        ns.Material(mu=mu),
        {"shape": ns.Disc(r), "density": 1000, "position": (0, r), "velocity": (v_0, 0), "name": "disc"},
    )
    disc = simulate(scene, 1.0, 1e-3)["disc"]
    assert disc.velocity[-1, 0] == pytest.approx(2 / 3 * v_0, rel=1e-12)
    assert disc.spin[-1] == pytest.approx(-disc.velocity[-1, 0] / r, rel=1e-12)
    rolls = disc.t[np.argmax(np.abs(disc.velocity[:, 0] + r * disc.spin) < 1e-9)]
    assert abs(rolls - v_0 / (3 * mu * G)) <= 1e-3


def test_conveyor_carries_a_parcel_to_its_speed():
    speed, mu = 1.5, 0.4
    scene = on_ground(
        ns.Material(mu=mu),
        {"shape": ns.Box(0.2, 0.2), "density": 500, "position": (0, 0.1), "name": "parcel"},
        surface_velocity=(speed, 0),
    )
    solution = simulate(scene, 1.0, 1e-3)
    parcel = solution["parcel"]
    np.testing.assert_allclose(parcel.velocity[:300, 0], mu * G * parcel.t[:300], atol=1e-9)
    np.testing.assert_allclose(parcel.velocity[-1], (speed, 0), atol=1e-12)
    # the belt does the work of friction and of the motion: in all m v^2, half of it lost by sliding
    m = 500 * 0.04
    assert solution.ledger["surface"][-1] == pytest.approx(m * speed**2, rel=5e-3)
    assert solution.ledger["friction"][-1] == pytest.approx(-0.5 * m * speed**2, rel=1e-2)


def test_guided_body_pushes_what_it_meets():
    scene = ns.Scene(gravity=(0.0, 0.0), material=ns.Material(mu=0.0))
    scene.kinematic(ns.Box(0.2, 0.2), motion=lambda t: (np.sin(t), 0.0), name="piston")
    scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(0.5, 0), name="slider")
    solution = simulate(scene, 1.5, 1e-3)
    piston, slider = solution["piston"], solution["slider"]
    np.testing.assert_allclose(piston.position[:, 0], np.sin(piston.t), atol=1e-13)
    assert (slider.position[:, 0] - piston.position[:, 0]).min() >= 0.2 - 1e-9
    # it is taken along at the speed of the piston when they meet, at sin t = 0.3, and flies on as the piston slows down
    assert slider.velocity[-1, 0] == pytest.approx(np.sqrt(1 - 0.3**2), rel=5e-3)


def tumbling(material):
    rng = np.random.default_rng(3)
    shapes = [ns.Disc(0.1), ns.Box(0.2, 0.1), ns.Capsule(0.2, 0.05), ns.Polygon([(0, 0), (0.2, 0), (0.1, 0.2)])]
    bodies = [
        {"shape": shape, "density": 800, "position": (0.1 * k, 0.5 + 0.3 * k), "turn": rng.uniform(0, 3)}
        for k, shape in enumerate(shapes)
    ]
    return on_ground(material, *bodies)


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")
def test_energy_ledger_closes_to_rounding_through_impacts():
    solution = simulate(tumbling(ns.Material(mu=0.4, e=0.3)), 1.5)
    ledger = solution.ledger
    works = sum(ledger[name] for name in ("force", "friction", "normal", "surface"))
    size = np.abs(ledger["force"]).max()
    np.testing.assert_allclose(ledger["kinetic"] - ledger["kinetic"][0], works, atol=1e-11 * size)
    moved = ledger["potential"][0] - ledger["potential"]
    np.testing.assert_allclose(moved, ledger["force"] + ledger["projection"], atol=1e-11 * size)


def test_contacts_without_restitution_lose_energy_but_for_what_gravity_adds_within_a_step():
    solution = simulate(tumbling(ns.Material(mu=0.4)), 1.5)
    loss = solution.ledger["friction"] + solution.ledger["normal"]
    # P . (gamma_0 + gamma_1)/2 = P . gamma_1 - P . W P / 2 - P . J dt g / 2: only the last can be positive
    P_N = np.array([solution.contacts(t).P_N.sum() for t in solution.t])
    assert (np.diff(loss) <= 0.5 * DT * G * P_N[1:] + 1e-12).all() and loss[-1] < -1.0


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")
def test_mirrored_scene_moves_as_its_mirror_image():
    def tumble(sign):
        scene = on_ground(ns.Material(mu=0.4, e=0.2))
        for k in range(4):
            scene.body(
                ns.Box(0.3, 0.1), density=800, position=(sign * 0.1 * k, 0.3 + 0.35 * k), turn=sign * (0.2 + k),
                velocity=(sign * 0.3, 0),
            )  # fmt: skip
        return simulate(scene, 0.4)

    right, left = tumble(1.0), tumble(-1.0)
    # chaotic after many impacts: roundings grow; to 0.4 s they have had three
    np.testing.assert_allclose(right.position * (-1, 1), left.position, atol=1e-9)
    np.testing.assert_allclose(right.turn, -left.turn, atol=1e-8)


def test_overlap_at_the_start_is_refused_by_name():
    scene = on_ground(ns.Material(), {"shape": ns.Disc(0.1), "mass": 1, "position": (0, 0.05), "name": "sunk"})
    with pytest.raises(ns.InvalidInput, match="ground and sunk overlap at the start by 0.05 m"):
        simulate(scene, 0.1)


def test_budget_and_interruption_keep_what_was_computed():
    scene = on_ground(ns.Material(), {"shape": ns.Disc(0.1), "mass": 1, "position": (0, 0.1)})
    solution = simulate(scene, 1.0, max_steps=10, on_failure="return")
    assert solution.status == ns.Status.BUDGET_SPENT and solution.t[-1] == pytest.approx(10 * DT)
    with pytest.raises(ns.BudgetSpent) as raised:
        simulate(scene, 1.0, max_steps=10)
    assert raised.value.solution.stats.steps == 10

    def stop(done):
        raise KeyboardInterrupt

    solution = simulate(scene, 1000.0, progress=stop)
    assert solution.status == ns.Status.INTERRUPTED and solution.t[-1] < 1000.0


def test_steps_at_rest_are_left_out_and_no_bit_changes():
    scene = on_ground(ns.Material(mu=0.5))
    for k in range(3):
        scene.body(ns.Box(0.2, 0.2), density=1000, position=(0.01 * k, 0.1 + 0.2 * k))
    awake, asleep = (
        ns.simulate(
            scene, (0, 4), integrator=ns.MoreauJean(dt=DT, contacts=ns.ContactSolver(may_sleep=may_sleep)), every=500
        )
        for may_sleep in (False, True)
    )
    assert asleep.stats.asleep > 1000 and awake.stats.asleep == 0
    assert asleep.stats.steps == awake.stats.steps
    for name in ("position", "turn", "velocity", "spin"):
        np.testing.assert_array_equal(getattr(asleep, name), getattr(awake, name))


def box_at_rest(motion=None):
    scene = on_ground(
        ns.Material(mu=0.5), {"shape": ns.Box(0.2, 0.2), "density": 1000, "position": (0, 0.1), "name": "box"}
    )
    if motion is not None:
        scene.kinematic(ns.Box(0.2, 0.2), motion=motion, name="ram")
    return scene


def test_steps_that_sleep_do_not_depend_on_how_the_run_is_cut():
    """A guided body that stands has its steps taken one by one: they are left out one by one."""
    cut, whole = (
        simulate(box_at_rest(motion), 2.0, every=every) for motion, every in ((lambda t: (-1.0, 0.5), 1), (None, 500))
    )
    assert cut.stats.asleep == whole.stats.asleep > 900
    assert cut.residual[-1] == whole.residual[-1]
    np.testing.assert_array_equal(cut["box"].position[-1], whole["box"].position[-1])


def test_what_sleeps_wakes_when_the_step_changes():
    """An impulse is a force times a step: that of a longer one is another."""
    whole = simulate(box_at_rest(), 2.0, t_eval=[0.0, 1.0, 1.0033, 2.0])
    assert 900 < whole.stats.asleep < whole.stats.steps - 4
    weight = 1000 * 0.2 * 0.2 * G
    for t, dt in ((1.0, DT), (1.0033, 0.0033 / 2)):
        assert abs(whole.contacts(t).P[:, 1].sum()) == pytest.approx(weight * dt, rel=1e-9)


def test_what_sleeps_wakes_when_it_is_pushed():
    scene = on_ground(
        ns.Material(mu=0.5), {"shape": ns.Box(0.2, 0.2), "density": 1000, "position": (0, 0.1), "name": "box"}
    )
    scene.kinematic(ns.Box(0.2, 0.2), motion=lambda t: (-0.4 + 0.3 * max(0.0, t - 1.0), 0.101), name="ram")
    solution = simulate(scene, 3.0)
    box, ram = solution["box"], solution["ram"]
    assert box.position[-1, 0] - ram.position[-1, 0] == pytest.approx(0.2, abs=1e-6)
    np.testing.assert_array_equal(box.position[solution.t < 1.5, 0], 0.0)


def test_thin_and_fast_bodies_that_come_through_a_wall_are_told():
    scene = ns.Scene(gravity=(0.0, 0.0))
    scene.fixed(ns.Box(0.4, 1.0), position=(1, 0))
    scene.kinematic(ns.Disc(0.05), velocity=(1.0, 0), name="ram")  # nothing stops what is told how to move
    with pytest.warns(ns.PenetrationWarning, match="smaller dt"):
        scene.body(ns.Disc(0.05), mass=1, position=(0.7, 0.0), name="between")
        simulate(scene, 0.8, 1e-3, on_failure="return")


def test_energy_that_newtons_law_makes_with_friction_is_told():
    """A slender rod that hits the ground with e = 0.9 and mu = 0.6 has more energy afterwards than before."""
    material, angle = ns.Material(mu=0.6, e=0.9), 0.75
    scene = ns.Scene(gravity=(0, 0), material=material)
    scene.fixed(ns.HalfPlane((0, 1)))
    height = 0.5 * np.sin(angle) + 0.02
    scene.body(ns.Capsule(1.0, 0.01), mass=1, position=(0, height), turn=angle, velocity=(0.41, -1), spin=2.45)
    with pytest.warns(ns.EnergyGainWarning, match="gained energy in 1 impacts"):
        solution = simulate(scene, 0.1, 1e-4)
    kinetic = solution.ledger["kinetic"]
    assert (
        solution.stats.worst_energy_gain == pytest.approx(kinetic[-1] - kinetic[0], rel=1e-6)
        and kinetic[-1] > kinetic[0]
    )


@pytest.mark.upkeep
def test_planar_scene_loads_nothing_of_space():
    program = """
import nonsmooth as ns
from nonsmooth.contact.network.solve import solve_network
from nonsmooth.integrators.assembly.stages import take_steps
from nonsmooth.scenes.spatial.find_contacts import find_contacts
scene = ns.Scene(gravity=(0, -9.81))
scene.body(ns.Disc(0.1), mass=1.0)
ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))
print(take_steps[2].is_loaded, [k.is_loaded for k in (take_steps[3], solve_network[3], find_contacts)])
"""
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.split("\n")[0] == "True [False, False, False]"


def test_work_of_a_belt_under_a_body_that_stands_is_booked_at_every_step():
    """A block leans on a wall while the belt runs below it: nothing moves, and mu m g v is lost all the time."""
    mu, speed, m, t_end = 0.3, 1.0, 20.0, 2.0
    scene = on_ground(
        ns.Material(mu=mu), {"shape": ns.Box(0.2, 0.2), "mass": m, "position": (0, 0.1), "name": "block"},
        surface_velocity=(speed, 0),
    )  # fmt: skip
    scene.fixed(ns.Box(0.2, 0.2), position=(0.2, 0.1), material=ns.Material(mu=0.0), name="wall")
    solution = simulate(scene, t_end, every=100)
    assert solution.stats.asleep == 0 and np.abs(solution["block"].position[-1] - (0, 0.1)).max() < 1e-12
    assert solution.ledger["surface"][-1] == pytest.approx(mu * m * G * speed * t_end, rel=1e-6)


def heap_that_is_not_solved(monkeypatch, act):
    monkeypatch.setattr("nonsmooth.integrators.assembly.step.rescue", act)
    scene = on_ground(ns.Material(mu=0.5))
    for k in range(60):
        scene.body(ns.Disc(0.1), density=1000, position=(0.21 * (k % 6) + 0.05 * (k // 6 % 2), 0.11 + 0.2 * (k // 6)))
    integrator = ns.MoreauJean(dt=DT, contacts=ns.ContactSolver(tol=1e-15, sweeps=1))
    return scene, integrator


def test_run_that_is_cut_short_within_a_step_ends_at_the_end_of_a_step(monkeypatch):
    def interrupt(network, solver, tol):
        if interrupt.left == 0:
            raise KeyboardInterrupt
        interrupt.left -= 1

    interrupt.left = 7
    scene, integrator = heap_that_is_not_solved(monkeypatch, interrupt)
    cut = ns.simulate(scene, (0, 1), integrator=integrator, every=100)
    assert cut.status == ns.Status.INTERRUPTED
    assert cut.t[-1] == pytest.approx(cut.stats.steps * DT) and 0 < cut.stats.steps < 100
    monkeypatch.setattr("nonsmooth.integrators.assembly.step.rescue", lambda network, solver, tol: None)
    with pytest.warns(ns.ResidualWarning):
        whole = ns.simulate(scene, (0, cut.t[-1]), integrator=integrator)
    np.testing.assert_array_equal(cut.position[-1], whole.position[-1])


@pytest.mark.parametrize("name", ["step.npz", "step.hdf5"])
def test_the_problem_that_a_step_was_not_solved_to_is_written_and_solved_from_its_file(monkeypatch, tmp_path, name):
    """Its impulses have the residual that ended the run; another solver finds a solution of what the file has."""
    pytest.importorskip("h5py")
    scene, _ = heap_that_is_not_solved(monkeypatch, lambda network, solver, tol: None)
    monkeypatch.setattr("nonsmooth.integrators.assembly.step.MOST_FACTORS", 0)
    strict = ns.ContactSolver(tol=1e-6, sweeps=3, on_residual="raise")
    with pytest.raises(ns.StepFailure, match="was solved to a residual of") as failure:
        ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=DT, contacts=strict))
    problem = failure.value.problem.problem
    rho = problem.dim / problem.G.diagonal().reshape(-1, problem.dim).sum(axis=1)
    gamma, P = ((x).reshape(-1, 2) for x in (problem.G @ problem.P + problem.c, problem.P))
    shifted = gamma[:, 0] + problem.mu * np.abs(gamma[:, 1])
    z = np.stack((P[:, 0] - rho * shifted, P[:, 1] - rho * gamma[:, 1]), axis=1)
    projected = np.array([interpreted(cone_project)(mu, *row, 0.0)[:2] for mu, row in zip(problem.mu, z, strict=True)])
    residual = failure.value.solution.stats.last_residual * np.linalg.norm(failure.value.solution.contacts().P)
    assert residual > 1e-6 and np.linalg.norm(P - projected) == pytest.approx(residual, rel=1e-3)
    path = failure.value.dump(tmp_path / name)
    (row,) = solve_files([path], tol=1e-6)
    assert row["status"] == "SOLVED" and row["contacts"] == len(problem.mu), row


def test_residual_of_a_rebound_counts_as_that_of_a_step(monkeypatch):
    """The stages judge a landing to be solved, and the impact behind it not."""
    scene = on_ground(ns.Material(mu=0.0, e=0.5), {"shape": ns.Disc(0.1), "mass": 1, "position": (0, 0.11)})
    run = SceneRun(scene, (0, 0.1), ns.MoreauJean(dt=DT), 1, None)
    progress, network, asleep = run.assembly.progress, run.assembly.network, run.assembly.asleep
    islands, network.tol = network.islands, 1e-8
    islands.count, islands.residual[0], progress.stage = 1, 1e-12, SOLVE
    interpreted(note_residual)(1e-12, network, asleep, progress, 2)
    assert progress.is_missed == 0 and progress.figures.residual == 1e-12
    progress.stage, islands.residual[0] = REBOUND, 1e-3
    interpreted(note_residual)(1e-3, network, asleep, progress, 2)
    assert progress.is_missed == 1
    assert progress.figures.residual == progress.figures.since_residual == progress.figures.last_residual == 1e-3


@pytest.mark.parametrize("normal", [(0, 0, -1), (0, 0, 1), (1e-9, 0, -1), (1e-4, -1e-5, -1), (0.3, -0.4, 0.5)])
def test_ground_has_the_normal_that_was_given_to_rounding(normal):
    ground = ns.HalfSpace(normal)
    np.testing.assert_allclose(rotate(turn_onto(ground.normal), np.array([0, 0, 1.0])), ground.normal, atol=1e-15)
