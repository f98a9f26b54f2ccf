"""A floor of flush pieces is one floor: what slides, rolls and tumbles over seams moves as it does without them.

The runs of a floor of pieces and of one floor have the same contacts, to rounding of the places of the pieces; what the
contact problems leave of that are roundings, too, of islands that are solved exactly. 1e-9 m is asked for, 1e-8 m of
ellipsoids, whose normal is known to 1e-6, and of pieces of unlike height. Where impulses of faces are not unique a
rounding may find others: 1e-5 m of boxes that tumble in space. What spins upon loose pieces in space is not asked, nor
are ellipsoids on them (docs/theory/scenes.md).
"""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns

SAME, NEARLY_SAME, SAME_TUMBLING = 1e-9, 1e-8, 1e-5  # [m]
LENGTH, DEPTH = 24.0, 0.2  # [m] of a floor
LOWER = 2e-15  # [m] by which every third piece is lower than the others: a rounding of places of some metres


def floor(dim, belt=0.0):
    """One floor with its top at zero, which runs like a belt."""
    s = ns.Scene(gravity=(0.0, -9.81) if dim == 2 else (0.0, 0.0, -9.81), material=ns.Material(mu=0.2))
    shape = ns.Box(LENGTH, DEPTH) if dim == 2 else ns.Box(LENGTH, 6.0, DEPTH)
    s.fixed(shape, position=at(0.0, -0.5 * DEPTH, dim), surface_velocity=at(belt, 0.0, dim))
    return s


def at(x, height, dim, y=0.0):
    return (x, height) if dim == 2 else (x, y, height)


def row(dim, length=0.25, kind="fixed"):
    """Boxes in a row, fixed or loose upon a plane."""
    s = floor(dim, -1.0 if kind == "belts" else 0.0)
    pieces = ns.Scene(gravity=s.gravity, material=s.material)
    if kind == "loose":
        pieces.fixed(ns.HalfPlane((0, 1), -DEPTH) if dim == 2 else ns.HalfSpace((0, 0, 1), -DEPTH))
    for k in range(-6, int(7.0 / length)):
        shape = ns.Box(length, DEPTH) if dim == 2 else ns.Box(length, 6.0, DEPTH)
        place = at((k + 0.5) * length, -0.5 * DEPTH - LOWER * (k % 3 == 0) * (kind == "uneven"), dim)
        if kind == "loose":
            pieces.body(shape, mass=50.0, position=place)
        elif kind == "belts":
            pieces.fixed(shape, position=place, surface_velocity=at(-1.0, 0.0, dim))
        else:
            pieces.fixed(shape, position=place)
    return s, pieces


def prisms():
    """A flat terrain of triangles and trapezia."""
    s = floor(2)
    pieces = ns.Scene(gravity=s.gravity, material=s.material)
    for k in range(-6, 30):
        x = 0.25 * k
        pieces.fixed(ns.Polygon([(x, 0), (x, -0.2), (x + 0.25, -0.2)]))
        pieces.fixed(ns.Polygon([(x, 0), (x + 0.25, -0.2), (x + 0.25, 0)]))
    return s, pieces


def compound(dim):
    """One body of many boxes."""
    s = floor(dim)
    pieces = ns.Scene(gravity=s.gravity, material=s.material)
    shape = ns.Box(0.25, DEPTH) if dim == 2 else ns.Box(0.25, 6.0, DEPTH)
    pieces.fixed(ns.Compound(*((shape, at(0.25 * k, -0.5 * DEPTH, dim)) for k in range(-6, 30))))
    return s, pieces


def segments():
    """A flat chain of segments."""
    s = floor(2)
    pieces = ns.Scene(gravity=s.gravity, material=s.material)
    for k in range(-6, 30):
        pieces.fixed(ns.Segment((0.25 * k, 0.0), (0.25 * (k + 1), 0.0)))
    return s, pieces


def grid(width=0.4, shift=0.0):
    """Squares in rows and columns; bricks where every second row is shifted."""
    s = floor(3)
    pieces = ns.Scene(gravity=s.gravity, material=s.material)
    for a in range(-4, 14):
        for b in range(-5, 6):
            pieces.fixed(ns.Box(width, width, DEPTH), position=(width * (a + shift * (b % 2)), width * b, -0.5 * DEPTH))
    return s, pieces


