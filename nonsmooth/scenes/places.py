"""Places: where a frame is in another one, (x, y, angle) in the plane and (position, unit quaternion w x y z) in space.

(a b)(v) = a(b(v)),    b(v) = position_b + R_b v
"""

from __future__ import annotations

import math

import numpy as np

ORIGIN = {2: np.zeros(3), 3: np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])}  # defined


def place_of(position: np.ndarray, turn: float | np.ndarray) -> np.ndarray:
    """Position and turn as one row."""
    return np.concatenate((position, np.atleast_1d(turn)))


def compose(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The place b of a frame within the frame a, in that of a."""
    if len(a) == 3:
        return np.append(a[:2] + rotate(a[2], b[:2]), a[2] + b[2])
    return np.concatenate((a[:3] + rotate(a[3:], b[:3]), times(a[3:], b[3:])))


def inverse(a: np.ndarray) -> np.ndarray:
    """The place a^-1 of the outer frame in the inner one."""
    if len(a) == 3:
        return np.append(-rotate(-a[2], a[:2]), -a[2])
    return np.concatenate((-rotate(conjugate(a[3:]), a[:3]), conjugate(a[3:])))


def rotate(turn: float | np.ndarray, v: np.ndarray) -> np.ndarray:
    """R v, by an angle or a unit quaternion; of many vectors (m, 2|3) too."""
    return v @ matrix_of(turn).T


def matrix_of(turn: float | np.ndarray) -> np.ndarray:
    """R of an angle (2, 2), or of a unit quaternion (3, 3)."""
    if np.ndim(turn) == 0:
        c, s = math.cos(float(turn)), math.sin(float(turn))
        return np.array([[c, -s], [s, c]])
    w, x, y, z = np.asarray(turn)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The product of quaternions (..., 4): first the turn b, then a."""
    a_0, a_v, b_0, b_v = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    scalar = a_0 * b_0 - (a_v * b_v).sum(axis=-1, keepdims=True)
    return np.concatenate((scalar, a_0 * b_v + b_0 * a_v + np.cross(a_v, b_v)), axis=-1)


def turn_by(vector: np.ndarray) -> np.ndarray:
    """The unit quaternion (..., 4) of a rotation vector (..., 3), axis times angle [rad]."""
    half = 0.5 * np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.concatenate((np.cos(half), 0.5 * np.sinc(half / np.pi) * vector), axis=-1)


def rotate_all(turns: np.ndarray, v: np.ndarray) -> np.ndarray:
    """R v of unit quaternions (..., 4) and vectors (..., 3)."""
    return v + 2.0 * np.cross(turns[..., 1:], np.cross(turns[..., 1:], v) + turns[..., :1] * v)


def conjugate(a: np.ndarray) -> np.ndarray:
    """The turn back (..., 4)."""
    return a * np.array([1.0, -1.0, -1.0, -1.0])


def quaternion_of(matrix: np.ndarray) -> np.ndarray:
    """The unit quaternion of a rotation (3, 3), with w >= 0 where it is largest."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(matrix).as_quat()
    return np.array([w, x, y, z]) * (1.0 if w >= 0 else -1.0)


def turn_onto(normal: np.ndarray) -> float | np.ndarray:
    """A turn that brings the last axis of a frame, y or z, onto a unit vector."""
    if len(normal) == 2:
        return math.atan2(normal[1], normal[0]) - 0.5 * math.pi
    across = math.hypot(normal[0], normal[1])
    half = 0.5 * math.atan2(across, normal[2])
    x, y = (-normal[1] / across, normal[0] / across) if across > 0.0 else (1.0, 0.0)
    return np.array([math.cos(half), x * math.sin(half), y * math.sin(half), 0.0])
