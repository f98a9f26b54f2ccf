"""Places of joined bodies: what their joints have drifted apart, and what penetrates, is taken back by a motion w.

    dt J w = -g  of joints,   0 <= gap-law of contacts:  dt J_N w + share g_N >= 0 _|_ P >= 0  of closed ones,
    dt J_N w + g_N >= 0 _|_ P >= 0  of open ones,   w = M^-1 J^T P, the least motion in the mass metric

That is the contact problem of a step without friction, whose free motion is none. It is solved as that of the
velocities is, by the same ladder from the same factors: a few sweeps of Gauss-Seidel, which do for contacts, leave a
chain of ten links with an end a thousand times heavier metres apart after two seconds. The problem of the velocities is
put aside meanwhile.
"""

from __future__ import annotations

from typing import Annotated as Array

from nonsmooth.contact.network.joint import JOINT_LIMIT, is_joint
from nonsmooth.contact.network.patience import Patience, copy_patience
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.network.solve import Solver, solve_network
from nonsmooth.integrators.assembly.contacts import Contacts
from nonsmooth.integrators.assembly.joined_trees import Tree, solve_trees
from nonsmooth.integrators.assembly.progress import Progress
from nonsmooth.integrators.assembly.project import SHARE, Moves, has_joints
from nonsmooth.jit import kernel
from nonsmooth.jit.blocks import Block, Floats, Ints, address, view
from nonsmooth.scenes.detection import Found


class HeldIslands(Block):
    """What was found of islands."""

    F: Array[Floats, "n_b"]
    P: Array[Floats, "n_b"]
    residual: Array[Floats, "n_b"]
    rung: Array[Ints, "n_b"]
    sweeps: Array[Ints, "n_b"]
    factors: Array[Ints, "n_b"]
    is_met: Array[Ints, "n_b"]


class Held(Block):
    """The problem of the velocities, while that of the places is solved."""

    is_begun: int  # whether it is put aside: the problem of the places goes on where there was no room for its factors
    passes: int  # that were made after the bodies have moved (hold_places.py)
    is_parted: Array[Ints, "n_b"]  # the islands that they are for
    islands: HeldIslands
    tree: Tree  # of joints, of an island after the other
    patience: Patience  # with what solvers led to: not with what became of the places
    contradicted: int
    P: Array[Floats, "m", "d"]
    b: Array[Floats, "m", "d"]
    mu: Array[Floats, "m"]
    v: Array[Floats, "n_b", "n"]
    v_free: Array[Floats, "n_b", "n"]


@kernel("int64(int64, int64)")
def draw_together(progress_at, d):
    """The push of all islands with joints, to ``moves``; d is 2 or 3. Returns 0, or how many blocks of factors are
    wanted: called again with more room it goes on."""
    progress = view(progress_at, Progress)
    places = progress.places
    network, solver, held = view(places.network, Network), view(places.solver, Solver), view(places.held, Held)
    if held.is_begun == 0:
        found, contacts, moves = view(places.found, Found), view(places.contacts, Contacts), view(places.moves, Moves)
        if not find_parted(found, contacts, network, moves, progress.tight):
            take_push(network, moves)  # none
            return 0
        begin_places(network, solver, held)
        write_drifts(found, contacts, network, moves, progress.dt)
    solve_trees(places.network, address(held.tree), solver.tol, 0, d)
    wanted = solve_network(places.network, places.solver, places.desk, d)
    if wanted > 0:
        return wanted
    take_push(network, view(places.moves, Moves))
    end_places(network, solver, held)
    return 0


@kernel
def begin_places(network, solver, held):
    """Put the problem of the velocities aside, with what solvers led to."""
    copy_problem(network, held, network.n_c, network.islands.count)
    copy_patience(solver.patience, held.patience)
    held.contradicted, held.is_begun = solver.contradicted, 1


@kernel
def end_places(network, solver, held):
    """Take the problem of the velocities up again."""
    copy_problem(held, network, network.n_c, network.islands.count)
    copy_patience(held.patience, solver.patience)
    solver.contradicted, held.is_begun = held.contradicted, 0


@kernel
def find_parted(found, contacts, network, moves, tight):
    """Mark the islands with joints whose points, or bodies that are in one another, are off by more than roundings."""
    islands, is_any = network.islands, False
    for k in range(islands.count):
        moves.deep[k] = 0
        if not has_joints(network, k):
            continue
        for at in range(islands.contact_start[k], islands.contact_start[k + 1]):
            c = islands.contacts[at]
            if found.gap[c] < -tight or (is_joint(network, c) and is_drifted(contacts, c, tight)):
                moves.deep[k] = 1
                is_any = True
    return is_any


@kernel
def is_drifted(contacts, c, tight):
    """Whether the points of joint c are farther apart than roundings are."""
    square = 0.0
    for axis in range(contacts.drift.shape[1]):
        square += contacts.drift[c, axis] * contacts.drift[c, axis]
    return square > tight * tight


@kernel
def copy_problem(source, to, n_c, count):
    """Copy n_c contacts, all bodies and what was found of so many islands."""
    d, n = to.b.shape[1], to.v.shape[1]
    for c in range(n_c):
        to.mu[c] = source.mu[c]
        for row in range(d):
            to.P[c, row], to.b[c, row] = source.P[c, row], source.b[c, row]
    for b in range(to.v.shape[0]):
        for x in range(n):
            to.v[b, x], to.v_free[b, x] = source.v[b, x], source.v_free[b, x]
    found, into = source.islands, to.islands
    for k in range(count):
        into.F[k], into.P[k], into.residual[k] = found.F[k], found.P[k], found.residual[k]
        into.rung[k], into.sweeps[k], into.factors[k] = found.rung[k], found.sweeps[k], found.factors[k]
        into.is_met[k] = found.is_met[k]


@kernel
def write_drifts(found, contacts, network, moves, dt):
    """The problem of the places; islands that are not parted are left out as if they were solved."""
    islands = network.islands
    for c in range(network.n_c):
        gap = found.gap[c]
        for row in range(network.b.shape[1]):
            network.P[c, row] = 0.0
            network.b[c, row] = contacts.drift[c, row] / dt if is_joint(network, c) else 0.0
        if not is_joint(network, c):
            share = SHARE if gap < 0.0 and network.sprung[c] != JOINT_LIMIT else 1.0
            network.mu[c], network.b[c, 0] = 0.0, share * gap / dt
    for b in range(network.v.shape[0]):
        for x in range(network.v.shape[1]):
            network.v[b, x] = network.v_free[b, x] = 0.0
    for k in range(islands.count):
        islands.is_met[k], islands.sweeps[k], islands.factors[k] = 1 - moves.deep[k], 0, 0
        islands.owner[k] = 0  # whichever thread had it: this problem is solved here


@kernel
def take_push(network, moves):
    """w of the bodies of all islands with joints."""
    islands = network.islands
    for k in range(islands.count):
        if has_joints(network, k):
            for at in range(islands.body_start[k], islands.body_start[k + 1]):
                b = islands.bodies[at]
                for x in range(network.v.shape[1]):
                    moves.push[b, x] = network.v[b, x] if moves.deep[k] == 1 else 0.0
