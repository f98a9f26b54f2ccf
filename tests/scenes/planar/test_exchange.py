"""What is found of a pair does not depend on which body is named first, nor on how the whole is turned or mirrored."""

import itertools

import numpy as np
import pytest

from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.detection import FEATURE_BITS
from tests.scenes.planar.test_hulls import EVERYTHING, bank, random_places
from tests.scenes.spatial.test_brute_force import brought_together

NAMES = ("disc", "capsule", "segment", "box", "rounded box", "triangle", "heptagon", "needle")
PAIRS = list(itertools.combinations_with_replacement(NAMES, 2))


def touching_places(scene, rng, n):
    """Places of pairs brought together along their normals, a half with edges in common."""
    x = random_places(rng, n)
    x[::2, 1, 2] = x[::2, 0, 2] + np.pi / 2 * rng.integers(4, size=len(x[::2]))
    for k in range(n):
        x[k] = brought_together(scene, x[k])
    return x


def points_of(scene, x, margin):
    """What is found, in the order of features: gap, normal and point a row."""
    scene.motion.x[:] = x
    gap, normal, point, key = scene.contacts(margin=margin)
    return np.column_stack((gap, normal, point)), [int(k) & ((1 << FEATURE_BITS) - 1) for k in key]


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_which_of_two_bodies_is_named_first_changes_no_contact(names, planar, shape):
    """10,800 places; discs to rounding, all else to the bit. Corners that met had the normal of a face of the first."""
    one, two = (bank(shape)[name] for name in names)
    there, back = planar([one(0), two(1)], np.zeros((2, 3))), planar([two(0), one(1)], np.zeros((2, 3)))
    rng = np.random.default_rng(PAIRS.index(names))
    free = np.concatenate((random_places(rng, 100), random_places(rng, 100, 0.5)))
    rounding = 4 * EPS if names == ("disc", "disc") else 0.0
    for places, margin in ((free, EVERYTHING), (touching_places(there, rng, 100), 0.02)):
        for x in places:
            points, features = points_of(there, x, margin)
            others, exchanged = points_of(back, x[::-1], margin)
            exchanged = exchanged if names == ("disc", "disc") else [f ^ 1 for f in exchanged]
            assert sorted(exchanged) == features
            others[:, 1:3] *= -1.0
            np.testing.assert_allclose(points, others[np.argsort(exchanged)], rtol=0, atol=rounding)


def least(scene, x):
    """The gap and the normal of the nearest point at each of the places."""
    found = []
    for places in x:
        scene.motion.x[:] = places
        gap, normal, *_ = scene.contacts(margin=EVERYTHING)
        found.append((gap.min(), *normal[gap.argmin()]))
    return np.array(found)


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_gaps_and_normals_turn_with_the_whole_pair_by_a_quarter(names, planar, shape):
    scene = planar([bank(shape)[names[0]](0), bank(shape)[names[1]](1)], np.zeros((2, 3)))
    x = random_places(np.random.default_rng(4), 100)
    gap, n_x, n_y = least(scene, x).T
    turned = np.stack([-x[:, :, 1], x[:, :, 0], x[:, :, 2] + np.pi / 2], axis=2)
    np.testing.assert_allclose(least(scene, turned), np.stack([gap, -n_y, n_x], axis=1), atol=1e-12)


@pytest.mark.parametrize("names", list(itertools.combinations_with_replacement(NAMES[:5], 2)), ids="-".join)
def test_gaps_and_normals_of_mirrored_pairs_are_mirrored(names, planar, shape):
    """Of shapes that are their own mirror images."""
    scene = planar([bank(shape)[names[0]](0), bank(shape)[names[1]](1)], np.zeros((2, 3)))
    x = random_places(np.random.default_rng(5), 100)
    np.testing.assert_allclose(least(scene, x * [-1, 1, -1]), least(scene, x) * [1, -1, 1], atol=1e-12)
