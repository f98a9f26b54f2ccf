"""What rigid contact leaves open at the beginning of a step of a scene: islands with no solution, or with several.

Asked of the islands that may be so (``doubtful.py``), few and seldom. What touches is a contact problem of its own,

    gamma = G P + c   of the step,        gamma' = G la + b   of the state before it,   b = J M^-1 h + J' v

with J' v by differences of the gaps along the velocities. In the plane the problem of the step is solved by the dense
core, which knows all solutions and takes one by the selection rule (contact/planar/ladder.py); a slide that ends in
sticking is checked for a force as a System's is (moreau_jean/slide_end.py). In space the round cone has no such core:
contacts that slide, with their directions held, are a problem of normal forces,

    gamma_N' = A la_N + b_N,    A = G_NN - G_NT diag(mu t)

whose solutions are enumerated; the one of the best rank is where the solver of the step begins. A contact that is
found where its bodies are before the step (bodies.py) has c without the dt J' v of the step, which decides between
lifting off and none: it is added here.

Source: Lötstedt, *ZAMM* 61 (1981) 605; Génot, Brogliato, *Eur. J. Mech. A/Solids* 18 (1999) 653.
Equations: docs/theory/scenes.md, (9).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from nonsmooth.contact.network.eliminated import Eliminated, without_joints
from nonsmooth.contact.network.joint import JOINED
from nonsmooth.contact.network.problem import Network
from nonsmooth.contact.network.rescue import dense_problem
from nonsmooth.contact.planar.enumerate import enumerate_modes
from nonsmooth.contact.planar.ladder import Route, solve_planar
from nonsmooth.contact.planar.lemke import pivot
from nonsmooth.contact.planar.problem import Planar, problem_of
from nonsmooth.contact.planar.redundant import enumerate_redundant
from nonsmooth.contact.planar.selection import FREE, SLIDE_PLUS, STICK, Selection, rank
from nonsmooth.contact.planar.single import count, solve_alone
from nonsmooth.integrators.assembly import doubtful
from nonsmooth.integrators.assembly.accelerations import SceneInStep, StateProblem
from nonsmooth.integrators.assembly.contacts import ON_THE_CONE
from nonsmooth.integrators.moreau_jean.slide_end import has_no_sliding_force
from nonsmooth.integrators.records import INCONSISTENT, INDETERMINATE
from nonsmooth.jit import interpreted, load_all
from nonsmooth.jit.blocks import new
from nonsmooth.mechanics.contact_problem import Problem
from nonsmooth.mechanics.laws import LAW_C
from nonsmooth.mechanics.situation import STATE_ACCURACY
from nonsmooth.mechanics.system import UNILATERAL, ContactMode

count_modes, solve_one, rank_of_mode = interpreted(count), interpreted(solve_alone), interpreted(rank)
no_force = interpreted(has_no_sliding_force)
is_closed, touches = interpreted(doubtful.is_closed), interpreted(doubtful.touches)


class Before(NamedTuple):
    """What contacts did before the step."""

    mode: np.ndarray  # (m,) ContactMode
    slip: np.ndarray  # (m,) signs of sliding along the tangents of the rows; 0 in space
    gamma: np.ndarray  # (m, d) velocities [m/s]
    t: np.ndarray  # (m, d) direction of sliding, in the axes of the world


class Verdict(NamedTuple):
    """What was found of an island."""

    contacts: np.ndarray  # rows of the network
    before: Before
    kind: int  # INCONSISTENT or INDETERMINATE
    of: np.ndarray  # (m,) whether a contact is one of those that it is told of
    n_solutions: int
    found: int  # candidates of a contact alone, as bits


def examine(assembly: SceneInStep) -> list[Verdict]:
    """What is found of the doubtful islands of the step at hand; where the solver is to begin is left in network.P."""
    doubts, network, is_planar = assembly.doubts, assembly.network, assembly.dim == 2
    islands, gap, verdicts = network.islands, assembly.found.gap, []
    for k in doubts.island[: int(doubts.count)]:
        listed = islands.contacts[islands.contact_start[k] : islands.contact_start[k + 1]]
        joints = listed[network.mu[listed] == JOINED]
        contacts = listed[(network.mu[listed] != JOINED) & which(touches, assembly, listed, 3 * (assembly.dim - 1))]
        kept = network.b[contacts, 0].copy(), gap[contacts].copy()
        ways = network.J_j[contacts, 1, :2] if is_planar else before_step(assembly, contacts).t
        state = StateProblem(assembly, contacts, joints, ways, 0.0)
        touching = corrected(assembly, contacts, state)
        is_left = len(touching) < len(contacts)
        verdict = None
        if is_planar and len(touching) > 0:
            verdict = examine_planar(assembly, touching, joints)
        elif not is_planar and not is_left:
            verdict = examine_spatial(assembly, contacts, joints, state)
        if verdict is not None:
            verdicts.append(verdict)
        elif not is_left:  # one solution, of which the solver is to know what it would have without a doubt
            network.b[contacts, 0], gap[contacts] = kept
    return verdicts


def which(claim: Callable[..., bool], assembly: SceneInStep, contacts: np.ndarray, *size: int) -> np.ndarray:
    """Of which contacts a claim of ``doubtful`` is true: what is listed there is what is examined here."""
    near = float(assembly.doubts.near) if assembly.progress.counts.steps == 0 else 0.0
    claims = (claim(assembly.found, assembly.network, c, near, *size) for c in contacts)
    return np.fromiter(claims, bool, len(contacts))


def before_step(assembly: SceneInStep, contacts: np.ndarray) -> Before:
    """Modes by the impulses of the step before; of a run that begins, by the velocities."""
    network, v, d = assembly.network, assembly.bodies.motion.v, assembly.dim
    i, j, P, mu = network.i[contacts], network.j[contacts], network.P[contacts], network.mu[contacts]
    gamma = np.einsum("cax,cx->ca", network.J_i[contacts], v[i]) + np.einsum("cax,cx->ca", network.J_j[contacts], v[j])
    gamma[:, 1:] += network.b[contacts, 1:]
    speed, friction = np.linalg.norm(gamma[:, 1:], axis=1), np.linalg.norm(P[:, 1:], axis=1)
    still = still_speed(assembly, contacts)
    slides, is_pressed = speed > still, P[:, 0] > 0.0
    if assembly.progress.counts.steps == 0:
        is_pressed = gamma[:, 0] >= -still
    else:
        slides &= friction >= mu * P[:, 0] * ON_THE_CONE
    mode = np.where(is_pressed, np.where(slides, ContactMode.SLIDE, ContactMode.STICK), ContactMode.OPEN)
    ways = gamma[:, 1:] / np.where(speed > 0.0, speed, 1.0)[:, None]
    has_slip = (mode == ContactMode.SLIDE) & (d == 2)
    slip = np.where(has_slip, np.sign(gamma[:, 1]), 0).astype(int)
    return Before(mode, slip, gamma, np.einsum("ca,cak->ck", ways, network.J_j[contacts][:, 1:, :d]))


def still_speed(assembly: SceneInStep, contacts: np.ndarray) -> float:
    """The velocity below which contacts count as still: of those of their bodies, and of what pulls at them [m/s]."""
    network, v = assembly.network, assembly.bodies.motion.v
    bodies = np.unique((network.i[contacts], network.j[contacts]))
    surface = float(np.abs(network.b[contacts, 1:]).max())
    return STATE_ACCURACY * max(float(np.abs(v[bodies]).max()), float(np.abs(network.v_free[bodies]).max()), surface)


def corrected(assembly: SceneInStep, contacts: np.ndarray, state: StateProblem) -> np.ndarray:
    """Let the normal velocities of the step's problem be those at its end, where its rows are those of its beginning;
    what counts as closed at the start of a run is. The gap is that of a straight way to where the curved one ends.

    Returns the contacts that touch then: what would have closed without the curve of its way may not.
    """
    bodies, network, dt = assembly.bodies, assembly.network, float(assembly.progress.dt)
    closed = which(is_closed, assembly, contacts)
    network.b[contacts[closed], 0] = 0.0
    for c, a in zip(contacts, state.curvature, strict=True):
        if not any(bodies.keeps[b] == 1 and bodies.motion.moves[b] for b in (network.i[c], network.j[c])):
            network.b[c, 0] += dt * a
            assembly.found.gap[c] += 0.5 * dt * dt * max(a, 0.0)
    return contacts[closed | which(touches, assembly, contacts, 3 * (assembly.dim - 1))]


def examine_planar(assembly: SceneInStep, contacts: np.ndarray, joints: np.ndarray) -> Verdict | None:
    """The solutions of the step's problem; the one that is taken goes to network.P."""
    network = assembly.network
    before, m = before_step(assembly, contacts), len(contacts)
    has_friction = network.mu[contacts] > 0.0
    held = held_by_joints(network, contacts, joints)
    problem, rows = planar_problem(assembly, contacts, held, before, has_friction)
    numbers, bits, members = solve_by_dense_core(assembly, problem)
    if numbers.min() == 0:
        return None
    several = (numbers >= 3) | ((numbers == 2) & (members > 1))
    stops = (problem.candidate == STICK) & (before.mode == ContactMode.SLIDE) & has_friction
    lost = np.array([bool(stops[k]) and has_lost_force(assembly, contacts, joints, k, before) for k in range(m)])
    if not lost.any() and not several.any():
        return None
    P = np.zeros(2 * m)
    P[rows] = problem.P
    network.P[contacts], network.P[joints] = P.reshape(m, 2), held.joints(P).reshape(-1, 2)
    if lost.any():
        return Verdict(contacts, before, INCONSISTENT, lost, 0, 0)
    return Verdict(contacts, before, INDETERMINATE, several, int(numbers.max()), bits)


