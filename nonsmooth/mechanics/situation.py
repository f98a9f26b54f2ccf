"""What a contact is doing at a state, from its gap and its two velocities, each against what counts as zero of it.

    open        g_N > near,  or gamma_N > slow         (a unilateral contact; others are always closed)
    landing     g_N <= near, gamma_N < -slow           an impact comes first
    resting     closed, gamma_N = 0, |gamma_F| <= still
    sliding     closed, gamma_N = 0, |gamma_F| > still

Everyone who asks has the answer from here. What counts as zero is an argument. A state that somebody typed, or that is
classified, is zero to STATE_ACCURACY of its own scales: ``tolerances_of_state``. In a run that locates events it is
what rounding and tolerances leave, and the run knows which gaps it holds closed: it hands in 0 for them.

A gap below zero, and a bilateral contact that is off, contradict a state that is judged. A run that goes on from there
takes them as zero: ``goes_on``.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from nonsmooth.jit import kernel
from nonsmooth.mechanics.system import BILATERAL, UNILATERAL, ContactMode
from nonsmooth.numerics.rounding import NOTHING

# chosen: a gap or a velocity is zero within this part of the state's own scale: about the square root of the rounding
# unit, so that states typed with eight digits count as consistent
STATE_ACCURACY = 1e-7


class Situation(IntEnum):
    """What a contact is doing at a state."""

    OPEN = 0  # g_N > 0, or parting
    RESTING = 1  # closed, gamma_N = 0 and gamma_F = 0
    SLIDING = 2  # closed, gamma_N = 0
    LANDING = 3  # closed and gamma_N < 0: an impact comes first
    PENETRATING = 4  # g_N < 0
    VIOLATED = 5  # bilateral with g_N != 0
    MOVING_APART = 6  # bilateral with gamma_N != 0


CONTRADICTIONS = {
    Situation.PENETRATING: "{name} penetrates by {depth:g} m",
    Situation.VIOLATED: "the bilateral {name} has the gap {g_N:g} m, which must be 0",
    Situation.MOVING_APART: "the bilateral {name} has the normal velocity {gamma_N:g} m/s, which must be 0",
}


@kernel
def find_situation(kind, g_N, gamma_N, gamma_F, near, slow, still, goes_on):
    """The Situation of a contact.

    ``near`` [m] counts as no gap, ``slow`` [m/s] as no normal velocity of a unilateral contact, ``still`` [m/s] as no
    velocity of sliding, nor of a bilateral contact. ``goes_on``: whether what contradicts the state is taken as zero.
    """
    if kind == BILATERAL and not goes_on:
        if abs(g_N) > near:
            return Situation.VIOLATED.value
        if abs(gamma_N) > still:
            return Situation.MOVING_APART.value
    elif kind == UNILATERAL:
        if g_N < -near and not goes_on:
            return Situation.PENETRATING.value
        if g_N > near or gamma_N > slow:
            return Situation.OPEN.value
        if gamma_N < -slow:
            return Situation.LANDING.value
    return Situation.RESTING.value if is_still(gamma_F, still) else Situation.SLIDING.value


@kernel
def is_still(gamma_F, still):
    """Whether a closed contact does not slide; of one that lands, whether it would not."""
    return abs(gamma_F) <= still


@kernel
def tolerances_of_state(length, speed, surface):
    """(near, slow, still) of a state with this largest coordinate, velocity and velocity of sliding."""
    near, slow, still = STATE_ACCURACY * length, STATE_ACCURACY * speed, STATE_ACCURACY * max(speed, surface)
    return near + NOTHING, slow + NOTHING, still + NOTHING


@kernel
def mode_of_situation(situation, d):
    """The ContactMode of a contact with d directions of friction."""
    if situation != Situation.RESTING and situation != Situation.SLIDING:
        return ContactMode.OPEN.value
    if d == 0:
        return ContactMode.LOCKED.value
    return ContactMode.STICK.value if situation == Situation.RESTING else ContactMode.SLIDE.value


def largest_closed_gap(q: np.ndarray) -> float:
    """``near`` of a state with these coordinates [m]."""
    return STATE_ACCURACY * float(np.abs(q).max(initial=0.0)) + NOTHING
