"""What has to stand, rest or tip: houses of cards, arches, sheets, a pallet, a hanger on a pin; who lets it fall."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

import nonsmooth as ns
from benchmarks.published.rows import Row, Section
from benchmarks.published.scenes import STEP, UP, ball_with_backspin, slid
from models.scenes import CardHouse

REAL = {"length": 0.088, "width": 0.063, "thickness": 0.0003, "lean": math.radians(25), "mass": 0.0018}


def card_house(
    levels: int, cubes: int = 0, kick: float = 0.0, length: float = 1.0, width: float = 0.45, thickness: float = 0.03,
    lean: float = 0.23, mass: float = 13.5,
) -> ns.Scene:  # fmt: skip
    """A house of cards; every card is kicked at random, cubes of 256 kg fall on it."""
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.8))
    scene.fixed(ns.HalfSpace(UP))
    rng = np.random.default_rng(0)
    height = length * math.cos(lean) + thickness * math.sin(lean)
    reach = (length * math.sin(lean) + thickness * math.cos(lean)) / 2

    def card(x: float, z: float, angle: float) -> None:
        turn = (math.cos(angle / 2), 0, math.sin(angle / 2), 0)
        velocity, spin = kick * rng.normal(size=(2, 3))
        scene.body(
            ns.Box(thickness, width, length), mass=mass, position=(x, 0, z), turn=turn, velocity=velocity, spin=spin
        )

    for level in range(levels):
        z = level * (height + thickness)
        for k in range(levels - level):
            for side in (-1, 1):
                card((k + level / 2) * length + side * reach, z + height / 2, -side * lean)
            if k:
                card((k - 0.5 + level / 2) * length, z + height + thickness / 2, math.pi / 2)
    top = levels * (height + thickness)
    for k in range(cubes):
        scene.body(ns.Box(0.8, 0.8, 0.8), density=500, position=(0.2 + 0.9 * k, 0.05 * k, top + 1.4 + 0.2 * k))
    return scene


@functools.cache
def house(levels, dt=1 / 60, **cards):
    """1 s of a house of cards."""
    return ns.simulate(card_house(levels, **cards), (0, 1), integrator=ns.MoreauJean(dt=dt))


def moved(sol):
    """Largest way of a body along an axis, from the start to the end [m]."""
    return np.abs(sol.position[-1] - sol.position[0]).max()


def limit(rests, low, high):
    """The largest value at which something rests, by halving."""
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if rests(middle) else (low, middle)
    return low


def steepest(mu):
    """Largest angle from the vertical at which two cards of 90 x 2 mm lean on one another [rad]."""

    def rests(angle):
        return moved(ns.simulate(CardHouse(mu=mu, angle=angle), (0, 0.2), integrator=ns.MoreauJean(dt=5e-3))) < 1e-9

    return limit(rests, 0.05, 1.4)


@functools.cache
def arch_under_cubes(n, thickness):
    """Largest way of a stone of an arch of radius 1 m after 1.5 s, on whose crown four cubes of 1 kg fall [m]."""
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.8))
    scene.fixed(ns.HalfSpace(UP))
    angles, radii = np.linspace(0, math.pi, n + 1), (1 - thickness / 2, 1 + thickness / 2)
    for k in range(n):
        faces = [(r * math.cos(a), r * math.sin(a)) for a in angles[k : k + 2] for r in radii]
        stone = ns.Polyhedron([(x, y, z) for x, z in faces for y in (-0.15, 0.15)])
        if k in (0, n - 1):
            scene.fixed(stone, name=f"stone {k}")
        else:
            scene.body(stone, density=1000, name=f"stone {k}")
    for k in range(4):
        scene.body(ns.Box(0.1, 0.1, 0.1), density=1000, position=(0.12 * (k - 2), 0, 1.5 + thickness / 2))
    sol = ns.simulate(scene, (0, 1.5), integrator=STEP)
    ways = (sol[f"stone {k}"].position[-1] - sol[f"stone {k}"].position[0] for k in range(n))
    return max(np.abs(way).max() for way in ways)


@functools.cache
def sheets(n):
    """1 s of a stack of sheets of 1 mm and 1 g."""
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5))
    scene.fixed(ns.HalfSpace(UP))
    for k in range(n):
        scene.body(ns.Box(0.2, 0.2, 0.001), mass=0.001, position=(0, 0, 0.001 * k + 0.0005))
    return ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(dt=0.01))


def shuttled(t):
    """Place of a platform that goes 1 m to and fro at 0.5 m/s^2."""
    s = t % 3.0
    way = 0.25 * s * s if s < 1 else 0.25 + 0.5 * (s - 1) if s < 2 else 1 - 0.25 * (3 - s) ** 2
    return (way if t % 6.0 < 3.0 else 1 - way, 0, -0.1)


@functools.cache
def pallet():
    """A pallet of 10 kg with five layers of 12 boxes of 1 kg, a sheet of 1 mm on each, once to and fro."""
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5))
    scene.kinematic(ns.Box(3, 2, 0.2), motion=shuttled, name="platform")
    scene.body(ns.Box(1.2, 1.0, 0.15), mass=10, position=(0, 0, 0.075), name="pallet")
    for layer in range(5):
        z = 0.15 + 0.251 * layer
        for k in range(12):
            at = ((k % 4 - 1.5) * 0.3, (k // 4 - 1) * 0.31, z + 0.125)
            scene.body(ns.Box(0.29, 0.3, 0.25), mass=1, position=at)
        if layer < 4:
            scene.body(ns.Box(1.2, 1.0, 0.001), mass=0.5, position=(0, 0, z + 0.2505))
    return ns.simulate(scene, (0, 6), integrator=ns.MoreauJean(dt=0.01))


def drift(sol):
    """Largest way along the shuttle's of a body against the platform [m]."""
    on_it = sol.position[:, 1:, 0] - np.array([[shuttled(t)[0]] for t in sol.t])
    return np.abs(on_it - on_it[0]).max()


