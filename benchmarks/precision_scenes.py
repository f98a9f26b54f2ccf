"""Ten scenes of bodies whose ends are known: by a closed form, by another method, or by two that agree."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

import nonsmooth as ns
from benchmarks.exact_scenes import backspin, turntable

G = 9.81  # m/s^2


class Case(NamedTuple):
    """A scene, how long it runs [s], and where the centres of the bodies that move are then (n, 2|3) [m]."""

    scene: Callable[[], ns.Scene]
    t_end: float
    exact: Callable[[ns.Scene, float], np.ndarray]
    source: str  # of the exact places
    has_system: bool = False  # whether EventDriven takes it


def slope_scene(angle: float, mu: float, up: tuple[float, ...]) -> ns.Scene:
    """A plane that descends along x, with gravity turned."""
    sin, cos = G * math.sin(angle), -G * math.cos(angle)
    scene = ns.Scene(gravity=(sin, cos) if len(up) == 2 else (sin, 0, cos), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfPlane(up) if len(up) == 2 else ns.HalfSpace(up))
    return scene


def box_that_slides() -> ns.Scene:
    """A box of 0.1 m that slides 0.6 m and stops."""
    scene = slope_scene(0.0, 0.2, (0, 0, 1))
    scene.body(ns.Box(0.2, 0.2, 0.1), mass=1.0, position=(0, 0, 0.05), velocity=(1.2, 0.9, 0))
    return scene


def stopped(scene: ns.Scene, t: float) -> np.ndarray:
    """v^2/(2 mu g) along v."""
    way = 1.5**2 / (2 * 0.2 * G)
    return np.array([[0.8 * way, 0.6 * way, 0.05]])


def came_back(scene: ns.Scene, t: float) -> np.ndarray:
    """A ball with backspin: it slides at mu g until t_1 = 2 s_0/(7 mu g), s_0 = v + omega r, and rolls."""
    v, s, mu = 4.0, 4.0 + 200 * 0.25, 0.5
    t_1 = 2 * s / (7 * mu * G)
    x = v * t - 0.5 * mu * G * t * t if t < t_1 else v * t_1 - 0.5 * mu * G * t_1**2 + (v - mu * G * t_1) * (t - t_1)
    return np.array([[x, 0, 0.25]])


def carried(scene: ns.Scene, t: float) -> np.ndarray:
    """On a table that turns at 2 rad/s."""
    return np.array([[math.cos(2 * t), math.sin(2 * t), 0.1]])


def spheres_that_meet() -> ns.Scene:
    """A sphere flies against another one, off its centre: no friction, no rebound."""
    scene = ns.Scene(gravity=(0, 0, 0), material=ns.Material(mu=0.0))
    scene.body(ns.Sphere(0.1), mass=1.0, position=(-1, 0.1, 0), velocity=(2, 0, 0))
    scene.body(ns.Sphere(0.1), mass=2.0, position=(0, 0, 0))
    return scene


def met(scene: ns.Scene, t: float) -> np.ndarray:
    """They meet where sin = 1/2; along the normal both then have the velocity of the centre of mass."""
    normal, v = np.array([math.sqrt(0.75), -0.5, 0]), np.array([2.0, 0, 0])
    t_1 = (1 - 0.2 * normal[0]) / 2
    P = 2 / 3 * (v @ normal) * normal
    return np.array([[-1, 0.1, 0] + v * t - P * (t - t_1), P / 2 * (t - t_1)])


def box_on_a_corner() -> ns.Scene:
    """A box that falls on a corner and turns down about it: no friction."""
    scene = slope_scene(0.0, 0.0, (0, 0, 1))
    turn = np.array([0.9, 0.3, 0.2, 0.1])
    scene.body(
        ns.Box(0.2, 0.3, 0.1), mass=1.0, position=(0, 0, 0.3), turn=turn / np.linalg.norm(turn), velocity=(1, 0, 0)
    )
    return scene


def rocking_block() -> ns.Scene:
    """A block of 0.2 by 0.8 m that is let go at 0.15 rad."""
    scene = slope_scene(0.0, 2.0, (0, 1))
    tilt, half = 0.15, np.array([0.1, 0.4])
    sin, cos = math.sin(tilt), math.cos(tilt)
    place = (-half[0] * cos + half[1] * -sin, -half[0] * -sin + half[1] * cos)
    scene.body(ns.Box(0.2, 0.8), mass=1.0, position=place, turn=tilt)
    return scene


def box_that_tumbles() -> ns.Scene:
    """A square that rolls down 40 degrees over its edges."""
    scene = slope_scene(math.radians(40), 1.5, (0, 1))
    scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(0, 0.1), velocity=(1.0, 0), spin=-10.0)
    return scene


def polygon_that_rolls() -> ns.Scene:
    """A polygon of 16 sides that rolls down 8 degrees."""
    scene, angles = slope_scene(math.radians(8), 0.9, (0, 1)), (np.arange(16) + 0.5) * math.pi / 8
    scene.body(
        ns.Polygon(0.1 * np.column_stack((np.cos(angles), np.sin(angles)))), mass=1.0,
        position=(0, 0.1 * math.cos(math.pi / 16)), velocity=(0.3, 0), spin=-3.0,
    )  # fmt: skip
    return scene


ANGLES, LENGTH = (1.0, 1.4), 0.5  # of two rods from below [rad]; [m]


def double_pendulum() -> ns.Scene:
    """Two thin rods of 0.5 m on pins."""
    scene = ns.Scene(gravity=(0, -G))
    wall = scene.fixed(ns.Disc(0.001), name="wall")
    before, at = wall, np.zeros(2)
    for k, angle in enumerate(ANGLES):
        along = LENGTH * np.array([math.sin(angle), -math.cos(angle)])
        rod = scene.body(
            ns.Disc(0.001), mass=1.0, inertia=LENGTH**2 / 12, position=at + along / 2, turn=angle, name=f"rod {k + 1}"
        )
        scene.joint(before, rod, at=at)
        before, at = rod, at + along
    return scene


def swung(scene: ns.Scene, t: float) -> np.ndarray:
    """Lagrange's equations of both angles, by `solve_ivp`."""

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        a, b, u, v = y
        c, s, m = math.cos(a - b), math.sin(a - b), LENGTH**2
        mass = m * np.array([[4 / 3, 0.5 * c], [0.5 * c, 1 / 3]])
        load = [
            -0.5 * m * s * v * v - 1.5 * G * LENGTH * math.sin(a),
            0.5 * m * s * u * u - 0.5 * G * LENGTH * math.sin(b),
        ]
        return np.concatenate(([u, v], np.linalg.solve(mass, load)))

    a, b = solve_ivp(rates, (0, t), [*ANGLES, 0, 0], method="DOP853", rtol=1e-12, atol=1e-14).y[:2, -1]
    first, second = (0.5 * LENGTH * np.array([math.sin(x), -math.cos(x)]) for x in (a, b))
    return np.array([first, 2 * first + second])


