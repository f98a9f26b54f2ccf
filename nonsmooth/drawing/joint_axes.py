"""Axes of the joints of a scene in its pictures: dashed lines through the joints, along a travel up to its limits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.scenes.elements import Joint
from nonsmooth.scenes.places import ORIGIN, compose, inverse, place_of, rotate

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

AXIS_SHARE = 0.06  # chosen: of the picture, that an axis reaches to either side


def joint_axes(solution: SceneSolution, here: Sequence[np.ndarray], size: float) -> list[np.ndarray]:
    """The two ends (2, d) of each axis, with the bodies at places (n_b, n_x), in a picture of a size [m]."""
    joints = [] if solution.scene is None else solution.scene.joints
    lines = [(joint, joint.axis) for joint in joints if has_axis(joint, solution.dim)]
    lines += [(joint, joint.axes_b[0]) for joint in joints if joint.kind == "universal"]
    return [line_of_axis(joint, axis, here, AXIS_SHARE * size) for joint, axis in lines]


def has_axis(joint: Joint, dim: int) -> bool:
    """Whether a joint has an axis that is seen: in the plane a hinge has none."""
    return not (joint.kind in ("joint", "fix") or joint.is_tie) and not (dim == 2 and joint.kind == "hinge")


def line_of_axis(joint: Joint, axis: np.ndarray, here: Sequence[np.ndarray], reach: float) -> np.ndarray:
    """The ends (2, d) of an axis: it goes with the first body, but the second one of a universal joint."""
    d = len(axis)
    body = joint.a if axis is joint.axis or (axis == joint.axis).all() else joint.b
    moved = compose(here[body.index], inverse(place_of(body.position, body.turn)))
    middle = compose(moved, place_of(joint.at, ORIGIN[d][d:]))[:d]
    low, high = joint.limits.get("travel", (-np.inf, np.inf))
    ends = np.array([low if np.isfinite(low) else -reach, high if np.isfinite(high) else reach])
    return middle + ends[:, None] * rotate(moved[d:] if d == 3 else moved[2], axis)