@dataclass(frozen=True)
class Hanger:
    """A body of 1 kg with a hole of 11 mm radius on a pin of 10 mm, its centre of mass 0.3 m below that of the hole.

    q = (x, y, turn) of the centre of mass; the pin is about the origin.
    """

    mu: float = 0.5

    def system(self):
        """As a system of one contact."""

        def mass(t, q, p, M):
            M[0, 0] = M[1, 1] = 1.0
            M[2, 2] = 0.05

        def force(t, q, u, p, h):
            h[1] = -9.81

        def gap(t, q, p, g_N):
            g_N[0] = 0.001 - math.hypot(q[0] - 0.3 * math.sin(q[2]), q[1] + 0.3 * math.cos(q[2]))

        def tangent(t, q, p, W_F):
            x, y = q[0] - 0.3 * math.sin(q[2]), q[1] + 0.3 * math.cos(q[2])
            nx, ny = -x / math.hypot(x, y), -y / math.hypot(x, y)  # from the middle of the pin to the contact
            W_F[0, 0, 0], W_F[0, 0, 1] = ny, -nx
            W_F[0, 0, 2] = -(0.01 * ny - q[1]) * ny - (0.01 * nx - q[0]) * nx

        return ns.System(n_q=3, mass=mass, force=force, gap=gap, tangent=tangent, contacts=[ns.Contact(mu="mu")],
                         parameters=self)  # fmt: skip


def farthest(mu):
    """Largest way from the vertical through the pin at which the centre of mass of the hanger rests [m]."""

    def rests(x):
        at = math.asin(x / 0.01)  # of the contact on the pin, from its top
        turn = math.asin((x + 0.001 * math.sin(at)) / 0.3)
        q = [x, -0.001 * math.cos(at) - 0.3 * math.cos(turn), turn]
        sol = ns.simulate(Hanger(mu=mu), (0, 0.05), q, [0, 0, 0], integrator=ns.MoreauJean(dt=1e-3))
        return np.abs(sol.u[-1]).max() < 1e-9

    return limit(rests, 0.0, 0.00999)


