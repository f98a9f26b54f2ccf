"""Kicks: where rounds of sweeps and factors come to nothing, the impulses about the worst contacts are scattered.

    P_c <- exp(s z_c) P_c,  z_c normal,  of contacts within h bodies of one that errs by a share of the largest error

then sweeps, and factors from where these end. The best impulses are kept, and kicked again. A factor P_c > 0 leaves
every P_c in its cone and in its direction.

Packings have many solutions, and between them places where sweeps wander and Newton's method goes from modes to modes;
a kick leads to another one, and leaves what is solved elsewhere as it is. Each draws s, h, the share and the number of
sweeps anew, of numbers in a fixed order: the same problem has the same solution, to the last bit. Of 32 packings of
spheres with 100 to 500 contacts rounds alone solve 15, with kicks 26 are solved, most within 3 s.
Source: Wales and Doye, J. Phys. Chem. A 101 (1997) 5111-5116 (basin hopping).
"""

from __future__ import annotations

import numpy as np

from nonsmooth.contact.blocks.natural_map import natural_map_entry
from nonsmooth.contact.network.rounds import Rounds

MOST_KICKS = 60  # measured: packings of 300 contacts that are solved take up to 30, of 500 up to 40
KICK_SEED = 0  # chosen: any other one will do
KICK_SIZES = (0.03, 0.1, 0.3, 1.0)  # chosen: s: for each there are packings that it serves best, as for those below
KICK_REACHES = (1, 2, 3, 5)  # chosen: h: bodies
KICKED_SHARES = (0.1, 0.3)  # chosen: of the largest error of a contact
KICK_SWEEPS = (500, 1000, 3000)  # chosen: sweeps after a kick


def kick(rounds: Rounds, tol: float, until: float) -> None:
    """Kick, sweep and factorise until the error is within tol, the kicks are spent, or ``until`` [s]."""
    draw = np.random.default_rng(KICK_SEED)
    for _ in range(MOST_KICKS):
        if rounds.is_over(tol, until) or not rounds.may_factorise:
            return
        kicked = worst_contacts(rounds, draw.choice(KICKED_SHARES), draw.choice(KICK_REACHES))
        factors = np.exp(draw.choice(KICK_SIZES) * draw.normal(size=len(kicked)))
        rounds.network.P[kicked] *= factors[kicked, None]
        rounds.begin_at(int(draw.choice(KICK_SWEEPS)), tol, until)


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
