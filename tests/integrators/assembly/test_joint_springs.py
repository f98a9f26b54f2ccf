"""Springs, dampers and rotors on joints, against closed forms, an integrator of the equations, and what is kept."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns

G = 9.81
MASS, MOMENT, ARM = 1.3, 0.02, 0.4


def run(scene, t_end, dt, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)


def point(dim, x, y):
    return (x, y) if dim == 2 else (x, 0.0, y)


def ball(dim, r):
    return ns.Disc(r) if dim == 2 else ns.Sphere(r)


def pendulum(dim, gravity=G, **spring):
    """A bob that starts level with its hinge; its angle counts downwards."""
    scene = ns.Scene(gravity=point(dim, 0, -gravity))
    scene.fixed(ball(dim, 0.02), name="post")
    inertia = MOMENT if dim == 2 else (MOMENT,) * 3
    scene.body(ball(dim, 0.1), mass=MASS, inertia=inertia, position=point(dim, ARM, 0), name="bob")
    hinge = scene.hinge("post", "bob", at=point(dim, 0, 0), name="h", **({} if dim == 2 else {"axis": (0, 1, 0)}))
    if spring:
        hinge.spring(**spring)
    return scene, hinge


def angle_of(dim, sol):
    return -sol.joint("h").angle if dim == 2 else sol.joint("h").angle


@pytest.mark.parametrize("dim", [2, 3])
def test_a_pendulum_with_spring_damper_and_rotor_follows_its_equation_to_second_order(dim):
    k, c, a, rest, torque = 5.0, 0.3, 0.7, 0.2, 1.5
    sign = -1.0 if dim == 2 else 1.0  # the angle counts up in the plane, and down about y

    def rates(t, y):
        pull = torque - k * (y[0] - rest) - c * y[1] + MASS * G * ARM * math.cos(y[0])
        return y[1], pull / (MOMENT + MASS * ARM**2 + a)

    exact = solve_ivp(rates, (0, 1), (0, 0), t_eval=np.linspace(0, 1, 11), rtol=1e-11, atol=1e-12).y[0]
    errors = []
    for dt in (4e-3, 2e-3):
        scene, hinge = pendulum(dim, stiffness=k, damping=c, inertia=a, rest=sign * rest)
        hinge.motor(torque=sign * torque)
        sol = run(scene, 1, dt, t_eval=np.linspace(0, 1, 11))
        errors.append(np.abs(angle_of(dim, sol) - exact).max())
        assert sol.stats.worst_residual <= 1e-8
        ledger = sol.ledger
        gained = ledger["force"] + ledger["normal"] + ledger["friction"]
        np.testing.assert_allclose(ledger["kinetic"], gained - gained[0], atol=1e-12)
    assert abs(math.log2(errors[0] / errors[1]) - 2) < 0.1


def test_a_rotor_alone_adds_its_inertia_to_that_of_the_wheel():
    scene, hinge = pendulum(2, gravity=0.0, inertia=0.5)
    hinge.motor(torque=2.0)
    angle = run(scene, 1, 1e-2).joint("h").angle[-1]
    assert angle == pytest.approx(0.5 * 2.0 / (MOMENT + MASS * ARM**2 + 0.5), rel=1e-4)


def test_a_function_of_a_motor_drives_a_joint_with_a_rotor_to_second_order():
    def rates(t, y):
        return y[1], (8.0 * math.sin(5.0 * t) - 20.0 * y[0]) / (MOMENT + MASS * ARM**2 + 0.3)

    exact = solve_ivp(rates, (0, 1), (0, 0), rtol=1e-11, atol=1e-12).y[0, -1]
    errors = []
    for dt in (4e-3, 2e-3):
        scene, hinge = pendulum(2, gravity=0.0, inertia=0.3)
        hinge.motor(torque=lambda t, bodies: 8.0 * math.sin(5.0 * t) - 20.0 * bodies["bob"].turn)
        errors.append(abs(run(scene, 1, dt).joint("h").angle[-1] - exact))
    assert abs(math.log2(errors[0] / errors[1]) - 2) < 0.2


def test_a_spring_that_no_step_resolves_keeps_its_energy_and_a_stiff_damper_brakes():
    scene = ns.Scene(gravity=(0, 0))
    scene.fixed(ns.Disc(0.1), name="frame")
    scene.body(ns.Disc(0.2), mass=1.0, inertia=0.5, spin=0.1, name="wheel")
    scene.hinge("frame", "wheel", at=(0, 0), name="h").spring(stiffness=2e9)
    sol = run(scene, 1, 1e-2)  # omega dt = 632
    assert np.abs(sol.joint("h").angle).max() < 1e-5
    energy = 0.5 * (0.5 * sol["wheel"].spin ** 2 + 2e9 * sol["wheel"].turn ** 2)
    np.testing.assert_allclose(energy, 0.5 * 0.5 * 0.1**2, rtol=1e-6)
    scene, hinge = pendulum(3, gravity=0.0, damping=1e6)
    hinge.motor(torque=1e3)
    assert run(scene, 1, 1e-2).joint("h").angle[-1] == pytest.approx(1e-3, rel=1e-3)


@pytest.mark.parametrize("kind", ["slider", "cylindrical", "slot"])
def test_a_spring_along_a_travel_swings_with_its_frequency(kind):
    scene = ns.Scene(gravity=(0, 0, 0))
    scene.fixed(ns.Sphere(0.1), name="a")
    scene.body(ns.Sphere(0.1), mass=2.0, position=(0, 0, 1), velocity=(0, 0, 0.6), name="b")
    joint = getattr(scene, kind)("a", "b", axis=(0, 0, 1), at=(0, 0, 1), name="j")
    joint.spring(stiffness=45.0, inertia=3.0, along="travel")  # omega = 3
    travel = run(scene, 2, 1e-3).joint("j").travel
    t = np.linspace(0, 2, len(travel))
    np.testing.assert_allclose(travel, 0.2 * np.sin(3 * t), atol=1e-6)


def test_two_bodies_that_tumble_on_a_hinge_with_a_rotor_keep_momentum_and_energy():
    errors = []
    for dt in (2e-3, 1e-3):
        scene = ns.Scene(gravity=(0, 0, 0))
        spin = np.array((3.0, 1.0, -2.0))
        for name, x in (("a", -0.3), ("b", 0.3)):
            scene.body(
                ns.Box(0.5, 0.2, 0.1), mass=2.0, position=(x, 0, 0), spin=spin, velocity=np.cross(spin, (x, 0, 0)),
                name=name,
            )  # fmt: skip
        hinge = scene.hinge("a", "b", at=(0, 0, 0), axis=(0, 1, 0), name="h")
        hinge.spring(inertia=0.4)
        sol = run(scene, 1, dt)
        assert np.abs((sol["a"].velocity + sol["b"].velocity)[-1]).max() < 1e-12
        energy = sol.ledger["kinetic"] + 0.5 * 0.4 * sol.joint("h").angle_rate ** 2
        errors.append(np.abs(energy - energy[0]).max())
    assert abs(math.log2(errors[0] / errors[1]) - 2) < 0.3


def test_what_rebounds_strikes_its_rotor_along():
    scene = ns.Scene(gravity=(0, 0, -10.0), material=ns.Material(e=0.5))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="floor")
    scene.fixed(ns.Sphere(0.1), position=(1, 0, 0), name="rail")
    scene.body(ns.Sphere(0.1), mass=1.0, position=(0, 0, 0.3), name="ball")
    scene.slider("rail", "ball", axis=(0, 0, 1), name="way").spring(inertia=3.0)
    sol = run(scene, 0.7, 1e-3)
    speed = sol["ball"].velocity[:, 2]
    fall = math.sqrt(2 * 2.5 * 0.2)  # 10/4 m/s^2 over 0.2 m
    assert speed.min() == pytest.approx(-fall, rel=5e-3)
    assert speed.max() == pytest.approx(0.5 * fall, rel=5e-3)


def test_a_run_with_a_rotor_goes_on_from_a_checkpoint_to_the_same_bits(tmp_path):
    def scene():
        return pendulum(3, stiffness=5.0, damping=0.1, inertia=0.2)[0]

    whole = run(scene(), 0.5, 1e-3)
    place = tmp_path / "run.nsc"
    run(scene(), 0.5, 1e-3, checkpoint=place, max_steps=223, on_failure="return")
    resumed = run(scene(), 0.5, 1e-3, checkpoint=place, resume=place)
    assert np.array_equal(resumed["bob"].position[-1], whole["bob"].position[-1])


def test_error_control_takes_springs_of_joints():
    scene, _ = pendulum(3, stiffness=5.0, damping=0.1, inertia=0.2)
    fine = run(scene, 0.5, 1e-4)["bob"].position[-1]
    sol = ns.simulate(scene, (0, 0.5), integrator=ns.Adaptive(rtol=1e-5, atol=1e-7))
    assert np.abs(sol["bob"].position[-1] - fine).max() < 1e-4


@pytest.mark.parametrize(
    ("kind", "options", "message"),
    [
        ("hinge", {}, "the spring of h needs stiffness=, damping= or inertia=; got none"),
        ("hinge", {"stiffness": -1.0}, "stiffness of the spring of h"),
        ("hinge", {"inertia": math.nan}, "inertia of the spring of h"),
        ("hinge", {"stiffness": 1.0, "rest": "far"}, "rest of the spring of h must be a number"),
        (
            "hinge",
            {"stiffness": 1.0, "along": "travel"},
            "has along='travel', and a hinge joint has angle along its axis",
        ),
        ("fix", {"stiffness": 1.0}, "and a fix joint has no angle or travel along its axis"),
    ],
)
def test_a_spring_that_is_none_is_refused(kind, options, message):
    scene = ns.Scene()
    scene.fixed(ns.Disc(0.1), name="a")
    scene.body(ns.Disc(0.1), mass=1.0, name="b")
    with pytest.raises(ns.InvalidInput, match=message):
        getattr(scene, kind)("a", "b", at=(0, 0), name="h").spring(**options)


def test_methods_that_know_no_springs_of_joints_say_so():
    scene, _ = pendulum(2, stiffness=5.0)
    with pytest.raises(ns.InvalidInput, match="Penalty knows no springs on coordinates of joints, and h has one"):
        ns.simulate(scene, (0, 0.1), integrator=ns.Penalty(1e5))
    scene.system()
    scene.joints[0].spring(inertia=1.0)
    with pytest.raises(ns.InvalidInput, match="h has limits, friction or a rotor, which no system of a scene holds"):
        scene.system()


def test_a_centre_of_mass_has_an_inertia_about_it_and_is_where_the_body_turns():
    scene = ns.Scene(gravity=(0, 0, 0))
    with pytest.raises(ns.InvalidInput, match="odd has centre= without inertia=, which is about it; give both"):
        scene.body(ns.Sphere(0.1), mass=1.0, centre=(0.1, 0, 0), name="odd")
    scene.body(
        ns.Sphere(0.1),
        mass=1.0,
        centre=(0.1, 0, 0),
        inertia=(1, 2, 3),
        position=(1, 0, 0),
        spin=(0, 0, 1.0),
        name="odd",
    )
    sol = run(scene, 0.1, 1e-2)
    np.testing.assert_allclose(sol["odd"].position, np.tile((1.1, 0, 0), (11, 1)), atol=1e-15)