@functools.cache
def tilt(mu):
    """At the end, of a box twice as high as long that slides at 4 m/s [degrees]."""
    scene = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=mu))
    scene.fixed(ns.HalfSpace(UP))
    scene.body(ns.Box(0.6, 0.3, 1.2), density=200, position=(0, 0, 0.6), velocity=(4, 0, 0), name="box")
    w, x, y, z = ns.simulate(scene, (0, 2), integrator=STEP)["box"].turn[-1]
    return math.degrees(2 * math.atan2(math.hypot(x, y), math.hypot(w, z)))


@functools.cache
def balls_on_a_box():
    """Accelerations of a box of 10 kg, drawn by 150 N, and of 25 balls of 1 kg and 0.5 m that roll on it [m/s^2]."""
    l = ns.lagrangian("balls on a box")
    x, ball, turn = l.coordinates("x ball turn")
    xdot, balldot, turndot = l.rates
    l.kinetic(10 * xdot**2 / 2 + 25 * (balldot**2 + 0.4 * 0.5**2 * turndot**2) / 2)
    l.potential(-150 * x)
    l.contact(normal_force=35 * 9.81, slip=xdot, mu=0.4)
    l.contact(normal_force=25 * 9.81, slip=balldot - xdot - 0.5 * turndot, mu=0.8)
    fine = ns.EventDriven(rtol=1e-12, atol=1e-14)
    return ns.simulate(l.model(), (0, 4), [0, 0, 0], [0, 0, 0], integrator=fine).u[-1] / 4


IN_MUJOCO = {0.3: "3.579", 0.4: "2.112", 0.45: "1.835", 0.5: "0.359", 0.55: "1.814"}
IN_KAMINO = {0.3: "3.539", 0.4: "1.770", 0.45: "0.885", 0.5: "5e-4"}


def lean_by_statics(mu):
    """Of two cards of 90 x 2 mm [rad]."""
    b = math.atan(2 * mu)
    return b + math.asin(math.sin(b) / 90)


def rest_by_statics(mu):
    """Of what hangs on a pin of 10 mm [m]."""
    return 0.01 * math.sin(math.atan(mu))


def way_down(mu):
    """By g (sin a - mu cos a) t^2/2 with tan a = 1/2, t = 2 s [m]."""
    return 2 * 9.81 * (0.5 - mu) / math.sqrt(1.25)


def slope_row(name: str, mu: float, printed: str) -> Row:
    """The way down the slope in another simulator: from mu = 1/2 on friction holds the cube."""
    is_held = mu >= 0.5
    errs = "friction holds the cube" if is_held else f"g (sin a - mu cos a) t^2/2 is {way_down(mu):.5f} m"
    return Row(f"{name}: way down the slope, mu = {mu} [m]", printed, lambda mu=mu: slid(mu), errs=f"{name}: {errs}",
               corrected="0.00000000" if is_held else functools.partial(way_down, mu))  # fmt: skip


