"""A scene in motion: the blocks of its steps, which are compiled (stages.py), and the room that they need."""

from __future__ import annotations

import functools
from typing import ClassVar

import numpy as np

from nonsmooth.contact.network.matrices import Matrices, unsolved_problem
from nonsmooth.contact.network.parallel import Desks
from nonsmooth.contact.network.problem import Network, judge_network, prepare_network
from nonsmooth.contact.network.rescue import rescue
from nonsmooth.contact.network.solve import OVER_RELAXATION, Solver, solve_network
from nonsmooth.contact.planar.problem import Planar
from nonsmooth.contact.planar.selection import Selection
from nonsmooth.integrators.assembly.adhesion import book_pulls, pull_together
from nonsmooth.integrators.assembly.bearings import Bearings, find_doubtful_machine
from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.book import Ledger, book_impact, book_landing, book_step
from nonsmooth.integrators.assembly.contacts import Contacts, Surfaces, write_contacts
from nonsmooth.integrators.assembly.divided import OF_PARTS, ROOM_OF_PARTS, Parts, with_parts
from nonsmooth.integrators.assembly.doubtful import FEW_TOUCHING, Doubts, find_doubtful
from nonsmooth.integrators.assembly.draw_together import Held, draw_together
from nonsmooth.integrators.assembly.drive_rows import RUBS, Drives, rub_joints, write_drives
from nonsmooth.integrators.assembly.energy_limit import limit_rebounds
from nonsmooth.integrators.assembly.friction import take_friction, update_friction
from nonsmooth.integrators.assembly.grain import turn_to_grain, upright
from nonsmooth.integrators.assembly.held_closed import hold_closed
from nonsmooth.integrators.assembly.hidden import Links, leave_out_hidden
from nonsmooth.integrators.assembly.hold_places import hold_places
from nonsmooth.integrators.assembly.impact import ask_rebounds, begin_impact
from nonsmooth.integrators.assembly.in_motion import ROOM, InMotion, Stages
from nonsmooth.integrators.assembly.joined_trees import solve_trees
from nonsmooth.integrators.assembly.joints import Joints, Reactions, book_reactions, leave_out_ignored, write_joints
from nonsmooth.integrators.assembly.pairs import OF_PAIRS, Pairs
from nonsmooth.integrators.assembly.paradox import Verdict, examine, load_dense_core
from nonsmooth.integrators.assembly.paradox_events import Paradoxes, tell
from nonsmooth.integrators.assembly.progress import (
    BY_LAW,
    DOUBTFUL,
    EXAMINED,
    FIND,
    MORE_FACTORS,
    NOT_MET,
    PREDICT,
    TOGETHER,
    TOO_MANY,
    Progress,
)
from nonsmooth.integrators.assembly.project import HEAP, Moves, move_bodies
from nonsmooth.integrators.assembly.rolling import limit_rolling, write_rolling
from nonsmooth.integrators.assembly.seized import examine_machines
from nonsmooth.integrators.assembly.sleep import Asleep, ContactRows, let_sleep, rows_at_rest, rows_of_step
from nonsmooth.integrators.assembly.spatial import turn_inertia
from nonsmooth.integrators.assembly.spring_rows import SIDES, Springs, write_springs
from nonsmooth.integrators.assembly.stages import predict, take_steps
from nonsmooth.integrators.assembly.struck import strike_by_law
from nonsmooth.integrators.assembly.wandering import ask_of_wandering, note_held
from nonsmooth.integrators.assembly.written import Written, no_records, take_recorded
from nonsmooth.jit import Kernel
from nonsmooth.jit.blocks import Block, keep_rows, new
from nonsmooth.mechanics.laws import ImpactLaw
from nonsmooth.mechanics.situation import largest_closed_gap
from nonsmooth.numerics.rounding import EPS
from nonsmooth.scenes.detection import FIRST_ROLLING, Found
from nonsmooth.scenes.find_contacts import find_contacts
from nonsmooth.scenes.planar.placement import planar_scratch
from nonsmooth.scenes.shape_rows import BOX, HALF_SPACE, Shapes
from nonsmooth.scenes.spatial.placement import spatial_scratch
from nonsmooth.scenes.spatial.solids import further_points, solid_contact

