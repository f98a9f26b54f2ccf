"""Where the planar shapes are: centres, vertices in world axes, boxes.

    c = x + R(angle) place,    a_k = R(angle + place's) vertex_k

Vertices are kept relative to the centre, so that contact of small bodies far from the origin is found to the rounding
of the difference of two centres.
"""

from __future__ import annotations

import math
from typing import Annotated as Array

from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, new
from nonsmooth.scenes.broad_phase import Grid
from nonsmooth.scenes.shape_rows import HALF_PLANE, Shapes


class Manifold(Block):
    """Where one pair touches: up to as many points as a shape has vertices, at least two; in the order of features."""

    nx: float  # the normal, from i to j
    ny: float
    gap: Array[Floats, "k"]
    x: Array[Floats, "k"]
    y: Array[Floats, "k"]
    feature: Array[Ints, "k"]


class PlanarScratch(Block, d=2):
    """What detection works with; n_p is the room for pairs."""

    centre: Array[Floats, "n_s", "2"]  # [m]
    arm: Array[Floats, "n_w", "2"]  # [m] vertices from the centre, in world axes
    normal: Array[Floats, "n_w", "2"]  # of edges
    grid: Grid
    manifold: Manifold


def planar_scratch(shapes: Shapes, n_pairs: int) -> PlanarScratch:
    """Scratch for these shapes, with room for so many pairs."""
    n_s, n_w = len(shapes.body), len(shapes.length)
    k = max([2, *shapes.count.tolist()])
    return new(PlanarScratch, n_s=n_s, n_w=n_w, n_p=n_pairs, k=k)


@kernel
def place_shapes(shapes, motion, dt, margin, scratch):
    """Bring all shapes to where their bodies are."""
    for s in range(shapes.body.shape[0]):
        b = shapes.body[s]
        place_shape(shapes, motion, scratch, s, b)
        if shapes.kind[s] == HALF_PLANE:
            scratch.grid.level[s] = -1
            bound_half_plane(shapes, motion, dt, margin, scratch, s, b)
        else:
            scratch.grid.level[s] = 0
            bound(shapes, motion, dt, margin, scratch, s, b)


@kernel
def place_shape(shapes, motion, scratch, s, b):
    """Centre, vertices and normals in the world; without an angle where there is nothing to turn."""
    px, py, angle = shapes.place[s, 0], shapes.place[s, 1], motion.x[b, 2]
    if px != 0.0 or py != 0.0:
        c, z = math.cos(angle), math.sin(angle)
        px, py = c * px - z * py, z * px + c * py
    scratch.centre[s, 0], scratch.centre[s, 1] = motion.x[b, 0] + px, motion.x[b, 1] + py
    angle += shapes.place[s, 2]
    if shapes.kind[s] == HALF_PLANE:
        scratch.grid.normal[s, 0], scratch.grid.normal[s, 1] = -math.sin(angle), math.cos(angle)
    elif shapes.reach[s] > 0.0:
        turn(shapes, scratch, s, math.cos(angle), math.sin(angle))


@kernel
def turn(shapes, scratch, s, c, z):
    """The vertices of a hull and its normals by an angle of this cosine and sine."""
    vertices, normals, arm, normal = shapes.vertices, shapes.normals, scratch.arm, scratch.normal
    for w in range(shapes.first[s], shapes.first[s] + shapes.count[s]):
        arm[w, 0] = c * vertices[w, 0] - z * vertices[w, 1]
        arm[w, 1] = z * vertices[w, 0] + c * vertices[w, 1]
        normal[w, 0] = c * normals[w, 0] - z * normals[w, 1]
        normal[w, 1] = z * normals[w, 0] + c * normals[w, 1]


@kernel
def bound(shapes, motion, dt, margin, scratch, s, b):
    """The box of a hull, wider by half the margin and by the farthest that a point of its core moves in the step.

    Rounding by a radius changes no normal velocity: the normal goes through the core.
    """
    vx, vy, x, y = motion.v[b, 0], motion.v[b, 1], shapes.place[s, 0], shapes.place[s, 1]
    arm = math.sqrt(x * x + y * y) + shapes.reach[s]
    grid = scratch.grid
    grid.approach[s] = dt * (math.sqrt(vx * vx + vy * vy) + abs(motion.v[b, 2]) * arm)
    wider = shapes.radius[s] + 0.5 * margin + grid.approach[s]
    for a in range(2):
        low, high = 0.0, 0.0
        if shapes.reach[s] > 0.0:
            low, high = scratch.arm[shapes.first[s], a], scratch.arm[shapes.first[s], a]
            for w in range(shapes.first[s] + 1, shapes.first[s] + shapes.count[s]):
                low, high = min(low, scratch.arm[w, a]), max(high, scratch.arm[w, a])
        grid.lo[s, a] = scratch.centre[s, a] + low - wider
        grid.hi[s, a] = scratch.centre[s, a] + high + wider


@kernel
def bound_half_plane(shapes, motion, dt, margin, scratch, s, b):
    """The border of a half-plane, wider as boxes are; where it turns, everywhere, since its points are far out."""
    grid, vx, vy = scratch.grid, motion.v[b, 0], motion.v[b, 1]
    grid.approach[s] = dt * math.sqrt(vx * vx + vy * vy) if motion.v[b, 2] == 0.0 else math.inf
    height = grid.normal[s, 0] * scratch.centre[s, 0] + grid.normal[s, 1] * scratch.centre[s, 1]
    grid.border[s] = height + 0.5 * margin + grid.approach[s]