def held_by_joints(network: Network, contacts: np.ndarray, joints: np.ndarray) -> Eliminated:
    """The problem of the step of some contacts, whose bodies joints hold."""
    is_joint = np.repeat([False, True], (network.b.shape[1] * len(contacts), network.b.shape[1] * len(joints)))
    return without_joints(*dense_problem(network, np.concatenate((contacts, joints))), is_joint)


def planar_problem(
    assembly: SceneInStep, contacts: np.ndarray, held: Eliminated, before: Before, has_friction: np.ndarray
) -> tuple[Problem, np.ndarray]:
    """The problem of the dense core, and which of the rows N, T it has: none for friction where mu = 0."""
    G, c = held.G, held.c
    mu = assembly.network.mu[contacts]
    rows = np.stack((np.ones(len(mu), bool), has_friction), axis=1).ravel()
    kinds = np.stack((np.full(len(mu), UNILATERAL), has_friction.astype(int)), axis=1)
    problem = problem_of(kinds, G[np.ix_(rows, rows)], c[rows], mu, mu)
    problem.laws[:, LAW_C], problem.selection = mu, int(assembly.selection)
    problem.mode[:], problem.slip[:] = before.mode, before.slip
    problem.previous_P[:] = assembly.network.P[contacts]
    return problem, rows


