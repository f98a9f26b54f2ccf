"""Axes and limits of the joints of a scene, as lines: through a joint, along a travel up to its stops, around an angle.

An angle has a sector from its least to its largest value, on the side to which the second body lies at the start.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.scenes.elements import Body, Joint
from nonsmooth.scenes.places import ORIGIN, compose, inverse, place_of, rotate

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

AXIS_SHARE = 0.06  # chosen: of the picture, that an axis reaches to either side
STOP_SHARE = 0.4  # chosen: of that, that a stop reaches across
ARC_POINTS = 25  # chosen: of the arc of a limited angle
OPEN_ARC = 0.25 * math.pi  # chosen: of an angle without a limit on one side, that is drawn [rad]


def joint_axes(solution: SceneSolution, here: Sequence[np.ndarray], size: float) -> list[np.ndarray]:
    """The two ends (2, d) of each axis, with the bodies at places (n_b, n_x), in a picture of a size [m]."""
    lines = [(joint, joint.axis) for joint in solution.joints if has_axis(joint, solution.dim)]
    lines += [(joint, joint.axes_b[0]) for joint in solution.joints if joint.kind == "universal"]
    return [line_of_axis(joint, axis, here, AXIS_SHARE * size) for joint, axis in lines]


def has_axis(joint: Joint, dim: int) -> bool:
    """Whether a joint has an axis that is seen: in the plane a hinge has none."""
    return not (joint.kind in ("joint", "fix") or joint.is_tie) and not (dim == 2 and joint.kind == "hinge")


def line_of_axis(joint: Joint, axis: np.ndarray, here: Sequence[np.ndarray], reach: float) -> np.ndarray:
    """The ends (2, d) of an axis: it goes with the first body, but the second one of a universal joint."""
    body = joint.a if axis is joint.axis or (axis == joint.axis).all() else joint.b
    return gone_with(body, here[body.index], ends_of_axis(joint, axis, reach))


def gone_with(body: Body, place: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (k, d) of the start, moved with the shape of a body to a place."""
    d = points.shape[1]
    moved = compose(place, inverse(place_of(body.position, body.turn)))
    return np.array(moved[:d] + rotate(moved[d:] if d == 3 else moved[2], points))


def ends_of_axis(joint: Joint, axis: np.ndarray, reach: float) -> np.ndarray:
    """The ends (2, d) of an axis at the start: of a travel its stops."""
    low, high = joint.limits.get("travel", (-np.inf, np.inf))
    ends = np.array([low if np.isfinite(low) else -reach, high if np.isfinite(high) else reach])
    return np.array(joint.at + ends[:, None] * axis)


def limits_of(joint: Joint, reach: float) -> list[np.ndarray]:
    """Lines (k, d) at the start, that go with the first body: bars across the ends of a travel, the sector of an
    angle."""
    d, lines = len(joint.at), []
    across = joint.axes[1:]
    for end in joint.limits.get("travel", ()):
        if np.isfinite(end):
            middle = joint.at + end * joint.axis
            lines += [middle + STOP_SHARE * reach * np.outer([-1.0, 1.0], way) for way in across]
    if "angle" in joint.limits:
        low, high = joint.limits["angle"]
        f, g = np.eye(2) if d == 2 else across
        towards = joint.b.position - joint.at
        first, last = (low if np.isfinite(low) else high - OPEN_ARC), (high if np.isfinite(high) else low + OPEN_ARC)
        angles = math.atan2(towards @ g, towards @ f) + np.linspace(first, last, ARC_POINTS)
        arc = joint.at + reach * (np.cos(angles)[:, None] * f + np.sin(angles)[:, None] * g)
        spokes = [joint.at[None] if np.isfinite(end) else arc[:0] for end in (low, high)]
        lines.append(np.concatenate((spokes[0], arc, spokes[1])))
    return lines


def lines_on(body: Body, joints: Sequence[Joint], dim: int, reach: float) -> list[np.ndarray]:
    """All of these lines that go with a body, in the axes of its shape."""
    lines = []
    for joint in joints:
        if joint.a is body:
            lines += [ends_of_axis(joint, joint.axis, reach)] if has_axis(joint, dim) else []
            lines += limits_of(joint, reach)
        elif joint.b is body and joint.kind == "universal":
            lines.append(ends_of_axis(joint, joint.axes_b[0], reach))
    return [gone_with(body, ORIGIN[dim], line) for line in lines]
