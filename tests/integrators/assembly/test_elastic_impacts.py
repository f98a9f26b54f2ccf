"""Bodies that are thrown back without loss, and without friction, keep their energy; with less they keep e^2 of it."""

import numpy as np
import pytest

import nonsmooth as ns

G = 9.81  # m/s^2
SMOOTH = ns.Material(mu=0.0, e=1.0)
SHAPES = {
    "disc": ns.Disc(0.1), "box": ns.Box(0.2, 0.14),
    "rounded": ns.Polygon([(-0.1, -0.05), (0.1, -0.05), (0, 0.1)], radius=0.02),
    "sphere": ns.Sphere(0.1), "ellipsoid": ns.Ellipsoid(0.1, 0.07, 0.05), "cuboid": ns.Box(0.2, 0.14, 0.1),
    "capsule": ns.Capsule(0.2, 0.05), "cylinder": ns.Cylinder(0.1, 0.06),
}  # fmt: skip
PLANAR = ("disc", "box", "rounded")
TURNED = np.array([0.96, 0.15, 0.2, 0.1]) / np.linalg.norm([0.96, 0.15, 0.2, 0.1])


def thrown(name, e=1.0):
    """A body that tumbles half a metre above the ground."""
    d, material = 2 if name in PLANAR else 3, ns.Material(mu=0.0, e=e)
    up = (0.0,) * (d - 1) + (1.0,)
    scene = ns.Scene(gravity=tuple(-G * x for x in up), material=material)
    scene.fixed(ns.HalfPlane(up) if d == 2 else ns.HalfSpace(up), name="ground")
    turn, spin = (0.3, 3.0) if d == 2 else (TURNED, (1.0, 2.0, 3.0))
    scene.body(SHAPES[name], density=1000, position=tuple(0.5 * x for x in up), turn=turn, spin=spin, name="body")
    return scene


def energy(sol):
    return sol.ledger["kinetic"] + sol.ledger["potential"]


@pytest.mark.parametrize("dt", [1e-2, 1e-3])
@pytest.mark.parametrize("name", ["disc", "sphere"])
def test_a_ball_that_falls_keeps_its_energy_to_rounding_at_any_step(name, dt):
    sol = ns.simulate(thrown(name), (0, 5.0), integrator=ns.MoreauJean(dt=dt))
    E = energy(sol)
    assert np.count_nonzero(np.diff(sol["body"].velocity[:, -1]) > 1.0) >= 8  # bounces
    assert np.ptp(E) < len(sol.t) * 1e-14 * E[0] and sol.stats.energy_gains == sol.stats.rebounds_limited == 0
    spin = sol["body"].spin
    assert (spin == spin[0]).all() if name == "disc" else np.abs(spin - spin[0]).max() < 1e-12  # no friction turns it


@pytest.mark.parametrize("e", [0.3, 0.5, 0.9])
@pytest.mark.parametrize("dt", [1e-2, 1.1e-3, 1e-4])
def test_a_ball_comes_back_with_e_times_its_speed_at_any_step(e, dt):
    sol = ns.simulate(thrown("sphere", e), (0, 0.4), integrator=ns.MoreauJean(dt=dt))  # lands after 0.286 s
    fallen, v = 0.4, sol["body"].velocity[-1, 2]
    height = sol["body"].position[-1, 2] - 0.1
    assert v**2 + 2 * G * height == pytest.approx(e**2 * 2 * G * fallen, rel=1e-11)


