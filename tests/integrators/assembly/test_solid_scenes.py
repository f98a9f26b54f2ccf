"""Scenes of cylinders, polyhedra and ellipsoids; boxes on edges; fast thin bodies."""

import itertools
import math
import subprocess
import sys
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import nonsmooth as ns

G = 9.81
DT = 2e-3


def ground(mu=0.5, gravity=(0, 0, -G)):
    scene = ns.Scene(gravity=gravity, material=ns.Material(mu=mu))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    return scene


def turn(rotation):
    return rotation.as_quat()[[3, 0, 1, 2]]


def test_cylinder_rolls_down_a_slope_with_two_thirds_of_its_pull():
    """On a half-space and on a box, which is no half-space: a = 2/3 g sin alpha, on neither a facet is felt."""
    alpha = 0.2
    for floor in (ns.HalfSpace((0, 0, 1)), ns.Box(20, 20, 1)):
        scene = ns.Scene(gravity=(0, G * math.sin(alpha), -G * math.cos(alpha)), material=ns.Material(mu=0.5))
        scene.fixed(floor, position=(0, 0, 0 if isinstance(floor, ns.HalfSpace) else -0.5))
        scene.body(ns.Cylinder(0.1, 0.4), density=1000, position=(0, 0, 0.1), name="log")
        log = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(dt=DT))["log"]
        assert log.velocity[-1, 1] == pytest.approx(2 / 3 * G * math.sin(alpha), rel=1e-9)
        assert np.abs(log.position[:, 2] - 0.1).max() < 1e-12 and np.abs(log.velocity[:, 0]).max() < 1e-12


def test_solids_stand_on_one_another_at_rest():
    scene = ground()
    cube = ns.Polyhedron(np.array(list(itertools.product((-0.1, 0.1), repeat=3))))
    upright = turn(Rotation.from_rotvec([0, -np.pi / 2, 0]))
    scene.body(ns.Cylinder(0.1, 0.2), density=1000, position=(0, 0, 0.1), turn=upright, name="can")
    scene.body(cube, density=1000, position=(0.01, 0, 0.3), name="cube")
    scene.body(ns.Box(0.2, 0.2, 0.2), density=1000, position=(0, 0.01, 0.5), name="box")
    scene.body(ns.Cylinder(0.05, 0.1), density=1000, position=(0, 0, 0.65), turn=upright, name="lid")
    sol = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(dt=DT))
    assert np.abs(sol.position - sol.position[0]).max() < 1e-9 and sol.penetration.max() < 1e-12
    volume = 2e-3 * math.pi + 8e-3 + 8e-3 + 2.5e-4 * math.pi
    weight = G * DT * 1000 * volume
    assert sol.contacts(1.0).of("ground").P_N.sum() == pytest.approx(weight, rel=1e-6)


@pytest.mark.parametrize("log", [ns.Cylinder(0.3, 0.6), ns.Capsule(0.6, 0.3)], ids=repr)
def test_a_log_lies_on_two_edges_along_it(log):
    """On the ridges of two boxes: held at both ends of what it has in common with each, it has nowhere to creep."""
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.5))
    for y in (-0.2, 0.2):
        on_edge = turn(Rotation.from_rotvec([math.pi / 4, 0, 0]))
        scene.fixed(ns.Box(2, 0.2, 0.2), position=(0.1, y, -0.1 * math.sqrt(2)), turn=on_edge)
    scene.body(log, density=1000, position=(0, 0, math.sqrt(0.3**2 - 0.2**2)), name="log")
    sol = ns.simulate(scene, (0, 1.0), integrator=ns.MoreauJean(dt=DT))
    assert len(sol.contacts(1.0)) >= 4 and sol.penetration.max() < 1e-15
    assert np.abs(sol.position - sol.position[0]).max() < 1e-14


def test_a_coin_in_a_compound_is_where_it_is_put():
    scene = ground()
    pin = ns.Compound((ns.Cylinder(0.1, 0.02), (0, 0, 0)), (ns.Cylinder(0.1, 0.02), (0.4, 0, 0)))
    scene.body(pin, mass=1.0, position=(0, 0, 0.1), name="axle")
    sol = ns.simulate(scene, (0, 0.1), integrator=ns.MoreauJean(dt=DT))
    assert len(sol.contacts(0.1)) >= 4 and np.abs(sol["axle"].position[-1] - [0.2, 0, 0.1]).max() < 1e-12


