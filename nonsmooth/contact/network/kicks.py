"""Kicks, walks and paths: what follows where rounds of sweeps and factors come to nothing.

    kick: P_c <- exp(s z_c) P_c,  z_c normal,  of contacts within h bodies of one that errs by a share of the largest
          error, in the best impulses; then sweeps, and factors from where these end; the best are kept
    walk: of spheres, instead: sweeps that go on from where the walk before ended (``walk``), and factors from
          the best on the way; where it came as near as the one before it goes in a circle, and is kicked itself
    path: of spheres, once, after some walks: ``path``, and walks again from the best impulses on it

A factor exp(s z_c) > 0 leaves every P_c in its cone and in its direction.

Packings have many solutions, and between them places where sweeps wander and Newton's method goes from modes to modes.
Each kick draws s, h and the share anew, of numbers in a fixed order: the same problem has the same solution, to the
last bit. Of 20 packings of spheres with 300 and 500 contacts walks solve 19, kicks 14; towers over six decades of mass
take some times as long with walks. Paths solve what circles leave of them, and take some times as long where walks come
through.
Source: Wales and Doye, J. Phys. Chem. A 101 (1997) 5111-5116 (basin hopping).
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.contact.blocks.natural_map import natural_map_entry
from nonsmooth.contact.network.path import follow_paths
from nonsmooth.contact.network.rounds import LEAST_SWEEPS, WORK_OF_ROUND, Rounds

MOST_KICKS = 60  # measured: packings of 300 contacts that are solved take up to 30, of 500 up to 40
WALK_SWEEPS = 20_000  # measured: walks alone solve 8 of 8 packings of 500 contacts, with 5000 sweeps 7
WALKS_BEFORE_PATHS = 8  # chosen: of 300 contacts they take some seconds, as a path does
CIRCLE = 0.03  # measured: relative change of the nearest approach in two walks of the same circle
KICK_SEED = 0  # chosen: any other one will do
KICK_SIZES = (0.03, 0.1, 0.3, 1.0)  # chosen: s: for each there are packings that it serves best, as for those below
KICK_REACHES = (1, 2, 3, 5)  # chosen: h: bodies
KICKED_SHARES = (0.1, 0.3)  # chosen: of the largest error of a contact
KICK_SWEEPS = (500, 1000, 3000)  # chosen: sweeps after a kick


def kick_and_walk(rounds: Rounds, tol: float, until: float) -> None:
    """Kick and walk until the error is within tol, the kicks are spent, or ``until`` [s]."""
    draw, walker, before = np.random.default_rng(KICK_SEED), rounds.best, math.inf
    may_walk, P = rounds.are_spheres(), rounds.network.P
    most = min(WALK_SWEEPS, max(LEAST_SWEEPS, WORK_OF_ROUND // max(rounds.network.n_c, 1)))
    for count in range(MOST_KICKS):
        if may_walk and count == WALKS_BEFORE_PATHS:
            follow_paths(rounds, tol, until)
            walker, before = rounds.best.copy(), math.inf
        if rounds.is_over(tol, until) or not rounds.may_factorise:
            break
        if may_walk:
            P[:] = walker
            nearest = rounds.walk(most, tol, until)
            if abs(nearest - before) <= CIRCLE * nearest:
                kick(rounds, draw)
            walker, before = P.copy(), nearest
        else:
            kick(rounds, draw)
            rounds.begin_at(int(draw.choice(KICK_SWEEPS)), tol, until)
    P[:] = rounds.best


def kick(rounds: Rounds, draw: np.random.Generator) -> None:
    """Scatter the impulses about the worst contacts of those at hand."""
    kicked = worst_contacts(rounds, draw.choice(KICKED_SHARES), draw.choice(KICK_REACHES))
    factors = np.exp(draw.choice(KICK_SIZES) * draw.normal(size=len(kicked)))
    rounds.network.P[kicked] *= factors[kicked, None]


def worst_contacts(rounds: Rounds, share: float, reach: int) -> np.ndarray:
    """Which contacts (n_c,) lie within so many bodies of one whose error is above a share of the largest."""
    network = rounds.network
    rounds.measured_error(rounds.rho)
    errors = contact_errors(rounds)
    found = errors > share * errors.max(initial=0.0)
    surroundings = len(network.v) - 1
    for _ in range(reach):
        bodies = np.zeros(len(network.v), dtype=bool)
        bodies[network.i[found]] = bodies[network.j[found]] = True
        bodies[surroundings] = False
        found = bodies[network.i] | bodies[network.j]
    return found


def contact_errors(rounds: Rounds) -> np.ndarray:
    """The error of each contact (n_c,), at the impulses that were measured last."""
    network, one = rounds.network, np.ones(1)
    return np.array([
        natural_map_entry(network.mu[c : c + 1], rounds.rho[c : c + 1], one, network.P[c], network.gamma[c], rounds.d)
        for c in range(len(network.mu))
    ])  # fmt: skip
