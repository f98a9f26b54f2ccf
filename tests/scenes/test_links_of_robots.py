"""Links of robots as bodies: hulls of many corners, and carriers between the coordinates of one link."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.scenes.convex_hull import hull_points
from nonsmooth.scenes.mass_properties import Mass
from nonsmooth.scenes.places import ORIGIN
from nonsmooth.scenes.robots.links import Coordinate, Link, add_links


@pytest.mark.parametrize("flat", [1.0, 0.01])
def test_a_hull_of_many_corners_is_taken_by_the_widest_ones(flat):
    points = np.random.default_rng(3).normal(size=(2000, 3))
    points *= (np.array((1.0, 1.0, flat)) / np.linalg.norm(points, axis=1)[:, None]).reshape(-1, 3)
    corners, out = hull_points(points, 100)
    hull = ns.Polyhedron(corners)
    assert len(hull.vertices) == len(corners) == 100
    farthest = 0.0
    for face in hull.faces:
        p, q, r = hull.vertices[list(face[:3])]
        normal = np.cross(q - p, r - p)
        farthest = max(farthest, ((points - p) @ (normal / np.linalg.norm(normal))).max())
    assert farthest == pytest.approx(out, rel=1e-9)
    assert out < 0.06  # a hundred points on a ball leave caps of 1 - cos of 2/sqrt(100), some twice as wide as others
    assert hull_points(points, 3000)[1] == 0.0


def test_a_link_with_three_hinges_has_two_carriers_that_touch_nothing_and_keep_its_mass():
    axes = np.eye(3)
    link = Link("thigh", ORIGIN[3], shapes=[(ns.Sphere(0.1), ORIGIN[3])])
    link.masses = [Mass(2.0, np.array((0, 0, -0.2)), np.diag((0.02, 0.03, 0.01)))]
    link.coordinates = [Coordinate(name, "hinge", np.zeros(3), axis) for name, axis in zip("xyz", axes, strict=True)]
    scene = ns.Scene(gravity=(0, 0, -9.81))
    (body,) = add_links(scene, [link], lambda i, j: True)
    scene.fixed(ns.HalfSpace((0, 0, 1)), position=(0, 0, -0.15), name="ground")
    names = [one.name for one in scene.bodies]
    assert names == ["world", "thigh on x", "thigh on y", "thigh", "ground"]
    assert sum(one.mass for one in scene.bodies if one.mass) == pytest.approx(2.0, rel=1e-12)
    assert body.mass == pytest.approx(2.0, rel=3e-5)
    apart = {frozenset(one.name for one in pair) for pair in scene.apart()}
    assert {frozenset(("thigh", "thigh on x")), frozenset(("thigh", "world"))} <= apart
