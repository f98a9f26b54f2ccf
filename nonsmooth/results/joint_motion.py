"""Joints of a run of a scene: what they did, and the angle and the travel along their axes, at the records.

    angle = atan2(f_b . g_a, f_b . f_a),  rate e . (w_b - w_a);    travel = e . (p_b - p_a),  rate e . d(p_b - p_a)/dt
    distance = |p_b - p_a| of a rope, or of two points that are held at a distance

with the frame (e, f, g) of the joint on either body a, b, e along the axis, and p its points; the rate of the travel is
that in the axes of a.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.errors import InvalidInput, nearest, shown
from nonsmooth.results.scene_bodies import JointMotion
from nonsmooth.results.spring_forces import end_of, length_between, start_of, turning
from nonsmooth.scenes.elements import Body, Joint
from nonsmooth.scenes.joint_kinds import coordinate_rows
from nonsmooth.scenes.places import conjugate, rotate, times

if TYPE_CHECKING:
    from nonsmooth.results.scene_solution import SceneSolution

STOPPED_WITHIN = (
    1e-5  # chosen: [rad], [m]: a limit that is nearer is reached: a landing is known to the second order of a step
)


def motion_of_joint(solution: SceneSolution, name: str) -> JointMotion:
    """What a joint did, by name.

    Raises
    ------
    InvalidInput
        For a joint that is not there, and where contacts were not recorded.
    """
    if name not in solution.joint_names:
        raise InvalidInput(f"there is no joint {shown(name)}; {nearest(name, solution.joint_names)}")
    k = solution.joint_names.index(name)
    did = JointMotion(solution.t, solution.joint_impulses[:, k], solution.joint_torques[:, k])
    if solution.scene is None:
        return did
    joint = solution.scene.joints[k]
    found = {along: COORDINATE_OF[along](solution, joint) for along in coordinate_rows(joint.kind, solution.dim)}
    columns: dict[str, np.ndarray] = {}
    for along, (value, rate) in found.items():
        columns |= {along: value, f"{along}_rate": rate}
        if along in joint.limits:
            low, high = joint.limits[along]
            columns["at_limit"] = np.where(
                value <= low + STOPPED_WITHIN, -1, np.where(value >= high - STOPPED_WITHIN, 1, 0)
            )
    return did._replace(**columns)


def angle_of(solution: SceneSolution, joint: Joint) -> tuple[np.ndarray, np.ndarray]:
    """The angle of the second body against the first from the start, full turns with it, and its rate."""
    a, b = solution[joint.a.name], solution[joint.b.name]
    if solution.dim == 2:
        start = start_of(solution, joint.b)[2] - start_of(solution, joint.a)[2]
        return b.turn - a.turn - start, b.spin - a.spin
    e, f, g = (axis_of(solution, joint.a, axis) for axis in joint.axes)
    f_b = axis_of(solution, joint.b, joint.axes_b[1])
    angle = np.unwrap(np.arctan2(dot(f_b, g), dot(f_b, f)))
    return angle, dot(e, b.spin - a.spin)


def travel_of(solution: SceneSolution, joint: Joint) -> tuple[np.ndarray, np.ndarray]:
    """The travel of the point of the second body along the axis from the start, and its rate."""
    a, e = solution[joint.a.name], axis_of(solution, joint.a, joint.axis)
    first, v_first = end_of(solution, joint.a, joint.at)
    second, v_second = end_of(solution, joint.b, joint.at)
    way = second - first
    return dot(e, way), dot(e, v_second - v_first - turning(a, way))


def distance_of(solution: SceneSolution, joint: Joint) -> tuple[np.ndarray, np.ndarray]:
    """The distance of the two points, and its rate."""
    return length_between(solution, (joint.a, joint.at), (joint.b, joint.at_b))


COORDINATE_OF = {"angle": angle_of, "travel": travel_of, "distance": distance_of}  # defined


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The products of the rows of (n_t, d)."""
    return np.einsum("tk,tk->t", a, b)


def axis_of(solution: SceneSolution, body: Body, axis: np.ndarray) -> np.ndarray:
    """An axis (n_t, d) that goes with a body, from what it was at the start."""
    turn, start = solution.turn[:, body.index], start_of(solution, body)
    if solution.dim == 2:
        angle = turn - start[2]
        c, s = np.cos(angle), np.sin(angle)
        return np.stack((c * axis[0] - s * axis[1], s * axis[0] + c * axis[1]), axis=1)
    own = np.concatenate(([0.0], rotate(conjugate(start[3:]), axis)))
    return times(times(turn, own[None]), conjugate(turn))[:, 1:]