def stack() -> ns.Scene:
    """Ten cubes, the top one 100 times as heavy."""
    scene = slope_scene(0.0, 0.5, (0, 0, 1))
    for k in range(10):
        scene.body(ns.Box(0.2, 0.2, 0.2), mass=100.0 if k == 9 else 1.0, position=(0, 0, 0.1 + 0.2 * k))
    return scene


def where_it_was(scene: ns.Scene, t: float) -> np.ndarray:
    """At the start."""
    return np.array([body.position for body in scene.bodies if body.kind.name == "DYNAMIC"])


def by_events(scene: ns.Scene, t: float) -> np.ndarray:
    """`EventDriven` of the system of the scene, another method."""
    return ends(ns.simulate(scene, (0, t), integrator=ns.EventDriven(rtol=1e-12, atol=1e-14), every=10**9))


def ends(sol: Any) -> np.ndarray:
    """The centres of the bodies that move at the end (n, 2|3) [m]."""
    moving = [body.index for body in sol.scene.bodies if body.kind.name == "DYNAMIC"]
    return np.asarray(sol.position[-1, moving])


CLOSED, OTHER = "closed form", "EventDriven, 1e-12"
CASES = {
    "box that slides": Case(box_that_slides, 1.5, stopped, CLOSED, True),
    "ball with backspin": Case(backspin, 4.0, came_back, CLOSED, True),
    "box on a turntable": Case(turntable, 1.0, carried, CLOSED),
    "spheres that meet": Case(spheres_that_meet, 1.0, met, CLOSED, True),
    "box on a corner": Case(box_on_a_corner, 0.22, by_events, OTHER, True),
    "rocking block": Case(rocking_block, 1.5, by_events, OTHER, True),
    "box that tumbles": Case(box_that_tumbles, 0.8, by_events, OTHER, True),
    "polygon that rolls": Case(polygon_that_rolls, 1.0, by_events, OTHER, True),
    "double pendulum": Case(double_pendulum, 2.0, swung, "SciPy, 1e-12", True),
    "stack": Case(stack, 2.0, where_it_was, CLOSED),
}
