"""Kinds of joints: each is a table of what it holds, row by row, and of what it leaves free.

Body i has a frame (e, f, g) at the joint and body j another, e along the axis of the joint; both coincide at the start.
A row is one of

    (u, POINT)         axis u of the world:   (p_j - p_i)_u = 0, at the point midway
    (u, OFFSET)        axis u of body i:      u_i . (p_j - p_i) = 0, at the point of body j
    (u, w)             two axes that stay at right angles:   u_i . w_j = 0
    (0, PLANE_ANGLE)   in the plane:          angle_j - angle_i = 0
    (0, DISTANCE)      |p_j - p_i| = l, along the line between both points
    (0, TURN)          in space: the angle of j about e, which no joint holds, but limits and motors act on

so that a hinge is five of them. What is held and what solves it (joint_rows.py) knows rows, and no kind.
Source: Haug, *Computer Aided Kinematics and Dynamics of Mechanical Systems* (1989), sections 3.3 and 9.4.
"""

from __future__ import annotations

from typing import NamedTuple

POINT, OFFSET, PLANE_ANGLE, TURN, UNUSED, DISTANCE = -1, -2, -3, -4, -5, -6  # code: in the place of an axis of body j
E_AXIS, F_AXIS, G_AXIS = range(3)  # code: axes of a frame

Row = tuple[int, int]
Rows = tuple[Row, ...]

SHARED_POINT: Rows = ((E_AXIS, POINT), (F_AXIS, POINT), (G_AXIS, POINT))  # defined
ON_AXIS: Rows = ((F_AXIS, OFFSET), (G_AXIS, OFFSET))  # defined: the point of j on the axis of i
IN_PLANE: Rows = ((E_AXIS, OFFSET),)  # defined: and in the plane across it
SAME_AXIS: Rows = ((F_AXIS, E_AXIS), (G_AXIS, E_AXIS))  # defined: e_j along e_i
SAME_TURN: Rows = (*SAME_AXIS, (G_AXIS, F_AXIS))  # defined
CROSSED: Rows = ((E_AXIS, E_AXIS),)  # defined: two axes at right angles
AT_DISTANCE: Rows = ((E_AXIS, DISTANCE),)  # defined: two points at a distance
BALL_TURNS: Row = (E_AXIS, UNUSED)  # code: of friction in a ball, whose rows are turns across what it bears


class Kind(NamedTuple):
    """What a joint holds in the plane and in space, whether an angle and a travel along its axis are left to it, and
    whether it is one of the distance of two points."""

    plane: Rows
    space: Rows
    has_angle: bool = False
    has_travel: bool = False
    has_distance: bool = False


JOINT_KINDS = {  # defined
    "joint": Kind(SHARED_POINT[:2], SHARED_POINT),
    "hinge": Kind(SHARED_POINT[:2], SHARED_POINT + SAME_AXIS, has_angle=True),
    "slider": Kind(((F_AXIS, OFFSET), (E_AXIS, PLANE_ANGLE)), ON_AXIS + SAME_TURN, has_travel=True),
    "cylindrical": Kind((), ON_AXIS + SAME_AXIS, has_angle=True, has_travel=True),
    "universal": Kind((), SHARED_POINT + CROSSED),
    "fix": Kind((*SHARED_POINT[:2], (E_AXIS, PLANE_ANGLE)), SHARED_POINT + SAME_TURN),
    "planar": Kind((), IN_PLANE + SAME_AXIS, has_angle=True),
    "slot": Kind(((F_AXIS, OFFSET),), ON_AXIS, has_travel=True),
    "distance": Kind(AT_DISTANCE, AT_DISTANCE, has_distance=True),
    "rope": Kind((), (), has_distance=True),
}


def coordinate_rows(kind: str, dim: int) -> dict[str, Row]:
    """The coordinates along its axis that a joint leaves free, each as a row; of a rope its length."""
    known = JOINT_KINDS[kind]
    found = {
        "angle": (E_AXIS, PLANE_ANGLE if dim == 2 else TURN),
        "travel": (E_AXIS, OFFSET),
        "distance": AT_DISTANCE[0],
    }
    has = {"angle": known.has_angle, "travel": known.has_travel, "distance": known.has_distance}
    return {name: row for name, row in found.items() if has[name]}


def is_known(kind: str, dim: int) -> bool:
    """Whether there is such a joint in the plane (2) or in space (3)."""
    return bool(rows_of(kind, dim)) or JOINT_KINDS[kind].has_distance


def rows_of(kind: str, dim: int) -> Rows:
    """What a kind of joint holds in the plane (2) or in space (3); none where there is no such joint."""
    return JOINT_KINDS[kind].plane if dim == 2 else JOINT_KINDS[kind].space


def blocks_of(rows: Rows, dim: int) -> list[Rows]:
    """The rows in blocks of a contact problem, the last of which may have some that are unused."""
    parts = [rows[first : first + dim] for first in range(0, len(rows), dim)]
    return [part + ((E_AXIS, UNUSED),) * (dim - len(part)) for part in parts]