SECTIONS = (
    Section(
        "standing",
        "What stands, rests or tips",
        "Song, Fan, Ascher, Pai (2026, arXiv 2607.19599), dt = 1/60 s: houses of cards and arches under falling "
        "cubes stand; a box of b/h = 1/2 tips above mu = 1/2; the sizes of cards and stones are ours. Tests of a fork "
        "of PhysX, 2026: 40 real cards of 88 x 63 x 0.3 mm that lean at 65 degrees, mu = 0.8; 100 sheets of 1 mm; a "
        "pallet on a shuttle, 1 m at 0.5 m/s^2, mu = 0.5. Kang, Hwangbo, SimBenchmark: 25 balls on a box. Statics: a "
        "body hung on a pin of radius r rests where its centre of mass is within r sin(atan mu) of the vertical "
        "through the pin; two cards with edges rounded by r stand at l sin(a - b) <= r sin b, tan b = 2 mu.",
        (
            *(
                Row(f"way of the cards of a house of {levels} levels in 1 s [m]", "0",
                    lambda levels=levels: moved(house(levels)), within=1e-9, why="it stands")
                for levels in (4, 10)
            ),
            Row("way of 40 real cards in five levels in 1 s [m]", "0", lambda: moved(house(5, 0.01, **REAL)),
                within=2.2e-7, why="a thousandth of their mark, 0.25 % of a card"),
            *(
                Row(f"steepest lean of two cards, mu = {mu} [rad]", functools.partial(lean_by_statics, mu),
                    lambda mu=mu: steepest(mu))
                for mu in (0.2, 0.3, 0.5)
            ),
            *(
                Row(f"way of the stones of an arch of {n} under four cubes [m]", "0",
                    lambda n=n, thickness=thickness: arch_under_cubes(n, thickness), within=1e-3, why="it stands",
                    is_slow=n > 25)
                for n, thickness in ((25, 0.2), (101, 0.15))
            ),
            Row("overlap of 100 sheets [m]", "0", lambda: sheets(100).stats.worst_penetration, within=1e-12,
                why="exact; their mark is 20 um"),
            Row("way of 100 sheets in 1 s [m]", "0", lambda: moved(sheets(100)), within=1e-12,
                why="exact; their mark is 1 um"),
            Row("drift on the shuttle in 6 s, pallet, 60 boxes and four sheets [m]", "0", lambda: drift(pallet()),
                within=1e-6, why="the residuals of 600 steps; PhysX 14, its fork 0.72, MuJoCo 1.05 mm in 60 s",
                is_slow=True),
            *(
                Row(f"farthest rest of a hanger on a pin of 10 mm, mu = {mu} [m]",
                    functools.partial(rest_by_statics, mu), lambda mu=mu: farthest(mu))
                for mu in (0.2, 0.5, 1.0)
            ),
            *(
                Row(f"tilt of the box that slid, mu = {mu} [degrees]", printed, lambda mu=mu: tilt(mu), within=1e-4,
                    why="it slides" if printed == "0" else "it lies on its side")
                for mu, printed in ((0.49, "0"), (0.51, "90"))
            ),
            Row("SimBenchmark: acceleration of the box [m/s^2]", "0.7385", lambda: balls_on_a_box()[0]),
            Row("SimBenchmark: acceleration of the balls [m/s^2]", "0.211", lambda: balls_on_a_box()[1]),
        ),
        (house, moved, limit, steepest, arch_under_cubes, sheets, shuttled, pallet, drift, Hanger, farthest, tilt,
         balls_on_a_box),
    ),
    Section(
        "other-simulators",
        "The same scenes in other simulators",
        "The paper's comparison, its figures for MuJoCo and Kamino (GPU RTX 3090), and runs of its author kept by "
        "DART, pull request 3377 (2026): the way down a slope of atan 1/2 in 2 s, the ball with backspin, and whether "
        "houses and arches stand (1) or fall (0). Their files are not open: the sizes are ours.",
        (
            *(
                slope_row(name, mu, printed)
                for name, ways in (("MuJoCo", IN_MUJOCO), ("Kamino", IN_KAMINO))
                for mu, printed in ways.items()
            ),
            Row("MuJoCo: speed of the ball that rolls back [m/s]", "-13.73",
                lambda: ball_with_backspin().velocity[-1, 0], corrected="-80/7",
                errs="MuJoCo: by its momentum about the ground it rolls at (5 v + 2 r w)/7 = -80/7 m/s"),
            *(
                Row(f"{name}: {what} stands", "0", ours, corrected="1", errs=f"{name} lets it fall",
                    is_slow="101" in what)
                for name, what, ours in (
                    ("MuJoCo", "a house of 5 levels", lambda: moved(house(5)) < 1e-9),
                    ("MuJoCo", "a house of 10 levels", lambda: moved(house(10)) < 1e-9),
                    ("MuJoCo", "an arch of 25", lambda: arch_under_cubes(25, 0.2) < 1e-3),
                    ("MuJoCo", "an arch of 101", lambda: arch_under_cubes(101, 0.15) < 1e-3),
                    ("Kamino", "an arch of 101", lambda: arch_under_cubes(101, 0.15) < 1e-3),
                )
            ),
        ),
        (way_down,),
    ),
)  # fmt: skip
