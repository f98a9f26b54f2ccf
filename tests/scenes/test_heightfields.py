"""Ground of heights: a plane where it is one, and in a hollow a ball that tends to its closed form with the cells."""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns

SAME = 1e-9  # [m]
G = 9.81
N, LENGTH = 20, 5.0  # points a side: no seam is where a body starts
UPRIGHT = np.array([np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0])


def product(p, q):
    """The product of two quaternions."""
    (a, u), (b, v) = (p[0], p[1:]), (q[0], q[1:])
    return np.array([a * b - u @ v, *(a * v + b * u + np.cross(u, v))])


def scenes_of(slope, ground, plane, dim):
    """The same slope as ground of heights and as a plane."""
    found = []
    for shape in (ground, plane):
        s = ns.Scene(gravity=(0, -G) if dim == 2 else (0, 0, -G), material=ns.Material(mu=0.2))
        s.fixed(shape)
        found.append(s)
    return found


def parted(scenes, shape, dt, **state):
    """How far the ways of a body in two scenes part [m]."""
    ways = []
    for s in scenes:
        s.body(shape, mass=1.0, name="b", **state)
        ways.append(ns.simulate(s, (0, 0.4), integrator=ns.MoreauJean(dt=dt))["b"].position)
    assert np.abs(ways[0][-1] - ways[0][0]).max() > 0.15
    return np.abs(ways[0] - ways[1]).max()


ON_GROUND = {
    "sphere": (ns.Sphere(0.1), 0.1, np.array([1.0, 0, 0, 0])),
    "box": (ns.Box(0.2, 0.15, 0.1), 0.05, np.array([1.0, 0, 0, 0])),
    "cylinder": (ns.Cylinder(0.1, 0.1), 0.05, UPRIGHT),
    "ellipsoid": (ns.Ellipsoid(0.12, 0.1, 0.06), 0.06, np.array([1.0, 0, 0, 0])),
}


@pytest.mark.upkeep
@pytest.mark.parametrize("body", ON_GROUND)
@pytest.mark.parametrize("slope", [(0.0, 0.0), (0.3, 0.0), (0.3, 0.17), (-0.5, 0.4)])
def test_flat_and_inclined_ground_is_a_plane(slope, body):
    shape, height, turn = ON_GROUND[body]
    x = np.linspace(-0.5 * LENGTH, 0.5 * LENGTH, N)
    ground = ns.heightfield(slope[0] * x + slope[1] * x[:, None], (LENGTH, LENGTH))
    up = np.array([-slope[0], -slope[1], 1.0]) / np.hypot(1.0, np.hypot(*slope))
    along = np.cross([0, 1.0, 0], up)
    along /= np.linalg.norm(along)
    lean = np.array([1.0 + up[2], -up[1], up[0], 0.0])
    place = height * up + np.array([0.013, 0.021, 0.013 * slope[0] + 0.021 * slope[1]])
    for dt, speed in ((1e-3, 2.0), (2.3e-3, 1.3)):
        state = {"position": place, "velocity": speed * along, "turn": product(lean / np.linalg.norm(lean), turn)}
        scenes = scenes_of(slope, ground, ns.HalfSpace(up), 3)
        assert parted(scenes, shape, dt, **state) <= SAME


@pytest.mark.parametrize("slope", [0.0, 0.3])
@pytest.mark.parametrize(
    "shape, height", [(ns.Disc(0.1), 0.1), (ns.Box(0.2, 0.1), 0.05), (ns.Capsule(0.1, 0.05), 0.05)]
)
def test_flat_and_inclined_ground_of_the_plane_is_a_half_plane(shape, height, slope):
    ground = ns.heightfield(slope * np.linspace(-0.5 * LENGTH, 0.5 * LENGTH, N), LENGTH)
    up = np.array([-slope, 1.0]) / np.hypot(1.0, slope)
    place = height * up + np.array([0.013, 0.013 * slope])
    state = {"position": place, "velocity": 2.0 * np.array([up[1], -up[0]]), "turn": np.arctan(slope)}
    assert parted(scenes_of(slope, ground, ns.HalfPlane(up), 2), shape, 1e-3, **state) <= SAME


