"""Islands that sleep one by one: what is left out changes no bit, and what comes near, pushes or carries wakes it.

Bits of whole scenes are compared where the bodies that are awake are solved without factors kept from step to step,
which all islands of a scene forget together; of what sleeps, they are compared always.
"""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.runs.scene_run import SceneRun

G = 9.81
DT = 2e-3

# steps in which a ball breaks a pyramid miss the tolerance, asleep before or not
pytestmark = pytest.mark.filterwarnings("ignore:in .* steps the contact problem was solved to less than tol")


def simulate(scene, t_end, may_sleep=True, **options):
    contacts = ns.ContactSolver(may_sleep=may_sleep)
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=DT, contacts=contacts), **options)


def pair_of_runs(make, t_end, **options):
    """Of the same scene, islands asleep and all awake."""
    return simulate(make(), t_end, True, **options), simulate(make(), t_end, False, **options)


def planar(e=0.0, tilt=0.0, mu=0.5):
    scene = ns.Scene(gravity=(G * np.sin(tilt), -G * np.cos(tilt)), material=ns.Material(mu=mu, e=e))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    return scene


def pile_boxes(scene, rows, x=0.0, name="box"):
    for r in range(rows):
        for k in range(rows - r):
            scene.body(
                ns.Box(0.2, 0.2),
                density=1000,
                position=(x + 0.22 * k + 0.11 * r, 0.1 + 0.2 * r),
                name=f"{name} {r} {k}",
            )


def roll_ball(scene, x=-6.0, speed=2.0):
    scene.body(ns.Disc(0.1), density=1000, position=(x, 0.1), velocity=(speed, 0), spin=-speed / 0.1, name="ball")


def pyramid_and_ball(speed=2.0):
    scene = planar()
    pile_boxes(scene, 5)
    roll_ball(scene, speed=speed)
    return scene


def require_same_bits(one, other):
    for name in ("position", "turn", "velocity", "spin", "penetration"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    for name in one.ledger:
        np.testing.assert_array_equal(one.ledger[name], other.ledger[name], err_msg=name)
    for name, column in one.all_contacts.columns.items():
        np.testing.assert_array_equal(column, getattr(other.all_contacts, name), err_msg=name)
    np.testing.assert_allclose(one.residual, other.residual, rtol=1e-12, atol=1e-18)  # the same sums in another order


def test_a_pyramid_sleeps_while_a_ball_rolls_elsewhere_and_no_bit_changes():
    asleep, awake = pair_of_runs(pyramid_and_ball, 2.0, every=10)
    assert asleep.stats.islands_asleep >= asleep.stats.steps - 4 and asleep.stats.asleep == 0
    assert awake.stats.islands_asleep == 0
    require_same_bits(asleep, awake)
    for name in ("contacts", "most_contacts", "islands", "methods", "worst_penetration"):
        assert getattr(asleep.stats, name) == getattr(awake.stats, name)


def test_what_sleeps_is_not_looked_for_written_or_solved():
    run = SceneRun(pyramid_and_ball(), (0, 1), ns.MoreauJean(dt=DT), 1, None)
    run.assembly.take_steps(DT, 20)
    assembly = run.assembly
    assert assembly.n_islands == 2 and assembly.network.islands.count == 1  # that of the ball
    assert assembly.network.n_c == 1 and assembly.scratch.grid.n_pairs == 1
    assert assembly.n_contacts == len(assembly.contact_rows().i) > 30


def test_a_wall_asleep_that_a_ball_hits_later_falls_as_if_it_had_been_awake():
    asleep, awake = pair_of_runs(lambda: pyramid_and_ball(speed=4.0), 2.5, every=5)
    hit = np.argmax(np.abs(asleep.velocity[:, 1:-1]).max(axis=(1, 2)) > 1e-3)
    assert 1.3 < asleep.t[hit] < 1.6  # it rolls 5.8 m at 4 m/s
    assert asleep.stats.islands_asleep > 600
    require_same_bits(asleep, awake)


@pytest.mark.filterwarnings("ignore::nonsmooth.SimultaneousImpactWarning")
def test_a_wall_asleep_is_hit_by_a_ball_in_free_flight_beside_a_ball_that_bounces():
    """Impacts elsewhere are a second problem in their steps, which no island asleep has a part in."""

    def make():
        scene = planar(e=0.5)
        pile_boxes(scene, 4)
        scene.body(ns.Disc(0.1), density=1000, position=(4.0, 1.0), name="bouncing")
        scene.body(ns.Disc(0.1), density=1000, position=(-3.0, 0.6), velocity=(5.0, 2.0), name="thrown")
        return scene

    asleep, awake = pair_of_runs(make, 0.6)
    assert asleep.stats.islands_asleep > 200 and asleep.stats.impacts == awake.stats.impacts > 1
    require_same_bits(asleep, awake)


def test_a_stack_on_a_slope_sleeps_and_its_impulses_do_not_drift():
    """Normals that are no axes: impulses kept from step to step are those along them, with the same bits."""

    def make():
        scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=0.5))
        turn = 0.3
        scene.fixed(ns.Box(6.0, 0.2), turn=turn, name="slope")
        n, t = np.array((-np.sin(turn), np.cos(turn))), np.array((np.cos(turn), np.sin(turn)))
        for k in range(3):
            scene.body(ns.Box(0.2, 0.2), density=1000, position=(0.2 + 0.2 * k) * n, turn=turn, name=f"box {k}")
        scene.body(ns.Disc(0.1), density=1000, position=-2.9 * t + 3.0 * n, velocity=(0.0, 3.0), name="thrown")
        return scene

    asleep, awake = pair_of_runs(make, 1.0)
    assert asleep.stats.islands_asleep > 350
    require_same_bits(asleep, awake)
    boxes = asleep.position[:, 1:4]
    assert np.ptp(boxes[asleep.t > 0.2], axis=0).max() == 0.0