@pytest.mark.upkeep
@pytest.mark.parametrize("dt", [1e-3, 5e-4])
@pytest.mark.parametrize("name", [name for name in SHAPES if name not in ("disc", "sphere")])
def test_a_body_that_tumbles_keeps_its_energy_up_to_the_square_of_its_turn_in_a_step(name, dt):
    """What is left: the rows of the place at which it lands are those of half a step before."""
    sol = ns.simulate(thrown(name), (0, 3.0), integrator=ns.MoreauJean(dt=dt))
    E, spin = energy(sol), np.abs(sol["body"].spin).reshape(len(sol.t), -1).max(axis=1)
    hits = np.flatnonzero(np.abs(np.diff(sol["body"].velocity[:, -1])) > 2 * G * dt)
    allowed = ((spin[hits] + spin[hits + 1]) * dt) ** 2 * E[0]
    assert len(hits) > 5 and np.abs(E - E[0]).max() < allowed.sum() + 1e-3 * dt * E[0]


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("e", [0.6, 1.0])
def test_smooth_balls_that_meet_at_an_angle_exchange_momentum_and_keep_their_spins(d, e):
    """They part with e times the approach of their centres, and without loss with the energy that they had."""
    shape, masses = (ns.Disc(0.1), ns.Disc(0.2)) if d == 2 else (ns.Sphere(0.1), ns.Sphere(0.2)), (1.0, 3.0)
    scene = ns.Scene(gravity=(0.0,) * d, material=ns.Material(mu=0.0, e=e))
    velocities = np.array([(4.0, 0.5, 0.2), (-2.0, -0.3, 0.1)])[:, :d]
    for k, place in enumerate([(0.0,) * d, (1.0, 0.12, 0.05)[:d]]):
        spin = 20.0 if d == 2 else (20.0, -5.0, 8.0)
        scene.body(shape[k], mass=masses[k], position=place, velocity=velocities[k], spin=spin, name="ab"[k])
    sol = ns.simulate(scene, (0, 0.3), integrator=ns.MoreauJean(dt=1e-3))
    a, b = sol["a"], sol["b"]
    n = (b.velocity[-1] - b.velocity[0]) / np.linalg.norm(b.velocity[-1] - b.velocity[0])
    before, after = (n @ (b.velocity[k] - a.velocity[k]) for k in (0, -1))
    turned = np.abs(before) * 1e-3 / 0.3  # by so much the line of centres turns in a step
    assert before < -3.0 and after == pytest.approx(-e * before, rel=turned)
    assert np.abs(a.spin - a.spin[0]).max() < 1e-11 and np.abs(b.spin - b.spin[0]).max() < 1e-11
    momentum = masses[0] * a.velocity + masses[1] * b.velocity
    assert np.abs(momentum - momentum[0]).max() < 1e-14 * len(sol.t)
    if e == 1.0:
        assert np.ptp(energy(sol)) < 1e-13 * energy(sol)[0]
    else:
        assert energy(sol)[-1] < energy(sol)[0]


GASES = [
    (2, 9, ("disc",)),
    (2, 7, ("disc", "box", "rounded")),
    (3, 4, ("sphere",)),
    (3, 4, ("sphere", "cuboid", "capsule")),
]


@pytest.mark.parametrize("e", [0.8, 1.0])
@pytest.mark.parametrize(("d", "n", "names"), GASES, ids=["discs", "planar", "spheres", "spatial"])
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.PenetrationWarning")
def test_a_gas_of_smooth_bodies_gains_no_energy_and_without_loss_keeps_it(d, n, names, e):
    """Hundreds of impacts, two and more of a body at once among them; a contact that is open takes nothing."""
    scene, rng = ns.Scene(gravity=(0.0,) * d, material=ns.Material(mu=0.0, e=e)), np.random.default_rng(4)
    wall = ns.HalfPlane if d == 2 else ns.HalfSpace
    for normal in np.eye(d):
        scene.fixed(wall(normal))
        scene.fixed(wall(-normal, -0.35 * n))
    for k in range(n**d):
        place = (np.array(np.unravel_index(k, (n,) * d)) + 0.5) * 0.35
        scene.body(SHAPES[names[k % len(names)]], density=1000, position=place, velocity=2.0 * rng.normal(size=d))
    sol = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(dt=1e-3))
    E = energy(sol)
    limited = sol.stats.rebounds_limited
    assert sol.stats.struck_together > 0 and sol.stats.energy_gains == 0
    assert limited < sol.stats.impacts and (f", {limited} limited to" in sol.summary()) == (limited > 0)
    assert limited > 0 or e < 1.0
    assert np.diff(E).max() < 1e-4 * E[0]  # inertia turns between landing and rebound
    assert E[-1] > 0.98 * E[0] if e == 1.0 else E[-1] < 0.97 * E[0]
