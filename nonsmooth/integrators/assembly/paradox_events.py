"""The paradoxes of a run of a scene, as it keeps them: rows of numbers, one a pair of bodies and episode.

A slide without a force is one each time. Several solutions are one as long as the pair has them in every step.
"""

from __future__ import annotations

from typing import Annotated as Array

import numpy as np

from nonsmooth.contact.planar.selection import SLIDE_PLUS
from nonsmooth.integrators.assembly.accelerations import SceneInStep
from nonsmooth.integrators.assembly.contacts import ON_THE_CONE
from nonsmooth.integrators.assembly.paradox import Verdict, still_speed
from nonsmooth.integrators.records import (
    EVENT_CONTACT,
    EVENT_FOUND,
    EVENT_GAMMA_F,
    EVENT_GAMMA_N,
    EVENT_I,
    EVENT_J,
    EVENT_KIND,
    EVENT_MODE_0,
    EVENT_MODE_1,
    EVENT_P_F,
    EVENT_P_N,
    EVENT_SLIP_0,
    EVENT_SLIP_1,
    EVENT_SOLUTIONS,
    EVENT_T,
    INCONSISTENT,
    INDETERMINATE,
    PARADOX_WIDTH,
)
from nonsmooth.jit.blocks import Block, Floats, Ints
from nonsmooth.mechanics.system import ContactMode
from nonsmooth.scenes.detection import FEATURE_BITS

MOST_PARADOXES = 200  # chosen: that are kept of a run; all are counted
MOST_TOLD = 64  # chosen: pairs whose episodes are followed at once


class Paradoxes(Block, most=MOST_PARADOXES, told=MOST_TOLD, width=PARADOX_WIDTH):
    """Those of a run: the first ones as rows, with the columns of records.py and the two bodies."""

    inconsistent: int  # slides without a force
    several: int  # steps with several solutions
    count: int
    rows: Array[Floats, "most", "width"]
    pair: Array[Ints, "told"]  # of shapes, of an episode of several solutions
    step: Array[Ints, "told"]  # and its last step


def tell(assembly: SceneInStep, paradoxes: Paradoxes, verdicts: list[Verdict], t: float) -> None:
    """Note what was found, once the step is taken: with the impulses and the modes that it ended with."""
    step = int(assembly.progress.counts.steps)
    paradoxes.several += any(verdict.kind == INDETERMINATE for verdict in verdicts)
    for verdict in verdicts:
        pairs = assembly.found.key[verdict.contacts] >> FEATURE_BITS
        for pair in np.unique(pairs[verdict.of]):
            is_of_pair = (pairs == pair) & verdict.of
            if verdict.kind == INCONSISTENT:
                paradoxes.inconsistent += 1
            elif is_episode(paradoxes, int(pair), step):
                continue
            if paradoxes.count < len(paradoxes.rows):
                write_event(assembly, verdict, np.flatnonzero(is_of_pair), t, paradoxes.rows[int(paradoxes.count)])
            paradoxes.count += 1


def is_episode(paradoxes: Paradoxes, pair: int, step: int) -> bool:
    """Whether a pair had several solutions in the step before too; it is noted that it has them now."""
    known = np.flatnonzero(paradoxes.pair == pair)
    at = int(known[0]) if len(known) else int(np.argmin(paradoxes.step))
    goes_on = len(known) > 0 and int(paradoxes.step[at]) == step - 1
    paradoxes.pair[at], paradoxes.step[at] = pair, step
    return goes_on


def write_event(assembly: SceneInStep, verdict: Verdict, members: np.ndarray, t: float, row: np.ndarray) -> None:
    """Write an event of some contacts of a pair: their impulses together, the rest of the first.

    The tangent of a scene is that of its system (scenes/as_system.py) turned about, and so are the signs of sliding;
    that of a joint is its coordinate.
    """
    network = assembly.network
    k, c = int(members[0]), int(verdict.contacts[members[0]])
    before, is_planar = verdict.before, assembly.dim == 2
    sign = -1 if network.sprung[c] == 0 else 1
    P = assembly.contacts.P[verdict.contacts[members]]
    own = assembly.contacts.P[c]
    row[EVENT_T], row[EVENT_KIND], row[EVENT_CONTACT] = t, verdict.kind, c
    row[EVENT_MODE_0], row[EVENT_SLIP_0] = before.mode[k], sign * before.slip[k]
    row[EVENT_MODE_1], row[EVENT_SLIP_1] = ContactMode.OPEN, 0
    if own[0] > 0.0:
        is_limit = np.linalg.norm(own[1:]) >= network.mu[c] * own[0] * ON_THE_CONE
        slides = is_limit and np.linalg.norm(network.gamma[c, 1:]) > still_speed(assembly, verdict.contacts)
        row[EVENT_MODE_1] = ContactMode.SLIDE if slides else ContactMode.STICK
        row[EVENT_SLIP_1] = -sign * np.sign(own[1]) if slides and is_planar else 0
    row[EVENT_P_N], row[EVENT_GAMMA_N] = P[:, 0].sum(), before.gamma[k, 0]
    if is_planar:
        row[EVENT_P_F], row[EVENT_GAMMA_F] = sign * P[:, 1].sum() + 0.0, sign * before.gamma[k, 1] + 0.0  # no -0.0
    else:
        row[EVENT_P_F] = np.linalg.norm(P[:, 1:].sum(axis=0))
        row[EVENT_GAMMA_F] = np.linalg.norm(before.gamma[k, 1:])
    row[EVENT_SOLUTIONS], row[EVENT_FOUND] = (
        verdict.n_solutions,
        turned_bits(verdict.found) if is_planar else verdict.found,
    )
    row[EVENT_I], row[EVENT_J] = network.i[c], network.j[c]


def turned_bits(found: int) -> int:
    """Candidates as bits, the two directions of sliding exchanged."""
    plus, minus = found >> SLIDE_PLUS & 1, found >> (SLIDE_PLUS + 1) & 1
    return found & (1 << SLIDE_PLUS) - 1 | minus << SLIDE_PLUS | plus << (SLIDE_PLUS + 1)
