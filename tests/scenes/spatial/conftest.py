"""Spatial shapes and motions for the tests of detection."""

from dataclasses import dataclass

import numpy as np
import pytest

from nonsmooth.jit import interpreted, load_all
from nonsmooth.jit.blocks import new
from nonsmooth.scenes.detection import Found, Motion
from nonsmooth.scenes.shape_rows import BOX, CAPSULE, HALF_SPACE, SPHERE, ShapeRow, shape_block
from nonsmooth.scenes.spatial.find_contacts import find_contacts
from nonsmooth.scenes.spatial.placement import spatial_scratch
from nonsmooth.scenes.spatial.solids import further_points, solid_contact

HERE = (0, 0, 0, 1, 0, 0, 0)


@dataclass
class Detection:
    """A spatial scene, one shape a body unless rows say otherwise; places (position, unit quaternion) or positions."""

    rows: list
    x: np.ndarray
    v: np.ndarray | None = None
    moves: np.ndarray | None = None
    apart: tuple = ()
    room: int = 64
    pairs: int = 64

    def __post_init__(self):
        load_all([solid_contact, further_points])
        x = np.asarray(self.x, dtype=float)
        self.shapes, self.motion = shape_block(self.rows, self.apart), new(Motion, n_b=len(x), n_x=7, n=6)
        self.motion.x[:, 3] = 1.0
        self.motion.x[:, : x.shape[1]] = x
        self.motion.v[:] = 0.0 if self.v is None else self.v
        self.motion.moves[:] = 1 if self.moves is None else self.moves
        self.found, self.scratch = new(Found, m=self.room, d=3), spatial_scratch(self.shapes, self.pairs)

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


class Shapes3:
    """Rows of shapes of a body."""

    @staticmethod
    def sphere(body, r=0.5, place=HERE):
        return ShapeRow(body, SPHERE, place, r)

    @staticmethod
    def capsule(body, half=0.5, r=0.2, place=HERE):
        return ShapeRow(body, CAPSULE, place, r, (0, 0, half))

    @staticmethod
    def box(body, a=0.5, b=0.5, c=0.5, r=0.0, place=HERE):
        return ShapeRow(body, BOX, place, r, (a, b, c))

    @staticmethod
    def half_space(body, place=HERE):
        return ShapeRow(body, HALF_SPACE, place)


@pytest.fixture(scope="session")
def spatial():
    return Detection


@pytest.fixture(scope="session")
def solid():
    return Shapes3
