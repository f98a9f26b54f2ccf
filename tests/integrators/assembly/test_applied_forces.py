"""Forces that are applied to bodies: orders, gravity by another name, friction, errors."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from models.painleve_rod import PainleveRod
from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.inertia import inertia_of


def run(scene, t_end, dt, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt), **options)


def orders(errors):
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


@pytest.mark.parametrize("dim", [2, 3])
def test_a_force_of_place_and_velocity_is_of_second_order(dim):
    """m x'' = -k x - c x', a damped oscillation."""
    k, c, m = 40.0, 1.0, 2.0
    decay, omega = c / (2 * m), math.sqrt(k / m - (c / (2 * m)) ** 2)
    exact = math.exp(-decay) * (math.cos(omega) + decay / omega * math.sin(omega))
    errors = []
    for dt in (4e-3, 2e-3, 1e-3):
        scene = ns.Scene(gravity=(0.0,) * dim)
        shape = ns.Disc(0.1) if dim == 2 else ns.Sphere(0.1)
        scene.body(shape, mass=m, position=np.eye(dim)[0], name="b")
        scene.force("b", lambda t, bodies: -k * bodies["b"].position - c * bodies["b"].velocity)
        sol = run(scene, 1.0, dt)
        errors.append(abs(sol["b"].position[-1, 0] - exact))
        gained = sol.ledger["kinetic"][-1] - sol.ledger["kinetic"][0]
        assert gained == pytest.approx(sol.ledger["force"][-1], abs=1e-12)
    np.testing.assert_allclose(orders(errors), 2.0, atol=0.1)


def torque(t):
    return np.array([math.sin(3 * t), 0.5, math.cos(t)])


@pytest.mark.upkeep
def test_a_torque_on_a_body_that_tumbles_is_of_second_order_with_its_work():
    inertia = np.diag([1.0, 2.0, 2.5])

    def rates(t, y):
        q, w = y[:4] / np.linalg.norm(y[:4]), y[4:]
        r, s = q[1:], q[0]
        cross = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
        R = np.eye(3) + 2 * s * cross + 2 * cross @ cross
        J = R @ inertia @ R.T
        turning = 0.5 * np.concatenate(([-w @ r], s * w + np.cross(w, r)))
        return np.concatenate((turning, np.linalg.solve(J, torque(t) - np.cross(w, J @ w))))

    exact = solve_ivp(rates, (0, 2), [1, 0, 0, 0, 1.0, 2, -1], rtol=1e-11, atol=1e-12).y[:, -1]
    errors, works = [], []
    for dt in (4e-3, 2e-3, 1e-3):
        scene = ns.Scene(gravity=(0, 0, 0))
        scene.body(ns.Box(0.3, 0.2, 0.1), mass=1.0, inertia=inertia, spin=(1, 2, -1), name="b")
        scene.force("b", lambda t, _: ((0, 0, 0), torque(t)))
        sol = run(scene, 2.0, dt)
        turn = sol["b"].turn[-1] * np.sign(sol["b"].turn[-1] @ exact[:4])
        errors.append(max(np.abs(turn - exact[:4]).max(), np.abs(sol["b"].spin[-1] - exact[4:]).max()))
        works.append(abs(sol.ledger["kinetic"][-1] - sol.ledger["kinetic"][0] - sol.ledger["force"][-1]))
    np.testing.assert_allclose(orders(errors), 2.0, atol=0.1)
    np.testing.assert_allclose(orders(works), 2.0, atol=0.1)


def rod(scene):
    q, u = PainleveRod().state(th=math.pi / 3, thdot=0.0, slip=-1.0)
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    shape = ns.Polygon([(-0.5, 0), (0, -0.01), (0.5, 0), (0, 0.01)])
    scene.body(shape, mass=1.0, inertia=1 / 12, position=q[:2], turn=q[2], velocity=u[:2], name="rod")


def boxes(scene):
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    for k in range(3):
        scene.body(ns.Box(0.2, 0.1), density=900, position=(0.03 * k, 0.06 + 0.15 * k), turn=0.1 * k, name=f"box {k}")


