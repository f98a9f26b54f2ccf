"""The live view of a run: now and then, at a look of the run, what it has come to is sent to the browser.

A browser that is closed, or one too slow, never stops the run; what cannot be drawn ends the view alone.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from nonsmooth.drawing.live.meshes import is_bounded, mesh_of, outline_of
from nonsmooth.drawing.live.window import Window
from nonsmooth.drawing.player.film import Body
from nonsmooth.drawing.player.scene_film import body_of, lines_of_joints
from nonsmooth.errors import InvalidInput, NonsmoothWarning, said_by, warn_caller
from nonsmooth.runs.recorder import contacts_of
from nonsmooth.runs.scene_run import SceneRun
from nonsmooth.runs.system_run import SystemRun
from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.shapes import PLANAR

PICTURE_PERIOD = 0.05  # chosen: s of wall time between two pictures
PICTURE_SHARE = 0.05  # chosen: of the wall time, that pictures may take
ROOM_ABOUT = 1.3  # chosen: of the size of what is seen at the start
# chosen: those of the player, darker, since viser's lights make them paler
LIVE_FILL = {Kind.DYNAMIC: "#4292c6", Kind.FIXED: "#a6a6a6", Kind.KINEMATIC: "#f16913"}
MOST_EDGES = 5000  # chosen: of planar bodies that have outlines, which are sent anew for each picture
LAND_REACH = 3.0  # chosen: of that size: how far a half-space is drawn


class LiveView(ABC):
    """What a browser is shown of a run.

    Parameters
    ----------
    run : SystemRun or SceneRun
    """

    window: Window

    def __init__(self, run: Any) -> None:
        self.run = run
        self.due, self.is_over = 0.0, False
        self.open()
        self.look()

    @abstractmethod
    def open(self) -> None:
        """Make the window, with all that does not change."""

    @abstractmethod
    def draw(self) -> None:
        """Show the present state."""

    @property
    @abstractmethod
    def now(self) -> float:
        """The time that the run has come to [s]."""

    def look(self) -> None:
        """Show the present state, if the last picture is old enough; it may warn, and raises nothing."""
        began = time.perf_counter()
        if self.is_over or began < self.due:
            return
        try:
            self.draw()
            self.window.say(f"**t = {self.now:.6g} s**")
        except Exception as error:
            self.is_over = True
            warn_caller(f"the live view ended, and the run goes on: {said_by(error)}", NonsmoothWarning)
        spent = time.perf_counter() - began
        self.due = began + max(PICTURE_PERIOD, spent / PICTURE_SHARE)

    def close(self) -> None:
        """Show the last state."""
        self.due = 0.0
        self.look()
        self.window.close()


class LiveModel(LiveView):
    """Lines of ``shape(q)`` and ``outline()``, and closed contacts."""

    run: SystemRun

    def open(self) -> None:
        """Open a window on the lines of the model."""
        self.model = self.run.system.described
        if self.model.shape is None:
            raise InvalidInput("this system has nothing to show: its model has no shape(q); leave view=True out")
        self.still = segments_of(self.model.outline() if self.model.outline else [])
        points = np.concatenate([self.still, self.segments()]).reshape(-1, 3)
        centre, radius = ball_about(points)
        title = type(self.run.system.parameters).__name__
        self.window = Window(title, centre, radius, is_planar=True)

    def segments(self) -> np.ndarray:
        """Of the bodies (n, 2, 3)."""
        assert self.model.shape is not None
        return segments_of(self.model.shape(self.run.state.q))

    def draw(self) -> None:
        self.window.draw_lines(np.concatenate([self.still, self.segments()]))
        if self.model.contact_frames is not None:
            points = self.model.contact_frames(self.run.state.q)[0]
            is_drawn = np.isfinite(points[:, 0]) & (self.run.state.mode != 0)
            self.window.draw_contacts(in_space(points[is_drawn]))

    @property
    def now(self) -> float:
        return self.run.now


class LiveScene(LiveView):
    """Bodies with their shapes, axes and limits of joints, and contacts that had an impulse in the last step."""

    run: SceneRun

    def open(self) -> None:
        """Open a window on the bodies."""
        run = self.run
        bodies = [body_of(body, run.centres[body.index], run.scene.dim) for body in run.scene.bodies]
        position, _ = self.poses()
        self.is_far = np.array([not is_bounded(body) for body in bodies])
        centre, radius = self.extent(bodies, position)
        is_planar = run.scene.dim == PLANAR
        self.window = Window(f"scene of {len(bodies)} bodies", centre, radius, is_planar)
        reach = LAND_REACH * radius + np.linalg.norm(position - centre, axis=1)
        meshes = [mesh_of(body, far) for body, far in zip(bodies, reach.tolist(), strict=True)]
        self.window.add_bodies(meshes, [LIVE_FILL[body.kind] for body in run.scene.bodies], is_seen_behind=is_planar)
        outlines = [outline_of(mesh) for mesh in meshes] if is_planar else []
        self.outlines = np.concatenate(outlines) if 0 < sum(map(len, outlines)) <= MOST_EDGES else np.zeros((0, 2, 3))
        self.outlined = np.repeat(np.arange(len(outlines)), [len(outline) for outline in outlines])
        if not len(self.outlines):
            self.outlined = self.outlined[:0]
        joints = [
            segments_of(lines) for lines in lines_of_joints(bodies, run.scene.bodies, run.scene.joints, run.centres)
        ]
        self.outlines = np.concatenate([self.outlines, *joints])
        self.outlined = np.concatenate([self.outlined, np.repeat(np.arange(len(joints)), list(map(len, joints)))])

    def extent(self, bodies: list[Body], position: np.ndarray) -> tuple[np.ndarray, float]:
        """Centre and radius of what has bounds, at the start."""
        near = np.flatnonzero(~self.is_far)
        if not len(near):
            return position.mean(axis=0), 1.0
        sizes = np.array([mesh_of(bodies[b], 0.0).size for b in near])[:, None]
        return ball_about(np.concatenate([position[near] - sizes, position[near] + sizes]))

    def poses(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions (n_b, 3) of centres of mass, and turns (n_b, 4) of the shapes."""
        x, d = self.run.world.bodies.motion.x, self.run.scene.dim
        if d != PLANAR:
            return x[:, :d].copy(), self.run.world.turns(x[None, :, d:])[0]
        half = 0.5 * x[:, d]
        return in_space(x[:, :d]), np.column_stack([np.cos(half), 0 * half, 0 * half, np.sin(half)])

    def draw(self) -> None:
        position, turn = self.poses()
        self.window.move(position, turn)
        if len(self.outlines):
            self.window.draw_lines(turned(turn[self.outlined], self.outlines) + position[self.outlined, None])
        found = contacts_of(self.run, ("P", "normal", "point"))
        is_loaded = np.einsum("ck,ck->c", found["P"], found["normal"]) > 0
        self.window.draw_contacts(in_space(found["point"][is_loaded]))

    @property
    def now(self) -> float:
        return self.run.now