MARGIN = 100.0  # measured: g dt^2 of the margin: with 25 a neighbour pushes bodies into pairs that were not listed
WEIGHTLESS_MARGIN = 1e-3  # chosen: of the largest bounded shape: what touches without gravity is a contact too
REACH_SHARE = 0.25  # chosen: of the largest bounded shape that the margin may be
# measured: of the smallest shape, that sweeps may leave bodies to be driven in by in a step: 2e-4 takes a tenth more
# time, with 8e-4 discs that fall from 5 m are up to a quarter of a millimetre deep. In space, of 10,000 spheres, 1e-3
# takes a seventh more time and leaves 0.08 mm for 0.2, 3e-4 half as much again, 0.03 mm
DRIVEN_IN = {2: 3e-4, 3: 1e-3}
TIGHT = 1e-10  # chosen: of the smallest shape: a penetration below it is a rounding, and is not taken back
MOST_FACTORS = 400  # measured: of an island in a step: heaps that take more do not end

OF_REBOUNDS = (ask_rebounds, limit_rebounds, book_landing, book_impact)  # defined: in the plane and in space

# defined: blocks whose addresses the steps are handed, beside that of the motion of the bodies
PLACES = (
    "bodies",
    "shapes",
    "surfaces",
    "scratch",
    "found",
    "contacts",
    "network",
    "moves",
    "ledger",
    "solver",
    "desk",
    "asleep",
    "joints",
    "held",
    "doubts",
    "pairs",
    "links",
    "parts",
    "springs",
    "reactions",
    "drives",
    "bearings",
)

# defined: blocks that a step takes something from that the step before left
CARRIED = (
    "bodies", "found", "contacts", "network", "moves", "ledger", "solver", "asleep", "pairs", "progress", "paradoxes",
    "parts", "reactions", "drives",
)  # fmt: skip


def stages_of(dim: int, has_restitution: bool, has_joints: bool = False, rare: tuple[Kernel, ...] = ()) -> Stages:
    """Those of the plane or of space, with rare ones of the scene and its run; nothing of the other is compiled, no
    impact where nothing rebounds, and no joint where there is none."""
    of_all = predict, find_doubtful, write_contacts, prepare_network, solve_network, judge_network, move_bodies
    others: list[Kernel] = [entry[dim] for entry in of_all]
    others += [turn_inertia] if dim == 3 else []
    others += [begin_impact[dim], *OF_REBOUNDS] if has_restitution else []
    others += [write_joints, solve_trees[dim], draw_together, hold_places] if has_joints else []
    others += [*rare, ask_of_wandering, note_held, hold_closed, let_sleep, book_step, take_recorded[dim]]
    scratch = planar_scratch if dim == 2 else spatial_scratch
    return Stages(take_steps[dim], find_contacts[dim], scratch, tuple(others))


def may_hide(shapes: Shapes) -> bool:
    """Whether several shapes have plane faces: a seam has two, and a third one meets it."""
    return int((shapes.faces.count > 0).sum()) > 1 and len(shapes.body) > 2


def contacts_of(shapes: Shapes, dim: int) -> tuple[Kernel, ...]:
    """What finds contacts of shapes that few scenes have."""
    if dim == 2:
        return ()
    rare = ((solid_contact, shapes.kind > HALF_SPACE), (further_points, shapes.kind == BOX))
    return tuple(found for found, has in rare if has.any())


