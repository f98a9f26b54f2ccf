"""The plane faces of shapes that are not rounded, of the plane and of space alike, in the axes of each shape.

    n_f . r <= h_f  of all faces f    a point r is in the shape

A hull has a face an edge, and a segment its two ends too; a half-plane and a half-space have one face without corners.
Points and directions are (x, y, z), with z = 0 in the plane.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import cos, sin
from typing import Annotated as Array

import numpy as np

from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints
from nonsmooth.scenes.rotation import turned

Face = tuple[np.ndarray, np.ndarray]  # outward normal (3,), corners (k, 3)
UP = np.array([0.0, 0.0, 1.0])
AXES = np.eye(3)


class Faces(Block):
    """Of n_s shapes, one behind the other."""

    first: Array[Ints, "n_s"]
    count: Array[Ints, "n_s"]  # 0: the shape is round
    normal: Array[Floats, "n_g", "3"]  # outward
    height: Array[Floats, "n_g"]  # [m] h_f
    first_corner: Array[Ints, "n_g"]
    corners: Array[Ints, "n_g"]
    corner: Array[Floats, "n_l", "3"]  # [m]


def faces_of_hull(hull: np.ndarray) -> Iterator[Face]:
    """Of a planar hull (k, 3) with z = 0, k >= 2."""
    for here, there in zip(hull, np.roll(hull, -1, axis=0), strict=True):
        along = (there - here) / np.linalg.norm(there - here)
        yield np.cross(along, UP), np.stack((here, there))
        if len(hull) == 2:
            yield along, there[None]


def faces_of_box(size: Sequence[float]) -> Iterator[Face]:
    """Of a box with these half lengths (3,)."""
    for axis in range(3):
        one, two = (size[k] * AXES[k] for k in ((axis + 1) % 3, (axis + 2) % 3))
        for side in (-1.0, 1.0):
            middle = side * size[axis] * AXES[axis]
            yield side * AXES[axis], middle + np.stack((-one - two, one - two, one + two, two - one))


@kernel
def in_body(x, b, r):
    """A direction of the world in the axes of a body at places x."""
    if x.shape[1] == 3:
        c, s = cos(x[b, 2]), sin(x[b, 2])
        return c * r[0] + s * r[1], c * r[1] - s * r[0], 0.0
    return turned(x[b, 3], -x[b, 4], -x[b, 5], -x[b, 6], r[0], r[1], r[2])


@kernel
def in_shape(shapes, x, s, r):
    """A direction of the world in the axes of shape s."""
    return in_body(shapes.place, s, in_body(x, shapes.body[s], r))


@kernel
def to_shape(shapes, x, s, p):
    """A point of the world in the axes of shape s."""
    b, place, is_planar = shapes.body[s], shapes.place, x.shape[1] == 3
    r = in_body(x, b, (p[0] - x[b, 0], p[1] - x[b, 1], 0.0 if is_planar else p[2] - x[b, 2]))
    return in_body(place, s, (r[0] - place[s, 0], r[1] - place[s, 1], 0.0 if is_planar else r[2] - place[s, 2]))


@kernel
def in_world_of(x, b, r):
    """A direction of the axes of a body at places x in the world."""
    if x.shape[1] == 3:
        c, s = cos(x[b, 2]), sin(x[b, 2])
        return c * r[0] - s * r[1], s * r[0] + c * r[1], 0.0
    return turned(x[b, 3], x[b, 4], x[b, 5], x[b, 6], r[0], r[1], r[2])


@kernel
def out_of_shape(shapes, x, s, r):
    """A direction of the axes of shape s in the world."""
    return in_world_of(x, shapes.body[s], in_world_of(shapes.place, s, r))


@kernel
def along(normal, f, r):
    """n_f . r."""
    return normal[f, 0] * r[0] + normal[f, 1] * r[1] + normal[f, 2] * r[2]


@kernel
def contains(faces, s, r, slack):
    """Whether a point r of its axes is in shape s, or no farther outside of a face than a slack."""
    for f in range(faces.first[s], faces.first[s] + faces.count[s]):
        if along(faces.normal, f, r) > faces.height[f] + slack:
            return False
    return faces.count[s] > 0


@kernel
def flattest(faces, s, m):
    """The face of shape s whose normal is nearest to a direction m of its axes."""
    best, most = faces.first[s], -2.0
    for f in range(faces.first[s], faces.first[s] + faces.count[s]):
        turn = along(faces.normal, f, m)
        if turn > most:
            best, most = f, turn
    return best


@kernel
def angle_of(faces, f, m):
    """The sine of the angle between the normal of face f and a unit vector m that is turned to it."""
    n = faces.normal
    a = m[0] - n[f, 0], m[1] - n[f, 1], m[2] - n[f, 2]
    return (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]) ** 0.5


@kernel
def goes_beyond(faces, s, r, m, slack):
    """Whether shape s goes farther along a direction m of its axes than a point r, by more than a slack."""
    for f in range(faces.first[s], faces.first[s] + faces.count[s]):
        if faces.corners[f] == 0:
            return angle_of(faces, f, m) > slack or faces.height[f] - along(faces.normal, f, r) > slack
        for k in range(faces.first_corner[f], faces.first_corner[f] + faces.corners[f]):
            corner = faces.corner
            way = m[0] * (corner[k, 0] - r[0]) + m[1] * (corner[k, 1] - r[1]) + m[2] * (corner[k, 2] - r[2])
            if way > slack:
                return True
    return False