def cubes(scene):
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    for k in range(3):
        turn = np.array([1.0, 0.1 * k, 0.05, 0.0])
        scene.body(
            ns.Box(0.2, 0.15, 0.1), density=900, position=(0.02 * k, 0, 0.12 + 0.2 * k), spin=(1, k, 0),
            turn=turn / np.linalg.norm(turn), name=f"box {k}",
        )  # fmt: skip


@pytest.mark.filterwarnings("ignore::nonsmooth.errors.SimultaneousImpactWarning")
@pytest.mark.parametrize(("build", "dim", "mu", "e"), [(rod, 2, 2.0, 0.0), (boxes, 2, 0.4, 0.3), (cubes, 3, 0.4, 0.3)])
def test_a_force_of_each_mass_is_gravity_by_another_name(build, dim, mu, e):
    """Landings, rebounds, stacks and a paradox: the same to rounding, of a few steps where that grows."""
    up, found = np.eye(dim)[-1], []
    for pulled in (0.0, 3.0):
        scene = ns.Scene(gravity=-(9.81 - pulled) * up, material=ns.Material(mu=mu, e=e))
        build(scene)
        for body in scene:
            if body.kind is Kind.DYNAMIC:
                scene.force(body, -pulled * inertia_of(body, dim).mass * up)
        found.append(run(scene, 0.25, 1e-3))
    np.testing.assert_allclose(found[1].position, found[0].position, atol=1e-8)
    np.testing.assert_allclose(found[1].velocity, found[0].velocity, atol=1e-5)
    assert [event.kind for event in found[1].paradoxes] == [event.kind for event in found[0].paradoxes]
    assert found[0].stats.missed == found[1].stats.missed == 0


@pytest.mark.parametrize("F", [4.9, 4.91, 6.0])
def test_a_block_that_is_pushed_sticks_up_to_mu_times_its_weight(F):
    scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Box(0.4, 0.1), mass=1.0, position=(0, 0.05), name="b")
    scene.force("b", (F, 0.0))
    sol = run(scene, 1.0, 1e-3)
    assert sol["b"].position[-1, 0] == pytest.approx(max(0.0, F - 0.5 * 9.81) / 2, abs=1e-12)
    if F < 4.905:
        assert (sol["b"].position[:, 0] == 0.0).all()  # no creep


@pytest.mark.parametrize(("F", "tips"), [(4.8, False), (5.0, True)])
def test_a_cube_tips_where_the_moment_of_the_push_exceeds_that_of_its_weight(F, tips):
    """A push at the upper edge of a cube of height a tips it about the lower one beyond m g/2."""
    scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.9))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Box(0.4, 0.4), mass=1.0, position=(0, 0.2), name="b")
    scene.force("b", (F, 0.0), at=(-0.2, 0.4))
    sol = run(scene, 0.3, 1e-3)
    assert (sol["b"].turn[-1] < -1e-3) == tips and (tips or sol["b"].turn[-1] == 0.0)


def test_a_force_at_a_point_goes_with_the_body():
    """A thruster of a puck that spins: its force is fixed in the world, its moment turns with the arm."""
    scene = ns.Scene(gravity=(0, 0))
    scene.body(ns.Box(0.2, 0.2), mass=1.0, inertia=0.5, position=(1, 0), name="b")
    scene.force("b", (0.0, 1.0), at=(1.1, 0.0))
    sol = run(scene, 2.0, 1e-3)
    exact = solve_ivp(lambda t, y: [y[1], 0.1 * math.cos(y[0]) / 0.5], (0, 2), [0, 0], rtol=1e-10, atol=1e-12)
    assert sol["b"].turn[-1] == pytest.approx(exact.y[0, -1], abs=1e-6)
    np.testing.assert_allclose(sol["b"].velocity[-1], [0.0, 2.0], atol=1e-12)


def test_constant_forces_add_up_and_a_function_of_them_is_the_same():
    found = []
    for forces in ([(1.0, 0.5)], [(0.25, 0.5), (0.75, 0.0)], [lambda t, bodies: (1.0, 0.5)]):
        scene = ns.Scene(gravity=(0, -9.81))
        scene.body(ns.Disc(0.1), mass=1.5, name="b")
        for force in forces:
            scene.force("b", force)
        found.append(run(scene, 0.5, 1e-3).position)
    assert (found[0] == found[1]).all() and (found[0] == found[2]).all()


