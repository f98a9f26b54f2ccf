"""What is found of a pair does not depend on which body is named first, nor on how the whole is turned or mirrored."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.detection import FEATURE_BITS
from nonsmooth.scenes.spatial.core import EDGES, NEAREST_POINTS, TWO_EDGES, VERTEX_OF_J
from tests.scenes.spatial.test_brute_force import aligned_places, brought_together
from tests.scenes.spatial.test_solids import EVERYTHING, NAMES, nearest_contacts, pair_of, random_places, shape_of

PAIRS = list(itertools.combinations_with_replacement(NAMES, 2))
EVEN = ("cube", "gem", "wedge", "box", "capsule", "sphere")  # whose normals are known to rounding
MIRROR = np.array([-1.0, 1, 1])


def touching_places(scene, rng, n):
    """Places of pairs that touch, of which a half have axes in common, and a fourth are pressed by 1e-6."""
    x = np.concatenate((random_places(rng, n // 2, 1.6), aligned_places(rng, n - n // 2)))
    for k in range(n):
        x[k] = brought_together(scene, x[k])
    x[::4, 1, :3] += 1e-6 * rng.normal(size=(len(x[::4]), 3))
    return x


def of_the_other(feature):
    """The feature (i, j) as one of (j, i)."""
    if feature >= TWO_EDGES:
        edge_i, edge_j = divmod(feature - TWO_EDGES, EDGES)
        return feature if feature == NEAREST_POINTS else TWO_EDGES + EDGES * edge_j + edge_i
    return feature - VERTEX_OF_J if feature >= VERTEX_OF_J else feature + VERTEX_OF_J


def points_of(scene, x, margin):
    """What is found, in the order of features (0 of two spheres): gap, normal and point a row."""
    scene.motion.x[:] = x
    gap, normal, point, key = scene.contacts(margin=margin)
    return np.column_stack((gap, normal, point)), [int(k) & ((1 << FEATURE_BITS) - 1) for k in key]


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_which_of_two_bodies_is_named_first_changes_no_contact(names, spatial):
    """11,000 places, apart, touching and deep, turned at random and with axes in common; spheres to rounding, all else
    to the bit. Edges of cylinders once had normals that differed by 1e-5, and another number of points."""
    one, two = (shape_of(name) for name in names)
    there, back = pair_of(spatial, one, two), pair_of(spatial, two, one)
    rng = np.random.default_rng(PAIRS.index(names))
    free = np.concatenate((random_places(rng, 40, 1.6), random_places(rng, 40, 0.5), aligned_places(rng, 60)))
    touching = touching_places(there, rng, 60)
    rounding = 8 * EPS if "sphere" in names else 0.0
    for places, margin in ((free, EVERYTHING), (touching, 0.02)):
        for x in places:
            points, features = points_of(there, x, margin)
            others, exchanged = points_of(back, x[::-1], margin)
            exchanged = exchanged if names == ("sphere", "sphere") else [of_the_other(f) for f in exchanged]
            assert sorted(exchanged) == features
            others[:, 1:4] *= -1.0
            np.testing.assert_allclose(points, others[np.argsort(exchanged)], rtol=0, atol=rounding)


@pytest.mark.parametrize("names", list(itertools.combinations_with_replacement(EVEN, 2)), ids="-".join)
def test_gaps_and_normals_turn_with_the_whole_pair_by_a_quarter(names, spatial):
    scene, rng = pair_of(spatial, *(shape_of(name) for name in names)), np.random.default_rng(4)
    x = random_places(rng, 80, 1.2)[10:]  # beside parallel ones, whose nearest faces are several
    gap, normal, *_ = nearest_contacts(scene, x)
    for axis in np.eye(3):
        quarter, turned = Rotation.from_rotvec(np.pi / 2 * axis), x.copy()
        for b in (0, 1):
            turned[:, b, :3] = quarter.apply(x[:, b, :3])
            turned[:, b, 3:] = (quarter * Rotation.from_quat(x[:, b, [4, 5, 6, 3]])).as_quat()[:, [3, 0, 1, 2]]
        again, turned_normal, *_ = nearest_contacts(scene, turned)
        assert np.abs(again - gap).max() < 1e-12
        assert np.abs(turned_normal - quarter.apply(normal)).max() < 1e-10


@pytest.mark.parametrize(
    "names", list(itertools.combinations_with_replacement(("box", "capsule", "sphere"), 2)), ids="-".join
)
def test_gaps_and_normals_of_mirrored_pairs_are_mirrored(names, spatial):
    """Of shapes that are their own mirror images: a turn by (w, x, y, z) is one by (w, x, -y, -z) in the mirror."""
    scene, rng = pair_of(spatial, *(shape_of(name) for name in names)), np.random.default_rng(5)
    x = random_places(rng, 160, 1.2)[20:]
    mirrored = x * np.concatenate((MIRROR, (1, 1, -1, -1)))
    gap, normal, *_ = nearest_contacts(scene, x)
    again, mirrored_normal, *_ = nearest_contacts(scene, mirrored)
    assert np.abs(again - gap).max() < 1e-12
    assert np.abs(mirrored_normal - MIRROR * normal).max() < 1e-10
