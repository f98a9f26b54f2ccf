"""The pose of a polyline in each frame, from its first one: which of a picture's lines are rigid bodies, and where.

    x_k = c_k + R(phi_k) (x_0 - c_0),    tan phi_k = sum (x_0 - c_0) x (x_k - c_k) / sum (x_0 - c_0) . (x_k - c_k)

is the rotation of least squares in the plane, with the mean c of the points; of a closed line the last point is the
first one, and counts once. Source: Kabsch, *Acta Cryst.* A 32 (1976)
922.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

CLOSED = 1e-12  # chosen: of a line's size: ends nearer to each other are one point
RIGID = 1e-6  # chosen: of a line's size: what a line that is called rigid may bend; float32 draws no less


class Pose(NamedTuple):
    """Centres (n_t, 2) and angles (n_t,), continuous in time, and whether the line keeps its form with them."""

    centre: np.ndarray
    angle: np.ndarray
    is_rigid: bool


def pose_of(lines: np.ndarray) -> Pose:
    """The pose of a line whose points in each frame are ``lines`` (n_t, k, 2)."""
    corners = lines[:, :-1] if is_closed(lines[0]) else lines
    centre = corners.mean(axis=1)
    spokes = corners - centre[:, None]
    first = spokes[0]
    along = np.einsum("kd,tkd->t", first, spokes)
    across = np.einsum("k,tk->t", first[:, 0], spokes[:, :, 1]) - np.einsum("k,tk->t", first[:, 1], spokes[:, :, 0])
    angle = np.unwrap(np.arctan2(across, along))
    bend = np.abs(seen_from(Pose(centre, angle, True), corners) - first).max(initial=0.0)
    return Pose(centre, angle, bool(bend <= RIGID * np.abs(first).max(initial=0.0)))


def is_closed(line: np.ndarray) -> bool:
    """Whether a line (k, 2) ends where it begins."""
    return len(line) > 3 and bool(np.abs(line[0] - line[-1]).max() <= CLOSED * np.abs(line - line[0]).max())


def seen_from(pose: Pose, lines: np.ndarray) -> np.ndarray:
    """Points (n_t, k, 2) in the frame of a body."""
    x, y = np.moveaxis(lines - pose.centre[:, None], 2, 0)
    c, s = np.cos(pose.angle)[:, None], np.sin(pose.angle)[:, None]
    return np.stack([c * x + s * y, c * y - s * x], axis=-1)
