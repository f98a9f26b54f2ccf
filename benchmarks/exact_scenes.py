"""The scenes of exact friction of 2026: what they hold, how long they run, and what is known of their ends.

After Song, Fan, Ascher, Pai, "A Splitting Architecture for Exact Reduced Coulomb Friction" (arXiv 2607.19599), and the
tests of a fork of PhysX (2026: pallet, sheets, real cards). Sizes of cards and stones are ours: the authors' files were
not at hand.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from benchmarks.published.standing import REAL, card_house, shuttled
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, HalfSpace, Polyhedron, Sphere

G = 9.81  # m/s^2
UP = (0, 0, 1)
Places = np.ndarray  # (3, n, 3) of the bodies that move: at the start, before the last step, at the end [m]


class Case(NamedTuple):
    """A scene, its duration [s], what is measured of its end, and the figure of the authors for it."""

    scene: Callable[[], Scene]
    t_end: float
    error: Callable[[Places, float], float]  # [m] or [m/s], of the places and the step
    says: str  # what the error is of
    authors: str = ""


def ground(mu: float, gravity: tuple[float, float, float] = (0, 0, -G)) -> Scene:
    """A plane and what rubs on it."""
    scene = Scene(gravity=gravity, material=Material(mu=mu))
    scene.fixed(HalfSpace(UP))
    return scene


def moved(places: Places, dt: float) -> float:
    """Largest way of a body along an axis."""
    return float(np.abs(places[2] - places[0]).max())


def slope(mu: float) -> Scene:
    """A cube on a slope of tan alpha = 1/2."""
    alpha = math.atan(0.5)
    scene = ground(mu, (G * math.sin(alpha), 0, -G * math.cos(alpha)))
    scene.body(Box(1, 1, 1), density=1000, position=(0, 0, 0.5))
    return scene


def slope_case(mu: float) -> Case:
    """Its way against that of the closed form."""
    exact = max(0.0, 2 * G * (math.sin(math.atan(0.5)) - mu * math.cos(math.atan(0.5))))
    told = {0.3: "FBF 5.3 ms", 0.5: "FBF 5.5 ms"}.get(mu, "")
    return Case(lambda: slope(mu), 2.0, lambda places, dt: abs(places[2, 0, 0] - exact), "way", told)


def backspin() -> Scene:
    """A ball that slides forward and spins backward."""
    scene = ground(0.5)
    scene.body(Sphere(0.25), density=1000, position=(0, 0, 0.25), velocity=(4, 0, 0), spin=(0, -200, 0))
    return scene


def returned(places: Places, dt: float) -> float:
    """Speed of the ball against 80/7 m/s, backwards."""
    return float(abs((places[2, 0, 0] - places[1, 0, 0]) / dt + 80 / 7))


def sliding_box() -> Scene:
    """A box at its limit between sliding and tipping."""
    scene = ground(0.5)
    scene.body(Box(0.3, 1.2, 0.6), density=200, position=(0, 0, 0.3), velocity=(4, 0, 0))
    return scene


def turntable() -> Scene:
    """A box that a turning table can just keep."""
    scene = Scene(gravity=(0, 0, -G), material=Material(mu=0.5))
    scene.kinematic(Box(10, 10, 0.2), position=(0, 0, -0.1), spin=(0, 0, 2.0), name="table")
    scene.body(Box(0.2, 0.2, 0.2), density=1000, position=(1, 0, 0.1), velocity=(0, 2.0, 0), spin=(0, 0, 2.0))
    return scene


def arch(n: int, thickness: float) -> Scene:
    """A half circle of stones, radius 1 m, between two that are fixed, and four cubes that fall on its crown."""
    scene = ground(0.8)
    angles, radii = np.linspace(0, math.pi, n + 1), (1 - thickness / 2, 1 + thickness / 2)
    for k in range(n):
        faces = [(r * math.cos(a), r * math.sin(a)) for a in angles[k : k + 2] for r in radii]
        stone = Polyhedron([(x, y, z) for x, z in faces for y in (-0.15, 0.15)])
        if k in (0, n - 1):
            scene.fixed(stone)
        else:
            scene.body(stone, density=1000)
    for k in range(4):
        scene.body(Box(0.1, 0.1, 0.1), density=1000, position=(0.12 * (k - 2), 0, 1.5 + thickness / 2))
    return scene


def arch_case(n: int, thickness: float, t_end: float, authors: str) -> Case:
    """The way of its stones."""
    return Case(lambda: arch(n, thickness), t_end, lambda p, dt: moved(p[:, : n - 2], dt), "stones moved", authors)


def sheets(n: int) -> Scene:
    """A stack of sheets of 1 mm and 1 g."""
    scene = ground(0.5)
    for k in range(n):
        scene.body(Box(0.2, 0.2, 0.001), mass=0.001, position=(0, 0, 0.001 * k + 0.0005))
    return scene


def pallet() -> Scene:
    """A pallet with 60 boxes and four sheets on a platform that is driven at 0.5 m/s^2."""
    scene = Scene(gravity=(0, 0, -G), material=Material(mu=0.5))
    scene.kinematic(Box(3, 2, 0.2), motion=shuttled, name="platform")
    scene.body(Box(1.2, 1.0, 0.15), mass=10, position=(0, 0, 0.075))
    for layer in range(5):
        z = 0.15 + 0.251 * layer
        for k in range(12):
            at = ((k % 4 - 1.5) * 0.3, (k // 4 - 1) * 0.31, z + 0.125)
            scene.body(Box(0.29, 0.3, 0.25), mass=1, position=at)
        if layer < 4:
            scene.body(Box(1.2, 1.0, 0.001), mass=0.5, position=(0, 0, z + 0.2505))
    return scene


def slipped(places: Places, dt: float) -> float:
    """Largest way along the path of the platform, against it, after 2 s."""
    return float(np.abs(places[2, :, 0] - places[0, :, 0] - shuttled(2.0)[0]).max())


def radius(places: Places, dt: float) -> float:
    """Change of the distance from the axis of the table."""
    return float(abs(math.hypot(*places[2, 0, :2]) - 1.0))


CASES = {
    "slope, μ = 0.3": slope_case(0.3),
    "slope, μ = tan α": slope_case(0.5),
    "backspin": Case(backspin, 4.0, returned, "speed [m/s]", "FBF 6.0 ms; MuJoCo -13.73 m/s, Kamino 17.1 ms"),
    "box at its limit": Case(
        sliding_box, 2.0, lambda places, dt: abs(places[2, 0, 0] - 16 / G), "way", "FBF 6.4 to 7.0 ms"
    ),
    "turntable": Case(turntable, 1.0, radius, "radius", "FBF 3.1 to 3.7 ms"),
    "house of 4 levels": Case(lambda: card_house(4), 1.0, moved, "moved", "FBF 199 ms; MuJoCo 8.7 times that"),
    "house of 10 levels": Case(lambda: card_house(10), 0.5, moved, "moved", "FBF 853 ms; MuJoCo did not finish"),
    "arch of 25 stones": arch_case(25, 0.2, 1.5, "FBF 595 ms; MuJoCo 23 times that"),
    "arch of 101 stones": arch_case(101, 0.15, 1.0, "FBF 1234 ms; MuJoCo did not finish"),
    "pallet on a shuttle": Case(pallet, 2.0, slipped, "slip", "1.05 mm (MuJoCo), 0.72 mm (the fork), 60 s"),
    "20 sheets": Case(lambda: sheets(20), 0.5, moved, "moved", "mark: overlap < 20 µm"),
    "real playing cards": Case(lambda: card_house(5, 0, 0.0, **REAL), 0.5, moved, "moved", "mark: < 220 µm"),
    "house of 4 levels, four cubes of 256 kg": Case(
        lambda: card_house(4, cubes=4), 2.0, lambda p, dt: moved(p[:, :26], dt), "cards moved"
    ),
    "house of 10 levels, kicked": Case(lambda: card_house(10, kick=0.02), 0.5, moved, "moved"),
}
