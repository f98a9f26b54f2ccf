"""Scenes of boxes and discs in Box2D 2.3: 8 and 3 iterations, as its manual has them. It never sleeps here."""

import Box2D as b2
import numpy as np

from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.inertia import inertia_of
from nonsmooth.scenes.shapes import Box

ITERATIONS = 8, 3  # chosen: of velocities and of places, as its manual has them
HALF_EDGE = 1e3  # m, chosen: half the length of the edge that stands for a half-plane


class Motion:
    """A scene in motion."""

    def __init__(self, scene, dt):
        gravity = tuple(float(g) for g in scene.gravity)
        self.dt, self.world = dt, b2.b2World(gravity=gravity, doSleep=False)
        self.bodies = [body for given in scene.bodies if (body := self.add(given)) is not None]

    def add(self, given):
        shape, mu = given.shape, given.material.mu
        if given.kind is Kind.FIXED:
            along, origin = np.array([shape.normal[1], -shape.normal[0]]), shape.offset * shape.normal
            ends = [tuple((origin + side * HALF_EDGE * along).tolist()) for side in (-1, 1)]
            self.world.CreateStaticBody(fixtures=b2.b2FixtureDef(shape=b2.b2EdgeShape(vertices=ends), friction=mu))
            return None
        is_box, mass = isinstance(shape, Box), float(inertia_of(given, 2).mass)
        area = np.prod(shape.lengths) if is_box else np.pi * shape.radius**2
        made = b2.b2PolygonShape(box=tuple(length / 2 for length in shape.lengths)) if is_box else b2.b2CircleShape(
            radius=shape.radius)  # fmt: skip
        place = tuple(float(x) for x in given.position)
        return self.world.CreateDynamicBody(
            position=place, angle=float(given.turn),
            fixtures=b2.b2FixtureDef(shape=made, density=float(mass / area), friction=mu),
        )  # fmt: skip

    def step(self, count):
        for _ in range(count):
            self.world.Step(self.dt, *ITERATIONS)

    def places(self):
        return np.array([tuple(body.position) for body in self.bodies]), np.array([body.angle for body in self.bodies])