def hulls():
    """Prisms of two triangles each in a grid."""
    s = floor(3)
    pieces = ns.Scene(gravity=s.gravity, material=s.material)
    w = 0.5
    for a in range(-3, 12):
        for b in range(-3, 4):
            x, y = a * w, b * w
            for corners in (((x, y), (x + w, y), (x + w, y + w)), ((x, y), (x + w, y + w), (x, y + w))):
                pieces.fixed(ns.Polyhedron([(p, q, z) for p, q in corners for z in (-DEPTH, 0.0)]))
    return s, pieces


def difference(scenes, shape, dt, t_end=0.6, **state):
    """How far the ways of a body on two floors part [m]."""
    ways = []
    for s in scenes:
        s.body(shape, mass=1.0, name="b", **state)
        sol = ns.simulate(s, (0.0, t_end), integrator=ns.MoreauJean(dt=dt))
        ways.append(sol["b"].position)
        assert sol.stats.worst_residual <= 1e-7
    assert np.abs(ways[0][-1] - ways[0][0]).max() > 0.1
    return np.abs(ways[0] - ways[1]).max()


LAYOUTS_2 = {
    "row": lambda: row(2),
    "short pieces": lambda: row(2, 0.07),
    "uneven": lambda: row(2, kind="uneven"),
    "belts": lambda: row(2, kind="belts"),
    "loose": lambda: row(2, 0.5, kind="loose"),
    "prisms": prisms,
    "compound": lambda: compound(2),
    "segments": segments,
}
SHAPES_2 = {
    "box": (ns.Box(0.2, 0.1), 0.05),
    "polygon": (ns.Polygon([(-0.1, -0.05), (0.1, -0.05), (0.15, 0.05), (0.0, 0.12)]), 0.05),
    "disc": (ns.Disc(0.1), 0.1),
    "capsule": (ns.Capsule(0.1, 0.05), 0.05),
}


@pytest.mark.upkeep
@pytest.mark.parametrize("shape", SHAPES_2)
@pytest.mark.parametrize("layout", LAYOUTS_2)
def test_plane(layout, shape):
    body, height = SHAPES_2[shape]
    for dt, speed in ((1e-3, 4.0), (3.1e-3, 2.3)):
        state = {"position": (0.013, height), "velocity": (speed, 0.0)}
        assert difference(LAYOUTS_2[layout](), body, dt, **state) <= SAME


@pytest.mark.upkeep
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("layout", ["row", "short pieces", "prisms", "compound"])
def test_tumbling_in_the_plane(layout, seed):
    rng = np.random.default_rng(seed)
    body = (ns.Box(0.2, 0.1), SHAPES_2["polygon"][0], ns.Capsule(0.2, 0.03))[seed % 3]
    state = {
        "position": (0.0, 0.3),
        "velocity": (rng.uniform(1, 4), 0.0),
        "spin": rng.uniform(-9, 9),
        "turn": rng.uniform(0, 6),
    }
    assert difference(LAYOUTS_2[layout](), body, (1e-3, 2e-3)[seed % 2], 0.8, **state) <= SAME


LAYOUTS_3 = {
    "row": lambda: row(3),
    "uneven": lambda: row(3, kind="uneven"),
    "loose": lambda: row(3, 0.5, kind="loose"),
    "compound": lambda: compound(3),
    "grid": grid,
    "bricks": lambda: grid(shift=0.5),
    "hulls": hulls,
}
UPRIGHT = (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0)
SHAPES_3 = {
    "box": (ns.Box(0.2, 0.15, 0.1), 0.05, {}),
    "hull": (ns.Polyhedron([(x, y, z) for x in (-0.1, 0.1) for y in (-0.08, 0.08) for z in (-0.05, 0.05)]), 0.05, {}),
    "cylinder": (ns.Cylinder(0.1, 0.1), 0.05, {"turn": UPRIGHT}),
    "sphere": (ns.Sphere(0.1), 0.1, {}),
    "ellipsoid": (ns.Ellipsoid(0.12, 0.1, 0.06), 0.06, {}),
}


@pytest.mark.upkeep
@pytest.mark.parametrize("shape", SHAPES_3)
@pytest.mark.parametrize("layout", LAYOUTS_3)
def test_space(layout, shape):
    body, height, turn = SHAPES_3[shape]
    for dt, velocity, spin in ((1e-3, (4.0, 0.0, 0.0), (0, 0, 0)), (2.3e-3, (2.0, 0.3, 0.0), (0, 0, 0.5))):
        if layout == "loose" and (shape == "ellipsoid" or (any(spin) and shape != "sphere")):
            continue
        state = {"position": (0.013, 0.021, height), "velocity": velocity, "spin": spin, **turn}
        assert difference(LAYOUTS_3[layout](), body, dt, 0.4, **state) <= (
            NEARLY_SAME if shape == "ellipsoid" or layout == "uneven" else SAME
        )


