"""Scenes of boxes and discs in pymunk: ten iterations, a slop for metres. It multiplies coefficients of friction."""

import math

import numpy as np
import pymunk

from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.inertia import inertia_of
from nonsmooth.scenes.shapes import Box, Polygon

SLOP = 1e-4  # m, chosen: a thousandth of the bodies; its own, 0.1, is for pixels
FAR, DEEP = 1e3, 1.0  # m, chosen: length and thickness of what stands for a half-plane


class Motion:
    """A scene in motion."""

    def __init__(self, scene, dt):
        self.dt, self.space = dt, pymunk.Space()
        self.space.gravity = tuple(float(g) for g in scene.gravity)
        self.space.collision_slop = SLOP
        self.bodies = [body for given in scene.bodies if (body := self.add(given)) is not None]

    def add(self, given):
        shape, body = given.shape, None
        if given.kind is Kind.FIXED:
            along, origin = np.array([shape.normal[1], -shape.normal[0]]), (shape.offset - DEEP) * shape.normal
            made = pymunk.Segment(
                self.space.static_body, (origin - FAR * along).tolist(), (origin + FAR * along).tolist(), DEEP
            )
        else:
            inertia = inertia_of(given, 2)
            body = pymunk.Body(float(inertia.mass), float(inertia.moments[0]))
            body.position, body.angle = tuple(float(x) for x in given.position), float(given.turn)
            body.velocity, body.angular_velocity = tuple(float(v) for v in given.velocity), float(given.spin)
            made = self.shape(body, shape)
            self.space.add(body)
        made.friction = math.sqrt(given.material.mu)
        self.space.add(made)
        return body

    def shape(self, body, shape):
        if isinstance(shape, Box):
            return pymunk.Poly.create_box(body, shape.lengths)
        if isinstance(shape, Polygon):
            return pymunk.Poly(body, shape.vertices.tolist())
        return pymunk.Circle(body, shape.radius)

    def step(self, count):
        for _ in range(count):
            self.space.step(self.dt)

    def places(self):
        return np.array([tuple(body.position) for body in self.bodies]), np.array([body.angle for body in self.bodies])
