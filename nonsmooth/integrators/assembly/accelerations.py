"""The forces that contacts need at a state of a scene: their problem at acceleration level.

    gamma' = G la + b,    G = J M^-1 J^T,    b = J M^-1 h + J' v

along normals and one direction of sliding each. J' v is the second difference of the gaps along the velocities, of
fourth order: whatever touches, shapes need say no more than where their contacts are. That of joints is the difference
of the velocities of their rows, and their forces are eliminated (contact/network/eliminated.py).

Source: Glocker, *Set-Valued Force Laws* (2001), chapter 5.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from nonsmooth.contact.network.eliminated import without_joints
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.planar.problem import Planar
from nonsmooth.contact.planar.selection import Selection
from nonsmooth.integrators.assembly.bearings import Bearings
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.contacts import Contacts, Surfaces
from nonsmooth.integrators.assembly.doubtful import Doubts
from nonsmooth.integrators.assembly.drive_rows import Drives
from nonsmooth.integrators.assembly.joint_rows import wrench_of
from nonsmooth.integrators.assembly.joints import Joints, block_of
from nonsmooth.integrators.assembly.planar import move_planar
from nonsmooth.integrators.assembly.progress import Progress
from nonsmooth.integrators.assembly.spatial import move_spatial
from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.detection import Found
from nonsmooth.scenes.joint_kinds import UNUSED
from nonsmooth.scenes.shape_rows import Shapes

# chosen: of the reach of a body: how far it is moved for differences of gaps: truncation (1e-3)^4, rounding 1e-16/1e-6
GAP_INCREMENT = 1e-3

FIRST_TURN = {2: 2, 3: 0}  # defined: where the moments that turn a body begin

move_2, move_3 = interpreted(move_planar), interpreted(move_spatial)
block, wrench = interpreted(block_of), interpreted(wrench_of)


class SceneInStep(Protocol):
    """What is asked of a scene in the middle of a step (step.py)."""

    bodies: Bodies
    found: Found
    network: Network
    contacts: Contacts
    shapes: Shapes
    surfaces: Surfaces
    doubts: Doubts
    progress: Progress
    stages: Any
    joints: Joints
    drives: Drives
    bearings: Bearings
    dim: int
    selection: Selection

    @property
    def dense_core(self) -> Planar:
        """Which knows all solutions of few contacts."""

    def reach_of(self, bodies: np.ndarray) -> np.ndarray:
        """How far bodies reach [m]."""


class StateProblem:
    """gamma' = G la + b of contacts, along their normals and directions t, where the bodies are after a free time."""

    def __init__(
        self, assembly: SceneInStep, contacts: np.ndarray, joints: np.ndarray, t: np.ndarray, ahead: float
    ) -> None:  # fmt: skip
        bodies, network, dt = assembly.bodies, assembly.network, float(assembly.progress.dt)
        self.assembly, d = assembly, assembly.dim
        ends = np.stack((network.i[contacts], network.j[contacts]), axis=1)
        moving = np.unique(np.concatenate((ends.ravel(), network.i[joints], network.j[joints])))
        blocks = [int(block(assembly.joints, key)) for key in assembly.found.key[joints]]
        v = bodies.motion.v + ahead / dt * (network.v_free - bodies.v_0)
        self.found = new(Found, m=2 * len(assembly.found.gap), d=d)
        keys, reach = assembly.found.key[contacts], assembly.reach_of(moving)
        e = GAP_INCREMENT / max(fastest(v[moving], reach, d), EPS)
        kept = bodies.motion.x[moving].copy()
        gaps, rates = [], []
        for h in (-2, -1, 1, 2, 0):
            gaps.append(self._gaps(keys, v, moving, ahead + h * e))
            rates.append(np.einsum("rbx,bx->r", self._rows_of_joints(blocks, moving), v[moving]))
        (g_0, g_1, g_3, g_4, g_2), (r_0, r_1, r_3, r_4, _) = gaps, rates
        self.curvature = np.nan_to_num((16.0 * (g_1 + g_3) - g_0 - g_4 - 30.0 * g_2) / (12.0 * e * e))
        turning = (r_0 - 8.0 * r_1 + 8.0 * r_3 - r_4) / (12.0 * e)
        at = self._rows_at(keys)
        self._place(v, moving, ahead)
        J = np.zeros((len(contacts), 2, len(moving), v.shape[1]))
        for k, c in enumerate(contacts):
            normal, point = assembly.found.normal[c], assembly.found.point[c]
            if at[k] >= 0:
                normal, point = self.found.normal[at[k]], self.found.point[at[k]]
            along = t[k] - (t[k] @ normal) * normal
            for b, sign in zip(np.searchsorted(moving, ends[k]), (-1.0, 1.0), strict=True):
                arm = point - bodies.motion.x[moving[b], :d]
                J[k, 0, b] += sign * row_of(normal, arm)
                J[k, 1, b] += sign * row_of(along, arm)
        rows = np.concatenate((J.reshape(-1, *J.shape[2:]), self._rows_of_joints(blocks, moving)))
        bodies.motion.x[moving] = kept
        images = np.einsum("rbx,bxy->rby", rows, network.M_inv[moving]).reshape(len(rows), -1)
        b = np.einsum("rbx,bx->r", rows, self._free_accelerations(v, moving))
        m = len(contacts)
        b[0 : 2 * m : 2] += self.curvature
        b[2 * m :] += turning
        left = without_joints(images @ rows.reshape(len(rows), -1).T, b, np.arange(len(rows)) >= 2 * m)
        self.G, self.b = left.G.reshape(m, 2, m, 2), left.c[::2]

    def _rows_of_joints(self, blocks: list[int], moving: np.ndarray) -> np.ndarray:
        """The rows of blocks of joints at the places of the bodies; those that a block does not use are 0."""
        joints, x, d = self.assembly.joints, self.assembly.bodies.motion.x, self.assembly.dim
        rows = np.zeros((len(blocks), d, len(moving), 3 * (d - 1)))
        for at, k in enumerate(blocks):
            for row in np.flatnonzero(joints.w[k] != UNUSED):
                for b, sign in ((joints.i[k], -1.0), (joints.j[k], 1.0)):
                    force, moment = wrench(joints, x, k, row, b)
                    rows[at, row, np.searchsorted(moving, b)] = sign * np.array((*force[:d], *moment[FIRST_TURN[d] :]))
        return rows.reshape(-1, len(moving), 3 * (d - 1))

    def _free_accelerations(self, v: np.ndarray, moving: np.ndarray) -> np.ndarray:
        """M^-1 h of some bodies: gravity, what is applied, and what the inertia of a spatial one turns it by."""
        bodies, network, d = self.assembly.bodies, self.assembly.network, self.assembly.dim
        M, M_inv = network.M[moving], network.M_inv[moving]
        rates = np.zeros((len(moving), v.shape[1]))
        rates[M_inv[:, 0, 0] > 0.0, :d] = bodies.gravity
        rates += np.einsum("bxy,by->bx", M_inv, bodies.load[moving])
        if d == 3:
            spin = v[moving, 3:]
            turning = np.cross(spin, np.einsum("bxy,by->bx", M[:, 3:, 3:], spin))
            rates[:, 3:] -= np.einsum("bxy,by->bx", M_inv[:, 3:, 3:], turning)
        return rates

    def _place(self, v: np.ndarray, moving: np.ndarray, time: float) -> None:
        """Put the bodies where they are after a time from the beginning of the step."""
        bodies = self.assembly.bodies
        for b in moving:
            bodies.motion.x[b] = bodies.x_0[b]
            (move_2 if self.assembly.dim == 2 else move_3)(bodies, b, time, v)

    def _gaps(self, keys: np.ndarray, v: np.ndarray, moving: np.ndarray, time: float) -> np.ndarray:
        """The gaps of contacts (m,) after a time; NaN of one that is not found there."""
        self._place(v, moving, time)
        places, progress = self.assembly.progress.places, self.assembly.progress
        margin = float(progress.margin)
        n = int(
            self.assembly.stages.find(places.shapes, places.motion, 0.0, margin, self.found.address, places.scratch)
        )
        self.n = n if 0 <= n <= len(self.found.gap) else 0
        at = self._rows_at(keys)
        return np.where(at >= 0, self.found.gap[at], np.nan)

    def _rows_at(self, keys: np.ndarray) -> np.ndarray:
        """Where contacts stand among those found last; -1 where they do not."""
        at = np.minimum(np.searchsorted(self.found.key[: self.n], keys), max(self.n - 1, 0))
        return np.where(self.found.key[at] == keys if self.n else False, at, -1)


def row_of(axis: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """The row (axis, arm x axis) of a body."""
    if len(axis) == 2:
        return np.array([axis[0], axis[1], arm[0] * axis[1] - arm[1] * axis[0]])
    return np.concatenate((axis, np.cross(arm, axis)))


def fastest(v: np.ndarray, reach: np.ndarray, d: int) -> float:
    """The rate at which the fastest of some bodies moves by its own reach [1/s]."""
    return float((np.linalg.norm(v[:, :d], axis=1) / reach + np.linalg.norm(v[:, d:], axis=1)).max())
