"""A hull over a half-plane: the height of each vertex."""

import numpy as np

from nonsmooth.numerics.rounding import EPS


def test_every_vertex_near_the_ground_is_a_point(planar, shape):
    angle, ground = 0.3, 0.1
    for first in (True, False):
        rows = [shape.box(0, 0.5, 0.2, 0.05), shape.half_plane(1)] if first else [
            shape.half_plane(0), shape.box(1, 0.5, 0.2, 0.05)]  # fmt: skip
        x = np.array([(0.2, 0.5, angle), (7.0, 3.0, ground)])
        gap, normal, point, key = planar(rows, x if first else x[::-1]).contacts(margin=5.0)
        c, s = np.cos(angle), np.sin(angle)
        corners = (
            np.array([(-0.5, -0.2), (0.5, -0.2), (0.5, 0.2), (-0.5, 0.2)]) @ np.array([[c, s], [-s, c]]) + x[0, :2]
        )
        n = np.array([-np.sin(ground), np.cos(ground)])
        height = (corners - x[1, :2]) @ n
        assert np.abs(gap - (height - 0.05)).max() < 16 * EPS
        assert np.abs(normal - (-n if first else n)).max() < EPS
        assert np.abs(point - (corners - 0.5 * (height[:, None] + 0.05) * n)).max() < 16 * EPS
        assert (np.diff(key) > 0).all()


def test_only_the_points_within_the_margin_are_kept(planar, shape):
    scene = planar([shape.box(0), shape.half_plane(1)], [(0, 0.5, 1e-2), (0, 0, 0)])
    assert len(scene.contacts(margin=4e-3)[0]) == 1
    assert len(scene.contacts(margin=8e-3)[0]) == 2
    assert len(scene.contacts(margin=2.0)[0]) == 4


def test_a_disc_far_above_the_ground_does_not_touch(planar, shape):
    assert len(planar([shape.disc(0), shape.half_plane(1)], [(0, 3, 0), (0, 0, 0)]).contacts()[0]) == 0