def height_lost(n):
    """How far below its start a ball that rolls through a hollow comes to rest on the other side [m]."""
    x, s, r = np.linspace(-1, 1, n), 0.6, 0.1
    scene = ns.Scene(gravity=(0, 0, -G), material=ns.Material(mu=0.5))
    scene.fixed(ns.heightfield(0.5 * (x**2 + x[:, None] ** 2), (2, 2)))
    up = np.array([-s, 0, 1]) / np.hypot(1, s)
    sag = 0.25 * (2 / (n - 1)) ** 2  # by which facets are above the surface, at most
    scene.body(ns.Sphere(r), mass=1.0, position=np.array([s, 0, 0.5 * s**2 + sag]) + r * up, name="ball")
    sol = ns.simulate(scene, (0, 1.4), integrator=ns.MoreauJean(dt=1e-3))
    way = sol["ball"].position
    after = way[np.argmin(way[:, 2]) :]
    assert np.abs(way[:, 1]).max() <= 0.01  # it stays in the plane of its start
    return way[0, 2] - after[:, 2].max()


@pytest.mark.upkeep
def test_a_ball_in_a_hollow_tends_to_its_energy_with_the_cells():
    """A ball that rolls without loss comes up as high as it started; on facets it loses as they are wide."""
    lost = np.array([height_lost(n) for n in (11, 21, 41)])
    assert (lost > 0).all()
    assert (lost[1:] <= 0.65 * lost[:-1]).all()


@pytest.mark.upkeep
@pytest.mark.parametrize("slope", [(-0.5, 0.4), (0.2, -0.3)])
def test_a_box_on_a_slope_slides_as_on_a_plane(slope):
    """Over the points too at which six tiles meet, where the sides of tiles are nearer than their gaps."""
    x = np.linspace(-0.5 * LENGTH, 0.5 * LENGTH, N + 1)
    ground = ns.heightfield(slope[0] * x + slope[1] * x[:, None], (LENGTH, LENGTH))
    up = np.array([-slope[0], -slope[1], 1.0]) / np.hypot(1.0, np.hypot(*slope))
    lean = np.array([1.0 + up[2], -up[1], up[0], 0.0])
    along = np.cross([0, 1.0, 0], up)
    place = 0.05 * up + np.array([0.013, 0.021, 0.013 * slope[0] + 0.021 * slope[1]])
    for speed in (1.3, -2.0):
        state = {"position": place, "velocity": speed * along, "turn": lean / np.linalg.norm(lean)}
        scenes = scenes_of(slope, ground, ns.HalfSpace(up), 3)
        assert parted(scenes, ns.Box(0.2, 0.15, 0.1), 2.3e-3, **state) <= SAME


def test_pieces_go_through_all_heights_and_down_to_the_base():
    heights = np.random.default_rng(3).uniform(0.5, 1.0, (3, 4))
    ground = ns.heightfield(heights, (6.0, 4.0), base=-1.0)
    assert len(ground.parts) == 12
    corners = np.concatenate([shape.vertices for shape, _, _ in ground.parts])
    for j, i in np.ndindex(3, 4):
        here = corners[(corners[:, 0] == 2.0 * i - 3.0) & (corners[:, 1] == 2.0 * j - 2.0), 2]
        assert set(here) == {-1.0, heights[j, i]}
    for shape, _, _ in ground.parts:
        hull = ns.Polyhedron(shape.vertices)
        faces = {frozenset(map(tuple, shape.vertices[list(face)])) for face in shape.faces}
        assert faces == {frozenset(map(tuple, hull.vertices[list(face)])) for face in hull.faces}


def test_a_file_has_ground_of_heights(tmp_path):
    (tmp_path / "hills.toml").write_text(
        "gravity = [0, -9.81]\n[[bodies]]\nkind = 'fixed'\n"
        "shape = {heightfield = {heights = [0, 0.1, 0], lengths = 2, base = -1}}\n"
    )
    (ground,) = ns.Scene.load(tmp_path / "hills.toml").bodies
    wanted = ns.heightfield([0, 0.1, 0], 2, base=-1).parts
    for (shape, _, _), (other, _, _) in zip(ground.shape.parts, wanted, strict=True):
        assert (shape.vertices == other.vertices).all()
