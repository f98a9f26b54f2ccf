"""Scenes of boxes and spheres in PyBullet: defaults, no damping. It multiplies coefficients of friction.

Its guide (setPhysicsEngineParameter) has ``iterations``, the most of the solver, 50 by default.
"""

import math

import numpy as np
import pybullet as b3

from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.inertia import inertia_of
from nonsmooth.scenes.shapes import Box


class Motion:
    """A scene in motion, in a world of its own."""

    def __init__(self, scene, dt, iterations=50):
        self.world = {"physicsClientId": b3.connect(b3.DIRECT)}
        b3.setGravity(*np.asarray(scene.gravity, dtype=float).tolist(), **self.world)
        b3.setPhysicsEngineParameter(fixedTimeStep=dt, numSolverIterations=iterations, **self.world)
        shapes = {}
        self.bodies = [number for body in scene.bodies if (number := self.add(body, shapes)) is not None]

    def add(self, body, shapes):
        """Its number, if it moves; shapes that occur again are made once."""
        key = repr(body.shape)
        if key not in shapes:
            shapes[key] = self.shape(body)
        if body.kind is Kind.FIXED:
            place = (body.shape.offset * body.shape.normal).tolist()
            number = b3.createMultiBody(0, shapes[key], basePosition=place, **self.world)
        else:
            w, x, y, z = np.asarray(body.turn, dtype=float).tolist()
            mass, place = float(inertia_of(body, 3).mass), np.asarray(body.position, dtype=float).tolist()
            number = b3.createMultiBody(
                mass, shapes[key], basePosition=place, baseOrientation=(x, y, z, w), **self.world
            )
        if body.kind is not Kind.FIXED:
            b3.resetBaseVelocity(number, list(body.velocity), list(body.spin), **self.world)
        b3.changeDynamics(
            number, -1, lateralFriction=math.sqrt(body.material.mu), linearDamping=0, angularDamping=0, **self.world
        )
        return None if body.kind is Kind.FIXED else number

    def shape(self, body):
        shape = body.shape
        if body.kind is Kind.FIXED:
            return b3.createCollisionShape(b3.GEOM_PLANE, planeNormal=shape.normal.tolist(), **self.world)
        if isinstance(shape, Box):
            half = [length / 2 for length in shape.lengths]
            return b3.createCollisionShape(b3.GEOM_BOX, halfExtents=half, **self.world)
        return b3.createCollisionShape(b3.GEOM_SPHERE, radius=shape.radius, **self.world)

    def step(self, count):
        for _ in range(count):
            b3.stepSimulation(**self.world)

    def places(self):
        found = [b3.getBasePositionAndOrientation(number, **self.world) for number in self.bodies]
        return np.array([place for place, _ in found]), np.array([turn for _, turn in found])[:, [3, 0, 1, 2]]

    def close(self):
        b3.disconnect(**self.world)