class Assembly(InMotion):
    """A scene in motion.

    Parameters
    ----------
    bodies, shapes, surfaces, joints, springs, drives : Bodies, Shapes, Surfaces, Joints, Springs, Drives
    tol : float
        Residual asked of the contact problems.
    sweeps : int
        The most of an island.
    interior : int
        The most bodies of an island that interior points solve.
    is_strict : bool
        Whether a step that misses the tolerance ends the run.
    may_sleep : bool
        Whether steps that would change nothing may be left out.
    theta : float
        Weight of the new velocity in the places of islands without impacts.
    keeps_pairs : bool
        Whether what each pair of bodies exchanges is summed up (pairs.py).
    selection : Selection
        The rule where few contacts have several solutions.
    """

    handed: ClassVar[tuple[str, ...]] = PLACES
    kept: ClassVar[tuple[str, ...]] = CARRIED
    own_stages: ClassVar[tuple[Kernel, ...]] = ()  # of one kind of steps alone

    def __init__(
        self, bodies: Bodies, shapes: Shapes, surfaces: Surfaces, joints: Joints, springs: Springs, drives: Drives,
        tol: float, sweeps: int, interior: int, is_strict: bool, may_sleep: bool, theta: float,
        keeps_pairs: bool = False, selection: Selection = Selection.COMPLIANT_LIMIT,
    ) -> None:  # fmt: skip
        self.bodies, self.shapes, self.surfaces = bodies, shapes, surfaces
        self.joints, self.springs, self.drives = joints, springs, drives
        self.dim, n_s = len(bodies.gravity), len(shapes.body)
        has_restitution = bool((surfaces.e > 0).any() or (drives.e > 0).any())
        has_faces = may_hide(shapes)
        rare = contacts_of(shapes, self.dim) + (OF_PAIRS if keeps_pairs else ())
        rare += (leave_out_hidden,) if has_faces else ()
        rare += (leave_out_ignored,) if joints.apart else ()
        rare += (take_friction, update_friction) if surfaces.has_laws else ()
        may_divide = not surfaces.is_compliant and int(bodies.motion.moves.sum()) < HEAP
        rare += (OF_PARTS if may_divide else ()) + self.own_stages
        rare += (write_springs,) if springs.count else ()
        rare += (write_drives,) if drives.count else ()
        rare += (book_reactions,) if drives.count or joints.count else ()
        has_rolling = bool((surfaces.rolling > 0.0).any() or (surfaces.spinning > 0.0).any())
        rare += (write_rolling, limit_rolling) if has_rolling else ()
        rare += (rub_joints, find_doubtful_machine[self.dim]) if (drives.law == RUBS).any() else ()
        adheres = bool((surfaces.adhesion > 0.0).any())
        rare += (pull_together, book_pulls) if adheres else ()
        rare += (turn_to_grain,) if surfaces.has_grain else ()
        self.stages = stages_of(self.dim, has_restitution, joints.count > 0, rare)
        self.stages.load()
        self.ledger, self.progress, self.no_records = new(Ledger), new(Progress), no_records(self.dim)
        self.tol, self.sweeps, self.interior, self.selection = tol, sweeps, interior, selection
        bounded = (shapes.reach + shapes.radius)[np.isfinite(shapes.reach)]
        self.largest = float(bounded.max(initial=0.0))
        progress = self.progress
        progress.may_sleep, progress.has_adhesion = may_sleep and not adheres, adheres
        progress.has_restitution, progress.is_strict = has_restitution, is_strict
        progress.has_faces, progress.has_laws, progress.has_grain = has_faces, surfaces.has_laws, surfaces.has_grain
        progress.has_impact_law = has_restitution and surfaces.impact != ImpactLaw.NEWTON
        progress.may_divide, progress.theta = may_divide, theta
        progress.has_pins, progress.has_rolling = bool((drives.law == RUBS).any()), has_rolling
        bodies.lead = 2.0 - 2.0 * theta
        self.smallest = float(bounded.min(initial=np.inf))
        progress.tight = TIGHT * self.smallest if len(bounded) else 0.0
        self.gravity = float(np.linalg.norm(bodies.gravity))
        self._make_scratch(4 * n_s + 64)
        self.fill = 10 * min(len(bodies.mass), 200) + 100
        self.contacts: Contacts = new(Contacts, m=0, n_s=n_s, d=self.dim)
        self.asleep: Asleep = new(Asleep, m=0, n_b=len(bodies.mass), d=self.dim)
        self.parts: Parts = new(Parts, m=0, d=self.dim)
        self.reactions: Reactions = new(Reactions, n_n=len(joints.begin), d=self.dim)
        self.network: Network = new(Network, m=0, n_b=0, d=self.dim, n=3 * (self.dim - 1))
        self.desks = Desks(1)
        self.unsolved: Matrices | None = None  # what ends a run that is strict
        self.bearings: Bearings = new(Bearings)
        self.doubts: Doubts = new(Doubts, n_b=len(bodies.mass))
        self.doubts.near = largest_closed_gap(bodies.motion.x[:, : self.dim])
        self.paradoxes, self.verdicts = new(Paradoxes), list[Verdict]()
        self.examined = 0.0  # the beginning of the step that these are of [s]
        self.has_room = False
        self.pairs: Pairs = new(Pairs, n_p=2 * n_s + 16 if keeps_pairs else 0, d=self.dim)
        self.pairs.is_asked = keeps_pairs
        self.solver: Solver = new(Solver, fill=0, m=0, n_b=0, d=self.dim, n=3 * (self.dim - 1))
        self._make_room(2 * n_s + 16 + self.n_others)

    def take_steps(self, dt: float, most: int, t: float = 0.0, written: Written | None = None) -> int:
        """Take so many steps, from a time t [s] that events are told by, with the records that fall due, where they
        are to be ``written``; returns DONE, LOST or UNSOLVED, or RECORD where one is to be written by the caller."""
        progress, written = self.progress, self.no_records if written is None else written
        progress.whole, progress.threads = dt, self.desks.threads
        self.solver.approach = DRIVEN_IN[self.dim] * self.smallest / dt
        progress.margin = max(
            MARGIN * (self.gravity + float(self.bodies.strongest)) * dt * dt, WEIGHTLESS_MARGIN * self.largest
        )
        progress.widest = REACH_SHARE * self.largest
        first = int(progress.counts.steps)
        while True:
            end = int(take_recorded(progress.address, written.address, first + most, self.dim))
            if self.verdicts and progress.stage == PREDICT:
                tell(self, self.paradoxes, self.verdicts, self.examined)
                self.verdicts = []
            if end == DOUBTFUL:
                begun, since = written.begin_of_interval(first, t)
                self.examined = since + (int(progress.counts.steps) - begun) * dt
                self.verdicts = examine(self) + examine_machines(self)
                progress.has_verdicts = len(self.verdicts) > 0
            elif end == EXAMINED:
                continue
            elif end == NOT_MET:
                self.rescue()
                if progress.is_strict:
                    self.unsolved = unsolved_problem(self.network)
            elif end == TOGETHER:
                self._solve_together()
            elif end == BY_LAW:
                if not strike_by_law(self):
                    return TOO_MANY
            elif end == MORE_FACTORS:
                self.fill = int(ROOM * int(progress.wanted))
                self._make_solver()
            elif not self.make_more_room(end):
                return end

    def rescue(self) -> None:
        """Try dearer solvers for the islands that are not met."""
        rescue(self.network, self.solver, self.tol)

    @functools.cached_property
    def dense_core(self) -> Planar:
        """Which knows all solutions of few contacts."""
        return load_dense_core(FEW_TOUCHING, self.dim)

    def reach_of(self, bodies: np.ndarray) -> np.ndarray:
        """How far the shapes of bodies reach, of unbounded ones the largest [m]."""
        shapes = self.shapes
        reach = shapes.reach + shapes.radius
        of_body = [reach[shapes.body == b].max(initial=0.0) for b in bodies]
        return np.where(np.isfinite(of_body) & (np.array(of_body) > 0.0), of_body, max(self.largest, EPS))

    def _solve_together(self) -> None:
        """Let several threads solve the islands of the problem at hand, with as much room as they ask for."""
        self.desks.begin(self.network, self.solver, int(self.progress.factors))
        while wanted := self.desks.solve(self.network, self.solver):
            self.fill = wanted
            self._make_solver()
        self.progress.is_shared = 1

    def end_step(self) -> None:
        """End a step that Ctrl-C or a lost body cut short: finish it, or, where no part of it is done, go back to its
        beginning, without contacts."""
        progress = self.progress
        if progress.stage != PREDICT and (progress.stage != FIND or progress.parts > 1):
            self.take_steps(float(progress.whole), 1)
        if progress.stage == FIND:
            self.bodies.motion.x[:] = self.bodies.x_0
            self.network.n_c = self.parts.n_c = 0
            progress.stage = PREDICT

    def write_rows(self, dt: float) -> None:
        """The rows of the contacts that were found, as of a step of a length [s]."""
        at = self.progress.places
        write_contacts(at.bodies, at.shapes, at.surfaces, at.found, at.contacts, at.network, dt, self.dim)

    def solve_contacts(self) -> None:
        """Solve the contact problem of these rows, with as much room as it asks for."""
        at = self.progress.places
        if self.dim == 3:
            turn_inertia(at.bodies, at.network)
        prepare_network(at.network, self.dim)
        while wanted := int(solve_network(at.network, at.solver, at.desk, self.dim)):
            self.fill = int(ROOM * wanted)
            self._make_solver()

    def contact_rows(self) -> ContactRows:
        """The contacts of the last step, those that sleep among them, in the order of their keys."""
        rows = self._upright(rows_of_step(self.found, self.network, self.contacts.P))
        found = self.found.key[: len(rows.i)]
        if self.parts.n_c > 0:
            rows, found = with_parts(rows, found, self.parts, self._upright if self.surfaces.has_grain else None)
        if self.asleep.count == 0:
            return rows
        is_contact = self.asleep.key[: int(self.asleep.n_c)] < FIRST_ROLLING
        is_awake = (self.asleep.island[rows.i] == 0) & (self.asleep.island[rows.j] == 0)
        resting = self._upright(rows_at_rest(self.asleep))
        keys = np.concatenate((found[is_awake], self.asleep.key[: int(self.asleep.n_c)][is_contact]))
        order = np.argsort(keys)
        joined = (np.concatenate((column[is_awake], others)) for column, others in zip(rows, resting, strict=True))
        return ContactRows(*(column[order] for column in joined))

    def _upright(self, rows: ContactRows) -> ContactRows:
        """Contacts as users are shown them, with rows of length 1."""
        return rows._replace(**upright(rows.frame, rows.own, rows.mu)._asdict()) if self.surfaces.has_grain else rows

    @property
    def desk(self) -> Block:
        """Where islands are solved, but by other threads."""
        return self.solver.direct.desk

    @property
    def n_contacts(self) -> int:
        """Candidates of the last step."""
        asleep, found = self.asleep, self.found.key[: int(self.network.n_c)]
        before = asleep.key[: int(asleep.n_c - asleep.new_contacts)]
        return int((found < FIRST_ROLLING).sum() + (before < FIRST_ROLLING).sum())

    @property
    def n_others(self) -> int:
        """Blocks of rows of joints, springs and drives, that are no contacts."""
        return int(self.joints.count) + SIDES * int(self.springs.count) + int(self.drives.count)

    @property
    def n_islands(self) -> int:
        """Groups of bodies that touch, of the last step."""
        return int(self.network.islands.count + self.asleep.count - self.asleep.new_islands)

    @property
    def sizes(self) -> np.ndarray:
        """Of the blocks: contacts, factors and pairs that there is room for."""
        return np.array([len(self.found.gap), self.fill, len(self.pairs.i)])

    def restore(self, sizes: np.ndarray) -> None:
        """Blocks of such sizes, into which what was carried may be copied; ``go_on`` afterwards."""
        m, self.fill, n_p = map(int, sizes)
        if self.pairs.is_asked:
            self._make_room_for_pairs(n_p)
        self._make_room(m)

    def _make_room(self, m: int) -> None:
        """Blocks for m contacts; the impulses of the step before are carried over."""
        d, n, n_b, before = self.dim, 3 * (self.dim - 1), len(self.bodies.mass), self.contacts
        self.found = new(Found, m=m, d=d)
        self.contacts = new(Contacts, m=m, n_s=len(self.shapes.body), d=d)
        self.links = new(Links, m=m, n_b=n_b)
        parts, room = self.parts, ROOM_OF_PARTS * m if self.progress.may_divide else 0
        self.parts = new(Parts, m=max(room, len(parts.key)), d=d)
        keep_rows(parts, self.parts)
        self.moves = new(Moves, m=m, n_b=n_b, n=n)
        held = {"m": m, "n_b": n_b} if self.joints.count else {"m": 0, "n_b": 0}
        self.held = new(Held, d=d, n=n, **held)
        network, asleep = new(Network, m=m, n_b=n_b, d=d, n=n), new(Asleep, m=m, n_b=n_b, d=d)
        if not self.has_room:
            write_masses(self.bodies, network)
            self.has_room = True
        else:
            k = int(before.n_before)
            self.contacts.n_before, self.contacts.dt_before = k, before.dt_before
            for name in ("key_before", "P_before", "own_before", "normal_before", "point_before", "stuck_before"):
                getattr(self.contacts, name)[:k] = getattr(before, name)[:k]
            keep_rows(self.asleep, asleep)
            network.M[:], network.M_inv[:] = self.network.M, self.network.M_inv
            network.v[:], network.v_free[:] = self.network.v, self.network.v_free
        self.network, self.asleep = network, asleep
        self._make_solver()

    def _make_solver(self) -> None:
        """The memory of the solvers, for the contacts and the factors that there is room for."""
        sizes = {"m": len(self.found.gap), "n_b": len(self.bodies.mass), "d": self.dim, "n": 3 * (self.dim - 1)}
        before, self.solver = self.solver, new(Solver, fill=self.fill, **sizes)
        keep_rows(before, self.solver)
        self.solver.direct.desk.graph.end = self.fill
        self.solver.tol, self.solver.most_sweeps, self.solver.most_factors = self.tol, self.sweeps, MOST_FACTORS
        self.solver.over_relaxation, self.solver.most_inside = OVER_RELAXATION, self.interior
        self.go_on()


def write_masses(bodies: Bodies, network: Network) -> None:
    """M and M^-1 of all bodies; of what impulses do not move, M^-1 is 0. A spatial body's are those of its axes."""
    moving = bodies.motion.moves != 0
    masses = np.repeat(bodies.mass[moving, None], len(bodies.gravity), axis=1)
    diagonal = np.concatenate((masses, bodies.moments[moving]), axis=1)
    for x in range(diagonal.shape[1]):
        network.M[moving, x, x], network.M_inv[moving, x, x] = diagonal[:, x], 1.0 / diagonal[:, x]
