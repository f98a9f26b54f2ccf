"""Geoms of a model of MuJoCo: their shapes, their friction, and which of them touch.

    friction    of two geoms the larger coefficients, or those of the higher priority; none where condim is 1, against
                spinning where it is 4 or more, against rolling where it is 6
    touching    contype and conaffinity, but for bodies that are welded, parent and child, or excluded

Source: MuJoCo, *Computation*, sections on contact parameters and on the selection of pairs.
"""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.scenes.convex_hull import MOST_CORNERS, hull_points
from nonsmooth.scenes.materials import Material
from nonsmooth.scenes.parts import ALONG_X
from nonsmooth.scenes.places import conjugate, place_of, times
from nonsmooth.scenes.robots.mujoco_model import Read, Surface, unit
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Polyhedron, Shape, Sphere

SLIDING, SPINNING, ROLLING = 3, 4, 6  # defined: condim from which there is friction against each


def shape_of_geom(read: Read, k: int) -> Shape | None:
    """The shape of a geom; none of one that a scene does not have."""
    kinds, (a, b, c) = read.lib.mjtGeom, read.model.geom_size[k]
    match read.model.geom_type[k]:
        case kind if kind == int(kinds.mjGEOM_PLANE):
            return HalfSpace((0, 0, 1))
        case kind if kind == int(kinds.mjGEOM_SPHERE):
            return Sphere(a)
        case kind if kind == int(kinds.mjGEOM_CAPSULE):
            return Capsule(2 * b, a) if b > 0 else Sphere(a)
        case kind if kind == int(kinds.mjGEOM_CYLINDER):
            return Cylinder(a, 2 * b)
        case kind if kind == int(kinds.mjGEOM_BOX):
            return Box(2 * a, 2 * b, 2 * c)
        case kind if kind == int(kinds.mjGEOM_ELLIPSOID):
            return Ellipsoid(a, b, c)
        case kind if kind == int(kinds.mjGEOM_MESH):
            return hull_of_mesh(read, k)
    read.miss("a geom of a kind that is left out", read.name("geom", k))
    return None


def hull_of_mesh(read: Read, k: int) -> Shape | None:
    """The convex hull of the mesh of a geom, of at most as many corners as a `Polyhedron` has."""
    mesh, name = read.model.geom_dataid[k], read.name("geom", k)
    first = read.model.mesh_vertadr[mesh]
    points = np.array(read.model.mesh_vert[first : first + read.model.mesh_vertnum[mesh]], dtype=float)
    try:
        corners, out = hull_points(points, MOST_CORNERS)
        if out > 0.0:
            read.miss(f"corners of a hull beyond {MOST_CORNERS}, which stand out", f"{name} by {out:.1e} m")
        return Polyhedron(corners)
    except (InvalidInput, ValueError, RuntimeError):  # Qhull's error is a RuntimeError
        read.miss("a mesh that lies in a plane, which is left out", name)
        return None


def geom_place(read: Read, k: int, shape: Shape | None = None) -> np.ndarray:
    """Where a geom is; capsules and cylinders lie along the z-axis there, and along the x-axis here."""
    turn = np.empty(4)
    read.lib.mju_mat2Quat(turn, read.data.geom_xmat[k])
    if isinstance(shape, Capsule | Cylinder):
        turn = times(turn, conjugate(ALONG_X))
    return place_of(read.data.geom_xpos[k], unit(turn))


def surface_of(read: Read, k: int) -> Surface:
    """What a geom is made of."""
    model = read.model
    mu, spinning, rolling = model.geom_friction[k].tolist()
    return Surface(mu, spinning, rolling, int(model.geom_condim[k]), int(model.geom_priority[k]))


def material_of(read: Read, geoms: list[int]) -> Material | None:
    """The material of a body with these geoms, of which the roughest counts."""
    if not geoms:
        return None
    surfaces = {surface_of(read, k): k for k in geoms}
    if len(surfaces) > 1:
        who = read.name("body", read.model.geom_bodyid[geoms[0]])
        read.miss("geoms of one body that have unlike friction, of which the roughest counts", who)
    roughest = max(surfaces, key=lambda one: (one.priority, one.condim > 1, one.mu))
    name = f"mu {roughest.mu:g}, condim {roughest.condim}"
    name += f", lengths {roughest.spinning:g} {roughest.rolling:g} m" if roughest.condim > SLIDING else ""
    name += f", priority {roughest.priority}" if roughest.priority else ""
    read.surfaces[name] = roughest
    mu, spinning, rolling = coefficients(roughest)
    return Material(mu=mu, name=name, spinning=spinning, rolling=rolling)


def coefficients(one: Surface) -> tuple[float, float, float]:
    """mu, spinning and rolling of a contact; those that its condim leaves out are none."""
    return (
        one.mu if one.condim >= SLIDING else 0.0, one.spinning if one.condim >= SPINNING else 0.0,
        one.rolling if one.condim >= ROLLING else 0.0,
    )  # fmt: skip


def give_pairs(scene: Scene, read: Read) -> None:
    """The friction of pairs as MuJoCo has it: of the higher priority, else the larger ones."""
    used = {body.material.name for body in scene.bodies}
    known = {name: surface for name, surface in read.surfaces.items() if name in used}
    for (first, a), (second, b) in combinations_with_replacement(known.items(), 2):
        both = Surface(max(a.mu, b.mu), max(a.spinning, b.spinning), max(a.rolling, b.rolling),
                       max(a.condim, b.condim), a.priority)  # fmt: skip
        decides = a if a.priority > b.priority else b if b.priority > a.priority else both
        mu, spinning, rolling = coefficients(decides)
        scene.pair(first, second, mu=mu, spinning=spinning, rolling=rolling)


class Touching:
    """Which geoms may touch, by the rules of MuJoCo's *Collision detection*."""

    def __init__(self, read: Read) -> None:
        model = read.model
        self.read = read
        self.excluded = {int(signature) for signature in model.exclude_signature}
        self.given = {tuple(sorted(map(int, pair))) for pair in zip(model.pair_geom1, model.pair_geom2, strict=True)}
        self.is_off = read.is_off("CONTACT") or read.is_off("CONSTRAINT")
        self.contype, self.conaffinity = model.geom_contype.astype(int), model.geom_conaffinity.astype(int)

    def is_any(self, g: int) -> bool:
        """Whether a geom touches any other one."""
        return any(self.are_two(g, h) for h in range(self.read.model.ngeom) if h != g)

    def touch(self, first: list[int], second: list[int], names: tuple[str, str]) -> bool:
        """Whether two links touch: where some of their geoms would and others not, all do."""
        found = {self.are_two(g, h) for g in first for h in second}
        if len(found) > 1:
            self.read.miss("two bodies of which some geoms touch and others not, of which all do", " and ".join(names))
        return True in found

    def are_two(self, g: int, h: int) -> bool:
        """Whether two geoms touch."""
        model = self.read.model
        if self.is_off:
            return False
        if (min(g, h), max(g, h)) in self.given:
            return True
        a, b = int(model.geom_bodyid[g]), int(model.geom_bodyid[h])
        first, second = (int(model.body_weldid[body]) for body in (a, b))
        if first == second or (min(a, b) << 16) + max(a, b) in self.excluded:
            return False
        above = [int(model.body_weldid[model.body_parentid[root]]) for root in (first, second)]
        if first and second and (above[0] == second or above[1] == first):
            return False
        types, affinities = self.contype, self.conaffinity
        return bool(types[g] & affinities[h] or types[h] & affinities[g])