def solve_by_dense_core(assembly: SceneInStep, problem: Problem) -> tuple[np.ndarray, int, np.ndarray]:
    """Solve a problem; of each contact the number of solutions of its island, 0 where none was found, and the contacts
    of that; of one contact alone also its candidates as bits."""
    m = int(problem.n)
    if m == 1:
        bits, _ = solve_one(0, problem)
        return np.array([count_modes(bits)]), bits, np.ones(1, int)
    planar = assembly.dense_core
    planar.memory.told[:] = planar.memory.members[:] = 0
    route, _, _, _ = solve_planar(problem.address, planar.address)
    numbers = planar.found[:m].copy() if route > Route.NO_SOLUTION else np.zeros(m, int)
    return numbers, 0, planar.members[:m].copy()


def has_lost_force(
    assembly: SceneInStep, contacts: np.ndarray, joints: np.ndarray, k: int, before: Before
) -> bool:  # fmt: skip
    """Whether the slide of contact k ran out of forces, before the step or, of the free motion, at its end."""
    mu, s = float(assembly.network.mu[contacts[k]]), int(before.slip[k])
    tangents = assembly.network.J_j[contacts, 1, :2]
    states = (StateProblem(assembly, contacts, joints, tangents, ahead) for ahead in (0.0, float(assembly.progress.dt)))
    return any(no_force(False, s, mu, at.G[k, 0, k, 0], at.G[k, 0, k, 1], at.b[k]) for at in states)


def examine_spatial(
    assembly: SceneInStep, contacts: np.ndarray, joints: np.ndarray, state: StateProblem
) -> Verdict | None:  # fmt: skip
    """The forces of contacts that all slide; where several fit, those that are taken go to network.P, of a step."""
    network, before, dt = assembly.network, before_step(assembly, contacts), float(assembly.progress.dt)
    if not (before.mode == ContactMode.SLIDE).all():
        return None
    mu, m = network.mu[contacts], len(contacts)
    A = state.G[:, 0, :, 0] - state.G[:, 0, :, 1] * mu
    problem = problem_of(np.tile((UNILATERAL, 0), (m, 1)), A, state.b, mu, mu)
    tree = assembly.dense_core.tree
    tree.group[:] = 0
    n_solutions, is_complete = enumerate_modes(problem.address, tree.address)
    if n_solutions == 1 or (n_solutions == 0 and not is_complete):
        return None
    is_saddle = np.diag(A) <= 0.0
    of = is_saddle if is_saddle.any() else np.ones(m, bool)
    if n_solutions == 0:
        return Verdict(contacts, before, INCONSISTENT, of, 0, 0)
    ranks = [sum(rank_in_slide(mode, saddle, assembly.selection) for mode, saddle in zip(modes, is_saddle, strict=True))
             for modes in tree.modes[: min(n_solutions, len(tree.modes)), :m]]  # fmt: skip
    la = tree.solutions[int(np.argmax(ranks)), :m]
    ways = np.einsum("ck,cak->ca", before.t, network.J_j[contacts][:, 1:, :3])
    network.P[contacts, 0] = dt * la
    network.P[contacts, 1:] = -(mu * dt * la)[:, None] * ways
    network.P[joints] = held_by_joints(network, contacts, joints).joints(network.P[contacts].ravel()).reshape(-1, 3)
    bits = 1 << FREE | 1 << SLIDE_PLUS if m == 1 else 0
    return Verdict(contacts, before, INDETERMINATE, of, int(n_solutions), bits)


def rank_in_slide(mode: int, is_saddle: bool, selection: Selection) -> int:
    """What a contact that slid adds to the rank of a solution in which it opens, or goes on."""
    return int(rank_of_mode(FREE if mode == FREE else SLIDE_PLUS, is_saddle, False, False, selection))


def load_dense_core(n: int, dim: int) -> Planar:
    """The memory of the dense core for n contacts; its code is loaded when a scene first needs it, in space that of the
    enumeration alone."""
    load_all([enumerate_modes] if dim == 3 else [enumerate_modes, solve_planar, pivot, enumerate_redundant])
    planar = new(Planar, n=max(2, n), d=1)
    planar.can_decide_redundant = 1 if dim == 2 else 0
    return planar