@pytest.mark.parametrize("thin", [ns.Sphere(0.005), ns.Box(0.01, 0.01, 0.01), ns.Cylinder(0.01, 0.002),
                                  ns.Ellipsoid(0.01, 0.008, 0.005), ns.Capsule(0.2, 0.001), ns.Box(0.1, 0.1, 0.001)],
                         ids=repr)  # fmt: skip
def test_what_is_fast_and_thin_does_not_pass_a_thin_wall_in_silence(thin):
    """At 100 m/s and 2 ms, 200 mm a step, against 1 mm: it is held, or a warning tells that it went in."""
    rng = np.random.default_rng(5)
    for _ in range(12):
        scene = ns.Scene(gravity=(0, 0, 0))
        scene.fixed(ns.Box(2, 2, 0.001), name="wall")
        place, spin = (*rng.normal(size=2) * 0.05, rng.uniform(0.15, 0.5)), rng.normal(size=3) * 30
        scene.body(thin, density=1000, position=place, velocity=(*rng.normal(size=2) * 10, -100), spin=spin,
                   turn=turn(Rotation.random(random_state=rng)), name="shot")  # fmt: skip
        check_held(scene, "shot", 2)


@pytest.mark.parametrize("wall", [ns.Box(2, 0.001), ns.Segment((-1, 0), (1, 0))], ids=repr)
@pytest.mark.parametrize(
    "thin", [ns.Disc(0.005), ns.Box(0.01, 0.01), ns.Capsule(0.2, 0.001), ns.Box(0.1, 0.001)], ids=repr
)
def test_what_is_fast_and_thin_in_the_plane_does_not_pass_in_silence(thin, wall):
    rng = np.random.default_rng(6)
    for _ in range(12):
        scene = ns.Scene(gravity=(0, 0))
        scene.fixed(wall, name="wall")
        scene.body(thin, density=1000, position=(rng.normal() * 0.05, rng.uniform(0.15, 0.5)), spin=rng.normal() * 30,
                   velocity=(rng.normal() * 10, -100), turn=rng.uniform(0, 6), name="shot")  # fmt: skip
        check_held(scene, "shot", 1)


def check_held(scene, name, axis):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        sol = ns.simulate(scene, (0, 0.03), integrator=ns.MoreauJean(dt=DT))
    is_through = sol[name].position[:, axis].min() < -0.0005
    assert not is_through or any(issubclass(warning.category, ns.PenetrationWarning) for warning in told)


@pytest.mark.filterwarnings("ignore::nonsmooth.errors.PenetrationWarning")
def test_boxes_that_land_on_edges_list_where_they_will_touch_next():
    """At 5 m/s and 2 ms. One point an edge left 9 mm here, when another corner swung down; what is left is the turn
    within a step, of the square of its angle: r (omega dt)^2/2, with omega of some 5/0.1 rad/s, 0.5 mm, twice."""
    for seed in range(12):
        rng = np.random.default_rng(seed)
        scene = ground(mu=0.5 * (seed % 3))
        tilts = np.array([math.pi / 4, 0, 0]) + rng.normal(size=3) * (0.1, 0.1, 0)
        scene.fixed(ns.Box(0.4, 0.4, 0.4), position=(0, 0, 0.3), turn=turn(Rotation.from_euler("xyz", tilts)))
        tilts = np.array([0, math.pi / 4, 0]) + rng.normal(size=3) * (0.1, 0.2, 1)
        scene.body(ns.Box(0.2, 0.3, 0.25), density=1000, position=(*rng.normal(size=2) * 0.02, 0.85),
                   turn=turn(Rotation.from_euler("xyz", tilts)), velocity=(0, 0, -5))  # fmt: skip
        sol = ns.simulate(scene, (0, 0.25), integrator=ns.MoreauJean(dt=DT))
        assert sol.penetration.max() < 1.5e-3


def test_a_scene_of_balls_and_the_ground_loads_nothing_of_other_shapes():
    code = """
import nonsmooth as ns
from nonsmooth.scenes.spatial.solids import further_points, solid_contact
def run(shape):
    scene = ns.Scene(gravity=(0, 0, -9.81))
    scene.fixed(ns.HalfSpace((0, 0, 1)))
    scene.body(shape, density=1000, position=(0, 0, 1))
    ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))
    print(int(solid_contact.is_loaded), int(further_points.is_loaded))
run(ns.Sphere(0.1)); run(ns.Box(0.1, 0.1, 0.1)); run(ns.Cylinder(0.1, 0.1))
"""
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.split("\n")[:3] == ["0 0", "0 1", "1 1"]
