"""Springs in pictures: their ends go with the bodies, also of shapes whose centre is not their origin."""

import math

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.drawing.spring_lines import coil, spring_lines


def turning(dim):
    """A body that turns freely about its centre by 1 rad/s, held by a spring too weak to matter."""
    scene = ns.Scene(gravity=(0.0,) * dim)
    shape = ns.Polygon([(0, 0), (0.4, 0), (0, 0.4)]) if dim == 2 else ns.Box(0.2, 0.2, 0.2)
    spin = 1.0 if dim == 2 else (0, 0, 1.0)
    scene.fixed(ns.Disc(0.1) if dim == 2 else ns.Sphere(0.1), position=(2.0,) + (0.0,) * (dim - 1), name="post")
    scene.body(shape, mass=1.0, spin=spin, name="body")
    scene.spring("post", "body", at_b=(0.1,) * 2 + (0.0,) * (dim - 2), stiffness=1e-9)
    scene.spring("post", "body", stiffness=1e-9)
    return ns.simulate(scene, (0, 1), integrator=ns.MoreauJean(1e-3))


@pytest.mark.parametrize("dim", [2, 3])
def test_the_ends_of_a_spring_go_with_its_bodies(dim):
    sol = turning(dim)
    (first, second), (post, centre) = spring_lines(sol, -1)
    middle = sol["body"].position[-1]
    c, s = math.cos(1.0), math.sin(1.0)
    x, y = np.array([0.1, 0.1]) - sol["body"].position[0][:2]
    np.testing.assert_allclose(second[:2], middle[:2] + [c * x - s * y, s * x + c * y], atol=1e-6)
    np.testing.assert_allclose(first, [2.0] + [0.0] * (dim - 1))
    np.testing.assert_allclose(centre, middle)
    assert (post == first).all()


def test_a_coil_goes_from_end_to_end_and_is_as_wide_as_asked():
    ends = np.array([[1.0, 2.0], [4.0, 6.0]])
    line = coil(ends, 0.3)
    np.testing.assert_allclose(line[[0, -1]], ends)
    across = (line - ends[0]) @ np.array([-0.8, 0.6])
    assert across.max() == pytest.approx(0.15) and across.min() == pytest.approx(-0.15)


def test_a_picture_shows_a_line_for_each_spring():
    figure = turning(2).picture(times=(1.0,))
    lines = [line for axes in figure.axes for collection in axes.collections for line in collection.get_paths()]
    ends = [line.vertices[0] for line in lines]
    assert sum(np.allclose(end, (2.0, 0.0)) for end in ends) >= 2
