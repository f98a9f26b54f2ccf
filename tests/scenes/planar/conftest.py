"""Planar shapes and motions for the tests of detection."""

from dataclasses import dataclass

import numpy as np
import pytest

from nonsmooth.jit import interpreted
from nonsmooth.jit.blocks import new
from nonsmooth.scenes.detection import Found, Motion
from nonsmooth.scenes.planar.find_contacts import find_contacts
from nonsmooth.scenes.planar.placement import planar_scratch
from nonsmooth.scenes.shape_rows import HALF_PLANE, HULL, ShapeRow, shape_block


@dataclass
class Detection:
    """A planar scene, one shape a body unless rows say otherwise."""

    rows: list
    x: np.ndarray
    v: np.ndarray | None = None
    moves: np.ndarray | None = None
    apart: tuple = ()
    room: int = 64
    pairs: int = 64

    def __post_init__(self):
        x = np.asarray(self.x, dtype=float).reshape(-1, 3)
        self.shapes, self.motion = shape_block(self.rows, self.apart), new(Motion, n_b=len(x), n_x=3, n=3)
        self.motion.x[:] = x
        self.motion.v[:] = 0.0 if self.v is None else self.v
        self.motion.moves[:] = 1 if self.moves is None else self.moves
        self.found, self.scratch = new(Found, m=self.room, d=2), planar_scratch(self.shapes, self.pairs)

    def run(self, margin=1e-3, dt=1e-3, is_compiled=True):
        if is_compiled:
            return find_contacts(self.shapes.address, self.motion.address, dt, margin,
                                 self.found.address, self.scratch.address)  # fmt: skip
        return interpreted(find_contacts)(self.shapes, self.motion, dt, margin, self.found, self.scratch)

    def contacts(self, **options):
        """(gap, normal, point, key) of what is found."""
        n = self.run(**options)
        assert 0 <= n <= self.room
        f = self.found
        return f.gap[:n].copy(), f.normal[:n].copy(), f.point[:n].copy(), f.key[:n].copy()


class Shapes2:
    """Rows of shapes of a body."""

    @staticmethod
    def disc(body, r=0.5, place=(0, 0, 0)):
        return ShapeRow(body, HULL, place, r, vertices=[(0, 0)])

    @staticmethod
    def capsule(body, half=0.5, r=0.2, place=(0, 0, 0)):
        return ShapeRow(body, HULL, place, r, vertices=[(-half, 0), (half, 0)])

    @staticmethod
    def box(body, a=0.5, b=0.5, r=0.0, place=(0, 0, 0)):
        return ShapeRow(body, HULL, place, r, vertices=[(-a, -b), (a, -b), (a, b), (-a, b)])

    @staticmethod
    def polygon(body, vertices, r=0.0, place=(0, 0, 0)):
        return ShapeRow(body, HULL, place, r, vertices=vertices)

    @staticmethod
    def half_plane(body, place=(0, 0, 0)):
        return ShapeRow(body, HALF_PLANE, place)


@pytest.fixture(scope="session")
def planar():
    return Detection


@pytest.fixture(scope="session")
def shape():
    return Shapes2