def test_what_is_pushed_does_not_sleep():
    scene = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfPlane((0, 1)))
    scene.body(ns.Box(0.4, 0.1), mass=1.0, position=(0, 0.05), name="b")
    scene.force("b", lambda t, bodies: (10.0 if t > 1.0 else 0.0, 0.0))
    sol = run(scene, 2.0, 1e-3)
    assert sol["b"].position[-1, 0] == pytest.approx((10 - 0.5 * 9.81) / 2, abs=0.02)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ((1.0,), "the force on b must have 2 entries"),
        ((1.0, math.nan), "the force on b"),
        ("up", "the force on b"),
    ],
)
def test_a_force_that_is_none_is_refused(value, message):
    scene = ns.Scene()
    scene.body(ns.Disc(0.1), mass=1.0, name="b")
    with pytest.raises(ns.InvalidInput, match=message):
        scene.force("b", value)


def test_what_cannot_be_pushed_is_refused_by_name():
    scene = ns.Scene()
    scene.fixed(ns.HalfPlane((0, 1)), name="ground")
    with pytest.raises(ns.InvalidInput, match="a force acts on ground, which no force moves"):
        scene.force("ground", (1, 0))
    with pytest.raises(ns.InvalidInput, match="a force acts on 'box', which is no body of the scene"):
        scene.force("box", (1, 0))
    scene.body(ns.Disc(0.1), mass=1.0, position=(0, 1), name="b")
    scene.force("b", nothing)
    with pytest.raises(ns.InvalidInput, match=r"force.* b|b.* force"):
        ns.simulate(scene, (0, 0.1), integrator=ns.EventDriven())
    with pytest.raises(ns.InvalidInput, match="the force on b is a function, which no system of a scene holds"):
        scene.system()
    with pytest.raises(ns.ModelFunctionError, match="finite"):
        ns.simulate(scene, (0, 0.1), integrator="auto")


def nothing(t, bodies):
    return math.nan, 0.0


def raises(t, bodies):
    raise ValueError("no wind")


def three(t, bodies):
    return 1.0, 2.0, 3.0


@pytest.mark.parametrize(
    ("function", "message"), [(nothing, "finite"), (raises, "raised ValueError: no wind"), (three, "must be 2 numbers")]
)
def test_a_function_that_says_no_force_ends_the_run_with_what_was_computed(function, message):
    scene = ns.Scene(gravity=(0, -9.81))
    scene.body(ns.Disc(0.1), mass=1.0, name="b")
    scene.force("b", lambda t, bodies: (0.0, 0.0) if t < 0.05 else function(t, bodies))
    with pytest.raises(ns.ModelFunctionError, match=message) as told:
        run(scene, 0.1, 1e-3)
    assert told.value.solution.t[-1] == pytest.approx(0.05, abs=2e-3)
    assert "the force on b at t = 0.05" in str(told.value)


def test_a_run_that_is_resumed_has_the_forces_and_another_force_is_another_run(tmp_path):
    def pushed(k):
        scene = ns.Scene(gravity=(0, -9.81))
        scene.body(ns.Disc(0.1), mass=1.0, name="b")
        scene.force("b", (k, 0.0), at=(0.0, 0.1))
        return scene

    place = tmp_path / "run.npz"
    part = run(pushed(2.0), 0.2, 1e-3, checkpoint=place, max_steps=77, on_failure="return")
    assert part.t[-1] < 0.2
    whole, resumed = run(pushed(2.0), 0.2, 1e-3), run(pushed(2.0), 0.2, 1e-3, checkpoint=place, resume=place)
    assert (whole.position == resumed.position).all() and (whole.turn == resumed.turn).all()
    place = tmp_path / "other.npz"
    run(pushed(2.0), 0.2, 1e-3, checkpoint=place, max_steps=77, on_failure="return")
    with pytest.raises(ns.NonsmoothError, match="force"):
        run(pushed(3.0), 0.2, 1e-3, checkpoint=place, resume=place)