def test_a_parcel_on_a_belt_never_sleeps_while_a_stack_beside_it_does():
    """All numbers are powers of two: the parcel is solved by the impulses of the step before to the last bit."""
    mu, speed, m = 0.25, 1.0, 16.0
    scene = ns.Scene(gravity=(0, -G), material=ns.Material(mu=mu))
    scene.fixed(ns.Box(4.0, 0.25), position=(0, -0.125), surface_velocity=(speed, 0), name="belt")
    scene.fixed(ns.Box(0.25, 0.25), position=(0.25, 0.125), material=ns.Material(mu=0.0), name="stop")
    scene.body(ns.Box(0.25, 0.25), mass=m, position=(0, 0.125), name="held")
    scene.fixed(ns.Box(1.0, 0.2), position=(5, -0.1), name="table")
    for k in range(3):
        scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(5, 0.1 + 0.2 * k), name=f"box {k}")
    solution = simulate(scene, 1.0, every=50)
    # the stack alone: one island a step
    assert solution.stats.steps - 10 < solution.stats.islands_asleep < solution.stats.steps
    assert solution.ledger["surface"][-1] == pytest.approx(mu * m * G * speed * 1.0, rel=1e-6)


def test_a_stack_asleep_wakes_when_what_carries_it_moves_and_when_a_ram_comes():
    def make():
        scene = planar()
        scene.kinematic(ns.Box(1.0, 0.1), motion=lambda t: (4.0, 0.2 + 0.2 * max(0.0, t - 0.3)), name="lift")
        scene.body(ns.Box(0.2, 0.2), density=1000, position=(4.0, 0.35), name="lifted")
        pile_boxes(scene, 2, x=-2.0)
        scene.kinematic(ns.Box(0.2, 0.2), motion=lambda t: (-4.0 + 4.0 * max(0.0, t - 0.2), 0.15), name="ram")
        return scene

    asleep, awake = pair_of_runs(make, 1.0)
    lifted = asleep["lifted"]
    assert np.ptp(lifted.position[asleep.t < 0.299, 1]) == 0.0
    assert lifted.position[-1, 1] == pytest.approx(0.35 + 0.2 * 0.7, abs=1e-9)
    assert asleep["box 0 0"].position[-1, 0] > -1.8
    assert 250 < asleep.stats.islands_asleep < 800
    np.testing.assert_allclose(asleep.position, awake.position, atol=1e-9)