def live_model(run: SystemRun) -> LiveView:
    """The live view of a run of a system."""
    return LiveModel(run)


def live_scene(run: SceneRun) -> LiveView:
    """The live view of a run of a scene."""
    return LiveScene(run)


def in_space(points: np.ndarray) -> np.ndarray:
    """Points (..., 3); planar ones in z = 0."""
    return points if points.shape[-1] == 3 else np.concatenate([points, 0 * points[..., :1]], axis=-1)


def turned(turn: np.ndarray, segments: np.ndarray) -> np.ndarray:
    """Segments (n, 2, 3), each turned by a unit quaternion (n, 4)."""
    r, across = turn[:, None, 1:], np.cross(turn[:, None, 1:], segments)
    return np.asarray(segments + 2 * (turn[:, None, :1] * across + np.cross(r, across)))


def segments_of(lines: list[np.ndarray]) -> np.ndarray:
    """The segments (n, 2, 3) of polylines."""
    pieces = [np.stack([line[:-1], line[1:]], axis=1) for line in map(np.asarray, lines)]
    return in_space(np.concatenate(pieces)) if pieces else np.zeros((0, 2, 3))


def ball_about(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Centre and radius [m] of what holds points (n, 3), and some room."""
    low, high = points.min(axis=0), points.max(axis=0)
    return 0.5 * (low + high), ROOM_ABOUT * (0.5 * float(np.linalg.norm(high - low)) or 1.0)
