"""Where the spatial shapes are: centres, axes in the world, boxes.

    c = x + R(p) place,    axes of the shape: the columns of R(p) R(p_place)

Everything else is found from differences of centres, so that contact of small bodies far from the origin is found to
the rounding of such a difference.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, new
from nonsmooth.scenes.broad_phase import Grid
from nonsmooth.scenes.rotation import composed, turned
from nonsmooth.scenes.shape_rows import HALF_SPACE, Shapes

FACE_CORNERS = 8  # derived: the most of a box, 4, and of the rim of a cylinder
MOST_GROWN = 128  # measured: points of a polytope of two cores, which are at most 100 of two ellipsoids to 1e-3
MOST_TRIANGLES = 2 * MOST_GROWN  # derived: of so many points, 2 n - 4
MOST_BORDERS = 3 * MOST_TRIANGLES  # derived: of so many triangles, before any is crossed out


class Manifold(Block):
    """Where one pair touches, point by point in the order of features; k is the room."""

    gap: Array[Floats, "k"]
    normal: Array[Floats, "k", "3"]  # from i to j
    point: Array[Floats, "k", "3"]
    feature: Array[Ints, "k"]


class SeparatingAxes(Block):
    """Of two cores, in the axes of i and j: what separates them most."""

    cosine: Array[Floats, "3", "3"]  # of the axes of i (rows) and j
    t_i: Array[Floats, "3"]  # [m] from the centre of i to that of j, in the axes of i
    t_j: Array[Floats, "3"]  # and of j
    face: int  # 0, 1, 2 of i, 3, 4, 5 of j; -1 where neither has one
    s_face: float  # [m] how far the other core is outside of it
    edges: int  # 3 p + q: axes p of i and q of j; -1 where all are parallel
    s_edges: float  # [m] along their vector product


class Polygon(Block):
    """A face that is clipped, in the axes of the reference box, or of a contact."""

    corner: Array[Floats, "k", "3"]
    feature: Array[Ints, "k"]
    side: Array[Ints, "k"]  # what the side behind a corner is: an edge of the incident core, or NO_EDGE + a plane


class Simplex(Block):
    """Points of the differences of two cores; four, and one that is dropped."""

    count: int
    corner: Array[Floats, "5", "3"]  # [m]
    own: Array[Floats, "5", "3"]  # [m] of i, from its centre
    part: Array[Floats, "5"]  # weights of the nearest point
    point: Array[Floats, "3"]  # [m] the nearest point of i, from its centre


class Polytope(Block):
    """Points of the differences of two cores, and the triangles of their hull."""

    points: int
    faces: int
    point: Array[Floats, MOST_GROWN, "3"]  # [m]
    corner: Array[Ints, MOST_TRIANGLES, "3"]  # counterclockwise from outside
    normal: Array[Floats, MOST_TRIANGLES, "3"]
    distance: Array[Floats, MOST_TRIANGLES]  # [m] from the origin along it; inf of what has no width
    edge: Array[Ints, MOST_BORDERS, "2"]


class SpatialScratch(Block, d=3):
    """What detection works with; n_p is the room for pairs, k for points of a pair and corners of a face."""

    centre: Array[Floats, "n_s", "3"]  # [m]
    axis: Array[Floats, "n_s", "3", "3"]  # a row an axis of the shape, in the world
    placed: Array[Floats, "n_s", "7"]  # x of the body that it was placed for
    grid: Grid
    manifold: Manifold
    axes: SeparatingAxes
    polygon: Polygon
    clipped: Polygon
    simplex: Simplex
    polytope: Polytope
    face_i: Polygon
    face_j: Polygon


def spatial_scratch(shapes: Shapes, n_pairs: int) -> SpatialScratch:
    """Scratch for these shapes, with room for so many pairs."""
    faces, vertices = int(shapes.solids.corners.max(initial=FACE_CORNERS)), int(shapes.solids.count.max(initial=0))
    k = max(2 * faces + 1, vertices)  # a face cut by as many sides, each of which adds a corner, and the nearest points
    return new(SpatialScratch, n_s=len(shapes.body), n_p=n_pairs, k=k)


@kernel
def place_shapes(shapes, motion, dt, margin, scratch):
    """Bring all shapes to where their bodies are."""
    for s in range(shapes.body.shape[0]):
        b = shapes.body[s]
        if motion.moves[b] == 1 or is_elsewhere(motion, scratch, s, b):
            place_shape(shapes, motion, scratch, s, b)
        if shapes.kind[s] == HALF_SPACE:
            scratch.grid.level[s] = -1
            bound_half_space(motion, dt, margin, scratch, s, b)
        else:
            scratch.grid.level[s] = 0
            bound(shapes, motion, dt, margin, scratch, s, b)


@kernel
def is_elsewhere(motion, scratch, s, b):
    """Whether the body of a shape is not where it was when the shape was placed; write down where it is."""
    x, placed, is_new = motion.x, scratch.placed, False
    for k in range(7):
        is_new = is_new or placed[s, k] != x[b, k]
        placed[s, k] = x[b, k]
    return is_new


@kernel
def place_shape(shapes, motion, scratch, s, b):
    """Centre and axes in the world; a sphere has none."""
    x, place, axis = motion.x, shapes.place, scratch.axis
    w, e_x, e_y, e_z = x[b, 3], x[b, 4], x[b, 5], x[b, 6]
    r_x, r_y, r_z = place[s, 0], place[s, 1], place[s, 2]
    if r_x != 0.0 or r_y != 0.0 or r_z != 0.0:
        r_x, r_y, r_z = turned(w, e_x, e_y, e_z, r_x, r_y, r_z)
    scratch.centre[s, 0], scratch.centre[s, 1], scratch.centre[s, 2] = x[b, 0] + r_x, x[b, 1] + r_y, x[b, 2] + r_z
    if shapes.reach[s] > 0.0:
        w, e_x, e_y, e_z = composed(w, e_x, e_y, e_z, place[s, 3], place[s, 4], place[s, 5], place[s, 6])
        axis[s, 0, 0], axis[s, 0, 1], axis[s, 0, 2] = turned(w, e_x, e_y, e_z, 1.0, 0.0, 0.0)
        axis[s, 1, 0], axis[s, 1, 1], axis[s, 1, 2] = turned(w, e_x, e_y, e_z, 0.0, 1.0, 0.0)
        axis[s, 2, 0], axis[s, 2, 1], axis[s, 2, 2] = turned(w, e_x, e_y, e_z, 0.0, 0.0, 1.0)


@kernel
def bound(shapes, motion, dt, margin, scratch, s, b):
    """The box of a shape, wider by half the margin and by the farthest that a point of its core moves in the step.

    Rounding by a radius changes no normal velocity: the normal goes through the core.
    """
    v, place, axis, size, grid = motion.v, shapes.place, scratch.axis, shapes.size, scratch.grid
    speed = math.sqrt(v[b, 0] * v[b, 0] + v[b, 1] * v[b, 1] + v[b, 2] * v[b, 2])
    spin = math.sqrt(v[b, 3] * v[b, 3] + v[b, 4] * v[b, 4] + v[b, 5] * v[b, 5])
    arm = math.sqrt(place[s, 0] * place[s, 0] + place[s, 1] * place[s, 1] + place[s, 2] * place[s, 2])
    grid.approach[s] = dt * (speed + spin * (arm + shapes.reach[s]))
    wider = shapes.radius[s] + 0.5 * margin + grid.approach[s]
    for a in range(3):
        half = wider
        if shapes.reach[s] > 0.0:
            for k in range(3):
                half += abs(axis[s, k, a]) * size[s, k]
        grid.lo[s, a], grid.hi[s, a] = scratch.centre[s, a] - half, scratch.centre[s, a] + half


@kernel
def bound_half_space(motion, dt, margin, scratch, s, b):
    """The border of a half-space, wider as boxes are; where it turns, everywhere, since its points are far out."""
    v, grid, height = motion.v, scratch.grid, 0.0
    speed = math.sqrt(v[b, 0] * v[b, 0] + v[b, 1] * v[b, 1] + v[b, 2] * v[b, 2])
    turns = v[b, 3] != 0.0 or v[b, 4] != 0.0 or v[b, 5] != 0.0
    grid.approach[s] = math.inf if turns else dt * speed
    for a in range(3):
        grid.normal[s, a] = scratch.axis[s, 2, a]
        height += grid.normal[s, a] * scratch.centre[s, a]
    grid.border[s] = height + 0.5 * margin + grid.approach[s]
