"""A scene with compliant contacts in motion: the blocks of its steps, and the room that they need.

What a run asks of it is what it asks of `Assembly`: steps, contacts, works, figures.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from nonsmooth.contact.network.problem import Network
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.in_motion import InMotion
from nonsmooth.integrators.assembly.in_motion import Stages as Kernels
from nonsmooth.integrators.assembly.joints import Reactions, leave_out_ignored
from nonsmooth.integrators.assembly.pairs import Pairs, begin_pairs, list_pairs, settle_pairs
from nonsmooth.integrators.assembly.paradox_events import Paradoxes
from nonsmooth.integrators.assembly.progress import DONE
from nonsmooth.integrators.assembly.sleep import ContactRows, rows_of_step
from nonsmooth.integrators.assembly.spatial import turn_inertia
from nonsmooth.integrators.assembly.spring_rows import TORSION
from nonsmooth.integrators.assembly.spring_rows import Springs as Coils
from nonsmooth.integrators.assembly.step import contacts_of, write_masses
from nonsmooth.integrators.assembly.world import World
from nonsmooth.integrators.penalty.law import LAWS, Regularised, TangentialSpring
from nonsmooth.integrators.penalty.options import TIME_RESOLUTION, Penalty
from nonsmooth.integrators.springs.blocks import Books, SpringPlaces, Stages
from nonsmooth.integrators.springs.exchange import N_POWERS, book_exchanges
from nonsmooth.integrators.springs.held import Row, hold_bodies
from nonsmooth.integrators.springs.law import Law, Springs
from nonsmooth.integrators.springs.steps import (
    ASKS,
    Course,
    Scales,
    take_spring_steps,
)
from nonsmooth.integrators.springs.table import STAGES
from nonsmooth.jit.blocks import new
from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.detection import Found
from nonsmooth.scenes.find_contacts import find_contacts
from nonsmooth.scenes.planar.placement import planar_scratch
from nonsmooth.scenes.shape_rows import POLYHEDRON, Shapes
from nonsmooth.scenes.spatial.placement import spatial_scratch

LONGEST = 1.0  # derived: in 1/omega: a third of the time that a contact lasts, and as far as the method is stable
FIRST = 1e-2  # chosen: of that, the first step


class SceneSprings(InMotion):
    """A scene in motion.

    Parameters
    ----------
    world : World
    options : Penalty
    t_0, t_1 : float
        Start and end [s].
    keeps_pairs : bool
        Whether what each pair of bodies exchanges is summed up (exchange.py).
    ask : callable, optional
        ask(t) writes what functions say of a time t [s] and the state at hand: forces, and where guided bodies are.

    Raises
    ------
    InvalidInput
        For a stiffness that rounding does not resolve.
    """

    handed = tuple(name for name in SpringPlaces.__annotations__ if name != "motion")
    kept = "bodies", "found", "network", "springs", "rates", "ledger", "pairs", "progress", "drives", "reactions"
    n_islands = 0  # of contact problems, which springs have none of

    def __init__(
        self, world: World, options: Penalty, t_0: float, t_1: float, keeps_pairs: bool = False,
        ask: Callable[[float], None] | None = None,
    ) -> None:  # fmt: skip
        self.bodies, self.shapes, self.surfaces, self.tol = world.bodies, world.shapes, world.surfaces, options.rtol
        self.joints, self.coils, self.drives, self.ask = world.joints, world.springs, world.drives, ask
        bodies, shapes = self.bodies, self.shapes
        self.dim, n_b, n_s = len(bodies.gravity), len(bodies.mass), len(shapes.body)
        sizes = {"n_b": n_b, "n": 3 * (self.dim - 1), "n_x": 4 * self.dim - 5}
        self.law, self.rates, self.ledger = law_of(options), new(Stages, **sizes), new(Books)
        self.smallest = half_thickness(shapes)
        self.row, self.reactions = new(Row, n=sizes["n"]), new(Reactions, n_n=len(self.joints.begin), d=self.dim)
        self.scales = scales_of(bodies, shapes, options, self.smallest, self.coils)
        self.omega = float(self.scales.omega.max(initial=0.0))
        require_resolved(options, self.omega, float(np.abs(bodies.motion.x[:, : self.dim]).max(initial=0.0)))
        booked = (book_exchanges, settle_pairs, begin_pairs, list_pairs) if keeps_pairs else ()
        others = () if self.dim == 2 else (turn_inertia, *contacts_of(shapes, self.dim))
        scratch = planar_scratch if self.dim == 2 else spatial_scratch
        entry = take_spring_steps[self.dim], find_contacts[self.dim]
        others += (leave_out_ignored,) if self.joints.apart else ()
        others += (hold_bodies,) if self.joints.count + self.coils.count + self.drives.count else ()
        self.stages = Kernels(*entry, scratch, (*others, *booked))
        self.stages.load()
        self.progress: Course = new(Course)
        self.progress.asks = ask is not None
        self.paradoxes: Paradoxes = new(Paradoxes, most=0, told=0)  # springs have a motion whatever the friction
        self.progress.t = self.progress.target = t_0
        self.progress.h = FIRST * self.scales.longest
        if not math.isfinite(self.scales.longest):  # nothing that moves
            self.scales.longest = self.progress.h = max(t_1 - t_0, 1.0)
        self._make_scratch(4 * n_s + 64)
        self.pairs: Pairs = new(Pairs, n_p=2 * n_s + 16 if keeps_pairs else 0, d=self.dim)
        self.pairs.is_asked = keeps_pairs
        self.springs: Springs = self._new_springs(0)
        self._make_room(2 * n_s + 16)

    def take_steps(self, dt: float, most: int, t: float = 0.0) -> int:
        """Take so many steps, as long as their error allows, to ``progress.target`` at most; returns DONE, LOST or
        VANISHED."""
        first = int(self.progress.counts.steps)
        while True:
            end = int(self.stages.take(self.progress.address, most - (int(self.progress.counts.steps) - first)))
            if end == ASKS:
                self._ask()
            elif not self.make_more_room(end):
                break
        if end != DONE:
            self.network.n_c = 0  # contacts of a step that was tried in vain
        return end

    def _ask(self) -> None:
        """Ask functions at the stage at hand; a step of which one says nothing that can be used is not begun."""
        assert self.ask is not None
        try:
            self.ask(float(self.progress.asked))
        except BaseException:
            self.bodies.motion.x[:], self.bodies.motion.v[:] = self.bodies.x_0, self.bodies.v_0
            self.progress.is_begun = 0
            raise
        self.progress.is_told = 1

    def contact_rows(self) -> ContactRows:
        """The contacts of the last step, with their forces."""
        return rows_of_step(self.found, self.network, self.network.P)

    @property
    def n_contacts(self) -> int:
        """Those of the last step."""
        return int(self.network.n_c)

    def end_step(self) -> None:
        """A step that Ctrl-C cut short has ended: the compiled steps come back whole."""

    @property
    def sizes(self) -> np.ndarray:
        """Of the blocks: contacts, pairs of shapes and pairs of bodies that there is room for."""
        return np.array([len(self.found.gap), self.room, len(self.pairs.i)])

    def restore(self, sizes: np.ndarray) -> None:
        """Blocks of such sizes, into which what was carried may be copied; ``go_on`` afterwards."""
        m, room, n_p = map(int, sizes)
        self._make_scratch(room)
        if self.pairs.is_asked:
            self._make_room_for_pairs(n_p)
        self._make_room(m)

    def _make_room(self, m: int) -> None:
        """Blocks for m contacts; the springs are carried over, and rates are computed anew."""
        n_b, n, before = len(self.bodies.mass), 3 * (self.dim - 1), self.springs
        self.found: Found = new(Found, m=m, d=self.dim)
        self.network: Network = new(Network, m=m, n_b=n_b, d=self.dim, n=n)
        write_masses(self.bodies, self.network)
        self.springs = self._new_springs(m)
        k = int(before.n_before)
        self.springs.n_before = k
        for name in ("key_before", "point_before", "normal_before", "xi"):
            getattr(self.springs, name)[:k] = getattr(before, name)[:k]
        self.progress.is_warm = 0
        self.go_on()

    def _new_springs(self, m: int) -> Springs:
        """Room for m springs, and for what they do at each stage where pairs are asked for."""
        exchanged = self.dim + N_POWERS if self.pairs.is_asked else 0
        springs: Springs = new(Springs, m=m, d=self.dim, stages=STAGES, exchanged=exchanged)
        springs.is_asked = self.pairs.is_asked
        return springs


def require_resolved(options: Penalty, omega: float, size: float) -> None:
    """Refuse a stiffness at which the rounding of a gap is more than the tolerance."""
    noise = omega * EPS * size
    if noise > TIME_RESOLUTION * options.rtol:
        raise InvalidInput(
            f"stiffness = {options.stiffness:g} N/m makes of the rounding of a gap, {EPS * size:.1e} m, a velocity of "
            f"{noise:.1e} m/s, and rtol = {options.rtol:g} cannot be met: take a smaller stiffness, or a larger rtol"
        )


def law_of(options: Penalty) -> Law:
    """The coefficients of all contacts."""
    law: Law = new(Law)
    law.law, law.k, law.c, law.mass = LAWS[options.law], options.stiffness, options.damping or 0.0, options.mass or 0.0
    law.zeta = -1.0 if options.damping_ratio is None else options.damping_ratio
    if isinstance(options.friction, Regularised):
        law.is_regularised, law.v_s = 1, options.friction.v_s
    else:
        spring = options.friction if isinstance(options.friction, TangentialSpring) else TangentialSpring()
        law.ratio = spring.ratio
    return law


def scales_of(bodies: Bodies, shapes: Shapes, options: Penalty, half: float, coils: Coils) -> Scales:
    """Reach and frequency of each body, and the longest step."""
    scales: Scales = new(Scales, n_b=len(bodies.mass))
    scales.rtol, scales.atol, scales.thinnest = options.rtol, options.atol, 2.0 * half
    out = np.linalg.norm(shapes.place[:, : len(bodies.gravity)], axis=1) + shapes.reach + shapes.radius
    is_bounded = np.isfinite(out)
    np.maximum.at(scales.reach, shapes.body[is_bounded], out[is_bounded])
    moves = bodies.motion.moves == 1
    # Hunt and Crossley's spring is k sqrt(d) stiff; a metre is deeper than any contact
    stiffness, turning = np.full(len(moves), options.stiffness), np.zeros(len(moves))
    for ends in (coils.i, coils.j):
        is_line = coils.axis != TORSION
        np.add.at(stiffness, ends[is_line], coils.stiffness[is_line])
        np.add.at(turning, ends[~is_line], coils.stiffness[~is_line])
    square = stiffness[moves] / bodies.mass[moves] + turning[moves] / bodies.moments[moves, 0]
    scales.omega[moves] = np.sqrt(square)
    with np.errstate(divide="ignore"):
        scales.longest = float(LONGEST / scales.omega.max(initial=0.0))
    return scales


def half_thickness(shapes: Shapes) -> float:
    """Of the thinnest shape [m]: deeper than that a contact is on the other side. A wall without thickness has none."""
    bounded = np.flatnonzero(np.isfinite(shapes.reach)).tolist()
    halves = [half_width(shapes, s) + float(shapes.radius[s]) for s in bounded]
    return min((half for half in halves if half > 0.0), default=math.inf)


def half_width(shapes: Shapes, s: int) -> float:
    """Of the core of a bounded shape [m], the least; of polygons and polyhedra the least across an edge or a face."""
    if shapes.kind[s] == POLYHEDRON:
        solids = shapes.solids
        vertices = rows_of(solids.vertices, solids.first[s], solids.count[s])
        return half_across(vertices, rows_of(solids.normal, solids.first_face[s], solids.faces[s]))
    if shapes.count[s] > 2:
        place = shapes.first[s], shapes.count[s]
        return half_across(rows_of(shapes.vertices, *place), rows_of(shapes.normals, *place))
    return float(shapes.size[s].min())


def rows_of(column: np.ndarray, first: int, count: int) -> np.ndarray:
    """Some rows of a column."""
    return column[int(first) : int(first) + int(count)]


def half_across(vertices: np.ndarray, normals: np.ndarray) -> float:
    """Half the least width of a convex core along a normal of it [m]."""
    along = vertices @ normals.T  # [vertex, normal]
    return float(0.5 * (along.max(axis=0) - along.min(axis=0)).min())
