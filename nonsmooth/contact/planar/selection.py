"""The candidates of a planar contact, and which of several solutions is taken: one rule, asked contact by contact.

Each contact of a solution has a rank, by what it does and what the rule asks; the solution with the largest sum is
taken, of equal ones the first. One contact solved by itself (``single.choose``), those of an enumeration
(``enumerate.select``) and those of an instant ask this rule and no other. From the best:

    ASKED    sticks, and that is asked for: by "impact" always, by the others of a contact that stuck before
    PARTS    is free
    HELD     sticks by the rule "lift-off", where it stuck and only a static coefficient above the kinetic one lets it
             stick and slide alike: hysteresis, no paradox
    SLIDES   slides with D > 0
    STICKS   sticks unasked
    SADDLE   slides with D < 0: a saddle of the compliant contact, taken only where there is nothing else

D = G_NN - s mu sigma G_NF. What is asked counts more than what all others do, a saddle more than what the others do
unasked; between solutions in which as many contacts part or slide, one that parts or holds more decides.

A new rule is a member of ``Selection``, what it asks in ``rank``, and its name in ``SELECTIONS`` (runs/simulate.py).
Source: docs/theory/selection.md.
"""

from __future__ import annotations

from enum import IntEnum

from nonsmooth.jit import kernel

# Candidates, and the bits of the set of admissible ones.
FREE, STICK, SLIDE_PLUS, SLIDE_MINUS, PULL_PLUS, PULL_MINUS = range(6)  # PULL: sliding with P_N < 0
NO_CANDIDATE = -1  # code: of none of these
# chosen: what is asked outweighs eight contacts, the most that are tried, and a saddle most of them
ASKED, PARTS, HELD, SLIDES, STICKS, SADDLE = 100_000, 102, 101, 100, 0, -3_000
WORST_RANK = -1_000_000  # derived: below every sum of ranks


class Selection(IntEnum):
    """Which solution is taken when a contact problem has several.

    COMPLIANT_LIMIT: a contact that stuck sticks; otherwise it lifts off, or slides where D > 0. This is what the limit
    of a stiff contact does. LIFT_OFF: free if admissible, else sliding where D > 0. IMPACT: stick if admissible.
    """

    COMPLIANT_LIMIT = 0
    LIFT_OFF = 1
    IMPACT = 2


@kernel
def rank(candidate, is_saddle, was_stuck, is_regular, selection):
    """How well a mode of a contact does what the rule asks; ``is_regular`` says that D > 0 for either slide."""
    if candidate == FREE:
        return PARTS
    if candidate != STICK:
        return SADDLE if is_saddle else SLIDES
    if selection == Selection.IMPACT or (was_stuck and selection == Selection.COMPLIANT_LIMIT):
        return ASKED
    return HELD if was_stuck and is_regular else STICKS


@kernel
def slip_of(candidate):
    """Sign of sliding of a candidate."""
    if candidate == SLIDE_PLUS or candidate == PULL_PLUS:
        return 1
    if candidate == SLIDE_MINUS or candidate == PULL_MINUS:
        return -1
    return 0


@kernel
def sigma_of(candidate):
    """Sign of P_N of a sliding candidate."""
    return -1 if candidate >= PULL_PLUS else 1
