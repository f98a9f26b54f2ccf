"""Random worlds of bodies of sizes from 1e-3 to 1e3, some of them fast: the contacts found are those of all pairs."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.jit import load_all
from nonsmooth.jit.blocks import new
from nonsmooth.scenes.detection import Found, Motion
from nonsmooth.scenes.parts import parts_of
from nonsmooth.scenes.places import ORIGIN
from nonsmooth.scenes.planar import find_contacts as planar
from nonsmooth.scenes.planar.placement import planar_scratch
from nonsmooth.scenes.shape_rows import shape_block
from nonsmooth.scenes.spatial import find_contacts as spatial
from nonsmooth.scenes.spatial.placement import spatial_scratch
from nonsmooth.scenes.spatial.solids import further_points, solid_contact

MARGIN, DT = 1e-3, 1e-2
EVERYTHING = 1e12  # margin: every pair is found


def planar_shape(rng, size):
    a, b = size * rng.uniform(0.3, 1.0, 2)
    shapes = [ns.Disc(a), ns.Box(2 * a, b), ns.Capsule(2 * a, 0.3 * b), ns.Polygon([(-a, 0), (a, -b), (a, b)], 0.1 * a)]
    return shapes[rng.integers(len(shapes))]


def spatial_shape(rng, size):
    a, b, c = size * rng.uniform(0.3, 1.0, 3)
    kinds = [
        lambda: ns.Sphere(a),
        lambda: ns.Box(2 * a, b, c),
        lambda: ns.Capsule(2 * a, 0.3 * b),
        lambda: ns.Cylinder(a, b),
        lambda: ns.Ellipsoid(a, b, c),
        lambda: ns.Polyhedron(size * rng.normal(size=(9, 3))),
    ]
    return kinds[rng.integers(len(kinds))]()


class World:
    """Bodies of one or two parts, crowded about a few places, a tenth of them fast; two grounds."""

    def __init__(self, dim, n, seed):
        rng = np.random.default_rng(seed)
        sizes = 10 ** rng.uniform(-3, 3, n)
        shape_of = planar_shape if dim == 2 else spatial_shape
        self.dim, self.bodies = dim, []
        for b in range(n):
            for k in range(1 + (b % 5 == 0)):
                frame = ORIGIN[dim].copy()
                frame[0] += k * sizes[b]
                (part,) = parts_of(shape_of(rng, sizes[b]), dim)
                self.bodies.append((b, part, frame))
        ground = ns.HalfPlane((0.1, 1)) if dim == 2 else ns.HalfSpace((0.1, 0, 1))
        self.bodies += [(n, parts_of(ground, dim)[0], ORIGIN[dim])]
        self.x = np.tile(ORIGIN[dim], (n + 1, 1))
        self.x[:n, :dim] = rng.normal(size=(n, dim)) * (3 * sizes[:, None])
        self.x[: n // 4, :dim] = self.x[n // 4 : n // 2, :dim][: n // 4]  # some are where others are
        self.x[1:n:7, :dim] *= 1e2
        turns = rng.normal(size=(n, 1 if dim == 2 else 4))
        self.x[:n, dim:] = turns if dim == 2 else turns / np.linalg.norm(turns, axis=1, keepdims=True)
        fast = 10 ** rng.uniform(-2, 5, (n, 1)) * (rng.random((n, 1)) < 0.1)
        self.v = np.zeros((n + 1, 3 if dim == 2 else 6))
        self.v[:n] = rng.normal(size=(n, self.v.shape[1])) * (sizes[:, None] + fast)
        self.moves = np.ones(n + 1, dtype=int)
        self.moves[n], self.moves[::9] = 0, 0

    def contacts(self, shown, bodies, margin=MARGIN):
        """What is found among some of the shapes: gap, normal and point, by shapes and features."""
        rows = [part.row(bodies.index(body), frame) for body, part, frame in (self.bodies[s] for s in shown)]
        shapes = shape_block(rows)
        motion = new(Motion, n_b=len(bodies), n_x=self.x.shape[1], n=self.v.shape[1])
        motion.x[:], motion.v[:], motion.moves[:] = self.x[bodies], self.v[bodies], self.moves[bodies]
        module, scratch_of = (planar, planar_scratch) if self.dim == 2 else (spatial, spatial_scratch)
        room = len(shown) ** 2
        found, scratch = new(Found, m=20 * room, d=self.dim), scratch_of(shapes, room)
        n = module.find_contacts(shapes.address, motion.address, DT, margin, found.address, scratch.address)
        assert 0 <= n <= 20 * room
        return {
            (shown[found.shape_i[k]], shown[found.shape_j[k]], int(found.key[k]) & (2**19 - 1)): (
                found.gap[k], *found.normal[k], *found.point[k])
            for k in range(n)
        }  # fmt: skip

    def closes(self, a, b, gap, normal, point):
        """Whether a gap is within the margin, or will be by the end of the step."""
        v = [self.v[body, : self.dim] + self.turning(body, point - self.x[body, : self.dim]) for body in (a, b)]
        return gap + DT * min(normal @ (v[1] - v[0]), 0.0) < MARGIN

    def turning(self, body, arm):
        """omega x arm."""
        if self.dim == 3:
            return np.cross(self.v[body, 3:], arm)
        return self.v[body, 2] * np.array([-arm[1], arm[0]])


def check(dim, n, seed):
    world = World(dim, n, seed)
    every = range(len(world.bodies))
    found = world.contacts(list(every), list(range(n + 1)))
    alone, near = {}, set()
    for i in every:
        for j in range(i + 1, len(world.bodies)):
            a, b = world.bodies[i][0], world.bodies[j][0]
            if a != b:
                alone |= world.contacts([i, j], [a, b])
                for gap, *rest in world.contacts([i, j], [a, b], EVERYTHING).values():
                    if world.closes(a, b, gap, np.array(rest[:dim]), np.array(rest[dim:])):
                        near.add((i, j))
    assert found == alone
    met = {(i, j) for i, j, _ in found}
    assert near <= met
    return len(met)


@pytest.mark.upkeep
@pytest.mark.parametrize("dim", [2, 3])
def test_contacts_of_a_world_of_all_sizes_are_those_of_its_pairs(dim):
    """To the last bit: which pairs are looked at depends on the crowd, what is found of them does not."""
    load_all([solid_contact, further_points])
    assert sum(check(dim, 36, seed) for seed in range(2)) > 60


@pytest.mark.stress
@pytest.mark.parametrize("dim", [2, 3])
def test_contacts_of_many_worlds_of_all_sizes_are_those_of_their_pairs(dim):
    load_all([solid_contact, further_points])
    assert sum(check(dim, 120, 100 + seed) for seed in range(15)) > 5000
