"""A step of a scene, as a table of contents: predict, find contacts, solve them, move, rebound, book.

    v_free = v_0 + dt M^-1 h,    (gamma_1 + g_N/dt, P) in the laws of contact and friction,    v_1 = v_free + M^-1 J^T P

Each stage is one compiled call; Python decides nothing but what room the blocks need and whether a stage has anything to
do. Sources: Stewart and Trinkle, *Int. J. Numer. Methods Eng.* 39 (1996) 2673-2691 (gaps at the end of the step); the
stages of this scheme and their figures are in docs/theory/scenes.md.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from nonsmooth.contact.network.problem import Network, prepare_planar, prepare_spatial
from nonsmooth.contact.network.solve import NetworkSolver
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.book import Ledger, book_impact, book_step
from nonsmooth.integrators.assembly.contacts import Contacts, Surfaces, write_contacts_planar, write_contacts_spatial
from nonsmooth.integrators.assembly.impact import begin_impact_planar, begin_impact_spatial
from nonsmooth.integrators.assembly.planar import predict_planar
from nonsmooth.integrators.assembly.project import Moves, move_bodies_planar, move_bodies_spatial
from nonsmooth.integrators.assembly.spatial import predict_spatial, turn_inertia
from nonsmooth.jit import Kernel, load_all
from nonsmooth.jit.blocks import new
from nonsmooth.scenes.detection import NOT_FINITE, Found
from nonsmooth.scenes.planar.find_contacts import find_contacts as find_contacts_planar
from nonsmooth.scenes.planar.placement import planar_scratch
from nonsmooth.scenes.shape_rows import Shapes

MARGIN = 100.0  # measured: g dt^2 of the margin: with 25 a neighbour pushes bodies into pairs that were not listed
REACH_SHARE = 0.25  # chosen: of the largest bounded shape that the margin may be
# chosen: a penetration below this part of the smallest shape is a rounding, and is not taken back
TIGHT = 1e-10
ROOM = 1.5  # chosen: by which a block is larger than what it was too small for


class Stages(NamedTuple):
    """The compiled stages of a step, in the plane or in space."""

    predict: Kernel
    find: Kernel
    scratch: Callable[..., Any]
    write: Kernel
    prepare: Kernel
    move: Kernel
    begin_impact: Kernel
    turn_inertia: Kernel | None

    def load(self) -> None:
        """Compile them, or read them from disk."""
        load_all([stage for stage in (*self, book_step, book_impact) if isinstance(stage, Kernel)])


def stages_of(dim: int) -> Stages:
    """Those of the plane or of space; nothing of the other is compiled."""
    if dim == 2:
        return Stages(
            predict_planar, find_contacts_planar, planar_scratch, write_contacts_planar, prepare_planar,
            move_bodies_planar, begin_impact_planar, None,
        )  # fmt: skip
    from nonsmooth.scenes.spatial.find_contacts import find_contacts as find_contacts_spatial
    from nonsmooth.scenes.spatial.placement import spatial_scratch

    return Stages(
        predict_spatial, find_contacts_spatial, spatial_scratch, write_contacts_spatial, prepare_spatial,
        move_bodies_spatial, begin_impact_spatial, turn_inertia,
    )  # fmt: skip


class Assembly:
    """A scene in motion.

    Parameters
    ----------
    bodies, shapes, surfaces : Bodies, Shapes, Surfaces
    solver : NetworkSolver
        Of the contact problems.
    theta : float
        Weight of the new velocity in the places of islands without impacts.
    guide : callable
        Sets the velocities of guided bodies for a step: guide(t, dt).
    """

    def __init__(
        self, bodies: Bodies, shapes: Shapes, surfaces: Surfaces, solver: NetworkSolver, theta: float,
        guide: Callable[[float, float], None] | None,
    ) -> None:  # fmt: skip
        self.bodies, self.shapes, self.surfaces, self.solver = bodies, shapes, surfaces, solver
        self.theta, self.guide = theta, guide
        self.dim = len(bodies.gravity)
        self.stages = stages_of(self.dim)
        self.stages.load()
        bounded = shapes.reach[np.isfinite(shapes.reach)] + shapes.radius[np.isfinite(shapes.reach)]
        self.largest, self.smallest = bounded.max(initial=0.0), bounded.min(initial=np.inf)
        self.ledger = new(Ledger)
        n_s = len(shapes.body)
        self.scratch = self.stages.scratch(shapes, 4 * n_s + 64)
        self._make_room(2 * n_s + 16)
        self.has_restitution = bool((surfaces.e > 0).any())
        self.residual = self.deepest = 0.0
        self.rebounds = 0
        self.gravity = float(np.linalg.norm(bodies.gravity))

    def _make_room(self, m: int) -> None:
        """Blocks for m contacts; the impulses of the step before are carried over."""
        d, n, n_b = self.dim, 3 * (self.dim - 1), len(self.bodies.mass)
        before = getattr(self, "contacts", None)
        self.found = new(Found, m=m, d=d)
        self.contacts = new(Contacts, m=m, d=d)
        self.moves = new(Moves, m=m, n_b=n_b, n=n)
        network = new(Network, m=m, n_b=n_b, d=d, n=n)
        if before is None:
            write_masses(self.bodies, network)
        else:
            k = before.n_before
            self.contacts.n_before = k
            self.contacts.key_before[:k], self.contacts.P_before[:k] = before.key_before[:k], before.P_before[:k]
            network.M[:], network.M_inv[:] = self.network.M, self.network.M_inv
            network.v[:], network.v_free[:] = self.network.v, self.network.v_free
        self.network = network

    def margin(self, dt: float) -> float:
        """Gap below which two shapes are candidates for a contact within a step [m]."""
        return float(min(MARGIN * self.gravity * dt * dt, REACH_SHARE * self.largest))

    def find_contacts(self, dt: float) -> int:
        """Fill `Found`; returns the number of contacts."""
        while True:
            blocks = self.shapes.address, self.bodies.motion.address
            n = self.stages.find(*blocks, dt, self.margin(dt), self.found.address, self.scratch.address)
            if n == NOT_FINITE:
                raise FloatingPointError
            if n < 0:
                self.scratch = self.stages.scratch(self.shapes, int(ROOM * -n))
            elif n > len(self.found.gap):
                self._make_room(int(ROOM * n))
            else:
                return int(n)

    def step(self, t: float, dt: float) -> None:
        """One step."""
        bodies, stages = self.bodies, self.stages
        if self.guide is not None:
            self.guide(t, dt)
        stages.predict(bodies.address, dt)
        n_c = self.find_contacts(dt)
        network, found, contacts, moves = self.network, self.found, self.contacts, self.moves
        network.n_c = n_c
        network.v_free[:] = bodies.v_free
        if stages.turn_inertia is not None and n_c > 0:
            stages.turn_inertia(bodies.address, network.address)
        shared = bodies.address, found.address, contacts.address, network.address
        stages.write(bodies.address, self.shapes.address, self.surfaces.address, *shared[1:], dt)
        stages.prepare(network.address)
        self.residual = self.solver.solve(network)
        self.deepest = float(found.gap[:n_c].min(initial=0.0))
        is_pushed = int(self.deepest < -TIGHT * self.smallest)
        stages.move(bodies.address, found.address, network.address, moves.address, dt, self.theta, is_pushed)
        book_step(*shared, moves.address, self.ledger.address, dt, is_pushed)
        self.rebounds = 0
        if self.has_restitution and n_c > 0 and stages.begin_impact(*shared, dt) > 0:
            self.rebounds = 1
            if stages.turn_inertia is not None:
                stages.turn_inertia(bodies.address, network.address)
            stages.prepare(network.address)
            self.residual = max(self.residual, self.solver.solve(network))
            book_impact(bodies.address, contacts.address, network.address, self.ledger.address)


def write_masses(bodies: Bodies, network: Network) -> None:
    """M and M^-1 of all bodies; of what impulses do not move, M^-1 is 0. A spatial body's are those of its axes."""
    d = len(bodies.gravity)
    for b in np.flatnonzero(bodies.motion.moves):
        moments = [bodies.mass[b]] * d + (list(bodies.moments[b]) if d == 3 else [bodies.moments[b, 0]])
        np.fill_diagonal(network.M[b], moments)
        np.fill_diagonal(network.M_inv[b], 1.0 / np.array(moments))