def test_what_sleeps_beside_a_moving_ball_wakes_when_the_step_changes():
    """An impulse is a force times a step."""
    times = [0.0, 0.5, 0.5033, 1.0]
    asleep, awake = pair_of_runs(pyramid_and_ball, 1.0, t_eval=times)
    weight = 15 * 1000 * 0.04 * G + 1000 * np.pi * 0.01 * G
    for t, dt in ((0.5, DT), (0.5033, 0.0033 / 2)):
        load = np.abs(asleep.contacts(t).of("ground").P[:, 1].sum())
        assert load == pytest.approx(weight * dt, rel=1e-9)
    assert asleep.stats.islands_asleep > 480
    assert np.abs(asleep.position - awake.position).max() <= 1e-13


def test_an_island_asleep_has_no_events():
    asleep, awake = pair_of_runs(lambda: pyramid_and_ball(speed=4.0), 2.0, record=("bodies", "events"))
    assert asleep.stats.islands_asleep > 600
    for name in ("t", "kind", "i", "j", "P_N"):
        np.testing.assert_array_equal(getattr(asleep.events, name), getattr(awake.events, name))
    assert len(asleep.events.t) > 0 and asleep.events.t.min() > 1.3


def test_islands_asleep_are_found_again_by_a_run_that_goes_on(tmp_path):
    path = tmp_path / "run.nsc"
    whole = simulate(pyramid_and_ball(speed=4.0), 2.0, every=7)
    stops, again = 0, dict(checkpoint=path, resume=path, on_failure="return")
    while not (
        cut := simulate(pyramid_and_ball(speed=4.0), 2.0, every=7, **again, max_steps=137 * (stops + 1))
    ).success:
        stops += 1
    assert stops == 7 and cut.stats.islands_asleep == whole.stats.islands_asleep > 600
    require_same_bits(cut, whole)


def spatial_stacks_and_ball():
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="floor")
    for stack, (x, turn) in enumerate(((0.0, (1, 0, 0, 0)), (3.0, (np.cos(0.2), 0, 0, np.sin(0.2))))):
        for k in range(3):
            position = (x, 0, 0.1 + 0.2 * k)
            scene.body(ns.Box(0.3, 0.2, 0.2), density=1000, position=position, turn=turn, name=f"box {stack} {k}")
    scene.body(ns.Sphere(0.1), density=3000, position=(-2, 0.02, 0.1), velocity=(4, 0, 0), spin=(0, 40, 0), name="ball")
    return scene


def test_stacks_in_space_sleep_one_by_one_until_they_are_hit():
    asleep, awake = pair_of_runs(spatial_stacks_and_ball, 0.6, every=3)
    moved = np.abs(asleep.velocity).max(axis=2) > 1e-3
    names = [body.name for body in asleep.scene.bodies]
    assert moved[:, names.index("box 0 0")].any() and not moved[:, names.index("box 1 0")].any()
    assert 2 * 225 < 225 + asleep.stats.islands_asleep  # both until the hit at 0.46 s, one afterwards
    boxes = [k for k, name in enumerate(names) if name.startswith("box 1")]
    np.testing.assert_array_equal(asleep.position[:, boxes], awake.position[:, boxes])
    before = asleep.t < 0.44
    np.testing.assert_array_equal(asleep.position[before], awake.position[before])
    np.testing.assert_allclose(asleep.position, awake.position, atol=1e-9)