@pytest.mark.upkeep
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.ResidualWarning")
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("layout", ["row", "grid", "bricks"])
def test_tumbling_in_space(layout, seed):
    rng = np.random.default_rng(seed)
    turn = rng.normal(size=4)
    state = {
        "velocity": (rng.uniform(1, 3), rng.uniform(-1, 1), 0.0),
        "spin": rng.uniform(-5, 5, 3),
        "turn": turn / np.linalg.norm(turn),
    }
    assert (
        difference(LAYOUTS_3[layout](), ns.Box(0.2, 0.15, 0.1), 1e-3, 0.5, position=(0.0, 0.0, 0.25), **state)
        <= SAME_TUMBLING
    )


@pytest.mark.parametrize("n", [3, 12])
def test_layers_hide_what_is_behind_them(n):
    """Of n sheets of 1 mm upon a floor, 4 contacts each can touch."""
    s = ns.Scene(gravity=(0, 0, -9.81), material=ns.Material(mu=0.5))
    s.fixed(ns.HalfSpace((0, 0, 1)))
    for i in range(n):
        s.body(ns.Box(0.2, 0.2, 0.001), mass=0.001, position=(0, 0, 0.0005 * (2 * i + 1)))
    sol = ns.simulate(s, (0, 0.1), integrator=ns.MoreauJean(dt=0.01))
    assert sol.stats.most_contacts == 4 * n
    assert np.abs(sol.position[-1] - sol.position[0]).max() <= 1e-12


def test_neighbours_on_a_plank_keep_their_corners():
    """Two boxes side by side on a plank: what is hidden for the plank holds them."""
    s = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.5))
    s.fixed(ns.HalfPlane((0, 1)))
    s.body(ns.Box(1.0, 0.1), mass=1.0, position=(0, 0.05))
    s.body(ns.Box(0.2, 0.2), mass=1.0, position=(-0.1, 0.2))
    s.body(ns.Box(0.2, 0.2), mass=1.0, position=(0.1, 0.2))
    sol = ns.simulate(s, (0, 0.5), integrator=ns.MoreauJean(dt=1e-3))
    assert np.abs(sol.q[-1] - sol.q[0]).max() <= 1e-12


def test_a_foot_in_the_corner_of_a_block_and_the_floor_is_stopped():
    """A rod whose foot slides along the floor is stopped by the face of a block, at its edge."""
    s = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.1))
    s.fixed(ns.Box(4.0, 0.2), position=(0, -0.1))
    s.fixed(ns.Box(0.2, 0.3), position=(0.5, 0.15))
    s.body(ns.Box(0.4, 0.04), mass=1.0, position=(0.0, 0.16), turn=-0.8, velocity=(3.0, 0.0), name="rod")
    sol = ns.simulate(s, (0, 0.6), integrator=ns.MoreauJean(dt=1e-3))
    assert sol.penetration.max() <= 1e-3
    assert sol["rod"].position[:, 0].max() <= 0.4


ROOF = {
    "disc": (ns.Disc(0.1), (-0.8, 0.35), (2.5, 0.0)),
    "box that rests on it": (ns.Box(0.4, 0.1), (0.03, 0.4), (0.0, 0.0)),
    "box that slides up": (ns.Box(0.4, 0.1), (-0.8, 0.4), (2.0, 0.0)),
}


@pytest.mark.parametrize("body", ROOF)
def test_a_ridge_between_two_pieces_still_acts(body):
    """What two prisms hide of one another is their inner faces, and not the edge that stands out between them."""
    shape, position, velocity = ROOF[body]
    left, right = [(-2, -1), (0, -1), (0, 0.3), (-2, 0)], [(0, -1), (2, -1), (2, 0), (0, 0.3)]
    ways = []
    for pieces in ((left, right), ([(-2, -1), (2, -1), (2, 0), (0, 0.3), (-2, 0)],)):
        s = ns.Scene(gravity=(0, -9.81), material=ns.Material(mu=0.3))
        for corners in pieces:
            s.fixed(ns.Polygon(corners))
        s.body(shape, mass=1.0, position=position, velocity=velocity, name="b")
        sol = ns.simulate(s, (0, 0.8), integrator=ns.MoreauJean(dt=1e-3))
        assert sol.penetration.max() <= 1e-5
        ways.append(sol["b"].position)
    assert np.abs(ways[0] - ways[1]).max() <= SAME
