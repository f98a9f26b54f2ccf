"""Scenes with joints against closed forms, other integrators, invariants and measured orders."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

import nonsmooth as ns
from models import BeadChain, WallPendulum
from nonsmooth.integrators.assembly.progress import DONE, NOT_MET
from nonsmooth.integrators.assembly.stages import take_steps
from nonsmooth.integrators.assembly.step import PLACES
from nonsmooth.jit import interpreted
from nonsmooth.runs.recorder import SceneRecorder
from nonsmooth.runs.scene_run import SceneRun
from nonsmooth.scenes.places import conjugate, rotate

G = 9.81
EPS = np.finfo(float).eps
LENGTH, WIDTH, MASS = 1.0, 0.02, 2.0
INERTIA = MASS * (LENGTH**2 + WIDTH**2) / 12 + MASS * LENGTH**2 / 4  # of a rod about its end


def simulate(scene, t_end, dt=1e-3, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)


def hooked(dim=2, gravity=G):
    """A scene with a fixed hook at the origin."""
    scene = ns.Scene(gravity=(0.0,) * (dim - 1) + (-gravity,))
    scene.fixed(ns.Disc(0.01) if dim == 2 else ns.Sphere(0.01), name="hook")
    return scene


def pendulum(angle, rate=0.0):
    """A rod that hangs on the hook, at an angle from there."""
    scene, s, c = hooked(), math.sin(angle), math.cos(angle)
    scene.body(
        ns.Box(WIDTH, LENGTH), mass=MASS, position=(LENGTH / 2 * s, -LENGTH / 2 * c), turn=angle, spin=rate,
        velocity=(LENGTH / 2 * rate * c, LENGTH / 2 * rate * s), name="rod",
    )  # fmt: skip
    scene.joint("hook", "rod", at=(0, 0), name="pin")
    return scene


def double_pendulum(first, second):
    """Two rods at angles from hanging."""
    scene = hooked()
    ends = [np.zeros(2)]
    for k, angle in enumerate((first, second)):
        way = LENGTH * np.array([math.sin(angle), -math.cos(angle)])
        body = scene.body(ns.Box(WIDTH, LENGTH), mass=MASS, position=ends[-1] + way / 2, turn=angle, name=f"rod {k}")
        scene.joint("hook" if k == 0 else "rod 0", body, at=ends[-1])
        ends.append(ends[-1] + way)
    return scene


def chain(n, dim, end=1.0, links=0.1):
    """Links that hang on the hook; the last one is ``end`` times as heavy as the others."""
    scene = hooked(dim)
    lengths = (0.02,) * (dim - 1) + (0.8 * links,)
    for k in range(n):
        down = np.array([0.0] * (dim - 1) + [-links])
        scene.body(ns.Box(*lengths), mass=0.1 * (end if k == n - 1 else 1), position=(k + 0.5) * down, name=f"link {k}")
        scene.joint("hook" if k == 0 else f"link {k - 1}", f"link {k}", at=k * down)
    return scene


def order(errors, ratio=2.0):
    """That errors of steps in a ratio fall with, the last ones."""
    return math.log(errors[-2] / errors[-1]) / math.log(ratio)


def energy(solution):
    return solution.ledger["kinetic"] + solution.ledger["potential"]


def test_pendulum_passes_the_bottom_after_a_quarter_of_the_elliptic_period_to_second_order():
    start = 1.2
    quarter = math.sqrt(INERTIA / (MASS * G * LENGTH / 2)) * ellipk(math.sin(start / 2) ** 2)
    fastest = 2 * math.sqrt(MASS * G * LENGTH / 2 / INERTIA) * math.sin(start / 2)
    angles, rates = [], []
    for steps in (100, 200, 400):
        rod = ns.simulate(pendulum(start), (0, quarter), integrator=ns.MoreauJean(dt=quarter / steps))["rod"]
        angles.append(abs(rod.turn[-1]))
        rates.append(abs(rod.spin[-1] + fastest))
    assert abs(order(angles) - 2) < 0.05 and abs(order(rates) - 2) < 0.05
    assert angles[-1] < 1e-4


def test_pendulum_is_the_system_of_one_angle():
    def mass(t, q, p, M):
        M[0, 0] = INERTIA

    def force(t, q, u, p, h):
        h[0] = -MASS * G * LENGTH / 2 * math.sin(q[0])

    def difference(dt):
        angle = ns.System(n_q=1, mass=mass, force=force)
        one = ns.simulate(angle, (0, 2), q0=[1.0], u0=[0.5], integrator=ns.MoreauJean(dt=dt))
        rod = simulate(pendulum(1.0, 0.5), 2.0, dt)["rod"]
        return max(abs(rod.turn[-1] - one.q[-1, 0]), abs(rod.spin[-1] - one.u[-1, 0]))

    differences = [difference(dt) for dt in (4e-3, 2e-3, 1e-3)]
    assert abs(order(differences) - 2) < 0.1 and differences[-1] < 2e-4


def test_double_pendulum_follows_its_equations_to_second_order():
    I, m, l, h = MASS * (LENGTH**2 + WIDTH**2) / 12, MASS, LENGTH, LENGTH / 2

    def rates(t, y):
        a, b, da, db = y
        c, s = m * l * h * math.cos(a - b), m * l * h * math.sin(a - b)
        M = np.array([[I + m * h**2 + m * l**2, c], [c, I + m * h**2]])
        f = [-s * db**2 - (m * h + m * l) * G * math.sin(a), s * da**2 - m * h * G * math.sin(b)]
        return [da, db, *np.linalg.solve(M, f)]

    start = (1.0, -0.4)
    exact = solve_ivp(rates, (0, 1.5), [*start, 0, 0], rtol=1e-11, atol=1e-12).y[:, -1]
    errors = []
    for dt in (1e-3, 5e-4, 2.5e-4):
        solution = simulate(double_pendulum(*start), 1.5, dt)
        found = [solution[f"rod {k}"].turn[-1] for k in range(2)] + [solution[f"rod {k}"].spin[-1] for k in range(2)]
        errors.append(np.abs(found - exact).max())
        assert solution.stats.worst_joint_drift < 20 * dt**3 * 6.0**3  # a step drifts dt^3 omega^3 l, at most 6 rad/s
    assert abs(order(errors) - 2) < 0.1


@pytest.mark.upkeep
def test_pendulum_strikes_a_wall_as_its_closed_form_says():
    mass, radius, length, e, start = 1.5, 0.1, 0.8, 0.7, 1.0
    inertia = 0.5 * mass * radius**2
    model = WallPendulum(l=length + inertia / (mass * length), e=e, g=G)
    peaks, times = model.peak_angles(3, th=start), model.impact_times(2, th=start)
    errors = []
    for dt in (1e-3, 2.5e-4):
        scene = hooked()
        scene.fixed(ns.HalfPlane((1, 0)), position=(-radius, 0), material=ns.Material(mu=0.0, e=e), name="wall")
        position = (length * math.sin(start), -length * math.cos(start))
        scene.body(
            ns.Disc(radius), mass=mass, position=position, turn=start, material=ns.Material(mu=0.0, e=e), name="bob"
        )
        scene.joint("hook", "bob", at=(0, 0))
        solution = ns.simulate(
            scene, (0, 2.0), integrator=ns.MoreauJean(dt=dt), record=("bodies", "contacts", "ledger", "events")
        )
        angle = solution["bob"].turn
        landings = [event.t for event in solution.events if event.kind == ns.SceneEventKind.LANDING]
        assert np.abs(np.array(landings[:2]) - times).max() < 2 * dt + 0.3 * dt  # a step, and its own error
        between = (solution.t > times[0]) & (solution.t < times[1])
        errors.append(abs(angle[between].max() - peaks[1]))
        balance = solution.ledger
        rest = balance["kinetic"] - sum(balance[name] for name in ("force", "friction", "normal", "surface"))
        assert np.ptp(rest) < 1e4 * EPS * np.abs(balance["force"]).max()  # some roundings a step
        assert solution.stats.energy_gains == solution.stats.struck_together == 0
    assert max(errors) < 1e-5  # [rad]: the velocity of the landing is that where the gap closes


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("end, moved", [(1.0, 0.0), (1e3, 0.0), (1e6, 1e-11)])
def test_hanging_chain_stands(dim, end, moved):
    # masses 1 to 1e6: its impulses are known to 1e6 roundings, which are velocities of the light links
    n = 50 if end == 1.0 else 10
    solution = simulate(chain(n, dim, end), 10.0 if end == 1.0 else 2.0, 2e-3)
    assert np.abs(solution.position - solution.position[0]).max() <= moved
    weight = 0.1 * (n - 1 + end) * G * 2e-3
    np.testing.assert_allclose(solution.joint("joint 0").P[-1], [0] * (dim - 1) + [weight], rtol=1e-9, atol=1e-9)
    assert solution.stats.missed == 0 and solution.stats.contacts == solution.stats.most_contacts == 0
    if moved == 0.0:
        assert solution.stats.asleep > 0.9 * solution.stats.steps


def test_heavy_end_swings_on_light_links():
    # fast enough for the links: they swing about their middles at sqrt(T h/I), T the pull, h half a link
    turning = []
    for dt in (2e-4, 1e-4):
        scene = chain(10, 2, 1e3)
        for k in range(10):  # as one rod
            body = scene[f"link {k}"]
            body.velocity[0] = 0.05 * (k + 0.5)
            object.__setattr__(body, "spin", 0.5)
        solution = simulate(scene, 0.5, dt)
        E = energy(solution)
        turning.append(np.abs(E - E[0]).max() / solution.ledger["kinetic"].max())
        assert solution.stats.missed == 0 and solution.stats.worst_joint_drift < 1e-7
    assert turning[1] < 1e-4


def test_door_on_two_ball_joints_swings_about_the_line_between_them():
    start, half = 1.0, 0.15
    exact = solve_ivp(
        lambda t, y: [y[1], -MASS * G * LENGTH / 2 / INERTIA * math.sin(y[0])], (0, 2), [start, 0],
        rtol=1e-11, atol=1e-12,
    ).y[:, -1]  # fmt: skip
    errors = []
    for dt in (4e-3, 2e-3):
        scene, turn = hooked(3), (math.cos(start / 2), 0, -math.sin(start / 2), 0)
        scene.body(
            ns.Box(WIDTH, 2 * half, LENGTH), mass=MASS, turn=turn, name="door",
            position=(LENGTH / 2 * math.sin(start), 0, -LENGTH / 2 * math.cos(start)),
        )  # fmt: skip
        for y in (half, -half):  # along the line between them both say the same: one row too many
            scene.joint("hook", "door", at=(0, y, 0))
        solution = simulate(scene, 2.0, dt)
        x, _, z = solution["door"].position[-1]
        errors.append(abs(math.atan2(x, -z) - exact[0]))
        assert np.abs(solution["door"].position[:, 1]).max() < 1e-12 and solution.stats.missed == 0
        first, second = (solution.joint(f"joint {k}").P for k in range(2))
        np.testing.assert_allclose(first[:, [0, 2]], second[:, [0, 2]], atol=1e-10 * np.abs(first).max())
    assert abs(order(errors) - 2) < 0.1


def test_linkage_of_four_bars_in_space_has_its_one_freedom():
    # two cranks l and a coupler in parallel: (2 I + m l^2) th'' = -(m_c + m) g l sin th; 24 rows on 18 coordinates
    l, m_c, m, half, start = 0.5, 0.4, 1.0, 0.05, 0.7
    crank, coupler = ns.Box(0.02, 0.04, l), ns.Box(1.0, 0.04, 0.02)
    of_crank = m_c * (l**2 + 0.02**2) / 12 + m_c * l**2 / 4

    def scene():
        linkage = hooked(3)
        way = l * np.array([math.sin(start), 0, -math.cos(start)])
        turn = (math.cos(start / 2), 0, -math.sin(start / 2), 0)
        for k, x in enumerate((-0.5, 0.5)):
            linkage.body(crank, mass=m_c, position=np.array([x, 0, 0]) + way / 2, turn=turn, name=f"crank {k}")
        linkage.body(coupler, mass=m, position=way, name="coupler")
        for k, x in enumerate((-0.5, 0.5)):
            for y in (-half, half):
                linkage.joint("hook", f"crank {k}", at=(x, y, 0))
                linkage.joint(f"crank {k}", "coupler", at=np.array([x, y, 0]) + way)
        return linkage

    stiffness, inertia = (m_c + m) * G * l, 2 * of_crank + m * l**2
    exact = solve_ivp(
        lambda t, y: [y[1], -stiffness / inertia * math.sin(y[0])], (0, 1), [start, 0], rtol=1e-11, atol=1e-12
    ).y[0, -1]
    errors = []
    for dt in (4e-3, 2e-3):
        solution = simulate(scene(), 1.0, dt)
        x, y, z = solution["coupler"].position.T
        errors.append(abs(math.atan2(x[-1], -z[-1]) - exact))
        assert np.abs(y).max() < 1e-12 and np.abs(solution["coupler"].spin).max() < 1e-4 and solution.stats.missed == 0
    assert abs(order(errors) - 2) < 0.1


def test_joined_bodies_keep_their_momentum_and_to_second_order_their_energy_and_angular_momentum():
    def run(dt):
        scene = ns.Scene(gravity=(0, 0))
        scene.body(ns.Box(0.4, 0.1), mass=1.0, position=(0.2, 0), velocity=(0, 0.3), name="a")
        scene.body(ns.Box(0.6, 0.1), mass=2.0, position=(0.7, 0), velocity=(0, -0.9), spin=-4.0, name="b")
        scene.joint("a", "b", at=(0.4, 0))  # whose points move alike at the start: 0.3 = -0.9 + 4 * 0.3
        return simulate(scene, 2.0, dt)

    turns, swings = [], []
    for dt in (2e-3, 1e-3):
        solution = run(dt)
        masses, inertias = np.array([1.0, 2.0]), np.array([1.0 * (0.16 + 0.01), 2.0 * (0.36 + 0.01)]) / 12
        x, v, omega = solution.position, solution.velocity, solution.spin
        momentum = (masses[:, None] * v).sum(axis=1)
        angular = (masses * (x[..., 0] * v[..., 1] - x[..., 1] * v[..., 0]) + inertias * omega).sum(axis=1)
        assert np.abs(momentum - momentum[0]).max() < 2000 * 16 * EPS  # some roundings a step
        turns.append(np.abs(angular - angular[0]).max())  # by what takes drifts back: dt^3 a step, times m v
        E = energy(solution)
        swings.append(np.abs(E - E[0]).max())
    assert abs(order(swings) - 2) < 0.2 and order(turns) > 1.8 and turns[-1] < 1e-6


def test_balls_on_a_joint_in_space_keep_their_momentum_and_to_second_order_the_angular_one():
    masses, inertias = np.array([1.0, 2.0])[:, None], 0.4 * np.array([1.0 * 0.01, 2.0 * 0.04])[:, None]

    def turned(dt):
        scene = ns.Scene(gravity=(0, 0, 0))
        scene.body(ns.Sphere(0.1), mass=1.0, position=(-0.2, 0, 0), velocity=(0, -0.4, 0), spin=(0, 0, 2.0), name="a")
        scene.body(ns.Sphere(0.2), mass=2.0, position=(0.3, 0, 0), velocity=(0, 0.6, 0), spin=(0.5, 0, 2.0), name="b")
        scene.joint("a", "b", at=(0, 0, 0))
        solution = simulate(scene, 2.0, dt)
        momentum = (masses * solution.velocity).sum(axis=1)
        assert np.abs(momentum - momentum[0]).max() < 2000 * 16 * EPS
        angular = (masses * np.cross(solution.position, solution.velocity) + inertias * solution.spin).sum(axis=1)
        return np.abs(angular - angular[0]).max()

    losses = [turned(dt) for dt in (4e-3, 2e-3)]
    assert order(losses) > 1.8 and losses[-1] < 1e-5


def test_order_of_bodies_and_mirror_change_roundings_only():
    def run(names, sign):
        scene = ns.Scene(gravity=(0, -G))
        places = {"hook": (0, 0), "a": (0.25, 0.1), "b": (0.75, 0.2)}
        for name in names:
            x, y = places[name]
            if name == "hook":
                scene.fixed(ns.Disc(0.01), name=name)
            else:
                scene.body(ns.Box(0.4, 0.05), mass=1.0, position=(sign * x, y), turn=sign * 0.3, name=name)
        scene.joint("hook", "a", at=(0, 0))
        scene.joint("a", "b", at=(sign * 0.5, 0.15))
        return simulate(scene, 1.0)

    one, other, mirror = run("hook a b".split(), 1), run("b hook a".split(), 1), run("hook a b".split(), -1)
    for name in ("a", "b"):
        # roundings grow as nearby motions part: e^(4 t) at most in this second
        np.testing.assert_allclose(other[name].position, one[name].position, atol=1e-10)
        np.testing.assert_allclose(mirror[name].position * [-1, 1], one[name].position, atol=1e-10)
        np.testing.assert_allclose(-mirror[name].turn, one[name].turn, atol=1e-10)


def test_guided_crank_drives_what_hangs_on_it():
    scene = ns.Scene(gravity=(0, -G))
    scene.kinematic(ns.Disc(0.02), motion=lambda t: (0.1 * math.sin(3 * t), 0.0), name="slide")
    scene.body(ns.Box(WIDTH, LENGTH), mass=MASS, position=(0, -LENGTH / 2), velocity=(0.3, 0), name="rod")
    scene.joint("slide", "rod", at=(0, 0))
    pull = MASS * LENGTH / 2 / INERTIA
    exact = solve_ivp(
        lambda t, y: [y[1], -pull * (G * math.sin(y[0]) - 0.9 * math.sin(3 * t) * math.cos(y[0]))],
        (0, 2), [0, 0], rtol=1e-11, atol=1e-12,
    ).y[0, -1]  # fmt: skip
    errors = []
    for dt in (4e-3, 2e-3):
        solution = simulate(scene, 2.0, dt)
        errors.append(abs(solution["rod"].turn[-1] - exact))
        works = solution.ledger
        rest = works["kinetic"] - sum(works[name] for name in ("force", "friction", "normal", "surface"))
        assert np.ptp(rest) < 1e4 * EPS * np.abs(works["force"]).max()
    assert errors[1] < 0.6 * errors[0] and errors[1] < 1e-2


def test_blow_wakes_a_chain_that_sleeps_and_leaves_no_other_bit():
    def run(may_sleep):
        scene = chain(5, 2)
        scene.body(ns.Disc(0.05), mass=0.05, position=(-1.5, -0.35), velocity=(3.0, 0.5 * G * 0.48), name="ball")
        contacts = ns.ContactSolver(may_sleep=may_sleep)
        return ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(dt=2.5e-4, contacts=contacts))

    asleep, awake = run(True), run(False)
    assert asleep.stats.islands_asleep > 100 and awake.stats.islands_asleep == 0
    assert np.abs(asleep["link 4"].turn).max() > 0.1 and asleep["link 4"].turn[1200] == 0.0
    np.testing.assert_array_equal(asleep.position, awake.position)
    np.testing.assert_array_equal(asleep.joint_impulses, awake.joint_impulses)


def test_joined_bodies_do_not_touch_and_others_do():
    scene = ns.Scene(gravity=(0, -G))
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    for k in range(3):
        scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(0.19 * k, 0.1), name=f"box {k}")  # 1 cm in one another
    scene.joint("box 0", "box 1", at=(0.095, 0.1))
    with pytest.raises(ns.InvalidInput, match="box 1 and box 2 overlap at the start by 0.01 m"):
        simulate(scene, 0.01)
    scene.joint("box 1", "box 2", at=(0.285, 0.1))
    found = simulate(scene, 0.1).contacts()
    assert set(zip(found.i, found.j, strict=True)) == {(0, 1), (0, 2), (0, 3)} and (found.mu >= 0).all()


@pytest.mark.parametrize("e", [0.8, 1.0])
def test_ten_beads_of_a_scene_are_those_of_the_system(e):
    # one impact at a time, in steps without forces: both methods are exact but for when a step is an impact
    n, radius, gap = 10, 0.05, 0.01
    chain_of_beads = BeadChain(n=n, m=1.0, gap=gap, e=e, r=radius)
    system, u0 = chain_of_beads.system(), np.eye(n)[0]
    scene = ns.Scene(gravity=(0, 0), material=ns.Material(mu=0.0, e=e))
    for k in range(n):
        scene.body(
            ns.Disc(radius), mass=1.0, position=(k * (2 * radius + gap), 0.0), velocity=(u0[k], 0), name=f"bead {k}"
        )
    scene.fixed(ns.HalfPlane((-1, 0)), position=((n - 1) * (2 * radius + gap) + radius + gap, 0), name="wall")
    one = ns.simulate(system, (0, 0.5), np.zeros(n), u0, integrator=ns.EventDriven())
    many = simulate(scene, 0.5, 1e-4)
    assert many.stats.struck_together == 0
    np.testing.assert_allclose(many.velocity[-1, :n, 0], one.u[-1], atol=100 * EPS)  # ten impacts, some roundings each


def of_turning(motion, moments):
    """Angular momentum about the centre of mass of a body in space at each record."""
    return [rotate(q, moments * rotate(conjugate(q), w)) for q, w in zip(motion.turn, motion.spin, strict=True)]


def moments_of(mass, size):
    squares = np.array(size) ** 2
    return mass * (squares.sum() - squares) / 12


def test_boxes_on_a_joint_in_space_keep_their_angular_momentum_to_second_order():
    parts = {"a": (1.0, (0.4, 0.1, 0.2), 0.2), "b": (2.0, (0.6, 0.1, 0.3), 0.7)}

    def lost(dt):
        scene, L = ns.Scene(gravity=(0, 0, 0)), 0.0
        for name, (mass, size, x) in parts.items():
            scene.body(ns.Box(*size), mass=mass, position=(x, 0, 0), velocity=(0, x, 0), spin=(1, 0, 1), name=name)
        scene.joint("a", "b", at=(0.4, 0, 0))
        solution = simulate(scene, 1.0, dt)
        for name, (mass, size, _) in parts.items():
            body = solution[name]
            L = L + mass * np.cross(body.position, body.velocity) + of_turning(body, moments_of(mass, size))
        return np.abs(L - L[0]).max()

    losses = [lost(dt) for dt in (4e-3, 2e-3)]
    assert order(losses) > 1.8 and losses[-1] < 1e-5


def test_box_on_a_ball_joint_keeps_energy_and_momentum_about_the_vertical_to_second_order():
    size, mass, tilt = (0.2, 0.3, 1.0), 2.0, 1.0
    errors, shares = [], []
    for dt in (4e-3, 2e-3):
        scene, (s, c) = hooked(3), (math.sin(tilt), math.cos(tilt))
        scene.body(
            ns.Box(*size), mass=mass, position=(0.5 * s, 0, -0.5 * c), velocity=(0, 1, 0), spin=(0, 0, 2 / s),
            turn=(math.cos(tilt / 2), 0, -math.sin(tilt / 2), 0), name="box",
        )  # fmt: skip
        scene.joint("hook", "box", at=(0, 0, 0))
        solution = simulate(scene, 2.0, dt)
        box, E, works = solution["box"], energy(solution), solution.ledger
        L = (mass * np.cross(box.position, box.velocity) + of_turning(box, moments_of(mass, size)))[:, 2]
        errors.append(max(np.abs(E - E[0]).max(), np.abs(L - L[0]).max()))
        rest = works["kinetic"] - sum(works[name] for name in ("force", "friction", "normal", "surface"))
        shares.append(np.ptp(rest))
        assert np.abs(np.linalg.norm(box.position, axis=1) - 0.5).max() < 10 * dt**3 * 5.0**3  # 5 rad/s at most
    assert abs(order(errors) - 2) < 0.2 and errors[-1] < 1e-4
    assert order(shares) > 1.5 and shares[-1] < 1e-4


@pytest.mark.parametrize("dim", [2, 3])
def test_the_interpreter_takes_steps_of_the_bits_of_compiled_code(dim):
    def begun():
        scene, dt = chain(3, dim), 2e-3
        scene["link 2"].velocity[0] = 0.3  # and it drags on the ground
        ground = ns.HalfPlane((0, 1)) if dim == 2 else ns.HalfSpace((0, 0, 1))
        surface = ns.Material(mu=0.0 if dim == 2 else 0.5)  # in the plane it may jam, which is asked of compiled code
        scene.fixed(ground, position=[0] * (dim - 1) + [-0.29], name="ground", material=surface)
        assembly = SceneRun(scene, (0, 5 * dt), ns.MoreauJean(dt=dt), 1, None, SceneRecorder(("pairs",))).assembly
        assembly.bodies.motion.x[2, 0] += 2e-5  # by which joints are off at the start
        return assembly

    one, other = begun(), begun()
    one.take_steps(2e-3, 5)
    fields = {name: getattr(other.progress, name) for name in type(other.progress)._fields()}
    fields |= {name: getattr(one.progress, name) for name in ("whole", "margin", "widest")}
    blocks = {name: getattr(other, name) for name in PLACES}
    fields["places"] = SimpleNamespace(motion=other.bodies.motion, **blocks)
    progress = SimpleNamespace(**fields)
    while (end := interpreted(take_steps)(progress, 5 - int(progress.counts.steps), dim)) == NOT_MET:
        other.rescue()
    assert end == DONE
    assert other.progress.figures.drift > 1e-5 and one.network.n_c > len(one.joints.i)
    assert one.pairs.count == 4  # three joints, and the ground
    for name in ("bodies", "contacts", "ledger", "pairs"):
        found, expected = (getattr(run, name).words.view(np.int64) for run in (other, one))
        np.testing.assert_array_equal(found, expected)
