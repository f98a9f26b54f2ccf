"""Bodies that overlap at the start of a run are moved apart, by the smallest displacement in the mass metric.

    min |x - x_0|_M   subject to   g_N(x) >= 0 of all pairs

Linearised where the bodies are, x_k, with J the rows of the contacts found there and w = x_{k+1} - x_k, this is the
contact problem of a step without friction and of unit length, whose free motion leads back to the start:

    0 <= g_N(x_k) + J_N w  _|_  P >= 0,    w = (x_0 - x_k) + M^-1 J_N^T P

so the solvers of a step solve it. It is repeated, contacts found anew, until w is small; then, with w = M^-1 J_N^T P
alone, until no gap is left. Gaps between discs and spheres are convex functions of the places of their centres: one
iteration parts what it was told of. A turn is that of the Cayley map.

Source: sequential quadratic programming with the metric in the place of the Hessian, Nocedal and Wright, *Numerical
Optimization* (2006), section 18.1.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.assembly.drive_rows import no_drives
from nonsmooth.integrators.assembly.spring_rows import no_springs
from nonsmooth.integrators.assembly.step import Assembly
from nonsmooth.integrators.assembly.world import World, spin_between
from nonsmooth.scenes.places import times

LEFT_GAP = 1e-12  # chosen: of the smaller shape: a penetration that is left
PART_TOL = 1e-10  # chosen: residual of each problem: what it leaves, the next one takes
PART_SWEEPS = 2000  # chosen: of an island: a start is made once
PART_INTERIOR = 2000  # chosen: bodies of an island that interior points solve, for the same reason
SETTLED = 1e-9  # chosen: of the displacement so far: a smaller change of it ends the way to the nearest start
TOWARDS_START, MOST = 60, 90  # chosen: iterations towards the nearest start, and in all
BOTH = 2.0  # defined: bodies that approach, each by as much
NEARBY = 1e-3  # chosen: of the largest bounded shape: pairs that are listed whatever moves
FARTHEST = 2.0  # chosen: of the largest bounded shape: some thirty neighbours of a body in a heap


def part_bodies(world: World) -> None:
    """Move the bodies of a world that overlap apart; without an overlap no bit changes.

    Raises
    ------
    InvalidInput
        Where no way is found, with the pair that is deepest in one another.
    """
    assembly = Assembly(
        world.bodies, world.shapes, world.surfaces, world.joints, no_springs(world.dim), no_drives(world.dim),
        PART_TOL, PART_SWEEPS,
        PART_INTERIOR, is_strict=False, may_sleep=False, theta=1.0,
    )  # fmt: skip
    world.require_found(assembly.find_contacts())
    x = world.bodies.motion.x
    start, is_nearest = x.copy(), False
    for iteration in range(MOST):
        back = way_between(x, start)
        margin = write_problem(assembly, 0.0 if is_nearest else float(np.abs(back).max()))
        if are_apart(assembly) and (iteration == 0 or is_nearest):
            world.bodies.x_0[:] = world.bodies.v_free[:] = 0.0  # as they are before a first step
            return
        is_nearest = is_nearest or iteration >= TOWARDS_START
        share = 0.0 if is_nearest else margin / max(margin, BOTH * np.abs(back).max())
        way = least_way(assembly, share * back)
        if not np.isfinite(way).all():
            break
        move(x, way)
        is_nearest = is_nearest or np.abs(way).max() <= SETTLED * np.abs(x - start).max()
    x[:] = start
    first, second, depth = world.deepest_pair(assembly.find_contacts(), assembly.found)
    raise InvalidInput(
        f"{first} and {second} overlap at the start by {depth:.3g} m, and project=True finds no places near by where "
        "nothing overlaps; move them apart by hand"
    )


def write_problem(assembly: Assembly, way: float) -> float:
    """The contacts at the present places, with their gaps as velocities that have a unit of time to close them.

    Pairs are listed that may meet where bodies move as far as they penetrate, or as a way; returns the margin of that.
    """
    n = max(0, assembly.find_contacts())
    depth = -assembly.found.gap[:n].min(initial=0.0)
    margin = float(min(BOTH * max(depth, way) + NEARBY * assembly.largest, FARTHEST * assembly.largest))
    n = max(0, assembly.find_contacts(margin))
    assembly.bodies.x_0[:] = assembly.bodies.motion.x
    network = assembly.network
    network.n_c = n
    assembly.write_rows(1.0)
    network.mu[:n] = 0.0
    network.b[:n] = 0.0
    network.b[:n, 0] = assembly.found.gap[:n]
    return margin


def are_apart(assembly: Assembly) -> bool:
    """Whether all gaps are closed, to rounding of the places or to ``LEFT_GAP``."""
    n, found, shapes = assembly.network.n_c, assembly.found, assembly.shapes
    reach = shapes.reach + shapes.radius
    size = np.minimum(reach[found.shape_i[:n]], reach[found.shape_j[:n]])
    return bool((found.gap[:n] >= -LEFT_GAP * size).all())


def least_way(assembly: Assembly, back: np.ndarray) -> np.ndarray:
    """w of all bodies (n_b, n), with the way back to the start that it begins from."""
    assembly.network.v_free[:] = back
    assembly.solve_contacts()
    assembly.rescue()
    return assembly.network.v


def way_between(here: np.ndarray, there: np.ndarray) -> np.ndarray:
    """The displacements that move bodies (n_b, n_x) from one place to the other."""
    d = 2 if here.shape[1] == 3 else 3
    return np.hstack((there[:, :d] - here[:, :d], spin_between(here[:, d:], there[:, d:], 1.0)))


def move(x: np.ndarray, way: np.ndarray) -> None:
    """Move and turn bodies (n_b, n_x); those without a way keep their bits."""
    if x.shape[1] == 3:
        x += way
        return
    x[:, :3] += way[:, :3]
    turned = np.flatnonzero(way[:, 3:].any(axis=1))
    turn = np.hstack((np.ones((len(turned), 1)), 0.5 * way[turned, 3:]))
    q = times(turn, x[turned, 3:])
    x[turned, 3:] = q / np.linalg.norm(q, axis=1, keepdims=True)
