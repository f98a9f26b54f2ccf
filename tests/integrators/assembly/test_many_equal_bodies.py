"""Bodies of equal shapes are weighed once: each is the one that it is in a scene of its own."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.integrators.assembly.world import World
from nonsmooth.scenes.inertia import mass_of_shape, spread_evenly

TETRAHEDRON = ns.Polyhedron([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 2)])
BOX, ARM = ns.Box(0.2, 0.3, 0.4), ns.Compound((ns.Sphere(0.1), (0, 0, 0)), (ns.Box(0.1, 0.1, 0.5), (0.3, 0, 0)))
TURN = (np.cos(0.3), np.sin(0.3), 0.0, 0.0)
SPATIAL_BODIES = [
    {"shape": ns.Sphere(0.1), "density": 1000.0},
    {"shape": ns.Sphere(0.1), "density": 500.0},
    {"shape": ns.Sphere(0.1), "mass": 3.0, "spin": (1, 2, 3)},
    {"shape": TETRAHEDRON, "density": 100.0, "turn": TURN},
    {"shape": TETRAHEDRON, "mass": 2.0, "turn": TURN},
    {"shape": TETRAHEDRON, "mass": 2.0, "inertia": (1, 2, 2.5), "centre": (0.1, 0.2, 0.3), "turn": TURN},
    {"shape": BOX, "mass": 2.0, "surface_velocity": (1, 0, 0), "turn": TURN},
    {"shape": ns.Box(0.2, 0.3, 0.4), "mass": 2.0, "inertia": (1, 1, 1)},
    {"shape": ARM, "density": 700.0, "velocity": (1, 2, 3)},
    {"shape": ARM, "density": 700.0, "centre": (0.3, 0, 0), "inertia": np.diag((1.0, 2.0, 2.0)) + 0.1},
]
PLANAR_BODIES = [
    {"shape": ns.Disc(0.1), "density": 1000.0},
    {"shape": ns.Disc(0.1), "mass": 3.0, "spin": 2.0, "turn": 0.3},
    {"shape": ns.Polygon([(0, 0), (1, 0), (0, 1)]), "mass": 2.0, "turn": 0.5},
    {"shape": ns.Polygon([(0, 0), (1, 0), (0, 1)]), "mass": 2.0, "inertia": 1.0, "centre": (0.2, 0.2)},
]


@pytest.mark.parametrize("gravity, listed", [((0, 0, -9.81), SPATIAL_BODIES), ((0, -9.81), PLANAR_BODIES)])
def test_a_body_among_many_is_that_of_a_scene_of_its_own(gravity, listed):
    n, d = len(listed), len(gravity)
    order = np.random.default_rng(2).permutation(np.repeat(np.arange(n), 3))
    scene = ns.Scene(gravity=gravity)
    for place, k in enumerate(order):
        scene.body(**listed[k], position=np.arange(d) + 3.0 * place)
    world, first = World(scene, 0.0), 0
    for b, k in enumerate(order):
        alone = ns.Scene(gravity=gravity)
        alone.body(**listed[k], position=np.arange(d) + 3.0 * b)
        mass_of_shape.cache_clear(), spread_evenly.cache_clear()
        own = World(alone, 0.0)
        for block, single in ((world.bodies, own.bodies), (world.bodies.motion, own.bodies.motion)):
            for name in ("mass", "moments", "surface") if block is world.bodies else ("x", "v", "moves"):
                np.testing.assert_array_equal(getattr(block, name)[b], getattr(single, name)[0])
        rows = slice(first, first + len(own.shapes.kind))
        assert (world.shapes.body[rows] == b).all()
        for name in ("kind", "place", "radius", "size", "reach", "count"):
            np.testing.assert_array_equal(getattr(world.shapes, name)[rows], getattr(own.shapes, name))
        first = rows.stop
    assert first == len(world.shapes.kind)
